//! Inputs as functions of time.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use quell_document::{Fault, Table};
use quell_expression::{Dimension, Quantity};

use super::amounts::Amounts;
use super::random::Random;
use super::samples::Samples;
use super::signal;

/// An input as a function of time, with its exact first and second derivatives.
///
/// A waveform is smooth between its [breakpoints](Self::breakpoints), at which its value or one of its first two
/// derivatives jumps. Integrators restart there, and evaluate every stage of a step on one side: see
/// [`value_beside`](Self::value_beside).
#[derive(Debug, Clone, PartialEq)]
pub enum Waveform {
    /// A sine, or a sweep.
    Harmonic(Harmonic),
    /// A single pulse.
    Pulse(Pulse),
    /// A sum of sines with random phases.
    Random(Random),
    /// Values between which is interpolated.
    Sampled(Samples),
}

impl Waveform {
    /// Reads a `signal` for an input of the given dimension (with none where the host is `dimensionless`); its amounts may
    /// be expressions of `parameters`, its file is looked for in `folder`.
    ///
    /// # Errors
    /// What is wrong with the table or the file that it names, at its place.
    pub fn read(
        table: &Table<'_>,
        dimension: Dimension,
        parameters: &Vec<(String, Quantity)>,
        dimensionless: bool,
        folder: &Path,
    ) -> Result<Self, Fault> {
        let amounts = Amounts {
            parameters,
            dimensionless,
        };
        signal::read(table, dimension, amounts, folder)
    }

    /// The file that a `signal` names, if it names one.
    #[must_use]
    pub fn file(table: &Table<'_>, folder: &Path) -> Option<PathBuf> {
        signal::file_of(table, folder)
    }

    /// Value, first and second derivative at time `t`, s; at a breakpoint those after it.
    #[must_use]
    pub fn value(&self, t: f64) -> [f64; 3] {
        self.value_beside(t, t)
    }

    /// Value, first and second derivative at time `t`, by the law that is in force at the time `inside`.
    ///
    /// With `inside` in the middle of a step from one breakpoint to the next, the end of the step is approached from
    /// the left although the waveform jumps there.
    #[must_use]
    pub fn value_beside(&self, t: f64, inside: f64) -> [f64; 3] {
        match self {
            Self::Harmonic(harmonic) => harmonic.value(t, inside),
            Self::Pulse(pulse) => pulse.value(t, inside),
            Self::Random(random) => random.value(t),
            Self::Sampled(samples) => samples.value(t, inside),
        }
    }

    /// Whether it has one value from one time to another, between two neighbouring breakpoints.
    #[must_use]
    pub fn is_constant(&self, from: f64, to: f64) -> bool {
        match self {
            Self::Harmonic(harmonic) => harmonic.amplitude == 0.0,
            Self::Pulse(pulse) => {
                let inside = 0.5 * (from + to);
                pulse.shape == PulseShape::Rectangular
                    || pulse.amplitude == 0.0
                    || !(pulse.at..pulse.at + pulse.duration).contains(&inside)
            }
            Self::Random(_) | Self::Sampled(_) => false,
        }
    }

    /// The times at which the value or one of its first two derivatives jumps, in order.
    #[must_use]
    pub fn breakpoints(&self) -> Vec<f64> {
        match self {
            Self::Harmonic(harmonic) => harmonic.breakpoints(),
            Self::Pulse(pulse) => pulse.breakpoints(),
            Self::Random(_) => Vec::new(),
            Self::Sampled(samples) => samples.breakpoints(),
        }
    }
}

/// a sin(θ(t) + φ), θ' = ω.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Harmonic {
    /// a, in the unit of the input.
    pub amplitude: f64,
    /// ω, rad/s; with a sweep that at t = 0.
    pub frequency: f64,
    /// φ, rad.
    pub phase: f64,
    /// Where the frequency goes from t = 0.
    pub sweep: Option<Sweep>,
}

/// How the frequency of a sine changes: from t = 0 until `time`; before and after it is constant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sweep {
    /// The last frequency, rad/s.
    pub to: f64,
    /// When it is reached, s.
    pub time: f64,
    /// By the same factor each second, rather than by the same number: both frequencies must be positive.
    pub logarithmic: bool,
}

impl Harmonic {
    fn value(&self, t: f64, inside: f64) -> [f64; 3] {
        let (angle, rate, acceleration) = self.angle(t, inside);
        let (sine, cosine) = (angle + self.phase).sin_cos();
        let a = self.amplitude;
        [
            a * sine,
            a * rate * cosine,
            a * (acceleration * cosine - rate * rate * sine),
        ]
    }

    /// θ, θ' and θ''.
    fn angle(&self, t: f64, inside: f64) -> (f64, f64, f64) {
        let first = self.frequency;
        let Some(sweep) = self.sweep else {
            return (first * t, first, 0.0);
        };
        if inside < 0.0 {
            return (first * t, first, 0.0);
        }
        let during = |t: f64| {
            if sweep.logarithmic {
                // θ' = ω0 r^(t/T), so θ = ω0 (r^(t/T) - 1) T/log r, which is ω0 t where r = 1.
                let rate = (sweep.to / first).ln() / sweep.time;
                let frequency = first * (rate * t).exp();
                let angle = if rate == 0.0 {
                    first * t
                } else {
                    first * (rate * t).exp_m1() / rate
                };
                (angle, frequency, frequency * rate)
            } else {
                let acceleration = (sweep.to - first) / sweep.time;
                (
                    (first + 0.5 * acceleration * t) * t,
                    first + acceleration * t,
                    acceleration,
                )
            }
        };
        if inside < sweep.time {
            during(t)
        } else {
            let (angle, ..) = during(sweep.time);
            (angle + sweep.to * (t - sweep.time), sweep.to, 0.0)
        }
    }

    fn breakpoints(&self) -> Vec<f64> {
        self.sweep
            .map(|sweep| vec![0.0, sweep.time])
            .unwrap_or_default()
    }
}

/// The shape of a pulse of height 1 over 0 < x < 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PulseShape {
    /// sin πx.
    HalfSine,
    /// 1.
    Rectangular,
    /// 2x, then 2 (1 - x).
    Triangular,
}

/// A single pulse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pulse {
    /// Its shape.
    pub shape: PulseShape,
    /// Its peak, in the unit of the input.
    pub amplitude: f64,
    /// How long it lasts, s.
    pub duration: f64,
    /// When it begins, s.
    pub at: f64,
}

impl Pulse {
    fn value(&self, t: f64, inside: f64) -> [f64; 3] {
        if inside < self.at || inside >= self.at + self.duration {
            return [0.0; 3];
        }
        let a = self.amplitude;
        let since = t - self.at;
        match self.shape {
            PulseShape::Rectangular => [a, 0.0, 0.0],
            PulseShape::HalfSine => {
                let omega = PI / self.duration;
                let (sine, cosine) = (omega * since).sin_cos();
                [a * sine, a * omega * cosine, -a * omega * omega * sine]
            }
            PulseShape::Triangular => {
                let slope = 2.0 * a / self.duration;
                if inside < self.at + 0.5 * self.duration {
                    [slope * since, slope, 0.0]
                } else {
                    [slope * (self.duration - since), -slope, 0.0]
                }
            }
        }
    }

    fn breakpoints(&self) -> Vec<f64> {
        let (first, last) = (self.at, self.at + self.duration);
        if self.shape == PulseShape::Triangular {
            vec![first, self.at + 0.5 * self.duration, last]
        } else {
            vec![first, last]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Derivatives against central differences of the value, away from breakpoints: error h² f'''/6 of the first,
    /// rounding 4ε/h² of the second.
    fn check_derivatives(wave: &Waveform, times: &[f64], scale: f64) {
        for &t in times {
            let h = 1e-4;
            let [before, here, after] = [t - h, t, t + h].map(|at| wave.value_beside(at, t)[0]);
            let [value, first, second] = wave.value(t);
            assert_eq!(value, here);
            assert!(
                (first - (after - before) / (2.0 * h)).abs() < 1e-5 * scale,
                "{wave:?} {t}"
            );
            assert!(
                (second - (after - 2.0 * here + before) / (h * h)).abs() < 1e-3 * scale,
                "{wave:?} {t}"
            );
        }
    }

    #[test]
    fn derivatives_of_sines_and_sweeps_are_exact() {
        let mut harmonic = Harmonic {
            amplitude: 2.0,
            frequency: 3.0,
            phase: 0.4,
            sweep: None,
        };
        check_derivatives(&Waveform::Harmonic(harmonic), &[-1.0, 0.0, 2.3], 54.0);
        for logarithmic in [false, true] {
            harmonic.sweep = Some(Sweep {
                to: 9.0,
                time: 4.0,
                logarithmic,
            });
            check_derivatives(
                &Waveform::Harmonic(harmonic),
                &[-0.7, 0.2, 1.9, 3.9, 5.0],
                1500.0,
            );
        }
    }

    /// θ is continuous, θ' goes from one frequency to the other.
    #[test]
    fn sweeps_begin_and_end_at_their_frequencies() {
        for logarithmic in [false, true] {
            let harmonic = Harmonic {
                amplitude: 1.0,
                frequency: 2.0,
                phase: 0.0,
                sweep: Some(Sweep {
                    to: 8.0,
                    time: 5.0,
                    logarithmic,
                }),
            };
            let (angle, rate, _) = harmonic.angle(5.0, 2.0);
            let (later, after, _) = harmonic.angle(5.0, 6.0);
            assert!((angle - later).abs() < 1e-12 && (rate - after).abs() < 1e-12);
            assert!((harmonic.angle(0.0, 1.0).1 - 2.0).abs() < 1e-15);
            // The mean frequency: arithmetic, or (ω1 - ω0)/log(ω1/ω0).
            let mean = if logarithmic { 6.0 / 4.0_f64.ln() } else { 5.0 };
            assert!((angle - 5.0 * mean).abs() < 1e-12);
        }
    }

    #[test]
    fn pulses_have_their_shape_on_both_sides_of_a_jump() {
        let mut pulse = Pulse {
            shape: PulseShape::Rectangular,
            amplitude: 3.0,
            duration: 0.5,
            at: 1.0,
        };
        let wave = Waveform::Pulse(pulse);
        assert_eq!(wave.value(1.0)[0], 3.0);
        assert_eq!(wave.value(1.5)[0], 0.0);
        assert_eq!(wave.value_beside(1.5, 1.2)[0], 3.0);
        assert_eq!(wave.value_beside(1.0, 0.9)[0], 0.0);
        assert_eq!(wave.breakpoints(), [1.0, 1.5]);
        assert!(wave.is_constant(1.0, 1.5) && wave.is_constant(1.5, 9.0));
        pulse.shape = PulseShape::HalfSine;
        let half_sine = Waveform::Pulse(pulse);
        assert!(!half_sine.is_constant(1.0, 1.5) && half_sine.is_constant(0.0, 1.0));
        check_derivatives(&Waveform::Pulse(pulse), &[1.1, 1.3], 800.0);
        assert!((Waveform::Pulse(pulse).value(1.25)[0] - 3.0).abs() < 1e-15);
        pulse.shape = PulseShape::Triangular;
        check_derivatives(&Waveform::Pulse(pulse), &[1.1, 1.3], 800.0);
        assert_eq!(Waveform::Pulse(pulse).value(1.25)[0], 3.0);
    }
}
