//! Derivatives of rates by parameters and time against central differences.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use std::path::Path;
use std::sync::Arc;

use quell_document::Source;
use quell_expression::LANES;
use quell_model::system::{Device, Phase, System};
use quell_model::{EquationHost, HostFile};
use quell_network::{Domain, Kinds, Layout, Mechanism};

fn device(layout: &str, domain: Domain) -> Device {
    let layout = Layout::parse(layout, &Kinds::new(domain)).unwrap();
    let mechanism = Mechanism::from_layout(&layout, None).unwrap();
    Device::new("damper".into(), 0, mechanism)
}

fn gear() -> EquationHost {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures");
    HostFile::read(folder.join("two-wheels.toml"))
        .and_then(|file| file.equations(&[]))
        .unwrap()
}

/// Every parameter of a system and time, at a point: the error of a central difference is h² f'''/6 and rounding ε f/h, of the
/// size 1e-9 with h = 1e-5 relative; 1e-6 of the largest entry leaves room for f'''.
fn check(system: &System, values: &[f64], t: f64, x: &[f64]) {
    let all: Vec<usize> = (0..values.len()).collect();
    let slopes = system.slopes(&all);
    let n = x.len();
    let rates = |values: &[f64], t: f64| {
        let mut out = vec![0.0; n];
        system.prepare(values).rates(t, x, &mut out);
        out
    };
    let mut batch = system.prepare_batch(values);
    let lanes: Vec<[f64; LANES]> = x.iter().map(|value| [*value; LANES]).collect();
    for which in 0..=values.len() {
        let mut exact = vec![f64::NAN; n];
        system
            .prepare(values)
            .slope(&slopes, which, t, x, &mut exact);
        let mut many = vec![[f64::NAN; LANES]; n];
        batch.slope(&slopes, which, &[t; LANES], &lanes, &mut many);
        let difference: Vec<f64> = if let Some(value) = values.get(which) {
            let h = 1e-5 * value.abs().max(1e-3);
            let [plus, minus] = [h, -h].map(|h| {
                let mut moved = values.to_vec();
                moved[which] += h;
                rates(&moved, t)
            });
            plus.iter()
                .zip(minus)
                .map(|(p, m)| (p - m) / (2.0 * h))
                .collect()
        } else {
            let h = 1e-5;
            let (plus, minus) = (rates(values, t + h), rates(values, t - h));
            plus.iter()
                .zip(minus)
                .map(|(p, m)| (p - m) / (2.0 * h))
                .collect()
        };
        let scale = rates(values, t)
            .iter()
            .fold(0.0_f64, |most, rate| most.max(rate.abs()));
        let value = values.get(which).map_or(1.0, |value| value.abs().max(1e-3));
        let size = exact
            .iter()
            .fold(scale / value * 1e-3, |most, slope| most.max(slope.abs()));
        for state in 0..n {
            assert!(
                (exact[state] - difference[state]).abs() <= 1e-6 * size,
                "parameter {which}, state {state}: {} and {}",
                exact[state],
                difference[state]
            );
            assert_eq!(exact[state].to_bits(), many[state][0].to_bits());
            assert_eq!(exact[state].to_bits(), many[state][LANES - 1].to_bits());
        }
    }
}

#[test]
fn slopes_of_a_gear_with_a_device_in_series() {
    let host = gear();
    for layout in ["k1 | c1", "k2 + (k1 | c1 | b1)"] {
        let device = device(layout, Domain::Rotational)
            .with_value("k1", 1.09e5)
            .with_value("k2", 7e5)
            .with_value("c1", 3.6e4)
            .with_value("b1", 140.0);
        let system = System::new(&host, &[device], &[], Phase::Free).unwrap();
        let x: Vec<f64> = (0..system.states().len())
            .map(|index| 0.02 * (1.0 + index as f64).sin())
            .collect();
        check(&system, &system.defaults(), 0.0, &x);
    }
}

#[test]
fn slopes_where_newton_finds_unknowns_and_time_stands_in_the_equations() {
    let text = r#"
quell = 1
title = "A mass behind a massless point with a cubic law, forced"
dimensionless = true
[parameters]
k = 2
c = 0.3
e = 0.7
F = 0.4
Om = 1.3
[coordinates]
x = {}
y = { massless = true }
[equations]
x = "x'' + c*x' + (x - y) = F*cos(Om*t)"
y = "k*y + e*y^3 + (y - x) = 0"
"#;
    let source = Arc::new(Source::new("host.toml", text));
    let host = HostFile::parse(source, ".")
        .and_then(|file| file.equations(&[]))
        .unwrap_or_else(|fault| panic!("{}", fault.render()));
    let system = System::new(&host, &[], &[], Phase::Free).unwrap();
    assert_eq!(system.implicit_unknowns(), 1);
    let x = [0.6, -0.2];
    let found = &system.states().len();
    assert_eq!(*found, 2);
    check(&system, &system.defaults(), 0.9, &x);
    // Equations without time have none to depend on.
    assert!(!system.slopes(&[]).timeless());
    let gear = System::new(&gear(), &[], &[], Phase::Free);
    assert!(gear.is_ok_and(|gear| gear.slopes(&[]).timeless()));
}
