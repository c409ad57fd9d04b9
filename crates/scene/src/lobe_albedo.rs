//! The directional albedo of GGX lobes under a Fresnel reflectance, and the light that they let through, from a table.
//!
//! ```text
//! E(mu, alpha) = integral F(wo . h) w(wo, wi) cos_i dwi,                        mu = cos_o
//! T(mu, alpha) = integral (1 - F(wo . h)) G1(wt) D_o(h) dh,     wt = refracted wo, D_o = visible normals
//! ```
//!
//! `E` is what leaves at the first hit, `T` what enters at the first hit [Walter et al. 2007]; the rest, which microfacets
//! scatter more than once, is in neither. There is no closed form. `lobe_albedo.bin` holds `E` and `1 - T` at nodes of the
//! refractive index, of `alpha` and of `mu`, as 16 bits each, by quadrature over the visible normals [Heitz 2018]; between nodes
//! they are interpolated. A test compares it with the quadrature, and writes it anew if `UNRENDER_WRITE_PAGES` is set. For
//! refractive indices from 1.3 on the error of `E` is below 0.0015, and up to 0.004 for nearly smooth lobes at 89 degrees (tested
//! beside a fine quadrature of the renderer's lobe); below, where lobes hardly reflect, it is larger at grazing angles. `T` is
//! tested beside Mitsuba's plastics of index 1.5, to 0.003.

use crate::reflectance::{Layering, f0_of_ior, fresnel};

/// Intervals of `sqrt(mu)`: `E` is steep near grazing. With half of them the error of smooth lobes is 0.003; double of them
/// change little where roughness is the larger error, and take twice the space.
const COSINES: usize = 32;
/// Intervals of `sqrt(alpha)`, Blender's *Roughness*. With half of them the error of nearly smooth lobes at 89 degrees is
/// 0.009; with double of them it is 0.001, and the table twice as large.
const ROUGHNESSES: usize = 48;
/// The distance of the refractive indices in `(ior - 1)/(ior + 1)`, the root of the reflectance at normal incidence: that of
/// 1.5 is a node. Between them `E` is interpolated linearly in that reflectance. With double of it the error at 1.33 is 0.003,
/// with half of it the table is twice as large.
const ROOT_STEP: f32 = 0.025;
/// The number of refractive indices: from 1 to 3; beyond the last, its albedo counts. Diamond has 2.4. Half of them would end
/// at 1.6, double of them serve no dielectric.
const INDICES: usize = 21;
/// The numbers of one refractive index: one for each roughness and cosine. It follows from the two.
const SLICE: usize = (ROUGHNESSES + 1) * (COSINES + 1);
/// The lobe that reflects everything once, as the slice after those of dielectrics: one slice more or less is another lobe.
const WHITE: usize = INDICES;
/// The first slice of `1 - T`; they follow the one of the white lobe.
const KEPT_OUT: usize = WHITE + 1;
/// `E` and `1 - T` times 65535, little-endian: by reflectance, then by roughness, then by cosine. 8 bits would have steps of
/// 0.004.
const TABLE: &[u8] = include_bytes!("lobe_albedo.bin");

/// The albedo of one lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LobeAlbedo {
    /// The slices of two refractive indices.
    slices: [usize; 2],
    /// The weight of the second slice.
    between: f32,
    /// The roughness's interval, and the place in it.
    row: usize,
    place: f32,
    /// One over the interval's width; zero where `alpha` is beyond the last node.
    per_alpha: f32,
    /// The refractive index of a perfect mirror's coat, whose albedo is Fresnel's; else zero.
    smooth: f32,
}

/// An albedo and its derivative by `alpha`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AlbedoSlope {
    /// The albedo.
    pub value: f32,
    /// Its derivative by `alpha`.
    pub by_alpha: f32,
}

impl LobeAlbedo {
    /// Of the lobe of roughness `alpha` of a dielectric; at zero a perfect mirror's, which is `F`.
    pub fn dielectric(ior: f32, alpha: f32) -> Self {
        Self::of_slices(0, ior, alpha)
    }

    /// What the rough surface of a dielectric keeps from entering, `1 - T`, in the place of the albedo.
    pub fn kept_out(ior: f32, alpha: f32) -> Self {
        Self::of_slices(KEPT_OUT, ior, alpha)
    }

    /// What the lobe of a dielectric takes from a base under it in this layering.
    pub fn over(layering: Layering, ior: f32, alpha: f32) -> Self {
        match layering {
            Layering::AlbedoScaled => Self::dielectric(ior, alpha),
            Layering::Coupled => Self::kept_out(ior, alpha),
        }
    }

    /// Of the slices of refractive indices that begin with this one.
    fn of_slices(start: usize, ior: f32, alpha: f32) -> Self {
        let f0 = f0_of_ior(ior.max(1.0));
        let at = (f0.sqrt() / ROOT_STEP).min((INDICES - 1) as f32);
        // A refractive index of the table, such as 1.5, needs one slice only.
        let nearest = at.round();
        let at = if (at - nearest).abs() < 1e-4 { nearest } else { at };
        let first = (at as usize).min(INDICES - 1);
        let second = (first + usize::from(at > first as f32)).min(INDICES - 1);
        let [low, high] = [first, second].map(|k| (k as f32 * ROOT_STEP).powi(2));
        let between = if second > first { (f0 - low) / (high - low) } else { 0.0 };
        let smooth = if alpha <= 0.0 { ior } else { 0.0 };
        Self { smooth, ..Self::new([start + first, start + second], between, alpha) }
    }

    /// Of the lobe of roughness `alpha` that reflects everything once: one, less the light that microfacets scatter more
    /// than once.
    pub fn white(alpha: f32) -> Self {
        Self::new([WHITE; 2], 0.0, alpha)
    }

    fn new(slices: [usize; 2], between: f32, alpha: f32) -> Self {
        let alpha = alpha.max(0.0);
        let row = ((alpha.sqrt() * ROUGHNESSES as f32) as usize).min(ROUGHNESSES - 1);
        let node = |k: usize| (k as f32 / ROUGHNESSES as f32).powi(2);
        let width = node(row + 1) - node(row);
        let place = (alpha - node(row)) / width;
        let per_alpha = if place > 1.0 { 0.0 } else { 1.0 / width };
        Self { slices, between, row, place: place.min(1.0), per_alpha, smooth: 0.0 }
    }

    /// `E` towards a direction of the cosine `mu`.
    #[inline]
    pub fn at(&self, mu: f32) -> f32 {
        if self.smooth > 0.0 {
            return fresnel(mu, self.smooth);
        }
        let [low, high] = self.rows(mu);
        low + self.place * (high - low)
    }

    /// [`LobeAlbedo::at`] with its derivative.
    #[inline]
    pub fn slope_at(&self, mu: f32) -> AlbedoSlope {
        if self.smooth > 0.0 {
            return AlbedoSlope { value: fresnel(mu, self.smooth), by_alpha: 0.0 };
        }
        let [low, high] = self.rows(mu);
        let value = low + self.place * (high - low);
        AlbedoSlope { value, by_alpha: (high - low) * self.per_alpha }
    }

    /// `Eavg = 2 integral E mu dmu`, with its derivative.
    pub fn mean(&self) -> AlbedoSlope {
        let mean = |row: usize| {
            let [first, second] = self.slices.map(|slice| mean(|column| node(slice, row, column)));
            first + self.between * (second - first)
        };
        let [low, high] = [mean(self.row), mean(self.row + 1)];
        if self.smooth > 0.0 {
            return AlbedoSlope { value: low, by_alpha: 0.0 };
        }
        let value = low + self.place * (high - low);
        AlbedoSlope { value, by_alpha: (high - low) * self.per_alpha }
    }

    /// The albedos at the two ends of the roughness's interval.
    #[inline]
    fn rows(&self, mu: f32) -> [f32; 2] {
        let at = mu.clamp(0.0, 1.0).sqrt() * COSINES as f32;
        let column = (at as usize).min(COSINES - 1);
        let place = at - column as f32;
        let in_row = |slice: usize, row: usize| {
            let [low, high] = [column, column + 1].map(|column| node(slice, row, column));
            low + place * (high - low)
        };
        [self.row, self.row + 1].map(|row| {
            let first = in_row(self.slices[0], row);
            if self.between > 0.0 {
                first + self.between * (in_row(self.slices[1], row) - first)
            } else {
                first
            }
        })
    }
}

/// `E` at a node of the table.
#[inline]
fn node(slice: usize, row: usize, column: usize) -> f32 {
    let at = 2 * (slice * SLICE + row * (COSINES + 1) + column);
    f32::from(u16::from_le_bytes([TABLE[at], TABLE[at + 1]])) / f32::from(u16::MAX)
}

/// `2 integral E mu dmu` of an interpolated row. With `mu = t^2` it is `4 integral E t^3 dt`, in which `E` is linear in
/// every interval.
fn mean(row: impl Fn(usize) -> f32) -> f32 {
    let node = |k: usize| k as f64 / COSINES as f64;
    let interval = |k: usize| {
        let (t0, t1) = (node(k), node(k + 1));
        let slope = f64::from(row(k + 1) - row(k)) / (t1 - t0);
        let constant = f64::from(row(k)) - slope * t0;
        constant * (t1.powi(4) - t0.powi(4)) + 0.8 * slope * (t1.powi(5) - t0.powi(5))
    };
    (0..COSINES).map(interval).sum::<f64>() as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;
    use std::path::Path;

    /// Quadrature points of a node, squared: more change `E` by less than 0.0003 (0.003 for the white lobe).
    const POINTS: usize = 20;

    /// The mean of `of(h_z, wo . h)` over the normals that are visible from the direction of the cosine `mu` [Heitz 2018]. The
    /// lobe is symmetric about the plane of incidence, so that one half of the normals is enough.
    fn over_visible_normals(mu: f64, alpha: f64, of: impl Fn(f64, f64) -> f64) -> f64 {
        let sin = (1.0 - mu * mu).max(0.0).sqrt();
        let length = (alpha * alpha * sin * sin + mu * mu).sqrt();
        let (stretched_x, stretched_z) = (alpha * sin / length, mu / length);
        let mut sum = 0.0;
        for i in 0..POINTS {
            // Dense at the rim, where the lobe's tail goes below the surface.
            let inner = 1.0 - (i as f64 + 0.5) / POINTS as f64;
            let (radius, weight) = ((1.0 - inner * inner).sqrt(), 2.0 * inner);
            for j in 0..POINTS {
                let angle = PI * ((j as f64 + 0.5) / POINTS as f64 - 0.5);
                let (across, y) = (radius * angle.cos(), radius * angle.sin());
                let half = (1.0 - across * across).sqrt();
                let share = 0.5 * (1.0 + stretched_z);
                let up = (1.0 - share) * half + share * y;
                let out = (1.0 - across * across - up * up).max(0.0).sqrt();
                // The frame about the stretched direction: `up` points away from the surface's normal where that leans.
                let x = stretched_x * out - stretched_z * up;
                let z = (stretched_z * out + stretched_x * up).max(0.0);
                let (x, y) = (alpha * x, alpha * across);
                let length = (x * x + y * y + z * z).sqrt();
                let (h_x, h_z) = (x / length, z / length);
                sum += weight * of(h_z, sin * h_x + mu * h_z);
            }
        }
        sum / (POINTS * POINTS) as f64
    }

    fn lambda(alpha: f64, z: f64) -> f64 {
        0.5 * ((1.0 + alpha * alpha * (1.0 - z * z).max(0.0) / (z * z)).sqrt() - 1.0)
    }

    /// At zero the visible normals have no limit of their own.
    const GRAZING: f64 = 1e-4;

    /// `E`: each visible normal is weighted by `F G(wo, wi)/G(wo)`, with the masking of [Heitz 2014, eq. 99].
    fn albedo(reflectance: &impl Fn(f64) -> f64, mu: f64, alpha: f64) -> f64 {
        if alpha <= 0.0 {
            return reflectance(mu);
        }
        let mu = mu.max(GRAZING);
        let seen = 1.0 + lambda(alpha, mu);
        over_visible_normals(mu, alpha, |h_z, cos| {
            let z = 2.0 * cos * h_z - mu;
            if z > 0.0 { reflectance(cos) * seen / (seen + lambda(alpha, z)) } else { 0.0 }
        })
    }

    /// `1 - T`: each visible normal lets `1 - F` through, less what is masked from below.
    fn kept_out(reflectance: &impl Fn(f64) -> f64, ior: f64, mu: f64, alpha: f64) -> f64 {
        if alpha <= 0.0 {
            return reflectance(mu);
        }
        let mu = mu.max(GRAZING);
        1.0 - over_visible_normals(mu, alpha, |h_z, cos| {
            // The refracted direction, below the surface: (cos/n - cos_t) h - wo/n.
            let cos_t = (1.0 - (1.0 - cos * cos) / (ior * ior)).max(0.0).sqrt();
            let z = mu / ior - (cos / ior - cos_t) * h_z;
            if z > 0.0 { (1.0 - reflectance(cos)) / (1.0 + lambda(alpha, z.min(1.0))) } else { 0.0 }
        })
    }

    /// The table by quadrature.
    fn computed() -> Vec<u8> {
        let nodes = |count: usize| (0..=count).map(move |k| (k as f64 / count as f64).powi(2));
        let mut bytes = Vec::new();
        for slice in 0..KEPT_OUT + INDICES {
            let root = f64::from(ROOT_STEP) * (slice % KEPT_OUT) as f64;
            let ior = ((1.0 + root) / (1.0 - root)) as f32;
            let reflectance =
                |cos: f64| if slice == WHITE { 1.0 } else { f64::from(fresnel(cos as f32, ior)) };
            for alpha in nodes(ROUGHNESSES) {
                for mu in nodes(COSINES) {
                    let value = if slice < KEPT_OUT {
                        albedo(&reflectance, mu, alpha)
                    } else {
                        kept_out(&reflectance, ior.into(), mu, alpha)
                    };
                    let value = value.clamp(0.0, 1.0);
                    bytes.extend(((value * f64::from(u16::MAX)).round() as u16).to_le_bytes());
                }
            }
        }
        bytes
    }

    #[test]
    fn the_table_is_that_of_the_quadrature() {
        let expected = computed();
        if std::env::var_os("UNRENDER_WRITE_PAGES").is_some() {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lobe_albedo.bin");
            std::fs::write(path, &expected).unwrap();
        }
        assert_eq!(TABLE.len(), expected.len());
        let number = |bytes: &[u8]| i32::from(u16::from_le_bytes([bytes[0], bytes[1]]));
        // Rounding of other processors' functions may move the last bit.
        for (found, expected) in TABLE.chunks(2).zip(expected.chunks(2)) {
            assert!((number(found) - number(expected)).abs() <= 1);
        }
    }

    #[test]
    fn what_does_not_enter_is_reflected_or_lost() {
        // T over that at normal incidence, of Mitsuba 3.9.1's roughplastic of ior 1.5, ggx, without its lobe.
        let mitsuba =
            [(0.1, 60.0f32, 0.9447), (0.1, 80.0, 0.7165), (0.2, 70.0, 0.8783), (0.4, 75.0, 0.8179)];
        for (alpha, degrees, expected) in mitsuba {
            let through = |mu: f32| 1.0 - LobeAlbedo::kept_out(1.5, alpha).at(mu);
            let found = through(degrees.to_radians().cos()) / through(1.0);
            assert!(
                (found - expected).abs() < 3e-3,
                "{alpha} {degrees}: {found} is not {expected}"
            );
        }
        for (alpha, mu) in [(0.05, 0.9), (0.2, 0.5), (0.6, 0.2), (1.0, 1.0)] {
            let [out, albedo] =
                [LobeAlbedo::kept_out(1.5, alpha), LobeAlbedo::dielectric(1.5, alpha)];
            assert!(out.at(mu) > albedo.at(mu), "{alpha} {mu}");
        }
    }

    #[test]
    fn a_smooth_lobe_has_fresnels_reflectance() {
        let smooth = LobeAlbedo::dielectric(1.5, 0.0);
        assert!((smooth.at(1.0) - 0.04).abs() < 1e-6);
        // The mean reflectance of n = 1.5 [Egan and Hilgeman 1973]: 0.0918.
        assert!((smooth.mean().value - 0.0918).abs() < 2e-4, "{:?}", smooth.mean());
        let polished = LobeAlbedo::dielectric(1.5, 1e-3);
        for mu in [1.0, 0.7, 0.3, 0.1] {
            assert!((polished.at(mu) - fresnel(mu, 1.5)).abs() < 2e-3, "{mu}");
        }
    }

    #[test]
    fn a_white_lobe_loses_what_is_scattered_twice() {
        // [Turquin 2019, figure 3]: little is lost below alpha = 0.2, and more than half at normal incidence for none.
        assert!(LobeAlbedo::white(0.1).at(0.8) > 0.98);
        let rough = LobeAlbedo::white(1.0).at(1.0);
        assert!((0.3..0.6).contains(&rough), "{rough}");
    }

    #[test]
    fn derivatives_are_those_of_the_interpolation() {
        for alpha in [0.02f32, 0.1, 0.3, 0.7] {
            let step = 1e-3 * alpha;
            let [low, high] = [alpha - step, alpha + step].map(|a| LobeAlbedo::dielectric(1.43, a));
            let middle = LobeAlbedo::dielectric(1.43, alpha);
            if low.row != high.row {
                continue;
            }
            let expected = (high.at(0.3) - low.at(0.3)) / (2.0 * step);
            let found = middle.slope_at(0.3).by_alpha;
            assert!((found - expected).abs() < 0.02 * expected.abs() + 1e-3, "{found} {expected}");
        }
    }

    #[test]
    fn what_lies_between_two_tables_is_between_them() {
        let [a, b, c] = [1.5, 1.52, 1.55].map(|ior| LobeAlbedo::dielectric(ior, 0.2).at(0.5));
        assert!(a < b && b < c, "{a} {b} {c}");
    }
}
