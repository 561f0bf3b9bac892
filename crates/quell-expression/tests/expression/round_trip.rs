//! Display and parser undo one another; the parser survives anything.

use proptest::prelude::*;
use quell_expression::{Expression, NoNames, Node, Span, Unit};

use super::random::{bare, tree};

/// The tree without its places.
fn placeless(expression: &Expression) -> Expression {
    expression.map(&|_| Span::new(0, 0), &str::to_owned)
}

fn parsed(text: &str) -> Expression {
    Expression::parse(text).unwrap_or_else(|error| panic!("{text}: {error} at {:?}", error.span))
}

/// Texts of what an expression is made of, valid or not in their order.
fn scraps() -> impl Strategy<Value = String> {
    let scraps = [
        "x", "m", "s", "kg", "1", "2.5", "1e3", ".", "1_0", " ", " ", "+", "-", "*", "/", "^", "(",
        ")", "(", ")", ",", "'", "<", "<=", "=", "==", "!", "max(", "sin(", "1/s", "%", "µm", "Hz",
        "a.b", "**", "·", "é", "²", "\u{301}", "if ", " then ", " else ", " and ", " or ", "not ",
    ];
    prop::collection::vec(prop::sample::select(scraps.to_vec()), 0..40)
        .prop_map(|parts| parts.concat())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_written_reads_back(expression in tree()) {
        let text = expression.to_string();
        prop_assert_eq!(placeless(&parsed(&text)), expression, "{}", text);
    }

    #[test]
    fn what_is_read_writes_back(text in scraps()) {
        if let Ok(expression) = Expression::parse(&text) {
            let written = expression.to_string();
            prop_assert_eq!(placeless(&parsed(&written)), placeless(&expression), "{} became {}", text, written);
        }
    }

    #[test]
    fn every_place_is_inside_the_text(text in scraps()) {
        match Expression::parse(&text) {
            Ok(expression) => {
                let mut inside = true;
                expression.walk(&mut |part| {
                    inside &= text.get(part.span.start..part.span.end).is_some_and(|part| !part.is_empty());
                });
                prop_assert!(inside);
                if let Err(error) = expression.evaluate(&NoNames) {
                    prop_assert!(text.get(error.span.start..error.span.end).is_some());
                }
            }
            Err(error) => prop_assert!(text.get(error.span.start..error.span.end).is_some(), "{error:?}"),
        }
        if let Err(error) = Unit::parse(&text) {
            prop_assert!(text.get(error.span.start..error.span.end).is_some(), "{error:?}");
        }
    }

    #[test]
    fn anything_is_read_without_panic(text in any::<String>()) {
        let _ = Expression::parse(&text).map(|expression| expression.evaluate(&NoNames));
        let _ = Unit::parse(&text);
    }
}

#[test]
fn negative_numbers_keep_their_value() {
    // The parser makes no negative number; programs may.
    for (expression, expected, text) in [
        (bare(Node::Number(-2.0)), -2.0, "-2"),
        (
            super::random::binary(
                quell_expression::BinaryOperator::Power,
                bare(Node::Number(-2.0)),
                bare(Node::Number(2.0)),
            ),
            4.0,
            "(-2)^2",
        ),
        (
            super::random::binary(
                quell_expression::BinaryOperator::Subtract,
                bare(Node::Number(1.0)),
                bare(Node::Quantity {
                    value: -2.0,
                    unit: Unit::parse("%").unwrap(),
                }),
            ),
            1.02,
            "1 - -2 %",
        ),
    ] {
        assert_eq!(expression.to_string(), text);
        assert_eq!(parsed(text).evaluate(&NoNames).unwrap().value, expected);
        assert_eq!(expression.evaluate(&NoNames).unwrap().value, expected);
    }
}

#[test]
fn texts_are_as_short_as_they_can_be() {
    for text in [
        "2*zeta*sqrt(k*m)",
        "-x^2 + 5 N*m",
        "2^-x",
        "(x')'^2 - (x + y)'",
        "(0.75 m)*max(abs(d), 1e-5)",
        "-5 N + 3 N",
        "a - (b - c)",
        "a/(b*c)",
        "a*(-b)'",
        "F <= 6380.3 lbf",
    ] {
        assert_eq!(parsed(text).to_string(), text);
    }
}
