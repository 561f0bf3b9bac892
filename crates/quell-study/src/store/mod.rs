//! The run store: every finished unit of work of a run, in one SQLite file in the run's folder.
//!
//! A unit is whatever is worth not doing twice: a start of a search, a labelled point of a branch. It is kept under a
//! [`Key`], a hash of everything that determines it, so that a unit that is found can be taken as it is:
//!
//! ```
//! use quell_study::store::{Key, Store};
//!
//! # fn main() -> Result<(), quell_study::store::StoreError> {
//! # let temporary = tempfile::tempdir().unwrap();
//! # let folder = temporary.path();
//! let store = Store::open(folder)?;
//! let key = Key::of("point").text("hash of the study").number(0.1).key();
//! store.put(&key, "point", b"any bytes")?;
//! assert_eq!(store.get(&key, "point")?.as_deref(), Some(b"any bytes".as_slice()));
//! # Ok(())
//! # }
//! ```
//!
//! What [`Store::put`] returned from is on the disk: neither a killed process nor a power cut loses it. One process at a
//! time has a store open; the lock is the operating system's and goes with the process that holds it, however that ends.

mod error;
mod file;
mod key;

pub use error::StoreError;
pub use file::{Origin, Store, Unit};
pub use key::{Key, KeyBuilder};
