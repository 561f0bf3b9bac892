//! Polynomials with real coefficients, lowest power first, and their roots.

use num_complex::Complex64;

/// Sweeps of the root finder; a dozen are enough but for roots of high multiplicity.
const SWEEPS: usize = 400;

/// Place of the highest coefficient that is not zero; zero for the polynomial zero.
pub(crate) fn degree(coefficients: &[f64]) -> usize {
    coefficients
        .iter()
        .rposition(|coefficient| *coefficient != 0.0)
        .unwrap_or(0)
}

/// Whether every coefficient is zero.
pub(crate) fn is_zero(coefficients: &[f64]) -> bool {
    coefficients.iter().all(|coefficient| *coefficient == 0.0)
}

/// Place of the lowest coefficient that is not zero.
pub(crate) fn lowest(coefficients: &[f64]) -> Option<usize> {
    coefficients
        .iter()
        .position(|coefficient| *coefficient != 0.0)
}

/// The coefficient of a power, zero beyond the highest.
pub(crate) fn at(coefficients: &[f64], power: usize) -> f64 {
    coefficients.get(power).copied().unwrap_or(0.0)
}

/// Without zeros above the highest coefficient; at least one coefficient is left.
pub(crate) fn trimmed(mut coefficients: Vec<f64>) -> Vec<f64> {
    coefficients.truncate(degree(&coefficients) + 1);
    if coefficients.is_empty() {
        coefficients.push(0.0);
    }
    coefficients
}

pub(crate) fn horner(coefficients: &[f64], s: Complex64) -> Complex64 {
    coefficients
        .iter()
        .rev()
        .fold(Complex64::ZERO, |sum, coefficient| sum * s + coefficient)
}

pub(crate) fn value(coefficients: &[f64], x: f64) -> f64 {
    coefficients
        .iter()
        .rev()
        .fold(0.0, |sum, coefficient| sum * x + coefficient)
}

/// Sum of the coefficients' magnitudes.
pub(crate) fn size(coefficients: &[f64]) -> f64 {
    coefficients.iter().map(|x| x.abs()).sum()
}

pub(crate) fn product(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut result = vec![0.0; (a.len() + b.len()).saturating_sub(1)];
    for (i, x) in a.iter().enumerate() {
        for (target, y) in result.iter_mut().skip(i).zip(b) {
            *target += x * y;
        }
    }
    result
}

/// a + factor b.
pub(crate) fn combined(a: &[f64], b: &[f64], factor: f64) -> Vec<f64> {
    (0..a.len().max(b.len()))
        .map(|i| factor.mul_add(at(b, i), at(a, i)))
        .collect()
}

pub(crate) fn sum(a: &[f64], b: &[f64]) -> Vec<f64> {
    combined(a, b, 1.0)
}

pub(crate) fn scaled(a: &[f64], factor: f64) -> Vec<f64> {
    a.iter().map(|x| x * factor).collect()
}

/// s^power times the polynomial.
pub(crate) fn shifted(a: &[f64], power: usize) -> Vec<f64> {
    let mut result = vec![0.0; power];
    result.extend_from_slice(a);
    result
}

pub(crate) fn derivative(a: &[f64]) -> Vec<f64> {
    let result: Vec<f64> = a
        .iter()
        .enumerate()
        .skip(1)
        .map(|(power, coefficient)| power as f64 * coefficient)
        .collect();
    if result.is_empty() { vec![0.0] } else { result }
}

/// Quotient and remainder; the divisor's highest coefficient must not be zero.
pub(crate) fn divided(dividend: &[f64], divisor: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let top = degree(divisor);
    let leading = at(divisor, top);
    let mut rest = trimmed(dividend.to_vec());
    if rest.len() <= top {
        return (vec![0.0], rest);
    }
    let mut quotient = vec![0.0; rest.len() - top];
    for (power, target) in quotient.iter_mut().enumerate().rev() {
        *target = at(&rest, power + top) / leading;
        for (entry, coefficient) in rest.iter_mut().skip(power).zip(divisor) {
            *entry -= *target * coefficient;
        }
    }
    rest.truncate(top.max(1));
    if top == 0 {
        rest = vec![0.0];
    }
    (quotient, rest)
}

/// Even and odd parts of a(jω) as polynomials in x = ω²: a(jω) = E(x) + jω O(x).
pub(crate) fn on_axis(a: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let part = |odd: usize| -> Vec<f64> {
        let part: Vec<f64> = a
            .iter()
            .skip(odd)
            .step_by(2)
            .enumerate()
            .map(|(i, coefficient)| {
                if i % 2 == 0 {
                    *coefficient
                } else {
                    -*coefficient
                }
            })
            .collect();
        if part.is_empty() { vec![0.0] } else { part }
    };
    (part(0), part(1))
}

/// Every root as often as its multiplicity (Aberth 1973; starts on Newton's polygon, Bini 1996).
///
/// A root of multiplicity m is found to about the m-th root of the rounding unit. No root for the polynomial zero.
pub(crate) fn roots(coefficients: &[f64]) -> Vec<Complex64> {
    let Some(low) = lowest(coefficients) else {
        return Vec::new();
    };
    let mut roots = vec![Complex64::ZERO; low];
    let rest = trimmed(coefficients.get(low..).unwrap_or_default().to_vec());
    match rest.as_slice() {
        [] | [_] => {}
        [a, b] => roots.push(Complex64::from(-a / b)),
        [a, b, c] => roots.extend(quadratic(*a, *b, *c)),
        _ => roots.extend(aberth(&rest)),
    }
    roots
}

fn quadratic(a: f64, b: f64, c: f64) -> [Complex64; 2] {
    // Scaled so that b² neither overflows nor underflows.
    let largest = a.abs().max(b.abs()).max(c.abs());
    let (a, b, c) = (a / largest, b / largest, c / largest);
    let discriminant = b.mul_add(b, -4.0 * a * c);
    if discriminant >= 0.0 {
        let sum = -0.5 * (b + discriminant.sqrt().copysign(b));
        if sum == 0.0 {
            return [Complex64::ZERO; 2];
        }
        [Complex64::from(sum / c), Complex64::from(a / sum)]
    } else {
        let root = Complex64::new(-b, (-discriminant).sqrt()) / (2.0 * c);
        [root, root.conj()]
    }
}

/// Moduli at which to start: slopes of the upper convex hull of log|a_i| over i.
fn moduli(coefficients: &[f64]) -> Vec<f64> {
    let points: Vec<(f64, f64)> = coefficients
        .iter()
        .enumerate()
        .filter(|(_, coefficient)| **coefficient != 0.0)
        .map(|(power, coefficient)| (power as f64, coefficient.abs().ln()))
        .collect();
    let mut hull: Vec<(f64, f64)> = Vec::new();
    for point in points {
        while let [.., before, last] = hull.as_slice() {
            let below = (last.1 - before.1) * (point.0 - before.0)
                <= (point.1 - before.1) * (last.0 - before.0);
            if !below {
                break;
            }
            hull.pop();
        }
        hull.push(point);
    }
    let mut result = Vec::new();
    for (from, to) in hull.iter().zip(hull.iter().skip(1)) {
        let width = to.0 - from.0;
        let modulus = ((from.1 - to.1) / width).exp();
        result.extend(std::iter::repeat_n(modulus, width as usize));
    }
    result
}

fn aberth(coefficients: &[f64]) -> Vec<Complex64> {
    let slope = derivative(coefficients);
    let magnitudes: Vec<f64> = coefficients.iter().map(|x| x.abs()).collect();
    let mut roots: Vec<Complex64> = moduli(coefficients)
        .into_iter()
        .enumerate()
        .map(|(place, modulus)| Complex64::from_polar(modulus, 2.4 * place as f64 + 0.7))
        .collect();
    for _ in 0..SWEEPS {
        let mut moving = false;
        for place in 0..roots.len() {
            let Some(z) = roots.get(place).copied() else {
                continue;
            };
            let function = horner(coefficients, z);
            // At the rounding of the value itself no step means anything.
            if function.norm() <= 2.0 * f64::EPSILON * value(&magnitudes, z.norm()) {
                continue;
            }
            let newton = function / horner(&slope, z);
            let repulsion: Complex64 = roots
                .iter()
                .enumerate()
                .filter(|(other, _)| *other != place)
                .map(|(_, other)| (z - other).inv())
                .filter(|term| term.is_finite())
                .sum();
            let step = newton / (Complex64::ONE - newton * repulsion);
            if !step.is_finite() {
                continue;
            }
            moving |= step.norm() > 1e-15 * z.norm();
            if let Some(root) = roots.get_mut(place) {
                *root = z - step;
            }
        }
        if !moving {
            break;
        }
    }
    roots
}

#[cfg(test)]
mod tests {
    use super::*;

    fn from_roots(roots: &[f64]) -> Vec<f64> {
        roots
            .iter()
            .fold(vec![1.0], |sum, root| product(&sum, &[-root, 1.0]))
    }

    #[test]
    fn roots_of_known_polynomials() {
        // Wilkinson's with ten roots: condition 1e7 or so, hence 1e-8.
        let known: Vec<f64> = (1..=10).map(f64::from).collect();
        let mut found: Vec<f64> = roots(&from_roots(&known)).iter().map(|z| z.re).collect();
        found.sort_by(f64::total_cmp);
        for (a, b) in found.iter().zip(&known) {
            assert!((a - b).abs() < 1e-8 * b, "{a} {b}");
        }
        // Far apart: each to a few roundings.
        let known = [-1e-6, -1.0, -1e5, -1e9];
        let mut found: Vec<f64> = roots(&from_roots(&known)).iter().map(|z| z.re).collect();
        found.sort_by(|a, b| b.total_cmp(a));
        for (a, b) in found.iter().zip(&known) {
            assert!((a - b).abs() < 1e-13 * b.abs(), "{a} {b}");
        }
        // A double root is found to the square root of the rounding unit.
        for root in roots(&from_roots(&[2.0, 2.0, -3.0])) {
            assert!((root - 2.0).norm().min((root + 3.0).norm()) < 1e-6);
        }
        // Unit roots.
        for root in roots(&[-1.0, 0.0, 0.0, 0.0, 0.0, 1.0]) {
            assert!((root.powi(5) - 1.0).norm() < 1e-14);
        }
        assert_eq!(
            roots(&[0.0, 0.0, 1.0, 1.0]),
            [0.0, 0.0, -1.0].map(Complex64::from)
        );
        assert!(roots(&[0.0]).is_empty());
    }

    #[test]
    fn division_undoes_multiplication() {
        let (a, b) = (vec![1.0, -2.0, 3.0, 0.5], vec![4.0, 0.0, 2.0]);
        let (quotient, rest) = divided(&sum(&product(&a, &b), &[7.0, 8.0]), &b);
        assert_eq!(quotient, a);
        assert_eq!(rest, [7.0, 8.0]);
        assert_eq!(divided(&[6.0, 4.0], &[2.0]), (vec![3.0, 2.0], vec![0.0]));
    }
}
