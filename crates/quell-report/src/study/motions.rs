//! Motions let go from several starts: measures over time, their ends on the diagram that they check, and a table.

use quell_study::continuation::{
    ContinuationFindings, Follows, MotionFindings, MotionOutcome, PlaceOutcome,
};

use super::branches::{DIGITS, headed};
use crate::number::{significant, significant_beside, with_unit};
use crate::page::PointTable;
use crate::plot::{Axis, Plot, Series};

/// Most pictures over time.
const PICTURES: usize = 12;
/// A measure that changes by more is drawn on a logarithmic scale.
const DECADES: f64 = 30.0;

/// The pictures; `of` is what the task found that the motions are compared with.
pub(super) fn plots(
    found: &ContinuationFindings,
    motions: &MotionFindings,
    of: Option<&ContinuationFindings>,
) -> Vec<Plot> {
    let mut plots = of.map_or_else(Vec::new, |of| over_branches(found, motions, of));
    for place in &motions.places {
        for (index, _) in found.measures.iter().enumerate() {
            if plots.len() < PICTURES {
                plots.push(over_time(found, place, index));
            }
        }
    }
    plots
}

/// The pictures of the other task with the ends of the motions in them.
fn over_branches(
    found: &ContinuationFindings,
    motions: &MotionFindings,
    of: &ContinuationFindings,
) -> Vec<Plot> {
    let mut plots = super::branches::plots(of);
    let region = of.follows == Follows::Region;
    for (index, plot) in plots.iter_mut().enumerate() {
        let head = of.measures.get(index);
        let own = head.and_then(|head| found.measures.iter().position(|one| one.name == head.name));
        let place = |at: &PlaceOutcome, motion: &MotionOutcome| {
            let x = at.parameters.first().copied()?;
            let y = if region {
                at.parameters.get(1).copied()?
            } else {
                motion.point.measures.get(own?)? / head?.factor
            };
            Some((x, y))
        };
        let ends = |agree: bool| {
            let mut points = Vec::new();
            for at in &motions.places {
                for motion in &at.motions {
                    let shown = motion.end.settled() && motion.on.is_some() == agree;
                    if let Some(point) = place(at, motion).filter(|_| shown) {
                        // Ends are points, with nothing between them.
                        points.extend([point, (f64::NAN, f64::NAN)]);
                    }
                }
            }
            points
        };
        for (agree, name, hue) in [
            (true, "ends of motions", found.oscillations.len() + 2),
            (false, "ends elsewhere", found.oscillations.len() + 3),
        ] {
            let points = ends(agree);
            if !points.is_empty() {
                plot.series.push(Series {
                    name: name.to_owned(),
                    points,
                    markers: true,
                    hue: Some(hue),
                    ..Series::default()
                });
            }
        }
        plot.caption = format!(
            "{} Points are where motions ended that were let go.",
            plot.caption
        );
    }
    plots
}

/// A measure over time.
fn over_time(found: &ContinuationFindings, place: &PlaceOutcome, index: usize) -> Plot {
    let head = found.measures.get(index);
    let (name, shown, factor) = head.map_or(("", "", 1.0), |head| {
        (head.name.as_str(), head.unit.as_str(), head.factor)
    });
    let series: Vec<Series> = place
        .motions
        .iter()
        .map(|motion| Series {
            name: format!("{}: {}", motion.start, ended(found, place, motion)),
            points: motion
                .envelope
                .iter()
                .map(|(t, values)| (*t, values.get(index).copied().unwrap_or(f64::NAN) / factor))
                .collect(),
            ..Series::default()
        })
        .collect();
    let values = || {
        let points = series.iter().flat_map(|one| &one.points);
        points.map(|(_, value)| *value).filter(|value| *value > 0.0)
    };
    let (low, high) = (
        values().fold(f64::INFINITY, f64::min),
        values().fold(0.0, f64::max),
    );
    Plot {
        caption: format!(
            "`{name}` over stretches of motions{}.",
            at_words(found, place)
        ),
        x: Axis {
            label: "t".to_owned(),
            unit: "s".to_owned(),
            logarithmic: false,
        },
        y: Axis {
            label: name.to_owned(),
            unit: shown.to_owned(),
            logarithmic: high > DECADES * low,
        },
        series,
        ..Plot::default()
    }
}

/// ` at V = 20 m/s`.
fn at_words(found: &ContinuationFindings, place: &PlaceOutcome) -> String {
    let values: Vec<String> = found
        .parameters
        .iter()
        .zip(&place.parameters)
        .map(|(one, value)| {
            let shown = with_unit(&significant(*value, 5), &one.unit);
            format!("`{}` = {shown}", one.name)
        })
        .collect();
    if values.is_empty() {
        String::new()
    } else {
        format!(" at {}", values.join(", "))
    }
}

/// What a motion came to, in a few words.
pub fn ended(found: &ContinuationFindings, place: &PlaceOutcome, motion: &MotionOutcome) -> String {
    let what = match motion.end.why() {
        Some(why) => return why.to_owned(),
        None if motion.point.period.is_some() => {
            found.oscillation(&motion.point).unwrap_or("oscillation")
        }
        None => "at rest",
    };
    match motion.on.and_then(|on| place.stable.get(on)) {
        Some(one) => format!("{what} ({})", one.on),
        None => what.to_owned(),
    }
}

/// All motions, with what is stable where they were let go.
pub(super) fn table(found: &ContinuationFindings, motions: &MotionFindings) -> PointTable {
    let mut heading: Vec<String> = found
        .parameters
        .iter()
        .map(|one| headed(&one.name, &one.unit))
        .collect();
    heading.extend(["start", "end", "watched (s)", "period (s)"].map(str::to_owned));
    heading.extend(
        found
            .measures
            .iter()
            .map(|one| headed(&one.name, &one.unit)),
    );
    let most = motions.largest();
    let mut rows = Vec::new();
    for place in &motions.places {
        for motion in &place.motions {
            let numbers = place.parameters.iter();
            let mut cells: Vec<String> = numbers.map(|value| significant(*value, DIGITS)).collect();
            cells.push(motion.start.clone());
            cells.push(ended(found, place, motion));
            cells.push(significant(motion.duration, 4));
            let period = motion.point.period;
            cells.push(period.map_or_else(String::new, |period| significant(period, DIGITS)));
            let measured = found.measures.iter().zip(&motion.point.measures);
            let shown = measured.zip(&most).map(|((head, value), most)| {
                significant_beside(value / head.factor, most / head.factor, 4)
            });
            cells.extend(shown);
            rows.push(cells);
        }
    }
    PointTable {
        found: motions.summary(),
        heading,
        rows,
    }
}

/// What was let go and where it ended, in words.
pub fn words(found: &ContinuationFindings, motions: &MotionFindings) -> Vec<String> {
    let mut words = vec![format!("{}.", motions.summary())];
    for place in &motions.places {
        let at = at_words(found, place);
        for (index, one) in place.stable.iter().enumerate() {
            if !place.motions.iter().any(|motion| motion.on == Some(index)) {
                let what = found
                    .oscillation(&one.point)
                    .map_or_else(|| one.of.to_owned(), |name| format!("{} ({name})", one.of));
                words.push(format!(
                    "No motion{at} ended on the stable {what} of {}: none of the starts lies in its basin.",
                    one.on
                ));
            }
        }
        if motions.of.is_some() {
            for motion in &place.motions {
                if motion.end.settled() && motion.on.is_none() {
                    words.push(format!(
                        "A motion{at} ({}) ended elsewhere: {}, which is no stable solution of `{}`.",
                        motion.start,
                        ended(found, place, motion),
                        motions.of.as_deref().unwrap_or_default()
                    ));
                }
            }
        }
    }
    if motions.of.is_some() {
        words.push(
            "Tested: so many motions from these starts. What they agree on is seen, not proven, and an attractor that none of them reaches would not be seen."
                .to_owned(),
        );
    }
    words
}
