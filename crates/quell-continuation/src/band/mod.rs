//! Stable bands: in which intervals of one parameter an equilibrium is stable for every value of another.
//!
//! Known is a matrix A(p, q), the linearisation about the equilibrium. A *ridge* at p is a local maximum over q of the real part
//! of an eigenvalue; p is in a band where no ridge is above zero. Ridges come with their slope by p (envelope theorem), so that a
//! ridge that rises above zero between two values of p (an island of instability) is found by its slopes, however narrow the island
//! is. An edge of a band is a solution of the extended system
//!
//! Re λ(p, q) = 0, ∂Re λ/∂q = 0 (or q at an end of its range), A v = λ v,
//!
//! solved by Newton's method. Slopes of eigenvalues are wᵀ (∂A) v / wᵀ v with left and right eigenvectors (P. Lancaster, 1964,
//! Numerische Mathematik 6, 377-387); ∂A are central differences unless [`Linearisation::slope`] is overridden: their error is of
//! second order in the position along the ridge, and leaves the edge as exact as the eigenvalue itself.

mod column;
mod crossings;
mod hermite;
mod locate;
mod sample;
mod scan;

use num_complex::Complex64;

pub(crate) use crossings::crossings;
pub use scan::stable_bands;

use crate::dense::{eigenvalues, eigenvector, left_eigenvector};
use crate::problem::Problem;

/// The eigenvalue of a matrix (n × n, row major) next to a number, as the Rayleigh quotient of its two eigenvectors.
pub fn eigenvalue_near(n: usize, a: &[f64], near: Complex64) -> Option<Complex64> {
    let values = eigenvalues(n, a)?;
    let distance = |value: &Complex64| (value - near).norm_sqr();
    let value = *values
        .iter()
        .min_by(|one, other| distance(one).total_cmp(&distance(other)))?;
    let right = eigenvector(n, a, value);
    let left = left_eigenvector(n, a, value);
    let product: Complex64 = left.iter().zip(&right).map(|(w, v)| w * v).sum();
    let mut image = Complex64::default();
    for (row, w) in a.chunks_exact(n).zip(&left) {
        let entry: Complex64 = row.iter().zip(&right).map(|(a, v)| v * *a).sum();
        image += w * entry;
    }
    let quotient = image / product;
    let near = (quotient - value).norm() <= 1e-6 * value.norm();
    Some(if near { quotient } else { value })
}

/// The eigenvalues of a matrix (n × n, row major) with non-negative imaginary part and their eigenvectors of unit length, the least
/// damped first.
pub fn eigenpairs(n: usize, a: &[f64]) -> Option<Vec<(Complex64, Vec<Complex64>)>> {
    let mut values = eigenvalues(n, a)?;
    values.retain(|value| value.im >= 0.0);
    values.sort_by(|a, b| b.re.total_cmp(&a.re).then(b.im.total_cmp(&a.im)));
    Some(
        values
            .into_iter()
            .map(|value| (value, eigenvector(n, a, value)))
            .collect(),
    )
}

/// The first Lyapunov coefficient at a Hopf point of frequency `omega`, as [`equilibria`](crate::equilibria) normalises it: negative
/// where the cycle is born stable. None where second or third derivatives are not available.
pub fn first_lyapunov(
    problem: &dyn Problem,
    state: &[f64],
    parameters: &[f64],
    omega: f64,
) -> Option<f64> {
    let n = state.len();
    let mut a = vec![0.0; n * n];
    problem.jacobian(0.0, state, parameters, &mut a);
    crate::equilibrium::normal::hopf(problem, state, parameters, &a, omega)
}

/// The linearisation of an equilibrium that depends on two parameters.
pub trait Linearisation {
    /// Number n of states.
    fn states(&self) -> usize;

    /// A(p, q), n × n, row major; false where there is no equilibrium or an entry is not finite.
    fn matrix(&mut self, p: f64, q: f64, out: &mut [f64]) -> bool;
}

/// The range of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterSpan {
    /// Lower end.
    pub from: f64,
    /// Upper end.
    pub to: f64,
    /// Whether it is searched on a logarithmic scale.
    pub logarithmic: bool,
}

impl ParameterSpan {
    /// A range; on a logarithmic scale where it is positive and a decade or more wide.
    pub fn new(from: f64, to: f64) -> Self {
        Self {
            from,
            to,
            logarithmic: from > 0.0 && to >= 10.0 * from,
        }
    }

    /// The value at a part of the range, 0 to 1.
    pub fn value(&self, part: f64) -> f64 {
        if part <= 0.0 {
            self.from
        } else if part >= 1.0 {
            self.to
        } else if self.logarithmic {
            self.from * (self.to / self.from).powf(part)
        } else {
            self.from + part * (self.to - self.from)
        }
    }

    /// The part of the range at which a value lies.
    pub fn part(&self, value: f64) -> f64 {
        if self.logarithmic {
            (value / self.from).ln() / (self.to / self.from).ln()
        } else {
            (value - self.from) / (self.to - self.from)
        }
    }

    /// The value at any part: beyond the ends the scale goes on as it is.
    pub(crate) fn beyond(&self, part: f64) -> f64 {
        if (0.0..=1.0).contains(&part) {
            self.value(part)
        } else if self.logarithmic {
            self.from * (self.to / self.from).powf(part)
        } else {
            self.from + part * (self.to - self.from)
        }
    }

    /// Its derivative.
    pub(crate) fn slope_beyond(&self, part: f64) -> f64 {
        if self.logarithmic {
            self.beyond(part) * (self.to / self.from).ln()
        } else {
            self.to - self.from
        }
    }

    /// Derivative of the value by the part.
    fn slope(&self, part: f64) -> f64 {
        if self.logarithmic {
            self.value(part) * (self.to / self.from).ln()
        } else {
            self.to - self.from
        }
    }
}

/// How bands are sought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BandSettings {
    /// Intervals of p before refinement.
    pub columns: usize,
    /// Intervals of q before refinement.
    pub rows: usize,
    /// Most columns.
    pub most_columns: usize,
    /// Shortest interval of p, as a part of its range, into which an ambiguous one is divided.
    pub shortest: f64,
}

impl Default for BandSettings {
    fn default() -> Self {
        Self {
            columns: 12,
            rows: 12,
            most_columns: 400,
            shortest: 1e-3,
        }
    }
}

/// What ends a band.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// The range of p.
    Range,
    /// A pair of eigenvalues reaches the imaginary axis inside of the range of q: an extremum of a Hopf curve.
    Hopf,
    /// An eigenvalue reaches zero inside of the range of q: an extremum of a fold curve.
    Fold,
    /// A pair reaches the axis at an end of the range of q.
    HopfAtEnd,
    /// An eigenvalue reaches zero at an end of the range of q.
    FoldAtEnd,
    /// The equilibrium ends.
    NoEquilibrium,
}

/// An end of a band.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Where it is.
    pub p: f64,
    /// Where in the other parameter the eigenvalue reaches the axis; none at the end of the range of p.
    pub q: Option<f64>,
    /// The eigenvalue there.
    pub eigenvalue: Complex64,
    /// Derivative of its real part by p.
    pub slope: f64,
    /// What ends it.
    pub limit: Limit,
    /// Estimated error of p, relative.
    pub error: f64,
}

/// An interval of p in which the equilibrium is stable for every q.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// Lower end.
    pub lower: Edge,
    /// Upper end.
    pub upper: Edge,
}

impl Band {
    /// Upper end less lower end.
    pub fn width(&self) -> f64 {
        self.upper.p - self.lower.p
    }
}

/// A maximum over p and q of the real part of an eigenvalue: above zero the top of an island of instability, below zero one that
/// is not yet born.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// Where it is.
    pub p: f64,
    /// Where it is in the other parameter.
    pub q: f64,
    /// The eigenvalue there.
    pub eigenvalue: Complex64,
}

/// All bands in a range, with how they were found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bands {
    /// The bands, from lower to upper.
    pub bands: Vec<Band>,
    /// Maxima over both parameters that came near the axis.
    pub peaks: Vec<Peak>,
    /// Values of p at which all of q was looked at.
    pub columns: usize,
    /// Points at which eigenvalues were computed.
    pub samples: usize,
    /// Intervals of p that remained ambiguous at the shortest division.
    pub unresolved: Vec<(f64, f64)>,
}

impl Bands {
    /// The widest band; the lower one of two that are equal.
    pub fn widest(&self) -> Option<&Band> {
        let mut best: Option<&Band> = None;
        for band in &self.bands {
            if best.is_none_or(|known| band.width() > known.width()) {
                best = Some(band);
            }
        }
        best
    }
}
