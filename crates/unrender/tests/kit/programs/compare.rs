//! Two pictures of one scene, compared by the mean radiance of its groups, whole or in quarters.

use unrender::render::Tracer;
use unrender::scene::{Camera, Rgb, RgbImage, Scene};

/// The mean radiance of a group in two pictures.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub(crate) group: usize,
    /// The number of pixels that show the group and lie inside it.
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
    compare_split(scene, camera, ours, theirs, least, |pixels, _| vec![pixels])
}

/// As [`compare`], with a row for each quarter of a group's part of the picture that has `least`
/// pixels: a flipped texture has the right mean, but not in each quarter.
pub(crate) fn compare_quadrants(
    scene: &Scene,
    camera: &Camera,
    ours: &RgbImage,
    theirs: &RgbImage,
    least: usize,
) -> Vec<Row> {
    compare_split(scene, camera, ours, theirs, least, |pixels, width| {
        quadrants(pixels, width).into_iter().filter(|quarter| quarter.len() >= least).collect()
    })
}

fn compare_split(
    scene: &Scene,
    camera: &Camera,
    ours: &RgbImage,
    theirs: &RgbImage,
    least: usize,
    split: impl Fn(Vec<usize>, usize) -> Vec<Vec<usize>>,
) -> Vec<Row> {
    let (width, height) = (ours.width(), ours.height());
    assert_eq!((theirs.width(), theirs.height()), (width, height), "pictures of one size");
    let geometry = Tracer::new(scene).geometry(camera, width, height);
    let group_of = |index: usize| geometry.pixels()[index].group as usize;
    let inside = |index: &usize| {
        geometry.neighbourhood(*index).all(|beside| group_of(beside) == group_of(*index))
    };
    let all = (0..scene.groups.len()).map(|group| {
        let pixels = (0..width * height).filter(|&i| group_of(i) == group).filter(inside);
        (group, pixels.collect::<Vec<usize>>())
    });
    all.filter(|(_, pixels)| pixels.len() >= least)
        .flat_map(|(group, pixels)| {
            let row = |pixels: Vec<usize>| row(group, &pixels, ours, theirs);
            split(pixels, width).into_iter().map(row).collect::<Vec<_>>()
        })
        .collect()
}

fn row(group: usize, pixels: &[usize], ours: &RgbImage, theirs: &RgbImage) -> Row {
    let mean = |picture: &RgbImage| {
        let sum: glam::DVec3 = pixels.iter().map(|&i| picture.pixels()[i].as_dvec3()).sum();
        (sum / pixels.len() as f64).as_vec3()
    };
    Row { group, pixels: pixels.len(), ours: mean(ours), theirs: mean(theirs) }
}

/// The quarters of the box around `pixels` of a picture of this width, each with its pixels.
fn quadrants(pixels: Vec<usize>, width: usize) -> Vec<Vec<usize>> {
    let middle = |of: &dyn Fn(usize) -> usize| {
        let (low, high) = pixels
            .iter()
            .map(|&i| of(i))
            .fold((usize::MAX, 0), |(low, high), at| (low.min(at), high.max(at)));
        usize::midpoint(low, high)
    };
    let (x, y) = (middle(&|i| i % width), middle(&|i| i / width));
    let mut quarters = vec![Vec::new(); 4];
    for i in pixels {
        quarters[usize::from(i % width > x) + 2 * usize::from(i / width > y)].push(i);
    }
    quarters
}
