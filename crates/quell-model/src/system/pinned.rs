//! Singular systems of equations: unknowns that they leave open stay where they are.

/// A sum counts as zero where its terms are this much larger.
const CANCELLED: f64 = 1e-13;

/// Solves A x = b (row-major) by elimination with complete pivoting; unknowns that A does not determine are zero in x, and
/// equations that contradict others are left as they are.
///
/// An unknown whose own equation is empty (the integral of an input that rests, a free displacement) is the last to be
/// determined by the others: it is where the run begins.
pub(crate) fn solve(entries: &[f64], b: &[f64]) -> Vec<f64> {
    let n = b.len();
    let mut work: Vec<Vec<f64>> = entries
        .chunks(n.max(1))
        .zip(b)
        .map(|(row, b)| row.iter().copied().chain([*b]).collect())
        .collect();
    let empty: Vec<bool> = work
        .iter()
        .map(|row| row.iter().take(n).all(|entry| *entry == 0.0))
        .collect();
    let mut size: Vec<Vec<f64>> = work
        .iter()
        .map(|row| row.iter().map(|entry| entry.abs()).collect())
        .collect();
    let scale: Vec<f64> = size
        .iter()
        .map(|row| row.iter().take(n).copied().fold(0.0, f64::max))
        .collect();
    let mut pivots: Vec<(usize, usize)> = Vec::new();
    for _ in 0..n {
        let mut best = (0.0, 0, 0);
        for last in [false, true] {
            for (i, row) in work.iter().enumerate() {
                for (j, entry) in row.iter().enumerate().take(n) {
                    let taken = pivots.iter().any(|(row, column)| *row == i || *column == j);
                    let relative = entry.abs() / scale[i];
                    if !taken && empty[j] == last && relative > best.0 {
                        best = (relative, i, j);
                    }
                }
            }
            if best.0 > 0.0 {
                break;
            }
        }
        let (found, pivot, column) = best;
        if found == 0.0 {
            break;
        }
        pivots.push((pivot, column));
        let (head, head_size) = (work[pivot].clone(), size[pivot].clone());
        for (i, (row, sizes)) in work.iter_mut().zip(&mut size).enumerate() {
            let factor = row[column] / head[column];
            if factor == 0.0 || pivots.iter().any(|(done, _)| *done == i) {
                continue;
            }
            let above = head.iter().zip(&head_size);
            for (j, ((entry, terms), (other, others))) in
                row.iter_mut().zip(sizes).zip(above).enumerate()
            {
                *terms += factor.abs() * others;
                *entry -= factor * other;
                if j == column || entry.abs() <= CANCELLED * *terms {
                    *entry = 0.0;
                }
            }
        }
    }
    let mut x = vec![0.0; n];
    for (row, column) in pivots.iter().rev() {
        let known: f64 = (0..n).map(|j| work[*row][j] * x[j]).sum();
        x[*column] = (work[*row][n] - known) / work[*row][*column];
    }
    x
}

#[cfg(test)]
mod tests {
    use super::solve;

    /// Two masses on one spring and the ground's motion r, whose own equation is empty: r stays, the masses follow.
    #[test]
    fn what_is_open_stays() {
        let a = [-2.0, 2.0, 0.0, 2.0, -5.0, 3.0, 0.0, 0.0, 0.0];
        // Pulled by 1 and 2: the spring to the ground carries 3.
        let x = solve(&a, &[-1.0, -2.0, 0.0]);
        assert!((x[1] - 1.0).abs() < 1e-14 && (x[0] - 1.5).abs() < 1e-14);
        assert_eq!(x[2], 0.0);
        // Free masses: one of them stays, the distance is what the spring needs.
        let x = solve(&[-2.0, 2.0, 2.0, -2.0], &[-1.0, 1.0]);
        assert!((x[0] - x[1] - 0.5).abs() < 1e-15);
        assert!(x[0] == 0.0 || x[1] == 0.0);
    }
}
