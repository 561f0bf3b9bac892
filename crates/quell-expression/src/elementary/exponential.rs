//! Exponential and natural logarithm.

use super::{ROUND, all, each, polynomial};

/// ln 2 in two parts, the first of 33 bits.
const LN_2: [f64; 2] = [
    6.931_471_803_691_238_164_90e-01,
    1.908_214_929_270_587_700_02e-10,
];

/// The exponential of each.
#[inline(always)]
pub(crate) fn exponential<const L: usize>(x: &[f64; L]) -> [f64; L] {
    /// Within it results are neither infinite nor subnormal.
    const LARGE: f64 = 708.0;
    if all(x, |x| x.abs() <= LARGE) {
        each(x, scaled)
    } else {
        each(x, |x| if x.abs() <= LARGE { scaled(x) } else { x.exp() })
    }
}

/// 2^k exp(r), x = k ln 2 + r.
#[inline(always)]
fn scaled(x: f64) -> f64 {
    let shifted = x * std::f64::consts::LOG2_E + ROUND;
    let k = shifted - ROUND;
    let (high, low) = (x - k * LN_2[0], k * LN_2[1]);
    let r = high - low;
    let t = r * r;
    let c = r - t * polynomial(
        t,
        [
            1.666_666_666_666_660_190_37e-01,
            -2.777_777_777_701_559_338_42e-03,
            6.613_756_321_437_934_361_17e-05,
            -1.653_390_220_546_525_153_90e-06,
            4.138_136_797_057_238_460_39e-08,
        ],
    );
    let value = 1.0 - ((low - (r * c) / (2.0 - c)) - high);
    let power = shifted.to_bits().wrapping_add(1023) << 52;
    value * f64::from_bits(power)
}

/// The natural logarithm of each.
#[inline(always)]
pub(crate) fn logarithm<const L: usize>(x: &[f64; L]) -> [f64; L] {
    let ordinary = |x: f64| (f64::MIN_POSITIVE..=f64::MAX).contains(&x);
    if all(x, ordinary) {
        each(x, split)
    } else {
        each(x, |x| if ordinary(x) { split(x) } else { x.ln() })
    }
}

/// k ln 2 + log(1 + f), x = 2^k (1 + f), √2/2 < 1 + f < √2.
#[inline(always)]
fn split(x: f64) -> f64 {
    /// The bits of √2/2, to 32.
    const ROOT: u64 = 0x3fe6_a09e_0000_0000;
    const ONE: u64 = 0x3ff0_0000_0000_0000;
    /// 2^52, whose lowest bits count ones.
    const WHOLE: u64 = 0x4330_0000_0000_0000;
    let bits = x.to_bits().wrapping_add(ONE - ROOT);
    let k = f64::from_bits(WHOLE | (bits >> 52)) - (4_503_599_627_370_496.0 + 1023.0);
    let f = f64::from_bits((bits & 0x000f_ffff_ffff_ffff).wrapping_add(ROOT)) - 1.0;
    let half = 0.5 * f * f;
    let s = f / (2.0 + f);
    let z = s * s;
    let w = z * z;
    let even = w * polynomial(
        w,
        [
            3.999_999_999_940_941_908e-01,
            2.222_219_843_214_978_396e-01,
            1.531_383_769_920_937_332e-01,
        ],
    );
    let odd = z * polynomial(
        w,
        [
            6.666_666_666_666_735_130e-01,
            2.857_142_874_366_239_149e-01,
            1.818_357_216_161_805_012e-01,
            1.479_819_860_511_658_591e-01,
        ],
    );
    s * (half + (even + odd)) + k * LN_2[1] - half + f + k * LN_2[0]
}
