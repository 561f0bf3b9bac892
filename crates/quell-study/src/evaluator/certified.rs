//! Values with what is known about them, and what a search's grids missed.

use quell_document::Fault;

use super::program::Inputs;
use super::reading::{self, Known};
use super::{Evaluator, EvaluatorScratch};
use crate::criteria::Functional;
use crate::results::CriterionDetail;
use crate::store::KeyBuilder;

/// A criterion's value with what is known about it.
#[derive(Debug, Clone)]
pub(crate) struct Certified {
    /// SI; NaN where there is none.
    pub value: f64,
    /// What is known.
    pub detail: CriterionDetail,
}

/// A frequency at which a certificate found more than the search's grid did.
#[derive(Debug, Clone)]
pub(crate) struct Miss {
    /// Where the reading stands: of each criterion that is taken at several points, its number and that of the point.
    pub(super) path: Vec<(usize, usize)>,
    pub(super) reading: usize,
    /// rad/s.
    pub(super) omega: f64,
}

impl Miss {
    /// Seen from the criterion that is taken at several points.
    pub(super) fn under(mut self, varied: usize, place: usize) -> Self {
        self.path.insert(0, (varied, place));
        self
    }

    /// Everything that it says.
    pub(crate) fn key(&self, key: KeyBuilder) -> KeyBuilder {
        let path = self.path.iter().flat_map(|(varied, place)| [varied, place]);
        path.chain([&self.reading])
            .fold(key, |key, number| key.count(*number as u64))
            .number(self.omega)
    }
}

/// What certificates found.
pub(crate) type Missed = Vec<Miss>;

impl Evaluator {
    /// Values with what is known about them, at element values that stand in `scratch.values`, and where a certificate
    /// found more than the grid's peak by over the tolerance.
    pub(crate) fn certified(&self, scratch: &mut EvaluatorScratch) -> (Vec<Certified>, Missed) {
        let values = scratch.values.mechanical.clone();
        let mut missed = Missed::new();
        let mut numbers = Vec::new();
        let mut knowledge: Vec<Known> = Vec::new();
        let mut timed: Vec<Option<(f64, Known)>> = Vec::new();
        timed.resize_with(self.readings.len(), || None);
        for (name, mut simulated) in self.simulate(&scratch.values, true) {
            let (places, observations) = self.observations(name);
            let read = simulated.read(&observations);
            let remarks = simulated.remarks(&observations);
            let read = read.into_iter().zip(remarks);
            for ((place, observation), (read, remark)) in
                places.into_iter().zip(observations).zip(read)
            {
                if let Some(entry) = timed.get_mut(place) {
                    *entry = Some(reading::in_time(&simulated, observation, read, remark));
                }
            }
        }
        let points = self.operating_points(&scratch.values);
        let bands = self.tested_bands(&scratch.values);
        for (index, (reading, timed)) in self.readings.iter().zip(timed).enumerate() {
            let of_band = match reading.functional {
                Functional::Band(index, value) => self
                    .bands
                    .get(index)
                    .zip(bands.get(index))
                    .map(|(plan, found)| reading::of_band(plan, found, value)),
                _ => None,
            };
            let (value, known) = match timed.or(of_band) {
                Some(found) => found,
                None => match self.linear(&reading.run, &scratch.values, &points) {
                    Ok(linear) => reading.certified(&linear),
                    Err(why) => Known::failed(why),
                },
            };
            if let (Some(plan), Some(omega)) = (&reading.plan, known.omega) {
                let fast = plan.peak(&values, &mut scratch.response).value;
                if value > fast * (1.0 + reading.tolerance) || fast.is_nan() {
                    missed.push(Miss {
                        path: Vec::new(),
                        reading: index,
                        omega,
                    });
                }
            }
            numbers.push(value);
            knowledge.push(known);
        }
        let mut values: Vec<f64> = Vec::new();
        let certified = self
            .programs
            .iter()
            .map(|program| {
                if let Inputs::Varied(index, _) = &program.inputs
                    && let Some(varied) = self.varied.get(*index)
                {
                    let inner = scratch.varied.get_or_insert_default();
                    let (found, further) = varied.certified(&scratch.values, inner, *index);
                    values.push(found.value);
                    missed.extend(further);
                    return found;
                }
                let value =
                    program.value(&numbers, &values, &mut scratch.inputs, &mut scratch.work);
                values.push(value);
                let known: Vec<&Known> = program
                    .readings
                    .iter()
                    .filter_map(|reading| knowledge.get(*reading))
                    .collect();
                let worst = known
                    .iter()
                    .find(|known| !matches!(known.status.as_str(), "certified" | "computed"))
                    .or_else(|| known.iter().find(|known| known.status != "certified"));
                Certified {
                    value,
                    detail: CriterionDetail {
                        unit: program.dimension.unit_text(),
                        at_hz: match known.as_slice() {
                            [one] => one.omega.map(|omega| omega / std::f64::consts::TAU),
                            _ => None,
                        },
                        at_s: match known.as_slice() {
                            [one] => one.time,
                            _ => None,
                        },
                        achieved_tolerance: known
                            .iter()
                            .map(|known| known.tolerance)
                            .try_fold(0.0, |worst: f64, one| Some(worst.max(one?))),
                        taken: None,
                        bands: self.band_results(program, &bands),
                        status: worst
                            .map_or_else(|| "certified".to_owned(), |known| known.status.clone()),
                    },
                }
            })
            .collect();
        (certified, missed)
    }

    /// Makes the search's grids denser where certificates found more.
    ///
    /// # Errors
    /// Where the host is singular there.
    pub(crate) fn add_frequencies(&mut self, missed: &[Miss]) -> Result<(), Fault> {
        for miss in missed {
            if let Some(((varied, place), rest)) = miss.path.split_first() {
                let inner = Miss {
                    path: rest.to_vec(),
                    ..*miss
                };
                if let Some(varied) = self.varied.get_mut(*varied) {
                    varied.add_frequencies(*place, &inner)?;
                }
                continue;
            }
            if let Some(plan) = self
                .readings
                .get_mut(miss.reading)
                .and_then(|reading| reading.plan.as_mut())
            {
                // The peak itself and its flanks, so that refinement starts on its own slope.
                let around = [0.995, 0.999, 1.0, 1.001, 1.005].map(|factor| factor * miss.omega);
                plan.add_frequencies(&around)
                    .map_err(|error| Fault::new(error.to_string()))?;
            }
        }
        Ok(())
    }
}
