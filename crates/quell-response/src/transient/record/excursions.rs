//! Stretches of time in which a signal is beyond a level, and how fast its swings decay.

use super::super::event::Condition;
use super::{Extremum, Record};

/// A stretch of time in which a signal is beyond a level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Excursion {
    /// When it begins, s.
    pub from: f64,
    /// When it ends, s.
    pub to: f64,
    /// Where the signal is farthest beyond the level.
    pub extreme: Extremum,
    /// The window ends while it lasts.
    pub cut: bool,
}

impl Record<'_> {
    /// The n-th largest of the peaks inside the window, counted from 1, whenever it occurs; `None` where there are fewer. The
    /// n-th peak in time is [`peak`](Self::peak).
    pub fn ranked_peak(&mut self, signal: usize, n: usize) -> Option<Extremum> {
        let mut peaks = self.peaks(signal);
        // Of equal ones the earlier comes first: the sort is stable.
        peaks.sort_by(|a, b| b.value.total_cmp(&a.value));
        peaks.get(n.checked_sub(1)?).copied()
    }

    /// The stretches of time in which a condition holds, each with the extreme value that the signal reaches in it.
    pub fn excursions(&mut self, condition: Condition) -> Vec<Excursion> {
        let samples = self.refined(condition.signal);
        let margin = |value: f64| {
            if condition.above {
                value - condition.value
            } else {
                condition.value - value
            }
        };
        let mut found: Vec<Excursion> = Vec::new();
        let mut open: Option<Excursion> = None;
        for (i, &(t, value)) in samples.iter().enumerate() {
            let holds = margin(value) > 0.0;
            if holds != open.is_some() {
                let at = match i.checked_sub(1).and_then(|before| samples.get(before)) {
                    Some(before) => {
                        self.crossing(condition.signal, condition.value, *before, (t, value))
                    }
                    None => t,
                };
                match open.take() {
                    Some(excursion) => found.push(Excursion {
                        to: at,
                        ..excursion
                    }),
                    None => {
                        open = Some(Excursion {
                            from: at,
                            to: at,
                            extreme: Extremum { t, value },
                            cut: false,
                        });
                    }
                }
            }
            if let Some(excursion) = &mut open
                && margin(value) > margin(excursion.extreme.value)
            {
                excursion.extreme = Extremum { t, value };
            }
        }
        if let (Some(excursion), Some(last)) = (open, samples.last()) {
            found.push(Excursion {
                to: last.0,
                cut: true,
                ..excursion
            });
        }
        found
    }

    /// The stretches of time in which |s - target| > band, above and below, in order of time.
    pub fn departures(&mut self, signal: usize, target: f64, band: f64) -> Vec<Excursion> {
        let mut found = self.excursions(Condition::above(signal, target + band));
        found.extend(self.excursions(Condition::below(signal, target - band)));
        found.sort_by(|a, b| a.from.total_cmp(&b.from));
        found
    }

    /// The rate, 1/s, at which the peaks of a positive signal decay: with peaks A_i at times t_i, from the largest of them on, the
    /// negative slope of the straight line that fits ln A_i over t_i best (least squares). Of A exp(-σ t) cos ω t it is σ.
    /// `None` where fewer than two peaks are left, or one is not positive.
    pub fn decay_rate(&mut self, signal: usize) -> Option<f64> {
        let peaks = self.peaks(signal);
        let largest = (0..peaks.len()).fold(None, |best: Option<usize>, i| match best {
            Some(best) if peaks[best].value >= peaks[i].value => Some(best),
            _ => Some(i),
        })?;
        let points: Vec<(f64, f64)> = peaks[largest..]
            .iter()
            .map(|peak| (peak.t, peak.value.ln()))
            .collect();
        if points.len() < 2 || points.iter().any(|point| !point.1.is_finite()) {
            return None;
        }
        let count = points.len() as f64;
        let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
        let (t, y) = (mean(|point| point.0), mean(|point| point.1));
        let (mut along, mut square) = (0.0, 0.0);
        for point in &points {
            along += (point.0 - t) * (point.1 - y);
            square += (point.0 - t).powi(2);
        }
        (square > 0.0).then(|| -along / square)
    }
}
