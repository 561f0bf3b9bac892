//! A problem whose two free parameters go from 0 to 1 on the scales of their ranges.

use super::mapped::{Map, Mapped};
use crate::band::ParameterSpan;
use crate::problem::Problem;

/// The unit square of two ranges.
pub(super) struct Square([ParameterSpan; 2]);

impl Map for Square {
    fn free(&self) -> usize {
        2
    }
    /// Beyond its ends, where differences ask, a scale goes on as it is.
    fn parameters(&self, u: &[f64]) -> Vec<f64> {
        let pairs = self.0.iter().zip(u);
        pairs.map(|(span, u)| span.beyond(*u)).collect()
    }
    fn slope(&self, u: &[f64], j: usize, k: usize) -> f64 {
        match (self.0.get(k), u.get(k)) {
            _ if j != k => 0.0,
            (Some(span), Some(u)) => span.slope_beyond(*u),
            _ => f64::NAN,
        }
    }
}

/// ẋ = f(t, x, p(u)) with u in the unit square.
pub(super) type Rescaled<'p> = Mapped<'p, Square>;

impl<'p> Rescaled<'p> {
    pub(super) const fn new(problem: &'p dyn Problem, spans: [ParameterSpan; 2]) -> Self {
        Self::of(problem, Square(spans))
    }

    /// The parameters themselves.
    pub(super) fn parameters(&self, u: &[f64]) -> Vec<f64> {
        self.map.parameters(u)
    }

    /// Parts of the ranges.
    pub(super) fn parts(&self, p: &[f64]) -> Vec<f64> {
        let pairs = self.map.0.iter().zip(p);
        pairs.map(|(span, p)| span.part(*p)).collect()
    }
}
