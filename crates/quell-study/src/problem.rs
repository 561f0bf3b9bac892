//! A design problem for one candidate: its objective and constraints as the search sees them.

use quell_search::{Pieces, Problem, Variable};

use crate::evaluator::{Evaluator, EvaluatorScratch};
use crate::study::Sense;

/// A criterion with its direction and, for a constraint, its bound (SI).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Goal {
    /// Index of the criterion in the evaluator.
    pub(crate) criterion: usize,
    /// Which way is good.
    pub(crate) sense: Sense,
    /// The bound of a constraint; 0 for an objective.
    pub(crate) bound: f64,
}

impl Goal {
    fn sign(&self) -> f64 {
        match self.sense {
            Sense::Minimise => 1.0,
            Sense::Maximise => -1.0,
        }
    }

    /// What a violation is measured by: the bound, or 1 where that is zero.
    fn scale(&self) -> f64 {
        if self.bound == 0.0 {
            1.0
        } else {
            self.bound.abs()
        }
    }

    /// (value - bound)/|bound|, positive where the constraint fails.
    pub(crate) fn excess(&self, value: f64) -> f64 {
        self.sign() * (value - self.bound) / self.scale()
    }
}

/// Minimise (the sign applied) one criterion of a candidate under constraints on others.
#[derive(Debug)]
pub struct DesignProblem {
    /// The criteria of the objective and the constraints.
    pub(crate) evaluator: Evaluator,
    /// The objective.
    pub(crate) objective: Goal,
    /// The constraints.
    pub(crate) constraints: Vec<Goal>,
}

/// Buffers of one thread.
#[derive(Debug, Default)]
pub struct ProblemScratch {
    /// Those of the criteria.
    pub(crate) evaluator: EvaluatorScratch,
    criteria: Vec<f64>,
}

impl Problem for DesignProblem {
    type Scratch = ProblemScratch;

    fn scratch(&self) -> ProblemScratch {
        ProblemScratch {
            criteria: vec![f64::NAN; self.evaluator.names().count()],
            ..ProblemScratch::default()
        }
    }

    fn variables(&self) -> &[Variable] {
        &self.evaluator.built().variables
    }

    fn constraints(&self) -> usize {
        self.constraints.len()
    }

    fn evaluate(
        &self,
        point: &[f64],
        constraints: &mut [f64],
        scratch: &mut ProblemScratch,
    ) -> f64 {
        self.evaluator
            .built()
            .values(point, &mut scratch.evaluator.values);
        self.evaluator
            .fast(&mut scratch.evaluator, &mut scratch.criteria);
        let value = |goal: &Goal| {
            scratch
                .criteria
                .get(goal.criterion)
                .copied()
                .unwrap_or(f64::NAN)
        };
        for (goal, out) in self.constraints.iter().zip(constraints) {
            *out = goal.excess(value(goal));
        }
        self.objective.sign() * value(&self.objective)
    }

    fn pieces(
        &self,
        point: &[f64],
        margin: f64,
        pieces: &mut Pieces,
        scratch: &mut ProblemScratch,
    ) -> bool {
        // The larger the better of a peak is no minimax problem.
        if self.objective.sense == Sense::Maximise
            || self
                .constraints
                .iter()
                .any(|goal| goal.sense == Sense::Maximise)
        {
            return false;
        }
        self.evaluator
            .built()
            .values_with_derivatives(point, &mut scratch.evaluator.values);
        pieces.clear();
        let objective = self.evaluator.pieces(
            self.objective.criterion,
            1.0,
            margin,
            &mut scratch.evaluator,
            |value, fill| {
                fill(pieces.push_objective(value));
            },
        );
        if !objective {
            return false;
        }
        for (index, goal) in self.constraints.iter().enumerate() {
            let factor = 1.0 / goal.scale();
            let found = self.evaluator.pieces(
                goal.criterion,
                factor,
                margin,
                &mut scratch.evaluator,
                |value, fill| {
                    fill(pieces.push_constraint(index, value - goal.bound * factor));
                },
            );
            if !found {
                return false;
            }
        }
        pieces.is_finite()
    }
}
