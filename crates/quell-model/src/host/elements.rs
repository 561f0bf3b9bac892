//! Springs, dampers, inerters and masses.

use quell_document::{Fault, Table, Value};
use quell_expression::Dimension;

use super::file::Host;
use super::keys;
use super::points;
use super::system::{Base, Motion, System};
use crate::form::motion_form;
use crate::linear::{CoordinateKind, InputKind, LinearForm, Signal};

/// An element of the host that outputs may name.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedElement {
    /// The name in the host file.
    pub name: String,
    /// Its relative displacement.
    pub stroke: LinearForm,
    /// Its force; none where it is complex (a loss factor).
    pub force: Option<LinearForm>,
    /// Between displacements or between angles.
    pub kind: CoordinateKind,
}

/// The four lists of `[linear]`.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Sort {
    Spring,
    Damper,
    Inerter,
    Mass,
}

impl Sort {
    const ALL: [(&'static str, Self); 4] = [
        ("springs", Self::Spring),
        ("dampers", Self::Damper),
        ("inerters", Self::Inerter),
        ("masses", Self::Mass),
    ];

    const fn value_name(self) -> &'static str {
        match self {
            Self::Spring => "stiffness",
            Self::Damper => "damping",
            Self::Inerter => "inertance",
            Self::Mass => "mass",
        }
    }

    const fn derivatives(self) -> usize {
        match self {
            Self::Spring => 0,
            Self::Damper => 1,
            Self::Inerter | Self::Mass => 2,
        }
    }
}

/// One element as typed.
struct Typed<'a> {
    ends: Vec<Value<'a>>,
    value: Value<'a>,
    name: Option<Value<'a>>,
    loss: Option<Value<'a>>,
}

/// Stamps every element of `[linear]` and collects the named ones.
pub(super) fn stamp(
    host: &mut Host,
    system: &mut System,
    linear: &Table<'_>,
    base: Option<&Base>,
) -> Result<(), Fault> {
    for (key, sort) in Sort::ALL {
        let Some(list) = linear.get(key) else {
            continue;
        };
        for item in list.as_array()? {
            element(host, system, sort, &item, base)?;
        }
    }
    Ok(())
}

fn typed<'a>(sort: Sort, item: &Value<'a>) -> Result<Typed<'a>, Fault> {
    if item.is_table() {
        let table = item.as_table()?;
        table.check(match sort {
            Sort::Spring => &keys::SPRING,
            Sort::Damper | Sort::Inerter => &keys::CONNECTION,
            Sort::Mass => &keys::POINT_MASS,
        })?;
        let ends = if sort == Sort::Mass {
            vec![table.require("at")?]
        } else {
            points::pair(&table.require("between")?)?.to_vec()
        };
        return Ok(Typed {
            ends,
            value: table.require("value")?,
            name: table.get("name"),
            loss: table.get("loss"),
        });
    }
    let (wanted, example) = if sort == Sort::Mass {
        (2, "a point and a mass, `[\"x1\", \"m\"]`")
    } else {
        (3, "two end points and a value, `[\"x1\", \"x2\", \"k\"]`")
    };
    let mut ends = item.as_array()?;
    if ends.len() != wanted {
        return Err(item.fault(format!("expected {example}; found {} entries", ends.len())));
    }
    let Some(value) = ends.pop() else {
        return Err(item.fault(format!("expected {example}")));
    };
    Ok(Typed {
        ends,
        value,
        name: None,
        loss: None,
    })
}

fn element(
    host: &mut Host,
    system: &mut System,
    sort: Sort,
    item: &Value<'_>,
    base: Option<&Base>,
) -> Result<(), Fault> {
    let typed = typed(sort, item)?;
    let motion = match &typed.ends[..] {
        [a, b] => points::between(host, &[a.clone(), b.clone()], base)?.0,
        [point] => points::point(host, point, base)?
            .filter(|motion| !motion.is_free_of_coordinates())
            .ok_or_else(|| point.fault("no coordinate of the host moves this point"))?,
        _ => return Err(item.fault("expected end points")),
    };
    let [stiffness, damping, inertance] = motion.kind.element_dimensions();
    let dimension = match sort {
        Sort::Spring => stiffness,
        Sort::Damper => damping,
        Sort::Inerter | Sort::Mass => inertance,
    };
    let value = amount(&host.parameters, &typed.value, dimension, sort.value_name())?;
    let loss = match &typed.loss {
        None => None,
        Some(given) => Some((
            amount(&host.parameters, given, Dimension::NONE, "loss factor")?,
            given,
        ))
        .filter(|(loss, _)| *loss > 0.0),
    };
    if let Some((_, given)) = &loss
        && !motion.is_free_of_inputs()
    {
        return Err(given
            .fault("a spring with a loss factor cannot end on a prescribed motion")
            .help("make the coordinates relative to the moving base, `base = { influence = […], input = … }`, and end the spring on `ground`"));
    }
    match sort {
        Sort::Spring => system.spring(&motion, value, loss.as_ref().map(|(loss, _)| *loss)),
        Sort::Damper => system.damper(&motion, value),
        Sort::Inerter => system.inerter(&motion, value),
        Sort::Mass => system.mass(&motion, value),
    }
    if let Some(name) = &typed.name {
        let text = name.as_str()?;
        super::names::Names::default().define(
            name.source(),
            text,
            name.span(),
            "the name of an element",
        )?;
        if host.elements.iter().any(|known| known.name == text) {
            return Err(name.fault(format!("`{text}` is already the name of another element")));
        }
        let named = named(text, sort, &motion, value, loss.is_some(), base);
        host.elements.push(named);
    }
    Ok(())
}

fn named(
    name: &str,
    sort: Sort,
    motion: &Motion,
    value: f64,
    lossy: bool,
    base: Option<&Base>,
) -> NamedElement {
    let mut stroke = motion_form(&motion.coordinates, &motion.inputs);
    if sort == Sort::Mass
        && let Some(base) = base
    {
        // A mass feels absolute motion.
        stroke.add(
            Signal::Input {
                index: base.input,
                order: 0,
            },
            carried(&motion.coordinates, base),
        );
    }
    let force = (!lossy).then(|| {
        let mut force = stroke.clone().scaled(value);
        for (signal, _) in &mut force.terms {
            if let Signal::Coordinate { order, .. } | Signal::Input { order, .. } = signal {
                *order = sort.derivatives();
            }
        }
        force
    });
    NamedElement {
        name: name.to_owned(),
        stroke,
        force,
        kind: motion.kind,
    }
}

/// h·ι: how far the base carries a point.
pub(super) fn carried(coordinates: &[f64], base: &Base) -> f64 {
    coordinates
        .iter()
        .zip(&base.influence)
        .map(|(coefficient, influence)| coefficient * influence)
        .sum()
}

/// A quantity that must not be negative.
pub(super) fn amount(
    parameters: &[(String, quell_expression::Quantity)],
    value: &Value<'_>,
    dimension: Dimension,
    what: &str,
) -> Result<f64, Fault> {
    let quantity = value.quantity(&parameters, Some(dimension))?.value;
    if quantity < 0.0 {
        return Err(value
            .fault(format!("a {what} must not be negative"))
            .help("zero or more is expected"));
    }
    Ok(quantity)
}

/// Reads the generalised direction in which each force acts, F0's column.
pub(super) fn direction(
    host: &Host,
    on: &Value<'_>,
    input: usize,
    base: Option<&Base>,
) -> Result<Vec<f64>, Fault> {
    let kind = host.linear.inputs[input].motion;
    if on.is_table() {
        let mut column = vec![0.0; host.linear.coordinates.len()];
        let table = on.as_table()?;
        for (name, span, value) in table.entries() {
            let Some(index) = host
                .linear
                .coordinates
                .iter()
                .position(|coordinate| coordinate.name == name)
            else {
                let fault = Fault::at(
                    on.source(),
                    span,
                    format!("there is no coordinate `{name}`"),
                );
                let names = host
                    .linear
                    .coordinates
                    .iter()
                    .map(|coordinate| coordinate.name.as_str());
                return Err(match quell_expression::nearest(name, names) {
                    Some(near) => fault.help(format!("did you mean `{near}`?")),
                    None => fault,
                });
            };
            let dimension = kind.dimension() / host.linear.coordinates[index].kind.dimension();
            column[index] = ratio(&host.parameters, &value, dimension)?;
        }
        return Ok(column);
    }
    let motion = points::motion(host, on, &on.expression()?, base)?;
    if motion.kind != kind {
        return Err(on
            .fault(match kind {
                CoordinateKind::Translation => {
                    "a force acts along a displacement, but this is an angle"
                }
                CoordinateKind::Rotation => {
                    "a moment acts along an angle, but this is a displacement"
                }
            })
            .help("`motion = \"rotation\"` makes the input a moment"));
    }
    if !motion.is_free_of_inputs() {
        return Err(on.fault("a force on a prescribed motion does nothing; expected coordinates"));
    }
    Ok(motion.coordinates)
}

/// A coefficient of a dimension in which rad does not count.
pub(super) fn ratio(
    parameters: &[(String, quell_expression::Quantity)],
    value: &Value<'_>,
    dimension: Dimension,
) -> Result<f64, Fault> {
    if value.is_number() {
        return value.as_f64();
    }
    let quantity = value.quantity(&parameters, None)?;
    if quantity.dimension.without_angle() == dimension.without_angle() {
        return Ok(quantity.value);
    }
    Err(value.fault(format!(
        "expected {}, found {}",
        super::parameters::as_quantity(dimension.without_angle()),
        super::parameters::as_quantity(quantity.dimension)
    )))
}

/// Indices of the inputs that are motions.
pub(super) fn motions(host: &Host) -> Vec<usize> {
    host.linear
        .inputs
        .iter()
        .enumerate()
        .filter(|(_, input)| input.kind != InputKind::Force)
        .map(|(index, _)| index)
        .collect()
}
