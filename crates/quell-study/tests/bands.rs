//! Stable bands of the gallery against figures that are known otherwise.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a failed test ends by panic"
)]

mod support;

use quell_document::Source;
use quell_study::Study;
use quell_study::results::{ConfigurationResult, Results, TaskBody, TaskFindings};
use support::gallery;

fn run(study: &Study, tasks: &[&str]) -> Results {
    support::run(study, 2, tasks)
}

fn configuration<'a>(results: &'a Results, task: &str) -> &'a ConfigurationResult {
    match &results.tasks[task].body {
        TaskBody::Single(TaskFindings::Evaluate { configurations }) => &configurations[task],
        other => panic!("{task}: {other:?}"),
    }
}

/// Y. Li's doctoral thesis on the optimal design of passive vibration suppressors with inerters, chapter 5, recomputed with AUTO-07p:
/// extrema of Hopf curves over speed. Tolerances: those of the recomputation, 0.1 of cd (0.2 and 20 where it had digits for no
/// more).
#[test]
fn bands_of_the_landing_gear() {
    let study = gallery("zero-shimmy.toml");
    let results = run(&study, &["L1", "L2", "LI1", "LI2"]);
    let expected = [
        ("L1", 2754.35, 3018.98, 0.1),
        ("L2", 3813.91, 14032.51, 0.1),
        ("LI1", 2319.48, 13562.68, 0.2),
        ("LI2", 3060.6, 22148.1, 20.0),
    ];
    for (task, lower, upper, tolerance) in expected {
        let found = configuration(&results, task);
        let detail = &found.details["band"];
        let widest = detail
            .bands
            .iter()
            .max_by(|a, b| (a.upper - a.lower).total_cmp(&(b.upper - b.lower)))
            .unwrap_or_else(|| panic!("{task}: {detail:?}"));
        assert!(
            (widest.lower - lower).abs() < tolerance,
            "{task}: {detail:?}"
        );
        assert!(
            (widest.upper - upper).abs() < tolerance,
            "{task}: {detail:?}"
        );
        assert_eq!(
            found.criteria["band"].to_bits(),
            (widest.upper - widest.lower).to_bits()
        );
        println!("{task}: {detail:#?}");
    }
    let l1 = &configuration(&results, "L1").details["band"].bands[0];
    assert!((l1.lower_at.unwrap() - 10.79).abs() < 0.01, "{l1:?}");
    assert!((l1.upper_at.unwrap() - 36.05).abs() < 0.01, "{l1:?}");
    let l2 = &configuration(&results, "L2").details["band"].bands[0];
    assert!((l2.lower_at.unwrap() - 11.63).abs() < 0.01, "{l2:?}");
    assert!((l2.upper_at.unwrap() - 18.15).abs() < 0.01, "{l2:?}");
}

/// The widths that the thesis gives for its best devices: the design must not be narrower. Printed: how long it took and how many
/// evaluations.
#[test]
fn designs_are_at_least_as_wide() {
    let study = gallery("zero-shimmy.toml");
    for (task, width) in [
        ("design L2", 14032.51 - 3813.91),
        ("design LI1", 11243.2),
        ("design LI2", 19087.0),
    ] {
        let began = std::time::Instant::now();
        let results = run(&study, &[task]);
        let TaskBody::Single(TaskFindings::Design { designs, .. }) = &results.tasks[task].body
        else {
            panic!("{task}");
        };
        let best = &designs[0];
        println!("{task}: {:.2} s {best:#?}", began.elapsed().as_secs_f64());
        assert!(best.objective >= width, "{task}: {}", best.objective);
        assert!(!best.details["band"].bands.is_empty());
    }
}

/// Typical section with unsteady aerodynamics: AUTO-07p (EPSL = EPSU = 1e-9) has the subcritical Hopf point at U = 17.957264996 and
/// the fold of its cycles at U = 14.660123947; beyond the fold a stable cycle coexists with rest. Tolerance of special points there:
/// 1e-6 relative.
#[test]
fn stable_cycles_end_a_band() {
    const FOLD: f64 = 14.660_123_947;
    let study = gallery("aeroelastic-section.toml");
    let results = run(&study, &["free speeds"]);
    let TaskBody::Single(TaskFindings::Evaluate { configurations }) =
        &results.tasks["free speeds"].body
    else {
        panic!("no evaluation");
    };
    let found = &configurations["section"];
    println!("{:#?}", found.details);
    let band = &found.details["free"].bands[0];
    assert!((band.upper / FOLD - 1.0).abs() < 1e-6, "{band:#?}");
    assert!(band.limited_by[1].contains("fold of cycles"), "{band:#?}");
    assert_eq!(band.lower, 4.0);
    assert_eq!(found.criteria["free"].to_bits(), band.upper.to_bits());
    // Two ways to one point: with the damping at which the curve of folds reaches 20 m/s, the band of speeds ends there. The
    // extremum of the curve lies at the end of its range, where it is met to the tolerance of the corrector.
    let damping = found.details["damping"].bands[0].lower;
    assert!(damping > 0.5628, "{:#?}", found.details["damping"]);
    let mut text = study.source.text.clone();
    text.insert_str(
        text.find("[criteria.free]").unwrap(),
        &format!("[parameters]\nc_a = {damping:.12}\n\n"),
    );
    let source = Source::new("again.toml".to_owned(), text);
    let again = Study::parse(source, &study.folder).unwrap();
    let results = run(&again, &["free speeds"]);
    let TaskBody::Single(TaskFindings::Evaluate { configurations }) =
        &results.tasks["free speeds"].body
    else {
        panic!("no evaluation");
    };
    let speed = configurations["section"].criteria["free"];
    assert!((speed / 20.0 - 1.0).abs() < 1e-6, "{speed} at {damping}");
}

/// r' = r (p - h(q) + 2 c(q) r² - r⁴), θ' = 1: rest is stable below p = h(q), and below the fold p = h(q) - c(q)² alone. With h = cosh q - 1,
/// c = 1 + 0.3 q the fold's curve is lowest where sinh q = 0.6 (1 + 0.3 q). Tolerance: cycles are meshed to 1e-8, and the extremum of
/// the curve is found to the third order of a hundredth of a step.
#[test]
fn a_band_ends_at_the_extremum_of_a_curve_of_folds_of_cycles() {
    let study = support::written(
        r#"
quell = 1
title = "Quiet whatever q is"
host = "folds.toml"

[criteria.quiet]
kind = "stable band"
of = "p"
range = [-3, 1]
over = { q = [-1, 1.5] }
value = "upper"

[[tasks]]
name = "band"
kind = "evaluate"
[tasks.configurations]
alone = {}
"#,
    );
    let results = run(&study, &["band"]);
    let TaskBody::Single(TaskFindings::Evaluate { configurations }) = &results.tasks["band"].body
    else {
        panic!("no evaluation");
    };
    let band = &configurations["alone"].details["quiet"].bands[0];
    let mut q = 0.5_f64;
    for _ in 0..50 {
        q -= (q.sinh() - 0.6 * (1.0 + 0.3 * q)) / (q.cosh() - 0.18);
    }
    let p = q.cosh() - 1.0 - (1.0 + 0.3 * q).powi(2);
    assert!((band.upper - p).abs() < 1e-7, "{band:#?} for {p} at {q}");
    assert!((band.upper_at.unwrap() - q).abs() < 1e-3, "{band:#?}");
    assert!(band.limited_by[1].contains("fold of cycles"), "{band:#?}");
}

/// The same source: bending splits the band at ks = 7.865e5 N m/rad, and it closes at 4.7371e5.
#[test]
fn events_of_a_sweep_are_located() {
    let study = gallery("zero-shimmy.toml");
    let results = run(&study, &["L2 over ks"]);
    let events = &results.tasks["L2 over ks"].events;
    println!("{events:#?}");
    let of = |what: &str| -> Vec<f64> {
        let own = events.iter().filter(|event| event.what == what);
        own.map(|event| event.value).collect()
    };
    let (opened, born) = (of("band opened"), of("island born"));
    assert_eq!((opened.len(), born.len()), (1, 1), "{events:#?}");
    assert!((opened[0] - 4.7371e5).abs() < 50.0, "{events:#?}");
    assert!((born[0] - 7.865e5).abs() < 200.0, "{events:#?}");
}

/// The same source: widths with the best spring of each inerter. Tolerance 5 of the source's grid of springs.
#[test]
fn best_springs_over_inerters() {
    let study = gallery("zero-shimmy.toml");
    let results = run(&study, &["LI1 over b"]);
    let TaskBody::Sweep { points } = &results.tasks["LI1 over b"].body else {
        panic!("no sweep");
    };
    for (point, width) in points.iter().zip([10976.0, 11172.0, 11243.0, 10680.0]) {
        let TaskFindings::Design { designs, .. } = &point.findings else {
            panic!("no design");
        };
        let best = &designs[0];
        println!("{:?}: {} {:?}", point.at, best.objective, best.devices);
        assert!(
            (best.objective - width).abs() < 5.0,
            "{width}: {}",
            best.objective
        );
    }
}

/// A. H. Wickens, Fundamentals of Rail Vehicle Dynamics (2003), ch. 3: the speed at which a wheelset of two degrees of freedom begins to hunt,
/// from the Hurwitz determinant; with a = 2 f22, b = 2 f11 s², c = 2 f11 cone s/r: ω² = (b ky + a kψ)/(m b + I a),
/// V² = a b ω²/(m I ω⁴ - (m kψ + I ky) ω² + ky kψ + a c). Tolerance: that of located edges.
#[test]
fn a_wheelset_hunts_from_the_speed_of_the_closed_form_on() {
    let critical = |kpsi: f64| {
        let (m, i, s, r, cone) = (1022.0, 678.0, 0.716, 0.4572, 0.05);
        let (f11, f22, ky) = (1.1e7, 1.0e7, 2e5);
        let (a, b, c) = (2.0 * f22, 2.0 * f11 * s * s, 2.0 * f11 * cone * s / r);
        let square: f64 = (b * ky + a * kpsi) / (m * b + i * a);
        let below = m * i * square * square - (m * kpsi + i * ky) * square + ky * kpsi + a * c;
        (a * b * square / below).sqrt()
    };
    let study = gallery("wheelset.toml");
    let results = run(&study, &["springs alone"]);
    let TaskBody::Single(TaskFindings::Evaluate { configurations }) =
        &results.tasks["springs alone"].body
    else {
        panic!("an evaluate task evaluates");
    };
    let plain = &configurations["plain"];
    let speed = plain.criteria["speeds"];
    assert!((speed / critical(1e6) - 1.0).abs() < 1e-9, "{speed}");
    // Stiffer yaw springs make it faster: the softest for 80 m/s by bisection of the closed form.
    let (mut low, mut high) = (1e4_f64, 1e7_f64);
    for _ in 0..200 {
        let middle = (low * high).sqrt();
        if critical(middle) < 80.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    let springs = plain.criteria["springs"];
    assert!((springs / low - 1.0).abs() < 1e-9, "{springs} for {low}");
}
