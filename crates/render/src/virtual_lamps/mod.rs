//! Virtual lamps: light samples by way of planar mirrors.
//!
//! A mirror on the wall lights the floor like a second lamp behind it. Directions drawn at the floor
//! hit the image of a small lamp by chance, and each hit weighs thousands; of a point light there is
//! no hit at all. For a plane the way is known in closed form, the method of images: reflect the
//! *point on the floor* at the mirror's plane, and from that image the lamp is seen in a straight line
//! through the mirror, as through a window. So a light sample drawn for the image point is a light
//! sample of the floor, with the same distance, cosine at the lamp and density over solid angle; for two mirrors in a
//! row it is the image of the image. Rays decide whether the mirrors are really where the line meets their planes, and
//! whether anything occludes a part of the way.
//!
//! The same light is found by a direction drawn from the BRDF that meets the mirrors and then the
//! lamp. Both are weighted by the balance heuristic [Veach and Guibas 1995] with the density over
//! solid angle at the point where the direction was drawn, times the probability with which each
//! mirror on the way reflects as one; so nothing is counted twice. A path keeps what that needs in
//! its [`MirrorTrail`].
//!
//! The lamp and the chain of mirrors of a sample are drawn by their approximate irradiance, where the lamp can be seen
//! through the window; then a pool of its lights ([`crate::emitters`]) by the bound of their irradiance at the image
//! point.
//!
//! Limits: light that is not sampled (by mirrors and lamps beyond the largest numbers, by chains of three mirrors, or
//! missed by the rays of `sight`) is found by chance if its source has an extent, as by way of any other surface. That
//! of point, spot and directional lights is missing.
//!
//! Cost: at each vertex a test of up to [`LAMPS_MAX`] virtual lamps, and two or three rays where one of
//! them may be seen.

mod chain;
mod faces;
mod fours;
mod lamps;
mod sight;

pub(crate) use faces::{FlatFace, FlatFaces};

use crate::accel::Accel;
use crate::appearance::Appearance;
use crate::emitters::{ENVIRONMENT, Emitters, LightSample};
use crate::lanes::{self, total};
use crate::surface::Surface;
use chain::{Chain, Crossings, MIRRORS_MAX, Mirror};
use fours::Four;
use glam::{Vec3, Vec4};
use lamps::VirtualLamp;
use sight::Sight;
use unrender_scene::color::luminance;

/// Most mirrors: those of the largest area times reflectance. With half of it rooms of several
/// mirrors have light that is found by chance, double of it costs time at every vertex.
const MIRRORS: usize = 8;
/// Most virtual lamps: the strongest by power, reflectance and area of the mirrors. With half of it some
/// lamps of rooms with many are found by chance, double of it costs time at every vertex.
const LAMPS_MAX: usize = 32;
/// Most fours of them: each length of chains may leave one incomplete.
const FOURS_MAX: usize = LAMPS_MAX / 4 + MIRRORS_MAX;

/// Where mirrors bring less than this share of the light that lamps bring straight, a vertex takes virtual
/// samples with a probability in proportion to it. With a fifth of it rooms of many mirrors took 2 to 10 % more
/// time for the same variance; with double of it the light of weak mirrors is noisier.
const WORTH: f32 = 1.0;

/// The lamps of a scene as its planar mirrors show them, under one appearance.
#[derive(Clone, Debug, Default)]
pub(crate) struct VirtualLamps {
    chains: Vec<Chain>,
    /// In fours by chains of one length; lamps that a four lacks have no strength.
    lamps: Vec<VirtualLamp>,
    fours: Vec<Four>,
}

/// A light sample by way of mirrors, which may turn out not to be there.
pub(crate) struct VirtualSample {
    /// As a sample for the last image: `wi` is the direction in which it leaves the last mirror.
    pub(crate) light: LightSample,
    /// Unit vector towards the first mirror.
    pub(crate) wi: Vec3,
    /// Where the way meets the mirrors, and the places of their faces.
    pub(crate) crossings: Crossings,
    pub(crate) places: [u16; MIRRORS_MAX],
    pub(crate) count: usize,
    /// The point of the light that the way ends at; none if that is at infinity.
    pub(crate) end: Option<Vec3>,
}

/// Mirrors that light passes on its way from a lamp to a vertex.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MirrorsPassed {
    mirrors: [Passed; MIRRORS_MAX],
    count: usize,
}

/// A mirror that light passes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Passed {
    /// The mirror's group.
    pub(crate) group: u32,
    /// The cosine of the angle to its normal.
    pub(crate) cos: f32,
}

impl MirrorsPassed {
    /// Adds a mirror.
    pub(crate) fn push(&mut self, mirror: Passed) {
        self.mirrors[self.count] = mirror;
        self.count += 1;
    }

    /// The mirrors.
    #[inline]
    pub(crate) fn all(&self) -> &[Passed] {
        &self.mirrors[..self.count]
    }
}

/// What a path keeps of the vertex at which its direction was last drawn from a density, and of the
/// perfect mirrors since.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MirrorTrail {
    /// The origin of rays that leave the vertex.
    origin: Vec3,
    /// The density over solid angle of the direction there, times the probabilities of the mirrors'
    /// reflections since; of several directions, the sum.
    pdf: f32,
    /// The number of virtual samples that the vertex takes.
    samples: u32,
    /// The places of the mirrors' faces, and their number.
    places: [u16; MIRRORS_MAX],
    count: usize,
}

impl MirrorTrail {
    /// That of a vertex where a direction was drawn with the density `pdf`, beside `samples` virtual
    /// samples.
    #[inline]
    pub(crate) fn new(from: &Surface, pdf: f32, samples: u32) -> Self {
        let origin = from.start();
        Self { origin, pdf, samples, places: [0; MIRRORS_MAX], count: 0 }
    }

    /// The same after the reflection, taken with `probability`, in the mirror of the face at `place`; none
    /// if virtual samples cannot come that way.
    pub(crate) fn reflected(mut self, place: Option<u16>, probability: f32) -> Option<Self> {
        *self.places.get_mut(self.count)? = place?;
        self.count += 1;
        self.pdf *= probability;
        Some(self)
    }
}

impl VirtualLamps {
    /// Those of the mirrors among `faces` under `appearance`.
    pub(crate) fn new(
        faces: &FlatFaces,
        accel: &Accel,
        emitters: &Emitters,
        appearance: &Appearance<'_>,
    ) -> Self {
        let mirror = |(face, place): (&FlatFace, u16)| {
            let material = appearance.materials.get(face.group as usize)?;
            let reflectance = luminance(material.rho_s);
            let reflects = material.is_delta() && reflectance > 0.0;
            reflects.then(|| Mirror::new(place, *face, reflectance))
        };
        let mut mirrors: Vec<_> = faces.all().iter().zip(0..).filter_map(mirror).collect();
        if mirrors.is_empty() {
            return Self::default();
        }
        let strength = |mirror: &Mirror| mirror.face.area * mirror.reflectance;
        mirrors.sort_by(|a, b| strength(b).total_cmp(&strength(a)));
        mirrors.truncate(MIRRORS);
        // Of these, `sight` knows the few that show a lamp.
        let pairs = mirrors
            .iter()
            .flat_map(|first| mirrors.iter().map(move |second| Chain::pair(*first, *second)));
        let singles = mirrors.iter().copied().map(Chain::single);
        let chains: Vec<_> = singles.chain(pairs).collect();
        let sight = Sight::new(&mirrors, faces, accel, emitters);
        let of_chain = |(index, chain): (usize, &Chain)| {
            let of_lamp = |lamp: usize| {
                let share = match chain.mirrors() {
                    [only] => sight.of(only.place, lamp)?,
                    [first, second, ..] => sight.of_pair(first.place, second.place, lamp)?,
                    [] => return None,
                };
                let lamp = VirtualLamp::new(index, chain, &sight.lamps[lamp], share)?;
                Some((lamp.strength * chain.area(), lamp))
            };
            (0..sight.lamps.len()).filter_map(of_lamp).collect::<Vec<_>>()
        };
        let mut lamps: Vec<_> = chains.iter().enumerate().flat_map(of_chain).collect();
        lamps.sort_by(|a, b| b.0.total_cmp(&a.0));
        lamps.truncate(LAMPS_MAX);
        Self::in_fours(chains, lamps.into_iter().map(|(_, lamp)| lamp).collect())
    }

    fn in_fours(chains: Vec<Chain>, all: Vec<VirtualLamp>) -> Self {
        let (mut lamps, mut fours) = (Vec::new(), Vec::new());
        for length in 1..=MIRRORS_MAX {
            let of_length = all.iter().filter(|lamp| chains[lamp.chain].mirrors().len() == length);
            for four in of_length.copied().collect::<Vec<_>>().chunks(4) {
                fours.push(Four::new(four, &chains));
                lamps.extend_from_slice(four);
                lamps.resize(4 * fours.len(), VirtualLamp { strength: 0.0, ..four[0] });
            }
        }
        Self { chains, lamps, fours }
    }

    /// Whether there are none.
    #[inline]
    pub(crate) fn is_empty(&self) -> bool {
        self.lamps.is_empty()
    }

    /// The irradiance of each virtual lamp at `origin`, in fours, and the sum.
    #[inline]
    fn irradiances(&self, origin: Vec3) -> ([Vec4; FOURS_MAX], f32) {
        let mut irradiances = [Vec4::ZERO; FOURS_MAX];
        let mut sum = Vec4::ZERO;
        for (slot, four) in irradiances.iter_mut().zip(&self.fours) {
            *slot = four.irradiances(origin);
            sum += *slot;
        }
        (irradiances, total(sum))
    }

    /// Draws light for a vertex whose rays leave from `origin`, where lamps bring about the irradiance
    /// `straight`, from three numbers in [0, 1).
    pub(crate) fn sample(
        &self,
        emitters: &Emitters,
        (origin, straight): (Vec3, f32),
        u: [f32; 3],
    ) -> Option<VirtualSample> {
        let (irradiances, sum) = self.irradiances(origin);
        let chance = chance(sum, straight);
        if u[0] >= chance {
            return None;
        }
        let (index, irradiance, rest) =
            lanes::draw(&irradiances[..self.fours.len()], u[0] / chance * sum)?;
        let lamp = &self.lamps[index];
        let chain = &self.chains[lamp.chain];
        let images = chain.images(origin)?;
        let image = chain.last(&images);
        let bounds = emitters.importances(image).times(&lamp.lamp.pools);
        let of_pools = bounds.sum();
        let (pool, bound, rest) = bounds.draw(rest * of_pools)?;
        let probability = chance * (irradiance / sum) * (bound / of_pools);
        let light = emitters.sample_pool(pool, probability, image, [rest, u[1], u[2]])?;
        let crossings = chain.crossings(&images, light.wi, light.distance)?;
        let mut places = [0; MIRRORS_MAX];
        let mirrors = chain.mirrors();
        places.iter_mut().zip(mirrors).for_each(|(place, mirror)| *place = mirror.place);
        let count = mirrors.len();
        Some(VirtualSample {
            wi: (crossings[0] - origin).normalize(),
            end: light.distance.is_finite().then(|| image + light.distance * light.wi),
            light,
            crossings,
            places,
            count,
        })
    }

    /// The weight of multiple importance sampling of the light that `emitter`, or else the environment, emits along
    /// `wi` (world space) and that the path found by the mirrors of `trail`.
    pub(crate) fn share_of_path(
        &self,
        emitters: &Emitters,
        trail: &MirrorTrail,
        emitter: Option<&Surface>,
        wi: Vec3,
    ) -> f32 {
        let pdf = self.pdf(emitters, trail, emitter, wi);
        trail.pdf / (trail.pdf + trail.samples as f32 * pdf)
    }

    /// The density over solid angle with which virtual samples find that light.
    fn pdf(
        &self,
        emitters: &Emitters,
        trail: &MirrorTrail,
        emitter: Option<&Surface>,
        wi: Vec3,
    ) -> f32 {
        let places = &trail.places[..trail.count];
        let is_same =
            |chain: &Chain| chain.mirrors().iter().map(|m| m.place).eq(places.iter().copied());
        let Some(chain) = self.chains.iter().position(is_same) else { return 0.0 };
        let pool = match emitter {
            Some(surface) => emitters.pool_of(surface.triangle),
            None => Some(ENVIRONMENT),
        };
        let Some(pool) = pool else { return 0.0 };
        let is_that = |lamp: &VirtualLamp| lamp.chain == chain && lamp.lamp.has(pool);
        let Some(index) = self.lamps.iter().position(is_that) else { return 0.0 };
        let (irradiances, sum) = self.irradiances(trail.origin);
        let Some(images) = self.chains[chain].images(trail.origin) else { return 0.0 };
        let image = self.chains[chain].last(&images);
        let bounds = emitters.importances(image).times(&self.lamps[index].lamp.pools);
        let irradiance = irradiances[index / 4][index % 4];
        if irradiance <= 0.0 || bounds.of(pool) <= 0.0 {
            return 0.0;
        }
        let chance = chance(sum, emitters.importances(trail.origin).sum());
        let probability = chance * (irradiance / sum) * (bounds.of(pool) / bounds.sum());
        match emitter {
            Some(surface) => {
                let distance = image.distance(surface.point);
                let cos = wi.dot(surface.geometric_normal).abs();
                emitters.pdf_of(probability, surface.triangle, distance, cos)
            }
            None => emitters.environment_pdf_of(probability, wi),
        }
    }
}

/// The probability with which a vertex takes a virtual sample, given the approximate irradiance there of all virtual
/// lamps and of all lamps themselves.
#[inline]
fn chance(irradiance: f32, straight: f32) -> f32 {
    if irradiance > 0.0 { (irradiance / (WORTH * straight)).min(1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests;
