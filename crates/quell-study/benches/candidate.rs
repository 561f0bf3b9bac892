//! Time of one candidate evaluation (peak over the band) and of one with all peaks and gradients, single-threaded.
//!
//!     cargo bench -p quell-study --bench candidate
//!
//! `candidate_numpy.py` beside this file times the same evaluation in NumPy, for the ratio.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a benchmark without its study ends by panic"
)]

use std::path::Path;

use divan::counter::ItemsCount;
use quell_search::{Pieces, Problem};
use quell_study::{DesignProblem, Study};

fn main() {
    divan::main();
}

const LAYOUTS: [&str; 3] = [
    "track1",
    "track1 + (track2 | restriction1)",
    "track1 + restriction1 + (track2 | restriction2)",
];

fn problem(layout: &str) -> DesignProblem {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../studies/engine-mount-linear.toml");
    let study = Study::read(&path).unwrap();
    ["one", "three", "four"]
        .iter()
        .flat_map(|task| quell_study::problems(&study, task).unwrap())
        .find(|(label, _)| label == layout)
        .map_or_else(|| panic!("no candidate {layout}"), |(_, problem)| problem)
}

/// Points spread over the box by a fixed irrational stride: no two alike, the same in every run.
fn points(problem: &DesignProblem) -> Vec<Vec<f64>> {
    (0..1000)
        .map(|index| {
            problem
                .variables()
                .iter()
                .enumerate()
                .map(|(place, variable)| {
                    let share =
                        (0.5 + f64::from(index) * 0.618_034 * (place as f64 + 1.0).sqrt()).fract();
                    variable.value(share)
                })
                .collect()
        })
        .collect()
}

#[divan::bench(args = LAYOUTS)]
fn evaluation(bencher: divan::Bencher<'_, '_>, layout: &str) {
    let problem = problem(layout);
    let points = points(&problem);
    let mut scratch = problem.scratch();
    bencher
        .counter(ItemsCount::new(points.len()))
        .bench_local(|| {
            points
                .iter()
                .map(|point| problem.evaluate(point, &mut [], &mut scratch))
                .sum::<f64>()
        });
}

#[divan::bench(args = LAYOUTS)]
fn pieces(bencher: divan::Bencher<'_, '_>, layout: &str) {
    let problem = problem(layout);
    let points = points(&problem);
    let mut scratch = problem.scratch();
    let mut pieces = Pieces::new(problem.variables().len());
    bencher
        .counter(ItemsCount::new(points.len()))
        .bench_local(|| {
            points
                .iter()
                .filter(|point| problem.pieces(point, 0.5, &mut pieces, &mut scratch))
                .count()
        });
}
