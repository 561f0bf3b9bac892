//! H2 norms and variances.
//!
//! ```text
//! ‖H‖₂² = (1/2π) ∫_{-∞}^{∞} |H(jω)|² dω,        variance = ∫_0^∞ S(f) |H(j 2π f)|² df
//! ```
//!
//! The first is two-sided (the variance for white noise of unit two-sided density); S is one-sided, per Hz.

use std::f64::consts::{PI, TAU};

use num_complex::Complex64;
use quell_model::linear::LinearForm;

use crate::assembly::Assembly;
use crate::dense::Dense;
use crate::eigen::balance;
use crate::error::ResponseError;
use crate::quadrature::{Integral, integrate};
use crate::realisation::Channel;
use crate::residues::Residues;

/// A one-sided spectral density (per Hz) as a function of ω (rad/s).
pub type Spectrum<'a> = dyn Fn(f64) -> f64 + Sync + 'a;

/// How a norm was computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum NormMethod {
    /// A Lyapunov equation, checked by quadrature and by partial fractions.
    LyapunovAndQuadrature,
    /// Quadrature alone (bands, spectra, loss factors, unseen undamped modes).
    Quadrature,
}

/// A squared norm or variance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Norm {
    /// ‖H‖² or the variance, in (output unit)² per (input unit)² times the unit of the integral.
    pub squared: f64,
    /// Estimate of its absolute error: the difference of the Lyapunov equation from the quadrature or (where that is
    /// nearer) from the sum over pairs of poles; else that of the quadrature.
    pub error_estimate: f64,
    /// How it was computed.
    pub method: NormMethod,
}

/// Relative tolerance of the quadrature.
const TOLERANCE: f64 = 1e-10;
/// A damping ratio below this counts as undamped.
const UNDAMPED: f64 = 1e-10;

/// Poles of a drift are at most this part of the largest: the root of what rounding makes of a double zero, and a little.
const DRIFT: f64 = 1e-6;

/// ‖H‖₂² over all frequencies or over a band (both signs of it), or the variance for a one-sided spectrum.
///
/// * without `spectrum`: (1/2π) ∫ |H|² dω over both signs of `band` (rad/s), or over all frequencies;
/// * with `spectrum`: ∫ S |H|² df over `band` or over all positive frequencies.
///
/// # Errors
/// Where values, input, signals or band do not fit, the system is unstable, an undamped mode is seen, or the integral
/// does not exist because the transfer function does not vanish at high frequency.
pub fn h2(
    assembly: &Assembly,
    values: &[f64],
    input: usize,
    form: &LinearForm,
    band: Option<(f64, f64)>,
    spectrum: Option<&Spectrum<'_>>,
) -> Result<Norm, ResponseError> {
    assembly.check_values(values)?;
    assembly.check_input(input)?;
    let terms = assembly.output_terms(form)?;
    let lossy = assembly.loss.is_some();
    let (residues, channel) = if lossy {
        let space =
            assembly.state_space(&assembly.structure, values, Complex64::ONE, Complex64::new)?;
        (
            Residues::new(&space.channel(assembly, values, input, &terms)?)?,
            None,
        )
    } else {
        let space = assembly.state_space(&assembly.structure, values, 1.0_f64, |k, _| k)?;
        let channel = space.channel(assembly, values, input, &terms)?;
        (Residues::new(&channel)?, Some(channel))
    };
    let response = Response {
        direct: &|omega| assembly.direct_terms(values, input, &terms, omega, None),
        residues,
        channel,
        lossy,
        drifts: false,
    };
    response.norm(band, spectrum)
}

/// A response of which norms are taken, whatever it is of.
pub(crate) struct Response<'a> {
    /// H(jω) by another way than the channel's eigenvectors.
    direct: &'a dyn Fn(f64) -> Result<Complex64, ResponseError>,
    residues: Option<Residues>,
    /// None with loss factors.
    channel: Option<Channel<f64>>,
    lossy: bool,
    /// Nothing pushes the output back: there are poles at zero, of which rounding makes small ones.
    drifts: bool,
}

impl<'a> Response<'a> {
    /// Of a channel, with another way to its response.
    pub(crate) fn new(
        channel: Channel<f64>,
        drifts: bool,
        direct: &'a dyn Fn(f64) -> Result<Complex64, ResponseError>,
    ) -> Result<Self, ResponseError> {
        Ok(Self {
            direct,
            residues: Residues::new(&channel)?,
            channel: Some(channel),
            lossy: false,
            drifts,
        })
    }

    /// As [`h2`].
    pub(crate) fn norm(
        &self,
        band: Option<(f64, f64)>,
        spectrum: Option<&Spectrum<'_>>,
    ) -> Result<Norm, ResponseError> {
        if let Some((from, to)) = band
            && !(from.is_finite() && to.is_finite() && from >= 0.0 && to > from)
        {
            return Err(ResponseError::Band { from, to });
        }
        let (residues, channel, lossy) =
            (self.residues.as_ref(), self.channel.as_ref(), self.lossy);
        let poles: Vec<Complex64> =
            residues.map_or_else(Vec::new, |residues| residues.poles.clone());
        let scale = poles.iter().map(|pole| pole.norm()).fold(0.0, f64::max);
        let seen: Vec<Complex64> = residues.map_or_else(
            || poles.clone(),
            |residues| residues.terms.iter().map(|term| term.0).collect(),
        );
        // Loss factors make poles of negative frequency look unstable: only ω > 0 has a meaning there.
        let zero = if self.drifts { DRIFT * scale } else { -1.0 };
        if self.drifts && band.is_none_or(|(from, _)| from <= zero) {
            return Err(ResponseError::Undamped { hz: 0.0 });
        }
        let relevant = |pole: &&Complex64| (!lossy || pole.im > 0.0) && pole.norm() > zero;
        for pole in seen.iter().filter(relevant) {
            let margin = UNDAMPED * pole.norm().max(1e-6 * scale);
            if pole.re > margin {
                return Err(ResponseError::Unstable {
                    real: pole.re,
                    imaginary: pole.im,
                });
            }
            let frequency = pole.im.abs();
            let inside = band.is_none_or(|(from, to)| frequency >= from && frequency <= to);
            if inside && pole.re > -margin {
                return Err(ResponseError::Undamped {
                    hz: frequency / TAU,
                });
            }
        }
        for pole in poles.iter().filter(relevant) {
            if pole.re > 1e-8 * pole.norm().max(1e-3 * scale) {
                return Err(ResponseError::Unstable {
                    real: pole.re,
                    imaginary: pole.im,
                });
            }
        }
        let direct = |omega: f64| {
            let response = match (self.direct)(omega) {
                // An unseen undamped mode exactly on a sample.
                Err(ResponseError::SingularAt { .. }) => (self.direct)(omega * (1.0 + 1e-9))?,
                other => other?,
            };
            let weight = match spectrum {
                None => 1.0,
                Some(spectrum) => {
                    let value = spectrum(omega);
                    if !(value.is_finite() && value >= 0.0) {
                        return Err(ResponseError::Spectrum {
                            hz: omega / TAU,
                            value,
                        });
                    }
                    value
                }
            };
            Ok(response.norm_sqr() * weight)
        };
        let resonances: Vec<Complex64> = poles
            .iter()
            .copied()
            .filter(|pole| pole.im >= 0.0)
            .collect();
        // Two-sided without a spectrum: (1/2π) 2 ∫; with one: ∫ df = (1/2π) ∫ dω.
        let factor = if spectrum.is_some() {
            1.0 / TAU
        } else {
            1.0 / PI
        };
        let integral = if let Some((from, to)) = band {
            let low = from.max(if from == 0.0 { 1e-12 * to } else { from });
            integrate(&breakpoints(&resonances, low, to), TOLERANCE, 4000, direct)?
        } else {
            let high = if scale > 0.0 { 4.0 * scale } else { 1.0 };
            proper(residues, channel, spectrum, high, &direct)?;
            let least = resonances
                .iter()
                .map(|pole| pole.norm())
                .filter(|size| *size > 0.0)
                .fold(high, f64::min);
            let mut breaks = breakpoints(&resonances, 1e-9 * least, high);
            breaks.insert(0, 0.0);
            let below: Integral = integrate(&breaks, TOLERANCE, 4000, |omega| {
                direct(omega.max(1e-12 * least))
            })?;
            // ω = high/t on the tail.
            let above = integrate(&[0.0, 0.1, 1.0], TOLERANCE, 500, |t: f64| {
                Ok(direct(high / t)? * high / (t * t))
            })?;
            Integral {
                value: below.value + above.value,
                error: below.error + above.error,
            }
        };
        let quadrature = Norm {
            squared: factor * integral.value,
            error_estimate: factor * integral.error,
            method: NormMethod::Quadrature,
        };
        let all_damped = poles.iter().all(|pole| pole.re < -UNDAMPED * pole.norm());
        if band.is_none()
            && spectrum.is_none()
            && all_damped
            && let Some(channel) = channel
            && let Some(squared) = lyapunov(channel)
        {
            // Near a hardly damped mode that the output hardly sees, samples of the stamped system are noise: the sum over
            // pairs of poles is then the second opinion.
            let by_poles = residues.map_or(f64::INFINITY, |residues| {
                (squared - pole_sum(residues)).abs()
            });
            let difference = (squared - quadrature.squared).abs().min(by_poles);
            let error_estimate = difference.max(4.0 * f64::EPSILON * squared);
            return Ok(Norm {
                squared,
                error_estimate,
                method: NormMethod::LyapunovAndQuadrature,
            });
        }
        Ok(quadrature)
    }
}

/// ‖H‖₂² over all frequencies by the Lyapunov equation alone, for search loops; [`h2`] checks it.
///
/// # Errors
/// As [`h2`]; undamped modes are errors even where the output does not see them.
pub fn h2_fast(
    assembly: &Assembly,
    values: &[f64],
    input: usize,
    form: &LinearForm,
) -> Result<f64, ResponseError> {
    assembly.check_values(values)?;
    assembly.check_input(input)?;
    assembly.no_loss("a norm by the Lyapunov equation")?;
    let terms = assembly.output_terms(form)?;
    let space = assembly.state_space(&assembly.structure, values, 1.0_f64, |k, _| k)?;
    white(&space.channel(assembly, values, input, &terms)?)
}

/// [`h2_fast`] of a channel.
pub(crate) fn white(channel: &Channel<f64>) -> Result<f64, ResponseError> {
    let size = channel.a.norm();
    let reference = channel
        .response(size)
        .map_or(0.0, Complex64::norm)
        .max(channel.response(0.1 * size).map_or(0.0, Complex64::norm));
    let mut power = 1.0;
    for (k, &d) in channel.d.iter().enumerate() {
        // Feedthrough that is left by cancellation is a rounding error of what cancels.
        if d.abs() * power > 1e-6 * reference {
            return Err(not_proper(d, k));
        }
        power *= size;
    }
    lyapunov(channel)
        .ok_or(ResponseError::Undamped { hz: 0.0 })
        .or_else(|error| {
            // Only now find out which mode it is.
            let poles = crate::eigen::eigenvalues(&channel.a)?;
            let worst = poles
                .into_iter()
                .max_by(|a, b| (a.re / a.norm()).total_cmp(&(b.re / b.norm())));
            Err(worst.map_or(error, |pole| {
                if pole.re > 1e-9 * pole.norm() {
                    ResponseError::Unstable {
                        real: pole.re,
                        imaginary: pole.im,
                    }
                } else {
                    ResponseError::Undamped {
                        hz: pole.im.abs() / TAU,
                    }
                }
            }))
        })
}

fn not_proper(limit: f64, power: usize) -> ResponseError {
    ResponseError::NotStrictlyProper {
        limit,
        growing: if power > 0 {
            " times a power of the frequency"
        } else {
            ""
        },
    }
}

/// -Σ r_i conj(r_k)/(λ_i + conj λ_k), the norm by partial fractions.
fn pole_sum(residues: &Residues) -> f64 {
    let mut sum = Complex64::ZERO;
    for (pole, residue) in &residues.terms {
        for (other, other_residue) in &residues.terms {
            sum -= residue * other_residue.conj() / (pole + other.conj());
        }
    }
    sum.re
}

/// Refuses integrals that do not exist.
fn proper(
    residues: Option<&Residues>,
    channel: Option<&Channel<f64>>,
    spectrum: Option<&Spectrum<'_>>,
    high: f64,
    integrand: &impl Fn(f64) -> Result<f64, ResponseError>,
) -> Result<(), ResponseError> {
    // ω |H|² S must fall: far above all poles it is a power of ω.
    let far = [1e3, 1e5].map(|factor| factor * high);
    let size = [integrand(far[0])? * far[0], integrand(far[1])? * far[1]];
    if size[1] > 0.3 * size[0] {
        if spectrum.is_none() {
            let polynomial = residues
                .map(|residues| {
                    residues
                        .polynomial
                        .iter()
                        .map(|d| d.norm())
                        .collect::<Vec<f64>>()
                })
                .or_else(|| channel.map(|channel| channel.d.iter().map(|d| d.abs()).collect()))
                .unwrap_or_default();
            let power = (0..polynomial.len())
                .rev()
                .find(|&k| polynomial[k] * far[1].powf(k as f64) > 1e-9)
                .unwrap_or(0);
            let limit = if power == 0 {
                integrand(far[1])?.sqrt()
            } else {
                polynomial[power]
            };
            return Err(not_proper(limit, power));
        }
        return Err(not_proper(integrand(far[1])?.sqrt(), 0));
    }
    Ok(())
}

/// Breakpoints at the resonances and a few widths beside them.
fn breakpoints(resonances: &[Complex64], low: f64, high: f64) -> Vec<f64> {
    let mut breaks = vec![low, high];
    for pole in resonances {
        for offset in [-8.0, -1.0, 0.0, 1.0, 8.0] {
            breaks.push(pole.im + offset * pole.re.abs());
        }
        breaks.push(pole.norm());
    }
    // Decades, because a linear subdivision would crawl towards zero.
    let mut decade = high / 10.0;
    while decade > low && breaks.len() < 400 {
        breaks.push(decade);
        decade /= 10.0;
    }
    breaks.retain(|omega| omega.is_finite() && *omega >= low && *omega <= high);
    breaks.sort_by(f64::total_cmp);
    breaks.dedup_by(|b, a| *b - *a <= 1e-12 * b.abs());
    breaks
}

/// c X cᵀ with A X + X Aᵀ + b bᵀ = 0, by the doubling iteration after a Cayley transformation; `None` where it does not converge.
///
/// X is a sum of positive semi-definite terms, so nothing cancels (R. A. Smith, 1968).
fn lyapunov(channel: &Channel<f64>) -> Option<f64> {
    let n = channel.a.rows();
    if n == 0 {
        return Some(0.0);
    }
    let (a, scale) = balance(&channel.a);
    let norm = a.norm();
    let inverse_norm = 1.0 / a.lu()?.inverse().norm();
    let shift = (norm * inverse_norm).sqrt();
    if !(shift > 0.0 && shift.is_finite()) {
        return None;
    }
    let shifted = |sign: f64| {
        Dense::from_fn(n, n, |i, j| {
            sign * a.get(i, j) + if i == j { shift } else { 0.0 }
        })
    };
    let lu = shifted(-1.0).lu()?;
    let mut step = lu.solve(&shifted(1.0));
    let b = lu
        .solve(&Dense::from_fn(n, 1, |i, _| channel.b[i] / scale[i]))
        .scale((2.0 * shift).sqrt());
    let mut x = b.times(&b.transpose());
    let c = Dense::from_fn(1, n, |_, j| channel.c[j] * scale[j]);
    let value = |x: &Dense<f64>| c.times(x).times(&c.transpose()).get(0, 0);
    for _ in 0..70 {
        let added = step.times(&x).times(&step.transpose());
        x = x.plus(&added);
        step = step.times(&step);
        let size = step.norm();
        if !(size.is_finite() && size < 1e8) {
            return None;
        }
        if size < 1e-12 {
            return Some(value(&x)).filter(|value| value.is_finite() && *value >= 0.0);
        }
    }
    None
}
