//! Branches, curves, diagrams, regions and motions in `results.json`.

use indexmap::IndexMap;
use serde::Serialize;

use super::motions::{MotionFindings, PlaceOutcome};
use super::outcome::{BranchOutcome, BranchPoint, ContinuationFindings, SpecialPoint};
use super::region::{AttractorOutcome, CellOutcome};

/// What a task of kind `branch`, `curve`, `diagram` or `region` found.
#[derive(Debug, Clone, Serialize)]
pub struct ContinuationResult {
    /// Names of the free parameters.
    pub parameters: Vec<String>,
    /// Layouts and values.
    pub devices: IndexMap<String, crate::results::DeviceResult>,
    /// The branches.
    pub branches: Vec<BranchResult>,
    /// region: the parts of the rectangle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub regions: Option<Box<RegionResult>>,
    /// simulate: motions from several starts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motions: Option<Box<MotionsResult>>,
    /// What could not be followed, and why.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
}

/// Motions let go from several starts.
#[derive(Debug, Clone, Serialize)]
pub struct MotionsResult {
    /// The task whose stable solutions they are compared with.
    pub of: Option<String>,
    /// How many motions there are.
    pub count: usize,
    /// How many ended on a solution that the other task says is stable.
    pub agree: usize,
    /// How many ended on another.
    pub elsewhere: usize,
    /// How many had not settled, or broke off.
    pub open: usize,
    /// The file of their measures over time, beside `results.json`.
    pub file: String,
    /// By values of the parameters.
    pub at: Vec<PlaceResult>,
}

/// Motions at one set of values of the parameters.
#[derive(Debug, Clone, Serialize)]
pub struct PlaceResult {
    /// Values of the parameters, SI.
    pub parameters: IndexMap<String, f64>,
    /// What the other task says is stable here.
    pub stable: Vec<StableResult>,
    /// One for each start.
    pub motions: Vec<MotionResult>,
}

/// A solution that the other task says is stable.
#[derive(Debug, Clone, Serialize)]
pub struct StableResult {
    /// The branch, or the cell of a region.
    pub on: String,
    /// What it is; of a cell at the point in which the cell was looked at.
    #[serde(flatten)]
    pub solution: AttractorResult,
    /// How many motions ended there.
    pub reached: usize,
}

/// A motion.
#[derive(Debug, Clone, Serialize)]
pub struct MotionResult {
    /// Where it began.
    pub start: String,
    /// What it came to: `equilibrium`, `cycle`, `open` (still changing) or `failed`.
    pub end: &'static str,
    /// Why it is open or failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub why: Option<String>,
    /// The branch or cell that says so; null where none does.
    pub on: Option<String>,
    /// How long it was watched, s.
    pub duration_s: f64,
    /// The name of the oscillation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub oscillation: Option<String>,
    /// Period of a cycle, s.
    pub period_s: Option<f64>,
    /// By name, SI; of an open motion over its last stretch.
    pub measures: IndexMap<String, f64>,
}

/// A rectangle of two parameters, divided by what is stable in its parts.
#[derive(Debug, Clone, Serialize)]
pub struct RegionResult {
    /// The file of the boundaries of cells, beside `results.json`.
    pub file: String,
    /// Part of the rectangle by what is stable there, on the scales of the ranges.
    pub areas: IndexMap<String, f64>,
    /// The cells, from the largest to the smallest.
    pub cells: Vec<CellResult>,
    /// How curves and cells were found, in words: tested is not proven.
    pub checks: Vec<String>,
}

/// A part of the rectangle that no curve divides.
#[derive(Debug, Clone, Serialize)]
pub struct CellResult {
    /// `A1`, `A2` …
    pub name: String,
    /// What is stable, in words.
    pub label: String,
    /// Where that was looked at, SI.
    pub at: IndexMap<String, f64>,
    /// Its part of the rectangle, on the scales of the ranges.
    pub area: f64,
    /// What was found stable; null where the cell is too narrow to be looked at.
    pub attractors: Option<Vec<AttractorResult>>,
}

/// A stable solution.
#[derive(Debug, Clone, Serialize)]
pub struct AttractorResult {
    /// `equilibrium` or `cycle`.
    pub of: &'static str,
    /// The name of the oscillation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub oscillation: Option<String>,
    /// Period of a cycle, s.
    pub period_s: Option<f64>,
    /// By name, SI.
    pub measures: IndexMap<String, f64>,
}

/// A branch or curve.
#[derive(Debug, Clone, Serialize)]
pub struct BranchResult {
    /// `E1`, `C1`, `K1` …: of equilibria, cycles, special points.
    pub id: String,
    /// `equilibrium`, `cycle`, or the code of the special points that the curve consists of.
    pub of: &'static str,
    /// The labelled point that it was born at, `E1:H1`.
    pub parent: Option<String>,
    /// Why it ends.
    pub stop: StopResult,
    /// The file of its points, beside `results.json`.
    pub file: String,
    /// Special points from the backward to the forward end.
    pub special: Vec<SpecialResult>,
    /// Solutions at the values of the parameter that were asked for.
    pub at: Vec<AtResult>,
}

/// Why a branch ends.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct StopResult {
    /// In the direction that the start looks back in.
    pub backward: &'static str,
    /// In the other.
    pub forward: &'static str,
}

/// A special point.
#[derive(Debug, Clone, Serialize)]
pub struct SpecialResult {
    /// Kind and number along the branch, `H1`.
    pub label: String,
    /// Code of the kind.
    pub kind: String,
    /// Values of the free parameters, SI.
    pub parameters: IndexMap<String, f64>,
    /// Period of a cycle, s.
    pub period_s: Option<f64>,
    /// Frequency of the critical pair, rad/s; at a torus point its angle in a period, rad.
    pub omega: Option<f64>,
    /// Frequency of the second pair, rad/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub second_omega: Option<f64>,
    /// Numbers of unstable eigenvalues or multipliers before and after.
    pub unstable: [usize; 2],
    /// Coefficients of the normal form by name.
    pub normal_form: IndexMap<&'static str, f64>,
    /// The name of the oscillation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub oscillation: Option<String>,
    /// By name, SI.
    pub measures: IndexMap<String, f64>,
    /// Uncertainty of the parameter, SI.
    pub error: f64,
    /// `located`, or `unresolved`: something happens here that could not be told apart.
    pub status: &'static str,
}

/// A solution at a value of the parameter that was asked for.
#[derive(Debug, Clone, Serialize)]
pub struct AtResult {
    /// Values of the free parameters, SI.
    pub parameters: IndexMap<String, f64>,
    /// Period of a cycle, s.
    pub period_s: Option<f64>,
    /// The name of the oscillation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub oscillation: Option<String>,
    /// By name, SI.
    pub measures: IndexMap<String, f64>,
    /// Whether it is stable.
    pub stable: bool,
}

/// The record of what was found.
pub(crate) fn record(
    found: &ContinuationFindings,
    devices: IndexMap<String, crate::results::DeviceResult>,
) -> ContinuationResult {
    ContinuationResult {
        parameters: found
            .parameters
            .iter()
            .map(|one| one.name.clone())
            .collect(),
        devices,
        branches: found
            .branches
            .iter()
            .map(|one| branch(found, one))
            .collect(),
        regions: found.regions.as_ref().map(|regions| {
            Box::new(RegionResult {
                file: regions.file.clone(),
                areas: regions.areas().into_iter().collect(),
                cells: regions.cells.iter().map(|one| cell(found, one)).collect(),
                checks: regions.checks.clone(),
            })
        }),
        motions: found
            .motions
            .as_ref()
            .map(|own| Box::new(motions(found, own))),
        notes: found.notes.clone(),
    }
}

fn motions(found: &ContinuationFindings, own: &MotionFindings) -> MotionsResult {
    let count = own.count();
    let name = |place: &PlaceOutcome, on: usize| place.stable.get(on).map(|one| one.on.clone());
    let place = |place: &PlaceOutcome| PlaceResult {
        parameters: found
            .parameters
            .iter()
            .map(|one| one.name.clone())
            .zip(place.parameters.iter().copied())
            .collect(),
        stable: place
            .stable
            .iter()
            .enumerate()
            .map(|(index, one)| StableResult {
                on: one.on.clone(),
                solution: attractor(found, one.of, &one.point),
                reached: place
                    .motions
                    .iter()
                    .filter(|motion| motion.on == Some(index))
                    .count(),
            })
            .collect(),
        motions: place
            .motions
            .iter()
            .map(|motion| MotionResult {
                start: motion.start.clone(),
                end: motion.end.code(),
                why: motion.end.why().map(str::to_owned),
                on: motion.on.and_then(|on| name(place, on)),
                duration_s: motion.duration,
                oscillation: found.oscillation(&motion.point).map(str::to_owned),
                period_s: motion.point.period,
                measures: measures(found, &motion.point),
            })
            .collect(),
    };
    MotionsResult {
        of: own.of.clone(),
        count: count.all,
        agree: count.agree,
        elsewhere: count.elsewhere,
        open: count.open,
        file: own.file.clone(),
        at: own.places.iter().map(place).collect(),
    }
}

fn attractor(
    found: &ContinuationFindings,
    of: &'static str,
    point: &BranchPoint,
) -> AttractorResult {
    AttractorResult {
        of,
        oscillation: found.oscillation(point).map(str::to_owned),
        period_s: point.period,
        measures: measures(found, point),
    }
}

fn cell(found: &ContinuationFindings, one: &CellOutcome) -> CellResult {
    let attractor = |one: &AttractorOutcome| attractor(found, one.of, &one.point);
    let names = found.parameters.iter().map(|one| one.name.clone());
    CellResult {
        name: one.name.clone(),
        label: one.label.clone(),
        at: names.zip(one.at).collect(),
        area: one.area,
        attractors: one
            .attractors
            .as_ref()
            .map(|all| all.iter().map(attractor).collect()),
    }
}

fn parameters(found: &ContinuationFindings, point: &BranchPoint) -> IndexMap<String, f64> {
    let names = found.parameters.iter().map(|one| one.name.clone());
    names.zip(point.parameters.iter().copied()).collect()
}

fn measures(found: &ContinuationFindings, point: &BranchPoint) -> IndexMap<String, f64> {
    let names = found.measures.iter().map(|one| one.name.clone());
    names.zip(point.measures.iter().copied()).collect()
}

fn branch(found: &ContinuationFindings, one: &BranchOutcome) -> BranchResult {
    BranchResult {
        id: one.id.clone(),
        of: one.of,
        parent: one.parent.clone(),
        stop: StopResult {
            backward: one.stop[0],
            forward: one.stop[1],
        },
        file: one.file.clone(),
        special: one
            .special
            .iter()
            .map(|point| special(found, point))
            .collect(),
        at: one
            .at
            .iter()
            .map(|point| AtResult {
                parameters: parameters(found, point),
                period_s: point.period,
                oscillation: found.oscillation(point).map(str::to_owned),
                measures: measures(found, point),
                stable: point.unstable == 0,
            })
            .collect(),
    }
}

fn special(found: &ContinuationFindings, one: &SpecialPoint) -> SpecialResult {
    SpecialResult {
        label: one.label.clone(),
        kind: one.kind.clone(),
        parameters: parameters(found, &one.point),
        period_s: one.point.period,
        omega: one.omega,
        second_omega: one.second_omega,
        unstable: one.unstable,
        normal_form: one.normal_form.iter().copied().collect(),
        oscillation: found.oscillation(&one.point).map(str::to_owned),
        measures: measures(found, &one.point),
        error: one.error,
        status: if one.located { "located" } else { "unresolved" },
    }
}
