//! Tasks of kind `simulate` as typed.

use indexmap::IndexMap;
use quell_document::{Fault, Table, Value};
use quell_expression::Span;

use super::continuation::{configuration, measures, oscillations, ranges, two_parameters};
use super::unknown;
use crate::amount::Amount;
use crate::continuation::{BranchStart, ContinuationTask, Follows, MotionStarts, MotionsAsked};
use crate::study::{Study, Task, TaskKind};

/// Most motions at one place that anybody waits for.
const MOST_STARTS: usize = 1000;
/// What a task that checks another takes from it.
const ITS: [&str; 6] = [
    "configuration",
    "parameter",
    "parameters",
    "ranges",
    "oscillations",
    "period",
];
const MEASURES: &str = "write `measures = { sway = \"max(abs(x))\" }`";

/// Reads a task.
///
/// # Errors
/// Whatever is wrong with it, at its place.
pub(super) fn task(
    table: &Table<'_>,
    study: &Study,
    above: &[Task],
) -> Result<ContinuationTask, Fault> {
    let own = match table.get("of") {
        Some(value) => checked(table, &value, above)?.clone(),
        None => alone(table, study, above)?,
    };
    let span = table.require("name")?.span();
    let places = places(table, study, &own.parameters)?;
    Ok(ContinuationTask {
        follows: Follows::Motions,
        start: BranchStart::Equilibrium,
        more: Vec::new(),
        at: Vec::new(),
        measures: match table.get("measures") {
            Some(_) => measures(table, study, "measures", MEASURES)?,
            None => own.measures.clone(),
        },
        motions: MotionsAsked {
            of: table
                .get("of")
                .map(|value| value.as_str().map(str::to_owned))
                .transpose()?,
            places,
            starts: starts(table, study)?,
            duration: table
                .get("duration")
                .map(|value| Amount::read(&value, &study.source))
                .transpose()?,
        },
        span,
        ..own
    })
}

/// The task that is checked.
fn checked<'t>(
    table: &Table<'_>,
    value: &Value<'_>,
    above: &'t [Task],
) -> Result<&'t ContinuationTask, Fault> {
    let name = value.as_str()?;
    let known = || {
        above.iter().filter_map(|task| match &task.kind {
            TaskKind::Continuation(own)
                if matches!(
                    own.follows,
                    Follows::Branch | Follows::Diagram | Follows::Region
                ) =>
            {
                Some((task, own.as_ref()))
            }
            _ => None,
        })
    };
    let Some((task, own)) = known().find(|(task, _)| task.name == name) else {
        let names: Vec<&str> = known().map(|(task, _)| task.name.as_str()).collect();
        let fault = value.fault(format!(
            "there is no task `{name}` of kind `branch`, `diagram` or `region` above, with which motions could be compared"
        ));
        return Err(unknown(fault, name, "task", names.iter().copied()));
    };
    if !task.sweep.is_empty() {
        return Err(value.fault(format!(
            "the task `{name}` is swept, so there is not one set of branches to compare with"
        )));
    }
    for key in ITS {
        if let Some(span) = table.key_span(key) {
            return Err(Fault::at(
                table.source(),
                span,
                format!("`{key}` is that of `{name}`, with which the motions are compared"),
            )
            .help(format!("leave `{key}` out, or leave `of` out")));
        }
    }
    Ok(own)
}

/// A task that checks no other.
fn alone(table: &Table<'_>, study: &Study, above: &[Task]) -> Result<ContinuationTask, Fault> {
    let parameters = match (table.get("parameter"), table.get("parameters")) {
        (Some(_), Some(both)) => {
            return Err(both
                .fault("the task has `parameter` already")
                .help("write `parameters` for two, or `parameter` for one"));
        }
        (Some(one), None) => vec![(one.as_str()?.to_owned(), one.span())],
        (None, Some(both)) => two_parameters(&both, "motions are let go over two parameters")?,
        (None, None) => Vec::new(),
    };
    Ok(ContinuationTask {
        configuration: match table.get("configuration") {
            Some(value) => Some(configuration(&value, study, above)?),
            None => None,
        },
        ranges: match table.get("ranges") {
            Some(value) => ranges(&value, study, &parameters)?,
            None => IndexMap::new(),
        },
        parameters,
        oscillations: oscillations(table, study)?,
        period: table
            .get("period")
            .map(|value| Amount::read(&value, &study.source))
            .transpose()?,
        ..ContinuationTask::new(Follows::Motions, table.require("name")?.span())
    })
}

/// Values of the parameters at which motions are let go.
fn places(
    table: &Table<'_>,
    study: &Study,
    parameters: &[(String, Span)],
) -> Result<Vec<Vec<Amount>>, Fault> {
    let Some(value) = table.get("at") else {
        return Ok(Vec::new());
    };
    let example = match parameters {
        [] => {
            return Err(value
                .fault("nothing says which parameter has these values")
                .help("add `parameter = \"NAME\"`, or `of = \"TASK\"` with a branch, diagram or region above"));
        }
        [_] => "write a list: `at = [\"20 m/s\", \"30 m/s\"]`".to_owned(),
        _ => {
            let names: Vec<&str> = parameters.iter().map(|(name, _)| name.as_str()).collect();
            format!(
                "write a list of pairs, first `{}`: `at = [[\"20 m/s\", \"5 N*s/m\"]]`",
                names.join("`, then `")
            )
        }
    };
    let list = value
        .as_array()
        .map_err(|fault| fault.help(example.clone()))?;
    if list.is_empty() {
        return Err(value.fault("motions are let go at no value").help(example));
    }
    list.iter()
        .map(|one| {
            let own = if parameters.len() == 1 {
                vec![one.clone()]
            } else {
                one.as_array()
                    .map_err(|fault| fault.help(example.clone()))?
            };
            if own.len() != parameters.len() {
                return Err(one
                    .fault(format!(
                        "{} values for {} parameters",
                        own.len(),
                        parameters.len()
                    ))
                    .help(example.clone()));
            }
            own.iter()
                .map(|value| {
                    Amount::read(value, &study.source).map_err(|fault| fault.help(example.clone()))
                })
                .collect()
        })
        .collect()
}

/// Where motions begin.
fn starts(table: &Table<'_>, study: &Study) -> Result<MotionStarts, Fault> {
    const EXAMPLE: &str =
        "write `starts = 6`, or `starts = [{ x = \"1 mm\" }, { \"x'\" = \"0.2 m/s\" }]`";
    let Some(value) = table.get("starts") else {
        return Ok(MotionStarts::default());
    };
    if value.is_number() {
        let number = value.as_count()?;
        return if (1..=MOST_STARTS).contains(&number) {
            Ok(MotionStarts::Pushed(number))
        } else {
            Err(value.fault(format!(
                "the number of motions at each value lies between 1 and {MOST_STARTS}"
            )))
        };
    }
    let list = value.as_array().map_err(|fault| fault.help(EXAMPLE))?;
    if list.is_empty() {
        return Err(value.fault("no motion has a start").help(EXAMPLE));
    }
    let one = |value: &Value<'_>| {
        let own = value.as_table().map_err(|fault| fault.help(EXAMPLE))?;
        let mut states = IndexMap::new();
        for (name, _, amount) in own.entries() {
            states.insert(name.to_owned(), Amount::read(&amount, &study.source)?);
        }
        if states.is_empty() {
            return Err(value
                .fault("a motion that begins at rest stays there")
                .help(EXAMPLE));
        }
        Ok((states, value.span()))
    };
    let all: Result<Vec<_>, Fault> = list.iter().map(one).collect();
    Ok(MotionStarts::Stated(all?))
}
