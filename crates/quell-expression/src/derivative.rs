//! Exact derivatives, as further operations of the same graph.
//!
//! Where a function has no derivative the convention is, so that what follows stays usable by Newton's method:
//! - `abs` at 0 has slope 0 (the mean of both sides), and so has `hypot` at (0, 0);
//! - `sign` has slope 0 everywhere;
//! - `min` and `max` take the slope of the earlier argument where two are equal;
//! - `x^y` at x = 0 has slope 0 along y if y > 0.
//!
//! Elsewhere infinity or not-a-number comes out, as at `sqrt(0)` or `atan2(0, 0)`.

use crate::Function;
use crate::graph::{Differentiation, Graph};
use crate::operation::{Operation, Slot};

/// Derivatives of operations along one direction; none where they are zero by structure.
pub(crate) struct Slopes(Vec<Option<Slot>>);

impl Slopes {
    pub(crate) fn of(&self, slot: Slot) -> Option<Slot> {
        self.0.get(slot.index()).copied().flatten()
    }
}

/// Derivatives of the operations of `order` when each seeded input moves at its rate.
///
/// Forward sweep: the derivative of each operation from those of its operands, by the chain rule. New operations are
/// appended to the graph, those that the values or other derivatives already hold are shared.
pub(crate) fn sweep(
    graph: &mut Graph,
    order: &[Slot],
    seeds: &[(usize, Slot)],
    kind: Differentiation,
) -> Slopes {
    let mut slopes = Slopes(vec![None; order.last().map_or(0, |slot| slot.index() + 1)]);
    for slot in order {
        let slope = match graph.operation(*slot) {
            Operation::Input(index) => seeds
                .iter()
                .find(|(input, _)| *input == index as usize)
                .map(|(_, rate)| *rate),
            Operation::Hold(_) if kind == Differentiation::Formal => None,
            operation => rule(graph, *slot, operation, |operand| slopes.of(operand)),
        };
        slopes.0[slot.index()] = slope.filter(|slope| graph.as_constant(*slope) != Some(0.0));
    }
    slopes
}

/// The chain rule for one operation, whose value is in `slot`.
fn rule(
    graph: &mut Graph,
    slot: Slot,
    operation: Operation,
    of: impl Fn(Slot) -> Option<Slot>,
) -> Option<Slot> {
    match operation {
        Operation::Constant(_) | Operation::Input(_) => None,
        Operation::Hold(a) => of(a),
        Operation::Negate(a) => of(a).map(|da| graph.negate(da)),
        Operation::Add(a, b) => sum(graph, of(a), of(b)),
        Operation::Subtract(a, b) => difference(graph, of(a), of(b)),
        Operation::Multiply(a, b) => {
            let first = of(a).map(|da| graph.multiply(da, b));
            let second = of(b).map(|db| graph.multiply(a, db));
            sum(graph, first, second)
        }
        // (a' - q b')·(1/b) with the quotient q at hand; one reciprocal serves all directions.
        Operation::Divide(a, b) => {
            let second = of(b).map(|db| graph.multiply(slot, db));
            let above = difference(graph, of(a), second)?;
            Some(over(graph, above, b))
        }
        Operation::WholePower(a, exponent) => {
            let da = of(a)?;
            let factor = scaled_power(graph, a, f64::from(exponent));
            Some(graph.multiply(factor, da))
        }
        Operation::Power(a, b) => power(graph, slot, (a, of(a)), (b, of(b))),
        Operation::Unary(function, a) => {
            let da = of(a)?;
            unary(graph, slot, function, a, da)
        }
        Operation::Binary(function, a, b) => binary(graph, slot, function, (a, of(a)), (b, of(b))),
        Operation::Choose([a, b, c, d]) => choice(graph, [a, b], of(c), of(d)),
    }
}

/// a·(1/b): the reciprocal is shared, and known beforehand where b is a parameter.
fn over(graph: &mut Graph, a: Slot, b: Slot) -> Slot {
    let one = graph.constant(1.0);
    let reciprocal = graph.divide(one, b);
    graph.multiply(a, reciprocal)
}

fn sum(graph: &mut Graph, a: Option<Slot>, b: Option<Slot>) -> Option<Slot> {
    match (a, b) {
        (Some(a), Some(b)) => Some(graph.add(a, b)),
        (one, None) | (None, one) => one,
    }
}

fn difference(graph: &mut Graph, a: Option<Slot>, b: Option<Slot>) -> Option<Slot> {
    match (a, b) {
        (Some(a), Some(b)) => Some(graph.subtract(a, b)),
        (a, None) => a,
        (None, Some(b)) => Some(graph.negate(b)),
    }
}

/// `first` where a ≤ b, else `second`.
fn choice(
    graph: &mut Graph,
    [a, b]: [Slot; 2],
    first: Option<Slot>,
    second: Option<Slot>,
) -> Option<Slot> {
    if first.is_none() && second.is_none() {
        return None;
    }
    let zero = graph.constant(0.0);
    Some(graph.select([a, b, first.unwrap_or(zero), second.unwrap_or(zero)]))
}

/// n a^(n - 1).
fn scaled_power(graph: &mut Graph, a: Slot, exponent: f64) -> Slot {
    let lower = graph.constant(exponent - 1.0);
    let power = graph.power(a, lower);
    let exponent = graph.constant(exponent);
    graph.multiply(exponent, power)
}

/// (a^b)' = b a^(b - 1) a' + a^b log(a) b'.
fn power(
    graph: &mut Graph,
    slot: Slot,
    (a, da): (Slot, Option<Slot>),
    (b, db): (Slot, Option<Slot>),
) -> Option<Slot> {
    let along_base = da.map(|da| {
        let factor = if let Some(exponent) = graph.as_constant(b) {
            scaled_power(graph, a, exponent)
        } else {
            let one = graph.constant(1.0);
            let lower = graph.subtract(b, one);
            let power = graph.power(a, lower);
            graph.multiply(b, power)
        };
        graph.multiply(factor, da)
    });
    let along_exponent = db.map(|db| {
        // 0·log(0) is not a number, its limit is zero.
        let logarithm = graph.unary(Function::Log, a);
        let product = graph.multiply(slot, logarithm);
        let magnitude = graph.unary(Function::Abs, slot);
        let zero = graph.constant(0.0);
        let factor = graph.select([magnitude, zero, zero, product]);
        graph.multiply(factor, db)
    });
    sum(graph, along_base, along_exponent)
}

fn unary(graph: &mut Graph, slot: Slot, function: Function, a: Slot, da: Slot) -> Option<Slot> {
    let one = graph.constant(1.0);
    let slope = match function {
        Function::Sin => {
            let cosine = graph.unary(Function::Cos, a);
            graph.multiply(cosine, da)
        }
        Function::Cos => {
            let sine = graph.unary(Function::Sin, a);
            let product = graph.multiply(sine, da);
            graph.negate(product)
        }
        // 1 + tan²
        Function::Tan => {
            let square = graph.multiply(slot, slot);
            let factor = graph.add(one, square);
            graph.multiply(factor, da)
        }
        // ±1/√((1 - a)(1 + a))
        Function::Asin | Function::Acos => {
            let product = one_minus_square(graph, a);
            let root = graph.unary(Function::Sqrt, product);
            let quotient = over(graph, da, root);
            if function == Function::Asin {
                quotient
            } else {
                graph.negate(quotient)
            }
        }
        // 1/(1 + a²)
        Function::Atan => {
            let square = graph.multiply(a, a);
            let below = graph.add(one, square);
            over(graph, da, below)
        }
        Function::Sinh => {
            let cosine = graph.unary(Function::Cosh, a);
            graph.multiply(cosine, da)
        }
        Function::Cosh => {
            let sine = graph.unary(Function::Sinh, a);
            graph.multiply(sine, da)
        }
        // 1 - tanh²
        Function::Tanh => {
            let factor = one_minus_square(graph, slot);
            graph.multiply(factor, da)
        }
        Function::Exp => graph.multiply(slot, da),
        Function::Log => over(graph, da, a),
        Function::Log10 => {
            let ten = graph.constant(std::f64::consts::LN_10);
            let below = graph.multiply(ten, a);
            over(graph, da, below)
        }
        // 1/(2 √a)
        Function::Sqrt => {
            let below = graph.add(slot, slot);
            over(graph, da, below)
        }
        Function::Abs => {
            let sign = graph.unary(Function::Sign, a);
            graph.multiply(sign, da)
        }
        Function::Sign => return None,
        // One argument is its own smallest and largest; the builder never asks for the others with one.
        Function::Min | Function::Max => da,
        Function::Atan2 | Function::Hypot => graph.constant(f64::NAN),
    };
    Some(slope)
}

/// (1 - a)(1 + a), which keeps its digits near |a| = 1.
fn one_minus_square(graph: &mut Graph, a: Slot) -> Slot {
    let one = graph.constant(1.0);
    let (below, above) = (graph.subtract(one, a), graph.add(one, a));
    graph.multiply(below, above)
}

fn binary(
    graph: &mut Graph,
    slot: Slot,
    function: Function,
    (a, da): (Slot, Option<Slot>),
    (b, db): (Slot, Option<Slot>),
) -> Option<Slot> {
    match function {
        Function::Min => choice(graph, [a, b], da, db),
        Function::Max => choice(graph, [b, a], da, db),
        // (b a' - a b')/(a² + b²)
        Function::Atan2 => {
            let first = da.map(|da| graph.multiply(b, da));
            let second = db.map(|db| graph.multiply(a, db));
            let above = difference(graph, first, second)?;
            let (square_a, square_b) = (graph.multiply(a, a), graph.multiply(b, b));
            let below = graph.add(square_a, square_b);
            Some(over(graph, above, below))
        }
        // (a a' + b b')/h
        Function::Hypot => {
            let first = da.map(|da| graph.multiply(a, da));
            let second = db.map(|db| graph.multiply(b, db));
            let above = sum(graph, first, second)?;
            let slope = graph.divide(above, slot);
            let zero = graph.constant(0.0);
            Some(graph.select([slot, zero, zero, slope]))
        }
        // No other function has two arguments.
        _ => (da.is_some() || db.is_some()).then(|| graph.constant(f64::NAN)),
    }
}
