//! Where motions begin.

use num_complex::Complex64;
use quell_continuation::eigenpairs;
use quell_document::Fault;

use super::super::ask::{ContinuationTask, MotionStarts};
use super::super::model::Model;
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
/// Seed of the pushes.
const SEED: u64 = 0x5851_f42d_4c95_7f2d;

/// Where a motion begins.
pub(super) struct Start {
    pub(super) words: String,
    pub(super) state: Vec<f64>,
    /// How long it is watched unless the study says, s.
    pub(super) duration: f64,
    /// A turn of the least damped mode, or a period of what forces it, s.
    pub(super) turn: f64,
}

/// A start that the study states: places among the states with values, SI; all others are at rest.
pub(super) struct Stated {
    words: String,
    values: Vec<(usize, f64)>,
}

/// The starts that a task states.
///
/// # Errors
/// What is no state of the host, or a value of another dimension.
pub(super) fn stated(
    study: &Study,
    situation: &Situation,
    task: &ContinuationTask,
    model: &Model,
) -> Result<Vec<Stated>, Fault> {
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
        found.push(Stated {
            words: words.join(", "),
            values,
        });
    }
    Ok(found)
}

/// Where motions begin at values of the free parameters, and what has to be said of that.
pub(super) fn begin(
    model: &Model,
    free: &[f64],
    starts: &MotionStarts,
    stated: &[Stated],
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
            let all = stated.iter().map(|stated| {
                let mut state = rest.clone();
                for (place, value) in &stated.values {
                    if let Some(entry) = state.get_mut(*place) {
                        *entry = *value;
                    }
                }
                Start {
                    words: stated.words.clone(),
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
    // Where nothing swings, what creeps takes its place.
    let swing = modes.iter().any(|value| value.im > 0.0);
    let largest = modes.iter().map(|value| value.norm()).fold(0.0, f64::max);
    let all = || {
        // What neither swings nor creeps is free to stay anywhere.
        let creeps = move |value: &&Complex64| value.re.abs() > 1e-9 * largest;
        modes
            .iter()
            .filter(move |value| value.im > 0.0 || !swing && creeps(value))
    };
    let speed = all()
        .next()
        .map_or(1.0, |first| if swing { first.im } else { first.re.abs() });
    let turn = forcing.unwrap_or(std::f64::consts::TAU / speed);
    let slowest = all()
        .map(|value| value.re.abs())
        .fold(f64::INFINITY, f64::min);
    let turns = (DECAYS / (slowest * turn).max(f64::MIN_POSITIVE)).clamp(TURNS.0, TURNS.1);
    (turns * turn, turn)
}

/// Stretches of so many turns.
pub(super) fn stretches(turns: f64) -> usize {
    (turns / STRETCH).clamp(STRETCHES.0, STRETCHES.1) as usize
}
