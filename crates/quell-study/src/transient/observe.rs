//! What calls in criteria mean on a run in time.
//!
//! | written | meaning |
//! | --- | --- |
//! | `max(s)`, `min(s)` | extremes over the run, from the dense solution; `max(beyond(s))`: after the end event |
//! | `peak(s, n)`, `trough(s, n)` | the n-th local maximum, minimum |
//! | `largest(s, n)` | the n-th largest local maximum over the whole run, whenever it occurs |
//! | `span(s, level)` | from the first to the last time at which s > level; 0 if never; cut off at the end of the run |
//! | `span(s, level, factor)` | the same without stretches above the level that do not reach factor·level |
//! | `crossing(s, n)` | the time at which s rises through zero for the n-th time |
//! | `initial(s)`, `final(s)`, `at(s, 2 s)` | values at the start, at the end, at a time |
//! | `mean(s)`, `rms(s)` | over time |
//! | `integral(s)`, `integral(s, b)` | ∫ s dt, ∫ s db |
//! | `settling(s, band)`, `settling(s, target, band)` | time after which \|s - target\| ≤ band until the end; target 0 unless given |
//! | `settling(s, target, band, factor)` | the same without departures that do not reach factor·band |
//! | `decay_rate(s)` | rate at which the peaks of s decay, from the largest on: slope of their logarithms over time, 1/s |
//! | `potential(NAME)`, `kinetic(NAME)`, `dissipated(NAME)` | energy since the start that springs, inerters, dampers of a device or element took |
//! | `stored(NAME)` | potential and kinetic |
//! | `energy_error` | what the energy ledger misses, over its largest entry |
//!
//! s and b are any expressions of signals: coordinates and their derivatives, definitions, forces of ports, `t`,
//! `force(NAME)`, `stroke(NAME)`, `power(NAME)`, `kinetic(host)`.

use quell_expression::{Dimension, Expression, ExpressionError, Node, Scope};

use super::ledger::Fate;
use super::observation::{Observation, Window};
use super::plan::Watching;
use crate::study::Study;

/// The observation that an expression stands for, with its dimension, if it stands for one.
///
/// # Errors
/// A signal that cannot be had, arguments that do not fit.
pub(crate) fn observe(
    study: &Study,
    watching: &Watching<'_>,
    scope: &dyn Scope,
    expression: &Expression,
) -> Result<Option<(Observation, Dimension)>, ExpressionError> {
    let Node::Call {
        function,
        arguments,
        ..
    } = &expression.node
    else {
        let is_error = matches!(&expression.node, Node::Name(name) if name == "energy_error");
        return Ok(is_error.then_some((Observation::EnergyError, Dimension::NONE)));
    };
    let time = watching.time_dimension();
    let of = |argument: &Expression| watching.signal(argument);
    let found = match (function.as_str(), arguments.as_slice()) {
        ("max", [argument]) => {
            let (signal, dimension, window) = windowed(watching, argument)?;
            (Observation::Maximum(signal, window), dimension)
        }
        ("min", [argument]) => {
            let (signal, dimension, window) = windowed(watching, argument)?;
            (Observation::Minimum(signal, window), dimension)
        }
        ("crossing", [argument, count]) => {
            let (signal, _) = of(argument)?;
            (Observation::Crossing(signal, counted(count, scope)?), time)
        }
        ("peak" | "trough" | "largest", [argument, count]) => {
            let (signal, dimension) = of(argument)?;
            let count = counted(count, scope)?;
            let found = match function.as_str() {
                "peak" => Observation::Peak(signal, count),
                "trough" => Observation::Trough(signal, count),
                _ => Observation::Largest(signal, count),
            };
            (found, dimension)
        }
        ("span", [argument, level, rest @ ..]) if rest.len() <= 1 => {
            let (signal, dimension) = of(argument)?;
            let value = number(level, scope, dimension, "a level of the signal")?;
            if value <= 0.0 {
                return Err(ExpressionError::new(level.span, "the level is above zero")
                    .with_help("of a signal of both signs take `abs(s)`"));
            }
            let observation = Observation::Span {
                signal,
                level: value,
                graze: factor(rest, scope)?,
            };
            (observation, time)
        }
        ("decay_rate", [argument]) => {
            let (signal, _) = of(argument)?;
            (Observation::DecayRate(signal), Dimension::NONE / time)
        }
        ("initial", [argument]) => {
            let (signal, dimension) = of(argument)?;
            (Observation::Initial(signal), dimension)
        }
        ("final", [argument]) => {
            let (signal, dimension) = of(argument)?;
            (Observation::Final(signal), dimension)
        }
        ("at", [argument, moment]) => {
            let (signal, dimension) = of(argument)?;
            let moment = number(moment, scope, time, "a time")?;
            (Observation::At(signal, moment), dimension)
        }
        ("mean", [argument]) => {
            let (signal, dimension) = of(argument)?;
            (Observation::Mean(signal), dimension)
        }
        ("rms", [argument]) => {
            let (signal, dimension) = of(argument)?;
            (Observation::Rms(signal), dimension)
        }
        ("integral", [argument]) => {
            let (signal, dimension) = of(argument)?;
            (Observation::Integral(signal), dimension * time)
        }
        ("integral", [force, over]) => {
            let (force, first) = of(force)?;
            let (over, second) = of(over)?;
            (Observation::Work(force, over), first * second)
        }
        ("settling", [argument, rest @ ..]) if (1..=3).contains(&rest.len()) => {
            let (signal, dimension) = of(argument)?;
            let (target, band, graze) = match rest {
                [target, band, graze @ ..] => {
                    let target = number(target, scope, dimension, "a value of the signal")?;
                    (target, band, factor(graze, scope)?)
                }
                [band] => (0.0, band, 1.0),
                [] => return Ok(None),
            };
            let half = number(band, scope, dimension, "half the width of the band")?;
            if half <= 0.0 {
                return Err(ExpressionError::new(
                    band.span,
                    "half the width of the band is above zero",
                ));
            }
            (
                Observation::Settling {
                    signal,
                    target,
                    band: half,
                    graze,
                },
                time,
            )
        }
        ("potential" | "kinetic" | "dissipated" | "stored", _) => {
            let (signals, dimension) =
                watching.energy(function, arguments, |device, element| {
                    let fate = Fate::of(study, device, element);
                    match function.as_str() {
                        "potential" => fate == Fate::Potential,
                        "kinetic" => fate == Fate::Kinetic,
                        "dissipated" => fate == Fate::Dissipated,
                        _ => matches!(fate, Fate::Potential | Fate::Kinetic),
                    }
                })?;
            (Observation::Energy(signals), dimension)
        }
        (name @ ("peak" | "trough" | "crossing" | "largest"), _) => {
            return Err(arguments_wrong(
                expression,
                name,
                "a signal and a number, which one it is",
            ));
        }
        (name @ ("initial" | "final" | "mean" | "decay_rate"), _) => {
            return Err(arguments_wrong(expression, name, "one signal"));
        }
        ("at", _) => {
            return Err(arguments_wrong(
                expression,
                "at",
                "a signal and a time: `at(s, 2 s)`",
            ));
        }
        ("integral", _) => {
            return Err(arguments_wrong(
                expression,
                "integral",
                "one or two signals",
            ));
        }
        ("span", _) => {
            return Err(arguments_wrong(
                expression,
                "span",
                "a signal and a level: `span(abs(s), 1 mm)`, and a factor of the level below which a swing does not count",
            ));
        }
        ("settling", _) => {
            return Err(arguments_wrong(
                expression,
                "settling",
                "a signal and half the width of the band, with the target between them if it is not 0 and a factor of the band after them below which a swing does not count",
            ));
        }
        _ => return Ok(None),
    };
    Ok(Some(found))
}

fn arguments_wrong(call: &Expression, name: &str, takes: &str) -> ExpressionError {
    ExpressionError::new(call.span, format!("`{name}` takes {takes}"))
}

/// s, or `beyond(s)`.
fn windowed(
    watching: &Watching<'_>,
    expression: &Expression,
) -> Result<(usize, Dimension, Window), ExpressionError> {
    if let Node::Call {
        function,
        arguments,
        ..
    } = &expression.node
        && function == "beyond"
        && let [inner] = arguments.as_slice()
    {
        let (signal, dimension) = watching.signal(inner)?;
        return Ok((signal, dimension, Window::Beyond));
    }
    let (signal, dimension) = watching.signal(expression)?;
    Ok((signal, dimension, Window::Run))
}

/// A number of a dimension, of constants.
fn number(
    expression: &Expression,
    scope: &dyn Scope,
    dimension: Dimension,
    what: &str,
) -> Result<f64, ExpressionError> {
    let quantity = expression.evaluate(scope)?;
    if dimension.without_angle() == quantity.dimension.without_angle() || quantity.value == 0.0 {
        Ok(quantity.value)
    } else {
        Err(ExpressionError::new(
            expression.span,
            format!("{what} is in {dimension}, found {}", quantity.dimension),
        ))
    }
}

/// The factor of a level from which on a swing counts; 1 unless given.
fn factor(rest: &[Expression], scope: &dyn Scope) -> Result<f64, ExpressionError> {
    let [expression] = rest else {
        return Ok(1.0);
    };
    let factor = number(expression, scope, Dimension::NONE, "a factor of the level")?;
    if (1.0..=10.0).contains(&factor) {
        return Ok(factor);
    }
    Err(ExpressionError::new(
        expression.span,
        "the factor of the level from which on a swing counts lies between 1 and 10",
    ))
}

/// Which one, from 1.
fn counted(expression: &Expression, scope: &dyn Scope) -> Result<usize, ExpressionError> {
    let quantity = expression.evaluate(scope)?;
    if quantity.dimension.is_none() && quantity.value.fract() == 0.0 && quantity.value >= 1.0 {
        Ok(quantity.value as usize)
    } else {
        Err(ExpressionError::new(
            expression.span,
            "expected a whole number from 1: which one it is",
        ))
    }
}
