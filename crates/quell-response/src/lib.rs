//! What an assembled system does: modes, frequency response and norms of a linear host with devices.
//!
//! An [`Assembly`] joins a host and devices by stamping; element values come with every call as one slice, so that a search
//! reuses all structure. [`Plan`] evaluates peaks of a transfer function quickly; [`certify`] bounds them independently;
//! [`Assembly::modes`] and [`Assembly::realise`] use the minimal first-order form; [`h2`] gives variances. An
//! [`OperatingPoint`] is the same for systems of equations: linearised about their static equilibrium as a [`FirstOrder`].
//!
//! ```
//! use std::sync::Arc;
//! use faer::mat;
//! use quell_expression::Dimension;
//! use quell_model::linear::*;
//! use quell_network::{Domain, Kinds, Layout, Network};
//! use quell_response::{Assembly, Attached, Plan, PlanSettings, Scratch};
//!
//! // m x'' + k x = F with m = k = 1 and an absorber of mass ratio 0.05 on it.
//! let translation = CoordinateKind::Translation;
//! let host = LinearHost {
//!     name: "primary".into(),
//!     coordinates: vec![Coordinate { name: "x".into(), kind: translation }],
//!     mass: mat![[1.0]],
//!     damping: mat![[0.0]],
//!     stiffness: mat![[1.0]],
//!     loss: None,
//!     inputs: vec![Input {
//!         name: "F".into(),
//!         kind: InputKind::Force,
//!         motion: translation,
//!         dimension: Dimension::FORCE,
//!     }],
//!     forcing: [mat![[1.0]], mat![[0.0]], mat![[0.0]]],
//!     ports: vec![Port {
//!         name: "absorber".into(),
//!         coordinates: vec![1.0],
//!         inputs: vec![0.0],
//!         kind: translation,
//!         hangs: true,
//!         grounded: true,
//!     }],
//!     outputs: vec![],
//! };
//! let layout = Layout::parse("(k | c) + m", &Kinds::new(Domain::Translational))?;
//! let network = Arc::new(Network::from_layout(&layout, None)?);
//! let system = Arc::new(Assembly::new(Arc::new(host), vec![Attached { port: 0, network }])?);
//! let x = LinearForm { terms: vec![(Signal::Coordinate { index: 0, order: 0 }, 1.0)] };
//! let plan = Plan::new(&system, 0, &x, (0.0, 3.0), PlanSettings::default())?;
//!
//! // The H∞ optimum of Nishihara and Asami (2002): f = 0.952372, ζ = 0.133938, peak 6.40792.
//! let (mass, f, zeta) = (0.05, 0.952_372, 0.133_938);
//! let values = [mass * f * f, 2.0 * zeta * mass * f, mass];
//! let peak = plan.peak(&values, &mut Scratch::new());
//! assert!((peak.value - 6.40792).abs() < 2e-5);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![expect(
    clippy::needless_range_loop,
    reason = "matrix algorithms read as in the books, by row and column"
)]

mod assembly;
mod certificate;
mod dense;
mod eigen;
mod error;
mod first_order;
mod frequency;
mod modes;
mod norm;
mod operating;
mod peak;
mod quadrature;
mod realisation;
mod receptance;
mod residues;
mod structure;
mod system;
pub mod transient;

pub use assembly::{Assembly, Attached};
pub use certificate::{Certificate, CertificateMethod, CertificateStatus, certify};
pub use error::ResponseError;
pub use first_order::FirstOrder;
pub use frequency::{Peak, Piece, Plan, PlanSettings, Scratch};
pub use modes::{Mode, ModeKind, Modes};
pub use norm::{Norm, NormMethod, Spectrum, h2, h2_fast};
pub use operating::{OperatingError, OperatingPoint};
pub use realisation::Realisation;
