//! Refinement of a peak between grid points.

/// A point (ω, 1/|H|²).
pub(crate) type Sample = (f64, f64);

/// The minimum of φ = 1/|H|² within (left, right), given φ(middle) ≤ both ends.
///
/// Near a resonance 1/|H|² is a parabola in ω (it is exactly one for a single pole), so parabolic steps with true
/// evaluations converge at once; golden sections guard them (R. P. Brent, 1973). It ends when the parabola predicted a
/// new sample within `tolerance` relative.
pub(crate) fn minimise(
    left: Sample,
    middle: Sample,
    right: Sample,
    tolerance: f64,
    mut evaluate: impl FnMut(f64) -> f64,
) -> Sample {
    const GOLDEN: f64 = 0.381_966_011_250_105;
    let (mut l, mut m, mut r) = (left, middle, right);
    let mut width = r.0 - l.0;
    for step in 0..40 {
        let (below, above) = (m.0 - l.0, r.0 - m.0);
        // φ(m + t) = φ_m + p t + q t²
        let (slope_left, slope_right) = ((l.1 - m.1) / below, (r.1 - m.1) / above);
        let q = (slope_left + slope_right) / (below + above);
        let p = slope_right - q * above;
        let mut t = -p / (2.0 * q);
        let near = 0.02 * below.min(above);
        let slow = step >= 6 && step % 3 == 0 && (r.0 - l.0) > 0.5 * width;
        if step % 3 == 0 {
            width = r.0 - l.0;
        }
        let parabolic = q > 0.0 && t > -below && t < above && !slow;
        if !parabolic {
            t = if above > below {
                GOLDEN * above
            } else {
                -GOLDEN * below
            };
        } else if t.abs() < near {
            // The vertex is (almost) the sample that there is: test the parabola a little beside it.
            t = if above > below { near } else { -near };
        }
        let x = m.0 + t;
        if !(x > l.0 && x < r.0) || x == m.0 {
            break;
        }
        let value = evaluate(x);
        let predicted = m.1 + t * (p + q * t);
        let sample = (x, value);
        let before = m.1;
        if value <= m.1 {
            if t > 0.0 {
                l = m;
            } else {
                r = m;
            }
            m = sample;
        } else if t > 0.0 {
            r = sample;
        } else {
            l = sample;
        }
        if parabolic && (value - predicted).abs() <= tolerance * m.1 {
            // The model is trusted; one more look at what is left of it to gain.
            let vertex = before - 0.25 * p * p / q;
            if m.1 - vertex <= tolerance * m.1 {
                break;
            }
        }
        if r.0 - l.0 <= 4.0 * f64::EPSILON * m.0.abs() || m.1 <= 0.0 {
            break;
        }
    }
    m
}

/// The least value of the parabola through three samples, at most that of the middle.
pub(crate) fn vertex(l: Sample, m: Sample, r: Sample) -> f64 {
    let (below, above) = (m.0 - l.0, r.0 - m.0);
    let (slope_left, slope_right) = ((l.1 - m.1) / below, (r.1 - m.1) / above);
    let q = (slope_left + slope_right) / (below + above);
    let p = slope_right - q * above;
    if q > 0.0 && q.is_finite() {
        m.1 - 0.25 * p * p / q
    } else {
        m.1
    }
}
