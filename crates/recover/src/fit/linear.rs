//! The reflectances of one group by weighted linear least squares, per channel.
//!
//! With a roughness given, radiance is linear: `L = rho_d D + rho_s S`. From two renderings with
//! independent noise, the objective is the product of the residuals,
//! `sum W (B - L_A)(B - L_B) = sum W B^2 - 2 b.x + x.A x`, with `x = (rho_d, rho_s)`,
//! `A = sym(J_A^T W J_B)` and `b = (J_A + J_B)^T W B / 2`. It is minimised over the box
//! `0 <= rho <= 1`. The paper's own 2x2 system (section 4.2.3) is the same without the weights, the
//! second rendering and the box.

use crate::evidence::Evidence;
use unrender_scene::Rgb;

/// Which reflectances are free.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Terms {
    /// `rho_d` alone.
    Diffuse,
    /// `rho_s` alone.
    Specular,
    /// Both.
    Both,
}

/// The reflectances that fit best and what they leave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearFit {
    /// Diffuse reflectance.
    pub rho_d: Rgb,
    /// Specular reflectance.
    pub rho_s: Rgb,
    /// What is left of the weighted objective, all channels.
    pub objective: f64,
}

/// One channel's sums: all that the objective needs to know of the pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Sums {
    bb: f64,
    bd: f64,
    bs: f64,
    dd: f64,
    ds: f64,
    ss: f64,
}

impl Sums {
    fn objective(&self, d: f64, s: f64) -> f64 {
        self.bb - 2.0 * (d * self.bd + s * self.bs)
            + d * d * self.dd
            + 2.0 * d * s * self.ds
            + s * s * self.ss
    }

    /// The best diffuse reflectance beside the specular reflectance `s`.
    fn best_d(&self, s: f64) -> f64 {
        clamp_ratio(self.bd - s * self.ds, self.dd)
    }

    /// The best specular reflectance beside the diffuse reflectance `d`.
    fn best_s(&self, d: f64) -> f64 {
        clamp_ratio(self.bs - d * self.ds, self.ss)
    }

    /// The best pair in the unit box: inside if the minimum lies there, else on an edge.
    fn best_pair(&self) -> (f64, f64) {
        let determinant = self.dd * self.ss - self.ds * self.ds;
        if self.dd > 0.0 && determinant > 1e-9 * self.dd * self.ss {
            let d = (self.bd * self.ss - self.bs * self.ds) / determinant;
            let s = (self.bs * self.dd - self.bd * self.ds) / determinant;
            if (0.0..=1.0).contains(&d) && (0.0..=1.0).contains(&s) {
                return (d, s);
            }
        }
        let edges = [
            (self.best_d(0.0), 0.0),
            (self.best_d(1.0), 1.0),
            (0.0, self.best_s(0.0)),
            (1.0, self.best_s(1.0)),
        ];
        let cost = |(d, s): &(f64, f64)| self.objective(*d, *s);
        edges.into_iter().min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap_or_default()
    }
}

fn clamp_ratio(numerator: f64, denominator: f64) -> f64 {
    if denominator > 0.0 { (numerator / denominator).clamp(0.0, 1.0) } else { 0.0 }
}

/// Fits the reflectances of a group to its evidence, with `diffuse` and `specular` (for
/// `rho_s = 1`) the two bases, each rendered twice.
pub fn fit(
    evidence: &Evidence,
    diffuse: &[Vec<Rgb>; 2],
    specular: Option<&[Vec<Rgb>; 2]>,
    terms: Terms,
) -> LinearFit {
    let mut result = LinearFit { rho_d: Rgb::ZERO, rho_s: Rgb::ZERO, objective: 0.0 };
    for channel in 0..3 {
        let sums = sums(evidence, diffuse, specular, channel);
        let (d, s) = match terms {
            Terms::Diffuse => (sums.best_d(0.0), 0.0),
            Terms::Specular => (0.0, sums.best_s(0.0)),
            Terms::Both => sums.best_pair(),
        };
        result.rho_d[channel] = d as f32;
        result.rho_s[channel] = s as f32;
        result.objective += sums.objective(d, s);
    }
    result
}

fn sums(
    evidence: &Evidence,
    diffuse: &[Vec<Rgb>; 2],
    specular: Option<&[Vec<Rgb>; 2]>,
    channel: usize,
) -> Sums {
    let mut sums = Sums::default();
    for (i, pixel) in evidence.pixels.iter().enumerate() {
        let at = |image: &Vec<Rgb>| f64::from(image[i][channel]);
        let (w, b) = (f64::from(pixel.weight[channel]), f64::from(pixel.radiance[channel]));
        let [d0, d1] = [at(&diffuse[0]), at(&diffuse[1])];
        let [s0, s1] = specular.map_or([0.0; 2], |s| [at(&s[0]), at(&s[1])]);
        sums.bb += w * b * b;
        sums.bd += 0.5 * w * b * (d0 + d1);
        sums.bs += 0.5 * w * b * (s0 + s1);
        sums.dd += w * d0 * d1;
        sums.ds += 0.5 * w * (d0 * s1 + d1 * s0);
        sums.ss += w * s0 * s1;
    }
    sums
}
