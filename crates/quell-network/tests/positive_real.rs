//! The test of positive-realness against known functions, closed forms and random networks.
#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

use num_complex::Complex64;
use proptest::prelude::*;
use quell_network::{
    Budget, Domain, Enumeration, Equivalence, Kinds, Layout, NearestError, Network,
    POSITIVE_REAL_TOLERANCE, RationalFunction, Violation,
};

/// From coefficients with the highest power first, as papers print them.
fn function(numerator: &[f64], denominator: &[f64]) -> RationalFunction {
    let reversed = |c: &[f64]| c.iter().rev().copied().collect::<Vec<f64>>();
    RationalFunction::new(reversed(numerator), reversed(denominator)).unwrap()
}

fn is_positive_real(function: &RationalFunction) -> bool {
    function
        .positive_real(POSITIVE_REAL_TOLERANCE)
        .is_positive_real()
}

#[test]
fn boundary_cases_are_right() {
    let yes: &[(&[f64], &[f64])] = &[
        // A minimum function: Re = (ω² - 2)²/|.|².
        (&[1.0, 1.0, 1.0], &[1.0, 1.0, 4.0]),
        (&[1.0, 1.0, 4.0], &[1.0, 1.0, 1.0]),
        // Elements, their duals and zero.
        (&[1.0], &[1.0, 0.0]),
        (&[1.0, 0.0], &[1.0]),
        (&[3.0], &[1.0]),
        (&[0.0], &[1.0]),
        // Lossless: poles and zeros on the axis, interlacing.
        (&[1.0, 0.0, 1.0], &[1.0, 0.0, 2.0, 0.0]),
        (&[1.0, 0.0, 4.0, 0.0, 3.0], &[1.0, 0.0, 2.0, 0.0]),
        (&[1.0, 0.0], &[1.0, 0.0, 1.0]),
        // A pole pair on the axis beside a damper, and its reciprocal: zeros on the axis.
        (&[1.0, 1.0, 1.0], &[1.0, 0.0, 1.0]),
        (&[1.0, 0.0, 1.0], &[1.0, 1.0, 1.0]),
        // Re Y = 0 at 0 and at infinity.
        (&[1.0, 0.0], &[1.0, 1.0, 1.0]),
        // A common factor on the axis, and one in the right half-plane, are none of the function's.
        (&[1.0, 1.0, 1.0, 1.0], &[1.0, 2.0, 1.0, 2.0]),
        (&[1.0, 0.0, -1.0], &[1.0, 1.0, -2.0]),
    ];
    for (n, d) in yes {
        let y = function(n, d);
        let verdict = y.positive_real(POSITIVE_REAL_TOLERANCE);
        assert!(verdict.is_positive_real(), "{y}: {verdict}");
        assert!(y.is_zero() || is_positive_real(&y.reciprocal()), "1/({y})");
    }
    let no: &[(&[f64], &[f64])] = &[
        // A hair beyond the minimum functions.
        (&[1.0, 1.0, 1.0], &[1.0, 0.9999, 4.0]),
        (&[1.0, 0.999_999, 1.0], &[1.0, 1.0, 4.0]),
        (&[-1.0], &[1.0]),
        (&[-1.0], &[1.0, 0.0]),
        (&[-1.0, 0.0], &[1.0]),
        // Double poles at 0, at infinity, and on the axis.
        (&[1.0], &[1.0, 0.0, 0.0]),
        (&[1.0, 0.0, 0.0], &[1.0]),
        (&[1.0, 0.0, 0.0, 0.0], &[1.0, 0.0, 2.0, 0.0, 1.0]),
        // Poles and zeros on the axis that do not interlace.
        (&[1.0, 0.0, 4.0], &[1.0, 0.0, 2.0, 0.0]),
        // All-pass, and poles to the right.
        (&[-1.0, 1.0], &[1.0, 1.0]),
        (&[1.0, 1.0], &[1.0, -1.0]),
        (&[1.0, -1.0, 1.0], &[1.0, 1.0, 1.0]),
        // A residue that is not real.
        (&[1.0], &[1.0, 0.0, 1.0]),
    ];
    for (n, d) in no {
        let y = function(n, d);
        assert!(!is_positive_real(&y), "{y}");
        assert!(!is_positive_real(&y.reciprocal()), "1/({y})");
    }
}

/// (A s² + B s + C)/(D s² + E s + F) with coefficients at least zero is positive-real if and only if
/// B E ≥ (√(A F) - √(C D))² (Chen and Smith 2009).
#[test]
fn biquadratics_follow_their_closed_form() {
    let values = [0.0, 0.3, 1.0, 2.5];
    let mut on_boundary = 0;
    for index in 0..4_usize.pow(6) {
        let [a, b, c, d, e, f] = [0, 1, 2, 3, 4, 5].map(|i| values[index / 4_usize.pow(i) % 4]);
        if [a, b, c] == [0.0; 3] || [d, e, f] == [0.0; 3] {
            continue;
        }
        let y = function(&[a, b, c], &[d, e, f]);
        let margin = b * e - ((a * f).sqrt() - (c * d).sqrt()).powi(2);
        if margin.abs() < 1e-12 {
            on_boundary += 1;
        }
        // Where N and D share a factor the closed form is that of the reduced function as well.
        assert_eq!(
            is_positive_real(&y),
            margin > -1e-12,
            "{y}: margin {margin}"
        );
    }
    assert!(on_boundary > 100);
}

#[test]
fn failures_say_where_and_by_how_much() {
    let verdict = |n: &[f64], d: &[f64]| function(n, d).positive_real(POSITIVE_REAL_TOLERANCE);
    // Re = (x² - 4.5 x + 4)/|.|²: negative between the roots of that polynomial.
    let found = verdict(&[1.0, 0.5, 1.0], &[1.0, 1.0, 4.0]);
    let [
        Violation::RealPart {
            omega,
            real_part,
            band,
        },
    ] = found.violations.as_slice()
    else {
        panic!("{found}");
    };
    let edges = [-1.0, 1.0]
        .map(|sign: f64| f64::midpoint(4.5, sign * (4.5_f64.powi(2) - 16.0).sqrt()).sqrt());
    assert!((band.0 - edges[0]).abs() < 1e-9 && (band.1 - edges[1]).abs() < 1e-9);
    let y = function(&[1.0, 0.5, 1.0], &[1.0, 1.0, 4.0]);
    let re = |w: f64| y.evaluate(Complex64::new(0.0, w)).re;
    let on_grid = (0..200_000)
        .map(|i| re(f64::from(i) * 1e-4))
        .fold(f64::INFINITY, f64::min);
    assert!((on_grid - real_part).abs() < 1e-8 && (re(*omega) - real_part).abs() < 1e-14);
    let found = verdict(&[1.0, 1.0], &[1.0, -1.0]);
    assert!(found.violations.contains(&Violation::UnstablePole {
        pole: Complex64::from(1.0)
    }));
    let found = verdict(&[1.0, 0.0, 4.0], &[1.0, 0.0, 2.0, 0.0]);
    assert!(
        matches!(found.violations[..], [Violation::Residue { omega, residue }]
        if (omega - 2.0_f64.sqrt()).abs() < 1e-12 && (residue.re + 0.5).abs() < 1e-12),
        "{found}"
    );
    let found = verdict(&[1.0], &[1.0, 0.0, 0.0]);
    assert!(matches!(
        found.violations[..],
        [
            Violation::MultiplePole {
                omega: 0.0,
                multiplicity: 2
            },
            ..
        ]
    ));
    assert!(found.to_string().contains("2-fold"), "{found}");
    let found = verdict(&[1.0, 0.0, 0.0, 0.0], &[1.0, 0.0, 2.0, 0.0, 1.0]);
    assert!(
        matches!(
            found.violations[..],
            [
                Violation::MultiplePole {
                    multiplicity: 2,
                    ..
                },
                ..
            ]
        ),
        "{found}"
    );
}

#[test]
fn the_nearest_is_a_damper_away() {
    let y = function(&[1.0, 0.5, 1.0], &[1.0, 1.0, 4.0]);
    let verdict = y.positive_real(POSITIVE_REAL_TOLERANCE);
    let nearest = y.nearest_positive_real(POSITIVE_REAL_TOLERANCE).unwrap();
    assert!(is_positive_real(&nearest.function));
    assert_eq!(nearest.distance, -verdict.least_real_part);
    assert_eq!(nearest.bound, nearest.distance);
    // Every frequency is as far.
    for omega in [0.0, 0.7, 3.0] {
        let s = Complex64::new(0.0, omega);
        let difference = (nearest.function.evaluate(s) - y.evaluate(s)).norm();
        assert!((difference - nearest.distance).abs() < 1e-9);
    }
    let unstable = function(&[1.0, 1.0], &[1.0, -0.1, 1.0]);
    let nearest = unstable
        .nearest_positive_real(POSITIVE_REAL_TOLERANCE)
        .unwrap();
    assert!(is_positive_real(&nearest.function));
    assert!(nearest.bound <= nearest.distance);
    assert!(matches!(
        function(&[1.0], &[1.0, 0.0, 0.0]).nearest_positive_real(POSITIVE_REAL_TOLERANCE),
        Err(NearestError::AxisPole(_))
    ));
    let passive = function(&[1.0, 1.0], &[1.0, 2.0]);
    assert_eq!(
        passive
            .nearest_positive_real(POSITIVE_REAL_TOLERANCE)
            .unwrap()
            .function,
        passive
    );
}

proptest! {
    /// Every network's admittance is positive-real, and so is its dual's; a damper less than none makes it fail.
    #[test]
    fn networks_are_positive_real(
        k in 0_usize..4, c in 0_usize..4, b in 0_usize..4, at in 0.0..1.0_f64,
        logs in prop::collection::vec(-1.5..1.5_f64, 9), scale in -4.0..4.0_f64,
    ) {
        let budgets = [Budget::exactly("k", k), Budget::exactly("c", c), Budget::exactly("b", b)];
        let all = Enumeration::new(&Kinds::new(Domain::Translational), &budgets, None, Equivalence::Irreducible).unwrap();
        prop_assume!(all.count() > 0);
        let index = ((all.count() as f64 * at) as u128).min(all.count() - 1);
        let layout = all.nth(index).unwrap();
        let values: Vec<f64> = logs.iter().map(|x| 10_f64.powf(x + scale)).collect();
        let network = Network::from_layout(&layout, None).unwrap();
        let y = network.admittance(&values);
        let verdict = y.positive_real(POSITIVE_REAL_TOLERANCE);
        prop_assert!(verdict.is_positive_real(), "{layout} {y}: {verdict}");
        prop_assert!(is_positive_real(&y.reciprocal()));
        // Subtract a damper larger than the least real part.
        let (omega, least) = (verdict.at, verdict.least_real_part);
        if omega.is_finite() {
            let size = y.scales().size;
            let less = y.plus(&RationalFunction::constant(least + 1e-3 * size), -1.0);
            // Next to a zero close to a pole the terms of N and D cancel: only rounding itself is forgiven here, and only where
            // less than seven digits cancel.
            let s = Complex64::new(0.0, omega);
            let magnitude = y.denominator.iter().enumerate()
                .map(|(power, d)| d.abs() * omega.powi(i32::try_from(power).unwrap())).sum::<f64>();
            let value = y.denominator.iter().rev().fold(Complex64::ZERO, |sum, d| sum * s + d).norm();
            prop_assert!(
                value < 1e-4 * magnitude || !less.positive_real(1e-13).is_positive_real(),
                "{layout} {y} at {omega}"
            );
        }
    }
}

#[test]
fn a_layout_of_many_decades() {
    let layout = Layout::parse(
        "k1 | c1 + (b1 | k2 + c2)",
        &Kinds::new(Domain::Translational),
    )
    .unwrap();
    let network = Network::from_layout(&layout, None).unwrap();
    let y = network.admittance(&[1.9e5, 7.4e3, 13.0, 2e7, 5.0]);
    assert!(is_positive_real(&y));
}
