//! Numbers taken from the solutions of a branch: `max(abs(p))`, `mean(x)`, `amplitude(x)`.
//!
//! On a cycle `max`, `min`, `mean` and `rms` are over one period of the piecewise polynomials, not of their nodes;
//! `amplitude(s)` is (max(s) - min(s))/2. At an equilibrium s does not move, so its maximum, minimum and mean are its value.

use quell_continuation::{Equilibrium, Orbit};
use quell_document::Fault;
use quell_expression::{
    BinaryOperator, Dimension, Expression, ExpressionError, Node, Quantity, Scope,
};
use quell_response::transient::Record;

use super::ask::Measure;
use super::field::Field;
use crate::criteria::{Functional, RunContext, RunKind, compile, functional_name};
use crate::linear::Output;
use crate::situation::Situation;
use crate::study::Study;
use crate::transient::{Observation, Watching, observe};

/// A measure compiled.
#[derive(Debug, Clone)]
pub(super) struct Compiled {
    pub(super) name: String,
    /// Unit in which people read it, and its size in SI.
    pub(super) unit: String,
    pub(super) factor: f64,
    pub(super) dimension: Dimension,
    arithmetic: Expression,
    readings: Vec<(Reading, Dimension)>,
    /// It names parameters of the host outside calls.
    pub(super) names: bool,
}

/// A statistic of a signal, by index.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Reading {
    Maximum(usize),
    Minimum(usize),
    Mean(usize),
    Rms(usize),
}

struct Context<'a, 'w> {
    study: &'a Study,
    situation: &'a Situation,
    watching: &'a Watching<'w>,
}

impl RunContext for Context<'_, '_> {
    fn signal(&self, expression: &Expression) -> Result<(Output, Dimension), ExpressionError> {
        Err(ExpressionError::new(
            expression.span,
            "a measure takes `max`, `min`, `mean`, `rms` or `amplitude` of a signal",
        ))
    }

    fn scope(&self) -> &dyn Scope {
        &self.situation.parameters
    }

    fn kind(&self) -> RunKind {
        RunKind::Branch
    }

    fn varies(&self, expression: &Expression) -> bool {
        self.watching.knows(expression)
    }

    fn observe(
        &self,
        call: &Expression,
    ) -> Result<Option<(Observation, Dimension)>, ExpressionError> {
        let found = observe(self.study, self.watching, self.scope(), call)?;
        if let Some((observation, _)) = &found
            && reading(observation).is_none()
        {
            return Err(ExpressionError::new(
                call.span,
                format!("`{}` is a number of a run in time, not of a cycle", call.excerpt()),
            )
            .with_help("a branch offers `max(s)`, `min(s)`, `mean(s)`, `rms(s)` and `amplitude(s)` of a signal s"));
        }
        Ok(found)
    }
}

fn reading(observation: &Observation) -> Option<Reading> {
    match observation {
        Observation::Maximum(signal, _) => Some(Reading::Maximum(*signal)),
        Observation::Minimum(signal, _) => Some(Reading::Minimum(*signal)),
        Observation::Mean(signal) => Some(Reading::Mean(*signal)),
        Observation::Rms(signal) => Some(Reading::Rms(*signal)),
        _ => None,
    }
}

/// `amplitude(s)` written out.
fn written_out(expression: &Expression) -> Expression {
    let span = expression.span;
    let again = |one: &Expression| Box::new(written_out(one));
    let node = match &expression.node {
        Node::Call {
            function,
            function_span,
            arguments,
        } => {
            let call = |name: &str| {
                Box::new(Expression {
                    node: Node::Call {
                        function: name.to_owned(),
                        function_span: *function_span,
                        arguments: arguments.clone(),
                    },
                    span,
                })
            };
            if function == "amplitude" && arguments.len() == 1 {
                let swing = Expression {
                    node: Node::Binary {
                        operator: BinaryOperator::Subtract,
                        left: call("max"),
                        right: call("min"),
                    },
                    span,
                };
                let two = Expression {
                    node: Node::Number(2.0),
                    span,
                };
                Node::Binary {
                    operator: BinaryOperator::Divide,
                    left: Box::new(swing),
                    right: Box::new(two),
                }
            } else {
                Node::Call {
                    function: function.clone(),
                    function_span: *function_span,
                    arguments: arguments.iter().map(written_out).collect(),
                }
            }
        }
        Node::Negate(one) => Node::Negate(again(one)),
        Node::Binary {
            operator,
            left,
            right,
        } => Node::Binary {
            operator: *operator,
            left: again(left),
            right: again(right),
        },
        other => other.clone(),
    };
    Expression { node, span }
}

/// Compiles a measure; its signals are watched from then on.
///
/// # Errors
/// Whatever is wrong with it, at its place.
pub(super) fn compiled(
    study: &Study,
    situation: &Situation,
    watching: &Watching<'_>,
    name: &str,
    measure: &Measure,
) -> Result<Compiled, Fault> {
    let located = |error: ExpressionError| Fault::from_expression(&study.source, error);
    let context = Context {
        study,
        situation,
        watching,
    };
    let found = compile(&written_out(&measure.value), &context).map_err(located)?;
    let (unit, factor) = match &measure.unit {
        None => (found.dimension.unit_text(), 1.0),
        Some((unit, span)) => {
            if !unit.dimension.accepts(&found.dimension)
                && !found.dimension.accepts(&unit.dimension)
            {
                return Err(Fault::at(
                    &study.source,
                    *span,
                    format!(
                        "`{name}` is {}, which cannot be shown in `{}`",
                        crate::amount::described(found.dimension),
                        unit.text
                    ),
                )
                .help("write a unit of the same dimension, or leave `unit` out"));
            }
            (unit.text.clone(), unit.factor)
        }
    };
    let readings = found
        .functionals
        .iter()
        .filter_map(|(functional, dimension)| match functional {
            Functional::Time(observation) => Some((reading(observation)?, *dimension)),
            _ => None,
        })
        .collect();
    let names = found
        .arithmetic
        .names()
        .iter()
        .any(|used| !used.starts_with("functional.") && *used != "pi");
    Ok(Compiled {
        name: name.to_owned(),
        unit,
        factor,
        dimension: found.dimension,
        arithmetic: found.arithmetic,
        readings,
        names,
    })
}

/// Whether two measures by which oscillations are named can be compared.
///
/// # Errors
/// Where their dimensions differ.
pub(super) fn comparable(
    study: &Study,
    first: &Compiled,
    other: &Compiled,
    typed: &Measure,
) -> Result<(), Fault> {
    let (a, b) = (first.dimension, other.dimension);
    if a.accepts(&b) || b.accepts(&a) {
        return Ok(());
    }
    Err(Fault::at(
        &study.source,
        typed.value.span,
        format!(
            "`{}` is {} and `{}` is {}, so it cannot be said which is larger",
            first.name,
            crate::amount::described(a),
            other.name,
            crate::amount::described(b)
        ),
    )
    .help("bring them to one dimension: with a lever arm, `\"0.75 m*max(abs(d))\"`, or by what is much, `\"max(abs(x))/(1 mm)\"`"))
}

/// Parameters of the host at a point, and the statistics in a measure.
struct At<'a> {
    readings: &'a [(String, Quantity)],
    parameters: &'a [(String, Quantity)],
}

impl Scope for At<'_> {
    fn quantity(&self, name: &str) -> Option<Quantity> {
        self.readings
            .iter()
            .find(|(known, _)| known == name)
            .map(|(_, quantity)| *quantity)
            .or_else(|| self.parameters.quantity(name))
    }

    fn names(&self) -> Vec<&str> {
        self.parameters.names()
    }
}

impl Compiled {
    fn combined(
        &self,
        parameters: &[(String, Quantity)],
        mut of: impl FnMut(Reading) -> f64,
    ) -> f64 {
        let readings: Vec<(String, Quantity)> = self
            .readings
            .iter()
            .enumerate()
            .map(|(index, (reading, dimension))| {
                (
                    functional_name(index),
                    Quantity::new(of(*reading), *dimension),
                )
            })
            .collect();
        let scope = At {
            readings: &readings,
            parameters,
        };
        self.arithmetic
            .evaluate(&scope)
            .map_or(f64::NAN, |quantity| quantity.value)
    }
}

/// Values of measures at an equilibrium, SI.
pub(super) fn at_equilibrium(
    measures: &[Compiled],
    field: &Field<'_>,
    signals: usize,
    parameters: &[(String, Quantity)],
    at: &Equilibrium,
) -> Vec<f64> {
    let mut values = vec![f64::NAN; signals];
    field.signals(0.0, &at.state, &at.parameters, &mut values);
    let value = |signal: usize| values.get(signal).copied().unwrap_or(f64::NAN);
    measures
        .iter()
        .map(|measure| {
            measure.combined(parameters, |reading| match reading {
                Reading::Maximum(signal) | Reading::Minimum(signal) | Reading::Mean(signal) => {
                    value(signal)
                }
                Reading::Rms(signal) => value(signal).abs(),
            })
        })
        .collect()
}

/// Values of measures of a cycle, SI.
pub(super) fn on_cycle(
    measures: &[Compiled],
    field: &Field<'_>,
    signals: usize,
    parameters: &[(String, Quantity)],
    orbit: &Orbit,
) -> Vec<f64> {
    let mut scan = Scan::new(field, signals, orbit);
    measures
        .iter()
        .map(|measure| {
            measure.combined(parameters, |reading| match reading {
                Reading::Maximum(signal) => scan.largest(signal, 1.0),
                Reading::Minimum(signal) => -scan.largest(signal, -1.0),
                Reading::Mean(signal) => scan.mean(signal, |value| value),
                Reading::Rms(signal) => scan.mean(signal, |value| value * value).sqrt(),
            })
        })
        .collect()
}

/// Values of measures over the window of a record of a run in time, SI.
pub(super) fn in_time(
    measures: &[Compiled],
    record: &mut Record<'_>,
    parameters: &[(String, Quantity)],
) -> Vec<f64> {
    measures
        .iter()
        .map(|measure| {
            measure.combined(parameters, |reading| match reading {
                Reading::Maximum(signal) => record.maximum(signal).value,
                Reading::Minimum(signal) => record.minimum(signal).value,
                Reading::Mean(signal) => record.mean(signal),
                Reading::Rms(signal) => record.rms(signal),
            })
        })
        .collect()
}

/// Signals along a cycle.
struct Scan<'a, 's> {
    field: &'a Field<'s>,
    orbit: &'a Orbit,
    times: Vec<f64>,
    /// By node, then signal.
    nodes: Vec<Vec<f64>>,
    signals: usize,
}

/// Nodes and weights of Gauss quadrature of four points on [0, 1].
const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_92),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_1),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_1),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_92),
];

/// A maximum is narrowed until its place is known to the root of the rounding unit.
const NARROWINGS: usize = 36;

impl<'a, 's> Scan<'a, 's> {
    fn new(field: &'a Field<'s>, signals: usize, orbit: &'a Orbit) -> Self {
        let times = orbit.times();
        let mut scan = Self {
            field,
            orbit,
            nodes: Vec::with_capacity(times.len()),
            times,
            signals,
        };
        for (tau, state) in scan
            .times
            .clone()
            .iter()
            .zip(orbit.states.chunks(orbit.dimension.max(1)))
        {
            let values = scan.at(*tau, state);
            scan.nodes.push(values);
        }
        scan
    }

    fn at(&self, tau: f64, state: &[f64]) -> Vec<f64> {
        let mut values = vec![f64::NAN; self.signals];
        let t = tau * self.orbit.period;
        self.field
            .signals(t, state, &self.orbit.parameters, &mut values);
        values
    }

    fn value(&self, tau: f64, signal: usize) -> f64 {
        let wrapped = tau - tau.floor();
        let values = self.at(tau, &self.orbit.state(wrapped));
        values.get(signal).copied().unwrap_or(f64::NAN)
    }

    /// Largest of sign · s: the best node, narrowed by golden section between its neighbours.
    fn largest(&mut self, signal: usize, sign: f64) -> f64 {
        let node = |index: usize| {
            let values = self.nodes.get(index);
            sign * values
                .and_then(|values| values.get(signal))
                .copied()
                .unwrap_or(f64::NAN)
        };
        let count = self.times.len();
        let mut best = 0;
        for index in 1..count {
            if node(index) > node(best) {
                best = index;
            }
        }
        let time = |index: usize| self.times.get(index).copied().unwrap_or(f64::NAN);
        // The last node is the first one, a period later.
        let mut from = if best == 0 {
            time(count.saturating_sub(2)) - 1.0
        } else {
            time(best - 1)
        };
        let mut to = if best + 1 == count {
            1.0 + time(1)
        } else {
            time(best + 1)
        };
        let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
        let mut most = node(best);
        let (mut low, mut high) = (to - golden * (to - from), from + golden * (to - from));
        let mut at_low = sign * self.value(low, signal);
        let mut at_high = sign * self.value(high, signal);
        for _ in 0..NARROWINGS {
            most = most.max(at_low).max(at_high);
            if at_low > at_high {
                to = high;
                (high, at_high) = (low, at_low);
                low = to - golden * (to - from);
                at_low = sign * self.value(low, signal);
            } else {
                from = low;
                (low, at_low) = (high, at_high);
                high = from + golden * (to - from);
                at_high = sign * self.value(high, signal);
            }
        }
        most
    }

    /// ∫ of a function of s over a period, over the period.
    fn mean(&self, signal: usize, of: impl Fn(f64) -> f64) -> f64 {
        let mut sum = 0.0;
        for pair in self.orbit.mesh.windows(2) {
            let [from, to] = pair else { continue };
            for (place, weight) in GAUSS {
                let tau = from + place * (to - from);
                sum += weight * (to - from) * of(self.value(tau, signal));
            }
        }
        sum
    }
}
