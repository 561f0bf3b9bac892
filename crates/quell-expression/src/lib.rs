//! Quantities with units, expressions with spans, and exact derivatives.
//!
//! SI inside, units at the edge: a text such as `18500 lbf/ft` or `2*zeta*sqrt(k*m)` becomes an [`Expression`], whose
//! value in a [`Scope`] of names is a [`Quantity`] in SI with its [`Dimension`] checked. Errors point at the bytes.
//!
//! Expressions that are evaluated often go another way: [`lower()`] turns them into operations of a [`Graph`] in a
//! vocabulary of [`Names`], the graph differentiates itself ([`Graph::tangent`], [`Graph::jacobian`]), and a [`Program`]
//! is compiled from it, which evaluates values and derivatives of one point or of [`LANES`] together. [`record()`] makes
//! a graph from a function in Rust.
//!
//! ```
//! use quell_expression::{Dimension, Expression, NoNames};
//! let force = Expression::parse("2 lbf + 1 N")?.evaluate(&NoNames)?;
//! assert_eq!(force.dimension, Dimension::FORCE);
//! assert!((force.value - 9.896443230521).abs() < 1e-12);
//! # Ok::<(), quell_expression::ExpressionError>(())
//! ```

mod derivative;
mod dimension;
mod elementary;
mod evaluate;
mod expression;
mod function;
mod graph;
mod lower;
mod nearest;
mod operation;
mod parser;
mod program;
mod quantity;
mod record;
mod span;
mod tape;
mod unit;
mod vector_function;

pub use dimension::Dimension;
pub use evaluate::unknown_name;
pub use expression::{BinaryOperator, ComparisonOperator, Expression, LogicalOperator, Node};
pub use function::Function;
pub use graph::{Condition, Differentiation, Graph};
pub use lower::{Lowering, Meaning, Names, Rate, lower};
pub use nearest::nearest;
pub use operation::Slot;
pub use parser::{Argument, Signature};
pub use program::{BatchWorkspace, LANES, Program, Workspace};
pub use quantity::{NoNames, Quantity, Scope};
pub use record::{Real, Recorded, Recording, record};
pub use span::{ExpressionError, Span};
pub use tape::{Tape, TapeBuilder};
pub use unit::Unit;
pub use vector_function::{CompiledFunction, Exactness, FiniteDifferences, VectorFunction};
