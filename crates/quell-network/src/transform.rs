//! Layouts from layouts: substitution, duals, merging of like elements, the place of a mass.

use std::collections::HashSet;

use crate::kind::{Branch, Kind};
use crate::{Domain, Element, Layout, Tree};

/// Why a layout cannot be transformed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TransformError {
    /// No placeholder of that name.
    #[error("the layout has no placeholder `{0}`")]
    NoPlaceholder(String),
    /// The two layouts are in different domains.
    #[error("a {inner} layout cannot be put into a {outer} one; write both in one domain")]
    Domain {
        /// Domain of the layout put in.
        inner: Domain,
        /// Domain of the layout around it.
        outer: Domain,
    },
    /// Both layouts use a name.
    #[error("`{0}` occurs in both layouts; rename one of them")]
    Name(String),
    /// A mass has no dual.
    #[error("the mass `{0}` has no dual, because one of its terminals is the inertial frame")]
    MassDual(String),
    /// What is not an element has no dual that is known here.
    #[error("`{0}` is no element, so that its dual is not known; expand components first")]
    NoElement(String),
    /// An element with a law of its own has no dual that the layout could write.
    #[error("`{0}` is nonlinear, so that it has no dual among springs, dampers and inerters")]
    Nonlinear(String),
    /// A series group with two masses.
    #[error(
        "`{first}` and `{second}` are in series, but one terminal of a mass is the inertial frame, so that nothing can follow it"
    )]
    MassesInSeries {
        /// A mass.
        first: String,
        /// Another one.
        second: String,
    },
    /// A parallel group of which one side ends in a mass and another does not.
    #[error(
        "`{mass}` ends in the inertial frame but `{other}` beside it does not; every branch beside a mass must end in a mass as well"
    )]
    BesideMass {
        /// The mass.
        mass: String,
        /// The branch beside it.
        other: String,
    },
    /// The device must end in a mass.
    #[error(
        "the device hangs on one point, so that its layout must end in a mass, such as `(k1 | c1) + m1`"
    )]
    NoMass,
}

/// A layout whose like elements are merged, with the values of the merged ones.
#[derive(Debug, Clone, PartialEq)]
pub struct Merged {
    /// The smaller layout; a merged element has the name of its first part.
    pub layout: Layout,
    /// Name of a merged element and its value as an expression of the former values, such as `k1` and `k1 + k3` or
    /// `1/(1/k1 + 1/k3)`.
    pub values: Vec<(String, String)>,
}

impl Layout {
    /// The layout with a placeholder replaced by another layout of the same domain.
    ///
    /// # Errors
    /// No such placeholder, another domain, or a name that occurs in both.
    pub fn substitute(&self, placeholder: &str, inner: &Self) -> Result<Self, TransformError> {
        if !self
            .branches()
            .any(|branch| branch.kind == Kind::Placeholder && branch.name == placeholder)
        {
            return Err(TransformError::NoPlaceholder(placeholder.to_owned()));
        }
        if self.domain != inner.domain {
            return Err(TransformError::Domain {
                inner: inner.domain,
                outer: self.domain,
            });
        }
        let names: HashSet<&str> = inner
            .branches()
            .map(|branch| branch.name.as_str())
            .collect();
        let twice = self
            .branches()
            .find(|branch| branch.name != placeholder && names.contains(branch.name.as_str()));
        if let Some(branch) = twice {
            return Err(TransformError::Name(branch.name.clone()));
        }
        let tree = substituted(&self.tree, placeholder, &inner.tree);
        let tree = tree
            .flattened()
            .ok_or_else(|| TransformError::NoPlaceholder(placeholder.to_owned()))?;
        Ok(Self {
            domain: self.domain,
            tree,
        })
    }

    /// The layout with the reciprocal admittance: series and parallel change places, spring and inerter as well.
    ///
    /// With mechanical values k' = 1/b, c' = 1/c, b' = 1/k the dual's admittance is 1/Y(s), as a number in SI units
    /// (force-velocity duality); for R, L and C this makes L' = C and C' = L, R' = 1/R. A name whose first letter tells
    /// the kind gets the letter of the new kind (`k1` becomes `b1`); a declared name gets that letter in front
    /// (`stop` becomes `bstop`), with `_` after it where that name is taken.
    ///
    /// # Errors
    /// A mass, a component or a placeholder in the layout.
    pub fn dual(&self) -> Result<Self, TransformError> {
        let mut used = HashSet::new();
        let mut failure = None;
        let mut swap = |branch: &Branch| {
            let dual = match branch.kind {
                Kind::Element(element) => element
                    .dual()
                    .ok_or_else(|| TransformError::MassDual(branch.name.clone())),
                Kind::Custom(_) => Err(TransformError::Nonlinear(branch.name.clone())),
                Kind::Component(_) | Kind::Placeholder => {
                    Err(TransformError::NoElement(branch.name.clone()))
                }
            };
            match dual.map(|element| (element, self.domain.letter(element))) {
                Ok((element, Some(letter))) => {
                    let rest: String = if branch.lettered {
                        branch.name.chars().skip(1).collect()
                    } else {
                        branch.name.clone()
                    };
                    let mut name = format!("{letter}{rest}");
                    while !used.insert(name.clone()) {
                        name.push('_');
                    }
                    let rank = self
                        .domain
                        .letters()
                        .iter()
                        .position(|(known, _)| *known == letter)
                        .unwrap_or(0);
                    Branch {
                        name,
                        kind: Kind::Element(element),
                        rank,
                        lettered: true,
                    }
                }
                Ok((_, None)) => {
                    failure = Some(TransformError::MassDual(branch.name.clone()));
                    branch.clone()
                }
                Err(error) => {
                    failure = Some(error);
                    branch.clone()
                }
            }
        };
        let tree = swapped(&self.tree, &mut swap);
        match failure {
            Some(error) => Err(error),
            None => Ok(Self {
                domain: self.domain,
                tree,
            }),
        }
    }

    /// The layout with like elements of one group merged into one, as often as that is possible.
    ///
    /// Values add up where one displacement (or flow, voltage …) is shared in the way of the element, else their
    /// reciprocals do: mechanical elements and electrical C add in parallel, electrical R and L in series, hydraulic R
    /// and I in series and C in parallel. Components, nonlinear elements and placeholders
    /// stay as they are.
    #[must_use]
    pub fn merge_like(&self) -> Merged {
        let mut values = Vec::new();
        let tree = self.merged(&self.tree, &mut values);
        let tree = tree.flattened().unwrap_or_else(|| self.tree.clone());
        // A merged element may have merged again with its group's neighbours: keep what is still there.
        let layout = Self {
            domain: self.domain,
            tree,
        };
        values.retain(|(name, _)| layout.branch(name).is_some());
        Merged { layout, values }
    }

    fn merged(&self, tree: &Tree<Branch>, values: &mut Vec<(String, String)>) -> Tree<Branch> {
        let (series, children) = match tree {
            Tree::Leaf(_) => return tree.clone(),
            Tree::Series(children) => (true, children),
            Tree::Parallel(children) => (false, children),
        };
        let children: Vec<Tree<Branch>> = children
            .iter()
            .map(|child| self.merged(child, values))
            .collect();
        let mut kept: Vec<Tree<Branch>> = Vec::new();
        let mut groups: Vec<(Element, usize, Vec<String>)> = Vec::new();
        for child in children {
            if let Tree::Leaf(Branch {
                name,
                kind: Kind::Element(element),
                ..
            }) = &child
                && (*element != Element::Mass || !series)
            {
                if let Some((_, _, names)) = groups.iter_mut().find(|(known, ..)| known == element)
                {
                    names.push(name.clone());
                    continue;
                }
                groups.push((*element, kept.len(), vec![name.clone()]));
            }
            kept.push(child);
        }
        for (element, _, names) in groups.iter().filter(|(_, _, names)| names.len() > 1) {
            let Some(first) = names.first() else { continue };
            let value = |name: &String| {
                values
                    .iter()
                    .find(|(known, _)| known == name)
                    .map_or_else(|| name.clone(), |(_, value)| value.clone())
            };
            let terms: Vec<String> = names.iter().map(value).collect();
            let merged = if self.domain.adds_in_series(*element) == series {
                terms.join(" + ")
            } else {
                let reciprocal = |term: &String| {
                    if term.contains(' ') && !is_reciprocal(term) {
                        format!("1/({term})")
                    } else {
                        reciprocal_of(term)
                    }
                };
                format!(
                    "1/({})",
                    terms.iter().map(reciprocal).collect::<Vec<_>>().join(" + ")
                )
            };
            values.retain(|(known, _)| known != first);
            values.push((first.clone(), merged));
        }
        if series {
            Tree::Series(kept)
        } else {
            Tree::Parallel(kept)
        }
        .flattened()
        .unwrap_or_else(|| tree.clone())
    }

    /// Whether the layout ends in a mass, which [`Layout::place_mass`] can place.
    #[must_use]
    pub fn ends_in_mass(&self) -> bool {
        self.place_mass().is_ok()
    }

    /// The layout with its mass at the far (tail) end, where the inertial frame is.
    ///
    /// A mass is well placed alone; in a series group, where exactly one child ends in a mass and comes last; in a
    /// parallel group, where every child must end in a mass.
    ///
    /// # Errors
    /// No mass, masses in series, or a branch beside a mass that does not end in one.
    pub fn place_mass(&self) -> Result<Self, TransformError> {
        if !self.contains_mass() {
            return Err(TransformError::NoMass);
        }
        Ok(Self {
            domain: self.domain,
            tree: placed(&self.tree)?,
        })
    }
}

/// Whether the text is `1/(…)` around everything.
fn is_reciprocal(term: &str) -> bool {
    let Some(inner) = term
        .strip_prefix("1/(")
        .and_then(|rest| rest.strip_suffix(')'))
    else {
        return false;
    };
    let mut depth = 0_i32;
    inner.chars().all(|character| {
        depth += i32::from(character == '(') - i32::from(character == ')');
        depth >= 0
    })
}

/// The reciprocal of a name or of `1/(…)`.
fn reciprocal_of(term: &str) -> String {
    if is_reciprocal(term) {
        term.strip_prefix("1/(")
            .and_then(|rest| rest.strip_suffix(')'))
            .unwrap_or(term)
            .to_owned()
    } else {
        format!("1/{term}")
    }
}

fn substituted(tree: &Tree<Branch>, placeholder: &str, inner: &Tree<Branch>) -> Tree<Branch> {
    let all = |children: &[Tree<Branch>]| {
        children
            .iter()
            .map(|child| substituted(child, placeholder, inner))
            .collect()
    };
    match tree {
        Tree::Leaf(branch) if branch.kind == Kind::Placeholder && branch.name == placeholder => {
            inner.clone()
        }
        Tree::Leaf(_) => tree.clone(),
        Tree::Series(children) => Tree::Series(all(children)),
        Tree::Parallel(children) => Tree::Parallel(all(children)),
    }
}

fn swapped(tree: &Tree<Branch>, leaf: &mut impl FnMut(&Branch) -> Branch) -> Tree<Branch> {
    match tree {
        Tree::Leaf(branch) => Tree::Leaf(leaf(branch)),
        Tree::Series(children) => {
            Tree::Parallel(children.iter().map(|child| swapped(child, leaf)).collect())
        }
        Tree::Parallel(children) => {
            Tree::Series(children.iter().map(|child| swapped(child, leaf)).collect())
        }
    }
}

/// The first mass of a tree.
fn mass_of(tree: &Tree<Branch>) -> Option<&str> {
    tree.leaves()
        .find(|branch| branch.kind == Kind::Element(Element::Mass))
        .map(|branch| branch.name.as_str())
}

fn placed(tree: &Tree<Branch>) -> Result<Tree<Branch>, TransformError> {
    match tree {
        Tree::Leaf(_) => Ok(tree.clone()),
        Tree::Series(children) => {
            let mut last = None;
            let mut others = Vec::with_capacity(children.len());
            for child in children {
                match (mass_of(child), &last) {
                    (None, _) => others.push(child.clone()),
                    (Some(name), None) => last = Some((name, placed(child)?)),
                    (Some(second), Some((first, _))) => {
                        return Err(TransformError::MassesInSeries {
                            first: (*first).to_owned(),
                            second: second.to_owned(),
                        });
                    }
                }
            }
            others.extend(last.map(|(_, child)| child));
            Ok(Tree::Series(others))
        }
        Tree::Parallel(children) => {
            if let Some(mass) = mass_of(tree)
                && let Some(other) = children.iter().find(|child| mass_of(child).is_none())
            {
                let other = other
                    .leaves()
                    .next()
                    .map(|branch| branch.name.clone())
                    .unwrap_or_default();
                return Err(TransformError::BesideMass {
                    mass: mass.to_owned(),
                    other,
                });
            }
            Ok(Tree::Parallel(
                children.iter().map(placed).collect::<Result<_, _>>()?,
            ))
        }
    }
}
