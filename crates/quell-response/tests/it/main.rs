//! The crate against closed forms, published optima, invariants and independent computations.

mod certificates;
mod classics;
mod errors;
mod harness;
mod modes;
mod responses;
