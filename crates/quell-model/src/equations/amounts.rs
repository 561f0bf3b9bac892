//! Amounts of a host file in the scope of its parameters.

use quell_document::{Fault, Value};
use quell_expression::{Dimension, Quantity, Unit};

/// How amounts are read: names of parameters, and whether units exist.
#[derive(Clone, Copy)]
pub(crate) struct Amounts<'a> {
    /// The parameters, worked out.
    pub parameters: &'a Vec<(String, Quantity)>,
    /// Whether all numbers are plain.
    pub dimensionless: bool,
}

impl Amounts<'_> {
    /// The dimension that a quantity of this one has here.
    pub(crate) fn dimension(&self, dimension: Dimension) -> Dimension {
        if self.dimensionless {
            Dimension::NONE
        } else {
            dimension
        }
    }

    /// An amount of a dimension, SI.
    pub(crate) fn read(&self, value: &Value<'_>, dimension: Dimension) -> Result<f64, Fault> {
        let wanted = self.dimension(dimension);
        Ok(value.quantity(self.parameters, Some(wanted))?.value)
    }

    /// An amount that must be positive.
    pub(crate) fn positive(
        &self,
        value: &Value<'_>,
        dimension: Dimension,
        what: &str,
    ) -> Result<f64, Fault> {
        let amount = self.read(value, dimension)?;
        if amount > 0.0 {
            Ok(amount)
        } else {
            Err(value.fault(format!("{what} must be positive")))
        }
    }

    /// A unit given as a text.
    pub(crate) fn unit(&self, value: &Value<'_>) -> Result<Unit, Fault> {
        let unit = Unit::parse(value.as_str()?).map_err(|error| {
            let span = value.text_span(error.span);
            Fault::from_expression(
                value.source(),
                quell_expression::ExpressionError { span, ..error },
            )
        })?;
        if self.dimensionless {
            return Err(value
                .fault("this host is dimensionless, so nothing in it has a unit")
                .help("leave out `unit`, or `dimensionless`"));
        }
        Ok(unit)
    }
}
