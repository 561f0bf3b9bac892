//! The run store: what was put is there, whatever happens to the process; one process at a time.
#![allow(missing_docs, reason = "a test binary")]
#![expect(
    clippy::unwrap_used,
    reason = "a test whose files cannot be read has failed"
)]

use std::fs;
use std::path::Path;

use quell_study::store::{Key, Origin, Store, StoreError, Unit};
use tempfile::tempdir;

fn key(number: u64) -> Key {
    Key::of("test").count(number).key()
}

fn origin(hash: &str, title: &str) -> Origin {
    Origin {
        hash: hash.to_owned(),
        title: title.to_owned(),
    }
}

/// The files as they are at this moment: what a killed process leaves.
fn left_behind(folder: &Path) -> tempfile::TempDir {
    let copy = tempdir().unwrap();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        fs::copy(&path, copy.path().join(path.file_name().unwrap())).unwrap();
    }
    copy
}

#[test]
fn what_was_put_is_there_after_a_kill_at_any_moment() {
    let folder = tempdir().unwrap();
    let store = Store::open(folder.path()).unwrap();
    for number in 0..20 {
        let bytes = number.to_string().into_bytes();
        store.put(&key(number), "start", &bytes).unwrap();
        let copy = left_behind(folder.path());
        let found = Store::open(copy.path()).unwrap();
        assert_eq!(found.count().unwrap(), number + 1);
        for earlier in 0..=number {
            let bytes = found.get(&key(earlier), "start").unwrap().unwrap();
            assert_eq!(bytes, earlier.to_string().into_bytes());
        }
        assert_eq!(found.get(&key(number + 1), "start").unwrap(), None);
    }
}

#[test]
fn units_are_told_apart_by_key_and_kind_and_replaced_by_the_same() {
    let folder = tempdir().unwrap();
    let store = Store::open(folder.path()).unwrap();
    let unit = |kind, bytes: &[u8]| Unit {
        key: key(1),
        kind,
        bytes: bytes.to_vec(),
    };
    store
        .put_all(&[unit("start", b"a"), unit("point", b"")])
        .unwrap();
    assert_eq!(store.get(&key(1), "start").unwrap().unwrap(), b"a");
    assert_eq!(store.get(&key(1), "point").unwrap().unwrap(), b"");
    assert_eq!(store.get(&key(1), "curve").unwrap(), None);
    store.put(&key(1), "start", b"b").unwrap();
    drop(store);
    let store = Store::open(folder.path()).unwrap();
    assert_eq!(store.get(&key(1), "start").unwrap().unwrap(), b"b");
    assert_eq!(store.count().unwrap(), 2);
    assert_eq!(store.folder(), folder.path());
}

#[test]
fn one_at_a_time() {
    let folder = tempdir().unwrap();
    let first = Store::open(folder.path()).unwrap();
    let refused = StoreError::InUse {
        folder: folder.path().to_path_buf(),
    };
    assert_eq!(Store::open(folder.path()).unwrap_err(), refused);
    assert_eq!(Store::open_anew(folder.path()).unwrap_err(), refused);
    first.put(&key(1), "start", b"kept").unwrap();
    drop(first);
    let second = Store::open(folder.path()).unwrap();
    assert_eq!(second.get(&key(1), "start").unwrap().unwrap(), b"kept");
    second.put(&key(2), "start", b"new").unwrap();
    assert_eq!(second.get(&key(2), "start").unwrap().unwrap(), b"new");
    assert!(second.is_earlier(&key(1)) && !second.is_earlier(&key(2)));
}

#[test]
fn a_store_belongs_to_one_study() {
    let folder = tempdir().unwrap();
    let store = Store::open(folder.path()).unwrap();
    store.claim(&origin("1", "A")).unwrap();
    store.claim(&origin("1", "A")).unwrap();
    let other = store.claim(&origin("2", "B")).unwrap_err();
    assert!(
        other
            .to_string()
            .ends_with("holds an unfinished run of another study, `A`")
    );
    let edited = store.claim(&origin("2", "A")).unwrap_err();
    assert!(edited.to_string().contains("before its files"), "{edited}");
    store.put(&key(1), "start", b"gone").unwrap();
    drop(store);
    let anew = Store::open_anew(folder.path()).unwrap();
    assert_eq!(anew.get(&key(1), "start").unwrap(), None);
    assert_eq!(anew.count().unwrap(), 0);
    anew.claim(&origin("2", "B")).unwrap();
    anew.remove().unwrap();
    assert!(!Store::is_in(folder.path()));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn what_is_no_store_is_said_to_be_none_and_gives_way_by_force() {
    let folder = tempdir().unwrap();
    let file = folder.path().join("store.sqlite");
    fs::write(
        &file,
        "a letter to my aunt, long enough to be a header of a database\n".repeat(50),
    )
    .unwrap();
    let error = Store::open(folder.path()).unwrap_err();
    assert!(matches!(error, StoreError::NoStore { .. }), "{error:?}");
    assert!(error.to_string().contains("store.sqlite"), "{error}");
    let anew = Store::open_anew(folder.path()).unwrap();
    anew.put(&key(1), "start", b"here").unwrap();
    assert_eq!(anew.count().unwrap(), 1);
    let nowhere = Store::open(&folder.path().join("missing")).unwrap_err();
    assert!(matches!(nowhere, StoreError::Failed { .. }), "{nowhere:?}");
}

#[test]
fn keys_tell_apart_what_is_added_by_place_length_and_bit() {
    let texts = |a: &str, b: &str| Key::of("x").text(a).text(b).key();
    assert_eq!(texts("ab", "c"), texts("ab", "c"));
    assert_ne!(texts("ab", "c"), texts("a", "bc"));
    assert_ne!(Key::of("x").text("y").key(), Key::of("y").text("x").key());
    let number = |number: f64| Key::of("x").number(number).key();
    assert_ne!(number(0.0), number(-0.0));
    assert_ne!(number(1.0), number(f64::from_bits(1.0_f64.to_bits() + 1)));
    let lists = |a: &[f64], b: &[f64]| Key::of("x").numbers(a).numbers(b).key();
    assert_ne!(lists(&[1.0], &[]), lists(&[], &[1.0]));
}
