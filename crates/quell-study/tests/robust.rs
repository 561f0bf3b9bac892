//! Criteria over several host parameters and over tolerances of values, against closed forms: a mass m on a spring k and a
//! damper c has the damping ratio zeta = c/(2 sqrt(k m)) and, over a base that moves by u, the transmissibility
//! |x/u|^2 = (k^2 + c^2 w^2)/((k - m w^2)^2 + c^2 w^2) (J. P. Den Hartog, Mechanical Vibrations, 1956, section 2.12).
#![allow(missing_docs, reason = "a test binary")]
#![expect(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test whose study is wrong has failed"
)]

use std::fs;

use quell_search::{Pieces, Problem};
use quell_study::{
    Evaluated, Findings, RunOutcome, RunSettings, Silent, Study, check, problems, run,
};
use tempfile::tempdir;

const HOST: &str = r#"
quell = 1
title = "A mass over a shaking base"

[parameters]
m = "1 kg"

[coordinates]
x = { mass = "m" }

[inputs]
base = { kind = "displacement" }

[linear]
springs = []

[ports.mount]
between = ["x", "base"]
"#;

const STUDY: &str = r#"
quell = 1
title = "An isolator"
host = "host.toml"

[devices.strut]
port = "mount"

[runs.free]
kind = "modes"

[runs.shake]
kind = "frequency"
input = "base"
band = ["0 Hz", "5 Hz"]

[criteria]
zeta = { run = "free", value = "min(damping_ratio)" }
zeta_loads = { value = "zeta", over = { m = ["1 kg", "2 kg", "4 kg"] }, take = "smallest" }
zeta_made = { run = "free", value = "min(damping_ratio)", tolerances = { k = "10 %", c1 = "20 %" }, take = "smallest" }
zeta_both = { value = "zeta", over = { m = ["1 kg", "4 kg"] }, tolerances = "10 %", take = "smallest" }
zeta_mean = { value = "zeta", over = { m = ["1 kg", "4 kg"] }, take = "mean" }
zeta_spread = { value = "zeta", over = { m = ["1 kg", "4 kg"] }, take = "spread" }
peak = { run = "shake", value = "max(abs(x))" }
peak_made = { value = "peak", tolerances = "10 %" }
peak_anywhere = { value = "peak", over = { m = ["1 kg", "2 kg"] }, tolerances = { k = "20 %", c = "10 %" } }
tone = { run = "shake", value = "abs(x, 10 rad/s)" }
tone_made = { value = "tone", tolerances = { k = "30 %" } }
"#;

fn study(task: &str, read: impl FnOnce(&Study)) {
    let folder = tempdir().unwrap();
    fs::write(folder.path().join("host.toml"), HOST).unwrap();
    let path = folder.path().join("study.toml");
    fs::write(
        &path,
        format!("{STUDY}\n[[tasks]]\nname = \"task\"\n{task}"),
    )
    .unwrap();
    let study = Study::read(&path).unwrap_or_else(|fault| panic!("{}", fault.render()));
    check(&study).unwrap_or_else(|fault| panic!("{}", fault.render()));
    read(&study);
}

fn found(task: &str) -> RunOutcome {
    let mut outcome = None;
    study(task, |study| {
        let found = run(study, &RunSettings::default(), &Silent);
        outcome = Some(found.unwrap_or_else(|error| panic!("{}", error.fault().render())));
    });
    outcome.unwrap()
}

fn evaluated(k: f64, c: f64) -> Evaluated {
    let outcome = found(&format!(
        r#"
kind = "evaluate"
[tasks.configurations]
one = {{ strut = "k1 | c1", k1 = "{k} N/m", c1 = "{c} N*s/m" }}
"#
    ));
    match &outcome.tasks[0].points[0].findings {
        Findings::Evaluate(all) => all[0].clone(),
        other => panic!("{other:?}"),
    }
}

fn zeta(m: f64, k: f64, c: f64) -> f64 {
    c / (2.0 * (k * m).sqrt())
}

fn transmissibility(m: f64, k: f64, c: f64, w: f64) -> f64 {
    ((k * k + c * c * w * w) / ((k - m * w * w).powi(2) + c * c * w * w)).sqrt()
}

fn close(one: f64, other: f64, tolerance: f64) {
    assert!(
        (one - other).abs() <= tolerance * other.abs(),
        "{one} is not {other}"
    );
}

/// Damping ratios come from eigenvalues, exact to rounding.
#[test]
fn worst_mean_and_spread_are_those_of_the_closed_form() {
    let one = evaluated(100.0, 4.0);
    let of = |name: &str| one.criteria[name];
    close(of("zeta"), zeta(1.0, 100.0, 4.0), 1e-12);
    close(of("zeta_loads"), zeta(4.0, 100.0, 4.0), 1e-12);
    close(of("zeta_made"), zeta(1.0, 110.0, 3.2), 1e-12);
    close(of("zeta_both"), zeta(4.0, 110.0, 3.6), 1e-12);
    close(of("zeta_mean"), 0.75 * zeta(1.0, 100.0, 4.0), 1e-12);
    close(of("zeta_spread"), 0.5 * zeta(1.0, 100.0, 4.0), 1e-12);
    let taken = |name: &str| one.details[name].taken.clone().unwrap();
    assert_eq!(taken("zeta_loads"), "smallest of 3 points, at m = 4 kg");
    assert_eq!(
        taken("zeta_both"),
        "smallest of 42 points, at m = 4 kg, k1 +10 %, c1 -10 %"
    );
    assert_eq!(taken("zeta_mean"), "mean of 2 points");
    assert!(one.details["zeta"].taken.is_none());
}

/// The response at 10 rad/s is largest where the spring makes the mass resonate there, which is no corner.
#[test]
fn the_largest_between_corners_is_found_and_said() {
    let one = evaluated(110.0, 0.5);
    let corners = [0.7, 1.0, 1.3].map(|factor| transmissibility(1.0, factor * 110.0, 0.5, 10.0));
    let corner = corners.into_iter().fold(0.0, f64::max);
    let highest = (0..=6000)
        .map(|step| transmissibility(1.0, 77.0 + 0.011 * f64::from(step), 0.5, 10.0))
        .fold(0.0, f64::max);
    let value = one.criteria["tone_made"];
    assert!(
        value > 1.5 * corner && value <= highest,
        "{corner} {value} {highest}"
    );
    let taken = one.details["tone_made"].taken.clone().unwrap();
    assert!(taken.contains("between the corners"), "{taken}");
}

/// A bound on the worst damping ratio is met by the worst load as the parts may be made.
#[test]
fn a_design_holds_its_bound_at_the_worst_point() {
    let outcome = found(
        r#"
kind = "design"
minimise = "peak"
subject_to = ["zeta_both >= 0.2", "zeta <= 1"]
candidates.strut = ["k1 | c1"]
fixed = { k1 = "100 N/m" }
bounds = { c1 = ["0.1 N*s/m", "100 N*s/m"] }
"#,
    );
    let Findings::Design(findings) = &outcome.tasks[0].points[0].findings else {
        panic!("no design");
    };
    let best = &findings.designs[0].configuration;
    // More damping always lowers the peak, so that the upper bound binds.
    close(best.criteria["zeta"], 1.0, 1e-4);
    assert!(best.criteria["zeta_both"] >= 0.2);
    let outcome = found(
        r#"
kind = "design"
minimise = "tone"
subject_to = ["zeta_both >= 0.2"]
candidates.strut = ["k1 | c1"]
fixed = { k1 = "20 N/m" }
bounds = { c1 = ["0.1 N*s/m", "100 N*s/m"] }
"#,
    );
    let Findings::Design(findings) = &outcome.tasks[0].points[0].findings else {
        panic!("no design");
    };
    let best = &findings.designs[0].configuration;
    // Far above resonance damping only harms, so that the bound binds at m = 4 kg, k + 10 %, c - 10 %.
    let c = 0.2 * 2.0 * (22.0_f64 * 4.0).sqrt() / 0.9;
    close(best.devices[0].elements[1].value, c, 1e-3);
}

/// Value and gradient of every piece against central differences of the criterion itself.
#[test]
fn pieces_are_those_of_the_worst_points() {
    let task = r#"
kind = "design"
minimise = "peak_anywhere"
candidates.strut = ["k1 | c1"]
bounds = { k1 = ["10 N/m", "1000 N/m"], c1 = ["0.1 N*s/m", "100 N*s/m"] }
"#;
    study(task, |study| {
        let (_, problem) = problems(study, "task").unwrap().remove(0);
        let mut scratch = problem.scratch();
        let mut pieces = Pieces::new(2);
        let point = [120.0, 3.0];
        assert!(problem.pieces(&point, 1e-3, &mut pieces, &mut scratch));
        let mut value = |x: &[f64]| problem.evaluate(x, &mut [], &mut scratch);
        let here = value(&point);
        // Heaviest mass, stiffest spring, weakest damper: peak of the least damped one.
        let (value_of, gradient) = pieces
            .iter_objectives()
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .unwrap();
        close(value_of, here, 1e-6);
        for (index, slope) in gradient.iter().enumerate() {
            let h = 1e-4 * point[index];
            let [plus, minus] = [h, -h].map(|h| {
                let mut moved = point;
                moved[index] += h;
                value(&moved)
            });
            // Peaks of the search are refined to about 1e-9 of their value.
            let difference = (plus - minus) / (2.0 * h);
            assert!(
                (slope - difference).abs() <= 1e-4 * here / point[index],
                "{index}: {slope} {difference}"
            );
        }
    });
}
