//! Hosts with devices as compiled systems, against right-hand sides written by hand, independent figures and invariants.

#![allow(clippy::panic, clippy::unwrap_used, reason = "tests fail by panicking")]

use std::path::Path;
use std::sync::Arc;

use quell_document::Source;
use quell_expression::{Dimension, Expression, LANES};
use quell_model::system::{
    Device, EquilibriumStatus, ForceLaw, LawParameter, Phase, Prepared, Quantity, System,
    SystemError, Vocabulary, Watched,
};
use quell_model::{EquationHost, HostFile};
use quell_network::{Domain, Kinds, Layout, Mechanism};
use serde_json::Value;

/// Upper and lower mass with a raked strut between them on a spring to the ground; force times cosine, not over it, as the
/// source has it (Li, Jiang, Neild, Wang, Journal of Aircraft 54, 2017).
const RAKED: &str = r#"
quell = 1
dimensionless = true
[parameters]
W1 = 2411
W2 = 131
g = 32.18
kt = 18500
phi = "pi/15"
V0 = 8.86
[coordinates]
z1 = { rate = "V0" }
z2 = { rate = "V0" }
[equations]
z1 = "W1/g*z1'' = -W2 - Fs*cos(phi)"
z2 = "W2/g*z2'' = W2 + Fs*cos(phi) - kt*z2"
[ports]
strut = { across = "(z1 - z2)/cos(phi)", force = "Fs" }
"#;

#[track_caller]
fn read(text: &str) -> EquationHost {
    HostFile::parse(Arc::new(Source::new("host.toml", text)), ".")
        .and_then(|file| file.equations(&[]))
        .unwrap_or_else(|fault| panic!("{}", fault.render()))
}

fn kinds(domain: Domain) -> Kinds {
    let mut kinds = Kinds::new(domain);
    kinds.declare_custom("gas", true, false).unwrap();
    kinds.declare_custom("oil", false, true).unwrap();
    kinds.declare_custom("stage", true, false).unwrap();
    kinds
}

fn device(name: &str, layout: &str, domain: Domain) -> Device {
    let layout = Layout::parse(layout, &kinds(domain)).unwrap();
    Device::new(
        name.into(),
        0,
        Mechanism::from_layout(&layout, None).unwrap(),
    )
}

fn strut(layout: &str, values: &[(&str, f64)]) -> Device {
    let device = device("strut", layout, Domain::Translational);
    values.iter().fold(device, |device, (name, value)| {
        device.with_value(name, *value)
    })
}

fn law(host: &EquationHost, text: &str, parameters: &[(&str, f64)]) -> ForceLaw {
    let parameters = parameters
        .iter()
        .map(|(name, value)| LawParameter {
            name: (*name).into(),
            dimension: Dimension::NONE,
            value: *value,
        })
        .collect();
    ForceLaw::lower(
        host,
        &Expression::parse(text).unwrap(),
        parameters,
        Dimension::NONE,
        Dimension::NONE,
    )
    .unwrap()
}

fn gas_and_oil(host: &EquationHost, device: Device) -> Device {
    let gas = law(
        host,
        "pa0*Aa*(v0/(v0 - Aa*x))^n",
        &[
            ("pa0", 6264.0),
            ("Aa", 0.05761),
            ("v0", 0.03545),
            ("n", 1.12),
        ],
    );
    device
        .with_law("gas", gas)
        .with_law("oil", law(host, "Ad*v*abs(v)", &[("Ad", 339.5)]))
        .with_law(
            "stage",
            law(
                host,
                "if x <= xs then k1*x else k1*xs + k2*(x - xs)",
                &[("xs", 0.1), ("k1", 2000.0), ("k2", 9000.0)],
            ),
        )
}

fn random(index: usize) -> f64 {
    ((index as f64 + 1.0) * 0.754_877_666_246_693).fract() * 2.0 - 1.0
}

#[track_caller]
fn assert_close(found: &[f64], expected: &[f64], relative: f64) {
    let size = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(expected) {
        assert!(
            (a - b).abs() <= relative * b.abs() + 1e-14 * size,
            "{found:?} is not {expected:?}"
        );
    }
}

fn rates(system: &System, prepared: &mut Prepared<'_>, x: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; system.states().len()];
    prepared.rates(0.0, x, &mut out);
    out
}

/// (ks, c, b, k, c2)
type Values = [f64; 5];
/// (Force without the inerter across, internal rates, inerter across) of values, stroke, its rate, internal states.
type ByHand = fn(Values, f64, f64, &[f64]) -> (f64, Vec<f64>, f64);

#[test]
fn struts_have_the_rates_written_by_hand() {
    let host = read(RAKED);
    let [ks, c, b, k, c2]: Values = [5884.0, 797.0, 18.0, 15641.0, 120.0];
    let cos = (std::f64::consts::PI / 15.0).cos();
    let (w1, w2, kt) = (2411.0, 131.0, 18500.0);
    let (m1, m2) = (w1 / 32.18, w2 / 32.18);
    // Layout; number of internal states; by hand.
    let cases: [(&str, usize, ByHand); 6] = [
        ("k1 | c1", 0, |[ks, c, ..], x, v, _| {
            (ks * x + c * v, vec![], 0.0)
        }),
        ("k1 | c1 | b1", 0, |[ks, c, b, ..], x, v, _| {
            (ks * x + c * v, vec![], b)
        }),
        // The state is the rate y' of the point between damper and inerter: the inerter's own rate.
        ("k1 | (c1 + b1)", 1, |[ks, c, b, ..], x, v, s| {
            (ks * x + c * (v - s[0]), vec![c * (v - s[0]) / b], 0.0)
        }),
        // The state is the position of the point between: here the spring's far end, so q = x - y is its stroke.
        ("k1 | b1 | (k2 + c1)", 1, |[ks, c, b, k, _], x, _, s| {
            (ks * x + k * (x - s[0]), vec![k * (x - s[0]) / c], b)
        }),
        (
            "k1 | b1 | c2 | (k2 + c1)",
            1,
            |[ks, c, b, k, c2], x, v, s| {
                (
                    ks * x + c2 * v + k * (x - s[0]),
                    vec![k * (x - s[0]) / c],
                    b,
                )
            },
        ),
        ("gas | oil", 0, |_, x, v, _| {
            let gas = 6264.0 * 0.05761 * (0.03545_f64 / (0.03545 - 0.05761 * x)).powf(1.12);
            (gas + 339.5 * v * v.abs(), vec![], 0.0)
        }),
    ];
    for (layout, internal, by_hand) in cases {
        let given = [("k1", ks), ("c1", c), ("b1", b), ("k2", k), ("c2", c2)];
        let device = gas_and_oil(&host, strut(layout, &given));
        let system = System::new(&host, &[device], &[], Phase::Free).unwrap();
        assert_eq!(system.states().len(), 4 + internal, "{layout}");
        assert_eq!(system.affine(), !layout.contains("gas"), "{layout}");
        let mut prepared = system.prepare(&system.defaults());
        let start = system.start(&system.defaults());
        for (name, value) in [("z1", 0.0), ("z2", 0.0), ("z1'", 8.86), ("z2'", 8.86)] {
            assert_eq!(start[system.state(name).unwrap()], value);
        }
        for state in system.states().iter().zip(&start) {
            if state.0.name.starts_with("strut") {
                assert_eq!(*state.1, 0.0);
            }
        }
        for seed in 0..20 {
            let mut x: Vec<f64> = (0..system.states().len())
                .map(|i| 0.3 * random(seed * 7 + i))
                .collect();
            let at = |name: &str| system.state(name).unwrap();
            x[at("z1'")] = 8.0 * random(seed + 100);
            let found = rates(&system, &mut prepared, &x);
            let inner: Vec<f64> = system
                .states()
                .iter()
                .zip(&x)
                .filter(|(state, _)| state.name.starts_with("strut"))
                .map(|(_, value)| *value)
                .collect();
            let (z1, z2, v1, v2) = (x[at("z1")], x[at("z2")], x[at("z1'")], x[at("z2'")]);
            let (force, inner_rates, b) =
                by_hand([ks, c, b, k, c2], (z1 - z2) / cos, (v1 - v2) / cos, &inner);
            // The cosines cancel in the mass matrix.
            let n = cos * force;
            let (f1, f2) = (-w2 - n, w2 + n - kt * z2);
            let determinant = m1 * m2 + b * (m1 + m2);
            let a1 = ((m2 + b) * f1 + b * f2) / determinant;
            let a2 = (b * f1 + (m1 + b) * f2) / determinant;
            assert_close(
                &[
                    found[at("z1")],
                    found[at("z2")],
                    found[at("z1'")],
                    found[at("z2'")],
                ],
                &[v1, v2, a1, a2],
                1e-11,
            );
            let found_inner: Vec<f64> = system
                .states()
                .iter()
                .zip(&found)
                .filter(|(state, _)| state.name.starts_with("strut"))
                .map(|(_, value)| *value)
                .collect();
            assert_close(&found_inner, &inner_rates, 1e-12);
        }
    }
}

#[test]
fn two_wheels_have_the_rates_of_an_independent_program() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures");
    let host = HostFile::read(folder.join("two-wheels.toml"))
        .and_then(|file| file.equations(&[]))
        .unwrap_or_else(|fault| panic!("{}", fault.render()));
    let text = std::fs::read_to_string(folder.join("two-wheels-vectors.json")).unwrap();
    let vectors: Value = serde_json::from_str(&text).unwrap();
    for vector in vectors["vectors"].as_array().unwrap() {
        let list = |key: &str| -> Vec<f64> {
            let numbers = vector[key].as_array().unwrap();
            numbers.iter().map(|one| one.as_f64().unwrap()).collect()
        };
        let (state, derivative) = (list("state"), list("derivative"));
        let name = vector["device"].as_str().unwrap();
        let layout = match name {
            "L1" => "k1 | c1",
            "L2" => "(k1 | c1) + k2",
            "LI1" => "(k1 | c1 | b1) + k2",
            _ => "(k1 | c1) + (k2 | b1)",
        };
        let mut damper = device("damper", layout, Domain::Rotational).with_value("k1", 1.09e5);
        for (key, element) in [("cd", "c1"), ("ks", "k2"), ("b", "b1")] {
            if let Some(value) = vector["parameters"][key].as_f64() {
                damper = damper.with_value(element, value);
            }
        }
        let system = System::new(&host, &[damper], &[], Phase::Free).unwrap();
        assert_eq!(system.states().len(), state.len(), "{name}");
        // Which states the internal ones are, by the directions: the stroke of the spring beside the damper, or with a
        // second point that of the whole.
        let own: Vec<f64> = match name {
            // e1' and e2' apart, e1 and e2 as motions of the device's head and of the point within.
            "LI2" => vec![state[7], state[6] + state[7], state[8]],
            _ => state[6..].to_vec(),
        };
        let expected_own: Vec<f64> = match name {
            "LI2" => vec![derivative[7], derivative[6] + derivative[7], derivative[8]],
            _ => derivative[6..].to_vec(),
        };
        let mut x = vec![0.0; state.len()];
        let mut expected = x.clone();
        for (index, known) in ["d", "d'", "p", "p'", "lamL", "lamR"].iter().enumerate() {
            let place = system.state(known).unwrap();
            x[place] = state[index];
            expected[place] = derivative[index];
        }
        let rest: Vec<usize> = (0..x.len())
            .filter(|place| {
                let name = system.states()[*place].name.as_str();
                !["d", "d'", "p", "p'", "lamL", "lamR"].contains(&name)
            })
            .collect();
        for ((place, value), rate) in rest.iter().zip(&own).zip(&expected_own) {
            x[*place] = *value;
            expected[*place] = *rate;
        }
        let mut parameters = system.defaults();
        let speed = system.parameters().iter().position(|p| p.name == "V");
        parameters[speed.unwrap()] = vector["parameters"]["V"].as_f64().unwrap();
        let found = rates(&system, &mut system.prepare(&parameters), &x);
        assert_close(&found, &expected, 1e-9);
    }
}

/// Every kind of block: algebraic and neutral points, linear and not, in one device each.
const BLOCKS: [(&str, usize); 9] = [
    ("k1 + k2 + c1", 0),
    ("(k1 | c1) + (c2 + b1)", 0),
    ("gas + k1", 1),
    ("(gas | c1) + (k1 | oil)", 1),
    ("oil + k1", 1),
    ("oil + c1", 1),
    ("k1 | (oil + b1)", 0),
    ("(k1 + gas) | (c1 + oil) | b1", 2),
    ("stage + b1 | (c1 + b2 + k1)", 0),
];

fn block(host: &EquationHost, layout: &str) -> Device {
    let given = [
        ("k1", 8000.0),
        ("k2", 3000.0),
        ("c1", 500.0),
        ("c2", 900.0),
        ("b1", 3.0),
        ("b2", 5.0),
    ];
    gas_and_oil(host, strut(layout, &given))
}

fn somewhere(system: &System, seed: usize) -> Vec<f64> {
    system
        .states()
        .iter()
        .enumerate()
        .map(|(i, state)| {
            let scale = if state.name.ends_with('\'') { 2.0 } else { 0.1 };
            scale * random(seed * 13 + i)
        })
        .collect()
}

#[test]
fn jacobians_agree_with_differences_whatever_the_blocks() {
    let host = read(RAKED);
    for (layout, implicit) in BLOCKS {
        let system = System::new(&host, &[block(&host, layout)], &[], Phase::Free)
            .unwrap_or_else(|error| panic!("{layout}: {error}"));
        assert_eq!(system.implicit_unknowns(), implicit, "{layout}");
        let n = system.states().len();
        let mut prepared = system.prepare(&system.defaults());
        let mut checked = 0;
        for seed in 0..20 {
            let x = somewhere(&system, seed);
            let (mut f, mut jacobian) = (vec![0.0; n], vec![0.0; n * n]);
            prepared.jacobian(0.0, &x, &mut f, &mut jacobian);
            assert_close(&rates(&system, &mut prepared, &x), &f, 1e-11);
            let u: Vec<f64> = (0..n).map(|i| 0.01 * random(i + 5)).collect();
            let mut at = |s: f64| {
                let moved: Vec<f64> = x.iter().zip(&u).map(|(x, u)| x + s * u).collect();
                rates(&system, &mut prepared, &moved)
            };
            // Six points, of sixth order in the step; two steps tell where a kink or a root is near.
            let mut points = |h: f64| -> Vec<Vec<f64>> {
                [1.0, 2.0, 3.0, -1.0, -2.0, -3.0]
                    .map(|s| at(s * h))
                    .to_vec()
            };
            let (wide, narrow) = (points(0.05), points(0.025));
            let product: Vec<f64> = (0..n)
                .map(|i| (0..n).map(|j| jacobian[i * n + j] * u[j]).sum())
                .collect();
            let difference = |values: &[Vec<f64>], h: f64| -> Vec<f64> {
                (0..n)
                    .map(|i| {
                        let d = |k: usize| values[k][i] - values[k + 3][i];
                        (45.0 * d(0) - 9.0 * d(1) + d(2)) / (60.0 * h)
                    })
                    .collect()
            };
            let (coarse, fine) = (difference(&wide, 0.05), difference(&narrow, 0.025));
            let size = product.iter().fold(0.0_f64, |most, p| most.max(p.abs()));
            let trusted = (0..n).all(|i| (coarse[i] - fine[i]).abs() <= 1e-7 * size);
            if !trusted {
                continue;
            }
            checked += 1;
            for (a, b) in product.iter().zip(&fine) {
                assert!(
                    (a - b).abs() <= 1e-7 * size,
                    "{layout}: {product:?}, {fine:?}"
                );
            }
            let (values, h) = (&narrow, 0.025);
            let along = prepared.along(0.0, &x, &[&u, &u, &u]);
            assert_close(&along[0], &product, 1e-10);
            // Second and third derivatives from the same points, of lower order.
            let centre = rates(&system, &mut prepared, &x);
            for i in 0..n {
                let s = |k: usize| values[k][i] + values[k + 3][i] - 2.0 * centre[i];
                let second = (270.0 * s(0) - 27.0 * s(1) + 2.0 * s(2)) / (180.0 * h * h);
                assert!(
                    (along[1][i] - second).abs() <= 1e-5 * size,
                    "{layout}: {} {second}",
                    along[1][i]
                );
            }
        }
        assert!(checked > 5, "{layout}: {checked}");
    }
}

#[test]
fn powers_of_elements_are_what_devices_receive() {
    let host = read(RAKED);
    for (layout, _) in BLOCKS {
        let device = block(&host, layout);
        let elements = device.mechanism.elements().len();
        let mut watched: Vec<Watched> = (0..elements)
            .map(|element| Quantity::ElementPower { device: 0, element }.into())
            .collect();
        let more = [
            Quantity::DevicePower { device: 0 },
            Quantity::PortPower { port: 0 },
            Quantity::PortReceived { port: 0 },
            Quantity::HostPower,
            Quantity::Kinetic,
        ];
        watched.extend(more.map(Watched::from));
        let system = System::new(&host, &[device], &watched, Phase::Free).unwrap();
        let n = system.states().len();
        let mut prepared = system.prepare(&system.defaults());
        let mut y = vec![0.0; watched.len()];
        let cos = (std::f64::consts::PI / 15.0).cos();
        for seed in 0..10 {
            let x = somewhere(&system, seed);
            prepared.signals(0.0, &x, &mut y);
            let sum: f64 = y[..elements].iter().sum();
            let size: f64 = y[..elements].iter().map(|p| p.abs()).sum();
            assert!((sum - y[elements]).abs() <= 1e-12 * size, "{layout}: {y:?}");
            assert!((y[elements + 2] - y[elements]).abs() <= 1e-13 * size);
            // This host's port is not virtual-work consistent: it gives cos² of what is received.
            let given = y[elements + 1];
            assert!((given - cos * cos * y[elements]).abs() <= 1e-12 * size);
            // d(kinetic)/dt by the rates.
            let f = rates(&system, &mut prepared, &x);
            let linear = prepared.linearise(0.0, &x);
            let row = &linear.c[(elements + 4) * n..(elements + 5) * n];
            let change: f64 = row.iter().zip(&f).map(|(c, f)| c * f).sum();
            let balance = y[elements + 3] - given;
            let size = y[elements + 3].abs() + given.abs();
            assert!(
                (change - balance).abs() <= 1e-12 * size,
                "{layout}: {change} {balance}"
            );
        }
    }
}

#[test]
fn lanes_have_the_bits_of_single_points() {
    let host = read(RAKED);
    for layout in ["k1 | b1 | (k2 + c1)", "gas | oil", "gas + k1"] {
        let system = System::new(&host, &[block(&host, layout)], &[], Phase::Free).unwrap();
        let n = system.states().len();
        let points: Vec<Vec<f64>> = (0..LANES).map(|lane| somewhere(&system, lane)).collect();
        let x: Vec<[f64; LANES]> = (0..n)
            .map(|i| std::array::from_fn(|lane| points[lane][i]))
            .collect();
        let mut batch = system.prepare_batch(&system.defaults());
        let mut f = vec![[0.0; LANES]; n];
        let mut jacobian = vec![[0.0; LANES]; n * n];
        batch.jacobian(&[0.0; LANES], &x, &mut f, &mut jacobian);
        let mut prepared = system.prepare(&system.defaults());
        for lane in 0..LANES {
            let (mut own, mut own_jacobian) = (vec![0.0; n], vec![0.0; n * n]);
            prepared.jacobian(0.0, &points[lane], &mut own, &mut own_jacobian);
            for i in 0..n {
                assert_eq!(f[i][lane], own[i], "{layout}");
            }
            for i in 0..n * n {
                assert_eq!(jacobian[i][lane], own_jacobian[i], "{layout}");
            }
        }
    }
}

#[test]
fn a_held_strut_moves_as_one_body_and_tells_its_load() {
    let host = read(RAKED);
    let device = block(&host, "gas | oil");
    let devices = [device];
    let mut vocabulary = Vocabulary::new(&host, &devices);
    let hold = vocabulary
        .hold(&Expression::parse("stroke(strut)").unwrap())
        .unwrap();
    assert_eq!(hold, Phase::HoldPort(0));
    let texts = ["Fs", "reaction(strut)", "force(gas)", "z1''"];
    let watched: Vec<Watched> = texts
        .iter()
        .map(|text| {
            vocabulary
                .lower(&Expression::parse(text).unwrap())
                .unwrap()
                .0
        })
        .collect();
    let system = vocabulary.system(&watched, hold).unwrap();
    let mut prepared = system.prepare(&system.defaults());
    let z = 0.02;
    let mut x = vec![0.0; 4];
    for (name, value) in [("z1", z), ("z2", z), ("z1'", 8.0), ("z2'", 8.0)] {
        x[system.state(name).unwrap()] = value;
    }
    let mut y = vec![0.0; 4];
    prepared.signals(0.0, &x, &mut y);
    let (m1, m2) = (2411.0 / 32.18, 131.0 / 32.18);
    let cos = (std::f64::consts::PI / 15.0).cos();
    let acceleration = -18500.0 * z / (m1 + m2);
    // m1 z'' = -W2 - F cos
    let load = (-131.0 - m1 * acceleration) / cos;
    assert_close(&y, &[load, load, 6264.0 * 0.05761, acceleration], 1e-12);
    let f = rates(&system, &mut prepared, &x);
    assert!((f[system.state("z1'").unwrap()] - f[system.state("z2'").unwrap()]).abs() < 1e-10);
}

#[test]
fn equilibria_carry_gravity_and_preload() {
    // A mass on a preloaded gas spring: m g = F(x) has the closed form x = v0/Aa (1 - (p0 Aa/(m g))^(1/n)).
    let text = r#"
quell = 1
dimensionless = true
[parameters]
m = 70
g = 32.18
[coordinates]
z = {}
[equations]
z = "m*z'' = m*g - F"
[ports]
strut = { across = "z", force = "F" }
"#;
    let host = read(text);
    let expected =
        0.03545 / 0.05761 * (1.0 - (6264.0 * 0.05761 / (70.0 * 32.18_f64)).powf(1.0 / 1.12));
    for layout in ["gas | oil", "gas + (k1 | c1)", "gas | (c1 + b1)"] {
        let system = System::new(&host, &[block(&host, layout)], &[], Phase::Free).unwrap();
        let mut prepared = system.prepare(&system.defaults());
        let found = prepared.equilibrium(0.0, &vec![0.0; system.states().len()]);
        assert_ne!(
            found.status,
            EquilibriumStatus::NotFound,
            "{layout}: {found:?}"
        );
        assert!(found.residual < 1e-12, "{layout}: {found:?}");
        let stroke = if layout.contains("k1") {
            expected + 70.0 * 32.18 / 8000.0
        } else {
            expected
        };
        let z = found.state[system.state("z").unwrap()];
        assert!((z - stroke).abs() < 1e-12, "{layout}: {z} {stroke}");
    }
}

#[test]
fn what_is_watched_may_be_a_state_more() {
    let host = read(RAKED);
    let devices = [strut("k1 | (c1 + b1)", &[])];
    let plain = System::new(&host, &devices, &[], Phase::Free).unwrap();
    assert_eq!(plain.states().len(), 5);
    let mut vocabulary = Vocabulary::new(&host, &devices);
    for (text, states) in [
        ("stroke(b1)", 6),
        ("stroke(b1)'", 5),
        ("power(strut.c1)", 5),
    ] {
        let (watched, _) = vocabulary.lower(&Expression::parse(text).unwrap()).unwrap();
        let system = vocabulary.system(&[watched], Phase::Free).unwrap();
        assert_eq!(system.states().len(), states, "{text}");
    }
    let error = vocabulary
        .lower(&Expression::parse("power(c3)").unwrap())
        .unwrap_err();
    assert!(error.message.contains("c3"), "{error:?}");
}

#[test]
fn refusals_name_what_is_at_fault() {
    let host = read(RAKED);
    let device = device("strut", "gas | c1", Domain::Translational);
    let error = System::new(&host, &[device], &[], Phase::Free).unwrap_err();
    assert!(matches!(&error, SystemError::NoLaw { element, .. } if element == "gas"));
    let reaction = System::new(&host, &[], &[Quantity::Reaction.into()], Phase::Free);
    assert_eq!(reaction.unwrap_err(), SystemError::NoReaction);
    let expression = Expression::parse("k*x + z1").unwrap();
    let parameter = LawParameter {
        name: "k".into(),
        dimension: Dimension::NONE,
        value: 1.0,
    };
    let none = Dimension::NONE;
    let error = ForceLaw::lower(&host, &expression, vec![parameter], none, none).unwrap_err();
    assert!(error.message.contains("depends on its own displacement"));
}
