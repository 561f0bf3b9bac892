//! A candidate built onto the host: networks on ports, and the way from design variables to element values.

mod assign;
mod attach;
mod moved;

use std::collections::HashSet;
use std::sync::Arc;

use indexmap::IndexMap;
use quell_document::Fault;
use quell_expression::Dimension;
use quell_model::DevicePart;
use quell_model::system::{Device as SystemDevice, ForceLaw, LawParameter};
use quell_network::ExpansionWorkspace;
use quell_response::Assembly;
use quell_search::{Scale, Variable};

use crate::amount::Amount;
use crate::candidates::Candidate;
use crate::outcome::{BuiltDevice, NamedValue};
use crate::situation::Situation;
use crate::study::{Bounds, DesignTask, Study};

pub(crate) use assign::range;
pub(crate) use attach::component_fault;
pub(crate) use moved::{Moved, Places};

use assign::Builder;
use attach::{Attachment, assembly};

/// What a candidate was built of, for building it again elsewhere.
#[derive(Debug)]
struct Recipe {
    candidate: Candidate,
    given: IndexMap<String, Amount>,
    bounds: IndexMap<String, Bounds>,
    searched: bool,
}

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

/// Where the value of a variable of the networks comes from.
#[derive(Debug, Clone, Copy)]
enum Origin {
    /// A design variable, by index.
    Searched(usize),
    /// A value that is given, SI.
    Given(f64),
    /// The own parameter of a stable band, which moves in it; a value within its range, SI, stands in.
    Moved(f64),
}

/// The value of a parameter of a nonlinear element.
#[derive(Debug, Clone)]
struct LawValue {
    attachment: usize,
    /// `gas.n`.
    name: String,
    /// Names under which something may be said of it, the most particular first.
    keys: Vec<String>,
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
    /// Of every one of them, names under which something may be said of it, the most particular first.
    names: Vec<Vec<String>>,
    laws: Vec<LawValue>,
    recipe: Arc<Recipe>,
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

/// Values of another scratch, each times its factor; factors that are left out are 1.
fn times(of: &ValueScratch, factors: &[f64], scratch: &mut ValueScratch) {
    let mut factors = factors.iter().copied().chain(std::iter::repeat(1.0));
    scratch.all.clear();
    let all = of.all.iter().zip(factors.by_ref());
    scratch
        .all
        .extend(all.map(|(value, factor)| value * factor));
    scratch.laws.clear();
    let laws = of.laws.iter().zip(factors);
    scratch
        .laws
        .extend(laws.map(|(value, factor)| value * factor));
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
            names: Vec::new(),
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
            names: builder.names,
            laws: builder.laws,
            recipe: Arc::new(Recipe {
                candidate: candidate.clone(),
                given: values.given.clone(),
                bounds: values.bounds.clone(),
                searched: values.searched,
            }),
        })
    }

    /// The same candidate at other parameters of the host.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub(crate) fn elsewhere(&self, study: &Study, situation: &Situation) -> Result<Self, Fault> {
        let recipe = &self.recipe;
        let values = Values {
            given: &recipe.given,
            bounds: &recipe.bounds,
            searched: recipe.searched,
        };
        Self::new(study, situation, &recipe.candidate, values)
    }

    /// For each value of the devices, those of nonlinear elements last, the names under which something may be said of
    /// it, the most particular first; none for what is no value.
    pub(crate) fn value_keys(&self) -> impl Iterator<Item = &[String]> {
        let laws = self.laws.iter().map(|law| law.keys.as_slice());
        self.names.iter().map(Vec::as_slice).chain(laws)
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
                Origin::Given(value) | Origin::Moved(value) => *value,
            }));
        scratch.mechanical.resize(self.element_count(), f64::NAN);
        scratch.laws.clear();
        scratch
            .laws
            .extend(self.laws.iter().map(|law| match law.origin {
                Origin::Searched(index) => point.get(index).copied().unwrap_or(f64::NAN),
                Origin::Given(value) | Origin::Moved(value) => value,
            }));
    }

    /// Mechanical values of all elements for values of the design variables, into `scratch.mechanical`.
    pub(crate) fn values(&self, point: &[f64], scratch: &mut ValueScratch) {
        self.spread(point, scratch);
        self.expand(scratch);
    }

    /// As [`Self::values`], of the values that `of` has for this candidate elsewhere, each times a factor.
    pub(crate) fn values_times(
        &self,
        of: &ValueScratch,
        factors: &[f64],
        scratch: &mut ValueScratch,
    ) {
        times(of, factors, scratch);
        scratch.mechanical.resize(self.element_count(), f64::NAN);
        self.expand(scratch);
    }

    fn expand(&self, scratch: &mut ValueScratch) {
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
        self.expand_with_derivatives(scratch);
    }

    /// As [`Self::values_times`], and prepares [`Self::chain`] for the gradient by the values before the factors.
    pub(crate) fn derivatives_times(
        &self,
        of: &ValueScratch,
        factors: &[f64],
        scratch: &mut ValueScratch,
    ) {
        times(of, factors, scratch);
        scratch.mechanical.resize(self.element_count(), f64::NAN);
        self.expand_with_derivatives(scratch);
        let mut derivatives = scratch.derivatives.iter_mut();
        for attachment in &self.attachments {
            let entries = attachment.expansion.entries().iter();
            for ((_, variable), derivative) in entries.zip(derivatives.by_ref()) {
                let factor = factors.get(attachment.variables.start + variable);
                *derivative *= factor.copied().unwrap_or(1.0);
            }
        }
    }

    fn expand_with_derivatives(&self, scratch: &mut ValueScratch) {
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
            .filter(|element| !self.moves(&element.name))
            .find(|element| !(element.value.is_finite() && element.value >= 0.0))
            .map(|element| (element.name, element.value))
    }

    /// Whether a value is the own parameter of a stable band, and nothing gives it another.
    fn moves(&self, name: &str) -> bool {
        self.moved_names().any(|known| known == name)
    }

    /// Values that nothing gives but the range of a stable band.
    pub(crate) fn moved_names(&self) -> impl Iterator<Item = &str> {
        self.attachments.iter().flat_map(|attachment| {
            let origins = self.origins.iter().skip(attachment.variables.start);
            let variables = attachment.expansion.variables().iter();
            variables
                .zip(origins)
                .filter(|(_, origin)| matches!(origin, Origin::Moved(_)))
                .map(|(variable, _)| variable.name.as_str())
        })
    }

    /// The devices with values, for results and reports.
    pub(crate) fn devices(&self, point: &[f64]) -> Vec<BuiltDevice> {
        let mut scratch = ValueScratch::default();
        self.spread(point, &mut scratch);
        // What moves in a band has no value.
        for (value, origin) in scratch.all.iter_mut().zip(&self.origins) {
            if matches!(origin, Origin::Moved(_)) {
                *value = f64::NAN;
            }
        }
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
                            Origin::Given(_) | Origin::Moved(_) => None,
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
                            Origin::Given(_) | Origin::Moved(_) => None,
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
