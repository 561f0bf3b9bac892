//! Wrong host files and the words they get.

mod common;

use std::fmt::Write as _;
use std::sync::Arc;

use proptest::prelude::*;
use quell_document::Source;
use quell_model::HostFile;

/// What reading and building `text` says, or `fine`.
fn words(text: &str) -> String {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let source = Arc::new(Source::new("host.toml", text));
    match HostFile::parse(source, folder).and_then(|file| file.build(&[])) {
        Ok(_) => "fine".to_owned(),
        Err(fault) => fault.render(),
    }
}

/// A sound host whose section `[linear]` and what follows are given.
fn with_linear(rest: &str) -> String {
    format!(
        "quell = 1\n[parameters]\nk = \"5 N/m\"\n[coordinates]\nx1 = {{ mass = \"2 kg\" }}\nx2 = {{ mass = \"1 kg\" }}\nphi = {{ kind = \"rotation\", inertia = \"1 kg*m^2\" }}\n[inputs]\nxs = {{ kind = \"displacement\" }}\nF = {{ kind = \"force\", on = \"x1\" }}\n[linear]\n{rest}\n"
    )
}

#[test]
fn wrong_host_files_get_useful_words() {
    let whole = [
        ("not TOML", "quell = 1\n[coordinates\n".to_owned()),
        ("no version", "[coordinates]\nx = {}\n[linear]\n".to_owned()),
        ("a later version", "quell = 2\n[coordinates]\nx = {}\n[linear]\n".to_owned()),
        ("unknown section", "quell = 1\n[coordinates]\nx = {}\n[liner]\n".to_owned()),
        ("no coordinate", "quell = 1\n[coordinates]\n[linear]\n".to_owned()),
        ("section that is no table", "quell = 1\nlinear = 3\n[coordinates]\nx = {}\n".to_owned()),
        ("cycle", "quell = 1\n[parameters]\na = \"2*b\"\nb = \"c + 1\"\nc = \"a\"\n[coordinates]\nx = {}\n[linear]\n".to_owned()),
        ("name of a function", "quell = 1\n[parameters]\nmax = 3\n[coordinates]\nx = {}\n[linear]\n".to_owned()),
        ("name unfit for expressions", "quell = 1\n[coordinates]\n\"x 1\" = {}\n[linear]\n".to_owned()),
        ("a name twice", "quell = 1\n[parameters]\nx = 3\n[coordinates]\nx = {}\n[linear]\n".to_owned()),
        ("unknown parameter", "quell = 1\n[parameters]\nkr = \"1 N/m\"\nks = \"2*kz\"\n[coordinates]\nx = {}\n[linear]\n".to_owned()),
        ("sum of unlike units", "quell = 1\n[parameters]\na = \"1 N/m + 2 kg\"\n[coordinates]\nx = {}\n[linear]\n".to_owned()),
        ("mass in the wrong unit", "quell = 1\n[coordinates]\nx = { mass = \"2 N\" }\n[linear]\n".to_owned()),
        ("mass of a rotation", "quell = 1\n[coordinates]\nx = { kind = \"rotation\", mass = \"2 kg\" }\n[linear]\n".to_owned()),
        ("negative mass", "quell = 1\n[coordinates]\nx = { mass = -2 }\n[linear]\n".to_owned()),
        ("unknown key of a coordinate", "quell = 1\n[coordinates]\nx = { mas = 2 }\n[linear]\n".to_owned()),
        ("force on nothing", "quell = 1\n[coordinates]\nx = {}\n[inputs]\nF = { kind = \"force\" }\n[linear]\n".to_owned()),
        ("kind of input", "quell = 1\n[coordinates]\nx = {}\n[inputs]\nF = { kind = \"fource\", on = \"x\" }\n[linear]\n".to_owned()),
        ("force on an angle", "quell = 1\n[coordinates]\nx = { kind = \"rotation\" }\n[inputs]\nF = { kind = \"force\", on = \"x\" }\n[linear]\n".to_owned()),
    ];
    let linear = [
        ("unknown end point", r#"springs = [["x1", "x3", "k"]]"#),
        ("two entries", r#"springs = [["x1", "x2"]]"#),
        ("negative stiffness", r#"springs = [["x1", "x2", "-k"]]"#),
        (
            "stiffness in the wrong unit",
            r#"springs = [["x1", "x2", "5 kg"]]"#,
        ),
        ("displacement to angle", r#"springs = [["x1", "phi", "k"]]"#),
        (
            "translational stiffness between angles",
            r#"springs = [["phi", "ground", "k"]]"#,
        ),
        ("ground to ground", r#"dampers = [["ground", "ground", 1]]"#),
        ("an element on itself", r#"dampers = [["x1", "x1", 1]]"#),
        ("end on a force", r#"springs = [["x1", "F", "k"]]"#),
        ("end on a velocity", r#"springs = [["x1", "x2'", "k"]]"#),
        (
            "end point that is no sum",
            r#"springs = [["x1*x2", "ground", "k"]]"#,
        ),
        (
            "loss to a prescribed motion",
            r#"springs = [{ between = ["x1", "xs"], value = "k", loss = 0.1 }]"#,
        ),
        (
            "unknown key of a spring",
            r#"springs = [{ betwen = ["x1", "xs"], value = "k" }]"#,
        ),
        ("not square", "matrices = { K = [[1, 2, 3], [4, 5, 6]] }"),
        ("ragged", "matrices = { K = [[1, 2, 3], [4, 5]] }"),
        ("another size", "matrices = { K = [[1, 2], [4, 5]] }"),
        (
            "matrix with a wrong unit",
            r#"matrices = { K = [["1 kg", 0, 0], [0, 0, 0], [0, 0, 0]] }"#,
        ),
        (
            "mass that is not symmetric",
            "matrices = { M = [[1, 2, 0], [0, 1, 0], [0, 0, 1]] }",
        ),
        (
            "mass with a negative eigenvalue",
            "matrices = { M = [[1, 9, 0], [9, 1, 0], [0, 0, 1]] }",
        ),
        (
            "missing file",
            r#"matrices = { K = "matrices/missing.mtx" }"#,
        ),
        (
            "complex file",
            r#"matrices = { K = "matrices/complex.mtx" }"#,
        ),
        (
            "file that is not square",
            r#"matrices = { K = "matrices/wide_array.mtx" }"#,
        ),
        (
            "influence of another length",
            r#"base = { influence = [1, 1], input = "xs" }"#,
        ),
        (
            "base moved by a force",
            r#"base = { influence = [1, 1, 0], input = "F" }"#,
        ),
        ("unknown support", r#"supports = ["x3"]"#),
        ("all supported", r#"supports = ["x1", "x2", "phi"]"#),
        (
            "number of ratios",
            "springs = [[\"x1\", \"x2\", \"k\"]]\ndamping = { modal = [0.1, 0.2] }",
        ),
        (
            "two kinds of damping",
            "damping = { modal = 0.1, loss = 0.1 }",
        ),
        ("negative ratio", "damping = { modal = -0.1 }"),
        ("port with nothing", "[ports.p]"),
        (
            "port with unknown key",
            "[ports.p]\nbetwixt = [\"x1\", \"x2\"]",
        ),
        (
            "port across unlike motions",
            "[ports.p]\nacross = \"x1 - phi\"",
        ),
        ("port across a velocity", "[ports.p]\nacross = \"x1'\""),
        ("port in another unit", "[ports.p]\nacross = \"k*x1\""),
        ("port on an input alone", "[ports.p]\nacross = \"xs\""),
        ("output that is unknown", "[outputs]\ny = \"x1 - xq\""),
        ("output that is not linear", "[outputs]\ny = \"2*x1*x2\""),
        ("output of unlike terms", "[outputs]\ny = \"x1 + x2'\""),
        ("output by a function", "[outputs]\ny = \"max(x1, x2)\""),
        (
            "outputs in a circle",
            "[outputs]\ny = \"x1 + z\"\nz = \"2*y\"",
        ),
        ("force of nothing", "[outputs]\ny = \"force(mount)\""),
        ("syntax of an output", "[outputs]\ny = \"x1 - (x2\""),
    ];
    let mut report = String::new();
    for (what, text) in whole
        .into_iter()
        .chain(linear.map(|(what, rest)| (what, with_linear(rest))))
    {
        let words = words(&text);
        assert_ne!(words, "fine", "{what}");
        let _ = writeln!(report, "# {what}\n{words}");
    }
    insta::assert_snapshot!(report);
}

#[test]
fn modal_damping_needs_mass_everywhere() {
    let words = words(
        "quell = 1\n[coordinates]\nx = {}\n[linear]\nsprings = [[\"x\", \"ground\", 1]]\ndamping = { modal = 0.1 }\n",
    );
    assert!(words.contains("the mass matrix is singular"), "{words}");
}

#[test]
fn numbers_too_large_are_refused() {
    let words = words(&with_linear(
        "springs = [[\"x1\", \"x2\", 1e308], [\"x1\", \"x2\", 1e308]]",
    ));
    assert!(words.contains("too large"), "{words}");
}

#[test]
fn a_long_chain_of_parameters_is_no_trouble() {
    let mut text = "quell = 1\n[coordinates]\nx = {}\n[linear]\n[parameters]\n".to_owned();
    for index in 0..3000 {
        let _ = writeln!(text, "p{index} = \"p{} + 1\"", index + 1);
    }
    text.push_str("p3000 = 0\n");
    assert_eq!(words(&text), "fine");
}

#[test]
fn long_and_deep_expressions_are_no_trouble() {
    let chain = format!("x1{}", " - 2*x2".repeat(900));
    assert_eq!(
        words(&with_linear(&format!("[outputs]\ny = \"{chain}\""))),
        "fine"
    );
    let longer = format!("x1{}", " - 2*x2".repeat(100_000));
    assert_ne!(
        words(&with_linear(&format!("[outputs]\ny = \"{longer}\""))),
        "fine"
    );
    let deep = format!("{}x1{}", "-(".repeat(40), ")".repeat(40));
    assert_eq!(
        words(&with_linear(&format!("[outputs]\ny = \"{deep}\""))),
        "fine"
    );
    let deeper = format!("{}x1{}", "(".repeat(100_000), ")".repeat(100_000));
    assert_ne!(
        words(&with_linear(&format!("[outputs]\ny = \"{deeper}\""))),
        "fine"
    );
    let nested = format!("{}1{}", "[".repeat(10_000), "]".repeat(10_000));
    assert_ne!(
        words(&with_linear(&format!("matrices = {{ K = {nested} }}"))),
        "fine"
    );
}

/// Pieces of which random host files are put together.
const PIECES: &[&str] = &[
    "quell = 1\n",
    "[coordinates]\n",
    "[linear]\n",
    "[inputs]\n",
    "[outputs]\n",
    "[ports.p]\n",
    "[parameters]\n",
    "x = { mass = 1 }\n",
    "y = { kind = \"rotation\" }\n",
    "z = {}\n",
    "u = { kind = \"velocity\" }\n",
    "f = { kind = \"force\", on = \"x\" }\n",
    "springs = [[\"x\", \"u\", 1e300]]\n",
    "dampers = [[\"x\", \"ground\", 0]]\n",
    "matrices = { M = [[1]] }\n",
    "matrices = { K = [[1, 2], [3, 4]] }\n",
    "damping = { modal = 0.1 }\n",
    "damping = { rayleigh = { alpha = 1, beta = 1e-3 } }\n",
    "base = { influence = [1], input = \"u\" }\n",
    "supports = [\"z\"]\n",
    "between = [\"x\", \"ground\"]\n",
    "across = \"x - u\"\n",
    "at = \"x\"\n",
    "o = \"x''\"\n",
    "a = \"force(p) + stroke(p)\"\n",
    "k = \"2 N/m\"\n",
    "b = \"k*k/0\"\n",
    "masses = [[\"x\", 0.0]]\n",
    "'\"[]{}=,\n",
];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn no_text_makes_the_reader_panic(text in any::<String>()) {
        let _ = words(&text);
    }

    #[test]
    fn no_mixture_of_pieces_makes_the_reader_panic(pieces in prop::collection::vec(prop::sample::select(PIECES), 0..24)) {
        let _ = words(&pieces.concat());
    }

    #[test]
    fn no_change_to_a_sound_host_makes_the_reader_panic(
        place in 0_usize..600,
        length in 0_usize..12,
        text in "[ -~é\n]{0,8}",
    ) {
        let sound = with_linear("springs = [[\"x1\", \"x2\", \"k\"], { between = [\"x1 + 0.4 m*phi\", \"xs\"], value = \"k\", name = \"s\" }]\nmatrices = { M = [[1, 0, 0], [0, 1, 0], [0, 0, 1]] }\ndamping = { modal = [0.1, 0.2] }\n[ports.p]\nat = \"x1\"\n[outputs]\ny = \"x1'' + force(s)/(2 kg) - 2*stroke(p)''\"");
        let characters: Vec<char> = sound.chars().collect();
        let start = place.min(characters.len());
        let end = (start + length).min(characters.len());
        let changed: String = characters[..start].iter().copied().chain(text.chars()).chain(characters[end..].iter().copied()).collect();
        let _ = words(&changed);
    }
}
