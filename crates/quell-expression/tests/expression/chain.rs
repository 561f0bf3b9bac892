//! The longest and deepest expressions that the parser lets through do not overflow a small stack.

use quell_expression::{Expression, NoNames, Quantity, TapeBuilder};

/// Parses, evaluates, writes, copies, compiles and drops on a thread of 2 MiB, the default of spawned threads.
fn survives(text: String, expected: f64) {
    let thread = std::thread::Builder::new()
        .stack_size(2 << 20)
        .spawn(move || {
            let expression = Expression::parse(&text).unwrap();
            let scope = vec![("x".to_owned(), Quantity::number(1.0))];
            assert_eq!(expression.evaluate(&scope).unwrap().value, expected);
            assert_eq!(
                Expression::parse(&expression.to_string()).unwrap().names(),
                expression.names()
            );
            assert_eq!(expression.clone(), expression);
            assert!(!format!("{expression:?}").is_empty());
            expression.walk(&mut |_| {});
            let moved = expression.map(&|span| span, &str::to_owned);
            let mut builder = TapeBuilder::new(&["x".to_owned()]);
            builder.add(&moved, &NoNames).unwrap();
            let mut output = [0.0];
            builder
                .build()
                .evaluate(&[1.0], &mut Vec::new(), &mut output);
            assert_eq!(output, [expected]);
        });
    thread.unwrap().join().unwrap();
}

#[test]
fn long_chains() {
    survives(format!("x{}", "+x".repeat(2000)), 2001.0);
    survives(format!("x{}", "*x".repeat(2000)), 1.0);
}

#[test]
fn long_chains_under_deep_parentheses() {
    // As high as a tree can be: signs and parentheses on top of the chain within.
    let mut text = format!("x{}", "+x".repeat(2000 - 50));
    for _ in 0..50 {
        text = format!("-({text})/x");
    }
    survives(text, 1951.0);
}

#[test]
fn what_is_longer_or_deeper_is_refused_in_words() {
    for (text, message) in [
        (
            format!("x{}", "+x".repeat(2001)),
            "this expression has more than 2000 operations",
        ),
        (
            format!("x{}", "^x".repeat(5000)),
            "this is nested more than 100 deep",
        ),
        ("(".repeat(100_000), "this is nested more than 100 deep"),
        ("-".repeat(100_000), "this is nested more than 100 deep"),
        ("sin(".repeat(100_000), "this is nested more than 100 deep"),
        (
            format!("5 {}", "N*(".repeat(100_000)),
            "this is nested more than 100 deep",
        ),
    ] {
        let error = Expression::parse(&text).unwrap_err();
        assert_eq!(error.message, message);
        assert_eq!(
            error.help.as_deref(),
            Some("name a part of it as a parameter")
        );
    }
}
