//! Criteria of runs in time, and of other criteria, against the closed form of a ringing oscillator:
//! x(t) = exp(-σ t) sin ω t, whose extremes are at ω t = atan(ω/σ) + n π and are exp(-σ t) ω/√(σ² + ω²) high.
#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing)]

use std::f64::consts::PI;
use std::path::Path;

use quell_document::Source;
use quell_study::{Evaluated, Findings, RunSettings, Silent, Study, run};

const SIGMA: f64 = 0.2;
const OMEGA: f64 = 3.0;

/// Criteria of the run `ring`, as lines of a study, and a second run that begins elsewhere.
fn evaluated(criteria: &str) -> Evaluated {
    let text = format!(
        r#"
quell = 1
title = "Ringing"
host = "hosts/ringing.toml"
[devices]
[runs.ring]
kind = "transient"
duration = 12
start = {{ "x'" = "omega" }}
[runs.release]
kind = "transient"
duration = 12
start = {{ x = 2, "x'" = "-2*sigma" }}
[criteria]
{criteria}
[[tasks]]
name = "ring"
kind = "evaluate"
[tasks.configurations]
alone = {{}}
"#
    );
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let study = Study::parse(Source::new("ringing", text), &folder)
        .unwrap_or_else(|fault| panic!("{}", fault.render()));
    let mut outcome =
        run(&study, &RunSettings::default(), &Silent).unwrap_or_else(|error| panic!("{error}"));
    match outcome.tasks.remove(0).points.remove(0).findings {
        Findings::Evaluate(mut found) => found.remove(0),
        _ => panic!("it evaluates"),
    }
}

fn x(t: f64) -> f64 {
    (-SIGMA * t).exp() * (OMEGA * t).sin()
}

/// Time and height of the n-th extreme of |x|, from 0.
fn extreme(n: f64) -> (f64, f64) {
    let t = ((OMEGA / SIGMA).atan() + n * PI) / OMEGA;
    (t, x(t).abs())
}

/// Where |x| goes through a level between two times.
fn through(level: f64, mut a: f64, mut b: f64) -> f64 {
    let above = x(a).abs() > level;
    for _ in 0..80 {
        let middle = 0.5 * (a + b);
        if (x(middle).abs() > level) == above {
            a = middle;
        } else {
            b = middle;
        }
    }
    0.5 * (a + b)
}

/// Exact propagation is good to about 1e-13 of the largest state; crossings divide that by the slope there.
const EXACT: f64 = 1e-10;

fn close(found: &Evaluated, name: &str, expected: f64) {
    let value = found.criteria[name];
    let difference = (value - expected).abs();
    let status = &found.details[name].status;
    assert!(
        difference <= EXACT * expected.abs().max(1.0),
        "{name}: {value}, expected {expected} ({status})"
    );
}

#[test]
fn peaks_by_size_and_spans() {
    let (t1, top) = extreme(1.0);
    let (t2, second) = extreme(2.0);
    // A level that the third swing passes by 3 %: spans that want 5 % more end with the second.
    let level = second / 1.03;
    let found = evaluated(&format!(
        r#"
second = {{ run = "ring", value = "largest(abs(x), 2)" }}
lowest = {{ run = "ring", value = "largest(-abs(x), 1)" }}
span = {{ run = "ring", value = "span(abs(x), {level:e})" }}
tolerant = {{ run = "ring", value = "span(abs(x), {level:e}, 1.05)" }}
never = {{ run = "ring", value = "span(abs(x), 5)" }}
cut = {{ run = "ring", value = "span(abs(x), 1e-9)" }}
settled = {{ run = "ring", value = "settling(x, {level:e})" }}
settled_tolerant = {{ run = "ring", value = "settling(x, 0, {level:e}, 1.05)" }}
decay = {{ run = "ring", value = "decay_rate(abs(x))" }}
none = {{ run = "ring", value = "largest(abs(x), 1000)" }}
"#
    ));
    close(&found, "second", top);
    // Between zeros |x| has its minima, of no height.
    assert!(found.criteria["lowest"].abs() < 1e-12);
    let begins = through(level, 0.0, extreme(0.0).0);
    let last = through(level, t2, t2 + 0.5 * PI / OMEGA);
    let before = through(level, t1, t1 + 0.5 * PI / OMEGA);
    close(&found, "span", last - begins);
    close(&found, "tolerant", before - begins);
    close(&found, "never", 0.0);
    close(&found, "settled", last);
    close(&found, "settled_tolerant", before);
    close(&found, "decay", SIGMA);
    assert!(found.criteria["none"].is_nan());
    let status = |name: &str| found.details[name].status.as_str();
    assert!(status("none").contains("fewer peaks"), "{}", status("none"));
    assert!(status("span").contains("grazing"), "{}", status("span"));
    assert!(
        status("settled").contains("grazing"),
        "{}",
        status("settled")
    );
    assert!(status("cut").contains("not settled"), "{}", status("cut"));
    assert_eq!(status("never"), "computed");
}

#[test]
fn a_swing_below_the_level_is_remarked_too() {
    let (_, second) = extreme(2.0);
    let found = evaluated(&format!(
        r#"
below = {{ run = "ring", value = "span(abs(x), {:e})" }}
clear = {{ run = "ring", value = "span(abs(x), {:e})" }}
"#,
        second * 1.04,
        // Half-way between two swings, which differ by a factor of 1.23.
        second * 1.115
    ));
    let status = &found.details["below"].status;
    assert!(status.contains("a later swing"), "{status}");
    assert_eq!(found.details["clear"].status, "computed");
}

#[test]
fn criteria_of_criteria() {
    let found = evaluated(
        r#"
both = { value = "max(first/2, later) + 0*sum" }
first = { run = "ring", value = "max(abs(x))" }
later = { run = "release", value = "initial(x)" }
sum = { value = "0.25*first + 0.75*later + sigma" }
"#,
    );
    let (_, top) = extreme(0.0);
    close(&found, "first", top);
    close(&found, "later", 2.0);
    close(&found, "both", 2.0);
    close(&found, "sum", 0.25 * top + 1.5 + SIGMA);
}
