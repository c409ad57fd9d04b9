//! Measures the kernels in turn on the same rays.

use super::kernel::Kernel;
use super::rays::RaySet;
use crate::machine;
use crate::statistics::median;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;
use unrender::render::accel::Ray;

/// Rays that a thread traces at a time.
const CHUNK: usize = 4096;
/// Distances are different if their relative difference is above this.
const TOLERANCE: f32 = 1e-3;

/// The result for one scene, one kind of rays and one number of threads.
pub(crate) struct Row {
    pub(crate) scene: String,
    pub(crate) set: &'static str,
    pub(crate) threads: usize,
    /// Millions of rays per second: of each kernel, of each round.
    speeds: Vec<Vec<f64>>,
    /// How many rays of a million each kernel except the first answered differently from the first.
    pub(crate) differ: Vec<f64>,
}

impl Row {
    /// Millions of rays per second of a kernel, if it is available.
    pub(crate) fn speed(&self, kernel: usize) -> Option<f64> {
        self.speeds.get(kernel).map(|speeds| median(speeds.iter().copied()))
    }

    /// The speedup of the first kernel over the one with the index `other` after it.
    pub(crate) fn ratio(&self, other: usize) -> Option<f64> {
        let theirs = self.speeds.get(other + 1)?;
        Some(median(self.speeds[0].iter().zip(theirs).map(|(ours, theirs)| ours / theirs)))
    }
}

/// One row for each set of rays, on one thread and on all.
pub(crate) fn measure(
    scene: &str,
    sets: &[RaySet],
    kernels: &[Box<dyn Kernel + '_>],
    rounds: usize,
) -> Vec<Row> {
    let mut rows = Vec::new();
    for set in sets {
        let mut answers = vec![vec![0.0f32; set.rays.len()]; kernels.len()];
        for threads in [1, machine::cores()] {
            let mut speeds = vec![Vec::new(); kernels.len()];
            // The first round warms the caches and does not count.
            for round in 0..=rounds {
                // Each is the first equally often.
                for turn in 0..kernels.len() {
                    let kernel = (round + turn) % kernels.len();
                    let trace = || trace(&*kernels[kernel], set, threads, &mut answers[kernel]);
                    let ((), seconds) = timed(trace);
                    if round > 0 {
                        speeds[kernel].push(1e-6 * set.rays.len() as f64 / seconds);
                    }
                }
            }
            let differ = answers[1..].iter().map(|theirs| differ(&answers[0], theirs)).collect();
            let row = Row { scene: scene.to_owned(), set: set.name, threads, speeds, differ };
            let speeds: Vec<_> = (0..kernels.len()).filter_map(|k| row.speed(k)).collect();
            eprintln!("{scene}, {}, {threads} threads: {speeds:.2?} million rays/s", set.name);
            rows.push(row);
        }
    }
    rows
}

fn trace(kernel: &dyn Kernel, set: &RaySet, threads: usize, answers: &mut [f32]) {
    let parts = Mutex::new(set.rays.chunks(CHUNK).zip(answers.chunks_mut(CHUNK)));
    let next = || parts.lock().unwrap_or_else(PoisonError::into_inner).next();
    let work = || {
        while let Some((rays, answers)) = next() {
            part(kernel, set.any, rays, answers);
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..threads {
            scope.spawn(work);
        }
        work();
    });
}

fn part(kernel: &dyn Kernel, any: bool, rays: &[Ray], answers: &mut [f32]) {
    if any { kernel.occluded(rays, answers) } else { kernel.closest(rays, answers) }
}

/// How many of a million answers are different.
fn differ(ours: &[f32], theirs: &[f32]) -> f64 {
    let different = |(a, b): &(&f32, &f32)| {
        a.is_finite() != b.is_finite() || (**a - **b).abs() > TOLERANCE * **a
    };
    let count = ours.iter().zip(theirs).filter(different).count();
    1e6 * count as f64 / ours.len() as f64
}

/// The result of `work`, and the seconds that it took.
pub(crate) fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let started = Instant::now();
    let done = work();
    (done, started.elapsed().as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn different_answers_are_counted() {
        let inf = f32::INFINITY;
        let ours = [1.0, 1.0, inf, inf, 1.0];
        let theirs = [1.0005, 1.1, inf, 2.0, inf];
        assert_eq!(differ(&ours, &theirs), 600_000.0);
    }
}
