//! The immittance route, regular functions, counts of classes, Ladenheim's set, removals and the catalogue.
#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

use num_complex::Complex64;
use proptest::prelude::*;
use quell_network::{
    CATALOGUE, Domain, Element, Gone, ImmittanceOrder, Kinds, LadenheimStructure, Layout, Matching,
    Network, POSITIVE_REAL_TOLERANCE, PassiveFunctions, Structure, SynthesisError, counts, device,
    is_regular, ladenheim_structures,
};

#[path = "../examples/synthesis_table.rs"]
mod synthesis_table;

fn layout(text: &str) -> Layout {
    Layout::parse(text, &Kinds::new(Domain::Translational)).unwrap()
}

/// Counted by brute force over trees and coloured multigraphs; equal immittance by mutual containment.
#[test]
fn classes_are_counted() {
    for ((k, c, b), raw, irreducible, zobel, immittance) in [
        ((1, 1, 1), 8, 8, 8, 8),
        ((2, 1, 0), 6, 2, 1, 1),
        ((2, 0, 1), 6, 2, 1, 1),
        ((2, 1, 1), 34, 18, 12, 12),
        ((1, 2, 1), 34, 18, 12, 12),
        // Foster's theorem: the canonical forms of one degree are one class; lossless and relaxation networks alike.
        ((2, 2, 0), 24, 8, 4, 2),
        ((2, 0, 2), 24, 8, 4, 2),
    ] {
        let found = counts(k, c, b).unwrap();
        assert_eq!(
            (found.raw, found.irreducible, found.zobel, found.immittance),
            (raw, irreducible, zobel, immittance),
            "({k}, {c}, {b})"
        );
    }
}

/// 148 = 3 + 6 + 16 + 38 + 85 (Ladenheim 1948; Morelli and Smith 2019).
#[test]
fn the_ladenheim_set_has_148_structures() {
    let all = ladenheim_structures().unwrap();
    let size = |structure: &LadenheimStructure| match structure {
        LadenheimStructure::SeriesParallel(layout) => layout.branches().count(),
        LadenheimStructure::Bridge(labels) => labels.len(),
    };
    let sizes: Vec<usize> = (1..=5)
        .map(|n| all.iter().filter(|s| size(s) == n).count())
        .collect();
    assert_eq!(sizes, [3, 6, 16, 38, 85]);
    assert_eq!(all.len(), 148);
    for structure in &all {
        if let LadenheimStructure::Bridge(labels) = structure {
            assert!(labels.contains(&Element::Damper));
        }
    }
}

#[test]
fn the_catalogue_reads() {
    for entry in CATALOGUE {
        for part in entry.parts {
            let layout = layout(part.layout);
            assert!(Network::from_layout(&layout, None).is_ok());
            assert!(
                !layout.contains_mass() || layout.ends_in_mass(),
                "{}",
                entry.name
            );
            assert!(layout.merge_like().values.is_empty(), "{}", entry.name);
        }
        assert_eq!(
            CATALOGUE
                .iter()
                .filter(|other| other.name == entry.name)
                .count(),
            1
        );
        assert!(entry.source.chars().any(|c| c.is_ascii_digit()));
    }
    assert_eq!(device("tvmd").unwrap().text(), Some("k1 + (c1 | b1)"));
    assert!(device("TMDI").unwrap().layout().is_none());
    assert_eq!(
        CATALOGUE
            .iter()
            .filter(|d| d.title.starts_with("strut"))
            .count(),
        8
    );
}

/// Each removal is the limit of the network itself, with the branch's value very small or very large.
#[test]
fn removals_are_limits() {
    for (text, values) in [
        ("b1 | c1 + (k1 | c2)", vec![13.0, 4900.0, 1.5e5, 1000.0]),
        (
            "k1 | k2 + (c1 | k3 + b1) | c2",
            vec![3.0, 5.0, 2.0, 7.0, 1.5, 0.4],
        ),
        ("(k1 | k2 + c1) + m1", vec![3.0, 5.0, 2.0, 7.0]),
    ] {
        let full = layout(text);
        let removals = full.removals(&values);
        assert!(removals.len() >= values.len());
        for removal in removals {
            let left = removal.layout.unwrap();
            let mut extreme = values.clone();
            let place = full
                .branches()
                .position(|b| b.name == removal.branch)
                .unwrap();
            extreme[place] *= if removal.how == Gone::Free {
                1e-11
            } else {
                1e11
            };
            let (a, b) = (
                Network::from_layout(&full, None).unwrap(),
                Network::from_layout(&left, None).unwrap(),
            );
            for omega in [0.3, 2.0, 31.0] {
                let (x, y) = (
                    a.dynamic_stiffness(omega, &extreme),
                    b.dynamic_stiffness(omega, &removal.values),
                );
                assert!(
                    (x - y).norm() < 1e-5 * y.norm(),
                    "{text} without {}: {left} {x} {y}",
                    removal.branch
                );
            }
        }
    }
    let hydraulic = Layout::parse("R1 + I1", &Kinds::new(Domain::Hydraulic)).unwrap();
    // R1 and I1 in one passage share the stroke: the mechanical network is c | b, which one of them free does not undo.
    let removals = hydraulic.removals(&[]);
    assert_eq!(removals.len(), 2);
    assert!(removals.iter().all(|removal| removal.how == Gone::Free));
    let chain = layout("k1 | c1 + b1").removals(&[]);
    let lost = chain
        .iter()
        .find(|r| r.branch == "c1" && r.how == Gone::Free)
        .unwrap();
    assert_eq!(lost.lost, ["b1"]);
    assert_eq!(lost.layout.as_ref().unwrap().to_string(), "k1");
}

/// The minimum function, which is not regular, has bridges of five elements but no series-parallel network so small.
#[test]
fn bridges_are_found_where_they_are_smaller() {
    for coefficients in [
        [1.0, 1.0, 1.0, 1.0, 1.0, 4.0],
        [1.0, 1.0, 4.0, 1.0, 1.0, 1.0],
    ] {
        let y = ImmittanceOrder::Biquadratic
            .function(&coefficients)
            .unwrap();
        assert!(!is_regular(&coefficients));
        let plain = Matching {
            most_elements: 5,
            bridges: false,
            starts: 60,
        };
        assert_eq!(plain.smallest(&y).unwrap_err(), SynthesisError::NotFound(5));
        let found = Matching::default().smallest(&y).unwrap();
        for realisation in &found.realisations {
            assert!(matches!(realisation.structure, Structure::Graph(_)));
            assert_eq!(realisation.structure.elements().total(), 5);
            // Analysed back through the spanning trees of the mesh, and through its values.
            let mesh = realisation.structure.mesh().unwrap();
            assert!(mesh.admittance().distance(&y) < 1e-9);
            assert!(mesh.elements.iter().all(|e| e.value > 0.0));
            assert_eq!(mesh.branches().len(), 5);
        }
    }
}

/// Whatever is smallest for Y is smallest, with springs and inerters exchanged, for 1/Y.
#[test]
fn the_smallest_networks_of_reciprocals_are_duals() {
    for coefficients in [
        [1.0, 2.0, 1.0, 1.0, 1.0, 2.0],
        [0.0, 1.0, 1.0, 1.0, 1.0, 0.0],
        [1.0, 2.0, 0.0, 1.0, 1.0, 2.0],
    ] {
        let y = ImmittanceOrder::Biquadratic
            .function(&coefficients)
            .unwrap();
        let kinds = |y: &quell_network::RationalFunction, swapped: bool| {
            let found = Matching::default().smallest(y).unwrap();
            let mut all: Vec<(usize, usize, usize)> = found
                .realisations
                .iter()
                .map(|r| {
                    let e = r.structure.elements();
                    if swapped {
                        (e.inerters, e.dampers, e.springs)
                    } else {
                        (e.springs, e.dampers, e.inerters)
                    }
                })
                .collect();
            all.sort_unstable();
            all
        };
        assert_eq!(kinds(&y, false), kinds(&y.reciprocal(), true));
    }
}

/// The documentation's table is what the example prints now.
#[test]
fn the_table_of_the_documentation_is_current() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/synthesis.md");
    let text = std::fs::read_to_string(path).unwrap();
    let table = synthesis_table::table();
    assert!(text.contains(&table), "docs/synthesis.md lacks\n{table}");
}

/// The margin's sign is the general test's verdict.
fn agree(order: ImmittanceOrder, coefficients: &[f64]) -> Result<(), TestCaseError> {
    let margin = order.margin(coefficients);
    let y = order.function(coefficients).unwrap();
    if margin.abs() > 1e-7 {
        let verdict = y.positive_real(POSITIVE_REAL_TOLERANCE);
        prop_assert_eq!(
            margin > 0.0,
            verdict.is_positive_real(),
            "{} margin {}: {}",
            y,
            margin,
            verdict
        );
    }
    Ok(())
}

proptest! {
    #[test]
    fn margins_agree_with_the_general_test(logs in prop::collection::vec(-1.0..1.0_f64, 8)) {
        let values: Vec<f64> = logs.iter().map(|x| 10_f64.powf(*x)).collect();
        for order in [ImmittanceOrder::Bilinear, ImmittanceOrder::Biquadratic, ImmittanceOrder::Bicubic] {
            agree(order, &values[..order.coefficients()])?;
        }
    }

    /// Bicubics near their boundary: a positive-real one less a damper up to its least real part.
    #[test]
    fn bicubic_margins_change_sign_at_the_boundary(
        parameters in prop::collection::vec(-1.0..1.0_f64, 14), less in 0.9..1.1_f64,
    ) {
        let passive = PassiveFunctions { states: 3 };
        let mut parameters = parameters;
        parameters[0] = 0.0;
        let y = passive.function(&parameters);
        let verdict = y.positive_real(POSITIVE_REAL_TOLERANCE);
        prop_assert!(verdict.is_positive_real(), "{y}: {verdict}");
        let reduced: Vec<f64> = y.numerator.iter().zip(&y.denominator)
            .map(|(n, d)| n - less * verdict.least_real_part * d).collect();
        prop_assume!(y.numerator.len() == 4 && reduced.iter().all(|x| *x >= 0.0));
        let coefficients: Vec<f64> = reduced.iter().rev().chain(y.denominator.iter().rev()).copied().collect();
        prop_assume!((less - 1.0).abs() > 1e-4);
        let margin = ImmittanceOrder::Bicubic.margin(&coefficients);
        prop_assert!(margin.abs() < 1e-7 || (margin > 0.0) == (less < 1.0), "{margin} {less}");
    }

    #[test]
    fn free_parameters_give_positive_real_functions(
        logs in prop::collection::vec(-1.5..1.5_f64, 6), exact in any::<bool>(),
        states in 1_usize..5, parameters in prop::collection::vec(-1.0..1.0_f64, 26),
    ) {
        let mut free: Vec<f64> = logs.iter().map(|x| 10_f64.powf(*x)).collect();
        if exact {
            free[4] = 0.0;
        }
        let coefficients = ImmittanceOrder::Biquadratic.from_free(&free).unwrap();
        let y = ImmittanceOrder::Biquadratic.function(&coefficients).unwrap();
        let verdict = y.positive_real(1e-9);
        prop_assert!(verdict.is_positive_real(), "{y}: {verdict}");
        let passive = PassiveFunctions { states };
        prop_assert!(passive.parameters() <= 26);
        let y = passive.function(&parameters);
        let verdict = y.positive_real(1e-9);
        prop_assert!(verdict.is_positive_real(), "{y}: {verdict}");
    }
}

/// A regular biquadratic whose equations no start of the matching solves: Foster's preamble stands in.
#[test]
fn what_the_starts_of_a_matching_miss_the_preamble_gives() {
    let y = quell_network::RationalFunction::new(
        vec![
            1.409_751_388_534_242_8,
            0.791_319_652_345_888_5,
            1.194_337_399_884_556_1,
        ],
        vec![
            3.692_227_261_989_555,
            2.773_374_157_798_096_4,
            3.212_261_615_504_058,
        ],
    )
    .unwrap();
    let matching = Matching {
        most_elements: 5,
        bridges: false,
        starts: 24,
    };
    let found = matching.smallest(&y).unwrap();
    assert_eq!(found.realisations[0].structure.elements().total(), 5);
    assert!(found.realisations[0].residual < 1e-9);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(24) })]

    /// Jiang and Smith 2011: a regular biquadratic needs at most five elements, series-parallel; what series-parallel networks
    /// of two reactive elements do is regular.
    #[test]
    fn regular_biquadratics_need_five_elements(logs in prop::collection::vec(-0.7..0.7_f64, 6)) {
        let free: Vec<f64> = logs.iter().map(|x| 10_f64.powf(*x)).collect();
        let coefficients = ImmittanceOrder::Biquadratic.from_free(&free).unwrap();
        let y = ImmittanceOrder::Biquadratic.function(&coefficients).unwrap();
        let six: [f64; 6] = coefficients.try_into().unwrap();
        // By definition, on a grid of frequencies.
        let at_end = |f: &quell_network::RationalFunction| {
            let re = |w: f64| f.evaluate(Complex64::new(0.0, w)).re;
            let ends = re(0.0).min(f.numerator[2] / f.denominator[2]);
            (0..2000).all(|i| re(10_f64.powf(f64::from(i) * 0.003 - 3.0)) >= ends * (1.0 - 1e-9))
        };
        prop_assert_eq!(is_regular(&six), at_end(&y) || at_end(&y.reciprocal()), "{}", y);
        let matching = Matching { most_elements: 5, bridges: false, starts: 24 };
        let found = matching.smallest(&y);
        if is_regular(&six) {
            prop_assert!(found.is_ok(), "{y}: {found:?}");
        } else if let Ok(found) = &found {
            let reactive = found.realisations.iter().map(|r| r.structure.elements().reactive()).min();
            prop_assert!(reactive > Some(2), "{y}: {}", found.realisations[0].structure);
        }
    }
}
