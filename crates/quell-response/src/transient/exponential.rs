//! Matrix exponentials, and tables of them along a step.

use crate::dense::Dense;
use crate::eigen::balance;

/// Terms of the exponential series: with ‖A‖₁ ≤ 1 the first one left out is 1/19! = 8e-18.
const TERMS: usize = 18;

fn norm(matrix: &[f64], n: usize) -> f64 {
    (0..n)
        .map(|j| (0..n).map(|i| matrix[i * n + j].abs()).sum())
        .fold(0.0, f64::max)
}

fn balanced(matrix: &[f64], n: usize) -> (Vec<f64>, Vec<f64>) {
    let (balanced, scale) = balance(&Dense::from_fn(n, n, |i, j| matrix[i * n + j]));
    (balanced.data().to_vec(), scale)
}

/// An affine map x → E x + e, kept as n rows of n + 1 numbers.
fn compose(first: &[f64], second: &[f64], n: usize, out: &mut [f64]) {
    let m = n + 1;
    for i in 0..n {
        let row = &second[i * m..(i + 1) * m];
        let out = &mut out[i * m..(i + 1) * m];
        out[..n].fill(0.0);
        out[n] = row[n];
        for (factor, through) in row.iter().zip(first.chunks_exact(m)) {
            for (out, value) in out.iter_mut().zip(through) {
                *out += factor * value;
            }
        }
    }
}

/// Terms h^j A^j / j! of the flow of x' = A x + b over h: maps of n rows and n + 1 columns, j from 0 to [`TERMS`].
fn terms(a: &[f64], b: &[f64], n: usize, h: f64) -> Vec<Vec<f64>> {
    let m = n + 1;
    let mut terms = Vec::with_capacity(TERMS + 1);
    let mut identity = vec![0.0; n * m];
    let mut first = vec![0.0; n * m];
    for i in 0..n {
        identity[i * m + i] = 1.0;
        for j in 0..n {
            first[i * m + j] = h * a[i * n + j];
        }
        first[i * m + n] = h * b[i];
    }
    terms.push(identity);
    terms.push(first);
    for order in 2..=TERMS {
        let last = &terms[order - 1];
        let mut next = vec![0.0; n * m];
        let factor = h / order as f64;
        for i in 0..n {
            let out = &mut next[i * m..(i + 1) * m];
            for (entry, row) in a[i * n..(i + 1) * n].iter().zip(last.chunks_exact(m)) {
                if *entry != 0.0 {
                    let entry = factor * entry;
                    for (out, value) in out.iter_mut().zip(row) {
                        *out += entry * value;
                    }
                }
            }
        }
        terms.push(next);
    }
    terms
}

/// Σ c^j terms_j, small terms first.
fn series(terms: &[Vec<f64>], c: f64) -> Vec<f64> {
    let mut sum = vec![0.0; terms[0].len()];
    for term in terms.iter().rev() {
        for (sum, value) in sum.iter_mut().zip(term) {
            *sum = *sum * c + value;
        }
    }
    sum
}

/// e^A of a square matrix (row-major, n × n).
///
/// Balanced by powers of two, scaled by a power of two to ‖A‖₁ ≤ 1, summed to 18 terms, squared back (N. J. Higham,
/// Functions of Matrices, 2008, section 10.3). Relative error in norm about 1e-15 times the number of squarings for matrices
/// that are not far from normal. Overflow gives infinities; a matrix with NaN gives NaN.
///
/// ```
/// use quell_response::transient::matrix_exponential;
/// let rotation = matrix_exponential(&[0.0, 1.0, -1.0, 0.0], 2);
/// assert!((rotation[1] - 1f64.sin()).abs() < 1e-15);
/// ```
pub fn matrix_exponential(matrix: &[f64], size: usize) -> Vec<f64> {
    let n = size;
    if !matrix.iter().all(|value| value.is_finite()) {
        return vec![f64::NAN; n * n];
    }
    let (a, scale) = balanced(matrix, n);
    let squarings = halvings(norm(&a, n));
    let h = (-f64::from(squarings)).exp2();
    let mut map = series(&terms(&a, &vec![0.0; n], n, h), 1.0);
    let mut square = map.clone();
    for _ in 0..squarings {
        compose(&map, &map, n, &mut square);
        std::mem::swap(&mut map, &mut square);
    }
    let mut result = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..n {
            result[i * n + j] = map[i * (n + 1) + j] * scale[i] / scale[j];
        }
    }
    result
}

/// The least k ≥ 0 with size/2^k ≤ 1.
fn halvings(size: f64) -> i32 {
    if size <= 1.0 {
        0
    } else {
        (size.log2().ceil() as i32).clamp(0, 1100)
    }
}

/// The flow of x' = A x + b at the nodes of steps h, 2h, 4h, …: exponentials computed once and squared up the ladder.
///
/// x(t + c h) = e^{Ach} x(t) + ch φ₁(Ach) b.
#[derive(Debug)]
pub(crate) struct Ladder {
    n: usize,
    a: Vec<f64>,
    b: Vec<f64>,
    /// A in balanced coordinates y = x/scale, ‖A‖₁ of it.
    balanced: Vec<f64>,
    scale: Vec<f64>,
    size: f64,
    /// Step of the lowest rung.
    base: f64,
    points: Vec<f64>,
    /// Per rung, the maps at points 1.., one after the other, in the coordinates of x.
    rungs: Vec<Vec<f64>>,
}

impl Ladder {
    /// A ladder whose rungs are `longest`/2^k, down to where ‖A‖ h ≤ 1.
    pub(crate) fn new(a: &[f64], b: &[f64], longest: f64, points: &[f64]) -> Self {
        let n = b.len();
        let (balanced, scale) = balanced(a, n);
        let size = norm(&balanced, n);
        let base = longest * (-f64::from(halvings(size * longest))).exp2();
        Self {
            n,
            a: a.to_vec(),
            b: b.to_vec(),
            balanced,
            scale,
            size,
            base,
            points: points.to_vec(),
            rungs: Vec::new(),
        }
    }

    /// Whether it belongs to this system.
    pub(crate) fn is_of(&self, a: &[f64], b: &[f64]) -> bool {
        self.a == a && self.b == b
    }

    /// Units of the states relative to each other, powers of two.
    pub(crate) fn scale(&self) -> &[f64] {
        &self.scale
    }

    /// Step of a rung.
    pub(crate) fn step(&self, rung: usize) -> f64 {
        self.base * (rung as f64).exp2()
    }

    /// The highest rung with ‖A‖ h ≤ `size`, at least 0.
    pub(crate) fn rung_of_size(&self, size: f64) -> usize {
        let now = self.size * self.base;
        if now > 0.0 && now.is_finite() {
            (size / now).log2().floor().max(0.0) as usize
        } else {
            usize::MAX
        }
    }

    /// Fills node-major states at the points of one step of `rung` from `x`. False where they are not finite.
    pub(crate) fn states(&mut self, rung: usize, x: &[f64], out: &mut [f64]) -> bool {
        while self.rungs.len() <= rung {
            self.climb();
        }
        let (n, m) = (self.n, self.n + 1);
        out[..n].copy_from_slice(x);
        let maps = self.rungs[rung].chunks_exact(n * m);
        for (out, map) in out[n..].chunks_exact_mut(n).zip(maps) {
            for (out, row) in out.iter_mut().zip(map.chunks_exact(m)) {
                let mut sum = row[n];
                for (entry, value) in row.iter().zip(x) {
                    sum += entry * value;
                }
                *out = sum;
            }
        }
        out.iter().all(|value| value.is_finite())
    }

    fn climb(&mut self) {
        let (n, m) = (self.n, self.n + 1);
        let maps = self.points.len() - 1;
        let mut rung = vec![0.0; maps * n * m];
        if let Some(last) = self.rungs.last() {
            for (out, map) in rung.chunks_exact_mut(n * m).zip(last.chunks_exact(n * m)) {
                compose(map, map, n, out);
            }
        } else {
            let b: Vec<f64> = self.b.iter().zip(&self.scale).map(|(b, d)| b / d).collect();
            let terms = terms(&self.balanced, &b, n, self.base);
            for (out, &c) in rung.chunks_exact_mut(n * m).zip(&self.points[1..]) {
                let map = series(&terms, c);
                for i in 0..n {
                    for j in 0..n {
                        out[i * m + j] = map[i * m + j] * self.scale[i] / self.scale[j];
                    }
                    out[i * m + n] = map[i * m + n] * self.scale[i];
                }
            }
        }
        self.rungs.push(rung);
    }
}
