//! `quell`: from a study file to a ranked shortlist of vibration suppressors.
//!
//! Exit codes: 0 done (an infeasible design is done, and says so), 1 the study is wrong, 2 the run failed, 130 it was interrupted.

mod arguments;
mod branches;
mod check;
mod diagnostics;
mod layouts;
mod progress;
mod run;
mod shortlist;
mod synthesise;
mod table;
mod terminal;

use std::process::ExitCode;

use clap::{CommandFactory, Parser};

use arguments::{Arguments, Command};
use terminal::Exit;

fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            // Help and version go to standard output and are what was asked for; anything else is a mistake in what was
            // typed, and 2 is taken by runs that failed.
            let code = u8::from(error.use_stderr());
            let _ = error.print();
            return ExitCode::from(code);
        }
    };
    let result = match arguments.command {
        Command::Check(options) => check::check(&options),
        Command::Run(options) => run::run(&options),
        Command::Layouts(options) => layouts::layouts(&options),
        Command::Synthesise(options) => synthesise::synthesise(&options),
        Command::Schema => terminal::print(&format!("{:#}\n", quell_study::json_schema())),
        Command::Reference => terminal::print(&quell_study::reference()),
        Command::Completions { shell } => {
            let mut text = Vec::new();
            clap_complete::generate(shell, &mut Arguments::command(), "quell", &mut text);
            terminal::print(&String::from_utf8_lossy(&text))
        }
        Command::Man => man_page(),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(exit) => exit.report(),
    }
}

fn man_page() -> Result<(), Exit> {
    let mut text = Vec::new();
    clap_mangen::Man::new(Arguments::command())
        .render(&mut text)
        .map_err(|error| Exit::failed(format!("the manual page could not be written: {error}")))?;
    terminal::print(&String::from_utf8_lossy(&text))
}
