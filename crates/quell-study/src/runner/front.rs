//! A task with several objectives: the front of each layout, and of all together.

use quell_document::Fault;
use quell_search::{efficient, epsilon_levels};
use rayon::prelude::*;

use super::candidate::Found;
use super::design::{BATCH, constraint_words, designed};
use super::{RunError, Runner};
use crate::candidates::{Candidate, Candidates};
use crate::outcome::{Findings, FrontFindings, FrontPoint, LayoutFront, Plot};
use crate::plots::Curves;
use crate::situation::Situation;
use crate::study::{DesignTask, Objective};

/// An objective that is held while the next is improved may become worse by this part of itself: the tolerance within which
/// starts agree on it.
const HELD: f64 = 1e-4;

impl Runner<'_> {
    pub(super) fn front(
        &self,
        situation: &Situation,
        design: &DesignTask,
    ) -> Result<(Findings, Vec<Plot>), RunError> {
        let objectives = design.objectives();
        let references = self.references(situation, design, &mut Curves::default())?;
        let candidates = Candidates::of(design);
        let mut layouts: Vec<(String, Vec<Found>)> = Vec::new();
        let mut iterator = candidates.iter();
        loop {
            let batch: Vec<Candidate> = iterator.by_ref().take(BATCH).collect();
            if batch.is_empty() {
                break;
            }
            let results: Vec<Result<(String, Vec<Found>), Fault>> = batch
                .into_par_iter()
                .with_max_len(1)
                .map(|candidate| {
                    let label = candidate.label();
                    let found = self.front_of(situation, design, &objectives, &candidate)?;
                    self.recorder.advance(&label);
                    Ok((label, found))
                })
                .collect();
            for result in results {
                layouts.push(result?);
            }
        }
        Ok((
            Findings::Front(Box::new(FrontFindings {
                constraints: design.constraints.iter().map(constraint_words).collect(),
                references,
                layouts: ranked(&objectives, layouts),
                candidates: candidates.words(),
                method: format!(
                    "epsilon-constraint: `{}` searched under bounds on the others, at {} values of each from one end of the front to the other; the ends are the optima of single objectives, the others improved after them",
                    design.objective, design.front_points
                ),
                objectives,
            })),
            Vec::new(),
        ))
    }

    /// The designs of one layout from which its front is taken; one that misses a constraint where none meets them all.
    fn front_of(
        &self,
        situation: &Situation,
        design: &DesignTask,
        objectives: &[Objective],
        candidate: &Candidate,
    ) -> Result<Vec<Found>, Fault> {
        let mut found = Vec::new();
        for first in 0..objectives.len() {
            let end = self.end(situation, design, objectives, first, candidate)?;
            if !end.verdict.feasible {
                return Ok(vec![end]);
            }
            found.push(end);
        }
        // Of each objective after the first: its best and its worst among the ends.
        let range = |objective: &Objective| {
            let values = found.iter().map(|end| value(end, objective));
            let sign = objective.sense.sign();
            values.fold(
                (f64::INFINITY, f64::NEG_INFINITY),
                |(best, worst), value| (best.min(sign * value), worst.max(sign * value)),
            )
        };
        let Some((first, further)) = objectives.split_first() else {
            return Ok(found);
        };
        let (ideal, nadir): (Vec<f64>, Vec<f64>) = further.iter().map(range).unzip();
        let between: Vec<Result<Found, Fault>> =
            epsilon_levels(&ideal, &nadir, design.front_points)
                .into_par_iter()
                .with_max_len(1)
                .map(|level| {
                    let bounds: Vec<(Objective, f64)> = further
                        .iter()
                        .zip(level)
                        .map(|(objective, bound)| {
                            (objective.clone(), objective.sense.sign() * bound)
                        })
                        .collect();
                    self.candidate(
                        situation,
                        &design.bounded(first, &bounds),
                        candidate.clone(),
                    )
                })
                .collect();
        for one in between {
            let one = one?;
            if one.verdict.feasible {
                found.push(one);
            }
        }
        Ok(found)
    }

    /// The best of one objective; then, that being held, the best of the others one after the other.
    fn end(
        &self,
        situation: &Situation,
        design: &DesignTask,
        objectives: &[Objective],
        first: usize,
        candidate: &Candidate,
    ) -> Result<Found, Fault> {
        let (before, from) = objectives.split_at(first);
        let mut held: Vec<(Objective, f64)> = Vec::new();
        let mut best: Option<Found> = None;
        for objective in from.iter().take(1).chain(before).chain(from.iter().skip(1)) {
            let task = design.bounded(objective, &held);
            let found = self.candidate(situation, &task, candidate.clone())?;
            if !found.verdict.feasible {
                // What was best so far meets the constraints of the task, if anything does.
                return Ok(best.unwrap_or(found));
            }
            let reached = value(&found, objective);
            let slack = objective.sense.sign() * HELD * reached.abs();
            held.push((objective.clone(), reached + slack));
            best = Some(found);
        }
        best.ok_or_else(|| Fault::new("the task has no objective"))
    }
}

fn value(found: &Found, objective: &Objective) -> f64 {
    let value = found.evaluated.criteria.get(&objective.criterion);
    value.copied().unwrap_or(f64::NAN)
}

/// The front of each layout in the order of the first objective, its points ranked among the efficient ones of all layouts.
fn ranked(objectives: &[Objective], layouts: Vec<(String, Vec<Found>)>) -> Vec<LayoutFront> {
    let vector = |found: &Found| -> Vec<f64> {
        objectives
            .iter()
            .map(|objective| objective.sense.sign() * value(found, objective))
            .collect()
    };
    let fronts: Vec<(String, Vec<Found>)> = layouts
        .into_iter()
        .map(|(label, found)| {
            let values: Vec<Vec<f64>> = found.iter().map(vector).collect();
            let infeasible = found.iter().all(|one| !one.verdict.feasible);
            let mut own: Vec<Found> = found
                .into_iter()
                .zip(efficient(&values))
                .filter(|(_, efficient)| *efficient || infeasible)
                .map(|(one, _)| one)
                .collect();
            own.sort_by(|a, b| compared(&vector(a), &vector(b)));
            (label, own)
        })
        .collect();
    let all: Vec<Vec<f64>> = fronts
        .iter()
        .flat_map(|(_, found)| found)
        .map(|one| {
            if one.verdict.feasible {
                vector(one)
            } else {
                vec![f64::NAN]
            }
        })
        .collect();
    let common = efficient(&all);
    let mut order: Vec<usize> = (0..all.len())
        .filter(|index| common.get(*index).copied().unwrap_or(false))
        .collect();
    order.sort_by(|a, b| match (all.get(*a), all.get(*b)) {
        (Some(first), Some(second)) => compared(first, second),
        _ => std::cmp::Ordering::Equal,
    });
    let mut index = 0;
    fronts
        .into_iter()
        .map(|(layout, found)| LayoutFront {
            layout,
            points: found
                .into_iter()
                .map(|one| {
                    let place = order.iter().position(|known| *known == index);
                    index += 1;
                    FrontPoint {
                        rank: place.map(|place| place + 1),
                        design: designed(&one, place.map_or(0, |place| place + 1)),
                    }
                })
                .collect(),
        })
        .collect()
}

fn compared(a: &[f64], b: &[f64]) -> std::cmp::Ordering {
    a.iter()
        .zip(b)
        .map(|(a, b)| a.total_cmp(b))
        .find(|order| order.is_ne())
        .unwrap_or(std::cmp::Ordering::Equal)
}
