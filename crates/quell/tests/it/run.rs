//! `quell run`, on a study that is over in a moment.

use std::fs;
use std::path::Path;

use assert_cmd::assert::Assert;
use serde_json::Value;

use crate::{assert_plain, errors, output, quell};

pub(crate) const HOST: &str = r#"
quell = 1
title = "One mass on one spring"

[parameters]
m = "10 kg"
k = "4 kN/m"
zeta = 0

[coordinates]
x = { mass = "m" }

[inputs]
F = { kind = "force", on = "x" }

[linear]
springs = [["x", "ground", "k"]]
dampers = [["x", "ground", "2*zeta*sqrt(k*m)"]]

[ports.hook]
at = "x"

[outputs]
spring_force = "k*x"
"#;

const STUDY: &str = r#"
quell = 1
title = "A tiny absorber"
host = "host.toml"

[devices.absorber]
port = "hook"

[runs.force]
kind = "frequency"
input = "F"
band = ["1 Hz", "10 Hz"]

[criteria]
amplification = { run = "force", value = "max(abs(spring_force))" }

[[tasks]]
name = "rule"
kind = "evaluate"
[tasks.configurations.simple]
absorber = "(k1 | c1) + m1"
m1 = "0.5 kg"
k1 = "180 N/m"
c1 = "2.5 N*s/m"

[[tasks]]
name = "peak"
kind = "design"
minimise = "amplification"
references = ["simple"]
candidates.absorber = ["(k1 | c1) + m1", "c1 + m1"]
fixed = { m1 = "0.5 kg" }
bounds = { k1 = ["10 N/m", "1 kN/m"], c1 = ["0.1 N*s/m", "100 N*s/m"] }
starts = 2

[[tasks]]
name = "damped"
kind = "evaluate"
sweep = { zeta = { values = [0.01, 0.05] } }
[tasks.configurations.again]
absorber = "(k1 | c1) + m1"
m1 = "0.5 kg"
k1 = "180 N/m"
c1 = "2.5 N*s/m"

[[tasks]]
name = "impossible"
kind = "design"
minimise = "amplification"
subject_to = ["amplification <= 1.5"]
candidates.absorber = ["(k1 | c1) + m1"]
fixed = { m1 = "0.5 kg" }
bounds = { k1 = ["10 N/m", "1 kN/m"], c1 = ["0.1 N*s/m", "100 N*s/m"] }
starts = 2
"#;

fn written(folder: &Path) {
    fs::write(folder.join("host.toml"), HOST).unwrap();
    fs::write(folder.join("tiny.toml"), STUDY).unwrap();
}

fn run(folder: &Path, arguments: &[&str]) -> Assert {
    quell()
        .current_dir(folder)
        .arg("run")
        .args(arguments)
        .assert()
}

fn results(folder: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(folder.join("results.json")).unwrap()).unwrap()
}

fn keys(value: &Value) -> Vec<&str> {
    value
        .as_object()
        .unwrap()
        .keys()
        .map(String::as_str)
        .collect()
}

/// The shortlist without what differs from run to run.
fn settled(text: &str) -> String {
    text.lines()
        .map(|line| {
            if line.contains(" evaluations in ") {
                "(evaluations, time, threads, seed)"
            } else {
                line
            }
        })
        .collect::<Vec<_>>()
        .join("\n")
}

#[test]
fn a_run_prints_a_shortlist_and_leaves_results_and_report() {
    let folder = tempfile::tempdir().unwrap();
    written(folder.path());
    let assert = run(folder.path(), &["tiny.toml"]).code(0);
    assert_eq!(errors(&assert), "", "no progress where nobody watches");
    assert_plain(&output(&assert));
    insta::assert_snapshot!(settled(&output(&assert)));

    let out = folder.path().join("runs/tiny");
    let mut names: Vec<_> = fs::read_dir(&out)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, ["report.html", "results.json", "store.sqlite"]);
    let report = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(report.starts_with("<!DOCTYPE html>") && report.ends_with("</html>"));
    assert!(report.contains("A tiny absorber") && report.contains("<svg"));
    assert!(
        !report.contains("http://") && !report.contains("https://"),
        "loads nothing"
    );

    let results = results(&out);
    assert_eq!(keys(&results), ["format", "study", "engine", "tasks"]);
    assert_eq!(results["format"], 1);
    assert_eq!(keys(&results["study"]), ["title", "hash"]);
    assert_eq!(
        keys(&results["engine"]),
        ["version", "seed", "threads", "wall_seconds", "evaluations"]
    );
    assert_eq!(
        keys(&results["tasks"]),
        ["rule", "peak", "damped", "impossible"]
    );

    let rule = &results["tasks"]["rule"];
    assert_eq!(keys(rule), ["kind", "status", "configurations"]);
    let simple = &rule["configurations"]["simple"];
    assert_eq!(keys(simple), ["devices", "criteria", "details"]);
    assert_eq!(simple["devices"]["absorber"]["layout"], "(k1 | c1) + m1");
    assert_eq!(simple["devices"]["absorber"]["values"]["k1"], 180.0);
    let detail = &simple["details"]["amplification"];
    assert!(detail["at_hz"].as_f64().unwrap() > 1.0);
    assert!(detail["achieved_tolerance"].is_number() && detail["status"].is_string());

    let peak = &results["tasks"]["peak"];
    assert_eq!(keys(peak), ["kind", "status", "references", "designs"]);
    assert!(peak["references"]["simple"]["criteria"]["amplification"].is_number());
    let designs = peak["designs"].as_array().unwrap();
    assert_eq!(designs.len(), 2);
    for (design, rank) in designs.iter().zip(1..) {
        assert_eq!(design["rank"], rank);
        for key in [
            "devices",
            "objective",
            "criteria",
            "feasible",
            "active_bounds",
            "starts",
            "starts_agreeing",
            "evaluations",
        ] {
            assert!(!design[key].is_null(), "{key}");
        }
        assert_eq!(design["objective"], design["criteria"]["amplification"]);
    }
    // Mass ratio 0.05 on an undamped host: the exact optimum is 6.40792 (O. Nishihara and T. Asami, 2002).
    let best = designs[0]["objective"].as_f64().unwrap();
    assert!((best / 6.40792 - 1.0).abs() < 2e-4, "{best}");

    let damped = results["tasks"]["damped"]["points"].as_array().unwrap();
    assert_eq!(damped.len(), 2);
    assert_eq!(damped[1]["at"]["zeta"], 0.05);
    assert!(damped[1]["configurations"]["again"]["criteria"]["amplification"].is_number());

    // An infeasible design is done, and says so.
    let impossible = &results["tasks"]["impossible"];
    assert_eq!(impossible["status"], "infeasible");
    assert_eq!(impossible["designs"][0]["feasible"], false);
}

#[test]
fn an_earlier_run_is_not_overwritten_unasked() {
    let folder = tempfile::tempdir().unwrap();
    written(folder.path());
    let task = ["tiny.toml", "--out", "kept", "--task", "rule"];
    run(folder.path(), &task).code(0);
    let before = fs::read_to_string(folder.path().join("kept/results.json")).unwrap();
    let assert = run(folder.path(), &task).code(1);
    assert_eq!(output(&assert), "");
    insta::assert_snapshot!(errors(&assert), @"`kept` already holds a run; `--force` starts afresh over it, `--out DIR` puts this one elsewhere");
    let after = fs::read_to_string(folder.path().join("kept/results.json")).unwrap();
    assert_eq!(before, after);
    let forced = [&task[..], &["--force", "--seed", "3", "--threads", "1"]].concat();
    run(folder.path(), &forced).code(0);
    let engine = results(&folder.path().join("kept"))["engine"].clone();
    assert_eq!(
        (&engine["seed"], &engine["threads"]),
        (&3.into(), &1.into())
    );
}

#[test]
fn only_the_tasks_that_were_named_are_run() {
    let folder = tempfile::tempdir().unwrap();
    written(folder.path());
    run(folder.path(), &["tiny.toml", "--task", "rule"]).code(0);
    let results = results(&folder.path().join("runs/tiny"));
    assert_eq!(keys(&results["tasks"]), ["rule"]);
}

#[test]
fn a_wrong_study_exits_with_one_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    written(folder.path());
    let assert = run(folder.path(), &["tiny.toml", "--task", "peek"]).code(1);
    insta::assert_snapshot!(errors(&assert));
    assert!(!folder.path().join("runs/tiny").exists());

    fs::write(
        folder.path().join("host.toml"),
        HOST.replace("10 kg", "10 N"),
    )
    .unwrap();
    let assert = run(folder.path(), &["tiny.toml", "--out", "out"]).code(1);
    assert!(errors(&assert).contains("host.toml"), "{}", errors(&assert));
    assert!(!folder.path().join("out").exists());
}

#[test]
fn a_folder_that_cannot_be_written_exits_with_two_before_the_run() {
    let folder = tempfile::tempdir().unwrap();
    written(folder.path());
    fs::write(folder.path().join("file"), "not a folder").unwrap();
    let assert = run(folder.path(), &["tiny.toml", "--out", "file/inside"]).code(2);
    let said = errors(&assert);
    assert!(said.contains("so nothing was run"), "{said}");
    assert_eq!(output(&assert), "");
}
