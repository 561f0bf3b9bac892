//! Polynomials through Chebyshev-Lobatto points, the form in which every step of a trajectory is kept.

use std::sync::OnceLock;

/// Highest degree that is used.
pub(crate) const HIGHEST: usize = 12;

/// Points c_j = (1 - cos(πj/N))/2 on [0, 1] with what is needed to interpolate, integrate and judge a polynomial through them.
#[derive(Debug)]
pub(crate) struct Nodes {
    /// Degree N; there are N + 1 points.
    pub(crate) degree: usize,
    /// The points.
    pub(crate) points: Vec<f64>,
    /// Weights of Clenshaw-Curtis quadrature on [0, 1].
    pub(crate) weights: Vec<f64>,
    /// Barycentric weights, up to a common factor.
    barycentric: Vec<f64>,
    /// Differentiation matrix on [0, 1], row-major.
    derivative: Vec<f64>,
    /// Rows giving the last three Chebyshev coefficients (N-2, N-1, N).
    tail: [Vec<f64>; 3],
}

/// The nodes of a degree up to [`HIGHEST`] (of the highest degree for a larger one).
pub(crate) fn nodes(degree: usize) -> &'static Nodes {
    static TABLES: [OnceLock<Nodes>; HIGHEST + 1] = [const { OnceLock::new() }; HIGHEST + 1];
    let degree = degree.clamp(2, HIGHEST);
    TABLES[degree].get_or_init(|| Nodes::new(degree))
}

impl Nodes {
    fn new(degree: usize) -> Self {
        let n = degree;
        let angle = |j: usize| std::f64::consts::PI * j as f64 / n as f64;
        // sin² keeps the points symmetric and exact at both ends.
        let points: Vec<f64> = (0..=n).map(|j| (0.5 * angle(j)).sin().powi(2)).collect();
        let half = |j: usize| if j == 0 || j == n { 0.5 } else { 1.0 };
        let barycentric: Vec<f64> = (0..=n)
            .map(|j| half(j) * if j % 2 == 0 { 1.0 } else { -1.0 })
            .collect();
        // Coefficient k of the interpolant: (2/N) Σ'' f_j T_k(x_j), with x_j = -cos(πj/N), halved for k = 0 and k = N.
        let coefficient = |k: usize, j: usize| {
            let sign = if k.is_multiple_of(2) { 1.0 } else { -1.0 };
            2.0 / n as f64 * half(k) * half(j) * sign * (k as f64 * angle(j)).cos()
        };
        // ∫ T_k over [-1, 1] is 2/(1 - k²) for even k, zero for odd.
        let weights = (0..=n)
            .map(|j| {
                (0..=n)
                    .step_by(2)
                    .map(|k| coefficient(k, j) / (1.0 - (k * k) as f64))
                    .sum()
            })
            .collect();
        let mut derivative = vec![0.0; (n + 1) * (n + 1)];
        for i in 0..=n {
            let mut sum = 0.0;
            for j in 0..=n {
                if i != j {
                    let entry = barycentric[j] / barycentric[i] / (points[i] - points[j]);
                    derivative[i * (n + 1) + j] = entry;
                    sum += entry;
                }
            }
            // Rows sum to zero, as the derivative of a constant does.
            derivative[i * (n + 1) + i] = -sum;
        }
        let row = |k: usize| (0..=n).map(|j| coefficient(k, j)).collect();
        Self {
            degree,
            weights,
            barycentric,
            derivative,
            tail: [row(n - 2), row(n - 1), row(n)],
            points,
        }
    }

    /// Values at θ in [0, 1] of the polynomials through `values` (node-major: `columns` numbers per node), barycentric formula
    /// (J.-P. Berrut and L. N. Trefethen, 2004), stable on and between the points.
    pub(crate) fn interpolate(&self, values: &[f64], columns: usize, theta: f64, out: &mut [f64]) {
        let mut factors = [0.0; HIGHEST + 1];
        let mut sum = 0.0;
        for (j, (&point, &weight)) in self.points.iter().zip(&self.barycentric).enumerate() {
            let distance = theta - point;
            if distance == 0.0 {
                out[..columns].copy_from_slice(&values[j * columns..(j + 1) * columns]);
                return;
            }
            factors[j] = weight / distance;
            sum += factors[j];
        }
        let inverse = 1.0 / sum;
        out[..columns].fill(0.0);
        for (row, factor) in values.chunks_exact(columns).zip(&factors) {
            let factor = factor * inverse;
            for (out, value) in out.iter_mut().zip(row) {
                *out += factor * value;
            }
        }
    }

    /// Derivative with respect to θ at the points, of column `column`.
    pub(crate) fn slopes(&self, values: &[f64], columns: usize, column: usize) -> Vec<f64> {
        let m = self.degree + 1;
        (0..m)
            .map(|i| {
                (0..m)
                    .map(|j| self.derivative[i * m + j] * values[j * columns + column])
                    .sum()
            })
            .collect()
    }

    /// Sizes of the last three Chebyshev coefficients of a column.
    pub(crate) fn tail(&self, values: &[f64], columns: usize, column: usize) -> [f64; 3] {
        let mut tail = [0.0; 3];
        for (tail, row) in tail.iter_mut().zip(&self.tail) {
            let coefficient: f64 = row
                .iter()
                .enumerate()
                .map(|(j, factor)| factor * values[j * columns + column])
                .sum();
            *tail = coefficient.abs();
        }
        tail
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_are_exact() {
        // A polynomial of degree N is reproduced, differentiated and integrated to rounding.
        for degree in [2, 6, 8, 12] {
            let nodes = nodes(degree);
            let power = i32::try_from(degree).unwrap();
            let f = |x: f64| 1.0 - 2.0 * x + x.powi(power);
            let values: Vec<f64> = nodes.points.iter().map(|&x| f(x)).collect();
            let mut out = [0.0];
            for theta in [0.0, 0.1, 0.5, 0.77, 1.0] {
                nodes.interpolate(&values, 1, theta, &mut out);
                assert!((out[0] - f(theta)).abs() < 1e-14);
            }
            let integral: f64 = nodes.weights.iter().zip(&values).map(|(w, v)| w * v).sum();
            assert!((integral - 1.0 / (degree as f64 + 1.0)).abs() < 1e-15);
            for (slope, &x) in nodes.slopes(&values, 1, 0).iter().zip(&nodes.points) {
                let exact = -2.0 + degree as f64 * x.powi(power - 1);
                assert!((slope - exact).abs() < 1e-12, "{slope} {exact}");
            }
        }
        // T_12 on [0, 1] has the last coefficient one and no other.
        let nodes = nodes(12);
        let values: Vec<f64> = (0..=12)
            .map(|j| if j % 2 == 0 { 1.0 } else { -1.0 })
            .collect();
        let tail = nodes.tail(&values, 1, 0);
        assert!((tail[2] - 1.0).abs() < 1e-14 && tail[0] < 1e-14 && tail[1] < 1e-14);
    }
}
