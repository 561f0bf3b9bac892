//! A design task: its references, its candidates one after the other, and their ranking.

use std::cmp::Ordering;
use std::sync::atomic::Ordering as Memory;
use std::sync::{Mutex, PoisonError};

use indexmap::IndexMap;
use quell_document::Fault;
use rayon::prelude::*;

use super::candidate::Found;
use super::{RunError, Runner, synthesis};
use crate::candidates::{Candidate, Candidates};
use crate::configuration::{configuration, evaluated};
use crate::outcome::{self, Design, DesignFindings, Evaluated, Findings, Plot, Role, Simplified};
use crate::plots::Curves;
use crate::problem::{DesignProblem, Verdict, constraints};
use crate::reference::Reference;
use crate::situation::Situation;
use crate::study::{Constraint, DesignTask, Sense};

/// Candidates that are searched as one batch, so that an enumeration is never held in memory as a whole.
pub(super) const BATCH: usize = 4096;

impl Runner<'_> {
    pub(super) fn design(
        &self,
        situation: &Situation,
        design: &DesignTask,
    ) -> Result<(Findings, Vec<Plot>), RunError> {
        let mut curves = Curves::only(&design.objective);
        let references = self.references(situation, design, &mut curves)?;
        let candidates = Candidates::of(design);
        let mut found: Vec<Found> = Vec::new();
        let best = Mutex::new(String::new());
        let mut iterator = candidates.iter();
        loop {
            let batch: Vec<Candidate> = iterator.by_ref().take(BATCH).collect();
            if batch.is_empty() {
                break;
            }
            let results: Vec<Result<Found, Fault>> = batch
                .into_par_iter()
                .with_max_len(1)
                .map(|candidate| {
                    let found = self.candidate(situation, design, candidate);
                    self.recorder
                        .advance(&self.best_so_far(design, &found, &best));
                    found
                })
                .collect();
            for result in results {
                found.push(result?);
            }
        }
        rank(&mut found, design.sense);
        let mut designs: Vec<Design> = found
            .iter()
            .enumerate()
            .map(|(index, found)| described(found, index + 1, design, &references))
            .collect();
        if !self.study.immittances.is_empty() {
            for (described, found) in designs.iter_mut().zip(&found) {
                described.synthesis = synthesis::of(self.study, found);
            }
        }
        let mut simplified = Vec::new();
        if design.simplify
            && let (Some(best), Some(described_best)) = (found.first(), designs.first())
        {
            let smaller = self.simplify(situation, design, best, &described_best.synthesis)?;
            simplified.extend(smaller.into_iter().map(|one| Simplified {
                elements: one.elements,
                without: one.without,
                tried: one.tried,
                design: described(&one.found, 1, design, &references),
            }));
        }
        for (index, found) in found.iter().enumerate().take(self.study.report.shortlist) {
            let problem = DesignProblem::of(self.study, situation, design, &found.candidate)?;
            let role = Role::Design(index + 1);
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
            simplified,
            candidates: candidates.words(),
        };
        Ok((Findings::Design(Box::new(findings)), curves.finish()))
    }

    pub(super) fn references(
        &self,
        situation: &Situation,
        design: &DesignTask,
        curves: &mut Curves,
    ) -> Result<Vec<outcome::Reference>, RunError> {
        let mut references = Vec::new();
        for (name, span) in &design.references {
            let role = Role::Reference;
            let (configuration, verdict) = match Reference::of(self.study, design, name, *span)? {
                Reference::Configuration(spec) => {
                    let evaluator = configuration(self.study, situation, spec)?;
                    self.evaluations.fetch_add(1, Memory::Relaxed);
                    curves.add(self.study, &evaluator, &[], name, role);
                    let evaluated = evaluated(name, &evaluator, &[]);
                    let bounds = constraints(design, situation, &evaluator)?;
                    let verdict = Verdict::on(&evaluated, design, &bounds);
                    (evaluated, verdict)
                }
                Reference::Layout(candidate) => {
                    let found = self.candidate(situation, design, candidate)?;
                    let problem =
                        DesignProblem::of(self.study, situation, design, &found.candidate)?;
                    curves.add(self.study, &problem.evaluator, &found.point, name, role);
                    let evaluated = Evaluated {
                        name: name.clone(),
                        ..found.evaluated
                    };
                    (evaluated, found.verdict)
                }
            };
            references.push(outcome::Reference {
                configuration,
                feasible: verdict.feasible,
                violation: verdict.violation,
            });
        }
        Ok(references)
    }

    /// The best so far in words, for a progress bar.
    fn best_so_far(
        &self,
        design: &DesignTask,
        found: &Result<Found, Fault>,
        best: &Mutex<String>,
    ) -> String {
        let mut best = best.lock().unwrap_or_else(PoisonError::into_inner);
        if let Ok(found) = found
            && found.verdict.feasible
        {
            let unit = self
                .study
                .criteria
                .get(&design.objective)
                .and_then(|criterion| criterion.unit.as_ref());
            let factor = unit.map_or(1.0, |(unit, _)| unit.factor);
            let text = unit.map_or("", |(unit, _)| unit.text.as_str());
            let value = found.verdict.objective / factor;
            let before = best
                .split(' ')
                .next()
                .and_then(|number| number.parse::<f64>().ok());
            let sign = design.sense.sign();
            if before.is_none_or(|before| sign * value < sign * before) {
                *best = format!("{value:.5} {text} {}", found.candidate.label());
            }
        }
        best.clone()
    }
}

/// A design of a rank, compared with references.
fn described(
    found: &Found,
    rank: usize,
    design: &DesignTask,
    references: &[outcome::Reference],
) -> Design {
    Design {
        improvement: improvements(design, found.verdict.objective, references),
        ..designed(found, rank)
    }
}

/// A design of a rank, not yet compared with references.
pub(super) fn designed(found: &Found, rank: usize) -> Design {
    Design {
        rank,
        configuration: found.evaluated.clone(),
        objective: found.verdict.objective,
        improvement: IndexMap::new(),
        feasible: found.verdict.feasible,
        violation: found.verdict.violation,
        violations: found.violations.clone(),
        active_bounds: found.active_bounds.clone(),
        starts: found.starts,
        starts_agreeing: found.starts_agreeing,
        evaluations: found.evaluations,
        status: found.status.clone(),
        remarks: found.remarks.clone(),
        synthesis: Vec::new(),
    }
}

/// Feasible before infeasible; among the feasible by the objective, among the others by the violation; then by layout.
pub(super) fn rank(found: &mut [Found], sense: Sense) {
    found.sort_by(|a, b| {
        let (first, second) = (&a.verdict, &b.verdict);
        let by_objective = match sense {
            Sense::Minimise => first.objective.total_cmp(&second.objective),
            Sense::Maximise => second.objective.total_cmp(&first.objective),
        };
        match (first.feasible, second.feasible) {
            (true, true) => by_objective,
            (true, false) => Ordering::Less,
            (false, true) => Ordering::Greater,
            (false, false) => first
                .violation
                .total_cmp(&second.violation)
                .then(by_objective),
        }
        .then_with(|| a.candidate.label().cmp(&b.candidate.label()))
    });
}

fn improvements(
    design: &DesignTask,
    objective: f64,
    references: &[outcome::Reference],
) -> IndexMap<String, f64> {
    references
        .iter()
        .filter_map(|reference| {
            let value = *reference.configuration.criteria.get(&design.objective)?;
            let gain = design.sense.sign() * (value - objective);
            let relative = gain / value.abs();
            relative
                .is_finite()
                .then(|| (reference.configuration.name.clone(), relative))
        })
        .collect()
}

/// A constraint in words, in the units of the study.
pub(super) fn constraint_words(constraint: &Constraint) -> String {
    let symbol = match constraint.sense {
        Sense::Minimise => "≤",
        Sense::Maximise => "≥",
    };
    if constraint.swept.is_some() {
        return format!("{} {symbol} swept bound", constraint.criterion);
    }
    format!(
        "{} {symbol} {}",
        constraint.criterion,
        constraint.bound.expression()
    )
}
