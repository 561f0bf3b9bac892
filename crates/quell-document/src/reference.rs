//! The reference of a document's keys, for people.

use std::fmt::Write as _;

use crate::keys::{KeySet, Shape, Tables};

/// The reference, in Markdown, of a document whose root table has these keys.
///
/// The root stands under a first-level heading; each nested table definition follows once, under a second-level one.
pub fn reference_markdown(root: &KeySet) -> String {
    let tables = Tables::under(root);
    let mut text = String::new();
    section(&mut text, "#", root, &tables);
    for named in &tables.nested {
        text.push('\n');
        section(&mut text, "##", named.keys, &tables);
    }
    text
}

fn section(text: &mut String, heading: &str, keys: &KeySet, tables: &Tables) {
    let _ = writeln!(text, "{heading} {}", keys.title);
    if !keys.documentation.is_empty() {
        let _ = writeln!(text, "\n{}", keys.documentation);
    }
    if keys.keys.is_empty() && keys.others.is_none() {
        return;
    }
    text.push_str("\n| Key | Value | Required | Meaning |\n|---|---|---|---|\n");
    for key in keys.keys {
        let required = if key.required { "yes" } else { "" };
        row(
            text,
            &format!("`{}`", key.name),
            &words(&key.shape, tables),
            required,
            key.documentation,
        );
    }
    if let Some((names, shape, documentation)) = &keys.others {
        row(
            text,
            &format!("*{names}*"),
            &words(shape, tables),
            "",
            documentation,
        );
    }
}

fn row(text: &mut String, key: &str, value: &str, required: &str, meaning: &str) {
    let _ = writeln!(
        text,
        "| {} | {} | {required} | {} |",
        cell(key),
        cell(value),
        cell(meaning)
    );
}

/// The text on one line, bars escaped: they would end the cell even inside code.
fn cell(text: &str) -> String {
    text.split_whitespace()
        .collect::<Vec<_>>()
        .join(" ")
        .replace('|', "\\|")
}

fn words(shape: &Shape, tables: &Tables) -> String {
    match shape {
        Shape::Text => "text".to_owned(),
        Shape::Number => "number".to_owned(),
        Shape::Integer => "integer".to_owned(),
        Shape::Boolean => "`true` or `false`".to_owned(),
        Shape::Amount => "amount".to_owned(),
        Shape::Expression => "expression".to_owned(),
        Shape::Choice(texts) => texts
            .iter()
            .map(|text| format!("`\"{text}\"`"))
            .collect::<Vec<_>>()
            .join(" or "),
        Shape::List(inner) => format!("list of: {}", words(inner, tables)),
        Shape::Table(keys) => match tables.anchor(keys) {
            Some(anchor) => format!("[table: {}](#{anchor})", keys.title),
            None => format!("table: {}", keys.title),
        },
        Shape::MapOf(inner) => format!("table of names, each: {}", words(inner, tables)),
        Shape::AnyOf(shapes) => shapes
            .iter()
            .map(|shape| words(shape, tables))
            .collect::<Vec<_>>()
            .join(", or "),
        Shape::Anything => "anything".to_owned(),
    }
}
