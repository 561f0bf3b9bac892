//! Foster's preamble.

use num_complex::Complex64;

use super::{Joined, Method, Structure, bott_duffin, brune};
use crate::polynomial::{
    at, combined, derivative, divided, horner, product, roots, scaled, size, trimmed,
};
use crate::positive_real::{AXIS, RealPart, lowered};
use crate::{Element, RationalFunction};

/// What is below this, relative to its terms, is rounding.
const ROUNDING: f64 = 1e-10;

/// A minimum function F: no poles or zeros on the axis, least real part zero at a finite ω > 0.
pub(super) struct Minimum {
    pub(super) function: RationalFunction,
    /// Whether F is an impedance rather than an admittance.
    pub(super) is_impedance: bool,
    pub(super) omega: f64,
}

/// The stages taken out, and what is left.
pub(super) struct Stages {
    pub(super) stages: Vec<(Joined, Structure)>,
    pub(super) minimum: Option<Minimum>,
}

/// The whole network: preamble, and a cycle of the method for the minimum function; for functions at unit scales.
pub(super) fn structure(function: &RationalFunction, method: Method) -> Option<Structure> {
    let Stages { stages, minimum } = preamble(function)?;
    let mut rest = match minimum {
        None => None,
        Some(minimum) => Some(match method {
            Method::Brune => brune::section(&minimum)?,
            _ => bott_duffin::cycle(&minimum, method)?,
        }),
    };
    for (joined, part) in stages.into_iter().rev() {
        rest = Some(match rest {
            None => part,
            Some(rest) => Structure::group(joined == Joined::InSeries, vec![part, rest]),
        });
    }
    rest
}

/// The network of what a cycle left, without the factors and coefficients that are its rounding.
pub(super) fn remainder(rest: &RationalFunction, method: Method) -> Option<Structure> {
    let clean = |coefficients: &[f64]| {
        let noise = 1e-11 * size(coefficients);
        trimmed(
            coefficients
                .iter()
                .map(|x| if x.abs() <= noise { 0.0 } else { *x })
                .collect(),
        )
    };
    let rest = RationalFunction {
        numerator: clean(&rest.numerator),
        denominator: clean(&rest.denominator),
    };
    structure(&rest.in_lowest_terms(1e-10), method)
}

/// The preamble of a positive-real function at unit scales; none if rounding leads astray.
pub(super) fn preamble(function: &RationalFunction) -> Option<Stages> {
    let mut rest = function.clone();
    let mut is_impedance = false;
    let mut stages = Vec::new();
    // Each stage lowers a degree or is followed by one that does.
    for _ in 0..4 * function.degree() + 8 {
        if rest.is_zero() {
            return Some(Stages {
                stages,
                minimum: None,
            });
        }
        let push = |stages: &mut Vec<(Joined, Structure)>, part: Structure| {
            if is_impedance {
                stages.push((Joined::InSeries, part.dual(1.0)?));
            } else {
                stages.push((Joined::Beside, part));
            }
            Some(())
        };
        if let Some((part, smaller)) = pole(&rest) {
            push(&mut stages, part)?;
            rest = smaller;
            continue;
        }
        if rest.degree() == 0 {
            let value = at(&rest.numerator, 0) / at(&rest.denominator, 0);
            push(&mut stages, Structure::Element(Element::Damper, value))?;
            rest = RationalFunction::constant(0.0);
            continue;
        }
        if pole(&rest.reciprocal()).is_some() {
            rest = rest.reciprocal();
            is_impedance = !is_impedance;
            continue;
        }
        let (omega, constant, smaller) = constant(&rest)?;
        let finite = omega > 0.0 && omega.is_finite();
        // The other immittance may have its least real part at an end, where a pole comes next.
        if finite && constant > ROUNDING {
            let (other, _, _) = self::constant(&rest.reciprocal())?;
            if other == 0.0 || other.is_infinite() {
                rest = rest.reciprocal();
                is_impedance = !is_impedance;
                continue;
            }
        }
        if constant > ROUNDING {
            push(&mut stages, Structure::Element(Element::Damper, constant))?;
        }
        rest = smaller;
        // Where an end is as low, a pole of the reciprocal has come up there.
        if pole(&rest.reciprocal()).is_some() {
            continue;
        }
        if finite && !zero_at(&rest, omega) {
            return Some(Stages {
                stages,
                minimum: Some(Minimum {
                    function: rest,
                    is_impedance,
                    omega,
                }),
            });
        }
        if finite {
            rest = snapped(&rest, omega);
        }
    }
    None
}

/// Least real part: where, how much, and the function without it.
fn constant(function: &RationalFunction) -> Option<(f64, f64, RationalFunction)> {
    let (omega, least) = RealPart::of(function).least(function, &[]);
    if !least.is_finite() || least < -ROUNDING {
        return None;
    }
    let mut rest = lowered(function, least);
    if omega == 0.0 {
        if let Some(first) = rest.numerator.first_mut() {
            *first = 0.0;
        }
    } else if omega.is_infinite() {
        let top = rest.denominator.len();
        rest.numerator.truncate(top.saturating_sub(1).max(1));
    }
    // Both ends may have vanished.
    let rest = cleaned(rest.numerator, rest.denominator, size(&function.numerator));
    Some((omega, least, rest))
}

/// Whether the function, whose real part is zero at jω, is zero there altogether.
fn zero_at(function: &RationalFunction, omega: f64) -> bool {
    let s = Complex64::new(0.0, omega);
    let magnitudes: Vec<f64> = function.numerator.iter().map(|x| x.abs()).collect();
    let largest = crate::polynomial::value(&magnitudes, omega);
    horner(&function.numerator, s).norm() <= 1e-8 * largest
}

/// The numerator with the exact factor s² + ω².
fn snapped(function: &RationalFunction, omega: f64) -> RationalFunction {
    let factor = [omega * omega, 0.0, 1.0];
    let (quotient, _) = divided(&function.numerator, &factor);
    RationalFunction {
        numerator: product(&quotient, &factor),
        denominator: function.denominator.clone(),
    }
}

/// A pole on the imaginary axis as a branch, and the admittance without it.
pub(super) fn pole(function: &RationalFunction) -> Option<(Structure, RationalFunction)> {
    let RationalFunction {
        numerator: p,
        denominator: q,
    } = function;
    let (top_p, top_q) = function.degrees();
    if top_p > top_q {
        let inertance = at(p, top_p) / at(q, top_q);
        let mut numerator = combined(p, &crate::polynomial::shifted(q, 1), -inertance);
        numerator.truncate(top_p);
        let rest = cleaned(numerator, q.clone(), size(p));
        return Some((Structure::Element(Element::Inerter, inertance), rest));
    }
    if at(q, 0) == 0.0 && at(q, 1) != 0.0 {
        let stiffness = at(p, 0) / at(q, 1);
        let others: Vec<f64> = q.iter().skip(1).copied().collect();
        let numerator = combined(p, &others, -stiffness)
            .into_iter()
            .skip(1)
            .collect();
        let rest = cleaned(numerator, others, size(p));
        return Some((Structure::Element(Element::Spring, stiffness), rest));
    }
    let omega = axis_root(q)?;
    let factor = [omega * omega, 0.0, 1.0];
    let (others, _) = divided(q, &factor);
    let s = Complex64::new(0.0, omega);
    let stiffness = (horner(p, s) / (s * horner(&others, s))).re;
    if stiffness.is_nan() || stiffness <= 0.0 {
        return None;
    }
    let taken = scaled(&crate::polynomial::shifted(&others, 1), -stiffness);
    let (numerator, _) = divided(&crate::polynomial::sum(p, &taken), &factor);
    let branch = Structure::Series(vec![
        Structure::Element(Element::Spring, stiffness),
        Structure::Element(Element::Inerter, stiffness / (omega * omega)),
    ]);
    Some((branch, cleaned(numerator, others, size(p))))
}

/// A rational function without leading and trailing coefficients that are rounding of terms of a given size.
fn cleaned(mut numerator: Vec<f64>, denominator: Vec<f64>, terms: f64) -> RationalFunction {
    let noise = 1e-11 * terms;
    for coefficient in &mut numerator {
        if coefficient.abs() <= noise {
            *coefficient = 0.0;
        }
    }
    if numerator.is_empty() {
        numerator.push(0.0);
    }
    RationalFunction {
        numerator: trimmed(numerator),
        denominator: trimmed(denominator),
    }
}

/// The angular frequency of a root on the imaginary axis, refined on the even and odd parts.
fn axis_root(polynomial: &[f64]) -> Option<f64> {
    let root = roots(polynomial)
        .into_iter()
        .find(|root| root.im > 0.0 && root.re.abs() <= AXIS * root.norm())?;
    let mut omega = root.norm();
    let slope = derivative(polynomial);
    for _ in 0..3 {
        let s = Complex64::new(0.0, omega);
        // Newton's step along the axis.
        let step = horner(polynomial, s) / (Complex64::I * horner(&slope, s));
        if step.re.is_finite() {
            omega -= step.re;
        }
    }
    Some(omega)
}
