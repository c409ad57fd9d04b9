//! The folders of the corpus: one for each scene, with its photographs, projects, truth and
//! results.
//!
//! `FAMILY/SEED/`: `scene.glb` and one `scene_DIAL.glb` for each model error, `photo.exr`, `.png` and
//! `.jpg`, one project per format and dial, `truth.json`, `meta.json`, the renderings without noise
//! (`radiance_0.exr`, `radiance_1.exr`: two halves), and `runs/`.

use super::family::{Family, Renderer};
use super::generate::Plan;
use super::spoil::Dial;
use crate::Failure;
use serde::{Deserialize, Serialize};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use unrender::formats::materials::{self, GroupEntry, MaterialsFile, Status, StatusEntry, VERSION};
use unrender::formats::{atomic, gltf, picture};
use unrender::recover::hypothesis::{self, Hypothesis};
use unrender::scene::{Material, Rgb, Scene};

/// The reflectance of unknown groups in the recovery's scenes.
const NEUTRAL: f32 = 0.5;

/// The format of the photograph's file.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, clap::ValueEnum,
)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Format {
    /// Linear radiance.
    Exr,
    /// 8 bits, sRGB.
    Png,
    /// 8 bits, sRGB, compressed at quality 90.
    Jpeg,
}

impl Format {
    /// All of them.
    pub(crate) const ALL: [Self; 3] = [Self::Exr, Self::Png, Self::Jpeg];

    /// The name in file names and on the page.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Exr => "exr",
            Self::Png => "png",
            Self::Jpeg => "jpeg",
        }
    }

    /// The photograph's file.
    pub(crate) fn file(self) -> &'static str {
        match self {
            Self::Exr => "photo.exr",
            Self::Png => "photo.png",
            Self::Jpeg => "photo.jpg",
        }
    }
}

/// The description of a scene's photograph.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Meta {
    /// The version of this corpus' scenes; others are made again.
    pub(crate) version: u32,
    pub(crate) seed: u64,
    pub(crate) family: Family,
    pub(crate) renderer: Renderer,
    pub(crate) brdf: String,
    pub(crate) size: (usize, usize),
    /// Of the scene with its true materials, which the photograph shows.
    #[serde(default)]
    pub(crate) fingerprint: String,
    /// Scene radiance of a linear pixel value of one, for PNG and JPEG.
    pub(crate) exposure: f32,
    /// The noise of the rendering, relative to a pixel, and that of the camera at middle grey.
    pub(crate) rendering_noise: f64,
    pub(crate) camera_noise: f32,
    pub(crate) spp: u32,
    pub(crate) seconds: f64,
}

/// Scenes of other versions differ from those that the code makes now.
pub(crate) const META_VERSION: u32 = 1;

/// The folder of a scene.
#[derive(Clone, Debug)]
pub(crate) struct Folder(pub(crate) PathBuf);

impl Folder {
    /// The folder of `seed`; scenes by a requested renderer have their own folder.
    pub(crate) fn new(out: &Path, family: Family, seed: u64, asked: Option<Renderer>) -> Self {
        let mut name = format!("{seed:04}");
        if let Some(renderer) = asked {
            name = format!("{name}-{}", renderer.name());
        }
        Self(out.join(family.name()).join(name))
    }

    /// A path in it.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// The project of a format and dial.
    pub(crate) fn project(&self, format: Format, dial: Dial) -> PathBuf {
        self.path(&format!("{}_{}.toml", format.name(), dial.name()))
    }

    /// The description of the photograph, if it is complete and of the present version.
    pub(crate) fn meta(&self) -> Option<Meta> {
        let text = std::fs::read_to_string(self.path("meta.json")).ok()?;
        let meta: Meta = serde_json::from_str(&text).ok()?;
        (meta.version == META_VERSION).then_some(meta)
    }

    /// Records that the photograph is complete.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub(crate) fn write_meta(&self, meta: &Meta) -> Result<(), Failure> {
        let text = serde_json::to_string_pretty(meta)? + "\n";
        Ok(atomic::write(&self.path("meta.json"), text.as_bytes())?)
    }
}

/// The fingerprint of a plan: it changes if anything that is photographed changes.
///
/// # Errors
/// If the scene is too large for glTF.
pub(crate) fn fingerprint(plan: &Plan) -> Result<String, Failure> {
    let foreign: Vec<_> = plan.groups.iter().map(|group| &group.foreign).collect();
    let mut hasher = DefaultHasher::new();
    (gltf::to_glb(&plan.scene())?, format!("{foreign:?}")).hash(&mut hasher);
    Ok(format!("{:016x}", hasher.finish()))
}

/// Writes the recovery's scene: all unknown materials are grey.
///
/// # Errors
/// If it cannot be written.
pub(crate) fn write_neutral(path: &Path, scene: &Scene) -> Result<(), Failure> {
    let mut scene = scene.clone();
    scene.groups.iter_mut().filter(|g| !g.is_emitter()).for_each(|group| {
        group.material = Material::diffuse(Rgb::splat(NEUTRAL));
    });
    Ok(atomic::write(path, &gltf::to_glb(&scene)?)?)
}

/// Writes `truth.json` and its textures.
///
/// # Errors
/// If they cannot be written.
pub(crate) fn write_truth(folder: &Folder, plan: &Plan, given: &[usize]) -> Result<(), Failure> {
    let mut file = MaterialsFile {
        version: Some(VERSION),
        brdf: Some(plan.style.brdf.name().to_owned()),
        exposure: Some([1.0; 3]),
        ..MaterialsFile::default()
    };
    for (index, group) in plan.groups.iter().enumerate() {
        let mut entry = entry(&group.material, given.contains(&index));
        if let Some(texture) = &group.material.texture {
            let name = format!("truth_{}.png", group.name);
            picture::write_png_srgb(&folder.path(&name), &texture.image)?;
            entry.texture = Some(name);
        }
        file.groups.insert(group.name.clone(), entry);
    }
    Ok(materials::write(&folder.path("truth.json"), &file)?)
}

fn entry(material: &Material, is_given: bool) -> GroupEntry {
    let kind = match &material.texture {
        Some(_) => Hypothesis::Textured,
        None => hypothesis::of(material),
    };
    GroupEntry {
        hypothesis: Some(kind),
        status: Some(StatusEntry::Of(if is_given { Status::Known } else { Status::Recovered })),
        rho_d: Some(material.rho_d.to_array()),
        rho_s: Some(material.rho_s.to_array()),
        alpha_x: Some(material.alpha_x),
        alpha_y: Some(material.alpha_y),
        theta_deg: Some(material.theta_rad.to_degrees()),
        ..GroupEntry::default()
    }
}

/// The text of a project: photograph, exposure, and the groups that the picture does not show.
pub(crate) fn project(
    plan: &Plan,
    given: &[usize],
    format: Format,
    dial: Dial,
    exposure: f32,
) -> String {
    let (response, exposure) = match format {
        Format::Exr => ("linear", 1.0),
        Format::Png | Format::Jpeg => ("srgb", exposure),
    };
    let mut text = format!(
        "scene = \"{}\"\nphoto = \"{}\"\nresponse = \"{response}\"\nexposure = {exposure}\n\
         camera = \"camera\"\n\n",
        dial.scene_file(),
        format.file()
    );
    for &group in given {
        let m = &plan.groups[group].material;
        let list = |rgb: Rgb| format!("[{}, {}, {}]", rgb.x, rgb.y, rgb.z);
        let mut known = format!("rho_d = {}", list(m.rho_d));
        if m.rho_s.max_element() > 0.0 {
            known += &format!(
                ", rho_s = {}, alpha_x = {}, alpha_y = {}, theta_deg = {}",
                list(m.rho_s),
                m.alpha_x,
                m.alpha_y,
                m.theta_rad.to_degrees()
            );
        }
        text += &format!("[groups.{}]\nknown = {{ {known} }}\n\n", plan.groups[group].name);
    }
    text + &format!("[recover]\nbrdf = \"{}\"\n", plan.style.brdf.name())
}
