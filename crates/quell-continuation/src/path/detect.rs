//! Special points between two successive points: every eigenvalue is followed on its own.
//!
//! A matched eigenvalue crosses the axis where its distance changes sign. Where both ends lie on the same side, the cubic
//! through both values and slopes, widened by its error, tells whether the eigenvalue may have come to the axis in
//! between; its extremum is then located. Ambiguous steps are halved; what cannot be resolved is reported as such.

use num_complex::Complex64;

use super::correct::Corrector;
use super::matching::assign;
use super::{Attention, Failure, Found, Label, Located, Manifold, Node, Trigger, inner};
use crate::dense::Spectrum;
use crate::kind::{Certainty, Kind};

/// The part of a branch between two points, along the chord.
struct Segment<'n> {
    a: &'n Node,
    b: &'n Node,
    row: Vec<f64>,
    origin: f64,
    length: f64,
    /// dz/ds at both ends, s being the coordinate along the chord.
    slopes: [f64; 2],
}

impl<'n> Segment<'n> {
    fn new<M: Manifold>(m: &M, a: &'n Node, b: &'n Node) -> Option<Self> {
        let chord: Vec<f64> = b.z.iter().zip(&a.z).map(|(b, a)| b - a).collect();
        let w = m.weights();
        let length = inner(w, &chord, &chord).sqrt();
        if !(length > 0.0 && length.is_finite()) {
            return None;
        }
        let row: Vec<f64> = chord.iter().zip(w).map(|(c, w)| c * w / length).collect();
        let project = |t: &[f64]| row.iter().zip(t).map(|(r, t)| r * t).sum::<f64>();
        let slopes = [project(&a.tangent), project(&b.tangent)];
        if slopes.iter().any(|s| *s < 0.1) {
            return None;
        }
        let origin = project(&a.z);
        Some(Self {
            a,
            b,
            row,
            origin,
            length,
            slopes,
        })
    }

    /// The cubic through both ends.
    fn guess(&self, s: f64) -> Vec<f64> {
        let x = s / self.length;
        let (h0, h1) = (
            (1.0 + 2.0 * x) * (1.0 - x) * (1.0 - x),
            x * x * (3.0 - 2.0 * x),
        );
        let (g0, g1) = (
            x * (1.0 - x) * (1.0 - x) * self.length,
            x * x * (x - 1.0) * self.length,
        );
        (0..self.a.z.len())
            .map(|i| {
                h0 * self.a.z[i]
                    + h1 * self.b.z[i]
                    + g0 * self.a.tangent[i] / self.slopes[0]
                    + g1 * self.b.tangent[i] / self.slopes[1]
            })
            .collect()
    }
}

/// A zero on a segment before it is labelled.
struct Zero {
    s: f64,
    node: Node,
    trigger: Trigger,
    error: f64,
    certainty: Certainty,
}

/// A bracketing search's state: value and eigenvalue at both ends.
struct Bracket {
    s: [f64; 2],
    f: [f64; 2],
    value: [Complex64; 2],
}

/// An eigenvalue so near the axis at its extremum touches it.
const TOUCH: f64 = 1e-9;
const UNKNOWN: Complex64 = Complex64::new(f64::NAN, f64::NAN);

enum Follow {
    /// The distance of one eigenvalue.
    Distance,
    /// The slope of that distance.
    Slope,
    /// That distance where it comes nearest to the axis, slopes being unknown.
    Least,
    /// A test function.
    Test(usize),
}

impl Corrector<'_> {
    fn at<M: Manifold>(
        &mut self,
        m: &mut M,
        segment: &Segment<'_>,
        s: f64,
    ) -> Result<Node, Failure> {
        let mut z = segment.guess(s);
        self.correct(m, &mut z, &segment.row, segment.origin + s, true)?;
        self.node(m, z, &segment.row)
    }

    /// Value of what is followed at a node, for the eigenvalue nearest to `near`.
    fn measure<M: Manifold>(
        m: &M,
        segment: &Segment<'_>,
        node: &Node,
        follow: &Follow,
        near: Complex64,
    ) -> (f64, Complex64) {
        if let Follow::Test(k) = follow {
            return (node.tests.get(*k).copied().unwrap_or(f64::NAN), near);
        }
        let Some(i) = nearest(&node.spectrum.values, near) else {
            return (f64::NAN, near);
        };
        let value = node.spectrum.values[i];
        if matches!(follow, Follow::Distance | Follow::Least) {
            return (m.distance(value), value);
        }
        let slope: f64 = segment
            .row
            .iter()
            .zip(&node.tangent)
            .map(|(r, t)| r * t)
            .sum();
        let rate = node
            .spectrum
            .rates
            .get(i)
            .copied()
            .unwrap_or(Complex64::new(f64::NAN, 0.0));
        (m.distance_rate(value, rate) / slope, value)
    }

    /// Regula falsi with Anderson and Björck's weights, safeguarded by bisection.
    fn root<M: Manifold>(
        &mut self,
        m: &mut M,
        segment: &Segment<'_>,
        follow: &Follow,
        mut bracket: Bracket,
    ) -> Option<(f64, Node, f64, Complex64)> {
        let mut tolerance = 1e-13 * (1.0 + bracket.value[0].norm());
        m.attend(Attention::Spectrum);
        if let Follow::Test(k) = follow {
            m.attend(Attention::Test(*k));
            // Test functions have no scale but their own.
            tolerance = tolerance.max(1e-11 * (bracket.f[0].abs() + bracket.f[1].abs()));
        }
        let mut best: Option<(f64, Node, f64, f64, Complex64)> = None;
        let mut weights = [1.0, 1.0];
        let mut last_width = f64::INFINITY;
        for round in 0..60 {
            let [s0, s1] = bracket.s;
            let width = s1 - s0;
            if width < 1e-12 * segment.length.max(1e-3) {
                break;
            }
            let (f0, f1) = (bracket.f[0] * weights[0], bracket.f[1] * weights[1]);
            let mut s = s0 - f0 * width / (f1 - f0);
            let slow = round % 4 == 3 && width > 0.4 * last_width;
            if round % 4 == 3 {
                last_width = width;
            }
            if !s.is_finite() || s <= s0 || s >= s1 || slow {
                s = 0.5 * (s0 + s1);
            }
            // Near a branch point the corrector fails; a nearby place serves as well.
            let mut node = self.at(m, segment, s);
            for shift in [0.1, -0.13, 0.3, -0.3] {
                if node.is_ok() {
                    break;
                }
                let moved = s + shift * (s1 - s).min(s - s0);
                node = self.at(m, segment, moved);
                if node.is_ok() {
                    s = moved;
                }
            }
            let Ok(node) = node else { break };
            let x = (s - s0) / width;
            let near = bracket.value[0] * (1.0 - x) + bracket.value[1] * x;
            let (f, value) = Self::measure(m, segment, &node, follow, near);
            if !f.is_finite() {
                break;
            }
            let better = best.as_ref().is_none_or(|b| f.abs() <= b.3);
            let moved = best.as_ref().map_or(width, |b| (b.0 - s).abs());
            if better {
                best = Some((s, node, width, f.abs(), value));
            }
            let side = usize::from((f > 0.0) == (bracket.f[1] > 0.0));
            let other = 1 - side;
            let ratio = 1.0 - f / bracket.f[side];
            weights[other] *= if ratio > 0.0 { ratio } else { 0.5 };
            weights[side] = 1.0;
            bracket.s[side] = s;
            bracket.f[side] = f;
            bracket.value[side] = value;
            if let Some(b) = &mut best
                && better
            {
                b.2 = moved.min(bracket.s[1] - bracket.s[0]);
            }
            if f.abs() <= tolerance || better && moved < 1e-11 * segment.length.max(1e-3) {
                break;
            }
        }
        m.attend(Attention::All);
        best.map(|(s, node, error, _, value)| (s, node, error, value))
    }

    /// Where the distance of an eigenvalue that stays on its side at both ends is least (parabolas through the best three places,
    /// golden section where they do not help), as soon as it is beyond the axis; None where it stays clear of it.
    fn least<M: Manifold>(
        &mut self,
        m: &mut M,
        segment: &Segment<'_>,
        bracket: &Bracket,
    ) -> Option<(f64, Node, f64, Complex64)> {
        let side = if bracket.f[0] > 0.0 { 1.0 } else { -1.0 };
        let [mut low, mut high] =
            [0, 1].map(|k| (bracket.s[k], side * bracket.f[k], bracket.value[k]));
        let mut best: Option<(f64, f64, Complex64, Node)> = None;
        let golden = 0.5 * (3.0 - 5.0_f64.sqrt());
        for round in 0..40 {
            let width = high.0 - low.0;
            let s = match &best {
                None => low.0 + 0.5 * width,
                Some((middle, value, ..)) => {
                    let (p, q) = (middle - low.0, middle - high.0);
                    let (u, v) = (value - high.1, value - low.1);
                    let parabola = middle - 0.5 * (p * p * u - q * q * v) / (p * u - q * v);
                    let larger = if p > -q { low.0 } else { high.0 };
                    let close = (parabola - middle).abs() < 1e-3 * width;
                    if parabola > low.0 && parabola < high.0 && !close && round % 4 != 3 {
                        parabola
                    } else {
                        middle + golden * (larger - middle)
                    }
                }
            };
            let node = self.at(m, segment, s).ok()?;
            let x = (s - low.0) / width;
            let near = low.2 * (1.0 - x) + high.2 * x;
            let (f, value) = Self::measure(m, segment, &node, &Follow::Least, near);
            let f = side * f;
            if !f.is_finite() {
                return None;
            }
            let better = best.as_ref().is_none_or(|b| f < b.1);
            if better {
                if let Some((middle, other, value, _)) = best.take() {
                    if middle < s {
                        low = (middle, other, value);
                    } else {
                        high = (middle, other, value);
                    }
                }
                best = Some((s, f, value, node));
            } else if let Some((middle, ..)) = &best {
                if s < *middle {
                    low = (s, f, value);
                } else {
                    high = (s, f, value);
                }
            }
            let (_, least, ..) = best.as_ref()?;
            let depth = low.1.min(high.1) - least;
            // Beyond the axis, or so flat that nothing is left to gain.
            if *least <= 0.0 || high.0 - low.0 < 1e-5 * segment.length || depth.abs() < 1e-12 {
                break;
            }
            // A dip that is half as deep as it is far from the axis does not reach it: three places of a parabola show all of it.
            if round > 4 && depth > 0.0 && *least > (2.0 * depth).max(1e2 * TOUCH) {
                return None;
            }
        }
        let (s, f, value, node) = best?;
        let width = high.0 - low.0;
        (f <= TOUCH * (1.0 + value.norm())).then_some((s, node, width, value))
    }

    /// Everything between two successive points, in order.
    pub(crate) fn examine<M: Manifold>(
        &mut self,
        m: &mut M,
        a: &Node,
        b: &Node,
        index: usize,
    ) -> Vec<Located> {
        let mut zeros = Vec::new();
        let division = self.settings.shortest_division;
        if let Some(segment) = Segment::new(m, a, b) {
            self.search(m, &segment, a, b, 1.0, division, 0.0, &mut zeros);
        }
        zeros.sort_by(|x, y| x.s.total_cmp(&y.s));
        let before = a.unstable(m);
        let after = b.unstable(m);
        label(m, a, b, zeros, before, after, index)
    }

    /// Searches the part of a segment between nodes a and b that takes a fraction of the whole.
    #[allow(clippy::too_many_arguments)]
    fn search<M: Manifold>(
        &mut self,
        m: &mut M,
        whole: &Segment<'_>,
        a: &Node,
        b: &Node,
        fraction: f64,
        division: f64,
        start: f64,
        zeros: &mut Vec<Zero>,
    ) {
        let Some(part) = Segment::new(m, a, b) else {
            return;
        };
        let length = part.length;
        let scale = whole.length * fraction / length;
        let place = |s: f64| start + s * scale;
        let ahead = |i: usize| {
            a.spectrum.values[i] + rate(&a.spectrum, i) * (0.5 * length / part.slopes[0])
        };
        let back = |j: usize| {
            b.spectrum.values[j] - rate(&b.spectrum, j) * (0.5 * length / part.slopes[1])
        };
        let pairs = assign(&a.spectrum, &b.spectrum, |i, j| m.gap(ahead(i), back(j)));
        let mut divide = false;
        let mut found: Vec<(Follow, Bracket, bool)> = Vec::new();
        for pair in &pairs {
            let (va, vb) = (a.spectrum.values[pair.from], b.spectrum.values[pair.to]);
            if m.tested(va, vb) {
                continue;
            }
            let (fa, fb) = (m.distance(va), m.distance(vb));
            let crosses = (fa > 0.0) != (fb > 0.0);
            let near = fa.abs().min(fb.abs()) < 4.0 * (va - vb).norm();
            if crosses && ((va.im == 0.0) != (vb.im == 0.0) || pair.ambiguous) {
                divide = true;
            }
            let gap = m.gap(va, vb);
            if gap > m.longest_gap()
                && fa.abs().min(fb.abs()) < 2.0 * gap
                && (fraction > 8.0 * division || crosses)
            {
                divide = true;
            }
            if va.im < 0.0 || va.im == 0.0 && vb.im < 0.0 {
                continue;
            }
            if crosses {
                found.push((
                    Follow::Distance,
                    Bracket {
                        s: [0.0, length],
                        f: [fa, fb],
                        value: [va, vb],
                    },
                    true,
                ));
                continue;
            }
            let known = |s: &Spectrum, i: usize, slope: f64| {
                let rate = s.rates.get(i).copied().unwrap_or(UNKNOWN);
                m.distance_rate(s.values[i], rate) / slope
            };
            let exact = (
                known(&a.spectrum, pair.from, part.slopes[0]),
                known(&b.spectrum, pair.to, part.slopes[1]),
            );
            let exactly = exact.0.is_finite() && exact.1.is_finite();
            let Some((ra, rb)) = (if exactly {
                Some(exact)
            } else {
                a.slopes(m, pair.from, (fa, fb), length)
            }) else {
                continue;
            };
            if pair.ambiguous
                && near
                && fraction > 8.0 * division
                && (va.im == 0.0) == (vb.im == 0.0)
            {
                divide = true;
            }
            let side = if fa > 0.0 { 1.0 } else { -1.0 };
            if side * ra < 0.0 && side * rb > 0.0 {
                let (least, depth) =
                    extremum(side * fa, side * fb, side * ra * length, side * rb * length);
                // The cubic's own error is taken as half the depth of its dip.
                if least - 0.5 * depth <= 0.0 {
                    let f = if exactly { [ra, rb] } else { [fa, fb] };
                    found.push((
                        if exactly {
                            Follow::Slope
                        } else {
                            Follow::Least
                        },
                        Bracket {
                            s: [0.0, length],
                            f,
                            value: [va, vb],
                        },
                        false,
                    ));
                }
            }
        }
        if divide {
            if fraction > division
                && let Ok(middle) = self.at(m, &part, 0.5 * length)
            {
                self.search(m, whole, a, &middle, 0.5 * fraction, division, start, zeros);
                let mut middle = middle;
                middle.remember(m, a);
                self.search(
                    m,
                    whole,
                    &middle,
                    b,
                    0.5 * fraction,
                    division,
                    place(0.5 * length),
                    zeros,
                );
                return;
            }
            let value = found.first().map_or(Complex64::default(), |f| f.1.value[1]);
            zeros.push(Zero {
                s: place(length),
                node: b.clone(),
                trigger: Trigger::Crossing(value),
                error: length,
                certainty: Certainty::Unresolved,
            });
            return;
        }
        for (follow, bracket, crossing) in found {
            let ends = bracket.f;
            let values = bracket.value;
            let outer = [m.distance(values[0]), m.distance(values[1])];
            let reached = if matches!(follow, Follow::Least) {
                // What does not come near the axis is nothing.
                match self.least(m, &part, &bracket) {
                    Some(found) => Some(found),
                    None => continue,
                }
            } else {
                self.root(m, &part, &follow, bracket)
            };
            let Some((s, node, error, value)) = reached else {
                zeros.push(Zero {
                    s: place(length),
                    node: b.clone(),
                    trigger: Trigger::Crossing(values[1]),
                    error: length,
                    certainty: Certainty::Unresolved,
                });
                continue;
            };
            let _ = ends;
            if crossing {
                zeros.push(Zero {
                    s: place(s),
                    node,
                    trigger: Trigger::Crossing(value),
                    error,
                    certainty: Certainty::Located,
                });
                continue;
            }
            let distance = m.distance(value);
            if distance.abs() <= TOUCH * (1.0 + value.norm()) {
                zeros.push(Zero {
                    s: place(s),
                    node,
                    trigger: Trigger::Touch(value),
                    error,
                    certainty: Certainty::Located,
                });
            } else if (distance > 0.0) != (outer[0] > 0.0) {
                for half in 0..2 {
                    let bracket = if half == 0 {
                        Bracket {
                            s: [0.0, s],
                            f: [outer[0], distance],
                            value: [values[0], value],
                        }
                    } else {
                        Bracket {
                            s: [s, length],
                            f: [distance, outer[1]],
                            value: [value, values[1]],
                        }
                    };
                    if let Some((s, node, error, value)) =
                        self.root(m, &part, &Follow::Distance, bracket)
                    {
                        zeros.push(Zero {
                            s: place(s),
                            node,
                            trigger: Trigger::Crossing(value),
                            error,
                            certainty: Certainty::Located,
                        });
                    }
                }
            }
        }
        for k in 0..a.tests.len().min(b.tests.len()) {
            let (fa, fb) = (a.tests[k], b.tests[k]);
            if fa.is_finite() && fb.is_finite() && (fa > 0.0) != (fb > 0.0) {
                let zero = Complex64::default();
                let bracket = Bracket {
                    s: [0.0, length],
                    f: [fa, fb],
                    value: [zero, zero],
                };
                if let Some((s, node, error, _)) = self.root(m, &part, &Follow::Test(k), bracket) {
                    zeros.push(Zero {
                        s: place(s),
                        node,
                        trigger: Trigger::Test(k),
                        error,
                        certainty: Certainty::Located,
                    });
                }
            }
        }
    }
}

/// Least value of the cubic on [0, 1] with values f and slopes r at the ends, and how far below both ends it lies.
fn extremum(f0: f64, f1: f64, r0: f64, r1: f64) -> (f64, f64) {
    let mut least = f0.min(f1);
    let ends = least;
    for k in 1..64 {
        let x = f64::from(k) / 64.0;
        let (h0, h1) = (
            (1.0 + 2.0 * x) * (1.0 - x) * (1.0 - x),
            x * x * (3.0 - 2.0 * x),
        );
        let (g0, g1) = (x * (1.0 - x) * (1.0 - x), x * x * (x - 1.0));
        least = least.min(h0 * f0 + h1 * f1 + g0 * r0 + g1 * r1);
    }
    (least, ends - least)
}

/// The derivative of eigenvalue i, or zero where unknown.
fn rate(s: &Spectrum, i: usize) -> Complex64 {
    s.rates
        .get(i)
        .copied()
        .filter(|r| r.re.is_finite() && r.im.is_finite())
        .unwrap_or_default()
}

fn nearest(values: &[Complex64], near: Complex64) -> Option<usize> {
    (0..values.len()).min_by(|i, j| {
        (values[*i] - near)
            .norm()
            .total_cmp(&(values[*j] - near).norm())
    })
}

/// Names the zeros; two pairs on the axis at one place are one point.
fn label<M: Manifold>(
    m: &mut M,
    a: &Node,
    b: &Node,
    zeros: Vec<Zero>,
    before: usize,
    after: usize,
    index: usize,
) -> Vec<Located> {
    let mut out: Vec<Located> = Vec::new();
    let mut count = before;
    let total = zeros
        .iter()
        .filter(|z| matches!(z.trigger, Trigger::Crossing(_)))
        .count();
    let mut seen = 0;
    let mut at = None;
    for zero in zeros {
        let found = Found {
            node: &zero.node,
            trigger: zero.trigger,
            before: a,
            after: b,
        };
        let label = match zero.certainty {
            Certainty::Located => m.classify(&found),
            Certainty::Unresolved => Some(
                m.classify(&found)
                    .unwrap_or_else(|| Label::plain(Kind::BranchPoint)),
            ),
        };
        let was = count;
        if let Trigger::Crossing(_) = zero.trigger {
            seen += 1;
        }
        let Some(label) = label else { continue };
        if let (Trigger::Crossing(v), Certainty::Located) = (zero.trigger, zero.certainty) {
            let multiple = if v.im == 0.0 { 1 } else { 2 };
            let up = rises(m, a, b, v);
            count = if up {
                count + multiple
            } else {
                count.saturating_sub(multiple)
            };
            if seen == total {
                count = after;
            }
        }
        let near = at.is_some_and(|s: f64| (zero.s - s).abs() < 1e-6);
        if near && let Some(last) = out.last_mut() {
            if last.label.kind == label.kind && label.kind == Kind::Hopf {
                last.label.kind = Kind::HopfHopf;
                last.label.second_omega = label.omega;
                last.label.normal_form.extend(&label.normal_form);
                last.after = count;
                continue;
            }
            if matches!(
                (last.label.kind, label.kind),
                (Kind::Hopf, Kind::Fold | Kind::BranchPoint)
                    | (Kind::Fold | Kind::BranchPoint, Kind::Hopf)
            ) {
                last.label.kind = Kind::ZeroHopf;
                last.label.omega = last.label.omega.or(label.omega);
                last.after = count;
                continue;
            }
            if last.label.kind == label.kind && !matches!(label.kind, Kind::Monitor(_)) {
                last.after = count;
                continue;
            }
        }
        at = Some(zero.s);
        let mut node = zero.node;
        if matches!(label.kind, Kind::BranchPoint | Kind::CycleBranchPoint) {
            // Where branches cross the tangent itself is ill determined.
            let chord: Vec<f64> = b.z.iter().zip(&a.z).map(|(b, a)| b - a).collect();
            let x = (zero.s / inner(m.weights(), &chord, &chord).sqrt()).clamp(0.0, 1.0);
            let mean: Vec<f64> = a
                .tangent
                .iter()
                .zip(&b.tangent)
                .map(|(a, b)| a + x * (b - a))
                .collect();
            let size = inner(m.weights(), &mean, &mean).sqrt();
            node.tangent = mean.iter().map(|t| t / size).collect();
        }
        out.push(Located {
            label,
            node,
            before: was,
            after: count,
            certainty: zero.certainty,
            error: zero.error,
            index,
        });
    }
    out
}

/// Whether the eigenvalue that is v on the axis is unstable at b.
fn rises<M: Manifold>(m: &M, a: &Node, b: &Node, v: Complex64) -> bool {
    // The pair that changes side and lies nearest to v decides.
    let pairs = assign(&a.spectrum, &b.spectrum, |i, j| {
        m.gap(a.spectrum.values[i], b.spectrum.values[j])
    });
    let mut best = (f64::INFINITY, true);
    for p in pairs {
        let (x, y) = (a.spectrum.values[p.from], b.spectrum.values[p.to]);
        let (fx, fy) = (m.distance(x), m.distance(y));
        if (fx > 0.0) == (fy > 0.0) {
            continue;
        }
        let gap = ((x + y) * 0.5 - v).norm();
        if gap < best.0 {
            best = (gap, fy > 0.0);
        }
    }
    best.1
}
