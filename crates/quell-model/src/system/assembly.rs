//! A host with devices as layers of unknowns and rates of a minimal state.

mod forces;
mod signals;
mod states;

use std::collections::BTreeSet;

use quell_expression::{Differentiation, Slot};

use super::device::Device;
use super::error::SystemError;
use super::inputs::{Inputs, Parameter, parameters};
use super::layers::{Closing, Layer, moved};
use super::motion::{Across, Displacements, ElementRow, Motions, Structure, across, formal_seeds};
use super::structure::unit;
use super::watched::{Phase, Quantity};
use crate::equations::{EquationHost, Symbol};

/// A state of a system.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct State {
    /// `z1`, `z1'`, or for internal motions of devices `strut.1`, `strut.1'` (first node in the direction).
    pub name: String,
    /// Whether it is a displacement (of host or device), its rate, or a first-order state of the host.
    pub kind: StateKind,
    pub(crate) input: usize,
}

/// What a state is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum StateKind {
    /// A displacement whose rate is the state of this index.
    Position {
        /// Index of the state that is its rate.
        rate: usize,
    },
    /// A displacement whose rate follows from equations without inertia.
    Displacement,
    /// A rate.
    Rate,
    /// A first-order state of the host.
    FirstOrder,
}

/// All the operations of a system.
#[derive(Debug, Clone)]
pub(crate) struct Assembled {
    pub(crate) inputs: Inputs,
    pub(crate) parameters: Vec<Parameter>,
    pub(crate) layers: Vec<Layer>,
    pub(crate) closing: Closing,
    pub(crate) states: Vec<State>,
    /// x', with unknowns in it.
    pub(crate) rates: Vec<Slot>,
    /// Where a run begins: of parameters, time and inputs.
    pub(crate) start: Vec<Slot>,
    /// Inputs of time and of the host's inputs with their derivatives.
    pub(crate) time: usize,
    pub(crate) waves: Vec<[usize; 3]>,
}

/// An element with its motion and force.
#[derive(Debug, Clone)]
struct ElementState {
    row: ElementRow,
    force: Slot,
}

pub(crate) struct Assembler<'a> {
    host: &'a EquationHost,
    devices: &'a [Device],
    phase: Phase,
    inputs: Inputs,
    parameters: Vec<Parameter>,
    /// Index into parameters of the first of each element, by device.
    first: Vec<Vec<usize>>,
    /// Rates of the host's first-order states without other such rates in them.
    rates: Vec<Slot>,
    across: Vec<Across>,
    displacements: Displacements,
    motions: Motions,
    elements: Vec<ElementState>,
    reaction: Option<usize>,
    /// What replaces the host's own inputs: massless coordinates, port forces, rates of states.
    replaced: Vec<(usize, Slot)>,
    /// Quantities that expressions hold as inputs.
    placeholders: &'a [(usize, Quantity)],
}

impl<'a> Assembler<'a> {
    pub(crate) fn assemble(
        host: &'a EquationHost,
        placeholders: &'a [(usize, Quantity)],
        devices: &'a [Device],
        wanted: &[Quantity],
        phase: Phase,
    ) -> Result<(Self, Assembled), SystemError> {
        check_devices(host, devices)?;
        let mut inputs = Inputs::new(host);
        let (parameters, first) = parameters(host, devices, &mut inputs)?;
        let rates = closed_rates(host, &mut inputs)?;
        let across = across(host, &mut inputs, &rates);
        let mut assembler = Self {
            host,
            devices,
            phase,
            inputs,
            parameters,
            first,
            rates,
            across,
            displacements: Displacements::new(host, devices),
            motions: Motions::default(),
            elements: Vec::new(),
            reaction: None,
            replaced: Vec::new(),
            placeholders,
        };
        assembler.find_alone();
        let all: Vec<Quantity> = wanted
            .iter()
            .copied()
            .chain(placeholders.iter().map(|(_, quantity)| *quantity))
            .collect();
        assembler.find_motions(&all)?;
        assembler.find_forces()?;
        let assembled = assembler.layers()?;
        Ok((assembler, assembled))
    }

    fn held_port(&self) -> Option<usize> {
        match self.phase {
            Phase::HoldPort(port) => Some(port),
            _ => None,
        }
    }

    /// Massless coordinates at ports with coefficients that are no plain numbers.
    fn find_alone(&mut self) {
        let used: BTreeSet<usize> = self.devices.iter().map(|device| device.port).collect();
        for port in used {
            let Some(across) = self.across.get(port) else {
                continue;
            };
            for (place, coordinate) in self.displacements.massless.iter().enumerate() {
                let bends = [&across.slopes, &across.levers].iter().any(|slots| {
                    slots
                        .get(*coordinate)
                        .copied()
                        .flatten()
                        .is_some_and(|slot| self.inputs.graph.as_constant(slot).is_none())
                });
                if let (true, Some(alone)) = (bends, self.displacements.alone.get_mut(place)) {
                    *alone = Some(port);
                }
            }
        }
    }

    fn find_motions(&mut self, wanted: &[Quantity]) -> Result<(), SystemError> {
        let held = self.held_port();
        let mut rows = Vec::new();
        for (device, attached) in self.devices.iter().enumerate() {
            for element in 0..attached.mechanism.elements().len() {
                rows.push(ElementRow::new(
                    &self.inputs,
                    &self.displacements,
                    self.devices,
                    &self.across,
                    held,
                    device,
                    element,
                ));
            }
        }
        let mut watched = Vec::new();
        for quantity in wanted {
            match *quantity {
                Quantity::ElementStroke {
                    device,
                    element,
                    order,
                } => {
                    if let Some(row) = find_row(&rows, device, element) {
                        watched.push((order, row.right.clone()));
                    }
                }
                Quantity::ElementPower { device, element } => {
                    if let Some(row) = find_row(&rows, device, element) {
                        watched.push((1, row.right.clone()));
                    }
                }
                Quantity::Coordinate { index, order } if order < 2 => {
                    if let Some(place) = self.displacements.place(index) {
                        watched.push((order, unit(self.displacements.size, place)));
                    }
                }
                _ => {}
            }
        }
        let structure = Structure {
            host: self.host,
            devices: self.devices,
            displacements: &self.displacements,
            elements: &rows,
            rates: &self.rates,
        };
        self.motions = structure.motions(&mut self.inputs, &watched)?;
        let nothing = self.inputs.graph.constant(0.0);
        self.elements = rows
            .into_iter()
            .map(|row| ElementState {
                row,
                force: nothing,
            })
            .collect();
        Ok(())
    }

    fn layers(&mut self) -> Result<Assembled, SystemError> {
        let left = self.motions.left.clone();
        let mut layers: Vec<Layer> = Vec::new();
        let massive: Vec<usize> = (0..self.host.coordinates.len())
            .filter(|index| self.displacements.place(*index).is_none())
            .collect();
        let accelerations: Vec<usize> = massive
            .iter()
            .map(|index| {
                self.inputs.find(Symbol::Coordinate {
                    index: *index,
                    order: 2,
                })
            })
            .collect();

        // Algebraic positions.
        let algebraic: Vec<Slot> = left
            .algebraic
            .iter()
            .map(|direction| self.balance(direction))
            .collect();
        let mut later = self.motions.first_rates.clone();
        later.extend(&self.motions.neutral_rates);
        let mut inertial = accelerations.clone();
        inertial.extend(&self.motions.conserved);
        inertial.extend(&self.motions.second_accelerations);
        inertial.extend(&self.motions.second_neutral_accelerations);
        inertial.extend(self.reaction);
        self.refuse(&algebraic, &later, &left.algebraic)?;
        self.refuse(&algebraic, &inertial, &left.algebraic)?;
        self.refuse(
            &algebraic,
            &self.motions.algebraic_rates.clone(),
            &left.algebraic,
        )?;
        let unknowns = self.motions.algebraic.clone();
        self.add_layer(&mut layers, unknowns, algebraic.clone(), &left.algebraic)?;

        // Rates of what has no inertia.
        let directions: Vec<Vec<f64>> = left
            .first
            .iter()
            .chain(&left.first_neutral)
            .cloned()
            .collect();
        let first: Vec<Slot> = directions
            .iter()
            .map(|direction| self.balance(direction))
            .collect();
        self.refuse(&first, &inertial, &directions)?;
        self.refuse(&first, &self.motions.algebraic_rates.clone(), &directions)?;
        self.add_layer(&mut layers, later, first, &directions)?;

        // Accelerations, with the constraint.
        let mut residuals: Vec<Slot> = Vec::new();
        for index in &massive {
            let residual = match self.residual(*index, false) {
                Some(residual) => residual,
                None => self.inputs.graph.constant(0.0),
            };
            residuals.push(residual);
        }
        let mut directions: Vec<Vec<f64>> = massive.iter().map(|_| Vec::new()).collect();
        for direction in left
            .conserved
            .iter()
            .chain(&left.second)
            .chain(&left.second_neutral)
        {
            residuals.push(self.balance(direction));
            directions.push(direction.clone());
        }
        if self.reaction.is_some() {
            residuals.push(self.constraint()?);
            directions.push(Vec::new());
        }
        self.refuse(
            &residuals,
            &self.motions.algebraic_rates.clone(),
            &directions,
        )?;
        self.add_layer(&mut layers, inertial, residuals, &directions)?;

        // Rates of algebraic positions, for what is watched.
        let states = self.states();
        let rates = self.state_rates(&states, &massive);
        if !algebraic.is_empty() {
            let mut seeds: Vec<(usize, Slot)> = states
                .iter()
                .map(|state| state.input)
                .zip(rates.iter().copied())
                .collect();
            let (positions, slopes) = (
                self.motions.algebraic.clone(),
                self.motions.algebraic_rates.clone(),
            );
            let slopes_of = self.inputs.slots(&slopes);
            seeds.extend(positions.into_iter().zip(slopes_of));
            seeds.extend(self.time_seeds());
            let moving = self
                .inputs
                .graph
                .tangent(&algebraic, &seeds, Differentiation::Exact);
            let residuals: Vec<Slot> = moving
                .into_iter()
                .map(|slot| slot.unwrap_or_else(|| self.inputs.graph.constant(0.0)))
                .collect();
            self.add_layer(&mut layers, slopes, residuals, &left.algebraic)?;
        }
        let closing = Closing::new(&layers, &mut self.inputs.graph);
        let start = self.start(&states);
        let time = self.inputs.find(Symbol::Time);
        let waves = (0..self.host.inputs.len())
            .map(|index| [0, 1, 2].map(|order| self.inputs.find(Symbol::Input { index, order })))
            .collect();
        Ok(Assembled {
            inputs: self.inputs.clone(),
            parameters: self.parameters.clone(),
            layers,
            closing,
            states,
            rates,
            start,
            time,
            waves,
        })
    }

    fn time_seeds(&mut self) -> Vec<(usize, Slot)> {
        let rates = self.rates.clone();
        let all = formal_seeds(self.host, &mut self.inputs, &rates);
        all.into_iter()
            .filter(|(input, _)| {
                matches!(
                    self.inputs.symbols.get(*input),
                    Some(Symbol::Time | Symbol::Input { .. })
                )
            })
            .collect()
    }

    /// E'' = 0 of what is held.
    fn constraint(&mut self) -> Result<Slot, SystemError> {
        let second = match self.phase {
            Phase::HoldPort(port) => self.across.get(port).map(|across| across.motion[2]),
            Phase::Hold(held) => {
                let rates = self.rates.clone();
                let seeds = formal_seeds(self.host, &mut self.inputs, &rates);
                let graph = &mut self.inputs.graph;
                let mut slot = Some(held);
                for _ in 0..2 {
                    slot = slot.and_then(|slot| {
                        graph
                            .tangent(&[slot], &seeds, Differentiation::Exact)
                            .first()
                            .copied()
                            .flatten()
                    });
                }
                slot
            }
            Phase::Free => None,
        };
        let second = second.ok_or(SystemError::HoldNothing)?;
        let depends = self.inputs.graph.dependence(&[second]);
        for index in self.displacements.massless.clone() {
            let input = self.inputs.find(Symbol::Coordinate { index, order: 2 });
            if depends.contains(&input) {
                return Err(SystemError::HoldMassless(
                    self.host
                        .coordinates
                        .get(index)
                        .map(|coordinate| coordinate.name.clone())
                        .unwrap_or_default(),
                ));
            }
        }
        self.replace(&[second])
            .first()
            .copied()
            .ok_or(SystemError::HoldNothing)
    }

    /// Refuses equations in which something occurs that must not.
    fn refuse(
        &self,
        residuals: &[Slot],
        unwanted: &[usize],
        directions: &[Vec<f64>],
    ) -> Result<(), SystemError> {
        for (residual, direction) in residuals.iter().zip(directions) {
            let found = self.inputs.graph.dependence(&[*residual]);
            if let Some(input) = unwanted.iter().find(|input| found.contains(input)) {
                return Err(SystemError::Order {
                    what: self
                        .displacements
                        .largest(self.host, self.devices, direction),
                    other: self.describe(*input),
                });
            }
        }
        Ok(())
    }

    fn describe(&self, input: usize) -> String {
        match self.inputs.symbols.get(input) {
            Some(Symbol::Coordinate { index, order }) => format!(
                "`{}{}`",
                self.host
                    .coordinates
                    .get(*index)
                    .map_or("", |coordinate| coordinate.name.as_str()),
                "'".repeat(*order)
            ),
            Some(Symbol::Reaction) => "the reaction of what is held".to_owned(),
            _ => "a rate that it should not depend on".to_owned(),
        }
    }

    fn add_layer(
        &mut self,
        layers: &mut Vec<Layer>,
        unknowns: Vec<usize>,
        residuals: Vec<Slot>,
        directions: &[Vec<f64>],
    ) -> Result<(), SystemError> {
        if unknowns.is_empty() {
            return Ok(());
        }
        let names = unknowns.clone();
        let layer = Layer::new(
            &mut self.inputs.graph,
            unknowns,
            residuals,
            &self.inputs.sample,
        )
        .map_err(|index| SystemError::Undetermined {
            what: match directions.get(index) {
                Some(direction) if !direction.is_empty() => {
                    self.displacements
                        .largest(self.host, self.devices, direction)
                }
                _ => names
                    .get(index)
                    .map_or_else(String::new, |input| self.describe(*input)),
            },
        })?;
        layers.push(layer);
        Ok(())
    }
}

impl Assembled {
    /// Seeds of everything that moves along a direction of the states: `slots[i]` is the rate of state i.
    pub(crate) fn along(&mut self, slots: &[Slot]) -> Vec<(usize, Slot)> {
        let seeds: Vec<(usize, Slot)> = self
            .states
            .iter()
            .map(|state| state.input)
            .zip(slots.iter().copied())
            .collect();
        moved(&self.layers, &mut self.inputs.graph, &seeds)
    }

    /// ∂root/∂input of each input, unknowns following, row-major.
    pub(crate) fn jacobian(&mut self, roots: &[Slot], by: &[usize]) -> Vec<Option<Slot>> {
        let one = self.inputs.graph.constant(1.0);
        let mut jacobian = vec![None; roots.len() * by.len()];
        for (column, input) in by.iter().enumerate() {
            let seeds = moved(&self.layers, &mut self.inputs.graph, &[(*input, one)]);
            let slopes = self
                .inputs
                .graph
                .tangent(roots, &seeds, Differentiation::Exact);
            for (row, slope) in slopes.into_iter().enumerate() {
                jacobian[row * by.len() + column] = slope;
            }
        }
        jacobian
    }

    /// Graph inputs of unknowns that have no expression.
    pub(crate) fn implicit(&self) -> impl Iterator<Item = &Layer> {
        self.layers.iter().filter(|layer| layer.solution.is_none())
    }

    pub(crate) fn close(&mut self, roots: &[Slot]) -> Vec<Slot> {
        self.closing.close(&mut self.inputs.graph, roots)
    }
}

fn find_row(rows: &[ElementRow], device: usize, element: usize) -> Option<&ElementRow> {
    rows.iter()
        .find(|row| row.device == device && row.element == element)
}

fn check_devices(host: &EquationHost, devices: &[Device]) -> Result<(), SystemError> {
    for device in devices {
        let Some(port) = host.ports.get(device.port) else {
            return Err(SystemError::UnknownPort {
                host: host.name.clone(),
                port: device.port,
            });
        };
        let mass = device.mechanism.contains_mass();
        if mass && !port.grounded && !port.hangs {
            return Err(SystemError::MassBetween {
                device: device.name.clone(),
                port: port.name.clone(),
            });
        }
        if port.hangs && !mass {
            return Err(SystemError::NoMass {
                device: device.name.clone(),
                port: port.name.clone(),
            });
        }
    }
    Ok(())
}

/// Rates of first-order states in which no other such rate occurs.
fn closed_rates(host: &EquationHost, inputs: &mut Inputs) -> Result<Vec<Slot>, SystemError> {
    let mut rates: Vec<Slot> = host.states.iter().map(|state| state.rate).collect();
    let places: Vec<usize> = (0..rates.len())
        .map(|index| inputs.find(Symbol::StateRate { index }))
        .collect();
    for _ in 0..=rates.len() {
        let depends = inputs.graph.dependence(&rates);
        if !places.iter().any(|place| depends.contains(place)) {
            return Ok(rates);
        }
        let with: Vec<(usize, Slot)> = places.iter().copied().zip(rates.clone()).collect();
        rates = inputs.graph.substitute(&rates, &with);
    }
    let name = host
        .states
        .iter()
        .zip(&rates)
        .find(|(_, rate)| {
            let depends = inputs.graph.dependence(&[**rate]);
            places.iter().any(|place| depends.contains(place))
        })
        .map(|(state, _)| state.name.clone())
        .unwrap_or_default();
    Err(SystemError::RateCycle(name))
}
