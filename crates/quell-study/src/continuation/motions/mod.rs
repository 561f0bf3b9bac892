//! The task `simulate`: motions let go from several starts, and whether they end where another task says that something is stable.
//!
//! A motion is integrated in stretches until it is at rest (little is left of its first distance from an equilibrium), until it repeats
//! itself (its swings have settled and a period is found), or until its time is over. Nothing of branches enters into that, so it
//! is a check on them; but only of the starts that were tried.

mod ends;
mod outcome;
mod stable;

use num_complex::Complex64;
use quell_continuation::{Orbit, eigenpairs};
use quell_document::Fault;
use quell_expression::Dimension;
use rayon::prelude::*;

pub use outcome::{
    MotionCount, MotionEnd, MotionFindings, MotionOutcome, PlaceOutcome, StableOutcome,
};

use self::ends::{Watch, Watched};
use self::stable::{Solution, Stable};
use super::ask::{ContinuationTask, MotionStarts};
use super::model::Model;
use super::outcome::{BranchPoint, ContinuationFindings};
use super::report::{Reporter, file_stem};
use super::solve::{Company, INTERRUPTED};
use super::solved::Solved;
use crate::push::{Still, push};
use crate::situation::Situation;
use crate::study::Study;

/// The nonlinear part of the rates at the smallest and the largest push, relative to the linear one at a push of the size 1.
const SHARE: f64 = 0.3;
const SMALLEST: f64 = 1e-2;
const LARGEST: f64 = 3.0;
/// Unless the study says for how long, motions are watched for so many times of growth or decay of the slowest mode, and for so many
/// turns of the fastest growing one.
const DECAYS: f64 = 10.0;
const TURNS: (f64, f64) = (200.0, 4000.0);
/// The length of a stretch, in turns, and how many there are.
const STRETCH: f64 = 16.0;
const STRETCHES: (f64, f64) = (8.0, 200.0);
/// A motion ends on a cycle of a branch where swings agree to this, which leaves room for what decays slowly beside it, and the period to
/// that.
const SWING: f64 = 0.05;
const PERIOD: f64 = 0.01;
/// … and at one of its equilibria where states do, relative to where the motion came from.
const NEAR: f64 = 1e-2;
/// Seed of the pushes.
const SEED: u64 = 0x5851_f42d_4c95_7f2d;

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

/// Where a motion begins.
struct Start {
    words: String,
    state: Vec<f64>,
    /// How long it is watched unless the study says, s.
    duration: f64,
    /// A turn of the least damped mode, or a period of what forces it, s.
    turn: f64,
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

/// Stated starts: places among the states with values, SI, and words.
fn stated(
    study: &Study,
    situation: &Situation,
    task: &ContinuationTask,
    model: &Model,
) -> Result<Vec<(String, Vec<(usize, f64)>)>, Fault> {
    let MotionStarts::Stated(all) = &task.motions.starts else {
        return Ok(Vec::new());
    };
    let known = model.beginnings();
    let states = model.states();
    let mut found = Vec::new();
    for (one, _) in all {
        let (mut words, mut values) = (Vec::new(), Vec::new());
        for (name, amount) in one {
            let fault = |message: String| Fault::at(&study.source, amount.span(), message);
            let place = states.iter().position(|state| state == name);
            let own = known.iter().find(|(known, _)| known == name);
            let (Some(place), Some((_, dimension))) = (place, own) else {
                let fault = fault(match own {
                    Some(_) => format!(
                        "`{name}` follows from the other states, so no motion can begin with a value of it"
                    ),
                    None => {
                        format!("the host has no coordinate, rate or state `{name}` to begin with")
                    }
                });
                let names = states.iter().map(String::as_str);
                return Err(match quell_expression::nearest(name, names) {
                    Some(near) if near != name => fault.help(format!("did you mean `{near}`?")),
                    _ => fault.help(format!("it has the states {}", states.join(", "))),
                });
            };
            values.push((place, amount.value(&situation.parameters, *dimension)?));
            words.push(format!("{name} = {}", amount.typed()));
        }
        found.push((words.join(", "), values));
    }
    Ok(found)
}

/// Where motions begin at values of the free parameters, and what has to be said of that.
fn begin(
    model: &Model,
    free: &[f64],
    starts: &MotionStarts,
    stated: &[(String, Vec<(usize, f64)>)],
) -> (Vec<Start>, Option<String>) {
    let mut prepared = model.system().prepare(&model.values(free));
    let forcing = model.forcing_period(free);
    let rest = if forcing.is_some() {
        prepared.start(0.0)
    } else {
        match model.equilibrium(free) {
            Ok(rest) => rest,
            Err(why) => return (Vec::new(), Some(why)),
        }
    };
    let n = rest.len();
    let mut matrix = vec![0.0; n * n];
    prepared.state_matrix(0.0, &rest, &mut matrix);
    let modes = eigenpairs(n, &matrix).unwrap_or_default();
    let modes: Vec<Complex64> = modes.into_iter().map(|(value, _)| value).collect();
    let (duration, turn) = times(&modes, forcing);
    match starts {
        MotionStarts::Stated(_) => {
            let all = stated.iter().map(|(words, values)| {
                let mut state = rest.clone();
                for (place, value) in values {
                    if let Some(entry) = state.get_mut(*place) {
                        *entry = *value;
                    }
                }
                Start {
                    words: words.clone(),
                    state,
                    duration,
                    turn,
                }
            });
            (all.collect(), None)
        }
        MotionStarts::Pushed(number) => {
            let still = Still {
                state: &rest,
                matrix: &matrix,
                creeping: true,
            };
            let mut found = Vec::new();
            for index in 0..*number {
                let mut random = SEED.wrapping_mul(index as u64 + 1);
                let own = push(&still, SHARE, &mut random, |state, rates| {
                    prepared.rates(0.0, state, rates);
                });
                let Some(own) = own else {
                    let why = "the equations are as good as linear about the equilibrium, so no size of a push is given by them: name starts, `starts = [{ x = \"1 mm\" }]`";
                    return (Vec::new(), Some(why.to_owned()));
                };
                let part = if *number == 1 {
                    1.0
                } else {
                    let along = index as f64 / (*number - 1) as f64;
                    SMALLEST * (LARGEST / SMALLEST).powf(along)
                };
                let state = own
                    .state
                    .iter()
                    .zip(&own.rest)
                    .map(|(x, rest)| rest + part * (x - rest));
                found.push(Start {
                    words: format!("pushed by {part:.2}"),
                    state: state.collect(),
                    duration,
                    turn,
                });
            }
            (found, None)
        }
    }
}

/// How long motions are watched unless the study says, and a turn, s; of modes the least damped come first.
fn times(modes: &[Complex64], forcing: Option<f64>) -> (f64, f64) {
    let swinging = || modes.iter().filter(|value| value.im > 0.0);
    let speed = swinging().next().map_or(1.0, |first| first.im);
    let turn = forcing.unwrap_or(std::f64::consts::TAU / speed);
    let slowest = swinging()
        .map(|value| value.re.abs())
        .fold(f64::INFINITY, f64::min);
    let turns = (DECAYS / (slowest * turn).max(f64::MIN_POSITIVE)).clamp(TURNS.0, TURNS.1);
    (turns * turn, turn)
}

/// Stretches of so many turns.
fn stretches(turns: f64) -> usize {
    (turns / STRETCH).clamp(STRETCHES.0, STRETCHES.1) as usize
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
    let point = match &found.rest {
        Some(rest) => BranchPoint {
            parameters: place.to_vec(),
            ..reporter.point(rest, 0)
        },
        None => {
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
