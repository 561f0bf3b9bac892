//! What the assembled system does: modes, frequency response, norms.
mod assembly;
mod dense;
mod error;
mod realisation;
mod structure;

pub use assembly::{Assembly, Attached};
pub use error::ResponseError;
pub use realisation::Realisation;
