//! Tables of a document.

use std::sync::Arc;

use quell_expression::{Span, nearest};

use crate::document::TableNode;
use crate::fault::Fault;
use crate::keys::KeySet;
use crate::source::Source;
use crate::value::Value;

/// A table of a document.
#[derive(Debug, Clone)]
pub struct Table<'a> {
    source: &'a Arc<Source>,
    span: Span,
    node: &'a TableNode,
}

impl<'a> Table<'a> {
    pub(crate) fn new(source: &'a Arc<Source>, span: Span, node: &'a TableNode) -> Self {
        Self { source, span, node }
    }

    /// The file the table stands in.
    pub fn source(&self) -> &'a Arc<Source> {
        self.source
    }

    /// The place of the table: its header in brackets, its braces, or the key that implies it.
    pub fn span(&self) -> Span {
        self.span
    }

    /// The dotted path from the root of the document, `runs.kick.inputs`; empty for the root itself.
    pub fn path(&self) -> &'a str {
        &self.node.path
    }

    /// The value of a key.
    pub fn get(&self, key: &str) -> Option<Value<'a>> {
        let entry = self.node.entry(key)?;
        Some(Value::new(self.source, &entry.value))
    }

    /// The value of a key that has to be there.
    ///
    /// # Errors
    ///
    /// A fault at the table that names the missing key.
    pub fn require(&self, key: &str) -> Result<Value<'a>, Fault> {
        self.get(key).ok_or_else(|| self.missing(key, ""))
    }

    /// Every key with its place and value, in file order.
    pub fn entries(&self) -> impl Iterator<Item = (&'a str, Span, Value<'a>)> + use<'a> {
        let source = self.source;
        self.node.entries.iter().map(move |entry| {
            (
                entry.key.as_str(),
                entry.key_span,
                Value::new(source, &entry.value),
            )
        })
    }

    /// The place of a key.
    pub fn key_span(&self, key: &str) -> Option<Span> {
        Some(self.node.entry(key)?.key_span)
    }

    /// How many keys the table has.
    pub fn len(&self) -> usize {
        self.node.entries.len()
    }

    /// Whether the table has no key.
    pub fn is_empty(&self) -> bool {
        self.node.entries.is_empty()
    }

    /// Checks that the table has no key but those defined, and every required one; values are not looked at.
    ///
    /// # Errors
    ///
    /// A fault at the first unknown key, with the nearest valid one or else all of them; or a fault at the table that
    /// names the missing keys.
    pub fn check(&self, keys: &KeySet) -> Result<(), Fault> {
        if keys.others.is_none() {
            for entry in &self.node.entries {
                if keys.key(&entry.key).is_none() {
                    return Err(self.unknown(&entry.key, entry.key_span, keys));
                }
            }
        }
        let missing: Vec<_> = keys
            .keys
            .iter()
            .filter(|key| key.required && self.node.entry(key.name).is_none())
            .collect();
        match missing.as_slice() {
            [] => Ok(()),
            [key] => Err(self.missing(key.name, key.documentation)),
            several => {
                let names = listed(several.iter().map(|key| key.name), "and");
                Err(self.fault(format!("{names} are missing {}", self.place())))
            }
        }
    }

    /// A fault at the table.
    pub fn fault(&self, message: impl Into<String>) -> Fault {
        Fault::at(self.source, self.span, message)
    }

    fn missing(&self, key: &str, documentation: &str) -> Fault {
        let fault = self.fault(format!("`{key}` is missing {}", self.place()));
        if documentation.is_empty() {
            fault
        } else {
            fault.help(format!("`{key}`: {documentation}"))
        }
    }

    fn unknown(&self, key: &str, span: Span, keys: &KeySet) -> Fault {
        let fault = Fault::at(
            self.source,
            span,
            format!("unknown key `{key}` {}", self.place()),
        );
        match nearest(key, keys.keys.iter().map(|key| key.name)) {
            Some(name) => fault
                .label("unknown key")
                .help(format!("did you mean `{name}`?")),
            None if keys.keys.is_empty() => {
                fault.label("unknown key").help("this table takes no keys")
            }
            None => fault.label("unknown key").help(format!(
                "valid keys are {}",
                listed(keys.keys.iter().map(|key| key.name), "and")
            )),
        }
    }

    /// Where the table is, in words.
    fn place(&self) -> String {
        if self.node.path.is_empty() {
            "at the top of the file".to_owned()
        } else {
            format!("in `{}`", self.node.path)
        }
    }
}

/// Names in backticks with commas and a last conjunction.
pub(crate) fn listed<'n>(names: impl IntoIterator<Item = &'n str>, conjunction: &str) -> String {
    let names: Vec<String> = names.into_iter().map(|name| format!("`{name}`")).collect();
    match names.as_slice() {
        [] => String::new(),
        [only] => only.clone(),
        [first @ .., last] => format!("{} {conjunction} {last}", first.join(", ")),
    }
}
