//! An equilibrium beside a known one.

use crate::dense::{Lu, norm};

/// Newton has converged when a correction is smaller than this, relative to the state.
const CONVERGED: f64 = 1e-12;
const ITERATIONS: usize = 12;

/// The equilibrium 0 = f(x) near a state on the same branch, by Newton's method; none where that does not converge, or only far off (on
/// another branch).
///
/// `linearise(x, rates, jacobian)` gives f and `f_x` (row major, n × n) at a state of n entries.
pub fn equilibrium_beside(
    from: &[f64],
    mut linearise: impl FnMut(&[f64], &mut [f64], &mut [f64]),
) -> Option<Vec<f64>> {
    let n = from.len();
    let (mut step, mut jacobian) = (vec![0.0; n], vec![0.0; n * n]);
    let mut lu = Lu::new();
    let mut x = from.to_vec();
    let mut first = f64::NAN;
    for iteration in 0..ITERATIONS {
        linearise(&x, &mut step, &mut jacobian);
        if !lu.factor(n, &jacobian) {
            return None;
        }
        lu.solve(&mut step);
        let length = norm(&step);
        if !length.is_finite() {
            return None;
        }
        if iteration == 0 {
            first = length;
        } else if length > 2.0 * first {
            return None;
        }
        for (entry, add) in x.iter_mut().zip(&step) {
            *entry -= add;
        }
        if length <= CONVERGED * (norm(&x) + 1e-3) {
            let moved: Vec<f64> = x.iter().zip(from).map(|(a, b)| a - b).collect();
            // On one branch the first step of Newton's method is most of the way.
            return (norm(&moved) <= 2.0 * first + CONVERGED).then_some(x);
        }
    }
    None
}
