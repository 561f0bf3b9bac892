//! Evaluation against closed forms, a nodal solution, central differences and properties of passive networks.
#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]
#![expect(
    clippy::needless_range_loop,
    reason = "eliminations read best by index"
)]

use num_complex::Complex64;
use proptest::prelude::*;
use quell_network::{
    Budget, Domain, Element, Enumeration, Equivalence, Kinds, Layout, Network, NetworkError, Node,
    Part, PartShare, RatioGrid, Workspace,
};

fn layout(text: &str) -> Layout {
    Layout::parse(text, &Kinds::new(Domain::Translational)).unwrap()
}

fn network(text: &str) -> Network {
    Network::from_layout(&layout(text), None).unwrap()
}

fn j(x: f64) -> Complex64 {
    Complex64::new(0.0, x)
}

#[track_caller]
fn close(a: Complex64, b: Complex64, tolerance: f64) {
    let size = a.norm().max(b.norm());
    assert!(
        a == b || (a - b).norm() <= tolerance * size,
        "{a} and {b} differ by {:e}",
        (a - b).norm() / size
    );
}

#[test]
fn closed_forms_of_small_networks() {
    // Sums and quotients of three terms: a few rounding errors.
    let tolerance = 1e-14;
    let (k, c, b, w) = (300.0, 7.0, 2.5, 11.0);
    close(
        network("k1 | c1 | b1").dynamic_stiffness(w, &[k, c, b]),
        k + j(w * c) - w * w * b,
        tolerance,
    );
    let series =
        1.0 / (1.0 / Complex64::from(k) + 1.0 / j(w * c) - 1.0 / Complex64::from(w * w * b));
    close(
        network("k1 + c1 + b1").dynamic_stiffness(w, &[k, c, b]),
        series,
        tolerance,
    );
    // A tuned viscous mass damper: spring in series with (spring | damper | inerter).
    let inner = 40.0 + j(w * c) - w * w * b;
    close(
        network("k2 + (k1 | c1 | b1)").dynamic_stiffness(w, &[k, 40.0, c, b]),
        k * inner / (k + inner),
        tolerance,
    );
    // A mass on a spring and damper seen from the base.
    let suspension = k + j(w * c);
    let inertia = Complex64::from(-w * w * b);
    close(
        network("(k1 | c1) + m1").dynamic_stiffness(w, &[k, c, b]),
        suspension * inertia / (suspension + inertia),
        tolerance,
    );
}

#[test]
fn zeros_poles_and_rest_are_ordinary() {
    // k = b = 1 at ω = 1: spring beside inerter is free, spring and inerter in series are rigid.
    assert_eq!(
        network("k1 | b1").dynamic_stiffness(1.0, &[1.0, 1.0]),
        Complex64::ZERO
    );
    let pole = network("k1 + b1");
    assert_eq!(pole.ratio(1.0, &[1.0, 1.0]).1, Complex64::ZERO);
    assert_eq!(pole.dynamic_stiffness(1.0, &[1.0, 1.0]).re, f64::INFINITY);
    // Two rigid branches side by side are 0/0 in N and D, and rigid; two free ones in series are free.
    let rigid = network("k1 + b1 | k2 + b2");
    assert_eq!(rigid.ratio(1.0, &[1.0; 4]).1, Complex64::ZERO);
    assert_ne!(rigid.ratio(1.0, &[1.0; 4]).0, Complex64::ZERO);
    assert_eq!(
        network("(k1 | b1) + (k2 | b2)").dynamic_stiffness(1.0, &[1.0; 4]),
        Complex64::ZERO
    );
    // A pole inside a network: the damper takes the whole stroke.
    close(
        network("(k1 + b1) + c1").dynamic_stiffness(1.0, &[1.0, 1.0, 3.0]),
        j(3.0),
        1e-15,
    );
    // At rest.
    assert_eq!(
        network("c1 + b1").dynamic_stiffness(0.0, &[2.0, 3.0]),
        Complex64::ZERO
    );
    assert_eq!(
        network("k1 + c1 + b1").dynamic_stiffness(0.0, &[2.0, 3.0, 1.0]),
        Complex64::ZERO
    );
    assert_eq!(
        network("k1 | c1 + b1").dynamic_stiffness(0.0, &[2.0, 3.0, 1.0]),
        Complex64::from(2.0)
    );
    let chain = network("k1 + c1 + b1");
    let share = |name: &str| chain.stroke_share(chain.part(name).unwrap(), 0.0, &[2.0, 3.0, 1.0]);
    assert_eq!(
        [share("k1"), share("c1"), share("b1")],
        [0.0, 0.0, 1.0].map(Complex64::from)
    );
    let mut gradient = [Complex64::ZERO; 3];
    let stiffness = network("k1 | c1 + b1").gradient(
        0.0,
        &[2.0, 3.0, 1.0],
        &mut Workspace::new(),
        &mut gradient,
    );
    assert_eq!(
        (stiffness, gradient),
        (Complex64::from(2.0), [1.0, 0.0, 0.0].map(Complex64::from))
    );
    // A limit is taken where two free parts in series leave the strokes open: by symmetry each takes half.
    let free = network("(k1 | b1) + (k2 | b2)");
    close(
        free.stroke_share(free.part("k1").unwrap(), 1.0, &[1.0; 4]),
        Complex64::from(0.5),
        1e-7,
    );
}

#[test]
fn too_few_values_are_not_a_number() {
    assert!(network("k1 | c1").dynamic_stiffness(1.0, &[1.0]).is_nan());
}

#[test]
fn large_networks_neither_overflow_nor_underflow() {
    // A ladder of 200 equal springs and dampers; values far apart.
    for (stiff, damp) in [(1e40, 1e-40), (1e-45, 1e45), (1e45, 1e45), (1e-45, 1e-45)] {
        let mut text = "k0".to_owned();
        for i in 1..60 {
            text = format!("({text} | c{i}) + k{i}");
        }
        let ladder = network(&text);
        let values: Vec<f64> = ladder
            .elements()
            .iter()
            .map(|element| {
                if element.element == Element::Spring {
                    stiff
                } else {
                    damp
                }
            })
            .collect();
        let mut expected = Complex64::from(stiff);
        for _ in 1..60 {
            let sum = expected + j(damp);
            expected = 1.0 / (1.0 / sum + 1.0 / stiff);
        }
        // 120 operations of a few roundings each.
        close(ladder.dynamic_stiffness(1.0, &values), expected, 1e-13);
    }
}

/// Hydraulic passageways under a piston (Y. Li, doctoral thesis, chapter 6): k1 = Ap²/C1 in series with
/// k2 = Ap²/C2 beside the dual of the passageway; a track is a damper Ap² R beside an inerter Ap² I.
#[test]
fn hydraulic_layouts_become_mechanical_networks() {
    let hydraulic = Layout::parse("C1 | C2 + (I1 + R1)", &Kinds::new(Domain::Hydraulic)).unwrap();
    assert_eq!(
        Network::from_layout(&hydraulic, None).unwrap_err(),
        NetworkError::NoPiston
    );
    for area in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(
            Network::from_layout(&hydraulic, Some(area)).unwrap_err(),
            NetworkError::PistonArea
        );
    }
    let area = 2.5e-3;
    let network = Network::from_layout(&hydraulic, Some(area)).unwrap();
    let own = [3.0e-11, 2.6e-9, 3.8e6, 1.05e8];
    let values: Vec<f64> = network
        .elements()
        .iter()
        .zip(own)
        .map(|(element, own)| element.own_to_mechanical(own))
        .collect();
    for (value, expected) in
        values
            .iter()
            .zip([area * area / 3.0e-11, area * area / 2.6e-9, 23.75, 656.25])
    {
        assert!((value / expected - 1.0).abs() < 1e-14);
    }
    for (element, own) in network.elements().iter().zip(own) {
        assert!(
            (element.mechanical_to_own(element.own_to_mechanical(own)) / own - 1.0).abs() < 1e-15
        );
        let step = 1e-6 * own;
        let difference = (element.own_to_mechanical(own + step)
            - element.own_to_mechanical(own - step))
            / (2.0 * step);
        // Second-order differences at a relative step of 1e-6: 1e-12 truncated, 1e-10 rounded.
        assert!((difference / element.derivative(own) - 1.0).abs() < 1e-9);
    }
    for w in [0.3, 10.0, 117.0, 900.0] {
        let z = j(w) * 3.8e6 + 1.05e8 + 1.0 / (j(w) * 2.6e-9);
        // G = Ap s Zt/(1 + C1 s Zt), times Ap for the force; poles and zeros cost a few digits.
        let expected = area * area * j(w) * z / (1.0 + 3.0e-11 * j(w) * z);
        close(network.dynamic_stiffness(w, &values), expected, 1e-12);
    }
}

/// Force-current analogy: Y(s) = I/V.
#[test]
fn electrical_layouts_become_mechanical_networks() {
    let circuit = Layout::parse("R1 + L1 | C1", &Kinds::new(Domain::Electrical)).unwrap();
    let network = Network::from_layout(&circuit, None).unwrap();
    let own = [50.0, 0.2, 1e-5];
    let values: Vec<f64> = network
        .elements()
        .iter()
        .zip(own)
        .map(|(element, own)| element.own_to_mechanical(own))
        .collect();
    let w = 300.0;
    let admittance = 1.0 / (50.0 + j(w) * 0.2) + j(w) * 1e-5;
    close(
        network.dynamic_stiffness(w, &values) / j(w),
        admittance,
        1e-14,
    );
    close(
        network.admittance(&values).evaluate(j(w)),
        admittance,
        1e-14,
    );
}

#[test]
fn rational_functions_print_and_reduce() {
    assert_eq!(
        network("k1 | c1").admittance(&[1.0, 2.0]).to_string(),
        "(s + 0.5)/(0.5 s)"
    );
    let series = network("c1 + b1").admittance(&[1.0, 1.0]);
    assert_eq!(series.to_string(), "(s)/(s + 1)");
    assert_eq!(series.degrees(), (1, 1));
    assert_eq!(series.degree(), 1);
}

#[test]
fn orders_of_small_networks() {
    for (text, poles, at_zero, at_infinity) in [
        ("k1", 0, 0, 0),
        ("c1", 0, 1, 1),
        ("k1 | c1 | b1", 0, 0, 2),
        ("k1 + c1", 1, 1, 0),
        ("k1 + b1", 2, 2, 0),
        ("c1 + b1", 1, 2, 1),
        ("(k1 | c1) + m1", 2, 2, 1),
        ("k1 | k2 + c1 + b1", 2, 0, 0),
        ("k2 + (k1 | c1 | b1)", 2, 0, 0),
        ("k1 + k2", 0, 0, 0),
    ] {
        let order = network(text).order();
        assert_eq!(
            (order.poles, order.at_zero, order.at_infinity),
            (poles, at_zero, at_infinity),
            "{text}"
        );
        assert_eq!(order.zeros, order.poles + order.at_infinity);
    }
}

/// Solves the dense complex system A x = b by elimination with partial pivoting.
fn solve(mut a: Vec<Vec<Complex64>>, mut b: Vec<Complex64>) -> Vec<Complex64> {
    let n = b.len();
    for column in 0..n {
        let pivot = (column..n)
            .max_by(|p, q| a[*p][column].norm().total_cmp(&a[*q][column].norm()))
            .unwrap();
        a.swap(column, pivot);
        b.swap(column, pivot);
        for row in column + 1..n {
            let factor = a[row][column] / a[column][column];
            for k in column..n {
                let x = a[column][k];
                a[row][k] -= factor * x;
            }
            let x = b[column];
            b[row] -= factor * x;
        }
    }
    for row in (0..n).rev() {
        for k in row + 1..n {
            let x = b[k];
            b[row] -= a[row][k] * x;
        }
        b[row] /= a[row][row];
    }
    b
}

/// Dynamic stiffness and strokes of every part for a unit displacement of the head, by nodal analysis.
fn nodal_solution(
    network: &Network,
    w: f64,
    values: &[f64],
) -> (Complex64, Vec<(String, Complex64)>) {
    let nodal = network.nodal();
    let n = nodal.internal_nodes;
    let (mut a, mut b) = (vec![vec![Complex64::ZERO; n]; n], vec![Complex64::ZERO; n]);
    let stiffness = |element: Element, value: f64| value * j(w).powu(element.power() as u32);
    for branch in &nodal.branches {
        let d = stiffness(branch.element, values[branch.value]);
        for (node, other) in [(branch.from, branch.to), (branch.to, branch.from)] {
            let Node::Internal(row) = node else { continue };
            a[row][row] += d;
            match other {
                Node::Internal(column) => a[row][column] -= d,
                Node::Head => b[row] += d,
                Node::Tail => {}
            }
        }
    }
    let x = solve(a, b);
    let at = |node: Node| match node {
        Node::Head => Complex64::ONE,
        Node::Tail => Complex64::ZERO,
        Node::Internal(index) => x[index],
    };
    let force = nodal
        .branches
        .iter()
        .filter(|branch| branch.from == Node::Head)
        .map(|branch| {
            stiffness(branch.element, values[branch.value]) * (Complex64::ONE - at(branch.to))
        })
        .sum();
    let strokes = nodal
        .parts
        .iter()
        .map(|(name, (from, to))| (name.clone(), at(*from) - at(*to)))
        .collect();
    (force, strokes)
}

/// Any layout of so many branches, with values between 0.1 and 10 and a frequency.
fn devices(
    branches: std::ops::RangeInclusive<usize>,
) -> impl Strategy<Value = (Layout, Network, Vec<f64>, f64)> {
    (
        branches,
        0.0..1.0_f64,
        prop::collection::vec(-1.0..1.0_f64, 8),
        0.1..10.0_f64,
    )
        .prop_map(|(n, at, exponents, w)| {
            let budgets = ["k", "c", "b"].map(Budget::any);
            let kinds = Kinds::new(Domain::Translational);
            let all =
                Enumeration::new(&kinds, &budgets, Some(n), Equivalence::Commutative).unwrap();
            let layout = all
                .nth(((all.count() as f64 * at) as u128).min(all.count() - 1))
                .unwrap();
            let network = Network::from_layout(&layout, None).unwrap();
            let values = exponents
                .iter()
                .take(n)
                .map(|exponent| 10.0_f64.powf(*exponent))
                .collect();
            (layout, network, values, w)
        })
}

/// How much worse than its terms the result of a network is conditioned: |D| N'|D'... measured by the sum of the
/// sensitivities Σ |value dD/dvalue| / |D|.
fn condition(network: &Network, w: f64, values: &[f64]) -> f64 {
    let mut gradient = vec![Complex64::ZERO; values.len()];
    let stiffness = network.gradient(w, values, &mut Workspace::new(), &mut gradient);
    gradient
        .iter()
        .zip(values)
        .map(|(g, v)| g.norm() * v)
        .sum::<f64>()
        / stiffness.norm()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    /// Tolerance: rounding of about 10 operations, amplified near resonances by the condition of the result, of both
    /// ways of computing (the nodal matrix may be worse conditioned than the result: three digits in hand).
    #[test]
    fn nodal_analysis_agrees((layout, network, values, w) in devices(1..=8)) {
        let (force, strokes) = nodal_solution(&network, w, &values);
        let stiffness = network.dynamic_stiffness(w, &values);
        let condition = condition(&network, w, &values);
        prop_assume!(condition < 1e4);
        let tolerance = 1e-11 * condition.max(1.0);
        prop_assert!((force - stiffness).norm() <= tolerance * stiffness.norm(), "{layout}: {force} {stiffness}");
        for (name, stroke) in strokes {
            let share = network.stroke_share(network.part(&name).unwrap(), w, &values);
            prop_assert!((share - stroke).norm() <= 10.0 * tolerance * stroke.norm().max(1.0), "{layout} {name}: {share} {stroke}");
        }
    }

    #[test]
    fn admittances_are_positive_real((layout, network, values, w) in devices(1..=8)) {
        let admittance = network.dynamic_stiffness(w, &values) / j(w);
        // Rounding can make the real part of a lossless network slightly negative.
        prop_assert!(admittance.re >= -1e-10 * admittance.norm() * condition(&network, w, &values).max(1.0), "{layout}: {admittance}");
        // In the open right half-plane the real part is strictly positive.
        let s = Complex64::new(0.3 * w, w);
        prop_assert!(network.admittance(&values).evaluate(s).re > 0.0);
    }

    #[test]
    fn duals_have_the_reciprocal_admittance((layout, network, values, w) in devices(1..=8)) {
        let dual = Network::from_layout(&layout.dual().unwrap(), None).unwrap();
        let reciprocals: Vec<f64> = values.iter().map(|value| 1.0 / value).collect();
        let admittance = network.dynamic_stiffness(w, &values) / j(w);
        let product = admittance * dual.dynamic_stiffness(w, &reciprocals) / j(w);
        let tolerance = 1e-11 * condition(&network, w, &values).max(1.0);
        prop_assert!((product - 1.0).norm() < tolerance, "{layout}: {product}");
    }

    /// Central differences with a relative step of 1e-5: truncation 1e-10 times third derivatives, rounding 1e-11.
    #[test]
    fn gradients_agree_with_central_differences((layout, network, values, w) in devices(1..=8)) {
        let mut gradient = vec![Complex64::ZERO; values.len()];
        let stiffness = network.gradient(w, &values, &mut Workspace::new(), &mut gradient);
        let condition = condition(&network, w, &values);
        prop_assume!(condition < 30.0);
        prop_assert!((stiffness - network.dynamic_stiffness(w, &values)).norm() <= 1e-13 * condition.max(1.0) * stiffness.norm());
        for i in 0..values.len() {
            let moved = |factor: f64| {
                let mut values = values.clone();
                values[i] *= factor;
                network.dynamic_stiffness(w, &values)
            };
            let h = 1e-5;
            let difference = (moved(1.0 + h) - moved(1.0 - h)) / (2.0 * h * values[i]);
            let size = stiffness.norm() / values[i];
            prop_assert!((difference - gradient[i]).norm() < 1e-5 * size.max(gradient[i].norm()), "{layout} {i}: {difference} {}", gradient[i]);
        }
        // Stiffness is homogeneous of degree one in the values (Euler).
        let sum: Complex64 = gradient.iter().zip(&values).map(|(g, v)| g * v).sum();
        prop_assert!((sum - stiffness).norm() <= 1e-12 * condition.max(1.0) * stiffness.norm());
    }

    #[test]
    fn gradient_ratio_is_the_gradient((_, network, values, w) in devices(1..=8)) {
        let (mut gradient, mut scaled) = (vec![Complex64::ZERO; values.len()], vec![Complex64::ZERO; values.len()]);
        let mut workspace = Workspace::new();
        network.gradient(w, &values, &mut workspace, &mut gradient);
        let (_, denominator) = network.gradient_ratio(w, &values, &mut workspace, &mut scaled);
        for (g, s) in gradient.iter().zip(&scaled) {
            prop_assert!((g * denominator * denominator - s).norm() <= 1e-14 * s.norm());
        }
    }

    #[test]
    fn grids_equal_the_scalar_form_to_the_last_bit((_, network, values, w) in devices(1..=8), count in 0_usize..40) {
        let omegas: Vec<f64> = (0..count).map(|i| w * i as f64).collect();
        let (mut workspace, mut grid) = (Workspace::new(), RatioGrid::new());
        network.ratio_grid(&omegas, &values, &mut workspace, &mut grid);
        prop_assert_eq!(grid.len(), count);
        for (i, omega) in omegas.iter().enumerate() {
            prop_assert_eq!(grid.get(i), Some(network.ratio(*omega, &values)));
        }
        prop_assert_eq!(grid.get(count), None);
    }

    #[test]
    fn rational_functions_agree((layout, network, values, w) in devices(1..=8)) {
        let admittance = network.admittance(&values);
        let expected = network.dynamic_stiffness(w, &values) / j(w);
        let tolerance = 1e-9 * condition(&network, w, &values).max(1.0);
        // Polynomials of degree 16 lose digits that the network's rules keep.
        prop_assert!((admittance.evaluate(j(w)) - expected).norm() <= tolerance * expected.norm(), "{layout}");
        prop_assert!(admittance.numerator.iter().chain(&admittance.denominator).all(|c| *c >= 0.0));
        let order = network.order();
        // Y = N/(s D), so a pole at zero is gained or a zero lost.
        let (numerator, denominator) = admittance.degrees();
        prop_assert_eq!(numerator + 1, denominator + order.at_infinity);
        prop_assert_eq!(denominator, if order.at_zero == 0 { order.poles + 1 } else { order.poles });
    }

    /// The number of poles is that of the polynomials, which have no common root for generic values: the resultant,
    /// as the determinant of the Sylvester matrix, is not zero.
    #[test]
    fn nothing_but_powers_of_s_cancels((layout, network, values, _) in devices(1..=6)) {
        let admittance = network.admittance(&values);
        let (p, q) = (&admittance.numerator, &admittance.denominator);
        let (m, n) = (p.len() - 1, q.len() - 1);
        let size = m + n;
        let mut rows = vec![vec![0.0; size]; size];
        for i in 0..n { for (k, x) in p.iter().rev().enumerate() { rows[i][i + k] = *x; } }
        for i in 0..m { for (k, x) in q.iter().rev().enumerate() { rows[n + i][i + k] = *x; } }
        // Rows to unit length, then elimination with full pivoting; the smallest pivot tells the distance to singularity.
        for row in &mut rows {
            let norm = row.iter().map(|x| x * x).sum::<f64>().sqrt();
            for x in row.iter_mut() {
                *x /= norm;
            }
        }
        let mut smallest = f64::INFINITY;
        for step in 0..size {
            let (r, c) = (step..size).flat_map(|r| (step..size).map(move |c| (r, c)))
                .max_by(|a, b| rows[a.0][a.1].abs().total_cmp(&rows[b.0][b.1].abs())).unwrap();
            rows.swap(step, r);
            for row in &mut rows { row.swap(step, c); }
            smallest = smallest.min(rows[step][step].abs());
            for r in step + 1..size {
                let factor = rows[r][step] / rows[step][step];
                for c in step..size { let x = rows[step][c]; rows[r][c] -= factor * x; }
            }
        }
        // A cancellation would leave rounding errors only.
        prop_assert!(smallest > 1e-13, "{layout}: {admittance}, smallest pivot {smallest:e}");
    }

    #[test]
    fn canonical_and_merged_layouts_are_the_same_network((layout, network, values, w) in devices(1..=8)) {
        let expected = network.dynamic_stiffness(w, &values);
        let tolerance = 1e-11 * condition(&network, w, &values).max(1.0) * expected.norm();
        let scope: Vec<(&str, f64)> = network.elements().iter().zip(&values).map(|(e, v)| (e.name.as_str(), *v)).collect();
        let merged = layout.merge_like();
        let smaller = Network::from_layout(&merged.layout, None).unwrap();
        let values: Vec<f64> = smaller.elements().iter().map(|element| {
            match merged.values.iter().find(|(name, _)| *name == element.name) {
                Some((_, text)) => evaluate(text, &scope),
                None => scope.iter().find(|(name, _)| *name == element.name).unwrap().1,
            }
        }).collect();
        prop_assert!((smaller.dynamic_stiffness(w, &values) - expected).norm() <= tolerance, "{layout} -> {}", merged.layout);
        prop_assert!(merged.layout.merge_like().values.is_empty());
    }
}

/// Values of sums and reciprocals of names.
fn evaluate(text: &str, scope: &[(&str, f64)]) -> f64 {
    struct Names<'a>(&'a [(&'a str, f64)]);
    impl quell_expression::Scope for Names<'_> {
        fn quantity(&self, name: &str) -> Option<quell_expression::Quantity> {
            self.0
                .iter()
                .find(|(known, _)| *known == name)
                .map(|(_, value)| quell_expression::Quantity::number(*value))
        }
        fn names(&self) -> Vec<&str> {
            self.0.iter().map(|(name, _)| *name).collect()
        }
    }
    // The dimension of the 1 in a reciprocal does not matter: all are numbers here.
    quell_expression::Expression::parse(text)
        .unwrap()
        .evaluate(&Names(scope))
        .unwrap()
        .value
}

#[test]
fn several_parts_share_one_sweep() {
    let network = network("k1 | c1 + b1");
    let parts: Vec<Part> = ["k1", "c1", "b1"]
        .iter()
        .map(|name| network.part(name).unwrap())
        .collect();
    let values = [5.0, 2.0, 3.0];
    let mut shares = [PartShare::default(); 3];
    network.part_shares(&parts, 1.3, &values, &mut Workspace::new(), &mut shares);
    assert_eq!(shares[0].stroke_share(), Complex64::ONE);
    close(
        shares[1].stroke_share() + shares[2].stroke_share(),
        Complex64::ONE,
        1e-15,
    );
    close(
        shares[0].force_share() + shares[1].force_share(),
        Complex64::ONE,
        1e-15,
    );
    close(shares[1].force_share(), shares[2].force_share(), 1e-15);
    for (share, part) in shares.iter().zip(parts) {
        assert_eq!(
            share.stroke_share(),
            network.stroke_share(part, 1.3, &values)
        );
        assert_eq!(share.force_share(), network.force_share(part, 1.3, &values));
    }
}
