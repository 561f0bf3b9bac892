//! What no task of a study reads is checked too: a run, a component or a criterion that is wrong should not wait for the
//! task that will use it.

use std::collections::HashSet;
use std::sync::Arc;

use quell_document::Fault;
use quell_expression::{Span, nearest};
use quell_network::{Domain, Kinds, Layout, expand};

use crate::built::{Built, Values, component_fault, range};
use crate::candidates::{Candidate, Candidates};
use crate::configuration;
use crate::evaluator::{Evaluator, prepare};
use crate::situation::Situation;
use crate::study::{DesignTask, Study, TaskKind};

/// Checks runs, components and criteria that no task has led to.
///
/// # Errors
/// What is wrong with the first of them, at its place.
pub(crate) fn check(study: &Study, situation: &Situation) -> Result<(), Fault> {
    for run in study.runs.values() {
        prepare(study, situation, run)?;
    }
    components(study, situation)?;
    criteria(study, situation)?;
    tolerances(study, situation)
}

/// Refuses a tolerance of a value that no layout of the study has.
fn tolerances(study: &Study, situation: &Situation) -> Result<(), Fault> {
    let named: Vec<(&str, Span)> = study
        .criteria
        .values()
        .filter_map(|criterion| criterion.variation.as_ref())
        .flat_map(|variation| &variation.tolerances)
        .filter_map(|tolerance| Some((tolerance.name.as_deref()?, tolerance.span)))
        .collect();
    if named.is_empty() {
        return Ok(());
    }
    let mut known: HashSet<String> = HashSet::new();
    let mut learn = |built: &Built| known.extend(built.value_keys().flatten().cloned());
    for task in &study.tasks {
        match &task.kind {
            TaskKind::Evaluate(configurations) => {
                for spec in configurations.values() {
                    learn(&configuration::built(study, situation, spec)?);
                }
            }
            TaskKind::Design(design) => {
                for candidate in Candidates::of(design).iter().take(TRIED) {
                    learn(&Built::new(
                        study,
                        situation,
                        &candidate,
                        Values::searched(design),
                    )?);
                }
            }
            TaskKind::Continuation(_) => {}
        }
    }
    for (name, span) in named {
        if known.contains(name) {
            continue;
        }
        let message = format!("no layout of this study has a value `{name}`");
        let fault = Fault::at(&study.source, span, message);
        let mut names: Vec<&str> = known.iter().map(String::as_str).collect();
        names.sort_unstable();
        return Err(match nearest(name, names) {
            Some(near) => fault.help(format!("did you mean `{near}`?")),
            None => fault.help("tolerances name values as `bounds` do: `{ k = \"5 %\" }`"),
        });
    }
    Ok(())
}

fn components(study: &Study, situation: &Situation) -> Result<(), Fault> {
    for (name, component) in &study.components {
        // A function's variables take their ranges from the task, not from the component that stands for it.
        if study.immittances.contains_key(name) {
            continue;
        }
        for (variable, bounds) in &component.variables {
            let lower = bounds.lower.quantity(&situation.parameters)?;
            range(
                format!("{name}.{variable}"),
                lower.dimension,
                bounds,
                &situation.parameters,
                &study.source,
            )?;
        }
        let own = study.kinds.of(component.domain).cloned();
        let kinds = own.unwrap_or_else(|| Kinds::new(component.domain));
        let Some(span) = component
            .values
            .values()
            .next()
            .map(crate::amount::Amount::span)
        else {
            continue;
        };
        let Ok(alone) = Layout::parse(&format!("{name}1"), &kinds) else {
            continue;
        };
        // Any piston will do: only the component's own values are looked at.
        let piston = (component.domain == Domain::Hydraulic).then_some(1.0);
        let components = situation.components(study)?;
        expand(&alone, &components, piston, &situation.parameters)
            .map_err(|error| component_fault(study, error, span))?;
    }
    Ok(())
}

fn criteria(study: &Study, situation: &Situation) -> Result<(), Fault> {
    let mut designs: Vec<&DesignTask> = Vec::new();
    let mut read: HashSet<&str> = HashSet::new();
    for task in &study.tasks {
        match &task.kind {
            // A configuration shows every criterion.
            TaskKind::Evaluate(_) => return Ok(()),
            TaskKind::Design(design) => {
                read.insert(&design.objective);
                read.extend(
                    design
                        .constraints
                        .iter()
                        .map(|constraint| constraint.criterion.as_str()),
                );
                designs.push(design);
            }
            TaskKind::Continuation(_) => {}
        }
    }
    for name in study.criteria.keys().map(String::as_str) {
        if read.contains(name) {
            continue;
        }
        // A criterion may speak of a part that only some layouts have: one where it makes sense is enough.
        let mut first_fault = None;
        let mut sound = false;
        for design in &designs {
            for candidate in Candidates::of(design).iter().take(TRIED) {
                match compiles(study, situation, design, &candidate, name) {
                    Ok(()) => {
                        sound = true;
                        break;
                    }
                    Err(fault) => {
                        first_fault.get_or_insert(fault);
                    }
                }
            }
            if sound {
                break;
            }
        }
        if let Some(fault) = first_fault.filter(|_| !sound) {
            return Err(fault);
        }
    }
    Ok(())
}

/// So many candidates of a task are tried for a criterion that the task does not read.
const TRIED: usize = 20;

fn compiles(
    study: &Study,
    situation: &Situation,
    design: &DesignTask,
    candidate: &Candidate,
    criterion: &str,
) -> Result<(), Fault> {
    let built = Built::new(study, situation, candidate, Values::searched(design))?;
    Evaluator::new(
        study,
        situation,
        Arc::new(built),
        Some(&[criterion]),
        &indexmap::IndexMap::new(),
    )
    .map(drop)
}
