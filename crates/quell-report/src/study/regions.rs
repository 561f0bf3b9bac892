//! A rectangle of two parameters, shaded by what is stable in its parts.

use std::fmt::Write as _;

use quell_study::continuation::{
    BranchPoint, CellOutcome, ContinuationFindings, FreeParameter, RegionFindings,
};

use super::branches::series;
use crate::number::{significant, with_unit};
use crate::plot::{Area, Axis, Mark, Plot, Series};

/// A cell that is smaller than this part of the rectangle has no text in it.
const LETTERED: f64 = 0.015;

/// The dashes of a curve, and what its points are.
fn drawn(of: &str) -> (Option<&'static str>, &'static str) {
    match of {
        "H" => (None, "Hopf points"),
        "LP" => (Some("12 4"), "folds of equilibria"),
        "NS" => (Some("6 3"), "torus points"),
        "LPC" => (Some("2 2"), "folds of cycles"),
        "PD" => (Some("8 3 2 3"), "period doublings"),
        _ => (Some("4 4"), "special points"),
    }
}

/// Labels in the order in which they are coloured: the stable equilibrium has no colour.
fn hues(found: &ContinuationFindings, regions: &RegionFindings) -> Vec<(String, usize)> {
    let areas = regions.areas();
    let mut labels: Vec<(String, usize)> = Vec::new();
    let plain = |label: &str| {
        label == "stable equilibrium"
            || regions
                .cells
                .iter()
                .any(|cell| cell.label == label && cell.attractors.is_none())
    };
    // Names of oscillations have the colours that they have in diagrams.
    for (index, name) in found.oscillations.iter().enumerate() {
        labels.push((name.clone(), index + 1));
    }
    let mut next = found.oscillations.len() + 1;
    for (label, _) in areas {
        if plain(&label) {
            labels.push((label, 0));
        } else if !labels.iter().any(|(known, _)| *known == label) {
            labels.push((label, next));
            next += 1;
        }
    }
    labels
}

/// The picture.
pub(super) fn plot(found: &ContinuationFindings, regions: &RegionFindings) -> Plot {
    let axis = |index: usize| {
        let one = found.parameters.get(index);
        Axis {
            label: one.map_or_else(String::new, |one| one.name.clone()),
            unit: one.map_or_else(String::new, |one| one.unit.clone()),
            logarithmic: regions.logarithmic.get(index).copied().unwrap_or(false),
        }
    };
    let place = |point: &BranchPoint| {
        let value = |index: usize| point.parameters.get(index).copied().unwrap_or(f64::NAN);
        (value(0), value(1))
    };
    let mut kinds: Vec<&str> = Vec::new();
    let mut points: Vec<Mark> = Vec::new();
    let curves = found.branches.iter().map(|branch| {
        let (dashes, name) = drawn(branch.of);
        let unlisted = kinds.contains(&branch.of);
        kinds.push(branch.of);
        let mut own = Series {
            name: name.to_owned(),
            hue: Some(0),
            dashes,
            unlisted,
            ..series(branch, false, &place)
        };
        points.append(&mut own.marks);
        own
    });
    let mut series: Vec<Series> = curves.collect();
    let hues = hues(found, regions);
    let mut areas: Vec<Area> = regions.cells.iter().map(|cell| area(cell, &hues)).collect();
    let ranges: Vec<(f64, f64)> = found.parameters.iter().map(|one| one.range).collect();
    let cells = areas.iter_mut().filter_map(|area| area.mark.as_mut());
    legible(&mut points, cells, &ranges, regions.logarithmic);
    if let Some(first) = series.first_mut() {
        first.marks = points;
    }
    Plot {
        caption: "What is stable over two parameters: each part between curves was looked at in one point."
            .to_owned(),
        x: axis(0),
        y: axis(1),
        series,
        areas,
        ..Plot::default()
    }
}

/// Texts that would lie on others are left out: a point of codimension two lies on two curves, and resonances come close to each other.
fn legible<'m>(
    points: &mut [Mark],
    cells: impl Iterator<Item = &'m mut Mark>,
    ranges: &[(f64, f64)],
    logarithmic: [bool; 2],
) {
    let part = |index: usize, value: f64| {
        let (low, high) = ranges.get(index).copied().unwrap_or((0.0, 1.0));
        if logarithmic.get(index).copied().unwrap_or(false) {
            (value / low).ln() / (high / low).ln()
        } else {
            (value - low) / (high - low)
        }
    };
    let place = |mark: &Mark| (part(0, mark.at.0), part(1, mark.at.1));
    let mut taken: Vec<(f64, f64)> = Vec::new();
    let mut free = |mark: &Mark| {
        let (x, y) = place(mark);
        let far = |known: &(f64, f64)| (known.0 - x).abs() > 0.045 || (known.1 - y).abs() > 0.045;
        let free = taken.iter().all(far);
        if free {
            taken.push((x, y));
        }
        free
    };
    // Those of equilibria first: cells begin there.
    points.sort_by_key(|mark| {
        !["HH", "GH", "BT", "ZH", "CP"].iter().any(|code| {
            let rest = mark.text.strip_prefix(code);
            rest.is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()))
        })
    });
    for mark in points.iter_mut() {
        if !free(mark) {
            mark.text.clear();
        }
    }
    for mark in cells {
        if !free(mark) {
            mark.text.clear();
        }
    }
}

fn area(cell: &CellOutcome, hues: &[(String, usize)]) -> Area {
    let hue = hues.iter().find(|(label, _)| *label == cell.label);
    let lettered = cell.area >= LETTERED;
    Area {
        name: cell.label.clone(),
        hue: hue.map_or(0, |(_, hue)| *hue),
        loops: cell
            .loops
            .iter()
            .map(|ring| ring.iter().map(|[x, y]| (*x, *y)).collect())
            .collect(),
        mark: lettered.then(|| Mark {
            at: (cell.at[0], cell.at[1]),
            text: cell.name.clone(),
        }),
    }
}

/// What is stable in how much of the rectangle, and how that was found.
pub(super) fn words(found: &ContinuationFindings, regions: &RegionFindings) -> Vec<String> {
    let shares: Vec<String> = regions
        .areas()
        .iter()
        .map(|(label, area)| format!("{label} {}\u{a0}%", significant(100.0 * area, 3)))
        .collect();
    let mut words = vec![format!(
        "Of the rectangle, on the scales of the picture: {}.",
        shares.join(", ")
    )];
    words.extend(regions.cells.iter().map(|cell| told(found, cell)));
    words.extend(
        regions
            .checks
            .iter()
            .map(|check| format!("Tested: {check}.")),
    );
    words
}

/// A cell in words.
fn told(found: &ContinuationFindings, cell: &CellOutcome) -> String {
    let at = |(one, value): (&FreeParameter, &f64)| {
        let shown = with_unit(&significant(*value, 4), &one.unit);
        format!("`{}` = {shown}", one.name)
    };
    let place: Vec<String> = found.parameters.iter().zip(&cell.at).map(at).collect();
    let mut text = format!(
        "{}: {} (looked at in {})",
        cell.name,
        cell.label,
        place.join(", ")
    );
    for one in cell
        .attractors
        .iter()
        .flatten()
        .filter(|one| one.of == "cycle")
    {
        let named = found.oscillation(&one.point).unwrap_or("oscillation");
        let measured = found.measures.iter().zip(&one.point.measures);
        let numbers: Vec<String> = measured
            .map(|(head, value)| {
                let shown = with_unit(&significant(value / head.factor, 4), &head.unit);
                format!("`{}` {shown}", head.name)
            })
            .collect();
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "; {named} of {}\u{a0}s",
            significant(one.point.period.unwrap_or(f64::NAN), 4)
        );
        if !numbers.is_empty() {
            let _ = write!(text, ", {}", numbers.join(", "));
        }
    }
    text.push('.');
    text
}
