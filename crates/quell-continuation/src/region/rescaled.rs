//! A problem whose two free parameters go from 0 to 1 on the scales of their ranges.

use crate::band::ParameterSpan;
use crate::problem::Problem;

/// ẋ = f(t, x, p(u)) with u in the unit square.
pub(super) struct Rescaled<'p> {
    problem: &'p dyn Problem,
    spans: [ParameterSpan; 2],
}

impl<'p> Rescaled<'p> {
    pub(super) const fn new(problem: &'p dyn Problem, spans: [ParameterSpan; 2]) -> Self {
        Self { problem, spans }
    }

    /// The parameters themselves. Beyond its ends, where differences ask, a scale goes on as it is.
    pub(super) fn parameters(&self, u: &[f64]) -> Vec<f64> {
        let pairs = self.spans.iter().zip(u);
        pairs.map(|(span, u)| span.beyond(*u)).collect()
    }

    /// Parts of the ranges.
    pub(super) fn parts(&self, p: &[f64]) -> Vec<f64> {
        let pairs = self.spans.iter().zip(p);
        pairs.map(|(span, p)| span.part(*p)).collect()
    }

    fn slope(&self, u: &[f64], k: usize) -> f64 {
        match (self.spans.get(k), u.get(k)) {
            (Some(span), Some(u)) => span.slope_beyond(*u),
            _ => f64::NAN,
        }
    }
}

impl Problem for Rescaled<'_> {
    fn states(&self) -> usize {
        self.problem.states()
    }
    fn parameters(&self) -> usize {
        2
    }
    fn value(&self, t: f64, x: &[f64], p: &[f64], out: &mut [f64]) {
        self.problem.value(t, x, &self.parameters(p), out);
    }
    fn jacobian(&self, t: f64, x: &[f64], p: &[f64], out: &mut [f64]) {
        self.problem.jacobian(t, x, &self.parameters(p), out);
    }
    fn parameter_derivative(&self, t: f64, x: &[f64], p: &[f64], k: usize, out: &mut [f64]) {
        let own = self.parameters(p);
        self.problem.parameter_derivative(t, x, &own, k, out);
        scale(self.slope(p, k), out);
    }
    fn second(&self, t: f64, x: &[f64], p: &[f64], u: &[f64], v: &[f64], out: &mut [f64]) -> bool {
        self.problem.second(t, x, &self.parameters(p), u, v, out)
    }
    fn third(
        &self,
        t: f64,
        x: &[f64],
        p: &[f64],
        u: &[f64],
        v: &[f64],
        w: &[f64],
        out: &mut [f64],
    ) -> bool {
        self.problem.third(t, x, &self.parameters(p), u, v, w, out)
    }
    fn is_approximate(&self) -> bool {
        self.problem.is_approximate()
    }
    fn values(&self, t: &[f64], x: &[f64], p: &[f64], out: &mut [f64]) {
        self.problem.values(t, x, &self.parameters(p), out);
    }
    fn linearisations(
        &self,
        t: &[f64],
        x: &[f64],
        p: &[f64],
        values: &mut [f64],
        jacobians: &mut [f64],
    ) {
        let own = self.parameters(p);
        self.problem.linearisations(t, x, &own, values, jacobians);
    }
    fn parameter_derivatives(&self, t: &[f64], x: &[f64], p: &[f64], k: usize, out: &mut [f64]) {
        let own = self.parameters(p);
        self.problem.parameter_derivatives(t, x, &own, k, out);
        scale(self.slope(p, k), out);
    }
}

fn scale(by: f64, out: &mut [f64]) {
    for value in out {
        *value *= by;
    }
}
