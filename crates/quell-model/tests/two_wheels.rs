//! A host with functions of a side, held parts, states and a massless coordinate, against independent vectors.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use std::path::Path;

use quell_model::{EquationHost, HostFile, Symbol};
use serde_json::Value;

fn fixture(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/fixtures")
        .join(name)
}

/// Values of graph inputs by symbol.
struct Point<'a> {
    host: &'a EquationHost,
    inputs: Vec<f64>,
}

impl Point<'_> {
    fn set(&mut self, symbol: Symbol, value: f64) {
        let input = self.host.input(symbol).unwrap();
        self.inputs[input] = value;
    }

    fn coordinate(&mut self, index: usize, values: [f64; 3]) {
        for (order, value) in values.into_iter().enumerate() {
            self.set(Symbol::Coordinate { index, order }, value);
        }
    }
}

#[test]
fn residuals_vanish_and_rates_agree_at_the_vectors() {
    let host = HostFile::read(fixture("two-wheels.toml"))
        .and_then(|file| file.equations(&[]))
        .unwrap_or_else(|fault| panic!("{}", fault.render()));
    assert_eq!(host.residuals.len(), 3);
    let text = std::fs::read_to_string(fixture("two-wheels-vectors.json")).unwrap();
    let vectors: Value = serde_json::from_str(&text).unwrap();
    let (kpsi, kd) = (3.8e5, 1.09e5);
    for vector in vectors["vectors"].as_array().unwrap() {
        let list = |key: &str| -> Vec<f64> {
            let numbers = vector[key].as_array().unwrap();
            numbers.iter().map(|one| one.as_f64().unwrap()).collect()
        };
        let (x, rates) = (list("state"), list("derivative"));
        let parameter = |name: &str| vector["parameters"][name].as_f64();
        let series = parameter("ks").map_or(kpsi, |ks| kpsi * ks / (kpsi + ks));
        // The torque that the device passes, by the definition of each chain.
        let device = vector["device"].as_str().unwrap();
        let torque = match device {
            "LI2" => kpsi * (x[2] - x[6] - x[7]),
            _ => series * (x[2] - x[6]),
        };
        if device == "L1" {
            let own = kd * x[6] + parameter("cd").unwrap() * rates[6];
            assert!((own - torque).abs() < 1e-9 * torque.abs());
        }
        let mut point = Point {
            host: &host,
            inputs: host.nominal(),
        };
        point.coordinate(0, [x[0], x[1], rates[1]]);
        point.coordinate(1, [x[2], x[3], rates[3]]);
        point.coordinate(2, [x[2] - torque / kpsi, 0.0, 0.0]);
        point.set(Symbol::State { index: 0 }, x[4]);
        point.set(Symbol::State { index: 1 }, x[5]);
        let speed = host.parameters.iter().position(|one| one.name == "V");
        let index = speed.unwrap();
        point.set(Symbol::Parameter { index }, parameter("V").unwrap());

        let slots: Vec<_> = host
            .residuals
            .iter()
            .copied()
            .chain(host.states.iter().map(|state| state.rate))
            .chain([host.ports[0].across])
            .collect();
        let found = host.graph.values(&slots, &point.inputs);
        // 1e-9 of the largest terms: inertia times acceleration, and the moment of the weight.
        assert!(found[0].abs() < 1e-9 * 500.0 * 50.0, "{device}: {found:?}");
        assert!(found[1].abs() < 1e-9 * 100.0 * 120.0, "{device}: {found:?}");
        // Virtual work adds the torque to the equation of the massless coordinate.
        assert!((found[2] + torque).abs() < 1e-9 * torque.abs());
        for (rate, expected) in found[3..5].iter().zip(&rates[4..6]) {
            assert!(
                (rate - expected).abs() < 1e-9 * (expected.abs() + 0.1),
                "{device}"
            );
        }
        assert!((found[5] - (x[2] - torque / kpsi)).abs() < 1e-15);
    }
}
