//! Events: zeros of signals on the solution, found on its dense output.

use super::search::{Bracket, minimum, root};

/// Which way a signal goes through its level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Direction {
    /// From below to above.
    Rising,
    /// From above to below.
    Falling,
    /// Both.
    #[default]
    Either,
}

/// A signal above or below a value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Condition {
    /// Index of the signal.
    pub signal: usize,
    /// The value.
    pub value: f64,
    /// Above it (true) or below it.
    pub above: bool,
}

impl Condition {
    /// The signal is above a value.
    pub fn above(signal: usize, value: f64) -> Self {
        Self {
            signal,
            value,
            above: true,
        }
    }

    /// The signal is below a value.
    pub fn below(signal: usize, value: f64) -> Self {
        Self {
            signal,
            value,
            above: false,
        }
    }

    /// Positive where it holds.
    pub(crate) fn margin(&self, signals: &[f64]) -> f64 {
        let margin = signals[self.signal] - self.value;
        if self.above { margin } else { -margin }
    }
}

/// A signal going through a level.
///
/// An event happens where `signal - level` changes sign, from a sign that it had to the other one. A signal that *is* zero at
/// the start has no sign yet, so nothing happens at the start; the first sign that it takes afterwards is its sign.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// Index of the signal.
    pub signal: usize,
    /// The level; 0 unless said otherwise.
    pub level: f64,
    /// Which way it must go.
    pub direction: Direction,
    /// The event counts only after this has once been true.
    pub armed: Option<Condition>,
    /// Whether the run ends here.
    pub ends: bool,
}

impl Event {
    /// The signal going through zero; it does not end the run.
    pub fn on(signal: usize, direction: Direction) -> Self {
        Self {
            signal,
            level: 0.0,
            direction,
            armed: None,
            ends: false,
        }
    }

    /// The same at another level.
    #[must_use]
    pub fn at(self, level: f64) -> Self {
        Self { level, ..self }
    }

    /// The same, counting only after a condition has once been true.
    #[must_use]
    pub fn armed(self, condition: Condition) -> Self {
        Self {
            armed: Some(condition),
            ..self
        }
    }

    /// The same, ending the run.
    #[must_use]
    pub fn ending(self) -> Self {
        Self { ends: true, ..self }
    }
}

/// An event that happened.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Occurrence {
    /// Index of the event in the list given.
    pub event: usize,
    /// When, s: the first representable time found with the new sign.
    pub t: f64,
    /// Whether the signal rose.
    pub rising: bool,
    /// How far from touching: |ġ²/(2 g̈)|, the height of the nearest extremum of g = signal - level as its value and two
    /// derivatives predict it, over the largest |g| of the run. Infinite for a straight crossing.
    pub depth: f64,
    /// The crossing is so shallow (`depth` below the setting `grazing`) that it hardly is one.
    pub grazing: bool,
}

/// An event function that touches its level, or nearly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grazing {
    /// Index of the event in the list given.
    pub event: usize,
    /// When the event function is nearest to zero, s.
    pub t: f64,
    /// Its value there over its largest size in the run: how much is missing where it was not crossed, how deep the
    /// excursion to the other side is where it was. Never negative.
    pub margin: f64,
    /// Whether zero was crossed (there and back).
    pub crossed: bool,
}

/// A sign change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Crossing {
    /// Last time with the old sign.
    pub(crate) near: f64,
    /// First time with the new one.
    pub(crate) far: f64,
    pub(crate) rising: bool,
}

/// A minimum of |g| between samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Touch {
    pub(crate) t: f64,
    /// |g| there.
    pub(crate) size: f64,
    pub(crate) crossed: bool,
}

/// Sizes below this fraction of the largest are rounding, and have no sign.
const NOISE: f64 = 1e-15;
/// At a start, sizes below this fraction of what comes next are zero.
const ZERO: f64 = 1e-12;

/// One function of time that is watched for sign changes, sample by sample.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Watched {
    /// The sign that it has: 0 where it has not left zero yet.
    pub(crate) sign: f64,
    /// Largest size so far.
    pub(crate) scale: f64,
    before: Option<(f64, f64)>,
    last: Option<(f64, f64)>,
}

impl Watched {
    /// Goes on from a place at which a piece ends.
    pub(crate) fn go_on(&mut self, t: f64, value: f64) {
        self.before = None;
        self.last = Some((t, value));
    }

    /// Goes through further samples (times increasing; the first may repeat the last one given before), evaluating `g` between
    /// them where needed, and reports crossings and near touches in order of time.
    pub(crate) fn scan(
        &mut self,
        samples: &[(f64, f64)],
        tolerance: f64,
        mut g: impl FnMut(f64) -> f64,
        mut crossed: impl FnMut(Crossing),
        mut touched: impl FnMut(Touch),
    ) {
        let size = samples
            .iter()
            .fold(0.0_f64, |size, sample| size.max(sample.1.abs()));
        self.scale = self.scale.max(size);
        for &(t, value) in samples {
            if self.last.is_some_and(|last| t <= last.0) {
                continue;
            }
            if self.sign == 0.0 {
                // A sign is taken at the first sample that is clearly not zero.
                if value.abs() > ZERO * size {
                    self.sign = value.signum();
                }
            } else if value * self.sign < 0.0 && value.abs() > NOISE * self.scale {
                let from = self.last.filter(|last| last.1 * self.sign > 0.0);
                let bracket = if let Some(last) = from {
                    root(last, (t, value), tolerance, &mut g)
                } else {
                    // The last sample was a zero: the crossing is there.
                    let near = self.last.map_or(t, |last| last.0);
                    Bracket { near, far: near }
                };
                let far = clearly(bracket.far, t, -self.sign, &mut g);
                crossed(Crossing {
                    near: bracket.near,
                    far,
                    rising: self.sign < 0.0,
                });
                self.sign = -self.sign;
                self.before = None;
                self.last = (far < t).then(|| (far, g(far)));
            } else if let (Some(a), Some(b)) = (self.before, self.last)
                && let sign = self.sign
                && b.1 * sign >= 0.0
                && b.1 * sign <= a.1 * sign
                && b.1 * sign <= value * sign
                && promising(a, b, (t, value), sign, self.scale)
            {
                let (touch, low) = minimum((a.0, t), (b.0, b.1 * sign), f64::NEG_INFINITY, |t| {
                    sign * g(t)
                });
                let crosses = low < -NOISE * self.scale;
                if crosses {
                    let down = root((a.0, a.1), (touch, sign * low), tolerance, &mut g);
                    let far = clearly(down.far, touch, -sign, &mut g);
                    crossed(Crossing {
                        near: down.near,
                        far,
                        rising: sign < 0.0,
                    });
                    let up = root((touch, sign * low), (t, value), tolerance, &mut g);
                    let far = clearly(up.far, t, sign, &mut g);
                    crossed(Crossing {
                        near: up.near,
                        far,
                        rising: sign > 0.0,
                    });
                }
                touched(Touch {
                    t: touch,
                    size: low.abs(),
                    crossed: crosses,
                });
            }
            if self.last.is_none_or(|last| t > last.0) {
                self.before = self.last;
                self.last = Some((t, value));
            }
        }
    }
}

/// The first time from `t` on, by steps that double from rounding, at which g has the sign.
fn clearly(t: f64, most: f64, sign: f64, g: &mut impl FnMut(f64) -> f64) -> f64 {
    let mut step = f64::EPSILON * t.abs().max(most.abs()).max(f64::MIN_POSITIVE);
    let mut at = t;
    while at < most && g(at) * sign <= 0.0 {
        at += step;
        step *= 2.0;
    }
    at.min(most)
}

/// Whether the parabola through three samples with the middle one lowest comes near zero.
fn promising(a: (f64, f64), b: (f64, f64), c: (f64, f64), sign: f64, scale: f64) -> bool {
    let (low, high) = (b.1 * sign, a.1.abs().max(c.1.abs()));
    if low <= 1e-3 * scale {
        return true;
    }
    let (left, right) = (
        sign * (b.1 - a.1) / (b.0 - a.0),
        sign * (c.1 - b.1) / (c.0 - b.0),
    );
    let bend = (right - left) / (c.0 - a.0);
    if bend <= 0.0 {
        return false;
    }
    // Newton form around b: slope there, then the lowest point.
    let slope = left + bend * (b.0 - a.0);
    let lowest = low - slope * slope / (4.0 * bend);
    lowest < 0.2 * high
}
