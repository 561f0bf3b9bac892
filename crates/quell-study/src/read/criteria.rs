//! Criteria: numbers taken from runs or from other criteria, and what they are taken over.

use std::sync::Arc;

use indexmap::IndexMap;
use quell_document::{Fault, Source, Table, Value};
use quell_expression::{Dimension, NoNames, Scope, Span, Unit};

use super::{band, check_name, named_tables, resolve, sweep};
use crate::amount::Amount;
use crate::combination;
use crate::criteria::Modal;
use crate::keys;
use crate::situation::Situation;
use crate::study::{Criterion, Run, Statistic, Tolerance, Variation};

/// `[criteria]`.
pub(super) fn criteria(
    value: &Value<'_>,
    runs: &IndexMap<String, Run>,
    standing: &Situation,
    source: &Arc<Source>,
) -> Result<IndexMap<String, Criterion>, Fault> {
    let table = named_tables(value, "criteria")?;
    let mut criteria = IndexMap::new();
    let names: Vec<&str> = table.entries().map(|(name, _, _)| name).collect();
    for (name, span, value) in table.entries() {
        check_name(name, span, &table)?;
        if Modal::NAMES.contains(&name) {
            return Err(Fault::at(
                table.source(),
                span,
                format!("`{name}` is the name of what every mode has"),
            )
            .help("choose another name"));
        }
        let entry = value.as_table()?;
        entry.check(&keys::CRITERION)?;
        let expression = entry.require("value")?;
        let run = entry.get("run");
        let band = band::read(&entry, &expression)?;
        match &run {
            _ if band.is_some() => {}
            Some(run) => {
                resolve(run, "run", runs.keys().map(String::as_str))?;
            }
            None => of_criteria(&entry, &expression, &names, runs)?,
        }
        let unit = entry
            .get("unit")
            .map(|value| {
                let text = value.as_str()?;
                Unit::parse(text)
                    .map(|unit| (unit, value.span()))
                    .map_err(|mut error| {
                        error.span = value.text_span(error.span);
                        Fault::from_expression(value.source(), error)
                    })
            })
            .transpose()?;
        let tolerance = match entry.get("tolerance") {
            Some(value) => {
                let tolerance = value.as_f64()?;
                if !(1e-10..=0.1).contains(&tolerance) {
                    return Err(value
                        .fault(format!("the tolerance {tolerance} is out of reach"))
                        .help(
                            "a relative tolerance lies between 1e-10 and 0.1; 1e-4 unless given",
                        ));
                }
                tolerance
            }
            None => 1e-4,
        };
        criteria.insert(
            name.to_owned(),
            Criterion {
                band: band.map(Box::new),
                run: run.map(|run| run.as_str().map(str::to_owned)).transpose()?,
                value: expression.expression()?,
                unit,
                tolerance,
                variation: variation(&entry, standing, source)?,
                span: expression.span(),
            },
        );
    }
    combination::refuse_cycles(&criteria, table.source())?;
    Ok(criteria)
}

/// A criterion without a run is an expression of other criteria.
fn of_criteria(
    entry: &Table<'_>,
    value: &Value<'_>,
    names: &[&str],
    runs: &IndexMap<String, Run>,
) -> Result<(), Fault> {
    let expression = value.expression()?;
    if expression.names().iter().any(|name| names.contains(name)) {
        return Ok(());
    }
    let fault = entry.fault("this criterion names neither a run nor other criteria");
    let runs: Vec<String> = runs
        .keys()
        .map(|run| format!("`run = \"{run}\"`"))
        .collect();
    Err(fault.help(format!(
        "add {}, or write an expression of criteria",
        runs.join(" or ")
    )))
}

/// What a criterion is taken over.
fn variation(
    entry: &Table<'_>,
    standing: &Situation,
    source: &Arc<Source>,
) -> Result<Option<Variation>, Fault> {
    // Of a stable band `over` is the operating parameter.
    let own = entry.get("kind").is_none();
    let over = match entry.get("over").filter(|_| own) {
        Some(value) => {
            let names = standing.parameters.names();
            let axes = sweep::parameter_axes(&value, &names, source)?;
            sweep::refuse_many(&value, &axes)?;
            axes
        }
        None => Vec::new(),
    };
    let tolerances = match entry.get("tolerances") {
        Some(value) => tolerances(&value, source)?,
        None => Vec::new(),
    };
    let take = entry
        .get("take")
        .map(|value| value.one_of(&Statistic::NAMES))
        .transpose()?;
    let span = ["over", "tolerances"]
        .iter()
        .filter(|key| own || **key != "over")
        .find_map(|key| entry.key_span(key));
    let Some(span) = span else {
        return match entry.get("take") {
            None => Ok(None),
            Some(value) => Err(value
                .fault("this criterion is one number: there is nothing to take")
                .help("`take` goes with `over = { PARAMETER = [\"10 kg\", \"12 kg\"] }` or `tolerances = \"10 %\"`")),
        };
    };
    Ok(Some(Variation {
        over,
        tolerances,
        take: take
            .and_then(Statistic::from_name)
            .unwrap_or(Statistic::Largest),
        span,
    }))
}

fn tolerances(value: &Value<'_>, source: &Arc<Source>) -> Result<Vec<Tolerance>, Fault> {
    let one = |name: Option<&str>, value: &Value<'_>, span: Span| -> Result<Tolerance, Fault> {
        let relative = Amount::read(value, source)?.value(&NoNames, Dimension::NONE)?;
        if !(relative > 0.0 && relative < 1.0) {
            return Err(value
                .fault("a tolerance lies between 0 and 100 %, both excluded")
                .help("`\"10 %\"`: the value may be a tenth smaller or larger than meant"));
        }
        Ok(Tolerance {
            name: name.map(str::to_owned),
            relative,
            span,
        })
    };
    if !value.is_table() {
        return Ok(vec![one(None, value, value.span())?]);
    }
    let table = value.as_table()?;
    let found = table
        .entries()
        .map(|(name, span, value)| one(Some(name), &value, span))
        .collect::<Result<Vec<_>, _>>()?;
    if found.is_empty() {
        return Err(value
            .fault("the tolerances name no value")
            .help("write `tolerances = \"10 %\"` for all, or `{ k = \"5 %\" }`"));
    }
    Ok(found)
}
