//! `[lagrangian]`: equations of motion from energies.

use quell_document::{Fault, Table, Value};
use quell_expression::{Differentiation, Dimension, Graph, Lowering, Names, Rate, Slot, nearest};

use super::host::{EquationHost, Symbol};
use super::place;
use super::residuals::Residual;
use crate::host::keys;

/// What an energy must not depend on.
#[derive(Clone, Copy, PartialEq)]
enum Highest {
    Position,
    Rate,
    Acceleration,
}

/// The Euler-Lagrange residuals d/dt(∂T/∂q') - ∂T/∂q + ∂V/∂q + ∂D/∂q' - Q, in the order of the coordinates.
pub(super) fn residuals<'a>(
    value: &Value<'a>,
    host: &EquationHost,
    graph: &mut Graph,
    lowering: &mut Lowering<'_>,
    names: &dyn Names,
) -> Result<Vec<Residual<'a>>, Fault> {
    let table = value.as_table()?;
    table.check(&keys::LAGRANGIAN)?;
    let mut reader = Reader {
        host,
        graph,
        lowering,
    };
    let energy = Dimension::ENERGY;
    let kinetic_place = table.require("kinetic")?;
    let kinetic = reader.read(&kinetic_place, energy, Highest::Rate)?;
    let potential = table
        .get("potential")
        .map(|value| reader.read(&value, energy, Highest::Position))
        .transpose()?;
    let dissipation = table
        .get("dissipation")
        .map(|value| reader.read(&value, Dimension::POWER, Highest::Rate))
        .transpose()?;
    let forces = table
        .get("forces")
        .map(|value| reader.forces(&value.as_table()?))
        .transpose()?
        .unwrap_or_else(|| vec![None; host.coordinates.len()]);
    let seeds = seeds(reader.graph, kinetic, &kinetic_place, names)?;
    let mut residuals = Vec::new();
    for (index, (coordinate, force)) in host.coordinates.iter().zip(forces).enumerate() {
        let along = |order| host.input(Symbol::Coordinate { index, order });
        let (Some(position), Some(rate)) = (along(0), along(1)) else {
            continue;
        };
        let graph = &mut *reader.graph;
        let momentum = partial(graph, kinetic, rate);
        let inertia = momentum.and_then(|momentum| {
            graph
                .tangent(&[momentum], &seeds, Differentiation::Formal)
                .into_iter()
                .next()
                .flatten()
        });
        let terms = [
            (inertia, false),
            (partial(graph, kinetic, position), true),
            (potential.and_then(|v| partial(graph, v, position)), false),
            (dissipation.and_then(|d| partial(graph, d, rate)), false),
            (force, true),
        ];
        let mut total: Option<Slot> = None;
        for (term, negative) in terms {
            let Some(term) = term else { continue };
            total = Some(match (total, negative) {
                (None, false) => term,
                (None, true) => graph.negate(term),
                (Some(total), false) => graph.add(total, term),
                (Some(total), true) => graph.subtract(total, term),
            });
        }
        let dimension = if host.dimensionless {
            Dimension::NONE
        } else {
            Dimension::ENERGY / coordinate.dimension
        };
        residuals.push(Residual {
            slot: match total {
                Some(total) => total,
                None => graph.constant(0.0),
            },
            dimension: Some(dimension),
            place: kinetic_place.clone(),
        });
    }
    Ok(residuals)
}

/// Formal partial derivative along an input; none where it is zero by structure.
fn partial(graph: &mut Graph, of: Slot, along: usize) -> Option<Slot> {
    let one = graph.constant(1.0);
    graph
        .tangent(&[of], &[(along, one)], Differentiation::Formal)
        .into_iter()
        .next()
        .flatten()
}

/// The rates of everything the kinetic energy depends on.
fn seeds(
    graph: &mut Graph,
    kinetic: Slot,
    place: &Value<'_>,
    names: &dyn Names,
) -> Result<Vec<(usize, Slot)>, Fault> {
    let mut seeds = Vec::new();
    for input in graph.dependence(&[kinetic]) {
        let rate = match names.rate(input) {
            Rate::Constant(0.0) => continue,
            Rate::Constant(value) => graph.constant(value),
            Rate::Input(index) => graph.input(index),
            Rate::Value(slot) => slot,
            Rate::Unknown(words) => {
                return Err(place.fault(format!(
                    "the equations of motion need {words}, which nothing here says"
                )));
            }
        };
        seeds.push((input, rate));
    }
    Ok(seeds)
}

struct Reader<'r, 'n> {
    host: &'r EquationHost,
    graph: &'r mut Graph,
    lowering: &'r mut Lowering<'n>,
}

impl Reader<'_, '_> {
    fn read(
        &mut self,
        value: &Value<'_>,
        wanted: Dimension,
        highest: Highest,
    ) -> Result<Slot, Fault> {
        let expression = value.expression()?;
        let (slot, dimension) = self
            .lowering
            .lower(self.graph, &expression)
            .map_err(|error| place::fault(value.source(), error))?;
        let zero = self.graph.as_constant(slot) == Some(0.0);
        if !self.host.dimensionless && !zero && dimension.without_angle() != wanted.without_angle()
        {
            return Err(value.fault(format!(
                "expected {}, found {dimension}",
                match wanted {
                    Dimension::ENERGY => "an energy, in N*m".to_owned(),
                    Dimension::POWER => "a power, in W".to_owned(),
                    other => format!("a generalised force in {other}"),
                }
            )));
        }
        for input in self.graph.dependence(&[slot]) {
            let (name, order) = match self.host.symbols.get(input) {
                Some(Symbol::Coordinate { index, order }) => (
                    self.host
                        .coordinates
                        .get(*index)
                        .map_or("", |one| one.name.as_str()),
                    *order,
                ),
                _ => continue,
            };
            let allowed = match highest {
                Highest::Position => 0,
                Highest::Rate => 1,
                Highest::Acceleration => 2,
            };
            if order > allowed {
                return Err(value.fault(format!(
                    "this must not depend on `{name}{}`",
                    "'".repeat(order)
                ))
                .help("T depends on coordinates and rates, V on coordinates, D on rates; whatever else there is goes into `forces`"));
            }
        }
        Ok(slot)
    }

    fn forces(&mut self, table: &Table<'_>) -> Result<Vec<Option<Slot>>, Fault> {
        let mut forces = vec![None; self.host.coordinates.len()];
        for (name, span, value) in table.entries() {
            let names = || {
                self.host
                    .coordinates
                    .iter()
                    .map(|coordinate| coordinate.name.as_str())
            };
            let Some(index) = names().position(|known| known == name) else {
                let fault = Fault::at(
                    table.source(),
                    span,
                    format!("there is no coordinate `{name}`"),
                );
                return Err(match nearest(name, names()) {
                    Some(near) => fault.help(format!("did you mean `{near}`?")),
                    None => fault.help("a generalised force acts on a coordinate"),
                });
            };
            let dimension = self.host.coordinates[index].dimension;
            let force = self.read(&value, Dimension::ENERGY / dimension, Highest::Acceleration)?;
            forces[index] = Some(force);
        }
        Ok(forces)
    }
}
