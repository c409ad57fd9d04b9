//! Compares the present run with an earlier one.

use super::measure::SceneNoise;
use super::record::Record;
use super::statistics::Noise;
use crate::Failure;
use crate::statistics::geometric_mean;
use std::path::{Path, PathBuf};

/// An earlier run.
pub(super) struct Before {
    file: PathBuf,
    record: Record,
}

/// Quotients for one set of pixels in two runs; none if one of them has no noise, or no light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Quotients {
    /// The mean radiance now over that before.
    pub(super) mean: Option<f64>,
    /// Variance times seconds before over that now.
    pub(super) efficiency: Option<f64>,
    /// The same for the robust noise.
    pub(super) robust: Option<f64>,
}

/// A scene now compared with the same scene before.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Compared {
    /// Of all pixels that are used.
    pub(super) picture: Quotients,
    /// Of each group that has a row now; none for those that had no row before.
    pub(super) groups: Vec<Option<Quotients>>,
    /// Paths per second now over those before.
    pub(super) speed: f64,
}

impl Before {
    /// Reads the file of an earlier run.
    ///
    /// # Errors
    /// If it cannot be read, or is not one.
    pub(super) fn read(file: &Path) -> Result<Self, Failure> {
        Ok(Self { file: file.to_owned(), record: Record::read(file)? })
    }

    /// A sentence about the earlier run.
    pub(super) fn sentence(&self) -> String {
        format!("compared with {}. {}", self.file.display(), self.record.measured)
    }

    /// The scene called `name`, measured `now`, compared with the file's entry; none if there is none, or if
    /// its pictures have another size.
    pub(super) fn compare(&self, name: &str, now: &SceneNoise) -> Option<Compared> {
        let before = self.record.scenes.get(name).filter(|before| before.size == now.size)?;
        Some(Compared::of(before, now))
    }

    /// A sentence about the scenes that could not be compared; none if all could.
    pub(super) fn without(&self, missing: &[&str]) -> Option<String> {
        let sentence = || {
            format!(
                "{} has no pictures of this size of: {}",
                self.file.display(),
                missing.join(", ")
            )
        };
        (!missing.is_empty()).then(sentence)
    }
}

impl Compared {
    fn of(before: &SceneNoise, now: &SceneNoise) -> Self {
        let seconds = before.seconds / now.seconds;
        let group = |name: &str| before.groups.iter().find(|group| group.name == name);
        let groups = now.groups.iter().map(|now| {
            let before = group(&now.name)?;
            Some(Quotients::of(&before.noise, &now.noise, seconds))
        });
        Self {
            picture: Quotients::of(&before.picture, &now.picture, seconds),
            groups: groups.collect(),
            speed: now.speed() / before.speed(),
        }
    }

    /// The geometric means over the groups of their efficiencies, and of those by the robust noise.
    pub(super) fn of_groups(&self) -> [Option<f64>; 2] {
        let groups = || self.groups.iter().flatten();
        let mean = |values: Vec<f64>| Some(geometric_mean(values)).filter(|mean| !mean.is_nan());
        [
            mean(groups().filter_map(|group| group.efficiency).collect()),
            mean(groups().filter_map(|group| group.robust).collect()),
        ]
    }
}

impl Quotients {
    /// `seconds` is the time before over that now.
    fn of(before: &Noise, now: &Noise, seconds: f64) -> Self {
        let efficiency = |before: f64, now: f64| Some(quotient(before, now)?.powi(2) * seconds);
        Self {
            mean: quotient(now.mean, before.mean),
            efficiency: efficiency(before.rms, now.rms),
            robust: efficiency(before.robust, now.robust),
        }
    }
}

fn quotient(a: f64, b: f64) -> Option<f64> {
    (a > 0.0 && b > 0.0).then_some(a / b)
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::measure::GroupNoise;
    use super::*;

    pub(in super::super) fn noise(rms: f64, robust: f64) -> Noise {
        Noise { pixels: 1234, mean: 0.5, rms, robust, worst: 0.25 }
    }

    /// A scene with these `groups` and the rms of each; the robust noise is half of it.
    pub(in super::super) fn scene(seconds: f64, groups: &[(&str, f64)]) -> SceneNoise {
        let group = |&(name, rms): &(&str, f64)| GroupNoise {
            name: name.to_owned(),
            noise: noise(rms, 0.5 * rms),
        };
        SceneNoise {
            size: [160, 120],
            spp: 64,
            seed: 0,
            seconds,
            picture: noise(0.2, 0.1),
            groups: groups.iter().map(group).collect(),
        }
    }

    fn before(scene: SceneNoise) -> Before {
        let mut record = Record::new("Measured once.".into());
        record.scenes.insert("room".into(), scene);
        Before { file: "before.json".into(), record }
    }

    #[test]
    fn efficiency_is_variance_times_seconds() {
        let before = before(scene(2.0, &[("a", 0.2), ("b", 0.4), ("gone", 1.0)]));
        let now = scene(1.0, &[("a", 0.1), ("b", 0.4), ("new", 0.3)]);
        let compared = before.compare("room", &now).unwrap();
        assert_eq!(compared.picture.efficiency, Some(2.0));
        assert_eq!(compared.speed, 2.0);
        assert_eq!(compared.groups[0].unwrap().efficiency, Some(8.0));
        assert_eq!(compared.groups[1].unwrap().mean, Some(1.0));
        assert_eq!(compared.groups[2], None);
        // 8 and 2.
        assert!(compared.of_groups().iter().all(|mean| (mean.unwrap() - 4.0).abs() < 1e-12));
    }

    #[test]
    fn what_is_not_in_the_file_is_said() {
        let before = before(scene(2.0, &[]));
        let now = scene(1.0, &[]);
        assert_eq!(before.compare("hall", &now), None);
        assert_eq!(before.compare("room", &SceneNoise { size: [80, 60], ..now }), None);
        let said = before.without(&["hall", "fig8"]);
        assert_eq!(
            said.as_deref(),
            Some("before.json has no pictures of this size of: hall, fig8")
        );
        assert_eq!(before.without(&[]), None);
    }

    #[test]
    fn scenes_without_noise_or_groups_have_no_efficiency() {
        let silent = SceneNoise { picture: noise(0.0, 0.0), ..scene(1.0, &[]) };
        let compared = before(silent.clone()).compare("room", &silent).unwrap();
        assert_eq!((compared.picture.efficiency, compared.of_groups()), (None, [None, None]));
    }
}
