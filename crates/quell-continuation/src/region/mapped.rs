//! A problem whose parameters are functions of others.

use crate::problem::Problem;

/// Parameters p as functions of others, u.
pub(super) trait Map: Sync {
    /// Number of the others.
    fn free(&self) -> usize;
    /// p(u).
    fn parameters(&self, u: &[f64]) -> Vec<f64>;
    /// ∂`p_j`/∂`u_k`, zero for most j.
    fn slope(&self, u: &[f64], j: usize, k: usize) -> f64;
}

/// ẋ = f(t, x, p(u)).
pub(super) struct Mapped<'p, M> {
    problem: &'p dyn Problem,
    pub(super) map: M,
}

impl<'p, M: Map> Mapped<'p, M> {
    pub(super) const fn of(problem: &'p dyn Problem, map: M) -> Self {
        Self { problem, map }
    }

    /// Σ ∂`p_j`/∂`u_k` ∂f/∂`p_j`, where `derivative(j)` writes the last.
    fn chained(
        &self,
        u: &[f64],
        k: usize,
        out: &mut [f64],
        mut derivative: impl FnMut(usize, &mut [f64]),
    ) {
        let mut slopes = (0..self.problem.parameters())
            .map(|j| (j, self.map.slope(u, j, k)))
            .filter(|(_, slope)| *slope != 0.0);
        let Some((j, slope)) = slopes.next() else {
            out.fill(0.0);
            return;
        };
        derivative(j, out);
        for value in out.iter_mut() {
            *value *= slope;
        }
        let mut own = Vec::new();
        for (j, slope) in slopes {
            own.resize(out.len(), 0.0);
            derivative(j, &mut own);
            crate::dense::axpy(slope, &own, out);
        }
    }
}

impl<M: Map> Problem for Mapped<'_, M> {
    fn states(&self) -> usize {
        self.problem.states()
    }
    fn parameters(&self) -> usize {
        self.map.free()
    }
    fn value(&self, t: f64, x: &[f64], p: &[f64], out: &mut [f64]) {
        self.problem.value(t, x, &self.map.parameters(p), out);
    }
    fn jacobian(&self, t: f64, x: &[f64], p: &[f64], out: &mut [f64]) {
        self.problem.jacobian(t, x, &self.map.parameters(p), out);
    }
    fn parameter_derivative(&self, t: f64, x: &[f64], p: &[f64], k: usize, out: &mut [f64]) {
        let own = self.map.parameters(p);
        self.chained(p, k, out, |j, out| {
            self.problem.parameter_derivative(t, x, &own, j, out);
        });
    }
    fn second(&self, t: f64, x: &[f64], p: &[f64], u: &[f64], v: &[f64], out: &mut [f64]) -> bool {
        let own = self.map.parameters(p);
        self.problem.second(t, x, &own, u, v, out)
    }
    fn third(
        &self,
        t: f64,
        x: &[f64],
        p: &[f64],
        u: &[f64],
        v: &[f64],
        w: &[f64],
        out: &mut [f64],
    ) -> bool {
        let own = self.map.parameters(p);
        self.problem.third(t, x, &own, u, v, w, out)
    }
    fn is_approximate(&self) -> bool {
        self.problem.is_approximate()
    }
    fn values(&self, t: &[f64], x: &[f64], p: &[f64], out: &mut [f64]) {
        self.problem.values(t, x, &self.map.parameters(p), out);
    }
    fn linearisations(
        &self,
        t: &[f64],
        x: &[f64],
        p: &[f64],
        values: &mut [f64],
        jacobians: &mut [f64],
    ) {
        let own = self.map.parameters(p);
        self.problem.linearisations(t, x, &own, values, jacobians);
    }
    fn seconds(
        &self,
        t: &[f64],
        x: &[f64],
        p: &[f64],
        u: &[f64],
        v: &[f64],
        out: &mut [f64],
    ) -> bool {
        let own = self.map.parameters(p);
        self.problem.seconds(t, x, &own, u, v, out)
    }
    fn thirds(
        &self,
        t: &[f64],
        x: &[f64],
        p: &[f64],
        u: &[f64],
        v: &[f64],
        w: &[f64],
        out: &mut [f64],
    ) -> bool {
        let own = self.map.parameters(p);
        self.problem.thirds(t, x, &own, u, v, w, out)
    }
    fn parameter_derivatives(&self, t: &[f64], x: &[f64], p: &[f64], k: usize, out: &mut [f64]) {
        let own = self.map.parameters(p);
        self.chained(p, k, out, |j, out| {
            self.problem.parameter_derivatives(t, x, &own, j, out);
        });
    }
}
