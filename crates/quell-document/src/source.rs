//! The text of a file and the places in it.

use std::fmt;

use quell_expression::Span;

/// A file as it was read, under the name its user knows it by.
#[derive(Clone, PartialEq, Eq)]
pub struct Source {
    /// The path as the user typed it.
    pub name: String,
    /// The whole text.
    pub text: String,
}

impl Source {
    /// A source from its name and text.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            text: text.into(),
        }
    }

    /// Line and column of a byte, both from 1, the column in characters; a byte past the end stands for the end.
    pub fn position(&self, byte: usize) -> (usize, usize) {
        let byte = self.boundary(byte);
        let before = self.text.get(..byte).unwrap_or_default();
        let line = before.bytes().filter(|&byte| byte == b'\n').count() + 1;
        let start = before.rfind('\n').map_or(0, |newline| newline + 1);
        let column = before
            .get(start..)
            .unwrap_or_default()
            .chars()
            .filter(|&character| character != BYTE_ORDER_MARK)
            .count();
        (line, column + 1)
    }

    /// The text of a span, cut to what exists.
    pub(crate) fn slice(&self, span: Span) -> &str {
        let span = self.fitted(span);
        self.text.get(span.start..span.end).unwrap_or_default()
    }

    /// The span moved to the nearest character boundaries at or before its ends, and into the text.
    pub(crate) fn fitted(&self, span: Span) -> Span {
        let start = self.boundary(span.start);
        Span {
            start,
            end: self.boundary(span.end).max(start),
        }
    }

    /// Bytes of the line a byte is in, without its line ending.
    pub(crate) fn line_around(&self, byte: usize) -> Span {
        let byte = self.boundary(byte);
        let (before, after) = self.text.split_at_checked(byte).unwrap_or_default();
        let start = before.rfind('\n').map_or(0, |newline| newline + 1);
        let end = byte + after.find('\n').unwrap_or(after.len());
        let line = self.text.get(start..end).unwrap_or_default();
        Span {
            start,
            end: start + line.strip_suffix('\r').unwrap_or(line).len(),
        }
    }

    fn boundary(&self, byte: usize) -> usize {
        self.text.floor_char_boundary(byte)
    }
}

impl fmt::Debug for Source {
    /// Every fault carries its source: a failed test should not print whole files.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Source")
            .field("name", &self.name)
            .field("bytes", &self.text.len())
            .finish_non_exhaustive()
    }
}

/// Some editors begin a file with it; it is neither shown nor counted.
pub(crate) const BYTE_ORDER_MARK: char = '\u{feff}';

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_lines_and_characters() {
        let source = Source::new("a", "é = 1\r\nb = 2\n");
        assert_eq!(source.position(0), (1, 1));
        assert_eq!(source.position(2), (1, 2));
        assert_eq!(source.position(8), (2, 1));
        assert_eq!(source.position(999), (3, 1));
        assert_eq!(source.position(1), (1, 1), "inside a character");
    }

    #[test]
    fn lines_leave_out_their_ending() {
        let source = Source::new("a", "one\r\ntwo\n");
        assert_eq!(source.slice(source.line_around(1)), "one");
        assert_eq!(source.slice(source.line_around(4)), "one");
        assert_eq!(source.slice(source.line_around(5)), "two");
        assert_eq!(source.slice(source.line_around(9)), "");
        assert_eq!(source.slice(Span::new(7, 3)), "");
    }
}
