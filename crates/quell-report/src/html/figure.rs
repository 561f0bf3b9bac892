//! Plots on the page: a wide and a narrow rendering, and a legend in real text.

use maud::{Markup, PreEscaped, html};

use super::design::number_with_unit;
use super::prose;
use crate::number::{significant, unit};
use crate::plot::{Area, LIMIT, Plot, SHADE, colour};

/// Areas, the first of each name.
fn listed(plot: &Plot) -> Vec<&Area> {
    let mut found: Vec<&Area> = Vec::new();
    for area in &plot.areas {
        if !found.iter().any(|known| known.name == area.name) {
            found.push(area);
        }
    }
    found
}

/// A plot with its legend and caption; `id` is unique on the page.
pub(super) fn figure(plot: &Plot, id: &str) -> Markup {
    // What is shaded has two axes of equal standing.
    let (broad, slim) = if plot.areas.is_empty() {
        (360.0, 330.0)
    } else {
        (540.0, 400.0)
    };
    html! {
        figure.plot {
            // Two renderings, because text in a scaled picture is unreadable on a phone; style shows one of them.
            div.broad { (PreEscaped(plot.inline(880.0, broad, &format!("{id}-w")))) }
            div.slim aria-hidden="true" { (PreEscaped(plot.inline(400.0, slim, &format!("{id}-n")))) }
            ul.legend {
                @for area in listed(plot) {
                    li {
                        svg viewBox="0 0 30 10" width="30" height="10" aria-hidden="true" {
                            @if area.hue > 0 {
                                path d="M1 0H29V10H1Z" fill=(colour(area.hue)) fill-opacity=(SHADE) {}
                            } @else {
                                path d="M1 1H29V9H1Z" fill="none" stroke="currentColor" stroke-width="0.6" {}
                            }
                        }
                        span { (area.name) }
                    }
                }
                @for (series, stroke) in plot.series.iter().zip(plot.strokes()).filter(|(series, _)| !series.unlisted) {
                    li {
                        svg viewBox="0 0 30 10" width="30" height="10" aria-hidden="true" {
                            path d="M1 5H29" fill="none" stroke=(stroke.colour) stroke-width="2" stroke-dasharray=[stroke.dashes] {}
                            @if series.peak.is_some() || series.markers || !series.marks.is_empty() { circle cx="15" cy="5" r="3.4" fill=(stroke.colour) {} }
                        }
                        span { (series.name) }
                        @if let Some((x, y)) = series.peak {
                            span.soft { (number_with_unit(y, &plot.y.unit)) " at " (significant(x, 4)) @if !plot.x.unit.is_empty() { "\u{a0}" (unit(&plot.x.unit)) } }
                        }
                    }
                }
                @for (text, height) in plot.limits.iter().filter(|(_, height)| height.is_finite()) {
                    li {
                        svg viewBox="0 0 30 10" width="30" height="10" aria-hidden="true" {
                            path d="M1 5H29" fill="none" stroke=(LIMIT) stroke-width="1.4" stroke-dasharray="6 3" {}
                        }
                        span { (text) }
                        span.soft { (number_with_unit(*height, &plot.y.unit)) }
                    }
                }
            }
            @if !plot.caption.is_empty() { figcaption { (prose(&plot.caption)) } }
        }
    }
}
