//! Newton's method for the unknowns of one layer.

use quell_expression::Workspace;

use super::compiled::Implicit;
use super::dense::Lu;

/// Iterations: a quadratic law halves the error each time where its slope vanishes at the solution.
const ITERATIONS: usize = 100;

/// Vectors that are reused.
#[derive(Debug, Clone, Default)]
pub(crate) struct Memory {
    outputs: Vec<f64>,
    trial: Vec<f64>,
    step: Vec<f64>,
    from: Vec<f64>,
    lu: Lu,
}

/// No solution was found; the unknowns are not-a-number.
#[derive(Debug)]
pub(crate) struct Unsolved;

/// Solves to rounding from what the point holds, damped by natural monotonicity (Deuflhard 2004, section 3.3).
pub(crate) fn solve(
    implicit: &Implicit,
    work: &mut Workspace,
    point: &mut [f64],
    memory: &mut Memory,
) -> Result<(), Unsolved> {
    let size = implicit.unknowns.len();
    let Memory {
        outputs,
        trial,
        step,
        from,
        lu,
    } = memory;
    outputs.resize(size + implicit.entries.len(), 0.0);
    trial.resize(size, 0.0);
    step.resize(size, 0.0);
    from.resize(size, 0.0);
    for unknown in &implicit.unknowns {
        if let Some(entry) = point.get_mut(*unknown)
            && !entry.is_finite()
        {
            *entry = 0.0;
        }
    }
    for _ in 0..ITERATIONS {
        implicit.program.evaluate(1, point, work, outputs);
        let (residual, entries) = outputs.split_at(size);
        lu.reset(size);
        for (place, value) in implicit.entries.iter().zip(entries) {
            lu.set(*place, *value);
        }
        // At rounding of the terms that the residual is made of nothing is left to gain.
        let done = (0..size).all(|i| {
            let terms: f64 = (0..size)
                .map(|j| {
                    let w = implicit.unknowns.get(j).and_then(|place| point.get(*place));
                    (lu.get(i * size + j) * w.copied().unwrap_or(0.0)).abs()
                })
                .sum();
            residual.get(i).is_some_and(|r| r.abs() <= 2e-16 * terms)
        });
        if done {
            return Ok(());
        }
        let regular = lu.factor();
        for (target, value) in step.iter_mut().zip(residual) {
            *target = -value;
        }
        if regular {
            lu.solve(step);
        }
        if !regular || step.iter().any(|value| !value.is_finite()) {
            // Where a slope vanishes, away from it against the residual.
            for (unknown, r) in implicit.unknowns.iter().zip(residual) {
                if let Some(entry) = point.get_mut(*unknown) {
                    let away = (1e-3 * entry.abs()).max(1e-6);
                    *entry -= away.copysign(*r);
                }
            }
            continue;
        }
        let mut size_of_step: f64 = 0.0;
        for (place, (value, start)) in implicit
            .unknowns
            .iter()
            .zip(step.iter().zip(from.iter_mut()))
        {
            *start = point.get(*place).copied().unwrap_or(0.0);
            let relative = value.abs() / start.abs().max(1e-300);
            size_of_step = size_of_step.max(relative);
        }
        let norm = |vector: &[f64]| vector.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let length = norm(step);
        let mut factor = 1.0;
        loop {
            for (place, (value, start)) in
                implicit.unknowns.iter().zip(step.iter().zip(from.iter()))
            {
                if let Some(entry) = point.get_mut(*place) {
                    *entry = start + factor * value;
                }
            }
            if size_of_step <= 1e-15 || length == 0.0 {
                return Ok(());
            }
            implicit.program.evaluate(0, point, work, outputs);
            trial.copy_from_slice(outputs.get(..size).unwrap_or_default());
            lu.solve(trial);
            let after = norm(trial);
            if after <= (1.0 - factor / 4.0) * length {
                break;
            }
            // Rounding ends the convergence.
            if after.is_finite() && length <= 1e-9 * norm(from) && factor == 1.0 {
                return Ok(());
            }
            factor *= 0.5;
            if factor < 1e-8 {
                return fail(implicit, point);
            }
        }
    }
    // A slope that vanishes at the solution halves the error each time, which is enough by now.
    let near = implicit
        .unknowns
        .iter()
        .zip(step.iter())
        .all(|(place, step)| {
            point
                .get(*place)
                .is_some_and(|value| step.abs() <= 1e-9 * value.abs() || step.abs() <= 1e-20)
        });
    if near {
        return Ok(());
    }
    fail(implicit, point)
}

fn fail(implicit: &Implicit, point: &mut [f64]) -> Result<(), Unsolved> {
    for unknown in &implicit.unknowns {
        if let Some(entry) = point.get_mut(*unknown) {
            *entry = f64::NAN;
        }
    }
    Err(Unsolved)
}
