//! Branches of equilibria.

use crate::close;
use crate::support::models::*;
use crate::support::{Exact, integrate};
use quell_continuation::{
    Branch, Closure, Equilibrium, Interrupt, Kind, Monitor, Problem, Settings, Stop, equilibria,
    equilibria_across,
};

/// Kinds and parameters of the special points in order of the free parameter k along the branch.
fn list(branch: &Branch<Equilibrium>, k: usize) -> Vec<(Kind, f64)> {
    branch
        .special
        .iter()
        .map(|s| (s.kind, s.solution.parameters[k]))
        .collect()
}

fn expect(branch: &Branch<Equilibrium>, k: usize, expected: &[(Kind, f64)], tolerance: f64) {
    let mut found = list(branch, k);
    let mut expected = expected.to_vec();
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    expected.sort_by(|a, b| a.1.total_cmp(&b.1));
    assert_eq!(
        found.iter().map(|f| f.0).collect::<Vec<_>>(),
        expected.iter().map(|f| f.0).collect::<Vec<_>>(),
        "{found:?}"
    );
    for (f, e) in found.iter().zip(&expected) {
        close(f.1, e.1, tolerance);
    }
}

use Kind::{BranchPoint, Fold, Hopf, HopfHopf};

#[test]
fn s1_flutter() {
    let problem = Exact::<_, 6>(Section);
    let b = equilibria(
        &problem,
        &[0.0; 6],
        &[4.0, 5006.7],
        0,
        &Settings::new(&[(4.0, 30.0)]),
    )
    .unwrap();
    expect(&b, 0, &[(Hopf, 17.957_264_996)], 1e-9);
    close(b.special[0].omega.unwrap(), 15.478_938_986, 1e-9);
    assert!(b.special[0].normal_form[0] > 0.0);
    assert_eq!(b.special[0].unstable, [0, 2]);
    assert_eq!(b.stop[1], Stop::Bound(0));
}

/// A branch that starts on an end of its range, or beyond it by rounding, has no point outside; one that starts on an end goes
/// across the whole range, in one step too.
#[test]
fn ranges_hold_from_their_ends() {
    let problem = Exact::<_, 6>(Section);
    for start in [30.0, 30.0 + 4e-15, 4.0] {
        for step in [0.1, 100.0] {
            let mut settings = Settings::new(&[(4.0, 30.0)]);
            settings.initial_step = step;
            settings.maximum_step = settings.maximum_step.max(step);
            let b = equilibria(&problem, &[0.0; 6], &[start, 5006.7], 0, &settings).unwrap();
            let speeds: Vec<f64> = b.points.iter().map(|p| p.solution.parameters[0]).collect();
            assert!(
                speeds
                    .iter()
                    .all(|u| (4.0 - 1e-12..=30.0 + 1e-12).contains(u)),
                "{speeds:?}"
            );
            assert_eq!(b.stop, [Stop::Bound(0); 2]);
            let across = speeds.iter().copied().fold(f64::NEG_INFINITY, f64::max)
                - speeds.iter().copied().fold(f64::INFINITY, f64::min);
            close(across, 26.0, 1e-12);
        }
    }
}

#[test]
fn s2_optimal_absorber_is_a_hopf_hopf_point() {
    let problem = Exact::<_, 4>(Absorber);
    let lam = 1.0 / 1.05_f64.sqrt();
    let b = equilibria(
        &problem,
        &[0.0; 4],
        &[0.01, lam, 0.3],
        0,
        &Settings::new(&[(0.01, 0.3)]),
    )
    .unwrap();
    expect(&b, 0, &[(HopfHopf, 0.05_f64.sqrt() / 2.0)], 1e-8);
    let hh = &b.special[0];
    assert_eq!(hh.unstable, [0, 2]);
    let mut omegas = [hh.omega.unwrap(), hh.second_omega.unwrap()];
    omegas.sort_by(f64::total_cmp);
    close(omegas[0], 0.975_900_072_9, 1e-6);
    close(omegas[1], 1.0, 1e-6);
    // The absorber's mass on its own: a step ten times as long finds the same.
    let mut coarse = Settings::new(&[(0.01, 0.3)]);
    coarse.maximum_step = 0.5;
    coarse.initial_step = 0.3;
    let b = equilibria(&problem, &[0.0; 4], &[0.01, lam, 0.3], 0, &coarse).unwrap();
    expect(&b, 0, &[(HopfHopf, 0.05_f64.sqrt() / 2.0)], 1e-8);
}

#[test]
fn s2_thresholds() {
    let problem = Exact::<_, 4>(Absorber);
    for (lam, mu) in [
        (0.95, 0.077_977_834_609_9),
        (0.97, 0.099_294_619_597_7),
        (0.99, 0.081_948_983_097_8),
        (1.0, 0.071_807_423_281_9),
    ] {
        let b = equilibria(
            &problem,
            &[0.0; 4],
            &[0.01, lam, 0.3],
            0,
            &Settings::new(&[(0.01, 0.3)]),
        )
        .unwrap();
        close(b.special[0].solution.parameters[0], mu, 1e-9);
        assert_eq!(b.special[0].kind, Hopf);
        assert_eq!(b.special[0].unstable, [0, 2], "lam = {lam}");
    }
}

#[test]
fn s5_feedback() {
    let problem = Exact::<_, 3>(Feedback);
    let b = equilibria(
        &problem,
        &[0.0; 3],
        &[1.5, 1.0],
        0,
        &Settings::new(&[(0.3, 1.5)]),
    )
    .unwrap();
    expect(&b, 0, &[(Hopf, 1.0)], 1e-9);
    close(b.special[0].normal_form[0], -0.3, 1e-8);
    // The branch runs towards smaller values: what was stable becomes unstable against the direction of the parameter.
    assert_eq!(b.special[0].unstable, [2, 0]);
}

#[test]
fn s6_oxidation() {
    let problem = Exact::<_, 3>(Oxidation);
    let b = equilibria(
        &problem,
        &[0.001_338_78, 0.833_309, 0.118_109],
        &[2.0, 0.4],
        0,
        &Settings::new(&[(0.5, 2.0)]),
    )
    .unwrap();
    expect(
        &b,
        0,
        &[
            (Hopf, 1.051_557_462_5),
            (Fold, 1.042_048_505_4),
            (Fold, 1.052_200_287_9),
            (Hopf, 1.040_991_569_5),
        ],
        1e-9,
    );
    let hopf = b.of(Hopf);
    let mut l1: Vec<f64> = hopf.iter().map(|h| h.normal_form[0]).collect();
    l1.sort_by(f64::total_cmp);
    close(l1[0], 4.331_379, 2e-7);
    close(l1[1], 10.701_02, 6e-7);
}

#[test]
fn s7_lorenz84() {
    let problem = Exact::<_, 4>(Lorenz84);
    let b = equilibria(
        &problem,
        &[2.978_70, -0.038_683, 0.058_232_7, -0.021_052_9],
        &[3.0, 0.04],
        0,
        &Settings::new(&[(0.0, 3.0)]),
    )
    .unwrap();
    expect(
        &b,
        0,
        &[
            (Fold, 1.546_648_372_6),
            (Hopf, 1.619_657_821_2),
            (Hopf, 2.467_222_122_7),
            (Hopf, 2.859_875_413),
        ],
        1e-9,
    );
}

#[test]
fn s8_peroxidase() {
    let problem = Exact::<_, 4>(Peroxidase);
    let b = equilibria(
        &problem,
        &[31.7915, 1.454_61, 0.015_245_9, 0.177_611],
        &[4.2355],
        0,
        &Settings::new(&[(0.5, 5.0)]),
    )
    .unwrap();
    expect(&b, 0, &[(Hopf, 0.712_475_372_6), (Hopf, 4.590_05)], 1.1e-6);
    close(b.special[0].solution.parameters[0], 0.712_475_372_6, 1e-9);
}

#[test]
fn s10_morris_lecar() {
    let problem = Exact::<_, 2>(MorrisLecar);
    let b = equilibria(
        &problem,
        &[-60.855, 0.014_915],
        &[0.0],
        0,
        &Settings::new(&[(0.0, 300.0)]),
    )
    .unwrap();
    let hopf: Vec<f64> = b
        .of(Hopf)
        .iter()
        .map(|h| h.solution.parameters[0])
        .collect();
    close(hopf[0], 93.857_618_259, 1e-8);
    close(hopf[1], 212.018_816_38, 1e-8);
    assert_eq!(hopf.len(), b.special.len());
}

#[test]
fn a1_ab() {
    let problem = Exact::<_, 2>(Ab);
    let go = |p2: f64| {
        equilibria(
            &problem,
            &[0.0; 2],
            &[0.0, p2],
            0,
            &Settings::new(&[(0.0, 0.5)]),
        )
        .unwrap()
    };
    expect(
        &go(14.0),
        0,
        &[(Hopf, 0.165_042), (Hopf, 0.336_550_5)],
        1e-4,
    );
    expect(
        &go(17.0),
        0,
        &[
            (Hopf, 0.120_866),
            (Fold, 0.121_901),
            (Fold, 0.117_015),
            (Hopf, 0.217_079),
        ],
        1e-4,
    );
    expect(
        &go(18.0),
        0,
        &[
            (Hopf, 0.111_153),
            (Fold, 0.111_565),
            (Fold, 0.099_574_1),
            (Hopf, 0.183_833),
        ],
        1e-4,
    );
}

#[test]
fn a2_abc() {
    let problem = Exact::<_, 3>(Abc);
    let b = equilibria(
        &problem,
        &[0.0; 3],
        &[0.0],
        0,
        &Settings::new(&[(0.0, 0.4)]),
    )
    .unwrap();
    let hopf: Vec<f64> = b
        .of(Hopf)
        .iter()
        .map(|h| h.solution.parameters[0])
        .collect();
    for (f, e) in hopf
        .iter()
        .zip([0.204_185, 0.229_836, 0.259_957, 0.346_208])
    {
        close(*f, e, 1e-4);
    }
    assert_eq!(hopf.len(), 4);
}

#[test]
fn a3_lorenz_branch_point_and_hopf() {
    let problem = Exact::<_, 3>(Lorenz);
    let s = Settings::new(&[(0.0, 30.0)]);
    let b = equilibria(&problem, &[0.0; 3], &[0.0], 0, &s).unwrap();
    expect(&b, 0, &[(BranchPoint, 1.0)], 1e-8);
    for side in [1.0, -1.0] {
        let other = equilibria_across(&problem, &b.special[0], 0, side, &s).unwrap();
        let hopf = other.of(Hopf);
        assert_eq!(hopf.len(), 1, "{:?}", list(&other, 0));
        close(hopf[0].solution.parameters[0], 470.0 / 19.0, 1e-9);
        assert!(
            (hopf[0].solution.state[0] > 0.0)
                == (other.points.last().unwrap().solution.state[0] > 0.0)
        );
    }
}

#[test]
fn a7_tor() {
    let problem = Exact::<_, 3>(Electronic);
    let b = equilibria(
        &problem,
        &[0.0; 3],
        &[-0.9],
        0,
        &Settings::new(&[(-0.9, -0.3)]),
    )
    .unwrap();
    expect(&b, 0, &[(Hopf, -0.589_337), (BranchPoint, -0.5)], 1e-6);
}

#[test]
fn a8_plp_and_a13_cusp() {
    let problem = Exact::<_, 2>(Enzyme);
    let b = equilibria(
        &problem,
        &[110.0, 500.0],
        &[0.0, 110.0],
        0,
        &Settings::new(&[(0.0, 10.0)]),
    )
    .unwrap();
    let hopf: Vec<f64> = b
        .of(Hopf)
        .iter()
        .map(|h| h.solution.parameters[0])
        .collect();
    assert_eq!(hopf.len(), 2, "{hopf:?}");
    close(hopf[0], 3.499_95, 2e-6);
    close(hopf[1], 4.650_46, 2e-6);
    let problem = Exact::<_, 1>(CuspForm);
    let b = equilibria(
        &problem,
        &[-1.4],
        &[-1.0, 1.0],
        0,
        &Settings::new(&[(-1.0, 1.0)]),
    )
    .unwrap();
    let mu = 2.0 / (3.0 * 3.0_f64.sqrt());
    expect(&b, 0, &[(Fold, mu), (Fold, -mu)], 1e-9);
}

#[test]
fn requested_values_are_met_exactly() {
    let problem = Exact::<_, 1>(CuspForm);
    let mut s = Settings::new(&[(-1.0, 1.0)]);
    s.at = vec![0.0, 0.25];
    let b = equilibria(&problem, &[-1.4], &[-1.0, 1.0], 0, &s).unwrap();
    // The S-shaped curve passes each value three times.
    assert_eq!(b.at.len(), 6);
    // The value that it starts at counts as well.
    s.at = vec![-1.0, -0.5];
    let c = equilibria(&problem, &[-1.2], &[-0.5, 1.0], 0, &s).unwrap();
    assert_eq!(c.at.len(), 2);
    for p in &b.at {
        let (x, mu) = (p.solution.state[0], p.solution.parameters[0]);
        assert!(mu == 0.0 || mu == 0.25);
        assert!((mu + x - x * x * x).abs() < 1e-13);
    }
}

#[test]
fn monitors_are_located_and_stop() {
    let problem = Exact::<_, 1>(CuspForm);
    let mut s = Settings::new(&[(-1.0, 1.0)]);
    s.monitors = vec![
        Monitor::new(|v| v.states[0] + 0.2),
        Monitor::new(|v| v.states[0] - 0.9).stopping(),
    ];
    let b = equilibria(&problem, &[-1.4], &[-1.0, 1.0], 0, &s).unwrap();
    let first = b.of(Kind::Monitor(0));
    assert_eq!(first.len(), 1);
    assert!((first[0].solution.state[0] + 0.2).abs() < 1e-10);
    assert_eq!(b.stop[1], Stop::Monitor);
}

#[test]
fn neutral_saddles_are_not_hopf_points() {
    // x' = a x, y' = -y: the sum of the eigenvalues vanishes at a = 1, nothing happens there.
    let problem = Closure::new(2, 1, |_t, x: &[f64], p: &[f64], out: &mut [f64]| {
        out[0] = p[0] * x[0] + x[1] * x[1];
        out[1] = -x[1];
    });
    let b = equilibria(
        &problem,
        &[0.0; 2],
        &[0.5],
        0,
        &Settings::new(&[(0.5, 2.0)]),
    )
    .unwrap();
    assert!(b.special.is_empty(), "{:?}", b.special);
    assert!(b.approximate);
}

#[test]
fn two_crossings_within_a_step_are_both_found() {
    // Re lambda = (mu - 0.5)^2 - 1e-5: unstable, stable, unstable within 0.0063 of mu.
    let problem = Closure::new(2, 1, |_t, x: &[f64], p: &[f64], out: &mut [f64]| {
        let g = (p[0] - 0.5).powi(2) - 1e-5;
        out[0] = g * x[0] - x[1];
        out[1] = x[0] + g * x[1];
    });
    let mut s = Settings::new(&[(0.0, 1.1)]);
    s.maximum_step = 0.3;
    let b = equilibria(&problem, &[0.0; 2], &[0.0], 0, &s).unwrap();
    expect(
        &b,
        0,
        &[(Hopf, 0.5 - 1e-5_f64.sqrt()), (Hopf, 0.5 + 1e-5_f64.sqrt())],
        1e-6,
    );
}

#[test]
fn degenerate_input_ends_with_a_status() {
    let s = Settings::new(&[(0.0, 1.0)]);
    // No equilibrium.
    let none = Closure::new(1, 1, |_t, x: &[f64], p: &[f64], out: &mut [f64]| {
        out[0] = 1.0 + x[0] * x[0] + p[0]
    });
    assert!(equilibria(&none, &[0.3], &[0.0], 0, &s).is_err());
    // A Jacobian singular everywhere.
    let flat = Closure::new(2, 1, |_t, x: &[f64], p: &[f64], out: &mut [f64]| {
        out[0] = x[0] - p[0];
        out[1] = 2.0 * (x[0] - p[0]);
    });
    let _ = equilibria(&flat, &[0.0, 0.0], &[0.0], 0, &s);
    // NaN on the way.
    let root = Closure::new(1, 1, |_t, x: &[f64], p: &[f64], out: &mut [f64]| {
        out[0] = x[0] - (0.5 - p[0]).sqrt()
    });
    let b = equilibria(&root, &[0.7], &[0.0], 0, &s).unwrap();
    assert!(
        matches!(b.stop[1], Stop::NotFinite | Stop::NoConvergence),
        "{:?}",
        b.stop
    );
    // A parameter without effect.
    let deaf = Closure::new(1, 1, |_t, x: &[f64], _p: &[f64], out: &mut [f64]| {
        out[0] = x[0] - 1.0
    });
    let b = equilibria(&deaf, &[0.7], &[0.0], 0, &s).unwrap();
    assert_eq!(
        b.stop,
        [Stop::Points, Stop::Bound(0)].map(|x| if x == Stop::Points { b.stop[0] } else { x })
    );
    // Shapes.
    assert!(equilibria(&deaf, &[0.7, 1.0], &[0.0], 0, &s).is_err());
    // Interrupted.
    let mut s = s;
    let flag = Interrupt::new();
    flag.raise();
    s.interrupt = Some(flag);
    let b = equilibria(&deaf, &[0.7], &[0.0], 0, &s).unwrap();
    assert_eq!(b.stop[1], Stop::Interrupted);
}

#[test]
fn second_derivatives_of_the_support_are_right() {
    let problem = Exact::<_, 2>(MorrisLecar);
    let (x, p) = ([-20.0, 0.1], [90.0]);
    let h = 1e-4;
    let (u, v) = ([1.0, 0.01], [0.5, -0.02]);
    let mut plus = [0.0; 4];
    let mut minus = [0.0; 4];
    problem.jacobian(0.0, &[x[0] + h * u[0], x[1] + h * u[1]], &p, &mut plus);
    problem.jacobian(0.0, &[x[0] - h * u[0], x[1] - h * u[1]], &p, &mut minus);
    let mut out = [0.0; 2];
    assert!(problem.second(0.0, &x, &p, &u, &v, &mut out));
    for i in 0..2 {
        let d: f64 = (0..2)
            .map(|j| (plus[i * 2 + j] - minus[i * 2 + j]) / (2.0 * h) * v[j])
            .sum();
        assert!((d - out[i]).abs() < 1e-7 * (1.0 + d.abs()));
    }
    let _ = integrate(&problem, &x, &p, 0.1, 3, 1);
}
