//! What a run found, with everything that a report draws; [`crate::results`] is its stable extract.

use indexmap::IndexMap;
use quell_network::{Domain, Layout};

use crate::results::{CriterionDetail, Ledger, Results};
use crate::study::Sense;

/// Everything that a run found.
#[derive(Debug, Clone)]
pub struct RunOutcome {
    /// The stable record, as written to `results.json`.
    pub results: Results,
    /// The tasks in the order of the study.
    pub tasks: Vec<TaskOutcome>,
}

impl RunOutcome {
    /// Files that stand beside `results.json`, with their texts: the points of branches.
    pub fn files(&self) -> impl Iterator<Item = (String, String)> + '_ {
        let points = self.tasks.iter().flat_map(|task| &task.points);
        points
            .filter_map(|point| match &point.findings {
                Findings::Continuation(found) => Some(found),
                _ => None,
            })
            .flat_map(|found| found.files())
            .map(|(name, text)| (name.to_owned(), text))
    }
}

/// What one task found.
#[derive(Debug, Clone)]
pub struct TaskOutcome {
    /// Name of the task.
    pub name: String,
    /// One entry, or one for each point of the sweep.
    pub points: Vec<PointOutcome>,
}

/// What a task found at one set of parameters.
#[derive(Debug, Clone)]
pub struct PointOutcome {
    /// Swept parameters: name, SI value, SI unit; empty without a sweep.
    pub at: Vec<NamedValue>,
    /// What was found.
    pub findings: Findings,
    /// Responses over the references.
    pub plots: Vec<Plot>,
}

/// What was found.
#[derive(Debug, Clone)]
pub enum Findings {
    /// Of an `evaluate` task.
    Evaluate(Vec<Evaluated>),
    /// Of a `design` task.
    Design(Box<DesignFindings>),
    /// Of a `branch`, `curve` or `diagram` task.
    Continuation(Box<crate::continuation::ContinuationFindings>),
}

/// What a design task found.
#[derive(Debug, Clone)]
pub struct DesignFindings {
    /// Name of the criterion.
    pub objective: String,
    /// Which way is good.
    pub sense: Sense,
    /// The constraints in words, in the units of the study.
    pub constraints: Vec<String>,
    /// What designs are measured against.
    pub references: Vec<Reference>,
    /// Best first.
    pub designs: Vec<Design>,
    /// How many layouts were tried, and up to which equivalence each was listed once.
    pub candidates: String,
}

/// A configuration with its criteria.
#[derive(Debug, Clone)]
pub struct Evaluated {
    /// Name of the configuration, or its layout.
    pub name: String,
    /// The devices.
    pub devices: Vec<BuiltDevice>,
    /// Values of the criteria, SI; NaN where there is none.
    pub criteria: IndexMap<String, f64>,
    /// More on each.
    pub details: IndexMap<String, CriterionDetail>,
    /// By run in time: where the energy has gone.
    pub energy: IndexMap<String, Ledger>,
}

/// What designs are measured against.
#[derive(Debug, Clone)]
pub struct Reference {
    /// Layouts, values and criteria.
    pub configuration: Evaluated,
    /// Every constraint of the task holds.
    pub feasible: bool,
    /// Largest relative violation; 0 where feasible.
    pub violation: f64,
}

impl Reference {
    /// It has a value of the criterion `objective`, but misses a constraint.
    pub fn misses_a_constraint(&self, objective: &str) -> bool {
        let value = self.configuration.criteria.get(objective);
        !self.feasible && value.is_some_and(|value| value.is_finite())
    }
}

/// One design of a shortlist.
#[derive(Debug, Clone)]
pub struct Design {
    /// 1 is the best.
    pub rank: usize,
    /// Layouts, values and criteria.
    pub configuration: Evaluated,
    /// Value of the objective, SI.
    pub objective: f64,
    /// By reference: relative improvement, positive is better; none where the reference has no number.
    pub improvement: IndexMap<String, f64>,
    /// Every constraint holds.
    pub feasible: bool,
    /// Largest relative violation.
    pub violation: f64,
    /// Variables at a bound: `track1.dL = lower`.
    pub active_bounds: Vec<String>,
    /// Independent starts.
    pub starts: usize,
    /// Starts that agree with the best.
    pub starts_agreeing: usize,
    /// Evaluations spent.
    pub evaluations: u64,
    /// How the search ended.
    pub status: String,
}

/// A device with values.
#[derive(Debug, Clone)]
pub struct BuiltDevice {
    /// Name of the device.
    pub name: String,
    /// The domain of its layout.
    pub domain: Domain,
    /// The layout that stands in the slot, in words.
    pub designed: String,
    /// The complete layout of the device.
    pub layout: Layout,
    /// Design variables and fixed values.
    pub variables: Vec<NamedValue>,
    /// Values of the elements in the device's own domain, SI; `track1.I` for those of components.
    pub elements: Vec<NamedValue>,
}

/// A number with its name and SI unit.
#[derive(Debug, Clone)]
pub struct NamedValue {
    /// The name.
    pub name: String,
    /// The value, SI.
    pub value: f64,
    /// SI unit; empty for a pure number.
    pub unit: String,
    /// Bounds, where the value was designed.
    pub bounds: Option<(f64, f64)>,
    /// Searched on a logarithmic scale.
    pub logarithmic: bool,
}

/// What curves run over.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Over {
    /// Frequency, Hz.
    Frequency,
    /// Time, s.
    Time,
    /// Another signal, with its SI unit.
    Signal(String, String),
}

/// A response drawn over frequency, time or another signal.
#[derive(Debug, Clone)]
pub struct Plot {
    /// What it is drawn over.
    pub over: Over,
    /// What is drawn: `|Td|`.
    pub quantity: String,
    /// Its SI unit.
    pub unit: String,
    /// Whether frequency is better read on a logarithmic axis.
    pub logarithmic: bool,
    /// The curves.
    pub series: Vec<Series>,
}

/// What a curve stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// What designs are measured against.
    Reference,
    /// A design, by rank.
    Design(usize),
    /// A configuration of an `evaluate` task.
    Configuration,
}

/// A curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Its name in the legend.
    pub name: String,
    /// What it stands for.
    pub role: Role,
    /// (Hz, s or SI value of the signal that it runs over; SI value).
    pub points: Vec<(f64, f64)>,
    /// The marked peak, if it is one.
    pub peak: Option<(f64, f64)>,
}
