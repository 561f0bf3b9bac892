//! Integrals over the window.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::super::chebyshev::nodes;
use super::{Integral, Panel, Record};

/// What is integrated over time.
#[derive(Debug, Clone, Copy)]
pub(super) enum Integrand {
    Signal(usize),
    Square(usize),
    /// a ḃ.
    Over(usize, usize),
}

/// Relative tolerance of quadratures.
const QUADRATURE: f64 = 1e-11;
/// Degree of panels that are made by halving others.
const HALVED: usize = 8;

impl Record<'_> {
    fn estimate(&self, panel: &Panel, integrand: Integrand) -> (Integral, f64) {
        let nodes = nodes(panel.degree);
        let length = panel.to - panel.from;
        let points = nodes.points.len();
        let mut extra = 0.0;
        let values: Vec<f64> = match integrand {
            Integrand::Signal(s) => (0..points).map(|j| self.sample(panel, j, s)).collect(),
            Integrand::Square(s) => (0..points)
                .map(|j| self.sample(panel, j, s).powi(2))
                .collect(),
            Integrand::Over(a, b) => {
                if a >= self.signals || b >= self.signals || length <= 0.0 {
                    vec![if length > 0.0 { f64::NAN } else { 0.0 }; points]
                } else {
                    let slopes = nodes.slopes(&panel.values, self.signals, b);
                    let a: Vec<f64> = (0..points).map(|j| self.sample(panel, j, a)).collect();
                    // ∫ a (b - p)' = -∫ a' (b - p), p through b: what is missed is at most the variation of a times b - p.
                    let (low, high) = a.iter().fold((f64::MAX, f64::MIN), |(low, high), value| {
                        (low.min(*value), high.max(*value))
                    });
                    let tail = nodes.tail(&panel.values, self.signals, b);
                    extra = (high - low) * (tail[1] + tail[2]);
                    a.iter().zip(&slopes).map(|(a, b)| a * b / length).collect()
                }
            }
        };
        let sum = |f: &dyn Fn(f64) -> f64| -> f64 {
            length
                * nodes
                    .weights
                    .iter()
                    .zip(&values)
                    .map(|(weight, value)| weight * f(*value))
                    .sum::<f64>()
        };
        let tail = nodes.tail(&values, 1, 0);
        // Coefficients after the last one integrate to about 2/N² of their size.
        let order = (nodes.degree * nodes.degree) as f64;
        let error = length * (tail[1] + tail[2]) * 2.0 / order + extra;
        let integral = Integral {
            value: sum(&|value| value),
            error,
        };
        (integral, sum(&f64::abs))
    }

    /// The panel with the largest error is halved until the errors add up to less than is allowed.
    ///
    /// Where the error estimate is the rounding of the signal itself (a stiff damper's force is a small difference of large
    /// numbers), halving leaves it as large as it was; such a panel is taken as it is, and its error is in the result.
    pub(super) fn integrate(&mut self, integrand: Integrand) -> Integral {
        self.prepare();
        let mut pieces: Vec<Piece> = Vec::with_capacity(self.panels.len());
        let mut total = 0.0;
        for panel in &self.panels {
            let (estimate, size) = self.estimate(panel, integrand);
            total += size;
            pieces.push(Piece::of(panel, estimate));
        }
        let allowed = QUADRATURE * total;
        let mut missing: f64 = pieces.iter().map(|piece| piece.estimate.error).sum();
        if missing > allowed && missing.is_finite() {
            let mut heap: BinaryHeap<Worst> = pieces
                .iter()
                .enumerate()
                .map(|(index, piece)| Worst(piece.estimate.error, index))
                .collect();
            let most = pieces.len() + HALVINGS;
            while missing > allowed && pieces.len() < most {
                let Some(Worst(error, index)) = heap.pop() else {
                    break;
                };
                let Some(parent) = pieces.get(index).copied() else {
                    break;
                };
                let middle = 0.5 * (parent.from + parent.to);
                let halves = [(parent.from, middle), (middle, parent.to)].map(|span| {
                    let panel = self.panel(parent.part, parent.segment, span, HALVED);
                    let (estimate, _) = self.estimate(&panel, integrand);
                    Piece {
                        futile: parent.futile,
                        ..Piece::of(&panel, estimate)
                    }
                });
                let after = halves[0].estimate.error + halves[1].estimate.error;
                let futile = if after > FUTILE * error {
                    parent.futile + 1
                } else {
                    0
                };
                missing += after - error;
                for (half, place) in halves.into_iter().zip([index, pieces.len()]) {
                    let half = Piece { futile, ..half };
                    if futile < 2 {
                        heap.push(Worst(half.estimate.error, place));
                    }
                    if place < pieces.len() {
                        pieces[place] = half;
                    } else {
                        pieces.push(half);
                    }
                }
            }
        }
        let mut result = Integral::default();
        for piece in &pieces {
            result.value += piece.estimate.value;
            result.error += piece.estimate.error;
        }
        result
    }
}

/// Halvings that one integral may cost.
const HALVINGS: usize = 2000;
/// Share of an error that must go when a panel is halved: a kink leaves a quarter, a jump a half, rounding all of it.
const FUTILE: f64 = 0.7;

/// A panel in the course of halving.
#[derive(Debug, Clone, Copy)]
struct Piece {
    part: usize,
    segment: usize,
    from: f64,
    to: f64,
    estimate: Integral,
    /// How often halving in a row has gained nothing.
    futile: u32,
}

impl Piece {
    fn of(panel: &Panel, estimate: Integral) -> Self {
        Self {
            part: panel.part,
            segment: panel.segment,
            from: panel.from,
            to: panel.to,
            estimate,
            futile: 0,
        }
    }
}

/// A piece in order of its error; the earlier one of two that are equal.
#[derive(Debug, Clone, Copy)]
struct Worst(f64, usize);

impl Ord for Worst {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0
            .total_cmp(&other.0)
            .then_with(|| other.1.cmp(&self.1))
    }
}

impl PartialOrd for Worst {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Worst {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Worst {}
