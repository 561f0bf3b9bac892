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
    panel: Vec<f64>,
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
        self.panel.resize(PANEL * m * n, 0.0);
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
            let pivots = &mut self.pivots[i * q..(i + 1) * q];
            if !eliminate(block, w, q, pivots, &mut self.panel) {
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
                // The diagonal is kept inverted, as in the blocks.
                work[k * w + k] = 1.0 / alpha;
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
            lower(self.block(i), w, q, c);
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
        // Of every pair of eliminated equations the unknowns are (here | x_0 | right), of every interval (inner | left | right).
        let mut y = vec![0.0; w];
        y[n..2 * n].copy_from_slice(x0);
        y[2 * n..3 * n].copy_from_slice(last);
        for i in (1..self.count).rev() {
            match carried {
                Some((_, mids)) => y[..n].copy_from_slice(&mids[(i - 1) * n..i * n]),
                None => y[..n].fill(0.0),
            }
            let merged = &self.merged[(i - 1) * 3 * n * n..i * 3 * n * n];
            upper(merged, 3 * n, n, &mut y[..3 * n]);
            out[i * rows..i * rows + n].copy_from_slice(&y[..n]);
            y.copy_within(..n, 2 * n);
        }
        for i in 0..self.count {
            match carried {
                Some((data, _)) => y[..q].copy_from_slice(&data[i * rows..i * rows + q]),
                None => y[..q].fill(0.0),
            }
            y[q..q + n].copy_from_slice(&out[i * rows..i * rows + n]);
            if i + 1 < self.count {
                y[q + n..].copy_from_slice(&out[(i + 1) * rows..(i + 1) * rows + n]);
            } else {
                y[q + n..].copy_from_slice(last);
            }
            upper(self.block(i), w, q, &mut y);
            out[i * rows + n..(i + 1) * rows].copy_from_slice(&y[..q]);
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
                let l = d[k] * u[k];
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
                let l = here[k] * u[k];
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
    for (v, row) in groups
        .remainder()
        .iter()
        .zip(rows[done * w..].chunks_exact(w))
    {
        axpy(*v, &row[from..from + n], sums);
    }
    for (v, row) in v.iter().zip(rows.chunks_exact_mut(w)) {
        axpy(-beta * v, sums, &mut row[from..from + n]);
    }
}

/// Columns that are eliminated together, so that what lies to their right is read and written once for all of them.
const PANEL: usize = 4;

/// Gaussian elimination of the first q columns of a row-major block of w columns; the diagonal of U is kept inverted.
/// `panel` is room for the columns at work, which are contiguous there.
fn eliminate(
    block: &mut [f64],
    w: usize,
    q: usize,
    pivots: &mut [usize],
    panel: &mut [f64],
) -> bool {
    let rows = block.len() / w;
    let mut first = 0;
    while first < q {
        let end = (first + PANEL).min(q);
        for (c, column) in panel.chunks_exact_mut(rows).take(end - first).enumerate() {
            let from = block[first + c..].iter().step_by(w);
            for (x, y) in column.iter_mut().zip(from).skip(first) {
                *x = *y;
            }
        }
        for k in first..end {
            let (before, now) = panel.split_at_mut((k - first) * rows);
            let (column, after) = now.split_at_mut(rows);
            let mut pivot = k;
            let mut best = column[k].abs();
            for (r, x) in column.iter().enumerate().skip(k + 1) {
                let size = x.abs();
                if size > best {
                    best = size;
                    pivot = r;
                }
            }
            pivots[k] = pivot;
            if !(best > 0.0 && best.is_finite()) {
                return false;
            }
            if pivot != k {
                for other in before
                    .chunks_exact_mut(rows)
                    .chain(after.chunks_exact_mut(rows).take(end - k - 1))
                {
                    other.swap(k, pivot);
                }
                column.swap(k, pivot);
                let (top, bottom) = block.split_at_mut(pivot * w);
                top[k * w..(k + 1) * w].swap_with_slice(&mut bottom[..w]);
            }
            let inverse = 1.0 / column[k];
            column[k] = inverse;
            let multipliers = &mut column[k + 1..];
            for l in multipliers.iter_mut() {
                *l *= inverse;
            }
            for other in after.chunks_exact_mut(rows).take(end - k - 1) {
                let (head, tail) = other.split_at_mut(k + 1);
                axpy(-head[k], multipliers, tail);
            }
        }
        for (c, column) in panel.chunks_exact(rows).take(end - first).enumerate() {
            let to = block[first + c..].iter_mut().step_by(w);
            for (x, y) in to.zip(column).skip(first) {
                *x = *y;
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

/// Four rows times x.
fn products(rows: [&[f64]; 4], x: &[f64]) -> [f64; 4] {
    let n = x.len();
    let rows = rows.map(|row| &row[..n]);
    let mut sums = [[0.0; 2]; 4];
    let whole = n - n % 2;
    for j in (0..whole).step_by(2) {
        for k in 0..4 {
            sums[k][0] += rows[k][j] * x[j];
            sums[k][1] += rows[k][j + 1] * x[j + 1];
        }
    }
    if whole < n {
        for k in 0..4 {
            sums[k][0] += rows[k][whole] * x[whole];
        }
    }
    sums.map(|s| s[0] + s[1])
}

/// L⁻¹ on the rows of an eliminated block, after its row exchanges.
fn lower(block: &[f64], w: usize, q: usize, x: &mut [f64]) {
    let rows = x.len();
    let mut first = 0;
    while first < rows {
        let end = (first + 4).min(rows);
        let known = first.min(q);
        let (done, rest) = x.split_at_mut(first);
        if end - first == 4 {
            let at = |r: usize| &block[(first + r) * w..(first + r) * w + known];
            let sums = products([at(0), at(1), at(2), at(3)], &done[..known]);
            for (x, s) in rest.iter_mut().zip(sums) {
                *x -= s;
            }
        } else {
            for r in first..end {
                rest[r - first] -= dot(&block[r * w..r * w + known], &done[..known]);
            }
        }
        for r in first + 1..end {
            for c in first..r.min(q) {
                rest[r - first] -= block[r * w + c] * rest[c - first];
            }
        }
        first = end;
    }
}

/// y[..q] from the right-hand side there and the known y[q..w], U being the first q rows of a block with inverted diagonal.
fn upper(block: &[f64], w: usize, q: usize, y: &mut [f64]) {
    let mut end = q;
    while end > 0 {
        let first = end.saturating_sub(4);
        let (head, known) = y.split_at_mut(end);
        if end - first == 4 {
            let at = |r: usize| &block[(first + r) * w + end..(first + r + 1) * w];
            let sums = products([at(0), at(1), at(2), at(3)], known);
            for (x, s) in head[first..].iter_mut().zip(sums) {
                *x -= s;
            }
        } else {
            for r in first..end {
                head[r] -= dot(&block[r * w + end..(r + 1) * w], known);
            }
        }
        for r in (first..end).rev() {
            let row = &block[r * w..r * w + end];
            let mut s = head[r];
            for c in r + 1..end {
                s -= row[c] * head[c];
            }
            head[r] = s * row[r];
        }
        end = first;
    }
}
