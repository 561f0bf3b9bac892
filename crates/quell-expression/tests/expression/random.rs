//! Random expression trees such as the parser makes: no negative numbers, no empty names.

use proptest::prelude::*;
use quell_expression::{
    BinaryOperator, ComparisonOperator, Expression, LogicalOperator, Node, Span, Unit,
};

pub(crate) const UNITS: [&str; 10] = [
    "N",
    "N*s/m",
    "kg/(s*m^4)",
    "lbf/ft",
    "m^2",
    "rad/s",
    "1/s",
    "%",
    "m^-1",
    "(N)*m",
];

const UNARY: [&str; 17] = [
    "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "log", "log10",
    "sqrt", "abs", "sign", // Names of units, which a call makes no units.
    "m", "s",
];

pub(crate) fn bare(node: Node) -> Expression {
    Expression::bare(node)
}

fn boxed(expression: Expression) -> Box<Expression> {
    Box::new(expression)
}

pub(crate) fn call(function: &str, arguments: Vec<Expression>) -> Expression {
    bare(Node::Call {
        function: function.to_owned(),
        function_span: Span::new(0, 0),
        arguments,
    })
}

pub(crate) fn binary(operator: BinaryOperator, left: Expression, right: Expression) -> Expression {
    bare(Node::Binary {
        operator,
        left: boxed(left),
        right: boxed(right),
    })
}

pub(crate) fn operator() -> impl Strategy<Value = BinaryOperator> {
    prop::sample::select(vec![
        BinaryOperator::Add,
        BinaryOperator::Subtract,
        BinaryOperator::Multiply,
        BinaryOperator::Divide,
        BinaryOperator::Power,
    ])
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        (0_u32..20).prop_map(f64::from),
        0.0..10.0,
        prop::num::f64::POSITIVE | prop::num::f64::ZERO,
    ]
    .prop_map(f64::abs)
}

fn quantity() -> impl Strategy<Value = Expression> {
    (number(), prop::sample::select(UNITS.to_vec())).prop_filter_map(
        "units of text",
        |(value, text)| {
            // A quantity's unit begins with a word or `1/`.
            (!text.starts_with('(')).then(|| {
                bare(Node::Quantity {
                    value,
                    unit: Unit::parse(text).unwrap(),
                })
            })
        },
    )
}

/// Trees of every kind of node.
pub(crate) fn tree() -> impl Strategy<Value = Expression> {
    let names = ["x", "y1", "m", "t", "s", "track1.dL", "e5", "_a", "µ"];
    let leaf = prop_oneof![
        number().prop_map(|value| bare(Node::Number(value))),
        prop::sample::select(names.to_vec()).prop_map(|name| bare(Node::Name(name.to_owned()))),
        quantity(),
    ];
    leaf.prop_recursive(6, 60, 3, |inner| {
        let comparison = prop::sample::select(vec![
            ComparisonOperator::Less,
            ComparisonOperator::LessOrEqual,
            ComparisonOperator::Greater,
            ComparisonOperator::GreaterOrEqual,
            ComparisonOperator::Equal,
            ComparisonOperator::NotEqual,
        ]);
        prop_oneof![
            6 => (operator(), inner.clone(), inner.clone()).prop_map(|(operator, a, b)| binary(operator, a, b)),
            2 => inner.clone().prop_map(|operand| bare(Node::Negate(boxed(operand)))),
            1 => (1_usize..=4, inner.clone())
                .prop_map(|(order, operand)| bare(Node::Derivative { order, operand: boxed(operand) })),
            1 => (comparison, inner.clone(), inner.clone()).prop_map(|(operator, left, right)| {
                bare(Node::Comparison { operator, left: boxed(left), right: boxed(right) })
            }),
            1 => (prop::sample::select(vec![LogicalOperator::And, LogicalOperator::Or]), inner.clone(), inner.clone())
                .prop_map(|(operator, left, right)| {
                    bare(Node::Logic { operator, left: boxed(left), right: boxed(right) })
                }),
            1 => inner.clone().prop_map(|operand| bare(Node::Not(boxed(operand)))),
            1 => (inner.clone(), inner.clone(), inner.clone()).prop_map(|(condition, then, otherwise)| {
                bare(Node::Choice { condition: boxed(condition), then: boxed(then), otherwise: boxed(otherwise) })
            }),
            2 => (prop::sample::select(UNARY.to_vec()), prop::collection::vec(inner, 0..4))
                .prop_map(|(function, arguments)| call(function, arguments)),
        ]
    })
}

/// Smooth functions of x and y, of moderate values for moderate arguments, and kinks.
pub(crate) fn differentiable() -> impl Strategy<Value = Expression> {
    let leaf = prop_oneof![
        2 => (1_u32..30).prop_map(|tenths| bare(Node::Number(f64::from(tenths) / 10.0))),
        3 => prop::sample::select(vec!["x", "y", "a"]).prop_map(|name| bare(Node::Name(name.to_owned()))),
    ];
    leaf.prop_recursive(5, 40, 3, |inner| {
        let two = || (inner.clone(), inner.clone());
        prop_oneof![
            6 => (operator(), two()).prop_map(|(operator, (a, b))| binary(operator, a, b)),
            1 => inner.clone().prop_map(|operand| bare(Node::Negate(boxed(operand)))),
            1 => (inner.clone(), 0_u32..5).prop_map(|(a, n)| {
                binary(BinaryOperator::Power, a, bare(Node::Number(f64::from(n))))
            }),
            4 => (prop::sample::select(UNARY[..15].to_vec()), inner.clone())
                .prop_map(|(function, argument)| call(function, vec![argument])),
            1 => (two(), two()).prop_map(|((a, b), (then, otherwise))| {
                let condition = Node::Comparison { operator: ComparisonOperator::Less, left: boxed(a), right: boxed(b) };
                bare(Node::Choice {
                    condition: boxed(bare(condition)),
                    then: boxed(then),
                    otherwise: boxed(otherwise),
                })
            }),
            2 => (prop::sample::select(vec!["min", "max", "hypot", "atan2"]), two())
                .prop_map(|(function, (a, b))| call(function, vec![a, b])),
        ]
    })
}
