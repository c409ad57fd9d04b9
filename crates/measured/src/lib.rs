//! Fits reflectances to a measured BRDF.
//!
//! For each [`Form`] the numbers minimise the cosine-weighted cube-root error over the measured cells ([`Errors`]), by
//! Levenberg-Marquardt from lobes of several widths. Cells beyond some forty thousand are left out of the fit and count in
//! the errors alone. A table of MERL's size takes about a second for each form.

mod form;
mod samples;
mod search;

pub use form::Form;
pub use samples::Errors;

use form::Number;
use rayon::prelude::*;
use samples::Sample;
use std::f64::consts::PI;
use unrender_scene::{Material, MeasuredBrdf};

/// The most cells along each angle that a fit uses. Of `theta_h` all that MERL's tables have, since a sharp lobe lies in a
/// few of them. With half of the others a quarter of the cells remain, and a fit to noise is half as certain; with double of
/// them it takes four times as long.
const MOST_CELLS: [usize; 3] = [90, 30, 15];
/// The roughnesses that a search starts from. They cover two decades of sharpness: at half or
/// double of each the next one takes its place (neither tried).
const ALPHAS: [f64; 3] = [0.02, 0.08, 0.3];
/// The share of the cells whose BRDF is at most that of the base which a search starts from. The search moves it: at half of it noise decides
/// where it starts, at double of it wide lobes do (neither tried).
const BASE_QUANTILE: f64 = 0.25;
/// The reflectance of a lobe over a base from which a search starts: about that of plastics. The search moves it; half or
/// double of it are plastics, too (neither tried).
const LOBE: f64 = 0.05;
/// The reflectance of a metal from which a search starts: the middle. The search moves it; half or double of it are its
/// ends (neither tried).
const METAL: f64 = 0.5;
/// The refractive index from which a search starts, that of plastics. The search moves it; with half or double of the
/// difference from one it starts at water or at diamond (neither tried).
const IOR: f64 = 1.5;

/// A reflectance that was fitted to a measured BRDF.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// What was fitted.
    pub form: Form,
    /// The material.
    pub material: Material,
    /// Its errors over the whole table.
    pub errors: Errors,
}

/// Why a table cannot be fitted.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "only {measured} of {cells} cells were measured within 80 degrees of the normal; a fit needs at least {}",
    LEAST_SAMPLES
)]
pub struct TooFew {
    /// The cells that can be used.
    pub measured: usize,
    /// All cells.
    pub cells: usize,
}

/// The fewest cells of a fit. Half of them hardly determine seven numbers; double of them would refuse coarse tables that do.
const LEAST_SAMPLES: usize = 12;

/// The best fit to `table` of each of `forms`, in their order.
///
/// ```
/// use unrender_measured::{Form, fit};
/// use unrender_scene::{Hypothesis, MeasuredBrdf, Rgb};
///
/// // Chalk: the same in all directions.
/// let table = MeasuredBrdf::from_fn([8, 4, 4], |_, _| Rgb::splat(0.6 / std::f32::consts::PI)).unwrap();
/// let fits = fit(&table, &Form::of(Some("ggx".parse().unwrap())))?;
/// assert_eq!(fits[0].form.hypothesis, Hypothesis::Diffuse);
/// assert!((fits[0].material.rho_d.x - 0.6).abs() < 1e-4 && fits[0].errors.compressed < 1e-5);
/// # Ok::<(), unrender_measured::TooFew>(())
/// ```
///
/// # Errors
/// If the table has hardly a measured cell.
pub fn fit(table: &MeasuredBrdf, forms: &[Form]) -> Result<Vec<Fit>, TooFew> {
    let counts = table.counts();
    let steps = [0, 1, 2].map(|angle| counts[angle].div_ceil(MOST_CELLS[angle]));
    let used = samples::samples(table, steps);
    if used.len() < LEAST_SAMPLES {
        return Err(TooFew { measured: used.len(), cells: table.len() });
    }
    let base = base(&used);
    let of_form = |form: &Form| {
        let material = best(*form, &used, base);
        let errors = samples::errors(table, &material, form.model);
        Fit { form: *form, material, errors }
    };
    Ok(forms.par_iter().map(of_form).collect())
}

/// The simplest of `fits` whose error is at most `NEARLY` times that of the best one.
pub fn chosen(fits: &[Fit]) -> Option<&Fit> {
    let least = fits.iter().map(|fit| fit.errors.compressed).min_by(f64::total_cmp)?;
    fits.iter().find(|fit| fit.errors.compressed <= NEARLY * least)
}

/// How much larger the error of a simpler fit may be. With half of it, noise would more often choose among forms that fit
/// alike; with double of it a weak lobe would more often be left out (neither tried).
const NEARLY: f64 = 1.02;

/// The material of `form` that fits best.
fn best(form: Form, samples: &[Sample], base: [f64; 3]) -> Material {
    let has_lobe = form.numbers().contains(&Number::Alpha);
    let alphas = if has_lobe { &ALPHAS[..] } else { &ALPHAS[..1] };
    let start = |alpha: f64| -> Vec<f64> {
        let value = |number: Number| match number {
            Number::Base(channel) => base[channel],
            Number::Lobe(_) if form.hypothesis == unrender_scene::Hypothesis::Metal => METAL,
            Number::Lobe(_) => LOBE,
            Number::Ior => IOR,
            Number::Alpha => alpha,
        };
        form.numbers().into_iter().map(value).collect()
    };
    let rough =
        alphas.iter().map(|alpha| search::search(form, samples, &start(*alpha), search::ROUGH));
    let rough = rough.min_by(|a, b| a.1.total_cmp(&b.1));
    let start = rough.map_or_else(|| start(ALPHAS[1]), |(values, _)| values);
    form.material(&search::search(form, samples, &start, search::FINAL).0)
}

/// The reflectance of the base if it is what dark cells show, by channel.
fn base(samples: &[Sample]) -> [f64; 3] {
    [0, 1, 2].map(|channel| {
        let mut values: Vec<f64> = samples.iter().map(|sample| sample.value[channel]).collect();
        values.sort_by(f64::total_cmp);
        let at = (BASE_QUANTILE * values.len() as f64) as usize;
        let low = values.get(at).copied().unwrap_or(0.0);
        // A number that starts on its bound would stay there.
        (PI * low).clamp(1e-3, 0.95)
    })
}
