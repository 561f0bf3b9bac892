//! The polynomials of a mesh interval: nodes, Gauss points, Lagrange values and derivatives.

/// Interpolation at the m + 1 Chebyshev-Lobatto nodes of [0, 1], collocation at the m Gauss points.
#[derive(Clone, Debug)]
pub(crate) struct Rule {
    pub(crate) m: usize,
    /// Nodes ξ, ascending, from 0 to 1.
    pub(crate) nodes: Vec<f64>,
    /// Gauss points.
    pub(crate) points: Vec<f64>,
    /// Gauss weights, sum 1.
    pub(crate) gauss: Vec<f64>,
    /// Lagrange values at Gauss points, m × (m + 1).
    pub(crate) values: Vec<f64>,
    /// Lagrange derivatives at Gauss points, m × (m + 1).
    pub(crate) slopes: Vec<f64>,
    /// Quadrature weights of the nodes, sum 1.
    pub(crate) weights: Vec<f64>,
    /// m-th derivative of each Lagrange polynomial (a constant).
    pub(crate) top: Vec<f64>,
}

impl Rule {
    /// The rule of degree m, between 2 and 7.
    pub(crate) fn new(m: usize) -> Self {
        let m = m.clamp(2, 7);
        let nodes: Vec<f64> = (0..=m)
            .map(|k| 0.5 * (1.0 - (std::f64::consts::PI * k as f64 / m as f64).cos()))
            .collect();
        let (points, gauss) = gauss(m);
        let mut values = vec![0.0; m * (m + 1)];
        let mut slopes = vec![0.0; m * (m + 1)];
        for (i, x) in points.iter().enumerate() {
            lagrange(&nodes, *x, &mut values[i * (m + 1)..(i + 1) * (m + 1)]);
            lagrange_slopes(&nodes, *x, &mut slopes[i * (m + 1)..(i + 1) * (m + 1)]);
        }
        // The Gauss rule integrates every Lagrange polynomial exactly.
        let weights = (0..=m)
            .map(|k| (0..m).map(|i| gauss[i] * values[i * (m + 1) + k]).sum())
            .collect();
        let factorial: f64 = (1..=m).map(|k| k as f64).product();
        let top = (0..=m)
            .map(|k| {
                factorial
                    / (0..=m)
                        .filter(|j| *j != k)
                        .map(|j| nodes[k] - nodes[j])
                        .product::<f64>()
            })
            .collect();
        Self {
            m,
            nodes,
            points,
            gauss,
            values,
            slopes,
            weights,
            top,
        }
    }
}

/// Lagrange polynomials of `nodes` at x.
pub(crate) fn lagrange(nodes: &[f64], x: f64, out: &mut [f64]) {
    for (k, o) in out.iter_mut().enumerate() {
        *o = 1.0;
        for (j, xj) in nodes.iter().enumerate() {
            if j != k {
                *o *= (x - xj) / (nodes[k] - xj);
            }
        }
    }
}

/// Their derivatives at x.
pub(crate) fn lagrange_slopes(nodes: &[f64], x: f64, out: &mut [f64]) {
    for (k, o) in out.iter_mut().enumerate() {
        *o = 0.0;
        for l in 0..nodes.len() {
            if l == k {
                continue;
            }
            let mut term = 1.0 / (nodes[k] - nodes[l]);
            for (j, xj) in nodes.iter().enumerate() {
                if j != k && j != l {
                    term *= (x - xj) / (nodes[k] - xj);
                }
            }
            *o += term;
        }
    }
}

/// Gauss-Legendre points and weights on [0, 1] by Newton on the Legendre polynomial.
fn gauss(m: usize) -> (Vec<f64>, Vec<f64>) {
    let mut points = Vec::with_capacity(m);
    let mut weights = Vec::with_capacity(m);
    for i in 0..m {
        let mut x = -(std::f64::consts::PI * (i as f64 + 0.75) / (m as f64 + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..50 {
            let (mut p0, mut p1) = (1.0, x);
            for k in 2..=m {
                let k = k as f64;
                (p0, p1) = (p1, ((2.0 * k - 1.0) * x * p1 - (k - 1.0) * p0) / k);
            }
            slope = m as f64 * (x * p1 - p0) / (x * x - 1.0);
            let step = p1 / slope;
            x -= step;
            if step.abs() < 1e-16 {
                break;
            }
        }
        points.push(0.5 * (1.0 + x));
        weights.push(1.0 / ((1.0 - x * x) * slope * slope));
    }
    (points, weights)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_exact_for_their_degree() {
        for m in 2..=7 {
            let rule = Rule::new(m);
            for degree in 0..2 * m {
                let sum: f64 = (0..m)
                    .map(|i| rule.gauss[i] * rule.points[i].powi(degree as i32))
                    .sum();
                assert!((sum - 1.0 / (degree as f64 + 1.0)).abs() < 1e-14);
            }
            for i in 0..m {
                let at = |table: &[f64], degree: i32| -> f64 {
                    (0..=m)
                        .map(|k| table[i * (m + 1) + k] * rule.nodes[k].powi(degree))
                        .sum()
                };
                for d in 1..=m as i32 {
                    assert!((at(&rule.values, d) - rule.points[i].powi(d)).abs() < 1e-13);
                    assert!(
                        (at(&rule.slopes, d) - f64::from(d) * rule.points[i].powi(d - 1)).abs()
                            < 1e-12
                    );
                }
            }
            let factorial: f64 = (1..=m).map(|k| k as f64).product();
            let top: f64 = (0..=m)
                .map(|k| rule.top[k] * rule.nodes[k].powi(m as i32))
                .sum();
            assert!((top - factorial).abs() < 1e-9 * factorial);
        }
    }
}
