//! What an engineer should know of a design beyond its numbers, in words.

use std::fmt::Write as _;

use indexmap::IndexMap;
use quell_network::{Gone, Kind, Layout};
use quell_search::{Outcome, Problem, Settings, Side};

use super::design::constraint_words;
use crate::candidates::Candidate;
use crate::outcome::Evaluated;
use crate::problem::{DesignProblem, Goal, ProblemScratch};
use crate::study::DesignTask;
use crate::transient::COMPUTED_BUT;

/// A value is flat when the largest that does as well is so many times the smallest.
const FACTOR: f64 = 1.5;

/// Or, where the smallest is not positive, when they lie so far apart, relative to the range.
const PART: f64 = 0.2;

/// First step of the look around, relative to the range on the scale of the search.
const STEP: f64 = 1e-3;

/// So far beyond its bound a value is tried that does as well at the bound. A limit is approached at least as 1/value,
/// while larger factors make runs in time stiff for nothing.
const BEYOND: f64 = 100.0;

/// Halvings between the last value that does as well and the first that does not.
const HALVINGS: usize = 12;

/// How far each constraint is missed, relative to its bound: 0 where it holds.
pub(super) fn violations(
    evaluated: &Evaluated,
    design: &DesignTask,
    goals: &[Goal],
) -> IndexMap<String, f64> {
    goals
        .iter()
        .zip(&design.constraints)
        .map(|(goal, constraint)| {
            let value = evaluated.criteria.get(&constraint.criterion);
            let excess = goal.excess(value.copied().unwrap_or(f64::NAN));
            let missed = if excess.is_nan() {
                f64::INFINITY
            } else if excess <= design.feasibility {
                0.0
            } else {
                excess
            };
            (constraint_words(constraint), missed)
        })
        .collect()
}

/// Which constraint costs what, of a design that misses one; of a single constraint the violation says it all.
pub(super) fn missed(violations: &IndexMap<String, f64>) -> Option<String> {
    if violations.len() < 2 {
        return None;
    }
    let mut text = String::new();
    for (words, missed) in violations {
        if !text.is_empty() {
            text.push_str(", ");
        }
        // Writing to a string cannot fail.
        let _ = if *missed == 0.0 {
            write!(text, "`{words}` holds")
        } else if missed.is_finite() {
            write!(text, "`{words}` is missed by {} %", rounded(100.0 * missed))
        } else {
            write!(text, "`{words}` has no number")
        };
    }
    Some(text)
}

/// What is said of the numbers that a design rests on beyond that they were computed: grazed events, swings that just count.
pub(super) fn cautions(evaluated: &Evaluated, design: &DesignTask) -> Vec<String> {
    let mut said: IndexMap<&str, Vec<&str>> = IndexMap::new();
    let objectives = design.objectives();
    let asked = objectives.iter().map(|objective| &objective.criterion);
    let constrained = design.constraints.iter().map(|one| &one.criterion);
    for name in asked.chain(constrained) {
        let detail = evaluated.details.get(name);
        if let Some(caution) = detail.and_then(|detail| detail.status.strip_prefix(COMPUTED_BUT)) {
            let names = said.entry(caution).or_default();
            if !names.contains(&name.as_str()) {
                names.push(name);
            }
        }
    }
    said.into_iter()
        .map(|(caution, names)| format!("`{}`: {caution}", names.join("`, `")))
        .collect()
}

/// Flat directions, and bounds behind which another layout lies.
///
/// A value is flat when it alone can go from the design to [`FACTOR`] times another value while the objective, as the
/// search sees it, stays within the agreement tolerance and every constraint holds.
pub(super) fn remarks(
    problem: &DesignProblem,
    candidate: &Candidate,
    evaluated: &Evaluated,
    outcome: &Outcome,
    settings: &Settings,
) -> Vec<String> {
    if !outcome.feasible || !outcome.objective.is_finite() {
        return Vec::new();
    }
    let mut look = Look {
        problem,
        outcome,
        settings,
        scratch: problem.scratch(),
        constraints: vec![0.0; problem.constraints()],
    };
    let mut remarks = Vec::new();
    for (index, variable) in problem.variables().iter().enumerate() {
        let name = &variable.name;
        let shown = |value: f64| with_unit(value, unit_of(evaluated, name));
        let limit = |side: Side| limit(candidate, name, side);
        let active = outcome
            .active_bounds
            .iter()
            .find(|(known, _)| *known == index)
            .map(|(_, side)| *side);
        match look.range(index) {
            Some((low, high)) => {
                let ends = [
                    (Side::Lower, low <= variable.lower),
                    (Side::Upper, high >= variable.upper),
                ];
                let mut text = if ends.iter().all(|(_, reached)| *reached) {
                    format!("`{name}` may lie anywhere between its bounds")
                } else {
                    format!(
                        "`{name}` may lie anywhere from {} to {}",
                        shown(low),
                        shown(high)
                    )
                };
                let _ = write!(
                    text,
                    ": by itself it changes the objective by less than {} of it",
                    settings.agreement
                );
                // One limit is enough: of a value that matters nowhere, the one without the element.
                let beyond =
                    ends.into_iter()
                        .filter(|(_, reached)| *reached)
                        .find_map(|(side, _)| {
                            let limit = limit(side)?;
                            look.goes_on(index, side).then_some((side, limit))
                        });
                if let Some((side, limit)) = beyond {
                    let _ = match side {
                        Side::Lower => write!(text, "; so does a hundredth of the lower bound"),
                        Side::Upper => write!(text, "; so does a hundred times the upper bound"),
                    };
                    let _ = write!(text, ", and behind it lies {limit}");
                }
                remarks.push(text);
            }
            None => {
                if let Some((side, limit)) = active.and_then(|side| Some((side, limit(side)?))) {
                    let end = match side {
                        Side::Lower => "lower",
                        Side::Upper => "upper",
                    };
                    remarks.push(format!(
                        "`{name}` runs to its {end} bound, {}: behind it lies {limit}",
                        shown(match side {
                            Side::Lower => variable.lower,
                            Side::Upper => variable.upper,
                        })
                    ));
                }
            }
        }
    }
    remarks
}

/// A look around a design along one variable at a time.
struct Look<'a> {
    problem: &'a DesignProblem,
    outcome: &'a Outcome,
    settings: &'a Settings,
    scratch: ProblemScratch,
    constraints: Vec<f64>,
}

impl Look<'_> {
    /// Whether a value of one variable does as well as the design's.
    fn as_good(&mut self, index: usize, value: f64) -> bool {
        let mut point = self.outcome.point.clone();
        let Some(place) = point.get_mut(index) else {
            return false;
        };
        *place = value;
        self.constraints.fill(0.0);
        let objective = self
            .problem
            .evaluate(&point, &mut self.constraints, &mut self.scratch);
        let best = self.outcome.objective;
        let allowed = self.settings.agreement * best.abs().max(self.settings.magnitude);
        (objective - best).abs() <= allowed
            && self
                .constraints
                .iter()
                .all(|excess| *excess <= self.settings.feasibility)
    }

    /// Whether a value far beyond a bound does as well: then the bound is not what matters, and the limit does as well too.
    fn goes_on(&mut self, index: usize, side: Side) -> bool {
        let Some(variable) = self.problem.variables().get(index) else {
            return false;
        };
        let value = match side {
            Side::Lower => variable.lower / BEYOND,
            Side::Upper => variable.upper * BEYOND,
        };
        self.as_good(index, value)
    }

    /// How far one variable can go while the objective stays, where that is far enough to be told.
    fn range(&mut self, index: usize) -> Option<(f64, f64)> {
        let variable = self.problem.variables().get(index)?.clone();
        let here = variable.coordinate(*self.outcome.point.get(index)?);
        let mut ends = [here; 2];
        for (end, direction) in ends.iter_mut().zip([-1.0, 1.0]) {
            let room = if direction < 0.0 { here } else { 1.0 - here };
            let (mut good, mut step) = (0.0, STEP);
            let mut bad = None;
            while good < room {
                let next = step.min(room);
                if !self.as_good(index, variable.value(here + direction * next)) {
                    bad = Some(next);
                    break;
                }
                good = next;
                step *= 2.0;
            }
            if let Some(mut bad) = bad {
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (good + bad);
                    if self.as_good(index, variable.value(here + direction * middle)) {
                        good = middle;
                    } else {
                        bad = middle;
                    }
                }
            }
            *end = here + direction * good;
        }
        let [low, high] = ends.map(|end| variable.value(end));
        let flat = if low > 0.0 {
            high >= FACTOR * low
        } else {
            high - low >= PART * (variable.upper - variable.lower)
        };
        flat.then_some((low, high))
    }
}

/// What lies behind a bound of an element's value: the layout without it, in words.
fn limit(candidate: &Candidate, variable: &str, side: Side) -> Option<String> {
    let (layout, element, name) = candidate.layouts.iter().find_map(|(slot, layout, _)| {
        // Where devices share a name, the device's stands before it.
        let own = variable
            .strip_prefix(slot.device.as_str())
            .and_then(|rest| rest.strip_prefix('.'));
        [Some(variable), own]
            .into_iter()
            .flatten()
            .find_map(|name| match layout.branch(name)?.kind {
                Kind::Element(element) => Some((layout, element, name)),
                _ => None,
            })
    })?;
    let inverse = layout.domain().inverts(element);
    let how = match (side, inverse) {
        (Side::Lower, false) | (Side::Upper, true) => Gone::Free,
        (Side::Upper, false) | (Side::Lower, true) => Gone::Rigid,
    };
    let left: Option<Layout> = layout
        .removals(&[])
        .into_iter()
        .find(|removal| removal.branch == name && removal.how == how)
        .and_then(|removal| removal.layout);
    let what = match how {
        Gone::Free => "no force through it",
        Gone::Rigid => "no motion across it",
    };
    match left {
        Some(left) => Some(format!("another layout, `{left}` ({what})")),
        // A mass on a rigid link ties the device to the inertial frame, which is no layout.
        None if how == Gone::Rigid && layout.contains_mass() => None,
        None => Some(match how {
            Gone::Free => "no device at all".to_owned(),
            Gone::Rigid => "a rigid link in place of the device".to_owned(),
        }),
    }
}

fn unit_of<'a>(evaluated: &'a Evaluated, variable: &str) -> &'a str {
    evaluated
        .devices
        .iter()
        .flat_map(|device| device.variables.iter().map(move |value| (device, value)))
        .find(|(device, value)| {
            value.name == variable || format!("{}.{}", device.name, value.name) == variable
        })
        .map_or("", |(_, value)| value.unit.as_str())
}

fn with_unit(value: f64, unit: &str) -> String {
    if unit.is_empty() {
        rounded(value)
    } else {
        format!("{} {unit}", rounded(value))
    }
}

/// A number to four significant digits, as short as it can be written.
fn rounded(value: f64) -> String {
    let near: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    if near != 0.0 && !(1e-4..1e7).contains(&near.abs()) {
        format!("{near:e}")
    } else {
        format!("{near}")
    }
}
