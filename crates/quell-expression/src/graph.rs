//! The graph of operations behind a tape: single assignment, every operation stored once.

use std::collections::HashMap;

use crate::Function;
use crate::evaluate::{as_whole, power, whole_power};

/// Place of an operation in its graph, and of its value in the work space.
pub(crate) type Slot = u32;

/// One operation on earlier slots.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Operation {
    /// A number, by its bits.
    Constant(u64),
    /// The input of an index.
    Input(u32),
    /// -a
    Negate(Slot),
    /// a + b
    Add(Slot, Slot),
    /// a - b
    Subtract(Slot, Slot),
    /// a b
    Multiply(Slot, Slot),
    /// a/b
    Divide(Slot, Slot),
    /// a^n for a constant whole n, by multiplication.
    WholePower(Slot, i32),
    /// a^b
    Power(Slot, Slot),
    /// A function of one argument.
    Unary(Function, Slot),
    /// A function of two arguments.
    Binary(Function, Slot, Slot),
    /// c where a ≤ b, d where a > b, not-a-number where they do not compare.
    Choose([Slot; 4]),
}

impl Operation {
    /// Its value, from inputs (a missing one is not-a-number) and the values of earlier slots.
    #[inline]
    pub(crate) fn value(self, inputs: &[f64], work: &[f64]) -> f64 {
        let at = |slot: Slot| work[slot as usize];
        match self {
            Self::Constant(bits) => f64::from_bits(bits),
            Self::Input(index) => inputs.get(index as usize).copied().unwrap_or(f64::NAN),
            Self::Negate(a) => -at(a),
            Self::Add(a, b) => at(a) + at(b),
            Self::Subtract(a, b) => at(a) - at(b),
            Self::Multiply(a, b) => at(a) * at(b),
            Self::Divide(a, b) => at(a) / at(b),
            Self::WholePower(a, exponent) => whole_power(at(a), exponent),
            Self::Power(a, b) => power(at(a), at(b)),
            Self::Unary(function, a) => function.value(&[at(a)]),
            Self::Binary(function, a, b) => function.value(&[at(a), at(b)]),
            Self::Choose([a, b, c, d]) => {
                let (a, b) = (at(a), at(b));
                if a <= b {
                    at(c)
                } else if a > b {
                    at(d)
                } else {
                    f64::NAN
                }
            }
        }
    }

    /// The same operation on other slots.
    #[must_use]
    pub(crate) fn map(self, mut to: impl FnMut(Slot) -> Slot) -> Self {
        match self {
            Self::Constant(_) | Self::Input(_) => self,
            Self::Negate(a) => Self::Negate(to(a)),
            Self::Add(a, b) => Self::Add(to(a), to(b)),
            Self::Subtract(a, b) => Self::Subtract(to(a), to(b)),
            Self::Multiply(a, b) => Self::Multiply(to(a), to(b)),
            Self::Divide(a, b) => Self::Divide(to(a), to(b)),
            Self::WholePower(a, exponent) => Self::WholePower(to(a), exponent),
            Self::Power(a, b) => Self::Power(to(a), to(b)),
            Self::Unary(function, a) => Self::Unary(function, to(a)),
            Self::Binary(function, a, b) => Self::Binary(function, to(a), to(b)),
            Self::Choose(slots) => Self::Choose(slots.map(to)),
        }
    }

    /// Calls `visit` with every slot that it reads.
    pub(crate) fn operands(self, mut visit: impl FnMut(Slot)) {
        let _ = self.map(|slot| {
            visit(slot);
            slot
        });
    }
}

/// Operations in the order of evaluation: each reads earlier ones only.
///
/// The constructors fold constants and leave out what is exact in floating point (x·1, x/1, x - 0, -(-x)), so a value
/// has the bits that evaluating the expression gives. 0·x stays, since x may be infinite; structural zeros are the
/// derivatives' own business.
#[derive(Debug, Clone, Default)]
pub(crate) struct Graph {
    operations: Vec<Operation>,
    known: HashMap<Operation, Slot>,
}

impl Graph {
    pub(crate) fn operations(&self) -> &[Operation] {
        &self.operations
    }

    pub(crate) fn operation(&self, slot: Slot) -> Operation {
        self.operations[slot as usize]
    }

    pub(crate) fn as_constant(&self, slot: Slot) -> Option<f64> {
        match self.operation(slot) {
            Operation::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    pub(crate) fn constant(&mut self, value: f64) -> Slot {
        self.store(Operation::Constant(value.to_bits()))
    }

    pub(crate) fn input(&mut self, index: u32) -> Slot {
        self.store(Operation::Input(index))
    }

    pub(crate) fn negate(&mut self, a: Slot) -> Slot {
        match self.operation(a) {
            Operation::Negate(inner) => inner,
            _ => self.push(Operation::Negate(a)),
        }
    }

    pub(crate) fn add(&mut self, a: Slot, b: Slot) -> Slot {
        match (self.operation(a), self.operation(b)) {
            (_, Operation::Negate(inner)) => self.subtract(a, inner),
            (Operation::Negate(inner), _) => self.subtract(b, inner),
            _ => self.push(Operation::Add(a.min(b), a.max(b))),
        }
    }

    pub(crate) fn subtract(&mut self, a: Slot, b: Slot) -> Slot {
        if self.as_constant(b).map(f64::to_bits) == Some(0) {
            return a;
        }
        self.push(Operation::Subtract(a, b))
    }

    pub(crate) fn multiply(&mut self, a: Slot, b: Slot) -> Slot {
        for (factor, other) in [(a, b), (b, a)] {
            match self.as_constant(factor) {
                Some(1.0) => return other,
                Some(-1.0) => return self.negate(other),
                _ => {}
            }
        }
        self.push(Operation::Multiply(a.min(b), a.max(b)))
    }

    pub(crate) fn divide(&mut self, a: Slot, b: Slot) -> Slot {
        if self.as_constant(b) == Some(1.0) {
            return a;
        }
        self.push(Operation::Divide(a, b))
    }

    pub(crate) fn power(&mut self, a: Slot, b: Slot) -> Slot {
        match self.as_constant(b) {
            Some(0.0) => self.constant(1.0),
            Some(1.0) => a,
            exponent => match exponent.and_then(as_whole) {
                Some(whole) => self.push(Operation::WholePower(a, whole)),
                None => self.push(Operation::Power(a, b)),
            },
        }
    }

    pub(crate) fn unary(&mut self, function: Function, a: Slot) -> Slot {
        self.push(Operation::Unary(function, a))
    }

    pub(crate) fn binary(&mut self, function: Function, a: Slot, b: Slot) -> Slot {
        self.push(Operation::Binary(function, a, b))
    }

    /// c where a ≤ b, d otherwise.
    pub(crate) fn choose(&mut self, slots: [Slot; 4]) -> Slot {
        self.push(Operation::Choose(slots))
    }

    /// Folds an operation on constants, else stores it.
    fn push(&mut self, operation: Operation) -> Slot {
        let mut slots = [0; 4];
        let mut values = [0.0; 4];
        let mut count = 0;
        let mut constant = true;
        operation.operands(|slot| {
            match self.as_constant(slot) {
                Some(value) => values[count] = value,
                None => constant = false,
            }
            slots[count] = slot;
            count += 1;
        });
        if !constant {
            return self.store(operation);
        }
        let mut next = 0;
        let local = operation.map(|_| {
            next += 1;
            next - 1
        });
        self.constant(local.value(&[], &values))
    }

    fn store(&mut self, operation: Operation) -> Slot {
        let operations = &mut self.operations;
        *self.known.entry(operation).or_insert_with(|| {
            operations.push(operation);
            // 2^32 operations would fill the memory of any machine long before.
            (operations.len() - 1) as Slot
        })
    }
}
