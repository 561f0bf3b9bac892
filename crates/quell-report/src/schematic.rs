//! Drawings of networks: series along the axis between two terminals, parallel as branches side by side.
//!
//! A drawing is first measured (every part knows its length along the axis and its extents across it), then placed.
//! Parts never share space, so labels cannot overlap by construction.

mod canvas;
mod plan;

use crate::symbols::Symbol;
use canvas::{Canvas, TERMINAL};
use plan::Plan;

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
        /// Its name in the layout, such as `tube1`.
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
    pub const FULL: Self = Self {
        orientation: Orientation::Vertical,
        values: true,
        expand: true,
        terminals: true,
    };
    /// A drawing for a row of a table: horizontal, names only, components as one symbol.
    pub const ROW: Self = Self {
        orientation: Orientation::Horizontal,
        values: false,
        expand: false,
        terminals: false,
    };
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
        self.left < other.right
            && other.left < self.right
            && self.top < other.bottom
            && other.top < self.bottom
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
        let head_length = if style.terminals {
            2.0 * TERMINAL + 5.0
        } else {
            5.0
        };
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
        Part::Element {
            symbol,
            name,
            value,
        } => match value {
            Some(value) => format!("{} {name} ({value})", symbol.word()),
            None => format!("{} {name}", symbol.word()),
        },
        Part::Component { name, .. } => name.clone(),
        Part::Series(parts) => format!(
            "[{}]",
            parts
                .iter()
                .map(words)
                .collect::<Vec<_>>()
                .join(" in series with ")
        ),
        Part::Parallel(parts) => format!(
            "[{}]",
            parts
                .iter()
                .map(words)
                .collect::<Vec<_>>()
                .join(" in parallel with ")
        ),
    }
}
