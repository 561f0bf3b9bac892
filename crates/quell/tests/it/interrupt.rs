//! Ctrl-C.

#![cfg(unix)]

use std::process::Stdio;
use std::time::{Duration, Instant};

use crate::{errors, quell, root};

/// The first Ctrl-C ends a plane that would take many seconds more; what was found so far is written and called interrupted.
#[test]
fn an_interrupt_ends_branches_and_leaves_what_they_found() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let mut run = std::process::Command::new(assert_cmd::cargo::cargo_bin!("quell"))
        .current_dir(root())
        .args([
            "run",
            "studies/zero-shimmy.toml",
            "--task",
            "L1 plane",
            "--out",
        ])
        .arg(&out)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let began = Instant::now();
    while !out.join("store.sqlite").exists() && began.elapsed() < Duration::from_mins(1) {
        std::thread::sleep(Duration::from_millis(20));
    }
    std::thread::sleep(Duration::from_secs(1));
    assert!(run.try_wait().unwrap().is_none(), "it was over already");
    let sent = std::process::Command::new("kill")
        .args(["-INT", &run.id().to_string()])
        .status()
        .unwrap();
    assert!(sent.success());
    assert_eq!(run.wait().unwrap().code(), Some(130));
    let results = std::fs::read_to_string(out.join("results.json")).unwrap();
    assert!(results.contains(r#""status": "interrupted""#), "{results}");
    let report = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(report.contains("interrupted"));
    // It is not a finished run: the same command goes on, and another study is refused.
    let refused = quell()
        .args(["run", "studies/wheelset.toml", "--out"])
        .arg(&out)
        .assert()
        .failure();
    assert!(errors(&refused).contains("--force"), "{}", errors(&refused));
}
