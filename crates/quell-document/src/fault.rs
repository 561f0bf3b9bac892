//! What is wrong with a document, where, and what to do about it.

use std::fmt::{self, Write as _};
use std::sync::Arc;

use quell_expression::{ExpressionError, Span};

use crate::source::{BYTE_ORDER_MARK, Source};

/// Something wrong in what a user wrote, with the place and a remedy where they are known.
#[derive(Debug, Clone)]
pub struct Fault {
    /// The file at fault.
    pub source: Option<Arc<Source>>,
    /// The bytes of it at fault.
    pub span: Option<Span>,
    /// What is wrong.
    pub message: String,
    /// What to write next to the place.
    pub label: Option<String>,
    /// What to do about it.
    pub help: Option<String>,
}

impl Fault {
    /// A fault of no particular place.
    pub fn new(message: impl Into<String>) -> Self {
        Self {
            source: None,
            span: None,
            message: printable(message.into()),
            label: None,
            help: None,
        }
    }

    /// A fault at a place of a file.
    pub fn at(source: &Arc<Source>, span: Span, message: impl Into<String>) -> Self {
        Self {
            source: Some(Arc::clone(source)),
            span: Some(source.fitted(span)),
            ..Self::new(message)
        }
    }

    /// The fault of an expression whose spans already count from the beginning of the file.
    pub fn from_expression(source: &Arc<Source>, error: ExpressionError) -> Self {
        Self {
            help: error.help.map(printable),
            ..Self::at(source, error.span, error.message)
        }
    }

    /// The same fault with words next to the place.
    #[must_use]
    pub fn label(mut self, label: impl Into<String>) -> Self {
        self.label = Some(printable(label.into()));
        self
    }

    /// The same fault with a remedy.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(printable(help.into()));
        self
    }

    /// Line and column where the fault begins, both from 1, the column in characters.
    pub fn position(&self) -> Option<(usize, usize)> {
        let source = self.source.as_ref()?;
        Some(source.position(self.span?.start))
    }

    /// The fault as plain text: message, place, the line with the part at fault underlined, and the remedy.
    ///
    /// ```
    /// use std::sync::Arc;
    /// use quell_document::{Fault, Source};
    /// use quell_expression::Span;
    ///
    /// let source = Arc::new(Source::new("a.toml", "mass = 0\n"));
    /// let fault = Fault::at(&source, Span::new(7, 8), "a mass must be positive").help("leave it out");
    /// assert_eq!(fault.render(), "\
    /// error: a mass must be positive
    ///  --> a.toml:1:8
    ///   |
    /// 1 | mass = 0
    ///   |        ^
    ///   = help: leave it out
    /// ");
    /// ```
    pub fn render(&self) -> String {
        let mut text = format!("error: {}\n", self.message);
        let mut gutter = 1;
        if let (Some(source), Some(span)) = (&self.source, self.span) {
            let (line, column) = source.position(span.start);
            let number = line.to_string();
            gutter = number.len();
            let excerpt = Excerpt::of(source, source.fitted(span));
            let label = self.label.as_deref().unwrap_or_default();
            let _ = writeln!(text, "{:gutter$}--> {}:{line}:{column}", "", source.name);
            let _ = writeln!(text, "{:gutter$} |", "");
            let _ = writeln!(
                text,
                "{}",
                format!("{number} | {}", excerpt.line).trim_end()
            );
            let carets = "^".repeat(excerpt.width);
            let underline = format!(
                "{:gutter$} | {:indent$}{carets} {label}",
                "",
                "",
                indent = excerpt.indent
            );
            let _ = writeln!(text, "{}", underline.trim_end());
        } else if let Some(source) = &self.source {
            let _ = writeln!(text, " --> {}", source.name);
        }
        if let Some(help) = &self.help {
            let _ = writeln!(text, "{:gutter$} = help: {help}", "");
        }
        text
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.message)?;
        match (&self.source, self.position()) {
            (Some(source), Some((line, _))) => write!(formatter, " ({}, line {line})", source.name),
            (Some(source), None) => write!(formatter, " ({})", source.name),
            (None, _) => Ok(()),
        }
    }
}

impl std::error::Error for Fault {}

/// Names in messages come from files: a control character among them must not reach the terminal.
fn printable(text: String) -> String {
    if text.chars().any(char::is_control) {
        text.replace(char::is_control, "\u{fffd}")
    } else {
        text
    }
}

/// One line of a file made fit to show, and where in it the carets go.
struct Excerpt {
    line: String,
    indent: usize,
    width: usize,
}

/// A tab is shown as so many blanks, wherever it stands.
const TAB: &str = "    ";
/// Of a longer line only the part around the fault is shown.
const LONGEST: usize = 160;

impl Excerpt {
    fn of(source: &Source, span: Span) -> Self {
        let whole = source.line_around(span.start);
        let mut line = String::new();
        let (mut column, mut indent, mut end) = (0, None, None);
        for (place, character) in source.slice(whole).char_indices() {
            let place = whole.start + place;
            if indent.is_none() && place >= span.start {
                indent = Some(column);
            }
            if end.is_none() && place >= span.end {
                end = Some(column);
            }
            match character {
                '\t' => {
                    line.push_str(TAB);
                    column += TAB.len();
                }
                BYTE_ORDER_MARK => {}
                // A control character in a broken file must not reach the terminal.
                character => {
                    line.push(if character.is_control() {
                        char::REPLACEMENT_CHARACTER
                    } else {
                        character
                    });
                    column += 1;
                }
            }
        }
        let indent = indent.unwrap_or(column);
        let width = end.unwrap_or(column).saturating_sub(indent).max(1);
        Self {
            line,
            indent,
            width,
        }
        .shortened(column)
    }

    /// The part of a very long line around the fault.
    fn shortened(self, columns: usize) -> Self {
        if columns <= LONGEST {
            return self;
        }
        let skipped = self.indent.saturating_sub(LONGEST / 4);
        let mut line: String = self.line.chars().skip(skipped).take(LONGEST).collect();
        let mut indent = self.indent - skipped;
        if skipped > 0 {
            line.insert(0, '…');
            indent += 1;
        }
        if skipped + LONGEST < columns {
            line.push('…');
        }
        Self {
            line,
            indent,
            width: self.width.min((LONGEST + 1).saturating_sub(indent)).max(1),
        }
    }
}
