//! Stable bands of the gallery against figures that are known otherwise.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a failed test ends by panic"
)]

use std::path::{Path, PathBuf};

use quell_study::results::{ConfigurationResult, Results, TaskBody, TaskFindings};
use quell_study::{RunSettings, Silent, Study};

fn gallery(name: &str) -> Study {
    let path: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../studies")
        .join(name);
    Study::read(&path).unwrap_or_else(|fault| panic!("{}", fault.render()))
}

fn run(study: &Study, tasks: &[&str]) -> Results {
    let settings = RunSettings {
        seed: 1,
        threads: Some(2),
        tasks: tasks.iter().map(|task| (*task).to_owned()).collect(),
    };
    quell_study::run(study, &settings, &Silent)
        .unwrap_or_else(|error| panic!("{error}"))
        .results
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
