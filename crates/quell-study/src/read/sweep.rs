//! Sweeps: values of the host's parameters and of bounds at which a task is repeated.

use std::sync::Arc;

use quell_document::{Fault, Source, Table, Value};
use quell_expression::Span;
use quell_search::Scale;

use super::unknown;
use crate::amount::Amount;
use crate::keys;
use crate::study::{Constraint, Study, SweepAxis, SweepRange, SweepValues, Swept, TaskKind};

/// A sweep of more points than this is a slip.
const MOST_POINTS: usize = 10_000;

/// The axes of a task's sweep.
pub(super) fn sweep(
    table: &Table<'_>,
    study: &Study,
    kind: &TaskKind,
) -> Result<Vec<SweepAxis>, Fault> {
    let Some(value) = table.get("sweep") else {
        return Ok(Vec::new());
    };
    let parameters = study.host.parameters(&[])?;
    let names: Vec<&str> = parameters.iter().map(|(name, _)| name.as_str()).collect();
    let axes = axes(&value, &study.source, |name, span| {
        swept(study, kind, name, span, &names)
    })?;
    refuse_many(&value, &axes)?;
    Ok(axes)
}

/// Axes of the host's parameters alone.
pub(super) fn parameter_axes(
    value: &Value<'_>,
    parameters: &[&str],
    source: &Arc<Source>,
) -> Result<Vec<SweepAxis>, Fault> {
    axes(value, source, |name, span| {
        if parameters.contains(&name) {
            return Ok(Swept::Parameter);
        }
        let message = format!("the host has no parameter `{name}`");
        let fault = Fault::at(source, span, message);
        Err(unknown(
            fault,
            name,
            "parameter",
            parameters.iter().copied(),
        ))
    })
}

fn axes(
    value: &Value<'_>,
    source: &Arc<Source>,
    what: impl Fn(&str, Span) -> Result<Swept, Fault>,
) -> Result<Vec<SweepAxis>, Fault> {
    let key = value.as_table()?;
    let mut axes = Vec::new();
    for (name, span, value) in key.entries() {
        axes.push(SweepAxis {
            name: name.to_owned(),
            what: what(name, span)?,
            span,
            values: sweep_values(&value, source)?,
        });
    }
    if axes.is_empty() {
        return Err(value
            .fault("no parameter is named here")
            .help("write `{ PARAMETER = [\"10 kg\", \"12 kg\"] }`"));
    }
    Ok(axes)
}

/// Refuses more combinations than anybody wants.
pub(super) fn refuse_many(value: &Value<'_>, axes: &[SweepAxis]) -> Result<(), Fault> {
    let points = axes
        .iter()
        .map(|axis| axis.values.count())
        .fold(1, usize::saturating_mul);
    if points > MOST_POINTS {
        return Err(value
            .fault(format!(
                "the combinations of this sweep are {points} points, more than {MOST_POINTS}"
            ))
            .help("sweep fewer parameters at once, or at fewer points"));
    }
    Ok(())
}

/// Whether the name of an axis is a parameter of the host or the criterion of a constraint.
fn swept(
    study: &Study,
    kind: &TaskKind,
    name: &str,
    span: Span,
    parameters: &[&str],
) -> Result<Swept, Fault> {
    let fault = |message: String| Fault::at(&study.source, span, message);
    let constraints: &[Constraint] = match kind {
        TaskKind::Design(design) => &design.constraints,
        TaskKind::Evaluate(_) | TaskKind::Continuation(_) => &[],
    };
    let bounds = constraints
        .iter()
        .filter(|constraint| constraint.criterion == name)
        .count();
    let given = match kind {
        TaskKind::Design(design) => design.fixed.contains_key(name),
        TaskKind::Evaluate(configurations) => configurations
            .values()
            .any(|spec| spec.values.contains_key(name)),
        TaskKind::Continuation(_) => false,
    };
    match (parameters.contains(&name), bounds) {
        (false, 0) if given => Ok(Swept::Value),
        (true, 0) => Ok(Swept::Parameter),
        (false, 1) => Ok(Swept::Bound),
        (true, _) => Err(fault(format!(
            "`{name}` is a parameter of the host and a criterion that the task bounds, and either could be swept"
        ))
        .help("give the criterion another name")),
        (false, 0) if study.criteria.contains_key(name) => {
            let fault = fault(format!("this task bounds no criterion `{name}`"));
            Err(match kind {
                TaskKind::Design(_) => fault.help(format!(
                    "give it a bound to sweep: `subject_to = [\"{name} <= VALUE\"]`"
                )),
                TaskKind::Evaluate(_) | TaskKind::Continuation(_) => {
                    fault.help("only a task of kind `design` has bounds to sweep")
                }
            })
        }
        (false, 0) => {
            let known = constraints.iter().map(|known| known.criterion.as_str());
            let known: Vec<&str> = parameters.iter().copied().chain(known).collect();
            Err(unknown(
                fault(format!("the host has no parameter `{name}` to sweep")),
                name,
                "parameter",
                known.iter().copied(),
            ))
        }
        (false, _) => Err(fault(format!(
            "the task bounds `{name}` twice, and either bound could be swept"
        ))
        .help("define the criterion under a second name for one of the two")),
    }
}

fn sweep_values(value: &Value<'_>, source: &Arc<Source>) -> Result<SweepValues, Fault> {
    let list = |value: &Value<'_>| -> Result<SweepValues, Fault> {
        let values = value
            .as_array()?
            .iter()
            .map(|value| Amount::read(value, source))
            .collect::<Result<Vec<_>, _>>()?;
        if values.is_empty() {
            return Err(value.fault("the sweep has no value").help(
                "write `[\"10 kg\", \"12 kg\"]`, or a range `{ from = …, to = …, points = … }`",
            ));
        }
        Ok(SweepValues::List(values))
    };
    if value.is_array() {
        return list(value);
    }
    let table = value.as_table()?;
    table.check(&keys::SWEEP)?;
    if let Some(values) = table.get("values") {
        if let Some(span) = ["from", "to", "points", "scale"]
            .iter()
            .find_map(|key| table.key_span(key))
        {
            return Err(Fault::at(
                source,
                span,
                "a sweep is a range or a list of `values`, not both",
            ));
        }
        return list(&values);
    }
    if let Some(missing) = ["from", "to", "points"]
        .iter()
        .find(|key| table.get(key).is_none())
    {
        return Err(table
            .fault(format!("the range of this sweep lacks `{missing}`"))
            .help(
                "write `{ from = \"10 kg\", to = \"12 kg\", points = 5 }`, or the values as a list",
            ));
    }
    let points_value = table.require("points")?;
    let points = points_value.as_count()?;
    if !(2..=MOST_POINTS).contains(&points) {
        return Err(points_value
            .fault(format!(
                "a sweep has 2 to {MOST_POINTS} points, found {points}"
            ))
            .help("for a single value use `parameters` at the top of the study"));
    }
    let scale = match table
        .get("scale")
        .map(|value| value.one_of(&["linear", "log"]))
        .transpose()?
    {
        Some("log") => Scale::Logarithmic,
        _ => Scale::Linear,
    };
    Ok(SweepValues::Range(Box::new(SweepRange {
        from: Amount::read(&table.require("from")?, source)?,
        to: Amount::read(&table.require("to")?, source)?,
        points,
        scale,
    })))
}
