//! `quell run`: the shortlist on the terminal, `results.json` and `report.html` in a folder.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use quell_study::store::{Origin, Store, StoreError};
use quell_study::{RunError, RunSettings, Study};

use crate::arguments::RunOptions;
use crate::progress::Bar;
use crate::shortlist;
use crate::terminal::{self, Exit};

const RESULTS: &str = "results.json";
const REPORT: &str = "report.html";

pub(crate) fn run(options: &RunOptions) -> Result<(), Exit> {
    let study = Study::read(&options.study).map_err(|fault| Exit::Study(Box::new(fault)))?;
    let folder = match &options.out {
        Some(folder) => folder.clone(),
        None => default_folder(&options.study)?,
    };
    let settings = RunSettings {
        seed: options.seed,
        threads: options.threads.map(usize::from),
        tasks: options.task.clone(),
    };
    // Before an earlier run gives way to one that cannot be.
    settings.check(&study).map_err(exit)?;
    refuse_to_overwrite(&folder, options.force)?;
    let made = prepare(&folder)?;
    let store = open(&study, &folder, options.force)?;
    let bar = Bar::new();
    bar.watch_interrupts();
    let outcome = quell_study::run_with_store(&study, &settings, &bar, &store);
    bar.finish();
    let outcome = match outcome {
        Ok(outcome) => outcome,
        Err(error) => {
            // A study that cannot run leaves no empty folder behind; one that was there stays.
            if made && !matches!(error, RunError::Store(_)) && store.remove().is_ok() {
                let _ = fs::remove_dir(&folder);
            }
            return Err(exit(error));
        }
    };

    let results = serde_json::to_string_pretty(&outcome.results)
        .map_err(|error| Exit::failed(format!("the results could not be written: {error}")))?;
    // The results come last: a folder that holds them holds a whole run, or says that it was interrupted.
    let report = folder.join(REPORT);
    write(&report, &quell_report::html(&study, &outcome))?;
    for (name, text) in outcome.files() {
        write(&folder.join(name), &text)?;
    }
    write(&folder.join(RESULTS), &format!("{results}\n"))?;

    let text = shortlist::text(&study, &outcome);
    terminal::print(&format!("{text}Report: {}\n", report.display()))?;
    if bar.is_interrupted() {
        return Err(Exit::Interrupted(
            "the run was interrupted; the same command goes on with it".to_owned(),
        ));
    }
    Ok(())
}

fn exit(error: RunError) -> Exit {
    match error {
        RunError::Study(fault) | RunError::NoSuchTask(fault) => Exit::Study(fault),
        RunError::Threads(fault) | RunError::Store(fault) => Exit::Run(fault),
    }
}

/// Opens the folder's store: that of an interrupted run of the same study is gone on with, any other is refused; by force
/// whatever is there gives way.
fn open(study: &Study, folder: &Path, force: bool) -> Result<Store, Exit> {
    let refused = |error: StoreError| match error {
        StoreError::Failed { reason, .. } => nothing_run(folder, &reason),
        _ => Exit::Asked(format!("{error}; {}", error.remedy())),
    };
    let store = if force {
        Store::open_anew(folder)
    } else {
        Store::open(folder)
    }
    .map_err(refused)?;
    if force {
        // From here on the folder holds an unfinished run, which these would hide.
        for name in [RESULTS, REPORT] {
            let path = folder.join(name);
            if path.exists() {
                fs::remove_file(&path).map_err(|error| {
                    Exit::failed(format!(
                        "`{}` cannot be removed, so nothing was run: {error}",
                        path.display()
                    ))
                })?;
            }
        }
    }
    let origin = Origin {
        hash: study.hash.clone(),
        title: study.title.clone(),
    };
    store.claim(&origin).map_err(refused)?;
    Ok(store)
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
    let results = folder.join(RESULTS);
    if force || !results.exists() || was_interrupted(&results) {
        return Ok(());
    }
    Err(Exit::Asked(format!(
        "`{}` already holds a run; `--force` starts afresh over it, `--out DIR` puts this one elsewhere",
        folder.display()
    )))
}

/// Whether these are the results of a run that was asked to stop.
fn was_interrupted(results: &Path) -> bool {
    let text = fs::read_to_string(results).unwrap_or_default();
    let found: Option<serde_json::Value> = serde_json::from_str(&text).ok();
    let tasks = found
        .as_ref()
        .and_then(|found| found.get("tasks")?.as_object());
    tasks.is_some_and(|tasks| {
        tasks.values().any(|task| {
            task.get("status").and_then(|status| status.as_str()) == Some("interrupted")
        })
    })
}

/// Makes the folder, before time is spent on what could not be kept; true where it was not there.
fn prepare(folder: &Path) -> Result<bool, Exit> {
    let made = !folder.exists();
    fs::create_dir_all(folder).map_err(|error| nothing_run(folder, &error))?;
    Ok(made)
}

fn nothing_run(folder: &Path, reason: &dyn std::fmt::Display) -> Exit {
    Exit::failed(format!(
        "the folder `{}` cannot be written, so nothing was run: {reason}",
        folder.display()
    ))
}

/// Writes beside the target and renames, so that a reader never sees half a file.
fn write(path: &Path, text: &str) -> Result<(), Exit> {
    let beside = path.with_extension("partial");
    fs::File::create(&beside)
        .and_then(|mut file| {
            file.write_all(text.as_bytes())?;
            // A name that reaches the disk before what it names is an empty file after a power cut.
            file.sync_all()
        })
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
