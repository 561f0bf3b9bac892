//! Cost of one candidate: `cargo bench -p quell-response --bench frequency`.
//!
//! One mass on a moving base, one port, 0 to 30 Hz; devices of 1, 4 and 8 elements.

#![expect(clippy::expect_used, reason = "a benchmark that cannot be set up ends")]

use std::f64::consts::TAU;
use std::sync::Arc;

use faer::mat;
use quell_expression::Dimension;
use quell_model::linear::{
    Coordinate, CoordinateKind, Input, InputKind, LinearForm, LinearHost, Port, Signal,
};
use quell_network::{Domain, Kinds, Layout, Network};
use quell_response::{Assembly, Attached, Plan, PlanSettings, Scratch, certify, h2_fast};

fn main() {
    divan::main();
}

const LAYOUTS: [&str; 3] = [
    "c1",
    "k1 + (k2 | c1 | b1)",
    "k1 + (k2 | (c1 | b1) + c2 + (b2 | c3 + c4))",
];

fn values(count: usize) -> Vec<f64> {
    // Of the size that a fluid-filled isolator has; all different, so that nothing cancels by chance.
    let typical = [2.0833e5, 2403.8, 656.25, 23.75, 900.0, 31.0, 450.0, 700.0];
    if count == 1 {
        vec![650.0]
    } else {
        typical[..count].to_vec()
    }
}

fn plan(layout: &str) -> Plan {
    let host = LinearHost {
        name: "bench".into(),
        coordinates: vec![Coordinate {
            name: "x".into(),
            kind: CoordinateKind::Translation,
        }],
        mass: mat![[60.0]],
        damping: mat![[105.0]],
        stiffness: mat![[2.25e5]],
        loss: None,
        inputs: vec![Input {
            name: "xs".into(),
            kind: InputKind::Displacement,
            motion: CoordinateKind::Translation,
            dimension: Dimension::LENGTH,
        }],
        forcing: [mat![[2.25e5]], mat![[105.0]], mat![[0.0]]],
        ports: vec![Port {
            name: "port".into(),
            coordinates: vec![1.0],
            inputs: vec![-1.0],
            kind: CoordinateKind::Translation,
            hangs: false,
            grounded: false,
        }],
        outputs: vec![],
    };
    let layout = Layout::parse(layout, &Kinds::new(Domain::Translational)).expect("a layout");
    let network = Arc::new(Network::from_layout(&layout, None).expect("a network"));
    let assembly = Arc::new(
        Assembly::new(Arc::new(host), vec![Attached { port: 0, network }]).expect("an assembly"),
    );
    Plan::new(
        &assembly,
        0,
        &output(),
        (0.0, 30.0 * TAU),
        PlanSettings::default(),
    )
    .expect("a plan")
}

fn output() -> LinearForm {
    LinearForm {
        terms: vec![
            (Signal::Coordinate { index: 0, order: 0 }, 1.0),
            (Signal::Input { index: 0, order: 0 }, -1.0),
        ],
    }
}

#[divan::bench(args = LAYOUTS)]
fn peak(bencher: divan::Bencher<'_, '_>, layout: &str) {
    let plan = plan(layout);
    let values = values(plan.assembly().elements());
    let mut scratch = Scratch::new();
    bencher.bench_local(|| plan.peak(divan::black_box(&values), &mut scratch));
}

#[divan::bench(args = LAYOUTS)]
fn pieces(bencher: divan::Bencher<'_, '_>, layout: &str) {
    let plan = plan(layout);
    let values = values(plan.assembly().elements());
    let mut scratch = Scratch::new();
    let mut pieces = Vec::new();
    bencher.bench_local(|| plan.pieces(divan::black_box(&values), 0.5, &mut scratch, &mut pieces));
}

#[divan::bench(args = LAYOUTS)]
fn certificate(bencher: divan::Bencher<'_, '_>, layout: &str) {
    let plan = plan(layout);
    let values = values(plan.assembly().elements());
    bencher.bench_local(|| {
        certify(
            plan.assembly(),
            divan::black_box(&values),
            0,
            &output(),
            plan.band(),
            1e-6,
        )
    });
}

#[divan::bench(args = LAYOUTS)]
fn modes(bencher: divan::Bencher<'_, '_>, layout: &str) {
    let plan = plan(layout);
    let values = values(plan.assembly().elements());
    bencher.bench_local(|| plan.assembly().eigenvalues(divan::black_box(&values)));
}

#[divan::bench(args = LAYOUTS)]
fn variance(bencher: divan::Bencher<'_, '_>, layout: &str) {
    let plan = plan(layout);
    let values = values(plan.assembly().elements());
    // The stroke tends to -1 at high frequency; the mass's displacement has a variance.
    let output = LinearForm {
        terms: vec![(Signal::Coordinate { index: 0, order: 0 }, 1.0)],
    };
    bencher.bench_local(|| h2_fast(plan.assembly(), divan::black_box(&values), 0, &output));
}
