//! The report of a study: what a run found, as a [`Page`].

mod bands;
mod branches;
mod device;
mod front;
mod motions;
mod pictures;
mod problem;
mod regions;
mod task;
mod words;

pub use motions::{ended, words as motion_words};
use quell_study::study::{Swept, Task};
use quell_study::{NamedValue, RunOutcome, Standing, Study};

use crate::number::significant;
use crate::page::{Fact, Page};

/// The report of a run as one self-contained HTML file.
pub fn html(study: &Study, outcome: &RunOutcome) -> String {
    page(study, outcome).html()
}

/// The report of a run as plain data.
pub fn page(study: &Study, outcome: &RunOutcome) -> Page {
    let bridge = Bridge {
        study,
        // A study that has run has a host; without it the report lacks names of points, nothing else.
        standing: study.standing(&[]).ok(),
    };
    Page {
        title: study.title.clone(),
        subtitle: study.host.title().to_owned(),
        facts: run_facts(outcome),
        problem: bridge.problem(outcome),
        tasks: outcome
            .tasks
            .iter()
            .map(|task| bridge.task(task, outcome))
            .collect(),
        comparisons: bands::comparisons(outcome),
    }
}

/// The unit in which people read a criterion, with its value in SI; `si_unit` where the study names none.
pub fn shown_unit<'a>(study: &'a Study, criterion: &str, si_unit: &'a str) -> (f64, &'a str) {
    study
        .criteria
        .get(criterion)
        .and_then(|known| known.unit.as_ref())
        .map_or((1.0, si_unit), |(unit, _)| {
            (unit.factor, unit.text.as_str())
        })
}

/// A swept value as people read it, with its unit: a bound in the unit of the criterion that it bounds.
pub fn shown_swept<'a>(
    study: &'a Study,
    task: Option<&Task>,
    value: &'a NamedValue,
) -> (f64, &'a str) {
    let bound = task.is_some_and(|task| {
        task.sweep
            .iter()
            .any(|axis| axis.name == value.name && axis.what == Swept::Bound)
    });
    if !bound {
        return (value.value, &value.unit);
    }
    let (factor, unit) = shown_unit(study, &value.name, &value.unit);
    (value.value / factor, unit)
}

/// What everything is looked up in.
struct Bridge<'a> {
    study: &'a Study,
    standing: Option<Standing>,
}

/// Digits of the study's hash that tell it apart.
const HASH_DIGITS: usize = 16;

fn run_facts(outcome: &RunOutcome) -> Vec<Fact> {
    let engine = &outcome.results.engine;
    let hash: String = outcome
        .results
        .study
        .hash
        .chars()
        .take(HASH_DIGITS)
        .collect();
    vec![
        Fact::new("Study", format!("`{hash}…`")),
        Fact::new("Quell", &engine.version),
        Fact::new("Seed", engine.seed.to_string()),
        Fact::new("Threads", engine.threads.to_string()),
        Fact::new(
            "Time",
            format!("{}\u{a0}s", significant(engine.wall_seconds, 3)),
        ),
        Fact::new("Evaluations", grouped(engine.evaluations)),
    ]
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
