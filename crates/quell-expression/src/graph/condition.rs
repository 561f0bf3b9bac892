//! Conditions on values of a graph.

use crate::operation::Slot;
use crate::{ComparisonOperator, LogicalOperator};

/// What decides between two expressions, see [`Graph::choose`](crate::Graph::choose).
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Condition {
    /// a ≤ b
    LessOrEqual(Slot, Slot),
    /// a < b
    Less(Slot, Slot),
    /// a = b
    Equal(Slot, Slot),
    /// The opposite.
    Not(Box<Self>),
    /// Both.
    And(Box<Self>, Box<Self>),
    /// At least one.
    Or(Box<Self>, Box<Self>),
}

impl Condition {
    /// A comparison of two values.
    #[must_use]
    pub fn of(operator: ComparisonOperator, left: Slot, right: Slot) -> Self {
        match operator {
            ComparisonOperator::Less => Self::Less(left, right),
            ComparisonOperator::LessOrEqual => Self::LessOrEqual(left, right),
            ComparisonOperator::Greater => Self::Less(right, left),
            ComparisonOperator::GreaterOrEqual => Self::LessOrEqual(right, left),
            ComparisonOperator::Equal => Self::Equal(left, right),
            ComparisonOperator::NotEqual => Self::Equal(left, right).negated(),
        }
    }

    /// This and, or or, another.
    #[must_use]
    pub fn joined(self, operator: LogicalOperator, other: Self) -> Self {
        match operator {
            LogicalOperator::And => self.and(other),
            LogicalOperator::Or => self.or(other),
        }
    }

    /// The opposite.
    #[must_use]
    pub fn negated(self) -> Self {
        Self::Not(Box::new(self))
    }

    /// This and another.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self::And(Box::new(self), Box::new(other))
    }

    /// This or another, or both.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self::Or(Box::new(self), Box::new(other))
    }
}
