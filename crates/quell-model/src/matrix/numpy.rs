//! NumPy's `.npy` and `.npz`.

use std::io::{Cursor, Read};

use faer::Mat;
use npyz::{NpyFile, Order};
use zip::ZipArchive;

use super::{Complaint, LARGEST_MATRIX, size_is_sane};

/// NumPy itself refuses longer headers.
const LONGEST_HEADER: usize = 10_000;
/// Digits of a header: with at most this many, no product of its numbers overflows.
const MOST_DIGITS: usize = 18;

/// Reads one array of two axes.
pub(super) fn parse_npy(bytes: &[u8]) -> Result<Mat<f64>, Complaint> {
    guard_header(bytes)?;
    let file = NpyFile::new(bytes)
        .map_err(|error| Complaint::new(format!("the NumPy header cannot be read: {error}")))?;
    let shape: Vec<usize> = file.shape().iter().map(|&size| size as usize).collect();
    let [rows, columns] = shape[..] else {
        return Err(Complaint::new(format!(
            "expected an array of two axes, found {}",
            shape.len()
        )));
    };
    size_is_sane(rows, columns)?;
    let order = file.order();
    let kind = file.dtype().descr();
    let values = values(file, rows * columns).ok_or_else(|| {
        Complaint::new(format!(
            "expected real numbers (f4, f8, i4 or i8), found the NumPy type {kind}"
        ))
    })?;
    let values = values
        .map_err(|error| Complaint::new(format!("the array's data cannot be read: {error}")))?;
    if values.len() != rows * columns {
        return Err(Complaint::new(format!(
            "the header announces {} numbers, but the file holds {}",
            rows * columns,
            values.len()
        )));
    }
    let at = |row: usize, column: usize| match order {
        Order::C => values[row * columns + column],
        Order::Fortran => values[column * rows + row],
    };
    for row in 0..rows {
        for column in 0..columns {
            if !at(row, column).is_finite() {
                return Err(Complaint::new(format!(
                    "entry ({}, {}) is not a finite number",
                    row + 1,
                    column + 1
                )));
            }
        }
    }
    Ok(Mat::from_fn(rows, columns, at))
}

/// Refuses headers whose lengths would overflow or exhaust memory inside the reader.
fn guard_header(bytes: &[u8]) -> Result<(), Complaint> {
    let malformed = || Complaint::new("the file is not a NumPy array");
    let (length, start) = match bytes {
        [0x93, b'N', b'U', b'M', b'P', b'Y', 1, _, low, high, ..] => {
            (usize::from(u16::from_le_bytes([*low, *high])), 10)
        }
        [0x93, b'N', b'U', b'M', b'P', b'Y', 2 | 3, _, a, b, c, d, ..] => {
            (u32::from_le_bytes([*a, *b, *c, *d]) as usize, 12)
        }
        _ => return Err(malformed()),
    };
    let header = bytes.get(start..start + length).ok_or_else(malformed)?;
    let digits = header.iter().filter(|byte| byte.is_ascii_digit()).count();
    let brackets = header.iter().filter(|byte| b"([{".contains(byte)).count();
    if length > LONGEST_HEADER || digits > MOST_DIGITS || brackets > 4 {
        return Err(Complaint::new(format!(
            "the NumPy header describes something other than a matrix of at most {LARGEST_MATRIX} rows and columns"
        )));
    }
    Ok(())
}

/// All numbers in file order; none where the type is not one of ours.
fn values(file: NpyFile<&[u8]>, count: usize) -> Option<std::io::Result<Vec<f64>>> {
    macro_rules! attempt {
        ($file:expr, $type:ty) => {
            match $file.try_data::<$type>() {
                // `take` before collecting keeps the reservation at the size that was checked.
                Ok(reader) => {
                    return Some(
                        reader
                            .take(count)
                            .map(|value| value.map(|value| value as f64))
                            .collect(),
                    );
                }
                Err(file) => file,
            }
        };
    }
    let file = attempt!(file, f64);
    #[expect(clippy::cast_lossless, reason = "one macro serves all types")]
    let file = attempt!(file, f32);
    #[expect(clippy::cast_lossless, reason = "one macro serves all types")]
    let file = attempt!(file, i32);
    let _ = attempt!(file, i64);
    None
}

/// Reads the array `name` of an archive, or its only one.
pub(super) fn parse_npz(bytes: &[u8], name: Option<&str>) -> Result<Mat<f64>, Complaint> {
    let mut archive = ZipArchive::new(Cursor::new(bytes))
        .map_err(|error| Complaint::new(format!("the NumPy archive cannot be opened: {error}")))?;
    let names: Vec<String> = archive
        .file_names()
        .filter_map(|file| file.strip_suffix(".npy"))
        .map(str::to_owned)
        .collect();
    let listed = || {
        let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
        quoted.join(", ")
    };
    if ["indices", "indptr", "shape"]
        .iter()
        .all(|part| names.iter().any(|name| name == part))
    {
        return Err(Complaint::new("the archive is a sparse matrix of SciPy")
            .help("save it as Matrix Market, `scipy.io.mmwrite(\"K.mtx\", K)`"));
    }
    let chosen = match name {
        Some(name) if names.iter().any(|known| known == name) => name,
        Some(name) => {
            return Err(Complaint::new(format!(
                "the archive has no array `{name}`; it holds {}",
                listed()
            )));
        }
        None => match &names[..] {
            [only] => only,
            [] => return Err(Complaint::new("the archive holds no array")),
            _ => {
                return Err(Complaint::new(format!(
                    "the archive holds several arrays: {}",
                    listed()
                ))
                .help("choose one as `file.npz:NAME`"));
            }
        },
    };
    let mut entry = archive
        .by_name(&format!("{chosen}.npy"))
        .map_err(|error| Complaint::new(format!("array `{chosen}` cannot be read: {error}")))?;
    let largest = (LARGEST_MATRIX * LARGEST_MATRIX * 8 + LONGEST_HEADER) as u64;
    let mut data = Vec::new();
    entry
        .by_ref()
        .take(largest)
        .read_to_end(&mut data)
        .map_err(|error| Complaint::new(format!("array `{chosen}` cannot be read: {error}")))?;
    parse_npy(&data).map_err(|complaint| Complaint {
        message: format!("array `{chosen}`: {}", complaint.message),
        ..complaint
    })
}
