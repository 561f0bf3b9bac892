//! Criteria of one built candidate: fast values for a search, certified ones for a report.

mod band;
mod certified;
mod compile;
mod pieces;
mod program;
mod reading;
mod run;
mod variation;

use std::sync::Arc;

use indexmap::IndexMap;
use quell_expression::Dimension;
use quell_response::{OperatingPoint, Piece, Scratch};

use crate::band::{BandPlan, FoundBands};
use crate::built::{Built, ValueScratch};
use crate::criteria::Functional;
use crate::linear::{Linear, LinearisedPlan, Output};
use crate::results::Ledger;
use crate::transient::{History, Observation, Simulated, TransientPlan};
use reading::Reading;
use variation::{Varied, VariedScratch};

pub(crate) use certified::{Certified, Miss, Missed};
pub(crate) use run::prepare;

use pieces::Push;
use program::{Inputs, Program};

/// All criteria of one candidate.
#[derive(Debug)]
pub(crate) struct Evaluator {
    built: Arc<Built>,
    readings: Vec<Reading>,
    programs: Vec<Program>,
    /// Runs in time by name, each carried out once for all that is read of it.
    transients: Vec<(String, TransientPlan)>,
    /// Linear runs of systems of equations by name.
    linearised: Vec<(String, LinearisedPlan)>,
    /// Criteria that are taken at several points.
    varied: Vec<Varied>,
    /// Stable bands, each worked out once for all that is read of it.
    bands: Vec<BandPlan>,
    /// Whether everything is looked at, so that what is reported is tested further.
    thorough: bool,
}

/// The operating points of the linear runs of a candidate by name, or why there is none.
type OperatingPoints<'a> = Vec<(&'a str, Result<OperatingPoint, String>)>;

/// Buffers of one thread.
#[derive(Debug, Default)]
pub(crate) struct EvaluatorScratch {
    /// Element values.
    pub values: ValueScratch,
    response: Scratch,
    readings: Vec<f64>,
    inputs: Vec<f64>,
    work: Vec<f64>,
    jacobian: Vec<f64>,
    pieces: Vec<Piece>,
    varied: Option<Box<VariedScratch>>,
    /// Stable bands at the last values.
    bands: Vec<FoundBands>,
}

/// A response that can be drawn.
pub(crate) struct Drawable<'a> {
    /// The run.
    pub run: &'a str,
    /// The host's input.
    pub input: usize,
    /// What is looked at.
    pub output: &'a Output,
    /// Over which angular frequencies, rad/s.
    pub band: Option<(f64, f64)>,
}

impl Evaluator {
    /// The candidate.
    pub(crate) fn built(&self) -> &Arc<Built> {
        &self.built
    }

    /// Names of the criteria.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.programs.iter().map(|program| program.name.as_str())
    }

    /// The index of a criterion.
    pub(crate) fn index(&self, name: &str) -> Option<usize> {
        self.programs
            .iter()
            .position(|program| program.name == name)
    }

    /// SI dimension of a criterion.
    pub(crate) fn dimension(&self, criterion: usize) -> Dimension {
        self.programs
            .get(criterion)
            .map_or(Dimension::NONE, |program| program.dimension)
    }

    /// Fast values of all criteria at element values that stand in `scratch.values`, into `out`; NaN where there is none.
    pub(crate) fn fast(&self, scratch: &mut EvaluatorScratch, out: &mut [f64]) {
        scratch.readings.clear();
        scratch.readings.resize(self.readings.len(), f64::NAN);
        for (name, mut simulated) in self.simulate(&scratch.values, false) {
            let (places, observations) = self.observations(name);
            for (place, (value, _)) in places.into_iter().zip(simulated.read(&observations)) {
                if let Some(entry) = scratch.readings.get_mut(place) {
                    *entry = value;
                }
            }
        }
        let points = self.operating_points(&scratch.values);
        self.find_bands(&scratch.values, &mut scratch.bands);
        let bands = &scratch.bands;
        for (reading, entry) in self.readings.iter().zip(&mut scratch.readings) {
            *entry = match reading.functional {
                Functional::Time(_) => continue,
                Functional::Band(index, value) => bands
                    .get(index)
                    .map_or(f64::NAN, |found| found.value(value)),
                _ => match self.linear(&reading.run, &scratch.values, &points) {
                    Ok(linear) => reading.fast(&linear, &mut scratch.response),
                    Err(_) => f64::NAN,
                },
            };
        }
        for (index, program) in self.programs.iter().enumerate() {
            let value = if let Inputs::Varied(varied, _) = &program.inputs {
                let inner = scratch.varied.get_or_insert_default();
                self.varied
                    .get(*varied)
                    .map_or(f64::NAN, |varied| varied.fast(&scratch.values, inner))
            } else {
                program.value(
                    &scratch.readings,
                    out,
                    &mut scratch.inputs,
                    &mut scratch.work,
                )
            };
            if let Some(entry) = out.get_mut(index) {
                *entry = value;
            }
        }
    }

    /// Whether everything that is read is smooth in the values but for jumps here and there: numbers of runs in time, norms, the
    /// response at one frequency. Peaks and statistics of modes have kinks where they are best.
    pub(crate) fn is_smooth(&self) -> bool {
        self.readings.iter().all(|reading| {
            matches!(
                reading.functional,
                Functional::Time(_) | Functional::Norm(..) | Functional::Magnitude(..)
            )
        }) && self.varied.iter().all(Varied::is_smooth)
    }

    /// Lets the runs in time run: beyond their ends where a criterion looks there, or where `beyond` asks for it.
    fn simulate(&self, values: &ValueScratch, beyond: bool) -> Vec<(&str, Simulated<'_>)> {
        self.transients
            .iter()
            .map(|(name, plan)| {
                let (_, observations) = self.observations(name);
                let beyond = beyond
                    || observations
                        .iter()
                        .any(|observation| observation.looks_beyond());
                (
                    name.as_str(),
                    plan.simulate(&values.mechanical, &values.laws, beyond),
                )
            })
            .collect()
    }

    /// What is read of a run in time, with the places among all readings.
    fn observations(&self, run: &str) -> (Vec<usize>, Vec<&Observation>) {
        self.readings
            .iter()
            .enumerate()
            .filter(|(_, reading)| reading.run == run)
            .filter_map(|(place, reading)| match &reading.functional {
                Functional::Time(observation) => Some((place, observation)),
                _ => None,
            })
            .unzip()
    }

    /// Finds the equilibria about which linear runs of equations are computed.
    pub(crate) fn operating_points(&self, values: &ValueScratch) -> OperatingPoints<'_> {
        self.linearised
            .iter()
            .map(|(name, plan)| (name.as_str(), plan.at(values)))
            .collect()
    }

    /// The linear system of a run, or why there is none.
    pub(crate) fn linear<'a>(
        &'a self,
        run: &str,
        values: &'a ValueScratch,
        points: &'a OperatingPoints<'_>,
    ) -> Result<Linear<'a>, String> {
        if let Some(assembly) = &self.built.assembly {
            return Ok(Linear::Assembled {
                assembly,
                values: &values.mechanical,
            });
        }
        match points.iter().find(|(name, _)| *name == run) {
            Some((_, Ok(point))) => Ok(Linear::AtRest(point)),
            Some((_, Err(why))) => Err(why.clone()),
            None => Err("there is no such run".to_owned()),
        }
    }

    /// Energy ledgers by run in time, at element values that stand in `values`.
    pub(crate) fn ledgers(&self, values: &ValueScratch) -> IndexMap<String, Ledger> {
        self.simulate(values, false)
            .into_iter()
            .filter_map(|(name, mut simulated)| Some((name.to_owned(), simulated.ledger()?)))
            .collect()
    }

    /// What happened in the runs in time, as far as criteria look at it: of one criterion, or of all.
    pub(crate) fn histories(&self, values: &ValueScratch, only: Option<&str>) -> Vec<History> {
        let mut histories = Vec::new();
        for (name, mut simulated) in self.simulate(values, true) {
            let chosen = self
                .programs
                .iter()
                .filter(|program| only.is_none_or(|only| program.name == only));
            let read: Vec<&Observation> = chosen
                .flat_map(|program| &program.readings)
                .filter_map(|index| self.readings.get(*index))
                .filter(|reading| reading.run == name)
                .filter_map(|reading| match &reading.functional {
                    Functional::Time(observation) => Some(observation),
                    _ => None,
                })
                .collect();
            histories.extend(simulated.histories(name, &read));
        }
        histories
    }

    /// The readings of a criterion at the values as they are meant.
    fn shown<'a>(&'a self, program: &'a Program) -> impl Iterator<Item = usize> + 'a {
        let named: &[String] = match &program.inputs {
            Inputs::Varied(_, names) => names,
            _ => &[],
        };
        let parts = named
            .iter()
            .filter_map(|name| self.programs.get(self.index(name)?))
            .flat_map(|program| &program.readings);
        program.readings.iter().chain(parts).copied()
    }

    /// SI dimension of the response (output over input) that [`Self::drawable`] gives.
    pub(crate) fn response_dimension(&self, criterion: usize) -> Dimension {
        let reading = self.programs.get(criterion).and_then(|program| {
            self.shown(program)
                .find_map(|index| self.readings.get(index))
        });
        reading.map_or(Dimension::NONE, |reading| reading.response)
    }

    /// The first response that a criterion reads, if it reads one, for plots.
    pub(crate) fn drawable(&self, criterion: usize) -> Option<Drawable<'_>> {
        let program = self.programs.get(criterion)?;
        self.shown(program).find_map(|index| {
            let reading = self.readings.get(index)?;
            match &reading.functional {
                Functional::Peak(output)
                | Functional::Norm(output, _)
                | Functional::Magnitude(output, _) => Some(Drawable {
                    run: &reading.run,
                    input: reading.input,
                    output,
                    band: reading.band,
                }),
                Functional::Modes(..) | Functional::Time(_) | Functional::Band(..) => None,
            }
        })
    }
}
