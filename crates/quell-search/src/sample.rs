//! Random streams and space-filling samples that depend only on seed, key and index.

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// The random stream of one start. Distinct triples give distinct streams: they are the generator's key itself.
pub(crate) fn stream(seed: u64, key: u64, index: usize) -> ChaCha8Rng {
    let mut bytes = [0_u8; 32];
    bytes[..8].copy_from_slice(&seed.to_le_bytes());
    bytes[8..16].copy_from_slice(&key.to_le_bytes());
    bytes[16..24].copy_from_slice(&(index as u64).to_le_bytes());
    ChaCha8Rng::from_seed(bytes)
}

/// Points of the unit cube, row by row: a part of an Owen-scrambled Sobol sequence.
///
/// Source: B. Burley, "Practical hash-based Owen scrambling", JCGT 9 (2020).
pub(crate) fn space_filling(
    scramble: u32,
    random: &mut ChaCha8Rng,
    dimension: usize,
    indices: std::ops::Range<usize>,
) -> Vec<f64> {
    let mut points = Vec::with_capacity(indices.len() * dimension);
    for index in indices {
        for axis in 0..dimension {
            let within = u32::try_from(index).ok().filter(|&i| i < 1 << 16).zip(
                u32::try_from(axis)
                    .ok()
                    .filter(|&a| a < sobol_burley::NUM_DIMENSIONS),
            );
            points.push(match within {
                Some((index, axis)) => f64::from(sobol_burley::sample(index, axis, scramble)),
                // Beyond the sequence's tables plain random numbers serve.
                None => uniform(random),
            });
        }
    }
    points
}

/// A random number in `[0, 1)` with 53 bits.
pub(crate) fn uniform(random: &mut ChaCha8Rng) -> f64 {
    (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}
