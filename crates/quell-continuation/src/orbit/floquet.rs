//! Floquet multipliers from the condensed system.
//!
//! Interval i maps `x_i` to `x_{i+1}` by `G_i` = -`B_i`⁻¹ `A_i`. Neighbours are multiplied while their product stays well conditioned;
//! the eigenvalues of the product of what remains come from its periodic Schur form. On autonomous orbits the direction of
//! the flow is projected out at the ends of each factor, so that the other multipliers stay smooth where one of them
//! passes +1.

use num_complex::Complex64;

use super::collocation::Collocation;
use crate::dense::{Lu, dot, norm, product_eigenvalues};

/// Multipliers without the trivial one, and an error bar.
#[derive(Clone, Debug, Default)]
pub(crate) struct Multipliers {
    pub(crate) values: Vec<Complex64>,
    /// |μ - 1| of the trivial multiplier; on forced orbits |det M exp(-∫ tr f_x) - 1|.
    pub(crate) error: f64,
}

/// Multipliers at the linearisation at hand; `z` are its unknowns.
pub(crate) fn multipliers(c: &Collocation<'_>, z: &[f64]) -> Option<Multipliers> {
    let n = c.n;
    let count = c.count();
    let mut factors: Vec<Vec<f64>> = Vec::new();
    let mut starts: Vec<usize> = Vec::new();
    let mut current: Vec<f64> = Vec::new();
    let (mut g, mut b) = (vec![0.0; n * n], vec![0.0; n * n]);
    let (mut product, mut work) = (vec![0.0; n * n], vec![0.0; n * n]);
    let mut lu = Lu::new();
    let mut log_det = 0.0;
    for i in 0..count {
        for r in 0..n {
            let (x, y) = c.condensed.ends(i, r);
            for (g, x) in g[r * n..(r + 1) * n].iter_mut().zip(x) {
                *g = -x;
            }
            b[r * n..(r + 1) * n].copy_from_slice(y);
        }
        if !lu.factor(n, &b) {
            return None;
        }
        lu.solve_rows(&mut g);
        if !c.autonomous {
            log_det += Lu::of(n, &g).log_determinant();
        }
        if current.is_empty() {
            starts.push(i);
            current.clone_from(&g);
            continue;
        }
        times(n, &g, &current, &mut product);
        if condition(n, &product, &mut work) > 1e4 {
            factors.push(std::mem::replace(&mut current, g.clone()));
            starts.push(i);
        } else {
            std::mem::swap(&mut current, &mut product);
        }
    }
    factors.push(current);
    if !c.autonomous {
        let mut trace = 0.0;
        let m = c.rule.m;
        for i in 0..count {
            for k in 0..m {
                let jacobian = &c.jacobians[(i * m + k) * n * n..(i * m + k + 1) * n * n];
                let sum: f64 = (0..n).map(|r| jacobian[r * n + r]).sum();
                trace += c.step(i) * c.period * c.rule.gauss[k] * sum;
            }
        }
        return Some(Multipliers {
            values: product_eigenvalues(n, &factors)?,
            error: (log_det - trace).exp_m1().abs(),
        });
    }
    // Householder frames whose first column is the flow.
    let mut flow = vec![0.0; n];
    let frames: Vec<Vec<f64>> = starts
        .iter()
        .map(|i| {
            let at = i * c.rule.m * n;
            c.problem
                .value(0.0, &z[at..at + n], &c.parameters, &mut flow);
            frame(&flow)
        })
        .collect();
    let k = n - 1;
    let mut reduced = Vec::with_capacity(factors.len());
    let mut trivial = 1.0;
    for (i, factor) in factors.iter().enumerate() {
        let (from, to) = (&frames[i], &frames[(i + 1) % frames.len()]);
        let mut part = factor.clone();
        reflect_columns(n, &mut part, from);
        reflect_rows(n, &mut part, to);
        // |f| at both ends belongs to the trivial product and cancels round the cycle.
        trivial *= part[0];
        let mut small = vec![0.0; k * k];
        for r in 0..k {
            small[r * k..(r + 1) * k].copy_from_slice(&part[(r + 1) * n + 1..(r + 2) * n]);
        }
        reduced.push(small);
    }
    let values = if k == 0 {
        Vec::new()
    } else {
        product_eigenvalues(k, &reduced)?
    };
    Some(Multipliers {
        values,
        error: (trivial.abs() - 1.0).abs(),
    })
}

/// u of the reflection I - 2 u uᵀ that maps e₁ to the direction of f (up to sign).
fn frame(f: &[f64]) -> Vec<f64> {
    let size = norm(f);
    let mut u: Vec<f64> = f
        .iter()
        .map(|x| if size > 0.0 { x / size } else { 0.0 })
        .collect();
    if size == 0.0 {
        return u;
    }
    u[0] += if u[0] >= 0.0 { 1.0 } else { -1.0 };
    let length = norm(&u);
    for x in &mut u {
        *x /= length;
    }
    u
}

fn reflect_columns(n: usize, a: &mut [f64], u: &[f64]) {
    for row in a.chunks_exact_mut(n) {
        let s = 2.0 * dot(row, u);
        for (x, u) in row.iter_mut().zip(u) {
            *x -= s * u;
        }
    }
}

fn reflect_rows(n: usize, a: &mut [f64], u: &[f64]) {
    for j in 0..n {
        let s = 2.0 * (0..n).map(|i| u[i] * a[i * n + j]).sum::<f64>();
        for i in 0..n {
            a[i * n + j] -= s * u[i];
        }
    }
}

/// a b.
fn times(n: usize, a: &[f64], b: &[f64], out: &mut [f64]) {
    out.fill(0.0);
    for (a, out) in a.chunks_exact(n).zip(out.chunks_exact_mut(n)) {
        for (a, b) in a.iter().zip(b.chunks_exact(n)) {
            crate::dense::axpy(*a, b, out);
        }
    }
}

/// Ratio of the largest to the smallest diagonal of R in A P = Q R, a usual estimate of the condition; `w` is room for A.
fn condition(n: usize, a: &[f64], w: &mut [f64]) -> f64 {
    w.copy_from_slice(a);
    let (mut largest, mut smallest) = (0.0_f64, f64::INFINITY);
    // Gram-Schmidt on rows with pivoting; those that are done come first.
    for k in 0..n {
        let mut best = -1.0;
        let mut pick = k;
        for i in k..n {
            let row = &w[i * n..(i + 1) * n];
            let s = dot(row, row);
            if s > best {
                best = s;
                pick = i;
            }
        }
        let size = best.max(0.0).sqrt();
        largest = largest.max(size);
        smallest = smallest.min(size);
        if size == 0.0 {
            return f64::INFINITY;
        }
        let (done, rest) = w.split_at_mut((k + 1) * n);
        let unit = &mut done[k * n..];
        if pick > k {
            unit.swap_with_slice(&mut rest[(pick - k - 1) * n..(pick - k) * n]);
        }
        for x in &mut *unit {
            *x /= size;
        }
        for row in rest.chunks_exact_mut(n) {
            let s = dot(row, unit);
            crate::dense::axpy(-s, unit, row);
        }
    }
    largest / smallest
}
