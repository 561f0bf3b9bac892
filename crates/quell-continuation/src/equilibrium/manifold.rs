//! f(x, p) = 0 in the unknowns (x, p).

use num_complex::Complex64;

use super::normal;
use crate::dense::{Lu, Spectrum, dot, eigenvalues, eigenvector, left_eigenvector};
use crate::kind::Kind;
use crate::monitor::View;
use crate::path::{Failure, Found, Label, Manifold, Trigger};
use crate::problem::Problem;
use crate::settings::{ContinuationError, Settings};

pub(crate) struct Equilibria<'a> {
    pub(crate) problem: &'a dyn Problem,
    pub(crate) parameters: Vec<f64>,
    pub(crate) free: usize,
    settings: &'a Settings,
    n: usize,
    jacobian: Vec<f64>,
    column: Vec<f64>,
    matrix: Vec<f64>,
    lu: Lu<f64>,
    weights: Vec<f64>,
    scale: f64,
}

impl<'a> Equilibria<'a> {
    pub(crate) fn new(
        problem: &'a dyn Problem,
        parameters: &[f64],
        free: usize,
        settings: &'a Settings,
    ) -> Self {
        let n = problem.states();
        Self {
            problem,
            parameters: parameters.to_vec(),
            free,
            settings,
            n,
            jacobian: vec![0.0; n * n],
            column: vec![0.0; n],
            matrix: vec![0.0; (n + 1) * (n + 1)],
            lu: Lu::new(),
            weights: vec![1.0; n + 1],
            scale: settings.state_scale,
        }
    }

    fn set(&mut self, z: &[f64]) {
        self.parameters[self.free] = z[self.n];
    }

    /// The direction orthogonal to the tangent in the null space of (`f_x`, `f_p`).
    pub(crate) fn across(
        &mut self,
        z: &[f64],
        tangent: &[f64],
    ) -> Result<Vec<f64>, ContinuationError> {
        self.rescale(z);
        self.factor(z)?;
        let row: Vec<f64> = tangent
            .iter()
            .zip(&self.weights)
            .map(|(t, w)| t * w)
            .collect();
        self.border(&row)?;
        Ok(crate::path::second_direction(self, &row, tangent))
    }
}

impl Manifold for Equilibria<'_> {
    fn len(&self) -> usize {
        self.n + 1
    }

    fn residual(&mut self, z: &[f64], out: &mut [f64]) -> Result<(), Failure> {
        self.set(z);
        self.problem
            .value(0.0, &z[..self.n], &self.parameters, &mut out[..self.n]);
        if out[..self.n].iter().all(|x| x.is_finite()) {
            Ok(())
        } else {
            Err(Failure::NotFinite)
        }
    }

    fn factor(&mut self, z: &[f64]) -> Result<(), Failure> {
        self.set(z);
        self.problem
            .jacobian(0.0, &z[..self.n], &self.parameters, &mut self.jacobian);
        self.problem.parameter_derivative(
            0.0,
            &z[..self.n],
            &self.parameters,
            self.free,
            &mut self.column,
        );
        Ok(())
    }

    fn border(&mut self, row: &[f64]) -> Result<(), Failure> {
        let n = self.n;
        for i in 0..n {
            self.matrix[i * (n + 1)..i * (n + 1) + n]
                .copy_from_slice(&self.jacobian[i * n..(i + 1) * n]);
            self.matrix[i * (n + 1) + n] = self.column[i];
        }
        self.matrix[n * (n + 1)..].copy_from_slice(row);
        // Equations of very different size: rows are scaled to one.
        if self.lu.factor(n + 1, &self.matrix) {
            Ok(())
        } else {
            Err(Failure::NotFinite)
        }
    }

    fn solve(&mut self, b: &mut [f64]) {
        self.lu.solve(b);
    }

    fn weights(&self) -> &[f64] {
        &self.weights
    }

    fn parameters(&self) -> Vec<usize> {
        vec![self.n]
    }

    fn rescale(&mut self, z: &[f64]) {
        let n = self.n;
        let rms = (dot(&z[..n], &z[..n]) / n.max(1) as f64).sqrt();
        if rms.is_finite() {
            self.scale = self.scale.max(rms);
        }
        let w = 1.0 / (self.scale * self.scale * n.max(1) as f64);
        self.weights[..n].fill(w);
        self.weights[n] = self.settings.parameter_scale(0, z[n]).powi(-2);
    }

    fn spectrum(&mut self, z: &[f64], tangent: &[f64]) -> Spectrum {
        let n = self.n;
        self.set(z);
        let Some(values) = eigenvalues(n, &self.jacobian) else {
            return Spectrum::default();
        };
        // dJ/ds by a central difference of the exact Jacobian along the tangent.
        let h = 1e-5;
        let mut difference = vec![0.0; n * n];
        let mut other = vec![0.0; n * n];
        let mut at = |sign: f64, out: &mut [f64]| {
            let x: Vec<f64> = (0..n).map(|i| z[i] + sign * h * tangent[i]).collect();
            self.parameters[self.free] = z[n] + sign * h * tangent[n];
            self.problem.jacobian(0.0, &x, &self.parameters, out);
        };
        at(1.0, &mut difference);
        at(-1.0, &mut other);
        self.set(z);
        for (d, o) in difference.iter_mut().zip(&other) {
            *d = (*d - o) / (2.0 * h);
        }
        let rates = values
            .iter()
            .map(|v| rate(n, &self.jacobian, &difference, *v))
            .collect();
        Spectrum {
            values,
            rates,
            error: 0.0,
        }
    }

    fn distance(&self, value: Complex64) -> f64 {
        value.re
    }

    fn distance_rate(&self, _value: Complex64, rate: Complex64) -> f64 {
        rate.re
    }

    fn tests(&mut self, z: &[f64], _tangent: &[f64], _spectrum: &Spectrum) -> Vec<f64> {
        self.set(z);
        let view = View {
            states: &z[..self.n],
            dimension: self.n,
            parameters: &self.parameters,
            period: None,
        };
        self.settings
            .monitors
            .iter()
            .map(|m| m.value(&view))
            .collect()
    }

    fn classify(&mut self, found: &Found<'_>) -> Option<Label> {
        let n = self.n;
        let z = &found.node.z;
        self.factor(z).ok()?;
        match found.trigger {
            Trigger::Test(k) => Some(Label::plain(Kind::Monitor(k))),
            Trigger::Crossing(v) | Trigger::Touch(v) if v.im.abs() > 1e-9 * (1.0 + v.norm()) => {
                let omega = v.im.abs();
                let normal_form = normal::hopf(
                    self.problem,
                    &z[..n],
                    &self.parameters,
                    &self.jacobian,
                    omega,
                );
                Some(Label {
                    kind: Kind::Hopf,
                    omega: Some(omega),
                    second_omega: None,
                    normal_form: normal_form.into_iter().collect(),
                })
            }
            Trigger::Crossing(v) | Trigger::Touch(v) => {
                let real = |x: Vec<Complex64>| x.iter().map(|c| c.re).collect::<Vec<f64>>();
                let w = real(left_eigenvector(
                    n,
                    &self.jacobian,
                    Complex64::new(v.re, 0.0),
                ));
                let q = real(eigenvector(n, &self.jacobian, Complex64::new(v.re, 0.0)));
                // A branch of a pitchfork is even in the distance from the point where it leaves the other: its parameter has no effect
                // there at all, and what rounding leaves of it is small beside that nearby only.
                let mut size = dot(&self.column, &self.column).sqrt();
                let mut beside = vec![0.0; n];
                for near in [&found.before.z, &found.after.z] {
                    self.set(near);
                    self.problem.parameter_derivative(
                        0.0,
                        &near[..n],
                        &self.parameters,
                        self.free,
                        &mut beside,
                    );
                    size = size.max(dot(&beside, &beside).sqrt());
                }
                self.set(z);
                let effect = dot(&w, &self.column).abs();
                let width = self.settings.parameter_scale(0, z[n]);
                // The parameter moves the equilibrium out of the range of f_x at a fold, not where branches cross.
                if effect * width > 1e-6 * (size * width).max(self.scale * 1e-3) {
                    let normal_form = normal::fold(self.problem, &z[..n], &self.parameters, &q, &w);
                    let mut label = Label::plain(Kind::Fold);
                    label.normal_form.extend(normal_form);
                    Some(label)
                } else {
                    Some(Label::plain(Kind::BranchPoint))
                }
            }
        }
    }

    fn ends(&self, kind: Kind) -> bool {
        matches!(kind, Kind::Monitor(k) if self.settings.monitors.get(k).is_some_and(|m| m.stops))
    }
}

/// dλ/ds = wᵀ (dA/ds) q / wᵀ q.
pub(crate) fn rate(n: usize, a: &[f64], da: &[f64], value: Complex64) -> Complex64 {
    let q = eigenvector(n, a, value);
    let w = left_eigenvector(n, a, value);
    let mut top = Complex64::default();
    let mut bottom = Complex64::default();
    for i in 0..n {
        let mut image = Complex64::default();
        for j in 0..n {
            image += q[j] * da[i * n + j];
        }
        top += w[i] * image;
        bottom += w[i] * q[i];
    }
    // Close to a defective eigenvalue the rate is unbounded and of no use.
    if bottom.norm() < 1e-7 {
        Complex64::new(f64::NAN, f64::NAN)
    } else {
        top / bottom
    }
}
