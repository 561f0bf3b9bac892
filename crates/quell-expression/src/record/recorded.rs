//! The symbol that takes the place of a number under recording.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{RECORDINGS, Real};
use crate::evaluate::as_whole;
use crate::operation::Slot;
use crate::{Condition, Function, Graph};

/// A number of a function that is being recorded, see [`record`](crate::record()).
///
/// After the end of its recording it is not-a-number.
#[derive(Debug, Clone, Copy)]
pub struct Recorded(Kind);

#[derive(Debug, Clone, Copy)]
enum Kind {
    Number(f64),
    /// An operation of the recording of a number.
    Symbol(u64, Slot),
}

impl Recorded {
    pub(super) const fn symbol(recording: u64, slot: Slot) -> Self {
        Self(Kind::Symbol(recording, slot))
    }

    fn apply(
        operation: impl FnOnce(&mut Graph, &dyn Fn(&mut Graph, Self) -> Slot) -> Slot,
    ) -> Self {
        let recording =
            RECORDINGS.with_borrow(|recordings| recordings.last().map(|(number, _)| *number));
        match recording {
            Some(number) => Self(Kind::Symbol(number, operate(operation))),
            None => Self(Kind::Number(f64::NAN)),
        }
    }
}

/// Adds an operation to the present recording; without one the slot means nothing.
pub(super) fn operate(
    operation: impl FnOnce(&mut Graph, &dyn Fn(&mut Graph, Recorded) -> Slot) -> Slot,
) -> Slot {
    RECORDINGS.with_borrow_mut(|recordings| {
        let Some((present, graph)) = recordings.last_mut() else {
            return Slot(0);
        };
        let present = *present;
        operation(graph, &|graph, value| match value.0 {
            Kind::Symbol(recording, slot) if recording == present => slot,
            Kind::Symbol(..) => graph.constant(f64::NAN),
            Kind::Number(value) => graph.constant(value),
        })
    })
}

impl From<f64> for Recorded {
    fn from(value: f64) -> Self {
        Self(Kind::Number(value))
    }
}

impl Neg for Recorded {
    type Output = Self;

    fn neg(self) -> Self {
        if let Kind::Number(value) = self.0 {
            return Self(Kind::Number(-value));
        }
        Self::apply(|graph, slot| {
            let a = slot(graph, self);
            graph.negate(a)
        })
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $of_graph:ident, $symbol:tt) => {
        impl $trait for Recorded {
            type Output = Self;

            fn $method(self, other: Self) -> Self {
                if let (Kind::Number(a), Kind::Number(b)) = (self.0, other.0) {
                    return Self(Kind::Number(a $symbol b));
                }
                Self::apply(|graph, slot| {
                    let (a, b) = (slot(graph, self), slot(graph, other));
                    graph.$of_graph(a, b)
                })
            }
        }

        impl $trait<f64> for Recorded {
            type Output = Self;

            fn $method(self, other: f64) -> Self {
                self $symbol Self::from(other)
            }
        }

        impl $trait<Recorded> for f64 {
            type Output = Recorded;

            fn $method(self, other: Recorded) -> Recorded {
                Recorded::from(self) $symbol other
            }
        }
    };
}

operator!(Add, add, add, +);
operator!(Sub, sub, subtract, -);
operator!(Mul, mul, multiply, *);
operator!(Div, div, divide, /);

impl Real for Recorded {
    fn unary(self, function: Function) -> Self {
        Self::apply(|graph, slot| {
            let a = slot(graph, self);
            graph.unary(function, a)
        })
    }

    fn binary(self, function: Function, other: Self) -> Self {
        Self::apply(|graph, slot| {
            let (a, b) = (slot(graph, self), slot(graph, other));
            graph.binary(function, a, b)
        })
    }

    fn powf(self, exponent: Self) -> Self {
        Self::apply(|graph, slot| {
            let (a, b) = (slot(graph, self), slot(graph, exponent));
            graph.power(a, b)
        })
    }

    fn powi(self, exponent: i32) -> Self {
        match as_whole(f64::from(exponent)) {
            Some(_) => self.powf(Self::from(f64::from(exponent))),
            None => Self::from(f64::NAN),
        }
    }

    fn select(self, bound: Self, then: Self, otherwise: Self) -> Self {
        Self::apply(|graph, slot| {
            let (a, b) = (slot(graph, self), slot(graph, bound));
            let (c, d) = (slot(graph, then), slot(graph, otherwise));
            graph.choose(&Condition::LessOrEqual(a, b), c, d)
        })
    }
}
