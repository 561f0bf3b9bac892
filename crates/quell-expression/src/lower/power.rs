//! The dimension of powers.

use super::{Lowered, Lowering};
use crate::{Dimension, Expression, ExpressionError, Graph};

impl Lowering<'_> {
    /// The dimension of a power with an exponent that is a number, a parameter, or anything if the base is a number.
    pub(super) fn power_dimension(
        &self,
        graph: &Graph,
        base: Dimension,
        exponent: Lowered,
        right: &Expression,
    ) -> Result<Dimension, ExpressionError> {
        if self.names.dimensionless() {
            return Ok(Dimension::NONE);
        }
        let own = exponent.plain();
        if !own.without_angle().is_none() {
            let words = format!("an exponent is a plain number, found {own}");
            return Err(ExpressionError::new(right.span, words));
        }
        if base.without_angle().is_none() {
            return Ok(Dimension::NONE);
        }
        let Some(value) = self.present_value(graph, exponent) else {
            let words = format!(
                "{base} cannot be raised to the power `{}`, which varies",
                right.excerpt()
            );
            return Err(ExpressionError::new(right.span, words)
                .with_help("divide what is raised by a reference quantity of the same unit"));
        };
        base.power(value).ok_or_else(|| {
            let words = format!("{base} cannot be raised to the power {value}");
            ExpressionError::new(right.span, words)
        })
    }

    /// The value of what is made of constants and parameters only.
    fn present_value(&self, graph: &Graph, of: Lowered) -> Option<f64> {
        if let Some(value) = graph.as_constant(of.slot) {
            return Some(value);
        }
        let mut inputs = Vec::new();
        for input in graph.dependence(&[of.slot]) {
            if inputs.len() <= input {
                inputs.resize(input + 1, f64::NAN);
            }
            inputs[input] = self.names.present(input)?;
        }
        graph.values(&[of.slot], &inputs).first().copied()
    }
}
