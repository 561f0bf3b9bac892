//! Branches of equilibria and cycles, curves of their special points, diagrams, regions, and motions in time that check them: the tasks
//! `branch`, `curve`, `diagram`, `region`, `simulate`.

mod ask;
mod field;
mod follower;
mod forcing;
mod measure;
mod model;
mod motions;
mod moving;
mod outcome;
mod record;
mod region;
mod report;
mod settled;
mod solve;
mod solved;
mod watch;

pub use ask::{
    BranchStart, ContinuationTask, Follows, Measure, MotionStarts, MotionsAsked, ParameterRange,
};
pub(crate) use field::{Assignment, Field};
pub use motions::{
    MotionCount, MotionEnd, MotionFindings, MotionOutcome, PlaceOutcome, StableOutcome,
};
pub(crate) use moving::{Entry, Moving};
pub use outcome::{
    BranchOutcome, BranchPoint, ContinuationFindings, FreeParameter, MeasureHead, SpecialPoint,
};
pub(crate) use record::record;
pub use record::{
    AtResult, AttractorResult, BranchResult, CellResult, ContinuationResult, MotionResult,
    MotionsResult, PlaceResult, RegionResult, SpecialResult, StableResult, StopResult,
};
pub use region::{AttractorOutcome, CellOutcome, RegionFindings};
pub(crate) use solve::{Company, solve};
pub(crate) use solved::Solved;
pub(crate) use watch::Watcher;

use quell_document::Fault;

use crate::situation::Situation;
use crate::study::{Study, TaskKind};

impl Study {
    /// Whether a task follows branches.
    pub(crate) fn follows_branches(&self) -> bool {
        self.tasks
            .iter()
            .any(|task| matches!(task.kind, TaskKind::Continuation(_)))
    }

    /// The task of this kind and name.
    pub(crate) fn continuation(&self, name: &str) -> Option<&ContinuationTask> {
        self.tasks.iter().find_map(|task| match &task.kind {
            TaskKind::Continuation(found) if task.name == name => Some(found.as_ref()),
            _ => None,
        })
    }
}

/// Checks a task without following anything; says what it would do.
///
/// # Errors
/// Whatever is wrong with it.
pub(crate) fn check(
    study: &Study,
    situation: &Situation,
    task: &ContinuationTask,
) -> Result<String, Fault> {
    let whole = inherited(study, task);
    let (model, ..) = solve::model(study, situation, &whole, None)?;
    solve::settings(situation, &whole, &model, &Watcher::default())?;
    solve::searched(study, situation, &whole, &model)?;
    let names: Vec<&str> = task
        .parameters
        .iter()
        .map(|(name, _)| name.as_str())
        .collect();
    let states = model.states().len();
    if task.follows == Follows::Motions {
        let number = motions::check(study, situation, &whole, &model)?;
        let compared = match &task.motions.of {
            Some(of) => format!(", and compares where they end with `{of}`"),
            None => String::new(),
        };
        return Ok(format!(
            "lets {number} motions go ({states} states){compared}"
        ));
    }
    if task.follows == Follows::Region {
        return Ok(format!(
            "divides the plane of {} by what is stable ({states} states)",
            names.join(" and ")
        ));
    }
    Ok(format!(
        "follows a {} in {} ({states} states)",
        task.follows.kind(),
        names.join(" and ")
    ))
}

/// A task with what it takes from those that it starts at: configuration and ranges.
fn inherited(study: &Study, task: &ContinuationTask) -> ContinuationTask {
    let mut whole = task.clone();
    let mut next = task;
    // They are tasks above, so this ends.
    while let Some(before) = next.before().next() {
        let Some(before) = study.continuation(before) else {
            break;
        };
        if whole.configuration.is_none() {
            whole.configuration.clone_from(&before.configuration);
        }
        for (name, range) in &before.ranges {
            if !whole.ranges.contains_key(name) {
                whole.ranges.insert(name.clone(), range.clone());
            }
        }
        next = before;
    }
    whole
}
