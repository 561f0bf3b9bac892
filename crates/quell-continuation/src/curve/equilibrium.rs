//! Folds and Hopf points of equilibria in two parameters, by bordered systems.
//!
//! With M = `f_x` = A at a fold and M = A² + κ, κ = ω², at a Hopf point, [M, b; cᵀ, 0] (V; G) = (0; I) has G = 0 where M has a
//! null space of dimension one or two (Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria, 2000, ch. 3-5).
//! The unknowns are (x, p) or (x, κ, p); G gives one equation or two. With W from the transposed system, ∂G = -Wᵀ ∂M V.
//! Squaring A keeps the system regular at Bogdanov-Takens points, where κ passes zero.

use num_complex::Complex64;

use crate::branch::{Branch, Equilibrium, Special, assemble};
use crate::dense::{Lu, Spectrum, axpy, dot, eigenvalues, eigenvector, left_eigenvector, multiply};
use crate::equilibrium::{check, normal, rate};
use crate::kind::Kind;
use crate::path::{Failure, Found, Label, Manifold, Start, Trigger, follow_both};
use crate::problem::Problem;
use crate::settings::{ContinuationError, Settings};

type C = Complex64;

/// A point of a fold curve (ω = 0) or a Hopf curve.
#[derive(Clone, Debug, PartialEq)]
pub struct CriticalEquilibrium {
    /// The equilibrium.
    pub equilibrium: Equilibrium,
    /// ω, rad/s; zero at folds.
    pub omega: f64,
}

/// The curve of folds through a fold, in two parameters.
///
/// Special points: cusps, Bogdanov-Takens points (normal form: a = ½⟨p₁, B(q₀, q₀)⟩ and b = ⟨p₀, B(q₀, q₀)⟩ + ⟨p₁, B(q₀, q₁)⟩
/// with A q₀ = 0, A q₁ = q₀, Aᵀ p₁ = 0, Aᵀ p₀ = p₁, |q₀| = 1, ⟨p₀, q₀⟩ = ⟨p₁, q₁⟩ = 1), zero-Hopf points.
///
/// # Errors
///
/// Where lengths do not fit or the start is no fold.
pub fn fold_curve(
    problem: &dyn Problem,
    start: &Equilibrium,
    free: [usize; 2],
    settings: &Settings,
) -> Result<Branch<CriticalEquilibrium>, ContinuationError> {
    run(problem, start, None, free, settings)
}

/// The curve of Hopf points through a Hopf point with frequency ω, in two parameters.
///
/// Special points: generalised Hopf (`l_1` = 0), zero-Hopf, Hopf-Hopf points, and Bogdanov-Takens points, where the curve
/// ends.
///
/// # Errors
///
/// As [`fold_curve`].
pub fn hopf_curve(
    problem: &dyn Problem,
    start: &Special<Equilibrium>,
    free: [usize; 2],
    settings: &Settings,
) -> Result<Branch<CriticalEquilibrium>, ContinuationError> {
    let omega = start.omega.ok_or(ContinuationError::Start(
        "the point carries no frequency: it is no Hopf point",
    ))?;
    run(problem, &start.solution, Some(omega), free, settings)
}

fn run(
    problem: &dyn Problem,
    start: &Equilibrium,
    omega: Option<f64>,
    free: [usize; 2],
    settings: &Settings,
) -> Result<Branch<CriticalEquilibrium>, ContinuationError> {
    check(problem, start.state.len(), start.parameters.len(), &free)?;
    let n = problem.states();
    let mut z = start.state.clone();
    z.extend(omega.map(|w| w * w));
    z.extend(free.iter().map(|k| start.parameters[*k]));
    let mut m = Critical::new(problem, &start.parameters, free, omega.is_some(), settings);
    m.begin(&z);
    let (forward, backward) = follow_both(&mut m, settings, Start::AtParameter(z))?;
    let (parameters, hopf) = (m.parameters.clone(), m.hopf);
    Ok(assemble(
        &m,
        forward,
        backward,
        problem.is_approximate(),
        |node| {
            let mut p = parameters.clone();
            for (k, index) in free.iter().enumerate() {
                p[*index] = node.z[n + usize::from(hopf) + k];
            }
            CriticalEquilibrium {
                equilibrium: Equilibrium {
                    state: node.z[..n].to_vec(),
                    parameters: p,
                },
                omega: if hopf { node.z[n].max(0.0).sqrt() } else { 0.0 },
            }
        },
    ))
}

struct Critical<'a> {
    problem: &'a dyn Problem,
    parameters: Vec<f64>,
    free: [usize; 2],
    hopf: bool,
    settings: &'a Settings,
    n: usize,
    jacobian: Vec<f64>,
    columns: [Vec<f64>; 2],
    /// Border vectors, one or two of each.
    b: Vec<Vec<f64>>,
    c: Vec<Vec<f64>>,
    v: Vec<Vec<f64>>,
    w: Vec<Vec<f64>>,
    /// Weights of the entries of G in each equation.
    forms: Vec<Vec<f64>>,
    /// The equations besides f = 0 and their derivatives by every unknown.
    g: Vec<f64>,
    gradient: Vec<Vec<f64>>,
    lu: Lu<f64>,
    matrix: Vec<f64>,
    weights: Vec<f64>,
    scale: f64,
}

impl<'a> Critical<'a> {
    fn new(
        problem: &'a dyn Problem,
        parameters: &[f64],
        free: [usize; 2],
        hopf: bool,
        settings: &'a Settings,
    ) -> Self {
        let n = problem.states();
        let size = n + 2 + usize::from(hopf);
        let k = 1 + usize::from(hopf);
        Self {
            problem,
            parameters: parameters.to_vec(),
            free,
            hopf,
            settings,
            n,
            jacobian: vec![0.0; n * n],
            columns: [vec![0.0; n], vec![0.0; n]],
            b: Vec::new(),
            c: Vec::new(),
            v: Vec::new(),
            w: Vec::new(),
            forms: Vec::new(),
            g: vec![0.0; k],
            gradient: vec![vec![0.0; size]; k],
            lu: Lu::new(),
            matrix: Vec::new(),
            weights: vec![1e30; size],
            scale: settings.state_scale,
        }
    }

    fn first(&self) -> usize {
        self.n + usize::from(self.hopf)
    }

    fn omega(&self, z: &[f64]) -> f64 {
        if self.hopf {
            z[self.n].max(0.0).sqrt()
        } else {
            0.0
        }
    }

    fn set(&mut self, z: &[f64]) {
        for k in 0..2 {
            self.parameters[self.free[k]] = z[self.first() + k];
        }
    }

    /// Border vectors from the eigenvectors at the start.
    fn begin(&mut self, z: &[f64]) {
        let n = self.n;
        self.set(z);
        self.problem
            .jacobian(0.0, &z[..n], &self.parameters, &mut self.jacobian);
        let value = C::new(0.0, self.omega(z));
        let parts = |x: Vec<C>| {
            let mut out = vec![x.iter().map(|c| c.re).collect::<Vec<f64>>()];
            if self.hopf {
                out.push(x.iter().map(|c| c.im).collect());
            }
            orthonormal(out)
        };
        self.c = parts(eigenvector(n, &self.jacobian, value));
        self.b = parts(left_eigenvector(n, &self.jacobian, value));
        self.forms();
    }

    /// G is about (trace) S + (κ - det) I on the critical plane, S being A there: the equations are its products with both.
    fn forms(&mut self) {
        let n = self.n;
        let product = |a: &[f64], b: &[f64]| dot(a, b);
        let mut identity = Vec::new();
        let mut image = Vec::new();
        let mut moved = vec![0.0; n];
        for b in &self.b {
            for c in &self.c {
                multiply(&self.jacobian, c, &mut moved);
                identity.push(product(b, c));
                image.push(product(b, &moved));
            }
        }
        let unit = |x: Vec<f64>| -> Vec<f64> {
            let size = dot(&x, &x).sqrt().max(1e-300);
            x.iter().map(|x| x / size).collect()
        };
        self.forms = if self.hopf {
            vec![unit(image), unit(identity)]
        } else {
            vec![vec![1.0]]
        };
    }

    /// v, w, g and its derivatives at the Jacobian at hand.
    fn bordered(&mut self, z: &[f64]) -> bool {
        let n = self.n;
        let nb = self.b.len();
        let size = n + nb;
        let mut matrix = vec![0.0; size * size];
        for i in 0..n {
            if self.hopf {
                for k in 0..n {
                    let a = self.jacobian[i * n + k];
                    for j in 0..n {
                        matrix[i * size + j] += a * self.jacobian[k * n + j];
                    }
                }
                matrix[i * size + i] += z[n];
            } else {
                matrix[i * size..i * size + n].copy_from_slice(&self.jacobian[i * n..(i + 1) * n]);
            }
            for k in 0..nb {
                matrix[i * size + n + k] = self.b[k][i];
                matrix[(n + k) * size + i] = self.c[k][i];
            }
        }
        let mut lu = Lu::new();
        if !lu.factor(size, &matrix) {
            return false;
        }
        self.v.clear();
        self.w.clear();
        let mut entries = vec![0.0; nb * nb];
        for k in 0..nb {
            let mut right = vec![0.0; size];
            right[n + k] = 1.0;
            let mut left = right.clone();
            lu.solve(&mut right);
            lu.solve_transposed(&mut left);
            for i in 0..nb {
                entries[i * nb + k] = right[n + i];
            }
            right.truncate(n);
            left.truncate(n);
            self.v.push(right);
            self.w.push(left);
        }
        for (g, form) in self.g.iter_mut().zip(&self.forms) {
            *g = dot(form, &entries);
        }
        self.differentiate(z);
        self.v
            .iter()
            .chain(&self.w)
            .flatten()
            .all(|x| x.is_finite())
    }

    /// ∂G_ij = -w_iᵀ ∂M v_j by central differences of exact first derivatives along v_j and A v_j.
    fn differentiate(&mut self, z: &[f64]) {
        let n = self.n;
        let nb = self.b.len();
        let first = self.first();
        let mut gradient = std::mem::take(&mut self.gradient);
        for g in &mut gradient {
            g.fill(0.0);
        }
        for j in 0..nb {
            // Pairs (direction u, and for each equation the left vector a) with ∂g = -Σ aᵀ ∂A u.
            let lefts = |transposed: bool| -> Vec<Vec<f64>> {
                self.forms
                    .iter()
                    .map(|form| {
                        let mut a = vec![0.0; n];
                        for i in 0..nb {
                            axpy(form[i * nb + j], &self.w[i], &mut a);
                        }
                        if !transposed {
                            return a;
                        }
                        (0..n)
                            .map(|c| (0..n).map(|r| a[r] * self.jacobian[r * n + c]).sum())
                            .collect()
                    })
                    .collect()
            };
            let mut pairs = Vec::new();
            if self.hopf {
                let mut image = vec![0.0; n];
                multiply(&self.jacobian, &self.v[j], &mut image);
                pairs.push((image, lefts(false)));
                pairs.push((self.v[j].clone(), lefts(true)));
            } else {
                pairs.push((self.v[j].clone(), lefts(false)));
            }
            for (direction, lefts) in pairs {
                let size = crate::dense::largest(&direction);
                if !(size > 0.0) {
                    continue;
                }
                let h = 1e-5 * self.scale / size;
                let up: Vec<f64> = (0..n).map(|i| z[i] + h * direction[i]).collect();
                let down: Vec<f64> = (0..n).map(|i| z[i] - h * direction[i]).collect();
                let (mut plus, mut minus) = (vec![0.0; n * n], vec![0.0; n * n]);
                self.problem.jacobian(0.0, &up, &self.parameters, &mut plus);
                self.problem
                    .jacobian(0.0, &down, &self.parameters, &mut minus);
                for (g, a) in gradient.iter_mut().zip(&lefts) {
                    for i in 0..n {
                        for j in 0..n {
                            g[j] -= a[i] * (plus[i * n + j] - minus[i * n + j]) / (2.0 * h);
                        }
                    }
                }
                for k in 0..2 {
                    self.problem.parameter_derivative(
                        0.0,
                        &up,
                        &self.parameters,
                        self.free[k],
                        &mut plus[..n],
                    );
                    self.problem.parameter_derivative(
                        0.0,
                        &down,
                        &self.parameters,
                        self.free[k],
                        &mut minus[..n],
                    );
                    for (g, a) in gradient.iter_mut().zip(&lefts) {
                        for i in 0..n {
                            g[first + k] -= a[i] * (plus[i] - minus[i]) / (2.0 * h);
                        }
                    }
                }
            }
            if self.hopf {
                for (g, form) in gradient.iter_mut().zip(&self.forms) {
                    for i in 0..nb {
                        g[n] -= form[i * nb + j] * dot(&self.w[i], &self.v[j]);
                    }
                }
            }
        }
        self.gradient = gradient;
    }

    fn equations(&self) -> usize {
        self.first() + 1
    }
}

/// Gram-Schmidt.
fn orthonormal(mut x: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    for k in 0..x.len() {
        let (done, rest) = x.split_at_mut(k);
        let here = &mut rest[0];
        for _ in 0..2 {
            for d in done.iter() {
                let s = dot(d, here);
                axpy(-s, d, here);
            }
        }
        let size = dot(here, here).sqrt();
        if size > 0.0 {
            for h in here.iter_mut() {
                *h /= size;
            }
        }
    }
    x
}

impl Manifold for Critical<'_> {
    fn len(&self) -> usize {
        self.first() + 2
    }

    fn residual(&mut self, z: &[f64], out: &mut [f64]) -> Result<(), Failure> {
        let n = self.n;
        self.set(z);
        self.problem
            .value(0.0, &z[..n], &self.parameters, &mut out[..n]);
        // g is that of the factorisation, which is always at this z.
        out[n..=n + usize::from(self.hopf)].copy_from_slice(&self.g);
        if out[..self.equations()].iter().all(|x| x.is_finite()) {
            Ok(())
        } else {
            Err(Failure::NotFinite)
        }
    }

    fn factor(&mut self, z: &[f64]) -> Result<(), Failure> {
        let n = self.n;
        self.set(z);
        self.problem
            .jacobian(0.0, &z[..n], &self.parameters, &mut self.jacobian);
        for k in 0..2 {
            self.problem.parameter_derivative(
                0.0,
                &z[..n],
                &self.parameters,
                self.free[k],
                &mut self.columns[k],
            );
        }
        if !self.bordered(z) {
            return Err(Failure::NotFinite);
        }
        Ok(())
    }

    fn border(&mut self, row: &[f64]) -> Result<(), Failure> {
        let n = self.n;
        let size = self.len();
        let first = self.first();
        self.matrix.clear();
        self.matrix.resize(size * size, 0.0);
        for i in 0..n {
            self.matrix[i * size..i * size + n].copy_from_slice(&self.jacobian[i * n..(i + 1) * n]);
            for k in 0..2 {
                self.matrix[i * size + first + k] = self.columns[k][i];
            }
        }
        for (k, gradient) in self.gradient.iter().enumerate() {
            self.matrix[(n + k) * size..(n + k + 1) * size].copy_from_slice(gradient);
        }
        self.matrix[(size - 1) * size..].copy_from_slice(row);
        if self.lu.factor(size, &self.matrix) {
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
        vec![self.first(), self.first() + 1]
    }

    fn rescale(&mut self, z: &[f64]) {
        let n = self.n;
        let rms = (dot(&z[..n], &z[..n]) / n as f64).sqrt();
        if rms.is_finite() {
            self.scale = self.scale.max(rms);
        }
        self.weights[..n].fill(1.0 / (self.scale * self.scale * n as f64));
        if self.hopf {
            // κ = ω² passes zero at a Bogdanov-Takens point: the scale is the largest so far.
            self.weights[n] = self.weights[n].min(z[n].powi(-2));
        }
        let first = self.first();
        for k in 0..2 {
            self.weights[first + k] = self.settings.parameter_scale(k, z[first + k]).powi(-2);
        }
    }

    fn accept(&mut self, _z: &[f64]) {
        if self.v.is_empty() {
            return;
        }
        self.c = orthonormal(self.v.clone());
        self.b = orthonormal(self.w.clone());
        self.forms();
    }

    fn spectrum(&mut self, z: &[f64], tangent: &[f64]) -> Spectrum {
        let n = self.n;
        let omega = self.omega(z);
        let Some(mut values) = eigenvalues(n, &self.jacobian) else {
            return Spectrum::default();
        };
        // The critical ones are left out.
        for target in [C::new(0.0, omega), C::new(0.0, -omega)]
            .iter()
            .take(if self.hopf { 2 } else { 1 })
        {
            let nearest = (0..values.len()).min_by(|i, j| {
                (values[*i] - target)
                    .norm()
                    .total_cmp(&(values[*j] - target).norm())
            });
            if let Some(i) = nearest {
                values.remove(i);
            }
        }
        let h = 1e-5;
        let (mut plus, mut minus) = (vec![0.0; n * n], vec![0.0; n * n]);
        for (sign, out) in [(1.0, &mut plus), (-1.0, &mut minus)] {
            let moved: Vec<f64> = z
                .iter()
                .zip(tangent)
                .map(|(z, t)| z + sign * h * t)
                .collect();
            self.set(&moved);
            self.problem
                .jacobian(0.0, &moved[..n], &self.parameters, out);
        }
        self.set(z);
        for (p, m) in plus.iter_mut().zip(&minus) {
            *p = (*p - m) / (2.0 * h);
        }
        let rates = values
            .iter()
            .map(|v| rate(n, &self.jacobian, &plus, *v))
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
        let n = self.n;
        if self.hopf {
            let omega = self.omega(z);
            let l1 = if omega > 0.0 {
                normal::hopf(
                    self.problem,
                    &z[..n],
                    &self.parameters,
                    &self.jacobian,
                    omega,
                )
            } else {
                None
            };
            // ω l₁ stays bounded towards Bogdanov-Takens points.
            return vec![z[n], l1.map_or(f64::NAN, |l| l * omega)];
        }
        let (v, w) = (&self.v[0], &self.w[0]);
        let size = (dot(v, v) * dot(w, w)).sqrt();
        vec![dot(w, v) / size, -dot(&self.gradient[0][..n], v) / size]
    }

    fn classify(&mut self, found: &Found<'_>) -> Option<Label> {
        let n = self.n;
        let z = &found.node.z;
        match found.trigger {
            Trigger::Test(0) => {
                let mut label = Label::plain(Kind::BogdanovTakens);
                if !self.hopf {
                    self.factor(z).ok()?;
                    label.normal_form = normal::bogdanov_takens(
                        self.problem,
                        &z[..n],
                        &self.parameters,
                        &self.jacobian,
                    )
                    .unwrap_or_default();
                }
                Some(label)
            }
            Trigger::Test(k) => {
                // A pole of the test function changes sign as well.
                let here = found.node.tests[k].abs();
                if here > 1e-3 * (found.before.tests[k].abs() + found.after.tests[k].abs()) {
                    return None;
                }
                if self.hopf {
                    return Some(Label {
                        omega: Some(self.omega(z)),
                        ..Label::plain(Kind::GeneralisedHopf)
                    });
                }
                self.factor(z).ok()?;
                let cubic = normal::cusp(self.problem, &z[..n], &self.parameters, &self.jacobian);
                Some(Label {
                    normal_form: cubic.into_iter().collect(),
                    ..Label::plain(Kind::Cusp)
                })
            }
            Trigger::Crossing(v) | Trigger::Touch(v) => {
                let complex = v.im.abs() > 1e-6 * (1.0 + v.norm());
                let omega = match (self.hopf, complex) {
                    (true, true) => {
                        self.factor(z).ok()?;
                        let omegas = [self.omega(z), v.im.abs()];
                        let (x, p) = (&z[..n], &self.parameters);
                        let found = normal::hopf_hopf(self.problem, x, p, &self.jacobian, omegas);
                        return Some(Label {
                            kind: Kind::HopfHopf,
                            omega: Some(omegas[0]),
                            second_omega: Some(omegas[1]),
                            normal_form: found.unwrap_or_default(),
                        });
                    }
                    // At a Bogdanov-Takens point ω vanishes too, and its own test names it.
                    (true, false) if z[n] > 1e-8 => self.omega(z),
                    (false, true) => v.im.abs(),
                    _ => return None,
                };
                self.factor(z).ok()?;
                let (x, p) = (&z[..n], &self.parameters);
                let found = normal::zero_hopf(self.problem, x, p, &self.jacobian, omega);
                Some(Label {
                    omega: Some(omega),
                    normal_form: found.unwrap_or_default(),
                    ..Label::plain(Kind::ZeroHopf)
                })
            }
        }
    }

    fn ends(&self, kind: Kind) -> bool {
        self.hopf && kind == Kind::BogdanovTakens
    }

    fn restart(&mut self, node: &crate::path::Node) {
        self.begin(&node.z);
    }
}
