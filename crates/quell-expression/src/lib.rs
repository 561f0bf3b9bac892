//! x
/// placeholder
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dimension;
