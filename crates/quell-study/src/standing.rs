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
    /// How many first-order states it has beside its coordinates.
    pub states: usize,
    /// Its parameters in the order of the file, SI.
    pub parameters: Vec<(String, Quantity)>,
}

impl Standing {
    /// `2 coordinates, 1 first-order state`.
    #[must_use]
    pub fn size(&self) -> String {
        size(self.host.coordinates.len(), self.states)
    }
}

/// The number of coordinates and of first-order states in words; where there are states alone, of those.
pub(crate) fn size(coordinates: usize, states: usize) -> String {
    let plural = |number: usize| if number == 1 { "" } else { "s" };
    let first = format!("{coordinates} coordinate{}", plural(coordinates));
    let second = format!("{states} first-order state{}", plural(states));
    match (coordinates, states) {
        (_, 0) => first,
        (0, _) => second,
        _ => format!("{first}, {second}"),
    }
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
        let states = situation.equations().map_or(0, |host| host.states.len());
        Ok(Standing {
            states,
            host: situation.host,
            parameters: situation.parameters,
        })
    }
}
