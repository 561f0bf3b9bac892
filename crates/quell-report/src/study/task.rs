//! The section of one task.

use std::fmt::Write as _;

use quell_study::continuation::ContinuationFindings;
use quell_study::study::{DesignTask, Swept, Task, TaskKind as Asked};
use quell_study::{
    Design, Evaluated, Findings, NamedValue, PointOutcome, Reference, RunOutcome, Sense,
    TaskOutcome,
};

use super::front::front_words;
use super::pictures::response;
use super::{Bridge, shown_swept, shown_unit};
use crate::number::{compact, significant, unit};
use crate::page::{
    self, Configuration, CriterionColumn, CriterionValue, EnergyBars, EnergyPart, Parameter,
    Quantity, ReferenceRow, SweepPoint, TaskKind, TaskSection,
};

/// The function of the best design and its networks in words; none where it is no function.
fn synthesis_words(point: &PointOutcome) -> Vec<String> {
    let Findings::Design(findings) = &point.findings else {
        return Vec::new();
    };
    let Some(best) = findings.designs.first() else {
        return Vec::new();
    };
    let polynomial = |coefficients: &[f64]| {
        let terms: Vec<String> = coefficients
            .iter()
            .enumerate()
            .rev()
            .filter(|(_, value)| **value != 0.0)
            .map(|(power, value)| match power {
                0 => format!("{value:.4e}"),
                1 => format!("{value:.4e} s"),
                _ => format!("{value:.4e} s^{power}"),
            })
            .collect();
        terms.join(" + ")
    };
    let mut words = Vec::new();
    for synthesis in &best.synthesis {
        words.push(format!(
            "The best `{}` is the function `Y(s) = ({})/({})`, {}.",
            synthesis.device,
            polynomial(&synthesis.numerator),
            polynomial(&synthesis.denominator),
            synthesis.status
        ));
        for network in &synthesis.networks {
            let values: Vec<String> = network
                .values
                .iter()
                .map(|(name, value)| format!("{name} = {value:.4e}"))
                .collect();
            words.push(format!(
                "By {}: `{}` with `{}`.",
                network.method,
                network.network,
                values.join(", ")
            ));
        }
    }
    words
}

impl Bridge<'_> {
    pub(super) fn task(&self, task: &TaskOutcome, outcome: &RunOutcome) -> TaskSection {
        let asked = self
            .study
            .tasks
            .iter()
            .find(|known| known.name == task.name);
        let design = asked.and_then(|asked| match &asked.kind {
            Asked::Design(design) => Some(design.as_ref()),
            _ => None,
        });
        let criteria = self.columns(task, design);
        let swept = task.points.iter().any(|point| !point.at.is_empty());
        let mut section = TaskSection {
            name: task.name.clone(),
            kind: if design.is_some() {
                TaskKind::Design
            } else {
                TaskKind::Evaluate
            },
            words: words(task, design),
            status: outcome
                .results
                .tasks
                .get(&task.name)
                .map(|result| result.status.clone())
                .filter(|status| status != "done"),
            criteria,
            ..TaskSection::default()
        };
        if let Some(sweep) = asked.map(|asked| &asked.sweep).filter(|_| swept) {
            let axes: Vec<String> = sweep
                .iter()
                .map(|axis| {
                    let points = axis.values.count();
                    match axis.what {
                        Swept::Parameter | Swept::Value => {
                            format!("{points} values of `{}`", axis.name)
                        }
                        Swept::Bound => format!("{points} bounds of `{}`", axis.name),
                    }
                })
                .collect();
            section
                .words
                .push(format!("Swept over {}.", axes.join(" and ")));
        }
        section.words.extend(super::bands::words(task));
        let first = task.points.first();
        section.references = first.map_or(Vec::new(), |point| {
            self.references(point, design, &section.criteria)
        });
        if swept {
            section.sweep = task
                .points
                .iter()
                .map(|point| SweepPoint {
                    at: point
                        .at
                        .iter()
                        .map(|value| self.parameter(asked, value))
                        .collect(),
                    designs: self.designs(point, design, &section.criteria),
                    configurations: self.configurations(point, &section.criteria),
                })
                .collect();
            // References move with the swept parameter, so one row of numbers cannot stand for them.
            for reference in &mut section.references {
                reference.criteria.clear();
                reference.infeasible = false;
            }
            section.plots = self.swept_plots(asked, task);
            section.plots.extend(super::bands::plots(task));
        } else if let Some(point) = first {
            if let Findings::Continuation(found) = &point.findings {
                section.kind = super::branches::kind(found);
                section.words = super::branches::words(found);
                section.points = Some(super::branches::table(found));
                section.plots = match &found.motions {
                    Some(motions) => {
                        let of = motions.of.as_deref();
                        let of = of.and_then(|of| followed(outcome, of));
                        super::motions::plots(found, motions, of)
                    }
                    None => super::branches::plots(found),
                };
                return section;
            }
            section.designs = self.designs(point, design, &section.criteria);
            section.smaller = self.smaller(point, design, &section.criteria);
            section.words.extend(synthesis_words(point));
            section.configurations = self.configurations(point, &section.criteria);
            if let Findings::Front(front) = &point.findings {
                section.references = self.reference_rows(
                    &front.references,
                    &design.map_or(String::new(), |design| design.objective.clone()),
                    point,
                    design,
                    &section.criteria,
                );
                section.front = self.front(front, point, design, &section.criteria);
                section.plots = self.front_pictures(front);
                section.words.extend(front_words(front));
            } else {
                section.plots = point.plots.iter().map(response).collect();
            }
        }
        section
    }

    /// A swept value; a bound is shown in the unit of its criterion.
    fn parameter(&self, task: Option<&Task>, value: &NamedValue) -> Parameter {
        let (shown, unit) = shown_swept(self.study, task, value);
        Parameter {
            name: value.name.clone(),
            value: Quantity::new(shown, unit),
        }
    }

    /// The objective first, then constrained criteria, then the others.
    fn columns(&self, task: &TaskOutcome, design: Option<&DesignTask>) -> Vec<CriterionColumn> {
        let point = task.points.first();
        let one = point.and_then(|point| super::problem::evaluated(&point.findings).next());
        let Some(one) = one else {
            return Vec::new();
        };
        let constraints: &[String] = match point.map(|point| &point.findings) {
            Some(Findings::Design(findings)) => &findings.constraints,
            Some(Findings::Front(findings)) => &findings.constraints,
            _ => &[],
        };
        let mut columns: Vec<(usize, CriterionColumn)> = one
            .criteria
            .keys()
            .map(|name| {
                let detail = one.details.get(name);
                let si_unit = detail.map_or("", |detail| detail.unit.as_str());
                let mut roles: Vec<&str> = Vec::new();
                let objectives = design.map_or(Vec::new(), DesignTask::objectives);
                let among = objectives
                    .iter()
                    .position(|objective| objective.criterion == *name);
                if let Some(found) = among.and_then(|index| objectives.get(index)) {
                    roles.push(match found.sense {
                        Sense::Minimise => "minimised",
                        Sense::Maximise => "maximised",
                    });
                }
                let bounds = constraints.iter().filter_map(|text| {
                    text.strip_prefix(name.as_str())
                        .and_then(|rest| rest.strip_prefix(' '))
                });
                roles.extend(bounds);
                let place = match (among, roles.is_empty()) {
                    (Some(index), _) => index,
                    (None, false) => objectives.len(),
                    (None, true) => objectives.len() + 1,
                };
                let column = CriterionColumn {
                    name: name.clone(),
                    unit: shown_unit(self.study, name, si_unit).1.to_owned(),
                    role: roles.join(", "),
                };
                (place, column)
            })
            .collect();
        columns.sort_by_key(|(place, _)| *place);
        columns.into_iter().map(|(_, column)| column).collect()
    }

    fn references(
        &self,
        point: &PointOutcome,
        design: Option<&DesignTask>,
        columns: &[CriterionColumn],
    ) -> Vec<ReferenceRow> {
        let Findings::Design(findings) = &point.findings else {
            return Vec::new();
        };
        self.reference_rows(
            &findings.references,
            &findings.objective,
            point,
            design,
            columns,
        )
    }

    fn reference_rows(
        &self,
        references: &[Reference],
        objective: &str,
        point: &PointOutcome,
        design: Option<&DesignTask>,
        columns: &[CriterionColumn],
    ) -> Vec<ReferenceRow> {
        references
            .iter()
            .map(|reference| ReferenceRow {
                name: reference.configuration.name.clone(),
                words: reference_words(&reference.configuration),
                criteria: self.values(&reference.configuration, &point.at, design, columns),
                infeasible: reference.misses_a_constraint(objective),
            })
            .collect()
    }

    fn designs(
        &self,
        point: &PointOutcome,
        design: Option<&DesignTask>,
        columns: &[CriterionColumn],
    ) -> Vec<page::Design> {
        let Findings::Design(findings) = &point.findings else {
            return Vec::new();
        };
        findings
            .designs
            .iter()
            .map(|found| {
                let about = (findings.objective.as_str(), findings.references.as_slice());
                self.design(found, about, point, design, columns)
            })
            .collect()
    }

    fn smaller(
        &self,
        point: &PointOutcome,
        design: Option<&DesignTask>,
        columns: &[CriterionColumn],
    ) -> Vec<page::Design> {
        let Findings::Design(findings) = &point.findings else {
            return Vec::new();
        };
        findings
            .simplified
            .iter()
            .map(|one| {
                let about = (findings.objective.as_str(), findings.references.as_slice());
                page::Design {
                    rank: one.elements,
                    ..self.design(&one.design, about, point, design, columns)
                }
            })
            .collect()
    }

    pub(super) fn design(
        &self,
        found: &Design,
        (objective, references): (&str, &[Reference]),
        point: &PointOutcome,
        design: Option<&DesignTask>,
        columns: &[CriterionColumn],
    ) -> page::Design {
        let detail = found.configuration.details.get(objective);
        let si_unit = detail.map_or("", |detail| detail.unit.as_str());
        let (factor, shown) = shown_unit(self.study, objective, si_unit);
        let mut certificate: Vec<String> = detail.map(sureness).into_iter().collect();
        if found.status != "starts agree" && found.status != "one start" {
            certificate.push(found.status.clone());
        }
        page::Design {
            rank: found.rank,
            devices: self.devices(&found.configuration.devices, &found.active_bounds),
            objective: Quantity::new(found.objective / factor, shown),
            criteria: self.values(&found.configuration, &point.at, design, columns),
            improvements: references
                .iter()
                .map(|reference| {
                    found
                        .improvement
                        .get(&reference.configuration.name)
                        .map_or(f64::NAN, |gain| 100.0 * gain)
                })
                .collect(),
            starts: found.starts,
            starts_agreeing: found.starts_agreeing,
            evaluations: found.evaluations,
            feasible: found.feasible,
            violation: 100.0 * found.violation,
            certificate: certificate.join(" · "),
            remarks: found.remarks.clone(),
        }
    }

    fn configurations(
        &self,
        point: &PointOutcome,
        columns: &[CriterionColumn],
    ) -> Vec<Configuration> {
        let Findings::Evaluate(configurations) = &point.findings else {
            return Vec::new();
        };
        configurations
            .iter()
            .map(|one| Configuration {
                name: one.name.clone(),
                devices: self.devices(&one.devices, &[]),
                criteria: self.values(one, &point.at, None, columns),
                energy: energies(one),
            })
            .collect()
    }

    /// The criteria of a configuration, one for each column, in the units of the columns.
    fn values(
        &self,
        one: &Evaluated,
        at: &[NamedValue],
        design: Option<&DesignTask>,
        columns: &[CriterionColumn],
    ) -> Vec<CriterionValue> {
        columns
            .iter()
            .map(|column| {
                let value = one.criteria.get(&column.name).copied().unwrap_or(f64::NAN);
                let detail = one.details.get(&column.name);
                let mut note: Vec<String> = Vec::new();
                if let Some(at) = detail.and_then(|detail| detail.at_hz) {
                    note.push(format!("at {}\u{a0}Hz", significant(at, 4)));
                }
                if let Some(at) = detail.and_then(|detail| detail.at_s) {
                    note.push(format!("at {}\u{a0}s", significant(at, 4)));
                }
                note.extend(detail.and_then(|detail| detail.taken.clone()));
                if let Some(detail) = detail.filter(|_| !value.is_finite()) {
                    note.push(detail.status.clone());
                }
                CriterionValue {
                    value: value / shown_unit(self.study, &column.name, "").0,
                    note: note.join(", "),
                    violated: design
                        .is_some_and(|design| self.violates(design, &column.name, value, at)),
                }
            })
            .collect()
    }

    fn violates(&self, design: &DesignTask, name: &str, value: f64, at: &[NamedValue]) -> bool {
        let own = design
            .constraints
            .iter()
            .filter(|constraint| constraint.criterion == name);
        own.into_iter().any(|constraint| {
            // A bound may depend on what is swept.
            let Ok(standing) = self.study.standing(at) else {
                return false;
            };
            let swept = at.iter().find(|swept| swept.name == name);
            let bound = match swept {
                Some(swept) => swept.value,
                None => match constraint.bound.quantity(&standing.parameters) {
                    Ok(bound) => bound.value,
                    Err(_) => return false,
                },
            };
            let excess = constraint.sense.sign() * (value - bound);
            excess > design.feasibility * bound.abs()
        })
    }

    pub(super) fn at_words(&self, asked: Option<&Task>, at: &[NamedValue]) -> String {
        let words: Vec<String> = at
            .iter()
            .map(|value| {
                let (shown, shown_in) = shown_swept(self.study, asked, value);
                let number = compact(shown, 4);
                if shown_in.is_empty() {
                    format!("{} = {number}", value.name)
                } else {
                    format!("{} = {number} {}", value.name, unit(shown_in))
                }
            })
            .collect();
        words.join(", ")
    }
}

/// The task in words.
fn words(task: &TaskOutcome, design: Option<&DesignTask>) -> Vec<String> {
    let Some(design) = design else {
        return Vec::new();
    };
    let findings = task.points.first().and_then(|point| match &point.findings {
        Findings::Design(findings) => Some(findings.as_ref()),
        _ => None,
    });
    let verb = match design.sense {
        Sense::Minimise => "Smallest",
        Sense::Maximise => "Largest",
    };
    let mut sentence = format!("{verb} `{}`", design.objective);
    for objective in &design.further {
        let verb = match objective.sense {
            Sense::Minimise => "smallest",
            Sense::Maximise => "largest",
        };
        let _ = write!(sentence, " against {verb} `{}`", objective.criterion);
    }
    if let Some(findings) = findings {
        // Of one layout there is nothing to tell apart.
        let candidates = match findings.candidates.strip_prefix("1 layout,") {
            Some(_) => "1 layout",
            None => findings.candidates.as_str(),
        };
        let _ = write!(sentence, " of {candidates}");
        if !findings.constraints.is_empty() {
            let _ = write!(
                sentence,
                "; subject to `{}`",
                findings.constraints.join("`, `")
            );
        }
    }
    sentence.push('.');
    let mut words = vec![sentence];
    if !design.fixed.is_empty() {
        let fixed: Vec<String> = design
            .fixed
            .iter()
            .map(|(name, amount)| format!("`{name} = {}`", amount.expression()))
            .collect();
        words.push(format!("Not designed: {}.", fixed.join(", ")));
    }
    words
}

/// What a reference is, where its name does not say so.
fn reference_words(reference: &Evaluated) -> String {
    let layouts: Vec<&str> = reference
        .devices
        .iter()
        .map(|device| device.designed.as_str())
        .collect();
    let layouts = layouts.join("; ");
    if layouts == reference.name {
        "designed within the same bounds".to_owned()
    } else if layouts.is_empty() {
        "without any device".to_owned()
    } else {
        layouts
    }
}

/// How surely a value is known.
fn sureness(detail: &quell_study::results::CriterionDetail) -> String {
    match detail.achieved_tolerance {
        // What is left of exact arithmetic is no tolerance to speak of.
        Some(tolerance) if tolerance > 1e-12 => {
            format!("{} within {}", detail.status, significant(tolerance, 2))
        }
        _ => detail.status.clone(),
    }
}

/// Where the energy went in each run in time, for bars.
fn energies(one: &Evaluated) -> Vec<EnergyBars> {
    one.energy
        .iter()
        .map(|(run, ledger)| {
            let mut parts = vec![EnergyPart {
                name: "left in motion".to_owned(),
                kind: "host".to_owned(),
                energy: ledger.kinetic_end,
            }];
            parts.extend(ledger.elements.iter().map(|(name, element)| EnergyPart {
                name: name.clone(),
                kind: element.kind.to_owned(),
                energy: element.energy,
            }));
            let lost: f64 = ledger.ports.values().map(|port| port.mismatch).sum();
            if lost.abs() > 1e-6 * ledger.kinetic_start.abs() {
                parts.push(EnergyPart {
                    name: "mismatch of the port's convention".to_owned(),
                    kind: "other".to_owned(),
                    energy: lost,
                });
            }
            parts.push(EnergyPart {
                name: "taken by the host's own forces".to_owned(),
                kind: "host".to_owned(),
                energy: -ledger.host,
            });
            EnergyBars {
                run: run.clone(),
                start: ledger.kinetic_start,
                parts,
                error: ledger.error,
            }
        })
        .collect()
}

/// What another task of the run followed.
fn followed<'o>(outcome: &'o RunOutcome, name: &str) -> Option<&'o ContinuationFindings> {
    let task = outcome.tasks.iter().find(|task| task.name == name)?;
    match &task.points.first()?.findings {
        Findings::Continuation(found) => Some(found),
        _ => None,
    }
}
