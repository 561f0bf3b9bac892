//! The canonical order of branches within a group.

use std::cmp::Ordering;

use crate::Tree;
use crate::kind::Branch;

/// A canonical subtree with what its comparison needs.
struct Ordered {
    tree: Tree<Branch>,
    /// Ranks of its branches, ascending.
    content: Vec<usize>,
    children: Vec<Ordered>,
    /// Names of its branches from left to right.
    names: Vec<String>,
}

/// The tree with every group in canonical order.
pub(crate) fn canonical_tree(tree: &Tree<Branch>) -> Tree<Branch> {
    ordered(tree).tree
}

/// The tree with every group in the order of the smallest name in each child, whatever the kinds: for comparison.
pub(crate) fn named_tree(tree: &Tree<Branch>) -> Tree<Branch> {
    fn sorted(tree: &Tree<Branch>) -> (Tree<Branch>, String) {
        let (series, children) = match tree {
            Tree::Leaf(branch) => return (tree.clone(), branch.name.clone()),
            Tree::Series(children) => (true, children),
            Tree::Parallel(children) => (false, children),
        };
        let mut children: Vec<(Tree<Branch>, String)> = children.iter().map(sorted).collect();
        children.sort_by(|(_, left), (_, right)| left.cmp(right));
        let smallest = children
            .first()
            .map(|(_, name)| name.clone())
            .unwrap_or_default();
        let children = children.into_iter().map(|(child, _)| child).collect();
        (
            if series {
                Tree::Series(children)
            } else {
                Tree::Parallel(children)
            },
            smallest,
        )
    }
    sorted(tree).0
}

fn ordered(tree: &Tree<Branch>) -> Ordered {
    let series = match tree {
        Tree::Leaf(branch) => {
            return Ordered {
                tree: tree.clone(),
                content: vec![branch.rank],
                children: Vec::new(),
                names: vec![branch.name.clone()],
            };
        }
        Tree::Series(_) => true,
        Tree::Parallel(_) => false,
    };
    let mut children: Vec<Ordered> = tree.children().iter().map(ordered).collect();
    children.sort_by(|left, right| {
        compare(left, right).then_with(|| compare_names(&left.names, &right.names))
    });
    let mut content: Vec<usize> = children
        .iter()
        .flat_map(|child| child.content.iter().copied())
        .collect();
    content.sort_unstable();
    let names = children
        .iter()
        .flat_map(|child| child.names.iter().cloned())
        .collect();
    let trees = children.iter().map(|child| child.tree.clone()).collect();
    let tree = if series {
        Tree::Series(trees)
    } else {
        Tree::Parallel(trees)
    };
    Ordered {
        tree,
        content,
        children,
        names,
    }
}

/// Fewer branches first, then kinds one by one.
fn compare_content(left: &[usize], right: &[usize]) -> Ordering {
    left.len().cmp(&right.len()).then_with(|| left.cmp(right))
}

/// Structure without names; both are children of one group, so they are leaves or groups of one sort.
///
/// Groups of equal content are compared run by run of children of equal content, a longer run of the smaller content
/// first: the order in which the enumeration lists them.
fn compare(left: &Ordered, right: &Ordered) -> Ordering {
    let by_content = compare_content(&left.content, &right.content);
    if by_content != Ordering::Equal {
        return by_content;
    }
    let (mut a, mut b) = (left.children.as_slice(), right.children.as_slice());
    while let (Some(first), Some(second)) = (a.first(), b.first()) {
        let by_content = compare_content(&first.content, &second.content);
        if by_content != Ordering::Equal {
            return by_content;
        }
        let run = |children: &[Ordered]| {
            children
                .iter()
                .take_while(|child| child.content == first.content)
                .count()
        };
        let (run_a, run_b) = (run(a), run(b));
        if run_a != run_b {
            return run_b.cmp(&run_a);
        }
        let ((head_a, tail_a), (head_b, tail_b)) = (a.split_at(run_a), b.split_at(run_b));
        for (x, y) in head_a.iter().zip(head_b) {
            let by_structure = compare(x, y);
            if by_structure != Ordering::Equal {
                return by_structure;
            }
        }
        (a, b) = (tail_a, tail_b);
    }
    Ordering::Equal
}

fn compare_names(left: &[String], right: &[String]) -> Ordering {
    left.iter()
        .zip(right)
        .map(|(a, b)| compare_natural(a, b))
        .find(|ordering| *ordering != Ordering::Equal)
        .unwrap_or_else(|| left.len().cmp(&right.len()))
}

/// Compares a trailing number as a number: `k2` before `k10`.
fn compare_natural(left: &str, right: &str) -> Ordering {
    let split = |name: &str| {
        let digits = name.bytes().rev().take_while(u8::is_ascii_digit).count();
        let (stem, number) = name.split_at(name.len() - digits);
        let significant = number.trim_start_matches('0').to_owned();
        (stem.to_owned(), significant.len(), significant)
    };
    split(left).cmp(&split(right)).then_with(|| left.cmp(right))
}
