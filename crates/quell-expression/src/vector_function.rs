//! Functions with derivatives, wherever they come from.

mod differences;

pub use differences::FiniteDifferences;

use crate::{Graph, Program, Slot, Workspace};

/// How far derivatives can be trusted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exactness {
    /// To rounding.
    Exact,
    /// By differences: about half of the digits are right.
    Approximate,
}

/// A vector function of a vector, y = f(x), with its Jacobian.
///
/// Evaluation takes `&mut self` for the work space. Where slices are too short a missing input is not-a-number, and as
/// much is written as fits.
pub trait VectorFunction {
    /// Length of x.
    fn inputs(&self) -> usize;

    /// Length of y.
    fn outputs(&self) -> usize;

    /// y at x.
    fn value(&mut self, inputs: &[f64], outputs: &mut [f64]);

    /// y at x, and `jacobian[i*n + j]` = ∂y_i/∂x_j of n inputs.
    fn jacobian(&mut self, inputs: &[f64], outputs: &mut [f64], jacobian: &mut [f64]);

    /// Whether the Jacobian is exact.
    fn exactness(&self) -> Exactness;
}

/// Expressions of a graph with their exact Jacobian, compiled.
#[derive(Debug, Clone)]
pub struct CompiledFunction {
    program: Program,
    workspace: Workspace,
    inputs: usize,
    outputs: usize,
    /// Values, then the Jacobian's entries that are not zero by structure.
    results: Vec<f64>,
    /// Where those entries stand.
    places: Vec<usize>,
}

impl CompiledFunction {
    /// The function of inputs 0 to `inputs` - 1 that the roots are.
    #[must_use]
    pub fn new(graph: &Graph, roots: &[Slot], inputs: usize) -> Self {
        let mut graph = graph.clone();
        let columns: Vec<usize> = (0..inputs).collect();
        let (places, entries): (Vec<usize>, Vec<Slot>) = graph
            .jacobian(roots, &columns)
            .into_iter()
            .enumerate()
            .filter_map(|(place, entry)| Some((place, entry?)))
            .unzip();
        let results = vec![0.0; roots.len() + entries.len()];
        let program = Program::compile(&graph, &[roots.to_vec(), entries], |_| false);
        let mut workspace = Workspace::default();
        program.prepare(&[], &mut workspace);
        Self {
            program,
            workspace,
            inputs,
            outputs: roots.len(),
            results,
            places,
        }
    }

    /// The program: level 0 are the values, level 1 the Jacobian's entries that are not zero by structure.
    #[must_use]
    pub const fn program(&self) -> &Program {
        &self.program
    }
}

impl VectorFunction for CompiledFunction {
    fn inputs(&self) -> usize {
        self.inputs
    }

    fn outputs(&self) -> usize {
        self.outputs
    }

    fn value(&mut self, inputs: &[f64], outputs: &mut [f64]) {
        let whole = outputs.len().min(self.outputs);
        let outputs = outputs.get_mut(..whole).unwrap_or_default();
        self.program
            .evaluate(0, inputs, &mut self.workspace, outputs);
    }

    fn jacobian(&mut self, inputs: &[f64], outputs: &mut [f64], jacobian: &mut [f64]) {
        self.program
            .evaluate(1, inputs, &mut self.workspace, &mut self.results);
        let (values, entries) = self.results.split_at(self.outputs);
        for (output, value) in outputs.iter_mut().zip(values) {
            *output = *value;
        }
        for entry in jacobian.iter_mut().take(self.inputs * self.outputs) {
            *entry = 0.0;
        }
        for (place, entry) in self.places.iter().zip(entries) {
            if let Some(target) = jacobian.get_mut(*place) {
                *target = *entry;
            }
        }
    }

    fn exactness(&self) -> Exactness {
        Exactness::Exact
    }
}
