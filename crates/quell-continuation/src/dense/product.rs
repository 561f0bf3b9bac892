//! Eigenvalues of a product of matrices without forming it: the periodic QR algorithm.
//!
//! Bojanczyk, Golub and Van Dooren 1992, in complex arithmetic with single shifts. A product of transfer matrices keeps
//! only the multipliers within 1e-16 of the largest; the periodic Schur form keeps all of them to relative accuracy.

use num_complex::Complex64;

type C = Complex64;

/// A rotation [c s; -s̄ c] with real c that maps (f, g) to (r, 0).
#[derive(Clone, Copy)]
struct Rotation {
    c: f64,
    s: C,
}

impl Rotation {
    fn of(f: C, g: C) -> Self {
        let size = f.norm().max(g.norm());
        if g.norm() == 0.0 || size == 0.0 {
            return Self {
                c: 1.0,
                s: C::default(),
            };
        }
        if f.norm() == 0.0 {
            return Self {
                c: 0.0,
                s: g.conj() / g.norm(),
            };
        }
        let (f, g) = (f / size, g / size);
        let r = (f.norm_sqr() + g.norm_sqr()).sqrt();
        let phase = f / f.norm();
        Self {
            c: f.norm() / r,
            s: phase * g.conj() / r,
        }
    }

    /// Rows i and i + 1 of `a`.
    fn rows(self, n: usize, a: &mut [C], i: usize) {
        for j in 0..n {
            let (x, y) = (a[i * n + j], a[(i + 1) * n + j]);
            a[i * n + j] = x * self.c + self.s * y;
            a[(i + 1) * n + j] = y * self.c - self.s.conj() * x;
        }
    }

    /// Columns i and i + 1 of `a` times the conjugate transpose of the rotation.
    fn columns(self, n: usize, a: &mut [C], i: usize) {
        for row in a.chunks_exact_mut(n) {
            let (x, y) = (row[i], row[i + 1]);
            row[i] = x * self.c + self.s.conj() * y;
            row[i + 1] = y * self.c - self.s * x;
        }
    }
}

/// The product `A_K` … `A_1`; `factors[0]` is `A_1` and becomes Hessenberg, the others upper triangular.
struct Product {
    n: usize,
    factors: Vec<Vec<C>>,
}

impl Product {
    /// Rotates rows i, i+1 of `A_1` and carries the rotation round the cycle back to its columns.
    fn push(&mut self, i: usize, rotation: Rotation) {
        let n = self.n;
        let mut g = rotation;
        g.rows(n, &mut self.factors[0], i);
        for a in &mut self.factors[1..] {
            g.columns(n, a, i);
            g = Rotation::of(a[i * n + i], a[(i + 1) * n + i]);
            g.rows(n, a, i);
            a[(i + 1) * n + i] = C::default();
        }
        g.columns(n, &mut self.factors[0], i);
    }

    /// Rotates rows i, i+1 of `A_K` and carries the rotation down to the rows of `A_1`, then its columns.
    fn pull(&mut self, i: usize, rotation: Rotation) {
        let n = self.n;
        let mut g = rotation;
        for a in self.factors[1..].iter_mut().rev() {
            g.rows(n, a, i);
            // A rotation Z of columns with (a_{i+1,i}, a_{i+1,i+1}) Z = (0, r).
            let (f, h) = (a[(i + 1) * n + i + 1], a[(i + 1) * n + i]);
            let z = Rotation::of(f.conj(), h.conj());
            // Rows (i, i+1) reversed: build the equivalent rotation in the usual order.
            g = Rotation {
                c: z.c,
                s: -z.s.conj(),
            };
            g.columns(n, a, i);
            a[(i + 1) * n + i] = C::default();
        }
        g.rows(n, &mut self.factors[0], i);
        rotation.columns(n, &mut self.factors[0], i);
    }

    fn triangularise(&mut self) {
        let n = self.n;
        for k in 1..self.factors.len() {
            for j in 0..n {
                for i in (j + 1..n).rev() {
                    let a = &mut self.factors[k];
                    let g = Rotation::of(a[(i - 1) * n + j], a[i * n + j]);
                    g.rows(n, a, i - 1);
                    a[i * n + j] = C::default();
                    let next = if k + 1 < self.factors.len() { k + 1 } else { 0 };
                    g.columns(n, &mut self.factors[next], i - 1);
                }
            }
        }
        for j in 0..n.saturating_sub(2) {
            for i in (j + 2..n).rev() {
                let a = &self.factors[0];
                let g = Rotation::of(a[(i - 1) * n + j], a[i * n + j]);
                self.push(i - 1, g);
                self.factors[0][i * n + j] = C::default();
            }
        }
    }

    /// The trailing (or leading) 2 × 2 block of the product at rows i, i+1.
    fn block(&self, i: usize) -> [C; 4] {
        let n = self.n;
        let a = &self.factors[0];
        let mut b = [
            a[i * n + i],
            a[i * n + i + 1],
            a[(i + 1) * n + i],
            a[(i + 1) * n + i + 1],
        ];
        for t in &self.factors[1..] {
            let (p, q, r) = (t[i * n + i], t[i * n + i + 1], t[(i + 1) * n + i + 1]);
            b = [p * b[0] + q * b[2], p * b[1] + q * b[3], r * b[2], r * b[3]];
        }
        b
    }

    fn value(&self, i: usize) -> C {
        self.factors
            .iter()
            .fold(C::new(1.0, 0.0), |v, a| v * a[i * self.n + i])
    }
}

/// Eigenvalues of `A_K` … `A_1` for real row-major n × n matrices given in the order of application.
///
/// None where an entry is not finite or the iteration fails.
pub(crate) fn product_eigenvalues(n: usize, factors: &[Vec<f64>]) -> Option<Vec<C>> {
    if factors.iter().flatten().any(|x| !x.is_finite()) {
        return None;
    }
    if n == 0 {
        return Some(Vec::new());
    }
    if factors.len() == 1 {
        return super::eigenvalues(n, &factors[0]);
    }
    let mut p = Product {
        n,
        factors: factors
            .iter()
            .map(|a| a.iter().map(|x| C::new(*x, 0.0)).collect())
            .collect(),
    };
    p.triangularise();
    let mut high = n;
    let mut iterations = 0;
    let mut out = vec![C::default(); n];
    while high > 0 {
        let last = high - 1;
        let mut low = last;
        while low > 0 {
            let a = &p.factors[0];
            let s = a[(low - 1) * n + low - 1].norm() + a[low * n + low].norm();
            if a[low * n + low - 1].norm() <= f64::EPSILON * s {
                p.factors[0][low * n + low - 1] = C::default();
                break;
            }
            low -= 1;
        }
        if low == last {
            out[last] = p.value(last);
            high -= 1;
            iterations = 0;
            continue;
        }
        iterations += 1;
        if iterations > 90 {
            return None;
        }
        let b = p.block(last - 1);
        let mut shift = wilkinson(b);
        if iterations % 11 == 0 {
            shift *= C::new(0.7, 0.9);
        }
        let lead = p.block(low);
        let g = Rotation::of(lead[0] - shift, lead[2]);
        p.pull(low, g);
        for i in low + 1..last {
            let a = &p.factors[0];
            let g = Rotation::of(a[i * n + i - 1], a[(i + 1) * n + i - 1]);
            p.push(i, g);
            p.factors[0][(i + 1) * n + i - 1] = C::default();
        }
    }
    Some(conjugate_pairs(out))
}

/// The eigenvalue of [b0 b1; b2 b3] nearest b3.
fn wilkinson(b: [C; 4]) -> C {
    let size = b.iter().map(|x| x.norm()).fold(0.0, f64::max);
    if size == 0.0 {
        return C::default();
    }
    let b = b.map(|x| x / size);
    let half = (b[0] - b[3]) * 0.5;
    let root = (half * half + b[1] * b[2]).sqrt();
    let w = if (half + root).norm() > (half - root).norm() {
        half + root
    } else {
        half - root
    };
    // The eigenvalues are b3 + w and b3 - b1 b2 / w; the second is the nearer.
    if w.norm() == 0.0 {
        b[3] * size
    } else {
        (b[3] - b[1] * b[2] / w) * size
    }
}

/// Restores the symmetry of a real product: eigenvalues real or in exact conjugate pairs.
fn conjugate_pairs(mut values: Vec<C>) -> Vec<C> {
    let mut out = Vec::with_capacity(values.len());
    values.sort_by(|a, b| (b.im.abs() / b.norm()).total_cmp(&(a.im.abs() / a.norm())));
    while !values.is_empty() {
        let v = values.remove(0);
        if v.im.abs() <= 1e-9 * v.norm() {
            out.push(C::new(v.re, 0.0));
            continue;
        }
        let mate = (0..values.len()).min_by(|i, j| {
            (values[*i] - v.conj())
                .norm()
                .total_cmp(&(values[*j] - v.conj()).norm())
        });
        match mate {
            Some(i) if (values[i] - v.conj()).norm() < 1e-2 * v.norm() => {
                let w = values.remove(i);
                let mean = (v + w.conj()) * 0.5;
                let up = C::new(mean.re, mean.im.abs());
                out.push(up);
                out.push(up.conj());
            }
            _ => out.push(C::new(v.re, 0.0)),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn graded_product_keeps_small_eigenvalues() {
        // S_{k+1} D_k S_k^{-1} around a cycle: the eigenvalues are those of the product of the D_k.
        let n = 5;
        let count = 7;
        let mut seed = 3_u64;
        let mut next = || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let basis: Vec<Vec<f64>> = (0..count)
            .map(|_| {
                (0..n * n)
                    .map(|k| next() + if k / n == k % n { 2.0 } else { 0.0 })
                    .collect()
            })
            .collect();
        let angle = 0.3_f64;
        let (c, s) = (angle.cos() * 1.01, angle.sin() * 1.01);
        let mut factors = Vec::new();
        for k in 0..count {
            let mut d = vec![0.0; n * n];
            (d[0], d[1], d[n], d[n + 1]) = (c, -s, s, c);
            d[2 * n + 2] = 0.03;
            d[3 * n + 3] = if k == 0 { -0.5 } else { 0.5 };
            d[4 * n + 4] = 0.001;
            // X = S_{k+1} D S_k^{-1}: solve S_k^T X^T = (S_{k+1} D)^T row by row.
            let lu = super::super::Lu::of(n, &basis[k]);
            let up = &basis[(k + 1) % count];
            let mut x = vec![0.0; n * n];
            for i in 0..n {
                let mut row: Vec<f64> = (0..n)
                    .map(|j| (0..n).map(|l| up[i * n + l] * d[l * n + j]).sum())
                    .collect();
                lu.solve_transposed(&mut row);
                x[i * n..(i + 1) * n].copy_from_slice(&row);
            }
            factors.push(x);
        }
        let found = product_eigenvalues(n, &factors).unwrap();
        let expected = [
            C::from_polar(1.01_f64.powi(7), 0.3 * 7.0),
            C::from_polar(1.01_f64.powi(7), -0.3 * 7.0),
            C::new(0.03_f64.powi(7), 0.0),
            C::new(-(0.5_f64.powi(7)), 0.0),
            C::new(1e-21, 0.0),
        ];
        for e in expected {
            let gap = found
                .iter()
                .map(|x| (x - e).norm() / e.norm())
                .fold(f64::INFINITY, f64::min);
            assert!(gap < 1e-10, "{e}: {gap:e} in {found:?}");
        }
    }
}
