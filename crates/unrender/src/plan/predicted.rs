//! The predicted gain of a candidate.

use super::Candidate;
use unrender_recover::Deviations;
use unrender_scene::Rgb;

/// The standard deviations of each group of a scene, in its order.
#[derive(Clone, Debug, PartialEq)]
pub struct Known(pub Vec<KnownGroup>);

/// The standard deviations of one group.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownGroup {
    /// Its name.
    pub name: String,
    /// Whether its reflectance is unknown.
    pub is_asked: bool,
    /// The standard deviations of its parameters; none if nothing was refined.
    pub std: Option<Deviations>,
    /// Whether a photograph shows it.
    pub is_seen: bool,
}

/// The predicted gain of a candidate for one group.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupPrediction {
    /// The group's name.
    pub name: String,
    /// Its predicted standard deviations over the present ones, the geometric mean over its
    /// parameters; none if they have none in common.
    pub ratio: Option<f64>,
    /// Whether no photograph shows the group, and the candidate would.
    pub is_new: bool,
}

/// The predicted gain of a candidate.
#[derive(Clone, Debug, PartialEq)]
pub struct Prediction {
    /// The candidate.
    pub candidate: Candidate,
    /// All predicted standard deviations over the present ones, the geometric mean over all parameters;
    /// one without any.
    pub ratio: f64,
    /// The groups with unknown reflectance.
    pub groups: Vec<GroupPrediction>,
}

impl Prediction {
    /// The prediction for `candidate`, from the standard deviations `with` it and those `now`.
    pub fn new(candidate: Candidate, now: &Known, with: &Known) -> Self {
        let asked = || now.0.iter().zip(&with.0).filter(|(a, _)| a.is_asked);
        let all: Vec<f64> = asked().flat_map(|(a, b)| ratios(a, b)).collect();
        let group = |(a, b): (&KnownGroup, &KnownGroup)| GroupPrediction {
            name: a.name.clone(),
            ratio: mean(&ratios(a, b)),
            is_new: !a.is_seen && b.is_seen,
        };
        Self { candidate, ratio: mean(&all).unwrap_or(1.0), groups: asked().map(group).collect() }
    }
}

/// The geometric mean.
fn mean(ratios: &[f64]) -> Option<f64> {
    let sum: f64 = ratios.iter().map(|ratio| ratio.ln()).sum();
    (!ratios.is_empty()).then(|| (sum / ratios.len() as f64).exp())
}

/// For each parameter that both have: the second standard deviation over the first.
fn ratios(a: &KnownGroup, b: &KnownGroup) -> Vec<f64> {
    let (Some(a), Some(b)) = (&a.std, &b.std) else { return Vec::new() };
    let numbers = |of: &Deviations| {
        let rgb = |value: Option<Rgb>| value.map_or([None; 3], |v| v.to_array().map(Some));
        let [r, g, b] = rgb(of.rho_d);
        let [sr, sg, sb] = rgb(of.rho_s);
        [r, g, b, sr, sg, sb, of.ln_alpha_x, of.ln_alpha_y, of.theta_rad]
    };
    let both = numbers(a).into_iter().zip(numbers(b));
    let ratio = |(a, b): (Option<f32>, Option<f32>)| {
        let (a, b) = (f64::from(a?), f64::from(b?));
        (a > 0.0 && b > 0.0).then(|| b / a)
    };
    both.filter_map(ratio).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_of_a_half_and_a_double_is_one() {
        assert!((mean(&[0.5, 2.0]).unwrap() - 1.0).abs() < 1e-12);
        assert_eq!(mean(&[]), None);
    }
}
