//! The ranked shortlist as text for a terminal.

use std::fmt::Write;

use quell_report::number::{compact, percent, significant, unit};
use quell_report::{shown_swept, shown_unit};
use quell_study::study::Task;
use quell_study::{
    Design, DesignFindings, Evaluated, Findings, FrontFindings, NamedValue, PointOutcome,
    RunOutcome, Sense, Study,
};

use crate::table::{Table, wrap};

/// Digits of a criterion.
const DIGITS: usize = 5;

/// Points of a front that are listed.
const MOST_OF_FRONT: usize = 15;

/// Columns of a line, on a terminal and in a file alike.
pub(crate) const WIDTH: usize = 100;

/// What `quell run` prints.
pub(crate) fn text(study: &Study, outcome: &RunOutcome) -> String {
    let printer = Printer { study };
    let mut text = format!("{}\n", study.title);
    for task in &outcome.tasks {
        text.push('\n');
        printer.task(&mut text, &task.name, &task.points);
    }
    if text.contains(['▾', '▴']) {
        text.push_str("\n▾ at its lower bound, ▴ at its upper bound\n");
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
    if outcome.restored > 0 {
        let plural = if outcome.restored == 1 { "" } else { "s" };
        let _ = writeln!(
            text,
            "{} piece{plural} of work came from the interrupted run",
            outcome.restored
        );
    }
    text
}

struct Printer<'a> {
    study: &'a Study,
}

impl Printer<'_> {
    fn task(&self, text: &mut String, name: &str, points: &[PointOutcome]) {
        let swept = points.iter().any(|point| !point.at.is_empty());
        let asked = self.study.tasks.iter().find(|task| task.name == name);
        match points.first().map(|point| &point.findings) {
            None => {}
            Some(Findings::Continuation(_)) => {
                for point in points {
                    if let Findings::Continuation(found) = &point.findings {
                        crate::branches::text(text, name, &self.at(asked, &point.at), found, WIDTH);
                    }
                }
            }
            Some(Findings::Evaluate(_)) => {
                let _ = writeln!(text, "{name}");
                self.evaluated(text, asked, points, swept);
            }
            Some(Findings::Front(findings)) => self.front(text, name, findings),
            Some(Findings::Design(findings)) => {
                heading(text, name, findings, points, swept);
                if swept {
                    self.best_of_points(text, asked, points, findings);
                } else {
                    self.ranked(text, findings);
                }
            }
        }
    }

    /// A row for each configuration, at each point of a sweep.
    fn evaluated(
        &self,
        text: &mut String,
        asked: Option<&Task>,
        points: &[PointOutcome],
        swept: bool,
    ) {
        let all: Vec<(&PointOutcome, &Evaluated)> = points
            .iter()
            .flat_map(|point| {
                let configurations: &[Evaluated] = match &point.findings {
                    Findings::Evaluate(configurations) => configurations,
                    Findings::Design(_) | Findings::Front(_) | Findings::Continuation(_) => &[],
                };
                configurations.iter().map(move |one| (point, one))
            })
            .collect();
        let Some((_, first)) = all.first() else {
            return;
        };
        let names: Vec<&String> = first.criteria.keys().collect();
        let mut heading: Vec<String> = if swept {
            vec!["at".to_owned()]
        } else {
            Vec::new()
        };
        heading.push("configuration".to_owned());
        let texts = heading.len();
        heading.extend(names.iter().map(|name| self.headed(name, first)));
        heading.push(String::new());
        let mut table = Table::new(heading, texts);
        for (point, one) in all {
            let mut cells: Vec<String> = if swept {
                vec![self.at(asked, &point.at)]
            } else {
                Vec::new()
            };
            cells.push(one.name.clone());
            cells.extend(names.iter().map(|name| self.value(name, one)));
            cells.push(remarks(one, &names));
            table.row(cells, Vec::new());
        }
        text.push_str(&table.text(2, WIDTH));
    }

    /// The shortlist of one task.
    fn ranked(&self, text: &mut String, findings: &DesignFindings) {
        let Some(first) = findings.designs.first() else {
            text.push_str("  no layouts\n");
            return;
        };
        let names = shown_criteria(findings);
        let mut table = self.design_table("rank", 0, findings, &names, &first.configuration);
        for reference in &findings.references {
            let mut cells = vec![String::new()];
            let one = &reference.configuration;
            cells.extend(names.iter().map(|name| self.value(name, one)));
            cells.extend(findings.references.iter().map(|_| String::new()));
            cells.push(String::new());
            cells.push(format!(
                "reference {}{}",
                one.name,
                where_of(one, &findings.objective)
            ));
            let missed = reference.misses_a_constraint(&findings.objective);
            let under = missed.then(|| not_feasible(reference.violation));
            table.row(cells, under.into_iter().collect());
        }
        let shown = findings.designs.len().min(self.study.report.shortlist);
        for found in findings.designs.iter().take(shown) {
            self.design_row(&mut table, found.rank.to_string(), found, findings, &names);
        }
        text.push_str(&table.text(2, WIDTH));
        let more = findings.designs.len() - shown;
        if more > 0 {
            let _ = writeln!(text, "  … and {more} more in the report");
        }
        for (found, synthesis) in findings
            .designs
            .iter()
            .take(shown)
            .flat_map(|found| found.synthesis.iter().map(move |one| (found, one)))
        {
            let _ = writeln!(
                text,
                "\n  function {} of `{}`: {}",
                found.rank, synthesis.device, synthesis.status
            );
            for network in &synthesis.networks {
                let values: Vec<String> = network
                    .values
                    .iter()
                    .map(|(name, value)| format!("{name} = {value:.4e}"))
                    .collect();
                let _ = writeln!(
                    text,
                    "    {} ({}): {}",
                    network.network,
                    network.method,
                    values.join(", ")
                );
            }
        }
        if let Some(most) = findings.simplified.first() {
            let _ = writeln!(text, "\n  the best with fewer elements");
            let mut table =
                self.design_table("elements", 0, findings, &names, &most.design.configuration);
            for one in &findings.simplified {
                let lead = one.elements.to_string();
                self.design_row(&mut table, lead, &one.design, findings, &names);
            }
            text.push_str(&table.text(2, WIDTH));
        }
    }

    /// The front of all layouts together, from one end to the other.
    fn front(&self, text: &mut String, name: &str, findings: &FrontFindings) {
        let asked: Vec<String> = findings
            .objectives
            .iter()
            .map(|objective| {
                let word = match objective.sense {
                    Sense::Minimise => "smallest",
                    Sense::Maximise => "largest",
                };
                format!("{word} {}", objective.criterion)
            })
            .collect();
        let mut line = format!(
            "{name}: {} of {}",
            asked.join(" against "),
            count_of(&findings.candidates)
        );
        if !findings.constraints.is_empty() {
            let _ = write!(line, ", subject to {}", findings.constraints.join(", "));
        }
        for broken in wrap(&line, WIDTH) {
            let _ = writeln!(text, "{broken}");
        }
        let common = findings.common();
        let Some((_, first)) = common.first() else {
            text.push_str("  no values were found that meet every constraint\n");
            return;
        };
        let example = &first.design.configuration;
        let names: Vec<&String> = findings
            .objectives
            .iter()
            .map(|objective| &objective.criterion)
            .collect();
        let mut heading = vec![String::new()];
        heading.extend(names.iter().map(|name| self.headed(name, example)));
        heading.push("starts".to_owned());
        heading.push("layout".to_owned());
        let mut table = Table::new(heading, 0);
        for reference in &findings.references {
            let one = &reference.configuration;
            let mut cells = vec![String::new()];
            cells.extend(names.iter().map(|name| self.value(name, one)));
            cells.push(String::new());
            cells.push(format!("reference {}", one.name));
            table.row(cells, Vec::new());
        }
        // Both ends and points evenly between them say more of a long front than its beginning.
        let shown = common.len().min(MOST_OF_FRONT);
        for index in 0..shown {
            let place = index * (common.len() - 1) / (shown - 1).max(1);
            let Some((layout, point)) = common.get(place) else {
                continue;
            };
            let one = &point.design.configuration;
            let mut cells = vec![point.design.rank.to_string()];
            cells.extend(names.iter().map(|name| self.value(name, one)));
            cells.push(format!(
                "{}/{}",
                point.design.starts_agreeing, point.design.starts
            ));
            cells.push(layout.layout.clone());
            let values = values(one, &point.design.active_bounds);
            table.row(
                cells,
                Some(values)
                    .filter(|values| !values.is_empty())
                    .into_iter()
                    .collect(),
            );
        }
        text.push_str(&table.text(2, WIDTH));
        if common.len() > shown {
            let more = common.len() - shown;
            let _ = writeln!(text, "  … and {more} between them in the report");
        }
        let without: Vec<&str> = findings
            .layouts
            .iter()
            .filter(|layout| layout.points.iter().all(|point| point.rank.is_none()))
            .map(|layout| layout.layout.as_str())
            .collect();
        if !without.is_empty() {
            let line = format!("Nowhere on the front: {}", without.join(" ; "));
            for broken in wrap(&line, WIDTH - 2) {
                let _ = writeln!(text, "  {broken}");
            }
        }
    }

    /// The best design at each point of a sweep.
    fn best_of_points(
        &self,
        text: &mut String,
        asked: Option<&Task>,
        points: &[PointOutcome],
        first: &DesignFindings,
    ) {
        let Some(best) = first.designs.first() else {
            text.push_str("  no layouts\n");
            return;
        };
        let names = shown_criteria(first);
        let mut table = self.design_table("at", 1, first, &names, &best.configuration);
        for point in points {
            let Findings::Design(findings) = &point.findings else {
                continue;
            };
            if let Some(best) = findings.designs.first() {
                self.design_row(
                    &mut table,
                    self.at(asked, &point.at),
                    best,
                    findings,
                    &names,
                );
            }
        }
        text.push_str(&table.text(2, WIDTH));
    }

    fn design_table(
        &self,
        lead: &str,
        texts: usize,
        findings: &DesignFindings,
        names: &[&String],
        example: &Evaluated,
    ) -> Table {
        let mut heading = vec![lead.to_owned()];
        heading.extend(names.iter().map(|name| self.headed(name, example)));
        heading.extend(
            findings
                .references
                .iter()
                .map(|reference| format!("on {}", reference.configuration.name)),
        );
        heading.push("starts".to_owned());
        heading.push("layout".to_owned());
        Table::new(heading, texts)
    }

    fn design_row(
        &self,
        table: &mut Table,
        lead: String,
        found: &Design,
        findings: &DesignFindings,
        names: &[&String],
    ) {
        let one = &found.configuration;
        let mut cells = vec![lead];
        cells.extend(names.iter().map(|name| self.value(name, one)));
        cells.extend(findings.references.iter().map(|reference| {
            found
                .improvement
                .get(&reference.configuration.name)
                .map_or_else(|| "–".to_owned(), |gain| percent(gain * 100.0))
        }));
        // Starts that meet no constraint agree on nothing worth telling.
        cells.push(if found.feasible {
            format!("{}/{}", found.starts_agreeing, found.starts)
        } else {
            "–".to_owned()
        });
        let layouts: Vec<&str> = one
            .devices
            .iter()
            .map(|device| device.designed.as_str())
            .collect();
        cells.push(layouts.join(" ; "));
        let mut under = Vec::new();
        let values = values(one, &found.active_bounds);
        if !values.is_empty() {
            under.push(values);
        }
        if !found.objective.is_finite() {
            under.push(format!("no value: {}", found.status));
        } else if !found.feasible {
            let tried = match found.starts {
                0 | 1 => String::new(),
                starts => format!(" by the best of {starts} starts"),
            };
            under.push(format!("{}{tried}", not_feasible(found.violation)));
        }
        if found.rank == 1 {
            // Of the others the report tells.
            let taken = one.details.iter().filter_map(|(name, detail)| {
                Some(format!("`{name}` is the {}", detail.taken.as_ref()?))
            });
            under.extend(taken);
            under.extend(found.remarks.iter().cloned());
        }
        table.row(cells, under);
    }

    /// Where a point of a sweep lies; bounds in the units of their criteria.
    fn at(&self, asked: Option<&Task>, values: &[NamedValue]) -> String {
        let values: Vec<String> = values
            .iter()
            .map(|value| {
                let (number, text) = shown_swept(self.study, asked, value);
                let shown = NamedValue {
                    value: number,
                    unit: text.to_owned(),
                    ..value.clone()
                };
                quantity(&value.name, &shown)
            })
            .collect();
        values.join(", ")
    }

    /// A criterion's name with its unit.
    fn headed(&self, name: &str, example: &Evaluated) -> String {
        let si_unit = example
            .details
            .get(name)
            .map_or("", |detail| detail.unit.as_str());
        match shown_unit(self.study, name, si_unit).1 {
            "" | "1" => name.to_owned(),
            text => format!("{name} [{}]", unit(text)),
        }
    }

    fn value(&self, name: &str, one: &Evaluated) -> String {
        let value = one.criteria.get(name).copied().unwrap_or(f64::NAN);
        significant(value / shown_unit(self.study, name, "").0, DIGITS)
    }
}

/// A constraint is missed by so much, relative.
fn not_feasible(violation: f64) -> String {
    let by = if violation.is_finite() {
        format!(" by {}", percent(violation * 100.0))
    } else {
        String::new()
    };
    format!("NOT FEASIBLE: a constraint is missed{by}")
}

/// How layouts were told apart is in the report; here the number is enough.
fn count_of(candidates: &str) -> &str {
    candidates
        .split_once(',')
        .map_or(candidates, |(count, _)| count)
}

/// What is asked of a design task, in a line.
fn heading(
    text: &mut String,
    name: &str,
    findings: &DesignFindings,
    points: &[PointOutcome],
    swept: bool,
) {
    let word = match findings.sense {
        Sense::Minimise => "smallest",
        Sense::Maximise => "largest",
    };
    let candidates = count_of(&findings.candidates);
    let mut line = format!("{name}: {word} {} of {candidates}", findings.objective);
    if !findings.constraints.is_empty() {
        let _ = write!(line, ", subject to {}", findings.constraints.join(", "));
    }
    if swept {
        let _ = write!(line, ", at {} points", points.len());
    }
    for broken in wrap(&line, WIDTH) {
        let _ = writeln!(text, "{broken}");
    }
}

/// The objective, then the criteria that constraints speak of.
fn shown_criteria(findings: &DesignFindings) -> Vec<&String> {
    let example = findings
        .designs
        .first()
        .map(|design| &design.configuration.criteria);
    let mut names: Vec<&String> = vec![&findings.objective];
    for name in example.into_iter().flat_map(|criteria| criteria.keys()) {
        let constrained = findings.constraints.iter().any(|text| {
            text.strip_prefix(name.as_str())
                .is_some_and(|rest| rest.starts_with(' '))
        });
        if constrained && *name != findings.objective {
            names.push(name);
        }
    }
    names
}

/// Where the objective's value is taken.
fn where_of(one: &Evaluated, name: &str) -> String {
    let Some(detail) = one.details.get(name) else {
        return String::new();
    };
    let frequency = detail
        .at_hz
        .map_or_else(String::new, |at| format!(", at {} Hz", significant(at, 4)));
    let taken = detail
        .taken
        .as_ref()
        .map_or_else(String::new, |taken| format!(", {taken}"));
    frequency + &taken
}

/// Where values are taken, and why there is none.
fn remarks(one: &Evaluated, names: &[&String]) -> String {
    let several = names.len() > 1;
    let mut remarks = Vec::new();
    for name in names {
        let Some(detail) = one.details.get(*name) else {
            continue;
        };
        let lead = if several {
            format!("{name} ")
        } else {
            String::new()
        };
        let value = one.criteria.get(*name).copied().unwrap_or(f64::NAN);
        if !value.is_finite() {
            remarks.push(format!("{lead}{}", detail.status));
            continue;
        }
        let at = detail.at_hz;
        let frequency = at.map(|at| format!("at {} Hz", significant(at, 4)));
        let words: Vec<String> = frequency.into_iter().chain(detail.taken.clone()).collect();
        if !words.is_empty() {
            remarks.push(format!("{lead}{}", words.join(", ")));
        }
    }
    remarks.join(", ")
}

/// `k1 = 180 N/m`, held together by no-break spaces.
fn quantity(name: &str, value: &NamedValue) -> String {
    let number = compact(value.value, DIGITS);
    if value.unit.is_empty() {
        format!("{name}\u{a0}=\u{a0}{number}")
    } else {
        format!("{name}\u{a0}=\u{a0}{number}\u{a0}{}", unit(&value.unit))
    }
}

/// The values that were searched; those of one component stand together: `pipe1: d = 2 m, l = 3 m; k1 = 180 N/m`.
fn values(one: &Evaluated, active: &[String]) -> String {
    let mut text = String::new();
    let mut before: Option<&str> = None;
    for device in &one.devices {
        for value in device
            .variables
            .iter()
            .filter(|value| value.bounds.is_some())
        {
            let (instance, name) = match value.name.split_once('.') {
                Some((instance, name)) => (Some(instance), name),
                None => (None, value.name.as_str()),
            };
            if !text.is_empty() {
                let apart = instance != before;
                // What belongs to one component is not broken over lines.
                text.push_str(match (apart, instance) {
                    (true, _) => "; ",
                    (false, Some(_)) => ",\u{a0}",
                    (false, None) => ", ",
                });
            }
            if let Some(instance) = instance.filter(|_| instance != before) {
                let _ = write!(text, "{instance}:\u{a0}");
            }
            text.push_str(&quantity(name, value));
            text.push_str(mark(&device.name, &value.name, active));
            before = instance;
        }
    }
    text
}

fn mark(device: &str, variable: &str, active: &[String]) -> &'static str {
    let side = active.iter().find_map(|text| {
        let (name, side) = text.split_once(" = ")?;
        // Where devices share a name, the device's stands before it.
        let inner = name
            .strip_prefix(device)
            .and_then(|rest| rest.strip_prefix('.'));
        (name == variable || inner == Some(variable)).then_some(side)
    });
    match side {
        Some("lower") => "\u{a0}▾",
        Some("upper") => "\u{a0}▴",
        _ => "",
    }
}
