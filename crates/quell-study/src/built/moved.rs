//! Values of a candidate that move, one after another, while all others stay: for branches.

use super::{Built, Origin, ValueScratch};
use quell_expression::Dimension;
use quell_network::ExpansionWorkspace;

/// Where a value enters: variables of networks, and parameters of nonlinear elements.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Places {
    origins: Vec<usize>,
    laws: Vec<usize>,
}

impl Places {
    /// Whether it enters nowhere.
    pub(crate) const fn is_empty(&self) -> bool {
        self.origins.is_empty() && self.laws.is_empty()
    }

    /// The parameters of nonlinear elements among them.
    pub(crate) fn laws(&self) -> &[usize] {
        &self.laws
    }
}

/// Mechanical values of all elements and parameters of all nonlinear ones, with their derivatives by what moves.
#[derive(Debug, Clone, Default)]
pub(crate) struct Moved {
    /// By element.
    pub mechanical: Vec<f64>,
    /// By parameter of a nonlinear element.
    pub laws: Vec<f64>,
    /// By what moves: (element, derivative).
    pub elements: Vec<Vec<(usize, f64)>>,
}

/// Whether a value of a device goes by a name.
fn is_called(name: &str, device: &str, own: &str) -> bool {
    name == own
        || name
            .strip_prefix(device)
            .and_then(|rest| rest.strip_prefix('.'))
            .is_some_and(|rest| rest == own)
}

impl Built {
    /// The places of everything that is searched.
    pub(crate) fn searched(&self) -> Places {
        let is_searched = |origin: &Origin| matches!(origin, Origin::Searched(_));
        Places {
            origins: (0..self.origins.len())
                .filter(|place| self.origins.get(*place).is_some_and(is_searched))
                .collect(),
            laws: (0..self.laws.len())
                .filter(|place| {
                    self.laws
                        .get(*place)
                        .is_some_and(|law| is_searched(&law.origin))
                })
                .collect(),
        }
    }

    /// The places of a value by its name in the layouts, `c1`, or with that of its device.
    pub(crate) fn places_of(&self, name: &str) -> Places {
        let mut found = Places::default();
        for attachment in &self.attachments {
            for (index, variable) in attachment.expansion.variables().iter().enumerate() {
                if is_called(name, &attachment.name, &variable.name) {
                    found.origins.push(attachment.variables.start + index);
                }
            }
        }
        for (index, law) in self.laws.iter().enumerate() {
            let device = self.attachments.get(law.attachment);
            if device.is_some_and(|device| is_called(name, &device.name, &law.name)) {
                found.laws.push(index);
            }
        }
        found
    }

    /// The dimension of a value by its name.
    pub(crate) fn dimension_of(&self, name: &str) -> Option<Dimension> {
        let variables = self.attachments.iter().flat_map(|attachment| {
            let own = attachment.expansion.variables().iter();
            own.filter(|variable| is_called(name, &attachment.name, &variable.name))
                .map(|variable| variable.dimension)
        });
        let laws = self.laws.iter().filter(|law| {
            let device = self.attachments.get(law.attachment);
            device.is_some_and(|device| is_called(name, &device.name, &law.name))
        });
        variables.chain(laws.map(|law| law.dimension)).next()
    }

    /// Whether any of some places takes its value from a search.
    pub(crate) fn searches(&self, places: &Places) -> bool {
        let origins = places
            .origins
            .iter()
            .filter_map(|place| self.origins.get(*place));
        let laws = places
            .laws
            .iter()
            .filter_map(|place| Some(&self.laws.get(*place)?.origin));
        origins
            .chain(laws)
            .any(|origin| matches!(origin, Origin::Searched(_)))
    }

    /// The values of a point with one design variable changed by so much.
    pub(crate) fn nudged(&self, values: &ValueScratch, variable: usize, by: f64) -> ValueScratch {
        let mut nudged = values.clone();
        let is_it =
            |origin: &Origin| matches!(origin, Origin::Searched(index) if *index == variable);
        for (value, origin) in nudged.all.iter_mut().zip(&self.origins) {
            if is_it(origin) {
                *value += by;
            }
        }
        for (value, law) in nudged.laws.iter_mut().zip(&self.laws) {
            if is_it(&law.origin) {
                *value += by;
            }
        }
        self.place(&Places::default(), f64::NAN, &mut nudged);
        nudged
    }

    /// The value of a design variable at a point.
    pub(crate) fn value_of(&self, values: &ValueScratch, variable: usize) -> Option<f64> {
        let is_it =
            |origin: &Origin| matches!(origin, Origin::Searched(index) if *index == variable);
        let origins = values.all.iter().zip(&self.origins);
        let laws = values
            .laws
            .iter()
            .zip(self.laws.iter().map(|law| &law.origin));
        origins
            .chain(laws)
            .find(|(_, origin)| is_it(origin))
            .map(|(value, _)| *value)
    }

    /// Puts another value into some places, after [`Built::values`].
    pub(crate) fn place(&self, places: &Places, value: f64, scratch: &mut ValueScratch) {
        for place in &places.origins {
            if let Some(entry) = scratch.all.get_mut(*place) {
                *entry = value;
            }
        }
        for place in &places.laws {
            if let Some(entry) = scratch.laws.get_mut(*place) {
                *entry = value;
            }
        }
        self.expand(scratch);
    }

    /// The value that is given at the first of some places.
    pub(crate) fn given(&self, places: &Places) -> Option<f64> {
        let mut origins = places
            .origins
            .iter()
            .filter_map(|place| self.origins.get(*place));
        let mut laws = places
            .laws
            .iter()
            .filter_map(|place| Some(&self.laws.get(*place)?.origin));
        match origins.next().or_else(|| laws.next())? {
            Origin::Given(value) | Origin::Moved(value) => Some(*value),
            Origin::Searched(_) => None,
        }
    }

    /// Which elements a value in some places may change.
    pub(crate) fn changed_elements(&self, places: &Places) -> Vec<usize> {
        let mut found = Vec::new();
        for attachment in &self.attachments {
            for (element, variable) in attachment.expansion.entries() {
                if places
                    .origins
                    .contains(&(attachment.variables.start + variable))
                {
                    found.push(attachment.elements.start + element);
                }
            }
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    /// All values with others in some places, from those that [`Built::values`] has spread.
    pub(crate) fn moved(&self, values: &ValueScratch, moves: &[(&Places, f64)]) -> Moved {
        let mut all = values.all.clone();
        let laws = values.laws.clone();
        let mut out = Moved {
            mechanical: vec![f64::NAN; self.element_count()],
            laws,
            elements: vec![Vec::new(); moves.len()],
        };
        for (places, value) in moves {
            for place in &places.origins {
                if let Some(entry) = all.get_mut(*place) {
                    *entry = *value;
                }
            }
            for place in &places.laws {
                if let Some(entry) = out.laws.get_mut(*place) {
                    *entry = *value;
                }
            }
        }
        let mut workspace = ExpansionWorkspace::default();
        for attachment in &self.attachments {
            let entries = attachment.expansion.entries();
            let mut derivatives = vec![f64::NAN; entries.len()];
            let variables = all.get(attachment.variables.clone()).unwrap_or_default();
            let values = out
                .mechanical
                .get_mut(attachment.elements.clone())
                .unwrap_or_default();
            attachment
                .expansion
                .derivatives(variables, &mut workspace, values, &mut derivatives);
            for ((element, variable), derivative) in entries.iter().zip(derivatives) {
                let place = attachment.variables.start + variable;
                for ((places, _), found) in moves.iter().zip(&mut out.elements) {
                    if places.origins.contains(&place) {
                        found.push((attachment.elements.start + element, derivative));
                    }
                }
            }
        }
        out
    }
}
