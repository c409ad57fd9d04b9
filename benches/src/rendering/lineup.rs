//! The renderers of a subject, and those that are not available.

use super::Subject;
use super::contender::{ByMitsuba, ByRadiance, Contender, Ours};
use crate::peers::mitsuba::{self, Lobe, Way};
use crate::peers::{Shot, work_folder};
use crate::{Effort, Failure};
use unrender::scene::{BrdfModel, WardModel};

/// The renderers of a subject.
pub(crate) struct Lineup {
    /// Ours first.
    pub(crate) here: Vec<Box<dyn Contender>>,
    /// Those that are not available, by name.
    pub(crate) missing: Vec<String>,
}

impl Lineup {
    /// Installs and starts them for pictures of `side` x `side` pixels.
    pub(crate) fn new(subject: &Subject, side: usize, effort: Effort) -> Self {
        let scene = &subject.scene;
        let ours = |shared| Box::new(Ours::new(scene, side, effort, shared)) as Box<dyn Contender>;
        let mut lineup = Self { here: vec![ours(true), ours(false)], missing: Vec::new() };
        let shot = Shot { scene, camera: &scene.cameras[0], size: (side, side) };
        for way in ways(scene.brdf) {
            let name = ByMitsuba::name_of(*way);
            let folder = work_folder(&format!("{}-{}", subject.file, name.replace([' ', ','], "")));
            let started = mitsuba::python().map_err(Failure::from);
            let made = started.and_then(|p| ByMitsuba::new(&p, &shot, &folder, *way, effort));
            lineup.add(name, made);
        }
        if let Some(finest) = subject.radiance {
            let folder = work_folder(&format!("{}-radiance", subject.file));
            lineup.add("Radiance".to_owned(), ByRadiance::new(&shot, &folder, finest, effort));
        }
        lineup
    }

    fn add<C: Contender + 'static>(&mut self, name: String, made: Result<C, Failure>) {
        match made {
            Ok(contender) => self.here.push(Box::new(contender)),
            Err(problem) => {
                eprintln!("{name} is not measured: {problem}");
                self.missing.push(name);
            }
        }
    }
}

/// The ways in which Mitsuba renders a scene with this lobe.
fn ways(model: BrdfModel) -> &'static [Way] {
    if model == WardModel::WardGmd.into() {
        &[
            ("llvm_ad_rgb", Lobe::Beckmann, "independent"),
            ("llvm_ad_rgb", Lobe::Beckmann, "multijitter"),
            ("scalar_rgb", Lobe::Beckmann, "independent"),
        ]
    } else {
        // No program has the lobe of 1992, or a similar one.
        &[("llvm_ad_rgb", Lobe::Ward, "independent"), ("llvm_ad_rgb", Lobe::Ward, "multijitter")]
    }
}
