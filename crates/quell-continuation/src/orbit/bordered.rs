//! The condensed system completed by border columns and rows.

use super::condense::Condensed;
use crate::dense::{Lu, dot};

/// A border row: over the nodes, and over the border unknowns.
#[derive(Clone, Debug, Default)]
pub(crate) struct Row {
    pub(crate) nodes: Vec<f64>,
    pub(crate) ends: Vec<f64>,
}

#[derive(Clone, Debug, Default)]
struct Column {
    data: Vec<f64>,
    mids: Vec<f64>,
    last: Vec<f64>,
}

#[derive(Clone, Debug, Default)]
struct Reduced {
    /// The row as it was, unless the factorisation is another by now.
    of: Vec<f64>,
    inner: Vec<f64>,
    mids: Vec<f64>,
    points: Vec<f64>,
}

/// [collocation, columns; rows] in reduced form.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bordered {
    columns: Vec<Column>,
    rows: Vec<Reduced>,
    lu: Option<Lu<f64>>,
    right: Column,
    x: Vec<f64>,
}

impl Bordered {
    /// Carries the border columns through a new factorisation.
    ///
    /// None stands for a column of zeros.
    pub(crate) fn columns(&mut self, c: &Condensed, raw: &[Option<&[f64]>]) {
        self.columns.resize_with(raw.len(), Column::default);
        for (column, raw) in self.columns.iter_mut().zip(raw) {
            column.data.clear();
            column.last.resize(c.n, 0.0);
            if let Some(raw) = raw {
                column.data.extend_from_slice(raw);
                c.forward(&mut column.data, &mut column.mids, &mut column.last);
            } else {
                column.data.resize(c.count * c.rows(), 0.0);
                column.mids.clear();
                column.mids.resize(c.count.saturating_sub(1) * c.n, 0.0);
                column.last.fill(0.0);
            }
        }
        for row in &mut self.rows {
            row.of.clear();
        }
        self.lu = None;
    }

    /// Eliminates the border rows (as many as columns) and factors what remains. False where it is not finite.
    pub(crate) fn rows(&mut self, c: &Condensed, rows: &[&Row]) -> bool {
        let n = c.n;
        let nb = self.columns.len();
        let size = n + nb;
        let mut matrix = vec![0.0; size * size];
        for r in 0..n {
            for k in 0..n {
                matrix[r * size + k] = c.a[r * n + k] + c.b[r * n + k];
            }
            for (k, column) in self.columns.iter().enumerate() {
                matrix[r * size + n + k] = column.last[r];
            }
        }
        self.rows.resize_with(rows.len(), Reduced::default);
        for (i, (reduced, row)) in self.rows.iter_mut().zip(rows).enumerate() {
            if reduced.of != row.nodes {
                reduced.points.resize(2 * n, 0.0);
                c.reduce_row(
                    &row.nodes,
                    &mut reduced.inner,
                    &mut reduced.mids,
                    &mut reduced.points,
                );
                reduced.of.clone_from(&row.nodes);
            }
            let out = &mut matrix[(n + i) * size..(n + i + 1) * size];
            for k in 0..n {
                out[k] = reduced.points[k] + reduced.points[n + k];
            }
            for (k, column) in self.columns.iter().enumerate() {
                out[n + k] = row.ends[k]
                    - c.eliminated(&reduced.inner, &reduced.mids, &column.data, &column.mids);
            }
        }
        let mut lu = self.lu.take().unwrap_or_default();
        let fine = lu.factor(size, &matrix);
        self.lu = Some(lu);
        fine
    }

    /// Solves in place: equations then border rows become nodes then border unknowns.
    pub(crate) fn solve(&mut self, c: &Condensed, b: &mut [f64]) {
        let n = c.n;
        let nb = self.columns.len();
        let nodes = b.len() - nb;
        let right = &mut self.right;
        right.data.clear();
        right.data.extend_from_slice(&b[..nodes]);
        right.last.resize(n, 0.0);
        c.forward(&mut right.data, &mut right.mids, &mut right.last);
        self.x.resize(n + nb, 0.0);
        self.x[..n].copy_from_slice(&right.last);
        for (i, row) in self.rows.iter().enumerate() {
            self.x[n + i] =
                b[nodes + i] - c.eliminated(&row.inner, &row.mids, &right.data, &right.mids);
        }
        if let Some(lu) = &self.lu {
            lu.solve(&mut self.x);
        }
        for (k, column) in self.columns.iter().enumerate() {
            let p = self.x[n + k];
            crate::dense::axpy(-p, &column.data, &mut right.data);
            crate::dense::axpy(-p, &column.mids, &mut right.mids);
            b[nodes + k] = p;
        }
        let (x0, _) = self.x.split_at(n);
        c.backward(x0, x0, Some((&right.data, &right.mids)), &mut b[..nodes]);
    }

    /// The carried column k: (data, mids, last).
    pub(crate) fn column(&self, k: usize) -> (&[f64], &[f64], &[f64]) {
        let c = &self.columns[k];
        (&c.data, &c.mids, &c.last)
    }
}

/// Row · column.
pub(crate) fn apply(row: &Row, z: &[f64]) -> f64 {
    let nodes = row.nodes.len();
    dot(&row.nodes, &z[..nodes]) + dot(&row.ends, &z[nodes..])
}
