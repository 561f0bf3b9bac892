//! Checking a study: everything that can be wrong with it, without computing.

use std::collections::HashSet;
use std::fmt::Write as _;

use quell_document::Fault;

use crate::candidates::Candidates;
use crate::configuration::configuration;
use crate::problem::DesignProblem;
use crate::reference::Reference;
use crate::situation::{self, Situation};
use crate::study::{DesignTask, Study, TaskKind};
use crate::sweep::sweep_points;
use crate::unread;

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
        crate::standing::size(
            standing.host.coordinates.len(),
            standing.equations().map_or(0, |host| host.states.len())
        ),
        counted(standing.host.inputs.len(), "input"),
        counted(standing.host.ports.len(), "port"),
    ));
    for task in &study.tasks {
        let points = sweep_points(study, task)?;
        let mut line = String::new();
        for at in &points {
            let situation = situation::build(&study.host, &study.overrides, &at.parameters())?;
            line = match &task.kind {
                TaskKind::Evaluate(configurations) => {
                    for spec in at.configurations(configurations).values() {
                        configuration(study, &situation, spec)?;
                    }
                    format!(
                        "evaluates {}",
                        counted(configurations.len(), "configuration")
                    )
                }
                TaskKind::Design(design) => check_design(study, &situation, &at.design(design))?,
                TaskKind::Continuation(task) => {
                    crate::continuation::check(study, &situation, task)?
                }
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
    let mut used = HashSet::new();
    let (mut fewest, mut most) = (usize::MAX, 0);
    for candidate in candidates.iter().take(CHECKED) {
        let problem = DesignProblem::of(study, situation, design, &candidate)?;
        for objective in &design.further {
            let task = design.bounded(objective, &[]);
            DesignProblem::of(study, situation, &task, &candidate)?;
        }
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
        match Reference::of(study, design, name, *span)? {
            Reference::Configuration(spec) => configuration(study, situation, spec).map(drop)?,
            Reference::Layout(candidate) => {
                DesignProblem::of(study, situation, design, &candidate).map(drop)?;
            }
        }
    }
    let variables = if fewest == most {
        counted(most, "variable")
    } else {
        format!("{fewest} to {most} variables")
    };
    let plural = if candidates.count() == 1 { "" } else { "s" };
    let objectives: Vec<String> = design
        .objectives()
        .into_iter()
        .map(|objective| objective.criterion)
        .collect();
    let front = if objectives.len() > 1 {
        "the front of "
    } else {
        ""
    };
    Ok(format!(
        "designs {} layout{plural} of {variables} for {front}{}",
        candidates.count(),
        objectives.join(" and ")
    ))
}
