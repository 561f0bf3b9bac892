//! Sweeps over bounds, fronts, effort and honesty of design tasks, against closed forms.
//!
//! The isolator of D. Karnopp and A. Trikha (1969): a mass on a spring and a damper over a base with white acceleration.
//! With omega^2 = k/m and zeta = c/(2 m omega), the H2 norms (two-sided, over 2 pi) squared are
//! J1 = 1/(4 zeta omega^3) for the relative displacement and J2 = omega (1 + 4 zeta^2)/(4 zeta) for the absolute
//! acceleration. For a given J1 the least J2 has zeta = 1/sqrt(2), hence J1 J2^3 = 27/64 along the front.
#![allow(missing_docs, reason = "a test binary")]
#![expect(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test whose study is wrong has failed"
)]

use std::fs;

use quell_study::{
    Design, Findings, FrontFindings, RunOutcome, RunSettings, Silent, Study, check, run,
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
base = { kind = "acceleration" }

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

[runs.shake]
kind = "frequency"
input = "base"

[criteria]
travel = { run = "shake", value = "h2(stroke(strut))" }
shock = { run = "shake", value = "h2(x'')" }
"#;

/// Runs the study with a task added.
fn found(task: &str) -> RunOutcome {
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
    run(&study, &RunSettings::default(), &Silent)
        .unwrap_or_else(|error| panic!("{}", error.fault().render()))
}

fn designs(outcome: &RunOutcome) -> &[Design] {
    match &outcome.tasks[0].points[0].findings {
        Findings::Design(findings) => &findings.designs,
        other => panic!("{other:?}"),
    }
}

fn front(outcome: &RunOutcome) -> &FrontFindings {
    match &outcome.tasks[0].points[0].findings {
        Findings::Front(findings) => findings,
        other => panic!("{other:?}"),
    }
}

/// Squares of both norms.
fn squares(design: &Design) -> (f64, f64) {
    let norm = |name: &str| design.configuration.criteria[name];
    (norm("travel").powi(2), norm("shock").powi(2))
}

/// The least J2 for a J1 with omega between 1 and 10 and any damping.
fn least(j1: f64) -> f64 {
    let free = (1.0 / (4.0 * 0.5_f64.sqrt() * j1)).cbrt();
    let omega = free.clamp(1.0, 10.0);
    let zeta = 1.0 / (4.0 * j1 * omega.powi(3));
    omega * (1.0 + 4.0 * zeta * zeta) / (4.0 * zeta)
}

const WIDE: &str = r#"bounds = { k1 = ["1 N/m", "100 N/m"], c1 = ["0.1 N*s/m", "30 N*s/m"] }"#;

#[test]
fn sweeping_a_bound_follows_the_closed_form() {
    let outcome = found(&format!(
        r#"
kind = "design"
minimise = "shock"
subject_to = ["travel <= 1"]
candidates.strut = ["k1 | c1"]
{WIDE}
starts = 4
sweep = {{ travel = {{ from = 0.05, to = 0.4, points = 3, scale = "log" }} }}
"#
    ));
    let points = &outcome.tasks[0].points;
    let bounds: Vec<f64> = points.iter().map(|point| point.at[0].value).collect();
    assert_eq!((bounds[0], bounds[2]), (0.05, 0.4));
    assert!((bounds[1] - 0.02_f64.sqrt()).abs() < 1e-12);
    for (point, bound) in points.iter().zip(bounds) {
        assert_eq!(point.at[0].name, "travel");
        let Findings::Design(findings) = &point.findings else {
            panic!("{point:?}");
        };
        assert_eq!(findings.constraints, ["travel ≤ swept bound"]);
        let best = &findings.designs[0];
        assert!(best.feasible);
        let (j1, j2) = squares(best);
        // The constraint is active; feasibility is 1e-6 relative.
        assert!((j1.sqrt() / bound - 1.0).abs() < 1e-4, "{j1} {bound}");
        // Searches agree within 1e-4 of the norm, twice that of its square.
        assert!((j2 / least(bound * bound) - 1.0).abs() < 4e-4, "{j2}");
    }
}

#[test]
fn the_front_of_an_isolator_is_the_closed_one() {
    // The spring alone rings for ever: both of its norms are infinite, and it is nowhere on the front.
    let outcome = found(&format!(
        r#"
kind = "design"
minimise = ["travel", "shock"]
candidates.strut = ["k1 | c1", "k1 + c1"]
{WIDE}
starts = 3
front_points = 7
"#
    ));
    let front = front(&outcome);
    assert_eq!(front.objectives.len(), 2);
    let common = front.common();
    // Seven of them belong to the layout with the spring beside the damper.
    assert!(common.len() >= 7, "{}", common.len());
    for (index, (layout, point)) in common.iter().enumerate() {
        assert_eq!(point.rank, Some(index + 1));
        assert_eq!(point.design.rank, index + 1);
        if layout.layout == "k1 | c1" {
            let (j1, j2) = squares(&point.design);
            assert!(
                (j2 / least(j1) - 1.0).abs() < 1e-3,
                "{j1} {j2} {}",
                least(j1)
            );
        }
    }
    for pair in common.windows(2) {
        let (a, b) = (squares(&pair[0].1.design), squares(&pair[1].1.design));
        assert!(a.0 < b.0 && a.1 > b.1, "{a:?} {b:?}");
    }
    // Ends: the least travel at both upper bounds, the least shock at the softest spring with zeta = 1/2.
    let own = &front.layouts[0].points;
    let first = squares(&own[0].design);
    assert!((first.0 * 4.0 * 1.5 * 1e3 - 1.0).abs() < 1e-3, "{first:?}");
    let last = squares(&own[own.len() - 1].design);
    assert!((last.1 - 1.0).abs() < 1e-3, "{last:?}");
    let json = serde_json::to_value(&outcome.results).unwrap();
    let task = &json["tasks"]["task"];
    assert_eq!(task["objectives"][1]["criterion"], "shock");
    assert_eq!(task["fronts"][0]["layout"], "k1 | c1");
    assert!(
        task["method"]
            .as_str()
            .unwrap()
            .starts_with("epsilon-constraint")
    );
    assert_eq!(
        task["fronts"][0]["points"].as_array().unwrap().len(),
        own.len()
    );
}

#[test]
fn senses_may_be_mixed() {
    // Stiffness is no criterion of its own, but the slowest mode is: the faster, the less travel.
    let folder = tempdir().unwrap();
    fs::write(folder.path().join("host.toml"), HOST).unwrap();
    let path = folder.path().join("study.toml");
    let text = STUDY
        .replace("[criteria]", "[runs.free]\nkind = \"modes\"\n\n[criteria]\nspeed = { run = \"free\", value = \"min(decay_rate)\" }")
        + &format!(
            r#"
[[tasks]]
name = "task"
kind = "design"
minimise = "shock"
maximise = "speed"
candidates.strut = ["k1 | c1"]
{WIDE}
starts = 3
front_points = 5
"#
        );
    fs::write(&path, text).unwrap();
    let study = Study::read(&path).unwrap_or_else(|fault| panic!("{}", fault.render()));
    let outcome = run(&study, &RunSettings::default(), &Silent).unwrap();
    let front = front(&outcome);
    let common = front.common();
    assert!(common.len() >= 4, "{}", common.len());
    for pair in common.windows(2) {
        let value = |index: usize, name: &str| pair[index].1.design.configuration.criteria[name];
        assert!(value(0, "shock") < value(1, "shock"));
        assert!(value(0, "speed") < value(1, "speed"));
    }
    for (_, point) in &common {
        // With m = 1, J2 = k/(2 c) + c/2. A decay rate d asks for c >= 2 d and, where the poles are real, for
        // k >= d (c - d), so the least J2 is at the double pole, c = 2 d and k = d^2: J2 = d/4 + d.
        let d = point.design.configuration.criteria["speed"];
        let j2 = point.design.configuration.criteria["shock"].powi(2);
        if d > 1.001 {
            assert!((j2 / (1.25 * d) - 1.0).abs() < 2e-3, "{d} {j2}");
        }
    }
}

#[test]
fn starts_are_added_until_enough_agree() {
    let task = |more: &str| {
        found(&format!(
            r#"
kind = "design"
minimise = "shock"
candidates.strut = ["k1 | c1"]
{WIDE}
starts = 1
{more}
"#
        ))
    };
    let alone = task("");
    assert_eq!(designs(&alone)[0].starts, 1);
    let agreed = task("agree = 3");
    let best = &designs(&agreed)[0];
    assert!(best.starts >= 3 && best.starts_agreeing >= 3);
    assert_eq!(best.status, "starts agree");
    // Where nothing can agree, the effort ends where it is said to.
    let never =
        task("agree = 3\nmost_starts = 5\nsubject_to = [\"travel <= 1e-4\", \"shock <= 100\"]");
    let worst = &designs(&never)[0];
    assert!(!worst.feasible);
    assert_eq!((worst.starts, worst.starts_agreeing), (5, 0));
    assert!(worst.status.starts_with("infeasible"));
    // J1 is 1/(4*1.5*1000) at the least, so the bound of 1e-4 is missed by 1.29e-2/1e-4 - 1 at the least.
    let least = (1.0_f64 / 6000.0).sqrt() / 1e-4 - 1.0;
    assert!(
        (worst.violations["travel ≤ 0.0001"] / least - 1.0).abs() < 1e-3,
        "{worst:?}"
    );
    assert_eq!(worst.violations["shock ≤ 100"], 0.0);
    assert_eq!(worst.remarks.len(), 1);
    assert!(
        worst.remarks[0].contains("`shock ≤ 100` holds"),
        "{:?}",
        worst.remarks
    );
    assert!(
        worst.remarks[0].contains("`travel ≤ 0.0001` is missed by 12810 %"),
        "{:?}",
        worst.remarks
    );
}

#[test]
fn what_hardly_matters_and_what_lies_behind_a_bound_is_said() {
    // A damper beside one a million times larger.
    let flat = found(
        r#"
kind = "design"
minimise = "shock"
candidates.strut = ["k1 | c1 | (k2 + c2)"]
fixed = { k1 = "1 N/m" }
bounds = { c1 = ["0.1 N*s/m", "30 N*s/m"], k2 = ["1e-9 N/m", "1e-8 N/m"], c2 = ["0.01 N*s/m", "1 N*s/m"] }
starts = 3
"#,
    );
    let remarks = &designs(&flat)[0].remarks;
    let about = |name: &str| {
        let lead = format!("`{name}`");
        remarks.iter().find(|remark| remark.starts_with(&lead))
    };
    assert!(about("c1").is_none(), "{remarks:?}");
    let said = about("k2").unwrap();
    assert!(said.contains("anywhere between its bounds"), "{said}");
    assert!(said.contains("`k1 | c1`"), "{said}");
    assert!(about("c2").unwrap().contains("anywhere between its bounds"));

    // At k = 1 the least shock has zeta = 1/2, c = 1; from 5 on, less is better, and none at all is another layout.
    let bound = found(
        r#"
kind = "design"
minimise = "shock"
candidates.strut = ["k1 | c1"]
fixed = { k1 = "1 N/m" }
bounds = { c1 = ["5 N*s/m", "30 N*s/m"] }
starts = 2
"#,
    );
    let best = &designs(&bound)[0];
    assert_eq!(best.active_bounds, ["c1 = lower"]);
    assert_eq!(
        best.remarks,
        [
            "`c1` runs to its lower bound, 5 N*s/m: behind it lies another layout, `k1` (no force through it)"
        ]
    );
}
