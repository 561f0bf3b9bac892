//! Networks that are no tree of series and parallel groups: elements between the nodes of any graph.

use std::collections::BTreeMap;
use std::fmt;

use crate::polynomial::{combined, lowest, product, scaled, size, trimmed};
use crate::{Domain, Element, NodalBranch, Node, RationalFunction};

/// An element between two nodes, with its value.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshElement {
    /// Its name: letter and number.
    pub name: String,
    /// What it is.
    pub element: Element,
    /// Its mechanical value (N/m, N s/m or kg).
    pub value: f64,
    /// The node on the head's side.
    pub from: Node,
    /// The node on the tail's side.
    pub to: Node,
}

/// A two-terminal network over any graph, such as a bridge, which no layout can write.
///
/// Admittance Y(s) = T/(s T') with the polynomial T of spanning trees in the elements' dynamic stiffnesses and T' that
/// of the graph whose terminals are joined (Kirchhoff 1847); terms are positive, so that none cancel.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    /// The elements.
    pub elements: Vec<MeshElement>,
    /// Number of nodes besides the terminals.
    pub internal_nodes: usize,
}

/// N/D of a dynamic stiffness or an admittance, homogeneous.
pub(crate) type Ratio = (Vec<f64>, Vec<f64>);

/// An edge of a graph whose nodes are numbered, 0 the head and 1 the tail.
pub(crate) type Edge = (usize, usize, Ratio);

impl Mesh {
    /// Y(s) of the network.
    #[must_use]
    pub fn admittance(&self) -> RationalFunction {
        let edges = self
            .elements
            .iter()
            .map(|element| {
                let ratio = element_ratio(element.element, element.value);
                (number(element.from), number(element.to), ratio)
            })
            .collect();
        from_ratio(graph_ratio(edges))
    }

    /// The elements between nodes, values in the order of [`Mesh::elements`]: the form that stamping into a host needs.
    #[must_use]
    pub fn branches(&self) -> Vec<NodalBranch> {
        self.elements
            .iter()
            .enumerate()
            .map(|(value, element)| NodalBranch {
                element: element.element,
                from: element.from,
                to: element.to,
                value,
            })
            .collect()
    }
}

impl fmt::Display for Mesh {
    /// `c1: head - 1, k1: 1 - tail …` with internal nodes numbered from 1.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let node = |node: Node| match node {
            Node::Head => "head".to_owned(),
            Node::Tail => "tail".to_owned(),
            Node::Internal(number) => (number + 1).to_string(),
        };
        for (place, element) in self.elements.iter().enumerate() {
            if place > 0 {
                f.write_str(", ")?;
            }
            write!(
                f,
                "{}: {} - {}",
                element.name,
                node(element.from),
                node(element.to)
            )?;
        }
        Ok(())
    }
}

/// Number of a node: head 0, tail 1, internal ones after.
pub(crate) fn number(node: Node) -> usize {
    match node {
        Node::Head => 0,
        Node::Tail => 1,
        Node::Internal(internal) => internal + 2,
    }
}

/// The node of a number.
pub(crate) fn node(number: usize) -> Node {
    match number {
        0 => Node::Head,
        1 => Node::Tail,
        internal => Node::Internal(internal - 2),
    }
}

/// Y of one element: k/s, c or b s.
pub(crate) fn element_ratio(element: Element, value: f64) -> Ratio {
    match element {
        Element::Spring => (vec![value], vec![0.0, 1.0]),
        Element::Damper => (vec![value], vec![1.0]),
        Element::Inerter | Element::Mass => (vec![0.0, value], vec![1.0]),
    }
}

/// Two side by side.
pub(crate) fn beside(a: &Ratio, b: &Ratio) -> Ratio {
    let numerator = combined(&product(&a.0, &b.1), &product(&b.0, &a.1), 1.0);
    balanced((numerator, product(&a.1, &b.1)))
}

/// Two end to end.
pub(crate) fn chained(a: &Ratio, b: &Ratio) -> Ratio {
    let denominator = combined(&product(&a.0, &b.1), &product(&b.0, &a.1), 1.0);
    balanced((product(&a.0, &b.0), denominator))
}

/// Without common powers of s, of size one.
fn balanced((n, d): Ratio) -> Ratio {
    let common = lowest(&n).unwrap_or(0).min(lowest(&d).unwrap_or(0));
    let weight = size(&n) + size(&d);
    let clean = |coefficients: Vec<f64>| {
        let kept = coefficients.iter().skip(common).copied().collect();
        if weight.is_normal() {
            trimmed(scaled(&trimmed(kept), 1.0 / weight))
        } else {
            trimmed(kept)
        }
    };
    (clean(n), clean(d))
}

/// The function of a ratio without common powers of s.
pub(crate) fn from_ratio(ratio: Ratio) -> RationalFunction {
    let (numerator, denominator) = balanced(ratio);
    RationalFunction {
        numerator,
        denominator,
    }
}

/// Y between nodes 0 and 1 of a graph of two-terminal networks.
pub(crate) fn graph_ratio(edges: Vec<Edge>) -> Ratio {
    let edges = reduced(edges);
    let apart = trees(edges.clone());
    let joined = trees(
        edges
            .into_iter()
            .map(|(a, b, ratio)| {
                (
                    if a == 1 { 0 } else { a },
                    if b == 1 { 0 } else { b },
                    ratio,
                )
            })
            .collect(),
    );
    balanced((apart, joined))
}

/// Series and parallel groups taken together as long as there are any.
fn reduced(mut edges: Vec<Edge>) -> Vec<Edge> {
    loop {
        edges.retain(|(a, b, _)| a != b);
        let parallel = (0..edges.len()).find_map(|i| {
            let (a, b, _) = edges.get(i)?;
            let other = edges
                .iter()
                .skip(i + 1)
                .position(|(c, d, _)| (a, b) == (c, d) || (a, b) == (d, c))?;
            Some((i, i + 1 + other))
        });
        if let Some((i, j)) = parallel {
            let (_, _, second) = edges.remove(j);
            if let Some((_, _, first)) = edges.get_mut(i) {
                *first = beside(first, &second);
            }
            continue;
        }
        let top = edges.iter().map(|(a, b, _)| *a.max(b)).max().unwrap_or(0);
        let series = (2..=top).find_map(|node| {
            let at: Vec<usize> = edges
                .iter()
                .enumerate()
                .filter(|(_, (a, b, _))| *a == node || *b == node)
                .map(|(place, _)| place)
                .collect();
            match at.as_slice() {
                [i] => Some((node, *i, None)),
                [i, j] => Some((node, *i, Some(*j))),
                _ => None,
            }
        });
        match series {
            None => return edges,
            // A branch that leads nowhere.
            Some((_, i, None)) => {
                edges.remove(i);
            }
            Some((node, i, Some(j))) => {
                let second = edges.remove(j);
                let first = edges.remove(i);
                let far = |edge: &Edge| if edge.0 == node { edge.1 } else { edge.0 };
                edges.push((far(&first), far(&second), chained(&first.2, &second.2)));
            }
        }
    }
}

/// Sum over spanning trees of the product of N of the tree's edges and D of the others.
///
/// Edges are taken one by one, in or out; what counts of the past is how the nodes that still have edges to come are joined,
/// and sums are kept for each such partition. Nodes are finished in the order of fewest open edges, so that partitions
/// stay small; every sum has positive terms.
fn trees(mut edges: Vec<Edge>) -> Vec<f64> {
    // Loops are in no tree.
    let mut factor = vec![1.0];
    edges.retain(|(a, b, ratio)| {
        if a == b {
            factor = product(&factor, &ratio.1);
        }
        a != b
    });
    // Of each partition the nodes with the number of their block, and the sum.
    let mut states: States = BTreeMap::from([(Vec::new(), factor)]);
    let mut open: Vec<usize> = Vec::new();
    while !edges.is_empty() {
        let count = |node: usize| {
            edges
                .iter()
                .filter(|(a, b, _)| *a == node || *b == node)
                .count()
        };
        let mut candidates = open.clone();
        if candidates.is_empty() {
            candidates.extend(edges.iter().flat_map(|(a, b, _)| [*a, *b]));
        }
        let Some(node) = candidates.into_iter().min_by_key(|node| count(*node)) else {
            break;
        };
        let (taken, left): (Vec<Edge>, Vec<Edge>) = edges
            .into_iter()
            .partition(|(a, b, _)| *a == node || *b == node);
        edges = left;
        for (a, b, ratio) in taken {
            for end in [a, b] {
                if !open.contains(&end) {
                    open.push(end);
                    states = entered(states, end);
                }
            }
            states = decided(states, a, b, &ratio);
        }
        let done: Vec<usize> = open
            .iter()
            .copied()
            .filter(|node| !edges.iter().any(|(a, b, _)| a == node || b == node))
            .collect();
        for node in done {
            open.retain(|other| *other != node);
            states = left_behind(states, node, open.is_empty());
        }
    }
    states
        .into_values()
        .reduce(|a, b| combined(&a, &b, 1.0))
        .unwrap_or_else(|| vec![0.0])
}

type States = BTreeMap<Vec<(usize, usize)>, Vec<f64>>;

/// A node alone in its block.
fn entered(states: States, node: usize) -> States {
    states
        .into_iter()
        .map(|(mut state, sum)| {
            let block = state.iter().map(|(_, block)| block + 1).max().unwrap_or(0);
            state.push((node, block));
            (numbered(state), sum)
        })
        .collect()
}

/// An edge in or out.
fn decided(states: States, a: usize, b: usize, ratio: &Ratio) -> States {
    let mut next = States::new();
    let mut add = |state: Vec<(usize, usize)>, sum: Vec<f64>| {
        let entry = next.entry(state).or_default();
        *entry = combined(entry, &sum, 1.0);
    };
    for (state, sum) in states {
        let block = |node: usize| {
            state
                .iter()
                .find(|(other, _)| *other == node)
                .map(|(_, block)| *block)
        };
        if let (Some(x), Some(y)) = (block(a), block(b))
            && x != y
        {
            let joined = state
                .iter()
                .map(|(node, block)| (*node, if *block == x { y } else { *block }))
                .collect();
            add(numbered(joined), product(&sum, &ratio.0));
        }
        add(state, product(&sum, &ratio.1));
    }
    next
}

/// A node without edges to come; its block must have another such node, unless it is the last.
fn left_behind(states: States, node: usize, last: bool) -> States {
    let mut next = States::new();
    for (mut state, sum) in states {
        let block = state
            .iter()
            .find(|(other, _)| *other == node)
            .map(|(_, block)| *block);
        state.retain(|(other, _)| *other != node);
        if last || state.iter().any(|(_, other)| Some(*other) == block) {
            let entry = next.entry(numbered(state)).or_default();
            *entry = combined(entry, &sum, 1.0);
        }
    }
    next
}

/// Nodes in order, blocks numbered as they come.
fn numbered(mut state: Vec<(usize, usize)>) -> Vec<(usize, usize)> {
    state.sort_unstable();
    let mut seen: Vec<usize> = Vec::new();
    for (_, block) in &mut state {
        let place = seen
            .iter()
            .position(|known| known == block)
            .unwrap_or_else(|| {
                seen.push(*block);
                seen.len() - 1
            });
        *block = place;
    }
    state
}

/// Names of elements in order: `k1`, `c1`, `k2` …
pub(crate) struct Names {
    next: [usize; 4],
}

impl Names {
    pub(crate) const fn new() -> Self {
        Self { next: [1; 4] }
    }

    pub(crate) fn next(&mut self, element: Element) -> String {
        let letter = Domain::Translational.letter(element).unwrap_or('m');
        let place = match element {
            Element::Spring => 0,
            Element::Damper => 1,
            Element::Inerter => 2,
            Element::Mass => 3,
        };
        let mut number = 1;
        if let Some(next) = self.next.get_mut(place) {
            number = *next;
            *next += 1;
        }
        format!("{letter}{number}")
    }
}
