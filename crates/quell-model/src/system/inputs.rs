//! Graph inputs of a system: those of the host, values of elements, motions of nodes.

use quell_expression::{Dimension, Graph, Slot};

use super::device::Device;
use super::error::SystemError;
use crate::equations::{EquationHost, Symbol};
use quell_network::Law;

/// Whom a parameter belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Owner {
    /// A primary parameter of the host.
    Host,
    /// The value, or a parameter of the force law, of an element.
    Element {
        /// Index of the device.
        device: usize,
        /// Index of the element in it.
        element: usize,
    },
}

/// A parameter of a system: a number that may change from one evaluation to the next.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Its name: as in the host file, `k1` for an element, `gas.n` for the parameter of a force law.
    pub name: String,
    /// Whom it belongs to.
    pub owner: Owner,
    /// SI dimension; values of elements are mechanical.
    pub dimension: Dimension,
    /// Its default, SI.
    pub value: f64,
    pub(crate) input: usize,
}

/// The graph with its inputs.
#[derive(Debug, Clone)]
pub(crate) struct Inputs {
    pub(crate) graph: Graph,
    pub(crate) symbols: Vec<Symbol>,
    /// A point to look at: where a run begins, what else there is a little off zero.
    pub(crate) sample: Vec<f64>,
    others: usize,
}

impl Inputs {
    pub(crate) fn new(host: &EquationHost) -> Self {
        let others = host.symbols.iter().filter_map(|symbol| match symbol {
            Symbol::Other(number) => Some(number + 1),
            _ => None,
        });
        Self {
            graph: host.graph.clone(),
            symbols: host.symbols.clone(),
            sample: host.start(),
            others: others.max().unwrap_or(0),
        }
    }

    /// The graph input of a symbol, which is added if there is none.
    pub(crate) fn find(&mut self, symbol: Symbol) -> usize {
        if let Some(index) = self.symbols.iter().position(|known| *known == symbol) {
            return index;
        }
        self.add(symbol, 0.0)
    }

    pub(crate) fn slot(&mut self, symbol: Symbol) -> Slot {
        let index = self.find(symbol);
        self.graph.input(index)
    }

    fn add(&mut self, symbol: Symbol, sample: f64) -> usize {
        self.symbols.push(symbol);
        self.sample.push(sample);
        self.symbols.len() - 1
    }

    /// A further input.
    pub(crate) fn other(&mut self, sample: f64) -> usize {
        self.others += 1;
        self.add(Symbol::Other(self.others - 1), sample)
    }

    /// Further inputs for unknowns and motions, off zero by amounts that differ.
    pub(crate) fn others(&mut self, count: usize) -> Vec<usize> {
        (0..count)
            .map(|_| {
                let sample = 1e-3 * (1.0 + (self.symbols.len() as f64 * 0.618_034).fract());
                self.other(sample)
            })
            .collect()
    }

    /// The slots of inputs.
    pub(crate) fn slots(&mut self, inputs: &[usize]) -> Vec<Slot> {
        inputs
            .iter()
            .map(|input| self.graph.input(*input))
            .collect()
    }
}

/// The parameters of a host with devices, and where those of each element begin.
pub(crate) fn parameters(
    host: &EquationHost,
    devices: &[Device],
    inputs: &mut Inputs,
) -> Result<(Vec<Parameter>, Vec<Vec<usize>>), SystemError> {
    let mut all: Vec<Parameter> = host
        .parameters
        .iter()
        .filter_map(|parameter| {
            Some(Parameter {
                name: parameter.name.clone(),
                owner: Owner::Host,
                dimension: parameter.value.dimension,
                value: parameter.value.value,
                input: parameter.input?,
            })
        })
        .collect();
    let mut first = Vec::with_capacity(devices.len());
    for (device, attached) in devices.iter().enumerate() {
        let port = host
            .ports
            .get(attached.port)
            .ok_or_else(|| SystemError::UnknownPort {
                host: host.name.clone(),
                port: attached.port,
            })?;
        let mut places = Vec::new();
        for (element, item) in attached.mechanism.elements().iter().enumerate() {
            places.push(all.len());
            let owner = Owner::Element { device, element };
            match &item.law {
                Law::Linear(linear) => {
                    let value = attached.value(&item.name).unwrap_or(1.0);
                    let static_dimension = port.force_dimension / port.dimension;
                    let dimension = if host.dimensionless {
                        Dimension::NONE
                    } else {
                        (0..linear.element.power())
                            .fold(static_dimension, |dimension, _| dimension * Dimension::TIME)
                    };
                    all.push(Parameter {
                        name: item.name.clone(),
                        owner,
                        dimension,
                        value,
                        input: inputs.other(value),
                    });
                }
                Law::Custom(_) => {
                    let law = attached.law(element).ok_or_else(|| SystemError::NoLaw {
                        device: attached.name.clone(),
                        element: item.name.clone(),
                    })?;
                    for own in law.parameters() {
                        let name = format!("{}.{}", item.name, own.name);
                        let value = attached.value(&name).unwrap_or(own.value);
                        all.push(Parameter {
                            name,
                            owner,
                            dimension: own.dimension,
                            value,
                            input: inputs.other(value),
                        });
                    }
                }
            }
        }
        places.push(all.len());
        first.push(places);
    }
    Ok((all, first))
}
