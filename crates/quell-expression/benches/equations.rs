//! Nanoseconds per point of equations of motion: `cargo bench -p quell-expression`.
//!
//! Every benchmark counts points, so the time of a point is the reciprocal of the items per second. `by_hand` computes
//! all coefficients at every call, `by_hand_prepared` has them at hand, as a program after `prepare` does.

#![expect(clippy::unwrap_used, reason = "a benchmark may panic")]
#![allow(
    dead_code,
    unreachable_pub,
    clippy::panic,
    reason = "the tests share the cases"
)]

#[path = "../tests/cases/mod.rs"]
mod cases;

use cases::{Equations, gear, section};
use divan::{Bencher, black_box, counter::ItemsCount};
use quell_expression::{BatchWorkspace, LANES, Workspace};

fn main() {
    divan::main();
}

/// Points of one call.
const POINTS: usize = 64 * LANES;

fn states<const N: usize>(scale: f64) -> Vec<[f64; N]> {
    let at = |point: usize, axis: usize| {
        let fraction = (0.5 + point as f64 * (axis as f64 + 2.0).sqrt()).fract();
        scale * (2.0 * fraction - 1.0)
    };
    (0..POINTS)
        .map(|point| std::array::from_fn(|axis| at(point, axis)))
        .collect()
}

fn by_hand<const N: usize>(bencher: Bencher, scale: f64, rates: impl Fn(&[f64; N], &mut [f64; N])) {
    let points = states::<N>(scale);
    let mut out = [0.0; N];
    bencher.counter(ItemsCount::new(POINTS)).bench_local(|| {
        for point in &points {
            rates(black_box(point), &mut out);
            black_box(&out);
        }
    });
}

fn alone<const N: usize>(bencher: Bencher, equations: &Equations, scale: f64, level: usize) {
    let program = equations.program();
    let points = states::<N>(scale);
    let mut workspace = Workspace::default();
    program.prepare(&equations.inputs(&[0.0; N]), &mut workspace);
    let mut outputs = vec![0.0; program.outputs(level)];
    bencher.counter(ItemsCount::new(POINTS)).bench_local(|| {
        for point in &points {
            program.evaluate(level, black_box(point), &mut workspace, &mut outputs);
            black_box(&outputs);
        }
    });
}

fn batch<const N: usize>(bencher: Bencher, equations: &Equations, scale: f64, level: usize) {
    let program = equations.program();
    let points: Vec<[[f64; LANES]; N]> = states::<N>(scale)
        .chunks(LANES)
        .map(|chunk| std::array::from_fn(|axis| std::array::from_fn(|lane| chunk[lane][axis])))
        .collect();
    let mut workspace = BatchWorkspace::default();
    program.prepare_batch(&equations.inputs(&[0.0; N]), &mut workspace);
    let mut outputs = vec![[0.0; LANES]; program.outputs(level)];
    bencher.counter(ItemsCount::new(POINTS)).bench_local(|| {
        for point in &points {
            program.evaluate_batch(level, black_box(point), &mut workspace, &mut outputs);
            black_box(&outputs);
        }
    });
}

mod aeroelastic_section {
    use super::{Bencher, alone, batch, black_box, section};

    const SCALE: f64 = 0.1;

    #[divan::bench]
    fn by_hand(bencher: Bencher) {
        let parameters = section::Section::default();
        super::by_hand(bencher, SCALE, |x, out| {
            section::rates(black_box(&parameters), x, out);
        });
    }

    #[divan::bench]
    fn by_hand_prepared(bencher: Bencher) {
        let prepared = section::prepare(&section::Section::default());
        super::by_hand(bencher, SCALE, |x, out| {
            section::prepared_rates(black_box(&prepared), x, out);
        });
    }

    #[divan::bench(args = [0, 1])]
    fn program(bencher: Bencher, level: usize) {
        alone::<6>(bencher, &section::MODEL.equations(), SCALE, level);
    }

    #[divan::bench(args = [0, 1])]
    fn program_batch(bencher: Bencher, level: usize) {
        batch::<6>(bencher, &section::MODEL.equations(), SCALE, level);
    }

    #[divan::bench]
    fn reading_and_compiling(bencher: Bencher) {
        bencher.bench_local(|| section::MODEL.equations().program());
    }
}

mod landing_gear {
    use super::{Bencher, alone, batch, black_box, gear};

    const SCALE: f64 = 0.03;

    #[divan::bench]
    fn by_hand(bencher: Bencher) {
        let parameters = gear::Gear::default();
        super::by_hand(bencher, SCALE, |x, out| {
            gear::rates(black_box(&parameters), x, out);
        });
    }

    #[divan::bench(args = [0, 1])]
    fn program(bencher: Bencher, level: usize) {
        alone::<7>(bencher, &gear::MODEL.equations(), SCALE, level);
    }

    #[divan::bench(args = [0, 1])]
    fn program_batch(bencher: Bencher, level: usize) {
        batch::<7>(bencher, &gear::MODEL.equations(), SCALE, level);
    }

    #[divan::bench]
    fn reading_and_compiling(bencher: Bencher) {
        bencher.bench_local(|| gear::MODEL.equations().program());
    }
}
