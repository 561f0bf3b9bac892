//! The crate on its own: the equilibria of a self-excited oscillator and the cycles born on them.
//!
//! `cargo run -p quell-continuation --example branch`
#![allow(clippy::print_stdout)] // an example prints

use quell_continuation::{
    ContinuationError, Kind, Problem, Settings, cycles_from_hopf, equilibria,
};

/// x'' - (mu + x² - x⁴) x' + x = 0.
struct Oscillator;

impl Problem for Oscillator {
    fn states(&self) -> usize {
        2
    }
    fn parameters(&self) -> usize {
        1
    }
    fn value(&self, _t: f64, x: &[f64], p: &[f64], out: &mut [f64]) {
        out[0] = x[1];
        out[1] = (p[0] + x[0].powi(2) - x[0].powi(4)) * x[1] - x[0];
    }
    fn jacobian(&self, _t: f64, x: &[f64], p: &[f64], out: &mut [f64]) {
        out[0] = 0.0;
        out[1] = 1.0;
        out[2] = (2.0 * x[0] - 4.0 * x[0].powi(3)) * x[1] - 1.0;
        out[3] = p[0] + x[0].powi(2) - x[0].powi(4);
    }
    fn parameter_derivative(&self, _t: f64, x: &[f64], _p: &[f64], _k: usize, out: &mut [f64]) {
        out[0] = 0.0;
        out[1] = x[1];
    }
}

fn main() -> Result<(), ContinuationError> {
    let settings = Settings::new(&[(-0.5, 0.5)]);
    let rest = equilibria(&Oscillator, &[0.0, 0.0], &[-0.5], 0, &settings)?;
    for point in rest.of(Kind::Hopf) {
        println!(
            "{} at mu = {:.9}",
            point.label, point.solution.parameters[0]
        );
        let cycles = cycles_from_hopf(&Oscillator, point, 0, &settings)?;
        for special in &cycles.special {
            println!(
                "  {} at mu = {:.9}, T = {:.9}",
                special.label, special.solution.parameters[0], special.solution.period
            );
        }
    }
    Ok(())
}
