//! Instructions, and the one loop that runs them.

#![expect(
    clippy::inline_always,
    reason = "only what is inlined is compiled for the vectors of the machine"
)]

use super::bank::{Bank, SMALL};
use super::rows::Term;
use crate::Function;
use crate::elementary;
use crate::evaluate::{power, whole_power};
use crate::operation::{Operation, Slot, choose};

/// What an instruction does with its operands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Code {
    Copy,
    Negate,
    Add,
    Subtract,
    Multiply,
    Divide,
    /// a b + c, rounded twice
    MultiplyAdd,
    /// a b - c
    MultiplySubtract,
    /// c - a b
    SubtractProduct,
    /// (a b) c
    Product,
    /// Σ ± a b over terms
    Row,
    /// Σ ± (a b) c over terms
    ProductRow,
    Cube,
    WholePower,
    Power,
    Choose,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Atan2,
    Sinh,
    Cosh,
    Tanh,
    Exp,
    Log,
    Log10,
    Sqrt,
    Abs,
    Sign,
    Min,
    Max,
    Hypot,
}

/// One operation on registers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Instruction {
    pub(super) code: Code,
    pub(super) target: u32,
    pub(super) operands: [u32; 4],
}

impl Instruction {
    /// The instruction of an operation, on slots; none of what computes nothing.
    pub(super) fn of(slot: Slot, operation: Operation) -> Option<Self> {
        let unused = 0;
        let (code, operands) = match operation {
            Operation::Constant(_) | Operation::Input(_) => return None,
            Operation::Hold(a) => (Code::Copy, [a.0, unused, unused, unused]),
            Operation::Negate(a) => (Code::Negate, [a.0, unused, unused, unused]),
            Operation::Add(a, b) => (Code::Add, [a.0, b.0, unused, unused]),
            Operation::Subtract(a, b) => (Code::Subtract, [a.0, b.0, unused, unused]),
            Operation::Multiply(a, b) => (Code::Multiply, [a.0, b.0, unused, unused]),
            Operation::Divide(a, b) => (Code::Divide, [a.0, b.0, unused, unused]),
            Operation::WholePower(a, 2) => (Code::Multiply, [a.0, a.0, unused, unused]),
            Operation::WholePower(a, 3) => (Code::Cube, [a.0, unused, unused, unused]),
            Operation::WholePower(a, exponent) => (
                Code::WholePower,
                [a.0, exponent.cast_unsigned(), unused, unused],
            ),
            Operation::Power(a, b) => (Code::Power, [a.0, b.0, unused, unused]),
            Operation::Unary(function, a) => (function.into(), [a.0, unused, unused, unused]),
            Operation::Binary(function, a, b) => (function.into(), [a.0, b.0, unused, unused]),
            Operation::Choose([a, b, c, d]) => (Code::Choose, [a.0, b.0, c.0, d.0]),
        };
        Some(Self {
            code,
            target: slot.0,
            operands,
        })
    }

    /// Its operands that are registers.
    pub(super) fn reads(&self) -> &[u32] {
        let count = match self.code {
            Code::Add
            | Code::Subtract
            | Code::Multiply
            | Code::Divide
            | Code::Power
            | Code::Atan2
            | Code::Min
            | Code::Max
            | Code::Hypot => 2,
            Code::MultiplyAdd | Code::MultiplySubtract | Code::SubtractProduct | Code::Product => 3,
            Code::Choose => 4,
            Code::Row | Code::ProductRow => 0,
            _ => 1,
        };
        self.operands.get(..count).unwrap_or(&[])
    }

    /// The same on other registers.
    pub(super) fn renamed(&self, target: u32, to: impl Fn(u32) -> u32) -> Self {
        let mut operands = self.operands;
        for (operand, read) in operands.iter_mut().zip(self.reads()) {
            *operand = to(*read);
        }
        Self {
            code: self.code,
            target,
            operands,
        }
    }
}

impl From<Function> for Code {
    fn from(function: Function) -> Self {
        match function {
            Function::Sin => Self::Sin,
            Function::Cos => Self::Cos,
            Function::Tan => Self::Tan,
            Function::Asin => Self::Asin,
            Function::Acos => Self::Acos,
            Function::Atan => Self::Atan,
            Function::Atan2 => Self::Atan2,
            Function::Sinh => Self::Sinh,
            Function::Cosh => Self::Cosh,
            Function::Tanh => Self::Tanh,
            Function::Exp => Self::Exp,
            Function::Log => Self::Log,
            Function::Log10 => Self::Log10,
            Function::Sqrt => Self::Sqrt,
            Function::Abs => Self::Abs,
            Function::Sign => Self::Sign,
            Function::Min => Self::Min,
            Function::Max => Self::Max,
            Function::Hypot => Self::Hypot,
        }
    }
}

/// Instructions with the terms of their rows.
#[derive(Debug, Clone, Default)]
pub(super) struct Stream {
    runs: Vec<Run>,
    instructions: Vec<Instruction>,
    /// Terms of all rows, one row after the other.
    terms: Vec<Term>,
    /// One more than the largest number of a register.
    registers: usize,
}

/// Instructions of one code that follow one another, decided upon once.
#[derive(Debug, Clone, Copy)]
struct Run {
    code: Code,
    count: u32,
    /// Terms of each, if they are rows.
    terms: u32,
}

impl Stream {
    /// Number of instructions.
    pub(super) const fn len(&self) -> usize {
        self.instructions.len()
    }

    /// Appends an instruction with the terms of its row.
    pub(super) fn push(&mut self, instruction: Instruction, terms: impl IntoIterator<Item = Term>) {
        let before = self.terms.len();
        self.terms.extend(terms);
        let of_terms = self.terms[before..].iter();
        let largest = of_terms
            .flat_map(|term| [term.a, term.b, term.c])
            .chain(instruction.reads().iter().copied())
            .fold(instruction.target, u32::max);
        self.registers = self.registers.max(largest as usize + 1);
        let terms = (self.terms.len() - before) as u32;
        self.instructions.push(instruction);
        match self.runs.last_mut() {
            Some(run) if run.code == instruction.code && run.terms == terms => run.count += 1,
            _ => self.runs.push(Run {
                code: instruction.code,
                count: 1,
                terms,
            }),
        }
    }

    /// Runs the instructions on registers of L points each, in every lane the same arithmetic.
    #[inline(always)]
    pub(super) fn run<const L: usize>(&self, registers: &mut [[f64; L]]) {
        match registers.first_chunk_mut::<SMALL>() {
            Some(bank) if self.registers <= SMALL => self.run_in(bank),
            _ => self.run_in(registers),
        }
    }

    #[inline(always)]
    fn run_in<const L: usize>(&self, registers: &mut (impl Bank<L> + ?Sized)) {
        let mut instructions = self.instructions.as_slice();
        let mut terms = self.terms.as_slice();
        for run in &self.runs {
            let Some((own, later)) = instructions.split_at_checked(run.count as usize) else {
                return;
            };
            instructions = later;
            if run.terms == 0 {
                run_simple(run.code, own, registers);
                continue;
            }
            let count = run.count as usize * run.terms as usize;
            let Some((rows, later)) = terms.split_at_checked(count) else {
                return;
            };
            terms = later;
            match (run.code, run.terms) {
                (Code::Row, 2) => run_rows::<2, L>(own, rows, registers),
                (Code::Row, 3) => run_rows::<3, L>(own, rows, registers),
                (Code::Row, 4) => run_rows::<4, L>(own, rows, registers),
                (Code::Row, length) => run_long::<false, L>(own, rows, length as usize, registers),
                (_, length) => run_long::<true, L>(own, rows, length as usize, registers),
            }
        }
    }
}

/// Rows of so many terms.
#[inline(always)]
fn run_long<const THREE: bool, const L: usize>(
    own: &[Instruction],
    mut rows: &[Term],
    length: usize,
    registers: &mut (impl Bank<L> + ?Sized),
) {
    for instruction in own {
        // Chunks would be counted by a division, which takes as long as a row.
        let Some((row, later)) = rows.split_at_checked(length) else {
            return;
        };
        rows = later;
        registers.set(instruction.target, sum::<L, THREE>(row, registers));
    }
}

/// Rows of N terms.
#[inline(always)]
fn run_rows<const N: usize, const L: usize>(
    own: &[Instruction],
    rows: &[Term],
    registers: &mut (impl Bank<L> + ?Sized),
) {
    let (rows, _) = rows.as_chunks::<N>();
    for (instruction, row) in own.iter().zip(rows) {
        registers.set(instruction.target, sum::<L, false>(row, registers));
    }
}

/// Terms of two or three factors, added from the left.
#[inline(always)]
fn sum<const L: usize, const THREE: bool>(
    terms: &[Term],
    registers: &(impl Bank<L> + ?Sized),
) -> [f64; L] {
    let mut sum = [0.0; L];
    let Some((first, rest)) = terms.split_first() else {
        return sum;
    };
    let (a, b) = (registers.at(first.a), registers.at(first.b));
    for lane in 0..L {
        sum[lane] = a[lane] * b[lane];
    }
    if THREE {
        let c = registers.at(first.c);
        for lane in 0..L {
            sum[lane] *= c[lane];
        }
    }
    for value in &mut sum {
        *value = f64::from_bits(value.to_bits() ^ first.mask);
    }
    for term in rest {
        let (a, b) = (registers.at(term.a), registers.at(term.b));
        let mask = term.mask;
        if THREE {
            let c = registers.at(term.c);
            for lane in 0..L {
                let product = a[lane] * b[lane] * c[lane];
                sum[lane] += f64::from_bits(product.to_bits() ^ mask);
            }
        } else {
            for lane in 0..L {
                let product = a[lane] * b[lane];
                sum[lane] += f64::from_bits(product.to_bits() ^ mask);
            }
        }
    }
    sum
}

/// Instructions of one code other than rows.
#[inline(always)]
fn run_simple<const L: usize>(
    code: Code,
    own: &[Instruction],
    registers: &mut (impl Bank<L> + ?Sized),
) {
    macro_rules! one {
        ($f:expr) => {{
            let f = $f;
            for Instruction {
                target, operands, ..
            } in own
            {
                let a = registers.at(operands[0]);
                registers.set(*target, std::array::from_fn(|lane| f(a[lane])));
            }
        }};
    }
    macro_rules! lanes {
        ($f:path) => {{
            for Instruction {
                target, operands, ..
            } in own
            {
                registers.set(*target, $f(registers.at(operands[0])));
            }
        }};
    }
    macro_rules! two {
        ($f:expr) => {{
            let f = $f;
            for Instruction {
                target, operands, ..
            } in own
            {
                let (a, b) = (registers.at(operands[0]), registers.at(operands[1]));
                registers.set(*target, std::array::from_fn(|lane| f(a[lane], b[lane])));
            }
        }};
    }
    macro_rules! three {
        ($f:expr) => {{
            let f = $f;
            for Instruction {
                target, operands, ..
            } in own
            {
                let (a, b) = (registers.at(operands[0]), registers.at(operands[1]));
                let c = registers.at(operands[2]);
                registers.set(
                    *target,
                    std::array::from_fn(|lane| f(a[lane], b[lane], c[lane])),
                );
            }
        }};
    }
    match code {
        Code::Copy => one!(|a: f64| a),
        Code::Negate => one!(|a: f64| -a),
        Code::Add => two!(|a: f64, b: f64| a + b),
        Code::Subtract => two!(|a: f64, b: f64| a - b),
        Code::Multiply => two!(|a: f64, b: f64| a * b),
        Code::Divide => two!(|a: f64, b: f64| a / b),
        Code::MultiplyAdd => three!(|a: f64, b: f64, c: f64| a * b + c),
        Code::MultiplySubtract => three!(|a: f64, b: f64, c: f64| a * b - c),
        Code::SubtractProduct => three!(|a: f64, b: f64, c: f64| c - a * b),
        Code::Product => three!(|a: f64, b: f64, c: f64| a * b * c),
        // Rows have terms.
        Code::Row | Code::ProductRow => {}
        Code::Cube => one!(|a: f64| a * (a * a)),
        Code::WholePower => {
            for Instruction {
                target, operands, ..
            } in own
            {
                let a = registers.at(operands[0]);
                let exponent = operands[1].cast_signed();
                registers.set(
                    *target,
                    std::array::from_fn(|lane| whole_power(a[lane], exponent)),
                );
            }
        }
        Code::Power => two!(power),
        Code::Choose => {
            for Instruction {
                target, operands, ..
            } in own
            {
                let [a, b, c, d] = operands.map(|operand| registers.at(operand));
                registers.set(
                    *target,
                    std::array::from_fn(|lane| choose([a[lane], b[lane], c[lane], d[lane]])),
                );
            }
        }
        Code::Sin => lanes!(elementary::sine),
        Code::Cos => lanes!(elementary::cosine),
        Code::Tan => one!(f64::tan),
        Code::Asin => lanes!(elementary::arc_sine),
        Code::Acos => one!(f64::acos),
        Code::Atan => lanes!(elementary::arc_tangent),
        Code::Atan2 => two!(f64::atan2),
        Code::Sinh => one!(f64::sinh),
        Code::Cosh => one!(f64::cosh),
        Code::Tanh => one!(f64::tanh),
        Code::Exp => lanes!(elementary::exponential),
        Code::Log => lanes!(elementary::logarithm),
        Code::Log10 => one!(f64::log10),
        Code::Sqrt => one!(f64::sqrt),
        Code::Abs => one!(f64::abs),
        Code::Sign => one!(crate::function::sign),
        Code::Min => two!(crate::function::least),
        Code::Max => two!(crate::function::largest),
        Code::Hypot => two!(f64::hypot),
    }
}
