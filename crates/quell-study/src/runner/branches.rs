//! Tasks of kind `branch`, `curve` and `diagram`.

use std::collections::HashMap;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use quell_continuation::Keeper;

use super::recorder::Recorder;
use super::{RunError, Runner};
use crate::continuation::{self, ContinuationTask, Watcher};
use crate::outcome::{Findings, Plot, PointOutcome};
use crate::situation::{self, Situation};
use crate::store::{Key, KeyBuilder};
use crate::study::Task;

/// What tasks have found, by name, for those that start there.
#[derive(Default)]
pub(super) struct Solved(Mutex<HashMap<String, Arc<continuation::Solved>>>);

/// How often somebody is told how far a branch is.
const TOLD: Duration = Duration::from_millis(200);

impl Runner<'_> {
    /// Follows what a task asks for.
    pub(super) fn branches(
        &self,
        situation: &Situation,
        task: &Task,
        asked: &ContinuationTask,
    ) -> Result<(Findings, Vec<Plot>), RunError> {
        let solved = self.solve(situation, &task.name, asked, task.sweep.is_empty())?;
        let found = solved.findings.clone();
        self.recorder.advance(&found.status);
        Ok((Findings::Continuation(Box::new(found)), Vec::new()))
    }

    fn solve(
        &self,
        situation: &Situation,
        name: &str,
        asked: &ContinuationTask,
        kept: bool,
    ) -> Result<Arc<continuation::Solved>, RunError> {
        let known = || {
            let all = self.solved.0.lock().unwrap_or_else(PoisonError::into_inner);
            all.get(name).cloned()
        };
        if let Some(known) = known().filter(|_| kept) {
            return Ok(known);
        }
        // They are tasks above, so this ends.
        let mut before = Vec::new();
        for task in asked.before() {
            if let Some(own) = self.study.continuation(task) {
                let standing = situation::build(&self.study.host, &self.study.overrides, &[])?;
                before.push(self.solve(&standing, task, own, true)?);
            }
        }
        let watcher = Watcher::default();
        let keeper = Kept {
            recorder: self.recorder,
            key: self.branch_key(situation, name, asked),
        };
        let parameter = asked.parameters.first().map_or("", |(name, _)| name);
        let (finished, waiting) = channel::<()>();
        let solved = std::thread::scope(|scope| {
            let (watcher, progress) = (&watcher, self.recorder);
            scope.spawn(move || {
                while matches!(waiting.recv_timeout(TOLD), Err(RecvTimeoutError::Timeout)) {
                    progress.note(&watcher.words(parameter));
                }
            });
            self.recorder.heed(true);
            let solved = continuation::solve(
                self.study,
                situation,
                name,
                asked,
                &before,
                &continuation::Company {
                    watcher,
                    keeper: &keeper,
                    interrupt: self.recorder.interrupt(),
                },
            );
            self.recorder.heed(false);
            drop(finished);
            solved
        })?;
        self.evaluations
            .fetch_add(solved.solutions(), Ordering::Relaxed);
        let solved = Arc::new(solved);
        if kept {
            let mut all = self.solved.0.lock().unwrap_or_else(PoisonError::into_inner);
            all.insert(name.to_owned(), Arc::clone(&solved));
        }
        Ok(solved)
    }
}

/// What a branch is called in a store.
const KIND: &str = "branch";

/// Branches of a task in the store of a run.
struct Kept<'a> {
    recorder: &'a Recorder<'a>,
    /// Everything that determines them but which of them it is.
    key: KeyBuilder,
}

impl Keeper for Kept<'_> {
    fn get(&self, name: &str) -> Option<Vec<u8>> {
        let key = self.key.clone().text(name).key();
        let found = self.recorder.kept(&key, KIND)?;
        self.recorder.tell_restored(&key);
        Some(found)
    }

    fn put(&self, name: &str, bytes: Vec<u8>) {
        let key = self.key.clone().text(name).key();
        self.recorder.keep(&key, KIND, bytes);
    }
}

impl Runner<'_> {
    fn branch_key(
        &self,
        situation: &Situation,
        name: &str,
        asked: &ContinuationTask,
    ) -> KeyBuilder {
        let mut key = Key::of("branch")
            .text(env!("CARGO_PKG_VERSION"))
            .text(&self.study.hash)
            .text(name)
            .text(asked.follows.kind());
        for (name, quantity) in &situation.parameters {
            key = key.text(name).number(quantity.value);
        }
        key
    }
}

/// Tells the files of the points of a sweep apart, which have the same branches.
pub(super) fn number_files(points: &mut [PointOutcome]) {
    for (index, point) in points.iter_mut().enumerate() {
        if let Findings::Continuation(found) = &mut point.findings {
            for branch in &mut found.branches {
                branch.file = format!("{}-{}", index + 1, branch.file);
            }
        }
    }
}
