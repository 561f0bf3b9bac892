//! Readers of matrix files against files written by NumPy and SciPy (`matrices/make.py` says how).

use std::path::Path;

use faer::Mat;
use quell_model::matrix::{MatrixError, read_matrix};

fn read(file: &str) -> Result<Mat<f64>, MatrixError> {
    read_matrix(
        file,
        &Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/matrices"),
    )
}

/// Exact comparison: every value of the fixtures is a binary fraction.
#[track_caller]
#[expect(clippy::unwrap_used, reason = "a helper of tests fails as tests do")]
fn assert_holds(file: &str, expected: &[&[f64]]) {
    let matrix = read(file).unwrap();
    let found: Vec<Vec<f64>> = (0..matrix.nrows())
        .map(|row| {
            (0..matrix.ncols())
                .map(|column| matrix[(row, column)])
                .collect()
        })
        .collect();
    assert_eq!(found, expected, "{file}");
}

const GENERAL: &[&[f64]] = &[
    &[11.5, 12.5, 13.5],
    &[21.5, 22.5, 23.5],
    &[31.5, 32.5, 33.5],
];
const WIDE: &[&[f64]] = &[&[11.5, 12.5, 13.5], &[21.5, 22.5, 23.5]];
const SYMMETRIC: &[&[f64]] = &[&[4.0, -1.0, 0.0], &[-1.0, 5.0, -2.25], &[0.0, -2.25, 6.0]];
const SKEW: &[&[f64]] = &[&[0.0, -1.5, 0.0], &[1.5, 0.0, 2.0], &[0.0, -2.0, 0.0]];
const WHOLE: &[&[f64]] = &[&[1.0, -2.0], &[3.0, 1_099_511_627_776.0]];

#[test]
fn numpy_files() {
    assert_holds("general_c_f8.npy", GENERAL);
    assert_holds("general_fortran_f8.npy", GENERAL);
    assert_holds("general_big_endian_f8.npy", GENERAL);
    assert_holds("wide_c_f4.npy", WIDE);
    assert_holds("wide_fortran_f4.npy", WIDE);
    assert_holds("whole_i8.npy", WHOLE);
    assert_holds("whole_i4.npy", &[&[1.0, -2.0], &[3.0, 4.0]]);
    assert_holds("several.npz:M", SYMMETRIC);
    assert_holds("several.npz:K", GENERAL);
    assert_holds("one_compressed.npz", SYMMETRIC);
}

#[test]
fn matrix_market_files() {
    assert_holds("general_array.mtx", GENERAL);
    assert_holds("wide_array.mtx", WIDE);
    assert_holds("symmetric_array.mtx", SYMMETRIC);
    assert_holds("skew_array.mtx", SKEW);
    assert_holds("symmetric_coordinate.mtx", SYMMETRIC);
    assert_holds("skew_coordinate.mtx", SKEW);
    assert_holds("general_coordinate.mtx", GENERAL);
    assert_holds("whole_coordinate.mtx", WHOLE);
}

#[test]
fn delimited_files() {
    assert_holds("general.csv", GENERAL);
    assert_holds("general_semicolon.csv", GENERAL);
    assert_holds("general_blanks.txt", GENERAL);
}

#[test]
fn refusals_say_why() {
    let refusals: Vec<String> = [
        "complex.mtx",
        "pattern.mtx",
        "complex.npy",
        "three_axes.npy",
        "not_a_number.npy",
        "several.npz",
        "several.npz:C",
        "sparse.npz",
        "missing.mtx",
        "model.xlsx",
    ]
    .into_iter()
    .map(|file| {
        let error = read(file).unwrap_err();
        match &error.help {
            Some(help) => format!("{error}\n  help: {help}"),
            None => error.to_string(),
        }
    })
    .collect();
    insta::assert_snapshot!(refusals.join("\n"));
}

#[test]
fn damaged_files_are_refused_without_a_panic() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/matrices");
    let damaged = tempfile::tempdir().unwrap();
    for file in [
        "general_c_f8.npy",
        "several.npz",
        "symmetric_coordinate.mtx",
        "general.csv",
    ] {
        let bytes = std::fs::read(folder.join(file)).unwrap();
        for cut in 0..bytes.len() {
            std::fs::write(damaged.path().join(file), &bytes[..cut]).unwrap();
            let _ = read_matrix(file, damaged.path());
            let mut changed = bytes.clone();
            changed[cut] = changed[cut].wrapping_add(1 + (cut % 250) as u8);
            std::fs::write(damaged.path().join(file), &changed).unwrap();
            let _ = read_matrix(file, damaged.path());
        }
    }
}
