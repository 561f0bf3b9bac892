//! Local minimax search by sequential quadratic programming with exact gradients.
//!
//! In scaled coordinates `u` the objective is `max_i f_i(u)` and the constraints are `max_i c_ij(u) <= 0`. Each step
//! solves
//!
//! ```text
//! minimise   t + ½ dᵀ B d + ρ s
//! subject to f_i + g_i·d <= f + t,   c_ij + ∇c_ij·d <= s,   s >= 0,   |d| <= Δ,   0 <= u + d <= 1
//! ```
//!
//! with a damped BFGS matrix `B` of the Lagrangian. Where a step fails for curvature, a second-order correction
//! re-centres the pieces on their values at the trial point; pieces that only show up there are kept as cuts. Steps
//! are accepted by the exact merit `f + ρ max(0, c)`.
//!
//! Sources: J. Nocedal and S. J. Wright, "Numerical Optimization" (2006), procedure 18.2 (damped BFGS), section 18.3
//! (second-order correction) and 18.5 (elastic steps); R. Fletcher, "Practical Methods of Optimization" (1987),
//! chapter 14 (minimax programmes).

use crate::evaluation::{Accuracy, Evaluator, Value};
use crate::quadratic::Quadratic;
use crate::{Pieces, Problem};

/// Why a descent ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ending {
    /// The model predicts no further decrease.
    Converged,
    /// The trust region collapsed without the model agreeing.
    Stalled,
    /// The budget is spent.
    Budget,
    /// There are no pieces at the present point.
    Unavailable,
}

/// Curvature given to `t` and `s` so that the programme is strictly convex. The weight of `t` becomes `1 + CURVATURE t`
/// in relative units, which is exact at convergence, where `t = 0`.
const CURVATURE: f64 = 1e-2;
const FIRST_RADIUS: f64 = 0.15;
const LARGEST_RADIUS: f64 = 0.5;
const SMALLEST_RADIUS: f64 = 1e-10;
const LARGEST_PENALTY: f64 = 1e7;
/// Where the trust region is this many differences wide or narrower, they are taken on both sides.
const NEAR: f64 = 30.0;
/// Relative distance to the maximum within which a piece counts as active for the certificate.
const ACTIVE: f64 = 1e-6;

/// One linearised piece: `target` is the constraint's index, or none for the objective.
#[derive(Debug, Clone, Copy)]
struct Row {
    target: Option<usize>,
    value: f64,
}

/// Pieces at one point, rows and gradients side by side.
#[derive(Debug, Default)]
struct Model {
    rows: Vec<Row>,
    gradients: Vec<f64>,
}

impl Model {
    fn fill(&mut self, pieces: &Pieces) {
        self.rows.clear();
        self.gradients.clear();
        for (value, gradient) in pieces.iter_objectives() {
            self.rows.push(Row {
                target: None,
                value,
            });
            self.gradients.extend_from_slice(gradient);
        }
        for (index, value, gradient) in pieces.iter_constraints() {
            self.rows.push(Row {
                target: Some(index),
                value,
            });
            self.gradients.extend_from_slice(gradient);
        }
    }

    fn push(&mut self, row: Row, gradient: &[f64]) {
        self.rows.push(row);
        self.gradients.extend_from_slice(gradient);
    }

    fn gradient(&self, index: usize, n: usize) -> &[f64] {
        &self.gradients[index * n..(index + 1) * n]
    }

    fn largest_gradient(&self, n: usize) -> f64 {
        let objective = self
            .rows
            .iter()
            .enumerate()
            .filter(|(_, row)| row.target.is_none());
        objective
            .map(|(i, _)| norm(self.gradient(i, n)))
            .fold(0.0, f64::max)
    }
}

/// Buffers and state of minimax descents.
#[derive(Debug, Default)]
pub(crate) struct Minimax {
    quadratic: Quadratic,
    model: Model,
    trial_model: Model,
    hessian: Vec<f64>,
    programme_hessian: Vec<f64>,
    linear: Vec<f64>,
    rows: Vec<f64>,
    limits: Vec<f64>,
    matches: Vec<Option<usize>>,
    multipliers: Vec<f64>,
    step: Vec<f64>,
    correction: Vec<f64>,
    trial: Vec<f64>,
    gradient_change: Vec<f64>,
    product: Vec<f64>,
    pieces: Pieces,
}

/// Solution of one programme.
#[derive(Debug, Clone, Copy)]
struct Solved {
    /// Decrease of the model including its curvature, relative to the objective's scale.
    predicted: f64,
    elastic: f64,
    constraint_multipliers: f64,
}

impl Minimax {
    pub(crate) fn new(dimension: usize) -> Self {
        Self {
            pieces: Pieces::new(dimension),
            ..Self::default()
        }
    }

    /// Descends from `coordinates` (moved to the end point) and gives the value there.
    pub(crate) fn descend<P: Problem>(
        &mut self,
        evaluator: &mut Evaluator<'_, P>,
        coordinates: &mut [f64],
        first_radius: Option<f64>,
    ) -> (Ending, Value) {
        let n = coordinates.len();
        let limit = evaluator.evaluations + evaluator.remaining();
        let mut value = evaluator.evaluate(coordinates);
        let mut accuracy = Accuracy::Coarse;
        if value.is_failed() || !evaluator.pieces(coordinates, accuracy, &mut self.pieces) {
            return (Ending::Unavailable, value);
        }
        self.model.fill(&self.pieces);
        let mut radius = first_radius.unwrap_or(FIRST_RADIUS);
        let mut penalty = 10.0;
        let mut fresh = true;
        let mut resets = 0;
        self.reset_hessian(n);
        while evaluator.evaluations < limit {
            let largest = self.model.largest_gradient(n);
            let scale = value
                .objective
                .abs()
                .max(evaluator.settings.magnitude)
                .max(0.1 * largest);
            if !(scale > 0.0 && scale.is_finite()) {
                // All gradients vanish: a flat place of the objective.
                return (Ending::Converged, value);
            }
            let Some(solved) = self.steered_step(coordinates, value, scale, radius, &mut penalty)
            else {
                if fresh {
                    return (Ending::Stalled, value);
                }
                self.reset_hessian(n);
                fresh = true;
                continue;
            };
            let measure = value
                .objective
                .abs()
                .max(evaluator.settings.magnitude)
                .max(1e-7 * largest);
            let done = solved.predicted * scale <= evaluator.settings.convergence * measure;
            let close = radius < NEAR * evaluator.settings.difference;
            if evaluator.differences() && accuracy == Accuracy::Coarse && (done || close) {
                accuracy = Accuracy::Fine;
                if !evaluator.pieces(coordinates, accuracy, &mut self.pieces) {
                    return (Ending::Unavailable, value);
                }
                self.model.fill(&self.pieces);
                continue;
            }
            if done {
                // A matrix grown too stiff also predicts no decrease: believe it only from a fresh one or with a
                // certificate, which does not depend on the matrix.
                if fresh
                    || resets >= 2
                    || self
                        .certificate(coordinates, value, evaluator.settings.magnitude)
                        .is_some_and(|c| c <= 1e-6)
                {
                    return (Ending::Converged, value);
                }
                resets += 1;
                self.reset_hessian(n);
                fresh = true;
                radius = radius.max(1e-3);
                continue;
            }
            let merit = |value: Value| value.objective / scale + penalty * value.violation;
            self.trial.clear();
            self.trial.extend(
                coordinates
                    .iter()
                    .zip(&self.step)
                    .map(|(u, d)| (u + d).clamp(0.0, 1.0)),
            );
            let mut trial_value = evaluator.evaluate(&self.trial);
            let mut ratio = ratio(merit(value), trial_value, merit, solved.predicted);
            let mut trial_pieces = false;
            if ratio < 0.1 && !trial_value.is_failed() && evaluator.evaluations < limit {
                // Second-order correction, and cuts from pieces that the model did not know.
                if evaluator.pieces(&self.trial, accuracy, &mut self.pieces) {
                    self.trial_model.fill(&self.pieces);
                    let corrected = self.correct(coordinates, value, scale, radius, penalty);
                    if corrected && evaluator.evaluations < limit {
                        self.trial.clear();
                        self.trial.extend(
                            coordinates
                                .iter()
                                .zip(&self.correction)
                                .map(|(u, d)| (u + d).clamp(0.0, 1.0)),
                        );
                        let second = evaluator.evaluate(&self.trial);
                        let second_ratio =
                            self::ratio(merit(value), second, merit, solved.predicted);
                        if second_ratio > ratio {
                            ratio = second_ratio;
                            trial_value = second;
                            std::mem::swap(&mut self.step, &mut self.correction);
                        } else {
                            self.trial.clear();
                            self.trial.extend(
                                coordinates
                                    .iter()
                                    .zip(&self.step)
                                    .map(|(u, d)| (u + d).clamp(0.0, 1.0)),
                            );
                            trial_pieces = true;
                        }
                    } else {
                        trial_pieces = true;
                    }
                }
            }
            let length = self
                .step
                .iter()
                .fold(0.0_f64, |longest, d| longest.max(d.abs()));
            if ratio > 1e-4 {
                if !trial_pieces {
                    if !evaluator.pieces(&self.trial, accuracy, &mut self.pieces) {
                        coordinates.copy_from_slice(&self.trial);
                        return (Ending::Unavailable, trial_value);
                    }
                    self.trial_model.fill(&self.pieces);
                }
                for (d, (new, old)) in self
                    .step
                    .iter_mut()
                    .zip(self.trial.iter().zip(coordinates.iter()))
                {
                    *d = new - old;
                }
                self.update_hessian(n, scale, fresh);
                fresh = false;
                coordinates.copy_from_slice(&self.trial);
                value = trial_value;
                std::mem::swap(&mut self.model, &mut self.trial_model);
            }
            if ratio < 0.25 {
                radius = 0.4 * length.min(radius);
            } else if ratio > 0.75 && length > 0.8 * radius {
                radius = (2.0 * radius).min(LARGEST_RADIUS);
            }
            // Differences say nothing of what is narrower than they are.
            let smallest = if evaluator.differences() {
                evaluator.settings.difference
            } else {
                SMALLEST_RADIUS
            };
            if radius < smallest {
                return (Ending::Stalled, value);
            }
        }
        (Ending::Budget, value)
    }

    fn reset_hessian(&mut self, n: usize) {
        let curvature = (0.1 * self.model.largest_gradient(n)).max(f64::MIN_POSITIVE);
        self.hessian.clear();
        self.hessian.resize(n * n, 0.0);
        for i in 0..n {
            self.hessian[i * n + i] = curvature;
        }
    }

    /// A step whose penalty is large enough that feasibility is improved where the linearised constraints allow it.
    fn steered_step(
        &mut self,
        coordinates: &[f64],
        value: Value,
        scale: f64,
        radius: f64,
        penalty: &mut f64,
    ) -> Option<Solved> {
        let mut solved = self.programme(coordinates, value, scale, radius, *penalty)?;
        // Whether the last programme solved is another one than that of `penalty`.
        let mut stale = false;
        while solved.elastic > 1e-9 && *penalty < LARGEST_PENALTY {
            let larger = *penalty * 10.0;
            let next = self.programme(coordinates, value, scale, radius, larger)?;
            if next.elastic > 0.9 * solved.elastic {
                stale = true;
                break;
            }
            *penalty = larger;
            solved = next;
        }
        if 1.5 * solved.constraint_multipliers > *penalty && *penalty < LARGEST_PENALTY {
            *penalty = 2.0 * solved.constraint_multipliers;
            stale = true;
        }
        if stale {
            solved = self.programme(coordinates, value, scale, radius, *penalty)?;
        }
        let n = coordinates.len();
        self.step.clear();
        self.step.extend_from_slice(&self.quadratic.solution()[..n]);
        self.multipliers.clear();
        self.multipliers
            .extend_from_slice(&self.quadratic.multipliers()[..self.model.rows.len()]);
        Some(solved)
    }

    /// Solves the programme around `coordinates`.
    fn programme(
        &mut self,
        coordinates: &[f64],
        value: Value,
        scale: f64,
        radius: f64,
        penalty: f64,
    ) -> Option<Solved> {
        let n = coordinates.len();
        let elastic = self.model.rows.iter().any(|row| row.target.is_some());
        let size = n + 1 + usize::from(elastic);
        self.programme_hessian.clear();
        self.programme_hessian.resize(size * size, 0.0);
        for i in 0..n {
            for j in 0..n {
                self.programme_hessian[i * size + j] = self.hessian[i * n + j] / scale;
            }
        }
        self.programme_hessian[n * size + n] = CURVATURE;
        self.linear.clear();
        self.linear.resize(size, 0.0);
        self.linear[n] = 1.0;
        if elastic {
            self.programme_hessian[(n + 1) * size + n + 1] = CURVATURE * penalty;
            self.linear[n + 1] = penalty;
        }
        self.rows.clear();
        self.limits.clear();
        for (index, row) in self.model.rows.iter().enumerate() {
            let gradient = &self.model.gradients[index * n..(index + 1) * n];
            if row.target.is_some() {
                self.rows.extend_from_slice(gradient);
                self.rows.extend_from_slice(&[0.0, -1.0]);
                self.limits.push(-row.value);
            } else {
                self.rows.extend(gradient.iter().map(|g| g / scale));
                self.rows.push(-1.0);
                if elastic {
                    self.rows.push(0.0);
                }
                self.limits.push((value.objective - row.value) / scale);
            }
        }
        for (i, &u) in coordinates.iter().enumerate() {
            for (sign, room) in [(1.0, 1.0 - u), (-1.0, u)] {
                let at = self.rows.len();
                self.rows.resize(at + size, 0.0);
                self.rows[at + i] = sign;
                self.limits.push(room.min(radius).max(0.0));
            }
        }
        if elastic {
            let at = self.rows.len();
            self.rows.resize(at + size, 0.0);
            self.rows[at + n + 1] = -1.0;
            self.limits.push(0.0);
        }
        self.quadratic
            .solve(
                &self.programme_hessian,
                &self.linear,
                &self.rows,
                &self.limits,
            )
            .ok()?;

        let solution = self.quadratic.solution();
        let step = &solution[..n];
        let mut curvature = 0.0;
        for i in 0..n {
            curvature += step[i] * dot(&self.hessian[i * n..(i + 1) * n], step);
        }
        let slack = if elastic {
            solution[n + 1].max(0.0)
        } else {
            0.0
        };
        let constraint_multipliers = self
            .model
            .rows
            .iter()
            .zip(self.quadratic.multipliers())
            .filter(|(row, _)| row.target.is_some())
            .map(|(_, multiplier)| multiplier)
            .sum();
        Some(Solved {
            predicted: -solution[n] - 0.5 * curvature / scale + penalty * (value.violation - slack),
            elastic: slack,
            constraint_multipliers,
        })
    }

    /// Re-centres the model's pieces on their values at the trial point (in `trial_model`), adds unknown pieces as
    /// cuts, and solves again into `correction`.
    fn correct(
        &mut self,
        coordinates: &[f64],
        value: Value,
        scale: f64,
        radius: f64,
        penalty: f64,
    ) -> bool {
        let n = coordinates.len();
        self.match_pieces(n);
        let known = self.model.rows.len();
        let originals: Vec<Row> = self.model.rows.clone();
        let mut used = vec![false; self.trial_model.rows.len()];
        for (index, found) in self.matches.iter().enumerate() {
            if let Some(found) = *found {
                used[found] = true;
                self.model.rows[index].value = self.trial_model.rows[found].value
                    - dot(self.model.gradient(index, n), &self.step);
            }
        }
        for (index, used) in used.iter().enumerate() {
            if !used {
                let row = self.trial_model.rows[index];
                let gradient = self.trial_model.gradient(index, n).to_vec();
                // Never above the present value, or the model would contradict the present point.
                let ceiling = if row.target.is_some() {
                    value.violation
                } else {
                    value.objective
                };
                let value = (row.value - dot(&gradient, &self.step)).min(ceiling);
                self.model.push(
                    Row {
                        target: row.target,
                        value,
                    },
                    &gradient,
                );
            }
        }
        let solved = self
            .programme(coordinates, value, scale, radius, penalty)
            .is_some();
        if solved {
            self.correction.clear();
            self.correction
                .extend_from_slice(&self.quadratic.solution()[..n]);
        }
        self.model.rows[..known].copy_from_slice(&originals);
        self.multipliers.resize(self.model.rows.len(), 0.0);
        solved
    }

    /// For each piece of the model, the piece of the trial point that continues it: the closest to what was predicted.
    fn match_pieces(&mut self, n: usize) {
        let mut used = vec![false; self.trial_model.rows.len()];
        self.matches.clear();
        for (index, row) in self.model.rows.iter().enumerate() {
            let gradient = self.model.gradient(index, n);
            let expected = row.value + dot(gradient, &self.step);
            let step_length = norm(&self.step);
            let mut best = None;
            let mut least = f64::INFINITY;
            for (candidate, other) in self.trial_model.rows.iter().enumerate() {
                if used[candidate] || other.target != row.target {
                    continue;
                }
                let other_gradient = self.trial_model.gradient(candidate, n);
                let turn = gradient
                    .iter()
                    .zip(other_gradient)
                    .map(|(a, b)| (a - b) * (a - b))
                    .sum::<f64>()
                    .sqrt();
                let size = norm(gradient).max(norm(other_gradient));
                let distance = (other.value - expected).abs() + turn * step_length;
                if turn <= size && distance < least {
                    least = distance;
                    best = Some(candidate);
                }
            }
            if let Some(found) = best {
                used[found] = true;
            }
            self.matches.push(best);
        }
    }

    /// Damped BFGS update of the Lagrangian's Hessian along the accepted step.
    fn update_hessian(&mut self, n: usize, scale: f64, first: bool) {
        self.match_pieces(n);
        self.gradient_change.clear();
        self.gradient_change.resize(n, 0.0);
        let mut weight = 0.0;
        let mut lost = 0.0;
        for (index, row) in self.model.rows.iter().enumerate() {
            let multiplier = self.multipliers.get(index).copied().unwrap_or(0.0);
            if multiplier <= 0.0 {
                continue;
            }
            let factor = if row.target.is_some() {
                multiplier * scale
            } else {
                multiplier
            };
            if row.target.is_none() {
                weight += multiplier;
            }
            let Some(found) = self.matches.get(index).copied().flatten() else {
                if row.target.is_none() {
                    lost += multiplier;
                }
                continue;
            };
            let (old, new) = (
                self.model.gradient(index, n),
                self.trial_model.gradient(found, n),
            );
            for (change, (new, old)) in self.gradient_change.iter_mut().zip(new.iter().zip(old)) {
                *change += factor * (new - old);
            }
        }
        // Curvature measured on less than half of the Lagrangian would be noise.
        if weight <= 0.0 || lost > 0.5 * weight {
            return;
        }
        for change in &mut self.gradient_change {
            *change /= weight;
        }
        let square = dot(&self.step, &self.step);
        let along = dot(&self.step, &self.gradient_change);
        if !(square > 0.0 && along.is_finite()) {
            return;
        }
        if first && along > 0.0 {
            let curvature = (dot(&self.gradient_change, &self.gradient_change) / along)
                .clamp(1e-3 * self.hessian[0], 1e3 * self.hessian[0]);
            self.hessian.fill(0.0);
            for i in 0..n {
                self.hessian[i * n + i] = curvature;
            }
        }
        self.product.clear();
        for i in 0..n {
            self.product
                .push(dot(&self.hessian[i * n..(i + 1) * n], &self.step));
        }
        let model = dot(&self.step, &self.product);
        if model <= 0.0 {
            return;
        }
        let theta = if along < 0.2 * model {
            0.8 * model / (model - along)
        } else {
            1.0
        };
        for (change, product) in self.gradient_change.iter_mut().zip(&self.product) {
            *change = theta * *change + (1.0 - theta) * product;
        }
        let along = dot(&self.step, &self.gradient_change);
        for i in 0..n {
            for j in 0..n {
                self.hessian[i * n + j] += self.gradient_change[i] * self.gradient_change[j]
                    / along
                    - self.product[i] * self.product[j] / model;
            }
        }
    }

    /// Length of the shortest vector in the convex hull of the active gradients, with multipliers for active
    /// constraints and bounds, relative to the objective or the largest of these gradients, whichever is larger.
    ///
    /// It is minus the minimiser of `t + ½ |d|²` subject to `g_i·d <= t`, `∇c_ij·d <= 0` and the active bounds.
    fn certificate(&mut self, coordinates: &[f64], value: Value, magnitude: f64) -> Option<f64> {
        let n = coordinates.len();
        let size = n + 1;
        self.rows.clear();
        self.limits.clear();
        let mut largest = value.objective.abs().max(magnitude);
        let near = ACTIVE * value.objective.abs();
        for (index, row) in self.model.rows.iter().enumerate() {
            let active = row.target.is_none() && row.value >= value.objective - near;
            if active {
                largest = largest.max(norm(self.model.gradient(index, n)));
            }
        }
        if largest == 0.0 {
            return Some(0.0);
        }
        for (index, row) in self.model.rows.iter().enumerate() {
            let gradient = &self.model.gradients[index * n..(index + 1) * n];
            if row.target.is_none() {
                if row.value >= value.objective - near {
                    self.rows.extend(gradient.iter().map(|g| g / largest));
                    self.rows.push(-1.0);
                    self.limits.push(0.0);
                }
            } else if row.value >= -ACTIVE {
                let length = norm(gradient);
                if length > 0.0 {
                    self.rows.extend(gradient.iter().map(|g| g / length));
                    self.rows.push(0.0);
                    self.limits.push(0.0);
                }
            }
        }
        for (i, &u) in coordinates.iter().enumerate() {
            for (sign, room) in [(1.0, 1.0 - u), (-1.0, u)] {
                if room <= 1e-9 {
                    let at = self.rows.len();
                    self.rows.resize(at + size, 0.0);
                    self.rows[at + i] = sign;
                    self.limits.push(0.0);
                }
            }
        }
        self.programme_hessian.clear();
        self.programme_hessian.resize(size * size, 0.0);
        for i in 0..n {
            self.programme_hessian[i * size + i] = 1.0;
        }
        self.programme_hessian[n * size + n] = CURVATURE;
        self.linear.clear();
        self.linear.resize(size, 0.0);
        self.linear[n] = 1.0;
        self.quadratic
            .solve(
                &self.programme_hessian,
                &self.linear,
                &self.rows,
                &self.limits,
            )
            .ok()?;
        Some(norm(&self.quadratic.solution()[..n]))
    }

    /// The certificate at any point, from pieces asked for there.
    pub(crate) fn certify<P: Problem>(
        &mut self,
        evaluator: &mut Evaluator<'_, P>,
        coordinates: &[f64],
        value: Value,
    ) -> Option<f64> {
        if value.is_failed() || !evaluator.pieces(coordinates, Accuracy::Fine, &mut self.pieces) {
            return None;
        }
        self.model.fill(&self.pieces);
        self.certificate(coordinates, value, evaluator.settings.magnitude)
    }
}

fn ratio(merit: f64, trial: Value, of: impl Fn(Value) -> f64, predicted: f64) -> f64 {
    if trial.is_failed() {
        -1.0
    } else {
        (merit - of(trial)) / predicted
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}
