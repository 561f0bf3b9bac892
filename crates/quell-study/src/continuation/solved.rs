//! Tasks that have been solved, and the labelled points at which others may start.

use quell_continuation::{
    Branch, CriticalEquilibrium, CriticalOrbit, Equilibrium, Kind, Orbit, Special,
};

use super::model::{Model, Wanted};
use crate::study::ConfigurationSpec;

/// A branch with its solutions, from which others may start.
pub(super) enum Solutions {
    Equilibria(Branch<Equilibrium>),
    Cycles(Branch<Orbit>),
    /// Of folds or Hopf points.
    CriticalEquilibria(Branch<CriticalEquilibrium>, Kind),
    /// Of special cycles.
    CriticalOrbits(Branch<CriticalOrbit>, Kind),
}

/// A branch of a task.
pub(super) struct Member {
    pub(super) id: String,
    pub(super) parent: Option<String>,
    pub(super) solutions: Solutions,
}

/// A task that has been solved.
pub(crate) struct Solved {
    pub(super) model: Model,
    pub(super) spec: ConfigurationSpec,
    pub(super) wanted: Vec<Wanted>,
    pub(super) members: Vec<Member>,
    /// What was found.
    pub(crate) findings: super::ContinuationFindings,
}

/// A labelled point to start from.
pub(super) enum Begin<'a> {
    Equilibrium(&'a Special<Equilibrium>),
    Cycle(&'a Special<Orbit>),
    CriticalEquilibrium(&'a Special<CriticalEquilibrium>),
    CriticalOrbit(&'a Special<CriticalOrbit>),
}

impl Solved {
    /// The number of solutions, and of motions.
    pub(crate) fn solutions(&self) -> u64 {
        let points = self.findings.branches.iter();
        let followed: usize = points.map(|branch| branch.points.len()).sum();
        let motions = self.findings.motions.iter();
        let watched: usize = motions.map(|motions| motions.count().all).sum();
        (followed + watched) as u64
    }

    /// The point of a label, `H1` or `E1:H1`.
    pub(super) fn labelled(&self, label: &str) -> Result<(String, Begin<'_>), String> {
        let (branch, short) = match label.rsplit_once(':') {
            Some((branch, short)) => (Some(branch), short),
            None => (None, label),
        };
        let mut found = Vec::new();
        let mut known = Vec::new();
        for member in &self.members {
            let begins: Vec<(&str, Begin<'_>)> = match &member.solutions {
                Solutions::Equilibria(own) => own
                    .special
                    .iter()
                    .map(|one| (one.label.as_str(), Begin::Equilibrium(one)))
                    .collect(),
                Solutions::Cycles(own) => own
                    .special
                    .iter()
                    .map(|one| (one.label.as_str(), Begin::Cycle(one)))
                    .collect(),
                Solutions::CriticalEquilibria(own, _) => own
                    .special
                    .iter()
                    .map(|one| (one.label.as_str(), Begin::CriticalEquilibrium(one)))
                    .collect(),
                Solutions::CriticalOrbits(own, _) => own
                    .special
                    .iter()
                    .map(|one| (one.label.as_str(), Begin::CriticalOrbit(one)))
                    .collect(),
            };
            for (own, begin) in begins {
                let full = format!("{}:{own}", member.id);
                if own == short && branch.is_none_or(|branch| branch == member.id) {
                    found.push((full.clone(), begin));
                }
                known.push(full);
            }
        }
        match (found.len(), found.pop()) {
            (1, Some(only)) => Ok(only),
            (0, _) if known.is_empty() => Err("it found no special point".to_owned()),
            (0, _) => Err(format!("its points are {}", known.join(", "))),
            (_, Some(last)) => {
                let all: Vec<String> = found.into_iter().map(|(full, _)| full).collect();
                Err(format!(
                    "several branches have it: write {} or {}",
                    all.join(", "),
                    last.0
                ))
            }
            (_, None) => Err(String::new()),
        }
    }

    /// Values of another model's free parameters at a solution of this one.
    pub(super) fn lifted(&self, at: &[f64], model: &Model) -> Vec<f64> {
        model
            .axes()
            .iter()
            .map(|axis| {
                let own = self
                    .model
                    .axes()
                    .iter()
                    .position(|known| known.name == axis.name);
                own.and_then(|index| at.get(index))
                    .copied()
                    .unwrap_or(axis.base)
            })
            .collect()
    }
}
