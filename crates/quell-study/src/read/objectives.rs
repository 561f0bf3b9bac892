//! What a task designs for, and with how much effort.

use quell_document::{Fault, Table, Value};
use quell_expression::Span;

use super::resolve;
use crate::study::{Agree, Objective, Sense, Study};

/// Each point of a front is a search; a grid of more than these is a slip.
const MOST_FRONT: usize = 2_000;

/// What is designed for: the first criterion, those after it, and where that stands.
pub(super) fn objectives(
    table: &Table<'_>,
    study: &Study,
) -> Result<(Objective, Vec<Objective>, Span), Fault> {
    let mut found: Vec<Objective> = Vec::new();
    let mut place = None;
    for (key, sense) in [("minimise", Sense::Minimise), ("maximise", Sense::Maximise)] {
        let Some(value) = table.get(key) else {
            continue;
        };
        place = place.or(Some(value.span()));
        let list = if value.is_array() {
            value.as_array()?
        } else {
            vec![value.clone()]
        };
        if list.is_empty() {
            return Err(value
                .fault(format!("there is no criterion to {key}"))
                .help(format!("write `{key} = \"CRITERION\"`, or leave it out")));
        }
        for value in list {
            let names = study.criteria.keys().map(String::as_str);
            resolve(&value, "criterion", names)?;
            let criterion = value.as_str()?.to_owned();
            if let Some(known) = found.iter().find(|known| known.criterion == criterion) {
                return Err(if known.sense == sense {
                    value
                        .fault(format!("`{criterion}` is to be {key}d twice"))
                        .help("once is enough")
                } else {
                    value
                        .fault(format!("`{criterion}` is to be minimised and maximised"))
                        .help("keep one of the two")
                });
            }
            found.push(Objective { criterion, sense });
        }
    }
    let mut found = found.into_iter();
    match (found.next(), place) {
        (Some(first), Some(place)) => Ok((first, found.collect(), place)),
        _ => Err(table
            .fault("the task does not say what to design for")
            .help("add `minimise = \"CRITERION\"` or `maximise = \"CRITERION\"`")),
    }
}

/// How far the effort is raised until starts agree.
pub(super) fn agree(table: &Table<'_>, first: Option<usize>) -> Result<Option<Agree>, Fault> {
    let most = table.get("most_starts");
    let Some(value) = table.get("agree") else {
        return match most {
            Some(most) => Err(most
                .fault("`most_starts` limits the starts that `agree` adds, and there is no `agree`")
                .help("add `agree = 3`, or say by `starts` how many there are")),
            None => Ok(None),
        };
    };
    let starts = value.as_count()?;
    if !(2..=1000).contains(&starts) {
        return Err(value
            .fault("the number of starts that are to agree lies between 2 and 1000")
            .help("write `agree = 3`"));
    }
    let limit = match &most {
        Some(value) => {
            let limit = value.as_count()?;
            let least = first.unwrap_or(1).max(starts);
            if limit < least || limit > 100_000 {
                return Err(value.fault(format!(
                    "the most starts lie between {least}, which there are to be anyhow, and 100000"
                )));
            }
            Some(limit)
        }
        None => None,
    };
    Ok(Some(Agree {
        starts,
        most: limit,
    }))
}

/// Points of a front along each axis of its grid.
pub(super) fn front_points(table: &Table<'_>, further: usize) -> Result<usize, Fault> {
    let value = table.get("front_points");
    if further == 0 {
        return match value {
            Some(value) => Err(value
                .fault("one objective has an optimum, and no front")
                .help("name a second criterion: `minimise = [\"ONE\", \"OTHER\"]`")),
            None => Ok(0),
        };
    }
    if let Some(span) = table.key_span("sweep") {
        return Err(Fault::at(
            table.source(),
            span,
            "a task with several objectives cannot be swept",
        )
        .help("write a task for each point, or make all objectives but one into constraints"));
    }
    let points = value.as_ref().map_or(Ok(11), Value::as_count)?;
    let searches = (0..further).fold(1, |searches: usize, _| searches.saturating_mul(points));
    if points < 3 || searches > MOST_FRONT {
        let message = format!(
            "a front has 3 points or more along each axis, and {MOST_FRONT} for each layout at most"
        );
        return Err(match &value {
            Some(value) => value.fault(message),
            None => table
                .fault(message)
                .help("give `front_points` a smaller number"),
        });
    }
    Ok(points)
}
