//! The symbols of the field, each drawn once in its own small coordinate system.
//!
//! A symbol lies between two terminals at (0, -17) and (0, 17); the first coordinate runs across the
//! axis, the second along it. The inerter is shown as rack, pinion and flywheel (M. C. Smith, "Synthesis of mechanical
//! networks: the inerter", 2002, figure 1), restriction and chamber follow the hydraulic drawings of ISO 1219.

use std::fmt::Write as _;

/// Half the distance between a symbol's two terminals.
pub(crate) const HALF_LENGTH: f64 = 17.0;

/// What a branch of a network is drawn as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Symbol {
    /// A spring, translational or rotational: a zigzag.
    Spring,
    /// A damper, translational or rotational: a dashpot.
    Damper,
    /// An inerter, translational or rotational: rack and flywheel.
    Inerter,
    /// A mass or a rotary inertia: a block, whose far terminal is the inertial frame.
    Mass,
    /// A hydraulic inertance: a long helical pipe.
    Inertance,
    /// A hydraulic resistance: a pipe narrowed between two arcs.
    Restriction,
    /// A hydraulic compliance: a chamber with a diaphragm.
    Compliance,
    /// An electrical resistor.
    Resistor,
    /// An electrical inductor.
    Inductor,
    /// An electrical capacitor.
    Capacitor,
    /// Anything that has no symbol of its own.
    Box,
}

impl Symbol {
    /// Extent across the axis towards the negative and the positive side.
    pub(crate) fn half_widths(self) -> (f64, f64) {
        match self {
            Self::Spring | Self::Restriction | Self::Inertance => (9.0, 9.0),
            Self::Damper | Self::Compliance | Self::Capacitor => (11.0, 11.0),
            Self::Inerter => (8.0, 19.0),
            Self::Mass => (16.0, 16.0),
            Self::Resistor => (7.0, 7.0),
            Self::Inductor => (2.0, 7.0),
            Self::Box => (12.0, 12.0),
        }
    }

    /// The word a reader would use, for the text alternative.
    pub fn word(self) -> &'static str {
        match self {
            Self::Spring => "spring",
            Self::Damper => "damper",
            Self::Inerter => "inerter",
            Self::Mass => "mass",
            Self::Inertance => "inertance",
            Self::Restriction => "restriction",
            Self::Compliance => "compliance",
            Self::Resistor => "resistor",
            Self::Inductor => "inductor",
            Self::Capacitor => "capacitor",
            Self::Box => "element",
        }
    }

    /// Whether the symbol's far terminal is the inertial frame, so that nothing is drawn beyond it.
    pub(crate) fn floats(self) -> bool {
        matches!(self, Self::Mass)
    }

    /// SVG fragments in the symbol's own coordinates; strokes and their colour come from the group around it.
    pub(crate) fn fragments(self) -> String {
        match self {
            Self::Spring => path("M0-17V-12.5L-8-10.5 8-6.3-8-2.1 8 2.1-8 6.3 8 10.5 0 12.5V17"),
            Self::Damper => {
                // The piston is a little heavier, so that it reads as a plate at small sizes.
                path("M0-17V-1M-9-9V9H9V-9M0 9V17") + r#"<path stroke-width="2.6" d="M-6-1H6"/>"#
            }
            Self::Inerter => {
                // Rack on the axis with teeth towards the flywheel, which turns in a housing on the far terminal.
                path(
                    "M0-17V9M0-8l2.6 1.4L0-5.2l2.6 1.4L0-2.4 2.6-1 0 .4 2.6 1.8 0 3.2 2.6 4.6 0 6M-7-10V13H18V-10M0 13V17",
                ) + r#"<circle cx="10" cy="-.5" r="6.6" fill="currentColor" fill-opacity=".14"/><circle cx="10" cy="-.5" r="1.1" fill="currentColor"/>"#
            }
            Self::Mass => {
                path("M0-17V-11")
                    + r#"<path fill="currentColor" fill-opacity=".14" d="M-15-11H15V11H-15Z"/>"#
            }
            Self::Inertance => path(&helix()),
            Self::Restriction => path("M0-17V17M-8.5-9.5Q1 0-8.5 9.5M8.5-9.5Q-1 0 8.5 9.5"),
            Self::Compliance => path(
                "M0-17V-11.5M0 11.5V17M-4-11.5H4A6 6 0 0 1 10-5.5V5.5A6 6 0 0 1 4 11.5H-4A6 6 0 0 1-10 5.5V-5.5A6 6 0 0 1-4-11.5ZM-10-2Q0 6.5 10-2",
            ),
            Self::Resistor => path("M0-17V-11.5M0 11.5V17M-6-11.5H6V11.5H-6Z"),
            Self::Inductor => {
                path("M0-17V-12a5 3 0 0 1 0 6a5 3 0 0 1 0 6a5 3 0 0 1 0 6a5 3 0 0 1 0 6V17")
            }
            Self::Capacitor => path("M0-17V-3M0 3V17M-9.5-3H9.5M-9.5 3H9.5"),
            Self::Box => path("M0-17V-11M0 11V17M-11-11H11V11H-11Z"),
        }
    }
}

fn path(data: &str) -> String {
    format!(r#"<path d="{data}"/>"#)
}

/// A pipe wound to a helix, seen from the side: a prolate cycloid, mirror-symmetric with three loops.
fn helix() -> String {
    const LOOPS: usize = 3;
    const POINTS_PER_TURN: usize = 14;
    /// Half the depth of a turn along the axis; above pitch/2π, so that every turn crosses itself.
    const DEPTH: f64 = 2.4;
    // A half turn more than there are loops brings both ends in from the same side.
    let steps = LOOPS * POINTS_PER_TURN + POINTS_PER_TURN / 2;
    let mut data = String::from("M0-17V-13.5");
    for step in 1..steps {
        let angle = std::f64::consts::TAU * step as f64 / POINTS_PER_TURN as f64;
        let across = 8.0 * angle.sin();
        let along =
            -13.5 + (27.0 - 2.0 * DEPTH) * step as f64 / steps as f64 + DEPTH * (1.0 - angle.cos());
        let _ = write!(data, "L{across:.1} {along:.1}");
    }
    data.push_str("L0 13.5V17");
    data
}
