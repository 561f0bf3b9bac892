//! The reference in the documentation is the one that the program prints.

#[test]
fn the_documented_reference_is_up_to_date() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference.md");
    let documented = std::fs::read_to_string(path).unwrap();
    assert!(
        documented == quell_study::reference(),
        "run `cargo run -- reference > docs/reference.md`"
    );
}
