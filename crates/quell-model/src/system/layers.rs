//! Unknowns that follow from equations, one group after another.

use quell_expression::{Differentiation, Graph, Slot};

use super::elimination::{Factor, plus};

/// Unknowns w with as many equations G(x, earlier w, w) = 0.
#[derive(Debug, Clone)]
pub(crate) struct Layer {
    /// Graph inputs of the unknowns.
    pub(crate) unknowns: Vec<usize>,
    /// G.
    pub(crate) residuals: Vec<Slot>,
    /// ∂G/∂w, row-major.
    pub(crate) matrix: Vec<Option<Slot>>,
    factor: Factor,
    /// w as expressions of what comes before, where G is affine in w.
    pub(crate) solution: Option<Vec<Slot>>,
}

impl Layer {
    /// Else the number of an unknown that the equations do not determine.
    pub(crate) fn new(
        graph: &mut Graph,
        unknowns: Vec<usize>,
        residuals: Vec<Slot>,
        sample: &[f64],
    ) -> Result<Self, usize> {
        let matrix = graph.jacobian(&residuals, &unknowns);
        let entries: Vec<Slot> = matrix.iter().flatten().copied().collect();
        let bends = graph.dependence(&entries);
        let affine = unknowns.iter().all(|unknown| !bends.contains(unknown));
        let factor = Factor::new(graph, &matrix, unknowns.len(), sample)?;
        let solution = affine.then(|| {
            let rest = graph.without(&residuals, &unknowns);
            let solved = factor.solve(graph, rest);
            solved
                .into_iter()
                .map(|value| match value {
                    Some(value) => graph.negate(value),
                    None => graph.constant(0.0),
                })
                .collect()
        });
        Ok(Self {
            unknowns,
            residuals,
            matrix,
            factor,
            solution,
        })
    }

    /// dw/dσ when inputs (earlier unknowns among them) move as seeded.
    fn tangent(&self, graph: &mut Graph, seeds: &[(usize, Slot)]) -> Vec<(usize, Slot)> {
        let slopes = graph.tangent(&self.residuals, seeds, Differentiation::Exact);
        if slopes.iter().all(Option::is_none) {
            return Vec::new();
        }
        let moved = self.factor.solve(graph, slopes);
        let mut found = Vec::with_capacity(moved.len());
        for (unknown, slope) in self.unknowns.iter().zip(moved) {
            if let Some(slope) = slope {
                found.push((*unknown, graph.negate(slope)));
            }
        }
        found
    }
}

/// Seeds of everything that moves when inputs do: the inputs' and those of all unknowns.
///
/// By the implicit function theorem dw = -(∂G/∂w)⁻¹ dG, with the factors that solve for w; so derivatives of any order
/// come from seeding again.
pub(crate) fn moved(
    layers: &[Layer],
    graph: &mut Graph,
    seeds: &[(usize, Slot)],
) -> Vec<(usize, Slot)> {
    let mut all = seeds.to_vec();
    for layer in layers {
        let found = layer.tangent(graph, &all);
        all.extend(found);
    }
    all
}

/// Expressions with all unknowns replaced that have an expression.
#[derive(Debug, Clone, Default)]
pub(crate) struct Closing {
    solutions: Vec<(usize, Slot)>,
}

impl Closing {
    pub(crate) fn new(layers: &[Layer], graph: &mut Graph) -> Self {
        let mut closing = Self::default();
        for layer in layers {
            let Some(solution) = &layer.solution else {
                continue;
            };
            let closed = closing.close(graph, solution);
            closing
                .solutions
                .extend(layer.unknowns.iter().copied().zip(closed));
        }
        closing
    }

    pub(crate) fn close(&self, graph: &mut Graph, roots: &[Slot]) -> Vec<Slot> {
        graph.substitute(roots, &self.solutions)
    }
}

/// Σ of products, any factor of which may be absent.
pub(crate) fn sum_of_products(
    graph: &mut Graph,
    pairs: &[(Option<Slot>, Option<Slot>)],
) -> Option<Slot> {
    let mut sum = None;
    for (a, b) in pairs {
        if let (Some(a), Some(b)) = (a, b) {
            let product = graph.multiply(*a, *b);
            sum = plus(graph, sum, Some(product));
        }
    }
    sum
}
