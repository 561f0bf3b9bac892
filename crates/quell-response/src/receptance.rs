//! Receptances of a host that carries a nominal dissipative device on every used port.
//!
//! The bare host alone would be singular at its modes (undamped hosts) or at rest (free hosts). With a nominal dynamic
//! stiffness d = (1 + j) κ(ω) at port p the matrix is regular at all frequencies, and a device D enters as D - d:
//!
//! ```text
//! x = x0 - G (D - d) x,      y = y0 - α (D - d) x + γ D x
//! ```

use num_complex::Complex64;

use crate::assembly::{Assembly, OutputTerm, powers, powers_of};
use crate::error::ResponseError;

/// What one frequency of the host needs: all by one factorisation of the host with nominal devices.
#[derive(Debug, Clone, Default)]
pub(crate) struct HostPoint {
    /// Output with the nominal devices.
    pub(crate) y0: Complex64,
    /// Displacement of every used port.
    pub(crate) x0: Vec<Complex64>,
    /// Output for a unit force on every used port.
    pub(crate) alpha: Vec<Complex64>,
    /// Displacement of port p (row) for a unit force on port r.
    pub(crate) g: Vec<Complex64>,
    /// The nominal dynamic stiffnesses.
    pub(crate) nominal: Vec<Complex64>,
}

/// The host's part of a transfer function.
#[derive(Debug, Clone)]
pub(crate) struct HostChannel {
    n: usize,
    input: usize,
    integrations: usize,
    /// Used ports: h and the factor of the input.
    ports: Vec<(Vec<f64>, f64)>,
    /// Output on coordinates: (order, index, coefficient).
    coordinates: Vec<(usize, usize, f64)>,
    /// Output directly from the input: (order, coefficient).
    direct: Vec<(usize, f64)>,
    mass: Vec<f64>,
    damping: Vec<f64>,
    stiffness: Vec<f64>,
    loss: Vec<f64>,
    forcing: [Vec<f64>; 3],
}

impl HostChannel {
    /// `terms` are those that involve neither device forces nor internal nodes.
    pub(crate) fn new(
        assembly: &Assembly,
        input: usize,
        ports: &[usize],
        terms: &[OutputTerm],
    ) -> Self {
        let n = assembly.host.coordinates.len();
        let zero = vec![0.0; n * n];
        let mut coordinates = Vec::new();
        let mut direct = Vec::new();
        for term in terms {
            for &(index, factor) in &term.row.coordinates {
                coordinates.push((term.order, index, factor * term.coefficient));
            }
            let from_input = term.row.input(input) * term.coefficient;
            if from_input != 0.0 {
                direct.push((term.order, from_input));
            }
        }
        let ports = ports
            .iter()
            .map(|&port| {
                let row = assembly.port_row(port);
                let mut dense = vec![0.0; n];
                for &(index, value) in &row.coordinates {
                    dense[index] += value;
                }
                (dense, row.input(input))
            })
            .collect();
        Self {
            n,
            input,
            integrations: assembly.host.inputs[input].kind.integrations(),
            ports,
            coordinates,
            direct,
            mass: assembly.mass.data().to_vec(),
            damping: assembly.damping.data().to_vec(),
            stiffness: assembly.stiffness.data().to_vec(),
            loss: assembly
                .loss
                .as_ref()
                .map_or(zero, |loss| loss.data().to_vec()),
            forcing: [0, 1, 2].map(|k| {
                (0..n)
                    .map(|i| assembly.forcing[k].get(i, input))
                    .collect::<Vec<f64>>()
            }),
        }
    }

    /// Index of the input, for messages.
    pub(crate) fn input(&self) -> usize {
        self.input
    }

    /// κ: the harmonic mean of the host's diagonal stiffnesses as the port sees them, so that d G is of order one.
    fn nominal(&self, port: &[f64], omega: f64) -> f64 {
        let mut compliance = 0.0;
        for (i, &h) in port.iter().enumerate() {
            let at = i * self.n + i;
            let diagonal = self.stiffness[at].abs()
                + self.loss[at].abs()
                + omega * self.damping[at].abs()
                + omega * omega * self.mass[at].abs();
            if diagonal > 0.0 {
                compliance += h * h / diagonal;
            }
        }
        if compliance > 0.0 {
            1.0 / compliance
        } else {
            1.0
        }
    }

    /// Fills `point`; false where the matrix is singular. Nothing is allocated once the buffers have their size.
    pub(crate) fn solve(
        &self,
        omega: f64,
        work: &mut Vec<Complex64>,
        point: &mut HostPoint,
    ) -> bool {
        let (n, p) = (self.n, self.ports.len());
        let width = n + 1 + p;
        work.resize(n * width, Complex64::ZERO);
        point.x0.resize(p, Complex64::ZERO);
        point.alpha.resize(p, Complex64::ZERO);
        point.g.resize(p * p, Complex64::ZERO);
        point.nominal.resize(p, Complex64::ZERO);
        let powers = powers(omega);
        let square = omega * omega;
        for i in 0..n {
            let row = &mut work[i * width..(i + 1) * width];
            for j in 0..n {
                let at = i * n + j;
                row[j] = Complex64::new(
                    self.stiffness[at] - square * self.mass[at],
                    omega * self.damping[at] + self.loss[at],
                );
            }
            row[n] = Complex64::new(
                self.forcing[0][i] - square * self.forcing[2][i],
                omega * self.forcing[1][i],
            );
        }
        for (r, (port, from_input)) in self.ports.iter().enumerate() {
            let kappa = self.nominal(port, omega);
            let nominal = Complex64::new(kappa, kappa);
            point.nominal[r] = nominal;
            for i in 0..n {
                let row = &mut work[i * width..(i + 1) * width];
                row[n + 1 + r] = Complex64::new(port[i], 0.0);
                if port[i] != 0.0 {
                    for j in 0..n {
                        row[j] += nominal * (port[i] * port[j]);
                    }
                    row[n] -= nominal * (port[i] * from_input);
                }
            }
        }
        if eliminate(work, n, width).is_none() {
            return false;
        }
        let integrated = Complex64::ONE / powers_of(omega, self.integrations);
        let displacement = |work: &[Complex64], port: &[f64], column: usize| -> Complex64 {
            port.iter()
                .enumerate()
                .map(|(i, &h)| work[i * width + column] * h)
                .sum()
        };
        for (r, (port, from_input)) in self.ports.iter().enumerate() {
            point.x0[r] = (displacement(work, port, n) + from_input) * integrated;
            for c in 0..p {
                point.g[r * p + c] = displacement(work, port, n + 1 + c);
            }
        }
        let output = |work: &[Complex64], column: usize| -> Complex64 {
            self.coordinates
                .iter()
                .map(|&(order, index, factor)| {
                    powers[order] * work[index * width + column] * factor
                })
                .sum()
        };
        let direct: Complex64 = self
            .direct
            .iter()
            .map(|&(order, factor)| powers[order] * factor)
            .sum();
        point.y0 = (output(work, n) + direct) * integrated;
        for c in 0..p {
            point.alpha[c] = output(work, n + 1 + c);
        }
        point.y0.is_finite() && point.x0.iter().all(|x| x.is_finite())
    }

    /// As [`HostChannel::solve`], a hair beside a frequency at which the host is singular whatever the devices do.
    pub(crate) fn solve_near(
        &self,
        omega: f64,
        work: &mut Vec<Complex64>,
        point: &mut HostPoint,
    ) -> Result<f64, ResponseError> {
        for shift in [0.0, 1e-9, -1e-9, 1e-7] {
            let at = omega * (1.0 + shift);
            if self.solve(at, work, point) {
                return Ok(at);
            }
        }
        Err(ResponseError::SingularAt {
            hz: omega / std::f64::consts::TAU,
        })
    }
}

/// Gauss elimination with partial pivoting of the first `n` columns; the solution replaces the others.
///
/// Returns the determinant, or nothing where the matrix is singular.
pub(crate) fn eliminate(work: &mut [Complex64], n: usize, width: usize) -> Option<Complex64> {
    let mut determinant = Complex64::ONE;
    let size = |value: Complex64| value.re.abs() + value.im.abs();
    for k in 0..n {
        let mut pivot = k;
        let mut best = 0.0;
        for i in k..n {
            let candidate = size(work[i * width + k]);
            if candidate > best {
                best = candidate;
                pivot = i;
            }
        }
        if !(best > 0.0 && best.is_finite()) {
            return None;
        }
        if pivot != k {
            determinant = -determinant;
            for j in k..width {
                work.swap(k * width + j, pivot * width + j);
            }
        }
        determinant *= work[k * width + k];
        let inverse = work[k * width + k].inv();
        let (above, below) = work.split_at_mut((k + 1) * width);
        let row = &mut above[k * width..];
        for value in &mut row[k + 1..] {
            *value *= inverse;
        }
        for other in below.chunks_exact_mut(width) {
            let factor = other[k];
            if factor != Complex64::ZERO {
                for (value, &pivot_value) in other[k + 1..].iter_mut().zip(&row[k + 1..]) {
                    *value -= factor * pivot_value;
                }
            }
        }
    }
    for k in (1..n).rev() {
        let (above, below) = work.split_at_mut(k * width);
        let row = &below[..width];
        for other in above.chunks_exact_mut(width) {
            let factor = other[k];
            if factor != Complex64::ZERO {
                for (value, &solved) in other[n..].iter_mut().zip(&row[n..]) {
                    *value -= factor * solved;
                }
            }
        }
    }
    Some(determinant)
}
