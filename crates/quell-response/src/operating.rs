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
const LATER: f64 = 1.618_033_988_749_895;
/// How much derivatives or rates may differ by rounding, relative to the largest of their row.
const ROUNDING: f64 = 1e-9;

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
        if here.differs(&later) > ROUNDING || here.jumps(&later) > ROUNDING {
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
    linear: Linearised,
}

impl Look {
    fn at(prepared: &mut Prepared<'_>, t: f64, x: &[f64]) -> Self {
        let mut rates = vec![0.0; x.len()];
        prepared.rates(t, x, &mut rates);
        let linear = prepared.linearise(t, x);
        Self { rates, linear }
    }

    /// Largest difference of a derivative, over the largest entry of its row.
    fn differs(&self, other: &Self) -> f64 {
        let [states, inputs, _] = self.linear.sizes;
        let (one, two) = (&self.linear, &other.linear);
        let mut most = change(&one.a, &two.a, states).max(change(&one.c, &two.c, states));
        for (one, two) in one.b.iter().chain(&one.d).zip(two.b.iter().chain(&two.d)) {
            most = most.max(change(one, two, inputs));
        }
        most
    }

    /// Largest difference of a rate, over what the derivatives make of a state of size one.
    fn jumps(&self, other: &Self) -> f64 {
        let states = self.rates.len();
        let rows = self.linear.a.chunks(states.max(1));
        self.rates
            .iter()
            .zip(&other.rates)
            .zip(rows)
            .map(|((one, two), row)| {
                let size = row.iter().fold(one.abs().max(two.abs()), |most, entry| {
                    most.max(entry.abs())
                });
                ratio((one - two).abs(), size)
            })
            .fold(0.0, f64::max)
    }
}

fn change(one: &[f64], two: &[f64], width: usize) -> f64 {
    let mut most = 0.0_f64;
    for (one, two) in one.chunks(width.max(1)).zip(two.chunks(width.max(1))) {
        let size = one
            .iter()
            .chain(two)
            .fold(0.0_f64, |size, entry| size.max(entry.abs()));
        for (one, two) in one.iter().zip(two) {
            most = most.max(ratio((one - two).abs(), size));
        }
    }
    most
}

fn ratio(part: f64, whole: f64) -> f64 {
    if part == 0.0 {
        0.0
    } else if part.is_nan() || whole.is_nan() {
        f64::INFINITY
    } else {
        part / whole
    }
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
        let [mut kink, mut jump] = [[0.0_f64; 2]; 2];
        for (place, share) in [1.0, 0.01].into_iter().enumerate() {
            let sides = [share, -share].map(|share| Look::at(prepared, 0.0, &beside(share)));
            for side in &sides {
                kink[place] = kink[place].max(here.differs(side));
            }
            jump[place] = sides[0].jumps(&sides[1]);
        }
        let at = format!("`{}`", prepared.system().states()[index].name);
        // What is smooth shrinks to a hundredth; a root to a tenth.
        let stays = |change: [f64; 2]| change[1] > ROUNDING && change[1] > 0.3 * change[0];
        if stays(jump) {
            return Err(OperatingError::Jump { at });
        }
        if stays(kink) {
            return Err(OperatingError::Kink { at });
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
