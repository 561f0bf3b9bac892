//! The file of a run store.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use rusqlite::{Connection, ErrorCode, OptionalExtension, params};

use super::{Key, StoreError};

/// Name of the file in a run's folder.
const FILE: &str = "store.sqlite";

/// The version of the tables, in the file's `user_version`.
const LAYOUT: i64 = 1;

/// Which study the units of a store belong to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Origin {
    /// [`Study::hash`](crate::Study::hash).
    pub hash: String,
    /// The study's title.
    pub title: String,
}

/// A finished unit of work.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unit {
    /// What determines it.
    pub key: Key,
    /// What it is: `start`, `point` …
    pub kind: &'static str,
    /// What came out, as its kind writes it.
    pub bytes: Vec<u8>,
}

/// Finished units of work in a run's folder; see the [module](crate::store).
#[derive(Debug)]
pub struct Store {
    folder: PathBuf,
    path: PathBuf,
    connection: Mutex<Connection>,
    /// Prefixes of the keys that were in the file when it was opened. A run that begins anew asks for a million units that
    /// are not there, and shall not wait for the writer to be told so.
    earlier: HashSet<u64>,
    /// Prefixes of those that were put since.
    later: Mutex<HashSet<u64>>,
}

impl Store {
    /// Opens the store of a run's folder, makes it where there is none, and keeps others out.
    ///
    /// # Errors
    /// [`StoreError::InUse`] where another process has it open, [`StoreError::NoStore`] where the file is something else,
    /// [`StoreError::Failed`] where the disk refuses.
    pub fn open(folder: &Path) -> Result<Self, StoreError> {
        let path = folder.join(FILE);
        let failed = |error: &rusqlite::Error| named(error, folder, &path);
        let connection = Connection::open(&path).map_err(|error| failed(&error))?;
        prepare(&connection).map_err(|error| failed(&error))?;
        let layout: i64 = connection
            .pragma_query_value(None, "user_version", |row| row.get(0))
            .map_err(|error| failed(&error))?;
        let tables: i64 = connection
            .query_row("SELECT count(*) FROM sqlite_schema", [], |row| row.get(0))
            .map_err(|error| failed(&error))?;
        if layout == 0 && tables == 0 {
            connection
                .execute_batch(&format!(
                    "BEGIN IMMEDIATE; {TABLES} PRAGMA user_version = {LAYOUT}; COMMIT;"
                ))
                .map_err(|error| failed(&error))?;
            sync_folder(folder);
        } else if layout != LAYOUT {
            return Err(StoreError::NoStore {
                path,
                reason: format!("its layout is {layout}, this Quell's is {LAYOUT}"),
            });
        }
        let store = Self {
            folder: folder.to_path_buf(),
            earlier: prefixes(&connection).map_err(|error| failed(&error))?,
            later: Mutex::new(HashSet::new()),
            connection: Mutex::new(connection),
            path,
        };
        Ok(store)
    }

    /// Opens the store of a folder and empties it; a file that is no store gives way to one.
    ///
    /// # Errors
    /// [`StoreError::InUse`] where another process has it open, [`StoreError::Failed`] where the disk refuses.
    pub fn open_anew(folder: &Path) -> Result<Self, StoreError> {
        match Self::open(folder) {
            Ok(mut store) => {
                store.empty()?;
                Ok(store)
            }
            // Whoever had it open would have made it a store, so nobody is robbed.
            Err(StoreError::NoStore { .. }) => {
                Self::remove_files(folder)?;
                Self::open(folder)
            }
            Err(other) => Err(other),
        }
    }

    /// Whether a folder holds a store, open or not.
    pub fn is_in(folder: &Path) -> bool {
        folder.join(FILE).is_file()
    }

    /// Closes the store and removes its file: for a run that came to nothing.
    ///
    /// # Errors
    /// [`StoreError::Failed`] where the disk refuses.
    pub fn remove(self) -> Result<(), StoreError> {
        let folder = self.folder.clone();
        drop(self);
        Self::remove_files(&folder)
    }

    fn remove_files(folder: &Path) -> Result<(), StoreError> {
        for name in [
            FILE.to_owned(),
            format!("{FILE}-wal"),
            format!("{FILE}-shm"),
        ] {
            let path = folder.join(name);
            if path.exists() {
                fs::remove_file(&path).map_err(|error| StoreError::Failed {
                    reason: error.to_string(),
                    path,
                })?;
            }
        }
        Ok(())
    }

    /// The store's folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    fn connection(&self) -> MutexGuard<'_, Connection> {
        // Whatever another thread was at, SQLite's transactions left the file whole.
        self.connection
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    fn later(&self) -> MutexGuard<'_, HashSet<u64>> {
        self.later.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether a unit was there when the store was opened, rather than put since.
    pub fn is_earlier(&self, key: &Key) -> bool {
        self.earlier.contains(&Key::prefix(key.bytes()))
    }

    fn failed(&self, error: &rusqlite::Error) -> StoreError {
        named(error, &self.folder, &self.path)
    }

    /// Says whose units these are, or finds that they are of the same origin.
    ///
    /// # Errors
    /// [`StoreError::Another`] where they are of another.
    pub fn claim(&self, origin: &Origin) -> Result<(), StoreError> {
        let connection = self.connection();
        let known: Option<(String, String)> = connection
            .query_row("SELECT hash, title FROM origin", [], |row| {
                Ok((row.get(0)?, row.get(1)?))
            })
            .optional()
            .map_err(|error| self.failed(&error))?;
        match known {
            Some((hash, _)) if hash == origin.hash => Ok(()),
            Some((_, title)) => Err(StoreError::Another {
                folder: self.folder.clone(),
                same_title: title == origin.title,
                title,
            }),
            None => connection
                .execute(
                    "INSERT INTO origin (hash, title) VALUES (?1, ?2)",
                    params![origin.hash, origin.title],
                )
                .map(drop)
                .map_err(|error| self.failed(&error)),
        }
    }

    /// How many units it holds.
    ///
    /// # Errors
    /// [`StoreError::Failed`].
    pub fn count(&self) -> Result<u64, StoreError> {
        self.connection()
            .query_row("SELECT count(*) FROM units", [], |row| row.get::<_, i64>(0))
            .map(i64::unsigned_abs)
            .map_err(|error| self.failed(&error))
    }

    /// What was put under a key and a kind; none if nothing was.
    ///
    /// # Errors
    /// [`StoreError::Failed`].
    pub fn get(&self, key: &Key, kind: &str) -> Result<Option<Vec<u8>>, StoreError> {
        let prefix = Key::prefix(key.bytes());
        if !self.earlier.contains(&prefix) && !self.later().contains(&prefix) {
            return Ok(None);
        }
        self.connection()
            .prepare("SELECT bytes FROM units WHERE key = ?1 AND kind = ?2")
            .and_then(|mut statement| {
                statement
                    .query_row(params![key.bytes(), kind], |row| row.get(0))
                    .optional()
            })
            .map_err(|error| self.failed(&error))
    }

    /// Puts a unit; when this returns, the unit is on the disk. What stood under the key and kind gives way.
    ///
    /// # Errors
    /// [`StoreError::Failed`]; the store is as it was before then.
    pub fn put(&self, key: &Key, kind: &'static str, bytes: &[u8]) -> Result<(), StoreError> {
        self.put_all(&[Unit {
            key: *key,
            kind,
            bytes: bytes.to_vec(),
        }])
    }

    /// Puts several units, all of them or none, with one wait for the disk.
    ///
    /// # Errors
    /// As [`Self::put`].
    pub fn put_all(&self, units: &[Unit]) -> Result<(), StoreError> {
        if units.is_empty() {
            return Ok(());
        }
        let mut connection = self.connection();
        let write = |connection: &mut Connection| {
            let transaction = connection.transaction()?;
            {
                let mut statement = transaction.prepare(
                    "INSERT OR REPLACE INTO units (key, kind, bytes) VALUES (?1, ?2, ?3)",
                )?;
                for unit in units {
                    statement.execute(params![unit.key.bytes(), unit.kind, unit.bytes])?;
                }
            }
            transaction.commit()
        };
        write(&mut connection).map_err(|error| self.failed(&error))?;
        drop(connection);
        self.later()
            .extend(units.iter().map(|unit| Key::prefix(unit.key.bytes())));
        Ok(())
    }

    /// Forgets everything.
    fn empty(&mut self) -> Result<(), StoreError> {
        self.connection()
            .execute_batch(
                "BEGIN IMMEDIATE; DELETE FROM units; DELETE FROM origin; COMMIT; VACUUM;",
            )
            .map_err(|error| self.failed(&error))?;
        self.earlier.clear();
        self.later().clear();
        Ok(())
    }
}

const TABLES: &str = "
    CREATE TABLE origin (hash TEXT NOT NULL, title TEXT NOT NULL);
    CREATE TABLE units (
        key BLOB NOT NULL,
        kind TEXT NOT NULL,
        bytes BLOB NOT NULL,
        PRIMARY KEY (key, kind)
    ) WITHOUT ROWID;
";

/// One process at a time, and nothing that was committed is lost in a power cut.
fn prepare(connection: &Connection) -> rusqlite::Result<()> {
    // A run that finds another at work says so at once.
    connection.busy_timeout(std::time::Duration::ZERO)?;
    // Before the write-ahead log is first touched: then the lock is held from the first read to the end of the process,
    // and no memory is shared between processes, so that network and container file systems do.
    connection.pragma_update(None, "locking_mode", "EXCLUSIVE")?;
    connection
        .pragma_update_and_check(None, "journal_mode", "WAL", |row| row.get::<_, String>(0))?;
    // FULL: the log is synchronised at every commit. NORMAL would lose the last ones in a power cut.
    connection.pragma_update(None, "synchronous", "FULL")?;
    // On macOS alone: the drive's own cache as well.
    connection.pragma_update(None, "fullfsync", true)?;
    // A first write takes the lock in every journal mode.
    connection.execute_batch("BEGIN IMMEDIATE; COMMIT;")
}

fn prefixes(connection: &Connection) -> rusqlite::Result<HashSet<u64>> {
    let mut statement = connection.prepare("SELECT key FROM units")?;
    let mut rows = statement.query([])?;
    let mut known = HashSet::new();
    while let Some(row) = rows.next()? {
        let bytes = row.get_ref(0)?;
        known.insert(Key::prefix(bytes.as_blob().unwrap_or_default()));
    }
    Ok(known)
}

/// SQLite's error in the words of a run store.
fn named(error: &rusqlite::Error, folder: &Path, path: &Path) -> StoreError {
    match error.sqlite_error_code() {
        Some(ErrorCode::DatabaseBusy | ErrorCode::DatabaseLocked) => StoreError::InUse {
            folder: folder.to_path_buf(),
        },
        Some(ErrorCode::NotADatabase) => StoreError::NoStore {
            path: path.to_path_buf(),
            reason: "it is something else".to_owned(),
        },
        Some(ErrorCode::DatabaseCorrupt) => StoreError::NoStore {
            path: path.to_path_buf(),
            reason: "it is damaged".to_owned(),
        },
        Some(ErrorCode::DiskFull) => StoreError::Failed {
            path: path.to_path_buf(),
            reason: "the disk is full".to_owned(),
        },
        _ => StoreError::Failed {
            path: path.to_path_buf(),
            reason: error.to_string(),
        },
    }
}

/// The folder's own entries reach the disk, where the system can be asked for that.
fn sync_folder(folder: &Path) {
    if cfg!(unix) {
        for folder in [Some(folder), folder.parent()].into_iter().flatten() {
            // Some file systems refuse; then they order such writes themselves.
            let _ = fs::File::open(folder).and_then(|folder| folder.sync_all());
        }
    }
}
