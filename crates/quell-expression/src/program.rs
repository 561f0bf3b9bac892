//! Programs: graphs compiled for many evaluations.
//!
//! What makes them quick, in the order of gain: parameters are hoisted; sums of products are one instruction
//! (`rows`); like instructions follow one another (`schedule`) and are decoded once, since a wrong guess of the processor
//! costs more than an operation; a batch shares the decoding among its lanes and computes them in the widest vectors that
//! the machine has, functions such as the sine included (`elementary`); values live in as few registers as their lifetimes
//! allow, so that they stay in the nearest cache. None of it changes a rounding. Measured figures are in CONTRIBUTING.

mod bank;
mod code;
mod compile;
mod rows;
mod schedule;
mod workspace;

use code::Stream;
use pulp::{Arch, Simd, WithSimd};
pub use workspace::{BatchWorkspace, Workspace};

/// Points that a batch evaluates together: of 8, 16 and 32 the quickest for equations of motion.
pub const LANES: usize = 16;

/// Expressions of a [`Graph`](crate::Graph), compiled for repeated evaluation.
///
/// Outputs come in *levels*: evaluating level k computes what levels 0 to k need, each operation once, so that level 0
/// may be values, level 1 their Jacobian, level 2 second derivatives. What depends on parameters only is computed by
/// [`Self::prepare`], once for a set of parameters. Results do not depend on the way of evaluation: a lane of a batch has
/// the bits of the point alone.
///
/// Inputs are numbered as in the graph, parameters among them. No call panics, whatever the lengths: a missing input reads
/// as not-a-number, and outputs are written as many as fit. A work space belongs to the program that prepared it.
///
/// ```
/// use quell_expression::{Graph, Program, Workspace};
/// let mut graph = Graph::default();
/// let (x, k) = (graph.input(0), graph.input(1));
/// let square = graph.multiply(x, x);
/// let energy = graph.multiply(k, square);
/// let slope = graph.jacobian(&[energy], &[0])[0].unwrap();
/// let program = Program::compile(&graph, &[vec![energy], vec![slope]], |input| input == 1);
/// let mut workspace = Workspace::default();
/// program.prepare(&[0.0, 10.0], &mut workspace);
/// let mut outputs = [0.0; 2];
/// program.evaluate(1, &[3.0], &mut workspace, &mut outputs);
/// assert_eq!(outputs, [90.0, 60.0]);
/// ```
#[derive(Debug, Clone, Default)]
pub struct Program {
    /// Operations on parameters and constants, in registers of their own.
    preparation: Stream,
    /// Constants of the preparation, which fill its first registers.
    constants: Vec<f64>,
    /// Inputs that the preparation reads, with their registers.
    parameters: Vec<(u32, u32)>,
    scratch: usize,
    /// Registers of the preparation that fill the first registers of the evaluation.
    kept: Vec<u32>,
    /// Inputs that the evaluation reads; they follow what is kept.
    inputs: Vec<u32>,
    registers: usize,
    levels: Vec<Level>,
}

/// What one level adds.
#[derive(Debug, Clone, Default)]
struct Level {
    stream: Stream,
    /// Registers of its outputs.
    outputs: Vec<u32>,
}

impl Program {
    /// Number of levels.
    #[must_use]
    pub fn levels(&self) -> usize {
        self.levels.len()
    }

    /// Number of outputs of levels 0 to `level`.
    #[must_use]
    pub fn outputs(&self, level: usize) -> usize {
        let levels = self.levels.iter().take(level + 1);
        levels.map(|level| level.outputs.len()).sum()
    }

    /// Number of operations that an evaluation of levels 0 to `level` dispatches.
    #[must_use]
    pub fn operations(&self, level: usize) -> usize {
        let levels = self.levels.iter().take(level + 1);
        levels.map(|level| level.stream.len()).sum()
    }

    /// Number of registers of an evaluation, its working set.
    #[must_use]
    pub const fn registers(&self) -> usize {
        self.registers
    }

    /// Computes what depends on parameters only; of the inputs nothing but parameters is read.
    pub fn prepare(&self, inputs: &[f64], workspace: &mut Workspace) {
        let read = |index: usize| [inputs.get(index).copied().unwrap_or(f64::NAN)];
        self.prepare_with(read, workspace);
    }

    /// Values of levels 0 to `level`, one after the other; of the inputs parameters are not read again.
    pub fn evaluate(
        &self,
        level: usize,
        inputs: &[f64],
        workspace: &mut Workspace,
        outputs: &mut [f64],
    ) {
        let mut outputs = outputs.iter_mut();
        self.evaluate_with(
            level,
            |index| [inputs.get(index).copied().unwrap_or(f64::NAN)],
            workspace,
            |[value]| {
                if let Some(output) = outputs.next() {
                    *output = value;
                }
            },
        );
    }

    /// As [`Self::prepare`], for a batch of points with the same parameters.
    pub fn prepare_batch(&self, inputs: &[f64], workspace: &mut BatchWorkspace) {
        let read = |index: usize| [inputs.get(index).copied().unwrap_or(f64::NAN); LANES];
        self.prepare_with(read, workspace);
    }

    /// As [`Self::prepare`], for a batch of points each with its own parameters.
    pub fn prepare_lanes(&self, inputs: &[[f64; LANES]], workspace: &mut BatchWorkspace) {
        let read = |index: usize| inputs.get(index).copied().unwrap_or([f64::NAN; LANES]);
        self.prepare_with(read, workspace);
    }

    /// As [`Self::evaluate`], for [`LANES`] points: `inputs[i]` holds input i of all of them, and so do outputs.
    pub fn evaluate_batch(
        &self,
        level: usize,
        inputs: &[[f64; LANES]],
        workspace: &mut BatchWorkspace,
        outputs: &mut [[f64; LANES]],
    ) {
        // The widest vectors of the machine; the arithmetic, and with it every bit, is the same.
        Arch::new().dispatch(Together {
            program: self,
            level,
            inputs,
            workspace,
            outputs,
        });
    }

    fn prepare_with<const L: usize>(
        &self,
        input: impl Fn(usize) -> [f64; L],
        workspace: &mut Workspace<L>,
    ) {
        let (registers, scratch) = workspace.sized(self.registers, self.scratch);
        for (register, constant) in scratch.iter_mut().zip(&self.constants) {
            *register = [*constant; L];
        }
        for (index, register) in &self.parameters {
            scratch[*register as usize] = input(*index as usize);
        }
        self.preparation.run(scratch);
        for (register, kept) in registers.iter_mut().zip(&self.kept) {
            *register = scratch[*kept as usize];
        }
    }

    #[expect(
        clippy::inline_always,
        reason = "only what is inlined is compiled for the vectors of the machine"
    )]
    #[inline(always)]
    fn evaluate_with<const L: usize>(
        &self,
        level: usize,
        input: impl Fn(usize) -> [f64; L],
        workspace: &mut Workspace<L>,
        mut output: impl FnMut([f64; L]),
    ) {
        let (registers, _) = workspace.sized(self.registers, 0);
        let places = registers.iter_mut().skip(self.kept.len());
        for (register, index) in places.zip(&self.inputs) {
            *register = input(*index as usize);
        }
        for level in self.levels.iter().take(level + 1) {
            level.stream.run(registers);
            for register in &level.outputs {
                output(registers[*register as usize]);
            }
        }
    }
}

/// An evaluation of a batch. A closure would not do: it is compiled by itself, for any machine.
struct Together<'a> {
    program: &'a Program,
    level: usize,
    inputs: &'a [[f64; LANES]],
    workspace: &'a mut BatchWorkspace,
    outputs: &'a mut [[f64; LANES]],
}

impl WithSimd for Together<'_> {
    type Output = ();

    #[expect(
        clippy::inline_always,
        reason = "only what is inlined is compiled for the vectors of the machine"
    )]
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let mut outputs = self.outputs.iter_mut();
        self.program.evaluate_with(
            self.level,
            #[inline(always)]
            |index| self.inputs.get(index).copied().unwrap_or([f64::NAN; LANES]),
            self.workspace,
            #[inline(always)]
            |values| {
                if let Some(output) = outputs.next() {
                    *output = values;
                }
            },
        );
    }
}
