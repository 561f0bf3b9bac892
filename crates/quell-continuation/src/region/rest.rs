//! The equilibrium of a region, followed over its rectangle.

use crate::band::Linearisation;
use crate::equilibrium::equilibrium_beside;
use crate::problem::Problem;

/// Longest and shortest step in the unit square.
const STRIDE: f64 = 1.0 / 32.0;
const SHORTEST: f64 = 1e-7;
/// Equilibria at points so far apart are kept to start from.
const APART: f64 = 1.0 / 16.0;

/// Follows an equilibrium from where it is known to where it is asked for, on a straight line.
pub(super) struct Rest<'p> {
    problem: &'p dyn Problem,
    known: Vec<([f64; 2], Vec<f64>)>,
    /// 1, or -1 where the matrix is wanted with the opposite sign: valleys of the growth rate are ridges then.
    pub(super) sign: f64,
}

impl<'p> Rest<'p> {
    pub(super) fn new(problem: &'p dyn Problem, at: [f64; 2], state: &[f64]) -> Self {
        Self {
            problem,
            known: vec![(at, state.to_vec())],
            sign: 1.0,
        }
    }

    /// The equilibrium at a point; none where it ends on the way.
    pub(super) fn equilibrium(&mut self, to: [f64; 2]) -> Option<Vec<f64>> {
        let first = &self.known[0].1;
        let mut rates = vec![0.0; first.len()];
        self.problem.value(0.0, first, &to, &mut rates);
        if rates.iter().all(|rate| *rate == 0.0) {
            return Some(first.clone());
        }
        let distance = |at: &[f64; 2]| (at[0] - to[0]).hypot(at[1] - to[1]);
        let nearest = self
            .known
            .iter()
            .min_by(|a, b| distance(&a.0).total_cmp(&distance(&b.0)));
        let (from, mut x) = nearest.cloned()?;
        let length = distance(&from);
        let (mut done, mut stride) = (0.0, STRIDE);
        while done < length || length == 0.0 {
            let next = if done + stride >= length {
                length
            } else {
                done + stride
            };
            let part = if length > 0.0 { next / length } else { 1.0 };
            let at = if part >= 1.0 {
                to
            } else {
                [0, 1].map(|k| from[k] + part * (to[k] - from[k]))
            };
            let problem = self.problem;
            let found = equilibrium_beside(&x, |x, rates, jacobian| {
                problem.value(0.0, x, &at, rates);
                problem.jacobian(0.0, x, &at, jacobian);
            });
            let Some(found) = found else {
                stride *= 0.25;
                if stride < SHORTEST {
                    return None;
                }
                continue;
            };
            x = found;
            done = next;
            stride = (2.0 * stride).min(STRIDE);
            if part >= 1.0 {
                break;
            }
        }
        let apart = |(at, _): &([f64; 2], Vec<f64>)| distance(at) > APART;
        if self.known.iter().all(apart) {
            self.known.push((to, x.clone()));
        }
        Some(x)
    }
}

impl Linearisation for Rest<'_> {
    fn states(&self) -> usize {
        self.problem.states()
    }

    /// Columns are values of the second parameter, along which the first one runs.
    fn matrix(&mut self, p: f64, q: f64, out: &mut [f64]) -> bool {
        let Some(x) = self.equilibrium([q, p]) else {
            return false;
        };
        self.problem.jacobian(0.0, &x, &[q, p], out);
        for entry in out.iter_mut() {
            *entry *= self.sign;
        }
        out.iter().all(|entry| entry.is_finite())
    }
}
