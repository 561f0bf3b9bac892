//! Regions: a rectangle of two parameters divided by what is stable in its parts.
//!
//! Nothing need be known of where curves are. (1) Points on all Hopf and fold curves of the equilibrium come from branches along
//! lines of both parameters and from a scan of the whole rectangle, whose ridges and valleys of the growth rate find islands between
//! its columns. (2) Every curve is followed over the rectangle with its points of codimension two. (3) Torus curves are followed from
//! Hopf-Hopf points, folds of cycles from generalised Hopf points. (4) The curves divide the rectangle into cells. (5) At a point of each, the
//! diagrams along both parameters tell what is stable; special points of cycles that lie on none of the curves start further ones, and
//! (4) and (5) are done again. (6) What is stable in a cell is followed along straight lines into its neighbours, and on from there: a boundary
//! is a bifurcation of one solution, and the others pass it.
//!
//! All of it happens in the unit square: parameters go from 0 to 1 on the scales of their ranges, so that a range of decades is looked at
//! evenly. What is handed out is in the parameters themselves.

mod arrangement;
mod carry;
mod cell;
mod curves;
mod mapped;
mod rescaled;
mod rest;

use rayon::prelude::*;

use crate::band::{BandSettings, ParameterSpan};
use crate::branch::{Branch, Equilibrium};
use crate::curve::{CriticalEquilibrium, CriticalOrbit};
use crate::diagram::DiagramSettings;
use crate::equilibrium::check;
use crate::kind::Kind;
use crate::orbit::Orbit;
use crate::problem::Problem;
use crate::settings::{ContinuationError, MeshSettings, Settings};

use arrangement::Face;
use cell::Looked;
use curves::Atlas;
use rescaled::Rescaled;
use rest::Rest;

/// How a rectangle is looked at.
#[derive(Clone, Debug)]
pub struct RegionSettings {
    /// Ranges of the first and the second parameter.
    pub spans: [ParameterSpan; 2],
    /// Settings of curves and branches; ranges and requested values are those of the region.
    pub branch: Settings,
    /// The scan: columns of the second parameter, rows of the first.
    pub scan: BandSettings,
    /// Half the width, state by state, of the box about the equilibrium in which others are sought.
    pub reach: Vec<f64>,
    /// Starts of Newton's method in that box.
    pub starts: usize,
    /// How often special points found in cells may start further curves.
    pub rounds: usize,
}

impl RegionSettings {
    /// The defaults for a rectangle and a number of states.
    pub fn new(spans: [ParameterSpan; 2], states: usize) -> Self {
        Self {
            spans,
            branch: Settings::new(&[(0.0, 1.0), (0.0, 1.0)]),
            scan: BandSettings {
                columns: 24,
                rows: 24,
                ..BandSettings::default()
            },
            reach: vec![1.0; states],
            starts: 12,
            rounds: 2,
        }
    }
}

/// Solutions along a curve.
#[derive(Clone, Debug)]
pub enum CurveSolutions {
    /// Hopf points or folds of equilibria.
    Equilibria(Branch<CriticalEquilibrium>),
    /// Folds, period doublings or torus points of cycles.
    Cycles(Branch<CriticalOrbit>),
}

/// A curve of special points.
#[derive(Clone, Debug)]
pub struct RegionCurve {
    /// `K1`, `K2` …
    pub name: String,
    /// Of which points.
    pub kind: Kind,
    /// The point of codimension two at which it starts.
    pub parent: Option<String>,
    /// Its points; labels of those of codimension two are those of the region.
    pub solutions: CurveSolutions,
}

/// What attracts.
#[derive(Clone, Debug)]
pub enum Attractor {
    /// A stable equilibrium.
    Equilibrium(Equilibrium),
    /// A stable cycle.
    Cycle(Orbit),
}

/// A cell: a part of the rectangle that no curve divides.
#[derive(Clone, Debug)]
pub struct RegionCell {
    /// Loops of its boundary, the outer one first, then those of holes; parameters.
    pub loops: Vec<Vec<[f64; 2]>>,
    /// Its part of the rectangle, on the scales of the ranges.
    pub area: f64,
    /// Where it was looked at.
    pub at: [f64; 2],
    /// What was found stable there; None where the cell is too narrow to be looked at.
    pub attractors: Option<Vec<Attractor>>,
}

/// A rectangle of two parameters.
#[derive(Clone, Debug)]
pub struct Region {
    /// The curves.
    pub curves: Vec<RegionCurve>,
    /// The cells, from the largest to the smallest.
    pub cells: Vec<RegionCell>,
    /// Columns of the scan, points at which it computed eigenvalues, islands that it found between columns.
    pub scan: [usize; 3],
    /// Intervals of the second parameter in which the scan remained ambiguous.
    pub unresolved: Vec<(f64, f64)>,
    /// Whether the equilibrium ends somewhere in the rectangle.
    pub ends: bool,
    /// Lines of a first look along both parameters.
    pub lines: usize,
    /// Diagrams that were followed through cells.
    pub diagrams: usize,
    /// Ways from cell to cell along which stable solutions were followed.
    pub ways: usize,
    /// Points at which a real eigenvalue passes zero without a fold: branch points, whose curves are not followed.
    pub branch_points: Vec<[f64; 2]>,
    /// Whether changes of sign of states leave the equations as they are, so that of mirror images one was counted.
    pub mirrored: bool,
    /// What could not be followed: what it was, and why.
    pub failed: Vec<(String, ContinuationError)>,
}

/// A cell whose furthest point is nearer than this to its boundary is not looked at, in the unit square.
const NARROW: f64 = 1.5e-3;
/// Tolerance and most intervals of the meshes of cycles in diagrams through cells.
const LOOK: f64 = 1e-6;
const INTERVALS: usize = 100;
/// The step, the angle between tangents at which curves are drawn.
const STEP: f64 = 0.02;
const ANGLE: f64 = 0.1;

/// Divides a rectangle of the two parameters of a problem by what is stable in its parts, beginning with an equilibrium at parameters in it.
///
/// # Errors
///
/// Where lengths do not fit or ranges are empty. What cannot be followed is listed in the region.
pub fn region(
    problem: &dyn Problem,
    start: &Equilibrium,
    settings: &RegionSettings,
) -> Result<Region, ContinuationError> {
    check(problem, start.state.len(), start.parameters.len(), &[0, 1])?;
    if problem.parameters() != 2 {
        return Err(ContinuationError::Shape {
            what: "parameters of a region",
            expected: 2,
            found: problem.parameters(),
        });
    }
    if settings.reach.len() != problem.states() {
        return Err(ContinuationError::Shape {
            what: "states",
            expected: problem.states(),
            found: settings.reach.len(),
        });
    }
    let rising = |span: &ParameterSpan| span.from.is_finite() && span.to > span.from;
    if !settings.spans.iter().all(rising) {
        return Err(ContinuationError::Start(
            "a region needs finite ranges that rise",
        ));
    }
    let square = Rescaled::new(problem, settings.spans);
    let parts = square.parts(&start.parameters);
    let at = [parts[0].clamp(0.0, 1.0), parts[1].clamp(0.0, 1.0)];
    let rest = Rest::new(&square, at, &start.state);
    let curve = Settings {
        ranges: vec![(0.0, 1.0), (0.0, 1.0)],
        at: Vec::new(),
        maximum_step: STEP.min(settings.branch.maximum_step),
        angle: ANGLE.min(settings.branch.angle),
        ..settings.branch.clone()
    };
    let mut atlas = Atlas::new(&square, rest, curve);
    atlas.lines(settings);
    atlas.scan(settings);
    atlas.codimension_two();
    let mesh = settings.branch.mesh;
    let look = DiagramSettings {
        branch: Settings {
            // Only the sign of a multiplier's distance is asked for.
            mesh: MeshSettings {
                tolerance: mesh.tolerance.max(LOOK),
                bounds: (mesh.bounds.0, mesh.bounds.1.min(INTERVALS)),
                ..mesh
            },
            ..settings.branch.clone()
        },
        states: settings.reach.iter().map(|half| (-half, *half)).collect(),
        starts: settings.starts,
        depth: 2,
    };
    let mut diagrams = 0;
    let mut cells = Vec::new();
    // What was seen in a point stays so when further curves cut its cell.
    let mut seen: Vec<([f64; 2], Looked)> = Vec::new();
    for round in 0..=settings.rounds {
        let mut faces = arrangement::faces(&atlas.polylines());
        let again: Vec<Option<usize>> = faces
            .iter_mut()
            .map(|face| {
                let place = seen.iter().position(|(at, _)| {
                    arrangement::contains(&face.loops, *at)
                        && arrangement::distance(&face.loops, *at, 0.0) >= NARROW
                })?;
                face.inside = seen[place].0;
                Some(place)
            })
            .collect();
        // One after the other, so that what is followed from does not depend on the order of threads.
        let rests: Vec<Option<Vec<f64>>> = faces
            .iter()
            .map(|face| atlas.rest.equilibrium(face.inside))
            .collect();
        let looked: Vec<_> = faces
            .par_iter()
            .zip(&rests)
            .zip(&again)
            .map(|((face, rest), again)| {
                (again.is_none() && face.clear >= NARROW)
                    .then(|| cell::look(&square, face.inside, rest.as_deref(), &look))
            })
            .collect();
        diagrams += 2 * looked.iter().flatten().count();
        cells.clear();
        let mut seeds = Vec::new();
        for ((face, looked), again) in faces.into_iter().zip(looked).zip(again) {
            let place = again.or_else(|| {
                let mut looked = looked?;
                seeds.append(&mut looked.seeds);
                atlas.mirrored |= looked.mirrors.any();
                let place = square.parameters(&face.inside);
                let told = looked.failed.drain(..).map(|(what, error)| {
                    let what = format!("{what} of the diagrams through {place:?}");
                    (what, error)
                });
                atlas.failed(told.collect());
                seen.push((face.inside, looked));
                Some(seen.len() - 1)
            });
            cells.push((face, place));
        }
        let known = atlas.curves.len();
        if round < settings.rounds {
            atlas.cycles(seeds);
        }
        if atlas.curves.len() == known {
            break;
        }
    }
    let looked: Vec<(&Face, usize)> = cells
        .iter()
        .filter_map(|(face, place)| Some((face, (*place)?)))
        .collect();
    let ways = carry::carry(&square, &looked, &mut seen, &look.branch);
    let cells = cells
        .into_iter()
        .map(|(face, place)| {
            let attractors = place.and_then(|place| seen.get(place));
            (
                face,
                attractors.map(|(_, looked)| looked.attractors.clone()),
            )
        })
        .collect();
    Ok(atlas.finish(cells, diagrams, ways))
}
