//! The recovered environment.

use super::Recovered;
use crate::Job;
use unrender_formats::materials::{LightEntry, PanoramaEntry};
use unrender_recover::{LightResult, Quantity, Unknown};
use unrender_scene::Rgb;

/// The environment's mean radiance, and that of each of its parts if it is in parts; none if it was not recovered.
pub(super) fn entry(job: &Job, recovered: &Recovered) -> Option<LightEntry> {
    let places = job.scene.environment_parts();
    let around = job.scene.environment.as_ref()?;
    let lights = &recovered.recovery.lights;
    let parts: Vec<&LightResult> =
        places.clone().filter_map(|p| lights.iter().find(|l| l.source == p)).collect();
    if parts.is_empty() || parts.len() != places.len() {
        return None;
    }
    let [columns, rows] = around.parts();
    let is_whole = [columns, rows] == [1, 1];
    let strength =
        |part: usize| if is_whole { around.mean() } else { around.panorama().pixels()[part] };
    let weight = |part: usize| strength(part) * around.share(part) as f32;
    let mean: Rgb = (0..parts.len()).map(|part| weight(part) * parts[part].factor).sum();
    let std = match parts[..] {
        [one] => weight(0) * one.std,
        _ => deviation_of_sum(recovered, places.start, &weight, parts.len()),
    };
    let panorama = (!is_whole).then(|| PanoramaEntry {
        columns,
        rows,
        radiance: (0..parts.len()).map(|p| (strength(p) * parts[p].factor).to_array()).collect(),
        std: (0..parts.len()).map(|p| (strength(p) * parts[p].std).to_array()).collect(),
    });
    Some(LightEntry { intensity: Some(mean.to_array()), std: Some(std.to_array()), panorama })
}

/// The standard deviation of the sum of `count` sources from number `first` on, each times its `weight`.
fn deviation_of_sum(
    recovered: &Recovered,
    first: usize,
    weight: &dyn Fn(usize) -> Rgb,
    count: usize,
) -> Rgb {
    let Some(covariance) = &recovered.recovery.covariance else { return Rgb::ZERO };
    let of_channel = |channel: usize| {
        let place = |part: usize| {
            let wanted =
                Unknown { quantity: Quantity::Light, of: first + part, channel: Some(channel) };
            covariance.of.iter().position(|unknown| *unknown == wanted)
        };
        let places: Vec<(usize, f64)> = (0..count)
            .filter_map(|part| Some((place(part)?, f64::from(weight(part)[channel]))))
            .collect();
        let pairs = places.iter().flat_map(|a| places.iter().map(move |b| (a, b)));
        let variance: f64 = pairs.map(|(a, b)| a.1 * b.1 * covariance.matrix[a.0][b.0]).sum();
        variance.max(0.0).sqrt() as f32
    };
    Rgb::from_array(std::array::from_fn(of_channel))
}
