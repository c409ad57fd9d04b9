//! A sky that the scene lacks: the photograph shows light where the model has nothing, or fits better with light from
//! outside.
//!
//! Within a group of one diffuse material, the photograph `P` is proportional to the light `L + s S`, where `L` is that of the
//! scene and `S` that of a white sky, interreflection included. For each channel, the `s` is found that minimises
//!
//! ```text
//! sum over groups and pixels of min(|ln P - ln (L + s S) - median of the group|, FAR)
//! ```
//!
//! The median stands for the group's reflectance; absolute values keep textures and highlights from deciding. The
//! reflectances in `L` and `S` are those of a first look: the group's median ratio to the light, four times, as each changes
//! the light of the others. Cost: six renderings of two thousand pixels, and a tracer with a sky.

use super::finding::{Findings, Gravity};
use super::lights::{is_open, seen_points};
use super::{GREY, Subject};
use crate::lighting::uniform;
use unrender_photo::Exposure;
use unrender_recover::{Renderer, Role, View};
use unrender_render::{Appearance, NOTHING, Settings, Tracer};
use unrender_scene::color::luminance;
use unrender_scene::{Material, Rgb, Scene};

/// Pixels that are looked at, of all groups together, and of each group, the least and the most. With half of them the
/// daylight of a bedroom stays unnoticed; double takes twice as long.
const PIXELS: usize = 2000;
const PIXELS_OF_GROUP: [usize; 2] = [30, 200];
/// Paths a pixel, and their reflections. Half of the paths is as noisy as a photograph's shadows; double takes twice as long.
const SPP: u32 = 32;
const BOUNCES: u32 = 5;
/// How often the reflectances are looked at. After half of the looks white rooms are too dark; double changes nothing.
const LOOKS: usize = 4;
/// Reflectances of a first look are between these. At half of the lower one noise makes black groups, and a higher upper one
/// lets light in a closed room grow without end.
const ALBEDO: [f32; 2] = [0.03, 0.9];
/// Logarithms of ratios count up to this much, a factor of e: what differs more has other causes. At half of it large errors
/// of the light weigh no more than small ones; at double mirrors decide.
const FAR: f32 = 1.0;
/// Factors that are tried in each direction, two for each doubling: a sky up to 32 times as bright as the lamps, or that much
/// fainter. Half of them miss noon.
const STEPS: i32 = 10;
/// A sky that brings less than this share of the light is not told of: at half of it a room without one is accused, as a sky
/// acts like reflections that are not known yet; at double two of three rooms of artists are dark without a word.
const SKY: f32 = 0.15;
/// It has to explain this share of the misfit, by so many standard deviations from cell to cell of the picture. At half of
/// either any light from all around does; at double it has to be the only light.
const SHARE: f64 = 0.04;
const CERTAIN: f64 = 3.0;
/// The cells of the picture along a side. Half of them are too few for a standard deviation, double are not independent.
const CELLS: usize = 8;
/// A sky is at most so many times as bright in one channel as in another; a coloured reflection is more. The sky of a clear
/// evening is about 3 times as blue as red; double of it is no sky.
const COLOURFUL: f32 = 4.0;
/// The photograph shows a sky where this share of it has nothing of the model behind it, brighter than this share of its
/// mean. At a tenth of the first one cracks between walls count, at ten times a window far away does not; black backgrounds
/// have noise of a tenth of the second one.
const EMPTY: f32 = 0.001;
const BRIGHT: f32 = 0.1;

/// What to do.
const REMEDY: &str = "If light comes from outside, let the recovery find it: [environment] with unknown = true, or \
                      panorama = \"FILE\" for a picture of it that you have";
const LINES: &str = "[environment]\nunknown = true";

/// The finding of a sky that the scene lacks.
pub(super) fn warnings(subject: &Subject<'_>) -> Findings {
    let mut findings = Findings::default();
    if subject.job.scene.environment.is_some() {
        return findings;
    }
    let told = if let Some(share) = seen(subject) {
        format!(
            "{:.1} % of the photo show light where the model has nothing, and the scene has no sky. {REMEDY}; or model \
             what stands there",
            100.0 * share
        )
    } else if let Some(share) = missing(subject) {
        format!(
            "the photo looks as if about {:.0} % of its light came from outside, through openings of the model, and the \
             scene has no sky. {REMEDY}",
            100.0 * share
        )
    } else {
        return findings;
    };
    findings.push_with(Gravity::All, told, LINES.to_owned());
    findings
}

/// The share of the photograph that is bright where the model has nothing; none if that is next to nothing.
fn seen(subject: &Subject<'_>) -> Option<f32> {
    let geometry = subject.geometry;
    let (values, pixels) = (&subject.observation.picture.values, geometry.pixels());
    let light = |index: usize| luminance(values.pixels()[index]);
    let mean = (0..pixels.len()).map(light).sum::<f32>() / pixels.len().max(1) as f32;
    let is_empty = |index: usize| pixels[index].object == NOTHING;
    // At an edge a pixel shows both sides.
    let is_inside = |index: usize| is_empty(index) && geometry.neighbourhood(index).all(is_empty);
    let counts = subject.job.counts(0, (&subject.registered.camera, geometry));
    let bright =
        (0..pixels.len()).filter(|i| counts[*i] && light(*i) > BRIGHT * mean && is_inside(*i));
    let share = bright.count() as f32 / pixels.len().max(1) as f32;
    (share > EMPTY).then_some(share)
}

/// The share of the light that a sky would bring, if the photograph fits better with one; its colour is free.
fn missing(subject: &Subject<'_>) -> Option<f32> {
    let (scene, tracer) = (&subject.job.scene, subject.tracer);
    if !is_open(tracer, &seen_points(subject)) {
        return None;
    }
    let balance = Balance::of(subject)?;
    let with = Scene { environment: uniform(Rgb::ONE), ..scene.clone() };
    let with = Tracer::new(&with);
    let size = (subject.geometry.width(), subject.geometry.height());
    let view = View::new(&with, &subject.registered.camera, size, scene.brdf);
    let mut lights = vec![Rgb::ZERO; scene.groups.len() + scene.lights.len()];
    lights.push(Rgb::ONE);
    let found = balance.sky(&balance.rendered(&view, &lights));
    let is_plain = found.brightness.max_element() < COLOURFUL * found.brightness.min_element();
    let bright = luminance(found.brightness);
    let share = bright / (1.0 + bright);
    (is_plain && share > SKY && found.gain > SHARE && found.deviations > CERTAIN).then_some(share)
}

/// The photograph and the light of the scene at some pixels.
struct Balance {
    /// The pixels, those of one group together, and where each group ends.
    pixels: Vec<u32>,
    ends: Vec<usize>,
    /// The cell of the picture in which each lies.
    cells: Vec<usize>,
    shown: Vec<Rgb>,
    /// The reflectances of a first look.
    materials: Vec<Material>,
    /// The light of all sources.
    light: Vec<Rgb>,
}

/// A sky that fits.
struct Sky {
    /// How bright it is, by channel, in units of the light of the scene.
    brightness: Rgb,
    /// The share of the misfit that it explains, and by how many standard deviations.
    gain: f64,
    deviations: f64,
}

impl Balance {
    /// None if too little of the scene is seen, or nothing of it is lit.
    fn of(subject: &Subject<'_>) -> Option<Self> {
        let (width, height) = (subject.geometry.width(), subject.geometry.height());
        let (pixels, ends, groups) = chosen(subject);
        let cell = |pixel: &u32| {
            let (x, y) = (*pixel as usize % width, *pixel as usize / width);
            y * CELLS / height * CELLS + x * CELLS / width
        };
        let values = subject.observation.picture.values.pixels();
        let shown: Vec<Rgb> = pixels.iter().map(|pixel| values[*pixel as usize]).collect();
        let cells = pixels.iter().map(cell).collect();
        let materials = (subject.specs.iter())
            .map(|spec| match spec.role {
                Role::Unknown => Material::diffuse(GREY),
                Role::Known | Role::Emitter => spec.material.clone(),
            })
            .collect();
        let mut balance = Self { pixels, ends, cells, shown, materials, light: Vec::new() };
        let (camera, model) = (&subject.registered.camera, subject.job.scene.brdf);
        let view = View::new(subject.tracer, camera, (width, height), model);
        balance.light = balance.rendered(&view, &[]);
        if balance.light.iter().all(|light| *light == Rgb::ZERO) {
            return None;
        }
        for _ in 0..LOOKS {
            balance.look(subject, &groups);
            balance.light = balance.rendered(&view, &[]);
        }
        Some(balance)
    }

    /// Gives the unknown ones of `groups` the reflectances of a first look.
    fn look(&mut self, subject: &Subject<'_>, groups: &[usize]) {
        let ratios: Vec<Rgb> = (self.ranges())
            .map(|range| median_ratio(&self.shown[range.clone()], &self.light[range]))
            .collect();
        // Where no exposure is stated, the usual group is grey.
        let scale = match subject.job.project.exposure {
            Exposure::Auto => {
                let usual = super::median(ratios.iter().map(|ratio| luminance(*ratio)));
                usual.unwrap_or(1.0).max(1e-6).recip()
            }
            Exposure::Fixed(_) => 1.0,
        };
        let [low, high] = ALBEDO.map(Rgb::splat);
        for (group, ratio) in groups.iter().zip(ratios) {
            if subject.specs[*group].role == Role::Unknown {
                let before = self.materials[*group].rho_d;
                let rho_d = (before * ratio * scale).clamp(low, high);
                self.materials[*group] = Material::diffuse(rho_d);
            }
        }
    }

    fn ranges(&self) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, end)| start..*end)
    }

    /// What the pixels show in the light of sources with these factors.
    fn rendered(&self, view: &View<'_>, lights: &[Rgb]) -> Vec<Rgb> {
        let appearance = Appearance { materials: &self.materials, lights };
        let settings = Settings { spp: SPP, max_bounces: BOUNCES, ..Settings::default() };
        view.rerender(appearance, &self.pixels, &settings)
    }

    /// What is misfit at each pixel and channel with `more` light beside that of the scene.
    fn misfit(&self, more: impl Fn(usize) -> Rgb) -> Vec<Rgb> {
        let left = |i: usize| ln(self.shown[i]) - ln(self.light[i] + more(i));
        let mut misfits = Vec::with_capacity(self.pixels.len());
        for range in self.ranges() {
            let left: Vec<Rgb> = range.map(left).collect();
            let middle = median(&left);
            misfits.extend(left.iter().map(|left| (*left - middle).abs().min(Rgb::splat(FAR))));
        }
        misfits
    }

    /// How bright a sky fits best, channel by channel, that brings `white` if it is white.
    fn sky(&self, white: &[Rgb]) -> Sky {
        let sum = |light: &[Rgb]| light.iter().sum::<Rgb>();
        let unit = sum(&self.light) / sum(white).max(Rgb::splat(1e-9));
        let factors = (-2 * STEPS..=STEPS).map(|step| 2f32.powf(0.5 * step as f32));
        let of = |factor: f32| (factor, self.misfit(|i| white[i] * unit * factor));
        let tried: Vec<(f32, Vec<Rgb>)> = std::iter::once(0.0).chain(factors).map(of).collect();
        let total = |misfit: &[Rgb], channel: usize| -> f64 {
            misfit.iter().map(|of_pixel| f64::from(of_pixel[channel])).sum()
        };
        let best = [0, 1, 2].map(|channel: usize| {
            let by = |k: &usize| total(&tried[*k].1, channel);
            (0..tried.len()).min_by(|a, b| by(a).total_cmp(&by(b))).unwrap_or(0)
        });
        let mut sums = [0.0; CELLS * CELLS];
        for (i, cell) in self.cells.iter().enumerate() {
            for (channel, best) in best.iter().enumerate() {
                sums[*cell] += f64::from(tried[0].1[i][channel] - tried[*best].1[i][channel]);
            }
        }
        let gain: f64 = sums.iter().sum();
        let squares: f64 = sums.iter().map(|sum| sum * sum).sum();
        let all: f64 = (0..3).map(|channel| total(&tried[0].1, channel)).sum();
        Sky {
            brightness: Rgb::from_array(best.map(|best| tried[best].0)),
            gain: gain / all.max(1e-9),
            deviations: gain / squares.sqrt().max(1e-9),
        }
    }
}

/// Valid pixels, those of one group together, where each group ends, and the groups.
fn chosen(subject: &Subject<'_>) -> (Vec<u32>, Vec<usize>, Vec<usize>) {
    let [fewest, most] = PIXELS_OF_GROUP;
    let count = (PIXELS / subject.specs.len().max(1)).clamp(fewest, most);
    let (mut pixels, mut ends, mut groups) = (Vec::new(), Vec::new(), Vec::new());
    for (group, of_group) in subject.observation.pixels_of_group.iter().enumerate() {
        if subject.specs[group].role != Role::Emitter && of_group.len() >= fewest {
            pixels.extend(unrender_recover::observe::blocks::spread(of_group, count, 0));
            ends.push(pixels.len());
            groups.push(group);
        }
    }
    (pixels, ends, groups)
}

/// The logarithm, by channel, of what is at least a little.
fn ln(value: Rgb) -> Rgb {
    value.max(Rgb::splat(1e-6)).map(f32::ln)
}

fn median(values: &[Rgb]) -> Rgb {
    let of =
        |channel: usize| super::median(values.iter().map(|value| value[channel])).unwrap_or(0.0);
    Rgb::from_array([0, 1, 2].map(of))
}

/// The median, by channel, of the ratios of two lists.
fn median_ratio(shown: &[Rgb], light: &[Rgb]) -> Rgb {
    let ratios: Vec<Rgb> =
        shown.iter().zip(light).map(|(shown, light)| ln(*shown) - ln(*light)).collect();
    median(&ratios).map(f32::exp)
}
