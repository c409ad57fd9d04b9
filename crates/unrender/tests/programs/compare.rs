//! Two pictures of one scene, compared by the mean radiance of its groups.

use unrender::render::Tracer;
use unrender::scene::{Camera, Rgb, RgbImage, Scene};

/// The mean radiance of a group in two pictures.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub(crate) group: usize,
    /// Pixels that show the group and that lie inside it.
    pub(crate) pixels: usize,
    /// Mean radiance in our picture, W sr^-1 m^-2.
    pub(crate) ours: Rgb,
    /// Mean radiance in theirs.
    pub(crate) theirs: Rgb,
}

impl Row {
    /// The largest difference of a channel, relative to our mean over the channels.
    pub(crate) fn difference(&self) -> f32 {
        (self.theirs - self.ours).abs().max_element() / (self.ours.element_sum() / 3.0)
    }
}

/// One row for each group that has at least `least` pixels all of whose neighbours show it too:
/// pixels at edges depend on a renderer's filter.
pub(crate) fn compare(
    scene: &Scene,
    camera: &Camera,
    ours: &RgbImage,
    theirs: &RgbImage,
    least: usize,
) -> Vec<Row> {
    let (width, height) = (ours.width(), ours.height());
    assert_eq!((theirs.width(), theirs.height()), (width, height), "pictures of one size");
    let geometry = Tracer::new(scene).geometry(camera, width, height);
    let group_of = |index: usize| geometry.pixels()[index].group as usize;
    let inside = |index: &usize| {
        geometry.neighbourhood(*index).all(|beside| group_of(beside) == group_of(*index))
    };
    let mut rows = Vec::new();
    for group in 0..scene.groups.len() {
        let pixels: Vec<usize> =
            (0..width * height).filter(|&i| group_of(i) == group).filter(inside).collect();
        if pixels.len() < least {
            continue;
        }
        let mean = |picture: &RgbImage| {
            let sum: glam::DVec3 = pixels.iter().map(|&i| picture.pixels()[i].as_dvec3()).sum();
            (sum / pixels.len() as f64).as_vec3()
        };
        rows.push(Row { group, pixels: pixels.len(), ours: mean(ours), theirs: mean(theirs) });
    }
    rows
}
