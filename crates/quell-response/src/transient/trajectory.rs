//! A run: the solution dense in time, and what happened on the way.

use super::chebyshev::nodes;
use super::event::{Grazing, Occurrence};
use super::integrator::{Scheme, Step};

/// How a run ended.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum End {
    /// An event that ends it.
    Event {
        /// Its index in the list given; the first one in it where several happened at once.
        event: usize,
    },
    /// The end of the span of time.
    Time,
    /// More steps than allowed.
    StepLimit,
    /// The states grew beyond all bounds, or the rates stopped being numbers.
    Diverged,
    /// A switch is crossed back and forth without time going on, or the motion would have to slide along it.
    Chattering {
        /// Index of the switching function.
        switch: usize,
    },
    /// The integrator gave up.
    Failed {
        /// What it says.
        why: String,
    },
    /// The caller asked to stop.
    Cancelled,
}

impl End {
    /// Whether the run went as far as it should: to an event or to the end of its time.
    pub fn is_regular(&self) -> bool {
        matches!(self, Self::Event { .. } | Self::Time)
    }
}

/// What a run cost.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Accepted steps.
    pub steps: usize,
    /// Evaluations of the rates (none in exact propagation).
    pub evaluations: usize,
    /// Crossings of switches, at each of which integration began anew.
    pub restarts: usize,
    /// What the steps were taken with, in order of first use.
    pub schemes: Vec<Scheme>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Segment {
    pub(crate) from: f64,
    pub(crate) length: f64,
    pub(crate) to: f64,
    pub(crate) degree: usize,
    offset: usize,
}

/// The solution of a run, dense in time, with its events.
///
/// Every step is a polynomial through states at Chebyshev-Lobatto points. With exact propagation it is the solution to about 1e-13
/// of each state's largest size; with the integrators it is their own dense output (order 4 for Tsit5(4), the order of the
/// step for backward differentiation), of about the accuracy that was asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    states: usize,
    start: f64,
    segments: Vec<Segment>,
    values: Vec<f64>,
    pub(crate) occurrences: Vec<Occurrence>,
    pub(crate) grazings: Vec<Grazing>,
    pub(crate) end: End,
    pub(crate) ended: Option<f64>,
    pub(crate) statistics: Statistics,
}

impl Trajectory {
    pub(crate) fn new(start: f64, x: &[f64]) -> Self {
        // A segment of no length, so that a run that fails at once still has a state.
        Self {
            states: x.len(),
            start,
            segments: vec![Segment {
                from: start,
                length: 0.0,
                to: start,
                degree: 0,
                offset: 0,
            }],
            values: x.to_vec(),
            occurrences: Vec::new(),
            grazings: Vec::new(),
            end: End::Time,
            ended: None,
            statistics: Statistics::default(),
        }
    }

    /// Number of states.
    pub fn states(&self) -> usize {
        self.states
    }

    /// Start of the run, s.
    pub fn from(&self) -> f64 {
        self.start
    }

    /// End of the run, s: the time of the event that ended it, or the last time. A continuation is not counted.
    pub fn to(&self) -> f64 {
        self.ended.unwrap_or_else(|| self.last())
    }

    /// Last time for which there is a state, s: after [`to`](Self::to) where the run was continued.
    pub fn last(&self) -> f64 {
        self.segments
            .last()
            .map_or(self.start, |segment| segment.to)
    }

    /// What ended it.
    pub fn end(&self) -> &End {
        &self.end
    }

    /// Events in order of time, those of the continuation included.
    pub fn occurrences(&self) -> &[Occurrence] {
        &self.occurrences
    }

    /// The times of one event.
    pub fn times_of(&self, event: usize) -> impl Iterator<Item = f64> + '_ {
        self.occurrences
            .iter()
            .filter(move |occurrence| occurrence.event == event)
            .map(|occurrence| occurrence.t)
    }

    /// Where event functions touched their level or nearly did.
    pub fn grazings(&self) -> &[Grazing] {
        &self.grazings
    }

    /// Whether the event that ended the run was touched rather than crossed, so that a small change of anything may make the
    /// run go on.
    pub fn ends_grazing(&self) -> bool {
        self.ended.is_some_and(|end| {
            self.occurrences
                .iter()
                .any(|occurrence| occurrence.t == end && occurrence.grazing)
        })
    }

    /// How far beyond its level the signal of the event that ended the run goes, over its largest size in the run, as its first
    /// two derivatives there predict it: see [`Occurrence::depth`]. `None` where no event ended it.
    pub fn ending_depth(&self) -> Option<f64> {
        let end = self.ended?;
        let at_end = self.occurrences.iter().filter(|one| one.t == end);
        at_end.map(|one| one.depth).reduce(f64::min)
    }

    /// What it cost.
    pub fn statistics(&self) -> &Statistics {
        &self.statistics
    }

    /// States at a time, clamped to the run.
    pub fn state(&self, t: f64) -> Vec<f64> {
        let mut x = vec![0.0; self.states];
        self.state_into(t, &mut x);
        x
    }

    /// States at the end of the run (see [`to`](Self::to)): what the next phase starts from.
    pub fn end_state(&self) -> Vec<f64> {
        self.state(self.to())
    }

    /// States at a time, clamped to the run, without allocation. `x` has as many places as there are states.
    pub fn state_into(&self, t: f64, x: &mut [f64]) {
        self.evaluate(self.segment_at(t), t, x);
    }

    /// Times at which the steps begin and end.
    pub fn step_times(&self) -> impl Iterator<Item = f64> + '_ {
        std::iter::once(self.start).chain(
            self.segments
                .iter()
                .filter(|segment| segment.to > segment.from)
                .map(|segment| segment.to),
        )
    }

    pub(crate) fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// The segment that holds a time; at a junction the earlier one.
    pub(crate) fn segment_at(&self, t: f64) -> usize {
        self.segments
            .partition_point(|segment| segment.to < t)
            .min(self.segments.len() - 1)
    }

    pub(crate) fn evaluate(&self, segment: usize, t: f64, x: &mut [f64]) {
        let n = self.states;
        let segment = &self.segments[segment];
        let values = &self.values[segment.offset..];
        if segment.length > 0.0 {
            let theta = ((t - segment.from) / segment.length).clamp(0.0, 1.0);
            nodes(segment.degree).interpolate(values, n, theta, x);
        } else {
            x[..n].copy_from_slice(&values[..n]);
        }
    }

    /// The states at the points of a segment, node-major.
    pub(crate) fn node_values(&self, segment: usize) -> &[f64] {
        let segment = &self.segments[segment];
        &self.values[segment.offset..segment.offset + (segment.degree + 1) * self.states]
    }

    pub(crate) fn push(&mut self, step: &Step<'_>) {
        self.segments.push(Segment {
            from: step.from,
            length: step.length,
            to: step.to,
            degree: step.degree,
            offset: self.values.len(),
        });
        self.values.extend_from_slice(step.values);
    }

    /// Takes the last step back.
    pub(crate) fn pop(&mut self) {
        if self.segments.len() > 1
            && let Some(segment) = self.segments.pop()
        {
            self.values.truncate(segment.offset);
        }
    }

    /// Forgets everything after a time.
    pub(crate) fn cut(&mut self, t: f64) {
        while self.segments.len() > 1
            && self
                .segments
                .last()
                .is_some_and(|segment| segment.from >= t)
        {
            self.pop();
        }
        if let Some(segment) = self.segments.last_mut() {
            segment.to = segment.to.min(t);
        }
    }
}
