//! Failures are values with words.

use std::sync::Arc;

use quell_model::linear::{InputKind, Signal};
use quell_response::{Assembly, Attached, Plan, PlanSettings, ResponseError, h2, h2_fast};

use crate::harness::{assembly, coordinate, form, host, input, matrix, network, port};

fn plain() -> quell_model::linear::LinearHost {
    let built = host(matrix(&[&[1.0]]), matrix(&[&[0.1]]), matrix(&[&[4.0]]));
    port(
        input(built, InputKind::Force, [&[1.0], &[], &[]]),
        &[1.0],
        &[0.0],
    )
}

#[test]
fn hosts_that_do_not_fit() {
    let mut shape = plain();
    shape.damping = matrix(&[&[0.1, 0.2]]);
    assert!(matches!(
        Assembly::new(Arc::new(shape), vec![]),
        Err(ResponseError::Shape { .. })
    ));
    let mut finite = plain();
    finite.stiffness[(0, 0)] = f64::NAN;
    assert!(matches!(
        Assembly::new(Arc::new(finite), vec![]),
        Err(ResponseError::NotFinite { .. })
    ));
    let unsymmetric = host(
        matrix(&[&[1.0, 0.3], &[0.1, 1.0]]),
        matrix(&[&[0.0, 0.0], &[0.0, 0.0]]),
        matrix(&[&[1.0, 0.0], &[0.0, 1.0]]),
    );
    assert!(matches!(
        Assembly::new(Arc::new(unsymmetric), vec![]),
        Err(ResponseError::UnsymmetricMass { .. })
    ));
    let device = Attached {
        port: 3,
        network: network("k"),
    };
    assert!(matches!(
        Assembly::new(Arc::new(plain()), vec![device]),
        Err(ResponseError::UnknownPort { .. })
    ));
}

#[test]
fn a_coordinate_that_nothing_holds_is_named() {
    let floating = host(
        matrix(&[&[1.0, 0.0], &[0.0, 0.0]]),
        matrix(&[&[0.0, 0.0], &[0.0, 0.0]]),
        matrix(&[&[4.0, 0.0], &[0.0, 0.0]]),
    );
    let floating = port(floating, &[0.0, 1.0], &[]);
    let error = Assembly::new(Arc::new(floating.clone()), vec![]).unwrap_err();
    assert!(error.to_string().contains("`x2`"), "{error}");
    // A device of whatever kind holds it.
    for (text, modes) in [("k", 2), ("c", 3), ("b", 4)] {
        let system = assembly(floating.clone(), &[(0, text)]);
        assert_eq!(system.predicted_modes(), modes, "{text}");
        assert_eq!(system.modes(&[0.5]).unwrap().count(), modes);
    }
}

#[test]
fn gyroscopic_coupling_into_a_massless_coordinate() {
    let built = host(
        matrix(&[&[1.0, 0.0], &[0.0, 0.0]]),
        matrix(&[&[0.0, 0.5], &[-0.5, 0.0]]),
        matrix(&[&[4.0, 0.0], &[0.0, 1.0]]),
    );
    let error = Assembly::new(Arc::new(built), vec![]).unwrap_err();
    assert!(
        matches!(error, ResponseError::UnsymmetricDamping { .. }),
        "{error}"
    );
}

#[test]
fn values_signals_and_bands() {
    let system = assembly(plain(), &[(0, "k1 | c1")]);
    let output = form(&[(coordinate(0, 0), 1.0)]);
    assert!(matches!(
        system.modes(&[1.0]),
        Err(ResponseError::ValueCount { .. })
    ));
    assert!(matches!(
        system.modes(&[1.0, f64::NAN]),
        Err(ResponseError::ElementValue { .. })
    ));
    assert!(matches!(
        system.modes(&[1.0, -1.0]),
        Err(ResponseError::ElementValue { .. })
    ));
    assert!(
        system
            .direct_response(&[1.0, 1.0], 4, &output, 1.0)
            .is_err()
    );
    let unknown = form(&[(
        Signal::PartStroke {
            port: 0,
            part: "k7".into(),
            order: 0,
        },
        1.0,
    )]);
    let error = system
        .direct_response(&[1.0, 1.0], 0, &unknown, 1.0)
        .unwrap_err();
    assert!(error.to_string().contains("`k1`"), "{error}");
    for band in [
        (3.0, 1.0),
        (-1.0, 1.0),
        (0.0, f64::INFINITY),
        (f64::NAN, 1.0),
        (0.0, 0.0),
    ] {
        assert!(matches!(
            Plan::new(&system, 0, &output, band, PlanSettings::default()),
            Err(ResponseError::Band { .. })
        ));
    }
    let plan = Plan::new(&system, 0, &output, (0.0, 3.0), PlanSettings::default()).unwrap();
    assert!(
        plan.peak(&[1.0], &mut quell_response::Scratch::new())
            .value
            .is_nan()
    );
}

#[test]
fn variances_that_do_not_exist() {
    let system = assembly(plain(), &[(0, "c1")]);
    // The acceleration of a mass under white force noise.
    let acceleration = form(&[(coordinate(0, 2), 1.0)]);
    assert!(matches!(
        h2(&system, &[0.1], 0, &acceleration, None, None),
        Err(ResponseError::NotStrictlyProper { .. })
    ));
    assert!(matches!(
        h2_fast(&system, &[0.1], 0, &acceleration),
        Err(ResponseError::NotStrictlyProper { .. })
    ));
    assert!(h2(&system, &[0.1], 0, &acceleration, Some((0.0, 50.0)), None).is_ok());
    let undamped = input(
        host(matrix(&[&[1.0]]), matrix(&[&[0.0]]), matrix(&[&[4.0]])),
        InputKind::Force,
        [&[1.0], &[], &[]],
    );
    let undamped = assembly(undamped, &[]);
    let output = form(&[(coordinate(0, 0), 1.0)]);
    assert!(matches!(
        h2(&undamped, &[], 0, &output, None, None),
        Err(ResponseError::Undamped { .. })
    ));
    assert!(h2_fast(&undamped, &[], 0, &output).is_err());
    let negative = input(
        host(matrix(&[&[1.0]]), matrix(&[&[-0.2]]), matrix(&[&[4.0]])),
        InputKind::Force,
        [&[1.0], &[], &[]],
    );
    let negative = assembly(negative, &[]);
    assert!(matches!(
        h2(&negative, &[], 0, &output, None, None),
        Err(ResponseError::Unstable { .. })
    ));
    assert!(matches!(
        h2_fast(&negative, &[], 0, &output),
        Err(ResponseError::Unstable { .. })
    ));
}

#[test]
fn a_drifting_output_of_an_acceleration_is_refused() {
    let built = host(matrix(&[&[1.0]]), matrix(&[&[0.1]]), matrix(&[&[4.0]]));
    let built = input(built, InputKind::Acceleration, [&[4.0], &[0.1], &[]]);
    let system = assembly(built, &[]);
    let absolute = form(&[(coordinate(0, 0), 1.0)]);
    assert!(matches!(
        h2(&system, &[], 0, &absolute, None, None),
        Err(ResponseError::PoleAtZero { .. })
    ));
    let own = form(&[(coordinate(0, 2), 1.0)]);
    assert!(
        system
            .realise(&[])
            .unwrap()
            .response(&system, &[], 0, &own, 1.0)
            .is_ok()
    );
}
