//! The minimal first-order form of the assembled system.
//!
//! ```text
//! x' = A x + B u,      z^(k) = X_k x + Σ_m U_km u^(m),   k = 0, 1, 2
//! ```
//!
//! Derivatives of the inputs are moved from the state equation to the outputs by the substitution x = x̃ + B_1 u + …,
//! so that H(s) = C (s I - A)^-1 B + D_0 + D_1 s + D_2 s² + …

use num_complex::Complex64;
use quell_model::linear::LinearForm;

use crate::assembly::{Assembly, OutputTerm};
use crate::dense::{Dense, Lu, Scalar};
use crate::error::ResponseError;
use crate::structure::Structure;

/// A quantity as rows over the state and over the inputs' derivatives.
#[derive(Debug, Clone)]
pub(crate) struct Map<T> {
    pub(crate) state: Dense<T>,
    /// Factor of u, u', u'' …
    pub(crate) input: Vec<Dense<T>>,
}

impl<T: Scalar> Map<T> {
    fn of_state(state: Dense<T>) -> Self {
        Self {
            state,
            input: Vec::new(),
        }
    }

    fn of_input(rows: usize, states: usize, input: Vec<Dense<T>>) -> Self {
        Self {
            state: Dense::zeros(rows, states),
            input,
        }
    }

    fn rows(&self) -> usize {
        self.state.rows()
    }

    fn left(&self, matrix: &Dense<T>) -> Self {
        Self {
            state: matrix.times(&self.state),
            input: self.input.iter().map(|block| matrix.times(block)).collect(),
        }
    }

    fn solved(&self, lu: &Lu<T>) -> Self {
        Self {
            state: lu.solve(&self.state),
            input: self.input.iter().map(|block| lu.solve(block)).collect(),
        }
    }

    fn combine(&self, other: &Self, factor: f64) -> Self {
        let longest = self.input.len().max(other.input.len());
        let input = (0..longest)
            .map(|k| match (self.input.get(k), other.input.get(k)) {
                (Some(a), Some(b)) => a.plus(&b.scale(factor)),
                (Some(a), None) => a.clone(),
                (None, Some(b)) => b.scale(factor),
                (None, None) => Dense::zeros(self.rows(), 0),
            })
            .collect();
        Self {
            state: self.state.plus(&other.state.scale(factor)),
            input,
        }
    }

    fn plus(&self, other: &Self) -> Self {
        self.combine(other, 1.0)
    }

    fn minus(&self, other: &Self) -> Self {
        self.combine(other, -1.0)
    }

    fn select(&self, rows: &[usize]) -> Self {
        let pick = |block: &Dense<T>| {
            Dense::from_fn(rows.len(), block.columns(), |i, j| block.get(rows[i], j))
        };
        Self {
            state: pick(&self.state),
            input: self.input.iter().map(pick).collect(),
        }
    }

    fn stacked(&self, below: &Self, inputs: usize) -> Self {
        let longest = self.input.len().max(below.input.len());
        let join = |a: Option<&Dense<T>>, b: Option<&Dense<T>>, width: usize| {
            let mut all = Dense::zeros(self.rows() + below.rows(), width);
            if let Some(a) = a {
                all.place(0, 0, a);
            }
            if let Some(b) = b {
                all.place(self.rows(), 0, b);
            }
            all
        };
        Self {
            state: join(Some(&self.state), Some(&below.state), self.state.columns()),
            input: (0..longest)
                .map(|k| join(self.input.get(k), below.input.get(k), inputs))
                .collect(),
        }
    }

    /// Time derivative, given that of the state.
    fn derivative(&self, rate: &Self, inputs: usize) -> Self {
        let mut shifted = vec![Dense::zeros(self.rows(), inputs)];
        shifted.extend(self.input.iter().cloned());
        rate.left(&self.state)
            .plus(&Self::of_input(self.rows(), rate.state.columns(), shifted))
    }
}

/// The first-order form over the real numbers or, with loss factors, the complex ones.
#[derive(Debug, Clone)]
pub(crate) struct StateSpace<T> {
    pub(crate) a: Dense<T>,
    pub(crate) b: Dense<T>,
    /// z, z', z''.
    pub(crate) z: [Map<T>; 3],
}

/// Stamped matrices in the coordinates y.
struct Stamped<T> {
    mass: Dense<T>,
    damping: Dense<T>,
    stiffness: Dense<T>,
    forcing: [Dense<T>; 3],
}

impl Assembly {
    /// The minimal first-order realisation at the given values.
    ///
    /// # Errors
    /// Where values do not fit, the host has loss factors, or a matrix that must be inverted is singular at the values.
    pub fn realise(&self, values: &[f64]) -> Result<Realisation, ResponseError> {
        self.check_values(values)?;
        self.no_loss("a realisation in time")?;
        let space = self.state_space(&self.structure, values, 1.0_f64, |k, _| k)?;
        Ok(Realisation {
            space,
            inputs: self.host.inputs.len(),
        })
    }

    /// The state space with `complex(k, loss)` as stiffness entries.
    pub(crate) fn state_space<T: Scalar>(
        &self,
        structure: &Structure,
        values: &[f64],
        _unit: T,
        entry: impl Fn(f64, f64) -> T,
    ) -> Result<StateSpace<T>, ResponseError> {
        let stamped = self.stamped(structure, values, entry);
        let inputs = self.host.inputs.len();
        let space = reduce(structure, &stamped, inputs)?;
        if !space.a.is_finite() || !space.b.is_finite() {
            return Err(ResponseError::Singular {
                what: "the system of equations",
            });
        }
        Ok(space)
    }

    fn stamped<T: Scalar>(
        &self,
        structure: &Structure,
        values: &[f64],
        entry: impl Fn(f64, f64) -> T,
    ) -> Stamped<T> {
        let (n, size, inputs) = (
            self.host.coordinates.len(),
            self.size,
            self.host.inputs.len(),
        );
        let rows = structure.transform.block(0..n, 0..size).map(T::real);
        let columns = rows.transpose();
        let congruent = |matrix: &Dense<T>| columns.times(&matrix.times(&rows));
        let zero = Dense::zeros(n, n);
        let loss = self.loss.as_ref().unwrap_or(&zero);
        let stiffness =
            Dense::from_fn(n, n, |i, j| entry(self.stiffness.get(i, j), loss.get(i, j)));
        let mut matrices = [
            congruent(&stiffness),
            congruent(&self.damping.map(T::real)),
            congruent(&self.mass.map(T::real)),
        ];
        let mut forcing = [0, 1, 2].map(|k| columns.times(&self.forcing[k].map(T::real)));
        for (stamp, incidence) in self.stamps.iter().zip(&structure.incidence) {
            let value = values[stamp.value];
            let support: Vec<usize> = (0..size).filter(|&i| incidence[i] != 0.0).collect();
            for &i in &support {
                let scaled = value * incidence[i];
                for &j in &support {
                    matrices[stamp.order].add(i, j, T::real(scaled * incidence[j]));
                }
                for &(input, g) in &stamp.row.inputs {
                    if input < inputs {
                        forcing[stamp.order].add(i, input, T::real(-scaled * g));
                    }
                }
            }
        }
        let [stiffness, damping, mass] = matrices;
        Stamped {
            mass,
            damping,
            stiffness,
            forcing,
        }
    }
}

fn factor<T: Scalar>(matrix: &Dense<T>, what: &'static str) -> Result<Lu<T>, ResponseError> {
    matrix
        .lu()
        .filter(|lu| lu.pivot_ratio() > 0.0)
        .ok_or(ResponseError::Singular { what })
}

fn reduce<T: Scalar>(
    structure: &Structure,
    stamped: &Stamped<T>,
    inputs: usize,
) -> Result<StateSpace<T>, ResponseError> {
    let [na, n1, n2, n3] = structure.counts;
    let n12 = n1 + n2;
    let (a, one, two, three) = (
        0..na,
        na..na + n1,
        na + n1..na + n12,
        na + n12..na + n12 + n3,
    );
    let both = na..na + n12;
    let Stamped {
        mass,
        damping,
        stiffness,
        forcing,
    } = stamped;

    // Momentum coordinates: y_a = M_aa^-1 (F2_a u - M_a1 y_1).
    let mass_a = factor(
        &mass.block(a.clone(), a.clone()),
        "the mass matrix of nodes that only inerters hold",
    )?;
    let follow = mass_a.solve(&mass.block(a.clone(), one.clone()));
    let follow_input = mass_a.solve(&forcing[2].block(a.clone(), 0..inputs));
    let mass_1a = mass.block(one.clone(), a.clone());
    let mass_1 = mass
        .block(one.clone(), one.clone())
        .minus(&mass_1a.times(&follow));

    // Algebraic coordinates: y_3 = K_33^-1 (F_3 u - K_3b y_b).
    let held = factor(
        &stiffness.block(three.clone(), three.clone()),
        "the stiffness matrix of coordinates that only springs hold",
    )?;
    let spring_share = held.solve(&stiffness.block(three.clone(), both.clone()));
    let spring_input: Vec<Dense<T>> = forcing
        .iter()
        .map(|f| held.solve(&f.block(three.clone(), 0..inputs)))
        .collect();
    let stiffness_b3 = stiffness.block(both.clone(), three.clone());
    let stiffness_b = stiffness
        .block(both.clone(), both.clone())
        .minus(&stiffness_b3.times(&spring_share));
    let forces: Vec<Dense<T>> = (0..3)
        .map(|k| {
            let mut force = forcing[k]
                .block(both.clone(), 0..inputs)
                .minus(&stiffness_b3.times(&spring_input[k]));
            if k == 2 {
                let carried = mass_1a.times(&follow_input);
                for i in 0..n1 {
                    for j in 0..inputs {
                        force.set(i, j, force.get(i, j) - carried.get(i, j));
                    }
                }
            }
            force
        })
        .collect();

    // The state: displacements modulo neutral directions, then velocities of `1`.
    let w = structure.neutral_rows.len();
    let displacements = n12 - w;
    let states = displacements + n1;
    let picked = |rows: usize, first: usize| {
        Map::of_state(Dense::from_fn(rows, states, |i, j| {
            if j == first + i { T::ONE } else { T::ZERO }
        }))
    };
    let displacement = picked(displacements, 0);
    let velocity = picked(n1, displacements);
    let kept = |matrix: &Dense<T>| {
        Dense::from_fn(matrix.rows(), displacements, |i, j| {
            matrix.get(i, structure.kept_rows[j])
        })
    };
    let force_map = |rows: std::ops::Range<usize>| {
        Map::of_input(
            rows.len(),
            states,
            forces
                .iter()
                .map(|force| force.block(rows.clone(), 0..inputs))
                .collect(),
        )
    };
    let damping_2 = factor(
        &damping.block(two.clone(), two.clone()),
        "the damping matrix of coordinates without mass",
    )?;
    let rate_2 = force_map(n1..n12)
        .minus(&velocity.left(&damping.block(two.clone(), one.clone())))
        .minus(&displacement.left(&kept(&stiffness_b.block(n1..n12, 0..n12))))
        .solved(&damping_2);
    let mass_1 = factor(&mass_1, "the mass matrix")?;
    let acceleration = force_map(0..n1)
        .minus(&velocity.left(&damping.block(one.clone(), one.clone())))
        .minus(&rate_2.left(&damping.block(one.clone(), two.clone())))
        .minus(&displacement.left(&kept(&stiffness_b.block(0..n1, 0..n12))))
        .solved(&mass_1);
    let rate_b = velocity.stacked(&rate_2, inputs);
    let ratio = Dense::from_fn(displacements, w, |i, j| {
        T::real(structure.neutral.get(structure.kept_rows[i], j))
    });
    let rate_d = rate_b
        .select(&structure.kept_rows)
        .minus(&rate_b.select(&structure.neutral_rows).left(&ratio));
    let mut rate = rate_d.stacked(&acceleration, inputs);

    // Displacements of neutral directions follow from the momentum that no spring changes.
    let position_b = if w == 0 {
        let mut rows = displacement.clone();
        rows.state = Dense::from_fn(n12, states, |i, j| {
            if structure.kept_rows.get(j) == Some(&i) {
                T::ONE
            } else {
                T::ZERO
            }
        });
        rows
    } else {
        let neutral = structure.neutral.map(T::real);
        let neutral_t = neutral.transpose();
        let damping_b = damping.block(both.clone(), both.clone());
        let weighted = neutral_t.times(&damping_b);
        let spread = Dense::from_fn(n12, displacements, |i, j| {
            if structure.kept_rows[j] == i {
                T::ONE
            } else {
                T::ZERO
            }
        });
        let resisting = factor(
            &weighted.times(&neutral),
            "the damping of nodes that no spring holds",
        )?;
        let neutral_1 = neutral_t.block(0..w, 0..n1);
        let full_mass_1 = mass
            .block(one.clone(), one.clone())
            .minus(&mass_1a.times(&follow));
        let momentum_input = vec![neutral_t.times(&forces[1]), neutral_t.times(&forces[2])];
        let along = Map::of_input(w, states, momentum_input)
            .minus(&displacement.left(&weighted.times(&spread)))
            .minus(&velocity.left(&neutral_1.times(&full_mass_1)))
            .solved(&resisting);
        displacement.left(&spread).plus(&along.left(&neutral))
    };

    // Everything back to z, three derivatives, before inputs are shifted.
    let rate2_b = acceleration.stacked(&rate_2.derivative(&rate, inputs), inputs);
    let transform = structure.transform.map(T::real);
    let ones: Vec<usize> = (0..n1).collect();
    let mut z = [&position_b, &rate_b, &rate2_b].map(Clone::clone);
    for (order, map) in z.iter_mut().enumerate() {
        let shift = |blocks: Vec<Dense<T>>, rows: usize| {
            let mut shifted: Vec<Dense<T>> =
                (0..order).map(|_| Dense::zeros(rows, inputs)).collect();
            shifted.extend(blocks);
            Map::of_input(rows, states, shifted)
        };
        let third = shift(spring_input.clone(), n3).minus(&map.left(&spring_share));
        let momentum =
            shift(vec![follow_input.clone()], na).minus(&map.select(&ones).left(&follow));
        *map = momentum
            .stacked(map, inputs)
            .stacked(&third, inputs)
            .left(&transform);
    }

    // x = x̃ + B_k u^(k-1), from the highest derivative down.
    while rate.input.len() > 1 {
        let Some(highest) = rate.input.pop() else {
            break;
        };
        let k = rate.input.len();
        let carried = rate.state.times(&highest);
        rate.input[k - 1] = rate.input[k - 1].plus(&carried);
        for map in &mut z {
            while map.input.len() < k {
                map.input.push(Dense::zeros(map.state.rows(), inputs));
            }
            map.input[k - 1] = map.input[k - 1].plus(&map.state.times(&highest));
        }
    }
    let b = rate
        .input
        .pop()
        .unwrap_or_else(|| Dense::zeros(states, inputs));
    Ok(StateSpace {
        a: rate.state,
        b,
        z,
    })
}

/// One input, one output: H(s) = c (s I - A)^-1 b + Σ d_k s^k.
#[derive(Debug, Clone)]
pub(crate) struct Channel<T> {
    pub(crate) a: Dense<T>,
    pub(crate) b: Vec<T>,
    pub(crate) c: Vec<T>,
    pub(crate) d: Vec<T>,
}

impl<T: Scalar> StateSpace<T> {
    pub(crate) fn channel(
        &self,
        assembly: &Assembly,
        values: &[f64],
        input: usize,
        terms: &[OutputTerm],
    ) -> Result<Channel<T>, ResponseError> {
        let states = self.a.rows();
        let b: Vec<T> = (0..states).map(|i| self.b.get(i, input)).collect();
        let mut c = vec![T::ZERO; states];
        let mut d: Vec<T> = vec![T::ZERO; 3];
        for term in terms {
            let weight = term.coefficient * term.value.map_or(1.0, |index| values[index]);
            let map = &self.z[term.order];
            for &(i, factor) in &term.row.coordinates {
                for (entry, value) in c.iter_mut().zip(map.state.row(i)) {
                    *entry += *value * (factor * weight);
                }
                for (k, block) in map.input.iter().enumerate() {
                    if d.len() <= k {
                        d.push(T::ZERO);
                    }
                    d[k] += block.get(i, input) * (factor * weight);
                }
            }
            d[term.order] += T::real(term.row.input(input) * weight);
        }
        let mut channel = Channel {
            a: self.a.clone(),
            b,
            c,
            d,
        };
        for _ in 0..assembly.host.inputs[input].kind.integrations() {
            channel.integrate_input(assembly, input)?;
        }
        while channel.d.len() > 1 && channel.d.last().is_some_and(|last| last.modulus() == 0.0) {
            channel.d.pop();
        }
        Ok(channel)
    }
}

impl<T: Scalar> Channel<T> {
    /// H(s)/s: the state is shifted by the static solution, whose output must vanish.
    fn integrate_input(&mut self, assembly: &Assembly, input: usize) -> Result<(), ResponseError> {
        let n = self.a.rows();
        let right = Dense::from_fn(n, 1, |i, _| self.b[i]);
        let solved = match self.a.lu().filter(|lu| lu.pivot_ratio() > 1e-13) {
            Some(lu) => lu.solve(&right),
            None => least_squares(&self.a, &right),
        };
        let remainder = self.a.times(&solved).minus(&right);
        let static_response: T = solved
            .data()
            .iter()
            .zip(&self.c)
            .fold(self.d[0], |sum, (&x, &c)| sum - c * x);
        // What it is measured against: the terms that cancel, and the response at the system's own frequencies.
        let terms: f64 = solved
            .data()
            .iter()
            .zip(&self.c)
            .map(|(x, c)| (*x * *c).modulus())
            .sum();
        let norm = self.a.norm();
        let response = [1.0, 1e-1, 1e-2, 1e-3]
            .iter()
            .filter_map(|share| self.response(share * norm))
            .fold(0.0_f64, |largest, h| largest.max(h.norm()));
        let size = terms.max(self.d[0].modulus()).max(response);
        // Rounding leaves about 1e-13 of it; a true drift is a sizeable part.
        if static_response.modulus() > 1e-8 * size || remainder.largest() > 1e-8 * right.largest() {
            return Err(ResponseError::PoleAtZero {
                host: assembly.host.name.clone(),
                input: assembly.host.inputs[input].name.clone(),
                residue: static_response.modulus(),
            });
        }
        self.b = solved.data().to_vec();
        self.d.remove(0);
        if self.d.is_empty() {
            self.d.push(T::ZERO);
        }
        Ok(())
    }

    /// H(jω) by one LU.
    pub(crate) fn response(&self, omega: f64) -> Option<Complex64> {
        let n = self.a.rows();
        let s = Complex64::new(0.0, omega);
        let matrix = Dense::from_fn(n, n, |i, j| {
            (if i == j { s } else { Complex64::ZERO }) - self.a.get(i, j).complex()
        });
        let x = matrix
            .lu()?
            .solve(&Dense::from_fn(n, 1, |i, _| self.b[i].complex()));
        let dynamic: Complex64 = x
            .data()
            .iter()
            .zip(&self.c)
            .map(|(x, c)| x * c.complex())
            .sum();
        Some(dynamic + self.polynomial(s))
    }

    pub(crate) fn polynomial(&self, s: Complex64) -> Complex64 {
        self.d
            .iter()
            .rev()
            .fold(Complex64::ZERO, |sum, d| sum * s + d.complex())
    }
}

/// Least squares of a singular square system, by the pseudo-inverse of the complex matrix.
fn least_squares<T: Scalar>(matrix: &Dense<T>, right: &Dense<T>) -> Dense<T> {
    // Tikhonov-free: solve on the pivot rows and columns that elimination with complete pivoting finds.
    let n = matrix.rows();
    let mut work = matrix.clone();
    let mut rhs = right.clone();
    let mut columns: Vec<usize> = (0..n).collect();
    let mut rank = n;
    let cut = 1e-12 * matrix.largest();
    for k in 0..n {
        let mut best = (0.0, k, k);
        for i in k..n {
            for j in k..n {
                let size = work.get(i, columns[j]).modulus();
                if size > best.0 {
                    best = (size, i, j);
                }
            }
        }
        if best.0 <= cut {
            rank = k;
            break;
        }
        columns.swap(k, best.2);
        for j in 0..n {
            let (upper, lower) = (work.get(k, j), work.get(best.1, j));
            work.set(k, j, lower);
            work.set(best.1, j, upper);
        }
        let (upper, lower) = (rhs.get(k, 0), rhs.get(best.1, 0));
        rhs.set(k, 0, lower);
        rhs.set(best.1, 0, upper);
        for i in k + 1..n {
            let factor = work.get(i, columns[k]) / work.get(k, columns[k]);
            for &j in &columns[k..] {
                let value = work.get(k, j);
                work.add(i, j, -(factor * value));
            }
            let value = rhs.get(k, 0);
            rhs.add(i, 0, -(factor * value));
        }
    }
    let mut x = Dense::zeros(n, 1);
    for k in (0..rank).rev() {
        let mut value = rhs.get(k, 0);
        for &j in &columns[k + 1..rank] {
            value -= work.get(k, j) * x.get(j, 0);
        }
        x.set(columns[k], 0, value / work.get(k, columns[k]));
    }
    x
}

/// The minimal first-order form x' = A x + B u of an assembled system, real-valued.
///
/// Its order is [`Assembly::predicted_modes`]; outputs may contain derivatives of the inputs.
#[derive(Debug, Clone)]
pub struct Realisation {
    pub(crate) space: StateSpace<f64>,
    inputs: usize,
}

impl Realisation {
    /// Number of states.
    pub fn states(&self) -> usize {
        self.space.a.rows()
    }

    /// Number of inputs u.
    pub fn inputs(&self) -> usize {
        self.inputs
    }

    /// A (states × states), row-major, 1/s.
    pub fn state_matrix(&self) -> &[f64] {
        self.space.a.data()
    }

    /// B (states × inputs), row-major: the effect of u (forces and displacements, not velocities).
    pub fn input_matrix(&self) -> &[f64] {
        self.space.b.data()
    }

    /// The `order`-th derivative (0, 1, 2) of every coordinate and internal node: X (rows × states) and the factors
    /// U_m (rows × inputs) of the m-th derivatives of u, row-major.
    ///
    /// # Errors
    /// Where `order` exceeds 2.
    pub fn coordinates(&self, order: usize) -> Result<(&[f64], Vec<&[f64]>), ResponseError> {
        let map = self
            .space
            .z
            .get(order)
            .ok_or_else(|| ResponseError::DerivativeOrder {
                what: "the coordinates".into(),
                order,
                most: 2,
            })?;
        Ok((
            map.state.data(),
            map.input.iter().map(Dense::data).collect(),
        ))
    }

    /// H(jω) from an input as it is given to an output of `assembly`, which must be the one that was realised at `values`.
    ///
    /// # Errors
    /// Where a signal does not exist, an undamped mode lies on ω, or an integrated input makes the output drift.
    pub fn response(
        &self,
        assembly: &Assembly,
        values: &[f64],
        input: usize,
        form: &LinearForm,
        omega: f64,
    ) -> Result<Complex64, ResponseError> {
        assembly.check_values(values)?;
        assembly.check_input(input)?;
        if self.space.z[0].state.rows() != assembly.size
            || self.states() != assembly.predicted_modes()
        {
            return Err(ResponseError::Shape {
                host: assembly.host.name.clone(),
                what: "the realisation".into(),
                expected: assembly.predicted_modes(),
                found: self.states(),
            });
        }
        let terms = assembly.output_terms(form)?;
        let channel = self.space.channel(assembly, values, input, &terms)?;
        channel
            .response(omega)
            .filter(|value| value.is_finite())
            .ok_or(ResponseError::SingularAt {
                hz: omega / std::f64::consts::TAU,
            })
    }
}
