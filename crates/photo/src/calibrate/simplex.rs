//! The downhill simplex [Nelder and Mead 1965] on the reprojection error, as in [Boivin and
//! Gagalowicz 2002, section 3.1].

use super::model::{Free, Model, Sight};
use argmin::core::{CostFunction, Error, Executor, State};
use argmin::solver::neldermead::NelderMead;

/// The first simplex: radians, share of the distance, logarithm of the focal length, share of the
/// focal length, distortion.
const ROTATION: f64 = 0.02;
const TRANSLATION: f64 = 0.02;
const LN_FOCAL: f64 = 0.05;
const SHIFT: f64 = 0.01;
const BEND: f64 = 0.01;
/// The search ends where the mean squared residuals at the corners differ by this, pixels^2.
const TOLERANCE: f64 = 1e-6;
const ITERATIONS: u64 = 2000;

struct Cost<F>(F);

impl<F: Fn(&[f64]) -> f64> CostFunction for Cost<F> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, step: &Vec<f64>) -> Result<f64, Error> {
        let cost = (self.0)(step);
        Ok(if cost.is_finite() { cost } else { f64::MAX })
    }
}

/// The camera downhill from `start`.
pub(super) fn downhill(start: &Model, sights: &[Sight], free: Free) -> Model {
    let distances = sights.iter().map(|sight| (sight.point - start.eye).norm());
    let distance = distances.sum::<f64>() / sights.len().max(1) as f64;
    let mut steps = vec![
        ROTATION,
        ROTATION,
        ROTATION,
        TRANSLATION * distance,
        TRANSLATION * distance,
        TRANSLATION * distance,
    ];
    if free.focal {
        steps.push(LN_FOCAL);
    }
    if free.principal_point {
        steps.extend([SHIFT * start.ln_focal.exp(); 2]);
    }
    if free.distortion {
        steps.extend([BEND; 2]);
    }
    let mut corners = vec![vec![0.0; steps.len()]];
    for (axis, step) in steps.iter().enumerate() {
        let mut corner = vec![0.0; steps.len()];
        corner[axis] = *step;
        corners.push(corner);
    }
    let cost = |step: &[f64]| start.moved(step, free).cost(sights) / sights.len().max(1) as f64;
    let run = NelderMead::new(corners).with_sd_tolerance(TOLERANCE).and_then(|solver| {
        Executor::new(Cost(cost), solver).configure(|state| state.max_iters(ITERATIONS)).run()
    });
    let best = run.ok().and_then(|result| result.state().get_best_param().cloned());
    let found = best.map_or(*start, |step| start.moved(&step, free));
    if found.cost(sights) <= start.cost(sights) { found } else { *start }
}
