//! Edges and peaks by Newton's method.

use num_complex::Complex64;

use super::column::Place;
use super::sample::{Mode, Sampler, Want};
use super::{Edge, Limit, Linearisation, Peak};

/// Step of differences of slopes, as a part of a range.
const STEP: f64 = 1e-4;
const ITERATIONS: usize = 30;
/// Longest step, as a part of a range.
const LONGEST: f64 = 0.05;
/// Newton has converged when a step is shorter than this part of the ranges.
const CONVERGED: f64 = 1e-12;
/// A real part that is zero, relative to the eigenvalue.
const ON_AXIS: f64 = 1e-9;

/// A point that an iteration has reached.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub(super) u: f64,
    pub(super) s: f64,
    pub(super) mode: Mode,
    pub(super) place: Place,
}

impl<L: Linearisation> Sampler<'_, L> {
    fn mode(&mut self, u: f64, s: f64, near: Complex64) -> Option<Mode> {
        self.sample(u, s, Want::One(near))?.modes.first().copied()
    }

    /// Second derivatives of the real part: by u twice, mixed, by s twice.
    fn second(&mut self, point: &Point) -> Option<[f64; 3]> {
        let (u, s, mode) = (point.u, point.s, point.mode);
        let along = |ahead: Mode, behind: Mode, width: f64| {
            [
                (ahead.by_u.re - behind.by_u.re) / width,
                (ahead.by_s.re - behind.by_s.re) / width,
            ]
        };
        let step = if u > 0.5 { -STEP } else { STEP };
        let near = mode.ahead(step, 0.0);
        let by_u = along(self.mode(u + step, s, near)?, mode, step);
        if self.q.is_none() {
            return Some([by_u[0], 0.0, -1.0]);
        }
        let step = if s > 0.5 { -STEP } else { STEP };
        let near = mode.ahead(0.0, step);
        let by_s = along(self.mode(u, s + step, near)?, mode, step);
        Some([by_u[0], 0.5 * (by_u[1] + by_s[0]), by_s[1]])
    }

    /// Where on q the point is, by the slope there.
    fn place(&self, s: f64, mode: &Mode) -> Place {
        if self.q.is_none() {
            Place::Inside
        } else if s <= 0.0 && mode.by_s.re <= 0.0 {
            Place::Lower
        } else if s >= 1.0 && mode.by_s.re >= 0.0 {
            Place::Upper
        } else {
            Place::Inside
        }
    }

    /// The zero of a ridge near a point: Re λ = 0 where Re λ is largest over q.
    pub(super) fn edge(&mut self, u: f64, s: f64, near: Complex64) -> Option<Point> {
        let (mut u, mut s, mut near) = (u, s, near);
        for _ in 0..ITERATIONS {
            let mode = self.mode(u, s, near)?;
            let place = self.place(s, &mode);
            let mut point = Point { u, s, mode, place };
            let value = mode.value.re;
            let (du, ds) = if place != Place::Inside || self.q.is_none() {
                (-value / mode.by_u.re, 0.0)
            } else {
                let [_, mixed, bend] = self.second(&point)?;
                if bend < 0.0 {
                    // [λ_u, λ_s; λ_us, λ_ss] (du, ds) = -(λ, λ_s)
                    let (a, b) = (mode.by_u.re, mode.by_s.re);
                    let determinant = a * bend - b * mixed;
                    (
                        (-value * bend + b * b) / determinant,
                        (value * mixed - a * b) / determinant,
                    )
                } else {
                    // No crest here: uphill, as far as allowed.
                    (0.0, LONGEST.copysign(mode.by_s.re))
                }
            };
            if !(du.is_finite() && ds.is_finite()) {
                return None;
            }
            let shorter = (LONGEST / du.abs().max(ds.abs())).min(1.0);
            let to = (
                (u + shorter * du).clamp(-0.01, 1.01),
                (s + shorter * ds).clamp(0.0, 1.0),
            );
            let (du, ds) = (to.0 - u, to.1 - s);
            near = mode.ahead(du, ds);
            (u, s) = to;
            if du.abs() <= CONVERGED && ds.abs() <= 1e-7 {
                point.u = u;
                // Where two eigenvalues meet slopes have no bound, and steps become short for that alone.
                return (value.abs() <= ON_AXIS * mode.value.norm()).then_some(point);
            }
        }
        None
    }

    /// The maximum of the real part over both parameters near a point.
    pub(super) fn peak(&mut self, u: f64, s: f64, near: Complex64) -> Option<Point> {
        let (mut u, mut s, mut near) = (u, s, near);
        let mut longest = LONGEST;
        let mut best = f64::NEG_INFINITY;
        for _ in 0..2 * ITERATIONS {
            let mode = self.mode(u, s, near)?;
            let place = self.place(s, &mode);
            let point = Point { u, s, mode, place };
            if mode.value.re < best - 1e-12 * mode.value.norm() {
                longest *= 0.5;
            }
            best = best.max(mode.value.re);
            let [first, mixed, last] = self.second(&point)?;
            let (a, b) = (mode.by_u.re, mode.by_s.re);
            let (du, ds) = if place != Place::Inside || self.q.is_none() {
                if first < 0.0 {
                    (-a / first, 0.0)
                } else {
                    (longest.copysign(a), 0.0)
                }
            } else {
                let determinant = first * last - mixed * mixed;
                if first < 0.0 && determinant > 0.0 {
                    (
                        (-a * last + b * mixed) / determinant,
                        (a * mixed - b * first) / determinant,
                    )
                } else if last < 0.0 {
                    // Along the ridge.
                    let along = a - b * mixed / last;
                    let du = longest.copysign(along);
                    (du, -(b + mixed * du) / last)
                } else {
                    let size = a.hypot(b);
                    (longest * a / size, longest * b / size)
                }
            };
            if !(du.is_finite() && ds.is_finite()) {
                return None;
            }
            let shorter = (longest / du.abs().max(ds.abs())).min(1.0);
            let to = (
                (u + shorter * du).clamp(0.0, 1.0),
                (s + shorter * ds).clamp(0.0, 1.0),
            );
            let (du, ds) = (to.0 - u, to.1 - s);
            // A maximum is exact to second order in where it is.
            if du.abs() <= 1e-8 && ds.abs() <= 1e-8 {
                return Some(point);
            }
            near = mode.ahead(du, ds);
            (u, s) = to;
        }
        None
    }

    /// A point as an edge of a band.
    pub(super) fn as_edge(&self, point: &Point) -> Edge {
        let p = self.p.value(point.u);
        let value = point.mode.value;
        let by_p = point.mode.by_u.re / self.p.slope(point.u);
        let oscillates = value.im > 0.0;
        let limit = match (point.place, oscillates) {
            (Place::Inside, true) => Limit::Hopf,
            (Place::Inside, false) => Limit::Fold,
            (_, true) => Limit::HopfAtEnd,
            (_, false) => Limit::FoldAtEnd,
        };
        // A real part is known to a few units of rounding of the eigenvalue.
        let doubt = value.re.abs() + 16.0 * f64::EPSILON * value.norm();
        Edge {
            p,
            q: self.q.map(|q| q.value(point.s)),
            eigenvalue: value,
            slope: by_p,
            limit,
            error: doubt / (by_p * p).abs(),
        }
    }

    /// A point as a peak.
    pub(super) fn as_peak(&self, point: &Point) -> Peak {
        Peak {
            p: self.p.value(point.u),
            q: self.q.map_or(0.0, |q| q.value(point.s)),
            eigenvalue: point.mode.value,
        }
    }
}
