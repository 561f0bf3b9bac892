//! Hosts, devices and random numbers that the tests share.

use std::sync::Arc;

use faer::Mat;
use quell_expression::Dimension;
use quell_model::linear::{
    Coordinate, CoordinateKind, Input, InputKind, LinearForm, LinearHost, Port, Signal,
};
use quell_network::{Domain, Kinds, Layout, Network};
use quell_response::{Assembly, Attached};

/// A small generator (xorshift64*), so that every failure can be repeated from its seed.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    pub(crate) fn unit(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn below(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count - 1)
    }

    pub(crate) fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.unit()
    }

    /// Log-uniform over 10^±decades.
    pub(crate) fn magnitude(&mut self, decades: f64) -> f64 {
        10_f64.powf(self.between(-decades, decades))
    }
}

pub(crate) fn network(text: &str) -> Arc<Network> {
    let layout = Layout::parse(text, &Kinds::new(Domain::Translational)).unwrap();
    Arc::new(Network::from_layout(&layout, None).unwrap())
}

/// A random layout with `elements` branches of springs, dampers and inerters.
pub(crate) fn random_layout(random: &mut Random, elements: usize) -> String {
    let mut number = 0;
    let series = random.unit() < 0.5;
    random_tree(random, elements, series, &mut number)
}

fn random_tree(random: &mut Random, elements: usize, series: bool, number: &mut usize) -> String {
    if elements == 1 {
        *number += 1;
        return format!("{}{}", ["k", "c", "b"][random.below(3)], number);
    }
    let left = 1 + random.below(elements - 1);
    let a = random_tree(random, left, !series, number);
    let b = random_tree(random, elements - left, !series, number);
    format!("({a}) {} ({b})", if series { "+" } else { "|" })
}

pub(crate) fn matrix(rows: &[&[f64]]) -> Mat<f64> {
    Mat::from_fn(
        rows.len(),
        rows.first().map_or(0, |row| row.len()),
        |i, j| rows[i][j],
    )
}

/// A host of the given matrices; inputs and ports are added by [`input`] and [`port`].
pub(crate) fn host(mass: Mat<f64>, damping: Mat<f64>, stiffness: Mat<f64>) -> LinearHost {
    let n = mass.nrows();
    LinearHost {
        name: "test host".into(),
        coordinates: (0..n)
            .map(|i| Coordinate {
                name: format!("x{}", i + 1),
                kind: CoordinateKind::Translation,
            })
            .collect(),
        mass,
        damping,
        stiffness,
        loss: None,
        inputs: Vec::new(),
        forcing: [Mat::zeros(n, 0), Mat::zeros(n, 0), Mat::zeros(n, 0)],
        ports: Vec::new(),
        outputs: Vec::new(),
    }
}

/// Adds an input with columns of F0, F1, F2.
pub(crate) fn input(mut host: LinearHost, kind: InputKind, columns: [&[f64]; 3]) -> LinearHost {
    let count = host.inputs.len();
    host.inputs.push(Input {
        name: format!("u{count}"),
        kind,
        motion: CoordinateKind::Translation,
        dimension: Dimension::NONE,
    });
    for (forcing, column) in host.forcing.iter_mut().zip(columns) {
        let old = forcing.clone();
        *forcing = Mat::from_fn(old.nrows(), count + 1, |i, j| {
            if j < count {
                old[(i, j)]
            } else {
                column.get(i).copied().unwrap_or(0.0)
            }
        });
    }
    for port in &mut host.ports {
        port.inputs.push(0.0);
    }
    host
}

pub(crate) fn port(mut host: LinearHost, coordinates: &[f64], inputs: &[f64]) -> LinearHost {
    let name = format!("p{}", host.ports.len());
    host.ports.push(Port {
        name,
        coordinates: coordinates.to_vec(),
        inputs: inputs.to_vec(),
        kind: CoordinateKind::Translation,
        hangs: false,
        grounded: true,
    });
    host
}

pub(crate) fn assembly(host: LinearHost, devices: &[(usize, &str)]) -> Arc<Assembly> {
    let devices = devices
        .iter()
        .map(|&(port, text)| Attached {
            port,
            network: network(text),
        })
        .collect();
    Arc::new(Assembly::new(Arc::new(host), devices).unwrap())
}

pub(crate) fn form(terms: &[(Signal, f64)]) -> LinearForm {
    LinearForm {
        terms: terms.to_vec(),
    }
}

pub(crate) fn coordinate(index: usize, order: usize) -> Signal {
    Signal::Coordinate { index, order }
}

/// A random host of 1 to 3 coordinates with regular mass, one force, one base displacement; ports are added by the caller.
pub(crate) fn random_host(random: &mut Random, damped: bool, free: bool) -> LinearHost {
    let n = 1 + random.below(3);
    let mut mass = Mat::zeros(n, n);
    for i in 0..n {
        mass[(i, i)] = random.magnitude(0.5);
    }
    if n > 1 {
        // A rocking inertia: symmetric and positive definite.
        let coupling = 0.3 * (mass[(0, 0)] * mass[(1, 1)]).sqrt() * random.between(-1.0, 1.0);
        mass[(0, 1)] = coupling;
        mass[(1, 0)] = coupling;
    }
    let mut stiffness = Mat::zeros(n, n);
    let mut damping = Mat::zeros(n, n);
    let chain = |matrix: &mut Mat<f64>, i: usize, j: Option<usize>, value: f64| {
        matrix[(i, i)] += value;
        if let Some(j) = j {
            matrix[(j, j)] += value;
            matrix[(i, j)] -= value;
            matrix[(j, i)] -= value;
        }
    };
    for i in 1..n {
        chain(&mut stiffness, i, Some(i - 1), random.magnitude(1.0));
        if damped {
            chain(&mut damping, i, Some(i - 1), random.magnitude(1.0) * 0.1);
        }
    }
    let mut ground = (0.0, 0.0);
    if !free {
        ground = (
            random.magnitude(1.0),
            if damped {
                random.magnitude(1.0) * 0.1
            } else {
                0.0
            },
        );
        chain(&mut stiffness, 0, None, ground.0);
        chain(&mut damping, 0, None, ground.1);
    }
    let mut force = vec![0.0; n];
    force[random.below(n)] = 1.0;
    let built = input(
        host(mass, damping, stiffness),
        InputKind::Force,
        [&force, &[], &[]],
    );
    input(
        built,
        InputKind::Displacement,
        [&[ground.0], &[ground.1], &[]],
    )
}

/// A port between random points; every second one touches the moving base.
pub(crate) fn random_port(random: &mut Random, host: LinearHost) -> LinearHost {
    let n = host.coordinates.len();
    let mut row = vec![0.0; n];
    let i = random.below(n);
    row[i] = 1.0;
    let mut base = 0.0;
    match random.below(3) {
        0 if n > 1 => row[(i + 1) % n] = -random.between(0.2, 1.5),
        1 => base = -1.0,
        _ => {}
    }
    let mut inputs = vec![0.0; host.inputs.len()];
    if let Some(last) = inputs.last_mut() {
        *last = base;
    }
    port(host, &row, &inputs)
}

pub(crate) fn random_values(random: &mut Random, assembly: &Assembly, decades: f64) -> Vec<f64> {
    (0..assembly.elements())
        .map(|_| random.magnitude(decades))
        .collect()
}
