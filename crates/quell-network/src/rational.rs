//! Admittances as rational functions with real coefficients.

use std::fmt;

use num_complex::Complex64;

use crate::polynomial::{degree, horner, product, sum};
use crate::program::Operation;
use crate::{Element, Network};

/// N(s)/D(s) with real coefficients, lowest power first.
#[derive(Debug, Clone, PartialEq)]
pub struct RationalFunction {
    /// Coefficients of N: `numerator[i]` belongs to s^i.
    pub numerator: Vec<f64>,
    /// Coefficients of D: `denominator[i]` belongs to s^i.
    pub denominator: Vec<f64>,
}

impl RationalFunction {
    /// Degrees of N and D; zero for the polynomial zero.
    #[must_use]
    pub fn degrees(&self) -> (usize, usize) {
        (degree(&self.numerator), degree(&self.denominator))
    }

    /// The larger degree, which is the McMillan degree where N and D have no common root.
    #[must_use]
    pub fn degree(&self) -> usize {
        let (numerator, denominator) = self.degrees();
        numerator.max(denominator)
    }

    /// The value at a complex s; +∞ at a pole.
    #[must_use]
    pub fn evaluate(&self, s: Complex64) -> Complex64 {
        crate::network::quotient(horner(&self.numerator, s), horner(&self.denominator, s))
    }
}

impl fmt::Display for RationalFunction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "({})/({})",
            Polynomial(&self.numerator),
            Polynomial(&self.denominator)
        )
    }
}

struct Polynomial<'a>(&'a [f64]);

impl fmt::Display for Polynomial<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut first = true;
        for (power, coefficient) in self
            .0
            .iter()
            .enumerate()
            .rev()
            .filter(|(_, coefficient)| **coefficient != 0.0)
        {
            match (first, *coefficient < 0.0) {
                (true, false) => {}
                (true, true) => f.write_str("-")?,
                (false, false) => f.write_str(" + ")?,
                (false, true) => f.write_str(" - ")?,
            }
            first = false;
            let size = coefficient.abs();
            match power {
                0 => write!(f, "{size}")?,
                _ if size == 1.0 => f.write_str("s")?,
                _ => write!(f, "{size} s")?,
            }
            if power > 1 {
                write!(f, "^{power}")?;
            }
        }
        if first { f.write_str("0") } else { Ok(()) }
    }
}

impl Network {
    /// Y(s) = F/(s x) for given values, a rational function with real coefficients without common powers of s.
    ///
    /// Scaled so that the largest coefficient is between one and two. Coefficients that differ by more than 1e±300 are
    /// lost; large networks are better evaluated by [`Network::ratio`].
    #[must_use]
    pub fn admittance(&self, values: &[f64]) -> RationalFunction {
        let mut results: Vec<RationalFunction> = Vec::with_capacity(self.program.steps.len());
        let none = RationalFunction {
            numerator: vec![0.0],
            denominator: vec![1.0],
        };
        let leaf = |element: usize, kind: Element| {
            let mut numerator = vec![0.0; kind.power() + 1];
            if let Some(last) = numerator.last_mut() {
                *last = values.get(element).copied().unwrap_or(f64::NAN);
            }
            RationalFunction {
                numerator,
                denominator: vec![1.0],
            }
        };
        for step in &self.program.steps {
            let left = results.get(step.left).unwrap_or(&none);
            let right = match step.operation {
                Operation::Series | Operation::Parallel => {
                    results.get(step.right).unwrap_or(&none).clone()
                }
                _ => leaf(step.element, step.kind),
            };
            let crossed = || {
                sum(
                    &product(&left.numerator, &right.denominator),
                    &product(&right.numerator, &left.denominator),
                )
            };
            let joined = match step.operation {
                Operation::Load => right,
                Operation::Series | Operation::SeriesElement => RationalFunction {
                    numerator: product(&left.numerator, &right.numerator),
                    denominator: crossed(),
                },
                Operation::Parallel | Operation::ParallelElement => RationalFunction {
                    numerator: crossed(),
                    denominator: product(&left.denominator, &right.denominator),
                },
            };
            results.push(scaled(joined));
        }
        let RationalFunction {
            mut numerator,
            mut denominator,
        } = results.pop().unwrap_or(none);
        denominator.insert(0, 0.0);
        let lowest = |coefficients: &[f64]| {
            coefficients
                .iter()
                .position(|coefficient| *coefficient != 0.0)
        };
        let common = match (lowest(&numerator), lowest(&denominator)) {
            (Some(a), Some(b)) => a.min(b),
            (Some(a), None) | (None, Some(a)) => a,
            (None, None) => 0,
        };
        for coefficients in [&mut numerator, &mut denominator] {
            coefficients.drain(..common.min(coefficients.len()));
            coefficients.truncate(degree(coefficients) + 1);
        }
        RationalFunction {
            numerator,
            denominator,
        }
    }
}

/// Both polynomials by the power of two that brings the largest coefficient near one; exact.
fn scaled(mut function: RationalFunction) -> RationalFunction {
    let largest = function
        .numerator
        .iter()
        .chain(&function.denominator)
        .fold(0.0_f64, |most, x| most.max(x.abs()));
    let scale = crate::program::scale(largest, 0.0, 0.0, 0.0);
    for coefficient in function
        .numerator
        .iter_mut()
        .chain(&mut function.denominator)
    {
        *coefficient *= scale;
    }
    function
}
