//! Right-hand sides written once and differentiated exactly by nilpotent numbers.
#![allow(
    dead_code,
    unreachable_pub,
    clippy::needless_range_loop,
    clippy::suspicious_arithmetic_impl
)]

pub mod models;

use std::ops::{Add, Div, Mul, Neg, Sub};

use quell_continuation::Problem;

/// Numbers that a right-hand side may be evaluated with.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + From<f64>
{
    /// The function with these derivatives of order 0 … 3 at the value.
    fn lift(self, f: impl Fn(f64) -> [f64; 4]) -> Self;
    fn exp(self) -> Self {
        self.lift(|x| [x.exp(); 4])
    }
    fn sin(self) -> Self {
        self.lift(|x| [x.sin(), x.cos(), -x.sin(), -x.cos()])
    }
    fn cos(self) -> Self {
        self.lift(|x| [x.cos(), -x.sin(), -x.cos(), x.sin()])
    }
    fn sqrt(self) -> Self {
        self.lift(|x| {
            [
                x.sqrt(),
                0.5 * x.powf(-0.5),
                -0.25 * x.powf(-1.5),
                0.375 * x.powf(-2.5),
            ]
        })
    }
    fn inverse(self) -> Self {
        self.lift(|x| {
            [
                1.0 / x,
                -1.0 / (x * x),
                2.0 / (x * x * x),
                -6.0 / (x * x * x * x),
            ]
        })
    }
    fn tanh(self) -> Self {
        let e = (self * Self::from(2.0)).exp();
        let one = Self::from(1.0);
        (e - one) / (e + one)
    }
    fn cosh(self) -> Self {
        (self.exp() + (-self).exp()) * Self::from(0.5)
    }
    fn square(self) -> Self {
        self * self
    }
    fn cube(self) -> Self {
        self * self * self
    }
}

impl Real for f64 {
    fn lift(self, f: impl Fn(f64) -> [f64; 4]) -> Self {
        f(self)[0]
    }
    fn exp(self) -> Self {
        f64::exp(self)
    }
}

/// A number with log2(L) infinitesimals of square zero; coefficient k belongs to the product of those in the bits of k.
#[derive(Clone, Copy, Debug)]
pub struct Nil<const L: usize>(pub [f64; L]);

impl<const L: usize> From<f64> for Nil<L> {
    fn from(x: f64) -> Self {
        let mut out = [0.0; L];
        out[0] = x;
        Self(out)
    }
}
impl<const L: usize> Add for Nil<L> {
    type Output = Self;
    fn add(mut self, o: Self) -> Self {
        for k in 0..L {
            self.0[k] += o.0[k];
        }
        self
    }
}
impl<const L: usize> Sub for Nil<L> {
    type Output = Self;
    fn sub(mut self, o: Self) -> Self {
        for k in 0..L {
            self.0[k] -= o.0[k];
        }
        self
    }
}
impl<const L: usize> Neg for Nil<L> {
    type Output = Self;
    fn neg(mut self) -> Self {
        for k in 0..L {
            self.0[k] = -self.0[k];
        }
        self
    }
}
impl<const L: usize> Mul for Nil<L> {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        let mut out = [0.0; L];
        for i in 0..L {
            for j in 0..L {
                if i & j == 0 {
                    out[i | j] += self.0[i] * o.0[j];
                }
            }
        }
        Self(out)
    }
}
impl<const L: usize> Div for Nil<L> {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        self * o.inverse()
    }
}
impl<const L: usize> Real for Nil<L> {
    fn lift(self, f: impl Fn(f64) -> [f64; 4]) -> Self {
        let d = f(self.0[0]);
        let mut n = self;
        n.0[0] = 0.0;
        let n2 = n * n;
        let n3 = n2 * n;
        let mut out = Self::from(d[0]);
        for k in 1..L {
            out.0[k] = d[1] * n.0[k] + 0.5 * d[2] * n2.0[k] + d[3] / 6.0 * n3.0[k];
        }
        out
    }
}

/// A number with its gradient by N variables.
#[derive(Clone, Copy, Debug)]
pub struct Grad<const N: usize>(pub f64, pub [f64; N]);

impl<const N: usize> From<f64> for Grad<N> {
    fn from(x: f64) -> Self {
        Self(x, [0.0; N])
    }
}
impl<const N: usize> Add for Grad<N> {
    type Output = Self;
    fn add(mut self, o: Self) -> Self {
        self.0 += o.0;
        for k in 0..N {
            self.1[k] += o.1[k];
        }
        self
    }
}
impl<const N: usize> Sub for Grad<N> {
    type Output = Self;
    fn sub(mut self, o: Self) -> Self {
        self.0 -= o.0;
        for k in 0..N {
            self.1[k] -= o.1[k];
        }
        self
    }
}
impl<const N: usize> Neg for Grad<N> {
    type Output = Self;
    fn neg(mut self) -> Self {
        self.0 = -self.0;
        for k in 0..N {
            self.1[k] = -self.1[k];
        }
        self
    }
}
impl<const N: usize> Mul for Grad<N> {
    type Output = Self;
    fn mul(mut self, o: Self) -> Self {
        for k in 0..N {
            self.1[k] = self.1[k] * o.0 + self.0 * o.1[k];
        }
        self.0 *= o.0;
        self
    }
}
impl<const N: usize> Div for Grad<N> {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        self * o.inverse()
    }
}
impl<const N: usize> Real for Grad<N> {
    fn lift(mut self, f: impl Fn(f64) -> [f64; 4]) -> Self {
        let d = f(self.0);
        self.0 = d[0];
        for k in 0..N {
            self.1[k] *= d[1];
        }
        self
    }
}

/// An equation to be evaluated with any numbers.
pub trait Field: Sync {
    const N: usize;
    const P: usize;
    /// Names which states are angles; none by default.
    fn f<R: Real>(&self, t: R, x: &[R], p: &[R], out: &mut [R]);
    fn period(&self, _p: &[f64]) -> Option<f64> {
        None
    }
    fn period_derivative(&self, _p: &[f64], _k: usize) -> f64 {
        0.0
    }
}

/// A field with exact derivatives; G is its number of states.
pub struct Exact<F, const G: usize>(pub F);

/// As many parameters as most equations have are room enough for them: what is cleared for more would be seen in benchmarks.
fn run<F: Field, R: Real, const G: usize>(
    field: &F,
    t: R,
    x: impl Fn(usize) -> R,
    p: impl Fn(usize) -> R,
    take: impl FnMut(usize, R),
) {
    if F::P <= 3 {
        run_with::<F, R, G, 3>(field, t, x, p, take);
    } else {
        run_with::<F, R, G, 24>(field, t, x, p, take);
    }
}

fn run_with<F: Field, R: Real, const G: usize, const P: usize>(
    field: &F,
    t: R,
    x: impl Fn(usize) -> R,
    p: impl Fn(usize) -> R,
    mut take: impl FnMut(usize, R),
) {
    let zero = R::from(0.0);
    let (mut xs, mut ps, mut out) = ([zero; G], [zero; P], [zero; G]);
    for (i, v) in xs[..F::N].iter_mut().enumerate() {
        *v = x(i);
    }
    for (i, v) in ps[..F::P].iter_mut().enumerate() {
        *v = p(i);
    }
    field.f(t, &xs[..F::N], &ps[..F::P], &mut out[..F::N]);
    for (i, v) in out[..F::N].iter().enumerate() {
        take(i, *v);
    }
}

impl<F: Field, const G: usize> Problem for Exact<F, G> {
    fn states(&self) -> usize {
        F::N
    }
    fn parameters(&self) -> usize {
        F::P
    }
    fn value(&self, t: f64, x: &[f64], p: &[f64], out: &mut [f64]) {
        self.0.f(t, x, p, out);
    }
    fn jacobian(&self, t: f64, x: &[f64], p: &[f64], out: &mut [f64]) {
        let lift = |i: usize| {
            let mut g = Grad::<G>::from(x[i]);
            g.1[i] = 1.0;
            g
        };
        run::<_, _, G>(
            &self.0,
            Grad::<G>::from(t),
            lift,
            |i| Grad::from(p[i]),
            |i, v: Grad<G>| {
                out[i * F::N..(i + 1) * F::N].copy_from_slice(&v.1[..F::N]);
            },
        );
    }
    fn parameter_derivative(&self, t: f64, x: &[f64], p: &[f64], k: usize, out: &mut [f64]) {
        let at = |i: usize| Nil::<2>([p[i], f64::from(u8::from(i == k))]);
        run::<_, _, G>(
            &self.0,
            Nil::<2>::from(t),
            |i| Nil::from(x[i]),
            at,
            |i, v: Nil<2>| out[i] = v.0[1],
        );
    }
    fn time_derivative(&self, t: f64, x: &[f64], p: &[f64], out: &mut [f64]) {
        run::<_, _, G>(
            &self.0,
            Nil::<2>([t, 1.0]),
            |i| Nil::from(x[i]),
            |i| Nil::from(p[i]),
            |i, v: Nil<2>| out[i] = v.0[1],
        );
    }
    fn period(&self, p: &[f64]) -> Option<f64> {
        self.0.period(p)
    }
    fn period_derivative(&self, p: &[f64], k: usize) -> f64 {
        self.0.period_derivative(p, k)
    }
    fn second(&self, t: f64, x: &[f64], p: &[f64], u: &[f64], v: &[f64], out: &mut [f64]) -> bool {
        let at = |i: usize| Nil::<4>([x[i], u[i], v[i], 0.0]);
        run::<_, _, G>(
            &self.0,
            Nil::<4>::from(t),
            at,
            |i| Nil::from(p[i]),
            |i, v: Nil<4>| out[i] = v.0[3],
        );
        true
    }
    fn third(
        &self,
        t: f64,
        x: &[f64],
        p: &[f64],
        u: &[f64],
        v: &[f64],
        w: &[f64],
        out: &mut [f64],
    ) -> bool {
        let at = |i: usize| Nil::<8>([x[i], u[i], v[i], 0.0, w[i], 0.0, 0.0, 0.0]);
        run::<_, _, G>(
            &self.0,
            Nil::<8>::from(t),
            at,
            |i| Nil::from(p[i]),
            |i, v: Nil<8>| out[i] = v.0[7],
        );
        true
    }
}

/// Classical Runge-Kutta, to reach an attractor in tests: (times, states) of the last `keep` steps.
pub fn integrate(
    problem: &dyn Problem,
    x0: &[f64],
    p: &[f64],
    h: f64,
    steps: usize,
    keep: usize,
) -> (Vec<f64>, Vec<Vec<f64>>) {
    let n = x0.len();
    let mut x = x0.to_vec();
    let (mut times, mut states) = (Vec::new(), Vec::new());
    let mut k = vec![vec![0.0; n]; 4];
    for step in 0..=steps {
        let t = h * step as f64;
        if steps - step < keep || step == steps {
            times.push(t);
            states.push(x.clone());
        }
        for s in 0..4 {
            let c = [0.0, 0.5, 0.5, 1.0][s];
            let y: Vec<f64> = (0..n)
                .map(|i| {
                    if s == 0 {
                        x[i]
                    } else {
                        x[i] + c * h * k[s - 1][i]
                    }
                })
                .collect();
            problem.value(t + c * h, &y, p, &mut k[s]);
        }
        for i in 0..n {
            x[i] += h / 6.0 * (k[0][i] + 2.0 * k[1][i] + 2.0 * k[2][i] + k[3][i]);
        }
    }
    (times, states)
}
