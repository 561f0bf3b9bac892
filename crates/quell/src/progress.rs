//! A progress bar with the best so far and the time left; silent when not on a terminal.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use quell_study::{Interrupt, Progress};

/// The bar of one run.
pub(crate) struct Bar {
    drawn: Mutex<ProgressBar>,
    shown: bool,
    restored: AtomicU64,
    interrupt: Interrupt,
    /// How many tasks follow branches just now.
    heeding: Arc<AtomicUsize>,
}

impl Bar {
    pub(crate) fn new() -> Self {
        Self {
            drawn: Mutex::new(ProgressBar::hidden()),
            shown: std::io::stderr().is_terminal(),
            restored: AtomicU64::new(0),
            interrupt: Interrupt::new(),
            heeding: Arc::new(AtomicUsize::new(0)),
        }
    }

    /// From now on Ctrl-C (or a request to terminate) ends branches at their next point; where none is followed, or at the second
    /// time, it ends the program. The store holds what was finished in either case.
    pub(crate) fn watch_interrupts(&self) {
        let (interrupt, heeding) = (self.interrupt.clone(), Arc::clone(&self.heeding));
        let set = ctrlc::set_handler(move || {
            if heeding.load(Ordering::SeqCst) == 0 || interrupt.is_raised() {
                // What a signal does to a program without a handler.
                std::process::exit(130);
            }
            interrupt.raise();
        });
        // Without a handler a signal ends the program, and the store goes on from what was finished.
        drop(set);
    }

    /// Whether somebody asked to stop.
    pub(crate) fn is_interrupted(&self) -> bool {
        self.interrupt.is_raised()
    }

    fn with(&self, act: impl FnOnce(&ProgressBar)) {
        // A poisoned lock only means that another thread panicked while drawing.
        let bar = self
            .drawn
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        act(&bar);
    }

    pub(crate) fn finish(&self) {
        self.with(ProgressBar::finish_and_clear);
    }
}

impl Progress for Bar {
    fn begin(&self, task: &str, units: u64) {
        if !self.shown {
            return;
        }
        let style = ProgressStyle::with_template(
            "{prefix:.bold} [{bar:32}] {pos}/{len} {elapsed} (left {eta})  {wide_msg}",
        )
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .progress_chars("=> ");
        let new =
            ProgressBar::with_draw_target(Some(units), ProgressDrawTarget::stderr_with_hz(10))
                .with_style(style)
                .with_prefix(task.to_owned());
        let mut bar = self
            .drawn
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        bar.finish_and_clear();
        *bar = new;
    }

    fn note(&self, words: &str) {
        if self.shown {
            self.with(|bar| bar.set_message(words.to_owned()));
        }
    }

    fn advance(&self, best: &str) {
        if self.shown {
            self.with(|bar| {
                bar.inc(1);
                bar.set_message(match self.restored.load(Ordering::Relaxed) {
                    0 => best.to_owned(),
                    pieces => format!("{best} ({pieces} pieces of work from the interrupted run)"),
                });
            });
        }
    }

    fn interrupt(&self) -> Option<Interrupt> {
        Some(self.interrupt.clone())
    }

    fn heed(&self, heeded: bool) {
        if heeded {
            self.heeding.fetch_add(1, Ordering::SeqCst);
        } else {
            self.heeding.fetch_sub(1, Ordering::SeqCst);
        }
    }

    fn restored(&self, pieces: u64) {
        self.restored.fetch_max(pieces, Ordering::Relaxed);
    }
}
