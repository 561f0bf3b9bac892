//! A design problem for one candidate: its objective and constraints as the search sees them.

use std::sync::Arc;

use quell_document::Fault;
use quell_search::{Pieces, Problem, Variable};

use crate::amount::Amount;
use crate::built::{Built, Values};
use crate::candidates::{Candidate, Candidates};
use crate::evaluator::{Evaluator, EvaluatorScratch, Missed};
use crate::outcome::Evaluated;
use crate::situation::{self, Situation};
use crate::study::{Constraint, DesignTask, Objective, Sense, Study, TaskKind};

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
        self.sense.sign() * (value - self.bound) / self.scale()
    }
}

/// How values stand to the constraints of a task.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Verdict {
    /// Of the objective; NaN where it has none.
    pub(crate) objective: f64,
    /// Every constraint holds.
    pub(crate) feasible: bool,
    /// Largest relative violation; 0 where feasible.
    pub(crate) violation: f64,
}

impl Verdict {
    /// The verdict on certified values, not on those of a search.
    pub(crate) fn on(values: &Evaluated, design: &DesignTask, constraints: &[Goal]) -> Self {
        let value = |name: &str| values.criteria.get(name).copied().unwrap_or(f64::NAN);
        let violation = constraints
            .iter()
            .zip(&design.constraints)
            .map(|(goal, constraint)| {
                let excess = goal.excess(value(&constraint.criterion));
                if excess.is_nan() {
                    f64::INFINITY
                } else {
                    excess
                }
            })
            .fold(0.0, f64::max);
        let objective = value(&design.objective);
        let feasible = objective.is_finite() && violation <= design.feasibility;
        Self {
            objective,
            feasible,
            violation: if feasible { 0.0 } else { violation },
        }
    }
}

impl DesignTask {
    /// The task with one objective and bounds (SI) on others.
    pub(crate) fn bounded(&self, objective: &Objective, bounds: &[(Objective, f64)]) -> Self {
        let mut task = self.clone();
        task.objective.clone_from(&objective.criterion);
        task.sense = objective.sense;
        task.further.clear();
        task.constraints
            .extend(bounds.iter().map(|(bounded, bound)| Constraint {
                criterion: bounded.criterion.clone(),
                sense: bounded.sense,
                bound: Amount::si(*bound),
                swept: Some(*bound),
            }));
        task
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

impl DesignProblem {
    /// The problem of one candidate.
    ///
    /// # Errors
    /// A candidate that cannot be built, or a criterion that makes no sense on it.
    pub(crate) fn of(
        study: &Study,
        situation: &Situation,
        design: &DesignTask,
        candidate: &Candidate,
    ) -> Result<Self, Fault> {
        let built = Built::new(study, situation, candidate, Values::searched(design))?;
        let mut names: Vec<&str> = vec![&design.objective];
        names.extend(
            design
                .constraints
                .iter()
                .map(|constraint| constraint.criterion.as_str()),
        );
        let evaluator = Evaluator::new(
            study,
            situation,
            Arc::new(built),
            Some(&names),
            &indexmap::IndexMap::new(),
        )?;
        let objective = Goal {
            criterion: index(&evaluator, &design.objective)?,
            sense: design.sense,
            bound: 0.0,
        };
        let constraints = constraints(design, situation, &evaluator)?;
        Ok(Self {
            evaluator,
            objective,
            constraints,
        })
    }

    /// The objective and the constraints.
    fn goals(&self) -> impl Iterator<Item = &Goal> {
        std::iter::once(&self.objective).chain(&self.constraints)
    }

    /// Makes the grids of peaks denser where certificates at `point` find more than they do; false where they find nothing.
    ///
    /// An optimiser drifts to where a grid misses a peak. What `quell run` does against it: search, refine at the best point,
    /// and search again until nothing was missed.
    ///
    /// # Errors
    /// Where the host is singular at a frequency that is added.
    pub fn refine(&mut self, point: &[f64]) -> Result<bool, Fault> {
        Ok(!self.refined(point)?.is_empty())
    }

    /// [`Self::refine`], with what was missed.
    pub(crate) fn refined(&mut self, point: &[f64]) -> Result<Missed, Fault> {
        let mut scratch = EvaluatorScratch::default();
        self.evaluator.built().values(point, &mut scratch.values);
        let (_, missed) = self.evaluator.certified(&mut scratch);
        self.evaluator.add_frequencies(&missed)?;
        Ok(missed)
    }
}

fn index(evaluator: &Evaluator, name: &str) -> Result<usize, Fault> {
    evaluator
        .index(name)
        .ok_or_else(|| Fault::new(format!("there is no criterion `{name}`")))
}

/// The constraints of a task, for criteria that `evaluator` holds.
///
/// # Errors
/// A bound of another dimension than its criterion.
pub(crate) fn constraints(
    design: &DesignTask,
    situation: &Situation,
    evaluator: &Evaluator,
) -> Result<Vec<Goal>, Fault> {
    design
        .constraints
        .iter()
        .map(|constraint| {
            let criterion = index(evaluator, &constraint.criterion)?;
            let dimension = evaluator.dimension(criterion);
            let bound = constraint.bound(&situation.parameters, dimension)?;
            Ok(Goal {
                criterion,
                sense: constraint.sense,
                bound,
            })
        })
        .collect()
}

/// The problems of a design task at the host's own parameters, each with its layout in words: for users who bring their own
/// optimiser, and for benchmarks.
///
/// # Errors
/// There is no such design task, or whatever is wrong with the study.
pub fn problems(study: &Study, task: &str) -> Result<Vec<(String, DesignProblem)>, Fault> {
    let design = study.tasks.iter().find_map(|known| match &known.kind {
        TaskKind::Design(design) if known.name == task => Some(design),
        _ => None,
    });
    let design =
        design.ok_or_else(|| Fault::new(format!("the study has no design task `{task}`")))?;
    let situation = situation::build(&study.host, &study.overrides, &[])?;
    Candidates::of(design)
        .iter()
        .map(|candidate| {
            Ok((
                candidate.label(),
                DesignProblem::of(study, &situation, design, &candidate)?,
            ))
        })
        .collect()
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
        self.constraints.len() + usize::from(self.evaluator.has_bands())
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
        for (goal, out) in self.constraints.iter().zip(constraints.iter_mut()) {
            *out = goal.excess(value(goal));
        }
        if let Some(out) = constraints.get_mut(self.constraints.len()) {
            *out = Evaluator::nearest_island(&scratch.evaluator);
        }
        self.objective.sense.sign() * value(&self.objective)
    }

    fn is_smooth(&self) -> bool {
        self.evaluator.is_smooth()
            || self
                .goals()
                .all(|goal| self.evaluator.is_band(goal.criterion))
    }

    fn pieces(
        &self,
        point: &[f64],
        margin: f64,
        pieces: &mut Pieces,
        scratch: &mut ProblemScratch,
    ) -> bool {
        // The larger the better of a peak is no minimax problem; a number of a stable band is one piece either way.
        let unbounded =
            |goal: &Goal| goal.sense == Sense::Maximise && !self.evaluator.is_band(goal.criterion);
        if self.goals().any(unbounded) {
            return false;
        }
        self.evaluator
            .built()
            .values_with_derivatives(point, &mut scratch.evaluator.values);
        pieces.clear();
        let objective = self.evaluator.pieces(
            self.objective.criterion,
            self.objective.sense.sign(),
            margin,
            &mut scratch.evaluator,
            &mut |value, fill| {
                fill(pieces.push_objective(value));
            },
        );
        if !objective {
            // Where there is no band there are no slopes, but elsewhere there are.
            return self.evaluator.is_band(self.objective.criterion);
        }
        for (index, goal) in self.constraints.iter().enumerate() {
            let factor = goal.sense.sign() / goal.scale();
            let found = self.evaluator.pieces(
                goal.criterion,
                factor,
                margin,
                &mut scratch.evaluator,
                &mut |value, fill| {
                    fill(pieces.push_constraint(index, value - goal.bound * factor));
                },
            );
            if !found {
                return false;
            }
        }
        if self.evaluator.has_bands() {
            let index = self.constraints.len();
            self.evaluator
                .islands(&mut scratch.evaluator, &mut |value, fill| {
                    fill(pieces.push_constraint(index, value));
                });
        }
        pieces.is_finite()
    }
}
