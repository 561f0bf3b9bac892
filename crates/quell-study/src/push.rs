//! Pushes from an equilibrium that are neither small nor wild: along its least damped modes, as far as the equations are nonlinear.

use num_complex::Complex64;
use quell_continuation::eigenpairs;

/// A push from an equilibrium.
pub(crate) struct Push {
    /// Where a motion begins.
    pub(crate) state: Vec<f64>,
    /// The equilibrium.
    pub(crate) rest: Vec<f64>,
    /// What each state is measured by: its largest excursion in the modes of the push.
    pub(crate) scale: Vec<f64>,
    /// The least damped eigenvalue among the modes of the push, 1/s and rad/s.
    pub(crate) leading: Complex64,
}

impl Push {
    /// Distance of a state from the equilibrium, in sizes of the push.
    pub(crate) fn size(&self, state: &[f64]) -> f64 {
        state
            .iter()
            .zip(&self.rest)
            .zip(&self.scale)
            .map(|((x, rest), scale)| (x - rest).abs() / scale)
            .fold(0.0, f64::max)
    }
}

/// An equilibrium that motions are pushed from.
pub(crate) struct Still<'a> {
    /// Its state.
    pub(crate) state: &'a [f64],
    /// `f_x` there, row major.
    pub(crate) matrix: &'a [f64],
    /// Whether modes that do not oscillate are pushed too.
    pub(crate) creeping: bool,
}

/// Modes along which is pushed, with what weights.
const MODES: [f64; 2] = [1.0, 0.5];
/// A push has no bound where this factor of a unit eigenvector leaves the rates linear.
const LINEAR: f64 = 1e9;

/// A push along the two least damped modes, in phases drawn at random, so far that the nonlinear part of the rates is `share` of the
/// linear one; none where the equations are as good as linear.
pub(crate) fn push(
    still: &Still<'_>,
    share: f64,
    random: &mut u64,
    mut rates: impl FnMut(&[f64], &mut [f64]),
) -> Option<Push> {
    let n = still.state.len();
    let modes = eigenpairs(n, still.matrix)?;
    let mut modes: Vec<_> = modes
        .into_iter()
        .filter(|(value, _)| still.creeping || value.im > 0.0)
        .collect();
    modes.truncate(MODES.len());
    let leading = modes.first()?.0;
    let mut direction = vec![0.0; n];
    let mut scale = vec![0.0_f64; n];
    for (weight, (_, vector)) in MODES.iter().zip(&modes) {
        let phase = std::f64::consts::TAU * uniform(random);
        for ((entry, size), v) in direction.iter_mut().zip(&mut scale).zip(vector) {
            *entry += weight * (v.re * phase.cos() - v.im * phase.sin());
            *size = size.max(weight * v.norm());
        }
    }
    let mut found = vec![0.0; n];
    let mut nonlinear = |by: f64| {
        let state = along(still.state, &direction, by);
        rates(&state, &mut found);
        let (mut off, mut size) = (0.0, 0.0);
        for (row, rate) in still.matrix.chunks_exact(n).zip(&found) {
            let linear: f64 = row.iter().zip(&direction).map(|(a, d)| by * a * d).sum();
            off += (rate - linear).powi(2);
            size += linear * linear;
        }
        (off / size).sqrt()
    };
    let mut by = 1e-9;
    while nonlinear(by) < share {
        by *= 2.0;
        if by > LINEAR {
            return None;
        }
    }
    by *= 0.5;
    let largest = scale.iter().copied().fold(0.0, f64::max);
    let scale = scale
        .iter()
        .map(|size| by * size.max(1e-9 * largest))
        .collect();
    Some(Push {
        state: along(still.state, &direction, by),
        rest: still.state.to_vec(),
        scale,
        leading,
    })
}

fn along(from: &[f64], direction: &[f64], by: f64) -> Vec<f64> {
    let pairs = from.iter().zip(direction);
    pairs.map(|(x, d)| x + by * d).collect()
}

/// A number in [0, 1) (S. Vigna's splitmix64).
fn uniform(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}
