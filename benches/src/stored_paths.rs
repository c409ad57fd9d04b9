//! Measures the cost of stored paths: `cargo run --release --bin performance -- stored`.
//!
//! Each scene's picture is traced with all derivatives, its paths are recorded, and both are replayed. The
//! columns are seconds of each, and the speedup of a replay over the computation that it replaces: a rendering
//! for radiance, a traced Jacobian for derivatives. The replayed radiance must equal the traced one except for
//! rounding.

use crate::noise::cases;
use crate::noise::measure::Shot;
use crate::statistics::geometric_mean;
use crate::{Failure, machine};
use clap::Args;
use std::path::PathBuf;
use std::time::Instant;
use unrender::render::{Integrator, Parameter, Query, Settings, Tracer};
use unrender::scene::{Material, Rgb};

/// The largest difference of a replayed radiance from the traced one, as a share of the picture's mean: single
/// precision of paths of a hundred times the mean. At half of it rounding alone may exceed it, at double a wrong
/// factor on dim paths passes.
const ROUNDING: f64 = 1e-4;

/// Measures stored paths: the cost of recording and replaying them, beside that of tracing them.
#[derive(Args)]
pub(crate) struct StoredRequest {
    /// The scenes by name, as for `noise` [default: all available ones].
    #[arg(value_name = "CASES")]
    cases: Vec<String>,
    /// Paths per pixel.
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..))]
    spp: u32,
    /// A folder of scenes of the corpus.
    #[arg(long, value_name = "DIR")]
    corpus: Option<PathBuf>,
}

/// The seconds of each step, and the size of the stored paths.
struct Cost {
    parameters: usize,
    tracing: [f64; 2],
    recording: f64,
    replaying: [f64; 2],
    bytes: usize,
    paths: usize,
}

/// Measures one scene after the other.
///
/// # Errors
/// If a scene cannot be loaded, or the replay differs.
pub(crate) fn run(request: &StoredRequest) -> Result<(), Failure> {
    let chosen = cases::choose(cases::all(request.corpus.as_deref())?, &request.cases)?;
    println!("{}", machine::origin());
    println!(
        "{:20} {:>10} {:>10} {:>10} {:>10} {:>10} {:>10} {:>8} {:>8} {:>8} {:>8}",
        "scene",
        "parameters",
        "picture s",
        "Jacobian s",
        "record s",
        "replay s",
        "replay J s",
        "times",
        "times J",
        "MB",
        "B/path"
    );
    let mut gains = [Vec::new(), Vec::new()];
    for case in &chosen {
        let in_case = |problem: Failure| -> Failure { format!("{}: {problem}", case.name).into() };
        let shot = case.load().map_err(in_case)?;
        let cost = measure(&shot, request.spp).map_err(in_case)?;
        let times = [0, 1].map(|way| cost.tracing[way] / cost.replaying[way]);
        gains.iter_mut().zip(times).for_each(|(gains, times)| gains.push(times));
        println!(
            "{:20} {:10} {:10.2} {:10.2} {:10.2} {:10.3} {:10.3} {:8.1} {:8.1} {:8.0} {:8.0}",
            case.name,
            cost.parameters,
            cost.tracing[0],
            cost.tracing[1],
            cost.recording,
            cost.replaying[0],
            cost.replaying[1],
            times[0],
            times[1],
            cost.bytes as f64 / 1e6,
            cost.bytes as f64 / cost.paths as f64,
        );
    }
    let [radiance, jacobian] = gains.map(geometric_mean);
    println!(
        "summary: {} scenes; a replay of radiance is {radiance:.1} times as fast as tracing it, of derivatives \
         {jacobian:.1} times",
        chosen.len()
    );
    Ok(())
}

/// Measures a scene.
fn measure(shot: &Shot, spp: u32) -> Result<Cost, Failure> {
    let tracer = Tracer::try_new(&shot.scene)?;
    let materials = shot.scene.materials();
    let settings = Settings { spp, integrator: Integrator::Path, ..Settings::default() };
    let (width, height) = shot.size;
    let pixels: Vec<u32> = (0..(width * height) as u32).collect();
    let parameters = parameters(&materials);
    let (camera, size) = (&shot.camera, shot.size);

    let (_, picture) = timed(|| tracer.render_pixels(&materials, camera, size, &pixels, &settings));
    let (traced, jacobian) = timed(|| {
        tracer.jacobian(
            camera,
            size,
            &Query { parameters: &parameters, ..Query::new(&materials, &pixels, &settings) },
        )
    });
    let (stored, recording) = timed(|| {
        tracer.store(
            camera,
            size,
            &Query { parameters: &parameters, ..Query::new(&materials, &pixels, &settings) },
        )
    });
    let (replayed, replay) = timed(|| stored.replay(&tracer, &materials, &[], None));
    let (_, replay_jacobian) = timed(|| stored.replay(&tracer, &materials, &parameters, None));

    let traced = traced.radiance;
    let mean = traced.iter().map(|radiance| radiance.as_dvec3().element_sum()).sum::<f64>()
        / (3 * pixels.len()) as f64;
    let is_same = |(traced, replayed): (&Rgb, &Rgb)| {
        let off = f64::from((*traced - *replayed).abs().max_element());
        replayed.is_finite() && off <= ROUNDING * mean
    };
    if !traced.iter().zip(&replayed.radiance).all(is_same) {
        return Err("a replayed radiance differs from the traced one".into());
    }
    Ok(Cost {
        parameters: parameters.len(),
        tracing: [picture, jacobian],
        recording,
        replaying: [replay, replay_jacobian],
        bytes: stored.bytes(),
        paths: pixels.len() * spp as usize,
    })
}

/// All parameters of these materials that a recovery can determine.
fn parameters(materials: &[Material]) -> Vec<Parameter> {
    let of_group = |(material, group): (&Material, u32)| {
        let mut all = vec![Parameter::RhoD(group)];
        if material.rho_s.max_element() > 0.0 {
            all.push(Parameter::RhoS(group));
        }
        if material.is_glossy() {
            all.extend([Parameter::AlphaX(group), Parameter::AlphaY(group)]);
            all.extend((material.alpha_x != material.alpha_y).then_some(Parameter::Theta(group)));
        }
        all
    };
    materials.iter().zip(0..).flat_map(of_group).collect()
}

/// The result of `work`, and the seconds that it takes.
fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let started = Instant::now();
    let made = work();
    (made, started.elapsed().as_secs_f64())
}
