//! What the photograph shows of each group: which pixels are valid.
//!
//! Every pixel has a [`PixelStatus`]: it is valid, or there is a reason why not. The photograph may be clipped there;
//! an edge of the model may be too close, given the error of its registration ([`unrender_register`]); or the pixel may
//! be an outlier of its group ([`crate::outliers`]). A group that would lose nearly all its pixels gets a narrower
//! margin. Their noise is estimated in [`crate::observe::noise`].

pub use crate::observe::noise::{Noise, PhotographNoise};
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};
use unrender_register::margin::{self, near_edges};
use unrender_register::offset::EdgePicture;
use unrender_register::steep::steepness;
use unrender_render::{GeometryBuffers, NOTHING};
use unrender_scene::Sheet;
use unrender_scene::{Image, Rgb, RgbImage};

/// The photograph, developed: linear values with a valid mask and a quantisation step per pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Radiance before the exposure is applied.
    pub values: RgbImage,
    /// False for pixels that are clipped or broken.
    pub valid: Image<bool>,
    /// True for pixels whose value is a lower bound: the camera or the file cut them off at the top.
    pub saturated: Image<bool>,
    /// The quantisation step at this pixel, in units of `values`; zero for float files.
    pub quantisation_step: RgbImage,
}

impl Picture {
    /// Several photographs on their `sheet`; between them nothing is valid.
    fn on_sheet(sheet: &Sheet, each: &[Observation]) -> Self {
        let pictures = || each.iter().map(|one| &one.picture);
        Self {
            values: sheet.stack(pictures().map(|one| &one.values), &Rgb::ZERO),
            valid: sheet.stack(pictures().map(|one| &one.valid), &false),
            saturated: sheet.stack(pictures().map(|one| &one.saturated), &false),
            quantisation_step: sheet
                .stack(pictures().map(|one| &one.quantisation_step), &Rgb::ZERO),
        }
    }
}

/// What the value of a pixel says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reading {
    /// A measurement with noise.
    Value,
    /// The scene is at least so bright there: the pixel is clipped.
    AtLeast,
    /// Nothing: the pixel shows what is not in the model.
    Nothing,
}

/// Whether a pixel is valid, or why it is not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum PixelStatus {
    /// It counts.
    Valid,
    /// The model shows nothing there.
    Nothing,
    /// The photograph says nothing there: clipped, too dark, or broken.
    Clipped,
    /// An edge of the model is too close, or one of the photograph where the model is off.
    Edge,
    /// A single bright pixel.
    Spike,
    /// It shows something that is not in the model, or not in this place.
    Outlier,
}

/// The photograph, sorted by groups.
#[derive(Clone, Debug)]
pub struct Observation {
    /// The photograph.
    pub picture: Picture,
    /// For each pixel: whether it is valid.
    pub status: Image<PixelStatus>,
    /// For each group: the valid pixels, in scanline order.
    pub pixels_of_group: Vec<Vec<u32>>,
    /// For each group: the valid pixels and those that are a lower bound, in scanline order.
    pub informative_of_group: Vec<Vec<u32>>,
    /// For each group: all its pixels, valid or not.
    pub all_pixels_of_group: Vec<Vec<u32>>,
    /// The local mean of the valid pixels of the same object, 5 x 5.
    pub smooth: RgbImage,
    /// Where each photograph stands in the picture.
    pub sheet: Sheet,
    /// The noise of each photograph.
    pub noise_of_photograph: Vec<PhotographNoise>,
}

/// Below this many valid pixels a group falls back on all its unclipped ones.
const FEW_PIXELS: usize = 40;
/// A group keeps at least this share of its pixels.
const KEPT: f32 = 0.1;
/// The margins at edges that are tried, as shares of the required one, until a group keeps enough pixels.
const SHARES: [f32; 4] = [1.0, 0.6, 0.3, 0.0];
/// The steepness of the photograph that is tolerated where the model is off, likewise.
const STEEP: [f32; 4] = [0.1, 0.2, 0.4, 1.0];
/// A pixel this many times above all its neighbours is a firefly or a hot pixel.
const SPIKE: f32 = 3.0;

impl Observation {
    /// Sorts the photograph by the groups of `geometry`, of which there are `groups`, as if the model
    /// fitted to the pixel.
    ///
    /// # Panics
    /// If picture and geometry differ in size.
    pub fn new(picture: Picture, geometry: &GeometryBuffers, groups: usize) -> Self {
        Self::with_margins(picture, geometry, &margin::margins(geometry, None), groups)
    }

    /// Sorts the photograph by the groups of `geometry`, of which there are `groups`. `margins` says
    /// for every pixel how far from an edge it must be ([`margin::margins`]).
    ///
    /// # Panics
    /// If picture, geometry and margins differ in size.
    pub fn with_margins(
        picture: Picture,
        geometry: &GeometryBuffers,
        margins: &Image<f32>,
        groups: usize,
    ) -> Self {
        let size = picture.values.pixels().len();
        assert_eq!(size, geometry.pixels().len(), "sizes differ");
        assert_eq!(size, margins.pixels().len(), "sizes differ");
        let mut all_pixels_of_group = vec![Vec::new(); groups];
        let mut status = geometry.map(|_| PixelStatus::Nothing);
        for (index, pixel) in geometry.pixels().iter().enumerate() {
            if pixel.group != NOTHING {
                all_pixels_of_group[pixel.group as usize].push(index as u32);
                status.pixels_mut()[index] = if !picture.valid.pixels()[index] {
                    PixelStatus::Clipped
                } else if is_spike(&picture.values, index) {
                    PixelStatus::Spike
                } else {
                    PixelStatus::Valid
                };
            }
        }
        let near = SHARES.map(|share| near_edges(geometry, margins, share));
        let steepness = &steepness(&EdgePicture::new(&picture.values), margins);
        for pixels in &all_pixels_of_group {
            let near = near.each_ref().map(|near| |p: u32| near.pixels()[p as usize]);
            mark_edges(&mut status, pixels, &near);
            let steep = STEEP.map(|most| move |p: u32| steepness.pixels()[p as usize] > most);
            mark_edges(&mut status, pixels, &steep);
        }
        let is_valid = |p: &&u32| status.pixels()[**p as usize] == PixelStatus::Valid;
        let pixels_of_group: Vec<Vec<u32>> = all_pixels_of_group
            .iter()
            .map(|all| all.iter().filter(is_valid).copied().collect())
            .collect();
        let near = near_edges(geometry, margins, 1.0);
        let informs = |p: &&u32| {
            let bounds = picture.saturated.pixels()[**p as usize] && !near.pixels()[**p as usize];
            is_valid(p) || bounds
        };
        let informative_of_group =
            all_pixels_of_group.iter().map(|a| a.iter().filter(informs).copied().collect());
        let informative_of_group = informative_of_group.collect();
        let smooth = smooth(&picture.values, geometry, &pixels_of_group);
        let noise =
            PhotographNoise::of((&picture.values, &picture.quantisation_step), &pixels_of_group);
        Self {
            sheet: Sheet::of(&[(picture.values.width(), picture.values.height())]),
            picture,
            status,
            pixels_of_group,
            informative_of_group,
            all_pixels_of_group,
            smooth,
            noise_of_photograph: vec![noise],
        }
    }

    /// Several photographs on their `sheet`, each sorted by the same groups.
    ///
    /// # Panics
    /// If they are not as many and not of the sizes that the sheet says, or there are none.
    pub fn on_sheet(sheet: &Sheet, mut each: Vec<Self>) -> Self {
        assert_eq!(each.len(), sheet.photographs(), "a sheet has a place for each photograph");
        if each.len() == 1 {
            return each.remove(0);
        }
        let groups = each[0].pixels_of_group.len();
        let pixels = |of: &dyn Fn(&Self) -> &Vec<Vec<u32>>| {
            let of_group = |group: usize| {
                let all = each.iter().enumerate().flat_map(|(photograph, one)| {
                    of(one)[group].iter().map(move |pixel| sheet.pixel(photograph, *pixel))
                });
                all.collect()
            };
            (0..groups).map(of_group).collect::<Vec<Vec<u32>>>()
        };
        Self {
            sheet: sheet.clone(),
            status: sheet.stack(each.iter().map(|one| &one.status), &PixelStatus::Nothing),
            pixels_of_group: pixels(&|one| &one.pixels_of_group),
            informative_of_group: pixels(&|one| &one.informative_of_group),
            all_pixels_of_group: pixels(&|one| &one.all_pixels_of_group),
            smooth: sheet.stack(each.iter().map(|one| &one.smooth), &Rgb::ZERO),
            picture: Picture::on_sheet(sheet, &each),
            noise_of_photograph: each.into_iter().flat_map(|one| one.noise_of_photograph).collect(),
        }
    }

    /// The share of a group's pixels that show something else.
    pub fn outlier_share(&self, group: usize) -> f64 {
        let all = &self.all_pixels_of_group[group];
        let outliers =
            all.iter().filter(|p| self.status.pixels()[**p as usize] == PixelStatus::Outlier);
        outliers.count() as f64 / all.len().max(1) as f64
    }

    /// The mean of the photograph's values over the valid pixels of all groups, which are at least one.
    pub fn mean(&self) -> Rgb {
        let valid = || self.pixels_of_group.iter().flatten();
        let values = valid().map(|&pixel| self.picture.values.pixels()[pixel as usize].as_dvec3());
        (values.sum::<DVec3>() / valid().count() as f64).as_vec3()
    }

    /// What the value of a pixel says.
    pub fn reading(&self, pixel: u32) -> Reading {
        let saturated = self.picture.saturated.pixels()[pixel as usize];
        if saturated { Reading::AtLeast } else { Reading::Value }
    }

    /// The noise at a pixel of `group`, in radiance; a unit of the photograph's values is
    /// `exposure`.
    pub fn noise(&self, group: usize, pixel: u32, exposure: Rgb) -> Noise {
        let step = exposure * self.picture.quantisation_step.pixels()[pixel as usize];
        let of_photograph = &self.noise_of_photograph[self.sheet.photograph_of(pixel)];
        let read = exposure * exposure * of_photograph.read;
        let slope = exposure * of_photograph.shot_of_group[group];
        Noise { base: step * step / 12.0 + read, slope }
    }

    /// Marks `pixels` of `group` as outliers: they show something else.
    pub fn mark_outliers(&mut self, group: usize, pixels: &[u32]) {
        for &pixel in pixels {
            self.status.pixels_mut()[pixel as usize] = PixelStatus::Outlier;
        }
        let status = &self.status;
        self.pixels_of_group[group].retain(|&p| status.pixels()[p as usize] == PixelStatus::Valid);
        self.informative_of_group[group]
            .retain(|&p| status.pixels()[p as usize] != PixelStatus::Outlier);
    }

    /// Makes the outliers of `group` valid again.
    pub fn forget_outliers(&mut self, group: usize) {
        let status = self.status.pixels_mut();
        let is_outlier = |p: &&u32| status[**p as usize] == PixelStatus::Outlier;
        let all = &self.all_pixels_of_group[group];
        let outliers: Vec<u32> = all.iter().filter(is_outlier).copied().collect();
        outliers.iter().for_each(|&p| status[p as usize] = PixelStatus::Valid);
        for pixels in [&mut self.pixels_of_group[group], &mut self.informative_of_group[group]] {
            pixels.extend(&outliers);
            pixels.sort_unstable();
        }
    }
}

/// Marks the pixels of one group that are too close to an edge; `rules` say which, ever more
/// leniently. It takes the first that leaves the group [`KEPT`] of its pixels, or else the last, or
/// none if even that leaves fewer than [`FEW_PIXELS`].
fn mark_edges<F: Fn(u32) -> bool>(status: &mut Image<PixelStatus>, pixels: &[u32], rules: &[F]) {
    let valid = |p: &&u32| status.pixels()[**p as usize] == PixelStatus::Valid;
    let valid: Vec<u32> = pixels.iter().filter(valid).copied().collect();
    let enough = (KEPT * valid.len() as f32) as usize;
    let left = |rule: &F| valid.iter().filter(|&&p| !rule(p)).count();
    let rule = rules.iter().find(|rule| left(rule) >= enough.max(FEW_PIXELS)).or(rules.last());
    if let Some(is_too_close) = rule.filter(|rule| left(rule) >= FEW_PIXELS) {
        for &pixel in valid.iter().filter(|&&p| is_too_close(p)) {
            status.pixels_mut()[pixel as usize] = PixelStatus::Edge;
        }
    }
}

fn is_spike(values: &RgbImage, index: usize) -> bool {
    let neighbours = values.neighbourhood(index).filter(|&n| n != index);
    let brightest = neighbours.fold(Rgb::ZERO, |m, n| m.max(values.pixels()[n]));
    let (value, around) = (values.pixels()[index].max_element(), brightest.max_element());
    value > SPIKE * around && around > 0.0
}

fn smooth(values: &RgbImage, geometry: &GeometryBuffers, groups: &[Vec<u32>]) -> RgbImage {
    let mut valid = vec![false; values.pixels().len()];
    groups.iter().flatten().for_each(|&p| valid[p as usize] = true);
    let (width, height) = (values.width(), values.height());
    RgbImage::from_fn(width, height, |x, y| {
        let object = geometry.at(x, y).object;
        let (mut sum, mut count) = (Vec3::ZERO, 0.0);
        for row in y.saturating_sub(2)..(y + 3).min(height) {
            for col in x.saturating_sub(2)..(x + 3).min(width) {
                if valid[row * width + col] && geometry.at(col, row).object == object {
                    sum += *values.at(col, row);
                    count += 1.0;
                }
            }
        }
        if count > 0.0 { sum / count } else { *values.at(x, y) }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use unrender_render::PixelGeometry;

    const SIDE: usize = 24;

    /// Three upright stripes, one a group: columns 0..11, 11..13, 13..24.
    fn stripes() -> GeometryBuffers {
        Image::from_fn(SIDE, SIDE, |x, _| {
            let group = u32::from(x >= 11) + u32::from(x >= 13);
            PixelGeometry {
                object: group,
                group,
                depth: 1.0,
                normal: Vec3::Z,
                ..PixelGeometry::EMPTY
            }
        })
    }

    fn observed(margin: f32, value: impl Fn(usize, usize) -> f32) -> Observation {
        let picture = Picture {
            values: RgbImage::from_fn(SIDE, SIDE, |x, y| Rgb::splat(value(x, y))),
            valid: Image::new(SIDE, SIDE, vec![true; SIDE * SIDE]),
            saturated: Image::new(SIDE, SIDE, vec![false; SIDE * SIDE]),
            quantisation_step: RgbImage::new(SIDE, SIDE, vec![Rgb::ZERO; SIDE * SIDE]),
        };
        let margins = Image::new(SIDE, SIDE, vec![margin; SIDE * SIDE]);
        Observation::with_margins(picture, &stripes(), &margins, 3)
    }

    fn columns(observation: &Observation, group: usize) -> Vec<usize> {
        let columns = observation.pixels_of_group[group].iter().map(|&p| p as usize % SIDE);
        columns.collect::<std::collections::BTreeSet<_>>().into_iter().collect()
    }

    #[test]
    fn pixels_near_an_edge_of_the_model_do_not_count_but_a_thin_group_keeps_some() {
        let fits = observed(1.0, |_, _| 0.5);
        assert_eq!(columns(&fits, 0), (0..10).collect::<Vec<_>>());
        assert_eq!(*fits.status.at(10, 5), PixelStatus::Edge);
        let off = observed(4.0, |_, _| 0.5);
        assert_eq!(columns(&off, 0), (0..7).collect::<Vec<_>>());
        assert_eq!(columns(&off, 2), (17..SIDE).collect::<Vec<_>>());
        assert_eq!(columns(&off, 1), [11, 12], "nothing would be left");
    }

    #[test]
    fn an_edge_of_the_photograph_matters_where_the_model_is_off() {
        let step = |x: usize, _: usize| if x < 18 { 0.5 } else { 0.2 };
        assert_eq!(columns(&observed(1.0, step), 2), (14..SIDE).collect::<Vec<_>>());
        let off = columns(&observed(2.5, step), 2);
        assert!(!off.contains(&17) && !off.contains(&18), "{off:?}");
        assert!(off.contains(&22), "{off:?}");
    }

    #[test]
    fn clipped_pixels_do_not_count_and_are_lower_bounds() {
        // The rows from 20 on are clipped; row 19 lies beside them.
        let picture = Picture {
            values: RgbImage::new(SIDE, SIDE, vec![Rgb::splat(0.5); SIDE * SIDE]),
            valid: Image::from_fn(SIDE, SIDE, |_, y| y < 19),
            saturated: Image::from_fn(SIDE, SIDE, |_, y| y >= 20),
            quantisation_step: RgbImage::new(SIDE, SIDE, vec![Rgb::ZERO; SIDE * SIDE]),
        };
        let margins = Image::new(SIDE, SIDE, vec![1.0; SIDE * SIDE]);
        let observation = Observation::with_margins(picture, &stripes(), &margins, 3);
        let rows = |pixels: &[u32]| {
            let rows = pixels.iter().map(|&pixel| pixel as usize / SIDE);
            rows.collect::<std::collections::BTreeSet<_>>().into_iter().collect::<Vec<_>>()
        };
        assert_eq!(rows(&observation.pixels_of_group[0]), (0..19).collect::<Vec<_>>());
        let informative = rows(&observation.informative_of_group[0]);
        assert_eq!(informative, (0..SIDE).filter(|&row| row != 19).collect::<Vec<_>>());
        assert_eq!(*observation.status.at(5, 22), PixelStatus::Clipped);
    }

    #[test]
    fn outliers_no_longer_count() {
        let mut observation = observed(1.0, |_, _| 0.5);
        let before = observation.pixels_of_group[0].len();
        observation.mark_outliers(0, &[2, 3]);
        assert_eq!(observation.pixels_of_group[0].len(), before - 2);
        assert_eq!(*observation.status.at(3, 0), PixelStatus::Outlier);
    }
}
