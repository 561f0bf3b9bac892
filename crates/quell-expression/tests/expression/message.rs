//! What is said about mistakes, and where.

use quell_expression::{Dimension, Expression, Quantity, nearest};

type Case = (
    &'static str,
    &'static str,
    &'static str,
    Option<&'static str>,
);

/// The text at fault must be the second entry, at its last place in the first.
fn check(cases: &[Case], error: impl Fn(&str) -> quell_expression::ExpressionError) {
    for (text, fault, message, help) in cases {
        let found = error(text);
        assert_eq!(found.message, *message, "{text}");
        assert_eq!(found.help.as_deref(), *help, "{text}");
        let start = text.rfind(fault).unwrap();
        let span = (found.span.start, found.span.end);
        assert_eq!(span, (start, start + fault.len()), "{text}");
    }
}

#[test]
fn syntax_is_explained_at_its_character() {
    let cases: &[Case] = &[
        (
            "",
            "",
            "expected a number, a name or `(`, found the end",
            None,
        ),
        (
            "2 +",
            "",
            "expected a number, a name or `(`, found the end",
            None,
        ),
        (
            "2 + * 3",
            "*",
            "expected a number, a name or `(`, found `*`",
            None,
        ),
        (
            "a b",
            "b",
            "expected an operator or the end, found `b`",
            None,
        ),
        (
            "a 5.2",
            "5.2",
            "expected an operator or the end, found `5.2`",
            None,
        ),
        (
            "µ*(a + b",
            "",
            "expected an operator or `)`, found the end",
            Some("the parenthesis opened at character 3 is not closed"),
        ),
        (
            "a)",
            ")",
            "expected an operator or the end, found `)`",
            None,
        ),
        (
            "2^3 + 0,5",
            ",",
            "expected an operator or the end, found `,`",
            Some("decimals are written with a point: `0.5`"),
        ),
        (
            "max(1, 2",
            "",
            "expected an operator, `,` or `)`, found the end",
            None,
        ),
        (
            "max(1; 2)",
            ";",
            "expected an operator, `,` or `)`, found `;`",
            None,
        ),
        (
            "a ** 2",
            "**",
            "`**` is not an operator",
            Some("a power is written `^`"),
        ),
        (
            "a − b",
            "−",
            "expected an operator or the end, found `−`",
            Some("minus is written `-`"),
        ),
        (
            "a × b",
            "×",
            "expected an operator or the end, found `×`",
            Some("a product is written `*`"),
        ),
        (
            "2(a + b)",
            "(",
            "expected an operator or the end, found `(`",
            Some("a product is written `*`, and a function's name stands before `(`"),
        ),
        (
            "2 x",
            "x",
            "`x` is not a unit",
            Some("a product is written `2*x`"),
        ),
        (
            "2 sin(a)",
            "sin",
            "`sin` is not a unit",
            Some("a product is written `2*sin`"),
        ),
        (
            "3 lbff",
            "lbff",
            "`lbff` is not a unit",
            Some("did you mean `lbf`? Or, a product is written `3*lbff`"),
        ),
        (
            "2 m^n",
            "n",
            "the power of a unit is a number, such as `m^2`",
            Some("to raise a quantity, put it in parentheses: `(5 m)^n`"),
        ),
        ("1e999", "1e999", "`1e999` is too large for a number", None),
        (
            "1e-999",
            "1e-999",
            "`1e-999` is too small for a number",
            None,
        ),
        (".", ".", "`.` is not a number", None),
        ("a = b", "=", "expected `<=`, `>=` or `==`, found `=`", None),
        (
            "a < b < c",
            "<",
            "expected an operator or the end, found `<`",
            Some("a comparison has two sides, such as `x <= 5`"),
        ),
        (
            "x'''''",
            "x'''''",
            "5 primes are more than any equation of motion has",
            None,
        ),
        (
            "a ' + 1",
            "'",
            "expected an operator or the end, found `'`",
            None,
        ),
        (
            "a.5",
            ".",
            "expected an operator or the end, found `.`",
            None,
        ),
    ];
    check(cases, |text| Expression::parse(text).unwrap_err());
}

#[test]
fn values_are_explained_at_their_part() {
    let scope = vec![
        ("stroke".to_owned(), Quantity::new(0.1, Dimension::LENGTH)),
        ("mass".to_owned(), Quantity::new(2.0, Dimension::MASS)),
        ("zero".to_owned(), Quantity::number(0.0)),
        ("V0".to_owned(), Quantity::new(1.0, Dimension::VELOCITY)),
    ];
    let cases: &[Case] = &[
        (
            "2*strok",
            "strok",
            "unknown name `strok`",
            Some("did you mean `stroke`?"),
        ),
        (
            "2*v0",
            "v0",
            "unknown name `v0`",
            Some("did you mean `V0`?"),
        ),
        ("2*qqq", "qqq", "unknown name `qqq`", None),
        (
            "2*sin",
            "sin",
            "unknown name `sin`",
            Some("`sin` is a function: `sin(…)`"),
        ),
        (
            "zero*lbf",
            "lbf",
            "unknown name `lbf`",
            Some("`lbf` is a unit, which stands directly after a number: `5 lbf`"),
        ),
        (
            "sine(1)",
            "sine",
            "unknown function `sine`",
            Some("did you mean `sin`?"),
        ),
        (
            "atan2(1)",
            "atan2",
            "`atan2` takes 2 arguments, found 1",
            None,
        ),
        (
            "sin(1, 2)",
            "sin",
            "`sin` takes one argument, found 2",
            None,
        ),
        (
            "1 + max(1)",
            "max",
            "`max` takes at least 2 arguments, found 1",
            None,
        ),
        ("stroke + mass", "mass", "cannot add kg to m", None),
        (
            "stroke - 1",
            "1",
            "cannot subtract a plain number from m",
            None,
        ),
        ("stroke*(V0 + 3 N)", "3 N", "cannot add N to m/s", None),
        (
            "2^stroke",
            "stroke",
            "an exponent is a plain number, found m",
            None,
        ),
        (
            "stroke^0.3",
            "0.3",
            "m cannot be raised to the power 0.3",
            None,
        ),
        (
            "sin(stroke)",
            "stroke",
            "`sin` takes an angle, found m",
            None,
        ),
        (
            "exp(3 N)",
            "3 N",
            "`exp` takes a plain number, found N",
            None,
        ),
        (
            "max(stroke, mass)",
            "mass",
            "`max` compares m with kg",
            None,
        ),
        ("1/zero", "zero", "`zero` is zero, and it divides", None),
        (
            "sqrt(-1) + 2",
            "sqrt(-1)",
            "`sqrt(-1)` is not a finite number",
            None,
        ),
        (
            "10^308*10^308",
            "10^308*10^308",
            "`10^308*10^308` is not a finite number",
            None,
        ),
        (
            "1 + stroke'",
            "stroke'",
            "`stroke'` is a time derivative, and nothing here varies in time",
            None,
        ),
        (
            "stroke < 1",
            "stroke < 1",
            "`stroke < 1` is a comparison, where a number is expected",
            None,
        ),
    ];
    check(cases, |text| {
        Expression::parse(text)
            .unwrap()
            .evaluate(&scope)
            .unwrap_err()
    });
}

#[test]
fn a_long_expression_does_not_swamp_its_message() {
    let text = format!("log({}-1)", "0*".repeat(300));
    let error = Expression::parse(&text)
        .and_then(|expression| expression.evaluate(&quell_expression::NoNames))
        .unwrap_err();
    assert!(error.message.chars().count() < 100, "{}", error.message);
}

#[test]
fn nearest_names_are_near() {
    for (typed, candidates, expected) in [
        (
            "frequencey",
            vec!["frequency", "transient"],
            Some("frequency"),
        ),
        ("Fs", vec!["fs", "Ft"], Some("fs")),
        ("k1", vec!["k2", "c1"], Some("k2")),
        ("zeta", vec!["beta", "eta"], Some("beta")),
        ("x", vec!["y", "z"], None),
        ("mount", vec!["amount"], Some("amount")),
        ("force", vec!["f"], None),
        ("", vec!["a"], None),
    ] {
        assert_eq!(nearest(typed, candidates), expected, "{typed}");
    }
}
