//! From admittances to networks.
//!
//! Everywhere Y(s) is the mechanical *admittance* force/velocity in the force-current analogy (Firestone 1933): spring
//! k/s, damper c, inerter b s, side by side adds. Papers on circuits mostly speak of the *impedance* Z = 1/Y of R, L and
//! C; a circuit's L is a spring 1/L, its R a damper 1/R, its C an inerter C, in the same groups. Every method here takes
//! Y and says of itself on which of both it works inside.
//!
//! Every [`Realisation`] is analysed back, from its elements, and is an error if it is farther than
//! [`REALISATION_TOLERANCE`] from the target.

mod bott_duffin;
mod brune;
mod matching;
mod monomials;
mod preamble;
mod structure;
mod two_kinds;

use std::fmt;

use crate::{POSITIVE_REAL_TOLERANCE, RationalFunction, Scales, Verdict};

pub(crate) use matching::numbered;
pub use matching::{Matching, Smallest};
pub(crate) use monomials::{Monomials, halton};
pub use structure::{Elements, LeverSection, Structure};
pub use two_kinds::Form;

/// The largest distance ([`RationalFunction::distance`]) between a target and what a realisation of it does.
pub const REALISATION_TOLERANCE: f64 = 1e-9;

/// How a network was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Method {
    /// Foster's preamble alone, which ended in a constant.
    Preamble,
    /// A canonical form of two kinds of elements.
    Canonical(Form),
    /// Brune's cycles, with a lever in each.
    Brune,
    /// Bott and Duffin's cycles.
    BottDuffin,
    /// Bott and Duffin's cycles with one reactive element less in each, a bridge.
    ReducedBottDuffin,
    /// Equations of an enumerated network solved.
    Matching,
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Preamble => f.write_str("Foster's preamble"),
            Self::Canonical(form) => write!(f, "{form}"),
            Self::Brune => f.write_str("Brune"),
            Self::BottDuffin => f.write_str("Bott-Duffin"),
            Self::ReducedBottDuffin => f.write_str("reduced Bott-Duffin"),
            Self::Matching => f.write_str("matching"),
        }
    }
}

/// A network that has a given admittance.
#[derive(Debug, Clone, PartialEq)]
pub struct Realisation {
    /// How it was found.
    pub method: Method,
    /// The network with its values.
    pub structure: Structure,
    /// Distance of its admittance, computed from its elements, from the target ([`RationalFunction::distance`]).
    pub residual: f64,
}

/// Why there is no network.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SynthesisError {
    /// No passive device has this admittance.
    #[error("{0}")]
    NotPositiveReal(Verdict),
    /// The admittance is zero: no device at all.
    #[error("the admittance is zero, so that there is nothing to build")]
    Zero,
    /// The function takes more than two kinds of elements.
    #[error(
        "the function needs more than two kinds of elements; try Bott and Duffin's method or matching"
    )]
    NotTwoKinds,
    /// What was found does not do what was asked for.
    #[error(
        "the network found by {method} differs from the target by {residual:.1e}, more than {REALISATION_TOLERANCE:.0e}: \
         the function is too ill-conditioned for this method"
    )]
    Inaccurate {
        /// The method.
        method: Method,
        /// How far (chordal distance).
        residual: f64,
    },
    /// Rounding hides what the method must decide, such as whether a coefficient is zero.
    #[error("rounding leads {0} astray: the function is too ill-conditioned for this method")]
    Rounding(Method),
    /// No network up to the given size has the admittance.
    #[error(
        "no network of at most {0} elements has this admittance; allow more, or try Bott and Duffin's method"
    )]
    NotFound(usize),
}

/// A target at unit scales, tested.
pub(crate) struct Target {
    pub(crate) unit: RationalFunction,
    pub(crate) scales: Scales,
}

impl Target {
    pub(crate) fn new(function: &RationalFunction) -> Result<Self, SynthesisError> {
        let verdict = function.positive_real(POSITIVE_REAL_TOLERANCE);
        if !verdict.is_positive_real() {
            return Err(SynthesisError::NotPositiveReal(verdict));
        }
        if function.is_zero() {
            return Err(SynthesisError::Zero);
        }
        let reduced = function.in_lowest_terms(1e-12);
        let scales = reduced.scales();
        Ok(Self {
            unit: reduced.at_scales(scales),
            scales,
        })
    }

    /// The structure at the target's scales, analysed back.
    pub(crate) fn accept(
        &self,
        function: &RationalFunction,
        structure: &Structure,
        method: Method,
    ) -> Result<Realisation, SynthesisError> {
        let structure = structure.rescaled(self.scales.size, self.scales.frequency);
        let residual = function.distance(&structure.admittance());
        if residual <= REALISATION_TOLERANCE {
            Ok(Realisation {
                method,
                structure,
                residual,
            })
        } else {
            Err(SynthesisError::Inaccurate { method, residual })
        }
    }
}

/// Realises Y(s) with springs, dampers, inerters and levers (Brune 1931): Foster's preamble, then cycles that each lower
/// the degree by two with one spring, one inerter and one lever. The cycles work on the impedance.
///
/// # Errors
/// See [`SynthesisError`].
pub fn brune(function: &RationalFunction) -> Result<Realisation, SynthesisError> {
    realise(function, Method::Brune)
}

/// Realises Y(s) with springs, dampers and inerters only (Bott and Duffin 1949): Foster's preamble, then cycles that each
/// lower the degree by two and leave two functions, with six reactive elements. The cycles work on the impedance
/// where it is spring-like at the minimum, else on the admittance.
///
/// # Errors
/// See [`SynthesisError`].
pub fn bott_duffin(function: &RationalFunction) -> Result<Realisation, SynthesisError> {
    realise(function, Method::BottDuffin)
}

/// As [`bott_duffin`], with five reactive elements a cycle in a bridge (Pantell 1954; Reza 1954; Fialkow and Gerst 1955).
///
/// No network of springs, dampers and inerters realises every biquadratic minimum function with fewer reactive elements
/// (Hughes 2017).
///
/// # Errors
/// See [`SynthesisError`].
pub fn reduced_bott_duffin(function: &RationalFunction) -> Result<Realisation, SynthesisError> {
    realise(function, Method::ReducedBottDuffin)
}

fn realise(function: &RationalFunction, method: Method) -> Result<Realisation, SynthesisError> {
    let target = Target::new(function)?;
    let structure =
        preamble::structure(&target.unit, method).ok_or(SynthesisError::Rounding(method))?;
    let simple = structure.is_series_parallel() && {
        let stages = preamble::preamble(&target.unit);
        stages.is_some_and(|stages| stages.minimum.is_none())
    };
    target.accept(
        function,
        &structure,
        if simple { Method::Preamble } else { method },
    )
}

/// Realises Y(s) of two kinds of elements in a canonical form (Foster 1924; Cauer 1926).
///
/// The Foster forms are partial fractions of the admittance or of the impedance, the Cauer forms continued fractions
/// of the admittance about infinity or about zero.
///
/// # Errors
/// See [`SynthesisError`]; [`SynthesisError::NotTwoKinds`] where three kinds are needed.
pub fn canonical(function: &RationalFunction, form: Form) -> Result<Realisation, SynthesisError> {
    let target = Target::new(function)?;
    let structure = two_kinds::structure(&target.unit, form).ok_or(SynthesisError::NotTwoKinds)?;
    target.accept(function, &structure, Method::Canonical(form))
}

/// What Foster's preamble takes out of a function, and the minimum function that it leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct Preamble {
    /// What is taken out, from the outside to the inside: beside the rest, or in series with it.
    pub stages: Vec<(Joined, Structure)>,
    /// The minimum function that is left, as an admittance, with the frequency (rad/s) at which its real part is zero.
    pub minimum: Option<(RationalFunction, f64)>,
}

/// How a part stands to the rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Joined {
    /// Beside it: taken from the admittance.
    Beside,
    /// In series with it: taken from the impedance.
    InSeries,
}

/// Foster's preamble: poles on the imaginary axis and constants, taken from admittance and impedance in turn, until
/// nothing or a minimum function is left (Brune 1931).
///
/// # Errors
/// See [`SynthesisError`].
pub fn foster_preamble(function: &RationalFunction) -> Result<Preamble, SynthesisError> {
    let target = Target::new(function)?;
    let stages =
        preamble::preamble(&target.unit).ok_or(SynthesisError::Rounding(Method::Preamble))?;
    let Scales { frequency, size } = target.scales;
    Ok(Preamble {
        stages: stages
            .stages
            .iter()
            .map(|(joined, part)| (*joined, part.rescaled(size, frequency)))
            .collect(),
        minimum: stages.minimum.map(|minimum| {
            let admittance = if minimum.is_impedance {
                minimum.function.reciprocal()
            } else {
                minimum.function
            };
            (
                admittance.at_former_scales(target.scales),
                minimum.omega * frequency,
            )
        }),
    })
}
