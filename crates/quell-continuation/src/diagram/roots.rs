//! Equilibria at given parameters by deflated Newton from many starts.

use super::DiagramSettings;
use crate::dense::{Lu, norm};
use crate::problem::Problem;

/// Point k of an additive recurrence in the box (fractional parts of k √prime).
pub(super) fn point(states: &[(f64, f64)], k: usize) -> Vec<f64> {
    let primes = [
        2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0, 23.0, 29.0, 31.0, 37.0_f64,
    ];
    states
        .iter()
        .enumerate()
        .map(|(i, (low, high))| {
            let root = (primes[i % primes.len()] + (i / primes.len()) as f64 * 0.37).sqrt();
            low + (high - low) * (k as f64 * root).fract()
        })
        .collect()
}

/// Parts of the box in which a third as many starts look for equilibria that lie close together on its scale.
const SHRUNK: [f64; 3] = [0.1, 0.01, 0.001];

/// Equilibria at given parameters, in the order in which they are found.
pub(super) fn roots(problem: &dyn Problem, p: &[f64], settings: &DiagramSettings) -> Vec<Vec<f64>> {
    let n = problem.states();
    let size = settings
        .states
        .iter()
        .map(|(a, b)| (b - a).powi(2))
        .sum::<f64>()
        .sqrt()
        .max(1e-12);
    let mut found: Vec<Vec<f64>> = Vec::new();
    let (mut f, mut jacobian) = (vec![0.0; n], vec![0.0; n * n]);
    let mut lu = Lu::new();
    // The middle of the box first; then the whole box, then parts of it about its middle.
    let starts = std::iter::once((0, 0.0))
        .chain((1..=settings.starts).map(|k| (k, 1.0)))
        .chain(
            SHRUNK
                .iter()
                .flat_map(|part| (1..=settings.starts.div_ceil(3)).map(move |k| (k, *part))),
        );
    for (k, part) in starts {
        let mut x = point(&settings.states, k);
        for (x, (low, high)) in x.iter_mut().zip(&settings.states) {
            let middle = 0.5 * (low + high);
            *x = middle + part * (*x - middle);
        }
        for _ in 0..60 {
            problem.value(0.0, &x, p, &mut f);
            problem.jacobian(0.0, &x, p, &mut jacobian);
            if !lu.factor(n, &jacobian) || f.iter().any(|f| !f.is_finite()) {
                break;
            }
            let mut step: Vec<f64> = f.iter().map(|f| -f).collect();
            lu.solve(&mut step);
            // Deflation multiplies the step by 1 / (1 - ∇η·step / η), η = Π (1 + (size / |x - r|)²).
            let mut slope = 0.0;
            for r in &found {
                let d: Vec<f64> = x.iter().zip(r).map(|(x, r)| x - r).collect();
                let square = crate::dense::dot(&d, &d).max(1e-300);
                let eta = 1.0 + 1e-4 * size * size / square;
                slope -= 2.0 * 1e-4 * size * size / (square * square)
                    * crate::dense::dot(&d, &step)
                    / eta;
            }
            let deflated = 1.0 / (1.0 - slope);
            let raw = norm(&step);
            let mut factor = if deflated.is_finite() { deflated } else { 1.0 };
            if raw * factor.abs() > 0.3 * size {
                factor *= 0.3 * size / (raw * factor.abs());
            }
            crate::dense::axpy(factor, &step, &mut x);
            if raw < 1e-10 * (size + norm(&x)) {
                break;
            }
        }
        problem.value(0.0, &x, p, &mut f);
        problem.jacobian(0.0, &x, p, &mut jacobian);
        if f.iter().any(|f| !f.is_finite()) || !lu.factor(n, &jacobian) {
            continue;
        }
        let mut step = f.clone();
        lu.solve(&mut step);
        let converged = norm(&step) < 1e-8 * (size + norm(&x));
        let new = found.iter().all(|r| {
            let d: Vec<f64> = x.iter().zip(r).map(|(x, r)| x - r).collect();
            norm(&d) > 1e-5 * size
        });
        let inside = x
            .iter()
            .zip(&settings.states)
            .all(|(x, (a, b))| *x >= a - 0.5 * (b - a) && *x <= b + 0.5 * (b - a));
        if converged && new && inside {
            found.push(x);
        }
    }
    found
}
