//! From a task to its branches.

use std::collections::HashMap;
use std::sync::Arc;

use quell_continuation::{
    Branch, ContinuationError, CriticalEquilibrium, CriticalOrbit, DiagramSettings, Equilibrium,
    Interrupt, Keeper, Kind, Orbit, Special, cycle_curve, cycles_across, cycles_doubled,
    cycles_from_hopf, cycles_from_orbit, cycles_from_pair, diagram_kept, equilibria,
    equilibria_across, fold_curve, fold_from_generalised_hopf, hopf_curve, torus_from_hopf_hopf,
};
use quell_document::Fault;
use quell_expression::{Dimension, Span};
use quell_model::system::StateKind;
use rayon::prelude::*;

use super::ask::{BranchStart, ContinuationTask, Follows};
use super::field::Field;
use super::model::{Model, Wanted};
use super::report::Reporter;
use super::watch::Watcher;
use crate::situation::Situation;
use crate::study::{ConfigurationSpec, Study};

/// A branch with its solutions, from which others may start.
pub(super) enum Solutions {
    Equilibria(Branch<Equilibrium>),
    Cycles(Branch<Orbit>),
    /// Of folds or Hopf points.
    CriticalEquilibria(Branch<CriticalEquilibrium>, Kind),
    /// Of special cycles.
    CriticalOrbits(Branch<CriticalOrbit>, Kind),
}

/// A branch of a task.
pub(super) struct Member {
    pub(super) id: String,
    pub(super) parent: Option<String>,
    pub(super) solutions: Solutions,
}

/// A task that has been solved.
pub(crate) struct Solved {
    pub(super) model: Model,
    spec: ConfigurationSpec,
    wanted: Vec<Wanted>,
    members: Vec<Member>,
    /// What was found.
    pub(crate) findings: super::ContinuationFindings,
}

/// A labelled point to start from.
enum Begin<'a> {
    Equilibrium(&'a Special<Equilibrium>),
    Cycle(&'a Special<Orbit>),
    CriticalEquilibrium(&'a Special<CriticalEquilibrium>),
    CriticalOrbit(&'a Special<CriticalOrbit>),
}

/// Who looks on while a task is solved.
pub(crate) struct Company<'a> {
    /// Counts points.
    pub(crate) watcher: &'a Watcher,
    /// Keeps finished branches.
    pub(crate) keeper: &'a dyn Keeper,
    /// Asks to stop.
    pub(crate) interrupt: Option<Interrupt>,
}

impl Solved {
    /// The number of solutions.
    pub(crate) fn solutions(&self) -> u64 {
        let points = self.findings.branches.iter();
        points.map(|branch| branch.points.len() as u64).sum()
    }

    /// The point of a label, `H1` or `E1:H1`.
    fn labelled(&self, label: &str) -> Result<(String, Begin<'_>), String> {
        let (branch, short) = match label.rsplit_once(':') {
            Some((branch, short)) => (Some(branch), short),
            None => (None, label),
        };
        let mut found = Vec::new();
        let mut known = Vec::new();
        for member in &self.members {
            let begins: Vec<(&str, Begin<'_>)> = match &member.solutions {
                Solutions::Equilibria(own) => own
                    .special
                    .iter()
                    .map(|one| (one.label.as_str(), Begin::Equilibrium(one)))
                    .collect(),
                Solutions::Cycles(own) => own
                    .special
                    .iter()
                    .map(|one| (one.label.as_str(), Begin::Cycle(one)))
                    .collect(),
                Solutions::CriticalEquilibria(own, _) => own
                    .special
                    .iter()
                    .map(|one| (one.label.as_str(), Begin::CriticalEquilibrium(one)))
                    .collect(),
                Solutions::CriticalOrbits(own, _) => own
                    .special
                    .iter()
                    .map(|one| (one.label.as_str(), Begin::CriticalOrbit(one)))
                    .collect(),
            };
            for (own, begin) in begins {
                let full = format!("{}:{own}", member.id);
                if own == short && branch.is_none_or(|branch| branch == member.id) {
                    found.push((full.clone(), begin));
                }
                known.push(full);
            }
        }
        match (found.len(), found.pop()) {
            (1, Some(only)) => Ok(only),
            (0, _) if known.is_empty() => Err("it found no special point".to_owned()),
            (0, _) => Err(format!("its points are {}", known.join(", "))),
            (_, Some(last)) => {
                let all: Vec<String> = found.into_iter().map(|(full, _)| full).collect();
                Err(format!(
                    "several branches have it: write {} or {}",
                    all.join(", "),
                    last.0
                ))
            }
            (_, None) => Err(String::new()),
        }
    }

    /// Values of another model's free parameters at a solution of this one.
    fn lifted(&self, at: &[f64], model: &Model) -> Vec<f64> {
        model
            .axes()
            .iter()
            .map(|axis| {
                let own = self
                    .model
                    .axes()
                    .iter()
                    .position(|known| known.name == axis.name);
                own.and_then(|index| at.get(index))
                    .copied()
                    .unwrap_or(axis.base)
            })
            .collect()
    }
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
    if model.forced() && matches!(task.start, BranchStart::Equilibrium) {
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

struct Follower<'a> {
    task: &'a ContinuationTask,
    model: &'a Model,
    field: &'a Field<'a>,
    settings: quell_continuation::Settings,
    keeper: &'a dyn Keeper,
}

/// Branches, a status, and what could not be followed.
type Followed = (Vec<Member>, String, Vec<String>);

fn done(members: Vec<Member>) -> Followed {
    (members, "done".to_owned(), Vec::new())
}

fn failed(error: &ContinuationError) -> Followed {
    (Vec::new(), error.to_string(), Vec::new())
}

/// The only branch that was followed, or why not.
fn single(id: &str, parent: Option<&str>, found: Result<Solutions, ContinuationError>) -> Followed {
    match found {
        Ok(solutions) => done(vec![Member {
            id: id.to_owned(),
            parent: parent.map(str::to_owned),
            solutions,
        }]),
        Err(error) => failed(&error),
    }
}

impl Follower<'_> {
    fn at_equilibrium(&self) -> Followed {
        let base = self.model.base();
        let state = match self.model.equilibrium(&base) {
            Ok(state) => state,
            Err(why) => return (Vec::new(), why, Vec::new()),
        };
        let followed = self.keeper.branch("E1", || {
            equilibria(self.field, &state, &base, 0, &self.settings)
        });
        let branch = match followed {
            Ok(branch) => branch,
            Err(error) => return failed(&error),
        };
        let mut members = Vec::new();
        let mut notes = Vec::new();
        if self.task.cycles {
            let births: Vec<&Special<Equilibrium>> = branch
                .special
                .iter()
                .filter(|one| matches!(one.kind, Kind::Hopf | Kind::HopfHopf))
                .collect();
            let found: Vec<_> = births
                .par_iter()
                .map(|point| {
                    self.keeper
                        .branch(&format!("cycles from {}", point.label), || {
                            cycles_from_hopf(self.field, point, 0, &self.settings)
                        })
                })
                .collect();
            for (point, found) in births.iter().zip(found) {
                match found {
                    Ok(own) => members.push(Member {
                        id: format!("C{}", members.len() + 1),
                        parent: Some(format!("E1:{}", point.label)),
                        solutions: Solutions::Cycles(own),
                    }),
                    Err(error) => notes.push(format!("cycles at {}: {error}", point.label)),
                }
            }
        }
        members.insert(
            0,
            Member {
                id: "E1".to_owned(),
                parent: None,
                solutions: Solutions::Equilibria(branch),
            },
        );
        (members, "done".to_owned(), notes)
    }

    fn at_samples(&self, samples: &super::settled::Settled) -> Followed {
        let base = self.model.base();
        let found = self.keeper.branch("C1", || {
            quell_continuation::cycles_from_samples(
                self.field,
                &samples.samples(),
                &base,
                0,
                &self.settings,
            )
        });
        single("C1", None, found.map(Solutions::Cycles))
    }

    fn diagram(&self, searched: &HashMap<String, (f64, f64)>) -> Followed {
        let base = self.model.base();
        let Ok(middle) = self.model.equilibrium(&base) else {
            return (
                Vec::new(),
                "no equilibrium was found to start from".to_owned(),
                Vec::new(),
            );
        };
        let states = self
            .model
            .system()
            .states()
            .iter()
            .zip(&middle)
            .map(
                |(state, value)| match (searched.get(&state.name), state.kind) {
                    (Some(range), _) => *range,
                    (None, StateKind::Rate) => (*value, *value),
                    (None, _) => (value - SEARCHED, value + SEARCHED),
                },
            )
            .collect();
        let asked = DiagramSettings {
            branch: self.settings.clone(),
            states,
            starts: STARTS,
            depth: self.task.depth,
        };
        let found = match diagram_kept(self.field, &base, 0, &asked, self.keeper) {
            Ok(found) => found,
            Err(error) => return failed(&error),
        };
        let parent = |parent: Option<(String, String)>| {
            parent.map(|(branch, label)| format!("{branch}:{label}"))
        };
        let mut members = Vec::new();
        for member in found.equilibria {
            members.push(Member {
                id: member.name,
                parent: parent(member.parent),
                solutions: Solutions::Equilibria(member.branch),
            });
        }
        for member in found.cycles {
            members.push(Member {
                id: member.name,
                parent: parent(member.parent),
                solutions: Solutions::Cycles(member.branch),
            });
        }
        let mut notes: Vec<String> = found
            .failed
            .iter()
            .map(|(branch, label, error)| {
                if branch.is_empty() {
                    format!("from an equilibrium at {label}: {error}")
                } else {
                    format!("from {branch}:{label}: {error}")
                }
            })
            .collect();
        if found.odd {
            notes.push(
                "the equations are the same for the mirrored motion: of mirror images one is shown"
                    .to_owned(),
            );
        }
        let status = if members.is_empty() {
            "no equilibrium was found".to_owned()
        } else {
            "done".to_owned()
        };
        (members, status, notes)
    }

    /// From the labelled points of other tasks, one after the other.
    fn at_labels(&self, study: &Study, before: &[Arc<Solved>]) -> Result<Followed, Fault> {
        let starts = std::iter::once(&self.task.start).chain(&self.task.more);
        let labels: Vec<(&str, &str, Span)> = starts
            .filter_map(|start| match start {
                BranchStart::Label { task, label, span } => Some((&**task, &**label, *span)),
                _ => None,
            })
            .collect();
        if labels.len() != before.len() {
            return Err(Fault::at(
                &study.source,
                self.task.span,
                "a task to start from has found nothing",
            ));
        }
        let all: Vec<Result<Followed, Fault>> = labels
            .par_iter()
            .zip(before)
            .map(|((task, label, span), before)| {
                let (parent, begin) = before.labelled(label).map_err(|why| {
                    Fault::at(
                        &study.source,
                        *span,
                        format!("the task `{task}` has no point `{label}` to start from"),
                    )
                    .help(why)
                })?;
                self.at_point(before, &begin, &format!("{task}:{parent}"))
                    .map_err(|why| Fault::at(&study.source, *span, why))
            })
            .collect();
        let single = all.len() == 1;
        let (mut members, mut status, mut notes) =
            (Vec::<Member>::new(), "done".to_owned(), Vec::new());
        for (found, (task, label, _)) in all.into_iter().zip(&labels) {
            let (own, how, why) = found?;
            for mut member in own {
                if !single {
                    // Curves are numbered through.
                    member.id = format!("K{}", members.len() + 1);
                }
                members.push(member);
            }
            if how != "done" && single {
                status = how;
            } else if how != "done" {
                notes.push(format!("from {task}:{label}: {how}"));
            }
            notes.extend(why);
        }
        if members.is_empty() && status == "done" {
            "no curve was found".clone_into(&mut status);
        }
        Ok((members, status, notes))
    }

    /// From a labelled point of another task; else what is wrong with it as a start.
    fn at_point(
        &self,
        before: &Solved,
        begin: &Begin<'_>,
        parent: &str,
    ) -> Result<Followed, String> {
        if self.task.follows == Follows::Curve {
            return self.curve(before, begin, parent);
        }
        let same = before.model.axes().first().map(|axis| &axis.name)
            == self.model.axes().first().map(|axis| &axis.name);
        let settings = &self.settings;
        let (field, keeper) = (self.field, self.keeper);
        let named = |id: &str| format!("{id} from {parent}");
        Ok(match begin {
            Begin::Equilibrium(point) => {
                let at = moved(point, |e| Equilibrium {
                    state: e.state.clone(),
                    parameters: before.lifted(&e.parameters, self.model),
                });
                match point.kind {
                    Kind::Hopf | Kind::HopfHopf => single(
                        "C1",
                        Some(parent),
                        keeper
                            .branch(&named("C1"), || cycles_from_hopf(field, &at, 0, settings))
                            .map(Solutions::Cycles),
                    ),
                    Kind::BranchPoint if same => single(
                        "E1",
                        Some(parent),
                        keeper
                            .branch(&named("E1"), || {
                                equilibria_across(field, &at, 0, 1.0, settings)
                            })
                            .map(Solutions::Equilibria),
                    ),
                    _ => single(
                        "E1",
                        Some(parent),
                        keeper
                            .branch(&named("E1"), || {
                                equilibria(
                                    field,
                                    &at.solution.state,
                                    &at.solution.parameters,
                                    0,
                                    settings,
                                )
                            })
                            .map(Solutions::Equilibria),
                    ),
                }
            }
            Begin::Cycle(point) => {
                let at = moved(point, |orbit| Orbit {
                    parameters: before.lifted(&orbit.parameters, self.model),
                    ..orbit.clone()
                });
                let found = keeper.branch(&named("C1"), || match point.kind {
                    Kind::PeriodDoubling => cycles_doubled(field, &at, 0, settings),
                    Kind::CycleBranchPoint if same => cycles_across(field, &at, 0, 1.0, settings),
                    _ => cycles_from_orbit(field, &at.solution, 0, settings),
                });
                single("C1", Some(parent), found.map(Solutions::Cycles))
            }
            Begin::CriticalEquilibrium(point) => {
                let e = &point.solution.equilibrium;
                let at = Equilibrium {
                    state: e.state.clone(),
                    parameters: before.lifted(&e.parameters, self.model),
                };
                let mut members = Vec::new();
                let mut notes = Vec::new();
                let pairs: Vec<f64> = point.omega.into_iter().chain(point.second_omega).collect();
                for omega in pairs.into_iter().filter(|omega| *omega > 0.0) {
                    let followed = keeper.branch(&named(&format!("cycles of {omega:?}")), || {
                        cycles_from_pair(field, &at, omega, 0, settings)
                    });
                    match followed {
                        Ok(own) => members.push(Member {
                            id: format!("C{}", members.len() + 1),
                            parent: Some(parent.to_owned()),
                            solutions: Solutions::Cycles(own),
                        }),
                        Err(error) => notes.push(format!("cycles of {omega} rad/s: {error}")),
                    }
                }
                if members.is_empty() {
                    single(
                        "E1",
                        Some(parent),
                        keeper
                            .branch(&named("E1"), || {
                                equilibria(field, &at.state, &at.parameters, 0, settings)
                            })
                            .map(Solutions::Equilibria),
                    )
                } else {
                    (members, "done".to_owned(), notes)
                }
            }
            Begin::CriticalOrbit(point) => {
                let orbit = Orbit {
                    parameters: before.lifted(&point.solution.orbit.parameters, self.model),
                    ..point.solution.orbit.clone()
                };
                single(
                    "C1",
                    Some(parent),
                    keeper
                        .branch(&named("C1"), || {
                            cycles_from_orbit(field, &orbit, 0, settings)
                        })
                        .map(Solutions::Cycles),
                )
            }
        })
    }

    fn curve(&self, before: &Solved, begin: &Begin<'_>, parent: &str) -> Result<Followed, String> {
        let settings = &self.settings;
        let (field, keeper) = (self.field, self.keeper);
        let named = |id: &str| format!("{id} from {parent}");
        let free = [0, 1];
        let no_curve = |kind: Kind| {
            format!(
                "no curve starts at a point of kind {kind}: curves start at LP, H, LPC, PD and NS points of branches, and at HH and GH points of curves"
            )
        };
        match begin {
            Begin::Equilibrium(point) => {
                let at = moved(point, |e| Equilibrium {
                    state: e.state.clone(),
                    parameters: before.lifted(&e.parameters, self.model),
                });
                let (found, kind) = match point.kind {
                    Kind::Hopf | Kind::HopfHopf => (
                        keeper.branch(&named("K1"), || hopf_curve(field, &at, free, settings)),
                        Kind::Hopf,
                    ),
                    Kind::Fold => (
                        keeper.branch(&named("K1"), || {
                            fold_curve(field, &at.solution, free, settings)
                        }),
                        Kind::Fold,
                    ),
                    other => return Err(no_curve(other)),
                };
                Ok(single(
                    "K1",
                    Some(parent),
                    found.map(|own| Solutions::CriticalEquilibria(own, kind)),
                ))
            }
            Begin::Cycle(point) => {
                if !matches!(
                    point.kind,
                    Kind::CycleFold | Kind::PeriodDoubling | Kind::Torus
                ) {
                    return Err(no_curve(point.kind));
                }
                let at = moved(point, |orbit| Orbit {
                    parameters: before.lifted(&orbit.parameters, self.model),
                    ..orbit.clone()
                });
                let found = keeper.branch(&named("K1"), || cycle_curve(field, &at, free, settings));
                Ok(single(
                    "K1",
                    Some(parent),
                    found.map(|own| Solutions::CriticalOrbits(own, point.kind)),
                ))
            }
            Begin::CriticalEquilibrium(point) => {
                let at = CriticalEquilibrium {
                    equilibrium: Equilibrium {
                        state: point.solution.equilibrium.state.clone(),
                        parameters: before
                            .lifted(&point.solution.equilibrium.parameters, self.model),
                    },
                    omega: point.solution.omega,
                };
                match (point.kind, point.omega, point.second_omega) {
                    (Kind::HopfHopf, Some(first), Some(second)) => {
                        let mut members = Vec::new();
                        let mut notes = Vec::new();
                        for (omega, other) in [(first, second), (second, first)] {
                            let name = named(&format!("torus points of {omega:?}"));
                            let followed = keeper.branch(&name, || {
                                torus_from_hopf_hopf(field, &at, omega, other, free, settings)
                            });
                            match followed {
                                Ok(own) => members.push(Member {
                                    id: format!("K{}", members.len() + 1),
                                    parent: Some(parent.to_owned()),
                                    solutions: Solutions::CriticalOrbits(own, Kind::Torus),
                                }),
                                Err(error) => {
                                    notes.push(format!("torus points of {omega} rad/s: {error}"));
                                }
                            }
                        }
                        let status = if members.is_empty() {
                            "no torus curve was found".to_owned()
                        } else {
                            "done".to_owned()
                        };
                        Ok((members, status, notes))
                    }
                    (Kind::GeneralisedHopf, ..) => {
                        let found = keeper.branch(&named("K1"), || {
                            fold_from_generalised_hopf(field, &at, free, settings)
                        });
                        Ok(single(
                            "K1",
                            Some(parent),
                            found.map(|own| Solutions::CriticalOrbits(own, Kind::CycleFold)),
                        ))
                    }
                    (other, ..) => Err(no_curve(other)),
                }
            }
            Begin::CriticalOrbit(point) => Err(no_curve(point.kind)),
        }
    }
}

/// The status of a task that was asked to stop.
pub(super) const INTERRUPTED: &str = "interrupted";
/// Half the width of the box about the equilibrium of runs in time in which a diagram looks for others, SI.
pub(super) const SEARCHED: f64 = 1.0;
/// Starts of Newton's method in that box, at each of three values of the parameter.
const STARTS: usize = 24;

/// A special point with its solution changed.
fn moved<S, T>(point: &Special<S>, change: impl FnOnce(&S) -> T) -> Special<T> {
    Special {
        label: point.label.clone(),
        kind: point.kind,
        certainty: point.certainty,
        solution: change(&point.solution),
        tangent: point.tangent.clone(),
        omega: point.omega,
        second_omega: point.second_omega,
        normal_form: point.normal_form.clone(),
        unstable: point.unstable,
        spectrum: point.spectrum.clone(),
        error: point.error,
        after: point.after,
    }
}
