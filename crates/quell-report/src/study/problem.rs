//! The problem in words: host, excitation, devices, criteria, bounds.

use std::fmt::Write as _;

use quell_network::Domain;
use quell_study::study::{self, DesignTask, TaskKind};
use quell_study::{Findings, NamedValue, RunOutcome, Sense};

use super::Bridge;
use crate::number::{compact, unit};
use crate::page::{BoundRow, Bounds, CriterionRow, Fact, Parameter, Problem, Quantity};

impl Bridge<'_> {
    pub(super) fn problem(&self, outcome: &RunOutcome) -> Problem {
        Problem {
            paragraphs: self.study.report.note.iter().cloned().collect(),
            facts: self.facts(),
            criteria: self.criteria(outcome),
            parameters: self.parameters(),
            bounds: self.bounds(outcome),
            constraints: self.constraints(outcome),
        }
    }

    fn facts(&self) -> Vec<Fact> {
        let mut facts = Vec::new();
        let title = self.study.host.title();
        facts.push(match &self.standing {
            Some(standing) => Fact::new("Host", format!("{title}: {}", standing.size())),
            None => Fact::new("Host", title),
        });
        for (name, run) in &self.study.runs {
            facts.push(Fact::new(format!("Run {name}"), self.excitation(run)));
        }
        for (name, device) in &self.study.devices {
            facts.push(Fact::new(
                format!("Device {name}"),
                self.device_words(device),
            ));
        }
        for (name, component) in &self.study.components {
            let values: Vec<String> = component
                .values
                .iter()
                .map(|(element, amount)| format!("`{element} = {}`", amount.expression()))
                .collect();
            facts.push(Fact::new(
                format!("Component {name}"),
                format!("`{}` with {}", component.layout, values.join(", ")),
            ));
        }
        facts
    }

    fn device_words(&self, device: &study::Device) -> String {
        let domain = match device.domain {
            Domain::Translational => "",
            Domain::Rotational => ", rotational",
            Domain::Electrical => ", electrical",
            Domain::Hydraulic => ", hydraulic",
        };
        let mut text = format!("on port `{}`{domain}", device.port);
        if let Some(layout) = &device.layout {
            let _ = write!(text, ", `{layout}`");
        }
        match device.slots.as_slice() {
            [] => {}
            [only] => {
                let _ = write!(text, " with any layout as `{only}`");
            }
            several => {
                let _ = write!(text, " with any layouts as `{}`", several.join("`, `"));
            }
        }
        if let Some(piston) = &device.piston {
            let parameters = self
                .standing
                .as_ref()
                .map_or(&[][..], |standing| standing.parameters.as_slice());
            let _ = write!(text, ", through a piston of area `{}`", piston.expression());
            if let Ok(area) = piston.quantity(&parameters.to_vec()) {
                let _ = write!(
                    text,
                    " ({} {})",
                    compact(area.value, 5),
                    unit(&area.dimension.unit_text())
                );
            }
        }
        text
    }

    fn criteria(&self, outcome: &RunOutcome) -> Vec<CriterionRow> {
        self.study
            .criteria
            .iter()
            .map(|(name, criterion)| CriterionRow {
                name: name.clone(),
                meaning: match (&criterion.band, &criterion.run) {
                    (Some(band), _) => {
                        let over = band.over.as_ref();
                        let over =
                            over.map_or_else(String::new, |over| format!(" over {}", over.name));
                        let meaning = self.meaning(criterion);
                        format!("{meaning} of the stable band of {}{over}", band.of)
                    }
                    (None, Some(run)) => format!("{}, run `{run}`", self.meaning(criterion)),
                    (None, None) => format!("{}, of other criteria", self.meaning(criterion)),
                },
                unit: super::shown_unit(self.study, name, &si_unit(outcome, name))
                    .1
                    .to_owned(),
            })
            .collect()
    }

    fn parameters(&self) -> Vec<Parameter> {
        let Some(standing) = &self.standing else {
            return Vec::new();
        };
        standing
            .parameters
            .iter()
            .map(|(name, quantity)| Parameter {
                name: name.clone(),
                value: Quantity::new(quantity.value, quantity.dimension.unit_text()),
            })
            .collect()
    }

    /// Bounds of components, then those of tasks; a name with other bounds in another task has a row of its own.
    fn bounds(&self, outcome: &RunOutcome) -> Vec<BoundRow> {
        let mut rows: Vec<BoundRow> = Vec::new();
        for (name, component) in &self.study.components {
            for (variable, bounds) in &component.variables {
                self.add_bounds(&mut rows, outcome, &format!("{name}.{variable}"), bounds);
            }
        }
        for design in self.design_tasks(outcome) {
            for (name, bounds) in &design.bounds {
                self.add_bounds(&mut rows, outcome, name, bounds);
            }
        }
        rows
    }

    fn add_bounds(
        &self,
        rows: &mut Vec<BoundRow>,
        outcome: &RunOutcome,
        name: &str,
        bounds: &study::Bounds,
    ) {
        let Some(standing) = &self.standing else {
            return;
        };
        let (Ok(lower), Ok(upper)) = (
            bounds.lower.quantity(&standing.parameters),
            bounds.upper.quantity(&standing.parameters),
        ) else {
            return;
        };
        let found = variable_of(outcome, name);
        let row = BoundRow {
            variable: name.to_owned(),
            bounds: Bounds {
                lower: lower.value,
                upper: upper.value,
                logarithmic: found
                    .map_or(upper.value >= 10.0 * lower.value, |known| known.logarithmic),
            },
            unit: found.map_or_else(|| lower.dimension.unit_text(), |known| known.unit.clone()),
        };
        if !rows.contains(&row) {
            rows.push(row);
        }
    }

    /// The design tasks that were run.
    fn design_tasks<'b>(&'b self, outcome: &'b RunOutcome) -> impl Iterator<Item = &'b DesignTask> {
        self.study.tasks.iter().filter_map(|task| {
            let run = outcome.tasks.iter().any(|known| known.name == task.name);
            match &task.kind {
                TaskKind::Design(design) if run => Some(design.as_ref()),
                _ => None,
            }
        })
    }

    fn constraints(&self, outcome: &RunOutcome) -> Vec<String> {
        let mut all: Vec<String> = Vec::new();
        for constraint in self
            .design_tasks(outcome)
            .flat_map(|design| &design.constraints)
        {
            let symbol = match constraint.sense {
                Sense::Minimise => "≤",
                Sense::Maximise => "≥",
            };
            let text = format!(
                "{} {symbol} {}",
                constraint.criterion,
                constraint.bound.expression()
            );
            if !all.contains(&text) {
                all.push(text);
            }
        }
        all
    }
}

/// SI unit of a criterion, from the first value of it.
fn si_unit(outcome: &RunOutcome, criterion: &str) -> String {
    let points = outcome.tasks.iter().flat_map(|task| &task.points);
    points
        .flat_map(|point| evaluated(&point.findings))
        .find_map(|one| one.details.get(criterion))
        .map_or_else(String::new, |detail| detail.unit.clone())
}

/// Every configuration of a finding: evaluated ones, references, designs.
pub(super) fn evaluated(
    findings: &Findings,
) -> Box<dyn Iterator<Item = &quell_study::Evaluated> + '_> {
    match findings {
        Findings::Evaluate(all) => Box::new(all.iter()),
        Findings::Continuation(_) => Box::new(std::iter::empty()),
        Findings::Design(design) => Box::new(
            design
                .references
                .iter()
                .map(|one| &one.configuration)
                .chain(design.designs.iter().map(|one| &one.configuration)),
        ),
        Findings::Front(front) => Box::new(
            front.references.iter().map(|one| &one.configuration).chain(
                front
                    .layouts
                    .iter()
                    .flat_map(|layout| &layout.points)
                    .map(|point| &point.design.configuration),
            ),
        ),
    }
}

/// A searched variable that the bounds of this name hold for: `k1` for `k`, `pipe2.d` for `pipe.d`.
fn variable_of<'a>(outcome: &'a RunOutcome, name: &str) -> Option<&'a NamedValue> {
    let numberless = |text: &str| {
        text.trim_end_matches(|c: char| c.is_ascii_digit())
            .to_owned()
    };
    let covers = |variable: &str| {
        variable == name
            || match variable.split_once('.') {
                Some((instance, rest)) => format!("{}.{rest}", numberless(instance)) == name,
                None => numberless(variable) == name,
            }
    };
    let points = outcome.tasks.iter().flat_map(|task| &task.points);
    points
        .flat_map(|point| evaluated(&point.findings))
        .flat_map(|one| &one.devices)
        .find_map(|device| {
            device.variables.iter().find(|variable| {
                variable.bounds.is_some()
                    && (covers(&variable.name)
                        || name
                            .strip_prefix(device.name.as_str())
                            .and_then(|rest| rest.strip_prefix('.'))
                            .is_some_and(|own| {
                                own == variable.name || own == numberless(&variable.name)
                            }))
            })
        })
}
