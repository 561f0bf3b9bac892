//! The usual functions, on quantities.

use crate::elementary::{self, alone};
use crate::{Dimension, Quantity};

/// A function of plain quantities.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Function {
    /// Sine of an angle.
    Sin,
    /// Cosine of an angle.
    Cos,
    /// Tangent of an angle.
    Tan,
    /// Arc sine, rad.
    Asin,
    /// Arc cosine, rad.
    Acos,
    /// Arc tangent, rad.
    Atan,
    /// Angle of (second, first), rad.
    Atan2,
    /// Hyperbolic sine.
    Sinh,
    /// Hyperbolic cosine.
    Cosh,
    /// Hyperbolic tangent.
    Tanh,
    /// Exponential.
    Exp,
    /// Natural logarithm.
    Log,
    /// Decimal logarithm.
    Log10,
    /// Square root, of any dimension.
    Sqrt,
    /// Magnitude, of any dimension.
    Abs,
    /// -1, 0 or 1.
    Sign,
    /// Smallest of the arguments.
    Min,
    /// Largest of the arguments.
    Max,
    /// √(x² + y²).
    Hypot,
}

impl Function {
    /// Every function with its name.
    pub const ALL: [(&'static str, Self); 19] = [
        ("sin", Self::Sin),
        ("cos", Self::Cos),
        ("tan", Self::Tan),
        ("asin", Self::Asin),
        ("acos", Self::Acos),
        ("atan", Self::Atan),
        ("atan2", Self::Atan2),
        ("sinh", Self::Sinh),
        ("cosh", Self::Cosh),
        ("tanh", Self::Tanh),
        ("exp", Self::Exp),
        ("log", Self::Log),
        ("log10", Self::Log10),
        ("sqrt", Self::Sqrt),
        ("abs", Self::Abs),
        ("sign", Self::Sign),
        ("min", Self::Min),
        ("max", Self::Max),
        ("hypot", Self::Hypot),
    ];

    /// The function of a name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL
            .iter()
            .find(|(known, _)| *known == name)
            .map(|(_, function)| *function)
    }

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::ALL
            .iter()
            .find(|(_, function)| *function == self)
            .map_or("", |(name, _)| name)
    }

    /// How many arguments it takes, at least and at most.
    #[must_use]
    pub const fn arguments(self) -> (usize, usize) {
        match self {
            Self::Atan2 | Self::Hypot => (2, 2),
            Self::Min | Self::Max => (2, usize::MAX),
            _ => (1, 1),
        }
    }

    /// Its value for SI arguments; not-a-number outside its domain. Missing arguments read as not-a-number.
    ///
    /// Sine, cosine, arc sine, arc tangent, exponential and logarithm are within one unit in the last place and have the
    /// same bits on every machine (angles up to 8e5 rad, exponents up to 708); the others are those of the platform.
    #[must_use]
    pub fn value(self, arguments: &[f64]) -> f64 {
        let first = arguments.first().copied().unwrap_or(f64::NAN);
        let second = arguments.get(1).copied().unwrap_or(f64::NAN);
        match self {
            Self::Sin => alone(elementary::sine, first),
            Self::Cos => alone(elementary::cosine, first),
            Self::Tan => first.tan(),
            Self::Asin => alone(elementary::arc_sine, first),
            Self::Acos => first.acos(),
            Self::Atan => alone(elementary::arc_tangent, first),
            Self::Atan2 => first.atan2(second),
            Self::Sinh => first.sinh(),
            Self::Cosh => first.cosh(),
            Self::Tanh => first.tanh(),
            Self::Exp => alone(elementary::exponential, first),
            Self::Log => alone(elementary::logarithm, first),
            Self::Log10 => first.log10(),
            Self::Sqrt => first.sqrt(),
            Self::Abs => first.abs(),
            Self::Sign => sign(first),
            Self::Min => arguments.iter().copied().fold(f64::INFINITY, least),
            Self::Max => arguments.iter().copied().fold(f64::NEG_INFINITY, largest),
            Self::Hypot => first.hypot(second),
        }
    }

    /// The dimension of its value.
    ///
    /// # Errors
    /// In words, with the place of the argument at fault.
    pub fn dimension(self, arguments: &[Dimension]) -> Result<Dimension, (usize, String)> {
        let first = arguments.first().copied().unwrap_or_default();
        let refused = |index: usize, what: &str, found: Dimension| {
            Err((
                index,
                format!("`{}` takes {what}, found {found}", self.name()),
            ))
        };
        match self {
            Self::Sin | Self::Cos | Self::Tan => {
                if Dimension::ANGLE.accepts(&first) {
                    Ok(Dimension::NONE)
                } else {
                    refused(0, "an angle", first)
                }
            }
            Self::Sinh | Self::Cosh | Self::Tanh | Self::Exp | Self::Log | Self::Log10 => {
                if Dimension::ANGLE.accepts(&first) {
                    Ok(Dimension::NONE)
                } else {
                    refused(0, "a plain number", first)
                }
            }
            Self::Asin | Self::Acos | Self::Atan => {
                if Dimension::ANGLE.accepts(&first) {
                    Ok(Dimension::ANGLE)
                } else {
                    refused(0, "a plain number", first)
                }
            }
            Self::Sqrt => match first.power(0.5) {
                Some(root) => Ok(root),
                None => refused(0, "what has a root", first),
            },
            Self::Abs => Ok(first),
            Self::Sign => Ok(Dimension::NONE),
            Self::Min | Self::Max | Self::Hypot | Self::Atan2 => {
                let mut joined = first;
                for (index, other) in arguments.iter().enumerate().skip(1) {
                    if !joined.agrees(other) {
                        return Err((
                            index,
                            format!("`{}` compares {joined} with {other}", self.name()),
                        ));
                    }
                    joined = joined.joined(*other);
                }
                Ok(if self == Self::Atan2 {
                    Dimension::ANGLE
                } else {
                    joined
                })
            }
        }
    }

    /// Value and dimension.
    ///
    /// # Errors
    /// As [`Self::dimension`].
    pub fn apply(self, arguments: &[Quantity]) -> Result<Quantity, (usize, String)> {
        let dimensions: Vec<Dimension> = arguments
            .iter()
            .map(|argument| argument.dimension)
            .collect();
        let values: Vec<f64> = arguments.iter().map(|argument| argument.value).collect();
        Ok(Quantity::new(
            self.value(&values),
            self.dimension(&dimensions)?,
        ))
    }
}

/// -1, 0 or 1.
#[inline]
pub(crate) fn sign(a: f64) -> f64 {
    if a == 0.0 { 0.0 } else { a.signum() }
}

/// The smaller, the earlier of equals. `f64::min` ignores not-a-number, which must not pass in silence.
#[inline]
pub(crate) fn least(a: f64, b: f64) -> f64 {
    if a <= b {
        a
    } else if b < a {
        b
    } else {
        f64::NAN
    }
}

/// The larger, the earlier of equals.
#[inline]
pub(crate) fn largest(a: f64, b: f64) -> f64 {
    if a >= b {
        a
    } else if b > a {
        b
    } else {
        f64::NAN
    }
}
