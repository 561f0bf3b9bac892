//! What every system of equations for an orbit shares: the scale of the states, the phase condition, the mesh.

use super::bordered::{Row, apply};
use super::collocation::Collocation;
use super::mesh;
use crate::dense::dot;
use crate::settings::MeshSettings;

#[derive(Clone, Debug, Default)]
pub(crate) struct Frame {
    /// Largest root mean square of the states so far.
    pub(crate) scale: f64,
    /// ∫⟨x, x_ref'⟩ over the nodes, of unit length.
    pub(crate) phase: Row,
    /// Its value at the reference.
    anchor: f64,
    /// The reference, an orbit on the present mesh.
    reference: Vec<f64>,
}

impl Frame {
    pub(crate) fn new(scale: f64) -> Self {
        Self {
            scale,
            ..Self::default()
        }
    }

    /// The weights of the nodes and, on autonomous orbits, of the period, after the scale has taken in this orbit.
    pub(crate) fn weigh(&mut self, c: &Collocation<'_>, z: &[f64], weights: &mut Vec<f64>) {
        let n = c.n;
        let quadrature = c.weights();
        let square: f64 = quadrature
            .iter()
            .zip(z.chunks_exact(n))
            .map(|(w, x)| w * dot(x, x))
            .sum();
        let rms = (square / n as f64).sqrt();
        if rms.is_finite() {
            self.scale = self.scale.max(rms);
        }
        let s = 1.0 / (self.scale * self.scale * n as f64);
        weights.clear();
        for w in quadrature {
            weights.extend(std::iter::repeat_n(w * s, n));
        }
        if c.autonomous {
            weights.push(z[c.nodes()].powi(-2));
        }
    }

    /// Takes an orbit as the reference of the phase, where the present one is no longer near.
    ///
    /// One reference for many points makes the branch one smooth curve, which can be predicted. With a new one at every point each
    /// would be in a phase of its own.
    pub(crate) fn anchor(&mut self, c: &Collocation<'_>, z: &[f64]) {
        if !c.autonomous {
            return;
        }
        let row = phase(c, z);
        if dot(&row, &self.phase.nodes) > NEAR && self.reference.len() == c.nodes() {
            return;
        }
        self.refer(c, z[..c.nodes()].to_vec(), row);
    }

    /// Lets the next orbit be the reference.
    pub(crate) fn forget(&mut self) {
        self.reference.clear();
    }

    fn refer(&mut self, c: &Collocation<'_>, reference: Vec<f64>, row: Vec<f64>) {
        self.anchor = dot(&row, &reference);
        self.reference = reference;
        self.phase = Row {
            nodes: row,
            ends: vec![0.0; c.borders()],
        };
    }

    /// How far an orbit is from the phase of the reference.
    pub(crate) fn offset(&self, z: &[f64]) -> f64 {
        apply(&self.phase, z) - self.anchor
    }

    /// Every so many points (`count` is the number of this one), carries an orbit and tangents over to a better mesh; false
    /// where the present one is kept.
    pub(crate) fn adapt(
        &mut self,
        c: &mut Collocation<'_>,
        settings: &MeshSettings,
        z: &mut Vec<f64>,
        tangents: &mut [&mut Vec<f64>],
        count: usize,
    ) -> bool {
        if settings.every == 0 || !count.is_multiple_of(settings.every) {
            return false;
        }
        let Some(mesh) = mesh::equidistribute(c, z, settings) else {
            return false;
        };
        let nodes = c.nodes();
        let still = vec![0.0; c.n];
        let moved = |x: &[f64], wrap: &[f64]| {
            let mut out = mesh::transfer(c, x, wrap, &mesh);
            out.extend_from_slice(&x[nodes..]);
            out
        };
        *z = moved(z, &c.winding);
        for tangent in tangents {
            **tangent = moved(tangent, &still);
        }
        let kept = self.reference.len() == nodes;
        let reference = kept.then(|| moved(&self.reference, &c.winding));
        c.set_mesh(mesh);
        if let Some(reference) = reference {
            let row = phase(c, &reference);
            self.refer(c, reference, row);
        }
        true
    }
}

/// The cosine of the angle between the phase rows of two orbits, above which one serves for the other: beyond it the steep parts of a
/// relaxation orbit would leave the part of the mesh that was made for them.
const NEAR: f64 = 0.99;

/// The row of the phase condition, of unit length.
fn phase(c: &Collocation<'_>, z: &[f64]) -> Vec<f64> {
    let mut row = c.phase_row(z);
    let size = dot(&row, &row).sqrt().max(1e-300);
    for x in &mut row {
        *x /= size;
    }
    row
}
