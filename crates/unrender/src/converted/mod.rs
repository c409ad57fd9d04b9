//! Converts the materials of a scene to another program's lobe, for one camera.
//!
//! `fit` finds the parameters of the other lobe, `target` evaluates it, and `in_scene` corrects its
//! brightness where the camera sees it.

mod fit;
mod in_scene;
mod target;

pub use fit::{Conversion, convert, convert_all};
pub use in_scene::Views;

use unrender_recover::View;
use unrender_render::Tracer;
use unrender_scene::{Camera, Lobe, Scene};

/// The longer side of the picture in which brightness is compared, pixels.
const LONGER_SIDE: usize = 384;

/// The conversion of each group of `scene` to the lobe `to`, for the picture of `size` (width and
/// height, pixels) that `camera` takes.
pub fn converted(
    scene: &Scene,
    camera: &Camera,
    size: (usize, usize),
    to: Lobe,
) -> Vec<Conversion> {
    let size = reduced(size);
    let tracer = Tracer::new(scene);
    let original = View::new(&tracer, camera, size, scene.brdf);
    let scene = Scene { brdf: to.nearest_model(), ..scene.clone() };
    let tracer = Tracer::new(&scene);
    let converted = View::new(&tracer, camera, size, scene.brdf);
    let views = Views { original: &original, converted: &converted };
    convert_all(&scene.materials(), views, to)
}

fn reduced((width, height): (usize, usize)) -> (usize, usize) {
    let scale = (LONGER_SIDE as f64 / width.max(height) as f64).min(1.0);
    let side = |n: usize| ((n as f64 * scale).round() as usize).max(1);
    (side(width), side(height))
}
