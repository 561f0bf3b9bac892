//! Expressions with inputs left out.

use std::collections::HashMap;

use super::{Differentiation, Graph};
use crate::operation::{Operation, Slot};

impl Graph {
    /// The expressions at zero of the given inputs, none where they are zero by structure.
    ///
    /// Unlike a substitution by the constant zero this leaves out products with what is zero: what they are multiplied
    /// with is taken to be finite. So an affine expression a·w + r becomes r.
    pub fn without(&mut self, roots: &[Slot], inputs: &[usize]) -> Vec<Option<Slot>> {
        let order = self.needed(roots, Differentiation::Exact);
        let mut moved: HashMap<Slot, Option<Slot>> = HashMap::with_capacity(order.len());
        for slot in order {
            let operation = self.operation(slot);
            let of = |operand: Slot| moved.get(&operand).copied().unwrap_or(Some(operand));
            let place = match operation {
                Operation::Constant(_) => Some(slot),
                Operation::Input(index) => (!inputs.contains(&(index as usize))).then_some(slot),
                Operation::Hold(a) => of(a).map(|a| self.hold(a)),
                Operation::Negate(a) => of(a).map(|a| self.negate(a)),
                Operation::Add(a, b) => match (of(a), of(b)) {
                    (Some(a), Some(b)) => Some(self.add(a, b)),
                    (one, None) | (None, one) => one,
                },
                Operation::Subtract(a, b) => match (of(a), of(b)) {
                    (Some(a), Some(b)) => Some(self.subtract(a, b)),
                    (a, None) => a,
                    (None, Some(b)) => Some(self.negate(b)),
                },
                Operation::Multiply(a, b) => match (of(a), of(b)) {
                    (Some(a), Some(b)) => Some(self.multiply(a, b)),
                    _ => None,
                },
                Operation::Divide(a, b) if of(b).is_some() => {
                    let below = of(b).unwrap_or(b);
                    of(a).map(|a| self.divide(a, below))
                }
                Operation::Choose([_, _, c, d]) if of(c).is_none() && of(d).is_none() => None,
                _ => {
                    let zero = self.constant(0.0);
                    let place = self.rebuild(operation.map(|operand| {
                        moved
                            .get(&operand)
                            .copied()
                            .unwrap_or(Some(operand))
                            .unwrap_or(zero)
                    }));
                    (self.as_constant(place) != Some(0.0)).then_some(place)
                }
            };
            moved.insert(slot, place);
        }
        roots
            .iter()
            .map(|root| moved.get(root).copied().unwrap_or(Some(*root)))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::{Function, Graph};

    #[test]
    fn what_is_multiplied_with_nothing_is_left_out() {
        let mut graph = Graph::default();
        let [m, w, x] = [0, 1, 2].map(|index| graph.input(index));
        let inertia = graph.multiply(m, w);
        let affine = graph.add(inertia, x);
        let cosine = graph.unary(Function::Cos, w);
        let sine = graph.unary(Function::Sin, w);
        let product = graph.multiply(sine, x);
        let found = graph.without(&[affine, inertia, cosine, product], &[1]);
        assert_eq!(found[0], Some(x));
        assert_eq!(found[1], None);
        assert_eq!(found[2].and_then(|slot| graph.as_constant(slot)), Some(1.0));
        assert_eq!(found[3], None);
    }
}
