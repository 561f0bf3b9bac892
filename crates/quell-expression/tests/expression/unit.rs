//! Conversions against the definitions: SI brochure (2019), international yard and pound agreement (1959), ISO 31-1.

use std::f64::consts::PI;

use quell_expression::{Dimension, Unit};

use super::quantity;

/// Two roundings of a product of exact factors.
const ROUNDING: f64 = 2.0 * f64::EPSILON;

#[test]
fn agree_with_their_definitions() {
    let frequency = Dimension::ANGULAR_FREQUENCY;
    let volume = Dimension::new(0, 3, 0, 0);
    for (unit, factor, dimension) in [
        ("lbf", 4.448_221_615_260_5, Dimension::FORCE),
        ("lb", 0.453_592_37, Dimension::MASS),
        ("slug", 14.593_902_937_206_364, Dimension::MASS),
        ("lbf*s^2/ft", 14.593_902_937_206_364, Dimension::MASS),
        ("psi", 6_894.757_293_168_361, Dimension::PRESSURE),
        ("in", 0.025_4, Dimension::LENGTH),
        ("ft", 0.304_8, Dimension::LENGTH),
        ("ft^3", 0.028_316_846_592, volume),
        ("mi", 1_609.344, Dimension::LENGTH),
        ("mph", 0.447_04, Dimension::VELOCITY),
        ("kn", 1_852.0 / 3_600.0, Dimension::VELOCITY),
        ("km/h", 1.0 / 3.6, Dimension::VELOCITY),
        ("deg", PI / 180.0, Dimension::ANGLE),
        ("rev", 2.0 * PI, Dimension::ANGLE),
        ("rpm", PI / 30.0, frequency),
        ("Hz", 2.0 * PI, frequency),
        ("kHz", 2e3 * PI, frequency),
        ("rev/min", PI / 30.0, frequency),
        ("kN", 1e3, Dimension::FORCE),
        ("kN/mm", 1e6, Dimension::STIFFNESS),
        ("µm", 1e-6, Dimension::LENGTH),
        ("μm", 1e-6, Dimension::LENGTH),
        ("um", 1e-6, Dimension::LENGTH),
        ("mm", 1e-3, Dimension::LENGTH),
        ("cm^2", 1e-4, Dimension::AREA),
        ("dm^3", 1e-3, volume),
        ("L", 1e-3, volume),
        ("mL", 1e-6, volume),
        ("MPa", 1e6, Dimension::PRESSURE),
        ("N/mm^2", 1e6, Dimension::PRESSURE),
        ("GPa", 1e9, Dimension::PRESSURE),
        ("bar", 1e5, Dimension::PRESSURE),
        ("mbar", 1e2, Dimension::PRESSURE),
        ("kg", 1.0, Dimension::MASS),
        ("g", 1e-3, Dimension::MASS),
        ("mg", 1e-6, Dimension::MASS),
        ("Mg", 1e3, Dimension::MASS),
        ("t", 1e3, Dimension::MASS),
        ("min", 60.0, Dimension::TIME),
        ("h", 3_600.0, Dimension::TIME),
        ("ms", 1e-3, Dimension::TIME),
        ("kJ", 1e3, Dimension::ENERGY),
        ("W*s", 1.0, Dimension::ENERGY),
        ("V*A", 1.0, Dimension::POWER),
        ("V/A", 1.0, Dimension::with_current(1, 2, -3, -2)),
        ("kohm", 1e3, Dimension::with_current(1, 2, -3, -2)),
        ("Ω*s", 1.0, Dimension::with_current(1, 2, -2, -2)),
        ("µF", 1e-6, Dimension::with_current(-1, -2, 4, 2)),
        ("mH", 1e-3, Dimension::with_current(1, 2, -2, -2)),
        ("%", 1e-2, Dimension::NONE),
        ("1", 1.0, Dimension::NONE),
        ("1/s", 1.0, Dimension::new(0, 0, -1, 0)),
        ("kg/(s*m^4)", 1.0, Dimension::new(1, -4, -1, 0)),
        ("m^5/N", 1.0, Dimension::new(-1, 4, 2, 0)),
        ("m^-2", 1.0, Dimension::new(0, -2, 0, 0)),
        ("(m/s)^2", 1.0, Dimension::new(0, 2, -2, 0)),
        ("m / s / s", 1.0, Dimension::ACCELERATION),
    ] {
        let found = Unit::parse(unit).unwrap_or_else(|error| panic!("{unit}: {error}"));
        assert_eq!(found.dimension, dimension, "{unit}");
        let error = (found.factor / factor - 1.0).abs();
        assert!(
            error <= ROUNDING,
            "{unit}: {} is not {factor}",
            found.factor
        );
    }
}

#[test]
fn every_named_dimension_reads_its_own_unit() {
    for dimension in [
        Dimension::MASS,
        Dimension::LENGTH,
        Dimension::TIME,
        Dimension::CURRENT,
        Dimension::TEMPERATURE,
        Dimension::ANGLE,
        Dimension::VELOCITY,
        Dimension::ACCELERATION,
        Dimension::AREA,
        Dimension::FORCE,
        Dimension::MOMENT,
        Dimension::POWER,
        Dimension::PRESSURE,
        Dimension::ANGULAR_FREQUENCY,
        Dimension::ANGULAR_ACCELERATION,
        Dimension::STIFFNESS,
        Dimension::DAMPING,
        Dimension::ROTATIONAL_STIFFNESS,
        Dimension::ROTATIONAL_DAMPING,
        Dimension::ROTATIONAL_INERTIA,
        Dimension::TIME.power(-0.5).unwrap(),
        Dimension::new(-3, 2, -1, -2),
    ] {
        let text = dimension.unit_text();
        let unit = Unit::parse(&text).unwrap_or_else(|error| panic!("{text}: {error}"));
        assert_eq!((unit.dimension, unit.factor), (dimension, 1.0), "{text}");
        let quantity = quantity(&format!("2 {text}"));
        assert_eq!(
            (quantity.dimension, quantity.value),
            (dimension, 2.0),
            "{text}"
        );
    }
}

#[test]
fn what_is_no_unit_is_refused_at_its_place() {
    for (text, start, end, message, help) in [
        ("Nm", 0, 2, "`Nm` is not a unit", Some("did you mean `m`?")),
        ("N*metre", 2, 7, "`metre` is not a unit", None),
        ("kn/", 3, 3, "expected a unit, found the end", None),
        ("", 0, 0, "expected a unit, found the end", None),
        (
            "m^x",
            2,
            3,
            "the power of a unit is a number, such as `m^2`",
            None,
        ),
        (
            "m^2^3",
            2,
            3,
            "the power of a unit is a number, such as `m^2`",
            None,
        ),
        (
            "m^0.3",
            2,
            5,
            "a unit cannot be raised to the power 0.3",
            None,
        ),
        (
            "(N*m",
            4,
            4,
            "expected `)` after the unit, found the end",
            None,
        ),
        (
            "1 m",
            2,
            3,
            "expected `/` and a unit after `1`, found `m`",
            None,
        ),
        (
            "m s",
            2,
            3,
            "expected `*`, `/` or the end of the unit, found `s`",
            None,
        ),
        (
            "Gm^100",
            0,
            6,
            "this unit is too large or too small for a number",
            None,
        ),
    ] {
        let error = Unit::parse(text).unwrap_err();
        assert_eq!(error.message, message, "{text}");
        assert_eq!((error.span.start, error.span.end), (start, end), "{text}");
        if help.is_some() {
            assert_eq!(error.help.as_deref(), help, "{text}");
        }
    }
}
