//! A candidate built onto the host: networks on ports, and the way from design variables to element values.

mod moved;

use std::collections::HashSet;
use std::ops::Range;
use std::sync::Arc;

use indexmap::IndexMap;
use quell_document::{Fault, Source};
use quell_expression::{Dimension, Scope, Span};
use quell_model::DevicePart;
use quell_model::system::{Device as SystemDevice, ForceLaw, LawParameter};
use quell_network::{
    Branch, ComponentError, Domain, Element, Expansion, ExpansionWorkspace, Kind, Layout,
    Mechanism, expand,
};
use quell_response::{Assembly, Attached};
use quell_search::{Scale, Variable};

use crate::amount::Amount;
use crate::candidates::Candidate;
use crate::outcome::{BuiltDevice, NamedValue};
use crate::situation::Situation;
use crate::study::{Bounds, DesignTask, Device, Run, Slot, Study};

pub(crate) use moved::Places;

/// Where values come from.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Values<'a> {
    /// Values that are given.
    pub given: &'a IndexMap<String, Amount>,
    /// Ranges of values that are searched.
    pub bounds: &'a IndexMap<String, Bounds>,
    /// Whether anything may be searched; otherwise a value that is not given is an error.
    pub searched: bool,
}

impl<'a> Values<'a> {
    /// Those of a design task.
    pub(crate) fn searched(design: &'a DesignTask) -> Self {
        Self {
            given: &design.fixed,
            bounds: &design.bounds,
            searched: true,
        }
    }
}

/// A device on its port.
#[derive(Debug, Clone)]
struct Attachment {
    name: String,
    device: Device,
    port: usize,
    layout: Layout,
    designed: String,
    /// Where its layout was asked for.
    span: Span,
    /// Values of linear elements; springs stand in for nonlinear ones.
    expansion: Expansion,
    /// Its elements between its nodes, nonlinear ones too, for runs in time.
    mechanism: Option<Mechanism>,
    /// Its elements among all mechanical values.
    elements: Range<usize>,
    /// Its variables among all.
    variables: Range<usize>,
}

/// Where the value of a variable of the networks comes from.
#[derive(Debug, Clone, Copy)]
enum Origin {
    /// A design variable, by index.
    Searched(usize),
    /// A value that is given, SI.
    Given(f64),
}

/// The value of a parameter of a nonlinear element.
#[derive(Debug, Clone)]
struct LawValue {
    attachment: usize,
    /// `gas.n`.
    name: String,
    dimension: Dimension,
    origin: Origin,
    /// Whether it is other than the default.
    shown: bool,
}

/// A candidate on the host, ready for values of its design variables.
#[derive(Debug)]
pub(crate) struct Built {
    /// Host and networks, where all is linear.
    pub assembly: Option<Arc<Assembly>>,
    /// The design variables.
    pub variables: Vec<Variable>,
    /// Keys of the study that were used, so that one that is never used can be refused.
    pub used: HashSet<String>,
    attachments: Vec<Attachment>,
    /// Of every variable of every network.
    origins: Vec<Origin>,
    laws: Vec<LawValue>,
}

/// Buffers of [`Built::values`].
#[derive(Debug, Clone, Default)]
pub(crate) struct ValueScratch {
    workspace: ExpansionWorkspace,
    all: Vec<f64>,
    derivatives: Vec<f64>,
    /// Mechanical values of all elements, SI.
    pub mechanical: Vec<f64>,
    /// Parameters of all nonlinear elements, SI.
    pub laws: Vec<f64>,
}

impl Built {
    /// Builds a candidate.
    ///
    /// # Errors
    /// A layout that its port cannot take, an element or variable without value or bounds, amounts of the wrong dimension.
    pub(crate) fn new(
        study: &Study,
        situation: &Situation,
        candidate: &Candidate,
        values: Values<'_>,
    ) -> Result<Self, Fault> {
        let mut builder = Builder {
            study,
            situation,
            values,
            used: HashSet::new(),
            variables: Vec::new(),
            origins: Vec::new(),
            laws: Vec::new(),
        };
        let attachments = builder.attach(candidate)?;
        builder.assign(&attachments)?;
        builder.assign_laws(&attachments)?;
        let linear = !situation.is_equations()
            && attachments
                .iter()
                .all(|attachment| attachment.customs().next().is_none());
        let assembly = if linear {
            Some(assembly(study, situation, candidate, &attachments)?)
        } else {
            None
        };
        Ok(Self {
            assembly,
            variables: builder.variables,
            used: builder.used,
            attachments,
            origins: builder.origins,
            laws: builder.laws,
        })
    }

    /// Number of elements of all devices.
    fn element_count(&self) -> usize {
        self.attachments
            .last()
            .map_or(0, |attachment| attachment.elements.end)
    }

    /// The devices as a system of equations takes them.
    ///
    /// # Errors
    /// What is wrong with the force of a nonlinear element, at its place.
    pub(crate) fn system_devices(
        &self,
        study: &Study,
        host: &quell_model::EquationHost,
    ) -> Result<Vec<SystemDevice>, Fault> {
        // Somewhere within the bounds; values come later, these only guide the order of elimination.
        let point: Vec<f64> = self
            .variables
            .iter()
            .map(|variable| match variable.scale {
                Scale::Logarithmic => (variable.lower * variable.upper).sqrt(),
                Scale::Linear => 0.5 * (variable.lower + variable.upper),
            })
            .collect();
        let mut scratch = ValueScratch::default();
        self.values(&point, &mut scratch);
        let mut devices = Vec::new();
        for (index, attachment) in self.attachments.iter().enumerate() {
            let Some(mechanism) = &attachment.mechanism else {
                continue;
            };
            let mut device =
                SystemDevice::new(attachment.name.clone(), attachment.port, mechanism.clone());
            let values = scratch
                .mechanical
                .get(attachment.elements.clone())
                .unwrap_or_default();
            for (element, value) in mechanism.elements().iter().zip(values) {
                device = device.with_value(&element.name, *value);
            }
            for (branch, law_name) in attachment.customs() {
                let Some((law, port)) = study
                    .laws
                    .get(law_name)
                    .zip(host.ports.get(attachment.port))
                else {
                    continue;
                };
                let own = self
                    .laws
                    .iter()
                    .zip(&scratch.laws)
                    .filter_map(|(known, value)| {
                        let name = known
                            .name
                            .strip_prefix(branch)
                            .and_then(|rest| rest.strip_prefix('.'))
                            .filter(|_| known.attachment == index)?;
                        Some(LawParameter {
                            name: name.to_owned(),
                            dimension: known.dimension,
                            value: *value,
                        })
                    });
                let lowered = ForceLaw::lower(
                    host,
                    &law.force,
                    own.collect(),
                    port.dimension,
                    port.force_dimension,
                )
                .map_err(|error| Fault::from_expression(&study.source, error))?;
                device = device.with_law(law_name, lowered);
            }
            devices.push(device);
        }
        Ok(devices)
    }

    /// Of each device, the first of its elements among all.
    pub(crate) fn first_elements(&self) -> Vec<usize> {
        self.attachments
            .iter()
            .map(|attachment| attachment.elements.start)
            .collect()
    }

    /// The place of a parameter of a nonlinear element, `gas.n` of a device, among all of them.
    pub(crate) fn law_place(&self, device: usize, name: &str) -> Option<usize> {
        self.laws
            .iter()
            .position(|law| law.attachment == device && law.name == name)
    }

    fn spread(&self, point: &[f64], scratch: &mut ValueScratch) {
        scratch.all.clear();
        scratch
            .all
            .extend(self.origins.iter().map(|origin| match origin {
                Origin::Searched(index) => point.get(*index).copied().unwrap_or(f64::NAN),
                Origin::Given(value) => *value,
            }));
        scratch.mechanical.resize(self.element_count(), f64::NAN);
        scratch.laws.clear();
        scratch
            .laws
            .extend(self.laws.iter().map(|law| match law.origin {
                Origin::Searched(index) => point.get(index).copied().unwrap_or(f64::NAN),
                Origin::Given(value) => value,
            }));
    }

    /// Mechanical values of all elements for values of the design variables, into `scratch.mechanical`.
    pub(crate) fn values(&self, point: &[f64], scratch: &mut ValueScratch) {
        self.spread(point, scratch);
        for attachment in &self.attachments {
            let variables = scratch
                .all
                .get(attachment.variables.clone())
                .unwrap_or_default();
            let values = scratch
                .mechanical
                .get_mut(attachment.elements.clone())
                .unwrap_or_default();
            attachment
                .expansion
                .values(variables, &mut scratch.workspace, values);
        }
    }

    /// As [`Self::values`], and prepares [`Self::chain`].
    pub(crate) fn values_with_derivatives(&self, point: &[f64], scratch: &mut ValueScratch) {
        self.spread(point, scratch);
        let entries = self
            .attachments
            .iter()
            .map(|attachment| attachment.expansion.entries().len())
            .sum();
        scratch.derivatives.resize(entries, f64::NAN);
        let mut rest = scratch.derivatives.as_mut_slice();
        for attachment in &self.attachments {
            let Some((own, following)) =
                rest.split_at_mut_checked(attachment.expansion.entries().len())
            else {
                return;
            };
            rest = following;
            let variables = scratch
                .all
                .get(attachment.variables.clone())
                .unwrap_or_default();
            let values = scratch
                .mechanical
                .get_mut(attachment.elements.clone())
                .unwrap_or_default();
            attachment
                .expansion
                .derivatives(variables, &mut scratch.workspace, values, own);
        }
    }

    /// The gradient by design variables of `factor` times a number whose gradient by mechanical values is given, at the
    /// point of the last [`Self::values_with_derivatives`]; as many entries as design variables.
    pub(crate) fn chain(
        &self,
        by_value: &[f64],
        factor: f64,
        scratch: &ValueScratch,
        gradient: &mut [f64],
    ) {
        gradient.fill(0.0);
        let mut derivatives = scratch.derivatives.iter();
        for attachment in &self.attachments {
            for ((element, variable), derivative) in attachment
                .expansion
                .entries()
                .iter()
                .zip(derivatives.by_ref())
            {
                let Some(Origin::Searched(index)) =
                    self.origins.get(attachment.variables.start + variable)
                else {
                    continue;
                };
                let value = by_value
                    .get(attachment.elements.start + element)
                    .copied()
                    .unwrap_or(f64::NAN);
                if let Some(entry) = gradient.get_mut(*index) {
                    *entry += factor * value * derivative;
                }
            }
        }
    }

    /// Devices and their ports, and their parts, for signals.
    pub(crate) fn signal_names(&self) -> (Vec<(String, usize)>, Vec<DevicePart>) {
        let mut devices = Vec::new();
        let mut parts = Vec::new();
        for attachment in &self.attachments {
            devices.push((attachment.name.clone(), attachment.port));
            parts.extend(
                attachment
                    .expansion
                    .network()
                    .parts()
                    .map(|(part, _)| DevicePart {
                        device: attachment.name.clone(),
                        port: attachment.port,
                        part: part.to_owned(),
                    }),
            );
        }
        (devices, parts)
    }

    /// Names under which values may be given, and those of the places that take a layout.
    pub(crate) fn value_names(&self) -> Vec<String> {
        self.attachments
            .iter()
            .flat_map(|attachment| {
                let variables = attachment
                    .expansion
                    .variables()
                    .iter()
                    .filter(|variable| !attachment.is_custom(&variable.name));
                let own = match &attachment.device.layout {
                    None => vec![attachment.name.clone()],
                    Some(_) => attachment.device.slots.clone(),
                };
                variables.map(|variable| variable.name.clone()).chain(own)
            })
            .chain(self.laws.iter().map(|law| law.name.clone()))
            .collect()
    }

    /// Name and own value of an element whose value is not finite, or negative, at these design variables.
    pub(crate) fn impossible_value(&self, point: &[f64]) -> Option<(String, f64)> {
        self.devices(point)
            .into_iter()
            .flat_map(|device| device.elements)
            .find(|element| !(element.value.is_finite() && element.value >= 0.0))
            .map(|element| (element.name, element.value))
    }

    /// The devices with values, for results and reports.
    pub(crate) fn devices(&self, point: &[f64]) -> Vec<BuiltDevice> {
        let mut scratch = ValueScratch::default();
        self.spread(point, &mut scratch);
        self.attachments
            .iter()
            .enumerate()
            .map(|(index, attachment)| {
                let network = attachment.expansion.network();
                let variables = scratch
                    .all
                    .get(attachment.variables.clone())
                    .unwrap_or_default();
                let mut own = vec![f64::NAN; network.elements().len()];
                attachment
                    .expansion
                    .own_values(variables, &mut scratch.workspace, &mut own);
                let elements = network
                    .elements()
                    .iter()
                    .zip(own)
                    .filter(|(element, _)| !attachment.is_custom(&element.name))
                    .map(|(element, value)| NamedValue {
                        name: element.name.clone(),
                        value,
                        unit: element.domain.unit(element.element).to_owned(),
                        bounds: None,
                        logarithmic: false,
                    });
                let origins = self.origins.iter().skip(attachment.variables.start);
                let named = attachment
                    .expansion
                    .variables()
                    .iter()
                    .zip(origins)
                    .zip(variables)
                    .filter(|((variable, _), _)| !attachment.is_custom(&variable.name))
                    .map(|((variable, origin), value)| {
                        let searched = match origin {
                            Origin::Searched(index) => self.variables.get(*index),
                            Origin::Given(_) => None,
                        };
                        NamedValue {
                            name: variable.name.clone(),
                            value: *value,
                            unit: variable.dimension.unit_text(),
                            bounds: searched.map(|variable| (variable.lower, variable.upper)),
                            logarithmic: searched
                                .is_some_and(|variable| variable.scale == Scale::Logarithmic),
                        }
                    });
                let laws = self
                    .laws
                    .iter()
                    .zip(&scratch.laws)
                    .filter(|(law, _)| law.shown && law.attachment == index)
                    .map(|(law, value)| {
                        let searched = match law.origin {
                            Origin::Searched(index) => self.variables.get(index),
                            Origin::Given(_) => None,
                        };
                        NamedValue {
                            name: law.name.clone(),
                            value: *value,
                            unit: law.dimension.unit_text(),
                            bounds: searched.map(|variable| (variable.lower, variable.upper)),
                            logarithmic: searched
                                .is_some_and(|variable| variable.scale == Scale::Logarithmic),
                        }
                    });
                BuiltDevice {
                    name: attachment.name.clone(),
                    domain: attachment.layout.domain(),
                    designed: attachment.designed.clone(),
                    layout: attachment.layout.clone(),
                    variables: named.chain(laws).collect(),
                    elements: elements.collect(),
                }
            })
            .collect()
    }
}

struct Builder<'a> {
    study: &'a Study,
    situation: &'a Situation,
    values: Values<'a>,
    used: HashSet<String>,
    variables: Vec<Variable>,
    origins: Vec<Origin>,
    laws: Vec<LawValue>,
}

impl Attachment {
    /// Names of its nonlinear elements with their laws.
    fn customs(&self) -> impl Iterator<Item = (&str, &str)> {
        self.layout
            .branches()
            .filter_map(|branch| match &branch.kind {
                Kind::Custom(custom) => Some((branch.name.as_str(), custom.law.as_str())),
                _ => None,
            })
    }

    fn is_custom(&self, name: &str) -> bool {
        self.customs().any(|(known, _)| known == name)
    }
}

/// Host and networks of an all linear candidate.
fn assembly(
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

/// A variable of a network, with what is needed to find its value.
struct Wanted<'a> {
    attachment: &'a Attachment,
    name: &'a str,
    dimension: Dimension,
    /// Of a plain element: what it is.
    element: Option<Element>,
    /// Whether it stands in the device's fixed layout.
    in_frame: bool,
    /// Keys under which a value may be given, the most particular first.
    keys: Vec<String>,
    /// Further keys under which bounds may be given.
    bound_keys: Vec<String>,
    /// Whether another device uses the same name.
    shared: bool,
    /// Bounds that come with a component.
    own_bounds: Option<&'a Bounds>,
}

impl<'a> Builder<'a> {
    fn attach(&self, candidate: &Candidate) -> Result<Vec<Attachment>, Fault> {
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

    fn assign(&mut self, attachments: &[Attachment]) -> Result<(), Fault> {
        // A name that several devices use is told apart by the device's.
        let mut seen: IndexMap<&str, usize> = IndexMap::new();
        for variable in attachments
            .iter()
            .flat_map(|attachment| attachment.expansion.variables())
        {
            *seen.entry(variable.name.as_str()).or_default() += 1;
        }
        for attachment in attachments {
            let device = &attachment.name;
            for variable in attachment.expansion.variables() {
                let name = variable.name.as_str();
                if attachment.is_custom(name) {
                    self.origins.push(Origin::Given(1.0));
                    continue;
                }
                let shared = seen.get(name).is_some_and(|count| *count > 1);
                let mut keys = vec![format!("{device}.{name}")];
                if !shared {
                    keys.push(name.to_owned());
                }
                let element = attachment
                    .layout
                    .branch(name)
                    .and_then(|branch| match branch.kind {
                        Kind::Element(element) => Some(element),
                        _ => None,
                    });
                let frame = attachment.device.layout.as_ref();
                let mut wanted = Wanted {
                    attachment,
                    name,
                    dimension: variable.dimension,
                    element,
                    in_frame: frame.is_some_and(|frame| frame.branch(&variable.branch).is_some()),
                    keys,
                    bound_keys: Vec::new(),
                    shared,
                    own_bounds: None,
                };
                if let Some((kind, inner)) = &variable.component {
                    // What is said of the kind holds for every instance.
                    wanted.keys.push(format!("{kind}.{inner}"));
                    if self.study.immittances.contains_key(kind) {
                        wanted.bound_keys = vec![format!("{device}.{inner}"), inner.clone()];
                    } else {
                        wanted.own_bounds = self
                            .study
                            .components
                            .get(kind)
                            .and_then(|component| component.variables.get(inner));
                    }
                } else {
                    let stem = name.trim_end_matches(|character: char| character.is_ascii_digit());
                    wanted.bound_keys = vec![format!("{device}.{stem}"), stem.to_owned()];
                }
                let origin = self.origin(&wanted)?;
                self.origins.push(origin);
            }
        }
        Ok(())
    }

    /// Parameters of nonlinear elements: given, searched, or as their element says.
    fn assign_laws(&mut self, attachments: &[Attachment]) -> Result<(), Fault> {
        let parameters = &self.situation.parameters;
        for (index, attachment) in attachments.iter().enumerate() {
            for (branch, law) in attachment.customs() {
                let Some(spec) = self.study.laws.get(law) else {
                    continue;
                };
                for (parameter, usual) in &spec.parameters {
                    let name = format!("{branch}.{parameter}");
                    let keys = [
                        format!("{}.{name}", attachment.name),
                        name.clone(),
                        format!("{law}.{parameter}"),
                    ];
                    let dimension = usual.quantity(parameters)?.dimension;
                    let given = keys
                        .iter()
                        .find_map(|key| self.values.given.get(key).map(|amount| (key, amount)));
                    let bounds = keys
                        .iter()
                        .filter(|_| self.values.searched)
                        .find_map(|key| self.values.bounds.get(key).map(|bounds| (key, bounds)));
                    let (origin, shown) = if let Some((key, amount)) = given {
                        self.used.insert(key.clone());
                        (Origin::Given(amount.value(parameters, dimension)?), true)
                    } else if let Some((key, bounds)) = bounds {
                        self.used.insert(key.clone());
                        let variable = range(
                            name.clone(),
                            dimension,
                            bounds,
                            parameters,
                            &self.study.source,
                        )?;
                        self.variables.push(variable);
                        (Origin::Searched(self.variables.len() - 1), true)
                    } else {
                        (Origin::Given(usual.value(parameters, dimension)?), false)
                    };
                    self.laws.push(LawValue {
                        attachment: index,
                        name,
                        dimension,
                        origin,
                        shown,
                    });
                }
            }
        }
        Ok(())
    }

    fn origin(&mut self, wanted: &Wanted<'_>) -> Result<Origin, Fault> {
        let parameters = &self.situation.parameters;
        let given: Option<(&String, &'a Amount)> = wanted
            .keys
            .iter()
            .find_map(|key| self.values.given.get(key).map(|amount| (key, amount)));
        let fixed = wanted
            .attachment
            .device
            .values
            .get(wanted.name)
            .filter(|_| wanted.in_frame);
        if let Some((key, _)) = given {
            self.used.insert(key.clone());
        }
        if let Some(amount) = given.map(|(_, amount)| amount).or(fixed) {
            let value = amount.value(parameters, wanted.dimension)?;
            if let Some(element) = wanted.element.filter(|_| value < 0.0) {
                let what = wanted.attachment.layout.domain().element_name(element);
                return Err(
                    amount.fault(format!("`{}` is negative: a {what} cannot be", wanted.name))
                );
            }
            return Ok(Origin::Given(value));
        }
        if self.values.searched {
            let keys = wanted.keys.iter().chain(&wanted.bound_keys);
            let found = keys
                .into_iter()
                .find_map(|key| self.values.bounds.get(key).map(|bounds| (key, bounds)));
            if let Some((key, _)) = found {
                self.used.insert(key.clone());
            }
            if let Some(bounds) = found.map(|(_, bounds)| bounds).or(wanted.own_bounds) {
                return self.variable(wanted, bounds);
            }
        }
        let parameter = parameters
            .quantity(wanted.name)
            .filter(|_| wanted.in_frame && wanted.element.is_some());
        match parameter {
            Some(parameter) if wanted.dimension.accepts(&parameter.dimension) => Ok(Origin::Given(parameter.value)),
            Some(parameter) => Err(Fault::at(
                &self.study.source,
                wanted.attachment.device.span,
                format!(
                    "the host's parameter `{}` is in {}, but the element of that name in `{}` in {}",
                    wanted.name, parameter.dimension, wanted.attachment.name, wanted.dimension
                ),
            )
            .help(format!("give it under `values` of the device: `{} = …`", wanted.name))),
            None => Err(self.nothing_for(wanted)),
        }
    }

    /// Neither value nor bounds.
    fn nothing_for(&self, wanted: &Wanted<'_>) -> Fault {
        let name = wanted.name;
        let what = if self.values.searched {
            "neither bounds nor a value"
        } else {
            "no value"
        };
        let fault = Fault::at(
            &self.study.source,
            if wanted.in_frame {
                wanted.attachment.device.span
            } else {
                wanted.attachment.span
            },
            format!(
                "`{name}` in the layout `{}` of `{}` has {what}",
                wanted.attachment.layout, wanted.attachment.name
            ),
        );
        let unit = wanted.dimension.unit_text();
        let key = if name.contains('.') {
            format!("\"{name}\"")
        } else {
            name.to_owned()
        };
        let example = if unit.is_empty() {
            "…".to_owned()
        } else {
            format!("\"… {unit}\"")
        };
        fault.help(if wanted.in_frame && wanted.element.is_some() {
            format!(
                "add `{key} = {example}` to `values` of the device, or give the host a parameter of that name"
            )
        } else if self.values.searched {
            format!(
                "add it to `bounds` of the task (`{key} = [{example}, {example}]`) or to `fixed`"
            )
        } else {
            format!("add `{key} = {example}` to the configuration")
        })
    }

    fn variable(&mut self, wanted: &Wanted<'_>, bounds: &Bounds) -> Result<Origin, Fault> {
        let lower = bounds
            .lower
            .value(&self.situation.parameters, wanted.dimension)?;
        if let Some(element) = wanted.element.filter(|_| lower < 0.0) {
            let what = wanted.attachment.layout.domain().element_name(element);
            return Err(bounds
                .lower
                .fault(format!(
                    "the lower bound of `{}` is negative: a {what} cannot be",
                    wanted.name
                ))
                .help(
                    "a lower bound of 0 or a little more lets the search leave the element out",
                ));
        }
        let shown = if wanted.shared {
            format!("{}.{}", wanted.attachment.name, wanted.name)
        } else {
            wanted.name.to_owned()
        };
        let variable = range(
            shown,
            wanted.dimension,
            bounds,
            &self.situation.parameters,
            &self.study.source,
        )?;
        self.variables.push(variable);
        Ok(Origin::Searched(self.variables.len() - 1))
    }
}

/// A design variable from its bounds.
///
/// # Errors
/// Bounds of another dimension, not finite, equal or reversed, or not positive where the scale is logarithmic.
pub(crate) fn range(
    name: String,
    dimension: Dimension,
    bounds: &Bounds,
    parameters: &dyn Scope,
    source: &Arc<Source>,
) -> Result<Variable, Fault> {
    let lower = bounds.lower.value(parameters, dimension)?;
    let upper = bounds.upper.value(parameters, dimension)?;
    let wide = lower > 0.0 && upper >= 10.0 * lower;
    let scale = bounds.scale.unwrap_or(if wide {
        Scale::Logarithmic
    } else {
        Scale::Linear
    });
    let fault = |message: String| Fault::at(source, bounds.span, message);
    if lower == upper {
        return Err(fault(format!("the two bounds of `{name}` are the same"))
            .help("a value that does not vary belongs to `fixed`"));
    }
    if lower > upper {
        return Err(fault(format!(
            "the lower bound of `{name}` is above the upper one"
        ))
        .help("exchange them: bounds are `[lower, upper]`"));
    }
    if scale == Scale::Logarithmic && lower <= 0.0 {
        return Err(fault(format!(
            "`{name}` is searched on a logarithmic scale, but its lower bound is not above zero"
        ))
        .help("raise the bound, or write `scale = \"linear\"`"));
    }
    Variable::new(name, lower, upper, scale).map_err(|error| fault(error.to_string()))
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

/// Domain of a device's layouts.
pub(crate) fn domain_of(study: &Study, slot: &Slot) -> Domain {
    study
        .devices
        .get(&slot.device)
        .map_or(Domain::Translational, |device| device.domain)
}
