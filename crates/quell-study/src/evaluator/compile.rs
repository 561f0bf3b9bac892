//! From the criteria of a study to programs over what is read of runs.

use std::sync::Arc;

use indexmap::IndexMap;
use quell_document::Fault;
use quell_expression::{Dimension, Expression, ExpressionError, Scope, TapeBuilder};
use quell_model::EquationHost;
use quell_response::{Plan, PlanSettings};

use super::program::{Inputs, Program};
use super::reading::Reading;
use super::run::prepare;
use super::variation::Varied;
use super::{Evaluator, band};
use crate::built::Built;
use crate::combination::{Combination, with_parts};
use crate::criteria::{Functional, RunContext, RunKind, compile, functional_name};
use crate::linear::{LinearisedPlan, Output};
use crate::situation::Situation;
use crate::study::{Criterion, Run, Study, Variation};
use crate::transient::{self, Observation, TransientPlan, ValuePlaces, Watching};

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
    pub(super) fn within(
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
pub(super) fn refuse_unit(
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
