//! Hosts of the gallery that are written as equations, against closed forms and published figures.
#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing)]

use std::path::Path;

use indexmap::IndexMap;
use quell_study::{Findings, RunSettings, Silent, Study, run};

/// Criteria at each point of the only task of a study.
fn criteria(name: &str) -> Vec<IndexMap<String, f64>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../studies")
        .join(name);
    let study = Study::read(&path).unwrap_or_else(|fault| panic!("{}", fault.render()));
    let outcome = run(&study, &RunSettings::default(), &Silent)
        .unwrap_or_else(|error| panic!("{}", error.fault().render()));
    outcome.tasks[0]
        .points
        .iter()
        .map(|point| match &point.findings {
            Findings::Evaluate(found) => found[0].criteria.clone(),
            _ => panic!("{name} evaluates"),
        })
        .collect()
}

fn near(value: f64, expected: f64, relative: f64) {
    assert!(
        (value - expected).abs() <= relative * expected.abs(),
        "{value}, expected {expected}"
    );
}

/// Periods and amplitudes by collocation with tight tolerances. The integration's tolerance of 1e-8 a step leaves less than 1e-6.
#[test]
fn van_der_pol() {
    let expected = [
        (6.663_286_859_3, 2.008_619_860_9),
        (11.612_230_667_7, 2.021_508_061_6),
        (19.078_369_566_9, 2.014_285_360_9),
    ];
    for (found, (period, amplitude)) in criteria("van-der-pol.toml").iter().zip(expected) {
        near(found["period"], period, 1e-6);
        near(found["amplitude"], amplitude, 1e-6);
    }
}

/// Free fall, then half a period of a spring without damping: closed forms. The run is piecewise linear and exact, so that
/// only rounding is left.
#[test]
fn bouncing_ball() {
    let found = &criteria("bouncing-ball.toml")[0];
    let (height, g, omega) = (1.0_f64, 9.81, 1000.0);
    near(found["first_contact"], (2.0 * height / g).sqrt(), 1e-10);
    let sag = g / (omega * omega);
    let speed = (2.0 * g * height).sqrt();
    near(found["deepest"], -(sag + sag.hypot(speed / omega)), 1e-9);
    near(found["rebound"], height, 1e-8);
    assert!(found["lost"].abs() < 1e-8, "{}", found["lost"]);
}

/// M. J. Brennan, I. Kovacic, A. Carrella and T. P. Waters, "On the jump-up and jump-down frequencies of the Duffing
/// oscillator", Journal of Sound and Vibration 318 (2008): at the jump down the amplitude over the static one is
/// √(2/(3α) (√(1 + 3α/(4ζ²)) - 1)), α = k3 F²/k³. It is of first order in harmonics, and the sweep takes a while to
/// fall off the branch: 2 %.
#[test]
fn duffing_under_a_sweep() {
    let found = &criteria("duffing-sweep.toml")[0];
    let stiffness = (2.0 * std::f64::consts::TAU).powi(2);
    let (force, cubic, zeta) = (1.5_f64, 2e4, 0.02_f64);
    let alpha = cubic * force * force / stiffness.powi(3);
    let bend = (1.0 + 3.0 * alpha / (4.0 * zeta * zeta)).sqrt() - 1.0;
    let amplitude = force / stiffness * (2.0 / (3.0 * alpha) * bend).sqrt();
    near(found["largest"], amplitude, 0.02);
    assert!(
        found["after_jump"] < 0.25 * amplitude,
        "{} after the jump from {amplitude}",
        found["after_jump"]
    );
}

/// Small swings of the slow mode: ω² = (2 - √2) g/l. At 0.01 degrees the next term of the pendulum's series, θ²/16, is below 1e-8.
/// At 60 degrees energy is kept.
#[test]
fn double_pendulum() {
    let found = criteria("double-pendulum.toml");
    let omega = ((2.0 - 2.0_f64.sqrt()) * 9.81).sqrt();
    near(found[0]["period"], std::f64::consts::TAU / omega, 1e-6);
    assert!(
        found[1]["energy_drift"] < 1e-6,
        "{}",
        found[1]["energy_drift"]
    );
}
