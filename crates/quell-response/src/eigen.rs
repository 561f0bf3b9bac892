//! Eigenvalues of dense matrices: balancing by powers of two, then faer.

use faer::Mat;
use num_complex::Complex64;

use crate::dense::{Dense, Scalar};
use crate::error::ResponseError;

/// Similarity D^-1 A D with powers of two that equalise row and column norms (B. N. Parlett and C. Reinsch, 1969).
pub(crate) fn balance<T: Scalar>(matrix: &Dense<T>) -> (Dense<T>, Vec<f64>) {
    let n = matrix.rows();
    let mut balanced = matrix.clone();
    let mut scale = vec![1.0; n];
    // A sweep without change ends it; a few dozen suffice for any double-precision range.
    for _ in 0..60 {
        let mut changed = false;
        for i in 0..n {
            let off =
                |sum: f64, j: usize, value: T| if j == i { sum } else { sum + value.modulus() };
            let column = (0..n).fold(0.0, |sum, j| off(sum, j, balanced.get(j, i)));
            let row = (0..n).fold(0.0, |sum, j| off(sum, j, balanced.get(i, j)));
            if column > 0.0 && row > 0.0 {
                let factor = ((row / column).log2() / 2.0)
                    .round()
                    .clamp(-500.0, 500.0)
                    .exp2();
                if (column * factor + row / factor) < 0.95 * (column + row) {
                    changed = true;
                    scale[i] *= factor;
                    for j in 0..n {
                        let (a, b) = (balanced.get(i, j), balanced.get(j, i));
                        if j != i {
                            balanced.set(i, j, a * (1.0 / factor));
                            balanced.set(j, i, b * factor);
                        }
                    }
                }
            }
        }
        if !changed {
            break;
        }
    }
    (balanced, scale)
}

fn check<T: Scalar>(matrix: &Dense<T>) -> Result<(), ResponseError> {
    if matrix.is_finite() {
        Ok(())
    } else {
        Err(ResponseError::NotFinite {
            what: "the state matrix".into(),
        })
    }
}

/// One thread for every decomposition: tasks run on threads of their own, and no result may depend on how many there are. Said
/// each time, because another dependency turns faer's threads on for the whole process.
fn sequential() {
    faer::set_global_parallelism(faer::Par::Seq);
}

/// A scalar whose matrices faer can decompose.
pub(crate) trait Decompose: Scalar {
    fn eigenvalues(matrix: &Dense<Self>) -> Option<Vec<Complex64>>;
    fn eigen(matrix: &Dense<Self>) -> Option<(Vec<Complex64>, Mat<Complex64>)>;
}

impl Decompose for f64 {
    fn eigenvalues(matrix: &Dense<Self>) -> Option<Vec<Complex64>> {
        sequential();
        Mat::from_fn(matrix.rows(), matrix.columns(), |i, j| matrix.get(i, j))
            .eigenvalues()
            .ok()
    }
    fn eigen(matrix: &Dense<Self>) -> Option<(Vec<Complex64>, Mat<Complex64>)> {
        sequential();
        let eigen = faer::linalg::solvers::Eigen::new_from_real(
            Mat::from_fn(matrix.rows(), matrix.columns(), |i, j| matrix.get(i, j)).as_ref(),
        )
        .ok()?;
        Some((
            eigen.S().column_vector().iter().copied().collect(),
            eigen.U().to_owned(),
        ))
    }
}

impl Decompose for Complex64 {
    fn eigenvalues(matrix: &Dense<Self>) -> Option<Vec<Complex64>> {
        sequential();
        Mat::from_fn(matrix.rows(), matrix.columns(), |i, j| matrix.get(i, j))
            .eigenvalues()
            .ok()
    }
    fn eigen(matrix: &Dense<Self>) -> Option<(Vec<Complex64>, Mat<Complex64>)> {
        sequential();
        let eigen = faer::linalg::solvers::Eigen::new(
            Mat::from_fn(matrix.rows(), matrix.columns(), |i, j| matrix.get(i, j)).as_ref(),
        )
        .ok()?;
        Some((
            eigen.S().column_vector().iter().copied().collect(),
            eigen.U().to_owned(),
        ))
    }
}

/// Eigenvalues alone, after balancing.
pub(crate) fn eigenvalues<T: Decompose>(
    matrix: &Dense<T>,
) -> Result<Vec<Complex64>, ResponseError> {
    check(matrix)?;
    if matrix.rows() == 0 {
        return Ok(Vec::new());
    }
    let (balanced, _) = balance(matrix);
    T::eigenvalues(&balanced)
        .filter(|values| values.iter().all(|value| value.is_finite()))
        .ok_or(ResponseError::Eigenvalues {
            size: matrix.rows(),
        })
}

/// Eigenvalues and right eigenvectors (columns) in the matrix's own coordinates.
pub(crate) fn eigen<T: Decompose>(
    matrix: &Dense<T>,
) -> Result<(Vec<Complex64>, Dense<Complex64>), ResponseError> {
    check(matrix)?;
    let n = matrix.rows();
    if n == 0 {
        return Ok((Vec::new(), Dense::zeros(0, 0)));
    }
    let (balanced, scale) = balance(matrix);
    let (values, vectors) = T::eigen(&balanced).ok_or(ResponseError::Eigenvalues { size: n })?;
    let vectors = Dense::from_fn(n, n, |i, j| vectors[(i, j)] * scale[i]);
    if !vectors.is_finite() || !values.iter().all(|value| value.is_finite()) {
        return Err(ResponseError::Eigenvalues { size: n });
    }
    Ok((values, vectors))
}
