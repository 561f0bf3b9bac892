//! Coordinates and inputs, and which coordinates are supports.

use quell_document::{Fault, Table, Value};
use quell_expression::{Dimension, Quantity, Span, nearest};

use super::keys;
use super::names::Names;
use crate::linear::{Coordinate, CoordinateKind, Input, InputKind};
use crate::matrix::LARGEST_MATRIX;

/// One row of the matrices.
#[derive(Debug, Clone)]
pub(super) struct Row {
    pub name: String,
    pub kind: CoordinateKind,
    /// Mass or inertia stated with it.
    pub inertia: f64,
    /// Where a run in time begins, and at what rate.
    pub start: [f64; 2],
    /// Index of the input that prescribes it, if it is a support.
    pub input: Option<usize>,
}

/// Rows of the matrices, of which some are coordinates and some supports, and the inputs.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    pub rows: Vec<Row>,
    /// Rows that are coordinates, in order.
    pub free: Vec<usize>,
    pub inputs: Vec<Input>,
}

impl Layout {
    /// Each free coordinate and its rate where a run in time begins.
    pub(super) fn starts(&self) -> Vec<[f64; 2]> {
        self.free.iter().map(|&row| self.rows[row].start).collect()
    }

    pub(super) fn coordinates(&self) -> Vec<Coordinate> {
        self.free
            .iter()
            .map(|&row| Coordinate {
                name: self.rows[row].name.clone(),
                kind: self.rows[row].kind,
            })
            .collect()
    }
}

/// A displacement or a rate at the start: a plain number is SI, also for a rotation, which is no frequency.
pub(crate) fn motion(
    value: &Value<'_>,
    parameters: &[(String, Quantity)],
    dimension: Dimension,
) -> Result<f64, Fault> {
    if value.is_number() {
        return value.as_f64();
    }
    Ok(value.quantity(&parameters, Some(dimension))?.value)
}

fn kind_of(table: &Table<'_>, key: &str) -> Result<CoordinateKind, Fault> {
    Ok(match table.get(key) {
        Some(value) if value.one_of(&["translation", "rotation"])? == "rotation" => {
            CoordinateKind::Rotation
        }
        _ => CoordinateKind::Translation,
    })
}

/// Reads `[coordinates]`, `[inputs]` and the names of supports.
pub(super) fn layout(
    coordinates: &Table<'_>,
    inputs: Option<&Table<'_>>,
    linear: &Table<'_>,
    parameters: &[(String, Quantity)],
    names: &mut Names,
) -> Result<Layout, Fault> {
    let mut rows = Vec::new();
    let mut spans: Vec<Span> = Vec::new();
    for (name, span, value) in coordinates.entries() {
        let table = value.as_table()?;
        table.check(&keys::COORDINATE)?;
        let kind = kind_of(&table, "kind")?;
        let (own, other) = match kind {
            CoordinateKind::Translation => ("mass", "inertia"),
            CoordinateKind::Rotation => ("inertia", "mass"),
        };
        if let Some(wrong) = table.get(other) {
            return Err(wrong
                .fault(format!(
                    "`{name}` is a {}, which takes `{own}`",
                    if kind == CoordinateKind::Rotation {
                        "rotation"
                    } else {
                        "translation"
                    }
                ))
                .help(if kind == CoordinateKind::Rotation {
                    "write `inertia`, in kg*m^2"
                } else {
                    "write `mass`, or say `kind = \"rotation\"`"
                }));
        }
        let [_, _, dimension] = kind.element_dimensions();
        let mut inertia = 0.0;
        if let Some(value) = table.get(own) {
            inertia = value.quantity(&parameters, Some(dimension))?.value;
            if inertia < 0.0 {
                return Err(value.fault(format!("the {own} of `{name}` must not be negative")));
            }
        }
        if let Some(value) = table.get("massless") {
            return Err(value
                .fault("`massless` belongs to a host written as equations")
                .help(format!("a coordinate without `{own}` has none of its own")));
        }
        let mut start = [0.0; 2];
        let rate = kind.dimension() / Dimension::TIME;
        for (amount, (key, dimension)) in start
            .iter_mut()
            .zip([("start", kind.dimension()), ("rate", rate)])
        {
            if let Some(value) = table.get(key) {
                *amount = motion(&value, parameters, dimension)?;
            }
        }
        rows.push(Row {
            name: name.to_owned(),
            kind,
            inertia,
            start,
            input: None,
        });
        spans.push(span);
    }
    if rows.len() > LARGEST_MATRIX {
        return Err(coordinates.fault(format!(
            "{} coordinates are too many: a host is dense and takes at most {LARGEST_MATRIX}",
            rows.len()
        )));
    }
    let supports = supports(linear, &rows)?;
    let mut given = Vec::new();
    if let Some(table) = inputs {
        for (name, span, value) in table.entries() {
            let support = supports.iter().find(|(row, _)| rows[*row].name == name);
            if support.is_none() {
                names.define(table.source(), name, span, "an input")?;
            }
            let entry = value.as_table()?;
            entry.check(&keys::INPUT)?;
            let input = input(name, &entry, support.map(|(row, _)| rows[*row].kind))?;
            if let Some((row, _)) = support {
                rows[*row].input = Some(given.len());
            }
            given.push(input);
        }
    }
    for (row, _) in &supports {
        if rows[*row].input.is_none() {
            rows[*row].input = Some(given.len());
            let kind = rows[*row].kind;
            given.push(Input {
                name: rows[*row].name.clone(),
                kind: InputKind::Displacement,
                motion: kind,
                dimension: kind.dimension(),
            });
        }
    }
    for (row, span) in rows.iter().zip(&spans) {
        let what = if row.input.is_some() {
            "a support"
        } else {
            "a coordinate"
        };
        names.define(coordinates.source(), &row.name, *span, what)?;
    }
    let free: Vec<usize> = (0..rows.len())
        .filter(|&row| rows[row].input.is_none())
        .collect();
    if free.is_empty() {
        return Err(coordinates.fault("a host needs a coordinate that is free to move"));
    }
    Ok(Layout {
        rows,
        free,
        inputs: given,
    })
}

/// Rows named by `supports`, with the places of the names.
fn supports(linear: &Table<'_>, rows: &[Row]) -> Result<Vec<(usize, Span)>, Fault> {
    let Some(list) = linear.get("supports") else {
        return Ok(Vec::new());
    };
    let mut found: Vec<(usize, Span)> = Vec::new();
    for value in list.as_array()? {
        let name = value.as_str()?;
        let Some(row) = rows.iter().position(|row| row.name == name) else {
            let fault = value.fault(format!("there is no coordinate `{name}`"));
            return Err(
                match nearest(name, rows.iter().map(|row| row.name.as_str())) {
                    Some(near) => fault.help(format!("did you mean `{near}`?")),
                    None => fault
                        .help("a support is one of `[coordinates]`, whose motion is prescribed"),
                },
            );
        };
        if found.iter().any(|(known, _)| *known == row) {
            return Err(value.fault(format!("`{name}` is named twice")));
        }
        found.push((row, value.span()));
    }
    Ok(found)
}

fn input(name: &str, table: &Table<'_>, support: Option<CoordinateKind>) -> Result<Input, Fault> {
    let key = table.require("kind")?;
    let kind = match key.one_of(&["displacement", "velocity", "acceleration", "force"])? {
        "displacement" => InputKind::Displacement,
        "velocity" => InputKind::Velocity,
        "acceleration" => InputKind::Acceleration,
        _ => InputKind::Force,
    };
    if let Some(unit) = table.get("unit") {
        return Err(unit
            .fault("`unit` belongs to an input of kind `number`, which only equations can use")
            .help("the unit of the input follows from its kind"));
    }
    let mut motion = kind_of(table, "motion")?;
    if let Some(of_support) = support {
        if kind == InputKind::Force {
            return Err(key
                .fault(format!(
                    "`{name}` is a support, whose motion is prescribed, not a force"
                ))
                .help("write `displacement`, `velocity` or `acceleration`"));
        }
        if let Some(given) = table.get("motion")
            && motion != of_support
        {
            return Err(given.fault(format!(
                "the coordinate `{name}` says otherwise in its `kind`"
            )));
        }
        motion = of_support;
    }
    match (kind, table.get("on")) {
        (InputKind::Force, None) => {
            return Err(key
                .fault(format!("the force `{name}` does not say what it acts on"))
                .help("write `on = \"x\"` with the name of a coordinate"));
        }
        (InputKind::Force, _) | (_, None) => {}
        (_, Some(on)) => {
            return Err(on
                .fault(format!(
                    "`{name}` is a prescribed motion, which acts through what is attached to it"
                ))
                .help("leave out `on`, and end a spring, a damper or a port on the input"));
        }
    }
    let displacement = motion.dimension();
    let dimension = match kind {
        InputKind::Force => motion.force_dimension(),
        InputKind::Displacement => displacement,
        InputKind::Velocity => displacement / Dimension::TIME,
        InputKind::Acceleration => displacement / Dimension::TIME / Dimension::TIME,
    };
    Ok(Input {
        name: name.to_owned(),
        kind,
        motion,
        dimension,
    })
}
