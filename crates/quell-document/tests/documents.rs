//! Reading documents: places, values, quantities, faults.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use std::collections::BTreeMap;
use std::sync::Arc;

use proptest::prelude::*;
use quell_document::{Document, Fault, Source, Table, Value};
use quell_expression::{Dimension, Expression, NoNames, Node, Quantity, Span};

fn source(text: &str) -> Arc<Source> {
    Arc::new(Source::new("case.toml", text))
}

fn parse(text: &str) -> Document {
    Document::parse(source(text)).unwrap()
}

fn refused(text: &str) -> Fault {
    Document::parse(source(text)).unwrap_err()
}

fn slice(text: &str, span: Span) -> &str {
    &text[span.start..span.end]
}

#[test]
fn places_of_keys_values_and_tables() {
    let text = "a = 'x'\n[body]\nmass = \"60 kg\"\n[ports.left]\nbetween = [\"a\", \"b\"]\n[[tasks]]\nn = 1\n[[tasks]]\nn = 2\n";
    let document = parse(text);
    let root = document.root();
    let body = root.require("body").unwrap().as_table().unwrap();
    assert_eq!(slice(text, body.span()), "[body]");
    assert_eq!(slice(text, body.key_span("mass").unwrap()), "mass");
    assert_eq!(slice(text, body.get("mass").unwrap().span()), "\"60 kg\"");
    let ports = root.require("ports").unwrap().as_table().unwrap();
    assert_eq!(slice(text, ports.span()), "ports", "implied by the key");
    let left = ports.require("left").unwrap().as_table().unwrap();
    let between = left.require("between").unwrap().as_array().unwrap();
    assert_eq!(slice(text, between[1].span()), "\"b\"");
    let tasks = root.require("tasks").unwrap().as_array().unwrap();
    assert_eq!(tasks.len(), 2);
    assert_eq!(tasks[1].span().start, text.rfind("[[tasks]]").unwrap());
    assert_eq!(root.span(), Span { start: 0, end: 0 });
    assert_eq!(root.len(), 4);
    assert!(!root.is_empty());
}

#[test]
fn entries_come_in_file_order() {
    let document = parse("z = 1\na.y = 1\nm = 2\na.b = 2\n[t.u]\n[s]\n[t]\nk = 1\n");
    let keys: Vec<&str> = document.root().entries().map(|(key, _, _)| key).collect();
    assert_eq!(keys, ["z", "a", "m", "s", "t"]);
    let a = document.root().require("a").unwrap().as_table().unwrap();
    let keys: Vec<&str> = a.entries().map(|(key, _, _)| key).collect();
    assert_eq!(keys, ["y", "b"]);
}

#[test]
fn a_byte_order_mark_and_carriage_returns_keep_places_right() {
    let text = "\u{feff}a = 1\r\nb = \"x + y\"\r\n";
    let document = parse(text);
    let b = document.root().require("b").unwrap();
    assert_eq!(slice(text, b.span()), "\"x + y\"");
    assert_eq!(b.fault("no").position(), Some((2, 5)));
    let fault = document.root().require("a").unwrap().fault("no");
    assert_eq!(fault.position(), Some((1, 5)));
    assert!(
        fault.render().contains("1 | a = 1\n  |     ^\n"),
        "{}",
        fault.render()
    );
}

#[test]
fn wrong_kinds_say_what_was_expected_and_found() {
    let document = parse("t = 'x'\ni = 3\nf = 1.5\nb = true\na = []\nm = {}\nq = '3'\nn = -1\n");
    let get = |key: &str| document.root().require(key).unwrap();
    let message = |fault: Fault| fault.message;
    assert_eq!(
        message(get("i").as_str().unwrap_err()),
        "expected a text, found an integer"
    );
    assert_eq!(
        message(get("t").as_f64().unwrap_err()),
        "expected a number, found a text"
    );
    assert_eq!(
        message(get("f").as_integer().unwrap_err()),
        "expected an integer, found a number"
    );
    assert_eq!(
        message(get("m").as_bool().unwrap_err()),
        "expected `true` or `false`, found a table"
    );
    assert_eq!(
        message(get("b").as_array().unwrap_err()),
        "expected a list, found a boolean"
    );
    assert_eq!(
        message(get("a").as_table().unwrap_err()),
        "expected a table, found a list"
    );
    assert_eq!(
        message(get("n").as_count().unwrap_err()),
        "`-1` must not be negative"
    );
    assert_eq!(
        get("q").as_f64().unwrap_err().help.as_deref(),
        Some("leave out the quotes")
    );
    assert_eq!(get("i").as_f64().unwrap(), 3.0);
    assert_eq!(get("i").as_count().unwrap(), 3);
    assert!(get("b").as_bool().unwrap());
    assert!(get("t").is_text() && get("i").is_number() && get("f").is_number());
    assert!(get("b").is_bool() && get("a").is_array() && get("m").is_table());
}

#[test]
fn numbers_must_be_finite_and_fit() {
    let document = parse(
        "a = inf\nb = nan\nc = -inf\nd = 1e999\ne = 99999999999999999999\nf = 0xff\ng = 1_000\nh = 1_0.5e-1\n",
    );
    let get = |key: &str| document.root().require(key).unwrap();
    for (key, written) in [("a", "inf"), ("b", "nan"), ("c", "-inf"), ("d", "1e999")] {
        assert_eq!(
            get(key).as_f64().unwrap_err().message,
            format!("`{written}` must be finite")
        );
        assert!(get(key).quantity(&NoNames, None).is_err());
        assert!(get(key).expression().is_err());
    }
    for fault in [
        get("e").as_integer().unwrap_err(),
        get("e").as_f64().unwrap_err(),
    ] {
        assert_eq!(
            fault.message,
            "the integer `99999999999999999999` is too large"
        );
    }
    assert_eq!(get("f").as_integer().unwrap(), 255);
    assert_eq!(get("g").as_integer().unwrap(), 1000);
    assert_eq!(get("h").as_f64().unwrap(), 1.05);
}

#[test]
fn dates_are_refused_in_words() {
    let fault = refused("a = 1979-05-27\n");
    assert_eq!(fault.message, "dates and times have no meaning here");
    assert_eq!(fault.position(), Some((1, 5)));
    assert!(
        refused("a = [{ b = 07:32:00 }]\n")
            .message
            .contains("dates and times")
    );
}

#[test]
fn syntax_faults_are_in_the_users_words() {
    for (text, message, position) in [
        (
            "m = 60 kg\n",
            "`60 kg` is neither a number nor a text in quotes",
            (1, 5),
        ),
        ("m = \"60 kg\nb = 1\n", "a text is not closed", (1, 11)),
        ("a = 1\na = 2\n", "`a` is given twice", (2, 1)),
        ("[a]\n[a]\n", "`a` is given twice", (2, 2)),
        ("a = { b = 1, b = 2 }\n", "`b` is given twice", (1, 14)),
        ("a =\n", "a value is missing", (1, 4)),
        (
            "u(x) = 1\n",
            "a key has a character that needs quotes",
            (1, 2),
        ),
        ("a = .5\n", "a number lacks digits", (1, 5)),
        (
            "a = [1, 2\nb = 3\n",
            "a list is not closed, or lacks a comma",
            (2, 1),
        ),
        (
            "a = \"\\q\"\n",
            "a backslash begins an escape, and this is none",
            (1, 7),
        ),
    ] {
        let fault = refused(text);
        assert_eq!(fault.message, message, "{text:?}");
        assert_eq!(fault.position(), Some(position), "{text:?}");
        assert!(fault.help.is_some(), "{text:?}");
    }
    assert_eq!(
        refused("m = 60 kg").help.as_deref(),
        Some("write it in quotes: `\"60 kg\"`")
    );
}

#[test]
fn deep_nesting_is_refused_without_harm() {
    let lists = format!("a = {}1{}", "[".repeat(5000), "]".repeat(5000));
    let keys = vec!["a"; 5000].join(".");
    let dotted = format!(
        "{} = {{ {} = 1 }}",
        vec!["a"; 70].join("."),
        vec!["b"; 70].join(".")
    );
    let chains = format!(
        "{}1{}",
        format!("{} = {{", vec!["a"; 70].join(".")).repeat(75),
        "}".repeat(75)
    );
    for text in [
        lists,
        format!("{keys} = 1"),
        dotted,
        format!("[{keys}]"),
        chains,
    ] {
        assert!(Document::parse(source(&text)).is_err());
    }
    let shallow = format!("a = {}1{}", "[".repeat(60), "]".repeat(60));
    assert!(Document::parse(source(&shallow)).is_ok());
}

#[test]
fn choices_suggest_the_nearest() {
    let document = parse("kind = \"frequncy\"\nother = \"q\"\n");
    let choices = ["frequency", "transient", "modes"];
    let fault = document
        .root()
        .require("kind")
        .unwrap()
        .one_of(&choices)
        .unwrap_err();
    assert_eq!(
        fault.message,
        "expected `frequency`, `transient` or `modes`, found `frequncy`"
    );
    assert_eq!(fault.help.as_deref(), Some("did you mean `frequency`?"));
    let fault = document
        .root()
        .require("other")
        .unwrap()
        .one_of(&choices)
        .unwrap_err();
    assert_eq!(fault.help, None);
    let document = parse("kind = \"modes\"\n");
    assert_eq!(
        document
            .root()
            .require("kind")
            .unwrap()
            .one_of(&choices)
            .unwrap(),
        "modes"
    );
}

/// Every name in the expression with the text its span covers in the file.
fn names<'t>(text: &'t str, expression: &Expression, found: &mut Vec<(String, &'t str)>) {
    match &expression.node {
        Node::Name(name) => found.push((name.clone(), slice(text, expression.span))),
        Node::Call {
            function,
            function_span,
            ..
        } => found.push((function.clone(), slice(text, *function_span))),
        _ => {}
    }
    for part in expression.parts() {
        names(text, part, found);
    }
}

#[test]
fn spans_of_expressions_are_places_in_the_file() {
    for text in [
        "\"é\" = 1 # é\nf = \"max(abs(xe - xs), yy') <= -kk*2\"\n",
        "f = 'max(abs(xe - xs), yy) <= -kk'\n",
        "f = \"\"\"max(abs(xe - xs), yy) <= -kk\"\"\"\n",
        "f = \"\"\"\nmax(abs(xe - xs), yy) <= -kk\"\"\"\n",
        "f = '''\r\nmax(abs(xe - xs), yy) <= -kk'''\r\n",
    ] {
        let document = parse(text);
        let expression = document.root().require("f").unwrap().expression().unwrap();
        let mut found = Vec::new();
        names(text, &expression, &mut found);
        assert_eq!(found.len(), 6, "{text}");
        for (name, covered) in found {
            assert_eq!(name, covered, "{text}");
        }
    }
}

#[test]
fn with_escapes_the_whole_text_is_the_place() {
    let text = "f = \"xe \\u002D xs\"\n";
    let document = parse(text);
    let value = document.root().require("f").unwrap();
    let expression = value.expression().unwrap();
    let mut found = Vec::new();
    names(text, &expression, &mut found);
    assert_eq!(found[0], ("xe".to_owned(), "\"xe \\u002D xs\""));
    assert_eq!(value.text_span(Span { start: 0, end: 2 }), value.span());
}

#[test]
fn faults_of_expressions_point_into_the_text() {
    let text = "k = 2\nforce = \"kr*(1 + \"\n";
    let document = parse(text);
    let fault = document
        .root()
        .require("force")
        .unwrap()
        .expression()
        .unwrap_err();
    assert_eq!(fault.position().unwrap().0, 2);
    let span = fault.span.unwrap();
    assert!(span.start >= 15 && span.end < text.len(), "{span:?}");

    let scope = BTreeMap::from([(
        "stiffness".to_owned(),
        Quantity::new(5.0, Dimension::STIFFNESS),
    )]);
    let text = "k = \"2*stifness\"\n";
    let document = parse(text);
    let fault = document
        .root()
        .require("k")
        .unwrap()
        .quantity(&scope, None)
        .unwrap_err();
    assert_eq!(slice(text, fault.span.unwrap()), "stifness");
    assert!(fault.help.unwrap().contains("stiffness"));
}

#[test]
fn a_number_is_an_expression() {
    let document = parse("a = 3\nb = -2.5\n");
    let value = |key: &str| {
        let expression = document.root().require(key).unwrap().expression().unwrap();
        expression.evaluate(&NoNames).unwrap().value
    };
    assert_eq!((value("a"), value("b")), (3.0, -2.5));
}

#[test]
fn quantities_are_in_si_and_of_the_dimension_wanted() {
    let scope = BTreeMap::from([("k".to_owned(), Quantity::new(5.0, Dimension::STIFFNESS))]);
    let document = parse(
        "a = \"2 kN/m\"\nb = \"2*k\"\nc = 7\nd = \"60 kg\"\ne = \"3\"\nf = \"1 kg/0\"\ng = true\n",
    );
    let quantity = |key: &str, wanted| {
        document
            .root()
            .require(key)
            .unwrap()
            .quantity(&scope, wanted)
    };
    let stiffness = Some(Dimension::STIFFNESS);
    // The factor 1000 and the products are exact in binary floating point.
    assert_eq!(
        quantity("a", stiffness).unwrap(),
        Quantity::new(2000.0, Dimension::STIFFNESS)
    );
    assert_eq!(quantity("b", stiffness).unwrap().value, 10.0);
    assert_eq!(
        quantity("c", stiffness).unwrap(),
        Quantity::new(7.0, Dimension::STIFFNESS)
    );
    assert_eq!(quantity("c", None).unwrap(), Quantity::number(7.0));
    assert_eq!(quantity("d", None).unwrap().dimension, Dimension::MASS);
    let fault = quantity("d", stiffness).unwrap_err();
    assert_eq!(
        fault.message,
        "expected a quantity in `N/m`, found a quantity in `kg`"
    );
    let fault = quantity("e", stiffness).unwrap_err();
    assert_eq!(
        fault.message,
        "expected a quantity in `N/m`, found a plain number"
    );
    assert_eq!(
        fault.help.as_deref(),
        Some("write a unit after the number, such as `N/m`")
    );
    assert!(quantity("f", None).is_err(), "not finite");
    let fault = quantity("g", None).unwrap_err();
    assert_eq!(
        fault.message,
        "expected a number, or a text with a unit, found a boolean"
    );
}

#[test]
fn a_plain_frequency_is_ambiguous() {
    let document = parse("a = 30\nb = \"30 Hz\"\nc = 0\nd = \"30\"\ne = \"30 1/s\"\n");
    let quantity = |key: &str| {
        let value = document.root().require(key).unwrap();
        value.quantity(&NoNames, Some(Dimension::ANGULAR_FREQUENCY))
    };
    let fault = quantity("a").unwrap_err();
    assert_eq!(fault.message, "`30` is ambiguous for a frequency");
    assert_eq!(
        fault.help.as_deref(),
        Some("write \"30 Hz\" or \"30 rad/s\"")
    );
    // One multiplication by 2 pi: a rounding or two.
    assert!((quantity("b").unwrap().value - 60.0 * std::f64::consts::PI).abs() < 1e-12);
    assert_eq!(
        quantity("c").unwrap().value,
        0.0,
        "zero is zero in either unit"
    );
    assert!(quantity("d").is_err());
    assert!(quantity("e").is_err());
}

#[test]
fn rendering() {
    let document = parse("[body]\n\tmass = \"-6 kg\" # heavy\n");
    let mass = document
        .root()
        .require("body")
        .unwrap()
        .as_table()
        .unwrap()
        .require("mass")
        .unwrap();
    let fault = mass
        .fault("a mass must be positive")
        .label("negative")
        .help("leave out the sign");
    assert_eq!(
        fault.render(),
        "error: a mass must be positive\n \
         --> case.toml:2:9\n  \
         |\n\
         2 |     mass = \"-6 kg\" # heavy\n  \
         |            ^^^^^^^ negative\n  \
         = help: leave out the sign\n"
    );
    assert_eq!(
        fault.to_string(),
        "a mass must be positive (case.toml, line 2)"
    );
}

#[test]
fn rendering_at_odd_places() {
    let text = "naïve = \"日本\"\r\nlast = [\n 1,\n 2]";
    let at = |start, end| Fault::at(&source(text), Span { start, end }, "m").render();
    let begin = text.find('"').unwrap();
    assert!(at(begin, begin + 8).contains("1 | naïve = \"日本\"\n  |         ^^^^\n"));
    let list = text.find('[').unwrap();
    assert!(
        at(list, text.len()).contains("2 | last = [\n  |        ^\n"),
        "the first line of several"
    );
    assert!(
        at(text.len(), text.len()).contains(":4:4\n  |\n4 |  2]\n  |    ^\n"),
        "end of file"
    );
    assert!(at(9999, 99999).contains(":4:4"));
    assert!(
        at(text.find('ï').unwrap() + 1, 4).contains(":1:3"),
        "inside a character"
    );
    assert!(at(30, 3).contains('^'), "end before start");
    let empty = Fault::at(&source(""), Span { start: 0, end: 0 }, "m").render();
    assert_eq!(empty, "error: m\n --> case.toml:1:1\n  |\n1 |\n  | ^\n");
    assert_eq!(
        Fault::new("m").help("h").render(),
        "error: m\n  = help: h\n"
    );
    let control = Fault::at(&source("a = \u{1b}[31m\n"), Span { start: 4, end: 5 }, "m").render();
    assert!(!control.contains('\u{1b}'));
}

#[test]
fn long_lines_are_cut_round_the_fault() {
    let text = format!("a = [{}x{}]", "1, ".repeat(500), ", 1".repeat(500));
    let place = text.find('x').unwrap();
    let rendered = Fault::at(
        &source(&text),
        Span {
            start: place,
            end: place + 1,
        },
        "m",
    )
    .render();
    let lines: Vec<&str> = rendered.lines().collect();
    let caret = lines[4]
        .chars()
        .position(|character| character == '^')
        .unwrap();
    assert_eq!(lines[3].chars().nth(caret), Some('x'));
    assert!(lines[3].chars().count() < 180);
}

#[test]
fn faults_cross_threads() {
    fn crosses<T: Send + Sync + std::error::Error + Clone>() {}
    crosses::<Fault>();
}

/// Reads everything there is to read in every way, keeping only what could panic.
fn walk(table: &Table<'_>, text: &str) {
    for (key, span, value) in table.entries() {
        assert!(text.get(span.start..span.end).is_some());
        assert!(table.get(key).is_some());
        visit(&value, text);
    }
}

fn visit(value: &Value<'_>, text: &str) {
    let span = value.span();
    assert!(text.get(span.start..span.end).is_some());
    value.fault("m").render();
    let _ = value.as_integer();
    let _ = value.as_count();
    let _ = value.as_bool();
    let _ = value.one_of(&["a", "b"]);
    let _ = value.quantity(&NoNames, Some(Dimension::ANGULAR_FREQUENCY));
    if let Err(fault) = value.expression() {
        fault.render();
    }
    if let Ok(number) = value.as_f64() {
        assert!(number.is_finite());
    }
    if let Ok(inner) = value.as_str() {
        let whole = value.text_span(Span {
            start: 0,
            end: inner.len(),
        });
        let covered = text.get(whole.start..whole.end).unwrap();
        assert!(covered == inner || whole == span);
    }
    for value in value.as_array().unwrap_or_default() {
        visit(&value, text);
    }
    if let Ok(table) = value.as_table() {
        walk(&table, text);
    }
}

fn read(text: &str) {
    match Document::parse(source(text)) {
        Ok(document) => walk(&document.root(), text),
        Err(fault) => {
            assert!(fault.position().is_some());
            fault.render();
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn no_text_makes_reading_panic(text in any::<String>()) {
        read(&text);
    }

    /// Pieces of documents in random order come closer to the corners of the syntax than random characters.
    #[test]
    fn no_pieces_make_reading_panic(pieces in prop::collection::vec(prop::sample::select(vec![
        "a", "b", "é", ".", " = ", "=", "\n", "\r\n", "\r", "\t", " ", "[", "]", "[[", "]]", "{", "}", ",", "\"", "'", "\"\"\"", "'''",
        "\\", "\\n", "\\u00e9", "1", "-2.5", "1e999", "inf", "nan", "0x", "_", "1979-05-27", "true", "# c", "\u{feff}", "\u{1b}",
        "60 kg", "max(a, b')", "a = 1\n", "[a]\n", "[[a]]\n", "[a.b]\n", "b.c = \"2 Hz\"\n", "a = { b = 1 }\n", "日",
    ]), 0..24)) {
        read(&pieces.concat());
    }
}
