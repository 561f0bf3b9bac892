//! Components: named sub-networks whose element values are expressions of design variables.

use quell_expression::{
    Dimension, Expression, ExpressionError, Node, Quantity, Scope, Tape, TapeBuilder, nearest,
};

use crate::kind::Kind;
use crate::{Domain, Layout, Network, NetworkError};

/// A design variable of a component.
#[derive(Debug, Clone, PartialEq)]
pub struct ComponentVariable {
    /// The name in the component's expressions.
    pub name: String,
    /// What it measures.
    pub dimension: Dimension,
    /// A possible value (SI), at which the expressions' dimensions are checked.
    pub sample: f64,
}

/// A named sub-network of elements in its domain.
#[derive(Debug, Clone, PartialEq)]
pub struct Component {
    /// The name of the kind, as declared in [`crate::Kinds`].
    pub name: String,
    /// Its elements.
    pub layout: Layout,
    /// Its design variables.
    pub variables: Vec<ComponentVariable>,
    /// The value of each element, by the element's name, in the layout's domain: an expression of the variables and of
    /// constants. A plain number is SI.
    pub values: Vec<(String, Expression)>,
}

/// Why a layout with components cannot be expanded.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ComponentError {
    /// The layout is no network.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// An element without a value.
    #[error("the component `{component}` gives no value for its element `{element}`")]
    MissingValue {
        /// The component.
        component: String,
        /// The element.
        element: String,
    },
    /// A value for what is no element.
    #[error("the component `{component}` gives a value for `{element}`, which is not in its layout{}", near.as_ref().map(|near| format!("; did you mean `{near}`?")).unwrap_or_default())]
    UnknownElement {
        /// The component.
        component: String,
        /// The name.
        element: String,
        /// The nearest element of its layout.
        near: Option<String>,
    },
    /// A value's expression cannot be evaluated.
    #[error("the value of `{element}` in the component `{component}`: {error}")]
    Expression {
        /// The component.
        component: String,
        /// The element.
        element: String,
        /// What is wrong, and where in the expression's text.
        #[source]
        error: ExpressionError,
    },
    /// A value measures something else.
    #[error("the value of `{element}` in the component `{component}` should be in {expected}, but it is in {}", if given.is_empty() { "no unit" } else { given })]
    Dimension {
        /// The component.
        component: String,
        /// The element.
        element: String,
        /// Unit expected.
        expected: String,
        /// Unit of the expression.
        given: String,
    },
}

/// A variable that a network's values follow from.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Its name: `k1` of a plain element, `pipe1.dL` of a component's instance.
    pub name: String,
    /// The branch that it belongs to: `k1`, `pipe1`.
    pub branch: String,
    /// The component's kind and the name of the variable there; none for a plain element.
    pub component: Option<(String, String)>,
    /// What it measures; for a plain element the dimension of its value in the layout's domain.
    pub dimension: Dimension,
}

/// One branch of the layout: where its variables and elements are.
#[derive(Debug, Clone)]
struct Instance {
    /// Index of the component's tape, none for a plain element.
    tape: Option<usize>,
    variable: usize,
    element: usize,
}

/// A component's expressions in the order of its elements.
#[derive(Debug, Clone)]
struct Values {
    tape: Tape,
    elements: usize,
    variables: usize,
}

/// Memory that [`Expansion`] reuses.
#[derive(Debug, Clone, Default)]
pub struct ExpansionWorkspace {
    work: Vec<f64>,
}

/// A network with the variables that its values follow from.
#[derive(Debug, Clone)]
pub struct Expansion {
    network: Network,
    variables: Vec<Variable>,
    values: Vec<Values>,
    instances: Vec<Instance>,
    entries: Vec<(usize, usize)>,
}

/// Replaces the component branches of a layout by their sub-networks.
///
/// The branch `pipe1` becomes elements `pipe1.R`, `pipe1.I` …; the part `pipe1` keeps its terminals. Every plain
/// element is a variable of its own, and every instance of a component has its component's variables, in the order of the
/// branches in the layout. `piston_area` Ap (m²) is needed by hydraulic layouts; `constants` are the names that component
/// values may use besides their variables (a variable hides a constant of its name).
///
/// # Errors
/// See [`ComponentError`] and [`NetworkError`]; every value is checked for its dimension.
pub fn expand(
    layout: &Layout,
    components: &[Component],
    piston_area: Option<f64>,
    constants: &dyn Scope,
) -> Result<Expansion, ComponentError> {
    let find = |name: &str| {
        components
            .iter()
            .position(|component| component.name == name)
    };
    let network = Network::with_components(layout, piston_area, |name| {
        find(name)
            .and_then(|index| components.get(index))
            .map(|component| &component.layout)
    })?;
    let mut expansion = Expansion {
        network,
        variables: Vec::new(),
        values: Vec::new(),
        instances: Vec::new(),
        entries: Vec::new(),
    };
    // The tape of each component that occurs.
    let mut tapes: Vec<Option<usize>> = vec![None; components.len()];
    let mut element = 0;
    for branch in layout.branches() {
        let variable = expansion.variables.len();
        let found = match &branch.kind {
            Kind::Component(name) => {
                find(name).and_then(|index| Some((index, components.get(index)?)))
            }
            Kind::Element(_) | Kind::Custom(_) | Kind::Placeholder => None,
        };
        let Some((index, component)) = found else {
            let dimension = match branch.kind {
                Kind::Element(kind) => layout.domain().dimension(kind),
                Kind::Custom(_) | Kind::Component(_) | Kind::Placeholder => Dimension::NONE,
            };
            let (name, branch) = (branch.name.clone(), branch.name.clone());
            expansion.variables.push(Variable {
                name,
                branch,
                component: None,
                dimension,
            });
            expansion.instances.push(Instance {
                tape: None,
                variable,
                element,
            });
            expansion.entries.push((element, variable));
            element += 1;
            continue;
        };
        let tape = if let Some(tape) = tapes.get(index).copied().flatten() {
            tape
        } else {
            expansion
                .values
                .push(compile(component, layout.domain(), constants)?);
            let tape = expansion.values.len() - 1;
            if let Some(entry) = tapes.get_mut(index) {
                *entry = Some(tape);
            }
            tape
        };
        for variable in &component.variables {
            expansion.variables.push(Variable {
                name: format!("{}.{}", branch.name, variable.name),
                branch: branch.name.clone(),
                component: Some((component.name.clone(), variable.name.clone())),
                dimension: variable.dimension,
            });
        }
        expansion.instances.push(Instance {
            tape: Some(tape),
            variable,
            element,
        });
        let elements = component.layout.branches().count();
        for row in 0..elements {
            for column in 0..component.variables.len() {
                expansion.entries.push((element + row, variable + column));
            }
        }
        element += elements;
    }
    Ok(expansion)
}

/// The component's values as a tape, each checked for its dimension.
fn compile(
    component: &Component,
    domain: Domain,
    constants: &dyn Scope,
) -> Result<Values, ComponentError> {
    let elements: Vec<&str> = component
        .layout
        .branches()
        .map(|branch| branch.name.as_str())
        .collect();
    if let Some((name, _)) = component
        .values
        .iter()
        .find(|(name, _)| !elements.contains(&name.as_str()))
    {
        return Err(ComponentError::UnknownElement {
            component: component.name.clone(),
            element: name.clone(),
            near: nearest(name, elements).map(str::to_owned),
        });
    }
    let inputs: Vec<String> = component
        .variables
        .iter()
        .map(|variable| variable.name.clone())
        .collect();
    let sample = Sample {
        variables: &component.variables,
        constants,
    };
    let mut builder = TapeBuilder::new(&inputs);
    for branch in component.layout.branches() {
        let Some((_, expression)) = component
            .values
            .iter()
            .find(|(name, _)| *name == branch.name)
        else {
            return Err(ComponentError::MissingValue {
                component: component.name.clone(),
                element: branch.name.clone(),
            });
        };
        let fault = |error| ComponentError::Expression {
            component: component.name.clone(),
            element: branch.name.clone(),
            error,
        };
        if let (Kind::Element(kind), false) =
            (&branch.kind, matches!(expression.node, Node::Number(_)))
        {
            let quantity = expression.evaluate(&sample).map_err(fault)?;
            if !domain.dimension(*kind).accepts(&quantity.dimension) {
                return Err(ComponentError::Dimension {
                    component: component.name.clone(),
                    element: branch.name.clone(),
                    expected: domain.unit(*kind).to_owned(),
                    given: quantity.dimension.unit_text(),
                });
            }
        }
        builder.add(expression, constants).map_err(fault)?;
    }
    Ok(Values {
        tape: builder.build(),
        elements: elements.len(),
        variables: inputs.len(),
    })
}

/// Constants and sample values of variables.
struct Sample<'a> {
    variables: &'a [ComponentVariable],
    constants: &'a dyn Scope,
}

impl Scope for Sample<'_> {
    fn quantity(&self, name: &str) -> Option<Quantity> {
        let variable = self.variables.iter().find(|variable| variable.name == name);
        variable.map_or_else(
            || self.constants.quantity(name),
            |variable| Some(Quantity::new(variable.sample, variable.dimension)),
        )
    }

    fn names(&self) -> Vec<&str> {
        let own = self.variables.iter().map(|variable| variable.name.as_str());
        own.chain(self.constants.names()).collect()
    }
}

impl Expansion {
    /// The mechanical network.
    #[must_use]
    pub const fn network(&self) -> &Network {
        &self.network
    }

    /// The variables that its values follow from, in the order of variables.
    #[must_use]
    pub fn variables(&self) -> &[Variable] {
        &self.variables
    }

    /// Which derivatives [`Expansion::derivatives`] gives: (index of the element, index of the variable).
    ///
    /// With dJ/dvalue the chain rule reads `dJ/dvariable[v] += dJ/dvalue[e] * derivative` for each entry (e, v).
    #[must_use]
    pub fn entries(&self) -> &[(usize, usize)] {
        &self.entries
    }

    /// Mechanical values (SI) of all elements for values of the variables (SI, in the layout's domain).
    ///
    /// `variables` are as many as [`Expansion::variables`], `values` as the network's elements; what is missing reads
    /// as not-a-number. Nothing is allocated once the workspace has been used.
    pub fn values(
        &self,
        variables: &[f64],
        workspace: &mut ExpansionWorkspace,
        values: &mut [f64],
    ) {
        self.own_values(variables, workspace, values);
        for (value, element) in values.iter_mut().zip(self.network.elements()) {
            *value = element.own_to_mechanical(*value);
        }
    }

    /// Values of all elements in the layout's domain (SI), as [`Expansion::values`] before the change of domain.
    pub fn own_values(
        &self,
        variables: &[f64],
        workspace: &mut ExpansionWorkspace,
        values: &mut [f64],
    ) {
        for instance in &self.instances {
            let rest = variables.get(instance.variable..).unwrap_or_default();
            let target = values.get_mut(instance.element..).unwrap_or_default();
            let Some(component) = instance.tape.and_then(|tape| self.values.get(tape)) else {
                if let Some(target) = target.first_mut() {
                    *target = rest.first().copied().unwrap_or(f64::NAN);
                }
                continue;
            };
            let length = component.elements.min(target.len());
            let Some(target) = target.get_mut(..length) else {
                continue;
            };
            match rest.get(..component.variables) {
                Some(inputs) => component.tape.evaluate(inputs, &mut workspace.work, target),
                None => target.fill(f64::NAN),
            }
        }
    }

    /// Mechanical values of all elements and their exact derivatives with respect to the variables.
    ///
    /// `derivatives` has one place for each of [`Expansion::entries`]; the rest as in [`Expansion::values`].
    pub fn derivatives(
        &self,
        variables: &[f64],
        workspace: &mut ExpansionWorkspace,
        values: &mut [f64],
        derivatives: &mut [f64],
    ) {
        let mut rest = derivatives;
        for instance in &self.instances {
            let inputs = variables.get(instance.variable..).unwrap_or_default();
            let target = values.get_mut(instance.element..).unwrap_or_default();
            let (elements, width) = instance
                .tape
                .and_then(|tape| self.values.get(tape))
                .map_or((1, 1), |component| {
                    (component.elements, component.variables)
                });
            let (Some(inputs), Some(target)) = (inputs.get(..width), target.get_mut(..elements))
            else {
                return;
            };
            let Some((block, following)) = rest.split_at_mut_checked(elements * width) else {
                return;
            };
            if let Some(component) = instance.tape.and_then(|tape| self.values.get(tape)) {
                component
                    .tape
                    .jacobian(inputs, &mut workspace.work, target, block);
            } else {
                target.copy_from_slice(inputs);
                block.fill(1.0);
            }
            let elements = self
                .network
                .elements()
                .get(instance.element..)
                .unwrap_or_default();
            for (row, (value, element)) in target.iter_mut().zip(elements).enumerate() {
                let factor = element.derivative(*value);
                *value = element.own_to_mechanical(*value);
                for derivative in block.iter_mut().skip(row * width).take(width) {
                    *derivative *= factor;
                }
            }
            rest = following;
        }
    }
}
