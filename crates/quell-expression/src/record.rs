//! Functions written in Rust, recorded as graphs.

mod real;
mod recorded;

use std::cell::{Cell, RefCell};

pub use real::Real;
pub use recorded::Recorded;

use crate::{CompiledFunction, Graph, Slot};

thread_local! {
    /// Recordings under way, innermost last, each with its number.
    static RECORDINGS: RefCell<Vec<(u64, Graph)>> = const { RefCell::new(Vec::new()) };
    static NEXT: Cell<u64> = const { Cell::new(0) };
}

/// What a function has computed: its outputs as expressions of its inputs.
#[derive(Debug, Clone)]
pub struct Recording {
    /// The operations; input i is argument i.
    pub graph: Graph,
    /// The outputs.
    pub outputs: Vec<Slot>,
    /// Number of inputs.
    pub inputs: usize,
}

impl Recording {
    /// Values and Jacobian, compiled.
    #[must_use]
    pub fn compile(&self) -> CompiledFunction {
        CompiledFunction::new(&self.graph, &self.outputs, self.inputs)
    }
}

/// Ends a recording even if the function panics.
struct Ending;

impl Drop for Ending {
    fn drop(&mut self) {
        RECORDINGS.with_borrow_mut(Vec::pop);
    }
}

/// Runs a function once on symbols for its inputs and keeps what it did with them.
///
/// What does not depend on the inputs, loops and branches on plain numbers included, is fixed as it was in this run; a
/// branch on the inputs is written with [`Real::select`]. A function over any [`Real`] serves both ways:
///
/// ```
/// use quell_expression::{Real, VectorFunction, record};
/// fn spring<R: Real>(x: R, n: i32) -> R {
///     x.powi(n) * 3.0 + x.sin()
/// }
/// let mut function = record(1, |x| vec![spring(x[0], 3)]).compile();
/// let (mut value, mut slope) = ([0.0], [0.0]);
/// function.jacobian(&[2.0], &mut value, &mut slope);
/// assert_eq!(value[0], spring(2.0, 3));
/// assert_eq!(slope[0], 36.0 + 2.0_f64.cos());
/// ```
pub fn record(inputs: usize, function: impl FnOnce(&[Recorded]) -> Vec<Recorded>) -> Recording {
    let number = NEXT.get() + 1;
    NEXT.set(number);
    let mut graph = Graph::default();
    let symbols: Vec<Recorded> = (0..inputs)
        .map(|index| Recorded::symbol(number, graph.input(index)))
        .collect();
    RECORDINGS.with_borrow_mut(|recordings| recordings.push((number, graph)));
    let ending = Ending;
    let results = function(&symbols);
    let outputs = results
        .into_iter()
        .map(|result| recorded::operate(|graph, slot| slot(graph, result)))
        .collect();
    let graph = RECORDINGS.with_borrow_mut(|recordings| {
        recordings
            .last_mut()
            .map(|(_, graph)| std::mem::take(graph))
            .unwrap_or_default()
    });
    drop(ending);
    Recording {
        graph,
        outputs,
        inputs,
    }
}
