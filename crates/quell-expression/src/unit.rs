//! Units: names and prefixes, and the expressions of them such as `lbf*s/ft`.

use crate::{Dimension, ExpressionError, Span, nearest};

/// A unit: how many SI units it is, and its dimension.
#[derive(Debug, Clone, PartialEq)]
pub struct Unit {
    /// SI value of one of it.
    pub factor: f64,
    /// Its dimension.
    pub dimension: Dimension,
    /// As it was written.
    pub text: String,
}

impl Unit {
    /// Reads a unit such as `N*s/m`, `kg/(s*m^4)`, `lbf/ft` or `1/s`; `1` is that of plain numbers.
    ///
    /// # Errors
    /// Unknown names (with the nearest valid one) and syntax, at their place.
    pub fn parse(text: &str) -> Result<Self, ExpressionError> {
        crate::parser::parse_unit(text)
    }
}

struct Named {
    name: &'static str,
    factor: f64,
    dimension: Dimension,
    /// Takes the prefixes p n u µ m c d k M G.
    prefixed: bool,
}

const fn named(name: &'static str, factor: f64, dimension: Dimension, prefixed: bool) -> Named {
    Named {
        name,
        factor,
        dimension,
        prefixed,
    }
}

const POUND: f64 = 0.453_592_37;
const STANDARD_GRAVITY: f64 = 9.806_65;
const FOOT: f64 = 0.304_8;
/// lbf = lb · g0 (both exact by definition).
const POUND_FORCE: f64 = POUND * STANDARD_GRAVITY;
const VOLT: Dimension = volt();
const TURN: f64 = 2.0 * std::f64::consts::PI;

const fn electrical(kg: i16, m: i16, s: i16, amperes: i16) -> Dimension {
    Dimension::with_current(kg, m, s, amperes)
}

const fn volt() -> Dimension {
    electrical(1, 2, -3, -1)
}

/// Every unit by name. Sources: SI brochure (2019); international yard and pound agreement (1959).
const UNITS: &[Named] = &[
    named("m", 1.0, Dimension::LENGTH, true),
    named("g", 1e-3, Dimension::MASS, true),
    named("t", 1e3, Dimension::MASS, false),
    named("s", 1.0, Dimension::TIME, true),
    named("min", 60.0, Dimension::TIME, false),
    named("h", 3600.0, Dimension::TIME, false),
    named("A", 1.0, Dimension::CURRENT, true),
    named("K", 1.0, Dimension::TEMPERATURE, true),
    named("rad", 1.0, Dimension::ANGLE, true),
    named("deg", TURN / 360.0, Dimension::ANGLE, false),
    named("rev", TURN, Dimension::ANGLE, false),
    named("N", 1.0, Dimension::FORCE, true),
    named("Pa", 1.0, Dimension::PRESSURE, true),
    named("bar", 1e5, Dimension::PRESSURE, true),
    named("J", 1.0, Dimension::ENERGY, true),
    named("W", 1.0, Dimension::POWER, true),
    named("L", 1e-3, Dimension::new(0, 3, 0, 0), true),
    named("l", 1e-3, Dimension::new(0, 3, 0, 0), true),
    named("Hz", TURN, Dimension::ANGULAR_FREQUENCY, true),
    named("rpm", TURN / 60.0, Dimension::ANGULAR_FREQUENCY, false),
    named("V", 1.0, VOLT, true),
    named("ohm", 1.0, electrical(1, 2, -3, -2), true),
    named("Ω", 1.0, electrical(1, 2, -3, -2), true),
    named("H", 1.0, electrical(1, 2, -2, -2), true),
    named("F", 1.0, electrical(-1, -2, 4, 2), true),
    named("%", 1e-2, Dimension::NONE, false),
    named("lb", POUND, Dimension::MASS, false),
    named("lbf", POUND_FORCE, Dimension::FORCE, false),
    named("slug", POUND_FORCE / FOOT, Dimension::MASS, false),
    named("ft", FOOT, Dimension::LENGTH, false),
    named("in", 0.025_4, Dimension::LENGTH, false),
    named(
        "psi",
        POUND_FORCE / (0.025_4 * 0.025_4),
        Dimension::PRESSURE,
        false,
    ),
    named("mi", 1609.344, Dimension::LENGTH, false),
    named("mph", 0.447_04, Dimension::VELOCITY, false),
    named("kn", 1852.0 / 3600.0, Dimension::VELOCITY, false),
];

const PREFIXES: &[(&str, f64)] = &[
    ("p", 1e-12),
    ("n", 1e-9),
    ("u", 1e-6),
    ("µ", 1e-6),
    ("μ", 1e-6),
    ("m", 1e-3),
    ("c", 1e-2),
    ("d", 1e-1),
    ("k", 1e3),
    ("M", 1e6),
    ("G", 1e9),
];

/// Factor and dimension of a unit name, with or without prefix. An exact name wins: `min` is a minute, `cd`, `ft` no prefixes.
pub(crate) fn look_up(name: &str) -> Option<(f64, Dimension)> {
    if let Some(unit) = UNITS.iter().find(|unit| unit.name == name) {
        return Some((unit.factor, unit.dimension));
    }
    PREFIXES.iter().find_map(|(prefix, scale)| {
        let rest = name.strip_prefix(prefix)?;
        let unit = UNITS
            .iter()
            .find(|unit| unit.prefixed && unit.name == rest)?;
        // 1e-3 · 1e-3 is not 1e-6 to the last bit; the gram is the only unit where that shows.
        let factor = if *prefix == "k" && rest == "g" {
            1.0
        } else {
            scale * unit.factor
        };
        Some((factor, unit.dimension))
    })
}

/// The error for a name that is no unit.
pub(crate) fn unknown(name: &str, span: Span) -> ExpressionError {
    let error = ExpressionError::new(span, format!("`{name}` is not a unit"));
    let prefixed = UNITS
        .iter()
        .filter(|unit| unit.prefixed)
        .flat_map(|unit| ["k", "m", "M", "c"].map(|prefix| format!("{prefix}{}", unit.name)));
    let names: Vec<String> = UNITS
        .iter()
        .map(|unit| unit.name.to_owned())
        .chain(prefixed)
        .collect();
    match nearest(name, names.iter().map(String::as_str)) {
        Some(near) => error.with_help(format!("did you mean `{near}`?")),
        None => error
            .with_help("units are SI with prefixes, and lbf, lb, slug, ft, in, psi, deg, rpm, Hz"),
    }
}
