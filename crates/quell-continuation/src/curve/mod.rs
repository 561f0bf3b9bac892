//! Curves of special points in two parameters.

mod cycle;
mod equilibrium;
mod variation;

pub(crate) use variation::{Mode, ReducedPhase, Variation};

pub use cycle::{CriticalOrbit, cycle_curve, fold_from_generalised_hopf, torus_from_hopf_hopf};
pub use equilibrium::{CriticalEquilibrium, fold_curve, hopf_curve};

use crate::dense::{Lu, norm};
use crate::orbit::collocation::Collocation;

/// The null function with x(1) = -x(0) at the linearisation at hand, of unit length at its start.
pub(crate) fn antiperiodic(c: &Collocation<'_>) -> Option<Vec<f64>> {
    let n = c.n;
    let matrix: Vec<f64> = c
        .condensed
        .a
        .iter()
        .zip(&c.condensed.b)
        .map(|(a, b)| a - b)
        .collect();
    let lu = Lu::of(n, &matrix);
    let mut x: Vec<f64> = (0..n).map(|i| 1.0 + 0.3 * (i as f64).sin()).collect();
    for _ in 0..3 {
        lu.solve(&mut x);
        let size = norm(&x);
        if !(size > 0.0 && size.is_finite()) {
            return None;
        }
        for x in &mut x {
            *x /= size;
        }
    }
    let last: Vec<f64> = x.iter().map(|x| -x).collect();
    let mut out = vec![0.0; c.nodes()];
    c.condensed.backward(&x, &last, None, &mut out);
    Some(out)
}
