//! Physical dimensions: exponents of kg, m, s, A, K and rad.

use std::fmt;
use std::ops::{Div, Mul};

/// Exponents are counted in twelfths, so that square, cube and fourth roots of whole powers stay exact.
const WHOLE: i32 = 12;

/// A physical dimension, as exponents of the SI base units kg, m, s, A, K and of rad.
///
/// rad is kept apart from the plain number so that a rotational stiffness is not taken for a translational one, and
/// Hz (2π rad/s) not for 1/s. It may be left out where it is expected, never added where it is not: see [`Self::accepts`].
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Dimension {
    twelfths: [i32; 6],
}

const NAMES: [&str; 6] = ["kg", "m", "s", "A", "K", "rad"];
const RAD: usize = 5;

impl Dimension {
    /// A plain number.
    pub const NONE: Self = Self::new(0, 0, 0, 0);
    /// kg.
    pub const MASS: Self = Self::new(1, 0, 0, 0);
    /// m.
    pub const LENGTH: Self = Self::new(0, 1, 0, 0);
    /// s.
    pub const TIME: Self = Self::new(0, 0, 1, 0);
    /// rad.
    pub const ANGLE: Self = Self::new(0, 0, 0, 1);
    /// A.
    pub const CURRENT: Self = Self {
        twelfths: [0, 0, 0, WHOLE, 0, 0],
    };
    /// K.
    pub const TEMPERATURE: Self = Self {
        twelfths: [0, 0, 0, 0, WHOLE, 0],
    };
    /// m/s.
    pub const VELOCITY: Self = Self::new(0, 1, -1, 0);
    /// m/s².
    pub const ACCELERATION: Self = Self::new(0, 1, -2, 0);
    /// m².
    pub const AREA: Self = Self::new(0, 2, 0, 0);
    /// N.
    pub const FORCE: Self = Self::new(1, 1, -2, 0);
    /// N m.
    pub const MOMENT: Self = Self::new(1, 2, -2, 0);
    /// J.
    pub const ENERGY: Self = Self::MOMENT;
    /// W.
    pub const POWER: Self = Self::new(1, 2, -3, 0);
    /// Pa.
    pub const PRESSURE: Self = Self::new(1, -1, -2, 0);
    /// rad/s, the dimension of every frequency.
    pub const ANGULAR_FREQUENCY: Self = Self::new(0, 0, -1, 1);
    /// rad/s².
    pub const ANGULAR_ACCELERATION: Self = Self::new(0, 0, -2, 1);
    /// N/m.
    pub const STIFFNESS: Self = Self::new(1, 0, -2, 0);
    /// N s/m.
    pub const DAMPING: Self = Self::new(1, 0, -1, 0);
    /// N m/rad.
    pub const ROTATIONAL_STIFFNESS: Self = Self::new(1, 2, -2, -1);
    /// N m s/rad.
    pub const ROTATIONAL_DAMPING: Self = Self::new(1, 2, -1, -1);
    /// kg m².
    pub const ROTATIONAL_INERTIA: Self = Self::new(1, 2, 0, 0);

    /// kg^mass m^length s^time rad^angle.
    #[must_use]
    pub const fn new(mass: i16, length: i16, time: i16, angle: i16) -> Self {
        Self {
            twelfths: [
                mass as i32 * WHOLE,
                length as i32 * WHOLE,
                time as i32 * WHOLE,
                0,
                0,
                angle as i32 * WHOLE,
            ],
        }
    }

    /// kg^mass m^length s^time A^current.
    #[must_use]
    pub const fn with_current(mass: i16, length: i16, time: i16, current: i16) -> Self {
        let mut dimension = Self::new(mass, length, time, 0);
        dimension.twelfths[3] = current as i32 * WHOLE;
        dimension
    }

    /// Whether it is a plain number, without even rad.
    #[must_use]
    pub fn is_none(self) -> bool {
        self == Self::NONE
    }

    /// The same dimension without rad.
    #[must_use]
    pub const fn without_angle(self) -> Self {
        let mut twelfths = self.twelfths;
        twelfths[RAD] = 0;
        Self { twelfths }
    }

    /// Whether a quantity of dimension `given` may stand where this dimension is expected.
    ///
    /// Everything must be equal, with two exceptions about rad:
    /// - `given` may leave it out (`N*m` passes for `N*m/rad`, a plain number for an angle), save that a frequency
    ///   insists on it, since 1/s may mean Hz or rad/s;
    /// - a product with an angle loses it (an arm times an angle, m rad, passes for m; moment times angle for energy).
    ///
    /// Not so the other way round: `N*m/rad` does not pass for `N*m`, nor an angle for a plain number, nor rad/s for
    /// 1/s.
    #[must_use]
    pub fn accepts(&self, given: &Self) -> bool {
        if self == given {
            return true;
        }
        let without = self.without_angle();
        if *self == Self::ANGULAR_FREQUENCY || without != given.without_angle() {
            return false;
        }
        let left_out = given.twelfths[RAD] == 0;
        let product_with_angle =
            self.twelfths[RAD] == 0 && given.twelfths[RAD] > 0 && !without.may_be_angular();
        left_out || product_with_angle
    }

    /// Whether it is 1, 1/s or 1/s², what is left of an angle, its rate and acceleration when rad is taken away.
    fn may_be_angular(self) -> bool {
        [Self::NONE, Self::new(0, 0, -1, 0), Self::new(0, 0, -2, 0)].contains(&self)
    }

    /// Whether quantities of both may be added or compared: equal but for rad that one of them leaves out.
    #[must_use]
    pub fn agrees(&self, other: &Self) -> bool {
        self == other
            || (self.without_angle() == other.without_angle()
                && (self.twelfths[RAD] == 0 || other.twelfths[RAD] == 0))
    }

    /// The dimension of a sum of both, which must [agree](Self::agrees).
    ///
    /// Where they are not the same, one has rad and the other does not. The sum keeps it (an angle, its rate or
    /// acceleration, `N*m/rad`), unless the rad comes from a product with an angle: m + m rad is m.
    #[must_use]
    pub fn joined(self, other: Self) -> Self {
        let (with, without) = if self.twelfths[RAD] == 0 {
            (other, self)
        } else {
            (self, other)
        };
        if with.twelfths[RAD] > 0 && !without.may_be_angular() {
            without
        } else {
            with
        }
    }

    /// The dimension of a power; none where an exponent would not be a multiple of 1/12, or beyond 1000.
    #[must_use]
    pub fn power(self, exponent: f64) -> Option<Self> {
        let mut twelfths = [0; 6];
        for (result, own) in twelfths.iter_mut().zip(self.twelfths) {
            let exact = f64::from(own) * exponent;
            let rounded = exact.round();
            // Written so that not-a-number is refused as well.
            let near = (exact - rounded).abs() <= 1e-9;
            if !near || rounded.abs() > 1000.0 * f64::from(WHOLE) {
                return None;
            }
            *result = rounded as i32;
        }
        Some(Self { twelfths })
    }

    /// The dimension of a square root; exact where every exponent is a multiple of 1/6, see [`Self::power`] otherwise.
    #[must_use]
    pub fn sqrt(self) -> Self {
        Self {
            twelfths: self.twelfths.map(|twelfths| twelfths / 2),
        }
    }

    /// SI unit as text: `N*s/m`, `N*m/rad`, `rad/s`, `kg/(s*m^4)`; empty for a plain number.
    ///
    /// The common mechanical units are named, others are written in base units; either way [`Unit::parse`](crate::Unit::parse)
    /// reads the text, and [`Expression::parse`](crate::Expression::parse) does after a number.
    #[must_use]
    pub fn unit_text(&self) -> String {
        for (dimension, text) in NAMED {
            if dimension == *self {
                return text.to_owned();
            }
        }
        let part = |sign: i32| -> Vec<String> {
            NAMES
                .iter()
                .zip(self.twelfths)
                .filter(|(_, twelfths)| twelfths.signum() == sign)
                .map(|(name, twelfths)| {
                    let power = twelfths.abs();
                    if power == WHOLE {
                        (*name).to_owned()
                    } else if power % WHOLE == 0 {
                        format!("{name}^{}", power / WHOLE)
                    } else {
                        format!("{name}^{}", f64::from(power) / f64::from(WHOLE))
                    }
                })
                .collect()
        };
        let (above, below) = (part(1), part(-1));
        let above = if above.is_empty() && !below.is_empty() {
            "1".to_owned()
        } else {
            above.join("*")
        };
        match below.as_slice() {
            [] => above,
            [one] => format!("{above}/{one}"),
            many => format!("{above}/({})", many.join("*")),
        }
    }
}

/// Units that are named rather than spelt in base units.
const NAMED: [(Dimension, &str); 15] = [
    (Dimension::FORCE, "N"),
    (Dimension::MOMENT, "N*m"),
    (Dimension::POWER, "W"),
    (Dimension::PRESSURE, "Pa"),
    (Dimension::STIFFNESS, "N/m"),
    (Dimension::DAMPING, "N*s/m"),
    (Dimension::ROTATIONAL_STIFFNESS, "N*m/rad"),
    (Dimension::ROTATIONAL_DAMPING, "N*m*s/rad"),
    (Dimension::ROTATIONAL_INERTIA, "kg*m^2"),
    (Dimension::ANGULAR_FREQUENCY, "rad/s"),
    (Dimension::ANGULAR_ACCELERATION, "rad/s^2"),
    (Dimension::new(-1, 4, 2, 0), "m^5/N"),
    (Dimension::new(1, -4, -1, 0), "kg/(s*m^4)"),
    (Dimension::new(1, -4, 0, 0), "kg/m^4"),
    (Dimension::new(-1, 0, 2, 0), "m/N"),
];

impl Mul for Dimension {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let mut twelfths = self.twelfths;
        for (own, other) in twelfths.iter_mut().zip(other.twelfths) {
            *own = own.saturating_add(other);
        }
        Self { twelfths }
    }
}

impl Div for Dimension {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let mut twelfths = self.twelfths;
        for (own, other) in twelfths.iter_mut().zip(other.twelfths) {
            *own = own.saturating_sub(other);
        }
        Self { twelfths }
    }
}

impl fmt::Display for Dimension {
    /// The unit, or `a plain number`.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = self.unit_text();
        formatter.write_str(if text.is_empty() {
            "a plain number"
        } else {
            &text
        })
    }
}

impl fmt::Debug for Dimension {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "Dimension({self})")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rad_may_be_left_out_but_not_added() {
        assert!(Dimension::ROTATIONAL_STIFFNESS.accepts(&Dimension::MOMENT));
        assert!(!Dimension::MOMENT.accepts(&Dimension::ROTATIONAL_STIFFNESS));
        assert!(!Dimension::ANGULAR_FREQUENCY.accepts(&Dimension::new(0, 0, -1, 0)));
        assert!(Dimension::ANGULAR_FREQUENCY.accepts(&Dimension::ANGULAR_FREQUENCY));
        assert!(Dimension::ANGLE.accepts(&Dimension::NONE));
        assert!(!Dimension::NONE.accepts(&Dimension::ANGLE));
        assert!(!Dimension::new(0, 0, -1, 0).accepts(&Dimension::ANGULAR_FREQUENCY));
        assert!(Dimension::LENGTH.accepts(&(Dimension::LENGTH * Dimension::ANGLE)));
        assert!(!Dimension::LENGTH.accepts(&(Dimension::LENGTH / Dimension::ANGLE)));
    }

    #[test]
    fn sums_keep_the_rad_of_angles_only() {
        let cases = [
            (Dimension::NONE, Dimension::ANGLE, Dimension::ANGLE),
            (
                Dimension::new(0, 0, -1, 0),
                Dimension::ANGULAR_FREQUENCY,
                Dimension::ANGULAR_FREQUENCY,
            ),
            (
                Dimension::LENGTH,
                Dimension::LENGTH * Dimension::ANGLE,
                Dimension::LENGTH,
            ),
            (
                Dimension::MOMENT,
                Dimension::ROTATIONAL_STIFFNESS,
                Dimension::ROTATIONAL_STIFFNESS,
            ),
        ];
        for (a, b, sum) in cases {
            assert!(a.agrees(&b) && b.agrees(&a));
            assert_eq!((a.joined(b), b.joined(a)), (sum, sum));
        }
        assert!(!Dimension::ANGLE.agrees(&(Dimension::ANGLE * Dimension::ANGLE)));
    }

    #[test]
    fn texts_are_units() {
        for dimension in [
            Dimension::DAMPING,
            Dimension::new(1, -4, -1, 0),
            Dimension::new(2, 3, -4, 1),
            Dimension::new(0, 0, -2, 0),
        ] {
            let unit = crate::Unit::parse(&dimension.unit_text()).unwrap();
            assert_eq!((unit.dimension, unit.factor), (dimension, 1.0));
            let text = format!("3 {}", dimension.unit_text());
            let quantity = crate::Expression::parse(&text)
                .and_then(|expression| expression.evaluate(&crate::NoNames))
                .unwrap();
            assert_eq!((quantity.dimension, quantity.value), (dimension, 3.0));
        }
        assert_eq!(Dimension::DAMPING.unit_text(), "N*s/m");
        assert_eq!(Dimension::NONE.unit_text(), "");
    }

    #[test]
    fn roots_are_exact() {
        let rate = Dimension::new(0, 0, -1, 0);
        assert_eq!(rate.sqrt() * rate.sqrt(), rate);
        assert_eq!(rate.power(0.5), Some(rate.sqrt()));
        assert_eq!(rate.power(0.123), None);
        assert_eq!(rate.power(f64::NAN), None);
        assert_eq!(rate.power(1001.0), None);
    }
}
