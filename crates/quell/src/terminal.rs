//! The one place that writes to standard output and decides exit codes.

use std::io::{self, Write};
use std::process::ExitCode;

use quell_document::Fault;

use crate::diagnostics;

/// Why the program ends without having done what was asked.
#[derive(Debug)]
pub(crate) enum Exit {
    /// The study is wrong: exit code 1.
    Study(Box<Fault>),
    /// What was typed on the command line is wrong: exit code 1.
    Asked(String),
    /// The run failed: exit code 2.
    Run(Box<Fault>),
    /// The machine failed (a file could not be written …): exit code 2.
    Failed(String),
    /// Somebody asked to stop: exit code 130, as after a signal.
    Interrupted(String),
    /// Whoever read our output has stopped reading; that is no fault of ours.
    Closed,
}

impl Exit {
    pub(crate) fn failed(message: impl Into<String>) -> Self {
        Self::Failed(message.into())
    }

    pub(crate) fn report(self) -> ExitCode {
        let (text, code) = match self {
            Self::Study(fault) => (diagnostics::render(&fault), 1),
            Self::Asked(message) => (format!("{message}\n"), 1),
            Self::Run(fault) => (diagnostics::render(&fault), 2),
            Self::Failed(message) => (format!("{message}\n"), 2),
            Self::Interrupted(message) => (format!("{message}\n"), 130),
            Self::Closed => return ExitCode::SUCCESS,
        };
        // Nothing can be done about a standard error that refuses to be written to.
        let _ = io::stderr().write_all(text.as_bytes());
        ExitCode::from(code)
    }
}

/// Writes text to standard output; a closed pipe (`quell layouts … | head`) ends quietly.
pub(crate) fn print(text: &str) -> Result<(), Exit> {
    let mut output = io::stdout().lock();
    output
        .write_all(text.as_bytes())
        .and_then(|()| output.flush())
        .map_err(|error| output_failed(&error))
}

/// What to do when standard output cannot be written.
pub(crate) fn output_failed(error: &io::Error) -> Exit {
    match error.kind() {
        io::ErrorKind::BrokenPipe => Exit::Closed,
        _ => Exit::failed(format!("standard output could not be written: {error}")),
    }
}
