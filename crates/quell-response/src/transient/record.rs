//! Reading signals from one or several trajectories: the functions that criteria and reports are made of.

use super::chebyshev::nodes;
use super::dynamics::Dynamics;
use super::event::{Condition, Direction};
use super::search::{minimum, root};
use super::trajectory::Trajectory;

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

/// What is integrated over time.
#[derive(Debug, Clone, Copy)]
enum Integrand {
    Signal(usize),
    Square(usize),
    /// a ḃ.
    Over(usize, usize),
}

/// Relative tolerance of quadratures.
const QUADRATURE: f64 = 1e-11;
/// Degree of panels that are made by halving others.
const HALVED: usize = 8;

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
        self.from = from.unwrap_or(begin).clamp(begin, latest);
        self.to = to.unwrap_or(end).clamp(self.from, latest);
        self.panels.clear();
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
        let samples = self.refined(condition.signal);
        let margin = |value: f64| {
            if condition.above {
                value - condition.value
            } else {
                condition.value - value
            }
        };
        let mut intervals = Vec::new();
        let mut since = None;
        for (i, &(t, value)) in samples.iter().enumerate() {
            let holds = margin(value) > 0.0;
            if holds != since.is_some() {
                let at = if i == 0 {
                    t
                } else {
                    self.crossing(
                        condition.signal,
                        condition.value,
                        samples[i - 1],
                        samples[i],
                    )
                };
                if holds {
                    since = Some(at);
                } else if let Some(since) = since.take() {
                    intervals.push((since, at));
                }
            }
        }
        if let (Some(since), Some(last)) = (since, samples.last()) {
            intervals.push((since, last.0));
        }
        intervals
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

    // ---- samples ----

    fn part_at(&self, t: f64) -> usize {
        self.parts
            .iter()
            .position(|part| t <= part.trajectory.to())
            .unwrap_or(self.parts.len() - 1)
    }

    /// Fills `values` with the signals at a time.
    fn evaluate(&mut self, part: usize, segment: Option<usize>, t: f64) {
        let Part {
            trajectory,
            dynamics,
        } = &mut self.parts[part];
        let x = &mut self.x[..trajectory.states()];
        let segment = segment.unwrap_or_else(|| trajectory.segment_at(t));
        trajectory.evaluate(segment, t, x);
        dynamics.0.watch(t, x, &mut self.values);
    }

    fn at(&mut self, signal: usize, t: f64) -> f64 {
        self.value(signal, t)
    }

    fn sample(&self, panel: &Panel, node: usize, signal: usize) -> f64 {
        if signal < self.signals {
            panel.values[node * self.signals + signal]
        } else {
            f64::NAN
        }
    }

    /// Samples the window, once.
    fn prepare(&mut self) {
        if !self.panels.is_empty() {
            return;
        }
        let mut panels = Vec::new();
        let parts = self.parts.len();
        for part in 0..parts {
            let trajectory = self.parts[part].trajectory;
            // Phases end at their event; only the last one may be read beyond.
            let most = if part + 1 < parts {
                trajectory.to()
            } else {
                trajectory.last()
            };
            let to = self.to.min(most);
            for (index, segment) in trajectory.segments().iter().enumerate() {
                let (a, b) = (segment.from.max(self.from), segment.to.min(to));
                if a < b {
                    let whole = a == segment.from
                        && b >= segment.from + segment.length * (1.0 - 1e-15)
                        && segment.degree >= 4;
                    let degree = segment.degree.max(6);
                    let panel = if whole {
                        self.whole(part, index, b)
                    } else {
                        self.panel(part, index, (a, b), degree)
                    };
                    panels.push(panel);
                }
            }
        }
        if panels.is_empty() {
            // An empty window still has a value.
            let part = self.part_at(self.from);
            let segment = self.parts[part].trajectory.segment_at(self.from);
            panels.push(self.panel(part, segment, (self.from, self.from), 2));
        }
        self.panels = panels;
    }

    /// The panel of a whole step, whose states need no interpolation.
    fn whole(&mut self, part: usize, index: usize, to: f64) -> Panel {
        let Part {
            trajectory,
            dynamics,
        } = &mut self.parts[part];
        let segment = trajectory.segments()[index];
        let points = &nodes(segment.degree).points;
        let n = trajectory.states();
        let mut values = Vec::with_capacity(points.len() * self.signals);
        let rows = trajectory.node_values(index).chunks_exact(n.max(1));
        for (point, x) in points.iter().zip(rows) {
            let t = segment.from + point * segment.length;
            dynamics.0.watch(t, x, &mut self.values);
            values.extend_from_slice(&self.values[..self.signals]);
        }
        Panel {
            part,
            segment: index,
            from: segment.from,
            to,
            degree: segment.degree,
            values,
        }
    }

    fn panel(
        &mut self,
        part: usize,
        segment: usize,
        (from, to): (f64, f64),
        degree: usize,
    ) -> Panel {
        let points = &nodes(degree).points;
        let mut values = Vec::with_capacity(points.len() * self.signals);
        for point in points {
            self.evaluate(part, Some(segment), from + point * (to - from));
            values.extend_from_slice(&self.values[..self.signals]);
        }
        Panel {
            part,
            segment,
            from,
            to,
            degree,
            values,
        }
    }

    // ---- extrema ----

    fn lowest(&mut self, signal: usize, sign: f64) -> Extremum {
        let samples = self.samples(signal);
        let value = |i: usize| sign * samples[i].1;
        let last = samples.len() - 1;
        let best = (0..=last).fold(0, |best, i| if value(i) < value(best) { i } else { best });
        let mut result = (samples[best].0, value(best));
        let lowest = result.1;
        for i in 0..=last {
            let (left, right) = (i.saturating_sub(1), (i + 1).min(last));
            if value(i) > value(left) || value(i) > value(right) {
                continue;
            }
            // The true minimum lies below the sample by less than the samples around it lie above.
            let variation = (value(left) - value(i)).max(value(right) - value(i));
            if value(i) - variation > lowest {
                continue;
            }
            if let Some(found) = self.refine(signal, sign, &samples, i)
                && found.1 < result.1
            {
                result = found;
            }
        }
        Extremum {
            t: result.0,
            value: result.1,
        }
    }

    /// The minimum of sign·s near a lowest sample; none where it is the sample itself, at an end.
    fn refine(
        &mut self,
        signal: usize,
        sign: f64,
        samples: &[(f64, f64)],
        i: usize,
    ) -> Option<(f64, f64)> {
        let last = samples.len() - 1;
        let (mut left, mut right) = (samples[i.saturating_sub(1)], samples[(i + 1).min(last)]);
        let mut middle = (samples[i].0, sign * samples[i].1);
        if left.0 >= right.0 {
            return None;
        }
        if left.0 >= middle.0 || middle.0 >= right.0 {
            // At an end (of the window, or of a piece where the signal jumps): does it go down into the interval?
            let inward = if left.0 >= middle.0 { right.0 } else { left.0 };
            let probe = middle.0 + 1e-3 * (inward - middle.0);
            let value = sign * self.at(signal, probe);
            if value >= middle.1 {
                return None;
            }
            (left.0, right.0) = (middle.0.min(inward), middle.0.max(inward));
            middle = (probe, value);
        }
        let (mut t, mut value) = minimum((left.0, right.0), middle, f64::NEG_INFINITY, |t| {
            sign * self.at(signal, t)
        });
        if middle.1 < value {
            (t, value) = middle;
        }
        Some((t, value))
    }

    /// Alternating extremes of the samples with ripples left out; `sign` 1 gives maxima, -1 minima, refined.
    fn turning_points(&mut self, signal: usize, sign: f64) -> Vec<Extremum> {
        let samples = self.samples(signal);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for &(_, value) in &samples {
            low = low.min(value);
            high = high.max(value);
        }
        let ripple = 1e-9 * (high - low);
        let value = |i: usize| sign * samples[i].1;
        let mut turning = Vec::new();
        // Going up, `top` is the highest sample since the last low; a fall by more than a ripple makes it a peak.
        let (mut top, mut bottom, mut rising) = (0, 0, None);
        for i in 1..samples.len() {
            if value(i) > value(top) {
                top = i;
            }
            if value(i) < value(bottom) {
                bottom = i;
            }
            if rising != Some(false) && value(top) - value(i) > ripple {
                if rising == Some(true) {
                    turning.push(top);
                }
                rising = Some(false);
                bottom = i;
                top = i;
            } else if rising != Some(true) && value(i) - value(bottom) > ripple {
                rising = Some(true);
                top = i;
                bottom = i;
            }
            if rising == Some(false) {
                top = bottom;
            }
            if rising == Some(true) {
                bottom = top;
            }
        }
        turning
            .into_iter()
            .map(|i| {
                let (t, value) = self
                    .refine(signal, -sign, &samples, i)
                    .unwrap_or((samples[i].0, -sign * samples[i].1));
                Extremum {
                    t,
                    value: -sign * value,
                }
            })
            .collect()
    }

    /// Samples with the refined local extremes among them, so that every sign change of s - level lies between neighbours.
    fn refined(&mut self, signal: usize) -> Vec<(f64, f64)> {
        let mut samples = self.samples(signal);
        let mut extremes = self.turning_points(signal, 1.0);
        extremes.extend(self.turning_points(signal, -1.0));
        // Extremes may hide in the first and the last interval too.
        let last = samples.len() - 1;
        for i in [0, last] {
            for sign in [1.0, -1.0] {
                if let Some((t, value)) = self.refine(signal, sign, &samples, i) {
                    extremes.push(Extremum {
                        t,
                        value: sign * value,
                    });
                }
            }
        }
        samples.extend(extremes.iter().map(|extreme| (extreme.t, extreme.value)));
        samples.sort_by(|a, b| a.0.total_cmp(&b.0));
        samples
    }

    fn crossing(
        &mut self,
        signal: usize,
        level: f64,
        before: (f64, f64),
        after: (f64, f64),
    ) -> f64 {
        let (a, b) = (before.1 - level, after.1 - level);
        if before.0 >= after.0 || a == 0.0 {
            return before.0;
        }
        if b == 0.0 {
            return after.0;
        }
        root((before.0, a), (after.0, b), 0.0, |t| {
            self.at(signal, t) - level
        })
        .far
    }

    // ---- quadrature ----

    fn estimate(&self, panel: &Panel, integrand: Integrand) -> (Integral, f64) {
        let nodes = nodes(panel.degree);
        let length = panel.to - panel.from;
        let points = nodes.points.len();
        let mut extra = 0.0;
        let values: Vec<f64> = match integrand {
            Integrand::Signal(s) => (0..points).map(|j| self.sample(panel, j, s)).collect(),
            Integrand::Square(s) => (0..points)
                .map(|j| self.sample(panel, j, s).powi(2))
                .collect(),
            Integrand::Over(a, b) => {
                if a >= self.signals || b >= self.signals || length <= 0.0 {
                    vec![if length > 0.0 { f64::NAN } else { 0.0 }; points]
                } else {
                    let slopes = nodes.slopes(&panel.values, self.signals, b);
                    let a: Vec<f64> = (0..points).map(|j| self.sample(panel, j, a)).collect();
                    // ∫ a (b - p)' = -∫ a' (b - p), p through b: what is missed is at most the variation of a times b - p.
                    let (low, high) = a.iter().fold((f64::MAX, f64::MIN), |(low, high), value| {
                        (low.min(*value), high.max(*value))
                    });
                    let tail = nodes.tail(&panel.values, self.signals, b);
                    extra = (high - low) * (tail[1] + tail[2]);
                    a.iter().zip(&slopes).map(|(a, b)| a * b / length).collect()
                }
            }
        };
        let sum = |f: &dyn Fn(f64) -> f64| -> f64 {
            length
                * nodes
                    .weights
                    .iter()
                    .zip(&values)
                    .map(|(weight, value)| weight * f(*value))
                    .sum::<f64>()
        };
        let tail = nodes.tail(&values, 1, 0);
        // Coefficients after the last one integrate to about 2/N² of their size.
        let order = (nodes.degree * nodes.degree) as f64;
        let error = length * (tail[1] + tail[2]) * 2.0 / order + extra;
        let integral = Integral {
            value: sum(&|value| value),
            error,
        };
        (integral, sum(&f64::abs))
    }

    fn integrate(&mut self, integrand: Integrand) -> Integral {
        self.prepare();
        let mut estimates: Vec<(Integral, f64)> = Vec::with_capacity(self.panels.len());
        for panel in &self.panels {
            estimates.push(self.estimate(panel, integrand));
        }
        let total: f64 = estimates.iter().map(|estimate| estimate.1).sum();
        let allowed = QUADRATURE * total / self.panels.len() as f64;
        let mut result = Integral::default();
        for (index, &(estimate, _)) in estimates.iter().enumerate() {
            if estimate.error <= allowed || !estimate.error.is_finite() {
                result.value += estimate.value;
                result.error += estimate.error;
                continue;
            }
            let panel = &self.panels[index];
            let (part, segment) = (panel.part, panel.segment);
            let mut stack = vec![(panel.from, panel.to, 0)];
            while let Some((from, to, depth)) = stack.pop() {
                let middle = 0.5 * (from + to);
                for (a, b) in [(from, middle), (middle, to)] {
                    let half = self.panel(part, segment, (a, b), HALVED);
                    let (estimate, _) = self.estimate(&half, integrand);
                    let share = allowed * (0.5_f64).powi(depth + 1);
                    if estimate.error <= share.max(f64::EPSILON * total) || depth >= 40 {
                        result.value += estimate.value;
                        result.error += estimate.error;
                    } else {
                        stack.push((a, b, depth + 1));
                    }
                }
            }
        }
        result
    }
}
