//! No text makes the reader or the check of studies panic, or keeps them busy.
//!
//! Paths in the text are relative to `studies/`; begin with the studies themselves:
//! `cargo +nightly fuzz run study fuzz/corpus/study studies crates/quell-study/tests/wrong`.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use quell_document::Source;
use quell_study::{Study, check};

fuzz_target!(|text: &str| {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../studies");
    let checked =
        Study::parse(Source::new("study.toml", text), &folder).and_then(|study| check(&study));
    if let Err(fault) = checked {
        let words = fault.render();
        assert!(words.starts_with("error: "));
    }
});
