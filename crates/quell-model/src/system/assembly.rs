//! A host with devices as layers of unknowns and rates of a minimal state.

use std::collections::BTreeSet;

use quell_expression::{Differentiation, Slot};
use quell_network::{Element, Law};

use super::device::Device;
use super::elimination::{combination, plus};
use super::error::SystemError;
use super::inputs::{Inputs, Parameter, parameters};
use super::layers::{Closing, Layer, moved, sum_of_products};
use super::motion::{
    Across, Displacements, ElementRow, Motions, Structure, across, element_motion, formal_seeds,
};
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

    /// Motion of an element as an operation; none where it is in no state.
    fn motion_of(&mut self, row: &ElementRow, order: usize) -> Option<Slot> {
        let rest = self
            .motions
            .along(&mut self.inputs.graph, &row.right, order)
            .ok()?;
        if row.head == 0.0 {
            return Some(element_motion_alone(&mut self.inputs, rest));
        }
        let port = self.devices.get(row.device)?.port;
        let known = self.known_across(port, order)?;
        let own = known;
        Some(element_motion(&mut self.inputs.graph, row.head, own, rest))
    }

    /// x, x' or x'' of a port without those massless coordinates that directions carry with plain numbers.
    fn known_across(&mut self, port: usize, order: usize) -> Option<Slot> {
        let slot = *self.across.get(port)?.motion.get(order)?;
        if self.displacements.massless.is_empty() {
            return Some(slot);
        }
        let mut gone = Vec::new();
        for (place, index) in self.displacements.massless.clone().into_iter().enumerate() {
            if self
                .displacements
                .alone
                .get(place)
                .copied()
                .flatten()
                .is_none()
            {
                for order in 0..3 {
                    gone.push(self.inputs.find(Symbol::Coordinate { index, order }));
                }
            }
        }
        let left = self.inputs.graph.without(&[slot], &gone);
        let left = match left.first().copied().flatten() {
            Some(left) => left,
            None => self.inputs.graph.constant(0.0),
        };
        let coordinates: Vec<(usize, Slot)> = self.replaced.clone();
        self.inputs
            .graph
            .substitute(&[left], &coordinates)
            .first()
            .copied()
    }

    /// Elements' forces, port forces, and what replaces the host's symbols.
    fn find_forces(&mut self) -> Result<(), SystemError> {
        // Massless coordinates by their directions.
        let size = self.displacements.size;
        for (place, index) in self.displacements.massless.clone().into_iter().enumerate() {
            for order in 0..3 {
                let row = unit(size, place);
                let motion = self.motions.along(&mut self.inputs.graph, &row, order);
                let Ok(motion) = motion else { continue };
                let slot = match motion {
                    Some(slot) => slot,
                    None => self.inputs.graph.constant(0.0),
                };
                let input = self.inputs.find(Symbol::Coordinate { index, order });
                self.replaced.push((input, slot));
            }
        }
        for index in 0..self.elements.len() {
            let Some(row) = self.elements.get(index).map(|element| element.row.clone()) else {
                continue;
            };
            let force = self.force_of(&row)?;
            if let Some(element) = self.elements.get_mut(index) {
                element.force = force;
            }
        }
        if self.phase != Phase::Free {
            self.reaction = Some(self.inputs.find(Symbol::Reaction));
        }
        // Forces of ports, then rates of states, in which they may occur.
        let mut forces = Vec::new();
        for (port, known) in self.host.ports.iter().enumerate() {
            let force = match (self.held_port() == Some(port), self.reaction) {
                (true, Some(reaction)) => self.inputs.graph.input(reaction),
                _ => self.devices_on(port),
            };
            forces.push((known.force_input, force));
        }
        self.replaced.extend(forces);
        let rates = self.inputs.graph.substitute(&self.rates, &self.replaced);
        for (index, rate) in rates.iter().enumerate() {
            let input = self.inputs.find(Symbol::StateRate { index });
            self.replaced.push((input, *rate));
        }
        self.rates = rates;
        Ok(())
    }

    fn force_of(&mut self, row: &ElementRow) -> Result<Slot, SystemError> {
        let Some((device, item)) = self
            .devices
            .get(row.device)
            .and_then(|device| Some((device, device.mechanism.elements().get(row.element)?)))
        else {
            return Ok(self.inputs.graph.constant(0.0));
        };
        let places = self
            .first
            .get(row.device)
            .and_then(|first| Some(*first.get(row.element)?..*first.get(row.element + 1)?))
            .unwrap_or(0..0);
        let own: Vec<usize> = self
            .parameters
            .get(places)
            .unwrap_or_default()
            .iter()
            .map(|parameter| parameter.input)
            .collect();
        let missing = || SystemError::NotAState {
            what: format!("the motion of `{}`", item.name),
        };
        match (&item.law, device.law(row.element)) {
            (Law::Linear(linear), _) => {
                let order = match linear.element {
                    Element::Spring => 0,
                    Element::Damper => 1,
                    Element::Inerter | Element::Mass => 2,
                };
                let motion = self.motion_of(row, order).ok_or_else(missing)?;
                let value = own.first().copied().unwrap_or(usize::MAX);
                let value = self.inputs.graph.input(value);
                Ok(self.inputs.graph.multiply(value, motion))
            }
            (Law::Custom(_), Some(law)) => {
                let zero = self.inputs.graph.constant(0.0);
                let x = if law.depends_on_displacement() {
                    self.motion_of(row, 0).ok_or_else(missing)?
                } else {
                    zero
                };
                let v = if law.depends_on_rate() {
                    self.motion_of(row, 1).ok_or_else(missing)?
                } else {
                    zero
                };
                let own = self.inputs.slots(&own);
                Ok(law.append(&mut self.inputs.graph, x, v, &own))
            }
            (Law::Custom(_), None) => Err(SystemError::NoLaw {
                device: device.name.clone(),
                element: item.name.clone(),
            }),
        }
    }

    /// Force of one device at its head.
    fn device_force(&mut self, device: usize) -> Slot {
        let terms: Vec<(f64, Slot)> = self
            .elements
            .iter()
            .filter(|element| element.row.device == device)
            .map(|element| (element.row.head, element.force))
            .collect();
        match combination(&mut self.inputs.graph, &terms) {
            Some(force) => force,
            None => self.inputs.graph.constant(0.0),
        }
    }

    /// Sum of the forces of all devices on a port.
    fn devices_on(&mut self, port: usize) -> Slot {
        let mut sum = None;
        for (index, device) in self.devices.iter().enumerate() {
            if device.port == port {
                let force = self.device_force(index);
                sum = plus(&mut self.inputs.graph, sum, Some(force));
            }
        }
        match sum {
            Some(sum) => sum,
            None => self.inputs.graph.constant(0.0),
        }
    }

    fn replace(&mut self, roots: &[Slot]) -> Vec<Slot> {
        self.inputs.graph.substitute(roots, &self.replaced)
    }

    /// R_i with all forces; `alone` keeps only forces that directions do not carry.
    fn residual(&mut self, coordinate: usize, projected: bool) -> Option<Slot> {
        let raw = *self.host.residuals.get(coordinate)?;
        let place = self.displacements.place(coordinate);
        let carried = projected
            && place.is_some_and(|place| {
                self.displacements
                    .alone
                    .get(place)
                    .copied()
                    .flatten()
                    .is_none()
            });
        let mut found = if carried {
            let gone: Vec<usize> = self
                .host
                .ports
                .iter()
                .enumerate()
                .filter(|(port, _)| self.held_port() != Some(*port))
                .map(|(_, port)| port.force_input)
                .collect();
            self.inputs.graph.without(&[raw], &gone).first().copied()?
        } else {
            Some(raw)
        };
        if let Some(slot) = found {
            found = self.replace(&[slot]).first().copied();
        }
        for (port, known) in self.host.ports.iter().enumerate() {
            let held = self.held_port() == Some(port);
            if known.force.is_some() || (carried && !held) {
                continue;
            }
            let attached = held || self.devices.iter().any(|device| device.port == port);
            let lever = self
                .across
                .get(port)
                .and_then(|across| across.slopes.get(coordinate).copied().flatten());
            if let (Some(lever), true) = (lever, attached) {
                let force = self.inputs.graph.input(known.force_input);
                let power = self.inputs.graph.multiply(force, lever);
                let power = self.replace(&[power]).first().copied();
                found = plus(&mut self.inputs.graph, found, power);
            }
        }
        if let (Phase::Hold(held), Some(reaction)) = (self.phase, self.reaction) {
            let input = self.inputs.find(Symbol::Coordinate {
                index: coordinate,
                order: 0,
            });
            let lever = self.inputs.graph.jacobian(&[held], &[input]);
            if let Some(lever) = lever.first().copied().flatten() {
                let reaction = self.inputs.graph.input(reaction);
                let force = self.inputs.graph.multiply(reaction, lever);
                let force = self.replace(&[force]).first().copied();
                found = plus(&mut self.inputs.graph, found, force);
            }
        }
        found
    }

    /// Σ over a direction of the residuals: elements by what the direction stretches, so that what cancels is absent.
    fn balance(&mut self, direction: &[f64]) -> Slot {
        let mut terms = Vec::new();
        for element in &self.elements {
            terms.push((
                super::structure::dot(&element.row.left, direction),
                element.force,
            ));
        }
        for (place, coordinate) in self.displacements.massless.clone().into_iter().enumerate() {
            let factor = direction.get(place).copied().unwrap_or(0.0);
            if factor != 0.0
                && let Some(residual) = self.residual(coordinate, true)
            {
                terms.push((factor, residual));
            }
        }
        match combination(&mut self.inputs.graph, &terms) {
            Some(sum) => sum,
            None => self.inputs.graph.constant(0.0),
        }
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

    /// Names of directions, `strut.1`, or of the massless coordinate that they are.
    fn direction_name(&self, direction: &[f64]) -> String {
        let largest = direction
            .iter()
            .fold(0.0_f64, |most, entry| most.max(entry.abs()));
        let place = direction
            .iter()
            .position(|entry| entry.abs() >= 0.999 * largest)
            .unwrap_or(0);
        if let Some(coordinate) = self
            .displacements
            .massless
            .get(place)
            .and_then(|index| self.host.coordinates.get(*index))
        {
            return coordinate.name.clone();
        }
        self.displacements
            .nodes
            .iter()
            .zip(self.devices)
            .rev()
            .find(|(first, _)| **first <= place)
            .map_or_else(
                || format!("motion{place}"),
                |(first, device)| format!("{}.{}", device.name, place - first + 1),
            )
    }

    fn states(&mut self) -> Vec<State> {
        let mut states = Vec::new();
        let massive: Vec<usize> = (0..self.host.coordinates.len())
            .filter(|index| self.displacements.place(*index).is_none())
            .collect();
        let motions = self.motions.clone();
        let first_rate = massive.len() + motions.second.len() + motions.first.len();
        for (place, index) in massive.iter().enumerate() {
            states.push(State {
                name: self.host.coordinates[*index].name.clone(),
                kind: StateKind::Position {
                    rate: first_rate + place,
                },
                input: self.inputs.find(Symbol::Coordinate {
                    index: *index,
                    order: 0,
                }),
            });
        }
        for (place, (direction, input)) in
            motions.right.second.iter().zip(&motions.second).enumerate()
        {
            states.push(State {
                name: self.direction_name(direction),
                kind: StateKind::Position {
                    rate: first_rate + massive.len() + place,
                },
                input: *input,
            });
        }
        for (direction, input) in motions.right.first.iter().zip(&motions.first) {
            states.push(State {
                name: self.direction_name(direction),
                kind: StateKind::Displacement,
                input: *input,
            });
        }
        for index in &massive {
            states.push(State {
                name: format!("{}'", self.host.coordinates[*index].name),
                kind: StateKind::Rate,
                input: self.inputs.find(Symbol::Coordinate {
                    index: *index,
                    order: 1,
                }),
            });
        }
        let seconds = motions.right.second.iter().zip(&motions.second_rates);
        let neutral = motions
            .right
            .second_neutral
            .iter()
            .zip(&motions.second_neutral_rates);
        for (direction, input) in seconds.chain(neutral) {
            states.push(State {
                name: format!("{}'", self.direction_name(direction)),
                kind: StateKind::Rate,
                input: *input,
            });
        }
        for (index, state) in self.host.states.iter().enumerate() {
            states.push(State {
                name: state.name.clone(),
                kind: StateKind::FirstOrder,
                input: self.inputs.find(Symbol::State { index }),
            });
        }
        states
    }

    /// Rates in the order of [`Self::states`].
    fn state_rates(&mut self, states: &[State], massive: &[usize]) -> Vec<Slot> {
        let mut rates = Vec::with_capacity(states.len());
        for index in massive {
            rates.push(self.inputs.slot(Symbol::Coordinate {
                index: *index,
                order: 1,
            }));
        }
        let motions = self.motions.clone();
        rates.extend(self.inputs.slots(&motions.second_rates));
        rates.extend(self.inputs.slots(&motions.first_rates));
        for index in massive {
            rates.push(self.inputs.slot(Symbol::Coordinate {
                index: *index,
                order: 2,
            }));
        }
        rates.extend(self.inputs.slots(&motions.second_accelerations));
        rates.extend(self.inputs.slots(&motions.second_neutral_accelerations));
        rates.extend(&self.rates);
        rates
    }

    /// Where a run begins: the host as it says; within devices springs unstretched and inerters at rest as far as
    /// possible, where not as evenly as possible.
    fn start(&mut self, states: &[State]) -> Vec<Slot> {
        let host = self.host;
        let mut begin = Vec::new();
        for (index, coordinate) in host.coordinates.iter().enumerate() {
            for (order, slot) in [coordinate.start, coordinate.rate].into_iter().enumerate() {
                begin.push((self.inputs.find(Symbol::Coordinate { index, order }), slot));
            }
        }
        for (index, state) in host.states.iter().enumerate() {
            begin.push((self.inputs.find(Symbol::State { index }), state.start));
        }
        let mut found: Vec<(usize, Slot)> = begin.clone();
        let size = self.displacements.size;
        let count = self.displacements.massless.len();
        let components = self.motions.right.components(size);
        let elements: Vec<ElementState> = self.elements.clone();
        for order in 0..2 {
            // Rows of what is to be unstretched, over nodes; the head's part is given.
            let chosen: Vec<&ElementRow> = elements
                .iter()
                .map(|element| &element.row)
                .filter(|row| {
                    let law = self
                        .devices
                        .get(row.device)
                        .and_then(|device| device.mechanism.elements().get(row.element))
                        .map(|item| &item.law);
                    law.is_some_and(|law| {
                        if order == 0 {
                            law.is_spring_like()
                        } else {
                            law.is_inertial()
                        }
                    })
                })
                .collect();
            let over_nodes: Vec<Vec<f64>> = chosen
                .iter()
                .map(|row| row.nodes.get(count..).unwrap_or_default().to_vec())
                .collect();
            let share = super::structure::least_squares(&over_nodes, size - count);
            let mut displacement: Vec<Option<Slot>> = self
                .displacements
                .massless
                .iter()
                .map(|index| {
                    let coordinate = host.coordinates.get(*index)?;
                    Some(if order == 0 {
                        coordinate.start
                    } else {
                        coordinate.rate
                    })
                })
                .collect();
            for row in &share {
                let mut terms = Vec::new();
                for (factor, element) in row.iter().zip(&chosen) {
                    let port = self
                        .devices
                        .get(element.device)
                        .map_or(0, |device| device.port);
                    let factor = super::structure::dot(&[*factor], &[element.head]);
                    if let (true, Some(across)) = (factor != 0.0, self.across.get(port)) {
                        terms.push((factor, across.motion[order]));
                    }
                }
                let slot = combination(&mut self.inputs.graph, &terms);
                displacement.push(slot.and_then(|slot| {
                    self.inputs
                        .graph
                        .substitute(&[slot], &begin)
                        .first()
                        .copied()
                }));
            }
            let groups = self.motions.right.counts();
            let offsets: Vec<usize> = groups
                .iter()
                .scan(0, |sum, count| {
                    let first = *sum;
                    *sum += count;
                    Some(first)
                })
                .collect();
            let targets: Vec<(usize, usize)> = if order == 0 {
                let first = self.motions.first.iter().enumerate();
                let second = self.motions.second.iter().enumerate();
                first
                    .map(|(i, input)| (offsets[1] + i, *input))
                    .chain(second.map(|(i, input)| (offsets[4] + i, *input)))
                    .collect()
            } else {
                let second = self.motions.second_rates.iter().enumerate();
                let neutral = self.motions.second_neutral_rates.iter().enumerate();
                second
                    .map(|(i, input)| (offsets[4] + i, *input))
                    .chain(neutral.map(|(i, input)| (offsets[5] + i, *input)))
                    .collect()
            };
            for (component, input) in targets {
                let terms: Vec<(f64, Slot)> = components
                    .get(component)
                    .map(|row| {
                        row.iter()
                            .zip(&displacement)
                            .filter_map(|(factor, slot)| Some((*factor, (*slot)?)))
                            .collect()
                    })
                    .unwrap_or_default();
                let slot = match combination(&mut self.inputs.graph, &terms) {
                    Some(slot) => slot,
                    None => self.inputs.graph.constant(0.0),
                };
                found.push((input, slot));
            }
        }
        states
            .iter()
            .map(|state| {
                found
                    .iter()
                    .find(|(input, _)| *input == state.input)
                    .map_or_else(|| self.inputs.graph.constant(0.0), |(_, slot)| *slot)
            })
            .collect()
    }

    /// Signals as operations with unknowns in them; the graph is that of `assembled` and grows.
    pub(crate) fn watch(
        &mut self,
        assembled: &mut Assembled,
        watched: &[super::watched::Watched],
    ) -> Result<Vec<Slot>, SystemError> {
        self.inputs = assembled.inputs.clone();
        let mut values = Vec::new();
        for (input, quantity) in self.placeholders {
            values.push((*input, self.quantity(*quantity)?));
        }
        let mut found = Vec::with_capacity(watched.len());
        for item in watched {
            let slot = match item {
                super::watched::Watched::Quantity(quantity) => self.quantity(*quantity)?,
                super::watched::Watched::Host(slot) => {
                    let with: Vec<(usize, Slot)> =
                        self.replaced.iter().chain(&values).copied().collect();
                    let found = self.inputs.graph.substitute(&[*slot], &with);
                    found.first().copied().unwrap_or(*slot)
                }
            };
            found.push(slot);
        }
        // Whatever is left of massless coordinates is in no state.
        for slot in &found {
            let depends = self.inputs.graph.dependence(&[*slot]);
            for index in self.displacements.massless.clone() {
                for order in 0..3 {
                    let input = self.inputs.find(Symbol::Coordinate { index, order });
                    if depends.contains(&input) {
                        return Err(SystemError::NotAState {
                            what: self.describe(input),
                        });
                    }
                }
            }
        }
        assembled.inputs = self.inputs.clone();
        Ok(found)
    }

    fn quantity(&mut self, quantity: Quantity) -> Result<Slot, SystemError> {
        let zero = self.inputs.graph.constant(0.0);
        let slot = match quantity {
            Quantity::Time => self.inputs.slot(Symbol::Time),
            Quantity::Coordinate { index, order } => {
                self.inputs.slot(Symbol::Coordinate { index, order })
            }
            Quantity::State { index, rate: false } => self.inputs.slot(Symbol::State { index }),
            Quantity::State { index, rate: true } => {
                return Ok(self.rates.get(index).copied().unwrap_or(zero));
            }
            Quantity::Input { index, order } => self.inputs.slot(Symbol::Input { index, order }),
            Quantity::PortForce { port } => {
                let force = self.host.ports.get(port).map(|port| port.force_input);
                force.map_or(zero, |input| self.inputs.graph.input(input))
            }
            Quantity::PortStroke { port, order } => self
                .across
                .get(port)
                .and_then(|across| across.motion.get(order).copied())
                .unwrap_or(zero),
            Quantity::DeviceForce { device } => return Ok(self.device_force(device)),
            Quantity::ElementForce { device, element } => {
                return Ok(self
                    .element(device, element)
                    .map_or(zero, |(_, force)| force));
            }
            Quantity::ElementStroke {
                device,
                element,
                order,
            } => {
                let Some((row, _)) = self.element(device, element) else {
                    return Ok(zero);
                };
                return self
                    .motion_of(&row, order)
                    .ok_or_else(|| SystemError::NotAState {
                        what: self.stroke_name(device, element, order),
                    });
            }
            Quantity::Reaction => {
                let reaction = self.reaction.ok_or(SystemError::NoReaction)?;
                return Ok(self.inputs.graph.input(reaction));
            }
            Quantity::ElementPower { device, element } => {
                let Some((row, force)) = self.element(device, element) else {
                    return Ok(zero);
                };
                let rate = self
                    .motion_of(&row, 1)
                    .ok_or_else(|| SystemError::NotAState {
                        what: self.stroke_name(device, element, 1),
                    })?;
                return Ok(self.inputs.graph.multiply(force, rate));
            }
            Quantity::DevicePower { device } => {
                let force = self.device_force(device);
                let port = self.devices.get(device).map_or(0, |device| device.port);
                let rate = self
                    .across
                    .get(port)
                    .map_or(zero, |across| across.motion[1]);
                self.inputs.graph.multiply(force, rate)
            }
            Quantity::PortReceived { port } => {
                let force = self.quantity(Quantity::PortForce { port })?;
                let rate = self
                    .across
                    .get(port)
                    .map_or(zero, |across| across.motion[1]);
                self.inputs.graph.multiply(force, rate)
            }
            Quantity::PortPower { port } => {
                let force = self.quantity(Quantity::PortForce { port })?;
                let power = self.given_to(port);
                match power {
                    Some(power) => self.inputs.graph.multiply(force, power),
                    None => zero,
                }
            }
            Quantity::Kinetic => {
                let momentum = self.momenta();
                let rates = self.rates_of_coordinates();
                let pairs: Vec<(Option<Slot>, Option<Slot>)> = momentum
                    .into_iter()
                    .zip(rates.iter().map(|rate| Some(*rate)))
                    .collect();
                let twice = sum_of_products(&mut self.inputs.graph, &pairs);
                let half = self.inputs.graph.constant(0.5);
                twice.map_or(zero, |twice| self.inputs.graph.multiply(half, twice))
            }
            Quantity::HostPower => self.host_power(true),
            Quantity::InputPower => {
                let all = self.host_power(true);
                let without = self.host_power(false);
                self.inputs.graph.subtract(all, without)
            }
            Quantity::ReactionPower => match (self.phase, self.reaction) {
                (Phase::Hold(held), Some(reaction)) => {
                    let rates = self.rates.clone();
                    let seeds: Vec<(usize, Slot)> =
                        formal_seeds(self.host, &mut self.inputs, &rates)
                            .into_iter()
                            .filter(|(input, _)| {
                                matches!(
                                    self.inputs.symbols.get(*input),
                                    Some(Symbol::Coordinate { .. })
                                )
                            })
                            .collect();
                    let rate = self
                        .inputs
                        .graph
                        .tangent(&[held], &seeds, Differentiation::Exact);
                    let reaction = self.inputs.graph.input(reaction);
                    match rate.first().copied().flatten() {
                        Some(rate) => {
                            let power = self.inputs.graph.multiply(reaction, rate);
                            self.inputs.graph.negate(power)
                        }
                        None => zero,
                    }
                }
                _ => zero,
            },
        };
        Ok(self.replace(&[slot]).first().copied().unwrap_or(slot))
    }

    fn element(&self, device: usize, element: usize) -> Option<(ElementRow, Slot)> {
        self.elements
            .iter()
            .find(|known| known.row.device == device && known.row.element == element)
            .map(|known| (known.row.clone(), known.force))
    }

    fn stroke_name(&self, device: usize, element: usize, order: usize) -> String {
        let name = self
            .devices
            .get(device)
            .and_then(|device| device.mechanism.elements().get(element))
            .map(|element| element.name.clone())
            .unwrap_or_default();
        format!("the stroke of `{name}`{}", "'".repeat(order))
    }

    fn rates_of_coordinates(&mut self) -> Vec<Slot> {
        (0..self.host.coordinates.len())
            .map(|index| self.inputs.slot(Symbol::Coordinate { index, order: 1 }))
            .collect()
    }

    /// Σ q_i' ∂R_i/∂F.
    fn given_to(&mut self, port: usize) -> Option<Slot> {
        let levers = self.across.get(port)?.levers.clone();
        let rates = self.rates_of_coordinates();
        let pairs: Vec<(Option<Slot>, Option<Slot>)> = levers
            .into_iter()
            .zip(rates.into_iter().map(Some))
            .collect();
        sum_of_products(&mut self.inputs.graph, &pairs)
    }

    /// M q' with M = ∂R/∂q''.
    fn momenta(&mut self) -> Vec<Option<Slot>> {
        let mass = self.mass();
        let rates = self.rates_of_coordinates();
        mass.chunks(rates.len().max(1))
            .map(|row| {
                let pairs: Vec<(Option<Slot>, Option<Slot>)> = row
                    .iter()
                    .copied()
                    .zip(rates.iter().map(|rate| Some(*rate)))
                    .collect();
                sum_of_products(&mut self.inputs.graph, &pairs)
            })
            .collect()
    }

    fn mass(&mut self) -> Vec<Option<Slot>> {
        let accelerations: Vec<usize> = (0..self.host.coordinates.len())
            .map(|index| self.inputs.find(Symbol::Coordinate { index, order: 2 }))
            .collect();
        self.inputs
            .graph
            .jacobian(&self.host.residuals, &accelerations)
    }

    /// -q'·(R - M q'' - forces of ports) + ½ q'ᵀ M' q'.
    fn host_power(&mut self, with_inputs: bool) -> Slot {
        let mut gone: Vec<usize> = self
            .host
            .ports
            .iter()
            .map(|port| port.force_input)
            .collect();
        for index in 0..self.host.coordinates.len() {
            gone.push(self.inputs.find(Symbol::Coordinate { index, order: 2 }));
        }
        if !with_inputs {
            for index in 0..self.host.inputs.len() {
                for order in 0..3 {
                    gone.push(self.inputs.find(Symbol::Input { index, order }));
                }
            }
        }
        let rest = self.inputs.graph.without(&self.host.residuals, &gone);
        let rates = self.rates_of_coordinates();
        let pairs: Vec<(Option<Slot>, Option<Slot>)> = rest
            .into_iter()
            .zip(rates.iter().map(|rate| Some(*rate)))
            .collect();
        let lost = sum_of_products(&mut self.inputs.graph, &pairs);
        let given = lost.map(|lost| self.inputs.graph.negate(lost));
        // ½ q'ᵀ M' q': from the half of q'ᵀ (M q')' that does not come from q''.
        let mass = self.mass();
        let slots: Vec<Slot> = mass.iter().flatten().copied().collect();
        let first = self.rates.clone();
        let seeds = formal_seeds(self.host, &mut self.inputs, &first);
        let mut slopes = self
            .inputs
            .graph
            .tangent(&slots, &seeds, Differentiation::Exact)
            .into_iter();
        let mut turning = None;
        for (place, entry) in mass.iter().enumerate() {
            let Some(slope) = entry.and_then(|_| slopes.next().flatten()) else {
                continue;
            };
            let (i, j) = (place / rates.len(), place % rates.len());
            let graph = &mut self.inputs.graph;
            let product = graph.multiply(rates[i], rates[j]);
            let product = graph.multiply(slope, product);
            turning = plus(graph, turning, Some(product));
        }
        let half = self.inputs.graph.constant(0.5);
        let turning = turning.map(|turning| self.inputs.graph.multiply(half, turning));
        let sum = plus(&mut self.inputs.graph, given, turning);
        match sum {
            Some(sum) => sum,
            None => self.inputs.graph.constant(0.0),
        }
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

fn element_motion_alone(inputs: &mut Inputs, rest: Option<Slot>) -> Slot {
    match rest {
        Some(rest) => rest,
        None => inputs.graph.constant(0.0),
    }
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
