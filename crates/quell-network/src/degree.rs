//! What a network's structure tells without its values.

use crate::network::Shape;
use crate::{Network, Tree};

/// Degrees of a network's dynamic stiffness D(s) = N(s)/D(s) = s Y(s) for generic positive values.
///
/// N and D of the homogeneous rules are sums of products of value · s^q with positive coefficients, so their lowest and
/// highest powers never cancel. Nor does anything else but a power of s: N is the spanning-tree polynomial of the
/// network's graph in the element stiffnesses, D that of the graph with its terminals joined. The spanning-tree polynomial
/// of a graph that is connected as a matroid is irreducible, and here each factor of one polynomial has other elements
/// than each of the other; a common factor after the substitution of value · s^q can then hold no value, so it is a power
/// of s. Equal values, or others that are tied, can lower the number of poles further.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Order {
    /// Number of finite poles of s Y(s): the modes (state variables) that the network adds to a host with a regular mass matrix.
    pub poles: usize,
    /// Number of finite zeros of s Y(s) (those at s = 0 included).
    pub zeros: usize,
    /// s Y(s) grows as s to this power at high frequency: 2 like an inerter, 1 like a damper, 0 like a spring.
    pub at_infinity: usize,
    /// s Y(s) falls as s to this power at low frequency: 0 like a spring, 1 like a damper, 2 like an inerter.
    pub at_zero: usize,
}

/// Lowest and highest powers of s in N and in D.
#[derive(Clone, Copy)]
struct Powers {
    numerator: (usize, usize),
    denominator: (usize, usize),
}

impl Network {
    /// Number of poles and degrees that generic positive values give.
    #[must_use]
    pub fn order(&self) -> Order {
        let powers = self.powers(&self.tree());
        let ((n0, n1), (d0, d1)) = (powers.numerator, powers.denominator);
        let common = n0.min(d0);
        Order {
            poles: d1 - common,
            zeros: n1 - common,
            at_infinity: n1.saturating_sub(d1),
            at_zero: n0.saturating_sub(d0),
        }
    }

    fn powers(&self, tree: &Tree<usize>) -> Powers {
        let children = match tree {
            Tree::Leaf(element) => {
                let power = self
                    .elements
                    .get(*element)
                    .map_or(0, |element| element.element.power());
                return Powers {
                    numerator: (power, power),
                    denominator: (0, 0),
                };
            }
            Tree::Series(children) | Tree::Parallel(children) => children,
        };
        let series = matches!(tree, Tree::Series(_));
        let product = |a: (usize, usize), b: (usize, usize)| (a.0 + b.0, a.1 + b.1);
        let sum = |a: (usize, usize), b: (usize, usize)| (a.0.min(b.0), a.1.max(b.1));
        let join = |a: Powers, b: Powers| {
            let crossed = sum(
                product(a.numerator, b.denominator),
                product(b.numerator, a.denominator),
            );
            if series {
                Powers {
                    numerator: product(a.numerator, b.numerator),
                    denominator: crossed,
                }
            } else {
                Powers {
                    numerator: crossed,
                    denominator: product(a.denominator, b.denominator),
                }
            }
        };
        children
            .iter()
            .map(|child| self.powers(child))
            .reduce(join)
            .unwrap_or(Powers {
                numerator: (0, 0),
                denominator: (0, 0),
            })
    }

    /// Whether a shape is a mass or ends in one.
    #[must_use]
    pub fn contains_mass(&self) -> bool {
        self.shapes.iter().any(|shape| {
            matches!(shape, Shape::Element(element)
                if self.elements.get(*element).is_some_and(|element| element.element == crate::Element::Mass))
        })
    }
}
