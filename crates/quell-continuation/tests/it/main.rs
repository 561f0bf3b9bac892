#![allow(
    clippy::needless_range_loop,
    clippy::wildcard_imports,
    clippy::semicolon_if_nothing_returned,
    unreachable_pub,
    missing_docs,
    clippy::suspicious_arithmetic_impl,
    clippy::missing_panics_doc,
    clippy::too_many_arguments,
    clippy::unwrap_used,
    clippy::panic,
    clippy::unreadable_literal,
    clippy::used_underscore_binding
)] // test code
//! Reference figures, closed forms and behaviour at the edges.

#[path = "../support/mod.rs"]
mod support;

mod bands;
mod codimension;
mod corrections;
mod crossings;
mod curves;
mod cycles;
mod diagrams;
mod equilibria;
mod growth;
mod kept;
mod meshes;
mod normal_forms;
mod region;
mod rotations;

/// Relative agreement.
pub fn close(found: f64, expected: f64, tolerance: f64) {
    assert!(
        (found - expected).abs() <= tolerance * expected.abs().max(1e-3),
        "found {found:.12}, expected {expected:.12}, relative gap {:.1e}",
        (found - expected).abs() / expected.abs().max(1e-300)
    );
}
