//! The run: smooth pieces one after the other.

use std::ops::ControlFlow;

use super::dynamics::Dynamics;
use super::event::Event;
use super::integrator::{Ending, Method, Piece, Scheme, Step, Visit};
use super::library;
use super::monitor::Monitor;
use super::propagation::Exact;
use super::simulation::{Progress, Settings, spectrum};
use super::trajectory::{End, Trajectory};

/// Why a piece was left.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Left {
    /// It was not; or the integrator itself came to its end.
    Not,
    /// A switch was crossed: a new piece begins there.
    Switched { switch: usize },
    /// A switch at which the rates jump was crossed at about `at`, in a step that was taken back.
    Jump { at: f64 },
    /// Stability dictates the steps.
    Stiff,
    /// The run is over.
    Over,
}

pub(crate) struct Run<'a> {
    settings: &'a Settings,
    progress: &'a mut dyn FnMut(Progress) -> ControlFlow<()>,
    from: f64,
    /// Where it ends at the latest; an event that ends it brings this nearer.
    limit: f64,
    length: f64,
    /// Times over which no step goes, in order.
    stops: Vec<f64>,
    bound: f64,
    trajectory: Trajectory,
    monitor: Monitor<'a>,
    left: Left,
    /// A jump within the step is taken as it is.
    bridging: bool,
    /// Steps since the last look at stiffness, and how many looks in a row found it.
    unlooked: usize,
    stiff_looks: usize,
}

/// Steps between two looks at whether stability dictates the steps.
const LOOK: usize = 200;

impl<'a> Run<'a> {
    pub(crate) fn new(
        dynamics: &mut dyn Dynamics,
        start: &[f64],
        (from, to): (f64, f64),
        events: &'a [Event],
        settings: &'a Settings,
        progress: &'a mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Self {
        let mut stops = dynamics.breakpoints();
        stops.extend(&settings.restarts);
        stops.retain(|stop| *stop > from && *stop < to);
        stops.sort_by(f64::total_cmp);
        let largest = start
            .iter()
            .fold(1.0_f64, |largest, value| largest.max(value.abs()));
        Self {
            settings,
            progress,
            from,
            limit: to,
            length: to - from,
            stops,
            bound: settings.divergence * largest,
            trajectory: Trajectory::new(from, start),
            monitor: Monitor::new(
                events,
                dynamics.signals(),
                dynamics.switches(),
                start.len(),
                settings.event_tolerance * (to - from),
            ),
            left: Left::Not,
            bridging: false,
            unlooked: 0,
            stiff_looks: 0,
        }
    }

    /// Piece after piece until the run is over.
    pub(crate) fn go(&mut self, dynamics: &mut dyn Dynamics, absolute: &[f64]) {
        self.pieces(dynamics, absolute);
        dynamics.within(None);
    }

    /// How far a piece that begins now may go: to the next stop, or to the end.
    fn reach(&self, begin: f64) -> f64 {
        let rounding = 8.0 * f64::EPSILON * begin.abs().max(self.length);
        let next = self.stops.partition_point(|stop| *stop <= begin + rounding);
        self.stops
            .get(next)
            .map_or(self.limit, |stop| stop.min(self.limit))
    }

    fn pieces(&mut self, dynamics: &mut dyn Dynamics, absolute: &[f64]) {
        let n = self.trajectory.states();
        let mut exact = Exact::default();
        let (mut a, mut b) = (vec![0.0; n * n], vec![0.0; n]);
        let mut chosen = None;
        let mut short = 0;
        loop {
            let begin = self.trajectory.last();
            let x = self.trajectory.state(begin);
            self.left = Left::Not;
            let reach = self.reach(begin);
            dynamics.within(Some((begin, reach)));
            let piece = Piece {
                t: begin,
                x: &x,
                limit: reach,
                scale: self.length,
                relative: self.settings.relative,
                absolute,
                longest: self.length,
            };
            let affine = self.settings.method == Method::Automatic
                && affine(dynamics, &piece, &mut a, &mut b);
            let mut scheme = Scheme::Exact;
            let ending = if affine {
                exact.run(dynamics, &a, &b, &piece, self)
            } else {
                scheme = match self.settings.method {
                    Method::Explicit => Scheme::Tsit45,
                    Method::Stiff => Scheme::Bdf,
                    Method::StiffOscillating => Scheme::Esdirk34,
                    Method::Automatic => *chosen
                        .get_or_insert_with(|| choose(dynamics, begin, &x, self.limit - begin)),
                };
                library::run(dynamics, &piece, scheme, self)
            };
            match (self.left, ending) {
                (Left::Switched { switch }, _) => {
                    short = self.count_short(begin, short);
                    if short > 50 {
                        self.trajectory.end = End::Chattering { switch };
                        return;
                    }
                }
                (Left::Jump { at }, _) => {
                    self.come_near(dynamics, absolute, scheme, at);
                    match self.left {
                        Left::Switched { switch } => {
                            short = self.count_short(begin, short);
                            if short > 50 {
                                self.trajectory.end = End::Chattering { switch };
                                return;
                            }
                        }
                        Left::Over => return,
                        Left::Stiff => chosen = Some(Scheme::Bdf),
                        Left::Not | Left::Jump { .. } => {}
                    }
                }
                (Left::Stiff, _) => chosen = Some(Scheme::Bdf),
                (Left::Not, Ending::Failed { t, why }) => {
                    self.fail(dynamics, t, why);
                    return;
                }
                // At a stop, with more to come.
                (Left::Not, Ending::Reached) if self.trajectory.last() < self.limit => {
                    self.trajectory.statistics.restarts += 1;
                }
                (Left::Over | Left::Not, _) => return,
            }
        }
    }

    fn count_short(&mut self, begin: f64, short: usize) -> usize {
        self.trajectory.statistics.restarts += 1;
        if self.trajectory.last() - begin < 1e-9 * self.length {
            short + 1
        } else {
            0
        }
    }

    /// Integrates up to just before a switch at which the rates jump, so that no stage of a step lies beyond it, and goes over
    /// it in a straight line of 1e-7 of a step.
    fn come_near(
        &mut self,
        dynamics: &mut dyn Dynamics,
        absolute: &[f64],
        scheme: Scheme,
        mut at: f64,
    ) {
        for attempt in 0..12 {
            let begin = self.trajectory.last();
            let x = self.trajectory.state(begin);
            let rounding = 8.0 * f64::EPSILON * at.abs().max(self.length);
            let near = at - (1e-7 * (at - begin)).max(rounding);
            self.left = Left::Not;
            if near > begin + rounding {
                let piece = Piece {
                    t: begin,
                    x: &x,
                    limit: near,
                    scale: self.length,
                    relative: self.settings.relative,
                    absolute,
                    longest: self.length,
                };
                self.bridging = attempt > 8;
                let ending = library::run(dynamics, &piece, scheme, self);
                self.bridging = false;
                match (self.left, ending) {
                    (Left::Jump { at: earlier }, _) => {
                        at = earlier;
                        continue;
                    }
                    (Left::Not, Ending::Reached) => {}
                    (Left::Not, Ending::Failed { t, why }) => {
                        self.fail(dynamics, t, why);
                        self.left = Left::Over;
                        return;
                    }
                    _ => return,
                }
            }
            let begin = self.trajectory.last();
            let x = self.trajectory.state(begin);
            let n = x.len();
            let mut rates = vec![0.0; n];
            dynamics.rates(begin, &x, &mut rates);
            let length = 4.0 * (at - begin).max(rounding);
            let mut values = vec![0.0; 3 * n];
            for (row, part) in values.chunks_exact_mut(n).zip([0.0, 0.5, 1.0]) {
                for ((value, x), rate) in row.iter_mut().zip(&x).zip(&rates) {
                    *value = x + part * length * rate;
                }
            }
            let step = Step {
                from: begin,
                length,
                to: begin + length,
                degree: 2,
                values: &values,
                scheme,
                evaluations: 1,
            };
            self.bridging = true;
            self.visit(dynamics, &step);
            self.bridging = false;
            return;
        }
    }

    fn fail(&mut self, dynamics: &mut dyn Dynamics, t: f64, why: String) {
        let x = self.trajectory.state(t);
        let mut rates = vec![0.0; x.len()];
        dynamics.rates(t, &x, &mut rates);
        let start = self.trajectory.state(self.from);
        let size = |x: &[f64]| x.iter().fold(0.0_f64, |size, value| size.max(value.abs()));
        let grown = size(&x) > 1e6 * size(&start).max(1e-6);
        let finite = rates.iter().all(|rate| rate.is_finite());
        self.trajectory.end = if grown || !finite {
            End::Diverged
        } else {
            End::Failed { why }
        };
    }

    /// The trajectory, with its flags.
    pub(crate) fn finish(mut self) -> Trajectory {
        self.monitor
            .finish(&mut self.trajectory, self.settings.grazing);
        self.trajectory
    }

    fn over(&mut self, end: End) -> bool {
        self.trajectory.end = end;
        self.left = Left::Over;
        false
    }

    /// Whether the step length is what stability allows and not what accuracy needs.
    fn looks_stiff(&mut self, dynamics: &mut dyn Dynamics, step: &Step<'_>) -> bool {
        self.unlooked += 1;
        if self.settings.method != Method::Automatic
            || step.scheme != Scheme::Tsit45
            || self.unlooked < LOOK
        {
            return false;
        }
        let x = &step.values[step.values.len() - self.trajectory.states()..];
        let decay = decay(dynamics, step.from + step.length, x);
        if decay * step.length > 2.0 {
            self.stiff_looks += 1;
            self.unlooked = LOOK - 10;
        } else {
            self.stiff_looks = 0;
            self.unlooked = 0;
        }
        self.stiff_looks >= 5
    }
}

/// Fastest decay, 1/s, among eigenvalues that decay rather than oscillate.
fn decay(dynamics: &mut dyn Dynamics, t: f64, x: &[f64]) -> f64 {
    spectrum(dynamics, t, x)
        .iter()
        .filter(|value| value.re.abs() > value.im.abs())
        .fold(0.0_f64, |decay, value| decay.max(-value.re))
}

/// Explicit, unless stability alone (a step is at most about 3/|λ|) would ask for thousands of steps.
fn choose(dynamics: &mut dyn Dynamics, t: f64, x: &[f64], length: f64) -> Scheme {
    if decay(dynamics, t, x) * length / 3.0 > 3000.0 {
        Scheme::Bdf
    } else {
        Scheme::Tsit45
    }
}

/// The affine form at the start of a piece. On a switch it is taken a moment later, on the side to which the motion goes.
fn affine(dynamics: &mut dyn Dynamics, piece: &Piece<'_>, a: &mut [f64], b: &mut [f64]) -> bool {
    let mut switches = vec![0.0; dynamics.switches()];
    dynamics.switch_values(piece.t, piece.x, &mut switches);
    if switches.contains(&0.0) {
        let mut x = piece.x.to_vec();
        let mut rates = vec![0.0; x.len()];
        dynamics.rates(piece.t, &x, &mut rates);
        let step = 1e-9 * piece.scale;
        for (x, rate) in x.iter_mut().zip(&rates) {
            *x += step * rate;
        }
        dynamics.affine(piece.t + step, &x, a, b)
    } else {
        dynamics.affine(piece.t, piece.x, a, b)
    }
}

/// Whether the rates differ on the two sides of a switch by more than the solution changes between them, measured by their
/// size there and at the start of the step.
fn jumps(
    dynamics: &mut dyn Dynamics,
    trajectory: &Trajectory,
    start: f64,
    (near, far): (f64, f64),
) -> bool {
    let n = trajectory.states();
    let [mut first, mut before, mut after] = [vec![0.0; n], vec![0.0; n], vec![0.0; n]];
    for (t, rates) in [(start, &mut first), (near, &mut before), (far, &mut after)] {
        dynamics.rates(t, &trajectory.state(t), rates);
    }
    (0..n).any(|i| {
        let size = first[i].abs().max(before[i].abs()).max(after[i].abs());
        (before[i] - after[i]).abs() > 1e-8 * size
    })
}

impl Visit for Run<'_> {
    fn visit(&mut self, dynamics: &mut dyn Dynamics, step: &Step<'_>) -> bool {
        let statistics = &mut self.trajectory.statistics;
        statistics.evaluations += step.evaluations;
        if !step
            .values
            .iter()
            .all(|value| value.is_finite() && value.abs() <= self.bound)
        {
            return self.over(End::Diverged);
        }
        let step = Step {
            to: step.to.min(self.limit),
            ..*step
        };
        self.trajectory.push(&step);
        let statistics = &mut self.trajectory.statistics;
        statistics.steps += 1;
        if !statistics.schemes.contains(&step.scheme) {
            statistics.schemes.push(step.scheme);
        }
        let steps = statistics.steps;

        self.monitor.sample(dynamics, &self.trajectory, &step);
        let switched = self.monitor.switch(dynamics, &self.trajectory);
        if let Some((_, crossing)) = switched {
            if step.scheme != Scheme::Exact
                && !self.bridging
                && jumps(
                    dynamics,
                    &self.trajectory,
                    step.from,
                    (crossing.near, crossing.far),
                )
            {
                self.trajectory.pop();
                self.monitor.take_back();
                self.left = Left::Jump { at: crossing.far };
                return false;
            }
            self.trajectory.cut(crossing.far);
        }
        let event = self
            .monitor
            .events(dynamics, &mut self.trajectory, crossing_time(switched));
        if let Some((event, t)) = event {
            self.trajectory.ended = Some(t);
            self.trajectory.end = End::Event { event };
            self.limit = self.limit.min(t + self.settings.continuation);
        }
        let last = self.trajectory.last();
        if last >= self.limit {
            self.trajectory.cut(self.limit);
            self.monitor.forget_after(&mut self.trajectory, self.limit);
            self.left = Left::Over;
            return false;
        }
        if steps >= self.settings.step_limit {
            return self.over(End::StepLimit);
        }
        let progress = Progress {
            t: last,
            fraction: (last - self.from) / self.length,
            steps,
        };
        if (self.progress)(progress).is_break() {
            return self.over(End::Cancelled);
        }
        if let Some((switch, _)) = switched {
            self.left = Left::Switched { switch };
            return false;
        }
        if self.looks_stiff(dynamics, &step) {
            self.left = Left::Stiff;
            return false;
        }
        true
    }
}

fn crossing_time(switched: Option<(usize, super::event::Crossing)>) -> Option<f64> {
    switched.map(|(_, crossing)| crossing.far)
}
