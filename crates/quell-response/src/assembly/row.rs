//! Sparse rows over the coordinates and the inputs, and the elements stamped along them.

use std::collections::BTreeMap;

use num_complex::Complex64;
use quell_model::linear::LinearHost;
use quell_network::Node;

/// A sparse row over the coordinates z and the inputs' u.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Row {
    pub(crate) coordinates: Vec<(usize, f64)>,
    pub(crate) inputs: Vec<(usize, f64)>,
}

impl Row {
    pub(super) fn minus(&self, other: &Self) -> Self {
        let merge = |a: &[(usize, f64)], b: &[(usize, f64)]| {
            let mut sum: BTreeMap<usize, f64> = a.iter().copied().collect();
            for &(index, value) in b {
                *sum.entry(index).or_insert(0.0) -= value;
            }
            sum.into_iter().filter(|entry| entry.1 != 0.0).collect()
        };
        Self {
            coordinates: merge(&self.coordinates, &other.coordinates),
            inputs: merge(&self.inputs, &other.inputs),
        }
    }

    /// The value of the row for coordinates `z` and the given u of input `input`.
    pub(super) fn apply(&self, z: &[Complex64], input: usize) -> Complex64 {
        let from_coordinates: Complex64 = self.coordinates.iter().map(|&(i, c)| z[i] * c).sum();
        from_coordinates + self.input(input)
    }

    pub(crate) fn input(&self, input: usize) -> f64 {
        self.inputs
            .iter()
            .filter(|entry| entry.0 == input)
            .map(|entry| entry.1)
            .sum()
    }
}

/// One element between two nodes: `value` times the `order`-th derivative of the relative displacement `row`.
#[derive(Debug, Clone)]
pub(crate) struct Stamp {
    /// 0 for a spring, 1 for a damper, 2 for an inerter or a mass.
    pub(crate) order: usize,
    /// Index into the concatenated values.
    pub(crate) value: usize,
    pub(crate) row: Row,
}

/// The displacement of a node of a device on `port` whose internal nodes begin at `first` in z.
pub(super) fn node_row(host: &LinearHost, port: usize, first: usize, node: Node) -> Row {
    let sparse = |values: &[f64]| {
        values
            .iter()
            .copied()
            .enumerate()
            .filter(|entry| entry.1 != 0.0)
            .collect::<Vec<(usize, f64)>>()
    };
    match node {
        Node::Head => {
            let port = &host.ports[port];
            Row {
                coordinates: sparse(&port.coordinates),
                inputs: sparse(&port.inputs),
            }
        }
        Node::Tail => Row::default(),
        Node::Internal(index) => Row {
            coordinates: vec![(first + index, 1.0)],
            inputs: vec![],
        },
    }
}
