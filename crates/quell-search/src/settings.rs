//! How a search is run: starts, budgets and the numerical meaning of its words.

use crate::SearchError;

/// Settings of a search; [`Settings::for_dimension`] gives defaults.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Seed of every random stream.
    pub seed: u64,
    /// Number of independent starts. Default `8 + 2 n` for `n` variables, at most 32.
    pub starts: usize,
    /// Two feasible starts agree when their objectives differ by at most this part of the best one. Default `1e-4`.
    pub agreement: f64,
    /// Magnitude of the objective below which agreement and convergence are absolute instead of relative, for
    /// objectives whose optimum is zero. Default `0` (always relative).
    pub magnitude: f64,
    /// A point is feasible when no constraint exceeds this value. Default `1e-6`.
    pub feasibility: f64,
    /// Relative change of the objective below which a local search has converged. Default `1e-9`.
    pub convergence: f64,
    /// A bound is active when the point lies within this part of the variable's scaled range. Default `1e-6`.
    pub active_bound: f64,
    /// Most evaluations that one start may take. Default `1000 n`, at least 2000, at most 8000. Starts with gradients
    /// usually end long before.
    pub evaluations_per_start: usize,
    /// Points of the space-filling sample from which a start sets out. Default 8: small samples keep
    /// starts diverse, large ones send all of them to the widest basin.
    pub sample: usize,
    /// Local searches after each sample where gradients are available, from its best points. Default 4.
    pub descents: usize,
    /// A start with gradients repeats sample and local searches until it has taken this many evaluations; a start whose
    /// gradients are differences, until it has taken `2 n + 1` times as many. Default `40 n`.
    pub effort: usize,
    /// Every so many-th start with gradients also goes through a short CMA-ES, which sees past small basins; `0` for
    /// none. Default 8.
    pub population_every: usize,
    /// The same where gradients are differences, of functions that may jump. Default 2.
    pub population_every_differenced: usize,
    /// Step, as a part of a variable's scaled range, of the differences that stand for gradients where a smooth problem
    /// gives none; `0` for searches without gradients there. Default `1e-4`: integrations in time are accurate to some 1e-8.
    /// They are one-sided on the way and central near the end; a trust region narrower than the step has stalled.
    pub difference: f64,
    /// Pieces of the objective within this relative margin of the maximum are asked for. Default `0.5`.
    pub margin: f64,
}

impl Settings {
    /// Defaults for a problem of `dimension` variables.
    pub fn for_dimension(dimension: usize) -> Self {
        Self {
            seed: 0,
            starts: (8 + 2 * dimension).min(32),
            agreement: 1e-4,
            magnitude: 0.0,
            feasibility: 1e-6,
            convergence: 1e-9,
            active_bound: 1e-6,
            evaluations_per_start: (1000 * dimension).clamp(2000, 8000),
            sample: 8,
            descents: 4,
            effort: 40 * dimension,
            population_every: 8,
            population_every_differenced: 2,
            difference: 1e-4,
            margin: 0.5,
        }
    }

    /// Checks that every setting is in the range in which it means something.
    ///
    /// # Errors
    ///
    /// The first setting that is not, by name.
    pub fn check(&self) -> Result<(), SearchError> {
        let positive = "a number above zero and below one";
        let not_negative = "a finite number, zero or above";
        let rules = [
            ("starts", self.starts as f64, self.starts >= 1, "at least 1"),
            (
                "agreement",
                self.agreement,
                self.agreement > 0.0 && self.agreement < 1.0,
                positive,
            ),
            (
                "magnitude",
                self.magnitude,
                self.magnitude >= 0.0 && self.magnitude.is_finite(),
                not_negative,
            ),
            (
                "feasibility",
                self.feasibility,
                self.feasibility >= 0.0 && self.feasibility.is_finite(),
                not_negative,
            ),
            (
                "convergence",
                self.convergence,
                self.convergence > 0.0 && self.convergence < 1.0,
                positive,
            ),
            (
                "active_bound",
                self.active_bound,
                self.active_bound >= 0.0 && self.active_bound < 0.5,
                "between zero and one half",
            ),
            (
                "evaluations_per_start",
                self.evaluations_per_start as f64,
                self.evaluations_per_start >= 1,
                "at least 1",
            ),
            ("sample", self.sample as f64, self.sample >= 1, "at least 1"),
            (
                "difference",
                self.difference,
                self.difference >= 0.0 && self.difference < 0.5,
                "between zero and one half",
            ),
            (
                "margin",
                self.margin,
                self.margin > 0.0 && self.margin.is_finite(),
                "a finite number above zero",
            ),
        ];
        for (name, value, holds, expected) in rules {
            if !holds {
                return Err(SearchError::Setting {
                    name,
                    value,
                    expected,
                });
            }
        }
        Ok(())
    }
}
