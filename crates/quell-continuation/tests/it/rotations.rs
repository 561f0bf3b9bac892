//! Orbits that come back but for whole turns of an angle, and orbits of several periods of the forcing.

use std::f64::consts::{PI, TAU};

use crate::close;
use crate::support::models::Duffing;
use crate::support::{Exact, Field, Real, integrate};
use quell_continuation::{
    Directions, Kind, Samples, Settings, Stop, cycles_doubled, cycles_from_samples,
};

/// φ' = I - sin φ: one turn takes 2π / √(I² - 1) (R. Adler 1946).
struct Adler;
impl Field for Adler {
    const N: usize = 1;
    const P: usize = 1;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        out[0] = p[0] - x[0].sin();
    }
}

#[test]
fn turns_of_an_angle() {
    let problem = Exact::<_, 1>(Adler);
    let (times, states) = integrate(&problem, &[0.3], &[1.5], 1e-3, 20_000, 8_000);
    let period = TAU / (1.5_f64.powi(2) - 1.0).sqrt();
    let first = states[0][0];
    let turn = states.iter().position(|x| x[0] >= first + TAU).unwrap();
    let samples = Samples {
        times: &times[..=turn],
        states: &states[..=turn],
        period: times[turn] - times[0],
        periods: 1,
        winding: &[1],
    };
    let mut s = Settings::new(&[(1.0, 3.0)]);
    s.at = vec![1.01, 1.1, 2.0, 3.0];
    s.period_bound = 60.0;
    s.maximum_points = 300;
    let b = cycles_from_samples(&problem, &samples, &[1.5], 0, &s).unwrap();
    assert!((period - samples.period).abs() < 2e-3);
    assert_eq!(b.stop, [Stop::PeriodBound, Stop::Bound(0)]);
    assert!(b.special.is_empty());
    assert!(b.at.len() >= 3);
    for at in b.at.iter().chain(&b.points) {
        let i = at.solution.parameters[0];
        if i < 1.005 {
            continue; // Slow past the ghost of the fold: the tolerance of the mesh tells less about the period.
        }
        close(at.solution.period, TAU / (i * i - 1.0).sqrt(), 1e-7);
        let (low, high) = at.solution.range(0);
        assert!((high - low - TAU).abs() < 1e-9);
    }
}

#[test]
fn several_periods_of_the_forcing() {
    // A linear oscillator's motion of one period is one of three as well: period, states and multipliers cubed.
    let problem = Exact::<_, 2>(Duffing);
    let p = [0.5, 0.2, 0.05];
    let one = TAU / p[0];
    let (times, states) = integrate(&problem, &[0.0; 2], &p, one / 400.0, 100 * 400, 3 * 400 + 1);
    let branch = |periods: usize| {
        let kept = periods * 400 + 1;
        let samples = Samples {
            times: &times[times.len() - kept..],
            states: &states[states.len() - kept..],
            period: 0.0,
            periods,
            winding: &[],
        };
        let mut s = Settings::new(&[(0.5, 0.7)]);
        s.directions = Directions::Forward;
        s.at = vec![0.6];
        s.mesh.tolerance = 1e-9;
        cycles_from_samples(&problem, &samples, &p, 0, &s).unwrap()
    };
    let (single, triple) = (branch(1), branch(3));
    let (a, b) = (&single.at[0], &triple.at[0]);
    close(b.solution.period, 3.0 * TAU / 0.6, 1e-14);
    assert_eq!(b.solution.periods, 3);
    for k in 0..3 {
        let (x, y) = (
            a.solution.state(0.37),
            b.solution.state((0.37 + f64::from(k)) / 3.0),
        );
        assert!((x[0] - y[0]).abs() < 1e-7 && (x[1] - y[1]).abs() < 1e-7);
    }
    let det = |p: &quell_continuation::Point<quell_continuation::Orbit>| {
        p.spectrum.iter().map(|v| v.norm()).product::<f64>()
    };
    close(det(b), det(a).powi(3), 1e-7);
    close(det(b), (-0.1 * 3.0 * TAU / 0.6).exp(), 1e-7);
}

/// x'' + 0.1 x' + (1 + p cos 2t... ) x + x³ = 0 about rest: a parametrically forced oscillator.
struct Mathieu;
impl Field for Mathieu {
    const N: usize = 2;
    const P: usize = 2;
    fn f<R: Real>(&self, t: R, x: &[R], p: &[R], out: &mut [R]) {
        let stiffness = R::from(1.0) + p[0] * (p[1] * t).cos();
        out[0] = x[1];
        out[1] = -(R::from(0.1) * x[1]) - stiffness * x[0] - x[0].cube();
    }
    fn period(&self, p: &[f64]) -> Option<f64> {
        Some(TAU / p[1])
    }
    fn period_derivative(&self, p: &[f64], k: usize) -> f64 {
        if k == 1 { -TAU / (p[1] * p[1]) } else { 0.0 }
    }
}

#[test]
fn doubled_motions_of_a_forced_system() {
    // Rest loses stability by period doubling at a forcing of twice its frequency (Ω = 2): the subharmonic of order two is
    // born there and has two periods of the forcing. To first order the threshold is p = 4 ζ = 0.2.
    let problem = Exact::<_, 2>(Mathieu);
    let times: Vec<f64> = (0..=40).map(|k| PI * f64::from(k) / 40.0).collect();
    let states = vec![vec![0.0, 0.0]; 41];
    let samples = Samples {
        times: &times,
        states: &states,
        period: PI,
        periods: 1,
        winding: &[],
    };
    let mut s = Settings::new(&[(0.0, 0.6)]);
    s.directions = Directions::Forward;
    let b = cycles_from_samples(&problem, &samples, &[0.0, 2.0], 0, &s).unwrap();
    let pd = b.of(Kind::PeriodDoubling);
    assert_eq!(pd.len(), 1, "{:?}", b.special);
    let at = pd[0].solution.parameters[0];
    assert!((at - 0.2).abs() < 0.005, "{at}");
    assert!(pd[0].normal_form[0].is_finite());
    s.maximum_points = 20;
    let d = cycles_doubled(&problem, pd[0], 0, &s).unwrap();
    let last = &d.points.last().unwrap().solution;
    assert_eq!(last.periods, 2);
    close(last.period, TAU, 1e-14);
    assert!(last.range(0).1 > 0.05);
    // Half a period of the doubled motion later it is upside down.
    let (x, y) = (last.state(0.2), last.state(0.7));
    assert!((x[0] + y[0]).abs() < 1e-6);
}
