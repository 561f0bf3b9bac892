//! Regions: a rectangle of two parameters, divided by what is stable in its parts.

use std::fmt::Write as _;

use quell_continuation::{
    Attractor, CurveSolutions, Equilibrium, Interrupt, Kind, ParameterSpan, RegionCell,
    RegionSettings, Settings, region,
};
use quell_model::system::StateKind;

use super::ask::ContinuationTask;
use super::model::Model;
use super::outcome::{BranchPoint, ContinuationFindings};
use super::report::{Reporter, file_stem};
use super::solve::{INTERRUPTED, SEARCHED};
use super::solved::{Member, Solutions};
use super::watch::Watcher;

/// The parts of a rectangle.
#[derive(Debug, Clone)]
pub struct RegionFindings {
    /// The file of the boundaries of cells.
    pub file: String,
    /// Whether the range of each parameter was looked at on a logarithmic scale.
    pub logarithmic: [bool; 2],
    /// From the largest to the smallest.
    pub cells: Vec<CellOutcome>,
    /// How curves and cells were found, in words.
    pub checks: Vec<String>,
}

/// A part of a rectangle that no curve divides.
#[derive(Debug, Clone)]
pub struct CellOutcome {
    /// `A1`, `A2` …
    pub name: String,
    /// What is stable, in words.
    pub label: String,
    /// Where that was looked at, SI.
    pub at: [f64; 2],
    /// Its part of the rectangle, on the scales of the ranges.
    pub area: f64,
    /// Loops of its boundary, the outer one first, then those of holes; SI.
    pub loops: Vec<Vec<[f64; 2]>>,
    /// What was found stable; none where the cell is too narrow to be looked at.
    pub attractors: Option<Vec<AttractorOutcome>>,
}

/// A stable solution.
#[derive(Debug, Clone, PartialEq)]
pub struct AttractorOutcome {
    /// `equilibrium` or `cycle`.
    pub of: &'static str,
    /// The solution.
    pub point: BranchPoint,
}

/// What the label of a cell is that is too narrow to be looked at.
const NARROW: &str = "not looked at";
/// A cell that is smaller and not looked at is not listed, as a part of the rectangle.
const SLIVER: f64 = 1e-4;

impl RegionFindings {
    /// Parts of the rectangle by label, the largest first.
    #[must_use]
    pub fn areas(&self) -> Vec<(String, f64)> {
        let mut found: Vec<(String, f64)> = Vec::new();
        for cell in &self.cells {
            match found.iter_mut().find(|(label, _)| *label == cell.label) {
                Some((_, area)) => *area += cell.area,
                None => found.push((cell.label.clone(), cell.area)),
            }
        }
        found.sort_by(|a, b| b.1.total_cmp(&a.1));
        found
    }

    /// The boundaries as comma-separated values: cell, loop, parameters; SI.
    #[must_use]
    pub fn csv<'n>(&self, names: impl Iterator<Item = &'n str>) -> String {
        let mut text = String::from("cell,label,loop");
        for name in names {
            let _ = write!(text, ",{name}");
        }
        text.push('\n');
        for cell in &self.cells {
            for (index, ring) in cell.loops.iter().enumerate() {
                for [x, y] in ring {
                    let _ = writeln!(
                        text,
                        "{},\"{}\",{},{x:?},{y:?}",
                        cell.name,
                        cell.label,
                        index + 1
                    );
                }
            }
        }
        text
    }
}

/// Divides the rectangle of a task.
pub(super) fn followed(
    name: &str,
    task: &ContinuationTask,
    model: &Model,
    settings: Settings,
    watcher: &Watcher,
) -> (Vec<Member>, ContinuationFindings) {
    let field = model.field();
    let reporter = Reporter {
        name,
        task,
        model,
        field: &field,
    };
    let none = |why: String| (Vec::new(), reporter.findings(&[], why, Vec::new()));
    let base = model.base();
    let state = match model.equilibrium(&base) {
        Ok(state) => state,
        Err(why) => return none(why),
    };
    let [first, second] = model.axes() else {
        return none("a region is of two parameters".to_owned());
    };
    // A range from nothing is no range of decades, however near its end is approached.
    let spans = [first, second].map(|axis| {
        let span = ParameterSpan::new(axis.range.0, axis.range.1);
        ParameterSpan {
            logarithmic: span.logarithmic && !axis.open,
            ..span
        }
    });
    let states = model.system().states();
    let reach = states
        .iter()
        .map(|state| match state.kind {
            StateKind::Rate => 0.0,
            _ => SEARCHED,
        })
        .collect();
    let asked = RegionSettings {
        branch: Settings {
            monitors: vec![watcher.counter()],
            ..settings
        },
        reach,
        ..RegionSettings::new(spans, states.len())
    };
    let start = Equilibrium {
        state,
        parameters: base,
    };
    let found = match region(&field, &start, &asked) {
        Ok(found) => found,
        Err(error) => return none(error.to_string()),
    };
    watcher.measuring();
    let mut checks = checks(model, &found);
    let mut notes: Vec<String> = found
        .failed
        .iter()
        .map(|(what, error)| format!("{what}: {error}"))
        .collect();
    notes.dedup();
    let members: Vec<Member> = found
        .curves
        .into_iter()
        .map(|curve| Member {
            id: curve.name,
            parent: curve.parent,
            solutions: match curve.solutions {
                CurveSolutions::Equilibria(branch) => {
                    Solutions::CriticalEquilibria(branch, curve.kind)
                }
                CurveSolutions::Cycles(branch) => Solutions::CriticalOrbits(branch, curve.kind),
            },
        })
        .collect();
    // Of what attracts in a cell, an interrupted look knows too little.
    if asked
        .branch
        .interrupt
        .as_ref()
        .is_some_and(Interrupt::is_raised)
    {
        let findings = reporter.findings(&members, INTERRUPTED.to_owned(), notes);
        return (members, findings);
    }
    let mut findings = reporter.findings(&members, "done".to_owned(), notes);
    let (cells, narrow): (Vec<RegionCell>, Vec<RegionCell>) = found
        .cells
        .into_iter()
        .partition(|cell| cell.attractors.is_some() || cell.area > SLIVER);
    if !narrow.is_empty() {
        let area: f64 = narrow.iter().map(|cell| cell.area).sum();
        checks.push(format!(
            "{} slivers between curves that nearly touch, together {area:.1e} of the rectangle, were not looked at and are not listed",
            narrow.len()
        ));
    }
    let cells = cells
        .into_iter()
        .enumerate()
        .map(|(index, cell)| outcome(index, cell, &reporter, &findings.oscillations))
        .collect();
    findings.regions = Some(RegionFindings {
        file: format!("{}-cells.csv", file_stem(name)),
        logarithmic: spans.map(|span| span.logarithmic),
        cells,
        checks,
    });
    (members, findings)
}

fn outcome(
    index: usize,
    cell: RegionCell,
    reporter: &Reporter<'_>,
    names: &[String],
) -> CellOutcome {
    let attractors = cell.attractors.map(|found| {
        let mut all: Vec<AttractorOutcome> = found
            .iter()
            .map(|one| match one {
                Attractor::Equilibrium(at) => AttractorOutcome {
                    of: "equilibrium",
                    point: reporter.point(at, 0),
                },
                Attractor::Cycle(orbit) => AttractorOutcome {
                    of: "cycle",
                    point: reporter.point(orbit, 0),
                },
            })
            .collect();
        // Equilibria first, then oscillations in the order of their names.
        all.sort_by_key(|one| (one.of == "cycle", one.point.oscillation));
        all
    });
    CellOutcome {
        name: format!("A{}", index + 1),
        label: attractors
            .as_ref()
            .map_or_else(|| NARROW.to_owned(), |all| label(all, names)),
        at: cell.at,
        area: cell.area,
        loops: cell.loops,
        attractors,
    }
}

/// What is stable, in words.
fn label(attractors: &[AttractorOutcome], names: &[String]) -> String {
    let word = |one: &AttractorOutcome| match (one.of, one.point.oscillation) {
        ("equilibrium", _) => "stable equilibrium",
        (_, Some(index)) => names.get(index).map_or("oscillation", String::as_str),
        _ => "oscillation",
    };
    let mut counted: Vec<(&str, usize)> = Vec::new();
    for one in attractors {
        let word = word(one);
        match counted.iter_mut().find(|(known, _)| *known == word) {
            Some((_, count)) => *count += 1,
            None => counted.push((word, 1)),
        }
    }
    let words: Vec<String> = counted
        .iter()
        .map(|(word, count)| match count {
            1 => (*word).to_owned(),
            more => format!("{more} × {word}"),
        })
        .collect();
    let all = words.join(" or ");
    match attractors.len() {
        0 => "nothing stable found".to_owned(),
        1 => all,
        2 => format!("bistable: {all}"),
        _ => format!("multistable: {all}"),
    }
}

/// How it was found, in words.
fn checks(model: &Model, found: &quell_continuation::Region) -> Vec<String> {
    let name = |index: usize| {
        model
            .axes()
            .get(index)
            .map_or("", |axis| axis.name.as_str())
    };
    let [columns, samples, islands] = found.scan;
    let mut words = vec![
        format!(
            "curves of the equilibrium start where eigenvalues pass the axis on {} branches along lines of `{}` and `{}`, and in a scan of the whole rectangle ({columns} columns, {samples} sets of eigenvalues, {islands} islands between columns)",
            found.lines,
            name(0),
            name(1)
        ),
        format!(
            "what is stable was looked at in one point of each cell, by {} diagrams along both parameters through these points, and by following what is stable in a cell into its neighbours ({} ways): solutions that no such branch reaches are not seen, so this is tested and not proven",
            found.diagrams, found.ways
        ),
    ];
    let from = |kind: Kind| {
        let curves = found.curves.iter();
        curves
            .filter(|curve| curve.kind == kind && curve.parent.is_none())
            .count()
    };
    let loose: Vec<String> = [Kind::CycleFold, Kind::PeriodDoubling, Kind::Torus]
        .into_iter()
        .filter(|kind| from(*kind) > 0)
        .map(|kind| format!("{} of {}", from(kind), kind.code()))
        .collect();
    if !loose.is_empty() {
        words.push(format!(
            "curves that start at no point of codimension two were found on those diagrams: {}; others of their sort may have been missed",
            loose.join(", ")
        ));
    }
    for (from, to) in &found.unresolved {
        words.push(format!(
            "the scan could not tell whether anything passes the axis between `{}` = {from:.6} and {to:.6}",
            name(1)
        ));
    }
    if found.ends {
        words.push(
            "the equilibrium ends within the rectangle; beyond, only branches along lines were looked at"
                .to_owned(),
        );
    }
    if let Some([x, y]) = found.branch_points.first() {
        words.push(format!(
            "a real eigenvalue passes zero without a fold at {} points, first at `{}` = {x:.6}, `{}` = {y:.6}: curves of branch points are not followed, so no cell is bounded by them",
            found.branch_points.len(),
            name(0),
            name(1)
        ));
    }
    if found.mirrored {
        words.push(
            "the equations are the same for the mirrored motion: of mirror images one was counted"
                .to_owned(),
        );
    }
    words
}
