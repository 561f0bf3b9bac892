//! Tapes: many expressions over the same inputs, evaluated together with their exact derivatives.

use crate::evaluate::{look_up, no_condition, no_value, not_finite, unknown_name};
use crate::expression::{BinaryOperator, Expression, Node};
use crate::graph::{Condition, Graph};
use crate::operation::{Operation, Slot};
use crate::{ExpressionError, Function, Quantity, Scope};

/// Gathers expressions into a [`Tape`].
#[derive(Debug, Clone)]
pub struct TapeBuilder {
    inputs: Vec<String>,
    graph: Graph,
    outputs: Vec<Slot>,
    /// Whether the part at hand belongs to a branch, which may never be taken.
    in_branch: bool,
}

/// Expressions over named real inputs, compiled: every sub-expression is computed once, for values and derivatives alike.
///
/// All values are SI; dimensions are not looked at ([`Expression::evaluate`] checks them). Values are those of
/// `evaluate`, save that a point outside a function's domain gives not-a-number or infinity instead of an error.
///
/// No call panics, whatever the lengths: a missing input reads as not-a-number, of outputs and derivatives as many are
/// written as fit, and what is beyond them stays as it was.
///
/// ```
/// use quell_expression::{Expression, NoNames, TapeBuilder};
/// let mut builder = TapeBuilder::new(&["x".to_owned(), "y".to_owned()]);
/// builder.add(&Expression::parse("x^2*y")?, &NoNames)?;
/// let tape = builder.build();
/// let (mut work, mut value, mut slope) = (Vec::new(), [0.0], [0.0; 2]);
/// tape.jacobian(&[3.0, 5.0], &mut work, &mut value, &mut slope);
/// assert_eq!((value, slope), ([45.0], [30.0, 9.0]));
/// # Ok::<(), quell_expression::ExpressionError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Tape {
    inputs: usize,
    /// Values first, then what only derivatives need.
    operations: Vec<Operation>,
    values: usize,
    outputs: Vec<Slot>,
    /// Position in the row-major Jacobian, and the slot of its entry; all other entries are zero by structure.
    entries: Vec<(usize, Slot)>,
}

impl TapeBuilder {
    /// A tape's inputs in their order; of two with the same name the first counts.
    #[must_use]
    pub fn new(inputs: &[String]) -> Self {
        Self {
            inputs: inputs.to_vec(),
            graph: Graph::default(),
            outputs: Vec::new(),
            in_branch: false,
        }
    }

    /// Adds an output and returns its index.
    ///
    /// Names that are no inputs are constants, SI values from `constants` (an input hides a constant of its name), and
    /// what consists of constants only is computed here.
    ///
    /// # Errors
    /// At their place: unknown names and functions, constant parts that are not finite, time derivatives and
    /// comparisons.
    pub fn add(
        &mut self,
        expression: &Expression,
        constants: &dyn Scope,
    ) -> Result<usize, ExpressionError> {
        let slot = self.part(expression, constants)?;
        self.outputs.push(slot);
        Ok(self.outputs.len() - 1)
    }

    fn part(
        &mut self,
        expression: &Expression,
        constants: &dyn Scope,
    ) -> Result<Slot, ExpressionError> {
        let (first, operations) = expression.chain();
        let mut slot = self.operand(first, constants)?;
        for operation in operations.into_iter().rev() {
            if let Node::Binary {
                operator, right, ..
            } = &operation.node
            {
                let other = self.part(right, constants)?;
                slot = match operator {
                    BinaryOperator::Add => self.graph.add(slot, other),
                    BinaryOperator::Subtract => self.graph.subtract(slot, other),
                    BinaryOperator::Multiply => self.graph.multiply(slot, other),
                    BinaryOperator::Divide => self.graph.divide(slot, other),
                    BinaryOperator::Power => self.graph.power(slot, other),
                };
                slot = self.finite(operation, slot)?;
            }
        }
        Ok(slot)
    }

    /// Anything but an operation of two operands.
    fn operand(
        &mut self,
        expression: &Expression,
        constants: &dyn Scope,
    ) -> Result<Slot, ExpressionError> {
        let slot = match &expression.node {
            Node::Number(value) => self.graph.constant(*value),
            Node::Quantity { value, unit } => self.graph.constant(value * unit.factor),
            Node::Name(name) => return self.name(name, expression, constants),
            Node::Negate(operand) => {
                let operand = self.part(operand, constants)?;
                self.graph.negate(operand)
            }
            Node::Binary { .. } => return self.part(expression, constants),
            Node::Call {
                function,
                function_span,
                arguments,
            } => {
                let function = look_up(function, *function_span, arguments.len())?;
                let slots = arguments
                    .iter()
                    .map(|argument| self.part(argument, constants))
                    .collect::<Result<Vec<_>, _>>()?;
                self.call(function, &slots)
            }
            Node::Choice {
                condition,
                then,
                otherwise,
            } => {
                let condition = self.condition(condition, constants)?;
                let outer = std::mem::replace(&mut self.in_branch, true);
                let branches = self
                    .part(then, constants)
                    .and_then(|then| Ok((then, self.part(otherwise, constants)?)));
                self.in_branch = outer;
                let (then, otherwise) = branches?;
                self.graph.choose(&condition, then, otherwise)
            }
            Node::Derivative { .. }
            | Node::Comparison { .. }
            | Node::Logic { .. }
            | Node::Not(_) => return Err(no_value(expression)),
        };
        self.finite(expression, slot)
    }

    fn condition(
        &mut self,
        expression: &Expression,
        constants: &dyn Scope,
    ) -> Result<Condition, ExpressionError> {
        match &expression.node {
            Node::Comparison {
                operator,
                left,
                right,
            } => {
                let left = self.part(left, constants)?;
                let right = self.part(right, constants)?;
                Ok(Condition::of(*operator, left, right))
            }
            Node::Logic { .. } => {
                let (first, operations) = expression.logic_chain();
                let mut condition = self.condition(first, constants)?;
                for (operator, right) in operations.into_iter().rev() {
                    condition = condition.joined(operator, self.condition(right, constants)?);
                }
                Ok(condition)
            }
            Node::Not(operand) => Ok(self.condition(operand, constants)?.negated()),
            _ => Err(no_condition(expression)),
        }
    }

    /// Refuses a constant that is infinite or not a number.
    fn finite(&self, expression: &Expression, slot: Slot) -> Result<Slot, ExpressionError> {
        match self.graph.as_constant(slot) {
            Some(value) if !value.is_finite() && !self.in_branch => Err(not_finite(expression)),
            _ => Ok(slot),
        }
    }

    fn name(
        &mut self,
        name: &str,
        expression: &Expression,
        constants: &dyn Scope,
    ) -> Result<Slot, ExpressionError> {
        if let Some(index) = self.inputs.iter().position(|input| input == name) {
            return Ok(self.graph.input(index));
        }
        let value = match constants.quantity(name) {
            Some(quantity) => quantity.value,
            None if name == "pi" => std::f64::consts::PI,
            None => {
                let scope = Together {
                    inputs: &self.inputs,
                    constants,
                };
                return Err(unknown_name(name, expression.span, &scope));
            }
        };
        if !value.is_finite() {
            return Err(not_finite(expression));
        }
        Ok(self.graph.constant(value))
    }

    fn call(&mut self, function: Function, slots: &[Slot]) -> Slot {
        match slots {
            [one] => self.graph.unary(function, *one),
            [first, rest @ ..] => rest
                .iter()
                .fold(*first, |a, b| self.graph.binary(function, a, *b)),
            // `look_up` refuses a call without arguments.
            [] => self.graph.constant(f64::NAN),
        }
    }

    /// Derives every output with respect to every input and leaves out what nothing needs.
    #[must_use]
    pub fn build(self) -> Tape {
        let Self {
            inputs,
            mut graph,
            outputs,
            ..
        } = self;
        let columns: Vec<usize> = (0..inputs.len()).collect();
        let entries: Vec<(usize, Slot)> = graph
            .jacobian(&outputs, &columns)
            .into_iter()
            .enumerate()
            .filter_map(|(position, slope)| Some((position, slope?)))
            .collect();
        let mut order = Order::new(graph.operations());
        order.take(outputs.iter().copied());
        let values = order.operations.len();
        order.take(entries.iter().map(|(_, slot)| *slot));
        let place = |slot: Slot| order.place(slot);
        Tape {
            inputs: inputs.len(),
            values,
            outputs: outputs.into_iter().map(place).collect(),
            entries: entries
                .into_iter()
                .map(|(position, slot)| (position, place(slot)))
                .collect(),
            operations: order.operations,
        }
    }
}

/// Inputs and constants, for suggestions.
struct Together<'a> {
    inputs: &'a [String],
    constants: &'a dyn Scope,
}

impl Scope for Together<'_> {
    fn quantity(&self, name: &str) -> Option<Quantity> {
        self.constants.quantity(name)
    }

    fn names(&self) -> Vec<&str> {
        let inputs = self.inputs.iter().map(String::as_str);
        inputs.chain(self.constants.names()).collect()
    }
}

/// Renumbers the operations that are needed.
struct Order<'a> {
    graph: &'a [Operation],
    places: Vec<Option<Slot>>,
    operations: Vec<Operation>,
}

impl<'a> Order<'a> {
    fn new(graph: &'a [Operation]) -> Self {
        Self {
            graph,
            places: vec![None; graph.len()],
            operations: Vec::new(),
        }
    }

    /// Appends what the roots need and is not there yet, each after what it reads.
    fn take(&mut self, roots: impl Iterator<Item = Slot>) {
        let mut needed = vec![false; self.graph.len()];
        for root in roots {
            needed[root.index()] = true;
        }
        // Operands come before in the graph, so one pass backwards finds them all.
        for (index, operation) in self.graph.iter().enumerate().rev() {
            if needed[index] {
                operation.operands(|operand| needed[operand.index()] = true);
            }
        }
        for (index, operation) in self.graph.iter().enumerate() {
            if needed[index] && self.places[index].is_none() {
                let moved = operation.map(|operand| self.place(operand));
                self.places[index] = Some(Slot::at(self.operations.len()));
                self.operations.push(moved);
            }
        }
    }

    fn place(&self, slot: Slot) -> Slot {
        // Every slot asked for was taken before; 0 is never read.
        self.places[slot.index()].unwrap_or(Slot(0))
    }
}

impl Tape {
    /// Number of inputs.
    #[must_use]
    pub const fn inputs(&self) -> usize {
        self.inputs
    }

    /// Number of outputs.
    #[must_use]
    pub const fn outputs(&self) -> usize {
        self.outputs.len()
    }

    /// Length of the work space that [`Self::evaluate`] needs.
    #[must_use]
    pub const fn work_len(&self) -> usize {
        self.values
    }

    /// Length of the work space that [`Self::jacobian`] needs.
    #[must_use]
    pub const fn jacobian_work_len(&self) -> usize {
        self.operations.len()
    }

    /// Values of all outputs.
    ///
    /// `inputs` are as many as [`Self::inputs`], `outputs` as [`Self::outputs`], all in SI; shorter slices see the type's
    /// contract. `work` is made longer where it is too short, so only the first call allocates.
    pub fn evaluate(&self, inputs: &[f64], work: &mut Vec<f64>, outputs: &mut [f64]) {
        let work = run(&self.operations[..self.values], inputs, work);
        self.read(work, outputs);
    }

    /// Values and exact derivatives of all outputs: `jacobian[i*n + j]` is ∂output_i/∂input_j, of n inputs.
    ///
    /// Where a function has no derivative: `abs`, `sign` and `hypot` have slope 0 at 0, `min` and `max` of equal arguments
    /// the slope of the earlier one; elsewhere (`sqrt` at 0) infinity or not-a-number comes out.
    /// `inputs`, `work` and `outputs` are as in [`Self::evaluate`], the Jacobian has [`Self::outputs`] rows of
    /// [`Self::inputs`] columns.
    pub fn jacobian(
        &self,
        inputs: &[f64],
        work: &mut Vec<f64>,
        outputs: &mut [f64],
        jacobian: &mut [f64],
    ) {
        let work = run(&self.operations, inputs, work);
        self.read(work, outputs);
        let size = self.inputs * self.outputs.len();
        for entry in jacobian.iter_mut().take(size) {
            *entry = 0.0;
        }
        for (position, slot) in &self.entries {
            if let Some(entry) = jacobian.get_mut(*position) {
                *entry = work[slot.index()];
            }
        }
    }

    fn read(&self, work: &[f64], outputs: &mut [f64]) {
        for (output, slot) in outputs.iter_mut().zip(&self.outputs) {
            *output = work[slot.index()];
        }
    }
}

/// Computes the operations in their order, each into its slot.
fn run<'a>(operations: &[Operation], inputs: &[f64], work: &'a mut Vec<f64>) -> &'a [f64] {
    if work.len() < operations.len() {
        work.resize(operations.len(), 0.0);
    }
    for (slot, operation) in operations.iter().enumerate() {
        work[slot] = operation.value(inputs, work);
    }
    work
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::NoNames;

    fn tape(inputs: &[&str], outputs: &[&str]) -> Tape {
        let inputs: Vec<String> = inputs.iter().map(|name| (*name).to_owned()).collect();
        let mut builder = TapeBuilder::new(&inputs);
        for output in outputs {
            let expression = Expression::parse(output).unwrap();
            builder.add(&expression, &NoNames).unwrap();
        }
        builder.build()
    }

    #[test]
    fn shares_and_folds() {
        let tape = tape(&["x"], &["exp(x)", "exp(x) + 2*3*pi", "exp(x)"]);
        // x, exp(x), 6π, the sum; exp is its own derivative, so only the 1 of dx/dx might be added, and is left out.
        assert_eq!(tape.work_len(), 4);
        assert_eq!(tape.jacobian_work_len(), 4);
    }

    #[test]
    fn short_and_long_slices_are_filled_as_far_as_they_go() {
        let tape = tape(&["x", "y"], &["x*y", "x + y", "3"]);
        let (mut work, mut values, mut slopes) = (vec![7.0; 100], [8.0; 4], [9.0; 7]);
        tape.jacobian(&[2.0, 5.0], &mut work, &mut values, &mut slopes);
        assert_eq!(values, [10.0, 7.0, 3.0, 8.0]);
        assert_eq!(slopes, [5.0, 2.0, 1.0, 1.0, 0.0, 0.0, 9.0]);
        let (mut values, mut slopes) = ([0.0; 1], [9.0; 1]);
        tape.jacobian(&[2.0], &mut Vec::new(), &mut values, &mut slopes);
        assert!(values[0].is_nan() && slopes[0].is_nan());
        tape.jacobian(&[], &mut Vec::new(), &mut [], &mut []);
        tape.evaluate(&[], &mut Vec::new(), &mut []);
    }

    #[test]
    fn work_is_allocated_once() {
        let tape = tape(&["x"], &["sin(x)*cos(x)^2"]);
        let mut work = Vec::new();
        let (mut values, mut slopes) = ([0.0], [0.0]);
        tape.jacobian(&[0.3], &mut work, &mut values, &mut slopes);
        let place = work.as_ptr();
        tape.jacobian(&[0.4], &mut work, &mut values, &mut slopes);
        tape.evaluate(&[0.5], &mut work, &mut values);
        assert_eq!(work.as_ptr(), place);
    }

    #[test]
    fn kinks_follow_the_stated_conventions() {
        let expressions = [
            ("abs(x)", 0.0),
            ("sign(x)", 0.0),
            ("x*abs(x)", 0.0),
            ("hypot(x, y)", 0.0),
            ("min(2*x, x)", 2.0),
            ("max(2*x, x, 3*x)", 2.0),
            ("max(sqrt(x), 1)", 0.0),
            ("(x + 1)^(y + 2)", 2.0),
            ("x^(x + 2)", 0.0),
            ("x^0", 0.0),
        ];
        let outputs: Vec<&str> = expressions.iter().map(|(text, _)| *text).collect();
        let tape = tape(&["x", "y"], &outputs);
        let (mut values, mut slopes) = ([0.0; 10], [0.0; 20]);
        tape.jacobian(&[0.0, 0.0], &mut Vec::new(), &mut values, &mut slopes);
        for (row, (text, slope)) in expressions.iter().enumerate() {
            assert_eq!(slopes[2 * row], *slope, "{text}");
        }
    }

    #[test]
    fn refuses_what_has_no_value() {
        let mut builder = TapeBuilder::new(&["stroke".to_owned()]);
        let constants = vec![("zero".to_owned(), Quantity::number(0.0))];
        for (text, message, help) in [
            (
                "2*strok",
                "unknown name `strok`",
                Some("did you mean `stroke`?"),
            ),
            ("stroke + 1/zero", "`1/zero` is not a finite number", None),
            (
                "stroke'",
                "`stroke'` is a time derivative, and nothing here varies in time",
                None,
            ),
            (
                "stroke < 1",
                "`stroke < 1` is a comparison, where a number is expected",
                None,
            ),
            (
                "sine(stroke)",
                "unknown function `sine`",
                Some("did you mean `sin`?"),
            ),
        ] {
            let error = builder
                .add(&Expression::parse(text).unwrap(), &constants)
                .unwrap_err();
            assert_eq!(
                (error.message.as_str(), error.help.as_deref()),
                (message, help)
            );
        }
        assert_eq!(builder.build().outputs(), 0);
    }
}
