//! The minimal first-order form of the assembled system.
//!
//! ```text
//! x' = A x + B u,      z^(k) = X_k x + Σ_m U_km u^(m),   k = 0, 1, 2
//! ```
//!
//! Derivatives of the inputs are moved from the state equation to the outputs by the substitution x = x̃ + B_1 u + …,
//! so that H(s) = C (s I - A)^-1 B + D_0 + D_1 s + D_2 s² + …

mod channel;
mod map;
mod reduction;

use num_complex::Complex64;
use quell_model::linear::LinearForm;

use crate::assembly::Assembly;
use crate::dense::{Dense, Scalar};
use crate::error::ResponseError;
use crate::structure::Structure;

use map::Map;
use reduction::reduce;

pub(crate) use channel::Channel;

/// The first-order form over the real numbers or, with loss factors, the complex ones.
#[derive(Debug, Clone)]
pub(crate) struct StateSpace<T> {
    pub(crate) a: Dense<T>,
    pub(crate) b: Dense<T>,
    /// z, z', z''.
    pub(crate) z: [Map<T>; 3],
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
