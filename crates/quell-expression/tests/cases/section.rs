//! An aeroelastic typical section with unsteady aerodynamics: plunge h, pitch al, and a second-order lag w.

use std::f64::consts::PI;

use super::Model;

pub const U: f64 = 17.0;

pub const MODEL: Model = Model {
    coordinates: ["h", "al"],
    states: &[
        ("w", "v"),
        (
            "v",
            "h'/b - (a - 1/2)*al' - (c2 + c4)*(U/b)*v + (U/b)*al - c2*c4*(U/b)^2*w",
        ),
    ],
    parameters: &[
        ("b", 0.15),
        ("a", -0.5),
        ("rho", 1.204),
        ("mw", 5.3),
        ("mT", 16.9),
        ("Ia", 0.1724),
        ("ca", 0.5628),
        ("ch", 14.5756),
        ("ka", 54.1162),
        ("ka2", 751.6),
        ("ka3", 5006.7),
        ("kh", 3529.4),
        ("xa", 0.24),
        ("U", U),
        ("c0", 1.0),
        ("c1", 0.165),
        ("c2", 0.0455),
        ("c3", 0.335),
        ("c4", 0.3),
    ],
    definitions: &[
        ("cc", "c0 - c1 - c3"),
        ("lag", "c1*c2 + c3*c4"),
        ("slow", "c2*c4*(c1 + c3)"),
    ],
    functions: &[],
    residuals: [
        "(mT + pi*rho*b^2)*h'' + (mw*xa*b - a*pi*rho*b^3)*al''
            + (ch + 2*pi*rho*b*U*cc)*h' + (1 + cc*(1 - 2*a))*pi*rho*b^2*U*al' + 2*pi*rho*U^2*b*lag*v
            + kh*h + 2*pi*rho*b*U^2*cc*al + 2*pi*rho*U^3*slow*w",
        "(mw*xa*b - a*pi*rho*b^3)*h'' + (Ia + pi*(1/8 + a^2)*rho*b^4)*al''
            - 2*pi*(a + 1/2)*rho*b^2*cc*U*h' + (ca + (1/2 - a)*(1 - cc*(1 + 2*a))*pi*rho*b^3*U)*al'
            - 2*pi*rho*b^2*U^2*(a + 1/2)*lag*v
            + (ka - 2*pi*(1/2 + a)*rho*cc*b^2*U^2)*al - 2*pi*rho*b*U^3*(a + 1/2)*slow*w
            + ka2*al^2 + ka3*al^3",
    ],
};

/// Parameters of the section.
pub struct Section {
    pub b: f64,
    pub a: f64,
    pub rho: f64,
    pub mw: f64,
    pub mt: f64,
    pub ia: f64,
    pub ca: f64,
    pub ch: f64,
    pub ka: f64,
    pub ka2: f64,
    pub ka3: f64,
    pub kh: f64,
    pub xa: f64,
    pub u: f64,
    pub c: [f64; 5],
}

impl Default for Section {
    fn default() -> Self {
        Self {
            b: 0.15,
            a: -0.5,
            rho: 1.204,
            mw: 5.3,
            mt: 16.9,
            ia: 0.1724,
            ca: 0.5628,
            ch: 14.5756,
            ka: 54.1162,
            ka2: 751.6,
            ka3: 5006.7,
            kh: 3529.4,
            xa: 0.24,
            u: U,
            c: [1.0, 0.165, 0.0455, 0.335, 0.3],
        }
    }
}

/// The right-hand side as one writes it: coefficients from parameters at every call.
#[inline(never)]
pub fn rates(p: &Section, x: &[f64; 6], out: &mut [f64; 6]) {
    let [h, al, dh, dal, w, v] = *x;
    let Section { b, a, rho, u, .. } = *p;
    let [c0, c1, c2, c3, c4] = p.c;
    let cc = c0 - c1 - c3;
    let (lag, slow) = (c1 * c2 + c3 * c4, c2 * c4 * (c1 + c3));
    let pr = PI * rho;
    let m11 = p.mt + pr * b * b;
    let m12 = p.mw * p.xa * b - a * pr * b * b * b;
    let m22 = p.ia + pr * (0.125 + a * a) * b * b * b * b;
    let r1 = (p.ch + 2.0 * pr * b * u * cc) * dh
        + (1.0 + cc * (1.0 - 2.0 * a)) * pr * b * b * u * dal
        + 2.0 * pr * u * u * b * lag * v
        + p.kh * h
        + 2.0 * pr * b * u * u * cc * al
        + 2.0 * pr * u * u * u * slow * w;
    let r2 = -2.0 * pr * (a + 0.5) * b * b * cc * u * dh
        + (p.ca + (0.5 - a) * (1.0 - cc * (1.0 + 2.0 * a)) * pr * b * b * b * u) * dal
        - 2.0 * pr * b * b * u * u * (a + 0.5) * lag * v
        + (p.ka - 2.0 * pr * (0.5 + a) * cc * b * b * u * u) * al
        - 2.0 * pr * b * u * u * u * (a + 0.5) * slow * w
        + p.ka2 * al * al
        + p.ka3 * al * al * al;
    let determinant = m11 * m22 - m12 * m12;
    let ub = u / b;
    *out = [
        dh,
        dal,
        (m12 * r2 - m22 * r1) / determinant,
        (m12 * r1 - m11 * r2) / determinant,
        v,
        dh / b - (a - 0.5) * dal - (c2 + c4) * ub * v + ub * al - c2 * c4 * ub * ub * w,
    ];
}

/// What of the right-hand side stays while states vary.
pub struct Prepared {
    pub mass: [f64; 3],
    pub determinant: f64,
    pub first: [f64; 6],
    pub second: [f64; 8],
    pub lag: [f64; 5],
}

/// Coefficients, once for a set of parameters.
pub fn prepare(p: &Section) -> Prepared {
    let Section { b, a, rho, u, .. } = *p;
    let [c0, c1, c2, c3, c4] = p.c;
    let cc = c0 - c1 - c3;
    let (lag, slow) = (c1 * c2 + c3 * c4, c2 * c4 * (c1 + c3));
    let pr = PI * rho;
    let m11 = p.mt + pr * b * b;
    let m12 = p.mw * p.xa * b - a * pr * b * b * b;
    let m22 = p.ia + pr * (0.125 + a * a) * b * b * b * b;
    Prepared {
        mass: [m11, m12, m22],
        determinant: m11 * m22 - m12 * m12,
        first: [
            p.ch + 2.0 * pr * b * u * cc,
            (1.0 + cc * (1.0 - 2.0 * a)) * pr * b * b * u,
            2.0 * pr * u * u * b * lag,
            p.kh,
            2.0 * pr * b * u * u * cc,
            2.0 * pr * u * u * u * slow,
        ],
        second: [
            2.0 * pr * (a + 0.5) * b * b * cc * u,
            p.ca + (0.5 - a) * (1.0 - cc * (1.0 + 2.0 * a)) * pr * b * b * b * u,
            2.0 * pr * b * b * u * u * (a + 0.5) * lag,
            p.ka - 2.0 * pr * (0.5 + a) * cc * b * b * u * u,
            2.0 * pr * b * u * u * u * (a + 0.5) * slow,
            p.ka2,
            p.ka3,
            0.0,
        ],
        lag: [
            b,
            a - 0.5,
            (c2 + c4) * (u / b),
            u / b,
            c2 * c4 * (u / b) * (u / b),
        ],
    }
}

/// The right-hand side with its coefficients at hand, as hard as one can make it by hand.
#[inline(never)]
pub fn prepared_rates(p: &Prepared, x: &[f64; 6], out: &mut [f64; 6]) {
    let [h, al, dh, dal, w, v] = *x;
    let [m11, m12, m22] = p.mass;
    let (f, s, l) = (&p.first, &p.second, &p.lag);
    let r1 = f[0] * dh + f[1] * dal + f[2] * v + f[3] * h + f[4] * al + f[5] * w;
    let square = al * al;
    let r2 = s[1] * dal - s[0] * dh - s[2] * v + s[3] * al - s[4] * w
        + s[5] * square
        + s[6] * (square * al);
    *out = [
        dh,
        dal,
        (m12 * r2 - m22 * r1) / p.determinant,
        (m12 * r1 - m11 * r2) / p.determinant,
        v,
        dh / l[0] - l[1] * dal - l[2] * v + l[3] * al - l[4] * w,
    ];
}
