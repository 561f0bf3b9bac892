//! Mirror images: changes of sign of some states under which the equations stay as they are.

use super::roots::point;
use crate::branch::{Equilibrium, Special};
use crate::dense::norm;
use crate::problem::Problem;

/// Up to so many states all sets of them are tried; beyond, all states together alone.
const TRIED: usize = 12;
/// So many points are compared.
const POINTS: usize = 4;
/// Most mirrors that are kept: of modes that do not know of each other there are many.
const MOST: usize = 8;

/// Mirrors of a problem: S with f(S x) = S f(x), S a diagonal of signs. A pitchfork breaks one, and has two branches that are images of
/// each other (x → -x of most structures; x, y → -x, -y of the Lorenz equations).
#[derive(Clone, Debug, Default)]
pub(crate) struct Mirrors(Vec<Vec<f64>>);

impl Mirrors {
    /// Those of a problem, judged at a few points of a box; all states together first.
    pub(super) fn of(problem: &dyn Problem, parameters: &[f64], states: &[(f64, f64)]) -> Self {
        let n = problem.states();
        let points: Vec<(Vec<f64>, Vec<f64>)> = (1..=POINTS)
            .map(|k| {
                let x = point(states, k);
                let mut f = vec![0.0; n];
                problem.value(0.0, &x, parameters, &mut f);
                (x, f)
            })
            .collect();
        let mut image = vec![0.0; n];
        let mut is = |signs: &[f64]| {
            points.iter().all(|(x, f)| {
                let mirrored = seen(signs, x);
                problem.value(0.0, &mirrored, parameters, &mut image);
                let size = norm(f).max(norm(&image));
                let pairs = image.iter().zip(f).zip(signs);
                size > 0.0 && { pairs }
                    .all(|((image, f), sign)| (image - sign * f).abs() <= 1e-12 * size)
            })
        };
        let mut found = Vec::new();
        if n == 0 {
            return Self(found);
        }
        let all = vec![-1.0; n];
        if is(&all) {
            found.push(all);
        }
        if n <= TRIED {
            for set in 1..(1_usize << n) - 1 {
                let signs: Vec<f64> = (0..n)
                    .map(|state| if set >> state & 1 == 1 { -1.0 } else { 1.0 })
                    .collect();
                if found.len() < MOST && is(&signs) {
                    found.push(signs);
                }
            }
        }
        Self(found)
    }

    /// Whether there are any.
    pub(crate) const fn any(&self) -> bool {
        !self.0.is_empty()
    }

    /// A state and its images.
    pub(crate) fn images(&self, x: &[f64]) -> impl Iterator<Item = Vec<f64>> {
        std::iter::once(x.to_vec()).chain(self.0.iter().map(move |signs| seen(signs, x)))
    }

    /// Ranges of states, and those of their images.
    pub(crate) fn ranges(&self, of: &[(f64, f64)]) -> impl Iterator<Item = Vec<(f64, f64)>> {
        let image = move |signs: &Vec<f64>| {
            let pairs = signs.iter().zip(of);
            pairs
                .map(|(sign, (low, high))| {
                    if *sign < 0.0 {
                        (-high, -low)
                    } else {
                        (*low, *high)
                    }
                })
                .collect()
        };
        std::iter::once(of.to_vec()).chain(self.0.iter().map(image))
    }

    /// Whether two special equilibria are images of each other and not the same.
    pub(super) fn images_of_each_other(
        &self,
        a: &Special<Equilibrium>,
        b: &Special<Equilibrium>,
    ) -> bool {
        let near = |p: &[f64], q: &[f64]| {
            let gap: Vec<f64> = p.iter().zip(q).map(|(p, q)| p - q).collect();
            norm(&gap) <= 1e-6 * (norm(p) + norm(q))
        };
        let (x, y) = (&a.solution, &b.solution);
        let moved = |signs: &Vec<f64>| {
            let image = seen(signs, &y.state);
            near(&x.state, &image) && !near(&image, &y.state)
        };
        near(&x.parameters, &y.parameters) && self.0.iter().any(moved)
    }
}

fn seen(signs: &[f64], x: &[f64]) -> Vec<f64> {
    signs.iter().zip(x).map(|(sign, x)| sign * x).collect()
}
