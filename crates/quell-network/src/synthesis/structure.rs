//! What a synthesis yields: groups, bridges and levers, with values.

use std::fmt;

use crate::kind::Kinds;
use crate::mesh::{Names, Ratio, beside, chained, element_ratio, from_ratio, graph_ratio, node};
use crate::polynomial::{combined, product, scaled};
use crate::{Domain, Element, Layout, Mesh, MeshElement, RationalFunction, Tree};

/// A two-terminal network with mechanical values.
#[derive(Debug, Clone, PartialEq)]
pub enum Structure {
    /// One element.
    Element(Element, f64),
    /// End to end, one force.
    Series(Vec<Structure>),
    /// Side by side, one relative displacement.
    Parallel(Vec<Structure>),
    /// Networks between the nodes of a graph; node 0 is the head, 1 the tail.
    Graph(Vec<(usize, usize, Structure)>),
    /// A section of Brune's with its lever.
    Lever(Box<LeverSection>),
}

/// Brune's section: an inerter C and, above it, a spring and an ideal lever, which drives what follows.
///
/// With terminal velocity v, velocity u of what follows and velocity w across the inerter, u - w = n (v - w) with the
/// lever's ratio n; the spring acts across v - w. Brune's coupled coils L_p = 1/k, M = n/k, L_s = n²/k are this spring and
/// this lever. Impedance Z = ((1 - n)²/(k b) + z11 Z_r)/(z22 + Z_r), with z11 = s/k + 1/(b s) and z22 = n² s/k + 1/(b s).
#[derive(Debug, Clone, PartialEq)]
pub struct LeverSection {
    /// Stiffness across the lever's driving side (N/m).
    pub stiffness: f64,
    /// The lever's ratio n > 0.
    pub ratio: f64,
    /// The inerter common to both sides (kg).
    pub inertance: f64,
    /// What the lever drives.
    pub rest: Structure,
}

/// How many elements of each kind a structure has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, PartialOrd, Ord, Hash)]
pub struct Elements {
    /// Springs.
    pub springs: usize,
    /// Dampers.
    pub dampers: usize,
    /// Inerters.
    pub inerters: usize,
    /// Levers (ideal transformers).
    pub levers: usize,
}

impl Elements {
    /// Springs, dampers and inerters together.
    #[must_use]
    pub const fn total(&self) -> usize {
        self.springs + self.dampers + self.inerters
    }

    /// Springs and inerters: the elements that store energy.
    #[must_use]
    pub const fn reactive(&self) -> usize {
        self.springs + self.inerters
    }
}

impl fmt::Display for Elements {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}k {}c {}b", self.springs, self.dampers, self.inerters)?;
        match self.levers {
            0 => Ok(()),
            1 => f.write_str(" and 1 lever"),
            levers => write!(f, " and {levers} levers"),
        }
    }
}

impl Structure {
    /// A group of one is its child.
    pub(crate) fn group(series: bool, mut children: Vec<Self>) -> Self {
        if children.len() == 1
            && let Some(only) = children.pop()
        {
            return only;
        }
        if series {
            Self::Series(children)
        } else {
            Self::Parallel(children)
        }
    }

    /// The structure whose impedance is, as a number in SI units, this one's admittance over `factor`; none where a
    /// lever or an unknown graph is inside.
    pub(crate) fn dual(&self, factor: f64) -> Option<Self> {
        let all = |children: &[Self]| {
            children
                .iter()
                .map(|child| child.dual(factor))
                .collect::<Option<Vec<_>>>()
        };
        match self {
            Self::Element(element, value) => Some(Self::Element(element.dual()?, factor / value)),
            Self::Series(children) => Some(Self::Parallel(all(children)?)),
            Self::Parallel(children) => Some(Self::Series(all(children)?)),
            Self::Graph(edges) => super::bott_duffin::dual_graph(edges, factor),
            Self::Lever(_) => None,
        }
    }

    /// With admittance Y0 Y(s/ω0).
    pub(crate) fn rescaled(&self, size: f64, frequency: f64) -> Self {
        let all = |children: &[Self]| -> Vec<Self> {
            children
                .iter()
                .map(|child| child.rescaled(size, frequency))
                .collect()
        };
        match self {
            Self::Element(element, value) => {
                let factor = match element {
                    Element::Spring => size * frequency,
                    Element::Damper => size,
                    Element::Inerter | Element::Mass => size / frequency,
                };
                Self::Element(*element, value * factor)
            }
            Self::Series(children) => Self::Series(all(children)),
            Self::Parallel(children) => Self::Parallel(all(children)),
            Self::Graph(edges) => Self::Graph(
                edges
                    .iter()
                    .map(|(a, b, child)| (*a, *b, child.rescaled(size, frequency)))
                    .collect(),
            ),
            Self::Lever(section) => Self::Lever(Box::new(LeverSection {
                stiffness: section.stiffness * size * frequency,
                ratio: section.ratio,
                inertance: section.inertance * size / frequency,
                rest: section.rest.rescaled(size, frequency),
            })),
        }
    }

    /// Y(s), computed from the elements: sums and products of positive terms, nothing subtracted.
    #[must_use]
    pub fn admittance(&self) -> RationalFunction {
        from_ratio(self.ratio())
    }

    fn ratio(&self) -> Ratio {
        let none = (vec![0.0], vec![1.0]);
        match self {
            Self::Element(element, value) => element_ratio(*element, *value),
            Self::Series(children) => children
                .iter()
                .map(Self::ratio)
                .reduce(|a, b| chained(&a, &b))
                .unwrap_or(none),
            Self::Parallel(children) => children
                .iter()
                .map(Self::ratio)
                .reduce(|a, b| beside(&a, &b))
                .unwrap_or(none),
            Self::Graph(edges) => graph_ratio(
                edges
                    .iter()
                    .map(|(a, b, child)| (*a, *b, child.ratio()))
                    .collect(),
            ),
            Self::Lever(section) => {
                let (compliance, inverse) = (1.0 / section.stiffness, 1.0 / section.inertance);
                let n = section.ratio;
                // s z11 and s z22; Y = (s z22 N + s D)/(s det N + s z11 D) of the rest's impedance D/N.
                let first = [inverse, 0.0, compliance];
                let second = [inverse, 0.0, n * n * compliance];
                let determinant = (1.0 - n) * (1.0 - n) * compliance * inverse;
                let (numerator, denominator) = section.rest.ratio();
                let shifted = |a: &[f64]| product(a, &[0.0, 1.0]);
                (
                    combined(&product(&second, &numerator), &shifted(&denominator), 1.0),
                    combined(
                        &scaled(&shifted(&numerator), determinant),
                        &product(&first, &denominator),
                        1.0,
                    ),
                )
            }
        }
    }

    /// How many elements of each kind.
    #[must_use]
    pub fn elements(&self) -> Elements {
        let mut counts = Elements::default();
        self.count(&mut counts);
        counts
    }

    fn count(&self, counts: &mut Elements) {
        match self {
            Self::Element(Element::Spring, _) => counts.springs += 1,
            Self::Element(Element::Damper, _) => counts.dampers += 1,
            Self::Element(..) => counts.inerters += 1,
            Self::Series(children) | Self::Parallel(children) => {
                for child in children {
                    child.count(counts);
                }
            }
            Self::Graph(edges) => {
                for (_, _, child) in edges {
                    child.count(counts);
                }
            }
            Self::Lever(section) => {
                counts.springs += 1;
                counts.inerters += 1;
                counts.levers += 1;
                section.rest.count(counts);
            }
        }
    }

    /// Whether the structure is a tree of series and parallel groups.
    #[must_use]
    pub fn is_series_parallel(&self) -> bool {
        match self {
            Self::Element(..) => true,
            Self::Series(children) | Self::Parallel(children) => {
                children.iter().all(Self::is_series_parallel)
            }
            Self::Graph(_) | Self::Lever(_) => false,
        }
    }

    /// The layout (`k1 | c1 + b1` …) with its mechanical values from left to right; none where there is a bridge or a
    /// lever.
    #[must_use]
    pub fn layout(&self) -> Option<(Layout, Vec<f64>)> {
        let tree = self.tree()?.flattened()?;
        let kinds = Kinds::new(Domain::Translational);
        let mut names = Names::new();
        let mut missing = false;
        let values = tree.leaves().map(|(_, value)| *value).collect();
        let tree = tree.map(&mut |(element, _)| {
            let branch = kinds.branch(&names.next(*element));
            missing |= branch.is_none();
            branch
        });
        if missing {
            return None;
        }
        let tree = present(&tree)?;
        Some((Layout::from_tree(Domain::Translational, tree)?, values))
    }

    /// Every value by the name that the printed structure gives it, in its order; a lever's ratio is `n`.
    #[must_use]
    pub fn values(&self) -> Vec<(String, f64)> {
        let mut values = Vec::new();
        self.name_values(&mut Names::new(), &mut values);
        values
    }

    fn name_values(&self, names: &mut Names, values: &mut Vec<(String, f64)>) {
        match self {
            Self::Element(element, value) => values.push((names.next(*element), *value)),
            Self::Series(children) | Self::Parallel(children) => {
                for child in children {
                    child.name_values(names, values);
                }
            }
            Self::Graph(edges) => {
                for (_, _, child) in edges {
                    child.name_values(names, values);
                }
            }
            Self::Lever(section) => {
                values.push((names.next(Element::Spring), section.stiffness));
                values.push((names.next(Element::Inerter), section.inertance));
                values.push(("n".to_owned(), section.ratio));
                section.rest.name_values(names, values);
            }
        }
    }

    fn tree(&self) -> Option<Tree<(Element, f64)>> {
        let all = |children: &[Self]| children.iter().map(Self::tree).collect::<Option<Vec<_>>>();
        match self {
            Self::Element(element, value) => Some(Tree::Leaf((*element, *value))),
            Self::Series(children) => Some(Tree::Series(all(children)?)),
            Self::Parallel(children) => Some(Tree::Parallel(all(children)?)),
            Self::Graph(_) | Self::Lever(_) => None,
        }
    }

    /// The elements between nodes; none where there is a lever.
    #[must_use]
    pub fn mesh(&self) -> Option<Mesh> {
        let mut mesh = Mesh {
            elements: Vec::new(),
            internal_nodes: 0,
        };
        self.place(0, 1, &mut Names::new(), &mut mesh)?;
        Some(mesh)
    }

    fn place(&self, from: usize, to: usize, names: &mut Names, mesh: &mut Mesh) -> Option<()> {
        match self {
            Self::Element(element, value) => mesh.elements.push(MeshElement {
                name: names.next(*element),
                element: *element,
                value: *value,
                from: node(from),
                to: node(to),
            }),
            Self::Parallel(children) => {
                for child in children {
                    child.place(from, to, names, mesh)?;
                }
            }
            Self::Series(children) => {
                let mut start = from;
                for (place, child) in children.iter().enumerate() {
                    let end = if place + 1 == children.len() {
                        to
                    } else {
                        mesh.internal_nodes += 1;
                        mesh.internal_nodes + 1
                    };
                    child.place(start, end, names, mesh)?;
                    start = end;
                }
            }
            Self::Graph(edges) => {
                let top = edges.iter().map(|(a, b, _)| *a.max(b)).max().unwrap_or(1);
                let first = mesh.internal_nodes;
                mesh.internal_nodes += top.saturating_sub(1);
                let outer = |inner: usize| match inner {
                    0 => from,
                    1 => to,
                    inner => inner + first,
                };
                for (a, b, child) in edges {
                    child.place(outer(*a), outer(*b), names, mesh)?;
                }
            }
            Self::Lever(_) => return None,
        }
        Some(())
    }

    fn write(&self, names: &mut Names, inside: bool, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let joined =
            |children: &[Self], between: &str, names: &mut Names, f: &mut fmt::Formatter<'_>| {
                for (place, child) in children.iter().enumerate() {
                    if place > 0 {
                        f.write_str(between)?;
                    }
                    child.write(names, between == " + ", f)?;
                }
                Ok(())
            };
        match self {
            Self::Element(element, _) => f.write_str(&names.next(*element)),
            Self::Series(children) => joined(children, " + ", names, f),
            Self::Parallel(children) => {
                if inside {
                    f.write_str("(")?;
                }
                joined(children, " | ", names, f)?;
                if inside { f.write_str(")") } else { Ok(()) }
            }
            Self::Graph(edges) => {
                f.write_str("bridge[")?;
                for (place, (a, b, child)) in edges.iter().enumerate() {
                    if place > 0 {
                        f.write_str(", ")?;
                    }
                    child.write(names, false, f)?;
                    write!(f, ": {a}-{b}")?;
                }
                f.write_str("]")
            }
            Self::Lever(section) => {
                let spring = names.next(Element::Spring);
                let inerter = names.next(Element::Inerter);
                write!(f, "lever[{spring}, {inerter}, ")?;
                section.rest.write(names, false, f)?;
                f.write_str("]")
            }
        }
    }
}

impl fmt::Display for Structure {
    /// As a layout; a graph as `bridge[c1: 0-2, …]` with nodes 0 (head), 1 (tail) and internal ones; Brune's section as
    /// `lever[k1, b1, rest]`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(&mut Names::new(), false, f)
    }
}

fn present<T: Clone>(tree: &Tree<Option<T>>) -> Option<Tree<T>> {
    let all =
        |children: &[Tree<Option<T>>]| children.iter().map(present).collect::<Option<Vec<_>>>();
    match tree {
        Tree::Leaf(leaf) => leaf.clone().map(Tree::Leaf),
        Tree::Series(children) => Some(Tree::Series(all(children)?)),
        Tree::Parallel(children) => Some(Tree::Parallel(all(children)?)),
    }
}
