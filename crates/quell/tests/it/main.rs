//! The program as a person or a script meets it: what it prints, writes and answers.

#![expect(
    clippy::unwrap_used,
    reason = "a test whose files cannot be read has failed"
)]

mod check;
mod help;
mod interrupt;
mod layouts;
mod objectives;
mod run;
mod store;
mod synthesise;

use std::path::PathBuf;

use assert_cmd::Command;
use assert_cmd::assert::Assert;

/// The program, in the root of the repository, without colour settings of whoever runs the tests.
fn quell() -> Command {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("quell"));
    command
        .current_dir(root())
        .env_remove("NO_COLOR")
        .env_remove("CLICOLOR_FORCE")
        .env_remove("FORCE_COLOR")
        .env("COLUMNS", "100");
    command
}

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn output(assert: &Assert) -> String {
    String::from_utf8_lossy(&assert.get_output().stdout).into_owned()
}

fn errors(assert: &Assert) -> String {
    String::from_utf8_lossy(&assert.get_output().stderr).into_owned()
}

/// Neither colours nor a redrawn line: what a log file should not hold.
fn assert_plain(text: &str) {
    assert!(!text.contains('\u{1b}'), "escape sequences in {text:?}");
    assert!(!text.contains('\r'), "carriage returns in {text:?}");
}
