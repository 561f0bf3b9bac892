//! A system of equations as a continuation problem.

use std::sync::{Mutex, PoisonError};

use quell_continuation::Problem;
use quell_expression::LANES;
use quell_model::system::{Batch, Prepared, Slopes, System};

use super::forcing::Forcing;

/// What gives a system the values of its parameters.
pub(crate) trait Assignment: Sync {
    /// Number of free parameters.
    fn free(&self) -> usize;
    /// Values of all parameters of the system for values of the free ones.
    fn values(&self, free: &[f64]) -> Vec<f64>;
    /// ∂(parameters of the slopes)/∂(free parameter k): (place in the slopes, derivative).
    fn weights(&self, free: &[f64]) -> Vec<Vec<(usize, f64)>>;
}

/// x' = f(t, x, p) of a compiled system; p are the free parameters alone.
///
/// Nodes are evaluated in batches. Workspaces are kept in a pool, so that many threads may ask at once; what they give does
/// not depend on which of them is taken.
pub(crate) struct Field<'s> {
    system: &'s System,
    slopes: &'s Slopes,
    assignment: &'s dyn Assignment,
    forcing: Option<&'s Forcing>,
    pool: Mutex<Vec<Work<'s>>>,
}

struct Work<'s> {
    free: Vec<f64>,
    weights: Vec<Vec<(usize, f64)>>,
    prepared: Prepared<'s>,
    batch: Batch<'s>,
    times: [f64; LANES],
    states: Vec<[f64; LANES]>,
    rates: Vec<[f64; LANES]>,
    column: Vec<[f64; LANES]>,
    jacobian: Vec<[f64; LANES]>,
    directions: [Vec<[f64; LANES]>; 3],
}

impl<'s> Field<'s> {
    pub(crate) const fn new(
        system: &'s System,
        slopes: &'s Slopes,
        assignment: &'s dyn Assignment,
        forcing: Option<&'s Forcing>,
    ) -> Self {
        Self {
            system,
            slopes,
            assignment,
            forcing,
            pool: Mutex::new(Vec::new()),
        }
    }

    /// Works with values of the free parameters.
    fn with<R>(&self, p: &[f64], act: impl FnOnce(&mut Work<'s>) -> R) -> R {
        let taken = self
            .pool
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .pop();
        let mut work = taken.unwrap_or_else(|| {
            let values = self.assignment.values(p);
            let n = self.system.states().len();
            Work {
                free: p.to_vec(),
                weights: self.assignment.weights(p),
                prepared: self.system.prepare(&values),
                batch: self.system.prepare_batch(&values),
                times: [0.0; LANES],
                states: vec![[0.0; LANES]; n],
                rates: vec![[0.0; LANES]; n],
                column: vec![[0.0; LANES]; n],
                jacobian: vec![[0.0; LANES]; n * n],
                directions: [(); 3].map(|()| vec![[0.0; LANES]; n]),
            }
        });
        let same = work.free.len() == p.len()
            && work
                .free
                .iter()
                .zip(p)
                .all(|(known, value)| known.to_bits() == value.to_bits());
        if !same {
            let values = self.assignment.values(p);
            work.prepared.set_parameters(&values);
            work.batch.set_parameters(&values);
            work.weights = self.assignment.weights(p);
            work.free = p.to_vec();
        }
        if self.system.implicit_unknowns() > 0 {
            work.prepared.forget();
            work.batch.forget();
        }
        let done = act(&mut work);
        self.pool
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .push(work);
        done
    }

    /// The signals of the system at a state.
    pub(super) fn signals(&self, t: f64, x: &[f64], p: &[f64], out: &mut [f64]) {
        self.with(p, |work| work.prepared.signals(t, x, out));
    }

    /// Runs over the nodes in batches; the last one is filled up with its last node.
    fn batches(
        &self,
        t: &[f64],
        x: &[f64],
        p: &[f64],
        mut act: impl FnMut(&mut Work<'s>, usize, usize),
    ) {
        let n = self.system.states().len().max(1);
        self.with(p, |work| {
            let mut first = 0;
            while first < t.len() {
                let count = LANES.min(t.len() - first);
                for lane in 0..LANES {
                    let node = first + lane.min(count - 1);
                    work.times[lane] = t.get(node).copied().unwrap_or(f64::NAN);
                }
                gather(x, n, first, count, &mut work.states);
                act(work, first, count);
                first += count;
            }
        });
    }

    /// The derivative of f along directions, which are given at every node.
    fn along(&self, t: &[f64], x: &[f64], p: &[f64], directions: &[&[f64]], out: &mut [f64]) {
        let n = self.system.states().len();
        self.batches(t, x, p, |work, first, count| {
            for (lanes, nodes) in work.directions.iter_mut().zip(directions) {
                gather(nodes, n, first, count, lanes);
            }
            let [u, v, w] = &work.directions;
            let lanes = [u.as_slice(), v, w];
            let given = lanes.get(..directions.len()).unwrap_or(&lanes);
            work.batch
                .along(&work.times, &work.states, given, &mut work.rates);
            scatter(&work.rates, first, count, out);
        });
    }

    /// A derivative by slopes with weights at every node.
    fn column(
        &self,
        t: &[f64],
        x: &[f64],
        p: &[f64],
        out: &mut [f64],
        which: impl Fn(&Work<'s>) -> Vec<(usize, f64)>,
    ) {
        let n = self.system.states().len();
        out.fill(0.0);
        self.batches(t, x, p, |work, first, count| {
            for (slope, weight) in which(work) {
                let (times, states) = (work.times, &work.states);
                work.batch
                    .slope(self.slopes, slope, &times, states, &mut work.column);
                for (state, values) in work.column.iter().enumerate() {
                    for (lane, value) in values.iter().take(count).enumerate() {
                        if let Some(entry) = out.get_mut((first + lane) * n + state) {
                            *entry += weight * value;
                        }
                    }
                }
            }
        });
    }
}

/// Nodes one after the other into lanes of states; lanes beyond the count hold the last node.
fn gather(nodes: &[f64], n: usize, first: usize, count: usize, lanes: &mut [[f64; LANES]]) {
    for lane in 0..LANES {
        let node = first + lane.min(count.saturating_sub(1));
        let own = nodes.get(node * n..(node + 1) * n).unwrap_or_default();
        for (state, value) in lanes.iter_mut().zip(own) {
            state[lane] = *value;
        }
    }
}

/// Lanes of states into nodes one after the other.
fn scatter(lanes: &[[f64; LANES]], first: usize, count: usize, out: &mut [f64]) {
    let size = lanes.len();
    for (lane, node) in out
        .chunks_exact_mut(size.max(1))
        .skip(first)
        .take(count)
        .enumerate()
    {
        for (entry, values) in node.iter_mut().zip(lanes) {
            if let Some(value) = values.get(lane) {
                *entry = *value;
            }
        }
    }
}

impl Problem for Field<'_> {
    fn states(&self) -> usize {
        self.system.states().len()
    }

    fn parameters(&self) -> usize {
        self.assignment.free()
    }

    fn value(&self, t: f64, x: &[f64], p: &[f64], out: &mut [f64]) {
        self.with(p, |work| work.prepared.rates(t, x, out));
    }

    fn jacobian(&self, t: f64, x: &[f64], p: &[f64], out: &mut [f64]) {
        self.with(p, |work| work.prepared.state_matrix(t, x, out));
    }

    fn parameter_derivative(&self, t: f64, x: &[f64], p: &[f64], k: usize, out: &mut [f64]) {
        self.parameter_derivatives(&[t], x, p, k, out);
    }

    fn time_derivative(&self, t: f64, x: &[f64], p: &[f64], out: &mut [f64]) {
        self.time_derivatives(&[t], x, p, out);
    }

    fn period(&self, p: &[f64]) -> Option<f64> {
        Some(self.forcing?.period(&self.assignment.values(p)))
    }

    fn period_derivative(&self, p: &[f64], k: usize) -> f64 {
        let Some(forcing) = self.forcing else {
            return 0.0;
        };
        let slopes = forcing.slopes(&self.assignment.values(p));
        let weights = self.assignment.weights(p);
        let own = weights.get(k).map_or(&[][..], Vec::as_slice);
        own.iter()
            .filter_map(|(slope, weight)| {
                let parameter = self.slopes.parameters().get(*slope)?;
                Some(weight * slopes.get(*parameter)?)
            })
            .sum()
    }

    fn second(&self, t: f64, x: &[f64], p: &[f64], u: &[f64], v: &[f64], out: &mut [f64]) -> bool {
        self.with(p, |work| take(&work.prepared.along(t, x, &[u, v]), 1, out))
    }

    fn third(
        &self,
        t: f64,
        x: &[f64],
        p: &[f64],
        u: &[f64],
        v: &[f64],
        w: &[f64],
        out: &mut [f64],
    ) -> bool {
        self.with(p, |work| {
            take(&work.prepared.along(t, x, &[u, v, w]), 2, out)
        })
    }

    fn values(&self, t: &[f64], x: &[f64], p: &[f64], out: &mut [f64]) {
        self.batches(t, x, p, |work, first, count| {
            work.batch.rates(&work.times, &work.states, &mut work.rates);
            scatter(&work.rates, first, count, out);
        });
    }

    fn linearisations(
        &self,
        t: &[f64],
        x: &[f64],
        p: &[f64],
        values: &mut [f64],
        jacobians: &mut [f64],
    ) {
        self.batches(t, x, p, |work, first, count| {
            work.batch.jacobian(
                &work.times,
                &work.states,
                &mut work.rates,
                &mut work.jacobian,
            );
            scatter(&work.rates, first, count, values);
            scatter(&work.jacobian, first, count, jacobians);
        });
    }

    fn parameter_derivatives(&self, t: &[f64], x: &[f64], p: &[f64], k: usize, out: &mut [f64]) {
        self.column(t, x, p, out, |work| {
            work.weights.get(k).cloned().unwrap_or_default()
        });
    }

    fn seconds(
        &self,
        t: &[f64],
        x: &[f64],
        p: &[f64],
        u: &[f64],
        v: &[f64],
        out: &mut [f64],
    ) -> bool {
        self.along(t, x, p, &[u, v], out);
        true
    }

    fn thirds(
        &self,
        t: &[f64],
        x: &[f64],
        p: &[f64],
        u: &[f64],
        v: &[f64],
        w: &[f64],
        out: &mut [f64],
    ) -> bool {
        self.along(t, x, p, &[u, v, w], out);
        true
    }

    fn time_derivatives(&self, t: &[f64], x: &[f64], p: &[f64], out: &mut [f64]) {
        let time = self.slopes.parameters().len();
        self.column(t, x, p, out, |_| vec![(time, 1.0)]);
    }
}

/// Level `level` of derivatives along directions.
fn take(levels: &[Vec<f64>], level: usize, out: &mut [f64]) -> bool {
    let Some(found) = levels.get(level) else {
        return false;
    };
    out.copy_from_slice(found);
    true
}
