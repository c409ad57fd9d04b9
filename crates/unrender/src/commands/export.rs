//! `unrender export`: a scene with its materials, for another program.

use crate::commands::render;
use crate::converted::{Conversion, converted};
use crate::edit::{EditSheet, Flag};
use crate::global::Global;
use crate::run::{self, Run};
use crate::{Error, interrupt, job, output, result_folder};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use unrender_formats::export::{self, SceneView, Target};
use unrender_formats::{Input, LightUnits, Limits, gltf, material_file};
use unrender_scene::{Camera, Environment, Group, Material, Scene, WardModel, Warnings};

/// Writes a scene and its materials for another program.
///
/// Radiance has the lobe of ward-gmd, all other programs that of ggx, and Mitsuba and Blender also one
/// that is like ward-gmd (Beckmann's). Materials of another lobe are converted, with a warning that
/// states the error.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    unrender export result --to blender --out room_blender\n  \
    unrender export result --to gltf --out room.glb\n  \
    unrender export result --to usd --out room.usdz\n  \
    unrender export result --to mitsuba --camera door --height 1080 --out room_mitsuba\n  \
    unrender export --scene room.glb --materials truth.json --to radiance --out room_radiance\n  \
    unrender export --scene room.glb --environment 'sky.exr: rotation_deg = 90' --to pbrt --out room_pbrt")]
pub struct Args {
    /// The folder with the results of `recover`.
    #[arg(value_name = "DIR", required_unless_present = "scene", conflicts_with_all = ["scene", "materials"])]
    pub results: Option<PathBuf>,
    /// The scene file, instead of a folder of results.
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    /// Materials to apply to the scene's groups: a file, or a folder with the results of `recover`.
    #[arg(long, value_name = "FILE.json|FILE.mtlx|DIR", requires = "scene")]
    pub materials: Option<PathBuf>,
    /// The units of a glTF file's lights: blender-standard, unitless, blender-raw or radiometric
    /// [default: as its generator writes them].
    #[arg(long, value_name = "UNITS", requires = "scene")]
    pub light_units: Option<LightUnits>,
    /// Light the scene by a panorama instead of its own or the recovered environment:
    /// 'FILE.exr: rotation_deg = 90, scale = 0.5'.
    #[arg(long, value_name = "EDIT")]
    pub environment: Option<String>,
    /// What to write: blender, gltf, materialx, mitsuba, pbrt, radiance or usd.
    #[arg(long, value_name = "FORMAT")]
    pub to: Target,
    /// The folder to write; for gltf the .glb file, for usd the .usda, .usdc or .usdz file. Pictures of FILE.usda and
    /// FILE.usdc go into the folder FILE_textures beside it.
    #[arg(long, value_name = "PATH")]
    pub out: PathBuf,
    /// The camera's name [default: the photograph's, else the scene's first].
    #[arg(long, value_name = "NAME")]
    pub camera: Option<String>,
    /// Pixels in a row [default: the photograph's, else by the height and the camera's aspect].
    #[arg(long, value_name = "N")]
    pub width: Option<usize>,
    /// Rows [default: the photograph's, else by the width and the camera's aspect].
    #[arg(long, value_name = "N")]
    pub height: Option<usize>,
}

/// Runs the command.
///
/// # Errors
/// If the input cannot be used or the export cannot be written.
pub fn run(args: &Args, global: &Global) -> Result<ExitCode, Error> {
    export::check_path(&args.out, args.to)?;
    check_inputs(args)?;
    let (scene, camera, size, warnings) = input(args, global)?;
    let light_units = light_units(args, global.limits())?;
    global.console.warn(&warnings);
    let (expressed, mut doubts) = expressed(&scene, args.to);
    let conversions = converted(&expressed, &camera, size, args.to.lobe(scene.brdf));
    if !global.quiet {
        tell(&expressed, &conversions, global);
    }
    let is_bent = |(group, c): (&Group, &Conversion)| c.material != group.material;
    if scene.brdf == WardModel::Ward1992.into()
        && expressed.groups.iter().zip(&conversions).any(is_bent)
    {
        doubts.push(
            "the lobe of ward-1992 reflects less at grazing angles, as in no other program; to \
             export, recover with brdf = \"ward-gmd\"",
        );
    }
    let materials: Vec<Material> = conversions.into_iter().map(|c| c.material).collect();
    let shot =
        SceneView { scene: &scene, materials: &materials, camera: &camera, size, light_units };
    let (files, noted) = export::export(&shot, args.to, &args.out)
        .map_err(|problem| Error::Request(format!("the scene cannot be exported: {problem}")))?;
    doubts.extend(noted);
    global.console.warn(&doubts);
    let _until_written = interrupt::writing();
    export::write(&args.out, args.to, &files)?;
    if !global.quiet {
        global.console.print(&(args.to.next_step(&args.out) + "\n"));
    }
    Ok(ExitCode::SUCCESS)
}

/// The scene with those reflectances that an export for `target` has words for.
fn expressed(scene: &Scene, target: Target) -> (Scene, Warnings) {
    let mut expressed = scene.clone();
    let mut freed = Vec::new();
    for group in &mut expressed.groups {
        if !target.keeps(group.material.reflectance) {
            group.material = group.material.clone().freed();
            freed.push(group.name.as_str());
        }
    }
    let mut doubts = Warnings::default();
    if !freed.is_empty() {
        doubts.push(format!(
            "{target} gets the reflectance at normal incidence for all angles, without Fresnel's rise at grazing ones, of: {}",
            freed.join(", ")
        ));
    }
    (expressed, doubts)
}

/// Checks before the work that no input is replaced.
fn check_inputs(args: &Args) -> Result<(), Error> {
    let of_results = |name: &str| args.results.as_ref().map(|folder| folder.join(name));
    let around = environment_sheet(args)?.map_or_else(Vec::new, |sheet| sheet.inputs());
    let named = [args.scene.clone(), args.materials.clone(), of_results("scene.glb")];
    let inputs: Vec<PathBuf> = named.into_iter().flatten().chain(around).collect();
    output::check_inputs(&args.out, inputs.iter().map(PathBuf::as_path))
}

/// Prints on stderr how lobes were converted that the target does not have.
fn tell(scene: &Scene, conversions: &[Conversion], global: &Global) {
    for (group, conversion) in scene.groups.iter().zip(conversions) {
        let (from, to) = (&group.material, &conversion.material);
        if from == to {
            continue;
        }
        let alphas = |m: &Material| format!("alpha {:.4} {:.4}", m.alpha_x, m.alpha_y);
        global.console.tell(&format!(
            "{}: {} of {} became {}, rho_s {:.4} times; over the lobe the reflected radiance is \
             {:.1} % off, and {:.1} % of it is kept",
            group.name,
            alphas(from),
            scene.brdf,
            alphas(to),
            to.rho_s.max_element() / from.rho_s.max_element(),
            100.0 * conversion.difference,
            100.0 * conversion.albedo
        ));
    }
}

fn scene_path(args: &Args) -> PathBuf {
    let of_results = args.results.as_ref().map(|folder| folder.join("scene.glb"));
    of_results.or_else(|| args.scene.clone()).unwrap_or_default()
}

/// The units of the lights in the glTF file to write: those of the file that was read, so that the
/// program that wrote that one reads the same lights.
fn light_units(args: &Args, limits: Limits) -> Result<LightUnits, Error> {
    let path = scene_path(args);
    let is_gltf = path.extension().is_some_and(|extension| {
        ["glb", "gltf"].iter().any(|known| extension.eq_ignore_ascii_case(known))
    });
    if args.to != Target::Gltf || !is_gltf {
        return Ok(LightUnits::Radiometric);
    }
    Ok(gltf::light_units(Input::new(&path, limits).in_light_units(args.light_units))?)
}

/// The scene with its materials, the camera, and the size of its picture.
fn input(args: &Args, global: &Global) -> Result<(Scene, Camera, (usize, usize), Warnings), Error> {
    let path = scene_path(args);
    let (scene, mut warnings) = scene(args, global, &path)?;
    let run = args.results.as_ref().map(|folder| folder.join(Run::FILE));
    let run = run.filter(|_| args.camera.is_none());
    let used = run.as_deref().map(run::recovered_camera).transpose()?.flatten();
    let size = run.as_deref().map(run::recovered_size).transpose()?.flatten();
    let camera = match used {
        Some(table) => table.camera("photograph", scene.origin),
        None => {
            let (camera, noted) = job::named_camera(&scene, args.camera.as_deref(), &path)?;
            warnings.extend(noted);
            camera
        }
    };
    let size = match (size, args.width, args.height) {
        (Some(size), None, None) => size,
        (_, width, height) => render::size(width, height, &camera)?,
    };
    Ok((scene, camera, size, warnings))
}

/// The scene with its materials and its environment: the one that is stated, else that of the recovery, else its own.
fn scene(args: &Args, global: &Global, path: &Path) -> Result<(Scene, Warnings), Error> {
    let limits = global.limits();
    let materials = args.results.as_deref().or(args.materials.as_deref());
    let materials = materials.map(result_folder::materials).transpose()?;
    let source = Input::new(path, limits).in_light_units(args.light_units);
    let (mut scene, mut warnings) = match &global.scene {
        Some(scene) => (Scene::clone(scene), Warnings::default()),
        // It may have no light: materials and meshes have a use without.
        None => unrender_formats::load_model(source)?,
    };
    let run = args.results.as_ref().map(|folder| folder.join(Run::FILE));
    scene.up = run.as_deref().map(run::recovered_up).transpose()?.unwrap_or_default();
    let up = scene.up;
    let stated = stated_environment(args, limits)?;
    let folder = args.results.as_deref().filter(|_| stated.is_none());
    let around = folder.map(|folder| run::recovered_environment(folder, limits)).transpose()?;
    let around = around.unwrap_or_default();
    warnings.extend(around.warnings);
    let own = scene.environment.take();
    scene.environment = around.environment.map(|around| around.with_up(up)).or(own);
    if let Some(materials) = materials {
        warnings.extend(material_file::apply(Input::new(&materials, limits), &mut scene)?);
    }
    if let Some((environment, noted)) = stated {
        scene.environment = environment.map(|around| around.with_up(up));
        warnings.extend(noted);
    }
    warnings.extend(job::validate_meshes(&mut scene, path)?);
    if let Some(environment) = around.lacking {
        warnings.push(format!(
            "the recovery had an environment ({environment}), which its older results do not hold and this export \
             lacks: recover again, or state it by --environment"
        ));
    }
    if let Some(folder) = folder.filter(|_| !args.to.has_environments()) {
        let panorama = Some(folder.join(run::PANORAMA)).filter(|panorama| panorama.exists());
        warnings.0.extend(panorama.map(|panorama| {
            format!(
                "the recovered environment is {}; this format does not hold it",
                panorama.display()
            )
        }));
    }
    Ok((scene, warnings))
}

/// The environment that is stated on the command line, and warnings of its panorama.
fn stated_environment(
    args: &Args,
    limits: Limits,
) -> Result<Option<(Option<Environment>, Warnings)>, Error> {
    let sheet = environment_sheet(args)?;
    sheet.map(|sheet| sheet.within(limits).environment()).transpose()
}

fn environment_sheet(args: &Args) -> Result<Option<EditSheet>, Error> {
    let stated = args.environment.as_deref();
    stated.map(|value| EditSheet::of_flag(Flag::Environment, value)).transpose()
}
