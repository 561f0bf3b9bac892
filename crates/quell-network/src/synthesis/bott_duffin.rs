//! Bott and Duffin's cycle, and the bridge that saves one element.
//!
//! Richards' theorem (1947): with Z positive-real and any a > 0, R = (a Z(s) - s Z(a))/(a Z(a) - s Z(s)) is positive-real of
//! no higher degree, and with ζ = Z(a)
//!
//! ```text
//! Z = 1/(1/(ζ R) + s/(a ζ)) + 1/(a/(ζ s) + R/ζ).
//! ```
//!
//! Where Z(jω0) = jX with X > 0, the a with Z(a)/a = X/ω0 makes R zero at jω0, so that 1/(ζ R) and R/ζ lose a pole there.

use num_complex::Complex64;

use super::preamble::{self, Minimum};
use super::{Method, Structure};
use crate::polynomial::{combined, divided, horner, roots, scaled, shifted, trimmed};
use crate::{Element, RationalFunction};

/// Edges of the bridge and of its planar dual, node 0 the head and 1 the tail.
///
/// Order: the merged inerter, two springs at its far node, the inerter beside them, the first remainder, the spring after
/// it, the second remainder.
const BRIDGE: [(usize, usize); 7] = [(0, 2), (2, 3), (2, 4), (0, 4), (0, 3), (3, 1), (4, 1)];
const DUAL_BRIDGE: [(usize, usize); 7] = [(2, 3), (2, 4), (3, 4), (3, 1), (2, 0), (4, 0), (4, 1)];

/// The dual of a graph that [`cycle`] made.
pub(super) fn dual_graph(edges: &[(usize, usize, Structure)], factor: f64) -> Option<Structure> {
    let same = |table: &[(usize, usize); 7]| {
        table.len() == edges.len() && edges.iter().zip(table).all(|(e, t)| (e.0, e.1) == *t)
    };
    let table = if same(&BRIDGE) {
        DUAL_BRIDGE
    } else if same(&DUAL_BRIDGE) {
        BRIDGE
    } else {
        return None;
    };
    let edges = edges
        .iter()
        .zip(table)
        .map(|((_, _, child), (a, b))| Some((a, b, child.dual(factor)?)))
        .collect::<Option<Vec<_>>>()?;
    Some(Structure::Graph(edges))
}

/// The network of a minimum function at unit scales.
pub(super) fn cycle(minimum: &Minimum, method: Method) -> Option<Structure> {
    let s = Complex64::new(0.0, minimum.omega);
    let given = minimum.function.evaluate(s);
    // X > 0: of F and 1/F one is inductive at jω0; `flip` says that the network is built for 1/F.
    let flip = given.im < 0.0;
    let z = if flip {
        minimum.function.reciprocal()
    } else {
        minimum.function.clone()
    };
    let built = impedance_cycle(&z, minimum.omega, method)?;
    // Built with impedance z; F = z or 1/z is an impedance or an admittance.
    if flip == minimum.is_impedance {
        built.dual(1.0)
    } else {
        Some(built)
    }
}

fn inductance(value: f64) -> Structure {
    Structure::Element(Element::Spring, 1.0 / value)
}

fn capacitance(value: f64) -> Structure {
    Structure::Element(Element::Inerter, value)
}

fn impedance_cycle(z: &RationalFunction, omega: f64, method: Method) -> Option<Structure> {
    let s = Complex64::new(0.0, omega);
    let (p, q) = (&z.numerator, &z.denominator);
    let ratio = (horner(p, s) / horner(q, s)).im / omega;
    // Z(a)/a falls from infinity to zero: one positive root.
    let a = roots(&combined(p, &shifted(q, 1), -ratio))
        .into_iter()
        .filter(|root| root.re > 0.0 && root.im.abs() <= 1e-7 * root.norm())
        .map(|root| root.re)
        .reduce(f64::max)?;
    let zeta = ratio * a;
    let (linear, quadratic) = ([-a, 1.0], [omega * omega, 0.0, 1.0]);
    let (numerator, _) = divided(&combined(&scaled(p, a), &shifted(q, 1), -zeta), &linear);
    let (denominator, _) = divided(
        &combined(&scaled(q, a * zeta), &shifted(p, 1), -1.0),
        &linear,
    );
    // R = (s² + ω0²) n/d, 1/(ζ R) = h s/(s² + ω0²) + r/n.
    let (n, _) = divided(&numerator, &quadratic);
    let d = scaled(&denominator, 1.0 / zeta);
    let h = (horner(&d, s) / (s * horner(&n, s))).re;
    if h.is_nan() || h <= 0.0 {
        return None;
    }
    let (r, _) = divided(&combined(&d, &shifted(&n, 1), -h), &quadratic);
    let top = z.degree() - 1;
    let cut = |mut coefficients: Vec<f64>| {
        coefficients.truncate(top);
        trimmed(coefficients)
    };
    let rest = RationalFunction {
        numerator: cut(r),
        denominator: cut(n),
    };
    // The first remainder by its admittance r/n, the second with impedance ζ²/Z_a.
    let first = preamble::remainder(&rest, method)?;
    let second = first.dual(1.0 / (zeta * zeta))?;
    let (l2, c2) = (1.0 / h, h / (omega * omega));
    let (c1, l1) = (1.0 / (a * zeta), ratio);
    let (l3, c3) = (zeta * zeta * c2, l2 / (zeta * zeta));
    if method == Method::BottDuffin {
        return Some(Structure::Series(vec![
            Structure::Parallel(vec![
                capacitance(c1),
                Structure::Series(vec![inductance(l2), capacitance(c2)]),
                first,
            ]),
            Structure::Parallel(vec![
                inductance(l1),
                Structure::Series(vec![
                    Structure::Parallel(vec![inductance(l3), capacitance(c3)]),
                    second,
                ]),
            ]),
        ]));
    }
    // The two halves are a balanced bridge, Z = (α + β) | (γ + δ) with α | (L2, C2) | Z_a, β = L1, γ = C1 and δ the tank
    // with Z_b. γ and the tank are also C4 | (C5 + L5), and C5 has the voltage of C2: their far nodes join, C2 + C5.
    let (sum, coefficient) = (1.0 / c1 + 1.0 / c3, omega * omega / c1);
    let difference = omega * omega - coefficient / sum;
    let (c4, l5, c5) = (1.0 / sum, sum / difference, difference / coefficient);
    let parts = [
        capacitance(c2 + c5),
        inductance(l2),
        inductance(l5),
        capacitance(c4),
        first,
        inductance(l1),
        second,
    ];
    Some(Structure::Graph(
        BRIDGE
            .into_iter()
            .zip(parts)
            .map(|((from, to), part)| (from, to, part))
            .collect(),
    ))
}
