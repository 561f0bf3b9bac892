//! Outputs of an assembly as terms over its coordinates, inputs and element values.

use quell_model::linear::{LinearForm, Signal};
use quell_network::Node;

use super::row::{Row, node_row};
use super::{Assembly, Device};
use crate::error::ResponseError;

/// A term of an output: coefficient · [value] · d^order/dt^order (row).
#[derive(Debug, Clone)]
pub(crate) struct OutputTerm {
    pub(crate) order: usize,
    /// Index of the element value that multiplies it (forces), if any.
    pub(crate) value: Option<usize>,
    pub(crate) coefficient: f64,
    pub(crate) row: Row,
}

impl Assembly {
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
}

/// Whether an element's name lies within the part (`track1.I` in `track1`).
fn is_within(element: &str, part: &str) -> bool {
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
