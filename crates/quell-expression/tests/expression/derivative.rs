//! Tapes against `evaluate`, and their derivatives against differences.

use proptest::prelude::*;
use quell_expression::{Expression, NoNames, Quantity, Tape, TapeBuilder};

use super::random::differentiable;

fn inputs() -> Vec<String> {
    vec!["x".to_owned(), "y".to_owned()]
}

fn constants() -> Vec<(String, Quantity)> {
    vec![("a".to_owned(), Quantity::number(0.7))]
}

fn tape(expression: &Expression) -> Option<Tape> {
    let mut builder = TapeBuilder::new(&inputs());
    builder.add(expression, &constants()).ok()?;
    Some(builder.build())
}

fn value(tape: &Tape, at: [f64; 2]) -> f64 {
    let mut output = [f64::NAN];
    tape.evaluate(&at, &mut Vec::new(), &mut output);
    output[0]
}

fn slopes(tape: &Tape, at: [f64; 2]) -> (f64, [f64; 2]) {
    let (mut output, mut slopes) = ([f64::NAN], [f64::NAN; 2]);
    tape.jacobian(&at, &mut Vec::new(), &mut output, &mut slopes);
    (output[0], slopes)
}

/// Ridders' extrapolation of central differences (C. J. F. Ridders, 1982): the slope and an estimate of its error.
fn difference(of: impl Fn(f64) -> f64, at: f64) -> (f64, f64) {
    const ROWS: usize = 8;
    let central = |step: f64| {
        // The step that is really taken, after rounding.
        let (above, below) = (at + step, at - step);
        (of(above) - of(below)) / (above - below)
    };
    let mut step = 0.01;
    let mut above = vec![central(step)];
    let (mut best, mut error) = (above[0], f64::INFINITY);
    for row in 1..ROWS {
        step /= 2.0;
        let mut current = vec![central(step)];
        let mut factor = 4.0;
        for column in 0..row {
            let next = (factor * current[column] - above[column]) / (factor - 1.0);
            let change = (next - current[column])
                .abs()
                .max((next - above[column]).abs());
            if change < error {
                (best, error) = (next, change);
            }
            current.push(next);
            factor *= 4.0;
        }
        above = current;
    }
    // Where a condition flickers, `x < sin(1/x)`, the larger steps may agree with each other on the wrong branch, and even the smallest
    // ones never look at the middle.
    let (middle, beside) = (of(at), 0.5 * (of(at + step) + of(at - step)));
    let jumps = (beside - middle).abs() > CONTINUOUS * (1.0 + middle.abs());
    if jumps || (above[0] - best).abs() > 100.0 * CONTINUOUS * (1.0 + best.abs()) {
        error = f64::INFINITY;
    }
    (best, error)
}

/// How far the mean of both neighbours at the smallest step may lie from a value between them: a smooth function of moderate curvature
/// is a hundred times nearer.
const CONTINUOUS: f64 = 1e-6;

/// Checks a slope where the differences themselves are trustworthy; false where they are not.
///
/// Tolerance: ten times the extrapolation's own estimate, and 1e-7 of the slope's scale for the estimate's luck.
fn agrees(tape: &Tape, at: [f64; 2]) -> Result<bool, TestCaseError> {
    let (output, exact) = slopes(tape, at);
    let mut compared = false;
    for (column, slope) in exact.into_iter().enumerate() {
        let (numerical, error) = difference(
            |moved| {
                let mut at = at;
                at[column] = moved;
                value(tape, at)
            },
            at[column],
        );
        let scale = 1.0 + output.abs() + numerical.abs();
        // A kink or pole within the steps, or a value that is not finite there, says nothing about the slope.
        // Nor is there one where an infinite slope meets a zero one, as in asin(1^x).
        if !slope.is_finite() || !error.is_finite() || error > 1e-6 * scale || scale > 1e8 {
            continue;
        }
        compared = true;
        prop_assert!(
            (slope - numerical).abs() <= 10.0 * error + 1e-7 * scale,
            "column {column}: {slope} against {numerical} ± {error}"
        );
    }
    Ok(compared)
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 3000,
        max_global_rejects: 60_000,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn a_tape_has_the_bits_of_evaluate(expression in differentiable(), x in -2.0..2.0_f64, y in 0.1..2.0_f64) {
        let mut scope = constants();
        scope.push(("x".to_owned(), Quantity::number(x)));
        scope.push(("y".to_owned(), Quantity::number(y)));
        let evaluated = expression.evaluate(&scope);
        prop_assume!(evaluated.is_ok());
        let expected = evaluated.unwrap().value;
        let tape = tape(&expression).unwrap();
        prop_assert_eq!(value(&tape, [x, y]), expected);
        prop_assert_eq!(slopes(&tape, [x, y]).0, expected);
    }

    #[test]
    fn slopes_agree_with_differences(expression in differentiable(), x in -2.0..2.0_f64, y in 0.1..2.0_f64) {
        let tape = tape(&expression);
        prop_assume!(tape.is_some());
        prop_assume!(agrees(&tape.unwrap(), [x, y])?);
    }
}

/// Here all differences lie on one branch and the point on the other: they say nothing about its slope.
#[test]
fn differences_across_a_flickering_condition_do_not_count() {
    let text = "if 0.1 + x < sin(2.6/x) then x else 0.1";
    let tape = tape(&Expression::parse(text).unwrap()).unwrap();
    let x = 0.079_194_082_847_513_06;
    assert_eq!(slopes(&tape, [x, 0.1]).1, [1.0, 0.0]);
    let (_, error) = difference(|moved| value(&tape, [moved, 0.1]), x);
    assert!(error.is_infinite());
}

#[test]
fn every_function_and_operator_has_its_slope() {
    for text in [
        "x + y",
        "x - y",
        "x*y",
        "x/y",
        "-x*y",
        "x^y",
        "x^2",
        "x^-3",
        "x^2.5",
        "2^x",
        "x^65",
        "sin(x)",
        "cos(x)",
        "tan(x)",
        "asin(x)",
        "acos(x)",
        "atan(x)",
        "atan2(x, y)",
        "sinh(x)",
        "cosh(x)",
        "tanh(x)",
        "exp(x)",
        "log(x)",
        "log10(x)",
        "sqrt(x)",
        "abs(-x)",
        "sign(x)*x",
        "min(x, y, 0.3)",
        "max(x, y, 0.3)",
        "hypot(x, y)",
    ] {
        let expression = Expression::parse(text).unwrap();
        let tape = tape(&expression).unwrap();
        for at in [[0.4, 0.9], [0.8, 0.2], [0.1, 0.7]] {
            assert!(
                agrees(&tape, at).unwrap(),
                "{text} at {at:?} was not compared"
            );
        }
    }
}

#[test]
fn closed_forms() {
    // d/dx (x^2 y + sin(x)/y) = 2 x y + cos(x)/y, d/dy = x^2 - sin(x)/y^2; rounding of a few operations.
    let mut builder = TapeBuilder::new(&inputs());
    for text in ["x^2*y + sin(x)/y", "y", "2*a"] {
        builder
            .add(&Expression::parse(text).unwrap(), &constants())
            .unwrap();
    }
    let tape = builder.build();
    let (x, y) = (1.3_f64, 0.6_f64);
    let (mut values, mut slopes) = ([0.0; 3], [f64::NAN; 6]);
    tape.jacobian(&[x, y], &mut Vec::new(), &mut values, &mut slopes);
    let expected = [
        2.0 * x * y + x.cos() / y,
        x * x - x.sin() / (y * y),
        0.0,
        1.0,
        0.0,
        0.0,
    ];
    for (found, expected) in slopes.iter().zip(expected) {
        assert!((found - expected).abs() < 4.0 * f64::EPSILON * (1.0 + expected.abs()));
    }
    assert_eq!(values[1..], [0.6, 1.4]);
}

#[test]
fn inputs_hide_constants_and_units_count() {
    let mut builder = TapeBuilder::new(&["a".to_owned()]);
    builder
        .add(&Expression::parse("a*2 kN").unwrap(), &constants())
        .unwrap();
    let mut output = [0.0];
    builder
        .build()
        .evaluate(&[3.0], &mut Vec::new(), &mut output);
    assert_eq!(output, [6000.0]);
    let mut builder = TapeBuilder::new(&[]);
    assert!(
        builder
            .add(&Expression::parse("a").unwrap(), &NoNames)
            .is_err()
    );
}
