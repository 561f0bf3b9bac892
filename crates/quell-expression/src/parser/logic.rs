//! The parser's part that reads choices and conditions.

use super::{Parser, RESERVED, continues_name};
use crate::ExpressionError;
use crate::expression::{Expression, LogicalOperator, Node};
use crate::span::Span;

impl Parser<'_> {
    /// Anything: a choice, a condition or a value.
    pub(super) fn expression(&mut self) -> Result<Expression, ExpressionError> {
        self.skip_space();
        let start = self.position;
        if !self.word("if") {
            return self.disjunction();
        }
        let condition = Box::new(self.deeper(Self::disjunction)?);
        self.expect_word("then", "`then` or an operator")?;
        let then = Box::new(self.deeper(Self::expression)?);
        self.expect_word("else", "`else` or an operator")?;
        let otherwise = Box::new(self.deeper(Self::expression)?);
        let span = Span::new(start, otherwise.span.end);
        let node = Node::Choice {
            condition,
            then,
            otherwise,
        };
        Ok(Expression { node, span })
    }

    fn disjunction(&mut self) -> Result<Expression, ExpressionError> {
        let mut left = self.conjunction()?;
        while self.word("or") {
            self.counted()?;
            let right = self.conjunction()?;
            left = logic(LogicalOperator::Or, left, right);
        }
        Ok(left)
    }

    fn conjunction(&mut self) -> Result<Expression, ExpressionError> {
        let mut left = self.negation()?;
        while self.word("and") {
            self.counted()?;
            let right = self.negation()?;
            left = logic(LogicalOperator::And, left, right);
        }
        Ok(left)
    }

    fn negation(&mut self) -> Result<Expression, ExpressionError> {
        self.skip_space();
        let start = self.position;
        if !self.word("not") {
            return self.comparison();
        }
        let operand = self.deeper(Self::negation)?;
        let span = Span::new(start, operand.span.end);
        let node = Node::Not(Box::new(operand));
        Ok(Expression { node, span })
    }

    /// The word of the language that follows.
    pub(super) fn reserved(&mut self) -> Option<&'static str> {
        self.skip_space();
        let rest = self.rest();
        RESERVED.into_iter().find(|word| {
            rest.strip_prefix(word)
                .is_some_and(|after| !after.starts_with(continues_name))
        })
    }

    /// Reads a word of the language if it follows.
    fn word(&mut self, word: &str) -> bool {
        let follows = self.reserved() == Some(word);
        if follows {
            self.position += word.len();
        }
        follows
    }

    fn expect_word(&mut self, word: &str, what: &str) -> Result<(), ExpressionError> {
        if self.word(word) {
            return Ok(());
        }
        let error = self.expected(what);
        Err(match error.help {
            Some(_) => error,
            None => error.with_help("a choice is written `if … then … else …`"),
        })
    }
}

fn logic(operator: LogicalOperator, left: Expression, right: Expression) -> Expression {
    let span = left.span.to(right.span);
    let node = Node::Logic {
        operator,
        left: Box::new(left),
        right: Box::new(right),
    };
    Expression { node, span }
}
