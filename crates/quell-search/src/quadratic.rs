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
    /// Rows that depend on the active ones and are exceeded by rounding only.
    is_settled: Vec<bool>,
    /// Largest magnitude that each variable has had on the way, on which rounding depends.
    reach: Vec<f64>,
}

/// Part of a row's own magnitude by which it may be exceeded: a few hundred roundings.
const ROW_TOLERANCE: f64 = 1e-13;
/// The same for a row that depends on the active ones, which amplify rounding.
const DEPENDENT_ROW_TOLERANCE: f64 = 1e-9;
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
        self.is_settled.clear();
        self.is_settled.resize(m, false);
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
        self.reach.clear();
        self.reach.extend(self.solution.iter().map(|z| z.abs()));

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
            if self.is_active[row] || self.is_settled[row] {
                continue;
            }
            let mut slack = limit;
            let mut magnitude = limit.abs();
            for ((a, z), reach) in rows[row * n..(row + 1) * n]
                .iter()
                .zip(&self.solution)
                .zip(&self.reach)
            {
                slack -= a * z;
                magnitude += (a * reach).abs();
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
                let magnitude = normal
                    .iter()
                    .zip(&self.reach)
                    .map(|(a, z)| (a * z).abs())
                    .sum::<f64>()
                    + limit.abs();
                if -slack <= DEPENDENT_ROW_TOLERANCE * magnitude {
                    self.is_settled[row] = true;
                    return Ok(());
                }
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
                for ((z, direction), reach) in self
                    .solution
                    .iter_mut()
                    .zip(&self.step)
                    .zip(&mut self.reach)
                {
                    *z += length * direction;
                    *reach = reach.max(z.abs());
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

#[cfg(test)]
mod tests {
    use clarabel::algebra::CscMatrix;
    use clarabel::solver::{DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT};

    use super::{Quadratic, Unsolved, dot};

    struct Programme {
        hessian: Vec<f64>,
        linear: Vec<f64>,
        rows: Vec<f64>,
        limits: Vec<f64>,
    }

    /// Numbers in [-1, 1) from a linear congruential generator (Knuth's MMIX constants).
    struct Numbers(u64);

    impl Numbers {
        fn next(&mut self) -> f64 {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }

        fn below(&mut self, count: usize) -> usize {
            ((self.next() + 1.0) * 0.5 * count as f64) as usize
        }
    }

    /// A minimax step: `n` variables in a box of radius `radius`, `t`, an elastic variable, random pieces, some of
    /// them repeated so that degenerate active sets occur.
    fn minimax_step(numbers: &mut Numbers) -> Programme {
        let n = 1 + numbers.below(8);
        let size = n + 2;
        let mut hessian = vec![0.0; size * size];
        let stiffness = 10.0_f64.powf(3.0 * numbers.next());
        for _ in 0..n {
            let v: Vec<f64> = (0..n).map(|_| numbers.next()).collect();
            for i in 0..n {
                for j in 0..n {
                    hessian[i * size + j] += stiffness * v[i] * v[j];
                }
            }
        }
        for i in 0..n {
            hessian[i * size + i] += 1e-3 * stiffness;
        }
        hessian[n * size + n] = 1e-2;
        hessian[(n + 1) * size + n + 1] = 0.1;
        let mut linear = vec![0.0; size];
        linear[n] = 1.0;
        linear[n + 1] = 10.0;
        let (mut rows, mut limits) = (Vec::new(), Vec::new());
        for piece in 0..=numbers.below(12) {
            let constraint = piece > 0 && numbers.next() > 0.5;
            if piece > 0 && numbers.next() > 0.8 {
                let previous = rows.len() - size;
                rows.extend_from_within(previous..);
                limits.push(*limits.last().unwrap());
                continue;
            }
            rows.extend((0..n).map(|_| numbers.next()));
            rows.extend_from_slice(if constraint {
                &[0.0, -1.0]
            } else {
                &[-1.0, 0.0]
            });
            limits.push(if piece == 0 {
                0.0
            } else {
                0.3 * numbers.next().abs()
            });
        }
        for i in 0..n {
            for sign in [1.0, -1.0] {
                let at = rows.len();
                rows.resize(at + size, 0.0);
                rows[at + i] = sign;
                limits.push(if numbers.next() > 0.7 { 0.0 } else { 0.15 });
            }
        }
        let at = rows.len();
        rows.resize(at + size, 0.0);
        rows[at + n + 1] = -1.0;
        limits.push(0.0);
        Programme {
            hessian,
            linear,
            rows,
            limits,
        }
    }

    fn cost(programme: &Programme, z: &[f64]) -> f64 {
        let n = z.len();
        dot(&programme.linear, z)
            + 0.5
                * (0..n)
                    .map(|i| z[i] * dot(&programme.hessian[i * n..(i + 1) * n], z))
                    .sum::<f64>()
    }

    /// The same programme by an interior-point method.
    fn oracle(programme: &Programme) -> Vec<f64> {
        let n = programme.linear.len();
        let m = programme.limits.len();
        let dense =
            |rows: usize, columns: usize, upper: bool, entry: &dyn Fn(usize, usize) -> f64| {
                let (mut starts, mut indices, mut values) = (vec![0], Vec::new(), Vec::new());
                for column in 0..columns {
                    for row in 0..if upper { column + 1 } else { rows } {
                        indices.push(row);
                        values.push(entry(row, column));
                    }
                    starts.push(indices.len());
                }
                CscMatrix::new(rows, columns, starts, indices, values)
            };
        let hessian = dense(n, n, true, &|i, j| programme.hessian[i * n + j]);
        let rows = dense(m, n, false, &|i, j| programme.rows[i * n + j]);
        let settings = DefaultSettingsBuilder::default()
            .verbose(false)
            .build()
            .unwrap();
        let cones = [NonnegativeConeT(m)];
        let mut solver = DefaultSolver::new(
            &hessian,
            &programme.linear,
            &rows,
            &programme.limits,
            &cones,
            settings,
        )
        .unwrap();
        solver.solve();
        solver.solution.x.clone()
    }

    /// Stationarity, feasibility, signs and complementarity of 20,000 random steps; the tolerances are roundings
    /// times the largest magnitudes that occur (multipliers up to 10, curvature up to 1e3).
    #[test]
    fn optimality_conditions_hold() {
        let mut numbers = Numbers(1);
        let mut quadratic = Quadratic::default();
        for _ in 0..20_000 {
            let p = minimax_step(&mut numbers);
            let n = p.linear.len();
            quadratic
                .solve(&p.hessian, &p.linear, &p.rows, &p.limits)
                .unwrap();
            let z = quadratic.solution();
            for i in 0..n {
                let mut residual = p.linear[i] + dot(&p.hessian[i * n..(i + 1) * n], z);
                for (row, multiplier) in quadratic.multipliers().iter().enumerate() {
                    residual += multiplier * p.rows[row * n + i];
                }
                assert!(residual.abs() < 1e-8, "stationarity {residual}");
            }
            for (row, (&limit, &multiplier)) in
                p.limits.iter().zip(quadratic.multipliers()).enumerate()
            {
                let slack = limit - dot(&p.rows[row * n..(row + 1) * n], z);
                assert!(slack > -1e-10, "feasibility {slack}");
                assert!(multiplier >= 0.0);
                assert!(
                    (multiplier * slack).abs() < 1e-8,
                    "complementarity {multiplier} {slack}"
                );
            }
        }
    }

    /// An interior-point solver finds the same cost; 1e-6 because it stops at a relative gap of 1e-8.
    #[test]
    fn agrees_with_an_interior_point_solver() {
        let mut numbers = Numbers(2);
        let mut quadratic = Quadratic::default();
        for _ in 0..500 {
            let p = minimax_step(&mut numbers);
            quadratic
                .solve(&p.hessian, &p.linear, &p.rows, &p.limits)
                .unwrap();
            let (ours, theirs) = (cost(&p, quadratic.solution()), cost(&p, &oracle(&p)));
            assert!(
                (ours - theirs).abs() < 1e-6 * (1.0 + theirs.abs()),
                "{ours} {theirs}"
            );
        }
    }

    #[test]
    fn contradictory_rows_are_infeasible() {
        let mut quadratic = Quadratic::default();
        let result = quadratic.solve(&[1.0], &[0.0], &[1.0, -1.0], &[-1.0, -1.0]);
        assert_eq!(result, Err(Unsolved::Infeasible));
    }

    #[test]
    fn indefinite_or_unbounded_numbers_are_refused() {
        let mut quadratic = Quadratic::default();
        for curvature in [-1.0, 0.0, f64::NAN, f64::INFINITY] {
            assert_eq!(
                quadratic.solve(&[curvature], &[1.0], &[1.0], &[1.0]),
                Err(Unsolved::NotConvex)
            );
        }
        assert!(
            quadratic
                .solve(&[1.0], &[f64::NAN], &[1.0], &[1.0])
                .is_err()
        );
        assert!(quadratic.solve(&[], &[], &[], &[]).is_ok());
    }

    #[test]
    #[ignore = "a measurement: cargo test --release -p quell-search -- --ignored --nocapture cost_of_a_step"]
    fn cost_of_a_step() {
        let mut numbers = Numbers(3);
        let programmes: Vec<Programme> = (0..2_000).map(|_| minimax_step(&mut numbers)).collect();
        let mut quadratic = Quadratic::default();
        let clock = std::time::Instant::now();
        for p in &programmes {
            quadratic
                .solve(&p.hessian, &p.linear, &p.rows, &p.limits)
                .unwrap();
        }
        let ours = clock.elapsed().as_secs_f64() / programmes.len() as f64;
        let clock = std::time::Instant::now();
        for p in &programmes {
            std::hint::black_box(oracle(p));
        }
        let theirs = clock.elapsed().as_secs_f64() / programmes.len() as f64;
        println!(
            "dual active set {:.2} us, interior point {:.2} us",
            ours * 1e6,
            theirs * 1e6
        );
    }
}
