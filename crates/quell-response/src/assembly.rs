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

use std::collections::BTreeMap;
use std::sync::Arc;

use num_complex::Complex64;
use quell_model::linear::{LinearForm, LinearHost, Signal};
use quell_network::{Element, Network, Node};

use crate::dense::{Dense, Scalar};
use crate::error::ResponseError;
use crate::structure::Structure;

/// A device and the port it is attached to.
#[derive(Debug, Clone)]
pub struct Attached {
    /// Index of the port in the host.
    pub port: usize,
    /// The device.
    pub network: Arc<Network>,
}

/// A sparse row over the coordinates z and the inputs' u.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Row {
    pub(crate) coordinates: Vec<(usize, f64)>,
    pub(crate) inputs: Vec<(usize, f64)>,
}

impl Row {
    fn minus(&self, other: &Self) -> Self {
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
    fn apply(&self, z: &[Complex64], input: usize) -> Complex64 {
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

/// A term of an output: coefficient · [value] · d^order/dt^order (row).
#[derive(Debug, Clone)]
pub(crate) struct OutputTerm {
    pub(crate) order: usize,
    /// Index of the element value that multiplies it (forces), if any.
    pub(crate) value: Option<usize>,
    pub(crate) coefficient: f64,
    pub(crate) row: Row,
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

    /// Every signal of a form as rows over z and u, forces with the element value that multiplies them.
    pub(crate) fn output_terms(&self, form: &LinearForm) -> Result<Vec<OutputTerm>, ResponseError> {
        let mut terms = Vec::new();
        for (signal, coefficient) in &form.terms {
            if !coefficient.is_finite() {
                return Err(ResponseError::NotFinite {
                    what: "a coefficient of the output".into(),
                });
            }
            self.signal_terms(signal, *coefficient, &mut terms)?;
        }
        Ok(terms)
    }

    fn signal_terms(
        &self,
        signal: &Signal,
        coefficient: f64,
        terms: &mut Vec<OutputTerm>,
    ) -> Result<(), ResponseError> {
        match signal {
            Signal::Coordinate { index, order } => {
                self.check_index("coordinate", *index, self.host.coordinates.len())?;
                check_order(
                    &format!("coordinate `{}`", self.host.coordinates[*index].name),
                    *order,
                )?;
                let row = Row {
                    coordinates: vec![(*index, 1.0)],
                    inputs: vec![],
                };
                terms.push(OutputTerm {
                    order: *order,
                    value: None,
                    coefficient,
                    row,
                });
            }
            Signal::Input { index, order } => {
                self.check_input(*index)?;
                check_order(
                    &format!("input `{}`", self.host.inputs[*index].name),
                    *order,
                )?;
                let row = Row {
                    coordinates: vec![],
                    inputs: vec![(*index, 1.0)],
                };
                terms.push(OutputTerm {
                    order: *order,
                    value: None,
                    coefficient,
                    row,
                });
            }
            Signal::PortForce { index } => {
                self.check_index("port", *index, self.host.ports.len())?;
                for device in self.devices.iter().filter(|device| device.port == *index) {
                    self.force_into(device, Node::Head, |_| true, coefficient, terms);
                }
            }
            Signal::PartStroke { port, part, order } => {
                let (device, (from, to)) = self.find_part(*port, part)?;
                check_order(&format!("the stroke of `{part}`"), *order)?;
                let row = node_row(&self.host, device.port, device.first_node, from)
                    .minus(&node_row(&self.host, device.port, device.first_node, to));
                terms.push(OutputTerm {
                    order: *order,
                    value: None,
                    coefficient,
                    row,
                });
            }
            Signal::PartForce { port, part } => {
                let (device, (from, _)) = self.find_part(*port, part)?;
                let within = |name: &str| is_within(name, part);
                self.force_into(device, from, within, coefficient, terms);
            }
        }
        Ok(())
    }

    /// The force that flows from `node` into those elements of a device that `select` names.
    fn force_into(
        &self,
        device: &Device,
        node: Node,
        select: impl Fn(&str) -> bool,
        coefficient: f64,
        terms: &mut Vec<OutputTerm>,
    ) {
        for (stamp, &(from, to)) in self.stamps[device.stamps.clone()].iter().zip(&device.ends) {
            if !select(&self.element_names[stamp.value]) {
                continue;
            }
            let sign = f64::from(u8::from(from == node)) - f64::from(u8::from(to == node));
            if sign != 0.0 {
                terms.push(OutputTerm {
                    order: stamp.order,
                    value: Some(stamp.value),
                    coefficient: sign * coefficient,
                    row: stamp.row.clone(),
                });
            }
        }
    }

    /// The device on `port` that has `part`, and the part's nodes.
    pub(crate) fn find_part(
        &self,
        port: usize,
        part: &str,
    ) -> Result<(&Device, (Node, Node)), ResponseError> {
        self.check_index("port", port, self.host.ports.len())?;
        let mut found = None;
        let mut names = Vec::new();
        for device in self.devices.iter().filter(|device| device.port == port) {
            let nodal = device.network.nodal();
            for (name, nodes) in &nodal.parts {
                if name == part {
                    if found.is_some() {
                        return Err(ResponseError::AmbiguousPart {
                            port: self.host.ports[port].name.clone(),
                            part: part.to_owned(),
                        });
                    }
                    found = Some((device, *nodes));
                } else {
                    names.push(format!("`{name}`"));
                }
            }
        }
        found.ok_or_else(|| ResponseError::UnknownPart {
            port: self.host.ports[port].name.clone(),
            part: part.to_owned(),
            help: if names.is_empty() {
                "there is no device on it".to_owned()
            } else {
                format!("the parts are {}", names.join(", "))
            },
        })
    }

    /// The stamped dynamic stiffness -ω² M + jω C + K + j K_loss at one frequency.
    fn dynamic_stiffness(&self, values: &[f64], omega: f64) -> Dense<Complex64> {
        let powers = powers(omega);
        let n = self.host.coordinates.len();
        let mut matrix = Dense::zeros(self.size, self.size);
        for i in 0..n {
            for j in 0..n {
                let loss = self.loss.as_ref().map_or(0.0, |loss| loss.get(i, j));
                let value = Complex64::new(
                    self.stiffness.get(i, j),
                    if omega > 0.0 { loss } else { 0.0 },
                ) + powers[1] * self.damping.get(i, j)
                    + powers[2] * self.mass.get(i, j);
                matrix.set(i, j, value);
            }
        }
        for stamp in &self.stamps {
            let value = powers[stamp.order] * values[stamp.value];
            for &(i, a) in &stamp.row.coordinates {
                for &(j, b) in &stamp.row.coordinates {
                    matrix.add(i, j, value * (a * b));
                }
            }
        }
        matrix
    }

    fn excitation(&self, values: &[f64], input: usize, omega: f64) -> Dense<Complex64> {
        let powers = powers(omega);
        let mut right = Dense::zeros(self.size, 1);
        for i in 0..self.host.coordinates.len() {
            let force: Complex64 = (0..3)
                .map(|k| powers[k] * self.forcing[k].get(i, input))
                .sum();
            right.set(i, 0, force);
        }
        for stamp in &self.stamps {
            let from_input = stamp.row.input(input);
            if from_input != 0.0 {
                let value = powers[stamp.order] * (values[stamp.value] * from_input);
                for &(i, a) in &stamp.row.coordinates {
                    right.add(i, 0, -value * a);
                }
            }
        }
        right
    }

    /// The transfer function H(jω) from an input as it is given to an output, by one LU of the stamped nodal system.
    ///
    /// `omega` in rad/s. This is the reference that every faster path is held against.
    ///
    /// # Errors
    /// Where `values` do not fit, the input or a signal does not exist, or an undamped mode lies on ω.
    pub fn direct_response(
        &self,
        values: &[f64],
        input: usize,
        form: &LinearForm,
        omega: f64,
    ) -> Result<Complex64, ResponseError> {
        self.check_values(values)?;
        self.check_input(input)?;
        let terms = self.output_terms(form)?;
        self.direct_terms(values, input, &terms, omega, None)
    }

    /// H(jω) and its exact derivatives by every element value, by one LU of the stamped system (adjoint method).
    ///
    /// # Errors
    /// As [`Assembly::direct_response`]; also where `gradient` has another length than the values.
    pub fn direct_gradient(
        &self,
        values: &[f64],
        input: usize,
        form: &LinearForm,
        omega: f64,
        gradient: &mut [Complex64],
    ) -> Result<Complex64, ResponseError> {
        self.check_values(values)?;
        self.check_input(input)?;
        if gradient.len() != self.elements {
            return Err(ResponseError::ValueCount {
                expected: self.elements,
                found: gradient.len(),
            });
        }
        let terms = self.output_terms(form)?;
        self.direct_terms(values, input, &terms, omega, Some(gradient))
    }

    pub(crate) fn direct_terms(
        &self,
        values: &[f64],
        input: usize,
        terms: &[OutputTerm],
        omega: f64,
        gradient: Option<&mut [Complex64]>,
    ) -> Result<Complex64, ResponseError> {
        if !omega.is_finite() {
            return Err(ResponseError::NotFinite {
                what: "the frequency".into(),
            });
        }
        let singular = || ResponseError::SingularAt {
            hz: omega / std::f64::consts::TAU,
        };
        let matrix = self.dynamic_stiffness(values, omega);
        let lu = matrix.lu().ok_or_else(singular)?;
        let z = lu.solve(&self.excitation(values, input, omega));
        let powers = powers(omega);
        let factor = Complex64::ONE / powers_of(omega, self.host.inputs[input].kind.integrations());
        let weight = |term: &OutputTerm| {
            powers[term.order] * (term.coefficient * term.value.map_or(1.0, |index| values[index]))
        };
        let response: Complex64 = terms
            .iter()
            .map(|term| weight(term) * term.row.apply(z.data(), input))
            .sum::<Complex64>()
            * factor;
        if !response.is_finite() {
            return Err(singular());
        }
        if let Some(gradient) = gradient {
            gradient.fill(Complex64::ZERO);
            let mut right = Dense::zeros(self.size, 1);
            for term in terms {
                for &(i, a) in &term.row.coordinates {
                    right.add(i, 0, weight(term) * a);
                }
                if let Some(index) = term.value {
                    gradient[index] += powers[term.order]
                        * term.coefficient
                        * term.row.apply(z.data(), input)
                        * factor;
                }
            }
            let adjoint = matrix.transpose().lu().ok_or_else(singular)?.solve(&right);
            for stamp in &self.stamps {
                let through: Complex64 = stamp
                    .row
                    .coordinates
                    .iter()
                    .map(|&(i, a)| adjoint.get(i, 0) * a)
                    .sum();
                gradient[stamp.value] -=
                    powers[stamp.order] * through * stamp.row.apply(z.data(), input) * factor;
            }
        }
        Ok(response)
    }
}

/// 1, jω, (jω)².
pub(crate) fn powers(omega: f64) -> [Complex64; 3] {
    [
        Complex64::ONE,
        Complex64::new(0.0, omega),
        Complex64::new(-omega * omega, 0.0),
    ]
}

/// (jω)^order.
pub(crate) fn powers_of(omega: f64, order: usize) -> Complex64 {
    (0..order).fold(Complex64::ONE, |power, _| {
        power * Complex64::new(0.0, omega)
    })
}

/// Whether an element's name lies within the part (`track1.I` in `track1`).
pub(crate) fn is_within(element: &str, part: &str) -> bool {
    element
        .strip_prefix(part)
        .is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

fn check_order(what: &str, order: usize) -> Result<(), ResponseError> {
    if order <= 2 {
        Ok(())
    } else {
        Err(ResponseError::DerivativeOrder {
            what: what.to_owned(),
            order,
            most: 2,
        })
    }
}

/// The displacement of a node of a device on `port` whose internal nodes begin at `first` in z.
fn node_row(host: &LinearHost, port: usize, first: usize, node: Node) -> Row {
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
