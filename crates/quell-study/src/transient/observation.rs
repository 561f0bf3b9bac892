//! Numbers taken from a run in time.

use quell_response::transient::{Direction, Record};

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
            } => {
                window(record, Window::Run);
                let found = record.settling(*signal, *target, *band);
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

    /// Why there is no number, in words.
    pub(crate) fn absent(&self) -> &'static str {
        match self {
            Self::Peak(..) => "the signal has fewer peaks than that",
            Self::Trough(..) => "the signal has fewer troughs than that",
            Self::Crossing(..) => "the signal rises through zero less often than that",
            Self::At(..) => "the run ends before that time",
            Self::Settling { .. } => "the signal has not settled when the run ends",
            _ => "the run gave no number",
        }
    }
}
