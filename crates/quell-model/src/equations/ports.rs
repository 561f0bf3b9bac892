//! `[ports.NAME]` of equation hosts.

use quell_document::{Fault, Table, Value};
use quell_expression::{BinaryOperator, Dimension, Expression, Graph, Lowering, Node, Slot, Span};

use super::host::{EquationHost, Measure, Symbol};
use super::place;
use crate::host::keys;
use crate::host::names::Names;

/// The name of the point that does not move.
const GROUND: &str = "ground";

/// A port as typed.
pub(super) struct TypedPort<'a> {
    pub name: String,
    /// The value of `between`, `across` or `at`.
    pub value: Value<'a>,
    pub across: Expression,
    pub force: Option<String>,
    /// Where the symbol of the force stands.
    pub force_place: Option<Value<'a>>,
    pub hangs: bool,
    /// Whether one end is said to be the ground.
    pub grounded: bool,
}

/// Reads `[ports]`; symbols of forces are names like any other.
pub(super) fn typed<'a>(
    table: &Table<'a>,
    symbols: &mut Names,
) -> Result<Vec<TypedPort<'a>>, Fault> {
    let mut names = Names::default();
    let mut ports = Vec::new();
    for (name, span, value) in table.entries() {
        names.define(table.source(), name, span, "a port")?;
        let entry = value.as_table()?;
        entry.check(&keys::PORT)?;
        let ends: Vec<_> = ["between", "across", "at"]
            .into_iter()
            .filter_map(|key| Some((key, entry.get(key)?)))
            .collect();
        let [(key, value)] = &ends[..] else {
            return Err(entry
                .fault(format!(
                    "the port `{name}` needs one of `between`, `across` and `at`"
                ))
                .help("for example `between = [\"x1\", \"ground\"]`"));
        };
        let (across, grounded) = match *key {
            "between" => between(value)?,
            _ => (value.expression()?, *key == "at"),
        };
        let force = entry.get("force");
        if let Some(value) = &force {
            let inner = Span::new(0, value.as_str()?.len());
            symbols.define(
                value.source(),
                value.as_str()?,
                value.text_span(inner),
                "the force of a port",
            )?;
        }
        ports.push(TypedPort {
            name: name.to_owned(),
            value: value.clone(),
            across,
            force: match &force {
                Some(value) => Some(value.as_str()?.to_owned()),
                None => None,
            },
            force_place: force,
            hangs: *key == "at",
            grounded,
        });
    }
    Ok(ports)
}

/// a - b of two end points, and whether one is the ground.
fn between(value: &Value<'_>) -> Result<(Expression, bool), Fault> {
    let ends = value.as_array()?;
    let [first, second] = &ends[..] else {
        return Err(value.fault(format!("expected two end points, found {}", ends.len())));
    };
    let point = |value: &Value<'_>| -> Result<Option<Expression>, Fault> {
        if value.is_text() && value.as_str()?.trim() == GROUND {
            return Ok(None);
        }
        value.expression().map(Some)
    };
    Ok(match (point(first)?, point(second)?) {
        (None, None) => return Err(second.fault("both ends are on the ground")),
        (Some(a), None) => (a, true),
        (None, Some(b)) => {
            let span = b.span;
            let node = Node::Negate(Box::new(b));
            (Expression { node, span }, true)
        }
        (Some(a), Some(b)) => {
            let span = a.span.to(b.span);
            let node = Node::Binary {
                operator: BinaryOperator::Subtract,
                left: Box::new(a),
                right: Box::new(b),
            };
            (Expression { node, span }, false)
        }
    })
}

/// The across-variable of a port in the graph.
pub(super) struct Across {
    pub slot: Slot,
    pub kind: Measure,
    pub grounded: bool,
}

/// Lowers the across-variable of a port and checks that it is a displacement that coordinates move.
pub(super) fn across(
    port: &TypedPort<'_>,
    host: &EquationHost,
    graph: &mut Graph,
    lowering: &mut Lowering<'_>,
) -> Result<Across, Fault> {
    let value = &port.value;
    let (slot, dimension) = lowering
        .lower(graph, &port.across)
        .map_err(|error| place::fault(value.source(), error))?;
    let plain = dimension.without_angle();
    let kind = if host.dimensionless {
        Measure::Number
    } else if plain == Dimension::LENGTH {
        Measure::Translation
    } else if plain.is_none() {
        Measure::Rotation
    } else {
        return Err(value.fault(format!(
            "expected a displacement in m or an angle in rad, found one in {dimension}"
        )));
    };
    let mut moved_by = Vec::new();
    let mut alone = true;
    for input in graph.dependence(&[slot]) {
        match host.symbols.get(input) {
            Some(Symbol::Coordinate { order: 0, .. }) => moved_by.push(input),
            Some(Symbol::Time | Symbol::Input { order: 0, .. }) => alone = false,
            Some(Symbol::Parameter { .. }) => {}
            _ => {
                return Err(value
                    .fault(format!(
                        "the port `{}` is stretched by what is no displacement",
                        port.name
                    ))
                    .help("it may depend on coordinates, inputs, parameters and time, not on rates, states and forces"));
            }
        }
    }
    if moved_by.is_empty() {
        return Err(value.fault("no coordinate of the host moves this port"));
    }
    // One coordinate alone, by a constant factor, is its motion relative to the ground.
    let single = alone && moved_by.len() == 1 && {
        let slopes = graph.jacobian(&[slot], &moved_by);
        slopes
            .iter()
            .flatten()
            .all(|slope| graph.as_constant(*slope).is_some())
    };
    Ok(Across {
        slot,
        kind,
        grounded: port.grounded || single,
    })
}
