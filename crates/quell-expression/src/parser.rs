//! The parser of expressions: recursive descent over characters, with a bound on depth.

mod logic;
mod signature;
mod units;

pub use signature::{Argument, Signature};
pub(crate) use units::parse_unit;

use crate::expression::{BinaryOperator, ComparisonOperator, Expression, Node, RESERVED};
use crate::{ExpressionError, Span};

/// Parentheses, calls and signs may be nested so deeply; no text can overflow the stack.
const DEPTH: usize = 100;

/// Longest chain of operations at one level, for the same reason: its tree is walked recursively.
const CHAIN: usize = 2000;

pub(crate) fn parse(text: &str) -> Result<Expression, ExpressionError> {
    let mut parser = Parser::new(text);
    let expression = parser.expression()?;
    parser.end("an operator or the end")?;
    Ok(expression)
}

pub(crate) fn parse_equation(text: &str) -> Result<(Expression, Expression), ExpressionError> {
    let mut parser = Parser::new(text);
    parser.equation = true;
    let left = parser.expression()?;
    if !parser.take("=") {
        let error = parser.expected("an operator or `=`");
        return Err(match error.help {
            Some(_) => error,
            None => error.with_help("an equation has two sides: `left = right`"),
        });
    }
    parser.equation = false;
    let right = parser.expression()?;
    parser.end("an operator or the end")?;
    Ok((left, right))
}

struct Parser<'a> {
    text: &'a str,
    position: usize,
    depth: usize,
    operations: usize,
    /// Whether a bare `=` may follow, which ends the left side of an equation.
    equation: bool,
}

fn starts_name(character: char) -> bool {
    character.is_alphabetic() || character == '_'
}

fn continues_name(character: char) -> bool {
    character.is_alphanumeric() || character == '_'
}

impl<'a> Parser<'a> {
    const fn new(text: &'a str) -> Self {
        Self {
            text,
            position: 0,
            depth: 0,
            operations: 0,
            equation: false,
        }
    }

    fn rest(&self) -> &'a str {
        self.text.get(self.position..).unwrap_or("")
    }

    fn skip_space(&mut self) {
        let rest = self.rest();
        self.position += rest.len() - rest.trim_start().len();
    }

    fn peek(&mut self) -> Option<char> {
        self.skip_space();
        self.rest().chars().next()
    }

    fn take(&mut self, expected: &str) -> bool {
        self.skip_space();
        let found = self.rest().starts_with(expected);
        if found {
            self.position += expected.len();
        }
        found
    }

    /// What stands at the present place, for "found …".
    fn found(&mut self) -> (Span, String) {
        self.skip_space();
        let start = self.position;
        match self.rest().chars().next() {
            None => (Span::new(start, start), "the end".to_owned()),
            Some(first) if starts_name(first) => {
                let name: String = self
                    .rest()
                    .chars()
                    .take_while(|c| continues_name(*c))
                    .collect();
                (Span::new(start, start + name.len()), format!("`{name}`"))
            }
            Some(first) if first.is_ascii_digit() => {
                let number: String = self
                    .rest()
                    .chars()
                    .take_while(|c| c.is_ascii_digit() || *c == '.')
                    .collect();
                (
                    Span::new(start, start + number.len()),
                    format!("`{number}`"),
                )
            }
            Some(first) => (
                Span::new(start, start + first.len_utf8()),
                format!("`{first}`"),
            ),
        }
    }

    fn expected(&mut self, what: &str) -> ExpressionError {
        let (span, found) = self.found();
        let error = ExpressionError::new(span, format!("expected {what}, found {found}"));
        match self.rest().chars().next() {
            Some(',') => error.with_help("decimals are written with a point: `0.5`"),
            Some('−' | '–') => error.with_help("minus is written `-`"),
            Some('×' | '·' | '⋅') => error.with_help("a product is written `*`"),
            Some('(') => {
                error.with_help("a product is written `*`, and a function's name stands before `(`")
            }
            _ if self.reserved() == Some("if") => error
                .with_help("within an operation it stands in parentheses: `(if … then … else …)`"),
            Some('<' | '>') => error.with_help("a comparison has two sides, such as `x <= 5`"),
            _ => error,
        }
    }

    fn end(&mut self, what: &str) -> Result<(), ExpressionError> {
        if self.peek().is_none() {
            Ok(())
        } else {
            Err(self.expected(what))
        }
    }

    fn deeper<T>(
        &mut self,
        inner: impl FnOnce(&mut Self) -> Result<T, ExpressionError>,
    ) -> Result<T, ExpressionError> {
        self.depth += 1;
        if self.depth > DEPTH {
            let (span, _) = self.found();
            return Err(ExpressionError::new(
                span,
                format!("this is nested more than {DEPTH} deep"),
            )
            .with_help("name a part of it as a parameter"));
        }
        let result = inner(self);
        self.depth -= 1;
        result
    }

    fn counted(&mut self) -> Result<(), ExpressionError> {
        self.operations += 1;
        if self.operations > CHAIN {
            let (span, _) = self.found();
            return Err(ExpressionError::new(
                span,
                format!("this expression has more than {CHAIN} operations"),
            )
            .with_help("name a part of it as a parameter"));
        }
        Ok(())
    }

    fn comparison(&mut self) -> Result<Expression, ExpressionError> {
        let left = self.sum()?;
        let operators = [
            ("<=", ComparisonOperator::LessOrEqual),
            (">=", ComparisonOperator::GreaterOrEqual),
            ("==", ComparisonOperator::Equal),
            ("!=", ComparisonOperator::NotEqual),
            ("<", ComparisonOperator::Less),
            (">", ComparisonOperator::Greater),
        ];
        for (symbol, operator) in operators {
            if self.take(symbol) {
                let right = self.sum()?;
                let span = left.span.to(right.span);
                let node = Node::Comparison {
                    operator,
                    left: Box::new(left),
                    right: Box::new(right),
                };
                return Ok(Expression { node, span });
            }
        }
        if self.peek() == Some('=') && !(self.equation && self.depth == 0) {
            return Err(self.expected("`<=`, `>=` or `==`"));
        }
        Ok(left)
    }

    fn sum(&mut self) -> Result<Expression, ExpressionError> {
        let mut left = self.product()?;
        loop {
            let operator = match self.peek() {
                Some('+') => BinaryOperator::Add,
                Some('-') => BinaryOperator::Subtract,
                _ => return Ok(left),
            };
            self.position += 1;
            self.counted()?;
            let right = self.product()?;
            left = binary(operator, left, right);
        }
    }

    fn product(&mut self) -> Result<Expression, ExpressionError> {
        let mut left = self.signed()?;
        loop {
            let operator = match self.peek() {
                Some('*') => BinaryOperator::Multiply,
                Some('/') => BinaryOperator::Divide,
                _ => return Ok(left),
            };
            self.position += 1;
            self.counted()?;
            if self.rest().starts_with('*') {
                self.position -= 1;
                return Err(ExpressionError::new(
                    Span::new(self.position, self.position + 2),
                    "`**` is not an operator",
                )
                .with_help("a power is written `^`"));
            }
            let right = self.signed()?;
            left = binary(operator, left, right);
        }
    }

    fn signed(&mut self) -> Result<Expression, ExpressionError> {
        self.skip_space();
        let start = self.position;
        if self.take("-") {
            let operand = self.deeper(Self::signed)?;
            let span = Span::new(start, operand.span.end);
            return Ok(Expression {
                node: Node::Negate(Box::new(operand)),
                span,
            });
        }
        if self.take("+") {
            return self.deeper(Self::signed);
        }
        self.power()
    }

    fn power(&mut self) -> Result<Expression, ExpressionError> {
        let base = self.postfix()?;
        if !self.take("^") {
            return Ok(base);
        }
        self.counted()?;
        let exponent = self.deeper(Self::signed)?;
        Ok(binary(BinaryOperator::Power, base, exponent))
    }

    fn postfix(&mut self) -> Result<Expression, ExpressionError> {
        let operand = self.atom()?;
        let mut order = 0;
        while self.rest().starts_with('\'') {
            self.position += 1;
            order += 1;
        }
        if order == 0 {
            return Ok(operand);
        }
        let span = Span::new(operand.span.start, self.position);
        if order > 4 {
            return Err(ExpressionError::new(
                span,
                format!("{order} primes are more than any equation of motion has"),
            ));
        }
        Ok(Expression {
            node: Node::Derivative {
                order,
                operand: Box::new(operand),
            },
            span,
        })
    }

    fn atom(&mut self) -> Result<Expression, ExpressionError> {
        match self.peek() {
            Some('(') => {
                let start = self.position;
                self.position += 1;
                let inner = self.deeper(Self::expression)?;
                if !self.take(")") {
                    let error = self.expected("an operator or `)`");
                    let before = self.text.get(..start).unwrap_or("").chars().count();
                    return Err(match error.help {
                        Some(_) => error,
                        None => error.with_help(format!(
                            "the parenthesis opened at character {} is not closed",
                            before + 1
                        )),
                    });
                }
                Ok(Expression {
                    node: inner.node,
                    span: Span::new(start, self.position),
                })
            }
            Some(first) if first.is_ascii_digit() || first == '.' => self.number(),
            Some(first) if starts_name(first) && self.reserved().is_none() => self.name(),
            _ => Err(self.expected("a number, a name or `(`")),
        }
    }

    fn number(&mut self) -> Result<Expression, ExpressionError> {
        let start = self.position;
        let written = self.digits();
        let span = Span::new(start, self.position);
        let value: f64 = written
            .parse()
            .map_err(|_| ExpressionError::new(span, format!("`{written}` is not a number")))?;
        if !value.is_finite() {
            return Err(ExpressionError::new(
                span,
                format!("`{written}` is too large for a number"),
            ));
        }
        let mantissa = written.split(['e', 'E']).next().unwrap_or("");
        if value == 0.0 && mantissa.contains(|digit| ('1'..='9').contains(&digit)) {
            return Err(ExpressionError::new(
                span,
                format!("`{written}` is too small for a number"),
            ));
        }
        let node = match self.unit_after_number(&written)? {
            Some(unit) => Node::Quantity { value, unit },
            None => Node::Number(value),
        };
        Ok(Expression {
            node,
            span: Span::new(start, self.position),
        })
    }

    /// The digits, point and exponent of a number; `_` may stand between digits and is left out.
    fn digits(&mut self) -> String {
        let start = self.position;
        let bytes = self.text.as_bytes();
        let is_digit = |at: usize| bytes.get(at).is_some_and(u8::is_ascii_digit);
        let digits = |mut at: usize| {
            let first = at;
            while is_digit(at)
                || (at > first
                    && bytes.get(at) == Some(&b'_')
                    && is_digit(at - 1)
                    && is_digit(at + 1))
            {
                at += 1;
            }
            at
        };
        let mut end = digits(start);
        if bytes.get(end) == Some(&b'.') {
            end = digits(end + 1);
        }
        if matches!(bytes.get(end), Some(b'e' | b'E')) {
            let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
            let exponent = digits(end + 1 + sign);
            if exponent > end + 1 + sign {
                end = exponent;
            }
        }
        self.position = end;
        self.text.get(start..end).unwrap_or("").replace('_', "")
    }

    fn name(&mut self) -> Result<Expression, ExpressionError> {
        let start = self.position;
        loop {
            let word: usize = self
                .rest()
                .chars()
                .take_while(|c| continues_name(*c))
                .map(char::len_utf8)
                .sum();
            self.position += word;
            let mut after = self.rest().chars();
            let dotted = after.next() == Some('.') && after.next().is_some_and(starts_name);
            if !dotted {
                break;
            }
            self.position += 1;
        }
        let span = Span::new(start, self.position);
        let name = self.text.get(start..self.position).unwrap_or("").to_owned();
        if self.peek() != Some('(') {
            // Blanks looked over are not part of the name.
            self.position = span.end;
            return Ok(Expression {
                node: Node::Name(name),
                span,
            });
        }
        self.position += 1;
        let mut arguments = Vec::new();
        if !self.take(")") {
            loop {
                self.counted()?;
                arguments.push(self.deeper(Self::expression)?);
                if self.take(")") {
                    break;
                }
                if !self.take(",") {
                    return Err(self.expected("an operator, `,` or `)`"));
                }
            }
        }
        let node = Node::Call {
            function: name,
            function_span: span,
            arguments,
        };
        Ok(Expression {
            node,
            span: Span::new(start, self.position),
        })
    }
}

fn binary(operator: BinaryOperator, left: Expression, right: Expression) -> Expression {
    let span = left.span.to(right.span);
    Expression {
        node: Node::Binary {
            operator,
            left: Box::new(left),
            right: Box::new(right),
        },
        span,
    }
}
