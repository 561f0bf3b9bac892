//! The main landing gear of chapter 3 of Y. Li's doctoral thesis on the optimal design of passive vibration suppressors with
//! inerters, after a sudden slip of the tyres and after a blow from the side.
//!
//! Expected figures were computed independently, by exact modal propagation of the same linear equations; they are printed to the
//! digits below. The tolerances are those asked for: peaks 0.1 %, spans 0.2 ms, damping ratios 1e-4.
#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing)]

use std::path::Path;

use quell_study::{Evaluated, Findings, RunSettings, Silent, Study, run};

fn findings(task: &str) -> Findings {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../studies/shimmy-transient.toml");
    let study = Study::read(&path).unwrap_or_else(|fault| panic!("{}", fault.render()));
    let settings = RunSettings {
        tasks: vec![task.to_owned()],
        ..RunSettings::default()
    };
    let mut outcome = run(&study, &settings, &Silent).unwrap_or_else(|error| panic!("{error}"));
    outcome.tasks.remove(0).points.remove(0).findings
}

fn configurations(task: &str) -> Vec<Evaluated> {
    match findings(task) {
        Findings::Evaluate(found) => found,
        other => panic!("`{task}` evaluates: {other:?}"),
    }
}

/// Input, configuration, peak (1e-2 rad), span and graze-tolerant span (ms), second extreme (1e-2 rad).
type Row = (&'static str, &'static str, f64, f64, f64, f64);

///
/// In two rows the record ends while a swing of 2.5 and 1.8 times the threshold lasts. The table's tolerant spans, 259.6 and 281.7 ms,
/// leave such an unfinished swing out; here it counts, as it does in the plain span, and the device is said not to have settled.
const ROWS: [Row; 21] = [
    ("slip", "default", 1.4947, 108.51, 108.5, 0.4173),
    ("slip", "C1ap", 1.2475, 101.29, 101.3, 0.5446),
    ("slip", "C2ap as printed", 1.2106, 295.75, 295.75, 1.1705),
    ("slip", "C2ap", 1.0815, 119.59, 94.3, 0.8222),
    ("slip", "C1aps", 1.3133, 101.98, 102.0, 0.4178),
    ("slip", "C2aps", 1.1011, 102.15, 102.2, 0.4007),
    ("slip", "C1as", 1.4888, 93.95, 93.9, 0.2093),
    ("slip", "C2as", 1.2561, 71.09, 47.0, 0.1539),
    ("slip", "C1Fps", 1.3692, 106.07, 106.1, 0.3910),
    ("slip", "C2Fps", 1.1290, 70.75, 70.7, 0.2020),
    ("force", "default", 1.4929, 120.93, 120.9, 0.7033),
    ("force", "C1Fp", 1.3920, 156.40, 123.9, 0.6993),
    ("force", "C2Fp as printed", 1.0432, 296.69, 296.69, 1.0323),
    ("force", "C2Fp", 1.0170, 229.93, 123.0, 0.9401),
    ("force", "C1Fps", 1.4004, 155.44, 123.1, 0.6981),
    ("force", "C2Fps", 1.2427, 131.59, 131.6, 0.6817),
    ("force", "C1Fs", 1.4141, 155.22, 121.8, 0.6970),
    ("force", "C2Fs as printed", 1.0904, 295.18, 295.1, 1.0320),
    ("force", "C2Fs", 1.5156, 118.90, 83.5, 0.6918),
    ("force", "C1as", 1.4951, 121.04, 121.0, 0.7016),
    ("force", "C2as", 1.3574, 119.45, 119.4, 0.6842),
];

fn check(found: &Evaluated, row: Row) {
    let (input, name, peak, span, tolerant, second) = row;
    let of = |criterion: &str| found.criteria[&format!("{input}_{criterion}")];
    let mut wrong = Vec::new();
    let mut compare = |what: &str, value: f64, expected: f64, tolerance: f64| {
        if value.is_nan() || (value - expected).abs() > tolerance {
            wrong.push(format!("{what} {value:.5}, expected {expected}"));
        }
    };
    compare("peak", 100.0 * of("peak"), peak, 1e-3 * peak);
    compare("second", 100.0 * of("second"), second, 1e-3 * second);
    compare("span", 1e3 * of("t"), span, 0.2);
    // Printed to 0.1 ms.
    compare("tolerant span", 1e3 * of("tolerant"), tolerant, 0.25);
    assert!(wrong.is_empty(), "{input} {name}: {}", wrong.join("; "));
}

#[test]
fn every_row_of_the_table() {
    let found = configurations("table");
    for row in ROWS {
        let configuration = found.iter().find(|one| one.name == row.1).unwrap();
        check(configuration, row);
    }
    // What is still above the threshold at the end of the record, or passes it by little, is said to be so.
    let status = |name: &str, criterion: &str| {
        let configuration = found.iter().find(|one| one.name == name).unwrap();
        configuration.details[criterion].status.clone()
    };
    for (name, criterion) in [
        ("C2ap as printed", "slip_t"),
        ("C2ap as printed", "slip_tolerant"),
        ("C2Fp as printed", "force_t"),
    ] {
        let cut = status(name, criterion);
        assert!(cut.contains("not settled"), "{cut}");
    }
    let grazing = status("C2as", "slip_t");
    assert!(grazing.contains("grazing"), "{grazing}");
    assert_eq!(status("default", "slip_t"), "computed");
}

#[test]
fn wheels_closer_and_a_shorter_trail() {
    for (task, row) in [
        ("l-", ("slip", "l-", 1.4648, 92.44, 92.5, 0.3574)),
        ("e-", ("slip", "e-", 1.3251, 91.35, 91.4, 0.2616)),
    ] {
        check(&configurations(task)[0], row);
    }
}

#[test]
fn least_damping_ratios() {
    let found = configurations("table");
    for (name, expected) in [("default", 0.04461), ("C3", 0.07789)] {
        let configuration = found.iter().find(|one| one.name == name).unwrap();
        let value = configuration.criteria["zeta_min"];
        assert!((value - expected).abs() <= 1e-4, "{name}: {value}");
    }
}

/// The tyres hardly feel the device: after the slip their deflection differs from the default's by less than 6.0e-4 m of
/// 3.92e-2 m, so that its largest value is the initial one for all.
#[test]
fn tyres_hardly_feel_the_device() {
    for configuration in configurations("table") {
        let v1 = configuration.criteria["slip_v1"];
        assert!((v1 - 0.03919).abs() < 1e-5, "{}: {v1}", configuration.name);
    }
}

/// Optima by differential evolution and simplices, to the digits that are printed.
#[test]
fn optima_are_reached() {
    for (task, expected) in [
        ("C1ap*", 1.308e-2),
        ("C1as", 74.5e-3),
        ("C2as", 42.1e-3),
        ("C2Fp*", 1.127e-2),
    ] {
        let Findings::Design(found) = findings(task) else {
            panic!("`{task}` designs");
        };
        let best = &found.designs[0];
        assert!(best.feasible, "{task}");
        assert!(
            best.objective <= expected * 1.0005,
            "{task}: {} for {expected}",
            best.objective
        );
        assert!(best.starts_agreeing >= 2, "{task}");
    }
}

/// Optimise, synthesise, simplify: the best biquadratic for the least damping ratio is the four-element layout of the thesis,
/// whose own values (1.490e5, 4980, 1002, 13.30) were found by a local search to give 7.90 %.
#[test]
fn four_elements_from_the_immittance_route() {
    let Findings::Design(found) = findings("C3 by immittance") else {
        panic!("it designs");
    };
    let best = &found.designs[0];
    assert!(best.feasible && best.objective > 0.0805, "{best:?}");
    let synthesis = &best.synthesis[0];
    assert!(!synthesis.networks.is_empty(), "{}", synthesis.status);
    for network in &synthesis.networks {
        assert!(network.residual <= 1e-9, "{network:?}");
    }
    let four = found
        .simplified
        .iter()
        .find(|one| one.elements == 4)
        .unwrap();
    assert!(four.design.objective > 0.0805, "{four:?}");
    // Fewer elements cannot be better than more, but for what the searches leave open.
    for pair in found.simplified.windows(2) {
        assert!(pair[1].elements < pair[0].elements);
        let (more, fewer) = (pair[0].design.objective, pair[1].design.objective);
        assert!(fewer <= more + 1e-4, "{more} {fewer}");
    }
}
