//! Many points at once.

use quell_expression::{BatchWorkspace, LANES};

use super::compiled::System;
use super::prepared::{Prepared, scatter};
use super::slopes::SlopeWorkspaces;

/// A system at [`LANES`] points at a time, each with its own parameters if need be.
///
/// A lane gives the bits of [`Prepared`] at its point alone, save for Newton's method, which may begin elsewhere.
#[derive(Debug, Clone)]
pub struct Batch<'s> {
    system: &'s System,
    pub(crate) point: Vec<[f64; LANES]>,
    rates: BatchWorkspace,
    jacobian: BatchWorkspace,
    outputs: Vec<[f64; LANES]>,
    /// Where Newton's method takes part: each lane by itself. One for all, or one for each.
    lanes: Vec<Prepared<'s>>,
    pub(crate) slopes: SlopeWorkspaces,
}

impl System {
    /// Puts in values of the parameters for all lanes alike.
    #[must_use]
    pub fn prepare_batch(&self, parameters: &[f64]) -> Batch<'_> {
        let mut batch = self.empty_batch();
        batch.lanes.push(self.prepare(parameters));
        batch.set_parameters(parameters);
        batch
    }

    /// Puts in values of the parameters for each lane: `parameters[i]` holds parameter i of all lanes.
    #[must_use]
    pub fn prepare_lanes(&self, parameters: &[[f64; LANES]]) -> Batch<'_> {
        let mut batch = self.empty_batch();
        for (parameter, values) in self.parameters.iter().zip(parameters) {
            if let Some(entry) = batch.point.get_mut(parameter.input) {
                *entry = *values;
            }
        }
        self.rates.prepare_lanes(&batch.point, &mut batch.rates);
        self.jacobian
            .prepare_lanes(&batch.point, &mut batch.jacobian);
        let lanes = if self.implicit.is_empty() && self.waves.is_empty() {
            1
        } else {
            LANES
        };
        for lane in 0..lanes {
            let own: Vec<f64> = parameters.iter().map(|values| values[lane]).collect();
            batch.lanes.push(self.prepare(&own));
        }
        batch
    }

    fn empty_batch(&self) -> Batch<'_> {
        Batch {
            system: self,
            point: vec![[0.0; LANES]; self.inputs],
            rates: BatchWorkspace::default(),
            jacobian: BatchWorkspace::default(),
            outputs: Vec::new(),
            lanes: Vec::new(),
            slopes: SlopeWorkspaces::default(),
        }
    }
}

impl Batch<'_> {
    /// Other values of the parameters, for all lanes alike.
    pub fn set_parameters(&mut self, parameters: &[f64]) {
        for (parameter, value) in self.system.parameters.iter().zip(parameters) {
            if let Some(entry) = self.point.get_mut(parameter.input) {
                *entry = [*value; LANES];
            }
        }
        let system = self.system;
        system.rates.prepare_lanes(&self.point, &mut self.rates);
        system
            .jacobian
            .prepare_lanes(&self.point, &mut self.jacobian);
        self.slopes.clear();
        self.lanes.truncate(1);
        for prepared in &mut self.lanes {
            prepared.set_parameters(parameters);
        }
    }

    /// Begins Newton's method anew in every lane, so that what follows does not depend on what was before.
    pub fn forget(&mut self) {
        for prepared in &mut self.lanes {
            prepared.forget();
        }
    }

    pub(crate) fn move_to(&mut self, t: &[f64; LANES], x: &[[f64; LANES]]) {
        if let Some(entry) = self.point.get_mut(self.system.time) {
            *entry = *t;
        }
        for (state, values) in self.system.states.iter().zip(x) {
            if let Some(entry) = self.point.get_mut(state.input) {
                *entry = *values;
            }
        }
        if self.system.implicit.is_empty() && self.system.waves.is_empty() {
            return;
        }
        for (lane, time) in t.iter().enumerate() {
            let own: Vec<f64> = x.iter().map(|values| values[lane]).collect();
            let last = self.lanes.len().saturating_sub(1);
            let Some(prepared) = self.lanes.get_mut(lane.min(last)) else {
                return;
            };
            prepared.move_to(*time, &own);
            let waves = self.system.waves.iter().flatten();
            let unknowns = self
                .system
                .implicit
                .iter()
                .flat_map(|implicit| &implicit.unknowns);
            for place in waves.chain(unknowns) {
                if let (Some(entry), Some(value)) =
                    (self.point.get_mut(*place), prepared.point.get(*place))
                {
                    entry[lane] = *value;
                }
            }
        }
    }

    /// x' of all lanes into `out`: `x[i]` and `out[i]` hold state i of all of them.
    pub fn rates(&mut self, t: &[f64; LANES], x: &[[f64; LANES]], out: &mut [[f64; LANES]]) {
        self.move_to(t, x);
        self.system
            .rates
            .evaluate_batch(0, &self.point, &mut self.rates, out);
    }

    /// ∂x'/∂x, row-major, into `jacobian`, and x' into `rates`.
    pub fn jacobian(
        &mut self,
        t: &[f64; LANES],
        x: &[[f64; LANES]],
        rates: &mut [[f64; LANES]],
        jacobian: &mut [[f64; LANES]],
    ) {
        self.move_to(t, x);
        let count = self.system.states.len();
        self.outputs
            .resize(count + self.system.entries.len(), [0.0; LANES]);
        self.system
            .jacobian
            .evaluate_batch(1, &self.point, &mut self.jacobian, &mut self.outputs);
        let (values, entries) = self.outputs.split_at(count);
        for (target, value) in rates.iter_mut().zip(values) {
            *target = *value;
        }
        scatter(&self.system.entries, entries, jacobian, count * count);
    }
}
