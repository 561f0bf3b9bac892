//! Helpers of the integration tests.
#![allow(dead_code, reason = "each test binary uses its share")]
#![allow(clippy::panic, reason = "helpers of tests fail as tests do")]

use std::sync::Arc;

use faer::Mat;
use quell_document::Source;
use quell_model::{HostFile, LinearHost};

#[track_caller]
pub(crate) fn file(text: &str) -> HostFile {
    HostFile::parse(Arc::new(Source::new("host.toml", text)), ".")
        .unwrap_or_else(|fault| panic!("{}", fault.render()))
}

#[track_caller]
pub(crate) fn build(text: &str) -> LinearHost {
    file(text)
        .build(&[])
        .unwrap_or_else(|fault| panic!("{}", fault.render()))
}

pub(crate) fn rows(matrix: &Mat<f64>) -> Vec<Vec<f64>> {
    (0..matrix.nrows())
        .map(|row| {
            (0..matrix.ncols())
                .map(|column| matrix[(row, column)])
                .collect()
        })
        .collect()
}

pub(crate) fn column(matrix: &Mat<f64>) -> Vec<f64> {
    (0..matrix.nrows()).map(|row| matrix[(row, 0)]).collect()
}

/// Equal within 1e-12 of the largest entry: a few roundings.
#[track_caller]
pub(crate) fn assert_close(found: &Mat<f64>, expected: &[&[f64]]) {
    let found = rows(found);
    assert_eq!(found.len(), expected.len());
    let largest = expected
        .iter()
        .flat_map(|row| row.iter())
        .fold(0.0_f64, |largest, value| largest.max(value.abs()));
    for (row, wanted) in found.iter().zip(expected) {
        assert_eq!(row.len(), wanted.len());
        for (value, wanted) in row.iter().zip(*wanted) {
            assert!(
                (value - wanted).abs() <= 1e-12 * largest,
                "{found:?} is not {expected:?}"
            );
        }
    }
}
