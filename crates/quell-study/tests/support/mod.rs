//! Studies for tests: of the gallery, or with a host of the tests, and what they find.

#![allow(
    dead_code,
    clippy::panic,
    reason = "no test uses everything, and a failed one ends by panic"
)]

use std::path::Path;

use quell_study::continuation::{BranchResult, ContinuationResult, SpecialResult};
use quell_study::results::{Results, TaskBody, TaskFindings};
use quell_study::{RunSettings, Silent, Study};

/// A study of the gallery.
pub(crate) fn gallery(name: &str) -> Study {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../studies")
        .join(name);
    Study::read(&path).unwrap_or_else(|fault| panic!("{}", fault.render()))
}

/// A study with a host of the tests.
pub(crate) fn written(text: &str) -> Study {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/hosts");
    let source = quell_document::Source::new("study.toml", text.to_owned());
    Study::parse(source, &folder).unwrap_or_else(|fault| panic!("{}", fault.render()))
}

pub(crate) fn settings(threads: usize, tasks: &[&str]) -> RunSettings {
    RunSettings {
        seed: 1,
        threads: Some(threads),
        tasks: tasks.iter().map(|task| (*task).to_owned()).collect(),
    }
}

/// Results of some tasks.
pub(crate) fn run(study: &Study, threads: usize, tasks: &[&str]) -> Results {
    quell_study::run(study, &settings(threads, tasks), &Silent)
        .unwrap_or_else(|error| panic!("{error}"))
        .results
}

/// What a task found that follows branches.
pub(crate) fn found<'a>(results: &'a Results, task: &str) -> &'a ContinuationResult {
    let result = &results.tasks[task];
    assert_eq!(result.status, "done", "{task}");
    match &result.body {
        TaskBody::Single(TaskFindings::Continuation(found)) => found,
        other => panic!("{task} follows nothing: {other:?}"),
    }
}

/// The special points of a kind.
pub(crate) fn points<'a>(branch: &'a BranchResult, kind: &str) -> Vec<&'a SpecialResult> {
    branch
        .special
        .iter()
        .filter(|one| one.kind == kind)
        .collect()
}

/// Responses of a hardening oscillator to a harmonic force, with more tasks after them.
pub(crate) fn responses(more: &str) -> String {
    format!(
        r#"
quell = 1
title = "Responses of a hardening oscillator"
host = "forced-duffing.toml"

[runs.settle]
kind = "transient"
duration = 400

[[tasks]]
name = "response"
kind = "branch"
parameter = "Om"
ranges = {{ Om = [0.4, 2] }}
start = {{ run = "settle" }}
at = [1]
measures = {{ swing = "amplitude(x)" }}
{more}"#
    )
}
