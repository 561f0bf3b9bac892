//! What names mean to [`Lowering`](super::Lowering).

use crate::{Dimension, Expression, ExpressionError, Graph, Quantity, Signature, Slot};

/// What a name stands for.
#[derive(Debug, Clone, Copy)]
pub enum Meaning<'a> {
    /// An input of the graph: a coordinate, a state, a parameter, time.
    Input(usize, Dimension),
    /// An expression of the graph.
    Value(Slot, Dimension),
    /// A number.
    Constant(Quantity),
    /// Another expression, with the same names.
    Definition(&'a Expression),
    /// A function; its body sees its arguments before other names.
    Function(&'a Signature, &'a Expression),
}

/// How an input moves in time.
#[derive(Debug, Clone, PartialEq)]
pub enum Rate {
    /// At so much a second: 0 for a parameter, 1 for time itself.
    Constant(f64),
    /// As another input says: q' for q.
    Input(usize),
    /// As an expression says.
    Value(Slot),
    /// Nothing says how; the words name what is missing, such as "the third derivative of `z1`".
    Unknown(String),
}

/// A vocabulary for expressions that become operations of a graph.
pub trait Names {
    /// What a name means.
    fn resolve(&self, name: &str) -> Option<Meaning<'_>>;

    /// Every name, for suggestions.
    fn names(&self) -> Vec<&str>;

    /// The time derivative of an input.
    fn rate(&self, input: usize) -> Rate;

    /// The present value of an input that is a parameter. It is asked for where a quantity is raised to the power of a
    /// parameter, whose value decides the unit.
    fn present(&self, input: usize) -> Option<f64> {
        let _ = input;
        None
    }

    /// Whether all is plain numbers: then no dimension is checked.
    fn dimensionless(&self) -> bool {
        false
    }

    /// The value of a call whose arguments are not expressions, such as the force of a named part; none where it is no
    /// such call. Goes before [`Self::resolve`] and the functions of the language.
    ///
    /// # Errors
    /// In words, at the argument at fault.
    fn call(
        &self,
        graph: &mut Graph,
        function: &str,
        arguments: &[Expression],
    ) -> Option<Result<(Slot, Dimension), ExpressionError>> {
        let _ = (graph, function, arguments);
        None
    }

    /// Whether a definition or function stands in another text than the expressions that use it. What is wrong within
    /// is then shown where it is used.
    fn elsewhere(&self, name: &str) -> bool {
        let _ = name;
        false
    }
}
