//! Zeros and minima of a function of time, to rounding.

/// The two sides of a sign change, in order of time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bracket {
    pub(crate) near: f64,
    pub(crate) far: f64,
}

/// Narrows a sign change of f between a and b to `tolerance` (or neighbouring numbers): bisection, secant and inverse
/// quadratic steps after T. E. Chandrupatla (1997). a < b; f(a) and f(b) must differ in sign.
pub(crate) fn root(
    (mut a, mut fa): (f64, f64),
    (mut b, mut fb): (f64, f64),
    tolerance: f64,
    mut f: impl FnMut(f64) -> f64,
) -> Bracket {
    let (mut c, mut fc);
    let mut fraction = 0.5;
    for _ in 0..200 {
        let width = (b - a).abs();
        let smallest = tolerance.max(2.0 * f64::EPSILON * a.abs().max(b.abs()));
        if width <= smallest {
            break;
        }
        let t = a + fraction * (b - a);
        let ft = f(t);
        if (ft > 0.0) == (fa > 0.0) {
            c = a;
            fc = fa;
        } else {
            c = b;
            fc = fb;
            b = a;
            fb = fa;
        }
        a = t;
        fa = ft;
        let best = if fa.abs() < fb.abs() { a } else { b };
        let smallest = tolerance.max(2.0 * f64::EPSILON * best.abs());
        let least = 0.5 * smallest / (b - a).abs();
        if least > 0.5 {
            break;
        }
        let xi = (a - b) / (c - b);
        let phi = (fa - fb) / (fc - fb);
        fraction = if phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi {
            fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        } else {
            0.5
        };
        fraction = if fraction.is_finite() {
            fraction.clamp(least, 1.0 - least)
        } else {
            0.5
        };
    }
    Bracket {
        near: a.min(b),
        far: a.max(b),
    }
}

/// A minimum of f inside [a, c] that has f(b) ≤ f(a), f(c): golden section with parabolic steps (R. P. Brent, 1973). Time is good
/// to the square root of rounding, the value to rounding. Ends early, where told to, as soon as f is below `enough`.
pub(crate) fn minimum(
    (mut a, mut c): (f64, f64),
    (b, fb): (f64, f64),
    enough: f64,
    mut f: impl FnMut(f64) -> f64,
) -> (f64, f64) {
    const GOLDEN: f64 = 0.381_966_011_250_105_1;
    let (mut x, mut fx) = (b, fb);
    let (mut w, mut fw) = (b, fb);
    let (mut v, mut fv) = (b, fb);
    let mut moved: f64 = 0.0;
    let mut before: f64 = 0.0;
    let span = c - a;
    for _ in 0..100 {
        if fx < enough {
            break;
        }
        let middle = 0.5 * (a + c);
        let smallest = 1e-9 * span + 4.0 * f64::EPSILON * x.abs();
        if (x - middle).abs() <= 2.0 * smallest - 0.5 * (c - a) {
            break;
        }
        let mut golden = true;
        let mut step = 0.0;
        if before.abs() > smallest {
            let r = (x - w) * (fx - fv);
            let mut q = (x - v) * (fx - fw);
            let mut p = (x - v) * q - (x - w) * r;
            q = 2.0 * (q - r);
            if q > 0.0 {
                p = -p;
            }
            q = q.abs();
            if p.abs() < (0.5 * q * before).abs() && p > q * (a - x) && p < q * (c - x) {
                step = p / q;
                let u = x + step;
                if u - a < 2.0 * smallest || c - u < 2.0 * smallest {
                    step = if x < middle { smallest } else { -smallest };
                }
                golden = false;
                before = moved;
            }
        }
        if golden {
            before = if x < middle { c - x } else { a - x };
            step = GOLDEN * before;
        }
        moved = step;
        let u = if step.abs() >= smallest {
            x + step
        } else {
            x + smallest.copysign(step)
        };
        let fu = f(u);
        if fu <= fx {
            if u < x {
                c = x;
            } else {
                a = x;
            }
            (v, fv) = (w, fw);
            (w, fw) = (x, fx);
            (x, fx) = (u, fu);
        } else {
            if u < x {
                a = u;
            } else {
                c = u;
            }
            if fu <= fw || w == x {
                (v, fv) = (w, fw);
                (w, fw) = (u, fu);
            } else if fu <= fv || v == x || v == w {
                (v, fv) = (u, fu);
            }
        }
    }
    (x, fx)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_to_rounding() {
        type Case = (fn(f64) -> f64, f64, f64, f64);
        let cases: [Case; 4] = [
            (|t| t * t - 2.0, 0.0, 2.0, 2f64.sqrt()),
            (|t| (t - 1.0).powi(3), 0.0, 3.0, 1.0),
            (|t| t.cos(), 0.0, 3.0, std::f64::consts::FRAC_PI_2),
            (|t| if t < 0.3 { -1.0 } else { 1e9 }, 0.0, 1.0, 0.3),
        ];
        for (f, a, b, exact) in cases {
            let mut count = 0;
            let bracket = root((a, f(a)), (b, f(b)), 0.0, |t| {
                count += 1;
                f(t)
            });
            assert!(bracket.near <= bracket.far);
            assert!((bracket.far - exact).abs() < 1e-15 * 4.0 || exact == 1.0);
            // The cubic is flat to rounding within 1e-5 of its zero.
            assert!((bracket.far - exact).abs() < 1e-5);
            assert!(count < 80, "{count}");
        }
    }

    #[test]
    fn minima() {
        let f = |t: f64| (t - 0.4).powi(2) + 1.0;
        let (t, value) = minimum((0.0, 1.0), (0.5, f(0.5)), f64::NEG_INFINITY, f);
        assert!((t - 0.4).abs() < 1e-7 && (value - 1.0).abs() < 1e-15);
    }
}
