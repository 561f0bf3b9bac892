//! Frequency response of a linear host to whatever device: peaks over a band, without solving the host again.
//!
//! With one port the transfer function is bilinear in the device's dynamic stiffness N/Den,
//!
//! ```text
//! H = (a N + b Den) / (c N + e Den),
//! ```
//!
//! and a, b, c, e are the host's alone: they are computed once on a grid. With p ports a p × p system takes their place.

mod bilinear;
mod evaluation;
mod grid;
mod maximum;
mod piece;

use std::sync::Arc;

use num_complex::Complex64;
use quell_model::linear::{LinearForm, Signal};
use quell_network::{Part, PartShare, RatioGrid, Workspace};

use crate::assembly::{Assembly, OutputTerm};
use crate::error::ResponseError;
use crate::receptance::{HostChannel, HostPoint};

use bilinear::{Bilinear, Constants};
use grid::grid;
use maximum::Candidate;

pub(crate) use grid::checked_band;
pub use maximum::Peak;
pub use piece::Piece;

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

    /// Number of integrations of the input (1 for velocities, 2 for accelerations).
    pub fn integrations(&self) -> usize {
        self.integrations
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
                let k = Constants::new(&point, self.gamma[0]);
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
