//! Running a study: from its tasks to ranked shortlists.

use std::cmp::Ordering;
use std::fmt::Write as _;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering as Memory};
use std::time::Instant;

use indexmap::IndexMap;
use quell_document::Fault;
use quell_expression::Quantity;
use quell_network::Layout;
use quell_search::{Outcome, Problem, Scale, Settings, Side, search};
use rayon::prelude::*;

use crate::built::{Built, Candidate, Values, domain_of};
use crate::candidates::{Candidates, single_slot};
use crate::evaluator::{Certified, Evaluator, EvaluatorScratch};
use crate::outcome::{
    Design, DesignFindings, Evaluated, Findings, NamedValue, PointOutcome, RunOutcome, TaskOutcome,
};
use crate::plots;
use crate::problem::{DesignProblem, Goal};
use crate::situation::{self, Situation};
use crate::study::{
    ConfigurationSpec, Constraint, DesignTask, Sense, Study, SweepAxis, SweepRange, SweepValues,
    Task, TaskKind,
};
use crate::unread;

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
    /// A unit is done; `best` says in words what is the best so far.
    fn advance(&self, best: &str);
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
    /// The study is wrong.
    Study(Box<Fault>),
    /// The computation failed.
    Failed(Box<Fault>),
}

impl std::fmt::Display for RunError {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Study(fault) | Self::Failed(fault) => fault.fmt(formatter),
        }
    }
}

impl std::error::Error for RunError {}

impl From<Fault> for RunError {
    fn from(fault: Fault) -> Self {
        Self::Study(Box::new(fault))
    }
}

/// Most rounds of searching again after a certificate found a peak that the grid had missed.
const ROUNDS: usize = 6;

/// Candidates that are searched as one batch, so that an enumeration is never held in memory as a whole.
const BATCH: usize = 4096;

/// Runs a study.
///
/// The same study, seed and version give the same designs on any number of threads: every start has a random stream of
/// its own, keyed by seed, candidate and index, and nothing depends on the order in which they finish.
///
/// # Errors
/// [`RunError::Study`] where the study is wrong (as [`crate::check`] would have said), [`RunError::Failed`] where the
/// machine is.
pub fn run(
    study: &Study,
    settings: &RunSettings,
    progress: &dyn Progress,
) -> Result<RunOutcome, RunError> {
    let started = Instant::now();
    let chosen = chosen_tasks(study, &settings.tasks)?;
    let mut pool = rayon::ThreadPoolBuilder::new();
    if let Some(threads) = settings.threads {
        pool = pool.num_threads(threads);
    }
    let pool = pool.build().map_err(|error| {
        RunError::Failed(Box::new(Fault::new(format!(
            "the threads could not be started: {error}"
        ))))
    })?;
    let evaluations = AtomicU64::new(0);
    let runner = Runner {
        study,
        settings,
        progress,
        evaluations: &evaluations,
    };
    let mut tasks = Vec::new();
    for task in chosen {
        let outcome = pool.install(|| runner.task(task))?;
        tasks.push(outcome);
    }
    let results = crate::record::of(
        study,
        settings.seed,
        pool.current_num_threads(),
        started.elapsed().as_secs_f64(),
        evaluations.load(Memory::Relaxed),
        &tasks,
    );
    Ok(RunOutcome { results, tasks })
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
            return Err(fault.into());
        }
    }
    Ok(study
        .tasks
        .iter()
        .filter(|task| names.is_empty() || names.contains(&task.name))
        .collect())
}

/// What [`check`] says about a sound study.
#[derive(Debug, Clone)]
pub struct Summary {
    /// Line by line.
    pub lines: Vec<String>,
}

/// Candidates beyond this number are not all built by [`check`]: they differ only in their layout.
const CHECKED: usize = 200;

/// Checks everything that can be wrong with a study without computing: every configuration and candidate is built, every
/// criterion compiled.
///
/// # Errors
/// The first thing that is wrong, at its place.
pub fn check(study: &Study) -> Result<Summary, Fault> {
    let mut lines = Vec::new();
    let standing = situation::build(&study.host, &study.overrides, &[])?;
    lines.push(format!(
        "host {}: {}, {}, {}",
        standing.host.name,
        counted(standing.host.coordinates.len(), "coordinate"),
        counted(standing.host.inputs.len(), "input"),
        counted(standing.host.ports.len(), "port"),
    ));
    for task in &study.tasks {
        let points = sweep_points(study, task)?;
        let mut line = String::new();
        for at in &points {
            let situation = situation::build(&study.host, &study.overrides, at)?;
            line = match &task.kind {
                TaskKind::Evaluate(configurations) => {
                    for spec in configurations.values() {
                        configuration(study, &situation, spec)?;
                    }
                    format!(
                        "evaluates {}",
                        counted(configurations.len(), "configuration")
                    )
                }
                TaskKind::Design(design) => check_design(study, &situation, design)?,
            };
        }
        if points.len() > 1 {
            let _ = write!(line, ", at {} points of the sweep", points.len());
        }
        lines.push(format!("task {}: {line}", task.name));
    }
    unread::check(study, &standing)?;
    Ok(Summary { lines })
}

fn counted(number: usize, what: &str) -> String {
    format!("{number} {what}{}", if number == 1 { "" } else { "s" })
}

fn check_design(
    study: &Study,
    situation: &Situation,
    design: &DesignTask,
) -> Result<String, Fault> {
    let candidates = Candidates::of(design);
    let mut used = std::collections::HashSet::new();
    let (mut fewest, mut most) = (usize::MAX, 0);
    for candidate in candidates.iter().take(CHECKED) {
        let problem = design_problem(study, situation, design, &candidate)?;
        let built = problem.evaluator.built();
        used.extend(built.used.iter().cloned());
        fewest = fewest.min(built.variables.len());
        most = most.max(built.variables.len());
    }
    if candidates.count() <= CHECKED as u128 {
        let keys = design
            .fixed
            .iter()
            .map(|(key, amount)| (key, amount.span()));
        let keys = keys.chain(design.bounds.iter().map(|(key, bounds)| (key, bounds.span)));
        for (key, span) in keys {
            if !used.contains(key) {
                return Err(Fault::at(
                    &study.source,
                    span,
                    format!(
                        "nothing in the layouts of this task takes its value or range from `{key}`"
                    ),
                )
                .help("remove it, or mend its name"));
            }
        }
    }
    for (name, span) in &design.references {
        match reference_candidate(study, design, name, *span)? {
            Reference::Configuration(spec) => configuration(study, situation, spec).map(drop)?,
            Reference::Layout(candidate) => {
                design_problem(study, situation, design, &candidate).map(drop)?;
            }
        }
    }
    let variables = if fewest == most {
        counted(most, "variable")
    } else {
        format!("{fewest} to {most} variables")
    };
    let plural = if candidates.count() == 1 { "" } else { "s" };
    Ok(format!(
        "designs {} layout{plural} of {variables} for {}",
        candidates.count(),
        design.objective
    ))
}

/// A reference: a configuration of the study, or a layout to be designed.
enum Reference<'a> {
    Configuration(&'a ConfigurationSpec),
    Layout(Candidate),
}

fn reference_candidate<'a>(
    study: &'a Study,
    design: &DesignTask,
    name: &str,
    span: quell_expression::Span,
) -> Result<Reference<'a>, Fault> {
    let configurations = || {
        study.tasks.iter().filter_map(|task| match &task.kind {
            TaskKind::Evaluate(configurations) => Some(configurations),
            TaskKind::Design(_) => None,
        })
    };
    if let Some(spec) = configurations().find_map(|known| known.get(name)) {
        return Ok(Reference::Configuration(spec));
    }
    let fault = |message: String| Fault::at(&study.source, span, message);
    let Some(slot) = single_slot(design) else {
        return Err(fault(format!("there is no configuration `{name}`"))
            .help("where several slots are designed, a reference is a configuration of an `evaluate` task"));
    };
    let domain = domain_of(study, slot);
    let kinds = study
        .kinds
        .of(domain)
        .cloned()
        .unwrap_or_else(|| quell_network::Kinds::new(domain));
    match Layout::parse(name, &kinds) {
        Ok(layout) => Ok(Reference::Layout(Candidate {
            layouts: vec![(slot.clone(), layout, span)],
        })),
        Err(error) => {
            let names: Vec<&String> = configurations().flat_map(IndexMap::keys).collect();
            let fault = fault(format!(
                "`{name}` is neither a configuration nor a layout: {}",
                error.message
            ));
            let near = quell_expression::nearest(name, names.iter().map(|name| name.as_str()));
            if let Some(near) = near {
                return Err(fault.help(format!("did you mean `{near}`?")));
            }
            let all: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
            let mut help = error.help.unwrap_or_default();
            if !all.is_empty() {
                help = format!("configurations are {}. {help}", all.join(", "));
            }
            Err(fault.help(help.trim().to_owned()))
        }
    }
}

/// The sets of swept values, in the order of the sweep (the last axis runs fastest).
fn sweep_points(study: &Study, task: &Task) -> Result<Vec<Vec<(String, Quantity)>>, Fault> {
    let mut points: Vec<Vec<(String, Quantity)>> = vec![Vec::new()];
    if task.sweep.is_empty() {
        return Ok(points);
    }
    let standing = situation::build(&study.host, &study.overrides, &[])?;
    for axis in &task.sweep {
        let values = axis_values(study, axis, &standing)?;
        points = points
            .iter()
            .flat_map(|point| {
                values.iter().map(|value| {
                    let mut point = point.clone();
                    point.push((axis.parameter.clone(), *value));
                    point
                })
            })
            .collect();
    }
    Ok(points)
}

fn axis_values(
    study: &Study,
    axis: &SweepAxis,
    standing: &Situation,
) -> Result<Vec<Quantity>, Fault> {
    let Some((_, known)) = standing
        .parameters
        .iter()
        .find(|(name, _)| *name == axis.parameter)
    else {
        return Err(Fault::at(
            &study.source,
            axis.span,
            format!("the host has no parameter `{}`", axis.parameter),
        ));
    };
    let dimension = known.dimension;
    let numbers = match &axis.values {
        SweepValues::List(amounts) => amounts
            .iter()
            .map(|amount| amount.value(&standing.parameters, dimension))
            .collect::<Result<Vec<f64>, Fault>>()?,
        SweepValues::Range(range) => {
            let SweepRange {
                from,
                to,
                points,
                scale,
            } = range.as_ref();
            let first = from.value(&standing.parameters, dimension)?;
            let last = to.value(&standing.parameters, dimension)?;
            if *scale == Scale::Logarithmic && (first <= 0.0 || last <= 0.0) {
                return Err(from.fault("a logarithmic sweep runs between positive values"));
            }
            let steps = points.saturating_sub(1).max(1) as f64;
            (0..*points)
                .map(|index| {
                    let share = index as f64 / steps;
                    match scale {
                        // The ends are the values as typed, to the last bit.
                        _ if index == 0 => first,
                        _ if index + 1 == *points => last,
                        Scale::Linear => first * (1.0 - share) + last * share,
                        Scale::Logarithmic => first * (last / first).powf(share),
                    }
                })
                .collect()
        }
    };
    Ok(numbers
        .into_iter()
        .map(|value| Quantity::new(value, dimension))
        .collect())
}

/// Builds a configuration with all its criteria.
fn configuration(
    study: &Study,
    situation: &Situation,
    spec: &ConfigurationSpec,
) -> Result<Evaluator, Fault> {
    let candidate = Candidate {
        layouts: spec
            .layouts
            .iter()
            .map(|(slot, (layout, span))| (slot.clone(), layout.clone(), *span))
            .collect(),
    };
    let bounds = IndexMap::new();
    let built = Built::new(
        study,
        situation,
        &candidate,
        Values {
            given: &spec.values,
            bounds: &bounds,
            searched: false,
        },
    )?;
    for (key, amount) in &spec.values {
        if !built.used.contains(key) {
            let fault = amount.fault(format!("`{key}` is in no layout of this configuration"));
            let names = built.value_names();
            return Err(
                match quell_expression::nearest(key, names.iter().map(String::as_str)) {
                    Some(near) => fault.help(format!("did you mean `{near}`?")),
                    None => fault.help("remove it, or mend its name"),
                },
            );
        }
    }
    if let Some((name, value)) = built.impossible_value(&[]) {
        return Err(Fault::at(
            &study.source,
            spec.span,
            format!(
                "the value {value} of `{name}` cannot be: an element's value is finite and not negative"
            ),
        ));
    }
    Evaluator::new(study, situation, Arc::new(built), None)
}

/// Builds the problem of one candidate.
fn design_problem(
    study: &Study,
    situation: &Situation,
    design: &DesignTask,
    candidate: &Candidate,
) -> Result<DesignProblem, Fault> {
    let values = Values {
        given: &design.fixed,
        bounds: &design.bounds,
        searched: true,
    };
    let built = Built::new(study, situation, candidate, values)?;
    let mut names: Vec<&str> = vec![&design.objective];
    names.extend(
        design
            .constraints
            .iter()
            .map(|constraint| constraint.criterion.as_str()),
    );
    let evaluator = Evaluator::new(study, situation, Arc::new(built), Some(&names))?;
    let index = |name: &str| {
        evaluator
            .index(name)
            .ok_or_else(|| Fault::new(format!("there is no criterion `{name}`")))
    };
    let objective = Goal {
        criterion: index(&design.objective)?,
        sense: design.sense,
        bound: 0.0,
    };
    let constraints = design
        .constraints
        .iter()
        .map(|constraint| {
            let criterion = index(&constraint.criterion)?;
            let bound = constraint
                .bound
                .value(&situation.parameters, evaluator.dimension(criterion))?;
            Ok(Goal {
                criterion,
                sense: constraint.sense,
                bound,
            })
        })
        .collect::<Result<Vec<Goal>, Fault>>()?;
    Ok(DesignProblem {
        evaluator,
        objective,
        constraints,
    })
}

/// The problems of a design task at the host's own parameters, each with its layout in words: for users who bring their own
/// optimiser, and for benchmarks.
///
/// # Errors
/// There is no such design task, or whatever is wrong with the study.
pub fn problems(study: &Study, task: &str) -> Result<Vec<(String, DesignProblem)>, Fault> {
    let design = study.tasks.iter().find_map(|known| match &known.kind {
        TaskKind::Design(design) if known.name == task => Some(design),
        _ => None,
    });
    let design =
        design.ok_or_else(|| Fault::new(format!("the study has no design task `{task}`")))?;
    let situation = situation::build(&study.host, &study.overrides, &[])?;
    Candidates::of(design)
        .iter()
        .map(|candidate| {
            Ok((
                candidate.label(),
                design_problem(study, &situation, design, &candidate)?,
            ))
        })
        .collect()
}

struct Runner<'a> {
    study: &'a Study,
    settings: &'a RunSettings,
    progress: &'a dyn Progress,
    evaluations: &'a AtomicU64,
}

/// A design before it is ranked.
struct Found {
    evaluated: Evaluated,
    objective: f64,
    feasible: bool,
    violation: f64,
    active_bounds: Vec<String>,
    starts: usize,
    starts_agreeing: usize,
    evaluations: u64,
    status: String,
    /// For plots of the best: the evaluator with all criteria, and the point.
    point: Vec<f64>,
    candidate: Candidate,
}

impl Runner<'_> {
    fn task(&self, task: &Task) -> Result<TaskOutcome, RunError> {
        let points = sweep_points(self.study, task)?;
        let units = match &task.kind {
            TaskKind::Evaluate(configurations) => configurations.len() as u128,
            TaskKind::Design(design) => Candidates::of(design).count(),
        };
        let units = units.saturating_mul(points.len() as u128);
        self.progress
            .begin(&task.name, u64::try_from(units).unwrap_or(u64::MAX));
        let swept = !task.sweep.is_empty();
        let points = points
            .into_iter()
            .map(|at| {
                let situation = situation::build(&self.study.host, &self.study.overrides, &at)?;
                let (findings, plots) = match &task.kind {
                    TaskKind::Evaluate(configurations) => {
                        self.evaluate(&situation, configurations)?
                    }
                    TaskKind::Design(design) => self.design(&situation, design)?,
                };
                let at = at
                    .into_iter()
                    .filter(|_| swept)
                    .map(|(name, quantity)| NamedValue {
                        name,
                        value: quantity.value,
                        unit: quantity.dimension.unit_text(),
                        bounds: None,
                        logarithmic: false,
                    });
                Ok(PointOutcome {
                    at: at.collect(),
                    findings,
                    plots,
                })
            })
            .collect::<Result<Vec<_>, RunError>>()?;
        Ok(TaskOutcome {
            name: task.name.clone(),
            points,
        })
    }

    fn evaluate(
        &self,
        situation: &Situation,
        configurations: &IndexMap<String, ConfigurationSpec>,
    ) -> Result<(Findings, Vec<crate::outcome::Plot>), RunError> {
        let mut curves = plots::Curves::default();
        let mut all = Vec::new();
        for (name, spec) in configurations {
            let evaluator = configuration(self.study, situation, spec)?;
            all.push(evaluated(name, &evaluator, &[]));
            self.evaluations.fetch_add(1, Memory::Relaxed);
            curves.add(
                self.study,
                &evaluator,
                &[],
                name,
                crate::outcome::Role::Configuration,
            );
            self.progress.advance(name);
        }
        Ok((Findings::Evaluate(all), curves.finish()))
    }

    fn design(
        &self,
        situation: &Situation,
        design: &DesignTask,
    ) -> Result<(Findings, Vec<crate::outcome::Plot>), RunError> {
        let mut curves = plots::Curves::only(&design.objective);
        let references = self.references(situation, design, &mut curves)?;
        let candidates = Candidates::of(design);
        let mut found: Vec<Found> = Vec::new();
        let mut iterator = candidates.iter();
        loop {
            let batch: Vec<Candidate> = iterator.by_ref().take(BATCH).collect();
            if batch.is_empty() {
                break;
            }
            let best = std::sync::Mutex::new(String::new());
            let results: Vec<Result<Found, Fault>> = batch
                .into_par_iter()
                .with_max_len(1)
                .map(|candidate| {
                    let found = self.candidate(situation, design, candidate);
                    self.progress
                        .advance(&self.best_so_far(design, &found, &best));
                    found
                })
                .collect();
            for result in results {
                found.push(result?);
            }
        }
        rank(&mut found, design.sense);
        let designs: Vec<Design> = found
            .iter()
            .enumerate()
            .map(|(index, found)| Design {
                rank: index + 1,
                configuration: found.evaluated.clone(),
                objective: found.objective,
                improvement: improvements(design, found.objective, &references),
                feasible: found.feasible,
                violation: found.violation,
                active_bounds: found.active_bounds.clone(),
                starts: found.starts,
                starts_agreeing: found.starts_agreeing,
                evaluations: found.evaluations,
                status: found.status.clone(),
            })
            .collect();
        for (index, found) in found.iter().enumerate().take(self.study.report.shortlist) {
            let problem = design_problem(self.study, situation, design, &found.candidate)?;
            let role = crate::outcome::Role::Design(index + 1);
            curves.add(
                self.study,
                &problem.evaluator,
                &found.point,
                &found.candidate.label(),
                role,
            );
        }
        let findings = DesignFindings {
            objective: design.objective.clone(),
            sense: design.sense,
            constraints: design.constraints.iter().map(constraint_words).collect(),
            references,
            designs,
            candidates: candidates.words(),
        };
        Ok((Findings::Design(Box::new(findings)), curves.finish()))
    }

    fn references(
        &self,
        situation: &Situation,
        design: &DesignTask,
        curves: &mut plots::Curves,
    ) -> Result<Vec<Evaluated>, RunError> {
        let mut references = Vec::new();
        for (name, span) in &design.references {
            let role = crate::outcome::Role::Reference;
            match reference_candidate(self.study, design, name, *span)? {
                Reference::Configuration(spec) => {
                    let evaluator = configuration(self.study, situation, spec)?;
                    self.evaluations.fetch_add(1, Memory::Relaxed);
                    curves.add(self.study, &evaluator, &[], name, role);
                    references.push(evaluated(name, &evaluator, &[]));
                }
                Reference::Layout(candidate) => {
                    let found = self.candidate(situation, design, candidate)?;
                    let problem = design_problem(self.study, situation, design, &found.candidate)?;
                    curves.add(self.study, &problem.evaluator, &found.point, name, role);
                    references.push(Evaluated {
                        name: name.clone(),
                        ..found.evaluated
                    });
                }
            }
        }
        Ok(references)
    }

    /// The best so far in words, for a progress bar.
    fn best_so_far(
        &self,
        design: &DesignTask,
        found: &Result<Found, Fault>,
        best: &std::sync::Mutex<String>,
    ) -> String {
        let mut best = best
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Ok(found) = found
            && found.feasible
        {
            let unit = self
                .study
                .criteria
                .get(&design.objective)
                .and_then(|criterion| criterion.unit.as_ref());
            let factor = unit.map_or(1.0, |(unit, _)| unit.factor);
            let text = unit.map_or("", |(unit, _)| unit.text.as_str());
            let value = found.objective / factor;
            let before = best
                .split(' ')
                .next()
                .and_then(|number| number.parse::<f64>().ok());
            let better = match (before, design.sense) {
                (None, _) => true,
                (Some(before), Sense::Minimise) => value < before,
                (Some(before), Sense::Maximise) => value > before,
            };
            if better {
                *best = format!("{value:.5} {text} {}", found.candidate.label());
            }
        }
        best.clone()
    }

    /// Searches the values of one candidate, certifies the best, and searches again where a certificate finds more.
    fn candidate(
        &self,
        situation: &Situation,
        design: &DesignTask,
        candidate: Candidate,
    ) -> Result<Found, Fault> {
        let mut problem = design_problem(self.study, situation, design, &candidate)?;
        let dimension = problem.variables().len();
        let mut settings = Settings::for_dimension(dimension);
        settings.seed = self.settings.seed;
        settings.feasibility = design.feasibility;
        if let Some(starts) = design.starts {
            settings.starts = starts;
        }
        let key = stream_key(&candidate);
        let mut evaluations = 0;
        let mut rounds = 0;
        let (outcome, missed) = loop {
            let outcome = if dimension == 0 {
                nothing_to_search(&problem)
            } else {
                search(&problem, &settings, key)
            };
            evaluations += outcome.evaluations as u64;
            if outcome.point.len() != dimension {
                break (outcome, true);
            }
            let mut scratch = EvaluatorScratch::default();
            problem
                .evaluator
                .built()
                .values(&outcome.point, &mut scratch.values);
            let (_, missed) = problem.evaluator.certified(&mut scratch);
            rounds += 1;
            if missed.is_empty() || rounds == ROUNDS || dimension == 0 {
                break (outcome, !missed.is_empty());
            }
            problem.evaluator.add_frequencies(&missed)?;
        };
        self.evaluations.fetch_add(evaluations, Memory::Relaxed);
        self.found(
            situation,
            design,
            candidate,
            &problem,
            &outcome,
            evaluations,
            missed,
        )
    }

    #[expect(
        clippy::too_many_arguments,
        reason = "one place that turns an outcome into a design"
    )]
    fn found(
        &self,
        situation: &Situation,
        design: &DesignTask,
        candidate: Candidate,
        problem: &DesignProblem,
        outcome: &Outcome,
        evaluations: u64,
        missed: bool,
    ) -> Result<Found, Fault> {
        let all = Evaluator::new(
            self.study,
            situation,
            Arc::clone(problem.evaluator.built()),
            None,
        )?;
        let evaluated = evaluated(&candidate.label(), &all, &outcome.point);
        let objective = evaluated
            .criteria
            .get(&design.objective)
            .copied()
            .unwrap_or(f64::NAN);
        // Feasibility is judged on the certified values, not on those of the search.
        let violation = problem
            .constraints
            .iter()
            .zip(&design.constraints)
            .map(|(goal, constraint)| {
                let value = evaluated
                    .criteria
                    .get(&constraint.criterion)
                    .copied()
                    .unwrap_or(f64::NAN);
                let excess = goal.excess(value);
                if excess.is_nan() {
                    f64::INFINITY
                } else {
                    excess
                }
            })
            .fold(0.0, f64::max);
        let feasible = objective.is_finite() && violation <= design.feasibility;
        let variables = problem.variables();
        let active_bounds = outcome
            .active_bounds
            .iter()
            .filter_map(|(index, side)| {
                let side = match side {
                    Side::Lower => "lower",
                    Side::Upper => "upper",
                };
                Some(format!("{} = {side}", variables.get(*index)?.name))
            })
            .collect();
        let status = if !objective.is_finite() {
            let detail = evaluated.details.get(&design.objective);
            detail.map_or_else(|| "no value".to_owned(), |detail| detail.status.clone())
        } else if !feasible {
            "infeasible: no values were found that meet every constraint; this is the least violation".to_owned()
        } else if missed {
            "searched again as often as allowed; the certified value is above the search's estimate"
                .to_owned()
        } else if outcome.starts <= 1 {
            "one start".to_owned()
        } else if outcome.starts_agreeing <= 1 {
            "no two starts agree: raise `starts`".to_owned()
        } else {
            "starts agree".to_owned()
        };
        Ok(Found {
            evaluated,
            objective,
            feasible,
            violation: if feasible { 0.0 } else { violation },
            active_bounds,
            starts: outcome.starts,
            starts_agreeing: outcome.starts_agreeing,
            evaluations,
            status,
            point: outcome.point.clone(),
            candidate,
        })
    }
}

/// A candidate without design variables: one evaluation.
fn nothing_to_search(problem: &DesignProblem) -> Outcome {
    let mut scratch = problem.scratch();
    let mut constraints = vec![0.0; problem.constraints()];
    let objective = problem.evaluate(&[], &mut constraints, &mut scratch);
    let violation = constraints.iter().copied().fold(0.0, f64::max);
    Outcome {
        point: Vec::new(),
        objective,
        constraints,
        violation,
        feasible: violation <= 0.0,
        active_bounds: Vec::new(),
        starts: 1,
        starts_agreeing: 1,
        evaluations: 1,
        status: quell_search::Status::SingleStart,
        certificate: None,
    }
}

/// The random stream's key: the same for the same candidate wherever it stands in a list.
fn stream_key(candidate: &Candidate) -> u64 {
    let mut hasher = blake3::Hasher::new();
    for (slot, layout, _) in &candidate.layouts {
        hasher.update(slot.device.as_bytes());
        hasher.update(&[0]);
        hasher.update(slot.placeholder.as_deref().unwrap_or_default().as_bytes());
        hasher.update(&[0]);
        hasher.update(layout.canonical().to_string().as_bytes());
        hasher.update(&[0]);
    }
    let bytes = hasher.finalize();
    bytes
        .as_bytes()
        .iter()
        .take(8)
        .fold(0, |key, byte| (key << 8) | u64::from(*byte))
}

fn evaluated(name: &str, evaluator: &Evaluator, point: &[f64]) -> Evaluated {
    let built = evaluator.built();
    let mut scratch = EvaluatorScratch::default();
    let certified: Vec<Certified> = if point.len() == built.variables.len() {
        built.values(point, &mut scratch.values);
        evaluator.certified(&mut scratch).0
    } else {
        Vec::new()
    };
    let mut criteria = IndexMap::new();
    let mut details = IndexMap::new();
    for (name, known) in evaluator.names().zip(certified) {
        criteria.insert(name.to_owned(), known.value);
        details.insert(name.to_owned(), known.detail);
    }
    Evaluated {
        name: name.to_owned(),
        devices: built.devices(point),
        criteria,
        details,
    }
}

/// Feasible before infeasible; among the feasible by the objective, among the others by the violation; then by layout.
fn rank(found: &mut [Found], sense: Sense) {
    found.sort_by(|a, b| {
        let by_objective = match sense {
            Sense::Minimise => a.objective.total_cmp(&b.objective),
            Sense::Maximise => b.objective.total_cmp(&a.objective),
        };
        match (a.feasible, b.feasible) {
            (true, true) => by_objective,
            (true, false) => Ordering::Less,
            (false, true) => Ordering::Greater,
            (false, false) => a.violation.total_cmp(&b.violation).then(by_objective),
        }
        .then_with(|| a.candidate.label().cmp(&b.candidate.label()))
    });
}

fn improvements(
    design: &DesignTask,
    objective: f64,
    references: &[Evaluated],
) -> IndexMap<String, f64> {
    references
        .iter()
        .filter_map(|reference| {
            let value = *reference.criteria.get(&design.objective)?;
            let gain = match design.sense {
                Sense::Minimise => value - objective,
                Sense::Maximise => objective - value,
            };
            let relative = gain / value.abs();
            relative
                .is_finite()
                .then(|| (reference.name.clone(), relative))
        })
        .collect()
}

fn constraint_words(constraint: &Constraint) -> String {
    let symbol = match constraint.sense {
        Sense::Minimise => "≤",
        Sense::Maximise => "≥",
    };
    format!(
        "{} {symbol} {}",
        constraint.criterion,
        constraint.bound.expression()
    )
}
