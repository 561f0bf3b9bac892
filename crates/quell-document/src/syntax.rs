//! Faults of the TOML itself, in the user's words.

use std::sync::Arc;

use quell_expression::Span;

use crate::fault::Fault;
use crate::source::Source;

/// The fault for what the parser refused.
pub(crate) fn fault(source: &Arc<Source>, error: &toml::de::Error) -> Fault {
    let length = source.text.len();
    let span = error.span().unwrap_or(length..length);
    let span = Span {
        start: span.start,
        end: span.end,
    };
    let found = source.slice(span);
    let message = error.message();
    if message.starts_with("duplicate key") {
        return Fault::at(source, span, format!("`{found}` is given twice"))
            .label("given before")
            .help("keep one of the two");
    }
    if message.contains("recursi") {
        return Fault::at(source, span, "tables or lists are nested too deeply");
    }
    let fault = Fault::at(source, span, format!("not valid TOML: {message}"));
    match remedy(source, span, message) {
        Some(help) => fault.help(help),
        None => fault,
    }
}

/// What to do about the mistakes people make.
fn remedy(source: &Source, span: Span, message: &str) -> Option<String> {
    let line = source.slice(source.line_around(span.start));
    if let Some((key, value)) = line.split_once('=') {
        let value = value.split('#').next().unwrap_or_default().trim();
        let unquoted = !value.starts_with(['"', '\'', '[', '{', '=']) && !value.is_empty();
        if unquoted && !value.contains(['"', '\'', '=']) {
            return Some(format!(
                "a quantity with a unit, and any other text, goes in quotes: `{} = \"{value}\"`",
                key.trim()
            ));
        }
        if value.is_empty() {
            return Some(format!("give `{}` a value", key.trim()));
        }
    }
    if message.contains("invalid basic string") || message.contains("missing opening quote") {
        return Some("close the text with the quote it began with, on the same line".to_owned());
    }
    if message.contains("unquoted key") {
        return Some(
            "a key of other characters than letters, digits, `_` and `-` goes in quotes: `\"u(lam)\" = …`".to_owned(),
        );
    }
    if message.contains("key with no value") || message.contains("invalid key-value pair") {
        return Some("write `key = value`, or `[table]` for a heading".to_owned());
    }
    None
}

/// The fault for too deep nesting.
pub(crate) fn too_deep(source: &Arc<Source>, span: Span, deepest: usize) -> Fault {
    Fault::at(source, span, "tables or lists are nested too deeply")
        .help(format!("at most {deepest} levels can be read"))
}
