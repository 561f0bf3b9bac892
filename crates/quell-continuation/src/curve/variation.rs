//! Null functions of the linearised orbit with x(1) = μ x(0), and the bordered function that vanishes with them.

use num_complex::Complex64;

use crate::dense::{Lu, axpy, largest};
use crate::orbit::bordered::{Bordered, Row};
use crate::orbit::collocation::Collocation;

type C = Complex64;

/// Which singularity is followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mode {
    /// Multiplier +1 besides the trivial one.
    Fold,
    /// Multiplier -1.
    Doubling,
    /// Multipliers exp(±iθ).
    Torus,
}

/// v and w of the reduced bordered system [R, b; c*, 0] (v; g) = (0; 1), R = A + μ B, on all nodes and equations.
///
/// At a fold of an autonomous problem R has the column of the period and the row of the phase as well.
#[derive(Clone, Debug, Default)]
pub(crate) struct Variation {
    pub(crate) b: Vec<C>,
    pub(crate) c: Vec<C>,
    /// Reduced vectors.
    pub(crate) v0: Vec<C>,
    pub(crate) w0: Vec<C>,
    pub(crate) g: C,
    /// Real and imaginary parts over the nodes, and of the period.
    pub(crate) v: [Vec<f64>; 2],
    pub(crate) tau: f64,
    /// Real and imaginary parts over the collocation equations.
    pub(crate) w: [Vec<f64>; 2],
    /// ∂g by the nodes, the period, the free parameters: real and imaginary parts.
    pub(crate) gradient: [Row; 2],
    /// ∂g/∂μ.
    pub(crate) by_multiplier: C,
    /// Room for what is evaluated beside the orbit.
    room: Room,
    /// Re w at the times of the last accepted point: (τ, w per equation of the Gauss point), which fixes the sign.
    reference: Vec<(f64, Vec<f64>)>,
}

/// Jacobians, states and rates on both sides of the orbit along v.
#[derive(Clone, Debug, Default)]
struct Room {
    plus: Vec<f64>,
    minus: Vec<f64>,
    up: Vec<f64>,
    down: Vec<f64>,
    above: Vec<f64>,
    below: Vec<f64>,
}

/// A phase row eliminated on a linearisation.
#[derive(Clone, Debug)]
pub(crate) struct ReducedPhase {
    /// What remains on `x_0` and `x_N`.
    row: Vec<f64>,
    /// Its entry for the period.
    corner: f64,
    /// Multipliers inside and between intervals.
    pub(crate) inner: Vec<f64>,
    pub(crate) mids: Vec<f64>,
}

impl ReducedPhase {
    /// Eliminates a row over the nodes; the first border column is that of the period.
    pub(crate) fn of(c: &Collocation<'_>, bordered: &Bordered, nodes: &[f64]) -> Self {
        let (mut inner, mut mids) = (Vec::new(), Vec::new());
        let mut row = vec![0.0; 2 * c.n];
        c.condensed
            .reduce_row(nodes, &mut inner, &mut mids, &mut row);
        let (data, column_mids, _) = bordered.column(0);
        let corner = -c.condensed.eliminated(&inner, &mids, data, column_mids);
        Self {
            row,
            corner,
            inner,
            mids,
        }
    }
}

impl Variation {
    /// The reduced matrix A + μ B, with the column of the period and the row of the phase where one is given.
    pub(crate) fn reduced(
        c: &Collocation<'_>,
        bordered: &Bordered,
        mu: C,
        phase: Option<&ReducedPhase>,
    ) -> (usize, Vec<C>) {
        let n = c.n;
        let size = n + usize::from(phase.is_some());
        let mut matrix = vec![C::default(); size * size];
        for i in 0..n {
            for j in 0..n {
                matrix[i * size + j] = mu * c.condensed.b[i * n + j] + c.condensed.a[i * n + j];
            }
        }
        if let Some(ReducedPhase { row, corner, .. }) = phase {
            let (_, _, last) = bordered.column(0);
            for i in 0..n {
                matrix[i * size + n] = C::new(last[i], 0.0);
                matrix[n * size + i] = C::new(row[i] + row[n + i], 0.0);
            }
            matrix[n * size + n] = C::new(*corner, 0.0);
        }
        (size, matrix)
    }

    /// Border vectors by inverse iteration.
    pub(crate) fn begin(
        &mut self,
        c: &Collocation<'_>,
        bordered: &Bordered,
        mu: C,
        phase: Option<&ReducedPhase>,
    ) {
        let (size, matrix) = Self::reduced(c, bordered, mu, phase);
        let lu = Lu::of(size, &matrix);
        let start: Vec<C> = (0..size)
            .map(|i| C::new(1.0 + 0.3 * (i as f64).sin(), 0.2 * (1.0 + i as f64).cos()))
            .collect();
        // Singular vectors: (Rᴴ R)⁻¹ and (R Rᴴ)⁻¹ alternately.
        let (mut right, mut left) = (start.clone(), start);
        for _ in 0..3 {
            conjugate(&mut right);
            lu.solve_transposed(&mut right);
            conjugate(&mut right);
            lu.solve(&mut right);
            unit(&mut right);
            lu.solve(&mut left);
            conjugate(&mut left);
            lu.solve_transposed(&mut left);
            conjugate(&mut left);
            unit(&mut left);
        }
        self.c = right;
        self.b = left;
    }

    /// New border vectors from the null vectors at hand.
    pub(crate) fn refresh(&mut self) {
        if self.v0.is_empty() {
            return;
        }
        self.c = self.v0.clone();
        unit(&mut self.c);
    }

    /// Keeps w at an accepted point. The reduced equations are combinations that change from one factorisation to the next,
    /// so only w on the collocation equations themselves has a sign that can be continued.
    pub(crate) fn keep_sign(&mut self, c: &Collocation<'_>) {
        if self.w[0].len() == c.nodes() && !self.v0.is_empty() {
            self.reference = (0..c.count() * c.rule.m)
                .map(|e| self.adjoint(c, e))
                .collect();
        }
    }

    /// τ and the adjoint at Gauss point e.
    fn adjoint(&self, c: &Collocation<'_>, e: usize) -> (f64, Vec<f64>) {
        let (m, n) = (c.rule.m, c.n);
        let (i, k) = (e / m, e % m);
        let scale = 1.0 / c.rule.gauss[k];
        (
            c.mesh[i] + c.rule.points[k] * c.step(i),
            self.w[0][e * n..(e + 1) * n]
                .iter()
                .map(|w| w * scale)
                .collect(),
        )
    }

    /// Whether w points against the reference.
    fn reversed(&self, c: &Collocation<'_>) -> bool {
        if self.reference.is_empty() {
            return false;
        }
        let mut sum = 0.0;
        let mut at = 0;
        for e in 0..c.count() * c.rule.m {
            let (tau, w) = self.adjoint(c, e);
            while at + 1 < self.reference.len()
                && (self.reference[at + 1].0 - tau).abs() <= (self.reference[at].0 - tau).abs()
            {
                at += 1;
            }
            sum += crate::dense::dot(&w, &self.reference[at].1)
                * c.step(e / c.rule.m)
                * c.rule.gauss[e % c.rule.m];
        }
        sum < 0.0
    }

    /// Solves for v, w and g at the linearisation at hand. False where not finite.
    pub(crate) fn solve(
        &mut self,
        c: &Collocation<'_>,
        bordered: &Bordered,
        mu: C,
        phase: Option<&ReducedPhase>,
    ) -> bool {
        let n = c.n;
        let (inner, matrix) = Self::reduced(c, bordered, mu, phase);
        let size = inner + 1;
        // b is found afresh: the reduced equations differ from those of the last factorisation.
        let reduced = Lu::of(inner, &matrix);
        let mut left: Vec<C> = (0..inner)
            .map(|i| {
                C::new(
                    1.0 + 0.3 * (i as f64).sin(),
                    0.2 * mu.im * (1.0 + i as f64).cos(),
                )
            })
            .collect();
        for _ in 0..2 {
            reduced.solve(&mut left);
            unit(&mut left);
            conjugate(&mut left);
            reduced.solve_transposed(&mut left);
            conjugate(&mut left);
            unit(&mut left);
        }
        self.b = left;
        let mut full = vec![C::default(); size * size];
        for i in 0..inner {
            full[i * size..i * size + inner].copy_from_slice(&matrix[i * inner..(i + 1) * inner]);
            full[i * size + inner] = self.b[i];
            full[inner * size + i] = self.c[i].conj();
        }
        let mut lu = Lu::new();
        if !lu.factor(size, &full) {
            return false;
        }
        let mut right = vec![C::default(); size];
        right[inner] = C::new(1.0, 0.0);
        let mut left = right.clone();
        lu.solve(&mut right);
        lu.solve_transposed(&mut left);
        self.g = right[inner];
        right.truncate(inner);
        left.truncate(inner);
        if right
            .iter()
            .chain(&left)
            .any(|x| !(x.re.is_finite() && x.im.is_finite()))
        {
            return false;
        }
        let complex = mu.im != 0.0;
        let nodes = c.nodes();
        self.tau = if phase.is_some() { right[n].re } else { 0.0 };
        for part in 0..2 {
            let take = |x: &C| if part == 0 { x.re } else { x.im };
            if part == 1 && !complex {
                self.v[1].clear();
                self.w[1].clear();
                continue;
            }
            let start: Vec<f64> = right[..n].iter().map(take).collect();
            let last: Vec<f64> = right[..n].iter().map(|x| take(&(mu * *x))).collect();
            self.v[part].resize(nodes, 0.0);
            if phase.is_some() {
                let (data, mids, _) = bordered.column(0);
                let data: Vec<f64> = data.iter().map(|x| -self.tau * x).collect();
                let mids: Vec<f64> = mids.iter().map(|x| -self.tau * x).collect();
                c.condensed
                    .backward(&start, &last, Some((&data, &mids)), &mut self.v[part]);
            } else {
                c.condensed.backward(&start, &last, None, &mut self.v[part]);
            }
            let weights: Vec<f64> = left[..n].iter().map(take).collect();
            self.w[part].resize(nodes, 0.0);
            let row = phase.map(|p| (take(&left[n]), &p.inner[..], &p.mids[..]));
            c.condensed.left(&weights, row, &mut self.w[part]);
        }
        self.by_multiplier = C::default();
        for i in 0..n {
            for j in 0..n {
                self.by_multiplier -= left[i] * right[j] * c.condensed.b[i * n + j];
            }
        }
        self.v0 = right;
        self.w0 = left;
        if self.reversed(c) {
            self.g = -self.g;
            self.by_multiplier = -self.by_multiplier;
            for x in self.b.iter_mut().chain(&mut self.w0) {
                *x = -*x;
            }
            for x in self.w.iter_mut().flatten() {
                *x = -*x;
            }
        }
        self.b.iter().all(|x| x.re.is_finite() && x.im.is_finite())
    }

    /// ∂g = -wᵀ ∂(linearisation) v, second derivatives of f by central differences of exact first ones along v.
    pub(crate) fn differentiate(&mut self, c: &Collocation<'_>, mu: C, scale: f64) {
        let (n, m, count) = (c.n, c.rule.m, c.count());
        let per = m * n;
        let total = count * m;
        let complex = mu.im != 0.0;
        let borders = c.borders();
        let offset = usize::from(c.autonomous);
        let mut nodes = [vec![0.0; total * n], vec![0.0; total * n]];
        let mut ends = [vec![0.0; borders], vec![0.0; borders]];
        let mut room = std::mem::take(&mut self.room);
        let Room {
            plus,
            minus,
            up,
            down,
            above: fu,
            below: fd,
        } = &mut room;
        for jacobians in [&mut *plus, &mut *minus] {
            jacobians.resize(total * n * n, 0.0);
        }
        for vectors in [&mut *up, &mut *down, &mut *fu, &mut *fd] {
            vectors.resize(total * n, 0.0);
        }
        // s (re, im) += (w) (dv) with the products of parts.
        let parts = if complex { 2 } else { 1 };
        let mut source = [vec![0.0; total * n], vec![0.0; total * n]];
        for pv in 0..parts {
            let mut at = vec![0.0; total * n];
            self.values(c, &self.v[pv], mu, pv, &mut at);
            let size = largest(&at);
            if !(size > 0.0) {
                continue;
            }
            let h = 1e-5 * scale / size;
            for i in 0..total * n {
                up[i] = c.states[i] + h * at[i];
                down[i] = c.states[i] - h * at[i];
            }
            let d = 1.0 / (2.0 * h);
            c.problem
                .linearisations(&c.times, up, &c.parameters, fu, plus);
            c.problem
                .linearisations(&c.times, down, &c.parameters, fd, minus);
            // f_x v at Gauss points, for the period.
            let mut image = vec![0.0; total * n];
            for e in 0..total {
                let jacobian = &c.jacobians[e * n * n..(e + 1) * n * n];
                crate::dense::multiply(
                    jacobian,
                    &at[e * n..(e + 1) * n],
                    &mut image[e * n..(e + 1) * n],
                );
            }
            for pw in 0..parts {
                // -w ∂ v with i² = -1 for both imaginary parts; the result's part.
                let (part, sign) = match (pw, pv) {
                    (0, 0) => (0, 1.0),
                    (1, 1) => (0, -1.0),
                    _ => (1, 1.0),
                };
                let w = &self.w[pw];
                for i in 0..count {
                    let hi = c.step(i);
                    for k in 0..m {
                        let e = i * m + k;
                        let s = &mut source[part][e * n..(e + 1) * n];
                        let mut by_period = 0.0;
                        for r in 0..n {
                            let weight = sign * w[i * per + k * n + r] * hi;
                            by_period += weight * image[e * n + r];
                            let row = (e * n + r) * n;
                            for j in 0..n {
                                s[j] += weight * c.period * (plus[row + j] - minus[row + j]) * d;
                            }
                            if self.tau != 0.0 && pv == 0 {
                                axpy(weight * self.tau, &c.jacobians[row..row + n], s);
                            }
                        }
                        if c.autonomous {
                            ends[part][0] += by_period;
                        }
                    }
                }
            }
            for (k, index) in c.free.iter().enumerate() {
                c.problem
                    .parameter_derivatives(&c.times, up, &c.parameters, *index, fu);
                c.problem
                    .parameter_derivatives(&c.times, down, &c.parameters, *index, fd);
                let mut along: Vec<f64> = fu
                    .iter()
                    .zip(fd.iter())
                    .map(|(a, b)| c.period * (a - b) * d)
                    .collect();
                if self.tau != 0.0 && pv == 0 {
                    // The column of the period depends on the parameter as well.
                    let mut direct = vec![0.0; total * n];
                    c.problem.parameter_derivatives(
                        &c.times,
                        &c.states,
                        &c.parameters,
                        *index,
                        &mut direct,
                    );
                    axpy(self.tau, &direct, &mut along);
                }
                let rate = if c.autonomous {
                    0.0
                } else {
                    c.periods as f64 * c.problem.period_derivative(&c.parameters, *index)
                };
                if rate != 0.0 {
                    c.problem.time_derivatives(&c.times, up, &c.parameters, fu);
                    c.problem
                        .time_derivatives(&c.times, down, &c.parameters, fd);
                    for e in 0..total {
                        let t = c.times[e];
                        for r in 0..n {
                            let q = e * n + r;
                            along[q] += rate * (image[q] + t * (fu[q] - fd[q]) * d);
                        }
                    }
                }
                for pw in 0..parts {
                    let (part, sign) = match (pw, pv) {
                        (0, 0) => (0, 1.0),
                        (1, 1) => (0, -1.0),
                        _ => (1, 1.0),
                    };
                    let w = &self.w[pw];
                    for i in 0..count {
                        let hi = sign * c.step(i);
                        ends[part][offset + k] += hi
                            * crate::dense::dot(
                                &w[i * per..(i + 1) * per],
                                &along[i * per..(i + 1) * per],
                            );
                    }
                }
            }
        }
        for part in 0..parts {
            for i in 0..count {
                for k in 0..m {
                    let s = &source[part][(i * m + k) * n..(i * m + k + 1) * n];
                    for l in 0..=m {
                        let index = (i * m + l) % total;
                        axpy(
                            c.rule.values[k * (m + 1) + l],
                            s,
                            &mut nodes[part][index * n..(index + 1) * n],
                        );
                    }
                }
            }
        }
        self.room = room;
        for (gradient, (nodes, ends)) in self.gradient.iter_mut().zip(nodes.into_iter().zip(ends)) {
            *gradient = Row { nodes, ends };
        }
    }

    /// v at Gauss points; its last node is μ times its first.
    pub(crate) fn values(
        &self,
        c: &Collocation<'_>,
        v: &[f64],
        mu: C,
        part: usize,
        out: &mut [f64],
    ) {
        let n = c.n;
        let wrap: Vec<f64> = self.v0[..n]
            .iter()
            .map(|x| {
                let last = mu * *x;
                if part == 0 {
                    last.re - x.re
                } else {
                    last.im - x.im
                }
            })
            .collect();
        c.interpolate(&c.rule.values, v, Some(&wrap), out);
    }
}

fn conjugate(x: &mut [C]) {
    for x in x {
        *x = x.conj();
    }
}

fn unit(x: &mut [C]) {
    let size = x.iter().map(C::norm_sqr).sum::<f64>().sqrt();
    if size > 0.0 {
        for x in x {
            *x /= size;
        }
    }
}
