//! Numbers read from runs: fast ones for a search, with what is known about them for a report.

use num_complex::Complex64;
use quell_expression::Dimension;
use quell_response::{CertificateStatus, ModeKind, Plan, ResponseError, Scratch};

use super::run::SpectrumTape;
use crate::band::{BandPlan, BandValue, FoundBands};
use crate::criteria::{Functional, Modal, Norm, Statistic};
use crate::linear::{Linear, Output};
use crate::transient::{Observation, Simulated};

/// A functional with the run that it reads.
#[derive(Debug)]
pub(super) struct Reading {
    pub(super) functional: Functional,
    pub(super) run: String,
    pub(super) input: usize,
    /// SI dimension of output over input.
    pub(super) response: Dimension,
    pub(super) band: Option<(f64, f64)>,
    pub(super) oscillatory: bool,
    pub(super) spectrum: Option<SpectrumTape>,
    /// Tightest tolerance of the criteria that read it.
    pub(super) tolerance: f64,
    /// Frequencies chosen once for all values; of linear hosts alone.
    pub(super) plan: Option<Plan>,
}

impl Reading {
    /// Its value for a search; not-a-number where there is none.
    pub(super) fn fast(&self, linear: &Linear<'_>, scratch: &mut Scratch) -> f64 {
        match &self.functional {
            Functional::Time(_) | Functional::Band(..) => f64::NAN,
            Functional::Peak(output) => match (&self.plan, linear) {
                (Some(plan), Linear::Assembled { values, .. }) => plan.peak(values, scratch).value,
                _ => self.band.map_or(f64::NAN, |band| {
                    linear
                        .certify(self.input, output, band, self.tolerance)
                        .map_or(f64::NAN, |certificate| certificate.value)
                }),
            },
            Functional::Magnitude(output, omega) => linear
                .response(self.input, output, *omega)
                .map_or(f64::NAN, Complex64::norm),
            Functional::Norm(output, norm) => {
                let squared = if self.band.is_none() && self.spectrum.is_none() {
                    linear.h2_fast(self.input, output).unwrap_or(f64::NAN)
                } else {
                    self.norm_squared(output, *norm, linear)
                        .map_or(f64::NAN, |norm| norm.squared)
                };
                rooted(*norm, squared)
            }
            Functional::Modes(statistic, modal) => {
                modal_value(linear, *statistic, *modal, self.oscillatory).unwrap_or(f64::NAN)
            }
        }
    }

    /// Its value with what is known about it.
    pub(super) fn certified(&self, linear: &Linear<'_>) -> (f64, Known) {
        let computed = |value: f64, omega: Option<f64>, tolerance: Option<f64>| {
            let known = Known {
                omega,
                time: None,
                tolerance,
                status: remarked("computed", linear.remark()),
            };
            (value, known)
        };
        match &self.functional {
            Functional::Time(_) | Functional::Band(..) => {
                Known::failed("there is no such run".to_owned())
            }
            Functional::Peak(output) => {
                let Some(band) = self.band else {
                    return Known::failed("the run has no band".to_owned());
                };
                match linear.certify(self.input, output, band, self.tolerance) {
                    Ok(certificate) => (
                        certificate.value,
                        Known {
                            omega: Some(certificate.omega),
                            time: None,
                            tolerance: Some(certificate.achieved_tolerance),
                            status: match certificate.status {
                                CertificateStatus::Certified => {
                                    remarked("certified", linear.remark())
                                }
                                CertificateStatus::NotCertified { reason } => {
                                    format!("not certified: {reason}")
                                }
                            },
                        },
                    ),
                    Err(error) => Known::failed(error.to_string()),
                }
            }
            Functional::Magnitude(output, omega) => {
                match linear.response(self.input, output, *omega) {
                    Ok(response) => computed(response.norm(), Some(*omega), None),
                    Err(error) => Known::failed(error.to_string()),
                }
            }
            Functional::Norm(output, norm) => match self.norm_squared(output, *norm, linear) {
                Ok(found) => {
                    let relative = found.error_estimate / found.squared;
                    let share = if *norm == Norm::Variance { 1.0 } else { 0.5 };
                    computed(rooted(*norm, found.squared), None, Some(share * relative))
                }
                Err(error) => Known::failed(error.to_string()),
            },
            Functional::Modes(statistic, modal) => {
                match modal_value(linear, *statistic, *modal, self.oscillatory) {
                    Ok(value) => (
                        value,
                        Known {
                            omega: None,
                            time: None,
                            tolerance: None,
                            status: "computed".to_owned(),
                        },
                    ),
                    Err(error) => Known::failed(error),
                }
            }
        }
    }

    fn norm_squared(
        &self,
        output: &Output,
        norm: Norm,
        linear: &Linear<'_>,
    ) -> Result<quell_response::Norm, ResponseError> {
        let spectrum = self.spectrum.clone();
        let density = move |omega: f64| {
            spectrum
                .as_ref()
                .map_or(1.0, |spectrum| spectrum.value(omega))
        };
        let weighted: Option<&quell_response::Spectrum<'_>> = if norm == Norm::H2 {
            None
        } else {
            Some(&density)
        };
        linear.h2(self.input, output, self.band, weighted)
    }
}

fn remarked(status: &str, remark: Option<String>) -> String {
    match remark {
        Some(remark) => format!("{status}, but {remark}"),
        None => status.to_owned(),
    }
}

/// A number of a run in time with what is known about it.
pub(super) fn in_time(
    simulated: &Simulated<'_>,
    observation: &Observation,
    (value, time): (f64, Option<f64>),
    remark: Option<String>,
) -> (f64, Known) {
    let status = if let Some(failure) = &simulated.failure {
        failure.clone()
    } else if value.is_nan() {
        observation.absent().to_owned()
    } else if let Some(grazing) = simulated.grazing() {
        grazing
    } else {
        remark.unwrap_or_else(|| "computed".to_owned())
    };
    (
        value,
        Known {
            omega: None,
            time,
            tolerance: None,
            status,
        },
    )
}

/// A number of a stable band with what is known about it.
pub(super) fn of_band(plan: &BandPlan, found: &FoundBands, value: BandValue) -> (f64, Known) {
    let known = Known {
        omega: None,
        time: None,
        tolerance: BandPlan::tolerance(found),
        status: plan.status(found),
    };
    (found.value(value), known)
}

/// What is known about a number.
pub(super) struct Known {
    /// Where it is taken, rad/s.
    pub(super) omega: Option<f64>,
    /// When it is taken, s.
    pub(super) time: Option<f64>,
    pub(super) tolerance: Option<f64>,
    /// Certified, computed, or why there is no number.
    pub(super) status: String,
}

impl Known {
    pub(super) fn failed(status: String) -> (f64, Self) {
        (
            f64::NAN,
            Self {
                omega: None,
                time: None,
                tolerance: None,
                status,
            },
        )
    }
}

fn rooted(norm: Norm, squared: f64) -> f64 {
    match norm {
        Norm::Variance => squared,
        Norm::H2 | Norm::Rms => squared.sqrt(),
    }
}

fn modal_value(
    linear: &Linear<'_>,
    statistic: Statistic,
    modal: Modal,
    oscillatory: bool,
) -> Result<f64, String> {
    let modes = linear.modes().map_err(|error| error.to_string())?;
    let counted = modes.modes.iter().filter(|mode| match mode.kind {
        ModeKind::Oscillatory => true,
        ModeKind::Real => !oscillatory,
        ModeKind::RigidBody => false,
    });
    let numbers = counted.map(|mode| match modal {
        Modal::DampingRatio => mode.damping_ratio,
        Modal::DecayRate => -mode.eigenvalue.re,
        Modal::Frequency => mode.eigenvalue.norm(),
    });
    match statistic {
        Statistic::Least => numbers.min_by(f64::total_cmp),
        Statistic::Largest => numbers.max_by(f64::total_cmp),
    }
    .ok_or_else(|| "no mode counts for this run".to_owned())
}
