//! Starts of a search as units of work.

use quell_document::Fault;
use quell_search::{Outcome, Settings, StartResult, collect, start};
use rayon::prelude::*;

use super::Runner;
use crate::problem::DesignProblem;
use crate::store::KeyBuilder;
use crate::study::DesignTask;

/// What a start is called in a store.
const KIND: &str = "start";

/// How many starts are made.
#[derive(Debug, Clone, Copy)]
pub(super) struct Effort {
    /// So many at first, and as many more each time.
    pub(super) batch: usize,
    /// Until so many agree on the best feasible objective; none: the first batch is all.
    pub(super) agree: Option<usize>,
    /// But no more than these.
    pub(super) most: usize,
}

impl Effort {
    /// What a task asks for.
    pub(super) fn of(design: &DesignTask, settings: &Settings) -> Self {
        let batch = settings.starts;
        match design.agree {
            None => Self {
                batch,
                agree: None,
                most: batch,
            },
            Some(agree) => Self {
                batch,
                agree: Some(agree.starts),
                most: agree.most.unwrap_or(10 * batch.max(agree.starts)),
            },
        }
    }
}

impl Runner<'_> {
    /// Starts, batch after batch until enough of them agree, each taken from the store where it is there.
    ///
    /// `key` holds everything that determines a start but the settings of the search, the stream and the index.
    pub(super) fn starts(
        &self,
        problem: &DesignProblem,
        settings: &Settings,
        effort: Effort,
        stream: u64,
        key: &KeyBuilder,
    ) -> Result<Outcome, Fault> {
        // How many there are decides nothing about any one of them.
        let alone = Settings {
            starts: 1,
            ..settings.clone()
        };
        // Debug writes every field, and numbers so that they read back to the same bits.
        let key = key.clone().text(&format!("{alone:?}")).count(stream);
        let mut results: Vec<StartResult> = Vec::new();
        loop {
            self.recorder.check()?;
            let from = results.len();
            let to = from.saturating_add(effort.batch).min(effort.most);
            results.par_extend((from..to).into_par_iter().map(|index| {
                self.recorder.unit(
                    &key.clone().count(index as u64).key(),
                    KIND,
                    StartResult::from_bytes,
                    StartResult::to_bytes,
                    || start(problem, settings, stream, index),
                )
            }));
            let outcome = collect(problem, settings, results.clone());
            let enough = effort
                .agree
                .is_none_or(|agree| outcome.starts_agreeing >= agree);
            if enough || to == effort.most || to == from {
                return Ok(outcome);
            }
        }
    }
}
