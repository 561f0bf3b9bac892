//! A right-hand side as a plain closure: where a wheel on a trailing arm begins to shimmy, and how far the motion is stable.
//!
//! Derivatives are differences, so results say that they are approximate and carry no normal forms.
//! `cargo run -p quell-continuation --example closure`
#![allow(clippy::print_stdout)] // an example prints

use quell_continuation::{
    Closure, ContinuationError, Kind, Settings, cycles_from_hopf, equilibria,
};

fn main() -> Result<(), ContinuationError> {
    // Swivel angle ψ, its rate, and the lateral deflection y of the tyre, at the speed V: stiffness and damping of the swivel,
    // a stretched string for the tyre, a side force that saturates.
    let wheel = Closure::new(3, 1, |_t, x: &[f64], p: &[f64], out: &mut [f64]| {
        let (psi, rate, y, speed) = (x[0], x[1], x[2], p[0]);
        let (arm, half, relaxation) = (0.1, 0.1, 0.3);
        let slip = (y / relaxation).atan();
        let force = 400.0 * (4.0 * slip).tanh();
        out[0] = rate;
        out[1] = -(100.0 * psi.sin() + 3.0 * rate + force * arm);
        out[2] = speed * psi.sin() + (arm - half) * psi.cos() * rate - speed * y / relaxation;
    });
    let settings = Settings::new(&[(1.0, 60.0)]);
    let straight = equilibria(&wheel, &[0.0; 3], &[1.0], 0, &settings)?;
    println!("straight running: {:?}", straight.stop);
    for hopf in straight.of(Kind::Hopf) {
        println!(
            "{} at V = {:.4} m/s, {:.3} rad/s",
            hopf.label,
            hopf.solution.parameters[0],
            hopf.omega.unwrap_or(f64::NAN)
        );
        let shimmy = cycles_from_hopf(&wheel, hopf, 0, &settings)?;
        for special in &shimmy.special {
            println!(
                "  {} at V = {:.4} m/s",
                special.label, special.solution.parameters[0]
            );
        }
        if let Some(largest) = shimmy
            .points
            .iter()
            .map(|point| (point.solution.range(0).1, point.solution.parameters[0]))
            .max_by(|a, b| a.0.total_cmp(&b.0))
        {
            println!(
                "  largest swivel {:.3} rad at V = {:.3} m/s",
                largest.0, largest.1
            );
        }
    }
    Ok(())
}
