//! Linear systems that are given as first-order equations: systems of equations linearised at a point.

mod drift;

use std::f64::consts::TAU;

use num_complex::Complex64;
use quell_model::system::Linearised;

use crate::certificate::{Bound, Certificate};
use crate::dense::Dense;
use crate::eigen::{balance, eigen};
use crate::error::ResponseError;
use crate::modes::{Mode, ModeKind, Modes};
use crate::norm::{Norm, Response, Spectrum, white};
use crate::realisation::Channel;

/// A linear system x' = A x + Σ_m B_m u^(m) with outputs y = C x + Σ_m D_m u^(m), m = 0, 1, 2.
///
/// u^(m) is the m-th time derivative of the inputs, so that H(s) = C (s I - A)^-1 Σ B_m s^m + Σ D_m s^m. It has what an
/// [`Assembly`](crate::Assembly) has: responses, certified peaks, norms, modes.
///
/// Motions that nothing pushes back (a free body, the integral of an input) make A singular. They are taken out by
/// elimination before anything else is computed, so far as the output does not see them or the input does not move them;
/// an entry counts as zero where what cancels in it is 1e13 times as large.
#[derive(Debug, Clone)]
pub struct FirstOrder {
    a: Dense<f64>,
    b: [Dense<f64>; 3],
    c: Dense<f64>,
    d: [Dense<f64>; 3],
}

impl FirstOrder {
    /// Takes over a system that was linearised.
    ///
    /// # Errors
    /// Where an array has a wrong length or a derivative is not finite.
    pub fn new(linear: &Linearised) -> Result<Self, ResponseError> {
        let [states, inputs, outputs] = linear.sizes;
        let matrix = |data: &[f64], rows: usize, columns: usize, what: &str| {
            if data.len() != rows * columns {
                return Err(ResponseError::Shape {
                    host: NAME.into(),
                    what: what.into(),
                    expected: rows * columns,
                    found: data.len(),
                });
            }
            let matrix = Dense::from_fn(rows, columns, |i, j| data[i * columns + j]);
            if matrix.is_finite() {
                Ok(matrix)
            } else {
                Err(ResponseError::NotFinite {
                    what: format!("the derivative {what} of the equations"),
                })
            }
        };
        let [b0, b1, b2] = &linear.b;
        let [d0, d1, d2] = &linear.d;
        Ok(Self {
            a: matrix(&linear.a, states, states, "A")?,
            b: [
                matrix(b0, states, inputs, "B")?,
                matrix(b1, states, inputs, "B")?,
                matrix(b2, states, inputs, "B")?,
            ],
            c: matrix(&linear.c, outputs, states, "C")?,
            d: [
                matrix(d0, outputs, inputs, "D")?,
                matrix(d1, outputs, inputs, "D")?,
                matrix(d2, outputs, inputs, "D")?,
            ],
        })
    }

    /// Number of states.
    #[must_use]
    pub fn states(&self) -> usize {
        self.a.rows()
    }

    /// Number of inputs.
    #[must_use]
    pub fn inputs(&self) -> usize {
        self.b[0].columns()
    }

    /// Number of outputs.
    #[must_use]
    pub fn outputs(&self) -> usize {
        self.c.rows()
    }

    /// H(jω) from an input to an output, ω in rad/s.
    ///
    /// # Errors
    /// Where there is no such input or output, or an undamped mode that the output sees lies on ω.
    pub fn response(
        &self,
        input: usize,
        output: usize,
        omega: f64,
    ) -> Result<Complex64, ResponseError> {
        if !omega.is_finite() {
            return Err(ResponseError::NotFinite {
                what: "the frequency".into(),
            });
        }
        direct(&self.channel(input, output)?, omega)
    }

    /// Responses at many frequencies (rad/s), as [`Self::response`] has them; not-a-number where there is none.
    ///
    /// # Errors
    /// Where there is no such input or output.
    pub fn responses(
        &self,
        input: usize,
        output: usize,
        omegas: &[f64],
    ) -> Result<Vec<Complex64>, ResponseError> {
        let channel = self.channel(input, output)?;
        let nothing = Complex64::new(f64::NAN, f64::NAN);
        Ok(omegas
            .iter()
            .map(|omega| direct(&channel, *omega).unwrap_or(nothing))
            .collect())
    }

    /// The largest |H(jω)| over a band (rad/s) with a bound, as [`certify`](crate::certify) has it.
    ///
    /// The two ways of evaluating H are an LU factorisation at each frequency and partial fractions.
    ///
    /// # Errors
    /// Where input, output, band or tolerance do not fit.
    pub fn certify(
        &self,
        input: usize,
        output: usize,
        band: (f64, f64),
        tolerance: f64,
    ) -> Result<Certificate, ResponseError> {
        let channel = self.channel(input, output)?;
        Bound::new(&|omega| direct(&channel, omega), band, tolerance)?.run(&channel)
    }

    /// ‖H‖₂² over all frequencies or a band (rad/s), or the variance for a spectrum, as [`h2`](crate::h2) has it.
    ///
    /// # Errors
    /// As [`h2`](crate::h2).
    pub fn h2(
        &self,
        input: usize,
        output: usize,
        band: Option<(f64, f64)>,
        spectrum: Option<&Spectrum<'_>>,
    ) -> Result<Norm, ResponseError> {
        let (channel, drifts) = self.reduced(input, output)?;
        Response::new(channel.clone(), drifts, &|omega| direct(&channel, omega))?
            .norm(band, spectrum)
    }

    /// ‖H‖₂² over all frequencies by the Lyapunov equation alone, for search loops.
    ///
    /// # Errors
    /// As [`h2_fast`](crate::h2_fast).
    pub fn h2_fast(&self, input: usize, output: usize) -> Result<f64, ResponseError> {
        match self.reduced(input, output)? {
            (_, true) => Err(ResponseError::Undamped { hz: 0.0 }),
            (channel, false) => white(&channel),
        }
    }

    /// The modes: as many eigenvalues as states, those of motions that nothing pushes back as rigid-body ones.
    ///
    /// Shapes are over the states, the largest entry 1.
    ///
    /// # Errors
    /// Where the eigenvalues cannot be computed.
    pub fn modes(&self) -> Result<Modes, ResponseError> {
        let rest = drift::without_drift(&self.a);
        let (eigenvalues, vectors) = eigen(&rest.a)?;
        let mut modes: Vec<Mode> = rest
            .drifts()
            .into_iter()
            .map(|shape| Mode {
                eigenvalue: Complex64::ZERO,
                frequency_hz: 0.0,
                damping_ratio: 0.0,
                kind: ModeKind::RigidBody,
                shape: normalised(shape),
            })
            .collect();
        for (index, &eigenvalue) in eigenvalues.iter().enumerate() {
            if eigenvalue.im < 0.0 {
                continue;
            }
            let size = eigenvalue.norm();
            let shape = (0..rest.a.rows()).map(|i| vectors.get(i, index)).collect();
            modes.push(Mode {
                eigenvalue,
                frequency_hz: size / TAU,
                damping_ratio: if size > 0.0 {
                    -eigenvalue.re / size
                } else {
                    0.0
                },
                kind: if eigenvalue.im == 0.0 {
                    ModeKind::Real
                } else {
                    ModeKind::Oscillatory
                },
                shape: normalised(rest.expand(shape, eigenvalue)),
            });
        }
        modes.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
        let scale = balance(&rest.a).0.norm();
        Ok(Modes { modes, scale })
    }

    fn channel(&self, input: usize, output: usize) -> Result<Channel<f64>, ResponseError> {
        Ok(self.reduced(input, output)?.0)
    }

    /// One input, one output, without derivatives of the input in the state equation and without motions that do not
    /// matter to them, in balanced coordinates; and whether the output drifts all the same.
    fn reduced(&self, input: usize, output: usize) -> Result<(Channel<f64>, bool), ResponseError> {
        for (what, index, count) in [
            ("input", input, self.inputs()),
            ("output", output, self.outputs()),
        ] {
            if index >= count {
                return Err(ResponseError::UnknownIndex {
                    host: NAME.into(),
                    what,
                    index,
                    count,
                });
            }
        }
        let n = self.states();
        let c = self.c.row(output).to_vec();
        let mut d: Vec<f64> = self.d.iter().map(|d| d.get(output, input)).collect();
        let mut b = [0, 1, 2].map(|m: usize| Dense::from_fn(n, 1, |i, _| self.b[m].get(i, input)));
        // x = x̃ + B_m u^(m-1), from the highest derivative down.
        for m in (1..b.len()).rev() {
            let carried = self.a.times(&b[m]);
            b[m - 1] = b[m - 1].plus(&carried);
            d[m - 1] += b[m].data().iter().zip(&c).map(|(b, c)| b * c).sum::<f64>();
        }
        while d.len() > 1 && d.last() == Some(&0.0) {
            d.pop();
        }
        let (mut channel, drifts) = drift::seen(Channel {
            a: self.a.clone(),
            b: b[0].data().to_vec(),
            c,
            d,
        });
        let (a, scale) = balance(&channel.a);
        channel.a = a;
        for ((b, c), scale) in channel.b.iter_mut().zip(&mut channel.c).zip(&scale) {
            *b /= scale;
            *c *= scale;
        }
        Ok((channel, drifts))
    }
}

/// By what messages call it: it has no name of its own.
const NAME: &str = "linearised";

fn direct(channel: &Channel<f64>, omega: f64) -> Result<Complex64, ResponseError> {
    channel
        .response(omega)
        .filter(|response| response.is_finite())
        .ok_or(ResponseError::SingularAt { hz: omega / TAU })
}

/// The largest entry 1.
fn normalised(mut shape: Vec<Complex64>) -> Vec<Complex64> {
    let largest = shape
        .iter()
        .copied()
        .max_by(|a, b| a.norm().total_cmp(&b.norm()))
        .filter(|value| value.norm() > 0.0);
    if let Some(largest) = largest {
        for entry in &mut shape {
            *entry /= largest;
        }
    }
    shape
}
