//! The nodal form of a network, for stamping into a host.

use std::collections::BTreeMap;

use crate::network::Shape;
use crate::{Element, Network};

/// A node of a network.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Node {
    /// The first terminal: the port's positive point.
    Head,
    /// The second terminal; of a device that ends in a mass it is the inertial frame.
    Tail,
    /// A massless node inside the device.
    Internal(usize),
}

/// An element between two nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NodalBranch {
    /// What it is.
    pub element: Element,
    /// The node on the head's side.
    pub from: Node,
    /// The node on the tail's side.
    pub to: Node,
    /// Place of its value in the order of the network's elements.
    pub value: usize,
}

/// A network as elements between nodes; series groups introduce internal nodes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Nodal {
    /// Number of internal nodes.
    pub internal_nodes: usize,
    /// Every element with its nodes, in the order of values.
    pub branches: Vec<NodalBranch>,
    /// The two nodes of every named part (element or instance of a component).
    pub parts: BTreeMap<String, (Node, Node)>,
}

impl Network {
    /// The nodal form; a mass must be at the tail ([`crate::Layout::place_mass`]), which is then the inertial frame.
    #[must_use]
    pub fn nodal(&self) -> Nodal {
        let mut ends = vec![(Node::Head, Node::Tail); self.shapes.len()];
        let mut internal_nodes = 0;
        let mut branches: Vec<Option<NodalBranch>> = vec![None; self.elements.len()];
        // Children come before their parents, so that the reverse order hands nodes down.
        for (index, shape) in self.shapes.iter().enumerate().rev() {
            let Some((from, to)) = ends.get(index).copied() else {
                continue;
            };
            match shape {
                Shape::Element(value) => {
                    if let (Some(element), Some(branch)) =
                        (self.elements.get(*value), branches.get_mut(*value))
                    {
                        *branch = Some(NodalBranch {
                            element: element.element,
                            from,
                            to,
                            value: *value,
                        });
                    }
                }
                Shape::Parallel(children) => {
                    for child in children {
                        if let Some(end) = ends.get_mut(*child) {
                            *end = (from, to);
                        }
                    }
                }
                Shape::Series(children) => {
                    let mut start = from;
                    for (place, child) in children.iter().enumerate() {
                        let next = if place + 1 == children.len() {
                            to
                        } else {
                            internal_nodes += 1;
                            Node::Internal(internal_nodes - 1)
                        };
                        if let Some(end) = ends.get_mut(*child) {
                            *end = (start, next);
                        }
                        start = next;
                    }
                }
            }
        }
        let parts = self
            .parts
            .iter()
            .filter_map(|(name, part)| Some((name.clone(), *ends.get(part.shape)?)))
            .collect();
        Nodal {
            internal_nodes,
            branches: branches.into_iter().flatten().collect(),
            parts,
        }
    }
}
