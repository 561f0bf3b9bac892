//! On what expressions depend, and where they are not smooth.

use std::collections::BTreeSet;

use super::{Differentiation, Graph};
use crate::Function;
use crate::operation::{Operation, Slot};

impl Graph {
    /// Whether an input occurs in an expression, be it in a condition only.
    #[must_use]
    pub fn depends(&self, root: Slot, input: usize) -> bool {
        self.dependence(&[root]).contains(&input)
    }

    /// Every input that occurs in any of the expressions.
    #[must_use]
    pub fn dependence(&self, roots: &[Slot]) -> BTreeSet<usize> {
        self.inputs_among(&self.needed(roots, Differentiation::Exact))
    }

    /// The inputs on which an expression depends otherwise than by deciding which of its pieces holds: without those
    /// that occur in conditions and in `sign` only. Of a Jacobian's entries none means: the function is affine, piece by
    /// piece.
    #[must_use]
    pub fn smooth_dependence(&self, root: Slot) -> BTreeSet<usize> {
        self.inputs_among(&self.reach(&[root], |operation, visit| match operation {
            Operation::Choose([_, _, c, d]) => [c, d].into_iter().for_each(visit),
            Operation::Unary(Function::Sign, _) => {}
            _ => operation.operands(visit),
        }))
    }

    /// The inputs that move an expression under [`Differentiation::Formal`].
    pub(crate) fn formal_dependence(&self, root: Slot) -> BTreeSet<usize> {
        self.inputs_among(&self.reach(&[root], |operation, visit| match operation {
            Operation::Choose([_, _, c, d]) => [c, d].into_iter().for_each(visit),
            Operation::Unary(Function::Sign, _) | Operation::Hold(_) => {}
            _ => operation.operands(visit),
        }))
    }

    /// The margins whose changes of sign are the kinks and jumps of the expressions: a - b of every condition, a of
    /// `abs(a)` and `sign(a)`, a - b of `min(a, b)` and `max(a, b)`. Each once, in the order of evaluation.
    pub fn switches(&mut self, roots: &[Slot]) -> Vec<Slot> {
        let mut margins: Vec<Slot> = Vec::new();
        for slot in self.needed(roots, Differentiation::Exact) {
            let margin = match self.operation(slot) {
                Operation::Choose([a, b, ..])
                | Operation::Binary(Function::Min | Function::Max, a, b) => self.subtract(a, b),
                Operation::Unary(Function::Abs | Function::Sign, a) => a,
                _ => continue,
            };
            let opposite = self.negative(margin);
            let known = margins
                .iter()
                .any(|known| *known == margin || Some(*known) == opposite);
            if !known && self.as_constant(margin).is_none() {
                margins.push(margin);
            }
        }
        margins
    }

    /// The slot of -a if it is in the graph in plain sight: b - a for a - b, a for -a.
    fn negative(&self, slot: Slot) -> Option<Slot> {
        match self.operation(slot) {
            Operation::Subtract(a, b) => self.find(Operation::Subtract(b, a)),
            Operation::Negate(a) => Some(a),
            _ => self.find(Operation::Negate(slot)),
        }
    }

    fn inputs_among(&self, slots: &[Slot]) -> BTreeSet<usize> {
        slots
            .iter()
            .filter_map(|slot| self.as_input(*slot))
            .collect()
    }

    /// What the roots need, themselves included, in the order of evaluation; under [`Differentiation::Formal`] without
    /// what is held.
    pub(crate) fn needed(&self, roots: &[Slot], kind: Differentiation) -> Vec<Slot> {
        self.reach(roots, |operation, visit| match operation {
            Operation::Hold(_) if kind == Differentiation::Formal => {}
            _ => operation.operands(visit),
        })
    }

    fn reach(
        &self,
        roots: &[Slot],
        operands: impl Fn(Operation, &mut dyn FnMut(Slot)),
    ) -> Vec<Slot> {
        let end = roots.iter().map(|root| root.index() + 1).max().unwrap_or(0);
        let mut needed = vec![false; end.min(self.len())];
        for root in roots {
            if let Some(mark) = needed.get_mut(root.index()) {
                *mark = true;
            }
        }
        // Operands come before in the graph, so one pass backwards finds them all.
        for index in (0..needed.len()).rev() {
            if needed[index] {
                operands(self.operation(Slot::at(index)), &mut |operand| {
                    needed[operand.index()] = true;
                });
            }
        }
        let marked = needed.iter().enumerate().filter(|(_, mark)| **mark);
        marked.map(|(index, _)| Slot::at(index)).collect()
    }
}
