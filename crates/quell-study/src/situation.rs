//! A host at one set of parameters.

use std::sync::{Arc, OnceLock};

use faer::Mat;
use indexmap::IndexMap;
use quell_document::Fault;
use quell_expression::{Dimension, Expression, ExpressionError, NoNames, Quantity};
use quell_model::{
    Coordinate, CoordinateKind, DevicePart, EquationHost, EquationInputKind, Host, HostFile, Input,
    InputKind, LinearForm, LinearHost, Measure, NamedElement, Override, Port, SignalNames,
};

use quell_network::{Component, ComponentVariable};

use crate::amount::Amount;
use crate::study::Study;

/// The host at one set of parameters, with the names that expressions of the study may use.
#[derive(Debug, Clone)]
pub(crate) struct Situation {
    /// The structure. Of a host written as equations: names of coordinates, inputs and ports, without matrices.
    pub host: Arc<LinearHost>,
    /// The host's parameters, SI.
    pub parameters: Vec<(String, Quantity)>,
    /// Values that a sweep gave.
    at: Vec<(String, Quantity)>,
    elements: Vec<NamedElement>,
    /// A linear host as it was read, from which its equations are made when a run in time asks for them.
    assembled: Option<Arc<Host>>,
    equations: OnceLock<Arc<EquationHost>>,
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
    if host.is_equations() {
        let equations = host
            .equations(&replaced)
            .map_err(|fault| blamed(fault, host, &replaced))?;
        let parameters = equations
            .parameters
            .iter()
            .map(|parameter| (parameter.name.clone(), parameter.value))
            .collect();
        return Ok(Situation {
            host: Arc::new(names_of(&equations)),
            parameters,
            at: at.to_vec(),
            elements: Vec::new(),
            assembled: None,
            equations: OnceLock::from(Arc::new(equations)),
        });
    }
    let assembled = host
        .assemble(&replaced)
        .map_err(|fault| blamed(fault, host, &replaced))?;
    Ok(Situation {
        host: Arc::new(assembled.linear.clone()),
        parameters: assembled.parameters.clone(),
        at: at.to_vec(),
        elements: assembled.elements.clone(),
        assembled: Some(Arc::new(assembled)),
        equations: OnceLock::new(),
    })
}

/// The names of a host that is written as equations, as a linear host without matrices has them.
fn names_of(equations: &EquationHost) -> LinearHost {
    let kind = |measure: Measure| match measure {
        Measure::Rotation => CoordinateKind::Rotation,
        Measure::Translation | Measure::Number => CoordinateKind::Translation,
    };
    let count = equations.coordinates.len();
    let inputs = equations.inputs.len();
    let square = || Mat::zeros(count, count);
    let wide = || Mat::zeros(count, inputs);
    LinearHost {
        name: equations.name.clone(),
        coordinates: equations
            .coordinates
            .iter()
            .map(|coordinate| Coordinate {
                name: coordinate.name.clone(),
                kind: kind(coordinate.kind),
            })
            .collect(),
        mass: square(),
        damping: square(),
        stiffness: square(),
        loss: None,
        inputs: equations
            .inputs
            .iter()
            .map(|input| Input {
                name: input.name.clone(),
                kind: match input.kind {
                    EquationInputKind::Mechanical(kind) => kind,
                    EquationInputKind::Number => InputKind::Force,
                },
                motion: CoordinateKind::Translation,
                dimension: input.dimension,
            })
            .collect(),
        forcing: [wide(), wide(), wide()],
        ports: equations
            .ports
            .iter()
            .map(|port| Port {
                name: port.name.clone(),
                coordinates: vec![0.0; count],
                inputs: vec![0.0; inputs],
                kind: kind(port.kind),
                hangs: port.hangs,
                grounded: port.grounded,
            })
            .collect(),
        outputs: Vec::new(),
    }
}

/// A host that is sound as it stands and not with these values: the message says which.
fn blamed(fault: Fault, host: &HostFile, replaced: &[Override]) -> Fault {
    let in_host = fault
        .source
        .as_ref()
        .is_some_and(|source| Arc::ptr_eq(source, host.source()));
    if replaced.is_empty() || !in_host || !sound(host) {
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

/// Whether a host can be built as it stands.
fn sound(host: &HostFile) -> bool {
    if host.is_equations() {
        host.equations(&[]).is_ok()
    } else {
        host.assemble(&[]).is_ok()
    }
}

/// Whether a parameter is a frequency, for which a plain number is refused.
fn name_is_frequency(host: &HostFile, name: &str) -> Result<bool, Fault> {
    let own = host.parameters(&[])?;
    Ok(own.iter().any(|(known, quantity)| {
        known == name && quantity.dimension == Dimension::ANGULAR_FREQUENCY
    }))
}

impl Situation {
    /// The host at further values of its parameters.
    ///
    /// # Errors
    /// As [`build`].
    pub(crate) fn moved(
        &self,
        study: &Study,
        further: &[(String, Quantity)],
    ) -> Result<Self, Fault> {
        let mut at = self.at.clone();
        at.retain(|(name, _)| further.iter().all(|(moved, _)| moved != name));
        at.extend(further.iter().cloned());
        build(&study.host, &study.overrides, &at)
    }

    /// Whether the host is written as equations.
    pub(crate) const fn is_equations(&self) -> bool {
        self.assembled.is_none()
    }

    /// Whether all numbers of the host are plain.
    pub(crate) fn is_dimensionless(&self) -> bool {
        self.is_equations()
            && self
                .equations
                .get()
                .is_some_and(|equations| equations.dimensionless)
    }

    /// The host as equations, for runs in time.
    ///
    /// # Errors
    /// A linear host that has none: loss factors are defined for harmonic motion only.
    pub(crate) fn equations(&self) -> Result<Arc<EquationHost>, Fault> {
        if let Some(known) = self.equations.get() {
            return Ok(Arc::clone(known));
        }
        let Some(assembled) = &self.assembled else {
            return Err(Fault::new("the host has no equations"));
        };
        let made = Arc::new(EquationHost::from_linear(assembled)?);
        Ok(Arc::clone(self.equations.get_or_init(|| made)))
    }

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
        Ok((form, dimension / self.input_dimension(input)))
    }

    /// SI dimension of an input as it is given; none where there is no such input.
    pub(crate) fn input_dimension(&self, input: usize) -> Dimension {
        self.host
            .inputs
            .get(input)
            .map_or(Dimension::NONE, |input| input.dimension)
    }
}
