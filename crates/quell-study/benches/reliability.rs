//! Evaluations and seconds to a reliable optimum: over 20 seeds, how many evaluations pass until a feasible point within 1e-3
//! of the best known value is met.
//!
//!     cargo bench -p quell-study --bench reliability [-- PROBLEM ...]
//!     cargo bench -p quell-study --bench reliability -- serve PROBLEM
//!
//! The second form answers points on its standard input, for other optimisers on the same objective: `reliability.py` beside
//! this file runs differential evolution, CMA-ES and NLopt that way.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a benchmark without its study ends by panic, and prints its table"
)]

use std::io::{BufRead, Write};
use std::path::Path;
use std::sync::Mutex;
use std::time::Instant;

use quell_search::{Pieces, Problem, Settings, Variable, start};
use quell_study::{DesignProblem, Study};

/// Best known values (SI) are those that all methods together found in runs a hundred times as long as the ones measured.
struct Case {
    name: &'static str,
    study: &'static str,
    task: &'static str,
    layout: &'static str,
    best: f64,
}

const CASES: [Case; 5] = [
    // The peak of a two-mass system: two equal maxima.
    Case {
        name: "absorber",
        study: "tuned-mass-damper",
        task: "peak",
        layout: "(k1 | c1) + m1",
        best: ABSORBER,
    },
    // Four geometries of fluid passageways, three equal maxima, several basins.
    Case {
        name: "passageways",
        study: "engine-mount-linear",
        task: "four",
        layout: "track1 + (restriction1 | track2 + track3)",
        best: PASSAGEWAYS,
    },
    // A norm over all frequencies, many flat directions.
    Case {
        name: "ride",
        study: "quarter-car",
        task: "comfort",
        layout: "k1 + (b1 | c1)",
        best: RIDE,
    },
    // The peak force of a transient under three constraints, two of them active.
    Case {
        name: "touch-down",
        study: "touch-down",
        task: "P2 L2 F",
        layout: "ks | c | b",
        best: TOUCH_DOWN,
    },
    // The same with a spring of two stages: constraints that jump.
    Case {
        name: "two stages",
        study: "touch-down",
        task: "P4 L1 eta",
        layout: "stage | c",
        best: TWO_STAGES,
    },
];
const ABSORBER: f64 = 6.407_920_768;
const PASSAGEWAYS: f64 = 1.659_845_608;
const RIDE: f64 = 1.753_602_843;
const TOUCH_DOWN: f64 = 21_808.167_01;
const TWO_STAGES: f64 = -0.877_221_653_7;

/// A value this close (relative) to the best known one is the optimum.
const WITHIN: f64 = 1e-3;
const SEEDS: u64 = 20;
/// Where one seed gives up.
const MOST: usize = 60_000;

impl Case {
    fn problem(&self) -> DesignProblem {
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join(format!("../../studies/{}.toml", self.study));
        let study = Study::read(&path).unwrap();
        let problems = quell_study::problems(&study, self.task).unwrap();
        let labels: Vec<String> = problems.iter().map(|(label, _)| label.clone()).collect();
        let mut problem = problems
            .into_iter()
            .find(|(label, _)| label == self.layout)
            .map_or_else(
                || panic!("{}: no {} in {labels:?}", self.name, self.layout),
                |(_, problem)| problem,
            );
        // The objective without holes in its grid, as a run ends with it.
        for _ in 0..6 {
            let settings = Settings::for_dimension(problem.variables().len());
            let found = quell_search::search(&problem, &settings, 1);
            if !problem.refine(&found.point).unwrap() {
                break;
            }
        }
        problem
    }

    fn target(&self) -> f64 {
        self.best + WITHIN * self.best.abs()
    }
}

/// Counts evaluations, and notes when the target was met.
struct Counted<'a> {
    problem: &'a DesignProblem,
    target: f64,
    feasibility: f64,
    begun: Instant,
    state: Mutex<Tally>,
}

#[derive(Default, Clone, Copy)]
struct Tally {
    evaluations: usize,
    hit: Option<(usize, f64)>,
    best: Option<f64>,
}

impl Problem for Counted<'_> {
    type Scratch = <DesignProblem as Problem>::Scratch;

    fn scratch(&self) -> Self::Scratch {
        self.problem.scratch()
    }

    fn variables(&self) -> &[Variable] {
        self.problem.variables()
    }

    fn constraints(&self) -> usize {
        self.problem.constraints()
    }

    fn is_smooth(&self) -> bool {
        self.problem.is_smooth()
    }

    fn evaluate(&self, point: &[f64], constraints: &mut [f64], scratch: &mut Self::Scratch) -> f64 {
        let value = self.problem.evaluate(point, constraints, scratch);
        let mut tally = self.state.lock().unwrap();
        tally.evaluations += 1;
        let feasible = constraints.iter().all(|excess| *excess <= self.feasibility);
        if feasible && value.is_finite() {
            tally.best = Some(tally.best.map_or(value, |best: f64| best.min(value)));
            if tally.hit.is_none() && value <= self.target {
                tally.hit = Some((tally.evaluations, self.begun.elapsed().as_secs_f64()));
            }
        }
        value
    }

    fn pieces(
        &self,
        point: &[f64],
        margin: f64,
        pieces: &mut Pieces,
        scratch: &mut Self::Scratch,
    ) -> bool {
        let found = self.problem.pieces(point, margin, pieces, scratch);
        // All peaks with their gradients count as one evaluation; they cost about 1.4.
        self.state.lock().unwrap().evaluations += usize::from(found);
        found
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    if let Some(at) = arguments.iter().position(|word| word == "serve") {
        let name = arguments.get(at + 1).map_or("", String::as_str);
        let case = CASES.iter().find(|case| case.name == name);
        serve(case.unwrap_or_else(|| panic!("no problem `{name}`")));
        return;
    }
    println!(
        "problem       variables  constraints  hits   evaluations: median  95 %   seconds: median  best met"
    );
    let named = |case: &&Case| arguments.iter().any(|word| word == case.name);
    let all = CASES.iter().filter(named).count() == 0;
    for case in CASES.iter().filter(|case| all || named(case)) {
        measure(case);
    }
}

fn measure(case: &Case) {
    let problem = case.problem();
    let settings = Settings::for_dimension(problem.variables().len());
    let mut hits: Vec<(usize, f64)> = Vec::new();
    let mut best = f64::INFINITY;
    for seed in 1..=SEEDS {
        let counted = Counted {
            problem: &problem,
            target: case.target(),
            feasibility: settings.feasibility,
            begun: Instant::now(),
            state: Mutex::new(Tally::default()),
        };
        let settings = Settings {
            seed,
            ..settings.clone()
        };
        for index in 0.. {
            start(&counted, &settings, 1, index);
            let tally = *counted.state.lock().unwrap();
            if tally.hit.is_some() || tally.evaluations >= MOST {
                break;
            }
        }
        let tally = *counted.state.lock().unwrap();
        hits.extend(tally.hit);
        best = best.min(tally.best.unwrap_or(f64::INFINITY));
    }
    hits.sort_by_key(|hit| hit.0);
    let share = |share: f64| {
        let place = (share * SEEDS as f64).ceil() as usize - 1;
        hits.get(place)
            .map_or("-".to_owned(), |hit| hit.0.to_string())
    };
    let seconds = hits.get(hits.len() / 2).map_or(f64::NAN, |hit| hit.1);
    println!(
        "{:12}  {:9}  {:11}  {:2}/{SEEDS}  {:19}  {:5}  {seconds:16.4}  {best:.9e}",
        case.name,
        problem.variables().len(),
        problem.constraints(),
        hits.len(),
        share(0.5),
        share(0.95),
    );
}

/// First a line with the target and the numbers of variables and constraints; then for each line of scaled coordinates a line
/// with objective and constraints.
fn serve(case: &Case) {
    let problem = case.problem();
    let mut scratch = problem.scratch();
    let mut constraints = vec![0.0; problem.constraints()];
    let mut out = std::io::stdout().lock();
    writeln!(
        out,
        "{:e} {} {}",
        case.target(),
        problem.variables().len(),
        constraints.len()
    )
    .unwrap();
    out.flush().unwrap();
    for line in std::io::stdin().lock().lines() {
        let line = line.unwrap();
        let point: Vec<f64> = line
            .split_whitespace()
            .zip(problem.variables())
            .map(|(text, variable)| variable.value(text.parse().unwrap()))
            .collect();
        let value = problem.evaluate(&point, &mut constraints, &mut scratch);
        write!(out, "{value:e}").unwrap();
        for constraint in &constraints {
            write!(out, " {constraint:e}").unwrap();
        }
        writeln!(out).unwrap();
        out.flush().unwrap();
    }
}
