//! Elimination of a collocation system: nodes inside each interval, then the mesh points between intervals.
//!
//! Of interval i the equations read W y = r with y = (inner nodes | left end | right end). LU with row pivoting removes the
//! inner nodes and leaves `A_i` `x_i` + `B_i` `x_{i+1}` = `r_i`. Householder reflections of neighbouring intervals then remove
//! `x_1` … `x_{N-1}` in turn (stable without pivoting between blocks: S. J. Wright, SIAM J. Sci. Stat. Comput. 13, 1992) and
//! leave A `x_0` + B `x_N` = r. Columns, rows, null vectors and multipliers all use this one factorisation.
#![allow(clippy::inline_always)] // only what is inlined is compiled for the vectors of the machine

use pulp::{Arch, Simd, WithSimd};

use super::kernel::{Four, WIDTH, eliminate, lower, reflect, upper, upper_transposed};
use crate::dense::{axpy, dot};

#[derive(Clone, Debug, Default)]
pub(crate) struct Condensed {
    pub(crate) n: usize,
    pub(crate) m: usize,
    pub(crate) count: usize,
    /// Per interval mn × (m + 1)n, overwritten by L and U; rows are filled up with zeros to whole vectors.
    pub(crate) blocks: Vec<f64>,
    pivots: Vec<usize>,
    /// Per merge: n reflectors of length 2n.
    reflectors: Vec<f64>,
    betas: Vec<f64>,
    /// Per merge: R | E | F, n × 3n in rows of whole vectors: R `x_i` + E `x_0` + F `x_{i+1}`.
    merged: Vec<f64>,
    /// Last A and B.
    pub(crate) a: Vec<f64>,
    pub(crate) b: Vec<f64>,
    work: Vec<f64>,
    panel: Vec<Four>,
}

impl Condensed {
    /// Prepares room for N intervals of degree m with n states.
    pub(crate) fn resize(&mut self, n: usize, m: usize, count: usize) {
        (self.n, self.m, self.count) = (n, m, count);
        self.blocks.resize(count * self.block_size(), 0.0);
        self.pivots.resize(count * self.inner(), 0);
        self.reflectors.resize(count * 2 * n * n, 0.0);
        self.betas.resize(count * n, 0.0);
        self.merged.resize(count * n * self.merged_stride(), 0.0);
        self.a.resize(n * n, 0.0);
        self.b.resize(n * n, 0.0);
        self.work.resize(2 * n * self.merged_stride(), 0.0);
        self.panel.resize(m * n, [0.0; WIDTH]);
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
    /// From one row of a block to the next.
    pub(crate) fn stride(&self) -> usize {
        self.width().next_multiple_of(WIDTH)
    }
    fn merged_stride(&self) -> usize {
        (3 * self.n).next_multiple_of(WIDTH)
    }
    pub(crate) fn block_size(&self) -> usize {
        self.rows() * self.stride()
    }
    fn merge_of(&self, i: usize) -> &[f64] {
        let size = self.n * self.merged_stride();
        &self.merged[(i - 1) * size..i * size]
    }

    fn block(&self, i: usize) -> &[f64] {
        &self.blocks[i * self.block_size()..(i + 1) * self.block_size()]
    }

    /// `A_i` and `B_i`, row r: (A row, B row).
    pub(crate) fn ends(&self, i: usize, r: usize) -> (&[f64], &[f64]) {
        let (s, q, n) = (self.stride(), self.inner(), self.n);
        let row = &self.block(i)[(q + r) * s + q..(q + r) * s + q + 2 * n];
        row.split_at(n)
    }

    /// Factors the filled blocks. False where an entry is not finite.
    pub(crate) fn factor(&mut self) -> bool {
        Arch::new().dispatch(Factor(self))
    }

    #[inline(always)]
    fn factor_in_vectors(&mut self) -> bool {
        let (q, s, size) = (self.inner(), self.stride() / WIDTH, self.block_size());
        for i in 0..self.count {
            let (block, _) = self.blocks[i * size..(i + 1) * size].as_chunks_mut();
            let pivots = &mut self.pivots[i * q..(i + 1) * q];
            if !eliminate(block, s, q, pivots, &mut self.panel) {
                return false;
            }
        }
        self.merge();
        self.a.iter().chain(&self.b).all(|x| x.is_finite())
    }

    #[inline(always)]
    fn merge(&mut self) {
        let n = self.n;
        let w = self.merged_stride();
        let mut work = std::mem::take(&mut self.work);
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
                row[2 * n..3 * n].copy_from_slice(b);
                row[3 * n..].fill(0.0);
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
                // Columns before k are not read again.
                let (rows, _) = work[k * w..].as_chunks_mut();
                reflect(&v[k..], beta, rows, w / WIDTH, k / WIDTH);
                // The diagonal is kept inverted, as in the blocks.
                work[k * w + k] = 1.0 / alpha;
            }
            self.merged[(i - 1) * n * w..i * n * w].copy_from_slice(&work[..n * w]);
            for r in 0..n {
                let row = &work[(n + r) * w..(n + r + 1) * w];
                self.a[r * n..(r + 1) * n].copy_from_slice(&row[n..2 * n]);
                self.b[r * n..(r + 1) * n].copy_from_slice(&row[2 * n..3 * n]);
            }
        }
        self.work = work;
    }

    /// Carries a right-hand side (N m n, overwritten) to the last equations.
    pub(crate) fn forward(&self, column: &mut [f64], mids: &mut Vec<f64>, out: &mut [f64]) {
        mids.resize(self.count.saturating_sub(1) * self.n, 0.0);
        Arch::new().dispatch(Forward(self, column, mids, out));
    }

    #[inline(always)]
    fn forward_in_vectors(&self, column: &mut [f64], mids: &mut [f64], out: &mut [f64]) {
        let (n, q, rows) = (self.n, self.inner(), self.rows());
        let s = self.stride() / WIDTH;
        let mut t = vec![0.0; 2 * n];
        let mut known = vec![[0.0; WIDTH]; s];
        for i in 0..self.count {
            let c = &mut column[i * rows..(i + 1) * rows];
            for (k, p) in self.pivots[i * q..(i + 1) * q].iter().enumerate() {
                c.swap(k, *p);
            }
            lower(self.block(i).as_chunks().0, s, q, c, &mut known);
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
        Arch::new().dispatch(Backward(self, x0, last, carried, out));
    }

    #[inline(always)]
    fn backward_in_vectors(
        &self,
        x0: &[f64],
        last: &[f64],
        carried: Option<(&[f64], &[f64])>,
        out: &mut [f64],
    ) {
        let (n, q, rows) = (self.n, self.inner(), self.rows());
        let (s, t) = (self.stride() / WIDTH, self.merged_stride() / WIDTH);
        out[..n].copy_from_slice(x0);
        // Of every pair of eliminated equations the unknowns are (here | x_0 | right), of every interval (inner | left | right).
        let mut room = vec![[0.0; WIDTH]; s.max(t)];
        let y = room.as_flattened_mut();
        y[n..2 * n].copy_from_slice(x0);
        y[2 * n..3 * n].copy_from_slice(last);
        for i in (1..self.count).rev() {
            let y = room.as_flattened_mut();
            match carried {
                Some((_, mids)) => y[..n].copy_from_slice(&mids[(i - 1) * n..i * n]),
                None => y[..n].fill(0.0),
            }
            upper(self.merge_of(i).as_chunks().0, t, n, &mut room[..t]);
            let y = room.as_flattened_mut();
            out[i * rows..i * rows + n].copy_from_slice(&y[..n]);
            y.copy_within(..n, 2 * n);
        }
        room.fill([0.0; WIDTH]);
        for i in 0..self.count {
            let y = room.as_flattened_mut();
            match carried {
                Some((data, _)) => y[..q].copy_from_slice(&data[i * rows..i * rows + q]),
                None => y[..q].fill(0.0),
            }
            y[q..q + n].copy_from_slice(&out[i * rows..i * rows + n]);
            if i + 1 < self.count {
                y[q + n..q + 2 * n].copy_from_slice(&out[(i + 1) * rows..(i + 1) * rows + n]);
            } else {
                y[q + n..q + 2 * n].copy_from_slice(last);
            }
            upper(self.block(i).as_chunks().0, s, q, &mut room[..s]);
            out[i * rows + n..(i + 1) * rows].copy_from_slice(&room.as_flattened()[..q]);
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
        inner.resize(self.count * self.inner(), 0.0);
        mids.resize(self.count.saturating_sub(1) * self.n, 0.0);
        Arch::new().dispatch(ReduceRow(self, row, inner, mids, out));
    }

    #[inline(always)]
    fn reduce_row_in_vectors(
        &self,
        row: &[f64],
        inner: &mut [f64],
        mids: &mut [f64],
        out: &mut [f64],
    ) {
        let (n, q, rows) = (self.n, self.inner(), self.rows());
        let (s, t) = (self.stride() / WIDTH, self.merged_stride() / WIDTH);
        let mut points = vec![0.0; (self.count + 1) * n];
        let mut room = vec![[0.0; WIDTH]; s.max(t)];
        for i in 0..self.count {
            let d = room.as_flattened_mut();
            d[..q].copy_from_slice(&row[i * rows + n..(i + 1) * rows]);
            d[q..].fill(0.0);
            upper_transposed(self.block(i).as_chunks().0, s, q, &mut room[..s]);
            let d = room.as_flattened();
            inner[i * q..(i + 1) * q].copy_from_slice(&d[..q]);
            for k in 0..n {
                points[i * n + k] += row[i * rows + k] + d[q + k];
                points[(i + 1) * n + k] += d[q + n + k];
            }
        }
        for i in 1..self.count {
            // (here | x_0 | right)
            let d = room.as_flattened_mut();
            d[..n].copy_from_slice(&points[i * n..(i + 1) * n]);
            d[n..2 * n].copy_from_slice(&points[..n]);
            d[2 * n..3 * n].copy_from_slice(&points[(i + 1) * n..(i + 2) * n]);
            d[3 * n..].fill(0.0);
            upper_transposed(self.merge_of(i).as_chunks().0, t, n, &mut room[..t]);
            let d = room.as_flattened();
            mids[(i - 1) * n..i * n].copy_from_slice(&d[..n]);
            points[..n].copy_from_slice(&d[n..2 * n]);
            points[(i + 1) * n..(i + 2) * n].copy_from_slice(&d[2 * n..3 * n]);
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
        let (n, q, width, rows) = (self.n, self.inner(), self.stride(), self.rows());
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

/// What is compiled for the vectors of the machine, with all it calls.
struct Factor<'a>(&'a mut Condensed);
struct Forward<'a>(&'a Condensed, &'a mut [f64], &'a mut [f64], &'a mut [f64]);
struct Backward<'a>(
    &'a Condensed,
    &'a [f64],
    &'a [f64],
    Option<(&'a [f64], &'a [f64])>,
    &'a mut [f64],
);
struct ReduceRow<'a>(
    &'a Condensed,
    &'a [f64],
    &'a mut [f64],
    &'a mut [f64],
    &'a mut [f64],
);

impl WithSimd for Factor<'_> {
    type Output = bool;
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        self.0.factor_in_vectors()
    }
}

impl WithSimd for Forward<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self(condensed, column, mids, out) = self;
        condensed.forward_in_vectors(column, mids, out);
    }
}

impl WithSimd for Backward<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self(condensed, x0, last, carried, out) = self;
        condensed.backward_in_vectors(x0, last, carried, out);
    }
}

impl WithSimd for ReduceRow<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self(condensed, row, inner, mids, out) = self;
        condensed.reduce_row_in_vectors(row, inner, mids, out);
    }
}
