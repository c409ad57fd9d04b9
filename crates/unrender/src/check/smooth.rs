//! Sharp edges that are shaded as if they were round: the normals of a box that was set to "shade smooth".

use super::finding::{Findings, Gravity};
use super::{Subject, some, surface_behind};
use std::collections::BTreeMap;
use unrender_render::NOTHING;

/// Pixels of an object that are looked at. Half of them miss objects of which one edge is seen, double takes twice as long.
const PIXELS: usize = 60;
/// Objects with fewer pixels are not looked at: half of them have no inside, double of them is a chair.
const PIXELS_MIN: usize = 100;
/// The cosine of the angle between a face and its normal from which on the shading is another: 30 degrees. A ball of twelve
/// sides stays below it; a box that is shaded smoothly has up to 55.
const APART: f32 = 0.866;
/// The share of an object's pixels that are shaded so: of a cube that is shaded smoothly it is three quarters. At half of it
/// bevels count, at double long boxes do not.
const SHARE: f32 = 0.3;

/// The finding of objects with such normals.
pub(super) fn warnings(subject: &Subject<'_>) -> Findings {
    let mut findings = Findings::default();
    let (camera, geometry) = (&subject.registered.camera, subject.geometry);
    let size = (geometry.width(), geometry.height());
    let mut pixels: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (index, pixel) in geometry.pixels().iter().enumerate().filter(|(_, p)| p.object != NOTHING)
    {
        pixels.entry(pixel.object).or_default().push(index as u32);
    }
    let is_apart = |pixel: &u32| {
        let shaded = geometry.pixels()[*pixel as usize].normal;
        let surface = surface_behind(subject.tracer, camera, size, *pixel);
        surface.is_some_and(|surface| surface.geometric_normal.dot(shaded).abs() < APART)
    };
    let is_smooth = |pixels: &Vec<u32>| {
        let looked = unrender_recover::observe::blocks::spread(pixels, PIXELS, 0);
        looked.iter().filter(|pixel| is_apart(pixel)).count() as f32 > SHARE * looked.len() as f32
    };
    let smooth = pixels.iter().filter(|(_, of)| of.len() >= PIXELS_MIN && is_smooth(of));
    let names: Vec<&str> = smooth.map(|(object, _)| subject.object_name(*object)).collect();
    if !names.is_empty() {
        findings.push(
            Gravity::Part,
            format!(
                "{} is shaded as if its edges were round, more than 30 degrees off its faces: its materials come out wrong \
                 near them. Split the normals at sharp edges (in Blender: Shade Auto Smooth), or bevel them",
                some(&names)
            ),
        );
    }
    findings
}
