//! What can be wrong with a run store.

use std::path::PathBuf;

use thiserror::Error;

/// Why a store cannot be opened, read or written.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum StoreError {
    /// Another process has it open.
    #[error("another run is writing to `{}`", folder.display())]
    InUse {
        /// The folder of the run.
        folder: PathBuf,
    },
    /// The file is there and is something else, or was written by a Quell whose stores are laid out in another way.
    #[error("`{}` cannot be read as a run store: {reason}", path.display())]
    NoStore {
        /// The file.
        path: PathBuf,
        /// What was found.
        reason: String,
    },
    /// The store holds units of another study.
    #[error("`{}` holds an unfinished run of {}", folder.display(), whose(title, *same_title))]
    Another {
        /// The folder of the run.
        folder: PathBuf,
        /// Title of the study that was run there.
        title: String,
        /// It has the title of the study that is to run: an earlier state of it.
        same_title: bool,
    },
    /// Reading or writing failed.
    #[error("the run store `{}` failed: {reason}", path.display())]
    Failed {
        /// The file.
        path: PathBuf,
        /// What the operating system or SQLite says.
        reason: String,
    },
}

fn whose(title: &str, same_title: bool) -> String {
    if same_title {
        format!("`{title}` as it was before its files, or Quell, changed")
    } else {
        format!("another study, `{title}`")
    }
}

impl StoreError {
    /// What to do about it, as far as `quell run` can help.
    pub fn remedy(&self) -> &'static str {
        match self {
            Self::InUse { .. } => "wait until it ends, or put this run elsewhere by `--out DIR`",
            Self::NoStore { .. } | Self::Another { .. } => {
                "`--force` starts afresh over it, `--out DIR` puts this run elsewhere"
            }
            Self::Failed { .. } => {
                "what was finished before is kept: once there is space and access, the same command goes on"
            }
        }
    }
}
