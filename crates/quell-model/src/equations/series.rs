//! Files of samples in time: two columns.

use std::path::Path;

use csv::{ReaderBuilder, StringRecord, Trim};

/// What is wrong with a file of samples, and what to do about it.
pub(super) struct Complaint {
    pub message: String,
    pub help: Option<String>,
}

/// Times and values of a file; a first line of titles is passed over.
pub(super) fn read(path: &Path) -> Result<(Vec<f64>, Vec<f64>), Complaint> {
    let name = path.display();
    let text = std::fs::read_to_string(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => Complaint {
            message: format!("there is no file `{name}`"),
            help: Some("a path is relative to the file that names it".to_owned()),
        },
        _ => Complaint {
            message: format!("the file `{name}` cannot be read: {error}"),
            help: None,
        },
    })?;
    parse(&text).map_err(|(line, message)| Complaint {
        message: format!("line {line} of `{name}`: {message}"),
        help: Some("expected two columns, time and value, with decimal points".to_owned()),
    })
}

fn parse(text: &str) -> Result<(Vec<f64>, Vec<f64>), (u64, String)> {
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
    let (mut times, mut values) = (Vec::new(), Vec::new());
    let mut record = StringRecord::new();
    let mut titles = true;
    loop {
        let more = reader
            .read_record(&mut record)
            .map_err(|error| (0, format!("{error}")))?;
        if !more {
            return Ok((times, values));
        }
        let line = record.position().map_or(0, csv::Position::line);
        // Blanks may stand several in a row, a separator may end a row.
        let fields: Vec<&str> = record.iter().filter(|field| !field.is_empty()).collect();
        let first = std::mem::take(&mut titles);
        let [time, value] = fields[..] else {
            return Err((line, format!("found {} columns", fields.len())));
        };
        match (number(time), number(value)) {
            (Some(time), Some(value)) => {
                times.push(time);
                values.push(value);
            }
            _ if first && number(time).is_none() && number(value).is_none() => {}
            (None, _) => return Err((line, format!("`{time}` is not a finite number"))),
            (_, None) => return Err((line, format!("`{value}` is not a finite number"))),
        }
    }
}

fn number(text: &str) -> Option<f64> {
    text.parse().ok().filter(|number: &f64| number.is_finite())
}

#[cfg(test)]
mod tests {
    use super::parse;

    #[test]
    fn separators_titles_and_comments_are_read() {
        for text in [
            "t,x\n0,1\n0.5,2\n",
            "# measured\n0;1\n0.5;2",
            "0\t1\n0.5\t2\n",
            "time  value\n 0   1\n 0.5 2\n",
        ] {
            assert_eq!(parse(text), Ok((vec![0.0, 0.5], vec![1.0, 2.0])), "{text}");
        }
    }

    #[test]
    fn faults_name_the_line() {
        assert_eq!(parse("0,1\n1\n"), Err((2, "found 1 columns".to_owned())));
        assert_eq!(
            parse("0,1\n1,x\n"),
            Err((2, "`x` is not a finite number".to_owned()))
        );
        assert_eq!(parse("0,nan\n").unwrap_err().0, 1);
    }
}
