//! Where the values of a candidate come from: given, searched within bounds, or as their element says.

use std::collections::HashSet;
use std::sync::Arc;

use indexmap::IndexMap;
use quell_document::{Fault, Source};
use quell_expression::{Dimension, Scope};
use quell_network::{Element, Kind};
use quell_search::{Scale, Variable};

use super::attach::Attachment;
use super::{LawValue, Origin, Values};
use crate::amount::Amount;
use crate::situation::Situation;
use crate::study::{Bounds, Study};

pub(super) struct Builder<'a> {
    pub(super) study: &'a Study,
    pub(super) situation: &'a Situation,
    pub(super) values: Values<'a>,
    pub(super) used: HashSet<String>,
    pub(super) variables: Vec<Variable>,
    pub(super) origins: Vec<Origin>,
    pub(super) names: Vec<Vec<String>>,
    pub(super) laws: Vec<LawValue>,
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
    /// Values of the variables of all networks.
    pub(super) fn assign(&mut self, attachments: &[Attachment]) -> Result<(), Fault> {
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
                    self.names.push(Vec::new());
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
                let mut names = wanted.keys;
                names.append(&mut wanted.bound_keys);
                self.names.push(names);
            }
        }
        Ok(())
    }

    /// Parameters of nonlinear elements: given, searched, or as their element says.
    pub(super) fn assign_laws(&mut self, attachments: &[Attachment]) -> Result<(), Fault> {
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
                        keys: keys.to_vec(),
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
        if let Some(value) = self.moved(wanted)? {
            return Ok(Origin::Moved(value));
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

    /// The middle of the range of a stable band that a value is the own parameter of.
    fn moved(&mut self, wanted: &Wanted<'_>) -> Result<Option<f64>, Fault> {
        let mut bands = self
            .study
            .criteria
            .values()
            .filter_map(|criterion| criterion.band.as_deref());
        let Some((range, of)) = bands
            .find(|band| band.is_of(&wanted.keys))
            .and_then(|band| Some((band.range.as_ref()?, band.of.clone())))
        else {
            return Ok(None);
        };
        let parameters = &self.situation.parameters;
        let from = range.from.value(parameters, wanted.dimension)?;
        let to = range.to.value(parameters, wanted.dimension)?;
        self.used.insert(of);
        Ok(Some(if from > 0.0 && to > 0.0 {
            (from * to).sqrt()
        } else {
            0.5 * (from + to)
        }))
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
