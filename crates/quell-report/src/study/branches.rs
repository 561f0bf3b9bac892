//! Branches, curves, diagrams and regions: a picture for each measure or of both parameters, and a table of special points.

use quell_study::continuation::{
    BranchOutcome, BranchPoint, ContinuationFindings, Follows, MeasureHead,
};

use crate::number::{significant, significant_beside, unit, with_unit};
use crate::page::{PointTable, TaskKind};
use crate::plot::{Axis, Mark, Plot, Role, Series};

/// Digits of a special point.
pub(super) const DIGITS: usize = 6;

/// What kind of task it is.
pub(super) const fn kind(found: &ContinuationFindings) -> TaskKind {
    match found.follows {
        Follows::Branch => TaskKind::Branch,
        Follows::Curve => TaskKind::Curve,
        Follows::Diagram => TaskKind::Diagram,
        Follows::Region => TaskKind::Region,
        Follows::Motions => TaskKind::Simulate,
    }
}

/// The pictures: every measure over the parameter, or the curves over both.
pub(super) fn plots(found: &ContinuationFindings) -> Vec<Plot> {
    let Some(first) = found.parameters.first() else {
        return Vec::new();
    };
    let x = Axis {
        label: first.name.clone(),
        unit: first.unit.clone(),
        logarithmic: false,
    };
    if let Some(regions) = &found.regions {
        return vec![super::regions::plot(found, regions)];
    }
    if let (Follows::Curve, Some(second)) = (found.follows, found.parameters.get(1)) {
        let (low, high) = second.range;
        let place = |point: &BranchPoint| {
            let value = |index: usize| point.parameters.get(index).copied().unwrap_or(f64::NAN);
            (value(0), value(1))
        };
        let y = Axis {
            label: second.name.clone(),
            unit: second.unit.clone(),
            logarithmic: low > 0.0 && high > 30.0 * low,
        };
        return vec![Plot {
            caption: "Special points over two parameters; points of codimension two are marked."
                .to_owned(),
            x,
            y,
            series: found
                .branches
                .iter()
                .map(|branch| series(branch, false, &place))
                .collect(),
            ..Plot::default()
        }];
    }
    let over = |head: &MeasureHead, index: usize| {
        let place = |point: &BranchPoint| {
            let x = point.parameters.first().copied().unwrap_or(f64::NAN);
            let y = point.measures.get(index).copied().unwrap_or(f64::NAN);
            (x, y / head.factor)
        };
        Plot {
            caption: format!(
                "`{}` over `{}`: solid where stable, dashed where unstable; special points are marked.",
                head.name, first.name
            ),
            x: x.clone(),
            y: Axis {
                label: head.name.clone(),
                unit: head.unit.clone(),
                logarithmic: false,
            },
            series: found
                .branches
                .iter()
                .flat_map(|branch| pieces(found, branch, &place))
                .collect(),
            ..Plot::default()
        }
    };
    found
        .measures
        .iter()
        .enumerate()
        .map(|(index, head)| over(head, index))
        .collect()
}

/// A branch in the colours of its oscillations: equilibria in ink, cycles in the colour of their name.
fn pieces(
    found: &ContinuationFindings,
    branch: &BranchOutcome,
    place: &dyn Fn(&BranchPoint) -> (f64, f64),
) -> Vec<Series> {
    let whole = series(branch, true, place);
    if found.oscillations.is_empty() {
        return vec![whole];
    }
    let mut names = Vec::with_capacity(whole.points.len());
    for (index, point) in branch.points.iter().enumerate() {
        names.push(point.oscillation);
        let special = branch.special.iter().filter(|one| one.after == index);
        names.extend(special.map(|one| one.point.oscillation));
    }
    let mut found_pieces: Vec<Series> = Vec::new();
    let mut known = Vec::new();
    let mut from = 0;
    while from < names.len() {
        let own = names.get(from).copied().flatten();
        let same = names.iter().skip(from).take_while(|one| **one == own);
        let end = from + same.count();
        // Pieces share the point at which the name changes.
        let until = (end + 1).min(names.len());
        let called = own.and_then(|index| found.oscillations.get(index));
        found_pieces.push(Series {
            name: called.map_or_else(
                || whole.name.clone(),
                |called| format!("{}: {called}", name(branch)),
            ),
            points: whole.points.get(from..until).unwrap_or_default().to_vec(),
            unstable: whole.unstable.get(from..until).unwrap_or_default().to_vec(),
            hue: Some(own.map_or(0, |index| index + 1)),
            unlisted: known.contains(&own),
            ..Series::default()
        });
        known.push(own);
        from = end;
    }
    if let Some(first) = found_pieces.first_mut() {
        first.marks = whole.marks;
    }
    found_pieces
}

/// A branch with its special points among the others.
pub(super) fn series(
    branch: &BranchOutcome,
    stability: bool,
    place: &dyn Fn(&BranchPoint) -> (f64, f64),
) -> Series {
    let mut points = Vec::new();
    let mut unstable = Vec::new();
    let mut marks = Vec::new();
    let mut add = |point: &BranchPoint, least: usize| {
        points.push(place(point));
        unstable.push(stability && least > 0);
    };
    for (index, point) in branch.points.iter().enumerate() {
        add(point, point.unstable);
        for special in branch.special.iter().filter(|one| one.after == index) {
            // Both sides meet here: the stable one reaches up to it.
            add(&special.point, special.unstable[0].min(special.unstable[1]));
            marks.push(Mark {
                at: place(&special.point),
                text: special.label.clone(),
            });
        }
    }
    Series {
        name: name(branch),
        role: Role::Design,
        points,
        unstable: if stability { unstable } else { Vec::new() },
        marks,
        ..Series::default()
    }
}

fn name(branch: &BranchOutcome) -> String {
    let what = match branch.of {
        "equilibrium" => "equilibria",
        "cycle" => "cycles",
        code => code,
    };
    let from = branch.parent.as_ref();
    from.map_or_else(
        || format!("{} {what}", branch.id),
        |parent| format!("{} {what} from {parent}", branch.id),
    )
}

/// The heading of a column of numbers.
pub(super) fn headed(name: &str, shown: &str) -> String {
    match shown {
        "" | "1" => name.to_owned(),
        text => format!("{name} ({})", unit(text)),
    }
}

/// The special points, and the solutions at the values that were asked for.
pub(super) fn table(found: &ContinuationFindings) -> PointTable {
    if let Some(motions) = &found.motions {
        return super::motions::table(found, motions);
    }
    let mut heading = vec!["Branch".to_owned(), "Point".to_owned()];
    heading.extend(
        found
            .parameters
            .iter()
            .map(|one| headed(&one.name, &one.unit)),
    );
    heading.push("period (s)".to_owned());
    heading.extend(
        found
            .measures
            .iter()
            .map(|one| headed(&one.name, &one.unit)),
    );
    let named = !found.oscillations.is_empty();
    if named {
        heading.push("oscillation".to_owned());
    }
    heading.push("unstable".to_owned());
    let most = found.largest();
    let row = |branch: &BranchOutcome, label: &str, point: &BranchPoint, stability: String| {
        let mut cells = vec![branch.id.clone(), label.to_owned()];
        let numbers = point.parameters.iter();
        cells.extend(numbers.map(|value| significant(*value, DIGITS)));
        cells.push(
            point
                .period
                .map_or_else(String::new, |period| significant(period, DIGITS)),
        );
        let measured = found.measures.iter().zip(&point.measures);
        let shown = measured.zip(&most).map(|((head, value), most)| {
            significant_beside(value / head.factor, most / head.factor, DIGITS)
        });
        cells.extend(shown);
        if named {
            cells.push(found.oscillation(point).unwrap_or_default().to_owned());
        }
        cells.push(stability);
        cells
    };
    let mut rows = Vec::new();
    for branch in &found.branches {
        for special in &branch.special {
            let [before, after] = special.unstable;
            let note = if special.located { "" } else { ", unresolved" };
            let stability = format!("{before} → {after}{note}");
            rows.push(row(branch, &special.label, &special.point, stability));
        }
        for at in &branch.at {
            rows.push(row(branch, "", at, at.unstable.to_string()));
        }
    }
    PointTable {
        found: in_short(found),
        heading,
        rows,
    }
}

/// `3 branches, 6 special points`, or why there is nothing.
fn in_short(found: &ContinuationFindings) -> String {
    if found.branches.is_empty() {
        return found.status.clone();
    }
    let count = |number: usize, one: &str, many: &str| match number {
        1 => format!("1 {one}"),
        _ => format!("{number} {many}"),
    };
    let number = found.branches.len();
    let mut text = match found.follows {
        Follows::Curve | Follows::Region => count(number, "curve", "curves"),
        Follows::Branch | Follows::Diagram | Follows::Motions => {
            count(number, "branch", "branches")
        }
    };
    let special = found.branches.iter().map(|branch| branch.special.len());
    text.push_str(", ");
    text.push_str(&count(special.sum(), "special point", "special points"));
    if let Some(regions) = &found.regions {
        text.push_str(", ");
        text.push_str(&count(regions.cells.len(), "cell", "cells"));
    }
    if found.status != "done" {
        text.push_str(", ");
        text.push_str(&found.status);
    }
    text
}

/// What was followed, in words.
pub(super) fn words(found: &ContinuationFindings) -> Vec<String> {
    let names: Vec<String> = found
        .parameters
        .iter()
        .map(|one| {
            let (low, high) = one.range;
            let high = with_unit(&significant(high, 4), &one.unit);
            format!("`{}` from {} to {high}", one.name, significant(low, 4))
        })
        .collect();
    let mut words = vec![format!("{}.", names.join(", "))];
    let ends: Vec<String> = found
        .branches
        .iter()
        .map(|branch| match branch.stop {
            [one, other] if one == other => format!("{} ends by `{one}`", name(branch)),
            ["not asked", one] | [one, "not asked"] => format!("{} ends by `{one}`", name(branch)),
            [one, other] => format!("{} ends by `{one}` and `{other}`", name(branch)),
        })
        .collect();
    if !ends.is_empty() {
        words.push(format!("{}.", ends.join("; ")));
    }
    if let Some(motions) = &found.motions {
        words = super::motions::words(found, motions);
    }
    if let Some(regions) = &found.regions {
        words.extend(super::regions::words(found, regions));
    }
    words.extend(found.notes.iter().cloned());
    words
}
