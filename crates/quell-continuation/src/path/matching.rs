//! Which eigenvalue of one point becomes which of the next.

use num_complex::Complex64;

use super::{Manifold, Node, inner};
use crate::dense::Spectrum;

/// A pair of matched eigenvalues.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pair {
    pub(crate) from: usize,
    pub(crate) to: usize,
    /// Whether another partner would have been about as good.
    pub(crate) ambiguous: bool,
}

/// Matches by repeatedly joining the pair (i, j) of least cost (both spectra are small).
pub(crate) fn assign(a: &Spectrum, b: &Spectrum, cost: impl Fn(usize, usize) -> f64) -> Vec<Pair> {
    let n = a.values.len().min(b.values.len());
    let mut costs: Vec<(f64, usize, usize)> = Vec::with_capacity(n * n);
    for i in 0..a.values.len() {
        for j in 0..b.values.len() {
            costs.push((cost(i, j), i, j));
        }
    }
    costs.sort_by(|x, y| x.0.total_cmp(&y.0));
    let mut used_a = vec![false; a.values.len()];
    let mut used_b = vec![false; b.values.len()];
    let mut pairs = Vec::with_capacity(n);
    for (c, i, j) in &costs {
        if used_a[*i] || used_b[*j] {
            continue;
        }
        used_a[*i] = true;
        used_b[*j] = true;
        let rival = costs
            .iter()
            .any(|(d, k, l)| ((k == i) != (l == j)) && *d < 2.0 * c + 1e-12);
        pairs.push(Pair {
            from: *i,
            to: *j,
            ambiguous: rival && *c > 1e-9 * (1.0 + a.values[*i].norm()),
        });
    }
    pairs.sort_by_key(|p| p.from);
    pairs
}

impl Node {
    /// Notes what its eigenvalues were at the point before, unless their rates are known.
    pub(crate) fn remember<M: Manifold>(&mut self, m: &M, before: &Self) {
        if self.spectrum.rates.iter().all(|r| r.re.is_finite()) || before.z.len() != self.z.len() {
            return;
        }
        let unknown = Complex64::new(f64::NAN, f64::NAN);
        let mut values = vec![unknown; self.spectrum.values.len()];
        let pairs = assign(&before.spectrum, &self.spectrum, |i, j| {
            m.gap(before.spectrum.values[i], self.spectrum.values[j])
        });
        for pair in pairs.iter().filter(|pair| !pair.ambiguous) {
            values[pair.to] = before.spectrum.values[pair.from];
        }
        let chord: Vec<f64> = self.z.iter().zip(&before.z).map(|(b, a)| b - a).collect();
        let length = inner(m.weights(), &chord, &chord).sqrt();
        self.history = (length > 0.0).then_some((values, length));
    }

    /// Slopes of a distance at this point and at the next, `length` further, by the parabola through three points:
    /// eigenvalue `index` is at `here` now and at `there` then.
    pub(crate) fn slopes<M: Manifold>(
        &self,
        m: &M,
        index: usize,
        (here, there): (f64, f64),
        length: f64,
    ) -> Option<(f64, f64)> {
        let (values, past) = self.history.as_ref()?;
        let before = m.distance(*values.get(index)?);
        let (last, now) = ((here - before) / past, (there - here) / length);
        let slope = (last * length + now * past) / (length + past);
        slope.is_finite().then_some((slope, 2.0 * now - slope))
    }
}
