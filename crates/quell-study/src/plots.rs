//! Responses to be drawn: references and designs on one frequency axis.

use std::f64::consts::TAU;

use crate::evaluator::{Drawable, Evaluator, EvaluatorScratch};
use crate::linear::{Linear, Output};
use crate::outcome::{Over, Plot, Role, Series};
use crate::study::Study;
use crate::transient::History;

/// Points of a curve before peaks are added.
const POINTS: usize = 400;

/// Plots under way, one for each criterion that is a number of a frequency response.
#[derive(Debug, Default)]
pub(crate) struct Curves {
    only: Option<String>,
    plots: Vec<(String, Plot)>,
}

impl Curves {
    /// Curves of one criterion alone.
    pub(crate) fn only(criterion: &str) -> Self {
        Self {
            only: Some(criterion.to_owned()),
            plots: Vec::new(),
        }
    }

    /// Adds the curves of a candidate with values.
    pub(crate) fn add(
        &mut self,
        study: &Study,
        evaluator: &Evaluator,
        point: &[f64],
        name: &str,
        role: Role,
    ) {
        let built = evaluator.built();
        if point.len() != built.variables.len() {
            return;
        }
        let mut scratch = EvaluatorScratch::default();
        built.values(point, &mut scratch.values);
        let points = evaluator.operating_points(&scratch.values);
        for history in evaluator.histories(&scratch.values, self.only.as_deref()) {
            self.add_history(history, name, role);
        }
        let names: Vec<&str> = evaluator.names().collect();
        for (index, criterion) in names.iter().enumerate() {
            if self.only.as_deref().is_some_and(|only| only != *criterion) {
                continue;
            }
            let Some(drawable) = evaluator.drawable(index) else {
                continue;
            };
            let title = quantity(study, criterion);
            let Ok(linear) = evaluator.linear(drawable.run, &scratch.values, &points) else {
                continue;
            };
            let Drawable {
                input,
                output,
                band,
                ..
            } = drawable;
            // Curves that are compared run over the same frequencies: without a band those of the first.
            let first = || self.range(criterion);
            let own = || around_modes(&linear);
            let Some((low, high)) = band.or_else(first).or_else(own) else {
                continue;
            };
            let logarithmic = low > 0.0 && high / low > 50.0;
            let marked = band.and_then(|band| linear.certify(input, output, band, 1e-6).ok());
            let peak = marked.as_ref().map(|peak| (peak.omega / TAU, peak.value));
            let points = curve(
                &linear,
                input,
                output,
                (low, high),
                logarithmic,
                marked.map(|peak| peak.omega),
            );
            let series = Series {
                name: name.to_owned(),
                role,
                points,
                peak,
            };
            match self.plots.iter_mut().find(|(known, _)| known == criterion) {
                Some((_, plot)) => plot.series.push(series),
                None => self.plots.push((
                    (*criterion).to_owned(),
                    Plot {
                        over: Over::Frequency,
                        quantity: title,
                        unit: response_unit(evaluator, index),
                        logarithmic,
                        series: vec![series],
                    },
                )),
            }
        }
    }

    /// Adds what happened in a run in time.
    fn add_history(&mut self, history: History, name: &str, role: Role) {
        let series = Series {
            name: name.to_owned(),
            role,
            points: history.points,
            peak: None,
        };
        // Several runs may look at one signal, each by itself.
        let key = format!(
            "{}: {} over {:?}",
            history.run, history.quantity, history.over
        );
        match self.plots.iter_mut().find(|(known, _)| *known == key) {
            Some((_, plot)) => plot.series.push(series),
            None => self.plots.push((
                key,
                Plot {
                    over: history.over,
                    quantity: history.quantity,
                    unit: history.unit,
                    logarithmic: false,
                    series: vec![series],
                },
            )),
        }
    }

    /// The angular frequencies over which the first curve of a criterion runs.
    fn range(&self, criterion: &str) -> Option<(f64, f64)> {
        let (_, plot) = self.plots.iter().find(|(known, _)| known == criterion)?;
        let points = &plot.series.first()?.points;
        Some((points.first()?.0 * TAU, points.last()?.0 * TAU))
    }

    /// The plots, without repetitions of the same response under another criterion.
    pub(crate) fn finish(self) -> Vec<Plot> {
        let mut plots: Vec<Plot> = Vec::new();
        for (_, plot) in self.plots {
            if !plots
                .iter()
                .any(|known| known.quantity == plot.quantity && known.series == plot.series)
            {
                plots.push(plot);
            }
        }
        plots
    }
}

/// What the criterion looks at, in words: the innermost signal's magnitude.
fn quantity(study: &Study, criterion: &str) -> String {
    let Some(known) = study.criteria.get(criterion) else {
        return criterion.to_owned();
    };
    let mut signal = None;
    known.value.walk(&mut |part| {
        if let quell_expression::Node::Call {
            function,
            arguments,
            ..
        } = &part.node
            && matches!(function.as_str(), "abs" | "h2" | "rms" | "variance")
            && signal.is_none()
        {
            signal = arguments.first().map(ToString::to_string);
        }
    });
    match (
        signal,
        known.run.as_ref().and_then(|run| study.runs.get(run)),
    ) {
        (Some(signal), Some(crate::study::Run::Frequency(run))) => {
            format!("|{signal} / {}|", run.input)
        }
        _ => known.value.to_string(),
    }
}

fn response_unit(evaluator: &Evaluator, criterion: usize) -> String {
    evaluator.response_dimension(criterion).unit_text()
}

/// A decade below the slowest to a decade above the fastest mode.
fn around_modes(linear: &Linear<'_>) -> Option<(f64, f64)> {
    let modes = linear.modes().ok()?;
    let speeds = modes
        .modes
        .iter()
        .map(|mode| mode.eigenvalue.norm())
        .filter(|speed| *speed > 0.0);
    let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
    for speed in speeds {
        low = low.min(speed);
        high = high.max(speed);
    }
    (low.is_finite() && high > 0.0).then_some((low / 3.0, high * 3.0))
}

fn curve(
    linear: &Linear<'_>,
    input: usize,
    output: &Output,
    (low, high): (f64, f64),
    logarithmic: bool,
    peak: Option<f64>,
) -> Vec<(f64, f64)> {
    let low = if low > 0.0 { low } else { high * 1e-4 };
    let mut omegas: Vec<f64> = (0..=POINTS)
        .map(|index| {
            let share = index as f64 / POINTS as f64;
            if logarithmic {
                low * (high / low).powf(share)
            } else {
                low + (high - low) * share
            }
        })
        .collect();
    // A curve shows its peak, however narrow.
    if let Some(peak) = peak {
        omegas.extend(
            [0.99, 0.997, 1.0, 1.003, 1.01]
                .map(|factor| factor * peak)
                .into_iter()
                .filter(|omega| *omega >= low && *omega <= high),
        );
        omegas.sort_by(f64::total_cmp);
    }
    linear
        .magnitudes(input, output, &omegas)
        .into_iter()
        .map(|(omega, value)| (omega / TAU, value))
        .collect()
}
