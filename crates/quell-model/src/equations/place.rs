//! Faults of expressions in equations.

use std::sync::Arc;

use quell_document::{Fault, Source};
use quell_expression::ExpressionError;

/// The fault of an expression, with a remedy where a unit has taken `t` for the tonne.
pub(super) fn fault(source: &Arc<Source>, error: ExpressionError) -> Fault {
    let text = source
        .text
        .get(error.span.start..error.span.end)
        .unwrap_or_default();
    let tonne = error.help.is_none() && has_tonne(text);
    let fault = Fault::from_expression(source, error);
    if tonne {
        return fault.help("directly after a unit `t` is the tonne: write `t*3 rad/s`, time first");
    }
    fault
}

/// Whether `t` is multiplied directly after a unit, as in `3 rad/s*t`.
fn has_tonne(text: &str) -> bool {
    let is_name = |character: char| character.is_alphanumeric() || character == '_';
    text.match_indices("*t").any(|(place, _)| {
        let after = text.get(place + 2..).unwrap_or_default();
        let before = text.get(..place).unwrap_or_default();
        // A unit: letters, `/`, `^` and digits back to the blank behind a number.
        let unit = before.trim_end_matches(|one: char| is_name(one) || "/^*".contains(one));
        let number = unit.strip_suffix(' ').unwrap_or_default();
        !after.starts_with(is_name) && number.ends_with(|one: char| one.is_ascii_digit())
    })
}

#[cfg(test)]
mod tests {
    use super::has_tonne;

    #[test]
    fn a_tonne_is_known_by_the_unit_before_it() {
        for (text, expected) in [
            ("3 rad/s*t", true),
            ("cos(2 rad/s*t + 1)", true),
            ("t*3 rad/s", false),
            ("3 rad/s*tau", false),
            ("omega*t", false),
            ("3*t", false),
        ] {
            assert_eq!(has_tonne(text), expected, "{text}");
        }
    }
}
