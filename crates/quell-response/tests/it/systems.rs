//! Systems of first-order equations that `quell-model` compiles, against the linear theory of this crate.

use std::sync::Arc;

use num_complex::Complex64;
use quell_model::linear::{LinearHost, Signal};
use quell_model::system::{Device, Linearised, Phase, Quantity, System, Watched};
use quell_model::{EquationHost, Host};
use quell_network::Mechanism;
use quell_response::{Assembly, Attached};

use crate::harness::{
    Random, coordinate, form, network, random_host, random_layout, random_port, random_values,
};

fn equations(linear: LinearHost) -> EquationHost {
    let (starts, waveforms) = (
        vec![[0.0; 2]; linear.coordinates.len()],
        vec![None; linear.inputs.len()],
    );
    let host = Host {
        linear,
        parameters: Vec::new(),
        elements: Vec::new(),
        starts,
        waveforms,
    };
    EquationHost::from_linear(&host).unwrap()
}

/// det(s - A) and the product of the rows' norms, which its rounding errors are a part of.
fn characteristic(a: &[f64], n: usize, s: Complex64) -> (Complex64, f64) {
    let mut m: Vec<Vec<Complex64>> = (0..n)
        .map(|i| {
            (0..n)
                .map(|j| {
                    let diagonal = if i == j { s } else { Complex64::ZERO };
                    diagonal - a[i * n + j]
                })
                .collect()
        })
        .collect();
    let mut determinant = Complex64::ONE;
    for k in 0..n {
        let pivot = (k..n)
            .max_by(|&i, &j| m[i][k].norm().total_cmp(&m[j][k].norm()))
            .unwrap();
        if pivot != k {
            m.swap(pivot, k);
            determinant = -determinant;
        }
        determinant *= m[k][k];
        for i in k + 1..n {
            let factor = m[i][k] / m[k][k];
            for j in k..n {
                let taken = factor * m[k][j];
                m[i][j] -= taken;
            }
        }
    }
    (determinant, determinant.norm())
}

/// H(s) of a signal from an input, by the linearised system.
fn transfer(linear: &Linearised, signal: usize, input: usize, s: Complex64) -> Complex64 {
    let [n, inputs, _] = linear.sizes;
    let powers = [Complex64::ONE, s, s * s];
    let sum = |blocks: &[Vec<f64>; 3], row: usize| -> Complex64 {
        blocks
            .iter()
            .zip(powers)
            .map(|(block, power)| power * block[row * inputs + input])
            .sum()
    };
    // (s - A) x = B by elimination beside the right-hand side.
    let mut rows: Vec<Vec<Complex64>> = (0..n)
        .map(|i| {
            let mut row: Vec<Complex64> = (0..n)
                .map(|j| {
                    let diagonal = if i == j { s } else { Complex64::ZERO };
                    diagonal - linear.a[i * n + j]
                })
                .collect();
            row.push(sum(&linear.b, i));
            row
        })
        .collect();
    for k in 0..n {
        let pivot = (k..n)
            .max_by(|&i, &j| rows[i][k].norm().total_cmp(&rows[j][k].norm()))
            .unwrap();
        rows.swap(pivot, k);
        let head = rows[k].clone();
        for (i, row) in rows.iter_mut().enumerate() {
            if i != k {
                let factor = row[k] / head[k];
                for (entry, other) in row.iter_mut().zip(&head) {
                    *entry -= factor * other;
                }
            }
        }
    }
    let states: Complex64 = (0..n)
        .map(|k| linear.c[signal * n + k] * rows[k][n] / rows[k][k])
        .sum();
    states + sum(&linear.d, signal)
}

/// Compares number of states, characteristic polynomial and transfer functions; false where linear theory has none.
fn compare(random: &mut Random, linear: LinearHost, texts: &[String], what: &str) -> bool {
    let networks: Vec<_> = texts.iter().map(|text| network(text)).collect();
    let attached = networks
        .iter()
        .enumerate()
        .map(|(port, network)| Attached {
            port,
            network: Arc::clone(network),
        })
        .collect();
    let Ok(assembly) = Assembly::new(Arc::new(linear.clone()), attached) else {
        return false;
    };
    let values = random_values(random, &assembly, 1.0);
    let devices: Vec<Device> = networks
        .iter()
        .enumerate()
        .map(|(port, network)| {
            Device::new(format!("d{port}"), port, Mechanism::from(network.as_ref()))
        })
        .collect();
    let coordinates = linear.coordinates.len();
    let mut watched: Vec<Watched> = vec![Quantity::PortForce { port: 0 }.into()];
    let massive: Vec<usize> = (0..coordinates)
        .filter(|&i| linear.mass[(i, i)] != 0.0)
        .collect();
    watched.extend(massive.iter().map(|&index| {
        let quantity = Quantity::Coordinate { index, order: 2 };
        Watched::from(quantity)
    }));
    let inputs = linear.inputs.len();
    let system = System::new(&equations(linear), &devices, &watched, Phase::Free)
        .unwrap_or_else(|error| panic!("{what}, {texts:?}: {error}"));
    assert_eq!(
        system.states().len(),
        assembly.predicted_modes(),
        "{what}, {texts:?}"
    );
    assert_eq!(system.implicit_unknowns(), 0);
    let n = system.states().len();
    let linearised = system.prepare(&values).linearise(0.0, &vec![0.0; n]);
    let Ok(realisation) = assembly.realise(&values) else {
        return false;
    };
    for _ in 0..4 {
        let s = Complex64::new(random.between(0.1, 3.0), random.between(-3.0, 3.0));
        let (ours, size) = characteristic(&linearised.a, n, s);
        let (theirs, _) = characteristic(realisation.state_matrix(), n, s);
        // Rounding errors of both, with condition numbers of a few decades of values.
        assert!(
            (ours - theirs).norm() <= 1e-8 * size,
            "{what}, {texts:?}, s = {s}: {ours} and {theirs}"
        );
    }
    for input in 0..inputs {
        let omega = random.between(0.3, 3.0);
        for signal in 0..watched.len() {
            let form = match signal {
                0 => form(&[(Signal::PortForce { index: 0 }, 1.0)]),
                _ => form(&[(coordinate(massive[signal - 1], 2), 1.0)]),
            };
            let Ok(theirs) = realisation.response(&assembly, &values, input, &form, omega) else {
                continue;
            };
            let ours = transfer(&linearised, signal, input, Complex64::new(0.0, omega));
            assert!(
                (ours - theirs).norm() <= 1e-8 * (theirs.norm() + 1e-3),
                "{what}, {texts:?}, input {input}, signal {signal}: {ours} and {theirs}"
            );
        }
    }
    true
}

fn layouts(random: &mut Random, count: usize) -> Vec<String> {
    (0..count)
        .map(|_| {
            let elements = 1 + random.below(6);
            random_layout(random, elements)
        })
        .collect()
}

#[test]
fn random_linear_systems_have_the_predicted_states_modes_and_responses() {
    let mut checked = 0;
    for seed in 0..400 {
        let mut random = Random::new(seed);
        let damped = random.unit() < 0.5;
        let free = random.unit() < 0.3;
        let mut linear = random_host(&mut random, damped, free);
        let count = 1 + random.below(2);
        for _ in 0..count {
            linear = random_port(&mut random, linear);
        }
        let texts = layouts(&mut random, count);
        checked += usize::from(compare(
            &mut random,
            linear,
            &texts,
            &format!("seed {seed}"),
        ));
    }
    assert!(checked > 300);
}

#[test]
fn coordinates_without_mass_join_the_devices_points() {
    let mut checked = 0;
    for seed in 0..400 {
        let mut random = Random::new(5000 + seed);
        let damped = random.unit() < 0.5;
        let mut linear = random_host(&mut random, damped, false);
        let gone = random.below(linear.coordinates.len());
        for i in 0..linear.coordinates.len() {
            linear.mass[(gone, i)] = 0.0;
            linear.mass[(i, gone)] = 0.0;
        }
        let count = 1 + random.below(2);
        for _ in 0..count {
            linear = random_port(&mut random, linear);
        }
        let texts = layouts(&mut random, count);
        checked += usize::from(compare(
            &mut random,
            linear,
            &texts,
            &format!("seed {seed}"),
        ));
    }
    assert!(checked > 200, "{checked}");
}

#[test]
fn powers_close_in_random_linear_systems() {
    for seed in 0..60 {
        let mut random = Random::new(1000 + seed);
        let mut linear = random_host(&mut random, true, false);
        linear = random_port(&mut random, linear);
        let text = random_layout(&mut random, 5);
        let network = network(&text);
        let elements = network.elements().len();
        let device = Device::new("d".into(), 0, Mechanism::from(network.as_ref()));
        let mut watched: Vec<Watched> = (0..elements)
            .map(|element| Watched::from(Quantity::ElementPower { device: 0, element }))
            .collect();
        watched.push(Quantity::DevicePower { device: 0 }.into());
        watched.push(Quantity::PortPower { port: 0 }.into());
        let system = System::new(&equations(linear), &[device], &watched, Phase::Free).unwrap();
        let values: Vec<f64> = (0..system.parameters().len())
            .map(|_| random.magnitude(1.0))
            .collect();
        let x: Vec<f64> = (0..system.states().len())
            .map(|_| random.between(-1.0, 1.0))
            .collect();
        let mut signals = vec![0.0; watched.len()];
        system.prepare(&values).signals(0.0, &x, &mut signals);
        let sum: f64 = signals[..elements].iter().sum();
        let size: f64 = signals[..elements].iter().map(|p| p.abs()).sum();
        // Tellegen's theorem, to rounding.
        assert!(
            (sum - signals[elements]).abs() <= 1e-12 * size,
            "seed {seed}, {text}: {sum} and {}",
            signals[elements]
        );
    }
}
