//! The points of a sweep: every combination of the values of its axes.

use quell_document::Fault;
use quell_expression::Quantity;
use quell_search::Scale;

use crate::situation::{self, Situation};
use crate::study::{Study, SweepAxis, SweepRange, SweepValues, Task};

/// The sets of swept values, in the order of the sweep (the last axis runs fastest).
pub(crate) fn sweep_points(
    study: &Study,
    task: &Task,
) -> Result<Vec<Vec<(String, Quantity)>>, Fault> {
    let mut points: Vec<Vec<(String, Quantity)>> = vec![Vec::new()];
    if task.sweep.is_empty() {
        return Ok(points);
    }
    let standing = situation::build(&study.host, &study.overrides, &[])?;
    for axis in &task.sweep {
        let values = axis_values(study, axis, &standing)?;
        points = points
            .iter()
            .flat_map(|point| {
                values.iter().map(|value| {
                    let mut point = point.clone();
                    point.push((axis.parameter.clone(), *value));
                    point
                })
            })
            .collect();
    }
    Ok(points)
}

fn axis_values(
    study: &Study,
    axis: &SweepAxis,
    standing: &Situation,
) -> Result<Vec<Quantity>, Fault> {
    let Some((_, known)) = standing
        .parameters
        .iter()
        .find(|(name, _)| *name == axis.parameter)
    else {
        return Err(Fault::at(
            &study.source,
            axis.span,
            format!("the host has no parameter `{}`", axis.parameter),
        ));
    };
    let dimension = known.dimension;
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
