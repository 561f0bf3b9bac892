//! Regions of the gallery against figures that are known otherwise.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a failed test ends by panic"
)]

mod support;

use quell_study::continuation::{BranchOutcome, ContinuationFindings, RegionFindings};
use quell_study::{Findings, Silent, Study};
use support::{gallery, settings};

fn followed(study: &Study, task: &str) -> ContinuationFindings {
    followed_by(study, task, 2)
}

fn followed_by(study: &Study, task: &str, threads: usize) -> ContinuationFindings {
    let outcome = quell_study::run(study, &settings(threads, &[task]), &Silent)
        .unwrap_or_else(|error| panic!("{error}"));
    match &outcome.tasks[0].points[0].findings {
        Findings::Continuation(found) => {
            assert_eq!(found.status, "done");
            (**found).clone()
        }
        other => panic!("{other:?}"),
    }
}

fn of<'a>(found: &'a ContinuationFindings, kind: &str) -> Vec<&'a BranchOutcome> {
    found
        .branches
        .iter()
        .filter(|branch| branch.of == kind)
        .collect()
}

/// Values of the first parameter at which a curve passes one of the second: cubics through four points.
fn passes(branch: &BranchOutcome, second: f64) -> Vec<f64> {
    let points: Vec<(f64, f64)> = branch
        .points
        .iter()
        .map(|point| (point.parameters[1], point.parameters[0]))
        .collect();
    let mut found = Vec::new();
    for k in 0..points.len() - 1 {
        if (points[k].0 > second) == (points[k + 1].0 > second) {
            continue;
        }
        let from = k.saturating_sub(1).min(points.len() - 4);
        let four = &points[from..from + 4];
        let value = (0..4)
            .map(|i| {
                let others = (0..4).filter(|j| *j != i);
                others.fold(four[i].1, |product, j| {
                    product * (second - four[j].0) / (four[i].0 - four[j].0)
                })
            })
            .sum();
        found.push(value);
    }
    found.sort_by(f64::total_cmp);
    found
}

#[track_caller]
fn near(found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len(), "{found:?} for {expected:?}");
    for (found, expected) in found.iter().zip(expected) {
        assert!(
            (found - expected).abs() <= tolerance,
            "{found} for {expected} within {tolerance}"
        );
    }
}

/// What is stable in the cell round a point.
fn label(regions: &RegionFindings, at: [f64; 2]) -> &str {
    let round = |ring: &Vec<[f64; 2]>| {
        let next = ring.iter().cycle().skip(1);
        let sides = ring.iter().zip(next).filter(|(a, b)| {
            (a[1] > at[1]) != (b[1] > at[1])
                && a[0] + (at[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) > at[0]
        });
        sides.count()
    };
    let cell = regions.cells.iter().find(|cell| {
        let sides: usize = cell.loops.iter().map(round).sum();
        sides % 2 == 1
    });
    cell.map_or("no cell", |cell| cell.label.as_str())
}

/// Y. Li's doctoral thesis on the optimal design of passive vibration suppressors with inerters, chapter 5, recomputed with
/// AUTO-07p: three Hopf curves, two Hopf-Hopf points, torus curves that pass V = 30.7865 and 27.3702 m/s at cd = 3.6e4 N m s/rad and between
/// which both oscillations are stable. Tolerance: that of the recomputation, 0.005 m/s; a cubic through points of a curve that are
/// 0.02 of the rectangle apart adds some 1e-4.
#[test]
fn the_plane_of_the_landing_gear_needs_no_hint() {
    let study = gallery("zero-shimmy.toml");
    let found = followed(&study, "L1 plane");
    let hopf = of(&found, "H");
    assert_eq!(hopf.len(), 3, "{:?}", found.notes);
    let at = |cd: f64| {
        let mut all: Vec<f64> = hopf.iter().flat_map(|curve| passes(curve, cd)).collect();
        all.sort_by(f64::total_cmp);
        all
    };
    near(&at(3.6e4), &[13.4308, 25.0908, 33.8422, 61.6176], 0.005);
    near(&at(5e3), &[25.2024, 50.6803], 0.005);
    near(&at(2e3), &[4.1494, 25.9574], 0.005);
    // Two Hopf-Hopf points, each on both of the upper curves.
    let mut crossings: Vec<&str> = hopf
        .iter()
        .flat_map(|curve| &curve.special)
        .filter(|one| one.kind == "HH")
        .map(|one| one.label.as_str())
        .collect();
    crossings.sort_unstable();
    assert_eq!(crossings, ["HH1", "HH1", "HH2", "HH2"]);
    // Section 10 of the recomputation: below 300 N m s/rad aside, no oscillation is born unstable.
    let born = hopf.iter().flat_map(|curve| &curve.special);
    assert!(born.clone().all(|one| one.kind != "GH"));
    for label in ["HH1", "HH2"] {
        let same: Vec<&Vec<f64>> = born
            .clone()
            .filter(|one| one.label == label)
            .map(|one| &one.point.parameters)
            .collect();
        for (a, b) in same[0].iter().zip(same[1]) {
            assert!((a / b - 1.0).abs() < 1e-6, "{label}: {a} and {b}");
        }
    }
    let mut torus: Vec<f64> = of(&found, "NS")
        .iter()
        .filter(|curve| curve.parent.is_some())
        .flat_map(|curve| passes(curve, 3.6e4))
        .collect();
    torus.sort_by(f64::total_cmp);
    near(&torus, &[27.3702, 30.7865], 0.005);
    let regions = found.regions.as_ref().unwrap();
    let expected = [
        ([29.0, 3.6e4], "bistable: torsion or bending"),
        ([26.0, 3.6e4], "torsion"),
        ([20.0, 3.6e4], "torsion"),
        ([33.0, 3.6e4], "bending"),
        ([40.0, 3.6e4], "bending"),
        ([40.0, 5e3], "bending"),
        ([10.0, 2.1e3], "torsion"),
        // Within the free band from 2754.35 to 3018.98, and beyond all oscillations.
        ([10.0, 2900.0], "stable equilibrium"),
        ([36.0, 2900.0], "stable equilibrium"),
        ([100.0, 1e4], "stable equilibrium"),
    ];
    for (at, words) in expected {
        assert_eq!(label(regions, at), words, "{at:?}");
    }
    let whole: f64 = regions.cells.iter().map(|cell| cell.area).sum();
    assert!((whole - 1.0).abs() < 1e-4, "{whole}");
}

/// The same section as in the study's branches (AUTO-07p, EPSL = EPSU = 1e-9): the Hopf point at U = 17.957264996 does not depend on k_a3, the
/// fold of cycles lies at U = 14.660123947 for k_a3 = 5006.7, and the generalised Hopf point at k_a3 = 1.0446e4 ends the
/// speeds at which the section rests or flutters.
#[test]
fn a_section_rests_or_flutters_between_folds_and_hopf_points() {
    let study = gallery("aeroelastic-section.toml");
    let found = followed(&study, "plane");
    let hopf = of(&found, "H");
    let onset: Vec<f64> = hopf
        .iter()
        .flat_map(|curve| passes(curve, 5006.7))
        .collect();
    near(&onset, &[17.957_264_996], 1e-5);
    let critical: Vec<f64> = hopf
        .iter()
        .flat_map(|curve| &curve.special)
        .filter(|one| one.kind == "GH")
        .map(|one| one.point.parameters[1])
        .collect();
    near(&critical, &[1.0446e4], 0.5);
    let folds: Vec<f64> = of(&found, "LPC")
        .iter()
        .flat_map(|curve| passes(curve, 5006.7))
        .collect();
    near(&folds, &[14.660_123_947], 1e-3);
    let regions = found.regions.as_ref().unwrap();
    assert_eq!(label(regions, [13.0, 5006.7]), "stable equilibrium");
    assert_eq!(
        label(regions, [16.0, 5006.7]),
        "bistable: stable equilibrium or oscillation"
    );
    assert_eq!(label(regions, [18.5, 5006.7]), "oscillation");
    assert_eq!(label(regions, [16.0, 1.8e4]), "stable equilibrium");
}

/// The curve on which a wheelset begins to hunt has a closed form (A. H. Wickens, Fundamentals of Rail Vehicle Dynamics, 2003, ch. 3; see the
/// host), and neither curve nor cells depend on the number of threads by a single bit.
#[test]
fn a_wheelset_runs_straight_or_hunts() {
    let study = gallery("wheelset.toml");
    let found = followed_by(&study, "plane", 1);
    let hopf = of(&found, "H");
    assert_eq!(hopf.len(), 1);
    for point in &hopf[0].points {
        let [speed, kpsi] = point.parameters[..] else {
            panic!("a point of a plane has two parameters");
        };
        let (m, i, s, r, cone) = (1022.0, 678.0, 0.716, 0.4572, 0.05);
        let (f11, f22, ky) = (1.1e7, 1.0e7, 2e5);
        let (a, b, c) = (2.0 * f22, 2.0 * f11 * s * s, 2.0 * f11 * cone * s / r);
        let square: f64 = (b * ky + a * kpsi) / (m * b + i * a);
        let below = m * i * square * square - (m * kpsi + i * ky) * square + ky * kpsi + a * c;
        let critical = (a * b * square / below).sqrt();
        // Newton's method converges to 1e-10 of the ranges.
        assert!((speed / critical - 1.0).abs() < 1e-7, "{speed} {kpsi}");
    }
    let regions = found.regions.as_ref().unwrap();
    assert_eq!(label(regions, [40.0, 2e4]), "oscillation");
    assert_eq!(label(regions, [70.0, 5e6]), "stable equilibrium");
    let again = followed_by(&study, "plane", 2);
    let files = |found: &ContinuationFindings| -> Vec<(String, String)> {
        let all = found.files();
        all.map(|(name, text)| (name.to_owned(), text)).collect()
    };
    assert_eq!(files(&found), files(&again));
}
