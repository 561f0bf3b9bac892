//! Folds, period doublings and torus points of cycles in two parameters.
//!
//! The orbit's own equations are completed by g = 0 of a bordered system on the same condensed linearisation (minimally
//! augmented systems: Govaerts, Kuznetsov and Dhooge, SIAM J. Sci. Comput. 27, 2005), with exact ∂g but for second
//! derivatives of f, which are differences of exact first ones: they steer Newton and do not enter the solution.

use num_complex::Complex64;

use super::variation::{Mode, ReducedPhase, Variation};
use crate::branch::{Branch, Special, assemble};
use crate::dense::{Spectrum, dot};
use crate::kind::{Certainty, Kind};
use crate::orbit::bordered::{Bordered, Row};
use crate::orbit::collocation::Collocation;
use crate::orbit::frame::Frame;
use crate::orbit::manifold::orbit;
use crate::orbit::{Orbit, floquet, normal, small_cycle, unpack};
use crate::path::{
    Attention, Failure, Found, Label, Located, Manifold, Node, Start, Trace, Trigger, follow_both,
};
use crate::problem::Problem;
use crate::settings::{ContinuationError, Settings, Stop};

use super::CriticalEquilibrium;

type C = Complex64;

/// A point of a curve of special cycles.
#[derive(Clone, Debug, PartialEq)]
pub struct CriticalOrbit {
    /// The orbit.
    pub orbit: Orbit,
    /// θ of the critical multipliers exp(±iθ), rad: 0 on curves of folds, π on those of period doublings.
    pub angle: f64,
}

/// The curve of folds, period doublings or torus points of cycles through such a point, in two parameters.
///
/// Special points: on folds, cusps of cycles and the resonance 1:1; on period doublings the resonance 1:2 and generalised period
/// doublings; on torus points the resonances 1:1 to 1:4, of which the first two end the curve, and Chenciner points; on all of them
/// points where a further multiplier or pair is on the unit circle.
///
/// # Errors
///
/// Where the start is of none of these kinds, lengths do not fit or Newton does not converge.
pub fn cycle_curve(
    problem: &dyn Problem,
    start: &Special<Orbit>,
    free: [usize; 2],
    settings: &Settings,
) -> Result<Branch<CriticalOrbit>, ContinuationError> {
    let (mode, angle) = match start.kind {
        Kind::CycleFold => (Mode::Fold, 0.0),
        Kind::PeriodDoubling => (Mode::Doubling, std::f64::consts::PI),
        Kind::Torus => (
            Mode::Torus,
            start
                .omega
                .ok_or(ContinuationError::Start("the torus point carries no angle"))?,
        ),
        _ => {
            return Err(ContinuationError::Start(
                "curves start at folds, period doublings or torus points of cycles",
            ));
        }
    };
    cycle_curve_from_orbit(problem, &start.solution, mode, angle, free, settings)
}

fn cycle_curve_from_orbit(
    problem: &dyn Problem,
    start: &Orbit,
    mode: Mode,
    angle: f64,
    free: [usize; 2],
    settings: &Settings,
) -> Result<Branch<CriticalOrbit>, ContinuationError> {
    let (c, mut z) = unpack(problem, start, &free)?;
    if mode == Mode::Torus {
        z.insert(c.nodes() + usize::from(c.autonomous), angle);
    }
    let mut m = Curves::new(c, mode, settings);
    m.rescale(&z);
    m.accept(&z);
    m.begin(&z)?;
    run(&mut m, settings, Start::AtParameter(z))
}

/// The torus curve that leaves a Hopf-Hopf point with the cycle of frequency `omega`, the other pair's frequency being
/// `other`.
///
/// # Errors
///
/// Where lengths do not fit or no small cycle is found.
pub fn torus_from_hopf_hopf(
    problem: &dyn Problem,
    at: &CriticalEquilibrium,
    omega: f64,
    other: f64,
    free: [usize; 2],
    settings: &Settings,
) -> Result<Branch<CriticalOrbit>, ContinuationError> {
    let full = std::f64::consts::TAU * other / omega;
    // exp(iθ) and its conjugate are the same pair: θ in (0, π).
    let mut angle = full.rem_euclid(std::f64::consts::TAU);
    if angle > std::f64::consts::PI {
        angle = std::f64::consts::TAU - angle;
    }
    small_curve(problem, at, omega, Mode::Torus, angle, free, settings)
}

/// The curve of folds of cycles that leaves a generalised Hopf point.
///
/// # Errors
///
/// Where lengths do not fit or no small cycle is found.
pub fn fold_from_generalised_hopf(
    problem: &dyn Problem,
    at: &CriticalEquilibrium,
    free: [usize; 2],
    settings: &Settings,
) -> Result<Branch<CriticalOrbit>, ContinuationError> {
    small_curve(problem, at, at.omega, Mode::Fold, 0.0, free, settings)
}

fn small_curve(
    problem: &dyn Problem,
    at: &CriticalEquilibrium,
    omega: f64,
    mode: Mode,
    angle: f64,
    free: [usize; 2],
    settings: &Settings,
) -> Result<Branch<CriticalOrbit>, ContinuationError> {
    let e = &at.equilibrium;
    crate::equilibrium::check(problem, e.state.len(), e.parameters.len(), &free)?;
    let (c, mut z, mut direction) = small_cycle(problem, e, omega, &free, settings);
    if mode == Mode::Torus {
        z.insert(c.nodes() + 1, angle);
        direction.insert(c.nodes() + 1, 0.0);
    }
    let mut m = Curves::new(c, mode, settings);
    m.rescale(&z);
    let size = crate::path::inner(m.weights(), &direction, &direction).sqrt();
    let off: Vec<f64> = z
        .iter()
        .zip(&direction)
        .map(|(z, d)| z + settings.initial_step * d / size)
        .collect();
    m.accept(&off);
    m.begin(&off)?;
    run(
        &mut m,
        settings,
        Start::Along(z, direction, settings.initial_step),
    )
}

fn run(
    m: &mut Curves<'_>,
    settings: &Settings,
    start: Start,
) -> Result<Branch<CriticalOrbit>, ContinuationError> {
    let (mut forward, mut backward) = follow_both(m, settings, start)?;
    for trace in [&mut forward, &mut backward] {
        m.end_at_resonance(trace);
    }
    let approximate = m.c.problem.is_approximate();
    Ok(assemble(m, forward, backward, approximate, |node| {
        m.solution(node)
    }))
}

/// A torus curve of an autonomous problem that breaks off below this angle, rad, has come to the resonance 1:1.
///
/// The critical pair and the trivial multiplier are all at +1 there, so that the bordered system is singular as one over the angle.
const RESONANT: f64 = 0.02;

struct Curves<'a> {
    c: Collocation<'a>,
    mode: Mode,
    settings: &'a Settings,
    bordered: Bordered,
    frame: Frame,
    variation: Variation,
    arclength: Row,
    weights: Vec<f64>,
    largest: f64,
    /// Where the factorisation at hand is; empty where there is none.
    factored: Vec<f64>,
    attention: Attention,
}

impl<'a> Curves<'a> {
    fn new(c: Collocation<'a>, mode: Mode, settings: &'a Settings) -> Self {
        Self {
            c,
            mode,
            settings,
            bordered: Bordered::default(),
            frame: Frame::new(settings.state_scale),
            variation: Variation::default(),
            arclength: Row::default(),
            weights: Vec::new(),
            largest: 0.0,
            factored: Vec::new(),
            attention: Attention::All,
        }
    }

    fn torus(&self) -> bool {
        self.mode == Mode::Torus
    }

    /// Index of θ among the unknowns, where it is one.
    fn angle_index(&self) -> usize {
        self.c.nodes() + usize::from(self.c.autonomous)
    }

    fn first(&self) -> usize {
        self.angle_index() + usize::from(self.torus())
    }

    /// The unknowns without θ, as the collocation wants them.
    fn strip(&self, z: &[f64]) -> Vec<f64> {
        let mut out = z.to_vec();
        if self.torus() {
            out.remove(self.angle_index());
        }
        out
    }

    fn multiplier(&self, z: &[f64]) -> C {
        match self.mode {
            Mode::Fold => C::new(1.0, 0.0),
            Mode::Doubling => C::new(-1.0, 0.0),
            Mode::Torus => C::from_polar(1.0, z[self.angle_index()]),
        }
    }

    fn solution(&self, node: &Node) -> CriticalOrbit {
        CriticalOrbit {
            orbit: orbit(
                &self.c,
                &self.strip_with(&node.z, node.mesh.len()),
                &node.mesh,
            ),
            angle: match self.mode {
                Mode::Fold => 0.0,
                Mode::Doubling => std::f64::consts::PI,
                Mode::Torus => {
                    node.z[(node.mesh.len() - 1) * self.c.rule.m * self.c.n
                        + usize::from(self.c.autonomous)]
                }
            },
        }
    }

    fn strip_with(&self, z: &[f64], mesh: usize) -> Vec<f64> {
        let mut out = z.to_vec();
        if self.torus() {
            out.remove((mesh - 1) * self.c.rule.m * self.c.n + usize::from(self.c.autonomous));
        }
        out
    }

    /// The phase row reduced on the linearisation at hand, where the critical system needs it.
    fn reduced_phase(&self) -> Option<ReducedPhase> {
        (self.c.autonomous && self.mode == Mode::Fold)
            .then(|| ReducedPhase::of(&self.c, &self.bordered, &self.frame.phase.nodes))
    }

    fn linearise(&mut self, z: &[f64]) -> Result<(), Failure> {
        let stripped = self.strip(z);
        self.c.linearise(&stripped)?;
        // Columns: period, θ (none in the collocation), parameters.
        let offset = usize::from(self.c.autonomous);
        let mut columns: Vec<Option<&[f64]>> = self
            .c
            .columns
            .iter()
            .map(|column| Some(column.as_slice()))
            .collect();
        if self.torus() {
            columns.insert(offset, None);
        }
        self.bordered.columns(&self.c.condensed, &columns);
        Ok(())
    }

    fn begin(&mut self, z: &[f64]) -> Result<(), ContinuationError> {
        self.linearise(z)?;
        let phase = self.reduced_phase();
        let mu = self.multiplier(z);
        self.variation
            .begin(&self.c, &self.bordered, mu, phase.as_ref());
        Ok(())
    }

    /// The coefficient whose sign tells which way what is born here is born, times what takes its poles at strong resonances away:
    /// ⟨w, v⟩ for a period doubling, whose sign is continued from point to point, |⟨w, v⟩|² for a torus.
    fn coefficient(&self, test: usize, angle: f64) -> f64 {
        let wanted = match self.attention {
            Attention::All => true,
            Attention::Test(k) => k == test,
            Attention::Spectrum => false,
        };
        if !wanted || self.c.problem.is_approximate() {
            return f64::NAN;
        }
        let phase = &self.frame.phase.nodes;
        normal::coefficients(
            &self.c,
            &self.bordered,
            phase,
            self.mode,
            angle,
            &self.variation,
        )
        .and_then(|(found, pairing)| {
            let factor = if self.torus() {
                pairing.norm_sqr()
            } else {
                pairing.re
            };
            Some(found.first()? * factor)
        })
        .unwrap_or(f64::NAN)
    }

    /// Names the resonance 1:1 to which a torus curve has come as near as its equations let it.
    fn end_at_resonance(&self, trace: &mut Trace) {
        let broken = matches!(trace.stop, Stop::NoConvergence | Stop::Singular);
        if !(self.torus() && self.c.autonomous && broken) {
            return;
        }
        // The last points may go to and fro within what can be told.
        let angle = |node: &Node| node.z[self.angle_index()];
        let Some(index) = (0..trace.nodes.len())
            .min_by(|a, b| angle(&trace.nodes[*a]).total_cmp(&angle(&trace.nodes[*b])))
        else {
            return;
        };
        let node = trace.nodes[index].clone();
        let near = angle(&node);
        if near > RESONANT {
            return;
        }
        trace.nodes.truncate(index + 1);
        trace.located.retain(|one| one.index < index);
        trace.at.retain(|(after, _)| *after < index);
        let unstable = node.unstable(self);
        let mut label = Label::plain(Kind::Resonance1);
        label.omega = Some(near);
        trace.located.push(Located {
            label,
            node,
            before: unstable,
            after: unstable,
            certainty: Certainty::Unresolved,
            // The distance goes with the square of the angle.
            error: near * near,
            index,
        });
        trace.stop = Stop::EndOfKind;
    }

    /// What a further multiplier on the unit circle makes of a point.
    fn other(&self, value: C) -> Option<Kind> {
        let own = C::new(
            if self.mode == Mode::Doubling {
                -1.0
            } else {
                1.0
            },
            0.0,
        );
        if self.mode != Mode::Torus && (value - own).norm() < 1e-3 {
            return (self.mode == Mode::Fold && self.c.autonomous).then_some(Kind::Resonance1);
        }
        let complex = value.im.abs() > 1e-6;
        match (self.mode, complex, value.re > 0.0) {
            // Tests of their own name the strong resonances; an autonomous fold has none for +1.
            (Mode::Fold, false, true) => self.c.autonomous.then_some(Kind::Resonance1),
            (Mode::Doubling, false, false) => None,
            (Mode::Fold, false, false) | (Mode::Doubling, false, true) => Some(Kind::FoldDoubling),
            (Mode::Fold, true, _) | (Mode::Torus, false, true) => Some(Kind::FoldTorus),
            (Mode::Doubling, true, _) | (Mode::Torus, false, false) => Some(Kind::DoublingTorus),
            (Mode::Torus, true, _) => Some(Kind::TorusTorus),
        }
    }

    /// ∂g with a place for θ.
    fn gradient(&self, z: &[f64], part: usize) -> Row {
        let g = &self.variation.gradient[part];
        let mut ends = g.ends.clone();
        if self.torus() {
            let rate = self.variation.by_multiplier * C::i() * self.multiplier(z);
            ends.insert(
                usize::from(self.c.autonomous),
                if part == 0 { rate.re } else { rate.im },
            );
        }
        Row {
            nodes: g.nodes.clone(),
            ends,
        }
    }
}

impl Manifold for Curves<'_> {
    fn len(&self) -> usize {
        self.first() + 2
    }

    fn residual(&mut self, z: &[f64], out: &mut [f64]) -> Result<(), Failure> {
        let stripped = self.strip(z);
        self.c.residual(&stripped, out)?;
        let mut at = self.c.nodes();
        if self.c.autonomous {
            out[at] = self.frame.offset(&z[..self.c.nodes()]);
            at += 1;
        }
        // g is that of the factorisation, which is always at this z.
        out[at] = self.variation.g.re;
        if self.torus() {
            out[at + 1] = self.variation.g.im;
        }
        Ok(())
    }

    fn factor(&mut self, z: &[f64]) -> Result<(), Failure> {
        if self.factored == z {
            return Ok(());
        }
        self.factored.clear();
        self.linearise(z)?;
        let phase = self.reduced_phase();
        let mu = self.multiplier(z);
        let fine = self
            .variation
            .solve(&self.c, &self.bordered, mu, phase.as_ref());
        if !fine {
            return Err(Failure::NotFinite);
        }
        self.variation.differentiate(&self.c, mu, self.frame.scale);
        // Kept for the border rows.
        self.arclength.ends = vec![z.get(self.angle_index()).copied().unwrap_or(0.0)];
        self.factored.extend_from_slice(z);
        Ok(())
    }

    fn border(&mut self, row: &[f64]) -> Result<(), Failure> {
        let nodes = self.c.nodes();
        let angle = self.arclength.ends.first().copied().unwrap_or(0.0);
        let mut z = vec![0.0; self.len()];
        z[self.angle_index()] = angle;
        let mut rows: Vec<Row> = Vec::with_capacity(4);
        if self.c.autonomous {
            let mut phase = self.frame.phase.clone();
            phase.ends = vec![0.0; row.len() - nodes];
            rows.push(phase);
        }
        rows.push(self.gradient(&z, 0));
        if self.torus() {
            rows.push(self.gradient(&z, 1));
        }
        rows.push(Row {
            nodes: row[..nodes].to_vec(),
            ends: row[nodes..].to_vec(),
        });
        let rows: Vec<&Row> = rows.iter().collect();
        if self.bordered.rows(&self.c.condensed, &rows) {
            Ok(())
        } else {
            Err(Failure::NotFinite)
        }
    }

    fn solve(&mut self, b: &mut [f64]) {
        self.bordered.solve(&self.c.condensed, b);
    }

    fn keeps(&self) -> bool {
        true
    }

    fn attend(&mut self, which: Attention) {
        self.attention = which;
    }

    fn weights(&self) -> &[f64] {
        &self.weights
    }

    fn parameters(&self) -> Vec<usize> {
        vec![self.first(), self.first() + 1]
    }

    fn rescale(&mut self, z: &[f64]) {
        self.frame.weigh(&self.c, z, &mut self.weights);
        if self.torus() {
            self.weights.push(0.1);
        }
        let first = self.first();
        for k in 0..2 {
            self.weights
                .push(self.settings.parameter_scale(k, z[first + k]).powi(-2));
        }
    }

    /// The multipliers that are not on the unit circle by construction.
    fn spectrum(&mut self, z: &[f64], _tangent: &[f64]) -> Spectrum {
        let found = floquet::multipliers(&self.c, z).unwrap_or_default();
        let mut values = found.values;
        let mu = self.multiplier(z);
        for target in [mu, mu.conj()]
            .iter()
            .take(if self.torus() { 2 } else { 1 })
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
        let rates = vec![C::new(f64::NAN, f64::NAN); values.len()];
        Spectrum {
            values,
            rates,
            error: found.error,
        }
    }

    fn distance(&self, value: Complex64) -> f64 {
        value.norm().ln()
    }

    /// Where a further multiplier joins the one that is there by construction both are ill determined; the tests of strong
    /// resonances are not.
    fn tested(&self, a: C, b: C) -> bool {
        let real = a.im == 0.0 && b.im == 0.0;
        match self.mode {
            Mode::Doubling => real && a.re < 0.0 && b.re < 0.0,
            Mode::Fold => real && a.re > 0.0 && b.re > 0.0 && !self.c.autonomous,
            Mode::Torus => false,
        }
    }

    fn distance_rate(&self, value: Complex64, rate: Complex64) -> f64 {
        (rate / value).re
    }

    fn tests(&mut self, z: &[f64], _tangent: &[f64], _spectrum: &Spectrum) -> Vec<f64> {
        let v = &self.variation;
        match self.mode {
            Mode::Torus => {
                let angle = z[self.angle_index()];
                let pi = std::f64::consts::PI;
                vec![
                    angle,
                    angle - pi,
                    angle - 2.0 * pi / 3.0,
                    angle - 0.5 * pi,
                    self.coefficient(4, angle),
                ]
            }
            Mode::Doubling => vec![
                v.by_multiplier.re,
                self.coefficient(1, std::f64::consts::PI),
            ],
            Mode::Fold => {
                let mut row = dot(&v.gradient[0].nodes, &v.v[0]);
                if self.c.autonomous {
                    row += v.gradient[0].ends[0] * v.tau;
                }
                // At an autonomous fold the derivative by the multiplier vanishes with the phase: only forced ones test it.
                let resonance = if self.c.autonomous {
                    f64::NAN
                } else {
                    v.by_multiplier.re
                };
                vec![row, resonance]
            }
        }
    }

    fn classify(&mut self, found: &Found<'_>) -> Option<Label> {
        let k = match found.trigger {
            Trigger::Test(k) => k,
            Trigger::Crossing(v) | Trigger::Touch(v) => {
                return self.other(v).map(|kind| {
                    let mut label = Label::plain(kind);
                    label.omega = self.torus().then(|| found.node.z[self.angle_index()]);
                    label.second_omega = (v.im != 0.0).then(|| v.arg().abs());
                    label
                });
            }
        };
        let kind = match (self.mode, k) {
            (Mode::Torus, 0) | (Mode::Fold, 1) => Kind::Resonance1,
            (Mode::Torus, 1) | (Mode::Doubling, 0) => Kind::Resonance2,
            (Mode::Torus, 2) => Kind::Resonance3,
            (Mode::Torus, 3) => Kind::Resonance4,
            (Mode::Torus, 4) => Kind::Chenciner,
            (Mode::Doubling, 1) => Kind::GeneralisedDoubling,
            (Mode::Fold, 0) => Kind::CycleCusp,
            _ => return None,
        };
        let here = found.node.tests.get(k).copied().unwrap_or(f64::NAN).abs();
        if !(here <= 1e-3 * (found.before.tests[k].abs() + found.after.tests[k].abs())) {
            // A jump, not a zero.
            return None;
        }
        let mut label = Label::plain(kind);
        if self.torus() {
            label.omega = Some(found.node.z[self.angle_index()]);
        }
        Some(label)
    }

    fn adapt(&mut self, z: &mut Vec<f64>, tangents: &mut [&mut Vec<f64>], count: usize) -> bool {
        // The sign of w is kept by time, so it outlives the mesh.
        let moved = self
            .frame
            .adapt(&mut self.c, &self.settings.mesh, z, tangents, count);
        if moved {
            self.accept(z);
        }
        moved
    }

    fn accept(&mut self, z: &[f64]) {
        // What borders the linearisation changes.
        self.factored.clear();
        self.variation.refresh();
        self.variation.keep_sign(&self.c);
        self.frame.anchor(&self.c, z);
    }

    fn restart(&mut self, node: &Node) {
        self.factored.clear();
        self.c.set_mesh(node.mesh.clone());
        self.frame.forget();
        self.rescale(&node.z);
        self.variation = Variation::default();
        self.accept(&node.z);
        // A failure shows at the next factorisation.
        let _ = self.begin(&node.z);
        self.largest = 0.0;
    }

    fn stop(&mut self, before: &Node, now: &Node) -> Option<Stop> {
        if !self.c.autonomous {
            return None;
        }
        let nodes = self.c.nodes();
        if now.z[nodes] > self.settings.period_bound {
            return Some(Stop::PeriodBound);
        }
        let slopes = |z: &[f64]| self.c.phase_row(&z[..nodes]);
        let (a, b) = (slopes(&before.z), slopes(&now.z));
        let (sa, sb) = (dot(&a, &a).sqrt(), dot(&b, &b).sqrt());
        self.largest = self.largest.max(sa);
        (dot(&a, &b) < 0.0 || sb < 1e-4 * self.largest).then_some(Stop::Vanished)
    }

    fn mesh(&self) -> Vec<f64> {
        self.c.mesh.clone()
    }

    fn ends(&self, kind: Kind) -> bool {
        self.torus() && matches!(kind, Kind::Resonance1 | Kind::Resonance2)
    }
}
