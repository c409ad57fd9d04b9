//! Light without most of its noise: averaged over pixels that show the same surface.
//!
//! Light that comes by way of other surfaces changes slowly over a surface, and is averaged far; what comes straight from lights
//! has the edges of shadows, and is averaged over neighbours alone. What a surface is, its normals and its plane say, as in
//! bilateral filters [Tomasi and Manduchi 1998].

use rayon::prelude::*;
use unrender_render::GeometryBuffers;
use unrender_scene::Rgb;

/// Light by way of other surfaces is averaged with a Gaussian of this standard deviation, pixels. At half of it its noise is
/// twice as large, at double half; in a trial on another renderer's light of one room 1.5 to 6 pixels served as well, and here
/// neither was tried.
const SLOW: f32 = 3.0;
/// Pixels to either side that count: two standard deviations, and neighbours.
const FAR: i64 = 6;
const NEAR: i64 = 1;
/// Light at pixels, twice with independent noise.
type Halves = [Vec<Rgb>; 2];

/// Pixels and which of them show the same surface.
pub(super) struct Surfaces<'a> {
    pub(super) geometry: &'a GeometryBuffers,
    pub(super) pixels: &'a [u32],
    /// The points that they show, world space, metres.
    pub(super) points: &'a [glam::Vec3],
}

impl Surfaces<'_> {
    /// The means of `light` over neighbours.
    pub(super) fn near(&self, light: &Halves) -> Halves {
        self.means(light, NEAR, |_| 1.0)
    }

    /// The means of `light` by way of other surfaces.
    pub(super) fn far(&self, light: &Halves) -> Halves {
        self.means(light, FAR, |square| (-0.5 * square as f32 / (SLOW * SLOW)).exp())
    }

    /// The means over the same surface within so many pixels, each with the weight of its squared distance.
    fn means(&self, light: &Halves, within: i64, weight: impl Fn(i64) -> f32) -> Halves {
        let places = Places::of(self.pixels);
        let width = self.geometry.width() as i64;
        let steps = || (-within..=within).flat_map(|y| (-within..=within).map(move |x| (x, y)));
        let kernel: Vec<(i64, i64, f32)> =
            steps().map(|(x, y)| (x, y, weight(x * x + y * y))).collect();
        let mean = |i: usize| {
            let pixel = i64::from(self.pixels[i]);
            let inside = |x: i64| (0..width).contains(&(pixel % width + x));
            let (mut sums, mut weights) = ([Rgb::ZERO; 2], 0.0);
            for (x, y, weight) in kernel.iter().filter(|(x, ..)| inside(*x)) {
                let Some(other) = places.at(pixel + y * width + x) else { continue };
                if self.is_same(i, other) {
                    sums = [0, 1].map(|half| sums[half] + *weight * light[half][other]);
                    weights += weight;
                }
            }
            sums.map(|sum| sum / weights)
        };
        let means: Vec<[Rgb; 2]> =
            (0..self.pixels.len()).into_par_iter().with_min_len(256).map(mean).collect();
        [0, 1].map(|half| means.iter().map(|both| both[half]).collect())
    }

    /// Whether two pixels show the same surface.
    fn is_same(&self, a: usize, b: usize) -> bool {
        let shown = |i: usize| &self.geometry.pixels()[self.pixels[i] as usize];
        a == b || shown(a).shows(shown(b).object, shown(b).normal, self.points[b] - self.points[a])
    }
}

/// Where each pixel stands among some of them.
struct Places {
    first: i64,
    /// From the first pixel to the last one: the place and one, zero for pixels that are not among them.
    next: Vec<u32>,
}

impl Places {
    fn of(pixels: &[u32]) -> Self {
        let first = pixels.iter().min().copied().unwrap_or_default();
        let last = pixels.iter().max().copied().unwrap_or_default();
        let mut next = vec![0; (last - first) as usize + 1];
        for (i, pixel) in (1..).zip(pixels) {
            next[(pixel - first) as usize] = i;
        }
        Self { first: first.into(), next }
    }

    fn at(&self, pixel: i64) -> Option<usize> {
        let next = self.next.get(usize::try_from(pixel - self.first).ok()?)?;
        (*next as usize).checked_sub(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec2, Vec3};
    use unrender_render::PixelGeometry;
    use unrender_render::sampler::mix;
    use unrender_scene::Image;

    const SIDE: usize = 40;

    /// A floor below row 20 and a wall above it, of one object, with the light of each pixel, smoothed over neighbours or `far`.
    fn smoothed(light: impl Fn(usize, usize) -> f32, far: bool) -> Vec<f32> {
        let is_wall = |y: usize| y < SIDE / 2;
        let geometry = Image::from_fn(SIDE, SIDE, |_, y| PixelGeometry {
            object: 0,
            group: 0,
            depth: 10.0,
            normal: if is_wall(y) { Vec3::Z } else { Vec3::Y },
            tangent: Vec3::X,
            uv: Vec2::ZERO,
            front: true,
        });
        let place = |i: usize| (i % SIDE, i / SIDE);
        let point = |i: usize| {
            let ((x, y), corner) = (place(i), (SIDE / 2) as f32);
            let (up, out) = (corner - y as f32, y as f32 - corner);
            Vec3::new(x as f32, up.max(0.0), out.max(0.0))
        };
        let points: Vec<Vec3> = (0..SIDE * SIDE).map(point).collect();
        let pixels: Vec<u32> = (0..points.len() as u32).collect();
        let surfaces = Surfaces { geometry: &geometry, pixels: &pixels, points: &points };
        let light: Vec<Rgb> =
            (0..points.len()).map(|i| Rgb::splat(light(place(i).0, place(i).1))).collect();
        let both = [light.clone(), light];
        let [one, _] = if far { surfaces.far(&both) } else { surfaces.near(&both) };
        one.iter().map(|light| light.x).collect()
    }

    #[test]
    fn light_by_way_of_surfaces_loses_its_noise_and_not_what_a_corner_does() {
        let noise = |x: usize, y: usize| (mix((y * SIDE + x) as u64) >> 40) as f32 / 16_777_216.0;
        let of_floor = |light: &[f32]| {
            let floor = &light[SIDE * SIDE / 2..];
            let mean = floor.iter().sum::<f32>() / floor.len() as f32;
            let square = floor.iter().map(|l| (l - mean).powi(2)).sum::<f32>() / floor.len() as f32;
            (mean, square.sqrt())
        };
        let step = |x: usize, y: usize| if y < SIDE / 2 { 9.0 } else { 1.0 + 0.4 * noise(x, y) };
        // 12^(-1/2) * 0.4 over 9 pixels, and over about 90.
        let (near, far) = (of_floor(&smoothed(step, false)), of_floor(&smoothed(step, true)));
        assert!((near.0 - 1.2).abs() < 0.01 && (far.0 - 1.2).abs() < 0.01, "{near:?} {far:?}");
        assert!(near.1 > 0.03 && near.1 < 0.05 && far.1 < 0.018, "{near:?} {far:?}");
    }

    #[test]
    fn light_that_changes_evenly_stays_as_it_is() {
        let slope = |x: usize, _: usize| 1.0 + 0.05 * x as f32;
        for far in [false, true] {
            let light = smoothed(slope, far);
            for x in 6..SIDE - 6 {
                assert!((light[30 * SIDE + x] - slope(x, 0)).abs() < 1e-4, "{x}");
            }
        }
    }
}
