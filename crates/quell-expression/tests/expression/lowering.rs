//! Expressions in a vocabulary: meanings, dimensions, time derivatives.

use quell_expression::{
    Dimension, Expression, ExpressionError, Graph, Lowering, Meaning, Names, Quantity, Rate,
    Signature, Slot, Unit, lower,
};

/// Coordinates x (m) and a (rad) with rates, states, parameters with values, definitions and functions.
#[derive(Default)]
struct Vocabulary {
    parameters: Vec<(&'static str, Quantity)>,
    definitions: Vec<(&'static str, Expression)>,
    functions: Vec<(Signature, Expression)>,
    dimensionless: bool,
    elsewhere: bool,
}

/// Inputs: t, x, x', x'', a, a', a'', then parameters.
const MOVING: usize = 7;

impl Vocabulary {
    fn new(parameters: &[(&'static str, &str)]) -> Self {
        let read = |text: &str| {
            Expression::parse(text)
                .unwrap()
                .evaluate(&quell_expression::NoNames)
        };
        Self {
            parameters: parameters
                .iter()
                .map(|(name, text)| (*name, read(text).unwrap()))
                .collect(),
            ..Self::default()
        }
    }

    fn define(mut self, name: &'static str, text: &str) -> Self {
        self.definitions
            .push((name, Expression::parse(text).unwrap()));
        self
    }

    fn function(mut self, head: &str, text: &str) -> Self {
        self.functions.push((
            Signature::parse(head).unwrap(),
            Expression::parse(text).unwrap(),
        ));
        self
    }

    fn value(&self, text: &str, moving: [f64; MOVING]) -> f64 {
        let mut graph = Graph::default();
        let expression = Expression::parse(text).unwrap();
        let (slot, _) =
            lower(&mut graph, &expression, self).unwrap_or_else(|error| panic!("{text}: {error}"));
        let parameters = self.parameters.iter().map(|(_, quantity)| quantity.value);
        let inputs: Vec<f64> = moving.into_iter().chain(parameters).collect();
        graph.values(&[slot], &inputs)[0]
    }

    fn dimension(&self, text: &str) -> Dimension {
        let expression = Expression::parse(text).unwrap();
        let lowered = lower(&mut Graph::default(), &expression, self);
        lowered.unwrap_or_else(|error| panic!("{text}: {error}")).1
    }

    fn error(&self, text: &str) -> (String, String, String) {
        let expression = Expression::parse(text).unwrap();
        let error = lower(&mut Graph::default(), &expression, self).unwrap_err();
        let place = text
            .get(error.span.start..error.span.end)
            .unwrap_or("?")
            .to_owned();
        (place, error.message, error.help.unwrap_or_default())
    }
}

impl Names for Vocabulary {
    fn resolve(&self, name: &str) -> Option<Meaning<'_>> {
        let moving = match name {
            "t" => Some(Meaning::Input(0, Dimension::TIME)),
            "x" => Some(Meaning::Input(1, Dimension::LENGTH)),
            "a" => Some(Meaning::Input(4, Dimension::ANGLE)),
            _ => None,
        };
        let parameter = || {
            let index = self
                .parameters
                .iter()
                .position(|(known, _)| *known == name)?;
            Some(Meaning::Input(
                MOVING + index,
                self.parameters[index].1.dimension,
            ))
        };
        let definition = || {
            let (_, definition) = self.definitions.iter().find(|(known, _)| *known == name)?;
            Some(Meaning::Definition(definition))
        };
        let function = || {
            let (head, body) = self.functions.iter().find(|(head, _)| head.name == name)?;
            Some(Meaning::Function(head, body))
        };
        moving
            .or_else(parameter)
            .or_else(definition)
            .or_else(function)
    }

    fn names(&self) -> Vec<&str> {
        let parameters = self.parameters.iter().map(|(name, _)| *name);
        let definitions = self.definitions.iter().map(|(name, _)| *name);
        let functions = self.functions.iter().map(|(head, _)| head.name.as_str());
        ["t", "x", "a"]
            .into_iter()
            .chain(parameters)
            .chain(definitions)
            .chain(functions)
            .collect()
    }

    fn rate(&self, input: usize) -> Rate {
        match input {
            0 => Rate::Constant(1.0),
            1 | 2 | 4 | 5 => Rate::Input(input + 1),
            3 => Rate::Unknown("the third derivative of `x`".to_owned()),
            6 => Rate::Unknown("the third derivative of `a`".to_owned()),
            _ => Rate::Constant(0.0),
        }
    }

    fn present(&self, input: usize) -> Option<f64> {
        Some(self.parameters.get(input.checked_sub(MOVING)?)?.1.value)
    }

    fn dimensionless(&self) -> bool {
        self.dimensionless
    }

    fn elsewhere(&self, _: &str) -> bool {
        self.elsewhere
    }

    fn call(
        &self,
        graph: &mut Graph,
        function: &str,
        arguments: &[Expression],
    ) -> Option<Result<(Slot, Dimension), ExpressionError>> {
        (function == "force").then(|| match arguments {
            [one] if one.to_string() == "strut" => Ok((graph.input(1), Dimension::FORCE)),
            _ => Err(ExpressionError::new(arguments[0].span, "no such part")),
        })
    }
}

const AT: [f64; MOVING] = [2.0, 0.3, -1.1, 0.7, 0.4, 1.3, -0.2];

/// The time derivative of a function of t, x and a and their rates by the chain rule, with central differences of
/// fourth order along the known motion.
fn differenced(vocabulary: &Vocabulary, text: &str) -> f64 {
    let [t, x, v, w, a, b, c] = AT;
    // A motion with these values and rates, of constant acceleration.
    let at = |s: f64| {
        let (x, v) = (x + v * s + w * s * s / 2.0, v + w * s);
        let (a, b) = (a + b * s + c * s * s / 2.0, b + c * s);
        vocabulary.value(text, [t + s, x, v, w, a, b, c])
    };
    let h = 1e-3;
    (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h)
}

#[test]
fn primes_differentiate_along_the_motion() {
    let vocabulary = Vocabulary::new(&[("m", "3 kg"), ("l", "0.5 m")])
        .define("y", "x + l*sin(a)")
        .function("arm(side, q)", "side*q*cos(a)*x + 0");
    for text in [
        "x",
        "x'",
        "y",
        "y'",
        "m*x*t",
        "x^2*sin(a)^3",
        "(x*a')",
        "arm(-1, x')",
        "abs(x)*a",
        "if x > 0 m then x*a else a*x^2/l",
        "max(x, l*a)",
        "m",
    ] {
        let derivative = vocabulary.value(&format!("({text})'"), AT);
        let expected = differenced(&vocabulary, text);
        // The truncation of the differences, h^4 times fifth derivatives of order 10.
        assert!(
            (derivative - expected).abs() < 1e-9 * (1.0 + expected.abs()),
            "{text}: {derivative} {expected}"
        );
    }
    assert_eq!(
        vocabulary.value("arm(1, l)''", AT),
        vocabulary.value("(arm(1, l)')'", AT)
    );
    assert_eq!(vocabulary.value("x''", AT), 0.7);
    assert_eq!(vocabulary.dimension("y''"), Dimension::ACCELERATION);
}

#[test]
fn held_parts_stand_still_under_primes() {
    let vocabulary = Vocabulary::new(&[]).function("z(k)", "hold(x^2)*k*x");
    let [_, x, v, w, ..] = AT;
    assert_eq!(vocabulary.value("z(2)'", AT), x * x * 2.0 * v);
    assert_eq!(vocabulary.value("z(2)''", AT), x * x * 2.0 * w);
    assert_eq!(vocabulary.value("d(z(2), x)", AT), x * x * 2.0);
    assert_eq!(vocabulary.value("hold(x)'", AT), 0.0);
}

#[test]
fn partial_derivatives_go_along_names() {
    let vocabulary = Vocabulary::new(&[("m", "2 kg")]).define("T", "1/2*m*x'^2*cos(a)");
    let [_, _, v, _, a, ..] = AT;
    let close = |text: &str, expected: f64| {
        let found = vocabulary.value(text, AT);
        assert!(
            (found - expected).abs() < 1e-14,
            "{text}: {found} {expected}"
        );
    };
    close("d(T, x')", 2.0 * v * a.cos());
    close("d(T, a)", -v * v * a.sin());
    close("d(T, m)", v * v * a.cos() / 2.0);
    close("d(T, x)", 0.0);
    assert_eq!(
        vocabulary.dimension("d(T, x')"),
        Dimension::new(1, 1, -1, 0)
    );
    assert_eq!(
        vocabulary.error("d(T, 2*x)").1,
        "`d` differentiates along a coordinate, a rate, a state or a parameter, and `2*x` is none"
    );
    assert_eq!(
        vocabulary.error("d(T)").1,
        "`d` takes two arguments, what is differentiated and along what, found 1"
    );
}

#[test]
fn dimensions_follow_the_rules_of_equations() {
    let vocabulary = Vocabulary::new(&[
        ("m", "3 kg"),
        ("k", "100 N/m"),
        ("kr", "50 N*m/rad"),
        ("l", "0.5 m"),
        ("n", "1.12"),
        ("two", "2"),
        ("v0", "0.001 m^3"),
        ("Aa", "0.005 m^2"),
        ("p", "1e5 Pa"),
    ]);
    for (text, dimension) in [
        ("m*x'' + k*x", Dimension::FORCE),
        ("m*l^2*a'' + kr*a + k*x*l", Dimension::MOMENT),
        ("x + l*a", Dimension::LENGTH),
        ("p*Aa*(v0/(v0 - Aa*x))^n", Dimension::FORCE),
        ("x^two", Dimension::AREA),
        ("x^(two + 1)", Dimension::new(0, 3, 0, 0)),
        ("(x/l)^(x/l)", Dimension::NONE),
        ("sqrt(k/m)*t", Dimension::NONE),
        ("sin(a) + sin(x/l)", Dimension::NONE),
        ("max(x, 0)", Dimension::LENGTH),
        ("if x > 0 then k*x else 0", Dimension::FORCE),
        ("0 - x", Dimension::LENGTH),
        ("abs(a')", Dimension::ANGULAR_FREQUENCY),
        ("atan(a)*exp(a)", Dimension::ANGLE),
        ("force(strut)", Dimension::FORCE),
    ] {
        let found = vocabulary.dimension(text);
        assert_eq!(
            found.without_angle(),
            dimension.without_angle(),
            "{text}: {found}"
        );
    }
    for (text, place, message) in [
        ("m*x'' + k*x'", "k*x'", "cannot add W/m to N"),
        ("x - m", "m", "cannot subtract kg from m"),
        (
            "if x > 3 then x else m",
            "3",
            "cannot compare m with a plain number",
        ),
        (
            "if x > 0 then x else m",
            "m",
            "one branch is kg, the other m",
        ),
        ("max(x, m)", "m", "`max` compares m with kg"),
        (
            "x^(x/l)",
            "(x/l)",
            "m cannot be raised to the power `x/l`, which varies",
        ),
        ("x^l", "l", "an exponent is a plain number, found m"),
        ("sin(x)", "x", "`sin` takes an angle, found m"),
        ("x/0", "0", "`0` is zero, and it divides"),
        (
            "x > 0 and a > 0",
            "x > 0 and a > 0",
            "`x > 0 and a > 0` is a condition, where a number is expected",
        ),
        (
            "if x then 1 else 2",
            "x",
            "`x` is a value, where a condition is expected",
        ),
        ("force(leg)", "leg", "no such part"),
    ] {
        let (found_place, found, _) = vocabulary.error(text);
        let message = message.replace(
            "W/m",
            &(Dimension::STIFFNESS * Dimension::VELOCITY).to_string(),
        );
        assert_eq!(
            (found.as_str(), found_place.as_str()),
            (message.as_str(), place),
            "{text}"
        );
    }
    let plain = Vocabulary {
        dimensionless: true,
        ..vocabulary
    };
    for text in [
        "x - m",
        "sin(x)",
        "x^l",
        "if x > 3 then x else m",
        "max(x, m) + 5 m",
    ] {
        assert_eq!(plain.dimension(text), Dimension::NONE);
    }
    assert!(Unit::parse("m").is_ok());
}

#[test]
fn what_is_wrong_is_said_in_words() {
    let vocabulary = Vocabulary::new(&[("mass", "3 kg")])
        .define("one", "two + 1")
        .define("two", "three*2")
        .define("three", "one - 1")
        .define("wrong", "x + mass")
        .function("F(s)", "s*G(s)")
        .function("G(s)", "F(s) + 1")
        .function("H(s)", "s + x");
    for (text, place, message, help) in [
        ("2*mas", "mas", "unknown name `mas`", "did you mean `mass`?"),
        (
            "2*sine(x)",
            "sine",
            "unknown function `sine`",
            "did you mean `sin`?",
        ),
        ("HH(x)", "HH", "unknown function `HH`", "did you mean `H`?"),
        (
            "mass(x)",
            "mass",
            "`mass` is no function",
            "a product is written `*`",
        ),
        (
            "x*H",
            "H",
            "`H` is a function, and has no value without arguments",
            "write `H(s)`",
        ),
        (
            "H(x, x)",
            "H(x, x)",
            "`H(s)` is called with 2 arguments",
            "",
        ),
        (
            "x'''",
            "x'''",
            "`x'''` needs the third derivative of `x`, which nothing here says",
            "",
        ),
    ] {
        let (found_place, found, found_help) = vocabulary.error(text);
        assert_eq!(
            (found_place.as_str(), found.as_str(), found_help.as_str()),
            (place, message, help),
            "{text}"
        );
    }
    let (_, message, help) = vocabulary.error("one");
    assert_eq!(
        (message.as_str(), help.as_str()),
        (
            "`one` is defined by itself",
            "it goes round: one → two → three → one"
        )
    );
    let (_, message, help) = vocabulary.error("F(2)");
    assert_eq!(
        (message.as_str(), help.as_str()),
        ("`F` calls itself", "it goes round: F → G → F")
    );
    // An error leaves the lowering usable.
    let mut graph = Graph::default();
    let mut lowering = Lowering::new(&vocabulary);
    let read = |text: &str| Expression::parse(text).unwrap();
    assert!(lowering.lower(&mut graph, &read("one")).is_err());
    assert!(lowering.lower(&mut graph, &read("H(x)")).is_ok());
    let far = Vocabulary {
        elsewhere: true,
        ..vocabulary
    };
    let (place, message, _) = far.error("2*x*wrong");
    assert_eq!(
        (place.as_str(), message.as_str()),
        ("wrong", "in `wrong`: cannot add kg to m")
    );
}

#[test]
fn deep_and_wide_definitions_need_neither_stack_nor_time() {
    // 2^40 expansions if calls were not remembered.
    let mut vocabulary = Vocabulary::new(&[]);
    vocabulary = vocabulary.function("f0(s)", "s + 1");
    let heads: Vec<String> = (0..40).map(|n| format!("f{n}")).collect();
    for pair in heads.windows(2) {
        vocabulary = vocabulary.function(
            &format!("{}(s)", pair[1]),
            &format!("{0}(s) + {0}(s)", pair[0]),
        );
    }
    assert_eq!(vocabulary.value("f39(1)", AT), 2.0 * 2_f64.powi(39));
    let names: Vec<&'static str> = (0..2000).map(|n| &*format!("d{n}").leak()).collect();
    let mut vocabulary = Vocabulary::new(&[]).define(names[0], "1");
    for pair in names.windows(2) {
        vocabulary = vocabulary.define(pair[1], &format!("(((({}))))*(-(-1))", pair[0]));
    }
    // Less than half the stack that a spawned thread has.
    let thread = std::thread::Builder::new()
        .stack_size(1 << 20)
        .spawn(move || {
            let message = vocabulary.error("d1999").1;
            assert_eq!(message, "definitions lead more than 400 deep here");
            assert_eq!(vocabulary.value("d300", AT), 1.0);
        });
    thread.unwrap().join().unwrap();
}
