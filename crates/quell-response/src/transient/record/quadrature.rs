//! Integrals over the window.

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

    pub(super) fn integrate(&mut self, integrand: Integrand) -> Integral {
        self.prepare();
        let mut estimates: Vec<(Integral, f64)> = Vec::with_capacity(self.panels.len());
        for panel in &self.panels {
            estimates.push(self.estimate(panel, integrand));
        }
        let total: f64 = estimates.iter().map(|estimate| estimate.1).sum();
        let allowed = QUADRATURE * total / self.panels.len() as f64;
        let mut result = Integral::default();
        for (index, &(estimate, _)) in estimates.iter().enumerate() {
            if estimate.error <= allowed || !estimate.error.is_finite() {
                result.value += estimate.value;
                result.error += estimate.error;
                continue;
            }
            let panel = &self.panels[index];
            let (part, segment) = (panel.part, panel.segment);
            let mut stack = vec![(panel.from, panel.to, 0)];
            while let Some((from, to, depth)) = stack.pop() {
                let middle = 0.5 * (from + to);
                for (a, b) in [(from, middle), (middle, to)] {
                    let half = self.panel(part, segment, (a, b), HALVED);
                    let (estimate, _) = self.estimate(&half, integrand);
                    let share = allowed * (0.5_f64).powi(depth + 1);
                    if estimate.error <= share.max(f64::EPSILON * total) || depth >= 40 {
                        result.value += estimate.value;
                        result.error += estimate.error;
                    } else {
                        stack.push((a, b, depth + 1));
                    }
                }
            }
        }
        result
    }
}
