//! The host as it stands at given parameters, for whoever draws or describes it.

use std::sync::Arc;

use quell_document::Fault;
use quell_expression::{Dimension, Quantity, Unit};
use quell_model::LinearHost;

use crate::outcome::NamedValue;
use crate::situation;
use crate::study::Study;

/// The host at one set of parameters.
#[derive(Debug, Clone)]
pub struct Standing {
    /// The structure.
    pub host: Arc<LinearHost>,
    /// Its parameters in the order of the file, SI.
    pub parameters: Vec<(String, Quantity)>,
}

impl Study {
    /// The host with the study's own parameters, and with those of a point of a sweep in their place.
    ///
    /// # Errors
    /// Whatever is wrong with the host at these parameters.
    pub fn standing(&self, at: &[NamedValue]) -> Result<Standing, Fault> {
        let known = self.host.parameters(&[])?;
        let at: Vec<(String, Quantity)> = at
            .iter()
            // Bounds of constraints are swept too, and are none of the host's.
            .filter(|value| known.iter().any(|(name, _)| *name == value.name))
            .map(|value| {
                let dimension =
                    Unit::parse(&value.unit).map_or(Dimension::NONE, |unit| unit.dimension);
                (value.name.clone(), Quantity::new(value.value, dimension))
            })
            .collect();
        let situation = situation::build(&self.host, &self.overrides, &at)?;
        Ok(Standing {
            host: situation.host,
            parameters: situation.parameters,
        })
    }
}
