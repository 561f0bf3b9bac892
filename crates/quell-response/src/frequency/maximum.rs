//! Local maxima of |H| over the band: those of the grid, those hidden between two of its points, and their refinement.

use num_complex::Complex64;

use super::evaluation::finite_square;
use super::{Plan, Scratch};
use crate::peak::{minimise, vertex};

/// The largest value of |H| over a band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peak {
    /// max |H|, in the unit of the output over that of the input; infinite at an undamped resonance.
    pub value: f64,
    /// Where, rad/s.
    pub omega: f64,
}

/// A bracket of a local maximum, samples (ω, 1/|H|²), before it is refined.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    /// φ = 1/|H|² that may be reached.
    promise: f64,
    left: (f64, f64),
    middle: (f64, f64),
    right: (f64, f64),
    /// An edge of the band: nothing to refine.
    edge: bool,
}

impl Plan {
    /// max |H| over the band: the grid, then the largest local maxima refined with true evaluations.
    ///
    /// Not-a-number where `values` has a wrong length. Resonances between two grid points are found by the turn of the
    /// characteristic factor's phase; two of them in one gap can still be missed, and [`crate::certify`] tells.
    pub fn peak(&self, values: &[f64], scratch: &mut Scratch) -> Peak {
        if values.len() != self.assembly.elements {
            return Peak {
                value: f64::NAN,
                omega: f64::NAN,
            };
        }
        self.refine(values, 0.0, scratch)
    }

    /// Refines all candidates that may come within `margin` of the largest; leaves them in `scratch.refined`.
    pub(super) fn refine(&self, values: &[f64], margin: f64, scratch: &mut Scratch) -> Peak {
        self.sweep(values, scratch);
        self.collect(values, scratch);
        let candidates = std::mem::take(&mut scratch.candidates);
        let mut refined = std::mem::take(&mut scratch.refined);
        refined.clear();
        let mut best = (self.omegas[0], f64::INFINITY);
        for candidate in &candidates {
            if candidate.middle.1 < best.1 {
                best = candidate.middle;
            }
        }
        let keep = 1.0 / ((1.0 - margin.clamp(0.0, 1.0)).powi(2)).max(f64::MIN_POSITIVE);
        let mut count = 0;
        for candidate in &candidates {
            if candidate.promise > best.1 * keep {
                continue;
            }
            let sample = if candidate.edge || count >= self.settings.peaks {
                candidate.middle
            } else {
                count += 1;
                minimise(
                    candidate.left,
                    candidate.middle,
                    candidate.right,
                    self.settings.tolerance,
                    |omega| 1.0 / finite_square(self.evaluate(values, omega, scratch).norm_sqr()),
                )
            };
            if sample.1 < best.1 {
                best = sample;
            }
            refined.push(Peak {
                value: sample.1.sqrt().recip(),
                omega: sample.0,
            });
        }
        scratch.candidates = candidates;
        scratch.refined = refined;
        Peak {
            value: best.1.sqrt().recip(),
            omega: best.0,
        }
    }

    /// Collects local maxima of the grid and resonances that hide between two points.
    fn collect(&self, values: &[f64], scratch: &mut Scratch) {
        let count = self.omegas.len();
        let mut candidates = std::mem::take(&mut scratch.candidates);
        candidates.clear();
        let last = count - 1;
        let sample = |square: &[f64], i: usize| (self.omegas[i], 1.0 / square[i]);
        let mut hidden = [usize::MAX; 16];
        let mut found = 0;
        // A lightly damped pole turns the phase of the characteristic factor by nearly half a turn between two points.
        let [re, im] = &scratch.factor;
        for i in 0..last {
            if re[i] * re[i + 1] + im[i] * im[i + 1] < 0.0 && found < hidden.len() {
                hidden[found] = i;
                found += 1;
            }
        }
        let mut covered = [usize::MAX; 32];
        for (place, &i) in hidden[..found].iter().enumerate() {
            if let Some(candidate) = self.hidden_peak(values, i, scratch) {
                candidates.push(candidate);
                covered[2 * place] = i;
                covered[2 * place + 1] = i + 1;
            }
        }
        let square = &scratch.square;
        for i in 0..count {
            let rises = i == 0 || square[i] >= square[i - 1];
            let falls = i == last || square[i] > square[i + 1];
            if !(rises && falls) || covered.contains(&i) {
                continue;
            }
            let middle = sample(square, i);
            if i == 0 || i == last {
                candidates.push(Candidate {
                    promise: middle.1,
                    left: middle,
                    middle,
                    right: middle,
                    edge: true,
                });
                continue;
            }
            let (left, right) = (sample(square, i - 1), sample(square, i + 1));
            let predicted = vertex(left, middle, right).max(0.0);
            // Half as much again may be gained, because a peak between points can be sharper than its parabola.
            let promise = (predicted - 0.5 * (middle.1 - predicted)).max(0.0);
            candidates.push(Candidate {
                promise,
                left,
                middle,
                right,
                edge: false,
            });
        }
        // Maxima between the edge and its neighbour.
        for (edge, next) in [(0, 1), (last, last - 1)] {
            let (at, beside) = (sample(square, edge), sample(square, next));
            let far = if edge == 0 { 2 } else { last - 2 };
            if square[edge] >= square[next] && !covered.contains(&edge) {
                let away = sample(square, far);
                let h = beside.0 - at.0;
                let h2 = away.0 - at.0;
                let slope = ((beside.1 - at.1) / h * h2 - (away.1 - at.1) / h2 * h) / (h2 - h);
                // φ falls on entering the band: the maximum lies inside.
                if slope * h.signum() < 0.0 {
                    let omega = at.0 + 0.2 * h;
                    let middle = (
                        omega,
                        1.0 / finite_square(self.evaluate(values, omega, scratch).norm_sqr()),
                    );
                    if middle.1 < at.1 {
                        let (left, right) = if edge == 0 {
                            (at, beside)
                        } else {
                            (beside, at)
                        };
                        candidates.push(Candidate {
                            promise: 0.0,
                            left,
                            middle,
                            right,
                            edge: false,
                        });
                    }
                    break;
                }
            }
        }
        candidates.sort_unstable_by(|a, b| a.promise.total_cmp(&b.promise));
        scratch.candidates = candidates;
    }

    /// The resonance between grid points i and i + 1, between which the characteristic factor turns by more than a quarter.
    fn hidden_peak(&self, values: &[f64], i: usize, scratch: &mut Scratch) -> Option<Candidate> {
        let factor = |scratch: &Scratch, at: usize| {
            Complex64::new(scratch.factor[0][at], scratch.factor[1][at])
        };
        let (mut low, mut high) = (
            (self.omegas[i], factor(scratch, i)),
            (self.omegas[i + 1], factor(scratch, i + 1)),
        );
        let (left, right) = (
            (low.0, 1.0 / scratch.square[i]),
            (high.0, 1.0 / scratch.square[i + 1]),
        );
        let mut best = if left.1 < right.1 { left } else { right };
        let mut width = 0.0;
        // The factor passes the origin almost on a straight line; along it, its projection changes sign.
        for _ in 0..12 {
            let along = high.1 - low.1;
            let share = -(along.conj() * low.1).re / along.norm_sqr();
            let omega = low.0 + share.clamp(0.01, 0.99) * (high.0 - low.0);
            if !(omega > low.0 && omega < high.0) {
                break;
            }
            let (response, factor) = self.evaluate_with_factor(values, omega, scratch);
            let sample = (omega, 1.0 / finite_square(response.norm_sqr()));
            if sample.1 < best.1 {
                best = sample;
            }
            let turned = along.conj() * factor;
            let slope = along.norm_sqr() / (high.0 - low.0);
            width = turned.im.abs() / slope;
            let away = turned.re / slope;
            if away.abs() < 0.5 * width || away.abs() < 1e-12 * omega {
                break;
            }
            if away < 0.0 {
                low = (omega, factor);
            } else {
                high = (omega, factor);
            }
        }
        if best.0 == left.0 || best.0 == right.0 {
            return None;
        }
        // A bracket of a few widths, where 1/|H|² is a parabola.
        let (mut below, mut above) = (left, right);
        for side in [-2.0, 2.0] {
            let omega = best.0 + side * width;
            if omega > left.0 && omega < right.0 && omega != best.0 {
                let value = 1.0 / finite_square(self.evaluate(values, omega, scratch).norm_sqr());
                if value >= best.1 {
                    if side < 0.0 {
                        below = (omega, value);
                    } else {
                        above = (omega, value);
                    }
                }
            }
        }
        // A parabola through far points says nothing about a narrow peak: always refine.
        Some(Candidate {
            promise: 0.0,
            left: below,
            middle: best,
            right: above,
            edge: false,
        })
    }
}
