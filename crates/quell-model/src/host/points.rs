//! End points: coordinates, motions and combinations of them.

use quell_document::{Fault, Value};
use quell_expression::{Dimension, Expression};

use super::file::Host;
use super::system::{Base, Motion};
use crate::form::{SignalNames, linear_form};
use crate::linear::{CoordinateKind, InputKind, Signal};

/// The name of the point that does not move.
const GROUND: &str = "ground";

/// Reads the motion of a point or a relative motion; none for `ground`.
pub(super) fn point(
    host: &Host,
    value: &Value<'_>,
    base: Option<&Base>,
) -> Result<Option<Motion>, Fault> {
    if value.is_text() && value.as_str()?.trim() == GROUND {
        return Ok(None);
    }
    motion(host, value, &value.expression()?, base).map(Some)
}

/// Reads a motion from an expression at `value`.
pub(super) fn motion(
    host: &Host,
    value: &Value<'_>,
    expression: &Expression,
    base: Option<&Base>,
) -> Result<Motion, Fault> {
    let names = SignalNames {
        constants: &host.parameters,
        motions: true,
        ..SignalNames::default()
    };
    let (form, dimension) = linear_form(&host.linear, expression, &names)
        .map_err(|error| Fault::from_expression(value.source(), error))?;
    let kind = if dimension.without_angle() == Dimension::LENGTH {
        CoordinateKind::Translation
    } else if Dimension::ANGLE.accepts(&dimension) {
        CoordinateKind::Rotation
    } else {
        return Err(value.fault(format!(
            "expected a displacement in m or an angle in rad, found one in {dimension}"
        )));
    };
    let mut motion = Motion::none(
        host.linear.coordinates.len(),
        host.linear.inputs.len(),
        kind,
    );
    for (signal, coefficient) in form.terms {
        match signal {
            Signal::Coordinate { index, order: 0 } => motion.coordinates[index] += coefficient,
            Signal::Input { index, order: 0 } => {
                let input = &host.linear.inputs[index];
                if input.kind == InputKind::Force {
                    return Err(value.fault(format!(
                        "`{}` is a force; expected a displacement here",
                        input.name
                    )));
                }
                if base.is_some_and(|base| base.input == index) {
                    return Err(value
                        .fault(format!(
                            "the coordinates are relative to the base that `{}` moves",
                            input.name
                        ))
                        .help("write `ground`, which is the base here"));
                }
                motion.inputs[index] += coefficient;
            }
            _ => {
                return Err(value.fault("expected a displacement, without derivatives and forces"));
            }
        }
    }
    Ok(motion)
}

/// The relative motion a - b of two end points, and whether the second is the ground.
pub(super) fn between(
    host: &Host,
    ends: &[Value<'_>; 2],
    base: Option<&Base>,
) -> Result<(Motion, bool), Fault> {
    let [first, second] = ends;
    let (a, b) = (point(host, first, base)?, point(host, second, base)?);
    let none = |kind| {
        Motion::none(
            host.linear.coordinates.len(),
            host.linear.inputs.len(),
            kind,
        )
    };
    let grounded = b.is_none();
    let (a, b) = match (a, b) {
        (None, None) => return Err(second.fault("both ends are on the ground")),
        (Some(a), None) => {
            let ground = none(a.kind);
            (a, ground)
        }
        (None, Some(b)) => (none(b.kind), b),
        (Some(a), Some(b)) => (a, b),
    };
    if a.kind != b.kind {
        return Err(second
            .fault("one end is a displacement and the other an angle")
            .help("an angle becomes a displacement by its lever arm, such as `0.4 m*theta`"));
    }
    let motion = a.minus(&b);
    if motion.is_free_of_coordinates() {
        return Err(second.fault("no coordinate of the host moves these two points apart"));
    }
    Ok((motion, grounded))
}

/// The two texts of a list `between`.
pub(super) fn pair<'a>(value: &Value<'a>) -> Result<[Value<'a>; 2], Fault> {
    let ends = value.as_array()?;
    let count = ends.len();
    <[Value<'a>; 2]>::try_from(ends)
        .map_err(|_| value.fault(format!("expected two end points, found {count}")))
}
