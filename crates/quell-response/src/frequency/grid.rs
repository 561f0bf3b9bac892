//! The grid of frequencies on which a plan samples its band.

use std::sync::Arc;

use crate::assembly::{Assembly, Attached};
use crate::error::ResponseError;

/// Checks a band and moves a lower edge of zero to 1e-6 of the upper one.
pub(crate) fn checked_band(band: (f64, f64)) -> Result<(f64, f64), ResponseError> {
    let (from, to) = band;
    if !(from.is_finite() && to.is_finite() && from >= 0.0 && to > from) {
        return Err(ResponseError::Band { from, to });
    }
    Ok((from.max(1e-6 * to), to))
}

/// Half linear, half logarithmic, and clusters at the bare host's modes.
pub(super) fn grid(assembly: &Assembly, band: (f64, f64), points: usize) -> Vec<f64> {
    let (low, high) = band;
    let half = points / 2;
    // Below a thousandth of the upper edge most systems are at rest: a few points a decade go there.
    let start = low.max(1e-3 * high);
    let mut omegas = vec![low, high];
    if start > low {
        let below = (3.0 * (start / low).log10()).ceil().max(1.0);
        for i in 1..=below as usize {
            omegas.push(low * (start / low).powf(i as f64 / below));
        }
    }
    for i in 1..half {
        let share = i as f64 / half as f64;
        omegas.push(low + (high - low) * share);
        omegas.push(start * (high / start).powf(share));
    }
    // A host that cannot stand alone has no modes of its own to look at.
    if let Ok(bare) = Assembly::new(Arc::clone(&assembly.host), Vec::<Attached>::new())
        && let Ok(modes) = bare.eigenvalues(&[])
    {
        for mode in modes.iter().filter(|mode| mode.im > 0.0).take(30) {
            let (centre, width) = (mode.im, (-mode.re).max(1e-3 * mode.im));
            for offset in [
                -0.03 * centre,
                -0.01 * centre,
                -width,
                0.0,
                width,
                0.01 * centre,
                0.03 * centre,
            ] {
                omegas.push(centre + offset);
            }
        }
    }
    omegas.retain(|omega| *omega >= low && *omega <= high);
    omegas.sort_by(f64::total_cmp);
    omegas.dedup_by(|b, a| *b - *a <= 1e-6 * *b);
    // Both edges stay exact.
    if let Some(last) = omegas.last_mut() {
        *last = high;
    }
    omegas
}
