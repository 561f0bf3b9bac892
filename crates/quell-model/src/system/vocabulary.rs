//! Signals as text.

use std::cell::RefCell;

use quell_expression::{Dimension, Expression, ExpressionError, Graph, Node, Rate, Slot};

use super::compiled::System;
use super::device::Device;
use super::error::SystemError;
use super::watched::{Phase, Quantity, Watched};
use crate::equations::{EquationHost, ExtraNames, Symbol};

/// The vocabulary of a host with devices: what the host's expressions know, and
///
/// | text | quantity |
/// | --- | --- |
/// | `force(NAME)` | force on a port, of a device (at its head), through an element |
/// | `stroke(NAME)`, `stroke(NAME)'` | relative displacement of an element or a port, and its rate |
/// | `power(NAME)` | what a port is given by the coordinates; what a device or an element takes, F x' |
/// | `received(PORT)` | F x' of a port |
/// | `reaction(NAME)` | the force of what is held, whatever its name |
/// | `kinetic(host)` | ½ q'ᵀ M q' of the host's coordinates |
/// | `power(host)`, `power(inputs)`, `power(reaction)` | what the host's own forces, its inputs, what is held give |
///
/// where `NAME` is a port, a device, an element `c1` or, where several devices have it, `device.c1`.
#[derive(Debug)]
pub struct Vocabulary<'a> {
    host: EquationHost,
    devices: &'a [Device],
    names: Names,
}

#[derive(Debug)]
struct Names {
    /// Number of symbols of the host itself; quantities follow.
    first: usize,
    known: RefCell<Vec<Quantity>>,
    /// Names of devices and elements with their quantities' places.
    devices: Vec<(String, usize)>,
    elements: Vec<(String, usize, usize)>,
    parts: Vec<String>,
    /// Dimensions of stroke and force by device, by port.
    by_device: Vec<(Dimension, Dimension)>,
    ports: Vec<(String, Dimension, Dimension)>,
    plain: bool,
}

impl<'a> Vocabulary<'a> {
    /// The vocabulary of a host with devices.
    #[must_use]
    pub fn new(host: &EquationHost, devices: &'a [Device]) -> Self {
        let ports: Vec<(String, Dimension, Dimension)> = host
            .ports
            .iter()
            .map(|port| (port.name.clone(), port.dimension, port.force_dimension))
            .collect();
        let mut elements = Vec::new();
        for (index, device) in devices.iter().enumerate() {
            for (element, item) in device.mechanism.elements().iter().enumerate() {
                elements.push((format!("{}.{}", device.name, item.name), index, element));
                let alone = devices
                    .iter()
                    .filter(|other| other.mechanism.element_index(&item.name).is_some())
                    .count()
                    == 1;
                if alone {
                    elements.push((item.name.clone(), index, element));
                }
            }
        }
        let named: Vec<(String, usize)> = devices
            .iter()
            .enumerate()
            .map(|(index, device)| (device.name.clone(), index))
            .collect();
        let mut parts: Vec<String> = elements.iter().map(|(name, ..)| name.clone()).collect();
        parts.extend(named.iter().map(|(name, _)| name.clone()));
        let names = Names {
            first: host.symbols.len(),
            known: RefCell::default(),
            by_device: devices
                .iter()
                .map(|device| {
                    ports
                        .get(device.port)
                        .map_or((Dimension::NONE, Dimension::NONE), |port| (port.1, port.2))
                })
                .collect(),
            devices: named,
            elements,
            parts,
            ports,
            plain: host.dimensionless,
        };
        Self {
            host: host.clone(),
            devices,
            names,
        }
    }

    /// A signal from text, with its SI dimension.
    ///
    /// # Errors
    /// As [`EquationHost::lower`].
    pub fn lower(
        &mut self,
        expression: &Expression,
    ) -> Result<(Watched, Dimension), ExpressionError> {
        let mut graph = self.host.graph.clone();
        let (slot, dimension) = self.host.lower(&mut graph, expression, &self.names)?;
        self.host.graph = graph;
        Ok((Watched::Host(slot), dimension))
    }

    /// The system in which these signals, all of this vocabulary, are watched.
    ///
    /// # Errors
    /// As [`System::new`].
    pub fn system(&self, watched: &[Watched], phase: Phase) -> Result<System, SystemError> {
        let known = self.names.known.borrow();
        // Only what occurs: a stroke that is watched may be a state more.
        let mut roots: Vec<Slot> = watched
            .iter()
            .filter_map(|item| match item {
                Watched::Host(slot) => Some(*slot),
                Watched::Quantity(_) => None,
            })
            .collect();
        if let Phase::Hold(slot) = phase {
            roots.push(slot);
        }
        let found = self.host.graph.dependence(&roots);
        let placeholders: Vec<(usize, Quantity)> = known
            .iter()
            .enumerate()
            .map(|(place, quantity)| (self.names.first + place, *quantity))
            .filter(|(input, _)| found.contains(input))
            .collect();
        let mut host = self.host.clone();
        for place in 0..known.len() {
            host.symbols.push(Symbol::Other(place));
        }
        System::with_placeholders(&host, &placeholders, self.devices, watched, phase)
    }

    /// What a phase holds: an expression; the across-variable of a port is recognised as such.
    ///
    /// # Errors
    /// As [`EquationHost::lower`].
    pub fn hold(&mut self, expression: &Expression) -> Result<Phase, ExpressionError> {
        let (watched, _) = self.lower(expression)?;
        Ok(match watched {
            Watched::Host(slot) => self
                .host
                .ports
                .iter()
                .position(|port| port.across == slot)
                .map_or(Phase::Hold(slot), Phase::HoldPort),
            Watched::Quantity(_) => Phase::Free,
        })
    }
}

impl Names {
    /// The graph input that stands for a quantity.
    fn input(&self, quantity: Quantity) -> usize {
        let mut known = self.known.borrow_mut();
        let place = known.iter().position(|other| *other == quantity);
        let place = place.unwrap_or_else(|| {
            known.push(quantity);
            known.len() - 1
        });
        self.first + place
    }

    fn dimension(&self, dimension: Dimension) -> Dimension {
        if self.plain {
            Dimension::NONE
        } else {
            dimension
        }
    }

    fn find(&self, function: &str, name: &str) -> Option<(Quantity, Dimension)> {
        let power = |(motion, force): (Dimension, Dimension)| force * motion / Dimension::TIME;
        if let Some(port) = self.ports.iter().position(|(known, ..)| known == name) {
            let (_, motion, force) = self.ports.get(port)?;
            return match function {
                "power" => Some((Quantity::PortPower { port }, power((*motion, *force)))),
                "received" => Some((Quantity::PortReceived { port }, power((*motion, *force)))),
                // The host knows force and stroke of its ports.
                _ => None,
            };
        }
        if let Some((_, device)) = self.devices.iter().find(|(known, _)| known == name) {
            let device = *device;
            let (motion, force) = *self.by_device.get(device)?;
            return match function {
                "force" => Some((Quantity::DeviceForce { device }, force)),
                "power" => Some((Quantity::DevicePower { device }, power((motion, force)))),
                _ => None,
            };
        }
        let (_, device, element) = self.elements.iter().find(|(known, ..)| known == name)?;
        let (device, element) = (*device, *element);
        let (motion, force) = *self.by_device.get(device)?;
        match function {
            "force" => Some((Quantity::ElementForce { device, element }, force)),
            "stroke" => Some((
                Quantity::ElementStroke {
                    device,
                    element,
                    order: 0,
                },
                motion,
            )),
            "power" => Some((
                Quantity::ElementPower { device, element },
                power((motion, force)),
            )),
            _ => None,
        }
    }
}

impl ExtraNames for Names {
    fn call(
        &self,
        graph: &mut Graph,
        function: &str,
        arguments: &[Expression],
    ) -> Option<Result<(Slot, Dimension), ExpressionError>> {
        if ![
            "force", "stroke", "power", "received", "reaction", "kinetic",
        ]
        .contains(&function)
        {
            return None;
        }
        let [
            Expression {
                node: Node::Name(name),
                span,
            },
        ] = arguments
        else {
            return None;
        };
        if function == "kinetic" {
            let input = self.input(Quantity::Kinetic);
            return Some(Ok((graph.input(input), self.dimension(Dimension::ENERGY))));
        }
        if function == "reaction" {
            let force = self
                .ports
                .iter()
                .find(|(known, ..)| known == name)
                .map_or(Dimension::FORCE, |(_, _, force)| *force);
            let input = self.input(Quantity::Reaction);
            return Some(Ok((graph.input(input), self.dimension(force))));
        }
        let whole = match (function, name.as_str()) {
            ("power", "host") => Some(Quantity::HostPower),
            ("power", "inputs") => Some(Quantity::InputPower),
            ("power", "reaction") => Some(Quantity::ReactionPower),
            _ => None,
        };
        if let Some(quantity) = whole {
            let input = self.input(quantity);
            return Some(Ok((graph.input(input), self.dimension(Dimension::POWER))));
        }
        if let Some((quantity, dimension)) = self.find(function, name) {
            let input = self.input(quantity);
            return Some(Ok((graph.input(input), self.dimension(dimension))));
        }
        // Ports' and host elements' forces and strokes are the host's own.
        if matches!(function, "force" | "stroke") {
            return None;
        }
        let known = self
            .parts
            .iter()
            .map(String::as_str)
            .chain(self.ports.iter().map(|(name, ..)| name.as_str()));
        let error = ExpressionError::new(
            *span,
            format!("there is no port, device or element called `{name}`"),
        );
        Some(Err(match quell_expression::nearest(name, known) {
            Some(near) => error.with_help(format!("did you mean `{near}`?")),
            None => error,
        }))
    }

    fn rate(&self, input: usize) -> Option<Rate> {
        let place = input.checked_sub(self.first)?;
        let quantity = *self.known.borrow().get(place)?;
        Some(match quantity {
            Quantity::ElementStroke {
                device,
                element,
                order: 0,
            } => Rate::Input(self.input(Quantity::ElementStroke {
                device,
                element,
                order: 1,
            })),
            _ => Rate::Unknown("the rate of this quantity".to_owned()),
        })
    }

    fn parts(&self) -> Vec<&str> {
        self.parts.iter().map(String::as_str).collect()
    }
}
