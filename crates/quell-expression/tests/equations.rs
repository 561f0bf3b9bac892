//! Models written as equations against the same written by hand, published figures, and derivatives by differences.

#![allow(
    dead_code,
    unreachable_pub,
    clippy::panic,
    clippy::unwrap_used,
    reason = "the benchmarks share the cases"
)]

mod cases;

use cases::{Equations, gear, section};
use quell_expression::{BatchWorkspace, Differentiation, LANES, Program, Workspace};

fn evaluate(program: &Program, equations: &Equations, states: &[f64]) -> Vec<f64> {
    let inputs = equations.inputs(states);
    let mut workspace = Workspace::default();
    program.prepare(&inputs, &mut workspace);
    let mut outputs = vec![0.0; program.outputs(1)];
    program.evaluate(1, &inputs, &mut workspace, &mut outputs);
    outputs
}

/// Each to `tolerance` of the largest.
fn close(found: &[f64], expected: &[f64], tolerance: f64) {
    let scale = expected
        .iter()
        .fold(0.0_f64, |scale, value| scale.max(value.abs()));
    for (a, b) in found.iter().zip(expected) {
        assert!(
            (a - b).abs() <= tolerance * scale,
            "{found:?}\n{expected:?}"
        );
    }
}

/// Point i of a sequence that fills the box of the scales.
fn point<const N: usize>(index: usize, scales: [f64; N]) -> [f64; N] {
    std::array::from_fn(|axis| {
        let fraction = (0.5 + index as f64 * (axis as f64 + 2.0).sqrt()).fract();
        scales[axis] * (2.0 * fraction - 1.0)
    })
}

const SECTION: [f64; 6] = [0.02, 0.1, 0.3, 1.5, 0.05, 0.4];
const GEAR: [f64; 7] = [0.01, 0.1, 0.5, 3.0, 0.04, 0.04, 0.1];

/// Jacobian by fourth-order central differences, row by row.
fn differenced<const N: usize>(
    rates: impl Fn(&[f64; N]) -> [f64; N],
    at: &[f64; N],
    scales: [f64; N],
) -> Vec<f64> {
    let mut jacobian = vec![0.0; N * N];
    for column in 0..N {
        let step = 1e-3 * scales[column];
        let moved = |steps: f64| {
            let mut states = *at;
            states[column] += steps * step;
            rates(&states)
        };
        let [a, b, c, d] = [moved(-2.0), moved(-1.0), moved(1.0), moved(2.0)];
        for row in 0..N {
            jacobian[row * N + column] =
                (8.0 * (c[row] - b[row]) - (d[row] - a[row])) / (12.0 * step);
        }
    }
    jacobian
}

#[test]
fn a_section_has_the_rates_written_by_hand() {
    let equations = section::MODEL.equations();
    let program = equations.program();
    let (parameters, prepared) = (
        section::Section::default(),
        section::prepare(&section::Section::default()),
    );
    for index in 0..50 {
        let states = point(index, SECTION);
        let rates = |states: &[f64; 6]| {
            let mut out = [0.0; 6];
            section::rates(&parameters, states, &mut out);
            out
        };
        let mut again = [0.0; 6];
        section::prepared_rates(&prepared, &states, &mut again);
        let outputs = evaluate(&program, &equations, &states);
        // Sums of a few terms of which some cancel.
        close(&outputs[..6], &rates(&states), 1e-13);
        close(&again, &rates(&states), 1e-13);
        for row in 0..6 {
            let (from, to) = (row * 6, row * 6 + 6);
            close(
                &outputs[6 + from..6 + to],
                &differenced(rates, &states, SECTION)[from..to],
                1e-9,
            );
        }
    }
}

#[test]
fn a_gear_has_the_rates_written_by_hand() {
    let equations = gear::MODEL.equations();
    let program = equations.program();
    let parameters = gear::Gear::default();
    let rates = |states: &[f64; 7]| {
        let mut out = [0.0; 7];
        gear::rates(&parameters, states, &mut out);
        out
    };
    // The figures of an independent program (Python), of thirteen digits, for V = 30 m/s, cd = 36000 N m s/rad.
    let states = [0.004, 0.05, -0.3, 1.2, 0.012, 0.009, 0.03];
    let expected = [
        -0.3,
        1.2,
        -45.170_944_167_6,
        -142.680_938_341_4,
        0.000_820_178_559_972,
        0.320_855_488_458_6,
        0.120_277_777_777_8,
    ];
    let outputs = evaluate(&program, &equations, &states);
    for (found, expected) in outputs.iter().zip(expected) {
        assert!(
            (found - expected).abs() < 1e-12_f64.max(1e-11 * expected.abs()),
            "{found} {expected}"
        );
    }
    for index in 0..50 {
        let states = point(index, GEAR);
        let outputs = evaluate(&program, &equations, &states);
        // The moments that balance here are a thousand times their sum.
        close(&outputs[..7], &rates(&states), 1e-11);
        for row in 0..7 {
            let (from, to) = (row * 7, row * 7 + 7);
            close(
                &outputs[7 + from..7 + to],
                &differenced(rates, &states, GEAR)[from..to],
                1e-8,
            );
        }
    }
}

#[test]
fn batches_have_the_bits_of_points_alone() {
    let equations = gear::MODEL.equations();
    let program = equations.program();
    let points: Vec<Vec<f64>> = (0..LANES)
        .map(|lane| equations.inputs(&point(lane, GEAR)))
        .collect();
    let inputs: Vec<[f64; LANES]> = (0..points[0].len())
        .map(|input| std::array::from_fn(|lane| points[lane][input]))
        .collect();
    for lanes in [false, true] {
        let mut workspace = BatchWorkspace::default();
        if lanes {
            program.prepare_lanes(&inputs, &mut workspace);
        } else {
            program.prepare_batch(&points[0], &mut workspace);
        }
        let mut outputs = vec![[0.0; LANES]; program.outputs(1)];
        program.evaluate_batch(1, &inputs, &mut workspace, &mut outputs);
        for (lane, states) in points.iter().enumerate() {
            let alone = evaluate(&program, &equations, &states[..7]);
            for (batch, alone) in outputs.iter().zip(alone) {
                assert_eq!(batch[lane].to_bits(), alone.to_bits());
            }
        }
    }
}

#[test]
fn higher_derivatives_come_from_repeated_tangents() {
    let mut equations = gear::MODEL.equations();
    // B(u, v) and C(u, v, w) of the normal form: the same direction twice and thrice, against the Taylor expansion of
    // the rates along a line.
    let direction = [0.3, 1.0, -0.7, 0.2, 0.5, -0.4, 0.6].map(|value| value * 0.02);
    let graph = &mut equations.graph;
    let seeds: Vec<_> = direction
        .iter()
        .enumerate()
        .map(|(input, value)| (input, graph.constant(*value)))
        .collect();
    let mut levels = vec![equations.rates.clone()];
    for order in 0..3 {
        let zero = graph.constant(0.0);
        let next = graph.tangent(&levels[order], &seeds, Differentiation::Exact);
        levels.push(next.into_iter().map(|slot| slot.unwrap_or(zero)).collect());
    }
    let program = Program::compile(graph, &levels, |input| input >= 7);
    let states = point(3, GEAR);
    let inputs = equations.inputs(&states);
    let mut workspace = Workspace::default();
    program.prepare(&inputs, &mut workspace);
    let mut derivatives = vec![0.0; 28];
    program.evaluate(3, &inputs, &mut workspace, &mut derivatives);
    let along = |s: f64| {
        let moved: Vec<f64> = states
            .iter()
            .zip(direction)
            .map(|(x, d)| x + s * d)
            .collect();
        let inputs = equations.inputs(&moved);
        let (mut workspace, mut rates) = (Workspace::default(), vec![0.0; 7]);
        program.prepare(&inputs, &mut workspace);
        program.evaluate(0, &inputs, &mut workspace, &mut rates);
        rates
    };
    let s = 0.05;
    let [a, b, c, d, e] = [
        along(-2.0 * s),
        along(-s),
        along(0.0),
        along(s),
        along(2.0 * s),
    ];
    for row in 0..7 {
        let second =
            (16.0 * (b[row] + d[row]) - 30.0 * c[row] - (a[row] + e[row])) / (12.0 * s * s);
        let third = ((e[row] - a[row]) / 2.0 - (d[row] - b[row])) / (s * s * s);
        let scale = c[row].abs() + 1.0;
        // Truncation: s^4/90 of the sixth and s^2/4 of the fifth derivative along 2 % of a radian.
        assert!(
            (derivatives[14 + row] - second).abs() < 1e-6 * scale,
            "{row}: {} {second}",
            derivatives[14 + row]
        );
        assert!(
            (derivatives[21 + row] - third).abs() < 1e-3 * scale,
            "{row}: {} {third}",
            derivatives[21 + row]
        );
    }
}
