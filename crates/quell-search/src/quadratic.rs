//! Small strictly convex quadratic programmes by the dual active-set method.
//!
//! The subproblems of a minimax search have some ten variables and a few dozen rows, and thousands are solved in a
//! second. An interior-point solver built for large sparse problems spends most of its time there on set-up, so this
//! method works on dense arrays that are reused; the general solver remains the oracle in the tests.
//!
//! Source: D. Goldfarb and A. Idnani, "A numerically stable dual method for solving strictly convex quadratic
//! programs", Mathematical Programming 27 (1983), 1-33.

/// Why a quadratic programme has no answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Unsolved {
    /// The Hessian is not positive definite, or a number is not finite.
    NotConvex,
    /// No point satisfies all rows.
    Infeasible,
    /// The iteration limit was reached, by rounding in a degenerate programme.
    IterationLimit,
}

/// Minimises `½ zᵀ H z + hᵀ z` subject to `A z <= b`; keeps its buffers from call to call.
#[derive(Debug, Default)]
pub(crate) struct Quadratic {
    size: usize,
    /// The minimiser.
    solution: Vec<f64>,
    /// Multipliers of the rows, zero for inactive ones.
    multipliers: Vec<f64>,
    /// Lower Cholesky factor, row-major.
    factor: Vec<f64>,
    /// `J = L^-T Q`, row-major.
    basis: Vec<f64>,
    /// Upper triangular factor of the active rows, row-major.
    triangle: Vec<f64>,
    rotated: Vec<f64>,
    step: Vec<f64>,
    dual_step: Vec<f64>,
    active: Vec<usize>,
    active_multipliers: Vec<f64>,
    is_active: Vec<bool>,
}

/// Part of a row's own magnitude by which it may be exceeded: a few hundred roundings.
const ROW_TOLERANCE: f64 = 1e-13;
/// Squared sine below which a new row counts as dependent on the active ones.
const DEPENDENCE: f64 = 1e-22;

impl Quadratic {
    pub(crate) fn solution(&self) -> &[f64] {
        &self.solution
    }

    pub(crate) fn multipliers(&self) -> &[f64] {
        &self.multipliers
    }

    /// Solves the programme with `linear.len()` variables and `limits.len()` rows; matrices are row-major.
    pub(crate) fn solve(
        &mut self,
        hessian: &[f64],
        linear: &[f64],
        rows: &[f64],
        limits: &[f64],
    ) -> Result<(), Unsolved> {
        let n = linear.len();
        let m = limits.len();
        self.size = n;
        self.multipliers.clear();
        self.multipliers.resize(m, 0.0);
        self.is_active.clear();
        self.is_active.resize(m, false);
        self.active.clear();
        self.active_multipliers.clear();
        for buffer in [
            &mut self.rotated,
            &mut self.step,
            &mut self.dual_step,
            &mut self.solution,
        ] {
            buffer.clear();
            buffer.resize(n, 0.0);
        }
        for buffer in [&mut self.basis, &mut self.triangle, &mut self.factor] {
            buffer.clear();
            buffer.resize(n * n, 0.0);
        }
        if n == 0 {
            return Ok(());
        }
        self.factorise(hessian)?;
        self.unconstrained(linear);
        if !self.solution.iter().all(|number| number.is_finite()) {
            return Err(Unsolved::NotConvex);
        }

        for _ in 0..(10 * (n + m) + 50) {
            let Some((row, slack)) = self.most_violated(rows, limits) else {
                for (&row, &multiplier) in self.active.iter().zip(&self.active_multipliers) {
                    self.multipliers[row] = multiplier;
                }
                return Ok(());
            };
            self.add_row(row, slack, &rows[row * n..(row + 1) * n], limits[row])?;
        }
        Err(Unsolved::IterationLimit)
    }

    /// `H = L Lᵀ` and `J = L^-T`.
    fn factorise(&mut self, hessian: &[f64]) -> Result<(), Unsolved> {
        let n = self.size;
        for i in 0..n {
            for j in 0..=i {
                let mut sum = hessian[i * n + j];
                for k in 0..j {
                    sum -= self.factor[i * n + k] * self.factor[j * n + k];
                }
                if i == j {
                    // Written so that not-a-number is refused as well.
                    if !(sum > 0.0 && sum.is_finite()) {
                        return Err(Unsolved::NotConvex);
                    }
                    self.factor[i * n + i] = sum.sqrt();
                } else {
                    self.factor[i * n + j] = sum / self.factor[j * n + j];
                }
            }
        }
        // Column c of L^-1 by forward substitution, stored as row c of J = L^-T.
        for c in 0..n {
            for i in c..n {
                let mut sum = if i == c { 1.0 } else { 0.0 };
                for k in c..i {
                    sum -= self.factor[i * n + k] * self.basis[c * n + k];
                }
                self.basis[c * n + i] = sum / self.factor[i * n + i];
            }
        }
        Ok(())
    }

    /// `z = -J Jᵀ h`.
    fn unconstrained(&mut self, linear: &[f64]) {
        let n = self.size;
        for j in 0..n {
            self.rotated[j] = (0..n).map(|i| self.basis[i * n + j] * linear[i]).sum();
        }
        for i in 0..n {
            self.solution[i] = -dot(&self.basis[i * n..(i + 1) * n], &self.rotated);
        }
    }

    /// The inactive row with the most negative slack in its own magnitude.
    fn most_violated(&self, rows: &[f64], limits: &[f64]) -> Option<(usize, f64)> {
        let n = self.size;
        let mut worst = None;
        let mut worst_slack = 0.0;
        for (row, &limit) in limits.iter().enumerate() {
            if self.is_active[row] {
                continue;
            }
            let mut slack = limit;
            let mut magnitude = limit.abs();
            for (a, z) in rows[row * n..(row + 1) * n].iter().zip(&self.solution) {
                slack -= a * z;
                magnitude += (a * z).abs();
            }
            if slack < -ROW_TOLERANCE * magnitude && slack < worst_slack {
                worst_slack = slack;
                worst = Some((row, slack));
            }
        }
        worst
    }

    /// Moves until `row` holds with equality, dropping active rows whose multipliers reach zero on the way.
    fn add_row(
        &mut self,
        row: usize,
        mut slack: f64,
        normal: &[f64],
        limit: f64,
    ) -> Result<(), Unsolved> {
        let n = self.size;
        let mut multiplier = 0.0;
        for _ in 0..=n + 1 {
            // In the notation of the source the constraint is n+ᵀ z >= ..., with n+ = -normal.
            for j in 0..n {
                self.rotated[j] = -(0..n)
                    .map(|i| self.basis[i * n + j] * normal[i])
                    .sum::<f64>();
            }
            let count = self.active.len();
            let free: f64 = self.rotated[count..].iter().map(|x| x * x).sum();
            let whole: f64 = free + self.rotated[..count].iter().map(|x| x * x).sum::<f64>();
            for i in 0..n {
                self.step[i] = dot(
                    &self.basis[i * n + count..(i + 1) * n],
                    &self.rotated[count..],
                );
            }
            for i in (0..count).rev() {
                let mut sum = self.rotated[i];
                for k in i + 1..count {
                    sum -= self.triangle[i * n + k] * self.dual_step[k];
                }
                self.dual_step[i] = sum / self.triangle[i * n + i];
            }
            let mut dual_length = f64::INFINITY;
            let mut blocking = None;
            for (position, &current) in self.active_multipliers.iter().enumerate() {
                let rate = self.dual_step[position];
                if rate > 0.0 && current / rate < dual_length {
                    dual_length = current / rate;
                    blocking = Some(position);
                }
            }
            let dependent = free <= DEPENDENCE * whole || count >= n;
            let primal_length = if dependent {
                f64::INFINITY
            } else {
                -slack / free
            };
            let length = dual_length.min(primal_length);
            if !length.is_finite() {
                return Err(if whole.is_finite() {
                    Unsolved::Infeasible
                } else {
                    Unsolved::NotConvex
                });
            }
            for (current, rate) in self.active_multipliers.iter_mut().zip(&self.dual_step) {
                *current = (*current - length * rate).max(0.0);
            }
            multiplier += length;
            if !dependent {
                for (z, direction) in self.solution.iter_mut().zip(&self.step) {
                    *z += length * direction;
                }
            }
            if primal_length <= dual_length {
                self.append(row, multiplier);
                return Ok(());
            }
            if let Some(position) = blocking {
                self.drop_row(position);
            }
            slack = limit - dot(normal, &self.solution);
        }
        Err(Unsolved::IterationLimit)
    }

    /// Makes `row` active; `rotated` holds `Jᵀ n+`.
    fn append(&mut self, row: usize, multiplier: f64) {
        let n = self.size;
        let count = self.active.len();
        for j in (count + 1..n).rev() {
            let (cosine, sine, length) = rotation(self.rotated[j - 1], self.rotated[j]);
            if length == 0.0 {
                continue;
            }
            self.rotated[j] = 0.0;
            self.rotated[j - 1] = length;
            for k in 0..n {
                let (left, right) = (self.basis[k * n + j - 1], self.basis[k * n + j]);
                self.basis[k * n + j - 1] = cosine * left + sine * right;
                self.basis[k * n + j] = cosine * right - sine * left;
            }
        }
        for i in 0..=count {
            self.triangle[i * n + count] = self.rotated[i];
        }
        self.active.push(row);
        self.active_multipliers.push(multiplier);
        self.is_active[row] = true;
    }

    /// Makes the active row at `position` inactive and restores the triangle.
    fn drop_row(&mut self, position: usize) {
        let n = self.size;
        let row = self.active.remove(position);
        self.active_multipliers.remove(position);
        self.is_active[row] = false;
        let count = self.active.len();
        for j in position..count {
            for i in 0..=j + 1 {
                self.triangle[i * n + j] = self.triangle[i * n + j + 1];
            }
        }
        for j in position..count {
            let (cosine, sine, length) =
                rotation(self.triangle[j * n + j], self.triangle[(j + 1) * n + j]);
            if length == 0.0 {
                continue;
            }
            for k in j..count {
                let (upper, lower) = (self.triangle[j * n + k], self.triangle[(j + 1) * n + k]);
                self.triangle[j * n + k] = cosine * upper + sine * lower;
                self.triangle[(j + 1) * n + k] = cosine * lower - sine * upper;
            }
            for k in 0..n {
                let (left, right) = (self.basis[k * n + j], self.basis[k * n + j + 1]);
                self.basis[k * n + j] = cosine * left + sine * right;
                self.basis[k * n + j + 1] = cosine * right - sine * left;
            }
        }
    }
}

/// Cosine and sine that turn `(a, b)` into `(length, 0)`.
fn rotation(a: f64, b: f64) -> (f64, f64, f64) {
    let length = a.hypot(b);
    if length == 0.0 {
        (1.0, 0.0, 0.0)
    } else {
        (a / length, b / length, length)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
