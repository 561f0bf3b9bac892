//! Frequency response of a linear host to whatever device: peaks over a band, without solving the host again.
//!
//! With one port the transfer function is bilinear in the device's dynamic stiffness N/Den,
//!
//! ```text
//! H = (a N + b Den) / (c N + e Den),
//! ```
//!
//! and a, b, c, e are the host's alone: they are computed once on a grid. With p ports a p × p system takes their place.

use std::sync::Arc;

use num_complex::Complex64;
use quell_model::linear::LinearForm;
use quell_network::{Part, PartShare, RatioGrid, Workspace};

use crate::assembly::{Assembly, Attached, OutputTerm, powers_of};
use crate::error::ResponseError;
use crate::peak::{minimise, vertex};
use crate::receptance::{HostChannel, HostPoint, eliminate};
use quell_model::linear::Signal;

/// How a [`Plan`] samples the band and refines peaks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanSettings {
    /// Number of grid points before clusters at the host's modes are added; half linear, half logarithmic. At least 8.
    pub points: usize,
    /// Largest number of local maxima that are refined.
    pub peaks: usize,
    /// Relative tolerance of a refined peak's |H|², 1e-9 by default.
    pub tolerance: f64,
}

impl Default for PlanSettings {
    fn default() -> Self {
        Self {
            points: 100,
            peaks: 8,
            tolerance: 1e-9,
        }
    }
}

/// The largest value of |H| over a band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peak {
    /// max |H|, in the unit of the output over that of the input; infinite at an undamped resonance.
    pub value: f64,
    /// Where, rad/s.
    pub omega: f64,
}

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

/// A part of a device that the output watches.
#[derive(Debug, Clone, Copy)]
struct PartTerm {
    /// Index into the assembly's devices.
    device: usize,
    part: Part,
    force: bool,
    order: usize,
    coefficient: f64,
}

/// The host's constants on the grid, as a structure of arrays: a, b, c, e, x0 of the bilinear form.
#[derive(Debug, Clone, Default)]
struct Bilinear {
    a: [Vec<f64>; 2],
    b: [Vec<f64>; 2],
    c: [Vec<f64>; 2],
    e: [Vec<f64>; 2],
    x0: Vec<Complex64>,
}

/// Constants of the bilinear form at one frequency.
#[derive(Debug, Clone, Copy)]
struct Constants {
    a: Complex64,
    b: Complex64,
    c: Complex64,
    e: Complex64,
    x0: Complex64,
}

/// Memory of evaluations, one for each thread; it grows at first use and is then reused.
#[derive(Debug, Clone, Default)]
pub struct Scratch {
    grids: Vec<RatioGrid>,
    workspace: Workspace,
    shares: Vec<PartShare>,
    /// |H|² over the grid.
    square: Vec<f64>,
    /// Re and Im of the characteristic factor c N + e Den over the grid.
    factor: [Vec<f64>; 2],
    combined: [Vec<f64>; 4],
    candidates: Vec<Candidate>,
    refined: Vec<Peak>,
    host: HostPoint,
    work: Vec<Complex64>,
    small: Vec<Complex64>,
    pairs: Vec<(Complex64, Complex64)>,
    derivative: Vec<Complex64>,
}

impl Scratch {
    /// Empty memory.
    pub fn new() -> Self {
        Self::default()
    }
}

#[derive(Debug, Clone, Copy)]
struct Candidate {
    /// φ = 1/|H|² that may be reached.
    promise: f64,
    left: (f64, f64),
    middle: (f64, f64),
    right: (f64, f64),
    /// An edge of the band: nothing to refine.
    edge: bool,
}

/// An input, an output and a band of an assembly, prepared for many evaluations.
#[derive(Debug, Clone)]
pub struct Plan {
    assembly: Arc<Assembly>,
    channel: HostChannel,
    /// Used ports, and for each the devices on it.
    ports: Vec<Vec<usize>>,
    /// Coefficient of the port force in the output, for each used port.
    gamma: Vec<f64>,
    parts: Vec<PartTerm>,
    terms: Vec<OutputTerm>,
    integrations: usize,
    settings: PlanSettings,
    omegas: Vec<f64>,
    bilinear: Bilinear,
    /// General path: the host at every grid point.
    points: Vec<HostPoint>,
}

impl Plan {
    /// Computes the host's receptances on a grid over `band` (rad/s), once for all devices' values.
    ///
    /// A band that starts at zero is taken from 1e-6 of its upper edge.
    ///
    /// # Errors
    /// Where the band is empty, the input or a signal does not exist, or a setting is out of range.
    pub fn new(
        assembly: &Arc<Assembly>,
        input: usize,
        form: &LinearForm,
        band: (f64, f64),
        settings: PlanSettings,
    ) -> Result<Self, ResponseError> {
        assembly.check_input(input)?;
        let band = checked_band(band)?;
        if settings.points < 8 {
            let value = settings.points as f64;
            return Err(ResponseError::Setting {
                name: "points",
                value,
                range: "at least 8",
            });
        }
        if settings.peaks == 0 {
            return Err(ResponseError::Setting {
                name: "peaks",
                value: 0.0,
                range: "at least 1",
            });
        }
        if !(settings.tolerance >= 1e-14 && settings.tolerance < 1.0) {
            let value = settings.tolerance;
            return Err(ResponseError::Setting {
                name: "tolerance",
                value,
                range: "from 1e-14 to 1",
            });
        }
        let mut used: Vec<usize> = assembly.devices.iter().map(|device| device.port).collect();
        used.sort_unstable();
        used.dedup();
        let ports: Vec<Vec<usize>> = used
            .iter()
            .map(|&port| {
                (0..assembly.devices.len())
                    .filter(|&d| assembly.devices[d].port == port)
                    .collect()
            })
            .collect();
        // Checks every signal, whatever path evaluates it.
        let terms = assembly.output_terms(form)?;
        let mut gamma = vec![0.0; used.len()];
        let mut parts = Vec::new();
        let mut plain = LinearForm::default();
        for (signal, coefficient) in &form.terms {
            match signal {
                Signal::Coordinate { .. } | Signal::Input { .. } => {
                    plain.terms.push((signal.clone(), *coefficient));
                }
                Signal::PortForce { index } => {
                    if let Some(place) = used.iter().position(|port| port == index) {
                        gamma[place] += coefficient;
                    }
                }
                Signal::PartStroke { port, part, order } => {
                    parts.push(part_term(
                        assembly,
                        *port,
                        part,
                        false,
                        *order,
                        *coefficient,
                    )?);
                }
                Signal::PartForce { port, part } => {
                    parts.push(part_term(assembly, *port, part, true, 0, *coefficient)?);
                }
            }
        }
        let channel = HostChannel::new(assembly, input, &used, &assembly.output_terms(&plain)?);
        let mut plan = Self {
            assembly: Arc::clone(assembly),
            integrations: assembly.host.inputs[input].kind.integrations(),
            channel,
            ports,
            gamma,
            parts,
            terms,
            settings,
            omegas: grid(assembly, band, settings.points),
            bilinear: Bilinear::default(),
            points: Vec::new(),
        };
        plan.precompute()?;
        Ok(plan)
    }

    /// The band, rad/s.
    pub fn band(&self) -> (f64, f64) {
        (
            self.omegas.first().copied().unwrap_or(0.0),
            self.omegas.last().copied().unwrap_or(0.0),
        )
    }

    /// The grid, rad/s, ascending.
    pub fn omegas(&self) -> &[f64] {
        &self.omegas
    }

    /// The assembly.
    pub fn assembly(&self) -> &Arc<Assembly> {
        &self.assembly
    }

    /// Adds frequencies (rad/s) to the grid, for instance where a certificate found a peak; those outside of the band are left out.
    ///
    /// # Errors
    /// Where the host is singular at one of them whatever the devices do.
    pub fn add_frequencies(&mut self, omegas: &[f64]) -> Result<(), ResponseError> {
        let (low, high) = self.band();
        self.omegas.extend(
            omegas
                .iter()
                .copied()
                .filter(|omega| *omega > low && *omega < high),
        );
        self.omegas.sort_by(f64::total_cmp);
        self.omegas.dedup_by(|b, a| *b - *a <= 1e-10 * *b);
        self.precompute()
    }

    fn single(&self) -> bool {
        self.ports.len() == 1
    }

    fn precompute(&mut self) -> Result<(), ResponseError> {
        self.bilinear = Bilinear::default();
        self.points.clear();
        let mut work = Vec::new();
        for omega in &mut self.omegas {
            let mut point = HostPoint::default();
            *omega = self.channel.solve_near(*omega, &mut work, &mut point)?;
            if self.ports.len() == 1 {
                let k = constants(&point, self.gamma[0]);
                let lists = &mut self.bilinear;
                for (list, value) in [
                    (&mut lists.a, k.a),
                    (&mut lists.b, k.b),
                    (&mut lists.c, k.c),
                    (&mut lists.e, k.e),
                ] {
                    list[0].push(value.re);
                    list[1].push(value.im);
                }
                lists.x0.push(k.x0);
            } else {
                self.points.push(point);
            }
        }
        Ok(())
    }

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
    fn evaluate_with_factor(
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
            let constants = constants(&scratch.host, self.gamma[0]);
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
    fn sweep(&self, values: &[f64], scratch: &mut Scratch) {
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

    /// Collects local maxima of the grid and resonances that hide between two points.
    fn collect(&self, values: &[f64], scratch: &mut Scratch) {
        let count = self.omegas.len();
        let mut candidates = std::mem::take(&mut scratch.candidates);
        candidates.clear();
        let last = count - 1;
        let sample = |square: &[f64], i: usize| (self.omegas[i], 1.0 / square[i]);
        let mut hidden = [usize::MAX; 16];
        let mut found = 0;
        // A lightly damped pole turns the phase of the characteristic factor by nearly half a turn between two points.
        let [re, im] = &scratch.factor;
        for i in 0..last {
            if re[i] * re[i + 1] + im[i] * im[i + 1] < 0.0 && found < hidden.len() {
                hidden[found] = i;
                found += 1;
            }
        }
        let mut covered = [usize::MAX; 32];
        for (place, &i) in hidden[..found].iter().enumerate() {
            if let Some(candidate) = self.hidden_peak(values, i, scratch) {
                candidates.push(candidate);
                covered[2 * place] = i;
                covered[2 * place + 1] = i + 1;
            }
        }
        let square = &scratch.square;
        for i in 0..count {
            let rises = i == 0 || square[i] >= square[i - 1];
            let falls = i == last || square[i] > square[i + 1];
            if !(rises && falls) || covered.contains(&i) {
                continue;
            }
            let middle = sample(square, i);
            if i == 0 || i == last {
                candidates.push(Candidate {
                    promise: middle.1,
                    left: middle,
                    middle,
                    right: middle,
                    edge: true,
                });
                continue;
            }
            let (left, right) = (sample(square, i - 1), sample(square, i + 1));
            let predicted = vertex(left, middle, right).max(0.0);
            // Half as much again may be gained, because a peak between points can be sharper than its parabola.
            let promise = (predicted - 0.5 * (middle.1 - predicted)).max(0.0);
            candidates.push(Candidate {
                promise,
                left,
                middle,
                right,
                edge: false,
            });
        }
        // Maxima between the edge and its neighbour.
        for (edge, next) in [(0, 1), (last, last - 1)] {
            let (at, beside) = (sample(square, edge), sample(square, next));
            let far = if edge == 0 { 2 } else { last - 2 };
            if square[edge] >= square[next] && !covered.contains(&edge) {
                let away = sample(square, far);
                let h = beside.0 - at.0;
                let h2 = away.0 - at.0;
                let slope = ((beside.1 - at.1) / h * h2 - (away.1 - at.1) / h2 * h) / (h2 - h);
                // φ falls on entering the band: the maximum lies inside.
                if slope * h.signum() < 0.0 {
                    let omega = at.0 + 0.2 * h;
                    let middle = (
                        omega,
                        1.0 / finite_square(self.evaluate(values, omega, scratch).norm_sqr()),
                    );
                    if middle.1 < at.1 {
                        let (left, right) = if edge == 0 {
                            (at, beside)
                        } else {
                            (beside, at)
                        };
                        candidates.push(Candidate {
                            promise: 0.0,
                            left,
                            middle,
                            right,
                            edge: false,
                        });
                    }
                    break;
                }
            }
        }
        candidates.sort_unstable_by(|a, b| a.promise.total_cmp(&b.promise));
        scratch.candidates = candidates;
    }

    /// The resonance between grid points i and i + 1, between which the characteristic factor turns by more than a quarter.
    fn hidden_peak(&self, values: &[f64], i: usize, scratch: &mut Scratch) -> Option<Candidate> {
        let factor = |scratch: &Scratch, at: usize| {
            Complex64::new(scratch.factor[0][at], scratch.factor[1][at])
        };
        let (mut low, mut high) = (
            (self.omegas[i], factor(scratch, i)),
            (self.omegas[i + 1], factor(scratch, i + 1)),
        );
        let (left, right) = (
            (low.0, 1.0 / scratch.square[i]),
            (high.0, 1.0 / scratch.square[i + 1]),
        );
        let mut best = if left.1 < right.1 { left } else { right };
        let mut width = 0.0;
        // The factor passes the origin almost on a straight line; along it, its projection changes sign.
        for _ in 0..12 {
            let along = high.1 - low.1;
            let share = -(along.conj() * low.1).re / along.norm_sqr();
            let omega = low.0 + share.clamp(0.01, 0.99) * (high.0 - low.0);
            if !(omega > low.0 && omega < high.0) {
                break;
            }
            let (response, factor) = self.evaluate_with_factor(values, omega, scratch);
            let sample = (omega, 1.0 / finite_square(response.norm_sqr()));
            if sample.1 < best.1 {
                best = sample;
            }
            let turned = along.conj() * factor;
            let slope = along.norm_sqr() / (high.0 - low.0);
            width = turned.im.abs() / slope;
            let away = turned.re / slope;
            if away.abs() < 0.5 * width || away.abs() < 1e-12 * omega {
                break;
            }
            if away < 0.0 {
                low = (omega, factor);
            } else {
                high = (omega, factor);
            }
        }
        if best.0 == left.0 || best.0 == right.0 {
            return None;
        }
        // A bracket of a few widths, where 1/|H|² is a parabola.
        let (mut below, mut above) = (left, right);
        for side in [-2.0, 2.0] {
            let omega = best.0 + side * width;
            if omega > left.0 && omega < right.0 && omega != best.0 {
                let value = 1.0 / finite_square(self.evaluate(values, omega, scratch).norm_sqr());
                if value >= best.1 {
                    if side < 0.0 {
                        below = (omega, value);
                    } else {
                        above = (omega, value);
                    }
                }
            }
        }
        // A parabola through far points says nothing about a narrow peak: always refine.
        Some(Candidate {
            promise: 0.0,
            left: below,
            middle: best,
            right: above,
            edge: false,
        })
    }

    /// Refines all candidates that may come within `margin` of the largest; leaves them in `scratch.refined`.
    fn refine(&self, values: &[f64], margin: f64, scratch: &mut Scratch) -> Peak {
        self.sweep(values, scratch);
        self.collect(values, scratch);
        let candidates = std::mem::take(&mut scratch.candidates);
        let mut refined = std::mem::take(&mut scratch.refined);
        refined.clear();
        let mut best = (self.omegas[0], f64::INFINITY);
        for candidate in &candidates {
            if candidate.middle.1 < best.1 {
                best = candidate.middle;
            }
        }
        let keep = 1.0 / ((1.0 - margin.clamp(0.0, 1.0)).powi(2)).max(f64::MIN_POSITIVE);
        let mut count = 0;
        for candidate in &candidates {
            if candidate.promise > best.1 * keep {
                continue;
            }
            let sample = if candidate.edge || count >= self.settings.peaks {
                candidate.middle
            } else {
                count += 1;
                minimise(
                    candidate.left,
                    candidate.middle,
                    candidate.right,
                    self.settings.tolerance,
                    |omega| 1.0 / finite_square(self.evaluate(values, omega, scratch).norm_sqr()),
                )
            };
            if sample.1 < best.1 {
                best = sample;
            }
            refined.push(Peak {
                value: sample.1.sqrt().recip(),
                omega: sample.0,
            });
        }
        scratch.candidates = candidates;
        scratch.refined = refined;
        Peak {
            value: best.1.sqrt().recip(),
            omega: best.0,
        }
    }

    /// max |H| over the band: the grid, then the largest local maxima refined with true evaluations.
    ///
    /// Not-a-number where `values` has a wrong length. Resonances between two grid points are found by the turn of the
    /// characteristic factor's phase; two of them in one gap can still be missed, and [`crate::certify`] tells.
    pub fn peak(&self, values: &[f64], scratch: &mut Scratch) -> Peak {
        if values.len() != self.assembly.elements {
            return Peak {
                value: f64::NAN,
                omega: f64::NAN,
            };
        }
        self.refine(values, 0.0, scratch)
    }

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

    /// Number of integrations of the input (1 for velocities, 2 for accelerations).
    pub fn integrations(&self) -> usize {
        self.integrations
    }
}

/// a, b, c, e of one port.
fn constants(point: &HostPoint, gamma: f64) -> Constants {
    let (d, g, x0, alpha) = (point.nominal[0], point.g[0], point.x0[0], point.alpha[0]);
    let e = 1.0 - g * d;
    Constants {
        a: point.y0 * g + (gamma - alpha) * x0,
        b: point.y0 * e + alpha * d * x0,
        c: g,
        e,
        x0,
    }
}

#[inline]
fn finite_square(value: f64) -> f64 {
    if value.is_nan() { f64::INFINITY } else { value }
}

fn bilinear_sweep(
    host: &Bilinear,
    device: [&[f64]; 4],
    square: &mut [f64],
    factor: &mut [Vec<f64>; 2],
) {
    let count = square.len();
    let [nr, ni, dr, di] = device.map(|list| &list[..count]);
    let (ar, ai) = (&host.a[0][..count], &host.a[1][..count]);
    let (br, bi) = (&host.b[0][..count], &host.b[1][..count]);
    let (cr, ci) = (&host.c[0][..count], &host.c[1][..count]);
    let (er, ei) = (&host.e[0][..count], &host.e[1][..count]);
    let [fr, fi] = factor;
    let (fr, fi) = (&mut fr[..count], &mut fi[..count]);
    for i in 0..count {
        let top_re = ar[i] * nr[i] - ai[i] * ni[i] + br[i] * dr[i] - bi[i] * di[i];
        let top_im = ar[i] * ni[i] + ai[i] * nr[i] + br[i] * di[i] + bi[i] * dr[i];
        let re = cr[i] * nr[i] - ci[i] * ni[i] + er[i] * dr[i] - ei[i] * di[i];
        let im = cr[i] * ni[i] + ci[i] * nr[i] + er[i] * di[i] + ei[i] * dr[i];
        fr[i] = re;
        fi[i] = im;
        square[i] = (top_re * top_re + top_im * top_im) / (re * re + im * im);
    }
}

/// Devices side by side: N = N1 Den2 + N2 Den1, Den = Den1 Den2.
fn combine(grids: &[RatioGrid], out: &mut [Vec<f64>; 4]) {
    let count = grids.first().map_or(0, RatioGrid::len);
    for (list, start) in out.iter_mut().zip([0.0, 0.0, 1.0, 0.0]) {
        list.clear();
        list.resize(count, start);
    }
    let [nr, ni, dr, di] = out;
    for grid in grids {
        for i in 0..count {
            let (pn, pd) = (Complex64::new(nr[i], ni[i]), Complex64::new(dr[i], di[i]));
            let on = Complex64::new(grid.numerator_re[i], grid.numerator_im[i]);
            let od = Complex64::new(grid.denominator_re[i], grid.denominator_im[i]);
            let (n, d) = (pn * od + on * pd, pd * od);
            (nr[i], ni[i], dr[i], di[i]) = (n.re, n.im, d.re, d.im);
        }
    }
}

fn part_term(
    assembly: &Assembly,
    port: usize,
    name: &str,
    force: bool,
    order: usize,
    coefficient: f64,
) -> Result<PartTerm, ResponseError> {
    let (found, _) = assembly.find_part(port, name)?;
    let unknown = || ResponseError::UnknownPart {
        port: assembly.host.ports[port].name.clone(),
        part: name.to_owned(),
        help: "check the name".to_owned(),
    };
    let device = assembly
        .devices
        .iter()
        .position(|device| device.first_value == found.first_value && device.port == port);
    let part = found.network.part(name).ok_or_else(unknown)?;
    Ok(PartTerm {
        device: device.ok_or_else(unknown)?,
        part,
        force,
        order,
        coefficient,
    })
}

/// Checks a band and moves a lower edge of zero to 1e-6 of the upper one.
pub(crate) fn checked_band(band: (f64, f64)) -> Result<(f64, f64), ResponseError> {
    let (from, to) = band;
    if !(from.is_finite() && to.is_finite() && from >= 0.0 && to > from) {
        return Err(ResponseError::Band { from, to });
    }
    Ok((from.max(1e-6 * to), to))
}

/// Half linear, half logarithmic, and clusters at the bare host's modes.
fn grid(assembly: &Assembly, band: (f64, f64), points: usize) -> Vec<f64> {
    let (low, high) = band;
    let half = points / 2;
    // Below a thousandth of the upper edge most systems are at rest: a few points a decade go there.
    let start = low.max(1e-3 * high);
    let mut omegas = vec![low, high];
    if start > low {
        let below = (3.0 * (start / low).log10()).ceil().max(1.0);
        for i in 1..=below as usize {
            omegas.push(low * (start / low).powf(i as f64 / below));
        }
    }
    for i in 1..half {
        let share = i as f64 / half as f64;
        omegas.push(low + (high - low) * share);
        omegas.push(start * (high / start).powf(share));
    }
    // A host that cannot stand alone has no modes of its own to look at.
    if let Ok(bare) = Assembly::new(Arc::clone(&assembly.host), Vec::<Attached>::new())
        && let Ok(modes) = bare.eigenvalues(&[])
    {
        for mode in modes.iter().filter(|mode| mode.im > 0.0).take(30) {
            let (centre, width) = (mode.im, (-mode.re).max(1e-3 * mode.im));
            for offset in [
                -0.03 * centre,
                -0.01 * centre,
                -width,
                0.0,
                width,
                0.01 * centre,
                0.03 * centre,
            ] {
                omegas.push(centre + offset);
            }
        }
    }
    omegas.retain(|omega| *omega >= low && *omega <= high);
    omegas.sort_by(f64::total_cmp);
    omegas.dedup_by(|b, a| *b - *a <= 1e-6 * *b);
    // Both edges stay exact.
    if let Some(last) = omegas.last_mut() {
        *last = high;
    }
    omegas
}
