//! A motion in stretches, until it has settled.

use quell_continuation::{Equilibrium, Interrupt};
use quell_model::system::EquilibriumStatus;
use quell_response::transient::{End, Record, Settings, Trajectory, simulate};

use super::super::measure;
use super::super::model::Model;
use super::super::settled;
use super::outcome::MotionEnd;

/// Error of a step, relative.
const RELATIVE: f64 = 1e-7;
/// Samples of a stretch in which swings are looked for; parabolas through three of them give the extremes.
const SAMPLES: usize = 2000;
/// A motion is at rest where this part of its first distance is left.
const LEFT: f64 = 1e-3;
/// Its swings have settled where they change by less from stretch to stretch …
const STEADY: f64 = 1e-3;
/// … and by no more than this in all that is to come, if changes go on falling as they do.
const TO_COME: f64 = 2e-3;
/// A turn comes nearer to the one before where less than this is left of their distance after the last
/// quarter of the stretches.
const CLOSING: f64 = 0.9;
/// Changes below are those of sampling.
const NOISE: f64 = 1e-5;

/// How a motion is watched.
pub(super) struct Watch<'a> {
    pub(super) model: &'a Model,
    /// Values of the free parameters.
    pub(super) free: &'a [f64],
    /// For how long, s, in how many stretches.
    pub(super) duration: f64,
    pub(super) stretches: usize,
    pub(super) interrupt: Option<&'a Interrupt>,
}

/// A motion that was watched.
pub(super) struct Watched {
    pub(super) end: MotionEnd,
    /// How long it was watched, s.
    pub(super) duration: f64,
    /// The equilibrium where it came to rest.
    pub(super) rest: Option<Equilibrium>,
    /// Period where it repeats itself, s.
    pub(super) period: Option<f64>,
    /// Swings of the states at the end; NaN for an angle that turns.
    pub(super) swings: Vec<f64>,
    /// All measures over its last period, or its last stretch.
    pub(super) measures: Vec<f64>,
    /// All measures by stretch, with the time at which it ends.
    pub(super) envelope: Vec<(f64, Vec<f64>)>,
}

impl Watch<'_> {
    /// Lets a motion go.
    pub(super) fn motion(&self, start: &[f64]) -> Watched {
        let values = self.model.values(self.free);
        let mut prepared = self.model.system().prepare(&values);
        let parameters = self.model.parameters(self.free);
        let settings = Settings {
            relative: RELATIVE,
            ..Settings::default()
        };
        let angles = self.model.angles();
        let mut found = Watched {
            end: MotionEnd::Failed("it was not let go".to_owned()),
            duration: 0.0,
            rest: None,
            period: None,
            swings: Vec::new(),
            measures: Vec::new(),
            envelope: Vec::new(),
        };
        let mut state = start.to_vec();
        let mut history: Vec<Vec<f64>> = Vec::new();
        let mut gaps: Vec<f64> = Vec::new();
        let mut first = None;
        for stretch in 0..self.stretches {
            if self.interrupt.is_some_and(Interrupt::is_raised) {
                found.end = MotionEnd::Failed("interrupted".to_owned());
                return found;
            }
            let time = |index: usize| self.duration * index as f64 / self.stretches as f64;
            let span = (time(stretch), time(stretch + 1));
            let trajectory = match simulate(&mut prepared, &state, span, &[], &settings) {
                Ok(trajectory) => trajectory,
                Err(error) => {
                    found.end = MotionEnd::Failed(error.to_string());
                    return found;
                }
            };
            found.duration = trajectory.to();
            if !matches!(trajectory.end(), End::Time) {
                found.end = MotionEnd::Failed(broken(trajectory.end(), trajectory.to()));
                return found;
            }
            state = trajectory.end_state();
            found.swings = swings(&trajectory, &angles);
            history.push(found.swings.clone());
            let mut record = Record::new(&trajectory, &mut prepared);
            found.measures = measure::in_time(&self.model.measures, &mut record, &parameters);
            found
                .envelope
                .push((trajectory.to(), found.measures.clone()));
            // At rest: little is left of the first distance from the equilibrium that is near now.
            let near = prepared.equilibrium(trajectory.to(), &state);
            if !self.model.forced() && near.status != EquilibriumStatus::NotFound {
                let distance = apart(&state, &near.state).max(apart(&found.swings, &[]));
                let begun = *first.get_or_insert_with(|| apart(start, &near.state).max(distance));
                if distance <= LEFT * begun {
                    found.end = MotionEnd::Equilibrium;
                    found.rest = Some(Equilibrium {
                        state: near.state,
                        parameters: self.free.to_vec(),
                    });
                    return found;
                }
            }
            let forcing = self.model.forcing_period(self.free);
            let back = settled::returns(&trajectory, forcing, &angles);
            gaps.push(back.as_ref().map_or(f64::NAN, |back| back.gap));
            if steady(&history) {
                let cycle = back.filter(|back| back.turns == 1 || !closing(&gaps));
                if let Some(period) = cycle.and_then(|back| back.period) {
                    found.end = MotionEnd::Cycle;
                    found.period = Some(period);
                    let mut record = Record::new(&trajectory, &mut prepared);
                    record.between(Some(trajectory.to() - period), None);
                    found.measures =
                        measure::in_time(&self.model.measures, &mut record, &parameters);
                    return found;
                }
            }
        }
        found.end = MotionEnd::Open(changing(&history));
        found
    }
}

/// Why a simulation went no further.
fn broken(end: &End, t: f64) -> String {
    match end {
        End::Diverged => format!("it grew beyond all bounds by {t:.4} s"),
        End::StepLimit => format!("the integrator's steps ran out at {t:.4} s"),
        End::Chattering { .. } => format!("a switch was crossed back and forth at {t:.4} s"),
        End::Failed { why } => format!("the integrator gave up at {t:.4} s: {why}"),
        _ => format!("it broke off at {t:.4} s"),
    }
}

/// Largest distance of two lists; of one from zero where the other is empty.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    let other = b.iter().copied().chain(std::iter::repeat(0.0));
    a.iter()
        .zip(other)
        .map(|(a, b)| (a - b).abs())
        .filter(|gap| gap.is_finite())
        .fold(0.0, f64::max)
}

/// Largest less least value of each state; NaN for an angle that turns.
fn swings(trajectory: &Trajectory, angles: &[bool]) -> Vec<f64> {
    let (from, to) = (trajectory.from(), trajectory.to());
    let n = trajectory.states();
    let mut rows = vec![vec![0.0; n]; 3];
    let mut ends = vec![(f64::INFINITY, f64::NEG_INFINITY); n];
    for index in 0..=SAMPLES {
        let t = from + (to - from) * index as f64 / SAMPLES as f64;
        rows.rotate_left(1);
        if let Some(last) = rows.last_mut() {
            trajectory.state_into(t, last);
        }
        let [before, middle, after] = rows.as_slice() else {
            continue;
        };
        for (i, (low, high)) in ends.iter_mut().enumerate() {
            let of = |row: &[f64]| row.get(i).copied().unwrap_or(f64::NAN);
            let (a, b, c) = (of(before), of(middle), of(after));
            *low = low.min(c);
            *high = high.max(c);
            let turning = (b > a && b >= c) || (b < a && b <= c);
            if index >= 2 && turning {
                let extreme = b - (c - a).powi(2) / (8.0 * (a - 2.0 * b + c));
                *low = low.min(extreme);
                *high = high.max(extreme);
            }
        }
    }
    ends.iter()
        .enumerate()
        .map(|(i, (low, high))| {
            let turns = angles.get(i).copied().unwrap_or(false);
            if turns && high - low > std::f64::consts::TAU {
                f64::NAN
            } else {
                high - low
            }
        })
        .collect()
}

/// Largest relative change of a swing between two stretches.
fn change(before: &[f64], after: &[f64]) -> f64 {
    // A state that hardly takes part is rounding.
    let least = 1e-6 * apart(after, &[]);
    before
        .iter()
        .zip(after)
        .filter(|(a, b)| a.is_finite() && b.is_finite())
        .map(|(a, b)| (a - b).abs() / b.abs().max(least).max(f64::MIN_POSITIVE))
        .fold(0.0, f64::max)
}

/// Whether swings have settled.
fn steady(history: &[Vec<f64>]) -> bool {
    let [.., one, two, three] = history else {
        return false;
    };
    let (before, last) = (change(one, two), change(two, three));
    if last.max(before) <= NOISE {
        return true;
    }
    let ratio = last / before;
    last <= STEADY && ratio < 1.0 && last * ratio / (1.0 - ratio) <= TO_COME
}

/// Whether a turn comes ever nearer to the one before, so that a motion that takes several turns now will take one in the end.
fn closing(gaps: &[f64]) -> bool {
    let back = (gaps.len() / 4).max(4);
    let before = gaps.len().checked_sub(1 + back);
    match (before.and_then(|index| gaps.get(index)), gaps.last()) {
        (Some(before), Some(last)) => *last < CLOSING * before,
        _ => true,
    }
}

/// How a motion that has not settled changes.
fn changing(history: &[Vec<f64>]) -> String {
    let [.., before, last] = history else {
        return "it was watched for too short a time".to_owned();
    };
    let least = 1e-3 * apart(last, &[]).max(apart(before, &[]));
    let most = before
        .iter()
        .zip(last)
        .filter(|(a, b)| a.is_finite() && b.is_finite() && a.max(**b) > least)
        .map(|(a, b)| (b - a) / a.max(*b))
        .max_by(|a, b| a.abs().total_cmp(&b.abs()))
        .unwrap_or(0.0);
    if most.abs() <= STEADY && steady(history) {
        "its swings are steady, but it does not repeat itself within eight turns".to_owned()
    } else if most > 0.0 {
        format!(
            "a swing still grew, by {:.2} % in the last stretch",
            100.0 * most
        )
    } else {
        format!(
            "a swing still fell, by {:.2} % in the last stretch",
            -100.0 * most
        )
    }
}
