//! Quantities as linear maps of the state and of the inputs' derivatives.

use crate::dense::{Dense, Lu, Scalar};

/// A quantity as rows over the state and over the inputs' derivatives.
#[derive(Debug, Clone)]
pub(crate) struct Map<T> {
    pub(crate) state: Dense<T>,
    /// Factor of u, u', u'' …
    pub(crate) input: Vec<Dense<T>>,
}

impl<T: Scalar> Map<T> {
    pub(super) fn of_state(state: Dense<T>) -> Self {
        Self {
            state,
            input: Vec::new(),
        }
    }

    pub(super) fn of_input(rows: usize, states: usize, input: Vec<Dense<T>>) -> Self {
        Self {
            state: Dense::zeros(rows, states),
            input,
        }
    }

    fn rows(&self) -> usize {
        self.state.rows()
    }

    pub(super) fn left(&self, matrix: &Dense<T>) -> Self {
        Self {
            state: matrix.times(&self.state),
            input: self.input.iter().map(|block| matrix.times(block)).collect(),
        }
    }

    pub(super) fn solved(&self, lu: &Lu<T>) -> Self {
        Self {
            state: lu.solve(&self.state),
            input: self.input.iter().map(|block| lu.solve(block)).collect(),
        }
    }

    fn combine(&self, other: &Self, factor: f64) -> Self {
        let longest = self.input.len().max(other.input.len());
        let input = (0..longest)
            .map(|k| match (self.input.get(k), other.input.get(k)) {
                (Some(a), Some(b)) => a.plus(&b.scale(factor)),
                (Some(a), None) => a.clone(),
                (None, Some(b)) => b.scale(factor),
                (None, None) => Dense::zeros(self.rows(), 0),
            })
            .collect();
        Self {
            state: self.state.plus(&other.state.scale(factor)),
            input,
        }
    }

    pub(super) fn plus(&self, other: &Self) -> Self {
        self.combine(other, 1.0)
    }

    pub(super) fn minus(&self, other: &Self) -> Self {
        self.combine(other, -1.0)
    }

    pub(super) fn select(&self, rows: &[usize]) -> Self {
        let pick = |block: &Dense<T>| {
            Dense::from_fn(rows.len(), block.columns(), |i, j| block.get(rows[i], j))
        };
        Self {
            state: pick(&self.state),
            input: self.input.iter().map(pick).collect(),
        }
    }

    pub(super) fn stacked(&self, below: &Self, inputs: usize) -> Self {
        let longest = self.input.len().max(below.input.len());
        let join = |a: Option<&Dense<T>>, b: Option<&Dense<T>>, width: usize| {
            let mut all = Dense::zeros(self.rows() + below.rows(), width);
            if let Some(a) = a {
                all.place(0, 0, a);
            }
            if let Some(b) = b {
                all.place(self.rows(), 0, b);
            }
            all
        };
        Self {
            state: join(Some(&self.state), Some(&below.state), self.state.columns()),
            input: (0..longest)
                .map(|k| join(self.input.get(k), below.input.get(k), inputs))
                .collect(),
        }
    }

    /// Time derivative, given that of the state.
    pub(super) fn derivative(&self, rate: &Self, inputs: usize) -> Self {
        let mut shifted = vec![Dense::zeros(self.rows(), inputs)];
        shifted.extend(self.input.iter().cloned());
        rate.left(&self.state)
            .plus(&Self::of_input(self.rows(), rate.state.columns(), shifted))
    }
}
