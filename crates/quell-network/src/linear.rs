//! Small dense linear algebra: the smallest singular vector, and least squares.

/// The right singular vector of the smallest singular value of a matrix given by columns, with that value over the
/// largest one (one-sided Jacobi, Hestenes 1958).
pub(crate) fn smallest_singular(mut columns: Vec<Vec<f64>>) -> (Vec<f64>, f64) {
    let n = columns.len();
    let mut right: Vec<Vec<f64>> = (0..n)
        .map(|i| (0..n).map(|j| if i == j { 1.0 } else { 0.0 }).collect())
        .collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    for _ in 0..60 {
        let mut turned = false;
        for i in 0..n {
            for j in i + 1..n {
                let (alpha, beta, gamma) = (
                    dot(&columns[i], &columns[i]),
                    dot(&columns[j], &columns[j]),
                    dot(&columns[i], &columns[j]),
                );
                if gamma == 0.0 || gamma.abs() <= 1e-17 * (alpha * beta).sqrt() {
                    continue;
                }
                turned |= gamma.abs() > 1e-15 * (alpha * beta).sqrt();
                let zeta = (beta - alpha) / (2.0 * gamma);
                let tangent = 1.0_f64.copysign(zeta) / (zeta.abs() + zeta.hypot(1.0));
                let cosine = 1.0 / tangent.hypot(1.0);
                let sine = cosine * tangent;
                for matrix in [&mut columns, &mut right] {
                    let (head, tail) = matrix.split_at_mut(j);
                    for (x, y) in head[i].iter_mut().zip(tail[0].iter_mut()) {
                        (*x, *y) = (cosine * *x - sine * *y, sine * *x + cosine * *y);
                    }
                }
            }
        }
        if !turned {
            break;
        }
    }
    let sizes: Vec<f64> = columns
        .iter()
        .map(|column| dot(column, column).sqrt())
        .collect();
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    let (place, smallest) = sizes
        .iter()
        .copied()
        .enumerate()
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap_or((0, 0.0));
    let vector = right.into_iter().nth(place).unwrap_or_default();
    (
        vector,
        if largest > 0.0 {
            smallest / largest
        } else {
            0.0
        },
    )
}

/// x of (A + μ diag A) x = b for a symmetric positive definite A given row by row, none if it is not.
#[expect(
    clippy::needless_range_loop,
    reason = "triangular solutions read best by index"
)]
pub(crate) fn damped_solution(
    matrix: &[Vec<f64>],
    damping: f64,
    right: &[f64],
) -> Option<Vec<f64>> {
    let n = right.len();
    let mut lower = vec![vec![0.0; n]; n];
    for i in 0..n {
        for j in 0..=i {
            let mut sum = matrix[i][j];
            if i == j {
                sum += damping * matrix[i][i].max(1e-30);
            }
            for k in 0..j {
                sum -= lower[i][k] * lower[j][k];
            }
            if i == j {
                if sum <= 0.0 || sum.is_nan() {
                    return None;
                }
                lower[i][i] = sum.sqrt();
            } else {
                lower[i][j] = sum / lower[j][j];
            }
        }
    }
    let mut x = right.to_vec();
    for i in 0..n {
        for k in 0..i {
            x[i] -= lower[i][k] * x[k];
        }
        x[i] /= lower[i][i];
    }
    for i in (0..n).rev() {
        for k in i + 1..n {
            x[i] -= lower[k][i] * x[k];
        }
        x[i] /= lower[i][i];
    }
    Some(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn null_vectors_are_found() {
        // Columns a, b, a + 2 b.
        let (a, b) = (vec![1.0, 2.0, 3.0, 4.0], vec![0.5, -1.0, 0.0, 2.0]);
        let c = a.iter().zip(&b).map(|(x, y)| x + 2.0 * y).collect();
        let (vector, value) = smallest_singular(vec![a, b, c]);
        assert!(value < 1e-15);
        assert!((vector[0] / vector[2] + 1.0).abs() < 1e-12);
        assert!((vector[1] / vector[2] + 2.0).abs() < 1e-12);
    }

    #[test]
    fn systems_are_solved() {
        let x = damped_solution(&[vec![4.0, 1.0], vec![1.0, 3.0]], 0.0, &[1.0, 2.0]).unwrap();
        assert!((x[0] - 1.0 / 11.0).abs() < 1e-15 && (x[1] - 7.0 / 11.0).abs() < 1e-15);
        assert!(damped_solution(&[vec![-1.0]], 0.0, &[1.0]).is_none());
    }
}
