//! From text to graph: names are resolved, dimensions checked, time derivatives taken.

mod call;
mod names;
mod power;

use std::collections::HashMap;

pub use names::{Meaning, Names, Rate};

use crate::evaluate::{
    no_condition, no_value, not_finite, unknown_name_among, unlike_branches, unlike_sides,
};
use crate::expression::{BinaryOperator, Expression, Node};
use crate::{Condition, Differentiation, Dimension, ExpressionError, Graph, Slot, Span};

/// Expressions under evaluation may be nested so deeply, definitions and functions included.
const DEPTH: usize = 400;

/// Lowers one expression, see [`Lowering`].
///
/// # Errors
/// As [`Lowering::lower`].
pub fn lower(
    graph: &mut Graph,
    expression: &Expression,
    names: &dyn Names,
) -> Result<(Slot, Dimension), ExpressionError> {
    Lowering::new(names).lower(graph, expression)
}

/// Turns expressions into operations of a graph, in one vocabulary; definitions are lowered once, where first used.
///
/// All numbers become SI. Dimensions are checked as [`Expression::evaluate`] does, save that rad is not looked at (in an
/// equation of motion arms turn angles into lengths), that a literal 0 is of any dimension, and that a power of a
/// quantity needs an exponent whose value is known. `'` and `d(…)` differentiate formally: what is in `hold(…)` counts
/// as constant.
///
/// One graph for one lowering: what was lowered before is remembered by its slots.
pub struct Lowering<'a> {
    names: &'a dyn Names,
    definitions: HashMap<String, Lowered>,
    calls: HashMap<(String, Vec<Lowered>), Lowered>,
    /// Definitions and functions being lowered, outermost first.
    stack: Vec<String>,
    depth: usize,
    /// Whether the part at hand belongs to a branch, which may never be taken.
    in_branch: bool,
}

/// An expression in the graph; without dimension it is a literal zero, which is of any.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Lowered {
    slot: Slot,
    dimension: Option<Dimension>,
}

impl Lowered {
    const fn new(slot: Slot, dimension: Dimension) -> Self {
        Self {
            slot,
            dimension: Some(dimension),
        }
    }

    fn plain(self) -> Dimension {
        self.dimension.unwrap_or_default()
    }
}

/// Arguments of the function whose body is being lowered.
type Locals<'e> = &'e [(&'e str, Lowered)];

impl<'a> Lowering<'a> {
    /// A lowering in a vocabulary.
    #[must_use]
    pub fn new(names: &'a dyn Names) -> Self {
        Self {
            names,
            definitions: HashMap::new(),
            calls: HashMap::new(),
            stack: Vec::new(),
            depth: 0,
            in_branch: false,
        }
    }

    /// The slot and dimension of an expression.
    ///
    /// # Errors
    /// At their place: unknown names and functions (with the nearest valid one), operands whose units do not fit,
    /// definitions and functions that need themselves, derivatives that nothing provides, constants that are not finite.
    pub fn lower(
        &mut self,
        graph: &mut Graph,
        expression: &Expression,
    ) -> Result<(Slot, Dimension), ExpressionError> {
        // What an error interrupted must not count.
        self.stack.clear();
        self.depth = 0;
        self.in_branch = false;
        let lowered = self.expression(graph, expression, &[])?;
        let dimension = if self.names.dimensionless() {
            Dimension::NONE
        } else {
            lowered.plain()
        };
        Ok((lowered.slot, dimension))
    }

    /// The condition that an expression states.
    ///
    /// # Errors
    /// As [`Self::lower`], and for what is no condition.
    pub fn condition(
        &mut self,
        graph: &mut Graph,
        expression: &Expression,
    ) -> Result<Condition, ExpressionError> {
        self.stack.clear();
        self.depth = 0;
        self.in_branch = false;
        self.condition_of(graph, expression, &[])
    }

    fn expression(
        &mut self,
        graph: &mut Graph,
        expression: &Expression,
        locals: Locals<'_>,
    ) -> Result<Lowered, ExpressionError> {
        self.deeper(expression.span)?;
        let (first, operations) = expression.chain();
        let mut lowered = self.operand(graph, first, locals)?;
        self.finite(graph, first, lowered.slot)?;
        for operation in operations.into_iter().rev() {
            if let Node::Binary {
                operator, right, ..
            } = &operation.node
            {
                let other = self.expression(graph, right, locals)?;
                lowered = self.combine(graph, *operator, lowered, other, right)?;
                self.finite(graph, operation, lowered.slot)?;
            }
        }
        self.depth -= 1;
        Ok(lowered)
    }

    /// Anything but an operation of two operands.
    fn operand(
        &mut self,
        graph: &mut Graph,
        expression: &Expression,
        locals: Locals<'_>,
    ) -> Result<Lowered, ExpressionError> {
        match &expression.node {
            Node::Number(value) => Ok(Lowered {
                slot: graph.constant(*value),
                dimension: (*value != 0.0).then_some(Dimension::NONE),
            }),
            Node::Quantity { value, unit } => Ok(Lowered::new(
                graph.constant(value * unit.factor),
                unit.dimension,
            )),
            Node::Name(name) => self.name(graph, name, expression.span, locals),
            Node::Negate(operand) => {
                let lowered = self.expression(graph, operand, locals)?;
                Ok(Lowered {
                    slot: graph.negate(lowered.slot),
                    ..lowered
                })
            }
            Node::Derivative { order, operand } => {
                let mut lowered = self.expression(graph, operand, locals)?;
                for _ in 0..*order {
                    lowered = self.rate(graph, lowered, expression)?;
                }
                Ok(lowered)
            }
            Node::Choice {
                condition,
                then,
                otherwise,
            } => {
                let condition = self.condition_of(graph, condition, locals)?;
                let outer = std::mem::replace(&mut self.in_branch, true);
                let then = self.expression(graph, then, locals)?;
                let other = self.expression(graph, otherwise, locals)?;
                self.in_branch = outer;
                let dimension = self
                    .joined(then, other)
                    .map_err(|(first, second)| unlike_branches(otherwise.span, second, first))?;
                let slot = graph.choose(&condition, then.slot, other.slot);
                Ok(Lowered { slot, dimension })
            }
            Node::Call {
                function,
                function_span,
                arguments,
            } => self.call(
                graph,
                (function, *function_span),
                arguments,
                expression,
                locals,
            ),
            // The first operand of a chain is no operation.
            Node::Binary { .. } => self.expression(graph, expression, locals),
            Node::Comparison { .. } | Node::Logic { .. } | Node::Not(_) => {
                Err(no_value(expression))
            }
        }
    }

    fn name(
        &mut self,
        graph: &mut Graph,
        name: &str,
        span: Span,
        locals: Locals<'_>,
    ) -> Result<Lowered, ExpressionError> {
        if let Some((_, local)) = locals.iter().find(|(local, _)| *local == name) {
            return Ok(*local);
        }
        match self.names.resolve(name) {
            Some(Meaning::Input(index, dimension)) => {
                Ok(Lowered::new(graph.input(index), dimension))
            }
            Some(Meaning::Value(slot, dimension)) => Ok(Lowered::new(slot, dimension)),
            Some(Meaning::Constant(quantity)) => Ok(Lowered::new(
                graph.constant(quantity.value),
                quantity.dimension,
            )),
            Some(Meaning::Definition(definition)) => {
                if let Some(known) = self.definitions.get(name) {
                    return Ok(*known);
                }
                self.enter(name, span, "is defined by itself")?;
                let lowered = self
                    .expression(graph, definition, &[])
                    .map_err(|error| self.placed(error, name, span))?;
                self.stack.pop();
                self.definitions.insert(name.to_owned(), lowered);
                Ok(lowered)
            }
            Some(Meaning::Function(signature, _)) => {
                let names = signature.arguments.iter().map(|one| one.name.as_str());
                let head = format!("{name}({})", names.collect::<Vec<_>>().join(", "));
                Err(ExpressionError::new(
                    span,
                    format!("`{name}` is a function, and has no value without arguments"),
                )
                .with_help(format!("write `{head}`")))
            }
            None if name == "pi" => Ok(Lowered::new(
                graph.constant(std::f64::consts::PI),
                Dimension::NONE,
            )),
            None => {
                let mut names: Vec<&str> = locals.iter().map(|(local, _)| *local).collect();
                names.extend(self.names.names());
                Err(unknown_name_among(name, span, names))
            }
        }
    }

    fn combine(
        &self,
        graph: &mut Graph,
        operator: BinaryOperator,
        a: Lowered,
        b: Lowered,
        right: &Expression,
    ) -> Result<Lowered, ExpressionError> {
        match operator {
            BinaryOperator::Add | BinaryOperator::Subtract => {
                let dimension = self.joined(a, b).map_err(|(first, second)| {
                    let words = if operator == BinaryOperator::Add {
                        format!("cannot add {second} to {first}")
                    } else {
                        format!("cannot subtract {second} from {first}")
                    };
                    ExpressionError::new(right.span, words)
                })?;
                let slot = if operator == BinaryOperator::Add {
                    graph.add(a.slot, b.slot)
                } else {
                    graph.subtract(a.slot, b.slot)
                };
                Ok(Lowered { slot, dimension })
            }
            BinaryOperator::Multiply => Ok(Lowered::new(
                graph.multiply(a.slot, b.slot),
                a.plain() * b.plain(),
            )),
            BinaryOperator::Divide => {
                if graph.as_constant(b.slot) == Some(0.0) && !self.in_branch {
                    let words = format!("`{}` is zero, and it divides", right.excerpt());
                    return Err(ExpressionError::new(right.span, words));
                }
                Ok(Lowered::new(
                    graph.divide(a.slot, b.slot),
                    a.plain() / b.plain(),
                ))
            }
            BinaryOperator::Power => Ok(Lowered::new(
                graph.power(a.slot, b.slot),
                self.power_dimension(graph, a.plain(), b, right)?,
            )),
        }
    }

    /// The dimension of what must be of the same: rad is not looked at, a literal zero fits.
    fn joined(&self, a: Lowered, b: Lowered) -> Result<Option<Dimension>, (Dimension, Dimension)> {
        let (first, second) = match (a.dimension, b.dimension) {
            (Some(first), Some(second)) => (first, second),
            (one, None) | (None, one) => return Ok(one),
        };
        if first.agrees(&second) {
            Ok(Some(first.joined(second)))
        } else if first.without_angle() == second.without_angle() {
            Ok(Some(first.without_angle()))
        } else if self.names.dimensionless() {
            Ok(Some(Dimension::NONE))
        } else {
            Err((first, second))
        }
    }

    fn condition_of(
        &mut self,
        graph: &mut Graph,
        expression: &Expression,
        locals: Locals<'_>,
    ) -> Result<Condition, ExpressionError> {
        self.deeper(expression.span)?;
        let condition = match &expression.node {
            Node::Comparison {
                operator,
                left,
                right,
            } => {
                let a = self.expression(graph, left, locals)?;
                let b = self.expression(graph, right, locals)?;
                self.joined(a, b)
                    .map_err(|(first, second)| unlike_sides(right.span, second, first))?;
                Condition::of(*operator, a.slot, b.slot)
            }
            Node::Logic { .. } => {
                let (first, operations) = expression.logic_chain();
                let mut condition = self.condition_of(graph, first, locals)?;
                for (operator, right) in operations.into_iter().rev() {
                    let other = self.condition_of(graph, right, locals)?;
                    condition = condition.joined(operator, other);
                }
                condition
            }
            Node::Not(operand) => self.condition_of(graph, operand, locals)?.negated(),
            _ => return Err(no_condition(expression)),
        };
        self.depth -= 1;
        Ok(condition)
    }

    /// The formal derivative in time; `whole` is the expression with its primes.
    fn rate(
        &self,
        graph: &mut Graph,
        of: Lowered,
        whole: &Expression,
    ) -> Result<Lowered, ExpressionError> {
        let mut seeds = Vec::new();
        for input in graph.formal_dependence(of.slot) {
            let rate = match self.names.rate(input) {
                Rate::Constant(0.0) => continue,
                Rate::Constant(value) => graph.constant(value),
                Rate::Input(index) => graph.input(index),
                Rate::Value(slot) => slot,
                Rate::Unknown(words) => {
                    let text = whole.excerpt();
                    let words = format!("`{text}` needs {words}, which nothing here says");
                    return Err(ExpressionError::new(whole.span, words));
                }
            };
            seeds.push((input, rate));
        }
        let slope = graph
            .tangent(&[of.slot], &seeds, Differentiation::Formal)
            .into_iter()
            .next()
            .flatten();
        Ok(Lowered {
            slot: slope.unwrap_or_else(|| graph.constant(0.0)),
            dimension: of.dimension.map(|dimension| dimension / Dimension::TIME),
        })
    }

    /// Refuses a constant that is infinite or not a number.
    fn finite(
        &self,
        graph: &Graph,
        expression: &Expression,
        slot: Slot,
    ) -> Result<(), ExpressionError> {
        match graph.as_constant(slot) {
            Some(value) if !value.is_finite() && !self.in_branch => Err(not_finite(expression)),
            _ => Ok(()),
        }
    }

    fn deeper(&mut self, span: Span) -> Result<(), ExpressionError> {
        self.depth += 1;
        if self.depth <= DEPTH {
            return Ok(());
        }
        Err(ExpressionError::new(
            span,
            format!("definitions lead more than {DEPTH} deep here"),
        )
        .with_help("let fewer of them build on one another"))
    }

    /// Begins a definition or a function's body; refuses those in which it is already.
    fn enter(&mut self, name: &str, span: Span, what: &str) -> Result<(), ExpressionError> {
        if let Some(first) = self.stack.iter().position(|known| known == name) {
            let round = self.stack.iter().skip(first).map(String::as_str);
            let round: Vec<&str> = round.chain([name]).collect();
            return Err(ExpressionError::new(span, format!("`{name}` {what}"))
                .with_help(format!("it goes round: {}", round.join(" → "))));
        }
        self.stack.push(name.to_owned());
        Ok(())
    }

    /// An error within a definition or function, where the reader can see it.
    fn placed(&self, error: ExpressionError, name: &str, span: Span) -> ExpressionError {
        if !self.names.elsewhere(name) {
            return error;
        }
        ExpressionError {
            span,
            message: format!("in `{name}`: {}", error.message),
            help: error.help,
        }
    }
}
