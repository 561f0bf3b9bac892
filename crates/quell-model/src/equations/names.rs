//! What names mean in expressions on an equation host.

use std::collections::HashMap;

use quell_expression::{
    Dimension, Expression, ExpressionError, Graph, Lowering, Meaning, Names, Node, Rate, Signature,
    Slot, nearest,
};

use super::host::{EquationHost, Symbol};

/// What an equation host remembers of its file beside what it consists of.
#[derive(Debug, Clone, Default)]
pub(crate) struct Vocabulary {
    /// Named expressions, lowered.
    pub(super) definitions: Vec<(String, Slot, Dimension)>,
    /// Functions with their bodies.
    pub(super) functions: Vec<(Signature, Expression)>,
}

/// Names beyond those of a host: a system's devices, their elements, whatever a study adds.
pub trait ExtraNames {
    /// The value of a name that the host does not know.
    fn value(&self, name: &str) -> Option<(Slot, Dimension)> {
        let _ = name;
        None
    }

    /// The value of a call such as `power(gas)`; none where it is no call of this vocabulary. It goes before the host's
    /// own `force` and `stroke`, which take the names of ports and of the host's elements.
    ///
    /// # Errors
    /// In words, at the argument at fault.
    fn call(
        &self,
        graph: &mut Graph,
        function: &str,
        arguments: &[Expression],
    ) -> Option<Result<(Slot, Dimension), ExpressionError>> {
        let _ = (graph, function, arguments);
        None
    }

    /// The time derivative of a graph input; it goes before what the host says.
    fn rate(&self, input: usize) -> Option<Rate> {
        let _ = input;
        None
    }

    /// The present value of a graph input that is a parameter of the system.
    fn present(&self, input: usize) -> Option<f64> {
        let _ = input;
        None
    }

    /// The names of [`value`](Self::value), for suggestions.
    fn names(&self) -> Vec<&str> {
        Vec::new()
    }

    /// The names that calls take, for suggestions.
    fn parts(&self) -> Vec<&str> {
        Vec::new()
    }
}

/// No further names.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoExtraNames;

impl ExtraNames for NoExtraNames {}

impl EquationHost {
    /// Lowers an expression in the host's vocabulary: coordinates and `'`, states, inputs, parameters, `t`, definitions,
    /// functions, outputs, force symbols of ports, `force(…)` and `stroke(…)` of ports and elements, and further names.
    ///
    /// - `graph`: a copy of the host's, which a caller may have extended;
    /// - `extra`: names the host does not know.
    ///
    /// Returns the slot and its SI dimension.
    ///
    /// # Errors
    /// As [`Lowering::lower`], at places of the expression's own text.
    pub fn lower(
        &self,
        graph: &mut Graph,
        expression: &Expression,
        extra: &dyn ExtraNames,
    ) -> Result<(Slot, Dimension), ExpressionError> {
        let names = self.names(extra);
        Lowering::new(&names).lower(graph, expression)
    }

    /// The host's vocabulary, for a [`Lowering`] of several expressions into one graph.
    #[must_use]
    pub fn names<'a>(&'a self, extra: &'a dyn ExtraNames) -> HostNames<'a> {
        HostNames {
            elsewhere: true,
            ..HostNames::new(self, &[], extra)
        }
    }
}

/// The vocabulary of an equation host, see [`EquationHost::names`].
pub struct HostNames<'a> {
    host: &'a EquationHost,
    meanings: HashMap<&'a str, Meaning<'a>>,
    order: Vec<&'a str>,
    rates: Vec<Rate>,
    /// Whether the host's definitions stand in another text.
    elsewhere: bool,
    extra: &'a dyn ExtraNames,
}

impl<'a> HostNames<'a> {
    /// The names of a host; `pending` are expressions of the file that have no slot yet.
    pub(super) fn new(
        host: &'a EquationHost,
        pending: &'a [(String, Expression)],
        extra: &'a dyn ExtraNames,
    ) -> Self {
        let mut names = Self {
            host,
            meanings: HashMap::new(),
            order: Vec::new(),
            rates: host.rates(),
            elsewhere: false,
            extra,
        };
        for (name, expression) in pending {
            names.add(name, Meaning::Definition(expression));
        }
        for (index, symbol) in host.symbols.iter().enumerate() {
            if let Some((name, dimension)) = host.named(*symbol) {
                names.add(name, Meaning::Input(index, dimension));
            }
        }
        for parameter in &host.parameters {
            let dimension = parameter.value.dimension;
            names.add(&parameter.name, Meaning::Value(parameter.slot, dimension));
        }
        for (name, slot, dimension) in &host.vocabulary.definitions {
            names.add(name, Meaning::Value(*slot, *dimension));
        }
        for output in &host.outputs {
            names.add(&output.name, Meaning::Value(output.value, output.dimension));
        }
        for (signature, body) in &host.vocabulary.functions {
            names.add(&signature.name, Meaning::Function(signature, body));
        }
        names
    }

    /// The first meaning of a name counts.
    fn add(&mut self, name: &'a str, meaning: Meaning<'a>) {
        self.meanings.entry(name).or_insert_with(|| {
            self.order.push(name);
            meaning
        });
    }

    /// `force(NAME)` or `stroke(NAME)` of a port or an element of the host.
    fn part(
        &self,
        graph: &mut Graph,
        function: &str,
        arguments: &[Expression],
    ) -> Result<(Slot, Dimension), ExpressionError> {
        let [
            Expression {
                node: Node::Name(name),
                span,
            },
        ] = arguments
        else {
            let span = arguments.first().map(|one| one.span).unwrap_or_default();
            return Err(ExpressionError::new(
                span,
                format!("`{function}` takes the name of one port, element or part of a device"),
            ));
        };
        if let Some(port) = self.host.ports.iter().find(|port| port.name == *name) {
            return Ok(if function == "force" {
                (graph.input(port.force_input), port.force_dimension)
            } else {
                (port.across, port.dimension)
            });
        }
        let elements = &self.host.elements;
        if let Some(element) = elements.iter().find(|element| element.name == *name) {
            return if function == "stroke" {
                Ok((element.stroke, element.kind.dimension()))
            } else {
                element
                    .force
                    .map(|force| (force, element.kind.force_dimension()))
                    .ok_or_else(|| {
                        ExpressionError::new(*span, format!("`{name}` has no force in time"))
                    })
            };
        }
        let known = self
            .host
            .ports
            .iter()
            .map(|port| port.name.as_str())
            .chain(elements.iter().map(|element| element.name.as_str()))
            .chain(self.extra.parts());
        let error = ExpressionError::new(
            *span,
            format!("there is no port, element or part of a device called `{name}`"),
        );
        Err(match nearest(name, known) {
            Some(near) => error.with_help(format!("did you mean `{near}`?")),
            None => error,
        })
    }
}

impl Names for HostNames<'_> {
    fn resolve(&self, name: &str) -> Option<Meaning<'_>> {
        if let Some(meaning) = self.meanings.get(name) {
            return Some(*meaning);
        }
        let (slot, dimension) = self.extra.value(name)?;
        Some(Meaning::Value(slot, dimension))
    }

    fn names(&self) -> Vec<&str> {
        let mut names = self.order.clone();
        names.extend(self.extra.names());
        names
    }

    fn rate(&self, input: usize) -> Rate {
        if let Some(rate) = self.extra.rate(input) {
            return rate;
        }
        self.rates
            .get(input)
            .cloned()
            .unwrap_or_else(|| Rate::Unknown("the rate of a part of a device".to_owned()))
    }

    fn present(&self, input: usize) -> Option<f64> {
        match self.host.symbols.get(input) {
            Some(Symbol::Parameter { index }) => {
                Some(self.host.parameters.get(*index)?.value.value)
            }
            _ => self.extra.present(input),
        }
    }

    fn dimensionless(&self) -> bool {
        self.host.dimensionless
    }

    fn call(
        &self,
        graph: &mut Graph,
        function: &str,
        arguments: &[Expression],
    ) -> Option<Result<(Slot, Dimension), ExpressionError>> {
        self.extra
            .call(graph, function, arguments)
            .or_else(|| match function {
                "force" | "stroke" => Some(self.part(graph, function, arguments)),
                _ => None,
            })
    }

    fn elsewhere(&self, _: &str) -> bool {
        self.elsewhere
    }
}

impl EquationHost {
    /// The name of a graph input that has one in expressions, and its dimension.
    fn named(&self, symbol: Symbol) -> Option<(&str, Dimension)> {
        match symbol {
            Symbol::Time if self.dimensionless => Some(("t", Dimension::NONE)),
            Symbol::Time => Some(("t", Dimension::TIME)),
            Symbol::Coordinate { index, order: 0 } => {
                let coordinate = self.coordinates.get(index)?;
                Some((&coordinate.name, coordinate.dimension))
            }
            Symbol::State { index } => {
                let state = self.states.get(index)?;
                Some((&state.name, state.dimension))
            }
            Symbol::Input { index, order: 0 } => {
                let input = self.inputs.get(index)?;
                Some((&input.name, input.dimension))
            }
            Symbol::PortForce { index } => {
                let port = self.ports.get(index)?;
                Some((port.force.as_ref()?, port.force_dimension))
            }
            Symbol::Parameter { .. }
            | Symbol::Coordinate { .. }
            | Symbol::StateRate { .. }
            | Symbol::Input { .. }
            | Symbol::Reaction
            | Symbol::Other(_) => None,
        }
    }

    /// How each graph input moves in time.
    #[must_use]
    pub fn rates(&self) -> Vec<Rate> {
        let position: HashMap<Symbol, usize> = self
            .symbols
            .iter()
            .enumerate()
            .map(|(index, symbol)| (*symbol, index))
            .collect();
        let to = |symbol: Symbol, words: String| match position.get(&symbol) {
            Some(index) => Rate::Input(*index),
            None => Rate::Unknown(words),
        };
        let name = |name: Option<&String>| name.map_or("", String::as_str).to_owned();
        self.symbols
            .iter()
            .map(|symbol| match *symbol {
                Symbol::Time => Rate::Constant(1.0),
                Symbol::Parameter { .. } => Rate::Constant(0.0),
                Symbol::Coordinate { index, order } => {
                    let name = name(self.coordinates.get(index).map(|one| &one.name));
                    let next = Symbol::Coordinate {
                        index,
                        order: order + 1,
                    };
                    to(next, format!("the third derivative of `{name}`"))
                }
                // A host made in Rust may do without symbols for rates.
                Symbol::State { index } => match (
                    position.get(&Symbol::StateRate { index }),
                    self.states.get(index),
                ) {
                    (Some(rate), _) => Rate::Input(*rate),
                    (None, Some(state)) => Rate::Value(state.rate),
                    (None, None) => Rate::Unknown("the rate of a state".to_owned()),
                },
                Symbol::StateRate { index } => {
                    let name = name(self.states.get(index).map(|one| &one.name));
                    Rate::Unknown(format!("the second derivative of the state `{name}`"))
                }
                Symbol::Input { index, order } => {
                    let name = name(self.inputs.get(index).map(|one| &one.name));
                    let next = Symbol::Input {
                        index,
                        order: order + 1,
                    };
                    to(next, format!("the third derivative of the input `{name}`"))
                }
                Symbol::PortForce { index } => {
                    let name = name(self.ports.get(index).map(|one| &one.name));
                    Rate::Unknown(format!(
                        "the rate of the device's force on the port `{name}`"
                    ))
                }
                Symbol::Reaction | Symbol::Other(_) => {
                    Rate::Unknown("the rate of a force".to_owned())
                }
            })
            .collect()
    }
}
