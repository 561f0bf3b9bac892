//! Reading, writing and transforming layouts.
#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

use proptest::prelude::*;
use quell_network::{Domain, Element, Kind, KindError, Kinds, Layout, TransformError, Tree};

fn mechanical() -> Kinds {
    let mut kinds = Kinds::new(Domain::Translational);
    kinds.declare_element("stop", Element::Spring).unwrap();
    kinds.declare_component("isolator").unwrap();
    kinds.declare_placeholder("network").unwrap();
    kinds
}

fn layout(text: &str) -> Layout {
    Layout::parse(text, &mechanical()).unwrap()
}

#[test]
fn series_binds_tighter_and_order_is_kept() {
    assert_eq!(layout("k1 | c1 + b1"), layout("(b1+c1)|k1"));
    assert_ne!(layout("k1 | c1 + b1"), layout("(k1 | c1) + b1"));
    assert_eq!(layout("c1 | k1").to_string(), "c1 | k1");
    assert_eq!(layout("c1 | k1").canonical().to_string(), "k1 | c1");
    assert_eq!(layout("((k1 + (c1 + b1)))").to_string(), "k1 + c1 + b1");
    assert_eq!(layout("k2+(k1|c1|b1)").to_string(), "k2 + (k1 | c1 | b1)");
    assert_eq!(layout("k10 | k2").canonical().to_string(), "k2 | k10");
    assert_eq!(
        layout("network | stop + isolator | k1 + b")
            .canonical()
            .to_string(),
        "network | k1 + b | stop + isolator"
    );
    assert!(layout("k1 | c1").equivalent(&layout("c1 | k1")));
}

#[test]
fn names_stand_for_kinds() {
    let kinds = mechanical();
    let kind = |name: &str| kinds.branch(name).map(|branch| branch.kind);
    assert_eq!(kind("k"), Some(Kind::Element(Element::Spring)));
    assert_eq!(kind("ks_2"), Some(Kind::Element(Element::Spring)));
    assert_eq!(kind("stop"), Some(Kind::Element(Element::Spring)));
    assert_eq!(kind("stop3"), Some(Kind::Element(Element::Spring)));
    assert_eq!(kind("isolator"), Some(Kind::Component("isolator".into())));
    assert_eq!(kind("isolator12"), Some(Kind::Component("isolator".into())));
    assert_eq!(kind("network"), Some(Kind::Placeholder));
    assert_eq!(kind("network1"), None);
    assert_eq!(kind("isolators"), None);
    assert_eq!(kind("K1"), None);
    let mut kinds = kinds;
    assert_eq!(
        kinds.declare_component("isolator"),
        Err(KindError::Twice("isolator".into()))
    );
    assert_eq!(
        kinds.declare_component("part2"),
        Err(KindError::EndsInDigit("part2".into()))
    );
    assert!(matches!(
        kinds.declare_element("isolator2", Element::Damper),
        Err(KindError::Ambiguous { .. })
    ));
    assert!(matches!(
        kinds.declare_element("2x", Element::Damper),
        Err(KindError::NotAName(_))
    ));
}

/// The text under the span, the message, the help.
fn fault(text: &str) -> (String, String, String) {
    let error = Layout::parse(text, &mechanical()).unwrap_err();
    (
        text[error.span.start..error.span.end].to_owned(),
        error.message,
        error.help.unwrap_or_default(),
    )
}

#[test]
fn errors_point_at_the_character() {
    for (text, at, message) in [
        ("", "", "the layout is empty"),
        ("  ", "  ", "the layout is empty"),
        ("k1 |", "|", "a branch is missing after `|`"),
        ("k1 + | c1", "|", "expected a branch before `|`"),
        ("k1 c1", "c1", "expected `+` or `|` before `c1`"),
        ("(k1 c1)", "c1", "expected `+`, `|` or `)` before `c1`"),
        ("(k1 | c1", "(", "this `(` is never closed"),
        ("k1 | c1)", ")", "this `)` closes nothing"),
        ("()", ")", "expected a branch before `)`"),
        ("k1 - c1", "-", "`-` has no meaning in a layout"),
        ("k1 || c1", "||", "`||` is no operator"),
        ("k1 | 2", "2", "`2` has no meaning in a layout"),
        ("k1 | k1", "k1", "`k1` occurs twice in this layout"),
        ("k1 | ζ1", "ζ1", "`ζ1` is no known kind of branch"),
        ("k1 → c1", "→", "`→` has no meaning in a layout"),
        ("k1 | x1", "x1", "`x1` is no known kind of branch"),
    ] {
        let (span, said, _) = fault(text);
        assert_eq!((span.as_str(), said.as_str()), (at, message), "{text:?}");
    }
    let twice = Layout::parse("k1 | k1", &mechanical()).unwrap_err();
    assert_eq!(twice.span.start, 5);
    let (_, _, help) = fault("k1 | isolater2");
    assert!(help.starts_with("did you mean `isolator2`?"), "{help}");
    let (_, _, help) = fault("k1 | netwrk");
    assert!(help.starts_with("did you mean `network`?"), "{help}");
    let (_, _, help) = fault("k1 | C1");
    assert!(help.starts_with("did you mean `c1`?"), "{help}");
}

#[test]
fn deep_and_long_texts_are_refused() {
    for text in [
        "(".repeat(100_000),
        format!("{}k{}", "(".repeat(100), ")".repeat(100)),
        vec!["k"; 5000].join("+"),
    ] {
        assert!(Layout::parse(&text, &mechanical()).is_err());
    }
    let deep = format!("{}k1{}", "(".repeat(64), ")".repeat(64));
    assert_eq!(layout(&deep).to_string(), "k1");
}

#[test]
fn substitution_fills_a_placeholder() {
    let outer = layout("k1 | (k2 + network)");
    assert_eq!(
        outer
            .substitute("network", &layout("c1 + b1"))
            .unwrap()
            .to_string(),
        "k1 | k2 + c1 + b1"
    );
    assert_eq!(
        outer
            .substitute("network", &layout("c1 | b1"))
            .unwrap()
            .to_string(),
        "k1 | k2 + (c1 | b1)"
    );
    assert_eq!(
        outer.substitute("network", &layout("c1 | k2")),
        Err(TransformError::Name("k2".into()))
    );
    assert_eq!(
        outer.substitute("net", &layout("c1")),
        Err(TransformError::NoPlaceholder("net".into()))
    );
    let hydraulic = Layout::parse("R1", &Kinds::new(Domain::Hydraulic)).unwrap();
    assert!(matches!(
        outer.substitute("network", &hydraulic),
        Err(TransformError::Domain { .. })
    ));
}

#[test]
fn duals_swap_groups_and_elements() {
    assert_eq!(
        layout("k1 | c1 + b2").dual().unwrap().to_string(),
        "b1 + (c1 | k2)"
    );
    assert_eq!(
        layout("stop | bstop + c1").dual().unwrap().to_string(),
        "bstop + (kstop | c1)"
    );
    assert_eq!(
        layout("k1 | c1 + b2").dual().unwrap().dual().unwrap(),
        layout("k1 | c1 + b2")
    );
    assert_eq!(
        layout("(k1 | c1) + m1").dual(),
        Err(TransformError::MassDual("m1".into()))
    );
    assert_eq!(
        layout("k1 | isolator1").dual(),
        Err(TransformError::NoElement("isolator1".into()))
    );
}

#[test]
fn like_elements_merge() {
    let merged = layout("k1 | c1 | k2 + k3 + k4").merge_like();
    assert_eq!(merged.layout.to_string(), "k1 | c1");
    assert_eq!(
        merged.values,
        [("k1".to_owned(), "k1 + 1/(1/k2 + 1/k3 + 1/k4)".to_owned())]
    );
    let merged = layout("k1 + (k2 | k3) + c1").merge_like();
    assert_eq!(
        merged.values,
        [("k1".to_owned(), "1/(1/k1 + 1/(k2 + k3))".to_owned())]
    );
    let hydraulic = Layout::parse("R1 + R2 | C1 | C2", &Kinds::new(Domain::Hydraulic))
        .unwrap()
        .merge_like();
    assert_eq!(hydraulic.layout.to_string(), "R1 | C1");
    assert_eq!(
        hydraulic.values,
        [
            ("R1".to_owned(), "R1 + R2".to_owned()),
            ("C1".to_owned(), "C1 + C2".to_owned())
        ]
    );
    assert!(
        layout("isolator1 | isolator2")
            .merge_like()
            .values
            .is_empty()
    );
    assert!(layout("m1 + m2").merge_like().values.is_empty());
}

#[test]
fn a_mass_goes_to_the_far_end() {
    let place = |text: &str| layout(text).place_mass().map(|placed| placed.to_string());
    assert_eq!(place("m1 + (k1 | c1)").unwrap(), "(k1 | c1) + m1");
    assert_eq!(place("m1").unwrap(), "m1");
    assert_eq!(place("m1 + k1 | k2 + m2").unwrap(), "k1 + m1 | k2 + m2");
    assert_eq!(place("(m1 + k1 | m2) + c1").unwrap(), "c1 + (k1 + m1 | m2)");
    assert_eq!(place("k1 | c1"), Err(TransformError::NoMass));
    assert!(matches!(
        place("m1 + k1 + m2"),
        Err(TransformError::MassesInSeries { .. })
    ));
    assert!(matches!(
        place("k1 | m1"),
        Err(TransformError::BesideMass { .. })
    ));
    assert!(!layout("k1 | m1").ends_in_mass());
}

/// Random trees of numbered names.
fn trees() -> impl Strategy<Value = Layout> {
    let leaf = prop::sample::select(vec!["k", "c", "b", "stop", "isolator"])
        .prop_map(|kind| Tree::Leaf(kind.to_owned()));
    leaf.prop_recursive(6, 40, 4, |inner| {
        prop_oneof![
            prop::collection::vec(inner.clone(), 1..4).prop_map(Tree::Series),
            prop::collection::vec(inner, 1..4).prop_map(Tree::Parallel),
        ]
    })
    .prop_map(|tree| {
        let kinds = mechanical();
        let mut number = 0;
        let tree = tree.map(&mut |kind: &String| {
            number += 1;
            kinds.branch(&format!("{kind}{number}")).unwrap()
        });
        Layout::from_tree(Domain::Translational, tree).unwrap()
    })
}

fn reversed<T: Clone>(tree: &Tree<T>) -> Tree<T> {
    match tree {
        Tree::Leaf(_) => tree.clone(),
        Tree::Series(children) => Tree::Series(children.iter().rev().map(reversed).collect()),
        Tree::Parallel(children) => Tree::Parallel(children.iter().rev().map(reversed).collect()),
    }
}

proptest! {
    #[test]
    fn printed_layouts_read_back(layout in trees()) {
        let read = Layout::parse(&layout.to_string(), &mechanical()).unwrap();
        prop_assert_eq!(read.tree(), layout.tree());
        let canonical = layout.canonical();
        let again = canonical.canonical();
        prop_assert_eq!(again.tree(), canonical.tree());
        let turned = Layout::from_tree(Domain::Translational, reversed(layout.tree())).unwrap();
        let sorted = turned.canonical();
        prop_assert_eq!(sorted.tree(), canonical.tree());
        prop_assert_eq!(&turned, &layout);
    }

    #[test]
    fn no_text_panics(text in ".*") {
        if let Err(error) = Layout::parse(&text, &mechanical()) {
            prop_assert!(text.get(error.span.start..error.span.end).is_some());
        }
    }

    #[test]
    fn no_text_of_layout_characters_panics(text in "[kcbmx1( )|+ζ]*") {
        match Layout::parse(&text, &mechanical()) {
            Ok(layout) => {
                let read = Layout::parse(&layout.to_string(), &mechanical()).unwrap();
                prop_assert_eq!(read.tree(), layout.tree());
                let _ = (layout.merge_like(), layout.dual(), layout.place_mass());
            }
            Err(error) => prop_assert!(text.get(error.span.start..error.span.end).is_some()),
        }
    }
}
