//! A renderer in closed form: horizontal stripes of materials under a grid of directional lights, without noise.

use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::f32::consts::FRAC_1_PI;
use std::ops::Range;
use unrender_recover::{Expected, Picture, Renderer, Stored};
use unrender_render::geometry::PixelGeometry;
use unrender_render::probe::Incident;
use unrender_render::{
    Appearance, GeometryBuffers, GlossyLobe, Jacobian, Parameter, Probe, ProbeSettings, Probes,
    RadianceCache, Settings,
};
use unrender_scene::{BrdfModel, Image, Material, Rgb, RgbImage};

const WIDTH: usize = 64;
const STRIPE: usize = 24;

/// Stripes of materials, one group and one object each, seen under directions that change over the
/// picture.
pub(crate) struct Stripes {
    pub(crate) model: BrdfModel,
    pub(crate) truth: Vec<Material>,
    pub(crate) geometry: GeometryBuffers,
    /// What is expected of the stripes; nothing of those beyond its end.
    pub(crate) expected: Vec<Expected>,
    /// The lights, the same at every pixel, and the sum of their irradiances.
    pub(crate) incident: Vec<Incident>,
    pub(crate) irradiance: Rgb,
    /// A stripe that gets no light.
    pub(crate) dark: Option<u32>,
}

impl Stripes {
    pub(crate) fn new(truth: Vec<Material>) -> Self {
        let geometry = Image::from_fn(WIDTH, STRIPE * truth.len(), |x, y| PixelGeometry {
            object: (y / STRIPE) as u32,
            group: (y / STRIPE) as u32,
            depth: 1.0,
            normal: Vec3::Z,
            tangent: Vec3::X,
            uv: Vec2::new((x as f32 + 0.5) / 64.0, ((y % STRIPE) as f32 + 0.5) / 24.0),
            front: true,
        });
        let incident = Self::lights();
        let irradiance = incident.iter().map(|light| light.irradiance).sum();
        let (model, expected) = (BrdfModel::default(), Vec::new());
        Self { model, truth, geometry, expected, incident, irradiance, dark: None }
    }

    fn wo(pixel: u32) -> Vec3 {
        let (x, y) = (pixel as usize % WIDTH, pixel as usize / WIDTH % STRIPE);
        Vec3::new((x as f32 - 32.0) / 40.0, (y as f32 - 12.0) / 30.0 + 0.5, 1.0).normalize()
    }

    fn lights() -> Vec<Incident> {
        let light = |i: usize| {
            let (a, b) = ((i % 7) as f32 - 3.0, (i / 7) as f32 - 3.0);
            let wi = Vec3::new(0.25 * a, 0.25 * b - 0.4, 1.0).normalize();
            let colour = Rgb::new(1.0 + 0.1 * a, 1.0, 1.0 - 0.1 * b);
            Incident { wi, irradiance: 0.1 * colour * wi.z }
        };
        (0..49).map(light).collect()
    }

    fn mirror(wo: Vec3) -> Rgb {
        let (x, y) = (-wo.x, -wo.y);
        Rgb::new(
            0.6 + 0.4 * (6.0 * x).sin(),
            0.5 + 0.3 * (5.0 * y).cos(),
            0.7 + 0.2 * (4.0 * x + 3.0 * y).sin(),
        )
    }

    /// The lobe of `material`; none if it has none.
    fn lobe(&self, material: &Material) -> Option<GlossyLobe> {
        let lobe = || GlossyLobe::new(self.model, material.alpha_x, material.alpha_y);
        material.is_glossy().then(lobe)
    }

    /// The radiance of `pixel` with `material`, whose lobe is `lobe`.
    fn radiance(&self, material: &Material, lobe: Option<&GlossyLobe>, pixel: u32) -> Rgb {
        if self.dark == Some(self.geometry.pixels()[pixel as usize].group) {
            return Rgb::ZERO;
        }
        let wo = Self::wo(pixel);
        let rho_d = material.rho_d_at(self.geometry.pixels()[pixel as usize].uv);
        let shine = lobe.map_or_else(
            || Self::mirror(wo),
            |lobe| {
                let (sin, cos) = material.theta_rad.sin_cos();
                let turn = |v: Vec3| Vec3::new(cos * v.x + sin * v.y, cos * v.y - sin * v.x, v.z);
                let wo = turn(wo);
                self.incident.iter().map(|i| lobe.value(wo, turn(i.wi)) * i.irradiance).sum()
            },
        );
        rho_d * self.irradiance * FRAC_1_PI + material.rho_s * shine
    }

    /// The derivatives of the radiances of `pixels`, all of one `group` with `material`, by central
    /// differences.
    fn derivatives(
        &self,
        material: &Material,
        group: u32,
        by: Parameter,
        pixels: &[u32],
    ) -> Vec<Rgb> {
        const STEP: f32 = 1e-3;
        let moved = |step: f32| {
            let mut moved = material.clone();
            match by {
                Parameter::RhoD(g) if g == group => moved.rho_d += step,
                Parameter::RhoS(g) if g == group => moved.rho_s += step,
                Parameter::AlphaX(g) if g == group => moved.alpha_x += step,
                Parameter::AlphaY(g) if g == group => moved.alpha_y += step,
                Parameter::Theta(g) if g == group => moved.theta_rad += step,
                // No stripe lights another.
                _ => return None,
            }
            let lobe = self.lobe(&moved);
            Some((moved, lobe))
        };
        let Some((up, down)) = moved(STEP).zip(moved(-STEP)) else {
            return vec![Rgb::ZERO; pixels.len()];
        };
        let at = |(material, lobe): &(Material, Option<GlossyLobe>), pixel: u32| {
            self.radiance(material, lobe.as_ref(), pixel)
        };
        pixels.iter().map(|&pixel| (at(&up, pixel) - at(&down, pixel)) / (2.0 * STEP)).collect()
    }

    /// The radiances of `pixels` with these materials of the groups.
    fn radiances(&self, materials: &[Material], pixels: &[u32]) -> Vec<Rgb> {
        let lobes: Vec<Option<GlossyLobe>> = materials.iter().map(|m| self.lobe(m)).collect();
        let one = |&pixel: &u32| {
            let group = self.geometry.pixels()[pixel as usize].group as usize;
            self.radiance(&materials[group], lobes[group].as_ref(), pixel)
        };
        pixels.par_iter().map(one).collect()
    }

    pub(crate) fn photograph(&self) -> Picture {
        let (width, height) = (WIDTH, STRIPE * self.truth.len());
        let pixels: Vec<u32> = (0..(width * height) as u32).collect();
        Picture {
            values: RgbImage::new(width, height, self.radiances(&self.truth, &pixels)),
            valid: Image::new(width, height, vec![true; width * height]),
            saturated: Image::new(width, height, vec![false; width * height]),
            quantisation_step: RgbImage::new(width, height, vec![Rgb::ZERO; width * height]),
        }
    }
}

/// What stripes send is known without paths.
struct StoredStripes<'s> {
    stripes: &'s Stripes,
    pixels: Vec<u32>,
}

impl Stored for StoredStripes<'_> {
    fn replay(
        &self,
        appearance: Appearance<'_>,
        parameters: &[Parameter],
        seen: Option<&RadianceCache>,
    ) -> Jacobian {
        let settings = Settings::default();
        let pixels: Vec<_> = self.pixels.iter().map(|pixel| (*pixel, settings.samples())).collect();
        self.stripes.jacobian(appearance, &pixels, parameters, &settings, seen)
    }
}

impl Renderer for Stripes {
    fn geometry(&self) -> &GeometryBuffers {
        &self.geometry
    }

    fn point(&self, pixel: u32) -> Option<Vec3> {
        Some(self.geometry.pixels()[pixel as usize].uv.extend(0.0))
    }

    fn model(&self) -> BrdfModel {
        self.model
    }

    fn probe(
        &self,
        _: Appearance<'_>,
        pixels: &[u32],
        settings: &ProbeSettings,
        _: Option<&RadianceCache>,
    ) -> Probes {
        let mut all = Probes::default();
        for &pixel in pixels {
            let incident = &self.incident;
            let first = all.incident.len() as u32;
            let count = if settings.keep_incident { incident.len() as u32 } else { 0 };
            all.incident.extend(incident.iter().take(count as usize).cloned());
            let at = self.geometry.pixels()[pixel as usize];
            let irradiance = if self.dark == Some(at.group) { Rgb::ZERO } else { self.irradiance };
            all.probes.push(Probe {
                pixel,
                group: at.group,
                throughput: Rgb::ONE,
                wo: Self::wo(pixel),
                point: at.uv.extend(0.0),
                emitted: Rgb::ZERO,
                diffuse: irradiance * FRAC_1_PI,
                mirror: Self::mirror(Self::wo(pixel)),
                mirrored: None,
                first,
                count,
            });
        }
        all
    }

    fn jacobian(
        &self,
        appearance: Appearance<'_>,
        pixels: &[(u32, Range<u32>)],
        parameters: &[Parameter],
        _: &Settings,
        _: Option<&RadianceCache>,
    ) -> Jacobian {
        let pixels: Vec<u32> = pixels.iter().map(|(pixel, _)| *pixel).collect();
        let mut derivatives = vec![Rgb::ZERO; pixels.len() * parameters.len()];
        let group_of = |index: usize| self.geometry.pixels()[pixels[index] as usize].group;
        for (group, material) in appearance.materials.iter().enumerate().map(|(g, m)| (g as u32, m))
        {
            let own: Vec<usize> = (0..pixels.len()).filter(|&i| group_of(i) == group).collect();
            let of_group: Vec<u32> = own.iter().map(|&index| pixels[index]).collect();
            for (column, &by) in parameters.iter().enumerate() {
                let found = self.derivatives(material, group, by, &of_group);
                for (&index, derivative) in own.iter().zip(found) {
                    derivatives[index * parameters.len() + column] = derivative;
                }
            }
        }
        let radiance = self.radiances(appearance.materials, &pixels);
        Jacobian { radiance, derivatives }
    }

    fn store<'s>(
        &'s self,
        _: Appearance<'_>,
        pixels: &[u32],
        _: &[Parameter],
        _: &Settings,
        _: Option<&RadianceCache>,
    ) -> Box<dyn Stored + 's> {
        let pixels = pixels.to_vec();
        Box::new(StoredStripes { stripes: self, pixels })
    }

    fn rerender(&self, appearance: Appearance<'_>, pixels: &[u32], _: &Settings) -> Vec<Rgb> {
        self.radiances(appearance.materials, pixels)
    }

    fn picture(
        &self,
        appearance: Appearance<'_>,
        settings: &Settings,
        _: &(dyn Fn(f64) + Sync),
    ) -> Vec<Rgb> {
        let pixels: Vec<u32> = (0..self.geometry.pixels().len() as u32).collect();
        self.rerender(appearance, &pixels, settings)
    }
}
