//! Time of one start: `cargo bench -p quell-search`.
#![allow(missing_docs, reason = "a benchmark binary")]

#[path = "../tests/catalogue/mod.rs"]
mod catalogue;

use catalogue::{classical, passageway, peaks};
use divan::Bencher;
use quell_search::{Problem, Settings, start};

fn main() {
    divan::main();
}

/// Sixteen starts in turn, so that the mean is over starts; the counter gives evaluations a second.
fn starts<P: Problem>(bencher: Bencher, problem: &P) {
    let settings = Settings::for_dimension(problem.variables().len());
    let run = || {
        (0..16)
            .map(|index| start(problem, &settings, 1, index).evaluations)
            .sum::<usize>()
    };
    let evaluations = run();
    bencher
        .counter(divan::counter::ItemsCount::new(evaluations))
        .bench(run);
}

const NETWORKS: [&str; 4] = ["(O+I)", "(I+(O|I))", "((O+I)|(I+I))", "(I|(I+I+I))"];

#[divan::bench(args = NETWORKS, sample_count = 10)]
fn passageways(bencher: Bencher, text: &str) {
    let networks: Vec<_> = (1..=4).flat_map(passageway::networks).collect();
    if let Some(network) = networks.iter().find(|network| network.text() == text) {
        starts(bencher, &passageway::passageway(network, true));
    }
}

#[divan::bench(args = [true, false], sample_count = 10)]
fn absorber(bencher: Bencher, gradients: bool) {
    starts(bencher, &peaks::absorber(0.05, 0.01, &[], gradients));
}

#[divan::bench(sample_count = 10)]
fn minimax_of_seven_variables(bencher: Bencher) {
    starts(bencher, &classical::wong_1());
}

#[divan::bench(sample_count = 10)]
fn hartmann_without_gradients(bencher: Bencher) {
    starts(bencher, &classical::hartmann_6().without_gradients());
}
