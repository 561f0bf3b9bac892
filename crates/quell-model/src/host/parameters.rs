//! Parameters: in any order, replaced by a study where it wishes.

use std::collections::HashMap;
use std::sync::Arc;

use quell_document::{Fault, Source, Table};
use quell_expression::{Dimension, Quantity, Scope, Span, nearest};

use super::names::Names;
use super::order::order;

/// A parameter of the host that a study replaces.
#[derive(Debug, Clone)]
pub struct Override {
    /// Name of the host's parameter.
    pub name: String,
    /// Its value instead. A plain number stands for SI, save for a frequency.
    pub value: Quantity,
    /// Where the study says so, for messages.
    pub place: Option<(Arc<Source>, Span)>,
}

impl Override {
    /// A replacement that stands in no file.
    pub fn new(name: impl Into<String>, value: Quantity) -> Self {
        Self {
            name: name.into(),
            value,
            place: None,
        }
    }

    fn fault(&self, message: String) -> Fault {
        match &self.place {
            Some((source, span)) => Fault::at(source, *span, message),
            None => Fault::new(message),
        }
    }
}

/// The parameters found so far, with the names of all.
struct Known<'a> {
    values: HashMap<&'a str, Quantity>,
    names: Vec<&'a str>,
}

impl Scope for Known<'_> {
    fn quantity(&self, name: &str) -> Option<Quantity> {
        self.values.get(name).copied()
    }

    fn names(&self) -> Vec<&str> {
        self.names.clone()
    }
}

/// Works out `[parameters]`, in file order.
pub(crate) fn parameters(
    table: Option<&Table<'_>>,
    overrides: &[Override],
    names: &mut Names,
) -> Result<Vec<(String, Quantity)>, Fault> {
    let mut entries = Vec::new();
    if let Some(table) = table {
        for (name, span, value) in table.entries() {
            names.define(table.source(), name, span, "a parameter")?;
            if !(value.is_text() || value.is_number()) {
                return Err(value.fault(format!(
                    "expected a number, or a text with a unit, found {}",
                    value.describe()
                )));
            }
            let expression = value.expression()?;
            entries.push((name, span, value, expression));
        }
    }
    let all: Vec<&str> = entries.iter().map(|(name, ..)| *name).collect();
    for replaced in overrides {
        if !all.contains(&replaced.name.as_str()) {
            let fault = replaced.fault(format!("the host has no parameter `{}`", replaced.name));
            return Err(match nearest(&replaced.name, all.iter().copied()) {
                Some(near) => fault.help(format!("did you mean `{near}`?")),
                None => fault,
            });
        }
    }
    let index: HashMap<&str, usize> = all
        .iter()
        .enumerate()
        .map(|(index, name)| (*name, index))
        .collect();
    let dependencies: Vec<Vec<usize>> = entries
        .iter()
        .map(|(.., expression)| {
            expression
                .names()
                .iter()
                .filter_map(|name| index.get(name).copied())
                .collect()
        })
        .collect();
    let sorted = order(&dependencies).map_err(|cycle| {
        let mut chain: Vec<&str> = cycle
            .iter()
            .filter_map(|&index| all.get(index).copied())
            .collect();
        let first = chain.first().copied().unwrap_or_default();
        chain.push(first);
        let quoted: Vec<String> = chain.iter().map(|name| format!("`{name}`")).collect();
        let message = if cycle.len() == 1 {
            format!("`{first}` is defined by itself")
        } else {
            format!(
                "these parameters are defined by each other: {}",
                quoted.join(" needs ")
            )
        };
        match cycle.first().and_then(|&index| entries.get(index)) {
            Some((_, _, value, _)) => value.fault(message),
            None => Fault::new(message),
        }
    })?;
    let mut known = Known {
        values: HashMap::new(),
        names: all.clone(),
    };
    for index in sorted {
        let (name, _, value, _) = &entries[index];
        let own = value.quantity(&known, None)?;
        let mut quantity = own;
        if let Some(replaced) = overrides
            .iter()
            .rev()
            .find(|replaced| replaced.name == *name)
        {
            quantity = replacement(replaced, own)?;
        }
        known.values.insert(name, quantity);
    }
    Ok(all
        .iter()
        .filter_map(|name| {
            known
                .values
                .get(name)
                .map(|quantity| ((*name).to_owned(), *quantity))
        })
        .collect())
}

fn replacement(replaced: &Override, own: Quantity) -> Result<Quantity, Fault> {
    let given = replaced.value;
    let name = &replaced.name;
    if !given.value.is_finite() {
        return Err(replaced.fault(format!("the value for `{name}` is not a finite number")));
    }
    let plain = given.dimension.is_none();
    if plain && own.dimension == Dimension::ANGULAR_FREQUENCY {
        return Err(replaced
            .fault(format!(
                "a plain number for the frequency `{name}` is ambiguous"
            ))
            .help("write a unit, `Hz` or `rad/s`"));
    }
    if plain || own.dimension.accepts(&given.dimension) {
        return Ok(Quantity::new(given.value, own.dimension));
    }
    Err(replaced.fault(format!(
        "`{name}` is {} in the host, but this is {}",
        in_words(own.dimension),
        in_words(given.dimension)
    )))
}

/// "in `N/m`", or "a plain number".
fn in_words(dimension: Dimension) -> String {
    if dimension.is_none() {
        "a plain number".to_owned()
    } else {
        format!("in `{}`", dimension.unit_text())
    }
}

/// "a quantity in `N/m`", or "a plain number".
pub(crate) fn as_quantity(dimension: Dimension) -> String {
    if dimension.is_none() {
        in_words(dimension)
    } else {
        format!("a quantity {}", in_words(dimension))
    }
}
