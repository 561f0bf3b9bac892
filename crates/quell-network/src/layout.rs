//! Layouts: trees of named branches in a domain.

use std::collections::HashSet;
use std::fmt;
use std::hash::{Hash, Hasher};

use quell_expression::Span;

use crate::kind::{Branch, Kind, Kinds};
use crate::order::{canonical_tree, named_tree};
use crate::{Domain, Element, Tree};

/// Why a text is not a layout, and where.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct LayoutError {
    /// The bytes of the text at fault.
    pub span: Span,
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    pub help: Option<String>,
}

/// Series (`+`, binds tighter) and parallel (`|`) groups over named branches, in a domain.
///
/// The order in which a user wrote the branches is kept; two layouts are equal (`==`) when they differ only in the
/// order of branches within groups. The tree is always normal (see [`Tree`]), names are unique.
///
/// ```
/// use quell_network::{Domain, Kinds, Layout};
/// let layout = Layout::parse("k1 | (c1 + b1)", &Kinds::new(Domain::Translational)).unwrap();
/// assert_eq!(layout.to_string(), "k1 | c1 + b1");
/// ```
#[derive(Debug, Clone)]
pub struct Layout {
    pub(crate) domain: Domain,
    pub(crate) tree: Tree<Branch>,
}

impl Layout {
    /// Reads a layout such as `k1 | c1 + b1`.
    ///
    /// # Errors
    /// Points at the character or name at fault: syntax, unknown kind, a name used twice, groups nested too deeply.
    pub fn parse(text: &str, kinds: &Kinds) -> Result<Self, LayoutError> {
        crate::parse::parse(text, kinds)
    }

    /// A layout from a tree of branches; none if the tree is empty or a name occurs twice.
    #[must_use]
    pub fn from_tree(domain: Domain, tree: Tree<Branch>) -> Option<Self> {
        let tree = tree.flattened()?;
        let mut names = HashSet::new();
        if tree
            .leaves()
            .all(|branch| names.insert(branch.name.as_str()))
        {
            Some(Self { domain, tree })
        } else {
            None
        }
    }

    /// The domain in whose letters and groups the layout is written.
    #[must_use]
    pub const fn domain(&self) -> Domain {
        self.domain
    }

    /// The tree in the user's order.
    #[must_use]
    pub const fn tree(&self) -> &Tree<Branch> {
        &self.tree
    }

    /// The branches from left to right.
    pub fn branches(&self) -> impl Iterator<Item = &Branch> {
        self.tree.leaves()
    }

    /// The branch of a name.
    #[must_use]
    pub fn branch(&self, name: &str) -> Option<&Branch> {
        self.branches().find(|branch| branch.name == name)
    }

    /// Whether any branch is a mass.
    #[must_use]
    pub fn contains_mass(&self) -> bool {
        self.branches()
            .any(|branch| branch.kind == Kind::Element(Element::Mass))
    }

    /// The same layout with every group in canonical order.
    ///
    /// Within a group the order is by number of branches, then by what the child is made of (its kinds sorted, compared
    /// one by one: letters in the order of [`Domain::letters`], then declared kinds in order of declaration), then by
    /// the children's own children in the same order; names (numbers compared as numbers) decide only between children
    /// that are otherwise alike. [`crate::Enumeration`] lists layouts in this form.
    #[must_use]
    pub fn canonical(&self) -> Self {
        Self {
            domain: self.domain,
            tree: canonical_tree(&self.tree),
        }
    }

    /// Whether both are the same layout up to the order of branches within groups (the same as `==`).
    #[must_use]
    pub fn equivalent(&self, other: &Self) -> bool {
        self == other
    }
}

impl PartialEq for Layout {
    fn eq(&self, other: &Self) -> bool {
        self.domain == other.domain && named_tree(&self.tree) == named_tree(&other.tree)
    }
}

impl Eq for Layout {}

impl Hash for Layout {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.domain.hash(state);
        named_tree(&self.tree).hash(state);
    }
}

impl fmt::Display for Layout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_tree(&self.tree, f)
    }
}

/// Writes the tree with the fewest parentheses: only a parallel group within a series group needs them.
fn write_tree(tree: &Tree<Branch>, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    match tree {
        Tree::Leaf(branch) => f.write_str(&branch.name),
        Tree::Series(children) => {
            for (index, child) in children.iter().enumerate() {
                if index > 0 {
                    f.write_str(" + ")?;
                }
                if matches!(child, Tree::Parallel(_)) {
                    f.write_str("(")?;
                    write_tree(child, f)?;
                    f.write_str(")")?;
                } else {
                    write_tree(child, f)?;
                }
            }
            Ok(())
        }
        Tree::Parallel(children) => {
            for (index, child) in children.iter().enumerate() {
                if index > 0 {
                    f.write_str(" | ")?;
                }
                write_tree(child, f)?;
            }
            Ok(())
        }
    }
}
