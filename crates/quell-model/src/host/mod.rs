//! Host files: what an engineer writes about a linear structure, and the [`LinearHost`](crate::linear::LinearHost) it becomes.
//!
//! Two stages: [`HostFile`] is the text with the place of everything, checked for its keys; [`HostFile::assemble`] works
//! out parameters (with those a study replaces), stamps elements and matrices, and gives a [`Host`] in SI.

mod coordinates;
mod damping;
mod elements;
mod file;
pub mod keys;
mod linear;
mod matrices;
mod names;
mod order;
mod outputs;
mod parameters;
mod points;
mod ports;
mod system;

pub use elements::NamedElement;
pub use file::{Host, HostFile};
pub use parameters::Override;
