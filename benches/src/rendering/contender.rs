//! The renderers, each with its settings.

use crate::peers::Shot;
use crate::peers::mitsuba::{self, Lobe, Mitsuba, Way};
use crate::peers::radiance::{Radiance, Setting};
use crate::{Effort, Failure};
use std::path::Path;
use std::time::Instant;
use unrender::render::{Settings, Tracer};
use unrender::scene::{Camera, Material, RgbImage, Scene};

/// A renderer with a scene.
pub(crate) trait Contender {
    fn name(&self) -> String;
    fn version(&self) -> String;
    /// The name of the picture to which it converges.
    fn truth(&self) -> String;
    /// The largest allowed ratio of our RMSE to its RMSE.
    fn goal(&self) -> f64;
    /// From fast to slow.
    fn settings(&self) -> Vec<String>;
    /// Whether the first picture of a setting takes longer than the next.
    fn compiles(&self) -> bool;
    /// A picture and the seconds that it took.
    fn render(&mut self, setting: usize, seed: u32) -> Result<(RgbImage, f64), Failure>;
    /// A picture with much less noise.
    fn converged(&mut self, seed: u32) -> Result<RgbImage, Failure>;
}

/// The program unrender, with paths that pixels share, as by default, or with independent ones.
pub(crate) struct Ours {
    shared: bool,
    tracer: Tracer,
    materials: Vec<Material>,
    camera: Camera,
    side: usize,
    effort: Effort,
}

impl Ours {
    pub(crate) fn new(scene: &Scene, side: usize, effort: Effort, shared: bool) -> Self {
        Self {
            shared,
            tracer: Tracer::new(scene),
            materials: scene.materials(),
            camera: scene.cameras[0].clone(),
            side,
            effort,
        }
    }

    fn spp(&self) -> &'static [u32] {
        match self.shared {
            true => self.effort.pick(&[2, 8], &[2, 8, 32]),
            false => self.effort.pick(&[4, 16], &[4, 16, 64]),
        }
    }

    fn picture(&self, spp: u32, seed: u32, shared: bool) -> RgbImage {
        let settings = Settings {
            spp,
            seed: u64::from(seed),
            integrator: unrender::render::Integrator::with_path_reuse(shared),
            ..Settings::default()
        };
        let size = (self.side, self.side);
        self.tracer.render(&self.materials, &self.camera, size, &settings, &|_| ()).mean
    }
}

impl Contender for Ours {
    fn name(&self) -> String {
        if self.shared { "unrender" } else { "unrender, `--independent`" }.to_owned()
    }

    fn version(&self) -> String {
        String::new()
    }

    fn truth(&self) -> String {
        "unrender".to_owned()
    }

    fn goal(&self) -> f64 {
        f64::NAN
    }

    fn settings(&self) -> Vec<String> {
        self.spp().iter().map(|spp| format!("{spp} spp")).collect()
    }

    fn compiles(&self) -> bool {
        false
    }

    fn render(&mut self, setting: usize, seed: u32) -> Result<(RgbImage, f64), Failure> {
        let started = Instant::now();
        let picture = self.picture(self.spp()[setting], seed, self.shared);
        Ok((picture, started.elapsed().as_secs_f64()))
    }

    fn converged(&mut self, seed: u32) -> Result<RgbImage, Failure> {
        Ok(self.picture(self.effort.pick(64, 512), seed, true))
    }
}

/// Mitsuba 3 in one variant, with one lobe and one sampler.
pub(crate) struct ByMitsuba {
    mitsuba: Mitsuba,
    way: Way,
    effort: Effort,
}

impl ByMitsuba {
    pub(crate) fn new(
        python: &Path,
        shot: &Shot,
        folder: &Path,
        way: Way,
        effort: Effort,
    ) -> Result<Self, Failure> {
        let (variant, lobe, sampler) = way;
        let scene = mitsuba::write(shot, folder, lobe, sampler)?;
        Ok(Self { mitsuba: Mitsuba::load(python, variant, &scene)?, way, effort })
    }

    /// The name of a way to render with it.
    pub(crate) fn name_of((variant, lobe, sampler): Way) -> String {
        let lobe = if lobe == Lobe::Ward { "ward" } else { "beckmann" };
        format!("Mitsuba {variant}, {lobe}, {sampler}")
    }

    /// Square numbers, as `multijitter` needs; few for the slow variant.
    fn spp(&self) -> &'static [u32] {
        let quick = self.effort == Effort::Quick || self.way.0 == "scalar_rgb";
        if quick { &[4, 16] } else { &[16, 64] }
    }
}

impl Contender for ByMitsuba {
    fn name(&self) -> String {
        Self::name_of(self.way)
    }

    fn version(&self) -> String {
        self.mitsuba.version()
    }

    fn truth(&self) -> String {
        format!("Mitsuba, {:?}", self.way.1)
    }

    fn goal(&self) -> f64 {
        0.5
    }

    fn settings(&self) -> Vec<String> {
        self.spp().iter().map(|spp| format!("{spp} spp")).collect()
    }

    fn compiles(&self) -> bool {
        self.way.0 != "scalar_rgb"
    }

    fn render(&mut self, setting: usize, seed: u32) -> Result<(RgbImage, f64), Failure> {
        self.mitsuba.render(self.spp()[setting], seed)
    }

    fn converged(&mut self, seed: u32) -> Result<RgbImage, Failure> {
        // Rendered in parts that fit into memory.
        let (parts, spp) = self.effort.pick((1, 64), (8, 72));
        let mut sum: Option<RgbImage> = None;
        for part in 0..parts {
            let (picture, _) = self.mitsuba.render(spp, 1000 * (seed % 1000) + part)?;
            sum = Some(match sum {
                None => picture,
                Some(sum) => added(&sum, &picture),
            });
        }
        let sum = sum.ok_or("no part was rendered")?;
        Ok(sum.map(|value| *value / parts as f32))
    }
}

/// The sum, pixel by pixel.
fn added(a: &RgbImage, b: &RgbImage) -> RgbImage {
    RgbImage::from_fn(a.width(), a.height(), |x, y| *a.at(x, y) + *b.at(x, y))
}

/// Radiance's settings, from fast to slow: with irradiance caching, and with paths alone.
const SETTINGS: [Setting; 5] = [
    Setting { finer: 2, options: "-ab 3 -aa .2 -ad 128 -as 32 -ar 64 -ss 1 -lr 6 -lw 1e-3" },
    Setting { finer: 4, options: "-ab 3 -aa .2 -ad 128 -as 32 -ar 64 -ss 1 -lr 6 -lw 1e-3" },
    Setting { finer: 4, options: "-ab 4 -aa .15 -ad 256 -as 64 -ar 128 -ss 1 -lr 8 -lw 1e-4" },
    Setting { finer: 2, options: "-ab 24 -aa 0 -ad 4 -as 0 -ss 1 -lr -8 -lw 1e-3" },
    Setting { finer: 4, options: "-ab 24 -aa 0 -ad 4 -as 0 -ss 1 -lr -8 -lw 1e-3" },
];
/// As in `render.sh` of the export: paths that end by Russian roulette, no caching.
const CONVERGED: &str = "-ab 24 -aa 0 -ad 8 -as 0 -ss 6 -lr -30 -lw 1e-5";

/// Radiance.
pub(crate) struct ByRadiance {
    radiance: Radiance,
    /// Rays in a row of a pixel, in the picture to which it converges.
    finest: usize,
    effort: Effort,
}

impl ByRadiance {
    pub(crate) fn new(
        shot: &Shot,
        folder: &Path,
        finest: usize,
        effort: Effort,
    ) -> Result<Self, Failure> {
        Ok(Self { radiance: Radiance::load(shot, folder)?, finest, effort })
    }

    fn chosen(&self) -> &'static [Setting] {
        self.effort.pick(&SETTINGS[..2], &SETTINGS)
    }
}

impl Contender for ByRadiance {
    fn name(&self) -> String {
        "Radiance".to_owned()
    }

    fn version(&self) -> String {
        self.radiance.version()
    }

    fn truth(&self) -> String {
        "Radiance".to_owned()
    }

    fn goal(&self) -> f64 {
        0.25
    }

    fn settings(&self) -> Vec<String> {
        let name = |s: &Setting| format!("{0} x {0}, `{1}`", s.finer, s.options);
        self.chosen().iter().map(name).collect()
    }

    fn compiles(&self) -> bool {
        false
    }

    fn render(&mut self, setting: usize, _seed: u32) -> Result<(RgbImage, f64), Failure> {
        self.radiance.render(self.chosen()[setting])
    }

    fn converged(&mut self, _seed: u32) -> Result<RgbImage, Failure> {
        // Its random numbers change every second.
        std::thread::sleep(std::time::Duration::from_secs(1));
        Ok(self.radiance.render(Setting { finer: self.finest, options: CONVERGED })?.0)
    }
}
