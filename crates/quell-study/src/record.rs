//! The record of a run: what goes from an outcome into `results.json`.

use indexmap::IndexMap;

use crate::outcome::{
    BuiltDevice, Design, Evaluated, Findings, FrontFindings, Reference, TaskOutcome,
};
use crate::results::{
    ConfigurationResult, DesignResult, DeviceResult, EngineFacts, FORMAT, LayoutFrontResult,
    ObjectiveResult, ReferenceResult, Results, SimplifiedResult, StudyFacts, SweepPoint, TaskBody,
    TaskFindings, TaskResult,
};
use crate::study::{Sense, Study};

/// The stable extract of what a run found.
pub(crate) fn of(
    study: &Study,
    seed: u64,
    threads: usize,
    wall_seconds: f64,
    evaluations: u64,
    tasks: &[TaskOutcome],
) -> Results {
    Results {
        format: FORMAT,
        study: StudyFacts {
            title: study.title.clone(),
            hash: study.hash.clone(),
        },
        engine: EngineFacts {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            seed,
            threads,
            wall_seconds,
            evaluations,
        },
        tasks: tasks
            .iter()
            .map(|task| (task.name.clone(), task_result(task)))
            .collect(),
    }
}

fn task_result(task: &TaskOutcome) -> TaskResult {
    let kind = match task.points.first().map(|point| &point.findings) {
        Some(Findings::Evaluate(_)) => "evaluate",
        Some(Findings::Continuation(found)) => found.follows.kind(),
        _ => "design",
    };
    let points: Vec<SweepPoint> = task
        .points
        .iter()
        .map(|point| {
            let (status, findings) = findings(&point.findings);
            SweepPoint {
                at: point
                    .at
                    .iter()
                    .map(|value| (value.name.clone(), value.value))
                    .collect(),
                status,
                findings,
            }
        })
        .collect();
    // What went wrong first, if anything did.
    let wrong = points.iter().find(|point| point.status != "done");
    let status = wrong.map_or_else(|| "done".to_owned(), |point| point.status.clone());
    let swept = points.iter().any(|point| !point.at.is_empty());
    let mut points = points.into_iter();
    let body = match points.next() {
        Some(only) if !swept => TaskBody::Single(only.findings),
        first => TaskBody::Sweep {
            points: first.into_iter().chain(points).collect(),
        },
    };
    TaskResult {
        kind,
        status,
        events: task.events.clone(),
        body,
    }
}

fn findings(found: &Findings) -> (String, TaskFindings) {
    match found {
        Findings::Continuation(found) => (
            found.status.clone(),
            TaskFindings::Continuation(crate::continuation::record(found, devices(&found.devices))),
        ),
        Findings::Evaluate(configurations) => {
            let configurations = configurations
                .iter()
                .map(|one| (one.name.clone(), configuration(one)))
                .collect();
            ("done".to_owned(), TaskFindings::Evaluate { configurations })
        }
        Findings::Design(design) => {
            let references = references(&design.references);
            let designs: Vec<DesignResult> = design.designs.iter().map(design_result).collect();
            let status = if designs.iter().any(|one| one.feasible) {
                "done"
            } else {
                "infeasible"
            };
            (
                status.to_owned(),
                TaskFindings::Design {
                    references,
                    designs,
                    simplified: design
                        .simplified
                        .iter()
                        .map(|one| SimplifiedResult {
                            elements: one.elements,
                            without: one.without.clone(),
                            tried: one.tried,
                            design: design_result(&one.design),
                        })
                        .collect(),
                },
            )
        }
        Findings::Front(front) => {
            let status = if front.common().is_empty() {
                "infeasible"
            } else {
                "done"
            };
            (status.to_owned(), front_result(front))
        }
    }
}

fn references(all: &[Reference]) -> IndexMap<String, ReferenceResult> {
    all.iter()
        .map(|one| {
            let result = ReferenceResult {
                configuration: configuration(&one.configuration),
                feasible: one.feasible,
                violation: one.violation,
            };
            (one.configuration.name.clone(), result)
        })
        .collect()
}

fn design_result(one: &Design) -> DesignResult {
    DesignResult {
        rank: one.rank,
        devices: devices(&one.configuration.devices),
        objective: one.objective,
        criteria: one.configuration.criteria.clone(),
        details: one.configuration.details.clone(),
        improvement: one.improvement.clone(),
        feasible: one.feasible,
        violation: one.violation,
        violations: one.violations.clone(),
        active_bounds: one.active_bounds.clone(),
        starts: one.starts,
        starts_agreeing: one.starts_agreeing,
        evaluations: one.evaluations,
        status: one.status.clone(),
        remarks: one.remarks.clone(),
        synthesis: one.synthesis.clone(),
    }
}

fn front_result(front: &FrontFindings) -> TaskFindings {
    TaskFindings::Front {
        objectives: front
            .objectives
            .iter()
            .map(|objective| ObjectiveResult {
                criterion: objective.criterion.clone(),
                sense: match objective.sense {
                    Sense::Minimise => "minimise",
                    Sense::Maximise => "maximise",
                },
            })
            .collect(),
        method: front.method.clone(),
        references: references(&front.references),
        fronts: front
            .layouts
            .iter()
            .map(|layout| LayoutFrontResult {
                layout: layout.layout.clone(),
                points: layout
                    .points
                    .iter()
                    .map(|point| design_result(&point.design))
                    .collect(),
            })
            .collect(),
    }
}

fn configuration(one: &Evaluated) -> ConfigurationResult {
    ConfigurationResult {
        devices: devices(&one.devices),
        criteria: one.criteria.clone(),
        details: one.details.clone(),
        energy: one.energy.clone(),
    }
}

fn devices(built: &[BuiltDevice]) -> IndexMap<String, DeviceResult> {
    built
        .iter()
        .map(|device| {
            let values = device
                .elements
                .iter()
                .chain(&device.variables)
                .map(|value| (value.name.clone(), value.value))
                .collect();
            let result = DeviceResult {
                layout: device.designed.clone(),
                device_layout: device.layout.to_string(),
                values,
            };
            (device.name.clone(), result)
        })
        .collect()
}
