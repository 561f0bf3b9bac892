//! Stable bands: what limits each and what was tested, and their edges over a sweep.

use quell_study::band::BandResult;
use quell_study::{Evaluated, Findings, RunOutcome, TaskOutcome};

use super::problem::evaluated;
use crate::number::significant;
use crate::number::unit;
use crate::plot::{Axis, Mark, Plot, Role, Series};

/// Digits of an edge.
const DIGITS: usize = 6;

/// The bands of a configuration or design in words.
fn of(one: &Evaluated) -> Vec<String> {
    let mut words = Vec::new();
    for (criterion, detail) in &one.details {
        for band in &detail.bands {
            let unit = &detail.unit;
            let [below, above] = &band.limited_by;
            words.push(format!(
                "`{}`, `{criterion}`: stable from {} to {} {unit}, {} {unit} wide; below ends {below}, above {above}.",
                one.name,
                significant(band.lower, DIGITS),
                significant(band.upper, DIGITS),
                significant(band.upper - band.lower, DIGITS),
            ));
            words.extend(band.near.iter().map(|near| format!("Near: {near}.")));
            words.push(format!("Tested, not proven: {}.", band.checks.join("; ")));
        }
    }
    words
}

/// The bands of a task in words.
pub(super) fn words(task: &TaskOutcome) -> Vec<String> {
    let Some(first) = task.points.first() else {
        return Vec::new();
    };
    let mut words: Vec<String> = if task.points.len() == 1 {
        evaluated(&first.findings).flat_map(of).collect()
    } else {
        Vec::new()
    };
    for event in &task.events {
        words.push(format!(
            "{} = {}: {} ({}, {}).",
            event.parameter,
            significant(event.value, DIGITS),
            event.what,
            event.configuration,
            event.place
        ));
    }
    words
}

/// The widest bands of all configurations and best designs side by side, a picture for each criterion.
pub(super) fn comparisons(outcome: &RunOutcome) -> Vec<Plot> {
    /// The widest band by the name of what has it.
    type Named = Vec<(String, BandResult)>;
    // By criterion, with its unit.
    let mut found: Vec<(String, String, Named)> = Vec::new();
    for task in &outcome.tasks {
        let [point] = task.points.as_slice() else {
            continue;
        };
        let shown: Vec<(&String, &Evaluated)> = match &point.findings {
            Findings::Evaluate(all) => all.iter().map(|one| (&one.name, one)).collect(),
            Findings::Design(design) => {
                let best = design.designs.first();
                best.map(|best| (&task.name, &best.configuration))
                    .into_iter()
                    .collect()
            }
            _ => Vec::new(),
        };
        for (called, one) in shown {
            for (criterion, detail) in &one.details {
                let width = |band: &BandResult| band.upper - band.lower;
                let widest = detail
                    .bands
                    .iter()
                    .max_by(|a, b| width(a).total_cmp(&width(b)));
                let Some(widest) = widest else { continue };
                let own = (called.clone(), widest.clone());
                match found.iter_mut().find(|known| known.0 == *criterion) {
                    Some(known) => known.2.push(own),
                    None => found.push((criterion.clone(), detail.unit.clone(), vec![own])),
                }
            }
        }
    }
    found
        .into_iter()
        .filter(|(.., bands)| bands.len() > 1)
        .map(|(criterion, shown, bands)| compared(&criterion, &shown, &bands))
        .collect()
}

/// Bands of one criterion, each at the height of its width.
fn compared(criterion: &str, shown: &str, bands: &[(String, BandResult)]) -> Plot {
    let axis = |label: &str| Axis {
        label: label.to_owned(),
        unit: shown.to_owned(),
        logarithmic: false,
    };
    Plot {
        caption: format!(
            "The widest stable band (`{criterion}`) of every configuration and best design: from its lower to its upper end, at the height of its width."
        ),
        x: axis("band"),
        y: axis("width"),
        series: bands
            .iter()
            .map(|(name, band)| {
                let width = band.upper - band.lower;
                Series {
                    name: format!("{name}: {}\u{a0}{}", significant(width, 5), unit(shown)),
                    role: Role::Design,
                    points: vec![(band.lower, width), (band.upper, width)],
                    markers: true,
                    marks: vec![Mark {
                        at: (band.upper, width),
                        text: name.clone(),
                    }],
                    ..Series::default()
                }
            })
            .collect(),
        ..Plot::default()
    }
}

/// Edges of bands over the first swept parameter, a picture for each criterion.
pub(super) fn plots(task: &TaskOutcome) -> Vec<Plot> {
    let Some(first) = task.points.first().filter(|_| task.points.len() > 1) else {
        return Vec::new();
    };
    let Some(axis) = first.at.first() else {
        return Vec::new();
    };
    let Some(one) = evaluated(&first.findings).next() else {
        return Vec::new();
    };
    let criteria = one.details.iter().filter(|(name, _)| {
        task.points.iter().any(|point| {
            evaluated(&point.findings).any(|one| {
                let detail = one.details.get(*name);
                detail.is_some_and(|detail| !detail.bands.is_empty())
            })
        })
    });
    criteria
        .map(|(name, detail)| Plot {
            caption: format!(
                "Stable bands (`{name}`) over `{}`: each pair of curves is the lower and the upper end of a band; they end where an island splits it.",
                axis.name
            ),
            x: Axis {
                label: axis.name.clone(),
                unit: axis.unit.clone(),
                logarithmic: false,
            },
            y: Axis {
                label: name.clone(),
                unit: detail.unit.clone(),
                logarithmic: false,
            },
            series: series(task, name),
            limits: Vec::new(),
            areas: Vec::new(),
        })
        .collect()
}

/// The ends of the first, second … band of the best design or the first configuration at every point.
fn series(task: &TaskOutcome, criterion: &str) -> Vec<Series> {
    let bands = |index: usize| -> Vec<BandResult> {
        let findings = task.points.get(index).map(|point| &point.findings);
        let one = findings.and_then(|findings| evaluated(findings).next());
        one.and_then(|one| one.details.get(criterion))
            .map_or_else(Vec::new, |detail| detail.bands.clone())
    };
    let all: Vec<Vec<BandResult>> = (0..task.points.len()).map(bands).collect();
    let most = all.iter().map(Vec::len).max().unwrap_or(0);
    let mut series = events(task, criterion, &all);
    for band in 0..most {
        for (side, name) in [(0, "lower"), (1, "upper")] {
            let points = task
                .points
                .iter()
                .zip(&all)
                .map(|(point, bands)| {
                    let x = point.at.first().map_or(f64::NAN, |at| at.value);
                    let y = bands.get(band).map_or(f64::NAN, |band| {
                        if side == 0 { band.lower } else { band.upper }
                    });
                    (x, y)
                })
                .collect();
            let points = broken(points, &splits(task, criterion));
            series.push(Series {
                name: if most > 1 {
                    format!("{name} end, band {}", band + 1)
                } else {
                    format!("{name} end")
                },
                role: Role::Design,
                points,
                markers: true,
                ..Series::default()
            });
        }
    }
    series
}

/// Where along the sweep an island begins or ceases to split a band.
fn splits(task: &TaskOutcome, criterion: &str) -> Vec<f64> {
    let islands = task
        .events
        .iter()
        .filter(|event| event.criterion == criterion && event.what.starts_with("island"));
    islands.map(|event| event.value).collect()
}

/// A curve that is not drawn across these places.
fn broken(points: Vec<(f64, f64)>, at: &[f64]) -> Vec<(f64, f64)> {
    let mut found: Vec<(f64, f64)> = Vec::with_capacity(points.len() + at.len());
    for point in points {
        let before = found.last().map_or(f64::NAN, |last| last.0);
        let between = |value: &&f64| (**value - before) * (**value - point.0) < 0.0;
        if let Some(value) = at.iter().find(between) {
            found.push((*value, f64::NAN));
        }
        found.push(point);
    }
    found
}

/// A line at every event of the sweep, with its name.
fn events(task: &TaskOutcome, criterion: &str, all: &[Vec<BandResult>]) -> Vec<Series> {
    let ends = all
        .iter()
        .flatten()
        .flat_map(|band| [band.lower, band.upper]);
    let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), end| {
        (low.min(end), high.max(end))
    });
    let own = task
        .events
        .iter()
        .filter(|event| event.criterion == criterion);
    own.map(|event| Series {
        name: format!(
            "{}, {} = {}",
            event.what,
            event.parameter,
            significant(event.value, DIGITS)
        ),
        role: Role::Design,
        points: vec![(event.value, low), (event.value, high)],
        hue: Some(0),
        dashes: Some("3 3"),
        ..Series::default()
    })
    .collect()
}
