//! Branches of periodic orbits of autonomous and forced problems.

pub(crate) mod bordered;
pub(crate) mod collocation;
mod condense;
mod cycle;
pub(crate) mod floquet;
pub(crate) mod frame;
mod kernel;
pub(crate) mod manifold;
mod mesh;
pub(crate) mod normal;
mod rule;

use num_complex::Complex64;

pub use cycle::Orbit;

use crate::branch::{Branch, Equilibrium, Special, assemble};
use crate::dense::eigenvector;
use crate::equilibrium::check;
use crate::kind::Kind;
use crate::path::{Manifold, Start, follow_both, second_direction};
use crate::problem::Problem;
use crate::settings::{ContinuationError, Settings};
use collocation::Collocation;
use manifold::Cycles;

/// The branch of cycles born at a Hopf point, in the parameter of index `free`.
///
/// # Errors
///
/// Where the point is no Hopf point or no small cycle is found.
pub fn cycles_from_hopf(
    problem: &dyn Problem,
    point: &Special<Equilibrium>,
    free: usize,
    settings: &Settings,
) -> Result<Branch<Orbit>, ContinuationError> {
    let omega = point.omega.ok_or(ContinuationError::Start(
        "the point carries no frequency: it is no Hopf point",
    ))?;
    cycles_from_pair(problem, &point.solution, omega, free, settings)
}

/// The branch of cycles born where `f_x` has the eigenvalues ±iω: for the second pair of a Hopf-Hopf point, say.
///
/// # Errors
///
/// As [`cycles_from_hopf`].
pub fn cycles_from_pair(
    problem: &dyn Problem,
    at: &Equilibrium,
    omega: f64,
    free: usize,
    settings: &Settings,
) -> Result<Branch<Orbit>, ContinuationError> {
    check(problem, at.state.len(), at.parameters.len(), &[free])?;
    let (c, z, direction) = small_cycle(problem, at, omega, &[free], settings);
    let mut m = Cycles::new(c, settings);
    run(
        &mut m,
        settings,
        Start::Along(z, direction, settings.initial_step),
    )
}

/// The equilibrium as a cycle of no amplitude, and the direction of its growth.
pub(crate) fn small_cycle<'a>(
    problem: &'a dyn Problem,
    at: &Equilibrium,
    omega: f64,
    free: &[usize],
    settings: &Settings,
) -> (Collocation<'a>, Vec<f64>, Vec<f64>) {
    let n = problem.states();
    let mut jacobian = vec![0.0; n * n];
    problem.jacobian(0.0, &at.state, &at.parameters, &mut jacobian);
    let q = eigenvector(n, &jacobian, Complex64::new(0.0, omega));
    let s = &settings.mesh;
    let mesh = mesh::uniform(s.intervals.max(2));
    let c = Collocation::new(
        problem,
        &at.parameters,
        free,
        1,
        s.degree,
        mesh,
        vec![0.0; n],
    );
    let mut z = Vec::with_capacity(c.nodes() + 2);
    let mut direction = Vec::with_capacity(c.nodes() + 2);
    for i in 0..c.count() {
        for k in 0..c.rule.m {
            let tau = c.mesh[i] + c.rule.nodes[k] * c.step(i);
            let phase = Complex64::from_polar(1.0, std::f64::consts::TAU * tau);
            for j in 0..n {
                z.push(at.state[j]);
                direction.push((q[j] * phase).re);
            }
        }
    }
    z.push(std::f64::consts::TAU / omega);
    direction.push(0.0);
    for f in free {
        z.push(at.parameters[*f]);
        direction.push(0.0);
    }
    (c, z, direction)
}

/// A sampled orbit to start from: times over one period (of the orbit, ascending, the last one period after the first
/// or less), and the states there.
#[derive(Clone, Debug)]
pub struct Samples<'a> {
    /// Times, s. For forced problems in the phase of the forcing.
    pub times: &'a [f64],
    /// States, one slice a time.
    pub states: &'a [Vec<f64>],
    /// Guess of the period, s; ignored for forced problems.
    pub period: f64,
    /// Periods of the forcing in an orbit; 1 for autonomous problems.
    pub periods: usize,
    /// Turns by which each coordinate advances in a period; empty for none.
    pub winding: &'a [i32],
}

/// The branch of orbits through the one near a sampled orbit.
///
/// # Errors
///
/// Where lengths do not fit or Newton does not converge from the samples.
pub fn cycles_from_samples(
    problem: &dyn Problem,
    samples: &Samples<'_>,
    parameters: &[f64],
    free: usize,
    settings: &Settings,
) -> Result<Branch<Orbit>, ContinuationError> {
    let n = problem.states();
    check(
        problem,
        samples.states.first().map_or(0, Vec::len),
        parameters.len(),
        &[free],
    )?;
    if samples.times.len() != samples.states.len() || samples.times.len() < 2 {
        return Err(ContinuationError::Start(
            "a sampled orbit needs as many states as times, and at least two",
        ));
    }
    let s = &settings.mesh;
    let winding: Vec<f64> = (0..n)
        .map(|i| {
            samples
                .winding
                .get(i)
                .map_or(0.0, |k| f64::from(*k) * std::f64::consts::TAU)
        })
        .collect();
    let mesh = mesh::uniform(s.intervals.max(2));
    let c = Collocation::new(
        problem,
        parameters,
        &[free],
        samples.periods.max(1),
        s.degree,
        mesh,
        winding,
    );
    let period = if c.autonomous {
        samples.period
    } else {
        c.periods as f64 * problem.period(parameters).unwrap_or(f64::NAN)
    };
    if !(period > 0.0 && period.is_finite()) {
        return Err(ContinuationError::Start(
            "the period of the start is not positive",
        ));
    }
    let origin = if c.autonomous {
        samples.times[0]
    } else {
        (samples.times[0] / period).floor() * period
    };
    let mut z = Vec::with_capacity(c.nodes() + 2);
    for i in 0..c.count() {
        for k in 0..c.rule.m {
            let tau = c.mesh[i] + c.rule.nodes[k] * c.step(i);
            z.extend(sample(
                problem,
                samples,
                parameters,
                period,
                origin + tau * period,
                &c.winding,
            ));
        }
    }
    if c.autonomous {
        z.push(period);
    }
    z.push(parameters[free]);
    let mut m = Cycles::new(c, settings);
    // The mesh is uniform; adapt it before the branch is followed.
    run_settled(&mut m, settings, z)
}

/// Cubic Hermite value of samples at a time, brought into their span by whole periods.
fn sample(
    problem: &dyn Problem,
    s: &Samples<'_>,
    p: &[f64],
    period: f64,
    t: f64,
    winding: &[f64],
) -> Vec<f64> {
    let n = s.states[0].len();
    let (first, last) = (s.times[0], s.times[s.times.len() - 1]);
    let mut t = t;
    let mut turns = 0.0;
    while t < first {
        t += period;
        turns -= 1.0;
    }
    while t > last && t - period >= first {
        t -= period;
        turns += 1.0;
    }
    let i = s
        .times
        .partition_point(|x| *x <= t)
        .clamp(1, s.times.len() - 1)
        - 1;
    let (a, b) = (&s.states[i], &s.states[i + 1]);
    let h = s.times[i + 1] - s.times[i];
    let x = (t - s.times[i]) / h;
    let (mut fa, mut fb) = (vec![0.0; n], vec![0.0; n]);
    problem.value(s.times[i], a, p, &mut fa);
    problem.value(s.times[i + 1], b, p, &mut fb);
    let (h0, h1) = (
        (1.0 + 2.0 * x) * (1.0 - x) * (1.0 - x),
        x * x * (3.0 - 2.0 * x),
    );
    let (g0, g1) = (x * (1.0 - x) * (1.0 - x) * h, x * x * (x - 1.0) * h);
    (0..n)
        .map(|j| h0 * a[j] + h1 * b[j] + g0 * fa[j] + g1 * fb[j] + turns * winding[j])
        .collect()
}

/// The branch of orbits through a known orbit, in another parameter say.
///
/// # Errors
///
/// Where lengths do not fit or Newton does not converge.
pub fn cycles_from_orbit(
    problem: &dyn Problem,
    orbit: &Orbit,
    free: usize,
    settings: &Settings,
) -> Result<Branch<Orbit>, ContinuationError> {
    let (c, z) = unpack(problem, orbit, &[free])?;
    let mut m = Cycles::new(c, settings);
    run(&mut m, settings, Start::AtParameter(z))
}

/// Collocation and unknowns of an orbit.
pub(crate) fn unpack<'a>(
    problem: &'a dyn Problem,
    orbit: &Orbit,
    free: &[usize],
) -> Result<(Collocation<'a>, Vec<f64>), ContinuationError> {
    check(problem, orbit.dimension, orbit.parameters.len(), free)?;
    let winding = orbit
        .winding
        .iter()
        .map(|w| w * std::f64::consts::TAU)
        .collect();
    let c = Collocation::new(
        problem,
        &orbit.parameters,
        free,
        orbit.periods,
        orbit.degree,
        orbit.mesh.clone(),
        winding,
    );
    if orbit.states.len() != c.nodes() + c.n {
        return Err(ContinuationError::Shape {
            what: "values on the mesh",
            expected: c.nodes() + c.n,
            found: orbit.states.len(),
        });
    }
    let mut z = orbit.states[..c.nodes()].to_vec();
    if c.autonomous {
        z.push(orbit.period);
    }
    for f in free {
        z.push(orbit.parameters[*f]);
    }
    Ok((c, z))
}

/// The branch of orbits of twice the period born at a period doubling.
///
/// # Errors
///
/// Where the point is no period doubling or the corrector does not leave the parent branch.
pub fn cycles_doubled(
    problem: &dyn Problem,
    point: &Special<Orbit>,
    free: usize,
    settings: &Settings,
) -> Result<Branch<Orbit>, ContinuationError> {
    if point.kind != Kind::PeriodDoubling {
        return Err(ContinuationError::Start("the point is no period doubling"));
    }
    let (mut c, z) = unpack(problem, &point.solution, &[free])?;
    c.linearise(&z)?;
    let v = crate::curve::antiperiodic(&c).ok_or(ContinuationError::Singular)?;
    let nodes = c.nodes();
    let mut mesh: Vec<f64> = c.mesh.iter().map(|t| 0.5 * t).collect();
    mesh.extend(c.mesh.iter().skip(1).map(|t| 0.5 + 0.5 * t));
    let mut start = z[..nodes].to_vec();
    for x in z[..nodes].chunks_exact(c.n) {
        start.extend(x.iter().zip(&c.winding).map(|(x, w)| x + w));
    }
    let mut direction = v.clone();
    direction.extend(v.iter().map(|x| -x));
    let winding = c.winding.iter().map(|w| 2.0 * w).collect();
    let double = Collocation::new(
        problem,
        &point.solution.parameters,
        &[free],
        2 * c.periods,
        c.rule.m,
        mesh,
        winding,
    );
    if double.autonomous {
        start.push(2.0 * z[nodes]);
        direction.push(0.0);
    }
    start.push(point.solution.parameters[free]);
    direction.push(0.0);
    let mut m = Cycles::new(double, settings);
    run(
        &mut m,
        settings,
        Start::Along(start, direction, settings.initial_step),
    )
}

/// The branch of orbits that crosses another at a branch point of cycles; `side` is 1 or -1.
///
/// # Errors
///
/// Where the corrector does not reach the other branch.
pub fn cycles_across(
    problem: &dyn Problem,
    point: &Special<Orbit>,
    free: usize,
    side: f64,
    settings: &Settings,
) -> Result<Branch<Orbit>, ContinuationError> {
    let (c, z) = unpack(problem, &point.solution, &[free])?;
    let mut m = Cycles::new(c, settings);
    m.rescale(&z);
    m.accept(&z);
    m.factor(&z)?;
    let row: Vec<f64> = point
        .tangent
        .iter()
        .zip(m.weights())
        .map(|(t, w)| t * w)
        .collect();
    m.border(&row)?;
    let direction: Vec<f64> = second_direction(&mut m, &row, &point.tangent)
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
    m: &mut Cycles<'_>,
    settings: &Settings,
    start: Start,
) -> Result<Branch<Orbit>, ContinuationError> {
    let (forward, backward) = follow_both(m, settings, start)?;
    let approximate = m.c.problem.is_approximate();
    Ok(assemble(m, forward, backward, approximate, |node| {
        m.orbit(node)
    }))
}

/// Corrects at the parameter, adapts the mesh until it suits, then runs.
fn run_settled(
    m: &mut Cycles<'_>,
    settings: &Settings,
    mut z: Vec<f64>,
) -> Result<Branch<Orbit>, ContinuationError> {
    let mut corrector = crate::path::Corrector::new(settings);
    for round in 0..6 {
        m.rescale(&z);
        m.accept(&z);
        let p = m.parameters()[0];
        let mut row = vec![0.0; m.len()];
        row[p] = m.weights()[p].sqrt();
        let target = row[p] * z[p];
        corrector.correct(m, &mut z, &row, target, false)?;
        let before = m.c.mesh.len();
        if settings.mesh.every == 0
            || !m.adapt(&mut z, &mut [], settings.mesh.every)
            || round > 2 && m.c.mesh.len() == before
        {
            break;
        }
    }
    run(m, settings, Start::AtParameter(z))
}
