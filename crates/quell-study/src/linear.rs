//! What frequency responses, norms and modes are taken of.

use num_complex::Complex64;
use quell_document::Fault;
use quell_model::LinearForm;
use quell_model::system::System;
use quell_response::{
    Assembly, Certificate, Modes, Norm, OperatingPoint, ResponseError, Spectrum, certify, h2,
    h2_fast,
};

use crate::built::ValueScratch;
use crate::study::Study;
use crate::transient::{Source, ValuePlaces, Watching, parameters, sources};

/// What is looked at in a linear run.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Output {
    /// Of a linear host with linear devices: a combination of its signals.
    Form(LinearForm),
    /// Of equations: one of the signals that the run watches, whose gradient at the equilibrium counts.
    Watched(usize),
}

/// A linear run of a system of equations: compiled, it is linearised about the equilibrium of each candidate's values.
#[derive(Debug)]
pub(crate) struct LinearisedPlan {
    system: System,
    sources: Vec<Source>,
}

impl LinearisedPlan {
    /// Compiles the system whose signals have been gathered.
    ///
    /// # Errors
    /// Why host and devices are no system of equations.
    pub(crate) fn new(
        study: &Study,
        span: quell_expression::Span,
        watching: &Watching<'_>,
        places: &ValuePlaces<'_>,
    ) -> Result<Self, Fault> {
        let system = watching
            .system()
            .map_err(|error| Fault::at(&study.source, span, error.to_string()))?;
        Ok(Self {
            sources: sources(&system, watching.devices(), places),
            system,
        })
    }

    /// The operating point at the given values, or why there is none.
    pub(crate) fn at(&self, values: &ValueScratch) -> Result<OperatingPoint, String> {
        let parameters = parameters(&self.sources, &values.mechanical, &values.laws);
        let mut prepared = self.system.prepare(&parameters);
        OperatingPoint::find(&mut prepared).map_err(|error| error.to_string())
    }
}

/// A linear system at values of its elements.
#[derive(Debug)]
pub(crate) enum Linear<'a> {
    /// A linear host with linear devices.
    Assembled {
        assembly: &'a Assembly,
        /// Mechanical values of all elements, SI.
        values: &'a [f64],
    },
    /// Equations linearised about their equilibrium.
    AtRest(&'a OperatingPoint),
}

/// An output of another kind of system than the one at hand, which compiling rules out.
fn stranger() -> ResponseError {
    ResponseError::UnknownIndex {
        host: "linearised".to_owned(),
        what: "output",
        index: 0,
        count: 0,
    }
}

impl Linear<'_> {
    /// The largest magnitude over a band (rad/s) with a bound.
    ///
    /// # Errors
    /// As [`certify`].
    pub(crate) fn certify(
        &self,
        input: usize,
        output: &Output,
        band: (f64, f64),
        tolerance: f64,
    ) -> Result<Certificate, ResponseError> {
        match (self, output) {
            (Self::Assembled { assembly, values }, Output::Form(form)) => {
                certify(assembly, values, input, form, band, tolerance)
            }
            (Self::AtRest(point), Output::Watched(signal)) => {
                point.linear.certify(input, *signal, band, tolerance)
            }
            _ => Err(stranger()),
        }
    }

    /// H(jω).
    ///
    /// # Errors
    /// Where an undamped mode lies on ω.
    pub(crate) fn response(
        &self,
        input: usize,
        output: &Output,
        omega: f64,
    ) -> Result<Complex64, ResponseError> {
        match (self, output) {
            (Self::Assembled { assembly, values }, Output::Form(form)) => {
                assembly.direct_response(values, input, form, omega)
            }
            (Self::AtRest(point), Output::Watched(signal)) => {
                point.linear.response(input, *signal, omega)
            }
            _ => Err(stranger()),
        }
    }

    /// |H(jω)| at many frequencies, with those left out at which there is none.
    pub(crate) fn magnitudes(
        &self,
        input: usize,
        output: &Output,
        omegas: &[f64],
    ) -> Vec<(f64, f64)> {
        let found: Vec<f64> = match (self, output) {
            (Self::AtRest(point), Output::Watched(signal)) => point
                .linear
                .responses(input, *signal, omegas)
                .unwrap_or_default()
                .into_iter()
                .map(Complex64::norm)
                .collect(),
            _ => omegas
                .iter()
                .map(|omega| {
                    self.response(input, output, *omega)
                        .map_or(f64::NAN, Complex64::norm)
                })
                .collect(),
        };
        omegas
            .iter()
            .copied()
            .zip(found)
            .filter(|(_, value)| value.is_finite())
            .collect()
    }

    /// ‖H‖₂² or a variance.
    ///
    /// # Errors
    /// As [`h2`].
    pub(crate) fn h2(
        &self,
        input: usize,
        output: &Output,
        band: Option<(f64, f64)>,
        spectrum: Option<&Spectrum<'_>>,
    ) -> Result<Norm, ResponseError> {
        match (self, output) {
            (Self::Assembled { assembly, values }, Output::Form(form)) => {
                h2(assembly, values, input, form, band, spectrum)
            }
            (Self::AtRest(point), Output::Watched(signal)) => {
                point.linear.h2(input, *signal, band, spectrum)
            }
            _ => Err(stranger()),
        }
    }

    /// ‖H‖₂² over all frequencies, unchecked.
    ///
    /// # Errors
    /// As [`h2_fast`].
    pub(crate) fn h2_fast(&self, input: usize, output: &Output) -> Result<f64, ResponseError> {
        match (self, output) {
            (Self::Assembled { assembly, values }, Output::Form(form)) => {
                h2_fast(assembly, values, input, form)
            }
            (Self::AtRest(point), Output::Watched(signal)) => point.linear.h2_fast(input, *signal),
            _ => Err(stranger()),
        }
    }

    /// The modes.
    ///
    /// # Errors
    /// Where they cannot be computed.
    pub(crate) fn modes(&self) -> Result<Modes, ResponseError> {
        match self {
            Self::Assembled { assembly, values } => assembly.modes(values),
            Self::AtRest(point) => point.linear.modes(),
        }
    }

    /// What must be said beside a frequency response: the equilibrium is not stable.
    pub(crate) fn remark(&self) -> Option<String> {
        let Self::AtRest(point) = self else {
            return None;
        };
        let modes = point.linear.modes().ok()?;
        // A part of the rounding error of eigenvalues is no growth.
        let growth = modes
            .growth()
            .filter(|growth| *growth > 1e-10 * modes.scale)?;
        Some(format!(
            "the equilibrium is unstable: a motion about it grows at {growth:.4e} 1/s, so that this response does not come about"
        ))
    }
}
