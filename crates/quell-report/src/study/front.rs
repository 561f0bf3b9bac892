//! The front of a task with several objectives.

use quell_study::study::{DesignTask, Objective};
use quell_study::{Evaluated, FrontFindings, PointOutcome};

use super::{Bridge, shown_unit};
use crate::page::{self, CriterionColumn};
use crate::plot::{Axis, Plot, Role, Series};

/// Layouts whose fronts are drawn in one picture: there are no more colours.
const DRAWN: usize = 6;

impl Bridge<'_> {
    /// The designs of the common front, from one end to the other.
    pub(super) fn front(
        &self,
        findings: &FrontFindings,
        point: &PointOutcome,
        design: Option<&DesignTask>,
        columns: &[CriterionColumn],
    ) -> Vec<page::Design> {
        let Some(first) = findings.objectives.first() else {
            return Vec::new();
        };
        findings
            .common()
            .into_iter()
            .map(|(_, found)| {
                let about = (first.criterion.as_str(), &[] as &[_]);
                self.design(&found.design, about, point, design, columns)
            })
            .collect()
    }

    /// Each objective after the first over the first, a colour for each layout; layouts with most of the common front first.
    pub(super) fn front_pictures(&self, findings: &FrontFindings) -> Vec<Plot> {
        let Some((first, further)) = findings.objectives.split_first() else {
            return Vec::new();
        };
        let mut layouts: Vec<_> = findings
            .layouts
            .iter()
            .filter(|layout| layout.points.iter().all(|point| point.design.feasible))
            .collect();
        layouts.sort_by_key(|layout| {
            let common = layout.points.iter().filter(|point| point.rank.is_some());
            std::cmp::Reverse(common.count())
        });
        let left = layouts.len().saturating_sub(DRAWN);
        further
            .iter()
            .map(|second| {
                let place = |one: &Evaluated| (self.shown(first, one), self.shown(second, one));
                let mut series: Vec<Series> = findings
                    .references
                    .iter()
                    .map(|reference| Series {
                        name: reference.configuration.name.clone(),
                        role: Role::Reference,
                        points: vec![place(&reference.configuration)],
                        peak: None,
                        markers: true,
                        ..Series::default()
                    })
                    .collect();
                series.extend(layouts.iter().take(DRAWN).map(|layout| {
                    Series {
                        name: layout.layout.clone(),
                        role: Role::Design,
                        points: layout
                            .points
                            .iter()
                            .map(|point| place(&point.design.configuration))
                            .collect(),
                        peak: None,
                        markers: true,
                        ..Series::default()
                    }
                }));
                let more = match left {
                    0 => String::new(),
                    1 => "; 1 more layout is left out".to_owned(),
                    left => format!("; {left} more layouts are left out"),
                };
                Plot {
                    caption: format!(
                        "Front of each layout: {} over {}{more}.",
                        second.criterion, first.criterion
                    ),
                    x: self.axis(findings, first),
                    y: self.axis(findings, second),
                    series,
                    limits: Vec::new(),
                    areas: Vec::new(),
                }
            })
            .collect()
    }

    fn shown(&self, objective: &Objective, one: &Evaluated) -> f64 {
        let value = one.criteria.get(&objective.criterion).copied();
        value.unwrap_or(f64::NAN) / shown_unit(self.study, &objective.criterion, "").0
    }

    fn axis(&self, findings: &FrontFindings, objective: &Objective) -> Axis {
        let si_unit = findings
            .layouts
            .iter()
            .flat_map(|layout| &layout.points)
            .find_map(|point| point.design.configuration.details.get(&objective.criterion))
            .map_or("", |detail| detail.unit.as_str());
        Axis {
            label: objective.criterion.clone(),
            unit: shown_unit(self.study, &objective.criterion, si_unit)
                .1
                .to_owned(),
            logarithmic: false,
        }
    }
}

/// What a front is, how it was found and who is not on it.
pub(super) fn front_words(findings: &FrontFindings) -> Vec<String> {
    let mut words = vec![format!(
        "No design of the front can be made better in one objective without becoming worse in another. Found by {}.",
        findings.method
    )];
    let without: Vec<String> = findings
        .layouts
        .iter()
        .filter(|layout| layout.points.iter().all(|point| point.rank.is_none()))
        .map(|layout| format!("`{}`", layout.layout))
        .collect();
    if !without.is_empty() {
        words.push(format!(
            "Nowhere on the common front: {}.",
            without.join(", ")
        ));
    }
    words
}
