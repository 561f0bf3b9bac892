//! Branches that are interrupted and gone on with: the same bits as of a run that was not.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a failed test ends by panic"
)]

mod support;

use std::time::Duration;

use quell_study::store::Store;
use quell_study::{Interrupt, Progress, RunOutcome, Silent};
use support::{responses, settings};

/// The folds of the responses of a forced oscillator.
const FOLDS: &str = r#"
[[tasks]]
name = "folds"
kind = "curve"
start = "response:LPC1"
parameters = ["Om", "F0"]
ranges = { F0 = [0.02, 0.4] }
"#;

/// Results and files to the last digit, but for the time it took.
fn written(outcome: &RunOutcome) -> (String, Vec<(String, String)>) {
    let tasks = serde_json::to_string(&outcome.results.tasks).unwrap();
    (tasks, outcome.files().collect())
}

/// Asks to stop some time after branches begin to be followed.
struct Impatient {
    interrupt: Interrupt,
    patience: Duration,
}

impl Impatient {
    fn new(patience: Duration) -> Self {
        Self {
            interrupt: Interrupt::new(),
            patience,
        }
    }
}

impl Progress for Impatient {
    fn begin(&self, _: &str, _: u64) {}
    fn advance(&self, _: &str) {}
    fn interrupt(&self) -> Option<Interrupt> {
        Some(self.interrupt.clone())
    }
    fn heed(&self, heeded: bool) {
        if heeded && self.patience.is_zero() {
            self.interrupt.raise();
        } else if heeded {
            let (interrupt, patience) = (self.interrupt.clone(), self.patience);
            std::thread::spawn(move || {
                std::thread::sleep(patience);
                interrupt.raise();
            });
        }
    }
}

#[test]
fn what_is_interrupted_says_so_and_goes_on_to_the_same_bits() {
    let study = support::written(&responses(FOLDS));
    let whole = quell_study::run(&study, &settings(2, &[]), &Silent).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let run = |progress: &dyn Progress| {
        let store = Store::open(folder.path()).unwrap();
        let outcome = quell_study::run_with_store(&study, &settings(2, &[]), progress, &store);
        (outcome.unwrap(), store.count().unwrap())
    };
    // At once: a branch with its start alone, which is no unit of work, and no second task.
    let (outcome, kept) = run(&Impatient::new(Duration::ZERO));
    assert_eq!(kept, 0);
    assert_eq!(outcome.results.tasks.len(), 1);
    let first = &outcome.results.tasks["response"];
    assert_eq!(first.status, "interrupted");
    let text = serde_json::to_string(first).unwrap();
    assert!(
        text.contains(r#""stop":{"backward":"interrupted","forward":"interrupted"}"#),
        "{text}"
    );
    // After ever longer times, until one run is long enough. What was computed so far is handed out.
    let mut rounds = 0;
    let last = (0..)
        .map(|round| Duration::from_millis(5 << round))
        .map(|patience| run(&Impatient::new(patience)).0)
        .inspect(|_| rounds += 1)
        .find(|outcome| {
            outcome.results.tasks.len() == 2
                && outcome
                    .results
                    .tasks
                    .values()
                    .all(|task| task.status == "done")
        })
        .unwrap();
    assert!(rounds > 1, "5 ms were enough for everything");
    assert_eq!(written(&last), written(&whole));
    // And once more, with nothing left to follow.
    let (again, _) = run(&Silent);
    assert_eq!(again.restored, 2);
    assert_eq!(written(&again), written(&whole));
}

#[test]
fn a_labelled_point_is_a_start_after_a_restart() {
    let study = support::written(&responses(FOLDS));
    let folder = tempfile::tempdir().unwrap();
    let run = |tasks: &[&str]| {
        let store = Store::open(folder.path()).unwrap();
        quell_study::run_with_store(&study, &settings(2, tasks), &Silent, &store).unwrap()
    };
    assert_eq!(run(&["response"]).restored, 0);
    // The branch that the curve starts on comes from the store, with the orbit of its label on its mesh.
    let folds = run(&["folds"]);
    assert_eq!(folds.restored, 1);
    let alone = quell_study::run(&study, &settings(2, &["folds"]), &Silent).unwrap();
    assert_eq!(written(&folds), written(&alone));
}
