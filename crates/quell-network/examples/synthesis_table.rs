//! The table of docs/synthesis.md: `cargo run -p quell-network --example synthesis_table`.
#![allow(
    clippy::print_stdout,
    dead_code,
    reason = "an example prints; a test includes it for its table"
)]

use std::fmt::Write as _;

use quell_network::{
    Form, Matching, POSITIVE_REAL_TOLERANCE, RationalFunction, Realisation, SynthesisError,
    bott_duffin, brune, canonical, foster_preamble, reduced_bott_duffin,
};

/// Name, coefficients of numerator and denominator (highest power first), source.
type Entry = (&'static str, &'static [f64], &'static [f64], &'static str);

const FUNCTIONS: &[Entry] = &[
    (
        "lossless",
        &[2.0, 0.0, 20.0, 0.0, 18.0],
        &[1.0, 0.0, 4.0, 0.0],
        "Kuo 1966",
    ),
    (
        "lossless",
        &[2.0, 0.0, 12.0, 0.0, 16.0, 0.0],
        &[1.0, 0.0, 4.0, 0.0, 3.0],
        "Kuo 1966",
    ),
    (
        "spring and damper",
        &[1.0, 4.0, 3.0],
        &[1.0, 2.0, 0.0],
        "Van Valkenburg 1960",
    ),
    (
        "damper and inerter",
        &[2.0, 8.0, 6.0],
        &[1.0, 8.0, 12.0],
        "Kuo 1966",
    ),
    ("bilinear", &[2.0, 3.0], &[1.0, 4.0], "Jiang and Smith 2011"),
    (
        "canonical, U = V = 1, W = 1/4",
        &[1.0, 1.0, 0.25],
        &[1.0, 4.0, 4.0],
        "Jiang and Smith 2011",
    ),
    (
        "minimum function",
        &[1.0, 1.0, 1.0],
        &[1.0, 1.0, 4.0],
        "Van Valkenburg 1960",
    ),
    (
        "its reciprocal",
        &[1.0, 1.0, 4.0],
        &[1.0, 1.0, 1.0],
        "Van Valkenburg 1960",
    ),
    (
        "above a minimum function",
        &[1.0, 1.0, 1.0],
        &[1.0, 1.2, 4.0],
        "Jiang and Smith 2012",
    ),
    (
        "below a minimum function",
        &[1.0, 1.0, 1.0],
        &[1.0, 0.8, 4.0],
        "Jiang and Smith 2012",
    ),
    (
        "TVMD, k = c = b = 1",
        &[0.0, 1.0, 1.0],
        &[1.0, 1.0, 1.0],
        "Ikago, Saito and Inoue 2012",
    ),
    (
        "TID, k = c = b = 1",
        &[1.0, 1.0, 0.0],
        &[1.0, 1.0, 1.0],
        "Lazar, Neild and Wagg 2014",
    ),
    (
        "`b1 \\| c1 + (k1 \\| c2)`, values 1, 2, 1, 1",
        &[3.0, 3.0, 2.0],
        &[3.0, 1.0],
        "Li, Jiang and Neild 2017",
    ),
    (
        "bicubic",
        &[1.0, 3.0, 4.0, 2.0],
        &[1.0, 2.0, 3.0, 1.0],
        "Wang and Chen 2021",
    ),
];

fn function(numerator: &[f64], denominator: &[f64]) -> Option<RationalFunction> {
    let reversed = |c: &[f64]| c.iter().rev().copied().collect::<Vec<f64>>();
    RationalFunction::new(reversed(numerator), reversed(denominator)).ok()
}

fn cell(found: Result<Realisation, SynthesisError>) -> String {
    match found {
        Ok(found) => found.structure.elements().to_string(),
        Err(SynthesisError::NotTwoKinds | SynthesisError::NotFound(_)) => "-".to_owned(),
        Err(SynthesisError::NotPositiveReal(_)) => "not positive-real".to_owned(),
        Err(error) => error.to_string(),
    }
}

/// The table in Markdown.
pub(crate) fn table() -> String {
    let mut text = String::from(
        "| Y(s) | form after | preamble leaves | Foster, Cauer | Brune | Bott-Duffin | reduced | smallest found |\n\
         | --- | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    for (name, numerator, denominator, source) in FUNCTIONS {
        let Some(y) = function(numerator, denominator) else {
            continue;
        };
        let verdict = y.positive_real(POSITIVE_REAL_TOLERANCE);
        let preamble = match foster_preamble(&y) {
            Ok(preamble) if preamble.minimum.is_some() => "a minimum function",
            Ok(_) => "nothing",
            Err(_) => "-",
        };
        let forms: Vec<String> = Form::ALL
            .iter()
            .map(|form| cell(canonical(&y, *form)))
            .collect();
        let forms = if forms.iter().all(|form| Some(form) == forms.first()) {
            forms.first().cloned().unwrap_or_default()
        } else {
            forms.join(", ")
        };
        let smallest = match Matching::default().smallest(&y) {
            Ok(found) => found
                .realisations
                .first()
                .map_or_else(String::new, |first| {
                    format!(
                        "{}: `{}`",
                        first.structure.elements(),
                        first.structure.to_string().replace('|', "\\|")
                    )
                }),
            Err(SynthesisError::NotFound(most)) => format!("more than {most}"),
            Err(_) => "-".to_owned(),
        };
        let _ = writeln!(
            text,
            "| {name}: {y}{} | {source} | {preamble} | {forms} | {} | {} | {} | {smallest} |",
            if verdict.is_positive_real() {
                ""
            } else {
                ", not positive-real"
            },
            cell(brune(&y)),
            cell(bott_duffin(&y)),
            cell(reduced_bott_duffin(&y)),
        );
    }
    text
}

fn main() {
    print!("{}", table());
}
