//! A renderer in closed form: horizontal stripes of materials under a grid of directional lights, without noise. Stripes
//! may face each other, and then light each other by one bounce more.

use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::f32::consts::FRAC_1_PI;
use std::ops::Range;
use unrender_recover::{Expected, Picture, Query, Renderer, Stored};
use unrender_render::geometry::PixelGeometry;
use unrender_render::probe::Incident;
use unrender_render::{
    Appearance, GeometryBuffers, GlossyLobe, Jacobian, Parameter, Probe, ProbeSettings, Probes,
    RadianceCache, Settings,
};
use unrender_scene::{BrdfModel, Image, Material, Rgb, RgbImage};

const WIDTH: usize = 64;
const STRIPE: usize = 24;

/// One material for each of the six rungs without a texture, in the ladder's order.
pub(crate) fn uniform() -> [Material; 6] {
    let brushed = Material {
        rho_s: Rgb::new(0.5, 0.6, 0.4),
        alpha_x: 0.08,
        alpha_y: 0.2,
        theta_rad: 30f32.to_radians(),
        ..Material::diffuse(Rgb::new(0.1, 0.2, 0.05))
    };
    [
        Material::diffuse(Rgb::new(0.2, 0.5, 0.8)),
        Material::mirror(Rgb::ONE),
        Material::mirror(Rgb::new(0.4, 0.6, 0.5)),
        Material { rho_d: Rgb::new(0.3, 0.1, 0.2), ..Material::mirror(Rgb::splat(0.25)) },
        Material::isotropic(Rgb::new(0.3, 0.12, 0.4), Rgb::splat(0.2), 0.12),
        brushed,
    ]
}

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
    /// How stripes light each other, if they do.
    pub(crate) facing: Option<Facing>,
    /// Whether gatherings of more directions than any hypothesis is looked for with say that half as much light arrives
    /// as does.
    pub(crate) misleads: bool,
}

/// Stripes that face each other: the first and the second, the third and the fourth, and so on. Each is the brighter by
/// the light that the other one reflects once.
#[derive(Clone, Copy)]
pub(crate) struct Facing {
    /// The share of the light of one that reaches the other.
    pub(crate) form_factor: f32,
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
        let (dark, facing, misleads) = (None, None, false);
        Self { model, truth, geometry, expected, incident, irradiance, dark, facing, misleads }
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

    /// How much brighter than by the lights alone `pixel` is lit with these `materials` of the groups: the facing stripe's
    /// diffuse light comes everywhere, that of its specular part to the right half alone, like a caustic.
    fn brighter(&self, materials: &[Material], pixel: u32) -> Rgb {
        let group = self.geometry.pixels()[pixel as usize].group as usize;
        let other = materials.get(group ^ 1).filter(|_| (group ^ 1) < self.truth.len());
        let Some((Facing { form_factor, .. }, other)) = self.facing.zip(other) else {
            return Rgb::ONE;
        };
        let is_right = pixel as usize % WIDTH >= WIDTH / 2;
        let specular = if is_right { 2.0 * other.rho_s } else { Rgb::ZERO };
        Rgb::ONE + form_factor * (other.rho_d + specular)
    }

    /// The radiance of `pixel` with `material`, whose lobe is `lobe`, in so many times the light.
    fn radiance(
        &self,
        material: &Material,
        lobe: Option<&GlossyLobe>,
        pixel: u32,
        brighter: Rgb,
    ) -> Rgb {
        let group = self.geometry.pixels()[pixel as usize].group;
        if self.dark == Some(group) {
            return Rgb::ZERO;
        }
        let wo = Self::wo(pixel);
        let rho_d = Self::seen(material, self.geometry.pixels()[pixel as usize].uv);
        let shine = lobe.map_or_else(
            || Self::mirror(wo),
            |lobe| {
                let (sin, cos) = material.theta_rad.sin_cos();
                let turn = |v: Vec3| Vec3::new(cos * v.x + sin * v.y, cos * v.y - sin * v.x, v.z);
                let wo = turn(wo);
                let lit = |i: &Incident| lobe.value(wo, turn(i.wi)) * i.irradiance;
                brighter * self.incident.iter().map(lit).sum::<Rgb>()
            },
        );
        rho_d * self.irradiance * brighter * FRAC_1_PI + material.rho_s * shine
    }

    /// The diffuse reflectance of `material` over the square of a pixel with this texture coordinate in its middle.
    fn seen(material: &Material, uv: Vec2) -> Rgb {
        const POINTS: usize = 16;
        if material.texture.is_none() {
            return material.rho_d;
        }
        let along = |i: usize| (i as f32 + 0.5) / POINTS as f32 - 0.5;
        let point = |i: usize| {
            material.rho_d_at(uv + Vec2::new(along(i % POINTS) / 64.0, along(i / POINTS) / 24.0))
        };
        (0..POINTS * POINTS).map(point).sum::<Rgb>() / (POINTS * POINTS) as f32
    }

    /// The derivatives of the radiances of `pixels` by one parameter, by central differences.
    fn derivatives(&self, materials: &[Material], by: Parameter, pixels: &[u32]) -> Vec<Rgb> {
        const STEP: f32 = 1e-3;
        let moved = |step: f32| {
            let mut moved = materials.to_vec();
            let (group, number): (_, fn(&mut Material, f32)) = match by {
                Parameter::RhoD(group) => (group, |of, step| of.rho_d += step),
                Parameter::RhoS(group) => (group, |of, step| of.rho_s += step),
                Parameter::AlphaX(group) => (group, |of, step| of.alpha_x += step),
                Parameter::AlphaY(group) => (group, |of, step| of.alpha_y += step),
                Parameter::Theta(group) => (group, |of, step| of.theta_rad += step),
                _ => return None,
            };
            number(moved.get_mut(group as usize)?, step);
            Some(moved)
        };
        let Some((up, down)) = moved(STEP).zip(moved(-STEP)) else {
            return vec![Rgb::ZERO; pixels.len()];
        };
        let [up, down] = [up, down].map(|materials| self.radiances(&materials, pixels));
        up.iter().zip(down).map(|(up, down)| (*up - down) / (2.0 * STEP)).collect()
    }

    /// Whether `pixel` changes with the parameter.
    fn depends(&self, pixel: u32, by: Parameter) -> bool {
        let own = self.geometry.pixels()[pixel as usize].group;
        let is_facing = |group: u32| self.facing.is_some() && group ^ 1 == own;
        match by {
            Parameter::RhoD(group) | Parameter::RhoS(group) => group == own || is_facing(group),
            Parameter::AlphaX(group) | Parameter::AlphaY(group) | Parameter::Theta(group) => {
                group == own
            }
            _ => false,
        }
    }

    /// The radiances of `pixels` with these materials of the groups.
    fn radiances(&self, materials: &[Material], pixels: &[u32]) -> Vec<Rgb> {
        let lobes: Vec<Option<GlossyLobe>> = materials.iter().map(|m| self.lobe(m)).collect();
        let one = |&pixel: &u32| {
            let group = self.geometry.pixels()[pixel as usize].group as usize;
            self.radiance(
                &materials[group],
                lobes[group].as_ref(),
                pixel,
                self.brighter(materials, pixel),
            )
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
        let query = Query::new(appearance, &pixels, &settings);
        self.stripes.jacobian(&Query { parameters, seen, ..query })
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

    fn probe(&self, query: &Query<'_, u32, ProbeSettings>) -> Probes {
        let Query { appearance, pixels, settings, .. } = *query;
        let mut all = Probes::default();
        for &pixel in pixels {
            let first = all.incident.len() as u32;
            let count = if settings.keep_incident { self.incident.len() as u32 } else { 0 };
            let at = self.geometry.pixels()[pixel as usize];
            let brighter = self.brighter(appearance.materials, pixel);
            let lit = |of: &Incident| Incident { irradiance: brighter * of.irradiance, ..*of };
            all.incident.extend(self.incident.iter().take(count as usize).map(lit));
            let is_dark = self.dark == Some(at.group);
            let irradiance = if is_dark { Rgb::ZERO } else { brighter * self.irradiance };
            let is_misled = self.misleads && settings.cosine > 16;
            let irradiance = if is_misled { 0.5 * irradiance } else { irradiance };
            all.probes.push(Probe {
                pixel,
                group: at.group,
                throughput: Rgb::ONE,
                wo: Self::wo(pixel),
                point: at.uv.extend(0.0),
                emitted: Rgb::ZERO,
                diffuse: irradiance * FRAC_1_PI,
                straight: irradiance * FRAC_1_PI,
                mirror: Self::mirror(Self::wo(pixel)),
                mirrored: None,
                first,
                count,
            });
        }
        all
    }

    fn jacobian(&self, query: &Query<'_, (u32, Range<u32>)>) -> Jacobian {
        let Query { appearance, pixels, parameters, .. } = *query;
        let pixels: Vec<u32> = pixels.iter().map(|(pixel, _)| *pixel).collect();
        let mut derivatives = vec![Rgb::ZERO; pixels.len() * parameters.len()];
        for (column, &by) in parameters.iter().enumerate() {
            let places: Vec<usize> =
                (0..pixels.len()).filter(|&index| self.depends(pixels[index], by)).collect();
            let changed: Vec<u32> = places.iter().map(|&index| pixels[index]).collect();
            let found = self.derivatives(appearance.materials, by, &changed);
            for (index, derivative) in places.into_iter().zip(found) {
                derivatives[index * parameters.len() + column] = derivative;
            }
        }
        let radiance = self.radiances(appearance.materials, &pixels);
        Jacobian { radiance, derivatives }
    }

    fn store<'s>(&'s self, query: &Query<'_>) -> Box<dyn Stored + 's> {
        let pixels = query.pixels.to_vec();
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
