//! Aligned columns for a terminal: numbers to the right, the last column to the left and as long as it likes.

/// Spaces between columns.
const GAP: &str = "  ";

/// Rows under a heading; lines that belong to a row stand under it, from its second column on.
#[derive(Debug, Default)]
pub(crate) struct Table {
    heading: Vec<String>,
    rows: Vec<(Vec<String>, Vec<String>)>,
    /// Columns from the first that are texts.
    texts: usize,
}

impl Table {
    /// A table of which the first `texts` columns, and the last, hold words.
    pub(crate) fn new(heading: Vec<String>, texts: usize) -> Self {
        Self {
            heading,
            rows: Vec::new(),
            texts,
        }
    }

    /// Adds a row with lines under it.
    pub(crate) fn row(&mut self, cells: Vec<String>, under: Vec<String>) {
        self.rows.push((cells, under));
    }

    /// The table, indented; lines under a row are broken between words at `width` columns.
    pub(crate) fn text(&self, indent: usize, width: usize) -> String {
        let columns = self.heading.len();
        let widths: Vec<usize> = (0..columns)
            .map(|column| {
                let cells = self.rows.iter().map(|(cells, _)| cells);
                cells
                    .chain(std::iter::once(&self.heading))
                    .filter_map(|cells| cells.get(column))
                    .map(|cell| cell.chars().count())
                    .max()
                    .unwrap_or(0)
            })
            .collect();
        let margin = " ".repeat(indent);
        let line = |cells: &[String]| {
            let mut text = margin.clone();
            for (column, (cell, width)) in cells.iter().zip(&widths).enumerate() {
                if column > 0 {
                    text.push_str(GAP);
                }
                let room = " ".repeat(width.saturating_sub(cell.chars().count()));
                if column < self.texts {
                    text.push_str(cell);
                    text.push_str(&room);
                } else if column + 1 == columns {
                    text.push_str(cell);
                } else {
                    text.push_str(&room);
                    text.push_str(cell);
                }
            }
            format!("{}\n", text.trim_end())
        };
        let under_indent = indent + widths.first().map_or(0, |width| width + GAP.len());
        let mut text = line(&self.heading);
        for (cells, under) in &self.rows {
            text.push_str(&line(cells));
            let room = width.saturating_sub(under_indent).max(24);
            for broken in under.iter().flat_map(|words| wrap(words, room)) {
                text.push_str(&" ".repeat(under_indent));
                text.push_str(&broken);
                text.push('\n');
            }
        }
        text
    }
}

/// Breaks a text at spaces; no-break spaces hold.
pub(crate) fn wrap(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    let mut length = 0;
    for word in text.split(' ').filter(|word| !word.is_empty()) {
        let own = word.chars().count();
        match lines.last_mut() {
            Some(line) if length + 1 + own <= width => {
                line.push(' ');
                line.push_str(word);
                length += 1 + own;
            }
            _ => {
                lines.push(word.to_owned());
                length = own;
            }
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stand_to_the_right_and_words_to_the_left() {
        let cells = |cells: [&str; 3]| cells.map(str::to_owned).to_vec();
        let mut table = Table::new(cells(["name", "value", "layout"]), 1);
        let under = "one two three four five six".to_owned();
        table.row(cells(["a", "1.50", "k1"]), vec![under]);
        table.row(cells(["longer", "10.50", "k1 | c1"]), Vec::new());
        let expected = [
            "  name    value  layout",
            "  a        1.50  k1",
            "          one two three four five",
            "          six",
            "  longer  10.50  k1 | c1",
            "",
        ];
        assert_eq!(table.text(2, 33), expected.join("\n"));
    }
}
