//! Largest magnitude of frequency responses over a band, with refined peaks and exact gradients.

use num_complex::Complex64;
use quell_search::{Pieces, Problem, Scale, Variable};

/// Frequency responses that depend on design variables.
pub trait Response: Sync {
    /// Response number `output` at `omega`; with `gradient`, also its derivatives by the variables.
    fn response(
        &self,
        output: usize,
        omega: f64,
        point: &[f64],
        gradient: Option<&mut [Complex64]>,
    ) -> Complex64;
}

/// Minimise the largest magnitude of output 0; output `j >= 1` is constrained by `max |H_j| <= limits[j - 1]`.
pub struct Peaks<R> {
    pub variables: Vec<Variable>,
    pub grid: Vec<f64>,
    pub response: R,
    pub limits: Vec<f64>,
    pub gradients: bool,
    /// Whether peaks between the grid's frequencies count; otherwise the objective is the largest value on the grid.
    pub refined: bool,
}

#[derive(Default)]
pub struct Scratch {
    magnitudes: Vec<f64>,
    gradient: Vec<Complex64>,
    peaks: Vec<(f64, f64)>,
}

impl<R: Response> Peaks<R> {
    /// Local maxima `(omega, magnitude)` of an output whose magnitude is at least `share` of the largest.
    fn peaks(&self, output: usize, point: &[f64], share: f64, scratch: &mut Scratch) -> f64 {
        let size = |omega: f64| {
            self.response
                .response(output, omega, point, None)
                .norm_sqr()
        };
        scratch.magnitudes.clear();
        scratch
            .magnitudes
            .extend(self.grid.iter().map(|&omega| size(omega)));
        let m = &scratch.magnitudes;
        let highest = m.iter().fold(
            0.0_f64,
            |a, &b| if b.is_nan() { f64::NAN } else { a.max(b) },
        );
        scratch.peaks.clear();
        if highest.is_nan() {
            return f64::NAN;
        }
        let last = m.len() - 1;
        let mut top = 0.0_f64;
        for i in 0..=last {
            // A grid value within 30 % of its peak is assumed; the grids of the catalogue are finer.
            if m[i] < 0.49 * share * share * highest
                || (i > 0 && m[i - 1] >= m[i])
                || (i < last && m[i + 1] > m[i])
            {
                continue;
            }
            let (mut omega, mut value) = (self.grid[i], m[i]);
            if !self.refined {
                // The neighbours are pieces of their own, which take over as the peak moves.
                for k in i.saturating_sub(2)..=(i + 2).min(last) {
                    scratch.peaks.push((self.grid[k], m[k].sqrt()));
                }
                top = top.max(value.sqrt());
                continue;
            }
            if i > 0 && i < last {
                let mut bracket = [
                    (self.grid[i - 1], m[i - 1]),
                    (omega, value),
                    (self.grid[i + 1], m[i + 1]),
                ];
                for _ in 0..12 {
                    let [(a, fa), (b, fb), (c, fc)] = bracket;
                    let (p, q) = ((b - a) * (fb - fc), (b - c) * (fb - fa));
                    let vertex = b - 0.5 * ((b - a) * p - (b - c) * q) / (p - q);
                    let mut next = vertex.clamp(a + 1e-3 * (b - a), c - 1e-3 * (c - b));
                    if next.is_nan() || (next - b).abs() < 1e-8 * b {
                        break;
                    }
                    if (next - b).abs() < 1e-6 * b {
                        // Straddle, so that both sides close in.
                        next = b + 2.0 * (next - b);
                    }
                    let f = size(next);
                    bracket = match (next < b, f > fb) {
                        (true, true) => [(a, fa), (next, f), (b, fb)],
                        (true, false) => [(next, f), (b, fb), (c, fc)],
                        (false, true) => [(b, fb), (next, f), (c, fc)],
                        (false, false) => [(a, fa), (b, fb), (next, f)],
                    };
                }
                (omega, value) = bracket[1];
            }
            scratch.peaks.push((omega, value.sqrt()));
            top = top.max(value.sqrt());
        }
        scratch.peaks.retain(|&(_, value)| value >= share * top);
        top
    }
}

impl<R: Response> Problem for Peaks<R> {
    type Scratch = Scratch;

    fn scratch(&self) -> Scratch {
        Scratch::default()
    }

    fn variables(&self) -> &[Variable] {
        &self.variables
    }

    fn constraints(&self) -> usize {
        self.limits.len()
    }

    fn evaluate(&self, point: &[f64], constraints: &mut [f64], scratch: &mut Scratch) -> f64 {
        for (output, (constraint, limit)) in constraints.iter_mut().zip(&self.limits).enumerate() {
            *constraint = self.peaks(output + 1, point, 0.95, scratch) / limit - 1.0;
        }
        self.peaks(0, point, 0.95, scratch)
    }

    fn pieces(
        &self,
        point: &[f64],
        margin: f64,
        pieces: &mut Pieces,
        scratch: &mut Scratch,
    ) -> bool {
        let n = point.len();
        for output in 0..=self.limits.len() {
            self.peaks(output, point, (1.0 - margin).max(0.1), scratch);
            let limit = if output == 0 {
                1.0
            } else {
                self.limits[output - 1]
            };
            let Scratch {
                gradient, peaks, ..
            } = scratch;
            for &(omega, _) in peaks.iter() {
                gradient.clear();
                gradient.resize(n, Complex64::new(0.0, 0.0));
                let h = self.response.response(output, omega, point, Some(gradient));
                let magnitude = h.norm();
                let row = if output == 0 {
                    pieces.push_objective(magnitude)
                } else {
                    pieces.push_constraint(output - 1, magnitude / limit - 1.0)
                };
                for (row, derivative) in row.iter_mut().zip(gradient.iter()) {
                    *row = (h.conj() * derivative).re / magnitude / limit;
                }
            }
        }
        self.gradients
    }
}

/// A damped oscillator with an absorber: output 0 is x1 k1 / F, output 1 the absorber's stroke (x1 - x2) k1 / F, in
/// the dimensionless frequency, over tuning ratio and absorber damping.
#[derive(Debug, Clone, Copy)]
pub struct Absorber {
    pub mass_ratio: f64,
    pub host_damping: f64,
}

impl Response for Absorber {
    fn response(
        &self,
        output: usize,
        w: f64,
        point: &[f64],
        gradient: Option<&mut [Complex64]>,
    ) -> Complex64 {
        let (f, z, mu) = (point[0], point[1], self.mass_ratio);
        // With d the absorber's dynamic stiffness over its mass: d (x1 - x2) = -w² x2, so x2 = share x1, and the host
        // carries the absorber's inertia force: (1 - w² + 2j zeta1 w) x1 - mu w² x2 = 1.
        let d = Complex64::new(f * f, 2.0 * z * f * w);
        let share = d / (d - w * w);
        let host = Complex64::new(1.0 - w * w, 2.0 * self.host_damping * w);
        let denominator = host - mu * w * w * share;
        let relative = share - 1.0;
        let h = if output == 0 {
            1.0 / denominator
        } else {
            relative / denominator
        };
        if let Some(gradient) = gradient {
            let d_share = -w * w / ((d - w * w) * (d - w * w));
            let d_stiffness = [
                Complex64::new(2.0 * f, 2.0 * z * w),
                Complex64::new(0.0, 2.0 * f * w),
            ];
            for (g, dd) in gradient.iter_mut().zip(d_stiffness) {
                let ds = d_share * dd;
                let dh = mu * w * w * ds / (denominator * denominator);
                *g = if output == 0 {
                    dh
                } else {
                    relative * dh + ds / denominator
                };
            }
        }
        h
    }
}

/// `count` evenly spaced numbers.
pub fn grid(from: f64, to: f64, count: usize) -> Vec<f64> {
    (0..count)
        .map(|i| from + (to - from) * i as f64 / (count - 1) as f64)
        .collect()
}

pub fn absorber(
    mass_ratio: f64,
    host_damping: f64,
    limits: &[f64],
    gradients: bool,
) -> Peaks<Absorber> {
    Peaks {
        variables: vec![
            Variable::new("tuning", 0.5, 1.5, Scale::Linear).unwrap(),
            Variable::new("damping", 0.001, 1.0, Scale::Logarithmic).unwrap(),
        ],
        grid: grid(0.5, 1.5, 200),
        response: Absorber {
            mass_ratio,
            host_damping,
        },
        limits: limits.to_vec(),
        gradients,
        refined: true,
    }
}

/// The absorber on 400 frequencies without refinement, as in an independent comparison of nine optimisers whose best
/// values are 5.7837357, and 17.0851599 with a stroke of at most 14 (mass ratio 0.05, host damping 0.01).
pub fn absorber_on_grid(limits: &[f64], gradients: bool) -> Peaks<Absorber> {
    Peaks {
        grid: grid(0.6, 1.4, 400),
        refined: false,
        ..absorber(0.05, 0.01, limits, gradients)
    }
}
