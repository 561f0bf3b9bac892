//! Canonical forms of functions of two kinds of elements.

use std::fmt;

use num_complex::Complex64;

use super::Structure;
use super::preamble::pole;
use crate::polynomial::{at, combined, derivative, horner, roots, trimmed, value};
use crate::{Element, RationalFunction};

/// The four canonical forms.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Form {
    /// Partial fractions of the admittance: branches side by side.
    FosterAdmittance,
    /// Partial fractions of the impedance: groups in series.
    FosterImpedance,
    /// Continued fraction about infinity: a ladder whose outermost element rules high frequencies.
    CauerAtInfinity,
    /// Continued fraction about zero: a ladder whose outermost element rules low frequencies.
    CauerAtZero,
}

impl Form {
    /// All of them.
    pub const ALL: [Self; 4] = [
        Self::FosterAdmittance,
        Self::FosterImpedance,
        Self::CauerAtInfinity,
        Self::CauerAtZero,
    ];
}

impl fmt::Display for Form {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::FosterAdmittance => "Foster (admittance)",
            Self::FosterImpedance => "Foster (impedance)",
            Self::CauerAtInfinity => "Cauer (infinity)",
            Self::CauerAtZero => "Cauer (zero)",
        })
    }
}

/// The form of a function at unit scales; none if it takes three kinds of elements.
pub(super) fn structure(function: &RationalFunction, form: Form) -> Option<Structure> {
    match form {
        Form::FosterAdmittance => foster(function),
        Form::FosterImpedance => foster(&function.reciprocal())?.dual(1.0),
        Form::CauerAtInfinity => cauer(function),
        Form::CauerAtZero => {
            // s to 1/s turns springs into inerters of the same number.
            cauer(&function.at_reciprocal()).map(|ladder| mirrored(&ladder))
        }
    }
}

fn mirrored(structure: &Structure) -> Structure {
    let all = |children: &[Structure]| children.iter().map(mirrored).collect();
    match structure {
        Structure::Element(element, value) => {
            Structure::Element(element.dual().unwrap_or(*element), *value)
        }
        Structure::Series(children) => Structure::Series(all(children)),
        Structure::Parallel(children) => Structure::Parallel(all(children)),
        other => other.clone(),
    }
}

/// Partial fractions of the admittance.
fn foster(function: &RationalFunction) -> Option<Structure> {
    if let Some(structure) = lossless(function) {
        return Some(structure);
    }
    let mut branches = Vec::new();
    let mut rest = function.clone();
    // Springs and inerters: every pole is on the axis.
    while let Some((branch, smaller)) = pole(&rest) {
        branches.push(branch);
        rest = smaller;
        if rest.is_zero() {
            return Some(Structure::group(false, branches));
        }
    }
    if branches
        .iter()
        .any(|branch| !matches!(branch, Structure::Element(..)))
    {
        return None;
    }
    // Poles on the negative real axis: residues of Y for springs and dampers, of Y/s for dampers and inerters.
    let (top_p, top_q) = rest.degrees();
    let slope = derivative(&rest.denominator);
    let mut poles = Vec::new();
    for root in roots(&rest.denominator) {
        if root.im.abs() > 1e-7 * root.norm() || root.re >= 0.0 {
            return None;
        }
        poles.push(root.re);
    }
    poles.sort_by(|a, b| b.total_cmp(a));
    let multiple = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-6 * a.abs();
    if poles.iter().zip(poles.iter().skip(1)).any(multiple) {
        return None;
    }
    let residues: Vec<f64> = poles
        .iter()
        .map(|s| value(&rest.numerator, *s) / value(&slope, *s))
        .collect();
    let with_springs = residues.iter().all(|residue| *residue > 0.0);
    let with_inerters = residues.iter().all(|residue| *residue < 0.0);
    let constant = if with_springs {
        if top_p == top_q {
            at(&rest.numerator, top_p) / at(&rest.denominator, top_q)
        } else {
            0.0
        }
    } else if with_inerters {
        at(&rest.numerator, 0) / at(&rest.denominator, 0)
    } else {
        return None;
    };
    let noise = 1e-12 * residues.iter().map(|r| r.abs()).sum::<f64>();
    if constant < -noise {
        return None;
    }
    if constant > noise || residues.is_empty() {
        branches.push(Structure::Element(Element::Damper, constant));
    }
    for (s, residue) in poles.iter().zip(&residues) {
        // k/(s + k/c) with residue k; c s/(s + c/b) = c - (c²/b)/(s + c/b) with residue -c²/b.
        let (element, reactive, damper) = if with_springs {
            (Element::Spring, *residue, residue / -s)
        } else {
            let damper = residue / s;
            (Element::Inerter, damper / -s, damper)
        };
        branches.push(Structure::Series(vec![
            Structure::Element(element, reactive),
            Structure::Element(Element::Damper, damper),
        ]));
    }
    let structure = Structure::group(false, branches);
    let counts = structure.elements();
    (counts.springs == 0 || counts.inerters == 0).then_some(structure)
}

/// Partial fractions of a function of springs and inerters, every residue from the function itself.
fn lossless(function: &RationalFunction) -> Option<Structure> {
    let RationalFunction {
        numerator: p,
        denominator: q,
    } = function;
    let odd = |coefficients: &[f64], parity: usize| {
        coefficients
            .iter()
            .enumerate()
            .all(|(power, coefficient)| power % 2 == parity || *coefficient == 0.0)
    };
    if !((odd(p, 0) && odd(q, 1)) || (odd(p, 1) && odd(q, 0))) {
        return None;
    }
    let mut branches = Vec::new();
    let (top_p, top_q) = function.degrees();
    if top_p > top_q {
        let inertance = at(p, top_p) / at(q, top_q);
        branches.push(Structure::Element(Element::Inerter, inertance));
    }
    if at(q, 0) == 0.0 {
        let stiffness = at(p, 0) / at(q, 1);
        branches.push(Structure::Element(Element::Spring, stiffness));
    }
    let slope = derivative(q);
    // q in x = -s², its roots ω².
    let start = usize::from(at(q, 0) == 0.0);
    let squares: Vec<f64> = q
        .iter()
        .skip(start)
        .step_by(2)
        .enumerate()
        .map(|(i, x)| if i % 2 == 0 { *x } else { -*x })
        .collect();
    let mut poles: Vec<f64> = roots(&squares).iter().map(|x| x.re).collect();
    poles.sort_by(f64::total_cmp);
    for square in poles {
        let s = Complex64::new(0.0, square.sqrt());
        let stiffness = 2.0 * (horner(p, s) / horner(&slope, s)).re;
        branches.push(Structure::Series(vec![
            Structure::Element(Element::Spring, stiffness),
            Structure::Element(Element::Inerter, stiffness / square),
        ]));
    }
    let positive = |part: &Structure| match part {
        Structure::Element(_, value) => *value > 0.0,
        _ => false,
    };
    let good = branches.iter().all(|branch| match branch {
        Structure::Series(parts) => parts.iter().all(positive),
        other => positive(other),
    });
    good.then(|| Structure::group(false, branches))
}

/// Continued fraction about infinity: poles and values there, of admittance and impedance in turn.
fn cauer(function: &RationalFunction) -> Option<Structure> {
    let mut stages: Vec<(bool, Structure)> = Vec::new();
    let mut rest = function.clone();
    let mut is_impedance = false;
    for _ in 0..4 * function.degree() + 4 {
        if rest.is_zero() {
            break;
        }
        let (top_p, top_q) = rest.degrees();
        if top_p < top_q {
            rest = rest.reciprocal();
            is_impedance = !is_impedance;
            continue;
        }
        let lead = at(&rest.numerator, top_p) / at(&rest.denominator, top_q);
        if lead.is_nan() || lead <= 0.0 {
            return None;
        }
        let shift = top_p - top_q;
        // Of a function and its reciprocal only that with the smaller value at infinity than at zero stays passive.
        let (p0, q0) = (at(&rest.numerator, 0), at(&rest.denominator, 0));
        if shift == 0 && rest.degree() > 0 && lead * q0 > p0 {
            rest = rest.reciprocal();
            is_impedance = !is_impedance;
            continue;
        }
        let part = match shift {
            0 => Structure::Element(Element::Damper, lead),
            1 => Structure::Element(Element::Inerter, lead),
            _ => return None,
        };
        let part = if is_impedance { part.dual(1.0)? } else { part };
        stages.push((is_impedance, part));
        let taken = crate::polynomial::shifted(&rest.denominator, shift);
        let mut numerator = combined(&rest.numerator, &taken, -lead);
        numerator.truncate(top_p);
        let noise = 1e-12 * crate::polynomial::size(&rest.numerator);
        for coefficient in &mut numerator {
            if coefficient.abs() <= noise {
                *coefficient = 0.0;
            }
        }
        rest.numerator = trimmed(numerator);
    }
    let mut ladder: Option<Structure> = None;
    for (series, part) in stages.into_iter().rev() {
        ladder = Some(match ladder {
            None => part,
            Some(inner) => Structure::group(series, vec![part, inner]),
        });
    }
    let ladder = ladder?;
    let counts = ladder.elements();
    let kinds = [counts.springs, counts.dampers, counts.inerters];
    (kinds.iter().filter(|count| **count > 0).count() <= 2).then_some(ladder)
}
