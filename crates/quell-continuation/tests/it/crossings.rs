//! No crossing of the unit circle is missed: pairs that cross twice within a step, touch, or touch while others cross.

use std::f64::consts::PI;

use crate::support::{Exact, Field, Real};
use quell_continuation::{
    Branch, Certainty, Kind, Orbit, Samples, Settings, Stop, cycle_curve, cycles_from_hopf,
    cycles_from_samples, equilibria,
};

/// The cycle r = 1 with two oscillators of rates δ - a p² + b p and frequency ω each beside it; parameters p, δ₁, a₁, b₁, δ₂, a₂, b₂.
struct Beside;
impl Field for Beside {
    const N: usize = 6;
    const P: usize = 7;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        let g = R::from(1.0) - x[0] * x[0] - x[1] * x[1];
        out[0] = g * x[0] - x[1];
        out[1] = g * x[1] + x[0];
        for (k, omega) in [(0, 0.31), (1, 0.43)] {
            let (z, w) = (x[2 + 2 * k], x[3 + 2 * k]);
            let size = z * z + w * w;
            let rate = p[1 + 3 * k] - p[2 + 3 * k] * p[0] * p[0] + p[3 + 3 * k] * p[0] - size;
            out[2 + 2 * k] = rate * z - R::from(omega) * w;
            out[3 + 2 * k] = rate * w + R::from(omega) * z;
        }
    }
}

fn branch(rest: [f64; 6]) -> Branch<Orbit> {
    let problem = Exact::<_, 6>(Beside);
    let times: Vec<f64> = (0..=200).map(|k| 2.0 * PI * f64::from(k) / 200.0).collect();
    let states: Vec<Vec<f64>> = times
        .iter()
        .map(|t| vec![t.cos(), t.sin(), 0.0, 0.0, 0.0, 0.0])
        .collect();
    let samples = Samples {
        times: &times,
        states: &states,
        period: 2.0 * PI,
        periods: 1,
        winding: &[],
    };
    let mut p = vec![-0.4];
    p.extend(rest);
    // Steps of a twentieth of the range: what happens within 1e-3 of p = 0 lies inside one of them.
    let s = Settings::new(&[(-0.43, 0.4)]);
    cycles_from_samples(&problem, &samples, &p, 0, &s).unwrap()
}

/// A pair that is well damped all along.
const QUIET: [f64; 3] = [-0.5, 0.0, 0.0];

fn tori(b: &Branch<Orbit>) -> Vec<(f64, [usize; 2], Certainty)> {
    assert!(b.special.iter().all(|s| s.kind == Kind::Torus));
    b.special
        .iter()
        .map(|s| (s.solution.parameters[0], s.unstable, s.certainty))
        .collect()
}

#[test]
fn a_pair_that_goes_out_and_back_within_a_step() {
    for gap in [1e-2, 1e-3, 1e-4] {
        let [a, b, c] = QUIET;
        let found = tori(&branch([0.5 * gap * gap, 0.5, 0.0, a, b, c]));
        assert_eq!(found.len(), 2, "{gap}: {found:?}");
        for (f, at) in found.iter().zip([-gap, gap]) {
            // Multipliers are good to 1e-9; the rate passes zero with slope gap.
            assert!((f.0 - at).abs() < 1e-9 / gap + 1e-9, "{gap}: {found:?}");
        }
        assert_eq!((found[0].1, found[1].1), ([0, 2], [2, 0]));
    }
}

#[test]
fn a_pair_that_touches_and_one_that_stays_away() {
    let [a, b, c] = QUIET;
    let found = tori(&branch([0.0, 0.5, 0.0, a, b, c]));
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].0.abs() < 1e-4 && found[0].1 == [0, 0], "{found:?}");
    for far in [1e-3, 1e-5, 1e-7] {
        let found = tori(&branch([-far, 0.5, 0.0, a, b, c]));
        assert!(found.is_empty(), "{far}: {found:?}");
    }
}

#[test]
fn a_pair_that_touches_where_another_crosses() {
    // The optimal absorber's case (oracle S2) on a cycle: the count goes from 0 to 2 and neither pair hides the other.
    let found = tori(&branch([0.0, 0.5, 0.0, 0.0, 0.0, 0.3]));
    assert!(!found.is_empty() && found.len() <= 2, "{found:?}");
    assert!(found.iter().all(|f| f.0.abs() < 1e-4), "{found:?}");
    assert!(found.iter().any(|f| f.0.abs() < 1e-8), "{found:?}");
    assert_eq!((found[0].1[0], found[found.len() - 1].1[1]), (0, 2));
    // Two crossings of one pair about one of the other.
    let found = tori(&branch([5e-7, 0.5, 0.0, 0.0, 0.0, 0.3]));
    let at: Vec<f64> = found.iter().map(|f| f.0).collect();
    assert_eq!(found.len(), 3, "{found:?}");
    for (f, e) in at.iter().zip([-1e-3, 0.0, 1e-3]) {
        assert!((f - e).abs() < 1e-6, "{at:?}");
    }
}

#[test]
fn two_tori_at_once() {
    // Rates p and δ₂ of both pairs: on the curve p = 0 of the first pair's tori the second pair joins at δ₂ = 0.
    let b = branch([0.0, 0.0, 1.0, -0.3, 0.0, 0.0]);
    let problem = Exact::<_, 6>(Beside);
    let s = Settings::new(&[(-0.43, 0.4), (-0.4, 0.4)]);
    let c = cycle_curve(&problem, b.of(Kind::Torus)[0], [0, 4], &s).unwrap();
    let found: Vec<(Kind, f64)> = c
        .special
        .iter()
        .map(|s| (s.kind, s.solution.orbit.parameters[4]))
        .collect();
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(
        found[0].0 == Kind::TorusTorus && found[0].1.abs() < 1e-7,
        "{found:?}"
    );
}

/// r' = r (p (1 - p) - r² - d r⁴), θ' = 1: cycles from p = 0 to p = 1.
struct Arch;
impl Field for Arch {
    const N: usize = 2;
    const P: usize = 2;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        let s = x[0] * x[0] + x[1] * x[1];
        let g = p[0] * (R::from(1.0) - p[0]) - s - p[1] * s * s;
        out[0] = g * x[0] - x[1];
        out[1] = g * x[1] + x[0];
    }
}

#[test]
fn where_a_branch_of_cycles_ends_nothing_else_happens() {
    // At either Hopf point a multiplier touches +1 and the parameter turns: neither is a fold of cycles.
    let problem = Exact::<_, 2>(Arch);
    for d in [0.0, 0.3, 1.0, 3.0] {
        for step in [0.05, 0.1, 0.17] {
            let mut s = Settings::new(&[(-0.5, 1.5)]);
            s.maximum_step = step;
            let e = equilibria(&problem, &[0.0; 2], &[-0.5, d], 0, &s).unwrap();
            assert_eq!(e.of(Kind::Hopf).len(), 2);
            let b = cycles_from_hopf(&problem, &e.special[0], 0, &s).unwrap();
            assert_eq!(b.stop[1], Stop::Vanished);
            assert!(b.special.is_empty(), "{d} {step}: {:?}", b.special);
        }
    }
}
