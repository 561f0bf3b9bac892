//! A bound of max |H(jω)| over a band that owes nothing to a grid.
//!
//! On an interval [m - h, m + h] with B3 ≥ |H'''| the Taylor bounds B2 = |H''(m)| + h B3, B1 = |H'(m)| + h B2,
//! B0 = |H(m)| + h |H'(m)| + h² B2/2 give for g = |H|²
//!
//! ```text
//! g(m + t) ≤ g(m) + |g'(m)| h + (B1² + B0 B2) h²
//! ```
//!
//! and intervals are halved until this is below γ² (1 + tolerance)², γ being the largest value found. B3 comes from the
//! distances to the poles (partial fractions) or, where eigenvectors are useless, from the resolvent's norm.

use num_complex::Complex64;
use quell_model::linear::LinearForm;

use crate::assembly::Assembly;
use crate::eigen::Decompose;
use crate::error::ResponseError;
use crate::frequency::checked_band;
use crate::realisation::Channel;
use crate::residues::{Residues, Resolvent};

/// How the third derivative was bounded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CertificateMethod {
    /// Partial fractions: distances to the poles.
    PartialFractions,
    /// The norm of the resolvent, where the eigenvectors are (nearly) defective.
    Resolvent,
}

/// Whether the bound holds.
#[derive(Debug, Clone, PartialEq)]
pub enum CertificateStatus {
    /// No value over the band exceeds `upper_bound`, and that is within the tolerance asked for.
    Certified,
    /// The value is the best that was found; the reason says why no bound within the tolerance could be given.
    NotCertified {
        /// Why, in words.
        reason: String,
    },
}

/// The largest value of |H(jω)| over a band, with a bound.
#[derive(Debug, Clone, PartialEq)]
pub struct Certificate {
    /// The largest |H| found, evaluated on the stamped nodal system.
    pub value: f64,
    /// Where, rad/s.
    pub omega: f64,
    /// No |H| over the band is larger; includes the difference between the two ways of evaluating H. Infinite where no bound was found.
    pub upper_bound: f64,
    /// upper bound / value - 1.
    pub achieved_tolerance: f64,
    /// How the bound was found.
    pub method: CertificateMethod,
    /// Whether it holds within the tolerance asked for.
    pub status: CertificateStatus,
    /// Number of intervals that were looked at.
    pub intervals: usize,
}

const MOST_INTERVALS: usize = 200_000;

/// Bounds max |H(jω)| over `band` (rad/s) within `tolerance` (relative, 1e-12 … 1), independently of [`crate::Plan`].
///
/// A band that starts at zero is taken from 1e-6 of its upper edge, as a plan does.
///
/// # Errors
/// Where values, input, signals, band or tolerance do not fit, or the system cannot be realised.
///
/// # References
/// The subdivision is the classical branch and bound on a Lipschitz constant; for the alternative by Hamiltonian level
/// sets see S. Boyd and V. Balakrishnan, 1990, and N. A. Bruinsma and M. Steinbuch, 1990.
pub fn certify(
    assembly: &Assembly,
    values: &[f64],
    input: usize,
    form: &LinearForm,
    band: (f64, f64),
    tolerance: f64,
) -> Result<Certificate, ResponseError> {
    assembly.check_values(values)?;
    assembly.check_input(input)?;
    let terms = assembly.output_terms(form)?;
    let direct = |omega: f64| assembly.direct_terms(values, input, &terms, omega, None);
    let bound = Bound::new(&direct, band, tolerance)?;
    if assembly.loss.is_some() {
        let space =
            assembly.state_space(&assembly.structure, values, Complex64::ONE, Complex64::new)?;
        bound.run(&space.channel(assembly, values, input, &terms)?)
    } else {
        let space = assembly.state_space(&assembly.structure, values, 1.0_f64, |k, _| k)?;
        bound.run(&space.channel(assembly, values, input, &terms)?)
    }
}

/// The search for a bound, whatever the response is of.
pub(crate) struct Bound<'a> {
    /// H(jω) by another way than the channel's eigenvectors.
    direct: &'a dyn Fn(f64) -> Result<Complex64, ResponseError>,
    band: (f64, f64),
    tolerance: f64,
}

/// Outcome of the subdivision.
struct Bounded {
    gamma: f64,
    omega: f64,
    upper: f64,
    intervals: usize,
    failure: Option<f64>,
}

impl<'a> Bound<'a> {
    /// Checks band and tolerance.
    pub(crate) fn new(
        direct: &'a dyn Fn(f64) -> Result<Complex64, ResponseError>,
        band: (f64, f64),
        tolerance: f64,
    ) -> Result<Self, ResponseError> {
        let band = checked_band(band)?;
        if !(1e-12..1.0).contains(&tolerance) {
            return Err(ResponseError::Setting {
                name: "tolerance",
                value: tolerance,
                range: "from 1e-12 to 1",
            });
        }
        Ok(Self {
            direct,
            band,
            tolerance,
        })
    }

    pub(crate) fn run<T: Decompose>(
        &self,
        channel: &Channel<T>,
    ) -> Result<Certificate, ResponseError> {
        let residues = Residues::new(channel)?;
        let breaks = self.breaks(residues.as_ref());
        let mut method = CertificateMethod::PartialFractions;
        let mut outcome = None;
        if let Some(residues) = &residues {
            let bounded =
                self.subdivide(&breaks, |m, h| Some((residues.at(m), residues.third(m, h))));
            let difference =
                self.difference(&breaks, bounded.omega, |omega| Some(residues.at(omega)[0]))?;
            if difference <= 0.25 * self.tolerance * bounded.gamma && bounded.failure.is_none() {
                outcome = Some((bounded, difference));
            } else if bounded.failure.is_some() && difference <= 1e-6 * bounded.gamma {
                return self.finish(method, &bounded, difference);
            }
        }
        let (bounded, difference) = if let Some(outcome) = outcome {
            outcome
        } else {
            method = CertificateMethod::Resolvent;
            let resolvent = Resolvent::new(channel);
            let bounded = self.subdivide(&breaks, |m, h| resolvent.at(m, h));
            let difference = self.difference(&breaks, bounded.omega, |omega| {
                resolvent.at(omega, 0.0).map(|h| h.0[0])
            })?;
            (bounded, difference)
        };
        self.finish(method, &bounded, difference)
    }

    fn finish(
        &self,
        method: CertificateMethod,
        bounded: &Bounded,
        difference: f64,
    ) -> Result<Certificate, ResponseError> {
        let value = match (self.direct)(bounded.omega) {
            Ok(response) => response.norm(),
            Err(ResponseError::SingularAt { .. }) => f64::INFINITY,
            Err(error) => return Err(error),
        };
        let upper_bound = bounded.upper.max(bounded.gamma).max(value) + 2.0 * difference;
        let achieved_tolerance = if value > 0.0 {
            upper_bound / value - 1.0
        } else {
            0.0
        };
        let status = if let Some(omega) = bounded.failure {
            CertificateStatus::NotCertified {
                reason: format!(
                    "the response could not be bounded near {} Hz, where a mode is undamped or nearly so",
                    omega / std::f64::consts::TAU
                ),
            }
        } else if achieved_tolerance <= self.tolerance * 1.5 + 1e-12 {
            CertificateStatus::Certified
        } else {
            CertificateStatus::NotCertified {
                reason: format!(
                    "two ways of evaluating the response differ by {difference:e}, more than the tolerance {:e} allows",
                    self.tolerance
                ),
            }
        };
        let upper_bound = if bounded.failure.is_some() {
            f64::INFINITY
        } else {
            upper_bound
        };
        let achieved_tolerance = if bounded.failure.is_some() {
            f64::INFINITY
        } else {
            achieved_tolerance
        };
        Ok(Certificate {
            value,
            omega: bounded.omega,
            upper_bound,
            achieved_tolerance,
            method,
            status,
            intervals: bounded.intervals,
        })
    }

    /// Edges, resonances and a few frequencies between them.
    fn breaks(&self, residues: Option<&Residues>) -> Vec<f64> {
        let (low, high) = self.band;
        let mut breaks = vec![low, high];
        for k in 1..16 {
            let share = f64::from(k) / 16.0;
            breaks.push(low + share * (high - low));
            breaks.push(low * (high / low).powf(share));
        }
        if let Some(residues) = residues {
            breaks.extend(residues.poles.iter().map(|pole| pole.im.abs()));
        }
        breaks.retain(|omega| *omega >= low && *omega <= high);
        breaks.sort_by(f64::total_cmp);
        breaks.dedup_by(|b, a| *b - *a <= 1e-9 * *b);
        if let Some(last) = breaks.last_mut() {
            *last = high;
        }
        breaks
    }

    /// The largest difference between the model and the stamped system, at breaks and midpoints.
    fn difference(
        &self,
        breaks: &[f64],
        peak: f64,
        model: impl Fn(f64) -> Option<Complex64>,
    ) -> Result<f64, ResponseError> {
        let mut largest = 0.0_f64;
        let middles = breaks.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
        for omega in breaks.iter().copied().chain(middles).chain([peak]) {
            match (self.direct)(omega) {
                Ok(response) => {
                    let Some(value) = model(omega) else {
                        return Ok(f64::INFINITY);
                    };
                    let difference = (response - value).norm();
                    largest = if difference.is_nan() {
                        f64::INFINITY
                    } else {
                        largest.max(difference)
                    };
                }
                Err(ResponseError::SingularAt { .. }) => {}
                Err(error) => return Err(error),
            }
        }
        Ok(largest)
    }

    fn subdivide(
        &self,
        breaks: &[f64],
        model: impl Fn(f64, f64) -> Option<([Complex64; 3], f64)>,
    ) -> Bounded {
        let value = |omega: f64| model(omega, 0.0).map_or(f64::NAN, |h| h.0[0].norm_sqr());
        let mut best = (0.0_f64, self.band.0);
        for &omega in breaks {
            let square = value(omega);
            if square > best.0 {
                best = (square, omega);
            }
        }
        best = self.polish(best, &model);
        let mut upper = best.0;
        let mut intervals = 0;
        let mut failure = None;
        let mut stack: Vec<(f64, f64)> = breaks
            .windows(2)
            .rev()
            .map(|pair| (pair[0], pair[1]))
            .collect();
        // Half of the tolerance is left to the difference between the ways of evaluating H.
        let slack = (1.0 + 0.5 * self.tolerance).powi(2);
        while let Some((from, to)) = stack.pop() {
            intervals += 1;
            let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
            let Some((h, third)) = model(middle, half) else {
                failure = failure.or(Some(middle));
                continue;
            };
            let square = h[0].norm_sqr();
            if square > best.0 {
                best = self.polish((square, middle), &model);
            }
            let (h0, h1, h2) = (square.sqrt(), h[1].norm(), h[2].norm());
            let b2 = h2 + half * third;
            let b1 = h1 + half * b2;
            let b0 = h0 + half * h1 + 0.5 * half * half * b2;
            let slope = 2.0 * (h[0].conj() * h[1]).re;
            let bound = square + slope.abs() * half + (b1 * b1 + b0 * b2) * half * half;
            if bound <= best.0 * slack {
                upper = upper.max(bound);
            } else if half <= 1e-13 * middle || intervals > MOST_INTERVALS {
                failure = failure.or(Some(middle));
                if intervals > MOST_INTERVALS {
                    break;
                }
            } else {
                stack.push((middle, to));
                stack.push((from, middle));
            }
        }
        Bounded {
            gamma: best.0.sqrt(),
            omega: best.1,
            upper: upper.sqrt(),
            intervals,
            failure,
        }
    }

    /// Newton steps uphill on |H|² within the band.
    fn polish(
        &self,
        start: (f64, f64),
        model: &impl Fn(f64, f64) -> Option<([Complex64; 3], f64)>,
    ) -> (f64, f64) {
        let mut best = start;
        let mut omega = start.1;
        let mut reach = 0.05 * omega;
        for _ in 0..30 {
            let Some((h, _)) = model(omega, 0.0) else {
                break;
            };
            let square = h[0].norm_sqr();
            if square > best.0 {
                best = (square, omega);
            }
            let slope = 2.0 * (h[0].conj() * h[1]).re;
            let curvature = 2.0 * (h[1].norm_sqr() + (h[0].conj() * h[2]).re);
            // 1/|H|² is nearly a parabola near a resonance: Newton's step for it.
            let inverse_curvature = 2.0 * slope * slope / square - curvature;
            let step = if inverse_curvature > 0.0 {
                slope / inverse_curvature
            } else {
                reach * slope.signum()
            };
            let step = step.clamp(-reach, reach);
            let next = (omega + step).clamp(self.band.0, self.band.1);
            if !next.is_finite() || (next - omega).abs() <= 1e-15 * omega {
                break;
            }
            let gained = model(next, 0.0).map_or(f64::NAN, |h| h.0[0].norm_sqr());
            if gained >= square {
                omega = next;
                if gained > best.0 {
                    best = (gained, next);
                }
            } else {
                reach = 0.25 * step.abs();
                if reach <= 1e-15 * omega {
                    break;
                }
            }
        }
        best
    }
}
