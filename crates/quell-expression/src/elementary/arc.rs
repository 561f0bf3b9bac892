//! Arc sine and arc tangent.

use super::{all, each, polynomial};

/// The high and the low part of π/2.
const HALF_PI: [f64; 2] = [
    std::f64::consts::FRAC_PI_2,
    6.123_233_995_736_766_035_87e-17,
];

/// The arc tangent of each.
#[inline(always)]
pub(crate) fn arc_tangent<const L: usize>(x: &[f64; L]) -> [f64; L] {
    if all(x, |x| x.abs() < 0.4375) {
        each(x, |x| near(x.abs(), 0.0, 0.0).copysign(x))
    } else {
        each(x, far)
    }
}

/// atan(x) = atan(c) + atan((x - c)/(1 + c x)), c one of 0, 1/2, 1, 3/2, ∞.
#[inline(always)]
fn far(x: f64) -> f64 {
    let a = x.abs();
    let (above, below) = (-1.0, a);
    let [high, low] = HALF_PI;
    let mut choice = [above, below, high, low];
    let mut nearer = |bound: f64, other: [f64; 4]| {
        let holds = a < bound;
        for (choice, other) in choice.iter_mut().zip(other) {
            *choice = if holds { other } else { *choice };
        }
    };
    nearer(
        2.4375,
        [
            a - 1.5,
            1.0 + 1.5 * a,
            9.827_937_232_473_290_540_82e-01,
            1.390_331_103_123_099_845_16e-17,
        ],
    );
    nearer(
        1.1875,
        [
            a - 1.0,
            a + 1.0,
            std::f64::consts::FRAC_PI_4,
            3.061_616_997_868_383_017_93e-17,
        ],
    );
    nearer(
        0.6875,
        [
            2.0 * a - 1.0,
            2.0 + a,
            4.636_476_090_008_060_935_15e-01,
            2.269_877_745_296_168_709_24e-17,
        ],
    );
    nearer(0.4375, [a, 1.0, 0.0, 0.0]);
    let [above, below, high, low] = choice;
    near(above / below, high, low).copysign(x)
}

/// high + low + atan(x) for |x| ≤ 7/16.
#[inline(always)]
fn near(x: f64, high: f64, low: f64) -> f64 {
    let z = x * x;
    let w = z * z;
    let even = polynomial(
        w,
        [
            3.333_333_333_333_293_180_27e-01,
            1.428_571_427_250_346_637_11e-01,
            9.090_887_133_436_506_561_96e-02,
            6.661_073_137_387_531_206_69e-02,
            4.976_877_994_615_932_360_17e-02,
            1.628_582_011_536_578_236_23e-02,
        ],
    );
    let odd = polynomial(
        w,
        [
            -1.999_999_999_987_648_324_76e-01,
            -1.111_111_040_546_235_578_80e-01,
            -7.691_876_205_044_829_994_95e-02,
            -5.833_570_133_790_573_486_45e-02,
            -3.653_157_274_421_691_552_70e-02,
        ],
    );
    high - ((x * (z * even + w * odd) - low) - x)
}

/// The arc sine of each.
#[inline(always)]
pub(crate) fn arc_sine<const L: usize>(x: &[f64; L]) -> [f64; L] {
    if all(x, |x| x.abs() < 0.5) {
        each(x, |x| (x + x * ratio(x * x)).copysign(x))
    } else {
        each(x, beyond)
    }
}

/// asin(x) = π/2 - 2 asin(√((1 - x)/2)) for x ≥ 1/2.
#[inline(always)]
fn beyond(x: f64) -> f64 {
    let a = x.abs();
    let inner = a < 0.5;
    let z = if inner { a * a } else { (1.0 - a) * 0.5 };
    let r = ratio(z);
    let near = a + a * r;
    // The root in two parts, of which the high one has an exact square.
    let s = z.sqrt();
    let high = f64::from_bits(s.to_bits() & 0xffff_ffff_0000_0000);
    let low = (z - high * high) / (s + high).max(f64::MIN_POSITIVE);
    let p = 2.0 * s * r - (HALF_PI[1] - 2.0 * low);
    let quarter = std::f64::consts::FRAC_PI_4;
    let far = quarter - (p - (quarter - 2.0 * high));
    (if inner { near } else { far }).copysign(x)
}

/// (asin(x) - x)/x over z = x² ≤ 1/4.
#[inline(always)]
fn ratio(z: f64) -> f64 {
    let above = polynomial(
        z,
        [
            1.666_666_666_666_666_574_15e-01,
            -3.255_658_186_224_009_154_05e-01,
            2.012_125_321_348_629_258_81e-01,
            -4.005_553_450_067_941_140_27e-02,
            7.915_349_942_898_145_321_76e-04,
            3.479_331_075_960_211_675_70e-05,
        ],
    );
    let below = polynomial(
        z,
        [
            1.0,
            -2.403_394_911_734_414_218_78,
            2.020_945_760_233_505_694_71,
            -6.882_839_716_054_532_930_30e-01,
            7.703_815_055_590_193_527_91e-02,
        ],
    );
    z * above / below
}
