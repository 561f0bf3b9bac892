//! The nodal form of a device whose elements need not be linear.

use std::collections::BTreeMap;

use crate::kind::{Branch, CustomElement, Kind};
use crate::{Component, Domain, Element, Layout, Network, NetworkElement, NetworkError, Node};

/// How an element's force follows from its relative displacement x.
#[derive(Debug, Clone, PartialEq)]
pub enum Law {
    /// k x, c x', b x'' or m x''.
    Linear(NetworkElement),
    /// A declared function of x and x'.
    Custom(CustomElement),
}

impl Law {
    /// Whether the force depends on the relative displacement.
    #[must_use]
    pub fn is_spring_like(&self) -> bool {
        match self {
            Self::Linear(element) => element.element == Element::Spring,
            Self::Custom(custom) => custom.displacement,
        }
    }

    /// Whether the force depends on the rate of the relative displacement.
    #[must_use]
    pub fn is_damper_like(&self) -> bool {
        match self {
            Self::Linear(element) => element.element == Element::Damper,
            Self::Custom(custom) => custom.rate,
        }
    }

    /// Whether the force depends on the relative acceleration.
    #[must_use]
    pub fn is_inertial(&self) -> bool {
        matches!(self, Self::Linear(element) if element.element.power() == 2)
    }
}

/// An element between two nodes; its relative displacement is x = x(from) - x(to).
#[derive(Debug, Clone, PartialEq)]
pub struct MechanismElement {
    /// The name: `k1`, `gas`, or `pipe1.I` within a component.
    pub name: String,
    /// How its force follows from its motion.
    pub law: Law,
    /// The node on the head's side.
    pub from: Node,
    /// The node on the tail's side.
    pub to: Node,
}

/// A device as elements between nodes, linear or not: what a simulation in time needs.
///
/// The order of elements is that of [`Network::elements`] for a layout without nonlinear elements.
///
/// ```
/// use quell_network::{Domain, Kinds, Layout, Mechanism};
/// let mut kinds = Kinds::new(Domain::Translational);
/// kinds.declare_custom("gas", true, false)?;
/// let layout = Layout::parse("gas | (c1 + b1)", &kinds).unwrap();
/// let mechanism = Mechanism::from_layout(&layout, None)?;
/// assert_eq!(mechanism.internal_nodes(), 1);
/// assert!(mechanism.elements()[0].law.is_spring_like());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Mechanism {
    elements: Vec<MechanismElement>,
    internal_nodes: usize,
    parts: BTreeMap<String, (Node, Node)>,
}

impl Mechanism {
    /// The nodal form of a layout of linear and nonlinear elements; `piston_area` as in [`Network::from_layout`].
    ///
    /// # Errors
    /// As [`Network::from_layout`], save that nonlinear elements are welcome in mechanical layouts.
    pub fn from_layout(layout: &Layout, piston_area: Option<f64>) -> Result<Self, NetworkError> {
        Self::with_components(layout, &[], piston_area)
    }

    /// The nodal form of a layout whose components are given.
    ///
    /// # Errors
    /// As [`Mechanism::from_layout`], and those of components.
    pub fn with_components(
        layout: &Layout,
        components: &[Component],
        piston_area: Option<f64>,
    ) -> Result<Self, NetworkError> {
        let custom: BTreeMap<&str, &CustomElement> = layout
            .branches()
            .filter_map(|branch| match &branch.kind {
                Kind::Custom(custom) => Some((branch.name.as_str(), custom)),
                _ => None,
            })
            .collect();
        if let (Some(branch), false) = (
            custom.keys().next(),
            matches!(layout.domain(), Domain::Translational | Domain::Rotational),
        ) {
            return Err(NetworkError::NotMechanical {
                branch: (*branch).to_owned(),
                domain: layout.domain(),
            });
        }
        // Springs in the places of nonlinear elements: where nodes are does not depend on the laws.
        let stand_in = Layout {
            domain: layout.domain(),
            tree: layout.tree().map(&mut |branch: &Branch| match branch.kind {
                Kind::Custom(_) => Branch {
                    kind: Kind::Element(Element::Spring),
                    ..branch.clone()
                },
                _ => branch.clone(),
            }),
        };
        let network = Network::with_components(&stand_in, piston_area, |name| {
            components
                .iter()
                .find(|component| component.name == name)
                .map(|component| &component.layout)
        })?;
        let mut mechanism = Self::from(&network);
        for element in &mut mechanism.elements {
            if let Some(known) = custom.get(element.name.as_str()) {
                element.law = Law::Custom((*known).clone());
            }
        }
        Ok(mechanism)
    }

    /// The elements.
    #[must_use]
    pub fn elements(&self) -> &[MechanismElement] {
        &self.elements
    }

    /// Place of a named element.
    #[must_use]
    pub fn element_index(&self, name: &str) -> Option<usize> {
        self.elements
            .iter()
            .position(|element| element.name == name)
    }

    /// Number of nodes within the device.
    #[must_use]
    pub const fn internal_nodes(&self) -> usize {
        self.internal_nodes
    }

    /// The two nodes of every named part (element or instance of a component).
    #[must_use]
    pub const fn parts(&self) -> &BTreeMap<String, (Node, Node)> {
        &self.parts
    }

    /// Whether every element is linear.
    #[must_use]
    pub fn is_linear(&self) -> bool {
        self.elements
            .iter()
            .all(|element| matches!(element.law, Law::Linear(_)))
    }

    /// Whether one of the elements is a mass, so that the tail is the inertial frame.
    #[must_use]
    pub fn contains_mass(&self) -> bool {
        self.elements.iter().any(
            |element| matches!(&element.law, Law::Linear(linear) if linear.element == Element::Mass),
        )
    }
}

impl From<&Network> for Mechanism {
    fn from(network: &Network) -> Self {
        let nodal = network.nodal();
        let elements = nodal
            .branches
            .iter()
            .filter_map(|branch| {
                let element = network.elements().get(branch.value)?;
                Some(MechanismElement {
                    name: element.name.clone(),
                    law: Law::Linear(element.clone()),
                    from: branch.from,
                    to: branch.to,
                })
            })
            .collect();
        Self {
            elements,
            internal_nodes: nodal.internal_nodes,
            parts: nodal.parts,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Budget, Enumeration, Equivalence, Kinds};

    fn kinds() -> Kinds {
        let mut kinds = Kinds::new(Domain::Translational);
        kinds.declare_custom("gas", true, false).unwrap();
        kinds.declare_custom("oil", false, true).unwrap();
        kinds
    }

    #[test]
    fn laws_know_what_they_depend_on() {
        let layout = Layout::parse("(gas | oil2) + b1", &kinds()).unwrap();
        let mechanism = Mechanism::from_layout(&layout, None).unwrap();
        let like: Vec<(bool, bool, bool)> = mechanism
            .elements()
            .iter()
            .map(|element| {
                let law = &element.law;
                (
                    law.is_spring_like(),
                    law.is_damper_like(),
                    law.is_inertial(),
                )
            })
            .collect();
        assert_eq!(
            like,
            [
                (true, false, false),
                (false, true, false),
                (false, false, true)
            ]
        );
        assert_eq!(mechanism.elements()[1].from, Node::Head);
        assert_eq!(mechanism.elements()[1].to, Node::Internal(0));
        assert!(!mechanism.is_linear());
    }

    #[test]
    fn linear_functions_refuse_in_words() {
        let layout = Layout::parse("gas | c1", &kinds()).unwrap();
        let error = Network::from_layout(&layout, None).unwrap_err();
        assert!(error.to_string().contains("`gas` is nonlinear"), "{error}");
        let error = layout.dual().unwrap_err();
        assert!(error.to_string().contains("`gas` is nonlinear"), "{error}");
        let mut hydraulic = Kinds::new(Domain::Hydraulic);
        hydraulic.declare_custom("gas", true, false).unwrap();
        let layout = Layout::parse("gas | R1", &hydraulic).unwrap();
        let error = Mechanism::from_layout(&layout, Some(0.1)).unwrap_err();
        assert!(error.to_string().contains("hydraulic"), "{error}");
        assert!(
            Kinds::new(Domain::Translational)
                .declare_custom("lump", false, false)
                .is_err()
        );
    }

    #[test]
    fn laws_of_one_kind_are_not_merged() {
        let layout = Layout::parse("gas1 | gas2 | k1 | k2", &kinds()).unwrap();
        assert_eq!(layout.merge_like().layout.to_string(), "gas1 | gas2 | k1");
        let budgets = [Budget::exactly("gas", 2), Budget::exactly("k", 1)];
        let all = Enumeration::new(&kinds(), &budgets, None, Equivalence::Irreducible).unwrap();
        // All eight of three branches, but two of them alike: of (a, a, b) there are 6 (Riordan and Shannon 1942).
        assert_eq!(all.count(), 6);
    }
}
