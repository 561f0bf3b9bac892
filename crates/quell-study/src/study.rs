//! A study as validated: names resolved, shapes checked, amounts still waiting for the parameters of a sweep.

use std::path::PathBuf;
use std::sync::Arc;

use indexmap::IndexMap;
use quell_document::{Document, Fault, Source};
use quell_expression::{Dimension, Expression, Scope, Span, Unit};
use quell_model::HostFile;
use quell_network::{Domain, Kinds, Layout};
use quell_search::Scale;

use crate::amount::Amount;
use crate::immittance::Form;

/// A study: host, what may be bolted on, what is computed, what hurts, and what is asked.
#[derive(Debug, Clone)]
pub struct Study {
    /// The title in the file.
    pub title: String,
    /// The text, for messages.
    pub source: Arc<Source>,
    /// The text as read: signals of runs are worked out when the parameters are known.
    pub(crate) document: Arc<Document>,
    /// BLAKE3 of the study's and its host's texts, matrices and samples, hexadecimal.
    pub hash: String,
    /// The folder that paths in the study are relative to.
    pub folder: PathBuf,
    /// The structure.
    pub host: HostFile,
    /// `parameters` of the study: they replace the host's.
    pub overrides: IndexMap<String, Amount>,
    /// Declared elements and components, by domain.
    pub kinds: Declared,
    /// Named sub-networks with design variables.
    pub components: IndexMap<String, Component>,
    /// Components that are positive-real functions, by name.
    pub immittances: IndexMap<String, Form>,
    /// Nonlinear elements by name.
    pub laws: IndexMap<String, ForceLawSpec>,
    /// What may be bolted on, and where.
    pub devices: IndexMap<String, Device>,
    /// Computations on the assembled system.
    pub runs: IndexMap<String, Run>,
    /// Numbers read from runs.
    pub criteria: IndexMap<String, Criterion>,
    /// What is asked.
    pub tasks: Vec<Task>,
    /// What the report shows beyond its defaults.
    pub report: ReportWishes,
}

impl Study {
    /// Domain of a device's layouts.
    pub(crate) fn domain_of(&self, slot: &Slot) -> Domain {
        self.devices
            .get(&slot.device)
            .map_or(Domain::Translational, |device| device.domain)
    }
}

/// Kinds of branch that layouts may name, for each domain in use.
#[derive(Debug, Clone, Default)]
pub struct Declared {
    /// The tables, one for each domain.
    pub tables: Vec<(Domain, Kinds)>,
}

impl Declared {
    /// The kinds of a domain.
    pub fn of(&self, domain: Domain) -> Option<&Kinds> {
        self.tables
            .iter()
            .find(|(known, _)| *known == domain)
            .map(|(_, kinds)| kinds)
    }
}

/// A named sub-network whose values follow from design variables.
#[derive(Debug, Clone)]
pub struct Component {
    /// The domain of its layout.
    pub domain: Domain,
    /// Its layout, of plain elements.
    pub layout: Layout,
    /// Value of each element, by the element's name in the layout.
    pub values: IndexMap<String, Amount>,
    /// Its design variables.
    pub variables: IndexMap<String, Bounds>,
}

/// The range of a design variable, as typed.
#[derive(Debug, Clone)]
pub struct Bounds {
    /// Smallest value.
    pub lower: Amount,
    /// Largest value.
    pub upper: Amount,
    /// Scale on which it is searched; left out: logarithmic where both ends are positive and a decade or more apart.
    pub scale: Option<Scale>,
    /// Where it stands.
    pub span: Span,
}

/// A place on the host and what stands there.
#[derive(Debug, Clone)]
pub struct Device {
    /// Name of the host's port.
    pub port: String,
    /// Where the name of the port stands.
    pub port_span: Span,
    /// The domain in which its layout is written.
    pub domain: Domain,
    /// Piston area between a hydraulic layout and the mechanical port.
    pub piston: Option<Amount>,
    /// A layout with a slot in it; left out: the device is one slot.
    pub layout: Option<Layout>,
    /// Names of the slots in the layout.
    pub slots: Vec<String>,
    /// Values of the layout's own elements.
    pub values: IndexMap<String, Amount>,
    /// Where the device is declared.
    pub span: Span,
}

/// One computation on the assembled system.
#[derive(Debug, Clone)]
pub enum Run {
    /// Response to a harmonic input over frequency.
    Frequency(Box<FrequencyRun>),
    /// Free modes.
    Modes {
        /// Only oscillatory modes count.
        oscillatory: bool,
        /// Where the run is declared.
        span: Span,
    },
    /// Motion in time.
    Transient(Box<TransientRun>),
}

impl Run {
    /// Where the run is declared.
    pub fn span(&self) -> Span {
        match self {
            Self::Frequency(run) => run.span,
            Self::Modes { span, .. } => *span,
            Self::Transient(run) => run.span,
        }
    }
}

/// Motion in time from a start until an event or a time.
#[derive(Debug, Clone)]
pub struct TransientRun {
    /// What ends it.
    pub end: Option<EndEvent>,
    /// How long it lasts at most.
    pub duration: Amount,
    /// How long it is continued beyond its end, for `beyond(…)`.
    pub beyond: Option<Amount>,
    /// Where it starts.
    pub start: StartAt,
    /// Signals of inputs that differ from the host's, by the input's name.
    pub inputs: IndexMap<String, Excitation>,
    /// Its phases, one after the other; none for a single free one.
    pub phases: Vec<PhaseSpec>,
    /// Relative tolerance of the integration.
    pub tolerance: f64,
    /// Most steps of the integration; a run that needs more has no numbers.
    pub most_steps: usize,
    /// How it is integrated.
    pub method: Integration,
    /// Where the run is declared.
    pub span: Span,
}

/// What an input is in a run in time.
#[derive(Debug, Clone)]
pub struct Excitation {
    /// Path of its table in the study.
    pub path: String,
    /// Where the input's name stands.
    pub span: Span,
}

/// Where a run in time starts.
#[derive(Debug, Clone)]
pub enum StartAt {
    /// As the host says.
    Stated,
    /// As the host says, but for these coordinates, rates and states.
    States(IndexMap<String, Amount>),
    /// In static equilibrium.
    Equilibrium,
}

/// How a run in time is integrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Integration {
    /// As the system asks for.
    Automatic,
    /// An explicit method.
    Explicit,
    /// A stiff method.
    Stiff,
    /// A stiff method for lightly damped oscillations.
    StiffOscillating,
}

/// What ends a run in time.
#[derive(Debug, Clone)]
pub struct EndEvent {
    /// The signal that goes through zero.
    pub event: Expression,
    /// Upwards, downwards, or either way.
    pub rising: Option<bool>,
    /// It counts only after this has been true.
    pub armed: Option<Expression>,
}

/// A phase of a run in time.
#[derive(Debug, Clone)]
pub struct PhaseSpec {
    /// What does not move in it.
    pub hold: Option<Expression>,
    /// What ends it.
    pub until: Option<Expression>,
    /// Where it stands.
    pub span: Span,
}

/// A nonlinear element: its force as an expression of its own x and v.
#[derive(Debug, Clone)]
pub struct ForceLawSpec {
    /// The force.
    pub force: Expression,
    /// Its parameters' defaults.
    pub parameters: IndexMap<String, Amount>,
    /// Its energy can be had back.
    pub stores: bool,
    /// Its energy is lost.
    pub dissipates: bool,
    /// Where it is declared.
    pub span: Span,
}

/// The response to a harmonic input over frequency.
#[derive(Debug, Clone)]
pub struct FrequencyRun {
    /// Name of the host's input.
    pub input: String,
    /// Where that name stands.
    pub input_span: Span,
    /// Lower and upper frequency; left out: all frequencies (norms only).
    pub band: Option<(Amount, Amount)>,
    /// One-sided spectrum of the input per Hz: an expression of `f` and parameters.
    pub spectrum: Option<Amount>,
    /// Where the run is declared.
    pub span: Span,
}

/// One number taken from a run, or from other criteria.
#[derive(Debug, Clone)]
pub struct Criterion {
    /// Name of the run; none of an expression of other criteria.
    pub run: Option<String>,
    /// A stable band, which has neither a run nor an expression.
    pub band: Option<Box<crate::band::BandSpec>>,
    /// What it is: an expression over the run.
    pub value: Expression,
    /// The unit in which people read it.
    pub unit: Option<(Unit, Span)>,
    /// Relative tolerance of the value.
    pub tolerance: f64,
    /// Over what it is taken again and again: the worst of several loads, of parts as they are made.
    pub variation: Option<Variation>,
    /// Where the value stands.
    pub span: Span,
}

/// What a criterion is taken over: every combination of parameters of the host, and for each the values of elements anywhere
/// within their tolerances.
#[derive(Debug, Clone)]
pub struct Variation {
    /// Parameters of the host with their values.
    pub over: Vec<SweepAxis>,
    /// Tolerances of values of devices.
    pub tolerances: Vec<Tolerance>,
    /// Which number of all of them it is.
    pub take: Statistic,
    /// Where it stands.
    pub span: Span,
}

/// How far a value may be from the one that is meant.
#[derive(Debug, Clone)]
pub struct Tolerance {
    /// Of which values, as `bounds` name them; none: of all.
    pub name: Option<String>,
    /// Relative, both ways.
    pub relative: f64,
    /// Where it stands.
    pub span: Span,
}

/// One number of many.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Statistic {
    /// The largest.
    Largest,
    /// The smallest.
    Smallest,
    /// Their arithmetic mean.
    Mean,
    /// Largest less smallest.
    Spread,
}

impl Statistic {
    /// The names in the study file.
    pub const NAMES: [&'static str; 4] = ["largest", "smallest", "mean", "spread"];

    pub(crate) fn from_name(name: &str) -> Option<Self> {
        [Self::Largest, Self::Smallest, Self::Mean, Self::Spread]
            .into_iter()
            .zip(Self::NAMES)
            .find_map(|(statistic, known)| (known == name).then_some(statistic))
    }
}

/// Which way is good.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sense {
    /// Small is good.
    Minimise,
    /// Large is good.
    Maximise,
}

impl Sense {
    /// 1 where small is good, -1 where large is: a number times this is the better the smaller it is.
    pub const fn sign(self) -> f64 {
        match self {
            Self::Minimise => 1.0,
            Self::Maximise => -1.0,
        }
    }
}

/// `criterion <= bound` or `criterion >= bound`.
#[derive(Debug, Clone)]
pub struct Constraint {
    /// Name of the criterion.
    pub criterion: String,
    /// [`Sense::Minimise`] for `<=`, [`Sense::Maximise`] for `>=`.
    pub sense: Sense,
    /// The bound.
    pub bound: Amount,
    /// What stands in the bound's place at a point of a sweep over it, SI.
    pub swept: Option<f64>,
}

impl Constraint {
    /// The bound, SI, for a criterion of this dimension.
    ///
    /// # Errors
    /// A bound of another dimension.
    pub fn bound(&self, scope: &dyn Scope, dimension: Dimension) -> Result<f64, Fault> {
        match self.swept {
            Some(value) => Ok(value),
            None => self.bound.value(scope, dimension),
        }
    }
}

/// What is asked of the study.
#[derive(Debug, Clone)]
pub struct Task {
    /// Its name.
    pub name: String,
    /// What is asked.
    pub kind: TaskKind,
    /// Repeated at every combination of these.
    pub sweep: Vec<SweepAxis>,
    /// Where it is declared.
    pub span: Span,
}

/// The kinds of task.
#[derive(Debug, Clone)]
pub enum TaskKind {
    /// Criteria of given configurations.
    Evaluate(IndexMap<String, ConfigurationSpec>),
    /// The best values of candidate layouts, ranked.
    Design(Box<DesignTask>),
    /// Branches of equilibria and cycles, curves of special points, diagrams.
    Continuation(Box<crate::continuation::ContinuationTask>),
}

/// A design task.
#[derive(Debug, Clone)]
pub struct DesignTask {
    /// The criterion.
    pub objective: String,
    /// Which way is good.
    pub sense: Sense,
    /// Objectives after the first: then the task asks for a front.
    pub further: Vec<Objective>,
    /// Points of the front for each layout, ends included.
    pub front_points: usize,
    /// What must hold.
    pub constraints: Vec<Constraint>,
    /// Configurations by name, or layouts designed under the same bounds.
    pub references: Vec<(String, Span)>,
    /// For each slot, the layouts to try.
    pub candidates: IndexMap<Slot, CandidateSet>,
    /// Values that are not designed.
    pub fixed: IndexMap<String, Amount>,
    /// Ranges of the values that are.
    pub bounds: IndexMap<String, Bounds>,
    /// Independent starts for each layout; left out: chosen from the number of variables.
    pub starts: Option<usize>,
    /// Starts are added until so many agree.
    pub agree: Option<Agree>,
    /// Relative feasibility tolerance.
    pub feasibility: f64,
    /// Whether the best design is made smaller, element by element.
    pub simplify: bool,
    /// Where the task's objective stands.
    pub place: Span,
}

impl DesignTask {
    /// All objectives, in order.
    pub fn objectives(&self) -> Vec<Objective> {
        let first = Objective {
            criterion: self.objective.clone(),
            sense: self.sense,
        };
        std::iter::once(first)
            .chain(self.further.iter().cloned())
            .collect()
    }
}

/// A criterion and which way it is good.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Objective {
    /// Name of the criterion.
    pub criterion: String,
    /// Which way is good.
    pub sense: Sense,
}

/// How far the effort of a search is raised.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Agree {
    /// Until so many starts agree on the best.
    pub starts: usize,
    /// But no more starts than these; left out: ten times the first ones.
    pub most: Option<usize>,
}

/// Where a layout goes: a whole device, or a placeholder in a device's layout.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Slot {
    /// Name of the device.
    pub device: String,
    /// Name of the placeholder in its layout.
    pub placeholder: Option<String>,
}

/// Layouts to try in one slot.
#[derive(Debug, Clone)]
pub enum CandidateSet {
    /// Named one by one.
    Layouts(Vec<(Layout, Span)>),
    /// All series-parallel layouts of a budget.
    Budget {
        /// What is enumerated, one entry for each number of branches.
        enumerations: Vec<quell_network::Enumeration>,
        /// Where it stands.
        span: Span,
    },
}

/// A configuration as typed: a layout for each slot, and values.
#[derive(Debug, Clone)]
pub struct ConfigurationSpec {
    /// Runs that differ from the study's in this configuration.
    pub runs: IndexMap<String, Run>,
    /// Layouts by slot; a device that is not named is left off.
    pub layouts: IndexMap<Slot, (Layout, Span)>,
    /// Values by name.
    pub values: IndexMap<String, Amount>,
    /// Where it is declared.
    pub span: Span,
}

/// What a sweep moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Swept {
    /// A parameter of the host.
    Parameter,
    /// The bound of the task's constraint on a criterion.
    Bound,
    /// A value that the configurations, or `fixed` of a design, give.
    Value,
}

/// One swept parameter or bound.
#[derive(Debug, Clone)]
pub struct SweepAxis {
    /// The host's parameter, or the criterion that the constraint is on.
    pub name: String,
    /// Which of the two.
    pub what: Swept,
    /// Where its name stands.
    pub span: Span,
    /// Its values.
    pub values: SweepValues,
}

/// The values of a swept parameter or bound.
#[derive(Debug, Clone)]
pub enum SweepValues {
    /// From, to, number of points.
    Range(Box<SweepRange>),
    /// One by one.
    List(Vec<Amount>),
}

impl SweepValues {
    /// How many there are.
    pub fn count(&self) -> usize {
        match self {
            Self::Range(range) => range.points,
            Self::List(values) => values.len(),
        }
    }
}

/// Values from an end to another.
#[derive(Debug, Clone)]
pub struct SweepRange {
    /// First value.
    pub from: Amount,
    /// Last value.
    pub to: Amount,
    /// Number of points, at least 2.
    pub points: usize,
    /// Spacing.
    pub scale: Scale,
}

/// What the report shows beyond its defaults.
#[derive(Debug, Clone)]
pub struct ReportWishes {
    /// How many designs of a shortlist are printed and drawn large.
    pub shortlist: usize,
    /// Words above the results.
    pub note: Option<String>,
}
