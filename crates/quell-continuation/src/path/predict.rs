//! Where the next point is expected.

use super::{Manifold, Node, inner};

/// A point before: its tangent, and what leads from it to the present one.
struct Past {
    tangent: Vec<f64>,
    chord: Vec<f64>,
}

/// The polynomial through the present point and those before, with their tangents. The coordinate is that across the plane in
/// which the corrector works, so that predictions lie in it.
///
/// Of all numbers of points before, that one is used which would have predicted the last point best: where a branch is smooth
/// Newton then has little to do, and where it bends, or points are known no better than their prediction, the line is taken.
#[derive(Default)]
pub(crate) struct Predictor {
    /// The latest first.
    past: Vec<Past>,
    used: usize,
}

/// So many points before are kept: two make a quintic, and what more of them gain the error of the points themselves takes.
const MOST: usize = 2;

impl Predictor {
    /// The point at `step` across the plane of `row`, from node `a`.
    pub(crate) fn predict(&self, a: &Node, row: &[f64], step: f64) -> Vec<f64> {
        self.with(self.used, a, row, step)
    }

    fn with(&self, count: usize, a: &Node, row: &[f64], step: f64) -> Vec<f64> {
        let project = |v: &[f64]| row.iter().zip(v).map(|(r, v)| r * v).sum::<f64>();
        let mut places = vec![0.0];
        let mut slopes = vec![1.0];
        for past in self.past.iter().take(count) {
            let (place, slope) = (-project(&past.chord), project(&past.tangent));
            // What lies round a sharp bend is no guide.
            if place >= places[places.len() - 1] || slope < 0.1 {
                break;
            }
            places.push(place);
            slopes.push(slope);
        }
        let mut weights = vec![[0.0; 2]; places.len()];
        hermite(&places, step, &mut weights);
        let mut z: Vec<f64> =
            a.z.iter()
                .zip(&a.tangent)
                .map(|(z, t)| z + weights[0][1] * t)
                .collect();
        for ((past, slope), [value, rate]) in self.past.iter().zip(&slopes[1..]).zip(&weights[1..])
        {
            let rate = rate / slope;
            for ((z, c), t) in z.iter_mut().zip(&past.chord).zip(&past.tangent) {
                *z += rate * t - value * c;
            }
        }
        z
    }

    /// Takes in the step from `a` to `b`, `row` being the plane's.
    pub(crate) fn learn<M: Manifold>(&mut self, m: &M, a: &Node, b: &Node, row: &[f64]) {
        let chord: Vec<f64> = b.z.iter().zip(&a.z).map(|(b, a)| b - a).collect();
        let step: f64 = row.iter().zip(&chord).map(|(r, c)| r * c).sum();
        let mut least = f64::INFINITY;
        for count in 0..=self.past.len() {
            let mut off = self.with(count, a, row, step);
            for (off, z) in off.iter_mut().zip(&b.z) {
                *off -= z;
            }
            let size = inner(m.weights(), &off, &off);
            if size < least {
                least = size;
                self.used = count;
            }
        }
        // The first time that there is one more, it is worth a try.
        if self.used == self.past.len() && self.used < MOST {
            self.used += 1;
        }
        for past in &mut self.past {
            for (old, new) in past.chord.iter_mut().zip(&chord) {
                *old += new;
            }
        }
        self.past.truncate(MOST - 1);
        let tangent = a.tangent.clone();
        self.past.insert(0, Past { tangent, chord });
    }

    /// What has to be carried over to another mesh.
    pub(crate) fn vectors(&mut self) -> impl Iterator<Item = &mut Vec<f64>> {
        self.past
            .iter_mut()
            .flat_map(|past| [&mut past.tangent, &mut past.chord])
    }
}

/// Weights of values and slopes at places in the polynomial that has them, at s.
fn hermite(places: &[f64], s: f64, weights: &mut [[f64; 2]]) {
    for (k, weight) in weights.iter_mut().enumerate() {
        let own = places[k];
        let others = || places.iter().enumerate().filter(move |(j, _)| *j != k);
        let basis: f64 = others().map(|(_, p)| (s - p) / (own - p)).product();
        let steep: f64 = others().map(|(_, p)| 1.0 / (own - p)).sum();
        let square = basis * basis;
        *weight = [square * (1.0 - 2.0 * (s - own) * steep), square * (s - own)];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quintic_is_predicted_from_three_points() {
        // Exact but for rounding: the weights here are at most about 70.
        let f = |s: f64| 2.0 - s + 0.5 * s.powi(3) + 0.25 * s.powi(5);
        let slope = |s: f64| -1.0 + 1.5 * s.powi(2) + 1.25 * s.powi(4);
        let places = [0.0, -0.3, -0.7];
        let mut weights = [[0.0; 2]; 3];
        hermite(&places, 0.4, &mut weights);
        let found: f64 = places
            .iter()
            .zip(&weights)
            .map(|(p, [v, r])| v * f(*p) + r * slope(*p))
            .sum();
        assert!((found - f(0.4)).abs() < 1e-12, "{found} {}", f(0.4));
    }
}
