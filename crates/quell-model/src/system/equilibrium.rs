//! Where a system stays at rest.

use super::assembly::StateKind;
use super::dense::Lu;
use super::pinned;
use super::prepared::Prepared;

/// How the search for an equilibrium ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum EquilibriumStatus {
    /// By Newton's method.
    Converged,
    /// By pseudo-transient continuation, after Newton's method had failed.
    Relaxed,
    /// Not: the state is the best that was found.
    NotFound,
}

/// A state at rest, or the best attempt at one.
#[derive(Debug, Clone, PartialEq)]
pub struct Equilibrium {
    /// The state.
    pub state: Vec<f64>,
    /// Largest of the rates there, each over the size of the terms that cancel in it (Σ |∂f/∂x_j| |x_j| and the rate where
    /// the search began).
    pub residual: f64,
    /// Evaluations of the Jacobian.
    pub iterations: usize,
    /// How the search ended.
    pub status: EquilibriumStatus,
}

/// Iterations of each method.
const NEWTON: usize = 50;
const RELAXATION: usize = 500;
/// A residual as small as this is rounding.
const ENOUGH: f64 = 1e-12;

impl Prepared<'_> {
    /// The equilibrium at a time near a guess: all rates zero, positions with the rates of motion zero.
    ///
    /// Newton's method, damped by natural monotonicity; where it fails, pseudo-transient continuation on positions (a step
    /// of an implicit relaxation, longer the smaller the rest becomes; Kelley and Keyes 1998). Gravity, preload and held
    /// phases count, for all are in the rates. What nothing pushes back (a free body, the integral of an input) stays at
    /// the guess.
    pub fn equilibrium(&mut self, t: f64, guess: &[f64]) -> Equilibrium {
        let kinds: Vec<StateKind> = self.system.states.iter().map(|state| state.kind).collect();
        let n = kinds.len();
        let mut x: Vec<f64> = guess
            .iter()
            .copied()
            .chain(std::iter::repeat(0.0))
            .take(n)
            .collect();
        // The unknown of an equation: a position stands with the acceleration that it causes.
        let pairs: Vec<(usize, usize)> = kinds
            .iter()
            .enumerate()
            .filter_map(|(index, kind)| match kind {
                StateKind::Position { rate } => Some((index, *rate)),
                StateKind::Displacement | StateKind::FirstOrder => Some((index, index)),
                StateKind::Rate => {
                    let of_position = kinds
                        .iter()
                        .any(|kind| matches!(kind, StateKind::Position { rate } if *rate == index));
                    (!of_position).then_some((index, index))
                }
            })
            .collect();
        for kind in &kinds {
            if let StateKind::Position { rate } = kind
                && let Some(entry) = x.get_mut(*rate)
            {
                *entry = 0.0;
            }
        }
        let mut search = Search {
            prepared: self,
            t,
            pairs,
            jacobian: vec![0.0; n * n],
            rates: vec![0.0; n],
            initial: Vec::new(),
            iterations: 0,
            singular: false,
            pins: false,
        };
        search.evaluate(&x);
        search.initial = search.rates.clone();
        let begin = x.clone();
        if search.newton(&mut x) {
            return search.finish(x, EquilibriumStatus::Converged);
        }
        if search.singular {
            let mut pinned = begin.clone();
            search.pins = true;
            if search.newton(&mut pinned) {
                return search.finish(pinned, EquilibriumStatus::Converged);
            }
            search.pins = false;
        }
        let reached = search.quality(&x);
        let mut relaxed = begin;
        let settled = search.relax(&mut relaxed);
        if settled {
            return search.finish(relaxed, EquilibriumStatus::Relaxed);
        }
        if search.quality(&relaxed) < reached || !reached.is_finite() {
            x = relaxed;
        }
        search.finish(x, EquilibriumStatus::NotFound)
    }
}

struct Search<'p, 's> {
    prepared: &'p mut Prepared<'s>,
    t: f64,
    /// (unknown, equation) by state.
    pairs: Vec<(usize, usize)>,
    jacobian: Vec<f64>,
    rates: Vec<f64>,
    initial: Vec<f64>,
    iterations: usize,
    /// Whether a singular matrix was met.
    singular: bool,
    /// Whether unknowns that a singular matrix leaves open stay where they are.
    pins: bool,
}

/// The matrix of a step, ready to solve with.
enum Matrix {
    Factored(Lu),
    /// Row-major entries of a singular one.
    Pinned(Vec<f64>),
}

impl Matrix {
    fn solve(&self, b: &mut Vec<f64>) {
        match self {
            Self::Factored(lu) => lu.solve(b),
            Self::Pinned(entries) => *b = pinned::solve(entries, b),
        }
    }
}

impl Search<'_, '_> {
    fn evaluate(&mut self, x: &[f64]) {
        self.iterations += 1;
        self.prepared
            .jacobian(self.t, x, &mut self.rates, &mut self.jacobian);
    }

    fn residual(&self) -> Vec<f64> {
        self.pairs
            .iter()
            .map(|(_, row)| self.rates.get(*row).copied().unwrap_or(0.0))
            .collect()
    }

    fn entry(&self, row: usize, column: usize) -> f64 {
        let n = self.rates.len();
        self.jacobian.get(row * n + column).copied().unwrap_or(0.0)
    }

    /// The Jacobian of the paired equations, with `shift` on the diagonal taken off.
    fn matrix(&self, shift: f64) -> Lu {
        let mut lu = Lu::default();
        let size = self.pairs.len();
        lu.reset(size);
        for (i, (_, row)) in self.pairs.iter().enumerate() {
            for (j, (column, _)) in self.pairs.iter().enumerate() {
                let diagonal = if i == j { shift } else { 0.0 };
                lu.set(i * size + j, self.entry(*row, *column) - diagonal);
            }
        }
        lu
    }

    /// The Jacobian of the paired equations, row-major.
    fn entries(&self) -> Vec<f64> {
        let columns = self.pairs.iter().map(|(column, _)| *column);
        self.pairs
            .iter()
            .flat_map(|(_, row)| columns.clone().map(|column| self.entry(*row, column)))
            .collect()
    }

    /// Largest rate over the size of what cancels in it, at the last evaluation.
    fn relative(&self, x: &[f64]) -> f64 {
        let mut most: f64 = 0.0;
        for (_, row) in &self.pairs {
            let rate = self.rates.get(*row).copied().unwrap_or(0.0).abs();
            let terms: f64 = x
                .iter()
                .enumerate()
                .map(|(column, value)| (self.entry(*row, column) * value).abs())
                .sum();
            let initial = self.initial.get(*row).copied().unwrap_or(0.0).abs();
            let size = terms.max(initial);
            let ratio = if rate == 0.0 { 0.0 } else { rate / size };
            // Not-a-number is no equilibrium.
            most = if ratio.is_nan() {
                f64::INFINITY
            } else {
                most.max(ratio)
            };
        }
        most
    }

    fn quality(&mut self, x: &[f64]) -> f64 {
        self.evaluate(x);
        self.relative(x)
    }

    fn step(&self, x: &mut [f64], step: &[f64], factor: f64) {
        for ((column, _), value) in self.pairs.iter().zip(step) {
            if let Some(entry) = x.get_mut(*column) {
                *entry += factor * value;
            }
        }
    }

    fn newton(&mut self, x: &mut Vec<f64>) -> bool {
        let norm = |vector: &[f64]| vector.iter().map(|v| v * v).sum::<f64>().sqrt();
        for _ in 0..NEWTON {
            self.evaluate(x);
            let mut lu = self.matrix(0.0);
            let mut step: Vec<f64> = self.residual().iter().map(|r| -r).collect();
            if step.iter().all(|r| *r == 0.0) {
                return true;
            }
            let matrix = if lu.factor() {
                Matrix::Factored(lu)
            } else {
                self.singular = true;
                if self.relative(x) <= ENOUGH {
                    return true;
                }
                if !self.pins {
                    return false;
                }
                Matrix::Pinned(self.entries())
            };
            matrix.solve(&mut step);
            let length = norm(&step);
            if !length.is_finite() {
                return false;
            }
            let mut factor = 1.0;
            loop {
                let mut trial = x.clone();
                self.step(&mut trial, &step, factor);
                self.evaluate(&trial);
                let mut after = self.residual();
                matrix.solve(&mut after);
                let reached = norm(&after);
                if reached <= (1.0 - factor / 4.0) * length {
                    *x = trial;
                    break;
                }
                // At rounding no step makes it better.
                if factor == 1.0 && self.relative(&trial) <= ENOUGH {
                    *x = trial;
                    return true;
                }
                factor *= 0.5;
                if factor < 1e-6 {
                    return false;
                }
            }
            if factor == 1.0 && length <= 1e-14 * norm(x) {
                // A singular matrix may leave equations out that contradict the others.
                return matches!(matrix, Matrix::Factored(_)) || self.relative(x) <= 1e3 * ENOUGH;
            }
        }
        self.quality(x) <= ENOUGH
    }

    /// Implicit Euler steps of y' = f(y) on the paired equations, with steps in inverse proportion to the rest.
    fn relax(&mut self, x: &mut Vec<f64>) -> bool {
        let norm = |vector: &[f64]| vector.iter().map(|v| v * v).sum::<f64>().sqrt();
        self.evaluate(x);
        let mut rest = norm(&self.residual());
        let scale = self
            .jacobian
            .iter()
            .fold(0.0_f64, |most, entry| most.max(entry.abs()));
        let mut rate = scale.max(f64::MIN_POSITIVE);
        for _ in 0..RELAXATION {
            let mut lu = self.matrix(rate);
            let mut step: Vec<f64> = self.residual().iter().map(|r| -r).collect();
            if !lu.factor() {
                rate *= 2.0;
                continue;
            }
            lu.solve(&mut step);
            let mut trial = x.clone();
            self.step(&mut trial, &step, 1.0);
            self.evaluate(&trial);
            let after = norm(&self.residual());
            if !after.is_finite() {
                rate *= 4.0;
                if rate > 1e12 * scale {
                    return false;
                }
                self.evaluate(x);
                continue;
            }
            *x = trial;
            if self.relative(x) <= 1e-6 {
                return self.newton(x);
            }
            rate *= (after / rest).clamp(0.1, 2.0);
            rest = after;
        }
        false
    }

    fn finish(&mut self, state: Vec<f64>, status: EquilibriumStatus) -> Equilibrium {
        let residual = self.quality(&state);
        Equilibrium {
            state,
            residual,
            iterations: self.iterations,
            status,
        }
    }
}
