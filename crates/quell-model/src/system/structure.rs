//! Which internal motions of devices are states, decided from which elements touch which nodes, never from values.
//!
//! Let U be the displacements without mass of their own: internal nodes of devices, and massless coordinates of the host.
//! An element is a row over U: how a displacement stretches it. The null spaces of three sets of rows,
//!
//! ```text
//! B = null(inertia)      no inerter or mass is stretched
//! D = null(damping)      no damper is stretched
//! N = null(stiffness)    no spring is stretched
//! ```
//!
//! split U into directions of six kinds:
//!
//! | kind | space | unknown, states |
//! | --- | --- | --- |
//! | algebraic | B ∩ D | position unknown |
//! | first | rest of B | rate unknown, position a state |
//! | first neutral | B ∩ N | rate unknown, no state |
//! | conserved | N ∩ D | acceleration unknown, no state: momentum is conserved there |
//! | second neutral | rest of N | acceleration unknown, rate a state |
//! | second | rest of U | acceleration unknown, position and rate states |
//!
//! so that the number of states is the least possible: that of the finite poles of the devices' dynamic stiffness. A
//! direction in B ∩ D ∩ N is held by nothing.
//!
//! Rows of networks are 0, 1 and -1 and stay so (their matrices are totally unimodular), so elimination is exact;
//! the tolerance only serves rows of hosts with other coefficients.
//!
//! # References
//! The index reduction is that of modified nodal analysis (R. März, 1992; C. Tischendorf, 1999), in second-order form.

/// What is smaller than this beside a row whose largest entry is one is the rounding error of its computation.
const TOLERANCE: f64 = 1e-9;

/// Rows over U: how displacements stretch what stores, dissipates and has inertia.
#[derive(Debug, Clone, Default)]
pub(crate) struct Rows {
    /// Number of displacements.
    pub(crate) size: usize,
    pub(crate) stiffness: Vec<Vec<f64>>,
    pub(crate) damping: Vec<Vec<f64>>,
    pub(crate) inertia: Vec<Vec<f64>>,
    /// Strokes whose position, and strokes whose rate, the state must tell although nothing may depend on them.
    pub(crate) watched: [Vec<Vec<f64>>; 2],
}

/// A basis of U adapted to the kinds; each direction is a vector over U.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Directions {
    pub(crate) algebraic: Vec<Vec<f64>>,
    pub(crate) first: Vec<Vec<f64>>,
    pub(crate) first_neutral: Vec<Vec<f64>>,
    pub(crate) conserved: Vec<Vec<f64>>,
    pub(crate) second: Vec<Vec<f64>>,
    pub(crate) second_neutral: Vec<Vec<f64>>,
}

impl Rows {
    /// The adapted basis; else a direction that nothing holds, as a vector over U.
    pub(crate) fn directions(&self) -> Result<Directions, Vec<f64>> {
        let (k, c, m) = (&self.stiffness, &self.damping, &self.inertia);
        let null = |sets: &[&Vec<Vec<f64>>]| {
            let rows: Vec<Vec<f64>> = sets.iter().flat_map(|set| set.iter().cloned()).collect();
            null_space(rows, self.size)
        };
        if let Some(loose) = null(&[k, c, m]).into_iter().next() {
            return Err(loose);
        }
        let [positions, rates] = &self.watched;
        let algebraic = null(&[m, c]);
        let first_neutral = null(&[m, k, positions]);
        let conserved = null(&[k, c, positions, rates]);
        let mut within = Span::new(self.size);
        within.extend(&algebraic);
        within.extend(&first_neutral);
        let first = within.extend(&null(&[m]));
        let mut neutral = Span::new(self.size);
        neutral.extend(&first_neutral);
        neutral.extend(&conserved);
        let second_neutral = neutral.extend(&null(&[k, positions]));
        within.extend(&conserved);
        within.extend(&second_neutral);
        let units: Vec<Vec<f64>> = (0..self.size).map(|i| unit(self.size, i)).collect();
        let second = within.extend(&units);
        Ok(Directions {
            algebraic,
            first,
            first_neutral,
            conserved,
            second,
            second_neutral,
        })
    }
}

impl Directions {
    /// Number of states that the internal motions add.
    #[cfg(test)]
    pub(crate) fn states(&self) -> usize {
        self.first.len() + 2 * self.second.len() + self.second_neutral.len()
    }

    /// Numbers of directions of each kind.
    pub(crate) fn counts(&self) -> [usize; 6] {
        [
            self.algebraic.len(),
            self.first.len(),
            self.first_neutral.len(),
            self.conserved.len(),
            self.second.len(),
            self.second_neutral.len(),
        ]
    }

    /// All of them: algebraic, first, first neutral, conserved, second, second neutral.
    pub(crate) fn all(&self) -> impl Iterator<Item = &Vec<f64>> {
        self.algebraic
            .iter()
            .chain(&self.first)
            .chain(&self.first_neutral)
            .chain(&self.conserved)
            .chain(&self.second)
            .chain(&self.second_neutral)
    }

    /// Components of a vector over U along all directions, in the order of [`Self::all`].
    pub(crate) fn components(&self, size: usize) -> Vec<Vec<f64>> {
        // The inverse of the matrix of directions, by elimination beside the identity.
        let columns: Vec<&Vec<f64>> = self.all().collect();
        let mut rows: Vec<Vec<f64>> = (0..size)
            .map(|i| {
                let mut row: Vec<f64> = columns.iter().map(|column| at(column, i)).collect();
                row.extend(unit(size, i));
                row
            })
            .collect();
        reduce(&mut rows, columns.len());
        rows.iter()
            .map(|row| row.iter().skip(columns.len()).copied().collect())
            .collect()
    }
}

/// y with minimal Σ (row·y + given)², rows over the free displacements: y = P·given, as rows of P.
///
/// Where nothing decides, zero.
pub(crate) fn least_squares(rows: &[Vec<f64>], size: usize) -> Vec<Vec<f64>> {
    // Normal equations beside -Rᵀ; entries are small whole numbers for networks.
    let mut system: Vec<Vec<f64>> = (0..size)
        .map(|i| {
            let mut line: Vec<f64> = (0..size)
                .map(|j| rows.iter().map(|row| at(row, i) * at(row, j)).sum())
                .collect();
            line.extend(rows.iter().map(|row| -at(row, i)));
            line
        })
        .collect();
    let pivots = reduce(&mut system, size);
    let mut solution = vec![vec![0.0; rows.len()]; size];
    for (row, column) in pivots.iter().enumerate() {
        if let (Some(target), Some(source)) = (solution.get_mut(*column), system.get(row)) {
            *target = source.iter().skip(size).copied().collect();
        }
    }
    solution
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let sum: f64 = a.iter().zip(b).map(|(x, y)| x * y).sum();
    if sum.abs() < TOLERANCE { 0.0 } else { sum }
}

pub(crate) fn unit(size: usize, index: usize) -> Vec<f64> {
    let mut vector = vec![0.0; size];
    if let Some(entry) = vector.get_mut(index) {
        *entry = 1.0;
    }
    vector
}

fn at(row: &[f64], index: usize) -> f64 {
    row.get(index).copied().unwrap_or(0.0)
}

/// Gauss-Jordan elimination on the first `columns` columns; the pivot's column of each row.
fn reduce(rows: &mut [Vec<f64>], columns: usize) -> Vec<usize> {
    for row in rows.iter_mut() {
        let largest = row
            .iter()
            .take(columns)
            .fold(0.0_f64, |most, x| most.max(x.abs()));
        if largest > 0.0 {
            for entry in row.iter_mut() {
                *entry /= largest;
            }
        }
    }
    let mut pivots = Vec::new();
    for column in 0..columns {
        let place = pivots.len();
        let best = (place..rows.len())
            .max_by(|a, b| {
                let size = |i: &usize| rows.get(*i).map_or(0.0, |row| at(row, column).abs());
                // Of equals the first, so that the basis does not depend on more than the rows.
                size(a).total_cmp(&size(b)).then_with(|| b.cmp(a))
            })
            .filter(|best| {
                rows.get(*best)
                    .is_some_and(|row| at(row, column).abs() > TOLERANCE)
            });
        let Some(best) = best else { continue };
        rows.swap(place, best);
        let Some(mut pivot) = rows.get(place).cloned() else {
            continue;
        };
        let size = at(&pivot, column);
        for entry in &mut pivot {
            *entry /= size;
        }
        for (index, row) in rows.iter_mut().enumerate() {
            let factor = at(row, column);
            if index == place {
                row.clone_from(&pivot);
            } else if factor != 0.0 {
                for (entry, other) in row.iter_mut().zip(&pivot) {
                    *entry -= factor * other;
                    if entry.abs() < TOLERANCE {
                        *entry = 0.0;
                    }
                }
            }
        }
        pivots.push(column);
    }
    pivots
}

/// A basis of the vectors that every row maps to zero: the identity on the columns without pivot.
fn null_space(mut rows: Vec<Vec<f64>>, size: usize) -> Vec<Vec<f64>> {
    let pivots = reduce(&mut rows, size);
    (0..size)
        .filter(|column| !pivots.contains(column))
        .map(|free| {
            let mut vector = unit(size, free);
            for (row, pivot) in rows.iter().zip(&pivots) {
                if let Some(entry) = vector.get_mut(*pivot) {
                    *entry = 0.0 - at(row, free);
                }
            }
            vector
        })
        .collect()
}

/// A growing space.
struct Span {
    size: usize,
    vectors: Vec<Vec<f64>>,
}

impl Span {
    const fn new(size: usize) -> Self {
        Self {
            size,
            vectors: Vec::new(),
        }
    }

    /// Adds those vectors that are not in the span yet, and returns them.
    fn extend(&mut self, candidates: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let mut added = Vec::new();
        for candidate in candidates {
            let mut tried = self.vectors.clone();
            tried.push(candidate.clone());
            if reduce(&mut tried, self.size).len() > self.vectors.len() {
                self.vectors.push(candidate.clone());
                added.push(candidate.clone());
            }
        }
        added
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use quell_network::{
        Budget, Domain, Enumeration, Equivalence, Kinds, Layout, Mechanism, Network, Node,
    };

    use super::*;

    /// Rows of a device whose terminals are prescribed.
    fn rows(mechanism: &Mechanism) -> Rows {
        let size = mechanism.internal_nodes();
        let mut rows = Rows {
            size,
            ..Rows::default()
        };
        for element in mechanism.elements() {
            let mut row = vec![0.0; size];
            if let Node::Internal(node) = element.from {
                row[node] += 1.0;
            }
            if let Node::Internal(node) = element.to {
                row[node] -= 1.0;
            }
            if element.law.is_spring_like() {
                rows.stiffness.push(row.clone());
            }
            if element.law.is_damper_like() {
                rows.damping.push(row.clone());
            }
            if element.law.is_inertial() {
                rows.inertia.push(row);
            }
        }
        rows
    }

    fn counts(text: &str) -> [usize; 6] {
        let layout = Layout::parse(text, &Kinds::new(Domain::Translational)).unwrap();
        let mechanism = Mechanism::from_layout(&layout, None).unwrap();
        rows(&mechanism).directions().unwrap().counts()
    }

    #[test]
    fn small_networks() {
        assert_eq!(counts("k1 + k2"), [1, 0, 0, 0, 0, 0]);
        assert_eq!(counts("k1 + c1"), [0, 1, 0, 0, 0, 0]);
        assert_eq!(counts("c1 + c2"), [0, 0, 1, 0, 0, 0]);
        assert_eq!(counts("b1 + b2"), [0, 0, 0, 1, 0, 0]);
        assert_eq!(counts("k1 + b1"), [0, 0, 0, 0, 1, 0]);
        assert_eq!(counts("c1 + b1"), [0, 0, 0, 0, 0, 1]);
        assert_eq!(counts("k1 + c1 + b1"), [0, 1, 0, 0, 0, 1]);
    }

    #[test]
    fn every_small_network_has_the_states_of_its_order() {
        let budgets = [Budget::any("k"), Budget::any("c"), Budget::any("b")];
        let kinds = Kinds::new(Domain::Translational);
        for branches in 1..=5 {
            let all = Enumeration::new(&kinds, &budgets, Some(branches), Equivalence::Commutative)
                .unwrap();
            for index in 0..all.count() {
                let network = Network::from_layout(&all.nth(index).unwrap(), None).unwrap();
                let found = rows(&Mechanism::from(&network)).directions().unwrap();
                assert_eq!(
                    found.states(),
                    network.order().poles,
                    "{}",
                    all.nth(index).unwrap()
                );
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]
        #[test]
        fn large_networks_have_the_states_of_their_order(branches in 6_usize..16, place in 0.0..1.0_f64) {
            let budgets = [Budget::any("k"), Budget::any("c"), Budget::any("b")];
            let kinds = Kinds::new(Domain::Translational);
            let all = Enumeration::new(&kinds, &budgets, Some(branches), Equivalence::Commutative).unwrap();
            let index = ((all.count() as f64 * place) as u128).min(all.count() - 1);
            let layout = all.nth(index).unwrap();
            let network = Network::from_layout(&layout, None).unwrap();
            let rows = rows(&Mechanism::from(&network));
            let found = rows.directions().unwrap();
            prop_assert_eq!(found.states(), network.order().poles, "{}", layout);
            prop_assert_eq!(found.all().count(), rows.size);
            // Directions and components are inverse to each other, in whole numbers.
            let components = found.components(rows.size);
            for (i, direction) in found.all().enumerate() {
                for (j, component) in components.iter().enumerate() {
                    prop_assert_eq!(dot(component, direction), f64::from(u8::from(i == j)));
                }
            }
            for direction in found.all() {
                prop_assert!(direction.iter().all(|entry| [-1.0, 0.0, 1.0].contains(entry)));
            }
        }
    }

    #[test]
    fn what_nothing_holds_is_named() {
        let loose = Rows {
            size: 2,
            stiffness: vec![vec![1.0, -1.0]],
            ..Rows::default()
        };
        assert_eq!(loose.directions(), Err(vec![1.0, 1.0]));
    }

    #[test]
    fn least_squares_close_what_can_be_closed() {
        // One spring from the head (given x) to the node: y = x.
        assert_eq!(least_squares(&[vec![-1.0]], 1), [[1.0]]);
        // Nothing decides.
        assert_eq!(least_squares(&[], 1), [[0.0; 0]]);
    }
}
