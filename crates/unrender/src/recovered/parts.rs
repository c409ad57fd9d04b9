//! Groups whose residuals differ by object: two materials under one name.
//!
//! One reflectance for objects of two materials makes one of them too dark and the other too bright.
//! For every object of a group, this finds the factor by which the photograph is brighter than the
//! re-rendering, channel by channel, with its standard error from squares of pixels, inside which
//! errors of the model are correlated. Objects whose factors agree are one part.

use std::collections::BTreeMap;
use unrender_recover::{PixelStatus, Recovery, Status};
use unrender_scene::{Image, Rgb, RgbImage};

/// Parts differ by more than this share: twice a notable model error in one place. At half of it,
/// slightly wrong light splits objects far from each other; at double, two paints of 0.5 and 0.6 are
/// one.
const NOTABLE: f64 = 0.1;
/// And by this many standard errors. At half of it one group of forty is split by chance; at double,
/// objects of a few squares never are.
const ERRORS: f64 = 4.0;
/// The side of the squares, as a share of the picture's height: a 40th is 12 pixels of 480. At half of it
/// errors reach over several squares and the standard error is too small; at double, small objects have
/// too few.
const SQUARE: f32 = 1.0 / 40.0;
/// An object with fewer squares is not evaluated: from three, the scatter is known only to a half.
const SQUARES_MIN: usize = 4;

/// The factor by which the photograph is brighter where it shows an object.
struct ObjectFit {
    object: usize,
    pixels: usize,
    factor: [f64; 3],
    error: [f64; 3],
}

/// The objects of a scene, as a photograph shows them.
#[derive(Clone, Copy, Debug)]
pub(super) struct ObjectsSeen<'a> {
    /// The group of each object.
    pub(super) groups: &'a [usize],
    /// The object of every pixel, or `u32::MAX`.
    pub(super) map: &'a Image<u32>,
    /// The photograph, radiance as in the re-rendering.
    pub(super) photograph: &'a RgbImage,
}

/// For each group to be split by object, by its index: the objects of its parts, the one with the most pixels first, each
/// in the scene's order. Objects that are not seen well enough belong to the first.
pub(super) fn find(
    recovery: &Recovery,
    objects_seen: &ObjectsSeen<'_>,
) -> BTreeMap<usize, Vec<Vec<usize>>> {
    let mut found = BTreeMap::new();
    let groups = objects_seen.groups;
    for (group, result) in recovery.groups.iter().enumerate() {
        let objects: Vec<usize> =
            (0..groups.len()).filter(|object| groups[*object] == group).collect();
        if result.status == Status::Known || objects.len() < 2 {
            continue;
        }
        let mut seen: Vec<ObjectFit> =
            objects.iter().filter_map(|object| look(recovery, objects_seen, *object)).collect();
        seen.sort_by_key(|seen| std::cmp::Reverse(seen.pixels));
        let mut parts = parts(&seen);
        if parts.len() > 1 {
            let rest = objects.iter().filter(|o| !parts.iter().flatten().any(|p| p == *o));
            let rest: Vec<usize> = rest.copied().collect();
            parts[0].extend(rest);
            parts.iter_mut().for_each(|part| part.sort_unstable());
            found.insert(group, parts);
        }
    }
    found
}

/// Objects whose factors agree with the first one of a part, part by part, that with the most pixels
/// first.
fn parts(seen: &[ObjectFit]) -> Vec<Vec<usize>> {
    let mut parts: Vec<Vec<&ObjectFit>> = Vec::new();
    for object in seen {
        match parts.iter_mut().find(|part| agree(part[0], object)) {
            Some(part) => part.push(object),
            None => parts.push(vec![object]),
        }
    }
    let pixels = |part: &Vec<&ObjectFit>| part.iter().map(|seen| seen.pixels).sum::<usize>();
    parts.sort_by_key(|part| std::cmp::Reverse(pixels(part)));
    parts.iter().map(|part| part.iter().map(|seen| seen.object).collect()).collect()
}

fn agree(a: &ObjectFit, b: &ObjectFit) -> bool {
    (0..3).all(|c| {
        let difference = (a.factor[c] - b.factor[c]).abs();
        let smaller = a.factor[c].min(b.factor[c]);
        difference <= NOTABLE * smaller || difference <= ERRORS * a.error[c].hypot(b.error[c])
    })
}

/// The fit of `object`; none if the photograph shows too little of it.
fn look(recovery: &Recovery, of: &ObjectsSeen<'_>, object: usize) -> Option<ObjectFit> {
    let (width, height) = (of.map.width(), of.map.height());
    let side = ((SQUARE * height as f32) as usize).max(1);
    // In each square: the photograph, the re-rendering, and the pixels.
    let mut squares: BTreeMap<usize, (Rgb, Rgb, usize)> = BTreeMap::new();
    for (index, shown) in of.map.pixels().iter().enumerate() {
        // Outliers may be the other material.
        let counts =
            matches!(recovery.status.pixels()[index], PixelStatus::Valid | PixelStatus::Outlier);
        if *shown as usize != object || !counts {
            continue;
        }
        let square = (index / width / side) * width + (index % width) / side;
        let sums = squares.entry(square).or_insert((Rgb::ZERO, Rgb::ZERO, 0));
        sums.0 += of.photograph.pixels()[index];
        sums.1 += recovery.rerendered.pixels()[index];
        sums.2 += 1;
    }
    seen(object, &squares.into_values().collect::<Vec<_>>())
}

/// The ratio of the sums over all squares, with its standard error from the scatter of the squares
/// [Cochran 1977, section 6.3].
fn seen(object: usize, squares: &[(Rgb, Rgb, usize)]) -> Option<ObjectFit> {
    let count = squares.len();
    if count < SQUARES_MIN {
        return None;
    }
    let (mut factor, mut error) = ([0.0; 3], [0.0; 3]);
    for c in 0..3 {
        let pairs =
            squares.iter().map(|(photo, model, _)| (f64::from(photo[c]), f64::from(model[c])));
        let [photo, model] = pairs.clone().fold([0.0; 2], |[p, m], (x, y)| [p + x, m + y]);
        if !(photo > 0.0 && model > 0.0) {
            return None;
        }
        factor[c] = photo / model;
        let squared: f64 = pairs.map(|(x, y)| (x - factor[c] * y).powi(2)).sum();
        error[c] = (squared * count as f64 / (count as f64 - 1.0)).sqrt() / model;
    }
    let pixels = squares.iter().map(|square| square.2).sum();
    Some(ObjectFit { object, pixels, factor, error })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(object: usize, factor: f64, error: f64) -> ObjectFit {
        ObjectFit { object, pixels: 100, factor: [factor; 3], error: [error; 3] }
    }

    #[test]
    fn objects_with_one_factor_are_one_part() {
        let seen = [of(4, 1.3, 0.01), of(1, 0.8, 0.01), of(2, 1.32, 0.01), of(3, 0.9, 0.05)];
        assert_eq!(parts(&seen), [vec![4, 2], vec![1, 3]]);
        assert_eq!(parts(&seen[..1]), [vec![4]]);
    }

    #[test]
    fn the_ratio_has_the_scatter_of_its_squares() {
        let square = |photo: f32| (Rgb::splat(photo), Rgb::splat(10.0), 25);
        let squares = [11.0, 13.0, 11.0, 13.0].map(square);
        let found = seen(0, &squares).unwrap();
        assert!((found.factor[1] - 1.2).abs() < 1e-6 && found.pixels == 100);
        // Four residuals of one each: sqrt(4 * 4 / 3) / 40.
        assert!((found.error[2] - (16.0f64 / 3.0).sqrt() / 40.0).abs() < 1e-6);
        assert!(seen(0, &squares[..3]).is_none());
        assert!(seen(0, &[square(0.0); 4]).is_none());
    }
}
