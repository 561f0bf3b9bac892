//! Runs a study from Rust and prints its best designs: `cargo run --release -p quell-study --example shortlist -- STUDY`.
#![allow(clippy::print_stdout, reason = "an example shows its result")]

use std::path::Path;
use std::time::Instant;

use quell_study::{Findings, RunSettings, Silent, Study};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments
        .next()
        .unwrap_or_else(|| "studies/engine-mount-linear.toml".to_owned());
    let seed = arguments
        .next()
        .and_then(|seed| seed.parse().ok())
        .unwrap_or(1);
    let started = Instant::now();
    let study = Study::read(Path::new(&path)).map_err(|fault| fault.render())?;
    let settings = RunSettings {
        seed,
        ..RunSettings::default()
    };
    let outcome = quell_study::run(&study, &settings, &Silent)?;
    for task in &outcome.tasks {
        for point in &task.points {
            match &point.findings {
                Findings::Evaluate(configurations) => {
                    for one in configurations {
                        println!("{} {}: {:?}", task.name, one.name, one.criteria);
                    }
                }
                Findings::Design(found) => {
                    for design in found.designs.iter().take(6) {
                        println!(
                            "{} {}: {} = {:.6}, {} of {} starts, {} evaluations, {}",
                            task.name,
                            design.configuration.name,
                            found.objective,
                            design.objective,
                            design.starts_agreeing,
                            design.starts,
                            design.evaluations,
                            design.status
                        );
                    }
                }
                Findings::Continuation(found) => {
                    println!(
                        "{}: {} branches, {}",
                        task.name,
                        found.branches.len(),
                        found.status
                    );
                }
                Findings::Front(found) => {
                    for (layout, point) in found.common() {
                        println!(
                            "{} {}: {:?}",
                            task.name, layout.layout, point.design.configuration.criteria
                        );
                    }
                }
            }
        }
    }
    let engine = &outcome.results.engine;
    println!(
        "{} evaluations, {:.2} s",
        engine.evaluations,
        started.elapsed().as_secs_f64()
    );
    Ok(())
}
