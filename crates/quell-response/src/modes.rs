//! Modes of a host with devices.

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::assembly::Assembly;
use crate::dense::Dense;
use crate::eigen::{eigen, eigenvalues};
use crate::error::ResponseError;

/// What kind of motion an eigenvalue describes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ModeKind {
    /// A conjugate pair of eigenvalues, listed once with its positive imaginary part: two of the predicted number.
    Oscillatory,
    /// A real eigenvalue: decay (or growth) without oscillation.
    Real,
    /// A zero eigenvalue of the host's motion as a rigid body; its number is known from the structure.
    RigidBody,
}

/// One mode.
#[derive(Debug, Clone, PartialEq)]
pub struct Mode {
    /// λ, rad/s.
    pub eigenvalue: Complex64,
    /// |λ|/(2π), Hz.
    pub frequency_hz: f64,
    /// -Re λ/|λ|: ±1 of a real eigenvalue, 0 of a rigid-body mode.
    pub damping_ratio: f64,
    /// Oscillatory, real or rigid body.
    pub kind: ModeKind,
    /// Displacements of the host's coordinates, then of the devices' internal nodes; the largest host entry is 1.
    pub shape: Vec<Complex64>,
}

/// All modes, slowest first.
#[derive(Debug, Clone, PartialEq)]
pub struct Modes {
    /// One entry for a conjugate pair, one for a real or zero eigenvalue; ascending by frequency.
    pub modes: Vec<Mode>,
    /// Size of the state matrix (balanced norm), rad/s: rounding errors of eigenvalues are a part of it.
    pub scale: f64,
}

impl Modes {
    /// Number of eigenvalues: two for each oscillatory mode.
    pub fn count(&self) -> usize {
        self.modes
            .iter()
            .map(|mode| {
                if mode.kind == ModeKind::Oscillatory {
                    2
                } else {
                    1
                }
            })
            .sum()
    }

    /// Every eigenvalue, rad/s, conjugates included.
    pub fn eigenvalues(&self) -> Vec<Complex64> {
        let mut all = Vec::with_capacity(self.count());
        for mode in &self.modes {
            all.push(mode.eigenvalue);
            if mode.kind == ModeKind::Oscillatory {
                all.push(mode.eigenvalue.conj());
            }
        }
        all
    }

    /// The largest real part of any eigenvalue that is no rigid-body mode (the stability margin is its negative), rad/s.
    pub fn growth(&self) -> Option<f64> {
        let motions = self
            .modes
            .iter()
            .filter(|mode| mode.kind != ModeKind::RigidBody);
        motions
            .map(|mode| mode.eigenvalue.re)
            .max_by(f64::total_cmp)
    }

    /// The least damping ratio of all modes that are no rigid-body mode, or of the oscillatory ones alone.
    pub fn least_damping(&self, oscillatory_only: bool) -> Option<f64> {
        let considered = self.modes.iter().filter(|mode| {
            mode.kind == ModeKind::Oscillatory || (!oscillatory_only && mode.kind == ModeKind::Real)
        });
        considered
            .map(|mode| mode.damping_ratio)
            .min_by(f64::total_cmp)
    }
}

impl Assembly {
    /// The modes at the given values: as many eigenvalues as [`Assembly::predicted_modes`] says.
    ///
    /// # Errors
    /// Where values do not fit, the host has loss factors, or the eigenvalues cannot be computed.
    pub fn modes(&self, values: &[f64]) -> Result<Modes, ResponseError> {
        self.check_values(values)?;
        self.no_loss("a mode")?;
        let space = self.state_space(&self.deflated, values, 1.0_f64, |k, _| k)?;
        let (eigenvalues, vectors) = eigen(&space.a)?;
        let positions = space.z[0]
            .state
            .map(|value| Complex64::new(value, 0.0))
            .times(&vectors);
        let mut modes: Vec<Mode> = self
            .rigid_body_shapes()
            .into_iter()
            .map(|shape| Mode {
                eigenvalue: Complex64::ZERO,
                frequency_hz: 0.0,
                damping_ratio: 0.0,
                kind: ModeKind::RigidBody,
                shape,
            })
            .collect();
        for (index, &eigenvalue) in eigenvalues.iter().enumerate() {
            if eigenvalue.im < 0.0 {
                continue;
            }
            let kind = if eigenvalue.im == 0.0 {
                ModeKind::Real
            } else {
                ModeKind::Oscillatory
            };
            let size = eigenvalue.norm();
            let shape = (0..self.size).map(|i| positions.get(i, index)).collect();
            modes.push(Mode {
                eigenvalue,
                frequency_hz: size / TAU,
                damping_ratio: if size > 0.0 {
                    -eigenvalue.re / size
                } else {
                    0.0
                },
                kind,
                shape: self.normalised(shape),
            });
        }
        modes.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
        let scale = crate::eigen::balance(&space.a).0.norm();
        Ok(Modes { modes, scale })
    }

    /// The eigenvalues alone, without shapes: for criteria in a search.
    ///
    /// # Errors
    /// As [`Assembly::modes`].
    pub fn eigenvalues(&self, values: &[f64]) -> Result<Vec<Complex64>, ResponseError> {
        self.check_values(values)?;
        self.no_loss("a mode")?;
        let space = self.state_space(&self.deflated, values, 1.0_f64, |k, _| k)?;
        let mut all = vec![Complex64::ZERO; self.predicted_rigid_body_modes()];
        all.extend(eigenvalues(&space.a)?);
        Ok(all)
    }

    fn normalised(&self, mut shape: Vec<Complex64>) -> Vec<Complex64> {
        let hosts = self.host.coordinates.len();
        let largest = |part: &[Complex64]| {
            part.iter()
                .copied()
                .max_by(|a, b| a.norm().total_cmp(&b.norm()))
                .filter(|value| value.norm() > 0.0)
        };
        let all = largest(&shape);
        // A motion of internal nodes alone is normalised to its own largest entry.
        let reference = largest(&shape[..hosts])
            .filter(|host| all.is_none_or(|all| host.norm() > 1e-12 * all.norm()))
            .or(all);
        if let Some(reference) = reference {
            for entry in &mut shape {
                *entry /= reference;
            }
        }
        shape
    }

    /// One shape for each zero eigenvalue: twice where the motion is undamped (displacement and velocity).
    fn rigid_body_shapes(&self) -> Vec<Vec<Complex64>> {
        let count = self.predicted_rigid_body_modes();
        let hosts = self.host.coordinates.len();
        let structure = &self.deflated;
        let column = |matrix: &Dense<f64>, j: usize| -> Vec<Complex64> {
            (0..self.size)
                .map(|i| Complex64::new(matrix.get(i, j), 0.0))
                .collect()
        };
        let moves_host =
            |shape: &Vec<Complex64>| shape[..hosts].iter().any(|value| value.norm() > 1e-9);
        let mut shapes: Vec<Vec<Complex64>> = Vec::new();
        for j in 0..structure.counts[0] {
            let shape = column(&structure.transform, j);
            if moves_host(&shape) {
                shapes.push(shape.clone());
                shapes.push(shape);
            }
        }
        let first = structure.counts[0];
        for j in 0..structure.neutral.columns() {
            let mut shape = vec![Complex64::ZERO; self.size];
            for (i, entry) in shape.iter_mut().enumerate() {
                for k in 0..structure.neutral.rows() {
                    *entry += structure.transform.get(i, first + k) * structure.neutral.get(k, j);
                }
            }
            if moves_host(&shape) {
                shapes.push(shape);
            }
        }
        shapes.resize(count, vec![Complex64::ZERO; self.size]);
        shapes
            .into_iter()
            .map(|shape| self.normalised(shape))
            .collect()
    }
}
