//! LU factorisation with partial pivoting, real or complex.

use std::ops::{Add, Div, Mul, Neg, Sub};

use num_complex::Complex64;

/// What the kernels need of a number.
pub(crate) trait Scalar:
    Copy
    + Default
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// |Re| + |Im|.
    fn size(self) -> f64;
    /// The real number as one of this kind.
    fn real(x: f64) -> Self;
}

impl Scalar for f64 {
    fn size(self) -> f64 {
        self.abs()
    }
    fn real(x: f64) -> Self {
        x
    }
}

impl Scalar for Complex64 {
    fn size(self) -> f64 {
        self.re.abs() + self.im.abs()
    }
    fn real(x: f64) -> Self {
        Self::new(x, 0.0)
    }
}

/// P A = L U of a square row-major matrix; buffers are kept between factorisations.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lu<S> {
    n: usize,
    a: Vec<S>,
    pivots: Vec<usize>,
    odd: bool,
    scale: f64,
}

impl<S: Scalar> Lu<S> {
    /// An empty factorisation.
    pub(crate) fn new() -> Self {
        Self {
            n: 0,
            a: Vec::new(),
            pivots: Vec::new(),
            odd: false,
            scale: 0.0,
        }
    }

    /// The factorisation of `a` (n × n).
    pub(crate) fn of(n: usize, a: &[S]) -> Self {
        let mut lu = Self::new();
        lu.factor(n, a);
        lu
    }

    /// Factors `a`. An exactly zero pivot is replaced by one at rounding level, as inverse iteration wants it;
    /// returns false where an entry is not finite.
    pub(crate) fn factor(&mut self, n: usize, a: &[S]) -> bool {
        self.n = n;
        self.a.clear();
        self.a.extend_from_slice(a);
        self.pivots.clear();
        self.odd = false;
        self.scale = 0.0;
        for x in &self.a {
            let size = x.size();
            if !size.is_finite() {
                return false;
            }
            self.scale = self.scale.max(size);
        }
        let tiny = self.scale.max(f64::MIN_POSITIVE) * f64::EPSILON * 0.1;
        for k in 0..n {
            let mut pivot = k;
            let mut best = self.a[k * n + k].size();
            for i in k + 1..n {
                let size = self.a[i * n + k].size();
                if size > best {
                    best = size;
                    pivot = i;
                }
            }
            self.pivots.push(pivot);
            if pivot != k {
                self.odd = !self.odd;
                let (top, bottom) = self.a.split_at_mut(pivot * n);
                top[k * n..(k + 1) * n].swap_with_slice(&mut bottom[..n]);
            }
            if best < tiny {
                self.a[k * n + k] = S::real(tiny);
            }
            let inverse = S::real(1.0) / self.a[k * n + k];
            let (top, bottom) = self.a.split_at_mut((k + 1) * n);
            let row = &top[k * n + k + 1..(k + 1) * n];
            for other in bottom.chunks_exact_mut(n) {
                let l = other[k] * inverse;
                other[k] = l;
                if l.size() != 0.0 {
                    for (x, y) in other[k + 1..].iter_mut().zip(row) {
                        *x = *x - l * *y;
                    }
                }
            }
        }
        true
    }

    /// Solves A X = B in place for a row-major B of any number of columns.
    pub(crate) fn solve_rows(&self, b: &mut [S]) {
        let n = self.n;
        let width = b.len() / n.max(1);
        let row = |k: usize| k * width..(k + 1) * width;
        let minus = |l: S, from: &[S], to: &mut [S]| {
            for (x, y) in to.iter_mut().zip(from) {
                *x = *x - l * *y;
            }
        };
        for (k, p) in self.pivots.iter().enumerate() {
            if *p != k {
                let (top, bottom) = b.split_at_mut(p * width);
                top[row(k)].swap_with_slice(&mut bottom[..width]);
            }
        }
        for i in 1..n {
            let (top, bottom) = b.split_at_mut(i * width);
            for k in 0..i {
                minus(self.a[i * n + k], &top[row(k)], &mut bottom[..width]);
            }
        }
        for i in (0..n).rev() {
            let (top, bottom) = b.split_at_mut((i + 1) * width);
            let own = &mut top[row(i)];
            for (k, from) in (i + 1..n).zip(bottom.chunks_exact(width)) {
                minus(self.a[i * n + k], from, own);
            }
            let inverse = S::real(1.0) / self.a[i * n + i];
            for x in own {
                *x = *x * inverse;
            }
        }
    }

    /// Solves A x = b in place.
    pub(crate) fn solve(&self, b: &mut [S]) {
        let n = self.n;
        for k in 0..n {
            b.swap(k, self.pivots[k]);
        }
        for i in 1..n {
            let mut sum = b[i];
            for j in 0..i {
                sum = sum - self.a[i * n + j] * b[j];
            }
            b[i] = sum;
        }
        for i in (0..n).rev() {
            let mut sum = b[i];
            for j in i + 1..n {
                sum = sum - self.a[i * n + j] * b[j];
            }
            b[i] = sum / self.a[i * n + i];
        }
    }

    /// Solves Aᵀ x = b in place (transposed, not conjugated).
    pub(crate) fn solve_transposed(&self, b: &mut [S]) {
        let n = self.n;
        for i in 0..n {
            let mut sum = b[i];
            for j in 0..i {
                sum = sum - self.a[j * n + i] * b[j];
            }
            b[i] = sum / self.a[i * n + i];
        }
        for i in (0..n).rev() {
            let mut sum = b[i];
            for j in i + 1..n {
                sum = sum - self.a[j * n + i] * b[j];
            }
            b[i] = sum;
        }
        for k in (0..n).rev() {
            b.swap(k, self.pivots[k]);
        }
    }
}

impl Lu<f64> {
    /// log |det A|.
    pub(crate) fn log_determinant(&self) -> f64 {
        (0..self.n).map(|i| self.a[i * self.n + i].abs().ln()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_both_ways() {
        let a = [2.0, -1.0, 0.5, 4.0, 0.0, 1.0, -3.0, 2.0, 5.0];
        let lu = Lu::of(3, &a);
        let x = [1.0, -2.0, 3.0];
        let mut b = [0.0; 3];
        super::super::multiply(&a, &x, &mut b);
        lu.solve(&mut b);
        for (x, b) in x.iter().zip(&b) {
            assert!((x - b).abs() < 1e-14);
        }
        let columns = [[1.0, -2.0, 3.0], [0.5, 4.0, -1.0]];
        let mut rows = [0.0; 6];
        for (k, column) in columns.iter().enumerate() {
            let mut b = [0.0; 3];
            super::super::multiply(&a, column, &mut b);
            for i in 0..3 {
                rows[2 * i + k] = b[i];
            }
        }
        lu.solve_rows(&mut rows);
        for (k, column) in columns.iter().enumerate() {
            for i in 0..3 {
                assert!((rows[2 * i + k] - column[i]).abs() < 1e-14);
            }
        }
        let mut c = [0.0; 3];
        for j in 0..3 {
            c[j] = (0..3).map(|i| a[i * 3 + j] * x[i]).sum();
        }
        lu.solve_transposed(&mut c);
        for (x, c) in x.iter().zip(&c) {
            assert!((x - c).abs() < 1e-14);
        }
    }
}
