//! Elimination of a collocation system: nodes inside each interval, then the mesh points between intervals.
//!
//! Of interval i the equations read W y = r with y = (inner nodes | left end | right end). LU with row pivoting removes the
//! inner nodes and leaves `A_i` `x_i` + `B_i` `x_{i+1}` = `r_i`. Householder reflections of neighbouring intervals then remove
//! `x_1` … `x_{N-1}` in turn (stable without pivoting between blocks: S. J. Wright, SIAM J. Sci. Stat. Comput. 13, 1992) and
//! leave A `x_0` + B `x_N` = r. Columns, rows, null vectors and multipliers all use this one factorisation.

use crate::dense::{axpy, dot};

#[derive(Clone, Debug, Default)]
pub(crate) struct Condensed {
    pub(crate) n: usize,
    pub(crate) m: usize,
    pub(crate) count: usize,
    /// Per interval mn × (m + 1)n, overwritten by L and U.
    pub(crate) blocks: Vec<f64>,
    pivots: Vec<usize>,
    /// Per merge: n reflectors of length 2n.
    reflectors: Vec<f64>,
    betas: Vec<f64>,
    /// Per merge: R | E | F, n × 3n: R `x_i` + E `x_0` + F `x_{i+1}`.
    pub(crate) merged: Vec<f64>,
    /// Last A and B.
    pub(crate) a: Vec<f64>,
    pub(crate) b: Vec<f64>,
    work: Vec<f64>,
    sums: Vec<f64>,
}

impl Condensed {
    /// Prepares room for N intervals of degree m with n states.
    pub(crate) fn resize(&mut self, n: usize, m: usize, count: usize) {
        (self.n, self.m, self.count) = (n, m, count);
        self.blocks.resize(count * self.block_size(), 0.0);
        self.pivots.resize(count * self.inner(), 0);
        self.reflectors.resize(count * 2 * n * n, 0.0);
        self.betas.resize(count * n, 0.0);
        self.merged.resize(count * 3 * n * n, 0.0);
        self.a.resize(n * n, 0.0);
        self.b.resize(n * n, 0.0);
        self.work.resize(2 * n * 3 * n, 0.0);
        self.sums.resize(3 * n, 0.0);
    }

    pub(crate) fn inner(&self) -> usize {
        (self.m - 1) * self.n
    }
    pub(crate) fn rows(&self) -> usize {
        self.m * self.n
    }
    pub(crate) fn width(&self) -> usize {
        (self.m + 1) * self.n
    }
    pub(crate) fn block_size(&self) -> usize {
        self.rows() * self.width()
    }

    fn block(&self, i: usize) -> &[f64] {
        &self.blocks[i * self.block_size()..(i + 1) * self.block_size()]
    }

    /// `A_i` and `B_i`, row r: (A row, B row).
    pub(crate) fn ends(&self, i: usize, r: usize) -> (&[f64], &[f64]) {
        let (w, q, n) = (self.width(), self.inner(), self.n);
        let row = &self.block(i)[(q + r) * w + q..(q + r + 1) * w];
        row.split_at(n)
    }

    /// Factors the filled blocks. False where an entry is not finite.
    pub(crate) fn factor(&mut self) -> bool {
        let (q, w, size) = (self.inner(), self.width(), self.block_size());
        for i in 0..self.count {
            let block = &mut self.blocks[i * size..(i + 1) * size];
            if !eliminate(block, w, q, &mut self.pivots[i * q..(i + 1) * q]) {
                return false;
            }
        }
        self.merge();
        self.a.iter().chain(&self.b).all(|x| x.is_finite())
    }

    fn merge(&mut self) {
        let n = self.n;
        let w = 3 * n;
        let mut work = std::mem::take(&mut self.work);
        let mut sums = std::mem::take(&mut self.sums);
        let (mut first, mut last) = (std::mem::take(&mut self.a), std::mem::take(&mut self.b));
        for r in 0..n {
            let (a, b) = self.ends(0, r);
            first[r * n..(r + 1) * n].copy_from_slice(a);
            last[r * n..(r + 1) * n].copy_from_slice(b);
        }
        (self.a, self.b) = (first, last);
        for i in 1..self.count {
            // Rows [B | A | 0] of what is carried and [A_i | 0 | B_i] of the next interval.
            for r in 0..n {
                let row = &mut work[r * w..(r + 1) * w];
                row[..n].copy_from_slice(&self.b[r * n..(r + 1) * n]);
                row[n..2 * n].copy_from_slice(&self.a[r * n..(r + 1) * n]);
                row[2 * n..].fill(0.0);
            }
            for r in 0..n {
                let (a, b) = self.ends(i, r);
                let row = &mut work[(n + r) * w..(n + r + 1) * w];
                row[..n].copy_from_slice(a);
                row[n..2 * n].fill(0.0);
                row[2 * n..].copy_from_slice(b);
            }
            let reflectors = &mut self.reflectors[(i - 1) * 2 * n * n..i * 2 * n * n];
            let betas = &mut self.betas[(i - 1) * n..i * n];
            for k in 0..n {
                let v = &mut reflectors[k * 2 * n..(k + 1) * 2 * n];
                v.fill(0.0);
                let mut square = 0.0;
                for r in k..2 * n {
                    v[r] = work[r * w + k];
                    square += v[r] * v[r];
                }
                let length = square.sqrt();
                let alpha = if v[k] > 0.0 { -length } else { length };
                let head = v[k] - alpha;
                // |v|² = 2 length (length + |v_k|)
                let norm = 2.0 * length * (length + v[k].abs());
                v[k] = head;
                let beta = if norm > 0.0 { 2.0 / norm } else { 0.0 };
                betas[k] = beta;
                let sums = &mut sums[..w - k - 1];
                sums.fill(0.0);
                reflect(&v[k..], beta, &mut work[k * w..], w, k + 1, sums);
                work[k * w + k] = alpha;
            }
            self.merged[(i - 1) * n * w..i * n * w].copy_from_slice(&work[..n * w]);
            for r in 0..n {
                let row = &work[(n + r) * w..(n + r + 1) * w];
                self.a[r * n..(r + 1) * n].copy_from_slice(&row[n..2 * n]);
                self.b[r * n..(r + 1) * n].copy_from_slice(&row[2 * n..]);
            }
        }
        (self.work, self.sums) = (work, sums);
    }

    /// Carries a right-hand side (N m n, overwritten) to the last equations.
    pub(crate) fn forward(&self, column: &mut [f64], mids: &mut Vec<f64>, out: &mut [f64]) {
        let (n, q, w, rows) = (self.n, self.inner(), self.width(), self.rows());
        mids.resize(self.count.saturating_sub(1) * n, 0.0);
        let mut t = vec![0.0; 2 * n];
        for i in 0..self.count {
            let c = &mut column[i * rows..(i + 1) * rows];
            for (k, p) in self.pivots[i * q..(i + 1) * q].iter().enumerate() {
                c.swap(k, *p);
            }
            let block = self.block(i);
            for r in 1..rows {
                let (done, rest) = c.split_at_mut(r);
                let l = r.min(q);
                rest[0] -= dot(&block[r * w..r * w + l], &done[..l]);
            }
            if i == 0 {
                out.copy_from_slice(&c[q..]);
                continue;
            }
            t[..n].copy_from_slice(out);
            t[n..].copy_from_slice(&c[q..]);
            for k in 0..n {
                let v = &self.reflectors[((i - 1) * n + k) * 2 * n..((i - 1) * n + k + 1) * 2 * n];
                let s = self.betas[(i - 1) * n + k] * dot(&v[k..], &t[k..]);
                axpy(-s, &v[k..], &mut t[k..]);
            }
            mids[(i - 1) * n..i * n].copy_from_slice(&t[..n]);
            out.copy_from_slice(&t[n..]);
        }
    }

    /// All nodes (N m n, then `x_N` in `last`) from `x_0` and `x_N` and a carried right-hand side; without one, the homogeneous
    /// solution.
    pub(crate) fn backward(
        &self,
        x0: &[f64],
        last: &[f64],
        carried: Option<(&[f64], &[f64])>,
        out: &mut [f64],
    ) {
        let (n, q, w, rows) = (self.n, self.inner(), self.width(), self.rows());
        out[..n].copy_from_slice(x0);
        let mut right = last.to_vec();
        let mut t = vec![0.0; n];
        for i in (1..self.count).rev() {
            let merged = &self.merged[(i - 1) * 3 * n * n..i * 3 * n * n];
            for r in (0..n).rev() {
                let row = &merged[r * 3 * n..(r + 1) * 3 * n];
                let mut s = carried.map_or(0.0, |c| c.1[(i - 1) * n + r]);
                s -= dot(&row[n..2 * n], x0) + dot(&row[2 * n..], &right);
                s -= dot(&row[r + 1..n], &t[r + 1..n]);
                t[r] = s / row[r];
            }
            out[i * rows..i * rows + n].copy_from_slice(&t);
            right.copy_from_slice(&t);
        }
        let mut ends = vec![0.0; 2 * n];
        for i in 0..self.count {
            ends[..n].copy_from_slice(&out[i * rows..i * rows + n]);
            if i + 1 < self.count {
                ends[n..].copy_from_slice(&out[(i + 1) * rows..(i + 1) * rows + n]);
            } else {
                ends[n..].copy_from_slice(last);
            }
            let block = self.block(i);
            let inner = &mut out[i * rows + n..(i + 1) * rows];
            for r in (0..q).rev() {
                let row = &block[r * w..(r + 1) * w];
                let mut s = carried.map_or(0.0, |c| c.0[i * rows + r]);
                s -= dot(&row[q..], &ends);
                s -= dot(&row[r + 1..q], &inner[r + 1..q]);
                inner[r] = s / row[r];
            }
        }
    }

    /// Eliminates a row over all nodes (N m n); `inner` and `mids` keep the multipliers, `out` is what remains on `x_0`, `x_N`.
    pub(crate) fn reduce_row(
        &self,
        row: &[f64],
        inner: &mut Vec<f64>,
        mids: &mut Vec<f64>,
        out: &mut [f64],
    ) {
        let (n, q, w, rows) = (self.n, self.inner(), self.width(), self.rows());
        inner.resize(self.count * q, 0.0);
        mids.resize(self.count.saturating_sub(1) * n, 0.0);
        let mut points = vec![0.0; (self.count + 1) * n];
        let mut d = vec![0.0; w];
        for i in 0..self.count {
            d[..q].copy_from_slice(&row[i * rows + n..(i + 1) * rows]);
            d[q..].fill(0.0);
            let block = self.block(i);
            for k in 0..q {
                let u = &block[k * w..(k + 1) * w];
                let l = d[k] / u[k];
                inner[i * q + k] = l;
                axpy(-l, &u[k + 1..], &mut d[k + 1..]);
            }
            for k in 0..n {
                points[i * n + k] += row[i * rows + k] + d[q + k];
                points[(i + 1) * n + k] += d[q + n + k];
            }
        }
        for i in 1..self.count {
            let merged = &self.merged[(i - 1) * 3 * n * n..i * 3 * n * n];
            let (left, right) = points.split_at_mut((i + 1) * n);
            let (head, here) = left.split_at_mut(i * n);
            for k in 0..n {
                let u = &merged[k * 3 * n..(k + 1) * 3 * n];
                let l = here[k] / u[k];
                mids[(i - 1) * n + k] = l;
                axpy(-l, &u[k + 1..n], &mut here[k + 1..]);
                axpy(-l, &u[n..2 * n], &mut head[..n]);
                axpy(-l, &u[2 * n..], &mut right[..n]);
            }
        }
        out[..n].copy_from_slice(&points[..n]);
        out[n..].copy_from_slice(&points[self.count * n..]);
        if self.count == 0 {
            out.fill(0.0);
        }
    }

    /// What the eliminated part of a row takes of a carried column.
    pub(crate) fn eliminated(
        &self,
        inner: &[f64],
        mids: &[f64],
        column: &[f64],
        column_mids: &[f64],
    ) -> f64 {
        let (q, rows) = (self.inner(), self.rows());
        let mut sum = dot(mids, column_mids);
        for i in 0..self.count {
            sum += dot(&inner[i * q..(i + 1) * q], &column[i * rows..i * rows + q]);
        }
        sum
    }

    /// The left vector over all equations (N m n) whose part on the last ones is w; `row` gives the weight and multipliers of
    /// a border row.
    pub(crate) fn left(&self, w: &[f64], row: Option<(f64, &[f64], &[f64])>, out: &mut [f64]) {
        let (n, q, width, rows) = (self.n, self.inner(), self.width(), self.rows());
        let mut carry = w.to_vec();
        let mut t = vec![0.0; 2 * n];
        for i in (0..self.count).rev() {
            if i > 0 {
                for k in 0..n {
                    t[k] = row.map_or(0.0, |(s, _, mids)| -s * mids[(i - 1) * n + k]);
                    t[n + k] = carry[k];
                }
                for k in (0..n).rev() {
                    let v =
                        &self.reflectors[((i - 1) * n + k) * 2 * n..((i - 1) * n + k + 1) * 2 * n];
                    let s = self.betas[(i - 1) * n + k] * dot(&v[k..], &t[k..]);
                    axpy(-s, &v[k..], &mut t[k..]);
                }
                carry.copy_from_slice(&t[..n]);
            } else {
                t[n..].copy_from_slice(&carry);
            }
            let y = &mut out[i * rows..(i + 1) * rows];
            for k in 0..q {
                y[k] = row.map_or(0.0, |(s, inner, _)| -s * inner[i * q + k]);
            }
            y[q..].copy_from_slice(&t[n..]);
            let block = self.block(i);
            for r in (1..rows).rev() {
                let l = r.min(q);
                let (head, tail) = y.split_at_mut(r);
                axpy(-tail[0], &block[r * width..r * width + l], &mut head[..l]);
            }
            for (k, p) in self.pivots[i * q..(i + 1) * q].iter().enumerate().rev() {
                y.swap(k, *p);
            }
        }
    }
}

/// (I - β v vᵀ) on the columns from `from` of as many rows of `w` columns as v has entries; `sums` begins at zero.
fn reflect(v: &[f64], beta: f64, rows: &mut [f64], w: usize, from: usize, sums: &mut [f64]) {
    let n = sums.len();
    let mut groups = v.chunks_exact(4);
    let mut blocks = rows.chunks_exact(4 * w);
    for (v, block) in groups.by_ref().zip(blocks.by_ref()) {
        let at = |k: usize| &block[k * w + from..k * w + from + n];
        let (a, b, c, d) = (at(0), at(1), at(2), at(3));
        for j in 0..n {
            sums[j] += ((v[0] * a[j] + v[1] * b[j]) + v[2] * c[j]) + v[3] * d[j];
        }
    }
    let done = v.len() - groups.remainder().len();
    for (v, row) in groups.remainder().iter().zip(rows[done * w..].chunks_exact(w)) {
        axpy(*v, &row[from..from + n], sums);
    }
    for (v, row) in v.iter().zip(rows.chunks_exact_mut(w)) {
        axpy(-beta * v, sums, &mut row[from..from + n]);
    }
}

/// Columns that are eliminated together, so that what lies to their right is read and written once for all of them.
const PANEL: usize = 4;

/// Gaussian elimination of the first q columns of a row-major block of w columns.
fn eliminate(block: &mut [f64], w: usize, q: usize, pivots: &mut [usize]) -> bool {
    let rows = block.len() / w;
    let mut first = 0;
    while first < q {
        let end = (first + PANEL).min(q);
        for k in first..end {
            let mut pivot = k;
            let mut best = block[k * w + k].abs();
            for r in k + 1..rows {
                let size = block[r * w + k].abs();
                if size > best {
                    best = size;
                    pivot = r;
                }
            }
            pivots[k] = pivot;
            if !(best > 0.0 && best.is_finite()) {
                return false;
            }
            let (top, bottom) = block.split_at_mut((k + 1) * w);
            let here = &mut top[k * w..];
            if pivot != k {
                here.swap_with_slice(&mut bottom[(pivot - k - 1) * w..(pivot - k) * w]);
            }
            let inverse = 1.0 / here[k];
            let tail = &here[k + 1..end];
            for row in bottom.chunks_exact_mut(w) {
                let l = row[k] * inverse;
                row[k] = l;
                for (x, y) in row[k + 1..end].iter_mut().zip(tail) {
                    *x -= l * y;
                }
            }
        }
        for k in first + 1..end {
            let (top, bottom) = block.split_at_mut(k * w);
            let (multipliers, tail) = bottom[..w].split_at_mut(end);
            for (l, above) in multipliers[first..k].iter().zip(first..k) {
                axpy(-l, &top[above * w + end..(above + 1) * w], tail);
            }
        }
        let (top, bottom) = block.split_at_mut(end * w);
        if end - first == PANEL {
            let above: [&[f64]; PANEL] =
                std::array::from_fn(|k| &top[(first + k) * w + end..(first + k + 1) * w]);
            for row in bottom.chunks_exact_mut(w) {
                let (multipliers, tail) = row.split_at_mut(end);
                let l: [f64; PANEL] = std::array::from_fn(|k| multipliers[first + k]);
                subtract(l, above, tail);
            }
        } else {
            for row in bottom.chunks_exact_mut(w) {
                let (multipliers, tail) = row.split_at_mut(end);
                for k in first..end {
                    axpy(-multipliers[k], &top[k * w + end..(k + 1) * w], tail);
                }
            }
        }
        first = end;
    }
    true
}

/// y -= Σ `l_k` `x_k`, the terms in order.
fn subtract(l: [f64; PANEL], x: [&[f64]; PANEL], y: &mut [f64]) {
    let n = y.len();
    let [a, b, c, d] = x.map(|x| &x[..n]);
    for j in 0..n {
        y[j] = (((y[j] - l[0] * a[j]) - l[1] * b[j]) - l[2] * c[j]) - l[3] * d[j];
    }
}
