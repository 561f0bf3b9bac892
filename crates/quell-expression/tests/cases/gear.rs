//! A two-wheel landing gear that rolls: bending d, torsion p, tyres lL and lR, a spring and damper behind torque links.

use std::f64::consts::PI;

use super::Model;

pub const MODEL: Model = Model {
    coordinates: ["d", "p"],
    states: &[("lL", "lamdot(-1, lL)"), ("lR", "lamdot(1, lR)"), ("e1", "(T - kd*e1)/cd")],
    parameters: &[
        ("a", 0.5), ("cdel", 300.0), ("cpsi", 300.0), ("e", 0.12), ("kdel", 6.1e6), ("kpsi", 3.8e5),
        ("Jxi", 200.0), ("Jeta", 250.0), ("Jzeta", 100.0), ("lD", 0.72), ("ldel", 0.75), ("mD", 500.0),
        ("phi", PI / 60.0), ("h", 0.1), ("kt", 7.0e5), ("kal", 1.0), ("klam", 0.002), ("l", 0.3),
        ("R0", 0.362), ("am", 0.1745), ("kd", 1.09e5), ("g", 9.81), ("W", 200_000.0), ("V", 30.0),
        ("cd", 36_000.0),
    ],
    definitions: &[
        ("mu", "asin(H32)"),
        ("th", "p*cos(phi)*cos(d)"),
        ("H11", "cos(phi)*cos(p) + sin(phi)*sin(d)*sin(p)"),
        ("H12", "sin(phi)*sin(d)*cos(p) - cos(phi)*sin(p)"),
        ("H13", "sin(phi)*cos(d)"),
        ("H21", "cos(d)*sin(p)"),
        ("H22", "cos(d)*cos(p)"),
        ("H23", "-sin(d)"),
        ("H31", "cos(phi)*sin(d)*sin(p) - sin(phi)*cos(p)"),
        ("H32", "sin(phi)*sin(p) + cos(phi)*sin(d)*cos(p)"),
        ("H33", "cos(phi)*cos(d)"),
        ("q", "mD*lD*cos(phi)*sin(d)"),
        ("dJ", "Jxi - Jeta"),
        ("T", "kpsi*(p - e1)"),
    ],
    functions: &[
        ("R(s)", "hold(R0 - 0.1*s*a*mu)"),
        ("x(s)", "-(e + R(s)*sin(phi))"),
        ("w(s)", "ldel + R(s)*cos(phi)"),
        ("X(s)", "H11*x(s) + H12*s*a/2 + H13*w(s)"),
        ("Y(s)", "H21*x(s) + H22*s*a/2 + H23*w(s)"),
        ("Z(s)", "H31*x(s) + H32*s*a/2 + H33*w(s)"),
        ("lamdot(s, lam)", "(V + X(s)')*(sin(th) - lam/l*cos(th)) - Y(s)'*(cos(th) + lam/l*sin(th)) - (h - lam^2/l)*th'"),
        ("u(lam)", "atan(7*lam/l)"),
        ("Lam(lam)", "klam*u(lam)*cos(0.95*u(lam))"),
        ("Ck(lam)", "if abs(atan(lam/l)) <= am then kal*(am/pi)*sin(pi*atan(lam/l)/am) else 0"),
        ("N1(s, lam)", "Lam(lam)*(sin(th)*d(X(s), d) - cos(th)*d(Y(s), d)) + d(Z(s), d) - Ck(lam)*sin(phi)"),
        ("N2(s, lam)", "Lam(lam)*(sin(th)*d(X(s), p) - cos(th)*d(Y(s), p)) + d(Z(s), p) + Ck(lam)*cos(phi)*cos(d)"),
        ("F(s)", "1/2*(s*a*mu*kt + W + mD*lD*cos(phi)*cos(d)*d'^2 + q*d'' + mD*Z(s)'')"),
    ],
    residuals: [
        "(Jeta + dJ*cos(p)^2 + mD*lD^2)*d'' + q*(Z(-1)'' + Z(1)'')/2 - 2*dJ*cos(p)*sin(p)*d'*p' + cdel*d' + kdel*d
            + mD*g*lD*cos(phi)*sin(d) + N1(-1, lL)*F(-1) + N1(1, lR)*F(1)",
        "Jzeta*p'' + dJ*cos(p)*sin(p)*d'^2 + cpsi*p' + T + N2(-1, lL)*F(-1) + N2(1, lR)*F(1)",
    ],
};

/// Parameters of the gear, by the names of [`MODEL`].
pub struct Gear {
    values: [f64; 25],
    sine: f64,
    cosine: f64,
}

impl Default for Gear {
    fn default() -> Self {
        let values: [f64; 25] = std::array::from_fn(|index| MODEL.parameters[index].1);
        Self {
            values,
            sine: values[12].sin(),
            cosine: values[12].cos(),
        }
    }
}

/// The right-hand side by hand: point kinematics written out, the 2 by 2 system collected.
/// States [d, p, d', p', lL, lR, e1].
#[inline(never)]
pub fn rates(gear: &Gear, states: &[f64; 7], out: &mut [f64; 7]) {
    let [d, p, dd, dp, ll, lr, e1] = *states;
    let [
        a,
        cdel,
        cpsi,
        e,
        kdel,
        kpsi,
        jxi,
        jeta,
        jzeta,
        ld,
        ldel,
        md,
        _,
        h,
        kt,
        kal,
        klam,
        l,
        r0,
        am,
        kd,
        g,
        load,
        v,
        cd,
    ] = gear.values;
    let (s, c) = (gear.sine, gear.cosine);
    let (sd, cod) = d.sin_cos();
    let (sp, cop) = p.sin_cos();
    let h11 = c * cop + s * sd * sp;
    let h12 = s * sd * cop - c * sp;
    let (h21, h22) = (cod * sp, cod * cop);
    let h31 = c * sd * sp - s * cop;
    let h32 = s * sp + c * sd * cop;
    let mu = h32.asin();
    let heading = p * c * cod;
    let (sth, cth) = heading.sin_cos();
    let turning = dp * c * cod - p * c * sd * dd;
    let q = md * ld * c * sd;
    let dj = jxi - jeta;
    let mut mass = [jeta + dj * cop * cop + md * ld * ld, 0.0, 0.0, jzeta];
    let mut rest = [
        -2.0 * dj * cop * sp * dd * dp + cdel * dd + kdel * d + md * g * ld * c * sd,
        dj * cop * sp * dd * dd + cpsi * dp + kpsi * (p - e1),
    ];
    let mut slips = [0.0; 2];
    for (index, (side, lam)) in [(-1.0, ll), (1.0, lr)].into_iter().enumerate() {
        let r = r0 - 0.1 * side * a * mu;
        let (x, y, w) = (-(e + r * s), side * a / 2.0, ldel + r * c);
        let rdx = s * cod * sp * x + s * cod * cop * y - s * sd * w;
        let rdy = -sd * sp * x - sd * cop * y - cod * w;
        let rdz = c * cod * sp * x + c * cod * cop * y - c * sd * w;
        let rpx = h12 * x - h11 * y;
        let rpy = h22 * x - h21 * y;
        let rpz = h32 * x - h31 * y;
        let zdd = -c * sd * sp * x - c * sd * cop * y - c * cod * w;
        let zdp = c * cod * cop * x - c * cod * sp * y;
        let zpp = -h31 * x - h32 * y;
        let zq = zdd * dd * dd + 2.0 * zdp * dd * dp + zpp * dp * dp;
        let u = (7.0 * lam / l).atan();
        let lambda = klam * u * (0.95 * u).cos();
        let alpha = (lam / l).atan();
        let ck = if alpha.abs() <= am {
            kal * (am / PI) * (PI * alpha / am).sin()
        } else {
            0.0
        };
        let n1 = lambda * (sth * rdx - cth * rdy) + rdz - ck * s;
        let n2 = lambda * (sth * rpx - cth * rpy) + rpz + ck * c * cod;
        // F = f0 + fd d'' + fp p''
        let f0 = 0.5 * (side * a * mu * kt + load + md * ld * c * cod * dd * dd + md * zq);
        let (fd, fp) = (0.5 * (q + md * rdz), 0.5 * md * rpz);
        mass[0] += n1 * fd + q * rdz / 2.0;
        mass[1] += n1 * fp + q * rpz / 2.0;
        mass[2] += n2 * fd;
        mass[3] += n2 * fp;
        rest[0] += n1 * f0 + q * zq / 2.0;
        rest[1] += n2 * f0;
        let (vx, vy) = (v + rdx * dd + rpx * dp, rdy * dd + rpy * dp);
        slips[index] =
            vx * (sth - lam / l * cth) - vy * (cth + lam / l * sth) - (h - lam * lam / l) * turning;
    }
    let determinant = mass[0] * mass[3] - mass[1] * mass[2];
    *out = [
        dd,
        dp,
        (mass[1] * rest[1] - mass[3] * rest[0]) / determinant,
        (mass[2] * rest[0] - mass[0] * rest[1]) / determinant,
        slips[0],
        slips[1],
        (kpsi * (p - e1) - kd * e1) / cd,
    ];
}
