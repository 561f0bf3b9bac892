//! What a task asks to be followed, from where it starts.

use std::collections::HashMap;
use std::sync::Arc;

use quell_continuation::{
    ContinuationError, CriticalEquilibrium, DiagramSettings, Equilibrium, Keeper, Kind, Orbit,
    Special, cycle_curve, cycles_across, cycles_doubled, cycles_from_hopf, cycles_from_orbit,
    cycles_from_pair, diagram_kept, equilibria, equilibria_across, fold_curve,
    fold_from_generalised_hopf, hopf_curve, torus_from_hopf_hopf,
};
use quell_document::Fault;
use quell_expression::Span;
use quell_model::system::StateKind;
use rayon::prelude::*;

use super::ask::{BranchStart, ContinuationTask, Follows};
use super::field::Field;
use super::model::Model;
use super::solve::SEARCHED;
use super::solved::{Begin, Member, Solutions, Solved};
use crate::study::Study;

/// Starts of Newton's method in that box, at each of three values of the parameter.
const STARTS: usize = 24;

pub(super) struct Follower<'a> {
    pub(super) task: &'a ContinuationTask,
    pub(super) model: &'a Model,
    pub(super) field: &'a Field<'a>,
    pub(super) settings: quell_continuation::Settings,
    pub(super) keeper: &'a dyn Keeper,
}

/// Branches, a status, and what could not be followed.
pub(super) type Followed = (Vec<Member>, String, Vec<String>);

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
    pub(super) fn at_equilibrium(&self) -> Followed {
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

    pub(super) fn at_samples(&self, samples: &super::settled::Settled) -> Followed {
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

    pub(super) fn diagram(&self, searched: &HashMap<String, (f64, f64)>) -> Followed {
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
        if found.mirrored {
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
    pub(super) fn at_labels(
        &self,
        study: &Study,
        before: &[Arc<Solved>],
    ) -> Result<Followed, Fault> {
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
        if let ([(first, ..), ..], [known, ..]) = (labels.as_slice(), before) {
            for ((task, _, span), other) in labels.iter().zip(before).skip(1) {
                if let Some(what) = self.differs(known, other) {
                    return Err(Fault::at(
                        &study.source,
                        *span,
                        format!("`{task}` and `{first}` are of different configurations: {what}"),
                    )
                    .help("curves of one plane are of one configuration: write a task for each, or make free what differs"));
                }
            }
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

    /// In what the configurations of two tasks differ, but for what this task makes free.
    fn differs(&self, one: &Solved, other: &Solved) -> Option<String> {
        let free = |name: &str| self.task.parameters.iter().any(|(known, _)| known == name);
        let (a, b) = (&one.findings.devices, &other.findings.devices);
        if a.len() != b.len() {
            return Some(format!("{} and {} devices", a.len(), b.len()));
        }
        a.iter().zip(b).find_map(|(a, b)| {
            if a.name != b.name || a.layout != b.layout {
                return Some(format!("`{}` is `{}` and `{}`", a.name, b.layout, a.layout));
            }
            let device = &a.name;
            let own = a.variables.iter().chain(&a.elements);
            let pairs = own.zip(b.variables.iter().chain(&b.elements));
            let differing = { pairs }.find(|(a, b)| {
                let differ = a.value.to_bits() != b.value.to_bits();
                differ && !free(&a.name) && !free(&format!("{device}.{}", a.name))
            });
            differing
                .map(|(a, b)| format!("`{}` is {} and {} {}", a.name, b.value, a.value, a.unit))
        })
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
