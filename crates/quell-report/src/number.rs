//! Numbers as an engineer reads them: significant digits, aligned decimals, powers of ten written out.

/// The digits shown where nothing else is asked for.
pub const SIGNIFICANT_DIGITS: usize = 5;

/// A number with its unit, kept on one line; a unit that is empty or 1 is left out.
pub fn with_unit(number: &str, shown: &str) -> String {
    match shown {
        "" | "1" => number.to_owned(),
        shown => format!("{number}\u{a0}{}", unit(shown)),
    }
}

/// What is smaller than this part of the largest number beside it is rounding.
const ROUNDING: f64 = 1e-9;

/// As [`significant`], in a column whose largest number is given: beside it, rounding is zero.
pub fn significant_beside(value: f64, largest: f64, digits: usize) -> String {
    if value.abs() <= ROUNDING * largest {
        "0".to_owned()
    } else {
        significant(value, digits)
    }
}

/// Writes `value` with `digits` significant digits, trailing zeros kept, as `0.5000`, `18.710`, `208333` or `2.5000×10⁻⁹`.
///
/// Plain decimals are used from 10⁻³ up to 10⁶, and a power of ten outside. Digits before the decimal point are
/// never rounded away, so `208333` keeps all six. What is not a number is shown as a dash.
pub fn significant(value: f64, digits: usize) -> String {
    let digits = digits.clamp(1, 17);
    if value.is_nan() {
        return "–".to_owned();
    }
    if value.is_infinite() {
        return if value > 0.0 { "∞" } else { "−∞" }.to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    // Rounding may carry into the next decade (9.99999 to 10.000), so the exponent is read after rounding.
    let scientific = format!("{value:.*e}", digits - 1);
    let Some((mantissa, exponent)) = scientific.split_once('e') else {
        return scientific;
    };
    let power: i32 = exponent.parse().unwrap_or(0);
    let text = if (-3..6).contains(&power) {
        let decimals = (i32::try_from(digits).unwrap_or(17) - 1 - power).max(0);
        format!("{value:.*}", usize::try_from(decimals).unwrap_or(0))
    } else {
        format!("{mantissa}×10{}", superscript(power))
    };
    text.replace('-', "−")
}

/// Writes `value` as [`significant`] does, without trailing zeros: for bounds and settings such as `0.5` or `1000`.
pub fn compact(value: f64, digits: usize) -> String {
    let text = significant(value, digits);
    let (mantissa, power) = match text.split_once('×') {
        Some((mantissa, power)) => (mantissa, Some(power)),
        None => (text.as_str(), None),
    };
    let mantissa = if mantissa.contains('.') {
        mantissa.trim_end_matches('0').trim_end_matches('.')
    } else {
        mantissa
    };
    match power {
        Some(power) if mantissa == "1" => power.to_owned(),
        Some(power) => format!("{mantissa}×{power}"),
        None => mantissa.to_owned(),
    }
}

/// Writes a relative change in per cent with one decimal, and a true minus sign.
pub fn percent(value: f64) -> String {
    if value.is_finite() {
        let text = format!("{value:.1} %");
        // What rounds to nothing has no sign.
        if text == "-0.0 %" {
            "0.0 %".to_owned()
        } else {
            text.replace('-', "−")
        }
    } else {
        "–".to_owned()
    }
}

fn superscript(power: i32) -> String {
    power
        .to_string()
        .chars()
        .map(|character| match character {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            '4' => '⁴',
            '5' => '⁵',
            '6' => '⁶',
            '7' => '⁷',
            '8' => '⁸',
            '9' => '⁹',
            _ => '⁰',
        })
        .collect()
}

/// Writes a unit for the eye: `N*s/m` becomes `N·s/m` and `m^2` becomes `m²`.
pub fn unit(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    let mut raised = false;
    for character in text.chars() {
        match character {
            '*' => {
                raised = false;
                shown.push('·');
            }
            '^' => raised = true,
            '-' if raised => shown.push('⁻'),
            digit if raised && digit.is_ascii_digit() => {
                shown.push_str(&superscript(i32::from(
                    u8::try_from(digit).unwrap_or(b'0') - b'0',
                )));
            }
            other => {
                raised = false;
                shown.push(other);
            }
        }
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn significant_digits_survive_every_decade() {
        assert_eq!(significant(3.634_9, 5), "3.6349");
        assert_eq!(significant(0.5, 4), "0.5000");
        assert_eq!(significant(9.999_996, 5), "10.000");
        assert_eq!(significant(208_333.3, 5), "208333");
        assert_eq!(significant(2.6e-9, 5), "2.6000×10⁻⁹");
        assert_eq!(significant(-1.5, 3), "−1.50");
        assert_eq!(significant(1.05e8, 3), "1.05×10⁸");
        assert_eq!(significant(0.0, 5), "0");
        assert_eq!(significant(f64::NAN, 5), "–");
        assert_eq!(significant(f64::NEG_INFINITY, 5), "−∞");
    }

    #[test]
    fn compact_drops_only_zeros_after_the_point() {
        assert_eq!(compact(0.5, 5), "0.5");
        assert_eq!(compact(1000.0, 5), "1000");
        assert_eq!(compact(1e-9, 5), "10⁻⁹");
        assert_eq!(compact(3.8e6, 5), "3.8×10⁶");
    }

    #[test]
    fn units_are_set_for_the_eye() {
        assert_eq!(unit("kg/(s*m^4)"), "kg/(s·m⁴)");
        assert_eq!(unit("m^-1"), "m⁻¹");
        assert_eq!(unit("s^12*m"), "s¹²·m");
    }

    #[test]
    fn percentages_have_one_decimal() {
        assert_eq!(percent(-3.25), "−3.2 %");
        assert_eq!(percent(-0.01), "0.0 %");
        assert_eq!(percent(f64::NAN), "–");
    }
}
