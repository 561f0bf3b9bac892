//! A host at one set of parameters.

use std::sync::Arc;

use indexmap::IndexMap;
use quell_document::Fault;
use quell_expression::{Dimension, Expression, ExpressionError, NoNames, Quantity};
use quell_model::{
    DevicePart, HostFile, LinearForm, LinearHost, NamedElement, Override, SignalNames,
};

use quell_network::{Component, ComponentVariable};

use crate::amount::Amount;
use crate::study::Study;

/// The host at one set of parameters, with the names that expressions of the study may use.
#[derive(Debug, Clone)]
pub(crate) struct Situation {
    /// The structure.
    pub host: Arc<LinearHost>,
    /// The host's parameters, SI.
    pub parameters: Vec<(String, Quantity)>,
    elements: Vec<NamedElement>,
}

/// Builds the host with the study's overrides and the values of a sweep.
///
/// # Errors
/// A parameter that the host does not have, a value that does not fit it, and whatever is then wrong with the host.
pub(crate) fn build(
    host: &HostFile,
    overrides: &IndexMap<String, Amount>,
    at: &[(String, Quantity)],
) -> Result<Situation, Fault> {
    let mut replaced: Vec<Override> = Vec::new();
    for (name, amount) in overrides {
        let mut value = amount.quantity(&NoNames)?;
        if amount.is_plain() && name_is_frequency(host, name)? {
            value = Quantity::new(
                amount.value(&NoNames, Dimension::ANGULAR_FREQUENCY)?,
                Dimension::ANGULAR_FREQUENCY,
            );
        }
        replaced.push(Override {
            name: name.clone(),
            value,
            place: Some(amount.place()),
        });
    }
    for (name, quantity) in at {
        replaced.retain(|known| known.name != *name);
        replaced.push(Override::new(name.clone(), *quantity));
    }
    let assembled = host
        .assemble(&replaced)
        .map_err(|fault| blamed(fault, host, &replaced))?;
    Ok(Situation {
        host: Arc::new(assembled.linear),
        parameters: assembled.parameters,
        elements: assembled.elements,
    })
}

/// A host that is sound as it stands and not with these values: the message says which.
fn blamed(fault: Fault, host: &HostFile, replaced: &[Override]) -> Fault {
    let in_host = fault
        .source
        .as_ref()
        .is_some_and(|source| Arc::ptr_eq(source, host.source()));
    if replaced.is_empty() || !in_host || host.assemble(&[]).is_err() {
        return fault;
    }
    let values: Vec<String> = replaced
        .iter()
        .map(|replaced| {
            let unit = replaced.value.dimension.unit_text();
            format!("`{} = {} {unit}`", replaced.name, replaced.value.value).replace(" `", "`")
        })
        .collect();
    let cause = format!("the study gives the host {}", values.join(", "));
    let help = match &fault.help {
        Some(help) => format!("{cause}; {help}"),
        None => cause,
    };
    fault.help(help)
}

/// Whether a parameter is a frequency, for which a plain number is refused.
fn name_is_frequency(host: &HostFile, name: &str) -> Result<bool, Fault> {
    let own = host.parameters(&[])?;
    Ok(own.iter().any(|(known, quantity)| {
        known == name && quantity.dimension == Dimension::ANGULAR_FREQUENCY
    }))
}

impl Situation {
    /// The study's components with their variables' dimensions at these parameters.
    ///
    /// # Errors
    /// Bounds that cannot be worked out.
    pub(crate) fn components(&self, study: &Study) -> Result<Vec<Component>, Fault> {
        study
            .components
            .iter()
            .map(|(name, component)| {
                let variables = component
                    .variables
                    .iter()
                    .map(|(variable, bounds)| {
                        let lower = bounds.lower.quantity(&self.parameters)?;
                        let upper = bounds.upper.quantity(&self.parameters)?;
                        let sample = 0.5 * (lower.value + upper.value);
                        Ok(ComponentVariable {
                            name: variable.clone(),
                            dimension: lower.dimension,
                            sample,
                        })
                    })
                    .collect::<Result<_, Fault>>()?;
                let values = component
                    .values
                    .iter()
                    .map(|(element, amount)| (element.clone(), amount.expression().clone()))
                    .collect();
                Ok(Component {
                    name: name.clone(),
                    layout: component.layout.clone(),
                    variables,
                    values,
                })
            })
            .collect()
    }

    /// The linear form of a signal, with its dimension over that of the input.
    ///
    /// # Errors
    /// As [`quell_model::linear_form`].
    pub(crate) fn signal(
        &self,
        expression: &Expression,
        devices: &[(String, usize)],
        parts: &[DevicePart],
        input: usize,
    ) -> Result<(LinearForm, Dimension), ExpressionError> {
        let names = SignalNames {
            constants: &self.parameters,
            elements: &self.elements,
            devices,
            parts,
            motions: false,
        };
        let (form, dimension) = quell_model::linear_form(&self.host, expression, &names)?;
        let over = self
            .host
            .inputs
            .get(input)
            .map_or(Dimension::NONE, |input| input.dimension);
        Ok((form, dimension / over))
    }
}
