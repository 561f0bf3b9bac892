//! Fronts and swept bounds as a person meets them.

use std::fs;

use crate::run::HOST;
use crate::{assert_plain, output, quell};

const STUDY: &str = r#"
quell = 1
title = "An absorber between two wishes"
host = "host.toml"

[devices.absorber]
port = "hook"

[runs.force]
kind = "frequency"
input = "F"
band = ["1 Hz", "10 Hz"]

[criteria]
amplification = { run = "force", value = "max(abs(spring_force))" }
stroke = { run = "force", value = "max(abs(stroke(c1)))", unit = "mm/N" }

[[tasks]]
name = "rule"
kind = "evaluate"
[tasks.configurations.simple]
absorber = "(k1 | c1) + m1"
m1 = "0.5 kg"
k1 = "180 N/m"
c1 = "2.5 N*s/m"

[[tasks]]
name = "trade"
kind = "design"
minimise = ["amplification", "stroke"]
references = ["simple"]
candidates.absorber = ["(k1 | c1) + m1", "c1 + m1"]
fixed = { m1 = "0.5 kg" }
bounds = { k1 = ["10 N/m", "1 kN/m"], c1 = ["0.1 N*s/m", "10 N*s/m"] }
starts = 3
front_points = 4

[[tasks]]
name = "limited"
kind = "design"
minimise = "amplification"
subject_to = ["stroke <= 5 mm/N"]
candidates.absorber = ["(k1 | c1) + m1"]
fixed = { m1 = "0.5 kg" }
bounds = { k1 = ["10 N/m", "1 kN/m"], c1 = ["0.1 N*s/m", "10 N*s/m"] }
starts = 3
agree = 2
sweep = { stroke = ["4 mm/N", "6 mm/N"] }
"#;

#[test]
fn a_front_and_a_swept_bound_are_printed_and_drawn() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("host.toml"), HOST).unwrap();
    fs::write(folder.path().join("two.toml"), STUDY).unwrap();
    let assert = quell()
        .current_dir(folder.path())
        .args(["run", "two.toml", "--out", "out"])
        .assert()
        .code(0);
    let said = output(&assert);
    assert_plain(&said);
    let lines: Vec<&str> = said
        .lines()
        .filter(|line| !line.contains(" evaluations in "))
        .collect();
    insta::assert_snapshot!(lines.join("\n"));
    let report = fs::read_to_string(folder.path().join("out/report.html")).unwrap();
    assert!(report.contains("Designs on the front"));
    assert!(report.contains("Front of each layout: stroke over amplification"));
    assert!(report.contains("amplification over stroke"));
}
