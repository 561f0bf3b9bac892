//! Pseudo-arclength continuation of the solutions of any system with one more unknown than equations.

mod correct;
mod detect;
mod follow;
mod matching;
mod predict;

use num_complex::Complex64;

pub(crate) use correct::Corrector;
pub(crate) use follow::{Start, Trace, follow_both};

use crate::dense::Spectrum;
use crate::kind::{Certainty, Kind};

/// Why a correction failed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Failure {
    /// Too many iterations or growing corrections.
    NoConvergence(f64),
    /// A value is not finite.
    NotFinite,
    /// The bordered matrix is singular.
    Singular,
}

/// A system F(z) = 0 of `len() - 1` equations in `len()` unknowns.
pub(crate) trait Manifold {
    /// Number of unknowns.
    fn len(&self) -> usize;
    /// F(z) into the first `len() - 1` entries.
    fn residual(&mut self, z: &[f64], out: &mut [f64]) -> Result<(), Failure>;
    /// Linearises and factors at z.
    fn factor(&mut self, z: &[f64]) -> Result<(), Failure>;
    /// Completes the factored Jacobian by a row.
    fn border(&mut self, row: &[f64]) -> Result<(), Failure>;
    /// Solves [F_z; row] x = b in place.
    fn solve(&mut self, b: &mut [f64]);
    /// Diagonal of the metric of z.
    fn weights(&self) -> &[f64];
    /// Indices in z of the free parameters, the branch's own first.
    fn parameters(&self) -> Vec<usize>;
    /// Updates scales after an accepted point.
    fn rescale(&mut self, z: &[f64]);
    /// Whether a factorisation may serve several iterations.
    fn chord(&self) -> bool {
        false
    }
    /// Whether a factorisation costs so much more than a solution that the last one of a correction shall serve the point itself.
    fn keeps(&self) -> bool {
        false
    }
    /// Which test functions the next points need.
    fn attend(&mut self, _which: Attention) {}
    /// Eigenvalues or multipliers at z, the factorisation being current; rates by dz/ds = tangent.
    fn spectrum(&mut self, z: &[f64], tangent: &[f64]) -> Spectrum;
    /// Signed distance of an eigenvalue from stability: positive is unstable.
    fn distance(&self, value: Complex64) -> f64;
    /// How far two eigenvalues are apart, in the coordinate in which they move smoothly.
    fn gap(&self, a: Complex64, b: Complex64) -> f64 {
        (a - b).norm()
    }
    /// A gap between matched eigenvalues beyond which a step is too long to say how one became the other.
    fn longest_gap(&self) -> f64 {
        f64::INFINITY
    }
    /// Whether a test function of its own finds what happens where an eigenvalue goes from a to b; spectra are not looked at then.
    fn tested(&self, _a: Complex64, _b: Complex64) -> bool {
        false
    }
    /// Derivative of the distance.
    fn distance_rate(&self, value: Complex64, rate: Complex64) -> f64;
    /// Test functions whose simple zeros are special points.
    fn tests(&mut self, _z: &[f64], _tangent: &[f64], _spectrum: &Spectrum) -> Vec<f64> {
        Vec::new()
    }
    /// What a located zero is, or None where it is nothing.
    fn classify(&mut self, found: &Found<'_>) -> Option<Label>;
    /// Adapts the representation (mesh) at an accepted point; true if z and the tangents changed.
    fn adapt(&mut self, _z: &mut Vec<f64>, _tangents: &mut [&mut Vec<f64>], _count: usize) -> bool {
        false
    }
    /// Called at every accepted point (phase reference).
    fn accept(&mut self, _z: &[f64]) {}
    /// A reason of its own to stop after this point.
    fn stop(&mut self, _before: &Node, _now: &Node) -> Option<crate::Stop> {
        None
    }
    /// The mesh that z lives on, for storage.
    fn mesh(&self) -> Vec<f64> {
        Vec::new()
    }
    /// Restores representation and phase reference to a stored node before following in the other direction.
    fn restart(&mut self, _node: &Node) {}
    /// Whether a test's zero ends the branch, after the point is labelled.
    fn ends(&self, _kind: Kind) -> bool {
        false
    }
}

/// Which test functions are looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Attention {
    /// All of them.
    #[default]
    All,
    /// One.
    Test(usize),
    /// None: an eigenvalue is followed.
    Spectrum,
}

/// A computed point with what detection needs.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub(crate) z: Vec<f64>,
    /// Unit tangent in the metric.
    pub(crate) tangent: Vec<f64>,
    pub(crate) spectrum: Spectrum,
    pub(crate) tests: Vec<f64>,
    pub(crate) mesh: Vec<f64>,
    /// What its eigenvalues were at the point before, and how far away that is; None where their rates are known.
    pub(crate) history: Option<(Vec<Complex64>, f64)>,
}

impl Node {
    /// Number of eigenvalues beyond the axis.
    pub(crate) fn unstable<M: Manifold>(&self, m: &M) -> usize {
        self.spectrum
            .values
            .iter()
            .filter(|v| m.distance(**v) > 0.0)
            .count()
    }
}

/// What was found between two points.
pub(crate) struct Found<'a> {
    pub(crate) node: &'a Node,
    pub(crate) trigger: Trigger,
    /// The tangents before and after.
    pub(crate) before: &'a Node,
    pub(crate) after: &'a Node,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Trigger {
    /// This eigenvalue is on the axis and crosses it.
    Crossing(Complex64),
    /// This eigenvalue touches the axis and goes back.
    Touch(Complex64),
    /// The test function of this index is zero.
    Test(usize),
}

/// What a found point is.
#[derive(Clone, Debug)]
pub(crate) struct Label {
    pub(crate) kind: Kind,
    pub(crate) omega: Option<f64>,
    pub(crate) second_omega: Option<f64>,
    pub(crate) normal_form: Vec<f64>,
}

impl Label {
    pub(crate) fn plain(kind: Kind) -> Self {
        Self {
            kind,
            omega: None,
            second_omega: None,
            normal_form: Vec::new(),
        }
    }
}

/// A special point of a trace.
#[derive(Clone, Debug)]
pub(crate) struct Located {
    pub(crate) label: Label,
    pub(crate) node: Node,
    pub(crate) before: usize,
    pub(crate) after: usize,
    pub(crate) certainty: Certainty,
    /// Uncertainty of the position, scaled arclength.
    pub(crate) error: f64,
    /// Index of the point after which it lies.
    pub(crate) index: usize,
}

/// Σ w a b.
pub(crate) fn inner(w: &[f64], a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let n = w.len().min(a.len()).min(b.len());
    let whole = n - n % 4;
    for k in (0..whole).step_by(4) {
        let (w, a, b) = (&w[k..k + 4], &a[k..k + 4], &b[k..k + 4]);
        for i in 0..4 {
            sums[i] += w[i] * a[i] * b[i];
        }
    }
    for k in whole..n {
        sums[0] += w[k] * a[k] * b[k];
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}

/// The direction of the other branch at a branch point: a null vector of [F_z; row] by inverse iteration, made orthogonal
/// to the tangent. The factorisation must be current and bordered by `row`.
pub(crate) fn second_direction<M: Manifold>(m: &mut M, row: &[f64], tangent: &[f64]) -> Vec<f64> {
    let n = m.len();
    let mut x: Vec<f64> = (0..n).map(|i| (1.0 + i as f64).sin()).collect();
    for _ in 0..3 {
        m.solve(&mut x);
        let size = inner(m.weights(), &x, &x).sqrt();
        if !(size > 0.0 && size.is_finite()) {
            break;
        }
        for x in &mut x {
            *x /= size;
        }
        let along: f64 = row.iter().zip(&x).map(|(r, x)| r * x).sum();
        let length: f64 = row.iter().zip(tangent).map(|(r, t)| r * t).sum();
        for (x, t) in x.iter_mut().zip(tangent) {
            *x -= along / length * t;
        }
    }
    let size = inner(m.weights(), &x, &x).sqrt();
    for x in &mut x {
        *x /= size;
    }
    // The largest component is positive, so that both halves are told apart reproducibly.
    let mut best = 0.0_f64;
    for x in &x {
        if x.abs() > best.abs() * (1.0 + 1e-6) {
            best = *x;
        }
    }
    if best < 0.0 {
        for x in &mut x {
            *x = -*x;
        }
    }
    x
}
