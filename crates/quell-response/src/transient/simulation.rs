//! The run: pieces one after the other, watched for switches and events.

use std::ops::ControlFlow;

use crate::dense::Dense;
use crate::eigen::eigenvalues;

use super::dynamics::Dynamics;
use super::error::TransientError;
use super::event::Event;
use super::integrator::Method;
use super::run::Run;
use super::trajectory::Trajectory;

/// Absolute tolerances of the states.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub enum Absolute {
    /// For each state the relative tolerance times a hundredth of its size as the start tells it: the larger of |x| and of |x'|
    /// times the shortest time constant of the Jacobian (at most the length of the run), at least 1e-6.
    #[default]
    Automatic,
    /// One number for all.
    All(f64),
    /// One for each state.
    Each(Vec<f64>),
}

/// How a run is carried out.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// The integrator.
    pub method: Method,
    /// Relative tolerance of a step; 1e-8.
    pub relative: f64,
    /// Absolute tolerances.
    pub absolute: Absolute,
    /// To how much of the length of the run events are located; 1e-13 (never better than rounding).
    pub event_tolerance: f64,
    /// An event function that comes within this fraction of its largest size to zero, or goes beyond it by less, is reported as
    /// grazing; 1e-6.
    pub grazing: f64,
    /// For how long the run goes on after the event that ends it, s; 0.
    pub continuation: f64,
    /// Most steps; 1,000,000.
    pub step_limit: usize,
    /// Times at which the integration starts anew, beside the system's own breakpoints; none.
    pub restarts: Vec<f64>,
    /// Size of a state, relative to one or its start, beyond which the run counts as diverged; 1e12.
    pub divergence: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            method: Method::Automatic,
            relative: 1e-8,
            absolute: Absolute::Automatic,
            event_tolerance: 1e-13,
            grazing: 1e-6,
            continuation: 0.0,
            step_limit: 1_000_000,
            restarts: Vec::new(),
            divergence: 1e12,
        }
    }
}

impl Settings {
    /// Default settings with another method.
    pub fn with_method(method: Method) -> Self {
        Self {
            method,
            ..Self::default()
        }
    }

    fn check(&self, states: usize) -> Result<(), TransientError> {
        let positive = [
            ("relative", self.relative),
            ("grazing", self.grazing),
            ("divergence", self.divergence),
        ];
        for (name, value) in positive {
            if !(value > 0.0 && value.is_finite()) {
                return Err(TransientError::Setting {
                    name,
                    value,
                    range: "positive",
                });
            }
        }
        if self.relative > 0.1 {
            return Err(TransientError::Setting {
                name: "relative",
                value: self.relative,
                range: "at most 0.1",
            });
        }
        for (name, value) in [
            ("event_tolerance", self.event_tolerance),
            ("continuation", self.continuation),
        ] {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(TransientError::Setting {
                    name,
                    value,
                    range: "zero or positive",
                });
            }
        }
        let bad = |value: &f64| !(*value > 0.0 && value.is_finite());
        let wrong = match &self.absolute {
            Absolute::Automatic => None,
            Absolute::All(value) => Some(*value).filter(bad),
            Absolute::Each(values) if values.len() == states => values.iter().copied().find(bad),
            Absolute::Each(values) => {
                return Err(TransientError::ToleranceCount {
                    expected: states,
                    found: values.len(),
                });
            }
        };
        match wrong {
            Some(value) => Err(TransientError::Setting {
                name: "absolute",
                value,
                range: "positive",
            }),
            None => Ok(()),
        }
    }
}

/// How far a run is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Time reached, s.
    pub t: f64,
    /// Fraction of the span of time.
    pub fraction: f64,
    /// Steps so far.
    pub steps: usize,
}

/// Carries a system from `start` over a span of time (s), or until an event ends it.
///
/// What goes wrong on the way is a status ([`End`]) beside the trajectory so far. Runs are deterministic: same arguments, same
/// bits.
///
/// # Errors
///
/// [`TransientError`] where the run cannot begin: start, span, settings or signals of events that do not fit the system.
pub fn simulate(
    dynamics: &mut dyn Dynamics,
    start: &[f64],
    span: (f64, f64),
    events: &[Event],
    settings: &Settings,
) -> Result<Trajectory, TransientError> {
    simulate_with(dynamics, start, span, events, settings, &mut |_| {
        ControlFlow::Continue(())
    })
}

/// [`simulate`] with a hook that is called after every step and may stop the run ([`End::Cancelled`]).
///
/// # Errors
///
/// As [`simulate`].
pub fn simulate_with(
    dynamics: &mut dyn Dynamics,
    start: &[f64],
    span: (f64, f64),
    events: &[Event],
    settings: &Settings,
    progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<Trajectory, TransientError> {
    let n = dynamics.states();
    if n == 0 {
        return Err(TransientError::NoStates);
    }
    if start.len() != n {
        return Err(TransientError::StartCount {
            expected: n,
            found: start.len(),
        });
    }
    if let Some(state) = start.iter().position(|value| !value.is_finite()) {
        return Err(TransientError::StartValue {
            state,
            value: start[state],
        });
    }
    let (from, to) = span;
    if !(from.is_finite() && to.is_finite() && from < to) {
        return Err(TransientError::Span { from, to });
    }
    let signals = dynamics.signals();
    for (event, asked) in events.iter().enumerate() {
        let read = [Some(asked.signal), asked.armed.map(|armed| armed.signal)];
        if let Some(signal) = read.into_iter().flatten().find(|&read| read >= signals) {
            return Err(TransientError::Signal {
                event,
                signal,
                signals,
            });
        }
    }
    settings.check(n)?;
    let absolute = tolerances(dynamics, start, span, settings);
    let mut run = Run::new(dynamics, start, span, events, settings, progress);
    run.go(dynamics, &absolute);
    Ok(run.finish())
}

/// Eigenvalues of the Jacobian, or none where they cannot be had.
pub(crate) fn spectrum(
    dynamics: &mut dyn Dynamics,
    t: f64,
    x: &[f64],
) -> Vec<num_complex::Complex64> {
    let n = x.len();
    let mut jacobian = vec![0.0; n * n];
    dynamics.jacobian(t, x, &mut jacobian);
    eigenvalues(&Dense::from_fn(n, n, |i, j| jacobian[i * n + j])).unwrap_or_default()
}

fn tolerances(
    dynamics: &mut dyn Dynamics,
    x: &[f64],
    (from, to): (f64, f64),
    settings: &Settings,
) -> Vec<f64> {
    match &settings.absolute {
        Absolute::All(value) => vec![*value; x.len()],
        Absolute::Each(values) => values.clone(),
        Absolute::Automatic => {
            let fastest = spectrum(dynamics, from, x)
                .iter()
                .fold(0.0_f64, |fastest, value| fastest.max(value.norm()));
            let time = (to - from).min(1.0 / fastest);
            let mut rates = vec![0.0; x.len()];
            dynamics.rates(from, x, &mut rates);
            x.iter()
                .zip(&rates)
                .map(|(x, rate)| {
                    let size = x.abs().max((rate * time).abs());
                    let size = if size.is_finite() { size } else { x.abs() };
                    settings.relative * 1e-2 * size.max(1e-6)
                })
                .collect()
        }
    }
}
