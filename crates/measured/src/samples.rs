//! The cells of a measured BRDF that are compared, and the two errors.
//!
//! With `m` the measured BRDF, `f` the fitted one and `c` the cosine of `wi`:
//!
//! ```text
//! compressed  sqrt( mean (cbrt(f c) - cbrt(m c))^2 )       over cells and channels [Fores et al. 2012]
//! linear      sqrt( sum w (f c - m c)^2 / sum w (m c)^2 )  w: solid angles of a cell [Ngan et al. 2005]
//! ```
//!
//! The first is what is minimised. Observers chose materials that were fitted so over those fitted by the second, which
//! sees little but the highlight. Its cells count alike, so that the table's own spacing decides how much a sharp
//! highlight counts. The second is divided by the measured light, so that it is a share of it. Directions further than
//! 80 degrees from the normal are left out: these values of the database are extrapolated [Ngan et al. 2005].

use glam::Vec3;
use rayon::prelude::*;
use unrender_render::bsdf::Bsdf;
use unrender_scene::measured::directions;
use unrender_scene::{BrdfModel, Material, MeasuredBrdf};

/// The least cosine of both directions, that of 80 degrees [Ngan et al. 2005]. With half of it, extrapolated values would
/// count; with double of it, Fresnel's rise towards grazing angles would hardly be seen.
pub(super) const LEAST_COSINE: f32 = 0.173_648;
/// Added to what a cube root is taken of, sr^-1: its slope is infinite at zero. It is the light of a base of reflectance
/// 3e-6; half or double of it is as far below any surface that is measured.
const FLOOR: f64 = 1e-6;

/// One cell that was measured.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub(super) wo: Vec3,
    pub(super) wi: Vec3,
    /// The BRDF, sr^-1.
    pub(super) value: [f64; 3],
    /// Its solid angles, up to a factor.
    weight: f64,
}

/// The errors of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// Of the cube roots of the reflected light, sr^(-1/3).
    pub compressed: f64,
    /// Of the reflected light, as a share of it.
    pub linear: f64,
}

impl Sample {
    /// That of the cell `index`; none if it was not measured, or lies at grazing angles.
    fn of(table: &MeasuredBrdf, index: usize) -> Option<Self> {
        let value = table.value(index)?.to_array().map(f64::from);
        let (wo, wi) = directions(table.centre(index));
        let is_steep = wo.z >= LEAST_COSINE && wi.z >= LEAST_COSINE;
        is_steep.then(|| Self { wo, wi, value, weight: f64::from(table.weight(index)) })
    }

    /// The cube root of the light that is reflected where the BRDF is `f`, and its derivative by `f`.
    pub(super) fn compressed(&self, f: f64) -> (f64, f64) {
        let cosine = f64::from(self.wi.z);
        let root = (f.max(0.0) * cosine + FLOOR).cbrt();
        (root, cosine / (3.0 * root * root))
    }
}

/// The samples of every `steps`-th cell along each angle.
pub(super) fn samples(table: &MeasuredBrdf, steps: [usize; 3]) -> Vec<Sample> {
    let [_, n_d, n_p] = table.counts();
    let is_taken = |index: &usize| {
        let at = [index / (n_d * n_p), index / n_p % n_d, index % n_p];
        // The middle one of each.
        at.iter().zip(&steps).all(|(at, step)| at % step == step / 2)
    };
    (0..table.len()).filter(is_taken).filter_map(|index| Sample::of(table, index)).collect()
}

/// The errors of `material` over the whole `table`.
pub(super) fn errors(table: &MeasuredBrdf, material: &Material, model: BrdfModel) -> Errors {
    let bsdf = Bsdf::new(material, material.rho_d, model);
    let rows = table.counts()[0];
    let cells = table.len() / rows;
    let row = |row: usize| {
        let mut sums = [0.0; 4];
        let of_row = row * cells..(row + 1) * cells;
        for sample in of_row.filter_map(|index| Sample::of(table, index)) {
            let fitted = bsdf.value(sample.wo, sample.wi).to_array().map(f64::from);
            let cosine = f64::from(sample.wi.z);
            for (fitted, measured) in fitted.into_iter().zip(sample.value) {
                let apart = sample.compressed(fitted).0 - sample.compressed(measured).0;
                let light = measured * cosine;
                let off = fitted * cosine - light;
                let more =
                    [apart * apart, 1.0, sample.weight * off * off, sample.weight * light * light];
                sums.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
            }
        }
        sums
    };
    let rows: Vec<[f64; 4]> = (0..rows).into_par_iter().map(row).collect();
    let sum = |of: usize| rows.iter().map(|row| row[of]).sum::<f64>();
    let root = |over: usize, under: usize| (sum(over) / sum(under).max(f64::MIN_POSITIVE)).sqrt();
    Errors { compressed: root(0, 1), linear: root(2, 3) }
}
