//! Branches, curves and diagrams: a picture for each measure, and a table of special points.

use quell_study::continuation::{
    BranchOutcome, BranchPoint, ContinuationFindings, Follows, MeasureHead,
};

use crate::number::{significant, unit};
use crate::page::{PointTable, TaskKind};
use crate::plot::{Axis, Mark, Plot, Role, Series};

/// Digits of a special point.
const DIGITS: usize = 6;

/// What kind of task it is.
pub(super) const fn kind(found: &ContinuationFindings) -> TaskKind {
    match found.follows {
        Follows::Branch => TaskKind::Branch,
        Follows::Curve => TaskKind::Curve,
        Follows::Diagram => TaskKind::Diagram,
        Follows::Region => TaskKind::Region,
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
            limits: Vec::new(),
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
                .map(|branch| series(branch, true, &place))
                .collect(),
            limits: Vec::new(),
        }
    };
    found
        .measures
        .iter()
        .enumerate()
        .map(|(index, head)| over(head, index))
        .collect()
}

/// A branch with its special points among the others.
fn series(
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

/// The special points, and the solutions at the values that were asked for.
pub(super) fn table(found: &ContinuationFindings) -> PointTable {
    let headed = |name: &str, shown: &str| match shown {
        "" | "1" => name.to_owned(),
        text => format!("{name} ({})", unit(text)),
    };
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
    heading.push("unstable".to_owned());
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
        cells.extend(measured.map(|(head, value)| significant(value / head.factor, DIGITS)));
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
    PointTable { heading, rows }
}

/// What was followed, in words.
pub(super) fn words(found: &ContinuationFindings) -> Vec<String> {
    let names: Vec<String> = found
        .parameters
        .iter()
        .map(|one| {
            let (low, high) = one.range;
            format!(
                "`{}` from {} to {}\u{a0}{}",
                one.name,
                significant(low, 4),
                significant(high, 4),
                unit(&one.unit)
            )
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
    words.extend(found.notes.iter().cloned());
    words
}
