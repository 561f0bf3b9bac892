//! One configuration: its networks, values, criteria.

use maud::{Markup, PreEscaped, html};

use super::count;
use crate::number::{SIGNIFICANT_DIGITS, compact, significant, unit};
use crate::page::{
    Bounds, CriterionColumn, CriterionValue, Design, DesignValue, Device, Quantity, Side,
};
use crate::schematic::{Drawing, Style};

/// A number with its unit after a no-break space.
pub(super) fn number_with_unit(value: f64, unit_text: &str) -> Markup {
    html! {
        (significant(value, SIGNIFICANT_DIGITS))
        @if !unit_text.is_empty() { span.unit { "\u{a0}" (unit(unit_text)) } }
    }
}

/// A quantity with its unit.
pub(super) fn quantity(quantity: &Quantity) -> Markup {
    number_with_unit(quantity.value, &quantity.unit)
}

/// A drawing that shrinks with its column, but never so far that its text cannot be read.
fn scaled(drawing: &Drawing, smallest: f64) -> Markup {
    let width = drawing.width;
    html! {
        div.schematic style={ "--natural:" (format!("{width:.0}")) "px;--least:" (format!("{:.0}", width * smallest)) "px" } {
            (PreEscaped(&drawing.svg))
        }
    }
}

/// How the starts of a search ended; of one that met no constraint none can be said to agree.
pub(super) fn starts(design: &Design) -> String {
    if !design.objective.value.is_finite() {
        "no start has a value".to_owned()
    } else if design.feasible {
        format!(
            "{} of {} agree",
            design.starts_agreeing,
            count(design.starts, "independent start", "independent starts")
        )
    } else if design.violation.is_finite() {
        format!(
            "no feasible start (least violation {}\u{a0}%)",
            significant(design.violation, 3)
        )
    } else {
        "no feasible start".to_owned()
    }
}

/// The same in the width of a column.
pub(super) fn starts_in_short(design: &Design, between: &str) -> String {
    if design.feasible {
        format!("{}{between}{}", design.starts_agreeing, design.starts)
    } else {
        "none feasible".to_owned()
    }
}

/// The networks of a configuration, drawn to be read by themselves.
pub(super) fn large(devices: &[Device]) -> Markup {
    html! {
        @for device in devices {
            figure.network {
                (scaled(&device.schematic.draw(Style::FULL), 0.75))
                figcaption {
                    @if devices.len() > 1 { (device.name) ": " }
                    code { (device.layout) }
                }
            }
        }
    }
}

/// The networks of a configuration for a row of a table.
pub(super) fn small(devices: &[Device]) -> Markup {
    html! {
        @for device in devices {
            div.network {
                (scaled(&device.schematic.draw(Style::ROW), 0.6))
                code.layout {
                    @if devices.len() > 1 { (device.name) ": " }
                    (device.layout)
                }
            }
        }
    }
}

/// Name, value, unit and place between the bounds, one row for each; values that were not searched stand apart below.
pub(super) fn values_table(devices: &[Device]) -> Markup {
    let bounds = any_searched(devices);
    let shown = |value: &&DesignValue| !bounds || value.bounds.is_some();
    let values = || devices.iter().flat_map(|device| device.values.iter());
    let units = values()
        .filter(shown)
        .any(|value| !value.value.unit.is_empty());
    let fixed: Vec<&DesignValue> = values().filter(|value| !shown(value)).collect();
    html! {
        @if values().next().is_some() {
            div.scroll { table.plain.values {
                thead { tr {
                    th { "Variable" } th.number { "Value" }
                    @if units { th { "Unit" } }
                    @if bounds { th { "Between its bounds" } }
                } }
                tbody {
                    @for device in devices {
                        @if devices.len() > 1 && device.values.iter().any(|value| shown(&value)) { tr { th.group colspan="4" { (device.name) } } }
                        @for value in device.values.iter().filter(shown) {
                            tr {
                                th scope="row" { code { (value.name) } }
                                td.number { (significant(value.value.value, SIGNIFICANT_DIGITS)) }
                                @if units { td { (unit(&value.value.unit)) } }
                                @if let Some(range) = &value.bounds { td { (gauge(value, *range)) } }
                            }
                        }
                    }
                }
            } }
            @if !fixed.is_empty() {
                p.evidence {
                    "Fixed: "
                    @for (index, value) in fixed.iter().enumerate() {
                        @if index > 0 { " · " }
                        (pair(value, &compact(value.value.value, SIGNIFICANT_DIGITS)))
                    }
                }
            }
        }
    }
}

/// Whether any value was searched.
fn any_searched(devices: &[Device]) -> bool {
    let mut values = devices.iter().flat_map(|device| device.values.iter());
    values.any(|value| value.bounds.is_some())
}

/// Name, number and unit of a value, held together.
fn pair(value: &DesignValue, number: &str) -> Markup {
    html! {
        span.pair {
            span.name { (value.name) } "\u{a0}"
            (number)
            @if !value.value.unit.is_empty() { span.unit { "\u{a0}" (unit(&value.value.unit)) } }
            @match value.active {
                Some(Side::Lower) => abbr.bound title="at its lower bound" { "▾" },
                Some(Side::Upper) => abbr.bound title="at its upper bound" { "▴" },
                None => {},
            }
        }
    }
}

/// Where a value lies between its bounds; an active bound stands out by colour, weight and words.
fn gauge(value: &DesignValue, bounds: Bounds) -> Markup {
    let position = bounds.position(value.value.value).unwrap_or(0.5);
    html! {
        span.gauge {
            span.end.active[value.active == Some(Side::Lower)] { (compact(bounds.lower, 4)) }
            span.rail.log[bounds.logarithmic] { i.active[value.active.is_some()] style={ "left:" (format!("{:.1}", 100.0 * position)) "%" } {} }
            span.end.active[value.active == Some(Side::Upper)] { (compact(bounds.upper, 4)) }
            @if let Some(side) = value.active { span.tag.alarm { (side_word(side)) } }
        }
    }
}

fn side_word(side: Side) -> &'static str {
    match side {
        Side::Lower => "lower bound",
        Side::Upper => "upper bound",
    }
}

/// The values in one line, for rows of tables; a value at a bound is marked. Where values were searched, only those.
pub(super) fn values_line(devices: &[Device]) -> Markup {
    let searched = any_searched(devices);
    html! {
        @for device in devices { div.values-line {
            @for value in device.values.iter().filter(|value| !searched || value.bounds.is_some()) {
                (pair(value, &significant(value.value.value, SIGNIFICANT_DIGITS)))
            }
        } }
    }
}

/// Whether any value of these devices lies at a bound.
pub(super) fn any_active(devices: &[Device]) -> bool {
    devices
        .iter()
        .any(|device| device.values.iter().any(|value| value.active.is_some()))
}

/// A cell with a criterion's value.
pub(super) fn criterion_cell(value: Option<&CriterionValue>, column: &CriterionColumn) -> Markup {
    html! {
        td.number data-label=(column.name) {
            @match value {
                Some(value) => {
                    span.alarm-text[value.violated] { (significant(value.value, SIGNIFICANT_DIGITS)) }
                    @if !value.note.is_empty() { span.note { (value.note) } }
                },
                None => "–",
            }
        }
    }
}

/// The heading of a criterion's column.
pub(super) fn criterion_head(column: &CriterionColumn) -> Markup {
    html! {
        th.number {
            code { (column.name) }
            @if !column.unit.is_empty() { span.unit { " " (unit(&column.unit)) } }
            @if !column.role.is_empty() { span.note { (column.role) } }
        }
    }
}
