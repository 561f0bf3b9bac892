//! From a task to its branches.

use std::collections::HashMap;
use std::sync::Arc;

use quell_continuation::{Interrupt, Keeper};
use quell_document::Fault;
use quell_expression::Dimension;

use super::ask::{BranchStart, ContinuationTask, Follows};
use super::follower::Follower;
use super::model::{Model, Wanted};
use super::report::Reporter;
use super::solved::{Member, Solved};
use super::watch::Watcher;
use crate::situation::Situation;
use crate::study::{ConfigurationSpec, Study};

/// Who looks on while a task is solved.
pub(crate) struct Company<'a> {
    /// Counts points.
    pub(crate) watcher: &'a Watcher,
    /// Keeps finished branches.
    pub(crate) keeper: &'a dyn Keeper,
    /// Asks to stop.
    pub(crate) interrupt: Option<Interrupt>,
}

/// Compiles the model of a task that starts afresh, without following anything.
///
/// # Errors
/// Whatever is wrong with it.
pub(super) fn model(
    study: &Study,
    situation: &Situation,
    task: &ContinuationTask,
    before: Option<&Solved>,
) -> Result<(Model, ConfigurationSpec, Vec<Wanted>), Fault> {
    let empty = || ConfigurationSpec {
        runs: indexmap::IndexMap::new(),
        layouts: indexmap::IndexMap::new(),
        values: indexmap::IndexMap::new(),
        span: task.span,
    };
    let spec = task
        .configuration
        .clone()
        .or_else(|| before.map(|before| before.spec.clone()))
        .unwrap_or_else(empty);
    let mut wanted = Wanted::of(task);
    if let Some(before) = before {
        for one in &mut wanted {
            if one.range.is_none() {
                let known = before.wanted.iter().find(|known| known.name == one.name);
                one.range = known.and_then(|known| known.range.clone());
            }
        }
        // What was free in the start keeps the value that it has there.
        for known in &before.wanted {
            if !wanted.iter().any(|one| one.name == known.name) {
                wanted.push(known.clone());
            }
        }
    }
    let model = Model::new(
        study,
        situation,
        &spec,
        &wanted,
        (&task.measures, &task.oscillations),
        task.period.as_ref(),
    )?;
    let rests = matches!(task.start, BranchStart::Equilibrium) && task.follows != Follows::Motions;
    if model.forced() && rests {
        return Err(Fault::at(
            &study.source,
            task.span,
            "the host is forced, so it has no equilibria to follow",
        )
        .help("start a `branch` at the motion on which a run in time settles: `start = { run = \"NAME\" }`"));
    }
    Ok((model, spec, wanted))
}

/// Settings of the engine for a task.
///
/// # Errors
/// Amounts of the task that do not fit.
pub(super) fn settings(
    situation: &Situation,
    task: &ContinuationTask,
    model: &Model,
    watcher: &Watcher,
) -> Result<quell_continuation::Settings, Fault> {
    let ranges: Vec<(f64, f64)> = model
        .axes()
        .iter()
        .take(task.parameters.len())
        .map(|axis| axis.range)
        .collect();
    let mut settings = quell_continuation::Settings::new(&ranges);
    settings.maximum_points = task.points;
    settings.mesh.tolerance = task.tolerance;
    settings.correction = task.correction;
    settings.monitors.push(watcher.monitor());
    if let Some(period) = &task.longest_period {
        let dimension = if situation.equations()?.dimensionless {
            Dimension::NONE
        } else {
            Dimension::TIME
        };
        settings.period_bound = period.value(&situation.parameters, dimension)?;
    }
    if let Some(axis) = model.axes().first() {
        for at in &task.at {
            settings
                .at
                .push(at.value(&situation.parameters, axis.dimension)?);
        }
    }
    Ok(settings)
}

/// Where a diagram looks for equilibria, by state.
///
/// # Errors
/// A state that the host does not have, or ends that do not fit.
pub(super) fn searched(
    study: &Study,
    situation: &Situation,
    task: &ContinuationTask,
    model: &Model,
) -> Result<HashMap<String, (f64, f64)>, Fault> {
    let known = model.beginnings();
    let mut found = HashMap::new();
    for (name, range) in &task.search {
        let fault = |message: String| Fault::at(&study.source, range.span, message);
        let Some((_, dimension)) = known.iter().find(|(known, _)| known == name) else {
            let fault = fault(format!(
                "the host has no coordinate, rate or state `{name}` in which equilibria could be sought"
            ));
            let names = known.iter().map(|(known, _)| known.as_str());
            return Err(match quell_expression::nearest(name, names) {
                Some(near) => fault.help(format!("did you mean `{near}`?")),
                None => fault,
            });
        };
        let from = range.from.value(&situation.parameters, *dimension)?;
        let to = range.to.value(&situation.parameters, *dimension)?;
        if !(from <= to && from.is_finite() && to.is_finite()) {
            return Err(
                fault(format!("the range of `{name}` is empty")).help("write the lower end first")
            );
        }
        found.insert(name.clone(), (from, to));
    }
    Ok(found)
}

/// Follows what a task asks for.
///
/// # Errors
/// What is wrong with the task; that nothing could be followed is a status of the findings.
pub(crate) fn solve(
    study: &Study,
    situation: &Situation,
    name: &str,
    task: &ContinuationTask,
    before: &[Arc<Solved>],
    company: &Company<'_>,
) -> Result<Solved, Fault> {
    let first = before.first().map(Arc::as_ref);
    let (model, spec, wanted) = self::model(study, situation, task, first)?;
    if task.follows == Follows::Motions {
        let findings =
            super::motions::followed(study, situation, name, task, &model, first, company)?;
        return Ok(Solved {
            model,
            spec,
            wanted,
            members: Vec::new(),
            findings,
        });
    }
    let mut settings = settings(situation, task, &model, company.watcher)?;
    settings.interrupt.clone_from(&company.interrupt);
    let (members, findings) = followed(
        study,
        situation,
        name,
        task,
        before,
        company,
        (&model, &spec, settings),
    )?;
    Ok(Solved {
        model,
        spec,
        wanted,
        members,
        findings,
    })
}

/// The branches of a task, with what is handed out.
fn followed(
    study: &Study,
    situation: &Situation,
    name: &str,
    task: &ContinuationTask,
    before: &[Arc<Solved>],
    company: &Company<'_>,
    (model, spec, settings): (&Model, &ConfigurationSpec, quell_continuation::Settings),
) -> Result<(Vec<Member>, super::ContinuationFindings), Fault> {
    if task.follows == Follows::Region {
        return Ok(super::region::followed(
            name,
            task,
            model,
            settings,
            company.watcher,
        ));
    }
    let field = model.field();
    let follower = Follower {
        task,
        model,
        field: &field,
        settings,
        keeper: company.keeper,
    };
    let (members, mut status, notes) = match &task.start {
        BranchStart::Label { .. } => {
            // Their labels are not yet those that they will be.
            if before
                .iter()
                .any(|before| before.findings.status == INTERRUPTED)
            {
                (Vec::new(), INTERRUPTED.to_owned(), Vec::new())
            } else {
                follower.at_labels(study, before)?
            }
        }
        BranchStart::Equilibrium if task.follows == Follows::Diagram => {
            follower.diagram(&searched(study, situation, task, model)?)
        }
        BranchStart::Equilibrium => follower.at_equilibrium(),
        BranchStart::Run { run, span } => {
            let samples = super::settled::samples(study, situation, spec, run, *span, model)?;
            follower.at_samples(&samples)
        }
    };
    let interrupted = |interrupt: &Interrupt| interrupt.is_raised();
    if company.interrupt.as_ref().is_some_and(interrupted) {
        INTERRUPTED.clone_into(&mut status);
    }
    company.watcher.measuring();
    let reporter = Reporter {
        name,
        task,
        model,
        field: &field,
    };
    let findings = reporter.findings(&members, status, notes);
    Ok((members, findings))
}

/// The status of a task that was asked to stop.
pub(super) const INTERRUPTED: &str = "interrupted";
/// Half the width of the box about the equilibrium of runs in time in which a diagram looks for others, SI.
pub(super) const SEARCHED: f64 = 1.0;
