//! Drawings of networks: series along the axis between two terminals, parallel as branches side by side.
//!
//! A drawing is first measured (every part knows its length along the axis and its extents across it), then placed.
//! Parts never share space, so labels cannot overlap by construction.

use std::fmt::Write as _;

use crate::symbols::{HALF_LENGTH, Symbol};
use crate::text::{escape, text_width};

const NAME_SIZE: f64 = 13.0;
const VALUE_SIZE: f64 = 11.0;
const NAME_LINE: f64 = 15.0;
const VALUE_LINE: f64 = 13.5;
/// Wire before and after a symbol.
const LEAD: f64 = 6.0;
/// Wire between a group's terminal and its bar.
const STUB: f64 = 7.0;
/// Clear space between neighbouring branches.
const GAP: f64 = 9.0;
const MARGIN: f64 = 3.0;
const TERMINAL: f64 = 3.0;

/// A part of a network, as it is drawn.
#[derive(Debug, Clone, PartialEq)]
pub enum Part {
    /// One element.
    Element {
        /// What it is drawn as.
        symbol: Symbol,
        /// Its name in the layout, such as `k1`.
        name: String,
        /// Its value with its unit, shown under the name.
        value: Option<String>,
    },
    /// A named sub-network with its own design variables.
    Component {
        /// Its name in the layout, such as `track1`.
        name: String,
        /// Lines shown under the name, such as `dL = 0.5000`.
        values: Vec<String>,
        /// What it consists of.
        inner: Box<Part>,
    },
    /// Parts one after the other.
    Series(Vec<Part>),
    /// Parts side by side.
    Parallel(Vec<Part>),
}

/// What a device is connected to at one end.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Terminal {
    /// A point of the host, with its name.
    Point(String),
    /// The ground.
    Ground,
    /// An open end without a name.
    #[default]
    Open,
}

/// A device's network with its two ends.
#[derive(Debug, Clone, PartialEq)]
pub struct Schematic {
    /// The network.
    pub part: Part,
    /// The end drawn first (at the top or at the left).
    pub head: Terminal,
    /// The end drawn last; not drawn where every path ends in a mass.
    pub tail: Terminal,
}

/// The direction from head to tail.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Orientation {
    /// Head at the top: room for values beside the symbols.
    Vertical,
    /// Head at the left: for rows of tables.
    Horizontal,
}

/// How a network is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Style {
    /// The direction from head to tail.
    pub orientation: Orientation,
    /// Show values, not only names.
    pub values: bool,
    /// Draw a component as a frame around its elements rather than as one boxed symbol.
    pub expand: bool,
    /// Draw the terminals and their names.
    pub terminals: bool,
}

impl Style {
    /// A drawing to be read by itself: vertical, with values, components expanded.
    pub const FULL: Self = Self { orientation: Orientation::Vertical, values: true, expand: true, terminals: true };
    /// A drawing for a row of a table: horizontal, names only, components as one symbol.
    pub const ROW: Self = Self { orientation: Orientation::Horizontal, values: false, expand: false, terminals: false };
}

/// A rectangle in the drawing, in its own units (pixels at natural size).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rectangle {
    /// Left edge.
    pub left: f64,
    /// Upper edge.
    pub top: f64,
    /// Right edge.
    pub right: f64,
    /// Lower edge.
    pub bottom: f64,
}

impl Rectangle {
    /// Whether two rectangles share an area; touching edges do not count.
    pub fn overlaps(&self, other: &Self) -> bool {
        self.left < other.right && other.left < self.right && self.top < other.bottom && other.top < self.bottom
    }
}

/// A finished drawing.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    /// The `<svg>` element, for a page or (see [`Drawing::standalone`]) for a file.
    pub svg: String,
    /// Natural width in pixels.
    pub width: f64,
    /// Natural height in pixels.
    pub height: f64,
    /// Every label with the room it takes.
    pub labels: Vec<(String, Rectangle)>,
    /// Every symbol drawn, by the name of its element or component, with the room it takes.
    pub symbols: Vec<(String, Rectangle)>,
}

impl Drawing {
    /// The drawing as a file of its own: with the namespace, a font and a stroke colour for light paper.
    pub fn standalone(&self) -> String {
        self.svg.replacen(
            "<svg ",
            r#"<svg xmlns="http://www.w3.org/2000/svg" color="black" font-family="system-ui, 'Segoe UI', Helvetica, Arial, sans-serif" "#,
            1,
        )
    }
}

impl Schematic {
    /// Draws the network.
    pub fn draw(&self, style: Style) -> Drawing {
        let plan = Plan::of(&self.part, style);
        let mut canvas = Canvas::new(style.orientation);
        let head_length = if style.terminals { 2.0 * TERMINAL + 5.0 } else { 5.0 };
        let tail = if plan.floats { None } else { Some(&self.tail) };
        let end = head_length + plan.length;
        plan.place(&mut canvas, 0.0, head_length, end);
        canvas.terminal(Some(&self.head), 0.0, head_length, -1.0, style.terminals);
        canvas.terminal(tail, 0.0, end, 1.0, style.terminals);
        canvas.finish(&words(&self.part))
    }
}

/// The network in words, for readers who do not see the picture.
fn words(part: &Part) -> String {
    match part {
        Part::Element { symbol, name, value } => match value {
            Some(value) => format!("{} {name} ({value})", symbol.word()),
            None => format!("{} {name}", symbol.word()),
        },
        Part::Component { name, .. } => name.clone(),
        Part::Series(parts) => format!("[{}]", parts.iter().map(words).collect::<Vec<_>>().join(" in series with ")),
        Part::Parallel(parts) => format!("[{}]", parts.iter().map(words).collect::<Vec<_>>().join(" in parallel with ")),
    }
}

/// A measured part: `length` along the axis, `before` and `after` across it.
struct Plan<'a> {
    shape: Shape<'a>,
    length: f64,
    before: f64,
    after: f64,
    /// Ends in the inertial frame, so that no wire leaves it.
    floats: bool,
}

enum Shape<'a> {
    Symbol { symbol: Symbol, name: &'a str, label: Label, boxed: bool },
    Frame { name: &'a str, label: Label, inner: Box<Plan<'a>> },
    Series(Vec<Plan<'a>>),
    Parallel(Vec<Plan<'a>>),
}

/// A name and the lines under it.
struct Label {
    name: String,
    lines: Vec<String>,
    width: f64,
    height: f64,
}

impl Label {
    fn new(name: &str, lines: Vec<String>) -> Self {
        let width = lines
            .iter()
            .map(|line| text_width(line, VALUE_SIZE))
            .fold(text_width(name, NAME_SIZE), f64::max);
        let height = if name.is_empty() { 0.0 } else { NAME_LINE + VALUE_LINE * lines.len() as f64 };
        Self { name: name.to_owned(), lines, width, height }
    }
}

impl<'a> Plan<'a> {
    fn of(part: &'a Part, style: Style) -> Self {
        match part {
            Part::Element { symbol, name, value } => {
                let lines = value.iter().filter(|_| style.values).cloned().collect();
                Self::symbol(*symbol, name, Label::new(name, lines), false, style)
            }
            Part::Component { name, values, inner } => {
                let lines = if style.values { values.clone() } else { Vec::new() };
                let label = Label::new(name, lines);
                let (symbol, single) = emblem(inner);
                // A frame around one element would say nothing.
                if style.expand && !single {
                    Self::frame(name, label, Self::of(inner, style), style)
                } else {
                    Self::symbol(symbol, name, label, !single, style)
                }
            }
            Part::Series(parts) => Self::series(parts.iter().map(|part| Self::of(part, style)).collect()),
            Part::Parallel(parts) => Self::parallel(parts.iter().map(|part| Self::of(part, style)).collect()),
        }
    }

    fn symbol(symbol: Symbol, name: &'a str, label: Label, boxed: bool, style: Style) -> Self {
        let (mut before, mut after) = symbol.half_widths();
        if boxed {
            (before, after) = (before + 5.0, after + 5.0);
        }
        let mut length = 2.0 * (HALF_LENGTH + if style.values { LEAD } else { 3.0 });
        if boxed {
            length += 8.0;
        }
        match style.orientation {
            Orientation::Vertical => {
                length = length.max(label.height + 6.0);
                after += 6.0 + label.width;
            }
            Orientation::Horizontal => {
                length = length.max(label.width + 6.0);
                after += 1.0 + label.height;
            }
        }
        Self { length, before, after, floats: symbol.floats(), shape: Shape::Symbol { symbol, name, label, boxed } }
    }

    fn frame(name: &'a str, label: Label, inner: Self, style: Style) -> Self {
        let (before, mut after) = (inner.before + 7.0, inner.after + 7.0);
        let mut length = inner.length + 8.0;
        match style.orientation {
            Orientation::Vertical => {
                length = length.max(label.height + 6.0);
                after += 6.0 + label.width;
            }
            Orientation::Horizontal => {
                length = length.max(label.width + 6.0);
                after += 2.0 + label.height;
            }
        }
        Self { length, before, after, floats: inner.floats, shape: Shape::Frame { name, label, inner: Box::new(inner) } }
    }

    fn series(mut plans: Vec<Self>) -> Self {
        // The order in a series group is free; what ends in the inertial frame comes last.
        plans.sort_by_key(|plan| plan.floats);
        Self {
            length: plans.iter().map(|plan| plan.length).sum(),
            before: plans.iter().map(|plan| plan.before).fold(0.0, f64::max),
            after: plans.iter().map(|plan| plan.after).fold(0.0, f64::max),
            floats: plans.last().is_some_and(|plan| plan.floats),
            shape: Shape::Series(plans),
        }
    }

    fn parallel(plans: Vec<Self>) -> Self {
        let axes = axes(&plans);
        let first = axes.first().copied().unwrap_or(0.0);
        let last = axes.last().copied().unwrap_or(0.0);
        let floats = !plans.is_empty() && plans.iter().all(|plan| plan.floats);
        Self {
            length: plans.iter().map(|plan| plan.length).fold(0.0, f64::max) + if floats { STUB } else { 2.0 * STUB },
            before: plans.first().map_or(0.0, |plan| plan.before) - first,
            after: plans.last().map_or(0.0, |plan| plan.after) + last,
            floats,
            shape: Shape::Parallel(plans),
        }
    }

    /// Draws the part with its terminals at `from` and `to` on the axis at `across`.
    fn place(&self, canvas: &mut Canvas, across: f64, from: f64, to: f64) {
        // What is shorter than its room sits in the middle; what hangs free sits at the start.
        let spare = (to - from - self.length).max(0.0);
        let (start, end) = if self.floats { (from, from + self.length) } else { (from + spare / 2.0, to - spare / 2.0) };
        canvas.wire(across, from, across, start);
        if !self.floats {
            canvas.wire(across, end, across, to);
        }
        match &self.shape {
            Shape::Symbol { symbol, name, label, boxed } => {
                let middle = f64::midpoint(start, end);
                canvas.wire(across, start, across, middle - HALF_LENGTH);
                if !self.floats {
                    canvas.wire(across, middle + HALF_LENGTH, across, end);
                }
                canvas.symbol(*symbol, name, across, middle, *boxed);
                let (_, half_width) = symbol.half_widths();
                canvas.label(label, across + half_width + if *boxed { 5.0 } else { 0.0 }, across, middle);
            }
            Shape::Frame { name, label, inner } => {
                let middle = f64::midpoint(start, end);
                let half = inner.length / 2.0;
                canvas.wire(across, start, across, middle - half);
                inner.place(canvas, across, middle - half, middle + half);
                if !self.floats {
                    canvas.wire(across, middle + half, across, end);
                }
                canvas.frame(name, across - inner.before - 5.0, middle - half - 0.5, across + inner.after + 5.0, middle + half + 0.5);
                canvas.label(label, across + inner.after + 5.0, across, middle);
            }
            Shape::Series(plans) => {
                let mut position = start;
                for plan in plans {
                    plan.place(canvas, across, position, position + plan.length);
                    position += plan.length;
                }
            }
            Shape::Parallel(plans) => {
                let axes: Vec<f64> = axes(plans).into_iter().map(|axis| across + axis).collect();
                let head_bar = start + STUB;
                let tail_bar = if self.floats { end } else { end - STUB };
                canvas.wire(across, start, across, head_bar);
                canvas.bar(across, axes.iter().copied(), head_bar);
                for (plan, axis) in plans.iter().zip(&axes) {
                    plan.place(canvas, *axis, head_bar, tail_bar);
                }
                if !self.floats {
                    let fixed = plans.iter().zip(&axes).filter(|(plan, _)| !plan.floats).map(|(_, axis)| *axis);
                    canvas.bar(across, fixed, tail_bar);
                    canvas.wire(across, tail_bar, across, end);
                }
            }
        }
    }
}

/// Positions of the branches' axes, relative to the middle between the first and the last.
fn axes(plans: &[Plan]) -> Vec<f64> {
    let mut axes = Vec::with_capacity(plans.len());
    let mut edge = 0.0;
    for plan in plans {
        axes.push(edge + plan.before);
        edge += plan.before + plan.after + GAP;
    }
    let middle = match (axes.first(), axes.last()) {
        (Some(first), Some(last)) => f64::midpoint(*first, *last),
        _ => 0.0,
    };
    axes.into_iter().map(|axis| axis - middle).collect()
}

/// The symbol that stands for a whole component (its first element that stores energy), and whether it is its only one.
fn emblem(part: &Part) -> (Symbol, bool) {
    fn collect(part: &Part, into: &mut Vec<Symbol>) {
        match part {
            Part::Element { symbol, .. } => into.push(*symbol),
            Part::Component { inner, .. } => collect(inner, into),
            Part::Series(parts) | Part::Parallel(parts) => parts.iter().for_each(|part| collect(part, into)),
        }
    }
    let mut symbols = Vec::new();
    collect(part, &mut symbols);
    let dissipative = |symbol: &Symbol| matches!(symbol, Symbol::Damper | Symbol::Restriction | Symbol::Resistor);
    let chosen = symbols.iter().find(|symbol| !dissipative(symbol)).or(symbols.first());
    (chosen.copied().unwrap_or(Symbol::Box), symbols.len() == 1)
}

/// Collects shapes; coordinates are (across, along) and are turned to (x, y) by the orientation.
struct Canvas {
    orientation: Orientation,
    wires: String,
    shapes: String,
    texts: String,
    labels: Vec<(String, Rectangle)>,
    symbols: Vec<(String, Rectangle)>,
    extent: Option<Rectangle>,
}

impl Canvas {
    fn new(orientation: Orientation) -> Self {
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
        self.cover(Rectangle { left, top, right, bottom })
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

    fn wire(&mut self, across1: f64, along1: f64, across2: f64, along2: f64) {
        if (across1 - across2).abs() + (along1 - along2).abs() < 1e-6 {
            return;
        }
        self.rectangle((across1.min(across2), across1.max(across2)), (along1.min(along2), along1.max(along2)));
        let (x1, y1) = self.point(across1, along1);
        let (x2, y2) = self.point(across2, along2);
        let _ = write!(self.wires, "M{x1:.1} {y1:.1}L{x2:.1} {y2:.1}");
    }

    /// A bar across the axis that reaches the axis itself and every branch.
    fn bar(&mut self, across: f64, branches: impl Iterator<Item = f64>, along: f64) {
        let (low, high) = branches.fold((across, across), |(low, high), axis| (low.min(axis), high.max(axis)));
        self.wire(low, along, high, along);
    }

    fn symbol(&mut self, symbol: Symbol, name: &str, across: f64, along: f64, boxed: bool) {
        let (before, after) = symbol.half_widths();
        let room = self.rectangle((across - before, across + after), (along - HALF_LENGTH, along + HALF_LENGTH));
        self.symbols.push((name.to_owned(), room));
        let (x, y) = self.point(across, along);
        let placement = match self.orientation {
            Orientation::Vertical => format!("translate({x:.1} {y:.1})"),
            Orientation::Horizontal => format!("matrix(0 1 1 0 {x:.1} {y:.1})"),
        };
        let _ = write!(self.shapes, r#"<g transform="{placement}">{}"#, symbol.fragments());
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

    fn frame(&mut self, name: &str, across1: f64, along1: f64, across2: f64, along2: f64) {
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
    fn label(&mut self, label: &Label, edge: f64, across: f64, along: f64) {
        if label.height == 0.0 {
            return;
        }
        let (x, top, anchor) = match self.orientation {
            Orientation::Vertical => (edge + 5.0, along - label.height / 2.0, "start"),
            Orientation::Horizontal => (along, edge + 1.0, "middle"),
        };
        let _ = across;
        let mut baseline = top + NAME_LINE - 3.5;
        let _ = write!(
            self.texts,
            r#"<text x="{x:.1}" y="{baseline:.1}" font-size="{NAME_SIZE}" text-anchor="{anchor}">{}</text>"#,
            variable(&label.name)
        );
        self.record(&label.name, x, top, text_width(&label.name, NAME_SIZE), NAME_LINE, anchor);
        for (index, line) in label.lines.iter().enumerate() {
            baseline += VALUE_LINE;
            let _ = write!(
                self.texts,
                r#"<text x="{x:.1}" y="{baseline:.1}" font-size="{VALUE_SIZE}" text-anchor="{anchor}" fill-opacity=".78">{}</text>"#,
                escape(line)
            );
            let line_top = top + NAME_LINE + VALUE_LINE * index as f64;
            self.record(line, x, line_top, text_width(line, VALUE_SIZE), VALUE_LINE, anchor);
        }
    }

    fn record(&mut self, text: &str, x: f64, top: f64, width: f64, height: f64, anchor: &str) {
        let left = if anchor == "middle" { x - width / 2.0 } else { x };
        let room = self.cover(Rectangle { left, top, right: left + width, bottom: top + height });
        self.labels.push((text.to_owned(), room));
    }

    /// A terminal at `along`; `direction` is -1 at the head and 1 at the tail.
    fn terminal(&mut self, terminal: Option<&Terminal>, across: f64, along: f64, direction: f64, shown: bool) {
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
        let room = self.rectangle((across - TERMINAL, across + TERMINAL), (centre - TERMINAL, centre + TERMINAL));
        let (x, y) = self.point(across, centre);
        let _ = write!(self.shapes, r#"<circle cx="{x:.1}" cy="{y:.1}" r="{TERMINAL}"/>"#);
        if let Terminal::Point(name) = terminal {
            let label = Label::new(name, Vec::new());
            match self.orientation {
                // Moved away from the network, so that a wide group beside the axis stays clear.
                Orientation::Vertical => self.label(&label, across + TERMINAL, across, centre + 3.5 * direction),
                Orientation::Horizontal => {
                    let x = if direction < 0.0 { room.left - 4.0 - label.width / 2.0 } else { room.right + 4.0 + label.width / 2.0 };
                    self.label(&label, across - label.height / 2.0 - 1.0, across, x);
                }
            }
        }
    }

    fn finish(self, description: &str) -> Drawing {
        let extent = self.extent.unwrap_or(Rectangle { left: 0.0, top: 0.0, right: 1.0, bottom: 1.0 });
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
        Drawing { svg, width, height, labels: self.labels, symbols: self.symbols }
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
                format!(r#"<tspan font-style="italic">{letter}</tspan><tspan font-size="9.5" dy="3">{number}</tspan>"#)
            }
        }
        _ => escape(name),
    }
}
