//! Models written as equations, and the same right-hand sides by hand, for tests and benchmarks.

pub mod gear;
pub mod section;

use std::collections::HashMap;

use quell_expression::{
    Dimension, Expression, Graph, Lowering, Meaning, Names, Program, Rate, Signature, Slot,
};

/// A model of two coordinates in plain numbers.
pub struct Model {
    pub coordinates: [&'static str; 2],
    /// First-order states with their rates.
    pub states: &'static [(&'static str, &'static str)],
    pub parameters: &'static [(&'static str, f64)],
    pub definitions: &'static [(&'static str, &'static str)],
    pub functions: &'static [(&'static str, &'static str)],
    /// What is zero.
    pub residuals: [&'static str; 2],
}

/// Right-hand sides of a model, over states [q1, q2, q1', q2', states…] and then parameters.
pub struct Equations {
    pub graph: Graph,
    pub rates: Vec<Slot>,
    pub states: usize,
    pub parameters: Vec<f64>,
}

struct Vocabulary {
    meanings: HashMap<String, usize>,
    rates: HashMap<usize, usize>,
    definitions: HashMap<String, Expression>,
    functions: HashMap<String, (Signature, Expression)>,
}

impl Names for Vocabulary {
    fn resolve(&self, name: &str) -> Option<Meaning<'_>> {
        if let Some(input) = self.meanings.get(name) {
            return Some(Meaning::Input(*input, Dimension::NONE));
        }
        if let Some(definition) = self.definitions.get(name) {
            return Some(Meaning::Definition(definition));
        }
        let (signature, body) = self.functions.get(name)?;
        Some(Meaning::Function(signature, body))
    }

    fn names(&self) -> Vec<&str> {
        self.meanings.keys().map(String::as_str).collect()
    }

    fn rate(&self, input: usize) -> Rate {
        match self.rates.get(&input) {
            Some(rate) => Rate::Input(*rate),
            None => Rate::Constant(0.0),
        }
    }

    fn dimensionless(&self) -> bool {
        true
    }
}

fn read(text: &str) -> Expression {
    Expression::parse(text).unwrap_or_else(|error| panic!("{text}: {error}"))
}

impl Model {
    /// Lowers the model and solves for the accelerations by Cramer's rule.
    pub fn equations(&self) -> Equations {
        let states = 4 + self.states.len();
        let acceleration = states + self.parameters.len();
        let mut vocabulary = Vocabulary {
            meanings: HashMap::new(),
            rates: HashMap::new(),
            definitions: HashMap::new(),
            functions: HashMap::new(),
        };
        for (index, name) in self.coordinates.iter().enumerate() {
            vocabulary.meanings.insert((*name).to_owned(), index);
            vocabulary.rates.insert(index, index + 2);
            vocabulary.rates.insert(index + 2, index + acceleration);
        }
        for (index, (name, _)) in self.states.iter().enumerate() {
            vocabulary.meanings.insert((*name).to_owned(), 4 + index);
        }
        for (index, (name, _)) in self.parameters.iter().enumerate() {
            vocabulary
                .meanings
                .insert((*name).to_owned(), states + index);
        }
        for (name, text) in self.definitions {
            vocabulary
                .definitions
                .insert((*name).to_owned(), read(text));
        }
        for (head, text) in self.functions {
            let head = Signature::parse(head).unwrap();
            vocabulary
                .functions
                .insert(head.name.clone(), (head, read(text)));
        }
        let mut graph = Graph::default();
        let mut lowering = Lowering::new(&vocabulary);
        let mut lower = |graph: &mut Graph, text: &str| {
            let lowered = lowering.lower(graph, &read(text));
            lowered.unwrap_or_else(|error| panic!("{text}: {error}")).0
        };
        let residuals = self.residuals.map(|text| lower(&mut graph, text));
        let others: Vec<Slot> = self
            .states
            .iter()
            .map(|(_, text)| lower(&mut graph, text))
            .collect();
        let zero = graph.constant(0.0);
        let masses = graph.jacobian(&residuals, &[acceleration, acceleration + 1]);
        let [a, b, c, d] = [0, 1, 2, 3].map(|index| masses[index].unwrap_or(zero));
        let rest = graph.substitute(
            &residuals,
            &[(acceleration, zero), (acceleration + 1, zero)],
        );
        let mut cross = |p: Slot, q: Slot, r: Slot, s: Slot| {
            let (first, second) = (graph.multiply(p, q), graph.multiply(r, s));
            graph.subtract(first, second)
        };
        let determinant = cross(a, d, b, c);
        // [a b; c d] q'' = -[r0, r1]
        let above = [cross(b, rest[1], d, rest[0]), cross(c, rest[0], a, rest[1])];
        let mut rates = vec![graph.input(2), graph.input(3)];
        rates.extend(above.map(|above| graph.divide(above, determinant)));
        rates.extend(others);
        Equations {
            graph,
            rates,
            states,
            parameters: self.parameters.iter().map(|(_, value)| *value).collect(),
        }
    }
}

impl Equations {
    /// Level 0 rates, level 1 the full Jacobian in the states.
    pub fn program(&self) -> Program {
        let mut graph = self.graph.clone();
        let columns: Vec<usize> = (0..self.states).collect();
        let zero = graph.constant(0.0);
        let jacobian = graph.jacobian(&self.rates, &columns);
        let jacobian = jacobian
            .into_iter()
            .map(|entry| entry.unwrap_or(zero))
            .collect();
        let states = self.states;
        Program::compile(&graph, &[self.rates.clone(), jacobian], |input| {
            input >= states
        })
    }

    /// States and parameters together.
    pub fn inputs(&self, states: &[f64]) -> Vec<f64> {
        states.iter().chain(&self.parameters).copied().collect()
    }
}
