//! What is drawn of a run in time.

use quell_expression::Dimension;
use quell_response::transient::Record;

use super::observation::Observation;
use crate::outcome::Over;

/// A signal over time or over another signal.
#[derive(Debug, Clone)]
pub(crate) struct History {
    /// Name of the run.
    pub run: String,
    /// The signal.
    pub quantity: String,
    /// Its SI unit.
    pub unit: String,
    /// What it is drawn over.
    pub over: Over,
    /// The curve.
    pub points: Vec<(f64, f64)>,
}

/// So many points make a smooth curve on any screen.
const POINTS: usize = 600;

/// Signals that observations look at, over time, and works as one signal over the other.
pub(crate) fn histories(
    run: &str,
    labels: &[Option<(String, Dimension)>],
    observations: &[&Observation],
    record: &mut Record<'_>,
    [start, end, last]: [f64; 3],
) -> Vec<History> {
    let mut pairs: Vec<(usize, usize)> = Vec::new();
    let mut single: Vec<usize> = Vec::new();
    for observation in observations {
        match observation {
            Observation::Work(force, over) => pairs.push((*force, *over)),
            Observation::Maximum(signal, _)
            | Observation::Minimum(signal, _)
            | Observation::Peak(signal, _)
            | Observation::Trough(signal, _)
            | Observation::Largest(signal, _)
            | Observation::DecayRate(signal)
            | Observation::Span { signal, .. }
            | Observation::Crossing(signal, _)
            | Observation::At(signal, _)
            | Observation::Rms(signal)
            | Observation::Settling { signal, .. } => single.push(*signal),
            _ => {}
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    single.sort_unstable();
    single.dedup();
    let mut times: Vec<f64> = (0..=POINTS)
        .map(|index| start + (last - start) * index as f64 / POINTS as f64)
        .collect();
    times.push(end);
    times.sort_by(f64::total_cmp);
    let label = |signal: usize| labels.get(signal).cloned().flatten();
    let mut found = Vec::new();
    for (force, over) in pairs {
        let (Some((quantity, dimension)), Some((across, across_dimension))) =
            (label(force), label(over))
        else {
            continue;
        };
        let curve = times.iter().filter(|t| **t <= end).map(|t| {
            let values = record.values(*t);
            let at = |signal: usize| values.get(signal).copied().unwrap_or(f64::NAN);
            (at(over), at(force))
        });
        found.push(History {
            run: run.to_owned(),
            quantity,
            unit: dimension.unit_text(),
            over: Over::Signal(across, across_dimension.unit_text()),
            points: curve.collect(),
        });
    }
    for signal in single {
        let Some((quantity, dimension)) = label(signal) else {
            continue;
        };
        let points = times
            .iter()
            .map(|t| (*t, record.value(signal, *t)))
            .collect();
        found.push(History {
            run: run.to_owned(),
            quantity,
            unit: dimension.unit_text(),
            over: Over::Time,
            points,
        });
    }
    found
}
