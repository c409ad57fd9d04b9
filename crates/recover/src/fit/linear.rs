//! The reflectances of one group by weighted linear least squares, per channel.
//!
//! With a roughness given, radiance is linear: `L = rho_d D + rho_s S`. From two renderings with
//! independent noise, the objective is the product of the residuals,
//! `sum W (B - L_A)(B - L_B) = sum W B^2 - 2 b.x + x.A x`, with `x = (rho_d, rho_s)`,
//! `A = sym(J_A^T W J_B)` and `b = (J_A + J_B)^T W B / 2`. It is minimised over the box
//! `0 <= rho <= 1`, or a smaller one that the user states. The paper's own 2x2 system (section 4.2.3) is the same without the weights, the
//! second rendering and the box.
//!
//! Pixels that are only known to be at least so bright count where the model is darker: a convex
//! problem, whose set of counting pixels is found by iteration.

use crate::evidence::Evidence;
use crate::expected::ParameterBounds;
use crate::observe::observation::Reading;
use std::collections::BTreeMap;
use unrender_scene::Rgb;

/// Which reflectances are known; those that are not are found, by default both.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Terms {
    /// That of `rho_d`, in all channels.
    pub rho_d: Option<f64>,
    /// That of `rho_s`, in all channels.
    pub rho_s: Option<f64>,
}

impl Terms {
    /// `rho_d` is free beside this `rho_s`.
    pub fn beside(rho_s: f64) -> Self {
        Self { rho_d: None, rho_s: Some(rho_s) }
    }
}

/// The reflectances that fit best and what they leave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearFit {
    /// Diffuse reflectance.
    pub rho_d: Rgb,
    /// Specular reflectance.
    pub rho_s: Rgb,
    /// The least weighted objective, all channels.
    pub objective: f64,
}

/// One channel's sums: all that the objective needs to know of the pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct NormalSums {
    b: f64,
    d: f64,
    s: f64,
    bb: f64,
    bd: f64,
    bs: f64,
    dd: f64,
    ds: f64,
    ss: f64,
}

impl NormalSums {
    /// Adds a pixel of weight `w` and radiance `b`, with both renderings of its bases.
    fn add(&mut self, w: f64, b: f64, [d0, d1]: [f64; 2], [s0, s1]: [f64; 2]) {
        self.b += w * b;
        self.d += 0.5 * w * (d0 + d1);
        self.s += 0.5 * w * (s0 + s1);
        self.bb += w * b * b;
        self.bd += 0.5 * w * b * (d0 + d1);
        self.bs += 0.5 * w * b * (s0 + s1);
        self.dd += w * d0 * d1;
        self.ds += 0.5 * w * (d0 * s1 + d1 * s0);
        self.ss += w * s0 * s1;
    }

    fn and(mut self, other: &Self) -> Self {
        self.b += other.b;
        self.d += other.d;
        self.s += other.s;
        self.bb += other.bb;
        self.bd += other.bd;
        self.bs += other.bs;
        self.dd += other.dd;
        self.ds += other.ds;
        self.ss += other.ss;
        self
    }

    /// Whether the model is on the mean at least as bright as the photograph.
    fn is_met(&self, (d, s): (f64, f64)) -> bool {
        d * self.d + s * self.s >= self.b
    }

    fn objective(&self, d: f64, s: f64) -> f64 {
        self.bb - 2.0 * (d * self.bd + s * self.bs)
            + d * d * self.dd
            + 2.0 * d * s * self.ds
            + s * s * self.ss
    }

    /// The best diffuse reflectance beside the specular reflectance `s`.
    fn best_d(&self, s: f64, limits: &Limits) -> f64 {
        clamp_ratio(self.bd - s * self.ds, self.dd, limits.d)
    }

    /// The best specular reflectance beside the diffuse reflectance `d`.
    fn best_s(&self, d: f64, limits: &Limits) -> f64 {
        clamp_ratio(self.bs - d * self.ds, self.ss, limits.s)
    }

    /// The best pair in the box: inside if the minimum lies there, else on an edge.
    fn best_pair(&self, limits: &Limits) -> (f64, f64) {
        let Limits { d: [d_low, d_high], s: [s_low, s_high] } = *limits;
        let determinant = self.dd * self.ss - self.ds * self.ds;
        if self.dd > 0.0 && determinant > 1e-9 * self.dd * self.ss {
            let d = (self.bd * self.ss - self.bs * self.ds) / determinant;
            let s = (self.bs * self.dd - self.bd * self.ds) / determinant;
            if (d_low..=d_high).contains(&d) && (s_low..=s_high).contains(&s) {
                return (d, s);
            }
        }
        let edges = [
            (self.best_d(s_low, limits), s_low),
            (self.best_d(s_high, limits), s_high),
            (d_low, self.best_s(d_low, limits)),
            (d_high, self.best_s(d_high, limits)),
        ];
        let cost = |(d, s): &(f64, f64)| self.objective(*d, *s);
        edges.into_iter().min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap_or_default()
    }
}

fn clamp_ratio(numerator: f64, denominator: f64, [low, high]: [f64; 2]) -> f64 {
    if denominator > 0.0 { (numerator / denominator).clamp(low, high) } else { low }
}

/// The box of one channel.
struct Limits {
    d: [f64; 2],
    s: [f64; 2],
}

impl Limits {
    fn of(bounds: &ParameterBounds, channel: usize) -> Self {
        let interval = |[low, high]: [Rgb; 2]| {
            let low = f64::from(low[channel]);
            [low, f64::from(high[channel]).max(low)]
        };
        Self { d: interval(bounds.rho_d), s: interval(bounds.rho_s) }
    }
}

/// Rounds in which the set of counting lower bounds is looked for; it settles within three or four.
const BOUND_ROUNDS: usize = 8;
/// Halvings of the interval in which a common reflectance is looked for: beyond single precision. With half of them it is
/// known to 10^-6, more change nothing.
const HALVINGS: usize = 40;

/// Fits the reflectances of a group to its evidence, with `diffuse` and `specular` (for
/// `rho_s = 1`) the two bases, each rendered twice.
pub fn fit(
    evidence: &Evidence,
    diffuse: &[Vec<Rgb>; 2],
    specular: Option<&[Vec<Rgb>; 2]>,
    terms: Terms,
) -> LinearFit {
    LinearFit::of(&channels(evidence, diffuse, specular), terms)
}

/// The same with one `rho_s` for all channels; none where the bounds exclude that.
pub fn colourless(
    evidence: &Evidence,
    diffuse: &[Vec<Rgb>; 2],
    specular: &[Vec<Rgb>; 2],
    terms: Terms,
) -> Option<LinearFit> {
    let channels = channels(evidence, diffuse, Some(specular));
    let with = |rho_s: f64| Terms { rho_s: Some(rho_s), ..terms };
    let low = channels.iter().map(|channel| channel.limits.s[0]).fold(f64::NEG_INFINITY, f64::max);
    let high = channels.iter().map(|channel| channel.limits.s[1]).fold(f64::INFINITY, f64::min);
    let (mut below, mut above) = (low, high);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (below + above);
        // The objective is convex in `rho_s`, with the best `rho_d` of each channel beside it.
        let rises = channels.iter().map(|channel| channel.slope(with(middle))).sum::<f64>() > 0.0;
        *(if rises { &mut above } else { &mut below }) = middle;
    }
    (low <= high).then(|| LinearFit::of(&channels, with(0.5 * (below + above))))
}

impl LinearFit {
    /// The best reflectances of the `channels`.
    fn of(channels: &[Channel; 3], terms: Terms) -> Self {
        let mut result = Self { rho_d: Rgb::ZERO, rho_s: Rgb::ZERO, objective: 0.0 };
        for (c, channel) in channels.iter().enumerate() {
            let (sums, (d, s)) = channel.best(terms);
            (result.rho_d[c], result.rho_s[c]) = (d as f32, s as f32);
            result.objective += sums.objective(d, s);
        }
        result
    }
}

/// What one channel shows.
struct Channel {
    /// The sums over the pixels that were measured.
    values: NormalSums,
    /// Those over the lower bounds of every block.
    bounds: Vec<NormalSums>,
    limits: Limits,
}

impl Channel {
    /// The best pair, and the sums over the pixels that count under it.
    fn best(&self, terms: Terms) -> (NormalSums, (f64, f64)) {
        let mut counts = vec![true; self.bounds.len()];
        let (mut sums, mut best) = (self.values, (0.0, 0.0));
        for _ in 0..BOUND_ROUNDS {
            let counting = self.bounds.iter().zip(&counts).filter(|(_, counts)| **counts);
            sums = counting.fold(self.values, |sums, (bound, _)| sums.and(bound));
            best = match (terms.rho_d, terms.rho_s) {
                (None, None) => sums.best_pair(&self.limits),
                (None, Some(s)) => (sums.best_d(s, &self.limits), s),
                (Some(d), None) => (d, sums.best_s(d, &self.limits)),
                (Some(d), Some(s)) => (d, s),
            };
            let next: Vec<bool> = self.bounds.iter().map(|bound| !bound.is_met(best)).collect();
            if next == counts {
                break;
            }
            counts = next;
        }
        (sums, best)
    }

    /// Half of the derivative of the least objective by `rho_s`, which `terms` fix.
    fn slope(&self, terms: Terms) -> f64 {
        let (sums, (d, s)) = self.best(terms);
        d * sums.ds + s * sums.ss - sums.bs
    }
}

/// What each channel shows.
fn channels(
    evidence: &Evidence,
    diffuse: &[Vec<Rgb>; 2],
    specular: Option<&[Vec<Rgb>; 2]>,
) -> [Channel; 3] {
    [0, 1, 2].map(|channel| {
        let (values, bounds) = sums(evidence, diffuse, specular, channel);
        Channel { values, bounds, limits: Limits::of(&evidence.expected.bounds, channel) }
    })
}

/// The sums over the pixels that were measured, and those over the lower bounds of every block.
fn sums(
    evidence: &Evidence,
    diffuse: &[Vec<Rgb>; 2],
    specular: Option<&[Vec<Rgb>; 2]>,
    channel: usize,
) -> (NormalSums, Vec<NormalSums>) {
    let mut values = NormalSums::default();
    let mut bounds: BTreeMap<u32, NormalSums> = BTreeMap::new();
    for (i, pixel) in evidence.sample.pixels.iter().enumerate() {
        let at = |image: &Vec<Rgb>| f64::from(image[i][channel]);
        let (w, b) = (f64::from(pixel.weight[channel]), f64::from(pixel.radiance[channel]));
        let d = [at(&diffuse[0]), at(&diffuse[1])];
        let s = specular.map_or([0.0; 2], |s| [at(&s[0]), at(&s[1])]);
        match pixel.reading {
            Reading::Value => values.add(w, b, d, s),
            Reading::AtLeast => {
                bounds.entry(evidence.sample.blocks.of_pixel[i]).or_default().add(w, b, d, s);
            }
            Reading::Nothing => {}
        }
    }
    (values, bounds.into_values().collect())
}
