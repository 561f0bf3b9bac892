//! What is minimised: a black box over bounded variables, and the smooth pieces of which it may be a maximum.

use crate::Variable;

/// An objective to be minimised over bounded variables, with inequality constraints.
///
/// Points are in the variables' own units and in the order of [`variables`](Self::variables). Evaluations must be
/// deterministic: the same point gives the same numbers whatever was evaluated before with the same scratch.
pub trait Problem: Sync {
    /// Buffers that one thread reuses from evaluation to evaluation.
    type Scratch: Send;

    /// New buffers for one thread.
    fn scratch(&self) -> Self::Scratch;

    /// The variables, in the order of every point.
    fn variables(&self) -> &[Variable];

    /// Number of inequality constraints.
    fn constraints(&self) -> usize {
        0
    }

    /// The objective at `point`; `constraints[j]` is set to `(value - bound) / scale`, feasible when at most
    /// [`Settings::feasibility`](crate::Settings::feasibility).
    ///
    /// A constraint that the first sample of a start misses by more than a thousand times its scale (a bound near zero, so that
    /// the scale is small) is weighed down where points are compared, by ten times the median of what that sample misses it by;
    /// what is feasible is not changed by it.
    ///
    /// An objective or constraint that is not finite is a failed evaluation, which is never chosen.
    fn evaluate(&self, point: &[f64], constraints: &mut [f64], scratch: &mut Self::Scratch) -> f64;

    /// The smooth pieces near the maximum, for objectives and constraints that are maxima of smooth functions.
    ///
    /// `pieces` comes cleared. Give at least every piece of the objective whose value is within `margin` (relative)
    /// of the objective, `f_i >= f - margin |f|`, and of every constraint each piece with `c_ij >= c_j - margin`, all
    /// with exact gradients by the variables in their own units. Returning `false` says that there are none at this
    /// point; the search then goes on without gradients.
    fn pieces(
        &self,
        point: &[f64],
        margin: f64,
        pieces: &mut Pieces,
        scratch: &mut Self::Scratch,
    ) -> bool {
        let _ = (point, margin, pieces, scratch);
        false
    }

    /// Whether objective and constraints are smooth but for jumps here and there, so that differences may stand for the gradients
    /// of a problem that gives no pieces. A maximum of several functions, a peak for instance, is not: it has kinks where it is
    /// least.
    fn is_smooth(&self) -> bool {
        false
    }
}

/// Near-active smooth pieces of an objective and its constraints, with gradients, at one point.
///
/// Buffers keep their capacity when cleared, so that refilling them allocates nothing.
#[derive(Debug, Clone, Default)]
pub struct Pieces {
    dimension: usize,
    objective_values: Vec<f64>,
    objective_gradients: Vec<f64>,
    constraint_indices: Vec<usize>,
    constraint_values: Vec<f64>,
    constraint_gradients: Vec<f64>,
}

impl Pieces {
    /// Empty buffers for points of `dimension` variables.
    pub fn new(dimension: usize) -> Self {
        Self {
            dimension,
            ..Self::default()
        }
    }

    /// Number of variables, the length of every gradient.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// Forgets all pieces and keeps the buffers.
    pub fn clear(&mut self) {
        self.objective_values.clear();
        self.objective_gradients.clear();
        self.constraint_indices.clear();
        self.constraint_values.clear();
        self.constraint_gradients.clear();
    }

    /// Adds a piece of the objective and gives its gradient (all zeros) to be filled in.
    pub fn push_objective(&mut self, value: f64) -> &mut [f64] {
        self.objective_values.push(value);
        grow(&mut self.objective_gradients, self.dimension)
    }

    /// Adds a piece of constraint `index`, in the units of `(value - bound) / scale`, and gives its gradient (all
    /// zeros) to be filled in.
    pub fn push_constraint(&mut self, index: usize, value: f64) -> &mut [f64] {
        self.constraint_indices.push(index);
        self.constraint_values.push(value);
        grow(&mut self.constraint_gradients, self.dimension)
    }

    /// Number of pieces of the objective.
    pub fn objectives(&self) -> usize {
        self.objective_values.len()
    }

    /// Number of pieces of constraints.
    pub fn constraints(&self) -> usize {
        self.constraint_values.len()
    }

    /// Values and gradients of the objective's pieces.
    pub fn iter_objectives(&self) -> impl Iterator<Item = (f64, &[f64])> {
        self.objective_values
            .iter()
            .copied()
            .zip(rows(&self.objective_gradients, self.dimension))
    }

    /// Constraint index, value and gradient of the constraints' pieces.
    pub fn iter_constraints(&self) -> impl Iterator<Item = (usize, f64, &[f64])> {
        self.constraint_indices
            .iter()
            .zip(&self.constraint_values)
            .zip(rows(&self.constraint_gradients, self.dimension))
            .map(|((&index, &value), gradient)| (index, value, gradient))
    }

    /// Whether every value and every component of a gradient is finite.
    pub fn is_finite(&self) -> bool {
        [
            &self.objective_values,
            &self.objective_gradients,
            &self.constraint_values,
            &self.constraint_gradients,
        ]
        .into_iter()
        .flatten()
        .all(|number| number.is_finite())
    }
}

fn grow(gradients: &mut Vec<f64>, dimension: usize) -> &mut [f64] {
    let start = gradients.len();
    gradients.resize(start + dimension, 0.0);
    &mut gradients[start..]
}

fn rows(gradients: &[f64], dimension: usize) -> impl Iterator<Item = &[f64]> {
    // `chunks_exact` refuses a width of zero; without variables there are no components either.
    gradients.chunks_exact(dimension.max(1))
}
