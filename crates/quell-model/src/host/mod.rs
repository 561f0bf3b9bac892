//! Host files: what an engineer writes about a linear structure, and the [`LinearHost`](crate::linear::LinearHost) it becomes.
//!
//! Two stages: [`HostFile`] is the text with the place of everything, checked for its keys; [`HostFile::assemble`] works
//! out parameters (with those a study replaces), stamps elements and matrices, and gives a [`Host`] in SI.

pub(crate) mod coordinates;
mod damping;
mod elements;
pub(crate) mod file;
pub mod keys;
mod linear;
mod matrices;
pub(crate) mod names;
pub(crate) mod order;
mod outputs;
pub(crate) mod parameters;
mod points;
mod ports;
mod system;

pub use elements::NamedElement;
pub use file::{Host, HostFile};
pub use parameters::Override;
