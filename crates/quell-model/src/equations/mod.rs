//! Hosts written as equations: nonlinear structures, first-order states, energies.
//!
//! [`HostFile::equations`](crate::HostFile::equations) lowers a file into an [`EquationHost`]: one graph of operations
//! that holds residuals, rates, across-variables and outputs over [`Symbol`]s. [`EquationHost::from_linear`] does the same
//! for a linear host, so that both kinds go through one door.

mod amounts;
mod host;
pub(crate) mod keys;
mod lagrangian;
mod linear;
mod names;
mod place;
mod ports;
mod random;
mod read;
mod residuals;
mod samples;
mod sections;
mod series;
pub(crate) mod signal;
mod waveform;

pub(crate) use amounts::Amounts;
pub use host::{
    EquationCoordinate, EquationElement, EquationHost, EquationInput, EquationInputKind,
    EquationOutput, EquationPort, FirstOrderState, HostParameter, Measure, OperatingRange, Symbol,
};
pub use names::{ExtraNames, HostNames, NoExtraNames};
pub use random::Random;
pub use samples::Samples;
pub use waveform::{Harmonic, Pulse, PulseShape, Sweep, Waveform};
