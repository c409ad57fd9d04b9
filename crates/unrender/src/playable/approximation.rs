//! How far the two approximations of a playable result are off, measured on stored paths.
//!
//! A path that meets a group `k` times carries light in proportion to the `k`-th power of its reflectance. With `t` the
//! reflectance over the present one and `m` the mean of `k` over the light of a pixel, `1 + m (t - 1)` and `t^m` both have
//! the derivative of the light, and neither is above it: the first as the tangent of a convex function, the second as a
//! weighted geometric mean below the arithmetic one. The page takes the greater. `1 + m (t - 1)` is right where the light
//! meets the group once or never, `t^m` where it meets it equally often.

use super::separated::{ColourOf, OwnColour, Stage};
use glam::DVec3;
use unrender_render::{Appearance, Integrator, Jacobian, Parameter, Query, Settings, StoredPaths};
use unrender_restage::repaint::Paint;
use unrender_scene::{Material, Rgb};

/// The least colour that powers are taken of; what is darker is black. Half and double of it change no code of a picture.
const OWN_MIN: f32 = 1e-4;

/// Pixels on which errors are measured, evenly over the picture. At half of it the root mean square is uncertain by a
/// tenth, double of it takes twice the time.
const PIXELS: usize = 3000;
/// Paths of each of them. Half of it makes errors of rare paths noisier, double of it takes twice the time.
const PATHS: u32 = 16;
/// The ends between which errors are measured: a black and a white paint. Nothing has more than 1, and below half of the
/// dark end errors are the same within a tenth.
const ENDS: [f32; 2] = [0.03, 0.9];

/// The errors of the picture by one colour.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Errors {
    /// By channel: values of the colour, ascending, and the root mean square error there, as a share of the channel's mean.
    pub(crate) first_order: [Vec<(f32, f64)>; 3],
    /// Per unit of the colour and of the brightness of each lamp alone, as a share of the picture's mean: that the group's
    /// share in the light is another one than in the photograph.
    pub(crate) lamps: Vec<f64>,
}

/// The errors of each of `colours`.
pub(super) fn errors(stage: &Stage<'_>, colours: &[OwnColour], seed: u64) -> Vec<Errors> {
    let count = stage.size.0 * stage.size.1;
    let step = (count as f64 / PIXELS as f64).max(1.0);
    let pixels: Vec<u32> = (0..count.min(PIXELS)).map(|k| (k as f64 * step) as u32).collect();
    let parameters: Vec<Parameter> = colours.iter().map(OwnColour::parameter).collect();
    let settings =
        Settings { spp: PATHS, seed, integrator: Integrator::Path, ..Settings::default() };
    let query = Query { parameters: &parameters, ..Query::new(stage.now(), &pixels, &settings) };
    let measured = Measured {
        stage,
        colours,
        paths: stage.tracer.store(&stage.camera, stage.size, &query),
        parameters,
    };
    measured.errors()
}

struct Measured<'a> {
    stage: &'a Stage<'a>,
    colours: &'a [OwnColour],
    paths: StoredPaths,
    parameters: Vec<Parameter>,
}

impl Measured<'_> {
    fn errors(&self) -> Vec<Errors> {
        let now = self.paths.replay(self.stage.tracer, self.stage.now(), &self.parameters, None);
        let lamps = self.by_lamp(&now.radiance, &now.derivatives);
        let each = lamps.into_iter().enumerate();
        each.map(|(colour, lamps)| Errors { first_order: self.first_order(colour, &now), lamps })
            .collect()
    }

    /// The error of first order by the colours between the ends, which are grey.
    fn first_order(&self, colour: usize, now: &Jacobian) -> [Vec<(f32, f64)>; 3] {
        let own = self.colours[colour].now;
        let own_error = |c: usize| (own[c], 0.0);
        let mut errors = [0, 1, 2].map(|c: usize| vec![own_error(c)]);
        let grey = own.element_sum() / 3.0;
        let halfway = ENDS.map(|end| (end * grey.max(ENDS[0])).sqrt());
        for level in ENDS.into_iter().chain(halfway) {
            let off = self.off(colour, level, now);
            for (c, errors) in errors.iter_mut().enumerate() {
                errors.push((level, f64::from(off[c])));
            }
        }
        errors.iter_mut().for_each(|of| of.sort_by(|a, b| a.0.total_cmp(&b.0)));
        errors
    }

    /// By channel the root mean square error where the colour has this `level`, as a share of the mean.
    fn off(&self, colour: usize, level: f32, now: &Jacobian) -> Rgb {
        let (materials, difference) = self.painted(colour, level);
        let appearance = Appearance { materials: &materials, ..self.stage.now() };
        let exact = self.paths.replay(self.stage.tracer, appearance, &[], None).radiance;
        let own = self.colours[colour].now;
        let own = own.max(Rgb::splat(OWN_MIN));
        let times = Rgb::splat(level) / own;
        // The parameter's present value is that of the colour in its unit.
        let value = own / self.colours[colour].unit();
        let each = self.parameters.len();
        let (mut squares, mut sum) = (DVec3::ZERO, DVec3::ZERO);
        for (pixel, (exact, light)) in exact.iter().zip(&now.radiance).enumerate() {
            let change = now.derivatives[pixel * each + colour];
            for c in 0..3 {
                let meets = if light[c] > 0.0 { value[c] * change[c] / light[c] } else { 0.0 };
                let taken = light[c] * times[c].powf(meets).max(0.0);
                let taken = taken.max(light[c] + change[c] * difference[c]);
                squares[c] += f64::from(exact[c] - taken).powi(2);
            }
            sum += light.as_dvec3();
        }
        let mean = sum / exact.len().max(1) as f64;
        let root = (squares / exact.len().max(1) as f64).map(f64::sqrt);
        (root / mean.max(DVec3::splat(f64::MIN_POSITIVE))).as_vec3()
    }

    /// The materials with a colour at this `level`, and the difference of its parameter.
    fn painted(&self, colour: usize, level: f32) -> (Vec<Material>, Rgb) {
        let mut materials = self.stage.materials.clone();
        let OwnColour { group, of, now } = self.colours[colour];
        let end = Rgb::splat(level);
        let (paint, difference) = match of {
            ColourOf::Diffuse => (Paint { rho_d: Some(end), ..Paint::default() }, end - now),
            ColourOf::Specular => (Paint { rho_s: Some(end), ..Paint::default() }, end - now),
            ColourOf::Texture => {
                let tint = end / now.max(Rgb::splat(f32::MIN_POSITIVE));
                (Paint { tint: Some(tint), ..Paint::default() }, tint - Rgb::ONE)
            }
        };
        // Roughnesses stay as they are.
        let _ = paint.onto(&mut materials[group]);
        (materials, difference)
    }

    /// For each colour and lamp the error of its share in the light.
    fn by_lamp(&self, now: &[Rgb], slopes: &[Rgb]) -> Vec<Vec<f64>> {
        let mean = mean(now).max(f64::MIN_POSITIVE);
        let each = self.parameters.len();
        let mut errors = vec![Vec::new(); each];
        for lamp in self.stage.lamps() {
            let mut lights = vec![Rgb::ZERO; self.stage.lights.len()];
            lamp.places.iter().for_each(|place| lights[*place as usize] = Rgb::ONE);
            let alone = Appearance { lights: &lights, ..self.stage.now() };
            let alone = self.paths.replay(self.stage.tracer, alone, &self.parameters, None);
            for (colour, errors) in errors.iter_mut().enumerate() {
                let unit = self.colours[colour].unit();
                let off = (0..now.len()).map(|pixel| {
                    let of = |all: &[Rgb]| all[pixel * each + colour] / unit;
                    let share =
                        alone.radiance[pixel] / now[pixel].max(Rgb::splat(f32::MIN_POSITIVE));
                    let taken = of(slopes) * share;
                    let is_lit = now[pixel].min_element() > 0.0;
                    of(&alone.derivatives) - if is_lit { taken } else { Rgb::ZERO }
                });
                errors.push(root_mean_square(off) / mean);
            }
        }
        errors
    }
}

/// The mean of all channels.
fn mean(values: &[Rgb]) -> f64 {
    let sum: f64 = values.iter().map(|rgb| f64::from(rgb.element_sum())).sum();
    sum / (3 * values.len().max(1)) as f64
}

/// The root mean square of all channels.
fn root_mean_square(values: impl Iterator<Item = Rgb>) -> f64 {
    let (sum, count) = values.fold((0.0, 0usize), |(sum, count), rgb| {
        (sum + rgb.as_dvec3().length_squared(), count + 1)
    });
    (sum / (3 * count.max(1)) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::playable::separated::separate;
    use glam::Vec3;
    use unrender_render::Tracer;
    use unrender_scene::{Camera, Group, Mesh, Object, Scene};

    /// A red wall beside a grey floor that it lights, under two lamps, one of them near the wall.
    fn corner() -> Scene {
        let square = |centre: Vec3, across: Vec3, up: Vec3| {
            let corners = [-across - up, across - up, across + up, up - across];
            Mesh::flat(&corners.map(|c| centre + c), &[], &[[0, 1, 2], [0, 2, 3]])
        };
        let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z];
        let parts = [
            ("floor", Rgb::splat(0.5), Rgb::ZERO, square(Vec3::ZERO, x, -z)),
            ("wall", Rgb::new(0.6, 0.2, 0.1), Rgb::ZERO, square(y - z, x, y)),
            ("high", Rgb::ZERO, Rgb::splat(5.0), square(2.0 * y, 0.3 * x, 0.3 * z)),
            ("low", Rgb::ZERO, Rgb::splat(9.0), square(0.5 * y + 0.9 * z, 0.1 * x, 0.1 * y)),
        ];
        let mut scene = Scene::default();
        for (group, (name, rho, emission, mesh)) in parts.into_iter().enumerate() {
            scene.objects.push(Object { name: name.into(), group, mesh });
            let material = Material::diffuse(rho);
            scene.groups.push(Group { name: name.into(), material, emission });
        }
        let eye = Vec3::new(0.3, 1.2, 3.0);
        scene.cameras.push(Camera::look_at("c", eye, 0.5 * Vec3::Y, Vec3::Y, 0.7));
        scene.validate().unwrap();
        scene
    }

    #[test]
    fn what_the_page_shows_is_off_by_what_it_says() {
        let scene = corner();
        let tracer = Tracer::new(&scene);
        let mut stage = Stage::new((&scene, &tracer), &[], scene.cameras[0].clone());
        stage.size = (24, 24);
        let settings = Settings { spp: 1024, ..Settings::default() };
        let separated = separate(&stage, &settings, &|_| {});
        let colours = stage.colours();
        let wall = colours.iter().position(|paint| paint.group == 1).unwrap();
        let errors = &errors(&stage, &colours, 0)[wall];

        let render = |materials: &[Material]| {
            tracer.render(materials, &stage.camera, stage.size, &settings, &|_| {}).mean
        };
        let now = render(&stage.materials);
        for level in ENDS {
            let mut painted = stage.materials.clone();
            painted[1].rho_d = Rgb::splat(level);
            let exact = render(&painted);
            let response = &separated.colours.iter().find(|c| c.own.group == 1).unwrap().response;
            let own = stage.materials[1].rho_d;
            for c in 0..3 {
                let shown = |pixel: usize| {
                    let (light, change) = (now.pixels()[pixel][c], response.pixels()[pixel][c]);
                    let power = (level / own[c]).powf(own[c] * change);
                    light * power.max(1.0 + change * (level - own[c]))
                };
                let squares: f64 = (0..24 * 24)
                    .map(|pixel| f64::from(exact.pixels()[pixel][c] - shown(pixel)).powi(2))
                    .sum();
                let mean: f64 = now.pixels().iter().map(|v| f64::from(v[c])).sum::<f64>() / 576.0;
                let found = (squares / 576.0).sqrt() / mean;
                let (_, said) = *errors.first_order[c].iter().find(|(at, _)| *at == level).unwrap();
                // Noise of the pictures is below half a percent.
                assert!(found < 1.3 * said + 0.01, "{level} {c}: {found}, said {said}");
                assert!(said < 1.3 * found + 0.01, "{level} {c}: {found}, said {said}");
            }
        }
    }

    #[test]
    fn shares_of_lamps_are_those_of_their_pictures() {
        let scene = corner();
        let tracer = Tracer::new(&scene);
        let mut stage = Stage::new((&scene, &tracer), &[3], scene.cameras[0].clone());
        stage.size = (24, 24);
        let settings = Settings { spp: 1024, ..Settings::default() };
        let lamps = separate(&stage, &settings, &|_| {}).lamps;
        let named: Vec<(&str, bool)> = lamps.iter().map(|l| (&*l.name, l.is_on)).collect();
        assert_eq!(named, [("high", true), ("low", false)]);
        let lit = |lights: &[Rgb]| {
            let appearance = Appearance { materials: &stage.materials, lights };
            tracer.render(appearance, &stage.camera, stage.size, &settings, &|_| {}).mean
        };
        let [zero, one] = [Rgb::ZERO, Rgb::ONE];
        let (alone, both) = (lit(&[one, one, one, zero]), lit(&[one; 4]));
        let mut squares = 0.0;
        for pixel in 0..24 * 24 {
            let [first, second] = [0, 1].map(|lamp: usize| lamps[lamp].share.pixels()[pixel]);
            let all = both.pixels()[pixel];
            if all.min_element() > 0.0 {
                assert!((first + second - Rgb::ONE).abs().max_element() < 1e-5);
                squares += (first - alone.pixels()[pixel] / all).length_squared() / 3.0;
            }
        }
        let root = (squares / 576.0).sqrt();
        assert!(root < 0.01, "{root}");
    }
}
