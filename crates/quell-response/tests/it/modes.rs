//! Modes: their number, their place and their independence of artefacts.

use num_complex::Complex64;
use quell_model::linear::InputKind;
use quell_response::ModeKind;

use crate::harness::{
    Random, assembly, host, input, matrix, network, port, random_host, random_layout, random_port,
    random_values,
};

type Polynomial = Vec<f64>;

fn add(a: &[f64], b: &[f64], factor: f64) -> Polynomial {
    (0..a.len().max(b.len()))
        .map(|i| a.get(i).copied().unwrap_or(0.0) + factor * b.get(i).copied().unwrap_or(0.0))
        .collect()
}

fn multiply(a: &[f64], b: &[f64]) -> Polynomial {
    let mut product = vec![0.0; a.len() + b.len() - 1];
    for (i, x) in a.iter().enumerate() {
        for (j, y) in b.iter().enumerate() {
            product[i + j] += x * y;
        }
    }
    product
}

/// Determinant of a matrix of polynomials by expansion.
fn determinant(entries: &[Vec<Polynomial>]) -> Polynomial {
    if entries.len() == 1 {
        return entries[0][0].clone();
    }
    let mut sum = vec![0.0];
    for j in 0..entries.len() {
        let minor: Vec<Vec<Polynomial>> = entries[1..]
            .iter()
            .map(|row| {
                row.iter()
                    .enumerate()
                    .filter(|(k, _)| *k != j)
                    .map(|(_, entry)| entry.clone())
                    .collect()
            })
            .collect();
        let sign = if j % 2 == 0 { 1.0 } else { -1.0 };
        sum = add(&sum, &multiply(&entries[0][j], &determinant(&minor)), sign);
    }
    sum
}

fn evaluate(polynomial: &[f64], s: Complex64) -> Complex64 {
    polynomial
        .iter()
        .rev()
        .fold(Complex64::ZERO, |sum, &c| sum * s + c)
}

/// The promise: the predicted number of modes, none growing, and the characteristic polynomial of rational
/// arithmetic det Z · Den + (det(Z + h hᵀ) - det Z) · N.
///
/// Tolerances: growth within 1e-9 of |A| (a double zero that rounding splits moves by √ε of its neighbourhood; undamped
/// pairs of high-order devices lose about 1e-12 |A|); the polynomial is compared in the right half plane, where all its
/// factors are bounded away from zero, to what an absolute error of 1e-10 |A| in every eigenvalue gives.
#[test]
fn random_devices_have_the_predicted_modes() {
    let mut worst_growth = 0.0_f64;
    let mut worst_polynomial = 0.0_f64;
    for seed in 0..6000 {
        let mut random = Random::new(seed);
        let damped = random.unit() < 0.5;
        let free = random.unit() < 0.2;
        let built = random_host(&mut random, damped, free);
        let built = random_port(&mut random, built);
        let n = built.coordinates.len();
        let count = 1 + random.below(6);
        let text = random_layout(&mut random, count);
        let device = network(&text);
        let reference = built.clone();
        let system = assembly(built, &[(0, &text)]);
        let values = random_values(&mut random, &system, 1.5);
        let predicted = 2 * n + device.order().poles;
        assert_eq!(system.predicted_modes(), predicted, "seed {seed}: {text}");
        let modes = system
            .modes(&values)
            .unwrap_or_else(|error| panic!("seed {seed}: {text}: {error}"));
        assert_eq!(modes.count(), predicted, "seed {seed}: {text}");
        let growth = modes.growth().unwrap_or(0.0) / modes.scale.max(1e-30);
        assert!(
            growth < 1e-9,
            "seed {seed}: {text}: growth {growth:e} of |A|"
        );
        worst_growth = worst_growth.max(growth);

        // det(Z + x h hᵀ) is linear in x, so the characteristic polynomial needs two determinants of the host.
        let h = &reference.ports[0].coordinates;
        let entry = |i: usize, j: usize, extra: f64| {
            vec![
                reference.stiffness[(i, j)] + extra * h[i] * h[j],
                reference.damping[(i, j)],
                reference.mass[(i, j)],
            ]
        };
        let build = |extra: f64| -> Polynomial {
            let rows: Vec<Vec<Polynomial>> = (0..n)
                .map(|i| (0..n).map(|j| entry(i, j, extra)).collect())
                .collect();
            determinant(&rows)
        };
        let (bare, held) = (build(0.0), build(1.0));
        let slope = add(&held, &bare, -1.0);
        let admittance = device.admittance(&values);
        let mut numerator = admittance.numerator.clone();
        numerator.insert(0, 0.0);
        let mut denominator = admittance.denominator.clone();
        if denominator[0] == 0.0 {
            numerator.remove(0);
            denominator.remove(0);
        }
        let mut characteristic = add(
            &multiply(&bare, &denominator),
            &multiply(&slope, &numerator),
            1.0,
        );
        let largest = characteristic.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        while characteristic
            .last()
            .is_some_and(|last| last.abs() < 1e-14 * largest)
            && characteristic.len() > predicted + 1
        {
            characteristic.pop();
        }
        assert_eq!(
            characteristic.len(),
            predicted + 1,
            "seed {seed}: {text}: {characteristic:?}"
        );
        let leading = characteristic[predicted];
        let eigenvalues = modes.eigenvalues();
        for centre in eigenvalues.iter().filter(|value| value.norm() > 0.0) {
            for angle in [0.0, 0.7, 1.4] {
                let s = Complex64::from_polar(centre.norm(), angle);
                let product = eigenvalues
                    .iter()
                    .fold(Complex64::new(leading, 0.0), |p, value| p * (s - value));
                let expected = evaluate(&characteristic, s);
                let allowed: f64 = eigenvalues
                    .iter()
                    .map(|value| 1e-10 * modes.scale / (s - value).norm())
                    .sum();
                // Coefficients of the reference cancel in det(Z + h hᵀ) - det Z themselves.
                let magnitude: f64 = characteristic
                    .iter()
                    .enumerate()
                    .map(|(k, c)| c.abs() * s.norm().powf(k as f64))
                    .sum();
                let error = (product - expected).norm() / magnitude;
                worst_polynomial = worst_polynomial.max(error / (1e-9 + allowed));
                assert!(
                    error < 1e-9 + allowed,
                    "seed {seed}: {text}: at {s} {product} instead of {expected}; {eigenvalues:?}"
                );
            }
        }
    }
    println!(
        "worst growth {worst_growth:e} |A|, worst polynomial {worst_polynomial:e} of what is allowed"
    );
}

/// Values over eight decades: the number of modes does not depend on them, and none grows.
#[test]
fn extreme_values_change_no_rank() {
    for seed in 0..1500 {
        let mut random = Random::new(seed + 31_000_000);
        let built = random_host(&mut random, true, false);
        let built = random_port(&mut random, built);
        let count = 1 + random.below(6);
        let text = random_layout(&mut random, count);
        let system = assembly(built, &[(0, &text)]);
        let values = random_values(&mut random, &system, 4.0);
        let modes = system.modes(&values).unwrap();
        assert_eq!(
            modes.count(),
            system.predicted_modes(),
            "seed {seed}: {text}"
        );
        // Rounding of undamped pairs: 1e-14 of |A|, which spans eight decades here.
        assert!(
            modes.growth().unwrap() < 1e-14 * modes.scale,
            "seed {seed}: {text}"
        );
    }
}

/// Several devices, also two on one port: predicted numbers add up, nothing grows.
#[test]
fn several_devices_add_their_orders() {
    for seed in 0..1500 {
        let mut random = Random::new(seed + 77_000);
        let damped = random.unit() < 0.5;
        let built = random_host(&mut random, damped, false);
        let built = random_port(&mut random, built);
        let built = random_port(&mut random, built);
        let n = built.coordinates.len();
        let texts: Vec<String> = (0..3)
            .map(|_| {
                let count = 1 + random.below(4);
                random_layout(&mut random, count)
            })
            .collect();
        let system = assembly(built, &[(0, &texts[0]), (1, &texts[1]), (1, &texts[2])]);
        let values = random_values(&mut random, &system, 1.5);
        let predicted = 2 * n
            + texts
                .iter()
                .map(|text| network(text).order().poles)
                .sum::<usize>();
        assert_eq!(
            system.predicted_modes(),
            predicted,
            "seed {seed}: {texts:?}"
        );
        let modes = system.modes(&values).unwrap();
        assert_eq!(modes.count(), predicted);
        assert!(
            modes.growth().unwrap() < 1e-9 * modes.scale,
            "seed {seed}: {texts:?}"
        );
    }
}

#[test]
fn undamped_pair_of_masses_that_floats() {
    // Two masses m1, m2 with a spring: ω² = k (1/m1 + 1/m2) and a rigid body that drifts.
    let built = host(
        matrix(&[&[2.0, 0.0], &[0.0, 3.0]]),
        matrix(&[&[0.0, 0.0], &[0.0, 0.0]]),
        matrix(&[&[50.0, -50.0], &[-50.0, 50.0]]),
    );
    let built = port(built, &[1.0, -1.0], &[]);
    let system = assembly(built.clone(), &[]);
    let modes = system.modes(&[]).unwrap();
    assert_eq!(system.predicted_rigid_body_modes(), 2);
    let kinds: Vec<ModeKind> = modes.modes.iter().map(|mode| mode.kind).collect();
    assert_eq!(
        kinds,
        [
            ModeKind::RigidBody,
            ModeKind::RigidBody,
            ModeKind::Oscillatory
        ]
    );
    let omega = (50.0_f64 * (0.5 + 1.0 / 3.0)).sqrt();
    assert!((modes.modes[2].eigenvalue.im / omega - 1.0).abs() < 1e-13);
    for value in &modes.modes[0].shape {
        assert!((value - Complex64::ONE).norm() < 1e-12);
    }
    // A device in between changes nothing for the rigid body; one to ground through a damper ends its drift.
    let between = assembly(built.clone(), &[(0, "c + b | k")]);
    assert_eq!(between.predicted_rigid_body_modes(), 2);
    let grounded = port(built, &[1.0, 0.0], &[]);
    let braked = assembly(grounded, &[(1, "c")]);
    assert_eq!(braked.predicted_rigid_body_modes(), 1);
    let modes = braked.modes(&[0.3]).unwrap();
    assert_eq!(modes.count(), 4);
    assert!(modes.growth().unwrap() < 0.0);
    assert_eq!(
        modes
            .modes
            .iter()
            .filter(|mode| mode.kind == ModeKind::RigidBody)
            .count(),
        1
    );
}

#[test]
fn massless_coordinates_are_algebraic_or_first_order() {
    // x1 with mass, x2 without: a spring between, a damper from x2 to ground: m s² + k c s/(k + c s) = 0.
    let built = host(
        matrix(&[&[1.5, 0.0], &[0.0, 0.0]]),
        matrix(&[&[0.0, 0.0], &[0.0, 0.7]]),
        matrix(&[&[4.0, -4.0], &[-4.0, 4.0]]),
    );
    let system = assembly(built, &[]);
    assert_eq!(system.predicted_modes(), 3);
    let modes = system.modes(&[]).unwrap();
    // One zero (nothing holds the displacement), the others of m c s² + m k s + k c = 0.
    assert_eq!(modes.modes[0].kind, ModeKind::RigidBody);
    let sum: Complex64 = modes.eigenvalues().iter().sum();
    let product = modes
        .eigenvalues()
        .iter()
        .filter(|value| value.norm() > 0.0)
        .product::<Complex64>();
    assert!(
        (sum.re + 4.0 / 0.7).abs() < 1e-12 && sum.im.abs() < 1e-12,
        "{sum}"
    );
    assert!((product.re - 4.0 / 1.5).abs() < 1e-12);
}

#[test]
fn damping_ratio_and_frequency_of_one_degree_of_freedom() {
    let built = host(matrix(&[&[2.0]]), matrix(&[&[0.4]]), matrix(&[&[8.0]]));
    let built = input(built, InputKind::Force, [&[1.0], &[], &[]]);
    let modes = assembly(built, &[]).modes(&[]).unwrap();
    let mode = &modes.modes[0];
    assert!((mode.frequency_hz - 2.0 / std::f64::consts::TAU).abs() < 1e-14);
    assert!((mode.damping_ratio - 0.05).abs() < 1e-14);
    assert_eq!((modes.modes.len(), modes.count()), (1, 2));
    assert_eq!(modes.least_damping(true), Some(mode.damping_ratio));
}
