//! What branches, curves, diagrams and regions found.

use std::fmt::Write as _;

use super::ask::Follows;
use crate::outcome::BuiltDevice;

/// What a task that follows branches, or lets motions go, found.
#[derive(Debug, Clone)]
pub struct ContinuationFindings {
    /// What was followed.
    pub follows: Follows,
    /// `done`, or why there is nothing.
    pub status: String,
    /// The free parameters.
    pub parameters: Vec<FreeParameter>,
    /// What is taken from every solution.
    pub measures: Vec<MeasureHead>,
    /// The devices of the configuration.
    pub devices: Vec<BuiltDevice>,
    /// Names of the states.
    pub states: Vec<String>,
    /// Names of oscillations.
    pub oscillations: Vec<String>,
    /// The branches.
    pub branches: Vec<BranchOutcome>,
    /// The parts of the rectangle of a region.
    pub regions: Option<super::RegionFindings>,
    /// Motions let go from several starts.
    pub motions: Option<super::MotionFindings>,
    /// What could not be followed, and why.
    pub notes: Vec<String>,
}

/// A free parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeParameter {
    /// Its name.
    pub name: String,
    /// Its SI unit.
    pub unit: String,
    /// Its range, SI.
    pub range: (f64, f64),
}

/// What a measure is.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasureHead {
    /// Its name.
    pub name: String,
    /// The unit in which people read it.
    pub unit: String,
    /// That unit in SI.
    pub factor: f64,
}

/// A branch or curve.
#[derive(Debug, Clone)]
pub struct BranchOutcome {
    /// `E1`, `C1`, `K1` …: of equilibria, cycles, special points.
    pub id: String,
    /// `equilibrium`, `cycle`, or the code of the special points that the curve consists of.
    pub of: &'static str,
    /// The labelled point that it was born at, `E1:H1`.
    pub parent: Option<String>,
    /// Why it ends, backward and forward.
    pub stop: [&'static str; 2],
    /// The file of its points.
    pub file: String,
    /// From the backward end to the forward end.
    pub points: Vec<BranchPoint>,
    /// Special points in the same order.
    pub special: Vec<SpecialPoint>,
    /// Solutions at the values of the parameter that were asked for.
    pub at: Vec<BranchPoint>,
}

/// A solution.
#[derive(Debug, Clone, PartialEq)]
pub struct BranchPoint {
    /// Values of the free parameters, SI.
    pub parameters: Vec<f64>,
    /// Period of a cycle, s.
    pub period: Option<f64>,
    /// Frequency of critical equilibria, rad/s, or angle of critical multipliers, rad.
    pub omega: Option<f64>,
    /// Number of unstable eigenvalues or multipliers.
    pub unstable: usize,
    /// Measures, SI.
    pub measures: Vec<f64>,
    /// Which of the named oscillations a cycle is.
    pub oscillation: Option<usize>,
    /// The state of an equilibrium; empty for cycles.
    pub state: Vec<f64>,
}

/// A special point.
#[derive(Debug, Clone, PartialEq)]
pub struct SpecialPoint {
    /// `H1`: its kind and number along the branch.
    pub label: String,
    /// Code of its kind.
    pub kind: String,
    /// The solution there.
    pub point: BranchPoint,
    /// Frequency of the critical pair, rad/s; at a torus point its angle in a period, rad.
    pub omega: Option<f64>,
    /// Frequency of the second pair of a Hopf-Hopf point, rad/s.
    pub second_omega: Option<f64>,
    /// Numbers of unstable eigenvalues or multipliers before and after, along the branch.
    pub unstable: [usize; 2],
    /// Coefficients of the normal form by name.
    pub normal_form: Vec<(&'static str, f64)>,
    /// Uncertainty of the parameter, SI.
    pub error: f64,
    /// Whether it was located; otherwise something happens here that could not be told apart.
    pub located: bool,
    /// Between points `after` and `after + 1` of the branch.
    pub after: usize,
}

impl ContinuationFindings {
    /// The points of a branch as comma-separated values, special points among them by their labels; SI.
    #[must_use]
    pub fn csv(&self, branch: &BranchOutcome) -> String {
        let mut text = String::from("label");
        let quoted = |name: &str| {
            if name.contains([',', '"']) {
                format!("\"{}\"", name.replace('"', "\"\""))
            } else {
                name.to_owned()
            }
        };
        for parameter in &self.parameters {
            let _ = write!(text, ",{}", quoted(&parameter.name));
        }
        text.push_str(",period_s,omega,unstable");
        for measure in &self.measures {
            let _ = write!(text, ",{}", quoted(&measure.name));
        }
        if !self.oscillations.is_empty() {
            text.push_str(",oscillation");
        }
        let with_states = branch.points.iter().any(|point| !point.state.is_empty());
        if with_states {
            for state in &self.states {
                let _ = write!(text, ",{}", quoted(state));
            }
        }
        text.push('\n');
        let mut line = |label: &str, point: &BranchPoint| {
            text.push_str(label);
            let mut number = |value: Option<f64>| {
                text.push(',');
                if let Some(value) = value.filter(|value| value.is_finite()) {
                    let _ = write!(text, "{value:?}");
                }
            };
            for value in &point.parameters {
                number(Some(*value));
            }
            number(point.period);
            number(point.omega);
            let _ = write!(text, ",{}", point.unstable);
            let numbers = |text: &mut String, values: &[f64]| {
                for value in values {
                    text.push(',');
                    if value.is_finite() {
                        let _ = write!(text, "{value:?}");
                    }
                }
            };
            numbers(&mut text, &point.measures);
            if !self.oscillations.is_empty() {
                text.push(',');
                text.push_str(&quoted(self.oscillation(point).unwrap_or_default()));
            }
            numbers(&mut text, &point.state);
            text.push('\n');
        };
        for (index, point) in branch.points.iter().enumerate() {
            line("", point);
            for special in branch.special.iter().filter(|one| one.after == index) {
                line(&special.label, &special.point);
            }
        }
        text
    }

    /// The largest of each measure by its absolute value over all branches, SI: beside it smaller ones may be rounding.
    #[must_use]
    pub fn largest(&self) -> Vec<f64> {
        let branches = self.branches.iter();
        let points = branches.flat_map(|branch| {
            let special = branch.special.iter().map(|one| &one.point);
            branch.points.iter().chain(&branch.at).chain(special)
        });
        largest(points.map(|point| &point.measures))
    }

    /// The name of the oscillation that a point is, where it is one and there are names.
    #[must_use]
    pub fn oscillation(&self, point: &BranchPoint) -> Option<&str> {
        let name = self.oscillations.get(point.oscillation?)?;
        Some(name)
    }

    /// The files of all branches, of the cells of a region and of motions: name and text.
    pub fn files(&self) -> impl Iterator<Item = (&str, String)> {
        let cells = self.regions.iter().map(|regions| {
            let names = self.parameters.iter().map(|one| one.name.as_str());
            (regions.file.as_str(), regions.csv(names))
        });
        let motions = self.motions.iter().map(|motions| {
            let parameters = self.parameters.iter().map(|one| one.name.as_str());
            let measures = self.measures.iter().map(|one| one.name.as_str());
            (motions.file.as_str(), motions.csv(parameters, measures))
        });
        self.branches
            .iter()
            .map(|branch| (branch.file.as_str(), self.csv(branch)))
            .chain(cells)
            .chain(motions)
    }
}

/// The largest of each column by its absolute value.
pub(super) fn largest<'m>(rows: impl Iterator<Item = &'m Vec<f64>>) -> Vec<f64> {
    let mut found: Vec<f64> = Vec::new();
    for row in rows {
        found.resize(found.len().max(row.len()), 0.0);
        for (most, value) in found.iter_mut().zip(row) {
            if value.is_finite() {
                *most = most.max(value.abs());
            }
        }
    }
    found
}
