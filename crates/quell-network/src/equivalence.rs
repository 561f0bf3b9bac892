//! Which layouts do the same: counts up to Zobel's moves and up to equal immittance, and Ladenheim's structures.

use std::collections::HashMap;

use crate::kind::{Branch, Kind};
use crate::synthesis::{Monomials, halton, numbered};
use crate::{
    Budget, Domain, Element, Enumeration, EnumerationError, Equivalence, Kinds, Layout, Scales,
    Tree, bridge,
};

/// How many layouts there are, by what counts as one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Counts {
    /// Up to the order of branches in groups ([`Equivalence::Commutative`]).
    pub raw: u128,
    /// Those without like elements side by side in a group ([`Equivalence::Irreducible`]).
    pub irreducible: u128,
    /// Irreducible ones up to Zobel's moves ([`zobel_classes`]).
    pub zobel: usize,
    /// Irreducible ones up to equal sets of admittances ([`immittance_classes`]).
    pub immittance: usize,
}

/// The layouts of exactly so many springs, dampers and inerters, counted.
///
/// # Errors
/// Too many to number.
pub fn counts(springs: usize, dampers: usize, inerters: usize) -> Result<Counts, EnumerationError> {
    let list = |equivalence| {
        let budgets = [
            Budget::exactly("k", springs),
            Budget::exactly("c", dampers),
            Budget::exactly("b", inerters),
        ];
        Enumeration::new(
            &Kinds::new(Domain::Translational),
            &budgets,
            None,
            equivalence,
        )
    };
    let irreducible = list(Equivalence::Irreducible)?;
    let layouts: Vec<Layout> = irreducible.iter().collect();
    let zobel = zobel_classes(&layouts);
    let representatives: Vec<Layout> = zobel
        .iter()
        .filter_map(|class| layouts.get(*class.first()?).cloned())
        .collect();
    Ok(Counts {
        raw: list(Equivalence::Commutative)?.count(),
        irreducible: irreducible.count(),
        zobel: zobel.len(),
        immittance: immittance_classes(&representatives).len(),
    })
}

/// Classes of layouts under Zobel's moves (Zobel 1923), as places in the list.
///
/// e | (e + R) and e + (e | R), with two elements e of one kind and any network R, have the same set of admittances; a move is
/// one such replacement anywhere in a layout. Only moves between layouts of the list join them.
#[must_use]
pub fn zobel_classes(layouts: &[Layout]) -> Vec<Vec<usize>> {
    let places: HashMap<String, usize> = layouts
        .iter()
        .enumerate()
        .map(|(place, layout)| (shape(layout), place))
        .collect();
    let mut classes = Classes::new(layouts.len());
    for (place, layout) in layouts.iter().enumerate() {
        for tree in moves(layout.tree()) {
            let other = Layout::from_tree(layout.domain(), tree);
            if let Some(other) = other.and_then(|other| places.get(&shape(&other))) {
                classes.join(place, *other);
            }
        }
    }
    classes.groups()
}

/// Classes of layouts whose sets of admittances are equal, as places in the list.
///
/// Computed, not proven: two layouts are one class if each realises three random admittances of the other. Zobel's moves,
/// Foster's and Cauer's forms and all others are found alike.
#[must_use]
pub fn immittance_classes(layouts: &[Layout]) -> Vec<Vec<usize>> {
    let networks: Vec<Option<Monomials>> = layouts
        .iter()
        .map(|layout| numbered(layout).map(|(tree, elements)| Monomials::of_tree(&tree, &elements)))
        .collect();
    let contains = |outer: &Monomials, inner: &Monomials, size: usize| {
        (0..3).all(|sample| {
            let values: Vec<f64> = (0..size)
                .map(|element| (3.0 * (halton(17 * sample + 5, element) - 0.5)).exp())
                .collect();
            let target = inner.admittance(&values);
            let target = target.at_scales(Scales {
                frequency: 1.0,
                size: 1.0,
            });
            outer.suits(&target) && outer.solve(&target, 40).is_some()
        })
    };
    let mut classes = Classes::new(layouts.len());
    for (i, first) in networks.iter().enumerate() {
        for (j, second) in networks.iter().enumerate().skip(i + 1) {
            if classes.root(i) == classes.root(j) {
                continue;
            }
            let (Some(first), Some(second)) = (first, second) else {
                continue;
            };
            let size = |place: usize| {
                layouts
                    .get(place)
                    .map_or(0, |layout| layout.branches().count())
            };
            if first.powers() == second.powers()
                && contains(first, second, size(j))
                && contains(second, first, size(i))
            {
                classes.join(i, j);
            }
        }
    }
    classes.groups()
}

/// The canonical text with the branches' numbers struck out.
fn shape(layout: &Layout) -> String {
    let text = layout.canonical().to_string();
    text.chars()
        .filter(|character| !character.is_ascii_digit())
        .collect()
}

fn element(tree: &Tree<Branch>) -> Option<Element> {
    match tree {
        Tree::Leaf(Branch {
            kind: Kind::Element(element),
            ..
        }) => Some(*element),
        _ => None,
    }
}

fn group(series: bool, children: Vec<Tree<Branch>>) -> Tree<Branch> {
    if series {
        Tree::Series(children)
    } else {
        Tree::Parallel(children)
    }
}

/// Every tree that is one of Zobel's moves away.
fn moves(tree: &Tree<Branch>) -> Vec<Tree<Branch>> {
    let (series, children) = match tree {
        Tree::Leaf(_) => return Vec::new(),
        Tree::Series(children) => (true, children),
        Tree::Parallel(children) => (false, children),
    };
    let mut all = Vec::new();
    for (place, child) in children.iter().enumerate() {
        let others = |without: &[usize]| -> Vec<Tree<Branch>> {
            children
                .iter()
                .enumerate()
                .filter(|(other, _)| !without.contains(other))
                .map(|(_, other)| other.clone())
                .collect()
        };
        for inner in moves(child) {
            let mut changed = others(&[place]);
            changed.push(inner);
            all.push(group(series, changed));
        }
        // `child` is e; a group beside it holds another e.
        let Some(kind) = element(child) else { continue };
        for (second, other) in children.iter().enumerate() {
            for (inner_place, inner) in other.children().iter().enumerate() {
                if element(inner) != Some(kind) {
                    continue;
                }
                let rest: Vec<Tree<Branch>> = other
                    .children()
                    .iter()
                    .enumerate()
                    .filter(|(third, _)| *third != inner_place)
                    .map(|(_, third)| third.clone())
                    .collect();
                let nested = group(series, vec![inner.clone(), group(!series, rest)]);
                let mut changed = others(&[place, second]);
                changed.push(group(!series, vec![child.clone(), nested]));
                all.push(group(series, changed));
            }
        }
    }
    all
}

/// Sets that grow together.
struct Classes {
    parents: Vec<usize>,
}

impl Classes {
    fn new(size: usize) -> Self {
        Self {
            parents: (0..size).collect(),
        }
    }

    fn root(&self, mut place: usize) -> usize {
        while let Some(parent) = self.parents.get(place)
            && *parent != place
        {
            place = *parent;
        }
        place
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        if let Some(parent) = self.parents.get_mut(a.max(b)) {
            *parent = a.min(b);
        }
    }

    fn groups(&self) -> Vec<Vec<usize>> {
        let mut groups: Vec<Vec<usize>> = vec![Vec::new(); self.parents.len()];
        for place in 0..self.parents.len() {
            if let Some(group) = groups.get_mut(self.root(place)) {
                group.push(place);
            }
        }
        groups.retain(|group| !group.is_empty());
        groups
    }
}

/// A structure of Ladenheim's set.
#[derive(Debug, Clone, PartialEq)]
pub enum LadenheimStructure {
    /// A series-parallel layout.
    SeriesParallel(Layout),
    /// The five-element bridge: head to first inner node, head to second, first to tail, second to tail, bridging.
    Bridge([Element; 5]),
}

/// The structures from which Ladenheim (1948) started: all series-parallel networks and bridges of at most five elements of
/// which at most two store energy, without like elements side by side in a group and without networks of several
/// dampers alone, up to the order in groups and the symmetries of the bridge.
///
/// They are 3, 6, 16, 38 and 85 of one to five elements, 148 in all. His catalogue keeps 108 of them: he left out those whose
/// admittances another one with fewer elements, or an equal number, has as well (Morelli and Smith 2019).
///
/// # Errors
/// None that can occur; those of [`Enumeration::new`].
pub fn ladenheim_structures() -> Result<Vec<LadenheimStructure>, EnumerationError> {
    let mut all = Vec::new();
    for size in 1..=5 {
        let budgets = ["k", "c", "b"].map(Budget::any);
        let list = Enumeration::new(
            &Kinds::new(Domain::Translational),
            &budgets,
            Some(size),
            Equivalence::Irreducible,
        )?;
        let reactive = |layout: &Layout| {
            layout
                .branches()
                .filter(|branch| branch.kind != Kind::Element(Element::Damper))
                .count()
        };
        all.extend(
            list.iter()
                .filter(|layout| reactive(layout) <= 2)
                .map(LadenheimStructure::SeriesParallel),
        );
    }
    all.extend(
        bridge::labelled()
            .filter(|labels| {
                let dampers = labels
                    .iter()
                    .filter(|label| **label == Element::Damper)
                    .count();
                dampers == 3 || dampers == 4
            })
            .map(LadenheimStructure::Bridge),
    );
    Ok(all)
}
