//! From points to curves, each followed once, and from their points of codimension two to further ones.

use rayon::prelude::*;

use super::arrangement::{self, Face};
use super::rescaled::Rescaled;
use super::rest::Rest;
use super::{Attractor, CurveSolutions, Region, RegionCell, RegionCurve, RegionSettings};
use crate::band::{ParameterSpan, crossings};
use crate::branch::{Branch, Equilibrium, Special};
use crate::curve::{
    CriticalEquilibrium, CriticalOrbit, cycle_curve, fold_curve, fold_from_generalised_hopf,
    hopf_curve, torus_from_hopf_hopf,
};
use crate::equilibrium::equilibria;
use crate::kind::{Certainty, Kind};
use crate::orbit::Orbit;
use crate::settings::{ContinuationError, Settings, Stop};

/// Lines along each parameter of the first look.
const LINES: usize = 5;
/// A point lies on a curve when it is nearer to a chord than this part of the chord's length and this, in the unit square …
const SAG: f64 = 0.02;
const NEAR: f64 = 1e-5;
/// … and frequencies, or periods, differ by less than this.
const ALIKE: f64 = 0.02;
/// Points of codimension two are the same when they are as near as this.
const ONE_POINT: f64 = 1e-5;
/// A curve that shrinks to an equilibrium ends in a point of codimension two within this distance.
const ENDS_WITHIN: f64 = 0.03;

/// A point of codimension two.
struct Corner {
    label: String,
    kind: Kind,
    at: [f64; 2],
    omegas: [f64; 2],
}

/// The curves found so far.
pub(super) struct Atlas<'p> {
    square: &'p Rescaled<'p>,
    pub(super) rest: Rest<'p>,
    settings: Settings,
    pub(super) curves: Vec<RegionCurve>,
    corners: Vec<Corner>,
    out: Region,
    pub(super) mirrored: bool,
}

impl<'p> Atlas<'p> {
    pub(super) fn new(square: &'p Rescaled<'p>, rest: Rest<'p>, settings: Settings) -> Self {
        Self {
            square,
            rest,
            settings,
            curves: Vec::new(),
            corners: Vec::new(),
            out: Region {
                curves: Vec::new(),
                cells: Vec::new(),
                scan: [0; 3],
                unresolved: Vec::new(),
                ends: false,
                lines: 0,
                diagrams: 0,
                ways: 0,
                branch_points: Vec::new(),
                mirrored: false,
                failed: Vec::new(),
            },
            mirrored: false,
        }
    }

    /// Branches of the equilibrium along lines of both parameters: all sheets of it that hang together.
    pub(super) fn lines(&mut self, settings: &RegionSettings) {
        let mut starts = Vec::new();
        for free in 0..2 {
            for k in 0..LINES {
                let mut at = [0.5, 0.5];
                at[1 - free] = k as f64 / (LINES - 1) as f64;
                if let Some(state) = self.rest.equilibrium(at) {
                    starts.push((free, at, state));
                }
            }
        }
        self.out.lines = starts.len();
        let along = Settings {
            ranges: vec![(0.0, 1.0)],
            ..settings.branch.clone()
        };
        let found: Vec<_> = starts
            .par_iter()
            .map(|(free, at, state)| equilibria(self.square, state, at, *free, &along))
            .collect();
        for (found, (_, at, _)) in found.into_iter().zip(&starts) {
            let branch = match found {
                Ok(branch) => branch,
                Err(error) => {
                    let place = self.square.parameters(at);
                    self.out
                        .failed
                        .push((format!("equilibria at {place:?}"), error));
                    continue;
                }
            };
            for special in branch.special {
                if special.certainty != Certainty::Located {
                    continue;
                }
                let omegas = [special.omega, special.second_omega];
                match special.kind {
                    Kind::Hopf | Kind::HopfHopf => {
                        for omega in omegas.into_iter().flatten() {
                            self.follow(&special.solution, omega);
                        }
                    }
                    Kind::Fold => self.follow(&special.solution, 0.0),
                    Kind::BranchPoint => {
                        let place = self.square.parameters(&special.solution.parameters);
                        self.out.branch_points.push([place[0], place[1]]);
                    }
                    _ => {}
                }
            }
        }
    }

    /// All of the rectangle, for what lies between the lines: islands.
    pub(super) fn scan(&mut self, settings: &RegionSettings) {
        let unit = ParameterSpan {
            from: 0.0,
            to: 1.0,
            logarithmic: false,
        };
        for sign in [1.0, -1.0] {
            self.rest.sign = sign;
            let found = crossings(&mut self.rest, unit, unit, &settings.scan);
            self.rest.sign = 1.0;
            self.out.scan[0] += found.columns;
            self.out.scan[1] += found.samples;
            self.out.scan[2] += found.islands;
            self.out.ends |= found.ends;
            let ambiguous = found.unresolved.iter();
            let second = |part: f64| self.square.parameters(&[0.5, part])[1];
            let ambiguous: Vec<_> = ambiguous.map(|(a, b)| (second(*a), second(*b))).collect();
            self.out.unresolved.extend(ambiguous);
            for crossing in found.found {
                let at = [crossing.q, crossing.p];
                let Some(state) = self.rest.equilibrium(at) else {
                    continue;
                };
                let start = Equilibrium {
                    state,
                    parameters: at.to_vec(),
                };
                self.follow(&start, crossing.omega);
            }
        }
    }

    /// The curve through a Hopf point (ω > 0) or fold, unless it is known.
    fn follow(&mut self, start: &Equilibrium, omega: f64) {
        let at = [start.parameters[0], start.parameters[1]];
        let kind = if omega > 0.0 { Kind::Hopf } else { Kind::Fold };
        if self.is_known(kind, at, omega) {
            return;
        }
        let found = if omega > 0.0 {
            let special = Special {
                label: String::new(),
                kind: Kind::Hopf,
                certainty: Certainty::Located,
                solution: start.clone(),
                tangent: Vec::new(),
                omega: Some(omega),
                second_omega: None,
                normal_form: Vec::new(),
                unstable: [0, 0],
                spectrum: Vec::new(),
                error: 0.0,
                after: 0,
            };
            hopf_curve(self.square, &special, [0, 1], &self.settings)
        } else {
            fold_curve(self.square, start, [0, 1], &self.settings)
        };
        match found {
            Ok(branch) => {
                let solutions = CurveSolutions::Equilibria(branch);
                if !self.repeats(kind, &solutions) {
                    self.add(kind, None, solutions);
                }
            }
            Err(error) => {
                let place = self.square.parameters(&at);
                if omega > 0.0 {
                    self.out
                        .failed
                        .push((format!("Hopf curve at {place:?}"), error));
                } else {
                    // A real eigenvalue passes zero while the equilibrium goes on: no fold.
                    self.out.branch_points.push([place[0], place[1]]);
                }
            }
        }
    }

    /// What could not be followed, each once.
    pub(super) fn failed(&mut self, all: Vec<(String, ContinuationError)>) {
        for one in all {
            if !self.out.failed.contains(&one) {
                self.out.failed.push(one);
            }
        }
    }

    fn add(&mut self, kind: Kind, parent: Option<String>, mut solutions: CurveSolutions) {
        match &mut solutions {
            CurveSolutions::Equilibria(branch) => self.label(branch, |solution| {
                let at = &solution.equilibrium.parameters;
                [at[0], at[1]]
            }),
            CurveSolutions::Cycles(branch) => self.label(branch, |solution| {
                let at = &solution.orbit.parameters;
                [at[0], at[1]]
            }),
        }
        self.curves.push(RegionCurve {
            name: format!("K{}", self.curves.len() + 1),
            kind,
            parent,
            solutions,
        });
    }

    /// Numbers points of codimension two over the whole region: one that lies on two curves has one label.
    fn label<S>(&mut self, branch: &mut Branch<S>, place: impl Fn(&S) -> [f64; 2]) {
        for special in &mut branch.special {
            let at = place(&special.solution);
            let omegas = [
                special.omega.unwrap_or(0.0),
                special.second_omega.unwrap_or(0.0),
            ];
            let known = self.corners.iter().find(|corner| {
                let apart = (corner.at[0] - at[0]).hypot(corner.at[1] - at[1]);
                corner.kind == special.kind && apart <= ONE_POINT && {
                    let pair = |one: &[f64; 2]| one[0].max(one[1]);
                    let (a, b) = (pair(&corner.omegas), pair(&omegas));
                    (a - b).abs() <= ALIKE * a.max(b) || special.kind != Kind::HopfHopf
                }
            });
            special.label = if let Some(corner) = known {
                corner.label.clone()
            } else {
                let same = self.corners.iter().filter(|c| c.kind == special.kind);
                let label = format!("{}{}", special.kind.code(), same.count() + 1);
                self.corners.push(Corner {
                    label: label.clone(),
                    kind: special.kind,
                    at,
                    omegas,
                });
                label
            };
        }
    }

    /// Torus curves from Hopf-Hopf points, folds of cycles from generalised Hopf points.
    pub(super) fn codimension_two(&mut self) {
        let mut starts: Vec<(String, Kind, CriticalEquilibrium, f64, f64)> = Vec::new();
        for curve in &self.curves {
            let CurveSolutions::Equilibria(branch) = &curve.solutions else {
                continue;
            };
            for special in &branch.special {
                if special.certainty != Certainty::Located
                    || starts.iter().any(|start| start.0 == special.label)
                {
                    continue;
                }
                let mut add = |kind: Kind, omega: f64, other: f64| {
                    let at = CriticalEquilibrium {
                        omega,
                        ..special.solution.clone()
                    };
                    starts.push((special.label.clone(), kind, at, omega, other));
                };
                match (special.kind, special.omega, special.second_omega) {
                    (Kind::HopfHopf, Some(first), Some(second)) => {
                        add(Kind::Torus, first, second);
                        add(Kind::Torus, second, first);
                    }
                    (Kind::GeneralisedHopf, ..) => {
                        add(Kind::CycleFold, special.solution.omega, 0.0);
                    }
                    _ => {}
                }
            }
        }
        let found: Vec<_> = starts
            .par_iter()
            .map(|(_, kind, at, omega, other)| {
                if *kind == Kind::Torus {
                    torus_from_hopf_hopf(self.square, at, *omega, *other, [0, 1], &self.settings)
                } else {
                    fold_from_generalised_hopf(self.square, at, [0, 1], &self.settings)
                }
            })
            .collect();
        for ((label, kind, ..), found) in starts.into_iter().zip(found) {
            match found {
                Ok(branch) => {
                    let solutions = CurveSolutions::Cycles(branch);
                    if !self.repeats(kind, &solutions) {
                        self.add(kind, Some(label), solutions);
                    }
                }
                Err(error) => {
                    let what = format!("{} curve from {label}", kind.code());
                    self.out.failed.push((what, error));
                }
            }
        }
    }

    /// Curves through special points of cycles that lie on none.
    pub(super) fn cycles(&mut self, seeds: Vec<Special<Orbit>>) {
        for special in seeds {
            let at = [
                special.solution.parameters[0],
                special.solution.parameters[1],
            ];
            let inside = at.iter().all(|part| (0.0..=1.0).contains(part));
            if !inside || self.is_known(special.kind, at, special.solution.period) {
                continue;
            }
            match cycle_curve(self.square, &special, [0, 1], &self.settings) {
                Ok(branch) => {
                    let solutions = CurveSolutions::Cycles(branch);
                    if !self.repeats(special.kind, &solutions) {
                        self.add(special.kind, None, solutions);
                    }
                }
                Err(error) => {
                    let place = self.square.parameters(&at);
                    let what = format!("{} curve at {place:?}", special.kind.code());
                    if !self.out.failed.iter().any(|(known, _)| *known == what) {
                        self.out.failed.push((what, error));
                    }
                }
            }
        }
    }

    /// Whether a point lies on a curve that is known; `value` is a frequency or a period.
    fn is_known(&self, kind: Kind, at: [f64; 2], value: f64) -> bool {
        self.curves
            .iter()
            .filter(|curve| curve.kind == kind)
            .any(|curve| {
                places(&curve.solutions).windows(2).any(|pair| {
                    let (a, b) = (pair[0].0, pair[1].0);
                    let chord = (b[0] - a[0]).hypot(b[1] - a[1]);
                    if arrangement::from_segment(at, a, b) > SAG * chord + NEAR {
                        return false;
                    }
                    let (low, high) = (pair[0].1.min(pair[1].1), pair[0].1.max(pair[1].1));
                    value >= low - ALIKE * value.abs() && value <= high + ALIKE * value.abs()
                })
            })
    }

    /// Whether a curve runs along one that is known, over most of its length.
    fn repeats(&self, kind: Kind, solutions: &CurveSolutions) -> bool {
        let own = places(solutions);
        if own.len() < 2 {
            return true;
        }
        let on = own
            .iter()
            .filter(|(at, value)| self.is_known(kind, *at, *value));
        2 * on.count() > own.len()
    }

    /// Every curve with the points of codimension two in which it begins and ends.
    pub(super) fn polylines(&self) -> Vec<Vec<[f64; 2]>> {
        let all = self.curves.iter().map(|curve| {
            let mut line: Vec<[f64; 2]> = places(&curve.solutions)
                .into_iter()
                .map(|(at, _)| at)
                .collect();
            let stop = match &curve.solutions {
                CurveSolutions::Equilibria(branch) => branch.stop,
                CurveSolutions::Cycles(branch) => branch.stop,
            };
            if stop.contains(&Stop::Closed)
                && let (Some(last), Some(first)) = (line.pop(), line.first().copied())
            {
                // The last point has gone past the first one.
                line.push(if line.len() > 1 { first } else { last });
            }
            if matches!(curve.solutions, CurveSolutions::Equilibria(_)) {
                return line;
            }
            if let Some(label) = &curve.parent
                && let Some(corner) = self.corners.iter().find(|corner| corner.label == *label)
            {
                line.insert(0, corner.at);
            }
            for (index, stop) in stop.iter().enumerate() {
                let end = if index == 0 {
                    line.first()
                } else {
                    line.last()
                };
                let (Stop::Vanished, Some(end)) = (stop, end.copied()) else {
                    continue;
                };
                let distance =
                    |corner: &&Corner| (corner.at[0] - end[0]).hypot(corner.at[1] - end[1]);
                let nearest = self
                    .corners
                    .iter()
                    .filter(|corner| matches!(corner.kind, Kind::HopfHopf | Kind::GeneralisedHopf))
                    .min_by(|a, b| distance(a).total_cmp(&distance(b)));
                if let Some(corner) = nearest.filter(|corner| distance(corner) <= ENDS_WITHIN) {
                    if index == 0 {
                        line.insert(0, corner.at);
                    } else {
                        line.push(corner.at);
                    }
                }
            }
            line
        });
        all.collect()
    }

    /// Everything in the parameters themselves.
    pub(super) fn finish(
        self,
        cells: Vec<(Face, Option<Vec<Attractor>>)>,
        diagrams: usize,
        ways: usize,
    ) -> Region {
        let Self {
            square,
            mut curves,
            mut out,
            mirrored,
            ..
        } = self;
        let back = |parameters: &mut Vec<f64>| *parameters = square.parameters(parameters);
        for curve in &mut curves {
            match &mut curve.solutions {
                CurveSolutions::Equilibria(branch) => {
                    each(branch, |solution: &mut CriticalEquilibrium| {
                        back(&mut solution.equilibrium.parameters);
                    });
                }
                CurveSolutions::Cycles(branch) => each(branch, |solution: &mut CriticalOrbit| {
                    back(&mut solution.orbit.parameters);
                }),
            }
        }
        let place = |at: &[f64; 2]| {
            let own = square.parameters(at);
            [own[0], own[1]]
        };
        out.curves = curves;
        out.cells = cells
            .into_iter()
            .map(|(face, attractors)| RegionCell {
                loops: face
                    .loops
                    .iter()
                    .map(|ring| ring.iter().map(place).collect())
                    .collect(),
                area: face.area,
                at: place(&face.inside),
                attractors: attractors.map(|mut found| {
                    for one in &mut found {
                        match one {
                            Attractor::Equilibrium(own) => back(&mut own.parameters),
                            Attractor::Cycle(own) => back(&mut own.parameters),
                        }
                    }
                    found
                }),
            })
            .collect();
        out.diagrams = diagrams;
        out.ways = ways;
        out.mirrored = mirrored;
        out
    }
}

fn each<S>(branch: &mut Branch<S>, change: impl Fn(&mut S)) {
    for point in branch.points.iter_mut().chain(&mut branch.at) {
        change(&mut point.solution);
    }
    for special in &mut branch.special {
        change(&mut special.solution);
    }
}

/// Points of a curve in the unit square, special ones among them, with frequencies or periods.
fn places(solutions: &CurveSolutions) -> Vec<([f64; 2], f64)> {
    match solutions {
        CurveSolutions::Equilibria(branch) => line(branch, |solution| {
            let at = &solution.equilibrium.parameters;
            ([at[0], at[1]], solution.omega)
        }),
        CurveSolutions::Cycles(branch) => line(branch, |solution| {
            let at = &solution.orbit.parameters;
            ([at[0], at[1]], solution.orbit.period)
        }),
    }
}

fn line<S>(branch: &Branch<S>, place: impl Fn(&S) -> ([f64; 2], f64)) -> Vec<([f64; 2], f64)> {
    let mut out = Vec::with_capacity(branch.points.len() + branch.special.len());
    for (index, point) in branch.points.iter().enumerate() {
        out.push(place(&point.solution));
        let here = branch.special.iter().filter(|one| one.after == index);
        out.extend(here.map(|one| place(&one.solution)));
    }
    out
}
