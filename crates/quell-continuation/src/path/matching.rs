//! Which eigenvalue of one point becomes which of the next.

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
