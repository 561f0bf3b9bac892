//! A system with values of its parameters, ready to be evaluated.

use quell_expression::Workspace;

use super::compiled::System;
use super::newton::{self, Unsolved};
use crate::equations::Waveform;

/// A system with values of its parameters.
///
/// All calls are in terms of (t, x) with x in the order of [`System::states`]; nothing is allocated once every kind of call
/// has been made. Where Newton's method takes part it begins at the last solution, so the last bits may depend on the
/// calls before; [`Self::forget`] begins anew.
#[derive(Debug, Clone)]
pub struct Prepared<'s> {
    pub(crate) system: &'s System,
    /// All graph inputs.
    pub(crate) point: Vec<f64>,
    pub(crate) waveforms: Vec<Option<Waveform>>,
    /// Between which two times waveforms are asked for.
    piece: Option<(f64, f64)>,
    rates: Workspace,
    jacobian: Workspace,
    signals: Workspace,
    switches: Workspace,
    implicit: Vec<Workspace>,
    linear: Option<Workspace>,
    higher: Option<Workspace>,
    outputs: Vec<f64>,
    newton: newton::Memory,
    unsolved: bool,
}

/// A system linearised at a point: δx' = A δx + Σ_m B_m δu^(m), δy = C δx + Σ_m D_m δu^(m) with the signals y.
#[derive(Debug, Clone, PartialEq)]
pub struct Linearised {
    /// Numbers of states, inputs, signals.
    pub sizes: [usize; 3],
    /// A, row-major, states × states.
    pub a: Vec<f64>,
    /// B_0, B_1, B_2 (of u, u', u''), row-major, states × inputs.
    pub b: [Vec<f64>; 3],
    /// C, row-major, signals × states.
    pub c: Vec<f64>,
    /// D_0, D_1, D_2, row-major, signals × inputs.
    pub d: [Vec<f64>; 3],
}

impl<'s> Prepared<'s> {
    pub(crate) fn new(system: &'s System, parameters: &[f64]) -> Self {
        let mut prepared = Self {
            system,
            point: vec![0.0; system.inputs],
            waveforms: system.waveforms.clone(),
            piece: None,
            rates: Workspace::default(),
            jacobian: Workspace::default(),
            signals: Workspace::default(),
            switches: Workspace::default(),
            implicit: vec![Workspace::default(); system.implicit.len()],
            linear: None,
            higher: None,
            outputs: Vec::new(),
            newton: newton::Memory::default(),
            unsolved: false,
        };
        prepared.set_parameters(parameters);
        prepared
    }

    /// Other values of the parameters.
    pub fn set_parameters(&mut self, parameters: &[f64]) {
        let mut given = parameters.iter();
        for parameter in &self.system.parameters {
            let value = given.next().copied().unwrap_or(f64::NAN);
            if let Some(entry) = self.point.get_mut(parameter.input) {
                *entry = value;
            }
        }
        let system = self.system;
        system.rates.prepare(&self.point, &mut self.rates);
        system.jacobian.prepare(&self.point, &mut self.jacobian);
        system.signals.prepare(&self.point, &mut self.signals);
        system.switches.prepare(&self.point, &mut self.switches);
        for (implicit, work) in system.implicit.iter().zip(&mut self.implicit) {
            implicit.program.prepare(&self.point, work);
        }
        self.linear = None;
        self.higher = None;
        self.forget();
    }

    /// The system.
    #[must_use]
    pub const fn system(&self) -> &'s System {
        self.system
    }

    /// Begins Newton's method anew, so that what follows does not depend on what was before.
    pub fn forget(&mut self) {
        for implicit in &self.system.implicit {
            for unknown in &implicit.unknowns {
                if let Some(entry) = self.point.get_mut(*unknown) {
                    *entry = 0.0;
                }
            }
        }
    }

    /// The waveform of an input from now on; none for zero.
    pub fn set_waveform(&mut self, input: usize, waveform: Option<Waveform>) {
        if let Some(entry) = self.waveforms.get_mut(input) {
            *entry = waveform;
        }
    }

    /// The times at which an input or one of its first two derivatives jumps, in order.
    #[must_use]
    pub fn breakpoints(&self) -> Vec<f64> {
        let mut all: Vec<f64> = self
            .waveforms
            .iter()
            .flatten()
            .flat_map(Waveform::breakpoints)
            .collect();
        all.sort_by(f64::total_cmp);
        all.dedup();
        all
    }

    /// Between which two times everything is asked for from now on: at its ends inputs are what they are inside. None: any
    /// time, and at a [breakpoint](Self::breakpoints) inputs are what they are after it.
    pub fn within(&mut self, piece: Option<(f64, f64)>) {
        self.piece = piece.filter(|(from, to)| from < to);
    }

    /// Whether Newton's method has failed since this was last asked: rates were not-a-number then.
    pub fn take_failure(&mut self) -> bool {
        std::mem::take(&mut self.unsolved)
    }

    fn set_time(&mut self, t: f64) {
        if let Some(entry) = self.point.get_mut(self.system.time) {
            *entry = t;
        }
        let inside = self.piece.map_or(t, |(from, to)| {
            let margin = 1e-9 * (to - from);
            t.max(from + margin).min(to - margin)
        });
        for (waveform, places) in self.waveforms.iter().zip(&self.system.waves) {
            let values = waveform
                .as_ref()
                .map_or([0.0; 3], |wave| wave.value_beside(t, inside));
            for (place, value) in places.iter().zip(values) {
                if let Some(entry) = self.point.get_mut(*place) {
                    *entry = value;
                }
            }
        }
    }

    /// Moves to a point and finds the unknowns there.
    pub(crate) fn move_to(&mut self, t: f64, x: &[f64]) {
        self.set_time(t);
        for (state, value) in self.system.states.iter().zip(x) {
            if let Some(entry) = self.point.get_mut(state.input) {
                *entry = *value;
            }
        }
        for (implicit, work) in self.system.implicit.iter().zip(&mut self.implicit) {
            if let Err(Unsolved) = newton::solve(implicit, work, &mut self.point, &mut self.newton)
            {
                self.unsolved = true;
            }
        }
    }

    /// Where a run begins at a time.
    #[must_use]
    pub fn start(&mut self, t: f64) -> Vec<f64> {
        self.set_time(t);
        let mut work = Workspace::default();
        self.system.start.prepare(&self.point, &mut work);
        let mut start = vec![0.0; self.system.states.len()];
        self.system
            .start
            .evaluate(0, &self.point, &mut work, &mut start);
        start
    }

    /// x' into `out`.
    pub fn rates(&mut self, t: f64, x: &[f64], out: &mut [f64]) {
        self.move_to(t, x);
        self.system
            .rates
            .evaluate(0, &self.point, &mut self.rates, out);
    }

    /// ∂x'/∂x, row-major, into `jacobian`, and x' into `rates`.
    pub fn jacobian(&mut self, t: f64, x: &[f64], rates: &mut [f64], jacobian: &mut [f64]) {
        self.move_to(t, x);
        let count = self.system.states.len();
        self.outputs.resize(count + self.system.entries.len(), 0.0);
        self.system
            .jacobian
            .evaluate(1, &self.point, &mut self.jacobian, &mut self.outputs);
        let (values, entries) = self.outputs.split_at(count);
        for (target, value) in rates.iter_mut().zip(values) {
            *target = *value;
        }
        scatter(&self.system.entries, entries, jacobian, count * count);
    }

    /// ∂x'/∂x alone, row-major.
    pub fn state_matrix(&mut self, t: f64, x: &[f64], jacobian: &mut [f64]) {
        self.jacobian(t, x, &mut [], jacobian);
    }

    /// The signals, in the order in which they were to be watched.
    pub fn signals(&mut self, t: f64, x: &[f64], out: &mut [f64]) {
        self.move_to(t, x);
        self.system
            .signals
            .evaluate(0, &self.point, &mut self.signals, out);
    }

    /// The margins at whose zeros the rates have kinks or jumps.
    pub fn switches(&mut self, t: f64, x: &[f64], out: &mut [f64]) {
        self.move_to(t, x);
        self.system
            .switches
            .evaluate(0, &self.point, &mut self.switches, out);
    }

    /// Whether inputs keep their values on the piece of time that is [looked at](Self::within).
    fn is_quiet(&self) -> bool {
        let Some((from, to)) = self.piece else {
            return !self.system.excited;
        };
        !self.system.excited
            || self
                .waveforms
                .iter()
                .flatten()
                .all(|waveform| waveform.is_constant(from, to))
    }

    /// A (row-major) and b with x' = A x + b on the piece on which x lies; false where the system is not
    /// [affine](System::affine) or inputs vary.
    pub fn affine(&mut self, t: f64, x: &[f64], a: &mut [f64], b: &mut [f64]) -> bool {
        if !self.system.affine() || !self.is_quiet() {
            return false;
        }
        self.jacobian(t, x, b, a);
        let count = self.system.states.len();
        for (target, row) in b.iter_mut().zip(a.chunks(count.max(1))) {
            let product: f64 = row.iter().zip(x).map(|(a, x)| a * x).sum();
            *target -= product;
        }
        true
    }

    /// The system linearised at a point: with respect to states and inputs, of rates and signals.
    pub fn linearise(&mut self, t: f64, x: &[f64]) -> Linearised {
        self.move_to(t, x);
        let system = self.system;
        let linear = system.linear();
        let work = self.linear.get_or_insert_with(|| {
            let mut work = Workspace::default();
            linear.program.prepare(&self.point, &mut work);
            work
        });
        self.outputs.resize(linear.entries.len(), 0.0);
        linear
            .program
            .evaluate(0, &self.point, work, &mut self.outputs);
        let (n, inputs, signals) = (system.states.len(), system.waves.len(), system.signal_count);
        let width = n + 3 * inputs;
        let mut full = vec![0.0; (n + signals) * width];
        let size = full.len();
        scatter(&linear.entries, &self.outputs, &mut full, size);
        let block = |rows: std::ops::Range<usize>, columns: std::ops::Range<usize>| -> Vec<f64> {
            rows.flat_map(|row| columns.clone().map(move |column| row * width + column))
                .map(|place| full.get(place).copied().unwrap_or(f64::NAN))
                .collect()
        };
        let of = |order: usize| n + order * inputs..n + (order + 1) * inputs;
        Linearised {
            sizes: [n, inputs, signals],
            a: block(0..n, 0..n),
            b: [0, 1, 2].map(|order| block(0..n, of(order))),
            c: block(n..n + signals, 0..n),
            d: [0, 1, 2].map(|order| block(n..n + signals, of(order))),
        }
    }

    /// Derivatives of the rates along directions: J·u, D²f[u, v] and D³f[u, v, w], as many as directions are given (1 to 3).
    pub fn along(&mut self, t: f64, x: &[f64], directions: &[&[f64]]) -> Vec<Vec<f64>> {
        self.move_to(t, x);
        let system = self.system;
        let higher = system.higher();
        let work = self.higher.get_or_insert_with(|| {
            let mut work = Workspace::default();
            higher.program.prepare(&self.point, &mut work);
            work
        });
        let mut point = self.point.clone();
        point.resize(higher.inputs, 0.0);
        for (places, direction) in higher.directions.iter().zip(directions) {
            for (place, value) in places.iter().zip(*direction) {
                if let Some(entry) = point.get_mut(*place) {
                    *entry = *value;
                }
            }
        }
        let levels = directions.len().min(3);
        let count = system.states.len();
        if levels == 0 || count == 0 {
            return Vec::new();
        }
        let mut outputs = vec![0.0; levels * count];
        higher
            .program
            .evaluate(levels - 1, &point, work, &mut outputs);
        outputs.chunks(count).map(<[f64]>::to_vec).collect()
    }
}

/// Entries into their places of a matrix that is zero elsewhere.
pub(crate) fn scatter<T: Copy + Default>(
    places: &[usize],
    entries: &[T],
    matrix: &mut [T],
    size: usize,
) {
    for entry in matrix.iter_mut().take(size) {
        *entry = T::default();
    }
    for (place, value) in places.iter().zip(entries) {
        if let Some(entry) = matrix.get_mut(*place) {
            *entry = *value;
        }
    }
}
