//! What is stable in one cell, carried along straight lines into its neighbours.
//!
//! A diagram through a cell follows branches along lines of one parameter within the rectangle, and misses what is joined to them only beyond
//! it: a large stable cycle beside a stable equilibrium, whose fold lies outside. In the cell next to it, where the equilibrium is
//! unstable, the same cycle is found at once. A boundary divides cells by a bifurcation of one solution; the others pass it.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::arrangement::Face;
use super::cell::Looked;
use super::mapped::{Map, Mapped};
use super::{Attractor, Rescaled};
use crate::branch::{Branch, Equilibrium};
use crate::equilibrium::equilibria;
use crate::orbit::{Orbit, cycles_from_orbit};
use crate::settings::Settings;

/// Most points on the way from one cell to the next.
const POINTS: usize = 60;

/// The straight line from one point of the unit square to another.
struct Line {
    from: [f64; 2],
    to: [f64; 2],
}

impl Map for Line {
    fn free(&self) -> usize {
        1
    }
    fn parameters(&self, u: &[f64]) -> Vec<f64> {
        let s = u.first().copied().unwrap_or(f64::NAN);
        let ends = self.from.iter().zip(&self.to);
        ends.map(|(from, to)| from + s * (to - from)).collect()
    }
    fn slope(&self, _: &[f64], j: usize, _: usize) -> f64 {
        match (self.from.get(j), self.to.get(j)) {
            (Some(from), Some(to)) => to - from,
            _ => 0.0,
        }
    }
}

/// Carries all attractors of cells into neighbouring cells, and on from there, until nothing new is found; how many ways were followed.
///
/// `seen` are cells that were looked at, with what was found in them.
pub(super) fn carry(
    square: &Rescaled<'_>,
    cells: &[(&Face, usize)],
    seen: &mut [([f64; 2], Looked)],
    settings: &Settings,
) -> usize {
    let neighbours = neighbours(cells);
    let mut ways = 0;
    // By place in `seen`: attractors up to there have been carried.
    let mut carried = vec![0; seen.len()];
    loop {
        let mut jobs: Vec<(usize, usize, Attractor)> = Vec::new();
        for (index, (_, from)) in cells.iter().enumerate() {
            let Some(looked) = seen.get(*from).map(|(_, looked)| looked) else {
                continue;
            };
            let known = carried.get(*from).copied().unwrap_or(0);
            for attractor in looked.attractors.iter().skip(known) {
                for next in neighbours.get(index).into_iter().flatten() {
                    if let Some((_, to)) = cells.get(*next) {
                        jobs.push((*from, *to, attractor.clone()));
                    }
                }
            }
        }
        for (place, (_, looked)) in carried.iter_mut().zip(seen.iter()) {
            *place = looked.attractors.len();
        }
        if jobs.is_empty() {
            return ways;
        }
        ways += jobs.len();
        let arrived: Vec<Option<Attractor>> = jobs
            .par_iter()
            .map(|(from, to, attractor)| {
                let line = Line {
                    from: seen.get(*from)?.0,
                    to: seen.get(*to)?.0,
                };
                along(square, line, attractor, settings)
            })
            .collect();
        for ((_, to, _), found) in jobs.iter().zip(arrived) {
            if let (Some((_, looked)), Some(found)) = (seen.get_mut(*to), found) {
                looked.add(found);
            }
        }
    }
}

/// Cells that have a piece of boundary in common, by place in the list.
fn neighbours(cells: &[(&Face, usize)]) -> Vec<Vec<usize>> {
    let sides: Vec<BTreeSet<[u64; 4]>> = cells
        .iter()
        .map(|(face, _)| {
            let rings = face.loops.iter();
            rings
                .flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)))
                .map(|(a, b)| {
                    let bits = |at: &[f64; 2]| at.map(f64::to_bits);
                    let (a, b) = (bits(a).min(bits(b)), bits(a).max(bits(b)));
                    [a[0], a[1], b[0], b[1]]
                })
                .collect()
        })
        .collect();
    (0..cells.len())
        .map(|one| {
            (0..cells.len())
                .filter(|other| *other != one && !sides[one].is_disjoint(&sides[*other]))
                .collect()
        })
        .collect()
}

/// An attractor followed to the end of a line, where it is stable there.
fn along(
    square: &Rescaled<'_>,
    line: Line,
    attractor: &Attractor,
    settings: &Settings,
) -> Option<Attractor> {
    let to = line.to;
    let problem = Mapped::of(square, line);
    let settings = Settings {
        ranges: vec![(0.0, 1.0)],
        at: vec![1.0],
        maximum_points: POINTS,
        ..settings.clone()
    };
    match attractor {
        Attractor::Equilibrium(one) => {
            let found = equilibria(&problem, &one.state, &[0.0], 0, &settings).ok()?;
            let state = at_the_end(found)?.state;
            Some(Attractor::Equilibrium(Equilibrium {
                state,
                parameters: to.to_vec(),
            }))
        }
        Attractor::Cycle(one) => {
            let start = Orbit {
                parameters: vec![0.0],
                ..one.clone()
            };
            let found = cycles_from_orbit(&problem, &start, 0, &settings).ok()?;
            Some(Attractor::Cycle(Orbit {
                parameters: to.to_vec(),
                ..at_the_end(found)?
            }))
        }
    }
}

/// The stable solution at the value that was asked for.
fn at_the_end<S>(branch: Branch<S>) -> Option<S> {
    let mut stable = branch.at.into_iter().filter(|point| point.unstable == 0);
    stable.next().map(|point| point.solution)
}
