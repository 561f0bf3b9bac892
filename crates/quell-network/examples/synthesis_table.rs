//! The table of docs/synthesis.md: `cargo run -p quell-network --example synthesis_table`.
#![allow(clippy::print_stdout, dead_code, reason = "an example prints; a test includes it for its table")]

use std::fmt::Write as _;

use quell_network::{
    Form, Matching, POSITIVE_REAL_TOLERANCE, RationalFunction, Realisation, SynthesisError, bott_duffin, brune, canonical,
    foster_preamble, reduced_bott_duffin,
};

/// Name, coefficients of numerator and denominator (highest power first), source.
type Entry = (&'static str, &'static [f64], &'static [f64], &'static str);

const FUNCTIONS: &[Entry] = &[
    ("lossless, order 4", &[1.0, 0.0, 4.0, 0.0, 3.0], &[1.0, 0.0, 2.0, 0.0], "Foster 1924, form of"),
    ("lossless, order 5", &[1.0, 0.0, 10.0, 0.0, 9.0, 0.0], &[1.0, 0.0, 4.0, 0.0], "Cauer 1926, form of"),
    ("spring and damper", &[1.0, 6.0, 8.0], &[1.0, 4.0, 3.0], "Valkenburg 1960, form of"),
    ("damper and inerter", &[1.0, 4.0, 3.0], &[1.0, 6.0, 8.0], "Valkenburg 1960, form of"),
    ("bilinear", &[2.0, 3.0], &[1.0, 4.0], "Jiang and Smith 2011, form of"),
    ("regular", &[1.0, 2.0, 1.0], &[1.0, 1.0, 2.0], "Jiang and Smith 2011, form of"),
    ("minimum function", &[1.0, 1.0, 1.0], &[1.0, 1.0, 4.0], "Bott and Duffin 1949, form of"),
    ("its reciprocal", &[1.0, 1.0, 4.0], &[1.0, 1.0, 1.0], "Bott and Duffin 1949, form of"),
    ("not regular", &[1.0, 1.0, 1.0], &[1.0, 1.2, 4.0], "Jiang and Smith 2012, form of"),
    ("train suspension strut", &[0.0, 1.0, 1.0], &[1.0, 1.0, 0.0], "Wang, Liao and others 2009, form of"),
    ("TID", &[1.0, 2.0, 0.0], &[1.0, 1.0, 2.0], "Lazar, Neild and Wagg 2014"),
    ("bicubic", &[1.0, 3.0, 4.0, 2.0], &[1.0, 2.0, 3.0, 1.0], "Wang and Chen 2021, form of"),
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
pub fn table() -> String {
    let mut text = String::from(
        "| Y(s) | preamble leaves | Foster, Cauer | Brune | Bott-Duffin | reduced | smallest found |\n\
         | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    for (name, numerator, denominator, _) in FUNCTIONS {
        let Some(y) = function(numerator, denominator) else { continue };
        let verdict = y.positive_real(POSITIVE_REAL_TOLERANCE);
        let preamble = match foster_preamble(&y) {
            Ok(preamble) if preamble.minimum.is_some() => "a minimum function",
            Ok(_) => "nothing",
            Err(_) => "-",
        };
        let forms: Vec<String> = Form::ALL.iter().map(|form| cell(canonical(&y, *form))).collect();
        let forms = if forms.iter().all(|form| Some(form) == forms.first()) {
            forms.first().cloned().unwrap_or_default()
        } else {
            forms.join(", ")
        };
        let smallest = match Matching::default().smallest(&y) {
            Ok(found) => found.realisations.first().map_or_else(String::new, |first| {
                format!(
                    "{}: `{}`",
                    first.structure.elements(),
                    first.structure.to_string().replace('|', "\\|")
                )
            }),
            Err(_) => "more than 6".to_owned(),
        };
        let _ = writeln!(
            text,
            "| {name}: ({y}){} | {preamble} | {forms} | {} | {} | {} | {smallest} |",
            if verdict.is_positive_real() { "" } else { ", not positive-real" },
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
