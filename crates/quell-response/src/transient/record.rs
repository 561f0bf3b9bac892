//! Reading signals from one or several trajectories: the functions that criteria and reports are made of.

mod excursions;
mod extrema;
mod quadrature;
mod samples;

use super::chebyshev::nodes;
use super::dynamics::Dynamics;
use super::event::{Condition, Direction};
use super::trajectory::Trajectory;

pub use excursions::Excursion;
use quadrature::Integrand;

/// Where a signal is largest or smallest, and how large it is there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extremum {
    /// When, s.
    pub t: f64,
    /// The value.
    pub value: f64,
}

/// An integral and an estimate of its error of quadrature.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Integral {
    /// The integral.
    pub value: f64,
    /// What quadrature may have missed; the error of the solution itself is not in it.
    pub error: f64,
}

#[derive(Debug)]
struct Part<'a> {
    trajectory: &'a Trajectory,
    dynamics: DynamicsOf<'a>,
}

struct DynamicsOf<'a>(&'a mut dyn Dynamics);

impl std::fmt::Debug for DynamicsOf<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("dyn Dynamics")
    }
}

/// A stretch of one step with all signals at its Chebyshev-Lobatto points, node-major.
#[derive(Debug, Clone)]
struct Panel {
    part: usize,
    segment: usize,
    from: f64,
    to: f64,
    degree: usize,
    values: Vec<f64>,
}

/// Signals of a run, as functions of time over a window.
///
/// A record joins trajectories with the systems that they belong to, because signals are evaluated where they are needed, on
/// the dense output, and not interpolated between samples. The phases of one run, with the same signals in the same order,
/// are joined by [`then`](Self::then). The window is the whole run without its continuation; [`between`](Self::between) sets
/// another one.
///
/// All functions take the index of a signal. A signal that does not exist reads as NaN. Extrema and zeros are found between
/// samples that every step has 7 to 13 of, and refined on the signal itself: a signal that goes up and down twice between two
/// such samples hides an extremum, one that the solution resolves does not.
#[derive(Debug)]
pub struct Record<'a> {
    parts: Vec<Part<'a>>,
    from: f64,
    to: f64,
    signals: usize,
    panels: Vec<Panel>,
    x: Vec<f64>,
    values: Vec<f64>,
}

impl<'a> Record<'a> {
    /// The record of one trajectory; `dynamics` is what it was computed with.
    pub fn new(trajectory: &'a Trajectory, dynamics: &'a mut dyn Dynamics) -> Self {
        let signals = dynamics.signals();
        Self {
            from: trajectory.from(),
            to: trajectory.to(),
            signals,
            panels: Vec::new(),
            x: vec![0.0; trajectory.states()],
            values: vec![f64::NAN; signals],
            parts: vec![Part {
                trajectory,
                dynamics: DynamicsOf(dynamics),
            }],
        }
    }

    /// Followed by a further phase. The window is the whole run again.
    #[must_use]
    pub fn then(mut self, trajectory: &'a Trajectory, dynamics: &'a mut dyn Dynamics) -> Self {
        self.to = trajectory.to();
        self.from = self
            .parts
            .first()
            .map_or(self.from, |part| part.trajectory.from());
        self.signals = self.signals.min(dynamics.signals());
        let states = self.x.len().max(trajectory.states());
        let most = self.values.len().max(dynamics.signals());
        self.x.resize(states, 0.0);
        self.values.resize(most, f64::NAN);
        self.panels.clear();
        self.parts.push(Part {
            trajectory,
            dynamics: DynamicsOf(dynamics),
        });
        self
    }

    /// Sets the window, clamped to what the trajectories cover (a continuation after the end event included). `None` is the end of
    /// the run that lies on that side.
    pub fn between(&mut self, from: Option<f64>, to: Option<f64>) -> &mut Self {
        let Some((first, last)) = self.parts.first().zip(self.parts.last()) else {
            return self;
        };
        let (begin, end) = (first.trajectory.from(), last.trajectory.to());
        let latest = last.trajectory.last();
        let window = self.window();
        self.from = from.unwrap_or(begin).clamp(begin, latest);
        self.to = to.unwrap_or(end).clamp(self.from, latest);
        if self.window() != window {
            self.panels.clear();
        }
        self
    }

    /// The window, s.
    pub fn window(&self) -> (f64, f64) {
        (self.from, self.to)
    }

    /// Value of a signal at a time.
    pub fn value(&mut self, signal: usize, t: f64) -> f64 {
        let part = self.part_at(t);
        self.evaluate(part, None, t);
        self.values.get(signal).copied().unwrap_or(f64::NAN)
    }

    /// All signals at a time.
    pub fn values(&mut self, t: f64) -> &[f64] {
        let part = self.part_at(t);
        self.evaluate(part, None, t);
        &self.values[..self.signals]
    }

    /// States at a time (those of the phase that holds it; of the earlier one at a junction).
    pub fn state(&self, t: f64) -> Vec<f64> {
        self.parts[self.part_at(t)].trajectory.state(t)
    }

    /// Times at which the solution is kept, between which it is smooth: a curve through them looks like the solution.
    pub fn times(&mut self) -> Vec<f64> {
        self.samples(0).into_iter().map(|(t, _)| t).collect()
    }

    /// A signal at [`times`](Self::times): (t, value).
    pub fn samples(&mut self, signal: usize) -> Vec<(f64, f64)> {
        self.prepare();
        let mut samples: Vec<(f64, f64)> = Vec::new();
        for panel in &self.panels {
            let points = &nodes(panel.degree).points;
            for (j, point) in points.iter().enumerate() {
                let t = panel.from + point * (panel.to - panel.from);
                let value = self.sample(panel, j, signal);
                let again = samples
                    .last()
                    .is_some_and(|last| j == 0 && last.0 == t && last.1 == value);
                if !again {
                    samples.push((t, value));
                }
            }
        }
        samples
    }

    /// max s(t) over the window. The value is accurate to rounding of the dense output, the time to its square root.
    pub fn maximum(&mut self, signal: usize) -> Extremum {
        let lowest = self.lowest(signal, -1.0);
        Extremum {
            value: -lowest.value,
            ..lowest
        }
    }

    /// min s(t) over the window; accuracy as [`maximum`](Self::maximum).
    pub fn minimum(&mut self, signal: usize) -> Extremum {
        self.lowest(signal, 1.0)
    }

    /// max |s(t)| over the window, with the sign of s kept.
    pub fn largest(&mut self, signal: usize) -> Extremum {
        let (high, low) = (self.maximum(signal), self.minimum(signal));
        if high.value.abs() >= low.value.abs() {
            high
        } else {
            low
        }
    }

    /// Local maxima inside the window in order of time. Ripples below 1e-9 of the range of the signal do not count.
    pub fn peaks(&mut self, signal: usize) -> Vec<Extremum> {
        self.turning_points(signal, 1.0)
    }

    /// Local minima inside the window in order of time, as [`peaks`](Self::peaks).
    pub fn troughs(&mut self, signal: usize) -> Vec<Extremum> {
        self.turning_points(signal, -1.0)
    }

    /// The n-th peak, counted from 1; `None` where there are fewer.
    pub fn peak(&mut self, signal: usize, n: usize) -> Option<Extremum> {
        n.checked_sub(1)
            .and_then(|index| self.peaks(signal).get(index).copied())
    }

    /// Times at which s(t) goes through a level, located to rounding.
    pub fn crossings(&mut self, signal: usize, level: f64, direction: Direction) -> Vec<f64> {
        let samples = self.refined(signal);
        let mut times = Vec::new();
        for pair in samples.windows(2) {
            let (before, after) = (pair[0].1 - level, pair[1].1 - level);
            let rises = before < 0.0 && after >= 0.0;
            let falls = before > 0.0 && after <= 0.0;
            let wanted = match direction {
                Direction::Rising => rises,
                Direction::Falling => falls,
                Direction::Either => rises || falls,
            };
            if wanted {
                times.push(self.crossing(signal, level, pair[0], pair[1]));
            }
        }
        times
    }

    /// The first time in the window at which a condition holds; `None` where it never does.
    pub fn first(&mut self, condition: Condition) -> Option<f64> {
        self.holds(condition).first().map(|interval| interval.0)
    }

    /// The last time in the window at which a condition holds; `None` where it never does.
    pub fn last(&mut self, condition: Condition) -> Option<f64> {
        self.holds(condition).last().map(|interval| interval.1)
    }

    /// For how long, s, a condition holds within the window.
    pub fn duration(&mut self, condition: Condition) -> f64 {
        self.holds(condition)
            .iter()
            .map(|interval| interval.1 - interval.0)
            .sum()
    }

    /// The intervals of time in which a condition holds.
    pub fn holds(&mut self, condition: Condition) -> Vec<(f64, f64)> {
        self.excursions(condition)
            .iter()
            .map(|excursion| (excursion.from, excursion.to))
            .collect()
    }

    /// Settling time: the least t, counted from the start of the window, after which |s - target| ≤ band until its end. `None` where
    /// the signal is outside of the band at the end.
    pub fn settling(&mut self, signal: usize, target: f64, band: f64) -> Option<f64> {
        let samples = self.refined(signal);
        let outside = |value: f64| (value - target).abs() > band;
        let Some(last) = samples.iter().rposition(|sample| outside(sample.1)) else {
            return Some(0.0);
        };
        let (before, after) = (samples[last], *samples.get(last + 1)?);
        let level = target + band.copysign(before.1 - target);
        Some(self.crossing(signal, level, before, after) - self.from)
    }

    /// ∫ s dt over the window: Clenshaw-Curtis quadrature on every step, halved where the last Chebyshev coefficients of the signal
    /// say so, to 1e-11 of ∫ |s| dt.
    pub fn integral(&mut self, signal: usize) -> Integral {
        self.integrate(Integrand::Signal(signal))
    }

    /// ∫ a db = ∫ a(t) ḃ(t) dt over the window, with ḃ the derivative of the polynomial through b on every step; accuracy as
    /// [`integral`](Self::integral). The work of a force `a` over a displacement `b`, for instance.
    pub fn integral_over(&mut self, a: usize, b: usize) -> Integral {
        self.integrate(Integrand::Over(a, b))
    }

    /// Mean over the window, (1/T) ∫ s dt; the value itself where the window is empty.
    pub fn mean(&mut self, signal: usize) -> f64 {
        let length = self.to - self.from;
        if length > 0.0 {
            self.integral(signal).value / length
        } else {
            self.value(signal, self.from)
        }
    }

    /// Root of the mean square over the window, √((1/T) ∫ s² dt).
    pub fn rms(&mut self, signal: usize) -> f64 {
        let length = self.to - self.from;
        if length > 0.0 {
            (self.integrate(Integrand::Square(signal)).value / length)
                .max(0.0)
                .sqrt()
        } else {
            self.value(signal, self.from).abs()
        }
    }
}
