//! A stable band as typed.

use indexmap::IndexMap;
use quell_expression::Span;

use crate::amount::Amount;
use crate::continuation::ParameterRange;

/// Which number of the widest band a criterion is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BandValue {
    /// Upper less lower end.
    Width,
    /// The lower end.
    Lower,
    /// The upper end.
    Upper,
}

impl BandValue {
    /// The names in a study file.
    pub const ALL: [(&'static str, Self); 3] = [
        ("width", Self::Width),
        ("lower", Self::Lower),
        ("upper", Self::Upper),
    ];
}

/// The operating parameter over which the equilibrium must be stable.
#[derive(Debug, Clone)]
pub struct Over {
    /// Its name.
    pub name: String,
    /// Where it stands.
    pub span: Span,
    /// Its range; that of `[operating]` of the host unless given.
    pub range: Option<ParameterRange>,
}

/// A criterion of kind `stable band`.
#[derive(Debug, Clone)]
pub struct BandSpec {
    /// The parameter whose band it is: an element's value or a parameter of the host.
    pub of: String,
    /// Where its name stands.
    pub of_span: Span,
    /// Its range; of a parameter of the host that of `[operating]` unless given.
    pub range: Option<ParameterRange>,
    /// The operating parameter; none where `of` is one itself.
    pub over: Option<Over>,
    /// Which number is wanted.
    pub value: BandValue,
    /// Where the equilibrium is sought: states by name; the `start` of the host unless given.
    pub start: IndexMap<String, Amount>,
    /// Where the criterion stands.
    pub span: Span,
}

impl BandSpec {
    /// Whether the value of a variable of a device is what the band is of.
    pub(crate) fn is_of(&self, keys: &[String]) -> bool {
        keys.contains(&self.of)
    }
}
