//! Two masses with a strut between them on a tyre, touching down: the struts of Y. Li's thesis (chapter 4; Li, Jiang, Neild and
//! Wang, Journal of Aircraft 54(5), 2017), written by hand as `Dynamics`. Units ft, lbf, s, slug as printed there.

#![allow(
    dead_code,
    reason = "shared by tests and a benchmark, each of which uses a part"
)]

use quell_response::transient::Dynamics;

pub(crate) const G: f64 = 32.18;
pub(crate) const W1: f64 = 2411.0;
pub(crate) const W2: f64 = 131.0;
pub(crate) const KT: f64 = 18500.0;
pub(crate) const V0: f64 = 8.86;

pub(crate) fn cosine() -> f64 {
    12f64.to_radians().cos()
}

pub(crate) const STROKE: usize = 0;
pub(crate) const RATE: usize = 1;
pub(crate) const FORCE: usize = 2;
pub(crate) const UPPER: usize = 3;
pub(crate) const KINETIC: usize = 4;
pub(crate) const TYRE: usize = 5;
pub(crate) const STORED: usize = 6;
pub(crate) const DISSIPATED: usize = 7;
pub(crate) const WEIGHT: usize = 8;
pub(crate) const INERTER: usize = 9;
pub(crate) const SIGNALS: usize = 10;

/// What stands beside the spring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Layout {
    /// ks | c | b (b may be zero).
    Parallel { c: f64, b: f64 },
    /// ks | (b + c): state u, speed of the inerter.
    Series { c: f64, b: f64 },
    /// ks | b | (c + k): state q, force of the branch.
    Branch { c: f64, b: f64, k: f64 },
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Linear {
    pub(crate) layout: Layout,
    /// Slopes of the spring below and above `knee`.
    pub(crate) ks: [f64; 2],
    pub(crate) knee: f64,
}

impl Linear {
    pub(crate) fn new(layout: Layout, ks: f64) -> Self {
        Self {
            layout,
            ks: [ks, ks],
            knee: f64::INFINITY,
        }
    }

    pub(crate) fn double(layout: Layout, ks1: f64, knee: f64) -> Self {
        let (sst, fst) = (0.504_660, 2464.86);
        Self {
            layout,
            ks: [ks1, (fst - ks1 * knee) / (sst - knee)],
            knee,
        }
    }

    pub(crate) fn start(&self) -> Vec<f64> {
        let mut x = vec![0.0, 0.0, V0, V0];
        if !matches!(self.layout, Layout::Parallel { .. }) {
            x.push(0.0);
        }
        x
    }

    fn spring(&self, ss: f64) -> (f64, f64) {
        let [k1, k2] = self.ks;
        if ss <= self.knee {
            (k1 * ss, 0.5 * k1 * ss * ss)
        } else {
            let f = k1 * self.knee;
            let over = ss - self.knee;
            (
                f + k2 * over,
                0.5 * k1 * self.knee * self.knee + f * over + 0.5 * k2 * over * over,
            )
        }
    }

    /// Axial force without the inerter across, accelerations, rate of the own state.
    fn solve(&self, x: &[f64]) -> (f64, f64, f64, f64) {
        let c = cosine();
        let (m1, m2) = (W1 / G, W2 / G);
        let ss = (x[0] - x[1]) / c;
        let v = (x[2] - x[3]) / c;
        let (spring, _) = self.spring(ss);
        let (force, across, own) = match self.layout {
            Layout::Parallel { c, b } => (spring + c * v, b, 0.0),
            Layout::Series { c, b } => {
                let f = c * (v - x[4]);
                (spring + f, 0.0, f / b)
            }
            Layout::Branch { c, b, k } => (spring + x[4], b, k * (v - x[4] / c)),
        };
        let n = c * force;
        let (r1, r2) = (-W2 - n, W2 + n - KT * x[1]);
        let determinant = m1 * m2 + across * (m1 + m2);
        let a1 = ((m2 + across) * r1 + across * r2) / determinant;
        let a2 = (across * r1 + (m1 + across) * r2) / determinant;
        (force, a1, a2, own)
    }
}

impl Dynamics for Linear {
    fn states(&self) -> usize {
        if matches!(self.layout, Layout::Parallel { .. }) {
            4
        } else {
            5
        }
    }

    fn rates(&mut self, _t: f64, x: &[f64], rates: &mut [f64]) {
        let (_, a1, a2, own) = self.solve(x);
        rates[0] = x[2];
        rates[1] = x[3];
        rates[2] = a1;
        rates[3] = a2;
        if let Some(rate) = rates.get_mut(4) {
            *rate = own;
        }
    }

    fn signals(&self) -> usize {
        SIGNALS
    }

    fn watch(&mut self, _t: f64, x: &[f64], s: &mut [f64]) {
        let c = cosine();
        let (force, a1, a2, _) = self.solve(x);
        let ss = (x[0] - x[1]) / c;
        let v = (x[2] - x[3]) / c;
        let (_, energy) = self.spring(ss);
        let (across, branch, power, inerter) = match self.layout {
            Layout::Parallel { c, b } => (b, 0.0, c * v * v, 0.0),
            Layout::Series { c, b } => (0.0, 0.0, c * (v - x[4]).powi(2), 0.5 * b * x[4] * x[4]),
            Layout::Branch { c, b, k } => (b, 0.5 * x[4] * x[4] / k, x[4] * x[4] / c, 0.0),
        };
        s[STROKE] = ss;
        s[RATE] = v;
        s[FORCE] = force + across * (a1 - a2) / c;
        s[UPPER] = x[2];
        s[KINETIC] = 0.5 * (W1 * x[2] * x[2] + W2 * x[3] * x[3]) / G;
        s[TYRE] = 0.5 * KT * x[1] * x[1];
        s[STORED] = c * c * (energy + branch);
        s[DISSIPATED] = c * c * power;
        s[WEIGHT] = W2 * ss * c;
        s[INERTER] = c * c * inerter;
    }

    fn switches(&self) -> usize {
        usize::from(self.knee.is_finite())
    }

    fn switch_values(&mut self, _t: f64, x: &[f64], values: &mut [f64]) {
        if let Some(value) = values.first_mut() {
            *value = (x[0] - x[1]) / cosine() - self.knee;
        }
    }

    fn affine(&mut self, _t: f64, x: &[f64], a: &mut [f64], b: &mut [f64]) -> bool {
        // The rates are affine, so columns are differences; the piece is that of x.
        let ss = (x[0] - x[1]) / cosine();
        let slope = self.ks[usize::from(ss > self.knee)];
        let offset = if ss > self.knee {
            (self.ks[0] - self.ks[1]) * self.knee
        } else {
            0.0
        };
        let mut piece = Self::new(self.layout, slope);
        let n = x.len();
        let zero = vec![0.0; n];
        let mut column = vec![0.0; n];
        piece.rates(0.0, &zero, b);
        for j in 0..n {
            let mut unit = zero.clone();
            unit[j] = 1.0;
            piece.rates(0.0, &unit, &mut column);
            for i in 0..n {
                a[i * n + j] = column[i] - b[i];
            }
        }
        // The spring's offset acts as a constant force, by the way that a force goes into the rates.
        if offset != 0.0 {
            let c = cosine();
            let (m1, m2) = (W1 / G, W2 / G);
            let across = match self.layout {
                Layout::Parallel { b, .. } | Layout::Branch { b, .. } => b,
                Layout::Series { .. } => 0.0,
            };
            let determinant = m1 * m2 + across * (m1 + m2);
            b[2] -= c * offset * m2 / determinant;
            b[3] += c * offset * m1 / determinant;
        }
        true
    }
}

/// The strut that is there: gas spring and orifice.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Default;

impl Default {
    pub(crate) fn start() -> Vec<f64> {
        vec![0.0, 0.0, V0, V0]
    }

    fn gas(ss: f64) -> (f64, f64) {
        let (pa0, area, v0, n) = (6264.0, 0.05761, 0.03545, 1.12);
        let rest: f64 = v0 - area * ss;
        let force = pa0 * area * (v0 / rest).powf(n);
        (force, force * n * area / rest)
    }
}

impl Dynamics for Default {
    fn states(&self) -> usize {
        4
    }

    fn rates(&mut self, _t: f64, x: &[f64], rates: &mut [f64]) {
        let c = cosine();
        let v = (x[2] - x[3]) / c;
        let f = c * (339.5 * v * v.abs() + Self::gas((x[0] - x[1]) / c).0);
        rates[0] = x[2];
        rates[1] = x[3];
        rates[2] = (-W2 - f) * G / W1;
        rates[3] = (W2 + f - KT * x[1]) * G / W2;
    }

    fn jacobian(&mut self, _t: f64, x: &[f64], jacobian: &mut [f64]) {
        let c = cosine();
        let v = (x[2] - x[3]) / c;
        let (damping, stiffness) = (679.0 * v.abs(), Self::gas((x[0] - x[1]) / c).1);
        jacobian.fill(0.0);
        jacobian[2] = 1.0;
        jacobian[7] = 1.0;
        for (j, derivative) in [stiffness, -stiffness, damping, -damping]
            .into_iter()
            .enumerate()
        {
            jacobian[8 + j] = -derivative * G / W1;
            jacobian[12 + j] = derivative * G / W2;
        }
        jacobian[13] -= KT * G / W2;
    }

    fn signals(&self) -> usize {
        SIGNALS
    }

    fn watch(&mut self, _t: f64, x: &[f64], s: &mut [f64]) {
        let c = cosine();
        let ss = (x[0] - x[1]) / c;
        let v = (x[2] - x[3]) / c;
        let oil = 339.5 * v * v.abs();
        let gas = Self::gas(ss).0;
        s[STROKE] = ss;
        s[RATE] = v;
        s[FORCE] = oil + gas;
        s[UPPER] = x[2];
        s[KINETIC] = 0.5 * (W1 * x[2] * x[2] + W2 * x[3] * x[3]) / G;
        s[TYRE] = 0.5 * KT * x[1] * x[1];
        // Power into the gas; its integral is the energy stored.
        s[STORED] = c * c * gas * v;
        s[DISSIPATED] = c * c * oil * v;
        s[WEIGHT] = W2 * ss * c;
        s[INERTER] = 0.0;
    }

    fn switches(&self) -> usize {
        1
    }

    fn switch_values(&mut self, _t: f64, x: &[f64], values: &mut [f64]) {
        values[0] = x[2] - x[3];
    }
}
