//! Systems of first-order equations that `quell-model` compiles, against the linear theory of this crate.

use std::sync::Arc;

use num_complex::Complex64;
use quell_expression::{Dimension, Expression};
use quell_model::linear::{LinearHost, Signal};
use quell_model::system::{
    Device, ForceLaw, LawParameter, Linearised, Phase, Quantity, System, Vocabulary, Watched,
};
use quell_model::{EquationHost, Host, HostFile};
use quell_network::{Domain, Kinds, Layout, Mechanism};
use quell_response::transient::{Condition, Direction, End, Event, Record, Settings, simulate};
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
        let head = m[k].clone();
        for row in &mut m[k + 1..] {
            let factor = row[k] / head[k];
            for (entry, above) in row.iter_mut().zip(&head).skip(k) {
                *entry -= factor * above;
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
    // Where rounding of a port's coefficients has misled its choice of coordinates it says so, and is no oracle.
    let Ok(realisation) = assembly.realise(&values) else {
        return false;
    };
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
    let system = System::new(&equations(linear), &devices, &watched, Phase::Free);
    assert!(system.is_ok(), "{what}, {texts:?}: {system:?}");
    let system = system.unwrap();
    assert_eq!(
        system.states().len(),
        assembly.predicted_modes(),
        "{what}, {texts:?}"
    );
    assert_eq!(system.implicit_unknowns(), 0);
    let n = system.states().len();
    let linearised = system.prepare(&values).linearise(0.0, &vec![0.0; n]);
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

/// A layout, values in lbf, ft, s, and [Fs_max, ss_max, |V_end|, t_end].
type Strut = (&'static str, &'static [(&'static str, f64)], [f64; 4]);

/// Touch-down of a gear from its host file.
///
/// The numbers are of an independent program (exact stepping and a general integrator) for the struts of Li, Jiang, Neild
/// and Wang, Journal of Aircraft 54 (2017); the last row is their default strut of gas and oil.
const STRUTS: [Strut; 6] = [
    (
        "k1 | c1",
        &[("k1", 7128.0), ("c1", 797.0)],
        [5783.2, 0.52909, 1.9627, 0.18100],
    ),
    (
        "k1 | c1 | b1",
        &[("k1", 13411.0), ("c1", 171.4), ("b1", 14.558)],
        [4902.7, 0.52910, 2.0581, 0.12815],
    ),
    (
        "k1 | (c1 + b1)",
        &[("k1", 22817.0), ("c1", 1481.0), ("b1", 33.42)],
        [6376.7, 0.38533, 0.0660, 0.13670],
    ),
    (
        "k1 | b1 | (c1 + k2)",
        &[
            ("k1", 4884.2),
            ("b1", 24.590),
            ("c1", 1281.3),
            ("k2", 43298.0),
        ],
        [6058.3, 0.48634, 2.0899, 0.17977],
    ),
    (
        "stage | c1",
        &[("c1", 1000.0)],
        [5488.1, 0.52909, 0.5294, 0.16262],
    ),
    ("gas | oil", &[], [6373.22, 0.52919, 2.0966, f64::NAN]),
];

#[test]
fn struts_touch_down_as_an_independent_program_has_it() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../studies/hosts/touch-down.toml"
    );
    let host = HostFile::read(path).unwrap().equations(&[]).unwrap();
    let (foot, pound) = (0.3048_f64, 4.448_221_615_260_5_f64);
    let mut kinds = Kinds::new(Domain::Translational);
    kinds.declare_custom("gas", true, false).unwrap();
    kinds.declare_custom("oil", false, true).unwrap();
    kinds.declare_custom("stage", true, false).unwrap();
    let law = |text: &str, parameters: &[(&str, Dimension, f64)]| {
        let parameters = parameters
            .iter()
            .map(|(name, dimension, value)| LawParameter {
                name: (*name).into(),
                dimension: *dimension,
                value: *value,
            })
            .collect();
        let expression = Expression::parse(text).unwrap();
        ForceLaw::lower(
            &host,
            &expression,
            parameters,
            Dimension::LENGTH,
            Dimension::FORCE,
        )
        .unwrap()
    };
    let volume = Dimension::LENGTH * Dimension::AREA;
    let square = Dimension::DAMPING / Dimension::VELOCITY;
    let gas = law(
        "pa0*Aa*(v0/(v0 - Aa*x))^n",
        &[
            ("v0", volume, 0.03545 * foot.powi(3)),
            ("n", Dimension::NONE, 1.12),
        ],
    );
    let oil = law(
        "Ad*v*abs(v)",
        &[("Ad", square, 339.5 * pound / foot / foot)],
    );
    // No force up to the knee, from there to the static point of the default strut.
    let slope = 2464.86 / (0.504_660 - 0.4737) * pound / foot;
    let stage = law(
        "k2*max(x - xs, 0)",
        &[
            ("k2", Dimension::STIFFNESS, slope),
            ("xs", Dimension::LENGTH, 0.4737 * foot),
        ],
    );
    for (layout, values, expected) in STRUTS {
        let parsed = Layout::parse(layout, &kinds).unwrap();
        let mechanism = Mechanism::from_layout(&parsed, None).unwrap();
        let mut device = Device::new("leg".into(), 0, mechanism)
            .with_law("gas", gas.clone())
            .with_law("oil", oil.clone())
            .with_law("stage", stage.clone());
        for (name, value) in values {
            // k, c and b in lbf/ft, lbf s/ft and slugs alike.
            device = device.with_value(name, value * pound / foot);
        }
        let devices = [device];
        let mut vocabulary = Vocabulary::new(&host, &devices);
        let watched: Vec<Watched> = ["ss", "ss'", "Fs", "z1'"]
            .iter()
            .map(|text| {
                vocabulary
                    .lower(&Expression::parse(text).unwrap())
                    .unwrap()
                    .0
            })
            .collect();
        let system = vocabulary.system(&watched, Phase::Free).unwrap();
        let parameters = system.defaults();
        let start = system.start(&parameters);
        let end = Event::on(1, Direction::Falling)
            .armed(Condition::above(1, 0.0))
            .ending();
        let mut prepared = system.prepare(&parameters);
        let settings = Settings::default();
        let run = simulate(&mut prepared, &start, (0.0, 1.0), &[end], &settings).unwrap();
        assert_eq!(run.end(), &End::Event { event: 0 }, "{layout}");
        let t = run.to();
        let mut record = Record::new(&run, &mut prepared);
        let found = [
            record.maximum(2).value / pound,
            record.maximum(0).value / foot,
            record.value(3, t).abs() / foot,
            t,
        ];
        for (found, expected) in found.iter().zip(expected) {
            // 2e-4 or the last digit printed, as the figures are given.
            assert!(
                expected.is_nan() || (found - expected).abs() <= 2e-4 * expected + 6e-5,
                "{layout}: {found} is not {expected}"
            );
        }
    }
}
