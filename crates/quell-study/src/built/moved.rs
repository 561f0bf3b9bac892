//! Values of a candidate that move, one after another, while all others stay: for branches.

use super::{Built, Origin};
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
            Origin::Given(value) => Some(*value),
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

    /// All values with others in some places.
    pub(crate) fn moved(&self, moves: &[(&Places, f64)]) -> Moved {
        let given = |origin: &Origin| match origin {
            Origin::Given(value) => *value,
            Origin::Searched(_) => f64::NAN,
        };
        let mut all: Vec<f64> = self.origins.iter().map(given).collect();
        let mut out = Moved {
            mechanical: vec![f64::NAN; self.element_count()],
            laws: self.laws.iter().map(|law| given(&law.origin)).collect(),
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
