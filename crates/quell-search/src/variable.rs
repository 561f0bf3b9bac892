//! Design variables: a range and the scale on which it is searched.

use crate::SearchError;

/// The scale on which a variable is searched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Scale {
    /// Equal steps are equal differences: `x = lower + u (upper - lower)`, `u` in `[0, 1]`.
    #[default]
    Linear,
    /// Equal steps are equal ratios: `x = lower (upper / lower)^u`, `u` in `[0, 1]`; needs `lower > 0`.
    Logarithmic,
}

/// One of the two ends of a variable's range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Side {
    /// The lower bound.
    Lower,
    /// The upper bound.
    Upper,
}

/// A design variable with its bounds, in the variable's own unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Name, used in messages only.
    pub name: String,
    /// Lower bound, in the variable's own unit.
    pub lower: f64,
    /// Upper bound, in the variable's own unit.
    pub upper: f64,
    /// Scale on which the range is searched.
    pub scale: Scale,
}

impl Variable {
    /// A variable between two bounds.
    ///
    /// # Errors
    ///
    /// Bounds that are not finite, equal or reversed, and a logarithmic scale whose lower bound is not positive.
    pub fn new(
        name: impl Into<String>,
        lower: f64,
        upper: f64,
        scale: Scale,
    ) -> Result<Self, SearchError> {
        let name = name.into();
        if !lower.is_finite() || !upper.is_finite() {
            return Err(SearchError::UnboundedVariable { name, lower, upper });
        }
        if lower == upper {
            return Err(SearchError::FixedVariable { name, value: lower });
        }
        if lower > upper {
            return Err(SearchError::ReversedBounds { name, lower, upper });
        }
        if scale == Scale::Logarithmic && lower <= 0.0 {
            return Err(SearchError::LogarithmOfBound { name, lower });
        }
        Ok(Self {
            name,
            lower,
            upper,
            scale,
        })
    }

    /// The value at the scaled coordinate `u` in `[0, 1]`; the ends give the bounds exactly.
    pub fn value(&self, u: f64) -> f64 {
        if u <= 0.0 {
            return self.lower;
        }
        if u >= 1.0 {
            return self.upper;
        }
        let value = match self.scale {
            Scale::Linear => self.lower * (1.0 - u) + self.upper * u,
            Scale::Logarithmic => self.lower * ((self.upper.ln() - self.lower.ln()) * u).exp(),
        };
        value.clamp(self.lower, self.upper)
    }

    /// The scaled coordinate in `[0, 1]` of a value; values outside the bounds go to the nearer end.
    pub fn coordinate(&self, value: f64) -> f64 {
        if value.is_nan() || value <= self.lower {
            return 0.0;
        }
        if value >= self.upper {
            return 1.0;
        }
        let u = match self.scale {
            Scale::Linear => {
                // Halves, because the range of two finite bounds may overflow.
                (0.5 * value - 0.5 * self.lower) / (0.5 * self.upper - 0.5 * self.lower)
            }
            Scale::Logarithmic => {
                (value.ln() - self.lower.ln()) / (self.upper.ln() - self.lower.ln())
            }
        };
        u.clamp(0.0, 1.0)
    }

    /// Derivative of the value by the scaled coordinate, `dx/du`, at a value.
    pub fn slope(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => self.upper - self.lower,
            Scale::Logarithmic => value * (self.upper.ln() - self.lower.ln()),
        }
    }

    /// The bound at which a value lies within `tolerance` of the scaled range, if any.
    pub fn active_side(&self, value: f64, tolerance: f64) -> Option<Side> {
        let u = self.coordinate(value);
        if u <= tolerance {
            Some(Side::Lower)
        } else if u >= 1.0 - tolerance {
            Some(Side::Upper)
        } else {
            None
        }
    }
}
