//! Stationary random inputs as sums of sines.

use std::f64::consts::TAU;

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// A sample of a stationary Gaussian process (in the limit of many sines):
///
/// u(t) = Σ √(2 S(ω_k) Δω) cos(ω_k t + φ_k), k = 1 … n
///
/// with the one-sided spectral density S, ω_k in the middles of n equal parts Δω of the band, and phases φ_k evenly
/// distributed over 0 … 2π, drawn from ChaCha8 with the seed. Its mean square is Σ S(ω_k) Δω whatever the phases.
///
/// Source: M. Shinozuka and G. Deodatis (1991), Simulation of stochastic processes by spectral representation, Applied
/// Mechanics Reviews 44(4), equation 14, with the one-sided density 2 S₀ of theirs.
#[derive(Debug, Clone, PartialEq)]
pub struct Random {
    /// ω_k, amplitude and φ_k of each sine.
    sines: Vec<[f64; 3]>,
}

impl Random {
    /// A sample with a given seed.
    ///
    /// - `spectrum`: S(ω) ≥ 0, unit² s/rad;
    /// - `band`: its first and last angular frequency, rad/s;
    /// - `count`: n;
    /// - `seed`: another seed gives another sample of the same process.
    #[must_use]
    pub fn new(spectrum: impl Fn(f64) -> f64, band: [f64; 2], count: usize, seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let step = (band[1] - band[0]) / count as f64;
        let sines = (0..count)
            .map(|index| {
                let omega = band[0] + (index as f64 + 0.5) * step;
                // 53 bits: every number a double can hold in 0 … 1 with that spacing.
                let unit = (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
                [omega, (2.0 * spectrum(omega) * step).sqrt(), TAU * unit]
            })
            .collect();
        Self { sines }
    }

    /// Value, first and second derivative.
    pub(super) fn value(&self, t: f64) -> [f64; 3] {
        let mut sums = [0.0; 3];
        for [omega, amplitude, phase] in &self.sines {
            let (sine, cosine) = (omega * t + phase).sin_cos();
            sums[0] += amplitude * cosine;
            sums[1] -= amplitude * omega * sine;
            sums[2] -= amplitude * omega * omega * cosine;
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean square over a whole period is half the sum of the squared amplitudes, which is the integral of the
    /// spectrum: for S = 3 over 2 … 6 rad/s it is 12. A period is sampled well above twice the highest frequency, so
    /// the mean is exact but for rounding.
    #[test]
    fn the_mean_square_is_the_area_under_the_spectrum() {
        let count = 8;
        let random = Random::new(|_| 3.0, [2.0, 6.0], count, 5);
        // All frequencies are odd multiples of Δω/2 = 0.25.
        let period = TAU / 0.25;
        let samples = 1000;
        let mean = (0..samples)
            .map(|index| random.value(period * f64::from(index) / f64::from(samples))[0].powi(2))
            .sum::<f64>()
            / f64::from(samples);
        assert!((mean - 12.0).abs() < 1e-10, "{mean}");
    }

    #[test]
    fn a_seed_gives_the_same_sample_again_and_another_seed_another() {
        let of = |seed| Random::new(|omega| 1.0 / omega, [1.0, 9.0], 50, seed);
        assert_eq!(of(3), of(3));
        assert_ne!(of(3), of(4));
    }

    /// Central differences: error h² ω³/6 times the sum of amplitudes.
    #[test]
    fn derivatives_are_exact() {
        let random = Random::new(|omega| 1.0 / omega, [1.0, 9.0], 50, 1);
        let h = 1e-4;
        let [before, here, after] = [0.7 - h, 0.7, 0.7 + h].map(|t| random.value(t));
        assert!((here[1] - (after[0] - before[0]) / (2.0 * h)).abs() < 1e-4);
        assert!((here[2] - (after[1] - before[1]) / (2.0 * h)).abs() < 1e-3);
    }
}
