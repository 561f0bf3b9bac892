//! The graph of operations behind tapes and programs: single assignment, every operation stored once.

mod condition;
mod dependence;
mod without;

use std::collections::HashMap;

pub use condition::Condition;

use crate::evaluate::as_whole;
use crate::operation::{Operation, Slot};
use crate::{Function, derivative};

/// What differentiation does at [`Graph::hold`].
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub enum Differentiation {
    /// A held expression counts as constant: the derivatives of the language, `'` and `d(…)`.
    Formal,
    /// A held expression is differentiated like any other: Jacobians.
    Exact,
}

/// Expressions over numbered real inputs, as operations in the order of evaluation: each reads earlier ones only.
///
/// Equal operations are stored once, so a part that occurs in many expressions and their derivatives is shared. The
/// constructors fold constants and change only what is exact in floating point (x·1, x/2, x - 0, -(-x), (-x)·y), so a value
/// has the bits that evaluating the expression gives. 0·x stays, since x may be infinite; a derivative that is zero by
/// structure is none at all.
///
/// Values are SI and have no dimension here; [`lower`](crate::lower()) checks dimensions. Points outside a function's
/// domain give not-a-number or infinity. A slot of another graph reads as not-a-number or as whatever stands there:
/// no call panics.
///
/// ```
/// use quell_expression::{Differentiation, Function, Graph};
/// let mut graph = Graph::default();
/// let (x, v) = (graph.input(0), graph.input(1));
/// let sine = graph.unary(Function::Sin, x);
/// let rate = graph.tangent(&[sine], &[(0, v)], Differentiation::Formal);
/// assert_eq!(graph.values(&[sine, rate[0].unwrap()], &[0.0, 3.0]), [0.0, 3.0]);
/// ```
#[derive(Debug, Clone, Default)]
pub struct Graph {
    operations: Vec<Operation>,
    known: HashMap<Operation, Slot>,
}

impl Graph {
    /// Number of operations, inputs and constants included.
    #[must_use]
    pub fn len(&self) -> usize {
        self.operations.len()
    }

    /// Whether nothing is in it.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.operations.is_empty()
    }

    pub(crate) fn operations(&self) -> &[Operation] {
        &self.operations
    }

    pub(crate) fn operation(&self, slot: Slot) -> Operation {
        self.operations
            .get(slot.index())
            .copied()
            .unwrap_or(Operation::Constant(f64::NAN.to_bits()))
    }

    /// The number that a slot is, whatever the inputs.
    #[must_use]
    pub fn as_constant(&self, slot: Slot) -> Option<f64> {
        match self.operation(slot) {
            Operation::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    /// The input that a slot is.
    #[must_use]
    pub fn as_input(&self, slot: Slot) -> Option<usize> {
        match self.operation(slot) {
            Operation::Input(index) => Some(index as usize),
            _ => None,
        }
    }

    /// A number.
    pub fn constant(&mut self, value: f64) -> Slot {
        self.store(Operation::Constant(value.to_bits()))
    }

    /// The input of an index.
    pub fn input(&mut self, index: usize) -> Slot {
        self.store(Operation::Input(index as u32))
    }

    /// a itself, constant under [`Differentiation::Formal`].
    pub fn hold(&mut self, a: Slot) -> Slot {
        match self.operation(a) {
            Operation::Hold(_) => a,
            _ => self.push(Operation::Hold(a)),
        }
    }

    /// -a
    pub fn negate(&mut self, a: Slot) -> Slot {
        match self.operation(a) {
            Operation::Negate(inner) => inner,
            _ => self.push(Operation::Negate(a)),
        }
    }

    /// a + b
    pub fn add(&mut self, a: Slot, b: Slot) -> Slot {
        match (self.operation(a), self.operation(b)) {
            (_, Operation::Negate(inner)) => self.subtract(a, inner),
            (Operation::Negate(inner), _) => self.subtract(b, inner),
            _ => self.push(Operation::Add(a.min(b), a.max(b))),
        }
    }

    /// a - b
    pub fn subtract(&mut self, a: Slot, b: Slot) -> Slot {
        if self.as_constant(b).map(f64::to_bits) == Some(0) {
            return a;
        }
        if let Operation::Negate(inner) = self.operation(b) {
            return self.push(Operation::Add(a.min(inner), a.max(inner)));
        }
        self.push(Operation::Subtract(a, b))
    }

    /// a b
    pub fn multiply(&mut self, a: Slot, b: Slot) -> Slot {
        for (factor, other) in [(a, b), (b, a)] {
            match self.as_constant(factor) {
                Some(1.0) => return other,
                Some(-1.0) => return self.negate(other),
                _ => {}
            }
        }
        // Signs go outwards, where sums take them up.
        match (self.operation(a), self.operation(b)) {
            (Operation::Negate(a), Operation::Negate(b)) => return self.multiply(a, b),
            (Operation::Negate(a), _) => {
                let product = self.multiply(a, b);
                return self.negate(product);
            }
            (_, Operation::Negate(b)) => {
                let product = self.multiply(a, b);
                return self.negate(product);
            }
            _ => {}
        }
        self.push(Operation::Multiply(a.min(b), a.max(b)))
    }

    /// a/b
    pub fn divide(&mut self, a: Slot, b: Slot) -> Slot {
        match self.as_constant(b) {
            Some(1.0) => return a,
            Some(below) if is_power_of_two(below) => {
                let factor = self.constant(1.0 / below);
                return self.multiply(a, factor);
            }
            _ => {}
        }
        match (self.operation(a), self.operation(b)) {
            (Operation::Negate(a), Operation::Negate(b)) => self.divide(a, b),
            (Operation::Negate(a), _) => {
                let quotient = self.divide(a, b);
                self.negate(quotient)
            }
            (_, Operation::Negate(b)) => {
                let quotient = self.divide(a, b);
                self.negate(quotient)
            }
            _ => self.push(Operation::Divide(a, b)),
        }
    }

    /// a^b; for a constant whole b of at most 64 by multiplication alone.
    pub fn power(&mut self, a: Slot, b: Slot) -> Slot {
        match self.as_constant(b) {
            Some(0.0) => self.constant(1.0),
            Some(1.0) => a,
            exponent => match exponent.and_then(as_whole) {
                Some(whole) => self.push(Operation::WholePower(a, whole)),
                None => self.push(Operation::Power(a, b)),
            },
        }
    }

    /// A function of one argument.
    pub fn unary(&mut self, function: Function, a: Slot) -> Slot {
        self.push(Operation::Unary(function, a))
    }

    /// A function of two arguments.
    pub fn binary(&mut self, function: Function, a: Slot, b: Slot) -> Slot {
        self.push(Operation::Binary(function, a, b))
    }

    /// `then` where the condition holds, `otherwise` where not; not-a-number where numbers in it do not compare.
    ///
    /// Only the chosen one counts: what the other is there, infinite perhaps, does not matter.
    pub fn choose(&mut self, condition: &Condition, then: Slot, otherwise: Slot) -> Slot {
        match condition {
            Condition::LessOrEqual(a, b) => self.select([*a, *b, then, otherwise]),
            Condition::Less(a, b) => self.select([*b, *a, otherwise, then]),
            Condition::Equal(a, b) => {
                let not_above = self.select([*b, *a, then, otherwise]);
                self.select([*a, *b, not_above, otherwise])
            }
            Condition::Not(inner) => self.choose(inner, otherwise, then),
            Condition::And(first, second) => {
                let both = self.choose(second, then, otherwise);
                self.choose(first, both, otherwise)
            }
            Condition::Or(first, second) => {
                let either = self.choose(second, then, otherwise);
                self.choose(first, then, either)
            }
        }
    }

    /// c where a ≤ b, d otherwise.
    pub(crate) fn select(&mut self, slots: [Slot; 4]) -> Slot {
        let [a, b, c, d] = slots;
        if c == d {
            return c;
        }
        if let (Some(a), Some(b)) = (self.as_constant(a), self.as_constant(b)) {
            if a <= b {
                return c;
            }
            if a > b {
                return d;
            }
        }
        self.push(Operation::Choose(slots))
    }

    /// d(root)/dσ of each root when every seeded input moves at its rate; none where it is zero by structure.
    ///
    /// An input without seed stands still. Applied to its own result it gives higher directional derivatives. Where a
    /// function has no derivative: `abs`, `sign` and `hypot` have slope 0 at 0, `min` and `max` of equal arguments that of
    /// the earlier one, and a choice that of the chosen side; a jump has no derivative of its own.
    pub fn tangent(
        &mut self,
        roots: &[Slot],
        seeds: &[(usize, Slot)],
        kind: Differentiation,
    ) -> Vec<Option<Slot>> {
        let order = self.needed(roots, kind);
        let slopes = derivative::sweep(self, &order, seeds, kind);
        roots.iter().map(|root| slopes.of(*root)).collect()
    }

    /// ∂root/∂input, exact, row by row: `jacobian[i*n + j]` of n inputs; none where it is zero by structure.
    pub fn jacobian(&mut self, roots: &[Slot], inputs: &[usize]) -> Vec<Option<Slot>> {
        let order = self.needed(roots, Differentiation::Exact);
        let one = self.constant(1.0);
        let mut jacobian = vec![None; roots.len() * inputs.len()];
        for (column, input) in inputs.iter().enumerate() {
            let slopes = derivative::sweep(self, &order, &[(*input, one)], Differentiation::Exact);
            for (row, root) in roots.iter().enumerate() {
                jacobian[row * inputs.len() + column] = slopes.of(*root);
            }
        }
        jacobian
    }

    /// The same expressions with inputs replaced; an input that is not mentioned stays.
    ///
    /// Replacing by the constant 0 takes away what it multiplies, wherever that may be infinite.
    pub fn substitute(&mut self, roots: &[Slot], with: &[(usize, Slot)]) -> Vec<Slot> {
        let order = self.needed(roots, Differentiation::Exact);
        let zero = self.constant(0.0);
        let mut moved: HashMap<Slot, Slot> = HashMap::with_capacity(order.len());
        for slot in order {
            let operation = self.operation(slot);
            let place = match operation {
                Operation::Input(index) => with
                    .iter()
                    .find(|(input, _)| *input == index as usize)
                    .map_or(slot, |(_, other)| *other),
                // Operands come first in the order.
                _ => self.without_zeros(
                    operation.map(|operand| moved.get(&operand).copied().unwrap_or(operand)),
                    zero,
                ),
            };
            moved.insert(slot, place);
        }
        let of = |root: &Slot| moved.get(root).copied().unwrap_or(*root);
        roots.iter().map(of).collect()
    }

    /// The operation where a constant zero is none.
    fn without_zeros(&mut self, operation: Operation, zero: Slot) -> Slot {
        match operation {
            Operation::Multiply(a, b) if a == zero || b == zero => zero,
            Operation::Divide(a, _) | Operation::Negate(a) if a == zero => zero,
            Operation::Add(a, b) if a == zero => b,
            Operation::Add(a, b) if b == zero => a,
            Operation::Subtract(a, b) if a == zero => self.negate(b),
            _ => self.rebuild(operation),
        }
    }

    /// Copies expressions of another graph, whose input i becomes the slot `inputs[i]`, or keeps its number where there
    /// is none.
    pub fn append(&mut self, other: &Self, roots: &[Slot], inputs: &[Slot]) -> Vec<Slot> {
        let mut moved: HashMap<Slot, Slot> = HashMap::new();
        for slot in other.needed(roots, Differentiation::Exact) {
            let operation = other.operation(slot);
            let place = match operation {
                Operation::Input(index) => match inputs.get(index as usize) {
                    Some(given) => *given,
                    None => self.input(index as usize),
                },
                _ => self.rebuild(
                    operation.map(|operand| moved.get(&operand).copied().unwrap_or(operand)),
                ),
            };
            moved.insert(slot, place);
        }
        roots
            .iter()
            .map(|root| match moved.get(root) {
                Some(place) => *place,
                None => self.constant(f64::NAN),
            })
            .collect()
    }

    /// Values at one point. For a few evaluations; a [`Program`](crate::Program) is for many.
    #[must_use]
    pub fn values(&self, roots: &[Slot], inputs: &[f64]) -> Vec<f64> {
        let order = self.needed(roots, Differentiation::Exact);
        let mut work = vec![f64::NAN; order.last().map_or(0, |slot| slot.index() + 1)];
        for slot in order {
            work[slot.index()] = self.operation(slot).value(inputs, &work);
        }
        let of = |root: &Slot| work.get(root.index()).copied().unwrap_or(f64::NAN);
        roots.iter().map(of).collect()
    }

    /// The operation through its constructor, which simplifies.
    pub(crate) fn rebuild(&mut self, operation: Operation) -> Slot {
        match operation {
            Operation::Constant(_) | Operation::Input(_) => self.store(operation),
            Operation::Hold(a) => self.hold(a),
            Operation::Negate(a) => self.negate(a),
            Operation::Add(a, b) => self.add(a, b),
            Operation::Subtract(a, b) => self.subtract(a, b),
            Operation::Multiply(a, b) => self.multiply(a, b),
            Operation::Divide(a, b) => self.divide(a, b),
            Operation::WholePower(..) => self.push(operation),
            Operation::Power(a, b) => self.power(a, b),
            Operation::Unary(function, a) => self.unary(function, a),
            Operation::Binary(function, a, b) => self.binary(function, a, b),
            Operation::Choose(slots) => self.select(slots),
        }
    }

    /// Folds an operation on constants, else stores it.
    fn push(&mut self, operation: Operation) -> Slot {
        let mut values = [0.0; 4];
        let mut count = 0;
        let mut constant = true;
        operation.operands(|slot| {
            match self.as_constant(slot) {
                Some(value) => values[count] = value,
                None => constant = false,
            }
            count += 1;
        });
        if !constant {
            return self.store(operation);
        }
        let mut next = 0;
        let local = operation.map(|_| {
            next += 1;
            Slot::at(next - 1)
        });
        self.constant(local.value(&[], &values))
    }

    /// The slot of an operation that is there.
    fn find(&self, operation: Operation) -> Option<Slot> {
        self.known.get(&operation).copied()
    }

    fn store(&mut self, operation: Operation) -> Slot {
        let operations = &mut self.operations;
        *self.known.entry(operation).or_insert_with(|| {
            operations.push(operation);
            Slot::at(operations.len() - 1)
        })
    }
}

/// Whether dividing by it is the same, to the last bit, as multiplying by its reciprocal.
fn is_power_of_two(value: f64) -> bool {
    const MANTISSA: u64 = (1 << 52) - 1;
    let magnitude = value.abs();
    value.to_bits() & MANTISSA == 0 && (1e-300..1e300).contains(&magnitude)
}
