//! Values of expressions, with their dimensions checked.

use crate::expression::{BinaryOperator, ComparisonOperator, Expression, LogicalOperator, Node};
use crate::{Dimension, ExpressionError, Function, Quantity, Scope, Span, nearest};

impl Expression {
    /// The SI value with its dimension.
    ///
    /// # Errors
    /// At their place: unknown names (with the nearest valid one), operands whose units do not fit, a result that is
    /// not a finite number, time derivatives and comparisons (which have no value outside equations and constraints).
    pub fn evaluate(&self, scope: &dyn Scope) -> Result<Quantity, ExpressionError> {
        let (first, operations) = self.chain();
        let mut quantity = finite(first, first.part(scope)?)?;
        for operation in operations.into_iter().rev() {
            if let Node::Binary {
                operator, right, ..
            } = &operation.node
            {
                let other = right.evaluate(scope)?;
                quantity = finite(operation, combine(*operator, quantity, other, right)?)?;
            }
        }
        Ok(quantity)
    }

    fn part(&self, scope: &dyn Scope) -> Result<Quantity, ExpressionError> {
        match &self.node {
            Node::Number(value) => Ok(Quantity::number(*value)),
            Node::Quantity { value, unit } => {
                Ok(Quantity::new(value * unit.factor, unit.dimension))
            }
            Node::Name(name) => named(name, self.span, scope),
            Node::Negate(operand) => {
                let operand = operand.evaluate(scope)?;
                Ok(Quantity::new(-operand.value, operand.dimension))
            }
            // The first operand of a chain is no operation.
            Node::Binary { .. } => self.evaluate(scope),
            Node::Call {
                function,
                function_span,
                arguments,
            } => {
                let known = look_up(function, *function_span, arguments.len())?;
                let values = arguments
                    .iter()
                    .map(|argument| argument.evaluate(scope))
                    .collect::<Result<Vec<_>, _>>()?;
                known.apply(&values).map_err(|(index, message)| {
                    let span = arguments
                        .get(index)
                        .map_or(self.span, |argument| argument.span);
                    ExpressionError::new(span, message)
                })
            }
            Node::Choice {
                condition,
                then,
                otherwise,
            } => {
                let (chosen, other) = if condition.holds(scope)? {
                    (then, otherwise)
                } else {
                    (otherwise, then)
                };
                let value = chosen.evaluate(scope)?;
                // The other may have no value here, as 1/x at zero; where it has one, its unit must fit.
                if let Ok(unused) = other.evaluate(scope)
                    && !value.dimension.agrees(&unused.dimension)
                {
                    return Err(unlike_branches(
                        other.span,
                        unused.dimension,
                        value.dimension,
                    ));
                }
                Ok(value)
            }
            Node::Derivative { .. }
            | Node::Comparison { .. }
            | Node::Logic { .. }
            | Node::Not(_) => Err(no_value(self)),
        }
    }

    /// Whether a condition holds.
    ///
    /// # Errors
    /// As [`Self::evaluate`], and for what is no condition.
    pub fn holds(&self, scope: &dyn Scope) -> Result<bool, ExpressionError> {
        match &self.node {
            Node::Comparison {
                operator,
                left,
                right,
            } => {
                let (a, b) = (left.evaluate(scope)?, right.evaluate(scope)?);
                if !a.dimension.agrees(&b.dimension) {
                    return Err(unlike_sides(right.span, b.dimension, a.dimension));
                }
                Ok(match operator {
                    ComparisonOperator::Less => a.value < b.value,
                    ComparisonOperator::LessOrEqual => a.value <= b.value,
                    ComparisonOperator::Greater => a.value > b.value,
                    ComparisonOperator::GreaterOrEqual => a.value >= b.value,
                    ComparisonOperator::Equal => a.value == b.value,
                    ComparisonOperator::NotEqual => a.value != b.value,
                })
            }
            Node::Logic { .. } => {
                let (first, operations) = self.logic_chain();
                let mut holds = first.holds(scope)?;
                for (operator, right) in operations.into_iter().rev() {
                    let other = right.holds(scope)?;
                    holds = match operator {
                        LogicalOperator::And => holds && other,
                        LogicalOperator::Or => holds || other,
                    };
                }
                Ok(holds)
            }
            Node::Not(operand) => Ok(!operand.holds(scope)?),
            _ => Err(no_condition(self)),
        }
    }
}

/// The error for branches of unlike dimension.
pub(crate) fn unlike_branches(span: Span, found: Dimension, other: Dimension) -> ExpressionError {
    ExpressionError::new(span, format!("one branch is {found}, the other {other}"))
}

/// The error for a comparison of unlike dimensions.
pub(crate) fn unlike_sides(span: Span, found: Dimension, other: Dimension) -> ExpressionError {
    ExpressionError::new(span, format!("cannot compare {other} with {found}"))
}

/// The error for a value where a condition belongs.
pub(crate) fn no_condition(expression: &Expression) -> ExpressionError {
    let text = expression.excerpt();
    ExpressionError::new(
        expression.span,
        format!("`{text}` is a value, where a condition is expected"),
    )
    .with_help("a condition compares, such as `x > 0`")
}

fn finite(expression: &Expression, quantity: Quantity) -> Result<Quantity, ExpressionError> {
    if quantity.value.is_finite() {
        Ok(quantity)
    } else {
        Err(not_finite(expression))
    }
}

/// The value of an operation on `a` and `b`, which is the value of `right`.
fn combine(
    operator: BinaryOperator,
    a: Quantity,
    b: Quantity,
    right: &Expression,
) -> Result<Quantity, ExpressionError> {
    let dimension = binary_dimension(operator, a, b, right.span)?;
    let value = match operator {
        BinaryOperator::Add => a.value + b.value,
        BinaryOperator::Subtract => a.value - b.value,
        BinaryOperator::Multiply => a.value * b.value,
        BinaryOperator::Divide if b.value == 0.0 => {
            return Err(ExpressionError::new(
                right.span,
                format!("`{}` is zero, and it divides", right.excerpt()),
            ));
        }
        BinaryOperator::Divide => a.value / b.value,
        BinaryOperator::Power => power(a.value, b.value),
    };
    Ok(Quantity::new(value, dimension))
}

/// The error for a value that is infinite or not a number.
pub(crate) fn not_finite(expression: &Expression) -> ExpressionError {
    ExpressionError::new(
        expression.span,
        format!("`{}` is not a finite number", expression.excerpt()),
    )
}

/// The error for an expression that has no value by itself.
pub(crate) fn no_value(expression: &Expression) -> ExpressionError {
    let text = expression.excerpt();
    let message = match expression.node {
        Node::Derivative { .. } => {
            format!("`{text}` is a time derivative, and nothing here varies in time")
        }
        Node::Logic { .. } | Node::Not(_) => {
            format!("`{text}` is a condition, where a number is expected")
        }
        _ => format!("`{text}` is a comparison, where a number is expected"),
    };
    ExpressionError::new(expression.span, message)
}

impl Expression {
    /// The expression as text, cut where it would swamp a message: the place says the rest.
    #[must_use]
    pub fn excerpt(&self) -> String {
        const LONGEST: usize = 60;
        let text = self.to_string();
        match text.char_indices().nth(LONGEST) {
            Some((end, _)) => format!("{}…", text.get(..end).unwrap_or("")),
            None => text,
        }
    }
}

/// x^y; moderate whole powers by multiplication alone, so that they have the same bits on every platform.
pub(crate) fn power(base: f64, exponent: f64) -> f64 {
    match as_whole(exponent) {
        Some(whole) => whole_power(base, whole),
        None => base.powf(exponent),
    }
}

/// An exponent that [`whole_power`] takes.
pub(crate) fn as_whole(exponent: f64) -> Option<i32> {
    (exponent.fract() == 0.0 && exponent.abs() <= 64.0).then_some(exponent as i32)
}

/// x^n by repeated squaring; n = 0 gives 1 whatever x.
#[inline]
pub(crate) fn whole_power(base: f64, exponent: i32) -> f64 {
    let mut left = exponent.unsigned_abs();
    let (mut square, mut result) = (base, 1.0);
    while left > 0 {
        if left % 2 == 1 {
            result *= square;
        }
        square *= square;
        left /= 2;
    }
    if exponent < 0 { 1.0 / result } else { result }
}

fn named(name: &str, span: Span, scope: &dyn Scope) -> Result<Quantity, ExpressionError> {
    if let Some(quantity) = scope.quantity(name) {
        return Ok(quantity);
    }
    if name == "pi" {
        return Ok(Quantity::number(std::f64::consts::PI));
    }
    Err(unknown_name(name, span, scope))
}

/// The error for a name that stands for nothing, with the nearest that does.
#[must_use]
pub fn unknown_name(name: &str, span: Span, scope: &dyn Scope) -> ExpressionError {
    unknown_name_among(name, span, scope.names())
}

/// The error for a name that stands for nothing, where others do.
pub(crate) fn unknown_name_among(name: &str, span: Span, names: Vec<&str>) -> ExpressionError {
    let error = ExpressionError::new(span, format!("unknown name `{name}`"));
    if Function::from_name(name).is_some() {
        return error.with_help(format!("`{name}` is a function: `{name}(…)`"));
    }
    match nearest(name, names) {
        Some(near) => error.with_help(format!("did you mean `{near}`?")),
        None if crate::unit::look_up(name).is_some() => error.with_help(format!(
            "`{name}` is a unit, which stands directly after a number: `5 {name}`"
        )),
        None => error,
    }
}

/// The function of a name, with as many arguments.
pub(crate) fn look_up(name: &str, span: Span, count: usize) -> Result<Function, ExpressionError> {
    look_up_among(name, span, count, Vec::new())
}

/// The function of a name, with as many arguments, where there are others of the user's.
pub(crate) fn look_up_among(
    name: &str,
    span: Span,
    count: usize,
    others: Vec<&str>,
) -> Result<Function, ExpressionError> {
    let Some(function) = Function::from_name(name) else {
        let error = ExpressionError::new(span, format!("unknown function `{name}`"));
        return Err(
            match nearest(
                name,
                Function::ALL.iter().map(|(known, _)| *known).chain(others),
            ) {
                Some(near) => error.with_help(format!("did you mean `{near}`?")),
                None => error,
            },
        );
    };
    let (least, most) = function.arguments();
    if count < least || count > most {
        let takes = match (least, most) {
            (1, 1) => "one argument".to_owned(),
            (a, b) if a == b => format!("{a} arguments"),
            (a, _) => format!("at least {a} arguments"),
        };
        return Err(ExpressionError::new(
            span,
            format!("`{name}` takes {takes}, found {count}"),
        ));
    }
    Ok(function)
}

/// The dimension of an operation on two quantities; the exponent's value matters for a power.
fn binary_dimension(
    operator: BinaryOperator,
    a: Quantity,
    b: Quantity,
    b_span: Span,
) -> Result<Dimension, ExpressionError> {
    match operator {
        BinaryOperator::Add | BinaryOperator::Subtract => {
            if a.dimension.agrees(&b.dimension) {
                Ok(a.dimension.joined(b.dimension))
            } else {
                let (verb, joint) = if operator == BinaryOperator::Add {
                    ("add", "to")
                } else {
                    ("subtract", "from")
                };
                Err(ExpressionError::new(
                    b_span,
                    format!("cannot {verb} {} {joint} {}", b.dimension, a.dimension),
                ))
            }
        }
        BinaryOperator::Multiply => Ok(a.dimension * b.dimension),
        BinaryOperator::Divide => Ok(a.dimension / b.dimension),
        BinaryOperator::Power => {
            if !b.dimension.is_none() {
                return Err(ExpressionError::new(
                    b_span,
                    format!("an exponent is a plain number, found {}", b.dimension),
                ));
            }
            a.dimension.power(b.value).ok_or_else(|| {
                ExpressionError::new(
                    b_span,
                    format!("{} cannot be raised to the power {}", a.dimension, b.value),
                )
            })
        }
    }
}
