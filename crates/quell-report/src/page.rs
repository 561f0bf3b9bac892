//! What a report says, as plain data.
//!
//! Every number is given in the unit that is shown with it. Texts are plain; the report escapes them.

use quell_network::Layout;

use crate::layout::Annotations;
use crate::number::{significant, unit};
use crate::plot::Plot;
use crate::schematic::{Part, Schematic, Terminal};

/// A whole report.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Page {
    /// The study's title.
    pub title: String,
    /// One line under the title.
    pub subtitle: String,
    /// The run: study hash, version, seed, threads, time, evaluations.
    pub facts: Vec<Fact>,
    /// The problem in words.
    pub problem: Problem,
    /// The tasks in the study's order.
    pub tasks: Vec<TaskSection>,
    /// What several tasks found, side by side.
    pub comparisons: Vec<Plot>,
}

/// A term and what it is.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Fact {
    /// The term, such as `Seed`.
    pub term: String,
    /// What it is.
    pub text: String,
}

impl Fact {
    /// A term and what it is.
    pub fn new(term: impl Into<String>, text: impl Into<String>) -> Self {
        Self {
            term: term.into(),
            text: text.into(),
        }
    }
}

/// The problem in words.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Problem {
    /// What the study is about.
    pub paragraphs: Vec<String>,
    /// Host, excitation, band, devices.
    pub facts: Vec<Fact>,
    /// What is computed of every configuration.
    pub criteria: Vec<CriterionRow>,
    /// Parameters of the host with their values.
    pub parameters: Vec<Parameter>,
    /// What is varied, between which bounds.
    pub bounds: Vec<BoundRow>,
    /// Constraints as the study states them.
    pub constraints: Vec<String>,
}

/// A criterion of the study.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct CriterionRow {
    /// Its name.
    pub name: String,
    /// Its expression or meaning.
    pub meaning: String,
    /// Its unit; empty if it has none.
    pub unit: String,
}

/// A parameter of the host.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: Quantity,
}

/// A design variable's bounds, as a row of the table.
#[derive(Debug, Clone, PartialEq)]
pub struct BoundRow {
    /// The variable, such as `tube.dL`.
    pub variable: String,
    /// Its bounds.
    pub bounds: Bounds,
    /// The unit of both; empty if there is none.
    pub unit: String,
}

/// A number with the unit it is shown in.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Quantity {
    /// The number.
    pub value: f64,
    /// The unit; empty if there is none.
    pub unit: String,
}

impl Quantity {
    /// A number with its unit.
    pub fn new(value: f64, unit: impl Into<String>) -> Self {
        Self {
            value,
            unit: unit.into(),
        }
    }
}

/// The interval that a design variable may take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Lower bound.
    pub lower: f64,
    /// Upper bound.
    pub upper: f64,
    /// Searched on a logarithmic scale.
    pub logarithmic: bool,
}

impl Bounds {
    /// Where `value` lies between the bounds, from 0 to 1 on the scale of the search.
    pub fn position(&self, value: f64) -> Option<f64> {
        let scale = |x: f64| if self.logarithmic { x.ln() } else { x };
        let position = (scale(value) - scale(self.lower)) / (scale(self.upper) - scale(self.lower));
        position.is_finite().then(|| position.clamp(0.0, 1.0))
    }

    /// The bound that `value` lies nearer to.
    pub fn nearer(&self, value: f64) -> Side {
        if self.position(value).is_some_and(|position| position < 0.5) {
            Side::Lower
        } else {
            Side::Upper
        }
    }
}

/// One of two bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The lower bound.
    Lower,
    /// The upper bound.
    Upper,
}

/// The results of one task.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TaskSection {
    /// The task's name, unique in the study.
    pub name: String,
    /// What the task asks for.
    pub kind: TaskKind,
    /// The task in words.
    pub words: Vec<String>,
    /// How it ended if anything but well, such as `infeasible`.
    pub status: Option<String>,
    /// The criteria shown of every configuration and design, in the order of their values.
    pub criteria: Vec<CriterionColumn>,
    /// References of a design task, in the order of the designs' improvements.
    pub references: Vec<ReferenceRow>,
    /// Designs, best first.
    pub designs: Vec<Design>,
    /// The best design of each number of elements, whose rank is that number.
    pub smaller: Vec<Design>,
    /// Evaluated configurations.
    pub configurations: Vec<Configuration>,
    /// Points of a sweep, each with its own results.
    pub sweep: Vec<SweepPoint>,
    /// Of a task with several objectives: the front of all layouts, from one end to the other.
    pub front: Vec<Design>,
    /// Responses, or branches.
    pub plots: Vec<Plot>,
    /// Special points of branches.
    pub points: Option<PointTable>,
}

/// Special points of branches, as a table.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct PointTable {
    /// What was found, in a few words.
    pub found: String,
    /// What stands in each column.
    pub heading: Vec<String>,
    /// The rows, a cell for each column.
    pub rows: Vec<Vec<String>>,
}

/// What a task asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TaskKind {
    /// The criteria of given configurations.
    #[default]
    Evaluate,
    /// The best values, and the best layout.
    Design,
    /// A branch of equilibria or cycles.
    Branch,
    /// A curve of special points.
    Curve,
    /// Every branch that can be found.
    Diagram,
    /// A rectangle of two parameters, divided by what is stable.
    Region,
    /// Motions in time from several starts.
    Simulate,
}

impl TaskKind {
    /// The word in the study file.
    pub(crate) const fn word(self) -> &'static str {
        match self {
            Self::Evaluate => "evaluate",
            Self::Design => "design",
            Self::Branch => "branch",
            Self::Curve => "curve",
            Self::Diagram => "diagram",
            Self::Region => "region",
            Self::Simulate => "simulate",
        }
    }
}

/// A criterion as a column of results.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct CriterionColumn {
    /// Its name.
    pub name: String,
    /// The unit of its values; empty if there is none.
    pub unit: String,
    /// Its role, such as `minimised` or `≤ 6380.3 lbf`; empty if it is only reported.
    pub role: String,
}

/// A criterion's value.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CriterionValue {
    /// The value in the column's unit; not a number where there is none.
    pub value: f64,
    /// Where and how surely, such as `at 18.71 Hz` or `certified to 1e-6`.
    pub note: String,
    /// Whether it breaks a constraint.
    pub violated: bool,
}

/// A reference that designs are compared with.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ReferenceRow {
    /// Its name.
    pub name: String,
    /// What it is.
    pub words: String,
    /// Its criteria, one for each column.
    pub criteria: Vec<CriterionValue>,
    /// Whether it misses a constraint that designs must meet.
    pub infeasible: bool,
}

/// One device of a configuration.
#[derive(Debug, Clone, PartialEq)]
pub struct Device {
    /// The device's name in the study.
    pub name: String,
    /// The layout as it is written.
    pub layout: String,
    /// The layout as it is drawn.
    pub schematic: Schematic,
    /// Its values in order.
    pub values: Vec<DesignValue>,
}

impl Device {
    /// A device drawn from its layout, its values written beside the symbols with four significant digits.
    ///
    /// `known` gives what components and placeholders consist of; values already in it are kept before the device's own.
    pub fn drawn(
        name: impl Into<String>,
        layout: &Layout,
        values: Vec<DesignValue>,
        known: &Annotations,
        head: Terminal,
        tail: Terminal,
    ) -> Self {
        let mut annotations = known.clone();
        annotations.values.extend(values.iter().map(|value| {
            let number = significant(value.value.value, 4);
            let text = if value.value.unit.is_empty() {
                number
            } else {
                format!("{number} {}", unit(&value.value.unit))
            };
            (value.name.clone(), text)
        }));
        Self {
            name: name.into(),
            layout: layout.to_string(),
            schematic: Schematic {
                part: Part::from_layout(layout, &annotations),
                head,
                tail,
            },
            values,
        }
    }
}

/// A value of a configuration.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DesignValue {
    /// Its name, such as `k1` or `tube1.dL`.
    pub name: String,
    /// The value.
    pub value: Quantity,
    /// Its bounds, if it was searched.
    pub bounds: Option<Bounds>,
    /// The bound at which it lies, if any.
    pub active: Option<Side>,
}

/// A designed configuration.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Design {
    /// Its place in the shortlist, from 1.
    pub rank: usize,
    /// Its devices.
    pub devices: Vec<Device>,
    /// The objective.
    pub objective: Quantity,
    /// Its criteria, one for each of the task's columns.
    pub criteria: Vec<CriterionValue>,
    /// Improvement on each reference in per cent, positive for better.
    pub improvements: Vec<f64>,
    /// Independent starts of the search.
    pub starts: usize,
    /// Those that ended within the stated tolerance of the best.
    pub starts_agreeing: usize,
    /// Evaluations of candidates.
    pub evaluations: u64,
    /// Whether every constraint is met.
    pub feasible: bool,
    /// The largest relative violation of a constraint, in per cent.
    pub violation: f64,
    /// What the certified objective is worth, such as `certified within 2.1e-7`.
    pub certificate: String,
    /// What else should be known, in words.
    pub remarks: Vec<String>,
}

/// An evaluated configuration.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Configuration {
    /// Its name.
    pub name: String,
    /// Its devices.
    pub devices: Vec<Device>,
    /// Its criteria, one for each of the task's columns.
    pub criteria: Vec<CriterionValue>,
    /// Where the energy went, by run in time.
    pub energy: Vec<EnergyBars>,
}

/// Where the energy of a run in time went.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EnergyBars {
    /// The run.
    pub run: String,
    /// Kinetic energy of the host at the start, J.
    pub start: f64,
    /// What became of it, J; their sum is the start.
    pub parts: Vec<EnergyPart>,
    /// What is missing in the balance, relative.
    pub error: f64,
}

/// A part of the energy.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EnergyPart {
    /// Where it is.
    pub name: String,
    /// `host`, `potential`, `kinetic`, `dissipated` or `other`.
    pub kind: String,
    /// J.
    pub energy: f64,
}

/// A point of a sweep.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SweepPoint {
    /// The swept parameters and their values.
    pub at: Vec<Parameter>,
    /// Designs at this point, best first.
    pub designs: Vec<Design>,
    /// Configurations evaluated at this point.
    pub configurations: Vec<Configuration>,
}
