//! `quell run`: the shortlist on the terminal, `results.json` and `report.html` in a folder.

use std::fmt::Write as _;

use std::fs;
use std::path::{Path, PathBuf};

use quell_study::{RunError, RunSettings, Study};

use crate::arguments::RunOptions;
use crate::progress::Bar;
use crate::shortlist;
use crate::terminal::{self, Exit};

pub(crate) fn run(options: &RunOptions) -> Result<(), Exit> {
    let study = Study::read(&options.study).map_err(|fault| Exit::Study(Box::new(fault)))?;
    let folder = match &options.out {
        Some(folder) => folder.clone(),
        None => default_folder(&options.study)?,
    };
    refuse_to_overwrite(&folder, options.force)?;
    let settings = RunSettings {
        seed: options.seed,
        threads: options.threads.map(usize::from),
        tasks: options.task.clone(),
    };
    let made = prepare(&folder)?;
    let bar = Bar::new();
    let outcome = quell_study::run(&study, &settings, &bar);
    bar.finish();
    let outcome = outcome.map_err(|error| {
        // A study that cannot run leaves no empty folder behind; one that was there stays.
        if made {
            let _ = fs::remove_dir(&folder);
        }
        match error {
            RunError::Study(fault) | RunError::NoSuchTask(fault) => Exit::Study(fault),
            RunError::Threads(fault) => Exit::Run(fault),
        }
    })?;

    let results = serde_json::to_string_pretty(&outcome.results)
        .map_err(|error| Exit::failed(format!("the results could not be written: {error}")))?;
    // The results come last: a folder that holds them holds a whole run.
    let report = folder.join("report.html");
    write(&report, &quell_report::html(&study, &outcome))?;
    for (name, text) in outcome.files() {
        write(&folder.join(name), &text)?;
    }
    write(&folder.join("results.json"), &format!("{results}\n"))?;

    let mut text = shortlist::text(&study, &outcome);
    // Writing to a string cannot fail.
    let _ = writeln!(text, "Report: {}", report.display());
    terminal::print(&text)
}

fn default_folder(study: &Path) -> Result<PathBuf, Exit> {
    let name = study.file_stem().ok_or_else(|| {
        Exit::Asked(format!(
            "`{}` names no file; give the folder for the results by `--out DIR`",
            study.display()
        ))
    })?;
    Ok(Path::new("runs").join(name))
}

fn refuse_to_overwrite(folder: &Path, force: bool) -> Result<(), Exit> {
    if force || !folder.join("results.json").exists() {
        return Ok(());
    }
    Err(Exit::Asked(format!(
        "`{}` already holds a run; `--force` starts afresh over it, `--out DIR` puts this one elsewhere",
        folder.display()
    )))
}

/// Makes the folder and tries it, before time is spent on what could not be kept; true where it was not there.
fn prepare(folder: &Path) -> Result<bool, Exit> {
    let made = !folder.exists();
    let cannot = |error: std::io::Error| {
        Exit::failed(format!(
            "the folder `{}` cannot be written, so nothing was run: {error}",
            folder.display()
        ))
    };
    fs::create_dir_all(folder).map_err(cannot)?;
    let trial = folder.join("results.partial");
    fs::write(&trial, "").map_err(cannot)?;
    fs::remove_file(&trial).map_err(cannot)?;
    Ok(made)
}

/// Writes beside the target and renames, so that a reader never sees half a file.
fn write(path: &Path, text: &str) -> Result<(), Exit> {
    let beside = path.with_extension("partial");
    fs::write(&beside, text)
        .and_then(|()| fs::rename(&beside, path))
        .map_err(|error| {
            // Half a file is of no use to anybody.
            let _ = fs::remove_file(&beside);
            Exit::failed(format!(
                "`{}` could not be written: {error}",
                path.display()
            ))
        })
}
