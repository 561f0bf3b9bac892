//! `[equations]`: one residual for each coordinate, and what is required of residuals wherever they come from.

use quell_document::{Fault, Table, Value};
use quell_expression::{
    Dimension, Expression, ExpressionError, Graph, Lowering, Node, Slot, Span, nearest,
};

use super::host::{EquationHost, Symbol};
use super::place;

/// A residual with the place of what it comes from.
pub(super) struct Residual<'a> {
    pub slot: Slot,
    /// None where the equation says nothing, being all zeros.
    pub dimension: Option<Dimension>,
    /// The equation.
    pub place: Value<'a>,
}

/// Reads `[equations]`, in the order of the coordinates.
pub(super) fn equations<'a>(
    table: &Table<'a>,
    host: &EquationHost,
    coordinate_places: &[Span],
    graph: &mut Graph,
    lowering: &mut Lowering<'_>,
) -> Result<Vec<Residual<'a>>, Fault> {
    let names = || {
        host.coordinates
            .iter()
            .map(|coordinate| coordinate.name.as_str())
    };
    for (name, span, _) in table.entries() {
        if names().any(|known| known == name) {
            continue;
        }
        let fault = Fault::at(
            table.source(),
            span,
            format!("there is an equation for `{name}`, but no such coordinate"),
        );
        let is_state = host.states.iter().any(|state| state.name == name);
        return Err(match nearest(name, names()) {
            _ if is_state => fault.help(format!(
                "`{name}` is a state: its rate stands under `[states]`"
            )),
            Some(near) => fault.help(format!("did you mean `{near}`?")),
            None => fault.help("an equation has the name of the coordinate that it determines"),
        });
    }
    let mut residuals = Vec::new();
    for (name, place) in names().zip(coordinate_places) {
        let Some(value) = table.get(name) else {
            return Err(Fault::at(
                table.source(),
                *place,
                format!("the coordinate `{name}` has no equation"),
            )
            .help(format!(
                "write one under `[equations]`: `{name} = \"… = 0\"`"
            )));
        };
        residuals.push(equation(value, graph, lowering)?);
    }
    Ok(residuals)
}

/// left - right of an equation.
fn equation<'a>(
    value: Value<'a>,
    graph: &mut Graph,
    lowering: &mut Lowering<'_>,
) -> Result<Residual<'a>, Fault> {
    let text = value.as_str()?;
    let (left, right) = Expression::parse_equation(text).map_err(|error| {
        let span = value.text_span(error.span);
        place::fault(value.source(), ExpressionError { span, ..error })
    })?;
    // Places in the file, as those of definitions and functions are.
    let [left, right] =
        [left, right].map(|side| side.map(&|span| value.text_span(span), &str::to_owned));
    let mut lower = |side: &Expression| {
        lowering
            .lower(graph, side)
            .map(|(slot, dimension)| (slot, (!is_zero(side)).then_some(dimension)))
            .map_err(|error| place::fault(value.source(), error))
    };
    let (a, first) = lower(&left)?;
    let (b, second) = lower(&right)?;
    if let (Some(first), Some(second)) = (first, second)
        && first.without_angle() != second.without_angle()
    {
        return Err(Fault::at(
            value.source(),
            right.span,
            format!("the left side is {first}, but the right side is {second}"),
        ));
    }
    Ok(Residual {
        slot: graph.subtract(a, b),
        dimension: first.or(second),
        place: value,
    })
}

fn is_zero(expression: &Expression) -> bool {
    matches!(expression.node, Node::Number(0.0))
}

/// What tells residual and coordinate apart in messages.
struct Own<'h> {
    name: &'h str,
    massless: bool,
    /// Graph inputs of the coordinate, its rate and its acceleration.
    inputs: [usize; 3],
}

/// Checks that every residual determines its coordinate, and gives it the sign in which inertia is positive.
///
/// `start`: values of all graph inputs where a run begins.
pub(super) fn orient(
    residuals: &mut [Residual<'_>],
    host: &EquationHost,
    graph: &mut Graph,
    start: &[f64],
) -> Result<(), Fault> {
    let position = |symbol| {
        host.symbols
            .iter()
            .position(|known| *known == symbol)
            .unwrap_or(usize::MAX)
    };
    let own: Vec<Own<'_>> = host
        .coordinates
        .iter()
        .enumerate()
        .map(|(index, coordinate)| Own {
            name: &coordinate.name,
            massless: coordinate.massless,
            inputs: [0, 1, 2].map(|order| position(Symbol::Coordinate { index, order })),
        })
        .collect();
    for (residual, own) in residuals.iter_mut().zip(&own) {
        let dependence = graph.dependence(&[residual.slot]);
        let has = own.inputs.map(|input| dependence.contains(&input));
        determines(residual, own, has)?;
        let decisive = if own.massless {
            let order = usize::from(!has[0]);
            own.inputs[order]
        } else {
            own.inputs[2]
        };
        let slope = graph.jacobian(&[residual.slot], &[decisive]);
        let sign = slope
            .first()
            .copied()
            .flatten()
            .and_then(|slope| sign(graph, slope, &host.symbols, start));
        match sign {
            Some(true) => residual.slot = graph.negate(residual.slot),
            Some(false) => {}
            None => {
                let what = match (own.massless, has[0]) {
                    (false, _) => format!("the inertia of `{}`", own.name),
                    (true, true) => format!("the stiffness of `{}`", own.name),
                    (true, false) => format!("the damping of `{}`", own.name),
                };
                return Err(residual
                    .place
                    .fault(format!("{what} is zero at the start, so it has no sign"))
                    .help("devices act against inertia: begin elsewhere, with `start` and `rate`, or write the equation so that its coefficient does not vanish"));
            }
        }
    }
    // Whoever has no mass of its own has no acceleration that an equation could use.
    for residual in residuals.iter() {
        let dependence = graph.dependence(&[residual.slot]);
        for massless in own.iter().filter(|own| own.massless) {
            if dependence.contains(&massless.inputs[2]) {
                return Err(residual
                    .place
                    .fault(format!(
                        "`{name}''` is used here, but `{name}` is massless",
                        name = massless.name
                    ))
                    .help(format!("leave out `massless` of `{}`", massless.name)));
            }
        }
    }
    Ok(())
}

/// Refuses an equation that does not contain what it is to determine.
fn determines(residual: &Residual<'_>, own: &Own<'_>, has: [bool; 3]) -> Result<(), Fault> {
    let name = own.name;
    let place = &residual.place;
    if has == [false; 3] {
        return Err(place
            .fault(format!(
                "the equation of `{name}` does not determine it: neither `{name}` nor `{name}'` nor `{name}''` is in it"
            ))
            .help("each equation stands under the coordinate that follows from it"));
    }
    match (own.massless, has[2]) {
        (false, false) => Err(place
            .fault(format!(
                "the equation of `{name}` does not determine its acceleration: `{name}''` is not in it"
            ))
            .help(format!(
                "if nothing has mass there, write `{name} = {{ massless = true }}` under `[coordinates]`"
            ))),
        (true, true) => Err(place
            .fault(format!("`{name}''` is in the equation of `{name}`, which is massless"))
            .help(format!("leave out `massless` of `{name}`"))),
        _ => Ok(()),
    }
}

/// Whether a coefficient is negative: at the start, or where it vanishes there, near it. None if it is zero all around.
fn sign(graph: &Graph, slope: Slot, symbols: &[Symbol], start: &[f64]) -> Option<bool> {
    (0..=TRIES)
        .map(|attempt| {
            let inputs: Vec<f64> = start
                .iter()
                .zip(symbols)
                .enumerate()
                .map(|(index, (value, symbol))| {
                    if matches!(symbol, Symbol::Parameter { .. }) {
                        return *value;
                    }
                    // Fractional parts of multiples of the golden ratio: in no special position to one another.
                    let spread = ((index + 1) as f64 * 0.618_033_988_749_895).fract() - 0.5;
                    value + f64::from(attempt) * 0.02 * spread
                })
                .collect();
            graph.values(&[slope], &inputs).first().copied()
        })
        .find_map(|value| match value {
            Some(value) if value != 0.0 && value.is_finite() => Some(value < 0.0),
            _ => None,
        })
}

/// How many places near the start are tried.
const TRIES: u8 = 8;

/// Checks that the forces of ports fit the equations to which their virtual work adds them.
pub(super) fn check_virtual_work(
    residuals: &[Residual<'_>],
    host: &EquationHost,
    graph: &mut Graph,
) -> Result<(), Fault> {
    if host.dimensionless {
        return Ok(());
    }
    for port in host.ports.iter().filter(|port| port.force.is_none()) {
        for (index, (coordinate, residual)) in host.coordinates.iter().zip(residuals).enumerate() {
            let symbol = Symbol::Coordinate { index, order: 0 };
            let moves = host
                .input(symbol)
                .is_some_and(|input| graph.depends(port.across, input));
            let Some(own) = residual.dimension else {
                continue;
            };
            let force = port.force_dimension * port.dimension / coordinate.dimension;
            if moves && own.without_angle() != force.without_angle() {
                return Err(residual
                    .place
                    .fault(format!(
                        "this equation is in {own}, but the port `{}` adds a force in {} to it",
                        port.name,
                        force.without_angle()
                    ))
                    .help("write it as a balance of forces (of moments for an angle), or name the port's force by `force = \"…\"` and put it where it belongs"));
            }
        }
    }
    Ok(())
}
