//! Whether a rational function is the admittance of a passive device, and where it fails.
//!
//! Y = N/D in lowest terms is positive-real if and only if N + D has no zero in Re s ≥ 0 and Re N(jω) D(-jω) ≥ 0 for
//! every ω (Weinberg and Slepian 1960; Chen and Smith 2009). This form has no special cases: poles and zeros on the
//! imaginary axis, at zero and at infinity need no residues, and minimum functions touch zero where a polynomial in ω²
//! touches zero.

use std::fmt;

use num_complex::Complex64;

use crate::RationalFunction;
use crate::polynomial::{
    at, combined, degree, derivative, horner, on_axis, product, roots, scaled, size, sum, value,
};

/// Rounding that the test forgives, relative to the terms that are summed.
pub const POSITIVE_REAL_TOLERANCE: f64 = 1e-10;

/// Roots this close to the imaginary axis, relative to their modulus, are taken to be on it.
pub(crate) const AXIS: f64 = 1e-7;

/// One reason why a function is not positive-real.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Violation {
    /// A pole in the open right half-plane.
    UnstablePole {
        /// The pole (rad/s); its real part says how far.
        pole: Complex64,
    },
    /// A multiple pole on the imaginary axis.
    MultiplePole {
        /// Its angular frequency, infinite for the pole at infinity.
        omega: f64,
        /// How often.
        multiplicity: usize,
    },
    /// A simple pole on the imaginary axis whose residue is not real and positive.
    Residue {
        /// Its angular frequency, infinite for the pole at infinity.
        omega: f64,
        /// lim (s - jω) Y(s), or lim Y(s)/s at infinity.
        residue: Complex64,
    },
    /// The real part on the axis is negative.
    RealPart {
        /// Where it is least (rad/s); infinite for the limit.
        omega: f64,
        /// Re Y(jω) there (the unit of Y).
        real_part: f64,
        /// The band around it in which Re Y(jω) < 0 (rad/s).
        band: (f64, f64),
    },
    /// The function is not defined: a coefficient is not finite, or the denominator is zero.
    Undefined,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = |omega: f64| {
            if omega.is_infinite() {
                "infinity".to_owned()
            } else {
                format!("ω = {omega:.6} rad/s")
            }
        };
        match self {
            Self::UnstablePole { pole } if pole.im == 0.0 => {
                write!(f, "it has the unstable pole s = {:.6}", pole.re)
            }
            Self::UnstablePole { pole } => write!(
                f,
                "it has the unstable poles s = {:.6} ± {:.6}j",
                pole.re,
                pole.im.abs()
            ),
            Self::MultiplePole {
                omega,
                multiplicity,
            } => write!(
                f,
                "its pole at {} is {multiplicity}-fold, where only simple poles are passive",
                place(*omega)
            ),
            Self::Residue { omega, residue } => write!(
                f,
                "the residue of its pole at {} is {residue:.6}, which must be real and positive",
                place(*omega)
            ),
            Self::RealPart {
                omega,
                real_part,
                band,
            } => write!(
                f,
                "its real part is negative between {:.6} and {:.6} rad/s, least ({real_part:.6e}) at {}",
                band.0,
                band.1,
                place(*omega)
            ),
            Self::Undefined => f.write_str("it is not defined by its coefficients"),
        }
    }
}

/// What the test of positive-realness found.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// Why the function is not positive-real; empty if it is.
    pub violations: Vec<Violation>,
    /// The least Re Y(jω) over all ω that are no poles (the unit of Y); zero for minimum functions.
    pub least_real_part: f64,
    /// Where it is (rad/s); infinite for the limit.
    pub at: f64,
}

impl Verdict {
    /// Whether the function is positive-real.
    #[must_use]
    pub fn is_positive_real(&self) -> bool {
        self.violations.is_empty()
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.violations.is_empty() {
            write!(
                f,
                "positive-real; least real part {:.6e} ",
                self.least_real_part
            )?;
            return if self.at.is_finite() {
                write!(f, "at ω = {:.6} rad/s", self.at)
            } else {
                f.write_str("as ω grows without bound")
            };
        }
        f.write_str("not positive-real: ")?;
        for (place, violation) in self.violations.iter().enumerate() {
            if place > 0 {
                f.write_str("; ")?;
            }
            write!(f, "{violation}")?;
        }
        Ok(())
    }
}

/// Re Y(jω) = N(x)/D(x) with x = ω², of a function at unit scales.
pub(crate) struct RealPart {
    /// Re p(jω) q(-jω).
    pub(crate) numerator: Vec<f64>,
    /// |q(jω)|².
    pub(crate) denominator: Vec<f64>,
}

impl RealPart {
    pub(crate) fn of(function: &RationalFunction) -> Self {
        let (p, q) = (on_axis(&function.numerator), on_axis(&function.denominator));
        let cross = |a: &(Vec<f64>, Vec<f64>), b: &(Vec<f64>, Vec<f64>)| {
            let odd = product(&product(&a.1, &b.1), &[0.0, 1.0]);
            sum(&product(&a.0, &b.0), &odd)
        };
        Self {
            numerator: cross(&p, &q),
            denominator: cross(&q, &q),
        }
    }

    /// x where the real part may be least, beside 0 and infinity: real parts of the zeros of N' D - N D'.
    fn stationary(&self) -> Vec<f64> {
        let slope = combined(
            &product(&derivative(&self.numerator), &self.denominator),
            &product(&self.numerator, &derivative(&self.denominator)),
            -1.0,
        );
        let mut slope = slope;
        // The two highest terms cancel where N and D have one degree.
        let noise = 1e-15 * size(&product(&self.numerator, &self.denominator));
        while slope.len() > 1 && slope.last().is_some_and(|last| last.abs() <= noise) {
            slope.pop();
        }
        roots(&slope)
            .into_iter()
            .map(|root| root.re)
            .filter(|x| *x > 0.0)
            .collect()
    }

    /// The limit at infinity.
    fn at_infinity(&self, function: &RationalFunction) -> f64 {
        let (p, q) = function.degrees();
        if p > q + 1 {
            return f64::INFINITY;
        }
        let top = q;
        let (n, d) = (at(&self.numerator, top), at(&self.denominator, top));
        if d == 0.0 { 0.0 } else { n / d }
    }

    /// (ω, Re Y) where the real part is least, away from the given poles on the axis.
    pub(crate) fn least(&self, function: &RationalFunction, poles: &[f64]) -> (f64, f64) {
        let limit = self.at_infinity(function);
        let mut best = (f64::INFINITY, limit);
        let interior = self.stationary().into_iter().chain([0.0]).filter(|x| {
            !poles
                .iter()
                .any(|pole| (x.sqrt() - pole).abs() <= 1e-5 * pole.max(1e-9))
        });
        for x in interior {
            let denominator = value(&self.denominator, x);
            if denominator <= 0.0 {
                continue;
            }
            let real_part = value(&self.numerator, x) / denominator;
            // Interior points must be clearly lower than the limits, so that flat functions report those.
            let margin = if x == 0.0 { 0.0 } else { 1e-13 };
            if real_part < best.1 - margin * best.1.abs() {
                best = (x.sqrt(), real_part);
            }
        }
        best
    }
}

/// Poles on the imaginary axis of a function at unit scales: those at jω with ω ≥ 0, each with its multiplicity, and the
/// poles in the open right half-plane.
pub(crate) fn axis_poles(denominator: &[f64]) -> (Vec<(f64, usize)>, Vec<Complex64>) {
    let mut on_axis: Vec<(f64, usize)> = Vec::new();
    let mut unstable = Vec::new();
    for root in roots(denominator) {
        if root.im < -AXIS * root.norm() {
            continue;
        }
        if root.re.abs() <= AXIS * root.norm() {
            let omega = root.norm();
            match on_axis
                .iter_mut()
                .find(|(known, _)| (known - omega).abs() <= 10.0 * AXIS * omega)
            {
                Some((_, multiplicity)) => *multiplicity += 1,
                None => on_axis.push((omega, 1)),
            }
        } else if root.re > 0.0 {
            unstable.push(root);
        }
    }
    (on_axis, unstable)
}

impl RationalFunction {
    /// Whether the function is positive-real, and where and by how much it fails otherwise.
    ///
    /// `tolerance` is the rounding forgiven relative to the terms that are summed in Re N(jω) D(-jω);
    /// [`POSITIVE_REAL_TOLERANCE`] suits coefficients of full precision. Common factors of N and D are removed first.
    #[must_use]
    pub fn positive_real(&self, tolerance: f64) -> Verdict {
        let undefined = Verdict {
            violations: vec![Violation::Undefined],
            least_real_part: f64::NAN,
            at: f64::NAN,
        };
        let Ok(function) = Self::new(self.numerator.clone(), self.denominator.clone()) else {
            return undefined;
        };
        if function.is_zero() {
            return Verdict {
                violations: Vec::new(),
                least_real_part: 0.0,
                at: 0.0,
            };
        }
        // A common factor elsewhere than in the right half-plane does no harm, and finding it rounds.
        let passes = |function: &Self| {
            let unit = function.at_scales(function.scales());
            hurwitz_sum(&unit, tolerance)
                && nonnegative(&RealPart::of(&unit).numerator, &unit, tolerance)
        };
        let passed = passes(&function);
        // What is reported must not see near-common factors on the axis as 0/0.
        let reduced = function.in_lowest_terms(if passed { 1e-9 } else { 1e-12 });
        let scales = reduced.scales();
        let unit = reduced.at_scales(scales);
        let real = RealPart::of(&unit);
        let (axis, unstable) = axis_poles(&unit.denominator);
        let mut poles: Vec<f64> = axis.iter().map(|(omega, _)| *omega).collect();
        let (p, q) = unit.degrees();
        if p > q {
            poles.push(f64::INFINITY);
        }
        let (omega, least) = real.least(&unit, &poles);
        let mut verdict = Verdict {
            violations: Vec::new(),
            least_real_part: least * scales.size,
            at: omega * scales.frequency,
        };
        if passed || passes(&reduced) {
            verdict.least_real_part = verdict.least_real_part.max(0.0);
            return verdict;
        }
        let to_hertz = scales.frequency;
        for pole in unstable {
            verdict.violations.push(Violation::UnstablePole {
                pole: pole * to_hertz,
            });
        }
        if p > q + 1 {
            verdict.violations.push(Violation::MultiplePole {
                omega: f64::INFINITY,
                multiplicity: p - q,
            });
        } else if p == q + 1 {
            let residue = at(&unit.numerator, p) / at(&unit.denominator, q);
            if residue < 0.0 {
                verdict.violations.push(Violation::Residue {
                    omega: f64::INFINITY,
                    residue: Complex64::from(residue * scales.size / scales.frequency),
                });
            }
        }
        for (omega, multiplicity) in axis {
            if multiplicity > 1 {
                verdict.violations.push(Violation::MultiplePole {
                    omega: omega * scales.frequency,
                    multiplicity,
                });
                continue;
            }
            let s = Complex64::new(0.0, omega);
            let residue = horner(&unit.numerator, s) / horner(&derivative(&unit.denominator), s);
            if residue.re < 0.0 || residue.im.abs() > 1e-7 * residue.norm() {
                verdict.violations.push(Violation::Residue {
                    omega: omega * scales.frequency,
                    residue: residue * scales.size * scales.frequency,
                });
            }
        }
        if least < 0.0 || verdict.violations.is_empty() {
            let band = negative_band(&real.numerator, omega);
            verdict.violations.push(Violation::RealPart {
                omega: verdict.at,
                real_part: verdict.least_real_part,
                band: (band.0 * scales.frequency, band.1 * scales.frequency),
            });
        }
        verdict
    }
}

/// Whether N + D has no zero to the right of the axis.
fn hurwitz_sum(unit: &RationalFunction, tolerance: f64) -> bool {
    let together = sum(&unit.numerator, &unit.denominator);
    // Y = -1 leaves nothing, or rounding.
    let scale = size(&unit.numerator) + size(&unit.denominator);
    if size(&together) <= 1e-14 * scale {
        return false;
    }
    roots(&together)
        .iter()
        .all(|root| root.re <= tolerance.max(1e-9) * root.norm())
}

/// Whether E(x) ≥ 0 for x ≥ 0, up to rounding of the terms of p(jω) q(-jω).
fn nonnegative(polynomial: &[f64], unit: &RationalFunction, tolerance: f64) -> bool {
    let magnitudes =
        |coefficients: &[f64]| coefficients.iter().map(|c| c.abs()).collect::<Vec<f64>>();
    let (p, q) = (magnitudes(&unit.numerator), magnitudes(&unit.denominator));
    let rounding = |x: f64| tolerance * value(&p, x.sqrt()) * value(&q, x.sqrt());
    let top = polynomial.len().saturating_sub(1);
    let all = product(&p, &q);
    if at(polynomial, top) < -tolerance * at(&all, 2 * top) {
        return false;
    }
    // Below rounding a leading term says nothing, but it would rule the value far out.
    let reach = 1e8;
    let stationary = roots(&derivative(polynomial))
        .into_iter()
        .map(|root| root.re)
        .filter(|x| *x > 0.0 && *x < reach * reach);
    stationary
        .chain([0.0])
        .all(|x| value(polynomial, x) >= -rounding(x))
}

/// The interval around ω in which E(ω²) < 0.
fn negative_band(polynomial: &[f64], omega: f64) -> (f64, f64) {
    let mut band = (0.0, f64::INFINITY);
    for root in roots(polynomial) {
        if root.re <= 0.0 || root.im.abs() > 1e-6 * root.norm() {
            continue;
        }
        let edge = root.re.sqrt();
        if edge <= omega && edge > band.0 {
            band.0 = edge;
        }
        if edge >= omega && edge < band.1 {
            band.1 = edge;
        }
    }
    band
}

/// The nearest positive-real function, and how far it is.
#[derive(Debug, Clone, PartialEq)]
pub struct Nearest {
    /// A positive-real function.
    pub function: RationalFunction,
    /// sup over ω of |Y(jω) - X(jω)| (the unit of Y).
    pub distance: f64,
    /// No positive-real function is nearer than this in the same norm.
    pub bound: f64,
}

/// Why no positive-real function is near.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NearestError {
    /// A pole on the axis that no passive device has: every positive-real function is infinitely far.
    #[error("no positive-real function is at a finite distance: {0}")]
    AxisPole(Violation),
    /// The function is not defined.
    #[error("the function is not defined by its coefficients")]
    Undefined,
}

impl RationalFunction {
    /// The nearest positive-real function X in the norm sup over ω of |Y(jω) - X(jω)|.
    ///
    /// Of a function with stable poles it is Y + c with c = -min Re Y(jω): Re X ≥ 0 forces |Y - X| ≥ -Re Y at every
    /// frequency, so that no other is nearer, and `bound` equals `distance`. Unstable poles are first mirrored in the
    /// imaginary axis; then X is a positive-real function, and `bound` says how much nearer another might be.
    ///
    /// # Errors
    /// A multiple pole on the axis, or one whose residue is not real and positive.
    pub fn nearest_positive_real(&self, tolerance: f64) -> Result<Nearest, NearestError> {
        let verdict = self.positive_real(tolerance);
        if verdict.is_positive_real() {
            return Ok(Nearest {
                function: self.clone(),
                distance: 0.0,
                bound: 0.0,
            });
        }
        for violation in &verdict.violations {
            match violation {
                Violation::Undefined => return Err(NearestError::Undefined),
                Violation::MultiplePole { .. } | Violation::Residue { .. } => {
                    return Err(NearestError::AxisPole(*violation));
                }
                Violation::UnstablePole { .. } | Violation::RealPart { .. } => {}
            }
        }
        let bound = (-verdict.least_real_part).max(0.0);
        let unstable = verdict
            .violations
            .iter()
            .any(|violation| matches!(violation, Violation::UnstablePole { .. }));
        let stable = if unstable {
            self.mirrored()
        } else {
            self.clone()
        };
        let again = stable.positive_real(tolerance);
        let lift = (-again.least_real_part).max(0.0);
        // A trace more than the lift, so that rounding does not undo it.
        let function = stable.plus(&Self::constant(lift * (1.0 + 1e-12)), 1.0);
        let distance = if unstable {
            self.largest_difference(&function)
        } else {
            lift
        };
        Ok(Nearest {
            function,
            distance,
            bound,
        })
    }

    /// Y with the poles of the right half-plane mirrored in the imaginary axis.
    fn mirrored(&self) -> Self {
        let reduced = self.in_lowest_terms(1e-12);
        let scales = reduced.scales();
        let unit = reduced.at_scales(scales);
        let top = degree(&unit.denominator);
        let mut denominator = vec![Complex64::from(at(&unit.denominator, top))];
        for root in roots(&unit.denominator) {
            let mirrored = Complex64::new(-root.re.abs(), root.im);
            let mut next = vec![Complex64::ZERO; denominator.len() + 1];
            for (power, coefficient) in denominator.iter().enumerate() {
                for (place, factor) in [(power, -mirrored), (power + 1, Complex64::ONE)] {
                    if let Some(entry) = next.get_mut(place) {
                        *entry += coefficient * factor;
                    }
                }
            }
            denominator = next;
        }
        Self {
            numerator: unit.numerator.clone(),
            denominator: denominator.iter().map(|z| z.re).collect(),
        }
        .at_former_scales(scales)
    }

    /// sup |Y - X| on a grid of 4001 frequencies over twelve decades, and in the limits.
    fn largest_difference(&self, other: &Self) -> f64 {
        let scales = self.scales();
        (0..=4000)
            .map(|i| scales.frequency * 10_f64.powf(-6.0 + f64::from(i) * 0.003))
            .map(|omega| {
                let s = Complex64::new(0.0, omega);
                (self.evaluate(s) - other.evaluate(s)).norm()
            })
            .fold(0.0, f64::max)
    }
}

/// The function minus a constant, over the same denominator.
pub(crate) fn lowered(function: &RationalFunction, constant: f64) -> RationalFunction {
    RationalFunction {
        numerator: sum(
            &function.numerator,
            &scaled(&function.denominator, -constant),
        ),
        denominator: function.denominator.clone(),
    }
}
