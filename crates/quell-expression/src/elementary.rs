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
        sum = if first { coefficient } else { coefficient + x * sum };
        first = false;
    }
    sum
}
