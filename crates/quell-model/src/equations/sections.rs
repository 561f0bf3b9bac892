//! `[coordinates]`, `[inputs]`, `[states]`, `[definitions]`, `[functions]` and `[operating]` of equation hosts, as typed.

use std::path::Path;

use quell_document::{Fault, Table, Value};
use quell_expression::{Dimension, Expression, ExpressionError, Signature, Span, nearest};

use super::amounts::Amounts;
use super::host::{EquationInput, EquationInputKind, Measure, OperatingRange};
use super::signal;
use crate::host::keys;
use crate::host::names::Names;
use crate::linear::{CoordinateKind, InputKind};

/// A coordinate as typed.
pub(super) struct TypedCoordinate<'a> {
    pub name: String,
    pub span: Span,
    pub kind: Measure,
    pub dimension: Dimension,
    pub massless: bool,
    pub start: Option<Value<'a>>,
    pub rate: Option<Value<'a>>,
}

/// Reads `[coordinates]`.
pub(super) fn coordinates<'a>(
    table: &Table<'a>,
    amounts: Amounts<'_>,
    names: &mut Names,
) -> Result<Vec<TypedCoordinate<'a>>, Fault> {
    let mut typed = Vec::new();
    for (name, span, value) in table.entries() {
        names.define(table.source(), name, span, "a coordinate")?;
        let entry = value.as_table()?;
        entry.check(&keys::COORDINATE)?;
        for key in ["mass", "inertia"] {
            if let Some(value) = entry.get(key) {
                return Err(value
                    .fault(format!(
                        "`{key}` belongs to a host with `[linear]`; here the equations hold it"
                    ))
                    .help(format!(
                        "make it a parameter, and write it before `{name}''` in the equation"
                    )));
            }
        }
        let kind = match entry.get("kind") {
            Some(value) => match value.one_of(&["translation", "rotation", "number"])? {
                "rotation" => Measure::Rotation,
                "number" => Measure::Number,
                _ => Measure::Translation,
            },
            None if amounts.dimensionless => Measure::Number,
            None => Measure::Translation,
        };
        typed.push(TypedCoordinate {
            name: name.to_owned(),
            span,
            kind,
            dimension: amounts.dimension(kind.dimension()),
            massless: entry
                .get("massless")
                .map_or(Ok(false), |value| value.as_bool())?,
            start: entry.get("start"),
            rate: entry.get("rate"),
        });
    }
    Ok(typed)
}

/// Reads `[inputs]`.
pub(super) fn inputs(
    table: &Table<'_>,
    amounts: Amounts<'_>,
    folder: &Path,
    names: &mut Names,
) -> Result<Vec<EquationInput>, Fault> {
    let mut inputs = Vec::new();
    for (name, span, value) in table.entries() {
        names.define(table.source(), name, span, "an input")?;
        let entry = value.as_table()?;
        entry.check(&keys::INPUT)?;
        if let Some(on) = entry.get("on") {
            return Err(on
                .fault("here the equations say where an input acts")
                .help(format!("leave out `on`, and write `{name}` in an equation")));
        }
        let key = entry.require("kind")?;
        let kind = match key.one_of(&[
            "displacement",
            "velocity",
            "acceleration",
            "force",
            "number",
        ])? {
            "displacement" => EquationInputKind::Mechanical(InputKind::Displacement),
            "velocity" => EquationInputKind::Mechanical(InputKind::Velocity),
            "acceleration" => EquationInputKind::Mechanical(InputKind::Acceleration),
            "force" => EquationInputKind::Mechanical(InputKind::Force),
            _ => EquationInputKind::Number,
        };
        let motion = match entry.get("motion") {
            Some(value) => {
                if kind == EquationInputKind::Number {
                    return Err(value.fault("a number is neither translation nor rotation"));
                }
                match value.one_of(&["translation", "rotation"])? {
                    "rotation" => CoordinateKind::Rotation,
                    _ => CoordinateKind::Translation,
                }
            }
            None => CoordinateKind::Translation,
        };
        let of_motion = motion.dimension();
        let mut dimension = match kind {
            EquationInputKind::Number => Dimension::NONE,
            EquationInputKind::Mechanical(kind) => match kind {
                InputKind::Force => motion.force_dimension(),
                InputKind::Displacement => of_motion,
                InputKind::Velocity => of_motion / Dimension::TIME,
                InputKind::Acceleration => of_motion / Dimension::TIME / Dimension::TIME,
            },
        };
        if let Some(value) = entry.get("unit") {
            if kind != EquationInputKind::Number {
                return Err(value
                    .fault(format!("the unit of `{name}` follows from its kind"))
                    .help("leave out `unit`, or write `kind = \"number\"`"));
            }
            dimension = amounts.unit(&value)?.dimension;
        }
        let dimension = amounts.dimension(dimension);
        let waveform = entry
            .get("signal")
            .map(|value| signal::waveform(&value, dimension, amounts, folder))
            .transpose()?;
        inputs.push(EquationInput {
            name: name.to_owned(),
            kind,
            dimension,
            waveform,
            harmonic: entry
                .get("signal")
                .map(|value| signal::harmonic_law(&value))
                .transpose()?
                .flatten(),
        });
    }
    Ok(inputs)
}

/// A state as typed.
pub(super) struct TypedState<'a> {
    pub name: String,
    pub rate: Value<'a>,
    pub start: Option<Value<'a>>,
    /// Known from `unit`, or from the unit of `start`.
    pub dimension: Option<Dimension>,
}

/// Reads `[states]`.
pub(super) fn states<'a>(
    table: &Table<'a>,
    amounts: Amounts<'_>,
    names: &mut Names,
) -> Result<Vec<TypedState<'a>>, Fault> {
    let mut typed = Vec::new();
    for (name, span, value) in table.entries() {
        names.define(table.source(), name, span, "a state")?;
        let name = name.to_owned();
        if !value.is_table() {
            typed.push(TypedState {
                name,
                rate: value,
                start: None,
                dimension: amounts.dimensionless.then_some(Dimension::NONE),
            });
            continue;
        }
        let entry = value.as_table()?;
        entry.check(&keys::STATE)?;
        let start = entry.get("start");
        let dimension = match (entry.get("unit"), &start) {
            (Some(unit), _) => Some(amounts.unit(&unit)?.dimension),
            _ if amounts.dimensionless => Some(Dimension::NONE),
            // A number without unit does not say that the state is one.
            (None, Some(start)) if start.is_text() => {
                Some(start.quantity(amounts.parameters, None)?.dimension)
            }
            _ => None,
        };
        typed.push(TypedState {
            name,
            rate: entry.require("rate")?,
            start,
            dimension,
        });
    }
    Ok(typed)
}

/// Reads `[definitions]`, `[outputs]`: names with their expressions.
pub(super) fn expressions<'a>(
    table: Option<&Table<'a>>,
    what: &'static str,
    names: &mut Names,
) -> Result<Vec<(String, Value<'a>, Expression)>, Fault> {
    let mut found = Vec::new();
    for (name, span, value) in table.into_iter().flat_map(Table::entries) {
        let source = value.source();
        if let Some(open) = name.find('(') {
            return Err(Fault::at(
                source,
                span,
                format!("`{name}` has arguments, so it is a function"),
            )
            .help(format!(
                "write it under `[functions]`, or as `{}`",
                name.get(..open).unwrap_or_default()
            )));
        }
        names.define(source, name, span, what)?;
        let expression = value.expression()?;
        found.push((name.to_owned(), value, expression));
    }
    Ok(found)
}

/// Reads `[functions]`.
pub(super) fn functions(
    table: &Table<'_>,
    names: &mut Names,
) -> Result<Vec<(Signature, Expression)>, Fault> {
    let mut functions = Vec::new();
    for (head, span, value) in table.entries() {
        let source = table.source();
        // The key is in quotes where it is well-formed, and its places count from behind the first.
        let quoted = source
            .text
            .get(span.start..span.end)
            .and_then(|text| text.find(head));
        let place = |inner: Span| match quoted {
            Some(offset) => inner.shifted(span.start + offset),
            None => span,
        };
        let signature = Signature::parse(head).map_err(|error| {
            let span = place(error.span);
            Fault::from_expression(source, ExpressionError { span, ..error })
        })?;
        names.define(source, &signature.name, place(signature.span), "a function")?;
        functions.push((signature, value.expression()?));
    }
    Ok(functions)
}

/// Reads `[operating]`.
pub(super) fn operating(
    table: &Table<'_>,
    amounts: Amounts<'_>,
) -> Result<Vec<OperatingRange>, Fault> {
    let mut ranges = Vec::new();
    for (name, span, value) in table.entries() {
        let Some((_, quantity)) = amounts.parameters.iter().find(|(known, _)| known == name) else {
            let fault = Fault::at(
                table.source(),
                span,
                format!("there is no parameter `{name}`"),
            );
            let known = amounts.parameters.iter().map(|(known, _)| known.as_str());
            return Err(match nearest(name, known) {
                Some(near) => fault.help(format!("did you mean `{near}`?")),
                None => fault.help("an operating range is one of `[parameters]`"),
            });
        };
        let entry = value.as_table()?;
        entry.check(&keys::RANGE)?;
        let (begin, open) = match (entry.get("from"), entry.get("above")) {
            (Some(value), None) => (value, false),
            (None, Some(value)) => (value, true),
            (Some(_), Some(value)) => {
                return Err(value
                    .fault("the range begins twice")
                    .help("`above` leaves the value itself out, `from` does not"));
            }
            (None, None) => {
                return Err(entry
                    .fault(format!(
                        "the range of `{name}` does not say where it begins"
                    ))
                    .help("write `from`, or `above` to leave the value itself out"));
            }
        };
        let end = entry.require("to")?;
        let from = amounts.read(&begin, quantity.dimension)?;
        let to = amounts.read(&end, quantity.dimension)?;
        if from >= to {
            return Err(end.fault("the range must end above its beginning"));
        }
        ranges.push(OperatingRange {
            parameter: name.to_owned(),
            dimension: quantity.dimension,
            from,
            open,
            to,
        });
    }
    Ok(ranges)
}
