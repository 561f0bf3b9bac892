//! Starts, their collection, and the search over all of them.

use rand::Rng;
use rayon::prelude::*;

use crate::derivative_free::{covariance_adaptation, simplex};
use crate::evaluation::{Evaluator, Value};
use crate::minimax::{Ending, Minimax};
use crate::sample::{space_filling, stream};
use crate::{Outcome, Problem, Settings, StartResult, StartStatus, Status};

/// Certificate below which a start counts as [`StartStatus::Certified`]. With a relative curvature of order one it
/// leaves a decrease of some 1e-6 of the objective.
const CERTIFIED: f64 = 1e-3;

/// Evaluations for each variable that a simplex may take after a descent along differences has stalled.
const POLISH: usize = 100;

/// One independent start: a unit of work whose random stream depends only on the seed, `key` and `index`.
///
/// `key` identifies the problem among those of one study (a hash of a layout, say), so that problems draw different
/// streams under one seed.
///
/// A start samples the box with a scrambled Sobol sequence. Where the problem gives pieces, the best
/// [`Settings::descents`] points of the sample each go down by minimax sequential quadratic programming, sample after
/// sample until [`Settings::effort`] is spent; where it gives none but is smooth, differences over [`Settings::difference`] stand for the
/// gradients, and Nelder-Mead goes on where these stall (at a jump, a kink). With neither, bounded CMA-ES sets out from the
/// best point, and Nelder-Mead finishes. Constraints follow feasibility rules (feasible beats infeasible, then the lower objective or the lower
/// violation) in what is kept, and an exact penalty in what steps are taken.
pub fn start<P: Problem>(problem: &P, settings: &Settings, key: u64, index: usize) -> StartResult {
    let mut evaluator = Evaluator::new(problem, settings);
    let dimension = evaluator.dimension();
    if dimension == 0 {
        evaluator.evaluate(&[]);
        return finish(evaluator, Ending::Converged, &mut Minimax::new(0));
    }
    let mut random = stream(settings.seed, key, index);
    let scramble = random.next_u32();
    let mut minimax = Minimax::new(dimension);
    let mut populates = is_nth(index, settings.population_every);
    // How the descent that found the best point ended, and whether any had pieces at all.
    let mut ending = Ending::Unavailable;
    let mut available = false;
    let count = settings.sample.max(1);
    for batch in 0.. {
        let points = space_filling(
            scramble,
            &mut random,
            dimension,
            batch * count..(batch + 1) * count,
        );
        let mut sample = Vec::with_capacity(count);
        for point in points.chunks_exact(dimension) {
            if evaluator.remaining() == 0 {
                break;
            }
            sample.push(evaluator.sampled(point));
        }
        if batch == 0 {
            evaluator.relieve(&mut sample);
        }
        let mut ranked: Vec<(Value, &[f64])> = Vec::with_capacity(count);
        for one in &sample {
            let (value, point) = (one.value, one.coordinates);
            let place = ranked.partition_point(|(other, _)| !evaluator.prefers(value, *other));
            ranked.insert(place, (value, point));
        }
        for &(value, point) in ranked.iter().take(settings.descents) {
            if evaluator.remaining() == 0 || value.is_failed() {
                break;
            }
            let before = evaluator.best;
            let (this, reached) = minimax.descend(&mut evaluator, &mut point.to_vec(), None);
            if evaluator.best != before || reached == before {
                ending = this;
            }
            available |= this != Ending::Unavailable;
            if evaluator.differences() {
                populates = is_nth(index, settings.population_every_differenced);
            }
        }
        if populates
            && available
            && let Some(&(_, centre)) = ranked.first()
        {
            let mut coordinates = population_step(&mut evaluator, random.next_u64(), centre);
            let before = evaluator.best;
            let (this, _) = minimax.descend(&mut evaluator, &mut coordinates, None);
            if evaluator.best != before {
                ending = this;
            }
        }
        if populates
            || !available
            || evaluator.evaluations >= effort(&evaluator)
            || evaluator.remaining() == 0
        {
            break;
        }
    }
    // Differences see one side of a kink, and gradients nothing of a jump; a simplex goes on from where they stall.
    let jumps = evaluator.differences() || problem.is_smooth();
    let stalled = jumps && ending == Ending::Stalled;
    if (ending == Ending::Unavailable || stalled) && !evaluator.best.is_failed() {
        let most = if available {
            POLISH * dimension
        } else {
            usize::MAX
        };
        ending = without_gradients(&mut evaluator, random.next_u64(), !available, most);
    }
    finish(evaluator, ending, &mut minimax)
}

/// Evaluations after which a start with gradients ends.
fn effort<P: Problem>(evaluator: &Evaluator<'_, P>) -> usize {
    let each = if evaluator.differences() {
        2 * evaluator.dimension() + 1
    } else {
        1
    };
    evaluator.settings.effort.saturating_mul(each)
}

/// Whether it is the turn of start `index` when every so many-th has one.
fn is_nth(index: usize, every: usize) -> bool {
    every > 0 && index % every == every - 1
}

/// A short CMA-ES from a point of the sample, and the best point that it met.
fn population_step<P: Problem>(
    evaluator: &mut Evaluator<'_, P>,
    seed: u64,
    centre: &[f64],
) -> Vec<f64> {
    let dimension = centre.len();
    let weight = if evaluator.has_constraints() {
        10.0 * evaluator.best.objective.abs().max(1e-300)
    } else {
        0.0
    };
    // Without gradients there may be jumps, across which only a population finds its way.
    let each = if evaluator.differences() { 200 } else { 60 };
    let end = evaluator.evaluations + (each * dimension).min(evaluator.remaining());
    let (mut least, mut found) = (f64::INFINITY, centre.to_vec());
    covariance_adaptation(seed, centre, 0.3, population(dimension), 1e-2, &mut |u| {
        (evaluator.evaluations < end).then(|| {
            let penalised = evaluator.evaluate(u).penalised(weight);
            if penalised < least {
                least = penalised;
                found.copy_from_slice(u);
            }
            penalised
        })
    });
    found
}

/// Default population of CMA-ES (N. Hansen 2016, equation 48).
fn population(dimension: usize) -> usize {
    4 + (3.0 * (dimension as f64).ln()) as usize
}

/// CMA-ES (with `global`), then Nelder-Mead from simplices of falling size, on an exact penalty.
fn without_gradients<P: Problem>(
    evaluator: &mut Evaluator<'_, P>,
    seed: u64,
    global: bool,
    most: usize,
) -> Ending {
    let dimension = evaluator.dimension();
    let end = evaluator.evaluations.saturating_add(most);
    let mut weight = if evaluator.has_constraints() {
        10.0 * evaluator.best.objective.abs().max(1e-300)
    } else {
        0.0
    };
    if global {
        let mut spread = 0.25;
        // A tenth of the budget stays for the simplices.
        let reserve = evaluator.settings.evaluations_per_start / 5;
        for round in 0..4 {
            let centre = evaluator.best_coordinates.clone();
            let population = population(dimension) + 2 * round;
            covariance_adaptation(
                seed.wrapping_add(round as u64),
                &centre,
                spread,
                population,
                1e-6,
                &mut |u| {
                    (evaluator.remaining() > reserve)
                        .then(|| evaluator.evaluate(u).penalised(weight))
                },
            );
            // An exact penalty is exact only when it is large enough.
            if evaluator.best.violation <= evaluator.settings.feasibility
                || evaluator.remaining() <= reserve
            {
                break;
            }
            weight *= 100.0;
            spread = 0.1;
        }
    }
    let mut size = if global { 1e-2 } else { 2e-2 };
    let mut previous = evaluator.best;
    let mut quiet = 0;
    while evaluator.remaining() > dimension + 1 && evaluator.evaluations < end {
        let centre = evaluator.best_coordinates.clone();
        simplex(&centre, size, 1e-9, &mut |u| {
            (evaluator.remaining() > 0 && evaluator.evaluations < end)
                .then(|| evaluator.evaluate(u).penalised(weight))
        });
        let gain = previous.objective - evaluator.best.objective;
        let measure = evaluator
            .best
            .objective
            .abs()
            .max(evaluator.settings.magnitude);
        let feasible = evaluator.best.violation <= evaluator.settings.feasibility;
        if !feasible {
            weight *= 10.0;
        }
        if gain.abs() <= 1e-8 * measure && evaluator.best.violation >= previous.violation {
            quiet += 1;
            if quiet >= 2 {
                return Ending::Converged;
            }
            size = if quiet == 1 { -size } else { size };
        } else {
            quiet = 0;
        }
        size = (0.3 * size.abs()).max(1e-5) * size.signum();
        previous = evaluator.best;
    }
    Ending::Budget
}

fn finish<P: Problem>(
    mut evaluator: Evaluator<'_, P>,
    ending: Ending,
    minimax: &mut Minimax,
) -> StartResult {
    let value = evaluator.best;
    let coordinates = evaluator.best_coordinates.clone();
    let certificate = minimax.certify(&mut evaluator, &coordinates, value);
    let status = if value.is_failed() {
        StartStatus::Failed
    } else if evaluator.violation() > evaluator.settings.feasibility {
        StartStatus::Infeasible
    } else if certificate.is_some_and(|length| length <= CERTIFIED) {
        StartStatus::Certified
    } else if ending == Ending::Budget {
        StartStatus::BudgetExhausted
    } else {
        StartStatus::Converged
    };
    let evaluations = evaluator.evaluations;
    let violation = evaluator.violation();
    let (point, constraints) = evaluator.into_best();
    StartResult {
        point,
        objective: value.objective,
        constraints,
        violation,
        evaluations,
        status,
        certificate,
    }
}

/// The best of several starts and how many of them agree on it; ties go to the earlier start.
#[expect(
    clippy::needless_pass_by_value,
    reason = "collecting ends the starts; the caller has no further use for them"
)]
pub fn collect<P: Problem>(problem: &P, settings: &Settings, results: Vec<StartResult>) -> Outcome {
    let starts = results.len();
    let evaluations = results.iter().map(|result| result.evaluations).sum();
    let value = |result: &StartResult| Value {
        objective: result.objective,
        violation: result.violation,
    };
    let mut best: Option<&StartResult> = None;
    for result in &results {
        let failed = value(result).is_failed();
        if !failed
            && best
                .is_none_or(|best| value(result).is_better_than(value(best), settings.feasibility))
        {
            best = Some(result);
        }
    }
    let Some(best) = best else {
        let first = results.first();
        return Outcome {
            point: first.map(|result| result.point.clone()).unwrap_or_default(),
            objective: f64::INFINITY,
            constraints: first
                .map(|result| result.constraints.clone())
                .unwrap_or_default(),
            violation: f64::INFINITY,
            feasible: false,
            active_bounds: Vec::new(),
            starts,
            starts_agreeing: 0,
            evaluations,
            status: Status::Failed,
            certificate: None,
        };
    };
    let feasible = best.violation <= settings.feasibility;
    let tolerance = settings.agreement * best.objective.abs().max(settings.magnitude);
    let starts_agreeing = results
        .iter()
        .filter(|result| {
            feasible
                && result.violation <= settings.feasibility
                && result.objective - best.objective <= tolerance
        })
        .count();
    let active_bounds = problem
        .variables()
        .iter()
        .zip(&best.point)
        .enumerate()
        .filter_map(|(index, (variable, &x))| {
            Some((index, variable.active_side(x, settings.active_bound)?))
        })
        .collect();
    Outcome {
        point: best.point.clone(),
        objective: best.objective,
        constraints: best.constraints.clone(),
        violation: best.violation,
        feasible,
        active_bounds,
        starts,
        starts_agreeing,
        evaluations,
        status: match (feasible, starts_agreeing) {
            (false, _) => Status::Infeasible,
            (true, 0 | 1) => Status::SingleStart,
            (true, _) => Status::Agreed,
        },
        certificate: best.certificate,
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
/// Used to bring a known design to the optimum after the problem changed slightly (a finer frequency grid). A point
/// outside the bounds is moved to the nearest one inside; missing coordinates are taken in the middle of their range.
pub fn polish<P: Problem>(problem: &P, settings: &Settings, from: &[f64]) -> StartResult {
    let mut evaluator = Evaluator::new(problem, settings);
    let mut coordinates: Vec<f64> = problem
        .variables()
        .iter()
        .enumerate()
        .map(|(index, variable)| from.get(index).map_or(0.5, |&x| variable.coordinate(x)))
        .collect();
    let mut minimax = Minimax::new(coordinates.len());
    let (mut ending, value) = minimax.descend(&mut evaluator, &mut coordinates, Some(0.02));
    if ending == Ending::Unavailable && !value.is_failed() {
        ending = without_gradients(&mut evaluator, 0, false, usize::MAX);
    }
    finish(evaluator, ending, &mut minimax)
}
