//! Pages of tasks that follow branches.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a failed test ends by panic"
)]

mod wellformed;

use std::path::Path;

use quell_study::{RunSettings, Silent, Study, run};

/// A wheelset that hunts: one branch of equilibria with its Hopf point, one of cycles, and a plane of two parameters.
#[test]
fn branches_and_regions_are_drawn_and_counted() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../studies/wheelset.toml");
    let study = Study::read(&path).unwrap_or_else(|fault| panic!("{fault:?}"));
    let settings = RunSettings {
        tasks: vec!["hunting".to_owned(), "plane".to_owned()],
        ..RunSettings::default()
    };
    let outcome = run(&study, &settings, &Silent).unwrap_or_else(|error| panic!("{error:?}"));
    let page = quell_report::page_of(&study, &outcome);
    let [hunting, plane] = page.tasks.as_slice() else {
        panic!("two tasks");
    };
    let found =
        |points: &Option<quell_report::page::PointTable>| points.as_ref().unwrap().found.clone();
    assert_eq!(found(&hunting.points), "2 branches, 1 special point");
    assert!(
        found(&plane.points).ends_with(" cells"),
        "{}",
        found(&plane.points)
    );
    // One picture for each measure of a branch, one of a plane, which has areas.
    assert_eq!(hunting.plots.len(), 2);
    assert_eq!(plane.plots.len(), 1);
    assert!(plane.plots[0].areas.len() >= 2);
    let html = quell_report::html(&study, &outcome);
    let (_, body) = html.split_once("<body>").unwrap();
    let (body, _) = body.split_once("</body>").unwrap();
    wellformed::well_formed(&format!("<body>{body}</body>")).unwrap();
    assert!(!html.contains("configurations evaluated"));
}
