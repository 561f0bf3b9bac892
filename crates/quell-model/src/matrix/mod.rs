//! Matrices from files: Matrix Market, NumPy and delimited text.
//!
//! | file | read as |
//! | --- | --- |
//! | `*.mtx`, `*.mm` | Matrix Market, `array` or `coordinate`, `real` or `integer`, `general`, `symmetric` or `skew-symmetric` |
//! | `*.npy` | one NumPy array of two axes, real or integer, in C or Fortran order |
//! | `*.npz`, `*.npz:M` | the array `M` of a NumPy archive; the name may be left out where there is only one |
//! | `*.csv`, `*.txt`, `*.dat` | rows of numbers apart by commas, semicolons, tabs or blanks; `#` starts a comment line |
//!
//! Values are taken as SI numbers, and every one must be finite.

mod delimited;
mod market;
mod numpy;

use std::path::{Path, PathBuf};

use faer::Mat;

/// The most rows or columns of a matrix read from a file: hosts are dense, and one matrix of this size takes 200 MB.
pub const LARGEST_MATRIX: usize = 5_000;

/// What is wrong with a matrix file, in words.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{file}`{}: {message}", .line.map(|line| format!(", line {line}")).unwrap_or_default())]
pub struct MatrixError {
    /// The file as the user named it.
    pub file: String,
    /// The line in it, from 1, where there is one.
    pub line: Option<usize>,
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    pub help: Option<String>,
}

/// Where in a file something is wrong, before the file's name is known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Complaint {
    line: Option<usize>,
    message: String,
    help: Option<String>,
}

impl Complaint {
    fn new(message: impl Into<String>) -> Self {
        Self {
            line: None,
            message: message.into(),
            help: None,
        }
    }

    fn at(line: usize, message: impl Into<String>) -> Self {
        Self {
            line: Some(line),
            ..Self::new(message)
        }
    }

    fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    fn in_file(self, file: &str) -> MatrixError {
        MatrixError {
            file: file.to_owned(),
            line: self.line,
            message: self.message,
            help: self.help,
        }
    }
}

/// Reads the real matrix that `reference` names: a path, or for an archive `file.npz:NAME`.
///
/// - `reference`: the file as the user wrote it; a relative path starts at `base`.
/// - `base`: the folder of the file in which the reference stands.
///
/// # Errors
/// The file cannot be read, is of no known kind, is malformed, is complex or a pattern,
/// holds a number that is not finite, or is larger than [`LARGEST_MATRIX`].
///
/// # References
/// R. F. Boisvert, R. Pozo, K. Remington, The Matrix Market exchange formats: initial design, NISTIR 5935 (1996);
/// NumPy Enhancement Proposal 1 (2007), the `.npy` format.
pub fn read_matrix(reference: &str, base: &Path) -> Result<Mat<f64>, MatrixError> {
    let (path, array) = split_reference(reference);
    let full: PathBuf = base.join(path);
    let fail = |complaint: Complaint| complaint.in_file(reference);
    let extension = Path::new(path)
        .extension()
        .and_then(|extension| extension.to_str())
        .map(str::to_ascii_lowercase);
    let kind = match extension.as_deref() {
        Some("mtx" | "mm") => Kind::Market,
        Some("npy") => Kind::Npy,
        Some("npz") => Kind::Npz,
        Some("csv" | "txt" | "dat" | "tsv") => Kind::Delimited,
        _ => {
            return Err(fail(
                Complaint::new("the file's ending does not say what it holds").help(
                    "matrices are read from `.mtx` (Matrix Market), `.npy`, `.npz` and `.csv` files",
                ),
            ));
        }
    };
    let bytes = std::fs::read(&full).map_err(|error| {
        fail(match error.kind() {
            std::io::ErrorKind::NotFound => Complaint::new("there is no such file")
                .help("a path is relative to the file that names it"),
            _ => Complaint::new(format!("the file cannot be read: {error}")),
        })
    })?;
    match kind {
        Kind::Market => text(&bytes).and_then(market::parse),
        Kind::Delimited => text(&bytes).and_then(delimited::parse),
        Kind::Npy => numpy::parse_npy(&bytes),
        Kind::Npz => numpy::parse_npz(&bytes, array),
    }
    .map_err(fail)
}

/// The file that `reference` names, as [`read_matrix`] takes it.
#[must_use]
pub fn matrix_path(reference: &str, base: &Path) -> PathBuf {
    base.join(split_reference(reference).0)
}

enum Kind {
    Market,
    Npy,
    Npz,
    Delimited,
}

/// Splits `model.npz:M` into the file and the array's name; other references are all file.
fn split_reference(reference: &str) -> (&str, Option<&str>) {
    if let Some((file, array)) = reference.rsplit_once(':')
        && file.to_ascii_lowercase().ends_with(".npz")
    {
        return (file, Some(array));
    }
    (reference, None)
}

fn text(bytes: &[u8]) -> Result<&str, Complaint> {
    let text = std::str::from_utf8(bytes)
        .map_err(|_| Complaint::new("the file is not text (it is not valid UTF-8)"))?;
    Ok(text.strip_prefix('\u{feff}').unwrap_or(text))
}

/// Reads one real number, with a Fortran exponent (`1.0D+00`) allowed.
fn number(word: &str, line: usize) -> Result<f64, Complaint> {
    let value: f64 = word
        .parse()
        .or_else(|_| word.replace(['d', 'D'], "e").parse())
        .map_err(|_| {
            let complaint = Complaint::at(line, format!("expected a number, found `{word}`"));
            if word.contains(',') {
                complaint.help("write a decimal point, not a decimal comma")
            } else {
                complaint
            }
        })?;
    if value.is_finite() {
        Ok(value)
    } else {
        Err(Complaint::at(
            line,
            format!("expected a finite number, found `{word}`"),
        ))
    }
}

fn size_is_sane(rows: usize, columns: usize) -> Result<(), Complaint> {
    if rows == 0 || columns == 0 {
        return Err(Complaint::new(format!(
            "the matrix is empty ({rows} x {columns})"
        )));
    }
    if rows > LARGEST_MATRIX || columns > LARGEST_MATRIX {
        return Err(Complaint::new(format!(
            "the matrix is {rows} x {columns}; at most {LARGEST_MATRIX} rows and columns can be read"
        ))
        .help("reduce the model first, for example by component mode synthesis"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reference_of_an_archive_names_its_array() {
        assert_eq!(split_reference("a/b.npz:M"), ("a/b.npz", Some("M")));
        assert_eq!(split_reference("b.npz"), ("b.npz", None));
        assert_eq!(split_reference("C:b.npy"), ("C:b.npy", None));
    }

    #[test]
    fn numbers_may_have_fortran_exponents_and_must_be_finite() {
        assert_eq!(number("1.5D+02", 1), Ok(150.0));
        assert!(number("inf", 1).is_err());
        assert!(number("1e999", 1).is_err());
        assert!(number("NaN", 1).is_err());
        assert_eq!(
            number("0,5", 3).unwrap_err().help.as_deref(),
            Some("write a decimal point, not a decimal comma")
        );
    }
}
