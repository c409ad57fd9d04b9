//! Motions as `xform` has them, of scenes, meshes and the places of functions.
//!
//! One motion follows the other; `-i n` starts anew and repeats what follows it n times.
//! [Radiance, `xform(1)`]

use glam::{DAffine3, DVec3};

/// Where things go to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion {
    matrix: DAffine3,
    /// Below zero if it mirrors.
    scale: f64,
}

impl Motion {
    const STILL: Self = Self { matrix: DAffine3::IDENTITY, scale: 1.0 };

    /// The motion at the beginning of `words`, and how many of them belong to it.
    pub(super) fn parse(words: &[String]) -> (Self, usize) {
        let (mut total, mut part, mut times) = (Self::STILL, Self::STILL, 1);
        let mut at = 0;
        while let Some(word) = words.get(at) {
            if word == "-i" {
                let Some(count) = words.get(at + 1).and_then(|word| word.parse::<i64>().ok())
                else {
                    break;
                };
                total = total.then(part.repeated(times));
                (part, times) = (Self::STILL, count);
                at += 2;
                continue;
            }
            let Some((step, count)) = Self::step(word, &words[at + 1..]) else { break };
            part = part.then(step);
            at += 1 + count;
        }
        (total.then(part.repeated(times)), at)
    }

    /// The motion stated by all of `words`.
    pub(super) fn of_all(words: &[String]) -> Result<Self, String> {
        let (motion, read) = Self::parse(words);
        match words.get(read) {
            None => Ok(motion),
            Some(word) => Err(format!(
                "a motion has \"{word}\", which is not one of -t x y z, -rx, -ry or -rz degrees, \
                 -s factor, -mx, -my, -mz and -i count"
            )),
        }
    }

    /// One motion, and how many numbers it takes.
    fn step(word: &str, numbers: &[String]) -> Option<(Self, usize)> {
        let number = |at: usize| {
            let number = numbers.get(at)?.parse::<f64>().ok();
            number.filter(|number| number.is_finite())
        };
        let turn = |turned: fn(f64) -> DAffine3| {
            let matrix = turned(number(0)?.to_radians());
            Some((Self { matrix, scale: 1.0 }, 1))
        };
        let stretched = |by: DVec3, scale: f64, count: usize| {
            Some((Self { matrix: DAffine3::from_scale(by), scale }, count))
        };
        match word {
            "-t" => {
                let way = DVec3::new(number(0)?, number(1)?, number(2)?);
                Some((Self { matrix: DAffine3::from_translation(way), scale: 1.0 }, 3))
            }
            "-rx" => turn(DAffine3::from_rotation_x),
            "-ry" => turn(DAffine3::from_rotation_y),
            "-rz" => turn(DAffine3::from_rotation_z),
            "-s" => {
                let factor = number(0).filter(|factor| *factor != 0.0)?;
                stretched(DVec3::splat(factor), factor, 1)
            }
            "-mx" => stretched(DVec3::new(-1.0, 1.0, 1.0), -1.0, 0),
            "-my" => stretched(DVec3::new(1.0, -1.0, 1.0), -1.0, 0),
            "-mz" => stretched(DVec3::new(1.0, 1.0, -1.0), -1.0, 0),
            _ => None,
        }
    }

    fn then(self, next: Self) -> Self {
        Self { matrix: next.matrix * self.matrix, scale: next.scale * self.scale }
    }

    /// This motion `times` over, by repeated squaring.
    fn repeated(self, times: i64) -> Self {
        let (mut power, mut left, mut all) = (self, times.max(0), Self::STILL);
        while left > 0 {
            if left % 2 == 1 {
                all = all.then(power);
            }
            power = power.then(power);
            left /= 2;
        }
        all
    }

    pub(super) fn point(&self, point: DVec3) -> DVec3 {
        self.matrix.transform_point3(point)
    }

    /// A vector moved: turned, and scaled where the motion scales.
    pub(super) fn vector(&self, vector: DVec3) -> DVec3 {
        self.matrix.transform_vector3(vector)
    }

    /// A vector moved back by the inverse.
    pub(super) fn vector_before(&self, vector: DVec3) -> DVec3 {
        self.matrix.inverse().transform_vector3(vector)
    }

    /// The factor of lengths, above zero.
    pub(super) fn scale(&self) -> f64 {
        self.scale.abs()
    }

    pub(super) fn mirrors(&self) -> bool {
        self.scale < 0.0
    }

    pub(super) fn matrix(&self) -> DAffine3 {
        self.matrix
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moved(text: &str) -> DVec3 {
        let words: Vec<String> = text.split_whitespace().map(String::from).collect();
        Motion::of_all(&words).unwrap().point(DVec3::new(1.0, 2.0, 3.0))
    }

    #[test]
    fn motions_follow_one_another_and_repeat() {
        for (text, expected) in [
            ("-t 1 0 0 -s 2", [4.0, 4.0, 6.0]),
            ("-s 2 -t 1 0 0", [3.0, 4.0, 6.0]),
            ("-rx 90", [1.0, -3.0, 2.0]),
            ("-ry 90", [3.0, 2.0, -1.0]),
            ("-rz 90", [-2.0, 1.0, 3.0]),
            ("-mx -my -mz", [-1.0, -2.0, -3.0]),
            ("-t 1 0 0 -i 3 -t 0 1 0", [2.0, 5.0, 3.0]),
            ("-rz 90 -i 2 -t 1 0 0 -rz 90", [1.0, 0.0, 3.0]),
            ("-t 1 0 0 -i 0 -t 0 1 0", [2.0, 2.0, 3.0]),
        ] {
            let (found, expected) = (moved(text), DVec3::from_array(expected));
            assert!(found.abs_diff_eq(expected, 1e-12), "{text}: {found}");
        }
    }

    #[test]
    fn what_is_no_motion_ends_it() {
        for (text, read) in [("-t 1 2", 0), ("-s 2 -s 0", 2), ("-rz x", 0), ("-mx a.rad", 1)] {
            let words: Vec<String> = text.split_whitespace().map(String::from).collect();
            assert_eq!(Motion::parse(&words).1, read, "{text}");
            assert!(Motion::of_all(&words).is_err());
        }
        let many = ["-t", "1", "0", "0", "-i", "9000000000000000000", "-t", "1", "0", "0"];
        assert!(Motion::of_all(&many.map(String::from)).is_ok());
    }
}
