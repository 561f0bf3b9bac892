//! Cost of a simulation: `cargo bench -p quell-response --bench transient`.
//!
//! Touch-down of two masses with a strut: a linear one by exact propagation, the one with gas spring and orifice by the general
//! integrator at a relative tolerance of 1e-8; to the event that ends the run, without and with the criteria that a study
//! reads. `transient_scipy.py` beside this file times SciPy's RK45 on the same.

#![expect(clippy::expect_used, reason = "a benchmark that cannot be set up ends")]

use quell_response::transient::{
    Condition, Direction, Dynamics, Event, Method, Record, Settings, Trajectory, simulate,
};

#[path = "../tests/transient/strut.rs"]
mod strut;

use strut::{Layout, Linear};

fn main() {
    divan::main();
}

fn run(system: &mut dyn Dynamics, start: &[f64], settings: &Settings) -> Trajectory {
    let end = Event::on(strut::RATE, Direction::Falling)
        .armed(Condition::above(strut::RATE, 0.0))
        .ending();
    simulate(system, start, (0.0, 1.0), &[end], settings).expect("a run")
}

fn criteria(system: &mut dyn Dynamics, trajectory: &Trajectory) -> [f64; 5] {
    let t = trajectory.to();
    let mut record = Record::new(trajectory, system);
    let force = record.maximum(strut::FORCE).value;
    let stroke = record.maximum(strut::STROKE).value;
    let work = record.integral_over(strut::FORCE, strut::STROKE).value;
    [
        work / (force * stroke),
        force,
        stroke,
        record.value(strut::UPPER, t),
        record.integral(strut::DISSIPATED).value,
    ]
}

fn linear(case: &str) -> Linear {
    match case {
        "parallel" => Linear::new(
            Layout::Parallel {
                c: 171.4,
                b: 14.558,
            },
            13411.0,
        ),
        "branch" => Linear::new(
            Layout::Branch {
                c: 1281.3,
                b: 24.59,
                k: 43298.0,
            },
            4884.2,
        ),
        _ => Linear::double(Layout::Parallel { c: 1000.0, b: 0.0 }, 0.0, 0.4737),
    }
}

const CASES: [&str; 3] = ["parallel", "branch", "double stage"];

#[divan::bench(args = CASES)]
fn linear_run(bencher: divan::Bencher<'_, '_>, case: &str) {
    let mut system = linear(case);
    let start = system.start();
    bencher.bench_local(|| run(&mut system, &start, &Settings::default()));
}

#[divan::bench(args = CASES)]
fn linear_run_and_criteria(bencher: divan::Bencher<'_, '_>, case: &str) {
    let mut system = linear(case);
    let start = system.start();
    bencher.bench_local(|| {
        let trajectory = run(&mut system, &start, &Settings::default());
        criteria(&mut system, &trajectory)
    });
}

const METHODS: [Method; 4] = [
    Method::Automatic,
    Method::Explicit,
    Method::Stiff,
    Method::StiffOscillating,
];

#[divan::bench(args = METHODS)]
fn default_run(bencher: divan::Bencher<'_, '_>, method: Method) {
    let start = strut::Default::start();
    let settings = Settings::with_method(method);
    bencher.bench_local(|| run(&mut strut::Default, &start, &settings));
}

#[divan::bench]
fn default_run_and_criteria(bencher: divan::Bencher<'_, '_>) {
    let start = strut::Default::start();
    bencher.bench_local(|| {
        let trajectory = run(&mut strut::Default, &start, &Settings::default());
        criteria(&mut strut::Default, &trajectory)
    });
}

/// Steps of the library on a system of 8 states: eight uncoupled oscillators' worth of overhead.
#[divan::bench(args = [Method::Explicit, Method::Stiff])]
fn overhead_of_a_thousand_steps(bencher: divan::Bencher<'_, '_>, method: Method) {
    struct Chain;
    impl Dynamics for Chain {
        fn states(&self) -> usize {
            8
        }
        fn rates(&mut self, _t: f64, x: &[f64], rates: &mut [f64]) {
            for i in 0..4 {
                rates[i] = x[4 + i];
                rates[4 + i] = -x[i];
            }
        }
    }
    let mut settings = Settings::with_method(method);
    settings.step_limit = 1000;
    let start = [1.0, 0.5, -0.3, 0.2, 0.0, 0.0, 0.0, 0.0];
    bencher
        .bench_local(|| simulate(&mut Chain, &start, (0.0, 1e6), &[], &settings).expect("a run"));
}
