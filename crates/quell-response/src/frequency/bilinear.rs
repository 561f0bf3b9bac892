//! The bilinear form of a transfer function with one used port, on the whole grid and at one frequency.

use num_complex::Complex64;
use quell_network::RatioGrid;

use crate::receptance::HostPoint;

/// The host's constants on the grid, as a structure of arrays: a, b, c, e, x0 of the bilinear form.
#[derive(Debug, Clone, Default)]
pub(super) struct Bilinear {
    pub(super) a: [Vec<f64>; 2],
    pub(super) b: [Vec<f64>; 2],
    pub(super) c: [Vec<f64>; 2],
    pub(super) e: [Vec<f64>; 2],
    pub(super) x0: Vec<Complex64>,
}

/// Constants of the bilinear form at one frequency.
#[derive(Debug, Clone, Copy)]
pub(super) struct Constants {
    pub(super) a: Complex64,
    pub(super) b: Complex64,
    pub(super) c: Complex64,
    pub(super) e: Complex64,
    pub(super) x0: Complex64,
}

impl Constants {
    /// a, b, c, e of one port.
    pub(super) fn new(point: &HostPoint, gamma: f64) -> Self {
        let (d, g, x0, alpha) = (point.nominal[0], point.g[0], point.x0[0], point.alpha[0]);
        let e = 1.0 - g * d;
        Self {
            a: point.y0 * g + (gamma - alpha) * x0,
            b: point.y0 * e + alpha * d * x0,
            c: g,
            e,
            x0,
        }
    }
}

/// |H|² and the characteristic factor c N + e Den at every grid point, from Re and Im of N and Den.
pub(super) fn bilinear_sweep(
    host: &Bilinear,
    device: [&[f64]; 4],
    square: &mut [f64],
    factor: &mut [Vec<f64>; 2],
) {
    let count = square.len();
    let [nr, ni, dr, di] = device.map(|list| &list[..count]);
    let (ar, ai) = (&host.a[0][..count], &host.a[1][..count]);
    let (br, bi) = (&host.b[0][..count], &host.b[1][..count]);
    let (cr, ci) = (&host.c[0][..count], &host.c[1][..count]);
    let (er, ei) = (&host.e[0][..count], &host.e[1][..count]);
    let [fr, fi] = factor;
    let (fr, fi) = (&mut fr[..count], &mut fi[..count]);
    for i in 0..count {
        let top_re = ar[i] * nr[i] - ai[i] * ni[i] + br[i] * dr[i] - bi[i] * di[i];
        let top_im = ar[i] * ni[i] + ai[i] * nr[i] + br[i] * di[i] + bi[i] * dr[i];
        let re = cr[i] * nr[i] - ci[i] * ni[i] + er[i] * dr[i] - ei[i] * di[i];
        let im = cr[i] * ni[i] + ci[i] * nr[i] + er[i] * di[i] + ei[i] * dr[i];
        fr[i] = re;
        fi[i] = im;
        square[i] = (top_re * top_re + top_im * top_im) / (re * re + im * im);
    }
}

/// Devices side by side: N = N1 Den2 + N2 Den1, Den = Den1 Den2.
pub(super) fn combine(grids: &[RatioGrid], out: &mut [Vec<f64>; 4]) {
    let count = grids.first().map_or(0, RatioGrid::len);
    for (list, start) in out.iter_mut().zip([0.0, 0.0, 1.0, 0.0]) {
        list.clear();
        list.resize(count, start);
    }
    let [nr, ni, dr, di] = out;
    for grid in grids {
        for i in 0..count {
            let (pn, pd) = (Complex64::new(nr[i], ni[i]), Complex64::new(dr[i], di[i]));
            let on = Complex64::new(grid.numerator_re[i], grid.numerator_im[i]);
            let od = Complex64::new(grid.denominator_re[i], grid.denominator_im[i]);
            let (n, d) = (pn * od + on * pd, pd * od);
            (nr[i], ni[i], dr[i], di[i]) = (n.re, n.im, d.re, d.im);
        }
    }
}
