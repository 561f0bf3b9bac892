//! Every layout of given kinds, each exactly once, by rank.
//!
//! Contents (how many branches of each kind) are numbered by size and then kind by kind. A series group of content v is a
//! multiset of at least two children, each a leaf or a parallel group; with C(u) children of content u, the multisets of
//! content v whose children have content numbers from j on are counted by
//!
//! ```text
//! M(v, j) = sum over m >= 0 of binomial(C(u_j) + m - 1, m) M(v - m u_j, j + 1),   M(0, j) = 1
//! ```
//!
//! (Riordan and Shannon 1942 for one kind). Parallel groups are as many as series groups. The same tables unrank: the
//! layout of any index is built directly, nothing is stored for each layout.

use std::collections::{HashMap, HashSet};
use std::fmt;

use quell_expression::nearest;

use crate::kind::{Branch, Kind, Kinds};
use crate::{Domain, Layout, Tree};

/// Which layouts count as one, and which are left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Equivalence {
    /// Series and parallel are commutative and associative; branches of one kind are interchangeable.
    Commutative,
    /// As [`Equivalence::Commutative`], and no two branches of one single-element kind stand side by side in one group,
    /// since they would merge into one element.
    ///
    /// This is not minimality: networks of equal admittance but different layout (Zobel, Foster and Cauer transformations)
    /// are all listed.
    Irreducible,
}

impl fmt::Display for Equivalence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Commutative => "up to the order of branches within groups and the numbering of branches of one kind",
            Self::Irreducible => {
                "up to the order of branches within groups and the numbering of branches of one kind, \
                 without two like single elements side by side in one group"
            }
        })
    }
}

/// How many branches of a kind a layout has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Budget {
    /// A letter of the domain (`k`), or a declared kind (`pipe`).
    pub kind: String,
    /// At least this many.
    pub at_least: usize,
    /// At most this many; none for as many as there are branches.
    pub at_most: Option<usize>,
    /// Whether a branch is one element, so that two of them side by side in one group merge. Elements always are; a
    /// component of several elements is not, because its values are tied by shared variables and bounds; elements with
    /// a law of their own never are, because their laws do not add up.
    pub single_element: bool,
}

impl Budget {
    /// Exactly so many single elements of a kind.
    #[must_use]
    pub fn exactly(kind: &str, number: usize) -> Self {
        Self {
            kind: kind.to_owned(),
            at_least: number,
            at_most: Some(number),
            single_element: true,
        }
    }

    /// Any number of a kind.
    #[must_use]
    pub fn any(kind: &str) -> Self {
        Self {
            kind: kind.to_owned(),
            at_least: 0,
            at_most: None,
            single_element: true,
        }
    }

    /// At least so many.
    #[must_use]
    pub fn at_least(self, number: usize) -> Self {
        Self {
            at_least: number,
            ..self
        }
    }

    /// At most so many.
    #[must_use]
    pub fn at_most(self, number: usize) -> Self {
        Self {
            at_most: Some(number),
            ..self
        }
    }

    /// Whether a branch of the kind is one element.
    #[must_use]
    pub fn single_element(self, single_element: bool) -> Self {
        Self {
            single_element,
            ..self
        }
    }
}

/// Why layouts cannot be listed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum EnumerationError {
    /// The kind is neither a letter nor declared.
    #[error("`{kind}` is no known kind of branch{}", near.as_ref().map(|near| format!("; did you mean `{near}`?")).unwrap_or_default())]
    UnknownKind {
        /// The kind.
        kind: String,
        /// The nearest known kind.
        near: Option<String>,
    },
    /// A placeholder cannot be counted.
    #[error("`{0}` is a placeholder, which no layout can be made of")]
    Placeholder(String),
    /// The kind occurs twice.
    #[error("the kind `{0}` is given twice")]
    Twice(String),
    /// More demanded than allowed.
    #[error("of `{kind}` at least {at_least} but at most {at_most} are asked for")]
    Range {
        /// The kind.
        kind: String,
        /// Lower bound.
        at_least: usize,
        /// Upper bound.
        at_most: usize,
    },
    /// Neither the number of branches nor that of the kind is bounded.
    #[error(
        "there is no end of layouts: bound the number of `{0}`, or give the number of branches"
    )]
    Unbounded(String),
    /// The count or its tables pass what can be handled.
    #[error("too many layouts to number: lower the number of branches or of kinds")]
    TooMany,
}

/// Contents and counting tables may have this many entries.
const TABLE_LIMIT: usize = 1 << 21;

/// A layout may have this many branches.
const BRANCH_LIMIT: usize = 64;

#[derive(Debug, Clone)]
struct EnumeratedKind {
    /// What precedes the number in names.
    stem: String,
    branch: Branch,
    single: bool,
}

/// One content with its counts.
#[derive(Debug, Clone)]
struct Content {
    counts: Vec<usize>,
    size: usize,
    /// The counts as digits of one number.
    key: u128,
    /// Children of this content that a group can have: 1 for a leaf, else the groups of the other sort.
    children: u128,
    /// W(v, j): groups of this content with content numbers of children from j on.
    groups: Vec<u128>,
}

/// All layouts with given numbers of each kind, each exactly once, in canonical order.
///
/// ```
/// use quell_network::{Budget, Domain, Enumeration, Equivalence, Kinds};
/// let budgets = [Budget::exactly("k", 1), Budget::exactly("c", 1), Budget::exactly("b", 1)];
/// let all = Enumeration::new(&Kinds::new(Domain::Translational), &budgets, None, Equivalence::Irreducible).unwrap();
/// assert_eq!(all.count(), 8);
/// assert_eq!(all.nth(0).unwrap().to_string(), "k1 + c1 + b1");
/// ```
#[derive(Debug, Clone)]
pub struct Enumeration {
    domain: Domain,
    kinds: Vec<EnumeratedKind>,
    equivalence: Equivalence,
    contents: Vec<Content>,
    numbers: HashMap<u128, usize>,
    /// Content numbers that satisfy the budgets, each with the index of its first layout.
    listed: Vec<(usize, u128)>,
    count: u128,
    taken: HashSet<String>,
}

impl Enumeration {
    /// Layouts over the kinds of the budgets, with exactly `branches` branches if given.
    ///
    /// Kinds are ordered as in canonical layouts, whatever the order of the budgets.
    ///
    /// # Errors
    /// See [`EnumerationError`].
    pub fn new(
        kinds: &Kinds,
        budgets: &[Budget],
        branches: Option<usize>,
        equivalence: Equivalence,
    ) -> Result<Self, EnumerationError> {
        let mut chosen: Vec<(usize, EnumeratedKind, usize, usize)> = Vec::new();
        for budget in budgets {
            let branch = kinds.kind(&budget.kind).ok_or_else(|| {
                let letters: Vec<String> = kinds
                    .domain()
                    .letters()
                    .iter()
                    .map(|(letter, _)| letter.to_string())
                    .collect();
                let known = kinds
                    .declared()
                    .map(|(name, _)| name)
                    .chain(letters.iter().map(String::as_str));
                EnumerationError::UnknownKind {
                    kind: budget.kind.clone(),
                    near: nearest(&budget.kind, known).map(str::to_owned),
                }
            })?;
            if branch.kind == Kind::Placeholder {
                return Err(EnumerationError::Placeholder(budget.kind.clone()));
            }
            if chosen.iter().any(|(rank, ..)| *rank == branch.rank) {
                return Err(EnumerationError::Twice(budget.kind.clone()));
            }
            let at_most = match (budget.at_most, branches) {
                (Some(most), Some(branches)) => most.min(branches),
                (Some(most), None) => most,
                (None, Some(branches)) => branches,
                (None, None) => return Err(EnumerationError::Unbounded(budget.kind.clone())),
            };
            if budget.at_most.is_some_and(|most| most < budget.at_least) {
                return Err(EnumerationError::Range {
                    kind: budget.kind.clone(),
                    at_least: budget.at_least,
                    at_most,
                });
            }
            let single = match branch.kind {
                Kind::Element(_) => true,
                // Two laws with parameters of their own do not add up to a third of the same kind.
                Kind::Custom(_) => false,
                Kind::Component(_) | Kind::Placeholder => budget.single_element,
            };
            let kind = EnumeratedKind {
                stem: budget.kind.clone(),
                branch,
                single,
            };
            chosen.push((kind.branch.rank, kind, budget.at_least, at_most));
        }
        chosen.sort_by_key(|(rank, ..)| *rank);
        let least: Vec<usize> = chosen.iter().map(|(_, _, least, _)| *least).collect();
        let most: Vec<usize> = chosen.iter().map(|(_, _, _, most)| *most).collect();
        let total = most
            .iter()
            .fold(0_usize, |sum, most| sum.saturating_add(*most));
        let size = branches.map_or(total, |branches| branches.min(total));
        let mut enumeration = Self {
            domain: kinds.domain(),
            kinds: chosen.into_iter().map(|(_, kind, _, _)| kind).collect(),
            equivalence,
            contents: Vec::new(),
            numbers: HashMap::new(),
            listed: Vec::new(),
            count: 0,
            taken: HashSet::new(),
        };
        let possible = branches.is_none_or(|branches| branches == size)
            && least.iter().zip(&most).all(|(l, m)| l <= m);
        if possible {
            enumeration.fill(&least, &most, size, branches)?;
        }
        Ok(enumeration)
    }

    /// All series-parallel topologies with so many branches (`branch1 | branch2` …), branches unlabelled:
    /// 1, 2, 4, 10, 24, 66, 180, 522 … (MacMahon 1892; Riordan and Shannon 1942).
    ///
    /// # Errors
    /// Too many to number.
    pub fn topologies(branches: usize) -> Result<Self, EnumerationError> {
        let mut kinds = Kinds::new(Domain::Translational);
        let name = "branch";
        kinds
            .declare_component(name)
            .map_err(|_| EnumerationError::Placeholder(name.to_owned()))?;
        let budget = Budget::any(name).single_element(false);
        Self::new(&kinds, &[budget], Some(branches), Equivalence::Commutative)
    }

    /// The same enumeration with names that leave out those taken: with `k1` taken the first spring is `k2`.
    #[must_use]
    pub fn avoiding<'a>(mut self, names: impl IntoIterator<Item = &'a str>) -> Self {
        self.taken.extend(names.into_iter().map(str::to_owned));
        self
    }

    /// Number of layouts.
    #[must_use]
    pub const fn count(&self) -> u128 {
        self.count
    }

    /// What counts as one layout.
    #[must_use]
    pub const fn equivalence(&self) -> Equivalence {
        self.equivalence
    }

    /// The layout of an index below [`Enumeration::count`], in canonical form; branches of each kind are numbered from
    /// left to right.
    #[must_use]
    pub fn nth(&self, index: u128) -> Option<Layout> {
        if index >= self.count {
            return None;
        }
        let place = self
            .listed
            .partition_point(|(_, first)| *first <= index)
            .checked_sub(1)?;
        let (number, first) = *self.listed.get(place)?;
        let content = self.contents.get(number)?;
        let index = index - first;
        let tree = if content.size == 1 {
            self.child(number, index, true)?
        } else {
            let half = *content.groups.first()?;
            if index < half {
                self.group(number, index, true)?
            } else {
                self.group(number, index - half, false)?
            }
        };
        let mut next = vec![1_usize; self.kinds.len()];
        let tree = tree.map(&mut |kind: &usize| self.name(*kind, &mut next));
        Some(Layout {
            domain: self.domain,
            tree,
        })
    }

    /// All layouts one after the other, built as they are asked for.
    #[must_use]
    pub const fn iter(&self) -> Layouts<'_> {
        Layouts {
            enumeration: self,
            next: 0,
        }
    }

    fn name(&self, kind: usize, next: &mut [usize]) -> Branch {
        let Some((kind, next)) = self.kinds.get(kind).zip(next.get_mut(kind)) else {
            return Branch {
                name: String::new(),
                kind: Kind::Placeholder,
                rank: usize::MAX,
                lettered: false,
            };
        };
        loop {
            let name = format!("{}{}", kind.stem, *next);
            *next += 1;
            if !self.taken.contains(&name) {
                return Branch {
                    name,
                    ..kind.branch.clone()
                };
            }
        }
    }

    fn fill(
        &mut self,
        least: &[usize],
        most: &[usize],
        size: usize,
        branches: Option<usize>,
    ) -> Result<(), EnumerationError> {
        if size > BRANCH_LIMIT {
            return Err(EnumerationError::TooMany);
        }
        let radix = size as u128 + 1;
        let counts = contents(most, size)?;
        for counts in counts {
            let key = counts
                .iter()
                .try_fold(0_u128, |key, count| {
                    key.checked_mul(radix)?.checked_add(*count as u128)
                })
                .ok_or(EnumerationError::TooMany)?;
            let number = self.contents.len();
            self.numbers.insert(key, number);
            let size = counts.iter().sum();
            self.contents.push(Content {
                counts,
                size,
                key,
                children: 0,
                groups: Vec::new(),
            });
        }
        let small = self
            .contents
            .iter()
            .filter(|content| 2 * content.size <= size)
            .count();
        if self.contents.len().saturating_mul(small.max(1)) > TABLE_LIMIT {
            return Err(EnumerationError::TooMany);
        }
        for number in 0..self.contents.len() {
            let (groups, children) = self
                .count_content(number)
                .ok_or(EnumerationError::TooMany)?;
            if let Some(content) = self.contents.get_mut(number) {
                (content.groups, content.children) = (groups, children);
            }
        }
        for (number, content) in self.contents.iter().enumerate() {
            let fits = content.size > 0
                && branches.is_none_or(|branches| content.size == branches)
                && content
                    .counts
                    .iter()
                    .zip(least)
                    .all(|(count, least)| count >= least);
            if fits {
                let layouts = if content.size == 1 {
                    Some(1)
                } else {
                    content.children.checked_mul(2)
                };
                if layouts != Some(0) {
                    self.listed.push((number, self.count));
                }
                self.count = layouts
                    .and_then(|layouts| self.count.checked_add(layouts))
                    .ok_or(EnumerationError::TooMany)?;
            }
        }
        Ok(())
    }

    /// W(v, j) for every j, and C(v).
    fn count_content(&self, number: usize) -> Option<(Vec<u128>, u128)> {
        let content = self.contents.get(number)?;
        if content.size < 2 {
            return Some((Vec::new(), u128::from(content.size == 1)));
        }
        let smaller = self
            .contents
            .iter()
            .take_while(|child| 2 * child.size <= content.size)
            .count();
        let mut groups = vec![0_u128; smaller + 1];
        for j in (0..smaller).rev() {
            let mut sum = *groups.get(j + 1)?;
            for times in 1..=self.most_times(j, content) {
                if let Some(rest) = self.minus(content, j, times) {
                    let choices = multichoose(self.contents.get(j)?.children, times)?;
                    sum = sum.checked_add(choices.checked_mul(self.multisets(rest, j + 1)?)?)?;
                }
            }
            *groups.get_mut(j)? = sum;
        }
        let all = *groups.first()?;
        Some((groups, all))
    }

    /// How often children of content j can occur in a group of the content.
    fn most_times(&self, j: usize, content: &Content) -> usize {
        let Some(child) = self.contents.get(j) else {
            return 0;
        };
        if child.size == 0 || child.children == 0 {
            return 0;
        }
        let most = content
            .counts
            .iter()
            .zip(&child.counts)
            .filter(|(_, needed)| **needed > 0)
            .map(|(available, needed)| available / needed)
            .min()
            .unwrap_or(0);
        let merges = self.equivalence == Equivalence::Irreducible
            && child.size == 1
            && child
                .counts
                .iter()
                .zip(&self.kinds)
                .any(|(count, kind)| *count == 1 && kind.single);
        if merges { most.min(1) } else { most }
    }

    /// The number of the content that is left when children of content j are taken so many times.
    fn minus(&self, content: &Content, j: usize, times: usize) -> Option<usize> {
        let child = self.contents.get(j)?;
        let size = content.size.checked_sub(times * child.size)?;
        let key = content.key.checked_sub(times as u128 * child.key)?;
        let number = *self.numbers.get(&key)?;
        // A borrow between digits would change the size.
        (self.contents.get(number)?.size == size).then_some(number)
    }

    /// M(v, j), the group of one child included.
    fn multisets(&self, number: usize, j: usize) -> Option<u128> {
        let content = self.contents.get(number)?;
        if content.size == 0 {
            return Some(1);
        }
        let several = content.groups.get(j).copied().unwrap_or(0);
        if number < j {
            Some(0)
        } else {
            several.checked_add(content.children)
        }
    }

    /// The child of an index of a content: a leaf, or a group of the sort given.
    fn child(&self, number: usize, index: u128, series: bool) -> Option<Tree<usize>> {
        let content = self.contents.get(number)?;
        if content.size == 1 {
            return content
                .counts
                .iter()
                .position(|count| *count == 1)
                .map(Tree::Leaf);
        }
        self.group(number, index, series)
    }

    /// The group of an index of a content.
    fn group(&self, number: usize, index: u128, series: bool) -> Option<Tree<usize>> {
        let mut children = Vec::new();
        let (mut rest, mut index, mut j) = (number, index, 0);
        loop {
            let content = self.contents.get(rest)?;
            if content.size == 0 {
                break;
            }
            if j >= content.groups.len() {
                // Only the group of one child is left.
                children.push(self.child(rest, index, !series)?);
                break;
            }
            let mut found = None;
            for times in (1..=self.most_times(j, content)).rev() {
                let Some(left) = self.minus(content, j, times) else {
                    continue;
                };
                let of_child = self.contents.get(j)?.children;
                let following = self.multisets(left, j + 1)?;
                let layouts = multichoose(of_child, times)?.checked_mul(following)?;
                if index < layouts {
                    found = Some((times, left, of_child, following));
                    break;
                }
                index -= layouts;
            }
            if let Some((times, left, of_child, following)) = found {
                for item in unrank_multiset(of_child, times, index / following)? {
                    children.push(self.child(j, item, !series)?);
                }
                index %= following;
                rest = left;
            }
            j += 1;
        }
        Some(if series {
            Tree::Series(children)
        } else {
            Tree::Parallel(children)
        })
    }
}

impl<'a> IntoIterator for &'a Enumeration {
    type Item = Layout;
    type IntoIter = Layouts<'a>;

    fn into_iter(self) -> Layouts<'a> {
        self.iter()
    }
}

/// The layouts of an [`Enumeration`], one after the other.
#[derive(Debug, Clone)]
pub struct Layouts<'a> {
    enumeration: &'a Enumeration,
    next: u128,
}

impl Iterator for Layouts<'_> {
    type Item = Layout;

    fn next(&mut self) -> Option<Layout> {
        let layout = self.enumeration.nth(self.next)?;
        self.next += 1;
        Some(layout)
    }

    fn nth(&mut self, n: usize) -> Option<Layout> {
        self.next = self.next.saturating_add(n as u128);
        self.next()
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = usize::try_from(self.enumeration.count.saturating_sub(self.next));
        (left.unwrap_or(usize::MAX), left.ok())
    }
}

/// Every content below `most` with at most `size` branches: by size, then more of the first kind first.
fn contents(most: &[usize], size: usize) -> Result<Vec<Vec<usize>>, EnumerationError> {
    let mut all: Vec<Vec<usize>> = vec![Vec::new()];
    for most in most {
        let mut longer = Vec::new();
        for counts in &all {
            let used: usize = counts.iter().sum();
            for count in 0..=(*most).min(size - used) {
                longer.push(counts.iter().copied().chain([count]).collect());
                if longer.len() > TABLE_LIMIT {
                    return Err(EnumerationError::TooMany);
                }
            }
        }
        all = longer;
    }
    all.sort_by(|a, b| {
        a.iter()
            .sum::<usize>()
            .cmp(&b.iter().sum())
            .then_with(|| b.cmp(a))
    });
    Ok(all)
}

/// Multisets of m out of n: binomial(n + m - 1, m).
fn multichoose(n: u128, m: usize) -> Option<u128> {
    let mut result = 1_u128;
    for i in 0..m as u128 {
        result = result.checked_mul(n.checked_add(i)?)? / (i + 1);
    }
    Some(result)
}

/// The multiset of an index among those of m out of n, as an ascending list; lists in lexicographic order.
fn unrank_multiset(n: u128, m: usize, index: u128) -> Option<Vec<u128>> {
    let mut items = Vec::with_capacity(m);
    let (mut lowest, mut index) = (0_u128, index);
    for left in (1..=m).rev() {
        let all = multichoose(n - lowest, left)?;
        // The largest item such that at most `index` lists start with a smaller one.
        let before = |item: u128| multichoose(n - item, left).map(|from_item| all - from_item);
        let (mut low, mut high) = (lowest, n - 1);
        while low < high {
            let middle = high - (high - low) / 2;
            if before(middle)? <= index {
                low = middle;
            } else {
                high = middle - 1;
            }
        }
        index -= before(low)?;
        items.push(low);
        lowest = low;
    }
    Some(items)
}
