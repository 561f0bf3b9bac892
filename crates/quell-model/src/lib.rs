//! Host structures: what the engineer's machine, building or vehicle is before anything is bolted on.
//!
//! A [`HostFile`] is what the engineer wrote; [`HostFile::assemble`] makes of it a [`Host`], whose [`LinearHost`] holds
//! the equations in SI. [`linear_form`] turns expressions such as `x1'' - 2*force(strut)/m` into combinations of signals.
//! [`matrix`] reads matrices from files.
//!
//! ```
//! use std::sync::Arc;
//! use quell_document::Source;
//! use quell_model::HostFile;
//!
//! let text = r#"
//! quell = 1
//! [coordinates]
//! x = { mass = "2 kg" }
//! [inputs]
//! F = { kind = "force", on = "x" }
//! [linear]
//! springs = [["x", "ground", "8 N/m"]]
//! [ports.absorber]
//! at = "x"
//! "#;
//! let host = HostFile::parse(Arc::new(Source::new("oscillator.toml", text)), ".")?.build(&[])?;
//! assert_eq!(host.stiffness[(0, 0)], 8.0);
//! assert!(host.ports[0].hangs);
//! # Ok::<(), quell_document::Fault>(())
//! ```
#![forbid(unsafe_code)]

mod describe;
pub mod equations;
mod form;
pub mod host;
pub mod linear;
pub mod matrix;
pub mod system;

pub use equations::{
    Driven, EquationCoordinate, EquationElement, EquationHost, EquationInput, EquationInputKind,
    EquationOutput, EquationPort, ExtraNames, FirstOrderState, HarmonicLaw, HostNames,
    HostParameter, Measure, NoExtraNames, OperatingRange, Symbol, Waveform,
};
pub use form::{DevicePart, SignalNames, linear_form};
pub use host::{Host, HostFile, NamedElement, Override};
pub use linear::{
    Coordinate, CoordinateKind, Input, InputKind, LinearForm, LinearHost, Output, Port, Signal,
};
