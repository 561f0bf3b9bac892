//! Instructions, and the one loop that runs them.

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
    /// Σ ± a b over terms; the operands are the first of them and their number
    Row,
    /// Σ ± (a b) c over terms
    ProductRow,
    Square,
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
            Operation::WholePower(a, 2) => (Code::Square, [a.0, unused, unused, unused]),
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
    pub(super) instructions: Vec<Instruction>,
    pub(super) terms: Vec<Term>,
}

/// Runs instructions on registers of L points each, in every lane the same arithmetic.
#[expect(
    clippy::inline_always,
    reason = "only what is inlined is compiled for the vectors of the machine"
)]
#[inline(always)]
pub(super) fn run<const L: usize>(stream: &Stream, registers: &mut [[f64; L]]) {
    let Stream {
        instructions,
        terms,
    } = stream;
    for instruction in instructions {
        let place = instruction.target as usize;
        let [a, b, c, d] = instruction.operands;
        // The compiler numbers registers below the length that the work space has been given.
        macro_rules! one {
            ($f:expr) => {{
                let a = &registers[a as usize];
                let f = $f;
                registers[place] = std::array::from_fn(|lane| f(a[lane]));
            }};
        }
        macro_rules! two {
            ($f:expr) => {{
                let (a, b) = (&registers[a as usize], &registers[b as usize]);
                let f = $f;
                registers[place] = std::array::from_fn(|lane| f(a[lane], b[lane]));
            }};
        }
        macro_rules! three {
            ($f:expr) => {{
                let (a, b) = (&registers[a as usize], &registers[b as usize]);
                let c = &registers[c as usize];
                let f = $f;
                registers[place] = std::array::from_fn(|lane| f(a[lane], b[lane], c[lane]));
            }};
        }
        match instruction.code {
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
            Code::Row => {
                let mut sum = [0.0; L];
                let terms = terms.get(a as usize..(a + b) as usize).unwrap_or(&[]);
                if let Some((first, rest)) = terms.split_first() {
                    let (a, b) = (&registers[first.a as usize], &registers[first.b as usize]);
                    sum = std::array::from_fn(|lane| a[lane] * b[lane]);
                    for term in rest {
                        let (a, b) = (&registers[term.a as usize], &registers[term.b as usize]);
                        let mask = term.mask();
                        for lane in 0..L {
                            let product = a[lane] * b[lane];
                            sum[lane] += f64::from_bits(product.to_bits() ^ mask);
                        }
                    }
                }
                registers[place] = sum;
            }
            Code::ProductRow => {
                let mut sum = [0.0; L];
                let terms = terms.get(a as usize..(a + b) as usize).unwrap_or(&[]);
                if let Some((first, rest)) = terms.split_first() {
                    let (a, b) = (&registers[first.a as usize], &registers[first.b as usize]);
                    let c = &registers[first.c as usize];
                    sum = std::array::from_fn(|lane| a[lane] * b[lane] * c[lane]);
                    for term in rest {
                        let (a, b) = (&registers[term.a as usize], &registers[term.b as usize]);
                        let c = &registers[term.c as usize];
                        let mask = term.mask();
                        for lane in 0..L {
                            let product = a[lane] * b[lane] * c[lane];
                            sum[lane] += f64::from_bits(product.to_bits() ^ mask);
                        }
                    }
                }
                registers[place] = sum;
            }
            Code::Square => one!(|a: f64| a * a),
            Code::Cube => one!(|a: f64| a * (a * a)),
            Code::WholePower => one!(|a: f64| whole_power(a, b.cast_signed())),
            Code::Power => two!(power),
            Code::Choose => {
                let (a, b) = (&registers[a as usize], &registers[b as usize]);
                let (c, d) = (&registers[c as usize], &registers[d as usize]);
                registers[place] =
                    std::array::from_fn(|lane| choose([a[lane], b[lane], c[lane], d[lane]]));
            }
            Code::Sin => registers[place] = elementary::sine(&registers[a as usize]),
            Code::Cos => registers[place] = elementary::cosine(&registers[a as usize]),
            Code::Tan => one!(f64::tan),
            Code::Asin => registers[place] = elementary::arc_sine(&registers[a as usize]),
            Code::Acos => one!(f64::acos),
            Code::Atan => registers[place] = elementary::arc_tangent(&registers[a as usize]),
            Code::Atan2 => two!(f64::atan2),
            Code::Sinh => one!(f64::sinh),
            Code::Cosh => one!(f64::cosh),
            Code::Tanh => one!(f64::tanh),
            Code::Exp => registers[place] = elementary::exponential(&registers[a as usize]),
            Code::Log => registers[place] = elementary::logarithm(&registers[a as usize]),
            Code::Log10 => one!(f64::log10),
            Code::Sqrt => one!(f64::sqrt),
            Code::Abs => one!(f64::abs),
            Code::Sign => one!(crate::function::sign),
            Code::Min => two!(crate::function::least),
            Code::Max => two!(crate::function::largest),
            Code::Hypot => two!(f64::hypot),
        }
    }
}
