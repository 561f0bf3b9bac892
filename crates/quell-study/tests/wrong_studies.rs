//! Wrong study files and the words they get: every file of `tests/wrong` has one thing wrong with it.
//!
//! A new file needs no line here; `cargo insta review` shows what an engineer would read.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use quell_study::{Study, check};

/// No wrong study keeps anybody waiting, however large its numbers: a generous limit for a busy machine and a build
/// without optimisation.
const LONGEST: Duration = Duration::from_secs(5);

/// The files of a folder, in order.
fn files(folder: &str) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "toml")
        })
        .collect();
    files.sort();
    files
}

/// What reading and checking a study says; nothing if it is sound.
fn words(path: &Path) -> Option<String> {
    let checked = Study::read(path).and_then(|study| check(&study));
    // Paths as typed, whatever the separator of the machine.
    checked.err().map(|fault| {
        fault
            .render()
            .replace("tests\\", "tests/")
            .replace("wrong\\", "wrong/")
    })
}

#[test]
fn wrong_studies_get_useful_words() {
    let mut report = String::new();
    let mut trouble = String::new();
    for path in files("tests/wrong") {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let begin = Instant::now();
        let said = std::panic::catch_unwind(|| words(&path));
        let taken = begin.elapsed();
        if taken > LONGEST {
            let _ = writeln!(trouble, "{name}: took {taken:?}");
        }
        match said {
            Ok(Some(words)) => {
                let _ = writeln!(report, "## {name}\n{words}");
            }
            Ok(None) => {
                let _ = writeln!(trouble, "{name}: accepted");
            }
            Err(_) => {
                let _ = writeln!(trouble, "{name}: panicked");
            }
        }
    }
    let mut settings = insta::Settings::clone_current();
    settings.set_omit_expression(true);
    settings.bind(|| insta::assert_snapshot!("wrong_studies", report));
    assert!(trouble.is_empty(), "\n{trouble}");
}

#[test]
fn a_missing_study_and_a_folder_are_said_to_be_so() {
    let missing = words(Path::new("tests/wrong/no-such-study.toml")).unwrap();
    assert!(missing.starts_with("error: there is no study"), "{missing}");
    let folder = words(Path::new("tests/wrong")).unwrap();
    assert!(folder.contains("is a folder"), "{folder}");
}

#[test]
fn what_the_wrong_studies_were_made_from_is_sound() {
    for path in files("tests/wrong/sound") {
        assert_eq!(words(&path), None, "{}", path.display());
    }
}

/// A sound study whose criterion is given.
fn with_criterion(value: &str) -> String {
    std::fs::read_to_string("tests/wrong/sound/strut.toml")
        .unwrap()
        .replace("max(abs(x1 - xs))", value)
}

/// Reads and checks a text on a thread with so much stack.
fn checked_with_stack(text: String, stack: usize) -> Result<(), String> {
    let folder = Path::new("tests/wrong/sound");
    std::thread::Builder::new()
        .stack_size(stack)
        .spawn(move || {
            let source = quell_document::Source::new("study.toml", text);
            Study::parse(source, folder)
                .and_then(|study| check(&study))
                .map(drop)
                .map_err(|fault| fault.render())
        })
        .unwrap()
        .join()
        .unwrap()
}

/// The least that platforms give the main thread (Windows: 1 MiB).
const LITTLE_STACK: usize = 1 << 20;

#[test]
fn long_criteria_take_no_stack() {
    let sum_of_norms = format!("h2(x1){}", " + h2(x1)".repeat(990));
    assert_eq!(
        checked_with_stack(with_criterion(&sum_of_norms), LITTLE_STACK),
        Ok(())
    );
    let sum_of_signals = format!("max(abs(x1{}))", " - 0.5*x2".repeat(990));
    assert_eq!(
        checked_with_stack(with_criterion(&sum_of_signals), LITTLE_STACK),
        Ok(())
    );
    // To the left and to the right, and as deep as the parser goes.
    let nested = format!("{}h2(x1){}", "(h2(x1) + ".repeat(90), ")".repeat(90));
    assert_eq!(
        checked_with_stack(with_criterion(&nested), LITTLE_STACK),
        Ok(())
    );
    let signs = format!("{}h2(x1)", "-".repeat(90));
    assert_eq!(
        checked_with_stack(with_criterion(&signs), LITTLE_STACK),
        Ok(())
    );
    let powers = format!("h2(x1)*1{}", "^1".repeat(90));
    assert_eq!(
        checked_with_stack(with_criterion(&powers), LITTLE_STACK),
        Ok(())
    );
    let functions = format!("{}1{}*h2(x1)", "sqrt(".repeat(90), ")".repeat(90));
    assert_eq!(
        checked_with_stack(with_criterion(&functions), LITTLE_STACK),
        Ok(())
    );
}

#[test]
fn endless_criteria_are_refused() {
    for endless in [
        format!("h2(x1){}", " + h2(x1)".repeat(50_000)),
        format!("h2(x1{})", " + x1".repeat(50_000)),
        format!("{}h2(x1){}", "(".repeat(50_000), ")".repeat(50_000)),
        format!("{}h2(x1)", "-".repeat(50_000)),
        format!("h2(x1)*1{}", "^1".repeat(50_000)),
        format!("h2(x1{})", "'".repeat(50_000)),
    ] {
        let words = checked_with_stack(with_criterion(&endless), LITTLE_STACK).unwrap_err();
        assert!(words.len() < 1000, "{} bytes of message", words.len());
    }
}

#[test]
fn long_values_take_no_stack() {
    let text = std::fs::read_to_string("tests/wrong/sound/strut.toml")
        .unwrap()
        .replace("\"1e3 N/m\"", &format!("\"k{}\"", " + k".repeat(1900)));
    assert_eq!(checked_with_stack(text, LITTLE_STACK), Ok(()));
}
