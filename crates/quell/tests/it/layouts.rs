//! `quell layouts`.

use std::fmt::Write as _;

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use crate::{assert_plain, errors, output, quell};

fn listed(arguments: &[&str]) -> Vec<String> {
    let assert = quell().arg("layouts").args(arguments).assert().code(0);
    assert_plain(&output(&assert));
    assert_eq!(errors(&assert), "");
    output(&assert).lines().map(str::to_owned).collect()
}

fn counted(arguments: &[&str]) -> String {
    let assert = quell()
        .arg("layouts")
        .args(arguments)
        .arg("--count")
        .assert()
        .code(0);
    output(&assert)
}

const ONE_OF_EACH: [&str; 6] = ["--springs", "1", "--dampers", "1", "--inerters", "1"];
const OWN: [&str; 4] = ["--kinds", "track,restriction", "--branches", "4"];

#[test]
fn one_of_each_makes_eight() {
    insta::assert_snapshot!(listed(&ONE_OF_EACH).join("\n"), @r"
    k1 + c1 + b1
    k1 + (c1 | b1)
    c1 + (k1 | b1)
    b1 + (k1 | c1)
    k1 | c1 | b1
    k1 | c1 + b1
    c1 | k1 + b1
    b1 | k1 + c1
    ");
    assert_eq!(counted(&ONE_OF_EACH), "8\n");
    // The short options say the same.
    assert_eq!(counted(&["-k1", "-c1", "-b1"]), "8\n");
}

#[test]
fn components_of_several_elements_do_not_merge() {
    let at_least = ["--at-least", "track=1", "--compound", "track"];
    assert_eq!(counted(&[&OWN[..], &at_least].concat()), "42\n");
    let lines = listed(&[&OWN[..], &at_least].concat());
    assert_eq!(lines.len(), 42);
    assert!(lines.iter().all(|line| line.contains("track1")));
    // Every network is listed once.
    let different: std::collections::HashSet<&String> = lines.iter().collect();
    assert_eq!(different.len(), lines.len());
    // Two tracks side by side stay two; two restrictions would be one, and come only when they are asked for.
    assert!(lines.contains(&"track1 | track2 | track3 | track4".to_owned()));
    let reducible = counted(&[&OWN[..], &at_least, &["--reducible"]].concat());
    assert!(reducible.trim().parse::<usize>().unwrap() > 42);
}

#[test]
fn masses_end_a_device() {
    let lines = listed(&["--springs", "1", "--dampers", "1", "--masses", "1"]);
    assert!(lines.contains(&"(k1 | c1) + m1".to_owned()), "{lines:?}");
    assert!(lines.iter().all(|line| !line.contains("m1 +")), "{lines:?}");
    let count = counted(&["--springs", "1", "--dampers", "1", "--masses", "1"]);
    assert_eq!(count, format!("{}\n", lines.len()));
}

#[test]
fn large_counts_are_not_listed_to_be_counted() {
    let assert = quell()
        .args(["layouts", "-k", "6", "-c", "6", "-b", "6", "--count"])
        .timeout(std::time::Duration::from_secs(20))
        .assert()
        .code(0);
    assert!(output(&assert).trim().len() > 10, "{}", output(&assert));
}

#[test]
fn a_reader_that_stops_reading_is_no_failure() {
    // Far more layouts than a pipe holds.
    let mut child = Command::new(assert_cmd::cargo::cargo_bin!("quell"))
        .args(["layouts", "-k", "4", "-c", "4", "-b", "4"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap())
        .read_line(&mut line)
        .unwrap();
    assert!(line.contains("k1"));
    let ended = child.wait_with_output().unwrap();
    assert_eq!(ended.status.code(), Some(0));
    assert_eq!(String::from_utf8_lossy(&ended.stderr), "");
}

#[test]
fn what_cannot_be_listed_is_said_in_words() {
    let mut said = String::new();
    for arguments in [
        &["layouts"][..],
        &[
            "layouts",
            "--kinds",
            "track",
            "--branches",
            "2",
            "--at-least",
            "track=x",
        ],
        &[
            "layouts",
            "--kinds",
            "track",
            "--branches",
            "2",
            "--at-least",
            "track",
        ],
        &[
            "layouts",
            "--kinds",
            "track",
            "--branches",
            "2",
            "--at-least",
            "trak=1",
        ],
        &[
            "layouts",
            "--kinds",
            "track",
            "--branches",
            "2",
            "--at-least",
            "track=3",
        ],
        &[
            "layouts",
            "--kinds",
            "track",
            "--branches",
            "2",
            "--compound",
            "pipe",
        ],
        &["layouts", "--kinds", "track,track", "--branches", "2"],
        &["layouts", "--kinds", "9lives", "--branches", "2"],
        &["layouts", "-k", "4000"],
    ] {
        let assert = quell().args(arguments).assert().code(1);
        assert_eq!(output(&assert), "", "{arguments:?}");
        let _ = write!(said, "{}\n  {}", arguments.join(" "), errors(&assert));
    }
    insta::assert_snapshot!(said);
}
