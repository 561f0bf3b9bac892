//! Expressions: trees with the place of every part in the text.

use std::fmt;

use crate::{ExpressionError, Span, Unit};

/// An expression and where it stands.
#[derive(Debug, Clone, PartialEq)]
pub struct Expression {
    /// What it is.
    pub node: Node,
    /// Where it stands.
    pub span: Span,
}

/// The kinds of expression.
#[derive(Debug, Clone, PartialEq)]
pub enum Node {
    /// A plain number.
    Number(f64),
    /// A number with a unit after it.
    Quantity {
        /// The number as written.
        value: f64,
        /// The unit as written.
        unit: Unit,
    },
    /// A name, dotted perhaps: `track1.dL`.
    Name(String),
    /// -x.
    Negate(Box<Expression>),
    /// Two operands.
    Binary {
        /// Which operation.
        operator: BinaryOperator,
        /// First operand.
        left: Box<Expression>,
        /// Second operand.
        right: Box<Expression>,
    },
    /// A comparison, the loosest of all.
    Comparison {
        /// Which.
        operator: ComparisonOperator,
        /// First operand.
        left: Box<Expression>,
        /// Second operand.
        right: Box<Expression>,
    },
    /// A function of arguments.
    Call {
        /// Name of the function.
        function: String,
        /// Where the name stands.
        function_span: Span,
        /// The arguments.
        arguments: Vec<Expression>,
    },
    /// A time derivative: `x''`.
    Derivative {
        /// Number of primes, at least 1.
        order: usize,
        /// What is differentiated.
        operand: Box<Expression>,
    },
}

/// Operations of two operands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum BinaryOperator {
    /// +
    Add,
    /// -
    Subtract,
    /// *
    Multiply,
    /// /
    Divide,
    /// ^
    Power,
}

impl BinaryOperator {
    /// As it is written.
    #[must_use]
    pub const fn symbol(self) -> char {
        match self {
            Self::Add => '+',
            Self::Subtract => '-',
            Self::Multiply => '*',
            Self::Divide => '/',
            Self::Power => '^',
        }
    }
}

/// Comparisons.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ComparisonOperator {
    /// <
    Less,
    /// <=
    LessOrEqual,
    /// >
    Greater,
    /// >=
    GreaterOrEqual,
    /// ==
    Equal,
    /// !=
    NotEqual,
}

impl ComparisonOperator {
    /// As it is written.
    #[must_use]
    pub const fn symbol(self) -> &'static str {
        match self {
            Self::Less => "<",
            Self::LessOrEqual => "<=",
            Self::Greater => ">",
            Self::GreaterOrEqual => ">=",
            Self::Equal => "==",
            Self::NotEqual => "!=",
        }
    }
}

impl Expression {
    /// Reads an expression.
    ///
    /// In order of binding: comparisons, `+ -`, `* /`, unary `-`, `^` (to the right), postfix `'` (time derivative).
    /// A number directly followed by a unit word is a quantity, and the unit goes on over `*`, `/`, `^` and
    /// parentheses while unit words follow: `1.05e8 kg/(s*m^4)`, but `0.75 m * max(x)` is a product.
    ///
    /// # Errors
    /// At the character: what was expected and what was found.
    pub fn parse(text: &str) -> Result<Self, ExpressionError> {
        crate::parser::parse(text)
    }

    /// An expression that is not in a text.
    #[must_use]
    pub const fn bare(node: Node) -> Self {
        Self {
            node,
            span: Span::new(0, 0),
        }
    }

    /// Every part, itself first.
    pub fn walk(&self, visit: &mut impl FnMut(&Self)) {
        visit(self);
        match &self.node {
            Node::Number(_) | Node::Quantity { .. } | Node::Name(_) => {}
            Node::Negate(operand) | Node::Derivative { operand, .. } => operand.walk(visit),
            Node::Binary { left, right, .. } | Node::Comparison { left, right, .. } => {
                left.walk(visit);
                right.walk(visit);
            }
            Node::Call { arguments, .. } => {
                for argument in arguments {
                    argument.walk(visit);
                }
            }
        }
    }

    /// The names in it, each once, in the order of first use.
    #[must_use]
    pub fn names(&self) -> Vec<&str> {
        fn collect<'a>(expression: &'a Expression, names: &mut Vec<&'a str>) {
            match &expression.node {
                Node::Name(name) => {
                    if !names.contains(&name.as_str()) {
                        names.push(name);
                    }
                }
                Node::Number(_) | Node::Quantity { .. } => {}
                Node::Negate(operand) | Node::Derivative { operand, .. } => collect(operand, names),
                Node::Binary { left, right, .. } | Node::Comparison { left, right, .. } => {
                    collect(left, names);
                    collect(right, names);
                }
                Node::Call { arguments, .. } => {
                    for argument in arguments {
                        collect(argument, names);
                    }
                }
            }
        }
        let mut names = Vec::new();
        collect(self, &mut names);
        names
    }

    /// The same expression with every span and name passed through.
    #[must_use]
    pub fn map(&self, span: &impl Fn(Span) -> Span, name: &impl Fn(&str) -> String) -> Self {
        let boxed = |inner: &Self| Box::new(inner.map(span, name));
        let node = match &self.node {
            Node::Number(_) | Node::Quantity { .. } => self.node.clone(),
            Node::Name(own) => Node::Name(name(own)),
            Node::Negate(operand) => Node::Negate(boxed(operand)),
            Node::Derivative { order, operand } => Node::Derivative {
                order: *order,
                operand: boxed(operand),
            },
            Node::Binary {
                operator,
                left,
                right,
            } => Node::Binary {
                operator: *operator,
                left: boxed(left),
                right: boxed(right),
            },
            Node::Comparison {
                operator,
                left,
                right,
            } => Node::Comparison {
                operator: *operator,
                left: boxed(left),
                right: boxed(right),
            },
            Node::Call {
                function,
                function_span,
                arguments,
            } => Node::Call {
                function: function.clone(),
                function_span: span(*function_span),
                arguments: arguments
                    .iter()
                    .map(|argument| argument.map(span, name))
                    .collect(),
            },
        };
        Self {
            node,
            span: span(self.span),
        }
    }

    /// How tightly it binds: the larger the tighter.
    const fn binding(&self) -> u8 {
        match &self.node {
            Node::Comparison { .. } => 0,
            Node::Binary {
                operator: BinaryOperator::Add | BinaryOperator::Subtract,
                ..
            } => 1,
            // A quantity's unit would swallow what follows it, so it is held together by parentheses in every product.
            Node::Binary {
                operator: BinaryOperator::Multiply | BinaryOperator::Divide,
                ..
            }
            | Node::Quantity { .. } => 2,
            Node::Negate(_) => 3,
            Node::Binary {
                operator: BinaryOperator::Power,
                ..
            } => 4,
            Node::Number(value) => {
                if value.is_sign_negative() {
                    3
                } else {
                    6
                }
            }
            Node::Derivative { .. } => 5,
            Node::Name(_) | Node::Call { .. } => 6,
        }
    }
}

/// Writes `inner`, in parentheses where it binds less tightly than its place asks.
fn place(formatter: &mut fmt::Formatter<'_>, inner: &Expression, at_least: u8) -> fmt::Result {
    let held = matches!(inner.node, Node::Quantity { .. }) && at_least > 1;
    if inner.binding() < at_least || held {
        write!(formatter, "({inner})")
    } else {
        write!(formatter, "{inner}")
    }
}

impl fmt::Display for Expression {
    /// Text that reads back as the same tree.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.node {
            Node::Number(value) => write!(formatter, "{value}"),
            Node::Quantity { value, unit } => write!(formatter, "{value} {}", unit.text),
            Node::Name(name) => formatter.write_str(name),
            Node::Negate(operand) => {
                formatter.write_str("-")?;
                place(formatter, operand, 4)
            }
            Node::Binary {
                operator,
                left,
                right,
            } => {
                let (own, leftmost, rightmost) = match operator {
                    BinaryOperator::Add | BinaryOperator::Subtract => (1, 1, 2),
                    BinaryOperator::Multiply | BinaryOperator::Divide => (2, 2, 3),
                    BinaryOperator::Power => (4, 5, 4),
                };
                let _ = own;
                place(formatter, left, leftmost)?;
                match operator {
                    BinaryOperator::Add | BinaryOperator::Subtract => {
                        write!(formatter, " {} ", operator.symbol())?;
                    }
                    _ => write!(formatter, "{}", operator.symbol())?,
                }
                place(formatter, right, rightmost)
            }
            Node::Comparison {
                operator,
                left,
                right,
            } => {
                place(formatter, left, 1)?;
                write!(formatter, " {} ", operator.symbol())?;
                place(formatter, right, 1)
            }
            Node::Call {
                function,
                arguments,
                ..
            } => {
                write!(formatter, "{function}(")?;
                for (index, argument) in arguments.iter().enumerate() {
                    if index > 0 {
                        formatter.write_str(", ")?;
                    }
                    write!(formatter, "{argument}")?;
                }
                formatter.write_str(")")
            }
            Node::Derivative { order, operand } => {
                place(formatter, operand, 6)?;
                for _ in 0..*order {
                    formatter.write_str("'")?;
                }
                Ok(())
            }
        }
    }
}
