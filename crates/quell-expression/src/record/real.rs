//! Numbers that a model's formulas are written over.

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::Function;
use crate::evaluate::{power, whole_power};
use crate::operation::choose;

/// A real number: `f64`, or a symbol under [`record`](crate::record()).
///
/// The functions are those of the language, with its conventions at kinks, so that both give the same bits.
pub trait Real:
    Copy
    + From<f64>
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
{
    /// A function of one argument.
    #[must_use]
    fn unary(self, function: Function) -> Self;

    /// A function of two arguments.
    #[must_use]
    fn binary(self, function: Function, other: Self) -> Self;

    /// x^y
    #[must_use]
    fn powf(self, exponent: Self) -> Self;

    /// x^n by multiplication, |n| ≤ 64.
    #[must_use]
    fn powi(self, exponent: i32) -> Self;

    /// `then` where self ≤ `bound`, `otherwise` where it is greater, not-a-number where they do not compare.
    #[must_use]
    fn select(self, bound: Self, then: Self, otherwise: Self) -> Self;

    /// Sine.
    #[must_use]
    fn sin(self) -> Self {
        self.unary(Function::Sin)
    }

    /// Cosine.
    #[must_use]
    fn cos(self) -> Self {
        self.unary(Function::Cos)
    }

    /// Tangent.
    #[must_use]
    fn tan(self) -> Self {
        self.unary(Function::Tan)
    }

    /// Arc sine.
    #[must_use]
    fn asin(self) -> Self {
        self.unary(Function::Asin)
    }

    /// Arc tangent.
    #[must_use]
    fn atan(self) -> Self {
        self.unary(Function::Atan)
    }

    /// Hyperbolic tangent.
    #[must_use]
    fn tanh(self) -> Self {
        self.unary(Function::Tanh)
    }

    /// Exponential.
    #[must_use]
    fn exp(self) -> Self {
        self.unary(Function::Exp)
    }

    /// Natural logarithm.
    #[must_use]
    fn ln(self) -> Self {
        self.unary(Function::Log)
    }

    /// Square root.
    #[must_use]
    fn sqrt(self) -> Self {
        self.unary(Function::Sqrt)
    }

    /// Magnitude.
    #[must_use]
    fn abs(self) -> Self {
        self.unary(Function::Abs)
    }

    /// -1, 0 or 1.
    #[must_use]
    fn sign(self) -> Self {
        self.unary(Function::Sign)
    }

    /// The smaller.
    #[must_use]
    fn min(self, other: Self) -> Self {
        self.binary(Function::Min, other)
    }

    /// The larger.
    #[must_use]
    fn max(self, other: Self) -> Self {
        self.binary(Function::Max, other)
    }

    /// Angle of (`other`, self).
    #[must_use]
    fn atan2(self, other: Self) -> Self {
        self.binary(Function::Atan2, other)
    }

    /// √(x² + y²)
    #[must_use]
    fn hypot(self, other: Self) -> Self {
        self.binary(Function::Hypot, other)
    }
}

impl Real for f64 {
    #[inline]
    fn unary(self, function: Function) -> Self {
        function.value(&[self])
    }

    #[inline]
    fn binary(self, function: Function, other: Self) -> Self {
        function.value(&[self, other])
    }

    #[inline]
    fn powf(self, exponent: Self) -> Self {
        power(self, exponent)
    }

    #[inline]
    fn powi(self, exponent: i32) -> Self {
        whole_power(self, exponent)
    }

    #[inline]
    fn select(self, bound: Self, then: Self, otherwise: Self) -> Self {
        choose([self, bound, then, otherwise])
    }
}
