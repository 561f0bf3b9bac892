//! Devices and the force laws of their nonlinear elements.

use std::collections::{BTreeMap, BTreeSet};

use quell_expression::{Dimension, Expression, ExpressionError, Graph, Rate, Slot};
use quell_network::{Law, Mechanism};

use crate::equations::{EquationHost, ExtraNames, Symbol};

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
    /// The graph input of x; v and the own parameters follow, and what is before is the host's.
    first: usize,
}

impl ForceLaw {
    /// A law built as operations, from x, v, the own parameters and those graph inputs of the host named in `host`.
    pub fn new(
        parameters: Vec<LawParameter>,
        host: &[usize],
        build: impl FnOnce(&mut Graph, Slot, Slot, &[Slot]) -> Slot,
    ) -> Self {
        let first = host.iter().map(|input| input + 1).max().unwrap_or(0);
        let mut graph = Graph::default();
        let (x, v) = (graph.input(first), graph.input(first + 1));
        let own = (0..parameters.len()).map(|index| first + 2 + index);
        let rest: Vec<Slot> = own
            .chain(host.iter().copied())
            .map(|input| graph.input(input))
            .collect();
        let force = build(&mut graph, x, v, &rest);
        Self {
            graph,
            force,
            parameters,
            first,
        }
    }

    /// A law as text: an expression of `x`, `v`, the own parameters and the host's parameters, definitions and functions
    /// as far as these are of parameters only.
    ///
    /// - `motion`, `force`: SI dimensions of x and F.
    ///
    /// # Errors
    /// As [`EquationHost::lower`]; another dimension than that of a force; anything in it that moves but x and v.
    pub fn lower(
        host: &EquationHost,
        expression: &Expression,
        parameters: Vec<LawParameter>,
        motion: Dimension,
        force: Dimension,
    ) -> Result<Self, ExpressionError> {
        let mut graph = host.graph.clone();
        let first = host.symbols.len();
        let names = LawNames {
            first,
            slots: (0..parameters.len() + 2)
                .map(|index| graph.input(first + index))
                .collect(),
            parameters: &parameters,
            motion,
        };
        let (slot, found) = host.lower(&mut graph, expression, &names)?;
        let literal = graph.as_constant(slot).is_some();
        if !host.dimensionless && !literal && found.without_angle() != force.without_angle() {
            return Err(ExpressionError::new(
                expression.span,
                format!("this is in {found}, but a force in {force} is wanted"),
            ));
        }
        let moving = graph.dependence(&[slot]).into_iter().find(|input| {
            *input < first && !matches!(host.symbols.get(*input), Some(Symbol::Parameter { .. }))
        });
        if moving.is_some() {
            return Err(ExpressionError::new(
                expression.span,
                "the force of an element depends on its own displacement `x`, its rate `v` and parameters only",
            )
            .with_help("what depends on the host's motion belongs into the host's equations"));
        }
        Ok(Self {
            graph,
            force: slot,
            parameters,
            first,
        })
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
        self.dependence().contains(&self.first)
    }

    /// Whether the force depends on the rate.
    #[must_use]
    pub fn depends_on_rate(&self) -> bool {
        self.dependence().contains(&(self.first + 1))
    }

    /// The force as an operation of another graph, in which the host's inputs have the same numbers.
    pub(crate) fn append(&self, graph: &mut Graph, x: Slot, v: Slot, own: &[Slot]) -> Slot {
        let mut inputs: Vec<Slot> = (0..self.first).map(|index| graph.input(index)).collect();
        inputs.extend([x, v]);
        inputs.extend_from_slice(own);
        graph
            .append(&self.graph, &[self.force], &inputs)
            .first()
            .copied()
            .unwrap_or(x)
    }
}

/// x, v and own parameters.
struct LawNames<'a> {
    first: usize,
    slots: Vec<Slot>,
    parameters: &'a [LawParameter],
    motion: Dimension,
}

impl ExtraNames for LawNames<'_> {
    fn value(&self, name: &str) -> Option<(Slot, Dimension)> {
        let (place, dimension) = match name {
            "x" => (0, self.motion),
            "v" => (1, self.motion / Dimension::TIME),
            _ => {
                let found = self
                    .parameters
                    .iter()
                    .position(|parameter| parameter.name == name)?;
                (found + 2, self.parameters.get(found)?.dimension)
            }
        };
        Some((*self.slots.get(place)?, dimension))
    }

    fn rate(&self, input: usize) -> Option<Rate> {
        match input.checked_sub(self.first)? {
            0 => Some(Rate::Input(self.first + 1)),
            1 => Some(Rate::Unknown("the rate of `v`".to_owned())),
            _ => Some(Rate::Constant(0.0)),
        }
    }

    fn present(&self, input: usize) -> Option<f64> {
        let place = input.checked_sub(self.first + 2)?;
        Some(self.parameters.get(place)?.value)
    }

    fn names(&self) -> Vec<&str> {
        let own = self.parameters.iter();
        ["x", "v"]
            .into_iter()
            .chain(own.map(|parameter| parameter.name.as_str()))
            .collect()
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
