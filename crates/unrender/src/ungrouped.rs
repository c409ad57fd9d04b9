//! Which pixels of a photograph show shapes that belong to no group: glass, through which the recovery does not look, and
//! what the project ignores.

use crate::Job;
use unrender_render::{GeometryBuffers, Tracer};
use unrender_scene::{Camera, Group, Image, Material, Object, Rgb, Scene, Ungrouped};

/// How far beyond their outlines pixels are left out, pixels: those mix both sides. Without it, the rims of glasses
/// count; twice as much leaves out thin things beside them.
const RIM: usize = 1;

/// The shapes of a scene that belong to no group.
struct UngroupedShapes {
    tracer: Tracer,
}

impl UngroupedShapes {
    /// Those of `scene`; none if it has no such shapes.
    fn of(scene: &Scene) -> Option<Self> {
        let names = scene.ungrouped_materials();
        let group = |name: &&str| {
            let (name, material) = ((*name).to_owned(), Material::diffuse(Rgb::ZERO));
            Group { name, material, emission: Rgb::ZERO }
        };
        let object = |shape: &Ungrouped| Object {
            name: shape.material.clone(),
            group: names.iter().position(|name| *name == shape.material).unwrap_or(0),
            mesh: shape.mesh.clone(),
        };
        let alone = Scene {
            groups: names.iter().map(group).collect(),
            objects: scene.ungrouped.iter().map(object).collect(),
            ..Scene::default()
        };
        // Without triangles there is nothing to trace.
        let tracer = (alone.triangle_count() > 0).then(|| Tracer::try_new(&alone).ok());
        Some(Self { tracer: tracer.flatten()? })
    }

    /// For each pixel of `geometry`, as `camera` sees it, the material of such a shape before it.
    fn seen(&self, camera: &Camera, geometry: &GeometryBuffers) -> Image<Option<u32>> {
        let clear = self.tracer.geometry(camera, geometry.width(), geometry.height());
        let pairs = clear.pixels().iter().zip(geometry.pixels());
        let is_before =
            pairs.map(|(clear, behind)| (clear.depth < behind.depth).then_some(clear.group));
        let before = Image::new(geometry.width(), geometry.height(), is_before.collect());
        Image::from_fn(geometry.width(), geometry.height(), |x, y| {
            let around = |at: usize, side: usize| at.saturating_sub(RIM)..(at + RIM + 1).min(side);
            let rows = around(y, geometry.height());
            let mut near = rows.flat_map(|y| around(x, geometry.width()).map(move |x| (x, y)));
            before.at(x, y).or_else(|| near.find_map(|(x, y)| *before.at(x, y)))
        })
    }
}

/// For each pixel of `geometry`, as `camera` sees it, whether such a shape is before it; none if the scene has no such
/// shapes.
pub(crate) fn covered(
    scene: &Scene,
    camera: &Camera,
    geometry: &GeometryBuffers,
) -> Option<Vec<bool>> {
    let seen = UngroupedShapes::of(scene)?.seen(camera, geometry);
    Some(seen.pixels().iter().map(Option::is_some).collect())
}

/// For each pixel of `geometry`, as `camera` sees it, the name of the material of such a shape before it; none if the scene
/// has no such shapes.
pub(crate) fn materials<'s>(
    scene: &'s Scene,
    camera: &Camera,
    geometry: &GeometryBuffers,
) -> Option<Vec<Option<&'s str>>> {
    let seen = UngroupedShapes::of(scene)?.seen(camera, geometry);
    let names = scene.ungrouped_materials();
    Some(seen.pixels().iter().map(|seen| seen.map(|index| names[index as usize])).collect())
}

/// The sentence about the pixels of a photograph that glass covers; none if it shows none.
pub(crate) fn told(job: &Job, camera: &Camera, geometry: &GeometryBuffers) -> Option<String> {
    let glass = job.scene.ungrouped.iter().filter(|shape| shape.glass.is_some());
    let scene = Scene { ungrouped: glass.cloned().collect(), ..Scene::default() };
    let seen = UngroupedShapes::of(&scene)?.seen(camera, geometry);
    let names = scene.ungrouped_materials();
    let shown = |material: usize| seen.pixels().contains(&u32::try_from(material).ok());
    let shown: Vec<String> = (0..names.len())
        .filter(|material| shown(*material))
        .map(|material| format!("\"{}\"", names[material]))
        .collect();
    let count = seen.pixels().iter().flatten().count();
    let share = 100.0 * count as f64 / seen.pixels().len().max(1) as f64;
    let (lets, is, them) =
        if shown.len() == 1 { ("lets", "is", "it") } else { ("let", "are", "them") };
    (!shown.is_empty()).then(|| {
        format!(
            "{} {lets} light through and {is} not recovered; the pixels that show {them}, {share:.1} % of the photo, are \
             left out",
            shown.join(", ")
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use unrender_scene::Mesh;

    fn ball(z: f32, radius: f32) -> Mesh {
        Mesh::sphere(Vec3::new(0.0, 0.0, z), radius)
    }

    /// A wide ball 10 m ahead, with a glass one `at` a distance.
    fn scene(at: f32) -> Scene {
        let wall = Group {
            name: "wall".into(),
            material: Material::diffuse(Rgb::splat(0.5)),
            emission: Rgb::ZERO,
        };
        Scene {
            groups: vec![wall],
            objects: vec![Object { name: "wall".into(), group: 0, mesh: ball(-10.0, 4.0) }],
            ungrouped: vec![Ungrouped {
                material: "glass".into(),
                mesh: ball(-at, 0.5),
                glass: None,
            }],
            ..Scene::default()
        }
    }

    #[test]
    fn pixels_before_which_glass_stands_are_covered() {
        let camera = Camera::look_at("c", Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 1.0);
        let covered = |scene: &Scene| {
            let geometry = Tracer::new(scene).geometry(&camera, 40, 40);
            covered(scene, &camera, &geometry)
        };
        let before = covered(&scene(3.0)).unwrap();
        assert!(before[20 * 40 + 20] && !before[0]);
        // A disc of a diameter of 0.333 / 2 / tan 0.5 of the height, and a rim.
        let count = before.iter().filter(|is_covered| **is_covered).count();
        assert!((110..190).contains(&count), "{count}");
        assert!(covered(&scene(30.0)).unwrap().iter().all(|is_covered| !is_covered));
        assert_eq!(covered(&Scene { ungrouped: Vec::new(), ..scene(3.0) }), None);
    }
}
