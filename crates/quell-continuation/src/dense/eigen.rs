//! Eigenvalues of small real matrices: balancing, Hessenberg form, Francis' double shift
//! (Golub and Van Loan, Matrix Computations, 4th ed. 2013, algorithms 7.4.2 and 7.5.1).

use num_complex::Complex64;

use super::lu::Lu;

/// Eigenvalues with the derivative of each along a branch.
#[derive(Clone, Debug, Default)]
pub(crate) struct Spectrum {
    /// The eigenvalues or multipliers.
    pub(crate) values: Vec<Complex64>,
    /// Their derivatives by arclength; NaN where unknown.
    pub(crate) rates: Vec<Complex64>,
    /// Error bar of multipliers.
    pub(crate) error: f64,
}

/// Scales rows and columns by powers of two so that their norms agree (Parlett and Reinsch 1969).
fn balance(n: usize, a: &mut [f64]) {
    let mut again = true;
    let mut rounds = 0;
    while again && rounds < 40 {
        again = false;
        rounds += 1;
        for i in 0..n {
            let mut column = 0.0;
            let mut row = 0.0;
            for j in 0..n {
                if j != i {
                    column += a[j * n + i].abs();
                    row += a[i * n + j].abs();
                }
            }
            if column == 0.0 || row == 0.0 {
                continue;
            }
            let sum = column + row;
            let mut f = 1.0;
            while column < row / 2.0 {
                f *= 2.0;
                column *= 4.0;
            }
            while column > row * 2.0 {
                f /= 2.0;
                column /= 4.0;
            }
            if (column + row) / f < 0.95 * sum {
                again = true;
                for j in 0..n {
                    a[i * n + j] /= f;
                }
                for j in 0..n {
                    a[j * n + i] *= f;
                }
            }
        }
    }
}

/// Reduces to upper Hessenberg form by Gaussian similarity with pivoting (stable enough for eigenvalues alone).
fn hessenberg(n: usize, a: &mut [f64]) {
    for m in 1..n.saturating_sub(1) {
        let mut pivot = m;
        let mut x = 0.0_f64;
        for j in m..n {
            if a[j * n + m - 1].abs() > x.abs() {
                x = a[j * n + m - 1];
                pivot = j;
            }
        }
        if pivot != m {
            for j in m - 1..n {
                a.swap(pivot * n + j, m * n + j);
            }
            for i in 0..n {
                a.swap(i * n + pivot, i * n + m);
            }
        }
        if x != 0.0 {
            for i in m + 1..n {
                let mut y = a[i * n + m - 1];
                if y != 0.0 {
                    y /= x;
                    a[i * n + m - 1] = 0.0;
                    for j in m..n {
                        a[i * n + j] -= y * a[m * n + j];
                    }
                    for j in 0..n {
                        a[j * n + m] += y * a[j * n + i];
                    }
                }
            }
        }
    }
}

/// Applies I - β v vᵀ to three (or two) consecutive rows and columns.
fn reflector(x: f64, y: f64, z: f64) -> Option<([f64; 3], f64)> {
    let size = x.abs() + y.abs() + z.abs();
    if size == 0.0 {
        return None;
    }
    let (x, y, z) = (x / size, y / size, z / size);
    let alpha = -(x * x + y * y + z * z).sqrt().copysign(x);
    let v0 = x - alpha;
    let norm2 = v0 * v0 + y * y + z * z;
    if norm2 == 0.0 {
        return None;
    }
    Some(([v0, y, z], 2.0 / norm2))
}

/// Eigenvalues of a row-major n × n matrix, or None where an entry is not finite or the iteration fails.
pub(crate) fn eigenvalues(n: usize, matrix: &[f64]) -> Option<Vec<Complex64>> {
    if matrix.iter().any(|x| !x.is_finite()) {
        return None;
    }
    let mut a = matrix.to_vec();
    balance(n, &mut a);
    hessenberg(n, &mut a);
    let mut out = vec![Complex64::default(); n];
    let mut high = n;
    let mut iterations = 0;
    let scale = a
        .iter()
        .fold(0.0_f64, |m, x| m.max(x.abs()))
        .max(f64::MIN_POSITIVE);
    while high > 0 {
        let last = high - 1;
        let mut low = last;
        while low > 0 {
            let mut s = a[(low - 1) * n + low - 1].abs() + a[low * n + low].abs();
            if s == 0.0 {
                s = scale;
            }
            if a[low * n + low - 1].abs() <= f64::EPSILON * s {
                a[low * n + low - 1] = 0.0;
                break;
            }
            low -= 1;
        }
        if low == last {
            out[last] = Complex64::new(a[last * n + last], 0.0);
            high -= 1;
            iterations = 0;
            continue;
        }
        let (p, q, r, t) = (
            a[(last - 1) * n + last - 1],
            a[(last - 1) * n + last],
            a[last * n + last - 1],
            a[last * n + last],
        );
        if low + 1 == last {
            let (one, two) = pair(p, q, r, t);
            out[last - 1] = one;
            out[last] = two;
            high -= 2;
            iterations = 0;
            continue;
        }
        iterations += 1;
        if iterations > 60 {
            return None;
        }
        let (mut sum, mut product) = (p + t, p * t - q * r);
        if iterations % 10 == 0 {
            let s = a[last * n + last - 1].abs() + a[(last - 1) * n + last - 2].abs();
            sum = 1.5 * s;
            product = s * s;
        }
        let h = |i: usize, j: usize| a[(low + i) * n + low + j];
        let mut x = h(0, 0) * h(0, 0) + h(0, 1) * h(1, 0) - sum * h(0, 0) + product;
        let mut y = h(1, 0) * (h(0, 0) + h(1, 1) - sum);
        let mut z = h(1, 0) * h(2, 1);
        for k in low..last {
            let three = k + 2 <= last;
            if let Some((v, beta)) = reflector(x, y, if three { z } else { 0.0 }) {
                let rows = if three { 3 } else { 2 };
                let from = if k > low { k - 1 } else { low };
                for j in from..high {
                    let mut s = 0.0;
                    for i in 0..rows {
                        s += v[i] * a[(k + i) * n + j];
                    }
                    s *= beta;
                    for i in 0..rows {
                        a[(k + i) * n + j] -= s * v[i];
                    }
                }
                let to = (k + 4).min(high);
                for i in low..to {
                    let mut s = 0.0;
                    for j in 0..rows {
                        s += v[j] * a[i * n + k + j];
                    }
                    s *= beta;
                    for j in 0..rows {
                        a[i * n + k + j] -= s * v[j];
                    }
                }
                if k > low {
                    a[(k + 1) * n + k - 1] = 0.0;
                    if three {
                        a[(k + 2) * n + k - 1] = 0.0;
                    }
                }
            }
            if k < last {
                x = a[(k + 1) * n + k];
                y = if k + 2 <= last {
                    a[(k + 2) * n + k]
                } else {
                    0.0
                };
                z = if k + 3 <= last {
                    a[(k + 3) * n + k]
                } else {
                    0.0
                };
            }
            if k + 2 > last {
                break;
            }
        }
    }
    Some(out)
}

/// Eigenvalues of [p q; r t], without cancellation.
fn pair(p: f64, q: f64, r: f64, t: f64) -> (Complex64, Complex64) {
    let half = 0.5 * (p - t);
    let disc = half * half + q * r;
    let mean = 0.5 * (p + t);
    if disc >= 0.0 {
        let root = disc.sqrt();
        let w = half + root.copysign(half);
        // t + w and t - q r / w; the second avoids cancellation.
        let one = t + w;
        let two = if w == 0.0 { t } else { t - q * r / w };
        (Complex64::new(one, 0.0), Complex64::new(two, 0.0))
    } else {
        let root = (-disc).sqrt();
        (Complex64::new(mean, root), Complex64::new(mean, -root))
    }
}

fn shifted(n: usize, a: &[f64], value: Complex64) -> Lu<Complex64> {
    let size = a
        .iter()
        .fold(value.norm(), |m, x| m.max(x.abs()))
        .max(1e-100);
    // A shift at rounding level keeps the factorisation from an exact zero pivot.
    let value = value + Complex64::new(size * 4e-16, size * 2e-16);
    let matrix: Vec<Complex64> = (0..n * n)
        .map(|k| {
            Complex64::new(a[k], 0.0)
                - if k / n == k % n {
                    value
                } else {
                    Complex64::default()
                }
        })
        .collect();
    Lu::of(n, &matrix)
}

fn inverse_iteration(n: usize, step: impl Fn(&mut [Complex64])) -> Vec<Complex64> {
    let mut x: Vec<Complex64> = (0..n)
        .map(|i| Complex64::new(1.0 + 0.37 * (i as f64).sin(), 0.21 * (1.0 + i as f64).cos()))
        .collect();
    for _ in 0..3 {
        step(&mut x);
        let size = x.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt();
        if !(size.is_finite() && size > 0.0) {
            break;
        }
        for x in &mut x {
            *x /= size;
        }
    }
    // The phase is fixed by the largest entry, so that results do not depend on rounding.
    let mut best = Complex64::default();
    for x in &x {
        if x.norm() > best.norm() * (1.0 + 1e-6) {
            best = *x;
        }
    }
    if best.norm() > 0.0 {
        let phase = best.conj() / best.norm();
        for x in &mut x {
            *x *= phase;
        }
    }
    x
}

/// q with A q = λ q and |q| = 1, its largest entry real and positive.
pub(crate) fn eigenvector(n: usize, a: &[f64], value: Complex64) -> Vec<Complex64> {
    let lu = shifted(n, a, value);
    inverse_iteration(n, |x| lu.solve(x))
}

/// w with wᵀ A = λ wᵀ (not conjugated) and |w| = 1.
pub(crate) fn left_eigenvector(n: usize, a: &[f64], value: Complex64) -> Vec<Complex64> {
    let lu = shifted(n, a, value);
    inverse_iteration(n, |x| lu.solve_transposed(x))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn companion_matrices_return_their_roots() {
        let roots = [
            Complex64::new(-1.0, 2.0),
            Complex64::new(-1.0, -2.0),
            Complex64::new(0.3, 0.0),
            Complex64::new(-4.0, 0.0),
            Complex64::new(0.1, 7.0),
            Complex64::new(0.1, -7.0),
            Complex64::new(1e-3, 0.0),
        ];
        let mut c = vec![Complex64::new(1.0, 0.0)];
        for r in roots {
            let mut next = vec![Complex64::default(); c.len() + 1];
            for (i, x) in c.iter().enumerate() {
                next[i + 1] += *x;
                next[i] -= r * *x;
            }
            c = next;
        }
        let n = roots.len();
        let mut a = vec![0.0; n * n];
        for i in 0..n {
            a[i * n + n - 1] = -c[i].re;
            if i > 0 {
                a[i * n + i - 1] = 1.0;
            }
        }
        let found = eigenvalues(n, &a).unwrap();
        for r in roots {
            let gap = found
                .iter()
                .map(|x| (x - r).norm())
                .fold(f64::INFINITY, f64::min);
            assert!(gap < 1e-10, "{r}: {gap} in {found:?}");
        }
        for r in roots {
            let q = eigenvector(n, &a, r);
            let w = left_eigenvector(n, &a, r);
            for i in 0..n {
                let image: Complex64 = (0..n).map(|j| q[j] * a[i * n + j]).sum();
                assert!((image - r * q[i]).norm() < 1e-9);
                let image: Complex64 = (0..n).map(|j| w[j] * a[j * n + i]).sum();
                assert!((image - r * w[i]).norm() < 1e-9);
            }
        }
    }

    #[test]
    fn random_matrices_keep_trace_and_determinant() {
        let mut seed = 7_u64;
        for n in 1..24 {
            let a: Vec<f64> = (0..n * n)
                .map(|_| {
                    seed = seed
                        .wrapping_mul(6_364_136_223_846_793_005)
                        .wrapping_add(1_442_695_040_888_963_407);
                    (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
                })
                .collect();
            let found = eigenvalues(n, &a).unwrap();
            let trace: f64 = (0..n).map(|i| a[i * n + i]).sum();
            let sum: Complex64 = found.iter().sum();
            assert!((sum.re - trace).abs() < 1e-12 * n as f64 && sum.im.abs() < 1e-12);
            let log: f64 = found.iter().map(|x| x.norm().ln()).sum();
            assert!((log - Lu::of(n, &a).log_determinant()).abs() < 1e-9);
        }
    }
}
