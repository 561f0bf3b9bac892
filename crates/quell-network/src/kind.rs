//! Kinds of branches: what a name in a layout stands for.

use crate::{Domain, Element};

/// A declared element whose force is any function of its own relative displacement x and rate v = x'.
///
/// The law itself is the declarer's; a network only needs to know what the force depends on.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct CustomElement {
    /// The declared name of the law.
    pub law: String,
    /// Whether the force depends on the relative displacement: it may hold what it joins, as a spring does.
    pub displacement: bool,
    /// Whether the force depends on the rate: it may brake what it joins, as a damper does.
    pub rate: bool,
}

/// What a branch is.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Kind {
    /// A single linear element.
    Element(Element),
    /// A single element with a declared force law, see [`crate::Mechanism`].
    Custom(CustomElement),
    /// An instance of the named component.
    Component(String),
    /// A place that another layout is to fill.
    Placeholder,
}

/// A named branch of a layout; equal if name and kind are.
#[derive(Debug, Clone)]
pub struct Branch {
    /// The name in the layout, unique there.
    pub name: String,
    /// What it is.
    pub kind: Kind,
    /// Place of the kind in canonical order.
    pub(crate) rank: usize,
    /// Whether the name's first letter told the kind.
    pub(crate) lettered: bool,
}

impl PartialEq for Branch {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name && self.kind == other.kind
    }
}

impl Eq for Branch {}

impl std::hash::Hash for Branch {
    fn hash<H: std::hash::Hasher>(&self, state: &mut H) {
        self.name.hash(state);
        self.kind.hash(state);
    }
}

/// Ranks of declared kinds start here; those of letters lie below.
const DECLARED_RANK: usize = 8;

/// Why a kind cannot be declared.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum KindError {
    /// The name is no name.
    #[error(
        "`{0}` is no name for a branch: a name starts with a letter and goes on with letters, digits and `_`"
    )]
    NotAName(String),
    /// The name is taken.
    #[error("`{0}` is declared twice")]
    Twice(String),
    /// The name ends in a digit.
    #[error(
        "the component name `{0}` ends in a digit, which would be read as the number of an instance"
    )]
    EndsInDigit(String),
    /// The name of a declared element ends in a digit.
    #[error(
        "the element name `{0}` ends in a digit, which would be read as the number of an instance"
    )]
    CustomEndsInDigit(String),
    /// The force of a declared element depends on nothing.
    #[error(
        "the force of `{0}` depends neither on its displacement `x` nor on its rate `v`, so that it is no element"
    )]
    Constant(String),
    /// The name is also an instance of another kind.
    #[error("`{name}` would also be a numbered branch of `{other}`; rename one of them")]
    Ambiguous {
        /// The name.
        name: String,
        /// The other kind.
        other: String,
    },
}

/// The names that a layout may use: the letters of its domain, and what is declared besides.
///
/// A name stands for the declared kind of exactly that name, else for the declared element or component whose name it
/// is with a number after it (`pipe2` of `pipe`), else for the element of its first letter.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Kinds {
    domain: Domain,
    declared: Vec<(String, Kind)>,
}

impl Kinds {
    /// The letters of a domain, nothing declared.
    #[must_use]
    pub const fn new(domain: Domain) -> Self {
        Self {
            domain,
            declared: Vec::new(),
        }
    }

    /// The domain whose letters are known.
    #[must_use]
    pub const fn domain(&self) -> Domain {
        self.domain
    }

    /// Declares an element of a name whose first letter does not tell its kind.
    ///
    /// # Errors
    /// See [`KindError`].
    pub fn declare_element(&mut self, name: &str, element: Element) -> Result<(), KindError> {
        self.declare(name, Kind::Element(element))
    }

    /// Declares a component; its instances are `name`, `name1`, `name2` …
    ///
    /// # Errors
    /// See [`KindError`].
    pub fn declare_component(&mut self, name: &str) -> Result<(), KindError> {
        if name.ends_with(|character: char| character.is_ascii_digit()) {
            return Err(KindError::EndsInDigit(name.to_owned()));
        }
        self.declare(name, Kind::Component(name.to_owned()))
    }

    /// Declares an element with a force law of its own; its instances are `name`, `name1`, `name2` …
    ///
    /// `displacement` and `rate` say what the force depends on.
    ///
    /// # Errors
    /// See [`KindError`].
    pub fn declare_custom(
        &mut self,
        name: &str,
        displacement: bool,
        rate: bool,
    ) -> Result<(), KindError> {
        if !(displacement || rate) {
            return Err(KindError::Constant(name.to_owned()));
        }
        if name.ends_with(|character: char| character.is_ascii_digit()) {
            return Err(KindError::CustomEndsInDigit(name.to_owned()));
        }
        let law = name.to_owned();
        self.declare(
            name,
            Kind::Custom(CustomElement {
                law,
                displacement,
                rate,
            }),
        )
    }

    /// Declares a place that another layout is to fill ([`crate::Layout::substitute`]).
    ///
    /// # Errors
    /// See [`KindError`].
    pub fn declare_placeholder(&mut self, name: &str) -> Result<(), KindError> {
        self.declare(name, Kind::Placeholder)
    }

    fn declare(&mut self, name: &str, kind: Kind) -> Result<(), KindError> {
        let mut characters = name.chars();
        if !(characters.next().is_some_and(starts_name) && characters.all(continues_name)) {
            return Err(KindError::NotAName(name.to_owned()));
        }
        for (other, other_kind) in &self.declared {
            if other == name {
                return Err(KindError::Twice(name.to_owned()));
            }
            let clash = (is_numbered(name, other) && *other_kind != Kind::Placeholder)
                || (is_numbered(other, name) && kind != Kind::Placeholder);
            if clash {
                return Err(KindError::Ambiguous {
                    name: name.to_owned(),
                    other: other.clone(),
                });
            }
        }
        self.declared.push((name.to_owned(), kind));
        Ok(())
    }

    /// What is declared, in order.
    pub fn declared(&self) -> impl Iterator<Item = (&str, &Kind)> {
        self.declared
            .iter()
            .map(|(name, kind)| (name.as_str(), kind))
    }

    /// The branch that a name stands for.
    #[must_use]
    pub fn branch(&self, name: &str) -> Option<Branch> {
        let exact = self
            .declared
            .iter()
            .position(|(declared, _)| declared == name);
        let declared = exact.or_else(|| {
            self.declared.iter().position(|(declared, kind)| {
                *kind != Kind::Placeholder && is_numbered(name, declared)
            })
        });
        if let Some(index) = declared {
            let (_, kind) = self.declared.get(index)?;
            return Some(Branch {
                name: name.to_owned(),
                kind: kind.clone(),
                rank: DECLARED_RANK + index,
                lettered: false,
            });
        }
        let first = name.chars().next()?;
        let rank = self
            .domain
            .letters()
            .iter()
            .position(|(letter, _)| *letter == first)?;
        let (_, element) = self.domain.letters().get(rank)?;
        Some(Branch {
            name: name.to_owned(),
            kind: Kind::Element(*element),
            rank,
            lettered: true,
        })
    }

    /// The branch of a kind given by its declared name or by its letter alone.
    pub(crate) fn kind(&self, kind: &str) -> Option<Branch> {
        let known = self.declared.iter().any(|(declared, _)| declared == kind)
            || self
                .domain
                .letters()
                .iter()
                .any(|(letter, _)| kind.strip_prefix(*letter) == Some(""));
        if known { self.branch(kind) } else { None }
    }
}

/// Whether `name` is `kind` followed by digits.
fn is_numbered(name: &str, kind: &str) -> bool {
    name.strip_prefix(kind)
        .is_some_and(|rest| !rest.is_empty() && rest.bytes().all(|byte| byte.is_ascii_digit()))
}

/// Whether a character can start a branch name.
pub(crate) fn starts_name(character: char) -> bool {
    character.is_alphabetic() || character == '_'
}

/// Whether a character can go on in a branch name.
pub(crate) fn continues_name(character: char) -> bool {
    character.is_alphanumeric() || character == '_'
}
