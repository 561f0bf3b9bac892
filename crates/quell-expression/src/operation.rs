//! One operation of a graph, on the values of earlier ones.

use crate::Function;
use crate::evaluate::{power, whole_power};

/// Place of an operation in its [`Graph`](crate::Graph): what an expression has become.
///
/// It means nothing in another graph than the one that gave it (clones apart, which keep all slots of their original).
#[derive(Copy, Clone, PartialEq, Eq, Hash, Ord, PartialOrd, Debug)]
pub struct Slot(pub(crate) u32);

impl Slot {
    pub(crate) const fn at(index: usize) -> Self {
        // 2^32 operations would fill the memory of any machine long before.
        Self(index as u32)
    }

    pub(crate) const fn index(self) -> usize {
        self.0 as usize
    }
}

/// One operation on earlier slots.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Operation {
    /// A number, by its bits.
    Constant(u64),
    /// The input of an index.
    Input(u32),
    /// a, opaque to formal differentiation.
    Hold(Slot),
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
        let at = |slot: Slot| work[slot.index()];
        match self {
            Self::Constant(bits) => f64::from_bits(bits),
            Self::Input(index) => inputs.get(index as usize).copied().unwrap_or(f64::NAN),
            Self::Hold(a) => at(a),
            Self::Negate(a) => -at(a),
            Self::Add(a, b) => at(a) + at(b),
            Self::Subtract(a, b) => at(a) - at(b),
            Self::Multiply(a, b) => at(a) * at(b),
            Self::Divide(a, b) => at(a) / at(b),
            Self::WholePower(a, exponent) => whole_power(at(a), exponent),
            Self::Power(a, b) => power(at(a), at(b)),
            Self::Unary(function, a) => function.value(&[at(a)]),
            Self::Binary(function, a, b) => function.value(&[at(a), at(b)]),
            Self::Choose([a, b, c, d]) => choose([at(a), at(b), at(c), at(d)]),
        }
    }

    /// The same operation on other slots.
    #[must_use]
    pub(crate) fn map(self, mut to: impl FnMut(Slot) -> Slot) -> Self {
        match self {
            Self::Constant(_) | Self::Input(_) => self,
            Self::Hold(a) => Self::Hold(to(a)),
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

/// c where a ≤ b, d where a > b, not-a-number where they do not compare.
#[inline]
pub(crate) fn choose([a, b, c, d]: [f64; 4]) -> f64 {
    if a <= b {
        c
    } else if a > b {
        d
    } else {
        f64::NAN
    }
}
