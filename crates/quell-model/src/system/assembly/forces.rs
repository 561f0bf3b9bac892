//! Forces of elements, and their balance along directions.

use quell_expression::Slot;
use quell_network::{Element, Law};

use super::Assembler;
use crate::equations::Symbol;
use crate::system::elimination::{combination, plus};
use crate::system::error::SystemError;
use crate::system::motion::{ElementRow, element_motion};
use crate::system::structure::{dot, unit};
use crate::system::watched::Phase;

impl Assembler<'_> {
    /// Motion of an element as an operation; none where it is in no state.
    pub(super) fn motion_of(&mut self, row: &ElementRow, order: usize) -> Option<Slot> {
        let rest = self
            .motions
            .along(&mut self.inputs.graph, &row.right, order)
            .ok()?;
        if row.head == 0.0 {
            return Some(rest.unwrap_or_else(|| self.inputs.graph.constant(0.0)));
        }
        let port = self.devices.get(row.device)?.port;
        let known = self.known_across(port, order)?;
        let own = known;
        Some(element_motion(&mut self.inputs.graph, row.head, own, rest))
    }

    /// x, x' or x'' of a port without those massless coordinates that directions carry with plain numbers.
    pub(super) fn known_across(&mut self, port: usize, order: usize) -> Option<Slot> {
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
    pub(super) fn find_forces(&mut self) -> Result<(), SystemError> {
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

    pub(super) fn force_of(&mut self, row: &ElementRow) -> Result<Slot, SystemError> {
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
    pub(super) fn device_force(&mut self, device: usize) -> Slot {
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
    pub(super) fn devices_on(&mut self, port: usize) -> Slot {
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

    pub(super) fn replace(&mut self, roots: &[Slot]) -> Vec<Slot> {
        self.inputs.graph.substitute(roots, &self.replaced)
    }

    /// R_i with all forces; `alone` keeps only forces that directions do not carry.
    pub(super) fn residual(&mut self, coordinate: usize, projected: bool) -> Option<Slot> {
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
    pub(super) fn balance(&mut self, direction: &[f64]) -> Slot {
        let mut terms = Vec::new();
        for element in &self.elements {
            terms.push((dot(&element.row.left, direction), element.force));
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
}
