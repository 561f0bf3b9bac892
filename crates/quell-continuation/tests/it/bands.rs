//! Stable bands of oscillators whose growth rates are given functions of two parameters: the edges are known in closed form.

use std::f64::consts::PI;

use quell_continuation::{BandSettings, Bands, Limit, Linearisation, ParameterSpan, stable_bands};

/// Oscillators x'' - 2 h x' + ω² x = 0 with growth rates h(p, q), of which Re λ = h while |h| < ω, all mixed by a similarity.
struct Oscillators<F> {
    frequencies: Vec<f64>,
    growth: F,
    evaluations: usize,
}

impl<F: Fn(f64, f64, usize) -> f64> Linearisation for Oscillators<F> {
    fn states(&self) -> usize {
        2 * self.frequencies.len()
    }

    fn matrix(&mut self, p: f64, q: f64, out: &mut [f64]) -> bool {
        self.evaluations += 1;
        let n = self.states();
        let mut a = vec![0.0; n * n];
        for (k, omega) in self.frequencies.iter().enumerate() {
            let h = (self.growth)(p, q, k);
            a[2 * k * n + 2 * k + 1] = 1.0;
            a[(2 * k + 1) * n + 2 * k] = -omega * omega;
            a[(2 * k + 1) * n + 2 * k + 1] = 2.0 * h;
        }
        // T A T⁻¹ with T = I + e vᵀ for e ⟂ v, so that T⁻¹ = I - e vᵀ: no block stands by itself.
        let v: Vec<f64> = (0..n).map(|i| 0.3 + 0.1 * i as f64).collect();
        let e: Vec<f64> = (0..n)
            .map(|i| if i % 2 == 0 { v[i + 1] } else { -v[i - 1] })
            .collect();
        let va: Vec<f64> = (0..n)
            .map(|j| (0..n).map(|i| v[i] * a[i * n + j]).sum())
            .collect();
        let ta: Vec<f64> = (0..n * n).map(|k| a[k] + e[k / n] * va[k % n]).collect();
        let te: Vec<f64> = (0..n)
            .map(|i| (0..n).map(|j| ta[i * n + j] * e[j]).sum())
            .collect();
        for k in 0..n * n {
            out[k] = ta[k] - te[k / n] * v[k % n];
        }
        true
    }
}

fn bands(
    frequencies: &[f64],
    growth: impl Fn(f64, f64, usize) -> f64,
    p: ParameterSpan,
    q: Option<ParameterSpan>,
) -> Bands {
    let mut problem = Oscillators {
        frequencies: frequencies.to_vec(),
        growth,
        evaluations: 0,
    };
    let found = stable_bands(&mut problem, p, q, &BandSettings::default());
    assert!(found.unresolved.is_empty(), "{found:?}");
    found
}

#[track_caller]
fn edges(found: &Bands, expected: &[(f64, f64)]) {
    assert_eq!(found.bands.len(), expected.len(), "{found:?}");
    for (band, (lower, upper)) in found.bands.iter().zip(expected) {
        // The promise: 1e-9 relative.
        let near = |found: f64, expected: f64| (found - expected).abs() <= 1e-9 * expected.abs();
        assert!(near(band.lower.p, *lower), "{band:?} for {lower}");
        assert!(near(band.upper.p, *upper), "{band:?} for {upper}");
    }
}

/// h1 = 1 - p - (q - 3)²/10 and h2 = p - 5 - (q - 7)²/10 leave 1 < p < 5, at q = 3 and q = 7.
#[test]
fn edges_are_extrema_of_hopf_curves() {
    let growth = |p: f64, q: f64, k: usize| {
        if k == 0 {
            0.3 * (1.0 - p) - (q - 3.0).powi(2) / 10.0
        } else {
            0.2 * (p - 5.0) - (q - 7.0).powi(2) / 10.0
        }
    };
    let found = bands(
        &[10.0, 23.0],
        growth,
        ParameterSpan::new(0.5, 8.0),
        Some(ParameterSpan::new(0.0, 10.0)),
    );
    edges(&found, &[(1.0, 5.0)]);
    let band = found.bands[0];
    assert_eq!(
        (band.lower.limit, band.upper.limit),
        (Limit::Hopf, Limit::Hopf)
    );
    assert!((band.lower.q.unwrap() - 3.0).abs() < 1e-6);
    assert!((band.upper.q.unwrap() - 7.0).abs() < 1e-6);
    assert!((band.lower.eigenvalue.im - 10.0).abs() < 1e-6);
    assert!((band.upper.slope - 0.2).abs() < 1e-6);
}

/// An island of radius r about (2.357, 6.131), r far below any grid: h = (r² - |x - x0|²) splits the band at 2.357 -+ r.
#[test]
fn islands_are_found_however_small() {
    for radius in [0.5, 0.03, 1e-3, 2e-5] {
        let growth = move |p: f64, q: f64, k: usize| {
            if k == 0 {
                radius * radius - (p - 2.357).powi(2) - (q - 6.131).powi(2)
            } else {
                -1.0 - 0.1 * p
            }
        };
        let found = bands(
            &[31.0, 12.0],
            growth,
            ParameterSpan::new(1.0, 5.0),
            Some(ParameterSpan::new(0.0, 10.0)),
        );
        assert_eq!(found.bands.len(), 2, "{radius}: {found:?}");
        let half = 0.5 * (found.bands[1].lower.p - found.bands[0].upper.p);
        // Near its top the growth is flat: at a rounding of 1e-14 an island of 2e-5 is known to some 1e-6 of its size.
        assert!((half / radius - 1.0).abs() < 1e-4, "{radius}: {half}");
        // Large ones are met by a column; of others the top was found.
        for peak in &found.peaks {
            assert!((peak.eigenvalue.re - radius * radius).abs() < 1e-12);
        }
    }
}

/// The same island just below the axis is none, and its peak is told.
#[test]
fn what_is_not_born_splits_nothing() {
    let growth = |p: f64, q: f64, _: usize| -1e-9 - (p - 2.357).powi(2) - (q - 6.131).powi(2);
    let found = bands(
        &[31.0],
        growth,
        ParameterSpan::new(1.0, 5.0),
        Some(ParameterSpan::new(0.0, 10.0)),
    );
    assert_eq!(found.bands.len(), 1, "{found:?}");
    assert!((found.peaks[0].eigenvalue.re + 1e-9).abs() < 1e-12);
    assert!((found.peaks[0].p - 2.357).abs() < 1e-6);
}

/// A narrow band between two ridges: stable where max(0.1 (p - 3) , 0.1 (2.999 - p)) < 0 is not, so one a thousandth wide.
#[test]
fn narrow_bands_are_found() {
    let growth = |p: f64, q: f64, k: usize| {
        let own = if k == 0 {
            0.1 * (2.9991 - p)
        } else {
            0.2 * (p - 3.0)
        };
        own - 0.01 * (q - 4.0).powi(2)
    };
    let found = bands(
        &[5.0, 8.0],
        growth,
        ParameterSpan::new(1.0, 5.0),
        Some(ParameterSpan::new(0.0, 10.0)),
    );
    edges(&found, &[(2.9991, 3.0)]);
}

/// A growth that is largest at an end of q's range, over decades of p: h = ln(p/20) + (q - 1) is zero at q = 1 where p = 20.
#[test]
fn ends_of_the_other_range_limit_too() {
    let growth = |p: f64, q: f64, k: usize| {
        if k == 0 {
            (p / 20.0).ln() + q - 1.0
        } else {
            -2.0
        }
    };
    let found = bands(
        &[40.0, 77.0],
        growth,
        ParameterSpan::new(1.0, 1e4),
        Some(ParameterSpan::new(0.0, 1.0)),
    );
    edges(&found, &[(1.0, 20.0)]);
    assert_eq!(found.bands[0].upper.limit, Limit::HopfAtEnd);
    assert_eq!(found.bands[0].lower.limit, Limit::Range);
}

/// Without another parameter: h = sin p is below zero between odd and even multiples of π.
#[test]
fn one_parameter_alone() {
    let found = bands(
        &[3.0],
        |p, _, _| p.sin(),
        ParameterSpan::new(1.0, 20.0),
        None,
    );
    edges(
        &found,
        &[(PI, 2.0 * PI), (3.0 * PI, 4.0 * PI), (5.0 * PI, 6.0 * PI)],
    );
}

/// Two modes of nearly the same frequency with a weak circulatory coupling ±p and equal damping d (binary flutter): λ² + 2 d λ = μ
/// with μ = -(100 + Δ/2) ± sqrt(Δ²/4 - p²), stable while p² < Δ²/4 + 4 d² (100 + Δ/2), of which the least over Δ is
/// 400 d² - 4 d⁴ at Δ = -4 d².
#[test]
fn narrow_flutter_at_a_crossing() {
    struct Flutter;
    impl Linearisation for Flutter {
        fn states(&self) -> usize {
            4
        }
        fn matrix(&mut self, p: f64, q: f64, out: &mut [f64]) -> bool {
            out.fill(0.0);
            let d = 0.01;
            out[1] = 1.0;
            out[4..8].copy_from_slice(&[-100.0, -2.0 * d, p, 0.0]);
            out[11] = 1.0;
            out[12..16].copy_from_slice(&[-p, 0.0, -100.0 - 13.7 * (q - 0.377), -2.0 * d]);
            true
        }
    }
    // The frequencies are locked over 2 p/13.7 = 0.03 of a range of 10.
    let found = stable_bands(
        &mut Flutter,
        ParameterSpan::new(0.02, 0.6),
        Some(ParameterSpan::new(-5.0, 5.0)),
        &BandSettings::default(),
    );
    assert_eq!(found.bands.len(), 1, "{found:?}");
    let d: f64 = 0.01;
    edges(&found, &[(0.02, (400.0 * d * d - 4.0 * d.powi(4)).sqrt())]);
    let q = 0.377 - 4.0 * d * d / 13.7;
    assert!((found.bands[0].upper.q.unwrap() - q).abs() < 1e-7);
}
