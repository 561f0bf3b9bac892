//! All of p: columns, divided where ridges may cross the axis between them.

use num_complex::Complex64;

use super::column::{Column, Ridge};
use super::hermite::Cubic;
use super::locate::Point;
use super::sample::Sampler;
use super::{Band, BandSettings, Bands, Edge, Limit, Linearisation, ParameterSpan, Peak};

/// How far beside an edge a column must agree with it, as a part of p's range.
const BESIDE: f64 = 1e-7;
/// Width at which an edge that Newton's method cannot have is taken from bisection.
const BISECTED: f64 = 1e-11;
/// Ridges whose tangents miss each other by more than this part of their eigenvalue are not the same.
const SAME: f64 = 0.3;
/// A crest between two columns is told where it is nearer to the axis than this part of what is beside it.
const NEAR: f64 = 0.2;
/// Or where its damping ratio is less than this.
const LIGHT: f64 = 0.02;
/// Parts of an interval at which the cubics of all ridges are compared.
const PARTS: usize = 32;

/// The bands of p in which the equilibrium is stable for every q.
///
/// Without q, the intervals of p in which it is stable. p and q are sampled adaptively on their scales: an interval is divided until
/// cubics through the real parts and their slopes at its ends, with an error bar from how far the tangents of both ends miss each other
/// in its middle, leave no doubt about their sign, or [`BandSettings::shortest`] is reached.
pub fn stable_bands<L: Linearisation>(
    linearisation: &mut L,
    p: ParameterSpan,
    q: Option<ParameterSpan>,
    settings: &BandSettings,
) -> Bands {
    let mut scan = Scan {
        sampler: Sampler::new(linearisation, p, q),
        settings,
        columns: 0,
        edges: Vec::new(),
        peaks: Vec::new(),
        unresolved: Vec::new(),
    };
    let count = settings.columns.max(1);
    let mut before = scan.column(0.0);
    let first_stable = before.stable;
    for k in 1..=count {
        let after = scan.column(k as f64 / count as f64);
        scan.between(&before, &after, 0);
        before = after;
    }
    scan.finish(first_stable, before.stable)
}

struct Scan<'s, 'l, L> {
    sampler: Sampler<'l, L>,
    settings: &'s BandSettings,
    columns: usize,
    /// Edges by u, with whether the stable side is above.
    edges: Vec<(f64, bool, Edge)>,
    peaks: Vec<(f64, Peak)>,
    unresolved: Vec<(f64, f64)>,
}

/// A ridge between two columns.
pub(super) struct Span {
    pub(super) cubic: Cubic,
    pub(super) error: f64,
    from: Ridge,
    to: Ridge,
}

impl Span {
    /// The height at a part of the interval, with its error bar: that of a cubic through values and slopes falls off as the square of
    /// the distance to either end.
    fn height(&self, t: f64) -> (f64, f64) {
        let shape = 4.0 * t * (1.0 - t);
        (self.cubic.value(t), self.error * shape * shape)
    }

    /// Parts of the interval at which heights are looked at.
    fn parts(&self) -> impl Iterator<Item = f64> {
        let stationary = [self.cubic.highest().0, self.cubic.lowest().0];
        let even = (0..=PARTS).map(|k| k as f64 / PARTS as f64);
        even.chain(stationary)
    }

    /// The largest height that there may be.
    pub(super) fn highest(&self) -> f64 {
        self.parts()
            .map(|t| self.height(t))
            .map(|(height, error)| height + error)
            .fold(f64::NEG_INFINITY, f64::max)
    }

    /// The least height that there may be.
    fn lowest(&self) -> f64 {
        self.parts()
            .map(|t| self.height(t))
            .map(|(height, error)| height - error)
            .fold(f64::INFINITY, f64::min)
    }

    /// Position in q and eigenvalue at a part of the interval.
    pub(super) fn at(&self, t: f64) -> (f64, Complex64) {
        let s = self.from.s + t * (self.to.s - self.from.s);
        let value = self.from.mode.value * (1.0 - t) + self.to.mode.value * t;
        (s, Complex64::new(self.cubic.value(t), value.im))
    }
}

/// Ridges of two columns matched where their tangents meet, and those that are left at either.
pub(super) fn spans(a: &Column, b: &Column) -> (Vec<Span>, Vec<Ridge>, Vec<Ridge>) {
    let width = b.u - a.u;
    let mut costs = Vec::new();
    for (i, one) in a.ridges.iter().enumerate() {
        for (j, other) in b.ridges.iter().enumerate() {
            let across = other.s - one.s;
            let ahead = one.mode.ahead(0.5 * width, 0.5 * across);
            let behind = other.mode.ahead(-0.5 * width, -0.5 * across);
            let size = one.mode.value.norm() + other.mode.value.norm();
            let cost = (ahead - behind).norm() / size.max(f64::MIN_POSITIVE) + across.abs();
            if cost < SAME {
                costs.push((cost, i, j));
            }
        }
    }
    costs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut left = vec![false; a.ridges.len()];
    let mut right = vec![false; b.ridges.len()];
    let mut found = Vec::new();
    for (_, i, j) in costs {
        if left[i] || right[j] {
            continue;
        }
        left[i] = true;
        right[j] = true;
        let (from, to) = (a.ridges[i], b.ridges[j]);
        let cubic = Cubic {
            ends: [from.height, to.height],
            slopes: [from.mode.by_u.re * width, to.mode.by_u.re * width],
        };
        found.push(Span {
            error: cubic.mismatch(),
            cubic,
            from,
            to,
        });
    }
    let rest = |column: &Column, taken: &[bool]| {
        let ridges = column.ridges.iter().zip(taken);
        ridges
            .filter(|(_, taken)| !**taken)
            .map(|(r, _)| *r)
            .collect()
    };
    (found, rest(a, &left), rest(b, &right))
}

impl<L: Linearisation> Scan<'_, '_, L> {
    fn column(&mut self, u: f64) -> Column {
        self.columns += 1;
        self.sampler.column(u, self.settings)
    }

    fn exhausted(&self) -> bool {
        self.columns >= self.settings.most_columns
    }

    /// Divides at a part of the interval and goes on with both.
    fn divide(&mut self, a: &Column, b: &Column, part: f64, depth: usize) {
        let part = part.clamp(0.1, 0.9);
        let middle = self.column(a.u + part * (b.u - a.u));
        self.between(a, &middle, depth + 1);
        self.between(&middle, b, depth + 1);
    }

    /// Finds all edges between two columns.
    fn between(&mut self, a: &Column, b: &Column, depth: usize) {
        match (a.stable, b.stable) {
            (true, true) => self.stable(a, b, depth),
            (false, false) => self.unstable(a, b, depth),
            _ => self.edge(a, b, depth),
        }
    }

    fn give_up(&mut self, a: &Column, b: &Column) -> bool {
        let short = b.u - a.u <= self.settings.shortest || self.exhausted();
        if short {
            self.unresolved.push((a.u, b.u));
        }
        short
    }

    /// Both columns are stable: does anything rise above the axis between them?
    fn stable(&mut self, a: &Column, b: &Column, depth: usize) {
        let width = b.u - a.u;
        if width <= 4.0 * BESIDE {
            return;
        }
        let (spans, left, right) = spans(a, b);
        let mut ambiguous = None;
        for span in &spans {
            let size = span.cubic.ends[0].abs().max(span.cubic.ends[1].abs());
            let highest = span.highest();
            // What comes near the axis is told, even where it stays below.
            let near = highest >= -NEAR * size || highest >= -LIGHT * span.from.mode.value.norm();
            if !near || (highest < 0.0 && span.cubic.crest().is_none()) {
                continue;
            }
            let t = span.cubic.highest().0;
            let (s, near) = span.at(t);
            let u = a.u + t * width;
            let known = self.peak_between(a.u, b.u, near);
            if known.is_some_and(|height| height <= 0.0) && span.error <= 0.25 * size {
                continue;
            }
            if known.is_none()
                && let Some(point) = self.sampler.peak(u, s, near)
                && point.u >= a.u
                && point.u <= b.u
            {
                let inside = point.u > 0.0 && point.u < 1.0;
                if inside {
                    self.peaks.push((point.u, self.sampler.as_peak(&point)));
                }
                if point.mode.value.re > 0.0 {
                    self.island(a, b, &point, depth);
                    return;
                }
                if span.error <= 0.25 * size {
                    continue;
                }
            }
            if highest < 0.0 {
                continue;
            }
            ambiguous = Some(t);
        }
        // A ridge that only one column has may go on to the middle at least.
        let rises = |ridge: &Ridge, towards: f64| {
            ridge.height + (towards * ridge.mode.by_u.re * width).max(0.0) >= 0.0
        };
        if left.iter().any(|ridge| rises(ridge, 1.0))
            || right.iter().any(|ridge| rises(ridge, -1.0))
        {
            ambiguous = ambiguous.or(Some(0.5));
        }
        if let Some(part) = ambiguous
            && !self.give_up(a, b)
        {
            self.divide(
                a,
                b,
                if (0.1..0.9).contains(&part) {
                    part
                } else {
                    0.5
                },
                depth,
            );
        }
    }

    /// The height of a peak that is known between two columns, of an eigenvalue like this.
    fn peak_between(&self, from: f64, to: f64, near: Complex64) -> Option<f64> {
        self.peaks
            .iter()
            .filter(|(u, _)| *u >= from && *u <= to)
            .map(|(_, peak)| peak.eigenvalue)
            .find(|value| (value.im - near.im).abs() <= 0.1 * near.norm())
            .map(|value| value.re)
    }

    /// An island between two stable columns, whose top is known.
    fn island(&mut self, a: &Column, b: &Column, top: &Point, depth: usize) {
        let inside = top.u > a.u + BESIDE && top.u < b.u - BESIDE;
        if !inside {
            self.unresolved.push((a.u, b.u));
            return;
        }
        let mut column = self.column(top.u);
        // The samples of the column may miss a tip that the iteration has found.
        if column.stable {
            column.stable = false;
            column.ridges.push(Ridge {
                s: top.s,
                place: top.place,
                mode: top.mode,
                height: top.mode.value.re,
            });
        }
        self.between(a, &column, depth + 1);
        self.between(&column, b, depth + 1);
    }

    /// Both columns are unstable: is there a band between them?
    fn unstable(&mut self, a: &Column, b: &Column, depth: usize) {
        let width = b.u - a.u;
        if width <= 4.0 * BESIDE {
            return;
        }
        if !a.complete || !b.complete {
            // Nothing is known of ridges where the equilibrium ends.
            if width > 4.0 * self.settings.shortest && !self.exhausted() && depth < 3 {
                self.divide(a, b, 0.5, depth);
            }
            return;
        }
        let (spans, _, _) = spans(a, b);
        if spans.iter().any(|span| span.lowest() > 0.0) {
            return;
        }
        let mut lowest = (0.5, f64::INFINITY);
        for k in 0..=PARTS {
            let t = k as f64 / PARTS as f64;
            let height = spans
                .iter()
                .map(|span| span.height(t))
                .map(|(height, error)| height - error)
                .fold(f64::NEG_INFINITY, f64::max);
            if height < lowest.1 {
                lowest = (t, height);
            }
        }
        if lowest.1 > 0.0 || self.give_up(a, b) {
            return;
        }
        self.divide(a, b, lowest.0, depth);
    }

    /// One column is stable and the other not: where is the edge next to the stable one?
    fn edge(&mut self, a: &Column, b: &Column, depth: usize) {
        let width = b.u - a.u;
        let upwards = a.stable;
        let (steady, other) = if upwards { (a, b) } else { (b, a) };
        if width <= BISECTED || self.exhausted() {
            self.bisected(steady, other, upwards);
            return;
        }
        let (spans, left, right) = spans(a, b);
        // From the stable side: (part of the interval, position in q, eigenvalue).
        let mut starts: Vec<(f64, f64, Complex64)> = Vec::new();
        for span in &spans {
            let [from, to] = span.cubic.ends;
            if (from > 0.0) != (to > 0.0) {
                let t = span.cubic.zero();
                let (s, near) = span.at(t);
                starts.push((t, s, near));
            }
        }
        let lone = if upwards { &right } else { &left };
        for ridge in lone.iter().filter(|ridge| ridge.height > 0.0) {
            let reach = (ridge.height / (ridge.mode.by_u.re.abs() * width)).min(1.0);
            let t = if upwards { 1.0 - reach } else { reach };
            starts.push((t, ridge.s, ridge.mode.value));
        }
        starts.sort_by(|a, b| {
            let order = a.0.total_cmp(&b.0);
            if upwards { order } else { order.reverse() }
        });
        for (t, s, near) in starts {
            let Some(point) = self.sampler.edge(a.u + t * width, s, near) else {
                continue;
            };
            let slope_fits = (point.mode.by_u.re > 0.0) == upwards;
            if point.u <= a.u || point.u >= b.u || !slope_fits {
                continue;
            }
            let towards = if upwards { BESIDE } else { -BESIDE };
            let before = (point.u - towards).clamp(a.u, b.u);
            let inner = self.column(before);
            if !inner.stable {
                // Something else rises earlier.
                if upwards {
                    self.between(a, &inner, depth + 1);
                    self.between(&inner, b, depth + 1);
                } else {
                    self.between(&inner, b, depth + 1);
                    self.between(a, &inner, depth + 1);
                }
                return;
            }
            let edge = self.sampler.as_edge(&point);
            self.edges.push((point.u, !upwards, edge));
            let after = (point.u + towards).clamp(a.u, b.u);
            let mut outer = self.column(after);
            outer.stable = false;
            if upwards {
                self.between(a, &inner, depth + 1);
                self.between(&outer, b, depth + 1);
            } else {
                self.between(a, &outer, depth + 1);
                self.between(&inner, b, depth + 1);
            }
            return;
        }
        self.divide(a, b, 0.5, depth);
    }

    /// An edge between two columns that lie close together.
    fn bisected(&mut self, steady: &Column, other: &Column, upwards: bool) {
        if self.exhausted() && (steady.u - other.u).abs() > 1e-6 {
            self.unresolved
                .push((steady.u.min(other.u), steady.u.max(other.u)));
        }
        let highest = |column: &Column| {
            let ridges = column.ridges.iter().copied();
            ridges.max_by(|a, b| a.height.total_cmp(&b.height))
        };
        let p = self.sampler.p.value(steady.u);
        let error = (self.sampler.p.value(other.u) - p).abs() / p.abs();
        let edge = match highest(if other.complete { other } else { steady }) {
            Some(ridge) => Edge {
                error,
                ..self.sampler.as_edge(&Point {
                    u: steady.u,
                    s: ridge.s,
                    mode: ridge.mode,
                    place: ridge.place,
                })
            },
            None => Edge {
                p,
                q: None,
                eigenvalue: Complex64::default(),
                slope: f64::NAN,
                limit: Limit::NoEquilibrium,
                error,
            },
        };
        let limit = if other.complete {
            edge.limit
        } else {
            Limit::NoEquilibrium
        };
        self.edges
            .push((steady.u, !upwards, Edge { limit, ..edge }));
    }

    /// Edges in order make bands.
    fn finish(mut self, first_stable: bool, last_stable: bool) -> Bands {
        self.edges.sort_by(|a, b| a.0.total_cmp(&b.0));
        let span = self.sampler.p;
        let end = |p: f64| Edge {
            p,
            q: None,
            eigenvalue: Complex64::default(),
            slope: 0.0,
            limit: Limit::Range,
            error: 0.0,
        };
        let mut lower = first_stable.then(|| end(span.from));
        let mut bands = Vec::new();
        for (_, opens, edge) in &self.edges {
            if *opens {
                lower = Some(*edge);
            } else if let Some(lower) = lower.take() {
                bands.push(Band {
                    lower,
                    upper: *edge,
                });
            }
        }
        if let Some(lower) = lower.filter(|_| last_stable) {
            bands.push(Band {
                lower,
                upper: end(span.to),
            });
        }
        self.peaks.sort_by(|a, b| a.0.total_cmp(&b.0));
        Bands {
            bands,
            peaks: self.peaks.into_iter().map(|(_, peak)| peak).collect(),
            columns: self.columns,
            samples: self.sampler.count,
            unresolved: self
                .unresolved
                .iter()
                .map(|(from, to)| (span.value(*from), span.value(*to)))
                .collect(),
        }
    }
}
