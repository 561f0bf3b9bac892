//! Linear systems of equations whose coefficients are operations of a graph.

use quell_expression::{Graph, Slot};

/// A pivot this much smaller than the largest entry of its row is passed over in a matrix that is not symmetric.
const PIVOT: f64 = 1e-3;

/// A square matrix of operations, factored: the order of pivots is fixed, their values are whatever the inputs give.
///
/// Structural zeros stay out of it. A symmetric matrix with a positive diagonal is factored along its diagonal, which is
/// stable for whatever positive values of elements and does not cancel for the matrices of networks; others take
/// pivots that are large at a sample point.
#[derive(Debug, Clone, Default)]
pub(crate) struct Factor {
    steps: Vec<Step>,
}

#[derive(Debug, Clone)]
struct Step {
    row: usize,
    column: usize,
    /// 1/pivot.
    reciprocal: Slot,
    /// Rows from which the pivot's row is taken, with what factor.
    below: Vec<(usize, Slot)>,
    /// The rest of the pivot's row.
    right: Vec<(usize, Slot)>,
}

impl Factor {
    /// Factors a row-major matrix; else the column for which no pivot is left at the sample point.
    pub(crate) fn new(
        graph: &mut Graph,
        matrix: &[Option<Slot>],
        size: usize,
        sample: &[f64],
    ) -> Result<Self, usize> {
        let mut entries = matrix.to_vec();
        let slots: Vec<Slot> = entries.iter().flatten().copied().collect();
        let mut values = graph.values(&slots, sample).into_iter();
        let mut shadow: Vec<f64> = entries
            .iter()
            .map(|entry| entry.map_or(0.0, |_| values.next().unwrap_or(f64::NAN)))
            .collect();
        let positive = (0..size).all(|i| {
            let diagonal = shadow[i * size + i];
            diagonal > 0.0
                && (0..i).all(|j| {
                    let (a, b) = (shadow[i * size + j], shadow[j * size + i]);
                    (a - b).abs() <= 1e-9 * (a.abs() + b.abs())
                })
        });
        let mut rows: Vec<usize> = (0..size).collect();
        let mut columns: Vec<usize> = (0..size).collect();
        let mut steps = Vec::with_capacity(size);
        while !rows.is_empty() {
            let (row, column) = pick(&entries, &shadow, size, &rows, &columns, positive)
                .ok_or_else(|| columns.first().copied().unwrap_or(0))?;
            rows.retain(|other| *other != row);
            columns.retain(|other| *other != column);
            let Some(pivot) = entries[row * size + column] else {
                return Err(column);
            };
            let one = graph.constant(1.0);
            let reciprocal = graph.divide(one, pivot);
            let right: Vec<(usize, Slot)> = columns
                .iter()
                .filter_map(|other| Some((*other, entries[row * size + other]?)))
                .collect();
            let mut below = Vec::new();
            for other in &rows {
                let Some(entry) = entries[other * size + column] else {
                    continue;
                };
                let factor = graph.multiply(entry, reciprocal);
                let size_of_factor = shadow[other * size + column] / shadow[row * size + column];
                for (place, slot) in &right {
                    let product = graph.multiply(factor, *slot);
                    let target = &mut entries[other * size + place];
                    *target = Some(match *target {
                        Some(known) => graph.subtract(known, product),
                        None => graph.negate(product),
                    });
                    shadow[other * size + place] -= size_of_factor * shadow[row * size + place];
                }
                below.push((*other, factor));
            }
            steps.push(Step {
                row,
                column,
                reciprocal,
                below,
                right,
            });
        }
        Ok(Self { steps })
    }

    /// x of A x = rhs; none where it is zero by structure.
    pub(crate) fn solve(&self, graph: &mut Graph, mut rhs: Vec<Option<Slot>>) -> Vec<Option<Slot>> {
        for step in &self.steps {
            let Some(pivot) = rhs[step.row] else { continue };
            for (row, factor) in &step.below {
                let product = graph.multiply(*factor, pivot);
                rhs[*row] = Some(match rhs[*row] {
                    Some(known) => graph.subtract(known, product),
                    None => graph.negate(product),
                });
            }
        }
        let mut solution = vec![None; rhs.len()];
        for step in self.steps.iter().rev() {
            let mut sum = rhs[step.row];
            for (column, factor) in &step.right {
                if let Some(known) = solution[*column] {
                    let product = graph.multiply(*factor, known);
                    sum = Some(match sum {
                        Some(sum) => graph.subtract(sum, product),
                        None => graph.negate(product),
                    });
                }
            }
            solution[step.column] = sum.map(|sum| graph.multiply(sum, step.reciprocal));
        }
        solution
    }
}

/// The next pivot: of those that are large enough the one that fills in least.
fn pick(
    entries: &[Option<Slot>],
    shadow: &[f64],
    size: usize,
    rows: &[usize],
    columns: &[usize],
    positive: bool,
) -> Option<(usize, usize)> {
    let in_row = |row: usize| {
        columns
            .iter()
            .filter(|column| entries[row * size + **column].is_some())
            .count()
    };
    let in_column = |column: usize| {
        rows.iter()
            .filter(|row| entries[**row * size + column].is_some())
            .count()
    };
    let mut best: Option<((usize, f64), (usize, usize))> = None;
    for &row in rows {
        let largest = columns.iter().fold(0.0_f64, |most, column| {
            most.max(shadow[row * size + column].abs())
        });
        for &column in columns {
            let value = shadow[row * size + column].abs();
            let usable = if positive {
                row == column && value > 0.0
            } else {
                value > 0.0 && value >= PIVOT * largest
            };
            if entries[row * size + column].is_none() || !usable || !value.is_finite() {
                continue;
            }
            let fill = (in_row(row) - 1) * (in_column(column) - 1);
            // Off the diagonal only where it pays.
            let fill = 2 * fill + usize::from(row != column);
            let better = best.is_none_or(|((least, size), _)| {
                fill < least || (fill == least && value > 4.0 * size)
            });
            if better {
                best = Some(((fill, value), (row, column)));
            }
        }
    }
    best.map(|(_, place)| place)
}

/// Σ coefficient · slot, without what is zero; none for an empty sum.
pub(crate) fn combination(graph: &mut Graph, terms: &[(f64, Slot)]) -> Option<Slot> {
    let mut sum: Option<Slot> = None;
    for (coefficient, slot) in terms {
        if *coefficient == 0.0 {
            continue;
        }
        let size = coefficient.abs();
        let term = if size == 1.0 {
            *slot
        } else {
            let size = graph.constant(size);
            graph.multiply(size, *slot)
        };
        sum = Some(match (sum, *coefficient > 0.0) {
            (None, true) => term,
            (None, false) => graph.negate(term),
            (Some(sum), true) => graph.add(sum, term),
            (Some(sum), false) => graph.subtract(sum, term),
        });
    }
    sum
}

/// a + b where either may be absent.
pub(crate) fn plus(graph: &mut Graph, a: Option<Slot>, b: Option<Slot>) -> Option<Slot> {
    match (a, b) {
        (Some(a), Some(b)) => Some(graph.add(a, b)),
        (one, None) | (None, one) => one,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn saddle_points_and_permutations_are_solved() {
        // [2 0 1; 0 3 -1; 1 -1 0] x = [1, 2, 3]; det = -5, by hand x = (2, -1, -3)·…: checked by multiplying back.
        let numbers = [2.0, 0.0, 1.0, 0.0, 3.0, -1.0, 1.0, -1.0, 0.0];
        let mut graph = Graph::default();
        let matrix: Vec<Option<Slot>> = numbers
            .iter()
            .enumerate()
            .map(|(i, value)| (*value != 0.0).then(|| graph.input(i)))
            .collect();
        let factor = Factor::new(&mut graph, &matrix, 3, &numbers).unwrap();
        let rhs: Vec<Option<Slot>> = [1.0, 2.0, 3.0]
            .iter()
            .map(|value| Some(graph.constant(*value)))
            .collect();
        let slots: Vec<Slot> = factor
            .solve(&mut graph, rhs)
            .into_iter()
            .flatten()
            .collect();
        let x = graph.values(&slots, &numbers);
        for row in 0..3 {
            let sum: f64 = (0..3).map(|j| numbers[3 * row + j] * x[j]).sum();
            assert!((sum - (row + 1) as f64).abs() < 1e-14);
        }
    }

    #[test]
    fn a_singular_matrix_is_refused() {
        let mut graph = Graph::default();
        let one = graph.constant(1.0);
        let matrix = [Some(one), Some(one), Some(one), Some(one)];
        assert!(Factor::new(&mut graph, &matrix, 2, &[]).is_err());
    }
}
