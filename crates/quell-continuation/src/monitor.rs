//! Functions of the user's that are watched along a branch.

use std::fmt;
use std::sync::Arc;

/// What a monitor sees of a solution.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// The state of an equilibrium, or the states at the nodes of an orbit one after the other.
    pub states: &'a [f64],
    /// Number of states.
    pub dimension: usize,
    /// All parameters.
    pub parameters: &'a [f64],
    /// Period of an orbit.
    pub period: Option<f64>,
}

type Watch = dyn Fn(&View<'_>) -> f64 + Send + Sync;

/// A smooth function whose zeros are located and reported as [`Kind::Monitor`](crate::Kind::Monitor).
#[derive(Clone)]
pub struct Monitor {
    watch: Arc<Watch>,
    /// Whether its first zero ends the branch.
    pub stops: bool,
}

impl Monitor {
    /// Watches a function.
    pub fn new(watch: impl Fn(&View<'_>) -> f64 + Send + Sync + 'static) -> Self {
        Self {
            watch: Arc::new(watch),
            stops: false,
        }
    }

    /// Ends the branch at its first zero.
    #[must_use]
    pub fn stopping(mut self) -> Self {
        self.stops = true;
        self
    }

    pub(crate) fn value(&self, view: &View<'_>) -> f64 {
        (self.watch)(view)
    }
}

impl fmt::Debug for Monitor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Monitor")
            .field("stops", &self.stops)
            .finish_non_exhaustive()
    }
}
