//! The cycle on which a run in time ends, as a start.

use std::f64::consts::TAU;

use quell_continuation::{Problem, Samples};
use quell_document::Fault;
use quell_expression::{Dimension, Span};
use quell_response::transient::{End, Method, Settings, Trajectory, simulate};

use super::model::Model;
use crate::situation::Situation;
use crate::study::{ConfigurationSpec, Integration, Run, StartAt, Study};

/// Samples of a cycle.
#[derive(Debug)]
pub(super) struct Settled {
    times: Vec<f64>,
    states: Vec<Vec<f64>>,
    period: f64,
    periods: usize,
    /// Turns of each angle in the period.
    winding: Vec<i32>,
}

impl Settled {
    pub(super) fn samples(&self) -> Samples<'_> {
        Samples {
            times: &self.times,
            states: &self.states,
            period: self.period,
            periods: self.periods,
            winding: &self.winding,
        }
    }
}

/// Samples of the last period.
const SAMPLES: usize = 400;
/// A return to within this share of the swing closes a cycle.
const CLOSED: f64 = 0.02;
/// Phases at which two turns are compared.
const PHASES: u32 = 16;
/// Longest cycle that is looked for, in turns of the state that swings most, or in periods of the forcing.
const TURNS: usize = 8;

/// Lets a run go and takes its last period.
///
/// # Errors
/// A run that is none in time, or that ends on no cycle.
pub(super) fn samples(
    study: &Study,
    situation: &Situation,
    spec: &ConfigurationSpec,
    name: &str,
    span: Span,
    model: &Model,
) -> Result<Settled, Fault> {
    let fault = |message: String| Fault::at(&study.source, span, message);
    let run = match spec.runs.get(name).or_else(|| study.runs.get(name)) {
        Some(Run::Transient(run)) => run,
        Some(_) => {
            return Err(fault(format!("`{name}` is no run in time"))
                .help("a branch starts at the end of a run of `kind = \"transient\"`"));
        }
        None => return Err(fault(format!("there is no run `{name}`"))),
    };
    if matches!(run.start, StartAt::States(_)) {
        return Err(fault(format!(
            "the run `{name}` begins at values of its own, which a branch does not take over"
        ))
        .help("give the host these values under `start`"));
    }
    if !run.phases.is_empty() || run.end.is_some() || !run.inputs.is_empty() {
        return Err(fault(format!(
            "the run `{name}` has phases, an end event or signals of its own, after which no cycle of the host is settled"
        ))
        .help("start at a run that lasts for a time"));
    }
    let dimension = if situation.equations()?.dimensionless {
        Dimension::NONE
    } else {
        Dimension::TIME
    };
    let duration = run.duration.value(&situation.parameters, dimension)?;
    let mut settings = Settings::with_method(match run.method {
        Integration::Automatic => Method::Automatic,
        Integration::Explicit => Method::Explicit,
        Integration::Stiff => Method::Stiff,
        Integration::StiffOscillating => Method::StiffOscillating,
    });
    settings.relative = run.tolerance;
    let base = model.base();
    let mut moving = model.system().prepare(&model.values(&base));
    let mut start = moving.start(0.0);
    if matches!(run.start, StartAt::Equilibrium) {
        start = moving.equilibrium(0.0, &start).state;
    }
    let trajectory = simulate(&mut moving, &start, (0.0, duration), &[], &settings)
        .map_err(|error| fault(format!("the run `{name}` failed: {error}")))?;
    if !matches!(trajectory.end(), End::Time) {
        return Err(fault(format!(
            "the run `{name}` did not last to its end, so it ends on no cycle"
        )));
    }
    let Some(Cycle {
        period,
        turns,
        winding,
    }) = cycle(&trajectory, model.forcing_period(&base), &model.angles())
    else {
        return Err(fault(format!("the run `{name}` does not end on a cycle"))
            .help("let it last longer, or start it nearer to the cycle; near an equilibrium use `start = \"equilibrium\"`"));
    };
    if let Some(index) = winding.iter().position(|turns| *turns != 0)
        && !same_after_turns(model, &base, &trajectory, &winding)
    {
        let state = model.states().get(index).cloned().unwrap_or_default();
        return Err(fault(format!(
            "in the run `{name}` the angle `{state}` goes on turning, but after whole turns of it the equations are not the same"
        ))
        .help("branches are of motions that repeat: an angle may turn where it enters by `sin` and `cos` alone"));
    }
    let end = trajectory.to();
    let times: Vec<f64> = (0..=SAMPLES)
        .map(|index| end - period + period * index as f64 / SAMPLES as f64)
        .collect();
    let mut states: Vec<Vec<f64>> = times.iter().map(|t| trajectory.state(*t)).collect();
    // An angle that turns begins within its first turn, however many it has made by now.
    let whole: Vec<f64> = winding
        .iter()
        .zip(states.first().map_or(&[][..], Vec::as_slice))
        .map(|(turns, angle)| {
            if *turns == 0 {
                0.0
            } else {
                (angle / TAU).floor() * TAU
            }
        })
        .collect();
    for state in &mut states {
        for (value, whole) in state.iter_mut().zip(&whole) {
            *value -= whole;
        }
    }
    Ok(Settled {
        states,
        times,
        period,
        periods: if model.forced() { turns } else { 1 },
        winding,
    })
}

/// Whether the rates at the end of a run are the same after the turns of its angles.
fn same_after_turns(model: &Model, base: &[f64], trajectory: &Trajectory, winding: &[i32]) -> bool {
    let field = model.field();
    let t = trajectory.to();
    let here = trajectory.end_state();
    let there: Vec<f64> = here
        .iter()
        .zip(winding)
        .map(|(value, turns)| value - TAU * f64::from(*turns))
        .collect();
    let (mut a, mut b) = (vec![0.0; here.len()], vec![0.0; here.len()]);
    field.value(t, &here, base, &mut a);
    field.value(t, &there, base, &mut b);
    // Rounding of an angle of many turns is far below; a spring on the angle is far above.
    let size = a.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    a.iter().zip(&b).all(|(a, b)| (a - b).abs() <= 1e-6 * size)
}

/// The time in which the angle that turns fastest at the end has made its last turn; None where none makes one.
fn revolution(trajectory: &Trajectory, angles: &[bool]) -> Option<f64> {
    let (from, end) = (trajectory.from(), trajectory.to());
    let last = trajectory.state(end);
    let times: Vec<f64> = trajectory.step_times().collect();
    let gone = |index: usize, t: f64| {
        let now = trajectory.state(t);
        match (last.get(index), now.get(index)) {
            (Some(last), Some(now)) => (last - now).abs(),
            _ => 0.0,
        }
    };
    (0..last.len())
        .filter(|index| angles.get(*index).copied().unwrap_or(false))
        .filter_map(|index| {
            let before = times
                .iter()
                .rev()
                .find(|t| **t < end && gone(index, **t) >= TAU)?;
            let (mut a, mut b) = (*before, end);
            for _ in 0..60 {
                let half = 0.5 * (a + b);
                if gone(index, half) >= TAU {
                    a = half;
                } else {
                    b = half;
                }
            }
            (a > from).then_some(end - a)
        })
        .min_by(f64::total_cmp)
}

/// The cycle on which a trajectory ends; `forcing` is the period of what forces it.
fn cycle(trajectory: &Trajectory, forcing: Option<f64>, angles: &[bool]) -> Option<Cycle> {
    let turn = forcing
        .or_else(|| revolution(trajectory, angles))
        .or_else(|| turn(trajectory))?;
    closed(trajectory, turn, angles)
}

/// What a motion comes back to.
pub(super) struct Return {
    /// The period of the cycle, s, where there is one.
    pub(super) period: Option<f64>,
    /// Turns, or periods of what forces it, in that.
    pub(super) turns: usize,
    /// Largest distance of the last turn from the one before, relative to the swings of the states.
    pub(super) gap: f64,
}

/// How a trajectory comes back to itself at its end; `forcing` is the period of what forces it.
pub(super) fn returns(
    trajectory: &Trajectory,
    forcing: Option<f64>,
    angles: &[bool],
) -> Option<Return> {
    let turn = forcing
        .or_else(|| revolution(trajectory, angles))
        .or_else(|| turn(trajectory))?;
    let end = trajectory.to();
    let at = |index: u32| end - turn * f64::from(index) / f64::from(PHASES);
    let swings: Vec<Vec<f64>> = (0..PHASES).map(|k| trajectory.state(at(k))).collect();
    let gaps = swings.iter().zip(0..).flat_map(|(now, k)| {
        let before = trajectory.state(at(k + PHASES));
        let swings = &swings;
        (0..now.len()).map(move |index| {
            let (low, high) = swing(swings, index);
            let off = match (now.get(index), before.get(index)) {
                (Some(a), Some(b)) if angles.get(index).copied().unwrap_or(false) => {
                    (a - b) - ((a - b) / TAU).round() * TAU
                }
                (Some(a), Some(b)) => a - b,
                _ => 0.0,
            };
            off.abs() / (high - low).max(1e-9 * (high.abs() + low.abs()))
        })
    });
    let gap = gaps.filter(|gap| gap.is_finite()).fold(0.0, f64::max);
    let found = closed(trajectory, turn, angles);
    Some(Return {
        turns: found.as_ref().map_or(0, |cycle| cycle.turns),
        period: found.map(|cycle| cycle.period),
        gap,
    })
}

/// A motion that is where it was.
struct Cycle {
    /// s.
    period: f64,
    /// How many turns, or periods of the forcing, it takes.
    turns: usize,
    /// Whole turns of each angle.
    winding: Vec<i32>,
}

/// The time between the last two rises of the state that swings most through the middle of its swing.
fn turn(trajectory: &Trajectory) -> Option<f64> {
    let (from, to) = (0.5 * (trajectory.from() + trajectory.to()), trajectory.to());
    let mut times: Vec<f64> = trajectory.step_times().filter(|t| *t >= from).collect();
    times.push(to);
    let states: Vec<Vec<f64>> = times.iter().map(|t| trajectory.state(*t)).collect();
    let most = (0..trajectory.states())
        .map(|index| swing(&states, index))
        .enumerate()
        .filter(|(_, (low, high))| high - low > 1e-9 * (high.abs() + low.abs()))
        .max_by(|(_, a), (_, b)| (a.1 - a.0).total_cmp(&(b.1 - b.0)))?;
    let (index, (low, high)) = most;
    let middle = 0.5 * (low + high);
    let value = |t: f64| trajectory.state(t).get(index).copied().unwrap_or(f64::NAN) - middle;
    let mut rises = Vec::new();
    for pair in times.windows(2) {
        let [before, after] = pair else { continue };
        if value(*before) < 0.0 && value(*after) >= 0.0 {
            let (mut a, mut b) = (*before, *after);
            for _ in 0..60 {
                let half = 0.5 * (a + b);
                if value(half) < 0.0 {
                    a = half;
                } else {
                    b = half;
                }
            }
            rises.push(0.5 * (a + b));
        }
    }
    match rises.as_slice() {
        [.., before, last] => Some(last - before),
        _ => None,
    }
}

fn swing(states: &[Vec<f64>], index: usize) -> (f64, f64) {
    states
        .iter()
        .filter_map(|state| state.get(index))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(*value), high.max(*value))
        })
}

/// The shortest multiple of a turn after which the motion is where it was, but for whole turns of angles.
fn closed(trajectory: &Trajectory, turn: f64, angles: &[bool]) -> Option<Cycle> {
    let end = trajectory.to();
    let last = trajectory.state(end);
    let recent: Vec<Vec<f64>> = (0..100)
        .map(|index| trajectory.state(end - turn * f64::from(index) / 100.0))
        .collect();
    (1..=TURNS).find_map(|turns| {
        let period = turn * turns as f64;
        if end - period < trajectory.from() {
            return None;
        }
        let before = trajectory.state(end - period);
        let winding: Vec<i32> = last
            .iter()
            .zip(&before)
            .zip(angles)
            .map(|((a, b), angle)| {
                if *angle {
                    ((a - b) / TAU).round() as i32
                } else {
                    0
                }
            })
            .collect();
        let near =
            last.iter()
                .zip(&before)
                .zip(&winding)
                .enumerate()
                .all(|(index, ((a, b), turns))| {
                    let (low, high) = swing(&recent, index);
                    let gap = a - b - TAU * f64::from(*turns);
                    gap.abs() <= CLOSED * (high - low) + 1e-12 * (1.0 + a.abs())
                });
        near.then_some(Cycle {
            period,
            turns,
            winding,
        })
    })
}
