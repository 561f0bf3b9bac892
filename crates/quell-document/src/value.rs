//! Values of a document.

use std::sync::Arc;

use quell_expression::{
    Dimension, Expression, ExpressionError, Node as Operation, Quantity, Scope, Span, nearest,
};

use crate::document::{Content, Node};
use crate::fault::Fault;
use crate::source::Source;
use crate::table::{Table, listed};

/// A value of a document.
#[derive(Debug, Clone)]
pub struct Value<'a> {
    source: &'a Arc<Source>,
    node: &'a Node,
}

impl<'a> Value<'a> {
    pub(crate) fn new(source: &'a Arc<Source>, node: &'a Node) -> Self {
        Self { source, node }
    }

    /// The place of the value, quotes and brackets included.
    pub fn span(&self) -> Span {
        self.node.span
    }

    /// The file the value stands in.
    pub fn source(&self) -> &'a Arc<Source> {
        self.source
    }

    /// Whether the value is a text.
    pub fn is_text(&self) -> bool {
        matches!(self.node.content, Content::Text { .. })
    }

    /// Whether the value is a number, whole or not.
    pub fn is_number(&self) -> bool {
        matches!(self.node.content, Content::Integer(_) | Content::Float(_))
    }

    /// Whether the value is a table.
    pub fn is_table(&self) -> bool {
        matches!(self.node.content, Content::Table(_))
    }

    /// Whether the value is an array.
    pub fn is_array(&self) -> bool {
        matches!(self.node.content, Content::Array(_))
    }

    /// Whether the value is `true` or `false`.
    pub fn is_bool(&self) -> bool {
        matches!(self.node.content, Content::Boolean(_))
    }

    /// What the value is, in words with their article.
    pub fn describe(&self) -> &'static str {
        match self.node.content {
            Content::Text { .. } => "a text",
            Content::Integer(_) => "an integer",
            Content::Float(_) => "a number",
            Content::Boolean(_) => "a boolean",
            Content::Array(_) => "a list",
            Content::Table(_) => "a table",
        }
    }

    /// The text, its escapes resolved.
    ///
    /// # Errors
    ///
    /// A fault if the value is no text.
    pub fn as_str(&self) -> Result<&'a str, Fault> {
        match &self.node.content {
            Content::Text { text, .. } => Ok(text),
            _ => Err(self.expected("a text")),
        }
    }

    /// The number, whole or not.
    ///
    /// # Errors
    ///
    /// A fault if the value is no number, or not a finite one.
    pub fn as_f64(&self) -> Result<f64, Fault> {
        match self.node.content {
            Content::Integer(Some(integer)) => Ok(integer as f64),
            Content::Integer(None) => Err(self
                .too_large()
                .help("write it with a decimal point or an exponent, such as `1e20`")),
            Content::Float(Some(number)) => Ok(number),
            Content::Float(None) => Err(self.not_finite()),
            _ => Err(self.expected("a number")),
        }
    }

    /// The whole number.
    ///
    /// # Errors
    ///
    /// A fault if the value is no integer, or one beyond 64 bits.
    pub fn as_integer(&self) -> Result<i64, Fault> {
        match self.node.content {
            Content::Integer(Some(integer)) => Ok(integer),
            Content::Integer(None) => Err(self.too_large()),
            _ => Err(self.expected("an integer")),
        }
    }

    /// The whole number, which may not be negative.
    ///
    /// # Errors
    ///
    /// A fault if the value is no integer, negative or too large.
    pub fn as_count(&self) -> Result<usize, Fault> {
        let integer = self.as_integer()?;
        if integer < 0 {
            return Err(self.fault(format!("`{integer}` must not be negative")));
        }
        usize::try_from(integer).map_err(|_| self.too_large())
    }

    /// `true` or `false`.
    ///
    /// # Errors
    ///
    /// A fault if the value is neither.
    pub fn as_bool(&self) -> Result<bool, Fault> {
        match self.node.content {
            Content::Boolean(boolean) => Ok(boolean),
            _ => Err(self.expected("`true` or `false`")),
        }
    }

    /// The values of a list.
    ///
    /// # Errors
    ///
    /// A fault if the value is no list.
    pub fn as_array(&self) -> Result<Vec<Value<'a>>, Fault> {
        match &self.node.content {
            Content::Array(nodes) => Ok(nodes
                .iter()
                .map(|node| Value::new(self.source, node))
                .collect()),
            _ => Err(self.expected("a list")),
        }
    }

    /// The table.
    ///
    /// # Errors
    ///
    /// A fault if the value is no table.
    pub fn as_table(&self) -> Result<Table<'a>, Fault> {
        match &self.node.content {
            Content::Table(table) => Ok(Table::new(self.source, self.node.span, table)),
            _ => Err(self.expected("a table")),
        }
    }

    /// The text, which has to be one of these; the one it is.
    ///
    /// # Errors
    ///
    /// A fault if the value is no text, or another one; it suggests the nearest.
    pub fn one_of(&self, choices: &[&'static str]) -> Result<&'static str, Fault> {
        let text = self.as_str()?;
        if let Some(choice) = choices.iter().find(|choice| **choice == text) {
            return Ok(choice);
        }
        let fault = self.fault(format!(
            "expected {}, found `{text}`",
            listed(choices.iter().copied(), "or")
        ));
        Err(match nearest(text, choices.iter().copied()) {
            Some(choice) => fault.help(format!("did you mean `{choice}`?")),
            None => fault,
        })
    }

    /// The text as an expression whose spans, all the way down, are places in the file; a number stands for itself.
    ///
    /// # Errors
    ///
    /// A fault if the value is neither, or at the place where the text is no expression.
    pub fn expression(&self) -> Result<Expression, Fault> {
        if self.is_number() {
            return Ok(Expression {
                node: number(self.as_f64()?, self.span()),
                span: self.span(),
            });
        }
        let Content::Text { text, .. } = &self.node.content else {
            return Err(self.expected("a text with an expression"));
        };
        let mut expression = Expression::parse(text).map_err(|error| {
            let span = self.text_span(error.span);
            Fault::from_expression(self.source, ExpressionError { span, ..error })
        })?;
        move_spans(&mut expression, |span| self.text_span(span));
        Ok(expression)
    }

    /// The place in the file of a byte span of the text; the whole value if it is written with escapes or is no text.
    pub fn text_span(&self, inner: Span) -> Span {
        match &self.node.content {
            Content::Text {
                offset: Some(offset),
                text,
            } => Span {
                start: offset + inner.start.min(text.len()),
                end: offset + inner.end.min(text.len()),
            },
            _ => self.node.span,
        }
    }

    /// The value as a quantity: a text is evaluated in the scope, a number is in SI units.
    ///
    /// Arguments: the names expressions may use, and the dimension wanted, if one is. The quantity returned has the
    /// wanted dimension. A number other than zero is refused for a frequency, since hertz and rad/s are both usual.
    ///
    /// # Errors
    ///
    /// A fault if the value is neither text nor number, at the place where the text cannot be read or evaluated, if it
    /// has another dimension than the wanted one, or is not finite.
    pub fn quantity(
        &self,
        scope: &dyn Scope,
        expected: Option<Dimension>,
    ) -> Result<Quantity, Fault> {
        if self.is_number() {
            return self.plain(expected);
        }
        if !self.is_text() {
            return Err(self.expected("a number, or a text with a unit"));
        }
        let quantity = self
            .expression()?
            .evaluate(scope)
            .map_err(|error| Fault::from_expression(self.source, error))?;
        if !quantity.value.is_finite() {
            return Err(self.not_finite());
        }
        let Some(wanted) = expected else {
            return Ok(quantity);
        };
        if wanted.accepts(&quantity.dimension) {
            return Ok(Quantity {
                value: quantity.value,
                dimension: wanted,
            });
        }
        let fault = self.fault(format!(
            "expected {}, found {}",
            in_words(wanted),
            in_words(quantity.dimension)
        ));
        Err(if wanted == Dimension::ANGULAR_FREQUENCY {
            fault.help("a frequency has the unit `Hz`, `rad/s` or `rpm`")
        } else if quantity.dimension == Dimension::NONE {
            fault.help(format!(
                "write a unit after the number, such as `{}`",
                wanted.unit_text()
            ))
        } else {
            fault
        })
    }

    /// A fault at the value.
    pub fn fault(&self, message: impl Into<String>) -> Fault {
        Fault::at(self.source, self.node.span, message)
    }

    /// A number as a quantity in SI units.
    fn plain(&self, expected: Option<Dimension>) -> Result<Quantity, Fault> {
        let value = self.as_f64()?;
        if expected == Some(Dimension::ANGULAR_FREQUENCY) && value != 0.0 {
            let written = self.written();
            return Err(self
                .fault(format!("`{written}` is ambiguous for a frequency"))
                .help(format!("write \"{written} Hz\" or \"{written} rad/s\"")));
        }
        Ok(Quantity {
            value,
            dimension: expected.unwrap_or(Dimension::NONE),
        })
    }

    fn expected(&self, what: &str) -> Fault {
        let fault = self.fault(format!("expected {what}, found {}", self.describe()));
        match (&self.node.content, what) {
            // A number in quotes is the usual slip, and the other way round.
            (Content::Text { text, .. }, "a number" | "an integer" | "`true` or `false`")
                if matches!(text.as_str(), "true" | "false") || text.parse::<f64>().is_ok() =>
            {
                fault.help("leave out the quotes")
            }
            _ => fault,
        }
    }

    fn too_large(&self) -> Fault {
        self.fault(format!("the integer `{}` is too large", self.written()))
    }

    fn not_finite(&self) -> Fault {
        self.fault(format!("`{}` must be finite", self.written()))
    }

    /// The value as it stands in the file, cut if it is long.
    fn written(&self) -> String {
        let raw = self.source.slice(self.node.span);
        let raw = raw.trim_matches(['"', '\'']).trim();
        if raw.chars().count() <= 40 {
            raw.to_owned()
        } else {
            raw.chars().take(39).chain(['…']).collect()
        }
    }
}

/// A number as the expression parser would give it: a minus sign is an operation.
fn number(value: f64, span: Span) -> Operation {
    if value.is_sign_negative() {
        Operation::Negate(Box::new(Expression {
            node: Operation::Number(-value),
            span,
        }))
    } else {
        Operation::Number(value)
    }
}

/// A dimension as what a reader would expect there.
fn in_words(dimension: Dimension) -> String {
    if dimension == Dimension::NONE {
        "a plain number".to_owned()
    } else {
        format!("a quantity in `{}`", dimension.unit_text())
    }
}

/// Moves every span of an expression; deep ones too, hence no recursion.
fn move_spans(expression: &mut Expression, place: impl Fn(Span) -> Span) {
    let mut left = vec![expression];
    while let Some(expression) = left.pop() {
        expression.span = place(expression.span);
        match &mut expression.node {
            Operation::Number(_) | Operation::Quantity { .. } | Operation::Name(_) => {}
            Operation::Negate(operand)
            | Operation::Not(operand)
            | Operation::Derivative { operand, .. } => left.push(operand),
            Operation::Binary {
                left: a, right: b, ..
            }
            | Operation::Comparison {
                left: a, right: b, ..
            }
            | Operation::Logic {
                left: a, right: b, ..
            } => left.extend([&mut **a, &mut **b]),
            Operation::Choice {
                condition,
                then,
                otherwise,
            } => left.extend([&mut **condition, &mut **then, &mut **otherwise]),
            Operation::Call {
                function_span,
                arguments,
                ..
            } => {
                *function_span = place(*function_span);
                left.extend(arguments);
            }
        }
    }
}
