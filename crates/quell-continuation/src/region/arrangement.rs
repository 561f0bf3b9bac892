//! The cells into which curves divide the unit square.
//!
//! Points are rounded to a lattice so fine that no picture shows it; on it every predicate is exact in integers. Segments are divided
//! where they meet until none cross, and the faces of the planar graph that remains are walked round (M. de Berg et al.,
//! Computational Geometry, 3rd ed., 2008, ch. 2: half-edges). Curves that end within a cell stay in its boundary as a slit.

use std::collections::{BTreeMap, BTreeSet};

/// Intervals of the lattice on the unit square.
const LATTICE: f64 = 1_048_576.0;
/// Most rounds of division: rounding bends segments, so that a few more may meet.
const ROUNDS: usize = 20;
/// Points across a cell's box among which one far from its boundary is sought.
const SEARCH: usize = 48;

type Vertex = (i64, i64);

/// A cell: loops of its boundary (the outer one first, then those of holes) and a point within, far from all of them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Face {
    pub(super) loops: Vec<Vec<[f64; 2]>>,
    pub(super) area: f64,
    pub(super) inside: [f64; 2],
    /// Distance of that point from the boundary.
    pub(super) clear: f64,
}

/// The cells between polylines in the unit square, from the largest to the smallest.
pub(super) fn faces(curves: &[Vec<[f64; 2]>]) -> Vec<Face> {
    let edges = divided(curves);
    let mut around: BTreeMap<Vertex, Vec<Vertex>> = BTreeMap::new();
    for (a, b) in &edges {
        around.entry(*a).or_default().push(*b);
        around.entry(*b).or_default().push(*a);
    }
    for (at, neighbours) in &mut around {
        neighbours.sort_by(|a, b| turn(direction(*at, *a), direction(*at, *b)));
    }
    // Loops with the face on their left: outer ones run round counter-clockwise, those of holes clockwise.
    let mut walked: BTreeSet<(Vertex, Vertex)> = BTreeSet::new();
    let mut outer: Vec<(i128, Vec<Vertex>)> = Vec::new();
    let mut holes: Vec<Vec<Vertex>> = Vec::new();
    for (start, neighbours) in &around {
        for first in neighbours {
            let mut edge = (*start, *first);
            let mut ring = Vec::new();
            while walked.insert(edge) {
                ring.push(edge.0);
                let (from, at) = edge;
                let Some(out) = around.get(&at) else { break };
                let place = out.iter().position(|next| *next == from).unwrap_or(0);
                let next = out[(place + out.len() - 1) % out.len()];
                edge = (at, next);
            }
            if ring.is_empty() {
                continue;
            }
            let area = doubled_area(&ring);
            if area > 0 {
                outer.push((area, ring));
            } else {
                holes.push(ring);
            }
        }
    }
    outer.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut within: Vec<Vec<Vec<Vertex>>> = vec![Vec::new(); outer.len()];
    let parts = components(&around);
    for hole in holes {
        // The smallest face about it; the outside of the square has none.
        let place = outer.iter().rposition(|(_, ring)| {
            parts.get(&ring[0]) != parts.get(&hole[0]) && encloses(ring, hole[0])
        });
        if let Some(place) = place {
            within[place].push(hole);
        }
    }
    outer
        .into_iter()
        .zip(within)
        .map(|((area, ring), holes)| {
            let all: i128 = area + holes.iter().map(|hole| doubled_area(hole)).sum::<i128>();
            let mut loops = vec![ring];
            loops.extend(holes);
            let loops: Vec<Vec<[f64; 2]>> = loops
                .iter()
                .map(|ring| ring.iter().map(|v| back(*v)).collect())
                .collect();
            let (inside, clear) = clearest(&loops);
            Face {
                area: all as f64 / (2.0 * LATTICE * LATTICE),
                loops,
                inside,
                clear,
            }
        })
        .collect()
}

fn back(v: Vertex) -> [f64; 2] {
    [v.0 as f64 / LATTICE, v.1 as f64 / LATTICE]
}

/// Segments that meet at ends only, each once; the square's own sides among them.
fn divided(curves: &[Vec<[f64; 2]>]) -> Vec<(Vertex, Vertex)> {
    let lattice = |x: f64| (x.clamp(0.0, 1.0) * LATTICE).round() as i64;
    let end = LATTICE as i64;
    let corners = [(0, 0), (end, 0), (end, end), (0, end)];
    let mut edges: BTreeSet<(Vertex, Vertex)> = BTreeSet::new();
    let mut add = |a: Vertex, b: Vertex| {
        if a != b {
            edges.insert((a.min(b), a.max(b)));
        }
    };
    for k in 0..4 {
        add(corners[k], corners[(k + 1) % 4]);
    }
    for curve in curves {
        for pair in curve.windows(2) {
            let [a, b] = [pair[0], pair[1]].map(|p| (lattice(p[0]), lattice(p[1])));
            add(a, b);
        }
    }
    for _ in 0..ROUNDS {
        let all: Vec<(Vertex, Vertex)> = edges.iter().copied().collect();
        let mut cuts: Vec<Vec<Vertex>> = vec![Vec::new(); all.len()];
        // By their left ends: what begins beyond a right end meets nothing before it.
        for (i, one) in all.iter().enumerate() {
            for (j, other) in all.iter().enumerate().skip(i + 1) {
                if other.0.0 > one.1.0 {
                    break;
                }
                let low = one.0.1.min(one.1.1).max(other.0.1.min(other.1.1));
                let high = one.0.1.max(one.1.1).min(other.0.1.max(other.1.1));
                if low > high {
                    continue;
                }
                for (on, segment, points) in
                    [(i, one, [other.0, other.1]), (j, other, [one.0, one.1])]
                {
                    for point in points {
                        if point != segment.0 && point != segment.1 && lies_on(point, *segment) {
                            cuts[on].push(point);
                        }
                    }
                }
                if let Some(point) = crossing(*one, *other) {
                    cuts[i].push(point);
                    cuts[j].push(point);
                }
            }
        }
        let mut changed = false;
        for ((a, b), mut points) in all.into_iter().zip(cuts) {
            points.retain(|point| *point != a && *point != b);
            if points.is_empty() {
                continue;
            }
            changed = true;
            edges.remove(&(a, b));
            let along = |v: &Vertex| {
                let ((x, y), (dx, dy)) = (direction(a, *v), direction(a, b));
                i128::from(x) * i128::from(dx) + i128::from(y) * i128::from(dy)
            };
            points.sort_by_key(along);
            points.insert(0, a);
            points.push(b);
            for pair in points.windows(2) {
                if pair[0] != pair[1] {
                    edges.insert((pair[0].min(pair[1]), pair[0].max(pair[1])));
                }
            }
        }
        if !changed {
            break;
        }
    }
    edges.into_iter().collect()
}

fn direction(from: Vertex, to: Vertex) -> (i64, i64) {
    (to.0 - from.0, to.1 - from.1)
}

fn cross(a: (i64, i64), b: (i64, i64)) -> i64 {
    a.0 * b.1 - a.1 * b.0
}

/// Order by angle from the positive first axis, counter-clockwise.
fn turn(a: (i64, i64), b: (i64, i64)) -> std::cmp::Ordering {
    let half = |d: (i64, i64)| d.1 < 0 || (d.1 == 0 && d.0 < 0);
    half(a).cmp(&half(b)).then_with(|| 0.cmp(&cross(a, b)))
}

fn lies_on(point: Vertex, (a, b): (Vertex, Vertex)) -> bool {
    cross(direction(a, b), direction(a, point)) == 0
        && (a.0.min(b.0)..=a.0.max(b.0)).contains(&point.0)
        && (a.1.min(b.1)..=a.1.max(b.1)).contains(&point.1)
}

/// Where two segments cross inside of both, rounded.
fn crossing((a, b): (Vertex, Vertex), (c, d): (Vertex, Vertex)) -> Option<Vertex> {
    let (along, other) = (direction(a, b), direction(c, d));
    let sides = [cross(along, direction(a, c)), cross(along, direction(a, d))];
    let others = [cross(other, direction(c, a)), cross(other, direction(c, b))];
    let apart = |pair: [i64; 2]| pair[0].signum() * pair[1].signum() < 0;
    if !(apart(sides) && apart(others)) {
        return None;
    }
    let part = others[0] as f64 / (others[0] as f64 - others[1] as f64);
    Some((
        a.0 + (part * along.0 as f64).round() as i64,
        a.1 + (part * along.1 as f64).round() as i64,
    ))
}

fn doubled_area(ring: &[Vertex]) -> i128 {
    (0..ring.len())
        .map(|k| i128::from(cross(ring[k], ring[(k + 1) % ring.len()])))
        .sum()
}

/// Whether a ring goes round a point that is not on it.
fn encloses(ring: &[Vertex], at: Vertex) -> bool {
    let mut inside = false;
    for k in 0..ring.len() {
        let (a, b) = (ring[k], ring[(k + 1) % ring.len()]);
        if (a.1 > at.1) != (b.1 > at.1) {
            let side = cross(direction(a, b), direction(a, at));
            if (side > 0) == (b.1 > a.1) {
                inside = !inside;
            }
        }
    }
    inside
}

/// Which vertices are connected: the least vertex of each one's component.
fn components(around: &BTreeMap<Vertex, Vec<Vertex>>) -> BTreeMap<Vertex, Vertex> {
    let mut known: BTreeMap<Vertex, Vertex> = BTreeMap::new();
    for first in around.keys() {
        let mut waiting = vec![*first];
        while let Some(vertex) = waiting.pop() {
            if known.contains_key(&vertex) {
                continue;
            }
            known.insert(vertex, *first);
            waiting.extend(around.get(&vertex).into_iter().flatten());
        }
    }
    known
}

/// The point of a search grid within the loops that is furthest from them, and how far.
fn clearest(loops: &[Vec<[f64; 2]>]) -> ([f64; 2], f64) {
    let mut low = [f64::INFINITY; 2];
    let mut high = [f64::NEG_INFINITY; 2];
    for point in loops.iter().flatten() {
        for k in 0..2 {
            low[k] = low[k].min(point[k]);
            high[k] = high[k].max(point[k]);
        }
    }
    let mut best = ([0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])], 0.0);
    for i in 0..SEARCH {
        for j in 0..SEARCH {
            let part = |k: usize| (k as f64 + 0.5) / SEARCH as f64;
            let at = [
                low[0] + part(i) * (high[0] - low[0]),
                low[1] + part(j) * (high[1] - low[1]),
            ];
            if !contains(loops, at) {
                continue;
            }
            let clear = distance(loops, at, best.1);
            if clear > best.1 {
                best = (at, clear);
            }
        }
    }
    best
}

/// Whether a point is inside of an outer loop and outside of its holes.
pub(super) fn contains(loops: &[Vec<[f64; 2]>], at: [f64; 2]) -> bool {
    let mut inside = false;
    for ring in loops {
        for k in 0..ring.len() {
            let (a, b) = (ring[k], ring[(k + 1) % ring.len()]);
            if (a[1] > at[1]) != (b[1] > at[1]) {
                let x = a[0] + (at[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
                if x > at[0] {
                    inside = !inside;
                }
            }
        }
    }
    inside
}

/// Distance from the nearest edge; anything below `enough` once it is less than that.
pub(super) fn distance(loops: &[Vec<[f64; 2]>], at: [f64; 2], enough: f64) -> f64 {
    let mut least = f64::INFINITY;
    for ring in loops {
        for k in 0..ring.len() {
            least = least.min(from_segment(at, ring[k], ring[(k + 1) % ring.len()]));
            if least < enough {
                return least;
            }
        }
    }
    least
}

/// Distance of a point from a segment.
pub(super) fn from_segment(at: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let length = dx * dx + dy * dy;
    let t = if length > 0.0 {
        (((at[0] - a[0]) * dx + (at[1] - a[1]) * dy) / length).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (at[0] - a[0] - t * dx).hypot(at[1] - a[1] - t * dy)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circle(x: f64, y: f64, r: f64) -> Vec<[f64; 2]> {
        (0..=200)
            .map(|k| std::f64::consts::TAU * f64::from(k) / 200.0)
            .map(|a| [x + r * a.cos(), y + r * a.sin()])
            .collect()
    }

    /// Euler: two circles that meet twice, a line across the square that meets neither, a circle within one cell: the square has
    /// 2 + 2 + 1 + 1 cells more or less than one, and all areas add up to one. Exact but for rounding to the lattice.
    #[test]
    fn faces_add_up_to_the_square() {
        let curves = vec![
            circle(0.3, 0.5, 0.15),
            circle(0.45, 0.5, 0.15),
            vec![[0.8, 0.0], [0.75, 0.6], [0.8, 1.0]],
            circle(0.9, 0.5, 0.05),
        ];
        let found = faces(&curves);
        // Left of the line, right of it, two moons and a lens, the small disc.
        assert_eq!(found.len(), 6);
        let total: f64 = found.iter().map(|face| face.area).sum();
        assert!((total - 1.0).abs() < 1e-9, "{total}");
        // A polygon of 200 corners has sin(2π/200)/(2π/200) of the disc's area; rounding moves corners by 5e-7.
        let angle = std::f64::consts::TAU / 200.0;
        let disc = std::f64::consts::PI * 0.05_f64.powi(2) * angle.sin() / angle;
        assert!((found[5].area - disc).abs() < 1e-6);
        let holed = found.iter().filter(|face| face.loops.len() == 2).count();
        assert_eq!(holed, 2);
        for face in &found {
            assert!(contains(&face.loops, face.inside) && face.clear > 0.0);
        }
    }

    /// A curve that ends within a cell divides nothing.
    #[test]
    fn a_slit_is_no_cell() {
        let found = faces(&[vec![[0.5, 0.0], [0.5, 0.7]]]);
        assert_eq!(found.len(), 1);
        assert!((found[0].area - 1.0).abs() < 1e-12);
    }

    /// Curves that touch in a common end divide the square, as torus curves and Hopf curves do at a Hopf-Hopf point.
    #[test]
    fn curves_that_meet_in_a_point_close_cells() {
        let meet = [0.4, 0.3];
        let found = faces(&[
            vec![[0.0, 0.3], meet, [1.0, 0.9]],
            vec![[0.4, 0.0], meet, [0.2, 1.0]],
            vec![meet, [0.6, 0.8], [0.7, 1.0]],
        ]);
        assert_eq!(found.len(), 5);
    }
}
