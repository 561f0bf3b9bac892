//! Parameters of a system as functions of the free ones: the host's own, and values of devices.

use std::borrow::Borrow;

use super::Assignment;
use crate::built::{Built, Moved, Places, ValueScratch};
use crate::transient::{Source, parameters};

/// Where a parameter enters the system.
#[derive(Debug, Clone, Default)]
pub(crate) struct Entry {
    /// Index among the parameters of the system, for one of the host.
    pub(crate) host: Option<usize>,
    /// Values of devices.
    pub(crate) places: Places,
}

/// A candidate whose free parameters move while all other values stay.
#[derive(Debug)]
pub(crate) struct Moving<B> {
    built: B,
    values: ValueScratch,
    sources: Vec<Source>,
    entries: Vec<Entry>,
    slopes: Vec<usize>,
}

impl<B: Borrow<Built>> Moving<B> {
    /// `values` are those of all that stands, as [`Built::values`] spreads them.
    pub(crate) fn new(
        built: B,
        values: ValueScratch,
        sources: Vec<Source>,
        entries: Vec<Entry>,
    ) -> Self {
        let mut slopes = Vec::new();
        for entry in &entries {
            let elements = built.borrow().changed_elements(&entry.places);
            let laws = entry.places.laws();
            for (parameter, source) in sources.iter().enumerate() {
                let moves = match source {
                    Source::Host(_) => entry.host == Some(parameter),
                    Source::Element(place) => elements.contains(place),
                    Source::Law(place) => laws.contains(place),
                };
                if moves && !slopes.contains(&parameter) {
                    slopes.push(parameter);
                }
            }
        }
        Self {
            built,
            values,
            sources,
            entries,
            slopes,
        }
    }

    /// The parameters of the system that move, in the order of the slopes.
    pub(crate) fn slopes(&self) -> &[usize] {
        &self.slopes
    }

    fn moved(&self, free: &[f64]) -> Moved {
        let places = self.entries.iter().map(|entry| &entry.places);
        let moves: Vec<(&Places, f64)> = places.zip(free.iter().copied()).collect();
        self.built.borrow().moved(&self.values, &moves)
    }
}

impl<B: Borrow<Built> + Sync> Assignment for Moving<B> {
    fn free(&self) -> usize {
        self.entries.len()
    }

    fn values(&self, free: &[f64]) -> Vec<f64> {
        let moved = self.moved(free);
        let mut values = parameters(&self.sources, &moved.mechanical, &moved.laws);
        for (entry, value) in self.entries.iter().zip(free) {
            if let Some(target) = entry.host.and_then(|index| values.get_mut(index)) {
                *target = *value;
            }
        }
        values
    }

    fn weights(&self, free: &[f64]) -> Vec<Vec<(usize, f64)>> {
        let moved = self.moved(free);
        self.entries
            .iter()
            .zip(&moved.elements)
            .map(|(entry, elements)| {
                let laws = entry.places.laws();
                let weight = |parameter: usize| match self.sources.get(parameter) {
                    Some(Source::Host(_)) => f64::from(u8::from(entry.host == Some(parameter))),
                    Some(Source::Element(element)) => elements
                        .iter()
                        .filter(|(known, _)| known == element)
                        .map(|(_, derivative)| derivative)
                        .sum(),
                    Some(Source::Law(law)) => f64::from(u8::from(laws.contains(law))),
                    None => 0.0,
                };
                let slopes = self.slopes.iter().enumerate();
                slopes
                    .map(|(place, parameter)| (place, weight(*parameter)))
                    .filter(|(_, weight)| *weight != 0.0)
                    .collect()
            })
            .collect()
    }
}
