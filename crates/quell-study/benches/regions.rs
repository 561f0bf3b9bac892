//! Time of every part of the diagrams of a landing gear with its first damper, on one thread: equilibria, branches of cycles, Hopf curves,
//! torus curves of 100 points in a direction, and the whole plane without a hint.
//!
//!     cargo bench -p quell-study --bench regions
//!
//! AUTO-07p took 0.25, 1.25, 0.64 and 10 s (each direction of a torus curve) of processor time for the first four on one core of another
//! machine, an idle two-core AMD EPYC.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a benchmark without its study ends by panic, and tells what it measured"
)]

use std::path::Path;
use std::sync::Mutex;
use std::time::Instant;

use quell_document::Source;
use quell_study::{Findings, Progress, RunSettings, Study};

const STUDY: &str = r#"
quell = 1
title = "The parts of a diagram"
host = "hosts/landing-gear.toml"

[devices.damper]
port = "links"

[[tasks]]
name = "equilibria"
kind = "branch"
configuration = { damper = "kd | cd", kd = "1.09e5 N*m/rad", cd = "3.6e4 N*m*s/rad" }
parameter = "V"

[[tasks]]
name = "equilibria and cycles"
kind = "branch"
configuration = { damper = "kd | cd", kd = "1.09e5 N*m/rad", cd = "3.6e4 N*m*s/rad" }
parameter = "V"
cycles = true

[[tasks]]
name = "soft"
kind = "branch"
configuration = { damper = "kd | cd", kd = "1.09e5 N*m/rad", cd = "2e3 N*m*s/rad" }
parameter = "V"

[[tasks]]
name = "Hopf curve 1"
kind = "curve"
start = "equilibria:H1"
parameters = ["V", "cd"]
ranges = { cd = ["300 N*m*s/rad", "1e5 N*m*s/rad"] }

[[tasks]]
name = "Hopf curve 2"
kind = "curve"
start = "equilibria:H2"
parameters = ["V", "cd"]
ranges = { cd = ["300 N*m*s/rad", "1e5 N*m*s/rad"] }

[[tasks]]
name = "Hopf curve 3"
kind = "curve"
start = "soft:H1"
parameters = ["V", "cd"]
ranges = { cd = ["300 N*m*s/rad", "1e5 N*m*s/rad"] }

[[tasks]]
name = "torus curves"
kind = "curve"
start = "Hopf curve 1:HH1"
parameters = ["V", "cd"]
points = 100

[[tasks]]
name = "plane"
kind = "region"
configuration = { damper = "kd | cd", kd = "1.09e5 N*m/rad", cd = "3.6e4 N*m*s/rad" }
parameters = ["V", "cd"]
ranges = { cd = ["300 N*m*s/rad", "1e5 N*m*s/rad"] }
"#;

/// When tasks began and ended.
struct Clock(Mutex<Vec<(String, Instant, f64)>>);

impl Progress for Clock {
    fn begin(&self, task: &str, _units: u64) {
        let mut all = self.0.lock().unwrap();
        all.push((task.to_owned(), Instant::now(), f64::NAN));
    }
    fn advance(&self, _best: &str) {
        if let Some(last) = self.0.lock().unwrap().last_mut() {
            last.2 = last.1.elapsed().as_secs_f64();
        }
    }
}

fn main() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../studies");
    let study = Study::parse(Source::new("study.toml", STUDY.to_owned()), &folder)
        .unwrap_or_else(|fault| panic!("{}", fault.render()));
    let settings = RunSettings {
        seed: 1,
        threads: Some(1),
        tasks: Vec::new(),
    };
    let clock = Clock(Mutex::new(Vec::new()));
    let outcome = quell_study::run(&study, &settings, &clock).unwrap_or_else(|e| panic!("{e}"));
    for (name, _, seconds) in clock.0.lock().unwrap().iter() {
        let task = outcome.tasks.iter().find(|task| task.name == *name);
        let Some(Findings::Continuation(found)) = task
            .and_then(|task| task.points.first())
            .map(|point| &point.findings)
        else {
            continue;
        };
        let points: Vec<String> = found
            .branches
            .iter()
            .map(|branch| format!("{} {}", branch.of, branch.points.len()))
            .collect();
        println!("{name:24} {seconds:8.3} s  points: {}", points.join(", "));
    }
}
