//! The immittance route: admittances of given order as design variables.
//!
//! A search over layouts fixes the layout and varies values; this route varies the coefficients of Y(s) under the exact
//! condition that some device has it, and synthesises afterwards. [`ImmittanceOrder`] gives the condition as a constraint for
//! orders one to three; [`PassiveFunctions`] maps any real parameters onto positive-real functions of any order.

use crate::polynomial::{at, on_axis, product, sum, trimmed, value};
use crate::{RationalError, RationalFunction};

/// Orders with a closed condition; coefficients are in the order of papers, highest power first, numerator before
/// denominator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ImmittanceOrder {
    /// (A s + B)/(C s + D).
    Bilinear,
    /// (A s² + B s + C)/(D s² + E s + F).
    Biquadratic,
    /// (A s³ + B s² + C s + D)/(E s³ + F s² + G s + H).
    Bicubic,
}

impl ImmittanceOrder {
    /// Number of coefficients: four, six or eight.
    #[must_use]
    pub const fn coefficients(self) -> usize {
        2 * (self.order() + 1)
    }

    /// One, two or three.
    #[must_use]
    pub const fn order(self) -> usize {
        match self {
            Self::Bilinear => 1,
            Self::Biquadratic => 2,
            Self::Bicubic => 3,
        }
    }

    /// Y(s) of coefficients; missing ones are zero.
    ///
    /// # Errors
    /// Coefficients that are not finite, or a denominator zero.
    pub fn function(self, coefficients: &[f64]) -> Result<RationalFunction, RationalError> {
        let length = self.order() + 1;
        let part = |start: usize| -> Vec<f64> {
            (0..length)
                .rev()
                .map(|place| coefficients.get(start + place).copied().unwrap_or(0.0))
                .collect()
        };
        RationalFunction::new(part(0), part(length))
    }

    /// A number that is at least zero if and only if Y(s) is positive-real, for coefficients without a common factor of
    /// numerator and denominator in the right half-plane; between -1 and 1, for a search's constraint.
    ///
    /// Coefficients must be at least zero. Then a bilinear function is positive-real; a biquadratic one if
    /// B E ≥ (√(A F) - √(C D))² (Chen and Smith 2009); a bicubic one if (in powers a_i, d_i of s)
    /// (a1 + d1)(a2 + d2) ≥ (a0 + d0)(a3 + d3) and the cubic Re N(jω) D(-jω) in x = ω² is at least zero for x ≥ 0, at its
    /// minimum x* = (√(β2² - 3 β1 β3) - β2)/(3 β3) (the same condition as Chen and Smith 2009, theorem 13). Each is over the sum of its
    /// terms' magnitudes. NaN where the function is not defined.
    #[must_use]
    pub fn margin(self, coefficients: &[f64]) -> f64 {
        let Ok(function) = self.function(coefficients) else {
            return f64::NAN;
        };
        let unit = function.at_scales(function.scales());
        let all = || unit.numerator.iter().chain(&unit.denominator);
        let least = all().copied().fold(f64::INFINITY, f64::min);
        if least < 0.0 {
            return least;
        }
        let (p, q) = (&unit.numerator, &unit.denominator);
        match self {
            Self::Bilinear => 1.0,
            Self::Biquadratic => {
                let (be, af, cd) = (
                    at(p, 1) * at(q, 1),
                    at(p, 2) * at(q, 0),
                    at(p, 0) * at(q, 2),
                );
                let total = be + af + cd;
                if total == 0.0 {
                    return 0.0;
                }
                (be - (af.sqrt() - cd.sqrt()).powi(2)) / total
            }
            Self::Bicubic => {
                let together = sum(p, q);
                let (inner, outer) = (
                    at(&together, 1) * at(&together, 2),
                    at(&together, 0) * at(&together, 3),
                );
                let routh = if inner + outer > 0.0 {
                    (inner - outer) / (inner + outer)
                } else {
                    0.0
                };
                routh.min(cubic_margin(p, q))
            }
        }
    }

    /// Coefficients from numbers at least zero, every result being positive-real and every positive-real function of the
    /// order being reached; none for the bicubic order, which [`PassiveFunctions`] serves.
    ///
    /// Bilinear: the coefficients themselves. Biquadratic: (A, C, D, F, t, r) with B E = (√(A F) - √(C D))² + t and B/E = r.
    #[must_use]
    pub fn from_free(self, free: &[f64]) -> Option<Vec<f64>> {
        match (self, free) {
            (Self::Bilinear, [a, b, c, d]) => Some(vec![*a, *b, *c, *d]),
            (Self::Biquadratic, [a, c, d, f, t, r]) => {
                let be = ((a * f).sqrt() - (c * d).sqrt()).powi(2) + t;
                Some(vec![*a, (be * r).sqrt(), *c, *d, (be / r).sqrt(), *f])
            }
            _ => None,
        }
    }
}

/// The least of β(x) over its terms for x ≥ 0.
fn cubic_margin(p: &[f64], q: &[f64]) -> f64 {
    let (even_p, odd_p) = on_axis(p);
    let (even_q, odd_q) = on_axis(q);
    let odd = product(&product(&odd_p, &odd_q), &[0.0, 1.0]);
    let beta = sum(&product(&even_p, &even_q), &odd);
    let [b1, b2, b3] = [1, 2, 3].map(|power| at(&beta, power));
    let over_terms = |x: f64| {
        let terms = value(p, x.sqrt()) * value(q, x.sqrt());
        if terms > 0.0 {
            value(&beta, x) / terms
        } else {
            0.0
        }
    };
    let ends = over_terms(0.0).min(over_terms(1e12));
    let stationary = if b3 > 0.0 {
        let discriminant = b2.mul_add(b2, -3.0 * b1 * b3);
        (discriminant >= 0.0).then(|| {
            // Without cancellation for b2 > 0.
            if b2 > 0.0 {
                -b1 / (discriminant.sqrt() + b2)
            } else {
                (discriminant.sqrt() - b2) / (3.0 * b3)
            }
        })
    } else if b2 > 0.0 {
        Some(-b1 / (2.0 * b2))
    } else {
        None
    };
    match stationary {
        Some(x) if x > 0.0 => ends.min(over_terms(x)),
        _ => ends,
    }
}

/// Whether a biquadratic (A s² + B s + C)/(D s² + E s + F) that is positive-real is *regular*: the least of Re Y(jω) or of
/// Re 1/Y(jω) is at ω = 0 or ω = ∞ (Jiang and Smith 2011).
///
/// Series-parallel networks of two reactive elements realise exactly the regular ones, with at most five elements. In
/// closed form: Re Y(jω) ≥ Y(∞) for all ω if and only if C D ≥ A F and D (A F - C D + B E) ≥ A E²; Re Y(jω) ≥ Y(0) if and only if
/// A F ≥ C D and F (C D - A F + B E) ≥ C E²; and both with (A, B, C) and (D, E, F) exchanged.
#[must_use]
pub fn is_regular(coefficients: &[f64; 6]) -> bool {
    let one = |a: f64, b: f64, c: f64, d: f64, e: f64, f: f64| {
        let at_infinity = c * d >= a * f && d * (a * f - c * d + b * e) >= a * e * e;
        let at_zero = a * f >= c * d && f * (c * d - a * f + b * e) >= c * e * e;
        at_infinity || at_zero
    };
    let [a, b, c, d, e, f] = *coefficients;
    one(a, b, c, d, e, f) || one(d, e, f, a, b, c)
}

/// All positive-real functions of a number of states, and an inerter beside them, from real parameters without bounds.
///
/// Y(s) = b² s + S + (G + P)ᵀ (s 1 - J + R)⁻¹ (G - P), with J skew and tridiagonal, G = g e1 and
/// [R P; Pᵀ S] = L Lᵀ: the port-Hamiltonian form (van der Schaft and Jeltsema 2014), whose energy ½ xᵀx proves passivity for any parameters. By the
/// positive-real lemma every positive-real function has such a form; an orthogonal change of states brings J and G to theirs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PassiveFunctions {
    /// Number of states.
    pub states: usize,
}

impl PassiveFunctions {
    /// Number of parameters: b, g, the n - 1 entries of J, and the (n + 1)(n + 2)/2 of L, row by row.
    #[must_use]
    pub const fn parameters(self) -> usize {
        let n = self.states;
        2 + n.saturating_sub(1) + (n + 1) * (n + 2) / 2
    }

    /// Y(s) of parameters; missing ones are zero.
    #[must_use]
    pub fn function(self, parameters: &[f64]) -> RationalFunction {
        let n = self.states;
        let parameter = |place: usize| parameters.get(place).copied().unwrap_or(0.0);
        let start = 2 + n.saturating_sub(1);
        let lower = |row: usize, column: usize| {
            if column > row {
                0.0
            } else {
                parameter(start + row * (row + 1) / 2 + column)
            }
        };
        let dissipation =
            |i: usize, j: usize| -> f64 { (0..=n).map(|k| lower(i, k) * lower(j, k)).sum() };
        let skew = |i: usize, j: usize| {
            if j == i + 1 {
                parameter(2 + i)
            } else if i == j + 1 {
                -parameter(2 + j)
            } else {
                0.0
            }
        };
        let a: Vec<Vec<f64>> = (0..n)
            .map(|i| (0..n).map(|j| skew(i, j) - dissipation(i, j)).collect())
            .collect();
        let drive = |i: usize| if i == 0 { parameter(1) } else { 0.0 };
        let input: Vec<f64> = (0..n).map(|i| drive(i) - dissipation(i, n)).collect();
        let output: Vec<f64> = (0..n).map(|i| drive(i) + dissipation(i, n)).collect();
        // det(s 1 - A) and its adjugate (Faddeev and Le Verrier).
        let mut determinant = vec![0.0; n + 1];
        let mut strict = vec![0.0; n + 1];
        let mut adjugate = vec![vec![0.0; n]; n];
        let mut last = 1.0;
        if let Some(top) = determinant.last_mut() {
            *top = 1.0;
        }
        for k in 1..=n {
            let times = |m: &[Vec<f64>]| -> Vec<Vec<f64>> {
                a.iter()
                    .map(|row| {
                        (0..n)
                            .map(|j| {
                                row.iter()
                                    .zip(m)
                                    .map(|(x, other)| x * other.get(j).copied().unwrap_or(0.0))
                                    .sum()
                            })
                            .collect()
                    })
                    .collect()
            };
            adjugate = times(&adjugate);
            for (i, row) in adjugate.iter_mut().enumerate() {
                if let Some(entry) = row.get_mut(i) {
                    *entry += last;
                }
            }
            let coefficient: f64 = output
                .iter()
                .zip(&adjugate)
                .map(|(c, row)| c * row.iter().zip(&input).map(|(x, b)| x * b).sum::<f64>())
                .sum();
            let trace: f64 = times(&adjugate)
                .iter()
                .enumerate()
                .map(|(i, row)| row.get(i).copied().unwrap_or(0.0))
                .sum();
            last = -trace / k as f64;
            for (target, value) in [(&mut strict, coefficient), (&mut determinant, last)] {
                if let Some(entry) = target.get_mut(n - k) {
                    *entry = value;
                }
            }
        }
        let through = [dissipation(n, n), parameter(0) * parameter(0)];
        RationalFunction {
            numerator: trimmed(sum(&strict, &product(&through, &determinant))),
            denominator: determinant,
        }
    }
}
