//! The tiny scenes of `examples/corpus`, for the tests: `corpus --tiny --out examples/corpus`.
//!
//! Each is from the first seed that shows the material of its name in plain view, by the renderer of
//! its name, with few groups and small files.

use super::family::{Family, Renderer, Style};
use super::generate::{self, Plan};
use super::make;
use super::photograph::{self, SampleBudget};
use super::spoil::Dial;
use super::store::{self, Folder, Format};
use super::verify;
use crate::Failure;
use std::path::Path;
use unrender::formats::{atomic, gltf, picture};
use unrender::scene::{BrdfModel, WardModel};

/// A scene to be found.
struct Wanted {
    name: &'static str,
    family: Family,
    renderer: Renderer,
    brdf: BrdfModel,
    format: Format,
    size: (usize, usize),
    /// The property that one of its groups must have.
    shows: fn(&generate::PlannedGroup) -> bool,
}

const WARD: BrdfModel = BrdfModel::Ward(WardModel::WardGmd);
/// Linear pictures take 12 bytes per pixel, so they are smaller.
const LINEAR: (usize, usize) = (80, 60);
const CODED: (usize, usize) = (96, 72);
/// Sides of round things.
const SEGMENTS: u32 = 20;
/// The least number of pixels inside the group of the scene's name, and in all other groups.
const SHOWN: usize = 260;
const SEEN: usize = 60;
/// The largest file, bytes.
const BYTES: usize = 60_000;
/// Groups besides lamps.
const GROUPS: std::ops::RangeInclusive<usize> = 4..=8;
/// The rendering's noise of a pixel, and the most samples.
const BUDGET: SampleBudget = SampleBudget { noise: 0.01, spp_max: 512 };
/// Seeds that are tried.
const SEEDS: u64 = 4000;

fn all() -> [Wanted; 6] {
    use Family::{Foreign, InModel};
    use Renderer::{Cycles, Mitsuba, Radiance};
    let wanted = |name, family, renderer, brdf, format, shows| {
        let size = if format == Format::Exr { LINEAR } else { CODED };
        Wanted { name, family, renderer, brdf, format, size, shows }
    };
    [
        wanted("anisotropic", InModel, Mitsuba, WARD, Format::Exr, |group| {
            let m = &group.material;
            m.is_glossy() && m.alpha_y > 1.5 * m.alpha_x && m.rho_s.max_element() > 0.2
        }),
        wanted("textured", InModel, Mitsuba, BrdfModel::Ggx, Format::Png, |group| {
            group.material.texture.is_some()
        }),
        wanted("mirror", InModel, Cycles, BrdfModel::Ggx, Format::Exr, |group| {
            group.material.is_pure_mirror()
        }),
        wanted("principled", Foreign, Cycles, BrdfModel::Ggx, Format::Png, |group| {
            matches!(group.foreign, Some(generate::Foreign::Principled { metallic: 1.0, .. }))
        }),
        wanted("plastic", Foreign, Mitsuba, WARD, Format::Jpeg, |group| {
            matches!(group.foreign, Some(generate::Foreign::Plastic { .. }))
        }),
        wanted("isotropic", InModel, Radiance, WARD, Format::Png, |group| {
            let m = &group.material;
            m.is_glossy() && m.alpha_x == m.alpha_y && m.rho_s.max_element() > 0.1
        }),
    ]
}

/// Makes the scenes that do not exist yet.
///
/// # Errors
/// If a renderer is not available, no seed fits, or a file cannot be written.
pub(crate) fn make(out: &Path) -> Result<(), Failure> {
    for wanted in all() {
        let folder = Folder(out.join(wanted.name));
        if folder.path("project.toml").exists() {
            continue;
        }
        let plan = find(&wanted)?;
        std::fs::create_dir_all(&folder.0)?;
        write(&wanted, &plan, &folder)?;
    }
    Ok(())
}

/// The plan of the first seed that fits.
fn find(wanted: &Wanted) -> Result<Plan, Failure> {
    let &Wanted { family, renderer, brdf, size, .. } = wanted;
    let fits = |plan: &Plan| {
        GROUPS.contains(&plan.groups.len()) && {
            let inner = plan.inner_pixels();
            let named = plan.groups.iter().enumerate();
            let shown = named.clone().any(|(i, group)| (wanted.shows)(group) && inner[i] >= SHOWN);
            let seen = named.filter(|(i, _)| inner[*i] >= SEEN).count();
            let small = gltf::to_glb(&plan.scene()).is_ok_and(|bytes| bytes.len() < BYTES);
            // Cycles samples many triangles on the far side of a round lamp, which causes noise.
            let quiet = renderer != Renderer::Cycles
                || plan.lights.lamps.iter().all(|lamp| lamp.ball.is_none());
            quiet && shown && seen + 1 >= plan.groups.len() && small
        }
    };
    (0..SEEDS)
        .map(|seed| generate::plan(seed, Style { family, renderer, brdf }, size, SEGMENTS))
        .find(fits)
        .ok_or_else(|| format!("no seed below {SEEDS} makes the scene {}", wanted.name).into())
}

fn write(wanted: &Wanted, plan: &Plan, folder: &Folder) -> Result<(), Failure> {
    let work = std::env::temp_dir().join(format!("unrender-corpus-{}", std::process::id()));
    // Radiance takes minutes where the others take seconds.
    let is_slow = plan.style.renderer == Renderer::Radiance;
    let budget = if is_slow { SampleBudget { noise: 0.02, spp_max: 256 } } else { BUDGET };
    let (scene, renderer) = (plan.scene(), plan.style.renderer);
    let taken = photograph::take(plan, &scene, &plan.cameras[0], renderer, budget, &work)?;
    let _ = std::fs::remove_dir_all(&work);
    let rows = verify::compare(plan, &taken);
    let noise = 100.0 * taken.noise();
    eprintln!("{}: seed {}, {noise:.1} % noise, {} spp", wanted.name, plan.seed, taken.spp);
    rows.iter().for_each(|row| eprintln!("  {}", row.text()));
    if wanted.family == Family::InModel && rows.iter().any(verify::Row::is_off) {
        return Err(format!("{}: the photograph does not agree with its truth", wanted.name).into());
    }
    let radiance = taken.mean();
    let exposure = make::exposure(plan, &radiance);
    let photo = folder.path(wanted.format.file());
    match wanted.format {
        Format::Exr => picture::write_exr(&photo, &radiance).map(|_| ())?,
        Format::Png => {
            picture::write_png_srgb(&photo, &radiance.map(|v| *v / exposure)).map(|_| ())?;
        }
        Format::Jpeg => atomic::write(&photo, &make::jpeg(&radiance, exposure)?)?,
    }
    let given = plan.given();
    store::write_truth(folder, plan, &given)?;
    store::write_neutral(&folder.path("scene.glb"), &scene)?;
    let head = format!(
        "# A scene of the corpus (docs/validation/corpus.md), seed {}, photographed by {}. Made by\n\
         # `cargo run --release -p unrender-benches -- corpus --tiny --out examples/corpus`.\n",
        plan.seed,
        renderer.name()
    );
    let text = store::project(plan, &given, wanted.format, Dial::Exact, exposure);
    atomic::write(&folder.path("project.toml"), (head + &text).as_bytes())?;
    Ok(())
}
