//! `quell check`: is the study sound, and what would it do?

use quell_study::Study;

use crate::arguments::CheckOptions;
use crate::terminal::{self, Exit};

pub(crate) fn check(options: &CheckOptions) -> Result<(), Exit> {
    let study = Study::read(&options.study).map_err(|fault| Exit::Study(Box::new(fault)))?;
    let summary = quell_study::check(&study).map_err(|fault| Exit::Study(Box::new(fault)))?;
    let mut text = format!("{}\n", study.title);
    for line in &summary.lines {
        text.push_str("  ");
        text.push_str(line);
        text.push('\n');
    }
    text.push_str("The study is sound.\n");
    terminal::print(&text)
}
