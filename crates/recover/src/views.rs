//! The renderer behind several cameras: what is asked of pixels of a sheet is asked of the photographs that they
//! are of.

use crate::rerender::{Renderer, Stored};
use crate::sheet::Sheet;
use std::ops::Range;
use unrender_render::sampler::mix;
use unrender_render::{
    Appearance, GeometryBuffers, Jacobian, Parameter, PixelGeometry, ProbeSettings, Probes,
    RadianceCache, Settings,
};
use unrender_scene::{BrdfModel, Rgb};

/// One photograph's renderer, and its light.
pub struct Shot<'a> {
    /// What its camera sees.
    pub renderer: Box<dyn Renderer + 'a>,
    /// The sources of light that were off, numbered as in [`Appearance::lights`].
    pub off: Vec<u32>,
}

/// The renderers of all photographs of a [`Sheet`].
pub struct Views<'a> {
    sheet: Sheet,
    shots: Vec<Shot<'a>>,
    geometry: GeometryBuffers,
}

impl<'a> Views<'a> {
    /// The views of `shots`, in the order of the sheet. All see one scene.
    ///
    /// # Panics
    /// If there are none.
    pub fn new(shots: Vec<Shot<'a>>) -> Self {
        assert!(!shots.is_empty(), "a view needs a photograph");
        let seen: Vec<&GeometryBuffers> =
            shots.iter().map(|shot| shot.renderer.geometry()).collect();
        let sizes: Vec<(usize, usize)> =
            seen.iter().map(|picture| (picture.width(), picture.height())).collect();
        let sheet = Sheet::of(&sizes);
        let geometry = sheet.stack(&seen, &PixelGeometry::EMPTY);
        Self { sheet, shots, geometry }
    }

    /// Where each photograph stands.
    pub fn sheet(&self) -> &Sheet {
        &self.sheet
    }

    /// The runs of `pixels` that are of one photograph: its number, and which of them.
    fn runs<P>(&self, pixels: &[P], pixel: impl Fn(&P) -> u32) -> Vec<(usize, Range<usize>)> {
        let mut runs: Vec<(usize, Range<usize>)> = Vec::new();
        for (place, of) in pixels.iter().enumerate() {
            let photograph = self.sheet.photograph_of(pixel(of));
            match runs.last_mut() {
                Some((last, run)) if *last == photograph => run.end = place + 1,
                _ => runs.push((photograph, place..place + 1)),
            }
        }
        runs
    }

    /// The number of `pixel` in its photograph. Nobody asks for pixels between photographs, as no group is seen there.
    fn local(&self, pixel: u32) -> u32 {
        self.sheet.in_photograph(pixel).unwrap_or_default()
    }

    fn in_photograph(&self, pixels: &[u32]) -> Vec<u32> {
        pixels.iter().map(|pixel| self.local(*pixel)).collect()
    }

    /// What of `seen` is of `photograph`: a path ends where its own photograph knows the radiance.
    fn cut(&self, seen: Option<&RadianceCache>, photograph: usize) -> Option<RadianceCache> {
        seen.map(|seen| RadianceCache {
            radiance: self.sheet.cut(&seen.radiance, photograph),
            valid: self.sheet.cut(&seen.valid, photograph),
        })
    }

    /// The brightness of all sources in the light of `photograph`.
    fn lights(&self, appearance: Appearance<'_>, photograph: usize) -> Vec<Rgb> {
        let mut lights = appearance.lights.to_vec();
        for &source in &self.shots[photograph].off {
            if lights.len() <= source as usize {
                lights.resize(source as usize + 1, Rgb::ONE);
            }
            lights[source as usize] = Rgb::ZERO;
        }
        lights
    }

    /// In `photograph`, what is off changes nothing, however bright it is when it is on.
    fn switch_off(&self, photograph: usize, parameters: &[Parameter], jacobian: &mut Jacobian) {
        for row in jacobian.derivatives.chunks_mut(parameters.len().max(1)) {
            for (derivative, parameter) in row.iter_mut().zip(parameters) {
                if matches!(parameter, Parameter::Light(source) if self.shots[photograph].off.contains(source))
                {
                    *derivative = Rgb::ZERO;
                }
            }
        }
    }
}

/// Each photograph has random numbers of its own; those of the first are those that it would have alone.
fn seed(seed: u64, photograph: usize) -> u64 {
    if photograph == 0 { seed } else { mix(mix(seed) ^ photograph as u64) }
}

fn append(all: &mut Jacobian, part: Jacobian) {
    all.radiance.extend(part.radiance);
    all.derivatives.extend(part.derivatives);
}

/// The paths of some pixels, photograph by photograph.
struct PathsOf<'v, 'a> {
    views: &'v Views<'a>,
    runs: Vec<(usize, Box<dyn Stored + 'v>)>,
}

impl Stored for PathsOf<'_, '_> {
    fn replay(
        &self,
        appearance: Appearance<'_>,
        parameters: &[Parameter],
        seen: Option<&RadianceCache>,
    ) -> Jacobian {
        let mut all = Jacobian::default();
        for (photograph, paths) in &self.runs {
            let lights = self.views.lights(appearance, *photograph);
            let appearance = Appearance { lights: &lights, ..appearance };
            let seen = self.views.cut(seen, *photograph);
            let mut part = paths.replay(appearance, parameters, seen.as_ref());
            self.views.switch_off(*photograph, parameters, &mut part);
            append(&mut all, part);
        }
        all
    }
}

impl Renderer for Views<'_> {
    fn geometry(&self) -> &GeometryBuffers {
        &self.geometry
    }

    fn model(&self) -> BrdfModel {
        self.shots[0].renderer.model()
    }

    fn probe(
        &self,
        appearance: Appearance<'_>,
        pixels: &[u32],
        settings: &ProbeSettings,
        seen: Option<&RadianceCache>,
    ) -> Probes {
        let mut all = Probes::default();
        for (photograph, run) in self.runs(pixels, |pixel| *pixel) {
            let lights = self.lights(appearance, photograph);
            let appearance = Appearance { lights: &lights, ..appearance };
            let settings =
                ProbeSettings { seed: seed(settings.seed, photograph), ..settings.clone() };
            let (pixels, seen) = (self.in_photograph(&pixels[run]), self.cut(seen, photograph));
            let renderer = &self.shots[photograph].renderer;
            let mut part = renderer.probe(appearance, &pixels, &settings, seen.as_ref());
            for probe in &mut part.probes {
                probe.pixel = self.sheet.pixel(photograph, probe.pixel);
            }
            all.append(part);
        }
        all
    }

    fn jacobian(
        &self,
        appearance: Appearance<'_>,
        pixels: &[(u32, Range<u32>)],
        parameters: &[Parameter],
        settings: &Settings,
        seen: Option<&RadianceCache>,
    ) -> Jacobian {
        let mut all = Jacobian::default();
        for (photograph, run) in self.runs(pixels, |(pixel, _)| *pixel) {
            let lights = self.lights(appearance, photograph);
            let appearance = Appearance { lights: &lights, ..appearance };
            let settings = Settings { seed: seed(settings.seed, photograph), ..*settings };
            let pixels = pixels[run].iter();
            let pixels: Vec<(u32, Range<u32>)> =
                pixels.map(|(pixel, paths)| (self.local(*pixel), paths.clone())).collect();
            let (seen, renderer) = (self.cut(seen, photograph), &self.shots[photograph].renderer);
            let mut part =
                renderer.jacobian(appearance, &pixels, parameters, &settings, seen.as_ref());
            self.switch_off(photograph, parameters, &mut part);
            append(&mut all, part);
        }
        all
    }

    fn store<'s>(
        &'s self,
        appearance: Appearance<'_>,
        pixels: &[u32],
        parameters: &[Parameter],
        settings: &Settings,
        seen: Option<&RadianceCache>,
    ) -> Box<dyn Stored + 's> {
        let store = |(photograph, run): (usize, Range<usize>)| {
            let lights = self.lights(appearance, photograph);
            let appearance = Appearance { lights: &lights, ..appearance };
            let settings = Settings { seed: seed(settings.seed, photograph), ..*settings };
            let (pixels, seen) = (self.in_photograph(&pixels[run]), self.cut(seen, photograph));
            let renderer = &self.shots[photograph].renderer;
            (photograph, renderer.store(appearance, &pixels, parameters, &settings, seen.as_ref()))
        };
        let runs = self.runs(pixels, |pixel| *pixel).into_iter().map(store).collect();
        Box::new(PathsOf { views: self, runs })
    }

    fn rerender(
        &self,
        appearance: Appearance<'_>,
        pixels: &[u32],
        settings: &Settings,
    ) -> Vec<Rgb> {
        let mut all = Vec::with_capacity(pixels.len());
        for (photograph, run) in self.runs(pixels, |pixel| *pixel) {
            let lights = self.lights(appearance, photograph);
            let appearance = Appearance { lights: &lights, ..appearance };
            let settings = Settings { seed: seed(settings.seed, photograph), ..*settings };
            let pixels = self.in_photograph(&pixels[run]);
            all.extend(self.shots[photograph].renderer.rerender(appearance, &pixels, &settings));
        }
        all
    }

    fn picture(
        &self,
        appearance: Appearance<'_>,
        settings: &Settings,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Vec<Rgb> {
        let count = self.shots.len() as f64;
        let picture = |(photograph, shot): (usize, &Shot<'_>)| {
            let lights = self.lights(appearance, photograph);
            let appearance = Appearance { lights: &lights, ..appearance };
            let settings = Settings { seed: seed(settings.seed, photograph), ..*settings };
            let progress = |done: f64| progress((photograph as f64 + done) / count);
            let [_, _, width, height] = self.sheet.place(photograph);
            let pixels = shot.renderer.picture(appearance, &settings, &progress);
            unrender_scene::RgbImage::new(width, height, pixels)
        };
        let pictures: Vec<_> = self.shots.iter().enumerate().map(picture).collect();
        let pictures: Vec<_> = pictures.iter().collect();
        self.sheet.stack(&pictures, &Rgb::ZERO).into_pixels()
    }
}
