//! Evaluations in scaled coordinates, counted and compared.

use crate::{Pieces, Problem, Settings};

/// Objective and violation at one point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Value {
    /// The objective; infinite for a failed evaluation.
    pub(crate) objective: f64,
    /// `max(0, max_j c_j)`; infinite for a failed evaluation.
    pub(crate) violation: f64,
}

impl Value {
    pub(crate) const FAILED: Self = Self {
        objective: f64::INFINITY,
        violation: f64::INFINITY,
    };

    pub(crate) fn is_failed(self) -> bool {
        !self.objective.is_finite() || !self.violation.is_finite()
    }

    /// Feasible beats infeasible, then the lower objective, or the lower violation among infeasible ones.
    pub(crate) fn is_better_than(self, other: Self, feasibility: f64) -> bool {
        match (
            self.violation <= feasibility,
            other.violation <= feasibility,
        ) {
            (true, true) => self.objective < other.objective,
            (true, false) => true,
            (false, true) => false,
            (false, false) => {
                self.violation < other.violation
                    || (self.violation == other.violation && self.objective < other.objective)
            }
        }
    }

    /// `f + weight max(0, violation - allowance)`, with failed evaluations infinite.
    pub(crate) fn penalised(self, weight: f64) -> f64 {
        if self.is_failed() {
            f64::INFINITY
        } else {
            self.objective + weight * self.violation
        }
    }
}

/// A point of a sample with everything about it.
pub(crate) struct Sampled<'p> {
    pub(crate) coordinates: &'p [f64],
    objective: f64,
    constraints: Vec<f64>,
    pub(crate) value: Value,
}

/// The problem of one start: counts evaluations, keeps the best point, and works in scaled coordinates.
pub(crate) struct Evaluator<'a, P: Problem> {
    problem: &'a P,
    pub(crate) settings: &'a Settings,
    scratch: P::Scratch,
    point: Vec<f64>,
    constraints: Vec<f64>,
    raw: Pieces,
    pub(crate) evaluations: usize,
    pub(crate) best: Value,
    pub(crate) best_coordinates: Vec<f64>,
    best_point: Vec<f64>,
    best_constraints: Vec<f64>,
    /// By what each constraint is divided beyond the tolerance; 1 for most.
    relief: Vec<f64>,
    /// Whether the problem gives no pieces, so that differences stand for them.
    differences: bool,
    /// Where `constraints` and this objective were evaluated.
    last: (Vec<f64>, f64),
}

/// How gradients by differences are taken; those that the problem gives are exact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Accuracy {
    /// To one side: half the evaluations, for the way to an optimum.
    Coarse,
    /// Central.
    Fine,
}

impl<'a, P: Problem> Evaluator<'a, P> {
    pub(crate) fn new(problem: &'a P, settings: &'a Settings) -> Self {
        let dimension = problem.variables().len();
        let constraints = problem.constraints();
        Self {
            problem,
            settings,
            scratch: problem.scratch(),
            point: vec![0.0; dimension],
            constraints: vec![0.0; constraints],
            raw: Pieces::new(dimension),
            evaluations: 0,
            best: Value::FAILED,
            best_coordinates: vec![0.5; dimension],
            best_point: problem
                .variables()
                .iter()
                .map(|variable| variable.value(0.5))
                .collect(),
            best_constraints: vec![f64::INFINITY; constraints],
            relief: vec![1.0; constraints],
            differences: false,
            last: (Vec::new(), f64::NAN),
        }
    }

    pub(crate) fn dimension(&self) -> usize {
        self.problem.variables().len()
    }

    pub(crate) fn has_constraints(&self) -> bool {
        !self.constraints.is_empty()
    }

    /// Whether gradients are differences.
    pub(crate) fn differences(&self) -> bool {
        self.differences
    }

    pub(crate) fn remaining(&self) -> usize {
        self.settings
            .evaluations_per_start
            .saturating_sub(self.evaluations)
    }

    /// Whether `a` would be preferred to `b` as a result of this start.
    ///
    /// Within a start only a hundredth of the feasibility tolerance is used, or every search would end at the far edge
    /// of the tolerance, where the objective is lowest, instead of at the constraint.
    pub(crate) fn prefers(&self, a: Value, b: Value) -> bool {
        a.is_better_than(b, 0.01 * self.settings.feasibility)
    }

    fn place(&mut self, coordinates: &[f64]) {
        for ((x, variable), &u) in self
            .point
            .iter_mut()
            .zip(self.problem.variables())
            .zip(coordinates)
        {
            *x = variable.value(u);
        }
    }

    /// The objective at scaled coordinates, with the constraints beside; the best point is kept.
    fn raw_values(&mut self, coordinates: &[f64]) -> f64 {
        self.place(coordinates);
        self.constraints.fill(0.0);
        self.evaluations += 1;
        let objective =
            self.problem
                .evaluate(&self.point, &mut self.constraints, &mut self.scratch);
        self.last.0.clear();
        self.last.0.extend_from_slice(coordinates);
        self.last.1 = objective;
        self.keep(coordinates, objective);
        objective
    }

    /// Objective and violation at scaled coordinates.
    pub(crate) fn evaluate(&mut self, coordinates: &[f64]) -> Value {
        let objective = self.raw_values(coordinates);
        self.value(objective)
    }

    fn value(&self, objective: f64) -> Value {
        if !objective.is_finite() || !self.constraints.iter().all(|c| c.is_finite()) {
            return Value::FAILED;
        }
        let violation = self
            .constraints
            .iter()
            .zip(&self.relief)
            .fold(0.0_f64, |worst, (&c, &relief)| {
                worst.max(self.violated(c, relief))
            });
        Value {
            objective,
            violation,
        }
    }

    /// A constraint as it is weighed where points are compared; steps see it divided by its relief on both sides of its edge.
    ///
    /// A bound near zero, `regrowth <= 1e-9` say, makes violations of 1e7 of everyday values: no other constraint would
    /// count beside it, no penalty would fit, and the slack of a whole bound on the feasible side would make differences
    /// across its edge steep. What is feasible stays so.
    fn violated(&self, constraint: f64, relief: f64) -> f64 {
        let allowed = 0.01 * self.settings.feasibility;
        if constraint > allowed && relief > 1.0 {
            allowed + constraint / relief
        } else {
            constraint
        }
    }

    /// Weighs constraints by a sample of the box: one that is missed by over a thousand times its bound at half of the points that
    /// miss it is divided by ten times that. Gives the sample anew, with the best point among it.
    pub(crate) fn relieve(&mut self, sample: &mut [Sampled<'_>]) {
        for j in 0..self.relief.len() {
            let mut missed: Vec<f64> = sample
                .iter()
                .filter_map(|one| one.constraints.get(j).copied())
                .filter(|c| c.is_finite() && *c > self.settings.feasibility)
                .collect();
            missed.sort_by(f64::total_cmp);
            if let Some(&median) = missed.get(missed.len() / 2)
                && median > 1000.0
            {
                // A tenth of the bound is what a sample misses everyday constraints by.
                self.relief[j] = 10.0 * median;
            }
        }
        if self.relief.iter().all(|relief| *relief == 1.0) {
            return;
        }
        self.best = Value::FAILED;
        self.last.0.clear();
        for one in sample {
            self.place(one.coordinates);
            self.constraints.copy_from_slice(&one.constraints);
            one.value = self.value(one.objective);
            self.keep(one.coordinates, one.objective);
        }
    }

    /// One point of a sample.
    pub(crate) fn sampled<'p>(&mut self, coordinates: &'p [f64]) -> Sampled<'p> {
        let objective = self.raw_values(coordinates);
        Sampled {
            coordinates,
            objective,
            constraints: self.constraints.clone(),
            value: self.value(objective),
        }
    }

    /// Largest violation at the best point, as it is.
    pub(crate) fn violation(&self) -> f64 {
        if self.best.is_failed() {
            return self.best.violation;
        }
        let constraints = self.best_constraints.iter();
        constraints.fold(0.0_f64, |worst, &c| worst.max(c))
    }

    fn keep(&mut self, coordinates: &[f64], objective: f64) {
        let value = self.value(objective);
        if value.is_failed() {
            return;
        }
        if self.best.is_failed() || self.prefers(value, self.best) {
            self.best = value;
            self.best_coordinates.clear();
            self.best_coordinates.extend_from_slice(coordinates);
            self.best_point.clone_from(&self.point);
            self.best_constraints.clone_from(&self.constraints);
        }
    }

    /// Near-active pieces with gradients by the scaled coordinates; false when there are none here.
    ///
    /// Where the problem gives none but is smooth, objective and constraints are one piece each, with differences.
    pub(crate) fn pieces(
        &mut self,
        coordinates: &[f64],
        accuracy: Accuracy,
        pieces: &mut Pieces,
    ) -> bool {
        if !self.differences {
            match self.given_pieces(coordinates, pieces) {
                Some(usable) => return usable,
                None => {
                    self.differences = self.settings.difference > 0.0 && self.problem.is_smooth();
                }
            }
        }
        self.differences && self.differenced(coordinates, accuracy, pieces)
    }

    /// The problem's own pieces; `None` where it gives none, false where they are of no use.
    fn given_pieces(&mut self, coordinates: &[f64], pieces: &mut Pieces) -> Option<bool> {
        self.place(coordinates);
        self.evaluations += 1;
        self.raw.clear();
        pieces.clear();
        let available = self.problem.pieces(
            &self.point,
            self.settings.margin,
            &mut self.raw,
            &mut self.scratch,
        );
        if !available {
            return None;
        }
        if self.raw.objectives() == 0 || !self.raw.is_finite() {
            return Some(false);
        }
        let variables = self.problem.variables();
        let scale = |target: &mut [f64], source: &[f64], point: &[f64]| {
            for (((target, &source), variable), &x) in
                target.iter_mut().zip(source).zip(variables).zip(point)
            {
                *target = source * variable.slope(x);
            }
        };
        for (value, gradient) in self.raw.iter_objectives() {
            scale(pieces.push_objective(value), gradient, &self.point);
        }
        for (index, value, gradient) in self.raw.iter_constraints() {
            let relief = self.relief.get(index).copied().unwrap_or(1.0);
            let target = pieces.push_constraint(index, value / relief);
            scale(target, gradient, &self.point);
            for entry in target {
                *entry /= relief;
            }
        }
        Some(true)
    }

    /// Objective and constraints with differences over [`Settings::difference`]: central if they are to be fine, one-sided
    /// else, at a bound and where a neighbour cannot be evaluated.
    fn differenced(
        &mut self,
        coordinates: &[f64],
        accuracy: Accuracy,
        pieces: &mut Pieces,
    ) -> bool {
        let dimension = coordinates.len();
        if dimension == 0 || self.remaining() < 2 * dimension + 1 {
            return false;
        }
        let count = 1 + self.constraints.len();
        let middle = if self.last.0 == coordinates {
            self.last_values()
        } else {
            self.values(coordinates)
        };
        if !middle.iter().all(|value| value.is_finite()) {
            return false;
        }
        let mut slopes = vec![0.0; count * dimension];
        let mut moved = coordinates.to_vec();
        let step = self.settings.difference;
        for (i, &at) in coordinates.iter().enumerate() {
            let mut ends = [(at, None), (at, None)];
            for (end, sign) in ends.iter_mut().zip([1.0, -1.0]) {
                let to = at + sign * step;
                if (0.0..=1.0).contains(&to) {
                    moved[i] = to;
                    let values = self.values(&moved);
                    if values.iter().all(|value| value.is_finite()) {
                        *end = (to, Some(values));
                        if accuracy == Accuracy::Coarse {
                            break;
                        }
                    }
                }
            }
            moved[i] = at;
            let [(upper, above), (lower, below)] = ends;
            if upper <= lower {
                return false;
            }
            let (above, below) = (above.as_ref(), below.as_ref());
            for j in 0..count {
                let of = |values: Option<&Vec<f64>>| values.unwrap_or(&middle)[j];
                slopes[j * dimension + i] = (of(above) - of(below)) / (upper - lower);
            }
        }
        pieces.clear();
        for (j, (slope, &value)) in slopes.chunks_exact(dimension).zip(&middle).enumerate() {
            match j.checked_sub(1) {
                None => pieces.push_objective(value).copy_from_slice(slope),
                Some(index) => pieces.push_constraint(index, value).copy_from_slice(slope),
            }
        }
        pieces.is_finite()
    }

    /// Objective and constraints, not-a-number or infinite where the evaluation failed.
    fn values(&mut self, coordinates: &[f64]) -> Vec<f64> {
        self.raw_values(coordinates);
        self.last_values()
    }

    /// Those of the last point.
    fn last_values(&self) -> Vec<f64> {
        let mut values = Vec::with_capacity(1 + self.constraints.len());
        values.push(self.last.1);
        values.extend(
            self.constraints
                .iter()
                .zip(&self.relief)
                .map(|(&c, &relief)| c / relief),
        );
        values
    }

    /// Best point in the variables' own units, and the constraints there.
    pub(crate) fn into_best(self) -> (Vec<f64>, Vec<f64>) {
        (self.best_point, self.best_constraints)
    }
}
