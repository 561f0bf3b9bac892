//! Newton's iteration on a hyperplane, and the tangent.

use super::{Failure, Manifold, Node, inner};
use crate::settings::{Correction, Settings};

/// What a correction cost.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Quality {
    pub(crate) iterations: usize,
    pub(crate) contraction: f64,
    pub(crate) last: f64,
}

/// Newton with its buffers.
pub(crate) struct Corrector<'a> {
    pub(crate) settings: &'a Settings,
    rhs: Vec<f64>,
}

impl<'a> Corrector<'a> {
    pub(crate) fn new(settings: &'a Settings) -> Self {
        Self {
            settings,
            rhs: Vec::new(),
        }
    }

    /// Solves F(z) = 0, row · z = target from the given z. `reuse` says that the factorisation at hand is near.
    pub(crate) fn correct<M: Manifold>(
        &mut self,
        m: &mut M,
        z: &mut [f64],
        row: &[f64],
        target: f64,
        reuse: bool,
    ) -> Result<Quality, Failure> {
        self.newton(m, z, row.to_vec(), Some(target), reuse)
    }

    /// Brings a predicted z onto the branch, as the settings say; `row` and `target` are the plane across the tangent before.
    pub(crate) fn step<M: Manifold>(
        &mut self,
        m: &mut M,
        z: &mut [f64],
        row: &[f64],
        target: f64,
        reuse: bool,
    ) -> Result<Quality, Failure> {
        let fixed = self.settings.correction == Correction::PseudoArclength;
        self.newton(m, z, row.to_vec(), fixed.then_some(target), reuse)
    }

    /// Newton in the plane row · z = target, or without a target across the null vector of each iteration, `row` being the first.
    fn newton<M: Manifold>(
        &mut self,
        m: &mut M,
        z: &mut [f64],
        mut row: Vec<f64>,
        target: Option<f64>,
        reuse: bool,
    ) -> Result<Quality, Failure> {
        let n = m.len();
        let tolerance = self.settings.newton_tolerance;
        let mut quality = Quality::default();
        let mut previous = f64::INFINITY;
        let chord = m.chord();
        let mut fresh = false;
        if reuse && chord {
            m.border(&row)?;
        } else {
            m.factor(z)?;
            m.border(&row)?;
            fresh = true;
        }
        let limit = if chord {
            self.settings.newton_iterations + 6
        } else {
            self.settings.newton_iterations
        };
        for iteration in 1..=limit {
            self.rhs.resize(n, 0.0);
            m.residual(z, &mut self.rhs)?;
            for r in &mut self.rhs[..n - 1] {
                *r = -*r;
            }
            self.rhs[n - 1] = target.map_or(0.0, |target| {
                let mut along = 0.0;
                for (r, z) in row.iter().zip(z.iter()) {
                    along += r * z;
                }
                target - along
            });
            m.solve(&mut self.rhs);
            if target.is_none() {
                // The null vector at hand; its plane is the next iteration's.
                let mut null = vec![0.0; n];
                null[n - 1] = 1.0;
                m.solve(&mut null);
                let length = inner(m.weights(), &null, &null).sqrt();
                if !(length > 0.0 && length.is_finite()) {
                    return Err(Failure::Singular);
                }
                for ((row, null), weight) in row.iter_mut().zip(&null).zip(m.weights()) {
                    *row = weight * null / length;
                }
            }
            let size = inner(m.weights(), &self.rhs, &self.rhs).sqrt();
            if !size.is_finite() {
                return Err(Failure::NotFinite);
            }
            let ratio = size / previous;
            // An old factorisation that converges slowly is replaced, and the step just computed is not taken.
            if chord && !fresh && (iteration > 1 && ratio > 0.25 || size > 0.5) {
                m.factor(z)?;
                m.border(&row)?;
                fresh = true;
                previous = f64::INFINITY;
                continue;
            }
            if m.keeps() && size < tolerance {
                // The point stays where its factorisation is.
                quality.iterations = iteration;
                quality.last = size;
                return Ok(quality);
            }
            if size > 1e3 || iteration > 2 && ratio > 2.0 && size > tolerance * 1e3 {
                return Err(Failure::NoConvergence(size));
            }
            for (z, d) in z.iter_mut().zip(&self.rhs) {
                *z += d;
            }
            quality.iterations = iteration;
            quality.last = size;
            if iteration > 1 && ratio.is_finite() {
                quality.contraction = quality.contraction.max(ratio.min(1.0));
            }
            let rate = if chord { ratio.clamp(0.0, 0.9) } else { 0.0 };
            let ahead = if rate > 0.0 {
                size * rate / (1.0 - rate)
            } else {
                size
            };
            if size < tolerance || iteration > 1 && ahead < tolerance {
                return Ok(quality);
            }
            // Rounding level reached: corrections no longer shrink.
            if iteration > 3 && size < tolerance * 100.0 && ratio > 0.3 {
                return Ok(quality);
            }
            previous = size;
            if !chord || fresh && ratio > 0.2 && iteration > 1 {
                m.factor(z)?;
                m.border(&row)?;
                fresh = true;
            } else if target.is_none() {
                m.border(&row)?;
            }
        }
        Err(Failure::NoConvergence(quality.last))
    }

    #[allow(clippy::unused_self)] // beside `correct`, with which it is always used
    /// The unit tangent at z with row · t > 0, leaving a factorisation at z bordered by `row`.
    pub(crate) fn tangent<M: Manifold>(
        &mut self,
        m: &mut M,
        z: &[f64],
        row: &[f64],
    ) -> Result<Vec<f64>, Failure> {
        m.factor(z)?;
        m.border(row)?;
        let n = m.len();
        let mut t = vec![0.0; n];
        t[n - 1] = 1.0;
        m.solve(&mut t);
        let size = inner(m.weights(), &t, &t).sqrt();
        if !size.is_finite() {
            return Err(Failure::NotFinite);
        }
        if size == 0.0 {
            return Err(Failure::Singular);
        }
        for t in &mut t {
            *t /= size;
        }
        Ok(t)
    }

    /// Completes a corrected z to a node.
    pub(crate) fn node<M: Manifold>(
        &mut self,
        m: &mut M,
        z: Vec<f64>,
        row: &[f64],
    ) -> Result<Node, Failure> {
        let tangent = self.tangent(m, &z, row)?;
        Ok(self.dress(m, z, tangent))
    }

    /// Spectrum and test functions at a z whose factorisation is current.
    pub(crate) fn dress<M: Manifold>(&mut self, m: &mut M, z: Vec<f64>, tangent: Vec<f64>) -> Node {
        let (spectrum, tests) = if self.settings.detect {
            let spectrum = m.spectrum(&z, &tangent);
            let tests = m.tests(&z, &tangent, &spectrum);
            (spectrum, tests)
        } else {
            (crate::dense::Spectrum::default(), Vec::new())
        };
        Node {
            z,
            tangent,
            spectrum,
            tests,
            mesh: m.mesh(),
            history: None,
        }
    }
}
