//! No text makes the readers of expressions, equations and function heads panic; what is read prints and reads back as
//! the same, and its evaluation and lowering end with a value or an error inside the text.
#![no_main]

use libfuzzer_sys::fuzz_target;
use quell_expression::{
    Dimension, Expression, ExpressionError, Graph, Meaning, Names, NoNames, Rate, Signature, Span,
    lower,
};

/// A coordinate x with its rates, a parameter k, and everything else unknown.
struct Few;

impl Names for Few {
    fn resolve(&self, name: &str) -> Option<Meaning<'_>> {
        match name {
            "x" => Some(Meaning::Input(0, Dimension::LENGTH)),
            "k" => Some(Meaning::Input(3, Dimension::STIFFNESS)),
            _ => None,
        }
    }

    fn names(&self) -> Vec<&str> {
        vec!["x", "k"]
    }

    fn rate(&self, input: usize) -> Rate {
        match input {
            0 | 1 => Rate::Input(input + 1),
            3 => Rate::Constant(0.0),
            _ => Rate::Unknown("the third derivative of `x`".to_owned()),
        }
    }

    fn present(&self, input: usize) -> Option<f64> {
        (input == 3).then_some(2.0)
    }
}

fn inside(text: &str, error: &ExpressionError) {
    assert!(text.get(error.span.start..error.span.end).is_some());
    assert!(!error.message.is_empty());
}

fuzz_target!(|text: &str| {
    match Expression::parse(text) {
        Ok(expression) => {
            let placeless =
                |expression: &Expression| expression.map(&|_| Span::new(0, 0), &str::to_owned);
            let printed = expression.to_string();
            let again = Expression::parse(&printed);
            assert_eq!(
                again.as_ref().map(placeless),
                Ok(placeless(&expression)),
                "{printed}"
            );
            if let Err(error) = expression.evaluate(&NoNames) {
                inside(text, &error);
            }
            let mut graph = Graph::default();
            match lower(&mut graph, &expression, &Few) {
                Ok((slot, _)) => {
                    let _ = graph.jacobian(&[slot], &[0, 1, 2, 3]);
                    let _ = graph.values(&[slot], &[0.1, 0.2, 0.3, 2.0]);
                }
                Err(error) => inside(text, &error),
            }
        }
        Err(error) => inside(text, &error),
    }
    if let Err(error) = Expression::parse_equation(text) {
        inside(text, &error);
    }
    if let Err(error) = Signature::parse(text) {
        inside(text, &error);
    }
});
