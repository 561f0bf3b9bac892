//! A periodic orbit as it is handed out.

use super::rule::{Rule, lagrange};

/// A periodic orbit: piecewise polynomials of degree m in τ = t / T.
#[derive(Clone, Debug, PartialEq)]
pub struct Orbit {
    /// Mesh points in [0, 1], N + 1 of them.
    pub mesh: Vec<f64>,
    /// Degree m.
    pub degree: usize,
    /// Number of states n.
    pub dimension: usize,
    /// States at the nodes, (N m + 1) n values; the last node is the first one plus the winding.
    pub states: Vec<f64>,
    /// Period T, s.
    pub period: f64,
    /// Number of periods of the forcing in T; 1 for autonomous problems.
    pub periods: usize,
    /// By how many turns each coordinate advances in a period; zeros save on angles.
    pub winding: Vec<f64>,
    /// All parameters.
    pub parameters: Vec<f64>,
}

impl Orbit {
    /// The nodes of τ, one for each state kept.
    pub fn times(&self) -> Vec<f64> {
        let rule = Rule::new(self.degree);
        let mut out = Vec::with_capacity(self.mesh.len() * self.degree);
        for pair in self.mesh.windows(2) {
            for k in 0..self.degree {
                out.push(pair[0] + rule.nodes[k] * (pair[1] - pair[0]));
            }
        }
        out.push(1.0);
        out
    }

    /// x(τ) for τ in [0, 1].
    pub fn state(&self, tau: f64) -> Vec<f64> {
        let count = self.mesh.len() - 1;
        let i = self.mesh.partition_point(|t| *t <= tau).clamp(1, count) - 1;
        let (m, n) = (self.degree, self.dimension);
        let mut l = vec![0.0; m + 1];
        let rule = Rule::new(m);
        lagrange(
            &rule.nodes,
            (tau - self.mesh[i]) / (self.mesh[i + 1] - self.mesh[i]),
            &mut l,
        );
        let mut out = vec![0.0; n];
        for (k, l) in l.iter().enumerate() {
            crate::dense::axpy(
                *l,
                &self.states[(i * m + k) * n..(i * m + k + 1) * n],
                &mut out,
            );
        }
        out
    }

    /// Least and largest value of coordinate i, of the polynomials and not of the nodes.
    pub fn range(&self, i: usize) -> (f64, f64) {
        let rule = Rule::new(self.degree);
        let (m, n) = (self.degree, self.dimension);
        let count = self.mesh.len() - 1;
        let mut l = vec![0.0; m + 1];
        let mut value = |j: usize, x: f64| {
            lagrange(&rule.nodes, x, &mut l);
            (0..=m)
                .map(|k| l[k] * self.states[(j * m + k) * n + i])
                .sum::<f64>()
        };
        let mut best = [(f64::INFINITY, 0, 0.0), (f64::INFINITY, 0, 0.0)];
        let fine = 4 * m;
        for j in 0..count {
            for k in 0..=fine {
                let x = k as f64 / fine as f64;
                let v = value(j, x);
                for (best, v) in best.iter_mut().zip([v, -v]) {
                    if v < best.0 {
                        *best = (v, j, x);
                    }
                }
            }
        }
        // Golden section about the best sample.
        let mut out = [0.0; 2];
        for (s, (least, j, x)) in best.into_iter().enumerate() {
            let sign = if s == 0 { 1.0 } else { -1.0 };
            let g = 0.5 * (5.0_f64.sqrt() - 1.0);
            let h = 1.0 / fine as f64;
            let (mut a, mut b) = ((x - h).max(0.0), (x + h).min(1.0));
            for _ in 0..60 {
                let (c, d) = (b - g * (b - a), a + g * (b - a));
                if sign * value(j, c) < sign * value(j, d) {
                    b = d;
                } else {
                    a = c;
                }
            }
            out[s] = sign * least.min(sign * value(j, 0.5 * (a + b)));
        }
        (out[0], out[1])
    }
}
