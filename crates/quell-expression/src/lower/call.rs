//! Calls: functions of the language, of the user, and the two that differentiate and hold.

use super::{Locals, Lowered, Lowering, Meaning};
use crate::evaluate::look_up_among;
use crate::{
    Differentiation, Dimension, Expression, ExpressionError, Function, Graph, Signature, Slot, Span,
};

impl Lowering<'_> {
    pub(super) fn call(
        &mut self,
        graph: &mut Graph,
        (name, span): (&str, Span),
        arguments: &[Expression],
        whole: &Expression,
        locals: Locals<'_>,
    ) -> Result<Lowered, ExpressionError> {
        if let Some(special) = self.names.call(graph, name, arguments) {
            return special.map(|(slot, dimension)| Lowered::new(slot, dimension));
        }
        if let Some(Meaning::Function(signature, body)) = self.names.resolve(name) {
            return self.expand(graph, (signature, body), span, arguments, whole, locals);
        }
        match (name, arguments) {
            ("hold", [one]) => {
                let lowered = self.expression(graph, one, locals)?;
                return Ok(Lowered {
                    slot: graph.hold(lowered.slot),
                    ..lowered
                });
            }
            ("d", [of, along]) => return self.partial(graph, of, along, locals),
            ("hold" | "d", _) => {
                let takes = if name == "d" {
                    "two arguments, what is differentiated and along what"
                } else {
                    "one argument"
                };
                let words = format!("`{name}` takes {takes}, found {}", arguments.len());
                return Err(ExpressionError::new(span, words));
            }
            _ => {}
        }
        let others = self
            .names
            .names()
            .into_iter()
            .filter(|other| matches!(self.names.resolve(other), Some(Meaning::Function(..))));
        let others: Vec<&str> = others.chain(["d", "hold"]).collect();
        let function = look_up_among(name, span, arguments.len(), others).map_err(|error| {
            if error.help.is_none() && self.names.resolve(name).is_some() {
                let words = format!("`{name}` is no function");
                return ExpressionError::new(span, words).with_help("a product is written `*`");
            }
            error
        })?;
        let arguments_lowered = self.all(graph, arguments, locals)?;
        let dimension = self.function_dimension(function, &arguments_lowered, arguments, whole)?;
        let slots: Vec<Slot> = arguments_lowered.iter().map(|one| one.slot).collect();
        let slot = match slots.as_slice() {
            [one] => graph.unary(function, *one),
            [first, rest @ ..] => rest
                .iter()
                .fold(*first, |a, b| graph.binary(function, a, *b)),
            // `look_up_among` refuses a call without arguments.
            [] => graph.constant(f64::NAN),
        };
        Ok(Lowered::new(slot, dimension))
    }

    fn all(
        &mut self,
        graph: &mut Graph,
        arguments: &[Expression],
        locals: Locals<'_>,
    ) -> Result<Vec<Lowered>, ExpressionError> {
        let lowered = arguments
            .iter()
            .map(|one| self.expression(graph, one, locals));
        lowered.collect()
    }

    /// The body of a function with its arguments in place.
    fn expand(
        &mut self,
        graph: &mut Graph,
        (signature, body): (&Signature, &Expression),
        span: Span,
        arguments: &[Expression],
        whole: &Expression,
        locals: Locals<'_>,
    ) -> Result<Lowered, ExpressionError> {
        let name = &signature.name;
        let wanted: Vec<&str> = signature
            .arguments
            .iter()
            .map(|one| one.name.as_str())
            .collect();
        if wanted.len() != arguments.len() {
            let head = format!("{name}({})", wanted.join(", "));
            let words = format!("`{head}` is called with {} arguments", arguments.len());
            return Err(ExpressionError::new(whole.span, words));
        }
        let arguments = self.all(graph, arguments, locals)?;
        // The same call in the same graph is the same value.
        let key = (name.clone(), arguments);
        if let Some(known) = self.calls.get(&key) {
            return Ok(*known);
        }
        self.enter(name, span, "calls itself")?;
        let inner: Vec<(&str, Lowered)> = wanted.into_iter().zip(key.1.iter().copied()).collect();
        let lowered = self
            .expression(graph, body, &inner)
            .map_err(|error| self.placed(error, name, span))?;
        self.stack.pop();
        self.calls.insert(key, lowered);
        Ok(lowered)
    }

    /// `d(of, along)`, formal.
    fn partial(
        &mut self,
        graph: &mut Graph,
        of: &Expression,
        along: &Expression,
        locals: Locals<'_>,
    ) -> Result<Lowered, ExpressionError> {
        let above = self.expression(graph, of, locals)?;
        let below = self.expression(graph, along, locals)?;
        let Some(input) = graph.as_input(below.slot) else {
            let words = format!(
                "`d` differentiates along a coordinate, a rate, a state or a parameter, and `{}` is none",
                along.excerpt()
            );
            return Err(ExpressionError::new(along.span, words));
        };
        let one = graph.constant(1.0);
        let slope = graph
            .tangent(&[above.slot], &[(input, one)], Differentiation::Formal)
            .into_iter()
            .next()
            .flatten();
        Ok(Lowered {
            slot: slope.unwrap_or_else(|| graph.constant(0.0)),
            dimension: above.dimension.map(|dimension| dimension / below.plain()),
        })
    }

    fn function_dimension(
        &self,
        function: Function,
        lowered: &[Lowered],
        arguments: &[Expression],
        whole: &Expression,
    ) -> Result<Dimension, ExpressionError> {
        if self.names.dimensionless() {
            return Ok(Dimension::NONE);
        }
        // A literal zero is of the dimension of the others.
        let other = lowered.iter().find_map(|one| one.dimension);
        let dimensions: Vec<Dimension> = lowered
            .iter()
            .map(|one| one.dimension.or(other).unwrap_or_default())
            .collect();
        if let Ok(dimension) = function.dimension(&dimensions) {
            return Ok(dimension);
        }
        let plain: Vec<Dimension> = dimensions.iter().map(|one| one.without_angle()).collect();
        function.dimension(&plain).map_err(|(index, message)| {
            let span = arguments.get(index).map_or(whole.span, |one| one.span);
            ExpressionError::new(span, message)
        })
    }
}
