//! `quell synthesise`.

use crate::{errors, output, quell};

/// Y = (3s² + 3s + 2)/(3s + 1) is that of `b1 | c1 + (k1 | c2)` with 1 kg, 2 N s/m, 1 N/m and 1 N s/m (by hand).
#[test]
fn a_function_becomes_networks_with_values() {
    let found = quell()
        .args(["synthesise", "(3 s^2 + 3*s + 2)/(3 s + 1)"])
        .assert()
        .success();
    let text = output(&found).replace('\u{a0}', " ");
    assert!(text.contains("positive-real; least real part"), "{text}");
    assert!(text.contains("b1 | c1 + (k1 | c2)"), "{text}");
    let values = "b1 = 1 kg, c1 = 2 N·s/m, k1 = 1 N/m, c2 = 1 N·s/m";
    assert!(text.contains(values), "{text}");
    // The impedance of the same network.
    let reciprocal = quell()
        .args(["synthesize", "--impedance", "(3 s + 1)/(3 s^2 + 3 s + 2)"])
        .assert()
        .success();
    assert_eq!(output(&found), output(&reciprocal));
}

/// (s² + s + 1)/(s² + s + 4) is Brune's kind of function: one spring, one damper, one inerter and a lever, or a bridge of five.
#[test]
fn a_minimum_function_has_a_bridge_and_a_lever() {
    let found = quell()
        .args(["synthesise", "(s^2 + s + 1)/(s^2 + s + 4)"])
        .assert()
        .success();
    let text = output(&found);
    assert!(
        text.contains("bridge[c1: 0-2, b1: 0-3, b2: 2-1, c2: 3-1, k1: 2-3]"),
        "{text}"
    );
    assert!(text.contains("1k 1c 1b and 1 lever"), "{text}");
    // Not to be had from fewer elements than were allowed.
    let fewer = quell()
        .args(["synthesise", "--most", "4", "(s^2 + s + 1)/(s^2 + s + 4)"])
        .assert()
        .success();
    assert!(output(&fewer).contains("no network of at most 4 elements"));
}

/// Re Y of (s² + s/10 + 1)/(s² + s + 4) on the axis is (x² - 4.9 x + 4)/((4 - x)² + x), x = ω²: negative between
/// x = 1.0349 and 3.8651, that is ω = 1.0173 and 1.9660.
#[test]
fn what_is_not_passive_is_said_with_the_nearest_that_is() {
    let function = "(s^2 + 0.1*s + 1)/(s^2 + s + 4)";
    let found = quell().args(["synthesise", function]).assert().success();
    let text = output(&found);
    assert!(text.contains("negative between 1.0173"), "{text}");
    assert!(text.contains("and 1.9659"), "{text}");
    assert!(text.contains("--nearest"), "{text}");
    let nearest = quell()
        .args(["synthesise", function, "--nearest"])
        .assert()
        .success();
    let text = output(&nearest);
    assert!(text.contains("at most 4.436504e-1 from it"), "{text}");
    assert!(text.contains("Bott-Duffin"), "{text}");
}

#[test]
fn wrong_functions_get_useful_words() {
    let words = |function: &str| {
        let refused = quell().args(["synthesise", function]).assert().code(1);
        errors(&refused)
    };
    let unknown = words("(s^2 + x + 1)/(s^2 + s + 4)");
    assert!(unknown.contains("`x` has no value here\n"), "{unknown}");
    assert!(unknown.contains("\n         ^\n"), "{unknown}");
    assert!(words("3 kg").contains("leave the unit out"));
    assert!(words("s^0.5").contains("whole number"));
    assert!(words("1/(s - s)").contains("this is zero"));
    assert!(words("0*s").contains("nothing to build"));
    assert!(words("sin(s)").contains("no rational function"));
    assert!(words("(s + 1").contains("not closed"));
}
