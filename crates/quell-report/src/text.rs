//! Widths of set text and XML escaping, shared by every picture.

/// Upper estimate of the width of `text` set in a sans-serif face at `size`, in the unit of `size`.
///
/// Advance widths of DejaVu Sans rounded up, one of the widest common faces, so that what fits by this estimate fits in the reader's font too.
pub(crate) fn text_width(text: &str, size: f64) -> f64 {
    text.chars().map(advance).sum::<f64>() * size
}

fn advance(character: char) -> f64 {
    match character {
        'i' | 'j' | 'l' | '.' | ',' | '\'' | ':' | ';' | '|' | ' ' | '·' => 0.33,
        'f' | 'r' | 't' | '/' | '(' | ')' | '[' | ']' | 'I' | 'J' => 0.42,
        '⁰' | '¹' | '²' | '³' | '⁴' | '⁵' | '⁶' | '⁷' | '⁸' | '⁹' | '⁻' => 0.45,
        'a'..='z' if !matches!(character, 'm' | 'w') => 0.62,
        '0'..='9' => 0.64,
        'm' | 'w' | 'M' | 'W' | '@' | '%' => 0.99,
        '=' | '+' | '<' | '>' | '−' | '×' | '~' => 0.84,
        _ if character.is_ascii() => 0.74,
        // Wide scripts take a full square.
        _ if character > '\u{2e7f}' => 1.05,
        _ => 0.8,
    }
}

/// Escapes `text` for XML and HTML content and attributes.
pub(crate) fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            // Control characters are not allowed in XML at all.
            control if control.is_control() => escaped.push(' '),
            other => escaped.push(other),
        }
    }
    escaped
}
