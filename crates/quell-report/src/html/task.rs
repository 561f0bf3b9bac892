//! The section of one task.

use maud::{Markup, html};

use super::design::{
    any_active, criterion_cell, criterion_head, large, number_with_unit, quantity, small, starts,
    starts_in_short, values_line, values_table,
};
use super::figure::figure;
use super::{anchor, count, energy, prose};
use crate::number::{SIGNIFICANT_DIGITS, compact, percent, unit};
use crate::page::{
    Configuration, Design, Parameter, PointTable, ReferenceRow, SweepPoint, TaskKind, TaskSection,
};
use crate::plot::{Axis, Plot, Role, Series};

/// Ranks after the first that are shown without being asked for.
const SHOWN: usize = 5;

/// A task with all its results.
pub(super) fn section(task: &TaskSection, index: usize) -> Markup {
    let id = anchor(index);
    html! {
        section.task id=(id) {
            h2 {
                (task.name)
                span.kind { (task.kind.word()) }
                @if let Some(status) = &task.status { span.tag.alarm { (status) } }
            }
            @for words in &task.words { p.prose { (prose(words)) } }
            @if task.sweep.is_empty() {
                (results(task, &task.designs, &task.configurations, &id))
                @if !task.smaller.is_empty() {
                    h3 { "What fewer elements cost" }
                    p.prose { "The best design of each number of elements: every element was taken out or made rigid in turn, and what was left searched anew." }
                    (ranks_table(task, &task.smaller, 0.0, "Elements"))
                }
            } @else {
                (sweep(task, &id))
            }
        }
    }
}

fn results(
    task: &TaskSection,
    designs: &[Design],
    configurations: &[Configuration],
    id: &str,
) -> Markup {
    html! {
        @if let Some(best) = designs.first() { (winner(task, best, designs.len())) }
        @match configurations {
            [] => {},
            [only] => (single(task, only)),
            _ => (configurations_table(task, configurations)),
        }
        (energy::section(configurations))
        @for (index, plot) in task.plots.iter().enumerate() { (figure(plot, &format!("{id}-plot-{index}"))) }
        @if let Some(points) = &task.points { (points_table(points)) }
        @if task.kind == TaskKind::Design && (task.criteria.len() > 1 || !task.references.is_empty()) { (comparison(task, designs.first())) }
        @if designs.len() > 1 { (ranks(task, designs)) }
        @if !task.front.is_empty() { (front(task)) }
    }
}

/// Special points of branches.
fn points_table(points: &PointTable) -> Markup {
    html! {
        @if !points.rows.is_empty() {
            div.scroll { table.plain.snug {
                thead { tr { @for head in &points.heading { th { (head) } } } }
                tbody {
                    @for row in &points.rows {
                        tr { @for cell in row { td.number { (cell) } } }
                    }
                }
            } }
        }
    }
}

/// The best design, large.
fn winner(task: &TaskSection, best: &Design, designs: usize) -> Markup {
    html! {
        div.winner {
            div.networks { (large(&best.devices)) }
            div.numbers {
                p.headline {
                    span.big { (quantity(&best.objective)) }
                    span.what {
                        @if let Some(column) = task.criteria.first() { code { (column.name) } " " }
                        @if designs > 1 { "best of " (count(designs, "layout", "layouts")) } @else { "the only layout" }
                        @if !best.feasible { " " span.tag.alarm { "infeasible" } }
                    }
                }
                @if !best.improvements.is_empty() {
                    ul.gains {
                        @for (gain, reference) in best.improvements.iter().zip(&task.references) {
                            li { strong { (percent(gain.abs())) } " " @if *gain >= 0.0 { "better" } @else { "worse" } " than " (reference.name) }
                        }
                    }
                }
                (values_table(&best.devices))
                p.evidence {
                    (starts(best))
                    " · " (grouped(best.evaluations)) " evaluations"
                    @if !best.certificate.is_empty() { " · " (best.certificate) }
                }
                @for remark in &best.remarks { p.evidence { (prose(remark)) } }
            }
        }
    }
}

/// An only configuration, large.
fn single(task: &TaskSection, only: &Configuration) -> Markup {
    html! {
        div.winner {
            div.networks { (large(&only.devices)) }
            div.numbers {
                p.headline { span.what { (only.name) } }
                table.plain {
                    tbody {
                        @for (column, value) in task.criteria.iter().zip(&only.criteria) {
                            tr {
                                th scope="row" { code { (column.name) } @if !column.role.is_empty() { span.note { (column.role) } } }
                                td.number {
                                    span.value.alarm-text[value.violated] { (number_with_unit(value.value, &column.unit)) }
                                    @if !value.note.is_empty() { span.note { (value.note) } }
                                }
                            }
                        }
                    }
                }
                (values_table(&only.devices))
            }
        }
    }
}

/// The best design's criteria beside those of the references.
fn comparison(task: &TaskSection, best: Option<&Design>) -> Markup {
    html! {
        div.scroll { table.plain.snug {
            thead { tr { th { "Compared with" } @for column in &task.criteria { (criterion_head(column)) } } }
            tbody {
                @if let Some(best) = best {
                    tr.best {
                        th scope="row" { "best design" }
                        @for (index, column) in task.criteria.iter().enumerate() { (criterion_cell(best.criteria.get(index), column)) }
                    }
                }
                @for ReferenceRow { name, words, criteria, infeasible } in &task.references {
                    tr {
                        th scope="row" {
                            (name)
                            @if !words.is_empty() { span.note { (words) } }
                            @if *infeasible { span.note.alarm-text { "infeasible" } }
                        }
                        @for (index, column) in task.criteria.iter().enumerate() { (criterion_cell(criteria.get(index), column)) }
                    }
                }
            }
        } }
    }
}

/// The designs of a front, from one end to the other.
fn front(task: &TaskSection) -> Markup {
    html! {
        h3 { "Designs on the front" }
        table.ranks {
            thead { tr {
                th.number { "No." } th { "Network" } th { "Values" }
                @for column in &task.criteria { (criterion_head(column)) }
                th.number { "Starts" }
            } }
            tbody {
                @for design in &task.front {
                    tr {
                        td.number.rank { (design.rank) }
                        td.drawn { (small(&design.devices)) }
                        td.chosen { (values_line(&design.devices)) }
                        @for (index, column) in task.criteria.iter().enumerate() { (criterion_cell(design.criteria.get(index), column)) }
                        td.number data-label="starts agreeing" { (starts_in_short(design, "/")) }
                    }
                }
            }
        }
        @if task.front.iter().any(|design| any_active(&design.devices)) {
            p.key { span.bound { "▾" } " at its lower bound, " span.bound { "▴" } " at its upper bound" }
        }
    }
}

/// All ranks after the first; a long list is folded.
fn ranks(task: &TaskSection, designs: &[Design]) -> Markup {
    let rest = designs.get(1..).unwrap_or_default();
    // A fold that hides one or two rows costs more than it saves.
    let shown = if rest.len() <= SHOWN + 2 {
        rest.len()
    } else {
        SHOWN
    };
    let (near, far) = rest.split_at_checked(shown).unwrap_or((rest, &[]));
    let best_gain = designs
        .iter()
        .filter_map(|design| design.improvements.first())
        .copied()
        .fold(0.0, f64::max);
    html! {
        h3 { "Further layouts" }
        (ranks_table(task, near, best_gain, "Rank"))
        @if !far.is_empty() {
            details {
                summary { "Ranks " (near.len() + 2) " to " (designs.len()) }
                (ranks_table(task, far, best_gain, "Rank"))
            }
        }
        @if rest.iter().any(|design| any_active(&design.devices)) {
            p.key { span.bound { "▾" } " at its lower bound, " span.bound { "▴" } " at its upper bound" }
        }
    }
}

fn ranks_table(task: &TaskSection, designs: &[Design], best_gain: f64, lead: &str) -> Markup {
    // The first criterion of a design task is its objective and has a column of its own.
    let others = task.criteria.iter().enumerate().skip(1);
    html! {
        table.ranks {
            thead { tr {
                th.number { (lead) } th { "Network" } th { "Values" }
                th.number { @if let Some(column) = task.criteria.first() { code { (column.name) } } @else { "Objective" } }
                @for reference in &task.references { th.number { "Improvement" br; "on " (reference.name) } }
                @for (_, column) in others.clone() { (criterion_head(column)) }
                th.number { "Starts" }
            } }
            tbody {
                @for design in designs {
                    tr {
                        td.number.rank { (design.rank) }
                        td.drawn { (small(&design.devices)) }
                        td.chosen { (values_line(&design.devices)) }
                        td.number data-label="objective" {
                            strong { (quantity(&design.objective)) }
                            @if !design.feasible { span.note.alarm-text { "infeasible" } }
                        }
                        @for (gain, reference) in design.improvements.iter().zip(&task.references) {
                            td.number.gain data-label={ "on " (reference.name) } {
                                (percent(*gain))
                                @if best_gain > 0.0 {
                                    span.bar style={ "width:" (format!("{:.0}", (100.0 * gain / best_gain).clamp(0.0, 100.0))) "%" } {}
                                }
                            }
                        }
                        @for (index, column) in others.clone() { (criterion_cell(design.criteria.get(index), column)) }
                        td.number data-label="starts agreeing" { (starts_in_short(design, "/")) }
                    }
                }
            }
        }
    }
}

fn configurations_table(task: &TaskSection, configurations: &[Configuration]) -> Markup {
    html! {
        table.ranks {
            thead { tr {
                th { "Configuration" } th { "Network" } th { "Values" }
                @for column in &task.criteria { (criterion_head(column)) }
            } }
            tbody {
                @for configuration in configurations {
                    tr {
                        th scope="row" { (configuration.name) }
                        td.drawn { (small(&configuration.devices)) }
                        td.chosen { (values_line(&configuration.devices)) }
                        @for (index, column) in task.criteria.iter().enumerate() { (criterion_cell(configuration.criteria.get(index), column)) }
                    }
                }
            }
        }
    }
}

/// A sweep: its picture, and the results of each point folded under it.
fn sweep(task: &TaskSection, id: &str) -> Markup {
    html! {
        @for (index, plot) in sweep_plots(task).iter().chain(&task.plots).enumerate() { (figure(plot, &format!("{id}-plot-{index}"))) }
        @if task.sweep.iter().any(|point| !point.designs.is_empty()) { (sweep_table(task)) }
        @if task.sweep.iter().any(|point| point.designs.len() > 1 || !point.configurations.is_empty()) {
            details {
                summary { "Everything at each point" }
                @for (index, point) in task.sweep.iter().enumerate() {
                    h3 { (place(point)) }
                    (results(&bare(task), &point.designs, &point.configurations, &format!("{id}-point-{index}")))
                }
            }
        }
    }
}

/// Where a point of a sweep lies.
fn place(point: &SweepPoint) -> Markup {
    html! { @for Parameter { name, value } in &point.at { span.pair { code { (name) } " = " (compact(value.value, SIGNIFICANT_DIGITS)) @if !value.unit.is_empty() { "\u{a0}" (unit(&value.unit)) } " " } } }
}

/// The best design at each point of a sweep.
fn sweep_table(task: &TaskSection) -> Markup {
    html! {
        h3 { "Best design at each point" }
        table.ranks {
            thead { tr {
                th { "At" } th { "Network" } th { "Values" }
                th.number { @if let Some(column) = task.criteria.first() { code { (column.name) } } @else { "Objective" } }
                th.number { "Starts" }
            } }
            tbody {
                @for point in &task.sweep {
                    @let best = point.designs.first();
                    tr {
                        th scope="row" { (place(point)) }
                        td.drawn { @if let Some(best) = best { (small(&best.devices)) } }
                        td.chosen { @if let Some(best) = best { (values_line(&best.devices)) } }
                        td.number data-label="objective" {
                            @if let Some(best) = best {
                                strong { (quantity(&best.objective)) }
                                @if !best.feasible { span.note.alarm-text { "infeasible" } }
                            } @else { "–" }
                        }
                        td.number data-label="starts agreeing" { @if let Some(best) = best { (starts_in_short(best, "/")) } }
                    }
                }
            }
        }
    }
}

/// The task's columns without its results.
fn bare(task: &TaskSection) -> TaskSection {
    TaskSection {
        criteria: task.criteria.clone(),
        references: task.references.clone(),
        kind: task.kind,
        ..TaskSection::default()
    }
}

/// Each criterion over the swept parameter, where there is just one.
fn sweep_plots(task: &TaskSection) -> Vec<Plot> {
    let Some([swept]) = task.sweep.first().map(|point| point.at.as_slice()) else {
        return Vec::new();
    };
    let place = |point: &SweepPoint| {
        point
            .at
            .first()
            .map_or(f64::NAN, |parameter| parameter.value.value)
    };
    let places: Vec<f64> = task.sweep.iter().map(place).collect();
    let x = Axis {
        label: swept.name.clone(),
        unit: swept.value.unit.clone(),
        logarithmic: geometric(&places),
    };
    let names: Vec<String> = task.sweep.first().map_or(Vec::new(), |point| {
        point
            .configurations
            .iter()
            .map(|configuration| configuration.name.clone())
            .collect()
    });
    let columns = if names.is_empty() {
        task.criteria.iter().take(1)
    } else {
        task.criteria.iter().take(task.criteria.len())
    };
    let infeasible = |point: &SweepPoint| point.designs.first().is_some_and(|best| !best.feasible);
    let left_out = if task.sweep.iter().any(infeasible) {
        "; points without a feasible design are left out"
    } else {
        ""
    };
    columns
        .enumerate()
        .map(|(column, criterion)| {
            let curve = |name: &str, value: &dyn Fn(&SweepPoint) -> Option<f64>| Series {
                name: name.to_owned(),
                role: Role::Design,
                points: task
                    .sweep
                    .iter()
                    .map(|point| (place(point), value(point).unwrap_or(f64::NAN)))
                    .collect(),
                peak: None,
                markers: true,
                ..Series::default()
            };
            let series = if names.is_empty() {
                vec![curve("best design", &|point| {
                    // What misses a constraint is no optimum to be compared with others.
                    let best = point.designs.first().filter(|design| design.feasible)?;
                    Some(best.objective.value)
                })]
            } else {
                names
                    .iter()
                    .map(|name| {
                        curve(name, &|point| {
                            let configuration = point
                                .configurations
                                .iter()
                                .find(|configuration| configuration.name == *name)?;
                            configuration.criteria.get(column).map(|value| value.value)
                        })
                    })
                    .collect()
            };
            Plot {
                caption: format!("{} over {}{left_out}", criterion.name, swept.name),
                x: x.clone(),
                y: Axis {
                    label: criterion.name.clone(),
                    unit: criterion.unit.clone(),
                    logarithmic: false,
                },
                series,
                limits: Vec::new(),
                areas: Vec::new(),
            }
        })
        .collect()
}

/// Whether the points lie nearer to a geometric than to an arithmetic progression, over a decade at least.
fn geometric(values: &[f64]) -> bool {
    match values {
        [first, .., last] if *first > 0.0 && *last > 9.9 * first => {
            let middle = values.get(values.len() / 2).copied().unwrap_or(*first);
            let share = (values.len() / 2) as f64 / (values.len() - 1) as f64;
            let arithmetic = first + share * (last - first);
            let logarithmic = first * (last / first).powf(share);
            (middle - logarithmic).abs() < (middle - arithmetic).abs()
        }
        _ => false,
    }
}

/// A count with thin spaces between thousands.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}
