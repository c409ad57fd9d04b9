//! The renderer behind several cameras: requests for pixels of a sheet go to the photographs that they are of.

use super::{Renderer, Stored};
use crate::sampler::mix;
use crate::{
    Appearance, GeometryBuffers, Jacobian, Parameter, PixelGeometry, ProbeSettings, Probes, Query,
    RadianceCache, Settings,
};
use glam::Vec3;
use std::ops::Range;
use unrender_scene::{BrdfModel, Rgb, RgbImage, Sheet};

/// The renderers of all photographs of a [`Sheet`].
pub struct Views<'a> {
    sheet: Sheet,
    each: Vec<Box<dyn Renderer + 'a>>,
    geometry: GeometryBuffers,
}

impl<'a> Views<'a> {
    /// The views of several photographs, in the order of the sheet. All see one scene; lamps may be off in some.
    ///
    /// # Panics
    /// If there are none.
    pub fn new(each: Vec<Box<dyn Renderer + 'a>>) -> Self {
        assert!(!each.is_empty(), "a view needs a photograph");
        let seen = || each.iter().map(|of| of.geometry());
        let sizes: Vec<(usize, usize)> =
            seen().map(|picture| (picture.width(), picture.height())).collect();
        let sheet = Sheet::of(&sizes);
        let geometry = sheet.stack(seen(), &PixelGeometry::EMPTY);
        Self { sheet, each, geometry }
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

    /// The part of `seen` for `photograph`: a path ends where its own photograph knows the
    /// radiance.
    fn cut(&self, seen: Option<&RadianceCache>, photograph: usize) -> Option<RadianceCache> {
        seen.map(|seen| RadianceCache {
            radiance: self.sheet.cut(&seen.radiance, photograph),
            valid: self.sheet.cut(&seen.valid, photograph),
        })
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
struct SheetPaths<'v, 'a> {
    views: &'v Views<'a>,
    runs: Vec<(usize, Box<dyn Stored + 'v>)>,
}

impl Stored for SheetPaths<'_, '_> {
    fn replay(
        &self,
        appearance: Appearance<'_>,
        parameters: &[Parameter],
        seen: Option<&RadianceCache>,
    ) -> Jacobian {
        let mut all = Jacobian::default();
        for (photograph, paths) in &self.runs {
            let seen = self.views.cut(seen, *photograph);
            let part = paths.replay(appearance, parameters, seen.as_ref());
            append(&mut all, part);
        }
        all
    }
}

impl Renderer for Views<'_> {
    fn geometry(&self) -> &GeometryBuffers {
        &self.geometry
    }

    fn point(&self, pixel: u32) -> Option<Vec3> {
        self.each[self.sheet.photograph_of(pixel)].point(self.local(pixel))
    }

    fn model(&self) -> BrdfModel {
        self.each[0].model()
    }

    fn probe(&self, query: &Query<'_, u32, ProbeSettings>) -> Probes {
        let mut all = Probes::default();
        for (photograph, run) in self.runs(query.pixels, |pixel| *pixel) {
            let seed = seed(query.settings.seed, photograph);
            let settings = ProbeSettings { seed, ..query.settings.clone() };
            let pixels = self.in_photograph(&query.pixels[run]);
            let seen = self.cut(query.seen, photograph);
            let mut part = self.each[photograph].probe(&Query {
                pixels: &pixels,
                settings: &settings,
                seen: seen.as_ref(),
                ..*query
            });
            for probe in &mut part.probes {
                probe.pixel = self.sheet.pixel(photograph, probe.pixel);
            }
            all.append(part);
        }
        all
    }

    fn jacobian(&self, query: &Query<'_, (u32, Range<u32>)>) -> Jacobian {
        let mut all = Jacobian::default();
        for (photograph, run) in self.runs(query.pixels, |(pixel, _)| *pixel) {
            let seed = seed(query.settings.seed, photograph);
            let settings = Settings { seed, ..*query.settings };
            let pixels = query.pixels[run].iter();
            let pixels: Vec<(u32, Range<u32>)> =
                pixels.map(|(pixel, paths)| (self.local(*pixel), paths.clone())).collect();
            let seen = self.cut(query.seen, photograph);
            let part = self.each[photograph].jacobian(&Query {
                pixels: &pixels,
                settings: &settings,
                seen: seen.as_ref(),
                ..*query
            });
            append(&mut all, part);
        }
        all
    }

    fn store<'s>(&'s self, query: &Query<'_>) -> Box<dyn Stored + 's> {
        let store = |(photograph, run): (usize, Range<usize>)| {
            let seed = seed(query.settings.seed, photograph);
            let settings = Settings { seed, ..*query.settings };
            let pixels = self.in_photograph(&query.pixels[run]);
            let seen = self.cut(query.seen, photograph);
            let stored = self.each[photograph].store(&Query {
                pixels: &pixels,
                settings: &settings,
                seen: seen.as_ref(),
                ..*query
            });
            (photograph, stored)
        };
        let runs = self.runs(query.pixels, |pixel| *pixel).into_iter().map(store).collect();
        Box::new(SheetPaths { views: self, runs })
    }

    fn rerender(
        &self,
        appearance: Appearance<'_>,
        pixels: &[u32],
        settings: &Settings,
    ) -> Vec<Rgb> {
        let mut all = Vec::with_capacity(pixels.len());
        for (photograph, run) in self.runs(pixels, |pixel| *pixel) {
            let settings = Settings { seed: seed(settings.seed, photograph), ..*settings };
            let pixels = self.in_photograph(&pixels[run]);
            all.extend(self.each[photograph].rerender(appearance, &pixels, &settings));
        }
        all
    }

    fn picture(
        &self,
        appearance: Appearance<'_>,
        settings: &Settings,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Vec<Rgb> {
        let count = self.each.len() as f64;
        let picture = |photograph: usize| {
            let settings = Settings { seed: seed(settings.seed, photograph), ..*settings };
            let progress = |done: f64| progress((photograph as f64 + done) / count);
            let [_, _, width, height] = self.sheet.place(photograph);
            let pixels = self.each[photograph].picture(appearance, &settings, &progress);
            RgbImage::new(width, height, pixels)
        };
        let pictures: Vec<_> = (0..self.each.len()).map(picture).collect();
        self.sheet.stack(&pictures, &Rgb::ZERO).into_pixels()
    }
}
