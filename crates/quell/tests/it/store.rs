//! Runs that are killed, gone on with, refused and begun anew.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use quell_study::store::Store;
use serde_json::Value;

use crate::run::HOST;
use crate::{errors, output, quell};

/// Enough layouts to be killed in the middle of, on any machine.
const STUDY: &str = r#"
quell = 1
title = "Many absorbers"
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
name = "peak"
kind = "design"
minimise = "amplification"
references = ["c1 + m1"]
sweep = { zeta = [0.0, 0.02] }
candidates.absorber = { springs = 1, dampers = 1, inerters = 1, masses = 1 }
fixed = { m1 = "0.5 kg" }
bounds = { k = ["10 N/m", "1 kN/m"], c = ["0.1 N*s/m", "100 N*s/m"], b = ["0.01 kg", "1 kg"] }
"#;

fn written(folder: &Path) {
    fs::write(folder.join("host.toml"), HOST).unwrap();
    fs::write(folder.join("many.toml"), STUDY).unwrap();
}

fn run(folder: &Path, arguments: &[&str]) -> assert_cmd::assert::Assert {
    quell()
        .current_dir(folder)
        .args(["run", "many.toml"])
        .args(arguments)
        .assert()
}

/// `results.json` without the one thing that differs from run to run.
fn results(folder: &Path) -> Value {
    let text = fs::read_to_string(folder.join("results.json")).unwrap();
    let mut results: Value = serde_json::from_str(&text).unwrap();
    let engine = results["engine"].as_object_mut().unwrap();
    assert!(engine.remove("wall_seconds").is_some());
    results
}

/// Moments between 0 and 1, different from run to run: no list of moments is to be the only one that works.
fn moments() -> impl Iterator<Item = f64> {
    let clock = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    let mut state = clock.unwrap().as_nanos() as u64 | 1;
    std::iter::repeat_with(move || {
        // Xorshift (G. Marsaglia 2003).
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    })
}

#[test]
fn a_run_killed_at_random_moments_ends_with_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    written(folder.path());
    let begun = Instant::now();
    let whole = run(folder.path(), &["--out", "whole"]).code(0);
    let taken = begun.elapsed();
    assert!(!output(&whole).contains("interrupted"));
    let expected = results(&folder.path().join("whole"));

    let out = folder.path().join("killed");
    let mut killed = 0;
    for moment in moments().take(12) {
        let mut child = Command::new(assert_cmd::cargo::cargo_bin!("quell"))
            .current_dir(folder.path())
            .args(["run", "many.toml", "--out", "killed"])
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        std::thread::sleep(taken.mul_f64(0.4 * moment) + Duration::from_millis(1));
        // SIGKILL: nothing of ours runs after it.
        child.kill().unwrap();
        let ended = child.wait_with_output().unwrap();
        if ended.status.success() {
            break;
        }
        let said = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(said, "", "it was killed, and nothing else was wrong");
        assert!(
            !out.join("results.json").exists(),
            "half a run has no results"
        );
        killed += 1;
    }
    assert!(killed > 0, "the first run ended within 0.4 of its own time");
    if out.join("results.json").exists() {
        assert_eq!(results(&out), expected);
        return;
    }
    let last = run(folder.path(), &["--out", "killed"]).code(0);
    let said = output(&last);
    assert!(said.contains("came from the interrupted run"), "{said}");
    assert_eq!(results(&out), expected);
}

#[test]
fn a_folder_in_use_is_refused_and_free_again_afterwards() {
    let folder = tempfile::tempdir().unwrap();
    written(folder.path());
    let out = folder.path().join("out");
    fs::create_dir(&out).unwrap();
    let held = Store::open(&out).unwrap();
    let few = ["--out", "out", "--task", "peak"];
    for arguments in [&few[..], &[&few[..], &["--force"]].concat()] {
        let refused = run(folder.path(), arguments).code(1);
        assert_eq!(output(&refused), "");
        insta::allow_duplicates! {
            insta::assert_snapshot!(errors(&refused), @"another run is writing to `out`; wait until it ends, or put this run elsewhere by `--out DIR`");
        }
    }
    drop(held);
    assert!(!out.join("results.json").exists());
}

#[test]
fn an_interrupted_run_of_something_else_is_not_gone_on_with() {
    let folder = tempfile::tempdir().unwrap();
    written(folder.path());
    // An interrupted run leaves its store and no results.
    run(folder.path(), &["--out", "out"]).code(0);
    let out = folder.path().join("out");
    let before = results(&out);
    fs::remove_file(out.join("results.json")).unwrap();
    let edited = STUDY.replace("100 N*s/m", "90 N*s/m");
    fs::write(folder.path().join("many.toml"), edited).unwrap();
    let refused = run(folder.path(), &["--out", "out"]).code(1);
    insta::assert_snapshot!(errors(&refused), @"`out` holds an unfinished run of `Many absorbers` as it was before its files, or Quell, changed; `--force` starts afresh over it, `--out DIR` puts this run elsewhere");

    // A wrong task name takes nothing away, by force either.
    let wrong = run(
        folder.path(),
        &["--out", "out", "--force", "--task", "peek"],
    )
    .code(1);
    assert!(errors(&wrong).contains("did you mean `peak`?"));

    // The study as it was goes on, on however many threads, from what is there.
    fs::write(folder.path().join("many.toml"), STUDY).unwrap();
    let gone_on = run(folder.path(), &["--out", "out", "--threads", "1"]).code(0);
    assert!(output(&gone_on).contains("came from the interrupted run"));
    let mut after = results(&out);
    after["engine"]["threads"] = before["engine"]["threads"].clone();
    assert_eq!(after, before);

    // By force it is begun anew: nothing comes from the store.
    let anew = run(folder.path(), &["--out", "out", "--force"]).code(0);
    assert!(!output(&anew).contains("interrupted"));
    assert_eq!(results(&out), before);
}
