//! Derivatives of functions that cannot be looked into.

use super::{Exactness, VectorFunction};

/// A plain function, with central differences for its Jacobian.
///
/// Column j is (f(x + h e_j) - f(x - h e_j))/2h with h = ∛ε max(|x_j|, scale_j): the truncation h² f‴/6 and the rounding
/// ε f/h are then both about ε^⅔, some ten digits for a smooth function whose argument has moderate scale.
#[derive(Debug, Clone)]
pub struct FiniteDifferences<F> {
    function: F,
    outputs: usize,
    scales: Vec<f64>,
    point: Vec<f64>,
    above: Vec<f64>,
    below: Vec<f64>,
}

impl<F: FnMut(&[f64], &mut [f64])> FiniteDifferences<F> {
    /// A function of as many inputs as `scales`, each the size of changes that matter for its input (1 will often do).
    pub fn new(function: F, scales: Vec<f64>, outputs: usize) -> Self {
        Self {
            function,
            outputs,
            point: vec![0.0; scales.len()],
            above: vec![0.0; outputs],
            below: vec![0.0; outputs],
            scales,
        }
    }
}

impl<F: FnMut(&[f64], &mut [f64])> VectorFunction for FiniteDifferences<F> {
    fn inputs(&self) -> usize {
        self.scales.len()
    }

    fn outputs(&self) -> usize {
        self.outputs
    }

    fn value(&mut self, inputs: &[f64], outputs: &mut [f64]) {
        for (index, own) in self.point.iter_mut().enumerate() {
            *own = inputs.get(index).copied().unwrap_or(f64::NAN);
        }
        (self.function)(&self.point, &mut self.above);
        for (output, value) in outputs.iter_mut().zip(&self.above) {
            *output = *value;
        }
    }

    fn jacobian(&mut self, inputs: &[f64], outputs: &mut [f64], jacobian: &mut [f64]) {
        self.value(inputs, outputs);
        let columns = self.scales.len();
        for column in 0..columns {
            let here = self.point[column];
            let step = f64::EPSILON.cbrt() * here.abs().max(self.scales[column].abs());
            let (up, down) = (here + step, here - step);
            self.point[column] = up;
            (self.function)(&self.point, &mut self.above);
            self.point[column] = down;
            (self.function)(&self.point, &mut self.below);
            self.point[column] = here;
            for (row, (above, below)) in self.above.iter().zip(&self.below).enumerate() {
                if let Some(entry) = jacobian.get_mut(row * columns + column) {
                    *entry = (above - below) / (up - down);
                }
            }
        }
    }

    fn exactness(&self) -> Exactness {
        Exactness::Approximate
    }
}
