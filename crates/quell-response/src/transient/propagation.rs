//! Exact propagation of pieces with x' = A x + b.

use super::chebyshev::nodes;
use super::dynamics::Dynamics;
use super::exponential::Ladder;
use super::integrator::{Ending, Piece, Scheme, Step, Visit};

/// Degree in which steps are kept.
const DEGREE: usize = 12;

/// Size of the last Chebyshev coefficients, relative to the state, below which a step's polynomial is the solution.
const RESOLVED: f64 = 1e-13;

/// Ladders of matrix exponentials of the pieces met so far in a run.
#[derive(Debug, Default)]
pub(crate) struct Exact {
    ladders: Vec<Ladder>,
}

impl Exact {
    /// Propagates x' = A x + b from the start of a piece; states at the nodes of a step are exact to rounding, and the step is
    /// taken from the ladder such that the polynomial through them is too.
    pub(crate) fn run(
        &mut self,
        dynamics: &mut dyn Dynamics,
        a: &[f64],
        b: &[f64],
        piece: &Piece<'_>,
        visitor: &mut dyn Visit,
    ) -> Ending {
        let n = piece.x.len();
        let nodes = nodes(DEGREE);
        let known = self.ladders.iter().position(|ladder| ladder.is_of(a, b));
        let index = known.unwrap_or_else(|| {
            self.ladders
                .push(Ladder::new(a, b, piece.longest, &nodes.points));
            self.ladders.len() - 1
        });
        let ladder = &mut self.ladders[index];
        let highest = {
            let mut rung = 0;
            while ladder.step(rung + 1) <= piece.longest * (1.0 + 1e-9) && rung < 1100 {
                rung += 1;
            }
            rung
        };
        let mut rung = ladder.rung_of_size(3.0).min(highest);
        let mut values = vec![0.0; (DEGREE + 1) * n];
        let mut largest = vec![0.0; n];
        let mut x = piece.x.to_vec();
        let (mut t, mut rest) = (piece.t, 0.0);
        let mut hold = 0_u32;
        loop {
            let mut slack;
            let mut failed = false;
            loop {
                let finite = ladder.states(rung, &x, &mut values);
                slack = if finite {
                    resolution(&values, ladder.scale(), rung, &mut largest, n)
                } else {
                    f64::INFINITY
                };
                // The lowest rung has ‖A‖ h ≤ 1 and is resolved by construction.
                if slack <= 1.0 || rung == 0 {
                    break;
                }
                rung -= 1;
                failed = true;
            }
            let length = ladder.step(rung);
            // Compensated: thousands of equal steps would add up one-sided roundings.
            let end = t + (length + rest);
            let carried = (length + rest) - (end - t);
            let reached = end >= piece.limit;
            let step = Step {
                from: t,
                length,
                to: if reached { piece.limit } else { end },
                degree: DEGREE,
                values: &values,
                scheme: Scheme::Exact,
                evaluations: 0,
            };
            if !visitor.visit(dynamics, &step) {
                return Ending::Stopped;
            }
            if reached {
                return Ending::Reached;
            }
            x.copy_from_slice(&values[DEGREE * n..]);
            (t, rest) = (end, carried);
            // Up where the last coefficients are near rounding; not again soon where that was tried in vain.
            hold = if failed { 8 } else { hold.saturating_sub(1) };
            if slack < 0.1 && rung < highest && hold == 0 {
                rung += 1;
            }
        }
    }
}

/// Size of the last coefficients over what is allowed; the largest states so far are remembered.
fn resolution(values: &[f64], scale: &[f64], rung: usize, largest: &mut [f64], n: usize) -> f64 {
    let nodes = nodes(DEGREE);
    for row in values.chunks_exact(n) {
        for (largest, value) in largest.iter_mut().zip(row) {
            *largest = largest.max(value.abs());
        }
    }
    // A state that is much smaller than the others, in balanced units, carries their rounding.
    let floor = 1e-4
        * largest
            .iter()
            .zip(scale)
            .fold(0.0_f64, |floor, (value, unit)| floor.max(value / unit));
    // Every squaring doubles the rounding of the slow modes, differently at every node.
    let allowed = RESOLVED + 2.0 * f64::EPSILON * (rung as f64).exp2();
    let mut worst = 0.0_f64;
    for i in 0..n {
        let tail = nodes.tail(values, n, i);
        let size = largest[i].max(floor * scale[i]);
        if size > 0.0 {
            worst = worst.max((tail[1] + tail[2]) / (allowed * size));
        }
    }
    worst
}
