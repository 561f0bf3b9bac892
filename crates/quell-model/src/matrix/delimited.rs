//! Rows of numbers apart by commas, semicolons, tabs or blanks.

use csv::{ReaderBuilder, StringRecord, Trim};
use faer::Mat;

use super::{Complaint, number, size_is_sane};

/// Reads rows of numbers; the separator is that of the first row.
pub(super) fn parse(text: &str) -> Result<Mat<f64>, Complaint> {
    let first = text
        .lines()
        .find(|line| !line.trim().is_empty() && !line.starts_with('#'))
        .unwrap_or_default();
    let delimiter = [b';', b',', b'\t', b' ']
        .into_iter()
        .find(|&delimiter| first.trim().contains(char::from(delimiter)))
        .unwrap_or(b',');
    let mut reader = ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .delimiter(delimiter)
        .comment(Some(b'#'))
        .trim(Trim::All)
        .from_reader(text.as_bytes());
    let mut values: Vec<f64> = Vec::new();
    let mut rows = 0_usize;
    let mut columns = 0_usize;
    let mut record = StringRecord::new();
    loop {
        let more = reader
            .read_record(&mut record)
            .map_err(|error| Complaint::new(format!("the file cannot be read: {error}")))?;
        if !more {
            break;
        }
        let line = record
            .position()
            .map_or(0, |position| position.line() as usize);
        let mut width = 0_usize;
        for field in &record {
            // Blanks may stand several in a row.
            if delimiter == b' ' && field.is_empty() {
                continue;
            }
            if field.is_empty() {
                // A separator may end every row.
                if record.len() > 1 && width + 1 == record.len() && width > 0 {
                    continue;
                }
                return Err(Complaint::at(
                    line,
                    "expected a number, found an empty field",
                ));
            }
            values.push(number(field, line).map_err(|complaint| {
                if rows == 0 && complaint.help.is_none() {
                    complaint.help("a matrix has no row of headings; `#` starts a comment line")
                } else {
                    complaint
                }
            })?);
            width += 1;
        }
        if width == 0 {
            continue;
        }
        if rows == 0 {
            columns = width;
        } else if width != columns {
            return Err(Complaint::at(
                line,
                format!("expected {columns} numbers, as in the first row; found {width}"),
            ));
        }
        rows += 1;
        size_is_sane(rows, columns)?;
    }
    size_is_sane(rows, columns)?;
    Ok(Mat::from_fn(rows, columns, |row, column| {
        values[row * columns + column]
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separators_and_comments() {
        for text in [
            "# units: SI\n1,2\n3,4\n",
            "1; 2\n# between\n3; 4",
            "1\t2\n3\t4\n",
            "1   2\n 3 4\n\n",
            "1,2,\n3,4,\n",
        ] {
            let matrix = parse(text).unwrap();
            assert_eq!((matrix.nrows(), matrix.ncols()), (2, 2), "{text}");
            assert_eq!(matrix[(0, 1)], 2.0);
            assert_eq!(matrix[(1, 0)], 3.0);
        }
    }

    #[test]
    fn faults_name_the_line() {
        let complaint = |text| parse(text).unwrap_err();
        assert_eq!(complaint("1,2\n3\n").line, Some(2));
        assert_eq!(
            complaint("1,2\n3,inf\n").message,
            "expected a finite number, found `inf`"
        );
        assert_eq!(complaint("a,b\n1,2\n").line, Some(1));
        assert!(complaint("a,b\n1,2\n").help.is_some());
        assert_eq!(
            complaint("1;0,5\n2;3").help.as_deref(),
            Some("write a decimal point, not a decimal comma")
        );
        assert_eq!(
            complaint("1,,2\n").message,
            "expected a number, found an empty field"
        );
        assert!(complaint("# nothing\n").message.contains("empty"));
    }
}
