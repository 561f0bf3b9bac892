//! Sine and cosine.

use super::{ROUND, all, each};

/// Below it an angle needs no reduction: a little less than π/4.
const SMALL: f64 = 0.78;
/// Up to it the reduction by multiples of π/2 is exact.
const LARGE: f64 = 8e5;

/// The sine of each.
#[inline(always)]
pub(crate) fn sine<const L: usize>(x: &[f64; L]) -> [f64; L] {
    if all(x, |x| x.abs() <= SMALL) {
        each(x, |x| near_sine(x, 0.0))
    } else if all(x, |x| x.abs() <= LARGE) {
        each(x, |x| reduced(x, 0))
    } else {
        each(x, |x| {
            if x.abs() <= LARGE {
                reduced(x, 0)
            } else {
                x.sin()
            }
        })
    }
}

/// The cosine of each.
#[inline(always)]
pub(crate) fn cosine<const L: usize>(x: &[f64; L]) -> [f64; L] {
    if all(x, |x| x.abs() <= SMALL) {
        each(x, |x| near_cosine(x, 0.0))
    } else if all(x, |x| x.abs() <= LARGE) {
        each(x, |x| reduced(x, 1))
    } else {
        each(x, |x| {
            if x.abs() <= LARGE {
                reduced(x, 1)
            } else {
                x.cos()
            }
        })
    }
}

/// sin(x + y) for |x| ≤ π/4 and y its error.
#[inline(always)]
fn near_sine(x: f64, y: f64) -> f64 {
    let z = x * x;
    let w = z * z;
    // S₂ to S₆ of sin(x)/x = 1 + S₁ x² + …
    let tail = (8.333_333_333_322_489_461_24e-03 + z * -1.984_126_982_985_794_931_34e-04)
        + w * ((2.755_731_370_707_006_767_89e-06 + z * -2.505_076_025_340_686_341_95e-08)
            + w * 1.589_690_995_211_550_102_21e-10);
    let cubic = (z * x) * (-1.666_666_666_666_663_243_48e-01 + z * tail);
    // The sign is that of x, also of zero.
    (x + (cubic + (y - 0.5 * z * y))).copysign(x)
}

/// cos(x + y) for |x| ≤ π/4 and y its error.
#[inline(always)]
fn near_cosine(x: f64, y: f64) -> f64 {
    let z = x * x;
    let w = z * z;
    let low = 4.166_666_666_666_660_190_37e-02
        + z * (-1.388_888_888_887_410_957_49e-03 + z * 2.480_158_728_947_672_941_78e-05);
    let high = -2.755_731_435_139_066_330_35e-07
        + z * (2.087_572_321_298_174_827_90e-09 + z * -1.135_964_755_778_819_482_65e-11);
    let tail = z * low + (w * w) * high;
    let half = 0.5 * z;
    let head = 1.0 - half;
    head + (((1.0 - head) - half) + (z * tail - x * y))
}

/// sin(x + `quarters` π/2) for |x| ≤ [`LARGE`]: x less the nearest multiple of π/2, to 151 bits of π.
#[inline(always)]
fn reduced(x: f64, quarters: u64) -> f64 {
    /// π/2 in parts of 33 bits, whose products with whole numbers below 2^20 are exact, and the rest.
    const PARTS: [f64; 4] = [
        1.570_796_326_734_125_614_17,
        6.077_100_506_303_965_976_60e-11,
        2.022_266_248_711_166_455_80e-21,
        8.478_427_660_368_899_569_97e-32,
    ];
    let shifted = x * std::f64::consts::FRAC_2_PI + ROUND;
    let turns = shifted - ROUND;
    let quadrant = shifted.to_bits().wrapping_add(quarters);
    let first = x - turns * PARTS[0];
    let (second, error) = difference(first, turns * PARTS[1]);
    let (third, other) = difference(second, turns * PARTS[2]);
    let error = (error + other) - turns * PARTS[3];
    let r = third + error;
    let y = (third - r) + error;
    let (s, c) = (near_sine(r, y), near_cosine(r, y));
    let value = if quadrant & 1 == 0 { s } else { c };
    f64::from_bits(value.to_bits() ^ ((quadrant & 2) << 62))
}

/// a - b and what its rounding lost.
#[inline(always)]
fn difference(a: f64, b: f64) -> (f64, f64) {
    let s = a - b;
    let t = s - a;
    (s, (a - (s - t)) - (b + t))
}
