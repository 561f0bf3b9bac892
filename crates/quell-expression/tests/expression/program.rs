//! Programs against the graph's own values, hoisting, levels, lanes.

use proptest::prelude::*;
use quell_expression::{
    BatchWorkspace, Condition, Differentiation, Dimension, Function, Graph, LANES, Meaning, Names,
    Program, Quantity, Rate, Slot, Workspace, lower,
};

use super::random::differentiable;

#[test]
fn levels_add_up_and_parameters_are_read_once() {
    let mut graph = Graph::default();
    let (x, y, k) = (graph.input(0), graph.input(1), graph.input(2));
    let sine = graph.unary(Function::Sin, k);
    let product = graph.multiply(sine, x);
    let root = graph.add(product, y);
    let slopes: Vec<_> = graph.jacobian(&[root], &[0, 1, 2]);
    let slopes: Vec<_> = slopes.into_iter().map(|slope| slope.unwrap()).collect();
    let program = Program::compile(&graph, &[vec![root], slopes], |input| input == 2);
    // One fused multiply-add; k x cos(k) for the parameter's column in level 1.
    assert_eq!((program.operations(0), program.operations(1)), (1, 2));
    assert_eq!((program.outputs(0), program.outputs(1)), (1, 4));
    let mut workspace = Workspace::default();
    program.prepare(&[f64::NAN, f64::NAN, 0.5], &mut workspace);
    let mut outputs = [7.0; 5];
    program.evaluate(0, &[2.0, 3.0, f64::NAN], &mut workspace, &mut outputs);
    assert_eq!(outputs, [0.5_f64.sin() * 2.0 + 3.0, 7.0, 7.0, 7.0, 7.0]);
    program.evaluate(1, &[2.0, 3.0], &mut workspace, &mut outputs);
    let (sine, cosine) = (0.5_f64.sin(), 0.5_f64.cos());
    assert_eq!(outputs, [sine * 2.0 + 3.0, sine, 1.0, cosine * 2.0, 7.0]);
}

#[test]
fn lanes_have_the_bits_of_points_alone() {
    let mut graph = Graph::default();
    let (x, k) = (graph.input(0), graph.input(1));
    let power = graph.power(x, k);
    let atan = graph.unary(Function::Atan, power);
    let product = graph.multiply(k, x);
    let less = graph.choose(&Condition::Less(x, k), product, atan);
    let root = graph.subtract(less, power);
    let slope = graph.jacobian(&[root], &[0])[0].unwrap();
    let program = Program::compile(&graph, &[vec![root], vec![slope]], |input| input == 1);
    let at = |lane: usize| [0.3 + 0.1 * lane as f64, 1.3 + 0.01 * lane as f64];
    let inputs: [[f64; LANES]; 2] =
        std::array::from_fn(|input| std::array::from_fn(|lane| at(lane)[input]));
    let (mut batch, mut outputs) = (BatchWorkspace::default(), [[0.0; LANES]; 2]);
    program.prepare_lanes(&inputs, &mut batch);
    program.evaluate_batch(1, &inputs, &mut batch, &mut outputs);
    let [first, second] = outputs;
    for (lane, together) in first.into_iter().zip(second).enumerate() {
        let (mut workspace, mut alone) = (Workspace::default(), [0.0; 2]);
        program.prepare(&at(lane), &mut workspace);
        program.evaluate(1, &at(lane), &mut workspace, &mut alone);
        assert_eq!([together.0, together.1], alone);
        assert_eq!(graph.values(&[root, slope], &at(lane)), alone);
    }
}

#[test]
fn sums_take_up_negations_without_changing_a_bit() {
    let mut graph = Graph::default();
    let [x, y, z] = [0, 1, 2].map(|index| graph.input(index));
    let product = graph.multiply(x, y);
    let negated = graph.negate(product);
    let cosine = graph.unary(Function::Cos, x);
    let opposite = graph.negate(cosine);
    let first = graph.subtract(negated, z);
    let second = graph.subtract(opposite, z);
    let program = Program::compile(&graph, &[vec![first, second]], |_| false);
    // Two sums and a cosine.
    assert_eq!(program.operations(0), 3);
    for inputs in [
        [0.0, 1.0, 0.0],
        [-0.0, 1.0, 0.0],
        [0.3, -7.0, 0.1],
        [1.5, 1e-9, -2.0],
    ] {
        let (mut workspace, mut outputs) = (Workspace::default(), [0.0; 2]);
        program.prepare(&inputs, &mut workspace);
        program.evaluate(0, &inputs, &mut workspace, &mut outputs);
        let [x, y, z] = inputs;
        let expected = [-(x * y) - z, graph.values(&[second], &inputs)[0]];
        assert_eq!(outputs.map(f64::to_bits), expected.map(f64::to_bits));
    }
}

#[test]
fn holds_stop_formal_derivatives_only() {
    let mut graph = Graph::default();
    let (x, v) = (graph.input(0), graph.input(1));
    let square = graph.multiply(x, x);
    let held = graph.hold(square);
    let root = graph.multiply(held, x);
    let formal = graph.tangent(&[root], &[(0, v)], Differentiation::Formal)[0].unwrap();
    let exact = graph.tangent(&[root], &[(0, v)], Differentiation::Exact)[0].unwrap();
    assert_eq!(graph.values(&[formal, exact], &[3.0, 2.0]), [18.0, 54.0]);
    let one = graph.constant(1.0);
    assert_eq!(
        graph.tangent(&[held], &[(0, one)], Differentiation::Formal),
        [None]
    );
}

#[test]
fn dependence_tells_smooth_from_deciding() {
    let mut graph = Graph::default();
    let (x, y, z) = (graph.input(0), graph.input(1), graph.input(2));
    let piece = graph.choose(&Condition::LessOrEqual(x, y), z, y);
    let sign = graph.unary(Function::Sign, x);
    let root = graph.multiply(sign, piece);
    assert!(graph.depends(root, 0));
    assert_eq!(
        graph
            .smooth_dependence(root)
            .into_iter()
            .collect::<Vec<_>>(),
        [1, 2]
    );
    let difference = graph.subtract(x, y);
    assert_eq!(graph.switches(&[root]), [difference, x]);
    let moved = graph.substitute(&[root], &[(0, y), (1, x)]);
    assert_eq!(
        graph.values(&[root, moved[0]], &[-1.0, 2.0, 5.0]),
        [-5.0, -1.0]
    );
}

/// x and y move, a is a parameter.
struct Three;

impl Names for Three {
    fn resolve(&self, name: &str) -> Option<Meaning<'_>> {
        let index = ["x", "y", "a"].iter().position(|known| *known == name)?;
        Some(Meaning::Input(index, Dimension::NONE))
    }

    fn names(&self) -> Vec<&str> {
        vec!["x", "y", "a"]
    }

    fn rate(&self, _: usize) -> Rate {
        Rate::Constant(0.0)
    }

    fn dimensionless(&self) -> bool {
        true
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 1000,
        max_global_rejects: 60_000,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn every_way_of_evaluation_gives_the_same_bits(
        expressions in prop::collection::vec(differentiable(), 1..4),
        points in prop::collection::vec((-2.0..2.0_f64, 0.1..2.0_f64), LANES),
    ) {
        let parameter = 1.7;
        let mut graph = Graph::default();
        let lowered: Result<Vec<_>, _> =
            expressions.iter().map(|one| lower(&mut graph, one, &Three).map(|(slot, _)| slot)).collect();
        // Constants that are not finite are refused.
        prop_assume!(lowered.is_ok());
        let roots = lowered.unwrap();
        let zero = graph.constant(0.0);
        let full = |graph: &mut Graph, of: &[Slot]| -> Vec<Slot> {
            graph.jacobian(of, &[0, 1]).into_iter().map(|slot| slot.unwrap_or(zero)).collect()
        };
        let first = full(&mut graph, &roots);
        let second = full(&mut graph, &first);
        let all: Vec<Slot> = [roots.clone(), first.clone(), second.clone()].concat();
        let program = Program::compile(&graph, &[roots, first, second], |input| input == 2);
        let inputs: [[f64; LANES]; 3] = [
            std::array::from_fn(|lane| points[lane].0),
            std::array::from_fn(|lane| points[lane].1),
            [parameter; LANES],
        ];
        let (mut workspace, mut batch) = (Workspace::default(), BatchWorkspace::default());
        program.prepare(&[f64::NAN, f64::NAN, parameter], &mut workspace);
        program.prepare_batch(&[f64::NAN, f64::NAN, parameter], &mut batch);
        let mut together = vec![[0.0; LANES]; all.len()];
        program.evaluate_batch(2, &inputs, &mut batch, &mut together);
        for (lane, (x, y)) in points.iter().enumerate() {
            let mut alone = vec![0.0; all.len()];
            program.evaluate(2, &[*x, *y], &mut workspace, &mut alone);
            let plain = graph.values(&all, &[*x, *y, parameter]);
            for ((alone, batch), plain) in alone.iter().zip(&together).zip(plain) {
                // Not-a-number has many patterns, of which hardware takes one or another.
                let same = |a: f64, b: f64| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan());
                prop_assert!(same(*alone, batch[lane]), "{alone} {}", batch[lane]);
                prop_assert!(same(*alone, plain), "{alone} {plain}");
            }
            let scope = vec![
                ("x".to_owned(), Quantity::number(*x)),
                ("y".to_owned(), Quantity::number(*y)),
                ("a".to_owned(), Quantity::number(parameter)),
            ];
            for (expression, value) in expressions.iter().zip(&alone) {
                if let Ok(expected) = expression.evaluate(&scope) {
                    prop_assert_eq!(expected.value, *value);
                }
            }
        }
    }
}
