//! From branches with solutions to what is handed out: measures, labels, reasons.

use quell_continuation::{
    Branch, Certainty, CriticalEquilibrium, CriticalOrbit, Equilibrium, Kind, Orbit, Point,
    Special, Stop,
};
use quell_expression::Quantity;
use rayon::prelude::*;

use super::ask::ContinuationTask;
use super::field::Field;
use super::measure;
use super::model::Model;
use super::outcome::{
    BranchOutcome, BranchPoint, ContinuationFindings, FreeParameter, MeasureHead, SpecialPoint,
};
use super::solved::{Member, Solutions};

pub(super) struct Reporter<'a> {
    pub(super) name: &'a str,
    pub(super) task: &'a ContinuationTask,
    pub(super) model: &'a Model,
    pub(super) field: &'a Field<'a>,
}

impl Reporter<'_> {
    /// Number of free parameters that are shown.
    pub(super) fn shown(&self) -> usize {
        self.task.parameters.len()
    }

    pub(super) fn findings(
        &self,
        members: &[Member],
        status: String,
        notes: Vec<String>,
    ) -> ContinuationFindings {
        ContinuationFindings {
            follows: self.task.follows,
            status,
            parameters: self
                .model
                .axes()
                .iter()
                .take(self.shown())
                .map(|axis| FreeParameter {
                    name: axis.name.clone(),
                    unit: axis.unit.clone(),
                    range: axis.range,
                })
                .collect(),
            measures: self
                .model
                .measures
                .iter()
                .take(self.model.shown)
                .map(|measure| MeasureHead {
                    name: measure.name.clone(),
                    unit: measure.unit.clone(),
                    factor: measure.factor,
                })
                .collect(),
            devices: self.model.devices.clone(),
            states: self.model.states(),
            oscillations: self
                .model
                .measures
                .iter()
                .skip(self.model.shown)
                .map(|measure| measure.name.clone())
                .collect(),
            branches: members.iter().map(|member| self.branch(member)).collect(),
            regions: None,
            motions: None,
            notes,
        }
    }

    fn branch(&self, member: &Member) -> BranchOutcome {
        let id = member.id.clone();
        let file = format!("{}-{id}.csv", file_stem(self.name));
        let parent = member.parent.clone();
        match &member.solutions {
            Solutions::Equilibria(branch) => self.outcome(id, "equilibrium", parent, file, branch),
            Solutions::Cycles(branch) => self.outcome(id, "cycle", parent, file, branch),
            Solutions::CriticalEquilibria(branch, kind) => {
                self.outcome(id, kind.code(), parent, file, branch)
            }
            Solutions::CriticalOrbits(branch, kind) => {
                self.outcome(id, kind.code(), parent, file, branch)
            }
        }
    }

    fn outcome<S: Solution>(
        &self,
        id: String,
        of: &'static str,
        parent: Option<String>,
        file: String,
        branch: &Branch<S>,
    ) -> BranchOutcome {
        let (all, special, at) = (&branch.points, &branch.special, &branch.at);
        let convert = |point: &Point<S>| self.point(&point.solution, point.unstable);
        BranchOutcome {
            id,
            of,
            parent,
            stop: branch.stop.map(stopped),
            file,
            points: all.par_iter().map(convert).collect(),
            special: special.par_iter().map(|one| self.special(one)).collect(),
            at: at.par_iter().map(convert).collect(),
        }
    }

    pub(super) fn point<S: Solution>(&self, solution: &S, unstable: usize) -> BranchPoint {
        let free = solution.parameters();
        let parameters = self.model.parameters(free);
        let (measures, largest) = self.named(solution.measured(self, &parameters));
        BranchPoint {
            parameters: free.iter().take(self.shown()).copied().collect(),
            period: solution.period(),
            omega: solution.omega(),
            unstable,
            measures,
            oscillation: largest.filter(|_| solution.period().is_some()),
            state: solution.state().to_vec(),
        }
    }

    /// The measures that are shown, and which of those by which oscillations are named is the largest.
    pub(super) fn named(&self, mut measures: Vec<f64>) -> (Vec<f64>, Option<usize>) {
        let naming = measures.split_off(self.model.shown.min(measures.len()));
        let largest = naming
            .iter()
            .enumerate()
            .filter(|(_, value)| value.is_finite())
            .max_by(|a, b| a.1.total_cmp(b.1));
        (measures, largest.map(|(index, _)| index))
    }

    fn special<S: Solution>(&self, one: &Special<S>) -> SpecialPoint {
        let range = self
            .model
            .axes()
            .first()
            .map_or((0.0, 0.0), |axis| axis.range);
        SpecialPoint {
            label: one.label.clone(),
            kind: one.kind.code().to_owned(),
            point: self.point(&one.solution, one.unstable[0].min(one.unstable[1])),
            omega: one.omega,
            second_omega: one.second_omega,
            unstable: one.unstable,
            normal_form: named(one.kind, &one.normal_form),
            error: one.error * (range.1 - range.0),
            located: one.certainty == Certainty::Located,
            after: one.after,
        }
    }
}

/// Names of the coefficients of normal forms.
fn named(kind: Kind, coefficients: &[f64]) -> Vec<(&'static str, f64)> {
    let names: &[&'static str] = match kind {
        Kind::Hopf => &["l1"],
        Kind::HopfHopf if coefficients.len() == 4 => &["p11", "p12", "p21", "p22"],
        // Of either pair by itself.
        Kind::HopfHopf => &["l1", "l1_second"],
        Kind::ZeroHopf => &["f200", "g110", "f011"],
        Kind::BogdanovTakens => &["a", "b"],
        Kind::CycleFold => &["b"],
        Kind::Cusp | Kind::PeriodDoubling => &["c"],
        Kind::Torus => &["d", "d_imaginary"],
        _ => &["a", "b", "c", "d"],
    };
    names
        .iter()
        .copied()
        .zip(coefficients.iter().copied())
        .collect()
}

/// Why a branch ended, in words.
fn stopped(stop: Stop) -> &'static str {
    match stop {
        Stop::Bound(_) => "bound",
        Stop::Points => "points",
        Stop::NoConvergence => "no convergence",
        Stop::NotFinite => "not finite",
        Stop::Singular => "singular",
        Stop::PeriodBound => "period bound",
        Stop::DegenerateFamily => "degenerate family",
        Stop::Vanished => "vanished",
        Stop::Closed => "closed",
        Stop::EndOfKind => "end of kind",
        Stop::Monitor => "monitor",
        Stop::Interrupted => "interrupted",
        Stop::NotAsked => "not asked",
    }
}

/// A name that every file system takes.
pub(super) fn file_stem(name: &str) -> String {
    name.chars()
        .map(|character| {
            if character.is_alphanumeric() || character == '-' {
                character
            } else {
                '_'
            }
        })
        .collect()
}

/// What all solutions of branches have.
pub(super) trait Solution: Sync {
    fn parameters(&self) -> &[f64];
    fn period(&self) -> Option<f64> {
        None
    }
    fn omega(&self) -> Option<f64> {
        None
    }
    fn state(&self) -> &[f64] {
        &[]
    }
    fn measured(&self, reporter: &Reporter<'_>, parameters: &[(String, Quantity)]) -> Vec<f64>;
}

impl Solution for Equilibrium {
    fn parameters(&self) -> &[f64] {
        &self.parameters
    }
    fn state(&self) -> &[f64] {
        &self.state
    }
    fn measured(&self, reporter: &Reporter<'_>, parameters: &[(String, Quantity)]) -> Vec<f64> {
        let model = reporter.model;
        let signals = model.system().signals();
        measure::at_equilibrium(&model.measures, reporter.field, signals, parameters, self)
    }
}

impl Solution for Orbit {
    fn parameters(&self) -> &[f64] {
        &self.parameters
    }
    fn period(&self) -> Option<f64> {
        Some(self.period)
    }
    fn measured(&self, reporter: &Reporter<'_>, parameters: &[(String, Quantity)]) -> Vec<f64> {
        let model = reporter.model;
        let signals = model.system().signals();
        measure::on_cycle(&model.measures, reporter.field, signals, parameters, self)
    }
}

impl Solution for CriticalEquilibrium {
    fn parameters(&self) -> &[f64] {
        &self.equilibrium.parameters
    }
    fn omega(&self) -> Option<f64> {
        (self.omega > 0.0).then_some(self.omega)
    }
    fn state(&self) -> &[f64] {
        &self.equilibrium.state
    }
    fn measured(&self, reporter: &Reporter<'_>, parameters: &[(String, Quantity)]) -> Vec<f64> {
        self.equilibrium.measured(reporter, parameters)
    }
}

impl Solution for CriticalOrbit {
    fn parameters(&self) -> &[f64] {
        &self.orbit.parameters
    }
    fn period(&self) -> Option<f64> {
        Some(self.orbit.period)
    }
    fn omega(&self) -> Option<f64> {
        Some(self.angle)
    }
    fn measured(&self, reporter: &Reporter<'_>, parameters: &[(String, Quantity)]) -> Vec<f64> {
        self.orbit.measured(reporter, parameters)
    }
}
