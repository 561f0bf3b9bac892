//! All of q at one p: whether the equilibrium is stable, and the ridges.

use num_complex::Complex64;

use super::hermite::Cubic;
use super::sample::{Mode, Sample, Sampler, Want};
use super::{BandSettings, Linearisation};

/// Shortest interval of q, as a part of its range.
const SHORTEST: f64 = 1.0 / 4096.0;
/// Part of a crest's height up to which the mismatch of two tangents is let pass.
const CLOSE: f64 = 0.02;
/// Ridges damped more than this are not followed (a damping ratio): between columns they cannot come up unseen without the
/// mismatch of other slopes showing it.
const DAMPED: f64 = 0.6;

/// Most steps up a crest, and how little one may rise that is taken without another look, relative to the height.
const CLIMBS: usize = 5;
const SMALL: f64 = 0.05;

/// Where in q's range a ridge is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    Lower,
    Inside,
    Upper,
}

/// A local maximum over q of the real part of an eigenvalue.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ridge {
    pub(super) s: f64,
    pub(super) place: Place,
    pub(super) mode: Mode,
    /// The real part at the crest.
    pub(super) height: f64,
}

/// What was found at one p.
#[derive(Clone, Debug)]
pub(super) struct Column {
    pub(super) u: f64,
    pub(super) stable: bool,
    /// Whether the equilibrium exists over all of q.
    pub(super) complete: bool,
    pub(super) ridges: Vec<Ridge>,
    /// About where an eigenvalue passes the axis: its position and value.
    pub(super) passes: Vec<(f64, Complex64)>,
}

/// Pairs of eigenvalues of two samples (im ≥ 0 at either), matched where their tangents meet.
pub(super) fn pairs(a: &Sample, b: &Sample) -> Vec<(Mode, Mode)> {
    let width = b.s - a.s;
    let (from, to) = (a.all(), b.all());
    let mut costs: Vec<(f64, usize, usize)> = Vec::with_capacity(from.len() * to.len());
    for (i, one) in from.iter().enumerate() {
        let ahead = one.ahead(0.0, 0.5 * width);
        for (j, other) in to.iter().enumerate() {
            costs.push(((ahead - other.ahead(0.0, -0.5 * width)).norm_sqr(), i, j));
        }
    }
    costs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut left, mut right) = (vec![false; from.len()], vec![false; to.len()]);
    let mut found = Vec::new();
    for (_, i, j) in costs {
        if !left[i] && !right[j] {
            left[i] = true;
            right[j] = true;
            if from[i].value.im >= 0.0 && to[j].value.im >= 0.0 {
                found.push((from[i], to[j]));
            }
        }
    }
    found
}

/// Real parts between two samples.
fn cubic(pair: &(Mode, Mode), width: f64) -> Cubic {
    Cubic {
        ends: [pair.0.value.re, pair.1.value.re],
        slopes: [pair.0.by_s.re * width, pair.1.by_s.re * width],
    }
}

/// How far the tangents of a pair are apart in the middle.
fn mismatch(pair: &(Mode, Mode), width: f64) -> f64 {
    (pair.0.ahead(0.0, 0.5 * width) - pair.1.ahead(0.0, -0.5 * width)).norm()
}

impl<L: Linearisation> Sampler<'_, L> {
    /// Looks at all of q.
    pub(super) fn column(&mut self, u: f64, settings: &BandSettings) -> Column {
        self.fit(u);
        let column = self.look(u, settings);
        self.unfit();
        column
    }

    fn look(&mut self, u: f64, settings: &BandSettings) -> Column {
        let mut column = Column {
            u,
            stable: true,
            complete: true,
            ridges: Vec::new(),
            passes: Vec::new(),
        };
        if self.q.is_none() {
            self.point(&mut column);
            return column;
        }
        let rows = settings.rows.max(1);
        let Some(mut from) = self.sample(u, 0.0, Want::All) else {
            return column.incomplete();
        };
        for row in 0..rows {
            let end = (row + 1) as f64 / rows as f64;
            let Some(to) = self.sample(u, end, Want::All) else {
                return column.incomplete();
            };
            if row == 0 {
                self.end_ridges(&mut column, &from, Place::Lower);
            }
            let mut ahead = vec![to];
            while let Some(to) = ahead.last() {
                let width = to.s - from.s;
                let matched = pairs(&from, to);
                if let Some(part) = divided(&matched, &from, to, width) {
                    let middle = from.s + part * width;
                    let Some(sample) = self.sample(u, middle, Want::All) else {
                        return column.incomplete();
                    };
                    ahead.push(sample);
                    continue;
                }
                column.stable &= from.growth() < 0.0 && to.growth() < 0.0;
                self.crests(&mut column, &matched, &from, width);
                passes(&mut column, &matched, from.s, width);
                if let Some(next) = ahead.pop() {
                    from = next;
                }
            }
        }
        self.end_ridges(&mut column, &from, Place::Upper);
        column.stable &= column.ridges.iter().all(|ridge| ridge.height < 0.0);
        column
    }

    /// Without a second parameter every eigenvalue is a ridge.
    fn point(&mut self, column: &mut Column) {
        let Some(sample) = self.sample(column.u, 0.0, Want::All) else {
            column.stable = false;
            column.complete = false;
            return;
        };
        column.stable = sample.growth() < 0.0;
        for mode in &sample.modes {
            self.ridge(column, mode.value, 0.0, Place::Inside, None);
        }
    }

    /// The ends of q's range are ridges of what falls from there.
    fn end_ridges(&mut self, column: &mut Column, sample: &Sample, place: Place) {
        for mode in &sample.modes {
            let falls = match place {
                Place::Lower => mode.by_s.re <= 0.0,
                _ => mode.by_s.re >= 0.0,
            };
            if falls {
                self.ridge(column, mode.value, sample.s, place, None);
            }
        }
    }

    /// The crests between two samples.
    fn crests(&mut self, column: &mut Column, matched: &[(Mode, Mode)], from: &Sample, width: f64) {
        for pair in matched {
            let own = cubic(pair, width);
            let Some(t) = own.crest() else {
                continue;
            };
            let value = pair.0.value * (1.0 - t) + pair.1.value * t;
            let value = Complex64::new(own.value(t), value.im);
            let curvature = own.curvature(t) / (width * width);
            self.ridge(
                column,
                value,
                from.s + t * width,
                Place::Inside,
                Some(curvature),
            );
        }
    }

    /// Adds a ridge unless it is far from the axis.
    fn ridge(
        &mut self,
        column: &mut Column,
        value: Complex64,
        s: f64,
        place: Place,
        curvature: Option<f64>,
    ) {
        if value.im > 0.0 && value.re < -DAMPED * value.norm() {
            return;
        }
        let Some(mode) = self
            .sample(column.u, s, Want::One(value))
            .and_then(|sample| sample.modes.first().copied())
        else {
            return;
        };
        let mut found = Ridge {
            s,
            place,
            mode,
            height: mode.value.re,
        };
        let mut bend = curvature.unwrap_or(0.0);
        for _ in 0..CLIMBS {
            let shift = (-found.mode.by_s.re / bend).clamp(-0.02, 0.02);
            let rise = 0.5 * found.mode.by_s.re * shift;
            if !(bend < 0.0 && rise > 0.0) {
                break;
            }
            if rise <= SMALL * found.height.abs() {
                found.height += rise;
                found.s = (found.s + shift).clamp(0.0, 1.0);
                break;
            }
            let next = (found.s + shift).clamp(0.0, 1.0);
            let near = found.mode.ahead(0.0, shift);
            let sampled = self.sample(column.u, next, Want::One(near));
            let Some(mode) = sampled.and_then(|sample| sample.modes.first().copied()) else {
                break;
            };
            if !(mode.value.re > found.height) {
                break;
            }
            let secant = (mode.by_s.re - found.mode.by_s.re) / (next - found.s);
            if secant < 0.0 {
                bend = secant;
            }
            found = Ridge {
                s: next,
                place,
                mode,
                height: mode.value.re,
            };
        }
        column.ridges.push(found);
    }
}

impl Column {
    /// Without an equilibrium over all of q.
    fn incomplete(mut self) -> Self {
        self.stable = false;
        self.complete = false;
        self.ridges.clear();
        self.passes.clear();
        self
    }
}

/// Zeros of the real parts between two samples, about.
fn passes(column: &mut Column, matched: &[(Mode, Mode)], from: f64, width: f64) {
    for pair in matched {
        let own = cubic(pair, width);
        for t in own.zeros() {
            let value = pair.0.value * (1.0 - t) + pair.1.value * t;
            column.passes.push((from + t * width, value));
        }
    }
}

/// Where an interval of q must be divided, if it must.
fn divided(matched: &[(Mode, Mode)], from: &Sample, to: &Sample, width: f64) -> Option<f64> {
    if width <= SHORTEST {
        return None;
    }
    for pair in matched {
        let own = cubic(pair, width);
        let error = mismatch(pair, width);
        let (_, highest) = own.highest();
        if highest + error < 0.0 {
            continue;
        }
        let rise = 0.25 * (own.slopes[0].abs() + own.slopes[1].abs());
        if error > CLOSE * rise.max(1e-9 * pair.0.value.norm()) && own.lowest().1 - error <= 0.0 {
            return Some(0.5);
        }
    }
    // A pair of real eigenvalues that meets within has a root of infinite slope there.
    let reals = |sample: &Sample| {
        sample
            .modes
            .iter()
            .filter(|mode| mode.value.im == 0.0)
            .count()
    };
    if reals(from) != reals(to) {
        let near = |sample: &Sample| {
            let reals = sample.modes.iter().filter(|mode| mode.value.im == 0.0);
            reals
                .map(|mode| mode.value.re + (mode.by_s.re * width).abs())
                .fold(f64::NEG_INFINITY, f64::max)
        };
        if near(from).max(near(to)) >= 0.0 {
            return Some(0.5);
        }
    }
    meeting(matched, width)
}

/// Where two eigenvalues pass each other closely: a weak coupling may part them there, and one of them towards the axis.
fn meeting(matched: &[(Mode, Mode)], width: f64) -> Option<f64> {
    if width <= 1.0 / 256.0 {
        return None;
    }
    for (i, one) in matched.iter().enumerate() {
        for other in matched.iter().skip(i + 1) {
            let apart = [
                one.0.value.im - other.0.value.im,
                one.1.value.im - other.1.value.im,
            ];
            if apart[0] * apart[1] >= 0.0 || one.0.value.im == 0.0 || other.0.value.im == 0.0 {
                continue;
            }
            let t = apart[0] / (apart[0] - apart[1]);
            let heights = [cubic(one, width).value(t), cubic(other, width).value(t)];
            let highest = heights[0].max(heights[1]);
            // A coupling that parts them by more than this bends their tangents already at the ends.
            let parted = 0.1 * (apart[0].abs() + apart[1].abs());
            if highest + 0.5 * (heights[0] - heights[1]).abs() + parted >= 0.0
                && (0.02..0.98).contains(&t)
            {
                return Some(t);
            }
        }
    }
    None
}
