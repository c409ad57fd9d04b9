//! The downhill simplex [Nelder and Mead 1965], which the paper uses for roughness (section 4.2.4).

use argmin::core::{CostFunction, Error, Executor, State};
use argmin::solver::neldermead::NelderMead;

struct Cost<F>(F);

impl<F: Fn(&[f64]) -> f64> CostFunction for Cost<F> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, parameters: &Vec<f64>) -> Result<f64, Error> {
        let cost = (self.0)(parameters);
        Ok(if cost.is_finite() { cost } else { f64::MAX })
    }
}

/// Minimises `cost` from `start`, with a first simplex that reaches `steps` along each axis.
///
/// Stops when the costs at the corners have a standard deviation below `tolerance`, or after
/// `iterations` steps. Returns the best parameters and their cost.
///
/// ```
/// use unrender_recover::fit::simplex::minimise;
///
/// let bowl = |p: &[f64]| (p[0] - 0.3).powi(2) + (p[1] - 0.2).powi(2);
/// let (best, cost) = minimise(bowl, &[0.1, 0.1], &[0.05, 0.05], 1e-12, 500);
/// assert!(cost < 1e-8 && (best[0] - 0.3).abs() < 1e-3);
/// ```
pub fn minimise(
    cost: impl Fn(&[f64]) -> f64,
    start: &[f64],
    steps: &[f64],
    tolerance: f64,
    iterations: u64,
) -> (Vec<f64>, f64) {
    let mut corners = vec![start.to_vec()];
    for (axis, step) in steps.iter().enumerate() {
        let mut corner = start.to_vec();
        corner[axis] += step;
        corners.push(corner);
    }
    let fallback = cost(start);
    let run = NelderMead::new(corners).with_sd_tolerance(tolerance).and_then(|solver| {
        Executor::new(Cost(&cost), solver).configure(|state| state.max_iters(iterations)).run()
    });
    let best = run.ok().and_then(|result| {
        let state = result.state();
        state.get_best_param().map(|p| (p.clone(), state.get_best_cost()))
    });
    best.filter(|(_, value)| *value <= fallback).unwrap_or_else(|| (start.to_vec(), fallback))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_bottom_of_a_curved_valley() {
        let rosenbrock = |p: &[f64]| (1.0 - p[0]).powi(2) + 100.0 * (p[1] - p[0] * p[0]).powi(2);
        let (best, cost) = minimise(rosenbrock, &[-1.2, 1.0], &[0.3, 0.3], 1e-14, 1000);
        assert!(cost < 1e-9, "{cost}");
        assert!((best[0] - 1.0).abs() < 1e-4 && (best[1] - 1.0).abs() < 1e-4, "{best:?}");
    }
}
