//! The parser of expressions and units: recursive descent over characters, with a bound on depth.

use crate::expression::{BinaryOperator, ComparisonOperator, Expression, Node};
use crate::unit::{look_up, unknown};
use crate::{Dimension, ExpressionError, Span, Unit};

/// Parentheses, calls and signs may be nested so deeply; no text can overflow the stack.
const DEPTH: usize = 100;

/// Longest chain of operations at one level, for the same reason: its tree is walked recursively.
const CHAIN: usize = 2000;

pub(crate) fn parse(text: &str) -> Result<Expression, ExpressionError> {
    let mut parser = Parser::new(text);
    let expression = parser.comparison()?;
    parser.end("an operator or the end")?;
    Ok(expression)
}

pub(crate) fn parse_unit(text: &str) -> Result<Unit, ExpressionError> {
    let mut parser = Parser::new(text);
    let (factor, dimension) = parser.unit_product(true)?;
    parser.end("`*`, `/` or the end of the unit")?;
    Ok(Unit {
        factor,
        dimension,
        text: text.trim().to_owned(),
    })
}

struct Parser<'a> {
    text: &'a str,
    position: usize,
    depth: usize,
    operations: usize,
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
            Some(first) => (
                Span::new(start, start + first.len_utf8()),
                format!("`{first}`"),
            ),
        }
    }

    fn expected(&mut self, what: &str) -> ExpressionError {
        let (span, found) = self.found();
        ExpressionError::new(span, format!("expected {what}, found {found}"))
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
        if self.peek() == Some('=') {
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
                let inner = self.deeper(Self::comparison)?;
                if !self.take(")") {
                    let mut error = self.expected("an operator or `)`");
                    error.help = Some(format!(
                        "the parenthesis opened at character {} is not closed",
                        start + 1
                    ));
                    return Err(error);
                }
                Ok(Expression {
                    node: inner.node,
                    span: Span::new(start, self.position),
                })
            }
            Some(first) if first.is_ascii_digit() || first == '.' => self.number(),
            Some(first) if starts_name(first) => self.name(),
            _ => Err(self.expected("a number, a name or `(`")),
        }
    }

    fn number(&mut self) -> Result<Expression, ExpressionError> {
        let start = self.position;
        let bytes = self.text.as_bytes();
        let digits = |mut at: usize| {
            while bytes
                .get(at)
                .is_some_and(|byte| byte.is_ascii_digit() || *byte == b'_')
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
        let written = self.text.get(start..end).unwrap_or("").replace('_', "");
        let span = Span::new(start, end);
        let value: f64 = written
            .parse()
            .map_err(|_| ExpressionError::new(span, format!("`{written}` is not a number")))?;
        if !value.is_finite() {
            return Err(ExpressionError::new(
                span,
                format!("`{written}` is too large for a number"),
            ));
        }
        self.position = end;
        if self.unit_follows() {
            self.skip_space();
            let unit_start = self.position;
            let (factor, dimension) = self.unit_product(false)?;
            let text = self
                .text
                .get(unit_start..self.position)
                .unwrap_or("")
                .to_owned();
            let unit = Unit {
                factor,
                dimension,
                text,
            };
            return Ok(Expression {
                node: Node::Quantity { value, unit },
                span: Span::new(start, self.position),
            });
        }
        Ok(Expression {
            node: Node::Number(value),
            span,
        })
    }

    /// Whether a word follows at once: after a number it can only be a unit.
    fn unit_follows(&mut self) -> bool {
        match self.peek() {
            Some('%') => true,
            Some(first) => starts_name(first),
            None => false,
        }
    }

    /// Unit factors joined by `*` and `/`. In an expression (`whole` false) it ends where no known unit word follows.
    fn unit_product(&mut self, whole: bool) -> Result<(f64, Dimension), ExpressionError> {
        let (mut factor, mut dimension) = if whole && self.take("1") && self.peek() == Some('/') {
            (1.0, Dimension::NONE)
        } else {
            self.unit_power()?
        };
        loop {
            let before = self.position;
            let divide = match self.peek() {
                Some('*' | '·') => false,
                Some('/') => true,
                _ => break,
            };
            self.position += self.rest().chars().next().map_or(0, char::len_utf8);
            if !whole && !self.unit_continues() {
                self.position = before;
                break;
            }
            let (next, next_dimension) = self.unit_power()?;
            if divide {
                factor /= next;
                dimension = dimension / next_dimension;
            } else {
                factor *= next;
                dimension = dimension * next_dimension;
            }
        }
        // Blanks after the unit are not part of it.
        let taken = self.text.get(..self.position).unwrap_or("");
        self.position = taken.trim_end().len();
        Ok((factor, dimension))
    }

    /// Whether a known unit, not followed by a call's parenthesis, comes next; parentheses must hold units only.
    fn unit_continues(&mut self) -> bool {
        let before = (self.position, self.depth);
        let continues = match self.peek() {
            Some('(') => self.unit_power().is_ok(),
            Some(first) if starts_name(first) => {
                let (span, _) = self.found();
                let name = self.text.get(span.start..span.end).unwrap_or("");
                let known = look_up(name).is_some();
                self.position = span.end;
                known
                    && self.peek() != Some('(')
                    && !matches!(self.rest().chars().next(), Some('.' | '\''))
            }
            _ => false,
        };
        (self.position, self.depth) = before;
        continues
    }

    fn unit_power(&mut self) -> Result<(f64, Dimension), ExpressionError> {
        let (factor, dimension) = self.unit_atom()?;
        let before = self.position;
        if !self.take("^") {
            return Ok((factor, dimension));
        }
        self.skip_space();
        let start = self.position;
        let parenthesis = self.take("(");
        let sign = if self.take("-") { -1.0 } else { 1.0 };
        self.skip_space();
        let digits: String = self
            .rest()
            .chars()
            .take_while(|c| c.is_ascii_digit() || *c == '.')
            .collect();
        self.position += digits.len();
        let closed = !parenthesis || self.take(")");
        let span = Span::new(start, self.position);
        let exponent: f64 = match digits.parse::<f64>() {
            Ok(number) if closed => sign * number,
            _ => {
                self.position = before;
                return Err(ExpressionError::new(
                    span,
                    "the power of a unit is a number, such as `m^2`",
                ));
            }
        };
        let power = dimension.power(exponent).ok_or_else(|| {
            ExpressionError::new(
                span,
                format!("a unit cannot be raised to the power {exponent}"),
            )
        })?;
        Ok((factor.powf(exponent), power))
    }

    fn unit_atom(&mut self) -> Result<(f64, Dimension), ExpressionError> {
        if self.take("(") {
            let inner = self.deeper(|parser| parser.unit_product(true))?;
            if !self.take(")") {
                return Err(self.expected("`)` after the unit"));
            }
            return Ok(inner);
        }
        if self.take("%") {
            return Ok((1e-2, Dimension::NONE));
        }
        if !self.peek().is_some_and(starts_name) {
            return Err(self.expected("a unit"));
        }
        let (span, _) = self.found();
        let name = self.text.get(span.start..span.end).unwrap_or("");
        let found = look_up(name).ok_or_else(|| unknown(name, span))?;
        self.position = span.end;
        Ok(found)
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
                arguments.push(self.deeper(Self::comparison)?);
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
