//! Admittances as polynomials in the elements' values, and the equations that make them equal a target.

use crate::linear::damped_solution;
use crate::polynomial::{at, degree, lowest};
use crate::{Element, RationalFunction, Tree};

/// value products (as bits of the elements) with their power of s.
type Terms = Vec<(usize, u32)>;

/// N and D of the dynamic stiffness N/D of a network in its elements' values, every coefficient one.
#[derive(Debug, Clone)]
pub(crate) struct Monomials {
    elements: usize,
    numerator: Terms,
    denominator: Terms,
}

/// Steps of one descent.
const STEPS: usize = 80;

/// Logarithms of values stay within this.
const REACH: f64 = 30.0;

/// A sum of squares of relative residuals that is rounding.
const SOLVED: f64 = 1e-26;

impl Monomials {
    /// Of a tree whose leaves number the elements.
    pub(crate) fn of_tree(tree: &Tree<usize>, elements: &[Element]) -> Self {
        let (numerator, denominator) = of_tree(tree, elements);
        Self {
            elements: elements.len(),
            numerator,
            denominator,
        }
    }

    /// Of a graph whose edges number the elements; nodes 0 and 1 are the terminals.
    pub(crate) fn of_graph(edges: &[(usize, usize)], elements: &[Element]) -> Self {
        let nodes = edges.iter().map(|(a, b)| a.max(b) + 1).max().unwrap_or(2);
        let joined: Vec<(usize, usize)> = edges
            .iter()
            .map(|(a, b)| (if *a == 1 { 0 } else { *a }, if *b == 1 { 0 } else { *b }))
            .collect();
        Self {
            elements: elements.len(),
            numerator: spanning_trees(edges, nodes, nodes - 1, elements),
            denominator: spanning_trees(&joined, nodes, nodes - 2, elements),
        }
    }

    /// Lowest and highest powers of s of N and of D.
    pub(crate) fn powers(&self) -> [(usize, usize); 2] {
        [&self.numerator, &self.denominator].map(|terms| {
            let powers = terms.iter().map(|(power, _)| *power);
            (powers.clone().min().unwrap_or(0), powers.max().unwrap_or(0))
        })
    }

    /// The network's degree for generic values.
    pub(crate) fn degree(&self) -> usize {
        let [(n0, n1), (d0, d1)] = self.powers();
        // Y = N/(s D) without common powers of s.
        let common = n0.min(d0 + 1);
        (n1 - common).max(d1 + 1 - common)
    }

    /// Whether the network behaves like the function at zero and at infinity, and is of no lower degree.
    pub(crate) fn suits(&self, target: &RationalFunction) -> bool {
        let [(n0, n1), (d0, d1)] = self.powers();
        let (p, q) = target.degrees();
        let (p0, q0) = (
            lowest(&target.numerator).unwrap_or(0),
            lowest(&target.denominator).unwrap_or(0),
        );
        n1 + q == d1 + 1 + p && n0 + q0 == d0 + 1 + p0 && self.degree() >= target.degree()
    }

    /// Y(s) for values.
    pub(crate) fn admittance(&self, values: &[f64]) -> RationalFunction {
        let logs: Vec<f64> = values.iter().map(|value| value.ln()).collect();
        let coefficients = |terms: &Terms, shift: usize| {
            let mut result = vec![0.0; shift + 1];
            for (power, mask) in terms {
                let place = power + shift;
                if result.len() <= place {
                    result.resize(place + 1, 0.0);
                }
                if let Some(entry) = result.get_mut(place) {
                    *entry += product_of(*mask, &logs);
                }
            }
            result
        };
        crate::mesh::from_ratio((
            coefficients(&self.numerator, 0),
            coefficients(&self.denominator, 1),
        ))
    }

    /// Residuals of N q - s D p = 0 over the size of their terms, and their derivatives by the logarithms of values.
    fn equations(&self, target: &RationalFunction, logs: &[f64]) -> (Vec<f64>, Vec<Vec<f64>>) {
        let [(_, n1), (_, d1)] = self.powers();
        let length = (n1 + target.denominator.len()).max(d1 + 1 + target.numerator.len());
        let mut residuals = vec![0.0; length];
        let mut slopes = vec![vec![0.0; length]; self.elements];
        let mut size = 0.0;
        for (terms, factor, shift, sign) in [
            (&self.numerator, &target.denominator, 0, 1.0),
            (&self.denominator, &target.numerator, 1, -1.0),
        ] {
            let weight: f64 = factor.iter().map(|x| x.abs()).sum();
            for (power, mask) in terms {
                let value = sign * product_of(*mask, logs);
                size += value.abs() * weight;
                for (place, coefficient) in factor.iter().enumerate() {
                    let place = power + shift + place;
                    let term = value * coefficient;
                    if let Some(entry) = residuals.get_mut(place) {
                        *entry += term;
                    }
                    for (element, slope) in slopes.iter_mut().enumerate() {
                        if mask >> element & 1 == 1
                            && let Some(entry) = slope.get_mut(place)
                        {
                            *entry += term;
                        }
                    }
                }
            }
        }
        for entry in residuals.iter_mut().chain(slopes.iter_mut().flatten()) {
            *entry /= size;
        }
        (residuals, slopes)
    }

    /// Values with which the network is the target (at unit scales), from several starts; none where no start ends in a
    /// solution.
    pub(crate) fn solve(&self, target: &RationalFunction, starts: usize) -> Option<Vec<f64>> {
        (0..starts).find_map(|start| {
            let first: Vec<f64> = (0..self.elements)
                .map(|element| 9.0 * (halton(start, element) - 0.5))
                .collect();
            self.descend(target, first)
        })
    }

    /// Levenberg and Marquardt's method.
    fn descend(&self, target: &RationalFunction, mut logs: Vec<f64>) -> Option<Vec<f64>> {
        let squares = |residuals: &[f64]| residuals.iter().map(|r| r * r).sum::<f64>();
        let (mut residuals, mut slopes) = self.equations(target, &logs);
        let mut cost = squares(&residuals);
        let mut damping = 1e-3;
        let mut earlier = cost;
        for step in 0..STEPS {
            if cost <= SOLVED {
                break;
            }
            if step % 16 == 15 {
                // Stuck far from any solution.
                if cost > 0.5 * earlier && cost > 1e-12 {
                    return None;
                }
                earlier = cost;
            }
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
            let matrix: Vec<Vec<f64>> = slopes
                .iter()
                .map(|row| slopes.iter().map(|column| dot(row, column)).collect())
                .collect();
            let right: Vec<f64> = slopes.iter().map(|row| -dot(row, &residuals)).collect();
            let next = damped_solution(&matrix, damping, &right).map(|delta| {
                logs.iter()
                    .zip(&delta)
                    .map(|(x, d)| x + d.clamp(-4.0, 4.0))
                    .collect::<Vec<f64>>()
            });
            let Some(next) = next else {
                damping = (damping * 10.0).max(1e-12);
                continue;
            };
            let (new_residuals, new_slopes) = self.equations(target, &next);
            let new_cost = squares(&new_residuals);
            if new_cost < cost {
                (logs, residuals, slopes, cost) = (next, new_residuals, new_slopes, new_cost);
                damping = (damping * 0.2).max(1e-15);
            } else {
                damping *= 8.0;
                if damping > 1e8 {
                    break;
                }
            }
            if logs.iter().any(|x| x.abs() > REACH) {
                return None;
            }
        }
        (cost <= 1e-20).then(|| logs.iter().map(|x| x.exp()).collect())
    }
}

fn product_of(mask: u32, logs: &[f64]) -> f64 {
    logs.iter()
        .enumerate()
        .filter(|(element, _)| mask >> element & 1 == 1)
        .map(|(_, log)| log)
        .sum::<f64>()
        .exp()
}

fn times(a: &Terms, b: &Terms) -> Terms {
    a.iter()
        .flat_map(|(p, m)| b.iter().map(move |(q, n)| (p + q, m | n)))
        .collect()
}

fn of_tree(tree: &Tree<usize>, elements: &[Element]) -> (Terms, Terms) {
    match tree {
        Tree::Leaf(element) => {
            let power = elements.get(*element).map_or(0, |kind| kind.power());
            (vec![(power, 1 << element)], vec![(0, 0)])
        }
        Tree::Series(children) | Tree::Parallel(children) => {
            let series = matches!(tree, Tree::Series(_));
            children
                .iter()
                .map(|child| of_tree(child, elements))
                .reduce(|a, b| {
                    let mut cross = times(&a.0, &b.1);
                    cross.extend(times(&b.0, &a.1));
                    if series {
                        (times(&a.0, &b.0), cross)
                    } else {
                        (cross, times(&a.1, &b.1))
                    }
                })
                .unwrap_or_default()
        }
    }
}

/// Every set of `size` edges that joins all nodes without a loop.
fn spanning_trees(
    edges: &[(usize, usize)],
    nodes: usize,
    size: usize,
    elements: &[Element],
) -> Terms {
    (0_u32..1 << edges.len())
        .filter(|mask| mask.count_ones() as usize == size)
        .filter(|mask| {
            let mut group: Vec<usize> = (0..nodes).collect();
            edges.iter().enumerate().all(|(place, (a, b))| {
                if mask >> place & 1 == 0 {
                    return true;
                }
                let (Some(x), Some(y)) = (group.get(*a).copied(), group.get(*b).copied()) else {
                    return false;
                };
                for entry in &mut group {
                    if *entry == x {
                        *entry = y;
                    }
                }
                x != y
            })
        })
        .map(|mask| {
            let power = elements
                .iter()
                .enumerate()
                .filter(|(place, _)| mask >> place & 1 == 1)
                .map(|(_, element)| element.power())
                .sum();
            (power, mask)
        })
        .collect()
}

/// Points that fill the unit cube evenly (Halton 1960).
pub(crate) fn halton(index: usize, dimension: usize) -> f64 {
    const PRIMES: [usize; 10] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29];
    let base = PRIMES.get(dimension % PRIMES.len()).copied().unwrap_or(2);
    let (mut rest, mut fraction, mut result) = (index + 1, 1.0, 0.0);
    while rest > 0 {
        fraction /= base as f64;
        result += fraction * (rest % base) as f64;
        rest /= base;
    }
    result
}

/// Whether a function's coefficients are all at least zero, as those of every network are.
pub(crate) fn is_nonnegative(function: &RationalFunction) -> bool {
    let all = |coefficients: &[f64]| {
        (0..=degree(coefficients)).all(|power| at(coefficients, power) >= 0.0)
    };
    all(&function.numerator) && all(&function.denominator)
}
