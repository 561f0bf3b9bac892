//! Functions in Rust: recorded, differenced.

use quell_expression::{Exactness, FiniteDifferences, Real, Recorded, VectorFunction, record};

fn model<R: Real>(x: &[R]) -> Vec<R> {
    let mut sum = R::from(0.5);
    for (index, value) in x.iter().enumerate() {
        sum = sum + *value * (index as f64 + 1.0);
    }
    let stop = x[0].select(R::from(0.2), R::from(0.0), (x[0] - 0.2) * 7.0);
    vec![
        sum.sin() * x[1] - x[0] / x[1],
        stop + (-x[0]).exp().max(x[1]) + x[0].hypot(x[1]),
        x[1].powi(3) + x[1].powf(x[0]) + x[1].sqrt().atan2(x[0]),
    ]
}

#[test]
fn one_function_serves_numbers_and_symbols() {
    let mut function = record(2, model).compile();
    assert_eq!((function.inputs(), function.outputs()), (2, 3));
    assert_eq!(function.exactness(), Exactness::Exact);
    let plain = |x: &[f64], y: &mut [f64]| y.copy_from_slice(&model(x));
    let mut differences = FiniteDifferences::new(plain, vec![1.0; 2], 3);
    assert_eq!(differences.exactness(), Exactness::Approximate);
    for point in [[0.1, 0.7], [0.6, 1.3], [-0.4, 2.2]] {
        let (mut values, mut slopes) = ([0.0; 3], [0.0; 6]);
        function.jacobian(&point, &mut values, &mut slopes);
        assert_eq!(values.as_slice(), model(&point));
        let mut again = [0.0; 3];
        function.value(&point, &mut again);
        assert_eq!(again, values);
        let (mut others, mut approximate) = ([0.0; 3], [0.0; 6]);
        differences.jacobian(&point, &mut others, &mut approximate);
        assert_eq!(others, values);
        for (exact, near) in slopes.iter().zip(approximate) {
            // ε^⅔ is 4e-11; third derivatives are of order 10.
            assert!((exact - near).abs() < 1e-8, "{slopes:?} {approximate:?}");
        }
    }
}

#[test]
fn symbols_that_outlive_their_recording_are_not_numbers() {
    let mut kept: Option<Recorded> = None;
    record(1, |x| {
        kept = Some(x[0]);
        // A recording within a recording.
        let inner = record(1, |y| vec![y[0] + x[0]]);
        assert!(inner.graph.values(&inner.outputs, &[1.0])[0].is_nan());
        vec![x[0] * 2.0]
    });
    let other = record(1, |x| vec![x[0] + kept.unwrap(), x[0] * 3.0]);
    let values = other.graph.values(&other.outputs, &[2.0]);
    assert!(values[0].is_nan());
    assert_eq!(values[1], 6.0);
    assert!(format!("{:?}", kept.unwrap() + 1.0).contains("NaN"));
}
