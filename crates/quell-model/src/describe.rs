//! Looking things up in a linear host, and saying what it is.

use quell_expression::Dimension;

use crate::linear::{Coordinate, CoordinateKind, Input, InputKind, LinearHost, Output, Port};

impl LinearHost {
    /// The coordinate of this name with its index.
    #[must_use]
    pub fn coordinate(&self, name: &str) -> Option<(usize, &Coordinate)> {
        find(&self.coordinates, |coordinate| coordinate.name == name)
    }

    /// The input of this name with its index.
    #[must_use]
    pub fn input(&self, name: &str) -> Option<(usize, &Input)> {
        find(&self.inputs, |input| input.name == name)
    }

    /// The port of this name with its index.
    #[must_use]
    pub fn port(&self, name: &str) -> Option<(usize, &Port)> {
        find(&self.ports, |port| port.name == name)
    }

    /// The output of this name with its index.
    #[must_use]
    pub fn output(&self, name: &str) -> Option<(usize, &Output)> {
        find(&self.outputs, |output| output.name == name)
    }

    /// The host in a few lines of words: coordinates with their units, inputs, ports and outputs.
    #[must_use]
    pub fn describe(&self) -> Vec<String> {
        let mut lines = Vec::new();
        let mut line = |what: &str, items: Vec<String>| {
            if !items.is_empty() {
                let plural = if items.len() == 1 { "" } else { "s" };
                lines.push(format!(
                    "{} {what}{plural}: {}",
                    items.len(),
                    items.join(", ")
                ));
            }
        };
        line(
            "coordinate",
            self.coordinates
                .iter()
                .map(|coordinate| with_unit(&coordinate.name, coordinate.kind.dimension()))
                .collect(),
        );
        line(
            "input",
            self.inputs
                .iter()
                .map(|input| {
                    let kind = match (input.kind, input.motion) {
                        (InputKind::Force, CoordinateKind::Translation) => "force",
                        (InputKind::Force, CoordinateKind::Rotation) => "moment",
                        (InputKind::Displacement, CoordinateKind::Translation) => "displacement",
                        (InputKind::Displacement, CoordinateKind::Rotation) => "angle",
                        (InputKind::Velocity, _) => "velocity",
                        (InputKind::Acceleration, _) => "acceleration",
                    };
                    format!("{} ({kind}, {})", input.name, input.dimension.unit_text())
                })
                .collect(),
        );
        line(
            "port",
            self.ports
                .iter()
                .map(|port| with_unit(&port.name, port.kind.dimension()))
                .collect(),
        );
        line(
            "output",
            self.outputs
                .iter()
                .map(|output| with_unit(&output.name, output.dimension))
                .collect(),
        );
        lines
    }
}

fn with_unit(name: &str, dimension: Dimension) -> String {
    if dimension.is_none() {
        name.to_owned()
    } else {
        format!("{name} ({})", dimension.unit_text())
    }
}

fn find<T>(items: &[T], is: impl Fn(&T) -> bool) -> Option<(usize, &T)> {
    items.iter().enumerate().find(|(_, item)| is(item))
}
