//! Wrong host files written as equations, and the words they get.

use std::fmt::Write as _;
use std::sync::Arc;

use proptest::prelude::*;
use quell_document::Source;
use quell_model::HostFile;

/// What reading and lowering `text` says, or `fine`.
fn words(text: &str) -> String {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let source = Arc::new(Source::new("host.toml", text));
    match HostFile::parse(source, folder).and_then(|file| file.equations(&[])) {
        Ok(_) => "fine".to_owned(),
        Err(fault) => fault
            .render()
            .replace(env!("CARGO_MANIFEST_DIR"), "")
            .replace('\\', "/"),
    }
}

/// A sound host: each entry of `changes` replaces a section's text, or adds a section.
fn with(changes: &[(&str, &str)]) -> String {
    let mut sections = vec![
        (
            "parameters",
            "m = \"2 kg\"\nc = \"3 N*s/m\"\nk = \"5 N/m\"\nl = \"0.4 m\"\nJ = \"0.3 kg*m^2\"",
        ),
        ("coordinates", "x = {}\nphi = { kind = \"rotation\" }"),
        ("inputs", "F = { kind = \"force\" }"),
        ("definitions", "s = \"x + l*phi\""),
        ("functions", "\"spring(z)\" = \"k*z\""),
        (
            "equations",
            "x = \"m*x'' + c*x' + spring(s) = F\"\nphi = \"J*phi'' + l*spring(s) = 0\"",
        ),
    ];
    for (name, text) in changes {
        match sections.iter_mut().find(|(known, _)| known == name) {
            Some((_, own)) => *own = text,
            None => sections.push((name, text)),
        }
    }
    let mut file = "quell = 1\n".to_owned();
    for (name, text) in sections {
        if name == "dimensionless" {
            file = format!("quell = 1\ndimensionless = {text}\n{}", &file[10..]);
        } else {
            let _ = writeln!(file, "[{name}]\n{text}");
        }
    }
    file
}

const EQUATIONS: &str = "phi = \"J*phi'' + l*spring(s) = 0\"";

#[test]
fn the_sound_host_is_fine() {
    assert_eq!(words(&with(&[])), "fine");
}

#[test]
fn wrong_equations_get_useful_words() {
    let equation = |x: &str| with(&[("equations", &format!("x = \"{x}\"\n{EQUATIONS}"))]);
    let cases = [
        // Sections.
        (
            "nothing that moves",
            "quell = 1\n[coordinates]\nx = {}\n".to_owned(),
        ),
        ("linear and equations", with(&[("linear", "")])),
        (
            "definitions of a linear host",
            "quell = 1\n[coordinates]\nx = { mass = 1 }\n[linear]\n[definitions]\na = \"x\"\n"
                .to_owned(),
        ),
        ("unknown section", with(&[("equation", "x = \"x'' = 0\"")])),
        (
            "equations and Lagrangian",
            with(&[("lagrangian", "kinetic = \"1/2*m*x'^2\"")]),
        ),
        // Coordinates and equations.
        (
            "coordinate without equation",
            with(&[("equations", EQUATIONS)]),
        ),
        (
            "coordinates without equations",
            "quell = 1\n[coordinates]\nx = {}\n[states]\ns = \"x'\"\n".to_owned(),
        ),
        (
            "equation without coordinate",
            with(&[(
                "equations",
                &format!("x = \"m*x'' = F\"\n{EQUATIONS}\nphj = \"phi = 0\""),
            )]),
        ),
        (
            "equation of a state",
            with(&[
                ("states", "w = { rate = \"F\", unit = \"N*s\" }"),
                (
                    "equations",
                    &format!("x = \"m*x'' = F\"\n{EQUATIONS}\nw = \"w' = F\""),
                ),
            ]),
        ),
        (
            "two equations for one",
            with(&[(
                "equations",
                &format!("x = \"m*x'' = F\"\n{EQUATIONS}\nx = \"k*x = F\""),
            )]),
        ),
        (
            "equation that does not determine its unknown",
            equation("J*phi'' = 0"),
        ),
        (
            "equation without acceleration",
            equation("c*x' + spring(s) = F"),
        ),
        (
            "massless with acceleration",
            with(&[(
                "coordinates",
                "x = { massless = true }\nphi = { kind = \"rotation\" }",
            )]),
        ),
        (
            "acceleration of a massless coordinate elsewhere",
            with(&[
                (
                    "coordinates",
                    "x = { massless = true }\nphi = { kind = \"rotation\" }",
                ),
                (
                    "equations",
                    "x = \"c*x' + spring(s) = F\"\nphi = \"J*phi'' + l*m*x'' + l*spring(s) = 0\"",
                ),
            ]),
        ),
        (
            "inertia that vanishes",
            equation("(m - 2 kg)*x'' + c*x' = F"),
        ),
        ("equation with one side", equation("m*x'' + c*x'")),
        ("equation with three sides", equation("m*x'' = F = 0")),
        ("equation with a comparison", equation("m*x'' <= F")),
        (
            "equation that is no text",
            with(&[("equations", &format!("x = 3\n{EQUATIONS}"))]),
        ),
        // Names.
        ("unknown name", equation("m*x'' + c*x' + kk*x = F")),
        ("name of another case", equation("M*x'' = F")),
        ("unknown function", equation("m*x'' + sprng(s) = F")),
        ("function without arguments", equation("m*x'' + spring = F")),
        (
            "function with too many arguments",
            equation("m*x'' + spring(s, x) = F"),
        ),
        (
            "unknown name in a definition",
            with(&[("definitions", "s = \"x + l*phj\"")]),
        ),
        (
            "unknown name in a function",
            with(&[("functions", "\"spring(z)\" = \"k*zz\"")]),
        ),
        (
            "definitions in a circle",
            with(&[("definitions", "s = \"x + l*r\"\nr = \"s/l\"")]),
        ),
        (
            "function that calls itself",
            with(&[("functions", "\"spring(z)\" = \"k*z + spring(z)\"")]),
        ),
        (
            "definition with arguments",
            with(&[("definitions", "s = \"x\"\n\"r(z)\" = \"z\"")]),
        ),
        (
            "function with a broken head",
            with(&[("functions", "\"spring(z\" = \"k*z\"")]),
        ),
        (
            "a name twice",
            with(&[("definitions", "s = \"x\"\nk = \"x\"")]),
        ),
        (
            "name of time",
            with(&[("definitions", "s = \"x\"\nt = \"x\"")]),
        ),
        ("third derivative", equation("m*x''' = F")),
        (
            "derivative of a definition with accelerations",
            with(&[
                ("definitions", "s = \"x\"\nw = \"x''*phi\""),
                (
                    "equations",
                    &format!("x = \"m*x'' + J*w'/(1 m*s) = F\"\n{EQUATIONS}"),
                ),
            ]),
        ),
        (
            "partial derivative along a number",
            equation("m*x'' + d(spring(x), 2) = F"),
        ),
        // Units.
        ("sides of unlike unit", equation("m*x'' = x")),
        ("terms of unlike unit", equation("m*x'' + c*x = F")),
        ("sine of a length", equation("m*x'' + k*l*sin(x) = F")),
        (
            "branches of unlike unit",
            equation("m*x'' + (if x > 0 then k*x else c*x) = F"),
        ),
        (
            "condition of unlike unit",
            equation("m*x'' + (if x > 2 N then k*x else 0) = F"),
        ),
        ("power that varies", equation("m*x'' + k*l*(x^phi) = F")),
        (
            "start in another unit",
            with(&[(
                "coordinates",
                "x = { start = \"2 N\" }\nphi = { kind = \"rotation\" }",
            )]),
        ),
        (
            "start that moves",
            with(&[(
                "coordinates",
                "x = { start = \"l*phi\" }\nphi = { kind = \"rotation\" }",
            )]),
        ),
        (
            "mass of a coordinate",
            with(&[(
                "coordinates",
                "x = { mass = 2 }\nphi = { kind = \"rotation\" }",
            )]),
        ),
        (
            "kind of a coordinate",
            with(&[("coordinates", "x = {}\nphi = { kind = \"rotaton\" }")]),
        ),
        (
            "units in a dimensionless host",
            with(&[("dimensionless", "true")]),
        ),
        // States.
        (
            "state in another unit",
            with(&[("states", "w = { rate = \"F\", unit = \"N\" }")]),
        ),
        (
            "state whose unit nothing says",
            with(&[("states", "w = \"-w/(1 s)\"")]),
        ),
        (
            "state with an unknown name",
            with(&[("states", "w = \"-w/tau\"")]),
        ),
        (
            "states whose rates need each other",
            with(&[(
                "states",
                "v = { rate = \"w'\", unit = \"m\" }\nw = { rate = \"v'\", unit = \"m\" }",
            )]),
        ),
        (
            "unknown key of a state",
            with(&[("states", "w = { rat = \"F\" }")]),
        ),
        // Inputs.
        (
            "place of an input",
            with(&[("inputs", "F = { kind = \"force\", on = \"x\" }")]),
        ),
        (
            "unit of a force",
            with(&[("inputs", "F = { kind = \"force\", unit = \"N\" }")]),
        ),
        (
            "signal of two kinds",
            with(&[(
                "inputs",
                "F = { kind = \"force\", signal = { harmonic = {}, pulse = {} } }",
            )]),
        ),
        (
            "signal of an unknown kind",
            with(&[(
                "inputs",
                "F = { kind = \"force\", signal = { harmonc = {} } }",
            )]),
        ),
        (
            "amplitude in another unit",
            with(&[(
                "inputs",
                "F = { kind = \"force\", signal = { harmonic = { amplitude = \"2 m\", frequency = \"3 Hz\" } } }",
            )]),
        ),
        (
            "frequency without unit",
            with(&[(
                "inputs",
                "F = { kind = \"force\", signal = { harmonic = { amplitude = 2, frequency = 3 } } }",
            )]),
        ),
        (
            "sweep from zero",
            with(&[(
                "inputs",
                "F = { kind = \"force\", signal = { harmonic = { amplitude = 2, frequency = 0, sweep = { to = \"3 Hz\", time = 2, scale = \"log\" } } } }",
            )]),
        ),
        (
            "pulse of no duration",
            with(&[(
                "inputs",
                "F = { kind = \"force\", signal = { pulse = { amplitude = 2, duration = 0 } } }",
            )]),
        ),
        (
            "random without strength",
            with(&[(
                "inputs",
                "F = { kind = \"force\", signal = { random = { band = [\"1 Hz\", \"2 Hz\"] } } }",
            )]),
        ),
        (
            "density without unit",
            with(&[(
                "inputs",
                "F = { kind = \"force\", signal = { random = { band = [\"1 Hz\", \"2 Hz\"], spectrum = 3 } } }",
            )]),
        ),
        (
            "density in another unit",
            with(&[(
                "inputs",
                "F = { kind = \"force\", signal = { random = { band = [\"1 Hz\", \"2 Hz\"], spectrum = \"3 N^2\" } } }",
            )]),
        ),
        (
            "spectrum that is too narrow",
            with(&[(
                "inputs",
                "F = { kind = \"force\", signal = { random = { band = [\"1 Hz\", \"3 Hz\"], spectrum = [[\"1 Hz\", \"2 N^2/Hz\"], [\"2 Hz\", \"2 N^2/Hz\"]] } } }",
            )]),
        ),
        (
            "band that falls",
            with(&[(
                "inputs",
                "F = { kind = \"force\", signal = { random = { band = [\"3 Hz\", \"2 Hz\"], rms = 1 } } }",
            )]),
        ),
        (
            "missing file of samples",
            with(&[(
                "inputs",
                "F = { kind = \"force\", signal = { sampled = { file = \"no-such.csv\" } } }",
            )]),
        ),
        (
            "samples that go back in time",
            with(&[(
                "inputs",
                "F = { kind = \"force\", signal = { sampled = { file = \"fixtures/back-in-time.csv\" } } }",
            )]),
        ),
        (
            "unit of samples",
            with(&[(
                "inputs",
                "F = { kind = \"force\", signal = { sampled = { file = \"fixtures/road.csv\", unit = \"mm\" } } }",
            )]),
        ),
        // Ports.
        ("port with nothing", with(&[("ports.p", "")])),
        (
            "port with two ends too many",
            with(&[("ports.p", "between = [\"x\", \"ground\"]\nacross = \"x\"")]),
        ),
        (
            "port across a rate",
            with(&[("ports.p", "across = \"x'\"")]),
        ),
        (
            "port across a hidden rate",
            with(&[("ports.p", "across = \"x + l*tanh(phi'*(1 s))\"")]),
        ),
        (
            "port across nothing that moves",
            with(&[("ports.p", "across = \"l\"")]),
        ),
        (
            "port between unlike ends",
            with(&[("ports.p", "between = [\"x\", \"phi\"]")]),
        ),
        (
            "port in another unit",
            with(&[("ports.p", "across = \"k*x\"")]),
        ),
        (
            "force symbol that no equation has",
            with(&[("ports.p", "across = \"x\"\nforce = \"Fs\"")]),
        ),
        (
            "force symbol that is taken",
            with(&[("ports.p", "across = \"x\"\nforce = \"F\"")]),
        ),
        (
            "virtual work in an equation of accelerations",
            with(&[
                (
                    "equations",
                    &format!("x = \"x'' + c/m*x' = F/m\"\n{EQUATIONS}"),
                ),
                ("ports.p", "across = \"x\""),
            ]),
        ),
        (
            "force of no port",
            with(&[
                ("ports.strut", "across = \"x\""),
                ("outputs", "y = \"force(strt)\""),
            ]),
        ),
        (
            "rate of a device's force",
            with(&[
                ("ports.p", "across = \"x\""),
                ("outputs", "y = \"force(p)'\""),
            ]),
        ),
        // Outputs and ranges.
        (
            "unknown name in an output",
            with(&[("outputs", "y = \"x + lenght*phi\"")]),
        ),
        (
            "range of no parameter",
            with(&[("operating", "V = { above = 0, to = 2 }")]),
        ),
        (
            "range without beginning",
            with(&[("operating", "c = { to = 2 }")]),
        ),
        (
            "range with two beginnings",
            with(&[("operating", "c = { from = 0, above = 0, to = 2 }")]),
        ),
        (
            "range that falls",
            with(&[("operating", "c = { from = 3, to = 2 }")]),
        ),
        (
            "range in another unit",
            with(&[("operating", "c = { from = \"3 N\", to = 2 }")]),
        ),
    ];
    let lagrangian = |text: &str| {
        with(&[("equations", ""), ("lagrangian", text)]).replace("[equations]\n\n", "")
    };
    let energies = [
        (
            "Lagrangian without kinetic energy",
            lagrangian("potential = \"1/2*k*x^2\""),
        ),
        (
            "kinetic energy in another unit",
            lagrangian("kinetic = \"1/2*m*x'\""),
        ),
        (
            "potential that depends on rates",
            lagrangian("kinetic = \"1/2*m*x'^2 + 1/2*J*phi'^2\"\npotential = \"1/2*c*x*x'\""),
        ),
        (
            "kinetic energy of accelerations",
            lagrangian("kinetic = \"1/2*m*x''*x + 1/2*J*phi'^2\""),
        ),
        (
            "dissipation in another unit",
            lagrangian("kinetic = \"1/2*m*x'^2 + 1/2*J*phi'^2\"\ndissipation = \"1/2*c*x'\""),
        ),
        (
            "force on no coordinate",
            lagrangian("kinetic = \"1/2*m*x'^2 + 1/2*J*phi'^2\"\nforces = { y = \"F\" }"),
        ),
        (
            "force in another unit",
            lagrangian("kinetic = \"1/2*m*x'^2 + 1/2*J*phi'^2\"\nforces = { phi = \"F\" }"),
        ),
        (
            "coordinate without kinetic energy",
            lagrangian("kinetic = \"1/2*m*x'^2\"\npotential = \"1/2*k*s^2\""),
        ),
        (
            "unknown key of a Lagrangian",
            lagrangian("kinetc = \"1/2*m*x'^2\""),
        ),
        (
            "unknown name in an energy",
            lagrangian("kinetic = \"1/2*mm*x'^2\""),
        ),
    ];
    let mut report = String::new();
    for (what, text) in cases.into_iter().chain(energies) {
        let words = words(&text);
        assert_ne!(words, "fine", "{what}");
        let _ = writeln!(report, "# {what}\n{words}");
    }
    insta::assert_snapshot!(report);
}

/// Pieces of which random host files are put together.
const PIECES: &[&str] = &[
    "quell = 1\n",
    "dimensionless = true\n",
    "[parameters]\n",
    "[coordinates]\n",
    "[states]\n",
    "[inputs]\n",
    "[definitions]\n",
    "[functions]\n",
    "[equations]\n",
    "[lagrangian]\n",
    "[ports.p]\n",
    "[outputs]\n",
    "[operating]\n",
    "a = 2\n",
    "x = {}\n",
    "y = { massless = true, start = \"a\" }\n",
    "s = \"-s + x'\"\n",
    "u = { kind = \"number\", signal = { pulse = { amplitude = 1, duration = 1 } } }\n",
    "w = \"x*y' + u'\"\n",
    "\"f(z)\" = \"if z > 0 then z^a else f(z)\"\n",
    "x = \"x'' + f(x) + w' = u\"\n",
    "y = \"y' + y + s = Q\"\n",
    "kinetic = \"x'^2 + y'^2*w\"\n",
    "potential = \"abs(x)*y\"\n",
    "forces = { x = \"u + Q\" }\n",
    "across = \"x - y*hold(x)\"\n",
    "force = \"Q\"\n",
    "a = { above = 0, to = 3 }\n",
    "'\"[]{}=,\n",
];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn no_mixture_of_pieces_makes_the_reader_panic(pieces in prop::collection::vec(prop::sample::select(PIECES), 0..24)) {
        let _ = words(&format!("quell = 1\n{}", pieces.concat()));
    }

    #[test]
    fn no_change_to_a_sound_host_makes_the_reader_panic(
        place in 0_usize..700,
        length in 0_usize..12,
        text in "[ -~é\n]{0,8}",
    ) {
        let sound = with(&[("ports.p", "across = \"s\"\nforce = \"Q\""), ("states", "w = \"(x - w)/(1 s)\""), ("equations", "x = \"m*x'' + c*w' + Q + spring(s) = F\"\nphi = \"J*phi'' + l*spring(s)*cos(hold(phi)) = 0\"")]);
        let characters: Vec<char> = sound.chars().collect();
        let start = place.min(characters.len());
        let end = (start + length).min(characters.len());
        let changed: String = characters[..start].iter().copied().chain(text.chars()).chain(characters[end..].iter().copied()).collect();
        let _ = words(&changed);
    }
}
