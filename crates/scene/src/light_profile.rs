//! Photometric profiles: how much light a lamp sends in which direction, as measured on a goniometer.
//!
//! A profile is a table of luminous intensities over a vertical angle `v` and a horizontal angle `h`, linear in both
//! between its entries and zero outside them [ANSI/IES LM-63-19]. Its three types of photometry place the angles
//! differently. With `d` the axis in which the lamp is aimed, `u` a unit vector at right angles to it, and `r = d x u`:
//!
//! | type | direction at `(v, h)` |
//! |---|---|
//! | C | `cos v d + sin v (cos h u - sin h r)` |
//! | B | `cos h (cos v d + sin v u) + sin h r` |
//! | A | `cos v (cos h d + sin h r) + sin v u` |
//!
//! So `d` points down from a ceiling lamp of type C, and `u` upwards from a floodlight of types A and B. The solid angle
//! of a table is the sum of its entries by the integrals of their hat functions, in closed form:
//! `sin v dv dh` for C, `cos h dv dh` for B, `cos v dv dh` for A.

use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::ops::RangeInclusive;
use std::sync::Arc;

/// How the angles of a profile are placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Photometry {
    /// Vertical angles from the axis, horizontal angles around it: lamps of buildings and streets.
    C,
    /// Vertical angles around the horizontal axis, horizontal angles towards it: floodlights.
    B,
    /// Horizontal angles around the vertical axis, vertical angles towards it: headlamps.
    A,
}

/// The profile of a lamp: intensities by direction, relative to the greatest one. Copies share one table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Candelas", into = "Candelas")]
pub struct LightProfile(Arc<Table>);

/// A profile as it is stored.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Candelas {
    photometry: Photometry,
    vertical_deg: Vec<f32>,
    horizontal_deg: Vec<f32>,
    candela: Vec<f64>,
}

#[derive(Debug, PartialEq)]
struct Table {
    photometry: Photometry,
    /// Ascending.
    vertical_deg: Vec<f32>,
    /// Ascending.
    horizontal_deg: Vec<f32>,
    /// For each horizontal angle, the intensities at all vertical ones, over `peak`.
    relative: Vec<f32>,
    /// The greatest intensity, candela.
    peak: f64,
    symmetry: Symmetry,
    /// The integral of `relative` over all directions.
    steradians: f64,
    /// Beyond this angle from the axis there is no light.
    reach_rad: f32,
}

/// How directions outside the horizontal angles of a table get into them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Symmetry {
    /// One horizontal angle serves for all.
    Round,
    /// 0 to 90: four quadrants alike.
    Quadrants,
    /// 0 to 180: the halves on both sides of the plane of 0 and 180 are alike.
    Halves,
    /// 90 to 270: the halves on both sides of the plane of 90 and 270 are alike.
    Ends,
    /// Types A and B from 0 on: both sides alike.
    Sides,
    /// Nothing is alike.
    Nothing,
}

impl LightProfile {
    /// The profile with the luminous intensities `candela`: for each horizontal angle, those at all vertical ones.
    /// Horizontal angles of type C say how it is symmetric: one angle, 0 to 90, 0 to 180, 90 to 270 or 0 to 360
    /// degrees. Types A and B from 0 on are alike on both sides.
    ///
    /// # Errors
    /// If angles do not ascend or are outside those of the type, or there are other than finite intensities of zero or
    /// more, one for each pair of angles, not all of them zero.
    pub fn new(
        photometry: Photometry,
        vertical_deg: Vec<f32>,
        horizontal_deg: Vec<f32>,
        candela: &[f64],
    ) -> Result<Self, String> {
        let symmetry = symmetry(photometry, &horizontal_deg)?;
        check_angles("vertical", &vertical_deg, vertical_range(photometry))?;
        if vertical_deg.len() < 2 {
            return Err("there is one vertical angle; a profile needs two or more".into());
        }
        let entries = vertical_deg.len().checked_mul(horizontal_deg.len());
        if entries != Some(candela.len()) {
            return Err(format!(
                "there are {} intensities for {} vertical and {} horizontal angles; give each pair one",
                candela.len(),
                vertical_deg.len(),
                horizontal_deg.len()
            ));
        }
        if let Some(bad) = candela.iter().find(|value| !(value.is_finite() && **value >= 0.0)) {
            return Err(format!("the intensity {bad} is not a finite number of zero or more"));
        }
        let peak = candela.iter().copied().fold(0.0, f64::max);
        if peak <= 0.0 {
            return Err("all intensities are zero; a lamp shines in some direction".into());
        }
        let relative = candela.iter().map(|value| (value / peak) as f32).collect();
        let (steradians, reach_rad) = (0.0, std::f32::consts::PI);
        let mut table = Table {
            photometry,
            vertical_deg,
            horizontal_deg,
            relative,
            peak,
            symmetry,
            steradians,
            reach_rad,
        };
        table.steradians = table.integral();
        table.reach_rad = table.reach();
        Ok(Self(Arc::new(table)))
    }

    /// How its angles are placed.
    pub fn photometry(&self) -> Photometry {
        self.0.photometry
    }

    /// Its vertical angles, ascending, degrees.
    pub fn vertical_deg(&self) -> &[f32] {
        &self.0.vertical_deg
    }

    /// Its horizontal angles, ascending, degrees.
    pub fn horizontal_deg(&self) -> &[f32] {
        &self.0.horizontal_deg
    }

    /// Its luminous intensities, candela: for each horizontal angle, those at all vertical ones.
    pub fn candela(&self) -> impl Iterator<Item = f64> + '_ {
        self.0.relative.iter().map(|relative| f64::from(*relative) * self.0.peak)
    }

    /// Its greatest luminous intensity, candela.
    pub fn peak_candela(&self) -> f64 {
        self.0.peak
    }

    /// Its luminous flux, lumens.
    pub fn lumens(&self) -> f64 {
        self.0.peak * self.0.steradians
    }

    /// Its flux over its greatest intensity, steradians.
    pub fn steradians(&self) -> f64 {
        self.0.steradians
    }

    /// The angle from the axis beyond which there is no light, radians.
    pub fn reach_rad(&self) -> f32 {
        self.0.reach_rad
    }

    /// The intensity over the greatest one at these angles of its type; horizontal ones of type C from -180 to 360.
    pub fn at(&self, vertical_deg: f32, horizontal_deg: f32) -> f32 {
        let turns = if horizontal_deg > 180.0 { 360.0 } else { 0.0 };
        self.0.at(vertical_deg, horizontal_deg - turns)
    }

    /// The intensity over the greatest one, in a direction with these components, of any common length: along `u`,
    /// along `-r`, and along `d` of the module's description.
    #[inline]
    pub fn relative(&self, [across, aside, along]: [f32; 3]) -> f32 {
        let table = &*self.0;
        let right = -aside;
        let [vertical, horizontal] = match table.photometry {
            Photometry::C => [length(across, aside).atan2(along), aside.atan2(across)],
            Photometry::B => [across.atan2(along), right.atan2(length(across, along))],
            Photometry::A => [across.atan2(length(right, along)), right.atan2(along)],
        };
        table.at(vertical.to_degrees(), horizontal.to_degrees())
    }
}

impl TryFrom<Candelas> for LightProfile {
    type Error = String;

    fn try_from(stored: Candelas) -> Result<Self, String> {
        let Candelas { photometry, vertical_deg, horizontal_deg, candela } = stored;
        Self::new(photometry, vertical_deg, horizontal_deg, &candela)
    }
}

impl From<LightProfile> for Candelas {
    fn from(profile: LightProfile) -> Self {
        Self {
            photometry: profile.photometry(),
            vertical_deg: profile.vertical_deg().to_vec(),
            horizontal_deg: profile.horizontal_deg().to_vec(),
            candela: profile.candela().collect(),
        }
    }
}

impl Table {
    /// The relative intensity at these angles; the horizontal one from -180 to 180.
    #[inline]
    fn at(&self, vertical_deg: f32, horizontal_deg: f32) -> f32 {
        let wrapped = if horizontal_deg < 0.0 { horizontal_deg + 360.0 } else { horizontal_deg };
        let folded = match self.symmetry {
            Symmetry::Round => self.horizontal_deg[0],
            Symmetry::Quadrants if horizontal_deg.abs() > 90.0 => 180.0 - horizontal_deg.abs(),
            Symmetry::Quadrants | Symmetry::Halves | Symmetry::Sides => horizontal_deg.abs(),
            Symmetry::Ends if horizontal_deg.abs() < 90.0 => 180.0 - horizontal_deg,
            Symmetry::Ends => wrapped,
            Symmetry::Nothing if self.photometry == Photometry::C => wrapped,
            Symmetry::Nothing => horizontal_deg,
        };
        let vertical = Between::of(&self.vertical_deg, vertical_deg);
        let horizontal = Between::of(&self.horizontal_deg, folded);
        let (Some(v), Some(h)) = (vertical, horizontal) else { return 0.0 };
        let column = |place: usize| {
            let from = place * self.vertical_deg.len();
            let [low, high] = [from + v.low, from + v.high].map(|place| self.relative[place]);
            low + (high - low) * v.share
        };
        let (one, other) = (column(h.low), column(h.high));
        one + (other - one) * h.share
    }

    /// The integral over all directions.
    fn integral(&self) -> f64 {
        let latitude = |angles: &[f32]| colatitude_weights(angles.iter().rev().map(|a| 90.0 - a));
        let (vertical, horizontal) = match self.photometry {
            Photometry::C => (
                colatitude_weights(self.vertical_deg.iter().copied()),
                around_weights(&self.horizontal_deg),
            ),
            Photometry::B => {
                let mut weights = latitude(&self.horizontal_deg);
                weights.reverse();
                (around_weights(&self.vertical_deg), weights)
            }
            Photometry::A => {
                let mut weights = latitude(&self.vertical_deg);
                weights.reverse();
                (weights, around_weights(&self.horizontal_deg))
            }
        };
        let times = match self.symmetry {
            Symmetry::Round => {
                return TAU
                    * self
                        .relative
                        .iter()
                        .zip(&vertical)
                        .map(|(v, w)| f64::from(*v) * w)
                        .sum::<f64>();
            }
            Symmetry::Quadrants => 4.0,
            Symmetry::Halves | Symmetry::Ends | Symmetry::Sides => 2.0,
            Symmetry::Nothing => 1.0,
        };
        let columns = self.relative.chunks(vertical.len()).zip(&horizontal);
        let column = |(values, across): (&[f32], &f64)| {
            across * values.iter().zip(&vertical).map(|(v, w)| f64::from(*v) * w).sum::<f64>()
        };
        times * columns.map(column).sum::<f64>()
    }

    /// The angle from the axis beyond which there is no light, radians.
    fn reach(&self) -> f32 {
        let rows = self.vertical_deg.len();
        let is_lit = |row: usize| self.relative[row..].iter().step_by(rows).any(|v| *v > 0.0);
        match ((0..rows).rev().find(|row| is_lit(*row)), self.photometry) {
            (Some(last), Photometry::C) => self.vertical_deg[(last + 1).min(rows - 1)].to_radians(),
            _ => std::f32::consts::PI,
        }
    }
}

fn length(x: f32, y: f32) -> f32 {
    (x * x + y * y).sqrt()
}

/// A place between two entries of a list.
struct Between {
    low: usize,
    high: usize,
    /// How far from the lower to the higher, 0 to 1.
    share: f32,
}

impl Between {
    /// The place of `value` in the ascending `list`; none outside of it.
    #[inline]
    fn of(list: &[f32], value: f32) -> Option<Self> {
        /// Degrees by which a direction in single precision may leave the list: at half of it rounding makes dark
        /// lines at the ends, with double nothing changes.
        const ROUNDING_DEG: f32 = 1e-4;
        let (first, last) = (*list.first()?, *list.last()?);
        if value < first - ROUNDING_DEG || value > last + ROUNDING_DEG {
            return None;
        }
        let value = value.clamp(first, last);
        let high = list.partition_point(|entry| *entry <= value).clamp(1, list.len().max(2) - 1);
        let (low, high) = (high - 1, high.min(list.len() - 1));
        let width = list[high] - list[low];
        let share = if width > 0.0 { (value - list[low]) / width } else { 0.0 };
        Some(Self { low, high, share })
    }
}

/// The integrals of the hat functions over ascending angles from a pole, degrees, by the sine.
fn colatitude_weights(angles_deg: impl Iterator<Item = f32>) -> Vec<f64> {
    let angles: Vec<f64> = angles_deg.map(|angle| f64::from(angle).to_radians()).collect();
    let mut weights = vec![0.0; angles.len()];
    for (index, pair) in angles.windows(2).enumerate() {
        let mean_cos = (pair[1].sin() - pair[0].sin()) / (pair[1] - pair[0]);
        weights[index] += pair[0].cos() - mean_cos;
        weights[index + 1] += mean_cos - pair[1].cos();
    }
    weights
}

/// The integrals of the hat functions over ascending angles, degrees.
fn around_weights(angles_deg: &[f32]) -> Vec<f64> {
    let mut weights = vec![0.0; angles_deg.len()];
    for (index, pair) in angles_deg.windows(2).enumerate() {
        let half = 0.5 * (f64::from(pair[1]) - f64::from(pair[0])).to_radians();
        weights[index] += half;
        weights[index + 1] += half;
    }
    weights
}

/// The vertical angles that the type has, degrees.
fn vertical_range(photometry: Photometry) -> RangeInclusive<f32> {
    match photometry {
        Photometry::C => 0.0..=180.0,
        Photometry::B => -180.0..=180.0,
        Photometry::A => -90.0..=90.0,
    }
}

fn check_angles(which: &str, angles: &[f32], range: RangeInclusive<f32>) -> Result<(), String> {
    if let Some(angle) = angles.iter().find(|angle| !range.contains(angle)) {
        return Err(format!(
            "the {which} angle {angle} is outside {} to {} degrees",
            range.start(),
            range.end()
        ));
    }
    match angles.windows(2).find(|pair| pair[0] >= pair[1]) {
        Some(pair) => {
            Err(format!("the {which} angles do not ascend: {} is followed by {}", pair[0], pair[1]))
        }
        None => Ok(()),
    }
}

fn symmetry(photometry: Photometry, horizontal_deg: &[f32]) -> Result<Symmetry, String> {
    let (Some(&first), Some(&last)) = (horizontal_deg.first(), horizontal_deg.last()) else {
        return Err("there is no horizontal angle; give at least one".into());
    };
    let range = match photometry {
        Photometry::C => 0.0..=360.0,
        Photometry::B => -90.0..=90.0,
        Photometry::A => -180.0..=180.0,
    };
    check_angles("horizontal", horizontal_deg, range)?;
    match (photometry, first, last) {
        (Photometry::C, ..) if horizontal_deg.len() == 1 => Ok(Symmetry::Round),
        (Photometry::C, 0.0, 90.0) => Ok(Symmetry::Quadrants),
        (Photometry::C, 0.0, 180.0) => Ok(Symmetry::Halves),
        (Photometry::C, 90.0, 270.0) => Ok(Symmetry::Ends),
        (Photometry::C, 0.0, 360.0) => Ok(Symmetry::Nothing),
        (Photometry::C, ..) => Err(format!(
            "the horizontal angles go from {first} to {last} degrees; type C has 0 alone, 0 to 90, 0 to 180, 90 to 270 \
             or 0 to 360"
        )),
        _ if horizontal_deg.len() < 2 => {
            Err("there is one horizontal angle; types A and B have two or more".into())
        }
        (_, 0.0, _) => Ok(Symmetry::Sides),
        _ => Ok(Symmetry::Nothing),
    }
}
