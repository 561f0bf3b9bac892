//! Help, version, completions, manual page, schema, reference.

use crate::{assert_plain, errors, output, quell};

fn help_of(arguments: &[&str]) -> String {
    let assert = quell().args(arguments).arg("--help").assert().success();
    assert_plain(&output(&assert));
    output(&assert)
}

#[test]
fn help() {
    insta::assert_snapshot!(help_of(&[]));
}

#[test]
fn help_of_run() {
    insta::assert_snapshot!(help_of(&["run"]));
}

#[test]
fn help_of_layouts() {
    insta::assert_snapshot!(help_of(&["layouts"]));
}

#[test]
fn version_is_an_answer() {
    let assert = quell().arg("--version").assert().code(0);
    assert_eq!(
        output(&assert),
        format!("quell {}\n", env!("CARGO_PKG_VERSION"))
    );
}

#[test]
fn mistakes_in_what_is_typed_exit_with_one() {
    for arguments in [
        &[][..],
        &["runn", "x.toml"],
        &["run"],
        &["run", "x.toml", "--seed", "three"],
        &["run", "x.toml", "--threads", "0"],
        &[
            "layouts",
            "--springs",
            "1",
            "--kinds",
            "a",
            "--branches",
            "2",
        ],
        &["layouts", "--kinds", "a"],
    ] {
        let assert = quell().args(arguments).assert().code(1);
        assert_eq!(output(&assert), "", "{arguments:?}");
        assert!(!errors(&assert).is_empty(), "{arguments:?}");
    }
}

#[test]
fn completions_and_manual_page_name_every_command() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let assert = quell().args(["completions", shell]).assert().success();
        let text = output(&assert);
        for command in ["check", "run", "layouts", "schema", "reference"] {
            assert!(text.contains(command), "{command} for {shell}");
        }
    }
    let text = output(&quell().arg("man").assert().success());
    assert!(text.starts_with(".ie") || text.starts_with(".TH"), "{text}");
    assert!(text.contains("layouts") && text.contains("Exit codes"));
}

#[test]
fn schema_and_reference_describe_the_keys_of_a_study() {
    let schema: serde_json::Value =
        serde_json::from_str(&output(&quell().arg("schema").assert().success())).unwrap();
    let text = schema.to_string();
    let reference = output(&quell().arg("reference").assert().success());
    for key in ["host", "devices", "runs", "criteria", "tasks", "minimise"] {
        assert!(text.contains(&format!("\"{key}\"")), "{key} in the schema");
        assert!(reference.contains(key), "{key} in the reference");
    }
}
