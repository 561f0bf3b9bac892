//! Criteria of one built candidate: fast values for a search, certified ones for a report.

use std::sync::Arc;

use indexmap::IndexMap;
use num_complex::Complex64;
use quell_document::Fault;
use quell_expression::{
    Dimension, Expression, ExpressionError, Quantity, Scope, Tape, TapeBuilder,
};
use quell_model::LinearForm;
use quell_response::{
    CertificateStatus, ModeKind, Piece, Plan, PlanSettings, Scratch, certify, h2, h2_fast,
};

use crate::built::{Built, ValueScratch};
use crate::criteria::{
    Functional, Modal, Norm, RunContext, RunKind, Statistic, compile, functional_name,
};
use crate::results::{CriterionDetail, Ledger};
use crate::situation::Situation;
use crate::study::{Criterion, Run, Study, TransientRun};
use crate::transient::{
    self, History, Observation, Simulated, TransientPlan, ValuePlaces, Watching,
};

/// A functional with the run that it reads.
#[derive(Debug)]
struct Reading {
    functional: Functional,
    run: String,
    input: usize,
    /// SI dimension of output over input.
    response: Dimension,
    band: Option<(f64, f64)>,
    oscillatory: bool,
    spectrum: Option<SpectrumTape>,
    /// Tightest tolerance of the criteria that read it.
    tolerance: f64,
    plan: Option<Plan>,
}

/// A criterion over the values of functionals.
#[derive(Debug)]
struct Program {
    name: String,
    dimension: Dimension,
    /// Indices of its functionals among all readings, in the order of the tape's inputs.
    readings: Vec<usize>,
    tape: Tape,
}

/// One-sided spectrum per Hz as a function of f.
#[derive(Debug, Clone)]
struct SpectrumTape {
    tape: Tape,
}

impl SpectrumTape {
    /// S at ω (rad/s), in the input's unit² per Hz.
    fn value(&self, omega: f64) -> f64 {
        let mut out = [f64::NAN];
        self.tape.evaluate(&[omega], &mut Vec::new(), &mut out);
        // In the study `f` is a quantity in rad/s like every frequency, and a spectrum "per Hz" is per 2π rad/s, so the
        // expression gives the density over ω; per Hz it is 2π times as large.
        out[0] * std::f64::consts::TAU
    }
}

/// All criteria of one candidate.
#[derive(Debug)]
pub(crate) struct Evaluator {
    built: Arc<Built>,
    readings: Vec<Reading>,
    programs: Vec<Program>,
    /// Runs in time by name, each carried out once for all that is read of it.
    transients: Vec<(String, TransientPlan)>,
}

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
}

/// A criterion's value with what is known about it.
#[derive(Debug, Clone)]
pub(crate) struct Certified {
    /// SI; NaN where there is none.
    pub value: f64,
    /// What is known.
    pub detail: CriterionDetail,
}

/// Frequencies (rad/s) at which a certificate found more than the search's grid did, by reading.
pub(crate) type Missed = Vec<(usize, f64)>;

/// A response that can be drawn.
pub(crate) struct Drawable<'a> {
    /// The host's input.
    pub input: usize,
    /// What is looked at.
    pub form: &'a LinearForm,
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
    fn signal(&self, expression: &Expression) -> Result<(LinearForm, Dimension), ExpressionError> {
        self.situation
            .signal(expression, &self.devices, &self.parts, self.input)
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

/// What is known of a run at one set of parameters.
pub(crate) struct Prepared {
    input: usize,
    band: Option<(f64, f64)>,
    spectrum: Option<(SpectrumTape, Dimension)>,
    oscillatory: bool,
    kind: RunKind,
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
        let mut evaluator = Self {
            built,
            readings: Vec::new(),
            programs: Vec::new(),
            transients: Vec::new(),
        };
        let chosen: Vec<(&String, &Criterion)> = study
            .criteria
            .iter()
            .filter(|(name, _)| only.is_none_or(|only| only.contains(&name.as_str())))
            .collect();
        let run_of = |name: &str| runs.get(name).or_else(|| study.runs.get(name));
        // Signals are gathered while criteria are read; then each run in time is compiled once.
        let mut in_time: Vec<(&String, &TransientRun)> = Vec::new();
        for (_, criterion) in &chosen {
            if let Some(Run::Transient(run)) = run_of(&criterion.run)
                && !in_time.iter().any(|(known, _)| **known == criterion.run)
            {
                in_time.push((&criterion.run, run));
            }
        }
        let (host, devices) = if in_time.is_empty() {
            (None, Vec::new())
        } else {
            let host = situation.equations()?;
            let devices = evaluator.built.system_devices(study, &host)?;
            (Some(host), devices)
        };
        let watchings: Vec<(&String, Watching<'_>)> = host
            .iter()
            .flat_map(|host| {
                in_time
                    .iter()
                    .map(|(name, _)| (*name, Watching::new(host, &devices)))
            })
            .collect();
        for (name, criterion) in &chosen {
            let watching = watchings
                .iter()
                .find(|(known, _)| **known == criterion.run)
                .map(|(_, watching)| watching);
            let run = run_of(&criterion.run);
            evaluator.add(study, situation, (name, criterion), run, watching)?;
        }
        let first_elements = evaluator.built.first_elements();
        for ((name, watching), (_, run)) in watchings.into_iter().zip(in_time) {
            // Whoever looks at everything wants to see where the energy went.
            let ledger = only.is_none()
                || evaluator.readings.iter().any(|reading| {
                    reading.run == *name
                        && reading.functional == Functional::Time(Observation::EnergyError)
                });
            let built = Arc::clone(&evaluator.built);
            let places = ValuePlaces {
                elements: &first_elements,
                law: &|device, name| built.law_place(device, name),
            };
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
        run: Option<&Run>,
        watching: Option<&Watching<'_>>,
    ) -> Result<(), Fault> {
        let located = |error: ExpressionError| Fault::from_expression(&study.source, error);
        let Some(run) = run else {
            return Err(Fault::at(
                &study.source,
                criterion.span,
                format!("there is no run `{}`", criterion.run),
            ));
        };
        let prepared = prepare(study, situation, run)?;
        if prepared.kind != RunKind::Transient && self.built.assembly.is_none() {
            let why = if situation.is_equations() {
                "the host is written as equations"
            } else {
                "a device holds a nonlinear element"
            };
            return Err(Fault::at(
                &study.source,
                criterion.span,
                format!("`{name}` reads a response of linear systems, and {why}"),
            )
            .help("use a run of `kind = \"transient\"`"));
        }
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
        if let Some((unit, span)) = &criterion.unit
            && !unit.dimension.accepts(&compiled.dimension)
            && !compiled.dimension.accepts(&unit.dimension)
        {
            return Err(Fault::at(
                &study.source,
                *span,
                format!(
                    "`{name}` is {}, which cannot be shown in `{}`",
                    crate::amount::described(compiled.dimension),
                    unit.text
                ),
            )
            .help(if prepared.kind == RunKind::Transient {
                "write a unit of the same dimension, or leave `unit` out"
            } else {
                "a response is over its input: metres by metres make a plain number"
            }));
        }
        let mut readings = Vec::new();
        for (functional, dimension) in compiled.functionals {
            let known = self.readings.iter_mut().enumerate().find(|(_, reading)| {
                reading.functional == functional && reading.run == criterion.run
            });
            if let Some((index, reading)) = known {
                reading.tolerance = reading.tolerance.min(criterion.tolerance);
                readings.push(index);
                continue;
            }
            readings.push(self.readings.len());
            let response = match &functional {
                // A norm's dimension holds that of the integral; the curve is drawn in the response's own.
                Functional::Norm(form, _) => form_dimension(form, criterion, &context),
                _ => dimension,
            };
            let plan = match (&functional, prepared.band, &self.built.assembly) {
                (Functional::Peak(form), Some(band), Some(assembly)) => Some(
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
                run: criterion.run.clone(),
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
            tape: builder.build(),
        });
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
        for (index, reading) in self.readings.iter().enumerate() {
            if !matches!(reading.functional, Functional::Time(_)) {
                let value = self.reading(index, scratch);
                if let Some(entry) = scratch.readings.get_mut(index) {
                    *entry = value;
                }
            }
        }
        for (program, out) in self.programs.iter().zip(out) {
            *out = program.value(&scratch.readings, &mut scratch.inputs, &mut scratch.work);
        }
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

    fn reading(&self, index: usize, scratch: &mut EvaluatorScratch) -> f64 {
        let Some(reading) = self.readings.get(index) else {
            return f64::NAN;
        };
        let values = &scratch.values.mechanical;
        let Some(assembly) = &self.built.assembly else {
            return f64::NAN;
        };
        match &reading.functional {
            Functional::Time(_) => f64::NAN,
            Functional::Peak(_) => match &reading.plan {
                Some(plan) => plan.peak(values, &mut scratch.response).value,
                None => f64::NAN,
            },
            Functional::Magnitude(form, omega) => assembly
                .direct_response(values, reading.input, form, *omega)
                .map_or(f64::NAN, Complex64::norm),
            Functional::Norm(form, norm) => {
                let squared = if reading.band.is_none() && reading.spectrum.is_none() {
                    h2_fast(assembly, values, reading.input, form).unwrap_or(f64::NAN)
                } else {
                    Self::norm_squared(reading, form, *norm, values, assembly)
                        .map_or(f64::NAN, |norm| norm.squared)
                };
                rooted(*norm, squared)
            }
            Functional::Modes(statistic, modal) => {
                modal_value(assembly, values, *statistic, *modal, reading.oscillatory)
                    .unwrap_or(f64::NAN)
            }
        }
    }

    fn norm_squared(
        reading: &Reading,
        form: &LinearForm,
        norm: Norm,
        values: &[f64],
        assembly: &quell_response::Assembly,
    ) -> Result<quell_response::Norm, quell_response::ResponseError> {
        let spectrum = reading.spectrum.clone();
        let density = move |omega: f64| {
            spectrum
                .as_ref()
                .map_or(1.0, |spectrum| spectrum.value(omega))
        };
        let weighted: Option<&quell_response::Spectrum<'_>> = if norm == Norm::H2 {
            None
        } else {
            Some(&density)
        };
        h2(
            assembly,
            values,
            reading.input,
            form,
            reading.band,
            weighted,
        )
    }

    /// The smooth pieces of which a criterion is the maximum, scaled by `factor`: value and gradient by design variables
    /// go to `push`. False where the criterion is no increasing function of one peak.
    pub(crate) fn pieces(
        &self,
        criterion: usize,
        factor: f64,
        margin: f64,
        scratch: &mut EvaluatorScratch,
        mut push: impl FnMut(f64, &mut dyn FnMut(&mut [f64])),
    ) -> bool {
        let Some(program) = self.programs.get(criterion) else {
            return false;
        };
        let [only] = program.readings.as_slice() else {
            return false;
        };
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
        let mut in_time: Vec<Option<(f64, Known)>> = Vec::new();
        in_time.resize_with(self.readings.len(), || None);
        for (name, mut simulated) in self.simulate(&scratch.values, true) {
            let (places, observations) = self.observations(name);
            let read = simulated.read(&observations);
            for ((place, observation), read) in places.into_iter().zip(observations).zip(read) {
                if let Some(entry) = in_time.get_mut(place) {
                    *entry = Some(known_in_time(&simulated, observation, read));
                }
            }
        }
        for (index, (reading, in_time)) in self.readings.iter().zip(in_time).enumerate() {
            let (value, known) =
                in_time.unwrap_or_else(|| self.certified_reading(reading, &values));
            if let (Some(plan), Some(omega)) = (&reading.plan, known.omega) {
                let fast = plan.peak(&values, &mut scratch.response).value;
                if value > fast * (1.0 + reading.tolerance) || fast.is_nan() {
                    missed.push((index, omega));
                }
            }
            numbers.push(value);
            knowledge.push(known);
        }
        let certified = self
            .programs
            .iter()
            .map(|program| {
                let value = program.value(&numbers, &mut scratch.inputs, &mut scratch.work);
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
                        status: worst
                            .map_or_else(|| "certified".to_owned(), |known| known.status.clone()),
                    },
                }
            })
            .collect();
        (certified, missed)
    }

    fn certified_reading(&self, reading: &Reading, values: &[f64]) -> (f64, Known) {
        let Some(assembly) = &self.built.assembly else {
            return Known::failed("there is no linear system".to_owned());
        };
        match &reading.functional {
            Functional::Time(_) => Known::failed("there is no such run".to_owned()),
            Functional::Peak(form) => {
                let Some(band) = reading.band else {
                    return Known::failed("the run has no band".to_owned());
                };
                match certify(
                    assembly,
                    values,
                    reading.input,
                    form,
                    band,
                    reading.tolerance,
                ) {
                    Ok(certificate) => (
                        certificate.value,
                        Known {
                            omega: Some(certificate.omega),
                            time: None,
                            tolerance: Some(certificate.achieved_tolerance),
                            status: match certificate.status {
                                CertificateStatus::Certified => "certified".to_owned(),
                                CertificateStatus::NotCertified { reason } => {
                                    format!("not certified: {reason}")
                                }
                            },
                        },
                    ),
                    Err(error) => Known::failed(error.to_string()),
                }
            }
            Functional::Magnitude(form, omega) => {
                match assembly.direct_response(values, reading.input, form, *omega) {
                    Ok(response) => (
                        response.norm(),
                        Known {
                            omega: Some(*omega),
                            time: None,
                            tolerance: None,
                            status: "computed".to_owned(),
                        },
                    ),
                    Err(error) => Known::failed(error.to_string()),
                }
            }
            Functional::Norm(form, norm) => {
                match Self::norm_squared(reading, form, *norm, values, assembly) {
                    Ok(found) => {
                        let relative = found.error_estimate / found.squared;
                        let share = if *norm == Norm::Variance { 1.0 } else { 0.5 };
                        (
                            rooted(*norm, found.squared),
                            Known {
                                omega: None,
                                time: None,
                                tolerance: Some(share * relative),
                                status: "computed".to_owned(),
                            },
                        )
                    }
                    Err(error) => Known::failed(error.to_string()),
                }
            }
            Functional::Modes(statistic, modal) => {
                match modal_value(assembly, values, *statistic, *modal, reading.oscillatory) {
                    Ok(value) => (
                        value,
                        Known {
                            omega: None,
                            time: None,
                            tolerance: None,
                            status: "computed".to_owned(),
                        },
                    ),
                    Err(error) => Known::failed(error),
                }
            }
        }
    }

    /// Makes the search's grids denser where certificates found more.
    ///
    /// # Errors
    /// Where the host is singular there.
    pub(crate) fn add_frequencies(&mut self, missed: &Missed) -> Result<(), Fault> {
        for (index, omega) in missed {
            if let Some(plan) = self
                .readings
                .get_mut(*index)
                .and_then(|reading| reading.plan.as_mut())
            {
                // The peak itself and its flanks, so that refinement starts on its own slope.
                let around = [0.995, 0.999, 1.0, 1.001, 1.005].map(|factor| factor * omega);
                plan.add_frequencies(&around)
                    .map_err(|error| Fault::new(error.to_string()))?;
            }
        }
        Ok(())
    }

    /// SI dimension of the response (output over input) that [`Self::drawable`] gives.
    pub(crate) fn response_dimension(&self, criterion: usize) -> Dimension {
        let reading = self.programs.get(criterion).and_then(|program| {
            program
                .readings
                .iter()
                .find_map(|index| self.readings.get(*index))
        });
        reading.map_or(Dimension::NONE, |reading| reading.response)
    }

    /// The first response that a criterion reads, if it reads one, for plots.
    pub(crate) fn drawable(&self, criterion: usize) -> Option<Drawable<'_>> {
        let program = self.programs.get(criterion)?;
        program.readings.iter().find_map(|index| {
            let reading = self.readings.get(*index)?;
            match &reading.functional {
                Functional::Peak(form)
                | Functional::Norm(form, _)
                | Functional::Magnitude(form, _) => Some(Drawable {
                    input: reading.input,
                    form,
                    band: reading.band,
                }),
                Functional::Modes(..) | Functional::Time(_) => None,
            }
        })
    }
}

/// The dimension of output over input of the norm in a criterion.
fn form_dimension(
    form: &LinearForm,
    criterion: &Criterion,
    context: &Context<'_, '_>,
) -> Dimension {
    let mut found = Dimension::NONE;
    criterion.value.walk(&mut |part| {
        if let quell_expression::Node::Call { arguments, .. } = &part.node
            && let [signal] = arguments.as_slice()
            && let Ok((known, dimension)) = context.signal(signal)
            && known == *form
        {
            found = dimension;
        }
    });
    found
}

/// A number of a run in time with what is known about it.
fn known_in_time(
    simulated: &Simulated<'_>,
    observation: &Observation,
    (value, time): (f64, Option<f64>),
) -> (f64, Known) {
    let status = if let Some(failure) = &simulated.failure {
        failure.clone()
    } else if value.is_nan() {
        observation.absent().to_owned()
    } else if simulated.grazes() {
        "computed, but an event is grazed: it is touched rather than crossed, so a small change of any value may end the run much later".to_owned()
    } else {
        "computed".to_owned()
    };
    (
        value,
        Known {
            omega: None,
            time,
            tolerance: None,
            status,
        },
    )
}

struct Known {
    omega: Option<f64>,
    time: Option<f64>,
    tolerance: Option<f64>,
    status: String,
}

impl Known {
    fn failed(status: String) -> (f64, Self) {
        (
            f64::NAN,
            Self {
                omega: None,
                time: None,
                tolerance: None,
                status,
            },
        )
    }
}

impl Program {
    fn value(&self, readings: &[f64], inputs: &mut Vec<f64>, work: &mut Vec<f64>) -> f64 {
        inputs.clear();
        inputs.extend(
            self.readings
                .iter()
                .map(|index| readings.get(*index).copied().unwrap_or(f64::NAN)),
        );
        let mut out = [f64::NAN];
        self.tape.evaluate(inputs, work, &mut out);
        out[0]
    }
}

fn rooted(norm: Norm, squared: f64) -> f64 {
    match norm {
        Norm::Variance => squared,
        Norm::H2 | Norm::Rms => squared.sqrt(),
    }
}

fn modal_value(
    assembly: &quell_response::Assembly,
    values: &[f64],
    statistic: Statistic,
    modal: Modal,
    oscillatory: bool,
) -> Result<f64, String> {
    let modes = assembly.modes(values).map_err(|error| error.to_string())?;
    let counted = modes.modes.iter().filter(|mode| match mode.kind {
        ModeKind::Oscillatory => true,
        ModeKind::Real => !oscillatory,
        ModeKind::RigidBody => false,
    });
    let numbers = counted.map(|mode| match modal {
        Modal::DampingRatio => mode.damping_ratio,
        Modal::DecayRate => -mode.eigenvalue.re,
        Modal::Frequency => mode.eigenvalue.norm(),
    });
    match statistic {
        Statistic::Least => numbers.min_by(f64::total_cmp),
        Statistic::Largest => numbers.max_by(f64::total_cmp),
    }
    .ok_or_else(|| "no mode counts for this run".to_owned())
}

pub(crate) fn prepare(study: &Study, situation: &Situation, run: &Run) -> Result<Prepared, Fault> {
    match run {
        Run::Transient(_) => Ok(Prepared {
            input: usize::MAX,
            band: None,
            spectrum: None,
            oscillatory: false,
            kind: RunKind::Transient,
        }),
        Run::Modes { oscillatory } => Ok(Prepared {
            input: usize::MAX,
            band: None,
            spectrum: None,
            oscillatory: *oscillatory,
            kind: RunKind::Modes,
        }),
        Run::Frequency(run) => {
            let index = situation
                .host
                .inputs
                .iter()
                .position(|known| known.name == run.input)
                .ok_or_else(|| {
                    Fault::at(
                        &study.source,
                        run.input_span,
                        format!("there is no input `{}`", run.input),
                    )
                })?;
            let band = match &run.band {
                Some((lower, upper)) => Some(band_of(situation, lower, upper)?),
                None => None,
            };
            let spectrum = match &run.spectrum {
                Some(amount) => Some(spectrum_of(situation, amount, index)?),
                None => None,
            };
            let kind = RunKind::Frequency {
                band: band.is_some(),
                spectrum: spectrum.as_ref().map(|(_, dimension)| *dimension),
            };
            Ok(Prepared {
                input: index,
                band,
                spectrum,
                oscillatory: false,
                kind,
            })
        }
    }
}

/// The least and the largest upper frequency of a band, rad/s.
const SLOWEST: f64 = 1e-9 * std::f64::consts::TAU;
const FASTEST: f64 = 1e12 * std::f64::consts::TAU;

/// The least width of a band over its upper frequency.
const NARROWEST: f64 = 1e-8;

/// Lower and upper frequency, rad/s.
fn band_of(
    situation: &Situation,
    lower: &crate::amount::Amount,
    upper: &crate::amount::Amount,
) -> Result<(f64, f64), Fault> {
    let low = lower.value(&situation.parameters, Dimension::ANGULAR_FREQUENCY)?;
    let high = upper.value(&situation.parameters, Dimension::ANGULAR_FREQUENCY)?;
    if low < 0.0 {
        return Err(lower.fault("a band begins at 0 Hz or above"));
    }
    if high <= low {
        return Err(upper
            .fault("the band is empty: its upper frequency is not above the lower one")
            .help("write `band = [\"0 Hz\", \"30 Hz\"]`"));
    }
    // Outside these a grid of frequencies has no sense, and numbers near the smallest cannot be told apart.
    if !(SLOWEST..=FASTEST).contains(&high) {
        return Err(upper
            .fault("a band ends between 1e-9 Hz and 1e12 Hz")
            .help("are the units the ones that are meant?"));
    }
    if high - low < NARROWEST * high {
        return Err(upper
            .fault("the band is narrower than a millionth of a percent of its frequency")
            .help("`abs(y, 12 Hz)` gives the magnitude at one frequency"));
    }
    Ok((low, high))
}

/// Host parameters and the frequency `f`.
struct WithFrequency<'a> {
    omega: f64,
    outer: &'a dyn Scope,
}

impl Scope for WithFrequency<'_> {
    fn quantity(&self, name: &str) -> Option<Quantity> {
        if name == "f" {
            Some(Quantity::new(self.omega, Dimension::ANGULAR_FREQUENCY))
        } else {
            self.outer.quantity(name)
        }
    }

    fn names(&self) -> Vec<&str> {
        let mut names = self.outer.names();
        names.push("f");
        names
    }
}

/// The spectrum with the dimension of S·Hz (the input squared).
fn spectrum_of(
    situation: &Situation,
    amount: &crate::amount::Amount,
    input: usize,
) -> Result<(SpectrumTape, Dimension), Fault> {
    let sample = WithFrequency {
        omega: 1.0,
        outer: &situation.parameters,
    };
    let quantity = amount.quantity(&sample)?;
    let own = situation
        .host
        .inputs
        .get(input)
        .map_or(Dimension::NONE, |input| input.dimension);
    let expected = own * own / Dimension::ANGULAR_FREQUENCY;
    if quantity.dimension.without_angle() != expected.without_angle() {
        return Err(amount
            .fault(format!(
                "a spectrum of this input is in {}/Hz, found {}",
                (own * own).unit_text(),
                quantity.dimension
            ))
            .help("spectra are one-sided: the variance is the integral of S over f > 0"));
    }
    if quantity.value < 0.0 {
        return Err(amount.fault("a spectrum is not negative"));
    }
    let mut builder = TapeBuilder::new(&["f".to_owned()]);
    builder
        .add(amount.expression(), &situation.parameters)
        .map_err(|error| amount.fault(error.to_string()))?;
    Ok((
        SpectrumTape {
            tape: builder.build(),
        },
        own * own * Dimension::TIME,
    ))
}
