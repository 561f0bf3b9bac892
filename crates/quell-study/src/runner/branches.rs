//! Tasks of kind `branch`, `curve` and `diagram`.

use std::collections::HashMap;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use super::{RunError, Runner};
use crate::continuation::{self, BranchStart, ContinuationTask, Watcher};
use crate::outcome::{Findings, Plot, PointOutcome};
use crate::situation::{self, Situation};
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
        // A start names a task above, so this ends.
        let before = match &asked.start {
            BranchStart::Label { task, .. } => match self.study.continuation(task) {
                Some(own) => {
                    let standing = situation::build(&self.study.host, &self.study.overrides, &[])?;
                    Some(self.solve(&standing, task, own, true)?)
                }
                None => None,
            },
            _ => None,
        };
        let watcher = Watcher::default();
        let parameter = asked.parameters.first().map_or("", |(name, _)| name);
        let (finished, waiting) = channel::<()>();
        let solved = std::thread::scope(|scope| {
            let (watcher, progress) = (&watcher, self.recorder);
            scope.spawn(move || {
                while matches!(waiting.recv_timeout(TOLD), Err(RecvTimeoutError::Timeout)) {
                    progress.note(&watcher.words(parameter));
                }
            });
            let solved =
                continuation::solve(self.study, situation, name, asked, before.as_ref(), watcher);
            drop(finished);
            solved
        })?;
        self.evaluations
            .fetch_add(watcher.solutions(), Ordering::Relaxed);
        let solved = Arc::new(solved);
        if kept {
            let mut all = self.solved.0.lock().unwrap_or_else(PoisonError::into_inner);
            all.insert(name.to_owned(), Arc::clone(&solved));
        }
        Ok(solved)
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
