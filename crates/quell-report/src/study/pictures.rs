//! Pictures of tasks: responses over frequency or time, criteria over what is swept.

use quell_study::study::Task;
use quell_study::{Over, PointOutcome, Role, TaskOutcome};

use super::Bridge;
use crate::plot::{self, Axis, Plot, Series};

/// Designs drawn over the references.
const DRAWN: usize = 3;

/// Points of a sweep whose responses are drawn in one picture.
const DRAWN_POINTS: usize = 6;

impl Bridge<'_> {
    /// One picture for each response: the best design, or the only configuration, at points spread over the sweep.
    pub(super) fn swept_plots(&self, asked: Option<&Task>, task: &TaskOutcome) -> Vec<Plot> {
        let Some(first) = task.points.first() else {
            return Vec::new();
        };
        let count = task.points.len();
        let shown = count.min(DRAWN_POINTS);
        let chosen: Vec<&PointOutcome> = (0..shown)
            .filter_map(|index| task.points.get(index * (count - 1) / (shown - 1).max(1)))
            .collect();
        first
            .plots
            .iter()
            .enumerate()
            .map(|(index, plot)| {
                let series = chosen
                    .iter()
                    .filter_map(|point| {
                        let own = point.plots.get(index)?.series.iter();
                        let best = own
                            .clone()
                            .find(|series| matches!(series.role, Role::Design(1)))
                            .or_else(|| {
                                own.clone()
                                    .find(|series| series.role == Role::Configuration)
                            })?;
                        Some(curve(
                            best,
                            self.at_words(asked, &point.at),
                            plot::Role::Design,
                        ))
                    })
                    .collect();
                picture(
                    plot,
                    "Response of the best design at points of the sweep",
                    series,
                )
            })
            .collect()
    }
}

/// A response as it is drawn: references in grey, designs in colour.
pub(super) fn response(plot: &quell_study::Plot) -> Plot {
    let mut references = 0;
    let mut evaluated = false;
    let series: Vec<Series> = plot
        .series
        .iter()
        .filter_map(|series| {
            let (role, name) = match series.role {
                Role::Reference => {
                    references += 1;
                    let role = if references == 1 {
                        plot::Role::Baseline
                    } else {
                        plot::Role::Reference
                    };
                    (role, series.name.clone())
                }
                Role::Design(rank) if rank <= DRAWN => {
                    (plot::Role::Design, format!("{rank}: {}", series.name))
                }
                Role::Design(_) => return None,
                Role::Configuration => {
                    evaluated = true;
                    (plot::Role::Design, series.name.clone())
                }
            };
            Some(curve(series, name, role))
        })
        .collect();
    let over = match &plot.over {
        Over::Frequency => "frequency".to_owned(),
        Over::Time => "time".to_owned(),
        Over::Signal(name, _) => name.clone(),
    };
    let caption = match (references, series.len() - references) {
        _ if evaluated => format!(
            "{} over {over}",
            if plot.over == Over::Frequency {
                "Response"
            } else {
                plot.quantity.as_str()
            }
        ),
        (0, _) => "Responses of the best designs".to_owned(),
        (_, 1) => "Response of the design over the references".to_owned(),
        _ => "Responses of the best designs over the references".to_owned(),
    };
    picture(plot, &caption, series)
}

fn curve(series: &quell_study::Series, name: String, role: plot::Role) -> Series {
    Series {
        name,
        role,
        points: series.points.clone(),
        peak: series.peak,
        markers: false,
        ..Series::default()
    }
}

fn picture(plot: &quell_study::Plot, caption: &str, series: Vec<Series>) -> Plot {
    let marked = series.iter().any(|series| series.peak.is_some());
    Plot {
        caption: format!(
            "{caption}{}",
            if marked { "; peaks are marked." } else { "." }
        ),
        x: match &plot.over {
            Over::Frequency => Axis {
                label: "Frequency".to_owned(),
                unit: "Hz".to_owned(),
                logarithmic: plot.logarithmic,
            },
            Over::Time => Axis {
                label: "Time".to_owned(),
                unit: "s".to_owned(),
                logarithmic: false,
            },
            Over::Signal(name, unit) => Axis {
                label: name.clone(),
                unit: unit.clone(),
                logarithmic: false,
            },
        },
        y: Axis {
            label: plot.quantity.clone(),
            unit: plot.unit.clone(),
            logarithmic: plot.logarithmic && wide(&series),
        },
        series,
        limits: Vec::new(),
        areas: Vec::new(),
    }
}

/// Whether the values span so many decades that a linear axis hides most of them.
fn wide(series: &[Series]) -> bool {
    let values = series
        .iter()
        .flat_map(|series| &series.points)
        .map(|(_, value)| *value)
        .filter(|value| *value > 0.0);
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    for value in values {
        least = least.min(value);
        most = most.max(value);
    }
    most > 1e4 * least
}
