//! Units of work on their way to the run store, and what is told of them.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};

use quell_continuation::Interrupt;
use quell_document::Fault;

use super::Progress;
use crate::store::{Key, Store, StoreError, Unit};

/// Messages on their way before the workers wait for the disk.
const AHEAD: usize = 1024;

/// What workers tell the writer.
enum Message {
    /// A unit is finished.
    Unit(Unit),
    /// Whatever was finished before may be reported, in these words.
    Advance(String),
}

/// Takes finished units and reports of progress from all threads.
///
/// With a store, one thread writes: everything that has come in while the disk was busy goes in one transaction, and
/// progress is reported after the units before it are on the disk. So no worker waits, and nothing that was reported
/// finished can be lost.
pub(super) struct Recorder<'a> {
    progress: &'a dyn Progress,
    store: Option<(&'a Store, SyncSender<Message>)>,
    failure: &'a OnceLock<StoreError>,
    restored: AtomicU64,
}

/// The writer's end.
pub(super) struct Writer<'a> {
    progress: &'a dyn Progress,
    store: &'a Store,
    messages: Receiver<Message>,
    failure: &'a OnceLock<StoreError>,
}

impl<'a> Recorder<'a> {
    /// Without a store: units are worked out and forgotten.
    pub(super) fn forgetful(progress: &'a dyn Progress, failure: &'a OnceLock<StoreError>) -> Self {
        Self {
            progress,
            store: None,
            failure,
            restored: AtomicU64::new(0),
        }
    }

    /// With a store, and the writer that is to run on a thread of its own until the recorder is dropped.
    pub(super) fn to(
        store: &'a Store,
        progress: &'a dyn Progress,
        failure: &'a OnceLock<StoreError>,
    ) -> (Self, Writer<'a>) {
        let (sender, messages) = sync_channel(AHEAD);
        let recorder = Self {
            store: Some((store, sender)),
            ..Self::forgetful(progress, failure)
        };
        let writer = Writer {
            progress,
            store,
            messages,
            failure,
        };
        (recorder, writer)
    }

    /// A task begins.
    pub(super) fn begin(&self, task: &str, units: u64) {
        self.progress.begin(task, units);
    }

    /// How far the unit at hand is, in words.
    pub(super) fn note(&self, words: &str) {
        self.progress.note(words);
    }

    /// Something that is counted in a task is done.
    pub(super) fn advance(&self, best: &str) {
        match &self.store {
            // A writer that is gone has left its reason in `failure`.
            Some((_, sender)) => drop(sender.send(Message::Advance(best.to_owned()))),
            None => self.progress.advance(best),
        }
    }

    /// A unit of work: from the store, or worked out and put there.
    ///
    /// `read` says none where the bytes are not what it knows; then they are worked out again.
    pub(super) fn unit<T>(
        &self,
        key: &Key,
        kind: &'static str,
        read: impl FnOnce(&[u8]) -> Option<T>,
        write: impl FnOnce(&T) -> Vec<u8>,
        work: impl FnOnce() -> T,
    ) -> T {
        if self.store.is_none() {
            return work();
        }
        if let Some(found) = self.kept(key, kind).and_then(|bytes| read(&bytes)) {
            self.tell_restored(key);
            return found;
        }
        let found = work();
        self.keep(key, kind, write(&found));
        found
    }

    /// What the store holds of a unit. A store that cannot be read costs time, and is told when it cannot be written either.
    pub(super) fn kept(&self, key: &Key, kind: &'static str) -> Option<Vec<u8>> {
        let (store, _) = self.store.as_ref()?;
        store.get(key, kind).ok()?
    }

    /// Puts a finished unit into the store.
    pub(super) fn keep(&self, key: &Key, kind: &'static str, bytes: Vec<u8>) {
        if let Some((_, sender)) = &self.store {
            let unit = Unit {
                key: *key,
                kind,
                bytes,
            };
            drop(sender.send(Message::Unit(unit)));
        }
    }

    /// Counts a unit that was read from the store.
    pub(super) fn tell_restored(&self, key: &Key) {
        // Tasks of one study may share a layout; that is no news of an earlier run.
        if self
            .store
            .as_ref()
            .is_some_and(|(store, _)| store.is_earlier(key))
        {
            let restored = self.restored.fetch_add(1, Ordering::Relaxed) + 1;
            self.progress.restored(restored);
        }
    }

    /// What asks to stop branches at their next point, where whoever waits has such a thing.
    pub(super) fn interrupt(&self) -> Option<Interrupt> {
        self.progress.interrupt()
    }

    /// Whether branches are followed just now, which heed the interrupt.
    pub(super) fn heed(&self, heeded: bool) {
        self.progress.heed(heeded);
    }

    /// How many units came from the store.
    pub(super) fn restored(&self) -> u64 {
        self.restored.load(Ordering::Relaxed)
    }

    /// Fails as soon as the store has.
    pub(super) fn check(&self) -> Result<(), Fault> {
        self.failure.get().map_or(Ok(()), |error| Err(fault(error)))
    }
}

/// A store's failure in the words of a run.
pub(super) fn fault(error: &StoreError) -> Fault {
    Fault::new(error.to_string()).help(error.remedy())
}

impl Writer<'_> {
    /// Writes until the recorder is dropped.
    pub(super) fn run(self) {
        let mut units: Vec<Unit> = Vec::new();
        let mut reports: Vec<String> = Vec::new();
        while let Ok(first) = self.messages.recv() {
            let mut next = Ok(first);
            while let Ok(message) = next {
                match message {
                    Message::Unit(unit) => units.push(unit),
                    Message::Advance(best) => reports.push(best),
                }
                next = if units.len() < AHEAD {
                    self.messages.try_recv()
                } else {
                    Err(TryRecvError::Empty)
                };
            }
            if let Err(error) = self.store.put_all(&units) {
                // Dropping the receiver lets workers go on without waiting; the run ends at its next check.
                let _ = self.failure.set(error);
                return;
            }
            units.clear();
            for best in reports.drain(..) {
                self.progress.advance(&best);
            }
        }
    }
}
