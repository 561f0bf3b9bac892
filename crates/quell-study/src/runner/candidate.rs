//! The search of one candidate: its best values, certified.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use indexmap::IndexMap;
use quell_document::Fault;
use quell_search::{Outcome, Problem, Settings, Side};

use super::starts::Effort;
use super::{Runner, remarks};
use crate::candidates::Candidate;
use crate::configuration::evaluated;
use crate::evaluator::Evaluator;
use crate::outcome::Evaluated;
use crate::problem::{DesignProblem, Verdict};
use crate::situation::Situation;
use crate::store::{Key, KeyBuilder};
use crate::study::DesignTask;

/// Most rounds of searching again after a certificate found a peak that the grid had missed.
const ROUNDS: usize = 6;

/// A design before it is ranked.
pub(super) struct Found {
    pub(super) candidate: Candidate,
    /// Values of the design variables.
    pub(super) point: Vec<f64>,
    /// Certified values of all criteria.
    pub(super) evaluated: Evaluated,
    pub(super) verdict: Verdict,
    pub(super) active_bounds: Vec<String>,
    pub(super) starts: usize,
    pub(super) starts_agreeing: usize,
    pub(super) evaluations: u64,
    pub(super) status: String,
    /// What an engineer should know beyond the numbers.
    pub(super) remarks: Vec<String>,
    /// How far each constraint is missed; empty where all hold.
    pub(super) violations: IndexMap<String, f64>,
}

impl Runner<'_> {
    /// Searches the values of one candidate, certifies the best, and searches again where a certificate finds more.
    pub(super) fn candidate(
        &self,
        situation: &Situation,
        design: &DesignTask,
        candidate: Candidate,
    ) -> Result<Found, Fault> {
        let mut problem = DesignProblem::of(self.study, situation, design, &candidate)?;
        let dimension = problem.variables().len();
        let mut settings = Settings::for_dimension(dimension);
        settings.seed = self.settings.seed;
        settings.feasibility = design.feasibility;
        if let Some(starts) = design.starts {
            settings.starts = starts;
        }
        let effort = Effort::of(design, &settings);
        let stream = stream_key(&candidate);
        let mut key = self.key(situation, design, &problem, &candidate);
        let mut evaluations = 0;
        let mut rounds = 0;
        let (outcome, missed) = loop {
            let outcome = if dimension == 0 {
                nothing_to_search(&problem)
            } else {
                self.starts(&problem, &settings, effort, stream, &key)?
            };
            evaluations += outcome.evaluations as u64;
            if outcome.point.len() != dimension {
                break (outcome, true);
            }
            rounds += 1;
            let missed = problem.refined(&outcome.point)?;
            if missed.is_empty() || rounds == ROUNDS || dimension == 0 {
                break (outcome, !missed.is_empty());
            }
            // The problem is another one from here on.
            for miss in &missed {
                key = miss.key(key);
            }
        };
        self.evaluations.fetch_add(evaluations, Ordering::Relaxed);
        let all = Evaluator::new(
            self.study,
            situation,
            Arc::clone(problem.evaluator.built()),
            None,
            &IndexMap::new(),
        )?;
        let evaluated = evaluated(&candidate.label(), &all, &outcome.point);
        let verdict = Verdict::on(&evaluated, design, &problem.constraints);
        let (violations, remarks) = if verdict.feasible {
            let mut remarks = remarks::cautions(&evaluated, design);
            remarks.extend(remarks::remarks(
                &problem, &candidate, &evaluated, &outcome, &settings,
            ));
            (IndexMap::new(), remarks)
        } else {
            let violations = remarks::violations(&evaluated, design, &problem.constraints);
            let remark = remarks::missed(&violations).into_iter().collect();
            (violations, remark)
        };
        Ok(Found {
            remarks,
            violations,
            status: status(design, &evaluated, verdict, &outcome, effort, missed),
            active_bounds: active_bounds(&problem, &outcome),
            starts: outcome.starts,
            starts_agreeing: outcome.starts_agreeing,
            candidate,
            point: outcome.point,
            evaluated,
            verdict,
            evaluations,
        })
    }
}

impl Runner<'_> {
    /// Everything that determines the search of a candidate but its settings: the texts of study and host, the version, the
    /// parameters and bounds at a point of a sweep, the objective, the layout.
    fn key(
        &self,
        situation: &Situation,
        design: &DesignTask,
        problem: &DesignProblem,
        candidate: &Candidate,
    ) -> KeyBuilder {
        let mut key = Key::of("start of a search")
            .text(env!("CARGO_PKG_VERSION"))
            .text(&self.study.hash)
            .text(&candidate.label());
        for (name, quantity) in &situation.parameters {
            key = key.text(name).number(quantity.value);
        }
        for (slot, _, _) in &candidate.layouts {
            key = key
                .text(&slot.device)
                .text(slot.placeholder.as_deref().unwrap_or_default());
        }
        // Two tasks may give one layout different ranges and fixed values.
        for (name, amount) in &design.fixed {
            key = key.text(name).text(&amount.expression().to_string());
        }
        for variable in problem.variables() {
            key = key
                .text(&variable.name)
                .numbers(&[variable.lower, variable.upper])
                .text(&format!("{:?}", variable.scale));
        }
        for goal in std::iter::once(&problem.objective).chain(&problem.constraints) {
            let name = problem.evaluator.names().nth(goal.criterion);
            key = key
                .text(name.unwrap_or_default())
                .numbers(&[goal.sense.sign(), goal.bound]);
        }
        key
    }
}

/// How the search of a candidate ended, in words.
fn status(
    design: &DesignTask,
    evaluated: &Evaluated,
    verdict: Verdict,
    outcome: &Outcome,
    effort: Effort,
    missed: bool,
) -> String {
    if !verdict.objective.is_finite() {
        let detail = evaluated.details.get(&design.objective);
        return detail.map_or_else(|| "no value".to_owned(), |detail| detail.status.clone());
    }
    let short = effort
        .agree
        .filter(|agree| verdict.feasible && outcome.starts_agreeing < *agree);
    if let Some(agree) = short {
        let (agreeing, starts) = (outcome.starts_agreeing, outcome.starts);
        let verb = if agreeing == 1 { "agrees" } else { "agree" };
        return format!(
            "only {agreeing} of {starts} starts {verb}, the most that are allowed, and `agree` asks for {agree}: raise `most_starts`"
        );
    }
    if !verdict.feasible {
        "infeasible: no values were found that meet every constraint; this is the least violation"
    } else if missed {
        "searched again as often as allowed; the certified value is above the search's estimate"
    } else if outcome.starts <= 1 {
        "one start"
    } else if outcome.starts_agreeing <= 1 {
        "no two starts agree: raise `starts`"
    } else {
        "starts agree"
    }
    .to_owned()
}

fn active_bounds(problem: &DesignProblem, outcome: &Outcome) -> Vec<String> {
    let variables = problem.variables();
    outcome
        .active_bounds
        .iter()
        .filter_map(|(index, side)| {
            let side = match side {
                Side::Lower => "lower",
                Side::Upper => "upper",
            };
            Some(format!("{} = {side}", variables.get(*index)?.name))
        })
        .collect()
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
