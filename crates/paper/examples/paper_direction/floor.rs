//! A floor, its photographs, and what it mirrors.

use crate::cornell_box::{FLOOR, camera};
use crate::streaks;
use glam::{Vec2, Vec3};
use unrender_paper::brushed;
use unrender_render::{Probe, ProbeSettings, Probes, Query, Settings, Tracer};
use unrender_scene::color::{luminance, srgb_from_linear};
use unrender_scene::{Camera, Material, Rgb, RgbImage, Scene};

/// How a floor is brushed: its direction, degrees from world x; none for a round lobe.
pub(crate) type Brushed = Option<f32>;

/// Pixels on a side: at half of it a mirrored block is 30 pixels wide, and lines on it too short.
const SIDE: usize = 128;
/// Paths a pixel. At half of it noise moves some of the readings by a step.
const SPP: u32 = 64;
/// Each pixel is drawn so many pixels wide in a panel.
const ENLARGED: usize = 2;

pub(crate) struct Floor<'s> {
    scene: &'s Scene,
    tracer: Tracer,
    camera: Camera,
    /// One probe a pixel of the floor.
    probes: Vec<Probe>,
}

impl<'s> Floor<'s> {
    pub(crate) fn of(scene: &'s Scene) -> Self {
        let mut floor =
            Self { scene, tracer: Tracer::new(scene), camera: camera(), probes: Vec::new() };
        let geometry = floor.tracer.geometry(&floor.camera, SIDE, SIDE);
        let shows = |pixel: &u32| geometry.pixels()[*pixel as usize].group as usize == FLOOR;
        let pixels: Vec<u32> = (0..(SIDE * SIDE) as u32).filter(shows).collect();
        let settings = ProbeSettings { cosine: 1, mirror: 1, ..ProbeSettings::default() };
        let mut probes = floor.probe(&scene.materials(), &pixels, &settings).probes;
        probes.retain(|probe| probe.group as usize == FLOOR);
        floor.probes = probes;
        floor
    }

    fn probe(&self, materials: &[Material], pixels: &[u32], settings: &ProbeSettings) -> Probes {
        self.tracer.probe(&self.camera, (SIDE, SIDE), &Query::new(materials, pixels, settings))
    }

    fn materials(&self, floor: Material) -> Vec<Material> {
        let mut materials = self.scene.materials();
        materials[FLOOR] = floor;
        materials
    }

    fn brushed(&self, brushed: Brushed) -> Material {
        let truth = self.scene.groups[FLOOR].material.clone();
        let round = (truth.alpha_x * truth.alpha_y).sqrt();
        match brushed {
            Some(degrees) => Material { theta_rad: degrees.to_radians(), ..truth },
            None => Material { alpha_x: round, alpha_y: round, theta_rad: 0.0, ..truth },
        }
    }

    fn picture(&self, floor: Material, seed: u64) -> RgbImage {
        let settings = Settings { spp: SPP, seed, ..Settings::default() };
        let materials = self.materials(floor);
        self.tracer.render(&materials, &self.camera, (SIDE, SIDE), &settings, &|_| {}).mean
    }

    pub(crate) fn photograph(&self, brushed: Brushed) -> RgbImage {
        self.picture(self.brushed(brushed), 0)
    }

    /// The same floor rendered again, with another noise.
    pub(crate) fn rerendered(&self, brushed: Brushed) -> RgbImage {
        self.picture(self.brushed(brushed), 1)
    }

    /// The floor without its lobe.
    pub(crate) fn matt(&self) -> RgbImage {
        let rho_d = self.scene.groups[FLOOR].material.rho_d;
        self.picture(Material::diffuse(rho_d), 0)
    }

    /// `photograph` of a floor brushed along `degrees` with streaks of this `amplitude` in its lobe; `matt` is the floor
    /// without it.
    pub(crate) fn streaked(
        &self,
        photograph: &RgbImage,
        matt: &RgbImage,
        (degrees, amplitude): (f32, f32),
    ) -> RgbImage {
        let mut streaked = photograph.clone();
        for probe in &self.probes {
            let at = probe.pixel as usize;
            let lobe = photograph.pixels()[at] - matt.pixels()[at];
            let change = streaks::strength(on_floor(probe), degrees, amplitude) - 1.0;
            streaked.pixels_mut()[at] += change * lobe;
        }
        streaked
    }

    pub(crate) fn as_mirror(&self) -> RgbImage {
        self.picture(Material::mirror(Rgb::ONE), 0)
    }

    /// Photograph minus mirror, at every pixel of the floor.
    pub(crate) fn difference(&self, photograph: &RgbImage, mirror: &RgbImage) -> Vec<f32> {
        let at = |image: &RgbImage, probe: &Probe| image.pixels()[probe.pixel as usize];
        self.probes.iter().map(|p| luminance(at(photograph, p) - at(mirror, p))).collect()
    }

    /// The mirrored surface with the largest `Area/d`.
    pub(crate) fn reference(&self) -> Option<u32> {
        brushed::reference_surface(&self.probes.iter().collect::<Vec<&Probe>>())
    }

    /// The objects that it mirrors.
    pub(crate) fn mirrored(&self) -> Vec<u32> {
        let mut objects: Vec<u32> =
            self.probes.iter().filter_map(|p| Some(p.mirrored?.object)).collect();
        objects.sort_unstable();
        objects.dedup();
        objects
    }

    pub(crate) fn name(&self, object: u32) -> &str {
        &self.scene.objects[object as usize].name
    }

    pub(crate) fn all(&self) -> Vec<bool> {
        vec![true; self.probes.len()]
    }

    /// The pixels that mirror `object`.
    pub(crate) fn mirrors(&self, object: u32) -> Vec<bool> {
        self.probes.iter().map(|p| p.mirrored.is_some_and(|m| m.object == object)).collect()
    }

    /// The pixels in a window of 1.5 times their extent.
    pub(crate) fn around(&self, object: u32) -> Vec<bool> {
        let own = self.mirrors(object);
        let positions: Vec<Vec2> = self.probes.iter().map(on_floor).collect();
        let shown = positions.iter().zip(&own).filter(|(_, own)| **own).map(|(p, _)| *p);
        let window = brushed::Window::around(shown, 1.5);
        positions.iter().map(|p| window.is_some_and(|window| window.contains(*p))).collect()
    }

    /// The `chosen` pixels with their `values`, where they lie on the floor.
    pub(crate) fn on_plane(&self, chosen: &[bool], values: &[f32]) -> Vec<(Vec2, f32)> {
        self.points(chosen, values, on_floor)
    }

    /// The same where they lie in the picture, y up.
    pub(crate) fn in_picture(&self, chosen: &[bool], values: &[f32]) -> Vec<(Vec2, f32)> {
        let place = |probe: &Probe| {
            let (x, y) = (probe.pixel as usize % SIDE, probe.pixel as usize / SIDE);
            Vec2::new(x as f32, -(y as f32))
        };
        self.points(chosen, values, place)
    }

    fn points(
        &self,
        chosen: &[bool],
        values: &[f32],
        place: impl Fn(&Probe) -> Vec2,
    ) -> Vec<(Vec2, f32)> {
        let all = self.probes.iter().zip(values).zip(chosen).filter(|(_, chosen)| **chosen);
        all.map(|((probe, value), _)| (place(probe), *value)).collect()
    }

    /// Photograph, mirror, their difference (grey where there is none) and the reference surface's image,
    /// from left to right; what is not floor is dark.
    pub(crate) fn steps(
        &self,
        photograph: &RgbImage,
        mirror: &RgbImage,
        difference: &[f32],
        reference: u32,
    ) -> image::RgbImage {
        let own = self.mirrors(reference);
        let dark = |image: &RgbImage| image.map(|rgb| 0.15 * *rgb);
        let mut panels = [dark(photograph), dark(mirror), dark(photograph), dark(photograph)];
        let largest = difference.iter().fold(f32::MIN_POSITIVE, |a, b| a.max(b.abs()));
        for (i, probe) in self.probes.iter().enumerate() {
            let at = probe.pixel as usize;
            panels[0].pixels_mut()[at] = photograph.pixels()[at];
            panels[1].pixels_mut()[at] = mirror.pixels()[at];
            // The square root shows faint differences.
            let shown = (difference[i] / largest).abs().sqrt().copysign(difference[i]);
            panels[2].pixels_mut()[at] = Rgb::splat(0.22 + 0.22 * shown + 0.3 * shown.max(0.0));
            let tint = if own[i] { Rgb::new(0.9, 0.5, 0.1) } else { Rgb::splat(0.12) };
            panels[3].pixels_mut()[at] = tint;
        }
        let rows = self.probes.iter().map(|probe| probe.pixel as usize / SIDE);
        let top = rows.min().unwrap_or(0).saturating_sub(4);
        let panel = ENLARGED * SIDE;
        let code = |linear: f32| (255.0 * srgb_from_linear(linear.clamp(0.0, 1.0))).round() as u8;
        let size = [panels.len() * panel, ENLARGED * (SIDE - top)].map(|side| side as u32);
        image::RgbImage::from_fn(size[0], size[1], |x, y| {
            let (x, y) = (x as usize, y as usize);
            let rgb = *panels[x / panel].at(x % panel / ENLARGED, top + y / ENLARGED);
            image::Rgb(rgb.to_array().map(code))
        })
    }
}

/// Where a pixel lies on the floor: world x, and across it the way that angles are counted.
fn on_floor(probe: &Probe) -> Vec2 {
    let bitangent = Vec3::Y.cross(Vec3::X);
    Vec2::new(probe.point.x, probe.point.dot(bitangent))
}
