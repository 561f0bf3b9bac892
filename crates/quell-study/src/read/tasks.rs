//! Tasks: configurations to evaluate, designs to find, sweeps over both.

use indexmap::IndexMap;
use quell_document::{Fault, Table, Value};
use quell_expression::Span;

use super::design::design;
use super::slots::{kinds_of, no_such_slot, refuse_second, slot_of};
use super::{continuation, devices, sweep, transient, unknown};
use crate::amount::Amount;
use crate::keys;
use crate::study::{ConfigurationSpec, Run, Study, Task, TaskKind};

pub(super) fn tasks(value: &Value<'_>, study: &Study) -> Result<Vec<Task>, Fault> {
    let list = value
        .as_array()
        .map_err(|fault| fault.help("write `[[tasks]]` for each task"))?;
    if list.is_empty() {
        return Err(value
            .fault("the study asks for nothing")
            .help("add a `[[tasks]]`"));
    }
    let mut tasks: Vec<Task> = Vec::new();
    let mut configurations: Vec<String> = Vec::new();
    for value in &list {
        let table = value.as_table()?;
        table.check(&keys::TASK)?;
        let name_value = table.require("name")?;
        let name = name_value.as_str()?.to_owned();
        if name.trim().is_empty() {
            return Err(name_value.fault("a task needs a name"));
        }
        if tasks.iter().any(|task| task.name == name) {
            return Err(name_value
                .fault(format!("there are two tasks `{name}`"))
                .help("give each its own name"));
        }
        let kind = table.require("kind")?.one_of(&KINDS)?;
        refuse_strangers(&table, kind)?;
        let kind = if continuation::KINDS.contains(&kind) {
            TaskKind::Continuation(Box::new(continuation::task(&table, kind, study, &tasks)?))
        } else if kind == "evaluate" {
            let found = evaluate(&table, study)?;
            for (name, spec) in &found {
                if configurations.contains(name) {
                    return Err(Fault::at(&study.source, spec.span, format!("there are two configurations `{name}`"))
                        .help("names of configurations are unique within a study, since tasks refer to them"));
                }
                configurations.push(name.clone());
            }
            TaskKind::Evaluate(found)
        } else {
            TaskKind::Design(Box::new(design(&table, study)?))
        };
        let sweep = sweep::sweep(&table, study, &kind)?;
        tasks.push(Task {
            name,
            kind,
            sweep,
            span: name_value.span(),
        });
    }
    Ok(tasks)
}

/// The kinds of task.
pub(crate) const KINDS: [&str; 7] = [
    "evaluate", "design", "branch", "curve", "diagram", "region", "simulate",
];

/// Keys of the other kinds of task.
fn refuse_strangers(table: &Table<'_>, kind: &str) -> Result<(), Fault> {
    const DESIGN: [&str; 13] = [
        "minimise",
        "maximise",
        "subject_to",
        "references",
        "candidates",
        "fixed",
        "bounds",
        "starts",
        "agree",
        "most_starts",
        "front_points",
        "feasibility",
        "simplify",
    ];
    let mut strangers: Vec<&str> = Vec::new();
    if kind != "design" {
        // Motions have starts too.
        strangers.extend(
            DESIGN
                .iter()
                .filter(|key| !(kind == "simulate" && **key == "starts")),
        );
    }
    if kind != "evaluate" {
        strangers.push("configurations");
    }
    strangers.extend(continuation::own_keys().filter(|key| !continuation::takes(kind, key)));
    if matches!(kind, "curve" | "region" | "simulate") {
        strangers.push("sweep");
    }
    for key in strangers {
        if let Some(span) = table.key_span(key) {
            return Err(Fault::at(
                table.source(),
                span,
                format!("`{key}` is no key of a task of kind `{kind}`"),
            ));
        }
    }
    Ok(())
}

fn evaluate(
    table: &Table<'_>,
    study: &Study,
) -> Result<IndexMap<String, ConfigurationSpec>, Fault> {
    const EXAMPLE: &str =
        "write `[tasks.configurations.NAME]`, below it a layout for each device and its values";
    let value = table.get("configurations").ok_or_else(|| {
        table
            .fault("the task does not say which configurations to evaluate")
            .help(EXAMPLE)
    })?;
    let mut found = IndexMap::new();
    for (name, span, value) in value.as_table()?.entries() {
        let entry = value.as_table().map_err(|fault| fault.help(EXAMPLE))?;
        found.insert(name.to_owned(), configuration_of(&entry, span, study)?);
    }
    if found.is_empty() {
        return Err(value
            .fault("there is no configuration to evaluate")
            .help(EXAMPLE));
    }
    Ok(found)
}

/// One configuration: a layout for each slot, and values.
pub(super) fn configuration_of(
    entry: &Table<'_>,
    span: Span,
    study: &Study,
) -> Result<ConfigurationSpec, Fault> {
    let mut layouts = IndexMap::new();
    let mut values = IndexMap::new();
    let mut runs: IndexMap<String, Run> = IndexMap::new();
    for (key, key_span, value) in entry.entries() {
        if let Some(path) = key.strip_prefix("runs.") {
            override_run(study, &mut runs, path, key_span, &value)?;
            continue;
        }
        match slot_of(study, key, key_span)? {
            Some(slot) => {
                let layout = devices::layout(&value, &kinds_of(study, study.domain_of(&slot)))?;
                let taken = layouts.insert(slot, (layout, value.span()));
                refuse_second(taken.is_some(), key, key_span, study)?;
            }
            None if value.as_str().is_ok_and(|text| text.contains('|')) => {
                return Err(no_such_slot(study, key, key_span));
            }
            None => {
                values.insert(key.to_owned(), Amount::read(&value, &study.source)?);
            }
        }
    }
    Ok(ConfigurationSpec {
        runs,
        layouts,
        values,
        span,
    })
}

/// `runs.RUN.KEY` of a configuration: the run with another value of the key.
fn override_run(
    study: &Study,
    runs: &mut IndexMap<String, Run>,
    path: &str,
    span: Span,
    value: &Value<'_>,
) -> Result<(), Fault> {
    let fault = |message: String| Fault::at(&study.source, span, message);
    let Some((name, key)) = path.split_once('.') else {
        return Err(
            fault(format!("`runs.{path}` does not say which key of the run"))
                .help("write `\"runs.RUN.KEY\"`"),
        );
    };
    let Some(base) = runs.get(name).or_else(|| study.runs.get(name)) else {
        return Err(unknown(
            fault(format!("there is no run `{name}`")),
            name,
            "run",
            study.runs.keys().map(String::as_str),
        ));
    };
    let Run::Transient(base) = base else {
        return Err(fault(format!(
            "only keys of runs of kind `transient` can differ between configurations, and `{name}` is none"
        )));
    };
    let mut changed = base.clone();
    if let Some(input) = key.strip_prefix("inputs.") {
        transient::excite(&mut changed, input, span, value)?;
        runs.insert(name.to_owned(), Run::Transient(changed));
        return Ok(());
    }
    if !transient::KEYS.contains(&key) {
        return Err(unknown(
            fault(format!("a `transient` run has no key `{key}`")),
            key,
            "key",
            transient::KEYS.iter().copied(),
        ));
    }
    transient::set(&mut changed, key, value, &study.source)?;
    runs.insert(name.to_owned(), Run::Transient(changed));
    Ok(())
}
