//! Runs in time as typed.

use std::sync::Arc;

use indexmap::IndexMap;
use quell_document::{Fault, Source, Table, Value};
use quell_expression::{Expression, Node, Span};

use crate::amount::Amount;
use crate::keys;
use crate::study::{EndEvent, Excitation, Integration, PhaseSpec, Run, StartAt, TransientRun};

/// The keys of a run in time, in which configurations may differ.
pub(super) const KEYS: [&str; 9] = [
    "duration",
    "inputs",
    "end",
    "continue",
    "start",
    "phases",
    "tolerance",
    "most_steps",
    "method",
];

/// Reads a run of kind `transient`.
pub(super) fn run(
    table: &Table<'_>,
    name: &str,
    span: Span,
    source: &Arc<Source>,
) -> Result<Run, Fault> {
    let duration = table.get("duration").ok_or_else(|| {
        table
            .fault(format!("the run `{name}` does not say how long it lasts"))
            .help("add `duration = \"10 s\"`; with `end` it is the longest that it may take")
    })?;
    let mut run = TransientRun {
        end: None,
        duration: Amount::read(&duration, source)?,
        beyond: None,
        start: StartAt::Stated,
        inputs: IndexMap::new(),
        phases: Vec::new(),
        tolerance: 1e-8,
        most_steps: 100_000,
        method: Integration::Automatic,
        span,
    };
    for key in KEYS {
        if let Some(value) = table.get(key) {
            set(&mut run, key, &value, source)?;
        }
    }
    Ok(Run::Transient(Box::new(run)))
}

/// Sets one key of a run in time.
///
/// # Errors
/// The value does not fit the key.
pub(super) fn set(
    run: &mut TransientRun,
    key: &str,
    value: &Value<'_>,
    source: &Arc<Source>,
) -> Result<(), Fault> {
    match key {
        "duration" => run.duration = Amount::read(value, source)?,
        "continue" => run.beyond = Some(Amount::read(value, source)?),
        "inputs" => {
            let table = value.as_table().map_err(|fault| {
                fault.help("write `inputs = { F = { pulse = { amplitude = \"5 N\", duration = \"1 ms\" } } }`")
            })?;
            for (name, span, value) in table.entries() {
                excite(run, name, span, &value)?;
            }
        }
        "end" => run.end = Some(end(value)?),
        "start" => {
            run.start = if value.is_table() {
                let entries = value.as_table()?;
                let states = entries
                    .entries()
                    .map(|(name, _, value)| Ok((name.to_owned(), Amount::read(&value, source)?)))
                    .collect::<Result<_, Fault>>()?;
                StartAt::States(states)
            } else {
                match value.one_of(&["stated", "equilibrium"]).map_err(|fault| {
                    fault.help("write `\"stated\"`, `\"equilibrium\"`, or values: `{ x = \"1 mm\", \"x'\" = \"2 m/s\" }`")
                })? {
                    "equilibrium" => StartAt::Equilibrium,
                    _ => StartAt::Stated,
                }
            }
        }
        "phases" => {
            let list = value.as_array().map_err(|fault| {
                fault.help("write a list: `[{ hold = \"x\", until = \"…\" }, {}]`")
            })?;
            run.phases = list.iter().map(phase).collect::<Result<_, _>>()?;
            let count = run.phases.len();
            for (index, (phase, value)) in run.phases.iter().zip(&list).enumerate() {
                if phase.until.is_none() && index + 1 < count {
                    return Err(value
                        .fault("nothing ends this phase, and another follows")
                        .help("add `until = \"…\"`"));
                }
            }
        }
        "most_steps" => {
            run.most_steps = value.as_count()?;
            if run.most_steps == 0 {
                return Err(value
                    .fault("a run takes at least one step")
                    .help("leave `most_steps` out for 100000"));
            }
        }
        "tolerance" => {
            let tolerance = value.as_f64()?;
            if !(1e-13..=1e-2).contains(&tolerance) {
                return Err(value
                    .fault(format!("the tolerance {tolerance} is out of reach"))
                    .help("the tolerance of an integration lies between 1e-13 and 1e-2; 1e-8 unless given"));
            }
            run.tolerance = tolerance;
        }
        _ => {
            run.method =
                match value.one_of(&["automatic", "explicit", "stiff", "stiff oscillating"])? {
                    "explicit" => Integration::Explicit,
                    "stiff" => Integration::Stiff,
                    "stiff oscillating" => Integration::StiffOscillating,
                    _ => Integration::Automatic,
                }
        }
    }
    Ok(())
}

/// Gives an input another signal in a run in time.
///
/// # Errors
/// The value is no table.
pub(super) fn excite(
    run: &mut TransientRun,
    name: &str,
    span: Span,
    value: &Value<'_>,
) -> Result<(), Fault> {
    let table = value.as_table().map_err(|fault| {
        fault.help("write a signal as in a host: `{ harmonic = { amplitude = \"2 mm\", frequency = \"3 Hz\" } }`")
    })?;
    let excitation = Excitation {
        path: table.path().to_owned(),
        span,
    };
    run.inputs.insert(name.to_owned(), excitation);
    Ok(())
}

fn end(value: &Value<'_>) -> Result<EndEvent, Fault> {
    let table = value
        .as_table()
        .map_err(|fault| fault.help("write `end = { event = \"x'\", falling = true }`"))?;
    table.check(&keys::END)?;
    let flag = |key: &str| table.get(key).map(|value| value.as_bool()).transpose();
    let (rising, falling) = (flag("rising")?, flag("falling")?);
    Ok(EndEvent {
        event: table.require("event")?.expression()?,
        rising: match (rising.unwrap_or(false), falling.unwrap_or(false)) {
            (true, false) => Some(true),
            (false, true) => Some(false),
            _ => None,
        },
        armed: table
            .get("armed")
            .map(|value| comparison(&value))
            .transpose()?,
    })
}

fn phase(value: &Value<'_>) -> Result<PhaseSpec, Fault> {
    let table = value.as_table()?;
    table.check(&keys::PHASE)?;
    Ok(PhaseSpec {
        hold: table
            .get("hold")
            .map(|value| value.expression())
            .transpose()?,
        until: table
            .get("until")
            .map(|value| comparison(&value))
            .transpose()?,
        span: value.span(),
    })
}

/// A condition that becomes true at a moment.
fn comparison(value: &Value<'_>) -> Result<Expression, Fault> {
    let expression = value.expression()?;
    if matches!(expression.node, Node::Comparison { .. }) {
        Ok(expression)
    } else {
        Err(value
            .fault("expected one comparison")
            .help("such as `\"x' > 0\"`"))
    }
}
