//! What a point costs, counted.

use std::sync::atomic::{AtomicUsize, Ordering};

use quell_continuation::{
    Equilibrium, Kind, MeshSettings, Problem, Settings, Special, cycles_from_hopf, equilibria,
};

use crate::support::Exact;
use crate::support::models::Chain;

/// A problem that counts where it is evaluated.
struct Counting<P> {
    problem: P,
    values: AtomicUsize,
    linearisations: AtomicUsize,
}

impl<P: Problem> Problem for Counting<P> {
    fn states(&self) -> usize {
        self.problem.states()
    }
    fn parameters(&self) -> usize {
        self.problem.parameters()
    }
    fn value(&self, t: f64, x: &[f64], p: &[f64], out: &mut [f64]) {
        self.problem.value(t, x, p, out);
    }
    fn jacobian(&self, t: f64, x: &[f64], p: &[f64], out: &mut [f64]) {
        self.problem.jacobian(t, x, p, out);
    }
    fn parameter_derivative(&self, t: f64, x: &[f64], p: &[f64], k: usize, out: &mut [f64]) {
        self.problem.parameter_derivative(t, x, p, k, out);
    }
    fn values(&self, t: &[f64], x: &[f64], p: &[f64], out: &mut [f64]) {
        self.values.fetch_add(t.len(), Ordering::Relaxed);
        self.problem.values(t, x, p, out);
    }
    fn linearisations(
        &self,
        t: &[f64],
        x: &[f64],
        p: &[f64],
        values: &mut [f64],
        jacobians: &mut [f64],
    ) {
        self.linearisations.fetch_add(t.len(), Ordering::Relaxed);
        self.problem.linearisations(t, x, p, values, jacobians);
    }
}

fn birth<P: Problem>(problem: &P) -> Special<Equilibrium> {
    let n = problem.states();
    let rest = equilibria(
        problem,
        &vec![0.0; n],
        &[-0.5],
        0,
        &Settings::new(&[(-0.5, 0.5)]),
    );
    rest.unwrap().of(Kind::Hopf)[0].clone()
}

/// Values and linearisations for each point of a branch and each of its Gauss points.
fn work<const N: usize>(intervals: usize) -> [f64; 2] {
    let problem = Counting {
        problem: Exact::<_, N>(Chain::<N>),
        values: AtomicUsize::new(0),
        linearisations: AtomicUsize::new(0),
    };
    let start = birth(&problem);
    let mut s = Settings::new(&[(-0.5, 1.0)]);
    s.mesh = MeshSettings::fixed(intervals, 4);
    s.maximum_points = 15;
    let branch = cycles_from_hopf(&problem, &start, 0, &s).unwrap();
    assert_eq!(branch.points.len(), 15);
    let nodes = (15 * intervals * 4) as f64;
    [&problem.values, &problem.linearisations]
        .map(|count| count.load(Ordering::Relaxed) as f64 / nodes)
}

/// Iterations, linearisations and factorisations for each point depend neither on the number of intervals nor on that of states: what
/// a linearisation costs is then all that grows, and that is one elimination of (m + 1) n columns for each interval and one of 3 n
/// between them (in `condense.rs`, no array is longer than intervals times states squared).
#[test]
fn iterations_do_not_grow_with_mesh_or_states() {
    let few = work::<8>(20);
    for more in [
        work::<8>(40),
        work::<8>(80),
        work::<8>(160),
        work::<20>(20),
        work::<40>(20),
    ] {
        for (few, more) in few.iter().zip(more) {
            // Points that are located on the way differ; eight times the intervals, or five times the states, would not be twice.
            assert!(more < 2.0 * few, "{few} {more}");
        }
    }
    let [values, linearisations] = few;
    assert!(values < 8.0 && linearisations < 2.5, "{few:?}");
}
