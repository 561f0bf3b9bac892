//! Amounts as typed: kept as expressions until the parameters of a sweep are known.

use std::sync::Arc;

use quell_document::{Fault, Source, Value};
use quell_expression::{Dimension, Expression, Node, Quantity, Scope, Span};

/// A number, a quantity or an expression, with the place where it was typed.
#[derive(Debug, Clone)]
pub struct Amount {
    expression: Expression,
    source: Arc<Source>,
    span: Span,
    /// A TOML number, which is SI; a text must carry its unit.
    plain: bool,
}

impl Amount {
    /// Reads a TOML number or text.
    ///
    /// # Errors
    /// The value is neither, or its text is no expression.
    pub fn read(value: &Value<'_>, source: &Arc<Source>) -> Result<Self, Fault> {
        let span = value.span();
        let expression = if value.is_text() {
            value.expression()?
        } else if !value.is_number() {
            return Err(value
                .fault(format!(
                    "expected a number, or a text with a unit, found {}",
                    value.describe()
                ))
                .help("write a quantity such as `\"5 N/m\"`, or a plain number in SI"));
        } else {
            let number = value.as_f64()?;
            Expression {
                node: Node::Number(number),
                span,
            }
        };
        Ok(Self {
            expression,
            source: Arc::clone(source),
            span,
            plain: !value.is_text(),
        })
    }

    /// An amount that is part of a larger expression.
    pub fn from_expression(expression: Expression, source: &Arc<Source>) -> Self {
        let span = expression.span;
        let plain = matches!(expression.node, Node::Number(_));
        Self {
            expression,
            source: Arc::clone(source),
            span,
            plain,
        }
    }

    /// A number that nobody typed, SI.
    pub(crate) fn si(number: f64) -> Self {
        let span = Span::new(0, 0);
        Self {
            expression: Expression {
                node: Node::Number(number),
                span,
            },
            source: Arc::new(Source::new(String::new(), String::new())),
            span,
            plain: true,
        }
    }

    /// As it was typed.
    pub(crate) fn typed(&self) -> String {
        let text = self.source.text.get(self.span.start..self.span.end);
        text.unwrap_or_default()
            .trim_matches(['"', '\''])
            .to_owned()
    }

    /// Where it was typed.
    pub const fn span(&self) -> Span {
        self.span
    }

    /// The file and the place in it.
    pub fn place(&self) -> (Arc<Source>, Span) {
        (Arc::clone(&self.source), self.span)
    }

    /// The expression.
    pub const fn expression(&self) -> &Expression {
        &self.expression
    }

    /// A fault at this amount.
    pub fn fault(&self, message: impl Into<String>) -> Fault {
        Fault::at(&self.source, self.span, message)
    }

    /// Whether it is a number alone, without unit or name: then it is SI.
    pub const fn is_plain(&self) -> bool {
        self.plain
    }

    /// The SI value with its dimension.
    ///
    /// # Errors
    /// Unknown names, units that do not fit together.
    pub fn quantity(&self, scope: &dyn Scope) -> Result<Quantity, Fault> {
        let quantity = self
            .expression
            .evaluate(scope)
            .map_err(|error| Fault::from_expression(&self.source, error))?;
        if quantity.value.is_finite() {
            Ok(quantity)
        } else {
            Err(self.fault(format!(
                "`{}` is not a finite number",
                self.expression.excerpt()
            )))
        }
    }

    /// The SI value, checked against what is expected. A plain number is taken as SI, save where a frequency is expected.
    ///
    /// # Errors
    /// As [`Self::quantity`]; the dimension is not the expected one; a plain number for a frequency.
    pub fn value(&self, scope: &dyn Scope, expected: Dimension) -> Result<f64, Fault> {
        let quantity = self.quantity(scope)?;
        if expected.accepts(&quantity.dimension) {
            return Ok(quantity.value);
        }
        let frequency = expected == Dimension::ANGULAR_FREQUENCY;
        // Zero is zero in Hz and in rad/s.
        if self.is_plain() && (!frequency || quantity.value == 0.0) {
            return Ok(quantity.value);
        }
        let unitless = quantity.dimension == Dimension::NONE;
        if frequency && unitless {
            let number = quantity.value;
            return Err(self
                .fault(format!(
                    "`{}` is ambiguous for a frequency",
                    self.expression.excerpt()
                ))
                .label("Hz or rad/s?")
                .help(format!("write \"{number} Hz\" or \"{number} rad/s\"")));
        }
        let fault = self.fault(format!(
            "expected {}, found {}",
            described(expected),
            described(quantity.dimension)
        ));
        Err(if frequency {
            fault.help("a frequency has the unit `Hz`, `rad/s` or `rpm`")
        } else if unitless {
            fault.help(format!(
                "write the unit after the number, such as `{}`",
                expected.unit_text()
            ))
        } else {
            fault
        })
    }
}

/// A dimension in words: "a quantity in `N/m`", or "a plain number".
pub(crate) fn described(dimension: Dimension) -> String {
    if dimension == Dimension::NONE {
        "a plain number".to_owned()
    } else {
        format!("a quantity in `{}`", dimension.unit_text())
    }
}
