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
    let (mut a, mut b) = (vec![0.0; n * n], vec![0.0; n * n]);
    let mut lu = Lu::new();
    let mut column = vec![0.0; n];
    let mut log_det = 0.0;
    for i in 0..count {
        for r in 0..n {
            let (x, y) = c.condensed.ends(i, r);
            a[r * n..(r + 1) * n].copy_from_slice(x);
            b[r * n..(r + 1) * n].copy_from_slice(y);
        }
        if !lu.factor(n, &b) {
            return None;
        }
        let mut g = vec![0.0; n * n];
        for j in 0..n {
            for r in 0..n {
                column[r] = -a[r * n + j];
            }
            lu.solve(&mut column);
            for r in 0..n {
                g[r * n + j] = column[r];
            }
        }
        if !c.autonomous {
            log_det += Lu::of(n, &g).log_determinant();
        }
        if current.is_empty() {
            starts.push(i);
            current = g;
            continue;
        }
        let product = times(n, &g, &current);
        if condition(n, &product) > 1e4 {
            factors.push(std::mem::replace(&mut current, g));
            starts.push(i);
        } else {
            current = product;
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

fn times(n: usize, a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; n * n];
    for i in 0..n {
        for k in 0..n {
            crate::dense::axpy(
                a[i * n + k],
                &b[k * n..(k + 1) * n],
                &mut out[i * n..(i + 1) * n],
            );
        }
    }
    out
}

/// Ratio of the largest to the smallest diagonal of R in A P = Q R, a usual estimate of the condition.
fn condition(n: usize, a: &[f64]) -> f64 {
    let mut w = a.to_vec();
    let (mut largest, mut smallest) = (0.0_f64, f64::INFINITY);
    let mut used = vec![false; n];
    for _ in 0..n {
        // Gram-Schmidt on rows with pivoting.
        let mut best = -1.0;
        let mut pick = 0;
        for i in 0..n {
            if !used[i] {
                let s = dot(&w[i * n..(i + 1) * n], &w[i * n..(i + 1) * n]);
                if s > best {
                    best = s;
                    pick = i;
                }
            }
        }
        used[pick] = true;
        let size = best.max(0.0).sqrt();
        largest = largest.max(size);
        smallest = smallest.min(size);
        if size == 0.0 {
            return f64::INFINITY;
        }
        let unit: Vec<f64> = w[pick * n..(pick + 1) * n]
            .iter()
            .map(|x| x / size)
            .collect();
        for i in 0..n {
            if !used[i] {
                let row = &mut w[i * n..(i + 1) * n];
                let s = dot(row, &unit);
                crate::dense::axpy(-s, &unit, row);
            }
        }
    }
    largest / smallest
}
