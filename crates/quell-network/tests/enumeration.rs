//! Enumeration against published counts and against independent generation.
#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

use std::collections::BTreeSet;

use proptest::prelude::*;
use quell_network::{Budget, Domain, Enumeration, EnumerationError, Equivalence, Kinds, Layout};

fn mechanical(k: usize, c: usize, b: usize, equivalence: Equivalence) -> Enumeration {
    let budgets = [
        Budget::exactly("k", k),
        Budget::exactly("c", c),
        Budget::exactly("b", b),
    ];
    Enumeration::new(
        &Kinds::new(Domain::Translational),
        &budgets,
        None,
        equivalence,
    )
    .unwrap()
}

fn passages() -> Kinds {
    let mut kinds = Kinds::new(Domain::Hydraulic);
    kinds.declare_component("track").unwrap();
    kinds.declare_component("restriction").unwrap();
    kinds
}

/// Two-terminal series-parallel networks: MacMahon (1892), Riordan and Shannon (1942), OEIS A000084.
#[test]
fn topologies_are_as_many_as_published() {
    let counts: Vec<u128> = (1..=10)
        .map(|n| Enumeration::topologies(n).unwrap().count())
        .collect();
    assert_eq!(counts, [1, 2, 4, 10, 24, 66, 180, 522, 1532, 4624]);
    assert_eq!(Enumeration::topologies(0).unwrap().count(), 0);
}

/// Counts by tree generation and by coloured multigraphs (both of them brute force) of (k, c, b).
#[test]
fn element_budgets_are_as_many_as_counted_by_brute_force() {
    for ((k, c, b), raw, irreducible) in [
        ((1, 1, 0), 2, 2),
        ((2, 1, 0), 6, 2),
        ((1, 1, 1), 8, 8),
        ((2, 1, 1), 34, 18),
        ((2, 2, 0), 24, 8),
        ((3, 1, 0), 18, 2),
        ((3, 1, 1), 136, 32),
        ((2, 2, 1), 180, 76),
        ((3, 2, 0), 88, 16),
        ((3, 2, 1), 856, 216),
        ((3, 3, 0), 394, 58),
        ((2, 2, 2), 1150, 414),
    ] {
        assert_eq!(
            mechanical(k, c, b, Equivalence::Commutative).count(),
            raw,
            "raw ({k}, {c}, {b})"
        );
        assert_eq!(
            mechanical(k, c, b, Equivalence::Irreducible).count(),
            irreducible,
            "irreducible ({k}, {c}, {b})"
        );
    }
}

/// Networks of passageways (Y. Li, doctoral thesis, chapter 6): 59 of one to four branches with at least one track.
#[test]
fn components_of_several_elements_do_not_merge() {
    let count = |branches, equivalence| {
        let budgets = [
            Budget::any("track").at_least(1).single_element(false),
            Budget::any("restriction"),
        ];
        Enumeration::new(&passages(), &budgets, Some(branches), equivalence)
            .unwrap()
            .count()
    };
    assert_eq!(
        [1, 2, 3, 4].map(|n| count(n, Equivalence::Irreducible)),
        [1, 4, 12, 42]
    );
    assert_eq!(
        [1, 2, 3, 4].map(|n| count(n, Equivalence::Commutative)),
        [1, 4, 16, 70]
    );
    let all = |branches| {
        let budgets = [
            Budget::any("track").single_element(false),
            Budget::any("restriction"),
        ];
        Enumeration::new(
            &passages(),
            &budgets,
            Some(branches),
            Equivalence::Commutative,
        )
        .unwrap()
        .count()
    };
    assert_eq!([1, 2, 3, 4].map(all), [2, 6, 20, 80]);
}

#[test]
fn names_are_numbered_from_left_to_right() {
    let budgets = [
        Budget::exactly("restriction", 1),
        Budget::exactly("track", 2).single_element(false),
    ];
    let all = Enumeration::new(&passages(), &budgets, None, Equivalence::Irreducible).unwrap();
    let texts: Vec<String> = all.iter().map(|layout| layout.to_string()).collect();
    assert_eq!(
        texts,
        [
            "track1 + track2 + restriction1",
            "track1 + (track2 | restriction1)",
            "restriction1 + (track1 | track2)",
            "track1 | track2 | restriction1",
            "track1 | track2 + restriction1",
            "restriction1 | track1 + track2",
        ]
    );
    let avoiding = all.avoiding(["track1", "restriction2"]);
    assert_eq!(
        avoiding.nth(0).unwrap().to_string(),
        "track2 + track3 + restriction1"
    );
}

#[test]
fn ranges_list_every_size() {
    let budgets = [Budget::any("k").at_most(2), Budget::any("c").at_most(1)];
    let all = Enumeration::new(
        &Kinds::new(Domain::Translational),
        &budgets,
        None,
        Equivalence::Commutative,
    )
    .unwrap();
    // k, c, then kk, kc of two branches, then kkc: 1 + 1 + 2 + 2 + 6.
    assert_eq!(all.count(), 12);
    assert_eq!(all.nth(0).unwrap().to_string(), "k1");
    assert_eq!(all.nth(1).unwrap().to_string(), "c1");
    assert_eq!(all.nth(12), None);
}

#[test]
fn wrong_budgets_are_refused() {
    let kinds = passages();
    let list = |budgets: &[Budget], branches| {
        Enumeration::new(&kinds, budgets, branches, Equivalence::Commutative).map(|all| all.count())
    };
    assert!(matches!(
        list(&[Budget::any("trak")], Some(2)),
        Err(EnumerationError::UnknownKind { .. })
    ));
    assert!(matches!(
        list(&[Budget::any("track")], None),
        Err(EnumerationError::Unbounded(_))
    ));
    assert!(matches!(
        list(&[Budget::any("R"), Budget::any("R")], Some(2)),
        Err(EnumerationError::Twice(_))
    ));
    assert!(matches!(
        list(&[Budget::exactly("R", 1).at_least(2)], Some(2)),
        Err(EnumerationError::Range { .. })
    ));
    assert!(matches!(
        list(&[Budget::any("R")], Some(1000)),
        Err(EnumerationError::TooMany)
    ));
    assert!(matches!(
        list(&[Budget::exactly("R", usize::MAX)], None),
        Err(EnumerationError::TooMany)
    ));
    let many: Vec<Budget> = ["R", "I", "C", "track", "restriction"]
        .map(Budget::any)
        .into();
    assert!(matches!(
        list(&many, Some(60)),
        Err(EnumerationError::TooMany)
    ));
    // Impossible demands list nothing.
    assert_eq!(list(&[Budget::exactly("R", 1)], Some(2)), Ok(0));
    assert_eq!(list(&[Budget::any("R").at_least(3)], Some(2)), Ok(0));
    assert_eq!(list(&[], Some(2)), Ok(0));
}

/// All trees of given leaves by splitting the leaves in two and joining the halves in series and in parallel; the
/// canonical text with numbers struck out tells equal ones.
fn generate(leaves: &[char]) -> BTreeSet<String> {
    fn texts(leaves: &[String]) -> BTreeSet<String> {
        if let [only] = leaves {
            return BTreeSet::from([only.clone()]);
        }
        let mut all = BTreeSet::new();
        for mask in 1..(1_u32 << leaves.len()) - 1 {
            let side = |wanted: bool| -> Vec<String> {
                leaves
                    .iter()
                    .enumerate()
                    .filter(|(i, _)| (mask >> i & 1 == 1) == wanted)
                    .map(|(_, leaf)| leaf.clone())
                    .collect()
            };
            for left in texts(&side(true)) {
                for right in texts(&side(false)) {
                    all.insert(format!("({left}) + ({right})"));
                    all.insert(format!("({left}) | ({right})"));
                }
            }
        }
        let kinds = Kinds::new(Domain::Translational);
        all.iter()
            .map(|text| Layout::parse(text, &kinds).unwrap().canonical().to_string())
            .collect()
    }
    let names: Vec<String> = leaves
        .iter()
        .enumerate()
        .map(|(i, kind)| format!("{kind}{i}"))
        .collect();
    texts(&names)
        .iter()
        .map(|text| text.chars().filter(|c| !c.is_ascii_digit()).collect())
        .collect()
}

#[test]
fn enumeration_lists_what_brute_force_generates() {
    for (k, c, b) in [
        (1, 1, 0),
        (2, 1, 0),
        (2, 1, 1),
        (2, 2, 0),
        (2, 2, 1),
        (3, 1, 1),
        (4, 1, 0),
    ] {
        let leaves: Vec<char> = [('k', k), ('c', c), ('b', b)]
            .into_iter()
            .flat_map(|(kind, n)| std::iter::repeat_n(kind, n))
            .collect();
        let expected = generate(&leaves);
        let listed: Vec<String> = mechanical(k, c, b, Equivalence::Commutative)
            .iter()
            .map(|layout| {
                layout
                    .to_string()
                    .chars()
                    .filter(|c| !c.is_ascii_digit())
                    .collect()
            })
            .collect();
        let distinct: BTreeSet<String> = listed.iter().cloned().collect();
        assert_eq!(distinct.len(), listed.len());
        assert_eq!(distinct, expected);
        // Irreducible ones are those that merging leaves alone.
        let kept = mechanical(k, c, b, Equivalence::Commutative)
            .iter()
            .filter(|layout| layout.merge_like().values.is_empty())
            .count();
        assert_eq!(
            kept as u128,
            mechanical(k, c, b, Equivalence::Irreducible).count()
        );
    }
}

proptest! {
    #[test]
    fn every_layout_is_canonical_and_unranked_alike(k in 0_usize..4, c in 0_usize..4, b in 0_usize..4, at in 0.0..1.0_f64) {
        let all = mechanical(k, c, b, Equivalence::Irreducible);
        prop_assume!(all.count() > 0);
        let index = ((all.count() as f64 * at) as u128).min(all.count() - 1);
        let layout = all.nth(index).unwrap();
        prop_assert_eq!(layout.canonical().to_string(), layout.to_string());
        prop_assert_eq!(layout.branches().count(), k + c + b);
        let read = Layout::parse(&layout.to_string(), &Kinds::new(Domain::Translational)).unwrap();
        prop_assert_eq!(read, layout.clone());
        prop_assert_eq!(all.iter().nth(usize::try_from(index).unwrap()), Some(layout));
    }
}
