//! Coefficients of normal forms against systems that are in normal form by construction.

use std::f64::consts::PI;

use crate::close;
use crate::support::models::*;
use crate::support::{Exact, Field, Real};
use quell_continuation::{
    Closure, Kind, Samples, Settings, cycles_doubled, cycles_from_hopf, cycles_from_samples,
    equilibria,
};

/// Which normal form rides on the cycle r = 1, θ' = 1 + k |ζ|², r' = r (1 - r²) + q |ζ|² r of the first two states.
#[derive(Clone, Copy)]
enum Rider {
    /// On a Möbius strip, ξ' = ξ (μ + c ξ² + s (r² - 1)): period doubling at μ = 0.
    Flip,
    /// ζ' = ζ (μ + iω + (c + 2i) |ζ|² + s (r² - 1)): a torus at μ = 0.
    Whirl(f64),
}

/// Parameters μ, c, s, q, k. As r² - 1 follows q |ζ|² = q ξ², the coefficient of the cubic term is c + s q.
struct Ridden(Rider);

impl Field for Ridden {
    const N: usize = 4;
    const P: usize = 5;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        let (mu, c, s, q, k) = (p[0], p[1], p[2], p[3], p[4]);
        let one = R::from(1.0);
        let half = R::from(0.5);
        let square = x[0] * x[0] + x[1] * x[1];
        let r = square.sqrt();
        let (cos, sin) = (x[0] / r, x[1] / r);
        let (z, w) = (x[2], x[3]);
        let far = square - one;
        let (size, rate) = match self.0 {
            Rider::Flip => {
                // ξ = C z + S w with C, S of the half angle: products of two are smooth.
                let (cc, ss, cs) = ((one + cos) * half, (one - cos) * half, sin * half);
                let (a, b) = (cc * z + cs * w, cs * z + ss * w);
                let size = a * z + b * w;
                let turn = half * (one + k * size);
                let g = mu + c * size + s * far;
                out[2] = g * a - turn * w - (ss * z - cs * w);
                out[3] = g * b + turn * z - (cc * w - cs * z);
                (size, one + k * size)
            }
            Rider::Whirl(omega) => {
                let size = z * z + w * w;
                let g = mu + c * size + s * far;
                let turn = R::from(omega) + R::from(2.0) * size;
                out[2] = g * z - turn * w;
                out[3] = g * w + turn * z;
                (size, one + k * size)
            }
        };
        let g = -far + q * size;
        out[0] = g * x[0] - rate * x[1];
        out[1] = g * x[1] + rate * x[0];
    }
}

fn coefficients(rider: Rider, parameters: [f64; 4]) -> (Kind, Vec<f64>) {
    let problem = Exact::<_, 4>(Ridden(rider));
    let times: Vec<f64> = (0..=200).map(|k| 2.0 * PI * f64::from(k) / 200.0).collect();
    let states: Vec<Vec<f64>> = times
        .iter()
        .map(|t| vec![t.cos(), t.sin(), 0.0, 0.0])
        .collect();
    let samples = Samples {
        times: &times,
        states: &states,
        period: 2.0 * PI,
        periods: 1,
        winding: &[],
    };
    let mut p = vec![-0.05];
    p.extend(parameters);
    let s = Settings::new(&[(-0.1, 0.1)]);
    let b = cycles_from_samples(&problem, &samples, &p, 0, &s).unwrap();
    assert_eq!(b.special.len(), 1, "{:?}", b.special);
    // Multipliers by suspension (S15): -exp(2πμ) on the strip, exp(2π(μ ± iω)) beside it.
    let size = (2.0 * PI * b.points[0].solution.parameters[0]).exp();
    let expected = match rider {
        Rider::Flip => num_complex::Complex64::new(-size, 0.0),
        Rider::Whirl(omega) => num_complex::Complex64::from_polar(size, 2.0 * PI * omega),
    };
    let gap = b.points[0]
        .spectrum
        .iter()
        .map(|v| (v - expected).norm())
        .fold(f64::INFINITY, f64::min);
    assert!(gap < 1e-8, "{gap:e}");
    assert!(b.special[0].solution.parameters[0].abs() < 1e-8);
    (b.special[0].kind, b.special[0].normal_form.clone())
}

#[test]
fn period_doubling() {
    // Mean |v|² = 1 and |ξ e| = |ξ|: the coefficient is that of the system. The tolerance is that of the mesh.
    for (c, s, q, k) in [
        (-0.7, 0.0, 0.0, 0.0),
        (-0.7, 0.0, 0.0, 0.4),
        (-0.7, 0.5, 0.6, 0.4),
        (0.3, -0.8, 0.9, -0.3),
    ] {
        let (kind, found) = coefficients(Rider::Flip, [c, s, q, k]);
        assert_eq!(kind, Kind::PeriodDoubling);
        close(found[0], c + s * q, 1e-6);
    }
}

#[test]
fn torus() {
    // Mean |v|² = 1 makes |ζ|² = 2 |ξ|²; the faster phase a = 2 k takes its turns from the imaginary part.
    let omega = 0.37;
    for (c, s, q, k) in [
        (-0.7, 0.0, 0.0, 0.0),
        (-0.7, 0.5, 0.6, 0.4),
        (0.3, -0.8, 0.9, -0.3),
    ] {
        let (kind, found) = coefficients(Rider::Whirl(omega), [c, s, q, k]);
        assert_eq!(kind, Kind::Torus);
        close(found[0], 2.0 * (c + s * q), 1e-6);
        close(found[1], 2.0 * 2.0 - omega * 2.0 * k, 1e-6);
    }
}

#[test]
fn fold_of_cycles() {
    // r' = g(r) with g'' = 8 r³ at the fold of Bautin's form, be = -1: r² = 1/2.
    let problem = Exact::<_, 2>(Bautin);
    let s = Settings::new(&[(-0.5, 1.0)]);
    let e = equilibria(&problem, &[0.0; 2], &[-0.5, -1.0], 0, &s).unwrap();
    let b = cycles_from_hopf(&problem, &e.special[0], 0, &s).unwrap();
    let fold = b.of(Kind::CycleFold)[0];
    close(fold.normal_form[0], 4.0 * 0.5_f64.powf(1.5), 1e-6);
}

#[test]
fn sign_of_a_published_torus_and_no_coefficients_from_differences() {
    // S8: the torus is born stable.
    let problem = Exact::<_, 4>(Peroxidase);
    let start = [31.7915, 1.454_61, 0.015_245_9, 0.177_611];
    let mut s = Settings::new(&[(0.5, 5.0)]);
    let e = equilibria(&problem, &start, &[4.2355], 0, &s).unwrap();
    s.maximum_points = 12;
    let b = cycles_from_hopf(&problem, &e.special[0], 0, &s).unwrap();
    assert!(b.special[0].normal_form[0] < 0.0, "{:?}", b.special);
    // Finite differences get no coefficients.
    let plain = Closure::new(2, 2, |_t, x: &[f64], p: &[f64], out: &mut [f64]| {
        let s = x[0] * x[0] + x[1] * x[1];
        let g = p[0] + p[1] * s + s * s;
        out[0] = g * x[0] - x[1];
        out[1] = g * x[1] + x[0];
    });
    let s = Settings::new(&[(-0.5, 1.0)]);
    let e = equilibria(&plain, &[0.0; 2], &[-0.5, -1.0], 0, &s).unwrap();
    let b = cycles_from_hopf(&plain, &e.special[0], 0, &s).unwrap();
    assert!(b.approximate && b.of(Kind::CycleFold)[0].normal_form.is_empty());
}

#[test]
fn doubled_cycles_grow_as_the_coefficient_says() {
    // ξ' = κ (α - α₀) ξ + c ξ³ gives ξ² = -κ (α - α₀) / c, with κ T the derivative of the multiplier's logarithm and
    // x(t) - x(t + T) = 2 ξ v. The next term of ξ² is taken out by two values; what is left is of second order, 1e-3.
    let problem = Exact::<_, 3>(Feedback);
    let range = Settings::new(&[(0.3, 1.5)]);
    let e = equilibria(&problem, &[0.0; 3], &[1.5, 1.0], 0, &range).unwrap();
    let h = 1e-3;
    let mut s = Settings::new(&[(0.5, 1.2)]);
    let b = cycles_from_hopf(&problem, &e.special[0], 0, &s).unwrap();
    let pd = b.of(Kind::PeriodDoubling)[0].clone();
    let at = pd.solution.parameters[0];
    s.at = vec![at + h, at - h];
    let b = cycles_from_hopf(&problem, &e.special[0], 0, &s).unwrap();
    let log = |k: usize| {
        let negative = b.at[k].spectrum.iter().find(|v| v.re < -0.5);
        negative.unwrap().norm().ln()
    };
    let kappa = (log(0) - log(1)) / (2.0 * h) / pd.solution.period;
    s.at = vec![at - h, at - 2.0 * h];
    s.maximum_points = 20;
    let d = cycles_doubled(&problem, &pd, 0, &s).unwrap();
    let square = |k: usize| {
        let orbit = &d.at[k].solution;
        let sum: f64 = (0..400)
            .map(|i| {
                let tau = 0.5 * f64::from(i) / 400.0;
                let (a, b) = (orbit.state(tau), orbit.state(tau + 0.5));
                a.iter().zip(&b).map(|(a, b)| (a - b).powi(2)).sum::<f64>()
            })
            .sum();
        sum / 400.0 / 4.0
    };
    let slope = (4.0 * square(0) - square(1)) / (2.0 * -h);
    close(pd.normal_form[0], -kappa / slope, 2e-3);
}
