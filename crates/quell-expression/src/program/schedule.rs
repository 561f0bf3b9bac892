//! The order of instructions: like after like.
//!
//! A processor that guesses wrongly what comes next loses more time than most operations take, and it guesses that what
//! came last comes again. Sums of the same length count as like.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

use super::code::Code;
use super::rows::{Step, has_third_factors};

/// Reorders a stream so that steps of the same code follow one another, each still after what it reads.
pub(super) fn schedule(steps: Vec<Step>, slots: usize, one: u32) -> Vec<Step> {
    let mut places: Vec<Option<usize>> = vec![None; slots];
    for (place, step) in steps.iter().enumerate() {
        places[step.target() as usize] = Some(place);
    }
    let mut readers: Vec<Vec<usize>> = vec![Vec::new(); steps.len()];
    let mut waiting: Vec<usize> = vec![0; steps.len()];
    for (place, step) in steps.iter().enumerate() {
        let reads: BTreeSet<usize> = step
            .reads()
            .into_iter()
            .filter_map(|read| places[read as usize])
            .collect();
        waiting[place] = reads.len();
        for read in reads {
            readers[read].push(place);
        }
    }
    let code = |step: &Step| match step {
        Step::One(instruction) => (instruction.code as u8, 0),
        Step::Row(_, terms) if has_third_factors(terms, one) => {
            (Code::ProductRow as u8, terms.len())
        }
        Step::Row(_, terms) => (Code::Row as u8, terms.len()),
    };
    let codes: Vec<(u8, usize)> = steps.iter().map(code).collect();
    let mut ready: BTreeMap<(u8, usize), BTreeSet<usize>> = BTreeMap::new();
    for (place, _) in waiting.iter().enumerate().filter(|(_, count)| **count == 0) {
        ready.entry(codes[place]).or_default().insert(place);
    }
    let mut steps: Vec<Option<Step>> = steps.into_iter().map(Some).collect();
    let mut ordered = Vec::with_capacity(steps.len());
    // The code that most steps wait for, then all of it that is ready.
    while let Some(code) = ready
        .iter()
        .max_by_key(|(code, places)| (places.len(), Reverse(**code)))
        .map(|(code, _)| *code)
    {
        while let Some(place) = ready.get_mut(&code).and_then(BTreeSet::pop_first) {
            ordered.extend(steps[place].take());
            for reader in &readers[place] {
                waiting[*reader] -= 1;
                if waiting[*reader] == 0 {
                    ready.entry(codes[*reader]).or_default().insert(*reader);
                }
            }
        }
        ready.remove(&code);
    }
    ordered
}
