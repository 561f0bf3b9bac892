//! Hosts written as equations: nonlinear structures, first-order states, energies.
//!
//! [`HostFile::equations`](crate::HostFile::equations) lowers a file into an [`EquationHost`]: one graph of operations
//! that holds residuals, rates, across-variables and outputs over [`Symbol`]s. [`EquationHost::from_linear`] does the same
//! for a linear host, so that both kinds go through one door.
//!
//! ```
//! use std::sync::Arc;
//! use quell_document::Source;
//! use quell_model::{HostFile, Symbol};
//!
//! let text = r#"
//! quell = 1
//! [parameters]
//! m = "2 kg"
//! k = "8 N/m"
//! l = "0.5 m"
//! [coordinates]
//! x = { start = "0.1 m" }
//! [definitions]
//! stretch = "sqrt(l^2 + x^2) - l"
//! [lagrangian]
//! kinetic = "1/2*m*x'^2"
//! potential = "1/2*k*stretch^2"
//! "#;
//! let host = HostFile::parse(Arc::new(Source::new("guitar.toml", text)), ".")?.equations(&[])?;
//! let values = host.graph.values(&host.residuals, &host.start());
//! // At rest the residual is the restoring force k s x/√(l² + x²).
//! let length = 0.26_f64.sqrt();
//! assert!((values[0] - 8.0 * (length - 0.5) * 0.1 / length).abs() < 1e-15);
//! # Ok::<(), quell_document::Fault>(())
//! ```

mod amounts;
mod driven;
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
pub use driven::{Driven, HarmonicLaw};
pub use host::{
    EquationCoordinate, EquationElement, EquationHost, EquationInput, EquationInputKind,
    EquationOutput, EquationPort, FirstOrderState, HostParameter, Measure, OperatingRange, Symbol,
};
pub use names::{ExtraNames, HostNames, NoExtraNames};
pub use random::Random;
pub use samples::Samples;
pub use waveform::{Harmonic, Pulse, PulseShape, Sweep, Waveform};
