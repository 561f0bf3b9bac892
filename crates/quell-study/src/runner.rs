//! Running a study: from its tasks to ranked shortlists.

mod branches;
mod candidate;
mod design;
mod events;
mod front;
mod recorder;
mod remarks;
mod simplify;
mod starts;
mod synthesis;

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use indexmap::IndexMap;
use quell_continuation::Interrupt;
use quell_document::Fault;

use self::recorder::Recorder;
use crate::candidates::Candidates;
use crate::configuration::{configuration, evaluated};
use crate::outcome::{Findings, Plot, PointOutcome, Role, RunOutcome, TaskOutcome};
use crate::plots::Curves;
use crate::situation::{self, Situation};
use crate::store::{Store, StoreError};
use crate::study::{ConfigurationSpec, Study, Task, TaskKind};
use crate::sweep::sweep_points;
use branches::Solved;

/// How a study is run.
#[derive(Debug, Clone, Default)]
pub struct RunSettings {
    /// Seed of the random streams.
    pub seed: u64,
    /// Threads; one for each core unless given.
    pub threads: Option<usize>,
    /// Names of the tasks to run; all if empty.
    pub tasks: Vec<String>,
}

/// Whoever wants to know how far a run is.
pub trait Progress: Sync {
    /// A task begins that has so many units of work.
    fn begin(&self, task: &str, units: u64);
    /// A unit is done; `best` says in words what is the best so far. With a store, what it took is on the disk.
    fn advance(&self, best: &str);
    /// So many pieces of work of this run came from the store.
    fn restored(&self, pieces: u64) {
        let _ = pieces;
    }
    /// How far the unit at hand is, in words.
    fn note(&self, _words: &str) {}
    /// What is raised to end branches, curves and diagrams at their next point; no further task is begun then.
    fn interrupt(&self) -> Option<Interrupt> {
        None
    }
    /// From now on (or no longer) branches are followed, which heed the interrupt.
    fn heed(&self, _heeded: bool) {}
}

/// Nobody wants to know.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Progress for Silent {
    fn begin(&self, _: &str, _: u64) {}
    fn advance(&self, _: &str) {}
}

/// Why a run ended without results.
#[derive(Debug, Clone)]
pub enum RunError {
    /// A task was asked for that the study does not have.
    NoSuchTask(Box<Fault>),
    /// The study is wrong.
    Study(Box<Fault>),
    /// The threads could not be started.
    Threads(Box<Fault>),
    /// The run store failed; what was finished before is in it.
    Store(Box<Fault>),
}

impl RunError {
    /// What to tell the user.
    pub fn fault(&self) -> &Fault {
        match self {
            Self::NoSuchTask(fault)
            | Self::Study(fault)
            | Self::Threads(fault)
            | Self::Store(fault) => fault,
        }
    }
}

impl std::fmt::Display for RunError {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.fault().fmt(formatter)
    }
}

impl std::error::Error for RunError {}

impl From<Fault> for RunError {
    fn from(fault: Fault) -> Self {
        Self::Study(Box::new(fault))
    }
}

impl RunSettings {
    /// Whether the study has the tasks that are to be run.
    ///
    /// # Errors
    /// [`RunError::NoSuchTask`].
    pub fn check(&self, study: &Study) -> Result<(), RunError> {
        chosen_tasks(study, &self.tasks).map(drop)
    }
}

/// Runs a study.
///
/// The same study, seed and version give the same designs on any number of threads: every start has a random stream of
/// its own, keyed by seed, candidate and index, and nothing depends on the order in which they finish.
///
/// # Errors
/// [`RunError::Study`] where the study is wrong (as [`crate::check`] would have said), [`RunError::NoSuchTask`] where the
/// settings are, [`RunError::Threads`] where the machine is.
pub fn run(
    study: &Study,
    settings: &RunSettings,
    progress: &dyn Progress,
) -> Result<RunOutcome, RunError> {
    let failure = OnceLock::new();
    let recorder = Recorder::forgetful(progress, &failure);
    recorded(study, settings, &recorder)
}

/// Runs a study as [`run`] does, and keeps every finished piece of work in a store. What the store holds already, from a
/// run of the same study that was interrupted, is taken from there: the designs are the same, bit for bit, as those of a
/// run that was not.
///
/// # Errors
/// As [`run`], and [`RunError::Store`] where the store cannot be written.
pub fn run_with_store(
    study: &Study,
    settings: &RunSettings,
    progress: &dyn Progress,
    store: &Store,
) -> Result<RunOutcome, RunError> {
    let failure = OnceLock::new();
    let (recorder, writer) = Recorder::to(store, progress, &failure);
    let outcome = std::thread::scope(|scope| {
        scope.spawn(|| writer.run());
        let outcome = recorded(study, settings, &recorder);
        // The writer ends when nobody can tell it anything more.
        drop(recorder);
        outcome
    });
    // The last units may fail after the last task has looked.
    match failure.get() {
        Some(error) => Err(RunError::from(error)),
        None => outcome,
    }
}

impl From<&StoreError> for RunError {
    fn from(error: &StoreError) -> Self {
        Self::Store(Box::new(recorder::fault(error)))
    }
}

fn recorded(
    study: &Study,
    settings: &RunSettings,
    recorder: &Recorder<'_>,
) -> Result<RunOutcome, RunError> {
    let started = Instant::now();
    let chosen = chosen_tasks(study, &settings.tasks)?;
    let mut pool = rayon::ThreadPoolBuilder::new();
    if let Some(threads) = settings.threads {
        pool = pool.num_threads(threads);
    }
    let pool = pool.build().map_err(|error| {
        RunError::Threads(Box::new(Fault::new(format!(
            "the threads could not be started: {error}"
        ))))
    })?;
    let evaluations = AtomicU64::new(0);
    let runner = Runner {
        study,
        settings,
        recorder,
        evaluations: &evaluations,
        solved: Solved::default(),
    };
    let mut tasks = Vec::new();
    for task in chosen {
        if runner.interrupted() {
            break;
        }
        let outcome = pool.install(|| runner.task(task))?;
        tasks.push(outcome);
    }
    let results = crate::record::of(
        study,
        settings.seed,
        pool.current_num_threads(),
        started.elapsed().as_secs_f64(),
        evaluations.load(Ordering::Relaxed),
        &tasks,
    );
    Ok(RunOutcome {
        results,
        tasks,
        restored: recorder.restored(),
    })
}

fn chosen_tasks<'a>(study: &'a Study, names: &[String]) -> Result<Vec<&'a Task>, RunError> {
    for name in names {
        if !study.tasks.iter().any(|task| task.name == *name) {
            let known: Vec<&str> = study.tasks.iter().map(|task| task.name.as_str()).collect();
            let fault = Fault::new(format!("the study has no task `{name}`"));
            let fault = match quell_expression::nearest(name, known.iter().copied()) {
                Some(near) => fault.help(format!("did you mean `{near}`?")),
                None => fault.help(format!("its tasks are `{}`", known.join("`, `"))),
            };
            return Err(RunError::NoSuchTask(Box::new(fault)));
        }
    }
    Ok(study
        .tasks
        .iter()
        .filter(|task| names.is_empty() || names.contains(&task.name))
        .collect())
}

struct Runner<'a> {
    study: &'a Study,
    settings: &'a RunSettings,
    recorder: &'a Recorder<'a>,
    evaluations: &'a AtomicU64,
    /// Branches from which others may start.
    solved: Solved,
}

impl Runner<'_> {
    /// Whether somebody asked to stop.
    fn interrupted(&self) -> bool {
        let interrupt = self.recorder.interrupt();
        interrupt.is_some_and(|interrupt| interrupt.is_raised())
    }

    fn task(&self, task: &Task) -> Result<TaskOutcome, RunError> {
        let points = sweep_points(self.study, task)?;
        let units = match &task.kind {
            TaskKind::Evaluate(configurations) => configurations.len() as u128,
            TaskKind::Design(design) => Candidates::of(design).count(),
            TaskKind::Continuation(_) => 1,
        };
        let units = units.saturating_mul(points.len() as u128);
        self.recorder
            .begin(&task.name, u64::try_from(units).unwrap_or(u64::MAX));
        let swept = points.clone();
        let points = points
            .into_iter()
            .map(|at| {
                let situation =
                    situation::build(&self.study.host, &self.study.overrides, &at.parameters())?;
                let (findings, plots) = match &task.kind {
                    TaskKind::Evaluate(configurations) => {
                        self.evaluate(&situation, &at.configurations(configurations))?
                    }
                    TaskKind::Design(design) if !design.further.is_empty() => {
                        self.front(&situation, design)?
                    }
                    TaskKind::Design(design) => self.design(&situation, &at.design(design))?,
                    TaskKind::Continuation(asked) => self.branches(&situation, task, asked)?,
                };
                Ok(PointOutcome {
                    at: at.named(),
                    findings,
                    plots,
                })
            })
            .collect::<Result<Vec<_>, RunError>>()?;
        let mut points = points;
        if !task.sweep.is_empty() {
            branches::number_files(&mut points);
        }
        Ok(TaskOutcome {
            name: task.name.clone(),
            events: self.events(task, &swept)?,
            points,
        })
    }

    fn evaluate(
        &self,
        situation: &Situation,
        configurations: &IndexMap<String, ConfigurationSpec>,
    ) -> Result<(Findings, Vec<Plot>), RunError> {
        let mut curves = Curves::default();
        let mut all = Vec::new();
        for (name, spec) in configurations {
            let evaluator = configuration(self.study, situation, spec)?;
            all.push(evaluated(name, &evaluator, &[]));
            self.evaluations.fetch_add(1, Ordering::Relaxed);
            curves.add(self.study, &evaluator, &[], name, Role::Configuration);
            self.recorder.advance(name);
        }
        Ok((Findings::Evaluate(all), curves.finish()))
    }
}
