//! The problems of the reference figures.

use super::{Field, Real};
use std::f64::consts::PI;

macro_rules! r {
    ($x:expr) => {
        R::from($x)
    };
}

/// Aeroelastic typical section with unsteady aerodynamics; parameters U, k_a3.
pub struct Section;
impl Field for Section {
    const N: usize = 6;
    const P: usize = 2;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        let (h, al, w, hd, ad, wd) = (x[0], x[1], x[2], x[3], x[4], x[5]);
        let (u, ka3) = (p[0], p[1]);
        let (b, a, rho, mw, mt, ia, ca, ch) =
            (0.15, -0.5, 1.204, 5.3, 16.9, 0.1724, 0.5628, 14.5756);
        let (ka, ka2, kh, xa) = (54.1162, 751.6, 3529.4, 0.24);
        let (c0, c1, c2, c3, c4) = (1.0, 0.165, 0.0455, 0.335, 0.3);
        let cc: f64 = c0 - c1 - c3;
        let m11 = mt + PI * rho * b * b;
        let m12 = mw * xa * b - a * PI * rho * b * b * b;
        let m22 = ia + PI * (0.125 + a * a) * rho * b * b * b * b;
        let u2 = u * u;
        let u3 = u2 * u;
        let r1 = -((r!(ch) + r!(2.0 * PI * rho * b * cc) * u) * hd
            + r!((1.0 + cc * (1.0 - 2.0 * a)) * PI * rho * b * b) * u * ad
            + r!(2.0 * PI * rho * b * (c1 * c2 + c3 * c4)) * u2 * wd
            + r!(kh) * h
            + r!(2.0 * PI * rho * b * cc) * u2 * al
            + r!(2.0 * PI * rho * c2 * c4 * (c1 + c3)) * u3 * w);
        let r2 = -(r!(-2.0 * PI * (a + 0.5) * rho * b * b * cc) * u * hd
            + (r!(ca) + r!((0.5 - a) * (1.0 - cc * (1.0 + 2.0 * a)) * PI * rho * b * b * b) * u)
                * ad
            - r!(2.0 * PI * rho * b * b * (a + 0.5) * (c1 * c2 + c3 * c4)) * u2 * wd
            + (r!(ka) - r!(2.0 * PI * (0.5 + a) * rho * cc * b * b) * u2) * al
            - r!(2.0 * PI * rho * b * (a + 0.5) * c2 * c4 * (c1 + c3)) * u3 * w
            + r!(ka2) * al * al
            + ka3 * al * al * al);
        let det = m11 * m22 - m12 * m12;
        out[0] = hd;
        out[1] = ad;
        out[2] = wd;
        out[3] = (r!(m22) * r1 - r!(m12) * r2) * r!(1.0 / det);
        out[4] = (r!(m11) * r2 - r!(m12) * r1) * r!(1.0 / det);
        out[5] = hd * r!(1.0 / b) - r!(a - 0.5) * ad - r!((c2 + c4) / b) * u * wd
            + u * al * r!(1.0 / b)
            - r!(c2 * c4 / (b * b)) * u2 * w;
    }
}

/// Van der Pol-Duffing host with a linear absorber; parameters mu1, lam, a3. States q1, q2, q1', q2'.
pub struct Absorber;
impl Field for Absorber {
    const N: usize = 4;
    const P: usize = 3;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        let eps: f64 = 0.05;
        let mu2 = (eps / (1.0 + eps)).sqrt() / 2.0;
        let (mu1, lam, a3) = (p[0], p[1], p[2]);
        let r = r!(2.0 * mu2) * lam * (x[2] - x[3]) + lam * lam * (x[0] - x[1]);
        out[0] = x[2];
        out[1] = x[3];
        out[2] =
            r!(2.0) * mu1 * (r!(1.0) - x[0] * x[0]) * x[2] - x[0] - a3 * x[0].cube() - r!(eps) * r;
        out[3] = r;
    }
}

/// Forced Duffing with a nonlinear tuned absorber; parameters Om, f.
pub struct ForcedAbsorber;
impl Field for ForcedAbsorber {
    const N: usize = 4;
    const P: usize = 2;
    fn f<R: Real>(&self, t: R, x: &[R], p: &[R], out: &mut [R]) {
        let (eps, mu1, a3, lam, mu2, b3) = (
            0.05,
            0.001,
            1.0,
            0.952_372_044_34,
            0.133_937_726_52,
            0.083_333_3,
        );
        let d = x[0] - x[1];
        let r = r!(2.0 * mu2 * lam) * (x[2] - x[3]) + r!(lam * lam) * d + r!(b3) * d.cube();
        out[0] = x[2];
        out[1] = x[3];
        out[2] = p[1] * (p[0] * t).cos()
            - r!(2.0 * mu1) * x[2]
            - x[0]
            - r!(a3) * x[0].cube()
            - r!(eps) * r;
        out[3] = r;
    }
    fn period(&self, p: &[f64]) -> Option<f64> {
        Some(2.0 * PI / p[0])
    }
    fn period_derivative(&self, p: &[f64], k: usize) -> f64 {
        if k == 0 {
            -2.0 * PI / (p[0] * p[0])
        } else {
            0.0
        }
    }
}

/// Forced Duffing x'' + 2 zeta x' + x + x^3 = F cos(Om t); parameters Om, F, zeta.
pub struct Duffing;
impl Field for Duffing {
    const N: usize = 2;
    const P: usize = 3;
    fn f<R: Real>(&self, t: R, x: &[R], p: &[R], out: &mut [R]) {
        out[0] = x[1];
        out[1] = p[1] * (p[0] * t).cos() - r!(2.0) * p[2] * x[1] - x[0] - x[0].cube();
    }
    fn period(&self, p: &[f64]) -> Option<f64> {
        Some(2.0 * PI / p[0])
    }
    fn period_derivative(&self, p: &[f64], k: usize) -> f64 {
        if k == 0 {
            -2.0 * PI / (p[0] * p[0])
        } else {
            0.0
        }
    }
}

/// x' = y, y' = z, z' = -al z - be y - x + x^2; parameters al, be.
pub struct Feedback;
impl Field for Feedback {
    const N: usize = 3;
    const P: usize = 2;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        out[0] = x[1];
        out[1] = x[2];
        out[2] = -(p[0] * x[2]) - p[1] * x[1] - x[0] + x[0] * x[0];
    }
}

/// CO oxidation; parameters q2, k.
pub struct Oxidation;
impl Field for Oxidation {
    const N: usize = 3;
    const P: usize = 2;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        let z = r!(1.0) - x[0] - x[1] - x[2];
        let xy = r!(10.0) * x[0] * x[1];
        out[0] = r!(5.0) * z * z - r!(2.0) * x[0] * x[0] - xy;
        out[1] = p[0] * z - r!(0.1) * x[1] - xy;
        out[2] = r!(0.0675) * (z - p[1] * x[2]);
    }
}

/// Lorenz-84 with four states; parameters F, T.
pub struct Lorenz84;
impl Field for Lorenz84 {
    const N: usize = 4;
    const P: usize = 2;
    fn f<R: Real>(&self, _t: R, s: &[R], p: &[R], out: &mut [R]) {
        let (al, be, g, de, ga) = (0.25, 1.0, 0.25, 1.04, 0.987);
        let (x, y, z, v) = (s[0], s[1], s[2], s[3]);
        out[0] = -(y * y) - z * z - r!(al) * x + r!(al) * p[0] - r!(ga) * v * v;
        out[1] = x * y - r!(be) * x * z - y + r!(g);
        out[2] = r!(be) * x * y + x * z - z;
        out[3] = -(r!(de) * v) + r!(ga) * v * x + p[1];
    }
}

/// Peroxidase-oxidase; parameter k7.
pub struct Peroxidase;
impl Field for Peroxidase {
    const N: usize = 4;
    const P: usize = 1;
    fn f<R: Real>(&self, _t: R, s: &[R], p: &[R], out: &mut [R]) {
        let (k1, k2, k3, k4, k5, k6, km7, k8) = (
            0.163_102_1,
            1250.0,
            0.046_875,
            20.0,
            1.104,
            0.001,
            0.1175,
            0.5,
        );
        let (a, b, x, y) = (s[0], s[1], s[2], s[3]);
        let abx = r!(k1) * a * b * x;
        let aby = r!(k3) * a * b * y;
        out[0] = -abx - aby + p[0] - r!(km7) * a;
        out[1] = -abx - aby + r!(k8);
        out[2] = abx - r!(2.0 * k2) * x * x + r!(2.0) * aby - r!(k4) * x + r!(k6);
        out[3] = -aby + r!(2.0 * k2) * x * x - r!(k5) * y;
    }
}

/// Morris-Lecar; parameter I.
pub struct MorrisLecar;
impl Field for MorrisLecar {
    const N: usize = 2;
    const P: usize = 1;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        let (v, w) = (x[0], x[1]);
        let m = (r!(1.0) + ((v + r!(1.2)) * r!(1.0 / 18.0)).tanh()) * r!(0.5);
        let wi = (r!(1.0) + ((v - r!(2.0)) * r!(1.0 / 30.0)).tanh()) * r!(0.5);
        let rate = ((v - r!(2.0)) * r!(1.0 / 60.0)).cosh();
        out[0] = (p[0]
            - r!(4.4) * m * (v - r!(120.0))
            - r!(8.0) * w * (v + r!(84.0))
            - r!(2.0) * (v + r!(60.0)))
            * r!(0.05);
        out[1] = r!(0.04) * (wi - w) * rate;
    }
}

/// r' = mu r + r^3 - r^5, theta' = 1 in Cartesian coordinates; parameter mu.
pub struct Quintic;
impl Field for Quintic {
    const N: usize = 2;
    const P: usize = 1;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        let s = x[0] * x[0] + x[1] * x[1];
        let g = p[0] + s - s * s;
        out[0] = g * x[0] - x[1];
        out[1] = g * x[1] + x[0];
    }
}

/// Bautin's normal form r' = r (mu + be r^2 + r^4), theta' = 1; parameters mu, be. Fold of cycles at mu = be^2/4.
pub struct Bautin;
impl Field for Bautin {
    const N: usize = 2;
    const P: usize = 2;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        let s = x[0] * x[0] + x[1] * x[1];
        let g = p[0] + p[1] * s + s * s;
        out[0] = g * x[0] - x[1];
        out[1] = g * x[1] + x[0];
    }
}

/// Van der Pol x'' - mu (1 - x^2) x' + x = 0; parameter mu.
pub struct VanDerPol;
impl Field for VanDerPol {
    const N: usize = 2;
    const P: usize = 1;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        out[0] = x[1];
        out[1] = p[0] * (r!(1.0) - x[0] * x[0]) * x[1] - x[0];
    }
}

/// AUTO's `ab`; parameters p1, p2.
pub struct Ab;
impl Field for Ab {
    const N: usize = 2;
    const P: usize = 2;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        let e = p[0] * (r!(1.0) - x[0]) * x[1].exp();
        out[0] = e - x[0];
        out[1] = p[1] * e - x[1] - r!(3.0) * x[1];
    }
}

/// AUTO's `abc`; parameter D.
pub struct Abc;
impl Field for Abc {
    const N: usize = 3;
    const P: usize = 1;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        let (al, be, b, s) = (1.0, 1.55, 8.0, 0.04);
        let e = p[0] * x[2].exp();
        let one = r!(1.0);
        out[0] = e * (one - x[0]) - x[0];
        out[1] = e * (one - x[0] - r!(s) * x[1]) - x[1];
        out[2] = r!(b) * e * (one - x[0] + r!(al * s) * x[1]) - x[2] - r!(be) * x[2];
    }
}

/// Lorenz; parameter rho.
pub struct Lorenz;
impl Field for Lorenz {
    const N: usize = 3;
    const P: usize = 1;
    fn f<R: Real>(&self, _t: R, s: &[R], p: &[R], out: &mut [R]) {
        out[0] = r!(10.0) * (s[1] - s[0]);
        out[1] = s[0] * (p[0] - s[2]) - s[1];
        out[2] = s[0] * s[1] - r!(8.0 / 3.0) * s[2];
    }
}

/// Two coupled pendula with a torque (AUTO's `pen`); parameter I. States phi1, phi2 and their rates.
pub struct Pendula;
impl Field for Pendula {
    const N: usize = 4;
    const P: usize = 1;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        let (ga, ep) = (0.175, 0.1);
        out[0] = x[2];
        out[1] = x[3];
        out[2] = -(r!(ep) * x[2]) - x[0].sin() + p[0] + r!(ga) * (x[1] - x[0]);
        out[3] = -(r!(ep) * x[3]) - x[1].sin() + p[0] + r!(ga) * (x[0] - x[1]);
    }
}

/// AUTO's `tor`; parameter nu.
pub struct Electronic;
impl Field for Electronic {
    const N: usize = 3;
    const P: usize = 1;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        let (be, ga, r, a3, b3) = (0.5, -0.6, 0.6, 0.328_578, 0.933_578);
        let d = x[1] - x[0];
        let cubic = r!(b3) * d.cube();
        out[0] = (-((r!(be) + p[0]) * x[0]) + r!(be) * x[1] - r!(a3) * x[0].cube() + cubic)
            * r!(1.0 / r);
        out[1] = r!(be) * x[0] - r!(be + ga) * x[1] - x[2] - cubic;
        out[2] = x[1];
    }
}

/// AUTO's `plp`; parameters rho, S0.
pub struct Enzyme;
impl Field for Enzyme {
    const N: usize = 2;
    const P: usize = 2;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        let (s, a) = (x[0], x[1]);
        let rate = p[0] * s * a / (r!(1.0) + s + r!(0.1) * s * s);
        out[0] = p[1] - s - rate;
        out[1] = r!(0.2) * (r!(500.0) - a) - rate;
    }
}

/// x' = mu + la x - x^3; parameters mu, la.
pub struct CuspForm;
impl Field for CuspForm {
    const N: usize = 1;
    const P: usize = 2;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        out[0] = p[0] + p[1] * x[0] - x[0].cube();
    }
}

/// K / 2 oscillators in a chain, the first of them of van der Pol's kind; parameter mu.
pub struct Chain<const K: usize>;
impl<const K: usize> Field for Chain<K> {
    const N: usize = K;
    const P: usize = 1;
    fn f<R: Real>(&self, _t: R, x: &[R], p: &[R], out: &mut [R]) {
        let k = K / 2;
        for i in 0..k {
            out[i] = x[k + i];
            let left = if i > 0 { x[i - 1] - x[i] } else { r!(0.0) };
            let right = if i + 1 < k { x[i + 1] - x[i] } else { r!(0.0) };
            let damping = if i == 0 {
                p[0] * (r!(1.0) - x[i] * x[i])
            } else {
                r!(-0.05)
            };
            out[k + i] = -x[i] + r!(0.1) * (left + right) + damping * x[k + i];
        }
    }
}
