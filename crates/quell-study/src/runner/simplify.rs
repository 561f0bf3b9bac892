//! What the last element buys: a design made smaller, element by element.

use std::collections::{BTreeMap, HashSet};

use quell_document::Fault;
use quell_network::{Gone, Layout};
use rayon::prelude::*;

use super::Runner;
use super::candidate::Found;
use super::design::rank;
use crate::candidates::Candidate;
use crate::outcome::Synthesis;
use crate::read::kinds_of;
use crate::situation::Situation;
use crate::study::DesignTask;

/// Of each number of elements, so many of the best layouts are made smaller still.
const KEPT: usize = 3;

/// The best design of a number of elements.
pub(super) struct Smaller {
    pub(super) elements: usize,
    pub(super) found: Found,
    /// What was left out, of which layout.
    pub(super) without: String,
    /// How many layouts of this number of elements were searched.
    pub(super) tried: usize,
}

impl Runner<'_> {
    /// From the best design, or the smallest network of its function, to smaller ones: each element removed in both ways, every
    /// layout that is left searched anew, and the best few of each size made smaller again.
    pub(super) fn simplify(
        &self,
        situation: &Situation,
        design: &DesignTask,
        best: &Found,
        synthesis: &[Synthesis],
    ) -> Result<Vec<Smaller>, Fault> {
        let [(slot, layout, span)] = best.candidate.layouts.as_slice() else {
            return Ok(Vec::new());
        };
        let begin = match synthesis.first() {
            None => layout.clone(),
            Some(synthesis) => {
                let kinds = kinds_of(self.study, layout.domain());
                let found = synthesis
                    .networks
                    .iter()
                    .filter(|network| network.is_series_parallel)
                    .find_map(|network| Layout::parse(&network.network, &kinds).ok());
                match found {
                    Some(found) => found,
                    None => return Ok(Vec::new()),
                }
            }
        };
        let count = |layout: &Layout| layout.branches().count();
        let mut seen: HashSet<String> = HashSet::from([begin.canonical().to_string()]);
        let mut waiting: BTreeMap<usize, Vec<(Layout, String)>> = BTreeMap::new();
        let what = if synthesis.is_empty() {
            "the best design"
        } else {
            "the smallest network of the function, searched anew"
        };
        waiting.insert(count(&begin), vec![(begin, what.to_owned())]);
        let mut smaller = Vec::new();
        while let Some((elements, layouts)) = waiting.pop_last() {
            let tried = layouts.len();
            let mut found: Vec<(Found, String)> = layouts
                .into_par_iter()
                .with_max_len(1)
                .map(|(layout, without)| {
                    let candidate = Candidate {
                        layouts: vec![(slot.clone(), layout, *span)],
                    };
                    Ok((self.candidate(situation, design, candidate)?, without))
                })
                .collect::<Result<_, Fault>>()?;
            let mut order: Vec<Found> = Vec::new();
            let mut words: Vec<(String, String)> = Vec::new();
            for (one, without) in found.drain(..) {
                words.push((one.candidate.label(), without));
                order.push(one);
            }
            rank(&mut order, design.sense);
            for one in order.iter().take(KEPT) {
                let Some((_, layout, _)) = one.candidate.layouts.first() else {
                    continue;
                };
                for removal in layout.removals(&[]) {
                    let Some(left) = removal.layout else {
                        continue;
                    };
                    // What is given stays where it is.
                    let given = |name: &str| design.fixed.contains_key(name);
                    let kept = layout
                        .branches()
                        .filter(|branch| given(&branch.name))
                        .all(|branch| left.branch(&branch.name).is_some());
                    if !kept || !seen.insert(left.canonical().to_string()) {
                        continue;
                    }
                    let how = match removal.how {
                        Gone::Free => "taken out of",
                        Gone::Rigid => "made rigid in",
                    };
                    let without = format!("`{}` {how} `{layout}`", removal.branch);
                    waiting
                        .entry(count(&left))
                        .or_default()
                        .push((left, without));
                }
            }
            let mut order = order.into_iter();
            if let Some(found) = order.next() {
                let label = found.candidate.label();
                let without = words
                    .into_iter()
                    .find(|(known, _)| *known == label)
                    .map(|(_, without)| without);
                smaller.push(Smaller {
                    elements,
                    found,
                    without: without.unwrap_or_default(),
                    tried,
                });
            }
        }
        Ok(smaller)
    }
}
