//! Stable bands among the criteria of a candidate.

use quell_continuation::Peak;
use quell_document::Fault;
use quell_expression::{Dimension, Expression, TapeBuilder};

use super::compile::refuse_unit;
use super::reading::Reading;
use super::{Evaluator, EvaluatorScratch, Inputs, Program, Push};
use crate::band::{BandPlan, BandResult, BandSpec, BandValue, FoundBands};
use crate::built::{Built, ValueScratch};
use crate::criteria::{Functional, RunKind, functional_name};
use crate::situation::Situation;
use crate::study::{Criterion, Study};

/// A negative damping ratio that counts as one in the constraint on islands: a hundredth of it moves the edges of a band by more than
/// a search resolves, and a search tells constraints apart to some 1e-6.
const UNIT: f64 = 1e-4;

/// A search stays so far on the safe side of an island's birth, as a damping ratio: far above the rounding of eigenvalues, so that whoever
/// looks again finds the island unborn, and far below what moves an edge noticeably.
const SAFE: f64 = 1e-9;

/// Re λ/|λ| and the safe distance, in units of [`UNIT`].
fn ratio(peak: &Peak) -> f64 {
    (peak.eigenvalue.re / peak.eigenvalue.norm() + SAFE) / UNIT
}

impl Evaluator {
    /// Adds a number of a stable band.
    pub(super) fn add_band(
        &mut self,
        study: &Study,
        situation: &Situation,
        (name, criterion): (&str, &Criterion),
        spec: &BandSpec,
    ) -> Result<(), Fault> {
        let known = self.bands.iter().position(|known| known.serves(spec));
        let index = if let Some(known) = known {
            known
        } else {
            let plan = BandPlan::new(study, situation, &self.built, spec)?;
            self.bands.push(plan);
            self.bands.len() - 1
        };
        let dimension = self
            .bands
            .get(index)
            .map_or(Dimension::NONE, BandPlan::dimension);
        refuse_unit(study, name, criterion, dimension, RunKind::Transient)?;
        let input = functional_name(0);
        let mut builder = TapeBuilder::new(std::slice::from_ref(&input));
        let itself = Expression {
            node: quell_expression::Node::Name(input),
            span: criterion.span,
        };
        builder
            .add(&itself, &situation.parameters)
            .map_err(|error| Fault::from_expression(&study.source, error))?;
        self.programs.push(Program {
            name: name.to_owned(),
            dimension,
            readings: vec![self.readings.len()],
            inputs: Inputs::Readings,
            tape: builder.build(),
        });
        self.readings.push(Reading {
            functional: Functional::Band(index, spec.value),
            run: String::new(),
            input: usize::MAX,
            response: dimension,
            band: None,
            oscillatory: false,
            spectrum: None,
            tolerance: criterion.tolerance,
            plan: None,
        });
        Ok(())
    }

    /// The bands of the linear equations into `out`, unless they are there from the last time.
    pub(super) fn find_bands(&self, values: &ValueScratch, out: &mut Vec<FoundBands>) {
        let known = out.len() == self.bands.len() && out.iter().all(|found| found.is_at(values));
        if !known {
            out.clear();
            let found = self.bands.iter().map(|plan| plan.find(&self.built, values));
            out.extend(found);
        }
    }

    /// The bands as they are reported: sought on finer grids, and tested for cycles where everything is looked at.
    pub(super) fn tested_bands(&self, values: &ValueScratch) -> Vec<FoundBands> {
        self.bands
            .iter()
            .map(|plan| plan.tested(&self.built, values, self.thorough))
            .collect()
    }

    /// The stable bands with the names of criteria that are numbers of them, one name for each.
    pub(crate) fn named_bands(&self, values: &ValueScratch) -> Vec<(&str, &BandPlan, FoundBands)> {
        let mut found = Vec::new();
        self.find_bands(values, &mut found);
        let of = |program: &Program, index: usize| {
            let reading = program
                .readings
                .first()
                .and_then(|at| self.readings.get(*at));
            matches!(program.inputs, Inputs::Readings)
                && matches!(reading.map(|reading| &reading.functional),
                    Some(Functional::Band(known, _)) if *known == index)
        };
        self.bands
            .iter()
            .zip(found)
            .enumerate()
            .filter_map(|(index, (plan, found))| {
                let program = self.programs.iter().find(|program| of(program, index))?;
                Some((program.name.as_str(), plan, found))
            })
            .collect()
    }

    /// Whether a criterion is a number of a stable band, which is smooth but for jumps.
    pub(crate) fn is_band(&self, criterion: usize) -> bool {
        self.programs.get(criterion).is_some_and(|program| {
            matches!(program.inputs, Inputs::Readings)
                && program.readings.iter().all(|index| {
                    let reading = self.readings.get(*index);
                    reading
                        .is_some_and(|reading| matches!(reading.functional, Functional::Band(..)))
                })
        })
    }

    /// Whether any criterion is.
    pub(crate) const fn has_bands(&self) -> bool {
        !self.bands.is_empty()
    }

    /// How near an island of instability is to being born within the widest band, as the largest -ζ (in units of 1e-4) of those that are not.
    /// Above zero only within [`SAFE`] of the birth, for one that is born splits the band. A search that steps over it falls off a cliff, so it is a constraint.
    pub(crate) fn nearest_island(scratch: &EvaluatorScratch) -> f64 {
        let islands = scratch.bands.iter().flat_map(FoundBands::unborn);
        islands.map(|peak| ratio(&peak)).fold(-1.0, f64::max)
    }

    /// The islands that are not born, with gradients by design variables.
    pub(crate) fn islands(&self, scratch: &mut EvaluatorScratch, push: &mut Push<'_>) {
        let mut bands = std::mem::take(&mut scratch.bands);
        self.find_bands(&scratch.values, &mut bands);
        for (plan, found) in self.bands.iter().zip(&bands) {
            for peak in found.unborn() {
                let slopes = plan.growth_slopes(
                    &self.built,
                    &scratch.values,
                    (peak.p, peak.q),
                    peak.eigenvalue,
                );
                let size = UNIT * peak.eigenvalue.norm();
                push(ratio(&peak), &mut |gradient| {
                    for (entry, slope) in gradient.iter_mut().zip(&slopes) {
                        *entry = slope / size;
                    }
                });
            }
        }
        scratch.bands = bands;
    }

    /// A number of a stable band as a smooth piece; false where there is no band, or an edge without slopes.
    pub(super) fn band_piece(
        &self,
        index: usize,
        value: BandValue,
        factor: f64,
        scratch: &mut EvaluatorScratch,
        push: &mut Push<'_>,
    ) -> bool {
        let mut bands = std::mem::take(&mut scratch.bands);
        self.find_bands(&scratch.values, &mut bands);
        let found = self.bands.get(index).zip(bands.get(index));
        let piece = found.and_then(|(plan, found)| {
            let slopes = plan.slopes(&self.built, &scratch.values, found, value)?;
            Some((found.value(value), slopes))
        });
        scratch.bands = bands;
        let Some((value, slopes)) = piece else {
            return false;
        };
        push(factor * value, &mut |gradient| {
            for (entry, slope) in gradient.iter_mut().zip(&slopes) {
                *entry = factor * slope;
            }
        });
        true
    }

    /// All bands, of a criterion that is a number of one.
    pub(super) fn band_results(&self, program: &Program, found: &[FoundBands]) -> Vec<BandResult> {
        let Inputs::Readings = program.inputs else {
            return Vec::new();
        };
        let reading = program
            .readings
            .first()
            .and_then(|index| self.readings.get(*index));
        let Some(Functional::Band(index, _)) = reading.map(|reading| &reading.functional) else {
            return Vec::new();
        };
        let plan = self.bands.get(*index).zip(found.get(*index));
        plan.map_or_else(Vec::new, |(plan, found)| plan.results(found))
    }
}

/// Refuses criteria of runs where a value is known as the own parameter of a stable band only.
pub(super) fn refuse_moved(
    study: &Study,
    built: &Built,
    only: Option<&[&str]>,
) -> Result<(), Fault> {
    let Some(moved) = built.moved_names().next() else {
        return Ok(());
    };
    let needy = study.criteria.iter().find(|(name, criterion)| {
        criterion.run.is_some() && only.is_none_or(|only| only.contains(&name.as_str()))
    });
    match needy {
        None => Ok(()),
        Some((name, criterion)) => Err(Fault::at(
            &study.source,
            criterion.span,
            format!(
                "`{name}` needs a value of `{moved}`, which is the own parameter of a stable band and has none here"
            ),
        )
        .help(format!("give `{moved}` a value too: bands do not use it"))),
    }
}
