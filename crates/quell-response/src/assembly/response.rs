//! The direct frequency response: one factorisation of the stamped nodal system at each frequency.

use num_complex::Complex64;
use quell_model::linear::LinearForm;

use super::{Assembly, OutputTerm};
use crate::dense::Dense;
use crate::error::ResponseError;

impl Assembly {
    /// The stamped dynamic stiffness -ω² M + jω C + K + j K_loss at one frequency.
    fn dynamic_stiffness(&self, values: &[f64], omega: f64) -> Dense<Complex64> {
        let powers = powers(omega);
        let n = self.host.coordinates.len();
        let mut matrix = Dense::zeros(self.size, self.size);
        for i in 0..n {
            for j in 0..n {
                let loss = self.loss.as_ref().map_or(0.0, |loss| loss.get(i, j));
                let value = Complex64::new(
                    self.stiffness.get(i, j),
                    if omega > 0.0 { loss } else { 0.0 },
                ) + powers[1] * self.damping.get(i, j)
                    + powers[2] * self.mass.get(i, j);
                matrix.set(i, j, value);
            }
        }
        for stamp in &self.stamps {
            let value = powers[stamp.order] * values[stamp.value];
            for &(i, a) in &stamp.row.coordinates {
                for &(j, b) in &stamp.row.coordinates {
                    matrix.add(i, j, value * (a * b));
                }
            }
        }
        matrix
    }

    fn excitation(&self, values: &[f64], input: usize, omega: f64) -> Dense<Complex64> {
        let powers = powers(omega);
        let mut right = Dense::zeros(self.size, 1);
        for i in 0..self.host.coordinates.len() {
            let force: Complex64 = (0..3)
                .map(|k| powers[k] * self.forcing[k].get(i, input))
                .sum();
            right.set(i, 0, force);
        }
        for stamp in &self.stamps {
            let from_input = stamp.row.input(input);
            if from_input != 0.0 {
                let value = powers[stamp.order] * (values[stamp.value] * from_input);
                for &(i, a) in &stamp.row.coordinates {
                    right.add(i, 0, -value * a);
                }
            }
        }
        right
    }

    /// The transfer function H(jω) from an input as it is given to an output, by one LU of the stamped nodal system.
    ///
    /// `omega` in rad/s. This is the reference that every faster path is held against.
    ///
    /// # Errors
    /// Where `values` do not fit, the input or a signal does not exist, or an undamped mode lies on ω.
    pub fn direct_response(
        &self,
        values: &[f64],
        input: usize,
        form: &LinearForm,
        omega: f64,
    ) -> Result<Complex64, ResponseError> {
        self.check_values(values)?;
        self.check_input(input)?;
        let terms = self.output_terms(form)?;
        self.direct_terms(values, input, &terms, omega, None)
    }

    /// H(jω) and its exact derivatives by every element value, by one LU of the stamped system (adjoint method).
    ///
    /// # Errors
    /// As [`Assembly::direct_response`]; also where `gradient` has another length than the values.
    pub fn direct_gradient(
        &self,
        values: &[f64],
        input: usize,
        form: &LinearForm,
        omega: f64,
        gradient: &mut [Complex64],
    ) -> Result<Complex64, ResponseError> {
        self.check_values(values)?;
        self.check_input(input)?;
        if gradient.len() != self.elements {
            return Err(ResponseError::ValueCount {
                expected: self.elements,
                found: gradient.len(),
            });
        }
        let terms = self.output_terms(form)?;
        self.direct_terms(values, input, &terms, omega, Some(gradient))
    }

    pub(crate) fn direct_terms(
        &self,
        values: &[f64],
        input: usize,
        terms: &[OutputTerm],
        omega: f64,
        gradient: Option<&mut [Complex64]>,
    ) -> Result<Complex64, ResponseError> {
        if !omega.is_finite() {
            return Err(ResponseError::NotFinite {
                what: "the frequency".into(),
            });
        }
        let singular = || ResponseError::SingularAt {
            hz: omega / std::f64::consts::TAU,
        };
        let matrix = self.dynamic_stiffness(values, omega);
        let lu = matrix.lu().ok_or_else(singular)?;
        let z = lu.solve(&self.excitation(values, input, omega));
        let powers = powers(omega);
        let factor = Complex64::ONE / powers_of(omega, self.host.inputs[input].kind.integrations());
        let weight = |term: &OutputTerm| {
            powers[term.order] * (term.coefficient * term.value.map_or(1.0, |index| values[index]))
        };
        let response: Complex64 = terms
            .iter()
            .map(|term| weight(term) * term.row.apply(z.data(), input))
            .sum::<Complex64>()
            * factor;
        if !response.is_finite() {
            return Err(singular());
        }
        if let Some(gradient) = gradient {
            gradient.fill(Complex64::ZERO);
            let mut right = Dense::zeros(self.size, 1);
            for term in terms {
                for &(i, a) in &term.row.coordinates {
                    right.add(i, 0, weight(term) * a);
                }
                if let Some(index) = term.value {
                    gradient[index] += powers[term.order]
                        * term.coefficient
                        * term.row.apply(z.data(), input)
                        * factor;
                }
            }
            let adjoint = matrix.transpose().lu().ok_or_else(singular)?.solve(&right);
            for stamp in &self.stamps {
                let through: Complex64 = stamp
                    .row
                    .coordinates
                    .iter()
                    .map(|&(i, a)| adjoint.get(i, 0) * a)
                    .sum();
                gradient[stamp.value] -=
                    powers[stamp.order] * through * stamp.row.apply(z.data(), input) * factor;
            }
        }
        Ok(response)
    }
}

/// 1, jω, (jω)².
pub(crate) fn powers(omega: f64) -> [Complex64; 3] {
    [
        Complex64::ONE,
        Complex64::new(0.0, omega),
        Complex64::new(-omega * omega, 0.0),
    ]
}

/// (jω)^order.
pub(crate) fn powers_of(omega: f64, order: usize) -> Complex64 {
    (0..order).fold(Complex64::ONE, |power, _| {
        power * Complex64::new(0.0, omega)
    })
}
