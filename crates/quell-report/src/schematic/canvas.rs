//! Shapes and labels collected into an SVG element.

use std::fmt::Write as _;

use super::{Drawing, Orientation, Rectangle, Terminal};
use crate::symbols::{HALF_LENGTH, Symbol};
use crate::text::{escape, text_width};

const NAME_SIZE: f64 = 13.0;
const VALUE_SIZE: f64 = 11.0;
const NAME_LINE: f64 = 15.0;
const VALUE_LINE: f64 = 13.5;
const MARGIN: f64 = 3.0;
/// Radius of a terminal's circle.
pub(super) const TERMINAL: f64 = 3.0;

/// A name and the lines under it.
pub(super) struct Label {
    name: String,
    lines: Vec<String>,
    pub(super) width: f64,
    pub(super) height: f64,
}

impl Label {
    pub(super) fn new(name: &str, lines: Vec<String>) -> Self {
        let width = lines
            .iter()
            .map(|line| text_width(line, VALUE_SIZE))
            .fold(text_width(name, NAME_SIZE), f64::max);
        let height = if name.is_empty() {
            0.0
        } else {
            NAME_LINE + VALUE_LINE * lines.len() as f64
        };
        Self {
            name: name.to_owned(),
            lines,
            width,
            height,
        }
    }
}

/// Collects shapes; coordinates are (across, along) and are turned to (x, y) by the orientation.
pub(super) struct Canvas {
    orientation: Orientation,
    wires: String,
    shapes: String,
    texts: String,
    labels: Vec<(String, Rectangle)>,
    symbols: Vec<(String, Rectangle)>,
    extent: Option<Rectangle>,
}

impl Canvas {
    pub(super) fn new(orientation: Orientation) -> Self {
        Self {
            orientation,
            wires: String::new(),
            shapes: String::new(),
            texts: String::new(),
            labels: Vec::new(),
            symbols: Vec::new(),
            extent: None,
        }
    }

    fn point(&self, across: f64, along: f64) -> (f64, f64) {
        match self.orientation {
            Orientation::Vertical => (across, along),
            Orientation::Horizontal => (along, across),
        }
    }

    fn rectangle(&mut self, across: (f64, f64), along: (f64, f64)) -> Rectangle {
        let (left, top) = self.point(across.0, along.0);
        let (right, bottom) = self.point(across.1, along.1);
        self.cover(Rectangle {
            left,
            top,
            right,
            bottom,
        })
    }

    fn cover(&mut self, rectangle: Rectangle) -> Rectangle {
        self.extent = Some(self.extent.map_or(rectangle, |extent| Rectangle {
            left: extent.left.min(rectangle.left),
            top: extent.top.min(rectangle.top),
            right: extent.right.max(rectangle.right),
            bottom: extent.bottom.max(rectangle.bottom),
        }));
        rectangle
    }

    pub(super) fn wire(&mut self, across1: f64, along1: f64, across2: f64, along2: f64) {
        if (across1 - across2).abs() + (along1 - along2).abs() < 1e-6 {
            return;
        }
        self.rectangle(
            (across1.min(across2), across1.max(across2)),
            (along1.min(along2), along1.max(along2)),
        );
        let (x1, y1) = self.point(across1, along1);
        let (x2, y2) = self.point(across2, along2);
        let _ = write!(self.wires, "M{x1:.1} {y1:.1}L{x2:.1} {y2:.1}");
    }

    /// A bar across the axis that reaches the axis itself and every branch.
    pub(super) fn bar(&mut self, across: f64, branches: impl Iterator<Item = f64>, along: f64) {
        let (low, high) = branches.fold((across, across), |(low, high), axis| {
            (low.min(axis), high.max(axis))
        });
        self.wire(low, along, high, along);
    }

    pub(super) fn symbol(
        &mut self,
        symbol: Symbol,
        name: &str,
        across: f64,
        along: f64,
        boxed: bool,
    ) {
        let (before, after) = symbol.half_widths();
        let spare = if boxed { 4.0 } else { 0.0 };
        let room = self.rectangle(
            (across - before - spare, across + after + spare),
            (along - HALF_LENGTH, along + HALF_LENGTH),
        );
        self.symbols.push((name.to_owned(), room));
        let (x, y) = self.point(across, along);
        let placement = match self.orientation {
            Orientation::Vertical => format!("translate({x:.1} {y:.1})"),
            Orientation::Horizontal => format!("matrix(0 1 1 0 {x:.1} {y:.1})"),
        };
        let _ = write!(
            self.shapes,
            r#"<g transform="{placement}">{}"#,
            symbol.fragments()
        );
        if boxed {
            let _ = write!(
                self.shapes,
                r#"<rect x="{:.1}" y="{:.1}" width="{:.1}" height="{:.1}" rx="5" stroke-width="1" stroke-opacity=".55"/>"#,
                -before - 4.0,
                -HALF_LENGTH - 1.0,
                before + after + 8.0,
                2.0 * HALF_LENGTH + 2.0
            );
        }
        self.shapes.push_str("</g>");
    }

    pub(super) fn frame(
        &mut self,
        name: &str,
        across1: f64,
        along1: f64,
        across2: f64,
        along2: f64,
    ) {
        let room = self.rectangle((across1, across2), (along1, along2));
        self.symbols.push((name.to_owned(), room));
        let _ = write!(
            self.shapes,
            r#"<rect x="{:.1}" y="{:.1}" width="{:.1}" height="{:.1}" rx="7" stroke-width="1" stroke-opacity=".55" stroke-dasharray="4 3"/>"#,
            room.left,
            room.top,
            room.right - room.left,
            room.bottom - room.top
        );
    }

    /// A label beside (vertical) or under (horizontal) something whose far edge is at `edge`.
    pub(super) fn label(&mut self, label: &Label, edge: f64, along: f64) {
        if label.height == 0.0 {
            return;
        }
        let (x, top, anchor) = match self.orientation {
            Orientation::Vertical => (edge + 5.0, along - label.height / 2.0, "start"),
            Orientation::Horizontal => (along, edge + 1.0, "middle"),
        };
        let mut baseline = top + NAME_LINE - 3.5;
        let _ = write!(
            self.texts,
            r#"<text x="{x:.1}" y="{baseline:.1}" font-size="{NAME_SIZE}" text-anchor="{anchor}">{}</text>"#,
            variable(&label.name)
        );
        self.record(
            &label.name,
            x,
            top,
            text_width(&label.name, NAME_SIZE),
            NAME_LINE,
            anchor,
        );
        for (index, line) in label.lines.iter().enumerate() {
            baseline += VALUE_LINE;
            let _ = write!(
                self.texts,
                r#"<text x="{x:.1}" y="{baseline:.1}" font-size="{VALUE_SIZE}" text-anchor="{anchor}" fill-opacity=".78">{}</text>"#,
                escape(line)
            );
            let line_top = top + NAME_LINE + VALUE_LINE * index as f64;
            self.record(
                line,
                x,
                line_top,
                text_width(line, VALUE_SIZE),
                VALUE_LINE,
                anchor,
            );
        }
    }

    fn record(&mut self, text: &str, x: f64, top: f64, width: f64, height: f64, anchor: &str) {
        let left = if anchor == "middle" {
            x - width / 2.0
        } else {
            x
        };
        let room = self.cover(Rectangle {
            left,
            top,
            right: left + width,
            bottom: top + height,
        });
        self.labels.push((text.to_owned(), room));
    }

    /// A terminal at `along`; `direction` is -1 at the head and 1 at the tail.
    pub(super) fn terminal(
        &mut self,
        terminal: Option<&Terminal>,
        across: f64,
        along: f64,
        direction: f64,
        shown: bool,
    ) {
        let Some(terminal) = terminal else { return };
        if !shown {
            self.wire(across, along, across, along + 5.0 * direction);
            return;
        }
        if matches!(terminal, Terminal::Ground) {
            let plate = along + 5.0 * direction;
            self.wire(across, along, across, plate);
            self.wire(across - 14.0, plate, across + 14.0, plate);
            for step in 0..5 {
                let foot = across - 12.0 + 6.0 * f64::from(step);
                self.wire(foot, plate, foot - 4.0, plate + 6.0 * direction);
            }
            return;
        }
        let centre = along + (5.0 + TERMINAL) * direction;
        self.wire(across, along, across, along + 5.0 * direction);
        let room = self.rectangle(
            (across - TERMINAL, across + TERMINAL),
            (centre - TERMINAL, centre + TERMINAL),
        );
        let (x, y) = self.point(across, centre);
        let _ = write!(
            self.shapes,
            r#"<circle cx="{x:.1}" cy="{y:.1}" r="{TERMINAL}"/>"#
        );
        if let Terminal::Point(name) = terminal {
            let label = Label::new(name, Vec::new());
            match self.orientation {
                // Moved away from the network, so that a wide group beside the axis stays clear.
                Orientation::Vertical => {
                    self.label(&label, across + TERMINAL, centre + 3.5 * direction);
                }
                Orientation::Horizontal => {
                    let x = if direction < 0.0 {
                        room.left - 4.0 - label.width / 2.0
                    } else {
                        room.right + 4.0 + label.width / 2.0
                    };
                    self.label(&label, across - label.height / 2.0 - 1.0, x);
                }
            }
        }
    }

    pub(super) fn finish(self, description: &str) -> Drawing {
        let extent = self.extent.unwrap_or(Rectangle {
            left: 0.0,
            top: 0.0,
            right: 1.0,
            bottom: 1.0,
        });
        let (left, top) = (extent.left - MARGIN, extent.top - MARGIN);
        let (width, height) = (extent.right - left + MARGIN, extent.bottom - top + MARGIN);
        let svg = format!(
            concat!(
                r#"<svg viewBox="{left:.1} {top:.1} {width:.1} {height:.1}" width="{width:.0}" height="{height:.0}" role="img" "#,
                r#"fill="none" stroke="currentColor" stroke-width="1.5" stroke-linecap="round" stroke-linejoin="round">"#,
                r#"<title>{title}</title><path d="{wires}"/>{shapes}<g fill="currentColor" stroke="none">{texts}</g></svg>"#
            ),
            left = left,
            top = top,
            width = width,
            height = height,
            title = escape(description),
            wires = self.wires,
            shapes = self.shapes,
            texts = self.texts,
        );
        Drawing {
            svg,
            width,
            height,
            labels: self.labels,
            symbols: self.symbols,
        }
    }
}

/// A name as it is set: one letter with a number becomes an italic letter with a subscript, words stay upright.
fn variable(name: &str) -> String {
    let stem = name.trim_end_matches(|character: char| character.is_ascii_digit());
    let number = name.get(stem.len()..).unwrap_or_default();
    let mut letters = stem.chars();
    match (letters.next(), letters.next()) {
        (Some(letter), None) if letter.is_alphabetic() => {
            let letter = escape(stem);
            if number.is_empty() {
                format!(r#"<tspan font-style="italic">{letter}</tspan>"#)
            } else {
                format!(
                    r#"<tspan font-style="italic">{letter}</tspan><tspan font-size="9.5" dy="3">{number}</tspan>"#
                )
            }
        }
        _ => escape(name),
    }
}
