//! Motions let go from several starts against closed forms, and against branches.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a failed test ends by panic"
)]

mod support;

use quell_study::continuation::{MotionResult, MotionsResult};
use quell_study::results::Results;
use support::{found, gallery, responses, run, written};

fn motions<'a>(results: &'a Results, task: &str) -> &'a MotionsResult {
    found(results, task).motions.as_ref().unwrap()
}

fn ends(all: &[MotionResult]) -> Vec<&str> {
    all.iter().map(|motion| motion.end).collect()
}

/// Bautin's normal form r' = mu r + a r³ - r⁵, theta' = 1: for mu = -0.1, a = 1 both rest and the cycle r² = (1 + √0.6)/2, T = 2π are
/// stable; the unstable cycle between them has r = 0.3357.
const BAUTIN: &str = r#"
quell = 1
title = "Two attractors"
host = "bautin.toml"

[[tasks]]
name = "all"
kind = "diagram"
parameter = "mu"
ranges = { mu = [-0.5, 0.5] }
measures = { r = "max(u)" }

[[tasks]]
name = "rest"
kind = "branch"
parameter = "mu"
ranges = { mu = [-0.5, 0.5] }

[[tasks]]
name = "plane"
kind = "region"
parameters = ["mu", "a"]
ranges = { mu = [-0.5, 0.5], a = [-1, 2] }

[[tasks]]
name = "beside the cycle between"
kind = "simulate"
of = "all"
at = [-0.1]
starts = [{ u = 0.33 }, { u = 0.34 }, { w = -0.34 }]

[[tasks]]
name = "pushed"
kind = "simulate"
of = "all"
at = [-0.4, -0.1, 0.2, 0.5]
starts = 5

[[tasks]]
name = "without cycles"
kind = "simulate"
of = "rest"
at = [-0.1]
measures = { r = "max(u)" }
starts = [{ u = 0.1 }, { u = 0.5 }]

[[tasks]]
name = "in the plane"
kind = "simulate"
of = "plane"
at = [[-0.1, 1], [0.1, 1], [-0.1, -0.5]]
starts = [{ u = 0.05 }, { u = 1 }]

[[tasks]]
name = "alone"
kind = "simulate"
parameter = "mu"
ranges = { mu = [-1, 1] }
measures = { r = "max(u)" }
starts = [{ u = 0.5 }]

[[tasks]]
name = "cut short"
kind = "simulate"
of = "all"
at = [0.001]
starts = [{ u = 0.01 }]
duration = 100
"#;

#[test]
fn motions_part_at_the_unstable_cycle() {
    let results = run(&written(BAUTIN), 2, &["all", "beside the cycle between"]);
    let found = motions(&results, "beside the cycle between");
    let at = &found.at[0];
    assert_eq!(ends(&at.motions), ["equilibrium", "cycle", "cycle"]);
    assert_eq!((found.count, found.agree, found.open), (3, 3, 0));
    let stable: Vec<_> = at.stable.iter().map(|one| one.solution.of).collect();
    assert_eq!(stable, ["equilibrium", "cycle"]);
    assert_eq!(at.stable[0].reached, 1);
    assert_eq!(at.stable[1].reached, 2);
    // A motion ends when 2e-3 of its swing may be to come; the radius of the stable cycle is a closed form.
    let radius = (0.5 * (1.0 + 0.6_f64.sqrt())).sqrt();
    for motion in &at.motions[1..] {
        assert!((motion.measures["r"] - radius).abs() < 2e-3 * radius);
        assert!((motion.period_s.unwrap() - std::f64::consts::TAU).abs() < 1e-4);
        assert_eq!(motion.on.as_deref(), Some("C1"));
    }
    // The cycle of the branch is corrected at the value that is asked for.
    assert!((at.stable[1].solution.measures["r"] - radius).abs() < 1e-6);
}

/// Below the fold of cycles at mu = -1/4 all motions come to rest, above the Hopf point at 0 none does.
#[test]
fn pushes_reach_both_attractors_where_there_are_two() {
    let results = run(&written(BAUTIN), 2, &["all", "pushed"]);
    let found = motions(&results, "pushed");
    assert_eq!((found.count, found.agree), (20, 20));
    let kinds: Vec<Vec<&str>> = found.at.iter().map(|at| ends(&at.motions)).collect();
    assert_eq!(kinds[0], ["equilibrium"; 5]);
    assert!(
        kinds[1].contains(&"equilibrium") && kinds[1].contains(&"cycle"),
        "{kinds:?}"
    );
    assert_eq!(kinds[2], ["cycle"; 5]);
    // The end of the range is a point of the branch too.
    assert_eq!(kinds[3], ["cycle"; 5]);
}

#[test]
fn an_attractor_that_was_not_followed_is_noticed() {
    let results = run(&written(BAUTIN), 2, &["rest", "without cycles"]);
    let found = motions(&results, "without cycles");
    assert_eq!((found.agree, found.elsewhere, found.open), (1, 1, 0));
    let elsewhere = &found.at[0].motions[1];
    assert_eq!((elsewhere.end, &elsewhere.on), ("cycle", &None));
}

#[test]
fn motions_end_on_what_is_stable_in_their_part_of_a_plane() {
    let results = run(&written(BAUTIN), 2, &["plane", "in the plane"]);
    let found = motions(&results, "in the plane");
    let kinds: Vec<Vec<&str>> = found.at.iter().map(|at| ends(&at.motions)).collect();
    assert_eq!(kinds[0], ["equilibrium", "cycle"]);
    assert_eq!(kinds[1], ["cycle", "cycle"]);
    assert_eq!(kinds[2], ["equilibrium", "equilibrium"]);
    assert_eq!((found.agree, found.elsewhere, found.open), (6, 0, 0));
}

#[test]
fn without_branches_motions_are_simply_watched() {
    let results = run(&written(BAUTIN), 2, &["alone"]);
    let found = motions(&results, "alone");
    assert_eq!(
        (found.of.as_deref(), found.agree, found.elsewhere),
        (None, 0, 0)
    );
    let motion = &found.at[0].motions[0];
    let radius = (0.5 * (1.0 + 0.6_f64.sqrt())).sqrt();
    assert!((motion.measures["r"] - radius).abs() < 2e-3 * radius);
}

/// In 100 periods of a growth by 0.001 a motion has not settled: it is neither at rest nor on a cycle.
#[test]
fn what_has_not_settled_is_called_open() {
    let results = run(&written(BAUTIN), 2, &["all", "cut short"]);
    let found = motions(&results, "cut short");
    assert_eq!((found.agree, found.open), (0, 1));
    let why = found.at[0].motions[0].why.as_deref().unwrap();
    assert!(why.contains("still grew"), "{why}");
}

/// A hardening oscillator between the folds of its response has two: x'' + 0.1 x' + x + x³ = 0.2 cos(1.4 t); the branch of its cycles
/// is the oracle, and the folds of that are tested against AUTO elsewhere.
#[test]
fn a_forced_oscillator_jumps_between_two_responses() {
    let study = written(&responses(
        r#"
[[tasks]]
name = "let go"
kind = "simulate"
of = "response"
at = [0.6, 1.4]
starts = [{ x = 0.01 }, { x = 1.2 }, { "x'" = -1.5 }, { x = -1 }, { "x'" = 1.5 }, { x = 2 }, { x = -2 }, { "x'" = 2.5 }]
"#,
    ));
    let results = run(&study, 2, &["response", "let go"]);
    let found = motions(&results, "let go");
    assert_eq!((found.count, found.agree), (16, 16), "{:?}", found.at);
    let [low, high] = &found.at[1].stable[..] else {
        panic!("{:?}", found.at[1].stable)
    };
    assert!(low.reached > 0 && high.reached > 0, "{:?}", found.at[1]);
    for motion in &found.at[1].motions {
        let swing = motion.measures["swing"];
        let near = found.at[1].stable.iter().any(|one| {
            let known = one.solution.measures["swing"];
            (swing - known).abs() < 5e-3 * known
        });
        assert!(near, "{swing}");
    }
}

/// Y. Li's doctoral thesis, chapter 5: with this damper torsion alone oscillates at 20 m/s, with 3.67 degrees (recomputed with
/// AUTO-07p), and at 29 m/s torsion or bending, by the push.
#[test]
fn both_shimmies_are_seen_where_both_are_stable() {
    let results = run(
        &gallery("zero-shimmy.toml"),
        2,
        &["L1 36000", "L1 36000 let go"],
    );
    let found = motions(&results, "L1 36000 let go");
    assert_eq!((found.elsewhere, found.open), (0, 0), "{:?}", found.at);
    let at = |speed: f64| {
        let at = found
            .at
            .iter()
            .find(|at| (at.parameters["V"] - speed).abs() < 1e-9);
        &at.unwrap().motions
    };
    for motion in at(20.0) {
        assert!((motion.measures["psi"].to_degrees() - 3.669).abs() < 0.01);
    }
    let names: Vec<_> = at(29.0)
        .iter()
        .map(|motion| motion.oscillation.as_deref().unwrap())
        .collect();
    assert!(
        names.contains(&"torsion") && names.contains(&"bending"),
        "{names:?}"
    );
}

/// Motions are the same bits on any number of threads.
#[test]
fn threads_do_not_matter() {
    let one = run(&written(BAUTIN), 1, &["all", "pushed"]);
    let two = run(&written(BAUTIN), 2, &["all", "pushed"]);
    let text = |results: &Results| serde_json::to_string(&motions(results, "pushed")).unwrap();
    assert_eq!(text(&one), text(&two));
}

/// About the rest of a linear host no push is large: the task says what to do, and lets nothing go.
#[test]
fn a_linear_host_needs_stated_starts() {
    let study = |starts: &str| {
        written(&format!(
            r#"
quell = 1
title = "Linear"
host = "linear.toml"

[[tasks]]
name = "let go"
kind = "simulate"
measures = {{ x = "max(abs(x))" }}
{starts}
"#
        ))
    };
    let results = run(&study(""), 1, &["let go"]);
    let status = &results.tasks["let go"].status;
    assert!(
        status.contains("as good as linear") && status.contains("starts ="),
        "{status}"
    );
    let results = run(
        &study("starts = [{ x = 1 }, { \"x'\" = 2 }]"),
        1,
        &["let go"],
    );
    assert_eq!(
        ends(&motions(&results, "let go").at[0].motions),
        ["equilibrium"; 2]
    );
}

/// x' = -1e-3 x + x³: nothing swings, and motions are watched for as long as what creeps takes, 10 / 0.001; r = 0.0316 parts them.
#[test]
fn what_creeps_is_watched_for_its_own_time() {
    let study = written(
        r#"
quell = 1
title = "Creeping"
host = "creeping.toml"

[[tasks]]
name = "let go"
kind = "simulate"
measures = { x = "max(abs(x))" }
starts = [{ x = 0.03 }]
"#,
    );
    let results = run(&study, 1, &["let go"]);
    let motion = &motions(&results, "let go").at[0].motions[0];
    assert_eq!(motion.end, "equilibrium");
    // From 0.03 to a thousandth of that: t = 500 ln((1 - 1e-3/x²) at the end / at the start) s, closed form.
    let part = |x: f64| (1e-3 / (x * x) - 1.0).ln();
    let least = 500.0 * (part(3e-5) - part(0.03));
    assert!(
        motion.duration_s >= least && motion.duration_s < 30.0 * least,
        "{} {least}",
        motion.duration_s
    );
}
