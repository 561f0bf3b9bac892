//! Points of codimension two: coefficients of equilibria, and further multipliers on curves of cycles, all in closed form.

use std::f64::consts::PI;

use crate::close;
use crate::support::models::CuspForm;
use crate::support::{Exact, Field, Real};
use quell_continuation::{
    Branch, CriticalOrbit, Kind, Samples, Settings, cycle_curve, cycles_from_samples, equilibria,
    fold_curve, hopf_curve,
};

/// x' = μ + λ x + x y - x³, y' = -2 y + x²: y follows x²/2, so the cubic coefficient is -1 + 1/2.
struct Slaved;
impl Field for Slaved {
    const N: usize = 2;
    const P: usize = 2;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        out[0] = p[0] + p[1] * x[0] + x[0] * x[1] - x[0].cube();
        out[1] = x[0] * x[0] - R::from(2.0) * x[1];
    }
}

#[test]
fn cusp() {
    let s = Settings::new(&[(-1.0, 1.0)]);
    let two = Settings::new(&[(-1.0, 1.0), (-0.5, 1.5)]);
    let plain = Exact::<_, 1>(CuspForm);
    let e = equilibria(&plain, &[-1.4], &[-1.0, 1.0], 0, &s).unwrap();
    let f = fold_curve(&plain, &e.special[0].solution, [0, 1], &two).unwrap();
    close(f.of(Kind::Cusp)[0].normal_form[0], -1.0, 1e-9);
    let slaved = Exact::<_, 2>(Slaved);
    let e = equilibria(&slaved, &[-1.8, 1.6], &[-1.0, 1.0], 0, &s).unwrap();
    let f = fold_curve(&slaved, &e.of(Kind::Fold)[0].solution, [0, 1], &two).unwrap();
    let cusp = f.of(Kind::Cusp)[0];
    assert!(
        cusp.solution
            .equilibrium
            .parameters
            .iter()
            .all(|p| p.abs() < 1e-8)
    );
    close(cusp.normal_form[0], -0.5, 1e-7);
}

/// x' = μ - x² + b |ζ|², ζ' = (λ + i + d x) ζ with b = 0.3, d = 0.7; parameters μ, λ.
struct ZeroHopfForm;
impl Field for ZeroHopfForm {
    const N: usize = 3;
    const P: usize = 2;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        let size = x[1] * x[1] + x[2] * x[2];
        let rate = p[1] + R::from(0.7) * x[0];
        out[0] = p[0] - x[0] * x[0] + R::from(0.3) * size;
        out[1] = rate * x[1] - x[2];
        out[2] = rate * x[2] + x[1];
    }
}

#[test]
fn zero_hopf() {
    // |q₁| = 1 makes |ζ|² = 2 |ξ|².
    let problem = Exact::<_, 3>(ZeroHopfForm);
    let s = Settings::new(&[(-0.5, 1.0)]);
    let e = equilibria(&problem, &[1.0, 0.0, 0.0], &[1.0, -0.3], 0, &s).unwrap();
    let two = Settings::new(&[(-1.0, 1.0), (-1.0, 1.0)]);
    let f = fold_curve(&problem, &e.of(Kind::Fold)[0].solution, [0, 1], &two).unwrap();
    let zh = f.of(Kind::ZeroHopf);
    assert_eq!(zh.len(), 1);
    close(zh[0].normal_form[0], -1.0, 1e-9);
    close(zh[0].normal_form[1], 0.7, 1e-9);
    close(zh[0].normal_form[2], 2.0 * 0.3, 1e-9);
}

/// ζ₁' = (λ₁ + 1.0 i + P₁₁|ζ₁|² + P₁₂|ζ₂|² + g₁ s) ζ₁, ζ₂' = (λ₂ + 2.3 i + …) ζ₂, s' = -s + |ζ₁|² + β |ζ₂|²; parameters λ₁, λ₂.
struct TwoPairs;
const CUBIC: [[f64; 2]; 2] = [[-0.4, 0.9], [-1.3, 0.6]];
const LIFT: [f64; 2] = [0.5, -0.8];
const SHARE: [f64; 2] = [1.0, 0.35];
impl Field for TwoPairs {
    const N: usize = 5;
    const P: usize = 2;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        let sizes = [0, 1].map(|k| x[2 * k] * x[2 * k] + x[2 * k + 1] * x[2 * k + 1]);
        for (k, omega) in [1.0, 2.3].into_iter().enumerate() {
            let rate = p[k]
                + R::from(CUBIC[k][0]) * sizes[0]
                + R::from(CUBIC[k][1]) * sizes[1]
                + R::from(LIFT[k]) * x[4];
            let (z, w) = (x[2 * k], x[2 * k + 1]);
            out[2 * k] = rate * z - R::from(omega) * w;
            out[2 * k + 1] = rate * w + R::from(omega) * z;
        }
        out[4] = R::from(SHARE[0]) * sizes[0] + R::from(SHARE[1]) * sizes[1] - x[4];
    }
}

#[test]
fn hopf_hopf() {
    let problem = Exact::<_, 5>(TwoPairs);
    let s = Settings::new(&[(-0.5, 0.5)]);
    let e = equilibria(&problem, &[0.0; 5], &[-0.5, -0.4], 0, &s).unwrap();
    let two = Settings::new(&[(-0.5, 0.5), (-0.5, 0.5)]);
    let h = hopf_curve(&problem, &e.special[0], [0, 1], &two).unwrap();
    let hh = h.of(Kind::HopfHopf);
    assert_eq!(hh.len(), 1);
    assert!((hh[0].omega.unwrap() - 1.0).abs() < 1e-9);
    // s follows |ζ₁|² + β |ζ₂|², and |ζ|² = 2 |ξ|².
    for i in 0..2 {
        for j in 0..2 {
            let expected = 2.0 * (CUBIC[i][j] + LIFT[i] * SHARE[j]);
            close(hh[0].normal_form[2 * i + j], expected, 1e-8);
        }
    }
}

/// The cycle r = 1 or Bautin's, with what may ride beside it: on a Möbius strip with rate p₁ + c ξ², and a pair with rate p₂ + d |ζ|².
///
/// Parameters: μ of r' = r (μ + be r² + r⁴), be, p₁, c, p₂, d. `far` times (1 + be) is added to both rates.
struct Ring {
    far: f64,
}
impl Field for Ring {
    const N: usize = 6;
    const P: usize = 6;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        let one = R::from(1.0);
        let half = R::from(0.5);
        let square = x[0] * x[0] + x[1] * x[1];
        let r = square.sqrt();
        let (cos, sin) = (x[0] / r, x[1] / r);
        let g = p[0] + p[1] * square + square * square;
        out[0] = g * x[0] - x[1];
        out[1] = g * x[1] + x[0];
        let extra = R::from(self.far) * (one + p[1]);
        let (z, w) = (x[2], x[3]);
        let (cc, ss, cs) = ((one + cos) * half, (one - cos) * half, sin * half);
        let (a, b) = (cc * z + cs * w, cs * z + ss * w);
        let rate = p[2] + extra + p[3] * (a * z + b * w);
        out[2] = rate * a - half * w - (ss * z - cs * w);
        out[3] = rate * b + half * z - (cc * w - cs * z);
        let (z, w) = (x[4], x[5]);
        let rate = p[4] + extra + p[5] * (z * z + w * w);
        let omega = R::from(0.37);
        out[4] = rate * z - omega * w;
        out[5] = rate * w + omega * z;
    }
}

/// The curve in two parameters through the first special point of a kind on the branch in the first of them.
fn curve(
    far: f64,
    p: [f64; 6],
    kind: Kind,
    free: [usize; 2],
    first: (f64, f64),
    ranges: [(f64, f64); 2],
) -> Branch<CriticalOrbit> {
    let problem = Exact::<_, 6>(Ring { far });
    // The stable one of both radii: r² = -be/2 - √(be²/4 - μ).
    let square = -0.5 * p[1] - (0.25 * p[1] * p[1] - p[0]).sqrt();
    let r = square.sqrt();
    let times: Vec<f64> = (0..=200).map(|k| 2.0 * PI * f64::from(k) / 200.0).collect();
    let states: Vec<Vec<f64>> = times
        .iter()
        .map(|t| vec![r * t.cos(), r * t.sin(), 0.0, 0.0, 0.0, 0.0])
        .collect();
    let samples = Samples {
        times: &times,
        states: &states,
        period: 2.0 * PI,
        periods: 1,
        winding: &[],
    };
    let s = Settings::new(&[first]);
    let b = cycles_from_samples(&problem, &samples, &p, free[0], &s).unwrap();
    let start = b.of(kind);
    assert!(!start.is_empty(), "{kind}: {:?}", b.special);
    cycle_curve(&problem, start[0], free, &Settings::new(&ranges)).unwrap()
}

/// Kinds and values of the second free parameter.
fn points(c: &Branch<CriticalOrbit>, k: usize) -> Vec<(Kind, f64)> {
    c.special
        .iter()
        .map(|s| (s.kind, s.solution.orbit.parameters[k]))
        .collect()
}

#[test]
fn coefficients_that_vanish() {
    // Period doubling at p₁ = 0 with coefficient c, torus at p₂ = 0 with d.
    let p = [0.1, -1.0, -0.1, -0.4, -0.3, -0.4];
    let wide = [(-0.2, 0.2), (-0.5, 0.5)];
    let c = curve(0.0, p, Kind::PeriodDoubling, [2, 3], (-0.2, 0.2), wide);
    let found = points(&c, 3);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].0 == Kind::GeneralisedDoubling && found[0].1.abs() < 1e-6);
    let p = [0.1, -1.0, -0.3, -0.4, -0.1, -0.4];
    let c = curve(0.0, p, Kind::Torus, [4, 5], (-0.2, 0.2), wide);
    let found = points(&c, 5);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].0 == Kind::Chenciner && found[0].1.abs() < 1e-6);
}

#[test]
fn two_kinds_at_once() {
    // Doubling at p₁ = 0, along p₂: the pair joins at p₂ = 0.
    let p = [0.1, -1.0, -0.1, -0.4, -0.3, -0.4];
    let wide = [(-0.2, 0.2), (-0.4, 0.4)];
    let c = curve(0.0, p, Kind::PeriodDoubling, [2, 4], (-0.2, 0.2), wide);
    let found = points(&c, 4);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].0 == Kind::DoublingTorus && found[0].1.abs() < 1e-7);
    // The same point on the torus curve.
    let p = [0.1, -1.0, -0.3, -0.4, -0.1, -0.4];
    let c = curve(0.0, p, Kind::Torus, [4, 2], (-0.2, 0.2), wide);
    let found = points(&c, 2);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].0 == Kind::DoublingTorus && found[0].1.abs() < 1e-7);
    // Folds at μ = be²/4; both rates pass zero there at be = -1 ± what is added.
    let p = [0.1, -1.0, -0.2, -0.4, 0.1, -0.4];
    let c = curve(
        1.0,
        p,
        Kind::CycleFold,
        [0, 1],
        (0.05, 0.4),
        [(0.02, 0.9), (-1.6, -0.5)],
    );
    let mut found = points(&c, 1);
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(
        found[0].0 == Kind::FoldTorus && (found[0].1 + 1.1).abs() < 1e-7,
        "{found:?}"
    );
    assert!(
        found[1].0 == Kind::FoldDoubling && (found[1].1 + 0.8).abs() < 1e-7,
        "{found:?}"
    );
}
