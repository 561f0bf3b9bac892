//! What an integrator is to the simulation: it hands over accepted steps until it is told to stop.

use super::dynamics::Dynamics;

/// How a run is integrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Method {
    /// Exact propagation wherever the system says that it is affine; elsewhere an explicit method, or an implicit one where
    /// the eigenvalues of the Jacobian say that stability and not accuracy would dictate the steps.
    #[default]
    Automatic,
    /// The explicit Runge-Kutta method Tsit5(4), affine or not.
    Explicit,
    /// Backward differentiation of order 1 to 5, affine or not: for stiff systems.
    Stiff,
    /// The singly diagonally implicit Runge-Kutta method ESDIRK 4(3), affine or not: for stiff systems that oscillate with
    /// little damping, where backward differentiation of high order is not stable.
    StiffOscillating,
}

/// What a step was taken with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Scheme {
    /// Matrix exponentials.
    Exact,
    /// Tsit5(4) (Ch. Tsitouras, 2011), explicit, order 5, dense output of order 4.
    Tsit45,
    /// Backward differentiation of variable order 1 to 5.
    Bdf,
    /// ESDIRK 4(3), implicit.
    Esdirk34,
}

impl Scheme {
    /// Its name in words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "matrix exponentials",
            Self::Tsit45 => "Tsit5(4)",
            Self::Bdf => "backward differentiation",
            Self::Esdirk34 => "ESDIRK 4(3)",
        }
    }
}

/// An accepted step: polynomials through the states at the Chebyshev-Lobatto points of [from, from + length], of which the
/// part up to `to` counts.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Step<'a> {
    pub(crate) from: f64,
    pub(crate) length: f64,
    pub(crate) to: f64,
    pub(crate) degree: usize,
    /// Node-major.
    pub(crate) values: &'a [f64],
    pub(crate) scheme: Scheme,
    /// Evaluations of the rates since the last step, rejected trials included.
    pub(crate) evaluations: usize,
}

/// Who receives the steps.
pub(crate) trait Visit {
    /// Whether to go on.
    fn visit(&mut self, dynamics: &mut dyn Dynamics, step: &Step<'_>) -> bool;
}

/// Where a smooth piece begins, how far it may go, how accurate it shall be.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Piece<'a> {
    pub(crate) t: f64,
    pub(crate) x: &'a [f64],
    pub(crate) limit: f64,
    /// A length of time on the scale of the run.
    pub(crate) scale: f64,
    pub(crate) relative: f64,
    pub(crate) absolute: &'a [f64],
    pub(crate) longest: f64,
}

/// How a piece ended.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Ending {
    /// At its limit.
    Reached,
    /// The visitor had enough.
    Stopped,
    /// The integrator gave up at a time, and says why.
    Failed { t: f64, why: String },
}
