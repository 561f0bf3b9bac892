//! Automatic diagrams: equilibria found by multi-start and deflation, their branches, the cycles born on them.

mod mirror;
mod roots;

use rayon::prelude::*;

use crate::branch::{Branch, Equilibrium, Special};
use crate::bytes::Kept;
use crate::dense::norm;
use crate::equilibrium::{check, equilibria, equilibria_across};
use crate::kind::{Certainty, Kind};
use crate::orbit::{Orbit, cycles_across, cycles_doubled, cycles_from_hopf};
use crate::problem::Problem;
use crate::settings::{ContinuationError, Settings, Stop};
pub(crate) use mirror::Mirrors;
use roots::roots;

/// What a diagram looks for.
#[derive(Clone, Debug)]
pub struct DiagramSettings {
    /// Settings of every branch; the first range is that of the parameter.
    pub branch: Settings,
    /// Box in which equilibria are sought, one pair a state.
    pub states: Vec<(f64, f64)>,
    /// Starts of Newton in the box at each of three values of the parameter; as many again in parts of the box about its middle that
    /// are ten, a hundred and a thousand times smaller.
    pub starts: usize,
    /// How often a switch (across, to cycles, to doubled cycles) may follow another.
    pub depth: usize,
}

/// One branch of a diagram.
#[derive(Clone, Debug)]
pub struct Member<S> {
    /// Name: `E1`, `E2` … for equilibria, `C1` … for cycles.
    pub name: String,
    /// Where it starts: name of the branch and label of the special point; None for a start found by search.
    pub parent: Option<(String, String)>,
    /// The branch.
    pub branch: Branch<S>,
}

/// Branches of equilibria and cycles, each once; of mirror images one.
#[derive(Clone, Debug, Default)]
pub struct Diagram {
    /// Branches of equilibria.
    pub equilibria: Vec<Member<Equilibrium>>,
    /// Branches of cycles.
    pub cycles: Vec<Member<Orbit>>,
    /// Whether changes of sign of states leave the equations as they are, so that mirror images were left out.
    pub mirrored: bool,
    /// These changes of sign.
    pub(crate) mirrors: Mirrors,
    /// Branches of equilibria whose branch points have been looked at.
    looked: usize,
    /// Switches that failed: name of the branch, label of the point, reason.
    pub failed: Vec<(String, String, ContinuationError)>,
}

/// Where finished branches are kept, so that what was interrupted goes on with them.
pub trait Keeper: Sync {
    /// What was kept under a name.
    fn get(&self, name: &str) -> Option<Vec<u8>>;
    /// Keeps it.
    fn put(&self, name: &str, bytes: Vec<u8>);
}

impl dyn Keeper + '_ {
    /// The branch of a name: from the keeper, or followed and, unless it was interrupted, kept.
    ///
    /// # Errors
    /// Those of following it.
    pub fn branch<S: Kept>(
        &self,
        name: &str,
        follow: impl FnOnce() -> Result<Branch<S>, ContinuationError>,
    ) -> Result<Branch<S>, ContinuationError> {
        if let Some(found) = self.get(name).and_then(|bytes| Branch::from_bytes(&bytes)) {
            return Ok(found);
        }
        let found = follow()?;
        if !found.is_interrupted() {
            self.put(name, found.to_bytes());
        }
        Ok(found)
    }
}

/// Keeps nothing.
struct Forgetful;

impl Keeper for Forgetful {
    fn get(&self, _: &str) -> Option<Vec<u8>> {
        None
    }
    fn put(&self, _: &str, _: Vec<u8>) {}
}

/// The diagram of a problem in the parameter of index `free`.
///
/// Equilibria at both ends and the middle of the range are sought by damped, deflated Newton (Farrell, Birkisson and Funke,
/// SIAM J. Sci. Comput. 37, 2015) from points of an additive recurrence, so the same settings give the same diagram.
///
/// # Errors
///
/// Where lengths do not fit or the range is not finite. A start or switch that fails is listed in the diagram.
pub fn diagram(
    problem: &dyn Problem,
    parameters: &[f64],
    free: usize,
    settings: &DiagramSettings,
) -> Result<Diagram, ContinuationError> {
    diagram_kept(problem, parameters, free, settings, &Forgetful)
}

/// The same with finished branches in a keeper. What it holds already is not followed again; the diagram is the same, bit for
/// bit.
///
/// # Errors
///
/// Those of [`diagram`].
pub fn diagram_kept(
    problem: &dyn Problem,
    parameters: &[f64],
    free: usize,
    settings: &DiagramSettings,
    keeper: &dyn Keeper,
) -> Result<Diagram, ContinuationError> {
    check(problem, settings.states.len(), parameters.len(), &[free])?;
    let (low, high) = settings.branch.range(0);
    if !(low.is_finite() && high.is_finite()) {
        return Err(ContinuationError::Start(
            "a diagram needs a finite range of its parameter",
        ));
    }
    let mirrors = Mirrors::of(problem, parameters, &settings.states);
    let mut out = Diagram {
        mirrored: mirrors.any(),
        mirrors,
        ..Diagram::default()
    };
    for value in [low, 0.5 * (low + high), high] {
        let mut p = parameters.to_vec();
        p[free] = value;
        let starts: Vec<Vec<f64>> = roots(problem, &p, settings)
            .into_iter()
            .filter(|state| !out.holds(state, &p, free))
            .collect();
        // The first one alone, with what branches off it: others may well lie there. The rest in parallel, then kept in order: a start on
        // a branch of an earlier one is superfluous.
        let (first, others) =
            starts.split_at(usize::from(out.equilibria.is_empty()).min(starts.len()));
        for starts in [first, others] {
            let found: Vec<_> = starts
                .par_iter()
                .filter(|state| !out.holds(state, &p, free))
                .map(|state| {
                    let name = format!("equilibria through {state:?} at {value:?}");
                    let followed = keeper.branch(&name, || {
                        equilibria(problem, state, &p, free, &settings.branch)
                    });
                    (state, followed)
                })
                .collect();
            for (state, followed) in found {
                if out.holds(state, &p, free) {
                    continue;
                }
                match followed {
                    Ok(branch) => out.add_equilibria(None, branch),
                    Err(error) => out.failed.push((String::new(), format!("{value}"), error)),
                }
            }
            out.across(problem, free, settings, keeper);
        }
    }
    if settings.depth > 0 {
        out.cycles(problem, free, settings, keeper);
    }
    Ok(out)
}

impl Diagram {
    /// Follows what crosses branches of equilibria that were not looked at yet, to the depth that is asked for.
    fn across(
        &mut self,
        problem: &dyn Problem,
        free: usize,
        settings: &DiagramSettings,
        keeper: &dyn Keeper,
    ) {
        for depth in 0..settings.depth {
            let mut switches = Vec::new();
            for member in &self.equilibria[self.looked..] {
                for point in member.branch.of(Kind::BranchPoint) {
                    if point.certainty == Certainty::Located {
                        switches.push((member.name.clone(), point.clone(), 1.0));
                        switches.push((member.name.clone(), point.clone(), -1.0));
                    }
                }
            }
            self.looked = self.equilibria.len();
            let found: Vec<_> = switches
                .par_iter()
                .map(|(branch, point, side)| {
                    let name = format!("across {branch}:{} by {side}", point.label);
                    keeper.branch(&name, || {
                        equilibria_across(problem, point, free, *side, &settings.branch)
                    })
                })
                .collect();
            for ((name, point, _), followed) in switches.into_iter().zip(found) {
                match followed {
                    Ok(branch) => {
                        let probe = &branch.points[branch.points.len() / 2].solution;
                        if !self.holds(&probe.state, &probe.parameters, free) {
                            self.add_equilibria(Some((name, point.label)), branch);
                        }
                    }
                    Err(error) => self.failed.push((name, point.label, error)),
                }
            }
            if depth + 1 == settings.depth {
                self.looked = self.equilibria.len();
            }
        }
    }

    fn add_equilibria(&mut self, parent: Option<(String, String)>, branch: Branch<Equilibrium>) {
        let name = format!("E{}", self.equilibria.len() + 1);
        self.equilibria.push(Member {
            name,
            parent,
            branch,
        });
    }

    /// Whether an equilibrium, or its mirror image, lies on a branch already computed.
    fn holds(&self, state: &[f64], parameters: &[f64], free: usize) -> bool {
        let value = parameters[free];
        self.equilibria.iter().any(|m| {
            m.branch.points.windows(2).any(|pair| {
                let (a, b) = (&pair[0].solution, &pair[1].solution);
                let chord: Vec<f64> = b.state.iter().zip(&a.state).map(|(b, a)| b - a).collect();
                let rise = b.parameters[free] - a.parameters[free];
                self.mirrors.images(state).any(|image| {
                    let to: Vec<f64> = image.iter().zip(&a.state).map(|(x, a)| x - a).collect();
                    let up = value - a.parameters[free];
                    // Distance from the chord in the state, at the place along it where the parameter agrees, or where
                    // the state is nearest if the parameter hardly moves.
                    let length = crate::dense::dot(&chord, &chord);
                    let along = crate::dense::dot(&chord, &to);
                    let x = (along + up * rise) / (length + rise * rise).max(1e-300);
                    if !(-0.05..=1.05).contains(&x) {
                        return false;
                    }
                    let gap: Vec<f64> = to.iter().zip(&chord).map(|(t, c)| t - x * c).collect();
                    let span = (length + rise * rise).sqrt();
                    norm(&gap).hypot(up - x * rise) <= 0.1 * span + 1e-6 * (1.0 + norm(state))
                })
            })
        })
    }

    fn cycles(
        &mut self,
        problem: &dyn Problem,
        free: usize,
        settings: &DiagramSettings,
        keeper: &dyn Keeper,
    ) {
        let mut starts: Vec<(String, Special<Equilibrium>)> = Vec::new();
        for member in &self.equilibria {
            for point in &member.branch.special {
                if matches!(point.kind, Kind::Hopf | Kind::HopfHopf)
                    && point.certainty == Certainty::Located
                    && !starts
                        .iter()
                        .any(|(_, known)| self.mirrors.images_of_each_other(known, point))
                {
                    starts.push((member.name.clone(), point.clone()));
                }
            }
        }
        // All in parallel, then kept in order: a branch that ends at a later start makes that one superfluous.
        let found: Vec<_> = starts
            .par_iter()
            .map(|(branch, point)| {
                keeper.branch(&format!("cycles from {branch}:{}", point.label), || {
                    cycles_from_hopf(problem, point, free, &settings.branch)
                })
            })
            .collect();
        let mut level = Vec::new();
        for ((name, point), result) in starts.iter().zip(found) {
            let met = self
                .cycles
                .iter()
                .any(|c| ends_at(&c.branch, &point.solution, free, &self.mirrors));
            match result {
                _ if met => {}
                Ok(branch) => {
                    level.push(self.cycles.len());
                    self.add_cycles(Some((name.clone(), point.label.clone())), branch);
                }
                Err(error) => self.failed.push((name.clone(), point.label.clone(), error)),
            }
        }
        for _ in 1..settings.depth {
            let mut switches = Vec::new();
            for index in std::mem::take(&mut level) {
                let member = &self.cycles[index];
                for point in &member.branch.special {
                    if point.certainty == Certainty::Located
                        && matches!(point.kind, Kind::PeriodDoubling | Kind::CycleBranchPoint)
                    {
                        switches.push((member.name.clone(), point.clone()));
                    }
                }
            }
            let found: Vec<_> = switches
                .par_iter()
                .map(|(branch, point)| {
                    keeper.branch(&format!("cycles from {branch}:{}", point.label), || {
                        if point.kind == Kind::PeriodDoubling {
                            cycles_doubled(problem, point, free, &settings.branch)
                        } else {
                            cycles_across(problem, point, free, 1.0, &settings.branch)
                        }
                    })
                })
                .collect();
            for ((name, point), result) in switches.iter().zip(found) {
                match result {
                    Ok(branch) if self.repeats(&branch, free) => {}
                    Ok(branch) => {
                        level.push(self.cycles.len());
                        self.add_cycles(Some((name.clone(), point.label.clone())), branch);
                    }
                    Err(error) => self.failed.push((name.clone(), point.label.clone(), error)),
                }
            }
        }
    }

    fn add_cycles(&mut self, parent: Option<(String, String)>, branch: Branch<Orbit>) {
        let name = format!("C{}", self.cycles.len() + 1);
        self.cycles.push(Member {
            name,
            parent,
            branch,
        });
    }

    /// Whether a branch of cycles passes the special points of one already kept.
    fn repeats(&self, branch: &Branch<Orbit>, free: usize) -> bool {
        let Some(first) = branch.special.first() else {
            return false;
        };
        self.cycles.iter().flat_map(|c| &c.branch.special).any(|s| {
            s.kind == first.kind
                && (s.solution.period / first.solution.period - 1.0).abs() < 1e-6
                && (s.solution.parameters[free] - first.solution.parameters[free]).abs()
                    < 1e-6 * (1.0 + first.solution.parameters[free].abs())
        })
    }
}

/// Whether a branch of cycles shrinks to an equilibrium (or its mirror image).
fn ends_at(branch: &Branch<Orbit>, at: &Equilibrium, free: usize, mirrors: &Mirrors) -> bool {
    if branch.stop[1] != Stop::Vanished {
        return false;
    }
    let Some(last) = branch.points.last() else {
        return false;
    };
    let orbit = &last.solution;
    let n = orbit.dimension;
    let ranges: Vec<(f64, f64)> = (0..n).map(|i| orbit.range(i)).collect();
    let size = ranges
        .iter()
        .map(|(low, high)| high - low)
        .fold(0.0, f64::max);
    let near = mirrors.images(&at.state).any(|state| {
        let pairs = ranges.iter().zip(&state);
        { pairs }.all(|((low, high), x)| (0.5 * (low + high) - x).abs() <= size)
    });
    let before = &branch.points[branch.points.len().saturating_sub(2)].solution;
    let moved = (before.parameters[free] - orbit.parameters[free]).abs();
    near && (orbit.parameters[free] - at.parameters[free]).abs() <= 10.0 * moved + 1e-6
}
