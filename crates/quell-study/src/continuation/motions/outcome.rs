//! What motions let go from several starts did.

use std::fmt::Write as _;

use super::super::outcome::{BranchPoint, largest};

/// What a task of kind `simulate` found.
#[derive(Debug, Clone)]
pub struct MotionFindings {
    /// The task whose stable solutions the motions are compared with.
    pub of: Option<String>,
    /// The file of the measures over time.
    pub file: String,
    /// By values of the parameters.
    pub places: Vec<PlaceOutcome>,
}

/// Motions at one set of values of the parameters.
#[derive(Debug, Clone)]
pub struct PlaceOutcome {
    /// Values of the parameters, SI.
    pub parameters: Vec<f64>,
    /// What the other task says is stable here.
    pub stable: Vec<StableOutcome>,
    /// One for each start.
    pub motions: Vec<MotionOutcome>,
}

/// A solution that another task says is stable.
#[derive(Debug, Clone)]
pub struct StableOutcome {
    /// The branch, or the cell of a region.
    pub on: String,
    /// `equilibrium` or `cycle`.
    pub of: &'static str,
    /// The solution; of a cell the one at the point in which the cell was looked at.
    pub point: BranchPoint,
}

/// A motion.
#[derive(Debug, Clone)]
pub struct MotionOutcome {
    /// Where it began, in words.
    pub start: String,
    /// How long it was watched, s.
    pub duration: f64,
    /// What it came to.
    pub end: MotionEnd,
    /// The equilibrium or cycle on which it ended; otherwise its last stretch.
    pub point: BranchPoint,
    /// Which of the stable solutions that is.
    pub on: Option<usize>,
    /// Measures over stretches of the motion, SI, with the times at which these end, s.
    pub envelope: Vec<(f64, Vec<f64>)>,
}

/// What a motion came to.
#[derive(Debug, Clone, PartialEq)]
pub enum MotionEnd {
    /// It came to rest.
    Equilibrium,
    /// It repeats itself.
    Cycle,
    /// It was still changing, in words.
    Open(String),
    /// The simulation went no further, in words.
    Failed(String),
}

impl MotionEnd {
    /// `equilibrium`, `cycle`, `open` or `failed`.
    #[must_use]
    pub const fn code(&self) -> &'static str {
        match self {
            Self::Equilibrium => "equilibrium",
            Self::Cycle => "cycle",
            Self::Open(_) => "open",
            Self::Failed(_) => "failed",
        }
    }

    /// Why it is neither at rest nor on a cycle.
    #[must_use]
    pub fn why(&self) -> Option<&str> {
        match self {
            Self::Open(why) | Self::Failed(why) => Some(why),
            Self::Equilibrium | Self::Cycle => None,
        }
    }

    /// Whether it is known where the motion ends.
    #[must_use]
    pub const fn settled(&self) -> bool {
        matches!(self, Self::Equilibrium | Self::Cycle)
    }
}

/// How many motions came to what.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MotionCount {
    /// All of them.
    pub all: usize,
    /// On a solution that the other task says is stable.
    pub agree: usize,
    /// On one that it does not have, or does not say is stable.
    pub elsewhere: usize,
    /// Still changing, or broken off.
    pub open: usize,
}

impl MotionFindings {
    /// How many motions came to what; without another task none agrees, and none is elsewhere.
    #[must_use]
    pub fn count(&self) -> MotionCount {
        let mut count = MotionCount::default();
        for motion in self.places.iter().flat_map(|place| &place.motions) {
            count.all += 1;
            if !motion.end.settled() {
                count.open += 1;
            } else if motion.on.is_some() {
                count.agree += 1;
            } else if self.of.is_some() {
                count.elsewhere += 1;
            }
        }
        count
    }

    /// The largest of each measure by its absolute value over all motions, SI: beside it smaller ones are rounding.
    #[must_use]
    pub fn largest(&self) -> Vec<f64> {
        let motions = || self.places.iter().flat_map(|place| &place.motions);
        let ends = motions().map(|motion| &motion.point.measures);
        let on_the_way = motions().flat_map(|motion| motion.envelope.iter().map(|(_, row)| row));
        largest(ends.chain(on_the_way))
    }

    /// The count in words.
    #[must_use]
    pub fn summary(&self) -> String {
        let MotionCount {
            all,
            agree,
            elsewhere,
            open,
        } = self.count();
        let motions = |number: usize| if number == 1 { "motion" } else { "motions" };
        let mut text = match &self.of {
            Some(of) => format!(
                "{agree} of {all} {} ended on what `{of}` says is stable",
                motions(all)
            ),
            None => format!("{} of {all} {} settled", all - open, motions(all)),
        };
        // Writing to a string cannot fail.
        if elsewhere > 0 {
            let _ = write!(text, ", {elsewhere} elsewhere");
        }
        if open > 0 && self.of.is_some() {
            let _ = write!(text, ", {open} did not settle");
        }
        text
    }

    /// Measures over time as comma-separated values; SI.
    #[must_use]
    pub fn csv<'n>(
        &self,
        parameters: impl Iterator<Item = &'n str>,
        measures: impl Iterator<Item = &'n str>,
    ) -> String {
        let mut text = String::from("motion");
        for name in parameters {
            let _ = write!(text, ",{name}");
        }
        text.push_str(",t_s");
        for name in measures {
            let _ = write!(text, ",{name}");
        }
        text.push('\n');
        let mut number = 0;
        for place in &self.places {
            for motion in &place.motions {
                number += 1;
                for (t, values) in &motion.envelope {
                    let _ = write!(text, "{number}");
                    for value in place.parameters.iter().chain([t]).chain(values) {
                        text.push(',');
                        if value.is_finite() {
                            let _ = write!(text, "{value:?}");
                        }
                    }
                    text.push('\n');
                }
            }
        }
        text
    }
}
