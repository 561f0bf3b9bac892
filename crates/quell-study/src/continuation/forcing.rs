//! The period of a forced system as a function of its parameters.

use quell_expression::{Graph, Slot};
use quell_model::EquationHost;
use quell_model::system::System;

/// The period of what forces a system, with its derivatives by the host's parameters.
#[derive(Debug)]
pub(crate) struct Forcing {
    graph: Graph,
    period: Slot,
    /// ∂T/∂p by parameter of the system, where there is one.
    slopes: Vec<Option<Slot>>,
    /// Graph inputs of the system's parameters, as many as the host's come first.
    inputs: Vec<Option<usize>>,
    nominal: Vec<f64>,
}

impl Forcing {
    /// From an operation of the host's graph.
    pub(super) fn new(
        host: &EquationHost,
        mut graph: Graph,
        period: Slot,
        system: &System,
    ) -> Self {
        let inputs: Vec<Option<usize>> = system
            .parameters()
            .iter()
            .map(|parameter| {
                if parameter.owner != quell_model::system::Owner::Host {
                    return None;
                }
                host.parameters
                    .iter()
                    .find(|known| known.name == parameter.name)?
                    .input
            })
            .collect();
        let by: Vec<usize> = inputs.iter().flatten().copied().collect();
        let mut found = graph.jacobian(&[period], &by).into_iter();
        let slopes = inputs
            .iter()
            .map(|input| input.and_then(|_| found.next().flatten()))
            .collect();
        Self {
            graph,
            period,
            slopes,
            inputs,
            nominal: host.nominal(),
        }
    }

    fn point(&self, parameters: &[f64]) -> Vec<f64> {
        let mut point = self.nominal.clone();
        for (input, value) in self.inputs.iter().zip(parameters) {
            if let Some(entry) = input.and_then(|input| point.get_mut(input)) {
                *entry = *value;
            }
        }
        point
    }

    /// T for values of all parameters of the system.
    pub(super) fn period(&self, parameters: &[f64]) -> f64 {
        let found = self.graph.values(&[self.period], &self.point(parameters));
        found.first().copied().unwrap_or(f64::NAN)
    }

    /// ∂T/∂p by parameter of the system.
    pub(super) fn slopes(&self, parameters: &[f64]) -> Vec<f64> {
        let present: Vec<Slot> = self.slopes.iter().flatten().copied().collect();
        let mut values = self
            .graph
            .values(&present, &self.point(parameters))
            .into_iter();
        self.slopes
            .iter()
            .map(|slope| slope.and_then(|_| values.next()).unwrap_or(0.0))
            .collect()
    }
}
