//! Eigenvalues at a point with their slopes.

use num_complex::Complex64;

use super::{Linearisation, ParameterSpan};
use crate::dense::{Lu, eigenvalues};

/// Step of differences of A, as a part of a range: the cube root of the rounding unit.
const STEP: f64 = 6e-6;

/// An eigenvalue with non-negative imaginary part and its slopes by the parts of the ranges.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Mode {
    pub(super) value: Complex64,
    /// By the part of p; zero where it was not asked for.
    pub(super) by_u: Complex64,
    /// By the part of q.
    pub(super) by_s: Complex64,
}

impl Mode {
    /// The eigenvalue a step away, to first order.
    pub(super) fn ahead(&self, du: f64, ds: f64) -> Complex64 {
        self.value + self.by_u * du + self.by_s * ds
    }

    /// The conjugate.
    fn conjugate(self) -> Self {
        Self {
            value: self.value.conj(),
            by_u: self.by_u.conj(),
            by_s: self.by_s.conj(),
        }
    }
}

/// All eigenvalues at a point of the (scaled) rectangle.
#[derive(Clone, Debug)]
pub(super) struct Sample {
    pub(super) s: f64,
    /// Eigenvalues with non-negative imaginary part.
    pub(super) modes: Vec<Mode>,
}

impl Sample {
    /// Largest real part.
    pub(super) fn growth(&self) -> f64 {
        let parts = self.modes.iter().map(|mode| mode.value.re);
        parts.fold(f64::NEG_INFINITY, f64::max)
    }

    /// The eigenvalue next to another.
    pub(super) fn nearest(&self, value: Complex64) -> Option<&Mode> {
        let distance = |mode: &Mode| (mode.value - value).norm_sqr();
        self.modes
            .iter()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }

    /// With those of negative imaginary part.
    pub(super) fn all(&self) -> Vec<Mode> {
        let mut all = Vec::with_capacity(2 * self.modes.len());
        for mode in &self.modes {
            all.push(*mode);
            if mode.value.im > 0.0 {
                all.push(mode.conjugate());
            }
        }
        all
    }
}

/// Which slopes are wanted, and of which eigenvalues.
#[derive(Clone, Copy, Debug)]
pub(super) enum Want {
    /// By q, of all.
    All,
    /// By both parameters, of the one next to this.
    One(Complex64),
}

/// Samples a linearisation over the unit square.
pub(super) struct Sampler<'l, L> {
    linearisation: &'l mut L,
    pub(super) p: ParameterSpan,
    pub(super) q: Option<ParameterSpan>,
    n: usize,
    pub(super) count: usize,
    matrix: Vec<f64>,
    plus: Vec<f64>,
    minus: Vec<f64>,
    shifted: Vec<Complex64>,
    lu: Lu<Complex64>,
    /// A over q at one u, where it is a polynomial there.
    fit: Option<Fit>,
}

/// Degree of the polynomials that are tried for A over q, and the parts of the range at which they are put to the test.
const DEGREE: usize = 4;
const TESTS: [f64; 6] = [0.031, 0.17, 0.35, 0.61, 0.83, 0.97];
/// Entries are those of a polynomial when they agree to this part of the largest entry of their row.
const SAME: f64 = 1e-13;

/// A(u, ·) as a polynomial of q: linear or quadratic in a speed, as a rule.
struct Fit {
    u: f64,
    /// Coefficients of 1, s, s² … of each entry, entry by entry.
    coefficients: Vec<f64>,
}

impl<'l, L: Linearisation> Sampler<'l, L> {
    pub(super) fn new(
        linearisation: &'l mut L,
        p: ParameterSpan,
        q: Option<ParameterSpan>,
    ) -> Self {
        let n = linearisation.states();
        Self {
            linearisation,
            p,
            q,
            n,
            count: 0,
            matrix: vec![0.0; n * n],
            plus: vec![0.0; n * n],
            minus: vec![0.0; n * n],
            shifted: Vec::new(),
            lu: Lu::new(),
            fit: None,
        }
    }

    fn at(&mut self, u: f64, s: f64, into: fn(&mut Self) -> &mut Vec<f64>) -> bool {
        // Beyond an end of p's range by a difference's step: the scale goes on there.
        let end = u.clamp(0.0, 1.0);
        let mut p = self.p.value(end);
        if u != end {
            p += (u - end) * self.p.slope(end);
        }
        let q = self.q.map_or(0.0, |q| q.value(s));
        let mut buffer = std::mem::take(into(self));
        let good = self.linearisation.matrix(p, q, &mut buffer)
            && buffer.iter().all(|entry| entry.is_finite());
        *into(self) = buffer;
        good
    }

    /// Looks whether A is a polynomial of q at this u, so that a column of samples costs no more matrices. Differences of A over s are then
    /// exact derivatives.
    pub(super) fn fit(&mut self, u: f64) {
        self.fit = None;
        if self.q.is_none_or(|q| q.logarithmic) {
            return;
        }
        let size = self.n * self.n;
        let nodes: Vec<f64> = (0..=DEGREE)
            .map(|k| 0.5 - 0.5 * (std::f64::consts::PI * k as f64 / DEGREE as f64).cos())
            .collect();
        // Divided differences, entry by entry, then into powers of s.
        let mut table: Vec<Vec<f64>> = Vec::with_capacity(nodes.len());
        for s in &nodes {
            if !self.at(u, *s, |own| &mut own.matrix) {
                return;
            }
            table.push(self.matrix.clone());
        }
        let mut coefficients = vec![0.0; size * (DEGREE + 1)];
        for entry in 0..size {
            let mut divided: Vec<f64> = table.iter().map(|matrix| matrix[entry]).collect();
            for order in 1..=DEGREE {
                for k in (order..=DEGREE).rev() {
                    divided[k] = (divided[k] - divided[k - 1]) / (nodes[k] - nodes[k - order]);
                }
            }
            let own = &mut coefficients[entry * (DEGREE + 1)..(entry + 1) * (DEGREE + 1)];
            for k in (0..=DEGREE).rev() {
                // own = own (s - node) + divided
                for power in (1..=DEGREE).rev() {
                    own[power] = own[power - 1] - nodes[k] * own[power];
                }
                own[0] = divided[k] - nodes[k] * own[0];
            }
        }
        let fit = Fit { u, coefficients };
        let mut found = vec![0.0; size];
        for s in TESTS {
            if !self.at(u, s, |own| &mut own.matrix) {
                return;
            }
            fit.values(s, &mut found);
            for (row, fitted) in self
                .matrix
                .chunks_exact(self.n)
                .zip(found.chunks_exact(self.n))
            {
                let largest = row
                    .iter()
                    .fold(0.0_f64, |most, entry| most.max(entry.abs()));
                let apart = |(a, b): (&f64, &f64)| (a - b).abs() <= SAME * largest;
                if !row.iter().zip(fitted).all(apart) {
                    return;
                }
            }
        }
        self.fit = Some(fit);
    }

    /// Forgets a polynomial.
    pub(super) fn unfit(&mut self) {
        self.fit = None;
    }

    /// Eigenvalues at (u, s); none where there is no equilibrium.
    pub(super) fn sample(&mut self, u: f64, s: f64, want: Want) -> Option<Sample> {
        self.count += 1;
        let fit = self.fit.take().filter(|fit| fit.u.to_bits() == u.to_bits());
        let found = self.sample_with(u, s, want, fit.as_ref());
        self.fit = fit;
        found
    }

    fn sample_with(&mut self, u: f64, s: f64, want: Want, fit: Option<&Fit>) -> Option<Sample> {
        match fit {
            Some(fit) => fit.values(s, &mut self.matrix),
            None => {
                if !self.at(u, s, |own| &mut own.matrix) {
                    return None;
                }
            }
        }
        let values = eigenvalues(self.n, &self.matrix)?;
        let scale = values.iter().map(|value| value.norm()).fold(0.0, f64::max);
        let mut modes: Vec<Mode> = values
            .into_iter()
            .filter(|value| value.im >= 0.0)
            .map(|value| Mode {
                value,
                ..Mode::default()
            })
            .collect();
        if let Want::One(value) = want {
            let sample = Sample { s, modes };
            modes = vec![*sample.nearest(value)?];
        }
        let vectors: Vec<_> = modes
            .iter_mut()
            .map(|mode| self.vectors(mode, scale))
            .collect();
        if let Some(fit) = fit {
            fit.slopes(s, &mut self.plus);
            for (mode, (left, right)) in modes.iter_mut().zip(&vectors) {
                mode.by_s = self.form(left, right);
            }
        } else if self.q.is_some() {
            // Ends of q's range may be those of the equations' domain, so differences stay inside.
            let (low, high) = ((s - STEP).max(0.0), (s + STEP).min(1.0));
            if !self.at(u, low, |own| &mut own.minus) || !self.at(u, high, |own| &mut own.plus) {
                return None;
            }
            if low == s || high == s {
                self.one_sided(u, s, if low == s { STEP } else { -STEP })?;
            } else {
                self.difference(high - low);
            }
            for (mode, (left, right)) in modes.iter_mut().zip(&vectors) {
                mode.by_s = self.form(left, right);
            }
        }
        if let Want::One(_) = want {
            if !self.at(u - STEP, s, |own| &mut own.minus)
                || !self.at(u + STEP, s, |own| &mut own.plus)
            {
                return None;
            }
            self.difference(2.0 * STEP);
            for (mode, (left, right)) in modes.iter_mut().zip(&vectors) {
                mode.by_u = self.form(left, right);
            }
        }
        Some(Sample { s, modes })
    }

    /// (plus - minus)/width into plus.
    fn difference(&mut self, width: f64) {
        for (plus, minus) in self.plus.iter_mut().zip(&self.minus) {
            *plus = (*plus - minus) / width;
        }
    }

    /// The derivative by s at an end, of second order, into plus.
    fn one_sided(&mut self, u: f64, s: f64, step: f64) -> Option<()> {
        if !self.at(u, s + step, |own| &mut own.plus)
            || !self.at(u, s + 2.0 * step, |own| &mut own.minus)
        {
            return None;
        }
        for ((plus, minus), here) in self.plus.iter_mut().zip(&self.minus).zip(&self.matrix) {
            *plus = (4.0 * *plus - 3.0 * here - minus) / (2.0 * step);
        }
        Some(())
    }

    /// Left and right eigenvectors with wᵀ v = 1; the eigenvalue becomes their Rayleigh quotient, whose error is the square of
    /// that of the vectors.
    fn vectors(&mut self, mode: &mut Mode, scale: f64) -> (Vec<Complex64>, Vec<Complex64>) {
        let n = self.n;
        let shift = mode.value + Complex64::new(4e-16 * scale, 2e-16 * scale);
        self.shifted.clear();
        self.shifted
            .extend(self.matrix.iter().map(|entry| Complex64::new(*entry, 0.0)));
        for i in 0..n {
            self.shifted[i * n + i] -= shift;
        }
        self.lu.factor(n, &self.shifted);
        let start =
            |i: usize| Complex64::new(1.0 + 0.37 * (i as f64).sin(), 0.21 * (1.0 + i as f64).cos());
        let mut right: Vec<Complex64> = (0..n).map(start).collect();
        let mut left = right.clone();
        for _ in 0..2 {
            self.lu.solve(&mut right);
            normalise(&mut right);
            self.lu.solve_transposed(&mut left);
            normalise(&mut left);
        }
        let product: Complex64 = left.iter().zip(&right).map(|(w, v)| w * v).sum();
        for w in &mut left {
            *w /= product;
        }
        let mut quotient = Complex64::default();
        for (row, w) in self.matrix.chunks_exact(n).zip(&left) {
            let image: Complex64 = row.iter().zip(&right).map(|(a, v)| v * *a).sum();
            quotient += w * image;
        }
        // Where vectors fail (a defective eigenvalue) the quotient is of no use.
        if (quotient - mode.value).norm() <= 1e-6 * scale {
            mode.value = if mode.value.im == 0.0 {
                Complex64::new(quotient.re, 0.0)
            } else {
                quotient
            };
        }
        (left, right)
    }

    /// wᵀ plus v.
    fn form(&self, left: &[Complex64], right: &[Complex64]) -> Complex64 {
        let mut sum = Complex64::default();
        for (row, w) in self.plus.chunks_exact(self.n).zip(left) {
            let image: Complex64 = row.iter().zip(right).map(|(a, v)| v * *a).sum();
            sum += w * image;
        }
        sum
    }
}

impl Fit {
    fn values(&self, s: f64, out: &mut [f64]) {
        for (own, out) in self.coefficients.chunks_exact(DEGREE + 1).zip(out) {
            *out = own.iter().rev().fold(0.0, |sum, c| sum * s + c);
        }
    }

    fn slopes(&self, s: f64, out: &mut [f64]) {
        for (own, out) in self.coefficients.chunks_exact(DEGREE + 1).zip(out) {
            let terms = own.iter().enumerate().skip(1).rev();
            *out = terms.fold(0.0, |sum, (power, c)| sum * s + power as f64 * c);
        }
    }
}

fn normalise(x: &mut [Complex64]) {
    let size = x.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt();
    if size.is_finite() && size > 0.0 {
        for entry in x {
            *entry /= size;
        }
    }
}
