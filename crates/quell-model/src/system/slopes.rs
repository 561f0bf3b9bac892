//! Derivatives of the rates by parameters and by time.

use quell_expression::{BatchWorkspace, LANES, Program, Slot};

use super::batch::Batch;
use super::compiled::System;
use super::prepared::Prepared;

/// ∂f/∂p of chosen parameters of a system and ∂f/∂t, exact, compiled beside it.
///
/// Unknowns that follow from equations within f move along, by the implicit function theorem. ∂f/∂t is that of time where it
/// stands in the equations; inputs with waveforms are taken as they are.
#[derive(Debug)]
pub struct Slopes {
    parameters: Vec<usize>,
    /// One for each parameter, the last for time.
    programs: Vec<Program>,
    timeless: bool,
}

impl Slopes {
    /// The parameters, as indices into [`System::parameters`].
    #[must_use]
    pub fn parameters(&self) -> &[usize] {
        &self.parameters
    }

    /// Whether time stands in no equation.
    #[must_use]
    pub const fn timeless(&self) -> bool {
        self.timeless
    }
}

/// Workspaces of [`Slopes`] in a batch with its parameters.
#[derive(Debug, Clone, Default)]
pub(crate) struct SlopeWorkspaces(Vec<Option<BatchWorkspace>>);

impl SlopeWorkspaces {
    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }
}

impl System {
    /// Compiles ∂f/∂p of parameters, given as indices into [`Self::parameters`], and ∂f/∂t.
    #[must_use]
    pub fn slopes(&self, parameters: &[usize]) -> Slopes {
        let mut assembled = self.assembled().clone();
        let mut by: Vec<usize> = parameters
            .iter()
            .filter_map(|index| Some(self.parameters.get(*index)?.input))
            .collect();
        by.push(self.time);
        let rates = assembled.rates.clone();
        let slopes = assembled.jacobian(&rates, &by);
        let timeless = slopes
            .iter()
            .skip(by.len() - 1)
            .step_by(by.len())
            .all(Option::is_none);
        let zero = assembled.inputs.graph.constant(0.0);
        let slots: Vec<Slot> = slopes
            .into_iter()
            .map(|slot| slot.unwrap_or(zero))
            .collect();
        let closed = assembled.close(&slots);
        let mask = self.mask();
        let programs = (0..by.len())
            .map(|column| {
                let own: Vec<Slot> = closed
                    .iter()
                    .skip(column)
                    .step_by(by.len())
                    .copied()
                    .collect();
                Program::compile(&assembled.inputs.graph, &[own], |input| {
                    mask.get(input).copied().unwrap_or(false)
                })
            })
            .collect();
        Slopes {
            parameters: parameters.to_vec(),
            programs,
            timeless,
        }
    }
}

impl Batch<'_> {
    /// ∂f/∂p of parameter `which` of the slopes, for all lanes, into `out`; of time where `which` is their number.
    pub fn slope(
        &mut self,
        slopes: &Slopes,
        which: usize,
        t: &[f64; LANES],
        x: &[[f64; LANES]],
        out: &mut [[f64; LANES]],
    ) {
        self.move_to(t, x);
        let Some(program) = slopes.programs.get(which) else {
            return;
        };
        if self.slopes.0.len() <= which {
            self.slopes.0.resize(which + 1, None);
        }
        let Some(work) = self.slopes.0.get_mut(which) else {
            return;
        };
        let point = &self.point;
        let work = work.get_or_insert_with(|| {
            let mut work = BatchWorkspace::default();
            program.prepare_lanes(point, &mut work);
            work
        });
        program.evaluate_batch(0, point, work, out);
    }
}

impl Prepared<'_> {
    /// ∂f/∂p of parameter `which` of the slopes into `out`; of time where `which` is their number.
    pub fn slope(&mut self, slopes: &Slopes, which: usize, t: f64, x: &[f64], out: &mut [f64]) {
        self.move_to(t, x);
        let Some(program) = slopes.programs.get(which) else {
            return;
        };
        let mut work = quell_expression::Workspace::default();
        program.prepare(&self.point, &mut work);
        program.evaluate(0, &self.point, &mut work, out);
    }
}
