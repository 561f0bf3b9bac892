//! Extrema and zeros between samples.

use super::super::search::{minimum, root};
use super::{Extremum, Record};

impl Record<'_> {
    pub(super) fn lowest(&mut self, signal: usize, sign: f64) -> Extremum {
        let samples = self.samples(signal);
        let value = |i: usize| sign * samples[i].1;
        let last = samples.len() - 1;
        let best = (0..=last).fold(0, |best, i| if value(i) < value(best) { i } else { best });
        let mut result = (samples[best].0, value(best));
        let lowest = result.1;
        for i in 0..=last {
            let (left, right) = (i.saturating_sub(1), (i + 1).min(last));
            if value(i) > value(left) || value(i) > value(right) {
                continue;
            }
            // The true minimum lies below the sample by less than the samples around it lie above.
            let variation = (value(left) - value(i)).max(value(right) - value(i));
            if value(i) - variation > lowest {
                continue;
            }
            if let Some(found) = self.refine(signal, sign, &samples, i)
                && found.1 < result.1
            {
                result = found;
            }
        }
        Extremum {
            t: result.0,
            value: result.1,
        }
    }

    /// The minimum of sign·s near a lowest sample; none where it is the sample itself, at an end.
    pub(super) fn refine(
        &mut self,
        signal: usize,
        sign: f64,
        samples: &[(f64, f64)],
        i: usize,
    ) -> Option<(f64, f64)> {
        let last = samples.len() - 1;
        let (mut left, mut right) = (samples[i.saturating_sub(1)], samples[(i + 1).min(last)]);
        let mut middle = (samples[i].0, sign * samples[i].1);
        if left.0 >= right.0 {
            return None;
        }
        if left.0 >= middle.0 || middle.0 >= right.0 {
            // At an end (of the window, or of a piece where the signal jumps): does it go down into the interval?
            let inward = if left.0 >= middle.0 { right.0 } else { left.0 };
            let probe = middle.0 + 1e-3 * (inward - middle.0);
            let value = sign * self.at(signal, probe);
            if value >= middle.1 {
                return None;
            }
            (left.0, right.0) = (middle.0.min(inward), middle.0.max(inward));
            middle = (probe, value);
        }
        let (mut t, mut value) = minimum((left.0, right.0), middle, f64::NEG_INFINITY, |t| {
            sign * self.at(signal, t)
        });
        if middle.1 < value {
            (t, value) = middle;
        }
        Some((t, value))
    }

    /// Alternating extremes of the samples with ripples left out; `sign` 1 gives maxima, -1 minima, refined.
    pub(super) fn turning_points(&mut self, signal: usize, sign: f64) -> Vec<Extremum> {
        let samples = self.samples(signal);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for &(_, value) in &samples {
            low = low.min(value);
            high = high.max(value);
        }
        let ripple = 1e-9 * (high - low);
        let value = |i: usize| sign * samples[i].1;
        let mut turning = Vec::new();
        // Going up, `top` is the highest sample since the last low; a fall by more than a ripple makes it a peak.
        let (mut top, mut bottom, mut rising) = (0, 0, None);
        for i in 1..samples.len() {
            if value(i) > value(top) {
                top = i;
            }
            if value(i) < value(bottom) {
                bottom = i;
            }
            if rising != Some(false) && value(top) - value(i) > ripple {
                if rising == Some(true) {
                    turning.push(top);
                }
                rising = Some(false);
                bottom = i;
                top = i;
            } else if rising != Some(true) && value(i) - value(bottom) > ripple {
                rising = Some(true);
                top = i;
                bottom = i;
            }
            if rising == Some(false) {
                top = bottom;
            }
            if rising == Some(true) {
                bottom = top;
            }
        }
        turning
            .into_iter()
            .map(|i| {
                let (t, value) = self
                    .refine(signal, -sign, &samples, i)
                    .unwrap_or((samples[i].0, -sign * samples[i].1));
                Extremum {
                    t,
                    value: -sign * value,
                }
            })
            .collect()
    }

    /// Samples with the refined local extremes among them, so that every sign change of s - level lies between neighbours.
    pub(super) fn refined(&mut self, signal: usize) -> Vec<(f64, f64)> {
        let mut samples = self.samples(signal);
        let mut extremes = self.turning_points(signal, 1.0);
        extremes.extend(self.turning_points(signal, -1.0));
        // Extremes may hide in the first and the last interval too.
        let last = samples.len() - 1;
        for i in [0, last] {
            for sign in [1.0, -1.0] {
                if let Some((t, value)) = self.refine(signal, sign, &samples, i) {
                    extremes.push(Extremum {
                        t,
                        value: sign * value,
                    });
                }
            }
        }
        samples.extend(extremes.iter().map(|extreme| (extreme.t, extreme.value)));
        samples.sort_by(|a, b| a.0.total_cmp(&b.0));
        samples
    }

    pub(super) fn crossing(
        &mut self,
        signal: usize,
        level: f64,
        before: (f64, f64),
        after: (f64, f64),
    ) -> f64 {
        let (a, b) = (before.1 - level, after.1 - level);
        if before.0 >= after.0 || a == 0.0 {
            return before.0;
        }
        if b == 0.0 {
            return after.0;
        }
        root((before.0, a), (after.0, b), 0.0, |t| {
            self.at(signal, t) - level
        })
        .far
    }
}
