//! Which kinds of paths a scene's noise comes from.

use super::measure::{Paths, Pictures, Shot};
use std::collections::BTreeMap;
use unrender::render::BrightPath;

/// A path is bright from so many times the mean radiance of the picture on. At 64 paths a pixel it changes its pixel
/// by a third of the mean, which is seen. At half of it there are four times as many, and most are no trouble; at
/// double what makes a tenth of the variance is missed.
const BRIGHT: f64 = 20.0;
/// So many kinds have a line. At half of them the rest is often more than a tenth of the variance, at double the
/// lines are mostly of long paths that nobody can do anything about.
const KINDS: usize = 8;

/// The bright paths of one kind, of both pictures.
#[derive(Clone, Debug, Default, PartialEq)]
struct Kind {
    /// What happened, a letter each.
    letters: String,
    paths: usize,
    /// The largest radiance of a path.
    worst: f64,
    /// Its part of the sum of both pictures' variances over all pixels.
    variance: f64,
}

/// The lines about a scene of which `pictures` were rendered.
pub(super) fn lines(shot: &Shot, paths: Paths, pictures: &Pictures) -> Vec<String> {
    let counting = || pictures.group_of.iter().zip(&pictures.values).filter(|(g, _)| g.is_some());
    let count = counting().count().max(1) as f64;
    let mean = counting().map(|(_, [a, b])| 0.5 * (a + b)).sum::<f64>() / count;
    // The difference of two pictures has the variances of both.
    let variance: f64 = counting().map(|(_, [a, b])| (a - b).powi(2)).sum();
    let materials = shot.scene.materials();
    let mut both = Vec::new();
    for settings in paths.of_both() {
        let threshold = (BRIGHT * mean) as f32;
        let tracer = &pictures.tracer;
        let mut bright =
            tracer.bright_paths(&materials, &shot.camera, shot.size, &settings, threshold);
        bright.retain(|path| pictures.group_of[path.pixel as usize].is_some());
        both.push(bright);
    }
    text(&kinds(&both, paths.spp), mean, variance)
}

/// The kinds of `pictures`' paths, that of the largest variance first.
///
/// Of `n` samples of a pixel, those along a kind of path have the sum `s` and the sum of squares `q`, the others
/// being zero; the variance of the pixel by this kind is then `(q - s^2 / n) / (n (n - 1))`. A path that all
/// samples find, like the image of a lamp in a mirror, has none.
fn kinds(pictures: &[Vec<BrightPath>], spp: u32) -> Vec<Kind> {
    let n = f64::from(spp);
    let mut kinds: BTreeMap<&str, Kind> = BTreeMap::new();
    for of_pixel in pictures.iter().flat_map(|paths| paths.chunk_by(|a, b| a.pixel == b.pixel)) {
        let mut sums: BTreeMap<&str, [f64; 2]> = BTreeMap::new();
        for path in of_pixel {
            let radiance = path.radiance.as_dvec3().element_sum() / 3.0;
            let [sum, squares] = sums.entry(&path.kind).or_default();
            *sum += radiance;
            *squares += radiance * radiance;
            let kind = kinds.entry(&path.kind).or_default();
            kind.paths += 1;
            kind.worst = kind.worst.max(radiance);
        }
        for (letters, [sum, squares]) in sums {
            let kind = kinds.entry(letters).or_default();
            kind.variance += (squares - sum * sum / n).max(0.0) / (n * (n - 1.0));
        }
    }
    let named = |(letters, kind): (&str, Kind)| Kind { letters: letters.to_owned(), ..kind };
    let mut kinds: Vec<Kind> = kinds.into_iter().map(named).collect();
    kinds.sort_by(|a, b| b.variance.total_cmp(&a.variance));
    kinds
}

/// The lines of `kinds` in a picture of this `mean` radiance and of this `variance` of all pixels.
fn text(kinds: &[Kind], mean: f64, variance: f64) -> Vec<String> {
    let percent = |part: f64| if variance > 0.0 { 100.0 * part / variance } else { 0.0 };
    let shown = &kinds[..kinds.len().min(KINDS)];
    let spaced = |kind: &Kind| {
        let letters: Vec<String> = kind.letters.chars().map(String::from).collect();
        letters.join(" ")
    };
    let width = shown.iter().map(|kind| spaced(kind).len()).max().unwrap_or(0);
    let mut lines: Vec<String> = shown
        .iter()
        .map(|kind| {
            format!(
                "{:<width$}  {:>8} paths   worst {:>9.1}   {:>5.1} % of the variance",
                spaced(kind),
                kind.paths,
                kind.worst / mean,
                percent(kind.variance)
            )
        })
        .collect();
    let rest = &kinds[shown.len()..];
    if !rest.is_empty() {
        lines.push(format!(
            "{} other kinds: {} paths, {:.1} % of the variance",
            rest.len(),
            rest.iter().map(|kind| kind.paths).sum::<usize>(),
            percent(rest.iter().map(|kind| kind.variance).sum())
        ));
    }
    if lines.is_empty() {
        lines.push(format!("no path is {BRIGHT:.0} times as bright as the picture"));
    }
    lines
}
