//! Meshes that hold a tolerance, and problems of many states.

use std::f64::consts::PI;

use crate::close;
use crate::support::models::VanDerPol;
use crate::support::{Exact, Field, Real, integrate};
use quell_continuation::{
    Branch, Directions, MeshSettings, Orbit, Samples, Settings, cycles_from_samples,
};

fn relaxation(mesh: MeshSettings) -> Branch<Orbit> {
    let problem = Exact::<_, 2>(VanDerPol);
    let (times, states) = integrate(
        &problem,
        &[2.0, 0.0],
        &[1.0],
        6.663_286_859_3 / 400.0,
        8_000,
        401,
    );
    let samples = Samples {
        times: &times,
        states: &states,
        period: 6.663,
        periods: 1,
        winding: &[],
    };
    let mut s = Settings::new(&[(0.5, 10.0)]);
    s.directions = Directions::Forward;
    s.at = vec![5.0];
    s.mesh = mesh;
    cycles_from_samples(&problem, &samples, &[1.0], 0, &s).unwrap()
}

fn intervals(orbit: &Orbit) -> usize {
    orbit.mesh.len() - 1
}

#[test]
fn the_number_of_intervals_follows_the_tolerance() {
    // Periods of oracle S13. The period is far better than the tolerance on the states (order 2m against m + 1).
    let mut last = 0;
    for (tolerance, error) in [(1e-5, 1e-5), (1e-7, 1e-7), (1e-9, 2e-10)] {
        let b = relaxation(MeshSettings {
            tolerance,
            bounds: (5, 400),
            ..MeshSettings::default()
        });
        let (five, ten) = (&b.at[0].solution, &b.points.last().unwrap().solution);
        close(five.period, 11.612_230_667_7, error);
        close(ten.period, 19.078_369_566_9, error);
        // Layers get thinner along the branch, so the mesh grows; and a smaller tolerance takes more intervals.
        let (start, end) = (intervals(&b.points[3].solution), intervals(ten));
        assert!(end > start, "{tolerance:e}: {start} to {end}");
        assert!(end > last, "{tolerance:e}: {end} after {last}");
        last = end;
        // Intervals are short where the motion is quick.
        let steps: Vec<f64> = ten.mesh.windows(2).map(|w| w[1] - w[0]).collect();
        let (least, most) = steps
            .iter()
            .fold((1.0_f64, 0.0_f64), |(a, b), h| (a.min(*h), b.max(*h)));
        assert!(most > 10.0 * least, "{least:e} {most:e}");
    }
    // Bounds are kept, and a fixed number is fixed.
    let b = relaxation(MeshSettings {
        tolerance: 1e-12,
        bounds: (20, 45),
        ..MeshSettings::default()
    });
    assert!(b.points.iter().all(|p| intervals(&p.solution) <= 45));
    let b = relaxation(MeshSettings::fixed(50, 4));
    assert!(b.points.iter().all(|p| intervals(&p.solution) == 50));
}

/// The cycle r = 1 and nineteen linear oscillators that it shakes, each with its damping and frequency.
struct Many;
impl Many {
    fn rates(k: usize) -> (f64, f64) {
        (0.02 + 0.08 * k as f64, 0.31 + 0.173 * k as f64)
    }
}
impl Field for Many {
    const N: usize = 40;
    const P: usize = 1;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        let g = R::from(1.0) - x[0] * x[0] - x[1] * x[1];
        out[0] = g * x[0] - x[1];
        out[1] = g * x[1] + x[0];
        for k in 0..19 {
            let (a, w) = Self::rates(k);
            let (y, z) = (x[2 + 2 * k], x[3 + 2 * k]);
            out[2 + 2 * k] = -(R::from(a) * y) - R::from(w) * z + p[0] * x[0];
            out[3 + 2 * k] = R::from(w) * y - R::from(a) * z;
        }
    }
}

#[test]
fn forty_states_with_multipliers_from_one_to_1e_4() {
    let problem = Exact::<_, 40>(Many);
    let times: Vec<f64> = (0..=200).map(|k| 2.0 * PI * f64::from(k) / 200.0).collect();
    let states: Vec<Vec<f64>> = times
        .iter()
        .map(|t| {
            let mut x = vec![0.0; 40];
            (x[0], x[1]) = (t.cos(), t.sin());
            x
        })
        .collect();
    let samples = Samples {
        times: &times,
        states: &states,
        period: 6.2,
        periods: 1,
        winding: &[],
    };
    let mut s = Settings::new(&[(0.0, 1.0)]);
    s.maximum_points = 4;
    s.mesh = MeshSettings::fixed(40, 5);
    let b = cycles_from_samples(&problem, &samples, &[0.1], 0, &s).unwrap();
    for p in &b.points {
        assert!(p.spectrum.len() == 39 && p.unstable == 0);
        for k in 0..19 {
            let (a, w) = Many::rates(k);
            let mu = num_complex::Complex64::from_polar((-2.0 * PI * a).exp(), 2.0 * PI * w);
            let gap = p
                .spectrum
                .iter()
                .map(|v| (v / mu).ln().norm())
                .fold(f64::INFINITY, f64::min);
            // Collocation of degree 5 on 40 intervals resolves a frequency of 3.4 to 1e-9.
            assert!(gap < 1e-8, "{k}: {gap:e}");
        }
    }
}
