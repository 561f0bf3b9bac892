//! What a continuation problem must offer: ẋ = f(t, x, p) and derivatives of f.

/// ẋ = f(t, x, p) with n states and parameters p, and exact derivatives.
///
/// Matrices are row major: `out[i * n + j]` is ∂`f_i`/∂`x_j`. Everything is SI or dimensionless as the caller likes; the crate
/// only scales steps. Methods must be pure: the same arguments give the same bits. A value outside the domain of f is
/// NaN; the branch then ends with a status that says so.
///
/// The methods in the plural evaluate many nodes at once (`t[k]`, `x[k n ..]`) and may be overridden by a compiled tape.
pub trait Problem: Sync {
    /// Number n of states.
    fn states(&self) -> usize;

    /// Number of parameters, of which one to three are free at a time.
    fn parameters(&self) -> usize;

    /// f(t, x, p).
    fn value(&self, t: f64, x: &[f64], p: &[f64], out: &mut [f64]);

    /// `f_x`(t, x, p), n × n.
    fn jacobian(&self, t: f64, x: &[f64], p: &[f64], out: &mut [f64]);

    /// ∂f/∂`p_k`, n values.
    fn parameter_derivative(&self, t: f64, x: &[f64], p: &[f64], k: usize, out: &mut [f64]);

    /// ∂f/∂t; zero unless overridden. Needed where the period of the forcing depends on a free parameter.
    fn time_derivative(&self, _t: f64, _x: &[f64], _p: &[f64], out: &mut [f64]) {
        out.fill(0.0);
    }

    /// The period of f in t, s, where f depends on t; None for an autonomous problem.
    fn period(&self, _p: &[f64]) -> Option<f64> {
        None
    }

    /// Derivative of [`period`](Self::period) by parameter k.
    fn period_derivative(&self, _p: &[f64], _k: usize) -> f64 {
        0.0
    }

    /// D²f\[u, v\] = Σ ∂²f/∂`x_i`∂`x_j` `u_i` `v_j`, exact. False (and nothing written) where not available: branches are then
    /// computed without normal forms.
    fn second(
        &self,
        _t: f64,
        _x: &[f64],
        _p: &[f64],
        _u: &[f64],
        _v: &[f64],
        _out: &mut [f64],
    ) -> bool {
        false
    }

    /// D³f\[u, v, w\], exact. False where not available.
    #[allow(clippy::too_many_arguments)] // one argument a symbol of the formula
    fn third(
        &self,
        _t: f64,
        _x: &[f64],
        _p: &[f64],
        _u: &[f64],
        _v: &[f64],
        _w: &[f64],
        _out: &mut [f64],
    ) -> bool {
        false
    }

    /// Whether derivatives are finite differences; results then say so.
    fn is_approximate(&self) -> bool {
        false
    }

    /// [`value`](Self::value) at every node.
    fn values(&self, t: &[f64], x: &[f64], p: &[f64], out: &mut [f64]) {
        let n = self.states();
        for ((t, x), out) in t.iter().zip(x.chunks_exact(n)).zip(out.chunks_exact_mut(n)) {
            self.value(*t, x, p, out);
        }
    }

    /// [`value`](Self::value) and [`jacobian`](Self::jacobian) at every node.
    fn linearisations(
        &self,
        t: &[f64],
        x: &[f64],
        p: &[f64],
        values: &mut [f64],
        jacobians: &mut [f64],
    ) {
        let n = self.states();
        self.values(t, x, p, values);
        for ((t, x), out) in t
            .iter()
            .zip(x.chunks_exact(n))
            .zip(jacobians.chunks_exact_mut(n * n))
        {
            self.jacobian(*t, x, p, out);
        }
    }

    /// [`parameter_derivative`](Self::parameter_derivative) at every node.
    fn parameter_derivatives(&self, t: &[f64], x: &[f64], p: &[f64], k: usize, out: &mut [f64]) {
        let n = self.states();
        for ((t, x), out) in t.iter().zip(x.chunks_exact(n)).zip(out.chunks_exact_mut(n)) {
            self.parameter_derivative(*t, x, p, k, out);
        }
    }

    /// [`second`](Self::second) at every node, u and v being given there too.
    fn seconds(
        &self,
        t: &[f64],
        x: &[f64],
        p: &[f64],
        u: &[f64],
        v: &[f64],
        out: &mut [f64],
    ) -> bool {
        let n = self.states();
        let nodes = t.iter().zip(x.chunks_exact(n)).zip(out.chunks_exact_mut(n));
        let directions = u.chunks_exact(n).zip(v.chunks_exact(n));
        nodes
            .zip(directions)
            .all(|(((t, x), out), (u, v))| self.second(*t, x, p, u, v, out))
    }

    /// [`third`](Self::third) at every node, u, v and w being given there too.
    #[allow(clippy::too_many_arguments)] // one argument a symbol of the formula
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
        let n = self.states();
        let nodes = t.iter().zip(x.chunks_exact(n)).zip(out.chunks_exact_mut(n));
        let directions = u.chunks_exact(n).zip(v.chunks_exact(n));
        nodes
            .zip(directions.zip(w.chunks_exact(n)))
            .all(|(((t, x), out), ((u, v), w))| self.third(*t, x, p, u, v, w, out))
    }

    /// [`time_derivative`](Self::time_derivative) at every node.
    fn time_derivatives(&self, t: &[f64], x: &[f64], p: &[f64], out: &mut [f64]) {
        let n = self.states();
        for ((t, x), out) in t.iter().zip(x.chunks_exact(n)).zip(out.chunks_exact_mut(n)) {
            self.time_derivative(*t, x, p, out);
        }
    }
}

/// A plain closure `f(t, x, p, out)` whose derivatives are central differences: results are marked approximate and
/// carry no normal forms.
///
/// ```
/// use quell_continuation::{Closure, Problem};
/// let field = Closure::new(1, 1, |_t, x: &[f64], p: &[f64], out: &mut [f64]| out[0] = p[0] + x[0] - x[0].powi(3));
/// let mut j = [0.0];
/// field.jacobian(0.0, &[2.0], &[0.0], &mut j);
/// assert!((j[0] + 11.0).abs() < 1e-7);
/// ```
pub struct Closure<F> {
    states: usize,
    parameters: usize,
    f: F,
}

impl<F: Fn(f64, &[f64], &[f64], &mut [f64]) + Sync> Closure<F> {
    /// An autonomous problem of so many states and parameters.
    pub fn new(states: usize, parameters: usize, f: F) -> Self {
        Self {
            states,
            parameters,
            f,
        }
    }

    fn difference(
        &self,
        t: f64,
        x: &[f64],
        p: &[f64],
        plus: &mut [f64],
        h: f64,
        of: &mut dyn FnMut(&mut [f64], &mut [f64], f64),
    ) {
        let (mut x, mut p) = (x.to_vec(), p.to_vec());
        let mut minus = vec![0.0; plus.len()];
        of(&mut x, &mut p, h);
        (self.f)(t, &x, &p, plus);
        of(&mut x, &mut p, -2.0 * h);
        (self.f)(t, &x, &p, &mut minus);
        for (a, b) in plus.iter_mut().zip(&minus) {
            *a = (*a - b) / (2.0 * h);
        }
    }
}

/// The step of a central difference about x: the cube root of the rounding unit, relative.
fn step(x: f64) -> f64 {
    6.1e-6 * x.abs().max(1e-2)
}

impl<F: Fn(f64, &[f64], &[f64], &mut [f64]) + Sync> Problem for Closure<F> {
    fn states(&self) -> usize {
        self.states
    }
    fn parameters(&self) -> usize {
        self.parameters
    }
    fn value(&self, t: f64, x: &[f64], p: &[f64], out: &mut [f64]) {
        (self.f)(t, x, p, out);
    }
    fn jacobian(&self, t: f64, x: &[f64], p: &[f64], out: &mut [f64]) {
        let n = self.states;
        let mut column = vec![0.0; n];
        for j in 0..n {
            self.difference(t, x, p, &mut column, step(x[j]), &mut |x, _, h| x[j] += h);
            for i in 0..n {
                out[i * n + j] = column[i];
            }
        }
    }
    fn parameter_derivative(&self, t: f64, x: &[f64], p: &[f64], k: usize, out: &mut [f64]) {
        self.difference(t, x, p, out, step(p[k]), &mut |_, p, h| p[k] += h);
    }
    fn is_approximate(&self) -> bool {
        true
    }
}
