//! Study files, criteria, design problems and the runner.
//!
//! [`Study::read`] reads a study, [`check`] says whether it is sound, [`run`] runs it. What comes out is a [`RunOutcome`];
//! its `results` are the stable record that is written to `results.json`.

mod amount;
pub mod band;
mod built;
mod candidates;
mod check;
mod combination;
mod configuration;
pub mod continuation;
mod criteria;
mod evaluator;
pub mod immittance;
pub mod keys;
mod linear;
pub mod outcome;
mod plots;
mod problem;
mod push;
mod read;
mod record;
mod reference;
pub mod results;
mod runner;
mod situation;
mod standing;
pub mod store;
pub mod study;
mod sweep;
mod transient;
mod unread;

pub use amount::Amount;
pub use check::{Summary, check};
pub use outcome::{
    BuiltDevice, Design, DesignFindings, Evaluated, Findings, FrontFindings, FrontPoint,
    LayoutFront, NamedValue, Over, Plot, PointOutcome, Reference, Role, RunOutcome, Series,
    TaskOutcome,
};
pub use problem::{DesignProblem, ProblemScratch, problems};
pub use quell_continuation::Interrupt;
pub use read::FILE_VERSION;
pub use runner::{Progress, RunError, RunSettings, Silent, run, run_with_store};
pub use standing::Standing;
pub use study::{Sense, Study};

/// The JSON Schema of study files, for editors.
pub fn json_schema() -> serde_json::Value {
    quell_document::json_schema(&keys::STUDY)
}

/// The reference of every key of study and host files, as Markdown.
pub fn reference() -> String {
    format!(
        "{}\n{}",
        quell_document::reference_markdown(&keys::STUDY),
        quell_document::reference_markdown(&quell_model::host::keys::HOST)
    )
}
