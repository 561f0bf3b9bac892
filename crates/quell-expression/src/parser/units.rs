//! The parser's part that reads units.

use super::{Parser, continues_name, starts_name};
use crate::evaluate::power;
use crate::unit::{look_up, unknown};
use crate::{Dimension, ExpressionError, Function, Span, Unit};

pub(crate) fn parse_unit(text: &str) -> Result<Unit, ExpressionError> {
    let mut parser = Parser::new(text);
    let (factor, dimension) = parser.unit_product(Extent::Whole)?;
    parser.end("`*`, `/` or the end of the unit")?;
    Ok(Unit {
        factor,
        dimension,
        text: text.trim().to_owned(),
    })
}

/// How far a unit goes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Extent {
    /// Over everything up to the end or a closing parenthesis.
    Whole,
    /// Until something follows that is no unit.
    Greedy,
}

impl Parser<'_> {
    /// The unit after a number, if one follows: a word there can be nothing else.
    pub(super) fn unit_after_number(
        &mut self,
        number: &str,
    ) -> Result<Option<Unit>, ExpressionError> {
        let before = self.position;
        let follows = match self.peek() {
            Some('%') => true,
            Some('1') => self.reciprocal_follows(),
            Some(first) if starts_name(first) && self.reserved().is_none() => {
                self.refuse_product(number)?;
                true
            }
            _ => false,
        };
        if !follows {
            self.position = before;
            return Ok(None);
        }
        self.skip_space();
        let start = self.position;
        let (factor, dimension) = self.unit_product(Extent::Greedy)?;
        let text = self.text.get(start..self.position).unwrap_or("").to_owned();
        Ok(Some(Unit {
            factor,
            dimension,
            text,
        }))
    }

    /// Whether `1/` and a unit follow.
    fn reciprocal_follows(&mut self) -> bool {
        let before = self.position;
        let follows = self.take("1") && self.take("/") && self.next_unit().is_some();
        self.position = before;
        follows
    }

    /// The error for a word after a number that is no unit: a product without its `*`, or a mistyped unit.
    fn refuse_product(&mut self, number: &str) -> Result<(), ExpressionError> {
        let (span, _) = self.found();
        let word = self.text.get(span.start..span.end).unwrap_or("");
        if look_up(word).is_some() {
            return Ok(());
        }
        let mut error = unknown(word, span);
        let product = format!("a product is written `{number}*{word}`");
        error.help = Some(match error.help {
            Some(near) if near.starts_with("did") && Function::from_name(word).is_none() => {
                format!("{near} Or, {product}")
            }
            _ => product,
        });
        Err(error)
    }

    /// Unit factors joined by `*` and `/`.
    fn unit_product(&mut self, extent: Extent) -> Result<(f64, Dimension), ExpressionError> {
        self.skip_space();
        let start = self.position;
        let (mut factor, mut dimension) = if self.take("1") {
            if !matches!(self.peek(), None | Some('/' | '*' | '·' | ')')) {
                return Err(self.expected("`/` and a unit after `1`"));
            }
            (1.0, Dimension::NONE)
        } else {
            self.unit_power()?
        };
        loop {
            let before = self.position;
            let divide = match self.peek() {
                Some('*' | '·') => Some(false),
                Some('/') => Some(true),
                _ => None,
            };
            self.position += self.rest().chars().next().map_or(0, char::len_utf8);
            let next = match (divide, extent) {
                (None, _) => None,
                (Some(_), Extent::Whole) => Some(self.unit_power()?),
                (Some(_), Extent::Greedy) => self.next_unit(),
            };
            let (Some(divide), Some((next, next_dimension))) = (divide, next) else {
                self.position = before;
                break;
            };
            if divide {
                factor /= next;
                dimension = dimension / next_dimension;
            } else {
                factor *= next;
                dimension = dimension * next_dimension;
            }
        }
        if factor.is_normal() {
            Ok((factor, dimension))
        } else {
            let span = Span::new(start, self.position);
            Err(ExpressionError::new(
                span,
                "this unit is too large or too small for a number",
            ))
        }
    }

    /// The unit that comes next, if what comes is a known one (in parentheses: units only) and not the beginning of a
    /// call, a dotted name or a time derivative; else nothing is read.
    fn next_unit(&mut self) -> Option<(f64, Dimension)> {
        self.skip_space();
        let before = (self.position, self.depth);
        let read = self.unit_power().ok();
        // `m(x)`, `s.x`, `s\'` and `s^2^n` are no units.
        let next = self.rest().chars().next();
        let ends = !matches!(next, Some('.' | '\''))
            && !matches!(self.peek(), Some('(' | '^'))
            && !next.is_some_and(continues_name);
        if read.is_some() && ends {
            // Blanks after it are not part of it.
            let taken = self.text.get(..self.position).unwrap_or("");
            self.position = taken.trim_end().len();
            return read;
        }
        (self.position, self.depth) = before;
        None
    }

    fn unit_power(&mut self) -> Result<(f64, Dimension), ExpressionError> {
        let (factor, dimension) = self.unit_atom()?;
        let after_atom = self.position;
        if !self.take("^") {
            self.position = after_atom;
            return Ok((factor, dimension));
        }
        self.skip_space();
        let start = self.position;
        let parenthesis = self.take("(");
        let sign = if self.take("-") { -1.0 } else { 1.0 };
        self.skip_space();
        let length = self
            .rest()
            .chars()
            .take_while(|c| c.is_ascii_digit() || *c == '.')
            .count();
        let digits = self
            .text
            .get(self.position..self.position + length)
            .unwrap_or("");
        self.position += length;
        let closed = !parenthesis || self.take(")");
        let after = self.position;
        let again = self.peek() == Some('^');
        self.position = after;
        let exponent = match digits.parse::<f64>() {
            Ok(number) if closed && !again => sign * number,
            _ => {
                let span = if self.position == start {
                    self.found().0
                } else {
                    Span::new(start, self.position)
                };
                return Err(ExpressionError::new(
                    span,
                    "the power of a unit is a number, such as `m^2`",
                )
                .with_help("to raise a quantity, put it in parentheses: `(5 m)^n`"));
            }
        };
        match dimension.power(exponent) {
            Some(dimension) => Ok((power(factor, exponent), dimension)),
            None => Err(ExpressionError::new(
                Span::new(start, self.position),
                format!("a unit cannot be raised to the power {exponent}"),
            )),
        }
    }

    fn unit_atom(&mut self) -> Result<(f64, Dimension), ExpressionError> {
        if self.take("(") {
            let inner = self.deeper(|parser| parser.unit_product(Extent::Whole))?;
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
}
