//! The last line: a summary of all scenes.

use super::compare::Compared;
use super::measure::SceneNoise;
use crate::statistics::geometric_mean;

/// A group whose ratio is above this has a tail: most pixels have less noise than the mean square indicates.
/// Uneven light alone gives up to 2; at half of it every group has a tail, at double fireflies of a few pixels
/// pass.
const TAIL: f64 = 2.0;

/// The measurements so far.
#[derive(Debug, Default)]
pub(super) struct Summary {
    scenes: usize,
    groups: usize,
    with_tail: usize,
    /// The largest ratio of a group, and the names of the group and its scene.
    worst: Option<(f64, String)>,
    seconds: f64,
    efficiencies: Vec<f64>,
    speeds: Vec<f64>,
}

impl Summary {
    /// Adds a scene, and its comparison with an earlier run.
    pub(super) fn add(&mut self, scene: &str, noise: &SceneNoise, compared: Option<&Compared>) {
        self.scenes += 1;
        self.seconds += noise.seconds;
        for group in &noise.groups {
            let Some(ratio) = group.noise.ratio() else { continue };
            self.groups += 1;
            self.with_tail += usize::from(ratio > TAIL);
            if self.worst.as_ref().is_none_or(|(worst, _)| ratio > *worst) {
                self.worst = Some((ratio, format!("{} of {scene}", group.name)));
            }
        }
        if let Some(compared) = compared {
            self.efficiencies.extend(compared.picture.efficiency);
            self.speeds.push(compared.speed);
        }
    }

    /// The line.
    pub(super) fn line(&self) -> String {
        let Self { scenes, groups, with_tail, seconds, .. } = self;
        let mut line =
            format!("summary: {scenes} scenes, {groups} groups, ratio above {TAIL} in {with_tail}");
        if let Some((ratio, name)) = &self.worst {
            line += &format!(", at most {ratio:.2} ({name})");
        }
        line += &format!("; {seconds:.1} s");
        let least = self.efficiencies.iter().copied().fold(f64::INFINITY, f64::min);
        if least.is_finite() {
            let [efficiency, speed] =
                [&self.efficiencies, &self.speeds].map(|all| geometric_mean(all.iter().copied()));
            line += &format!(
                "; efficiency {efficiency:.2}, at least {least:.2}, speed {speed:.2} times those of before"
            );
        }
        line
    }
}

#[cfg(test)]
mod tests {
    use super::super::measure::GroupNoise;
    use super::super::statistics::Noise;
    use super::*;

    #[test]
    fn groups_with_a_tail_are_counted_and_the_worst_is_named() {
        let noise = |rms| Noise { pixels: 100, mean: 1.0, rms, robust: 0.1, worst: 0.1 };
        let group = |name: &str, rms| GroupNoise { name: name.into(), noise: noise(rms) };
        let scene = SceneNoise {
            size: [10, 10],
            spp: 4,
            seed: 0,
            seconds: 2.0,
            picture: noise(0.2),
            groups: vec![group("wall", 0.15), group("floor", 0.3)],
        };
        let mut summary = Summary::default();
        summary.add("room", &scene, None);
        let expected =
            "summary: 1 scenes, 2 groups, ratio above 2 in 1, at most 3.00 (floor of room); 2.0 s";
        assert_eq!(summary.line(), expected);
    }
}
