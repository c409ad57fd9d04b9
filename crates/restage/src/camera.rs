//! Camera paths: Catmull-Rom splines through key poses [Catmull and Rom 1974].
//!
//! Between two keys every parameter follows the cubic Hermite curve in time whose slopes at the
//! keys are those of the line from the key before to the key after. At a key the pose is the key's
//! to the bit.

use glam::Vec3;
use unrender_scene::{Camera, Lens};

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
        let fov = hermite(near.each_ref().map(|k| (k.time, Vec3::splat(k.fov_y_rad))), time).x;
        let up = vector(|k| k.up.normalize());
        // Overshoot could make the field of view invalid.
        let fov_y_rad = fov.clamp(
            near[1].fov_y_rad.min(near[2].fov_y_rad),
            near[1].fov_y_rad.max(near[2].fov_y_rad),
        );
        Key { time, eye: vector(|k| k.eye), target: vector(|k| k.target), up, fov_y_rad }
    }
}

/// The curve at `time`, which lies between the second and the third of four (time, value) pairs.
fn hermite(values: [(f32, Vec3); 4], time: f32) -> Vec3 {
    let [a, b, c, d] = values;
    let slope = |from: (f32, Vec3), to: (f32, Vec3)| (to.1 - from.1) / (to.0 - from.0);
    let span = c.0 - b.0;
    let (begin, end) = (slope(a, c) * span, slope(b, d) * span);
    let t = (time - b.0) / span;
    let (t2, t3) = (t * t, t * t * t);
    b.1 * (2.0 * t3 - 3.0 * t2 + 1.0)
        + begin * (t3 - 2.0 * t2 + t)
        + c.1 * (3.0 * t2 - 2.0 * t3)
        + end * (t3 - t2)
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
    fn the_path_is_smooth_at_a_key() {
        let keys = vec![key(0.0, 0.0), key(1.0, 2.0), key(2.0, 1.0)];
        let path = Path { keys, lens: Lens::default() };
        let x = |time: f32| path.camera("", time).origin().x;
        let (h, at) = (1e-2, 1.0);
        let (before, after) = ((x(at) - x(at - h)) / h, (x(at + h) - x(at)) / h);
        assert!((before - after).abs() < 0.2, "{before} {after}");
        assert_eq!(x(1.0), 2.0);
    }
}
