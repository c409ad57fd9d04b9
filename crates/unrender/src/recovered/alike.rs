//! Groups whose numbers agree within their standard deviations: they may be one material.
//!
//! For two groups of one hypothesis with n numbers each, the sum of their squared differences, each
//! over its variance, has the mean n and the variance 2 n if the groups are alike. Parameters that
//! the photograph does not determine agree with everything, so pairs with such parameters are not
//! named.

use std::collections::BTreeMap;
use unrender_recover::{GroupResult, Status};
use unrender_scene::{Hypothesis, Rgb};

/// Groups agree if the sum is at most this many standard deviations above its mean. At half of it a
/// fifth of the pairs of equal groups is missed; at double pairs are named that differ visibly.
const DEVIATIONS: f64 = 2.0;
/// A reflectance with a larger standard deviation is not compared: 0.03 is the difference of two
/// whites of wall paint. At half of it small groups are never named, at double all dark groups are
/// alike.
const RHO_OPEN: f64 = 0.03;
/// The same for the logarithm of a roughness: 0.2 is a highlight that is a fifth wider, which is
/// visible.
const LN_ALPHA_OPEN: f64 = 0.2;

/// For each of `groups` by its name: the names of those that agree with it.
pub(super) fn find<'g>(groups: &[&'g GroupResult]) -> BTreeMap<&'g str, Vec<&'g str>> {
    let mut alike: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for (index, a) in groups.iter().enumerate() {
        for b in groups[index + 1..].iter().filter(|b| agree(a, b)) {
            alike.entry(&a.name).or_default().push(&b.name);
            alike.entry(&b.name).or_default().push(&a.name);
        }
    }
    alike
}

fn agree(a: &GroupResult, b: &GroupResult) -> bool {
    let recovered = |group: &GroupResult| group.status == Status::Recovered;
    if !(recovered(a) && recovered(b) && a.hypothesis == b.hypothesis) {
        return false;
    }
    let Some(numbers) = numbers(a).zip(numbers(b)) else { return false };
    let mut sum = 0.0;
    for ((x, std_x, open), (y, std_y, _)) in numbers.0.iter().zip(&numbers.1) {
        let variance = std_x * std_x + std_y * std_y;
        if !(variance > 0.0 && variance < open * open) {
            return false;
        }
        sum += (x - y).powi(2) / variance;
    }
    let count = numbers.0.len() as f64;
    sum <= count + DEVIATIONS * (2.0 * count).sqrt()
}

/// A parameter, its standard deviation, and the limit of that above which it is not compared.
type Number = (f64, f64, f64);

/// The parameters of a group by its hypothesis, without the direction, which is relative to the
/// tangent of each surface; none if one has no standard deviation, or none is free.
fn numbers(group: &GroupResult) -> Option<Vec<Number>> {
    let (material, std) = (&group.material, group.std?);
    let rgb = |value: Rgb, std: Option<Rgb>| {
        let std = std?.to_array();
        Some(value.to_array().into_iter().zip(std).map(|(v, s)| (v.into(), s.into(), RHO_OPEN)))
    };
    let alpha = |value: f32, std: Option<f32>| {
        Some((f64::from(value.max(f32::MIN_POSITIVE).ln()), f64::from(std?), LN_ALPHA_OPEN))
    };
    let mut numbers: Vec<Number> = Vec::new();
    use Hypothesis::{Anisotropic, Diffuse, DiffuseSpecular, Isotropic, PartialMirror};
    if matches!(group.hypothesis, Diffuse | DiffuseSpecular | Isotropic | Anisotropic) {
        numbers.extend(rgb(material.rho_d, std.rho_d)?);
    }
    if matches!(group.hypothesis, PartialMirror | DiffuseSpecular | Isotropic | Anisotropic) {
        numbers.extend(rgb(material.rho_s, std.rho_s)?);
    }
    if matches!(group.hypothesis, Isotropic | Anisotropic) {
        numbers.push(alpha(material.alpha_x, std.ln_alpha_x)?);
    }
    if group.hypothesis == Anisotropic {
        numbers.push(alpha(material.alpha_y, std.ln_alpha_y)?);
    }
    (!numbers.is_empty()).then_some(numbers)
}

#[cfg(test)]
mod tests {
    use super::*;
    use unrender_recover::Deviations;
    use unrender_scene::Material;

    fn group(name: &str, rho_d: f32, std: f32) -> GroupResult {
        GroupResult {
            name: name.into(),
            status: Status::Recovered,
            hypothesis: Hypothesis::Diffuse,
            material: Material::diffuse(Rgb::splat(rho_d)),
            alternatives: Vec::new(),
            std: Some(Deviations { rho_d: Some(Rgb::splat(std)), ..Deviations::default() }),
            direction: None,
            seen_texels: None,
            pixels: 100,
            valid_pixels: 100,
            error: None,
            error_share: None,
            selection_log: Vec::new(),
            decisions: Vec::new(),
            note: None,
        }
    }

    #[test]
    fn groups_within_their_deviations_are_named() {
        let results = [
            group("a", 0.500, 0.002),
            group("b", 0.503, 0.002),
            group("c", 0.520, 0.002),
            group("open", 0.510, 0.1),
            GroupResult { std: None, ..group("given", 0.5, 0.0) },
            GroupResult { status: Status::Doubtful, ..group("doubtful", 0.5, 0.002) },
        ];
        let found = find(&results.iter().collect::<Vec<_>>());
        assert_eq!(found.keys().collect::<Vec<_>>(), [&"a", &"b"]);
        assert_eq!((&found["a"], &found["b"]), (&vec!["b"], &vec!["a"]));
    }

    #[test]
    fn lobes_must_agree_too() {
        let lobe = |name: &str, alpha: f32| {
            let mut group = group(name, 0.3, 0.002);
            group.hypothesis = Hypothesis::Isotropic;
            group.material.rho_s = Rgb::splat(0.1);
            (group.material.alpha_x, group.material.alpha_y) = (alpha, alpha);
            let std = group.std.as_mut().unwrap();
            (std.rho_s, std.ln_alpha_x) = (Some(Rgb::splat(0.004)), Some(0.02));
            group
        };
        let results = [lobe("a", 0.10), lobe("b", 0.101), lobe("c", 0.13), group("d", 0.3, 0.002)];
        let found = find(&results.iter().collect::<Vec<_>>());
        assert_eq!(found.keys().collect::<Vec<_>>(), [&"a", &"b"]);
    }
}
