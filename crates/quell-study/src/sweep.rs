//! The points of a sweep: every combination of the values of its axes.

use std::borrow::Cow;

use indexmap::IndexMap;
use quell_document::Fault;
use quell_expression::{Dimension, Quantity};
use quell_search::Scale;

use crate::amount::Amount;
use crate::candidates::Candidates;
use crate::outcome::NamedValue;
use crate::problem::DesignProblem;
use crate::situation::{self, Situation};
use crate::study::{
    ConfigurationSpec, DesignTask, Study, SweepAxis, SweepRange, SweepValues, Swept, Task, TaskKind,
};

/// The values of the axes at one point of a sweep.
#[derive(Debug, Clone, Default)]
pub(crate) struct SweepPoint {
    values: Vec<(Swept, String, Quantity)>,
}

impl SweepPoint {
    fn of(&self, what: Swept) -> impl Iterator<Item = (&String, &Quantity)> {
        self.values
            .iter()
            .filter(move |(known, _, _)| *known == what)
            .map(|(_, name, value)| (name, value))
    }

    /// Those of the host's parameters.
    pub(crate) fn parameters(&self) -> Vec<(String, Quantity)> {
        self.of(Swept::Parameter)
            .map(|(name, value)| (name.clone(), *value))
            .collect()
    }

    /// The task with the bounds of this point.
    pub(crate) fn design<'a>(&self, design: &'a DesignTask) -> Cow<'a, DesignTask> {
        let mut own = self.of(Swept::Bound).chain(self.of(Swept::Value));
        if own.next().is_none() {
            return Cow::Borrowed(design);
        }
        let mut design = design.clone();
        for (name, value) in self.of(Swept::Value) {
            design.fixed.insert(name.clone(), Amount::si(value.value));
        }
        for (name, value) in self.of(Swept::Bound) {
            for constraint in &mut design.constraints {
                if constraint.criterion == *name {
                    constraint.swept = Some(value.value);
                }
            }
        }
        Cow::Owned(design)
    }

    /// Configurations with the values of this point, where they give them.
    pub(crate) fn configurations<'a>(
        &self,
        configurations: &'a IndexMap<String, ConfigurationSpec>,
    ) -> Cow<'a, IndexMap<String, ConfigurationSpec>> {
        if self.of(Swept::Value).next().is_none() {
            return Cow::Borrowed(configurations);
        }
        let mut configurations = configurations.clone();
        for (name, value) in self.of(Swept::Value) {
            for spec in configurations.values_mut() {
                if let Some(entry) = spec.values.get_mut(name) {
                    *entry = Amount::si(value.value);
                }
            }
        }
        Cow::Owned(configurations)
    }

    /// The point with another value of its first axis.
    pub(crate) fn moved(&self, to: f64) -> Self {
        let mut point = self.clone();
        if let Some((_, _, value)) = point.values.first_mut() {
            value.value = to;
        }
        point
    }

    /// The value of the first axis.
    pub(crate) fn first(&self) -> Option<(&str, f64)> {
        self.values
            .first()
            .map(|(_, name, quantity)| (name.as_str(), quantity.value))
    }

    /// The values in the order of the axes, SI.
    pub(crate) fn named(&self) -> Vec<NamedValue> {
        self.values
            .iter()
            .map(|(_, name, quantity)| NamedValue {
                name: name.clone(),
                value: quantity.value,
                unit: quantity.dimension.unit_text(),
                bounds: None,
                logarithmic: false,
            })
            .collect()
    }
}

/// The sets of swept values, in the order of the sweep (the last axis runs fastest).
pub(crate) fn sweep_points(study: &Study, task: &Task) -> Result<Vec<SweepPoint>, Fault> {
    let mut points = vec![SweepPoint::default()];
    if task.sweep.is_empty() {
        return Ok(points);
    }
    let standing = situation::build(&study.host, &study.overrides, &[])?;
    for axis in &task.sweep {
        let values = axis_values(study, task, axis, &standing)?;
        points = points
            .iter()
            .flat_map(|point| {
                values.iter().map(|value| {
                    let mut point = point.clone();
                    point.values.push((axis.what, axis.name.clone(), *value));
                    point
                })
            })
            .collect();
    }
    Ok(points)
}

/// The dimension of what an axis moves.
fn axis_dimension(
    study: &Study,
    task: &Task,
    axis: &SweepAxis,
    standing: &Situation,
) -> Result<Dimension, Fault> {
    let missing = |what: &str| {
        let message = format!("there is no {what} `{}` to sweep", axis.name);
        Fault::at(&study.source, axis.span, message)
    };
    match (axis.what, &task.kind) {
        (Swept::Bound, TaskKind::Design(design)) => {
            // A criterion has its dimension once it is compiled; every layout gives it the same.
            let candidate = Candidates::of(design)
                .iter()
                .next()
                .ok_or_else(|| missing("bound"))?;
            let problem = DesignProblem::of(study, standing, design, &candidate)?;
            let index = problem.evaluator.index(&axis.name);
            index
                .map(|index| problem.evaluator.dimension(index))
                .ok_or_else(|| missing("bound"))
        }
        (Swept::Value, kind) => {
            let given = match kind {
                TaskKind::Design(design) => design.fixed.get(&axis.name),
                TaskKind::Evaluate(configurations) => configurations
                    .values()
                    .find_map(|spec| spec.values.get(&axis.name)),
                TaskKind::Continuation(_) => None,
            };
            let given = given.ok_or_else(|| missing("value"))?;
            Ok(given.quantity(&standing.parameters)?.dimension)
        }
        _ => parameter_dimension(axis, standing).ok_or_else(|| missing("parameter")),
    }
}

fn axis_values(
    study: &Study,
    task: &Task,
    axis: &SweepAxis,
    standing: &Situation,
) -> Result<Vec<Quantity>, Fault> {
    let dimension = axis_dimension(study, task, axis, standing)?;
    values_of(axis, dimension, standing)
}

/// Every combination of values of host parameters, the last axis running fastest.
pub(crate) fn combinations(
    study: &Study,
    axes: &[SweepAxis],
    standing: &Situation,
) -> Result<Vec<Vec<(String, Quantity)>>, Fault> {
    let mut points = vec![Vec::new()];
    for axis in axes {
        let dimension = parameter_dimension(axis, standing).ok_or_else(|| {
            let message = format!("there is no parameter `{}`", axis.name);
            Fault::at(&study.source, axis.span, message)
        })?;
        let values = values_of(axis, dimension, standing)?;
        points = points
            .iter()
            .flat_map(|point: &Vec<(String, Quantity)>| {
                values.iter().map(|value| {
                    let mut point = point.clone();
                    point.push((axis.name.clone(), *value));
                    point
                })
            })
            .collect();
    }
    Ok(points)
}

fn parameter_dimension(axis: &SweepAxis, standing: &Situation) -> Option<Dimension> {
    standing
        .parameters
        .iter()
        .find(|(name, _)| *name == axis.name)
        .map(|(_, known)| known.dimension)
}

fn values_of(
    axis: &SweepAxis,
    dimension: Dimension,
    standing: &Situation,
) -> Result<Vec<Quantity>, Fault> {
    let numbers = match &axis.values {
        SweepValues::List(amounts) => amounts
            .iter()
            .map(|amount| amount.value(&standing.parameters, dimension))
            .collect::<Result<Vec<f64>, Fault>>()?,
        SweepValues::Range(range) => {
            let SweepRange {
                from,
                to,
                points,
                scale,
            } = range.as_ref();
            let first = from.value(&standing.parameters, dimension)?;
            let last = to.value(&standing.parameters, dimension)?;
            if *scale == Scale::Logarithmic && (first <= 0.0 || last <= 0.0) {
                return Err(from.fault("a logarithmic sweep runs between positive values"));
            }
            let steps = points.saturating_sub(1).max(1) as f64;
            (0..*points)
                .map(|index| {
                    let share = index as f64 / steps;
                    match scale {
                        // The ends are the values as typed, to the last bit.
                        _ if index == 0 => first,
                        _ if index + 1 == *points => last,
                        Scale::Linear => first * (1.0 - share) + last * share,
                        Scale::Logarithmic => first * (last / first).powf(share),
                    }
                })
                .collect()
        }
    };
    Ok(numbers
        .into_iter()
        .map(|value| Quantity::new(value, dimension))
        .collect())
}
