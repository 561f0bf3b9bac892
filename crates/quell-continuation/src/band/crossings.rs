//! Where in a rectangle eigenvalues pass the imaginary axis: a point at least on every curve on which one does.
//!
//! Columns are looked at as for stable bands, but for every eigenvalue. Curves that lie between two columns are islands of a ridge
//! of the growth rate, or of a valley, which is a ridge of the matrix with the opposite sign.

use super::column::{Column, Place, Ridge};
use super::sample::{Sampler, Want};
use super::scan::spans;
use super::{BandSettings, Linearisation, ParameterSpan};

/// A real part that is zero, relative to the eigenvalue.
const ON_AXIS: f64 = 1e-9;
const ITERATIONS: usize = 20;

/// An eigenvalue on the imaginary axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Crossing {
    pub(crate) p: f64,
    pub(crate) q: f64,
    /// Its imaginary part; zero for a real eigenvalue.
    pub(crate) omega: f64,
}

/// What a scan found.
#[derive(Clone, Debug, Default)]
pub(crate) struct Crossings {
    pub(crate) found: Vec<Crossing>,
    /// Islands between columns.
    pub(crate) islands: usize,
    pub(crate) columns: usize,
    pub(crate) samples: usize,
    /// Intervals of p that remained ambiguous at the shortest division.
    pub(crate) unresolved: Vec<(f64, f64)>,
    /// Whether the equilibrium ends somewhere in the rectangle.
    pub(crate) ends: bool,
}

/// Points on all curves on which an eigenvalue passes the axis.
pub(crate) fn crossings<L: Linearisation>(
    linearisation: &mut L,
    p: ParameterSpan,
    q: ParameterSpan,
    settings: &BandSettings,
) -> Crossings {
    let mut scan = Scan {
        sampler: Sampler::new(linearisation, p, Some(q)),
        settings,
        q,
        out: Crossings::default(),
    };
    let count = settings.columns.max(1);
    let mut before = scan.column(0.0);
    for k in 1..=count {
        let after = scan.column(k as f64 / count as f64);
        scan.between(&before, &after);
        before = after;
    }
    scan.out.samples = scan.sampler.count;
    scan.out
}

struct Scan<'s, 'l, L> {
    sampler: Sampler<'l, L>,
    settings: &'s BandSettings,
    q: ParameterSpan,
    out: Crossings,
}

impl<L: Linearisation> Scan<'_, '_, L> {
    fn column(&mut self, u: f64) -> Column {
        self.out.columns += 1;
        let column = self.sampler.column(u, self.settings);
        self.out.ends |= !column.complete;
        for (s, value) in &column.passes {
            let mut s = *s;
            let mut near = *value;
            for _ in 0..ITERATIONS {
                let sampled = self.sampler.sample(u, s, Want::One(near));
                let Some(mode) = sampled.and_then(|sample| sample.modes.first().copied()) else {
                    break;
                };
                near = mode.value;
                if near.re.abs() <= ON_AXIS * near.norm().max(ON_AXIS) {
                    self.add(u, s, near.im);
                    break;
                }
                let step = (-near.re / mode.by_s.re).clamp(-0.02, 0.02);
                if !step.is_finite() {
                    break;
                }
                s = (s + step).clamp(0.0, 1.0);
            }
        }
        column
    }

    fn add(&mut self, u: f64, s: f64, omega: f64) {
        let found = Crossing {
            p: self.sampler.p.value(u),
            q: self.q.value(s),
            omega,
        };
        self.out.found.push(found);
    }

    /// Ridges that are below the axis at both columns, and where those are that pass it between them.
    fn between(&mut self, a: &Column, b: &Column) {
        let width = b.u - a.u;
        let short =
            width <= self.settings.shortest || self.out.columns >= self.settings.most_columns;
        if !a.complete || !b.complete {
            if width > 16.0 * self.settings.shortest && !short {
                self.divide(a, b, 0.5);
            }
            return;
        }
        let (spans, left, right) = spans(a, b);
        let mut ambiguous = None;
        for span in &spans {
            let [from, to] = span.cubic.ends;
            if (from > 0.0) != (to > 0.0) {
                let t = span.cubic.zero();
                let (s, near) = span.at(t);
                if let Some(point) = self.sampler.edge(a.u + t * width, s, near)
                    && (0.0..=1.0).contains(&point.u)
                {
                    self.add(point.u, point.s, point.mode.value.im);
                }
                continue;
            }
            if from > 0.0 || span.highest() < 0.0 {
                continue;
            }
            let t = span.cubic.highest().0;
            let (s, near) = span.at(t);
            let peak = self
                .sampler
                .peak(a.u + t * width, s, near)
                .filter(|point| point.u >= a.u && point.u <= b.u);
            match peak {
                Some(point) if point.mode.value.re > 0.0 => {
                    self.out.islands += 1;
                    let part = (point.u - a.u) / width;
                    // A tip that the samples of its column miss is a point beside the curve all the same.
                    if point.place == Place::Inside {
                        self.add(point.u, point.s, point.mode.value.im);
                    }
                    if (0.02..=0.98).contains(&part) && !short {
                        self.divide(a, b, part);
                    }
                    return;
                }
                Some(_) if span.error <= 0.25 * from.abs().max(to.abs()) => {}
                _ => ambiguous = ambiguous.or(Some(t)),
            }
        }
        // A ridge that only one column has may go on to the middle at least.
        let rises = |ridge: &Ridge, towards: f64| {
            ridge.height < 0.0
                && ridge.height + (towards * ridge.mode.by_u.re * width).max(0.0) >= 0.0
        };
        if left.iter().any(|ridge| rises(ridge, 1.0))
            || right.iter().any(|ridge| rises(ridge, -1.0))
        {
            ambiguous = ambiguous.or(Some(0.5));
        }
        if let Some(part) = ambiguous {
            if short {
                let span = self.sampler.p;
                let unresolved = (span.value(a.u), span.value(b.u));
                self.out.unresolved.push(unresolved);
            } else {
                self.divide(
                    a,
                    b,
                    if (0.1..0.9).contains(&part) {
                        part
                    } else {
                        0.5
                    },
                );
            }
        }
    }

    fn divide(&mut self, a: &Column, b: &Column, part: f64) {
        let middle = self.column(a.u + part * (b.u - a.u));
        self.between(a, &middle);
        self.between(&middle, b);
    }
}
