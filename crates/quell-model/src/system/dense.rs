//! Small dense systems of equations.

/// A square matrix factored in place with row pivots.
#[derive(Debug, Clone, Default)]
pub(crate) struct Lu {
    size: usize,
    entries: Vec<f64>,
    rows: Vec<usize>,
}

impl Lu {
    /// An empty matrix of this size.
    pub(crate) fn reset(&mut self, size: usize) {
        self.size = size;
        self.entries.clear();
        self.entries.resize(size * size, 0.0);
    }

    pub(crate) fn set(&mut self, place: usize, value: f64) {
        if let Some(entry) = self.entries.get_mut(place) {
            *entry = value;
        }
    }

    pub(crate) fn get(&self, place: usize) -> f64 {
        self.entries.get(place).copied().unwrap_or(0.0)
    }

    /// Factors; false where the matrix is singular or not finite. Rows are scaled to the same size for the choice of pivots.
    pub(crate) fn factor(&mut self) -> bool {
        let n = self.size;
        self.rows.clear();
        self.rows.extend(0..n);
        let scale: Vec<f64> = self
            .entries
            .chunks(n.max(1))
            .map(|row| row.iter().fold(0.0_f64, |most, x| most.max(x.abs())))
            .collect();
        if scale.iter().any(|s| !s.is_finite() || *s == 0.0) {
            return false;
        }
        for k in 0..n {
            let size = |i: usize| (self.entries[self.rows[i] * n + k] / scale[self.rows[i]]).abs();
            let best = (k..n)
                .max_by(|a, b| size(*a).total_cmp(&size(*b)))
                .unwrap_or(k);
            self.rows.swap(k, best);
            let pivot_row = self.rows[k];
            let pivot = self.entries[pivot_row * n + k];
            // Below this the pivot is the rounding of what it was computed from.
            if (pivot / scale[pivot_row]).abs() < 1e-15 || !pivot.is_finite() {
                return false;
            }
            for i in k + 1..n {
                let row = self.rows[i];
                let factor = self.entries[row * n + k] / pivot;
                self.entries[row * n + k] = factor;
                if factor != 0.0 {
                    for j in k + 1..n {
                        self.entries[row * n + j] -= factor * self.entries[pivot_row * n + j];
                    }
                }
            }
        }
        true
    }

    /// Replaces b by the x of A x = b; the matrix must be factored.
    pub(crate) fn solve(&self, b: &mut [f64]) {
        let n = self.size;
        if b.len() < n || self.rows.len() < n {
            b.fill(f64::NAN);
            return;
        }
        let mut x: Vec<f64> = self.rows.iter().map(|row| b[*row]).collect();
        for i in 0..n {
            let row = self.rows[i];
            for j in 0..i {
                x[i] -= self.entries[row * n + j] * x[j];
            }
        }
        for i in (0..n).rev() {
            let row = self.rows[i];
            for j in i + 1..n {
                x[i] -= self.entries[row * n + j] * x[j];
            }
            x[i] /= self.entries[row * n + i];
        }
        b[..n].copy_from_slice(&x);
    }
}
