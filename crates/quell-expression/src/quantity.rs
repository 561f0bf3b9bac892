//! Quantities: SI values with their dimensions.

use crate::Dimension;

/// A value in SI (Hz has become 2π rad/s, degrees rad) with its dimension.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantity {
    /// The SI value.
    pub value: f64,
    /// What it measures.
    pub dimension: Dimension,
}

impl Quantity {
    /// A value of a dimension.
    #[must_use]
    pub const fn new(value: f64, dimension: Dimension) -> Self {
        Self { value, dimension }
    }

    /// A plain number.
    #[must_use]
    pub const fn number(value: f64) -> Self {
        Self::new(value, Dimension::NONE)
    }
}

/// Names and what they stand for.
pub trait Scope {
    /// The quantity of a name.
    fn quantity(&self, name: &str) -> Option<Quantity>;
    /// Every name, for suggestions.
    fn names(&self) -> Vec<&str>;
}

/// A scope without names.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoNames;

impl Scope for NoNames {
    fn quantity(&self, _: &str) -> Option<Quantity> {
        None
    }

    fn names(&self) -> Vec<&str> {
        Vec::new()
    }
}

impl Scope for [(String, Quantity)] {
    fn quantity(&self, name: &str) -> Option<Quantity> {
        self.iter()
            .find(|(known, _)| known == name)
            .map(|(_, quantity)| *quantity)
    }

    fn names(&self) -> Vec<&str> {
        self.iter().map(|(name, _)| name.as_str()).collect()
    }
}

impl Scope for Vec<(String, Quantity)> {
    fn quantity(&self, name: &str) -> Option<Quantity> {
        self.as_slice().quantity(name)
    }

    fn names(&self) -> Vec<&str> {
        self.as_slice().names()
    }
}

impl<S: Scope + ?Sized> Scope for &S {
    fn quantity(&self, name: &str) -> Option<Quantity> {
        (**self).quantity(name)
    }

    fn names(&self) -> Vec<&str> {
        (**self).names()
    }
}

impl<S: std::hash::BuildHasher> Scope for std::collections::HashMap<String, Quantity, S> {
    fn quantity(&self, name: &str) -> Option<Quantity> {
        self.get(name).copied()
    }

    fn names(&self) -> Vec<&str> {
        self.keys().map(String::as_str).collect()
    }
}

impl Scope for std::collections::BTreeMap<String, Quantity> {
    fn quantity(&self, name: &str) -> Option<Quantity> {
        self.get(name).copied()
    }

    fn names(&self) -> Vec<&str> {
        self.keys().map(String::as_str).collect()
    }
}
