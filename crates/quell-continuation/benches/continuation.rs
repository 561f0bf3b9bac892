//! The work of the reference table, a point at a time: `cargo bench -p quell-continuation`. Items are points of a branch.
#![allow(missing_docs, clippy::wildcard_imports)]

#[path = "../tests/support/mod.rs"]
mod support;

use divan::Bencher;
use divan::counter::ItemsCount;
use quell_continuation::{
    Branch, Kind, MeshSettings, Orbit, Problem, Samples, Settings, Special, cycle_curve,
    cycles_from_hopf, cycles_from_samples, equilibria,
};
use support::models::*;
use support::{Exact, integrate};

fn main() {
    divan::main();
}

fn fixed(range: &[(f64, f64)], intervals: usize, points: usize) -> Settings {
    let mut s = Settings::new(range);
    s.mesh = MeshSettings::fixed(intervals, 4);
    s.maximum_points = points;
    s
}

/// One run to count points, then timed runs.
fn timed<S>(bencher: Bencher<'_, '_>, run: impl Fn() -> Option<Branch<S>> + Sync) {
    let points = run().map_or(1, |b| b.points.len());
    bencher.counter(ItemsCount::new(points)).bench(run);
}

fn hopf(
    problem: &dyn Problem,
    x: &[f64],
    p: &[f64],
    range: (f64, f64),
) -> Option<Special<quell_continuation::Equilibrium>> {
    equilibria(problem, x, p, 0, &Settings::new(&[range]))
        .ok()?
        .special
        .into_iter()
        .find(|s| s.kind == Kind::Hopf)
}

#[divan::bench]
fn lorenz_cycles_35(bencher: Bencher<'_, '_>) {
    let problem = Exact::<_, 3>(Lorenz);
    let c = (8.0 / 3.0 * 27.0_f64).sqrt();
    let Some(h) = hopf(&problem, &[c, c, 27.0], &[28.0], (20.0, 28.0)) else {
        return;
    };
    let s = fixed(&[(14.5, 28.0)], 35, 100);
    timed(bencher, || cycles_from_hopf(&problem, &h, 0, &s).ok());
}

#[divan::bench]
fn section_cycles_60(bencher: Bencher<'_, '_>) {
    let problem = Exact::<_, 6>(Section);
    let Some(h) = hopf(&problem, &[0.0; 6], &[16.0, 5006.7], (16.0, 19.0)) else {
        return;
    };
    let s = fixed(&[(12.0, 18.5)], 60, 100);
    timed(bencher, || cycles_from_hopf(&problem, &h, 0, &s).ok());
}

#[divan::bench]
fn section_cycles_60_without_detection(bencher: Bencher<'_, '_>) {
    let problem = Exact::<_, 6>(Section);
    let Some(h) = hopf(&problem, &[0.0; 6], &[16.0, 5006.7], (16.0, 19.0)) else {
        return;
    };
    let mut s = fixed(&[(12.0, 18.5)], 60, 100);
    s.detect = false;
    timed(bencher, || cycles_from_hopf(&problem, &h, 0, &s).ok());
}

fn forced(s: &Settings) -> Option<Branch<Orbit>> {
    let problem = Exact::<_, 4>(ForcedAbsorber);
    let p = [0.7, 0.12];
    let period = problem.period(&p)?;
    let (times, states) = integrate(&problem, &[0.0; 4], &p, period / 200.0, 20_000, 201);
    let samples = Samples {
        times: &times,
        states: &states,
        period,
        periods: 1,
        winding: &[],
    };
    cycles_from_samples(&problem, &samples, &p, 0, s).ok()
}

#[divan::bench]
fn forced_absorber_60(bencher: Bencher<'_, '_>) {
    let s = fixed(&[(0.7, 1.7)], 60, 300);
    timed(bencher, || forced(&s));
}

#[divan::bench]
fn forced_torus_curve_60(bencher: Bencher<'_, '_>) {
    let problem = Exact::<_, 4>(ForcedAbsorber);
    let Some(b) = forced(&fixed(&[(0.7, 1.7)], 60, 300)) else {
        return;
    };
    let Some(torus) = b.special.iter().find(|s| s.kind == Kind::Torus) else {
        return;
    };
    let s = fixed(&[(0.7, 2.0), (0.05, 0.3)], 60, 60);
    timed(bencher, || cycle_curve(&problem, torus, [0, 1], &s).ok());
}

#[divan::bench]
fn section_fold_curve_60(bencher: Bencher<'_, '_>) {
    let problem = Exact::<_, 6>(Section);
    let Some(h) = hopf(&problem, &[0.0; 6], &[16.0, 5006.7], (16.0, 19.0)) else {
        return;
    };
    let Ok(b) = cycles_from_hopf(&problem, &h, 0, &fixed(&[(12.0, 18.5)], 60, 100)) else {
        return;
    };
    let Some(fold) = b.special.iter().find(|s| s.kind == Kind::CycleFold) else {
        return;
    };
    let s = fixed(&[(10.0, 17.0), (2000.0, 9000.0)], 60, 60);
    timed(bencher, || cycle_curve(&problem, fold, [0, 1], &s).ok());
}

#[divan::bench]
fn feedback_cycles_60(bencher: Bencher<'_, '_>) {
    let problem = Exact::<_, 3>(Feedback);
    let Some(h) = hopf(&problem, &[0.0; 3], &[1.2, 1.0], (0.5, 1.2)) else {
        return;
    };
    let s = fixed(&[(0.5, 1.2)], 60, 100);
    timed(bencher, || cycles_from_hopf(&problem, &h, 0, &s).ok());
}

#[divan::bench]
fn feedback_doubling_curve_60(bencher: Bencher<'_, '_>) {
    let problem = Exact::<_, 3>(Feedback);
    let Some(h) = hopf(&problem, &[0.0; 3], &[1.2, 1.0], (0.5, 1.2)) else {
        return;
    };
    let Ok(b) = cycles_from_hopf(&problem, &h, 0, &fixed(&[(0.5, 1.2)], 60, 100)) else {
        return;
    };
    let Some(pd) = b.special.iter().find(|s| s.kind == Kind::PeriodDoubling) else {
        return;
    };
    let s = fixed(&[(-0.2, 1.2), (0.4, 2.0)], 60, 60);
    timed(bencher, || cycle_curve(&problem, pd, [0, 1], &s).ok());
}

fn chain<const K: usize>(bencher: Bencher<'_, '_>, intervals: usize) {
    let problem = Exact::<_, K>(Chain::<K>);
    let Some(h) = hopf(&problem, &[0.0; K], &[-0.5], (-0.5, 0.5)) else {
        return;
    };
    let s = fixed(&[(-0.5, 1.0)], intervals, 15);
    timed(bencher, || cycles_from_hopf(&problem, &h, 0, &s).ok());
}

#[divan::bench(args = [20, 40, 80])]
fn chain_of_8_states(bencher: Bencher<'_, '_>, intervals: usize) {
    chain::<8>(bencher, intervals);
}

#[divan::bench(args = [20])]
fn chain_of_10_states(bencher: Bencher<'_, '_>, intervals: usize) {
    chain::<10>(bencher, intervals);
}

#[divan::bench(args = [20])]
fn chain_of_20_states(bencher: Bencher<'_, '_>, intervals: usize) {
    chain::<20>(bencher, intervals);
}

#[divan::bench(args = [20])]
fn chain_of_40_states(bencher: Bencher<'_, '_>, intervals: usize) {
    chain::<40>(bencher, intervals);
}
