//! Branches of equilibria f(x, p) = 0.

mod beside;
mod manifold;
pub use beside::equilibrium_beside;
pub(crate) use manifold::rate;
pub(crate) mod normal;

use manifold::Equilibria;

use crate::branch::{Branch, Equilibrium, Special, assemble};
use crate::path::{Start, follow_both};
use crate::problem::Problem;
use crate::settings::{ContinuationError, Settings};

/// Checks the lengths of a start.
pub(crate) fn check(
    problem: &dyn Problem,
    states: usize,
    parameters: usize,
    free: &[usize],
) -> Result<(), ContinuationError> {
    if states != problem.states() {
        return Err(ContinuationError::Shape {
            what: "states",
            expected: problem.states(),
            found: states,
        });
    }
    if parameters != problem.parameters() {
        return Err(ContinuationError::Shape {
            what: "parameters",
            expected: problem.parameters(),
            found: parameters,
        });
    }
    if let Some(k) = free.iter().find(|k| **k >= parameters) {
        return Err(ContinuationError::Shape {
            what: "parameters",
            expected: parameters,
            found: k + 1,
        });
    }
    Ok(())
}

/// The branch of equilibria through the one near `state`, in the parameter of index `free`.
///
/// Special points: folds (normal form a = ½ ⟨p, B(q, q)⟩, |q| = 1, ⟨p, q⟩ = 1), Hopf points (first Lyapunov coefficient
/// `l_1` = ½ Re⟨p, C(q, q, q̄) - 2 B(q, A⁻¹ B(q, q̄)) + B(q̄, (2iω - A)⁻¹ B(q, q))⟩, ⟨q, q⟩ = ⟨p, q⟩ = 1, Kuznetsov 2004, eq. 3.20
/// without its division by ω), branch points, and Hopf-Hopf or zero-Hopf points where two meet.
///
/// # Errors
///
/// Where lengths do not fit or no equilibrium is found near the start. What happens later is the branch's stop.
pub fn equilibria(
    problem: &dyn Problem,
    state: &[f64],
    parameters: &[f64],
    free: usize,
    settings: &Settings,
) -> Result<Branch<Equilibrium>, ContinuationError> {
    check(problem, state.len(), parameters.len(), &[free])?;
    let mut z = state.to_vec();
    z.push(parameters[free]);
    let mut m = Equilibria::new(problem, parameters, free, settings);
    run(&mut m, settings, Start::AtParameter(z))
}

/// The branch that crosses another at a branch point; `side` is 1 or -1 for the two halves.
///
/// # Errors
///
/// Where the point is not one at which branches cross or the corrector does not reach the other branch.
pub fn equilibria_across(
    problem: &dyn Problem,
    point: &Special<Equilibrium>,
    free: usize,
    side: f64,
    settings: &Settings,
) -> Result<Branch<Equilibrium>, ContinuationError> {
    let at = &point.solution;
    check(problem, at.state.len(), at.parameters.len(), &[free])?;
    let mut z = at.state.clone();
    z.push(at.parameters[free]);
    let mut m = Equilibria::new(problem, &at.parameters, free, settings);
    let direction: Vec<f64> = m
        .across(&z, &point.tangent)?
        .iter()
        .map(|d| d * side)
        .collect();
    run(
        &mut m,
        settings,
        Start::Along(z, direction, settings.initial_step),
    )
}

fn run(
    m: &mut Equilibria<'_>,
    settings: &Settings,
    start: Start,
) -> Result<Branch<Equilibrium>, ContinuationError> {
    let (forward, backward) = follow_both(m, settings, start)?;
    let n = m.problem.states();
    let (parameters, free) = (m.parameters.clone(), m.free);
    Ok(assemble(
        m,
        forward,
        backward,
        m.problem.is_approximate(),
        |node| {
            let mut p = parameters.clone();
            p[free] = node.z[n];
            Equilibrium {
                state: node.z[..n].to_vec(),
                parameters: p,
            }
        },
    ))
}
