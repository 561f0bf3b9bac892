//! What a search found and what is known about it.

use crate::Side;

/// How one start ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum StartStatus {
    /// A feasible point at which the local search converged with a minimax certificate of at most `1e-3`.
    Certified,
    /// A feasible point at which the local search converged; there is no certificate, for want of gradients or
    /// because the active pieces do not satisfy it.
    Converged,
    /// The budget of evaluations ran out first; the point is feasible and the best of the start.
    BudgetExhausted,
    /// No feasible point was found; the point is the one of least violation.
    Infeasible,
    /// No evaluation gave finite numbers.
    Failed,
}

/// The result of one independent start.
#[derive(Debug, Clone, PartialEq)]
pub struct StartResult {
    /// Best point, in the variables' own units.
    pub point: Vec<f64>,
    /// Objective there; infinite when every evaluation failed.
    pub objective: f64,
    /// Constraints there, `(value - bound) / scale`.
    pub constraints: Vec<f64>,
    /// Largest excess of a constraint over zero, `max(0, max_j c_j)`; infinite when every evaluation failed.
    pub violation: f64,
    /// Evaluations taken: calls of `evaluate` and calls of `pieces`.
    pub evaluations: usize,
    /// How the start ended.
    pub status: StartStatus,
    /// Minimax certificate where pieces with gradients exist: the length of the shortest vector in the convex hull of
    /// the active pieces' gradients (in scaled coordinates, with multipliers for active constraints and bounds),
    /// relative to the objective or the largest of these gradients, whichever is larger. Zero at a stationary point.
    pub certificate: Option<f64>,
}

/// How a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Status {
    /// At least two starts agree on the best feasible objective.
    Agreed,
    /// A feasible point was found, but only one start reached its objective.
    SingleStart,
    /// No start found a feasible point; the outcome is the point of least violation.
    Infeasible,
    /// No evaluation of any start gave finite numbers.
    Failed,
}

/// The result of a search over all its starts.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Best point, in the variables' own units.
    pub point: Vec<f64>,
    /// Objective there; infinite when every evaluation failed.
    pub objective: f64,
    /// Constraints there, `(value - bound) / scale`.
    pub constraints: Vec<f64>,
    /// Largest excess of a constraint over zero, `max(0, max_j c_j)`.
    pub violation: f64,
    /// Whether no constraint exceeds the feasibility tolerance.
    pub feasible: bool,
    /// Variables at a bound, by index.
    pub active_bounds: Vec<(usize, Side)>,
    /// Number of starts.
    pub starts: usize,
    /// Number of feasible starts whose objective agrees with the best one, itself included.
    pub starts_agreeing: usize,
    /// Evaluations of all starts together.
    pub evaluations: usize,
    /// How the search ended.
    pub status: Status,
    /// Minimax certificate of the best start, see [`StartResult::certificate`].
    pub certificate: Option<f64>,
}
