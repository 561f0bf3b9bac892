//! What is left of a layout without one of its branches.

use quell_expression::{Dimension, Expression, Quantity, Scope};

use crate::kind::{Branch, Kind};
use crate::{Element, Layout, Tree};

/// In which way a branch goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Gone {
    /// It transmits no force: the mechanical value tends to zero; an open circuit, in its place nothing.
    Free,
    /// It does not yield: the mechanical value tends to infinity; a short circuit, in its place a rigid link.
    Rigid,
}

/// A layout without one of its branches.
#[derive(Debug, Clone, PartialEq)]
pub struct Removal {
    /// The branch that was removed.
    pub branch: String,
    /// How.
    pub how: Gone,
    /// Other branches that have no effect any more: in a chain that is interrupted, or beside a rigid link.
    pub lost: Vec<String>,
    /// What is left, like elements merged; none where the whole device is free or rigid.
    pub layout: Option<Layout>,
    /// Values of the left layout's branches in its order, where values were given (SI, in the layout's domain).
    pub values: Vec<f64>,
}

impl Layout {
    /// The layouts that are left when one branch is removed, each branch in both ways, in the order of branches.
    ///
    /// `values` are those of the branches from left to right (SI, in the layout's domain), or empty. A mass is never made rigid:
    /// that would tie the device to the inertial frame. Removals that leave nothing are left out. Force goes through a
    /// chain of the mechanical network; a hydraulic layout's groups change places (series flow is shared displacement).
    #[must_use]
    pub fn removals(&self, values: &[f64]) -> Vec<Removal> {
        let names: Vec<&str> = self.branches().map(|branch| branch.name.as_str()).collect();
        let scope = Values {
            names: &names,
            values,
        };
        let mut all = Vec::new();
        for branch in self.branches() {
            for how in [Gone::Free, Gone::Rigid] {
                if how == Gone::Rigid && branch.kind == Kind::Element(Element::Mass) {
                    continue;
                }
                let Left::Tree(tree) = self.without(self.tree(), &branch.name, how) else {
                    continue;
                };
                let Some(left) = Self::from_tree(self.domain(), tree) else {
                    continue;
                };
                let lost = names
                    .iter()
                    .filter(|name| **name != branch.name && left.branch(name).is_none())
                    .map(|name| (*name).to_owned())
                    .collect();
                let merged = left.merge_like();
                let value = |name: &str| {
                    let expression = merged.values.iter().find(|(known, _)| known == name);
                    match expression {
                        Some((_, text)) => Expression::parse(text)
                            .ok()
                            .and_then(|expression| expression.evaluate(&scope).ok())
                            .map_or(f64::NAN, |quantity| quantity.value),
                        None => scope.value(name).unwrap_or(f64::NAN),
                    }
                };
                let values = if values.is_empty() {
                    Vec::new()
                } else {
                    merged
                        .layout
                        .branches()
                        .map(|branch| value(&branch.name))
                        .collect()
                };
                all.push(Removal {
                    branch: branch.name.clone(),
                    how,
                    lost,
                    layout: Some(merged.layout),
                    values,
                });
            }
        }
        all
    }

    fn without(&self, tree: &Tree<Branch>, name: &str, how: Gone) -> Left {
        let (series, children) = match tree {
            Tree::Leaf(branch) if branch.name == name => {
                return match how {
                    Gone::Free => Left::Free,
                    Gone::Rigid => Left::Rigid,
                };
            }
            Tree::Leaf(_) => return Left::Tree(tree.clone()),
            Tree::Series(children) => (true, children),
            Tree::Parallel(children) => (false, children),
        };
        // In a chain of the mechanical network a free part frees all and a rigid one goes; side by side it is the reverse.
        let chain = series != self.domain().swaps_groups();
        let mut kept = Vec::with_capacity(children.len());
        for child in children {
            match (self.without(child, name, how), chain) {
                (Left::Free, true) => return Left::Free,
                (Left::Rigid, false) => return Left::Rigid,
                (Left::Rigid, true) | (Left::Free, false) => {}
                (Left::Tree(tree), _) => kept.push(tree),
            }
        }
        if kept.is_empty() {
            return if chain { Left::Rigid } else { Left::Free };
        }
        let group = if series {
            Tree::Series(kept)
        } else {
            Tree::Parallel(kept)
        };
        group.flattened().map_or(Left::Free, Left::Tree)
    }
}

enum Left {
    Tree(Tree<Branch>),
    Free,
    Rigid,
}

/// Values by name, without dimension.
struct Values<'a> {
    names: &'a [&'a str],
    values: &'a [f64],
}

impl Values<'_> {
    fn value(&self, name: &str) -> Option<f64> {
        let place = self.names.iter().position(|known| *known == name)?;
        self.values.get(place).copied()
    }
}

impl Scope for Values<'_> {
    fn quantity(&self, name: &str) -> Option<Quantity> {
        Some(Quantity::new(self.value(name)?, Dimension::NONE))
    }

    fn names(&self) -> Vec<&str> {
        self.names.to_vec()
    }
}
