//! Operating points: a system of equations at its static equilibrium, and linearised there.

use quell_model::system::{Equilibrium, EquilibriumStatus, Linearised, Prepared};
use thiserror::Error;

use crate::error::ResponseError;
use crate::first_order::FirstOrder;

/// A system at rest, and the linear one that it is for small motions about that.
#[derive(Debug, Clone)]
pub struct OperatingPoint {
    /// Where it rests.
    pub equilibrium: Equilibrium,
    /// The linear system; its outputs are the signals that the system watches, its inputs those of the host.
    pub linear: FirstOrder,
}

/// Why there is no operating point.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum OperatingError {
    /// No equilibrium was found.
    #[error(
        "no static equilibrium was found (relative residual {residual:.1e}); give `start` values near it in the host"
    )]
    NoEquilibrium {
        /// What is left, relative.
        residual: f64,
    },
    /// Equations that contain time.
    #[error(
        "the equations contain the time `t` and change with it, so that there is no static equilibrium about which they are linear; write what varies as an input"
    )]
    Moving,
    /// A jump of the rates at the equilibrium.
    #[error(
        "the equations jump at the static equilibrium, where {at} passes through its value there, so that no linear equations hold about it; smooth the jump, for example `tanh(v/v0)` for `sign(v)`"
    )]
    Jump {
        /// What passes.
        at: String,
    },
    /// A kink of the rates at the equilibrium.
    #[error(
        "the equations have a kink at the static equilibrium, where {at} passes through its value there, so that no linear equations hold about it; move the equilibrium off the kink, or smooth it"
    )]
    Kink {
        /// What passes.
        at: String,
    },
    /// The linear system cannot be used.
    #[error("about the static equilibrium {0}")]
    Linear(#[from] ResponseError),
}

/// A second moment, at which equations that do not contain time are the same.
const LATER: f64 = 1.7;
/// Rounding errors of a derivative over the largest of its row, and of a rate over the terms that cancel in it.
const ROUNDING: f64 = 1e-13;

impl OperatingPoint {
    /// Finds the static equilibrium near where a run would begin (`start` values of the host), and linearises there.
    ///
    /// Inputs take no part in it: whatever signal the host or a run gives them, they rest at zero, with their rates. The
    /// linear equations hold for motions so small that no nonlinearity shows. Where the rates or their derivatives are
    /// not continuous there, no linear equations hold at all, which is told by looking at both sides, a millionth of
    /// each state away and a hundredth of that: what changes in proportion is smooth.
    ///
    /// # Errors
    /// No equilibrium; equations that contain time; a jump or a kink there; derivatives that are not finite.
    pub fn find(prepared: &mut Prepared<'_>) -> Result<Self, OperatingError> {
        for input in 0..prepared.system().inputs() {
            prepared.set_waveform(input, None);
        }
        prepared.forget();
        let guess = prepared.start(0.0);
        let equilibrium = prepared.equilibrium(0.0, &guess);
        if equilibrium.status == EquilibriumStatus::NotFound {
            return Err(OperatingError::NoEquilibrium {
                residual: equilibrium.residual,
            });
        }
        let x = &equilibrium.state;
        let here = Look::at(prepared, 0.0, x);
        let linear = FirstOrder::new(&here.linear)?;
        let later = Look::at(prepared, LATER, x);
        let rounding = here.rounding();
        if more(&here.changes(&later), &rounding) {
            return Err(OperatingError::Moving);
        }
        smooth(prepared, x, &here)?;
        Ok(Self {
            equilibrium,
            linear,
        })
    }
}

/// Rates and derivatives at a point.
struct Look {
    rates: Vec<f64>,
    /// What cancels in each rate, Σ |∂f/∂x_j x_j|.
    terms: Vec<f64>,
    /// Rows of [A, B_0, B_1, B_2], then of [C, D_0, D_1, D_2].
    slopes: Vec<Vec<f64>>,
    linear: Linearised,
}

impl Look {
    fn at(prepared: &mut Prepared<'_>, t: f64, x: &[f64]) -> Self {
        // What Newton's method finds shall not depend on where it was before.
        prepared.forget();
        let mut rates = vec![0.0; x.len()];
        prepared.rates(t, x, &mut rates);
        let linear = prepared.linearise(t, x);
        let [states, inputs, outputs] = linear.sizes;
        let row = |first: &[f64], then: &[Vec<f64>; 3], i: usize| -> Vec<f64> {
            let blocks = then
                .iter()
                .flat_map(|block| &block[i * inputs..(i + 1) * inputs]);
            first[i * states..(i + 1) * states]
                .iter()
                .chain(blocks)
                .copied()
                .collect()
        };
        let own = (0..states).map(|i| row(&linear.a, &linear.b, i));
        let watched = (0..outputs).map(|i| row(&linear.c, &linear.d, i));
        let slopes: Vec<Vec<f64>> = own.chain(watched).collect();
        let terms = slopes[..states]
            .iter()
            .map(|row| row.iter().zip(x).map(|(a, x)| (a * x).abs()).sum())
            .collect();
        Self {
            rates,
            terms,
            slopes,
            linear,
        }
    }

    /// What is rounding in each rate and each derivative.
    fn rounding(&self) -> Changes {
        Changes {
            rates: self.terms.iter().map(|terms| ROUNDING * terms).collect(),
            slopes: self
                .slopes
                .iter()
                .flat_map(|row| {
                    let largest = row
                        .iter()
                        .fold(0.0_f64, |most, entry| most.max(entry.abs()));
                    vec![ROUNDING * largest; row.len()]
                })
                .collect(),
        }
    }

    /// How much rates and derivatives change to another point.
    fn changes(&self, other: &Self) -> Changes {
        let change = |(one, two): (&f64, &f64)| (one - two).abs();
        Changes {
            rates: self.rates.iter().zip(&other.rates).map(change).collect(),
            slopes: self
                .slopes
                .iter()
                .flatten()
                .zip(other.slopes.iter().flatten())
                .map(change)
                .collect(),
        }
    }
}

/// One number for each rate, one for each derivative.
struct Changes {
    rates: Vec<f64>,
    slopes: Vec<f64>,
}

/// Whether any change is more than rounding, or no number.
fn more(changes: &Changes, rounding: &Changes) -> bool {
    let pairs = |changes: &[f64], rounding: &[f64]| {
        changes
            .iter()
            .zip(rounding)
            .any(|(change, rounding)| change > rounding || change.is_nan())
    };
    pairs(&changes.rates, &rounding.rates) || pairs(&changes.slopes, &rounding.slopes)
}

/// Whether something changes as much a hundredth of the way off as all the way: smooth changes are a hundredth, roots a tenth.
fn stays(near: &[f64], far: &[f64], rounding: &[f64]) -> bool {
    near.iter()
        .zip(far)
        .zip(rounding)
        .any(|((near, far), rounding)| near.is_nan() || (near > rounding && *near > 0.3 * far))
}

/// Refuses a point at which margins of pieces vanish and the pieces do not fit together in value and slope.
fn smooth(prepared: &mut Prepared<'_>, x: &[f64], here: &Look) -> Result<(), OperatingError> {
    let count = prepared.system().switches();
    if count == 0 {
        return Ok(());
    }
    let margins = |prepared: &mut Prepared<'_>, x: &[f64]| {
        let mut values = vec![0.0; count];
        prepared.switches(0.0, x, &mut values);
        values
    };
    let rounding = here.rounding();
    let own = margins(prepared, x);
    let mut moved = vec![false; count];
    for (index, value) in x.iter().enumerate() {
        // A nanometre where a length is zero.
        let far = 1e-6 * value.abs() + 1e-9;
        let beside = |share: f64| {
            let mut beside = x.to_vec();
            beside[index] += share * far;
            beside
        };
        let mut crosses = false;
        for side in [1.0, -1.0] {
            let there = margins(prepared, &beside(side));
            for ((own, there), moved) in own.iter().zip(&there).zip(&mut moved) {
                *moved |= own != there;
                // On the margin, or on the other side of it.
                crosses |= own != there && own * there <= 0.0;
            }
        }
        if !crosses {
            continue;
        }
        let look = |prepared: &mut Prepared<'_>, share: f64| {
            [share, -share].map(|share| Look::at(prepared, 0.0, &beside(share)))
        };
        let (far, near) = (look(prepared, 1.0), look(prepared, 0.01));
        let at = format!("`{}`", prepared.system().states()[index].name);
        let across = [&near, &far].map(|sides| sides[0].changes(&sides[1]).rates);
        if stays(&across[0], &across[1], &rounding.rates) {
            return Err(OperatingError::Jump { at });
        }
        for (near, far) in near.iter().zip(&far) {
            let slopes = [near, far].map(|side| here.changes(side).slopes);
            if stays(&slopes[0], &slopes[1], &rounding.slopes) {
                return Err(OperatingError::Kink { at });
            }
        }
    }
    // A margin that no state moves is one of inputs.
    if own
        .iter()
        .zip(&moved)
        .any(|(own, moved)| *own == 0.0 && !moved)
    {
        return Err(OperatingError::Kink {
            at: "an input".into(),
        });
    }
    Ok(())
}
