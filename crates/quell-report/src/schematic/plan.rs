//! Parts measured and placed.

use super::canvas::{Canvas, Label};
use super::{Orientation, Part, Style};
use crate::symbols::{HALF_LENGTH, Symbol};

/// Wire before and after a symbol.
const LEAD: f64 = 6.0;
/// Wire between a group's terminal and its bar.
const STUB: f64 = 7.0;
/// Clear space between neighbouring branches.
const GAP: f64 = 9.0;

/// A measured part: `length` along the axis, `before` and `after` across it.
pub(super) struct Plan<'a> {
    shape: Shape<'a>,
    pub(super) length: f64,
    before: f64,
    after: f64,
    /// Ends in the inertial frame, so that no wire leaves it.
    pub(super) floats: bool,
}

enum Shape<'a> {
    Symbol {
        symbol: Symbol,
        name: &'a str,
        label: Label,
        boxed: bool,
    },
    Frame {
        name: &'a str,
        label: Label,
        inner: Box<Plan<'a>>,
    },
    Series(Vec<Plan<'a>>),
    Parallel(Vec<Plan<'a>>),
}

impl<'a> Plan<'a> {
    pub(super) fn of(part: &'a Part, style: Style) -> Self {
        match part {
            Part::Element {
                symbol,
                name,
                value,
            } => {
                let lines = value.iter().filter(|_| style.values).cloned().collect();
                Self::symbol(*symbol, name, Label::new(name, lines), false, style)
            }
            Part::Component {
                name,
                values,
                inner,
            } => {
                let lines = if style.values {
                    values.clone()
                } else {
                    Vec::new()
                };
                let label = Label::new(name, lines);
                let (symbol, single) = emblem(inner);
                // A frame around one element would say nothing.
                if style.expand && !single {
                    Self::frame(name, label, Self::of(inner, style), style)
                } else {
                    Self::symbol(symbol, name, label, !single, style)
                }
            }
            Part::Series(parts) => {
                Self::series(parts.iter().map(|part| Self::of(part, style)).collect())
            }
            Part::Parallel(parts) => {
                Self::parallel(parts.iter().map(|part| Self::of(part, style)).collect())
            }
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
        Self {
            length,
            before,
            after,
            floats: symbol.floats(),
            shape: Shape::Symbol {
                symbol,
                name,
                label,
                boxed,
            },
        }
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
        Self {
            length,
            before,
            after,
            floats: inner.floats,
            shape: Shape::Frame {
                name,
                label,
                inner: Box::new(inner),
            },
        }
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
            length: plans.iter().map(|plan| plan.length).fold(0.0, f64::max)
                + if floats { STUB } else { 2.0 * STUB },
            before: plans.first().map_or(0.0, |plan| plan.before) - first,
            after: plans.last().map_or(0.0, |plan| plan.after) + last,
            floats,
            shape: Shape::Parallel(plans),
        }
    }

    /// Draws the part with its terminals at `from` and `to` on the axis at `across`.
    pub(super) fn place(&self, canvas: &mut Canvas, across: f64, from: f64, to: f64) {
        // What is shorter than its room sits in the middle; what hangs free sits at the start.
        let spare = (to - from - self.length).max(0.0);
        let (start, end) = if self.floats {
            (from, from + self.length)
        } else {
            (from + spare / 2.0, to - spare / 2.0)
        };
        canvas.wire(across, from, across, start);
        if !self.floats {
            canvas.wire(across, end, across, to);
        }
        match &self.shape {
            Shape::Symbol {
                symbol,
                name,
                label,
                boxed,
            } => {
                let middle = f64::midpoint(start, end);
                canvas.wire(across, start, across, middle - HALF_LENGTH);
                if !self.floats {
                    canvas.wire(across, middle + HALF_LENGTH, across, end);
                }
                canvas.symbol(*symbol, name, across, middle, *boxed);
                let (_, half_width) = symbol.half_widths();
                canvas.label(
                    label,
                    across + half_width + if *boxed { 5.0 } else { 0.0 },
                    middle,
                );
            }
            Shape::Frame { name, label, inner } => {
                let middle = f64::midpoint(start, end);
                let half = inner.length / 2.0;
                canvas.wire(across, start, across, middle - half);
                inner.place(canvas, across, middle - half, middle + half);
                if !self.floats {
                    canvas.wire(across, middle + half, across, end);
                }
                canvas.frame(
                    name,
                    across - inner.before - 5.0,
                    middle - half - 0.5,
                    across + inner.after + 5.0,
                    middle + half + 0.5,
                );
                canvas.label(label, across + inner.after + 5.0, middle);
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
                    let fixed = plans
                        .iter()
                        .zip(&axes)
                        .filter(|(plan, _)| !plan.floats)
                        .map(|(_, axis)| *axis);
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
            Part::Series(parts) | Part::Parallel(parts) => {
                for part in parts {
                    collect(part, into);
                }
            }
        }
    }
    let mut symbols = Vec::new();
    collect(part, &mut symbols);
    let dissipative = |symbol: &Symbol| {
        matches!(
            symbol,
            Symbol::Damper | Symbol::Restriction | Symbol::Resistor
        )
    };
    let chosen = symbols
        .iter()
        .find(|symbol| !dissipative(symbol))
        .or(symbols.first());
    (chosen.copied().unwrap_or(Symbol::Box), symbols.len() == 1)
}
