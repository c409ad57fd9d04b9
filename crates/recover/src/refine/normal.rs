//! The normal equations of one pass.
//!
//! With the residuals `r = B - L` and Jacobians `J` of two renderings with independent noise:
//! `H = sum w sym(J_A^T J_B)` and `g = sum w (J_A^T r_B + J_B^T r_A) / 2`: the noise of a rendering
//! meets itself nowhere, so it biases neither. The weight `w` is the inverse variance of a cell's
//! residual under the observation model ([`crate::model_error`]): the photograph's noise, and,
//! measured on all cells of its group, the rendering's noise and the model error, at the brightness
//! of the model around the cell.
//!
//! `g` is a sum over cells. From their spread comes its covariance, whatever the noise is and
//! however it hangs together within a cell: `G = m/(m - n) sum g_b g_b^T` for `m` cells and `n`
//! unknowns, which make the residuals smaller than the noise [Huber 1967; White 1982; MacKinnon
//! and White 1985].

use super::means::Mean;
use nalgebra::{DMatrix, DVector};
use unrender_scene::Rgb;

/// The normal equations and how good the fit was where they were taken.
pub(crate) struct Normal {
    /// The curvature of half the weighted squared error.
    pub(crate) h: DMatrix<f64>,
    /// The negative of its gradient: where to go.
    pub(crate) g: DVector<f64>,
    /// The covariance of `g`.
    pub(crate) g_covariance: DMatrix<f64>,
    /// The part of it that the renderings' noise has.
    pub(crate) g_rendering: DMatrix<f64>,
    /// What each cell contributes to the relative squared error that both renderings see.
    pub(crate) errors: Vec<f64>,
    /// The weight of each cell's residuals.
    pub(crate) weights: Vec<Rgb>,
}

/// Residuals of more standard deviations than this pull as if they were of so many: a few cells
/// that the model has no idea of do not rule the rest [Huber 1964].
const HUBER: f32 = 6.0;
/// No model of a scene is better than this, relatively and squared.
const MISFIT_MIN: f32 = 1e-6;
/// A cell counts at most this many times the median when the noise of a group is measured: one
/// firefly is not the group's noise.
const OUTLIER: f32 = 30.0;

impl Normal {
    /// The equations for `n` unknowns of a scene with `groups` groups; `specular` says for each
    /// unknown whether it is a specular reflectance.
    pub(crate) fn of(means: &[Mean], specular: &[bool], groups: usize) -> Self {
        let n = specular.len();
        let noise: Vec<Noise> = (0..groups).map(|group| Noise::of(means, group)).collect();
        let shrinkage = shrinkage(means, n, groups);
        let specular = Specular::of(means, specular, groups);
        let mut normal = Self {
            h: DMatrix::zeros(n, n),
            g: DVector::zeros(n),
            g_covariance: DMatrix::zeros(n, n),
            g_rendering: DMatrix::zeros(n, n),
            errors: Vec::with_capacity(means.len()),
            weights: Vec::with_capacity(means.len()),
        };
        for mean in means {
            let variance = noise[mean.group].variance(mean);
            let [a, b] = mean.residuals;
            let robust = if specular.may_be_highlight(mean) {
                1.0
            } else {
                let deviations = (0.5 * (a + b)).abs() / variance.map(f32::sqrt);
                (HUBER / deviations.max_element()).min(1.0)
            };
            let shrink = |k: usize| shrinkage[(mean.group, k)];
            let (mut g, mut g_rendering) = (DVector::zeros(n), DVector::zeros(n));
            for channel in 0..3 {
                let weight = f64::from(robust / variance[channel]);
                let residuals = [f64::from(a[channel]), f64::from(b[channel])];
                let row = &mean.rows[channel];
                normal.add_row(row, shrink, weight, residuals, &mut g);
                // The difference of the two has the noise of their mean and nothing else.
                let noise = 0.5 * weight * (residuals[0] - residuals[1]);
                row.iter()
                    .for_each(|&(k, a, b)| g_rendering[k] += shrink(k) * noise * 0.5 * (a + b));
            }
            normal.g_covariance.syger(1.0, &g, &g, 1.0);
            normal.g_rendering.syger(1.0, &g_rendering, &g_rendering, 1.0);
            normal.g += g;
            let error = f64::from((robust * a * b / mean.level2).element_sum());
            normal.errors.push(error * mean.pixels);
            normal.weights.push(robust * variance.recip());
        }
        let free = means.len().saturating_sub(n).max(1);
        normal.g_covariance *= means.len() as f64 / free as f64;
        normal.h.fill_upper_triangle_with_lower_triangle();
        normal.g_covariance.fill_upper_triangle_with_lower_triangle();
        normal.g_rendering.fill_upper_triangle_with_lower_triangle();
        normal
    }

    /// Adds one cell in one channel to the lower triangle of `h`, and to the cell's `g`.
    fn add_row(
        &mut self,
        row: &[(usize, f64, f64)],
        shrink: impl Fn(usize) -> f64,
        weight: f64,
        [ra, rb]: [f64; 2],
        g: &mut DVector<f64>,
    ) {
        for (k, &(i, ai, bi)) in row.iter().enumerate() {
            g[i] += 0.5 * weight * shrink(i) * (ai * rb + bi * ra);
            for &(j, aj, bj) in &row[..=k] {
                let (low, high) = (i.max(j), i.min(j));
                let shrinkage = (shrink(i) * shrink(j)).sqrt();
                self.h[(low, high)] += 0.5 * weight * shrinkage * (ai * bj + bi * aj);
            }
        }
    }
}

/// For each group and unknown: how much of the group's derivatives by the unknown is signal.
///
/// `S / (S + N)`, with `S` the power that both renderings see and `N` that of their difference. What
/// is mostly noise says little about the unknown but would put its noise into the equations. The
/// scaled rows are instruments `z = S J`: the estimating equation is `sum z r = 0`, whose derivative
/// `sum z J` has the factor once, like `g`, so that steps and covariance are those of the unknowns
/// themselves. Off its diagonal the derivative is taken as `sqrt(S_i S_j) J_i J_j`, which keeps it
/// positive semidefinite.
fn shrinkage(means: &[Mean], n: usize, groups: usize) -> DMatrix<f64> {
    let mut signal = DMatrix::<f64>::zeros(groups, n);
    let mut noise = DMatrix::<f64>::zeros(groups, n);
    for mean in means {
        for channel in 0..3 {
            let weight = mean.pixels / f64::from(mean.level2[channel]);
            for &(k, a, b) in &mean.rows[channel] {
                signal[(mean.group, k)] += weight * a * b;
                noise[(mean.group, k)] += weight * 0.25 * (a - b).powi(2);
            }
        }
    }
    signal.zip_map(&noise, |s, n| if s > 0.0 { s / (s + n) } else { 0.0 })
}

/// Where a highlight may be: the greatest specular term of each group.
struct Specular<'a> {
    is_specular: &'a [bool],
    greatest: Vec<f64>,
}

/// A cell may show a highlight if its specular term is this share of the greatest of its group. At
/// half of it more of what the model lacks pulls with full force, at double the feet of highlights
/// are cut.
const HIGHLIGHT: f64 = 0.1;

impl<'a> Specular<'a> {
    fn of(means: &[Mean], is_specular: &'a [bool], groups: usize) -> Self {
        let mut all = Self { is_specular, greatest: vec![0.0; groups] };
        for mean in means {
            all.greatest[mean.group] = all.greatest[mean.group].max(all.term(mean));
        }
        all
    }

    /// The mean derivative by the group's specular reflectance.
    fn term(&self, mean: &Mean) -> f64 {
        let of_row = |row: &Vec<(usize, f64, f64)>| {
            let specular = row.iter().filter(|(k, ..)| self.is_specular[*k]);
            specular.map(|(_, a, b)| 0.5 * (a + b)).fold(0.0, f64::max)
        };
        mean.rows.iter().map(of_row).fold(0.0, f64::max)
    }

    /// Whether the photograph is brighter than the model where the group may show a highlight.
    fn may_be_highlight(&self, mean: &Mean) -> bool {
        let brighter = (mean.residuals[0] + mean.residuals[1]).element_sum() > 0.0;
        let greatest = self.greatest[mean.group];
        brighter && greatest > 0.0 && self.term(mean) >= HIGHLIGHT * greatest
    }
}

/// What is not the photograph's noise in the residuals of a group, relative to the local radiance.
struct Noise {
    /// Variance of the mean of both renderings, times the pixels of a cell.
    rendering: Rgb,
    /// Variance of what the model does not explain.
    misfit: Rgb,
}

impl Noise {
    fn of(means: &[Mean], group: usize) -> Self {
        let of_group = || means.iter().filter(move |m| m.group == group && !m.bound);
        let rendering = |m: &Mean| {
            let [a, b] = m.residuals;
            0.25 * (a - b) * (a - b) / m.level2 * m.pixels as f32
        };
        let rendering = clipped_mean(of_group().map(rendering));
        let misfit = |m: &Mean| {
            let mean = 0.5 * (m.residuals[0] + m.residuals[1]);
            (mean * mean - m.variance) / m.level2 - rendering / m.pixels as f32
        };
        let misfit = clipped_mean(of_group().map(misfit)).max(Rgb::splat(MISFIT_MIN));
        Self { rendering, misfit }
    }

    /// The variance of a cell's mean residual.
    fn variance(&self, mean: &Mean) -> Rgb {
        let relative = self.misfit + self.rendering / mean.pixels as f32;
        (mean.variance + relative * mean.level2).max(Rgb::splat(f32::MIN_POSITIVE))
    }
}

/// The mean with values beyond [`OUTLIER`] medians (of their sizes) cut down to that, by channel.
fn clipped_mean(values: impl Iterator<Item = Rgb>) -> Rgb {
    let values: Vec<Rgb> = values.collect();
    let channel = |c: usize| {
        let mut sizes: Vec<f32> = values.iter().map(|v| v[c].abs()).collect();
        let middle = sizes.len() / 2;
        if sizes.is_empty() {
            return 0.0;
        }
        let most = OUTLIER * *sizes.select_nth_unstable_by(middle, f32::total_cmp).1;
        let sum: f64 = values.iter().map(|v| f64::from(v[c].clamp(-most, most))).sum();
        (sum / values.len() as f64) as f32
    };
    Rgb::new(channel(0), channel(1), channel(2))
}
