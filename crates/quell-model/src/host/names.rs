//! The names of a host file: each stands for one thing.

use std::collections::HashMap;
use std::sync::Arc;

use quell_document::{Fault, Source};
use quell_expression::{Expression, Function, Node, Span};

/// Names already given, with what they stand for.
#[derive(Debug, Default)]
pub(crate) struct Names {
    taken: HashMap<String, &'static str>,
}

/// Names that expressions give a meaning of their own.
const RESERVED: [&str; 4] = ["ground", "force", "stroke", "pi"];

impl Names {
    /// Takes a name that a kind of file gives a meaning of its own.
    pub(crate) fn reserve(&mut self, name: &str, what: &'static str) {
        self.taken.insert(name.to_owned(), what);
    }

    /// Takes a name, which must be fit for expressions and free.
    pub(crate) fn define(
        &mut self,
        source: &Arc<Source>,
        name: &str,
        span: Span,
        what: &'static str,
    ) -> Result<(), Fault> {
        if Function::from_name(name).is_some() || RESERVED.contains(&name) {
            return Err(Fault::at(
                source,
                span,
                format!("`{name}` has a meaning of its own in expressions and cannot be {what}"),
            ));
        }
        let plain = Expression::parse(name)
            .is_ok_and(|read| matches!(&read.node, Node::Name(same) if same == name))
            && !name.contains('.');
        if !plain {
            return Err(Fault::at(
                source,
                span,
                format!("`{name}` cannot be {what}: it could not be used in an expression"),
            )
            .help("a name is letters, digits and underscores, and begins with a letter"));
        }
        if let Some(other) = self.taken.insert(name.to_owned(), what) {
            return Err(Fault::at(
                source,
                span,
                format!("`{name}` is already {other} and cannot be {what} as well"),
            ));
        }
        Ok(())
    }
}
