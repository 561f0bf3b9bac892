//! Devices on their ports: the layouts of a candidate, each with its place on the host.

use std::ops::Range;
use std::sync::Arc;

use quell_document::Fault;
use quell_expression::{Dimension, Span};
use quell_network::{Branch, ComponentError, Element, Expansion, Kind, Layout, Mechanism, expand};
use quell_response::{Assembly, Attached};

use super::assign::Builder;
use crate::amount::Amount;
use crate::candidates::Candidate;
use crate::situation::Situation;
use crate::study::{Device, Run, Slot, Study};

/// A device on its port.
#[derive(Debug, Clone)]
pub(super) struct Attachment {
    pub(super) name: String,
    pub(super) device: Device,
    pub(super) port: usize,
    pub(super) layout: Layout,
    pub(super) designed: String,
    /// Where its layout was asked for.
    pub(super) span: Span,
    /// Values of linear elements; springs stand in for nonlinear ones.
    pub(super) expansion: Expansion,
    /// Its elements between its nodes, nonlinear ones too, for runs in time.
    pub(super) mechanism: Option<Mechanism>,
    /// Its elements among all mechanical values.
    pub(super) elements: Range<usize>,
    /// Its variables among all.
    pub(super) variables: Range<usize>,
}

impl Attachment {
    /// Names of its nonlinear elements with their laws.
    pub(super) fn customs(&self) -> impl Iterator<Item = (&str, &str)> {
        self.layout
            .branches()
            .filter_map(|branch| match &branch.kind {
                Kind::Custom(custom) => Some((branch.name.as_str(), custom.law.as_str())),
                _ => None,
            })
    }

    pub(super) fn is_custom(&self, name: &str) -> bool {
        self.customs().any(|(known, _)| known == name)
    }
}

/// Host and networks of an all linear candidate.
pub(super) fn assembly(
    study: &Study,
    situation: &Situation,
    candidate: &Candidate,
    attachments: &[Attachment],
) -> Result<Arc<Assembly>, Fault> {
    let attached = attachments
        .iter()
        .map(|attachment| Attached {
            port: attachment.port,
            network: Arc::new(attachment.expansion.network().clone()),
        })
        .collect();
    Assembly::new(Arc::clone(&situation.host), attached)
        .map(Arc::new)
        .map_err(|error| {
            let span = candidate
                .layouts
                .first()
                .map_or(Span::new(0, 0), |(_, _, span)| *span);
            Fault::at(
                &study.source,
                span,
                format!(
                    "`{}` on `{}`: {error}",
                    candidate.label(),
                    situation.host.name
                ),
            )
        })
}

/// The same layout with springs in the places of nonlinear elements.
fn linear_stand_in(layout: &Layout) -> Option<Layout> {
    let stand_in = layout.tree().map(&mut |branch: &Branch| {
        let mut branch = branch.clone();
        if matches!(branch.kind, Kind::Custom(_)) {
            branch.kind = Kind::Element(Element::Spring);
        }
        branch
    });
    Layout::from_tree(layout.domain(), stand_in)
}

impl Builder<'_> {
    /// The networks on their ports.
    ///
    /// # Errors
    /// A layout that its port cannot take.
    pub(super) fn attach(&self, candidate: &Candidate) -> Result<Vec<Attachment>, Fault> {
        let mut attachments: Vec<Attachment> = Vec::new();
        let (mut first_element, mut first_variable) = (0, 0);
        for (name, device) in &self.study.devices {
            let own: Vec<&(Slot, Layout, Span)> = candidate
                .layouts
                .iter()
                .filter(|(slot, _, _)| slot.device == *name)
                .collect();
            let span = own.first().map_or(device.span, |(_, _, span)| *span);
            let fault = |message: String| Fault::at(&self.study.source, span, message);
            let layout = match &device.layout {
                None => match own.first() {
                    Some((_, layout, _)) => layout.clone(),
                    None => continue,
                },
                Some(_) if own.is_empty() && !device.slots.is_empty() => continue,
                Some(around) => {
                    let mut layout = around.clone();
                    for slot in &device.slots {
                        let Some((_, inner, _)) = own
                            .iter()
                            .find(|(known, _, _)| known.placeholder.as_deref() == Some(slot))
                        else {
                            return Err(fault(format!(
                                "the slot `{slot}` of `{name}` is left empty"
                            )));
                        };
                        layout = layout
                            .substitute(slot, inner)
                            .map_err(|error| fault(error.to_string()))?;
                    }
                    layout
                }
            };
            let (layout, port) = self.at_port(name, device, layout, span)?;
            let designed = match own.as_slice() {
                [(_, designed, _)] => designed.to_string(),
                _ => layout.to_string(),
            };
            let piston = match &device.piston {
                Some(amount) => {
                    let area = amount.value(&self.situation.parameters, Dimension::AREA)?;
                    if area <= 0.0 {
                        return Err(amount.fault(format!(
                            "the piston of `{name}` has an area of {area} m^2, which is not above zero"
                        )));
                    }
                    Some(area)
                }
                None => None,
            };
            let components = self.situation.components(self.study)?;
            let nonlinear = layout
                .branches()
                .any(|branch| matches!(branch.kind, Kind::Custom(_)));
            let stand_in = nonlinear.then(|| linear_stand_in(&layout)).flatten();
            let expansion = expand(
                stand_in.as_ref().unwrap_or(&layout),
                &components,
                piston,
                &self.situation.parameters,
            )
            .map_err(|error| component_fault(self.study, error, span))?;
            let in_time = self
                .study
                .runs
                .values()
                .any(|run| matches!(run, Run::Transient(_)))
                || self.study.follows_branches();
            let mechanism = if in_time || nonlinear || self.situation.is_equations() {
                let made = Mechanism::with_components(&layout, &components, piston);
                Some(made.map_err(|error| fault(error.to_string()))?)
            } else {
                None
            };
            let elements = first_element..first_element + expansion.network().elements().len();
            let variables = first_variable..first_variable + expansion.variables().len();
            (first_element, first_variable) = (elements.end, variables.end);
            attachments.push(Attachment {
                name: name.clone(),
                device: device.clone(),
                port,
                layout,
                designed,
                span,
                expansion,
                mechanism,
                elements,
                variables,
            });
        }
        Ok(attachments)
    }

    /// A mass can only stand where the far side of the device is the inertial frame.
    fn at_port(
        &self,
        name: &str,
        device: &Device,
        layout: Layout,
        span: Span,
    ) -> Result<(Layout, usize), Fault> {
        let fault = |message: String| Fault::at(&self.study.source, span, message);
        let found = self
            .situation
            .host
            .ports
            .iter()
            .enumerate()
            .find(|(_, port)| port.name == device.port);
        let Some((index, port)) = found else {
            return Err(Fault::at(
                &self.study.source,
                device.port_span,
                format!("the host has no port `{}`", device.port),
            ));
        };
        if port.hangs {
            let placed = layout.place_mass().map_err(|error| {
                fault(format!(
                    "`{layout}` cannot hang at the port `{}` of `{name}`: {error}",
                    port.name
                ))
                .help("a device at one point ends in a mass: `(k1 | c1) + m1`")
            })?;
            return Ok((placed, index));
        }
        if !layout.contains_mass() {
            return Ok((layout, index));
        }
        if !port.grounded {
            return Err(fault(format!(
                "`{layout}` holds a mass, but the port `{}` of `{name}` lies between two moving points",
                port.name
            ))
            .help("a mass has one terminal in the inertial frame: use a port `at = \"…\"`"));
        }
        Ok((
            layout
                .place_mass()
                .map_err(|error| fault(error.to_string()))?,
            index,
        ))
    }
}

/// What is wrong with a component, at the value at fault where it is known and else at `span`.
pub(crate) fn component_fault(study: &Study, error: ComponentError, span: Span) -> Fault {
    let source = &study.source;
    let place = |component: &str, element: &str| {
        let known = study.components.get(component);
        known
            .and_then(|known| known.values.get(element))
            .map_or(span, Amount::span)
    };
    match error {
        ComponentError::Expression {
            component,
            element,
            error,
        } => {
            let helped = error.help.is_some();
            // A value that has no number at the middle of its bounds has no place of its own in the text.
            let fault = if error.span == Span::default() {
                Fault::at(source, place(&component, &element), error.message)
            } else {
                Fault::from_expression(source, error)
            };
            if helped {
                fault
            } else {
                fault.help(format!(
                    "a value may use the `variables` of `{component}`, each tried in the middle of its bounds, and the host's parameters"
                ))
            }
        }
        ComponentError::Dimension {
            ref component,
            ref element,
            ..
        } => Fault::at(source, place(component, element), error.to_string()),
        other => Fault::at(source, span, other.to_string()),
    }
}
