//! Sine, cosine, arc sine, arc tangent, exponential and logarithm of several points at a time.
//!
//! The method of each, its polynomials and its bound of error (below one unit in the last place) are those of fdlibm,
//! written without branches: each step is one addition, multiplication, division or selection of all points, which the
//! compiler turns into vectors. No step is fused, so a point has the same bits alone, in a batch, and on every machine.
//! Where all points are small the reduction of the argument, which would change nothing, is left out. Arguments for which
//! it is not made (angles beyond 8e5, results near the ends of the range) go to the library of the platform.
//!
//! Source: fdlibm 5.3, with this notice: Copyright (C) 1993 by Sun Microsystems, Inc. All rights reserved. Developed at
//! SunSoft, a Sun Microsystems, Inc. business. Permission to use, copy, modify, and distribute this software is freely
//! granted, provided that this notice is preserved.

#![expect(
    clippy::inline_always,
    reason = "only what is inlined is compiled for the vectors of the machine"
)]
#![expect(
    clippy::excessive_precision,
    reason = "the constants as their source prints them"
)]

mod arc;
mod exponential;
mod sine;

pub(crate) use arc::{arc_sine, arc_tangent};
pub(crate) use exponential::{exponential, logarithm};
pub(crate) use sine::{cosine, sine};

/// Adding it rounds to a whole number, which its lowest bits then hold: 3/2 2^52.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// A function of one point, by that of many.
#[inline(always)]
pub(crate) fn alone(function: impl Fn(&[f64; 1]) -> [f64; 1], x: f64) -> f64 {
    let [value] = function(&[x]);
    value
}

/// Whether all points are; without a way out, so that it is done in vectors.
#[inline(always)]
fn all<const L: usize>(x: &[f64; L], is: impl Fn(f64) -> bool) -> bool {
    x.iter().fold(true, |so_far, x| so_far & is(*x))
}

/// The function of each.
#[inline(always)]
fn each<const L: usize>(x: &[f64; L], function: impl Fn(f64) -> f64) -> [f64; L] {
    let mut values = [0.0; L];
    for (value, x) in values.iter_mut().zip(x) {
        *value = function(*x);
    }
    values
}

/// c₀ + c₁ x + …
#[inline(always)]
fn polynomial<const N: usize>(x: f64, coefficients: [f64; N]) -> f64 {
    let mut sum = 0.0;
    let mut first = true;
    for coefficient in coefficients.into_iter().rev() {
        sum = if first {
            coefficient
        } else {
            coefficient + x * sum
        };
        first = false;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    type Kernel = fn(&[f64; 4]) -> [f64; 4];
    /// Name, kernel, the platform's function, range of arguments.
    type Case = (&'static str, Kernel, fn(f64) -> f64, f64, f64);

    const ALL: [Case; 9] = [
        ("sine", sine, f64::sin, -0.8, 0.8),
        ("sine", sine, f64::sin, -800_000.0, 800_000.0),
        ("cosine", cosine, f64::cos, -0.8, 0.8),
        ("cosine", cosine, f64::cos, -800_000.0, 800_000.0),
        ("arc sine", arc_sine, f64::asin, -1.0, 1.0),
        ("arc tangent", arc_tangent, f64::atan, -3.0, 3.0),
        ("arc tangent", arc_tangent, f64::atan, -1e6, 1e6),
        ("exponential", exponential, f64::exp, -708.0, 708.0),
        ("logarithm", logarithm, f64::ln, 0.0, 8.0),
    ];

    fn alone(kernel: Kernel, x: f64) -> f64 {
        kernel(&[x; 4])[0]
    }

    /// Units in the last place between two numbers of the same sign.
    fn apart(a: f64, b: f64) -> u64 {
        if a == b || (a.is_nan() && b.is_nan()) {
            return 0;
        }
        a.to_bits().abs_diff(b.to_bits())
    }

    #[test]
    fn values_are_those_of_the_platform_to_a_unit_in_the_last_place() {
        for (name, kernel, platform, from, to) in ALL {
            let mut differ = 0;
            for index in 0..200_000_u32 {
                let fraction = (0.5 + f64::from(index) * 0.618_033_988_749_894_9).fract();
                // Dense about zero as well.
                let narrow = if index % 2 == 0 {
                    1.0
                } else {
                    fraction * fraction
                };
                let x = (from + (to - from) * fraction) * narrow;
                let (found, expected) = (alone(kernel, x), platform(x));
                // Both are within one unit of the truth, mostly at the same neighbour.
                let units = apart(found, expected);
                assert!(units <= 1, "{name}({x}): {found} {expected}, {units} units");
                differ += units;
            }
            assert!(differ < 40_000, "{name}: {differ} of 200000 differ");
        }
    }

    #[test]
    fn company_does_not_change_a_bit() {
        let others = [
            1e-9,
            0.3,
            -0.6,
            0.99,
            2.0,
            -17.0,
            1e5,
            1e9,
            f64::INFINITY,
            f64::NAN,
        ];
        for (name, kernel, ..) in ALL {
            for index in 0..2000_i32 {
                let x = f64::from(index - 1000) * 0.001_3;
                let expected = alone(kernel, x).to_bits();
                for other in others {
                    let [first, _, _, last] = kernel(&[x, other, -x, x]);
                    assert_eq!(
                        first.to_bits(),
                        last.to_bits(),
                        "{name}({x}) beside {other}"
                    );
                    assert!(
                        first.is_nan() || first.to_bits() == expected,
                        "{name}({x}) beside {other}"
                    );
                }
            }
        }
    }

    #[test]
    fn ends_of_the_range_are_those_of_the_platform() {
        let smallest = f64::from_bits(1);
        let ends = [
            0.0,
            -0.0,
            0.5,
            1.0,
            -1.0,
            smallest,
            -smallest,
            f64::MIN_POSITIVE,
            1e-200,
            f64::MAX,
            f64::MIN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::NAN,
            709.5,
            710.0,
            -709.0,
            -745.0,
            -746.0,
            1e6,
            1e22,
            -1e300,
            1.000_000_1,
            0.437_5,
            0.687_5,
            1.187_5,
            2.437_5,
        ];
        for (name, kernel, platform, ..) in ALL {
            for x in ends {
                let (found, expected) = (alone(kernel, x), platform(x));
                assert!(
                    apart(found, expected) <= 1,
                    "{name}({x}): {found} {expected}"
                );
                assert!(found.is_nan() || found.is_sign_negative() == expected.is_sign_negative());
            }
        }
    }

    /// The doubles next to multiples of π/2, where the reduction loses most; sin(x) = ±(x - n π), cos likewise.
    #[test]
    fn angles_next_to_multiples_of_a_right_angle_keep_their_digits() {
        for turns in 1..500_000_u32 {
            let x = f64::from(turns) * std::f64::consts::FRAC_PI_2;
            for (found, expected) in [(alone(sine, x), x.sin()), (alone(cosine, x), x.cos())] {
                assert!(apart(found, expected) <= 1, "{x}: {found} {expected}");
            }
        }
    }
}
