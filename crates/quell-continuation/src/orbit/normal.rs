//! Normal forms of cycles at a fold, a period doubling or a torus point, on the condensed linearisation.
//!
//! Coefficients of the periodic normal forms of G. Iooss (J. Differential Equations 76, 1988), by the solvability conditions of
//! Kuznetsov, Govaerts, Doedel and Dhooge (SIAM J. Numer. Anal. 43, 2005), their integrals being those of the collocation
//! equations: what is orthogonal to the discrete adjoint is exactly what the discrete equations can be solved for.

use num_complex::Complex64;

use super::bordered::Bordered;
use super::collocation::Collocation;
use crate::curve::{Mode, ReducedPhase, Variation};
use crate::dense::Lu;
use crate::equilibrium::normal::{bilinear, conj};

type C = Complex64;

/// Coefficients of a critical cycle as [`Kind`](crate::Kind) states them, at the linearisation at hand; None where second or third
/// derivatives are not available or a system is singular.
pub(crate) fn coefficients_alone(
    c: &Collocation<'_>,
    bordered: &Bordered,
    phase: &[f64],
    mode: Mode,
    angle: f64,
) -> Option<Vec<f64>> {
    let own = (c.autonomous && mode == Mode::Fold).then(|| ReducedPhase::of(c, bordered, phase));
    let mu = multiplier(mode, angle);
    let mut variation = Variation::default();
    variation.begin(c, bordered, mu, own.as_ref());
    if !variation.solve(c, bordered, mu, own.as_ref()) {
        return None;
    }
    let (found, _) = coefficients(c, bordered, phase, mode, angle, &variation)?;
    Some(found)
}

/// The critical multiplier.
fn multiplier(mode: Mode, angle: f64) -> C {
    match mode {
        Mode::Fold => C::new(1.0, 0.0),
        Mode::Doubling => C::new(-1.0, 0.0),
        Mode::Torus => C::from_polar(1.0, angle),
    }
}

/// The same where the null functions of the linearisation are known, and ⟨w, v⟩ of those, each of unit length: where it
/// vanishes, at strong resonances, the coefficients have poles.
pub(crate) fn coefficients(
    c: &Collocation<'_>,
    bordered: &Bordered,
    phase: &[f64],
    mode: Mode,
    angle: f64,
    variation: &Variation,
) -> Option<(Vec<f64>, C)> {
    let point = Point::new(c, bordered, phase);
    let mu = multiplier(mode, angle);
    let part = |k: usize| -> Vec<f64> {
        let mut out = vec![0.0; c.nodes()];
        if !variation.v[k].is_empty() {
            variation.values(c, &variation.v[k], mu, k, &mut out);
        }
        out
    };
    let mut v: Vec<C> = part(0)
        .into_iter()
        .zip(part(1))
        .map(|(re, im)| C::new(re, im))
        .collect();
    let left: Vec<C> = (0..c.nodes())
        .map(|k| {
            C::new(
                variation.w[0][k],
                variation.w[1].get(k).copied().unwrap_or(0.0),
            )
        })
        .collect();
    // The mean over a period of |v|² is one.
    let size = point.mean_square(&v).sqrt();
    for x in &mut v {
        *x /= size;
    }
    let norm = point.pair(&left, &v);
    let found = match mode {
        Mode::Fold => {
            // v' = A v + σ f: the phase runs by σ slower for each unit of amplitude.
            let sigma = variation.tau / size / c.period;
            let mut source = point.squares(&v)?.0;
            let image = point.image(&v);
            for (s, a) in source.iter_mut().zip(&image) {
                *s = *s * 0.5 + a * sigma;
            }
            // The phase of v does not matter, but its sign does: the largest mean of the normal form is positive.
            vec![(point.pair(&left, &source) / norm).re.abs()]
        }
        Mode::Doubling => {
            // v is real.
            let (h2, a) = point.solve(&point.squares(&v)?.0, C::new(1.0, 0.0))?;
            let mut source = point.cube(&v)?;
            let mixed = point.second(&v, &h2)?;
            let image = point.image(&v);
            for k in 0..source.len() {
                source[k] = source[k] / 6.0 + mixed[k] * 0.5 - image[k] * (0.5 * a);
            }
            vec![(point.pair(&left, &source) / norm).re]
        }
        Mode::Torus => {
            let (square, mean) = point.squares(&v)?;
            let (h20, _) = point.solve(&square, mu * mu)?;
            let (h11, a) = point.solve(&mean, C::new(1.0, 0.0))?;
            let mut source = point.cube(&v)?;
            let one = point.second(&v, &h11)?;
            let two = point.second(&conj(&v), &h20)?;
            let image = point.image(&v);
            for k in 0..source.len() {
                source[k] = source[k] * 0.5 + one[k] + two[k] * 0.5 - image[k] * a;
            }
            let d = point.pair(&left, &source) / norm;
            vec![d.re, d.im]
        }
    };
    let length = left.iter().map(C::norm_sqr).sum::<f64>().sqrt();
    found
        .iter()
        .all(|x| x.is_finite())
        .then_some((found, norm / length))
}

/// The real or imaginary part of something at all Gauss points, unless it vanishes.
type Part = Option<Vec<f64>>;

fn parts(v: &[C]) -> [Part; 2] {
    let part = |of: fn(&C) -> f64| {
        let part: Vec<f64> = v.iter().map(of).collect();
        part.iter().any(|x| *x != 0.0).then_some(part)
    };
    [part(|x| x.re), part(|x| x.im)]
}

/// The linearisation with what every integral needs.
struct Point<'c, 'p> {
    c: &'c Collocation<'p>,
    bordered: &'c Bordered,
    /// The phase condition, where there is one.
    phase: Option<ReducedPhase>,
}

impl<'c, 'p> Point<'c, 'p> {
    fn new(c: &'c Collocation<'p>, bordered: &'c Bordered, phase: &[f64]) -> Self {
        Self {
            c,
            bordered,
            phase: c.autonomous.then(|| ReducedPhase::of(c, bordered, phase)),
        }
    }

    /// (weight of Gauss point, its index) in order.
    fn gauss(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        let m = self.c.rule.m;
        (0..self.c.count()).flat_map(move |i| (0..m).map(move |k| (i * m + k, self.c.step(i))))
    }

    /// Mean over a period of |v|².
    fn mean_square(&self, v: &[C]) -> f64 {
        let (n, m) = (self.c.n, self.c.rule.m);
        self.gauss()
            .map(|(e, h)| {
                let sum: f64 = v[e * n..(e + 1) * n].iter().map(C::norm_sqr).sum();
                h * self.c.rule.gauss[e % m] * sum
            })
            .sum()
    }

    /// ∫⟨w, g⟩ as the collocation equations weigh it.
    fn pair(&self, w: &[C], g: &[C]) -> C {
        let n = self.c.n;
        self.gauss()
            .map(|(e, h)| bilinear(&w[e * n..(e + 1) * n], &g[e * n..(e + 1) * n]) * h)
            .sum()
    }

    /// A v.
    fn image(&self, v: &[C]) -> Vec<C> {
        let n = self.c.n;
        let mut out = Vec::with_capacity(v.len());
        for (e, v) in v.chunks_exact(n).enumerate() {
            let jacobian = &self.c.jacobians[e * n * n..(e + 1) * n * n];
            for row in jacobian.chunks_exact(n) {
                out.push(row.iter().zip(v).map(|(a, v)| v * *a).sum());
            }
        }
        out
    }

    /// D²f\[u, v\] or D³f\[u, v, w\] at every Gauss point.
    fn form(&self, directions: &[&Part]) -> Option<Vec<f64>> {
        let c = self.c;
        let (t, x, p) = (&c.times, &c.states, &c.parameters);
        let mut out = vec![0.0; c.nodes()];
        let known = match directions {
            [Some(u), Some(v)] => c.problem.seconds(t, x, p, u, v, &mut out),
            [Some(u), Some(v), Some(w)] => c.problem.thirds(t, x, p, u, v, w, &mut out),
            // A direction vanishes.
            _ => true,
        };
        known.then_some(out)
    }

    /// B(u, v).
    fn second(&self, u: &[C], v: &[C]) -> Option<Vec<C>> {
        let ([a, b], [c, d]) = (parts(u), parts(v));
        let (ac, bd) = (self.form(&[&a, &c])?, self.form(&[&b, &d])?);
        let (ad, bc) = (self.form(&[&a, &d])?, self.form(&[&b, &c])?);
        let terms = ac.iter().zip(&bd).zip(ad.iter().zip(&bc));
        Some(
            terms
                .map(|((ac, bd), (ad, bc))| C::new(ac - bd, ad + bc))
                .collect(),
        )
    }

    /// B(v, v) and B(v, v̄): by symmetry three real forms hold both.
    fn squares(&self, v: &[C]) -> Option<(Vec<C>, Vec<C>)> {
        let [a, b] = parts(v);
        let (aa, bb, ab) = (
            self.form(&[&a, &a])?,
            self.form(&[&b, &b])?,
            self.form(&[&a, &b])?,
        );
        let own = aa.iter().zip(&bb).zip(&ab);
        let with = aa.iter().zip(&bb);
        Some((
            own.map(|((aa, bb), ab)| C::new(aa - bb, 2.0 * ab))
                .collect(),
            with.map(|(aa, bb)| C::new(aa + bb, 0.0)).collect(),
        ))
    }

    /// C(v, v, v̄): by symmetry four real forms.
    fn cube(&self, v: &[C]) -> Option<Vec<C>> {
        let [a, b] = parts(v);
        let (aaa, abb) = (self.form(&[&a, &a, &a])?, self.form(&[&a, &b, &b])?);
        let (aab, bbb) = (self.form(&[&a, &a, &b])?, self.form(&[&b, &b, &b])?);
        let terms = aaa.iter().zip(&abb).zip(aab.iter().zip(&bbb));
        Some(
            terms
                .map(|((aaa, abb), (aab, bbb))| C::new(aaa + abb, aab + bbb))
                .collect(),
        )
    }

    /// h at Gauss points with h' = A h + g - a f and h(T) = μ h(0), and a: zero but at μ = 1 of an autonomous problem, where it
    /// makes the equation solvable and h is free of the flow.
    fn solve(&self, g: &[C], mu: C) -> Option<(Vec<C>, f64)> {
        let c = self.c;
        let n = c.n;
        let phase = self.phase.as_ref().filter(|_| mu.re == 1.0 && mu.im == 0.0);
        let (size, matrix) = Variation::reduced(c, self.bordered, mu, phase);
        let mut lu = Lu::new();
        if !lu.factor(size, &matrix) {
            return None;
        }
        let mut right = vec![C::default(); size];
        let mut carried = Vec::new();
        // A real equation has a real solution.
        let real = mu.im == 0.0 && g.iter().all(|x| x.im == 0.0);
        for part in 0..if real { 1 } else { 2 } {
            let mut data = vec![0.0; c.nodes()];
            for (e, h) in self.gauss() {
                for k in e * n..(e + 1) * n {
                    data[k] = h * c.period * if part == 0 { g[k].re } else { g[k].im };
                }
            }
            let (mut mids, mut last) = (Vec::new(), vec![0.0; n]);
            c.condensed.forward(&mut data, &mut mids, &mut last);
            let unit = if part == 0 { C::new(1.0, 0.0) } else { C::i() };
            for (r, x) in right.iter_mut().zip(&last) {
                *r += unit * *x;
            }
            if let Some(phase) = phase {
                right[n] -= unit
                    * c.condensed
                        .eliminated(&phase.inner, &phase.mids, &data, &mids);
            }
            carried.push((data, mids));
        }
        lu.solve(&mut right);
        let sigma = right.get(n).copied().unwrap_or_default();
        let mut values = Vec::new();
        for (part, (data, mids)) in carried.iter_mut().enumerate() {
            let take = |x: C| if part == 0 { x.re } else { x.im };
            if phase.is_some() {
                let (column, column_mids, _) = self.bordered.column(0);
                crate::dense::axpy(-take(sigma), column, data);
                crate::dense::axpy(-take(sigma), column_mids, mids);
            }
            let start: Vec<f64> = right[..n].iter().map(|x| take(*x)).collect();
            let end: Vec<f64> = right[..n].iter().map(|x| take(mu * *x)).collect();
            let mut nodes = vec![0.0; c.nodes()];
            c.condensed
                .backward(&start, &end, Some((data, mids)), &mut nodes);
            let wrap: Vec<f64> = end.iter().zip(&start).map(|(b, a)| b - a).collect();
            let mut out = vec![0.0; c.nodes()];
            c.interpolate(&c.rule.values, &nodes, Some(&wrap), &mut out);
            values.push(out);
        }
        let im = if real {
            vec![0.0; c.nodes()]
        } else {
            values.pop()?
        };
        let re = values.pop()?;
        let h = re
            .into_iter()
            .zip(im)
            .map(|(re, im)| C::new(re, im))
            .collect();
        Some((h, -sigma.re / c.period))
    }
}
