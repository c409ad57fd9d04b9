//! Finds the kinds of paths that cause a scene's noise.

use super::measure::{Paths, Pictures, Shot};
use std::collections::BTreeMap;
use unrender::render::BrightPath;

/// A path is bright from this many times the mean radiance of the picture on. At 64 paths per pixel it changes its
/// pixel by a third of the mean, which is visible. At half of it there are several times as many, most of them
/// harmless; at double much of the noise of pictures without caustics is unexplained.
const BRIGHT: f64 = 20.0;
/// The number of kinds that have a line. At half of it the rest is often more than a tenth of the variance, at
/// double most lines are of long paths with a thousandth each.
const KINDS: usize = 8;

/// A bright path.
struct Found {
    pixel: usize,
    /// Its contribution to its sample, the mean of the channels.
    radiance: f64,
    /// The events along it, a letter each.
    letters: String,
}

impl From<BrightPath> for Found {
    fn from(path: BrightPath) -> Self {
        let radiance = path.radiance.as_dvec3().element_sum() / 3.0;
        Self { pixel: path.pixel as usize, radiance, letters: path.kind }
    }
}

/// The bright paths of one kind in both pictures.
#[derive(Clone, Debug, Default, PartialEq)]
struct Kind {
    letters: String,
    paths: usize,
    /// The largest radiance of a path.
    worst: f64,
    /// Its share of the variance of all pixels that are used.
    share: f64,
}

/// The lines about a scene whose `pictures` were rendered.
pub(super) fn lines(shot: &Shot, paths: Paths, pictures: &Pictures) -> Vec<String> {
    let counts = |pixel: usize| pictures.group_of[pixel].is_some();
    let difference = |(pixel, [a, b]): (usize, &[f64; 2])| if counts(pixel) { a - b } else { 0.0 };
    let differences: Vec<f64> = pictures.values.iter().enumerate().map(difference).collect();
    let mean = pictures.mean();
    let materials = shot.scene.materials();
    let both = paths.of_both().map(|settings| {
        let threshold = (BRIGHT * mean) as f32;
        let tracer = &pictures.tracer;
        let found = tracer.bright_paths(&materials, &shot.camera, shot.size, &settings, threshold);
        found.into_iter().map(Found::from).filter(|path| counts(path.pixel)).collect()
    });
    text(&kinds(&both, &differences, paths.spp), mean)
}

/// The kinds of the paths of both pictures, in order of decreasing shares of the variance.
///
/// With `a - b` the difference of the two pictures in a pixel, and `c` the difference of the contributions of a kind
/// of path to it, the share of the kind is its covariance: the sum of `c (a - b)` over the sum of `(a - b)^2`. The
/// shares of all paths, bright or not, sum to one. Paths that contribute equally to both pictures, like the image of
/// a lamp in a mirror, have none.
fn kinds(both: &[Vec<Found>; 2], differences: &[f64], spp: u32) -> Vec<Kind> {
    let variance: f64 = differences.iter().map(|d| d * d).sum();
    let mut kinds: BTreeMap<&str, Kind> = BTreeMap::new();
    for (paths, sign) in both.iter().zip([1.0, -1.0]) {
        for path in paths {
            let kind = kinds.entry(&path.letters).or_default();
            kind.paths += 1;
            kind.worst = kind.worst.max(path.radiance);
            if variance > 0.0 {
                let contribution = sign * path.radiance / f64::from(spp);
                kind.share += contribution * differences[path.pixel] / variance;
            }
        }
    }
    let named = |(letters, kind): (&str, Kind)| Kind { letters: letters.to_owned(), ..kind };
    let mut kinds: Vec<Kind> = kinds.into_iter().map(named).collect();
    kinds.sort_by(|a, b| b.share.total_cmp(&a.share));
    kinds
}

/// The lines of `kinds` in a picture of this `mean` radiance.
fn text(kinds: &[Kind], mean: f64) -> Vec<String> {
    if kinds.is_empty() {
        return vec![format!("no path is {BRIGHT:.0} times as bright as the picture")];
    }
    let (shown, rest) = kinds.split_at(kinds.len().min(KINDS));
    let names: Vec<String> = shown.iter().map(|kind| spaced(&kind.letters)).collect();
    let others = format!("{} more kinds", rest.len());
    let dim = "all other paths".to_owned();
    let width = names.iter().chain([&others, &dim]).map(String::len).max().unwrap_or(0);
    let line = |name: &str, [paths, worst]: [String; 2], share: f64| {
        let percent = 100.0 * share;
        format!("{name:<width$}  {paths:>14}   {worst:>20}   {percent:>5.1} % of the variance")
    };
    let numbers = |kinds: &[Kind]| {
        let paths = kinds.iter().map(|kind| kind.paths).sum::<usize>();
        let worst = kinds.iter().map(|kind| kind.worst).fold(0.0, f64::max) / mean;
        let plural = if paths == 1 { "" } else { "s" };
        [format!("{paths} path{plural}"), format!("worst {worst:.1} x mean")]
    };
    let sum = |kinds: &[Kind]| kinds.iter().map(|kind| kind.share).sum::<f64>();
    let of_kind = |(name, kind): (&String, &Kind)| {
        line(name, numbers(std::slice::from_ref(kind)), kind.share)
    };
    let mut lines: Vec<String> = names.iter().zip(shown).map(of_kind).collect();
    if !rest.is_empty() {
        lines.push(line(&others, numbers(rest), sum(rest)));
    }
    lines.push(line(&dim, [String::new(), String::new()], 1.0 - sum(kinds)));
    lines
}

/// The letters, separated by spaces.
fn spaced(letters: &str) -> String {
    let letters: Vec<String> = letters.chars().map(String::from).collect();
    letters.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(pixel: usize, radiance: f64, letters: &str) -> Found {
        Found { pixel, radiance, letters: letters.to_owned() }
    }

    #[test]
    fn a_path_that_one_picture_found_has_the_variance() {
        // Four samples per pixel. In the first pixel one picture found a caustic of 40, in the second both found
        // the image of a lamp; in the third one picture is 1 brighter by paths that are not bright.
        let both = [
            vec![found(0, 40.0, "DML"), found(1, 80.0, "ML")],
            vec![found(1, 80.0, "ML"), found(1, 8.0, "l")],
        ];
        let kinds = kinds(&both, &[10.0, -2.0, 1.0], 4);
        let of = |letters: &str| kinds.iter().find(|kind| kind.letters == letters).unwrap();
        let variance = 100.0 + 4.0 + 1.0;
        assert_eq!((kinds[0].letters.as_str(), of("DML").paths, of("ML").paths), ("DML", 1, 2));
        assert_eq!(of("DML").worst, 40.0);
        for (letters, part) in [("DML", 100.0), ("ML", 0.0), ("l", 4.0)] {
            assert!((of(letters).share - part / variance).abs() < 1e-12, "{letters}");
        }
        let lines = text(&kinds, 0.5);
        assert_eq!(lines.len(), 4);
        assert_eq!(
            lines[0],
            "D M L                    1 path      worst 80.0 x mean    95.2 % of the variance"
        );
        let rest: Vec<&str> = lines[3].split_whitespace().collect();
        assert_eq!(rest.join(" "), "all other paths 1.0 % of the variance");
    }

    #[test]
    fn equal_pictures_and_dim_ones_have_something_to_say() {
        let both = [vec![found(0, 9.0, "l")], vec![found(0, 9.0, "l")]];
        assert_eq!(kinds(&both, &[0.0], 4)[0].share, 0.0);
        assert_eq!(text(&[], 1.0), ["no path is 20 times as bright as the picture"]);
    }

    #[test]
    fn kinds_beyond_the_first_share_a_line() {
        let kind = |index: usize| Kind {
            letters: "D".repeat(index) + "L",
            paths: 2,
            worst: 3.0,
            share: 0.1 / (index + 1) as f64,
        };
        let kinds: Vec<Kind> = (0..KINDS + 3).map(kind).collect();
        let lines = text(&kinds, 1.0);
        assert_eq!(lines.len(), KINDS + 2);
        assert!(lines[KINDS].starts_with("3 more kinds") && lines[KINDS].contains(" 6 paths"));
    }
}
