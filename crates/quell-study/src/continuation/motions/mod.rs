//! The task `simulate`: motions let go from several starts, and whether they end where another task says that something is stable.
//!
//! A motion is integrated in stretches until it is at rest (little is left of its first distance from an equilibrium), until it repeats
//! itself (its swings have settled and a period is found), or until its time is over. Nothing of branches enters into that, so it
//! is a check on them; but only of the starts that were tried.

mod ends;
mod outcome;
mod stable;
mod start;

use quell_continuation::Orbit;
use quell_document::Fault;
use quell_expression::Dimension;
use rayon::prelude::*;

pub use outcome::{
    MotionCount, MotionEnd, MotionFindings, MotionOutcome, PlaceOutcome, StableOutcome,
};

use self::ends::{Watch, Watched};
use self::stable::{Solution, Stable};
use self::start::{Start, begin, stated, stretches};
use super::ask::{ContinuationTask, MotionStarts};
use super::model::Model;
use super::outcome::{BranchPoint, ContinuationFindings};
use super::report::{Reporter, file_stem};
use super::solve::{Company, INTERRUPTED};
use super::solved::Solved;
use crate::situation::Situation;
use crate::study::Study;

/// A motion ends on a cycle of a branch where swings agree to this, which leaves room for what decays slowly beside it, and the period to
/// that.
const SWING: f64 = 0.05;
const PERIOD: f64 = 0.01;
/// … and at one of its equilibria where states do, relative to where the motion came from.
const NEAR: f64 = 1e-2;
/// Checks what the task asks for without letting anything go.
///
/// # Errors
/// Values or starts that the host does not have or take.
pub(super) fn check(
    study: &Study,
    situation: &Situation,
    task: &ContinuationTask,
    model: &Model,
) -> Result<usize, Fault> {
    let places = places(study, situation, task, model)?;
    let number = match &task.motions.starts {
        MotionStarts::Pushed(number) => *number,
        MotionStarts::Stated(all) => {
            stated(study, situation, task, model)?;
            all.len()
        }
    };
    duration(situation, task)?;
    Ok(places.len() * number)
}

/// Lets all motions of a task go.
///
/// # Errors
/// As [`check`].
pub(super) fn followed(
    study: &Study,
    situation: &Situation,
    name: &str,
    task: &ContinuationTask,
    model: &Model,
    before: Option<&Solved>,
    company: &Company<'_>,
) -> Result<ContinuationFindings, Fault> {
    let field = model.field();
    let reporter = Reporter {
        name,
        task,
        model,
        field: &field,
    };
    if before.is_some_and(|before| before.findings.status == INTERRUPTED) {
        return Ok(reporter.findings(&[], INTERRUPTED.to_owned(), Vec::new()));
    }
    let places = places(study, situation, task, model)?;
    let stated = stated(study, situation, task, model)?;
    let asked = duration(situation, task)?;
    let mut notes = Vec::new();
    let mut starts: Vec<Vec<Start>> = Vec::new();
    let free: Vec<Vec<f64>> = places
        .iter()
        .map(|place| match before {
            Some(before) => before.free(place),
            None => place.clone(),
        })
        .collect();
    for own in &free {
        let (found, note) = begin(model, own, &task.motions.starts, &stated);
        if let Some(note) = note
            && !notes.contains(&note)
        {
            notes.push(note);
        }
        starts.push(found);
    }
    if starts.iter().all(Vec::is_empty) {
        let why = notes.join("; ");
        return Ok(reporter.findings(&[], why, Vec::new()));
    }
    company.watcher.let_go(starts.iter().map(Vec::len).sum());
    let jobs: Vec<(usize, &Start)> = starts
        .iter()
        .enumerate()
        .flat_map(|(place, all)| all.iter().map(move |start| (place, start)))
        .collect();
    let watched: Vec<(usize, &Start, Watched)> = jobs
        .into_par_iter()
        .filter_map(|(place, start)| {
            let own = free.get(place)?;
            let duration = asked.unwrap_or(start.duration);
            let watch = Watch {
                model,
                free: own,
                duration,
                stretches: stretches(duration / start.turn),
                interrupt: company.interrupt.as_ref(),
            };
            let found = watch.motion(&start.state);
            company.watcher.watched();
            Some((place, start, found))
        })
        .collect();
    let mut known: Vec<Vec<Stable>> = places
        .par_iter()
        .map(|place| before.map_or_else(Vec::new, |before| before.stable(place, &reporter)))
        .collect();
    let mut outcomes: Vec<PlaceOutcome> = places
        .iter()
        .map(|place| PlaceOutcome {
            parameters: place.clone(),
            stable: Vec::new(),
            motions: Vec::new(),
        })
        .collect();
    for (place, start, found) in watched {
        let Some((outcome, known)) = outcomes.get_mut(place).zip(known.get(place)) else {
            continue;
        };
        outcome.motions.push(motion(
            &reporter,
            before,
            &outcome.parameters,
            known,
            start,
            found,
        ));
    }
    for (outcome, known) in outcomes.iter_mut().zip(&mut known) {
        outcome.stable = known.drain(..).map(|one| one.shown).collect();
    }
    let interrupt = company.interrupt.as_ref();
    let status = if interrupt.is_some_and(quell_continuation::Interrupt::is_raised) {
        INTERRUPTED
    } else {
        "done"
    };
    let mut findings = reporter.findings(&[], status.to_owned(), notes);
    findings.motions = Some(MotionFindings {
        of: task.motions.of.clone(),
        file: format!("{}-motions.csv", file_stem(name)),
        places: outcomes,
    });
    Ok(findings)
}

/// Values of the parameters at which motions are let go, SI.
fn places(
    study: &Study,
    situation: &Situation,
    task: &ContinuationTask,
    model: &Model,
) -> Result<Vec<Vec<f64>>, Fault> {
    let axes = model.axes();
    if task.motions.places.is_empty() {
        return Ok(vec![model.base()]);
    }
    let mut found = Vec::new();
    for place in &task.motions.places {
        let mut own = Vec::new();
        for (amount, axis) in place.iter().zip(axes) {
            let value = amount.value(&situation.parameters, axis.dimension)?;
            let (low, high) = axis.range;
            if !(low..=high).contains(&value) {
                return Err(Fault::at(
                    &study.source,
                    amount.span(),
                    format!(
                        "`{}` = {value} {} lies outside of its range, {low} to {high}",
                        axis.name, axis.unit
                    ),
                )
                .help("motions are compared with what was followed: choose a value within the range, or widen the range"));
            }
            own.push(value);
        }
        found.push(own);
    }
    Ok(found)
}

fn duration(situation: &Situation, task: &ContinuationTask) -> Result<Option<f64>, Fault> {
    let Some(amount) = &task.motions.duration else {
        return Ok(None);
    };
    let dimension = if situation.equations()?.dimensionless {
        Dimension::NONE
    } else {
        Dimension::TIME
    };
    let value = amount.value(&situation.parameters, dimension)?;
    if value > 0.0 && value.is_finite() {
        Ok(Some(value))
    } else {
        Err(amount.fault(format!("motions cannot be watched for {value} s")))
    }
}

/// A motion with what it ended on.
fn motion(
    reporter: &Reporter<'_>,
    before: Option<&Solved>,
    place: &[f64],
    known: &[Stable],
    start: &Start,
    found: Watched,
) -> MotionOutcome {
    let point = if let Some(rest) = &found.rest {
        BranchPoint {
            parameters: place.to_vec(),
            ..reporter.point(rest, 0)
        }
    } else {
        let (measures, oscillation) = reporter.named(found.measures.clone());
        BranchPoint {
            parameters: place.to_vec(),
            period: found.period,
            omega: None,
            unstable: 0,
            measures,
            oscillation: oscillation.filter(|_| found.end.settled()),
            state: Vec::new(),
        }
    };
    let on = known
        .iter()
        .position(|one| ends_on(one, &found, &point, start, reporter, before));
    MotionOutcome {
        start: start.words.clone(),
        duration: found.duration,
        end: found.end,
        point,
        on,
        envelope: found
            .envelope
            .into_iter()
            .map(|(t, measures)| (t, reporter.named(measures).0))
            .collect(),
    }
}

/// Whether a motion ended on a solution, or on its mirror image.
fn ends_on(
    one: &Stable,
    found: &Watched,
    point: &BranchPoint,
    start: &Start,
    reporter: &Reporter<'_>,
    before: Option<&Solved>,
) -> bool {
    match (&one.solution, &found.end) {
        (Solution::Equilibrium(at), MotionEnd::Equilibrium) => {
            let Some(rest) = &found.rest else {
                return false;
            };
            let pairs = || at.state.iter().zip(&rest.state).zip(&start.state);
            let come = pairs()
                .map(|((_, rest), start)| (rest - start).abs())
                .fold(0.0, f64::max);
            pairs().all(|((at, rest), _)| {
                (at - rest).abs().min((at + rest).abs()) <= NEAR * come + 1e-9 * at.abs()
            })
        }
        (Solution::Cycle(orbit), MotionEnd::Cycle) => {
            let close = |value: f64, of: f64, by: f64| (value - of).abs() <= by * of.abs();
            let period = found.period.unwrap_or(f64::NAN);
            close(period, orbit.period, PERIOD) && same_swings(&found.swings, orbit)
        }
        (Solution::Named, MotionEnd::Equilibrium) => one.shown.of == "equilibrium",
        (Solution::Named, MotionEnd::Cycle) => {
            let named =
                |index: Option<usize>, all: &[String]| index.and_then(|i| all.get(i).cloned());
            let own: Vec<String> = reporter
                .model
                .measures
                .iter()
                .skip(reporter.model.shown)
                .map(|measure| measure.name.clone())
                .collect();
            let other = before.map_or(&[][..], |before| &before.findings.oscillations);
            let (here, there) = (
                named(point.oscillation, &own),
                named(one.shown.point.oscillation, other),
            );
            one.shown.of == "cycle" && here == there
        }
        _ => false,
    }
}

/// Whether the states of a motion swing as those of a cycle do; what hardly swings is not asked.
fn same_swings(swings: &[f64], orbit: &Orbit) -> bool {
    let own: Vec<f64> = (0..swings.len())
        .map(|state| {
            let (low, high) = orbit.range(state);
            high - low
        })
        .collect();
    let largest = own.iter().copied().fold(0.0, f64::max);
    swings
        .iter()
        .zip(&own)
        .filter(|(swing, own)| swing.is_finite() && **own > 1e-6 * largest)
        .all(|(swing, own)| (swing - own).abs() <= SWING * own)
}
