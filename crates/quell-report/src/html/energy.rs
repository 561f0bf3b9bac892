//! Where the energy of runs in time went: a stacked bar and the numbers for every configuration.

use maud::{Markup, html};

use crate::number::significant;
use crate::page::{Configuration, EnergyBars};

/// Kinds in the order of the bar, with the words of the legend and the colour.
const KINDS: [(&str, &str, &str); 6] = [
    ("motion", "left in motion", "var(--baseline, #7a828a)"),
    ("potential", "in springs", "var(--design-1, #0072b2)"),
    (
        "kinetic",
        "in inerters and masses of devices",
        "var(--design-3, #009e73)",
    ),
    ("dissipated", "dissipated", "var(--design-2, #d55e00)"),
    ("other", "other", "var(--design-4, #b0578d)"),
    (
        "host",
        "taken by the host's own forces",
        "var(--grid, #c9ced3)",
    ),
];

/// The energy sections of a task: one for each run in time.
pub(super) fn section(configurations: &[Configuration]) -> Markup {
    let mut runs: Vec<&str> = Vec::new();
    for bars in configurations.iter().flat_map(|one| &one.energy) {
        if !runs.contains(&bars.run.as_str()) {
            runs.push(&bars.run);
        }
    }
    html! { @for run in runs { (of_run(run, configurations)) } }
}

/// Σ energy of a kind, J.
fn of_kind(bars: &EnergyBars, kind: &str) -> f64 {
    bars.parts
        .iter()
        .filter(|part| match kind {
            "motion" => part.name == "left in motion",
            "host" => part.kind == "host" && part.name != "left in motion",
            _ => part.kind == kind,
        })
        .map(|part| part.energy)
        .sum()
}

fn of_run(run: &str, configurations: &[Configuration]) -> Markup {
    let rows: Vec<(&str, &EnergyBars)> = configurations
        .iter()
        .filter_map(|one| {
            let bars = one.energy.iter().find(|bars| bars.run == run)?;
            Some((one.name.as_str(), bars))
        })
        .collect();
    let used: Vec<_> = KINDS
        .iter()
        .filter(|(kind, _, _)| {
            rows.iter()
                .any(|(_, bars)| of_kind(bars, kind).abs() > 1e-9 * bars.start.abs())
        })
        .collect();
    html! {
        h3 { "Where the energy went in " code { (run) } }
        div.scroll { table.plain.snug.energy {
            thead { tr {
                th { "Configuration" } th { "Shares" } th.number { "At the start / J" }
                @for (_, words, colour) in &used {
                    th.number { span style={ "display:inline-block;width:.8em;height:.8em;margin-right:.35em;background:" (colour) } {} (words) " / J" }
                }
                th.number { "Balance error" }
            } }
            tbody {
                @for (name, bars) in &rows {
                    tr {
                        th scope="row" { (name) }
                        td { (bar(bars, &used)) }
                        td.number { (significant(bars.start, 4)) }
                        @for (kind, _, _) in &used { td.number { (significant(of_kind(bars, kind), 4)) } }
                        td.number { (significant(bars.error, 1)) }
                    }
                }
            }
        } }
    }
}

/// The positive parts as shares of their sum.
fn bar(bars: &EnergyBars, used: &[&(&str, &str, &str)]) -> Markup {
    let whole: f64 = used
        .iter()
        .map(|(kind, _, _)| of_kind(bars, kind).max(0.0))
        .sum();
    html! {
        span style="display:flex;width:12em;height:1em" role="img" aria-label="shares of the energy" {
            @for (kind, words, colour) in used {
                @let share = if whole > 0.0 { 100.0 * of_kind(bars, kind).max(0.0) / whole } else { 0.0 };
                @if share > 0.05 {
                    span style={ "width:" (format!("{share:.2}")) "%;background:" (colour) } title={ (words) ": " (format!("{share:.1}")) " %" } {}
                }
            }
        }
    }
}
