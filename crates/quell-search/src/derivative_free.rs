//! Derivative-free steps in the unit cube: bounded CMA-ES and projected Nelder-Mead.
//!
//! The only module that knows the optimisation library. Both methods see a scalar function that returns `None` when
//! the budget is spent; the caller keeps the best point itself.

use std::cell::RefCell;

use basin::{
    BoundedCmaEs, BoxBounds, ConstraintDescription, ConstraintSet, Constraints, CostFunction,
    DenseMatrix, Executor, NelderMead, PopulationProgress, SimplexProgress,
};

/// The budget is spent.
#[derive(Debug, thiserror::Error)]
#[error("the budget of evaluations is spent")]
struct Spent;

/// A scalar function of scaled coordinates; `None` when the budget is spent.
pub(crate) type Function<'a> = dyn FnMut(&[f64]) -> Option<f64> + 'a;

struct UnitCube<'a> {
    lower: Vec<f64>,
    upper: Vec<f64>,
    // The library evaluates through a shared reference, always on this thread.
    function: RefCell<&'a mut Function<'a>>,
}

impl<'a> UnitCube<'a> {
    fn new(dimension: usize, function: &'a mut Function<'a>) -> Self {
        Self {
            lower: vec![0.0; dimension],
            upper: vec![1.0; dimension],
            function: RefCell::new(function),
        }
    }
}

impl Constraints for UnitCube<'_> {
    type Set = ConstraintSet<BoxBounds<Vec<f64>>>;

    fn constraints(&self) -> <Self::Set as ConstraintDescription>::Borrowed<'_> {
        ConstraintSet::new().with_bounds(BoxBounds::new(Some(&self.lower), Some(&self.upper)))
    }
}

impl CostFunction for UnitCube<'_> {
    type Param = Vec<f64>;
    type Output = f64;
    type Error = Spent;

    fn cost(&self, point: &Vec<f64>) -> Result<f64, Spent> {
        (self.function.borrow_mut())(point).ok_or(Spent)
    }
}

/// Covariance matrix adaptation from `mean` with standard deviation `spread`, until the distribution is smaller than
/// `tolerance` or the function returns `None`.
///
/// Source: N. Hansen, "The CMA evolution strategy: a tutorial" (2016), with pycma's boundary penalty.
pub(crate) fn covariance_adaptation(
    seed: u64,
    mean: &[f64],
    spread: f64,
    population: usize,
    tolerance: f64,
    function: &mut Function<'_>,
) {
    if mean.is_empty() {
        return;
    }
    let solver = BoundedCmaEs::<Vec<f64>, DenseMatrix>::new(seed, spread)
        .with_lambda(population.max(4))
        .with_absolute_distribution_size_tolerance(tolerance);
    let progress = PopulationProgress::from_point(mean.to_vec());
    // An error says that the budget is spent; the caller has the best point in either case. The generation limit only
    // guards against a function that never ends.
    let _ = Executor::new(UnitCube::new(mean.len(), function), solver, progress)
        .max_iter(100_000)
        .run();
}

/// Nelder-Mead projected on the cube, from a simplex of edge `size` at `centre`, until the simplex is smaller than
/// `tolerance` or the function returns `None`.
///
/// Source: F. Gao and L. Han, "Implementing the Nelder-Mead simplex algorithm with adaptive parameters" (2012).
pub(crate) fn simplex(centre: &[f64], size: f64, tolerance: f64, function: &mut Function<'_>) {
    if centre.is_empty() {
        return;
    }
    let mut vertices = vec![centre.to_vec()];
    for i in 0..centre.len() {
        let mut vertex = centre.to_vec();
        vertex[i] += if centre[i] + size <= 1.0 { size } else { -size };
        vertex[i] = vertex[i].clamp(0.0, 1.0);
        vertices.push(vertex);
    }
    let solver = NelderMead::adaptive()
        .projected()
        .with_absolute_simplex_size_tolerance(tolerance)
        .with_relative_simplex_size_tolerance(None)
        .with_absolute_simplex_cost_tolerance(None)
        .with_relative_simplex_cost_tolerance(None);
    let progress = SimplexProgress::from_simplex(vertices);
    let _ = Executor::new(UnitCube::new(centre.len(), function), solver, progress)
        .max_iter(100_000)
        .run();
}
