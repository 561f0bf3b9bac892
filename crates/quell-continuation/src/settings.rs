//! How a branch is followed, and how it ends.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::monitor::Monitor;

/// A flag that asks a computation to stop at its next point.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// A flag that is not raised.
    pub fn new() -> Self {
        Self::default()
    }
    /// Raises it.
    pub fn raise(&self) {
        self.0.store(true, Ordering::Relaxed);
    }
    /// Whether it is raised.
    pub fn is_raised(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Settings of a branch or curve.
///
/// Lengths of steps are in scaled arclength ‖(x / X, p / P)‖: X is the largest root mean square of the states so far (at
/// least [`state_scale`](Self::state_scale)), P the width of the range of each free parameter.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Bounds of each free parameter, the first one being the parameter of the branch. A branch ends on a bound exactly.
    pub ranges: Vec<(f64, f64)>,
    /// First step.
    pub initial_step: f64,
    /// A step shorter than this ends the branch.
    pub minimum_step: f64,
    /// No step is longer.
    pub maximum_step: f64,
    /// Most points in each direction.
    pub maximum_points: usize,
    /// Newton has converged when a correction is smaller than this, in the norm of the steps.
    pub newton_tolerance: f64,
    /// Most iterations of Newton.
    pub newton_iterations: usize,
    /// Angle between tangents of successive points that the step aims at, rad.
    pub angle: f64,
    /// Least root mean square of the states used to scale steps.
    pub state_scale: f64,
    /// Values of the first free parameter at which a solution is wanted exactly.
    pub at: Vec<f64>,
    /// Whether special points are sought.
    pub detect: bool,
    /// Shortest part of a step, relative to it, into which detection divides an ambiguous step before it reports the
    /// point as unresolved.
    pub shortest_division: f64,
    /// A branch of periodic orbits ends beyond this period.
    pub period_bound: f64,
    /// Mesh of periodic orbits.
    pub mesh: MeshSettings,
    /// How a predicted point is brought onto the branch.
    pub correction: Correction,
    /// Directions to follow.
    pub directions: Directions,
    /// Functions whose zeros are wanted.
    pub monitors: Vec<Monitor>,
    /// Raised from outside to stop.
    pub interrupt: Option<Interrupt>,
}

/// In which plane Newton brings a predicted point onto the branch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Correction {
    /// In the one across the tangent of the point before, through the predicted point (Keller 1977).
    #[default]
    PseudoArclength,
    /// In each iteration across the null vector at hand, so that in the end the correction is that of the pseudo-inverse and the
    /// point is, to first order, the nearest one (Allgower and Georg, Numerical Continuation Methods, 1990, chapter 3): another way
    /// round sharp bends, for a further solution in each iteration.
    MoorePenrose,
}

/// Which ways to follow from the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Directions {
    /// Both.
    Both,
    /// Where the first free parameter (or the amplitude, at a switch) grows at the start.
    Forward,
    /// The other way.
    Backward,
}

/// Collocation mesh of periodic orbits.
#[derive(Clone, Copy, Debug)]
pub struct MeshSettings {
    /// Degree m of the polynomials, 2 … 7.
    pub degree: usize,
    /// Number of intervals at the start.
    pub intervals: usize,
    /// Fewest and most intervals; equal to `intervals` for a fixed number.
    pub bounds: (usize, usize),
    /// Estimated collocation error that the number of intervals holds, relative to the orbit's scale.
    pub tolerance: f64,
    /// The mesh is adapted every so many points; 0 for never.
    pub every: usize,
}

impl Default for MeshSettings {
    fn default() -> Self {
        Self {
            degree: 4,
            intervals: 40,
            bounds: (20, 400),
            tolerance: 1e-8,
            every: 3,
        }
    }
}

impl MeshSettings {
    /// A mesh with a fixed number of intervals whose positions still adapt.
    pub fn fixed(intervals: usize, degree: usize) -> Self {
        Self {
            degree,
            intervals,
            bounds: (intervals, intervals),
            ..Self::default()
        }
    }
}

impl Settings {
    /// The defaults with bounds for the free parameters.
    pub fn new(ranges: &[(f64, f64)]) -> Self {
        Self {
            ranges: ranges.to_vec(),
            initial_step: 0.01,
            minimum_step: 1e-8,
            maximum_step: 0.05,
            maximum_points: 400,
            newton_tolerance: 1e-10,
            newton_iterations: 12,
            angle: 0.2,
            state_scale: 0.1,
            at: Vec::new(),
            detect: true,
            shortest_division: 1e-3,
            period_bound: f64::INFINITY,
            mesh: MeshSettings::default(),
            correction: Correction::PseudoArclength,
            directions: Directions::Both,
            monitors: Vec::new(),
            interrupt: None,
        }
    }

    pub(crate) fn range(&self, k: usize) -> (f64, f64) {
        self.ranges
            .get(k)
            .copied()
            .unwrap_or((f64::NEG_INFINITY, f64::INFINITY))
    }

    /// The scale of free parameter k.
    pub(crate) fn parameter_scale(&self, k: usize, value: f64) -> f64 {
        let (low, high) = self.range(k);
        let width = high - low;
        if width.is_finite() && width > 0.0 {
            width
        } else {
            value.abs().max(1.0)
        }
    }
}

/// Why a branch ended in one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stop {
    /// The free parameter of this index reached a bound; the last point lies on it.
    Bound(usize),
    /// The allowed number of points was computed.
    Points,
    /// Newton did not converge with the shortest step; the last point is the last good one.
    NoConvergence,
    /// The vector field or a derivative was not finite.
    NotFinite,
    /// The linear system was singular: a parameter without effect, or a whole family of solutions.
    Singular,
    /// The period exceeded its bound.
    PeriodBound,
    /// The parameter stands still while the orbit grows: a vertical family.
    DegenerateFamily,
    /// The orbit shrank to an equilibrium.
    Vanished,
    /// The branch returned to its start.
    Closed,
    /// A curve reached a point where its kind ends (Bogdanov-Takens, a strong resonance).
    EndOfKind,
    /// A monitor asked to stop.
    Monitor,
    /// The interrupt was raised.
    Interrupted,
    /// This direction was not asked for.
    NotAsked,
}

/// Why nothing could be computed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ContinuationError {
    /// Arguments do not fit the problem.
    #[error("the problem has {expected} {what}, but {found} were given")]
    Shape {
        /// What was counted.
        what: &'static str,
        /// How many the problem has.
        expected: usize,
        /// How many were given.
        found: usize,
    },
    /// Newton did not converge from the start.
    #[error(
        "Newton's iteration did not converge from the given start (the last correction was {correction:.1e})"
    )]
    NoConvergence {
        /// Norm of the last correction.
        correction: f64,
    },
    /// The field is not finite at the start.
    #[error("the vector field or a derivative is not finite at the given start")]
    NotFinite,
    /// The linearisation is singular at the start.
    #[error("the linear system is singular at the given start: has the free parameter an effect?")]
    Singular,
    /// The start is not what was said.
    #[error("{0}")]
    Start(&'static str),
}
