//! Tables of closed forms, written here from their papers: the fit finds the parameters that made them.

use glam::Vec3;
use std::f32::consts::PI;
use unrender_measured::{Fit, Form, chosen, fit};
use unrender_scene::{BrdfModel, Hypothesis, MeasuredBrdf, Rgb};

/// A coarse table: MERL's own has 90 x 90 x 180 cells.
const COUNTS: [usize; 3] = [30, 10, 8];
const RHO_D: Rgb = Rgb::new(0.3, 0.15, 0.05);
const RHO_S: Rgb = Rgb::new(0.1, 0.12, 0.2);

/// Ward's isotropic lobe as in his paper [Ward 1992, equation 5].
fn ward(wo: Vec3, wi: Vec3, alpha: f32) -> f32 {
    let h = (wo + wi).normalize();
    let tan2 = (1.0 - h.z * h.z) / (h.z * h.z);
    (-tan2 / (alpha * alpha)).exp() / (4.0 * PI * alpha * alpha * (wo.z * wi.z).sqrt())
}

/// Smith's Lambda of GGX [Heitz 2014].
fn lambda(z: f32, alpha: f32) -> f32 {
    0.5 * ((1.0 + alpha * alpha * (1.0 - z * z) / (z * z)).sqrt() - 1.0)
}

/// GGX with the height-correlated masking of Smith [Heitz 2014].
fn ggx(wo: Vec3, wi: Vec3, alpha: f32) -> f32 {
    let h = (wo + wi).normalize();
    let a2 = alpha * alpha;
    let below = h.z * h.z * (a2 - 1.0) + 1.0;
    let density = a2 / (PI * below * below);
    density / (1.0 + lambda(wo.z, alpha) + lambda(wi.z, alpha)) / (4.0 * wo.z * wi.z)
}

/// The same with both directions masked apart [Walter et al. 2007].
fn ggx_apart(wo: Vec3, wi: Vec3, alpha: f32) -> f32 {
    let [out, into] = [wo.z, wi.z].map(|z| lambda(z, alpha));
    ggx(wo, wi, alpha) * (1.0 + out + into) / ((1.0 + out) * (1.0 + into))
}

fn schlick(wo: Vec3, wi: Vec3, f0: Rgb) -> Rgb {
    let cosine = (wo + wi).normalize().dot(wi);
    f0 + (Rgb::ONE - f0) * (1.0 - cosine).powi(5)
}

/// The table of `f` above the horizon.
fn table(f: impl Fn(Vec3, Vec3) -> Rgb) -> MeasuredBrdf {
    let above = |wo: Vec3, wi: Vec3| {
        if wo.z > 0.0 && wi.z > 0.0 { f(wo, wi) } else { Rgb::splat(-1.0) }
    };
    MeasuredBrdf::from_fn(COUNTS, above).unwrap()
}

fn best(table: &MeasuredBrdf, model: Option<&str>) -> Fit {
    let fits = fit(table, &Form::of(model.map(|name| name.parse().unwrap()))).unwrap();
    chosen(&fits).unwrap().clone()
}

fn is_near(found: &Fit, rho_d: Rgb, rho_s: Rgb, alpha: f32, relative: f32) {
    let material = &found.material;
    let off = (material.rho_d - rho_d).abs().max_element() / rho_d.max_element().max(1e-3);
    assert!(off < relative, "rho_d {off}: {found:?}");
    let off = (material.rho_s - rho_s).abs().max_element() / rho_s.max_element();
    assert!(off < relative, "rho_s {off}: {found:?}");
    assert!((material.alpha_x / alpha - 1.0).abs() < relative, "{found:?}");
}

#[test]
fn wards_lobe_over_a_base_is_found_among_all_models() {
    for alpha in [0.06, 0.25] {
        let table = table(|wo, wi| RHO_D / PI + RHO_S * ward(wo, wi, alpha));
        let found = best(&table, None);
        assert_eq!(found.form.model.name(), "ward-1992");
        is_near(&found, RHO_D, RHO_S, alpha, 1e-3);
        assert!(found.errors.compressed < 1e-4 && found.errors.linear < 1e-3, "{found:?}");
    }
}

#[test]
fn ggxs_lobe_over_a_base_is_found_among_all_models() {
    for alpha in [0.05, 0.3] {
        let table = table(|wo, wi| RHO_D / PI + RHO_S * ggx(wo, wi, alpha));
        let found = best(&table, None);
        assert_eq!(found.form, Form { model: BrdfModel::Ggx, hypothesis: Hypothesis::Isotropic });
        is_near(&found, RHO_D, RHO_S, alpha, 1e-3);
    }
}

#[test]
fn a_metal_by_schlick_is_one() {
    let f0 = Rgb::new(0.95, 0.64, 0.54);
    let table = table(|wo, wi| schlick(wo, wi, f0) * ggx_apart(wo, wi, 0.2));
    let found = best(&table, Some("principled"));
    assert_eq!(found.form.hypothesis, Hypothesis::Metal);
    // Without the light that is scattered several times, as the closed form is.
    assert_eq!(found.form.model.layering().name(), "coupled");
    is_near(&found, Rgb::ZERO, f0, 0.2, 2e-3);
}

#[test]
fn chalk_has_no_lobe() {
    let table = table(|_, _| RHO_D / PI);
    let found = best(&table, None);
    assert_eq!(found.form.hypothesis, Hypothesis::Diffuse);
    assert!((found.material.rho_d - RHO_D).abs().max_element() < 1e-4);
}

#[test]
fn noise_and_cells_that_were_not_measured_do_not_mislead() {
    // Ten percent of noise by a sequence without pattern, and every seventh cell missing.
    let clean = table(|wo, wi| RHO_D / PI + RHO_S * ggx(wo, wi, 0.15));
    let cells = (0..clean.len()).map(|index| {
        let share = (index as f32 * 0.618_034).fract() - 0.5;
        let value = clean.value(index).unwrap_or(Rgb::splat(-1.0));
        if index % 7 == 3 { Rgb::splat(f32::NAN) } else { value * (1.0 + 0.35 * share) }
    });
    let table = MeasuredBrdf::new(COUNTS, cells.collect()).unwrap();
    let found = best(&table, Some("ggx"));
    is_near(&found, RHO_D, RHO_S, 0.15, 0.03);
    // Uniform noise of a width of 35 % has a standard deviation of 10 %.
    assert!((found.errors.linear - 0.1).abs() < 0.03, "{found:?}");
}

#[test]
fn tables_without_measured_cells_are_refused() {
    let empty = table(|_, _| Rgb::splat(-1.0));
    let problem = fit(&empty, &Form::of(None)).unwrap_err();
    assert!(problem.to_string().contains("only 0 of 2400 cells"), "{problem}");
}

#[test]
fn all_threads_find_the_same_bits() {
    let table = table(|wo, wi| RHO_D / PI + RHO_S * ward(wo, wi, 0.1));
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| fit(&table, &Form::of(Some("ward-gmd".parse().unwrap()))).unwrap())
    };
    assert_eq!(run(1), run(3));
}

#[test]
#[ignore = "takes seconds: a table of the size of MERL's"]
fn a_table_of_full_size_gives_its_numbers_back() {
    let f = |wo: Vec3, wi: Vec3| RHO_D / PI + RHO_S * ggx(wo, wi, 0.03);
    let above = |wo: Vec3, wi: Vec3| {
        if wo.z > 0.0 && wi.z > 0.0 { f(wo, wi) } else { Rgb::splat(-1.0) }
    };
    let table = MeasuredBrdf::from_fn([90, 90, 180], above).unwrap();
    let found = best(&table, None);
    assert_eq!(found.form.model, BrdfModel::Ggx);
    is_near(&found, RHO_D, RHO_S, 0.03, 1e-3);
}
