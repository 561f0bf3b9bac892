//! Numbers taken from a run in time.

use quell_response::transient::{Condition, Direction, Excursion, Extremum, Record};

/// How the status of a number begins that stands, with something to be known about it.
pub(crate) const COMPUTED_BUT: &str = "computed, but ";

/// How near to its level, relative, a swing grazes it.
const GRAZING: f64 = 0.1;

/// The part of a run that is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Window {
    /// From the start to the end event.
    Run,
    /// From the end event on, as far as the run was continued.
    Beyond,
}

/// A number taken from a run in time; signals are indices.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Observation {
    /// Largest value.
    Maximum(usize, Window),
    /// Smallest value.
    Minimum(usize, Window),
    /// The n-th local maximum.
    Peak(usize, usize),
    /// The n-th local minimum.
    Trough(usize, usize),
    /// The n-th largest local maximum over the whole run.
    Largest(usize, usize),
    /// From the first to the last time above a level.
    Span {
        /// The signal.
        signal: usize,
        /// The level.
        level: f64,
        /// Stretches above the level count where they reach this many times the level; 1 for all.
        graze: f64,
    },
    /// Rate at which the peaks decay, 1/s.
    DecayRate(usize),
    /// Time of the n-th rise through zero.
    Crossing(usize, usize),
    /// Value at the start.
    Initial(usize),
    /// Value at the end event, or at the last time.
    Final(usize),
    /// Value at a time, s.
    At(usize, f64),
    /// Mean over time.
    Mean(usize),
    /// Root of the mean square over time.
    Rms(usize),
    /// ∫ s dt.
    Integral(usize),
    /// ∫ a db.
    Work(usize, usize),
    /// Time after which |s - target| ≤ band until the end.
    Settling {
        /// The signal.
        signal: usize,
        /// Where it settles.
        target: f64,
        /// Half the width of the band.
        band: f64,
        /// Departures from the band count where they reach this many times its half width; 1 for all.
        graze: f64,
    },
    /// Σ ∫ s dt of several signals: powers.
    Energy(Vec<usize>),
    /// What is missing in the energy ledger, over its largest entry.
    EnergyError,
}

impl Observation {
    /// The number, with the time at which it is taken where it is one; not-a-number where there is none.
    ///
    /// `times` are start, end and last time, s.
    pub(crate) fn read(&self, record: &mut Record<'_>, times: [f64; 3]) -> (f64, Option<f64>) {
        let [start, end, last] = times;
        let window = |record: &mut Record<'_>, window: Window| {
            let (from, to) = match window {
                Window::Run => (start, end),
                Window::Beyond => (end, last),
            };
            record.between(Some(from), Some(to));
        };
        let extremum = |found: Option<quell_response::transient::Extremum>| {
            found.map_or((f64::NAN, None), |found| (found.value, Some(found.t)))
        };
        match self {
            Self::Maximum(signal, of) => {
                window(record, *of);
                extremum(Some(record.maximum(*signal)))
            }
            Self::Minimum(signal, of) => {
                window(record, *of);
                extremum(Some(record.minimum(*signal)))
            }
            Self::Peak(signal, n) => {
                window(record, Window::Run);
                extremum(record.peak(*signal, *n))
            }
            Self::Trough(signal, n) => {
                window(record, Window::Run);
                extremum(record.troughs(*signal).into_iter().nth(n.saturating_sub(1)))
            }
            Self::Largest(signal, n) => {
                window(record, Window::Run);
                extremum(record.ranked_peak(*signal, *n))
            }
            Self::Span {
                signal,
                level,
                graze,
            } => {
                window(record, Window::Run);
                let above = counting(
                    record.excursions(Condition::above(*signal, *level)),
                    |top| top >= graze * level,
                );
                match (above.first(), above.last()) {
                    (Some(first), Some(last)) => (last.to - first.from, Some(last.to)),
                    _ => (0.0, None),
                }
            }
            Self::DecayRate(signal) => {
                window(record, Window::Run);
                (record.decay_rate(*signal).unwrap_or(f64::NAN), None)
            }
            Self::Crossing(signal, n) => {
                window(record, Window::Run);
                let crossings = record.crossings(*signal, 0.0, Direction::Rising);
                match crossings.get(n.saturating_sub(1)) {
                    Some(t) => (*t, Some(*t)),
                    None => (f64::NAN, None),
                }
            }
            Self::Initial(signal) => (record.value(*signal, start), Some(start)),
            Self::Final(signal) => (record.value(*signal, end), Some(end)),
            Self::At(signal, t) => {
                if *t > end {
                    return (f64::NAN, None);
                }
                (record.value(*signal, *t), Some(*t))
            }
            Self::Mean(signal) => {
                window(record, Window::Run);
                (record.mean(*signal), None)
            }
            Self::Rms(signal) => {
                window(record, Window::Run);
                (record.rms(*signal), None)
            }
            Self::Integral(signal) => {
                window(record, Window::Run);
                (record.integral(*signal).value, None)
            }
            Self::Work(force, over) => {
                window(record, Window::Run);
                (record.integral_over(*force, *over).value, None)
            }
            Self::Settling {
                signal,
                target,
                band,
                graze,
            } => {
                window(record, Window::Run);
                let found = if *graze > 1.0 {
                    let out = counting(record.departures(*signal, *target, *band), |extreme| {
                        (extreme - target).abs() >= graze * band
                    });
                    match out.last() {
                        Some(last) => (!last.cut).then_some(last.to - start),
                        None => Some(0.0),
                    }
                } else {
                    record.settling(*signal, *target, *band)
                };
                (found.unwrap_or(f64::NAN), found.map(|t| start + t))
            }
            Self::Energy(signals) => {
                window(record, Window::Run);
                let sum = signals
                    .iter()
                    .map(|signal| record.integral(*signal).value)
                    .sum();
                (sum, None)
            }
            Self::EnergyError => (f64::NAN, None),
        }
    }

    /// Whether it looks at what comes after the end event.
    pub(crate) const fn looks_beyond(&self) -> bool {
        matches!(
            self,
            Self::Maximum(_, Window::Beyond) | Self::Minimum(_, Window::Beyond)
        )
    }

    /// What an engineer should know of a number that there is: that a swing nearly touches the level that decides, or that the
    /// run ends before the answer is known.
    ///
    /// Grazing is a stretch beyond the level whose extreme is within [`GRAZING`] of it and that decides the number, or a swing
    /// after it that misses the level by less.
    pub(crate) fn remark(&self, record: &mut Record<'_>, times: [f64; 3]) -> Option<String> {
        let [start, end, _] = times;
        record.between(Some(start), Some(end));
        let (levels, graze): (Vec<(Condition, f64)>, f64) = match *self {
            Self::Span {
                signal,
                level,
                graze,
            } => (vec![(Condition::above(signal, level), level)], graze),
            Self::Settling {
                signal,
                target,
                band,
                graze,
            } => {
                let both = [
                    (Condition::above(signal, target + band), band),
                    (Condition::below(signal, target - band), band),
                ];
                (both.to_vec(), graze)
            }
            _ => return None,
        };
        let mut last: Option<(Excursion, f64)> = None;
        let mut near: Option<(Extremum, f64)> = None;
        for (condition, size) in levels {
            let sign = if condition.above { 1.0 } else { -1.0 };
            // 1 at the level itself.
            let share = |value: f64| 1.0 + sign * (value - condition.value) / size;
            let found = record.excursions(condition);
            for one in counting(found, |extreme| share(extreme) >= graze) {
                if last.is_none_or(|(known, _)| known.to < one.to) {
                    last = Some((one, share(one.extreme.value)));
                }
            }
            let turning = if condition.above {
                record.peaks(condition.signal)
            } else {
                record.troughs(condition.signal)
            };
            for one in turning {
                let share = share(one.value);
                if (graze * (1.0 - GRAZING)..graze).contains(&share)
                    && near.is_none_or(|(known, _)| known.t < one.t)
                {
                    near = Some((one, share));
                }
            }
        }
        let (last, share) = last?;
        if last.cut {
            let seconds = end - start;
            return Some(format!(
                "not settled: the signal is still beyond the level when the run of {seconds} s ends"
            ));
        }
        if share < graze * (1.0 + GRAZING) {
            let t = last.extreme.t;
            return Some(format!(
                "{COMPUTED_BUT}grazing: the last swing that counts, at {t:.4} s, reaches {share:.3} of the level, so a small change of any value may shorten this by whole swings"
            ));
        }
        let (near, share) = near.filter(|(near, _)| near.t > last.to)?;
        Some(format!(
            "{COMPUTED_BUT}grazing: a later swing, at {:.4} s, reaches {share:.3} of the level, so a small change of any value may lengthen this by whole swings",
            near.t
        ))
    }

    /// Why there is no number, in words.
    pub(crate) fn absent(&self) -> &'static str {
        match self {
            Self::Peak(..) | Self::Largest(..) => "the signal has fewer peaks than that",
            Self::Trough(..) => "the signal has fewer troughs than that",
            Self::Crossing(..) => "the signal rises through zero less often than that",
            Self::At(..) => "the run ends before that time",
            Self::DecayRate(_) => {
                "the signal has fewer than two positive peaks from the largest on"
            }
            Self::Settling { .. } => "the signal has not settled when the run ends",
            _ => "the run gave no number",
        }
    }
}

/// The stretches whose extreme counts.
fn counting(mut found: Vec<Excursion>, counts: impl Fn(f64) -> bool) -> Vec<Excursion> {
    found.retain(|one| counts(one.extreme.value));
    found
}
