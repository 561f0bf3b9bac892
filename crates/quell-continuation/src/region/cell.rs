//! What is stable at a point of a cell.

use crate::branch::{Branch, Point, Special};
use crate::diagram::{DiagramSettings, Mirrors, diagram};
use crate::kind::Kind;
use crate::orbit::Orbit;
use crate::problem::Problem;
use crate::settings::{ContinuationError, Settings};

use super::Attractor;

/// Orbits are the same when periods and ranges of states agree so well, relative.
const SAME: f64 = 1e-3;

/// Stable solutions at a point, and special points of cycles at which a stable one begins or ends.
#[derive(Default)]
pub(super) struct Looked {
    pub(super) attractors: Vec<Attractor>,
    pub(super) seeds: Vec<Special<Orbit>>,
    /// Mirror images were left out.
    pub(super) mirrors: Mirrors,
    pub(super) failed: Vec<(String, ContinuationError)>,
}

/// Follows the diagrams through a point along both parameters.
pub(super) fn look(
    problem: &dyn Problem,
    at: [f64; 2],
    rest: Option<&[f64]>,
    settings: &DiagramSettings,
) -> Looked {
    let mut out = Looked::default();
    for (free, place) in at.iter().enumerate() {
        let mut asked = settings.clone();
        asked.branch = Settings {
            ranges: vec![(0.0, 1.0)],
            at: vec![*place],
            ..settings.branch.clone()
        };
        if let Some(rest) = rest {
            // The box is about the equilibrium here.
            for ((low, high), x) in asked.states.iter_mut().zip(rest) {
                let half = 0.5 * (*high - *low);
                (*low, *high) = (x - half, x + half);
            }
        }
        let found = match diagram(problem, &at, free, &asked) {
            Ok(found) => found,
            Err(error) => {
                out.failed.push((format!("{at:?}"), error));
                continue;
            }
        };
        if found.mirrored {
            out.mirrors = found.mirrors.clone();
        }
        for member in &found.equilibria {
            for point in stable(&member.branch) {
                out.add(Attractor::Equilibrium(point.solution.clone()));
            }
        }
        for member in &found.cycles {
            for point in stable(&member.branch) {
                out.add(Attractor::Cycle(point.solution.clone()));
            }
            for special in &member.branch.special {
                let ends = special.unstable.contains(&0)
                    && matches!(
                        special.kind,
                        Kind::CycleFold | Kind::PeriodDoubling | Kind::Torus
                    );
                if ends {
                    out.seeds.push(special.clone());
                }
            }
        }
        for (branch, label, error) in found.failed {
            out.failed.push((format!("{branch}:{label}"), error));
        }
    }
    out
}

fn stable<S>(branch: &Branch<S>) -> impl Iterator<Item = &Point<S>> {
    branch.at.iter().filter(|point| point.unstable == 0)
}

impl Looked {
    /// Adds what is not known yet.
    pub(super) fn add(&mut self, new: Attractor) {
        let known = self.attractors.iter().any(|known| match (known, &new) {
            (Attractor::Equilibrium(known), Attractor::Equilibrium(new)) => {
                self.mirrors.images(&new.state).any(|image| {
                    let mut pairs = known.state.iter().zip(&image);
                    pairs.all(|(a, b)| (a - b).abs() <= 1e-6 * (1.0 + a.abs()))
                })
            }
            (Attractor::Cycle(known), Attractor::Cycle(new)) => same(known, new, &self.mirrors),
            _ => false,
        });
        if !known {
            self.attractors.push(new);
        }
    }
}

/// Whether two orbits at the same parameters are one, or mirror images.
fn same(a: &Orbit, b: &Orbit, mirrors: &Mirrors) -> bool {
    if (a.period / b.period - 1.0).abs() > SAME {
        return false;
    }
    let ranges = |orbit: &Orbit| -> Vec<(f64, f64)> {
        (0..orbit.dimension).map(|i| orbit.range(i)).collect()
    };
    let (own, other) = (ranges(a), ranges(b));
    mirrors.ranges(&other).any(|image| {
        own.iter().zip(&image).all(|((low, high), (other, top))| {
            let size = (high - low).max(top - other);
            (low - other).abs().max((high - top).abs()) <= SAME.sqrt() * size + 1e-9
        })
    })
}
