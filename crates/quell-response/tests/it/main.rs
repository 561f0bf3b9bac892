//! The crate against closed forms, published optima, invariants and independent computations.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail the test")]

mod certificates;
mod classics;
mod errors;
mod harness;
mod modes;
mod responses;
mod systems;
