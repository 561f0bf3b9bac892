//! The discretised orbit: x' = T f(Tτ, x, p) at Gauss points, x(1) = x(0) + winding.

#![allow(clippy::inline_always)] // only what is inlined is compiled for the vectors of the machine

use pulp::{Arch, Simd, WithSimd};

use super::condense::Condensed;
use super::rule::Rule;
use crate::dense::axpy;
use crate::path::Failure;
use crate::problem::Problem;

/// Unknowns are the nodes (N m n), the period where the problem is autonomous, then the free parameters.
pub(crate) struct Collocation<'a> {
    pub(crate) problem: &'a dyn Problem,
    pub(crate) parameters: Vec<f64>,
    pub(crate) free: Vec<usize>,
    /// Periods of the forcing in an orbit.
    pub(crate) periods: usize,
    pub(crate) autonomous: bool,
    pub(crate) winding: Vec<f64>,
    pub(crate) rule: Rule,
    pub(crate) mesh: Vec<f64>,
    pub(crate) n: usize,
    pub(crate) period: f64,
    pub(crate) condensed: Condensed,
    /// Raw columns of the period (if unknown) and the free parameters.
    pub(crate) columns: Vec<Vec<f64>>,
    pub(crate) times: Vec<f64>,
    pub(crate) states: Vec<f64>,
    pub(crate) fields: Vec<f64>,
    pub(crate) jacobians: Vec<f64>,
    scratch: Vec<f64>,
}

impl<'a> Collocation<'a> {
    pub(crate) fn new(
        problem: &'a dyn Problem,
        parameters: &[f64],
        free: &[usize],
        periods: usize,
        degree: usize,
        mesh: Vec<f64>,
        winding: Vec<f64>,
    ) -> Self {
        let n = problem.states();
        let mut out = Self {
            problem,
            parameters: parameters.to_vec(),
            free: free.to_vec(),
            periods,
            autonomous: problem.period(parameters).is_none(),
            winding,
            rule: Rule::new(degree),
            mesh: Vec::new(),
            n,
            period: 0.0,
            condensed: Condensed::default(),
            columns: Vec::new(),
            times: Vec::new(),
            states: Vec::new(),
            fields: Vec::new(),
            jacobians: Vec::new(),
            scratch: Vec::new(),
        };
        out.set_mesh(mesh);
        out
    }

    pub(crate) fn set_mesh(&mut self, mesh: Vec<f64>) {
        self.mesh = mesh;
        let (count, m, n) = (self.count(), self.rule.m, self.n);
        self.condensed.resize(n, m, count);
        let nodes = count * m;
        self.times.resize(nodes, 0.0);
        self.states.resize(nodes * n, 0.0);
        self.fields.resize(nodes * n, 0.0);
        self.jacobians.resize(nodes * n * n, 0.0);
        self.scratch.resize(nodes * n, 0.0);
        self.columns.resize(self.borders(), Vec::new());
        for c in &mut self.columns {
            c.resize(nodes * n, 0.0);
        }
    }

    /// N.
    pub(crate) fn count(&self) -> usize {
        self.mesh.len() - 1
    }
    /// N m n.
    pub(crate) fn nodes(&self) -> usize {
        self.count() * self.rule.m * self.n
    }
    /// Unknowns besides the nodes.
    pub(crate) fn borders(&self) -> usize {
        self.free.len() + usize::from(self.autonomous)
    }
    /// Index of the first free parameter among the unknowns.
    pub(crate) fn first_parameter(&self) -> usize {
        self.nodes() + usize::from(self.autonomous)
    }
    pub(crate) fn step(&self, i: usize) -> f64 {
        self.mesh[i + 1] - self.mesh[i]
    }

    /// Node k of interval i, with the winding where it wraps round.
    pub(crate) fn node(&self, z: &[f64], i: usize, k: usize, j: usize) -> f64 {
        let index = i * self.rule.m + k;
        let total = self.count() * self.rule.m;
        if index == total {
            z[j] + self.winding[j]
        } else {
            z[index * self.n + j]
        }
    }

    /// Values at Gauss points of anything on the nodes; `wrap` is added at the end.
    pub(crate) fn interpolate(
        &self,
        table: &[f64],
        z: &[f64],
        wrap: Option<&[f64]>,
        out: &mut [f64],
    ) {
        Arch::new().dispatch(Interpolate(self, table, z, wrap, out));
    }

    #[inline(always)]
    fn interpolate_in_vectors(
        &self,
        table: &[f64],
        z: &[f64],
        wrap: Option<&[f64]>,
        out: &mut [f64],
    ) {
        let (m, n, count) = (self.rule.m, self.n, self.count());
        let per = m * n;
        // The last interval ends where the first begins.
        let mut last = vec![0.0; per + n];
        last[..per].copy_from_slice(&z[(count - 1) * per..count * per]);
        last[per..].copy_from_slice(&z[..n]);
        if let Some(w) = wrap {
            axpy(1.0, w, &mut last[per..]);
        }
        for (i, out) in out.chunks_exact_mut(per).take(count).enumerate() {
            let nodes = if i + 1 < count {
                &z[i * per..(i + 1) * per + n]
            } else {
                &last[..]
            };
            combine(&table[..m * (m + 1)], nodes, n, out);
        }
    }

    /// Sets parameters, period, times and states at Gauss points from the unknowns.
    pub(crate) fn set(&mut self, z: &[f64]) {
        let first = self.first_parameter();
        for (k, index) in self.free.iter().enumerate() {
            self.parameters[*index] = z[first + k];
        }
        self.period = if self.autonomous {
            z[self.nodes()]
        } else {
            self.periods as f64 * self.problem.period(&self.parameters).unwrap_or(f64::NAN)
        };
        let m = self.rule.m;
        for i in 0..self.count() {
            for c in 0..m {
                self.times[i * m + c] = if self.autonomous {
                    0.0
                } else {
                    self.period * (self.mesh[i] + self.rule.points[c] * self.step(i))
                };
            }
        }
        let mut states = std::mem::take(&mut self.states);
        self.interpolate(&self.rule.values, z, Some(&self.winding), &mut states);
        self.states = states;
    }

    /// Collocation residual Σ D x - h T f into the first N m n entries.
    pub(crate) fn residual(&mut self, z: &[f64], out: &mut [f64]) -> Result<(), Failure> {
        self.set(z);
        self.problem.values(
            &self.times,
            &self.states,
            &self.parameters,
            &mut self.fields,
        );
        self.interpolate(
            &self.rule.slopes,
            z,
            Some(&self.winding),
            &mut out[..self.nodes()],
        );
        let per = self.rule.m * self.n;
        for i in 0..self.count() {
            let h = self.step(i) * self.period;
            axpy(
                -h,
                &self.fields[i * per..(i + 1) * per],
                &mut out[i * per..(i + 1) * per],
            );
        }
        if out[..self.nodes()].iter().all(|x| x.is_finite()) && self.period > 0.0 {
            Ok(())
        } else {
            Err(Failure::NotFinite)
        }
    }

    /// Linearises and condenses at z; columns are filled.
    pub(crate) fn linearise(&mut self, z: &[f64]) -> Result<(), Failure> {
        self.set(z);
        self.problem.linearisations(
            &self.times,
            &self.states,
            &self.parameters,
            &mut self.fields,
            &mut self.jacobians,
        );
        let (m, n, count) = (self.rule.m, self.n, self.count());
        Arch::new().dispatch(Fill(self));
        if !self.condensed.factor() {
            return Err(Failure::NotFinite);
        }
        let per = m * n;
        let mut columns = std::mem::take(&mut self.columns);
        let offset = usize::from(self.autonomous);
        if self.autonomous {
            for i in 0..count {
                let h = self.step(i);
                for (o, f) in columns[0][i * per..(i + 1) * per]
                    .iter_mut()
                    .zip(&self.fields[i * per..(i + 1) * per])
                {
                    *o = -h * f;
                }
            }
        }
        for (k, index) in self.free.iter().enumerate() {
            self.problem.parameter_derivatives(
                &self.times,
                &self.states,
                &self.parameters,
                *index,
                &mut self.scratch,
            );
            let column = &mut columns[offset + k];
            for i in 0..count {
                let h = self.step(i) * self.period;
                for (o, f) in column[i * per..(i + 1) * per]
                    .iter_mut()
                    .zip(&self.scratch[i * per..(i + 1) * per])
                {
                    *o = -h * f;
                }
            }
            let rate = if self.autonomous {
                0.0
            } else {
                self.periods as f64 * self.problem.period_derivative(&self.parameters, *index)
            };
            if rate != 0.0 {
                // d/dp of T f(Tτ) through T: T_p (f + t f_t).
                self.problem.time_derivatives(
                    &self.times,
                    &self.states,
                    &self.parameters,
                    &mut self.scratch,
                );
                for i in 0..count {
                    let h = self.step(i);
                    for c in 0..m {
                        let t = self.times[i * m + c];
                        for r in 0..n {
                            let e = (i * m + c) * n + r;
                            column[e] -= h * rate * (self.fields[e] + t * self.scratch[e]);
                        }
                    }
                }
            }
        }
        self.columns = columns;
        Ok(())
    }

    /// The blocks of the condensed system from the Jacobians.
    #[inline(always)]
    fn fill(&mut self) {
        let (m, n, count) = (self.rule.m, self.n, self.count());
        let w = self.condensed.stride();
        let q = self.condensed.inner();
        let size = self.condensed.block_size();
        for i in 0..count {
            let h = self.step(i) * self.period;
            let block = &mut self.condensed.blocks[i * size..(i + 1) * size];
            for c in 0..m {
                let jacobian = &self.jacobians[(i * m + c) * n * n..(i * m + c + 1) * n * n];
                let values = &self.rule.values[c * (m + 1)..(c + 1) * (m + 1)];
                let slopes = &self.rule.slopes[c * (m + 1)..(c + 1) * (m + 1)];
                let rows = block[c * n * w..(c + 1) * n * w].chunks_exact_mut(w);
                for (r, (row, j)) in rows.zip(jacobian.chunks_exact(n)).enumerate() {
                    // Inner nodes, then both ends.
                    for k in 0..=m {
                        let column = match k {
                            0 => q,
                            _ if k == m => q + n,
                            _ => (k - 1) * n,
                        };
                        let s = -h * values[k];
                        let part = &mut row[column..column + n];
                        for (x, j) in part.iter_mut().zip(j) {
                            *x = s * j;
                        }
                        part[r] += slopes[k];
                    }
                    row[q + 2 * n..].fill(0.0);
                }
            }
        }
    }

    /// The row of the phase condition ∫⟨x, x_ref'⟩ dτ over the nodes.
    pub(crate) fn phase_row(&self, reference: &[f64]) -> Vec<f64> {
        let (m, n, count) = (self.rule.m, self.n, self.count());
        let mut slopes = vec![0.0; count * m * n];
        self.interpolate(
            &self.rule.slopes,
            reference,
            Some(&self.winding),
            &mut slopes,
        );
        self.functional(&slopes)
    }

    /// The row r with r · z = Σ over Gauss points of `b_c` ⟨g, x⟩ (per interval, without its length) for g at Gauss points.
    pub(crate) fn functional(&self, g: &[f64]) -> Vec<f64> {
        let (m, n, count) = (self.rule.m, self.n, self.count());
        let total = count * m;
        let mut row = vec![0.0; total * n];
        for i in 0..count {
            for c in 0..m {
                let g = &g[(i * m + c) * n..(i * m + c + 1) * n];
                for k in 0..=m {
                    let index = (i * m + k) % total;
                    axpy(
                        self.rule.gauss[c] * self.rule.values[c * (m + 1) + k],
                        g,
                        &mut row[index * n..(index + 1) * n],
                    );
                }
            }
        }
        row
    }

    /// Quadrature weights of the nodes, Σ = 1, one per node.
    pub(crate) fn weights(&self) -> Vec<f64> {
        let (m, count) = (self.rule.m, self.count());
        let total = count * m;
        let mut out = vec![0.0; total];
        for i in 0..count {
            for k in 0..=m {
                out[(i * m + k) % total] += self.step(i) * self.rule.weights[k];
            }
        }
        out
    }
}

/// What is compiled for the vectors of the machine, with all it calls.
struct Fill<'a, 'p>(&'a mut Collocation<'p>);
struct Interpolate<'a, 'p>(
    &'a Collocation<'p>,
    &'a [f64],
    &'a [f64],
    Option<&'a [f64]>,
    &'a mut [f64],
);

impl WithSimd for Fill<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.0.fill();
    }
}

impl WithSimd for Interpolate<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self(collocation, table, z, wrap, out) = self;
        collocation.interpolate_in_vectors(table, z, wrap, out);
    }
}

/// Rows of the table times the nodes of an interval, n values each; usual numbers of states are compiled for themselves.
#[inline(always)]
fn combine(table: &[f64], nodes: &[f64], n: usize, out: &mut [f64]) {
    match n {
        2 => combine_few::<2>(table, nodes, out),
        3 => combine_few::<3>(table, nodes, out),
        4 => combine_few::<4>(table, nodes, out),
        5 => combine_few::<5>(table, nodes, out),
        6 => combine_few::<6>(table, nodes, out),
        7 => combine_few::<7>(table, nodes, out),
        8 => combine_few::<8>(table, nodes, out),
        _ => combine_many(table, nodes, n, out),
    }
}

#[inline(always)]
fn combine_few<const N: usize>(table: &[f64], nodes: &[f64], out: &mut [f64]) {
    let (nodes, _) = nodes.as_chunks::<N>();
    let (out, _) = out.as_chunks_mut::<N>();
    for (weights, out) in table.chunks_exact(nodes.len()).zip(out) {
        let mut sum = [0.0; N];
        for (weight, node) in weights.iter().zip(nodes) {
            for j in 0..N {
                sum[j] += weight * node[j];
            }
        }
        *out = sum;
    }
}

#[inline(always)]
fn combine_many(table: &[f64], nodes: &[f64], n: usize, out: &mut [f64]) {
    let m = out.len() / n;
    for (weights, out) in table.chunks_exact(m + 1).zip(out.chunks_exact_mut(n)) {
        let mut from = 0;
        out.fill(0.0);
        while from + 3 <= weights.len() {
            let at = |k: usize| &nodes[(from + k) * n..(from + k + 1) * n];
            let (a, b, c) = (at(0), at(1), at(2));
            let (u, v, w) = (weights[from], weights[from + 1], weights[from + 2]);
            for j in 0..n {
                out[j] += (u * a[j] + v * b[j]) + w * c[j];
            }
            from += 3;
        }
        for k in from..weights.len() {
            axpy(weights[k], &nodes[k * n..(k + 1) * n], out);
        }
    }
}
