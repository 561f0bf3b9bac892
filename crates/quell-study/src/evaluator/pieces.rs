//! The smooth pieces of which a criterion is the largest, with exact gradients.

use super::program::Inputs;
use super::{Evaluator, EvaluatorScratch};
use crate::criteria::Functional;

/// Takes a smooth piece: its value, and what fills its gradient.
pub(super) type Push<'a> = dyn FnMut(f64, &mut dyn FnMut(&mut [f64])) + 'a;

impl Evaluator {
    /// The smooth pieces of which a criterion is the maximum, scaled by `factor`: value and gradient by design variables
    /// go to `push`. False where the criterion is no increasing function of one peak.
    pub(crate) fn pieces(
        &self,
        criterion: usize,
        factor: f64,
        margin: f64,
        scratch: &mut EvaluatorScratch,
        push: &mut Push<'_>,
    ) -> bool {
        let Some(program) = self.programs.get(criterion) else {
            return false;
        };
        if let Inputs::Varied(varied, _) = &program.inputs {
            let Some(varied) = self.varied.get(*varied) else {
                return false;
            };
            let inner = scratch.varied.get_or_insert_default();
            return varied.pieces(&scratch.values, factor, margin, inner, push);
        }
        if let Inputs::Criteria { terms, .. } = &program.inputs {
            let mut sound = !terms.is_empty();
            let (mut work, mut slope) = (Vec::new(), [f64::NAN]);
            for (part, term) in terms {
                sound &= self.pieces(*part, 1.0, margin, scratch, &mut |value, fill| {
                    let mut changed = [f64::NAN];
                    term.jacobian(&[value], &mut work, &mut changed, &mut slope);
                    let slope = factor * slope[0];
                    // A decreasing function of a maximum is no maximum of its pieces.
                    sound &= slope >= 0.0;
                    push(factor * changed[0], &mut |gradient| {
                        fill(gradient);
                        for entry in gradient {
                            *entry *= slope;
                        }
                    });
                });
            }
            return sound;
        }
        let ([only], Inputs::Readings) = (program.readings.as_slice(), &program.inputs) else {
            return false;
        };
        if let Some(Functional::Band(index, value)) =
            self.readings.get(*only).map(|reading| &reading.functional)
        {
            return self.band_piece(*index, *value, factor, scratch, push);
        }
        let Some(plan) = self
            .readings
            .get(*only)
            .and_then(|reading| reading.plan.as_ref())
        else {
            return false;
        };
        let mut pieces = std::mem::take(&mut scratch.pieces);
        let found = plan
            .pieces(
                &scratch.values.mechanical,
                margin,
                &mut scratch.response,
                &mut pieces,
            )
            .is_ok();
        let mut sound = found && !pieces.is_empty();
        if sound {
            for piece in &pieces {
                let mut value = [f64::NAN];
                scratch.jacobian.resize(1, f64::NAN);
                program.tape.jacobian(
                    &[piece.value],
                    &mut scratch.work,
                    &mut value,
                    &mut scratch.jacobian,
                );
                let slope = factor * scratch.jacobian.first().copied().unwrap_or(f64::NAN);
                // A decreasing function of a maximum is no maximum of its pieces.
                if slope.is_nan() || slope < 0.0 {
                    sound = false;
                    break;
                }
                let values = &scratch.values;
                push(factor * value[0], &mut |gradient| {
                    self.built.chain(&piece.gradient, slope, values, gradient);
                });
            }
        }
        scratch.pieces = pieces;
        sound
    }
}
