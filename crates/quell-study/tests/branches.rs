//! Branches, curves and diagrams of the gallery against figures that are known otherwise.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a failed test ends by panic"
)]

mod support;

use quell_study::continuation::{BranchResult, ContinuationResult};
use quell_study::{RunSettings, Silent};
use support::{found, gallery, points, responses, run, written};

fn values(branch: &BranchResult, kind: &str, parameter: &str) -> Vec<f64> {
    let mut values: Vec<f64> = points(branch, kind)
        .iter()
        .map(|one| one.parameters[parameter])
        .collect();
    values.sort_by(f64::total_cmp);
    values
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

fn cycles(found: &ContinuationResult) -> Vec<&BranchResult> {
    found
        .branches
        .iter()
        .filter(|branch| branch.of == "cycle")
        .collect()
}

/// The measure of the stable cycle at a value of the parameter, of all branches.
fn stable_at(found: &ContinuationResult, parameter: &str, value: f64, measure: &str) -> Vec<f64> {
    let mut out: Vec<f64> = cycles(found)
        .iter()
        .flat_map(|branch| &branch.at)
        .filter(|at| at.stable && (at.parameters[parameter] - value).abs() < 1e-9)
        .map(|at| at.measures[measure])
        .collect();
    out.sort_by(f64::total_cmp);
    out
}

/// Y. Li's doctoral thesis on the optimal design of passive vibration suppressors with inerters, chapter 5, recomputed with
/// AUTO-07p (EPSL = EPSU = 1e-9, EPSS = 1e-7, NCOL = 4, NTST = 20-80). Tolerances are a few units of the last digit kept
/// there; 0.3 % on amplitudes, which it took from mesh points.
#[test]
fn a_stiff_damper_lets_two_oscillations_be_bistable() {
    let study = gallery("zero-shimmy.toml");
    let results = run(&study, 2, &["L1 36000"]);
    let found = found(&results, "L1 36000");
    let rest = &found.branches[0];
    assert_eq!(rest.of, "equilibrium");
    let hopf = values(rest, "H", "V");
    near(&hopf[..1], &[13.4308], 1e-3);
    near(&hopf[1..2], &[25.0908], 2e-3);
    near(&hopf[2..3], &[33.8422], 1e-3);
    near(&hopf[3..], &[61.6176], 2e-3);
    // Torsion at 28 to 75 rad/s, bending near 110 rad/s.
    let omegas: Vec<f64> = points(rest, "H")
        .iter()
        .map(|one| one.omega.unwrap())
        .collect();
    assert_eq!(
        omegas.iter().filter(|omega| **omega > 100.0).count(),
        2,
        "{omegas:?}"
    );
    let both = cycles(found);
    assert_eq!(both.len(), 2);
    let tori: Vec<Vec<f64>> = both
        .iter()
        .map(|branch| values(branch, "NS", "V"))
        .collect();
    near(&tori.concat(), &[30.7865, 27.3702], 5e-3);
    let psi = stable_at(found, "V", 20.0, "psi");
    near(&[psi[0].to_degrees()], &[3.669], 3e-3 * 3.669);
    near(
        &[stable_at(found, "V", 20.0, "bend")[0] * 1e3],
        &[0.457],
        3e-3 * 0.457,
    );
    near(
        &[stable_at(found, "V", 40.0, "bend")[0] * 1e3],
        &[12.15],
        3e-3 * 12.15,
    );
    near(
        &[stable_at(found, "V", 40.0, "psi")[0].to_degrees()],
        &[0.527],
        3e-3 * 0.527,
    );
    let period = |value: f64| {
        let all = both.iter().flat_map(|branch| &branch.at);
        let stable = all.filter(|at| at.stable && (at.parameters["V"] - value).abs() < 1e-9);
        stable.map(|at| at.period_s.unwrap()).collect::<Vec<f64>>()
    };
    near(&period(20.0), &[0.091_459], 3e-3 * 0.091_459);
    near(&period(40.0), &[0.057_079], 3e-3 * 0.057_079);
}

/// As above: with softer dampers one oscillation alone is left.
#[test]
fn softer_dampers_leave_one_oscillation() {
    let study = gallery("zero-shimmy.toml");
    let results = run(&study, 2, &["L1 5000", "L1 2000"]);
    let bending = found(&results, "L1 5000");
    near(
        &values(&bending.branches[0], "H", "V"),
        &[25.2024, 50.6803],
        2e-3,
    );
    assert_eq!(bending.branches.len(), 2);
    assert!(
        cycles(bending)[0].special.is_empty(),
        "{:?}",
        cycles(bending)[0].special
    );
    let torsion = found(&results, "L1 2000");
    near(
        &values(&torsion.branches[0], "H", "V"),
        &[4.1494, 25.9574],
        2e-3,
    );
    assert_eq!(torsion.branches.len(), 2);
    assert!(cycles(torsion)[0].special.is_empty());
    for (speed, degrees) in [(10.0, 7.904), (15.0, 6.050)] {
        let psi = stable_at(torsion, "V", speed, "psi");
        near(&[psi[0].to_degrees()], &[degrees], 3e-3 * degrees);
    }
}

/// Aeroelastic section of the oracles of this crate's engine: AUTO-07p, EPSL = EPSU = 1e-9, parameters of special points to 1e-6
/// relative, periods to 1e-7; the generalised Hopf point to half a unit of its last printed digit.
#[test]
fn flutter_begins_subcritically_and_a_fold_of_cycles_precedes_it() {
    let study = gallery("aeroelastic-section.toml");
    let results = run(&study, 2, &[]);
    let flutter = found(&results, "flutter");
    let hopf = points(&flutter.branches[0], "H");
    assert_eq!(hopf.len(), 1);
    near(&[hopf[0].parameters["U"]], &[17.957_264_996], 17.96e-6);
    near(&[hopf[0].omega.unwrap()], &[15.478_938_986], 15.48e-6);
    assert!(hopf[0].normal_form["l1"] > 0.0, "subcritical");
    let folds = points(&flutter.branches[1], "LPC");
    near(&[folds[0].parameters["U"]], &[14.660_123_947], 14.66e-6);
    near(&[folds[0].period_s.unwrap()], &[0.418_544_969_6], 0.4186e-7);
    let onset = found(&results, "onset over k_a3");
    let critical = points(&onset.branches[0], "GH");
    assert_eq!(critical.len(), 1);
    near(&[critical[0].parameters["k_a3"]], &[1.0446e4], 0.5);
    // The curve of folds shrinks to nothing where the birth turns from one kind into the other, which it meets tangentially:
    // a cycle of relative size 1e-4 still lies 1e-4 from it.
    let fold = &found(&results, "fold over k_a3").branches[0];
    assert_eq!(fold.of, "LPC");
    assert!([fold.stop.backward, fold.stop.forward].contains(&"vanished"));
}

/// x'' + 2ζx' + x + x³ = F cos Ωt with ζ = 0.05, F = 0.2: folds at Ω = 1.5224481367 and 1.2520149905 (AUTO-07p, EPSL = EPSU = 1e-9,
/// parameters to 1e-6 relative). The amplitude and the frequency of a harmonic input are parameters like any other.
#[test]
fn forced_motions_are_followed_from_where_a_run_settles() {
    let text = r#"
[[tasks]]
name = "folds"
kind = "curve"
start = "response:LPC1"
parameters = ["Om", "F0"]
ranges = { F0 = [0.02, 0.4] }

[[tasks]]
name = "both folds"
kind = "curve"
start = ["response:LPC1", "response:LPC2"]
parameters = ["Om", "F0"]
ranges = { F0 = [0.02, 0.4] }
"#;
    let study = written(&responses(text));
    let results = run(&study, 2, &[]);
    let response = &found(&results, "response").branches[0];
    near(
        &values(response, "LPC", "Om"),
        &[1.252_014_990_5, 1.522_448_136_7],
        1.5e-6,
    );
    let at = &response.at[0];
    assert!((at.period_s.unwrap() - std::f64::consts::TAU).abs() < 1e-9);
    // Folds meet in a cusp at (Ω, F) = (1.09011, 0.0513635), to the digits that are known.
    let cusps = points(&found(&results, "folds").branches[0], "CPC");
    near(&[cusps[0].parameters["Om"]], &[1.09011], 1e-5);
    near(&[cusps[0].parameters["F0"]], &[0.051_363_5], 1e-6);
    // Both folds lie on the one curve, so each leads to the cusp.
    let both = &found(&results, "both folds").branches;
    let named: Vec<_> = both
        .iter()
        .map(|one| (one.id.as_str(), one.parent.as_deref()))
        .collect();
    assert_eq!(
        named,
        [
            ("K1", Some("response:C1:LPC1")),
            ("K2", Some("response:C1:LPC2"))
        ]
    );
    for curve in both {
        let cusp = points(curve, "CPC")[0];
        near(&[cusp.parameters["F0"]], &[cusps[0].parameters["F0"]], 1e-8);
    }
}

/// Curves in one plane from points of different dampers: refused where the damper is not one of the plane's parameters.
#[test]
fn curves_of_one_plane_are_of_one_configuration() {
    let study = |parameters: &str, range: &str| {
        written(&format!(
            r#"
quell = 1
title = "Two dampers"
host = "self-excited.toml"

[devices.damper]
port = "p"

[[tasks]]
name = "light"
kind = "branch"
parameter = "mu"
configuration = {{ damper = "c1", c1 = "0.2 N*s/m" }}

[[tasks]]
name = "heavy"
kind = "branch"
parameter = "mu"
configuration = {{ damper = "c1", c1 = "0.4 N*s/m" }}

[[tasks]]
name = "both"
kind = "curve"
start = ["light:H1", "heavy:H1"]
parameters = ["mu", "{parameters}"]
ranges = {{ {parameters} = {range} }}
"#
        ))
    };
    let fixed = study("k", r#"["90 N/m", "110 N/m"]"#);
    let refused = quell_study::run(&fixed, &RunSettings::default(), &Silent).unwrap_err();
    let words = refused.to_string();
    assert!(
        words.contains("`heavy` and `light` are of different configurations: `c1` is 0.4 and 0.2"),
        "{words}"
    );
    // Rest loses its stability at mu = c1, from either.
    let results = run(&study("c1", r#"["0.1 N*s/m", "1 N*s/m"]"#), 2, &[]);
    let curves = &found(&results, "both").branches;
    assert_eq!(curves.len(), 2);
}

/// φ'' + c φ' + sin φ = M going round and round. In a turn the torque does the work that the damper takes:
/// ∫ c φ'² dt = 2π M, so T mean(φ'²) = 2π M / c; exact, so the tolerance is that of collocation.
#[test]
fn a_pendulum_that_goes_round_is_a_cycle() {
    let text = r#"
quell = 1
title = "Rotations"
host = "driven-pendulum.toml"

[runs.settle]
kind = "transient"
duration = 200

[[tasks]]
name = "rotations"
kind = "branch"
parameter = "torque"
ranges = { torque = [0.2, 1.5] }
start = { run = "settle" }
at = [0.3, 0.5, 1, 1.4]
longest_period = 30
measures = { work = "rms(phi')^2", least = "min(phi)", most = "max(phi)" }
"#;
    let results = run(&written(text), 2, &[]);
    let rotations = &found(&results, "rotations").branches[0];
    assert!(rotations.at.len() >= 4, "{rotations:?}");
    for at in &rotations.at {
        let work = 0.1 * at.measures["work"] * at.period_s.unwrap();
        let torque = at.parameters["torque"];
        near(&[work], &[std::f64::consts::TAU * torque], 1e-6 * work);
        // One turn, and it begins within the first.
        let turned = at.measures["most"] - at.measures["least"];
        near(&[turned], &[std::f64::consts::TAU], 1e-9);
        assert!(at.stable);
    }
}

/// The pendulum with a weak spring from its angle to the ground: it goes round, and every turn is another one.
#[test]
fn an_angle_that_is_held_by_a_spring_does_not_turn_periodically() {
    let text = r#"
quell = 1
title = "No rotations"
host = "driven-pendulum.toml"
parameters = { k = 1e-5 }

[runs.settle]
kind = "transient"
duration = 200

[[tasks]]
name = "rotations"
kind = "branch"
parameter = "torque"
ranges = { torque = [0.2, 1.5] }
start = { run = "settle" }
"#;
    let study = written(text);
    let refused = quell_study::run(&study, &RunSettings::default(), &Silent).unwrap_err();
    let words = refused.to_string();
    assert!(
        words.contains("the angle `phi` goes on turning, but after whole turns of it the equations are not the same"),
        "{words}"
    );
}

/// Same study, same bits, for any number of threads.
#[test]
fn threads_change_nothing() {
    let study = gallery("aeroelastic-section.toml");
    let text = |threads| {
        let results = run(&study, threads, &["flutter"]);
        serde_json::to_string(&results.tasks).unwrap()
    };
    assert_eq!(text(1), text(2));
}
