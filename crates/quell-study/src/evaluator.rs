//! Criteria of one built candidate: fast values for a search, certified ones for a report.

mod band;
mod reading;
mod run;
mod variation;

use std::sync::Arc;

use indexmap::IndexMap;
use quell_document::Fault;
use quell_expression::{Dimension, Expression, ExpressionError, Scope, Tape, TapeBuilder};
use quell_model::EquationHost;
use quell_response::{OperatingPoint, Piece, Plan, PlanSettings, Scratch};

use crate::band::{BandPlan, FoundBands};
use crate::built::{Built, ValueScratch};
use crate::combination::{Combination, with_parts};
use crate::criteria::{Functional, RunContext, RunKind, compile, functional_name};
use crate::linear::{Linear, LinearisedPlan, Output};
use crate::results::{CriterionDetail, Ledger};
use crate::situation::Situation;
use crate::store::KeyBuilder;
use crate::study::{Criterion, Run, Study, Variation};
use crate::transient::{
    self, History, Observation, Simulated, TransientPlan, ValuePlaces, Watching,
};
use reading::{Known, Reading};
use variation::{Varied, VariedScratch};

pub(crate) use run::prepare;

/// A criterion over the values of functionals, or of other criteria.
#[derive(Debug)]
struct Program {
    name: String,
    dimension: Dimension,
    /// Indices of its functionals among all readings; of one of criteria, all that those read.
    readings: Vec<usize>,
    inputs: Inputs,
    tape: Tape,
}

/// What the tape of a criterion takes.
#[derive(Debug)]
enum Inputs {
    /// Its readings, in order.
    Readings,
    /// The values of other criteria, which stand before it.
    Criteria {
        /// Which, in order.
        parts: Vec<usize>,
        /// Where it is the largest of terms of one criterion each: which, and the term.
        terms: Vec<(usize, Tape)>,
    },
    /// Itself at several points, by index; and the names in its expression.
    Varied(usize, Vec<String>),
}

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
    path: Vec<(usize, usize)>,
    reading: usize,
    /// rad/s.
    omega: f64,
}

impl Miss {
    /// Seen from the criterion that is taken at several points.
    fn under(mut self, varied: usize, place: usize) -> Self {
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

/// Takes a smooth piece: its value, and what fills its gradient.
type Push<'a> = dyn FnMut(f64, &mut dyn FnMut(&mut [f64])) + 'a;

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

struct Context<'a, 'w> {
    study: &'a Study,
    situation: &'a Situation,
    watching: Option<&'a Watching<'w>>,
    devices: Vec<(String, usize)>,
    parts: Vec<quell_model::DevicePart>,
    input: usize,
    kind: RunKind,
}

impl RunContext for Context<'_, '_> {
    fn signal(&self, expression: &Expression) -> Result<(Output, Dimension), ExpressionError> {
        if let Some(watching) = self.watching {
            let (signal, dimension) = watching.signal(expression)?;
            let over = self.situation.input_dimension(self.input);
            return Ok((Output::Watched(signal), dimension / over));
        }
        let (form, dimension) =
            self.situation
                .signal(expression, &self.devices, &self.parts, self.input)?;
        Ok((Output::Form(form), dimension))
    }

    fn scope(&self) -> &dyn Scope {
        &self.situation.parameters
    }

    fn kind(&self) -> RunKind {
        self.kind
    }

    fn varies(&self, expression: &Expression) -> bool {
        match self.watching {
            Some(watching) => watching.knows(expression),
            None => self.signal(expression).is_ok(),
        }
    }

    fn observe(
        &self,
        call: &Expression,
    ) -> Result<Option<(Observation, Dimension)>, ExpressionError> {
        match self.watching {
            Some(watching) => transient::observe(self.study, watching, self.scope(), call),
            None => Ok(None),
        }
    }
}

impl Evaluator {
    /// Compiles the criteria of a study for a candidate.
    ///
    /// With `only`, the criteria of these names alone, in the order of the study.
    ///
    /// # Errors
    /// What is wrong with a run or a criterion, at its place in the study.
    pub(crate) fn new(
        study: &Study,
        situation: &Situation,
        built: Arc<Built>,
        only: Option<&[&str]>,
        runs: &IndexMap<String, Run>,
    ) -> Result<Self, Fault> {
        Self::within(study, situation, built, only, runs, None)
    }

    /// As [`Self::new`], but the criterion `within` at one of the points over which it is taken.
    fn within(
        study: &Study,
        situation: &Situation,
        built: Arc<Built>,
        only: Option<&[&str]>,
        runs: &IndexMap<String, Run>,
        within: Option<&str>,
    ) -> Result<Self, Fault> {
        band::refuse_moved(study, &built, only)?;
        let mut evaluator = Self {
            varied: Vec::new(),
            built,
            readings: Vec::new(),
            programs: Vec::new(),
            transients: Vec::new(),
            linearised: Vec::new(),
            bands: Vec::new(),
            thorough: only.is_none(),
        };
        let wanted = study
            .criteria
            .keys()
            .map(String::as_str)
            .filter(|name| only.is_none_or(|only| only.contains(name)));
        let chosen: Vec<(&str, &Criterion)> = with_parts(wanted, &study.criteria, within)
            .into_iter()
            .filter_map(|name| Some((name, study.criteria.get(name)?)))
            .collect();
        let run_of = |name: &str| runs.get(name).or_else(|| study.runs.get(name));
        // Signals are gathered while criteria are read; then each run of equations is compiled once.
        let mut of_equations: Vec<(&String, &Run)> = Vec::new();
        for (chosen, criterion) in &chosen {
            if variation_of(chosen, criterion, within).is_none()
                && let Some(name) = &criterion.run
                && let Some(run) = run_of(name)
                && (matches!(run, Run::Transient(_)) || evaluator.built.assembly.is_none())
                && !of_equations.iter().any(|(known, _)| *known == name)
            {
                of_equations.push((name, run));
            }
        }
        let (host, devices) = if of_equations.is_empty() {
            (None, Vec::new())
        } else {
            let host = situation.equations()?;
            let devices = evaluator.built.system_devices(study, &host)?;
            (Some(host), devices)
        };
        let mut hosts: Vec<Arc<EquationHost>> = Vec::new();
        if let Some(host) = &host {
            for (_, run) in &of_equations {
                hosts.push(transient::beginning(study, situation, host, run)?);
            }
        }
        let watchings: Vec<(&String, Watching<'_>)> = of_equations
            .iter()
            .zip(&hosts)
            .map(|((name, _), host)| (*name, Watching::new(host, &devices)))
            .collect();
        for (name, criterion) in &chosen {
            if let Some(variation) = variation_of(name, criterion, within) {
                let varied = (*name, *criterion, variation);
                evaluator.vary(study, situation, varied, runs)?;
                continue;
            }
            if let Some(spec) = &criterion.band {
                evaluator.add_band(study, situation, (name, criterion), spec)?;
                continue;
            }
            let Some(run) = &criterion.run else {
                evaluator.combine(study, situation, (name, criterion))?;
                continue;
            };
            let watching = watchings
                .iter()
                .find(|(known, _)| *known == run)
                .map(|(_, watching)| watching);
            evaluator.add(
                study,
                situation,
                (name, criterion),
                (run, run_of(run)),
                watching,
            )?;
        }
        let first_elements = evaluator.built.first_elements();
        for ((name, watching), (_, run)) in watchings.into_iter().zip(of_equations) {
            let built = Arc::clone(&evaluator.built);
            let places = ValuePlaces {
                elements: &first_elements,
                law: &|device, name| built.law_place(device, name),
            };
            let Run::Transient(run) = run else {
                let plan = LinearisedPlan::new(study, run.span(), &watching, &places)?;
                evaluator.linearised.push((name.clone(), plan));
                continue;
            };
            // Whoever looks at everything wants to see where the energy went.
            let ledger = only.is_none()
                || evaluator.readings.iter().any(|reading| {
                    reading.run == *name
                        && reading.functional == Functional::Time(Observation::EnergyError)
                });
            let plan = TransientPlan::new(study, situation, run, &watching, ledger, &places)?;
            evaluator.transients.push((name.clone(), plan));
        }
        Ok(evaluator)
    }

    fn add(
        &mut self,
        study: &Study,
        situation: &Situation,
        (name, criterion): (&str, &Criterion),
        (run_name, run): (&str, Option<&Run>),
        watching: Option<&Watching<'_>>,
    ) -> Result<(), Fault> {
        let located = |error: ExpressionError| Fault::from_expression(&study.source, error);
        let Some(run) = run else {
            return Err(Fault::at(
                &study.source,
                criterion.span,
                format!("there is no run `{run_name}`"),
            ));
        };
        let prepared = prepare(study, situation, run)?;
        let (devices, parts) = self.built.signal_names();
        let context = Context {
            study,
            situation,
            watching,
            devices,
            parts,
            input: prepared.input,
            kind: prepared.kind,
        };
        let compiled = compile(&criterion.value, &context).map_err(located)?;
        refuse_unit(study, name, criterion, compiled.dimension, prepared.kind)?;
        let mut readings = Vec::new();
        for (functional, dimension) in compiled.functionals {
            let known =
                self.readings.iter_mut().enumerate().find(|(_, reading)| {
                    reading.functional == functional && reading.run == run_name
                });
            if let Some((index, reading)) = known {
                reading.tolerance = reading.tolerance.min(criterion.tolerance);
                readings.push(index);
                continue;
            }
            readings.push(self.readings.len());
            let response = match &functional {
                // A norm's dimension holds that of the integral; the curve is drawn in the response's own.
                Functional::Norm(output, _) => output_dimension(output, criterion, &context),
                _ => dimension,
            };
            let plan = match (&functional, prepared.band, &self.built.assembly) {
                (Functional::Peak(Output::Form(form)), Some(band), Some(assembly)) => Some(
                    Plan::new(
                        assembly,
                        prepared.input,
                        form,
                        band,
                        PlanSettings::default(),
                    )
                    .map_err(|error| {
                        Fault::at(&study.source, criterion.span, format!("`{name}`: {error}"))
                    })?,
                ),
                _ => None,
            };
            self.readings.push(Reading {
                functional,
                run: run_name.to_owned(),
                input: prepared.input,
                response,
                band: prepared.band,
                oscillatory: prepared.oscillatory,
                spectrum: prepared.spectrum.as_ref().map(|(tape, _)| tape.clone()),
                tolerance: criterion.tolerance,
                plan,
            });
        }
        let inputs: Vec<String> = (0..readings.len()).map(functional_name).collect();
        let mut builder = TapeBuilder::new(&inputs);
        builder
            .add(&compiled.arithmetic, &situation.parameters)
            .map_err(located)?;
        self.programs.push(Program {
            name: name.to_owned(),
            dimension: compiled.dimension,
            readings,
            inputs: Inputs::Readings,
            tape: builder.build(),
        });
        Ok(())
    }

    /// Adds an expression of criteria that have been added.
    fn combine(
        &mut self,
        study: &Study,
        situation: &Situation,
        (name, criterion): (&str, &Criterion),
    ) -> Result<(), Fault> {
        let known: Vec<(&str, Dimension)> = self
            .programs
            .iter()
            .map(|program| (program.name.as_str(), program.dimension))
            .collect();
        let found = Combination::new(&criterion.value, &known, &situation.parameters)
            .map_err(|error| Fault::from_expression(&study.source, error))?;
        refuse_unit(study, name, criterion, found.dimension, RunKind::Transient)?;
        let parts: Vec<usize> = found
            .parts
            .iter()
            .filter_map(|part| self.index(part))
            .collect();
        let mut readings: Vec<usize> = parts
            .iter()
            .filter_map(|part| self.programs.get(*part))
            .flat_map(|program| program.readings.iter().copied())
            .collect();
        readings.sort_unstable();
        readings.dedup();
        let terms = found.terms.into_iter();
        let terms = terms
            .filter_map(|(place, tape)| Some((*parts.get(place)?, tape)))
            .collect();
        self.programs.push(Program {
            name: name.to_owned(),
            dimension: found.dimension,
            readings,
            inputs: Inputs::Criteria { parts, terms },
            tape: found.tape,
        });
        Ok(())
    }

    /// Adds a criterion that is taken at several points.
    fn vary(
        &mut self,
        study: &Study,
        situation: &Situation,
        (name, criterion, variation): (&str, &Criterion, &Variation),
        runs: &IndexMap<String, Run>,
    ) -> Result<(), Fault> {
        let varied = Varied::new(study, situation, self, (name, criterion, variation), runs)?;
        // Constants and units are the same wherever the host's parameters stand.
        refuse_unit(study, name, criterion, varied.dimension, RunKind::Transient)?;
        let names = criterion.value.names().into_iter().map(str::to_owned);
        self.programs.push(Program {
            name: name.to_owned(),
            dimension: varied.dimension,
            readings: Vec::new(),
            inputs: Inputs::Varied(self.varied.len(), names.collect()),
            tape: TapeBuilder::new(&[]).build(),
        });
        self.varied.push(varied);
        Ok(())
    }

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

/// What a criterion is taken over, unless it is looked at at one point of that.
fn variation_of<'a>(
    name: &str,
    criterion: &'a Criterion,
    within: Option<&str>,
) -> Option<&'a Variation> {
    criterion
        .variation
        .as_ref()
        .filter(|_| within != Some(name))
}

/// The dimension of output over input of the norm in a criterion.
fn output_dimension(
    output: &Output,
    criterion: &Criterion,
    context: &Context<'_, '_>,
) -> Dimension {
    let mut found = Dimension::NONE;
    criterion.value.walk(&mut |part| {
        if let quell_expression::Node::Call { arguments, .. } = &part.node
            && let [signal] = arguments.as_slice()
            && let Ok((known, dimension)) = context.signal(signal)
            && known == *output
        {
            found = dimension;
        }
    });
    found
}

/// Refuses a unit in which a criterion cannot be shown.
fn refuse_unit(
    study: &Study,
    name: &str,
    criterion: &Criterion,
    dimension: Dimension,
    kind: RunKind,
) -> Result<(), Fault> {
    let Some((unit, span)) = &criterion.unit else {
        return Ok(());
    };
    if unit.dimension.accepts(&dimension) || dimension.accepts(&unit.dimension) {
        return Ok(());
    }
    Err(Fault::at(
        &study.source,
        *span,
        format!(
            "`{name}` is {}, which cannot be shown in `{}`",
            crate::amount::described(dimension),
            unit.text
        ),
    )
    .help(if kind == RunKind::Transient {
        "write a unit of the same dimension, or leave `unit` out"
    } else {
        "a response is over its input: metres by metres make a plain number"
    }))
}

impl Program {
    /// The value, of those of the readings and of the criteria before this one.
    fn value(
        &self,
        readings: &[f64],
        criteria: &[f64],
        inputs: &mut Vec<f64>,
        work: &mut Vec<f64>,
    ) -> f64 {
        let (places, values) = match &self.inputs {
            Inputs::Readings => (&self.readings, readings),
            Inputs::Criteria { parts, .. } => (parts, criteria),
            Inputs::Varied(..) => return f64::NAN,
        };
        inputs.clear();
        inputs.extend(
            places
                .iter()
                .map(|index| values.get(*index).copied().unwrap_or(f64::NAN)),
        );
        let mut out = [f64::NAN];
        self.tape.evaluate(inputs, work, &mut out);
        out[0]
    }
}
