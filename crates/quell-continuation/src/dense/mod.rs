//! Dense kernels for small matrices, row major, without allocation in inner loops.
//!
//! General libraries allocate per call and block for sizes that never occur here; below about forty states these plain
//! loops are faster.

mod eigen;
mod lu;
mod product;

pub(crate) use eigen::{Spectrum, eigenvalues, eigenvector, left_eigenvector};
pub(crate) use lu::Lu;
pub(crate) use product::product_eigenvalues;

/// Σ `a_i` `b_i`.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    // Four sums at once: a single one would wait for every addition.
    let mut sums = [0.0; 4];
    let n = a.len().min(b.len());
    let (a, b) = (a[..n].chunks_exact(4), b[..n].chunks_exact(4));
    let mut rest = 0.0;
    for (x, y) in a.remainder().iter().zip(b.remainder()) {
        rest += x * y;
    }
    for (x, y) in a.zip(b) {
        for k in 0..4 {
            sums[k] += x[k] * y[k];
        }
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3]) + rest
}

/// `y += s x`.
pub(crate) fn axpy(s: f64, x: &[f64], y: &mut [f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += s * x;
    }
}

/// Euclidean norm.
pub(crate) fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// Largest absolute value; NaN if any entry is.
pub(crate) fn largest(a: &[f64]) -> f64 {
    let mut best = 0.0_f64;
    for x in a {
        let x = x.abs();
        if x.is_nan() {
            return f64::NAN;
        }
        best = best.max(x);
    }
    best
}

/// y = A x for a row-major A with `x.len()` columns.
pub(crate) fn multiply(a: &[f64], x: &[f64], y: &mut [f64]) {
    for (row, y) in a.chunks_exact(x.len()).zip(y) {
        *y = dot(row, x);
    }
}
