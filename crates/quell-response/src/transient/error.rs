//! What can be wrong with a simulation before it begins.

/// A simulation that cannot begin. What goes wrong on the way is a status of the trajectory, not an error.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TransientError {
    /// A system without states.
    #[error("the system has no states, so nothing moves")]
    NoStates,
    /// The start has a wrong number of states.
    #[error("{found} start values were given for a system of {expected} states")]
    StartCount {
        /// States of the system.
        expected: usize,
        /// Values given.
        found: usize,
    },
    /// A start value is infinite or not a number.
    #[error("the start value of state {state} is `{value}`; a run starts from finite values")]
    StartValue {
        /// Index of the state.
        state: usize,
        /// Its value.
        value: f64,
    },
    /// The span of time is empty, backward or not finite.
    #[error("a run from {from} s to {to} s is empty; its end must be finite and after its start")]
    Span {
        /// Start, s.
        from: f64,
        /// End, s.
        to: f64,
    },
    /// An event or its arming condition reads a signal that does not exist.
    #[error("event {event} reads signal {signal}, but the system has {signals} signals")]
    Signal {
        /// Index of the event.
        event: usize,
        /// Index of the signal.
        signal: usize,
        /// Number of signals.
        signals: usize,
    },
    /// A setting outside of its range.
    #[error("setting `{name}` is `{value}`; it must be {range}")]
    Setting {
        /// The setting.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        range: &'static str,
    },
    /// Absolute tolerances for a wrong number of states.
    #[error("{found} absolute tolerances were given for a system of {expected} states")]
    ToleranceCount {
        /// States of the system.
        expected: usize,
        /// Tolerances given.
        found: usize,
    },
}
