//! Fast paths against the stamped nodal system.

use num_complex::Complex64;
use quell_model::linear::{InputKind, LinearForm, LinearHost, Signal};
use quell_response::{Plan, PlanSettings, Scratch};

use crate::harness::{
    Random, assembly, coordinate, form, host, input, matrix, network, port, random_host,
    random_layout, random_port, random_values,
};

/// A random output: coordinates, input, port force, stroke and force of a part, derivatives.
fn random_form(
    random: &mut Random,
    host: &LinearHost,
    devices: &[(usize, &str)],
    parts: bool,
) -> LinearForm {
    let mut terms = vec![(
        coordinate(random.below(host.coordinates.len()), random.below(3)),
        random.between(-2.0, 2.0),
    )];
    if random.unit() < 0.3 {
        terms.push((
            Signal::Input {
                index: 1,
                order: random.below(3),
            },
            random.between(-2.0, 2.0),
        ));
    }
    if random.unit() < 0.5 {
        terms.push((
            Signal::PortForce {
                index: devices[0].0,
            },
            random.between(-2.0, 2.0),
        ));
    }
    if parts {
        let (port, text) = devices[random.below(devices.len())];
        let device = network(text);
        let part = device.elements()[random.below(device.elements().len())]
            .name
            .clone();
        // Two devices on one port may share a name; then there is no part to speak of.
        let shared = devices
            .iter()
            .filter(|other| {
                other.0 == port
                    && network(other.1)
                        .elements()
                        .iter()
                        .any(|element| element.name == part)
            })
            .count();
        if shared == 1 {
            terms.push((
                Signal::PartStroke {
                    port,
                    part: part.clone(),
                    order: random.below(3),
                },
                1.3,
            ));
            terms.push((Signal::PartForce { port, part }, -0.4));
        }
    }
    form(&terms)
}

struct Case {
    system: std::sync::Arc<quell_response::Assembly>,
    output: LinearForm,
    values: Vec<f64>,
    text: String,
    random: Random,
}

fn random_case(seed: u64, parts: bool, damped: bool) -> Case {
    let mut random = Random::new(seed + 1_000_000);
    let built = random_host(&mut random, damped, false);
    let built = random_port(&mut random, built);
    let mut built = random_port(&mut random, built);
    if random.unit() < 0.2 {
        let n = built.coordinates.len();
        let loss = faer::Mat::from_fn(n, n, |i, j| 0.02 * built.stiffness[(i, j)]);
        built.loss = Some(loss);
    }
    let texts: Vec<String> = (0..3)
        .map(|_| {
            let count = 1 + random.below(5);
            random_layout(&mut random, count)
        })
        .collect();
    let devices: Vec<(usize, &str)> = match random.below(4) {
        0 | 1 => vec![(0, &texts[0])],
        2 => vec![(0, &texts[0]), (1, &texts[1])],
        _ => vec![(0, &texts[0]), (0, &texts[1]), (1, &texts[2])],
    };
    let output = random_form(&mut random, &built, &devices, parts);
    let text = format!("seed {seed}: {devices:?} {output:?}");
    let system = assembly(built, &devices);
    let values = random_values(&mut random, &system, 1.5);
    Case {
        system,
        output,
        values,
        text,
        random,
    }
}

/// Tolerance 1e-10 of |H|, or of the largest |H| nearby where it has a zero.
#[test]
fn plan_agrees_with_the_stamped_system() {
    let mut worst = 0.0_f64;
    for seed in 0..3000 {
        let Case {
            system,
            output,
            values,
            text,
            mut random,
        } = random_case(seed, seed % 2 == 0, seed % 3 != 0);
        for index in 0..2 {
            let plan = Plan::new(
                &system,
                index,
                &output,
                (0.0, 20.0),
                PlanSettings {
                    points: 8,
                    ..PlanSettings::default()
                },
            )
            .unwrap_or_else(|error| panic!("{text}: {error}"));
            // Not lower: at rest a port between base and mass has a stroke that is left by cancellation, in both ways.
            let omegas: Vec<f64> = (0..6).map(|_| random.magnitude(1.0)).collect();
            let fast = plan.response(&values, &omegas);
            for (&omega, &fast) in omegas.iter().zip(&fast) {
                let exact = system
                    .direct_response(&values, index, &output, omega)
                    .unwrap();
                // Terms of an output can cancel: the size of the terms counts.
                let size: f64 = output
                    .terms
                    .iter()
                    .map(|term| {
                        system
                            .direct_response(
                                &values,
                                index,
                                &form(std::slice::from_ref(term)),
                                omega,
                            )
                            .unwrap()
                            .norm()
                    })
                    .sum();
                let error = (fast - exact).norm() / size.max(1e-30);
                worst = worst.max(error);
                assert!(
                    error < 1e-10,
                    "{text}: ω = {omega}: {fast} instead of {exact}"
                );
            }
        }
    }
    println!("plan against direct: worst relative difference {worst:e}");
}

/// The minimal realisation gives the same transfer functions.
///
/// Tolerance 1e-8 of the terms' size: derivatives of outputs and inputs pass through powers of A, which cancel by up to
/// (|A|/ω)² ≈ 1e5 here.
#[test]
fn realisation_agrees_with_the_stamped_system() {
    let mut worst = 0.0_f64;
    for seed in 0..3000 {
        let Case {
            system,
            output,
            values,
            text,
            mut random,
        } = random_case(seed, seed % 2 == 0, seed % 3 != 0);
        if system.host().loss.is_some() {
            continue;
        }
        let realisation = system.realise(&values).unwrap();
        assert_eq!(realisation.states(), system.predicted_modes(), "{text}");
        for index in 0..2 {
            for _ in 0..4 {
                let omega = random.magnitude(1.0);
                let exact = system
                    .direct_response(&values, index, &output, omega)
                    .unwrap();
                let found = realisation
                    .response(&system, &values, index, &output, omega)
                    .unwrap();
                let size: f64 = output
                    .terms
                    .iter()
                    .map(|term| {
                        system
                            .direct_response(
                                &values,
                                index,
                                &form(std::slice::from_ref(term)),
                                omega,
                            )
                            .unwrap()
                            .norm()
                    })
                    .sum();
                let error = (found - exact).norm() / size.max(1e-30);
                worst = worst.max(error);
                assert!(
                    error < 1e-8,
                    "{text}: ω = {omega}: {found} instead of {exact}"
                );
            }
        }
    }
    println!("realisation against direct: worst relative difference {worst:e}");
}

/// Exact gradients of the stamped system and of pieces against central differences.
///
/// Central differences with a relative step of 1e-5 have an error of about 1e-9 of the second-order terms and of
/// 1e-11 |H|/step: 1e-6 of the largest entry is asked for.
#[test]
fn gradients_agree_with_central_differences() {
    for seed in 0..400 {
        let Case {
            system,
            output,
            values,
            text,
            mut random,
        } = random_case(seed, seed % 2 == 0, true);
        let omega = random.magnitude(1.0);
        let mut gradient = vec![Complex64::ZERO; values.len()];
        system
            .direct_gradient(&values, 0, &output, omega, &mut gradient)
            .unwrap();
        let scale = gradient
            .iter()
            .zip(&values)
            .map(|(g, v)| g.norm() * v)
            .fold(1e-9, f64::max);
        for i in 0..values.len() {
            let shifted = |factor: f64| {
                let mut other = values.clone();
                other[i] *= factor;
                system.direct_response(&other, 0, &output, omega).unwrap()
            };
            let difference = (shifted(1.0 + 1e-5) - shifted(1.0 - 1e-5)) / 2e-5;
            let error = (difference - gradient[i] * values[i]).norm();
            let size = system
                .direct_response(&values, 0, &output, omega)
                .unwrap()
                .norm();
            assert!(
                error < 1e-6 * scale + 1e-9 * size,
                "{text}: element {i}: {difference} {}",
                gradient[i] * values[i]
            );
        }
    }
}

#[test]
fn gradients_of_pieces_are_those_of_the_peak() {
    let mut scratch = Scratch::new();
    for seed in 0..600 {
        let Case {
            system,
            output,
            values,
            text,
            ..
        } = random_case(seed, seed % 4 == 0, true);
        let plan = Plan::new(&system, 0, &output, (0.0, 20.0), PlanSettings::default()).unwrap();
        let mut pieces = Vec::new();
        plan.pieces(&values, 0.5, &mut scratch, &mut pieces)
            .unwrap();
        assert!(!pieces.is_empty(), "{text}");
        let peak = plan.peak(&values, &mut scratch);
        assert!(
            (peak.value / pieces[0].value - 1.0).abs() < 1e-8,
            "{text}: {peak:?} {:?}",
            pieces[0]
        );
        for piece in &pieces {
            // The same derivative by the adjoint of the stamped system.
            let mut gradient = vec![Complex64::ZERO; values.len()];
            let response = system
                .direct_gradient(&values, 0, &output, piece.omega, &mut gradient)
                .unwrap();
            assert!((response.norm() / piece.value - 1.0).abs() < 1e-9, "{text}");
            let scale = gradient
                .iter()
                .zip(&values)
                .map(|(g, v)| g.norm() * v)
                .fold(1e-30, f64::max);
            for i in 0..values.len() {
                let expected = (response.conj() * gradient[i]).re / response.norm();
                assert!(
                    (expected - piece.gradient[i]).abs() * values[i] < 1e-8 * scale,
                    "{text}: element {i}"
                );
            }
        }
    }
}

/// Re of the driving-point mobility is not negative, whatever passive devices are attached.
///
/// To rounding: 1e-12 |Y|, and near an undamped resonance what an error of 1e-13 in 1/Y gives, 1e-13 |Y|².
#[test]
fn driving_point_mobility_is_passive() {
    for seed in 0..1000 {
        let mut random = Random::new(seed + 5_000_000);
        let damped = random.unit() < 0.5;
        let built = random_host(&mut random, damped, false);
        let built = random_port(&mut random, built);
        let driven = (0..built.coordinates.len())
            .find(|&i| built.forcing[0][(i, 0)] == 1.0)
            .unwrap();
        let count = 1 + random.below(6);
        let text = random_layout(&mut random, count);
        let system = assembly(built, &[(0, &text)]);
        let values = random_values(&mut random, &system, 2.0);
        let plan = Plan::new(
            &system,
            0,
            &form(&[(coordinate(driven, 1), 1.0)]),
            (0.0, 100.0),
            PlanSettings {
                points: 8,
                ..PlanSettings::default()
            },
        )
        .unwrap();
        let omegas: Vec<f64> = (0..20).map(|_| random.magnitude(2.0)).collect();
        for (mobility, omega) in plan.response(&values, &omegas).iter().zip(&omegas) {
            assert!(
                mobility.re >= -1e-12 * mobility.norm() - 1e-13 * mobility.norm_sqr(),
                "seed {seed}: {text}: {mobility} at {omega}"
            );
        }
    }
}

#[test]
fn inputs_as_velocity_and_acceleration() {
    // A mass on a spring and a damper on a base: stroke over base acceleration = -m/(m s² + c s + k), finite at rest.
    let (m, c, k) = (2.0, 0.4, 9.0);
    for (kind, power) in [
        (InputKind::Displacement, 0),
        (InputKind::Velocity, 1),
        (InputKind::Acceleration, 2),
    ] {
        let built = host(matrix(&[&[m]]), matrix(&[&[c]]), matrix(&[&[k]]));
        let built = input(built, kind, [&[k], &[c], &[]]);
        let built = port(built, &[1.0], &[-1.0]);
        let system = assembly(built, &[(0, "k1 + c1")]);
        let values = [3.0, 0.2];
        let stroke = form(&[
            (coordinate(0, 0), 1.0),
            (Signal::Input { index: 0, order: 0 }, -1.0),
        ]);
        let plan = Plan::new(&system, 0, &stroke, (0.0, 10.0), PlanSettings::default()).unwrap();
        for omega in [1e-3, 0.5, 2.0, 7.0] {
            let s = Complex64::new(0.0, omega);
            let device = 1.0 / (1.0 / values[0] + 1.0 / (values[1] * s));
            let expected = -m * s.powi(2) / (m * s * s + c * s + k + device) / s.powi(power);
            for found in [
                system.direct_response(&values, 0, &stroke, omega).unwrap(),
                plan.response(&values, &[omega])[0],
                system
                    .realise(&values)
                    .unwrap()
                    .response(&system, &values, 0, &stroke, omega)
                    .unwrap(),
            ] {
                // At rest the difference of two nearly equal displacements remains: 1e-16/ω² of it.
                let allowed = 1e-11 + 1e-14 / (omega * omega);
                assert!(
                    (found - expected).norm() < allowed * expected.norm(),
                    "{kind:?} {omega}: {found} {expected}"
                );
            }
        }
    }
}

#[test]
fn denser_grids_are_added_where_asked() {
    let built = port(
        input(
            host(matrix(&[&[1.0]]), matrix(&[&[0.1]]), matrix(&[&[1.0]])),
            InputKind::Force,
            [&[1.0], &[], &[]],
        ),
        &[1.0],
        &[0.0],
    );
    let system = assembly(built, &[(0, "k")]);
    let mut plan = Plan::new(
        &system,
        0,
        &form(&[(coordinate(0, 0), 1.0)]),
        (0.1, 9.0),
        PlanSettings::default(),
    )
    .unwrap();
    let before = plan.omegas().len();
    plan.add_frequencies(&[3.3, 100.0, 3.3, f64::NAN]).unwrap();
    assert_eq!(plan.omegas().len(), before + 1);
    assert_eq!(plan.band(), (0.1, 9.0));
}
