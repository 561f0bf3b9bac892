//! The ranked shortlist as text for a terminal.

use std::fmt::Write;

use quell_report::number::{compact, percent, significant, unit};
use quell_study::{
    Design, DesignFindings, Evaluated, Findings, NamedValue, RunOutcome, Sense, Study,
};

/// What `quell run` prints.
pub(crate) fn text(study: &Study, outcome: &RunOutcome) -> String {
    let mut text = format!("{}\n", study.title);
    for task in &outcome.tasks {
        for point in &task.points {
            text.push_str(&heading(&task.name, &point.at));
            match &point.findings {
                Findings::Evaluate(configurations) => evaluate(&mut text, study, configurations),
                Findings::Design(findings) => design(&mut text, study, findings),
            }
        }
    }
    let engine = &outcome.results.engine;
    // Writing to a string cannot fail.
    let _ = write!(
        text,
        "\n{} evaluations in {} s on {} thread{}, seed {}\n",
        engine.evaluations,
        significant(engine.wall_seconds, 3),
        engine.threads,
        if engine.threads == 1 { "" } else { "s" },
        engine.seed
    );
    text
}

fn heading(task: &str, at: &[NamedValue]) -> String {
    let mut heading = format!("\n{task}");
    if !at.is_empty() {
        let points: Vec<String> = at.iter().map(named).collect();
        let _ = write!(heading, " at {}", points.join(", "));
    }
    heading.push('\n');
    heading
}

fn named(value: &NamedValue) -> String {
    let number = compact(value.value, 5);
    if value.unit.is_empty() {
        format!("{} = {number}", value.name)
    } else {
        format!("{} = {number} {}", value.name, unit(&value.unit))
    }
}

/// A criterion in the unit in which the study reads it.
pub(crate) fn criterion(study: &Study, name: &str, value: f64, si_unit: &str) -> String {
    let (value, unit_text) = match study
        .criteria
        .get(name)
        .and_then(|criterion| criterion.unit.as_ref())
    {
        Some((shown, _)) => (value / shown.factor, shown.text.as_str()),
        None => (value, si_unit),
    };
    let number = significant(value, 5);
    if unit_text.is_empty() {
        number
    } else {
        format!("{number} {}", unit(unit_text))
    }
}

fn criteria_of(study: &Study, configuration: &Evaluated) -> String {
    let mut parts = Vec::new();
    for (name, value) in &configuration.criteria {
        let detail = configuration.details.get(name);
        let si_unit = detail.map_or("", |detail| detail.unit.as_str());
        let mut part = format!("{name} = {}", criterion(study, name, *value, si_unit));
        if let Some(at) = detail.and_then(|detail| detail.at_hz) {
            let _ = write!(part, " at {} Hz", significant(at, 4));
        }
        if let Some(detail) = detail.filter(|_| !value.is_finite()) {
            let _ = write!(part, " ({})", detail.status);
        }
        parts.push(part);
    }
    parts.join(", ")
}

fn evaluate(text: &mut String, study: &Study, configurations: &[Evaluated]) {
    let width = configurations
        .iter()
        .map(|one| one.name.chars().count())
        .max()
        .unwrap_or(0);
    for one in configurations {
        let _ = writeln!(text, "  {:width$}  {}", one.name, criteria_of(study, one));
    }
}

fn design(text: &mut String, study: &Study, findings: &DesignFindings) {
    let word = match findings.sense {
        Sense::Minimise => "smallest",
        Sense::Maximise => "largest",
    };
    let _ = writeln!(
        text,
        "  {word} {} of {}",
        findings.objective, findings.candidates
    );
    for constraint in &findings.constraints {
        let _ = writeln!(text, "  subject to {constraint}");
    }
    for reference in &findings.references {
        let _ = writeln!(
            text,
            "  reference {}: {}",
            reference.name,
            criteria_of(study, reference)
        );
    }
    let shown = findings.designs.len().min(study.report.shortlist);
    for found in findings.designs.iter().take(shown) {
        one_design(text, study, findings, found);
    }
    let more = findings.designs.len() - shown;
    if more > 0 {
        let _ = writeln!(text, "  … and {more} more in the report");
    }
}

fn one_design(text: &mut String, study: &Study, findings: &DesignFindings, found: &Design) {
    let layout: Vec<&str> = found
        .configuration
        .devices
        .iter()
        .map(|device| device.designed.as_str())
        .collect();
    let _ = writeln!(text, "  {:>3}  {}", found.rank, layout.join(" ; "));
    let si_unit = found
        .configuration
        .details
        .get(&findings.objective)
        .map_or("", |detail| detail.unit.as_str());
    let mut line = format!(
        "{} = {}",
        findings.objective,
        criterion(study, &findings.objective, found.objective, si_unit)
    );
    for (reference, improvement) in &found.improvement {
        let _ = write!(line, ", {} on {reference}", percent(*improvement * 100.0));
    }
    let _ = write!(
        line,
        ", {} of {} starts agree",
        found.starts_agreeing, found.starts
    );
    if !found.feasible {
        let _ = write!(
            line,
            ", NOT FEASIBLE: a constraint is missed by {} of its bound",
            significant(found.violation, 3)
        );
    }
    let _ = writeln!(text, "       {line}");
    let values: Vec<String> = found
        .configuration
        .devices
        .iter()
        .flat_map(|device| &device.variables)
        .map(|value| {
            let side = found
                .active_bounds
                .iter()
                .find_map(|active| active.strip_prefix(&format!("{} = ", value.name)))
                .map_or(String::new(), |side| format!(" ({side} bound)"));
            format!("{}{side}", named(value))
        })
        .collect();
    if !values.is_empty() {
        let _ = writeln!(text, "       {}", values.join(", "));
    }
}
