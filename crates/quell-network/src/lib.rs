//! The algebra of two-terminal networks of springs, dampers, inerters and masses.
//!
//! A [`Layout`] is a tree of series (`+`) and parallel (`|`) groups over named branches, written in the letters of its
//! [`Domain`] (`k c b m`, electrical `R L C`, hydraulic `R I C`); [`Enumeration`] lists layouts, each exactly once.
//! A [`Network`] is the mechanical network that a layout becomes, with numbered elements, ready to be evaluated: dynamic
//! stiffness, its gradient, rational admittance, number of modes, nodal form for stamping.
//! A [`Mechanism`] is the nodal form of a layout that may hold nonlinear elements besides ([`Kinds::declare_custom`]);
//! a layout with such elements is never a [`Network`], so that nothing linear can be asked of it by mistake.
//!
//! Conventions: force F, relative displacement x, admittance Y(s) = F/(s x), dynamic stiffness D(s) = s Y(s) = F/x; SI
//! units throughout; the time factor is e^(jωt).

mod bridge;
mod catalogue;
mod component;
mod degree;
mod element;
mod enumeration;
mod equivalence;
mod gradient;
mod immittance;
mod kind;
mod layout;
mod linear;
mod mechanism;
mod mesh;
mod network;
mod nodal;
mod order;
mod parse;
mod polynomial;
mod positive_real;
mod program;
mod rational;
mod rational_algebra;
mod removal;
mod synthesis;
mod transform;
mod tree;

pub use catalogue::{CATALOGUE, Device, DevicePart, device};
pub use component::{
    Component, ComponentError, ComponentVariable, Expansion, ExpansionWorkspace, Variable, expand,
};
pub use degree::Order;
pub use element::{Domain, Element};
pub use enumeration::{Budget, Enumeration, EnumerationError, Equivalence, Layouts};
pub use equivalence::{
    Counts, LadenheimStructure, counts, immittance_classes, ladenheim_structures, zobel_classes,
};
pub use gradient::PartShare;
pub use immittance::{ImmittanceOrder, PassiveFunctions, is_regular};
pub use kind::{Branch, CustomElement, Kind, KindError, Kinds};
pub use layout::{Layout, LayoutError};
pub use mechanism::{Law, Mechanism, MechanismElement};
pub use mesh::{Mesh, MeshElement};
pub use network::{Network, NetworkElement, NetworkError, Part};
pub use nodal::{Nodal, NodalBranch, Node};
pub use positive_real::{Nearest, NearestError, POSITIVE_REAL_TOLERANCE, Verdict, Violation};
pub use program::{RatioGrid, Workspace};
pub use rational::RationalFunction;
pub use rational_algebra::{RationalError, Scales};
pub use removal::{Gone, Removal};
pub use synthesis::{
    Elements, Form, Joined, LeverSection, Matching, Method, Preamble, REALISATION_TOLERANCE,
    Realisation, Smallest, Structure, SynthesisError, bott_duffin, brune, canonical,
    foster_preamble, reduced_bott_duffin,
};
pub use transform::{Merged, TransformError};
pub use tree::Tree;
