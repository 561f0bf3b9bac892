//! The loop over points: predictor, corrector, length of step, ends.

use super::correct::Corrector;
use super::predict::Predictor;
use super::{Failure, Located, Manifold, Node, inner};
use crate::kind::Kind;
use crate::settings::{ContinuationError, Directions, Settings, Stop};

/// What one direction gave.
#[derive(Clone, Debug)]
pub(crate) struct Trace {
    pub(crate) nodes: Vec<Node>,
    pub(crate) located: Vec<Located>,
    /// Solutions at requested values of the parameter: (index of the point before, node).
    pub(crate) at: Vec<(usize, Node)>,
    pub(crate) stop: Stop,
}

impl From<Failure> for ContinuationError {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::NoConvergence(correction) => Self::NoConvergence { correction },
            Failure::NotFinite => Self::NotFinite,
            Failure::Singular => Self::Singular,
        }
    }
}

impl From<Failure> for Stop {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::NoConvergence(_) => Self::NoConvergence,
            Failure::NotFinite => Self::NotFinite,
            Failure::Singular => Self::Singular,
        }
    }
}

/// How to start: z, and either a covector that fixes the first point or a tangent that is already known.
#[derive(Clone, Debug)]
pub(crate) enum Start {
    /// Correct z at a fixed value of the first free parameter, or of the second where the curve runs along the first.
    AtParameter(Vec<f64>),
    /// Step off a special point along a direction: (solution, direction, distance in scaled arclength).
    Along(Vec<f64>, Vec<f64>, f64),
}

/// Both directions from a start: (forward, backward).
pub(crate) fn follow_both<M: Manifold>(
    m: &mut M,
    settings: &Settings,
    start: Start,
) -> Result<(Trace, Trace), ContinuationError> {
    let mut corrector = Corrector::new(settings);
    let empty = |node: &Node, stop| Trace {
        nodes: vec![node.clone()],
        located: Vec::new(),
        at: Vec::new(),
        stop,
    };
    let (node, along) = match start {
        Start::AtParameter(guess) => {
            let mut first = None;
            let mut found = None;
            for fixed in m.parameters() {
                let mut z = guess.clone();
                m.rescale(&z);
                m.accept(&z);
                let mut row = vec![0.0; m.len()];
                row[fixed] = m.weights()[fixed].sqrt();
                let target = row[fixed] * z[fixed];
                match corrector.correct(m, &mut z, &row, target, false) {
                    Ok(_) => {
                        z[fixed] = guess[fixed];
                        found = Some((z, row));
                        break;
                    }
                    // The first reason is the one to tell.
                    Err(failure) => first = first.or(Some(failure)),
                }
            }
            let Some((z, row)) = found else {
                return Err(first.unwrap_or(Failure::Singular).into());
            };
            m.rescale(&z);
            m.accept(&z);
            (corrector.node(m, z, &row)?, false)
        }
        Start::Along(mut z, mut direction, distance) => {
            m.rescale(&z);
            let size = inner(m.weights(), &direction, &direction).sqrt();
            if !(size > 0.0 && size.is_finite()) {
                return Err(ContinuationError::Start(
                    "the direction of the start vanishes",
                ));
            }
            for d in &mut direction {
                *d /= size;
            }
            let row: Vec<f64> = direction
                .iter()
                .zip(m.weights())
                .map(|(d, w)| d * w)
                .collect();
            let origin: f64 = row.iter().zip(&z).map(|(r, z)| r * z).sum();
            let base = z.clone();
            let mut length = distance;
            loop {
                for ((z, b), d) in z.iter_mut().zip(&base).zip(&direction) {
                    *z = b + length * d;
                }
                m.accept(&z);
                match corrector.correct(m, &mut z, &row, origin + length, false) {
                    Ok(_) => break,
                    Err(failure) if length < 1e-3 * distance => return Err(failure.into()),
                    Err(_) => length *= 0.4,
                }
            }
            m.rescale(&z);
            m.accept(&z);
            (corrector.node(m, z, &row)?, true)
        }
    };
    let value = node.z[m.parameters()[0]];
    let wanted = settings.at.contains(&value).then(|| (0, node.clone()));
    let mut forward = if settings.directions == Directions::Backward && !along {
        empty(&node, Stop::NotAsked)
    } else {
        follow(m, settings, node.clone())
    };
    // The start itself is met by neither direction.
    if let Some(start) = wanted {
        forward.at.insert(0, start);
    }
    let backward = if forward.stop == Stop::Closed {
        // The other way round would be the same again.
        empty(&node, Stop::Closed)
    } else if settings.directions == Directions::Forward || along {
        empty(&node, Stop::NotAsked)
    } else {
        let mut back = node;
        for t in &mut back.tangent {
            *t = -*t;
        }
        for r in &mut back.spectrum.rates {
            *r = -*r;
        }
        m.restart(&back);
        let z = back.z.clone();
        let row: Vec<f64> = back
            .tangent
            .iter()
            .zip(m.weights())
            .map(|(t, w)| t * w)
            .collect();
        let again = corrector.node(m, z, &row)?;
        follow(m, settings, again)
    };
    Ok((forward, backward))
}

/// Follows from a node in the direction of its tangent. The factorisation is that of the node.
pub(crate) fn follow<M: Manifold>(m: &mut M, settings: &Settings, start: Node) -> Trace {
    let mut corrector = Corrector::new(settings);
    let mut trace = Trace {
        nodes: vec![start.clone()],
        located: Vec::new(),
        at: Vec::new(),
        stop: Stop::Points,
    };
    let first = start.clone();
    let mut a = start;
    let mut predictor = Predictor::default();
    let mut step = settings.initial_step;
    let mut current = true;
    while trace.nodes.len() < settings.maximum_points {
        if settings
            .interrupt
            .as_ref()
            .is_some_and(crate::settings::Interrupt::is_raised)
        {
            trace.stop = Stop::Interrupted;
            return trace;
        }
        let parameters = m.parameters();
        let row: Vec<f64> = a
            .tangent
            .iter()
            .zip(m.weights())
            .map(|(t, w)| t * w)
            .collect();
        let origin: f64 = row.iter().zip(&a.z).map(|(r, z)| r * z).sum();
        let mut z = predictor.predict(&a, &row, step);
        let target = origin + step;
        let attempt = match corrector.step(m, &mut z, &row, target, current) {
            Ok(quality) => corrector.node(m, z, &row).map(|n| (quality, n)),
            Err(failure) => Err(failure),
        };
        current = true;
        let (quality, mut b) = match attempt {
            Ok(x) => x,
            Err(failure) => {
                current = false;
                step *= 0.4;
                if step < settings.minimum_step {
                    trace.stop = failure.into();
                    return trace;
                }
                continue;
            }
        };
        let cosine = inner(m.weights(), &a.tangent, &b.tangent).clamp(-1.0, 1.0);
        let angle = cosine.acos();
        if angle > 3.0 * settings.angle && step > settings.minimum_step * 10.0 {
            step *= (settings.angle / angle).clamp(0.2, 0.6);
            current = false;
            continue;
        }
        // A bound is met exactly, with the parameter fixed.
        let mut bound = None;
        for (k, index) in parameters.iter().enumerate() {
            let (low, high) = settings.range(k);
            let at = a.z[*index];
            let (value, before) = if b.z[*index] > high {
                (high, high - at)
            } else if b.z[*index] < low {
                (low, at - low)
            } else {
                continue;
            };
            // From the bound itself, or from beyond it, there is no way outwards.
            if before <= ON_BOUND * settings.parameter_scale(k, value) {
                trace.stop = Stop::Bound(k);
                return trace;
            }
            if let Ok(node) = at_parameter(&mut corrector, m, &a, &b, *index, value, &row) {
                b = node;
            }
            current = false;
            bound = Some(k);
            break;
        }
        for value in &settings.at {
            let index = parameters[0];
            if (a.z[index] - value) * (b.z[index] - value) < 0.0 || b.z[index] == *value {
                if let Ok(node) = at_parameter(&mut corrector, m, &a, &b, index, *value, &row) {
                    trace.at.push((trace.nodes.len() - 1, node));
                }
                current = false;
            }
        }
        let stop = m.stop(&a, &b);
        if stop == Some(Stop::Vanished) {
            // Where an orbit shrinks to an equilibrium and grows again beyond it, a multiplier touches +1 and nothing happens.
            a.history = None;
        }
        let mut ended = None;
        if settings.detect {
            let found = corrector.examine(m, &a, &b, trace.nodes.len() - 1);
            b.remember(m, &a);
            if !found.is_empty() {
                current = false;
            }
            for point in found {
                let kind = point.label.kind;
                let end = m.ends(kind);
                trace.located.push(point);
                if end {
                    ended = Some(if matches!(kind, Kind::Monitor(_)) {
                        Stop::Monitor
                    } else {
                        Stop::EndOfKind
                    });
                    break;
                }
            }
        }
        if let Some(stop) = ended {
            // The branch ends on the point itself.
            if let Some(last) = trace.located.last() {
                trace.nodes.push(last.node.clone());
            }
            trace.stop = stop;
            return trace;
        }
        trace.nodes.push(b.clone());
        if let Some(k) = bound {
            trace.stop = Stop::Bound(k);
            return trace;
        }
        if let Some(stop) = stop {
            trace.stop = stop;
            return trace;
        }
        if trace.nodes.len() > 12 && closed(m, &first, &a, &b) {
            trace.stop = Stop::Closed;
            return trace;
        }
        let by_angle = if angle > 0.0 {
            settings.angle / angle
        } else {
            2.0
        };
        let target = if m.chord() { 6.0 } else { 3.5 };
        let by_newton = target / quality.iterations as f64;
        step = (step * by_angle.min(by_newton).clamp(0.4, 1.6))
            .min(settings.maximum_step)
            .max(settings.minimum_step);
        m.accept(&b.z);
        predictor.learn(m, &a, &b, &row);
        let mut tangent = b.tangent.clone();
        let mut z = b.z.clone();
        let mut vectors: Vec<&mut Vec<f64>> = predictor.vectors().collect();
        vectors.push(&mut tangent);
        if m.adapt(&mut z, &mut vectors, trace.nodes.len()) {
            // The same orbit on another mesh; the next correction is the first that works on it.
            m.rescale(&z);
            let size = inner(m.weights(), &tangent, &tangent).sqrt();
            for t in &mut tangent {
                *t /= size;
            }
            b = Node {
                z,
                tangent,
                mesh: m.mesh(),
                ..b
            };
            current = false;
        } else {
            m.rescale(&b.z);
            let size = inner(m.weights(), &b.tangent, &b.tangent).sqrt();
            for t in &mut b.tangent {
                *t /= size;
            }
            for r in &mut b.spectrum.rates {
                *r /= size;
            }
        }
        a = b;
    }
    trace
}

/// The solution between a and b (or beyond) at a value of one unknown.
fn at_parameter<M: Manifold>(
    corrector: &mut Corrector<'_>,
    m: &mut M,
    a: &Node,
    b: &Node,
    index: usize,
    value: f64,
    along: &[f64],
) -> Result<Node, Failure> {
    let x = (value - a.z[index]) / (b.z[index] - a.z[index]);
    let mut z: Vec<f64> = a.z.iter().zip(&b.z).map(|(a, b)| a + x * (b - a)).collect();
    let scale = m.weights()[index].sqrt();
    let mut row = vec![0.0; m.len()];
    row[index] = scale;
    corrector.correct(m, &mut z, &row, scale * value, false)?;
    z[index] = value;
    corrector.node(m, z, along)
}

/// Distance from a bound, over the scale of its parameter, within which a point lies on it.
const ON_BOUND: f64 = 1e-12;

/// Whether the step from a to b passes the start in the direction of the start.
fn closed<M: Manifold>(m: &M, first: &Node, a: &Node, b: &Node) -> bool {
    if first.z.len() != b.z.len() {
        return false;
    }
    let w = m.weights();
    let chord: Vec<f64> = b.z.iter().zip(&a.z).map(|(b, a)| b - a).collect();
    let to: Vec<f64> = first.z.iter().zip(&a.z).map(|(b, a)| b - a).collect();
    let length = inner(w, &chord, &chord);
    let along = inner(w, &chord, &to) / length;
    if !(0.0..=1.0).contains(&along) {
        return false;
    }
    let rest: Vec<f64> = to.iter().zip(&chord).map(|(t, c)| t - along * c).collect();
    inner(w, &rest, &rest).sqrt() < 0.1 * length.sqrt()
        && inner(w, &first.tangent, &chord)
            > 0.5 * length.sqrt() * inner(w, &first.tangent, &first.tangent).sqrt()
}
