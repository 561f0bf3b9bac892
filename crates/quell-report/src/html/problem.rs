//! The problem in words.

use maud::{Markup, html};

use super::{facts, prose};
use crate::number::{SIGNIFICANT_DIGITS, compact, unit};
use crate::page::Problem;

/// What is asked: words, host, excitation, criteria, parameters, bounds, constraints.
pub(super) fn section(problem: &Problem) -> Markup {
    html! {
        section #problem {
            h2 { "Problem" }
            @for paragraph in &problem.paragraphs { p.prose { (prose(paragraph)) } }
            (facts(&problem.facts, "wide"))
            div.columns {
                @if !problem.criteria.is_empty() {
                    div {
                        h3 { "Criteria" }
                        div.scroll { table.plain {
                            thead { tr { th { "Name" } th { "Meaning" } th { "Unit" } } }
                            tbody {
                                @for criterion in &problem.criteria {
                                    tr { th scope="row" { code { (criterion.name) } } td { (prose(&criterion.meaning)) } td { (unit_or_dash(&criterion.unit)) } }
                                }
                            }
                        } }
                    }
                }
                @if !problem.bounds.is_empty() {
                    div {
                        h3 { "Design variables" }
                        div.scroll { table.plain {
                            thead { tr { th { "Variable" } th.number { "From" } th.number { "To" } th { "Unit" } th { "Scale" } } }
                            tbody {
                                @for row in &problem.bounds {
                                    tr {
                                        th scope="row" { code { (row.variable) } }
                                        td.number { (compact(row.bounds.lower, SIGNIFICANT_DIGITS)) }
                                        td.number { (compact(row.bounds.upper, SIGNIFICANT_DIGITS)) }
                                        td { (unit_or_dash(&row.unit)) }
                                        td { @if row.bounds.logarithmic { "logarithmic" } @else { "linear" } }
                                    }
                                }
                            }
                        } }
                    }
                }
                @if !problem.parameters.is_empty() {
                    div {
                        h3 { "Parameters of the host" }
                        div.scroll { table.plain {
                            thead { tr { th { "Name" } th.number { "Value" } th { "Unit" } } }
                            tbody {
                                @for parameter in &problem.parameters {
                                    tr {
                                        th scope="row" { code { (parameter.name) } }
                                        td.number { (compact(parameter.value.value, SIGNIFICANT_DIGITS)) }
                                        td { (unit_or_dash(&parameter.value.unit)) }
                                    }
                                }
                            }
                        } }
                    }
                }
                @if !problem.constraints.is_empty() {
                    div {
                        h3 { "Constraints" }
                        ul { @for constraint in &problem.constraints { li { code { (constraint) } } } }
                    }
                }
            }
        }
    }
}

fn unit_or_dash(text: &str) -> String {
    if text.is_empty() {
        "–".to_owned()
    } else {
        unit(text)
    }
}
