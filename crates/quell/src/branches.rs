//! Branches, curves, diagrams, regions and motions as text for a terminal: a table of special points, or of where motions ended.

use std::fmt::Write as _;

use quell_report::number::{significant, significant_beside, unit};
use quell_report::{ended, motion_words};
use quell_study::continuation::{
    BranchOutcome, BranchPoint, ContinuationFindings, Follows, MotionFindings, RegionFindings,
};

use crate::table::{Table, wrap};

/// Digits of a number.
const DIGITS: usize = 6;

/// What a task found, under its name.
pub(crate) fn text(
    text: &mut String,
    name: &str,
    at: &str,
    found: &ContinuationFindings,
    width: usize,
) {
    let parameters: Vec<&str> = found
        .parameters
        .iter()
        .map(|one| one.name.as_str())
        .collect();
    let place = if at.is_empty() {
        String::new()
    } else {
        format!(", at {at}")
    };
    // Writing to a string cannot fail.
    let over = if parameters.is_empty() {
        String::new()
    } else {
        format!(" in {}", parameters.join(" and "))
    };
    let _ = writeln!(text, "{name}: {}{over}{place}", found.follows.kind());
    if found.status != "done" {
        let what = match found.follows {
            Follows::Motions => "LET GO",
            _ => "FOLLOWED",
        };
        for line in wrap(&format!("NOTHING {what}: {}", found.status), width - 2) {
            let _ = writeln!(text, "  {line}");
        }
    }
    if !found.branches.is_empty() {
        text.push_str(&table(found).text(2, width));
    }
    if let Some(regions) = &found.regions {
        text.push_str(&cells(found, regions).text(2, width));
        for check in &regions.checks {
            for line in wrap(&format!("tested: {check}"), width - 2) {
                let _ = writeln!(text, "  {line}");
            }
        }
    }
    if let Some(motions) = &found.motions {
        text.push_str(&let_go(found, motions).text(2, width));
        for words in motion_words(found, motions) {
            for line in wrap(&words, width - 2) {
                let _ = writeln!(text, "  {line}");
            }
        }
    }
    for note in &found.notes {
        for line in wrap(note, width - 2) {
            let _ = writeln!(text, "  {line}");
        }
    }
}

/// Motions with where they ended.
fn let_go(found: &ContinuationFindings, motions: &MotionFindings) -> Table {
    let mut heading: Vec<String> = found
        .parameters
        .iter()
        .map(|one| headed(&one.name, &one.unit))
        .collect();
    let numbers = heading.len();
    heading.extend(["start", "end", "watched [s]", "period [s]"].map(str::to_owned));
    heading.extend(
        found
            .measures
            .iter()
            .map(|one| headed(&one.name, &one.unit)),
    );
    let mut table = Table::new(heading, numbers + 2);
    let most = motions.largest();
    for place in &motions.places {
        for motion in &place.motions {
            let mut row: Vec<String> = place
                .parameters
                .iter()
                .map(|value| significant(*value, 5))
                .collect();
            row.push(motion.start.clone());
            row.push(ended(found, place, motion));
            row.push(significant(motion.duration, 4));
            let period = motion.point.period;
            row.push(period.map_or_else(String::new, |period| significant(period, 5)));
            let measured = found.measures.iter().zip(&motion.point.measures);
            let shown = measured.zip(&most).map(|((head, value), most)| {
                significant_beside(value / head.factor, most / head.factor, 4)
            });
            row.extend(shown);
            table.row(row, Vec::new());
        }
    }
    table
}

/// The heading of a column of numbers.
fn headed(name: &str, shown: &str) -> String {
    match shown {
        "" | "1" => name.to_owned(),
        text => format!("{name} [{}]", unit(text)),
    }
}

/// The parts of a rectangle.
fn cells(found: &ContinuationFindings, regions: &RegionFindings) -> Table {
    let mut heading = vec!["cell".to_owned(), "what is stable".to_owned()];
    heading.extend(
        found
            .parameters
            .iter()
            .map(|one| format!("at {}", one.name)),
    );
    heading.push("part [%]".to_owned());
    let mut table = Table::new(heading, 2);
    for cell in &regions.cells {
        let mut row = vec![cell.name.clone(), cell.label.clone()];
        row.extend(cell.at.iter().map(|value| significant(*value, 4)));
        row.push(significant(100.0 * cell.area, 3));
        table.row(row, Vec::new());
    }
    table
}

fn table(found: &ContinuationFindings) -> Table {
    let mut heading = vec!["branch".to_owned(), "point".to_owned()];
    heading.extend(
        found
            .parameters
            .iter()
            .map(|one| headed(&one.name, &one.unit)),
    );
    heading.push("period [s]".to_owned());
    heading.extend(
        found
            .measures
            .iter()
            .map(|one| headed(&one.name, &one.unit)),
    );
    heading.push("stability".to_owned());
    let mut table = Table::new(heading, 2);
    let most = found.largest();
    for branch in &found.branches {
        let mut cells = vec![branch.id.clone(), words(branch)];
        cells.resize(
            5 + found.parameters.len() + found.measures.len() - 1,
            String::new(),
        );
        table.row(cells, Vec::new());
        let mut rows: Vec<(f64, Vec<String>)> = Vec::new();
        for special in &branch.special {
            let [before, after] = special.unstable;
            let mut stability = format!("{before} → {after} unstable");
            if !special.located {
                stability.push_str(", unresolved");
            }
            for (name, value) in &special.normal_form {
                let _ = write!(stability, ", {name} = {}", significant(*value, 4));
            }
            rows.push((
                special.after as f64,
                row(found, &most, &special.label, &special.point, stability),
            ));
        }
        for at in &branch.at {
            let mut stability = if at.unstable == 0 {
                "stable".to_owned()
            } else {
                format!("{} unstable", at.unstable)
            };
            if let Some(name) = found.oscillation(at) {
                let _ = write!(stability, ", {name}");
            }
            rows.push((f64::INFINITY, row(found, &most, "at", at, stability)));
        }
        for (_, cells) in rows {
            table.row(cells, Vec::new());
        }
    }
    table
}

/// What a branch is, where it comes from and why it ends.
fn words(branch: &BranchOutcome) -> String {
    let what = match branch.of {
        "equilibrium" => "equilibria".to_owned(),
        "cycle" => "cycles".to_owned(),
        code => format!("{code} points"),
    };
    let from = branch
        .parent
        .as_ref()
        .map_or_else(String::new, |parent| format!(" from {parent}"));
    let [backward, forward] = branch.stop;
    let ends = match (backward, forward) {
        (one, other) if one == other => format!("ends: {one}"),
        ("not asked", other) | (other, "not asked") => format!("ends: {other}"),
        (one, other) => format!("ends: {one}, {other}"),
    };
    format!("{what}{from} ({} points; {ends})", branch.points.len())
}

fn row(
    found: &ContinuationFindings,
    most: &[f64],
    label: &str,
    point: &BranchPoint,
    stability: String,
) -> Vec<String> {
    let mut cells = vec![String::new(), label.to_owned()];
    cells.extend(
        point
            .parameters
            .iter()
            .map(|value| significant(*value, DIGITS)),
    );
    cells.push(
        point
            .period
            .map_or_else(String::new, |period| significant(period, DIGITS)),
    );
    cells.extend(found.measures.iter().zip(&point.measures).zip(most).map(
        |((head, value), most)| significant_beside(value / head.factor, most / head.factor, DIGITS),
    ));
    cells.push(stability);
    cells
}
