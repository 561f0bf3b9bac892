//! A host with devices on its ports: one stamped system of equations.
//!
//! A device joins the host as in a circuit simulator: between two nodes a spring stamps stiffness, a damper damping,
//! an inerter mass, and the device's internal nodes become further coordinates without mass of their own:
//!
//! ```text
//! M z'' + C z' + (K + j K_loss) z = F0 u + F1 u' + F2 u'',      z = [q; internal nodes of all devices]
//! ```
//!
//! The head of a device on port p moves with the port's across-variable x_p = h_p·q + g_p·u, its tail is at rest.

mod output;
mod response;
mod row;

use std::sync::Arc;

use quell_model::linear::LinearHost;
use quell_network::{Element, Network, Node};

use crate::dense::{Dense, Scalar};
use crate::error::ResponseError;
use crate::structure::Structure;

use row::{Row, node_row};

pub(crate) use output::OutputTerm;
pub(crate) use response::{powers, powers_of};
pub(crate) use row::Stamp;

/// A device and the port it is attached to.
#[derive(Debug, Clone)]
pub struct Attached {
    /// Index of the port in the host.
    pub port: usize,
    /// The device.
    pub network: Arc<Network>,
}

#[derive(Debug, Clone)]
pub(crate) struct Device {
    pub(crate) port: usize,
    pub(crate) network: Arc<Network>,
    /// First of its values in the concatenated slice.
    pub(crate) first_value: usize,
    /// First of its internal nodes in z.
    pub(crate) first_node: usize,
    /// First of its stamps, and one past the last.
    pub(crate) stamps: std::ops::Range<usize>,
    /// Nodes of each stamp.
    pub(crate) ends: Vec<(Node, Node)>,
}

impl Device {
    pub(crate) fn values<'a>(&self, values: &'a [f64]) -> &'a [f64] {
        &values[self.first_value..self.first_value + self.network.elements().len()]
    }
}

/// A host and the structure of the devices on its ports; element values come later, as one concatenated slice
/// (devices in the order given, each network's element order, SI mechanical values).
#[derive(Debug, Clone)]
pub struct Assembly {
    pub(crate) host: Arc<LinearHost>,
    pub(crate) devices: Vec<Device>,
    pub(crate) stamps: Vec<Stamp>,
    pub(crate) size: usize,
    pub(crate) elements: usize,
    pub(crate) element_names: Vec<String>,
    /// Structure of the realisation that transients and transfer functions use.
    pub(crate) structure: Structure,
    /// The same with the host's rigid-body motions taken out, for modes.
    pub(crate) deflated: Structure,
    pub(crate) mass: Dense<f64>,
    pub(crate) damping: Dense<f64>,
    pub(crate) stiffness: Dense<f64>,
    pub(crate) loss: Option<Dense<f64>>,
    pub(crate) forcing: [Dense<f64>; 3],
}

impl Assembly {
    /// Attaches devices to a host and decides the ranks of the joint system, once for all values.
    ///
    /// # Errors
    /// Where a matrix of the host has a wrong shape or a value that is not finite, the mass matrix is not symmetric,
    /// a port does not exist, or nothing holds a coordinate.
    pub fn new(host: Arc<LinearHost>, devices: Vec<Attached>) -> Result<Self, ResponseError> {
        validate(&host)?;
        let n = host.coordinates.len();
        let mut assembly_devices: Vec<Device> = Vec::with_capacity(devices.len());
        let mut stamps: Vec<Stamp> = Vec::new();
        let mut element_names = Vec::new();
        let (mut size, mut elements) = (n, 0);
        for Attached { port, network } in devices {
            if port >= host.ports.len() {
                return Err(ResponseError::UnknownPort {
                    host: host.name.clone(),
                    port,
                    ports: host.ports.len(),
                });
            }
            let nodal = network.nodal();
            let first_stamp = stamps.len();
            let mut ends = Vec::with_capacity(nodal.branches.len());
            for branch in &nodal.branches {
                let row = node_row(&host, port, size, branch.from)
                    .minus(&node_row(&host, port, size, branch.to));
                let order = match branch.element {
                    Element::Spring => 0,
                    Element::Damper => 1,
                    Element::Inerter | Element::Mass => 2,
                };
                stamps.push(Stamp {
                    order,
                    value: elements + branch.value,
                    row,
                });
                ends.push((branch.from, branch.to));
            }
            element_names.extend(
                network
                    .elements()
                    .iter()
                    .map(|element| element.name.clone()),
            );
            let count = network.elements().len();
            assembly_devices.push(Device {
                port,
                network: Arc::clone(&network),
                first_value: elements,
                first_node: size,
                stamps: first_stamp..stamps.len(),
                ends,
            });
            size += nodal.internal_nodes;
            elements += count;
        }
        let mass = Dense::from_faer(&host.mass);
        let damping = Dense::from_faer(&host.damping);
        let stiffness = Dense::from_faer(&host.stiffness);
        let loss = host
            .loss
            .as_ref()
            .map(Dense::from_faer)
            .filter(|loss| !loss.is_zero());
        let forcing = [0, 1, 2].map(|k| Dense::from_faer(&host.forcing[k]));
        let names = |index: usize| {
            if index < n {
                return host.coordinates[index].name.clone();
            }
            assembly_devices
                .iter()
                .rev()
                .find(|device| device.first_node <= index)
                .map_or_else(
                    || format!("internal node {index}"),
                    |device| {
                        format!(
                            "internal node {} of the device on port {}",
                            index - device.first_node + 1,
                            host.ports[device.port].name
                        )
                    },
                )
        };
        let matrices = [&stiffness, &damping, &mass];
        let structure = Structure::new(n, size, matrices, &stamps, false, &names)?;
        let deflated = Structure::new(n, size, matrices, &stamps, true, &names)?;
        Ok(Self {
            host,
            devices: assembly_devices,
            stamps,
            size,
            elements,
            element_names,
            structure,
            deflated,
            mass,
            damping,
            stiffness,
            loss,
            forcing,
        })
    }

    /// Number of element values that every evaluation takes.
    pub fn elements(&self) -> usize {
        self.elements
    }

    /// The host.
    pub fn host(&self) -> &Arc<LinearHost> {
        &self.host
    }

    /// Number of eigenvalues of the assembled system, rigid-body ones included, which its structure predicts for
    /// whatever positive values: 2n of a host with n coordinates and a regular mass matrix, plus the order of each device.
    pub fn predicted_modes(&self) -> usize {
        self.structure.states()
    }

    /// How many of the predicted eigenvalues are zero because the host (with its devices) can move as a rigid body.
    pub fn predicted_rigid_body_modes(&self) -> usize {
        self.structure
            .states()
            .saturating_sub(self.deflated.states())
    }

    pub(crate) fn check_values(&self, values: &[f64]) -> Result<(), ResponseError> {
        if values.len() != self.elements {
            return Err(ResponseError::ValueCount {
                expected: self.elements,
                found: values.len(),
            });
        }
        for (index, &value) in values.iter().enumerate() {
            if !(value.is_finite() && value >= 0.0) {
                return Err(ResponseError::ElementValue {
                    element: self.element_names[index].clone(),
                    value,
                });
            }
        }
        Ok(())
    }

    pub(crate) fn check_input(&self, input: usize) -> Result<(), ResponseError> {
        self.check_index("input", input, self.host.inputs.len())
    }

    fn check_index(
        &self,
        what: &'static str,
        index: usize,
        count: usize,
    ) -> Result<(), ResponseError> {
        if index < count {
            Ok(())
        } else {
            Err(ResponseError::UnknownIndex {
                host: self.host.name.clone(),
                what,
                index,
                count,
            })
        }
    }

    pub(crate) fn no_loss(&self, task: &'static str) -> Result<(), ResponseError> {
        if self.loss.is_some() {
            return Err(ResponseError::LossFactors {
                host: self.host.name.clone(),
                task,
            });
        }
        Ok(())
    }

    /// The across-variable of a port as a row.
    pub(crate) fn port_row(&self, port: usize) -> Row {
        node_row(&self.host, port, self.size, Node::Head)
    }
}

fn validate(host: &LinearHost) -> Result<(), ResponseError> {
    let (n, inputs) = (host.coordinates.len(), host.inputs.len());
    let shape = |what: String, expected: usize, found: usize| {
        if expected == found {
            Ok(())
        } else {
            Err(ResponseError::Shape {
                host: host.name.clone(),
                what,
                expected,
                found,
            })
        }
    };
    let mut matrices = vec![
        ("the mass matrix", &host.mass, n),
        ("the damping matrix", &host.damping, n),
        ("the stiffness matrix", &host.stiffness, n),
    ];
    if let Some(loss) = &host.loss {
        matrices.push(("the loss matrix", loss, n));
    }
    for (name, matrix) in ["the matrix F0", "the matrix F1", "the matrix F2"]
        .into_iter()
        .zip(&host.forcing)
    {
        matrices.push((name, matrix, inputs));
    }
    for (name, matrix, columns) in matrices {
        shape(format!("a column of {name}"), n, matrix.nrows())?;
        shape(format!("a row of {name}"), columns, matrix.ncols())?;
        if !Dense::from_faer(matrix).is_finite() {
            return Err(ResponseError::NotFinite {
                what: format!("{name} of host `{}`", host.name),
            });
        }
    }
    for port in &host.ports {
        shape(
            format!(
                "the across-variable of port `{}` on the coordinates",
                port.name
            ),
            n,
            port.coordinates.len(),
        )?;
        shape(
            format!("the across-variable of port `{}` on the inputs", port.name),
            inputs,
            port.inputs.len(),
        )?;
        if !port
            .coordinates
            .iter()
            .chain(&port.inputs)
            .all(|value| value.is_finite())
        {
            return Err(ResponseError::NotFinite {
                what: format!("port `{}` of host `{}`", port.name, host.name),
            });
        }
    }
    for i in 0..n {
        for j in 0..i {
            let (upper, lower) = (host.mass[(j, i)], host.mass[(i, j)]);
            let scale = (host.mass[(i, i)] * host.mass[(j, j)])
                .abs()
                .sqrt()
                .max(upper.abs());
            // Files carry six digits or more; anything beyond that is a mistake in the matrix.
            if (upper - lower).modulus() > 1e-6 * scale {
                return Err(ResponseError::UnsymmetricMass {
                    host: host.name.clone(),
                    row: host.coordinates[j].name.clone(),
                    column: host.coordinates[i].name.clone(),
                    upper,
                    lower,
                });
            }
        }
    }
    Ok(())
}
