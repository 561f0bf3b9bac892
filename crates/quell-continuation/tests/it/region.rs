//! Regions whose curves and cells have closed forms.

use crate::close;
use crate::support::{Exact, Field, Real};
use quell_continuation::{
    Attractor, CurveSolutions, Equilibrium, Kind, ParameterSpan, Region, RegionSettings, region,
};

fn linear(from: f64, to: f64) -> ParameterSpan {
    ParameterSpan {
        from,
        to,
        logarithmic: false,
    }
}

fn rest(states: usize, parameters: [f64; 2]) -> Equilibrium {
    Equilibrium {
        state: vec![0.0; states],
        parameters: parameters.to_vec(),
    }
}

/// Equilibria and cycles that attract in a cell.
fn counts(region: &Region) -> Vec<(f64, usize, usize)> {
    region
        .cells
        .iter()
        .map(|cell| {
            let all = cell.attractors.as_ref().unwrap();
            let cycles = all.iter().filter(|one| matches!(one, Attractor::Cycle(_)));
            let cycles = cycles.count();
            (cell.area, all.len() - cycles, cycles)
        })
        .collect()
}

/// Part of the rectangle with so many stable equilibria and cycles.
fn part(region: &Region, equilibria: usize, cycles: usize) -> f64 {
    let all = counts(region).into_iter();
    all.filter(|(_, e, c)| (*e, *c) == (equilibria, cycles))
        .map(|(area, ..)| area)
        .sum()
}

fn codes(region: &Region) -> Vec<(&'static str, Option<&str>)> {
    let curves = region.curves.iter();
    curves
        .map(|curve| (curve.kind.code(), curve.parent.as_deref()))
        .collect()
}

/// r' = r (p + q r² - r⁴), θ' = 1.
struct Bautin;
impl Field for Bautin {
    const N: usize = 2;
    const P: usize = 2;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        let r = x[0] * x[0] + x[1] * x[1];
        let growth = p[0] + p[1] * r - r * r;
        out[0] = growth * x[0] - x[1];
        out[1] = growth * x[1] + x[0];
    }
}

/// Hopf at p = 0, generalised Hopf at (0, 0), folds of cycles at p = -q²/4 for q > 0: rest and a cycle between the two.
#[test]
fn folds_of_cycles_from_a_generalised_hopf_point() {
    let problem = Exact::<_, 2>(Bautin);
    let settings = RegionSettings::new([linear(-0.4, 0.5), linear(-1.1, 1.0)], 2);
    let found = region(&problem, &rest(2, [-0.4, -1.1]), &settings).unwrap();
    assert_eq!(
        codes(&found),
        [("H", None), ("LPC", Some("GH1"))],
        "{:?}",
        found.failed
    );
    let CurveSolutions::Equilibria(hopf) = &found.curves[0].solutions else {
        panic!("a Hopf curve is of equilibria");
    };
    let gh = hopf.of(Kind::GeneralisedHopf)[0];
    for value in &gh.solution.equilibrium.parameters {
        assert!(value.abs() < 1e-7, "{value}");
    }
    let CurveSolutions::Cycles(folds) = &found.curves[1].solutions else {
        panic!("a fold curve is of cycles");
    };
    for point in &folds.points {
        let [p, q] = point.solution.orbit.parameters[..] else {
            panic!("two parameters");
        };
        assert!((p + 0.25 * q * q).abs() < 1e-8, "{p} {q}");
    }
    // ∫ q²/4 over [0, 1] = 1/12 of 0.9 · 2.1; chords miss the parabola by some 1e-5.
    close(part(&found, 1, 1), 1.0 / 12.0 / 1.89, 2e-3);
    close(part(&found, 0, 1), 0.5 / 0.9, 1e-6);
    close(part(&found, 1, 0), 0.4 / 0.9 - 1.0 / 12.0 / 1.89, 2e-4);
}

/// The normal form of a Hopf-Hopf point of two modes that suppress each other: r₁' = r₁ (μ₁ - r₁² - 2 r₂²), r₂' = r₂ (μ₂ - 2 r₁² - r₂²).
struct Competing;
impl Field for Competing {
    const N: usize = 4;
    const P: usize = 2;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        let two = R::from(2.0);
        let first = x[0] * x[0] + x[1] * x[1];
        let second = x[2] * x[2] + x[3] * x[3];
        let growth = [p[0] - first - two * second, p[1] - two * first - second];
        out[0] = growth[0] * x[0] - x[1];
        out[1] = growth[0] * x[1] + x[0];
        let omega = R::from(1.7);
        out[2] = growth[1] * x[2] - omega * x[3];
        out[3] = growth[1] * x[3] + omega * x[2];
    }
}

/// Torus curves are μ₂ = 2 μ₁ and μ₁ = 2 μ₂; both cycles are stable between them.
#[test]
fn torus_curves_from_a_hopf_hopf_point_bound_where_both_cycles_are_stable() {
    let problem = Exact::<_, 4>(Competing);
    let settings = RegionSettings::new([linear(-0.9, 1.1), linear(-0.7, 1.3)], 4);
    let found = region(&problem, &rest(4, [-0.9, -0.7]), &settings).unwrap();
    let mut kinds = codes(&found);
    kinds.sort_unstable();
    assert_eq!(
        kinds,
        [
            ("H", None),
            ("H", None),
            ("NS", Some("HH1")),
            ("NS", Some("HH1"))
        ],
        "{:?}",
        found.failed
    );
    let mut slopes = Vec::new();
    for curve in &found.curves {
        let CurveSolutions::Cycles(torus) = &curve.solutions else {
            continue;
        };
        let last = &torus.points[torus.points.len() - 1]
            .solution
            .orbit
            .parameters;
        slopes.push(last[1] / last[0]);
    }
    slopes.sort_by(f64::total_cmp);
    // Located by Newton's method on orbits whose mesh holds 1e-8.
    close(slopes[0], 0.5, 1e-7);
    close(slopes[1], 2.0, 1e-7);
    // In [0, 1.1] × [0, 1.3] less the triangles below μ₁/2 and above 2 μ₁; all of 2 · 2.
    let below = 0.5 * 1.1 * 0.55;
    let above = 0.5 * 1.3 * 0.65;
    close(part(&found, 0, 2), (1.1 * 1.3 - below - above) / 4.0, 1e-5);
    close(part(&found, 1, 0), 0.9 * 0.7 / 4.0, 1e-5);
    close(counts(&found).iter().map(|cell| cell.0).sum(), 1.0, 1e-9);
}

/// Growth rates that are positive in one small disc and negative in another, far from every line of the first look.
struct Islands;
impl Field for Islands {
    const N: usize = 4;
    const P: usize = 2;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        let disc = |a: f64, b: f64| {
            let (u, v) = (p[0] - R::from(a), p[1] - R::from(b));
            R::from(0.0004) - u * u - v * v
        };
        // An unstable disc about (0.37, 0.61) for one mode; for the other a disc of stability about (0.63, 0.38).
        let growth = [disc(0.37, 0.61), -disc(0.63, 0.38)];
        for (k, omega) in [1.0, 1.7].into_iter().enumerate() {
            let (a, b) = (x[2 * k], x[2 * k + 1]);
            let own = growth[k] - a * a - b * b;
            out[2 * k] = own * a - R::from(omega) * b;
            out[2 * k + 1] = own * b + R::from(omega) * a;
        }
    }
}

/// Both discs have radius 0.02, half of the distance of columns.
#[test]
fn islands_between_columns_are_found() {
    let problem = Exact::<_, 4>(Islands);
    let settings = RegionSettings::new([linear(0.0, 1.0), linear(0.0, 1.0)], 4);
    let found = region(&problem, &rest(4, [0.0, 0.0]), &settings).unwrap();
    assert_eq!(
        codes(&found),
        [("H", None), ("H", None)],
        "{:?}",
        found.failed
    );
    let disc = std::f64::consts::PI * 4e-4;
    let mut small: Vec<f64> = counts(&found).iter().map(|cell| cell.0).collect();
    small.remove(0);
    assert_eq!(small.len(), 2);
    for area in small {
        // Of a polygon whose corners are some 0.1 rad apart.
        close(area, disc, 5e-3);
    }
    // Outside of the second disc its mode oscillates; the first mode dies out but in its own disc.
    close(part(&found, 1, 0), disc, 5e-3);
}
