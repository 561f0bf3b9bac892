//! `results.json`: the stable, documented record of a run.
//!
//! Every number is SI (rad, rad/s; frequencies under keys that end in `_hz`); `unit` is that SI unit.
//! A number that could not be had is `null`, and the `status` beside it says why.

use indexmap::IndexMap;
use serde::Serialize;

use crate::outcome::Synthesis;

/// The version of this format; it changes only when a reader of the old one would be misled.
pub const FORMAT: u32 = 1;

/// The whole of `results.json`.
#[derive(Debug, Clone, Serialize)]
pub struct Results {
    /// Version of the format, [`FORMAT`].
    pub format: u32,
    /// Which study it was.
    pub study: StudyFacts,
    /// What computed it.
    pub engine: EngineFacts,
    /// Results by task name, in the order of the study.
    pub tasks: IndexMap<String, TaskResult>,
}

/// Which study was run.
#[derive(Debug, Clone, Serialize)]
pub struct StudyFacts {
    /// The title in the file.
    pub title: String,
    /// BLAKE3 of everything that determines the results: study, host and matrix files.
    pub hash: String,
}

/// What computed the results.
#[derive(Debug, Clone, Serialize)]
pub struct EngineFacts {
    /// Version of Quell.
    pub version: String,
    /// Seed of the random streams.
    pub seed: u64,
    /// Threads used; the designs do not depend on it.
    pub threads: usize,
    /// Wall-clock time, s.
    pub wall_seconds: f64,
    /// Evaluations of candidates, all tasks together.
    pub evaluations: u64,
}

/// The result of one task.
#[derive(Debug, Clone, Serialize)]
pub struct TaskResult {
    /// `evaluate`, `design`, `branch`, `curve`, `diagram` or `region`.
    pub kind: &'static str,
    /// `done`, `infeasible` where no design meets the constraints, or why nothing was found.
    pub status: String,
    /// What happens between the points of a sweep.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub events: Vec<SweepEvent>,
    /// What the task found; with a sweep, one for each point.
    #[serde(flatten)]
    pub body: TaskBody,
}

/// Something that happens between two points of a sweep.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SweepEvent {
    /// What is swept.
    pub parameter: String,
    /// The value at which it happens, SI.
    pub value: f64,
    /// The configuration that it happens to.
    pub configuration: String,
    /// The criterion.
    pub criterion: String,
    /// What happens as the value grows: `island born`, `island gone`, `band closed`, `band opened`,
    /// `another limit` (another mode takes over an end).
    pub what: &'static str,
    /// Where, in words.
    pub place: String,
}

/// With or without a sweep.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
pub enum TaskBody {
    /// No sweep.
    Single(TaskFindings),
    /// One entry for each point of the sweep.
    Sweep {
        /// The points, in the order of the sweep.
        points: Vec<SweepPoint>,
    },
}

/// One point of a sweep.
#[derive(Debug, Clone, Serialize)]
pub struct SweepPoint {
    /// The swept parameters' values, SI.
    pub at: IndexMap<String, f64>,
    /// `done` or `infeasible`.
    pub status: String,
    /// What the task found there.
    #[serde(flatten)]
    pub findings: TaskFindings,
}

/// What a task found at one set of parameters.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
pub enum TaskFindings {
    /// Of an `evaluate` task.
    Evaluate {
        /// By name of configuration.
        configurations: IndexMap<String, ConfigurationResult>,
    },
    /// Of a `design` task.
    Design {
        /// By name of the reference.
        references: IndexMap<String, ReferenceResult>,
        /// Best first.
        designs: Vec<DesignResult>,
        /// The best design of each number of elements, from many to one.
        #[serde(skip_serializing_if = "Vec::is_empty")]
        simplified: Vec<SimplifiedResult>,
    },
    /// Of a `design` task with several objectives.
    Front {
        /// The objectives, in order.
        objectives: Vec<ObjectiveResult>,
        /// How the fronts were found.
        method: String,
        /// By name of the reference.
        references: IndexMap<String, ReferenceResult>,
        /// The front of each layout.
        fronts: Vec<LayoutFrontResult>,
    },
    /// Of a `branch`, `curve` or `diagram` task.
    Continuation(crate::continuation::ContinuationResult),
}

/// A device as it was built.
#[derive(Debug, Clone, Serialize, PartialEq)]
pub struct DeviceResult {
    /// The layout that the study asked for or the search found, in the device's own domain.
    pub layout: String,
    /// The complete layout of the device: differs where the layout stands in a slot of a fixed one.
    pub device_layout: String,
    /// Values by name: design variables as the study calls them, and elements.
    pub values: IndexMap<String, f64>,
}

/// One evaluated configuration.
#[derive(Debug, Clone, Serialize, PartialEq)]
pub struct ConfigurationResult {
    /// By device name.
    pub devices: IndexMap<String, DeviceResult>,
    /// By criterion name.
    pub criteria: IndexMap<String, f64>,
    /// More on each criterion.
    pub details: IndexMap<String, CriterionDetail>,
    /// By run in time: where the energy has gone.
    #[serde(skip_serializing_if = "IndexMap::is_empty")]
    pub energy: IndexMap<String, Ledger>,
}

/// Where the energy has gone in a run in time, J.
///
/// ```text
/// kinetic_end - kinetic_start = host - Σ_ports given,   Σ_ports received = Σ_elements
/// ```
#[derive(Debug, Clone, Serialize, PartialEq)]
pub struct Ledger {
    /// ½ q'ᵀ M q' of the host at the start.
    pub kinetic_start: f64,
    /// The same at the end.
    pub kinetic_end: f64,
    /// Work of all forces of the host other than devices': gravity, its own springs and dampers, inputs.
    pub host: f64,
    /// What of that is there only because of the inputs.
    pub inputs: f64,
    /// By port.
    pub ports: IndexMap<String, PortEnergy>,
    /// By element, `device.element`.
    pub elements: IndexMap<String, ElementEnergy>,
    /// What is missing in the balance, over its largest entry.
    pub error: f64,
}

/// Work at a port, J.
#[derive(Debug, Clone, Copy, Serialize, PartialEq)]
pub struct PortEnergy {
    /// Work that the device's force takes from the coordinates.
    pub given: f64,
    /// Work ∫F dx that the device receives.
    pub received: f64,
    /// Their difference: zero but for rounding where the force acts by virtual work; where the host's equations place a named
    /// force, what that convention loses.
    pub mismatch: f64,
}

/// What an element took, J.
#[derive(Debug, Clone, Copy, Serialize, PartialEq)]
pub struct ElementEnergy {
    /// `potential`, `kinetic`, `dissipated`, or `other` for a nonlinear element that says neither.
    pub kind: &'static str,
    /// ∫F dx since the start of the run.
    pub energy: f64,
}

/// More on one value of a criterion.
#[derive(Debug, Clone, Serialize, PartialEq)]
pub struct CriterionDetail {
    /// SI unit of the value.
    pub unit: String,
    /// Where the value is taken, Hz, for a peak over frequency.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_hz: Option<f64>,
    /// When the value is taken, s, for one read at a moment of a run in time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_s: Option<f64>,
    /// The relative tolerance that the value is known to.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub achieved_tolerance: Option<f64>,
    /// Of a criterion that is taken over parameters or tolerances: of how many points, and at which of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub taken: Option<String>,
    /// All stable bands, where the value is of one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bands: Vec<crate::band::BandResult>,
    /// `certified`, `computed`, or why there is no number.
    pub status: String,
}

impl CriterionDetail {
    /// Of a criterion without a value.
    pub(crate) fn absent(why: &str) -> Self {
        Self {
            unit: String::new(),
            at_hz: None,
            at_s: None,
            achieved_tolerance: None,
            taken: None,
            bands: Vec::new(),
            status: why.to_owned(),
        }
    }
}

/// What designs are measured against.
#[derive(Debug, Clone, Serialize)]
pub struct ReferenceResult {
    /// Layouts, values and criteria.
    #[serde(flatten)]
    pub configuration: ConfigurationResult,
    /// True where every constraint of the task holds within the feasibility tolerance.
    pub feasible: bool,
    /// Largest relative violation of a constraint; 0 where feasible.
    pub violation: f64,
}

/// One design of a shortlist.
#[derive(Debug, Clone, Serialize)]
pub struct DesignResult {
    /// 1 is the best.
    pub rank: usize,
    /// By device name.
    pub devices: IndexMap<String, DeviceResult>,
    /// Value of the criterion that was minimised or maximised.
    pub objective: f64,
    /// By criterion name.
    pub criteria: IndexMap<String, f64>,
    /// More on each criterion.
    pub details: IndexMap<String, CriterionDetail>,
    /// By name of the reference: the relative improvement of the objective, positive is better.
    pub improvement: IndexMap<String, f64>,
    /// True where every constraint holds within the feasibility tolerance.
    pub feasible: bool,
    /// Largest relative violation of a constraint; 0 where feasible.
    pub violation: f64,
    /// Where a constraint is missed: how far each is, by constraint; 0 for those that hold.
    #[serde(skip_serializing_if = "IndexMap::is_empty")]
    pub violations: IndexMap<String, f64>,
    /// Names of the variables that stand at a bound, with the side: `track1.dL = lower`.
    pub active_bounds: Vec<String>,
    /// Independent starts of the search.
    pub starts: usize,
    /// How many of them came within 1e-4 relative of the best objective.
    pub starts_agreeing: usize,
    /// Evaluations spent on this layout.
    pub evaluations: u64,
    /// How the search ended, in words.
    pub status: String,
    /// What else should be known, in words: values that hardly matter, layouts that lie behind a bound.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub remarks: Vec<String>,
    /// Of a design that is a function: the function, and networks that have it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub synthesis: Vec<Synthesis>,
}

/// An objective of a task that has several.
#[derive(Debug, Clone, Serialize)]
pub struct ObjectiveResult {
    /// Name of the criterion.
    pub criterion: String,
    /// `minimise` or `maximise`.
    pub sense: &'static str,
}

/// The front of one layout.
#[derive(Debug, Clone, Serialize)]
pub struct LayoutFrontResult {
    /// The layout.
    pub layout: String,
    /// Its points, the best of the first objective first. `rank` is the place on the front of all layouts together, 0 for a
    /// point that a design of another layout beats in every objective; `objective` is the criterion that was searched to
    /// find the point.
    pub points: Vec<DesignResult>,
}

/// The best design of a number of elements.
#[derive(Debug, Clone, Serialize)]
pub struct SimplifiedResult {
    /// How many elements it has.
    pub elements: usize,
    /// What was left out, of which layout.
    pub without: String,
    /// How many layouts of this number of elements were searched.
    pub tried: usize,
    /// The best of them.
    #[serde(flatten)]
    pub design: DesignResult,
}
