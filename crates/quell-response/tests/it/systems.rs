//! Systems of first-order equations that `quell-model` compiles, against the linear theory of this crate.

use std::sync::Arc;

use num_complex::Complex64;
use quell_model::linear::LinearHost;
use quell_model::system::{Device, Phase, Quantity, System, Watched};
use quell_model::{EquationHost, Host};
use quell_network::Mechanism;
use quell_response::{Assembly, Attached};

use crate::harness::{Random, network, random_host, random_layout, random_port, random_values};

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

#[test]
fn random_linear_systems_have_the_predicted_states_and_modes() {
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
        let texts: Vec<String> = (0..count)
            .map(|_| {
                let elements = 1 + random.below(6);
                random_layout(&mut random, elements)
            })
            .collect();
        let networks: Vec<_> = texts.iter().map(|text| network(text)).collect();
        let attached = networks
            .iter()
            .enumerate()
            .map(|(port, network)| Attached {
                port,
                network: Arc::clone(network),
            })
            .collect();
        let assembly = Assembly::new(Arc::new(linear.clone()), attached).unwrap();
        let values = random_values(&mut random, &assembly, 1.0);
        let devices: Vec<Device> = networks
            .iter()
            .enumerate()
            .map(|(port, network)| {
                Device::new(format!("d{port}"), port, Mechanism::from(network.as_ref()))
            })
            .collect();
        let system = System::new(&equations(linear), &devices, &[], Phase::Free)
            .unwrap_or_else(|error| panic!("seed {seed}, {texts:?}: {error}"));
        assert_eq!(
            system.states().len(),
            assembly.predicted_modes(),
            "seed {seed}, {texts:?}"
        );
        assert_eq!(system.implicit_unknowns(), 0);
        // Base motion makes it depend on time; without, it is affine.
        let n = system.states().len();
        let linearised = system.prepare(&values).linearise(0.0, &vec![0.0; n]);
        let Ok(realisation) = assembly.realise(&values) else {
            continue;
        };
        for _ in 0..4 {
            let s = Complex64::new(random.between(0.1, 3.0), random.between(-3.0, 3.0));
            let (ours, size) = characteristic(&linearised.a, n, s);
            let (theirs, _) = characteristic(realisation.state_matrix(), n, s);
            // Rounding errors of both, with condition numbers of a few decades of values.
            assert!(
                (ours - theirs).norm() <= 1e-8 * size,
                "seed {seed}, {texts:?}, s = {s}: {ours} and {theirs}"
            );
        }
        checked += 1;
    }
    assert!(checked > 300);
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
