//! What the photograph determines, and what it does not.
//!
//! A number is worth what its standard deviation allows. A mirror's diffuse part is removed, or its reflectance made
//! one, if the photograph speaks for that or the change is below the threshold of the ladder. A lobe is removed, or a brushed
//! one made round, if what that changes is certainly negligible, and one that is as sharp as any that is searched is a mirror.
//! What is only uncertain stays, since a single highlight leaves a lobe's strength uncertain and its presence certain, which
//! the ladder compares. A group out of sight whose reflectance stays open is assumed: at its best guess, or white, as the
//! paper does, where there is nothing to guess from.

use super::relations::Relation;
use super::{Solution, parameters};
use crate::compare::{CERTAIN, Measured, WORSE};
use crate::expected::Like;
use crate::guess::Guess;
use crate::hypothesis::{Hypothesis, anisotropic};
use crate::problem::Options;
use crate::progress::Progress;
use crate::record::{Covariance, Deviations, LightResult, Rule, Status};
use crate::unknown::{Quantity, Unknown};
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeSet;
use std::f64::consts::TAU;
use unrender_scene::reflectance::ALPHA_RANGE;
use unrender_scene::{Material, Rgb};

/// A group out of sight is recovered if all its standard deviations are below this; else it is assumed. At half of it what
/// the light says of a large wall behind the camera counts as a guess, at double a guess as known.
const UNSEEN_MAX: f64 = 0.1;
/// A brushed lobe is round if its roughnesses certainly differ by no more than this share of them. At half a wall of 15 000
/// pixels (0.3 % +- 0.3 %) would still be made round; double was not tried.
const ROUND: f64 = 0.05;
/// From this correlation on, two numbers of one group are named as tied.
const TIED: f64 = 0.95;
/// The most lights that are named as tied; they fit on a line. At half a room with three lamps loses one, double was not
/// tried.
const TOLD: usize = 4;
/// The standard deviation of what the lobe of a dull plastic reflects, as a share of even light: 0.02 to 0.055 with
/// roughnesses from 1 to 0.3. The base is wrong by as much of what it does not reflect. At half or double, the deviations of
/// such bases are half or twice as large.
const OPEN_GLOSS: f64 = 0.01;
/// What is said of one.
const GLOSS_IS_OPEN: &str = "this photograph shows no gloss of it: its roughness is a guess";
/// A roughness with a larger relative standard deviation than this is said to be open.
const ALPHA_OPEN: f64 = 0.5;

/// Simplifies hypotheses that the photograph does not support. True if something changed.
pub(super) fn simplify(
    guess: &mut Guess<'_>,
    solution: &Solution,
    options: &Options,
    progress: &mut Progress<'_>,
) -> bool {
    let free = |group: &usize| Verdict { solution, group: *group }.is_free();
    let groups: Vec<usize> = (0..guess.materials.len()).filter(free).collect();
    let mut changed = false;
    for group in groups {
        let verdict = Verdict { solution, group };
        let simpler = verdict.simpler(guess, options.thresholds.explained);
        let Some((to, material, note)) = simpler else { continue };
        let from = guess.groups[group].hypothesis;
        if step_down(guess, group, to, material, note) {
            let measured = Measured { holds: true, ..Measured::default() };
            progress.decide(group, [from, to], measured, Rule::Simpler);
            changed = true;
        }
    }
    changed
}

/// Whether hardly any of what `material` reflects is diffuse.
fn is_mirror(material: &Material, explained: f64) -> bool {
    material.rho_d.max_element() <= explained as f32 * material.rho_s.max_element()
}

/// A share in percent, to a thousandth of one.
fn percent(share: f64) -> f64 {
    (1e5 * share).round() / 1e3
}

fn step_down(
    guess: &mut Guess<'_>,
    group: usize,
    hypothesis: Hypothesis,
    material: Material,
    note: &str,
) -> bool {
    if !guess.problem.groups[group].allows(hypothesis) {
        return false;
    }
    guess.materials[group] = guess.problem.groups[group].expected.bounds.nearest(&material);
    let of_group = &mut guess.groups[group];
    of_group.hypothesis = hypothesis;
    of_group.undecided.clear();
    of_group.add_note(format!("{note}: taken as {hypothesis}"));
    true
}

/// Records the standard deviation of each number.
pub(super) fn record(guess: &mut Guess<'_>, solution: &mut Solution) {
    solution.leave_gloss_open(guess);
    let solution = &*solution;
    let matrix = solution.covariance.row_iter().map(|row| row.iter().copied().collect()).collect();
    let mut covariance = Covariance { of: solution.unknowns.list.clone(), matrix };
    for group in 0..guess.materials.len() {
        let verdict = Verdict { solution, group };
        if !verdict.is_free() {
            continue;
        }
        // A texture's are those of its texels, known when it is extracted at the end.
        if guess.groups[group].hypothesis != Hypothesis::Textured {
            guess.groups[group].std = Some(verdict.deviations());
        }
        if guess.groups[group].hypothesis == Hypothesis::Anisotropic && canonical(guess, group) {
            covariance.of.iter_mut().filter(|u| u.of == group).for_each(swap_alphas);
        }
        if guess.observation.pixels_of_group[group].is_empty() {
            let is_determined = verdict.largest(Quantity::RhoD) <= UNSEEN_MAX;
            let why = guess.why_unseen(group);
            let of_group = &mut guess.groups[group];
            of_group.status = if is_determined { Status::Recovered } else { Status::Assumed };
            let how = if is_determined { "" } else { ", which leaves it open: a guess" };
            of_group.note.get_or_insert_with(|| {
                format!("{why}: from the light that it sends to the others{how}")
            });
        }
        if has_open_gloss(guess, group) {
            guess.groups[group].add_note(GLOSS_IS_OPEN.to_owned());
        }
        if let Some(note) = verdict.likeness(guess) {
            guess.groups[group].add_note(note);
        }
        for note in verdict.doubts().into_iter().chain(verdict.ties_to_lights(guess)) {
            guess.groups[group].add_note(note);
        }
    }
    let rgb = |quantity, of| solution.rgb(quantity, of);
    for &source in &guess.problem.unknown_lights {
        let factor = guess.appearance().light(source as u32);
        let std = rgb(Quantity::Light, source).unwrap_or(Rgb::ZERO);
        guess.light_results.push(LightResult { source, factor, std });
    }
    guess.exposure_std = rgb(Quantity::Exposure, 0).map(|std| std * guess.exposure);
    let places: Vec<usize> = (0..guess.problem.photometric_parameters.len())
        .filter_map(|of| solution.index(Quantity::Camera, of, None))
        .collect();
    let row = |i: &usize| places.iter().map(|j| solution.covariance[(*i, *j)]).collect();
    guess.photometric.covariance = places.iter().map(row).collect();
    guess.covariance = Some(covariance);
}

/// Whether `group` is a plastic of which the photograph does not tell the roughness.
fn has_open_gloss(guess: &Guess<'_>, group: usize) -> bool {
    guess.groups[group].hypothesis == Hypothesis::Diffuse && guess.materials[group].is_glossy()
}

/// Swaps the names of the two roughnesses of a group.
fn swap_alphas(unknown: &mut Unknown) {
    unknown.quantity = match unknown.quantity {
        Quantity::AlphaX => Quantity::AlphaY,
        Quantity::AlphaY => Quantity::AlphaX,
        other => other,
    };
}

/// Puts the smoother direction first, and the angle within half a turn; returns whether the two
/// directions were swapped.
fn canonical(guess: &mut Guess<'_>, group: usize) -> bool {
    let material = &mut guess.materials[group];
    let swapped = material.alpha_x > material.alpha_y;
    let shape = [material.alpha_x, material.alpha_y, material.theta_rad];
    [material.alpha_x, material.alpha_y, material.theta_rad] = anisotropic::canonical(shape);
    if let Some(std) = guess.groups[group].std.as_mut().filter(|_| swapped) {
        std::mem::swap(&mut std.ln_alpha_x, &mut std.ln_alpha_y);
    }
    swapped
}

impl Solution {
    /// Adds what is open of the lobes of dull plastics to the variances of their bases.
    fn leave_gloss_open(&mut self, guess: &Guess<'_>) {
        let unknowns = &self.unknowns;
        let open = |u: &Unknown| {
            let is_open = u.quantity == Quantity::RhoD && has_open_gloss(guess, u.of);
            if is_open { OPEN_GLOSS * (1.0 - unknowns.value(guess, u)) } else { 0.0 }
        };
        let open: Vec<f64> = unknowns.list.iter().map(open).collect();
        for (i, j) in (0..open.len()).flat_map(|i| (0..open.len()).map(move |j| (i, j))) {
            if unknowns.list[i].of == unknowns.list[j].of {
                self.covariance[(i, j)] += open[i] * open[j];
            }
        }
    }

    /// The index of an unknown.
    fn index(&self, quantity: Quantity, of: usize, channel: Option<usize>) -> Option<usize> {
        let wanted = Unknown { quantity, of, channel };
        self.unknowns.list.iter().position(|u| *u == wanted)
    }

    /// The standard deviations of a quantity with three channels.
    fn rgb(&self, quantity: Quantity, of: usize) -> Option<Rgb> {
        let index =
            |c: usize| self.index(quantity, of, Some(c)).or_else(|| self.index(quantity, of, None));
        let std = |c: usize| index(c).map(|i| self.deviation(i) as f32);
        Some(Rgb::new(std(0)?, std(1)?, std(2)?))
    }

    fn deviation(&self, i: usize) -> f64 {
        self.covariance[(i, i)].max(0.0).sqrt()
    }
}

/// Whether reflectances are likelier to differ from what was found by exactly this `change` than to be any between zero and
/// one, alike: by the Bayes factor of both, with a normal likelihood [Kass and Raftery 1995]. What is not determined speaks for
/// nothing.
fn is_likelier(change: &DVector<f64>, covariance: DMatrix<f64>) -> bool {
    let Some(factors) = covariance.cholesky() else { return false };
    let distance = change.dot(&factors.solve(change));
    let volume = 2.0 * factors.l().diagonal().map(f64::ln).sum() + change.len() as f64 * TAU.ln();
    !change.is_empty() && volume + distance < 0.0
}

/// The verdict on one group.
struct Verdict<'a> {
    solution: &'a Solution,
    group: usize,
}

impl Verdict<'_> {
    fn indices(&self) -> impl Iterator<Item = usize> + '_ {
        let list = self.solution.unknowns.list.iter().enumerate();
        list.filter(move |(_, u)| u.of == self.group && !parameters::of(u.quantity).is_nuisance())
            .map(|(i, _)| i)
    }

    /// The simpler mirror or lobe that explains the group as well, its material, and why.
    fn simpler(
        &self,
        guess: &Guess<'_>,
        explained: f64,
    ) -> Option<(Hypothesis, Material, &'static str)> {
        let material = &guess.materials[self.group];
        let hypothesis = guess.groups[self.group].hypothesis;
        if hypothesis != Hypothesis::PartialMirror && self.is_lobe_negligible(guess, explained) {
            let diffuse = guess.plain(self.group, material.rho_d);
            return Some((Hypothesis::Diffuse, diffuse, "its specular part is negligible"));
        }
        match hypothesis {
            Hypothesis::PartialMirror
                if self.is_perfect(guess, explained, &[(Quantity::RhoS, 1.0)]) =>
            {
                let note = "its reflectance does not differ from one by more than chance";
                Some((Hypothesis::Mirror, Material::mirror(Rgb::ONE), note))
            }
            Hypothesis::DiffuseSpecular => {
                let (hypothesis, material) = self.mirror(guess, explained)?;
                Some((hypothesis, material, "its diffuse part is not significant"))
            }
            Hypothesis::Isotropic
                if material.reflectance.is_free() && material.alpha_x <= ALPHA_RANGE[0] =>
            {
                let beside = Material { rho_d: material.rho_d, ..Material::mirror(material.rho_s) };
                let (hypothesis, material) =
                    self.mirror(guess, explained).unwrap_or((Hypothesis::DiffuseSpecular, beside));
                Some((hypothesis, material, "its lobe is as sharp as any that is searched"))
            }
            Hypothesis::Anisotropic if self.is_round(guess) => {
                let alpha = (material.alpha_x * material.alpha_y).sqrt();
                let round = Material { alpha_x: alpha, alpha_y: alpha, ..material.clone() };
                let note = "the difference of its two roughnesses is negligible";
                Some((Hypothesis::Isotropic, Material { theta_rad: 0.0, ..round }, note))
            }
            _ => None,
        }
    }

    /// The mirror that the group is if its diffuse part is not significant.
    fn mirror(&self, guess: &Guess<'_>, explained: f64) -> Option<(Hypothesis, Material)> {
        let material = &guess.materials[self.group];
        if !is_mirror(material, explained) && !self.speaks_for(guess, &[(Quantity::RhoD, 0.0)]) {
            return None;
        }
        Some(
            if self.is_perfect(guess, explained, &[(Quantity::RhoD, 0.0), (Quantity::RhoS, 1.0)]) {
                (Hypothesis::Mirror, Material::mirror(Rgb::ONE))
            } else {
                (Hypothesis::PartialMirror, Material::mirror(material.rho_s))
            },
        )
    }

    /// Whether the photograph speaks for a mirror that reflects all, by `which` of its numbers, or its reflectance differs
    /// from one by no more than what is always allowed for.
    fn is_perfect(&self, guess: &Guess<'_>, explained: f64, which: &[(Quantity, f64)]) -> bool {
        let rho_s = guess.materials[self.group].rho_s;
        let is_near = (Rgb::ONE - rho_s).cmple(Rgb::splat(explained as f32)).all();
        is_near || self.speaks_for(guess, which)
    }

    /// Whether the photograph speaks for these values of quantities of the group. Numbers that are tied together are judged
    /// together.
    fn speaks_for(&self, guess: &Guess<'_>, which: &[(Quantity, f64)]) -> bool {
        let unknowns = &self.solution.unknowns;
        let wanted = |i: usize| {
            let own = unknowns.list[i];
            let (_, wanted) = which.iter().find(|(quantity, _)| *quantity == own.quantity)?;
            Some((i, wanted - unknowns.value(guess, &own)))
        };
        let (indices, change): (Vec<usize>, Vec<f64>) = self.indices().filter_map(wanted).unzip();
        let covariance = self.solution.covariance.select_rows(&indices).select_columns(&indices);
        is_likelier(&DVector::from_vec(change), covariance)
    }

    fn is_free(&self) -> bool {
        self.indices().next().is_some()
    }

    /// The largest standard deviation of a quantity over the channels.
    fn largest(&self, quantity: Quantity) -> f64 {
        let std = self.solution.rgb(quantity, self.group).unwrap_or(Rgb::ZERO);
        f64::from(std.max_element())
    }

    /// Whether the specular part reflects certainly no more than `explained`. A plastic's is what Fresnel's equations say.
    fn is_lobe_negligible(&self, guess: &Guess<'_>, explained: f64) -> bool {
        let list = &self.solution.unknowns.list;
        let mut strength =
            self.indices().filter(|i| list[*i].quantity == Quantity::RhoS).peekable();
        let most = |i: usize| {
            self.solution.unknowns.value(guess, &list[i]) + CERTAIN * self.solution.deviation(i)
        };
        strength.peek().is_some() && strength.all(|i| most(i) <= explained)
    }

    /// Whether the two roughnesses differ certainly by no more than [`ROUND`].
    fn is_round(&self, guess: &Guess<'_>) -> bool {
        let place = |quantity| self.solution.index(quantity, self.group, None);
        let (Some(x), Some(y)) = (place(Quantity::AlphaX), place(Quantity::AlphaY)) else {
            return false;
        };
        let c = &self.solution.covariance;
        let variance = c[(x, x)] + c[(y, y)] - 2.0 * c[(x, y)];
        let material = &guess.materials[self.group];
        let difference = f64::from((material.alpha_x / material.alpha_y).ln());
        difference.abs() + CERTAIN * variance.max(0.0).sqrt() <= ROUND
    }

    fn deviations(&self) -> Deviations {
        let one = |quantity| {
            let index = self.solution.index(quantity, self.group, None);
            index.map(|i| self.solution.deviation(i) as f32)
        };
        let round = one(Quantity::Alpha);
        Deviations {
            rho_d: self.solution.rgb(Quantity::RhoD, self.group),
            rho_s: self.solution.rgb(Quantity::RhoS, self.group),
            ln_alpha_x: round.or(one(Quantity::AlphaX)),
            ln_alpha_y: round.or(one(Quantity::AlphaY)),
            theta_rad: one(Quantity::Theta),
        }
    }

    /// How the group compares with the one that it is like, if any.
    fn likeness(&self, guess: &Guess<'_>) -> Option<String> {
        let Like { group, within } = guess.problem.groups[self.group].expected.like?;
        let name = &guess.problem.groups[group].name;
        let unknowns = &self.solution.unknowns;
        let values = unknowns.values(guess);
        let of_group = |relation: &&Relation| {
            let unknown = &unknowns.list[relation.unknown];
            unknown.of == self.group && !parameters::of(unknown.quantity).is_nuisance()
        };
        let apart = |relation: &Relation| {
            (relation.difference(|index| values[index]) / relation.deviation).abs()
        };
        let worst = unknowns.relations.iter().filter(of_group).map(apart).reduce(f64::max);
        Some(match worst {
            None => format!(
                "like \"{name}\", as the project says, changes nothing: they share no free number"
            ),
            Some(worst) if worst > WORSE => format!(
                "like \"{name}\" within {} %, as the project says, but the photograph has them \
                 {worst:.1} times as far apart",
                percent(within)
            ),
            Some(_) => format!("like \"{name}\" within {} %, as the project says", percent(within)),
        })
    }

    /// The unknown lights that would explain the group's brightness as well as its reflectance does: those whose
    /// brightness (of an environment in parts, that of all parts together) is tied to it.
    fn ties_to_lights(&self, guess: &Guess<'_>) -> Option<String> {
        let problem = guess.problem;
        let parts: BTreeSet<usize> =
            problem.neighbouring_lights.iter().flatten().copied().collect();
        let alone = problem.unknown_lights.iter().filter(|of| !parts.contains(of));
        let mut lights: Vec<(String, Vec<usize>)> = alone
            .map(|&of| {
                let lamp = problem.groups.get(of).map(|group| format!("\"{}\"", group.name));
                (lamp.unwrap_or_else(|| "a light without a surface".to_owned()), vec![of])
            })
            .collect();
        if !parts.is_empty() {
            lights.push(("the environment".to_owned(), parts.into_iter().collect()));
        }
        let tied = |(name, of): (String, Vec<usize>)| {
            let most = (0..3).filter_map(|channel| self.correlation(&of, channel));
            let most = most.fold(0.0, f64::min);
            (most < -TIED).then_some((name, most))
        };
        ties_told(lights.into_iter().filter_map(tied).collect())
    }

    /// The correlation of the group's diffuse reflectance with the summed factors of the lights `of`, in one
    /// channel.
    fn correlation(&self, of: &[usize], channel: usize) -> Option<f64> {
        let place = |quantity, of| {
            let of_channel = self.solution.index(quantity, of, Some(channel));
            of_channel.or_else(|| self.solution.index(quantity, of, None))
        };
        let own = place(Quantity::RhoD, self.group)?;
        let lights: Vec<usize> = of.iter().filter_map(|of| place(Quantity::Light, *of)).collect();
        let c = &self.solution.covariance;
        let both: f64 = lights.iter().map(|i| c[(own, *i)]).sum();
        let square: f64 = lights.iter().flat_map(|i| lights.iter().map(|j| c[(*i, *j)])).sum();
        let correlation = both / (c[(own, own)] * square).sqrt();
        correlation.is_finite().then_some(correlation)
    }

    /// What the user should know about the group's numbers.
    fn doubts(&self) -> Vec<String> {
        let list = &self.solution.unknowns.list;
        let name = |i: usize| parameters::of(list[i].quantity).name();
        let mut doubts: Vec<String> = Vec::new();
        let indices: Vec<usize> = self.indices().collect();
        for (k, &i) in indices.iter().enumerate() {
            let alpha =
                matches!(list[i].quantity, Quantity::Alpha | Quantity::AlphaX | Quantity::AlphaY);
            if alpha && self.solution.deviation(i) > ALPHA_OPEN {
                doubts.push(format!("{} is hardly determined", name(i)));
            }
            for &j in indices[..k].iter().filter(|j| list[**j].quantity != list[i].quantity) {
                let c = &self.solution.covariance;
                let correlation = c[(i, j)] / (c[(i, i)] * c[(j, j)]).sqrt();
                let pair = [name(j), name(i)].join(" and ");
                if correlation.abs() > TIED && !doubts.iter().any(|d| d.starts_with(&pair)) {
                    doubts.push(format!(
                        "{pair} are tied together (correlation {correlation:.3}): their \
                         combination is known better than either"
                    ));
                }
            }
        }
        doubts
    }
}

/// What to say of the lights that a group's reflectance is tied to, each with its correlation: the closest by name,
/// and how many others there are.
fn ties_told(mut lights: Vec<(String, f64)>) -> Option<String> {
    lights.sort_by(|a, b| a.1.total_cmp(&b.1));
    let named: Vec<&str> = lights.iter().take(TOLD).map(|(name, _)| name.as_str()).collect();
    let rest = lights.len() - named.len();
    let names = match rest {
        0 => named.join(", "),
        rest => format!("{} and {rest} more", named.join(", ")),
    };
    let (_, closest) = lights.first()?;
    let correlation = match lights[..] {
        [_] => format!("correlation {closest:.3}"),
        _ => format!("correlations from {closest:.3} on"),
    };
    Some(format!(
        "rho_d and the brightness of {names} are tied together ({correlation}): more of one and less of the other \
         explain the photograph as well"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_known_well_speaks_for_one_value() {
        let alone = |off: f64, std: f64| {
            is_likelier(
                &DVector::from_element(3, off),
                DMatrix::from_diagonal_element(3, 3, std * std),
            )
        };
        assert!(alone(0.01, 0.02) && alone(0.0, 0.3));
        assert!(!alone(0.06, 0.02), "three standard deviations away");
        assert!(!alone(0.0, 0.5) && !alone(0.96, 0.6), "not determined");
        // Each of two numbers is hardly known, their sum is.
        let tied = |off: [f64; 2]| {
            let own = 0.3f64.powi(2);
            let covariance = DMatrix::from_row_slice(2, 2, &[own, -0.999 * own, -0.999 * own, own]);
            is_likelier(&DVector::from_row_slice(&off), covariance)
        };
        assert!(tied([-0.2, 0.2]) && !tied([-0.2, 0.6]));
        assert!(!is_likelier(&DVector::zeros(0), DMatrix::zeros(0, 0)));
    }

    #[test]
    fn of_many_lights_that_are_tied_a_few_are_named() {
        assert_eq!(ties_told(Vec::new()), None);
        let one = ties_told(vec![("the environment".into(), -0.98)]).unwrap();
        assert!(one.contains("of the environment are tied together (correlation -0.980)"), "{one}");
        let lights = (0..320).map(|k| (format!("\"l{k}\""), -0.96 - 1e-4 * f64::from(k))).collect();
        let many = ties_told(lights).unwrap();
        assert!(many.contains("\"l319\", \"l318\", \"l317\", \"l316\" and 316 more"), "{many}");
        assert!(many.contains("(correlations from -0.992 on)"), "{many}");
    }
}
