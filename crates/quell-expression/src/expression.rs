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
    /// Two conditions.
    Logic {
        /// Which.
        operator: LogicalOperator,
        /// First condition.
        left: Box<Expression>,
        /// Second condition.
        right: Box<Expression>,
    },
    /// The opposite of a condition.
    Not(Box<Expression>),
    /// One of two values: `if x > 0 then k*x else 0`.
    Choice {
        /// What decides.
        condition: Box<Expression>,
        /// The value where it holds.
        then: Box<Expression>,
        /// The value elsewhere.
        otherwise: Box<Expression>,
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

/// What joins conditions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LogicalOperator {
    /// Both.
    And,
    /// At least one.
    Or,
}

impl LogicalOperator {
    /// As it is written.
    #[must_use]
    pub const fn symbol(self) -> &'static str {
        match self {
            Self::And => "and",
            Self::Or => "or",
        }
    }
}

/// Words of the language, which name nothing else.
pub(crate) const RESERVED: [&str; 6] = ["if", "then", "else", "and", "or", "not"];

impl Expression {
    /// Reads an expression.
    ///
    /// In order of binding, loosest first: `if … then … else …` (which reaches as far as it can, and stands in
    /// parentheses inside a sum or product), `or`, `and`, `not`, comparisons, `+ -`, `* /`, unary `-`, `^` (from the right, so that `2^3^2` is
    /// 2⁹ and `-2^2` is -4), postfix `'` (time derivative of a name, a call or a parenthesis).
    ///
    /// A number directly followed by a unit word (or by `1/` and one: `0.5 1/s`) is a quantity. Its unit goes on over
    /// `*`, `/`, `^` and parentheses while unit words follow, so `1.05e8 kg/(s*m^4)` is one quantity, but in
    /// `0.75 m * max(x)` a call follows and ends it, as a name that is no unit, a dotted name or a prime does.
    ///
    /// **A unit word goes first**: after a quantity `*` and `/` take a unit's name for the unit even where a parameter
    /// is called the same. `3 m/s*t` is 3 metres a second times a *tonne*; write `(3 m/s)*t` or `t*3 m/s`.
    ///
    /// # Errors
    /// At the character: what was expected and what was found.
    pub fn parse(text: &str) -> Result<Self, ExpressionError> {
        crate::parser::parse(text)
    }

    /// Reads an equation, `left = right`.
    ///
    /// # Errors
    /// At the character: what was expected and what was found.
    pub fn parse_equation(text: &str) -> Result<(Self, Self), ExpressionError> {
        crate::parser::parse_equation(text)
    }

    /// An expression that is not in a text.
    #[must_use]
    pub const fn bare(node: Node) -> Self {
        Self {
            node,
            span: Span::new(0, 0),
        }
    }

    /// The parts that it is directly made of, from left to right.
    #[must_use]
    pub fn parts(&self) -> Vec<&Self> {
        match &self.node {
            Node::Number(_) | Node::Quantity { .. } | Node::Name(_) => Vec::new(),
            Node::Negate(operand) | Node::Not(operand) | Node::Derivative { operand, .. } => {
                vec![operand]
            }
            Node::Binary { left, right, .. }
            | Node::Comparison { left, right, .. }
            | Node::Logic { left, right, .. } => vec![left, right],
            Node::Choice {
                condition,
                then,
                otherwise,
            } => vec![condition, then, otherwise],
            Node::Call { arguments, .. } => arguments.iter().collect(),
        }
    }

    /// Every part, itself first.
    pub fn walk(&self, visit: &mut impl FnMut(&Self)) {
        visit(self);
        for part in self.parts() {
            part.walk(visit);
        }
    }

    /// The first operand of a chain such as a - b + c, and its operations from the last to the first.
    ///
    /// Chains may be thousands long, where parentheses nest by the dozen: who follows them in a loop needs little stack.
    pub(crate) fn chain(&self) -> (&Self, Vec<&Self>) {
        let (mut first, mut operations) = (self, Vec::new());
        while let Node::Binary { left, .. } = &first.node {
            operations.push(first);
            first = left;
        }
        (first, operations)
    }

    /// The first condition of a chain such as a and b or c, and what is joined to it from the last to the first.
    pub(crate) fn logic_chain(&self) -> (&Self, Vec<(LogicalOperator, &Self)>) {
        let (mut first, mut operations) = (self, Vec::new());
        while let Node::Logic {
            operator,
            left,
            right,
        } = &first.node
        {
            operations.push((*operator, &**right));
            first = left;
        }
        (first, operations)
    }

    /// The names in it, each once, in the order of first use.
    #[must_use]
    pub fn names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        let mut left_to_see = vec![self];
        while let Some(expression) = left_to_see.pop() {
            if let Node::Name(name) = &expression.node
                && !names.contains(&name.as_str())
            {
                names.push(name);
            }
            left_to_see.extend(expression.parts().into_iter().rev());
        }
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
            Node::Logic {
                operator,
                left,
                right,
            } => Node::Logic {
                operator: *operator,
                left: boxed(left),
                right: boxed(right),
            },
            Node::Not(operand) => Node::Not(boxed(operand)),
            Node::Choice {
                condition,
                then,
                otherwise,
            } => Node::Choice {
                condition: boxed(condition),
                then: boxed(then),
                otherwise: boxed(otherwise),
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

    /// How tightly it binds.
    const fn binding(&self) -> Binding {
        match &self.node {
            Node::Choice { .. } => Binding::Choice,
            Node::Logic { operator, .. } => match operator {
                LogicalOperator::Or => Binding::Or,
                LogicalOperator::And => Binding::And,
            },
            Node::Not(_) => Binding::Not,
            Node::Comparison { .. } => Binding::Comparison,
            Node::Binary { operator, .. } => match operator {
                BinaryOperator::Add | BinaryOperator::Subtract => Binding::Sum,
                BinaryOperator::Multiply | BinaryOperator::Divide => Binding::Product,
                BinaryOperator::Power => Binding::Power,
            },
            Node::Negate(operand) if matches!(operand.node, Node::Quantity { .. }) => Binding::Unit,
            Node::Quantity { .. } => Binding::Unit,
            Node::Number(value) if value.is_sign_negative() => Binding::Sign,
            Node::Negate(_) => Binding::Sign,
            Node::Derivative { .. } => Binding::Prime,
            Node::Number(_) | Node::Name(_) | Node::Call { .. } => Binding::Atom,
        }
    }

    fn write(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.node {
            Node::Number(value) => write_number(formatter, *value),
            Node::Quantity { value, unit } => {
                write_number(formatter, *value)?;
                formatter.write_str(" ")?;
                formatter.write_str(&unit.text)
            }
            Node::Name(name) => formatter.write_str(name),
            Node::Negate(operand) => {
                formatter.write_str("-")?;
                if matches!(operand.node, Node::Quantity { .. }) {
                    return operand.write(formatter);
                }
                operand.write_at(formatter, Binding::Power)
            }
            Node::Binary {
                operator,
                left,
                right,
            } => {
                let (symbol, before, after) = match operator {
                    BinaryOperator::Add => (" + ", Binding::Sum, Binding::Unit),
                    BinaryOperator::Subtract => (" - ", Binding::Sum, Binding::Unit),
                    BinaryOperator::Multiply => ("*", Binding::Product, Binding::Sign),
                    BinaryOperator::Divide => ("/", Binding::Product, Binding::Sign),
                    BinaryOperator::Power => ("^", Binding::Prime, Binding::Sign),
                };
                left.write_at(formatter, before)?;
                formatter.write_str(symbol)?;
                right.write_at(formatter, after)
            }
            Node::Comparison {
                operator,
                left,
                right,
            } => {
                left.write_at(formatter, Binding::Sum)?;
                formatter.write_str(" ")?;
                formatter.write_str(operator.symbol())?;
                formatter.write_str(" ")?;
                right.write_at(formatter, Binding::Sum)
            }
            Node::Logic {
                operator,
                left,
                right,
            } => {
                let (before, after) = match operator {
                    LogicalOperator::Or => (Binding::Or, Binding::And),
                    LogicalOperator::And => (Binding::And, Binding::Not),
                };
                left.write_at(formatter, before)?;
                write!(formatter, " {} ", operator.symbol())?;
                right.write_at(formatter, after)
            }
            Node::Not(operand) => {
                formatter.write_str("not ")?;
                operand.write_at(formatter, Binding::Not)
            }
            Node::Choice {
                condition,
                then,
                otherwise,
            } => {
                formatter.write_str("if ")?;
                condition.write_at(formatter, Binding::Or)?;
                formatter.write_str(" then ")?;
                then.write(formatter)?;
                formatter.write_str(" else ")?;
                otherwise.write(formatter)
            }
            Node::Call {
                function,
                arguments,
                ..
            } => {
                formatter.write_str(function)?;
                formatter.write_str("(")?;
                for (index, argument) in arguments.iter().enumerate() {
                    if index > 0 {
                        formatter.write_str(", ")?;
                    }
                    argument.write(formatter)?;
                }
                formatter.write_str(")")
            }
            Node::Derivative { order, operand } => {
                operand.write_at(formatter, Binding::Atom)?;
                for _ in 0..*order {
                    formatter.write_str("'")?;
                }
                Ok(())
            }
        }
    }

    /// Writes it, in parentheses where it binds less tightly than its place asks.
    fn write_at(&self, formatter: &mut fmt::Formatter<'_>, at_least: Binding) -> fmt::Result {
        if self.binding() >= at_least {
            return self.write(formatter);
        }
        formatter.write_str("(")?;
        self.write(formatter)?;
        formatter.write_str(")")
    }
}

/// How tightly an expression binds, loosest first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Binding {
    Choice,
    Or,
    And,
    Not,
    Comparison,
    Sum,
    /// What ends in a unit, which would swallow units that a product puts after it.
    Unit,
    Product,
    Sign,
    Power,
    Prime,
    Atom,
}

/// A number that reads back as the same, with an exponent where there would be many zeros.
fn write_number(formatter: &mut fmt::Formatter<'_>, value: f64) -> fmt::Result {
    let magnitude = value.abs();
    if magnitude == 0.0 || (1e-4..1e9).contains(&magnitude) {
        write!(formatter, "{value}")
    } else {
        write!(formatter, "{value:e}")
    }
}

impl fmt::Display for Expression {
    /// Text that reads back as the same tree (a negative number as the negation of a positive one).
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(formatter)
    }
}
