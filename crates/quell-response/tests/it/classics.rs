//! Closed forms and published optima.

use std::f64::consts::TAU;
use std::sync::Arc;

use quell_model::linear::{InputKind, LinearHost, Signal};
use quell_response::{
    Assembly, CertificateStatus, Plan, PlanSettings, Scratch, certify, h2, h2_fast,
};

use crate::harness::{assembly, coordinate, form, host, input, matrix, port};

/// One mass on a spring and a damper, force on the mass; the port is between mass and ground.
fn single(mass: f64, damping: f64, stiffness: f64) -> LinearHost {
    let built = host(
        matrix(&[&[mass]]),
        matrix(&[&[damping]]),
        matrix(&[&[stiffness]]),
    );
    port(
        input(built, InputKind::Force, [&[1.0], &[], &[]]),
        &[1.0],
        &[0.0],
    )
}

fn peak(system: &Arc<Assembly>, values: &[f64], band: (f64, f64)) -> (f64, f64) {
    let plan = Plan::new(
        system,
        0,
        &form(&[(coordinate(0, 0), 1.0)]),
        band,
        PlanSettings::default(),
    )
    .unwrap();
    let peak = plan.peak(values, &mut Scratch::new());
    (peak.value, peak.omega)
}

#[test]
fn resonance_of_one_degree_of_freedom() {
    for zeta in [0.5, 0.1, 1e-2, 1e-3, 1e-5] {
        // All damping from the device, on an undamped host.
        let system = assembly(single(1.0, 0.0, 1.0), &[(0, "c")]);
        let output = form(&[(coordinate(0, 0), 1.0)]);
        let (value, omega) = peak(&system, &[2.0 * zeta], (0.0, 4.0));
        let exact = 1.0 / (2.0 * zeta * (1.0 - zeta * zeta).sqrt());
        // 1e-9 on |H|² is what the plan promises.
        assert!(
            (value / exact - 1.0).abs() < 2e-9,
            "ζ = {zeta}: {value} {exact}"
        );
        assert!((omega - (1.0 - 2.0 * zeta * zeta).sqrt()).abs() < 1e-4 * zeta.max(1e-4));
        let certificate = certify(&system, &[2.0 * zeta], 0, &output, (0.0, 4.0), 1e-8).unwrap();
        assert_eq!(
            certificate.status,
            CertificateStatus::Certified,
            "{certificate:?}"
        );
        assert!(
            (certificate.value / exact - 1.0).abs() < 1e-9 * (1.0 + 1e-4 / zeta),
            "{certificate:?}"
        );
        assert!(certificate.upper_bound >= exact * (1.0 - 1e-12));
        let norm = h2(&system, &[2.0 * zeta], 0, &output, None, None).unwrap();
        assert!(
            (norm.squared * 4.0 * zeta - 1.0).abs() < 1e-9,
            "ζ = {zeta}: {norm:?}"
        );
        assert!(
            norm.error_estimate < 1e-8 * norm.squared,
            "ζ = {zeta}: {norm:?}"
        );
        let fast = h2_fast(&system, &[2.0 * zeta], 0, &output).unwrap();
        assert!((fast / norm.squared - 1.0).abs() < 1e-9);
    }
}

/// Absorber (k | c) + b of mass ratio μ, natural frequency f and damping ratio ζ relative to a host with m = k = 1.
fn absorber(mu: f64, f: f64, zeta: f64) -> [f64; 3] {
    let k = mu * f * f;
    [k, 2.0 * zeta * (k * mu).sqrt(), mu]
}

#[test]
fn minimax_absorber_of_nishihara_and_asami() {
    // O. Nishihara and T. Asami, J. Vib. Acoust. 124 (2002): exact H∞ optimum, μ = 0.05.
    let system = assembly(single(1.0, 0.0, 1.0), &[(0, "(k | c) + b")]);
    let values = absorber(0.05, 0.952_372, 0.133_938);
    let (value, _) = peak(&system, &values, (0.0, 3.0));
    assert!((value - 6.407_92).abs() < 2e-5, "{value}");
    // Den Hartog's rule f = 1/(1+μ), ζ² = 3μ/(8(1+μ)) has the peak 6.40844.
    let rule = absorber(0.05, 1.0 / 1.05, (3.0_f64 * 0.05 / (8.0 * 1.05)).sqrt());
    let (ruled, _) = peak(&system, &rule, (0.0, 3.0));
    assert!((ruled - 6.408_44).abs() < 1e-5, "{ruled}");
    // Both peaks are equal at the optimum, and pieces sees them both.
    let plan = Plan::new(
        &system,
        0,
        &form(&[(coordinate(0, 0), 1.0)]),
        (0.0, 3.0),
        PlanSettings::default(),
    )
    .unwrap();
    let mut pieces = Vec::new();
    plan.pieces(&values, 1e-3, &mut Scratch::new(), &mut pieces)
        .unwrap();
    assert_eq!(pieces.len(), 2);
    assert!((pieces[0].value / pieces[1].value - 1.0).abs() < 1e-5);
    let certificate = certify(
        &system,
        &values,
        0,
        &form(&[(coordinate(0, 0), 1.0)]),
        (0.0, 3.0),
        1e-9,
    )
    .unwrap();
    assert_eq!(certificate.status, CertificateStatus::Certified);
    assert!((certificate.value / value - 1.0).abs() < 1e-9);
}

#[test]
fn absorber_as_a_hanging_mass_equals_an_inerter_to_ground() {
    let inerter = assembly(single(1.0, 0.02, 1.0), &[(0, "(k | c) + b")]);
    let hanging = assembly(single(1.0, 0.02, 1.0), &[(0, "(k | c) + m")]);
    let values = absorber(0.1, 0.9, 0.2);
    let output = form(&[
        (coordinate(0, 2), 1.0),
        (Signal::PortForce { index: 0 }, 0.3),
    ]);
    for omega in [1e-3, 0.7, 1.0, 5.0] {
        let a = inerter.direct_response(&values, 0, &output, omega).unwrap();
        let b = hanging.direct_response(&values, 0, &output, omega).unwrap();
        assert!((a - b).norm() < 1e-15 * a.norm());
    }
    assert_eq!(hanging.predicted_modes(), 4);
}

#[test]
fn variance_optimum_of_warburton_and_asami() {
    // Force on the mass, white noise: f² = (2+μ)/(2(1+μ)²), ζ² = μ(4+3μ)/(8(1+μ)(2+μ)) (Warburton 1982; Asami et al. 2002).
    let system = assembly(single(1.0, 0.0, 1.0), &[(0, "(k | c) + b")]);
    let output = form(&[(coordinate(0, 0), 1.0)]);
    for mu in [0.02_f64, 0.05, 0.3] {
        let f = (1.0 + 0.5 * mu).sqrt() / (1.0 + mu);
        let zeta = (mu * (4.0 + 3.0 * mu) / (8.0 * (1.0 + mu) * (2.0 + mu))).sqrt();
        let value = |f: f64, zeta: f64| {
            let values = absorber(mu, f, zeta);
            let norm = h2(&system, &values, 0, &output, None, None).unwrap();
            assert!(norm.error_estimate < 1e-8 * norm.squared, "{norm:?}");
            norm.squared
        };
        let optimum = value(f, zeta);
        // I = 2 ‖H‖² = √((4+3μ)/(μ(1+μ))) in the units m = k = 1.
        let closed = 0.5 * ((4.0 + 3.0 * mu) / (mu * (1.0 + mu))).sqrt();
        assert!(
            (optimum / closed - 1.0).abs() < 1e-9,
            "μ = {mu}: {optimum} {closed}"
        );
        for step in [-1e-3, 1e-3] {
            assert!(value(f * (1.0 + step), zeta) > optimum);
            assert!(value(f, zeta * (1.0 + 5.0 * step)) > optimum);
        }
    }
}

#[test]
fn isolated_mass_with_a_lever_inertia_in_a_tank() {
    // Mechanical equivalent of a fluid-filled mount, Y. Li, doctoral thesis, chapter 6 (linear low-frequency model):
    // max |(xe - xs)/xs| = 3.6349 at 18.71 Hz, first peak 2.309 at 8.06 Hz.
    let (me, kr, cr) = (60.0, 2.25e5, 105.0);
    let built = host(matrix(&[&[me]]), matrix(&[&[cr]]), matrix(&[&[kr]]));
    let built = input(built, InputKind::Displacement, [&[kr], &[cr], &[]]);
    let built = port(built, &[1.0], &[-1.0]);
    let system = assembly(built, &[(0, "k1 + (k2 | c | b)")]);
    let ap2 = 2.5e-3_f64.powi(2);
    let values = [ap2 / 3.0e-11, ap2 / 2.6e-9, ap2 * 1.05e8, ap2 * 3.8e6];
    let output = form(&[
        (coordinate(0, 0), 1.0),
        (Signal::Input { index: 0, order: 0 }, -1.0),
    ]);
    let plan = Plan::new(
        &system,
        0,
        &output,
        (0.0, 30.0 * TAU),
        PlanSettings::default(),
    )
    .unwrap();
    let mut pieces = Vec::new();
    plan.pieces(&values, 0.9, &mut Scratch::new(), &mut pieces)
        .unwrap();
    assert!((pieces[0].value - 3.6349).abs() < 5e-5, "{pieces:?}");
    assert!((pieces[0].omega / TAU - 18.71).abs() < 5e-3);
    assert!((pieces[1].value - 2.309).abs() < 5e-4);
    assert!((pieces[1].omega / TAU - 8.06).abs() < 5e-3);
    let certificate = certify(&system, &values, 0, &output, (0.0, 30.0 * TAU), 1e-6).unwrap();
    assert_eq!(certificate.status, CertificateStatus::Certified);
    assert!((certificate.value / pieces[0].value - 1.0).abs() < 1e-9);
}

#[test]
fn bands_and_spectra() {
    let system = assembly(single(1.0, 0.2, 1.0), &[]);
    let output = form(&[(coordinate(0, 0), 1.0)]);
    let all = h2(&system, &[], 0, &output, None, None).unwrap();
    assert!((all.squared - 1.0 / 0.4).abs() < 1e-10);
    // Both signs of a wide band hold nearly everything: the tail is 1/(3π ω³), its next term 1/ω² of that.
    let wide = h2(&system, &[], 0, &output, Some((0.0, 50.0)), None).unwrap();
    let tail = 1.0 / (3.0 * std::f64::consts::PI * 50.0_f64.powi(3));
    assert!(
        ((all.squared - wide.squared) / tail - 1.0).abs() < 2e-3,
        "{all:?} {wide:?}"
    );
    // A constant one-sided spectrum S per Hz is half of it for each sign: variance = S/2 · ‖H‖².
    let constant = h2(&system, &[], 0, &output, None, Some(&|_| 3.0)).unwrap();
    assert!(
        (constant.squared - 1.5 * all.squared).abs() < 1e-8 * all.squared,
        "{constant:?} {all:?}"
    );
    // Shaped acceleration input: a spectrum 1/ω⁴ of the force of an acceleration output.
    let acceleration = form(&[(coordinate(0, 2), 1.0)]);
    let shaped = h2(
        &system,
        &[],
        0,
        &acceleration,
        None,
        Some(&|omega: f64| 2.0 / omega.powi(4)),
    )
    .unwrap();
    assert!(
        (shaped.squared - all.squared).abs() < 1e-7 * all.squared,
        "{shaped:?}"
    );
}
