//! Nanoseconds per element and frequency of a network's evaluation: `cargo bench -p quell-network`.
//!
//! divan counts one item per element and frequency, so the items per second it prints are the reciprocal.

#![expect(clippy::unwrap_used, reason = "a benchmark may panic")]

use divan::{Bencher, black_box, counter::ItemsCount};
use num_complex::Complex64;
use quell_network::{
    Budget, Domain, Enumeration, Equivalence, Kinds, Layout, Network, RatioGrid, Workspace,
};

fn main() {
    divan::main();
}

/// Layouts of mechanical elements, and a hydraulic one that becomes two springs around four passageways.
const LAYOUTS: [(&str, Domain); 4] = [
    ("k1 | c1 + b1", Domain::Translational),
    ("k1 + (k2 | c1 | b1 | c2 + b2)", Domain::Translational),
    (
        "C1 | C2 + (I1 + R1 | I2 + R2 | I3 + (R3 | R4))",
        Domain::Hydraulic,
    ),
    (
        "k1 + (c1 | b1) | k2 + (c2 | b2) + (k3 | b3)",
        Domain::Translational,
    ),
];

fn network(index: usize) -> (Network, Vec<f64>) {
    let (text, domain) = LAYOUTS[index];
    let layout = Layout::parse(text, &Kinds::new(domain)).unwrap();
    let network = Network::from_layout(&layout, Some(1.0)).unwrap();
    let values = (0..network.elements().len())
        .map(|i| 1.0 + 0.1 * i as f64)
        .collect();
    (network, values)
}

const FREQUENCIES: usize = 256;

fn omegas() -> Vec<f64> {
    (0..FREQUENCIES).map(|i| 0.1 + 0.01 * i as f64).collect()
}

#[divan::bench(args = 0..LAYOUTS.len())]
fn ratio_grid(bencher: Bencher, index: usize) {
    let (network, values) = network(index);
    let omegas = omegas();
    let (mut workspace, mut grid) = (Workspace::new(), RatioGrid::new());
    bencher
        .counter(ItemsCount::new(FREQUENCIES * values.len()))
        .bench_local(|| {
            network.ratio_grid(
                black_box(&omegas),
                black_box(&values),
                &mut workspace,
                &mut grid,
            );
            black_box(&grid);
        });
}

#[divan::bench(args = 0..LAYOUTS.len())]
fn dynamic_stiffness(bencher: Bencher, index: usize) {
    let (network, values) = network(index);
    let omegas = omegas();
    bencher
        .counter(ItemsCount::new(FREQUENCIES * values.len()))
        .bench_local(|| {
            omegas
                .iter()
                .map(|omega| network.dynamic_stiffness(*omega, black_box(&values)))
                .sum::<Complex64>()
        });
}

#[divan::bench(args = 0..LAYOUTS.len())]
fn gradient(bencher: Bencher, index: usize) {
    let (network, values) = network(index);
    let omegas = omegas();
    let mut workspace = Workspace::new();
    let mut out = vec![Complex64::ZERO; values.len()];
    bencher
        .counter(ItemsCount::new(FREQUENCIES * values.len()))
        .bench_local(|| {
            for omega in &omegas {
                black_box(network.gradient_ratio(
                    *omega,
                    black_box(&values),
                    &mut workspace,
                    &mut out,
                ));
            }
        });
}

/// One layout of ten branches of three kinds by its index.
#[divan::bench]
fn unrank_ten_branches(bencher: Bencher) {
    let budgets = ["k", "c", "b"].map(Budget::any);
    let kinds = Kinds::new(Domain::Translational);
    let all = Enumeration::new(&kinds, &budgets, Some(10), Equivalence::Irreducible).unwrap();
    let mut index = 0;
    bencher.bench_local(|| {
        index = (index + 7_919) % all.count();
        all.nth(black_box(index))
    });
}

/// The tables of an enumeration of ten branches of three kinds.
#[divan::bench]
fn count_ten_branches() -> u128 {
    let budgets = ["k", "c", "b"].map(Budget::any);
    let kinds = Kinds::new(Domain::Translational);
    Enumeration::new(&kinds, &budgets, Some(10), Equivalence::Irreducible)
        .unwrap()
        .count()
}
