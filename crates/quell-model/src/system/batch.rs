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
    higher: Option<BatchWorkspace>,
    /// The point with directions after it.
    directed: Vec<[f64; LANES]>,
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
            higher: None,
            directed: Vec::new(),
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
        self.higher = None;
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

    /// The derivative of the rates along all directions given (1 to 3), which [`Prepared::along`] gives last: J·u, D²f[u, v] or
    /// D³f[u, v, w]. `directions[k][i]` and `out[i]` hold component i of all lanes.
    pub fn along(
        &mut self,
        t: &[f64; LANES],
        x: &[[f64; LANES]],
        directions: &[&[[f64; LANES]]],
        out: &mut [[f64; LANES]],
    ) {
        self.move_to(t, x);
        let higher = self.system.higher();
        let point = &self.point;
        let work = self.higher.get_or_insert_with(|| {
            let mut work = BatchWorkspace::default();
            higher.program.prepare_lanes(point, &mut work);
            work
        });
        self.directed.clear();
        self.directed.extend_from_slice(point);
        self.directed.resize(higher.inputs, [0.0; LANES]);
        for (places, direction) in higher.directions.iter().zip(directions) {
            for (place, values) in places.iter().zip(*direction) {
                if let Some(entry) = self.directed.get_mut(*place) {
                    *entry = *values;
                }
            }
        }
        let count = self.system.states.len();
        let Some(before) = directions.len().min(3).checked_sub(1) else {
            return;
        };
        self.outputs.resize((before + 1) * count, [0.0; LANES]);
        higher
            .program
            .evaluate_batch(before, &self.directed, work, &mut self.outputs);
        let last = self.outputs.iter().skip(before * count);
        for (target, value) in out.iter_mut().zip(last) {
            *target = *value;
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic)]
mod tests {
    use std::sync::Arc;

    use quell_document::Source;
    use quell_expression::LANES;

    use crate::HostFile;
    use crate::system::{Phase, System};

    #[test]
    fn derivatives_along_directions_have_the_bits_of_single_points() {
        let text = r#"
quell = 1
dimensionless = true
[coordinates]
y = {}
z = {}
[equations]
y = "y'' = -sin(y)*z' - exp(y*z)"
z = "(2 + y^2)*z'' = atan(y' - z) - z^3"
"#;
        let host = HostFile::parse(Arc::new(Source::new("host.toml", text)), ".")
            .and_then(|file| file.equations(&[]))
            .unwrap_or_else(|fault| panic!("{}", fault.render()));
        let system = System::new(&host, &[], &[], Phase::Free).unwrap();
        let n = system.states().len();
        let lanes = |which: usize| -> Vec<[f64; LANES]> {
            let value = |i: usize, lane: usize| (1.0 + (i + 4 * lane + 64 * which) as f64).sin();
            (0..n)
                .map(|i| std::array::from_fn(|lane| value(i, lane)))
                .collect()
        };
        let all: Vec<Vec<[f64; LANES]>> = (0..4).map(lanes).collect();
        let directions: Vec<&[[f64; LANES]]> = all[1..].iter().map(Vec::as_slice).collect();
        let mut batch = system.prepare_batch(&system.defaults());
        let mut prepared = system.prepare(&system.defaults());
        for order in 1..=3 {
            let mut out = vec![[0.0; LANES]; n];
            batch.along(&[0.0; LANES], &all[0], &directions[..order], &mut out);
            for lane in 0..LANES {
                let own: Vec<Vec<f64>> = all
                    .iter()
                    .map(|values| values.iter().map(|value| value[lane]).collect())
                    .collect();
                let along: Vec<&[f64]> = own[1..=order].iter().map(Vec::as_slice).collect();
                let expected = prepared.along(0.0, &own[0], &along);
                assert!(expected[order - 1].iter().any(|x| *x != 0.0));
                for (value, expected) in out.iter().zip(&expected[order - 1]) {
                    assert_eq!(value[lane].to_bits(), expected.to_bits());
                }
            }
        }
    }
}
