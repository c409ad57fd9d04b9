//! One lobe after another over the same incident samples: `S = sum w(wo, wi) E` for each probe.
//!
//! A search for the shape of a lobe needs these sums a hundred times. All that depends only on the directions is
//! computed once: the slopes of the half vector `h = wo + wi` and of `wi` (x and y over z), and the sample's irradiance
//! times all factors without a roughness. What is left is an exponential for Ward's lobe, and two square roots for GGX.
//! Samples go eight at a time.

use crate::bsdf::ward::ALPHA_MIN;
use crate::probe::{Incident, Probe, Probes};
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;
use unrender_scene::{BrdfModel, Rgb, WardModel};
use wide::f32x8;

/// Samples that are summed together.
const LANES: usize = 8;

/// The incident samples of some probes, prepared for lobes of one model.
#[derive(Clone, Debug)]
pub struct LobeSums {
    model: BrdfModel,
    probes: Vec<Outgoing>,
    lanes: Vec<Lanes>,
    /// The slopes of `wi`, eight by eight; empty where the model has no masking.
    wi: Vec<[f32x8; 2]>,
}

/// The data of a probe.
#[derive(Clone, Copy, Debug)]
struct Outgoing {
    /// The slopes of `wo`.
    slopes: Vec2,
    first: u32,
    count: u32,
}

/// Eight samples of one probe; those beyond its last have no irradiance.
#[derive(Clone, Copy, Debug)]
struct Lanes {
    /// The slopes of the half vectors.
    half: [f32x8; 2],
    /// Irradiance times what does not depend on the lobe.
    irradiance: [f32x8; 3],
}

impl LobeSums {
    /// Prepares the samples of `probes` for lobes of `model`.
    pub fn new(model: BrdfModel, probes: &Probes) -> Self {
        let mut lanes = Vec::with_capacity(probes.incident.len() / LANES + probes.probes.len());
        let mut wi = Vec::new();
        let mut of_probe = |probe: &Probe| {
            let first = lanes.len() as u32;
            for eight in probes.incident_of(probe).chunks(LANES) {
                lanes.push(Lanes::new(model, probe.wo, eight));
                if model.is_ggx() {
                    wi.push(columns(eight.iter().map(|sample| slopes(sample.wi).to_array())));
                }
            }
            Outgoing { slopes: slopes(probe.wo), first, count: lanes.len() as u32 - first }
        };
        let of_probes = probes.probes.iter().map(&mut of_probe).collect();
        Self { model, probes: of_probes, lanes, wi }
    }

    /// Drops the probes that are not `kept`, in their order.
    pub fn retain(&mut self, mut kept: impl FnMut() -> bool) {
        self.probes.retain(|_| kept());
    }

    /// For the probe number `probe`: the radiance towards `wo` of a lobe with `rho_s = 1`, whose roughnesses are
    /// raised to [`ALPHA_MIN`]; its anisotropy direction is `theta_rad` from the tangent.
    pub fn of(&self, probe: usize, [alpha_x, alpha_y, theta_rad]: [f32; 3]) -> Rgb {
        let lobe = Lobe::new(alpha_x.max(ALPHA_MIN), alpha_y.max(ALPHA_MIN), theta_rad);
        let outgoing = self.probes[probe];
        let range = outgoing.first as usize..(outgoing.first + outgoing.count) as usize;
        let lanes = &self.lanes[range.clone()];
        let mut sums = [f32x8::ZERO; 3];
        let mut add = |lanes: &Lanes, value: f32x8| {
            for (sum, irradiance) in sums.iter_mut().zip(lanes.irradiance) {
                *sum += value * irradiance;
            }
        };
        match self.model {
            BrdfModel::Ward(_) => lanes.iter().for_each(|l| add(l, lobe.exponential(l.half))),
            BrdfModel::Ggx | BrdfModel::Principled(_) => {
                let seen = 1.0 + lobe.masking(outgoing.slopes);
                let both = lanes.iter().zip(&self.wi[range]);
                both.for_each(|(l, wi)| add(l, lobe.microfacets(l.half, *wi, seen)));
            }
        }
        lobe.norm * Rgb::from_array(sums.map(total))
    }
}

impl Lanes {
    fn new(model: BrdfModel, wo: Vec3, samples: &[Incident]) -> Self {
        let row = |sample: &Incident| {
            let (half, factor) = (slopes(wo + sample.wi), factor(model, wo, sample.wi));
            // Where the half vector grazes, no lobe has a value.
            let lit = if factor.is_finite() { factor * sample.irradiance } else { Rgb::ZERO };
            [half.x, half.y, lit.x, lit.y, lit.z]
        };
        let [half_x, half_y, r, g, b] = columns(samples.iter().map(row));
        Self { half: [half_x, half_y], irradiance: [r, g, b] }
    }
}

/// At most eight rows as columns; what is beyond the last row is zero.
fn columns<const N: usize>(rows: impl Iterator<Item = [f32; N]>) -> [f32x8; N] {
    let mut columns = [[0.0f32; LANES]; N];
    for (lane, row) in rows.enumerate() {
        columns.iter_mut().zip(row).for_each(|(column, value)| column[lane] = value);
    }
    columns.map(f32x8::from)
}

/// The slopes of a direction along x and y.
fn slopes(direction: Vec3) -> Vec2 {
    direction.truncate() / direction.z
}

/// The factor of a lobe's value that depends neither on its shape nor on the norm `1 / (4 pi alpha_x alpha_y)`.
fn factor(model: BrdfModel, wo: Vec3, wi: Vec3) -> f32 {
    let h = wo + wi;
    let (length2, z2) = (h.length_squared(), h.z * h.z);
    match model {
        BrdfModel::Ward(WardModel::Ward1992) => 1.0 / (wo.z * wi.z).sqrt(),
        BrdfModel::Ward(WardModel::WardDuer) => 1.0 / (wo.z * wi.z),
        BrdfModel::Ward(WardModel::WardGmd) => 4.0 * length2 / (z2 * z2),
        // D has the fourth power of the cosine of the normalised half vector.
        BrdfModel::Ggx | BrdfModel::Principled(_) => length2 * length2 / (z2 * z2) / (wo.z * wi.z),
    }
}

/// The sum of all lanes, in the same order on all processors.
fn total(lanes: f32x8) -> f32 {
    let [a, b, c, d, e, f, g, h] = lanes.to_array();
    ((a + b) + (c + d)) + ((e + f) + (g + h))
}

/// A lobe's shape.
struct Lobe {
    /// Turns slopes into the lobe's frame, over its roughnesses.
    rows: [Vec2; 2],
    /// Turns slopes into the lobe's frame, times its roughnesses.
    masks: [Vec2; 2],
    /// `1 / (4 pi alpha_x alpha_y)`.
    norm: f32,
}

impl Lobe {
    fn new(alpha_x: f32, alpha_y: f32, theta_rad: f32) -> Self {
        let (sin, cos) = theta_rad.sin_cos();
        let (along, across) = (Vec2::new(cos, sin), Vec2::new(-sin, cos));
        Self {
            rows: [along / alpha_x, across / alpha_y],
            masks: [alpha_x * along, alpha_y * across],
            norm: 0.25 * FRAC_1_PI / (alpha_x * alpha_y),
        }
    }

    /// `(h_x / alpha_x)^2 + (h_y / alpha_y)^2` of Ward's exponent, and of GGX's distribution.
    fn squared(rows: [Vec2; 2], [x, y]: [f32x8; 2]) -> f32x8 {
        let [a, b] = rows.map(|row| f32x8::splat(row.x) * x + f32x8::splat(row.y) * y);
        a * a + b * b
    }

    fn exponential(&self, half: [f32x8; 2]) -> f32x8 {
        (-Self::squared(self.rows, half)).exp()
    }

    /// `1 / ((1 + q)^2 (1 + L(wo) + L(wi)))`.
    fn microfacets(&self, half: [f32x8; 2], wi: [f32x8; 2], seen: f32) -> f32x8 {
        let one = f32x8::ONE;
        let q = one + Self::squared(self.rows, half);
        let of_wi = f32x8::splat(0.5) * ((one + Self::squared(self.masks, wi)).sqrt() - one);
        one / (q * q * (f32x8::splat(seen) + of_wi))
    }

    /// `L(wo)`: the masking of a direction with these slopes.
    fn masking(&self, slopes: Vec2) -> f32 {
        let tan2: f32 = self.masks.iter().map(|mask| mask.dot(slopes).powi(2)).sum();
        0.5 * ((1.0 + tan2).sqrt() - 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::lobe::GlossyLobe;

    fn direction(cos: f32, phi: f32) -> Vec3 {
        let sin = (1.0 - cos * cos).sqrt();
        Vec3::new(sin * phi.cos(), sin * phi.sin(), cos)
    }

    /// Probes of 0 to 20 samples each, from all over the hemisphere.
    fn probes() -> Probes {
        let mut probes = Probes::default();
        for (i, cos) in [1.0f32, 0.8, 0.4, 0.1].into_iter().enumerate() {
            let wo = direction(cos, 0.7 * i as f32);
            let first = probes.incident.len() as u32;
            for j in 0..[13, 0, 20, 8][i] {
                let wi = direction(0.05 + 0.95 * (j as f32 / 20.0), 2.1 * j as f32);
                let irradiance = Rgb::new(1.0, 0.5 + j as f32, 0.3);
                probes.incident.push(Incident { wi, irradiance });
            }
            let count = probes.incident.len() as u32 - first;
            probes.probes.push(Probe {
                pixel: i as u32,
                group: 0,
                throughput: Rgb::ONE,
                wo,
                point: Vec3::ZERO,
                emitted: Rgb::ZERO,
                diffuse: Rgb::ZERO,
                straight: Rgb::ZERO,
                mirror: Rgb::ZERO,
                mirrored: None,
                first,
                count,
            });
        }
        probes
    }

    #[test]
    fn sums_are_those_of_the_lobes_values() {
        let probes = probes();
        let wards = [WardModel::Ward1992, WardModel::WardDuer, WardModel::WardGmd];
        let models = wards.map(BrdfModel::Ward).into_iter().chain([BrdfModel::Ggx]);
        for model in models {
            let sums = LobeSums::new(model, &probes);
            for shape in [[0.02, 0.02, 0.0], [0.3, 0.3, 0.0], [0.1, 0.4, 0.6], [0.9, 0.05, 2.5]] {
                let lobe = GlossyLobe::new(model, shape[0], shape[1]);
                let (sin, cos) = shape[2].sin_cos();
                let turn = |v: Vec3| Vec3::new(cos * v.x + sin * v.y, cos * v.y - sin * v.x, v.z);
                for (i, probe) in probes.probes.iter().enumerate() {
                    let value =
                        |s: &Incident| lobe.value(turn(probe.wo), turn(s.wi)) * s.irradiance;
                    let expected: Rgb = probes.incident_of(probe).iter().map(value).sum();
                    let off = (sums.of(i, shape) - expected).abs().max_element();
                    let most = 2e-5 * expected.max_element() + 1e-12;
                    assert!(off <= most, "{model:?} {shape:?} {i}: {off} of {expected}");
                }
            }
        }
    }

    #[test]
    fn probes_that_are_dropped_take_their_samples_with_them() {
        let probes = probes();
        let whole = LobeSums::new(BrdfModel::Ggx, &probes);
        let mut some = whole.clone();
        let mut number = 0..;
        some.retain(|| number.next() != Some(1));
        for (left, before) in [0, 2, 3].into_iter().enumerate() {
            let shape = [0.2, 0.3, 0.1];
            assert_eq!(some.of(left, shape), whole.of(before, shape));
        }
    }
}
