//! Motions that nothing pushes back: vectors with A v = 0, and their elimination.
//!
//! With v scaled to v_p = 1 and x = y + v x_p the remaining states have y' = (A - v A_p) y + (b - v b_p) u, where A_p is row p:
//! nothing depends on x_p. Outputs do not either where c v = 0. Dually, where w A = 0 with w_p = 1 and w b = 0, w x keeps its
//! value of zero and x_p = -Σ w_j x_j is eliminated.

use num_complex::Complex64;

use crate::dense::Dense;
use crate::eigen::balance;
use crate::realisation::Channel;

/// A sum counts as zero where its terms are this much larger.
const CANCELLED: f64 = 1e-13;
/// The same for a sum over a null vector, which has roundings of its own.
const UNSEEN: f64 = 1e-10;

/// A square matrix without the motions that nothing pushes back.
pub(super) struct Rest {
    pub(super) a: Dense<f64>,
    removed: Vec<Removed>,
}

/// One such motion.
struct Removed {
    place: usize,
    /// v without its entry v_p = 1.
    motion: Vec<f64>,
    /// Row p of A without its entry p.
    row: Vec<f64>,
}

impl Removed {
    fn expand(&self, rest: Vec<Complex64>, own: Complex64) -> Vec<Complex64> {
        let mut all: Vec<Complex64> = rest
            .into_iter()
            .zip(&self.motion)
            .map(|(y, v)| y + own * *v)
            .collect();
        all.insert(self.place, own);
        all
    }
}

impl Rest {
    /// All states of a mode from the remaining ones.
    pub(super) fn expand(
        &self,
        mut shape: Vec<Complex64>,
        eigenvalue: Complex64,
    ) -> Vec<Complex64> {
        for removed in self.removed.iter().rev() {
            let rate: Complex64 = shape.iter().zip(&removed.row).map(|(y, a)| y * *a).sum();
            shape = removed.expand(shape, rate / eigenvalue);
        }
        shape
    }

    /// The motions themselves, over all states; of a chain (displacement, then velocity) each by itself.
    pub(super) fn drifts(&self) -> Vec<Vec<Complex64>> {
        (0..self.removed.len())
            .map(|last| {
                let rest = self.a.rows() + self.removed.len() - last - 1;
                let mut shape = vec![Complex64::ZERO; rest];
                for (index, removed) in self.removed[..=last].iter().enumerate().rev() {
                    let own = if index == last {
                        Complex64::ONE
                    } else {
                        Complex64::ZERO
                    };
                    shape = removed.expand(shape, own);
                }
                shape
            })
            .collect()
    }
}

/// Takes out every motion with A v = 0, and those that are left then.
pub(super) fn without_drift(a: &Dense<f64>) -> Rest {
    let mut rest = Rest {
        a: a.clone(),
        removed: Vec::new(),
    };
    while let Some(mut motion) = null_vectors(&rest.a).into_iter().next() {
        let place = unit(&mut motion);
        let row = without(rest.a.row(place), place);
        rest.a = reduced(&rest.a, &motion, place);
        motion.remove(place);
        rest.removed.push(Removed { place, motion, row });
    }
    rest
}

/// A channel without motions that its output does not see or its input does not move, and whether others are left.
pub(super) fn seen(mut channel: Channel<f64>) -> (Channel<f64>, bool) {
    loop {
        let motions = null_vectors(&channel.a);
        if motions.is_empty() {
            return (channel, false);
        }
        if let Some(mut motion) = orthogonal(motions, &channel.c) {
            let place = unit(&mut motion);
            let share = channel.b[place];
            for (b, v) in channel.b.iter_mut().zip(&motion) {
                *b -= v * share;
            }
            channel.a = reduced(&channel.a, &motion, place);
            channel.b.remove(place);
            channel.c.remove(place);
            continue;
        }
        let transposed = channel.a.transpose();
        let Some(mut constant) = orthogonal(null_vectors(&transposed), &channel.b) else {
            return (channel, true);
        };
        let place = unit(&mut constant);
        let share = channel.c[place];
        for (c, w) in channel.c.iter_mut().zip(&constant) {
            *c -= w * share;
        }
        channel.a = reduced(&transposed, &constant, place).transpose();
        channel.b.remove(place);
        channel.c.remove(place);
    }
}

/// A - v A_p without row and column p.
fn reduced(a: &Dense<f64>, motion: &[f64], place: usize) -> Dense<f64> {
    let n = a.rows();
    let kept: Vec<usize> = (0..n).filter(|i| *i != place).collect();
    Dense::from_fn(n - 1, n - 1, |i, j| {
        a.get(kept[i], kept[j]) - motion[kept[i]] * a.get(place, kept[j])
    })
}

fn without(row: &[f64], place: usize) -> Vec<f64> {
    let mut row = row.to_vec();
    row.remove(place);
    row
}

/// Scales the largest entry to one; its place.
fn unit(motion: &mut [f64]) -> usize {
    let mut place = 0;
    for (i, entry) in motion.iter().enumerate() {
        if entry.abs() > motion[place].abs() {
            place = i;
        }
    }
    let largest = motion[place];
    for entry in motion.iter_mut() {
        *entry /= largest;
    }
    place
}

/// A combination of vectors whose product with `row` vanishes, if there is one: of two that do not vanish one does.
fn orthogonal(vectors: Vec<Vec<f64>>, row: &[f64]) -> Option<Vec<f64>> {
    let mut other: Option<(Vec<f64>, f64)> = None;
    for vector in vectors {
        let terms = vector.iter().zip(row).map(|(v, c)| v * c);
        let size: f64 = terms.clone().map(f64::abs).sum();
        let product: f64 = terms.sum();
        if product.abs() <= UNSEEN * size {
            return Some(vector);
        }
        match &other {
            None => other = Some((vector, product)),
            Some((first, of_first)) => {
                let share = product / of_first;
                return Some(
                    vector
                        .iter()
                        .zip(first)
                        .map(|(v, first)| v - share * first)
                        .collect(),
                );
            }
        }
    }
    None
}

/// A basis of the null space by elimination with complete pivoting.
///
/// Beside every entry goes the size of what was added up in it, so that zero is told by cancellation and not by smallness:
/// a slow motion beside fast ones is none that nothing pushes back.
fn null_vectors(a: &Dense<f64>) -> Vec<Vec<f64>> {
    let n = a.rows();
    let (mut work, scale) = balance(a);
    let mut size = work.map(f64::abs);
    let mut columns: Vec<usize> = (0..n).collect();
    let mut rank = n;
    for k in 0..n {
        let mut best = (0.0, k, k);
        for i in k..n {
            for j in k..n {
                let entry = work.get(i, columns[j]).abs();
                if entry > best.0 {
                    best = (entry, i, j);
                }
            }
        }
        if best.0 == 0.0 {
            rank = k;
            break;
        }
        columns.swap(k, best.2);
        for j in 0..n {
            for matrix in [&mut work, &mut size] {
                let (upper, lower) = (matrix.get(k, j), matrix.get(best.1, j));
                matrix.set(k, j, lower);
                matrix.set(best.1, j, upper);
            }
        }
        for i in k + 1..n {
            let factor = work.get(i, columns[k]) / work.get(k, columns[k]);
            if factor == 0.0 {
                continue;
            }
            for &j in &columns[k + 1..] {
                let entry = work.get(i, j) - factor * work.get(k, j);
                let terms = size.get(i, j) + factor.abs() * size.get(k, j);
                let cancelled = entry.abs() <= CANCELLED * terms;
                work.set(i, j, if cancelled { 0.0 } else { entry });
                size.set(i, j, terms);
            }
        }
    }
    (rank..n)
        .map(|free| {
            let mut vector = vec![0.0; n];
            vector[columns[free]] = 1.0;
            for k in (0..rank).rev() {
                let rest: f64 = columns[k + 1..]
                    .iter()
                    .map(|&j| work.get(k, j) * vector[j])
                    .sum();
                vector[columns[k]] = -rest / work.get(k, columns[k]);
            }
            for (entry, scale) in vector.iter_mut().zip(&scale) {
                *entry *= scale;
            }
            vector
        })
        .collect()
}
