//! Forward-mode derivatives in up to eight variables, enough for the closed-form reference problems.

use std::ops::{Add, Mul, Sub};

#[derive(Debug, Clone, Copy)]
pub struct Dual {
    pub value: f64,
    pub gradient: [f64; 8],
}

impl Dual {
    pub fn variable(value: f64, index: usize) -> Self {
        let mut gradient = [0.0; 8];
        gradient[index] = 1.0;
        Self { value, gradient }
    }

    fn chain(self, value: f64, slope: f64) -> Self {
        Self {
            value,
            gradient: self.gradient.map(|g| g * slope),
        }
    }

    pub fn powi(self, power: i32) -> Self {
        self.chain(
            self.value.powi(power),
            f64::from(power) * self.value.powi(power - 1),
        )
    }

    pub fn exp(self) -> Self {
        self.chain(self.value.exp(), self.value.exp())
    }

    pub fn cos(self) -> Self {
        self.chain(self.value.cos(), -self.value.sin())
    }
}

impl From<f64> for Dual {
    fn from(value: f64) -> Self {
        Self {
            value,
            gradient: [0.0; 8],
        }
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, |$a:ident, $b:ident| $value:expr, $left:expr, $right:expr) => {
        impl $trait for Dual {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                let ($a, $b) = (self.value, other.value);
                let (left, right): (f64, f64) = ($left, $right);
                let mut gradient = [0.0; 8];
                for (i, g) in gradient.iter_mut().enumerate() {
                    *g = left * self.gradient[i] + right * other.gradient[i];
                }
                Self {
                    value: $value,
                    gradient,
                }
            }
        }
        impl $trait<f64> for Dual {
            type Output = Self;
            fn $method(self, other: f64) -> Self {
                $trait::$method(self, Self::from(other))
            }
        }
        impl $trait<Dual> for f64 {
            type Output = Dual;
            fn $method(self, other: Dual) -> Dual {
                $trait::$method(Dual::from(self), other)
            }
        }
    };
}

operator!(Add, add, |a, b| a + b, 1.0, 1.0);
operator!(Sub, sub, |a, b| a - b, 1.0, -1.0);
operator!(Mul, mul, |a, b| a * b, b, a);
