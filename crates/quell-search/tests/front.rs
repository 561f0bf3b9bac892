//! Fronts against closed forms.
#![allow(missing_docs, reason = "a test binary")]
#![expect(
    clippy::unwrap_used,
    reason = "a test whose problem is wrong has failed"
)]

use proptest::collection::vec;
use proptest::prelude::*;
use quell_search::{Pieces, Problem, Scale, Settings, Variable, efficient, epsilon_levels, search};

/// `f1 = |x|^2` and `f2 = |x - a|^2`, the one chosen to be minimised, the other below a bound or not at all.
///
/// The efficient points lie between 0 and a, so the front is `sqrt(f1) + sqrt(f2) = |a|`.
struct Pair {
    variables: [Variable; 2],
    minimised: usize,
    bound: Option<f64>,
}

const A: [f64; 2] = [3.0, 4.0];

impl Pair {
    fn new(minimised: usize, bound: Option<f64>) -> Self {
        let variable = |name| Variable::new(name, -10.0, 10.0, Scale::Linear).unwrap();
        Self {
            variables: [variable("x"), variable("y")],
            minimised,
            bound,
        }
    }

    fn values(x: &[f64]) -> [f64; 2] {
        [
            x[0].powi(2) + x[1].powi(2),
            (x[0] - A[0]).powi(2) + (x[1] - A[1]).powi(2),
        ]
    }

    fn gradients(x: &[f64]) -> [[f64; 2]; 2] {
        [
            [2.0 * x[0], 2.0 * x[1]],
            [2.0 * (x[0] - A[0]), 2.0 * (x[1] - A[1])],
        ]
    }
}

impl Problem for Pair {
    type Scratch = ();
    fn scratch(&self) {}
    fn variables(&self) -> &[Variable] {
        &self.variables
    }
    fn constraints(&self) -> usize {
        usize::from(self.bound.is_some())
    }
    fn evaluate(&self, x: &[f64], constraints: &mut [f64], (): &mut ()) -> f64 {
        let values = Self::values(x);
        if let (Some(bound), Some(out)) = (self.bound, constraints.first_mut()) {
            *out = (values[1 - self.minimised] - bound) / bound;
        }
        values[self.minimised]
    }
    fn pieces(&self, x: &[f64], _: f64, pieces: &mut Pieces, (): &mut ()) -> bool {
        let (values, gradients) = (Self::values(x), Self::gradients(x));
        let one = self.minimised;
        pieces
            .push_objective(values[one])
            .copy_from_slice(&gradients[one]);
        if let Some(bound) = self.bound {
            let other = 1 - one;
            let gradient = pieces.push_constraint(0, (values[other] - bound) / bound);
            for (out, slope) in gradient.iter_mut().zip(gradients[other]) {
                *out = slope / bound;
            }
        }
        true
    }
}

#[test]
fn the_front_of_two_quadratics_is_the_closed_one() {
    let settings = Settings {
        // f1 ends at zero, where relative agreement means nothing.
        magnitude: 1.0,
        ..Settings::for_dimension(2)
    };
    let mut points = Vec::new();
    let ends: Vec<[f64; 2]> = [0, 1]
        .into_iter()
        .map(|one| Pair::values(&search(&Pair::new(one, None), &settings, 0).point))
        .collect();
    // Of the second objective: ideal at its own optimum, nadir at that of the first.
    let (ideal, nadir) = (ends[1][1], ends[0][1]);
    assert!(ideal < 1e-9 && (nadir - 25.0).abs() < 1e-6, "{ends:?}");
    points.extend(ends.iter().map(|end| end.to_vec()));
    for level in epsilon_levels(&[ideal], &[nadir], 11) {
        let outcome = search(&Pair::new(0, Some(level[0])), &settings, 0);
        assert!(outcome.feasible && outcome.starts_agreeing > 1);
        points.push(Pair::values(&outcome.point).to_vec());
    }
    assert_eq!(points.len(), 11);
    assert_eq!(efficient(&points), [true; 11]);
    for point in &points {
        // A bound may be overstepped by 1e-6 of itself: half of that in the root.
        let sum = point[0].sqrt() + point[1].sqrt();
        assert!((sum - 5.0).abs() < 5e-5, "{point:?}: {sum}");
    }
}

#[test]
fn levels_of_three_objectives_are_a_grid_without_the_ideal() {
    let levels = epsilon_levels(&[0.0, 10.0], &[2.0, 30.0], 3);
    assert_eq!(levels, [[1.0, 20.0], [1.0, 30.0], [2.0, 20.0], [2.0, 30.0]]);
    // No conflict in the second: nothing to step over.
    let levels = epsilon_levels(&[0.0, 10.0], &[2.0, 10.0], 3);
    assert_eq!(levels, [[1.0, 10.0], [2.0, 10.0]]);
    assert_eq!(epsilon_levels(&[0.0], &[1.0], 3), [[0.5]]);
}

proptest! {
    /// The definition, spelled out by brute force, on small integers so that points often tie.
    #[test]
    fn efficient_points_are_those_of_the_definition(raw in vec(vec(0_i32..4, 3), 0..12)) {
        let points: Vec<Vec<f64>> = raw.iter().map(|p| p.iter().map(|v| f64::from(*v)).collect()).collect();
        let found = efficient(&points);
        for (index, point) in raw.iter().enumerate() {
            let worse = |other: &Vec<i32>| (0..3).all(|i| other[i] <= point[i]) && other != point;
            let repeated = raw[..index].contains(point);
            prop_assert_eq!(found[index], !raw.iter().any(worse) && !repeated);
        }
    }
}

#[test]
fn numbers_that_are_none_are_on_no_front_and_hide_nothing() {
    let points = [
        vec![f64::NAN, 0.0],
        vec![1.0, 1.0],
        vec![f64::NEG_INFINITY, 0.0],
    ];
    assert_eq!(efficient(&points), [false, true, false]);
}
