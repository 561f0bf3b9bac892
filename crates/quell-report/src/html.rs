//! The report as one self-contained HTML file: no script, nothing to load.

mod design;
mod energy;
mod figure;
mod problem;
mod task;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::page::{Fact, Page, TaskKind, TaskSection};

const STYLE: &str = include_str!("html/style.css");

impl Page {
    /// Writes the report as one HTML file that loads nothing from anywhere.
    pub fn html(&self) -> String {
        html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="color-scheme" content="light dark";
                    title { (self.title) }
                    style { (PreEscaped(STYLE)) }
                }
                body {
                    header {
                        p.kicker { "Quell study report" }
                        h1 { (self.title) }
                        @if !self.subtitle.is_empty() { p.subtitle { (self.subtitle) } }
                        (facts(&self.facts, "run"))
                    }
                    main {
                        (contents(&self.tasks))
                        @for (index, plot) in self.comparisons.iter().enumerate() { (figure::figure(plot, &format!("comparison-{index}"))) }
                        (problem::section(&self.problem))
                        @for (index, section) in self.tasks.iter().enumerate() {
                            (task::section(section, index))
                        }
                    }
                    footer { p { "Numbers are shown rounded; the results file beside this report holds them in full, in SI units." } }
                }
            }
        }
        .into_string()
    }
}

/// A text with what stands between backticks set as code.
fn prose(text: &str) -> Markup {
    html! {
        @for (index, piece) in text.split('`').enumerate() {
            @if index % 2 == 1 { code { (piece) } } @else { (piece) }
        }
    }
}

/// Terms and what they are.
fn facts(facts: &[Fact], class: &str) -> Markup {
    html! {
        @if !facts.is_empty() {
            dl.facts.(class) {
                @for fact in facts { div { dt { (fact.term) } dd { (prose(&fact.text)) } } }
            }
        }
    }
}

/// The task's place on the page.
fn anchor(index: usize) -> String {
    format!("task-{}", index + 1)
}

/// Results at a glance, which is the table of contents as well.
fn contents(tasks: &[TaskSection]) -> Markup {
    html! {
        @if !tasks.is_empty() {
            nav aria-label="Tasks" {
                h2 { "Results at a glance" }
                div.scroll {
                    table.plain.glance {
                        thead { tr { th { "Task" } th { "Result" } th.number { "Value" } th.number { "Improvement" } th.number { "Starts agreeing" } } }
                        tbody {
                            @for (index, task) in tasks.iter().enumerate() { (glance(task, index)) }
                        }
                    }
                }
            }
        }
    }
}

fn glance(task: &TaskSection, index: usize) -> Markup {
    let best = task.designs.first();
    html! {
        tr {
            th scope="row" { a href={ "#" (anchor(index)) } { (task.name) } }
            @if !task.sweep.is_empty() {
                td { (count(task.sweep.len(), "point", "points")) " of a sweep" }
                td {} td {} td {}
            } @else if !task.front.is_empty() {
                td { (count(task.front.len(), "design", "designs")) " on the front" }
                td {} td {} td {}
            } @else if task.kind == TaskKind::Design {
                @if let Some(best) = best {
                    td {
                        code { (best.devices.iter().map(|device| device.layout.as_str()).collect::<Vec<_>>().join("; ")) }
                        @if task.designs.len() > 1 { span.soft { " best of " (task.designs.len()) } }
                        @if !best.feasible { " " span.tag.alarm { "infeasible" } }
                    }
                    td.number { (design::quantity(&best.objective)) }
                    td.number {
                        @if let (Some(gain), Some(reference)) = (best.improvements.first(), task.references.first()) {
                            (crate::number::percent(*gain)) span.soft.on { " on " (reference.name) }
                        }
                    }
                    td.number data-label="starts" { (design::starts_in_short(best, " of ")) }
                } @else { td { (task.status.as_deref().unwrap_or("no design")) } td {} td {} td {} }
            } @else if let Some(points) = &task.points {
                td { (points.found) }
                td {} td {} td {}
            } @else {
                td { (count(task.configurations.len(), "configuration", "configurations")) " evaluated" }
                td.number {
                    @if let (1, Some(only), Some(column)) = (task.configurations.len(), task.configurations.first(), task.criteria.first()) {
                        @if let Some(value) = only.criteria.first() { (design::number_with_unit(value.value, &column.unit)) }
                    }
                }
                td {} td {}
            }
        }
    }
}

fn count(number: usize, one: &str, many: &str) -> String {
    format!("{number} {}", if number == 1 { one } else { many })
}
