//! Brune's cycle.

use num_complex::Complex64;

use super::preamble::{self, Minimum};
use super::structure::LeverSection;
use super::{Method, Structure};
use crate::RationalFunction;
use crate::polynomial::{at, combined, divided, horner, shifted, trimmed};

/// The section of a minimum function, with the network of what it leaves.
///
/// With Z(jω0) = jX and L1 = X/ω0 (of either sign), Z - L1 s is zero at jω0; its reciprocal's pole there is a branch of
/// L2 and C in series, and what is left has a pole at infinity, L3 = -L1 L2/(L1 + L2). The three inductances, one of them
/// negative, are two coils of coupling one: L1 + L2, L2 + L3, and L2 between them.
pub(super) fn section(minimum: &Minimum) -> Option<Structure> {
    let impedance = if minimum.is_impedance {
        minimum.function.clone()
    } else {
        minimum.function.reciprocal()
    };
    let omega = minimum.omega;
    let s = Complex64::new(0.0, omega);
    let (p, q) = (&impedance.numerator, &impedance.denominator);
    let first = (horner(p, s) / horner(q, s)).im / omega;
    let factor = [omega * omega, 0.0, 1.0];
    let (p1, _) = divided(&combined(p, &shifted(q, 1), -first), &factor);
    // q/((s² + ω0²) p1) = h s/(s² + ω0²) + q1/p1.
    let h = (horner(q, s) / (s * horner(&p1, s))).re;
    let (second, inertance) = (1.0 / h, h / (omega * omega));
    let (q1, _) = divided(&combined(q, &shifted(&p1, 1), -h), &factor);
    // p1/q1 has the pole L3 s at infinity: two degrees go, the rest is of degree two less than Z.
    let top = impedance.degree();
    let (q1, p1) = (truncated(q1, top - 1), truncated(p1, top));
    let third = at(&p1, top - 1) / at(&q1, top - 2);
    let mut p2 = combined(&p1, &shifted(&q1, 1), -third);
    p2.truncate(top - 1);
    let rest = RationalFunction {
        numerator: trimmed(q1),
        denominator: trimmed(p2),
    };
    let primary = first + second;
    if !(primary > 0.0 && inertance > 0.0 && third.is_finite()) {
        return None;
    }
    Some(Structure::Lever(Box::new(LeverSection {
        stiffness: 1.0 / primary,
        ratio: second / primary,
        inertance,
        rest: preamble::remainder(&rest, Method::Brune)?,
    })))
}

/// The first so many coefficients.
fn truncated(mut coefficients: Vec<f64>, length: usize) -> Vec<f64> {
    coefficients.truncate(length);
    coefficients
}
