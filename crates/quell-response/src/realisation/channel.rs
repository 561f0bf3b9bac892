//! One input and one output of the first-order form.

use num_complex::Complex64;

use super::StateSpace;
use crate::assembly::{Assembly, OutputTerm};
use crate::dense::{Dense, Scalar};
use crate::error::ResponseError;

/// One input, one output: H(s) = c (s I - A)^-1 b + Σ d_k s^k.
#[derive(Debug, Clone)]
pub(crate) struct Channel<T> {
    pub(crate) a: Dense<T>,
    pub(crate) b: Vec<T>,
    pub(crate) c: Vec<T>,
    pub(crate) d: Vec<T>,
}

impl<T: Scalar> StateSpace<T> {
    pub(crate) fn channel(
        &self,
        assembly: &Assembly,
        values: &[f64],
        input: usize,
        terms: &[OutputTerm],
    ) -> Result<Channel<T>, ResponseError> {
        let states = self.a.rows();
        let b: Vec<T> = (0..states).map(|i| self.b.get(i, input)).collect();
        let mut c = vec![T::ZERO; states];
        let mut d: Vec<T> = vec![T::ZERO; 3];
        for term in terms {
            let weight = term.coefficient * term.value.map_or(1.0, |index| values[index]);
            let map = &self.z[term.order];
            for &(i, factor) in &term.row.coordinates {
                for (entry, value) in c.iter_mut().zip(map.state.row(i)) {
                    *entry += *value * (factor * weight);
                }
                for (k, block) in map.input.iter().enumerate() {
                    if d.len() <= k {
                        d.push(T::ZERO);
                    }
                    d[k] += block.get(i, input) * (factor * weight);
                }
            }
            d[term.order] += T::real(term.row.input(input) * weight);
        }
        let mut channel = Channel {
            a: self.a.clone(),
            b,
            c,
            d,
        };
        for _ in 0..assembly.host.inputs[input].kind.integrations() {
            channel.integrate_input(assembly, input)?;
        }
        while channel.d.len() > 1 && channel.d.last().is_some_and(|last| last.modulus() == 0.0) {
            channel.d.pop();
        }
        Ok(channel)
    }
}

impl<T: Scalar> Channel<T> {
    /// H(s)/s: the state is shifted by the static solution, whose output must vanish.
    fn integrate_input(&mut self, assembly: &Assembly, input: usize) -> Result<(), ResponseError> {
        let n = self.a.rows();
        let right = Dense::from_fn(n, 1, |i, _| self.b[i]);
        let solved = match self.a.lu().filter(|lu| lu.pivot_ratio() > 1e-13) {
            Some(lu) => lu.solve(&right),
            None => least_squares(&self.a, &right),
        };
        let remainder = self.a.times(&solved).minus(&right);
        let static_response: T = solved
            .data()
            .iter()
            .zip(&self.c)
            .fold(self.d[0], |sum, (&x, &c)| sum - c * x);
        // What it is measured against: the terms that cancel, and the response at the system's own frequencies.
        let terms: f64 = solved
            .data()
            .iter()
            .zip(&self.c)
            .map(|(x, c)| (*x * *c).modulus())
            .sum();
        let norm = self.a.norm();
        let response = [1.0, 1e-1, 1e-2, 1e-3]
            .iter()
            .filter_map(|share| self.response(share * norm))
            .fold(0.0_f64, |largest, h| largest.max(h.norm()));
        let size = terms.max(self.d[0].modulus()).max(response);
        // Rounding leaves about 1e-13 of it; a true drift is a sizeable part.
        if static_response.modulus() > 1e-8 * size || remainder.largest() > 1e-8 * right.largest() {
            return Err(ResponseError::PoleAtZero {
                host: assembly.host.name.clone(),
                input: assembly.host.inputs[input].name.clone(),
                residue: static_response.modulus(),
            });
        }
        self.b = solved.data().to_vec();
        self.d.remove(0);
        if self.d.is_empty() {
            self.d.push(T::ZERO);
        }
        Ok(())
    }

    /// H(jω) by one LU.
    pub(crate) fn response(&self, omega: f64) -> Option<Complex64> {
        let n = self.a.rows();
        let s = Complex64::new(0.0, omega);
        let matrix = Dense::from_fn(n, n, |i, j| {
            (if i == j { s } else { Complex64::ZERO }) - self.a.get(i, j).complex()
        });
        let x = matrix
            .lu()?
            .solve(&Dense::from_fn(n, 1, |i, _| self.b[i].complex()));
        let dynamic: Complex64 = x
            .data()
            .iter()
            .zip(&self.c)
            .map(|(x, c)| x * c.complex())
            .sum();
        Some(dynamic + self.polynomial(s))
    }

    pub(crate) fn polynomial(&self, s: Complex64) -> Complex64 {
        self.d
            .iter()
            .rev()
            .fold(Complex64::ZERO, |sum, d| sum * s + d.complex())
    }
}

/// Least squares of a singular square system, by the pseudo-inverse of the complex matrix.
fn least_squares<T: Scalar>(matrix: &Dense<T>, right: &Dense<T>) -> Dense<T> {
    // Tikhonov-free: solve on the pivot rows and columns that elimination with complete pivoting finds.
    let n = matrix.rows();
    let mut work = matrix.clone();
    let mut rhs = right.clone();
    let mut columns: Vec<usize> = (0..n).collect();
    let mut rank = n;
    let cut = 1e-12 * matrix.largest();
    for k in 0..n {
        let mut best = (0.0, k, k);
        for i in k..n {
            for j in k..n {
                let size = work.get(i, columns[j]).modulus();
                if size > best.0 {
                    best = (size, i, j);
                }
            }
        }
        if best.0 <= cut {
            rank = k;
            break;
        }
        columns.swap(k, best.2);
        for j in 0..n {
            let (upper, lower) = (work.get(k, j), work.get(best.1, j));
            work.set(k, j, lower);
            work.set(best.1, j, upper);
        }
        let (upper, lower) = (rhs.get(k, 0), rhs.get(best.1, 0));
        rhs.set(k, 0, lower);
        rhs.set(best.1, 0, upper);
        for i in k + 1..n {
            let factor = work.get(i, columns[k]) / work.get(k, columns[k]);
            for &j in &columns[k..] {
                let value = work.get(k, j);
                work.add(i, j, -(factor * value));
            }
            let value = rhs.get(k, 0);
            rhs.add(i, 0, -(factor * value));
        }
    }
    let mut x = Dense::zeros(n, 1);
    for k in (0..rank).rev() {
        let mut value = rhs.get(k, 0);
        for &j in &columns[k + 1..rank] {
            value -= work.get(k, j) * x.get(j, 0);
        }
        x.set(columns[k], 0, value / work.get(k, columns[k]));
    }
    x
}
