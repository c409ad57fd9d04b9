//! Checks whether a photograph agrees with the truth: compares it with our own rendering with the
//! true materials, group by group.

use super::generate::Plan;
use super::photograph::Photograph;
use unrender::render::{Settings, Tracer};
use unrender::scene::{Rgb, RgbImage};

/// Paths per pixel of our own rendering: three seconds at 43 200 pixels on two cores.
const SPP: u32 = 256;
/// Paths per pixel of the command's last picture.
const RERENDERED_SPP: u32 = 64;
/// Groups of fewer inner pixels are not compared.
const LEAST: usize = 40;
/// Differences up to this many of their standard deviations are noise.
const SIGMAS: f64 = 4.0;

/// A group in two pictures.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub(crate) group: String,
    pub(crate) pixels: usize,
    pub(crate) ours: f64,
    pub(crate) theirs: f64,
    /// The difference of the channel where it is largest, over our mean of all channels.
    pub(crate) difference: f64,
    /// Its standard deviation by noise alone.
    pub(crate) deviation: f64,
    /// The difference that is allowed besides noise.
    alike: f64,
}

impl Row {
    /// The row as text.
    pub(crate) fn text(&self) -> String {
        format!(
            "{:14} {:6} {:9.4} {:9.4} {:7.2} % +- {:.2} %{}",
            self.group,
            self.pixels,
            self.ours,
            self.theirs,
            100.0 * self.difference,
            100.0 * self.deviation,
            if self.is_off() { "  OFF" } else { "" }
        )
    }

    /// Whether noise cannot explain the difference.
    pub(crate) fn is_off(&self) -> bool {
        self.difference.abs() > self.alike && self.difference.abs() > SIGMAS * self.deviation
    }
}

/// Our rendering of the plan with its true materials, in two halves.
pub(crate) fn ours(plan: &Plan, spp: u32) -> Photograph {
    let scene = plan.scene();
    let tracer = Tracer::new(&scene);
    let half = |seed: u64| {
        let settings = Settings {
            spp: spp / 2,
            seed,
            integrator: unrender::render::Integrator::Path,
            ..Settings::default()
        };
        tracer.render(&scene.materials(), &plan.cameras[0], plan.size, &settings, &|_| {}).mean
    };
    Photograph { halves: [half(7001), half(7002)], spp }
}

/// Our rendering of the plan with its true materials, with as many paths as the command's last
/// picture has by default.
pub(crate) fn once(plan: &Plan) -> RgbImage {
    let scene = plan.scene();
    let settings = Settings { spp: RERENDERED_SPP, seed: 7003, ..Settings::default() };
    let camera = &plan.cameras[0];
    Tracer::new(&scene).render(&scene.materials(), camera, plan.size, &settings, &|_| {}).mean
}

/// A row for each group with enough pixels.
pub(crate) fn compare(plan: &Plan, photograph: &Photograph) -> Vec<Row> {
    let scene = plan.scene();
    let ours = ours(plan, SPP);
    let (width, height) = plan.size;
    let geometry = Tracer::new(&scene).geometry(&plan.cameras[0], width, height);
    let group_of = |i: usize| geometry.pixels()[i].group as usize;
    let inside =
        |i: &usize| geometry.neighbourhood(*i).all(|beside| group_of(beside) == group_of(*i));
    let mut rows = Vec::new();
    for (index, group) in scene.groups.iter().enumerate() {
        let pixels: Vec<usize> =
            (0..width * height).filter(|&i| group_of(i) == index).filter(inside).collect();
        if pixels.len() < LEAST {
            continue;
        }
        let mean = |picture: &RgbImage| {
            let sum: glam::DVec3 = pixels.iter().map(|&i| picture.pixels()[i].as_dvec3()).sum();
            sum / pixels.len() as f64
        };
        let (our_mean, their_mean) = (mean(&ours.mean()), mean(&photograph.mean()));
        let level = (our_mean.element_sum() / 3.0).max(1e-12);
        let off = (their_mean - our_mean) / level;
        let channel = off.abs().max_position();
        // The difference of the halves has twice the standard deviation of their mean.
        let noise = |photograph: &Photograph| {
            let [a, b] = &photograph.halves;
            let square = |&i: &usize| {
                let difference: Rgb = (a.pixels()[i] - b.pixels()[i]) * 0.5;
                f64::from(difference[channel]).powi(2)
            };
            pixels.iter().map(square).sum::<f64>().sqrt() / pixels.len() as f64
        };
        rows.push(Row {
            group: group.name.clone(),
            pixels: pixels.len(),
            ours: level,
            theirs: their_mean.element_sum() / 3.0,
            difference: off[channel],
            deviation: noise(&ours).hypot(noise(photograph)) / level,
            alike: plan.style.renderer.alike(),
        });
    }
    rows
}
