//! The algebra of rational functions: lowest terms, scales, distance.

use num_complex::Complex64;

use crate::RationalFunction;
use crate::linear::smallest_singular;
use crate::polynomial::{
    combined, degree, horner, is_zero, lowest, product, roots, scaled, size, trimmed,
};

/// Why coefficients are no rational function.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum RationalError {
    /// A coefficient is not finite.
    #[error("a coefficient is infinite or not a number")]
    NotFinite,
    /// Every coefficient of the denominator is zero.
    #[error("every coefficient of the denominator is zero")]
    ZeroDenominator,
}

/// The frequency ω0 and size Y0 at which a function is of order one: Y(s) = Y0 y(s/ω0).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scales {
    /// ω0 (rad/s).
    pub frequency: f64,
    /// Y0 (the unit of Y).
    pub size: f64,
}

/// Two coefficients that cancel leave this much of the largest one.
const ROUNDING: f64 = 1e-13;

impl RationalFunction {
    /// N(s)/D(s) from coefficients, lowest power first.
    ///
    /// # Errors
    /// A coefficient that is not finite, or a denominator zero.
    pub fn new(numerator: Vec<f64>, denominator: Vec<f64>) -> Result<Self, RationalError> {
        if !numerator
            .iter()
            .chain(&denominator)
            .all(|coefficient| coefficient.is_finite())
        {
            return Err(RationalError::NotFinite);
        }
        if is_zero(&denominator) {
            return Err(RationalError::ZeroDenominator);
        }
        Ok(Self {
            numerator: trimmed(numerator),
            denominator: trimmed(denominator),
        })
    }

    /// A constant.
    #[must_use]
    pub fn constant(value: f64) -> Self {
        Self {
            numerator: vec![value],
            denominator: vec![1.0],
        }
    }

    /// 1/Y: the impedance of an admittance, and the other way round.
    #[must_use]
    pub fn reciprocal(&self) -> Self {
        Self {
            numerator: self.denominator.clone(),
            denominator: self.numerator.clone(),
        }
    }

    /// Whether the function is zero.
    #[must_use]
    pub fn is_zero(&self) -> bool {
        is_zero(&self.numerator)
    }

    /// Y + factor X, over the product of both denominators.
    #[must_use]
    pub fn plus(&self, other: &Self, factor: f64) -> Self {
        let cross = combined(
            &product(&self.numerator, &other.denominator),
            &product(&other.numerator, &self.denominator),
            factor,
        );
        Self {
            numerator: trimmed(cross),
            denominator: trimmed(product(&self.denominator, &other.denominator)),
        }
    }

    /// factor · Y.
    #[must_use]
    pub fn times(&self, factor: f64) -> Self {
        Self {
            numerator: scaled(&self.numerator, factor),
            denominator: self.denominator.clone(),
        }
    }

    /// Y X.
    #[must_use]
    pub fn product(&self, other: &Self) -> Self {
        Self {
            numerator: trimmed(product(&self.numerator, &other.numerator)),
            denominator: trimmed(product(&self.denominator, &other.denominator)),
        }
    }

    /// Y(1/s).
    #[must_use]
    pub fn at_reciprocal(&self) -> Self {
        let top = self.degree();
        let reversed = |coefficients: &[f64]| {
            trimmed(
                (0..=top)
                    .map(|power| crate::polynomial::at(coefficients, top - power))
                    .collect(),
            )
        };
        Self {
            numerator: reversed(&self.numerator),
            denominator: reversed(&self.denominator),
        }
    }

    /// The frequency and size at which the function is of order one: ω0 is the geometric mean of the moduli of all
    /// zeros and poles that are neither zero nor infinite.
    #[must_use]
    pub fn scales(&self) -> Scales {
        let spread = |coefficients: &[f64]| {
            let (low, high) = (lowest(coefficients).unwrap_or(0), degree(coefficients));
            let ratio = crate::polynomial::at(coefficients, low).abs().ln()
                - crate::polynomial::at(coefficients, high).abs().ln();
            if high > low {
                (ratio, (high - low) as f64)
            } else {
                (0.0, 0.0)
            }
        };
        let (a, b) = (spread(&self.numerator), spread(&self.denominator));
        let count = a.1 + b.1;
        let frequency = if count > 0.0 {
            ((a.0 + b.0) / count).exp()
        } else {
            1.0
        };
        let weight = |coefficients: &[f64]| size(&stretched(coefficients, frequency));
        let size = weight(&self.numerator) / weight(&self.denominator);
        if frequency.is_normal() && size.is_normal() {
            Scales { frequency, size }
        } else {
            Scales {
                frequency: 1.0,
                size: 1.0,
            }
        }
    }

    /// y(s) = Y(ω0 s)/Y0, its coefficients of sum of magnitudes one in numerator and denominator.
    #[must_use]
    pub fn at_scales(&self, scales: Scales) -> Self {
        let numerator = stretched(&self.numerator, scales.frequency);
        let denominator = stretched(&self.denominator, scales.frequency);
        let weight = size(&denominator);
        Self {
            numerator: trimmed(scaled(&numerator, 1.0 / (weight * scales.size))),
            denominator: trimmed(scaled(&denominator, 1.0 / weight)),
        }
    }

    /// The function without common factors of N and D.
    ///
    /// A common factor is one that the smallest singular value of the Sylvester matrix reveals relative to the largest,
    /// with the function's coefficients at their own scales; `tolerance` around 1e-11 suits coefficients that carry
    /// rounding only.
    #[must_use]
    pub fn in_lowest_terms(&self, tolerance: f64) -> Self {
        let common = match (lowest(&self.numerator), lowest(&self.denominator)) {
            (Some(a), Some(b)) => a.min(b),
            (None, _) => return Self::constant(0.0),
            (_, None) => return self.clone(),
        };
        let cut =
            |coefficients: &[f64]| trimmed(coefficients.iter().skip(common).copied().collect());
        let reduced = Self {
            numerator: cut(&self.numerator),
            denominator: cut(&self.denominator),
        };
        let scales = reduced.scales();
        let unit = reduced.at_scales(scales);
        let top = unit.degree();
        for lower in 0..top {
            let mut columns = Vec::with_capacity(2 * lower + 2);
            for (coefficients, sign) in [(&unit.numerator, 1.0), (&unit.denominator, -1.0)] {
                for shift in 0..=lower {
                    let mut column = vec![0.0; top + lower + 1];
                    for (target, coefficient) in column.iter_mut().skip(shift).zip(coefficients) {
                        *target = sign * coefficient;
                    }
                    columns.push(column);
                }
            }
            let (vector, value) = smallest_singular(columns);
            if value > tolerance {
                continue;
            }
            // N q = D p: the vector holds q, then p.
            let (q, p) = vector.split_at((lower + 1).min(vector.len()));
            // Cancellation keeps the powers of s at both ends.
            let clean = |coefficients: &[f64], former: &[f64]| {
                let largest = coefficients
                    .iter()
                    .fold(0.0_f64, |most, x| most.max(x.abs()));
                let sign = if coefficients.iter().sum::<f64>() < 0.0 {
                    -1.0
                } else {
                    1.0
                };
                let low = lowest(former).unwrap_or(0);
                let high = (degree(former) + lower).saturating_sub(top);
                let kept = coefficients.iter().enumerate().map(|(power, x)| {
                    if power < low || power > high || x.abs() <= ROUNDING * largest {
                        0.0
                    } else {
                        sign * x
                    }
                });
                (trimmed(kept.collect()), sign)
            };
            let ((p, sign_p), (q, sign_q)) =
                (clean(p, &unit.numerator), clean(q, &unit.denominator));
            let unscaled = Self {
                numerator: scaled(&p, sign_p * sign_q),
                denominator: q,
            };
            let candidate = unscaled.at_former_scales(scales);
            if !is_zero(&candidate.denominator) && reduced.distance(&candidate) <= 100.0 * tolerance
            {
                return candidate;
            }
        }
        reduced
    }

    /// Y(s) = Y0 y(s/ω0) of a function at scales.
    #[must_use]
    pub(crate) fn at_former_scales(&self, scales: Scales) -> Self {
        Self {
            numerator: scaled(
                &stretched(&self.numerator, 1.0 / scales.frequency),
                scales.size,
            ),
            denominator: stretched(&self.denominator, 1.0 / scales.frequency),
        }
    }

    /// The largest chordal distance of two functions on the imaginary axis, between 0 (equal) and 1.
    ///
    /// χ = Y0 |N1 D2 - N2 D1| / (√(|N1|² + Y0² |D1|²) √(|N2|² + Y0² |D2|²)), with Y0 and ω0 of [`RationalFunction::scales`]:
    /// half the distance of Y1/Y0 and Y2/Y0 on Riemann's sphere, so that poles are as good as other points, and 1/Y1 and
    /// 1/Y2 are as far apart as Y1 and Y2. Taken at 0, ∞, 481 points over twelve decades around ω0, and at the moduli
    /// of all zeros and poles of both.
    #[must_use]
    pub fn distance(&self, other: &Self) -> f64 {
        let scales = self.scales();
        let (a, b) = (self.at_scales(scales), other.at_scales(scales));
        let chordal = |[n1, d1, n2, d2]: [Complex64; 4]| {
            let sizes = n1.norm().hypot(d1.norm()) * n2.norm().hypot(d2.norm());
            let cross = (n1 * d2 - n2 * d1).norm();
            if cross == 0.0 { 0.0 } else { cross / sizes }
        };
        // All four over the power that keeps them finite.
        let all = [&a.numerator, &a.denominator, &b.numerator, &b.denominator];
        let (top_a, top_b) = (a.degree(), b.degree());
        let at = |omega: f64| {
            let s = Complex64::new(0.0, omega);
            let (fa, fb) = (power(omega.max(1.0), top_a), power(omega.max(1.0), top_b));
            chordal([
                horner(all[0], s) / fa,
                horner(all[1], s) / fa,
                horner(all[2], s) / fb,
                horner(all[3], s) / fb,
            ])
        };
        let infinity = chordal([
            Complex64::from(crate::polynomial::at(all[0], top_a)),
            Complex64::from(crate::polynomial::at(all[1], top_a)),
            Complex64::from(crate::polynomial::at(all[2], top_b)),
            Complex64::from(crate::polynomial::at(all[3], top_b)),
        ]);
        let grid = (0..=480).map(|i| 10_f64.powf(-6.0 + f64::from(i) / 40.0));
        let special = all
            .into_iter()
            .flat_map(|coefficients| roots(coefficients))
            .map(Complex64::norm);
        grid.chain(special)
            .chain([0.0])
            .map(at)
            .fold(
                infinity,
                |most, x| if x > most || x.is_nan() { x } else { most },
            )
    }
}

/// base^exponent.
fn power(base: f64, exponent: usize) -> f64 {
    base.powi(i32::try_from(exponent).unwrap_or(i32::MAX))
}

/// Coefficients of p(factor · s).
fn stretched(coefficients: &[f64], factor: f64) -> Vec<f64> {
    coefficients
        .iter()
        .enumerate()
        .map(|(exponent, coefficient)| coefficient * power(factor, exponent))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn function(numerator: &[f64], denominator: &[f64]) -> RationalFunction {
        RationalFunction::new(numerator.to_vec(), denominator.to_vec()).unwrap()
    }

    #[test]
    fn common_factors_go() {
        // (s + 2)(s² + s + 3) over (s + 2)(s + 5), also where s is in units of 1e4.
        for unit in [1.0, 1e-4] {
            let common = [2.0, unit];
            let full = function(
                &product(&common, &[3.0, unit, unit * unit]),
                &product(&common, &[5.0, unit]),
            );
            let reduced = full.in_lowest_terms(1e-11);
            assert_eq!(reduced.degrees(), (2, 1));
            assert!(full.distance(&reduced) < 1e-13);
        }
        let coprime = function(&[1.0, 1.0, 1.0], &[4.0, 1.0, 1.0]);
        assert_eq!(coprime.in_lowest_terms(1e-11), coprime);
        assert_eq!(
            function(&[0.0, 2.0], &[0.0, 0.0, 4.0]).in_lowest_terms(1e-11),
            function(&[2.0], &[0.0, 4.0])
        );
        // A whole numerator in common.
        let whole = function(&[1.0, 2.0, 3.0], &[2.0, 4.0, 6.0]).in_lowest_terms(1e-11);
        assert_eq!(whole.degree(), 0);
        assert!((whole.numerator[0] / whole.denominator[0] - 0.5).abs() < 1e-13);
    }

    #[test]
    fn distance_sees_poles_and_scale() {
        let y = function(&[3e8, 1e3, 1.0], &[2e7, 1e4, 3.0]);
        assert!(y.distance(&y.times(1.0 + 1e-9)) < 1e-9);
        assert!(y.distance(&y.times(1.0 + 1e-9)) > 1e-10);
        assert!(
            (y.distance(&y.times(1.01)) - y.reciprocal().distance(&y.times(1.01).reciprocal()))
                .abs()
                < 1e-4
        );
        assert_eq!(y.distance(&y), 0.0);
    }

    #[test]
    fn wrong_coefficients_are_refused() {
        assert_eq!(
            RationalFunction::new(vec![1.0], vec![0.0]),
            Err(RationalError::ZeroDenominator)
        );
        assert_eq!(
            RationalFunction::new(vec![f64::NAN], vec![1.0]),
            Err(RationalError::NotFinite)
        );
    }
}
