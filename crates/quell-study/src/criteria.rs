//! Criteria: expressions over runs, compiled into functionals of the response and a tape over their values.
//!
//! | written | run | meaning |
//! | --- | --- | --- |
//! | `max(abs(y))` | frequency with a band | peak of \|Y(jω)/U(jω)\| over the band, between grid points too |
//! | `abs(y, f)` | frequency | \|Y/U\| at the frequency f |
//! | `h2(y)` | frequency | √((1/2π)∫\|Y/U\|² dω) over all ω, or over the band, both signs |
//! | `variance(y)`, `rms(y)` | frequency with a spectrum | ∫ S(f) \|Y/U\|² df over f > 0 (the band), and its root |
//! | `min(damping_ratio)`, `max(damping_ratio)` | modes | over the modes: ζ = -Re λ/\|λ\| |
//! | `min(decay_rate)`, `max(decay_rate)` | modes | -Re λ, 1/s |
//! | `min(frequency)`, `max(frequency)` | modes | \|λ\|, rad/s |
//!
//! | `max(s)`, `final(s)`, `integral(s, b)` … | transient | see [`crate::transient`] |
//!
//! y is linear in coordinates, inputs and outputs of the host (`xe - xs`, `xe''`, `force(port)`, `stroke(part)`); of
//! equations it is any expression, taken linear about the static equilibrium;
//! around these calls any arithmetic over host parameters may stand.

use crate::band::BandValue;
use crate::linear::Output;
use crate::transient::Observation;
use quell_expression::{
    Dimension, Expression, ExpressionError, Function, Node, Quantity, Scope, Span, nearest,
};

/// A number taken from a run.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Functional {
    /// Largest magnitude over the run's band.
    Peak(Output),
    /// Magnitude at one frequency, rad/s.
    Magnitude(Output, f64),
    /// A norm.
    Norm(Output, Norm),
    /// A statistic of the modes.
    Modes(Statistic, Modal),
    /// A number of a run in time.
    Time(Observation),
    /// A number of a stable band, by its index among those of the evaluator.
    Band(usize, BandValue),
}

/// Which norm of a frequency response.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Norm {
    /// √((1/2π)∫|H|² dω).
    H2,
    /// ∫ S |H|² df.
    Variance,
    /// Root of the variance.
    Rms,
}

/// Smallest or largest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Statistic {
    /// Smallest over the modes.
    Least,
    /// Largest over the modes.
    Largest,
}

/// What is read from each mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Modal {
    /// -Re λ/|λ|.
    DampingRatio,
    /// -Re λ, 1/s.
    DecayRate,
    /// |λ|, rad/s.
    Frequency,
}

impl Modal {
    /// The names in the study file.
    pub(crate) const NAMES: [&'static str; 3] = ["damping_ratio", "decay_rate", "frequency"];

    fn from_name(name: &str) -> Option<Self> {
        match name {
            "damping_ratio" => Some(Self::DampingRatio),
            "decay_rate" => Some(Self::DecayRate),
            "frequency" => Some(Self::Frequency),
            _ => None,
        }
    }

    fn dimension(self) -> Dimension {
        match self {
            Self::DampingRatio => Dimension::NONE,
            Self::DecayRate => Dimension::NONE / Dimension::TIME,
            Self::Frequency => Dimension::ANGULAR_FREQUENCY,
        }
    }
}

/// What the compiler of criteria asks of its surroundings.
pub(crate) trait RunContext {
    /// What a signal is, with the dimension of signal over input.
    ///
    /// # Errors
    /// The expression is not linear where the host is, or names something unknown.
    fn signal(&self, expression: &Expression) -> Result<(Output, Dimension), ExpressionError>;
    /// Host parameters.
    fn scope(&self) -> &dyn Scope;
    /// What kind of run it is.
    fn kind(&self) -> RunKind;
    /// Whether an expression is a signal, which varies over the run.
    fn varies(&self, expression: &Expression) -> bool {
        self.signal(expression).is_ok()
    }
    /// The observation of a run in time that a call stands for, if it stands for one.
    ///
    /// # Errors
    /// A signal that cannot be had, arguments that do not fit.
    fn observe(
        &self,
        _call: &Expression,
    ) -> Result<Option<(Observation, Dimension)>, ExpressionError> {
        Ok(None)
    }
}

/// What a criterion may ask of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum RunKind {
    /// A frequency response.
    Frequency {
        /// It has a band.
        band: bool,
        /// It has a spectrum, of this dimension per Hz.
        spectrum: Option<Dimension>,
    },
    /// Modes.
    Modes,
    /// Motion in time.
    Transient,
    /// A solution of a branch.
    Branch,
}

/// A criterion split into functionals and the arithmetic around them.
#[derive(Debug, Clone)]
pub(crate) struct Compiled {
    /// The functionals with their dimensions.
    pub functionals: Vec<(Functional, Dimension)>,
    /// The arithmetic, with the functionals as the names `functional.0`, `functional.1` …
    pub arithmetic: Expression,
    /// The dimension of the whole.
    pub dimension: Dimension,
}

/// The name under which a functional stands in [`Compiled::arithmetic`].
pub(crate) fn functional_name(index: usize) -> String {
    format!("functional.{index}")
}

/// Splits a criterion.
///
/// # Errors
/// A call that the run does not offer, a signal that is not linear, units that do not fit, an unknown name.
pub(crate) fn compile(
    value: &Expression,
    context: &dyn RunContext,
) -> Result<Compiled, ExpressionError> {
    let mut functionals = Vec::new();
    let arithmetic = split(value, context, &mut functionals)?;
    if functionals.is_empty() {
        return Err(ExpressionError {
            span: value.span,
            message: match context.kind() {
                RunKind::Branch => "this measure takes nothing from the solutions",
                _ => "this criterion takes nothing from its run",
            }
            .to_owned(),
            help: Some(offers(context.kind())),
        });
    }
    let scope = WithFunctionals {
        functionals: &functionals,
        outer: context.scope(),
    };
    let dimension = arithmetic.evaluate(&scope)?.dimension;
    Ok(Compiled {
        functionals,
        arithmetic,
        dimension,
    })
}

/// Host parameters and functionals, the latter as one in their dimension.
struct WithFunctionals<'a> {
    functionals: &'a [(Functional, Dimension)],
    outer: &'a dyn Scope,
}

impl Scope for WithFunctionals<'_> {
    fn quantity(&self, name: &str) -> Option<Quantity> {
        name.strip_prefix("functional.")
            .and_then(|index| index.parse::<usize>().ok())
            .and_then(|index| self.functionals.get(index))
            .map(|(_, dimension)| Quantity {
                value: 1.0,
                dimension: *dimension,
            })
            .or_else(|| self.outer.quantity(name))
    }

    fn names(&self) -> Vec<&str> {
        self.outer.names()
    }
}

fn offers(kind: RunKind) -> String {
    match kind {
        RunKind::Frequency { band, spectrum } => {
            let mut calls = vec!["`h2(y)`", "`abs(y, 12 Hz)`"];
            if band {
                calls.insert(0, "`max(abs(y))`");
            }
            if spectrum.is_some() {
                calls.extend(["`rms(y)`", "`variance(y)`"]);
            }
            format!("a frequency run offers {}", calls.join(", "))
        }
        RunKind::Modes => "a modes run offers `min(damping_ratio)`, `min(decay_rate)`, `min(frequency)` and their `max`".to_owned(),
        RunKind::Branch => "a branch offers `max(s)`, `min(s)`, `mean(s)`, `rms(s)` and `amplitude(s)` of a signal s, over a cycle or at an equilibrium".to_owned(),
        RunKind::Transient => "a transient run offers `max(s)`, `min(s)`, `peak(s, n)`, `trough(s, n)`, `largest(s, n)`, `span(s, level)`, `crossing(s, n)`, `initial(s)`, `final(s)`, `at(s, 2 s)`, `mean(s)`, `rms(s)`, `integral(s)`, `integral(s, b)`, `settling(s, band)`, `decay_rate(s)`, `potential(NAME)`, `kinetic(NAME)`, `stored(NAME)`, `dissipated(NAME)`, `energy_error`".to_owned(),
    }
}

fn split(
    expression: &Expression,
    context: &dyn RunContext,
    functionals: &mut Vec<(Functional, Dimension)>,
) -> Result<Expression, ExpressionError> {
    let found = match context.kind() {
        RunKind::Transient | RunKind::Branch => context
            .observe(expression)?
            .map(|(observation, dimension)| (Functional::Time(observation), dimension)),
        _ => functional(expression, context)?,
    };
    if let Some(found) = found {
        let index = functionals
            .iter()
            .position(|known| *known == found)
            .unwrap_or_else(|| {
                functionals.push(found);
                functionals.len() - 1
            });
        return Ok(Expression {
            node: Node::Name(functional_name(index)),
            span: expression.span,
        });
    }
    let varies = || ExpressionError {
        span: expression.span,
        message: format!(
            "`{}` is not one number: it varies over the {}",
            expression.excerpt(),
            if context.kind() == RunKind::Branch {
                "cycle"
            } else {
                "run"
            }
        ),
        help: Some(offers(context.kind())),
    };
    let node = match &expression.node {
        Node::Comparison { .. } => {
            return Err(ExpressionError {
                span: expression.span,
                message: "a criterion is a number, not a comparison".to_owned(),
                help: Some(
                    "a task compares it: `subject_to = [\"CRITERION <= VALUE\"]`".to_owned(),
                ),
            });
        }
        Node::Logic { .. } | Node::Not(_) | Node::Choice { .. } => {
            return Err(ExpressionError {
                span: expression.span,
                message: "a criterion is a number, without conditions".to_owned(),
                help: Some("`min` and `max` choose between numbers".to_owned()),
            });
        }
        Node::Derivative { .. } if context.varies(expression) => return Err(varies()),
        Node::Call { function, .. }
            if matches!(function.as_str(), "force" | "stroke") && context.varies(expression) =>
        {
            return Err(varies());
        }
        Node::Call {
            function,
            function_span,
            ..
        } if Function::from_name(function).is_none() => {
            let known = Function::ALL.iter().map(|(name, _)| *name);
            let near = nearest(function, known.chain(["h2", "rms", "variance"]));
            return Err(ExpressionError {
                span: *function_span,
                message: format!("unknown function `{function}`"),
                help: Some(match near {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => offers(context.kind()),
                }),
            });
        }
        Node::Negate(operand) => Node::Negate(Box::new(split(operand, context, functionals)?)),
        Node::Binary { .. } => return split_chain(expression, context, functionals),
        Node::Call {
            function,
            function_span,
            arguments,
        } => Node::Call {
            function: function.clone(),
            function_span: *function_span,
            arguments: arguments
                .iter()
                .map(|argument| split(argument, context, functionals))
                .collect::<Result<_, _>>()?,
        },
        Node::Name(name) if context.scope().quantity(name).is_none() && name != "pi" => {
            // A bare signal is the commonest slip: a criterion is one number, a signal is many.
            if Modal::from_name(name).is_some() && context.kind() != RunKind::Modes {
                return Err(only_modes(name, expression.span));
            }
            if context.varies(expression) || Modal::from_name(name).is_some() {
                return Err(varies());
            }
            expression.node.clone()
        }
        other => other.clone(),
    };
    Ok(Expression {
        node,
        span: expression.span,
    })
}

/// What modes have, asked of another run.
fn only_modes(name: &str, span: Span) -> ExpressionError {
    ExpressionError {
        span,
        message: format!("`{name}` is read from modes, and this run is none of them"),
        help: Some("add a run of `kind = \"modes\"` and name it here".to_owned()),
    }
}

/// A chain such as a - b + c, in a loop: it may be thousands long.
fn split_chain(
    expression: &Expression,
    context: &dyn RunContext,
    functionals: &mut Vec<(Functional, Dimension)>,
) -> Result<Expression, ExpressionError> {
    let mut operations = Vec::new();
    let mut first = expression;
    while let Node::Binary {
        operator,
        left,
        right,
    } = &first.node
    {
        operations.push((first.span, *operator, right));
        first = left;
    }
    let mut whole = split(first, context, functionals)?;
    for (span, operator, right) in operations.into_iter().rev() {
        whole = Expression {
            node: Node::Binary {
                operator,
                left: Box::new(whole),
                right: Box::new(split(right, context, functionals)?),
            },
            span,
        };
    }
    Ok(whole)
}

/// The functional that a call stands for, if it stands for one.
fn functional(
    expression: &Expression,
    context: &dyn RunContext,
) -> Result<Option<(Functional, Dimension)>, ExpressionError> {
    let Node::Call {
        function,
        function_span,
        arguments,
    } = &expression.node
    else {
        return Ok(None);
    };
    let refused = |message: String| {
        Err(ExpressionError {
            span: *function_span,
            message,
            help: Some(offers(context.kind())),
        })
    };
    match (function.as_str(), arguments.as_slice(), context.kind()) {
        ("max", [inner], RunKind::Frequency { band, .. }) => {
            let Some(signal) = magnitude_of(inner) else {
                return refused(format!(
                    "`max({})` is not the peak of a magnitude",
                    inner.excerpt()
                ));
            };
            if !band {
                return Err(ExpressionError {
                    span: *function_span,
                    message: "a peak is taken over a band, and the run has none".to_owned(),
                    help: Some("add `band = [\"0 Hz\", \"30 Hz\"]` to the run".to_owned()),
                });
            }
            let (form, dimension) = context.signal(signal)?;
            Ok(Some((Functional::Peak(form), dimension)))
        }
        ("abs", [signal, at], RunKind::Frequency { .. }) => {
            let (form, dimension) = context.signal(signal)?;
            let frequency = at.evaluate(context.scope())?;
            if !Dimension::ANGULAR_FREQUENCY.accepts(&frequency.dimension) || frequency.value <= 0.0
            {
                return Err(ExpressionError {
                    span: at.span,
                    message: format!("`{}` is not a frequency above zero", at.excerpt()),
                    help: Some("write it with its unit: `12 Hz`".to_owned()),
                });
            }
            Ok(Some((
                Functional::Magnitude(form, frequency.value),
                dimension,
            )))
        }
        ("h2", [signal], RunKind::Frequency { .. }) => {
            let (form, dimension) = context.signal(signal)?;
            let root_of_rate = (Dimension::NONE / Dimension::TIME).sqrt();
            Ok(Some((
                Functional::Norm(form, Norm::H2),
                dimension * root_of_rate,
            )))
        }
        ("variance" | "rms", [signal], RunKind::Frequency { spectrum, .. }) => {
            let Some(spectrum) = spectrum else {
                return Err(ExpressionError {
                    span: *function_span,
                    message: format!(
                        "`{function}` needs a spectrum of the input, and the run has none"
                    ),
                    help: Some(
                        "add `spectrum = \"1e-4 m^2/Hz\"` to the run, in the input's own unit squared per Hz; `h2(y)` needs none"
                            .to_owned(),
                    ),
                });
            };
            let (form, dimension) = context.signal(signal)?;
            let variance = dimension * dimension * spectrum / Dimension::TIME;
            Ok(Some(if function == "rms" {
                (Functional::Norm(form, Norm::Rms), variance.sqrt())
            } else {
                (Functional::Norm(form, Norm::Variance), variance)
            }))
        }
        ("min" | "max", [inner], RunKind::Modes) => {
            let modal = match &inner.node {
                Node::Name(name) => Modal::from_name(name),
                _ => None,
            };
            let Some(modal) = modal else {
                return refused(format!("`{}` is nothing that modes have", inner.excerpt()));
            };
            let statistic = if function == "min" {
                Statistic::Least
            } else {
                Statistic::Largest
            };
            Ok(Some((
                Functional::Modes(statistic, modal),
                modal.dimension(),
            )))
        }
        ("h2" | "variance" | "rms", _, _) => refused(format!(
            "`{}` is not what this run offers",
            expression.excerpt()
        )),
        _ => Ok(None),
    }
}

/// y of `abs(y)`.
fn magnitude_of(expression: &Expression) -> Option<&Expression> {
    match &expression.node {
        Node::Call {
            function,
            arguments,
            ..
        } if function == "abs" => match arguments.as_slice() {
            [signal] => Some(signal),
            _ => None,
        },
        _ => None,
    }
}
