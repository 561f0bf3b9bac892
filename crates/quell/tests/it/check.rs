//! `quell check`.

use std::fs;

use crate::{assert_plain, errors, output, quell, root};

#[test]
fn every_study_of_the_repository_is_sound() {
    let mut checked = 0;
    for entry in fs::read_dir(root().join("studies")).unwrap() {
        let path = entry.unwrap().path();
        if path
            .extension()
            .is_some_and(|extension| extension == "toml")
        {
            let assert = quell().arg("check").arg(&path).assert().code(0);
            let text = output(&assert);
            assert_plain(&text);
            assert!(text.ends_with("The study is sound.\n"), "{text}");
            assert_eq!(errors(&assert), "");
            checked += 1;
        }
    }
    assert!(checked >= 3);
}

#[test]
fn says_what_a_study_would_do() {
    let assert = quell()
        .args(["check", "studies/engine-mount-linear.toml"])
        .assert()
        .code(0);
    insta::assert_snapshot!(output(&assert));
}

#[test]
fn a_wrong_study_exits_with_one_and_shows_the_place() {
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("wrong.toml");
    let text = "quell = 1\ntitle = \"Wrong\"\nhost = \"host.toml\"\n\n[critera]\n";
    fs::write(&study, text).unwrap();
    let assert = quell()
        .current_dir(folder.path())
        .args(["check", "wrong.toml"])
        .assert()
        .code(1);
    assert_eq!(output(&assert), "");
    assert_plain(&errors(&assert));
    insta::assert_snapshot!(errors(&assert));
}

#[test]
fn a_missing_study_exits_with_one() {
    let assert = quell().args(["check", "no-such.toml"]).assert().code(1);
    assert!(errors(&assert).contains("no-such.toml"));
}
