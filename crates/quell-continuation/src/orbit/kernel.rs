//! Elimination in rows of whole vectors.
//!
//! Everything here is compiled with its caller, for the vectors of the machine at hand. Sums are split alike whatever those
//! are, so the bits are the same on all machines.
#![allow(clippy::inline_always)] // see above

/// Entries that are worked on together.
pub(crate) const WIDTH: usize = 4;

/// So many entries of a row.
pub(crate) type Four = [f64; WIDTH];

/// y -= l u.
#[inline(always)]
fn minus(l: f64, u: &Four, y: &mut Four) {
    for j in 0..WIDTH {
        y[j] -= l * u[j];
    }
}

/// y -= l u on rows.
#[inline(always)]
fn minus_row(l: f64, u: &[Four], y: &mut [Four]) {
    for (y, u) in y.iter_mut().zip(u) {
        minus(l, u, y);
    }
}

/// y -= Σ `l_k` `u_k` on rows, the terms in order.
#[inline(always)]
fn minus_rows(l: Four, u: [&[Four]; WIDTH], y: &mut [Four]) {
    let n = y.len();
    let [a, b, c, d] = u.map(|u| &u[..n]);
    for i in 0..n {
        for j in 0..WIDTH {
            y[i][j] =
                (((y[i][j] - l[0] * a[i][j]) - l[1] * b[i][j]) - l[2] * c[i][j]) - l[3] * d[i][j];
        }
    }
}

/// Rows first … first + 4 of a block, from vector `from` on.
#[inline(always)]
fn four_rows(block: &[Four], s: usize, first: usize, from: usize) -> [&[Four]; WIDTH] {
    std::array::from_fn(|k| &block[(first + k) * s + from..(first + k + 1) * s])
}

/// The largest size of an entry; those that are not-a-number do not count.
#[inline(always)]
fn largest(x: &[f64]) -> f64 {
    let mut best = [0.0_f64; WIDTH];
    let (fours, rest) = x.as_chunks::<WIDTH>();
    for four in fours {
        for j in 0..WIDTH {
            let size = four[j].abs();
            best[j] = if size > best[j] { size } else { best[j] };
        }
    }
    for (best, x) in best.iter_mut().zip(rest) {
        let size = x.abs();
        *best = if size > *best { size } else { *best };
    }
    best.into_iter().fold(0.0, f64::max)
}

/// Gaussian elimination of the first q columns of a block in rows of s vectors; the diagonal of U is kept inverted. Columns of one
/// vector are eliminated together, so that what lies to their right is read and written once for all of them. `panel` is room
/// for them, a vector for each row. False where a pivot is zero or not finite.
#[inline(always)]
pub(crate) fn eliminate(
    block: &mut [Four],
    s: usize,
    q: usize,
    pivots: &mut [usize],
    panel: &mut [Four],
) -> bool {
    let rows = block.len() / s;
    // By columns, so that pivots are sought and multipliers made in vectors as well.
    let (zero, rest) = panel.as_flattened_mut()[..WIDTH * rows].split_at_mut(rows);
    let (one, rest) = rest.split_at_mut(rows);
    let (two, three) = rest.split_at_mut(rows);
    let mut panel: [&mut [f64]; WIDTH] = [zero, one, two, three];
    let mut first = 0;
    while first < q {
        let end = (first + WIDTH).min(q);
        let at = first / WIDTH;
        for (r, row) in block.chunks_exact(s).enumerate().skip(first) {
            for (column, x) in panel.iter_mut().zip(row[at]) {
                column[r] = x;
            }
        }
        for k in first..end {
            let j = k - first;
            let best = largest(&panel[j][k..]);
            if !(best > 0.0 && best.is_finite()) {
                return false;
            }
            let pivot = k + panel[j][k..]
                .iter()
                .position(|x| x.abs() == best)
                .unwrap_or_default();
            pivots[k] = pivot;
            if pivot != k {
                for column in &mut panel {
                    column.swap(k, pivot);
                }
                let (top, bottom) = block.split_at_mut(pivot * s);
                top[k * s..(k + 1) * s].swap_with_slice(&mut bottom[..s]);
            }
            let (done, right) = panel.split_at_mut(j + 1);
            let (head, below) = done[j][k..].split_at_mut(1);
            let inverse = 1.0 / head[0];
            head[0] = inverse;
            for l in below.iter_mut() {
                *l *= inverse;
            }
            for column in right {
                let (head, rest) = column[k..].split_at_mut(1);
                for (x, l) in rest.iter_mut().zip(&*below) {
                    *x -= l * head[0];
                }
            }
        }
        for (r, row) in block.chunks_exact_mut(s).enumerate().skip(first) {
            row[at] = std::array::from_fn(|j| panel[j][r]);
        }
        let next = at + 1;
        for k in first + 1..end {
            let (top, bottom) = block.split_at_mut(k * s);
            for above in first..k {
                let u = &top[above * s + next..(above + 1) * s];
                minus_row(panel[above - first][k], u, &mut bottom[next..s]);
            }
        }
        let (top, bottom) = block.split_at_mut(end * s);
        if end - first == WIDTH {
            let above = four_rows(top, s, first, next);
            for row in bottom.chunks_exact_mut(s) {
                minus_rows(row[at], above, &mut row[next..]);
            }
        } else {
            for row in bottom.chunks_exact_mut(s) {
                let l = row[at];
                for k in first..end {
                    let u = &top[k * s + next..(k + 1) * s];
                    minus_row(l[k - first], u, &mut row[next..]);
                }
            }
        }
        first = end;
    }
    true
}

/// (I - β v vᵀ) from vector `from` on of as many rows of s vectors as v has entries.
#[inline(always)]
pub(crate) fn reflect(v: &[f64], beta: f64, rows: &mut [Four], s: usize, from: usize) {
    for at in from..s {
        let mut sums = [0.0; WIDTH];
        for (v, row) in v.iter().zip(rows.chunks_exact(s)) {
            for j in 0..WIDTH {
                sums[j] += v * row[at][j];
            }
        }
        for (v, row) in v.iter().zip(rows.chunks_exact_mut(s)) {
            minus(beta * v, &sums, &mut row[at]);
        }
    }
}

/// Four rows times x.
#[inline(always)]
fn products(rows: [&[Four]; WIDTH], x: &[Four]) -> Four {
    let n = x.len();
    let rows = rows.map(|row| &row[..n]);
    let mut sums = [[0.0; WIDTH]; WIDTH];
    for i in 0..n {
        for k in 0..WIDTH {
            for j in 0..WIDTH {
                sums[k][j] += rows[k][i][j] * x[i][j];
            }
        }
    }
    sums.map(|s| (s[0] + s[2]) + (s[1] + s[3]))
}

/// L⁻¹ on the rows of an eliminated block, after its row exchanges; `known` is room for a row.
#[inline(always)]
pub(crate) fn lower(block: &[Four], s: usize, q: usize, x: &mut [f64], known: &mut [Four]) {
    let rows = x.len();
    known.fill([0.0; WIDTH]);
    let mut first = 0;
    while first < rows {
        let end = (first + WIDTH).min(rows);
        // Beyond q what is known stays zero.
        let done = first.min(q).div_ceil(WIDTH);
        if end - first == WIDTH {
            let of = std::array::from_fn(|k| &block[(first + k) * s..(first + k) * s + done]);
            let sums = products(of, &known[..done]);
            for (x, s) in x[first..end].iter_mut().zip(sums) {
                *x -= s;
            }
        } else {
            for r in first..end {
                let row = &block[r * s..r * s + done];
                let sums = products([row; WIDTH], &known[..done]);
                x[r] -= sums[0];
            }
        }
        let flat = block.as_flattened();
        for r in first + 1..end {
            for c in first..r.min(q) {
                x[r] -= flat[r * s * WIDTH + c] * x[c];
            }
        }
        for k in first..end.min(q) {
            known[k / WIDTH][k % WIDTH] = x[k];
        }
        first = end;
    }
}

/// y[..q] from the right-hand side there and the known rest of y, U being the first q rows of a block with inverted diagonal.
#[inline(always)]
pub(crate) fn upper(block: &[Four], s: usize, q: usize, y: &mut [Four]) {
    let mut end = q;
    while end > 0 {
        let first = (end - 1) / WIDTH * WIDTH;
        let next = first / WIDTH + 1;
        let own = next - 1;
        let mut head = y[own];
        if end - first == WIDTH {
            let sums = products(four_rows(block, s, first, next), &y[next..]);
            for j in 0..WIDTH {
                head[j] -= sums[j];
            }
        } else {
            for r in first..end {
                let row = &block[r * s + next..(r + 1) * s];
                head[r - first] -= products([row; WIDTH], &y[next..])[0];
            }
        }
        // Entries of this vector from `end` on are known.
        for r in (first..end).rev() {
            let row = &block[r * s + own];
            let mut sum = head[r - first];
            for c in r - first + 1..WIDTH {
                sum -= row[c] * head[c];
            }
            head[r - first] = sum * row[r - first];
        }
        y[own] = head;
        end = first;
    }
}

/// The multipliers l of the first q rows in d[..q], l U = d there, and what remains of d beyond.
#[inline(always)]
pub(crate) fn upper_transposed(block: &[Four], s: usize, q: usize, d: &mut [Four]) {
    let mut first = 0;
    while first < q {
        let end = (first + WIDTH).min(q);
        let own = first / WIDTH;
        let next = own + 1;
        let mut l = d[own];
        for k in first..end {
            let j = k - first;
            let row = &block[k * s + own];
            l[j] *= row[j];
            for c in j + 1..WIDTH {
                l[c] -= l[j] * row[c];
            }
        }
        d[own] = l;
        if end - first == WIDTH {
            minus_rows(l, four_rows(block, s, first, next), &mut d[next..]);
        } else {
            for k in first..end {
                let u = &block[k * s + next..(k + 1) * s];
                minus_row(l[k - first], u, &mut d[next..]);
            }
        }
        first = end;
    }
}
