//! What the fuzz targets do by hand, in a small way on every run: no text makes the reader of studies or layouts panic.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use std::fmt::Write as _;
use std::path::Path;
use std::time::Duration;

use proptest::prelude::*;
use quell_document::Source;
use quell_network::{Domain, Element, Kinds, Layout};
use quell_study::{Study, check};

/// Sound studies, with the folder to which their paths are relative.
const STUDIES: [(&str, &str); 6] = [
    ("../../studies/engine-mount-linear.toml", "../../studies"),
    ("../../studies/quarter-car.toml", "../../studies"),
    ("../../studies/tuned-mass-damper.toml", "../../studies"),
    ("tests/wrong/sound/strut.toml", "tests/wrong/sound"),
    ("tests/wrong/sound/pipe.toml", "tests/wrong/sound"),
    ("tests/wrong/sound/absorber.toml", "tests/wrong/sound"),
];

/// Numbers that nobody means.
const NUMBERS: [&str; 14] = [
    "0",
    "-1",
    "1e308",
    "-1e308",
    "1e-320",
    "nan",
    "inf",
    "-inf",
    "9223372036854775807",
    "1e999",
    "0.1e-999",
    "-0.0",
    "1000000",
    "7",
];

/// What a person or a crash might leave in a file.
const PIECES: [&str; 26] = [
    "\"",
    "'",
    "[",
    "]",
    "{",
    "}",
    "=",
    ",",
    "\n",
    "\\",
    "\0",
    "\u{feff}",
    "é",
    "|",
    "+",
    "(",
    ")",
    "^",
    "'''",
    "1e999",
    " Hz",
    " N/m",
    "/0",
    "[[tasks]]\n",
    "max(abs(",
    "= {}\n",
];

/// Begins the sequences that colour a terminal: from a file it must never get there.
const ESCAPE: char = '\u{1b}';

/// One change to a text.
#[derive(Debug, Clone)]
enum Mutation {
    Delete(usize, usize),
    Insert(usize, &'static str),
    Overwrite(usize, char),
    SwapLines(usize, usize),
    RepeatLine(usize),
    DropLine(usize),
    Number(usize, &'static str),
    SwapWords(usize, usize),
}

fn mutation() -> impl Strategy<Value = Mutation> {
    let place = || any::<usize>();
    prop_oneof![
        1 => (place(), 1..40_usize).prop_map(|(at, length)| Mutation::Delete(at, length)),
        1 => (place(), prop::sample::select(&PIECES[..])).prop_map(|(at, piece)| Mutation::Insert(at, piece)),
        1 => (place(), any::<char>()).prop_map(|(at, character)| Mutation::Overwrite(at, character)),
        1 => (place(), place()).prop_map(|(a, b)| Mutation::SwapLines(a, b)),
        1 => place().prop_map(Mutation::RepeatLine),
        1 => place().prop_map(Mutation::DropLine),
        4 => (place(), prop::sample::select(&NUMBERS[..])).prop_map(|(at, number)| Mutation::Number(at, number)),
        3 => (place(), place()).prop_map(|(a, b)| Mutation::SwapWords(a, b)),
    ]
}

/// Byte ranges of the runs of characters of a sort.
fn runs(text: &str, belongs: impl Fn(char) -> bool) -> Vec<std::ops::Range<usize>> {
    let mut found: Vec<std::ops::Range<usize>> = Vec::new();
    for (at, character) in text.char_indices() {
        if belongs(character) {
            let end = at + character.len_utf8();
            match found.last_mut() {
                Some(last) if last.end == at => last.end = end,
                _ => found.push(at..end),
            }
        }
    }
    found
}

fn mutate(text: &str, mutation: &Mutation) -> String {
    let boundary = |at: usize| text.floor_char_boundary(at % (text.len() + 1));
    let by_lines = |change: &dyn Fn(&mut Vec<&str>)| {
        let mut lines: Vec<&str> = text.lines().collect();
        if !lines.is_empty() {
            change(&mut lines);
        }
        lines.join("\n")
    };
    match *mutation {
        Mutation::Delete(at, length) => {
            let start = boundary(at);
            let end = text.ceil_char_boundary((start + length).min(text.len()));
            format!("{}{}", &text[..start], &text[end..])
        }
        Mutation::Insert(at, piece) => {
            let at = boundary(at);
            format!("{}{piece}{}", &text[..at], &text[at..])
        }
        Mutation::Overwrite(at, character) => {
            let start = boundary(at);
            let mut rest = text[start..].chars();
            rest.next();
            format!("{}{character}{}", &text[..start], rest.as_str())
        }
        Mutation::SwapLines(a, b) => by_lines(&|lines| {
            let count = lines.len();
            lines.swap(a % count, b % count);
        }),
        Mutation::RepeatLine(at) => by_lines(&|lines| {
            let at = at % lines.len();
            lines.insert(at, lines[at]);
        }),
        Mutation::DropLine(at) => by_lines(&|lines| {
            lines.remove(at % lines.len());
        }),
        Mutation::Number(at, number) => {
            let numbers = runs(text, |character| {
                character.is_ascii_digit() || character == '.'
            });
            match numbers.get(at % numbers.len().max(1)) {
                Some(place) => format!("{}{number}{}", &text[..place.start], &text[place.end..]),
                None => text.to_owned(),
            }
        }
        Mutation::SwapWords(a, b) => {
            let words = runs(text, |character| {
                character.is_alphanumeric() || character == '_'
            });
            let count = words.len().max(1);
            let (first, second) = ((a % count).min(b % count), (a % count).max(b % count));
            match (words.get(first), words.get(second)) {
                (Some(first), Some(second)) if first.end <= second.start => format!(
                    "{}{}{}{}{}",
                    &text[..first.start],
                    &text[second.clone()],
                    &text[first.end..second.start],
                    &text[first.clone()],
                    &text[second.end..]
                ),
                _ => text.to_owned(),
            }
        }
    }
}

/// Reads and checks a study; renders the fault, as the command line would.
fn verdict(text: String, folder: &str) -> Result<(), String> {
    let checked = Study::parse(Source::new("study.toml", text), Path::new(folder))
        .and_then(|study| check(&study));
    checked.map(drop).map_err(|fault| fault.render())
}

/// Whatever the numbers in it, no study keeps `check` busy for longer: generous, for a build without optimisation on a
/// machine with other work.
const LONGEST: Duration = Duration::from_secs(10);

/// The verdict, if there is one in time: a loop without end must fail the test, not hang it.
fn verdict_in_time(text: String, folder: &'static str) -> Option<Result<(), String>> {
    let (sender, receiver) = std::sync::mpsc::channel();
    std::thread::spawn(move || sender.send(verdict(text, folder)));
    receiver.recv_timeout(LONGEST).ok()
}

/// So many cases, or as many as `PROPTEST_CASES` asks for.
fn config(cases: u32) -> ProptestConfig {
    let asked = std::env::var("PROPTEST_CASES").is_ok();
    let usual = ProptestConfig::default();
    ProptestConfig {
        cases: if asked { usual.cases } else { cases },
        failure_persistence: None,
        max_shrink_iters: 64,
        ..usual
    }
}

proptest! {
    #![proptest_config(config(2500))]

    #[test]
    fn no_mutation_of_a_study_makes_the_reader_panic(
        (study, mutations) in (0..STUDIES.len(), prop::collection::vec(mutation(), 1..4))
    ) {
        let (path, folder) = STUDIES[study];
        let mut text = std::fs::read_to_string(path).unwrap();
        for mutation in &mutations {
            text = mutate(&text, mutation);
        }
        let said = verdict_in_time(text.clone(), folder);
        prop_assert!(said.is_some(), "this study is not judged within {LONGEST:?}, or makes the reader panic:\n{text}");
        let said = said.unwrap_or(Ok(()));
        if let Err(words) = said {
            prop_assert!(words.starts_with("error: "));
            prop_assert!(!words.contains(ESCAPE));
        }
    }

    #[test]
    fn no_text_is_too_strange_for_a_study(text in "\\PC{0,200}") {
        let _ = verdict(text.clone(), "../../studies");
        let _ = verdict(format!("quell = 1\n{text}"), "../../studies");
    }
}

fn kinds(domain: Domain) -> Kinds {
    let mut kinds = Kinds::new(domain);
    kinds.declare_component("pipe").unwrap();
    kinds.declare_element("pad", Element::Damper).unwrap();
    kinds.declare_placeholder("slot").unwrap();
    kinds
}

fn layout_is_sound_or_refused(text: &str) -> Result<(), TestCaseError> {
    for domain in Domain::ALL {
        let kinds = kinds(domain);
        match Layout::parse(text, &kinds) {
            Ok(layout) => {
                let printed = layout.to_string();
                let again = Layout::parse(&printed, &kinds);
                prop_assert_eq!(again.as_ref(), Ok(&layout), "{}", printed);
                prop_assert_eq!(layout.canonical(), layout.canonical().canonical());
            }
            Err(error) => {
                prop_assert!(
                    error.span.end <= text.len(),
                    "{:?} in {} bytes",
                    error.span,
                    text.len()
                );
                prop_assert!(error.span.start <= error.span.end);
                prop_assert!(!error.message.is_empty());
            }
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(config(2000))]

    #[test]
    fn no_text_makes_the_reader_of_layouts_panic(text in "\\PC{0,60}") {
        layout_is_sound_or_refused(&text)?;
    }

    #[test]
    fn no_mixture_of_pieces_makes_the_reader_of_layouts_panic(
        pieces in prop::collection::vec(
            prop::sample::select(&["k1", "c1", "b2", "m1", "R", "I3", "C", "L", "pipe1", "pipe2", "pad", "slot", "+", "|", "(", ")", " ", "é", "1", "||"][..]),
            0..40,
        )
    ) {
        layout_is_sound_or_refused(&pieces.concat())?;
    }
}

#[test]
fn long_and_deep_layouts_are_no_trouble() {
    let mut long = "k1".to_owned();
    for index in 2..3000 {
        let _ = write!(
            long,
            "{} c{index}",
            if index % 2 == 0 { " |" } else { " +" }
        );
    }
    let deep = |depth: usize| format!("{}k1{}", "(".repeat(depth), ")".repeat(depth));
    let ladder: String = (0..60).fold("k0".to_owned(), |inner, rung| {
        format!("(({inner}) + c{rung}) | b{rung}")
    });
    for text in [long, deep(60), deep(100_000), ladder, "|".repeat(100_000)] {
        layout_is_sound_or_refused(&text).unwrap();
    }
}
