//! diffsol's integrators behind [`run`]; nothing else knows that library.
//!
//! Time is scaled to the length of the run, because the library's least step and first step are absolute numbers.

use std::cell::{Cell, RefCell};

use diffsol::{
    DiffsolError, NalgebraLU, NalgebraMat, OdeBuilder, OdeEquations, OdeSolverMethod,
    OdeSolverStopReason, Vector,
};

use super::chebyshev::nodes;
use super::dynamics::Dynamics;
use super::integrator::{Ending, Piece, Scheme, Step, Visit};

type M = NalgebraMat<f64>;

/// Degree in which steps are kept: the dense output of Tsit45 has degree 4, that of backward differentiation at most 5.
const DEGREE: usize = 6;

/// The system as the library's closures see it.
struct Shared<'d> {
    dynamics: RefCell<&'d mut dyn Dynamics>,
    /// Jacobian with the (t, x) that it belongs to: the library asks for its columns one by one.
    jacobian: RefCell<Jacobian>,
    evaluations: Cell<usize>,
    from: f64,
    scale: f64,
}

#[derive(Default)]
struct Jacobian {
    t: f64,
    x: Vec<f64>,
    matrix: Vec<f64>,
}

impl Shared<'_> {
    fn rates(&self, s: f64, x: &[f64], rates: &mut [f64]) {
        self.evaluations.set(self.evaluations.get() + 1);
        self.dynamics
            .borrow_mut()
            .rates(self.from + s * self.scale, x, rates);
        for rate in rates {
            *rate *= self.scale;
        }
    }

    fn times(&self, s: f64, x: &[f64], v: &[f64], out: &mut [f64]) {
        let n = x.len();
        let mut kept = self.jacobian.borrow_mut();
        if kept.t != s || kept.x != x {
            kept.t = s;
            kept.x.clear();
            kept.x.extend_from_slice(x);
            kept.matrix.resize(n * n, 0.0);
            let mut dynamics = self.dynamics.borrow_mut();
            dynamics.jacobian(self.from + s * self.scale, x, &mut kept.matrix);
        }
        for (out, row) in out.iter_mut().zip(kept.matrix.chunks_exact(n)) {
            let sum: f64 = row.iter().zip(v).map(|(a, b)| a * b).sum();
            *out = self.scale * sum;
        }
    }
}

/// Integrates one smooth piece, handing over every accepted step.
pub(crate) fn run(
    dynamics: &mut dyn Dynamics,
    piece: &Piece<'_>,
    scheme: Scheme,
    visitor: &mut dyn Visit,
) -> Ending {
    let shared = Shared {
        dynamics: RefCell::new(dynamics),
        jacobian: RefCell::default(),
        evaluations: Cell::new(0),
        from: piece.t,
        scale: piece.scale,
    };
    match attempt(&shared, piece, scheme, visitor) {
        Ok(ending) => ending,
        Err((t, error)) => Ending::Failed {
            t,
            why: error.to_string(),
        },
    }
}

fn attempt(
    shared: &Shared<'_>,
    piece: &Piece<'_>,
    scheme: Scheme,
    visitor: &mut dyn Visit,
) -> Result<Ending, (f64, DiffsolError)> {
    let at_start = |error| (piece.t, error);
    let end = (piece.limit - piece.t) / piece.scale;
    let mut problem = OdeBuilder::<M>::new()
        .t0(0.0)
        .h0(end.min(1.0))
        .rtol(piece.relative)
        .atol(piece.absolute.iter().copied())
        .rhs_implicit(
            |x: &[f64], _p: &[f64], s: f64, rates: &mut [f64]| shared.rates(s, x, rates),
            |x: &[f64], _p: &[f64], s: f64, v: &[f64], out: &mut [f64]| shared.times(s, x, v, out),
        )
        .init(
            |_p: &[f64], _s: f64, x: &mut [f64]| x.copy_from_slice(piece.x),
            piece.x.len(),
        )
        .build()
        .map_err(at_start)?;
    problem.ode_options.min_timestep = 1e-15;
    match scheme {
        Scheme::Bdf => {
            let mut solver = problem.bdf::<NalgebraLU<f64>>().map_err(at_start)?;
            steps(shared, piece, scheme, visitor, &mut solver, end)
        }
        Scheme::Esdirk34 => {
            let mut solver = problem.esdirk34::<NalgebraLU<f64>>().map_err(at_start)?;
            steps(shared, piece, scheme, visitor, &mut solver, end)
        }
        Scheme::Exact | Scheme::Tsit45 => {
            let mut solver = problem.tsit45().map_err(at_start)?;
            steps(shared, piece, Scheme::Tsit45, visitor, &mut solver, end)
        }
    }
}

fn steps<'a, E, S>(
    shared: &Shared<'_>,
    piece: &Piece<'_>,
    scheme: Scheme,
    visitor: &mut dyn Visit,
    solver: &mut S,
    end: f64,
) -> Result<Ending, (f64, DiffsolError)>
where
    E: OdeEquations<T = f64, V = diffsol::NalgebraVec<f64>> + 'a,
    S: OdeSolverMethod<'a, E>,
{
    let n = piece.x.len();
    let nodes = nodes(DEGREE);
    let time = |s: f64| {
        if s >= end {
            piece.limit
        } else {
            piece.t + s * piece.scale
        }
    };
    solver
        .set_stop_time(end)
        .map_err(|error| (piece.t, error))?;
    let mut values = vec![0.0; (DEGREE + 1) * n];
    values[DEGREE * n..].copy_from_slice(piece.x);
    let mut inside = solver.state().y.clone();
    let mut last = 0.0;
    loop {
        let reached = match solver.step().map_err(|error| (time(last), error))? {
            OdeSolverStopReason::TstopReached => true,
            OdeSolverStopReason::InternalTimestep | OdeSolverStopReason::RootFound(..) => false,
        };
        let now = if reached { end } else { solver.state().t };
        // The end of the last step is the start of this one.
        let (head, tail) = values.split_at_mut(DEGREE * n);
        head[..n].copy_from_slice(tail);
        for (&point, row) in nodes.points[1..DEGREE]
            .iter()
            .zip(head[n..].chunks_exact_mut(n))
        {
            solver
                .interpolate_inplace(last + point * (now - last), &mut inside)
                .map_err(|error| (time(last), error))?;
            copy(&inside, row);
        }
        copy(solver.state().y, tail);
        let step = Step {
            from: time(last),
            length: time(now) - time(last),
            to: time(now),
            degree: DEGREE,
            values: &values,
            scheme,
            evaluations: shared.evaluations.replace(0),
        };
        let more = visitor.visit(&mut **shared.dynamics.borrow_mut(), &step);
        if !more {
            return Ok(Ending::Stopped);
        }
        if reached {
            return Ok(Ending::Reached);
        }
        last = now;
    }
}

fn copy(from: &diffsol::NalgebraVec<f64>, to: &mut [f64]) {
    for (i, to) in to.iter_mut().enumerate() {
        *to = from.get_index(i);
    }
}
