//! What a candidate would tell, in numbers.

use super::Candidate;
use unrender_recover::Deviations;
use unrender_scene::Rgb;

/// How well the numbers of each group of a scene are known, in its order.
#[derive(Clone, Debug, PartialEq)]
pub struct Known(pub Vec<KnownGroup>);

/// How well the numbers of one group are known.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownGroup {
    /// Its name.
    pub name: String,
    /// Whether its reflectance is asked for.
    pub is_asked: bool,
    /// The standard deviations of its numbers; none where nothing was refined.
    pub std: Option<Deviations>,
    /// Whether a photograph shows it.
    pub is_seen: bool,
}

/// What a candidate would tell of one group.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupPrediction {
    /// The group's name.
    pub name: String,
    /// Its standard deviations over those of now, the geometric mean over its numbers; none where it has none in common.
    pub ratio: Option<f64>,
    /// Whether no photograph shows the group, and the candidate would.
    pub is_new: bool,
}

/// What a candidate would tell.
#[derive(Clone, Debug, PartialEq)]
pub struct Prediction {
    /// The candidate.
    pub candidate: Candidate,
    /// All standard deviations over those of now, the geometric mean over all numbers; one without any.
    pub ratio: f64,
    /// The groups that are asked for.
    pub groups: Vec<GroupPrediction>,
}

impl Prediction {
    /// Of `candidate`: what `with` it is known beside what is known `now`.
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

/// For each number that both have: the second standard deviation over the first.
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
