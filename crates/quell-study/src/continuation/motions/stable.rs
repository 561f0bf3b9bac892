//! What branches or a region say is stable at values of their parameters.

use quell_continuation::{
    Branch, Equilibrium, Orbit, Point, Settings, cycles_from_orbit, equilibria,
};

use super::super::ask::Follows;
use super::super::model::Model;
use super::super::outcome::BranchPoint;
use super::super::region::{CellOutcome, RegionFindings};
use super::super::report::Reporter;
use super::super::solved::{Solutions, Solved};
use super::outcome::StableOutcome;

/// A stable solution, with what motions are told by whether they end there.
pub(super) struct Stable {
    pub(super) shown: StableOutcome,
    pub(super) solution: Solution,
}

pub(super) enum Solution {
    Equilibrium(Equilibrium),
    Cycle(Orbit),
    /// Of a cell: its kind and name are known, and not where it lies here.
    Named,
}

/// Most points from one of the branch to the value that is asked for.
const POINTS: usize = 60;

impl Solved {
    /// All free parameters where those that are shown have these values; the others stay as they are on the branches.
    pub(super) fn free(&self, place: &[f64]) -> Vec<f64> {
        let own = self
            .members
            .iter()
            .find_map(|member| match &member.solutions {
                Solutions::Equilibria(branch) => {
                    let first = branch.points.first()?;
                    Some(first.solution.parameters.clone())
                }
                Solutions::Cycles(branch) => {
                    let first = branch.points.first()?;
                    Some(first.solution.parameters.clone())
                }
                _ => None,
            });
        let mut free = own.unwrap_or_else(|| self.model.base());
        for (entry, value) in free.iter_mut().zip(place) {
            *entry = *value;
        }
        free
    }

    /// What it says is stable where the parameters have these values.
    pub(super) fn stable(&self, place: &[f64], reporter: &Reporter<'_>) -> Vec<Stable> {
        if self.findings.follows == Follows::Region {
            let regions = self.findings.regions.as_ref();
            let cell = regions.and_then(|regions| cell(regions, place));
            return cell.map(in_cell).unwrap_or_default();
        }
        let Some(value) = place.first().copied() else {
            return Vec::new();
        };
        let mut found = Vec::new();
        for member in &self.members {
            let mut add = |of, point: BranchPoint, solution| {
                let shown = StableOutcome {
                    on: member.id.clone(),
                    of,
                    point,
                };
                found.push(Stable { shown, solution });
            };
            match &member.solutions {
                Solutions::Equilibria(branch) => {
                    for one in crossings(branch, value, |one| &one.parameters) {
                        if let Some(at) = equilibrium(&self.model, one, value) {
                            let point = reporter.point(&at, 0);
                            add("equilibrium", point, Solution::Equilibrium(at));
                        }
                    }
                }
                Solutions::Cycles(branch) => {
                    for one in crossings(branch, value, |one| &one.parameters) {
                        if let Some(at) = cycle(&self.model, one, value) {
                            let point = reporter.point(&at, 0);
                            add("cycle", point, Solution::Cycle(at));
                        }
                    }
                }
                Solutions::CriticalEquilibria(..) | Solutions::CriticalOrbits(..) => {}
            }
        }
        found
    }
}

/// Pairs of neighbours between which the first parameter passes a value.
fn crossings<'a, S>(
    branch: &'a Branch<S>,
    value: f64,
    parameters: impl Fn(&S) -> &[f64] + Copy + 'a,
) -> impl Iterator<Item = [&'a Point<S>; 2]> {
    let first = move |one: &Point<S>| {
        let known = parameters(&one.solution).first();
        known.map_or(f64::NAN, |known| known - value)
    };
    let last = branch.points.len().saturating_sub(2);
    branch
        .points
        .windows(2)
        .enumerate()
        .filter_map(move |(index, pair)| {
            let [one, other] = pair else { return None };
            let (a, b) = (first(one), first(other));
            if index == last && b == 0.0 {
                // A branch ends on the end of its range.
                return Some([other, one]);
            }
            (a == 0.0 || a * b < 0.0).then_some([one, other])
        })
}

/// Settings for the way between two points of a branch, with the value that is asked for.
fn way(from: &[f64], to: &[f64], value: f64) -> Settings {
    let (a, b) = (
        from.first().copied().unwrap_or(value),
        to.first().copied().unwrap_or(value),
    );
    let mut settings = Settings::new(&[(a.min(b), a.max(b))]);
    settings.maximum_points = POINTS;
    settings.at.push(value);
    settings
}

/// The equilibrium between two points, where it is stable.
fn equilibrium(
    model: &Model,
    [one, other]: [&Point<Equilibrium>; 2],
    value: f64,
) -> Option<Equilibrium> {
    let (from, to) = (&one.solution, &other.solution);
    if from.parameters.first() == Some(&value) {
        return (one.unstable == 0).then(|| from.clone());
    }
    let settings = way(&from.parameters, &to.parameters, value);
    let found = equilibria(&model.field(), &from.state, &from.parameters, 0, &settings).ok()?;
    let at = found.at.into_iter().next()?;
    (at.unstable == 0).then_some(at.solution)
}

/// The cycle between two points, where it is stable.
fn cycle(model: &Model, [one, other]: [&Point<Orbit>; 2], value: f64) -> Option<Orbit> {
    let (from, to) = (&one.solution, &other.solution);
    if from.parameters.first() == Some(&value) {
        return (one.unstable == 0).then(|| from.clone());
    }
    let settings = way(&from.parameters, &to.parameters, value);
    let found = cycles_from_orbit(&model.field(), from, 0, &settings).ok()?;
    let at = found.at.into_iter().next()?;
    (at.unstable == 0).then_some(at.solution)
}

/// The cell of a point.
fn cell<'r>(regions: &'r RegionFindings, place: &[f64]) -> Option<&'r CellOutcome> {
    let [x, y] = place else { return None };
    let scaled = |index: usize, value: f64| {
        if regions.logarithmic.get(index).copied().unwrap_or(false) {
            value.ln()
        } else {
            value
        }
    };
    let (x, y) = (scaled(0, *x), scaled(1, *y));
    // A ray upwards passes the loops of its cell an odd number of times: boundary and holes together.
    regions.cells.iter().find(|cell| {
        let passes = cell.loops.iter().map(|ring| {
            let pairs = ring.iter().zip(ring.iter().cycle().skip(1));
            pairs
                .filter(|(a, b)| {
                    let (ax, bx) = (scaled(0, a[0]), scaled(0, b[0]));
                    let (ay, by) = (scaled(1, a[1]), scaled(1, b[1]));
                    (ax > x) != (bx > x) && ay + (x - ax) / (bx - ax) * (by - ay) > y
                })
                .count()
        });
        passes.sum::<usize>() % 2 == 1
    })
}

fn in_cell(cell: &CellOutcome) -> Vec<Stable> {
    let attractors = cell.attractors.iter().flatten();
    attractors
        .map(|one| Stable {
            shown: StableOutcome {
                on: cell.name.clone(),
                of: one.of,
                point: one.point.clone(),
            },
            solution: Solution::Named,
        })
        .collect()
}
