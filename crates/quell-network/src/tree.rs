//! Trees of series and parallel groups.

/// A two-terminal series-parallel network over leaves of any kind.
///
/// A tree is *normal* when every group has at least two children and none is of its parent's kind; [`Tree::flattened`]
/// makes it so.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Tree<T> {
    /// One branch.
    Leaf(T),
    /// Children end to end, one force; the first touches the head terminal, the last the tail terminal.
    Series(Vec<Tree<T>>),
    /// Children side by side, one relative displacement.
    Parallel(Vec<Tree<T>>),
}

impl<T> Tree<T> {
    /// The leaves from left to right.
    pub fn leaves(&self) -> impl Iterator<Item = &T> {
        let mut pending = vec![self];
        std::iter::from_fn(move || {
            while let Some(tree) = pending.pop() {
                match tree {
                    Self::Leaf(leaf) => return Some(leaf),
                    Self::Series(children) | Self::Parallel(children) => {
                        pending.extend(children.iter().rev());
                    }
                }
            }
            None
        })
    }

    /// Number of leaves.
    #[must_use]
    pub fn branches(&self) -> usize {
        self.leaves().count()
    }

    /// The children of a group, none for a leaf.
    #[must_use]
    pub fn children(&self) -> &[Self] {
        match self {
            Self::Leaf(_) => &[],
            Self::Series(children) | Self::Parallel(children) => children,
        }
    }

    /// The same tree with every leaf replaced.
    pub fn map<U>(&self, leaf: &mut impl FnMut(&T) -> U) -> Tree<U> {
        match self {
            Self::Leaf(value) => Tree::Leaf(leaf(value)),
            Self::Series(children) => {
                Tree::Series(children.iter().map(|child| child.map(leaf)).collect())
            }
            Self::Parallel(children) => {
                Tree::Parallel(children.iter().map(|child| child.map(leaf)).collect())
            }
        }
    }

    /// The same network as a normal tree: groups within a like group dissolve into it, a group of one is its child.
    ///
    /// An empty group, which has no meaning, vanishes; none is left only if the whole tree is empty.
    #[must_use]
    pub fn flattened(self) -> Option<Self> {
        let (series, children) = match self {
            Self::Leaf(_) => return Some(self),
            Self::Series(children) => (true, children),
            Self::Parallel(children) => (false, children),
        };
        let mut flat = Vec::with_capacity(children.len());
        for child in children.into_iter().filter_map(Self::flattened) {
            match child {
                Self::Series(inner) if series => flat.extend(inner),
                Self::Parallel(inner) if !series => flat.extend(inner),
                other => flat.push(other),
            }
        }
        if flat.len() < 2 {
            flat.pop()
        } else if series {
            Some(Self::Series(flat))
        } else {
            Some(Self::Parallel(flat))
        }
    }
}
