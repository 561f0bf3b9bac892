//! Watching the steps for crossings of switches and events.

use super::dynamics::Dynamics;
use super::event::{Crossing, Direction, Event, Grazing, Occurrence, Touch, Watched};
use super::integrator::Step;
use super::trajectory::Trajectory;

use super::chebyshev::nodes;

/// The switches and events of a run, with the samples of the present step.
#[derive(Debug)]
pub(crate) struct Monitor<'a> {
    events: &'a [Event],
    tolerance: f64,
    signals: usize,
    switches: usize,
    watched_events: Vec<Watched>,
    watched_conditions: Vec<Watched>,
    watched_switches: Vec<Watched>,
    /// The switches before the present step.
    before_step: Vec<Watched>,
    armed: Vec<bool>,
    touches: Vec<(usize, Touch)>,
    /// Present step: times and, per time, all signals and all switching functions.
    times: Vec<f64>,
    signal_samples: Vec<f64>,
    switch_samples: Vec<f64>,
    // Work space.
    x: Vec<f64>,
    values: Vec<f64>,
    samples: Vec<(f64, f64)>,
}

/// Something found in a step.
#[derive(Debug, Clone, Copy)]
enum Found {
    Armed(usize),
    Crossed(usize, Crossing),
    Touched(usize, Touch),
}

/// Evaluates one of the functions on the solution.
fn at(
    dynamics: &mut dyn Dynamics,
    trajectory: &Trajectory,
    x: &mut [f64],
    values: &mut [f64],
    t: f64,
) {
    trajectory.state_into(t, x);
    dynamics.watch(t, x, values);
}

impl<'a> Monitor<'a> {
    pub(crate) fn new(
        events: &'a [Event],
        signals: usize,
        switches: usize,
        states: usize,
        tolerance: f64,
    ) -> Self {
        Self {
            events,
            tolerance,
            signals,
            switches,
            watched_events: vec![Watched::default(); events.len()],
            watched_conditions: vec![Watched::default(); events.len()],
            watched_switches: vec![Watched::default(); switches],
            before_step: vec![Watched::default(); switches],
            armed: events.iter().map(|event| event.armed.is_none()).collect(),
            touches: Vec::new(),
            times: Vec::new(),
            signal_samples: Vec::new(),
            switch_samples: Vec::new(),
            x: vec![0.0; states],
            values: vec![0.0; signals.max(switches)],
            samples: Vec::new(),
        }
    }

    /// The last step was taken back: switches are as before it.
    pub(crate) fn take_back(&mut self) {
        self.watched_switches.copy_from_slice(&self.before_step);
    }

    /// Evaluates everything at the points of a step that has been pushed.
    pub(crate) fn sample(
        &mut self,
        dynamics: &mut dyn Dynamics,
        trajectory: &Trajectory,
        step: &Step<'_>,
    ) {
        if self.events.is_empty() && self.switches == 0 {
            return;
        }
        let n = trajectory.states();
        self.times.clear();
        self.signal_samples.clear();
        self.switch_samples.clear();
        let points = &nodes(step.degree).points;
        let whole = step.to >= step.from + step.length * (1.0 - 1e-15);
        for (j, (&point, row)) in points.iter().zip(step.values.chunks_exact(n)).enumerate() {
            let last = j == step.degree;
            let t = step.from + point * step.length;
            if last && whole {
                self.take(dynamics, step.to, row);
            } else if t >= step.to || last {
                let mut x = std::mem::take(&mut self.x);
                trajectory.state_into(step.to, &mut x);
                self.take(dynamics, step.to, &x);
                self.x = x;
                break;
            } else {
                self.take(dynamics, t, row);
            }
        }
    }

    fn take(&mut self, dynamics: &mut dyn Dynamics, t: f64, x: &[f64]) {
        self.times.push(t);
        if !self.events.is_empty() {
            let values = &mut self.values[..self.signals];
            dynamics.watch(t, x, values);
            self.signal_samples.extend_from_slice(values);
        }
        if self.switches > 0 {
            let values = &mut self.values[..self.switches];
            dynamics.switch_values(t, x, values);
            self.switch_samples.extend_from_slice(values);
        }
    }

    /// The first switch crossed in the step, if any. What comes after it in the step is not looked at.
    pub(crate) fn switch(
        &mut self,
        dynamics: &mut dyn Dynamics,
        trajectory: &Trajectory,
    ) -> Option<(usize, Crossing)> {
        let count = self.switches;
        self.before_step.copy_from_slice(&self.watched_switches);
        let mut first: Option<(usize, Crossing)> = None;
        for k in 0..count {
            self.samples.clear();
            self.samples.extend(
                self.times
                    .iter()
                    .zip(self.switch_samples.chunks_exact(count))
                    .map(|(&t, values)| (t, values[k])),
            );
            let mut watched = self.watched_switches[k];
            let (x, values) = (&mut self.x, &mut self.values[..count]);
            watched.scan(
                &self.samples,
                0.0,
                |t| {
                    trajectory.state_into(t, x);
                    dynamics.switch_values(t, x, values);
                    values[k]
                },
                |crossing| {
                    if first.is_none_or(|(_, earlier)| crossing.far < earlier.far) {
                        first = Some((k, crossing));
                    }
                },
                |_| {},
            );
            self.watched_switches[k] = watched;
        }
        if let Some((crossed, crossing)) = first {
            let t = crossing.far;
            let (x, values) = (&mut self.x, &mut self.values[..count]);
            trajectory.state_into(t, x);
            dynamics.switch_values(t, x, values);
            for (k, watched) in self.watched_switches.iter_mut().enumerate() {
                let scale = watched.scale;
                *watched = self.before_step[k];
                watched.scale = scale;
                watched.go_on(t, values[k]);
                if k == crossed {
                    watched.sign = if crossing.rising { 1.0 } else { -1.0 };
                }
            }
        }
        first
    }

    /// Finds the events of the step up to `until`, records them, and returns the first that ends the run.
    pub(crate) fn events(
        &mut self,
        dynamics: &mut dyn Dynamics,
        trajectory: &mut Trajectory,
        until: Option<f64>,
    ) -> Option<(usize, f64)> {
        if self.events.is_empty() {
            return None;
        }
        let count = self.signals;
        if let Some(until) = until {
            let keep = self.times.partition_point(|&t| t < until);
            self.times.truncate(keep);
            self.signal_samples.truncate(keep * count);
            let (x, values) = (&mut self.x, &mut self.values[..count]);
            at(dynamics, trajectory, x, values, until);
            self.times.push(until);
            self.signal_samples.extend_from_slice(values);
        }
        let begin = self.times.first().copied().unwrap_or_default();
        let mut found: Vec<(f64, Found)> = Vec::new();
        for (e, event) in self.events.iter().enumerate() {
            if let (false, Some(condition)) = (self.armed[e], event.armed) {
                self.fill(|values| condition.margin(values));
                let mut watched = self.watched_conditions[e];
                let unknown = watched.sign == 0.0;
                let mut fell_first = None;
                let (x, values) = (&mut self.x, &mut self.values[..count]);
                watched.scan(
                    &self.samples,
                    self.tolerance,
                    |t| {
                        at(dynamics, trajectory, x, values, t);
                        condition.margin(values)
                    },
                    |crossing| {
                        fell_first.get_or_insert(!crossing.rising);
                        if crossing.rising {
                            found.push((crossing.far, Found::Armed(e)));
                        }
                    },
                    |_| {},
                );
                // It left zero upwards, so it held from the start on.
                if unknown && fell_first.unwrap_or(watched.sign > 0.0) {
                    found.push((begin, Found::Armed(e)));
                }
                self.watched_conditions[e] = watched;
            }
            self.fill(|values| values[event.signal] - event.level);
            let mut watched = self.watched_events[e];
            let (x, values) = (&mut self.x, &mut self.values[..count]);
            let list = std::cell::RefCell::new(&mut found);
            watched.scan(
                &self.samples,
                self.tolerance,
                |t| {
                    at(dynamics, trajectory, x, values, t);
                    values[event.signal] - event.level
                },
                |crossing| {
                    list.borrow_mut()
                        .push((crossing.far, Found::Crossed(e, crossing)));
                },
                |touch| list.borrow_mut().push((touch.t, Found::Touched(e, touch))),
            );
            self.watched_events[e] = watched;
        }
        if found.is_empty() {
            return None;
        }
        // Stable: simultaneous events stay in the order of the list.
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut ending = None;
        let mut armed_at = vec![f64::NEG_INFINITY; self.events.len()];
        for (t, found) in found {
            match found {
                Found::Armed(e) => {
                    if !self.armed[e] {
                        self.armed[e] = true;
                        armed_at[e] = t;
                    }
                }
                Found::Touched(e, touch) => {
                    if self.armed[e] {
                        self.touches.push((e, touch));
                    }
                }
                Found::Crossed(e, crossing) => {
                    let event = &self.events[e];
                    let wanted = match event.direction {
                        Direction::Rising => crossing.rising,
                        Direction::Falling => !crossing.rising,
                        Direction::Either => true,
                    };
                    if wanted && self.armed[e] && t > armed_at[e] {
                        trajectory.occurrences.push(Occurrence {
                            event: e,
                            t,
                            rising: crossing.rising,
                            depth: self.height(dynamics, trajectory, event, t),
                            grazing: false,
                        });
                        if event.ends && ending.is_none() && trajectory.ended.is_none() {
                            ending = Some((e, t));
                        }
                    }
                }
            }
        }
        ending
    }

    fn fill(&mut self, g: impl Fn(&[f64]) -> f64) {
        self.samples.clear();
        self.samples.extend(
            self.times
                .iter()
                .zip(self.signal_samples.chunks_exact(self.signals))
                .map(|(&t, values)| (t, g(values))),
        );
    }

    /// |ġ²/(2 g̈)| at a crossing, from the parabola through three points of the step around it.
    fn height(
        &mut self,
        dynamics: &mut dyn Dynamics,
        trajectory: &Trajectory,
        event: &Event,
        t: f64,
    ) -> f64 {
        let index = trajectory.segment_at(t);
        let segment = trajectory.segments()[index];
        let h = 0.02 * segment.length;
        if h <= 0.0 {
            return f64::INFINITY;
        }
        let middle = t.clamp(segment.from + h, segment.from + segment.length - h);
        let mut g = [0.0; 3];
        for (g, t) in g.iter_mut().zip([middle - h, middle, middle + h]) {
            trajectory.evaluate(index, t, &mut self.x);
            let values = &mut self.values[..self.signals];
            dynamics.watch(t, &self.x, values);
            *g = values[event.signal] - event.level;
        }
        let bend = (g[2] - 2.0 * g[1] + g[0]) / (h * h);
        let slope = (g[2] - g[0]) / (2.0 * h) + bend * (t - middle);
        if bend == 0.0 {
            f64::INFINITY
        } else {
            slope * slope / (2.0 * bend.abs())
        }
    }

    /// Takes back what was found after the end of the run, but for what happened together with it.
    pub(crate) fn forget_after(&mut self, trajectory: &mut Trajectory, limit: f64) {
        let together = limit + self.tolerance + 8.0 * f64::EPSILON * limit.abs();
        trajectory
            .occurrences
            .retain(|occurrence| occurrence.t <= together);
        self.touches.retain(|(_, touch)| touch.t <= together);
    }

    /// Relates heights and touches to the largest sizes of the run.
    pub(crate) fn finish(&mut self, trajectory: &mut Trajectory, grazing: f64) {
        for occurrence in &mut trajectory.occurrences {
            let scale = self.watched_events[occurrence.event].scale;
            occurrence.depth /= scale;
            occurrence.grazing = occurrence.depth <= grazing;
        }
        for &(event, touch) in &self.touches {
            let margin = touch.size / self.watched_events[event].scale;
            if margin <= grazing {
                trajectory.grazings.push(Grazing {
                    event,
                    t: touch.t,
                    margin,
                    crossed: touch.crossed,
                });
            }
        }
    }
}
