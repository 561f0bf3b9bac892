//! Branches, curves and diagrams as typed.

use indexmap::IndexMap;
use quell_continuation::Correction;
use quell_expression::{Expression, Span, Unit};

use crate::amount::Amount;
use crate::study::ConfigurationSpec;

/// What is followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Follows {
    /// Equilibria or cycles in one parameter.
    Branch,
    /// Special points in two parameters.
    Curve,
    /// Everything that can be found in one parameter.
    Diagram,
    /// A rectangle of two parameters, divided by what is stable.
    Region,
    /// Motions in time from several starts: no branch at all, but what branches say is stable is what they come to.
    Motions,
}

impl Follows {
    /// The kind of the task in the study file.
    #[must_use]
    pub const fn kind(self) -> &'static str {
        match self {
            Self::Branch => "branch",
            Self::Curve => "curve",
            Self::Diagram => "diagram",
            Self::Region => "region",
            Self::Motions => "simulate",
        }
    }
}

/// A task of kind `branch`, `curve`, `diagram`, `region` or `simulate`.
#[derive(Debug, Clone)]
pub struct ContinuationTask {
    /// What is followed.
    pub follows: Follows,
    /// Layouts and values; that of the start unless given.
    pub configuration: Option<ConfigurationSpec>,
    /// The free parameters, one or two.
    pub parameters: Vec<(String, Span)>,
    /// Ranges of free parameters, by name.
    pub ranges: IndexMap<String, ParameterRange>,
    /// Where it begins.
    pub start: BranchStart,
    /// curve: further points at which curves of the same plane begin.
    pub more: Vec<BranchStart>,
    /// Values of the first parameter at which solutions are wanted.
    pub at: Vec<Amount>,
    /// Numbers taken from every solution.
    pub measures: IndexMap<String, Measure>,
    /// By name of an oscillation the measure that is largest where it has that name.
    pub oscillations: IndexMap<String, Measure>,
    /// branch: whether cycles born at Hopf points are followed too.
    pub cycles: bool,
    /// diagram: where equilibria are sought, by coordinate, rate or state.
    pub search: IndexMap<String, ParameterRange>,
    /// How predicted points are brought onto a branch.
    pub correction: Correction,
    /// diagram: how often branches of branches are followed.
    pub depth: usize,
    /// Most points in each direction.
    pub points: usize,
    /// Estimated error that the mesh of a cycle holds, relative to its size.
    pub tolerance: f64,
    /// A branch of cycles ends beyond this period.
    pub longest_period: Option<Amount>,
    /// The period of the forcing, where the equations depend on time.
    pub period: Option<Amount>,
    /// simulate: what is let go, and where.
    pub motions: MotionsAsked,
    /// Where the task is declared.
    pub span: Span,
}

impl ContinuationTask {
    /// A task that asks for nothing yet, with what holds unless the study says otherwise.
    pub(crate) fn new(follows: Follows, span: Span) -> Self {
        Self {
            follows,
            configuration: None,
            parameters: Vec::new(),
            ranges: IndexMap::new(),
            start: BranchStart::Equilibrium,
            more: Vec::new(),
            at: Vec::new(),
            measures: IndexMap::new(),
            oscillations: IndexMap::new(),
            cycles: false,
            search: IndexMap::new(),
            correction: Correction::PseudoArclength,
            depth: 2,
            points: 400,
            tolerance: 1e-8,
            longest_period: None,
            period: None,
            motions: MotionsAsked::default(),
            span,
        }
    }

    /// Names of the tasks above that must be solved before.
    pub(crate) fn before(&self) -> impl Iterator<Item = &str> {
        let starts = std::iter::once(&self.start).chain(&self.more);
        let labels = starts.filter_map(|start| match start {
            BranchStart::Label { task, .. } => Some(task.as_str()),
            _ => None,
        });
        labels.chain(self.motions.of.as_deref())
    }
}

/// Motions in time.
#[derive(Debug, Clone, Default)]
pub struct MotionsAsked {
    /// The task above whose stable solutions the motions are compared with.
    pub of: Option<String>,
    /// Values of the parameters at which motions are let go.
    pub places: Vec<Vec<Amount>>,
    /// Where each begins.
    pub starts: MotionStarts,
    /// For how long a motion is watched at most.
    pub duration: Option<Amount>,
}

/// Where motions begin.
#[derive(Debug, Clone)]
pub enum MotionStarts {
    /// So many pushes from the equilibrium, from small to large.
    Pushed(usize),
    /// At values of coordinates, rates and states; what is not named is at rest.
    Stated(Vec<(IndexMap<String, Amount>, Span)>),
}

impl Default for MotionStarts {
    fn default() -> Self {
        Self::Pushed(4)
    }
}

/// The range of a free parameter.
#[derive(Debug, Clone)]
pub struct ParameterRange {
    /// Lower end.
    pub from: Amount,
    /// Upper end.
    pub to: Amount,
    /// Where it stands.
    pub span: Span,
}

/// Where a branch or curve begins.
#[derive(Debug, Clone)]
pub enum BranchStart {
    /// At the equilibrium near the start of runs in time.
    Equilibrium,
    /// At a labelled point of another task.
    Label {
        /// Name of the task.
        task: String,
        /// `H1`, or `C1:NS1` where several branches have the label.
        label: String,
        /// Where it stands.
        span: Span,
    },
    /// At the orbit on which a run in time ends.
    Run {
        /// Name of the run.
        run: String,
        /// Where it stands.
        span: Span,
    },
}

/// A number taken from every solution of a branch.
#[derive(Debug, Clone)]
pub struct Measure {
    /// What it is.
    pub value: Expression,
    /// The unit in which people read it.
    pub unit: Option<(Unit, Span)>,
}
