//! What can be simulated.

/// A system of first-order differential equations x' = f(t, x) with the signals that are observed on it.
///
/// Methods take `&mut self` so that an implementation may keep its work space. They must be functions of (t, x) alone: the
/// integrators evaluate at trial states that are not on the solution, and in any order. A value that does not exist (the
/// root of a negative number in a trial step) may be NaN; the step is then rejected or the run ends as diverged.
pub trait Dynamics {
    /// Number n of states.
    fn states(&self) -> usize;

    /// Rates x' = f(t, x), n numbers.
    fn rates(&mut self, t: f64, x: &[f64], rates: &mut [f64]);

    /// ∂f/∂x, row-major, n × n.
    ///
    /// As provided: central differences with steps of the cube root of the machine epsilon times |x_i| (or 1e-3 of the
    /// largest state where x_i is smaller), good to about ten digits of the larger entries. Stiff integration converges with
    /// such a matrix; implement it where derivatives are known.
    fn jacobian(&mut self, t: f64, x: &[f64], jacobian: &mut [f64]) {
        let n = self.states();
        let largest = x
            .iter()
            .fold(0.0_f64, |largest, value| largest.max(value.abs()));
        let mut shifted = x.to_vec();
        let (mut above, mut below) = (vec![0.0; n], vec![0.0; n]);
        for j in 0..n {
            let size = x[j].abs().max(1e-3 * largest).max(1e-8);
            let step = f64::EPSILON.cbrt() * size;
            shifted[j] = x[j] + step;
            let upper = shifted[j];
            self.rates(t, &shifted, &mut above);
            shifted[j] = x[j] - step;
            let width = upper - shifted[j];
            self.rates(t, &shifted, &mut below);
            shifted[j] = x[j];
            for i in 0..n {
                jacobian[i * n + j] = (above[i] - below[i]) / width;
            }
        }
    }

    /// Number of signals that [`watch`](Self::watch) fills.
    fn signals(&self) -> usize {
        0
    }

    /// Everything that an event or an observer reads, in one call.
    fn watch(&mut self, _t: f64, _x: &[f64], _signals: &mut [f64]) {}

    /// Number of switching functions.
    fn switches(&self) -> usize {
        0
    }

    /// Functions of (t, x) whose zeros are the places where the rates have a kink or a jump. Their crossings are located and
    /// the integration starts anew there.
    fn switch_values(&mut self, _t: f64, _x: &[f64], _values: &mut [f64]) {}

    /// Where within the piece around (t, x), bounded by zeros of the switching functions, the rates are exactly A x + b with
    /// constant A (row-major, n × n) and b (n): fills both and returns true. Such a piece is propagated by matrix exponentials.
    fn affine(&mut self, _t: f64, _x: &[f64], _a: &mut [f64], _b: &mut [f64]) -> bool {
        false
    }

    /// Times at which the rates have a jump or a kink whatever the state is, in any order: the edges of a pulse, the corners
    /// of a polygon. No step goes across one, and the integration starts anew there.
    fn breakpoints(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Between which two times everything is asked for from now on. At its ends that is what holds inside, on either side of
    /// a jump there. None: any time, and at a breakpoint what holds after it.
    fn within(&mut self, _piece: Option<(f64, f64)>) {}
}

impl<D: Dynamics + ?Sized> Dynamics for &mut D {
    fn states(&self) -> usize {
        (**self).states()
    }
    fn rates(&mut self, t: f64, x: &[f64], rates: &mut [f64]) {
        (**self).rates(t, x, rates);
    }
    fn jacobian(&mut self, t: f64, x: &[f64], jacobian: &mut [f64]) {
        (**self).jacobian(t, x, jacobian);
    }
    fn signals(&self) -> usize {
        (**self).signals()
    }
    fn watch(&mut self, t: f64, x: &[f64], signals: &mut [f64]) {
        (**self).watch(t, x, signals);
    }
    fn switches(&self) -> usize {
        (**self).switches()
    }
    fn switch_values(&mut self, t: f64, x: &[f64], values: &mut [f64]) {
        (**self).switch_values(t, x, values);
    }
    fn affine(&mut self, t: f64, x: &[f64], a: &mut [f64], b: &mut [f64]) -> bool {
        (**self).affine(t, x, a, b)
    }
    fn breakpoints(&self) -> Vec<f64> {
        (**self).breakpoints()
    }
    fn within(&mut self, piece: Option<(f64, f64)>) {
        (**self).within(piece);
    }
}
