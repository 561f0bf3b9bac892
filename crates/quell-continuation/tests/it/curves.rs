//! Curves of folds and Hopf points, and of special points of cycles.

use crate::close;
use crate::support::models::*;
use crate::support::{Exact, Field, Real};
use quell_continuation::{
    Branch, CriticalEquilibrium, CriticalOrbit, Kind, MeshSettings, Samples, Settings, Stop,
    cycle_curve, cycles_from_hopf, cycles_from_orbit, cycles_from_samples, equilibria, fold_curve,
    fold_from_generalised_hopf, hopf_curve, torus_from_hopf_hopf,
};

use Kind::{BogdanovTakens, Cusp, Fold, GeneralisedHopf, Hopf, HopfHopf, ZeroHopf};

fn show(b: &Branch<CriticalEquilibrium>, k: [usize; 2]) -> String {
    use std::fmt::Write;
    let mut out = format!("{} points, stop {:?}\n", b.points.len(), b.stop);
    for s in &b.special {
        let p = &s.solution.equilibrium.parameters;
        let _ = writeln!(
            out,
            "{} ({:.9}, {:.9}) {:?} {:?} {:?}",
            s.label, p[k[0]], p[k[1]], s.omega, s.second_omega, s.normal_form
        );
    }
    out
}

fn has(b: &Branch<CriticalEquilibrium>, kind: Kind, k: [usize; 2], at: [f64; 2], unit: f64) {
    let found = b.of(kind).iter().any(|s| {
        let p = &s.solution.equilibrium.parameters;
        (p[k[0]] - at[0]).abs() <= unit && (p[k[1]] - at[1]).abs() <= unit
    });
    assert!(found, "{kind} at {at:?} not found\n{}", show(b, k));
}

#[test]
fn s1_generalised_hopf() {
    let problem = Exact::<_, 6>(Section);
    let e = equilibria(
        &problem,
        &[0.0; 6],
        &[4.0, 5006.7],
        0,
        &Settings::new(&[(4.0, 30.0)]),
    )
    .unwrap();
    let s = Settings::new(&[(4.0, 30.0), (0.0, 20000.0)]);
    // U of the Hopf point does not depend on k_a3: the second parameter leads.
    let s2 = Settings {
        ranges: vec![s.ranges[1], s.ranges[0]],
        ..s
    };
    let c = hopf_curve(&problem, &e.special[0], [1, 0], &s2).unwrap();
    assert_eq!(c.of(GeneralisedHopf).len(), 1, "{}", show(&c, [0, 1]));
    close(
        c.of(GeneralisedHopf)[0].solution.equilibrium.parameters[1],
        1.0446e4,
        5e-5,
    );
}

#[test]
fn s2_hopf_curve_crosses_itself() {
    let problem = Exact::<_, 4>(Absorber);
    let e = equilibria(
        &problem,
        &[0.0; 4],
        &[0.01, 0.95, 0.3],
        0,
        &Settings::new(&[(0.01, 0.3)]),
    )
    .unwrap();
    let s = Settings::new(&[(0.01, 0.3), (0.9, 1.05)]);
    let c = hopf_curve(&problem, &e.special[0], [0, 1], &s).unwrap();
    let hh = c.of(HopfHopf);
    assert_eq!(hh.len(), 2, "{}", show(&c, [0, 1]));
    for h in hh {
        let p = &h.solution.equilibrium.parameters;
        assert!((p[0] - 0.05_f64.sqrt() / 2.0).abs() < 1e-8);
        assert!((p[1] - 1.0 / 1.05_f64.sqrt()).abs() < 1e-8);
    }
    // The extremum in mu1: the top of a parabola through three exact points 2e-6 apart, whose error is of the order of their
    // distance cubed.
    let lam = 0.976_044_4;
    let mut s = Settings::new(&[(0.9, 1.05), (0.01, 0.3)]);
    s.at = vec![lam - 2e-6, lam, lam + 2e-6];
    let c = hopf_curve(&problem, &e.special[0], [1, 0], &s).unwrap();
    let top = |lam: f64| {
        let points = c.at.iter().map(|p| &p.solution.equilibrium.parameters);
        points
            .filter(|p| (p[1] - lam).abs() < 1e-9)
            .map(|p| p[0])
            .fold(0.0, f64::max)
    };
    let [low, middle, high] = [top(s.at[0]), top(s.at[1]), top(s.at[2])];
    let (slope, bend) = (0.5 * (high - low), high - 2.0 * middle + low);
    close(
        middle - 0.5 * slope * slope / bend,
        0.113_167_1,
        5e-8 / 0.113,
    );
    close(lam - 2e-6 * slope / bend, 0.976_044_4, 1e-6);
}

#[test]
fn s6_oxidation() {
    let problem = Exact::<_, 3>(Oxidation);
    let e = equilibria(
        &problem,
        &[0.001_338_78, 0.833_309, 0.118_109],
        &[2.0, 0.4],
        0,
        &Settings::new(&[(0.5, 2.0)]),
    )
    .unwrap();
    let s = Settings::new(&[(0.5, 2.0), (0.0, 2.0)]);
    let f = fold_curve(&problem, &e.of(Fold)[0].solution, [0, 1], &s).unwrap();
    has(&f, BogdanovTakens, [0, 1], [1.161_198_7, 0.722_339_1], 6e-8);
    has(&f, BogdanovTakens, [0, 1], [1.417_627_6, 0.971_397_6], 6e-8);
    has(&f, Cusp, [0, 1], [1.006_408_3, 0.355_991_3], 6e-8);
    let mut found = Vec::new();
    for h in e.of(Hopf) {
        let c = hopf_curve(&problem, h, [0, 1], &s).unwrap();
        for g in c.of(GeneralisedHopf) {
            found.push(g.solution.equilibrium.parameters.clone());
        }
        has(&c, BogdanovTakens, [0, 1], [1.161_198_7, 0.722_339_1], 6e-8);
    }
    for at in [[0.924_254_9, 0.305_879_2], [0.891_318_9, 0.232_487_3]] {
        assert!(
            found
                .iter()
                .any(|p| (p[0] - at[0]).abs() < 5e-7 && (p[1] - at[1]).abs() < 2e-7),
            "{at:?} in {found:?}"
        );
    }
}

#[test]
fn s7_lorenz84() {
    let problem = Exact::<_, 4>(Lorenz84);
    let e = equilibria(
        &problem,
        &[2.978_70, -0.038_683, 0.058_232_7, -0.021_052_9],
        &[3.0, 0.04],
        0,
        &Settings::new(&[(0.0, 3.0)]),
    )
    .unwrap();
    let s = Settings::new(&[(0.0, 4.0), (-0.1, 0.1)]);
    let f = fold_curve(&problem, &e.of(Fold)[0].solution, [0, 1], &s).unwrap();
    for sign in [1.0, -1.0] {
        has(
            &f,
            BogdanovTakens,
            [0, 1],
            [1.446_716_7, sign * 0.020_940_2],
            1e-7,
        );
        has(
            &f,
            ZeroHopf,
            [0, 1],
            [1.283_419_3, sign * 1.265_408e-4],
            1e-7,
        );
    }
    has(&f, Cusp, [0, 1], [1.278_283_3, 0.0], 1e-7);
    let mut kinds = Vec::new();
    for h in e.of(Hopf) {
        let c = hopf_curve(&problem, h, [0, 1], &s).unwrap();
        for x in c.special {
            let p = x.solution.equilibrium.parameters;
            kinds.push((x.kind, p[0], p[1], x.omega, x.second_omega));
        }
    }
    let seen = |kind: Kind, at: [f64; 2]| {
        kinds
            .iter()
            .find(|k| k.0 == kind && (k.1 - at[0]).abs() < 5e-7 && (k.2 - at[1]).abs() < 1e-7)
            .copied()
    };
    assert!(
        seen(GeneralisedHopf, [2.376_359_7, 0.050_197_5]).is_some(),
        "{kinds:?}"
    );
    let hh = seen(HopfHopf, [2.533_221_1, 0.026_273_9]).unwrap_or_else(|| panic!("{kinds:?}"));
    let mut w = [hh.3.unwrap(), hh.4.unwrap()];
    w.sort_by(f64::total_cmp);
    assert!(
        (w[0] - 0.7432).abs() < 6e-5 && (w[1] - 1.1515).abs() < 6e-5,
        "{w:?}"
    );
    assert!(
        seen(ZeroHopf, [1.283_419_3, 1.265_408e-4]).is_some()
            || seen(ZeroHopf, [1.283_419_3, -1.265_408e-4]).is_some(),
        "{kinds:?}"
    );
}

#[test]
fn a13_cusp() {
    let problem = Exact::<_, 1>(CuspForm);
    let e = equilibria(
        &problem,
        &[-1.4],
        &[-1.0, 1.0],
        0,
        &Settings::new(&[(-1.0, 1.0)]),
    )
    .unwrap();
    let s = Settings::new(&[(-1.0, 1.0), (-0.5, 1.5)]);
    let f = fold_curve(&problem, &e.special[0].solution, [0, 1], &s).unwrap();
    assert_eq!(f.special.len(), 1, "{}", show(&f, [0, 1]));
    has(&f, Cusp, [0, 1], [0.0, 0.0], 1e-9);
}

fn show_cycles(b: &Branch<CriticalOrbit>, k: [usize; 2]) -> String {
    use std::fmt::Write;
    let mut out = format!("{} points, stop {:?}\n", b.points.len(), b.stop);
    for s in &b.special {
        let p = &s.solution.orbit.parameters;
        let _ = writeln!(
            out,
            "{} ({:.9}, {:.9}) T {:.9}",
            s.label, p[k[0]], p[k[1]], s.solution.orbit.period
        );
    }
    for p in b.points.iter().step_by(5) {
        let q = &p.solution.orbit.parameters;
        let _ = writeln!(
            out,
            "  point ({:.9}, {:.9}) T {:.6} angle {:.4}",
            q[k[0]], q[k[1]], p.solution.orbit.period, p.solution.angle
        );
    }
    out
}

fn has_cycle(
    b: &Branch<CriticalOrbit>,
    kind: Kind,
    k: [usize; 2],
    at: [f64; 2],
    unit: [f64; 2],
) -> f64 {
    b.of(kind)
        .iter()
        .find(|s| {
            let p = &s.solution.orbit.parameters;
            (p[k[0]] - at[0]).abs() <= unit[0] && (p[k[1]] - at[1]).abs() <= unit[1]
        })
        .unwrap_or_else(|| panic!("{kind} at {at:?} not found\n{}", show_cycles(b, k)))
        .solution
        .orbit
        .period
}

fn forced<P: quell_continuation::Problem>(
    problem: &P,
    n: usize,
    p: &[f64],
    s: &Settings,
) -> Branch<quell_continuation::Orbit> {
    let period = problem.period(p).unwrap();
    let (times, states) =
        crate::support::integrate(problem, &vec![0.0; n], p, period / 400.0, 200 * 400, 401);
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
fn bautin_fold_of_cycles_is_a_parabola() {
    let problem = Exact::<_, 2>(Bautin);
    let e = equilibria(
        &problem,
        &[0.0; 2],
        &[-0.5, -1.0],
        0,
        &Settings::new(&[(-0.5, 1.0)]),
    )
    .unwrap();
    let b = cycles_from_hopf(&problem, &e.special[0], 0, &Settings::new(&[(-0.5, 1.0)])).unwrap();
    let fold = b.of(Kind::CycleFold)[0];
    let s = Settings::new(&[(0.0, 1.0), (-2.5, 0.5)]);
    let c = cycle_curve(&problem, fold, [0, 1], &s).unwrap();
    assert!(c.points.len() > 10);
    for p in &c.points {
        let (mu, be) = (
            p.solution.orbit.parameters[0],
            p.solution.orbit.parameters[1],
        );
        assert!((mu - be * be / 4.0).abs() < 1e-8 * (1.0 + mu), "{mu} {be}");
        let r = p.solution.orbit.range(0).1;
        assert!((r * r + be / 2.0).abs() < 1e-6, "{r} {be}");
    }
    // The same curve from the generalised Hopf point at the origin.
    let h = hopf_curve(
        &problem,
        &e.special[0],
        [1, 0],
        &Settings::new(&[(-2.0, 2.0), (-1.0, 1.0)]),
    )
    .unwrap();
    let gh = h.of(GeneralisedHopf)[0];
    assert!(
        gh.solution
            .equilibrium
            .parameters
            .iter()
            .all(|p| p.abs() < 1e-9),
        "{}",
        show(&h, [0, 1])
    );
    let c = fold_from_generalised_hopf(&problem, &gh.solution, [0, 1], &s).unwrap();
    let last = &c.points.last().unwrap().solution.orbit.parameters;
    assert!(last[1] < -0.5, "{}", show_cycles(&c, [0, 1]));
    for p in &c.points {
        let (mu, be) = (
            p.solution.orbit.parameters[0],
            p.solution.orbit.parameters[1],
        );
        assert!((mu - be * be / 4.0).abs() < 1e-8 * (1.0 + mu), "{mu} {be}");
    }
}

#[test]
fn s3_and_s4_fold_curves() {
    let problem = Exact::<_, 2>(Duffing);
    let b = forced(
        &problem,
        2,
        &[0.5, 0.2, 0.05],
        &Settings::new(&[(0.5, 2.5)]),
    );
    let s = Settings::new(&[(0.5, 2.5), (0.01, 0.5)]);
    let c = cycle_curve(&problem, b.of(Kind::CycleFold)[0], [0, 1], &s).unwrap();
    has_cycle(
        &c,
        Kind::CycleCusp,
        [0, 1],
        [1.090_11, 0.051_363_5],
        [6e-6, 6e-8],
    );
    let problem = Exact::<_, 4>(ForcedAbsorber);
    let b = forced(&problem, 4, &[0.7, 0.12], &Settings::new(&[(0.7, 1.7)]));
    let s = Settings::new(&[(0.7, 2.0), (0.05, 0.3)]);
    let c = cycle_curve(&problem, b.of(Kind::CycleFold)[0], [0, 1], &s).unwrap();
    // The reference prints (1.29304, 0.146911) and (1.67388, 0.127213), 1e-5 away along the curve. Shooting in extended precision
    // settles it: a program of its own (Runge-Kutta of order four with 2 000, 8 000 and 16 000 steps a period, which agree to 1e-12;
    // Newton on x(T) = x(0), det(M - I) = 0 by a bordered matrix, and ⟨w, v⟩ = 0 of its null vectors) finds these points. Here they
    // are found to the square root of what a double root loses.
    for at in [
        [1.293_030_366_667, 0.146_908_099_667],
        [1.673_890_982_599, 0.127_211_891_909],
    ] {
        has_cycle(&c, Kind::Resonance1, [0, 1], at, [1e-6, 1e-6]);
    }
    for point in c.of(Kind::Resonance1) {
        let gap = point
            .spectrum
            .iter()
            .map(|v| (v - 1.0).norm())
            .fold(f64::INFINITY, f64::min);
        assert!(gap < 2e-6, "{gap:e}");
    }
    let on_folds: Vec<[f64; 2]> = c
        .of(Kind::Resonance1)
        .iter()
        .map(|r| {
            [
                r.solution.orbit.parameters[0],
                r.solution.orbit.parameters[1],
            ]
        })
        .collect();
    // The torus curve ends at one of them, where its angle vanishes: another system of equations for the same point.
    let s = Settings::new(&[(0.9, 2.0), (0.05, 0.3)]);
    let c = cycle_curve(&problem, b.of(Kind::Torus)[0], [0, 1], &s).unwrap();
    let ends = c.of(Kind::Resonance1);
    assert!(!ends.is_empty(), "{}", show_cycles(&c, [0, 1]));
    for end in ends {
        let p = &end.solution.orbit.parameters;
        let gap = on_folds
            .iter()
            .map(|f| (f[0] - p[0]).abs().max((f[1] - p[1]).abs()))
            .fold(f64::INFINITY, f64::min);
        assert!(gap < 1e-6, "{gap:e} {}", show_cycles(&c, [0, 1]));
    }
    let s = Settings::new(&[(0.9, 1.5), (0.05, 0.2)]);
    let mut at = s.clone();
    at.at = vec![b.of(Kind::Torus)[1].solution.parameters[0]];
    let c = cycle_curve(&problem, b.of(Kind::Torus)[0], [0, 1], &at).unwrap();
    assert!(
        c.at.iter()
            .any(|p| (p.solution.orbit.parameters[1] - 0.12).abs() < 1e-8),
        "{}",
        show_cycles(&c, [0, 1])
    );
}

#[test]
fn s5_period_doubling_curve() {
    let problem = Exact::<_, 3>(Feedback);
    let e = equilibria(
        &problem,
        &[0.0; 3],
        &[1.5, 1.0],
        0,
        &Settings::new(&[(0.3, 1.5)]),
    )
    .unwrap();
    let b = cycles_from_hopf(&problem, &e.special[0], 0, &Settings::new(&[(0.5, 1.2)])).unwrap();
    let s = Settings::new(&[(-0.2, 1.2), (0.4, 2.0)]);
    let c = cycle_curve(&problem, b.of(Kind::PeriodDoubling)[0], [0, 1], &s).unwrap();
    let t = has_cycle(
        &c,
        Kind::Resonance2,
        [0, 1],
        [0.0, 1.698_710_692],
        [1e-8, 2e-8],
    );
    close(t, 4.841_835_116, 1e-8);
    let t = has_cycle(
        &c,
        Kind::Resonance2,
        [0, 1],
        [0.0, 0.678_278_315],
        [1e-8, 2e-8],
    );
    close(t, 9.058_318_221, 1e-8);
    assert_eq!(c.special.len(), 2, "{}", show_cycles(&c, [0, 1]));
}

#[test]
fn a8_fold_curve() {
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
    let mut found = Vec::new();
    for fold in b.of(Kind::CycleFold) {
        let mut s = Settings::new(&[(108.5, 111.5), (2.0, 6.0)]);
        s.at = vec![109.0, 111.0];
        let c = cycle_curve(&problem, fold, [1, 0], &s).unwrap();
        found.extend(c.at.iter().map(|p| {
            (
                p.solution.orbit.parameters[1],
                p.solution.orbit.parameters[0],
            )
        }));
    }
    for (s0, rho) in [
        (111.0, 2.986_29),
        (111.0, 4.722_13),
        (109.0, 2.582_64),
        (109.0, 5.243_32),
    ] {
        assert!(
            found
                .iter()
                .any(|f| f.0 == s0 && (f.1 / rho - 1.0).abs() < 1e-5),
            "{s0} {rho}: {found:?}"
        );
    }
}

#[test]
fn s1_fold_curve() {
    let problem = Exact::<_, 6>(Section);
    let e = equilibria(
        &problem,
        &[0.0; 6],
        &[4.0, 5006.7],
        0,
        &Settings::new(&[(4.0, 30.0)]),
    )
    .unwrap();
    let mut s = Settings::new(&[(12.0, 18.5)]);
    s.mesh = MeshSettings::fixed(60, 4);
    let b = cycles_from_hopf(&problem, &e.special[0], 0, &s).unwrap();
    let mut s = Settings::new(&[(5.0, 18.5), (2000.0, 12_000.0)]);
    s.mesh = MeshSettings::fixed(60, 4);
    let c = cycle_curve(&problem, b.of(Kind::CycleFold)[0], [0, 1], &s).unwrap();
    // It meets the curve of Hopf points at the generalised Hopf point.
    let nearest = c
        .points
        .iter()
        .map(|p| &p.solution.orbit.parameters)
        .max_by(|a, b| a[1].total_cmp(&b[1]))
        .unwrap();
    assert!(
        (nearest[1] / 1.0446e4 - 1.0).abs() < 0.02,
        "{}",
        show_cycles(&c, [0, 1])
    );
    assert!((nearest[0] - 17.957_264_996).abs() < 0.01);
}

#[test]
fn torus_curves_leave_the_hopf_hopf_point() {
    let problem = Exact::<_, 4>(Absorber);
    let e = equilibria(
        &problem,
        &[0.0; 4],
        &[0.01, 0.95, 0.3],
        0,
        &Settings::new(&[(0.01, 0.3)]),
    )
    .unwrap();
    let s = Settings::new(&[(0.01, 0.3), (0.9, 1.05)]);
    let h = hopf_curve(&problem, &e.special[0], [0, 1], &s).unwrap();
    let hh = h.of(HopfHopf)[0];
    let (one, two) = (hh.omega.unwrap(), hh.second_omega.unwrap());
    let mut s = s;
    s.maximum_points = 30;
    for (omega, other) in [(one, two), (two, one)] {
        let c = torus_from_hopf_hopf(&problem, &hh.solution, omega, other, [0, 1], &s).unwrap();
        assert!(c.points.len() > 5, "{}", show_cycles(&c, [0, 1]));
        let p = &c.points[3].solution;
        // An independent check: the branch in mu1 through it has a torus point there.
        let mut b = Settings::new(&[(p.orbit.parameters[0] - 0.01, p.orbit.parameters[0] + 0.01)]);
        b.maximum_points = 40;
        let branch = cycles_from_orbit(&problem, &p.orbit, 0, &b).unwrap();
        let unit = branch
            .points
            .iter()
            .flat_map(|x| &x.spectrum)
            .map(|v| (v.norm() - 1.0).abs())
            .fold(f64::INFINITY, f64::min);
        assert!(unit < 1e-6, "{unit:e}");
    }
}

/// A Bogdanov-Takens point turned round the circle: x' = y, y' = β₁ + β₂ x + x² - x y with x = r - 1, φ' = 1. Its Hopf curve β₁ = 0,
/// β₂ < 0 is one of torus points with the angle 2π √-β₂, which ends on the folds of cycles in the resonance 1:1 at the origin.
struct TurnedTakens;
impl Field for TurnedTakens {
    const N: usize = 3;
    const P: usize = 2;
    fn f<R: Real>(&self, _t: R, s: &[R], p: &[R], out: &mut [R]) {
        let (u, v, y) = (s[0], s[1], s[2]);
        let r = (u * u + v * v).sqrt();
        let x = r - R::from(1.0);
        out[0] = y * u / r - v;
        out[1] = y * v / r + u;
        out[2] = p[0] + p[1] * x + x * x - x * y;
    }
}

#[test]
fn a_torus_curve_of_cycles_ends_at_the_resonance_one_to_one() {
    let problem = Exact::<_, 5>(TurnedTakens);
    let tau = std::f64::consts::TAU;
    let times: Vec<f64> = (0..=80).map(|k| tau * f64::from(k) / 80.0).collect();
    // At β₁ = -0.01, β₂ = -0.04 the equilibrium of smaller x.
    let r = 1.0 + 0.5 * (0.04 - (0.0016_f64 + 0.04).sqrt());
    let states: Vec<Vec<f64>> = times
        .iter()
        .map(|t| vec![r * t.cos(), r * t.sin(), 0.0])
        .collect();
    let samples = Samples {
        times: &times,
        states: &states,
        period: tau,
        periods: 1,
        winding: &[],
    };
    let settings = Settings::new(&[(-0.02, 0.01)]);
    let cycles = cycles_from_samples(&problem, &samples, &[-0.01, -0.04], 0, &settings).unwrap();
    let torus = cycles.of(Kind::Torus)[0];
    assert!(torus.solution.parameters[0].abs() < 1e-7);
    close(torus.omega.unwrap(), 0.2 * tau, 1e-6);
    let settings = Settings::new(&[(-0.02, 0.02), (-0.05, 0.02)]);
    let curve = cycle_curve(&problem, torus, [0, 1], &settings).unwrap();
    assert!(curve.stop.contains(&Stop::EndOfKind), "{:?}", curve.stop);
    let end = curve.of(Kind::Resonance1)[0];
    let [b1, b2] = end.solution.orbit.parameters[..] else {
        unreachable!("there are two parameters");
    };
    // θ² = -4π² β₂: where the angle can no longer be told from zero, at 0.02 at most, β₂ is.
    assert!(b1.abs() < 1e-6 && b2.abs() < 1.1e-5, "{b1} {b2}");
    for point in &curve.points {
        let [b1, b2] = point.solution.orbit.parameters[..] else {
            unreachable!("there are two parameters");
        };
        assert!(b1.abs() < 1e-6, "{b1} {b2}");
        assert!(
            (point.solution.angle.powi(2) + tau * tau * b2).abs() < 1e-4,
            "{b2}"
        );
    }
}
