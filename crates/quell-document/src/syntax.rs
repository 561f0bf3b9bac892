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
    let found = source.slice(span).trim();
    let (message, help) = in_words(error.message(), found, at_line_end(source, span));
    Fault {
        help,
        ..Fault::at(source, span, message)
    }
}

/// The fault for too deep nesting.
pub(crate) fn too_deep(source: &Arc<Source>, span: Span, deepest: usize) -> Fault {
    Fault::at(source, span, "tables or lists are nested too deeply")
        .help(format!("at most {deepest} levels can be read"))
}

/// What is wrong and what to do, from the parser's words and the text it points at.
fn in_words(error: &str, found: &str, at_line_end: bool) -> (String, Option<String>) {
    let is = |beginning: &str| error.starts_with(beginning);
    let (message, help) = if is("duplicate key") {
        (format!("`{found}` is given twice"), "keep one of the two")
    } else if is("cannot extend value") {
        (
            format!("`{found}` has a value already, so nothing can be put inside it"),
            "give the further keys another name",
        )
    } else if error.contains("recursi") {
        (
            "tables or lists are nested too deeply".to_owned(),
            "use fewer levels",
        )
    } else if is("string values must be quoted") || is("invalid boolean") {
        return unquoted(found);
    } else if error.contains("visible characters") && found.chars().any(char::is_control) {
        (
            "this character cannot be shown, and TOML does not allow it".to_owned(),
            "remove it; in double quotes it may be written as an escape such as `\\u0007`",
        )
    } else if error.contains(" string,") && is("invalid") && at_line_end {
        (
            "a text is not closed".to_owned(),
            "close it with the quote it began with, on the same line",
        )
    } else if is("invalid literal string") || is("missing value") || is("invalid value") {
        (
            "a value is missing".to_owned(),
            "write a number, a text in quotes, `true`, `false`, a list in `[ ]` or a table in `{ }`",
        )
    } else if error.contains("escape") {
        (
            "a backslash begins an escape, and this is none".to_owned(),
            "write the backslash twice, or put the text in single quotes",
        )
    } else if is("unexpected leading zero") {
        (
            "a number may not begin with a superfluous zero".to_owned(),
            "leave the zero out",
        )
    } else if is("invalid mantissa") || is("invalid fraction") || is("invalid exponent") {
        (
            "a number lacks digits".to_owned(),
            "a decimal point needs digits on both sides, such as `0.5` or `5.0`",
        )
    } else if is("unquoted keys cannot be empty") {
        ("a key is missing".to_owned(), "write `key = value`")
    } else if is("invalid unquoted key") {
        (
            "a key has a character that needs quotes".to_owned(),
            "a key with other than letters, digits, `_` and `-` goes in quotes, such as `\"u(x)\" = 1`",
        )
    } else if is("key with no value") || is("invalid key-value pair") {
        (
            "a key has no value".to_owned(),
            "write `key = value`, or `[table]` for a heading",
        )
    } else if is("missing comma between array elements") || is("unclosed array,") {
        (
            "a list is not closed, or lacks a comma".to_owned(),
            "separate values with `,` and end the list with `]`",
        )
    } else if is("missing comma between key-value pairs") || is("unclosed inline table") {
        (
            "a table is not closed, or lacks a comma".to_owned(),
            "separate keys with `,` and end the table with `}`",
        )
    } else if is("unclosed table") || is("unclosed array table") {
        (
            "a heading is not closed".to_owned(),
            "write `[table]`, or `[[list]]` for one of several",
        )
    } else if is("unexpected key or value") {
        (
            "something follows the value".to_owned(),
            "begin a new line for the next key, or put the whole value in quotes",
        )
    } else if is("extra `=`") {
        ("one `=` is enough".to_owned(), "write `key = value`")
    } else {
        return (format!("not valid TOML: {error}"), None);
    };
    (message, Some(help.to_owned()))
}

/// The parser takes whatever is no number, boolean or date for a text without quotes.
fn unquoted(found: &str) -> (String, Option<String>) {
    if found.is_empty() {
        return in_words("missing value", found, false);
    }
    let message = format!("`{found}` is neither a number nor a text in quotes");
    let small = found.to_lowercase();
    let help = if small == "true" || small == "false" {
        format!("write `{small}`")
    } else if !found.contains(|character: char| character.is_alphabetic()) {
        "write one number; values of a list are separated by `,`".to_owned()
    } else if found.contains(['"', '\'']) {
        "put the whole text in quotes".to_owned()
    } else {
        format!("write it in quotes: `\"{found}\"`")
    };
    (message, Some(help))
}

/// Whether nothing of the line is left where the span begins.
fn at_line_end(source: &Source, span: Span) -> bool {
    span.start >= source.line_around(span.start).end
}
