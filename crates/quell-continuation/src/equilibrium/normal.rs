//! Normal-form coefficients of equilibria. Symbols as in Kuznetsov, Elements of Applied Bifurcation Theory, 2004.

use num_complex::Complex64;

use crate::dense::{Lu, dot, eigenvector, left_eigenvector};
use crate::problem::Problem;

type C = Complex64;

/// Multilinear forms of f at a point, extended to complex vectors.
pub(crate) struct Forms<'a> {
    pub(crate) problem: &'a dyn Problem,
    pub(crate) t: f64,
    pub(crate) x: &'a [f64],
    pub(crate) p: &'a [f64],
}

fn parts(v: &[C]) -> [Vec<f64>; 2] {
    [
        v.iter().map(|c| c.re).collect(),
        v.iter().map(|c| c.im).collect(),
    ]
}

impl Forms<'_> {
    /// B(u, v), or None where second derivatives are not available.
    pub(crate) fn second(&self, u: &[C], v: &[C]) -> Option<Vec<C>> {
        let n = self.x.len();
        let (u, v) = (parts(u), parts(v));
        let mut out = vec![C::default(); n];
        let mut part = vec![0.0; n];
        for (i, a) in u.iter().enumerate() {
            for (j, b) in v.iter().enumerate() {
                if a.iter().all(|x| *x == 0.0) || b.iter().all(|x| *x == 0.0) {
                    continue;
                }
                if !self.problem.second(self.t, self.x, self.p, a, b, &mut part) {
                    return None;
                }
                let unit = C::i().powu((i + j) as u32);
                for (o, x) in out.iter_mut().zip(&part) {
                    *o += unit * *x;
                }
            }
        }
        Some(out)
    }

    /// C(u, v, w), or None where third derivatives are not available.
    pub(crate) fn third(&self, u: &[C], v: &[C], w: &[C]) -> Option<Vec<C>> {
        let n = self.x.len();
        let (u, v, w) = (parts(u), parts(v), parts(w));
        let mut out = vec![C::default(); n];
        let mut part = vec![0.0; n];
        for (i, a) in u.iter().enumerate() {
            for (j, b) in v.iter().enumerate() {
                for (k, c) in w.iter().enumerate() {
                    if [a, b, c].iter().any(|v| v.iter().all(|x| *x == 0.0)) {
                        continue;
                    }
                    if !self
                        .problem
                        .third(self.t, self.x, self.p, a, b, c, &mut part)
                    {
                        return None;
                    }
                    let unit = C::i().powu((i + j + k) as u32);
                    for (o, x) in out.iter_mut().zip(&part) {
                        *o += unit * *x;
                    }
                }
            }
        }
        Some(out)
    }
}

/// Σ `a_i` `b_i`, not conjugated.
pub(crate) fn bilinear(a: &[C], b: &[C]) -> C {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

pub(crate) fn conj(a: &[C]) -> Vec<C> {
    a.iter().map(C::conj).collect()
}

/// (s I - A) as a factorisation.
pub(crate) fn resolvent(n: usize, a: &[f64], s: C) -> Lu<C> {
    let matrix: Vec<C> = (0..n * n)
        .map(|k| {
            if k / n == k % n {
                s - a[k]
            } else {
                C::new(-a[k], 0.0)
            }
        })
        .collect();
    Lu::of(n, &matrix)
}

/// q and w of iω with |q| = 1 and wᵀ q = 1.
pub(crate) fn critical(n: usize, a: &[f64], omega: f64) -> (Vec<C>, Vec<C>) {
    let value = C::new(0.0, omega);
    let q = eigenvector(n, a, value);
    let mut w = left_eigenvector(n, a, value);
    let s = bilinear(&w, &q);
    for w in &mut w {
        *w /= s;
    }
    (q, w)
}

/// First Lyapunov coefficient ½ Re⟨p, C(q, q, q̄) - 2 B(q, A⁻¹ B(q, q̄)) + B(q̄, (2iω - A)⁻¹ B(q, q))⟩.
pub(crate) fn hopf(
    problem: &dyn Problem,
    x: &[f64],
    p: &[f64],
    a: &[f64],
    omega: f64,
) -> Option<f64> {
    let n = x.len();
    let forms = Forms {
        problem,
        t: 0.0,
        x,
        p,
    };
    let (q, w) = critical(n, a, omega);
    let qc = conj(&q);
    let cubic = forms.third(&q, &q, &qc)?;
    // resolvent(0) is (-A)⁻¹, hence the sign.
    let mut h11 = forms.second(&q, &qc)?;
    resolvent(n, a, C::default()).solve(&mut h11);
    let mut h20 = forms.second(&q, &q)?;
    resolvent(n, a, C::new(0.0, 2.0 * omega)).solve(&mut h20);
    let one = forms.second(&q, &h11)?;
    let two = forms.second(&qc, &h20)?;
    let sum: C = (0..n)
        .map(|i| w[i] * (cubic[i] + one[i] * 2.0 + two[i]))
        .sum();
    Some(0.5 * sum.re)
}

/// ½ ⟨p, B(q, q)⟩ with |q| = 1, ⟨p, q⟩ = 1.
pub(crate) fn fold(
    problem: &dyn Problem,
    x: &[f64],
    p: &[f64],
    q: &[f64],
    w: &[f64],
) -> Option<f64> {
    let mut out = vec![0.0; x.len()];
    problem
        .second(0.0, x, p, q, q, &mut out)
        .then(|| 0.5 * dot(w, &out) / dot(w, q))
}

/// Coefficients a and b of a Bogdanov-Takens point, normalised as its curve's documentation states.
pub(crate) fn bogdanov_takens(
    problem: &dyn Problem,
    x: &[f64],
    p: &[f64],
    a: &[f64],
) -> Option<Vec<f64>> {
    let n = x.len();
    let zero = C::default();
    let real = |v: Vec<C>| v.iter().map(|c| c.re).collect::<Vec<f64>>();
    let q0 = real(eigenvector(n, a, zero));
    let p1 = real(left_eigenvector(n, a, zero));
    // [A, p1; q0ᵀ, 0] solves for the generalised vectors.
    let size = n + 1;
    let mut matrix = vec![0.0; size * size];
    for i in 0..n {
        matrix[i * size..i * size + n].copy_from_slice(&a[i * n..(i + 1) * n]);
        matrix[i * size + n] = p1[i];
        matrix[n * size + i] = q0[i];
    }
    let lu = Lu::of(size, &matrix);
    let mut q1 = q0.clone();
    q1.push(0.0);
    lu.solve(&mut q1);
    q1.truncate(n);
    let mut p0 = p1.clone();
    p0.push(0.0);
    lu.solve_transposed(&mut p0);
    p0.truncate(n);
    // ⟨p1, q1⟩ = ⟨p0, q0⟩ holds; scale both to one and make ⟨p0, q1⟩ vanish.
    let scale = dot(&p1, &q1);
    let p1: Vec<f64> = p1.iter().map(|x| x / scale).collect();
    let mut p0: Vec<f64> = p0.iter().map(|x| x / scale).collect();
    let off = dot(&p0, &q1);
    for (a, b) in p0.iter_mut().zip(&p1) {
        *a -= off * b;
    }
    let mut b00 = vec![0.0; n];
    let mut b01 = vec![0.0; n];
    if !(problem.second(0.0, x, p, &q0, &q0, &mut b00)
        && problem.second(0.0, x, p, &q0, &q1, &mut b01))
    {
        return None;
    }
    Some(vec![0.5 * dot(&p1, &b00), dot(&p0, &b00) + dot(&p1, &b01)])
}

/// Right and left null vectors of A, |q| = 1 and wᵀ q = 1.
fn null(n: usize, a: &[f64]) -> (Vec<C>, Vec<C>) {
    let real = |v: Vec<C>| v.iter().map(|c| C::new(c.re, 0.0)).collect::<Vec<C>>();
    let q = real(eigenvector(n, a, C::default()));
    let mut w = real(left_eigenvector(n, a, C::default()));
    let s = bilinear(&w, &q);
    for w in &mut w {
        *w /= s;
    }
    (q, w)
}

/// c of a cusp, dξ/dt = c ξ³: (1/6)⟨p, C(q, q, q) + 3 B(q, h)⟩ with A h = ⟨p, B(q, q)⟩ q - B(q, q), ⟨p, h⟩ = 0.
pub(crate) fn cusp(problem: &dyn Problem, x: &[f64], p: &[f64], a: &[f64]) -> Option<f64> {
    let n = x.len();
    let forms = Forms {
        problem,
        t: 0.0,
        x,
        p,
    };
    let (q, w) = null(n, a);
    let curved = forms.second(&q, &q)?;
    let along = bilinear(&w, &curved);
    // [A, q; wᵀ, 0] is regular and its last unknown vanishes.
    let size = n + 1;
    let mut matrix = vec![C::default(); size * size];
    for i in 0..n {
        for j in 0..n {
            matrix[i * size + j] = C::new(a[i * n + j], 0.0);
        }
        matrix[i * size + n] = q[i];
        matrix[n * size + i] = w[i];
    }
    let mut h: Vec<C> = (0..n).map(|i| along * q[i] - curved[i]).collect();
    h.push(C::default());
    Lu::of(size, &matrix).solve(&mut h);
    h.truncate(n);
    let cubic = forms.third(&q, &q, &q)?;
    let mixed = forms.second(&q, &h)?;
    let sum: C = (0..n).map(|i| w[i] * (cubic[i] + mixed[i] * 3.0)).sum();
    Some(sum.re / 6.0)
}

/// Quadratic coefficients of a zero-Hopf point: ½⟨p₀, B(q₀, q₀)⟩, Re⟨p₁, B(q₀, q₁)⟩, ⟨p₀, B(q₁, q̄₁)⟩.
pub(crate) fn zero_hopf(
    problem: &dyn Problem,
    x: &[f64],
    p: &[f64],
    a: &[f64],
    omega: f64,
) -> Option<Vec<f64>> {
    let n = x.len();
    let forms = Forms {
        problem,
        t: 0.0,
        x,
        p,
    };
    let (q0, w0) = null(n, a);
    let (q1, w1) = critical(n, a, omega);
    Some(vec![
        0.5 * bilinear(&w0, &forms.second(&q0, &q0)?).re,
        bilinear(&w1, &forms.second(&q0, &q1)?).re,
        bilinear(&w0, &forms.second(&q1, &conj(&q1))?).re,
    ])
}

/// Real parts p₁₁, p₁₂, p₂₁, p₂₂ of the cubic coefficients of a Hopf-Hopf point.
pub(crate) fn hopf_hopf(
    problem: &dyn Problem,
    x: &[f64],
    p: &[f64],
    a: &[f64],
    omegas: [f64; 2],
) -> Option<Vec<f64>> {
    let n = x.len();
    let forms = Forms {
        problem,
        t: 0.0,
        x,
        p,
    };
    let modes = omegas.map(|omega| critical(n, a, omega));
    let solved = |mut right: Vec<C>, s: f64| {
        resolvent(n, a, C::new(0.0, s)).solve(&mut right);
        right
    };
    let mut out = Vec::with_capacity(4);
    for (i, (q, w)) in modes.iter().enumerate() {
        for (j, (r, _)) in modes.iter().enumerate() {
            let rc = conj(r);
            // Of its own motion and of the other's.
            let mean = solved(forms.second(r, &rc)?, 0.0);
            let sum = solved(forms.second(q, r)?, omegas[i] + omegas[j]);
            let cubic = forms.third(q, r, &rc)?;
            let one = forms.second(q, &mean)?;
            let two = forms.second(&rc, &sum)?;
            let mut total = bilinear(w, &cubic) + bilinear(w, &one) + bilinear(w, &two);
            if i == j {
                // Both motions that mean and difference belong to are the same one.
                total += bilinear(w, &one);
                total *= 0.5;
            } else {
                let difference = solved(forms.second(q, &rc)?, omegas[i] - omegas[j]);
                total += bilinear(w, &forms.second(r, &difference)?);
            }
            out.push(total.re);
        }
    }
    Some(out)
}
