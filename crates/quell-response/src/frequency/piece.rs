//! Local maxima with their exact gradients: the smooth pieces of which the largest value is made.

use num_complex::Complex64;

use super::{Plan, Scratch};
use crate::error::ResponseError;
use crate::receptance::eliminate;

/// A local maximum of |H| with its exact derivatives by every element value.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Piece {
    /// |H|.
    pub value: f64,
    /// Where, rad/s.
    pub omega: f64,
    /// d|H|/dvalue_i (envelope theorem: ω needs no derivative at a maximum or at an edge of the band).
    pub gradient: Vec<f64>,
}

impl Plan {
    /// All refined local maxima of |H| within `margin` (relative) of the largest, largest first, each with its exact gradient.
    ///
    /// # Errors
    /// Where `values` do not fit or an undamped mode lies on a maximum.
    pub fn pieces(
        &self,
        values: &[f64],
        margin: f64,
        scratch: &mut Scratch,
        pieces: &mut Vec<Piece>,
    ) -> Result<(), ResponseError> {
        self.assembly.check_values(values)?;
        let best = self.refine(values, margin, scratch);
        let mut refined = std::mem::take(&mut scratch.refined);
        refined.retain(|peak| peak.value >= best.value * (1.0 - margin));
        refined.sort_unstable_by(|a, b| b.value.total_cmp(&a.value));
        refined.dedup_by(|b, a| (b.omega - a.omega).abs() <= 1e-7 * a.omega);
        pieces.resize_with(refined.len(), Piece::default);
        let mut result = Ok(());
        for (peak, piece) in refined.iter().zip(pieces.iter_mut()) {
            piece.value = peak.value;
            piece.omega = peak.omega;
            piece.gradient.resize(self.assembly.elements, 0.0);
            result = self.gradient(values, peak.omega, scratch, &mut piece.gradient);
            if result.is_err() {
                break;
            }
        }
        scratch.refined = refined;
        result
    }

    /// d|H|/dvalue_i at one frequency.
    fn gradient(
        &self,
        values: &[f64],
        omega: f64,
        scratch: &mut Scratch,
        gradient: &mut [f64],
    ) -> Result<(), ResponseError> {
        let mut derivative = std::mem::take(&mut scratch.derivative);
        derivative.resize(self.assembly.elements, Complex64::ZERO);
        let response = if self.parts.is_empty() && !self.ports.is_empty() {
            self.device_gradient(values, omega, scratch, &mut derivative)
        } else {
            self.assembly.direct_terms(
                values,
                self.channel.input(),
                &self.terms,
                omega,
                Some(&mut derivative),
            )
        };
        let outcome = response.map(|response| {
            let size = response.norm();
            for (target, derivative) in gradient.iter_mut().zip(&derivative) {
                *target = if size > 0.0 {
                    (response.conj() * derivative).re / size
                } else {
                    0.0
                };
            }
        });
        scratch.derivative = derivative;
        outcome
    }

    /// dH/dvalue_i from dH/dD of each port and the networks' own gradients.
    fn device_gradient(
        &self,
        values: &[f64],
        omega: f64,
        scratch: &mut Scratch,
        derivative: &mut [Complex64],
    ) -> Result<Complex64, ResponseError> {
        let singular = || ResponseError::SingularAt {
            hz: omega / std::f64::consts::TAU,
        };
        let p = self.ports.len();
        if !self
            .channel
            .solve(omega, &mut scratch.work, &mut scratch.host)
        {
            return Err(singular());
        }
        // One sweep of every network gives N, Den and Den² dD/dvalue with one common factor.
        let mut pairs = std::mem::take(&mut scratch.pairs);
        pairs.resize(
            self.assembly.devices.len(),
            (Complex64::ZERO, Complex64::ONE),
        );
        for (device, pair) in self.assembly.devices.iter().zip(&mut pairs) {
            let place = device.first_value..device.first_value + device.network.elements().len();
            *pair = device.network.gradient_ratio(
                omega,
                device.values(values),
                &mut scratch.workspace,
                &mut derivative[place],
            );
        }
        let host = &scratch.host;
        let joint = |r: usize| {
            self.ports[r]
                .iter()
                .fold((Complex64::ZERO, Complex64::ONE), |(n, d), &index| {
                    let (own_n, own_d) = pairs[index];
                    (n * own_d + own_n * d, d * own_d)
                })
        };
        // A ξ = x0 and νᵀ A = wᵀ, A = diag(Den) + G diag(N - d Den); one factorisation each, p is small.
        let width = p + 1;
        let mut forward = vec![Complex64::ZERO; p * width];
        let mut adjoint = vec![Complex64::ZERO; p * width];
        for r in 0..p {
            let (n, d) = joint(r);
            let excess = n - host.nominal[r] * d;
            for q in 0..p {
                let entry = host.g[q * p + r] * excess + if q == r { d } else { Complex64::ZERO };
                forward[q * width + r] = entry;
                adjoint[r * width + q] = entry;
            }
            forward[r * width + p] = host.x0[r];
            adjoint[r * width + p] = n * self.gamma[r] - host.alpha[r] * excess;
        }
        let mut response = host.y0;
        for r in 0..p {
            response += adjoint[r * width + p] * Complex64::ZERO;
        }
        let output: Vec<Complex64> = (0..p).map(|r| adjoint[r * width + p]).collect();
        if eliminate(&mut forward, p, width).is_none()
            || eliminate(&mut adjoint, p, width).is_none()
        {
            return Err(singular());
        }
        for r in 0..p {
            response += output[r] * forward[r * width + p];
        }
        for r in 0..p {
            let back: Complex64 = (0..p)
                .map(|q| adjoint[q * width + p] * host.g[q * p + r])
                .sum();
            // dH/dD = ξ Den (γ - α - ν G); dD/dvalue = out/Den_device², and ξ = (..)/Den.
            let slope = forward[r * width + p] * (self.gamma[r] - host.alpha[r] - back);
            for &index in &self.ports[r] {
                let device = &self.assembly.devices[index];
                let others = self.ports[r]
                    .iter()
                    .filter(|&&other| other != index)
                    .fold(Complex64::ONE, |product, &other| product * pairs[other].1);
                let factor = slope * others / pairs[index].1;
                for entry in &mut derivative
                    [device.first_value..device.first_value + device.network.elements().len()]
                {
                    *entry *= factor;
                }
            }
        }
        scratch.pairs = pairs;
        if response.is_finite() && derivative.iter().all(|entry| entry.is_finite()) {
            Ok(response)
        } else {
            Err(singular())
        }
    }
}
