//! Partial fractions of a transfer function: H(s) = Σ r_i/(s - λ_i) + Σ d_k s^k.

use num_complex::Complex64;

use crate::dense::Dense;
use crate::eigen::{Decompose, eigen};
use crate::error::ResponseError;
use crate::realisation::Channel;

/// Poles, residues and polynomial part.
#[derive(Debug, Clone)]
pub(crate) struct Residues {
    /// Poles that the output sees, with their residues.
    pub(crate) terms: Vec<(Complex64, Complex64)>,
    /// All poles.
    pub(crate) poles: Vec<Complex64>,
    pub(crate) polynomial: Vec<Complex64>,
}

/// Componentwise cancellation to this part means that a mode is not excited or not seen.
const UNSEEN: f64 = 1e-12;

impl Residues {
    /// `None` where the eigenvectors cannot be inverted.
    pub(crate) fn new<T: Decompose>(channel: &Channel<T>) -> Result<Option<Self>, ResponseError> {
        let n = channel.a.rows();
        let (poles, vectors) = eigen(&channel.a)?;
        let polynomial = channel.d.iter().map(|d| d.complex()).collect();
        let Some(lu) = vectors.lu() else {
            return Ok(None);
        };
        let inverse = lu.inverse();
        let (b, c): (Vec<Complex64>, Vec<Complex64>) = (
            channel.b.iter().map(|b| b.complex()).collect(),
            channel.c.iter().map(|c| c.complex()).collect(),
        );
        let mut terms = Vec::with_capacity(n);
        for i in 0..n {
            let (mut seen, mut seen_size) = (Complex64::ZERO, 0.0);
            let (mut excited, mut excited_size) = (Complex64::ZERO, 0.0);
            for k in 0..n {
                let (s, e) = (c[k] * vectors.get(k, i), inverse.get(i, k) * b[k]);
                seen += s;
                seen_size += s.norm();
                excited += e;
                excited_size += e.norm();
            }
            if seen.norm() > UNSEEN * seen_size && excited.norm() > UNSEEN * excited_size {
                terms.push((poles[i], seen * excited));
            }
        }
        if terms.iter().all(|(_, residue)| residue.is_finite()) {
            Ok(Some(Self {
                terms,
                poles,
                polynomial,
            }))
        } else {
            Ok(None)
        }
    }

    /// H and its first two derivatives by ω.
    pub(crate) fn at(&self, omega: f64) -> [Complex64; 3] {
        let s = Complex64::new(0.0, omega);
        let mut h = polynomial(&self.polynomial, omega);
        for &(pole, residue) in &self.terms {
            let inverse = (s - pole).inv();
            let value = residue * inverse;
            let first = value * inverse;
            h[0] += value;
            h[1] += Complex64::new(first.im, -first.re);
            h[2] -= first * inverse * 2.0;
        }
        h
    }

    /// A bound of |H'''| on [middle - half, middle + half].
    pub(crate) fn third(&self, middle: f64, half: f64) -> f64 {
        let mut bound = polynomial_third(&self.polynomial, middle.abs() + half);
        for &(pole, residue) in &self.terms {
            let away = ((pole.im - middle).abs() - half).max(0.0);
            let square = pole.re * pole.re + away * away;
            bound += 6.0 * residue.norm() / (square * square);
        }
        bound
    }
}

/// Σ d_k (jω)^k and its derivatives by ω.
pub(crate) fn polynomial(coefficients: &[Complex64], omega: f64) -> [Complex64; 3] {
    let s = Complex64::new(0.0, omega);
    let (mut p, mut d1, mut d2) = (Complex64::ZERO, Complex64::ZERO, Complex64::ZERO);
    for &coefficient in coefficients.iter().rev() {
        d2 = d2 * s + d1 * 2.0;
        d1 = d1 * s + p;
        p = p * s + coefficient;
    }
    [p, d1 * Complex64::new(0.0, 1.0), -d2]
}

pub(crate) fn polynomial_third(coefficients: &[Complex64], omega: f64) -> f64 {
    coefficients
        .iter()
        .enumerate()
        .skip(3)
        .map(|(k, d)| d.norm() * (k * (k - 1) * (k - 2)) as f64 * omega.powf(k as f64 - 3.0))
        .sum()
}

/// The resolvent of a state matrix, for systems whose eigenvectors are useless.
pub(crate) struct Resolvent<T> {
    channel: Channel<T>,
    polynomial: Vec<Complex64>,
}

impl<T: Decompose> Resolvent<T> {
    /// Takes the channel in balanced coordinates.
    pub(crate) fn new(channel: &Channel<T>) -> Self {
        let (a, scale) = crate::eigen::balance(&channel.a);
        let b = channel
            .b
            .iter()
            .zip(&scale)
            .map(|(&b, &d)| b * (1.0 / d))
            .collect();
        let c = channel.c.iter().zip(&scale).map(|(&c, &d)| c * d).collect();
        let polynomial = channel.d.iter().map(|d| d.complex()).collect();
        Self {
            channel: Channel {
                a,
                b,
                c,
                d: channel.d.clone(),
            },
            polynomial,
        }
    }

    /// H, H', H'' at the middle and a bound of |H'''| within `half`.
    ///
    /// With R = (jω I - A)^-1 and σ its smallest inverse singular value, ‖R(ω + t)‖ ≤ 1/(σ - |t|) and
    /// |c R⁴ b| ≤ ‖c R‖ ‖R²‖ ‖R b‖.
    pub(crate) fn at(&self, omega: f64, half: f64) -> Option<([Complex64; 3], f64)> {
        let n = self.channel.a.rows();
        let mut h = polynomial(&self.polynomial, omega);
        let tail = polynomial_third(&self.polynomial, omega.abs() + half);
        if n == 0 {
            return Some((h, tail));
        }
        let s = Complex64::new(0.0, omega);
        let matrix = Dense::from_fn(
            n,
            n,
            |i, j| if i == j { s } else { Complex64::ZERO } - self.channel.a.get(i, j).complex(),
        );
        let lu = matrix.lu()?;
        let first = lu.solve(&Dense::from_fn(n, 1, |i, _| self.channel.b[i].complex()));
        let second = lu.solve(&first);
        let third = lu.solve(&second);
        let watch = |x: &Dense<Complex64>| -> Complex64 {
            x.data()
                .iter()
                .zip(&self.channel.c)
                .map(|(x, c)| x * c.complex())
                .sum()
        };
        let (h0, h1) = (watch(&first), watch(&second));
        h[0] += h0;
        h[1] += Complex64::new(h1.im, -h1.re);
        h[2] -= watch(&third) * 2.0;
        let row = matrix
            .transpose()
            .lu()?
            .solve(&Dense::from_fn(n, 1, |i, _| self.channel.c[i].complex()));
        let norm =
            |x: &Dense<Complex64>| x.data().iter().map(Complex64::norm_sqr).sum::<f64>().sqrt();
        let faer = faer::Mat::from_fn(n, n, |i, j| matrix.get(i, j));
        let sigma = faer
            .singular_values()
            .ok()?
            .into_iter()
            .fold(f64::INFINITY, f64::min);
        if sigma.is_nan() || half >= sigma {
            return Some((h, f64::INFINITY));
        }
        let growth = 1.0 / (1.0 - half / sigma);
        let bound = 6.0 * norm(&row) * norm(&first) * growth * growth / (sigma - half).powi(2);
        Some((h, bound + tail))
    }
}
