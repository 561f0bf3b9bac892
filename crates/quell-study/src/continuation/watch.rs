//! How far a branch is, for whoever waits for it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};

use quell_continuation::Monitor;

/// Counts the points that are computed.
#[derive(Debug, Clone, Default)]
pub(crate) struct Watcher {
    seen: Arc<Seen>,
}

#[derive(Debug, Default)]
struct Seen {
    points: AtomicUsize,
    parameter: AtomicU64,
    measuring: AtomicBool,
    motions: AtomicUsize,
    all_motions: AtomicUsize,
}

impl Watcher {
    /// A monitor that has no zero: it only counts.
    pub(super) fn monitor(&self) -> Monitor {
        let seen = Arc::clone(&self.seen);
        Monitor::new(move |view| {
            seen.points.fetch_add(1, Ordering::Relaxed);
            if let Some(value) = view.parameters.first() {
                seen.parameter.store(value.to_bits(), Ordering::Relaxed);
            }
            1.0
        })
    }

    /// A monitor that counts only, where parameters are on scales of their own.
    pub(super) fn counter(&self) -> Monitor {
        let seen = Arc::clone(&self.seen);
        Monitor::new(move |_| {
            seen.points.fetch_add(1, Ordering::Relaxed);
            1.0
        })
    }

    /// So many motions will be let go.
    pub(super) fn let_go(&self, motions: usize) {
        self.seen.all_motions.store(motions, Ordering::Relaxed);
    }

    /// One of them has been watched to its end.
    pub(super) fn watched(&self) {
        self.seen.motions.fetch_add(1, Ordering::Relaxed);
    }

    pub(super) fn measuring(&self) {
        self.seen.measuring.store(true, Ordering::Relaxed);
    }

    /// Solutions so far, and where the last one is.
    pub(crate) fn words(&self, parameter: &str) -> String {
        let all = self.seen.all_motions.load(Ordering::Relaxed);
        if all > 0 {
            let done = self.seen.motions.load(Ordering::Relaxed);
            return format!("{done} of {all} motions");
        }
        let points = self.seen.points.load(Ordering::Relaxed);
        if self.seen.measuring.load(Ordering::Relaxed) {
            return format!("{points} solutions, measuring");
        }
        let bits = self.seen.parameter.load(Ordering::Relaxed);
        if bits == 0 {
            return format!("{points} solutions");
        }
        let value = f64::from_bits(bits);
        format!("{points} solutions, {parameter} = {value:.4}")
    }
}
