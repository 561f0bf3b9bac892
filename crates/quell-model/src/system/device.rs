//! Devices and the force laws of their nonlinear elements.

use std::collections::{BTreeMap, BTreeSet};

use quell_expression::{Dimension, Graph, Slot};
use quell_network::{Law, Mechanism};

/// A parameter of a force law.
#[derive(Debug, Clone, PartialEq)]
pub struct LawParameter {
    /// The name in the law.
    pub name: String,
    /// SI dimension.
    pub dimension: Dimension,
    /// Its value unless another is given, SI.
    pub value: f64,
}

/// The force F(x, v, own parameters, the host's parameters) of a nonlinear element.
///
/// x is the element's relative displacement, v = x' its rate; F is positive where it resists stretching, so F v is the
/// power that it takes.
#[derive(Debug, Clone)]
pub struct ForceLaw {
    graph: Graph,
    force: Slot,
    parameters: Vec<LawParameter>,
    /// Graph inputs of the host that follow the law's own parameters.
    host: Vec<usize>,
}

impl ForceLaw {
    /// A law built as operations, from x, v, the own parameters and the host's graph inputs named in `host`.
    pub fn new(
        parameters: Vec<LawParameter>,
        host: Vec<usize>,
        build: impl FnOnce(&mut Graph, Slot, Slot, &[Slot]) -> Slot,
    ) -> Self {
        let mut graph = Graph::default();
        let (x, v) = (graph.input(0), graph.input(1));
        let rest: Vec<Slot> = (0..parameters.len() + host.len())
            .map(|index| graph.input(2 + index))
            .collect();
        let force = build(&mut graph, x, v, &rest);
        Self {
            graph,
            force,
            parameters,
            host,
        }
    }

    /// A law whose force is already an operation of a graph with inputs x, v, own parameters, then those of the host.
    pub(crate) const fn from_graph(
        graph: Graph,
        force: Slot,
        parameters: Vec<LawParameter>,
        host: Vec<usize>,
    ) -> Self {
        Self {
            graph,
            force,
            parameters,
            host,
        }
    }

    /// Its own parameters.
    #[must_use]
    pub fn parameters(&self) -> &[LawParameter] {
        &self.parameters
    }

    fn dependence(&self) -> BTreeSet<usize> {
        self.graph.dependence(&[self.force])
    }

    /// Whether the force depends on the relative displacement.
    #[must_use]
    pub fn depends_on_displacement(&self) -> bool {
        self.dependence().contains(&0)
    }

    /// Whether the force depends on the rate.
    #[must_use]
    pub fn depends_on_rate(&self) -> bool {
        self.dependence().contains(&1)
    }

    /// The force as an operation of another graph.
    pub(crate) fn append(&self, graph: &mut Graph, x: Slot, v: Slot, own: &[Slot]) -> Slot {
        let mut inputs = vec![x, v];
        inputs.extend_from_slice(own);
        for index in &self.host {
            inputs.push(graph.input(*index));
        }
        graph
            .append(&self.graph, &[self.force], &inputs)
            .first()
            .copied()
            .unwrap_or(x)
    }
}

/// A device on a port of a host.
#[derive(Debug, Clone)]
pub struct Device {
    /// What it is called.
    pub name: String,
    /// Index of the port in the host.
    pub port: usize,
    /// Its elements between its nodes.
    pub mechanism: Mechanism,
    laws: BTreeMap<String, ForceLaw>,
    values: BTreeMap<String, f64>,
}

impl Device {
    /// A device whose linear elements have the value one until [`Self::with_value`] says otherwise.
    #[must_use]
    pub const fn new(name: String, port: usize, mechanism: Mechanism) -> Self {
        Self {
            name,
            port,
            mechanism,
            laws: BTreeMap::new(),
            values: BTreeMap::new(),
        }
    }

    /// The same device with the force law of all elements of a declared kind.
    #[must_use]
    pub fn with_law(mut self, declared: &str, law: ForceLaw) -> Self {
        self.laws.insert(declared.to_owned(), law);
        self
    }

    /// The same device with the mechanical value (SI) of a linear element, `c1`, or of a law's parameter, `gas.n`.
    ///
    /// Values can be anything later ([`System::prepare`](super::System::prepare)); those given here are the defaults, and
    /// decide the order of pivots where the host's matrices are not symmetric.
    #[must_use]
    pub fn with_value(mut self, name: &str, value: f64) -> Self {
        self.values.insert(name.to_owned(), value);
        self
    }

    /// The law of an element, where it is nonlinear and has one.
    pub(crate) fn law(&self, element: usize) -> Option<&ForceLaw> {
        match &self.mechanism.elements().get(element)?.law {
            Law::Custom(custom) => self.laws.get(&custom.law),
            Law::Linear(_) => None,
        }
    }

    pub(crate) fn value(&self, name: &str) -> Option<f64> {
        self.values.get(name).copied()
    }
}
