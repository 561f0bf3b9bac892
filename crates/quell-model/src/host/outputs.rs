//! `[outputs]`: named combinations of signals, in any order.

use quell_document::{Fault, Table};
use quell_expression::{Expression, Node};

use super::file::Host;
use super::names::Names;
use super::order::order;
use crate::linear::Output;

/// Reads all outputs.
pub(super) fn outputs(host: &mut Host, table: &Table<'_>, names: &mut Names) -> Result<(), Fault> {
    let mut entries = Vec::new();
    for (name, span, value) in table.entries() {
        names.define(table.source(), name, span, "an output")?;
        let expression = value.expression()?;
        entries.push((name, value, expression));
    }
    let dependencies: Vec<Vec<usize>> = entries
        .iter()
        .map(|(_, _, expression)| {
            let mut found = Vec::new();
            signals(expression, &mut |used| {
                found.extend(entries.iter().position(|(name, ..)| *name == used));
            });
            found
        })
        .collect();
    let sorted = order(&dependencies).map_err(|cycle| {
        let chain: Vec<String> = cycle
            .iter()
            .chain(cycle.first())
            .filter_map(|&index| entries.get(index))
            .map(|(name, ..)| format!("`{name}`"))
            .collect();
        let message = format!(
            "these outputs are defined by each other: {}",
            chain.join(" needs ")
        );
        match cycle.first().and_then(|&index| entries.get(index)) {
            Some((_, value, _)) => value.fault(message),
            None => Fault::new(message),
        }
    })?;
    for index in sorted {
        let (name, _, expression) = &entries[index];
        let (form, dimension) = host
            .form(expression)
            .map_err(|error| Fault::from_expression(table.source(), error))?;
        host.linear.outputs.push(Output {
            name: (*name).to_owned(),
            form,
            dimension,
        });
    }
    host.linear
        .outputs
        .sort_by_key(|output| entries.iter().position(|(name, ..)| *name == output.name));
    Ok(())
}

/// Visits the names that stand for signals or constants; arguments of `force` and `stroke` are names of parts.
fn signals<'a>(expression: &'a Expression, visit: &mut impl FnMut(&'a str)) {
    let mut left_to_see = vec![expression];
    while let Some(expression) = left_to_see.pop() {
        match &expression.node {
            Node::Name(name) => visit(name),
            Node::Call { function, .. } if matches!(function.as_str(), "force" | "stroke") => {}
            _ => left_to_see.extend(expression.parts()),
        }
    }
}
