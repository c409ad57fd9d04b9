//! The step from one global re-rendering to the next, for the reflectances of all groups together.
//!
//! Each group's correction takes its light as given; but the corrected group lights the others, and they light it. In a
//! box with bright walls most of that comes back: groups that all become brighter or darker together overshoot with the
//! full correction; half of it stops the overshooting, but where one group becomes brighter and another darker it
//! leaves nine tenths of the error. The last corrections and their effects show how the groups depend on each other:
//! Anderson's mixing [Walker and Ni 2011] takes the combination of the last steps that would have left the least to
//! correct, and adds half of the correction.

use nalgebra::{DMatrix, DVector};
use unrender_scene::Material;

/// The share of a correction that is taken. With one, as eq. 3 has it, all groups overshoot together on Figure 8 and
/// swing between two states for ever (change 0.257 in every iteration from the third to the twelfth).
const SHARE: f64 = 0.5;
/// How many steps before the last are combined with it. Half and double of it were not tried.
const DEPTH: usize = 4;
/// Singular values of the last changes below this share of the largest count as zero.
const RELATIVE: f64 = 1e-3;
/// And so do those below this: reflectances are rounded to a hundredth of it.
const ROUNDING: f64 = 1e-5;
/// A reflectance below this gets its full correction: its logarithm says nothing.
const LEAST: f32 = 1e-4;
/// A reflectance changes by this factor at most, as a logarithm.
const LARGEST: f64 = 0.7;

/// The last steps of each channel: the channels are independent.
#[derive(Default)]
pub(super) struct Mixing {
    channels: [Channel; 3],
}

/// The logarithms of the reflectances of a channel at the last steps, and the corrections of them.
#[derive(Default)]
struct Channel {
    of: Vec<Entry>,
    past: Vec<[DVector<f64>; 2]>,
}

/// A group, and whether the number is its specular reflectance.
type Entry = (usize, bool);

impl Mixing {
    /// Forgets the last steps: they were those of other hypotheses.
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }

    /// From the materials `now` towards the `corrected` ones. Roughnesses and directions are as corrected.
    pub(super) fn step(&mut self, now: &[Material], corrected: &[Material]) -> Vec<Material> {
        let mut next = corrected.to_vec();
        for (c, channel) in self.channels.iter_mut().enumerate() {
            let value = |materials: &[Material], (group, is_specular): Entry| {
                let material = &materials[group];
                if is_specular { material.rho_s[c] } else { material.rho_d[c] }
            };
            let all = (0..now.len()).flat_map(|group| [(group, false), (group, true)]);
            let is_mixed = |entry: &Entry| {
                let is_plain = corrected[entry.0].texture.is_none();
                is_plain
                    && [now, corrected].iter().all(|materials| value(materials, *entry) > LEAST)
            };
            let of: Vec<Entry> = all.filter(is_mixed).collect();
            let logs = |materials: &[Material]| {
                let log = |entry: &Entry| f64::from(value(materials, *entry)).ln();
                DVector::from_iterator(of.len(), of.iter().map(log))
            };
            let (from, to) = (logs(now), logs(corrected));
            if channel.of != of {
                *channel = Channel { of: of.clone(), past: Vec::new() };
            }
            let step = channel.step(from.clone(), to - &from);
            for (entry, log) in of.iter().zip((from + step).iter()) {
                let (material, value) = (&mut next[entry.0], log.exp().min(1.0) as f32);
                if entry.1 {
                    material.rho_s[c] = value;
                } else {
                    material.rho_d[c] = value;
                }
            }
        }
        next
    }
}

impl Channel {
    /// The step from `at`, where the corrections are `correction`.
    fn step(&mut self, at: DVector<f64>, correction: DVector<f64>) -> DVector<f64> {
        let mut step = SHARE * &correction;
        if !self.past.is_empty() && !at.is_empty() {
            let columns = |of: &dyn Fn(&[DVector<f64>; 2]) -> DVector<f64>| {
                DMatrix::from_columns(&self.past.iter().map(of).collect::<Vec<_>>())
            };
            let moved = columns(&|past| &at - &past[0]);
            let changed = columns(&|past| &correction - &past[1]);
            let svd = changed.clone().svd(true, true);
            let least = (RELATIVE * svd.singular_values.max()).max(ROUNDING);
            let weights = svd.solve(&correction, least);
            if let Ok(weights) = weights {
                step -= (moved + SHARE * changed) * weights;
            }
        }
        self.past.push([at, correction]);
        let old = self.past.len().saturating_sub(DEPTH);
        self.past.drain(..old);
        step.map(|by| by.clamp(-LARGEST, LARGEST))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use unrender_scene::Rgb;

    /// Two walls that send each other most of their light: each correction makes its own wall right for the light that
    /// the other sends now.
    #[test]
    fn walls_that_light_each_other_come_to_rest() {
        let truth = [0.8f32, 0.3];
        let corrected = |now: &[Material]| -> Vec<Material> {
            let off = [0, 1].map(|wall: usize| now[wall].rho_d.x / truth[wall]);
            let of = |wall: usize| truth[wall] / off[1 - wall].powf(0.9);
            [0, 1].map(|wall| Material::diffuse(Rgb::splat(of(wall)))).to_vec()
        };
        // The same correction again and again, but for rounding, says nothing of the walls either.
        let rounded = |now: &[Material]| {
            let up = |material: &Material| Material::diffuse(material.rho_d * (1.0 + 4e-7));
            now.iter().map(up).collect::<Vec<_>>()
        };
        for start in [[0.5, 0.5], [0.9, 0.1]] {
            let mut walls = start.map(|rho| Material::diffuse(Rgb::splat(rho))).to_vec();
            let mut mixing = Mixing::default();
            for _ in 0..6 {
                walls = mixing.step(&walls, &corrected(&walls));
            }
            for _ in 0..6 {
                walls = mixing.step(&walls, &rounded(&walls));
            }
            let off = |wall: usize| (walls[wall].rho_d.x - truth[wall]).abs();
            assert!(off(0).max(off(1)) < 1e-3, "{walls:?}");
        }
    }
}
