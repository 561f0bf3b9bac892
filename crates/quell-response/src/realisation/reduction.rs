//! The stamped second-order system and its reduction to first order.

use super::StateSpace;
use super::map::Map;
use crate::assembly::Assembly;
use crate::dense::{Dense, Lu, Scalar};
use crate::error::ResponseError;
use crate::structure::Structure;

/// Stamped matrices in the coordinates y.
pub(super) struct Stamped<T> {
    mass: Dense<T>,
    damping: Dense<T>,
    stiffness: Dense<T>,
    forcing: [Dense<T>; 3],
}

impl Assembly {
    pub(super) fn stamped<T: Scalar>(
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

pub(super) fn reduce<T: Scalar>(
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
