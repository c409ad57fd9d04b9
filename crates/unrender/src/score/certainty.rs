//! Errors in units of the standard deviations that the results state, to check these.
//!
//! If they are right, and errors are normal, 68 % of all values lie within one and 95 % within two.

use super::GroupScore;
use serde::Serialize;
use unrender_formats::materials::MaterialsFile;

/// The error of one parameter whose standard deviation the results state; one value, or one per
/// channel.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterScore {
    /// Its key in the results: rho_d, rho_s, alpha_x, alpha_y, theta_deg, or a light's intensity.
    pub parameter: &'static str,
    /// Absolute errors; of textures, the mean over the texels.
    pub error: Vec<f64>,
    /// Standard deviations; of textures, those of one texel.
    pub std: Vec<f64>,
    /// The errors divided by the standard deviations; none where these are zero.
    pub in_std: Vec<Option<f64>>,
}

impl ParameterScore {
    pub(super) fn new(parameter: &'static str, error: &[f64], std: &[f32]) -> Self {
        let std: Vec<f64> = std.iter().map(|&std| f64::from(std)).collect();
        let ratio = |(error, std): (&f64, &f64)| (*std > 0.0).then(|| error / std);
        let in_std = error.iter().zip(&std).map(ratio).collect();
        Self { parameter, error: error.to_vec(), std, in_std }
    }
}

/// The largest error of `parameters` in units of its standard deviation.
pub(super) fn largest(parameters: &[ParameterScore]) -> Option<f64> {
    parameters.iter().flat_map(|p| &p.in_std).filter_map(|ratio| *ratio).reduce(f64::max)
}

/// The error of one light.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LightScore {
    /// The light's name.
    pub light: String,
    /// Largest relative error of the intensity over the channels that emit, percent.
    pub percent: Option<f64>,
    /// The intensity, if the results state its standard deviation.
    pub parameters: Vec<ParameterScore>,
}

/// Compares the lights that `results` and `truth` both have an intensity for.
pub fn score_lights(results: &MaterialsFile, truth: &MaterialsFile) -> Vec<LightScore> {
    let pairs = truth.lights.iter().filter_map(|(name, wanted)| {
        let found = results.lights.get(name)?;
        let [found_is, wanted_is] = [found.intensity?, wanted.intensity?].map(|v| v.map(f64::from));
        let error: [f64; 3] = std::array::from_fn(|c| (found_is[c] - wanted_is[c]).abs());
        let shining = (0..3).filter(|&c| wanted_is[c] > 0.0);
        let parameter = |std: &[f32; 3]| ParameterScore::new("intensity", &error, std);
        Some(LightScore {
            light: name.clone(),
            percent: shining.map(|c| 100.0 * error[c] / wanted_is[c]).reduce(f64::max),
            parameters: found.std.iter().map(parameter).collect(),
        })
    });
    pairs.collect()
}

/// How the stated standard deviations agree with the errors; each channel is a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Certainty {
    /// The number of parameters of lights, and of groups that count, with a standard deviation
    /// above zero.
    pub parameters: usize,
    /// The percentage whose error is at most one standard deviation.
    pub percent_within_one: f64,
    /// The percentage whose error is at most two.
    pub percent_within_two: f64,
    /// The largest error in units of its standard deviation.
    pub worst: f64,
}

/// Sums up all stated standard deviations; none if there is none.
pub fn certainty(groups: &[GroupScore], lights: &[LightScore]) -> Option<Certainty> {
    let of_groups = groups.iter().filter(|g| g.counted).flat_map(|g| &g.parameters);
    let all = of_groups.chain(lights.iter().flat_map(|light| &light.parameters));
    let ratios: Vec<f64> = all.flat_map(|p| &p.in_std).filter_map(|ratio| *ratio).collect();
    let percent_within = |limit: f64| {
        100.0 * ratios.iter().filter(|&&r| r <= limit).count() as f64 / ratios.len() as f64
    };
    let worst = ratios.iter().copied().reduce(f64::max)?;
    Some(Certainty {
        parameters: ratios.len(),
        percent_within_one: percent_within(1.0),
        percent_within_two: percent_within(2.0),
        worst,
    })
}
