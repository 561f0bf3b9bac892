//! A gear with two wheels as a compiled system: `cargo bench -p quell-model --bench system`.
//!
//! Counters are points, so that items per second compare scalar, batched and hand-written evaluation.

#![expect(clippy::unwrap_used, reason = "a benchmark may panic")]
#![allow(
    dead_code,
    unreachable_pub,
    clippy::panic,
    reason = "the cases are shared with tests of expressions"
)]

#[path = "../../quell-expression/tests/cases/mod.rs"]
mod cases;

use std::path::Path;

use cases::gear;
use divan::{Bencher, black_box, counter::ItemsCount};
use quell_expression::LANES;
use quell_model::system::{Device, Phase, System};
use quell_model::{EquationHost, HostFile};
use quell_network::{Domain, Kinds, Layout, Mechanism};

fn main() {
    divan::main();
}

const POINTS: usize = 16 * LANES;

fn host() -> EquationHost {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures");
    HostFile::read(folder.join("two-wheels.toml"))
        .and_then(|file| file.equations(&[]))
        .unwrap()
}

fn device(layout: &str) -> Device {
    let layout = Layout::parse(layout, &Kinds::new(Domain::Rotational)).unwrap();
    let mechanism = Mechanism::from_layout(&layout, None).unwrap();
    Device::new("damper".into(), 0, mechanism)
        .with_value("k1", 1.09e5)
        .with_value("c1", 36000.0)
}

fn system() -> System {
    System::new(&host(), &[device("k1 | c1")], &[], Phase::Free).unwrap()
}

fn points() -> Vec<[f64; 7]> {
    let at = |point: usize, axis: usize| {
        let fraction = (0.5 + point as f64 * (axis as f64 + 2.0).sqrt()).fract();
        0.05 * (2.0 * fraction - 1.0)
    };
    (0..POINTS)
        .map(|point| std::array::from_fn(|axis| at(point, axis)))
        .collect()
}

fn lanes() -> Vec<Vec<[f64; LANES]>> {
    points()
        .chunks(LANES)
        .map(|chunk| {
            (0..7)
                .map(|i| std::array::from_fn(|lane| chunk[lane][i]))
                .collect()
        })
        .collect()
}

#[divan::bench]
fn rates_by_hand(bencher: Bencher) {
    let (gear, points) = (gear::Gear::default(), points());
    let mut out = [0.0; 7];
    bencher.counter(ItemsCount::new(POINTS)).bench_local(|| {
        for point in &points {
            gear::rates(&gear, black_box(point), &mut out);
            black_box(&out);
        }
    });
}

#[divan::bench]
fn rates(bencher: Bencher) {
    let (system, points) = (system(), points());
    let mut prepared = system.prepare(&system.defaults());
    let mut out = [0.0; 7];
    bencher.counter(ItemsCount::new(POINTS)).bench_local(|| {
        for point in &points {
            prepared.rates(0.0, black_box(point), &mut out);
            black_box(&out);
        }
    });
}

#[divan::bench]
fn rates_and_jacobian(bencher: Bencher) {
    let (system, points) = (system(), points());
    let mut prepared = system.prepare(&system.defaults());
    let (mut out, mut jacobian) = ([0.0; 7], [0.0; 49]);
    bencher.counter(ItemsCount::new(POINTS)).bench_local(|| {
        for point in &points {
            prepared.jacobian(0.0, black_box(point), &mut out, &mut jacobian);
            black_box(&jacobian);
        }
    });
}

#[divan::bench]
fn rates_batched(bencher: Bencher) {
    let (system, lanes) = (system(), lanes());
    let mut batch = system.prepare_batch(&system.defaults());
    let mut out = [[0.0; LANES]; 7];
    bencher.counter(ItemsCount::new(POINTS)).bench_local(|| {
        for x in &lanes {
            batch.rates(&[0.0; LANES], black_box(x), &mut out);
            black_box(&out);
        }
    });
}

#[divan::bench]
fn rates_and_jacobian_batched(bencher: Bencher) {
    let (system, lanes) = (system(), lanes());
    let mut batch = system.prepare_batch(&system.defaults());
    let (mut out, mut jacobian) = ([[0.0; LANES]; 7], [[0.0; LANES]; 49]);
    bencher.counter(ItemsCount::new(POINTS)).bench_local(|| {
        for x in &lanes {
            batch.jacobian(&[0.0; LANES], black_box(x), &mut out, &mut jacobian);
            black_box(&jacobian);
        }
    });
}

#[divan::bench(args = ["k1 | c1", "(k1 | c1) + (k2 | b1)"])]
fn new(bencher: Bencher, layout: &str) {
    let (host, device) = (host(), device(layout));
    bencher.bench_local(|| {
        System::new(&host, std::slice::from_ref(&device), &[], Phase::Free).unwrap()
    });
}

#[divan::bench]
fn prepare(bencher: Bencher) {
    let system = system();
    let parameters = system.defaults();
    let mut prepared = system.prepare(&parameters);
    bencher.bench_local(|| prepared.set_parameters(black_box(&parameters)));
}
