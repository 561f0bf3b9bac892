//! The second half of a stable band: that no stable cycle exists in it. Tested, never proven: what was done is told in words.

use quell_continuation::{
    Band, Branch, CriticalOrbit, Edge, Equilibrium, Kind, Limit, Linearisation, Orbit, Point,
    Settings, Special, cycle_curve, cycles_from_pair, first_lyapunov,
};
use quell_response::transient::{End, simulate};

use super::plan::{BandPlan, FoundBands};
use crate::built::{Built, ValueScratch};
use crate::continuation::{Field, Moving};
use crate::push::{Push, Still, push};

/// What was tested of a band.
#[derive(Debug, Clone, Default)]
pub(crate) struct Tests {
    /// In words.
    pub(super) words: Vec<String>,
    /// What ends the band where cycles do, below and above.
    cuts: [Option<String>; 2],
}

impl Tests {
    /// What ends the band on a side where cycles do.
    pub(super) fn cut(&self, side: &str) -> Option<&str> {
        self.cuts[usize::from(side == "upper")].as_deref()
    }
}

/// A largest push is such that the nonlinear part of the rates is this part of the linear one.
const PUSH: f64 = 0.3;
/// So many values of the band's parameter and of the operating parameter at which motions are let go.
const ACROSS: usize = 2;
const ALONG: usize = 3;
/// A motion is watched for so many times its linear decay, and at most so many turns.
const DECAYS: f64 = 3.0;
const TURNS: f64 = 200.0;
/// Where so little has decayed by then, it is watched for longer: until this part is left, and at most so many turns.
const LEFT: f64 = 0.6;
const MOST_TURNS: f64 = 600.0;
/// It has decayed where its last swing is less than this part of its first, or where linear decay is slower, not much more than that
/// leaves.
const DECAYED: f64 = 0.5;
const SLOWER: f64 = 1.1;
const STANDING: f64 = 0.97;
/// Relative error of special points of cycles, that of their meshes, and of extrema of their curves.
const LOCATED: f64 = 1e-8;
const EXTREMUM: f64 = 1e-6;
/// Seed of the pushes.
const SEED: u64 = 0x9e37_79b9_7f4a_7c15;

/// Tests all bands, and cuts off where stable cycles exist.
pub(super) fn test(plan: &BandPlan, built: &Built, values: &ValueScratch, found: &mut FoundBands) {
    let entries = std::iter::once(&plan.p).chain(&plan.q);
    let entries = entries.map(|free| free.entry.clone()).collect();
    let moving = Moving::new(built, values.clone(), plan.sources.clone(), entries);
    let slopes = plan.system.slopes(moving.slopes());
    let field = Field::new(&plan.system, &slopes, &moving, None);
    let widest = found.bands.widest().copied();
    let mut kept = Vec::new();
    for band in found.bands.bands.clone() {
        let mut tests = Tests::default();
        let mut own = band;
        for (index, side) in ["lower", "upper"].into_iter().enumerate() {
            let edge = if index == 0 { band.lower } else { band.upper };
            let looked = Look {
                plan,
                built,
                values,
                field: &field,
                band,
            }
            .edge(&edge, side, &mut tests);
            if let Some((p, q, words)) = looked {
                tests.cuts[index] = Some(words);
                let error = if q.is_some() { EXTREMUM } else { LOCATED };
                let cut = Edge {
                    p,
                    q,
                    error,
                    ..edge
                };
                if index == 0 {
                    own.lower = cut;
                } else {
                    own.upper = cut;
                }
            }
        }
        if own.upper.p <= own.lower.p {
            continue;
        }
        // The widest is the one that counts.
        if widest == Some(band) {
            simulations(plan, built, values, &own, &mut tests);
        }
        kept.push((own, tests));
    }
    found.bands.bands = kept.iter().map(|(band, _)| *band).collect();
    found.tests = kept.into_iter().map(|(_, tests)| tests).collect();
}

/// A look at what begins at the ends of a band.
struct Look<'a> {
    plan: &'a BandPlan,
    built: &'a Built,
    values: &'a ValueScratch,
    field: &'a Field<'a>,
    band: Band,
}

impl Look<'_> {
    /// Cycles born at an edge: where they are stable within the band, the value at which that ends, with words.
    fn edge(
        &self,
        edge: &Edge,
        side: &str,
        tests: &mut Tests,
    ) -> Option<(f64, Option<f64>, String)> {
        if !matches!(edge.limit, Limit::Hopf | Limit::HopfAtEnd) {
            return None;
        }
        let q = edge.q.unwrap_or(0.0);
        let mut rest = self.plan.at_rest(self.built, self.values);
        let state = rest.equilibrium(edge.p, q)?;
        let mut at = vec![edge.p];
        at.extend(self.plan.q.as_ref().map(|_| q));
        let omega = edge.eigenvalue.im;
        let coefficient = first_lyapunov(self.field, &state, &at, omega);
        match coefficient {
            Some(l1) if l1 < 0.0 => {
                tests.words.push(format!(
                    "the Hopf point at the {side} end is supercritical (first Lyapunov coefficient {l1:.3e}): its cycles are born stable and outside of the band"
                ));
                return None;
            }
            Some(l1) => tests.words.push(format!(
                "the Hopf point at the {side} end is subcritical (first Lyapunov coefficient {l1:.3e}): its cycles are born unstable, and into the band"
            )),
            None => tests.words.push(format!(
                "the first Lyapunov coefficient at the {side} end could not be had"
            )),
        }
        let born = Equilibrium {
            state,
            parameters: at,
        };
        let width = self.band.width();
        let range = (
            (self.band.lower.p - width).max(self.plan.p.span.from),
            (self.band.upper.p + width).min(self.plan.p.span.to),
        );
        let branch = cycles_from_pair(self.field, &born, omega, 0, &Settings::new(&[range]));
        let branch = match branch {
            Ok(branch) => branch,
            Err(error) => {
                tests.words.push(format!(
                    "its cycles could not be followed ({error}): whether stable ones reach into the band is not known"
                ));
                return None;
            }
        };
        self.stable_cycles(&branch, edge, side, tests)
    }

    /// Whether stable cycles of a branch lie within the band, and up to where.
    fn stable_cycles(
        &self,
        branch: &Branch<Orbit>,
        edge: &Edge,
        side: &str,
        tests: &mut Tests,
    ) -> Option<(f64, Option<f64>, String)> {
        let name = &self.plan.p.name;
        let inwards = if side == "upper" { -1.0 } else { 1.0 };
        let depth = |p: f64| inwards * (p - edge.p);
        let value = |orbit: &Orbit| orbit.parameters.first().copied().unwrap_or(f64::NAN);
        let ends = branch
            .special
            .iter()
            .filter(|special| special.unstable.contains(&0))
            .max_by(|a, b| depth(value(&a.solution)).total_cmp(&depth(value(&b.solution))));
        let deepest = branch
            .points
            .iter()
            .filter(|point| point.unstable == 0)
            .map(|point| value(&point.solution))
            .max_by(|a, b| depth(*a).total_cmp(&depth(*b)));
        let followed = branch
            .points
            .iter()
            .map(|point| depth(value(&point.solution)))
            .fold(0.0, f64::max);
        let reached = edge.p + inwards * followed;
        let located = ends.map(|special| (value(&special.solution), Some(special)));
        let stable = [located, deepest.map(|p| (p, None))]
            .into_iter()
            .flatten()
            .max_by(|a, b| {
                depth(a.0)
                    .total_cmp(&depth(b.0))
                    .then(a.1.is_some().cmp(&b.1.is_some()))
            })
            .filter(|(p, _)| depth(*p) > 0.0);
        let Some((p, special)) = stable else {
            tests.words.push(format!(
                "they were followed over `{name}` as far as {reached:.6} {}: none of them is stable within the band",
                self.plan.p.unit
            ));
            return None;
        };
        let what = match special.map(|special| special.kind) {
            Some(Kind::CycleFold) => "a fold of cycles",
            Some(Kind::Torus) => "a torus point of cycles",
            Some(Kind::PeriodDoubling) => "a period doubling of cycles",
            _ => "stable cycles",
        };
        let mut cut = (p, edge.q);
        if let (Some(free), Some(special)) = (&self.plan.q, special)
            && let Some(extreme) = self.extreme(special, inwards)
        {
            tests.words.push(format!(
                "the curve of such points in `{name}` and `{}` was followed to its extremum",
                free.name
            ));
            cut = extreme;
        }
        tests.words.push(format!(
            "beyond {what} stable cycles exist beside the stable equilibrium: from {name} = {:.9} to the {side} end of the linear band at {:.9}",
            cut.0, edge.p
        ));
        let words = match (&self.plan.q, cut.1) {
            (Some(free), Some(q)) => format!("{what} at {} = {q:.6} {}", free.name, free.unit)
                .trim_end()
                .to_owned(),
            _ => what.to_owned(),
        };
        Some((cut.0, cut.1.filter(|_| self.plan.q.is_some()), words))
    }

    /// The point furthest into the band of the curve of a special point in both parameters.
    ///
    /// A first walk along the curve finds it between three points. A second one passes three values of the operating parameter close to
    /// the top of the parabola through these, and the top of the parabola through what it finds there is the extremum: its error is of the
    /// third order in their distance.
    fn extreme(&self, special: &Special<Orbit>, inwards: f64) -> Option<(f64, Option<f64>)> {
        let free = self.plan.q.as_ref()?;
        let width = self.band.width();
        let own = (
            (self.band.lower.p - width).max(self.plan.p.span.from),
            (self.band.upper.p + width).min(self.plan.p.span.to),
        );
        let across = (free.span.from, free.span.to);
        let curve =
            cycle_curve(self.field, special, [0, 1], &Settings::new(&[own, across])).ok()?;
        let points: Vec<[f64; 2]> = curve.points.iter().filter_map(place).collect();
        let best = (0..points.len())
            .max_by(|a, b| (inwards * points[*a][0]).total_cmp(&(inwards * points[*b][0])))?;
        let [p, q] = *points.get(best)?;
        // At an end of the range there is no parabola: the curve goes on beyond it.
        let near = 1e-7 * (across.1 - across.0);
        let around = best
            .checked_sub(1)
            .and_then(|before| Some([*points.get(before)?, [p, q], *points.get(best + 1)?]))
            .filter(|_| (q - across.0).min(across.1 - q) > near);
        let Some(around) = around else {
            return Some((p, Some(q)));
        };
        let Some([p, q]) = top(around) else {
            return Some((p, Some(q)));
        };
        let apart = CLOSE * (around[2][1] - around[0][1]).abs();
        let mut again = Settings::new(&[across, own]);
        again.at = [q - apart, q, q + apart]
            .into_iter()
            .filter(|q| (across.0..=across.1).contains(q))
            .collect();
        let found = cycle_curve(self.field, special, [1, 0], &again).ok();
        let mut close: Vec<[f64; 2]> = found
            .iter()
            .flat_map(|curve| &curve.at)
            .filter_map(place)
            .collect();
        // The curve may pass a value twice; what is meant is near.
        close.sort_by(|a, b| (a[0] - p).abs().total_cmp(&(b[0] - p).abs()));
        close.truncate(3);
        close.sort_by(|a, b| a[1].total_cmp(&b[1]));
        let [p, q] = <[[f64; 2]; 3]>::try_from(close)
            .ok()
            .and_then(top)
            .unwrap_or([p, q]);
        Some((p, Some(q)))
    }
}

/// Distance of the three points of the second walk, relative to that of the first.
const CLOSE: f64 = 0.01;

/// The band's parameter and the operating one at a point of a curve.
fn place(point: &Point<CriticalOrbit>) -> Option<[f64; 2]> {
    match point.solution.orbit.parameters.as_slice() {
        [p, q, ..] => Some([*p, *q]),
        _ => None,
    }
}

/// The top (or bottom) of the parabola p(q) through three points, where it lies between them.
fn top([a, [p, q], b]: [[f64; 2]; 3]) -> Option<[f64; 2]> {
    let (da, db) = (a[1] - q, b[1] - q);
    let (fa, fb) = ((a[0] - p) / da, (b[0] - p) / db);
    let bend = (fa - fb) / (da - db);
    let slope = fa - bend * da;
    let shift = -slope / (2.0 * bend);
    let inside = shift.is_finite() && shift >= da.min(db) && shift <= da.max(db);
    inside.then_some([p + 0.5 * slope * shift, q + shift])
}

/// Motions let go within a band.
fn simulations(
    plan: &BandPlan,
    built: &Built,
    values: &ValueScratch,
    band: &Band,
    tests: &mut Tests,
) {
    let span = quell_continuation::ParameterSpan {
        from: band.lower.p,
        to: band.upper.p,
        logarithmic: plan.p.span.logarithmic,
    };
    let along = if plan.q.is_some() { ALONG } else { 1 };
    let mut random = SEED;
    let (mut made, mut decayed, mut open) = (0, 0, Vec::new());
    for across in 0..ACROSS {
        let p = span.value((across as f64 + 0.5) / ACROSS as f64);
        for row in 0..along {
            let q = plan.q.as_ref().map_or(0.0, |free| {
                free.span.value((row as f64 + 0.5) / along as f64)
            });
            let mut rest = plan.at_rest(built, values);
            let Some((push, duration)) = pushed(&mut rest, p, q, &mut random) else {
                continue;
            };
            made += 1;
            let settings = quell_response::transient::Settings {
                relative: 1e-5,
                divergence: 1e6,
                ..quell_response::transient::Settings::default()
            };
            let run = simulate(
                &mut rest.prepared,
                &push.state,
                (0.0, duration),
                &[],
                &settings,
            );
            let settled = run.is_ok_and(|run| {
                matches!(run.end(), End::Time) && {
                    let swing = |from: f64, to: f64| {
                        (0..200)
                            .map(|k| run.state(from + (to - from) * f64::from(k) / 199.0))
                            .map(|state| push.size(&state))
                            .fold(0.0, f64::max)
                    };
                    let end = duration;
                    let linear = SLOWER * (push.leading.re * 0.8 * end).exp();
                    let most = linear.clamp(DECAYED, STANDING);
                    swing(0.9 * end, end) < most * swing(0.0, 0.1 * end)
                }
            });
            if settled {
                decayed += 1;
            } else {
                open.push(match &plan.q {
                    Some(free) => format!("{} = {p:.6}, {} = {q:.6}", plan.p.name, free.name),
                    None => format!("{} = {p:.6}", plan.p.name),
                });
            }
        }
    }
    if made == 0 {
        tests.words.push(
            "no motions were let go: the equations are linear, or no push could be found"
                .to_owned(),
        );
        return;
    }
    tests.words.push(format!(
        "{decayed} of {made} motions let go within the band were seen to decay, pushed so far that the nonlinear part of the rates was {PUSH} of the linear one"
    ));
    if !open.is_empty() {
        tests.words.push(format!(
            "not seen to decay, or too slowly to tell: {}",
            open.join("; ")
        ));
    }
}

/// A push as far as the equations are nonlinear, and for how long the motion is watched, s.
fn pushed(
    rest: &mut super::rest::AtRest<'_>,
    p: f64,
    q: f64,
    random: &mut u64,
) -> Option<(Push, f64)> {
    let n = rest.states();
    let mut matrix = vec![0.0; n * n];
    if !rest.matrix(p, q, &mut matrix) {
        return None;
    }
    let state = rest.equilibrium(p, q)?;
    rest.set(p, q);
    let still = Still {
        state: &state,
        matrix: &matrix,
        creeping: false,
    };
    let found = push(&still, PUSH, random, |state, rates| {
        rest.prepared.rates(0.0, state, rates);
    })?;
    let turn = std::f64::consts::TAU / found.leading.im;
    let short = (DECAYS / found.leading.re.abs()).min(TURNS * turn);
    let long = (LEFT.ln() / found.leading.re).min(MOST_TURNS * turn);
    Some((found, short.max(long)))
}
