//! Branches of periodic orbits.

use std::f64::consts::PI;

use crate::close;
use crate::support::models::*;
use crate::support::{Exact, Field, Real, integrate};
use quell_continuation::{
    Branch, Directions, Kind, MeshSettings, Orbit, Problem, Samples, Settings, Stop, cycles_across,
    cycles_doubled, cycles_from_hopf, cycles_from_samples, equilibria, equilibria_across,
};

use Kind::{CycleBranchPoint, CycleFold, Fold, Hopf, PeriodDoubling, Torus};

pub fn show(b: &Branch<Orbit>, k: usize) -> String {
    use std::fmt::Write;
    let mut out = format!("{} points, stop {:?}\n", b.points.len(), b.stop);
    for s in &b.special {
        let _ = writeln!(
            out,
            "{} {:.12} T {:.10} {:?} {:?} err {:.1e}",
            s.label, s.solution.parameters[k], s.solution.period, s.unstable, s.certainty, s.error
        );
    }
    out
}

fn has(b: &Branch<Orbit>, kind: Kind, k: usize, p: f64, tolerance: f64) -> f64 {
    let best = b
        .of(kind)
        .into_iter()
        .min_by(|x, y| {
            (x.solution.parameters[k] - p)
                .abs()
                .total_cmp(&(y.solution.parameters[k] - p).abs())
        })
        .unwrap_or_else(|| panic!("no {kind}\n{}", show(b, k)));
    assert!(
        (best.solution.parameters[k] - p).abs() <= tolerance * p.abs().max(1e-3),
        "{kind} at {p} not found\n{}",
        show(b, k)
    );
    best.solution.period
}

fn only(b: &Branch<Orbit>, kinds: &[Kind], k: usize) {
    let found: Vec<Kind> = b.special.iter().map(|s| s.kind).collect();
    assert_eq!(found, kinds, "{}", show(b, k));
}

#[test]
fn s1_fold_of_cycles() {
    let problem = Exact::<_, 6>(Section);
    let s = Settings::new(&[(4.0, 30.0)]);
    let e = equilibria(&problem, &[0.0; 6], &[4.0, 5006.7], 0, &s).unwrap();
    let mut s = Settings::new(&[(12.0, 18.5)]);
    s.mesh = MeshSettings::fixed(60, 4);
    let b = cycles_from_hopf(&problem, &e.special[0], 0, &s).unwrap();
    let period = has(&b, CycleFold, 0, 14.660_123_947, 1e-9);
    close(period, 0.418_544_969_6, 1e-9);
    only(&b, &[CycleFold], 0);
    // Tiny multipliers of the lag states are kept.
    let smallest = b.special[0]
        .spectrum
        .iter()
        .map(|m| m.norm())
        .fold(f64::INFINITY, f64::min);
    assert!(smallest < 1e-5 && smallest > 0.0, "{smallest:e}");
}

#[test]
fn s2_fold_of_cycles() {
    let problem = Exact::<_, 4>(Absorber);
    let p = [0.01, 0.95, 0.3];
    let e = equilibria(&problem, &[0.0; 4], &p, 0, &Settings::new(&[(0.01, 0.3)])).unwrap();
    let b = cycles_from_hopf(&problem, &e.special[0], 0, &Settings::new(&[(0.01, 0.3)])).unwrap();
    let period = has(&b, CycleFold, 0, 0.051_244_494_85, 1e-8);
    close(period, 5.296_094_96, 1e-8);
}

fn settle<P: Problem>(
    problem: &P,
    x0: &[f64],
    p: &[f64],
    period: f64,
    warm: usize,
) -> (Vec<f64>, Vec<Vec<f64>>) {
    let per = 400;
    integrate(
        problem,
        x0,
        p,
        period / f64::from(per),
        (warm + 1) * per as usize,
        per as usize + 1,
    )
}

fn forced<P: Problem>(
    problem: &P,
    x0: &[f64],
    p: &[f64],
    warm: usize,
    s: &Settings,
) -> Branch<Orbit> {
    let period = problem.period(p).unwrap();
    let (times, states) = settle(problem, x0, p, period, warm);
    let samples = Samples {
        times: &times,
        states: &states,
        period,
        periods: 1,
        winding: &[],
    };
    cycles_from_samples(problem, &samples, p, 0, s).unwrap()
}

#[test]
fn s3_forced_absorber() {
    let problem = Exact::<_, 4>(ForcedAbsorber);
    let s = Settings::new(&[(0.7, 1.7)]);
    for f in [0.05, 0.09] {
        let b = forced(&problem, &[0.0; 4], &[0.7, f], 200, &s);
        only(&b, &[], 0);
        assert_eq!(b.stop[1], Stop::Bound(0), "{}", show(&b, 0));
    }
    let b = forced(&problem, &[0.0; 4], &[0.7, 0.12], 200, &s);
    only(&b, &[Torus, Torus, CycleFold, CycleFold], 0);
    has(&b, Torus, 0, 1.109_286_761_9, 1e-7);
    has(&b, Torus, 0, 1.227_108_111, 1e-7);
    has(&b, CycleFold, 0, 1.235_195_284_3, 1e-7);
    has(&b, CycleFold, 0, 1.218_073_366_3, 1e-7);
    for p in &b.points {
        assert!(p.spectrum_error < 1e-7, "{:e}", p.spectrum_error);
    }
}

#[test]
fn s4_forced_duffing() {
    let problem = Exact::<_, 2>(Duffing);
    let p = [0.5, 0.2, 0.05];
    let b = forced(&problem, &[0.0; 2], &p, 100, &Settings::new(&[(0.5, 2.5)]));
    only(&b, &[CycleFold, CycleFold], 0);
    has(&b, CycleFold, 0, 1.522_448_136_7, 2e-7);
    has(&b, CycleFold, 0, 1.252_014_990_5, 2e-7);
    for point in &b.points {
        let det: num_complex::Complex64 = point.spectrum.iter().product();
        close(det.re, (-0.1 * point.solution.period).exp(), 1e-7);
    }
}

#[test]
fn s5_period_doublings() {
    let problem = Exact::<_, 3>(Feedback);
    let e = equilibria(
        &problem,
        &[0.0; 3],
        &[1.5, 1.0],
        0,
        &Settings::new(&[(0.3, 1.5)]),
    )
    .unwrap();
    let mut s = Settings::new(&[(0.5, 1.2)]);
    let b = cycles_from_hopf(&problem, &e.special[0], 0, &s).unwrap();
    let period = has(&b, PeriodDoubling, 0, 0.630_302_006_2, 1e-9);
    close(period, 6.364_071_339_4, 1e-9);
    s.ranges = vec![(-0.1, 1.2)];
    s.maximum_points = 300;
    s.mesh.intervals = 60;
    let d = cycles_doubled(&problem, b.labelled("PD1").unwrap(), 0, &s).unwrap();
    let period = has(&d, PeriodDoubling, 0, 0.579_629_841_3, 1e-9);
    close(period, 12.734_365_542, 1e-8);
    has(&d, CycleFold, 0, 0.044_949_123_9, 1e-6);
    has(&d, CycleFold, 0, -0.044_949_123_9, 1e-6);
}

#[test]
fn s8_torus() {
    let problem = Exact::<_, 4>(Peroxidase);
    let e = equilibria(
        &problem,
        &[31.7915, 1.454_61, 0.015_245_9, 0.177_611],
        &[4.2355],
        0,
        &Settings::new(&[(0.5, 5.0)]),
    )
    .unwrap();
    let mut s = Settings::new(&[(0.5, 5.0)]);
    s.maximum_points = 60;
    let b = cycles_from_hopf(&problem, &e.special[0], 0, &s).unwrap();
    let period = has(&b, Torus, 0, 0.716_433_564_4, 1e-8);
    close(period, 10.912_126_88, 1e-7);
    assert_eq!(b.special[0].kind, Torus, "{}", show(&b, 0));
}

#[test]
fn s10_morris_lecar() {
    let problem = Exact::<_, 2>(MorrisLecar);
    let e = equilibria(
        &problem,
        &[-60.855, 0.014_915],
        &[0.0],
        0,
        &Settings::new(&[(0.0, 300.0)]),
    )
    .unwrap();
    let b = cycles_from_hopf(&problem, &e.special[0], 0, &Settings::new(&[(0.0, 300.0)])).unwrap();
    only(&b, &[CycleFold, CycleFold], 0);
    let t = has(&b, CycleFold, 0, 88.293_250_543, 1e-8);
    close(t, 135.386, 4e-6);
    let t = has(&b, CycleFold, 0, 216.899_801_39, 1e-8);
    close(t, 77.9291, 1e-6);
    assert_eq!(b.stop[1], Stop::Vanished);
}

#[test]
fn s12_quintic() {
    let problem = Exact::<_, 2>(Quintic);
    let e = equilibria(
        &problem,
        &[0.0; 2],
        &[-0.5],
        0,
        &Settings::new(&[(-0.5, 0.5)]),
    )
    .unwrap();
    assert!(e.special[0].solution.parameters[0].abs() < 1e-12);
    let b = cycles_from_hopf(&problem, &e.special[0], 0, &Settings::new(&[(-0.5, 0.5)])).unwrap();
    let t = has(&b, CycleFold, 0, -0.25, 1e-9);
    close(t, 2.0 * PI, 1e-9);
    let (low, high) = b.special[0].solution.range(0);
    close(high, 0.5_f64.sqrt(), 1e-8);
    close(low, -(0.5_f64.sqrt()), 1e-8);
}

#[test]
fn s13_van_der_pol_and_its_vertical_family() {
    let problem = Exact::<_, 2>(VanDerPol);
    let e = equilibria(
        &problem,
        &[0.0; 2],
        &[-0.5],
        0,
        &Settings::new(&[(-0.5, 0.5)]),
    )
    .unwrap();
    assert_eq!(e.special.len(), 1);
    let b = cycles_from_hopf(&problem, &e.special[0], 0, &Settings::new(&[(-1.0, 11.0)])).unwrap();
    assert_eq!(b.stop[1], Stop::DegenerateFamily, "{}", show(&b, 0));
    only(&b, &[], 0);
    // From the settled orbit at mu = 1 upwards.
    let (times, states) = settle(&problem, &[2.0, 0.0], &[1.0], 6.6632868593, 20);
    let samples = Samples {
        times: &times,
        states: &states,
        period: 6.663,
        periods: 1,
        winding: &[],
    };
    let mut s = Settings::new(&[(0.5, 10.0)]);
    s.directions = Directions::Forward;
    s.at = vec![5.0, 10.0];
    let b = cycles_from_samples(&problem, &samples, &[1.0], 0, &s).unwrap();
    only(&b, &[], 0);
    close(b.points[0].solution.period, 6.663_286_859_3, 1e-9);
    close(b.points[0].solution.range(0).1, 2.008_619_860_9, 1e-8);
    let five = &b.at[0].solution;
    close(five.period, 11.612_230_667_7, 1e-7);
    close(five.range(0).1, 2.021_508_061_6, 1e-7);
    let ten = &b.points.last().unwrap().solution;
    assert_eq!(ten.parameters[0], 10.0);
    close(ten.period, 19.078_369_566_9, 1e-7);
    close(ten.range(0).1, 2.014_285_360_9, 1e-7);
}

#[test]
fn a1_and_a2() {
    let problem = Exact::<_, 2>(Ab);
    let e = equilibria(
        &problem,
        &[0.0; 2],
        &[0.0, 14.0],
        0,
        &Settings::new(&[(0.0, 0.5)]),
    )
    .unwrap();
    let mut s = Settings::new(&[(0.0, 0.5)]);
    s.at = vec![0.25];
    let b = cycles_from_hopf(&problem, &e.special[0], 0, &s).unwrap();
    close(b.at[0].solution.period, 2.220_34, 1e-4);
    let problem = Exact::<_, 3>(Abc);
    let e = equilibria(
        &problem,
        &[0.0; 3],
        &[0.0],
        0,
        &Settings::new(&[(0.0, 0.4)]),
    )
    .unwrap();
    let mut found = Vec::new();
    for h in e.of(Hopf) {
        let b = cycles_from_hopf(&problem, h, 0, &Settings::new(&[(0.1, 0.4)])).unwrap();
        found.extend(
            b.of(CycleFold)
                .iter()
                .map(|s| (s.solution.parameters[0], s.solution.period)),
        );
    }
    for (d, t) in [
        (0.213_697, 7.611_04),
        (0.211_903, 8.289_14),
        (0.224_962, 6.525_51),
    ] {
        assert!(
            found
                .iter()
                .any(|f| (f.0 / d - 1.0).abs() < 1e-4 && (f.1 / t - 1.0).abs() < 1e-3),
            "{d} not among {found:?}"
        );
    }
}

#[test]
fn a3_lorenz() {
    let problem = Exact::<_, 3>(Lorenz);
    let s = Settings::new(&[(0.0, 30.0)]);
    let e = equilibria(&problem, &[0.0; 3], &[0.0], 0, &s).unwrap();
    let other = equilibria_across(&problem, &e.special[0], 0, 1.0, &s).unwrap();
    let mut s = Settings::new(&[(0.0, 30.0)]);
    s.period_bound = 50.0;
    s.maximum_points = 600;
    let b = cycles_from_hopf(&problem, other.of(Hopf)[0], 0, &s).unwrap();
    assert_eq!(b.stop[1], Stop::PeriodBound, "{}", show(&b, 0));
    let rho = b.points.last().unwrap().solution.parameters[0];
    assert!((rho - 13.9266).abs() < 1e-4, "{rho}");
    let (times, states) = settle(&problem, &[10.0, 20.0, 230.0], &[235.0], 0.474_917, 400);
    let samples = Samples {
        times: &times,
        states: &states,
        period: 0.474_917,
        periods: 1,
        winding: &[],
    };
    let mut s = Settings::new(&[(200.0, 240.0)]);
    s.directions = Directions::Backward;
    let b = cycles_from_samples(&problem, &samples, &[235.0], 0, &s).unwrap();
    let t = has(&b, PeriodDoubling, 0, 229.407, 3e-6);
    close(t, 0.480_867, 1e-4);
    let d = cycles_doubled(&problem, b.of(PeriodDoubling).last().unwrap(), 0, &s).unwrap();
    has(&d, PeriodDoubling, 0, 218.210, 3e-6);
    let d = cycles_doubled(&problem, d.of(PeriodDoubling)[0], 0, &s).unwrap();
    has(&d, PeriodDoubling, 0, 215.966, 3e-6);
}

#[test]
fn a4_rotations() {
    let problem = Exact::<_, 4>(Pendula);
    // Rotations of both pendula, not quite in phase.
    let (times, states) = integrate(&problem, &[0.0, 0.1, 2.0, 2.0], &[0.3], 0.005, 60_000, 5000);
    // One turn of the first pendulum.
    let first = states[0][0];
    let turn = states
        .iter()
        .position(|x| x[0] >= first + 2.0 * PI)
        .unwrap();
    let samples = Samples {
        times: &times[..=turn],
        states: &states[..=turn],
        period: times[turn] - times[0],
        periods: 1,
        winding: &[1, 1],
    };
    let b =
        cycles_from_samples(&problem, &samples, &[0.3], 0, &Settings::new(&[(0.1, 0.5)])).unwrap();
    let t = has(&b, PeriodDoubling, 0, 0.179_163, 1e-4);
    close(t, 3.705_28, 1e-4);
}

#[test]
fn a7_tor() {
    let problem = Exact::<_, 3>(Electronic);
    let e = equilibria(
        &problem,
        &[0.0; 3],
        &[-0.9],
        0,
        &Settings::new(&[(-0.9, -0.3)]),
    )
    .unwrap();
    let s = Settings::new(&[(-0.9, -0.3)]);
    let b = cycles_from_hopf(&problem, e.of(Hopf)[0], 0, &s).unwrap();
    has(&b, CycleFold, 0, -0.584_335, 1e-4);
    has(&b, CycleBranchPoint, 0, -0.587_029, 1e-4);
    let d = cycles_across(&problem, b.of(CycleBranchPoint)[0], 0, 1.0, &s).unwrap();
    let t = has(&d, Torus, 0, -0.591_650, 1e-4);
    close(t, 8.794_15, 1e-4);
    has(&d, PeriodDoubling, 0, -0.614_955, 1e-4);
    has(&d, CycleFold, 0, -0.760_407, 1e-4);
}

#[test]
fn a8_plp() {
    let problem = Exact::<_, 2>(Enzyme);
    let e = equilibria(
        &problem,
        &[110.0, 500.0],
        &[0.0, 110.0],
        0,
        &Settings::new(&[(0.0, 10.0)]),
    )
    .unwrap();
    let b = cycles_from_hopf(&problem, e.of(Hopf)[0], 0, &Settings::new(&[(0.0, 10.0)])).unwrap();
    let t = has(&b, CycleFold, 0, 2.759_69, 1e-4);
    close(t, 10.0064, 1e-4);
    let t = has(&b, CycleFold, 0, 5.007_84, 1e-4);
    close(t, 5.676_58, 1e-4);
    let _ = Fold;
}

/// The cycle r = 1 of r' = r (1 - r²) + c, with a third state z' = (a + d cos θ) z: multipliers exp(-4π) and exp(2πa).
struct Known;
impl Field for Known {
    const N: usize = 3;
    const P: usize = 2;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        let s = x[0] * x[0] + x[1] * x[1];
        let g = R::from(1.0) - s;
        out[0] = g * x[0] - x[1];
        out[1] = g * x[1] + x[0];
        out[2] = (p[0] + p[1] * x[0]) * x[2];
    }
}

fn circle(n: usize, z: f64) -> (Vec<f64>, Vec<Vec<f64>>) {
    let times: Vec<f64> = (0..=200).map(|k| 2.0 * PI * f64::from(k) / 200.0).collect();
    let states = times
        .iter()
        .map(|t| {
            let mut x = vec![z; n];
            (x[0], x[1]) = (t.cos(), t.sin());
            x
        })
        .collect();
    (times, states)
}

#[test]
fn multipliers_of_a_known_cycle() {
    let problem = Exact::<_, 3>(Known);
    let (times, states) = circle(3, 0.0);
    let samples = Samples {
        times: &times,
        states: &states,
        period: 6.2,
        periods: 1,
        winding: &[],
    };
    for a in [0.3, -1.0, -3.0, -3.7] {
        let mut s = Settings::new(&[(a - 1.0, a + 1.0)]);
        s.maximum_points = 1;
        s.mesh = MeshSettings::fixed(60, 6);
        let b = cycles_from_samples(&problem, &samples, &[a, 0.5], 0, &s).unwrap();
        let mut found: Vec<f64> = b.points[0].spectrum.iter().map(|v| v.norm().ln()).collect();
        found.sort_by(f64::total_cmp);
        let mut expected = [-4.0 * PI, 2.0 * PI * a];
        expected.sort_by(f64::total_cmp);
        for (f, e) in found.iter().zip(expected) {
            assert!((f - e).abs() < 1e-9 * e.abs(), "{f} {e}");
        }
        assert!(b.points[0].spectrum_error < 1e-9);
    }
}

#[test]
fn collocation_shows_its_order() {
    // Superconvergence of order 2m at mesh points, seen in the period of a cycle with θ' = 1 + x/2.
    let problem = Exact::<_, 2>(Uneven);
    let exact = 2.0 * PI / (1.0_f64 - 0.25).sqrt();
    for m in 2..=4 {
        let mut errors = Vec::new();
        for count in [10, 20] {
            let (times, states) = circle(2, 0.0);
            let times: Vec<f64> = times.iter().map(|t| t * exact / (2.0 * PI)).collect();
            let samples = Samples {
                times: &times,
                states: &states,
                period: exact,
                periods: 1,
                winding: &[],
            };
            let mut s = Settings::new(&[(0.0, 1.0)]);
            s.maximum_points = 1;
            s.newton_tolerance = 1e-13;
            s.mesh = MeshSettings {
                every: 0,
                ..MeshSettings::fixed(count, m)
            };
            let b = cycles_from_samples(&problem, &samples, &[0.5], 0, &s).unwrap();
            errors.push((b.points[0].solution.period - exact).abs());
        }
        let order = (errors[0] / errors[1]).log2();
        assert!(
            (order - 2.0 * m as f64).abs() < 0.6,
            "degree {m}: order {order}, errors {errors:?}"
        );
    }
}

struct Uneven;
impl Field for Uneven {
    const N: usize = 2;
    const P: usize = 1;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        let s = x[0] * x[0] + x[1] * x[1];
        let g = R::from(1.0) - s;
        let w = R::from(1.0) + p[0] * x[0];
        out[0] = g * x[0] - w * x[1];
        out[1] = g * x[1] + w * x[0];
    }
}
