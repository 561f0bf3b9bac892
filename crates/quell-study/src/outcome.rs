//! What a run found, with everything that a report draws; [`crate::results`] is its stable extract.

use indexmap::IndexMap;
use quell_network::{Domain, Layout};
use serde::Serialize;

use crate::results::{CriterionDetail, Ledger, Results};
use crate::study::{Objective, Sense};

/// Everything that a run found.
#[derive(Debug, Clone)]
pub struct RunOutcome {
    /// The stable record, as written to `results.json`.
    pub results: Results,
    /// The tasks in the order of the study.
    pub tasks: Vec<TaskOutcome>,
    /// Finished pieces of work that came from the run store.
    pub restored: u64,
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
    /// What happens between the points of a sweep.
    pub events: Vec<crate::results::SweepEvent>,
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
    /// Of a `design` task with several objectives.
    Front(Box<FrontFindings>),
    /// Of a `branch`, `curve` or `diagram` task.
    Continuation(Box<crate::continuation::ContinuationFindings>),
}

/// What a design task with several objectives found.
#[derive(Debug, Clone)]
pub struct FrontFindings {
    /// The objectives, in order.
    pub objectives: Vec<Objective>,
    /// The constraints in words, in the units of the study.
    pub constraints: Vec<String>,
    /// What designs are seen beside.
    pub references: Vec<Reference>,
    /// The front of each layout, in the order of the candidates.
    pub layouts: Vec<LayoutFront>,
    /// How many layouts were tried, and up to which equivalence each was listed once.
    pub candidates: String,
    /// How the fronts were found, in words.
    pub method: String,
}

/// The front of one layout.
#[derive(Debug, Clone)]
pub struct LayoutFront {
    /// The layout.
    pub layout: String,
    /// Its designs of which none can be made better in one objective without becoming worse in another, the best of the first
    /// objective first; a single infeasible design where no values meet the constraints.
    pub points: Vec<FrontPoint>,
}

/// A point of a front.
#[derive(Debug, Clone)]
pub struct FrontPoint {
    /// The place on the front of all layouts together, from 1; none where another layout is better in everything.
    pub rank: Option<usize>,
    /// The design.
    pub design: Design,
}

impl FrontFindings {
    /// The points of the front of all layouts, the best of the first objective first.
    pub fn common(&self) -> Vec<(&LayoutFront, &FrontPoint)> {
        let mut points: Vec<(&LayoutFront, &FrontPoint)> = self
            .layouts
            .iter()
            .flat_map(|layout| layout.points.iter().map(move |point| (layout, point)))
            .filter(|(_, point)| point.rank.is_some())
            .collect();
        points.sort_by_key(|(_, point)| point.rank);
        points
    }
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
    /// The best design of each number of elements, from many to one; empty unless the task asks for it.
    pub simplified: Vec<Simplified>,
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
    /// Of a design that misses a constraint: by constraint how far it is missed, relative; 0 where it holds.
    pub violations: IndexMap<String, f64>,
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
    /// What else should be known, in words: flat directions, layouts that lie behind a bound, which constraint costs what.
    pub remarks: Vec<String>,
    /// Of a design that is a function: networks that have it.
    pub synthesis: Vec<Synthesis>,
}

/// A function that was found, with networks that have it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Synthesis {
    /// Name of the device.
    pub device: String,
    /// Coefficients of the admittance's numerator by power of s, lowest first, SI.
    pub numerator: Vec<f64>,
    /// Coefficients of its denominator.
    pub denominator: Vec<f64>,
    /// Networks, the fewest elements first.
    pub networks: Vec<RealisedNetwork>,
    /// In words: how many elements it takes, or why there is no network.
    pub status: String,
}

/// A network that has a function.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RealisedNetwork {
    /// How it was found.
    pub method: String,
    /// A layout, or a bridge with its nodes.
    pub network: String,
    /// Whether it is a layout.
    pub is_series_parallel: bool,
    /// Values of its elements, SI.
    pub values: IndexMap<String, f64>,
    /// Distance between its admittance and the function.
    pub residual: f64,
}

/// The best design of a number of elements.
#[derive(Debug, Clone)]
pub struct Simplified {
    /// How many elements it has.
    pub elements: usize,
    /// What was left out, of which layout.
    pub without: String,
    /// How many layouts of this number of elements were searched.
    pub tried: usize,
    /// The best of them.
    pub design: Design,
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
