//! Expressions and quantities as their users meet them.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a failed test ends by panic"
)]

mod chain;
mod derivative;
mod grammar;
mod lowering;
mod message;
mod program;
mod random;
mod recording;
mod round_trip;
mod unit;

use quell_expression::{Expression, NoNames, Quantity};

/// The SI value of an expression without names.
fn value(text: &str) -> f64 {
    quantity(text).value
}

fn quantity(text: &str) -> Quantity {
    Expression::parse(text)
        .and_then(|expression| expression.evaluate(&NoNames))
        .unwrap_or_else(|error| panic!("{text}: {error} at {:?}", error.span))
}
