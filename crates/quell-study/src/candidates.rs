//! The candidates of a design task: every combination of the layouts of its slots, one after the other.

use indexmap::IndexMap;
use quell_expression::Span;
use quell_network::{Layout, Layouts};

use crate::study::{CandidateSet, DesignTask, Slot};

/// A layout for each slot that is filled, with the place where it was asked for.
#[derive(Debug, Clone)]
pub(crate) struct Candidate {
    /// By slot.
    pub layouts: Vec<(Slot, Layout, Span)>,
}

impl Candidate {
    /// The layouts in words, separated by semicolons.
    pub(crate) fn label(&self) -> String {
        let layouts: Vec<String> = self
            .layouts
            .iter()
            .map(|(_, layout, _)| layout.to_string())
            .collect();
        layouts.join(" ; ")
    }
}

/// All candidates of a task.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Candidates<'a> {
    design: &'a DesignTask,
}

/// The only slot of a task, if it designs one.
pub(crate) fn single_slot(design: &DesignTask) -> Option<&Slot> {
    let mut slots = design.candidates.keys();
    slots.next().filter(|_| design.candidates.len() == 1)
}

impl<'a> Candidates<'a> {
    /// The candidates of a task.
    pub(crate) const fn of(design: &'a DesignTask) -> Self {
        Self { design }
    }

    /// How many there are, layouts that end wrongly in a mass included.
    pub(crate) fn count(self) -> u128 {
        count(&self.design.candidates)
    }

    /// How many, and up to which equivalence each is listed once.
    pub(crate) fn words(self) -> String {
        let count = self.count();
        let listed = self.design.candidates.values().find_map(|set| match set {
            CandidateSet::Layouts(_) => None,
            CandidateSet::Budget { enumerations, .. } => enumerations.first(),
        });
        let plural = if count == 1 { "" } else { "s" };
        match listed {
            Some(enumeration) => format!(
                "{count} layout{plural}, each once {}",
                enumeration.equivalence()
            ),
            None => format!("{count} layout{plural}"),
        }
    }

    /// One after the other, the last slot running fastest; nothing is held in memory.
    pub(crate) fn iter(self) -> impl Iterator<Item = Candidate> + use<'a> {
        let sets: Vec<(&'a Slot, &'a CandidateSet)> = self.design.candidates.iter().collect();
        combinations(sets)
    }
}

/// How many combinations there are of the layouts of all slots.
pub(crate) fn count(sets: &IndexMap<Slot, CandidateSet>) -> u128 {
    sets.values().map(set_count).fold(1, u128::saturating_mul)
}

fn set_count(set: &CandidateSet) -> u128 {
    match set {
        CandidateSet::Layouts(layouts) => layouts.len() as u128,
        CandidateSet::Budget { enumerations, .. } => enumerations
            .iter()
            .map(quell_network::Enumeration::count)
            .fold(0, u128::saturating_add),
    }
}

fn layouts<'a>(set: &'a CandidateSet) -> Box<dyn Iterator<Item = (Layout, Span)> + 'a> {
    match set {
        CandidateSet::Layouts(layouts) => Box::new(layouts.iter().cloned()),
        CandidateSet::Budget { enumerations, span } => {
            let all = enumerations
                .iter()
                .flat_map(|enumeration| -> Layouts<'a> { enumeration.iter() });
            // A budget with masses also has layouts in which a mass would not stand at the end: they do not exist.
            Box::new(
                all.filter(|layout| !layout.contains_mass() || layout.ends_in_mass())
                    .map(move |layout| (layout, *span)),
            )
        }
    }
}

fn combinations<'a>(
    mut sets: Vec<(&'a Slot, &'a CandidateSet)>,
) -> Box<dyn Iterator<Item = Candidate> + 'a> {
    let Some((slot, set)) = sets.pop() else {
        return Box::new(std::iter::once(Candidate {
            layouts: Vec::new(),
        }));
    };
    if sets.is_empty() {
        return Box::new(layouts(set).map(move |(layout, span)| Candidate {
            layouts: vec![(slot.clone(), layout, span)],
        }));
    }
    Box::new(combinations(sets).flat_map(move |first| {
        layouts(set).map(move |(layout, span)| {
            let mut candidate = first.clone();
            candidate.layouts.push((slot.clone(), layout, span));
            candidate
        })
    }))
}
