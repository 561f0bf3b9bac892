//! Evaluation of a plan: H at one frequency and |H|² over the grid.

use num_complex::Complex64;
use quell_network::{PartShare, RatioGrid};

use super::bilinear::{Constants, bilinear_sweep, combine};
use super::{Plan, Scratch};
use crate::assembly::powers_of;
use crate::receptance::{HostPoint, eliminate};

impl Plan {
    /// H(jω) at any frequencies (rad/s, positive) of the band or outside of it; not-a-number where values do not fit.
    pub fn response(&self, values: &[f64], omegas: &[f64]) -> Vec<Complex64> {
        let mut scratch = Scratch::new();
        omegas
            .iter()
            .map(|&omega| self.evaluate(values, omega, &mut scratch))
            .collect()
    }

    /// H(jω) at one frequency, rad/s, without allocation.
    pub fn evaluate(&self, values: &[f64], omega: f64, scratch: &mut Scratch) -> Complex64 {
        self.evaluate_with_factor(values, omega, scratch).0
    }

    /// H(jω) and the characteristic factor whose zeros are the poles.
    pub(super) fn evaluate_with_factor(
        &self,
        values: &[f64],
        omega: f64,
        scratch: &mut Scratch,
    ) -> (Complex64, Complex64) {
        if values.len() != self.assembly.elements
            || !self
                .channel
                .solve(omega, &mut scratch.work, &mut scratch.host)
        {
            let nothing = Complex64::new(f64::NAN, f64::NAN);
            return (nothing, nothing);
        }
        if self.single() {
            let constants = Constants::new(&scratch.host, self.gamma[0]);
            let (numerator, denominator, parts) = self.port_pair(0, values, omega, scratch);
            let top = constants.a * numerator + constants.b * denominator + parts * constants.x0;
            let factor = constants.c * numerator + constants.e * denominator;
            return (top / factor, factor);
        }
        let host = std::mem::take(&mut scratch.host);
        let response = self.coupled(&host, values, omega, scratch);
        scratch.host = host;
        response
    }

    /// N, Den of all devices on a used port, and the part terms' factor of x/Den.
    fn port_pair(
        &self,
        port: usize,
        values: &[f64],
        omega: f64,
        scratch: &mut Scratch,
    ) -> (Complex64, Complex64, Complex64) {
        let (mut numerator, mut denominator) = (Complex64::ZERO, Complex64::ONE);
        let mut watched = Complex64::ZERO;
        for &index in &self.ports[port] {
            let device = &self.assembly.devices[index];
            let own = device.values(values);
            let (mut n, mut d) = (Complex64::ZERO, Complex64::ONE);
            let mut from_parts = Complex64::ZERO;
            let mut shared = false;
            for term in self.parts.iter().filter(|term| term.device == index) {
                scratch.shares.resize(1, PartShare::default());
                device.network.part_shares(
                    &[term.part],
                    omega,
                    own,
                    &mut scratch.workspace,
                    &mut scratch.shares,
                );
                let share = scratch.shares[0];
                let amount = if term.force {
                    share.force
                } else {
                    share.stroke
                };
                from_parts += amount * powers_of(omega, term.order) * term.coefficient;
                (n, d, shared) = (share.numerator, share.denominator, true);
            }
            if !shared {
                (n, d) = device.network.ratio(omega, own);
            }
            watched = watched * d + from_parts * denominator;
            numerator = numerator * d + n * denominator;
            denominator *= d;
        }
        (numerator, denominator, watched)
    }

    /// H with any number of ports; also the characteristic factor (a determinant).
    fn coupled(
        &self,
        host: &HostPoint,
        values: &[f64],
        omega: f64,
        scratch: &mut Scratch,
    ) -> (Complex64, Complex64) {
        let p = self.ports.len();
        if p == 0 {
            return (host.y0, Complex64::ONE);
        }
        let width = p + 1;
        let mut small = std::mem::take(&mut scratch.small);
        let mut pairs = std::mem::take(&mut scratch.pairs);
        small.resize(p * width, Complex64::ZERO);
        pairs.resize(2 * p, (Complex64::ZERO, Complex64::ZERO));
        for r in 0..p {
            let (n, d, watched) = self.port_pair(r, values, omega, scratch);
            let excess = n - host.nominal[r] * d;
            // Row over ξ = x/Den of this port's output.
            pairs[r] = (
                watched + n * self.gamma[r] - host.alpha[r] * excess,
                Complex64::ZERO,
            );
            for q in 0..p {
                small[q * width + r] =
                    host.g[q * p + r] * excess + if q == r { d } else { Complex64::ZERO };
            }
        }
        for r in 0..p {
            small[r * width + p] = host.x0[r];
        }
        let determinant = eliminate(&mut small, p, width);
        let mut response = host.y0;
        for r in 0..p {
            response += pairs[r].0 * small[r * width + p];
        }
        if determinant.is_none() {
            response = Complex64::new(f64::INFINITY, 0.0);
        }
        scratch.small = small;
        scratch.pairs = pairs;
        (response, determinant.unwrap_or(Complex64::ZERO))
    }

    /// Fills |H|² (and for one port the characteristic factor) over the grid.
    pub(super) fn sweep(&self, values: &[f64], scratch: &mut Scratch) {
        let count = self.omegas.len();
        scratch.square.resize(count, 0.0);
        for list in &mut scratch.factor {
            list.resize(count, 0.0);
        }
        if !self.single() || !self.parts.is_empty() {
            for i in 0..count {
                let omega = self.omegas[i];
                let (response, factor) = if self.single() {
                    let b = &self.bilinear;
                    let at = |list: &[Vec<f64>; 2]| Complex64::new(list[0][i], list[1][i]);
                    let (n, d, parts) = self.port_pair(0, values, omega, scratch);
                    let factor = at(&b.c) * n + at(&b.e) * d;
                    (
                        (at(&b.a) * n + at(&b.b) * d + parts * b.x0[i]) / factor,
                        factor,
                    )
                } else {
                    self.coupled(&self.points[i], values, omega, scratch)
                };
                scratch.square[i] = finite_square(response.norm_sqr());
                scratch.factor[0][i] = factor.re;
                scratch.factor[1][i] = factor.im;
            }
            return;
        }
        let devices = &self.ports[0];
        scratch.grids.resize_with(devices.len(), RatioGrid::new);
        for (&index, grid) in devices.iter().zip(&mut scratch.grids) {
            let device = &self.assembly.devices[index];
            device.network.ratio_grid(
                &self.omegas,
                device.values(values),
                &mut scratch.workspace,
                grid,
            );
        }
        if devices.len() > 1 {
            combine(&scratch.grids, &mut scratch.combined);
            let [nr, ni, dr, di] = &scratch.combined;
            bilinear_sweep(
                &self.bilinear,
                [nr, ni, dr, di],
                &mut scratch.square,
                &mut scratch.factor,
            );
        } else if let Some(grid) = scratch.grids.first() {
            let lists = [
                &grid.numerator_re[..],
                &grid.numerator_im,
                &grid.denominator_re,
                &grid.denominator_im,
            ];
            bilinear_sweep(
                &self.bilinear,
                lists,
                &mut scratch.square,
                &mut scratch.factor,
            );
        }
        for value in &mut scratch.square {
            *value = finite_square(*value);
        }
    }
}

/// |H|², taken as infinite where it is not a number.
#[inline]
pub(super) fn finite_square(value: f64) -> f64 {
    if value.is_nan() { f64::INFINITY } else { value }
}
