//! What an assembled system does: modes, frequency response and norms of a linear host with devices.
//!
//! An [`Assembly`] joins a host and devices by stamping; element values come with every call as one slice, so that a search
//! reuses all structure. [`Plan`] evaluates peaks of a transfer function quickly; [`certify`] bounds them independently;
//! [`Assembly::modes`] and [`Assembly::realise`] use the minimal first-order form; [`h2`] gives variances.

mod assembly;
mod certificate;
mod dense;
mod eigen;
mod error;
mod frequency;
mod modes;
mod norm;
mod peak;
mod quadrature;
mod realisation;
mod receptance;
mod residues;
mod structure;

pub use assembly::{Assembly, Attached};
pub use certificate::{Certificate, CertificateMethod, CertificateStatus, certify};
pub use error::ResponseError;
pub use frequency::{Peak, Piece, Plan, PlanSettings, Scratch};
pub use modes::{Mode, ModeKind, Modes};
pub use norm::{Norm, NormMethod, Spectrum, h2, h2_fast};
pub use realisation::Realisation;
