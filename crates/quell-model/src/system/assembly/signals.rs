//! Signals: quantities of host and devices as operations.

use quell_expression::{Differentiation, Slot};

use super::{Assembled, Assembler};
use crate::equations::Symbol;
use crate::system::elimination::plus;
use crate::system::error::SystemError;
use crate::system::layers::sum_of_products;
use crate::system::motion::{ElementRow, formal_seeds};
use crate::system::watched::{Phase, Quantity, Watched};

impl Assembler<'_> {
    /// Signals as operations with unknowns in them; the graph is that of `assembled` and grows.
    pub(crate) fn watch(
        &mut self,
        assembled: &mut Assembled,
        watched: &[Watched],
    ) -> Result<Vec<Slot>, SystemError> {
        self.inputs = assembled.inputs.clone();
        let mut values = Vec::new();
        for (input, quantity) in self.placeholders {
            values.push((*input, self.quantity(*quantity)?));
        }
        let mut found = Vec::with_capacity(watched.len());
        for item in watched {
            let slot = match item {
                Watched::Quantity(quantity) => self.quantity(*quantity)?,
                Watched::Host(slot) => {
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

    pub(super) fn quantity(&mut self, quantity: Quantity) -> Result<Slot, SystemError> {
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

    pub(super) fn element(&self, device: usize, element: usize) -> Option<(ElementRow, Slot)> {
        self.elements
            .iter()
            .find(|known| known.row.device == device && known.row.element == element)
            .map(|known| (known.row.clone(), known.force))
    }

    pub(super) fn stroke_name(&self, device: usize, element: usize, order: usize) -> String {
        let name = self
            .devices
            .get(device)
            .and_then(|device| device.mechanism.elements().get(element))
            .map(|element| element.name.clone())
            .unwrap_or_default();
        format!("the stroke of `{name}`{}", "'".repeat(order))
    }

    pub(super) fn rates_of_coordinates(&mut self) -> Vec<Slot> {
        (0..self.host.coordinates.len())
            .map(|index| self.inputs.slot(Symbol::Coordinate { index, order: 1 }))
            .collect()
    }

    /// Σ q_i' ∂R_i/∂F.
    pub(super) fn given_to(&mut self, port: usize) -> Option<Slot> {
        let levers = self.across.get(port)?.levers.clone();
        let rates = self.rates_of_coordinates();
        let pairs: Vec<(Option<Slot>, Option<Slot>)> = levers
            .into_iter()
            .zip(rates.into_iter().map(Some))
            .collect();
        sum_of_products(&mut self.inputs.graph, &pairs)
    }

    /// M q' with M = ∂R/∂q''.
    pub(super) fn momenta(&mut self) -> Vec<Option<Slot>> {
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

    pub(super) fn mass(&mut self) -> Vec<Option<Slot>> {
        let accelerations: Vec<usize> = (0..self.host.coordinates.len())
            .map(|index| self.inputs.find(Symbol::Coordinate { index, order: 2 }))
            .collect();
        self.inputs
            .graph
            .jacobian(&self.host.residuals, &accelerations)
    }

    /// -q'·(R - M q'' - forces of ports) + ½ q'ᵀ M' q'.
    pub(super) fn host_power(&mut self, with_inputs: bool) -> Slot {
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
