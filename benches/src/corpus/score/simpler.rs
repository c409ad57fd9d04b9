//! Whether a simpler hypothesis counts as right, too, as the photograph cannot distinguish it from
//! the truth.
//!
//! A group's true rendering `T` is compared with the best fit of a simpler hypothesis in the true
//! light. Diffuse: `rho_d D`, with `D` the radiance of a white surface there. Isotropic, for an
//! anisotropic group: `rho_d D + rho_s S(alpha)`, the best over alpha. Both are least squares, weighted
//! by the photograph's noise. The simpler one counts as right if the difference is not significant,
//!
//! `chi^2 = sum (T - simpler)^2 / sigma^2 <= 2 k ln n`,
//!
//! with `n` pixels and `k` fewer parameters (the penalty of the Bayesian information criterion,
//! doubled since pixels with similar values count twice), or if it is within the difference of the
//! renderers: its root mean square is at most [`ALIKE`] of the group's mean.

use glam::DVec3;
use unrender::render::{GlossyLobe, ProbeSettings, Probes, ProposalLobe, Query, Tracer};
use unrender::scene::{Camera, Rgb, Scene};

/// The difference of the renderers' pictures of one scene, as a share of a group's mean: the mean
/// deviation that `corpus --verify` finds.
const ALIKE: f64 = 0.005;
/// The most pixels of a group that are used, spread over all of them.
const PIXELS: usize = 500;
/// The number of roughnesses that are tried for an isotropic fit, evenly in the logarithm between
/// the two.
const ALPHAS: usize = 7;

/// The evidence of the photograph about a group.
pub(crate) struct Observed<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) tracer: &'a Tracer,
    pub(crate) camera: &'a Camera,
    pub(crate) size: (usize, usize),
    pub(crate) group: usize,
    /// The pixels inside the group.
    pub(crate) pixels: &'a [u32],
    /// Standard deviation of the photograph at a radiance.
    pub(crate) noise: &'a dyn Fn(f64) -> f64,
}

/// Whether the hypothesis called `kind` explains the group as well as the truth.
pub(crate) fn explains(seen: &Observed<'_>, kind: &str) -> bool {
    let material = &seen.scene.groups[seen.group].material;
    let brushed = material.is_glossy() && material.alpha_x != material.alpha_y;
    let fewer = match kind {
        "diffuse" if material.rho_s.max_element() > 0.0 && material.texture.is_none() => {
            if material.is_delta() { 3 } else { 4 }
        }
        "isotropic" if brushed => 2,
        _ => return false,
    };
    let step = seen.pixels.len().div_ceil(PIXELS).max(1);
    let pixels: Vec<u32> = seen.pixels.iter().copied().step_by(step).collect();
    let sets = [1, 2].map(|seed| probes(seen, &pixels, seed));
    let truth = sets.each_ref().map(|set| values(set, seen.scene, seen.group));
    let diffuse = sets.each_ref().map(|set| set.probes.iter().map(|p| p.diffuse).collect());
    let mut best = f64::INFINITY;
    let mut least = f64::INFINITY;
    let shapes: Vec<Option<f32>> = match kind {
        "diffuse" => vec![None],
        _ => (0..ALPHAS)
            .map(|i| {
                let share = i as f32 / (ALPHAS - 1) as f32;
                Some(material.alpha_x * (material.alpha_y / material.alpha_x).powf(share))
            })
            .collect(),
    };
    for shape in shapes {
        let specular = shape.map(|alpha| {
            let lobe = GlossyLobe::new(seen.scene.brdf, alpha, alpha);
            sets.each_ref().map(|set| lobes(set, &lobe, 0.0))
        });
        let (chi2, rms) = residual(&truth, &diffuse, specular.as_ref(), seen.noise);
        if chi2 < best {
            (best, least) = (chi2, rms);
        }
    }
    // The used pixels represent all of them.
    let count = seen.pixels.len() as f64;
    best * step as f64 <= 2.0 * f64::from(fewer) * count.ln().max(1.0) || least <= ALIKE
}

fn probes(seen: &Observed<'_>, pixels: &[u32], seed: u64) -> Probes {
    let material = &seen.scene.groups[seen.group].material;
    let (alpha_x, alpha_y) = (material.alpha_x, material.alpha_y);
    let lobe = ProposalLobe { alpha_x, alpha_y, theta_rad: material.theta_rad };
    let settings = ProbeSettings {
        probes_per_pixel: 2,
        cosine: 24,
        per_lobe: if material.is_glossy() { 24 } else { 0 },
        lobes: if material.is_glossy() { vec![lobe] } else { Vec::new() },
        mirror: if material.is_delta() { 6 } else { 0 },
        keep_incident: material.is_glossy(),
        seed,
        ..ProbeSettings::default()
    };
    let materials = seen.scene.materials();
    seen.tracer.probe(seen.camera, seen.size, &Query::new(&materials, pixels, &settings))
}

/// The radiance with the true material at every probe.
fn values(set: &Probes, scene: &Scene, group: usize) -> Vec<Rgb> {
    let material = &scene.groups[group].material;
    let specular = if material.is_glossy() {
        let lobe = GlossyLobe::new(scene.brdf, material.alpha_x, material.alpha_y);
        lobes(set, &lobe, material.theta_rad)
    } else {
        set.probes.iter().map(|probe| probe.mirror).collect()
    };
    let pairs = set.probes.iter().zip(specular);
    pairs.map(|(probe, s)| material.rho_d * probe.diffuse + material.rho_s * s).collect()
}

/// The radiance of a lobe of `rho_s = 1`.
fn lobes(set: &Probes, lobe: &GlossyLobe, theta_rad: f32) -> Vec<Rgb> {
    let turn = |v: glam::Vec3| {
        let (sin, cos) = theta_rad.sin_cos();
        glam::Vec3::new(cos * v.x + sin * v.y, cos * v.y - sin * v.x, v.z)
    };
    let of = |probe| {
        let probe: &unrender::render::Probe = probe;
        let wo = turn(probe.wo);
        set.incident_of(probe).iter().map(|i| lobe.value(wo, turn(i.wi)) * i.irradiance).sum()
    };
    set.probes.iter().map(of).collect()
}

/// Chi^2 and relative root mean square of the best explanation by `diffuse` and `specular`; each
/// product is of two independent sets, so that the probes' noise adds no bias.
fn residual(
    truth: &[Vec<Rgb>; 2],
    diffuse: &[Vec<Rgb>; 2],
    specular: Option<&[Vec<Rgb>; 2]>,
    noise: &dyn Fn(f64) -> f64,
) -> (f64, f64) {
    let count = truth[0].len().min(truth[1].len());
    let (mut chi2, mut squares, mut mean) = (0.0, 0.0, DVec3::ZERO);
    for channel in 0..3 {
        let at = |set: &[Vec<Rgb>; 2], half: usize, i: usize| f64::from(set[half][i][channel]);
        let weight = |i: usize| {
            let level = 0.5 * (at(truth, 0, i) + at(truth, 1, i));
            noise(level).max(1e-9).powi(-2)
        };
        let product = |a: &[Vec<Rgb>; 2], b: &[Vec<Rgb>; 2]| -> f64 {
            let both = |i: usize| 0.5 * (at(a, 0, i) * at(b, 1, i) + at(a, 1, i) * at(b, 0, i));
            (0..count).map(|i| weight(i) * both(i)).sum()
        };
        let (dd, dt) = (product(diffuse, diffuse), product(diffuse, truth));
        let (mut rho_d, mut rho_s) = (if dd > 0.0 { dt / dd } else { 0.0 }, 0.0);
        if let Some(specular) = specular {
            let (ss, ds, st) =
                (product(specular, specular), product(diffuse, specular), product(specular, truth));
            let determinant = dd * ss - ds * ds;
            if determinant > 1e-9 * dd * ss {
                rho_d = (dt * ss - st * ds) / determinant;
                rho_s = (st * dd - dt * ds) / determinant;
            }
        }
        let off = |half: usize, i: usize| {
            let specular = specular.map_or(0.0, |set| rho_s * at(set, half, i));
            at(truth, half, i) - rho_d * at(diffuse, half, i) - specular
        };
        for i in 0..count {
            let square = off(0, i) * off(1, i);
            chi2 += weight(i) * square;
            squares += square;
            mean[channel] += at(truth, 0, i) / count as f64;
        }
    }
    // A camera ray is one sample of a pixel; two make a pixel.
    let level = mean.element_sum() / 3.0;
    let rms = (squares.max(0.0) / (3.0 * count.max(1) as f64)).sqrt();
    (0.5 * chi2, rms / level.max(1e-12))
}
