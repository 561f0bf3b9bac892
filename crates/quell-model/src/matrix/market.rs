//! Matrix Market exchange format.
//!
//! Boisvert, Pozo and Remington (1996). Symmetric files hold the lower triangle; entries of a coordinate file that
//! name the same place are added, as finite-element codes and SciPy do.

use faer::Mat;

use super::{Complaint, number, size_is_sane};

#[derive(Clone, Copy, PartialEq, Eq)]
enum Symmetry {
    General,
    Symmetric,
    Skew,
}

impl Symmetry {
    const fn name(self) -> &'static str {
        match self {
            Self::General => "general",
            Self::Symmetric => "symmetric",
            Self::Skew => "skew-symmetric",
        }
    }
}

struct Header {
    coordinate: bool,
    integer: bool,
    symmetry: Symmetry,
}

fn header(line: &str) -> Result<Header, Complaint> {
    let lower = line.to_ascii_lowercase();
    let words: Vec<&str> = lower.split_whitespace().collect();
    let [banner, object, format, field, symmetry] = words[..] else {
        return Err(Complaint::at(
            1,
            "expected a header such as `%%MatrixMarket matrix coordinate real symmetric`",
        ));
    };
    if banner != "%%matrixmarket" {
        return Err(Complaint::at(
            1,
            "expected a header that starts with `%%MatrixMarket`",
        ));
    }
    if object != "matrix" {
        return Err(Complaint::at(
            1,
            format!("expected a `matrix`, found `{object}`"),
        ));
    }
    let coordinate = match format {
        "coordinate" => true,
        "array" => false,
        _ => {
            return Err(Complaint::at(
                1,
                format!("expected `coordinate` or `array`, found `{format}`"),
            ));
        }
    };
    let integer = match field {
        "real" | "double" => false,
        "integer" => true,
        "complex" => {
            return Err(
                Complaint::at(1, "the matrix is complex, and a host's matrices are real").help(
                    "give the imaginary part of a complex stiffness as a loss factor, `damping = { loss = … }`",
                ),
            );
        }
        "pattern" => {
            return Err(Complaint::at(
                1,
                "the matrix is a pattern, which says where entries stand but not their values",
            ));
        }
        _ => {
            return Err(Complaint::at(
                1,
                format!("expected `real` or `integer`, found `{field}`"),
            ));
        }
    };
    let symmetry = match symmetry {
        "general" => Symmetry::General,
        "symmetric" => Symmetry::Symmetric,
        "skew-symmetric" => Symmetry::Skew,
        _ => {
            return Err(Complaint::at(
                1,
                format!("expected `general`, `symmetric` or `skew-symmetric`, found `{symmetry}`"),
            ));
        }
    };
    Ok(Header {
        coordinate,
        integer,
        symmetry,
    })
}

/// Reads the text of a Matrix Market file.
pub(super) fn parse(text: &str) -> Result<Mat<f64>, Complaint> {
    let mut lines = text
        .lines()
        .enumerate()
        .map(|(index, line)| (index + 1, line.trim()));
    let header = header(lines.next().map_or("", |(_, line)| line))?;
    let mut lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('%'));
    let Some((size_line, sizes)) = lines.next() else {
        return Err(Complaint::new("the file ends before the line of sizes"));
    };
    let wanted = if header.coordinate {
        "three whole numbers: rows, columns, entries"
    } else {
        "two whole numbers: rows, columns"
    };
    let sizes: Vec<usize> = sizes
        .split_whitespace()
        .map(str::parse)
        .collect::<Result<_, _>>()
        .map_err(|_| Complaint::at(size_line, format!("expected {wanted}; found `{sizes}`")))?;
    let (rows, columns, entries) = match (header.coordinate, &sizes[..]) {
        (true, &[rows, columns, entries]) => (rows, columns, Some(entries)),
        (false, &[rows, columns]) => (rows, columns, None),
        _ => {
            return Err(Complaint::at(
                size_line,
                format!("expected {wanted}; found {} numbers", sizes.len()),
            ));
        }
    };
    size_is_sane(rows, columns).map_err(|complaint| Complaint {
        line: Some(size_line),
        ..complaint
    })?;
    if header.symmetry != Symmetry::General && rows != columns {
        return Err(Complaint::at(
            size_line,
            format!(
                "a {} matrix is square, but this one is {rows} x {columns}",
                header.symmetry.name()
            ),
        ));
    }
    let value = |word: &str, line: usize| {
        if header.integer && word.parse::<i64>().is_err() {
            return Err(Complaint::at(
                line,
                format!("expected an integer, as the header says; found `{word}`"),
            ));
        }
        number(word, line)
    };
    let mut matrix = Mat::zeros(rows, columns);
    let mut add = |row: usize, column: usize, value: f64| {
        matrix[(row, column)] += value;
        if row != column {
            match header.symmetry {
                Symmetry::General => {}
                Symmetry::Symmetric => matrix[(column, row)] += value,
                Symmetry::Skew => matrix[(column, row)] -= value,
            }
        }
    };
    if let Some(entries) = entries {
        let mut count = 0_usize;
        for (line, content) in lines {
            let words: Vec<&str> = content.split_whitespace().collect();
            let [row, column, word] = words[..] else {
                return Err(Complaint::at(
                    line,
                    format!("expected `row column value`, found `{content}`"),
                ));
            };
            count += 1;
            if count > entries {
                return Err(Complaint::at(
                    line,
                    format!(
                        "the file has more than the {entries} entries that line {size_line} announces"
                    ),
                ));
            }
            let place = |word: &str, size: usize, what: &str| {
                word.parse::<usize>()
                    .ok()
                    .filter(|index| (1..=size).contains(index))
                    .map(|index| index - 1)
                    .ok_or_else(|| {
                        Complaint::at(
                            line,
                            format!("expected a {what} from 1 to {size}, found `{word}`"),
                        )
                    })
            };
            let row = place(row, rows, "row")?;
            let column = place(column, columns, "column")?;
            let value = value(word, line)?;
            if header.symmetry != Symmetry::General && row < column {
                return Err(Complaint::at(
                    line,
                    format!(
                        "a {} file holds the lower triangle, but this entry stands above the diagonal",
                        header.symmetry.name()
                    ),
                ));
            }
            if header.symmetry == Symmetry::Skew && row == column && value != 0.0 {
                return Err(Complaint::at(
                    line,
                    "the diagonal of a skew-symmetric matrix is zero",
                ));
            }
            add(row, column, value);
        }
        if count < entries {
            return Err(Complaint::new(format!(
                "line {size_line} announces {entries} entries, but the file ends after {count}"
            )));
        }
        return finite(matrix);
    }
    // Array files run down the columns, from the diagonal where there is symmetry.
    let first = |column: usize| match header.symmetry {
        Symmetry::General => 0,
        Symmetry::Symmetric => column,
        Symmetry::Skew => column + 1,
    };
    let mut words =
        lines.flat_map(|(line, content)| content.split_whitespace().map(move |word| (line, word)));
    for column in 0..columns {
        for row in first(column)..rows {
            let Some((line, word)) = words.next() else {
                return Err(Complaint::new(format!(
                    "the file ends before entry ({}, {}) of a {rows} x {columns} matrix",
                    row + 1,
                    column + 1
                )));
            };
            add(row, column, value(word, line)?);
        }
    }
    if let Some((line, word)) = words.next() {
        return Err(Complaint::at(
            line,
            format!("expected the end of a {rows} x {columns} matrix, found `{word}`"),
        ));
    }
    finite(matrix)
}

/// Sums of entries may overflow although each is finite.
fn finite(matrix: Mat<f64>) -> Result<Mat<f64>, Complaint> {
    if matrix.is_all_finite() {
        Ok(matrix)
    } else {
        Err(Complaint::new(
            "entries that name the same place add up to more than a number can hold",
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(matrix: &Mat<f64>) -> Vec<Vec<f64>> {
        (0..matrix.nrows())
            .map(|row| {
                (0..matrix.ncols())
                    .map(|column| matrix[(row, column)])
                    .collect()
            })
            .collect()
    }

    fn message(text: &str) -> (Option<usize>, String) {
        let complaint = parse(text).unwrap_err();
        (complaint.line, complaint.message)
    }

    #[test]
    fn array_runs_down_columns() {
        let text = "%%MatrixMarket matrix array real general\n% comment\n2 3\n1\n2\n3\n4\n5\n6\n";
        assert_eq!(
            rows(&parse(text).unwrap()),
            [[1.0, 3.0, 5.0], [2.0, 4.0, 6.0]]
        );
    }

    #[test]
    fn symmetric_and_skew_arrays_hold_the_lower_triangle() {
        let text = "%%MatrixMarket matrix array integer symmetric\n2 2\n1\n2\n3\n";
        assert_eq!(rows(&parse(text).unwrap()), [[1.0, 2.0], [2.0, 3.0]]);
        let text = "%%MatrixMarket matrix array real skew-symmetric\n2 2\n2\n";
        assert_eq!(rows(&parse(text).unwrap()), [[0.0, -2.0], [2.0, 0.0]]);
    }

    #[test]
    fn coordinate_entries_add() {
        let text =
            "%%MatrixMarket MATRIX coordinate Real symmetric\n\n2 2 3\n1 1 1.5\n2 1 -1\n1 1 1D0\n";
        assert_eq!(rows(&parse(text).unwrap()), [[2.5, -1.0], [-1.0, 0.0]]);
    }

    #[test]
    fn faults_name_the_line() {
        let head = "%%MatrixMarket matrix coordinate real general\n";
        assert_eq!(message("").0, Some(1));
        assert_eq!(
            message("%%MatrixMarket matrix array complex general\n1 1\n1 0\n").1,
            "the matrix is complex, and a host's matrices are real"
        );
        assert!(
            message("%%MatrixMarket matrix coordinate pattern general\n1 1 1\n1 1\n")
                .1
                .contains("pattern")
        );
        assert_eq!(
            message(&format!("{head}2 2 1\n3 1 1\n")),
            (Some(3), "expected a row from 1 to 2, found `3`".to_owned())
        );
        assert_eq!(
            message(&format!("{head}2 2 1\n1 1 nan\n")),
            (Some(3), "expected a finite number, found `nan`".to_owned())
        );
        assert_eq!(
            message(&format!("{head}2 2 2\n1 1 1\n")).1,
            "line 2 announces 2 entries, but the file ends after 1"
        );
        assert_eq!(message(&format!("{head}99999999 2 0\n")).0, Some(2));
        assert_eq!(message(&format!("{head}2 2\n")).0, Some(2));
        assert!(
            message(&format!("{head}1 1 2\n1 1 1e308\n1 1 1e308\n"))
                .1
                .contains("add up")
        );
    }
}
