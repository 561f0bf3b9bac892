//! From a graph to a program: what to hoist, in which order to compute, in which registers.

use super::code::{Code, Instruction, Stream};
use super::rows::{Step, Term, has_third_factors, join};
use super::schedule::schedule;
use super::{Level, Program};
use crate::graph::{Differentiation, Graph};
use crate::operation::{Operation, Slot};

/// When a value is known.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Known {
    /// Once the parameters are.
    Prepared,
    /// At each evaluation.
    Varying,
}

impl Program {
    /// Compiles groups of outputs; `is_parameter` says of each input whether it stays while others vary.
    #[must_use]
    pub fn compile(
        graph: &Graph,
        levels: &[Vec<Slot>],
        is_parameter: impl Fn(usize) -> bool,
    ) -> Self {
        let (mut graph, levels) = without_holds(graph, levels);
        let one = graph.constant(1.0);
        let mut known = Vec::with_capacity(graph.len());
        for operation in graph.operations() {
            known.push(match operation {
                Operation::Constant(_) => Known::Prepared,
                Operation::Input(index) if is_parameter(*index as usize) => Known::Prepared,
                Operation::Input(_) => Known::Varying,
                _ => {
                    let mut latest = Known::Prepared;
                    operation.operands(|operand| latest = latest.max(known[operand.index()]));
                    latest
                }
            });
        }
        let mut done = vec![false; graph.len()];
        let mut streams: Vec<Vec<Instruction>> = Vec::with_capacity(levels.len());
        for outputs in &levels {
            let mut stream = Vec::new();
            for slot in graph.needed(outputs, Differentiation::Exact) {
                if known[slot.index()] == Known::Varying && !done[slot.index()] {
                    done[slot.index()] = true;
                    stream.extend(Instruction::of(slot, graph.operation(slot)));
                }
            }
            streams.push(stream);
        }
        let mut read = vec![0_u32; graph.len()];
        for slot in streams.iter().flatten().flat_map(Instruction::reads) {
            read[*slot as usize] += 1;
        }
        for output in levels.iter().flatten() {
            read[output.index()] += 1;
        }
        let streams: Vec<Vec<Step>> = join(streams, &read, one.0)
            .into_iter()
            .map(|stream| schedule(stream, graph.len(), one.0))
            .collect();
        Compiler {
            graph: &graph,
            known: &known,
            one: one.0,
            places: vec![None; graph.len()],
            program: Self::default(),
        }
        .finish(&streams, &levels)
    }
}

/// The same expressions without [`Operation::Hold`], which computes nothing and hides what is equal.
fn without_holds(graph: &Graph, levels: &[Vec<Slot>]) -> (Graph, Vec<Vec<Slot>>) {
    let roots: Vec<Slot> = levels.iter().flatten().copied().collect();
    let mut plain = Graph::default();
    let mut moved: Vec<Slot> = vec![Slot(0); graph.len()];
    for slot in graph.needed(&roots, Differentiation::Exact) {
        let place = match graph.operation(slot) {
            Operation::Hold(a) => moved[a.index()],
            operation => plain.rebuild(operation.map(|operand| moved[operand.index()])),
        };
        moved[slot.index()] = place;
    }
    let levels = levels
        .iter()
        .map(|outputs| {
            let place = |slot: &Slot| match moved.get(slot.index()) {
                Some(place) => *place,
                None => plain.constant(f64::NAN),
            };
            outputs.iter().map(place).collect()
        })
        .collect();
    (plain, levels)
}

struct Compiler<'a> {
    graph: &'a Graph,
    known: &'a [Known],
    /// The slot of the number 1.
    one: u32,
    /// Register of each value that has one at present.
    places: Vec<Option<u32>>,
    program: Program,
}

impl Compiler<'_> {
    fn finish(mut self, streams: &[Vec<Step>], levels: &[Vec<Slot>]) -> Program {
        let reads = streams.iter().flatten().flat_map(Step::reads);
        let mut read: Vec<Slot> = reads
            .map(Slot)
            .chain(levels.iter().flatten().copied())
            .collect();
        read.sort_unstable();
        read.dedup();
        let (kept, varying): (Vec<Slot>, Vec<Slot>) = read
            .into_iter()
            .partition(|slot| self.known[slot.index()] == Known::Prepared);
        self.prepare(&kept);
        self.places.fill(None);
        for (register, slot) in kept.iter().enumerate() {
            self.places[slot.index()] = Some(register as u32);
        }
        let mut registers = kept.len();
        for slot in varying {
            if let Some(input) = self.graph.as_input(slot) {
                self.places[slot.index()] = Some(registers as u32);
                self.program.inputs.push(input as u32);
                registers += 1;
            }
        }
        self.program.registers = registers;
        self.allocate(streams, levels, registers);
        self.program
    }

    /// The stream that computes what is kept, each value in a register of its own.
    fn prepare(&mut self, kept: &[Slot]) {
        let needed = self.graph.needed(kept, Differentiation::Exact);
        for slot in &needed {
            if let Some(value) = self.graph.as_constant(*slot) {
                self.places[slot.index()] = Some(self.program.constants.len() as u32);
                self.program.constants.push(value);
            }
        }
        let mut next = self.program.constants.len() as u32;
        for slot in &needed {
            if self.places[slot.index()].is_some() {
                continue;
            }
            self.places[slot.index()] = Some(next);
            if let Some(input) = self.graph.as_input(*slot) {
                self.program.parameters.push((input as u32, next));
            } else if let Some(instruction) = Instruction::of(*slot, self.graph.operation(*slot)) {
                let renamed = instruction.renamed(next, |read| self.place(read));
                self.program.preparation.push(renamed, []);
            }
            next += 1;
        }
        self.program.scratch = next as usize;
        self.program.kept = kept.iter().map(|slot| self.place(slot.0)).collect();
    }

    fn place(&self, slot: u32) -> u32 {
        // Whatever is read has been computed before; 0 is never taken.
        self.places
            .get(slot as usize)
            .copied()
            .flatten()
            .unwrap_or(0)
    }

    /// Gives every value a register for as long as it is read.
    fn allocate(&mut self, streams: &[Vec<Step>], levels: &[Vec<Slot>], fixed: usize) {
        // The time of a value's last reading; outputs are read at the end of their level.
        let mut last = vec![0_usize; self.graph.len()];
        let mut time = 0;
        for (stream, outputs) in streams.iter().zip(levels) {
            for step in stream {
                time += 1;
                for read in step.reads() {
                    last[read as usize] = time;
                }
            }
            time += 1;
            for output in outputs {
                last[output.index()] = time;
            }
        }
        let mut free: Vec<u32> = Vec::new();
        let mut registers = fixed;
        let mut time = 0;
        for (steps, outputs) in streams.iter().zip(levels) {
            let mut stream = Stream::default();
            for step in steps {
                time += 1;
                let (instruction, terms) = self.encode(step);
                for read in step.reads() {
                    self.release(read, last[read as usize] == time, fixed, &mut free);
                }
                let target = free.pop().unwrap_or_else(|| {
                    registers += 1;
                    (registers - 1) as u32
                });
                self.places[step.target() as usize] = Some(target);
                let instruction = Instruction {
                    target,
                    ..instruction
                };
                stream.push(instruction, terms);
            }
            time += 1;
            let places = outputs.iter().map(|slot| self.place(slot.0)).collect();
            for output in outputs {
                self.release(output.0, last[output.index()] == time, fixed, &mut free);
            }
            self.program.levels.push(Level {
                stream,
                outputs: places,
            });
        }
        self.program.registers = registers;
    }

    /// The instruction of a step and its terms, with the registers that they read.
    fn encode(&self, step: &Step) -> (Instruction, Vec<Term>) {
        match step {
            Step::One(instruction) => (instruction.renamed(0, |read| self.place(read)), Vec::new()),
            Step::Row(_, own) => {
                let place = |term: &Term| Term {
                    a: self.place(term.a),
                    b: self.place(term.b),
                    c: self.place(term.c),
                    mask: term.mask,
                };
                let code = if has_third_factors(own, self.one) {
                    Code::ProductRow
                } else {
                    Code::Row
                };
                let instruction = Instruction {
                    code,
                    target: 0,
                    operands: [0; 4],
                };
                (instruction, own.iter().map(place).collect())
            }
        }
    }

    /// Frees the register of a value that was read for the last time.
    fn release(&mut self, slot: u32, dead: bool, fixed: usize, free: &mut Vec<u32>) {
        if let Some(place) = self.places[slot as usize]
            && dead
            && place as usize >= fixed
        {
            self.places[slot as usize] = None;
            free.push(place);
        }
    }
}
