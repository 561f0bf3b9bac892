//! Systems of `quell-model` can be simulated.

use quell_model::system::Prepared;

use crate::transient::Dynamics;

impl Dynamics for Prepared<'_> {
    fn states(&self) -> usize {
        self.system().states().len()
    }

    fn rates(&mut self, t: f64, x: &[f64], rates: &mut [f64]) {
        Prepared::rates(self, t, x, rates);
    }

    fn jacobian(&mut self, t: f64, x: &[f64], jacobian: &mut [f64]) {
        self.state_matrix(t, x, jacobian);
    }

    fn signals(&self) -> usize {
        self.system().signals()
    }

    fn watch(&mut self, t: f64, x: &[f64], signals: &mut [f64]) {
        Prepared::signals(self, t, x, signals);
    }

    fn switches(&self) -> usize {
        self.system().switches()
    }

    fn switch_values(&mut self, t: f64, x: &[f64], values: &mut [f64]) {
        Prepared::switches(self, t, x, values);
    }

    fn affine(&mut self, t: f64, x: &[f64], a: &mut [f64], b: &mut [f64]) -> bool {
        Prepared::affine(self, t, x, a, b)
    }

    fn breakpoints(&self) -> Vec<f64> {
        Prepared::breakpoints(self)
    }

    fn within(&mut self, piece: Option<(f64, f64)>) {
        Prepared::within(self, piece);
    }
}
