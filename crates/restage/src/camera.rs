//! Camera paths: monotone cubic curves through key poses [Fritsch and Butland 1984].
//!
//! Between two keys every coordinate follows the cubic Hermite curve in time whose slopes at the keys are harmonic means
//! of those of the lines to both neighbours, and zero where they differ in sign. So it never leaves the range of the
//! two keys: a hold is one pose, and a camera that stops at a wall does not go through it. At a key the pose is the
//! key's to the bit.

use glam::Vec3;
use unrender_render::Tracer;
use unrender_render::accel::Ray;
use unrender_scene::{Camera, Lens, Scene};

/// A pose at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// Time, in any unit; increases from key to key.
    pub time: f32,
    /// The camera's centre, metres.
    pub eye: Vec3,
    /// A point on the optical axis.
    pub target: Vec3,
    /// Upwards in the picture.
    pub up: Vec3,
    /// Full vertical field of view, radians.
    pub fov_y_rad: f32,
}

/// A camera path.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// The keys, in the order of time; at least one.
    pub keys: Vec<Key>,
    /// The lens, constant along the path.
    pub lens: Lens,
}

impl Path {
    /// The cameras of `frames` pictures, equally spaced in time from the first key to the last.
    ///
    /// ```
    /// use glam::Vec3;
    /// use unrender_restage::camera::{Key, Path};
    /// use unrender_scene::Lens;
    ///
    /// let key = |time, x| Key {
    ///     time,
    ///     eye: Vec3::new(x, 1.0, 4.0),
    ///     target: Vec3::ZERO,
    ///     up: Vec3::Y,
    ///     fov_y_rad: 0.6,
    /// };
    /// let path = Path { keys: vec![key(0.0, -1.0), key(2.0, 1.0)], lens: Lens::default() };
    /// let cameras = path.cameras(5);
    /// assert_eq!(cameras[4].origin().x, 1.0);
    /// assert!(cameras[2].origin().x.abs() < 1e-6);
    /// ```
    pub fn cameras(&self, frames: usize) -> Vec<Camera> {
        let (Some(first), Some(last)) = (self.keys.first(), self.keys.last()) else {
            return Vec::new();
        };
        let step = (last.time - first.time) / frames.saturating_sub(1).max(1) as f32;
        let time = |frame: usize| {
            if frame + 1 == frames { last.time } else { first.time + step * frame as f32 }
        };
        let at = |frame: usize| {
            self.camera(
                &format!("frame {}", frame + 1),
                if frames == 1 { first.time } else { time(frame) },
            )
        };
        (0..frames).map(at).collect()
    }

    /// The camera at `time`, called `name`; constant before the first and after the last key.
    pub fn camera(&self, name: &str, time: f32) -> Camera {
        let key = self.pose(time);
        let camera = Camera::look_at(name, key.eye, key.target, key.up, key.fov_y_rad);
        Camera { lens: self.lens, ..camera }
    }

    fn pose(&self, time: f32) -> Key {
        let keys = &self.keys;
        let after = keys.partition_point(|key| key.time <= time);
        if after == 0 || after == keys.len() || keys[after - 1].time == time {
            return keys[after.saturating_sub(1)];
        }
        let near = [after.saturating_sub(2), after - 1, after, (after + 1).min(keys.len() - 1)];
        let near = near.map(|index| keys[index]);
        let vector = |of: fn(&Key) -> Vec3| hermite(near.each_ref().map(|k| (k.time, of(k))), time);
        let fov_y_rad = vector(|k| Vec3::splat(k.fov_y_rad)).x;
        let up = vector(|k| k.up.normalize());
        Key { time, eye: vector(|k| k.eye), target: vector(|k| k.target), up, fov_y_rad }
    }
}

/// How far the way from one picture to the next is looked along, in lengths of it. At half of the excess rounding may hide
/// a surface where a picture is taken; at double a camera that stops a five-hundredth of its way before a wall is told.
const REACH: f32 = 1.001;

/// The first picture of a sequence of `cameras` before which the camera went through a surface of `scene`: its index, and
/// the index of the object.
pub fn goes_through(scene: &Scene, cameras: &[Camera]) -> Option<(usize, usize)> {
    let tracer = Tracer::new(scene);
    cameras.windows(2).enumerate().find_map(|(index, pair)| {
        let (from, to) = (pair[0].origin(), pair[1].origin());
        let distance = from.distance(to);
        // A little beyond: a picture may be taken from the very surface.
        let t_max = REACH * distance;
        let ray = Ray { origin: from, direction: (to - from) / distance, t_max };
        let met = (distance > 0.0).then(|| tracer.surface(&ray)).flatten()?;
        Some((index + 1, met.object as usize))
    })
}

/// The curve at `time`, which lies between the second and the third of four (time, value) pairs.
fn hermite([a, b, c, d]: [(f32, Vec3); 4], time: f32) -> Vec3 {
    let span = c.0 - b.0;
    let (begin, end) = (slope([a, b, c]) * span, slope([b, c, d]) * span);
    let t = (time - b.0) / span;
    let (t2, t3) = (t * t, t * t * t);
    // In this form a hold is exact.
    b.1 + (c.1 - b.1) * (3.0 * t2 - 2.0 * t3) + begin * (t3 - 2.0 * t2 + t) + end * (t3 - t2)
}

/// The slope of the curve at the second of three (time, value) pairs, of which two may be the same at an end of the path.
/// Each coordinate has the weighted harmonic mean of the slopes of both sides where they have one sign, else zero.
fn slope([a, b, c]: [(f32, Vec3); 3]) -> Vec3 {
    let (before, after) = (b.0 - a.0, c.0 - b.0);
    if before == 0.0 || after == 0.0 {
        return (c.1 - a.1) / (c.0 - a.0);
    }
    let (left, right) = ((b.1 - a.1) / before, (c.1 - b.1) / after);
    let weights = [before + 2.0 * after, 2.0 * before + after];
    let mean = weights.iter().sum::<f32>() / (weights[0] / left + weights[1] / right);
    Vec3::select((left * right).cmpgt(Vec3::ZERO), mean, Vec3::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(time: f32, x: f32) -> Key {
        Key { time, eye: Vec3::X * x, target: Vec3::NEG_Z * 5.0, up: Vec3::Y, fov_y_rad: 0.8 }
    }

    fn eyes(keys: Vec<Key>, frames: usize) -> Vec<f32> {
        let path = Path { keys, lens: Lens::default() };
        path.cameras(frames).iter().map(|c| c.origin().x).collect()
    }

    #[test]
    fn frames_hit_the_keys_and_follow_keys_on_a_line() {
        let keys = vec![key(0.0, 0.0), key(1.0, 1.0), key(3.0, 3.0), key(4.0, 4.0)];
        let even: Vec<f32> = (0..9).map(|i| 0.5 * i as f32).collect();
        let got = eyes(keys, 9);
        assert!(got.iter().zip(&even).all(|(a, b)| (a - b).abs() < 1e-5), "{got:?}");
        assert_eq!(eyes(vec![key(2.0, 7.0)], 3), [7.0; 3]);
    }

    #[test]
    fn a_hold_is_one_pose_and_no_coordinate_leaves_the_range_of_its_keys() {
        let keys = [(0.0, 0.95), (2.0, 0.95), (3.0, 4.2), (3.5, 4.1), (7.0, -2.0), (8.0, -2.0)];
        let path = Path { keys: keys.map(|(t, x)| key(t, x)).to_vec(), lens: Lens::default() };
        let x = |time: f32| path.camera("", time).origin().x;
        for i in 0..=800 {
            let time = 0.01 * i as f32;
            let after = keys.partition_point(|key| key.0 <= time).clamp(1, keys.len() - 1);
            let (from, to) = (keys[after - 1].1, keys[after].1);
            let range = from.min(to)..=from.max(to);
            assert!(range.contains(&x(time)), "{time}: {} is not in {range:?}", x(time));
        }
        assert_eq!([0.5, 1.33, 7.3].map(x), [0.95, 0.95, -2.0]);
    }

    #[test]
    fn the_path_is_smooth_at_a_key() {
        let keys = vec![key(0.0, 0.0), key(1.0, 2.0), key(2.0, 5.0)];
        let path = Path { keys, lens: Lens::default() };
        let x = |time: f32| path.camera("", time).origin().x;
        let (h, at) = (1e-2, 1.0);
        let (before, after) = ((x(at) - x(at - h)) / h, (x(at + h) - x(at)) / h);
        assert!((before - after).abs() < 0.2, "{before} {after}");
        assert_eq!(x(1.0), 2.0);
    }
}
