//! Small dense matrices over the real or complex numbers, with an equilibrated LU.
//!
//! Row-major, allocated once; the systems of this crate rarely have more than a few dozen unknowns, where a plain
//! triple loop is faster than a blocked library routine. Eigenvalues and singular values come from faer.

use num_complex::Complex64;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// A real or complex number.
pub(crate) trait Scalar:
    Copy
    + std::fmt::Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + Mul<f64, Output = Self>
    + Send
    + Sync
    + 'static
{
    const ZERO: Self;
    const ONE: Self;
    fn modulus(self) -> f64;
    fn real(value: f64) -> Self;
    fn complex(self) -> Complex64;
    fn finite(self) -> bool;
}

impl Scalar for f64 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    #[inline]
    fn modulus(self) -> f64 {
        self.abs()
    }
    #[inline]
    fn real(value: f64) -> Self {
        value
    }
    #[inline]
    fn complex(self) -> Complex64 {
        Complex64::new(self, 0.0)
    }
    #[inline]
    fn finite(self) -> bool {
        self.is_finite()
    }
}

impl Scalar for Complex64 {
    const ZERO: Self = Self::new(0.0, 0.0);
    const ONE: Self = Self::new(1.0, 0.0);
    #[inline]
    fn modulus(self) -> f64 {
        // |re| + |im|: pivots need an order, not the exact modulus.
        self.re.abs() + self.im.abs()
    }
    #[inline]
    fn real(value: f64) -> Self {
        Self::new(value, 0.0)
    }
    #[inline]
    fn complex(self) -> Complex64 {
        self
    }
    #[inline]
    fn finite(self) -> bool {
        self.re.is_finite() && self.im.is_finite()
    }
}

/// A dense matrix, row-major.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Dense<T> {
    rows: usize,
    columns: usize,
    data: Vec<T>,
}

impl<T: Scalar> Dense<T> {
    pub(crate) fn zeros(rows: usize, columns: usize) -> Self {
        Self {
            rows,
            columns,
            data: vec![T::ZERO; rows * columns],
        }
    }

    pub(crate) fn identity(size: usize) -> Self {
        Self::from_fn(size, size, |i, j| if i == j { T::ONE } else { T::ZERO })
    }

    pub(crate) fn from_fn(
        rows: usize,
        columns: usize,
        mut entry: impl FnMut(usize, usize) -> T,
    ) -> Self {
        let mut data = Vec::with_capacity(rows * columns);
        for i in 0..rows {
            for j in 0..columns {
                data.push(entry(i, j));
            }
        }
        Self {
            rows,
            columns,
            data,
        }
    }

    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    pub(crate) fn columns(&self) -> usize {
        self.columns
    }

    #[inline]
    pub(crate) fn get(&self, i: usize, j: usize) -> T {
        self.data[i * self.columns + j]
    }

    #[inline]
    pub(crate) fn set(&mut self, i: usize, j: usize, value: T) {
        self.data[i * self.columns + j] = value;
    }

    #[inline]
    pub(crate) fn add(&mut self, i: usize, j: usize, value: T) {
        self.data[i * self.columns + j] += value;
    }

    pub(crate) fn row(&self, i: usize) -> &[T] {
        &self.data[i * self.columns..(i + 1) * self.columns]
    }

    pub(crate) fn row_mut(&mut self, i: usize) -> &mut [T] {
        &mut self.data[i * self.columns..(i + 1) * self.columns]
    }

    pub(crate) fn data(&self) -> &[T] {
        &self.data
    }

    pub(crate) fn is_finite(&self) -> bool {
        self.data.iter().all(|value| value.finite())
    }

    pub(crate) fn is_zero(&self) -> bool {
        self.data.iter().all(|value| value.modulus() == 0.0)
    }

    /// Largest modulus of an entry.
    pub(crate) fn largest(&self) -> f64 {
        self.data
            .iter()
            .fold(0.0, |largest, value| largest.max(value.modulus()))
    }

    /// The largest row sum of moduli.
    pub(crate) fn norm(&self) -> f64 {
        (0..self.rows)
            .map(|i| self.row(i).iter().map(|value| value.modulus()).sum::<f64>())
            .fold(0.0, f64::max)
    }

    pub(crate) fn transpose(&self) -> Self {
        Self::from_fn(self.columns, self.rows, |i, j| self.get(j, i))
    }

    pub(crate) fn map<U: Scalar>(&self, convert: impl Fn(T) -> U) -> Dense<U> {
        Dense {
            rows: self.rows,
            columns: self.columns,
            data: self.data.iter().map(|&value| convert(value)).collect(),
        }
    }

    pub(crate) fn scale(&self, factor: f64) -> Self {
        self.map(|value| value * factor)
    }

    /// The product of this matrix and `other`.
    pub(crate) fn times(&self, other: &Self) -> Self {
        debug_assert_eq!(self.columns, other.rows);
        let mut product = Self::zeros(self.rows, other.columns);
        for i in 0..self.rows {
            for k in 0..self.columns {
                let factor = self.get(i, k);
                if factor.modulus() == 0.0 {
                    continue;
                }
                for j in 0..other.columns {
                    product.data[i * other.columns + j] += factor * other.get(k, j);
                }
            }
        }
        product
    }

    pub(crate) fn plus(&self, other: &Self) -> Self {
        debug_assert_eq!((self.rows, self.columns), (other.rows, other.columns));
        let data = self
            .data
            .iter()
            .zip(&other.data)
            .map(|(&a, &b)| a + b)
            .collect();
        Self {
            rows: self.rows,
            columns: self.columns,
            data,
        }
    }

    pub(crate) fn minus(&self, other: &Self) -> Self {
        debug_assert_eq!((self.rows, self.columns), (other.rows, other.columns));
        let data = self
            .data
            .iter()
            .zip(&other.data)
            .map(|(&a, &b)| a - b)
            .collect();
        Self {
            rows: self.rows,
            columns: self.columns,
            data,
        }
    }

    /// The block of the given rows and columns.
    pub(crate) fn block(
        &self,
        rows: std::ops::Range<usize>,
        columns: std::ops::Range<usize>,
    ) -> Self {
        let (row, column) = (rows.start, columns.start);
        Self::from_fn(rows.len(), columns.len(), |i, j| {
            self.get(row + i, column + j)
        })
    }

    /// Writes `block` with its first entry at (`row`, `column`).
    pub(crate) fn place(&mut self, row: usize, column: usize, block: &Self) {
        for i in 0..block.rows {
            for j in 0..block.columns {
                self.set(row + i, column + j, block.get(i, j));
            }
        }
    }

    /// LU with partial pivoting after row and column scaling by powers of two; `None` where a pivot vanishes.
    pub(crate) fn lu(&self) -> Option<Lu<T>> {
        Lu::new(self)
    }
}

impl Dense<f64> {
    pub(crate) fn from_faer(matrix: &faer::Mat<f64>) -> Self {
        Self::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)])
    }
}

/// A factorised square matrix.
#[derive(Debug, Clone)]
pub(crate) struct Lu<T> {
    factors: Dense<T>,
    pivots: Vec<usize>,
    row_scale: Vec<f64>,
    column_scale: Vec<f64>,
}

fn power_of_two_inverse(value: f64) -> f64 {
    if value > 0.0 && value.is_finite() {
        (-value.log2().round()).clamp(-1000.0, 1000.0).exp2()
    } else {
        1.0
    }
}

impl<T: Scalar> Lu<T> {
    fn new(matrix: &Dense<T>) -> Option<Self> {
        debug_assert_eq!(matrix.rows, matrix.columns);
        if !matrix.is_finite() {
            return None;
        }
        let n = matrix.rows;
        let mut factors = matrix.clone();
        let row_scale: Vec<f64> = (0..n)
            .map(|i| {
                power_of_two_inverse(
                    factors
                        .row(i)
                        .iter()
                        .fold(0.0, |m: f64, v| m.max(v.modulus())),
                )
            })
            .collect();
        for i in 0..n {
            for value in factors.row_mut(i) {
                *value = *value * row_scale[i];
            }
        }
        let column_scale: Vec<f64> = (0..n)
            .map(|j| {
                power_of_two_inverse(
                    (0..n).fold(0.0, |m: f64, i| m.max(factors.get(i, j).modulus())),
                )
            })
            .collect();
        for i in 0..n {
            for (value, scale) in factors.row_mut(i).iter_mut().zip(&column_scale) {
                *value = *value * *scale;
            }
        }
        let mut pivots = vec![0; n];
        for k in 0..n {
            let pivot = (k..n).max_by(|&a, &b| {
                factors
                    .get(a, k)
                    .modulus()
                    .total_cmp(&factors.get(b, k).modulus())
            })?;
            let size = factors.get(pivot, k).modulus();
            if size.is_nan() || size <= 1e-300 {
                return None;
            }
            pivots[k] = pivot;
            if pivot != k {
                for j in 0..n {
                    factors.data.swap(k * n + j, pivot * n + j);
                }
            }
            let inverse = T::ONE / factors.get(k, k);
            for i in k + 1..n {
                let factor = factors.get(i, k) * inverse;
                factors.set(i, k, factor);
                if factor.modulus() != 0.0 {
                    for j in k + 1..n {
                        let value = factors.get(k, j);
                        factors.data[i * n + j] -= factor * value;
                    }
                }
            }
        }
        Some(Self {
            factors,
            pivots,
            row_scale,
            column_scale,
        })
    }

    /// Smallest over largest pivot of the scaled matrix: a crude measure of how singular it is.
    pub(crate) fn pivot_ratio(&self) -> f64 {
        let n = self.factors.rows;
        let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
        for k in 0..n {
            let size = self.factors.get(k, k).modulus();
            least = least.min(size);
            most = most.max(size);
        }
        if n == 0 { 1.0 } else { least / most }
    }

    /// Solves A x = b for every column of `right`.
    pub(crate) fn solve(&self, right: &Dense<T>) -> Dense<T> {
        let n = self.factors.rows;
        let m = right.columns;
        let mut x = right.clone();
        for i in 0..n {
            for value in x.row_mut(i) {
                *value = *value * self.row_scale[i];
            }
        }
        // Rows of L were exchanged by later pivots as well, so all exchanges come first.
        for (k, &pivot) in self.pivots.iter().enumerate() {
            if pivot != k {
                for j in 0..m {
                    x.data.swap(k * m + j, pivot * m + j);
                }
            }
        }
        for k in 0..n {
            for i in k + 1..n {
                let factor = self.factors.get(i, k);
                if factor.modulus() != 0.0 {
                    for j in 0..m {
                        let value = x.get(k, j);
                        x.data[i * m + j] -= factor * value;
                    }
                }
            }
        }
        for k in (0..n).rev() {
            for i in k + 1..n {
                let factor = self.factors.get(k, i);
                if factor.modulus() != 0.0 {
                    for j in 0..m {
                        let value = x.get(i, j);
                        x.data[k * m + j] -= factor * value;
                    }
                }
            }
            let inverse = T::ONE / self.factors.get(k, k);
            for value in x.row_mut(k) {
                *value = *value * inverse;
            }
        }
        for i in 0..n {
            for value in x.row_mut(i) {
                *value = *value * self.column_scale[i];
            }
        }
        x
    }

    pub(crate) fn inverse(&self) -> Dense<T> {
        self.solve(&Dense::identity(self.factors.rows))
    }
}

/// A null space in echelon form: unit entries on the free columns.
#[derive(Debug, Clone)]
pub(crate) struct NullSpace {
    /// Columns that carry the rank, ascending.
    pub(crate) pivots: Vec<usize>,
    /// Columns that are free, ascending: one null vector each.
    pub(crate) free: Vec<usize>,
    /// The null vectors as columns (size × free): identity on the free rows.
    pub(crate) basis: Dense<f64>,
}

/// Null space of `matrix` (any shape) by Gauss-Jordan elimination with complete pivoting.
///
/// On matrices whose rows are incidence vectors all entries stay 0 or ±1, so that rank and basis are exact.
/// `tolerance` is relative to the largest entry.
pub(crate) fn null_space(matrix: &Dense<f64>, tolerance: f64) -> NullSpace {
    let (rows, columns) = (matrix.rows, matrix.columns);
    let mut work = matrix.clone();
    let cut = tolerance * work.largest();
    let mut pivot_of_row: Vec<usize> = Vec::new();
    let mut used = vec![false; columns];
    for k in 0..rows.min(columns) {
        let mut best = (0.0, 0, 0);
        for i in k..rows {
            for j in 0..columns {
                let size = work.get(i, j).abs();
                // Ties (which incidence matrices have everywhere) go to the first entry.
                if !used[j] && size > best.0 * (1.0 + 1e-9) {
                    best = (size, i, j);
                }
            }
        }
        if best.0 <= cut || best.0 == 0.0 {
            break;
        }
        let (_, pivot_row, pivot) = best;
        for j in 0..columns {
            work.data.swap(k * columns + j, pivot_row * columns + j);
        }
        used[pivot] = true;
        pivot_of_row.push(pivot);
        let inverse = 1.0 / work.get(k, pivot);
        for value in work.row_mut(k) {
            *value *= inverse;
        }
        for i in 0..rows {
            let factor = work.get(i, pivot);
            if i != k && factor != 0.0 {
                for j in 0..columns {
                    let value = work.get(k, j);
                    work.data[i * columns + j] -= factor * value;
                }
            }
        }
    }
    let free: Vec<usize> = (0..columns).filter(|&j| !used[j]).collect();
    let mut basis = Dense::zeros(columns, free.len());
    for (c, &j) in free.iter().enumerate() {
        basis.set(j, c, 1.0);
        for (row, &pivot) in pivot_of_row.iter().enumerate() {
            basis.set(pivot, c, snap(-work.get(row, j)));
        }
    }
    let mut pivots = pivot_of_row;
    pivots.sort_unstable();
    NullSpace {
        pivots,
        free,
        basis,
    }
}

/// Rounds to the nearest integer where rounding errors are the only difference.
pub(crate) fn snap(value: f64) -> f64 {
    let nearest = value.round();
    if (value - nearest).abs() < 1e-11 {
        nearest
    } else {
        value
    }
}
