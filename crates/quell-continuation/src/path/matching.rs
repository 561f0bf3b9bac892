//! Which eigenvalue of one point becomes which of the next.

use num_complex::Complex64;

use crate::dense::Spectrum;

/// A pair of matched eigenvalues.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pair {
    pub(crate) from: usize,
    pub(crate) to: usize,
    /// Whether another partner would have been about as good.
    pub(crate) ambiguous: bool,
}

fn rate(s: &Spectrum, i: usize) -> Complex64 {
    match s.rates.get(i) {
        Some(r) if r.re.is_finite() && r.im.is_finite() => *r,
        _ => Complex64::default(),
    }
}

/// Distance between eigenvalue i carried half a step forwards and j carried half a step back.
fn cost(a: &Spectrum, i: usize, b: &Spectrum, j: usize, length: f64) -> f64 {
    let ahead = a.values[i] + rate(a, i) * (0.5 * length);
    let back = b.values[j] - rate(b, j) * (0.5 * length);
    (ahead - back).norm()
}

/// Matches by repeatedly joining the closest pair (both spectra are small).
pub(crate) fn assign(a: &Spectrum, b: &Spectrum, length: f64) -> Vec<Pair> {
    let n = a.values.len().min(b.values.len());
    let mut costs: Vec<(f64, usize, usize)> = Vec::with_capacity(n * n);
    for i in 0..a.values.len() {
        for j in 0..b.values.len() {
            costs.push((cost(a, i, b, j, length), i, j));
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
        pairs.push(Pair { from: *i, to: *j, ambiguous: rival && *c > 1e-9 * (1.0 + a.values[*i].norm()) });
    }
    pairs.sort_by_key(|p| p.from);
    pairs
}
