//! What can be wrong with a search before it starts.

use thiserror::Error;

/// Why a variable or a setting is refused.
///
/// A search itself never fails with an error: whatever happens is a [`Status`](crate::Status) of its outcome.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SearchError {
    /// A bound is missing, infinite or not a number.
    #[error(
        "variable `{name}` has the bounds `{lower}` and `{upper}`, and both must be finite numbers"
    )]
    UnboundedVariable {
        /// The variable's name.
        name: String,
        /// Lower bound as given.
        lower: f64,
        /// Upper bound as given.
        upper: f64,
    },
    /// The bounds are in the wrong order.
    #[error(
        "variable `{name}` has its lower bound `{lower}` above its upper bound `{upper}`; exchange them"
    )]
    ReversedBounds {
        /// The variable's name.
        name: String,
        /// Lower bound as given.
        lower: f64,
        /// Upper bound as given.
        upper: f64,
    },
    /// Both bounds are the same number, so there is nothing to search.
    #[error(
        "variable `{name}` has both bounds at `{value}`, so it cannot vary; give it as a fixed value instead"
    )]
    FixedVariable {
        /// The variable's name.
        name: String,
        /// The common value of both bounds.
        value: f64,
    },
    /// A logarithmic scale cannot reach zero or below.
    #[error(
        "variable `{name}` is on a logarithmic scale but its lower bound is `{lower}`; use a bound above zero or a linear scale"
    )]
    LogarithmOfBound {
        /// The variable's name.
        name: String,
        /// Lower bound as given.
        lower: f64,
    },
    /// A setting is outside the range in which it means something.
    #[error("search setting `{name}` is `{value}`, and it must be {expected}")]
    Setting {
        /// The setting's name.
        name: &'static str,
        /// Its value as given.
        value: f64,
        /// What would be accepted, in words.
        expected: &'static str,
    },
}
