//! Branches as they are handed out.

use std::collections::HashMap;

use num_complex::Complex64;

use crate::kind::{Certainty, Kind};
use crate::path::{Manifold, Node, Trace};
use crate::settings::Stop;

/// An equilibrium: f(x, p) = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Equilibrium {
    /// x.
    pub state: Vec<f64>,
    /// All parameters.
    pub parameters: Vec<f64>,
}

/// A point of a branch.
#[derive(Clone, Debug)]
pub struct Point<S> {
    /// The solution.
    pub solution: S,
    /// Eigenvalues of `f_x`, 1/s, or Floquet multipliers without the trivial one.
    pub spectrum: Vec<Complex64>,
    /// How many of them are unstable.
    pub unstable: usize,
    /// Error bar of the multipliers: that of the trivial one, or of det M = exp ∫ tr `f_x` on forced orbits; zero for eigenvalues.
    pub spectrum_error: f64,
}

/// A special point.
#[derive(Clone, Debug)]
pub struct Special<S> {
    /// `H1`, `LP2` …: the code of the kind and its number along the branch.
    pub label: String,
    /// What it is.
    pub kind: Kind,
    /// Whether it was located.
    pub certainty: Certainty,
    /// The solution there.
    pub solution: S,
    /// Tangent of the branch, in the unknowns of the solution.
    pub tangent: Vec<f64>,
    /// Angular frequency of the critical pair, rad/s, or its angle per period at a torus point, rad.
    pub omega: Option<f64>,
    /// That of a second pair.
    pub second_omega: Option<f64>,
    /// Coefficients of the normal form, as the kind's documentation states; empty where second or third derivatives are
    /// not available.
    pub normal_form: Vec<f64>,
    /// Unstable eigenvalues or multipliers before and after, along the branch.
    pub unstable: [usize; 2],
    /// Eigenvalues or multipliers at the point.
    pub spectrum: Vec<Complex64>,
    /// Uncertainty of the position, in scaled arclength.
    pub error: f64,
    /// It lies between points `after` and `after + 1` of the branch.
    pub after: usize,
}

/// A branch or curve.
#[derive(Clone, Debug)]
pub struct Branch<S> {
    /// Points from the backward end to the forward end.
    pub points: Vec<Point<S>>,
    /// Special points in the same order.
    pub special: Vec<Special<S>>,
    /// Solutions at the requested values of the first free parameter.
    pub at: Vec<Point<S>>,
    /// Why the backward and the forward direction ended.
    pub stop: [Stop; 2],
    /// Whether derivatives were finite differences.
    pub approximate: bool,
}

impl<S> Branch<S> {
    /// The special points of a kind, in order.
    pub fn of(&self, kind: Kind) -> Vec<&Special<S>> {
        self.special.iter().filter(|s| s.kind == kind).collect()
    }

    /// The special point of a label.
    pub fn labelled(&self, label: &str) -> Option<&Special<S>> {
        self.special.iter().find(|s| s.label == label)
    }
}

/// Joins both directions and numbers the special points.
pub(crate) fn assemble<M: Manifold, S>(
    m: &M,
    forward: Trace,
    backward: Trace,
    approximate: bool,
    convert: impl Fn(&Node) -> S,
) -> Branch<S> {
    let point = |node: &Node| Point {
        solution: convert(node),
        spectrum: node.spectrum.values.clone(),
        unstable: node.unstable(m),
        spectrum_error: node.spectrum.error,
    };
    let special = |l: &crate::path::Located, after: usize, reversed: bool| Special {
        label: String::new(),
        kind: l.label.kind,
        certainty: l.certainty,
        solution: convert(&l.node),
        tangent: l
            .node
            .tangent
            .iter()
            .map(|t| if reversed { -t } else { *t })
            .collect(),
        omega: l.label.omega,
        second_omega: l.label.second_omega,
        normal_form: l.label.normal_form.clone(),
        unstable: if reversed {
            [l.after, l.before]
        } else {
            [l.before, l.after]
        },
        spectrum: l.node.spectrum.values.clone(),
        error: l.error,
        after,
    };
    let offset = backward.nodes.len() - 1;
    let mut points: Vec<Point<S>> = backward.nodes.iter().rev().map(point).collect();
    points.extend(forward.nodes.iter().skip(1).map(point));
    let mut out: Vec<Special<S>> = backward
        .located
        .iter()
        .rev()
        .map(|l| special(l, offset.saturating_sub(l.index + 1), true))
        .collect();
    out.extend(
        forward
            .located
            .iter()
            .map(|l| special(l, offset + l.index, false)),
    );
    let mut numbers: HashMap<&'static str, usize> = HashMap::new();
    for s in &mut out {
        let number = numbers.entry(s.kind.code()).or_insert(0);
        *number += 1;
        s.label = format!("{}{}", s.kind.code(), number);
    }
    let mut at: Vec<Point<S>> = backward.at.iter().rev().map(|(_, n)| point(n)).collect();
    at.extend(forward.at.iter().map(|(_, n)| point(n)));
    Branch {
        points,
        special: out,
        at,
        stop: [backward.stop, forward.stop],
        approximate,
    }
}
