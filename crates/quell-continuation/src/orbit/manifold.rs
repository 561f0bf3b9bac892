//! Periodic orbits as solutions of one system: collocation, phase, and the arclength row.

use num_complex::Complex64;

use super::bordered::{Bordered, Row};
use super::collocation::Collocation;
use super::cycle::Orbit;
use super::floquet;
use super::frame::Frame;
use super::normal;
use crate::curve::Mode;
use crate::dense::{Spectrum, dot};
use crate::kind::Kind;
use crate::monitor::View;
use crate::path::{Failure, Found, Label, Manifold, Node, Trigger};
use crate::settings::{Settings, Stop};

pub(crate) struct Cycles<'a> {
    pub(crate) c: Collocation<'a>,
    settings: &'a Settings,
    bordered: Bordered,
    frame: Frame,
    arclength: Row,
    weights: Vec<f64>,
    /// Largest fluctuation so far, and for how many points the parameter has stood still.
    largest: f64,
    still: usize,
}

impl<'a> Cycles<'a> {
    pub(crate) fn new(c: Collocation<'a>, settings: &'a Settings) -> Self {
        Self {
            c,
            settings,
            bordered: Bordered::default(),
            frame: Frame::new(settings.state_scale),
            arclength: Row::default(),
            weights: Vec::new(),
            largest: 0.0,
            still: 0,
        }
    }

    /// The orbit of a node.
    pub(crate) fn orbit(&self, node: &Node) -> Orbit {
        orbit(&self.c, &node.z, &node.mesh)
    }

    /// x - mean over the nodes.
    fn fluctuation(&self, z: &[f64]) -> Vec<f64> {
        let n = self.c.n;
        let w = self.c.weights();
        let mut mean = vec![0.0; n];
        for (w, x) in w.iter().zip(z.chunks_exact(n)) {
            crate::dense::axpy(*w, x, &mut mean);
        }
        let mut out = z[..self.c.nodes()].to_vec();
        for x in out.chunks_exact_mut(n) {
            crate::dense::axpy(-1.0, &mean, x);
        }
        out
    }
}

impl Cycles<'_> {
    /// Coefficients at a special point; empty where they cannot be had.
    fn normal_form(&mut self, node: &Node, mode: Mode, angle: f64) -> Vec<f64> {
        if self.c.problem.is_approximate() || self.factor(&node.z).is_err() {
            return Vec::new();
        }
        let phase = &self.frame.phase.nodes;
        normal::coefficients_alone(&self.c, &self.bordered, phase, mode, angle).unwrap_or_default()
    }
}

/// Builds an orbit from unknowns on a mesh.
pub(crate) fn orbit(c: &Collocation<'_>, z: &[f64], mesh: &[f64]) -> Orbit {
    let n = c.n;
    let nodes = (mesh.len() - 1) * c.rule.m * n;
    let mut states = z[..nodes].to_vec();
    for j in 0..n {
        states.push(z[j] + c.winding[j]);
    }
    let first = nodes + usize::from(c.autonomous);
    let mut parameters = c.parameters.clone();
    for (k, index) in c.free.iter().enumerate() {
        parameters[*index] = z[first + k];
    }
    let period = if c.autonomous {
        z[nodes]
    } else {
        c.periods as f64 * c.problem.period(&parameters).unwrap_or(f64::NAN)
    };
    Orbit {
        mesh: mesh.to_vec(),
        degree: c.rule.m,
        dimension: n,
        states,
        period,
        periods: c.periods,
        winding: c
            .winding
            .iter()
            .map(|w| w / std::f64::consts::TAU)
            .collect(),
        parameters,
    }
}

impl Manifold for Cycles<'_> {
    fn len(&self) -> usize {
        self.c.nodes() + self.c.borders()
    }

    fn residual(&mut self, z: &[f64], out: &mut [f64]) -> Result<(), Failure> {
        self.c.residual(z, out)?;
        if self.c.autonomous {
            out[self.c.nodes()] = self.frame.offset(z);
        }
        Ok(())
    }

    fn factor(&mut self, z: &[f64]) -> Result<(), Failure> {
        self.c.linearise(z)?;
        let columns: Vec<Option<&[f64]>> = self
            .c
            .columns
            .iter()
            .map(|column| Some(column.as_slice()))
            .collect();
        self.bordered.columns(&self.c.condensed, &columns);
        Ok(())
    }

    fn border(&mut self, row: &[f64]) -> Result<(), Failure> {
        let nodes = self.c.nodes();
        self.arclength.nodes.clear();
        self.arclength.nodes.extend_from_slice(&row[..nodes]);
        self.arclength.ends.clear();
        self.arclength.ends.extend_from_slice(&row[nodes..]);
        let fine = if self.c.autonomous {
            self.bordered
                .rows(&self.c.condensed, &[&self.frame.phase, &self.arclength])
        } else {
            self.bordered.rows(&self.c.condensed, &[&self.arclength])
        };
        if fine {
            Ok(())
        } else {
            Err(Failure::NotFinite)
        }
    }

    fn solve(&mut self, b: &mut [f64]) {
        self.bordered.solve(&self.c.condensed, b);
    }

    fn weights(&self) -> &[f64] {
        &self.weights
    }

    fn parameters(&self) -> Vec<usize> {
        vec![self.c.first_parameter()]
    }

    fn chord(&self) -> bool {
        true
    }

    fn rescale(&mut self, z: &[f64]) {
        self.frame.weigh(&self.c, z, &mut self.weights);
        let first = self.c.first_parameter();
        self.weights
            .push(self.settings.parameter_scale(0, z[first]).powi(-2));
    }

    fn spectrum(&mut self, z: &[f64], _tangent: &[f64]) -> Spectrum {
        let found = floquet::multipliers(&self.c, z).unwrap_or_default();
        let rates = vec![Complex64::new(f64::NAN, f64::NAN); found.values.len()];
        Spectrum {
            values: found.values,
            rates,
            error: found.error,
        }
    }

    fn distance(&self, value: Complex64) -> f64 {
        value.norm().ln()
    }

    /// In the logarithm: a real multiplier does not pass through zero.
    fn gap(&self, a: Complex64, b: Complex64) -> f64 {
        let ratio = a / b;
        if ratio.norm() > 0.0 && ratio.norm().is_finite() {
            ratio.ln().norm()
        } else {
            1e3
        }
    }

    fn longest_gap(&self) -> f64 {
        1.0
    }

    fn distance_rate(&self, value: Complex64, rate: Complex64) -> f64 {
        (rate / value).re
    }

    fn tests(&mut self, z: &[f64], _tangent: &[f64], _spectrum: &Spectrum) -> Vec<f64> {
        if self.settings.monitors.is_empty() {
            return Vec::new();
        }
        self.c.set(z);
        let view = View {
            states: &z[..self.c.nodes()],
            dimension: self.c.n,
            parameters: &self.c.parameters,
            period: Some(self.c.period),
        };
        self.settings
            .monitors
            .iter()
            .map(|m| m.value(&view))
            .collect()
    }

    fn classify(&mut self, found: &Found<'_>) -> Option<Label> {
        let v = match found.trigger {
            Trigger::Test(k) => return Some(Label::plain(Kind::Monitor(k))),
            Trigger::Crossing(v) | Trigger::Touch(v) => v,
        };
        if v.im.abs() > 1e-6 {
            let mut label = Label::plain(Kind::Torus);
            let angle = v.arg().abs();
            label.omega = Some(angle);
            label.normal_form = self.normal_form(found.node, Mode::Torus, angle);
            return Some(label);
        }
        if v.re < 0.0 {
            let mut label = Label::plain(Kind::PeriodDoubling);
            label.normal_form = self.normal_form(found.node, Mode::Doubling, std::f64::consts::PI);
            return Some(label);
        }
        // A family without a moving parameter has multiplier one all along.
        let near = |n: &Node| {
            n.spectrum
                .values
                .iter()
                .map(|x| (x - 1.0).norm())
                .fold(f64::INFINITY, f64::min)
                < 1e-7_f64.max(10.0 * n.spectrum.error)
        };
        if near(found.before) && near(found.after) {
            return None;
        }
        let p = self.c.first_parameter();
        if found.before.tangent[p] * found.after.tangent[p] < 0.0 {
            let mut label = Label::plain(Kind::CycleFold);
            label.normal_form = self.normal_form(found.node, Mode::Fold, 0.0);
            Some(label)
        } else {
            Some(Label::plain(Kind::CycleBranchPoint))
        }
    }

    fn adapt(&mut self, z: &mut Vec<f64>, tangents: &mut [&mut Vec<f64>], count: usize) -> bool {
        let moved = self
            .frame
            .adapt(&mut self.c, &self.settings.mesh, z, tangents, count);
        if moved {
            self.accept(z);
        }
        moved
    }

    fn accept(&mut self, z: &[f64]) {
        self.frame.anchor(&self.c, z);
    }

    fn restart(&mut self, node: &Node) {
        self.c.set_mesh(node.mesh.clone());
        self.frame.forget();
        self.rescale(&node.z);
        self.accept(&node.z);
        self.still = 0;
        self.largest = 0.0;
    }

    fn stop(&mut self, before: &Node, now: &Node) -> Option<Stop> {
        let nodes = self.c.nodes();
        if self.c.autonomous && now.z[nodes] > self.settings.period_bound {
            return Some(Stop::PeriodBound);
        }
        if !self.c.autonomous {
            return None;
        }
        let (a, b) = (self.fluctuation(&before.z), self.fluctuation(&now.z));
        let (sa, sb) = (dot(&a, &a).sqrt(), dot(&b, &b).sqrt());
        self.largest = self.largest.max(sa);
        if dot(&a, &b) < 0.0 || sb < 1e-4 * self.largest {
            return Some(Stop::Vanished);
        }
        let p = self.c.first_parameter();
        let moved = (now.z[p] - before.z[p]).abs() / self.settings.parameter_scale(0, now.z[p]);
        let grown = (sb - sa).abs() / sb;
        // Near a homoclinic orbit the parameter stands still as well, but no second multiplier is one.
        let double = now.spectrum.values.iter().any(|v| (v - 1.0).norm() < 1e-6);
        if moved < 1e-10 && grown > 1e-5 && (double || !self.settings.detect) {
            self.still += 1;
        } else {
            self.still = 0;
        }
        (self.still >= 5).then_some(Stop::DegenerateFamily)
    }

    fn mesh(&self) -> Vec<f64> {
        self.c.mesh.clone()
    }

    fn ends(&self, kind: Kind) -> bool {
        matches!(kind, Kind::Monitor(k) if self.settings.monitors.get(k).is_some_and(|m| m.stops))
    }
}
