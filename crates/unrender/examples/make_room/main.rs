//! Makes `examples/room`: a furnished room, its photograph, and the truth about its materials.
//!
//! Run from the root of the workspace:
//!
//! ```text
//! cargo run --release --example make_room [FOLDER [SPP [BRDF [HEIGHT]]]]
//! ```
//!
//! By default the photograph has 1024 samples per pixel and 360 rows, and the lobes are those of `ward-gmd`.
//!
//! It writes the scene as a user would model it (`scene.glb`, all materials grey), the photograph
//! (`photo.png`: 8 bits, sRGB, with the noise of a sensor), the project (`room.toml`), and the
//! materials that the photograph was rendered with (`truth.json` and the textures that it names);
//! and a robot to put into it (`robot.glb`).
//!
//! `room` builds the scene, `robot` the robot, `shapes` their meshes, `rug` the texture; `sensor`
//! takes the photograph.

mod robot;
mod room;
mod rug;
mod sensor;
mod shapes;

use glam::Vec3;
use std::error::Error;
use std::path::{Path, PathBuf};
use unrender::formats::materials::{GroupEntry, MaterialsFile, Status, StatusEntry, VERSION};
use unrender::formats::{atomic, gltf, materials, picture};
use unrender::recover::hypothesis::{self, Hypothesis};
use unrender::render::{Settings, Tracer};
use unrender::scene::{BrdfModel, Group, Material, Rgb, Scene};

/// Scene radiance of a linear pixel value of one, such that only the lamps are clipped.
const EXPOSURE: f32 = 0.65;
/// Another seed than the recovery's, so that both do not make the same errors.
const SEED: u64 = 2002;
const SPP: u32 = 1024;
/// The reflectance of all groups in the scene file.
const GREY: f32 = 0.5;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1);
    let folder = arguments.next().map_or_else(|| PathBuf::from("examples/room"), PathBuf::from);
    let spp = match arguments.next() {
        Some(spp) => spp.to_string_lossy().parse()?,
        None => SPP,
    };
    let brdf = arguments.next().map(|brdf| brdf.to_string_lossy().parse::<BrdfModel>());
    let rows = arguments.next().map(|rows| rows.to_string_lossy().parse::<usize>());
    let rows = rows.transpose()?.unwrap_or(room::SIZE.1);
    let size = (rows * room::SIZE.0 / room::SIZE.1, rows);
    std::fs::create_dir_all(&folder)?;
    let mut scene = room::scene();
    scene.brdf = brdf.transpose()?.unwrap_or(scene.brdf);
    for warning in scene.validate()?.0 {
        eprintln!("warning: {warning}");
    }
    write_truth(&scene, &folder)?;
    write_photo(&scene, &folder, (spp, size))?;
    atomic::write(&folder.join("room.toml"), project(&scene).as_bytes())?;
    scene.groups.iter_mut().filter(|g| !g.is_emitter()).for_each(|group| {
        group.material = Material::diffuse(Rgb::splat(GREY));
    });
    atomic::write(&folder.join("scene.glb"), &gltf::to_glb(&scene)?)?;
    atomic::write(&folder.join("robot.glb"), &gltf::to_glb(&robot::scene())?)?;
    Ok(())
}

fn write_photo(
    scene: &Scene,
    folder: &Path,
    (spp, size): (u32, (usize, usize)),
) -> Result<(), Box<dyn Error>> {
    let settings = Settings { spp, seed: SEED, ..Settings::default() };
    let camera = &scene.cameras[0];
    let materials = scene.materials();
    let film = Tracer::new(scene).render(&materials, camera, size, &settings, &|_| ());
    picture::write(&folder.join("photo.png"), &sensor::expose(&film.mean, EXPOSURE, SEED))?;
    Ok(())
}

fn write_truth(scene: &Scene, folder: &Path) -> Result<(), Box<dyn Error>> {
    let mut file = MaterialsFile {
        version: Some(VERSION),
        brdf: Some(scene.brdf.name().to_owned()),
        exposure: Some([EXPOSURE; 3]),
        ..MaterialsFile::default()
    };
    for (index, group) in scene.groups.iter().enumerate().filter(|(_, g)| !g.is_emitter()) {
        let mut entry = entry(scene, index);
        if let Some(texture) = &group.material.texture {
            let name = format!("truth_{}.png", group.name);
            picture::write_png_srgb(&folder.join(&name), &texture.image)?;
            entry.rho_d = Some(materials::mean_of(&texture.image).to_array());
            entry.texture = Some(name);
        }
        file.groups.insert(group.name.clone(), entry);
    }
    materials::write(&folder.join("truth.json"), &file)?;
    Ok(())
}

fn entry(scene: &Scene, index: usize) -> GroupEntry {
    let Group { name, material, .. } = &scene.groups[index];
    let kind = hypothesis::of(material);
    let known = is_unseen(name);
    GroupEntry {
        hypothesis: Some(kind),
        status: Some(StatusEntry::Of(if known { Status::Known } else { Status::Recovered })),
        rho_d: Some(material.rho_d.to_array()),
        rho_s: Some(material.rho_s.to_array()),
        alpha_x: Some(material.alpha_x),
        alpha_y: Some(material.alpha_y),
        theta_deg: Some(material.theta_rad.to_degrees()),
        direction: (kind == Hypothesis::Anisotropic).then(|| direction(scene, index).to_array()),
        ..GroupEntry::default()
    }
}

/// The anisotropy direction of a flat group whose texture coordinates grow along its first edge.
fn direction(scene: &Scene, group: usize) -> Vec3 {
    let Some(object) = scene.objects.iter().find(|o| o.group == group) else { return Vec3::ZERO };
    let [a, b, _] = object.mesh.corners(0);
    let (tangent, normal) = ((b - a).normalize(), object.mesh.normals[0]);
    let (sin, cos) = scene.groups[group].material.theta_rad.sin_cos();
    cos * tangent + sin * normal.cross(tangent)
}

/// The project file.
fn project(scene: &Scene) -> String {
    let unseen = scene.groups.iter().filter(|group| is_unseen(&group.name));
    let known = unseen.map(|Group { name, material, .. }| {
        let [r, g, b] = material.rho_d.to_array();
        format!("[groups.{name}]\nknown = {{ rho_d = [{r}, {g}, {b}] }}\n")
    });
    format!(
        "\
# A furnished room: diffuse walls, glossy boards, a mirror, a glass table, brushed steel, a rug with
# shadows on it. All files here were made by `cargo run --release --example make_room`.
scene = \"scene.glb\"        # every material grey, as a modeller leaves it
photo = \"photo.png\"
response = \"srgb\"
exposure = {EXPOSURE}            # scene radiance of a linear pixel value of one

# The picture shows next to nothing of the first and nothing of the second.
{known}
[recover]
brdf = \"{brdf}\"
",
        known = known.collect::<String>(),
        brdf = scene.brdf.name(),
    )
}

fn is_unseen(name: &str) -> bool {
    room::UNSEEN.contains(&name)
}
