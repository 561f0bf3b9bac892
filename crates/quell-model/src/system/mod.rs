//! A host with devices as one system of first-order equations, compiled.
//!
//! [`System::new`] takes an [`EquationHost`](crate::EquationHost) and [`Device`]s on its ports, decides from their structure
//! alone which internal motions are states, eliminates all other unknowns and compiles the rates of the states with
//! their exact derivatives. [`System::prepare`] puts in values of the parameters.

mod assembly;
mod batch;
mod compiled;
mod dense;
mod device;
mod elimination;
mod equilibrium;
mod error;
mod inputs;
mod layers;
mod motion;
mod newton;
mod pinned;
mod prepared;
mod slopes;
mod structure;
mod vocabulary;
mod watched;

pub use assembly::{State, StateKind};
pub use batch::Batch;
pub use compiled::System;
pub use device::{Device, ForceLaw, LawParameter};
pub use equilibrium::{Equilibrium, EquilibriumStatus};
pub use error::SystemError;
pub use inputs::{Owner, Parameter};
pub use prepared::{Linearised, Prepared};
pub use slopes::Slopes;
pub use vocabulary::Vocabulary;
pub use watched::{Phase, Quantity, Watched};
