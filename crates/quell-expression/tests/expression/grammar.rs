//! What expressions mean.

use std::f64::consts::PI;

use quell_expression::{
    BinaryOperator, ComparisonOperator, Dimension, Expression, NoNames, Node, Quantity, Signature,
    Span,
};

use super::{quantity, value};

#[test]
fn operators_bind_as_in_mathematics() {
    for (text, expected) in [
        ("1 + 2*3", 7.0),
        ("(1 + 2)*3", 9.0),
        ("8 - 3 - 2", 3.0),
        ("8/4/2", 1.0),
        ("8/4*2", 4.0),
        ("-2^2", -4.0),
        ("(-2)^2", 4.0),
        ("2^-1", 0.5),
        ("2^-2^2", 0.0625),
        ("2^3^2", 512.0),
        ("(2^3)^2", 64.0),
        ("2*-3", -6.0),
        ("2--3", 5.0),
        ("--3", 3.0),
        ("+3 - +1", 2.0),
        ("-2*3 + 1", -5.0),
        ("1_000.5e-1", 100.05),
        (".5 + 1.", 1.5),
        ("2e3", 2000.0),
        ("1/2*4", 2.0),
        ("abs(-3) + max(1, 2, 5) - min(4, 2)", 6.0),
        ("hypot(3, 4)*sign(-2)", -5.0),
        ("cos(pi)", -1.0),
        ("4^0.5", 2.0),
        ("0^0", 1.0),
    ] {
        assert_eq!(value(text), expected, "{text}");
    }
}

#[test]
fn a_number_before_a_unit_is_a_quantity() {
    for (text, expected, dimension) in [
        ("5 N*s/m", 5.0, Dimension::DAMPING),
        ("5N*s/m", 5.0, Dimension::DAMPING),
        ("1.05e8 kg/(s*m^4)", 1.05e8, Dimension::new(1, -4, -1, 0)),
        ("3.8e6 kg/m^4", 3.8e6, Dimension::new(1, -4, 0, 0)),
        ("0.75 m * max(2, 3)", 2.25, Dimension::LENGTH),
        ("0.75 m*max(2, 3)", 2.25, Dimension::LENGTH),
        ("2 m + 3 m/s * 2 s", 8.0, Dimension::LENGTH),
        ("(3 m)^2", 9.0, Dimension::AREA),
        ("2*3 m^2", 6.0, Dimension::AREA),
        ("-3 m", -3.0, Dimension::LENGTH),
        ("6 N/3 m", 2.0, Dimension::STIFFNESS),
        ("6 N/(3 m)", 2.0, Dimension::STIFFNESS),
        ("0.5 1/s", 0.5, Dimension::new(0, 0, -1, 0)),
        ("50 %", 0.5, Dimension::NONE),
        ("sqrt(16 N/m / 1 kg)", 4.0, Dimension::new(0, 0, -1, 0)),
        ("2 rad/s * 1 s", 2.0, Dimension::ANGLE),
        ("1 + 0.5 rad", 1.5, Dimension::ANGLE),
        ("sin(90 deg)", 1.0, Dimension::NONE),
        ("atan2(0 m, 2 m)", 0.0, Dimension::ANGLE),
        ("acos(-1)", PI, Dimension::ANGLE),
        ("sign(-3 N)", -1.0, Dimension::NONE),
    ] {
        let found = quantity(text);
        assert_eq!(
            (found.value, found.dimension),
            (expected, dimension),
            "{text}"
        );
    }
}

#[test]
fn a_unit_word_goes_first() {
    let scope = vec![
        ("t".to_owned(), Quantity::new(2.0, Dimension::TIME)),
        ("x".to_owned(), Quantity::new(4.0, Dimension::LENGTH)),
        ("s.x".to_owned(), Quantity::new(4.0, Dimension::LENGTH)),
        ("h".to_owned(), Quantity::new(3.0, Dimension::LENGTH)),
    ];
    let momentum = Dimension::new(1, 1, -1, 0);
    for (text, expected, dimension) in [
        // t is the tonne here, whatever parameter is called the same.
        ("3 m/s*t", 3000.0, momentum),
        ("(3 m/s)*t", 6.0, Dimension::LENGTH),
        ("t*3 m/s", 6.0, Dimension::LENGTH),
        // x is no unit: the unit ends before it; so it does before a dotted name and a parenthesis that holds more than units.
        ("3 N/x", 0.75, Dimension::STIFFNESS),
        ("3 N/s.x", 0.75, Dimension::STIFFNESS),
        ("3 N/(x + h)", 3.0 / 7.0, Dimension::STIFFNESS),
        ("3 N/h^t.zero", 1.0, Dimension::STIFFNESS),
    ] {
        let mut scope = scope.clone();
        scope.push(("t.zero".to_owned(), Quantity::number(1.0)));
        let found = Expression::parse(text)
            .and_then(|expression| expression.evaluate(&scope))
            .unwrap_or_else(|error| panic!("{text}: {error}"));
        assert_eq!(
            (found.value, found.dimension),
            (expected, dimension),
            "{text}"
        );
    }
}

#[test]
fn names_may_be_dotted_and_primed() {
    let expression = Expression::parse("track1.dL*x'' + f(y)'").unwrap();
    assert_eq!(expression.names(), ["track1.dL", "x", "y"]);
    let Node::Binary {
        operator: BinaryOperator::Add,
        left,
        right,
    } = &expression.node
    else {
        panic!("{expression:?}");
    };
    assert_eq!(
        (left.span, right.span),
        (Span::new(0, 13), Span::new(16, 21))
    );
    assert!(matches!(&right.node, Node::Derivative { order: 1, operand }
        if matches!(&operand.node, Node::Call { function, .. } if function == "f")));
    let Node::Binary { right, .. } = &left.node else {
        panic!("{left:?}");
    };
    assert!(matches!(&right.node, Node::Derivative { order: 2, operand }
        if operand.node == Node::Name("x".to_owned())));
}

#[test]
fn comparisons_are_loosest() {
    for (text, expected) in [
        ("a + 1 <= b*2", ComparisonOperator::LessOrEqual),
        ("a >= 5 N*m", ComparisonOperator::GreaterOrEqual),
        ("a<b", ComparisonOperator::Less),
        ("a>b", ComparisonOperator::Greater),
        ("a == b", ComparisonOperator::Equal),
        ("a != b", ComparisonOperator::NotEqual),
    ] {
        let expression = Expression::parse(text).unwrap();
        assert!(
            matches!(expression.node, Node::Comparison { operator, .. } if operator == expected),
            "{text}"
        );
    }
}

#[test]
fn choices_and_conditions() {
    for (text, expected) in [
        ("if 2 > 1 then 3 else 4", 3.0),
        ("if 2 > 1 and not 1 > 2 then 3 else 4", 3.0),
        (
            "if 1 > 2 or 2 <= 1 then 3 else if 1 != 1 then 5 else 6 + 1",
            7.0,
        ),
        ("1 + (if 1 == 1 then 3 else 4)*2", 7.0),
        ("if 1 > 2 then 1/0 else 5", 5.0),
        ("if 1 > 2 or 1 < 2 and 3 < 2 then 1 else 0", 0.0),
        ("if(1 < 2)then(1)else(0)", 1.0),
        ("if 5 m > 3 ft then 1 else 0", 1.0),
        ("if 1 < 2 then 5 else 4 m*0", 5.0),
    ] {
        let found = Expression::parse(text).and_then(|read| read.evaluate(&NoNames));
        if text.ends_with("m*0") {
            assert_eq!(
                found.unwrap_err().message,
                "one branch is m, the other a plain number"
            );
        } else {
            assert_eq!(found.unwrap().value, expected, "{text}");
        }
    }
    for (text, message, help) in [
        (
            "2*if x > 0 then 1 else 0",
            "expected a number, a name or `(`, found `if`",
            Some("within an operation it stands in parentheses: `(if … then … else …)`"),
        ),
        (
            "if x > 0 then 1",
            "expected `else` or an operator, found the end",
            Some("a choice is written `if … then … else …`"),
        ),
        (
            "if x > 0 or then 1 else 2",
            "expected a number, a name or `(`, found `then`",
            None,
        ),
        (
            "x and",
            "expected a number, a name or `(`, found the end",
            None,
        ),
    ] {
        let error = Expression::parse(text).unwrap_err();
        assert_eq!(
            (error.message.as_str(), error.help.as_deref()),
            (message, help),
            "{text}"
        );
    }
    let error = Expression::parse("if 1 then 2 else 3")
        .unwrap()
        .evaluate(&NoNames)
        .unwrap_err();
    assert_eq!(
        error.message,
        "`1` is a value, where a condition is expected"
    );
}

#[test]
fn equations_have_two_sides() {
    let (left, right) =
        Expression::parse_equation("m*x'' + (if x == 0 then c else k)*x = F").unwrap();
    assert_eq!(
        (left.to_string().as_str(), right.to_string().as_str()),
        ("m*x'' + (if x == 0 then c else k)*x", "F")
    );
    for (text, message) in [
        ("m*x''", "expected an operator or `=`, found the end"),
        ("a = b = c", "expected `<=`, `>=` or `==`, found `=`"),
        ("(a = b)", "expected `<=`, `>=` or `==`, found `=`"),
    ] {
        assert_eq!(
            Expression::parse_equation(text).unwrap_err().message,
            message
        );
    }
}

#[test]
fn signatures_name_functions_and_arguments() {
    let signature = Signature::parse(" F ( side, lam ) ").unwrap();
    assert_eq!((signature.name.as_str(), signature.span.start), ("F", 1));
    let arguments: Vec<_> = signature
        .arguments
        .iter()
        .map(|one| (one.name.as_str(), one.span.start))
        .collect();
    assert_eq!(arguments, [("side", 5), ("lam", 11)]);
    for (text, message) in [
        ("F", "expected `(`, found the end"),
        ("F()", "expected the name of an argument, found `)`"),
        ("F(x, x)", "`x` is an argument already"),
        ("sin(x)", "`sin` is a function of the language"),
        ("F(if)", "expected the name of an argument, found `if`"),
        ("F(x) + 1", "expected the end, found `+`"),
    ] {
        assert_eq!(Signature::parse(text).unwrap_err().message, message);
    }
}
