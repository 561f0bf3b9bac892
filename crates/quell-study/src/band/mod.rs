//! Stable bands: the criterion `kind = "stable band"`.
//!
//! The numerical part is [`quell_continuation::stable_bands`]; here are what a study says of it, host and devices as a matrix of two
//! parameters, and what is told about a band.

mod ask;
mod checks;
mod plan;
mod record;
mod rest;

pub use ask::{BandSpec, BandValue, Over};
pub(crate) use plan::{BandPlan, FoundBands};
pub use record::BandResult;
