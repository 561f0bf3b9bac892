//! Reference problems with known optima, shared by tests and benchmarks.
#![allow(
    dead_code,
    missing_docs,
    unreachable_pub,
    clippy::unwrap_used,
    clippy::needless_range_loop,
    clippy::semicolon_if_nothing_returned,
    clippy::needless_for_each,
    reason = "each test binary uses a part of the catalogue"
)]

pub mod classical;
pub mod dual;
pub mod passageway;
pub mod peaks;

use quell_search::{Scale, Variable};

pub fn linear(bounds: &[(f64, f64)]) -> Vec<Variable> {
    bounds
        .iter()
        .enumerate()
        .map(|(index, &(lower, upper))| {
            Variable::new(format!("x{}", index + 1), lower, upper, Scale::Linear).unwrap()
        })
        .collect()
}
