//! What the names of a host written as equations stand for.

/// Definitions and functions of a host.
#[derive(Debug, Clone, Default)]
pub(crate) struct Vocabulary {}
